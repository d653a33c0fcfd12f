//! The page of a run.
//!
//! `document` is what it shows, with `states` from the ParaView files as `encode` packs them, fields on a `surface`; `html`
//! puts it into one file, which `report` writes and `view` serves.

mod document;
mod encode;
mod html;
mod report;
mod states;
mod surface;
mod view;

pub use document::STUDY_FILE;
pub use html::{escape, shell};
pub use report::{Written, write};
pub use view::View;
