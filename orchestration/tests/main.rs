//! Tests of the orchestrator, in one binary.

mod background;
mod conform;
mod conform_toy;
mod engines;
mod kills;
mod pictures;
mod populations;
mod processes;
mod scene_errors;
mod scenes_folder;
