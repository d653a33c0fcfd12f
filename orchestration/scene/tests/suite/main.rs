//! Tests of scenes, in one binary.

mod bounds;
mod mesh_files;
mod populations;
mod scene_errors;
mod scenes_folder;
mod schema;
mod schema_sweep;
mod sides;
mod validator;
