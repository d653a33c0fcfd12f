//! Grains and walls as bodies of rapier, and one sub-step: once for the crate of the plane and once for that
//! of space, which call things by the same names.
//!
//! ```text
//!   v ← (m v + δt (m g + q))/(m + γδt)     drag implicit in the free motion
//!   A = m + γδt                            and in the contacts: rapier sees this mass
//!   rapier: contacts as springs of natural frequency f and damping ratio ζ, friction, x ← x + δt v
//! ```
//!
//! A resting grain overlaps what it lies on by about g/(2πf)², whatever the iterations.

use serde::{Deserialize, Serialize};
use space::{Spin, Vector, hypot};

use super::rapier::{self, *};
use super::{D, moments, turning, wall};
use crate::bodies::{Bodies, Pair};
use crate::model::Model;

/// The state of rapier.
#[derive(Clone, Serialize, Deserialize)]
pub struct World {
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    /// Pairs of colliders that are near, with what the solver found.
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    /// Grains first, in their order; then walls.
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    /// Body of each grain.
    grains: Vec<RigidBodyHandle>,
}

impl Bodies<D> for World {
    type Pipeline = PhysicsPipeline;

    fn new(model: &Model<D>, position: &[Vector<D>], velocity: &[Vector<D>]) -> World {
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
            let body = if model.fixed[grain] {
                RigidBodyBuilder::fixed()
            } else {
                RigidBodyBuilder::dynamic()
                    .linvel(theirs(&velocity[grain]))
                    .additional_mass_properties(mass_properties(model, grain, 0.0))
            };
            let body = body.translation(theirs(&position[grain])).can_sleep(false);
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
        for (index, corners) in model.walls.iter().enumerate() {
            let wall = wall(corners.map(|corner| theirs(&corner)))
                .friction(wall_friction)
                .friction_combine_rule(rule)
                .restitution(0.0)
                .user_data((model.radius.len() + index) as u128);
            world.colliders.insert(wall);
        }
        world
    }

    fn step(
        &mut self,
        model: &Model<D>,
        pipeline: &mut PhysicsPipeline,
        dt: f64,
        drag: Option<&[f64]>,
        force: Option<&[Vector<D>]>,
    ) -> Result<(), usize> {
        for (grain, &handle) in self.grains.iter().enumerate() {
            if model.fixed[grain] {
                continue;
            }
            let (mass, drag) = (model.mass[grain], drag.map_or(0.0, |drag| drag[grain]));
            let body = &mut self.bodies[handle];
            let old = body.linvel();
            let free: [f64; D] = std::array::from_fn(|axis| {
                let push =
                    mass * model.gravity[axis] + force.map_or(0.0, |force| force[grain][axis]);
                (mass * old[axis] + dt * push) / (mass + drag * dt)
            });
            body.set_linvel(free.into(), true);
            body.set_additional_mass_properties(mass_properties(model, grain, drag * dt), true);
        }
        let mut ccd = CCDSolver::new();
        pipeline.step(
            rapier::Vector::ZERO,
            &parameters(model, dt),
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

    fn count(&self) -> usize {
        self.grains.len()
    }

    fn position(&self, grain: usize) -> Vector<D> {
        ours(self.bodies[self.grains[grain]].translation())
    }

    fn velocity(&self, grain: usize) -> Vector<D> {
        ours(self.bodies[self.grains[grain]].linvel())
    }

    fn spin(&self, grain: usize) -> Spin<D> {
        turning(self.bodies[self.grains[grain]].angvel())
    }

    fn pairs(&self, model: &Model<D>) -> Vec<Pair> {
        let pair = |pair: &ContactPair| {
            let of = [pair.collider1, pair.collider2].map(|handle| &self.colliders[handle]);
            Pair {
                ends: of.map(number),
                pushes: pair.total_impulse_magnitude() > 0.0,
                overlap: self.overlap(model, of),
            }
        };
        self.narrow_phase.contact_pairs().map(pair).collect()
    }
}

impl World {
    /// Overlap of two grains, or of a grain and a wall, of the smaller radius; negative when apart.
    fn overlap(&self, model: &Model<D>, mut of: [&Collider; 2]) -> f64 {
        of.sort_by_key(|collider| number(collider));
        let ([grain, other], count) = (of.map(number), model.radius.len());
        if grain >= count {
            return 0.0;
        }
        let (at, radius) = (self.position(grain), model.radius[grain]);
        if other < count {
            let apart = hypot(&(at - self.position(other)));
            return (radius + model.radius[other] - apart) / radius.min(model.radius[other]);
        }
        let wall = of[1].shape();
        let nearest = wall.project_local_point(theirs(&at), false).point;
        (radius - hypot(&(at - ours(nearest)))) / radius
    }
}

/// Number of a grain, or of a wall counted on from there.
fn number(collider: &Collider) -> usize {
    collider.user_data as usize
}

fn theirs(vector: &Vector<D>) -> rapier::Vector {
    <[f64; D]>::from(*vector).into()
}

fn ours(vector: rapier::Vector) -> Vector<D> {
    Vector::from(vector.to_array())
}

fn mass_properties(model: &Model<D>, grain: usize, added: f64) -> MassProperties {
    let (mass, inertia) = (model.mass[grain] + added, moments(model.inertia[grain]));
    MassProperties::new(rapier::Vector::ZERO, mass, inertia)
}

fn parameters(model: &Model<D>, dt: f64) -> IntegrationParameters {
    let settings = &model.settings;
    let softness = SpringCoefficients::new(settings.frequency, settings.damping_ratio);
    let length = model.length();
    IntegrationParameters {
        dt,
        contact_softness: softness,
        static_contact_softness: softness,
        num_solver_iterations: usize::from(settings.iterations),
        length_unit: length,
        normalized_max_corrective_velocity: model.recovery() / length,
        normalized_max_linear_velocity: f64::MAX,
        max_ccd_substeps: 0,
        // Contacts that are looked at again in every sub-step.
        contact_recycling: false,
        ..IntegrationParameters::default()
    }
}
