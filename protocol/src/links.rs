//! The links of a run: who sends which field to whom, and how fields of one exchange are sent and
//! received with validation.

use std::time::Duration;

use crate::channel::{Channel, Received, Wait};
use crate::error::Error;
use crate::field::Field;
use crate::header::{Expected, Stage};
use crate::messages::Role;
use crate::services::End;

/// Coupler → fluid.
pub const TO_FLUID: [Field; 6] = [
    Field::Porosity,
    Field::Drag,
    Field::DragSource,
    Field::EntrainedFraction,
    Field::SolidFlux,
    Field::SolidMobility,
];
/// The mesh, fluid → coupler (and coupler → orchestrator).
pub const MESH: [Field; 4] = [
    Field::NodePosition,
    Field::TriangleNodes,
    Field::TrianglePosition,
    Field::NodalMass,
];
/// A fluid candidate.
pub const FROM_FLUID: [Field; 3] = [
    Field::InterstitialVelocity,
    Field::PressureGradient,
    Field::Pressure,
];
/// Coupler → particles.
pub const TO_PARTICLES: [Field; 2] = [Field::GrainDrag, Field::GrainForce];
/// Grains, both ways with `Configure` and `Ready`.
pub const GRAINS: [Field; 6] = [
    Field::GrainPosition,
    Field::GrainVelocity,
    Field::GrainRadius,
    Field::GrainMass,
    Field::GrainVolume,
    Field::GrainFixed,
];
/// A particle candidate.
pub const FROM_PARTICLES: [Field; 4] = [
    Field::GrainPosition,
    Field::GrainVelocity,
    Field::GrainMeanVelocity,
    Field::GrainContact,
];

const FLUID_SENDS: [Field; 7] = [
    Field::NodePosition,
    Field::TriangleNodes,
    Field::TrianglePosition,
    Field::NodalMass,
    Field::InterstitialVelocity,
    Field::PressureGradient,
    Field::Pressure,
];
const PARTICLES_RECEIVE: [Field; 8] = [
    Field::GrainPosition,
    Field::GrainVelocity,
    Field::GrainRadius,
    Field::GrainMass,
    Field::GrainVolume,
    Field::GrainFixed,
    Field::GrainDrag,
    Field::GrainForce,
];
const PARTICLES_SEND: [Field; 9] = [
    Field::GrainPosition,
    Field::GrainVelocity,
    Field::GrainMeanVelocity,
    Field::GrainRadius,
    Field::GrainMass,
    Field::GrainVolume,
    Field::GrainFixed,
    Field::GrainSpin,
    Field::GrainContact,
];

/// Messages that may wait between coupler and engine: in lock step, `Commit` and one more.
const ENGINE_QUEUE: usize = 4;
/// Steps that the orchestrator may be behind before the coupler waits for it.
const MONITOR_QUEUE: usize = 64;

impl Role {
    /// Name of the seat.
    pub fn seat(self) -> &'static str {
        match self {
            Role::Fluid => "fluid",
            Role::Particles => "particles",
        }
    }

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
            patience: Duration::from_secs(10),
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
        patience: Duration::from_secs(60),
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

/// How many nodes, triangles and grains a link has, and the epoch of both.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub epoch: u64,
    pub nodes: usize,
    pub triangles: usize,
    pub grains: usize,
}

/// Step, pass, stage and time that all fields of one exchange share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub step: u64,
    pub pass: u32,
    pub stage: Stage,
    pub time: f64,
}

impl Moment {
    /// Outside of steps.
    pub(crate) fn at(stage: Stage) -> Moment {
        Moment {
            step: 0,
            pass: 0,
            stage,
            time: 0.0,
        }
    }
}

impl Counts {
    /// What the header of a field must say.
    pub(crate) fn expect(&self, field: Field, moment: Moment) -> Expected {
        use crate::field::Support;
        let entities = match field.support() {
            Support::Node => self.nodes,
            Support::Triangle => self.triangles,
            Support::Grain => self.grains,
        };
        let Moment {
            step,
            pass,
            stage,
            time,
        } = moment;
        Expected {
            field,
            epoch: self.epoch,
            step,
            pass,
            stage,
            entities,
            time,
        }
    }

    /// Send a copy of `values`, whose length must fit.
    pub(crate) fn send(
        &self,
        channel: &mut dyn Channel,
        field: Field,
        moment: Moment,
        values: &[f64],
    ) -> Result<(), Error> {
        let expected = self.expect(field, moment);
        if values.len() != expected.count() {
            let why = format!(
                "{} numbers given, {} expected",
                values.len(),
                expected.count()
            );
            return Err(Error::invalid(
                "sender itself",
                moment.step,
                field.name(),
                why,
            ));
        }
        channel.send_field(field, expected.header(), values)
    }

    /// The next field of this kind, validated.
    pub(crate) fn receive(
        &self,
        channel: &mut dyn Channel,
        field: Field,
        moment: Moment,
        wait: Wait<'_>,
    ) -> Result<Box<dyn Received>, Error> {
        let received = channel.receive_field(field, wait.awaiting(field.name()))?;
        received.header().validate(
            channel.peer(),
            &self.expect(field, moment),
            received.values(),
        )?;
        Ok(received)
    }

    /// The same, as a copy.
    pub(crate) fn receive_copy(
        &self,
        channel: &mut dyn Channel,
        field: Field,
        moment: Moment,
        wait: Wait<'_>,
    ) -> Result<Vec<f64>, Error> {
        Ok(self
            .receive(channel, field, moment, wait)?
            .values()
            .to_vec())
    }
}

/// The grains' fields in the order of [`GRAINS`].
pub fn grain_slices(grains: &crate::engine::InitialGrains) -> [(Field, &[f64]); 6] {
    [
        (Field::GrainPosition, &grains.position),
        (Field::GrainVelocity, &grains.velocity),
        (Field::GrainRadius, &grains.radius),
        (Field::GrainMass, &grains.mass),
        (Field::GrainVolume, &grains.volume),
        (Field::GrainFixed, &grains.fixed),
    ]
}

/// Receive grains and look at what must hold for each of them.
pub(crate) fn receive_grains(
    counts: &Counts,
    channel: &mut dyn Channel,
    stage: Stage,
    wait: Wait<'_>,
) -> Result<crate::engine::InitialGrains, Error> {
    let moment = Moment::at(stage);
    let mut next = |field| counts.receive_copy(channel, field, moment, wait);
    let grains = crate::engine::InitialGrains {
        position: next(Field::GrainPosition)?,
        velocity: next(Field::GrainVelocity)?,
        radius: next(Field::GrainRadius)?,
        mass: next(Field::GrainMass)?,
        volume: next(Field::GrainVolume)?,
        fixed: next(Field::GrainFixed)?,
    };
    let positive = [
        (Field::GrainRadius, &grains.radius),
        (Field::GrainMass, &grains.mass),
        (Field::GrainVolume, &grains.volume),
    ];
    for (field, values) in positive {
        if let Some(grain) = values.iter().position(|&value| value <= 0.0) {
            let why = format!("{} at grain {grain}, must be positive", values[grain]);
            return Err(Error::invalid(channel.peer(), 0, field.name(), why));
        }
    }
    Ok(grains)
}
