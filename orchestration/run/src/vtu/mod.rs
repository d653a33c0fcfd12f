//! States for ParaView: `write` makes the files, `read` takes them back, `mesh` is what lies in them.

pub mod mesh;
pub mod read;
pub mod write;
