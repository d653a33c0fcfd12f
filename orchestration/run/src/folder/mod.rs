//! The folder of a run.
//!
//! `run_folder` takes what the coupler sends, on the thread of `writer`; `steps` is its table,
//! `document` its `run.json` (with `machine` and `recorded`), `draw` what pictures must offer, `lock` that
//! no other run writes there, `claim` that nothing of another origin lies there, `previous` an earlier run,
//! `reserve` keeps room for the last `run.json`.

pub mod claim;
pub mod document;
pub mod draw;
pub mod lock;
pub mod machine;
pub mod previous;
pub mod recorded;
pub mod reserve;
pub mod run_folder;
pub mod steps;
pub mod writer;

pub use document::Ending;
pub use run_folder::RunFolder;
