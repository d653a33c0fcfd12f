//! Files that Gmsh writes are read, and what cannot be computed on is refused with its number.

mod faults;
mod reads;
