//! What an advance answers.

use space::{Dim, Dimension, Vector};

use crate::contact::impulses::{Impulses, Pair};
use crate::contact::law::Local;
use crate::contact::residual::Residual;
use crate::grains::State;
use crate::step::request::Label;

/// Numbers of a candidate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Report {
    /// Sub-steps made.
    pub sub_steps: u32,
    /// Active contacts at the end.
    pub contacts: usize,
    /// Most candidate contacts of a sub-step.
    pub candidates: usize,
    /// Sweeps of all solves.
    pub sweeps: usize,
    /// Largest residual of a sub-step.
    pub residual: Residual,
    /// Of a step made in small steps: how far contacts sink before they carry their load, of the smaller radius (M6).
    pub sinking: Option<f64>,
    /// Largest overlap at the end, of the smaller radius.
    pub penetration_max: f64,
    /// Kinetic energy at the end \[J\].
    pub kinetic_energy: f64,
    /// Contact problems solved; more than one a sub-step when margins had to grow.
    pub attempts: usize,
}

/// An active contact at the end of an advance, in small steps one that acted in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveContact<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// The pair, its normal, and its gap at the start of the last sub-step.
    pub pair: Pair<D>,
    /// Impulse over the length of the sub-step, in small steps the mean over the step \[N\].
    pub force: Local<D>,
    /// The same as a vector, on the first \[N\]; in small steps normals turn, and this is the sum that momentum knows.
    pub push: Vector<D>,
}

/// A computed, not yet accepted step.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// What it was computed for.
    pub label: Label,
    /// The state at the end.
    pub state: State<D>,
    /// (xⁿ⁺¹ − xⁿ)/Δt \[m/s\].
    pub mean_velocity: Vec<Vector<D>>,
    /// 0 free, 1 touches, 2 force-connected to a wall or a fixed grain, in any sub-step.
    pub contact: Vec<u8>,
    /// Numbers.
    pub report: Report,
    /// Active contacts of the last sub-step.
    pub active: Vec<ActiveContact<D>>,
    /// Impulses of the first sub-step, where the next pass starts.
    pub(crate) first_impulses: Impulses<D>,
}
