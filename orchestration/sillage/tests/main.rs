//! Tests of the orchestrator, in one binary.

mod background;
mod browser;
mod browser_in_space;
mod commands;
mod costs;
mod draws;
mod folders;
mod full_disk;
mod instants;
mod kills;
mod leaving;
mod leaving_out;
mod load;
mod meshes;
mod namespaces;
mod processes;
mod recordings;
mod reports;
mod resume;
#[path = "../../show/tests/ring/mod.rs"]
mod ring;
mod schema;
mod stability;
mod states;
mod stops;
mod strays;
mod unread;
mod words;
