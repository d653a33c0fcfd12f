//! The ends of the links of a run: who sends which field to whom, and how long a queue may be.

use std::time::Duration;

use crate::language::field::{Exchange, Field, TO_FLUID, count, sent_in};
use crate::language::role::Role;
use crate::run::limits;
use crate::run::liveness::Board;

/// What distinguishes one end of one link.
#[derive(Debug, Clone)]
pub(crate) struct End {
    /// Name of the link: first part of its service names.
    pub link: &'static str,
    /// This end's name.
    pub me: &'static str,
    /// The other end's name.
    pub peer: &'static str,
    /// Fields this end sends.
    pub sends: &'static [Field],
    /// Fields this end receives.
    pub receives: &'static [Field],
    /// Messages that may wait in a queue.
    pub queue: usize,
    /// How long a full queue is tolerated.
    pub patience: Duration,
    /// Does the loss of a third process end a wait for the peer?
    pub heeds_others: bool,
}

impl End {
    /// A process whose absence makes waiting for the peer pointless.
    pub(crate) fn missing(&self, board: &Board) -> Option<String> {
        if self.heeds_others {
            return board.missing(self.peer);
        }
        board.is_gone(self.peer).then(|| self.peer.to_owned())
    }
}

const BY_FLUID: &[Exchange] = &[Exchange::Mesh, Exchange::Boundary, Exchange::FromFluid];
const FOR_PARTICLES: &[Exchange] = &[Exchange::Grains, Exchange::ToParticles];
const BY_PARTICLES: &[Exchange] = &[
    Exchange::Grains,
    Exchange::FromParticles,
    Exchange::MaybeFromParticles,
];

const FLUID_SENDS: [Field; count(BY_FLUID)] = sent_in(BY_FLUID);
const PARTICLES_RECEIVE: [Field; count(FOR_PARTICLES)] = sent_in(FOR_PARTICLES);
const PARTICLES_SEND: [Field; count(BY_PARTICLES)] = sent_in(BY_PARTICLES);

/// Messages that may wait between coupler and engine: in lock step, `Commit` and one more.
const ENGINE_QUEUE: usize = 4;

/// Steps that the orchestrator may be behind before the coupler waits for it.
const MONITOR_QUEUE: usize = 64;

impl Role {
    /// The coupler's end of the link to this engine.
    pub(crate) fn coupler_end(self) -> End {
        let engine = self.engine_end();
        End {
            me: engine.peer,
            peer: engine.me,
            sends: engine.receives,
            receives: engine.sends,
            ..engine
        }
    }

    /// The engine's end.
    pub(crate) fn engine_end(self) -> End {
        let (sends, receives): (&'static [Field], &'static [Field]) = match self {
            Role::Fluid => (&FLUID_SENDS, &TO_FLUID),
            Role::Particles => (&PARTICLES_SEND, &PARTICLES_RECEIVE),
        };
        End {
            link: self.seat(),
            me: self.seat(),
            peer: "coupler",
            sends,
            receives,
            queue: ENGINE_QUEUE,
            patience: limits::QUEUE.duration(),
            heeds_others: true,
        }
    }
}

/// The coupler's end of the link to the orchestrator.
pub(crate) fn monitor_sender_end() -> End {
    End {
        link: "monitor",
        me: "coupler",
        peer: "orchestrator",
        sends: &Field::ALL,
        receives: &[],
        queue: MONITOR_QUEUE,
        // Longer than the orchestrator waits for a full disk.
        patience: limits::TAKE_OVER.duration(),
        // A loss must still be reported, and read.
        heeds_others: false,
    }
}

/// The orchestrator's end.
pub(crate) fn monitor_receiver_end() -> End {
    let sender = monitor_sender_end();
    End {
        me: sender.peer,
        peer: sender.me,
        sends: &[],
        receives: sender.sends,
        ..sender
    }
}
