//! The equations of one step, solved: once when the convecting velocity is known, by Picard and
//! Newton iteration when it is not.
//!
//! ```text
//!   residual  ‖S(r − K(v)x)‖ / ‖S |K(v)||x|‖ over the free unknowns, S the nodal scaling
//! ```

use std::sync::Arc;

use space::{Dim, Dimension, Vector};

use crate::boundary::constraints::Constraints;
use crate::boundary::frame::velocity_of;
use crate::config::Nonlinear;
use crate::cost::{Cost, cpu_seconds};
use crate::equations::assembly::Assembly;
use crate::equations::coarse;
use crate::equations::coefficients::Coefficients;
use crate::equations::drive::{Border, Drive};
use crate::error::FluidError;
use crate::linear::iterative::Starts;
use crate::linear::method::Method;
use crate::linear::solver::Krylov;
use crate::linear::system::System;
use crate::mesh::simplices::Mesh;
use crate::numbers::{Numbers, named};
use crate::solid::SolidMatrix;
use crate::state::Flow;

/// Picard iterations before Newton takes over, and after a Newton step that made things worse.
const PICARD_FIRST: usize = 3;
/// A Newton step that multiplies the residual by more than this is followed by Picard steps.
const GROWTH_MAX: f64 = 2.0;
/// Tolerance and limit of a steady Picard iteration.
const STEADY_PICARD: (f64, usize) = (1e-8, 200);

/// Everything the last factorised matrix depended on. Equal keys: equal matrix, bit for bit.
pub struct MatrixKey<const D: usize> {
    solid: Arc<SolidMatrix>,
    rate: f64,
    convecting: Vec<(Flow<D>, f64)>,
}

/// The flows that convect, with their weights.
fn convecting<'a, const D: usize>(
    terms: &'a Coefficients<'_, D>,
) -> impl Iterator<Item = (&'a Flow<D>, f64)> {
    let carriers = terms.carriers.iter();
    let moving = carriers.filter(|carrier| carrier.convects != 0.0);
    moving.map(|carrier| (carrier.flow, carrier.convects))
}

impl<const D: usize> MatrixKey<D> {
    fn new(terms: &Coefficients<'_, D>) -> MatrixKey<D> {
        MatrixKey {
            solid: Arc::clone(&terms.solid.matrix),
            rate: terms.rate,
            convecting: convecting(terms)
                .map(|(flow, weight)| (flow.clone(), weight))
                .collect(),
        }
    }

    fn belongs_to(&self, terms: &Coefficients<'_, D>) -> bool {
        let own = self.convecting.iter().map(|(flow, weight)| (flow, *weight));
        self.rate == terms.rate && self.solid == terms.solid.matrix && own.eq(convecting(terms))
    }
}

/// How many solves a candidate took, and how good they are.
#[derive(Debug, Default, Clone, Copy)]
pub struct Effort {
    backward_error: f64,
    nonlinear_residual: f64,
    iterations: usize,
    factorised: usize,
    fallbacks: usize,
    solves: usize,
    krylov: Option<Krylov>,
}

impl Effort {
    /// As diagnostics; those of an iterative solver where that is one.
    pub fn numbers(&self) -> Numbers {
        let mut numbers = named([
            ("linear_residual", self.backward_error),
            ("nonlinear_residual", self.nonlinear_residual),
            ("iterations", self.iterations as f64),
            ("factorised", self.factorised as f64),
        ]);
        if self.krylov.is_none() {
            numbers.extend(named([
                ("linear_solves", self.solves as f64),
                ("factor_fallbacks", self.fallbacks as f64),
            ]));
        }
        numbers.extend(named(self.krylov.iter().flat_map(|krylov| {
            [
                ("krylov_iterations", krylov.iterations as f64),
                ("krylov_fallbacks", krylov.fallbacks as f64),
            ]
        })));
        numbers
    }

    fn note(&mut self, solution: &crate::linear::solver::Solution) {
        self.backward_error = self.backward_error.max(solution.backward_error);
        self.fallbacks += solution.fallbacks;
        self.solves += solution.solves;
        self.iterations += 1;
        if let Some(krylov) = solution.krylov {
            let sum = self.krylov.get_or_insert_default();
            sum.iterations += krylov.iterations;
            sum.fallbacks += krylov.fallbacks;
        }
    }
}

/// Unknowns that fulfil the equations.
pub struct Solution<const D: usize> {
    /// The components of u and p, node by node.
    pub unknowns: Vec<f64>,
    /// The uniform part of ∇p that steers the mean flow \[Pa/m\]; 0 where nothing does.
    pub driving: Vector<D>,
    /// The flow that convects, where it was found by iteration.
    pub convecting: Option<Flow<D>>,
    /// What it took.
    pub effort: Effort,
}

/// The pieces that a solve needs.
pub struct Equations<'a, const D: usize, const N: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// Its conditions.
    pub constraints: &'a Constraints<D>,
    /// The assembled system.
    pub system: &'a mut System<N>,
    /// How it is solved.
    pub linear: &'a mut Method<D, N>,
    /// What the factor belongs to.
    pub key: &'a mut Option<MatrixKey<D>>,
    /// Given unknowns.
    pub given: &'a [f64],
    /// ∮ N_i Q_n
    pub flux: &'a [f64],
    /// What an iterative solver may begin with: the accepted state, then the last iterate.
    pub starts: Option<Starts>,
    /// What the flow is to do on the whole, where that is steered.
    pub drive: Option<Drive<D>>,
    /// CPU time so far.
    pub cost: &'a mut Cost,
}

impl<const D: usize, const N: usize> Equations<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// One linear solve; the factor is reused when the matrix is the same.
    pub fn solve_once(&mut self, terms: &Coefficients<'_, D>) -> Result<Solution<D>, FluidError> {
        let mut effort = Effort::default();
        let same = self.key.as_ref().is_some_and(|key| key.belongs_to(terms));
        self.assemble(terms, !same);
        if !same {
            self.factorise(terms, &mut effort);
            *self.key = Some(MatrixKey::new(terms));
        }
        let (unknowns, driving) = self.solve(terms, &mut effort)?;
        Ok(Solution {
            unknowns,
            driving,
            convecting: None,
            effort,
        })
    }

    /// Picard and Newton iterations; afterwards the system holds K(v) and r at the solution.
    pub fn iterate(
        &mut self,
        terms: &Coefficients<'_, D>,
        start: &Flow<D>,
        nonlinear: Nonlinear,
    ) -> Result<Solution<D>, FluidError> {
        let (tolerance, iterations_max, newton) = match nonlinear {
            Nonlinear::Picard => (STEADY_PICARD.0, STEADY_PICARD.1, false),
            Nonlinear::Newton {
                tolerance,
                iterations_max,
            } => (tolerance, iterations_max, true),
        };
        let mut effort = Effort::default();
        let mut flow = start.clone();
        let mut found: Option<(Vec<f64>, Vector<D>)> = None;
        let mut picard_left = PICARD_FIRST;
        let mut residual = f64::INFINITY;
        for iteration in 0..=iterations_max {
            let carriers = terms.relay(&flow);
            let now = Coefficients {
                carriers: &carriers,
                ..*terms
            };
            self.assemble(&now, true);
            if let Some((unknowns, driving)) = found.take() {
                let last = residual;
                let right = self.push(&now, &driving);
                residual = self.linear.residual(self.system, &unknowns);
                tracing::debug!(iteration, residual, "nonlinear iteration");
                effort.nonlinear_residual = residual;
                if residual <= tolerance {
                    return Ok(Solution {
                        unknowns,
                        driving,
                        convecting: Some(flow),
                        effort,
                    });
                }
                self.system.right = right;
                if residual > GROWTH_MAX * last {
                    picard_left = PICARD_FIRST;
                }
            }
            if iteration == iterations_max {
                break;
            }
            let now = Coefficients {
                newton: newton && picard_left == 0,
                ..now
            };
            if now.newton {
                self.assemble(&now, true);
            }
            picard_left = picard_left.saturating_sub(1);
            self.factorise(&now, &mut effort);
            let (unknowns, driving) = self.solve(&now, &mut effort)?;
            if let Some(starts) = &mut self.starts {
                starts.last.clone_from(&unknowns);
            }
            flow = Flow {
                superficial_velocity: velocity_of(&unknowns, &self.constraints.frames),
                porosity: terms.solid.matrix.porosity.clone(),
            };
            found = Some((unknowns, driving));
        }
        Err(FluidError::NotConverged {
            residual,
            iterations: iterations_max,
            tolerance,
        })
    }

    fn assemble(&mut self, terms: &Coefficients<'_, D>, matrix_too: bool) {
        let begin = cpu_seconds();
        let assembly = Assembly {
            terms,
            mesh: self.mesh,
            constraints: self.constraints,
            flux: self.flux,
        };
        assembly.fill(self.system, matrix_too);
        self.cost.assembly += cpu_seconds() - begin;
    }

    fn factorise(&mut self, terms: &Coefficients<'_, D>, effort: &mut Effort) {
        let begin = cpu_seconds();
        *self.key = None;
        let mesh = self.mesh;
        let missing = |hierarchy: &_| coarse::missing(terms, mesh, hierarchy);
        self.linear.factorise(self.system, missing);
        effort.factorised += 1;
        self.cost.factor += cpu_seconds() - begin;
    }

    /// Unknowns and uniform pressure gradient of the assembled and factorised system, whose right-hand side
    /// holds that gradient afterwards.
    fn solve(
        &mut self,
        terms: &Coefficients<'_, D>,
        effort: &mut Effort,
    ) -> Result<(Vec<f64>, Vector<D>), FluidError> {
        let begin = cpu_seconds();
        let solved = self.steer(terms).and_then(|driving| {
            let starts = self.starts.as_ref();
            let solution = self.linear.solve(self.system, self.given, starts)?;
            Ok((solution, driving))
        });
        self.cost.solve += cpu_seconds() - begin;
        let (solution, driving) = solved?;
        effort.note(&solution);
        Ok((solution.unknowns, driving))
    }

    /// The uniform pressure gradient that gives the flow its mean, moved to the right-hand side.
    fn steer(&mut self, terms: &Coefficients<'_, D>) -> Result<Vector<D>, FluidError> {
        let Some(drive) = self.drive else {
            return Ok(Vector::zeros());
        };
        let border = Border::new(terms, self.mesh, &drive);
        let right = self.system.right.clone();
        let starts = self.starts.as_ref();
        let solution = self.linear.solve(self.system, self.given, starts)?;
        let start = solution.unknowns;
        let mut responses = [const { Vec::new() }; D];
        let still = vec![0.0; start.len()];
        for k in drive.steered() {
            self.system.right.clone_from(&border.columns[k]);
            responses[k] = self.linear.solve(self.system, &still, None)?.unknowns;
        }
        let gradient = border.gradient(&drive, &start, &responses);
        self.system.right = border.pushed(&right, &gradient);
        Ok(gradient)
    }

    /// Move this uniform pressure gradient to the right-hand side; returns what that was.
    fn push(&mut self, terms: &Coefficients<'_, D>, driving: &Vector<D>) -> Vec<f64> {
        let right = self.system.right.clone();
        if let Some(drive) = &self.drive {
            self.system.right = Border::new(terms, self.mesh, drive).pushed(&right, driving);
        }
        right
    }
}
