//! Pictures of a run that goes on, as this crate sees them: it draws none itself.

use std::path::Path;

use protocol::monitor::Event;
use scene::{Error, Scene};

use crate::disk::Disk;

/// Sees every message of the coupler, on the thread that writes the folder.
pub trait Draw: Send {
    /// Draw what there is to draw of a message.
    fn take(&mut self, event: &Event, disk: &Disk) -> Result<(), Error>;

    /// What is needed to go on from here.
    fn keep(&self) -> String;

    /// Go on from what was kept, and forget what was drawn after it; before any message.
    fn resume(&mut self, kept: &str) -> Result<(), Error>;

    /// The run is over.
    fn finish(&mut self, disk: &Disk) -> Result<(), Error>;
}

/// What draws a scene into its run folder.
pub type Pictures = fn(&Scene, &Path) -> Box<dyn Draw>;
