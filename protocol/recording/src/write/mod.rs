//! Writing a recording: [`recorder`] makes the file, hands out taps and ends it; a [`tap`] copies what
//! passes a link into the [`feed`], a queue that never waits; the thread writes it to the [`file`].
//! Read `feed`, `tap`, `file`, `recorder`.

pub(crate) mod feed;
pub(crate) mod file;
pub(crate) mod recorder;
pub(crate) mod tap;
