//! The back end between processes: iceoryx2 in shared memory.

use std::os::fd::BorrowedFd;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{Config, ipc};

use super::descriptor;
use super::ends::End;
use super::services::configuration;
use crate::language::error::Error;
use crate::language::role::Role;
use crate::run::liveness::OnLoss;
use crate::run::runspace::RunSpace;
use crate::run::{names, place};
use crate::transport::channel::Channel;
use crate::transport::link::{Backend, Link};

impl Backend for ipc::Service {
    fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_> {
        descriptor::borrowed(listener)
    }

    fn close_to_others(config: &Config) -> Result<(), Error> {
        place::close_shared(&config.global.prefix.to_string())
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
    let config = configuration(&names::root(runspace.id()), &names::prefix(runspace.id()))?;
    let token = Some(runspace.token()?);
    let membership = Box::new(runspace.clone());
    let link = Link::<ipc::Service>::open(&config, end, board, token, membership)?;
    Ok(Box::new(link))
}
