//! Tests of the orchestrator, in one binary.

mod pictures;
mod populations;
mod processes;
mod scene_errors;
mod scenes_folder;
