//! Sparse direct solve: symbolic analysis once, numeric factor when the matrix changed, iterative
//! refinement always.
//!
//! Scaling and backward error ω are those of [`super::measure`]. Large matrices are factorised in single precision and
//! refined in double; where that does not gain, or a pivot is small, in double precision, and where that does not reach
//! the bound either, once more with row exchanges anywhere.

use std::sync::Arc;

use super::eliminate::Precision;
use super::measure;
use super::multifrontal::Multifrontal;
use super::pattern::{Block, Pattern};
use super::pivoting::PivotingLu;
use super::plans::Plans;
use super::system::System;
use crate::error::FluidError;

/// Backward error that a solution must reach.
pub const BACKWARD_ERROR_MAX: f64 = 1e-10;
/// Backward error below which no further refinement is tried.
const BACKWARD_ERROR_GOAL: f64 = 1e-14;
/// Refinements that are always allowed; more only while ω is above its bound.
const REFINEMENTS: usize = 2;
const REFINEMENTS_MAX: usize = 8;
/// Solves with a factor of single precision.
const SOLVES_SINGLE: usize = 5;
/// What each of them must gain.
const GAIN: f64 = 10.0;
/// Fewer nodes are factorised in double precision: that takes milliseconds.
const SINGLE_NODES: usize = 3000;

/// A solution and how good it is.
#[derive(Debug, Clone)]
pub struct Solution {
    /// All unknowns.
    pub unknowns: Vec<f64>,
    /// ω
    pub backward_error: f64,
    /// Solves with a factor, the last that was tried.
    pub solves: usize,
    /// Factors that were not accurate enough: one of single precision, one of double precision without exchanges.
    pub fallbacks: usize,
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

/// A way to factorise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    /// Fronts in single precision.
    Single,
    /// Fronts in double precision.
    Double,
    /// Row exchanges anywhere.
    Pivoting,
}

/// A factor of one of the levels, made when first needed.
struct Kept<F> {
    factor: Option<F>,
    /// Does it hold the present matrix?
    is_current: bool,
}

impl<F> Default for Kept<F> {
    fn default() -> Kept<F> {
        Kept {
            factor: None,
            is_current: false,
        }
    }
}

/// The factorised matrix of a mesh.
pub struct LinearSolver<const N: usize> {
    plans: Arc<Plans<N>>,
    single: Kept<Multifrontal<f32, N>>,
    double: Kept<Multifrontal<f64, N>>,
    pivoting: Kept<PivotingLu>,
    fixed: Vec<bool>,
    scale: Vec<f64>,
    scaled: Vec<Block<N>>,
}

impl<const N: usize> LinearSolver<N> {
    /// Analyse a pattern; `fixed` unknowns are eliminated.
    pub fn new(pattern: &Pattern<N>, fixed: Vec<bool>) -> Result<LinearSolver<N>, FluidError> {
        Ok(LinearSolver {
            plans: Arc::new(Plans::new(pattern)?),
            single: Kept::default(),
            double: Kept::default(),
            pivoting: Kept::default(),
            fixed,
            scale: vec![1.0; pattern.unknowns()],
            scaled: vec![[[0.0; N]; N]; pattern.blocks()],
        })
    }

    /// How matrices of this size are factorised at first.
    fn first(&self) -> Level {
        match self.scale.len() / N < SINGLE_NODES {
            true => Level::Double,
            false => Level::Single,
        }
    }

    /// Does a solve profit from a start near its solution?
    pub fn begins(&self) -> bool {
        self.first() == Level::Single
    }

    /// Factorise the matrix of a system.
    pub fn factorise(&mut self, system: &System<N>) {
        self.scale = measure::nodal_scale(system);
        measure::scale_matrix(system, &self.scale, &self.fixed, &mut self.scaled);
        self.single.is_current = false;
        self.double.is_current = false;
        self.pivoting.is_current = false;
        match self.first() {
            Level::Single => factorise_fronts(&mut self.single, &self.plans, &self.scaled),
            _ => factorise_fronts(&mut self.double, &self.plans, &self.scaled),
        }
    }

    /// Have the factor of a level at hand; can it be used?
    fn prepare(&mut self, level: Level, pattern: &Pattern<N>) -> Result<bool, FluidError> {
        match level {
            Level::Single if !self.single.is_current => {
                factorise_fronts(&mut self.single, &self.plans, &self.scaled);
            }
            Level::Double if !self.double.is_current => {
                tracing::debug!("a factor of single precision is not accurate enough: double");
                factorise_fronts(&mut self.double, &self.plans, &self.scaled);
            }
            Level::Pivoting if !self.pivoting.is_current => {
                tracing::debug!("the multifrontal factor is not accurate enough: pivoting");
                let mut factor = match self.pivoting.factor.take() {
                    Some(factor) => factor,
                    None => PivotingLu::new(pattern)?,
                };
                factor.factorise(&pattern.by_columns(&self.scaled))?;
                self.pivoting = Kept {
                    factor: Some(factor),
                    is_current: true,
                };
            }
            _ => {}
        }
        // what the others are worth, the backward error tells
        let single = self.single.factor.as_ref();
        Ok(level != Level::Single || single.is_some_and(Multifrontal::is_trusted))
    }

    /// Solve with the last matrix; `given` holds the fixed unknowns, `start` what the solution may be near to. Which of
    /// the factors is taken depends on this right-hand side alone, not on those before it.
    pub fn solve(
        &mut self,
        system: &System<N>,
        given: &[f64],
        start: Option<&[f64]>,
    ) -> Result<Solution, FluidError> {
        let levels: &[Level] = match self.first() {
            Level::Single => &[Level::Single, Level::Double, Level::Pivoting],
            _ => &[Level::Double, Level::Pivoting],
        };
        let mut last = None;
        for (fallbacks, &level) in levels.iter().enumerate() {
            if !self.prepare(level, &system.pattern)? {
                continue;
            }
            let solution = match level {
                Level::Single => self.refine_single(system, given, start),
                _ => self.refine(system, given, level),
            };
            if solution.backward_error < BACKWARD_ERROR_MAX {
                return Ok(Solution {
                    fallbacks,
                    ..solution
                });
            }
            last = Some(solution);
        }
        let (residual, solves) = last.map_or((f64::NAN, 0), |solution| {
            (solution.backward_error, solution.solves)
        });
        Err(FluidError::LinearResidual {
            residual,
            solves,
            bound: BACKWARD_ERROR_MAX,
        })
    }

    /// A start with the given unknowns in their places.
    fn start(&self, given: &[f64], start: Option<&[f64]>) -> Vec<f64> {
        let known = given.iter().zip(&self.fixed).enumerate();
        let start = |k: usize| start.map_or(0.0, |start| start[k]);
        known
            .map(|(k, (&v, &fixed))| if fixed { v } else { start(k) })
            .collect()
    }

    /// ω of a solution; r − K x comes into `residual`.
    fn measured(&self, system: &System<N>, x: &[f64], residual: &mut Vec<f64>) -> f64 {
        measure::measured(system, x, &self.scale, &self.fixed, residual)
    }

    /// Solve and refine with the factor of single precision.
    fn refine_single(
        &mut self,
        system: &System<N>,
        given: &[f64],
        start: Option<&[f64]>,
    ) -> Solution {
        let mut x = self.start(given, start);
        let mut residual = Vec::new();
        let mut error = self.measured(system, &x, &mut residual);
        let mut solves = 0;
        // one at least: what is good enough to begin with would stay for ever
        while solves < SOLVES_SINGLE && (solves == 0 || error >= BACKWARD_ERROR_MAX) {
            let mut next = x.clone();
            self.correct(&mut residual, &mut next, Level::Single);
            solves += 1;
            let reached = self.measured(system, &next, &mut residual);
            let gain = error / reached;
            if reached < error {
                (x, error) = (next, reached);
            }
            if gain.is_nan() || gain < GAIN {
                break;
            }
        }
        Solution {
            unknowns: x,
            backward_error: error,
            solves,
            fallbacks: 0,
            krylov: None,
        }
    }

    /// Solve and refine with a factor of double precision.
    fn refine(&mut self, system: &System<N>, given: &[f64], level: Level) -> Solution {
        let mut x = self.start(given, None);
        let mut residual = Vec::new();
        self.measured(system, &x, &mut residual);
        self.correct(&mut residual, &mut x, level);
        let mut error = self.measured(system, &x, &mut residual);
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
            self.correct(&mut residual, &mut next, level);
            refinements += 1;
            let next_error = self.measured(system, &next, &mut residual);
            if next_error >= error || next_error.is_nan() {
                break;
            }
            (x, error) = (next, next_error);
        }
        Solution {
            unknowns: x,
            backward_error: error,
            solves: refinements + 1,
            fallbacks: 0,
            krylov: None,
        }
    }

    /// [`measure::residual`]
    pub fn residual(&self, system: &System<N>, x: &[f64]) -> f64 {
        measure::residual(system, x, &self.fixed)
    }

    /// x ← x + S (LU)⁻¹ S (r − K x) on the free unknowns; takes r − K x, which is used up.
    fn correct(&mut self, residual: &mut [f64], x: &mut [f64], level: Level) {
        for (k, value) in residual.iter_mut().enumerate() {
            *value *= if self.fixed[k] { 0.0 } else { self.scale[k] };
        }
        // of size one: the least numbers of single precision are not so small
        let size = residual
            .iter()
            .fold(0.0, |size: f64, value| size.max(value.abs()));
        if size > 0.0 {
            residual.iter_mut().for_each(|value| *value /= size);
        }
        match level {
            Level::Single => self
                .single
                .factor
                .as_ref()
                .map(|factor| factor.solve(residual)),
            Level::Double => self
                .double
                .factor
                .as_ref()
                .map(|factor| factor.solve(residual)),
            Level::Pivoting => self
                .pivoting
                .factor
                .as_mut()
                .map(|factor| factor.solve(residual)),
        };
        for (k, value) in residual.iter().enumerate() {
            if !self.fixed[k] {
                x[k] += value * size * self.scale[k];
            }
        }
    }
}

/// Factorise fronts in some precision.
fn factorise_fronts<T: Precision, const N: usize>(
    kept: &mut Kept<Multifrontal<T, N>>,
    plans: &Arc<Plans<N>>,
    scaled: &[Block<N>],
) {
    let make = || Multifrontal::new(Arc::clone(plans));
    kept.factor.get_or_insert_with(make).factorise(scaled);
    kept.is_current = true;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rectangle::Rectangle;

    #[test]
    fn all_factors_give_the_same_solution() {
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
        let mut linear = LinearSolver::new(&system.pattern, fixed).unwrap();
        linear.factorise(&system);
        let fast = linear.solve(&system, &given, None).unwrap();
        let [single, safe] = [Level::Single, Level::Pivoting].map(|level| {
            assert!(linear.prepare(level, &system.pattern).unwrap());
            match level {
                Level::Single => linear.refine_single(&system, &given, None),
                _ => linear.refine(&system, &given, level),
            }
        });
        assert!(fast.fallbacks == 0 && fast.unknowns[7] == 0.25);
        for (other, bound) in [(&safe, 1e-13), (&single, 1e-12)] {
            let pairs = fast.unknowns.iter().zip(&other.unknowns);
            let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("{difference:.1e} after {} solves", other.solves);
            assert!(difference < bound, "{difference}");
        }
        // A right-hand side that needed the safe factor leaves no trace.
        let again = linear.solve(&system, &given, None).unwrap();
        assert!(again.fallbacks == 0 && again.unknowns == fast.unknowns);
    }
}
