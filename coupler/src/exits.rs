//! Where grains leave: the open sides of the fluid without a wall for grains, and what has left by them.
//!
//! A grain whose centre is outside the mesh at the end of a step is taken out after the commit; within a
//! step it is where its path was inside for the last time. Its volume, momentum and energy are counted,
//!
//! ```text
//!   Σ V + V_out,   Σ m v + p_out,   Σ m (½ v² − g·x) + E_out       do not change when it leaves       (X1)
//! ```
//!
//! and so are those of grains in `steps.csv`. What the last step owes the fluid for it
//! (`coupled/carry.rs`) leaves with it.

use protocol::engine::FacetDescription;
use space::{Dim, Dimension, Period, Vector};

use crate::error::CouplerError;
use crate::seats::door;
use crate::state::Grains;
use crate::transfer::Transfer;

/// What grains leave by; empty: all stay.
#[derive(Debug, Clone, Default)]
pub struct Exits<const D: usize> {
    /// The box around each open side \[m\].
    sides: Vec<[Vector<D>; 2]>,
}

impl<const D: usize> Exits<D>
where
    Dim<D>: Dimension<D>,
{
    /// The boundaries of the fluid with these names. None of an engine that does not tell its boundary:
    /// there a grain that leaves ends the run.
    pub fn new(told: &FacetDescription, names: &[String]) -> Result<Exits<D>, CouplerError> {
        let corners = door::vectors::<D>(&told.position, "facet_position")?;
        let mut sides = Vec::new();
        for (number, boundary) in told.boundaries.iter().enumerate() {
            if !names.contains(&boundary.name) {
                continue;
            }
            let facets = corners.chunks_exact(D).zip(&told.boundary);
            let own = facets.filter(|(_, own)| **own as usize == number);
            let bounds = own.flat_map(|(facet, _)| facet).fold(None, around);
            sides.extend(bounds);
        }
        Ok(Exits { sides })
    }

    /// May grains leave at all?
    pub fn are_there(&self) -> bool {
        !self.sides.is_empty()
    }

    /// Does a straight path end outside, by an open side?
    fn is_way_out<const N: usize>(
        &self,
        transfer: &Transfer<D, N>,
        from: &Vector<D>,
        to: &Vector<D>,
    ) -> bool {
        self.may_cross(from, to, transfer.period()) && transfer.is_outside(to)
    }

    /// Does the box around a path meet that of an open side? Seldom, so that few grains are sought.
    fn may_cross(&self, from: &Vector<D>, to: &Vector<D>, period: &Period<D>) -> bool {
        let (lower, upper) = (from.inf(to), from.sup(to));
        let meets = |[low, high]: &[Vector<D>; 2]| {
            // along a period a path has no place
            (0..D).all(|axis| {
                period[axis].is_some() || lower[axis] <= high[axis] && low[axis] <= upper[axis]
            })
        };
        self.sides.iter().any(meets)
    }

    /// Where a grain is within a step on its way by `by` \[m\].
    pub fn place<const N: usize>(
        &self,
        transfer: &Transfer<D, N>,
        grain: usize,
        start: &Vector<D>,
        by: &Vector<D>,
    ) -> Result<Vector<D>, CouplerError> {
        let end = start + by;
        match self.is_way_out(transfer, start, &end) {
            true => transfer.last_inside(grain, start, by),
            false => Ok(end),
        }
    }

    /// Grains that are outside after a step of length `dt`, in ascending order.
    pub fn left<const N: usize>(
        &self,
        transfer: &Transfer<D, N>,
        grains: &Grains<D>,
        dt: f64,
    ) -> Vec<usize> {
        let leaves = |&grain: &usize| {
            let end = grains.position[grain];
            let start = end - grains.mean_velocity[grain] * dt;
            self.is_way_out(transfer, &start, &end)
        };
        (0..grains.count()).filter(leaves).collect()
    }
}

/// The box around another box and a point.
fn around<const D: usize>(
    bounds: Option<[Vector<D>; 2]>,
    point: &Vector<D>,
) -> Option<[Vector<D>; 2]> {
    let [low, high] = bounds.unwrap_or([*point, *point]);
    Some([low.inf(point), high.sup(point)])
}
