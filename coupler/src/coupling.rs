//! The coupled system: its engines, its accepted state, and one step of it.

use protocol::configure::{CouplerScene, Geometry, Scheme};
use protocol::engine::InitialGrains;
use protocol::messages::{Hello, Role};
use protocol::partner::Partner;

use crate::budget::{self, Budget};
use crate::drag::{self, Shape};
use crate::engines::{FluidSeat, GrainCandidate, ParticleSeat, Request};
use crate::error::CouplerError;
use crate::proximity;
use crate::response::{self, FluidState, Model, NodalResponse};
use crate::scheme::{Outcome, TOUCHES};
use crate::transfer::{Placement, Transfer};

/// Deposited fields keep the lumped mass up to this ratio of grain diameter to cell size.
pub const LUMPED_RATIO_MAX: f64 = 0.25;

/// Contact residual wished for, of the tolerance of the passes: errors of all contacts below a grain
/// add up in it, so a held bed is as still as its contact solve is exact.
const CONTACT_SHARE: f64 = 0.001;

/// The accepted grains. Vectors are interleaved.
#[derive(Debug, Clone, Default)]
pub struct GrainState {
    /// xⁿ \[m\]
    pub position: Vec<f64>,
    /// vⁿ \[m/s\]
    pub velocity: Vec<f64>,
    /// v̄ of the last step \[m/s\]
    pub mean_velocity: Vec<f64>,
    /// 0 free, 1 touches, 2 held; where the fluid does not feel the grains it is known after
    /// [`Coupling::contact_states`]
    pub contact: Vec<f64>,
    /// Mean contact force of the last step \[N\]
    pub contact_force: Vec<f64>,
    /// γ r of the last step, owed to the fluid \[N\]
    pub carried: Vec<f64>,
    /// m \[kg\]
    pub mass: Vec<f64>,
    /// V \[m³\]
    pub volume: Vec<f64>,
    /// Radii \[m\]
    pub radius: Vec<f64>,
    /// Never moves
    pub fixed: Vec<bool>,
}

/// Choices of the scheme that only its own tests change.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// λ of every grain that is not held; none: 1.
    pub lambda: Option<f64>,
    /// Apply the deferred correction.
    pub deferred_correction: bool,
    /// Accept a first pass with the correction of the last step.
    pub lagged_correction: bool,
}

/// What one accepted step did.
#[derive(Debug, Clone, Default)]
pub struct StepReport {
    /// Its length \[s\].
    pub dt: f64,
    /// Fluid solves.
    pub passes: u32,
    /// Sub-steps of the grains.
    pub sub_steps: u32,
    /// Interaction defect of the pass accepted.
    pub interaction_defect: f64,
    /// Balances.
    pub budget: Budget,
}

/// The coupled system.
pub struct Coupling {
    pub(crate) scene: CouplerScene,
    /// The fluid's seat, if the scene has a fluid.
    pub fluid: Option<FluidSeat>,
    /// The grains' seat, if the scene has grains.
    pub particles: Option<ParticleSeat>,
    transfer: Option<Transfer>,
    shapes: Vec<Shape>,
    /// Accepted grains.
    pub grains: GrainState,
    /// Accepted nodal fields of the fluid.
    pub fluid_state: FluidState,
    /// Porosity of the last accepted step.
    pub porosity: Vec<f64>,
    /// Accepted time \[s\].
    pub time: f64,
    /// Accepted steps.
    pub step: u64,
    /// For tests of the scheme.
    pub options: Options,
}

impl Coupling {
    /// Configure the engines and take over their initial state.
    pub fn new(
        scene: CouplerScene,
        fluid: Option<Partner>,
        particles: Option<Partner>,
        grains: &InitialGrains,
    ) -> Result<Coupling, CouplerError> {
        let fluid = match (fluid, &scene.fluid) {
            (Some(partner), Some(part)) => {
                Some(FluidSeat::new(partner, part, scene.unread(Role::Fluid))?)
            }
            _ => None,
        };
        let particles = match (particles, &scene.particles) {
            (Some(partner), Some(part)) => {
                let unread = scene.unread(Role::Particles);
                Some(ParticleSeat::new(partner, part, grains, unread)?)
            }
            (None, Some(_)) if scene.grains_stay => Some(ParticleSeat::fixed(grains)),
            _ => None,
        };
        let state = particles
            .as_ref()
            .map_or_else(GrainState::default, |seat| initial_state(&seat.grains));
        let transfer = fluid
            .as_ref()
            .map(|seat| new_transfer(&scene, seat, &state.radius))
            .transpose()?;
        let mut coupling = Coupling {
            shapes: shapes(scene.geometry, &state.radius),
            scene,
            fluid,
            particles,
            transfer,
            grains: state,
            fluid_state: FluidState::default(),
            porosity: Vec::new(),
            time: 0.0,
            step: 0,
            options: Options {
                lambda: None,
                deferred_correction: true,
                lagged_correction: true,
            },
        };
        coupling.set_initial_fluid()?;
        Ok(coupling)
    }

    /// Fluid at its initial velocity, pressure hydrostatic.
    fn set_initial_fluid(&mut self) -> Result<(), CouplerError> {
        let Some(scene) = &self.scene.fluid else {
            return Ok(());
        };
        let nodes = self.transfer().node_count();
        let (superficial, density, gravity) =
            (scene.initial_velocity, scene.density, scene.gravity);
        self.porosity = vec![1.0; nodes];
        if self.particles.is_some() && self.scene.reaction {
            self.porosity = self.porosity(&self.place(0.0)?)?;
        }
        self.fluid_state = FluidState {
            velocity: (0..2 * nodes)
                .map(|k| superficial[k % 2] / self.porosity[k / 2])
                .collect(),
            pressure_gradient: (0..2 * nodes).map(|k| density * gravity[k % 2]).collect(),
        };
        Ok(())
    }

    /// The scene that is run.
    pub fn scene(&self) -> &CouplerScene {
        &self.scene
    }

    /// Who takes part.
    pub fn hellos(&self) -> Vec<Hello> {
        let fluid = self.fluid.as_ref().map(|seat| seat.hello().clone());
        let particles = self
            .particles
            .as_ref()
            .and_then(|seat| seat.hello().cloned());
        fluid.into_iter().chain(particles).collect()
    }

    /// Advance the accepted state by dt \[s\].
    pub fn advance(&mut self, dt: f64) -> Result<StepReport, CouplerError> {
        let report = match (self.fluid.is_some(), self.particles.is_some()) {
            (true, true) if self.scene.reaction => {
                let outcome = self.coupled_step(dt)?;
                self.accept_coupled(outcome, dt)?
            }
            (true, true) => self.one_way_step(dt)?,
            (true, false) => self.fluid_step(dt)?,
            (false, true) => self.dry_step(dt)?,
            (false, false) => StepReport::default(),
        };
        let step = self.step + 1;
        if let Some(seat) = &mut self.fluid {
            seat.partner().commit(step)?;
        }
        if let Some(partner) = self.particles.as_mut().and_then(ParticleSeat::partner) {
            partner.commit(step)?;
        }
        self.step = step;
        self.time += dt;
        Ok(report)
    }

    fn accept_coupled(&mut self, outcome: Outcome, dt: f64) -> Result<StepReport, CouplerError> {
        self.check_finite(&outcome.grains.position, "a grain's position")?;
        self.check_finite(&outcome.fluid.velocity, "the fluid's velocity")?;
        let budget = budget::of_coupled_step(self, &outcome, dt);
        let report = StepReport {
            dt,
            passes: outcome.passes,
            sub_steps: outcome.grains.sub_steps,
            interaction_defect: outcome.defect.relative,
            budget,
        };
        self.grains.contact_force = self.contact_force(&outcome, dt);
        self.grains.carried = outcome.carried;
        self.take_grains(outcome.grains);
        self.fluid_state = outcome.fluid;
        self.porosity = outcome.fields.porosity;
        Ok(report)
    }

    /// The fluid does not feel the grains: solve it alone, then move the grains in it.
    fn one_way_step(&mut self, dt: f64) -> Result<StepReport, CouplerError> {
        let request = self.request(1, dt);
        let fluid = self.solve_fluid(&request, None)?;
        let placement = self.place(dt)?;
        let porosity = vec![1.0; self.transfer().node_count()];
        self.fluid_state = fluid;
        let drag = self.drag_coefficients(&placement, &porosity, Some(dt));
        let model = self.free_model(drag, dt, 1);
        let force = self.grain_force(&placement, &self.fluid_state, &model);
        let candidate = self.move_grains(&request, &model.drag, &force, 0)?;
        self.check_finite(&candidate.position, "a grain's position")?;
        let sub_steps = candidate.sub_steps;
        self.take_grains(candidate);
        Ok(StepReport {
            dt,
            passes: 1,
            sub_steps,
            ..StepReport::default()
        })
    }

    fn fluid_step(&mut self, dt: f64) -> Result<StepReport, CouplerError> {
        let request = self.request(1, dt);
        self.fluid_state = self.solve_fluid(&request, None)?;
        self.check_finite(&self.fluid_state.velocity, "the fluid's velocity")?;
        Ok(StepReport {
            dt,
            passes: 1,
            ..StepReport::default()
        })
    }

    fn dry_step(&mut self, dt: f64) -> Result<StepReport, CouplerError> {
        let request = self.request(1, dt);
        let tolerance = self.contact_tolerance();
        let seat = self.particles.as_mut().expect("a dry scene has grains");
        let candidate = seat.advance(&request, None, 0, tolerance)?;
        self.check_finite(&candidate.position, "a grain's position")?;
        let sub_steps = candidate.sub_steps;
        self.take_grains(candidate);
        Ok(StepReport {
            dt,
            passes: 1,
            sub_steps,
            ..StepReport::default()
        })
    }

    /// Grains on the mesh at xⁿ + ½Δt vⁿ: the mid-point removes the first-order spiral of grains
    /// that follow curved streamlines.
    pub(crate) fn place(&self, dt: f64) -> Result<Placement, CouplerError> {
        let grains = &self.grains;
        let middle: Vec<f64> = grains
            .position
            .iter()
            .zip(&grains.velocity)
            .map(|(x, v)| x + 0.5 * dt * v)
            .collect();
        self.transfer().place(&middle)
    }

    /// φ = 1 − T(V); an error names the first node where it is not positive.
    pub(crate) fn porosity(&self, placement: &Placement) -> Result<Vec<f64>, CouplerError> {
        let mut porosity = self
            .transfer()
            .deposit(placement, |i| self.grains.volume[i]);
        porosity.iter_mut().for_each(|value| *value = 1.0 - *value);
        match porosity
            .iter()
            .position(|value| value.is_nan() || *value <= 0.0)
        {
            Some(node) => {
                let [x, y] = self.transfer().node_position(node);
                Err(CouplerError::Porosity {
                    node,
                    porosity: porosity[node],
                    x,
                    y,
                })
            }
            None => Ok(porosity),
        }
    }

    /// γ of every grain, with the slip that the drag itself decides over `dt` (D7); none: with the
    /// slip of the start.
    pub(crate) fn drag_coefficients(
        &self,
        placement: &Placement,
        porosity: &[f64],
        dt: Option<f64>,
    ) -> Vec<f64> {
        let (grains, gravity) = (&self.grains, self.scene.gravity);
        let scene = self.scene.fluid.as_ref().expect("drag needs a fluid");
        let fluid = drag::Fluid {
            density: scene.density,
            dynamic_viscosity: scene.dynamic_viscosity,
        };
        let local_porosity = self.transfer().sample(placement, porosity);
        let velocity = self
            .transfer()
            .sample_vector(placement, &self.fluid_state.velocity);
        let gradient = self
            .transfer()
            .sample_vector(placement, &self.fluid_state.pressure_gradient);
        let coefficient = |i: usize| {
            let slip = [0, 1].map(|axis| grains.velocity[2 * i + axis] - velocity[2 * i + axis]);
            let bounded = local_porosity[i].clamp(drag::POROSITY_RANGE[0], drag::POROSITY_RANGE[1]);
            let speed = match dt.filter(|_| !grains.fixed[i]) {
                None => slip[0].hypot(slip[1]),
                Some(dt) => {
                    let inertia = grains.mass[i] / dt;
                    let drive = [0, 1].map(|axis| {
                        let k = 2 * i + axis;
                        inertia * slip[axis] + grains.mass[i] * gravity[axis]
                            - grains.volume[i] * gradient[k]
                            + grains.contact_force[k]
                    });
                    drag::implicit_slip_speed(
                        self.scene.drag,
                        &fluid,
                        bounded,
                        &self.shapes[i],
                        inertia,
                        drive[0].hypot(drive[1]),
                    )
                }
            };
            drag::coefficient(self.scene.drag, &fluid, bounded, speed, &self.shapes[i])
        };
        (0..grains.count()).map(coefficient).collect()
    }

    /// The model of grains that meet no contact: λ = 1, z = S vⁿ + D m g.
    pub(crate) fn free_model(&self, drag: Vec<f64>, dt: f64, sub_steps: u32) -> Model {
        let grains = &self.grains;
        let count = grains.count();
        let mut model = Model {
            volume: grains.volume.clone(),
            mobility: vec![0.0; count],
            lambda: vec![1.0; count],
            free_velocity: vec![0.0; 2 * count],
            drag,
        };
        for i in (0..count).filter(|&i| !grains.fixed[i]) {
            let (keep, mobility) =
                response::free_response(grains.mass[i], model.drag[i], dt, sub_steps.max(1));
            model.mobility[i] = mobility;
            for axis in 0..2 {
                let k = 2 * i + axis;
                model.free_velocity[k] = keep * grains.velocity[k]
                    + mobility * grains.mass[i] * self.scene.gravity[axis];
            }
        }
        model
    }

    /// q = γ N w − V N G \[N\], interleaved (S3).
    pub(crate) fn grain_force(
        &self,
        placement: &Placement,
        fluid: &FluidState,
        model: &Model,
    ) -> Vec<f64> {
        let velocity = self.transfer().sample_vector(placement, &fluid.velocity);
        let gradient = self
            .transfer()
            .sample_vector(placement, &fluid.pressure_gradient);
        (0..velocity.len())
            .map(|k| model.drag[k / 2] * velocity[k] - model.volume[k / 2] * gradient[k])
            .collect()
    }

    /// F_c = m (vⁿ⁺¹ − vⁿ)/Δt − (m g + q − γ v̄) where a grain touches, else 0.
    fn contact_force(&self, outcome: &Outcome, dt: f64) -> Vec<f64> {
        let (grains, candidate) = (&self.grains, &outcome.grains);
        let force = |k: usize| {
            let i = k / 2;
            if candidate.contact[i] < TOUCHES || grains.fixed[i] {
                return 0.0;
            }
            let inertia = grains.mass[i] * (candidate.velocity[k] - grains.velocity[k]) / dt;
            let drag = outcome.model.drag[i] * candidate.mean_velocity[k];
            inertia - grains.mass[i] * self.scene.gravity[k % 2] - outcome.force[k] + drag
        };
        (0..candidate.velocity.len()).map(force).collect()
    }

    fn take_grains(&mut self, candidate: GrainCandidate) {
        self.grains.position = candidate.position;
        self.grains.velocity = candidate.velocity;
        self.grains.mean_velocity = candidate.mean_velocity;
        if !candidate.contact.is_empty() {
            self.grains.contact = candidate.contact;
        }
    }

    /// Contact states of the accepted grains; they come from the engine now where the scheme does
    /// without.
    pub fn contact_states(&mut self) -> Result<&[f64], CouplerError> {
        if let (Some(seat), true) = (&mut self.particles, self.step > 0)
            && let Some(contact) = seat.withheld_contact()?
        {
            self.grains.contact = contact;
        }
        Ok(&self.grains.contact)
    }

    pub(crate) fn request(&self, pass: u32, dt: f64) -> Request {
        Request {
            step: self.step + 1,
            pass,
            time: self.time,
            dt,
        }
    }

    pub(crate) fn solve_fluid(
        &mut self,
        request: &Request,
        fields: Option<&NodalResponse>,
    ) -> Result<FluidState, CouplerError> {
        self.fluid
            .as_mut()
            .expect("the scene has a fluid")
            .advance(request, fields)
    }

    pub(crate) fn move_grains(
        &mut self,
        request: &Request,
        drag: &[f64],
        force: &[f64],
        sub_steps: u32,
    ) -> Result<GrainCandidate, CouplerError> {
        let tolerance = self.contact_tolerance();
        let seat = self.particles.as_mut().expect("the scene has grains");
        let mut candidate = seat.advance(request, Some((drag, force)), sub_steps, tolerance)?;
        if let (false, true, Some(part)) = (
            self.tells_contacts(),
            self.scene.reaction,
            &self.scene.particles,
        ) {
            let may_touch = proximity::may_touch(&self.grains, part, request.dt);
            let state = |may| if may { TOUCHES } else { 0.0 };
            candidate.contact = may_touch.into_iter().map(state).collect();
        }
        Ok(candidate)
    }

    /// Does the particle engine say who touches, and who is held?
    pub(crate) fn tells_contacts(&self) -> bool {
        let seat = self.particles.as_ref();
        seat.is_none_or(ParticleSeat::tells_contacts)
    }

    /// Does the fluid engine take c and κ into its equations?
    pub(crate) fn takes_affine_response(&self) -> bool {
        let seat = self.fluid.as_ref();
        seat.is_none_or(FluidSeat::takes_affine_response)
    }

    /// Contact residual asked for: that of the scene, and well below the defect that ends the passes,
    /// which could not be reached otherwise.
    fn contact_tolerance(&self) -> f64 {
        let own = self
            .scene
            .particles
            .as_ref()
            .map_or(0.0, |part| part.tolerance);
        match self.scene.scheme {
            Scheme::Iterated { tolerance, .. } if self.fluid.is_some() => {
                own.min(CONTACT_SHARE * tolerance)
            }
            _ => own,
        }
    }

    pub(crate) fn transfer(&self) -> &Transfer {
        self.transfer.as_ref().expect("the scene has a fluid")
    }

    /// ρ of the fluid \[kg/m³\].
    pub(crate) fn fluid_density(&self) -> f64 {
        self.scene.fluid.as_ref().map_or(0.0, |part| part.density)
    }

    fn check_finite(&self, values: &[f64], what: &str) -> Result<(), CouplerError> {
        match values.iter().position(|value| !value.is_finite()) {
            Some(k) => Err(CouplerError::NotFinite {
                step: self.step + 1,
                what: format!("{what} (number {})", k / 2),
            }),
            None => Ok(()),
        }
    }
}

fn initial_state(grains: &InitialGrains) -> GrainState {
    let count = grains.mass.len();
    GrainState {
        position: grains.position.clone(),
        velocity: grains.velocity.clone(),
        mean_velocity: grains.velocity.clone(),
        contact: vec![0.0; count],
        contact_force: vec![0.0; 2 * count],
        carried: vec![0.0; 2 * count],
        mass: grains.mass.clone(),
        volume: grains.volume.clone(),
        radius: grains.radius.clone(),
        fixed: grains.fixed.iter().map(|&flag| flag != 0.0).collect(),
    }
}

fn new_transfer(
    scene: &CouplerScene,
    seat: &FluidSeat,
    radii: &[f64],
) -> Result<Transfer, CouplerError> {
    let diameter = 2.0 * radii.iter().fold(0.0_f64, |max, &radius| max.max(radius));
    let cell = smallest_cell(seat);
    let automatic = if diameter > LUMPED_RATIO_MAX * cell {
        2.0 * diameter
    } else {
        0.0
    };
    let depth = match scene.geometry {
        Geometry::Disk => 1.0,
        Geometry::Sphere { depth } => depth,
    };
    Transfer::new(
        &seat.mesh,
        scene.smoothing_length.unwrap_or(automatic),
        depth,
    )
}

/// h of the smallest cell: the side of a square of two triangles.
pub(crate) fn smallest_cell(seat: &FluidSeat) -> f64 {
    let doubled_area = |c: &[f64; 6]| (c[2] - c[0]) * (c[5] - c[1]) - (c[4] - c[0]) * (c[3] - c[1]);
    seat.mesh
        .triangle_position
        .iter()
        .map(doubled_area)
        .fold(f64::INFINITY, f64::min)
        .sqrt()
}

fn shapes(geometry: Geometry, radii: &[f64]) -> Vec<Shape> {
    let cubes: f64 = radii.iter().map(|r| r.powi(3)).sum();
    let squares: f64 = radii.iter().map(|r| r.powi(2)).sum();
    let sauter = cubes / squares; // mean radius weighted by surface
    radii
        .iter()
        .map(|&radius| Shape::new(geometry, radius, radius / sauter))
        .collect()
}
