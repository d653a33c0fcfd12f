//! A run as a set of processes: where it is in shared memory, who takes part, who is lost, how a process
//! enters and leaves, and how long anybody waits. Read `private`, `names`, `lock`, `members`, `strays`, `place`,
//! `leftovers`, `signals`, `open_files`, `liveness`, `runspace`, `process`; `awake` and `limits` for waits;
//! `checkpoints` names what it keeps of itself.

pub mod awake;
pub mod checkpoints;
pub(crate) mod leftovers;
pub mod limits;
pub(crate) mod liveness;
pub(crate) mod lock;
pub(crate) mod members;
pub(crate) mod names;
pub(crate) mod open_files;
pub(crate) mod place;
pub(crate) mod private;
pub mod process;
pub mod runspace;
pub(crate) mod signals;
pub(crate) mod strays;
