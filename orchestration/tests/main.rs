//! Tests of the orchestrator, in one binary.

mod background;
mod browser;
mod commands;
mod kills;
mod leaving_out;
mod pictures;
mod populations;
mod processes;
mod recordings;
mod reports;
mod scene_errors;
mod scenes_folder;
mod stability;
