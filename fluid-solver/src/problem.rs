//! The discrete problem of one step, and the candidate made of its solution.

use space::{Dim, Dimension, Period, Vector, dot, hypot};

use crate::boundary::condition::resolve_names;
use crate::boundary::constraints::Constraints;
use crate::boundary::flux::BoundaryFlux;
use crate::boundary::frame::velocity_of;
use crate::candidate::{Candidate, Request};
use crate::config::{FluidConfig, Nonlinear, TimeScheme};
use crate::cost::{Cost, cpu_seconds};
use crate::diagnostics::solved::Solved;
use crate::equations::coefficients::Coefficients;
use crate::equations::creeping::Creeping;
use crate::equations::drive::Drive;
use crate::error::FluidError;
use crate::linear::hierarchy::Conditions;
use crate::linear::iterative::Starts;
use crate::linear::method::Method;
use crate::linear::system::System;
use crate::mesh::nested::Coarser;
use crate::mesh::simplices::Mesh;
use crate::numbers::named;
use crate::solid::{Solid, finite};
use crate::solve::{Equations, MatrixKey, Solution};
use crate::state::{Flow, State};
use crate::time_scheme::TimeWeights;

/// What a step begins with.
pub struct Step<'a, const D: usize> {
    request: Request,
    /// Time at its end \[s\].
    time: f64,
    /// vⁿ
    now: Flow<D>,
    /// vⁿ⁻¹, and how long the step after it was \[s\].
    before: Option<&'a (Flow<D>, f64)>,
    /// pⁿ
    pressure: &'a [f64],
    solid: Solid<D>,
}

impl<'a, const D: usize> Step<'a, D> {
    /// From the accepted state; an initial state takes the porosity of the solid.
    pub fn new(
        accepted: &'a State<D>,
        request: &Request,
        solid: Solid<D>,
    ) -> Result<Step<'a, D>, FluidError> {
        let dt = request.dt;
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(FluidError::Parameter {
                name: "dt",
                value: dt,
                why: "must be positive and finite",
            });
        }
        Ok(Step {
            request: *request,
            time: accepted.time + dt,
            now: accepted.flow_with(&solid.matrix.porosity),
            before: accepted.before.as_ref(),
            pressure: &accepted.pressure,
            solid,
        })
    }

    /// The unknowns of the accepted state.
    fn unknowns(&self, constraints: &Constraints<D>) -> Vec<f64> {
        let velocity = self.now.superficial_velocity.iter();
        let nodes = velocity.zip(self.pressure).zip(&constraints.frames);
        let mut unknowns = Vec::with_capacity((D + 1) * self.pressure.len());
        for ((velocity, &pressure), frame) in nodes {
            let first = unknowns.len();
            unknowns.extend(velocity.iter());
            unknowns.push(pressure);
            if let Some(frame) = frame {
                frame.turn(&mut unknowns[first..]);
            }
        }
        unknowns
    }

    /// Does it begin at rest, so that an extrapolated velocity convects nothing?
    fn begins_at_rest(&self) -> bool {
        self.before.is_none() && self.now.is_at_rest()
    }
}

/// Mesh, conditions, and the linear system on them.
pub struct Problem<const D: usize, const N: usize> {
    config: FluidConfig<D>,
    /// The mesh.
    pub mesh: Mesh<D, N>,
    constraints: Constraints<D>,
    system: System<N>,
    linear: Method<D, N>,
    key: Option<MatrixKey<D>>,
    drive: Option<Drive<D>>,
    creeping: Creeping,
    /// CPU time since the last commit.
    cost: Cost,
}

impl<const D: usize, const N: usize> Problem<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// The problem of a fluid on a mesh, with coarser ones under it.
    pub fn new(
        config: FluidConfig<D>,
        mesh: Mesh<D, N>,
        coarser: &[Coarser<D, N>],
    ) -> Result<Problem<D, N>, FluidError> {
        let conditions = resolve_names(&config.boundaries, &mesh.boundary_names)?;
        let constraints = Constraints::new(&mesh, conditions, config.density, &config.gravity)?;
        constraints.boundary_flux(&mesh, 0.0)?;
        let system = System::new(mesh.node_count(), &mesh.simplices);
        Ok(Problem {
            linear: method(&config, &mesh, &constraints, coarser, &system)?,
            creeping: Creeping::new(config.density, config.dynamic_viscosity, &mesh),
            cost: Cost::default(),
            key: None,
            drive: drive(&config, &mesh.period)?,
            config,
            mesh,
            constraints,
            system,
        })
    }

    /// What holds at the boundary.
    pub fn constraints(&self) -> &Constraints<D> {
        &self.constraints
    }

    /// What it was made with.
    pub fn config(&self) -> &FluidConfig<D> {
        &self.config
    }

    /// Count costs from now on.
    pub fn forget_cost(&mut self) {
        self.cost.forget();
    }

    /// A new mesh has cost so much \[s\].
    pub fn add_cost_of_mesh(&mut self, seconds: f64) {
        *self.cost.mesh.get_or_insert(0.0) += seconds;
    }

    /// May its mesh become another one, or has it?
    pub fn mesh_may_change(&self) -> bool {
        self.cost.mesh.is_some()
    }

    /// A step without convection while the flow creeps; the first candidate that does not is solved
    /// again with it, and `convected` are later passes of its step, whose equations must not differ,
    /// and all steps after it.
    pub fn solve(
        &mut self,
        step: &Step<'_, D>,
        convected: bool,
    ) -> Result<Candidate<D>, FluidError> {
        let FluidConfig {
            convection,
            creeping_below,
            ..
        } = self.config;
        let bound = creeping_below.filter(|_| convection);
        if let (Some(bound), false) = (bound, convected) {
            let candidate = self.candidate(step, false)?;
            if candidate.reynolds <= bound {
                return Ok(marked(candidate, false, false));
            }
            let Request {
                step: number, pass, ..
            } = step.request;
            let reynolds = candidate.reynolds;
            tracing::debug!(step = number, pass, reynolds, bound, "convection is there");
            if step.begins_at_rest() && !self.iterates() {
                // Nothing convects in this step: it has been solved with all terms.
                return Ok(marked(candidate, true, true));
            }
        }
        let candidate = self.candidate(step, convection)?;
        Ok(marked(candidate, convection, convected || bound.is_some()))
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

    fn candidate(
        &mut self,
        step: &Step<'_, D>,
        convection: bool,
    ) -> Result<Candidate<D>, FluidError> {
        let iterated = convection && self.iterates();
        let config = &self.config;
        let dt_before = step.before.map(|(_, dt)| *dt);
        let weights = TimeWeights::new(config.time_scheme, step.request.dt, dt_before);
        let carriers = weights.carriers(&step.now, step.before, convection);
        let terms = Coefficients {
            density: config.density,
            dynamic_viscosity: config.dynamic_viscosity,
            gravity: config.gravity,
            viscous_form: config.viscous_form,
            grad_div: config.grad_div,
            rate: weights.rate,
            newton: false,
            body_force: config.body_force.as_deref(),
            time: step.time,
            carriers: &carriers,
            solid: &step.solid,
        };
        let given = self.constraints.values(&self.mesh, step.time);
        let flux = self.constraints.boundary_flux(&self.mesh, step.time)?;
        let starts = (self.linear.begins()).then(|| Starts {
            rest: hydrostatic(config, &self.mesh),
            last: step.unknowns(&self.constraints),
        });
        let mut equations = Equations {
            mesh: &self.mesh,
            constraints: &self.constraints,
            system: &mut self.system,
            linear: &mut self.linear,
            key: &mut self.key,
            given: &given,
            flux: &flux.of_node,
            starts,
            drive: self.drive,
            cost: &mut self.cost,
        };
        let solution = if iterated {
            equations.iterate(&terms, &step.now, config.nonlinear)?
        } else {
            equations.solve_once(&terms)?
        };
        let relayed = solution.convecting.as_ref().map(|flow| terms.relay(flow));
        let terms = Coefficients {
            carriers: relayed.as_deref().unwrap_or(&carriers),
            ..terms
        };
        let (candidate, cost) = self.finish(step, &terms, &solution, &flux)?;
        self.cost.powers += cost;
        Ok(with_costs(candidate, &self.cost))
    }

    /// ℓ⁻¹ ∫N ∇p by node, the uniform part that steers the mean flow included.
    fn pressure_gradient(&self, pressure: &[f64], driving: &Vector<D>) -> Vec<Vector<D>> {
        let mut gradient = self.mesh.averaged_gradient(pressure);
        if self.drive.is_some() {
            gradient.iter_mut().for_each(|g| *g += driving);
        }
        gradient
    }

    /// Fields and numbers of a solution, and what the numbers cost \[s\].
    fn finish(
        &self,
        step: &Step<'_, D>,
        terms: &Coefficients<'_, D>,
        solution: &Solution<D>,
        flux: &BoundaryFlux,
    ) -> Result<(Candidate<D>, f64), FluidError> {
        let unknowns = &solution.unknowns;
        let velocity = velocity_of(unknowns, &self.constraints.frames);
        let pressure: Vec<f64> = unknowns.iter().skip(D).step_by(N).copied().collect();
        let numbers = space::flat::numbers(&velocity);
        finite("superficial velocity", numbers, D, &self.mesh)?;
        finite("pressure", &pressure, 1, &self.mesh)?;
        let begin = cpu_seconds();
        let solved = Solved {
            terms,
            mesh: &self.mesh,
            constraints: &self.constraints,
            velocity: &velocity,
            pressure: &pressure,
            unknowns,
            reaction: &self.system.reaction(unknowns),
            flux,
            drive: self.drive,
            driving: solution.driving,
        };
        let (powers, forces) = (solved.powers(), solved.forces());
        let mut diagnostics = powers.numbers();
        diagnostics.extend(solved.through_flow());
        diagnostics.extend(solved.mean_pressure_gradient());
        diagnostics.extend(solved.wall_forces(&forces));
        diagnostics.extend(solution.effort.numbers());
        let now = Flow {
            superficial_velocity: velocity,
            porosity: step.solid.matrix.porosity.clone(),
        };
        let reynolds = self.creeping.reynolds(&now, &self.mesh);
        let cost = cpu_seconds() - begin;
        let candidate = Candidate {
            request: step.request,
            interstitial_velocity: now.interstitial_velocity(),
            pressure_gradient: self.pressure_gradient(&pressure, &solution.driving),
            powers,
            forces,
            reynolds,
            convects: false,
            diagnostics,
            state: State {
                time: step.time,
                fresh: false,
                now,
                before: Some((step.now.clone(), step.request.dt)),
                pressure,
                convected: false,
                mesh_change: None,
            },
        };
        Ok((candidate, cost))
    }
}

/// How the systems on a mesh are solved. A coarser mesh on which the conditions cannot be had ends the list.
fn method<const D: usize, const N: usize>(
    config: &FluidConfig<D>,
    mesh: &Mesh<D, N>,
    constraints: &Constraints<D>,
    coarser: &[Coarser<D, N>],
    system: &System<N>,
) -> Result<Method<D, N>, FluidError>
where
    Dim<D>: Dimension<D>,
{
    let held = |level: &Coarser<D, N>| -> Result<Constraints<D>, FluidError> {
        let conditions = resolve_names(&config.boundaries, &level.mesh.boundary_names)?;
        Constraints::new(&level.mesh, conditions, config.density, &config.gravity)
    };
    let held: Vec<_> = coarser.iter().map_while(|level| held(level).ok()).collect();
    let levels = coarser.iter().zip(&held).map(|(level, constraints)| {
        let mesh = &level.mesh;
        (Conditions { mesh, constraints }, level.spots.as_slice())
    });
    let levels: Vec<_> = levels.collect();
    Method::new(system, &Conditions { mesh, constraints }, &levels)
}

/// The unknowns of fluid at rest: p = ρ g·x.
fn hydrostatic<const D: usize, const N: usize>(
    config: &FluidConfig<D>,
    mesh: &Mesh<D, N>,
) -> Vec<f64> {
    let mut unknowns = vec![0.0; N * mesh.node_count()];
    for (values, position) in unknowns.chunks_exact_mut(N).zip(&mesh.position) {
        values[D] = config.density * dot(&config.gravity, position);
    }
    unknowns
}

/// What the configuration asks of the mean flow through periodic sides.
fn drive<const D: usize>(
    config: &FluidConfig<D>,
    period: &Period<D>,
) -> Result<Option<Drive<D>>, FluidError> {
    let Some(velocity) = config.mean_flow else {
        return Ok(None);
    };
    let axes = period.map(|period| period.is_some());
    let parameter = |value: f64, why: &'static str| FluidError::Parameter {
        name: "mean_flow",
        value,
        why,
    };
    if !axes.contains(&true) {
        let why = "no side is periodic, so what flows in says what flows through: leave it out";
        return Err(parameter(hypot(&velocity), why));
    }
    let across = (0..D).find(|&k| !axes[k] && velocity[k] != 0.0);
    match across {
        None => Ok(Some(Drive { velocity, axes })),
        Some(k) => {
            let why = "must be 0 along an axis whose sides are not periodic";
            Err(parameter(velocity[k], why))
        }
    }
}

fn with_costs<const D: usize>(mut candidate: Candidate<D>, cost: &Cost) -> Candidate<D> {
    candidate.diagnostics.extend(cost.numbers());
    candidate
}

/// Say whether convection was there, and whether it is from now on.
fn marked<const D: usize>(
    mut candidate: Candidate<D>,
    convects: bool,
    convected: bool,
) -> Candidate<D> {
    candidate.convects = convects;
    candidate.state.convected = convected;
    let numbers = [
        ("reynolds", candidate.reynolds),
        ("convection", f64::from(u8::from(convects))),
    ];
    candidate.diagnostics.extend(named(numbers));
    candidate
}
