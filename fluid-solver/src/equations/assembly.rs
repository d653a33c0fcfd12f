//! The system of the equations: element by element, and turned where the unknowns of a node are.
//!
//! Elements are added in their order: same input, same bits on any number of threads.

use rayon::prelude::*;
use space::{Dim, Dimension};

use super::coefficients::{Coefficients, ViscousForm};
use super::continuity;
use super::element::Element;
use super::momentum::{self, Matrix, RightSide};
use super::open;
use crate::boundary::constraints::Constraints;
use crate::boundary::frame::Frame;
use crate::linear::system::System;
use crate::mesh::simplices::Mesh;

/// Simplices whose blocks are computed, on all threads, before they are added in order.
const BATCH: usize = 2048;

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
        let simplices = &self.mesh.simplices;
        if matrix_too {
            system.matrix.fill(0.0);
        }
        system.right.fill(0.0);
        let nothing = ([[[[0.0; N]; N]; N]; N], [[0.0; N]; N]);
        let mut batch = vec![nothing; BATCH.min(simplices.len())];
        for first in (0..simplices.len()).step_by(BATCH) {
            let batch = &mut batch[..BATCH.min(simplices.len() - first)];
            let slots = batch.par_iter_mut().enumerate();
            slots.for_each(|(k, slot)| *slot = self.element(first + k, matrix_too));
            for (k, (matrix, right)) in batch.iter().enumerate() {
                system.add_right(&simplices[first + k], right);
                if matrix_too {
                    system.add_matrix(first + k, matrix);
                }
            }
        }
        if matrix_too {
            self.add_open_facets(system);
        }
        for (node, flux) in self.flux.iter().enumerate() {
            system.right[N * node + D] -= flux;
        }
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
