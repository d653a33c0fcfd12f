//! Tests of the orchestrator, in one binary.

mod pictures;
mod populations;
mod scene_errors;
mod scenes_folder;
