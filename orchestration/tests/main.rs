//! Tests of the orchestrator, in one binary.

mod background;
mod commands;
mod kills;
mod pictures;
mod populations;
mod processes;
mod recordings;
mod scene_errors;
mod scenes_folder;
