//! What a step owes the fluid: force that the grains took and the fluid was not given.
//!
//! ```text
//!   carried = γ r + V A N (G* − G)        handed to s of the next step (R3)                  (K1)
//! ```
//!
//! The first part is the residual of the accepted pass; with it total momentum is exact. The second
//! is 0 where the fluid takes c: one that does not was told the pressure force of A at G* and got G.

use space::{Dim, Dimension, Vector};

use crate::coupled::outcome::Pass;
use crate::coupled::response::Model;
use crate::state::Flow;
use crate::transfer::{Placement, Transfer};

/// The unbalanced force of a staggered step is carried on only below this defect: above it, the
/// carry amplifies.
const CARRY_MAX: f64 = 1e-2;

/// V A N (G* − G) \[N\] of every grain, for a fluid that was not given c.
pub fn lagged_pressure_force<const D: usize, const N: usize>(
    transfer: &Transfer<D, N>,
    placement: &Placement,
    model: &Model<D>,
    reference: &Flow<D>,
    flow: &Flow<D>,
) -> Vec<Vector<D>>
where
    Dim<D>: Dimension<D>,
{
    let pairs = reference.pressure_gradient.iter();
    let pairs = pairs.zip(&flow.pressure_gradient);
    let change: Vec<Vector<D>> = pairs.map(|(old, new)| old - new).collect();
    let mut force = transfer.sample(placement, &change);
    for (i, force) in force.iter_mut().enumerate() {
        *force *= model.volume[i] * model.entrainment(i);
    }
    force
}

/// (K1) \[N\] of every grain.
pub fn carried_force<const D: usize>(
    pass: &Pass<D>,
    drag: &[f64],
    lagged: &[Vector<D>],
) -> Vec<Vector<D>> {
    let share = if pass.defect.relative <= CARRY_MAX {
        1.0
    } else {
        0.0
    };
    let residual = pass.residual.iter().zip(lagged).enumerate();
    residual
        .map(|(i, (r, lagged))| r * (share * drag[i]) + lagged)
        .collect()
}
