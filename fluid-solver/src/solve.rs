//! The equations of one step, solved: once when the convecting velocity is known, by Picard and
//! Newton iteration when it is not.
//!
//! ```text
//!   residual  ‖S(r − K(v)x)‖ / ‖S |K(v)||x|‖ over the free unknowns, S the nodal scaling
//! ```

use crate::assembly::System;
use crate::boundary::Constraints;
use crate::config::Nonlinear;
use crate::cost::{Cost, cpu_seconds};
use crate::diagnostics::{Numbers, named};
use crate::error::FluidError;
use crate::linear::LinearSolver;
use crate::mesh::Mesh;
use crate::point::{Carrier, Coefficients};
use crate::state::{Flow, SolidMatrix};
use crate::step::velocity_of;

/// Picard iterations before Newton takes over, and after a Newton step that made things worse.
const PICARD_FIRST: usize = 3;
/// A Newton step that multiplies the residual by more than this is followed by Picard steps.
const GROWTH_MAX: f64 = 2.0;
/// Tolerance and limit of a steady Picard iteration.
const STEADY_PICARD: (f64, usize) = (1e-8, 200);

/// Everything the last factorised matrix depended on. Equal keys: equal matrix, bit for bit.
#[derive(PartialEq)]
pub struct MatrixKey {
    solid: SolidMatrix,
    rate: f64,
    convecting: Vec<(Flow, f64)>,
}

impl MatrixKey {
    fn new(terms: &Coefficients<'_>) -> MatrixKey {
        let convecting = terms
            .carriers
            .iter()
            .filter(|carrier| carrier.convects != 0.0);
        MatrixKey {
            solid: terms.solid.matrix.clone(),
            rate: terms.rate,
            convecting: convecting.map(|c| (c.flow.clone(), c.convects)).collect(),
        }
    }
}

/// How many solves a candidate took, and how good they are.
#[derive(Debug, Default, Clone, Copy)]
pub struct Effort {
    backward_error: f64,
    nonlinear_residual: f64,
    iterations: usize,
    factorised: usize,
    pivoted: bool,
}

impl Effort {
    /// As diagnostics.
    pub fn numbers(&self) -> Numbers {
        named([
            ("linear_residual", self.backward_error),
            ("nonlinear_residual", self.nonlinear_residual),
            ("iterations", self.iterations as f64),
            ("factorised", self.factorised as f64),
            ("pivoted", f64::from(u8::from(self.pivoted))),
        ])
    }
}

/// The pieces that a solve needs, and what came of them.
pub struct Equations<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its conditions.
    pub constraints: &'a Constraints,
    /// The assembled system.
    pub system: &'a mut System,
    /// The factor.
    pub linear: &'a mut LinearSolver,
    /// What the factor belongs to.
    pub key: &'a mut Option<MatrixKey>,
    /// Given unknowns.
    pub given: &'a [f64],
    /// ∮ N_i Q_n
    pub flux: &'a [f64],
    /// Solves so far.
    pub effort: Effort,
    /// CPU time so far.
    pub cost: &'a mut Cost,
}

impl Equations<'_> {
    /// One linear solve; the factor is reused when the matrix is the same.
    pub fn solve_once(&mut self, terms: &Coefficients<'_>) -> Result<Vec<f64>, FluidError> {
        let key = MatrixKey::new(terms);
        let same = self.key.as_ref() == Some(&key);
        self.assemble(terms, !same);
        if !same {
            self.factorise();
            *self.key = Some(key);
        }
        self.effort.iterations = 1;
        self.solve()
    }

    /// Picard and Newton iterations; afterwards the system holds K(v) and r at the solution.
    pub fn iterate(
        &mut self,
        terms: &Coefficients<'_>,
        start: &Flow,
        nonlinear: Nonlinear,
    ) -> Result<(Vec<f64>, Flow), FluidError> {
        let (tolerance, iterations_max, newton) = match nonlinear {
            Nonlinear::Picard => (STEADY_PICARD.0, STEADY_PICARD.1, false),
            Nonlinear::Newton {
                tolerance,
                iterations_max,
            } => (tolerance, iterations_max, true),
        };
        let mut flow = start.clone();
        let mut unknowns: Option<Vec<f64>> = None;
        let mut picard_left = PICARD_FIRST;
        let mut residual = f64::INFINITY;
        for iteration in 0..=iterations_max {
            let carriers = terms.relay(&flow);
            let now = Coefficients {
                carriers: &carriers,
                ..*terms
            };
            self.assemble(&now, true);
            if let Some(x) = unknowns.take() {
                let last = residual;
                residual = self.linear.residual(self.system, &x);
                tracing::debug!(iteration, residual, "nonlinear iteration");
                self.effort.nonlinear_residual = residual;
                if residual <= tolerance {
                    return Ok((x, flow));
                }
                if residual > GROWTH_MAX * last {
                    picard_left = PICARD_FIRST;
                }
            }
            if iteration == iterations_max {
                break;
            }
            if newton && picard_left == 0 {
                self.assemble(
                    &Coefficients {
                        newton: true,
                        ..now
                    },
                    true,
                );
            }
            picard_left = picard_left.saturating_sub(1);
            self.factorise();
            let x = self.solve()?;
            self.effort.iterations += 1;
            flow = Flow {
                superficial_velocity: velocity_of(&x, &self.constraints.frames),
                porosity: terms.solid.matrix.porosity.clone(),
            };
            unknowns = Some(x);
        }
        Err(FluidError::NotConverged {
            residual,
            iterations: iterations_max,
            tolerance,
        })
    }

    fn assemble(&mut self, terms: &Coefficients<'_>, matrix_too: bool) {
        let begin = cpu_seconds();
        self.system
            .assemble(terms, self.mesh, self.constraints, self.flux, matrix_too);
        self.cost.assembly += cpu_seconds() - begin;
    }

    fn factorise(&mut self) {
        let begin = cpu_seconds();
        *self.key = None;
        self.linear.factorise(self.system);
        self.effort.factorised += 1;
        self.cost.factor += cpu_seconds() - begin;
    }

    fn solve(&mut self) -> Result<Vec<f64>, FluidError> {
        let begin = cpu_seconds();
        let solved = self.linear.solve(self.system, self.given);
        self.cost.solve += cpu_seconds() - begin;
        let solution = solved?;
        self.effort.backward_error = self.effort.backward_error.max(solution.backward_error);
        self.effort.pivoted |= solution.pivoted;
        Ok(solution.unknowns)
    }
}

impl Coefficients<'_> {
    /// The carriers with `flow` convecting in place of the extrapolation.
    pub fn relay<'f>(&self, flow: &'f Flow) -> Vec<Carrier<'f>>
    where
        Self: 'f,
    {
        let still = self.carriers.iter().map(|carrier| Carrier {
            convects: 0.0,
            ..*carrier
        });
        let moving = Carrier {
            flow,
            convects: 1.0,
            history: 0.0,
        };
        still
            .filter(|carrier| carrier.history != 0.0)
            .chain(std::iter::once(moving))
            .collect()
    }
}
