//! A run as a set of processes: where it is in shared memory, who takes part, who is lost, how a process
//! enters and leaves. Read `place`, `members`, `signals`, `liveness`, `runspace`, `process`.

pub(crate) mod liveness;
pub(crate) mod members;
pub(crate) mod place;
pub mod process;
pub mod runspace;
pub(crate) mod signals;
