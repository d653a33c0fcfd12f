//! The contract, tested over both back ends and with broken partners.

mod codec;
mod exchange;
mod faults;
mod fields;
mod header;
mod limits;
mod monitor;
mod private;
mod processes;
mod runspaces;
mod toy;
