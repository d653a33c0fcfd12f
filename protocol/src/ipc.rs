//! The back end between processes: iceoryx2 in shared memory.

use std::os::fd::RawFd;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{FileDescriptorBased, ipc};

use crate::channel::Channel;
use crate::error::Error;
use crate::iox::{Backend, Link};
use crate::liveness::OnLoss;
use crate::messages::Role;
use crate::runspace::{self, RunSpace};
use crate::services::{End, configuration};

impl Backend for ipc::Service {
    fn descriptor(listener: &Listener<Self>) -> RawFd {
        // SAFETY: only handed to `poll`; the listener keeps owning it.
        unsafe { listener.file_descriptor().native_handle() }
    }
}

/// The engine's end of its link to the coupler, for [`crate::engine::serve_fluid`] and
/// [`crate::engine::serve_particles`].
pub fn engine_link(runspace: &RunSpace, role: Role) -> Result<Box<dyn Channel>, Error> {
    open(runspace, role.engine_end())
}

/// The coupler's end of its link to an engine; [`crate::partner::Partner`] is what a coupler uses.
pub fn coupler_link(runspace: &RunSpace, role: Role) -> Result<Box<dyn Channel>, Error> {
    open(runspace, role.coupler_end())
}

/// Take the seat of this end, watch the partners, open the link.
pub(crate) fn open(runspace: &RunSpace, end: End) -> Result<Box<dyn Channel>, Error> {
    runspace.take_seat(end.me)?;
    let board = runspace.watch(OnLoss::Report)?;
    let config = configuration(
        &runspace::root(runspace.id()),
        &runspace::prefix(runspace.id()),
    )?;
    let link = Link::<ipc::Service>::open(&config, end, board, Box::new(runspace.clone()))?;
    Ok(Box::new(link))
}
