//! All tests of the coupled system in one binary, a module a subject. Slow ones are ignored with
//! the command that runs them; their tables stand in `docs/verification.md`.

mod bed;
mod beds_in_space;
mod cloud;
mod column;
mod epochs;
mod held;
mod held_in_space;
mod layers_in_space;
mod leaving;
mod lesser;
mod mean_flow;
mod one_grain;
mod packing;
mod replay;
mod settling;
mod settling_in_space;
mod showcase;
mod spheres;
mod walls;
