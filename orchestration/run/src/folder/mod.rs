//! The folder of a run.
//!
//! `run_folder` takes what the coupler sends, on the thread of `writer`; `steps` is its table,
//! `document` its `run.json` (with `machine` and `recorded`), `draw` what pictures must offer, `fresh` a folder that nobody named, `lock` that
//! no other run writes there, `checkpoint` what it keeps of itself with the `outputs` up to there, `claim` that nothing of another origin lies there, `previous` an earlier run,
//! `reserve` keeps room for the last `run.json`.

pub mod checkpoint;
pub mod claim;
pub mod document;
pub mod draw;
pub mod fresh;
pub mod lock;
pub mod machine;
pub mod outputs;
pub mod previous;
pub mod recorded;
pub mod reserve;
pub mod run_folder;
pub mod steps;
pub mod writer;

pub use document::Ending;
pub use run_folder::RunFolder;
