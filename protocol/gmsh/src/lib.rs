//! Gmsh files: from bytes to a mesh that can be computed on, or to everything that is wrong with it.
//!
//! Formats 2.2 and 4.1, ASCII and binary. Read in this order:
//!
//! * `cursor`: numbers and words of the bytes; `kind`: which elements there are
//! * [`mod@file`]: what a file says; `read`, `sections`, `legacy`: how it is read, in both formats
//! * [`mesh`]: a mesh of simplices; `build`, `filling`: how it is made
//! * `sides`, `borders`, `topology`: what is the boundary, and what makes a mesh unusable
//! * [`survey`]: groups, sizes, qualities, for people
//!
//! No part of the protocol, like `space`: an engine reads the file that a scene names, and who checks the
//! scene finds the same faults before a process is started.

mod borders;
mod build;
mod cells;
mod cursor;
pub mod error;
pub mod file;
mod filling;
mod kind;
mod legacy;
pub mod mesh;
mod read;
mod sections;
mod sides;
pub mod survey;
mod topology;

pub use error::Error;
pub use file::File;
pub use mesh::{Border, Mesh, Options};
