//! Sparse direct solve: symbolic analysis once, numeric factor when the matrix changed, iterative
//! refinement always.
//!
//! Scaling and backward error ω are those of [`super::measure`]. Where refinement with the
//! multifrontal factor does not reach the bound, the matrix is factorised once more with row
//! exchanges anywhere.

use space::Vector;

use super::measure;
use super::multifrontal::Multifrontal;
use super::pattern::{Block, Pattern};
use super::pivoting::PivotingLu;
use super::system::System;
use crate::error::FluidError;

/// Backward error that a solution must reach.
pub const BACKWARD_ERROR_MAX: f64 = 1e-10;
/// Backward error below which no further refinement is tried.
const BACKWARD_ERROR_GOAL: f64 = 1e-14;
/// Refinements that are always allowed; more only while ω is above its bound.
const REFINEMENTS: usize = 2;
const REFINEMENTS_MAX: usize = 8;

/// A solution and how good it is.
#[derive(Debug, Clone)]
pub struct Solution {
    /// All unknowns.
    pub unknowns: Vec<f64>,
    /// ω
    pub backward_error: f64,
    /// Refinements done.
    pub refinements: usize,
    /// Was the safe factor needed?
    pub pivoted: bool,
    /// What an iterative solver did; none where the matrix was factorised.
    pub krylov: Option<Krylov>,
}

/// What an iterative solver did.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Krylov {
    /// Iterations, with those of preconditioners that were not enough.
    pub iterations: usize,
    /// Preconditioners that were not enough.
    pub fallbacks: usize,
}

/// The factorised matrix of a mesh.
pub struct LinearSolver<const N: usize> {
    fast: Multifrontal<N>,
    /// Made when first needed.
    safe: Option<PivotingLu>,
    /// Does the safe factor hold the present matrix?
    safe_is_current: bool,
    fixed: Vec<bool>,
    scale: Vec<f64>,
    scaled: Vec<Block<N>>,
}

impl<const N: usize> LinearSolver<N> {
    /// Analyse a pattern on nodes with these positions; `fixed` unknowns are eliminated.
    pub fn new<const D: usize>(
        pattern: &Pattern<N>,
        position: &[Vector<D>],
        fixed: Vec<bool>,
    ) -> LinearSolver<N> {
        LinearSolver {
            fast: Multifrontal::new(pattern, position),
            safe: None,
            safe_is_current: false,
            fixed,
            scale: vec![1.0; pattern.unknowns()],
            scaled: vec![[[0.0; N]; N]; pattern.blocks()],
        }
    }

    /// Factorise the matrix of a system.
    pub fn factorise(&mut self, system: &System<N>) {
        self.scale = measure::nodal_scale(system);
        let (scale, fixed) = (&self.scale, &self.fixed);
        let mut slots = self.scaled.as_flattened_mut().as_flattened_mut().iter_mut();
        system
            .pattern
            .for_each(&system.matrix, |row, column, value| {
                if let Some(slot) = slots.next() {
                    *slot = match (fixed[row] || fixed[column], row == column) {
                        (false, _) => value * scale[row] * scale[column],
                        (true, same) => f64::from(u8::from(same)),
                    };
                }
            });
        self.safe_is_current = false;
        self.fast.factorise(&self.scaled);
    }

    /// Factorise the same matrix with row exchanges anywhere.
    fn factorise_safely(&mut self, pattern: &Pattern<N>) -> Result<(), FluidError> {
        tracing::info!("the multifrontal factor is not accurate enough: pivoting");
        let mut safe = match self.safe.take() {
            Some(safe) => safe,
            None => PivotingLu::new(pattern)?,
        };
        safe.factorise(&pattern.by_columns(&self.scaled))?;
        self.safe = Some(safe);
        self.safe_is_current = true;
        Ok(())
    }

    /// Solve with the last factor; `given` holds the fixed unknowns. Which of the two factors is taken
    /// depends on this right-hand side alone, not on those before it.
    pub fn solve(&mut self, system: &System<N>, given: &[f64]) -> Result<Solution, FluidError> {
        let mut solution = self.refine(system, given, false);
        let good = |solution: &Solution| solution.backward_error < BACKWARD_ERROR_MAX;
        if !good(&solution) {
            if !self.safe_is_current {
                self.factorise_safely(&system.pattern)?;
            }
            solution = self.refine(system, given, true);
        }
        if good(&solution) {
            return Ok(solution);
        }
        Err(FluidError::LinearResidual {
            residual: solution.backward_error,
            refinements: solution.refinements,
            bound: BACKWARD_ERROR_MAX,
        })
    }

    /// Solve and refine with the fast or, `pivoted`, the safe factor.
    fn refine(&mut self, system: &System<N>, given: &[f64], pivoted: bool) -> Solution {
        let known = given.iter().zip(&self.fixed);
        let mut x: Vec<f64> = known
            .map(|(&v, &fixed)| if fixed { v } else { 0.0 })
            .collect();
        self.correct(system, &mut x, pivoted);
        let mut error = measure::backward_error(system, &x, &self.scale, &self.fixed);
        let mut refinements = 0;
        while refinements < REFINEMENTS_MAX && error.is_finite() {
            let usual = refinements < REFINEMENTS;
            if error
                <= if usual {
                    BACKWARD_ERROR_GOAL
                } else {
                    BACKWARD_ERROR_MAX
                }
            {
                break;
            }
            let mut next = x.clone();
            self.correct(system, &mut next, pivoted);
            refinements += 1;
            let next_error = measure::backward_error(system, &next, &self.scale, &self.fixed);
            if next_error >= error || next_error.is_nan() {
                break;
            }
            (x, error) = (next, next_error);
        }
        Solution {
            unknowns: x,
            backward_error: error,
            refinements,
            pivoted,
            krylov: None,
        }
    }

    /// [`measure::residual`]
    pub fn residual(&self, system: &System<N>, x: &[f64]) -> f64 {
        measure::residual(system, x, &self.fixed)
    }

    /// x ← x + S (LU)⁻¹ S (r − K x) on the free unknowns.
    fn correct(&mut self, system: &System<N>, x: &mut [f64], pivoted: bool) {
        let mut residual = system.right.clone();
        system
            .pattern
            .subtract_product(&system.matrix, x, &mut residual);
        for (k, value) in residual.iter_mut().enumerate() {
            *value = if self.fixed[k] {
                0.0
            } else {
                *value * self.scale[k]
            };
        }
        match &mut self.safe {
            Some(safe) if pivoted => safe.solve(&mut residual),
            _ => self.fast.solve(&mut residual),
        }
        for (k, value) in residual.iter().enumerate() {
            if !self.fixed[k] {
                x[k] += value * self.scale[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rectangle::Rectangle;

    #[test]
    fn both_factors_give_the_same_solution() {
        let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [14, 9]);
        rectangle.periodic = [true, false];
        let mesh = rectangle.mesh().unwrap();
        let mut system = System::new(mesh.node_count(), &mesh.simplices);
        // Any matrix with a strong diagonal, and a given unknown among the others.
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let matrix = system.matrix.clone();
        let mut slots = system
            .matrix
            .as_flattened_mut()
            .as_flattened_mut()
            .iter_mut();
        system.pattern.for_each(&matrix, |row, column, _| {
            *slots.next().unwrap() = random() + if row == column { 8.0 } else { 0.0 };
        });
        system.right.iter_mut().for_each(|value| *value = random());
        let mut fixed = vec![false; system.pattern.unknowns()];
        fixed[7] = true;
        let given = vec![0.25; fixed.len()];
        let mut linear = LinearSolver::new(&system.pattern, &mesh.position, fixed);
        linear.factorise(&system);
        let fast = linear.solve(&system, &given).unwrap();
        linear.factorise_safely(&system.pattern).unwrap();
        let safe = linear.refine(&system, &given, true);
        assert!(!fast.pivoted && safe.pivoted && fast.unknowns[7] == 0.25);
        let pairs = fast.unknowns.iter().zip(&safe.unknowns);
        let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-13, "{difference}");
        // A right-hand side that needed the safe factor leaves no trace.
        let again = linear.solve(&system, &given).unwrap();
        assert!(!again.pivoted && again.unknowns == fast.unknowns);
    }
}
