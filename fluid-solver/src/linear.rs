//! Sparse direct solve: symbolic analysis once, numeric factor when the matrix changed, iterative
//! refinement always.
//!
//! ```text
//!   s_u = (½(|K_xx| + |K_yy|))^(−1/2),  s_p = |K_pp|^(−1/2)      symmetric nodal scaling
//!   ω   = max_i |r − Kx|_i / (|K||x| + |r|)_i                    componentwise backward error
//! ```
//!
//! A 2-norm residual hides a wrong fluid velocity next to stiff grains; ω does not (Oettli and
//! Prager 1964). Where the denominator of a row is round-off, that of Arioli, Demmel and Duff
//! (1989) is taken.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par};

use crate::assembly::{Pattern, System};
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
}

/// The factorised matrix of a mesh.
pub struct LinearSolver {
    structure: SymbolicSparseColMat<usize>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    memory: MemBuffer,
    fixed: Vec<bool>,
    scale: Vec<f64>,
    scaled: Vec<f64>,
}

impl LinearSolver {
    /// Analyse a pattern; `fixed` unknowns are eliminated.
    pub fn new(pattern: &Pattern, fixed: Vec<bool>) -> Result<LinearSolver, FluidError> {
        let broken = |error| FluidError::Factorisation(format!("analysis: {error:?}"));
        let (pointers, rows) = pattern.columns();
        let n = pattern.unknowns();
        let structure = SymbolicSparseColMat::new_checked(n, n, pointers, None, rows);
        let symbolic =
            factorize_symbolic_lu(structure.as_ref(), Default::default()).map_err(broken)?;
        let numeric = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let memory =
            MemBuffer::try_new(numeric.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)))
                .map_err(|_| FluidError::Factorisation("out of memory".into()))?;
        Ok(LinearSolver {
            structure,
            symbolic,
            numeric: NumericLu::new(),
            memory,
            fixed,
            scale: vec![1.0; n],
            scaled: vec![0.0; pattern.entries()],
        })
    }

    /// Factorise the matrix of a system.
    pub fn factorise(&mut self, system: &System) -> Result<(), FluidError> {
        self.scale_of(system);
        let (scale, fixed) = (&self.scale, &self.fixed);
        let mut slot = self.scaled.iter_mut();
        system
            .pattern
            .for_each(&system.matrix, |row, column, value| {
                if let Some(slot) = slot.next() {
                    *slot = match (fixed[row] || fixed[column], row == column) {
                        (false, _) => value * scale[row] * scale[column],
                        (true, same) => f64::from(u8::from(same)),
                    };
                }
            });
        let matrix = SparseColMatRef::new(self.structure.as_ref(), &self.scaled[..]);
        let stack = MemStack::new(&mut self.memory);
        self.symbolic
            .factorize_numeric_lu(
                &mut self.numeric,
                matrix,
                Par::Seq,
                stack,
                Default::default(),
            )
            .map_err(|error| FluidError::Factorisation(format!("{error:?}")))?;
        Ok(())
    }

    fn scale_of(&mut self, system: &System) {
        let mut diagonal = vec![0.0; self.scale.len()];
        system
            .pattern
            .for_each(&system.matrix, |row, column, value| {
                if row == column {
                    diagonal[row] = value.abs();
                }
            });
        let root = |value: f64| {
            if value > 0.0 {
                value.sqrt().recip()
            } else {
                1.0
            }
        };
        for (scale, d) in self.scale.chunks_exact_mut(3).zip(diagonal.chunks_exact(3)) {
            let velocity = root(0.5 * (d[0] + d[1]));
            scale.copy_from_slice(&[velocity, velocity, root(d[2])]);
        }
    }

    /// Solve with the last factor; `given` holds the fixed unknowns.
    pub fn solve(&mut self, system: &System, given: &[f64]) -> Result<Solution, FluidError> {
        let mut x: Vec<f64> = given
            .iter()
            .zip(&self.fixed)
            .map(|(&v, &fixed)| if fixed { v } else { 0.0 })
            .collect();
        let mut refinements = 0;
        self.correct(system, &mut x);
        let mut error = self.backward_error(system, &x);
        loop {
            let wanted = if refinements < REFINEMENTS {
                BACKWARD_ERROR_GOAL
            } else {
                BACKWARD_ERROR_MAX
            };
            if error <= wanted || refinements == REFINEMENTS_MAX || !error.is_finite() {
                break;
            }
            let before = (x.clone(), error);
            self.correct(system, &mut x);
            refinements += 1;
            error = self.backward_error(system, &x);
            if error >= before.1 {
                (x, error) = before;
                break;
            }
        }
        if error.is_nan() || error >= BACKWARD_ERROR_MAX {
            let bound = BACKWARD_ERROR_MAX;
            return Err(FluidError::LinearResidual {
                residual: error,
                refinements,
                bound,
            });
        }
        Ok(Solution {
            unknowns: x,
            backward_error: error,
            refinements,
        })
    }

    /// ‖S(r − Kx)‖ / ‖S|K||x|‖ over the free unknowns.
    pub fn residual(&mut self, system: &System, x: &[f64]) -> f64 {
        self.scale_of(system);
        let mut residual = system.right.clone();
        let mut size = vec![0.0; x.len()];
        system
            .pattern
            .for_each(&system.matrix, |row, column, value| {
                residual[row] -= value * x[column];
                size[row] += (value * x[column]).abs();
            });
        let norm = |values: &[f64]| {
            let free = (0..values.len()).filter(|&k| !self.fixed[k]);
            free.map(|k| (self.scale[k] * values[k]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let (residual, size) = (norm(&residual), norm(&size));
        if residual == 0.0 {
            0.0
        } else {
            residual / size
        }
    }

    /// x ← x + S (LU)⁻¹ S (r − K x) on the free unknowns.
    fn correct(&mut self, system: &System, x: &mut [f64]) {
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
        let n = residual.len();
        let stack = MemStack::new(&mut self.memory);
        let column = MatMut::from_column_major_slice_mut(&mut residual, n, 1);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            column,
            Par::Seq,
            stack,
        );
        for (k, value) in residual.iter().enumerate() {
            if !self.fixed[k] {
                x[k] += value * self.scale[k];
            }
        }
    }

    /// ω of the free rows.
    fn backward_error(&self, system: &System, x: &[f64]) -> f64 {
        let n = x.len();
        let mut residual = system.right.clone();
        let mut size: Vec<f64> = system.right.iter().map(|value| value.abs()).collect();
        let mut row_sum = vec![0.0; n];
        system
            .pattern
            .for_each(&system.matrix, |row, column, value| {
                let product = value * x[column];
                residual[row] -= product;
                size[row] += product.abs();
                row_sum[row] += (value * self.scale[column]).abs();
            });
        let largest = x
            .iter()
            .zip(&self.scale)
            .map(|(x, s)| (x / s).abs())
            .fold(0.0, f64::max);
        let mut worst: f64 = 0.0;
        for k in (0..n).filter(|&k| !self.fixed[k]) {
            let background = row_sum[k] * largest;
            let tiny = 1000.0 * n as f64 * f64::EPSILON * (background + system.right[k].abs());
            let bound = if size[k] > tiny {
                size[k]
            } else {
                size[k] + background
            };
            if residual[k] != 0.0 {
                worst = worst.max(residual[k].abs() / bound);
            }
            if residual[k].is_nan() {
                return f64::NAN;
            }
        }
        worst
    }
}
