//! The iterative solver: flexible GMRES with a multigrid cycle as preconditioner.
//!
//! ```text
//!   ‖S(r − K x)‖ ≤ 1e-10 max(min(R(x_given), R(x_rest)), 0.01 R(x_given)),    R(x) = ‖S(r − K x)‖
//! ```
//!
//! over the free unknowns, with S the nodal scaling; x_given: the fixed unknowns, 0 elsewhere; x_rest: the pressure of
//! fluid at rest as well, so that gravity does not hide what moves the fluid. A pressure that is known up to a constant
//! is singular in all of multigrid but on its last level; what the pinned row lacks there is the sum of the others,
//! since those of continuity add up to 0. Where the iterations allowed are not enough, more fill is tried, then a
//! direct factor; what is tried depends on matrix, right-hand side and starts alone.

use super::hierarchy::{Hierarchy, inverse};
use super::krylov;
use super::measure;
use super::multigrid::{Multigrid, Smoothers};
use super::pattern::Block;
use super::solver::{Krylov, LinearSolver, Solution};
use super::system::System;
use crate::boundary::Floating;
use crate::error::FluidError;

/// Residual at which it stops, relative to that of fluid at rest.
pub const TOLERANCE: f64 = 1e-10;
/// Least share of the residual of the given unknowns alone that counts as that of fluid at rest.
const REST_LEAST: f64 = 1e-2;
/// Iterations allowed where there are coarser meshes.
const ITERATIONS_MAX: usize = 40;
/// Iterations allowed where there are none.
const ITERATIONS_ALONE_MAX: usize = 100;
/// Most nodes of which a direct factor fits.
const DIRECT_FITS: usize = 20_000;

/// What an iteration may begin with, all unknowns each.
pub struct Starts {
    /// Fluid at rest.
    pub rest: Vec<f64>,
    /// What the solution may be near to.
    pub last: Vec<f64>,
}

/// Where an iteration is.
struct Iterate {
    x: Vec<f64>,
    /// S(r − K x), and its norm.
    residual: Vec<f64>,
    left: f64,
    /// What residuals are relative to.
    reference: f64,
}

/// Solver of the systems on a mesh.
pub struct Iterative<const N: usize> {
    hierarchy: Hierarchy<N>,
    fixed: Vec<bool>,
    floating: Floating,
    /// S
    scale: Vec<f64>,
    /// One factor for all velocities, one for all pressures: single precision has a range.
    uniform: [f64; N],
    matrices: Multigrid<N>,
    stages: Vec<Stage<N>>,
    direct: Option<LinearSolver<N>>,
    /// Does the direct factor hold the present matrix?
    direct_is_current: bool,
}

/// A preconditioner.
struct Stage<const N: usize> {
    fill: u8,
    /// Made when first needed.
    smoothers: Option<Smoothers<N>>,
    /// Of the present matrix: not made yet, or has it a factor?
    factorised: Option<bool>,
}

impl<const N: usize> Iterative<N> {
    /// Of a mesh and coarser ones; `fixed` unknowns are eliminated.
    pub fn new(hierarchy: Hierarchy<N>, fixed: Vec<bool>, floating: Floating) -> Iterative<N> {
        let fills: &[u8] = if hierarchy.levels.is_empty() {
            &[1]
        } else {
            &[0, 1]
        };
        let stage = |&fill: &u8| Stage {
            fill,
            smoothers: None,
            factorised: None,
        };
        Iterative {
            matrices: Multigrid::new(&hierarchy),
            stages: fills.iter().map(stage).collect(),
            hierarchy,
            scale: vec![1.0; fixed.len()],
            uniform: [1.0; N],
            fixed,
            floating,
            direct: None,
            direct_is_current: false,
        }
    }

    /// The mesh and the coarser ones.
    pub fn hierarchy(&self) -> &Hierarchy<N> {
        &self.hierarchy
    }

    /// Make the preconditioner of a system; `missing` is k of (G1) in [`super::multigrid`], level by level.
    pub fn factorise(&mut self, system: &System<N>, missing: &[Vec<f64>]) {
        self.scale = measure::nodal_scale(system);
        self.uniform = std::array::from_fn(|q| {
            let of_unknown = self.scale.iter().skip(q).step_by(N);
            let sum: f64 = of_unknown.map(|s| 1.0 / (s * s)).sum();
            (sum * N as f64 / self.scale.len() as f64).sqrt().recip()
        });
        self.copy(system);
        let weight = self.uniform[N - 1] * self.uniform[N - 1];
        self.matrices.coarsen(&self.hierarchy, missing, weight);
        for stage in &mut self.stages {
            stage.factorised = None;
        }
        self.direct_is_current = false;
        self.prepare(0);
    }

    /// The matrix in the order of rows.
    fn copy(&mut self, system: &System<N>) {
        let (hierarchy, uniform) = (&self.hierarchy, self.uniform);
        let rank = inverse(&hierarchy.order);
        let factors: Block<N> = uniform.map(|column| uniform.map(|row| column * row));
        let blocks = &mut self.matrices.finest().blocks;
        let mut sorted: Vec<(u32, &Block<N>)> = Vec::new();
        for (row, &node) in hierarchy.order.iter().enumerate() {
            let (neighbours, own) = system.row(node as usize);
            sorted.clear();
            sorted.extend(neighbours.iter().map(|&other| rank[other]).zip(own));
            sorted.sort_unstable_by_key(|&(column, _)| column);
            let slots = &mut blocks[hierarchy.rows.range(row)];
            for (slot, &(column, block)) in slots.iter_mut().zip(&sorted) {
                let mut block = *block;
                for (values, factors) in block.iter_mut().zip(&factors) {
                    (0..N).for_each(|r| values[r] *= factors[r]);
                }
                *slot = hierarchy.unknowns.fix(row, column as usize, &block);
            }
        }
    }

    /// Is a stage of use for the present matrix?
    fn prepare(&mut self, number: usize) -> bool {
        let (stage, matrices) = (&mut self.stages[number], &self.matrices);
        let smoothers =
            (stage.smoothers).get_or_insert_with(|| Smoothers::new(matrices, stage.fill));
        *(stage.factorised).get_or_insert_with(|| smoothers.factorise(matrices))
    }

    /// Solve with the last matrix; `given` holds the fixed unknowns.
    pub fn solve(
        &mut self,
        system: &System<N>,
        given: &[f64],
        starts: Option<&Starts>,
    ) -> Result<Solution, FluidError> {
        let mut begin = self.begin(system, given, starts);
        let mut krylov = Krylov::default();
        let mut left = f64::INFINITY;
        for number in 0..self.stages.len() {
            if self.prepare(number) {
                let (iterations, reached) = self.iterate(system, &mut begin, number);
                krylov.iterations += iterations;
                left = reached;
                if left <= TOLERANCE {
                    return Ok(self.solution(system, begin.x, krylov));
                }
            }
            krylov.fallbacks += 1;
            tracing::info!(left, "the preconditioner is not good enough: more fill");
        }
        self.solve_directly(system, given, krylov, left)
    }

    /// The start of the least residual, and what residuals are relative to.
    fn begin(&self, system: &System<N>, given: &[f64], starts: Option<&Starts>) -> Iterate {
        let known = given.iter().zip(&self.fixed);
        let known = known.map(|(&v, &fixed)| if fixed { v } else { 0.0 });
        let known: Vec<f64> = known.collect();
        let begin = |x: Vec<f64>, residual: Vec<f64>, reference: f64| Iterate {
            left: norm(&residual),
            x,
            residual,
            reference,
        };
        let Some(Starts { rest, last }) = starts else {
            let [residual] = self.residuals(system, [&known]);
            let reference = norm(&residual);
            return begin(known, residual, reference);
        };
        let (rest, last) = (self.shifted(rest, given), self.shifted(last, given));
        let residuals = self.residuals(system, [&known, &rest, &last]);
        let [of_known, of_rest, _] = residuals.each_ref().map(|residual| norm(residual));
        let reference = of_known.min(of_rest).max(REST_LEAST * of_known);
        let starts = [known, rest, last].into_iter().zip(residuals);
        let starts = starts.map(|(x, residual)| begin(x, residual, reference));
        let least = starts.reduce(|best, next| if next.left < best.left { next } else { best });
        least.expect("three starts")
    }

    fn solution(&self, system: &System<N>, x: Vec<f64>, krylov: Krylov) -> Solution {
        Solution {
            backward_error: measure::backward_error(system, &x, &self.scale, &self.fixed),
            unknowns: x,
            solves: 0,
            fallbacks: 0,
            krylov: Some(krylov),
        }
    }

    /// Iterate from where it is; returns iterations and the residual reached, relative to the reference.
    fn iterate(&mut self, system: &System<N>, at: &mut Iterate, stage: usize) -> (usize, f64) {
        let most = match self.hierarchy.levels.is_empty() {
            true => ITERATIONS_ALONE_MAX,
            false => ITERATIONS_MAX,
        };
        let reference = at.reference;
        let goal = TOLERANCE * reference;
        let mut iterations = 0;
        loop {
            let left = at.left;
            if left <= goal || left.is_nan() {
                let relative = if left == 0.0 { 0.0 } else { left / reference };
                return (iterations, relative);
            }
            if iterations >= most {
                return (iterations, left / reference);
            }
            let (fixed, scale, floating) = (&self.fixed, &self.scale, &self.floating);
            let (hierarchy, uniform) = (&self.hierarchy, &self.uniform);
            let Some(smoothers) = &self.stages[stage].smoothers else {
                return (iterations, left / reference);
            };
            let matrices = &mut self.matrices;
            let mut unscaled = vec![0.0; at.x.len()];
            let precondition = |v: &[f64], z: &mut [f64]| {
                let pairs = v.iter().zip(scale);
                (unscaled.iter_mut().zip(pairs)).for_each(|(slot, (v, s))| *slot = v / s);
                floating.fill_pinned::<N>(&mut unscaled);
                let solved = matrices.cycle(hierarchy, smoothers, |right| {
                    for (slot, &node) in right.iter_mut().zip(&hierarchy.order) {
                        let values = &unscaled[N * node as usize..][..N];
                        *slot = std::array::from_fn(|q| (values[q] * uniform[q]) as f32);
                    }
                });
                for (values, &node) in solved.iter().zip(&hierarchy.order) {
                    let slot = &mut z[N * node as usize..][..N];
                    (0..N).for_each(|q| slot[q] = f64::from(values[q]) * uniform[q]);
                }
                floating.level::<N>(z);
                clear_fixed(z, fixed);
            };
            let multiply = |z: &[f64], w: &mut [f64]| {
                w.fill(0.0);
                system.pattern.subtract_product(&system.matrix, z, w);
                for (k, value) in w.iter_mut().enumerate() {
                    *value *= if fixed[k] { 0.0 } else { -scale[k] };
                }
            };
            let (step, reached) = krylov::solve(
                std::mem::take(&mut at.residual),
                0.9 * goal,
                most - iterations,
                precondition,
                multiply,
            );
            at.x.iter_mut().zip(&step).for_each(|(x, step)| *x += step);
            [at.residual] = self.residuals(system, [&at.x]);
            at.left = norm(&at.residual);
            if reached.iterations == 0 {
                return (iterations, left / reference);
            }
            iterations += reached.iterations;
        }
    }

    /// S(r − K x) of several x, 0 where the unknown is fixed.
    fn residuals<const K: usize>(&self, system: &System<N>, x: [&[f64]; K]) -> [Vec<f64>; K] {
        let mut residuals: [Vec<f64>; K] = std::array::from_fn(|_| system.right.clone());
        let product = &system.pattern;
        let slots = residuals.each_mut().map(|residual| residual.as_mut_slice());
        product.subtract_products(&system.matrix, x, slots);
        for residual in &mut residuals {
            for (k, value) in residual.iter_mut().enumerate() {
                *value *= if self.fixed[k] { 0.0 } else { self.scale[k] };
            }
        }
        residuals
    }

    /// A start with the given unknowns of `given`, the pressure of a closed part level with that given there.
    fn shifted(&self, start: &[f64], given: &[f64]) -> Vec<f64> {
        let mut start = start.to_vec();
        self.floating.level::<N>(&mut start);
        for &pinned in &self.floating.pinned {
            start[N * pinned + N - 1] = given[N * pinned + N - 1];
        }
        for (k, slot) in start.iter_mut().enumerate() {
            if self.fixed[k] {
                *slot = given[k];
            }
        }
        start
    }

    fn solve_directly(
        &mut self,
        system: &System<N>,
        given: &[f64],
        krylov: Krylov,
        left: f64,
    ) -> Result<Solution, FluidError> {
        let nodes = system.pattern.nodes();
        if nodes > DIRECT_FITS {
            return Err(FluidError::Krylov {
                residual: left,
                iterations: krylov.iterations,
                tolerance: TOLERANCE,
                nodes,
                most: DIRECT_FITS,
            });
        }
        tracing::info!(
            nodes,
            left,
            "the iterative solver did not converge: a direct factor"
        );
        let direct = match &mut self.direct {
            Some(direct) => direct,
            none => none.insert(LinearSolver::new(&system.pattern, self.fixed.clone())?),
        };
        if !self.direct_is_current {
            direct.factorise(system);
            self.direct_is_current = true;
        }
        Ok(Solution {
            krylov: Some(krylov),
            ..direct.solve(system, given, None)?
        })
    }

    /// ‖S(r − Kx)‖ / ‖S|K||x|‖ over the free unknowns.
    pub fn relative_residual(&self, system: &System<N>, x: &[f64]) -> f64 {
        measure::residual(system, x, &self.fixed)
    }

    /// Memory of the preconditioner \[bytes\].
    pub fn bytes(&self) -> usize {
        let smoothers = self.stages.iter().filter_map(|s| s.smoothers.as_ref());
        let smoothers: usize = smoothers.map(|s| s.bytes(&self.matrices)).sum();
        self.hierarchy.bytes() + self.matrices.bytes() + smoothers
    }
}

fn clear_fixed(x: &mut [f64], fixed: &[bool]) {
    for (value, &fixed) in x.iter_mut().zip(fixed) {
        if fixed {
            *value = 0.0;
        }
    }
}

fn norm(values: &[f64]) -> f64 {
    krylov::dot(values, values).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{Condition, Constraints};
    use crate::linear::hierarchy::Conditions;
    use crate::mesh::Rectangle;

    #[test]
    fn where_iterations_do_not_converge_a_direct_factor_solves() {
        let mesh = Rectangle::new([0.0; 2], [1.0; 2], [48, 40]).mesh().unwrap();
        let mut system = System::new(mesh.node_count(), &mesh.simplices);
        // Numbers without any order.
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let blocks = system.matrix.as_flattened_mut().as_flattened_mut();
        blocks.iter_mut().for_each(|value| *value = random());
        system.right.iter_mut().for_each(|value| *value = random());
        let conditions = vec![Condition::NoSlip; 4];
        let constraints =
            Constraints::new(&mesh, conditions, 1.0, &space::Vector::zeros()).unwrap();
        let finest = Conditions {
            mesh: &mesh,
            constraints: &constraints,
        };
        let hierarchy = Hierarchy::new(&system.pattern, &finest, &[]);
        let fixed = constraints.fixed.clone();
        let floating = constraints.floating();
        let mut solver = Iterative::new(hierarchy, fixed.clone(), floating);
        let given = vec![0.0; fixed.len()];
        solver.factorise(&system, &[]);
        let found = solver.solve(&system, &given, None).unwrap();
        let krylov = found.krylov.unwrap();
        println!("{krylov:?}, omega {:.1e}", found.backward_error);
        assert!(krylov.fallbacks == 1 && krylov.iterations > 0);
        let mut direct = LinearSolver::new(&system.pattern, fixed).unwrap();
        direct.factorise(&system);
        assert!(direct.solve(&system, &given, None).unwrap().unknowns == found.unknowns);
    }
}
