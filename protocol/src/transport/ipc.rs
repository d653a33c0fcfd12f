//! The back end between processes: iceoryx2 in shared memory.

use std::os::fd::RawFd;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{FileDescriptorBased, ipc};

use super::ends::End;
use super::services::configuration;
use crate::language::error::Error;
use crate::language::role::Role;
use crate::run::liveness::OnLoss;
use crate::run::place;
use crate::run::runspace::RunSpace;
use crate::transport::channel::Channel;
use crate::transport::link::{Backend, Link};

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

/// The coupler's end of its link to an engine; [`crate::coupler::partner::Partner`] is what a coupler uses.
pub fn coupler_link(runspace: &RunSpace, role: Role) -> Result<Box<dyn Channel>, Error> {
    open(runspace, role.coupler_end())
}

/// Take the seat of this end, watch the partners, open the link.
pub(crate) fn open(runspace: &RunSpace, end: End) -> Result<Box<dyn Channel>, Error> {
    runspace.take_seat(end.me)?;
    let board = runspace.watch(OnLoss::Report)?;
    let config = configuration(&place::root(runspace.id()), &place::prefix(runspace.id()))?;
    let link = Link::<ipc::Service>::open(&config, end, board, Box::new(runspace.clone()))?;
    Ok(Box::new(link))
}
