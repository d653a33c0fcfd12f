//! The fluid engine of Sillage as a process.

fn main() {}
