//! Runs that are resumed: the same bits as without an interruption, whatever ended them.

mod damage;
mod killed;
pub mod kinds;
pub mod same;
mod words;
