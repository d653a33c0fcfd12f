//! What lies behind each facet of a simplex: another one, or nothing.

use std::collections::BTreeMap;

use space::{Dim, Dimension, Period, Vector, periodic, simplex};

use crate::transfer::locate::Locator;

/// Two facets with the same nodes are one where their centres are this close, of their size.
const SAME_PLACE: f64 = 1e-6;

/// What lies behind a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Behind<const D: usize> {
    /// The other simplex.
    pub simplex: u32,
    /// From coordinates of this one to those of the other \[m\]: whole periods.
    pub shift: Vector<D>,
}

/// No simplex.
const NONE: u32 = u32::MAX;
/// Bit of a simplex that lies across a period.
const SHIFTED: u32 = 1 << 31;

/// Simplices across each facet.
#[derive(Debug)]
pub struct Neighbours<const D: usize, const N: usize> {
    /// Behind facet k, opposite to corner k; with `SHIFTED` where a period lies between. `NONE`: the boundary.
    behind: Vec<[u32; N]>,
    /// Shifts of those, by simplex and facet.
    shifts: BTreeMap<(u32, usize), Vector<D>>,
}

/// A facet of one simplex, as it is matched.
struct Facet<const D: usize> {
    nodes: [u32; D],
    simplex: u32,
    opposite: usize,
    centre: Vector<D>,
    size: f64,
}

impl<const D: usize, const N: usize> Neighbours<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Match the facets of a mesh. Where a mesh is so narrow that a period brings two facets with the
    /// same nodes, their places decide.
    pub fn new(mesh: &Locator<D, N>) -> Neighbours<D, N> {
        let count = mesh.simplices().len();
        let mut facets: Vec<Facet<D>> = (0..count)
            .flat_map(|index| (0..N).map(move |opposite| facet(mesh, index, opposite)))
            .collect();
        facets.sort_by_key(|facet| (facet.nodes, facet.simplex, facet.opposite));
        let mut behind = vec![[NONE; N]; count];
        let mut shifts = BTreeMap::new();
        for alike in facets.chunk_by(|a, b| a.nodes == b.nodes) {
            for (place, a) in alike.iter().enumerate() {
                for b in &alike[place + 1..] {
                    let Some(shift) = shift(a, b, mesh.period()) else {
                        continue;
                    };
                    let mut join = |from: &Facet<D>, to: &Facet<D>, shift: Vector<D>| {
                        let slot = &mut behind[from.simplex as usize][from.opposite];
                        *slot = to.simplex;
                        if shift != Vector::<D>::zeros() {
                            *slot |= SHIFTED;
                            shifts.insert((from.simplex, from.opposite), shift);
                        }
                    };
                    join(a, b, shift);
                    join(b, a, -shift);
                }
            }
        }
        Neighbours { behind, shifts }
    }

    /// What lies behind the facet opposite to this corner; none: the boundary.
    #[inline]
    pub fn behind(&self, simplex: u32, opposite: usize) -> Option<Behind<D>> {
        let behind = self.behind[simplex as usize][opposite];
        if behind == NONE {
            return None;
        }
        let shift = match behind & SHIFTED {
            0 => Vector::zeros(),
            _ => self.shifts[&(simplex, opposite)],
        };
        Some(Behind {
            simplex: behind & !SHIFTED,
            shift,
        })
    }
}

fn facet<const D: usize, const N: usize>(
    mesh: &Locator<D, N>,
    index: usize,
    opposite: usize,
) -> Facet<D>
where
    Dim<D>: Dimension<D>,
{
    let corners = simplex::facet_corners::<D>(opposite);
    let mut nodes = corners.map(|corner| mesh.simplices()[index][corner]);
    nodes.sort_unstable();
    let places = corners.map(|corner| mesh.corners()[index][corner]);
    let centre = places.iter().fold(Vector::zeros(), |sum, x| sum + x) / D as f64;
    Facet {
        nodes,
        simplex: index as u32,
        opposite,
        centre,
        size: (places[0] - centre).amax(),
    }
}

/// Whole periods from one facet to the other; none where they are two places.
fn shift<const D: usize>(a: &Facet<D>, b: &Facet<D>, period: &Period<D>) -> Option<Vector<D>> {
    let apart = b.centre - a.centre;
    let rest = periodic::shortest_image(apart, period);
    let whole = apart - rest;
    let near = rest.amax() <= SAME_PLACE * a.size;
    near.then(|| {
        whole.map(|x| {
            if x.abs() <= SAME_PLACE * a.size {
                0.0
            } else {
                x
            }
        })
    })
}
