//! What an engine must do, check by check.
//!
//! | file | what |
//! | --- | --- |
//! | `suite` | all checks in their order |
//! | `exchange` | hello, shapes, finiteness, finish |
//! | `states` | what a second `Advance`, a commit and a checkpoint do to the bits |
//! | `meshes` | a mesh that follows the grains |
//! | `order`, `refusals` | messages and fields that must be refused |
//! | `deaths` | the coupler ends in each state of the engine |

pub mod deaths;
mod exchange;
mod meshes;
mod order;
mod refusals;
mod states;
mod suite;

pub use suite::run;
