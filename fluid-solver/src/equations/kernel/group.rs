//! Groups of consecutive simplices: their geometry, and what the kernels say about them.

use std::f64::consts::PI;

use super::lanes::{LANES, Lanes};
use crate::equations::stabilization::Real;
use crate::mesh::simplices::Mesh;

/// Blocks of the matrix: row corner, column corner, then unknown (column), then equation (row), as
/// the matrix is stored.
pub type GroupMatrix<const N: usize> = [[[[Lanes; N]; N]; N]; N];
/// Right-hand side, corner by corner.
pub type GroupRight<const N: usize> = [[Lanes; N]; N];

/// Corners and geometry of a group; the last group repeats the last simplex.
pub struct Group<const D: usize, const N: usize> {
    /// Nodes, simplex by simplex.
    pub nodes: [[usize; N]; LANES],
    /// ∇N_i
    pub gradient: [[Lanes; D]; N],
    /// Volume.
    pub volume: Lanes,
    /// h
    pub size: Lanes,
}

impl<const D: usize, const N: usize> Group<D, N> {
    /// Group number `g`.
    #[inline(always)]
    pub fn gather(mesh: &Mesh<D, N>, g: usize) -> Group<D, N> {
        let mut group = Group {
            nodes: [[0; N]; LANES],
            gradient: [[Lanes::ZERO; D]; N],
            volume: Lanes::ZERO,
            size: Lanes::ZERO,
        };
        for l in 0..LANES {
            let t = (g * LANES + l).min(mesh.simplices.len() - 1);
            let simplex = &mesh.geometry[t];
            group.nodes[l] = mesh.simplices[t];
            group.volume.0[l] = simplex.volume;
            for i in 0..N {
                for d in 0..D {
                    group.gradient[i][d].0[l] = simplex.gradient[i][d];
                }
            }
        }
        group.size = size::<D>(group.volume);
        group
    }
}

/// Diameter of the balls (disks) of these volumes.
#[inline(always)]
fn size<const D: usize>(volume: Lanes) -> Lanes {
    if D == 2 {
        return (volume * (4.0 / PI)).sqrt();
    }
    let mut size = volume * (6.0 / PI);
    for l in 0..LANES {
        size.0[l] = size.0[l].cbrt();
    }
    size
}
