//! The command line, as clap reads it: `command` lists the commands, the others their arguments.

pub mod command;
pub mod engines;
mod help;
pub mod pages;
pub mod recordings;
pub mod scenes;
mod seat;
mod threads;
