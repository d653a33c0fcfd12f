//! The system of the equations: element by element, and turned where the unknowns of a node are.
//!
//! Elements are computed in groups, most by the `kernel`, and added in their order: same input, same bits on any
//! number of threads.

use rayon::prelude::*;
use space::{Dim, Dimension};

use super::coefficients::{Coefficients, ViscousForm};
use super::continuity;
use super::element::Element;
use super::kernel::{GroupMatrix, GroupRight, Kernel, LANES, Lanes};
use super::momentum::{self, Matrix, RightSide};
use super::open;
use crate::boundary::constraints::Constraints;
use crate::boundary::frame::Frame;
use crate::linear::system::System;
use crate::mesh::simplices::Mesh;

/// Groups that are computed, on all threads, while those before them are added: few enough for the cache of a
/// core, and on several threads enough to be worth sharing.
const BATCH: usize = 8;
const BATCH_SHARED: usize = 96;

/// The equations on a mesh with its conditions.
pub struct Assembly<'a, const D: usize, const N: usize> {
    /// What the equations are told.
    pub terms: &'a Coefficients<'a, D>,
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Its conditions.
    pub constraints: &'a Constraints<D>,
    /// ∮ N_i Q_n by node.
    pub flux: &'a [f64],
}

impl<const D: usize, const N: usize> Assembly<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Fill a system; its matrix is left as it is when `matrix_too` is false.
    pub fn fill(&self, system: &mut System<N>, matrix_too: bool) {
        if matrix_too {
            system.matrix.fill([[0.0; N]; N]);
        }
        system.right.fill(0.0);
        let kernel = Kernel::new(self.terms, self.mesh);
        let groups = self.mesh.simplices.len().div_ceil(LANES);
        let batch = match rayon::current_num_threads() {
            1 => BATCH,
            _ => BATCH_SHARED,
        };
        let mut done = vec![Slot::empty(); batch.min(groups)];
        let mut next = done.clone();
        self.compute(kernel.as_ref(), 0, &mut done, matrix_too);
        for first in (0..groups).step_by(batch) {
            let filled = &done[..batch.min(groups - first)];
            rayon::join(
                || self.add(system, first, filled, matrix_too),
                || self.compute(kernel.as_ref(), first + batch, &mut next, matrix_too),
            );
            std::mem::swap(&mut done, &mut next);
        }
        if matrix_too {
            self.add_open_facets(system);
        }
        for (node, flux) in self.flux.iter().enumerate() {
            system.right[N * node + D] -= flux;
        }
    }

    /// The groups from `first` on, as many as there are slots or groups.
    fn compute(
        &self,
        kernel: Option<&Kernel<'_, D, N>>,
        first: usize,
        slots: &mut [Slot<N>],
        matrix_too: bool,
    ) {
        let groups = self.mesh.simplices.len().div_ceil(LANES);
        let left = groups.saturating_sub(first);
        let slots = slots.par_iter_mut().take(left).enumerate();
        slots.for_each(|(k, slot)| {
            let simplices = self.simplices_of(first + k);
            let straight = simplices
                .iter()
                .flatten()
                .all(|&node| self.constraints.frames[node].is_none());
            match kernel {
                Some(kernel) if straight => {
                    kernel.compute(first + k, matrix_too, &mut slot.matrix, &mut slot.right);
                }
                _ => {
                    for l in 0..simplices.len() {
                        let (matrix, right) = self.element((first + k) * LANES + l, matrix_too);
                        slot.set(l, &matrix, &right);
                    }
                }
            }
        });
    }

    /// Add the groups from `first` on.
    fn add(&self, system: &mut System<N>, first: usize, slots: &[Slot<N>], matrix_too: bool) {
        for (k, slot) in slots.iter().enumerate() {
            for (l, nodes) in self.simplices_of(first + k).iter().enumerate() {
                system.add_right(
                    nodes,
                    &slot.right.map(|values| values.map(|value| value.0[l])),
                );
                if matrix_too {
                    slot.add_matrix(system, (first + k) * LANES + l, l);
                }
            }
        }
    }

    /// The corners of a group.
    fn simplices_of(&self, group: usize) -> &[[usize; N]] {
        let simplices = &self.mesh.simplices;
        &simplices[group * LANES..simplices.len().min((group + 1) * LANES)]
    }

    /// Matrix (zero unless wanted) and right-hand side of simplex `t`.
    fn element(&self, t: usize, matrix_too: bool) -> (Matrix<N>, RightSide<N>) {
        let element = Element::gather(self.terms, self.mesh, t);
        let (mut matrix, mut right) = ([[[[0.0; N]; N]; N]; N], [[0.0; N]; N]);
        for at in element.points() {
            momentum::add_right_side(&at, &mut right);
            continuity::add_right_side(&at, &mut right);
            if matrix_too {
                momentum::add_matrix(&at, &mut matrix);
                continuity::add_matrix(&at, &mut matrix);
            }
        }
        let nodes = &self.mesh.simplices[t];
        turn(&self.constraints.frames, nodes, &mut matrix, &mut right);
        (matrix, right)
    }

    fn add_open_facets(&self, system: &mut System<N>) {
        for facet in &self.constraints.open_facets {
            let element = Element::gather(self.terms, self.mesh, facet.simplex);
            let mut matrix = [[[[0.0; N]; N]; N]; N];
            let straight = self.terms.viscous_form == ViscousForm::Symmetric;
            let flows_in = open::flows_in(&element, facet);
            if !straight && !flows_in {
                continue;
            }
            if straight {
                open::add_traction(&element, facet, &mut matrix);
            }
            if flows_in {
                open::add_inflow(&element, facet, &mut matrix);
            }
            let nodes = &self.mesh.simplices[facet.simplex];
            let frames = &self.constraints.frames;
            turn(frames, nodes, &mut matrix, &mut [[0.0; N]; N]);
            system.add_matrix(facet.simplex, &matrix);
        }
    }
}

/// What a group adds.
#[derive(Clone)]
struct Slot<const N: usize> {
    matrix: GroupMatrix<N>,
    right: GroupRight<N>,
}

impl<const N: usize> Slot<N> {
    fn empty() -> Slot<N> {
        Slot {
            matrix: [[[[Lanes::ZERO; N]; N]; N]; N],
            right: [[Lanes::ZERO; N]; N],
        }
    }

    /// Add the blocks of simplex `l` of the group, simplex `t` of the mesh.
    #[inline]
    fn add_matrix(&self, system: &mut System<N>, t: usize, l: usize) {
        for i in 0..N {
            for j in 0..N {
                let columns = &self.matrix[i][j];
                let lane = std::array::from_fn(|f| std::array::from_fn(|d| columns[f][d].0[l]));
                system.add_block(t, i, j, &lane);
            }
        }
    }

    /// What simplex `l` of the group adds.
    fn set(&mut self, l: usize, matrix: &Matrix<N>, right: &RightSide<N>) {
        for i in 0..N {
            for q in 0..N {
                self.right[i][q].0[l] = right[i][q];
            }
            for j in 0..N {
                for f in 0..N {
                    for d in 0..N {
                        self.matrix[i][j][f][d].0[l] = matrix[i][j][d][f];
                    }
                }
            }
        }
    }
}

/// Turn the velocity unknowns and equations of nodes on oblique slip walls into their frames.
fn turn<const D: usize, const N: usize>(
    frames: &[Option<Frame<D>>],
    nodes: &[usize; N],
    matrix: &mut Matrix<N>,
    right: &mut RightSide<N>,
) {
    for (k, &node) in nodes.iter().enumerate() {
        let Some(frame) = &frames[node] else { continue };
        frame.turn(&mut right[k]);
        for block in &mut matrix[k] {
            let rows = *block;
            for column in 0..N {
                let mut values = rows.map(|row| row[column]);
                frame.turn(&mut values);
                (0..D).for_each(|d| block[d][column] = values[d]);
            }
        }
        for blocks in matrix.iter_mut() {
            blocks[k].iter_mut().for_each(|row| frame.turn(row));
        }
    }
}
