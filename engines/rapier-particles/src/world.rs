//! Grains and walls as bodies of rapier, and one sub-step.
//!
//! ```text
//!   v ← (m v + δt (m g + q))/(m + γδt)     drag implicit in the free motion
//!   A = m + γδt                            and in the contacts: rapier sees this mass
//!   rapier: contacts as springs of natural frequency f and damping ratio ζ, friction, x ← x + δt v
//! ```
//!
//! A resting grain overlaps what it lies on by about g/(2πf)², whatever the iterations.

use clap::Args;
use rapier2d_f64::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of the contact solver; each is an argument of the program.
#[derive(Debug, Clone, Copy, Args)]
pub struct Settings {
    /// Natural frequency of contacts (Hz); a grain at rest overlaps by about g/(2πf)²
    #[arg(long, value_name = "HZ", default_value_t = 400.0, value_parser = positive)]
    pub frequency: f64,
    /// Damping ratio of contacts; 1: critical
    #[arg(long, value_name = "ZETA", default_value_t = 1.0, value_parser = positive)]
    pub damping_ratio: f64,
    /// Solver iterations in a sub-step
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub iterations: u16,
    /// Longest sub-step (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 2e-3, value_parser = positive)]
    pub sub_step_max: f64,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if f64::is_finite(value) && value > 0.0 => Ok(value),
        _ => Err("must be a positive number".to_owned()),
    }
}

/// A wall segment; grains stay on the left of a → b \[m\].
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Start.
    pub a: [f64; 2],
    /// End.
    pub b: [f64; 2],
}

/// What does not change.
#[derive(Debug, Clone)]
pub struct Model {
    /// Settings of the solver.
    pub settings: Settings,
    /// g \[m/s²\].
    pub gravity: [f64; 2],
    /// Walls.
    pub walls: Vec<Segment>,
    /// Coulomb coefficients, between grains and with walls.
    pub friction: [f64; 2],
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Masses \[kg\].
    pub mass: Vec<f64>,
    /// Moments of inertia \[kg m²\].
    pub inertia: Vec<f64>,
    /// Grains that never move.
    pub fixed: Vec<bool>,
}

/// The state of rapier; the candidate is a copy that has moved on.
#[derive(Clone, Serialize, Deserialize)]
pub struct World {
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    /// Pairs of colliders that are near, with what the solver found.
    pub narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    /// Grains first, in their order; then walls.
    pub colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    /// Body of each grain.
    grains: Vec<RigidBodyHandle>,
}

impl World {
    /// Grains and walls at the start.
    pub fn new(model: &Model, position: &[f64], velocity: &[f64]) -> World {
        let mut world = World {
            islands: IslandManager::new(),
            broad_phase: DefaultBroadPhase::default(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            grains: Vec::new(),
        };
        let [friction, wall_friction] = model.friction;
        for (grain, &radius) in model.radius.iter().enumerate() {
            let vector = |values: &[f64]| Vector::new(values[2 * grain], values[2 * grain + 1]);
            let body = if model.fixed[grain] {
                RigidBodyBuilder::fixed()
            } else {
                RigidBodyBuilder::dynamic()
                    .linvel(vector(velocity))
                    .additional_mass_properties(model.mass_properties(grain, 0.0))
            };
            let body = body.translation(vector(position)).can_sleep(false);
            let handle = world.bodies.insert(body);
            // The mass is the body's: it changes with the drag.
            let ball = ColliderBuilder::ball(radius)
                .density(0.0)
                .friction(friction)
                .restitution(0.0)
                .user_data(grain as u128);
            world
                .colliders
                .insert_with_parent(ball, handle, &mut world.bodies);
            world.grains.push(handle);
        }
        let rule = if wall_friction <= friction {
            CoefficientCombineRule::Min
        } else {
            CoefficientCombineRule::Max
        };
        for (index, wall) in model.walls.iter().enumerate() {
            let end = |p: [f64; 2]| Vector::new(p[0], p[1]);
            let segment = ColliderBuilder::segment(end(wall.a), end(wall.b))
                .friction(wall_friction)
                .friction_combine_rule(rule)
                .restitution(0.0)
                .user_data((model.radius.len() + index) as u128);
            world.colliders.insert(segment);
        }
        world
    }

    /// One sub-step of `dt` under drag coefficients \[kg/s\] and forces \[N\]; the grain whose numbers
    /// are no longer finite is an error.
    pub fn step(
        &mut self,
        model: &Model,
        pipeline: &mut PhysicsPipeline,
        dt: f64,
        drag: Option<&[f64]>,
        force: Option<&[f64]>,
    ) -> Result<(), usize> {
        for (grain, &handle) in self.grains.iter().enumerate() {
            if model.fixed[grain] {
                continue;
            }
            let (mass, drag) = (model.mass[grain], drag.map_or(0.0, |drag| drag[grain]));
            let given = |axis: usize| force.map_or(0.0, |force| force[2 * grain + axis]);
            let body = &mut self.bodies[handle];
            let old = body.linvel();
            let free = [0, 1].map(|axis| {
                let push = mass * model.gravity[axis] + given(axis);
                (mass * old[axis] + dt * push) / (mass + drag * dt)
            });
            body.set_linvel(Vector::new(free[0], free[1]), true);
            body.set_additional_mass_properties(model.mass_properties(grain, drag * dt), true);
        }
        let mut ccd = CCDSolver::new();
        pipeline.step(
            Vector::new(0.0, 0.0),
            &model.parameters(dt),
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut ccd,
            &(),
            &(),
        );
        match pipeline.quarantine().bodies().first() {
            None => Ok(()),
            Some(bad) => Err(self.grains.iter().position(|body| body == bad).unwrap_or(0)),
        }
    }

    /// Number of grains.
    pub fn count(&self) -> usize {
        self.grains.len()
    }

    /// Centre of a grain \[m\].
    pub fn position(&self, grain: usize) -> [f64; 2] {
        let at = self.bodies[self.grains[grain]].translation();
        [at.x, at.y]
    }

    /// Velocity of a grain \[m/s\].
    pub fn velocity(&self, grain: usize) -> [f64; 2] {
        let velocity = self.bodies[self.grains[grain]].linvel();
        [velocity.x, velocity.y]
    }

    /// Angular velocity of a grain, counter-clockwise \[rad/s\].
    pub fn spin(&self, grain: usize) -> f64 {
        self.bodies[self.grains[grain]].angvel()
    }

    /// Translational and rotational energy of all grains \[J\].
    pub fn kinetic_energy(&self, model: &Model) -> f64 {
        let energy = |grain: usize| {
            let ([x, y], spin) = (self.velocity(grain), self.spin(grain));
            0.5 * (model.mass[grain] * (x * x + y * y) + model.inertia[grain] * spin * spin)
        };
        (0..self.grains.len()).map(energy).sum()
    }
}

impl Model {
    fn mass_properties(&self, grain: usize, added: f64) -> MassProperties {
        let centre = Vector::new(0.0, 0.0);
        MassProperties::new(centre, self.mass[grain] + added, self.inertia[grain])
    }

    /// Mean diameter \[m\]: rapier's unit of length, to which its margins are relative.
    pub fn length(&self) -> f64 {
        2.0 * self.radius.iter().sum::<f64>() / self.radius.len().max(1) as f64
    }

    /// |g| \[m/s²\].
    pub fn weight(&self) -> f64 {
        self.gravity[0].hypot(self.gravity[1])
    }

    fn parameters(&self, dt: f64) -> IntegrationParameters {
        let softness =
            SpringCoefficients::new(self.settings.frequency, self.settings.damping_ratio);
        let length = self.length();
        // Rapier's 3 m/s for bodies of 1 m under 9.81 m/s² is √(g d).
        let recovery = (self.weight().max(1.0) * length).sqrt();
        IntegrationParameters {
            dt,
            contact_softness: softness,
            static_contact_softness: softness,
            num_solver_iterations: usize::from(self.settings.iterations),
            length_unit: length,
            normalized_max_corrective_velocity: recovery / length,
            normalized_max_linear_velocity: f64::MAX,
            max_ccd_substeps: 0,
            // Contacts that are looked at again in every sub-step.
            contact_recycling: false,
            ..IntegrationParameters::default()
        }
    }
}
