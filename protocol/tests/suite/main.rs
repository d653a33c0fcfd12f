//! The contract, tested over both back ends and with broken partners.

mod codec;
mod exchange;
mod faults;
mod fields;
mod header;
mod monitor;
mod processes;
mod runspaces;
mod toy;
