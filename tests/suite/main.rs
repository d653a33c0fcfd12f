//! All tests of the coupled system in one binary, a module a subject. Slow ones are ignored with
//! the command that runs them; their tables stand in `docs/verification.md`.

mod bed;
mod cloud;
mod column;
mod epochs;
mod held;
mod leaving;
mod lesser;
mod mean_flow;
mod one_grain;
mod packing;
mod replay;
mod settling;
mod showcase;
mod spheres;
mod walls;
