//! One step: the accepted state and the solid in, a candidate out; `commit` accepts it.
//!
//! ```text
//!   backward Euler   D_t v = (v − vⁿ)/Δt                              a = vⁿ
//!   BDF2, r = Δt/Δt⁻ D_t v = [(1+2r)/(1+r) v − (1+r) vⁿ + r²/(1+r) vⁿ⁻¹]/Δt
//!                                                                     a = (1+r) vⁿ − r vⁿ⁻¹
//!   steady           D_t v = 0                                        a = v, iterated
//! ```

use std::sync::Arc;

use crate::assembly::{System, turn_back};
use crate::boundary::{Constraints, resolve_names};
use crate::config::{FluidConfig, Nonlinear, TimeScheme};
use crate::cost::{Cost, cpu_seconds};
use crate::creeping::Creeping;
use crate::diagnostics::{Numbers, Powers, Solved};
use crate::error::FluidError;
use crate::linear::LinearSolver;
use crate::mesh::Mesh;
use crate::point::{Carrier, Coefficients};
use crate::solve::{Effort, Equations, MatrixKey};
use crate::state::{Flow, Solid, SolidFields, State, finite};

/// Which candidate is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step.
    pub pass: u32,
    /// Length of the step \[s\].
    pub dt: f64,
}

impl Request {
    /// The first pass of a step.
    pub fn first(step: u64, dt: f64) -> Request {
        Request { step, pass: 0, dt }
    }

    /// Is this a further pass of the same step? A repeated pass and a step of another length are not:
    /// they begin again.
    fn follows(&self, other: &Request) -> bool {
        self.step == other.step && self.dt == other.dt && self.pass > other.pass
    }
}

/// What `advance` computed.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// What was asked for.
    pub request: Request,
    /// The state at the end of the step.
    pub state: State,
    /// v_α = u_α/φ_α \[m/s\].
    pub interstitial_velocity: Vec<[f64; 2]>,
    /// ℓ_α⁻¹ ∫N_α ∇p \[Pa/m\].
    pub pressure_gradient: Vec<[f64; 2]>,
    /// Terms of the energy identity.
    pub powers: Powers,
    /// Force of the fluid on each boundary \[N/m\], in the order of the mesh's names.
    pub forces: Vec<[f64; 2]>,
    /// Named numbers.
    pub diagnostics: Numbers,
}

impl Candidate {
    /// A named number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.diagnostics
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| *value)
    }

    fn set_number(&mut self, name: &str, value: f64) {
        let found = self.diagnostics.iter_mut().find(|(known, _)| known == name);
        if let Some((_, number)) = found {
            *number = value;
        }
    }
}

/// The fluid engine.
pub struct FluidSolver {
    config: FluidConfig,
    mesh: Mesh,
    constraints: Constraints,
    system: System,
    linear: LinearSolver,
    pool: Arc<rayon::ThreadPool>,
    accepted: State,
    candidate: Option<Candidate>,
    key: Option<MatrixKey>,
    creeping: Creeping,
    /// CPU time since the last commit.
    cost: Cost,
}

/// Weights of the time derivative and of the extrapolation.
struct TimeWeights {
    /// α/Δt
    rate: f64,
    /// How vⁿ takes part: (convects, history).
    now: (f64, f64),
    /// How vⁿ⁻¹ takes part, if it does.
    before: Option<(f64, f64)>,
}

impl TimeWeights {
    fn new(scheme: TimeScheme, dt: f64, dt_before: Option<f64>) -> TimeWeights {
        match (scheme, dt_before) {
            (TimeScheme::Steady, _) => TimeWeights {
                rate: 0.0,
                now: (1.0, 0.0),
                before: None,
            },
            (TimeScheme::Bdf2, Some(dt_before)) => {
                let r = dt / dt_before;
                TimeWeights {
                    rate: (1.0 + 2.0 * r) / (1.0 + r) / dt,
                    now: (1.0 + r, (1.0 + r) / dt),
                    before: Some((-r, -r * r / (1.0 + r) / dt)),
                }
            }
            _ => TimeWeights {
                rate: 1.0 / dt,
                now: (1.0, 1.0 / dt),
                before: None,
            },
        }
    }
}

impl FluidSolver {
    /// A solver at its initial state.
    pub fn new(config: FluidConfig, mesh: Mesh) -> Result<FluidSolver, FluidError> {
        config.validate()?;
        let conditions = resolve_names(&config.boundaries, &mesh.boundary_names)?;
        let constraints = Constraints::new(&mesh, conditions, config.density, config.gravity)?;
        constraints.boundary_flux(&mesh, &constraints.values(&mesh, 0.0))?;
        let system = System::new(&mesh);
        let linear = LinearSolver::new(&system.pattern, &mesh.position, constraints.fixed.clone());
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(config.threads.max(1))
            .build();
        let pool = pool.map_err(|error| FluidError::Threads(error.to_string()))?;
        let pool = Arc::new(pool);
        let accepted = State::uniform(mesh.node_count(), config.initial_velocity);
        let (candidate, key) = (None, None);
        let creeping = Creeping::new(config.density, config.dynamic_viscosity, &mesh);
        Ok(FluidSolver {
            creeping,
            cost: Cost::default(),
            config,
            mesh,
            constraints,
            system,
            linear,
            pool,
            accepted,
            candidate,
            key,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The accepted state.
    pub fn state(&self) -> &State {
        &self.accepted
    }

    /// Replace the accepted state, e.g. by a checkpoint of the same mesh.
    pub fn set_state(&mut self, state: State) {
        self.accepted = state;
        self.candidate = None;
    }

    /// Compute a candidate from the accepted state, which stays as it is.
    pub fn advance(
        &mut self,
        request: &Request,
        fields: &SolidFields<'_>,
    ) -> Result<&Candidate, FluidError> {
        let last = self.candidate.take();
        let dt = request.dt;
        if !(dt > 0.0 && dt.is_finite()) {
            let why = "must be positive and finite";
            return Err(FluidError::Parameter {
                name: "dt",
                value: dt,
                why,
            });
        }
        let solid = Solid::new(fields, &self.mesh)?;
        let pool = Arc::clone(&self.pool);
        let further = last.filter(|last| request.follows(&last.request));
        let convected = further.map_or(self.accepted.convected, |last| last.state.convected);
        let candidate = pool.install(|| self.compute(request, &solid, convected))?;
        Ok(self.candidate.insert(candidate))
    }

    /// Accept the last candidate.
    pub fn commit(&mut self) -> Result<(), FluidError> {
        let candidate = self.candidate.take().ok_or(FluidError::NoCandidate)?;
        self.accepted = candidate.state;
        self.cost = Cost::default();
        Ok(())
    }

    fn compute(
        &mut self,
        request: &Request,
        solid: &Solid,
        convected: bool,
    ) -> Result<Candidate, FluidError> {
        let now = self.accepted.flow_with(&solid.matrix.porosity);
        let before = self.accepted.before.take();
        let result = self.compute_as_needed(request, &now, before.as_ref(), solid, convected);
        self.accepted.before = before;
        result
    }

    /// Is the convecting velocity found by iteration, not extrapolated?
    fn iterates(&self) -> bool {
        let FluidConfig {
            nonlinear,
            time_scheme,
            ..
        } = self.config;
        nonlinear != Nonlinear::Picard || time_scheme == TimeScheme::Steady
    }

    /// Without convection while the flow creeps; the first candidate that does not is computed
    /// again with it, and `convected` are later passes of its step, whose equations must not differ,
    /// and all steps after it.
    fn compute_as_needed(
        &mut self,
        request: &Request,
        now: &Flow,
        before: Option<&(Flow, f64)>,
        solid: &Solid,
        mut convected: bool,
    ) -> Result<Candidate, FluidError> {
        let bound = self
            .config
            .creeping_below
            .filter(|_| self.config.convection);
        if let (Some(bound), false) = (bound, convected) {
            let mut candidate = self.compute_from(request, now, before, solid, false)?;
            let reynolds = candidate.number("reynolds").unwrap_or(f64::INFINITY);
            if reynolds <= bound {
                return Ok(candidate);
            }
            let Request { step, pass, .. } = *request;
            tracing::info!(step, pass, reynolds, bound, "convection is there");
            convected = true;
            if before.is_none() && now.is_at_rest() && !self.iterates() {
                // Nothing convects in this step: it has been solved with all terms.
                candidate.state.convected = true;
                candidate.set_number("convection", 1.0);
                return Ok(candidate);
            }
        }
        let mut candidate =
            self.compute_from(request, now, before, solid, self.config.convection)?;
        candidate.state.convected = convected;
        Ok(candidate)
    }

    fn compute_from(
        &mut self,
        request: &Request,
        now: &Flow,
        before: Option<&(Flow, f64)>,
        solid: &Solid,
        convection: bool,
    ) -> Result<Candidate, FluidError> {
        let time = self.accepted.time + request.dt;
        let config = self.config.clone();
        let iterated = convection && self.iterates();
        let weights = TimeWeights::new(config.time_scheme, request.dt, before.map(|(_, dt)| *dt));
        let joins = |flow, (convects, history): (f64, f64)| {
            let convects = if convection { convects } else { 0.0 };
            Carrier {
                flow,
                convects,
                history,
            }
        };
        let mut carriers = vec![joins(now, weights.now)];
        carriers.extend(
            before
                .zip(weights.before)
                .map(|((flow, _), pair)| joins(flow, pair)),
        );
        let terms = Coefficients {
            density: config.density,
            dynamic_viscosity: config.dynamic_viscosity,
            gravity: config.gravity,
            viscous_form: config.viscous_form,
            grad_div: config.grad_div,
            rate: weights.rate,
            newton: false,
            body_force: config.body_force.as_deref(),
            time,
            carriers: &carriers,
            solid,
        };
        let given = self.constraints.values(&self.mesh, time);
        let flux = self.constraints.boundary_flux(&self.mesh, &given)?;
        let mut equations = Equations {
            mesh: &self.mesh,
            constraints: &self.constraints,
            system: &mut self.system,
            linear: &mut self.linear,
            key: &mut self.key,
            given: &given,
            flux: &flux,
            effort: Effort::default(),
            cost: &mut self.cost,
        };
        let (unknowns, last) = if iterated {
            let (unknowns, flow) = equations.iterate(&terms, now, config.nonlinear)?;
            (unknowns, Some(flow))
        } else {
            (equations.solve_once(&terms)?, None)
        };
        let effort = equations.effort;
        let relayed = last.as_ref().map(|flow| terms.relay(flow));
        let terms = Coefficients {
            carriers: relayed.as_deref().unwrap_or(&carriers),
            ..terms
        };
        self.finish(&terms, unknowns, &flux, &effort, (now, request), convection)
    }

    /// Fields and numbers from the unknowns.
    fn finish(
        &mut self,
        terms: &Coefficients<'_>,
        unknowns: Vec<f64>,
        flux: &[f64],
        effort: &Effort,
        (now, request): (&Flow, &Request),
        convection: bool,
    ) -> Result<Candidate, FluidError> {
        let velocity = velocity_of(&unknowns, &self.constraints.frames);
        let pressure: Vec<f64> = unknowns.iter().skip(2).step_by(3).copied().collect();
        finite(
            "superficial velocity",
            velocity.as_flattened(),
            2,
            &self.mesh,
        )?;
        finite("pressure", &pressure, 1, &self.mesh)?;
        let begin = cpu_seconds();
        let solved = Solved {
            terms,
            mesh: &self.mesh,
            constraints: &self.constraints,
            velocity: &velocity,
            pressure: &pressure,
            unknowns: &unknowns,
            reaction: &self.system.reaction(&unknowns),
            flux,
        };
        let powers = solved.powers();
        let forces: Vec<_> = (0..self.mesh.boundary_names.len())
            .map(|k| solved.force_on(k))
            .collect();
        let mut diagnostics = powers.numbers();
        diagnostics.extend(solved.inflow());
        diagnostics.extend(solved.wall_forces(&forces));
        diagnostics.extend(effort.numbers());
        let flow = Flow {
            superficial_velocity: velocity,
            porosity: terms.solid.matrix.porosity.clone(),
        };
        let reynolds = self.creeping.reynolds(&flow, &self.mesh);
        self.cost.powers += cpu_seconds() - begin;
        diagnostics.extend(self.cost.numbers());
        let interstitial_velocity = flow.interstitial_velocity();
        let pressure_gradient = self.mesh.averaged_gradient(&pressure);
        diagnostics.push(("reynolds".to_owned(), reynolds));
        diagnostics.push(("convection".to_owned(), f64::from(u8::from(convection))));
        let before = Some((now.clone(), request.dt));
        let state = State {
            convected: false,
            time: terms.time,
            fresh: false,
            now: flow,
            before,
            pressure,
        };
        Ok(Candidate {
            request: *request,
            state,
            interstitial_velocity,
            pressure_gradient,
            powers,
            forces,
            diagnostics,
        })
    }
}

/// Velocity of every node from the unknowns.
pub(crate) fn velocity_of(unknowns: &[f64], frames: &[Option<[f64; 2]>]) -> Vec<[f64; 2]> {
    let nodes = unknowns.chunks_exact(3).zip(frames);
    nodes
        .map(|(x, frame)| turn_back(*frame, [x[0], x[1]]))
        .collect()
}
