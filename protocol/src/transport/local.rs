//! The back end between threads, for tests: the same loop, messages and buffers, on the heap.

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::local;

use super::descriptor;
use super::ends::End;
use super::services::configuration;
use crate::coupler::partner::Partner;
use crate::language::engine::{FluidEngine, ParticleEngine, serve_fluid, serve_particles};
use crate::language::error::Error;
use crate::language::role::Role;
use crate::language::scene::Limits;
use crate::run::liveness::Board;
use crate::run::names;
use crate::transport::channel::Channel;
use crate::transport::link::{Backend, Link};

/// Limits of links to engines on threads \[s\].
pub const LIMITS: Limits = Limits {
    connect: 30.0,
    configure: 600.0,
    step: 3600.0,
};

impl Backend for local::Service {
    fn descriptor(listener: &Listener<Self>) -> BorrowedFd<'_> {
        descriptor::borrowed(listener)
    }
}

/// Tells the other end that this end is closed.
struct Membership {
    me: &'static str,
    other: Arc<Board>,
}

impl Drop for Membership {
    fn drop(&mut self) {
        self.other.mark_left(self.me);
    }
}

/// Run a fluid engine on a thread; `make` is called on that thread.
pub fn spawn_fluid<E: FluidEngine + 'static>(
    make: impl FnOnce() -> E + Send + 'static,
) -> Result<Partner, Error> {
    spawn(Role::Fluid, move |link| serve_fluid(&mut make(), link))
}

/// Run a particle engine on a thread; `make` is called on that thread.
pub fn spawn_particles<E: ParticleEngine + 'static>(
    make: impl FnOnce() -> E + Send + 'static,
) -> Result<Partner, Error> {
    spawn(Role::Particles, move |link| {
        serve_particles(&mut make(), link)
    })
}

/// Run anything that speaks for an engine on a thread (also one that breaks the rules, for tests).
pub fn spawn(
    role: Role,
    serve: impl FnOnce(Box<dyn Channel>) -> Result<(), Error> + Send + 'static,
) -> Result<Partner, Error> {
    spawn_with(role, &LIMITS, serve)
}

/// The same with other limits.
pub fn spawn_with(
    role: Role,
    limits: &Limits,
    serve: impl FnOnce(Box<dyn Channel>) -> Result<(), Error> + Send + 'static,
) -> Result<Partner, Error> {
    Partner::greet(role, connect(role, serve)?, limits)
}

/// The same without the greeting: the coupler's end of the link, for a recorder to tap.
pub fn connect(
    role: Role,
    serve: impl FnOnce(Box<dyn Channel>) -> Result<(), Error> + Send + 'static,
) -> Result<Box<dyn Channel>, Error> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let id = format!(
        "local{}x{}",
        std::process::id(),
        COUNT.fetch_add(1, Ordering::Relaxed)
    );
    let (coupler, engine) = (Arc::new(Board::new()?), Arc::new(Board::new()?));
    let end = role.engine_end();
    let there = Membership {
        me: end.me,
        other: Arc::clone(&coupler),
    };
    let here = Membership {
        me: end.peer,
        other: Arc::clone(&engine),
    };
    let link = open(&id, role.coupler_end(), coupler, here)?;
    let run = move || {
        let served = open(&id, end, engine, there).and_then(serve);
        if let Err(error) = served {
            tracing::warn!("engine thread: {error}");
        }
    };
    std::thread::Builder::new()
        .name(role.seat().to_owned())
        .spawn(run)
        .map_err(|e| Error::transport("engine thread", e))?;
    Ok(link)
}

fn open(
    id: &str,
    end: End,
    board: Arc<Board>,
    membership: Membership,
) -> Result<Box<dyn Channel>, Error> {
    let config = configuration(&names::root(id), &names::prefix(id))?;
    Ok(Box::new(Link::<local::Service>::open(
        &config,
        end,
        board,
        None,
        Box::new(membership),
    )?))
}
