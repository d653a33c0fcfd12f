//! What an engine tells about a candidate, typed: the coupler goes by these numbers, so none has a name
//! that can be misspelt, and one that every engine owes cannot be left out.

use std::num::NonZeroU32;

use serde::{Deserialize, Serialize};

/// The report of a candidate; that of the engine's seat.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// Of a fluid engine.
    Fluid(FluidReport),
    /// Of a particle engine.
    Particles(ParticleReport),
}

/// What a fluid engine tells; it owes nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct FluidReport {
    /// Power of the solid's terms as the equations had them \[W\] (in the plane W/m): the coupler's
    /// energy balance compares it with its own.
    pub solid_power: Option<f64>,
    /// Reynolds number by which the engine judges whether convection matters.
    pub reynolds: Option<f64>,
    /// Was v·∇v in the equations?
    pub convects: Option<bool>,
}

/// What a particle engine tells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ParticleReport {
    /// Sub-steps that it took: the solid's response that the fluid is told is a mean over them.
    pub sub_steps: NonZeroU32,
    /// Contacts that carry an impulse.
    pub touching: Option<u64>,
}

impl ParticleReport {
    /// Of a candidate in this many sub-steps, without more to tell; none for 0 sub-steps.
    pub fn new(sub_steps: u32) -> Option<ParticleReport> {
        Some(ParticleReport {
            sub_steps: NonZeroU32::new(sub_steps)?,
            touching: None,
        })
    }

    /// Of a candidate in one step.
    pub fn one_step() -> ParticleReport {
        ParticleReport {
            sub_steps: NonZeroU32::MIN,
            touching: None,
        }
    }
}

impl Report {
    /// Its first number that is not finite, with its name.
    pub fn not_finite(&self) -> Option<(&'static str, f64)> {
        let Report::Fluid(report) = self else {
            return None;
        };
        let numbers = [
            ("solid_power", report.solid_power),
            ("reynolds", report.reynolds),
        ];
        let mut told = numbers
            .iter()
            .filter_map(|&(name, value)| Some((name, value?)));
        told.find(|(_, value)| !value.is_finite())
    }
}
