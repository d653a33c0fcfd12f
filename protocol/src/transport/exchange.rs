//! How the fields of one exchange are sent and received, with validation.

use crate::language::engine::told::InitialGrains;
use crate::language::error::Error;
use crate::language::field::{Field, Support};
use crate::language::header::{Expected, Stage};
use crate::transport::channel::{Channel, Received, Wait};

/// How many nodes, simplices, facets and grains a link has, in which dimension, and the epoch of both.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub epoch: u64,
    pub dimension: usize,
    pub nodes: usize,
    pub simplices: usize,
    pub grains: usize,
    pub facets: usize,
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
        let entities = match field.support() {
            Support::Node => self.nodes,
            Support::Simplex => self.simplices,
            Support::Grain => self.grains,
            Support::Facet => self.facets,
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
            dimension: self.dimension,
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

/// Receive grains and look at what must hold for each of them.
pub(crate) fn receive_grains(
    counts: &Counts,
    channel: &mut dyn Channel,
    stage: Stage,
    wait: Wait<'_>,
) -> Result<InitialGrains, Error> {
    let moment = Moment::at(stage);
    let mut next = |field| counts.receive_copy(channel, field, moment, wait);
    let grains = InitialGrains {
        dimension: counts.dimension,
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
