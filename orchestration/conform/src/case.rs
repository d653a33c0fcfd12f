//! What an engine under test is configured with, and the inputs it is given.

use std::path::PathBuf;
use std::time::Duration;

use protocol::engine::InitialGrains;
use protocol::field::Field;
use protocol::message::{Advance, Capability, Role};
use protocol::scene::{FluidScene, Geometry, Limits, ParticleScene};

use scene::document::Document;
use scene::{Error, Scene};

const SCENE: &str = include_str!("scene.toml");

/// The engine's part of a scene.
#[derive(Debug, Clone)]
pub enum Part {
    /// For a fluid engine.
    Fluid(Box<FluidScene>),
    /// For a particle engine, with its grains.
    Particles(Box<ParticleScene>, InitialGrains),
}

/// A command under test and what it is tested with.
#[derive(Debug, Clone)]
pub struct Case {
    /// Program and arguments.
    pub command: Vec<String>,
    /// The seat it must take.
    pub role: Role,
    /// What it is configured with.
    pub part: Part,
    /// Length of a step \[s\].
    pub dt: f64,
    /// Limit on every wait \[s\].
    pub limit: f64,
    /// The scene's file, when it is not the built-in one, and its settings.
    pub scene: Option<PathBuf>,
    /// `KEY=VALUE` of the scene.
    pub settings: Vec<String>,
}

/// Inputs of one `Advance`.
pub type Inputs = Vec<(Field, Vec<f64>)>;

impl Case {
    /// A case from the built-in scene or from one of the user's.
    pub fn new(
        role: Role,
        command: Vec<String>,
        scene: Option<PathBuf>,
        settings: Vec<String>,
        limit: f64,
    ) -> Result<Case, Error> {
        let document = match &scene {
            Some(path) => Document::load(path, &settings)?,
            None => Document::parse("conform.toml".as_ref(), SCENE.to_owned(), &settings)?,
        };
        let resolved = scene::from_document(&document, 1)?;
        let missing = |what: &str| {
            let why = format!("the scene {} has no {what}", resolved.name);
            Error::Usage(format!("{why}, which `--as {}` needs", role.seat()))
        };
        let part = match role {
            Role::Fluid => {
                let fluid = resolved.coupler.fluid.clone();
                Part::Fluid(Box::new(fluid.ok_or_else(|| missing("[fluid]"))?))
            }
            Role::Particles => {
                let particles = resolved.coupler.particles.clone();
                let particles = particles.ok_or_else(|| missing("[[grains]]"))?;
                Part::Particles(Box::new(particles), grains(&resolved))
            }
        };
        Ok(Case {
            command,
            role,
            part,
            dt: resolved.coupler.coupling_step,
            limit,
            scene,
            settings,
        })
    }

    /// Dimension of the space.
    pub fn dimension(&self) -> usize {
        match &self.part {
            Part::Fluid(scene) => scene.dimension,
            Part::Particles(scene, _) => scene.dimension,
        }
    }

    /// The same for all waits.
    pub fn limits(&self) -> Limits {
        Limits {
            connect: self.limit,
            configure: self.limit,
            step: self.limit,
        }
    }

    /// The limit as a duration.
    pub fn patience(&self) -> Duration {
        Duration::from_secs_f64(self.limit)
    }

    /// Accuracy asked of contacts, of |g|Δt.
    fn tolerance(&self) -> f64 {
        match &self.part {
            Part::Fluid(_) => 0.0,
            Part::Particles(scene, _) => scene.tolerance,
        }
    }

    /// The request for a step of the usual length.
    pub fn request(&self, step: u64, pass: u32) -> Advance {
        Advance {
            step,
            pass,
            time: (step - 1) as f64 * self.dt,
            dt: self.dt,
            sub_steps: 0,
            tolerance: self.tolerance(),
            fields: Vec::new(),
        }
    }

    /// Inputs in a physical range, a different set for each `variant`: porosities from 0.7 to 0.9
    /// with a drag of the fluid's inertia over a step, or forces of 0.3 times the weight. A fluid that
    /// does not declare `AffineResponse` is not sent what only that uses.
    pub fn inputs(&self, count: usize, variant: u32, able: &[Capability]) -> Inputs {
        let affine = able.contains(&Capability::AffineResponse);
        let only_affine =
            |field: Field| matches!(field, Field::EntrainedFraction | Field::SolidMobility);
        let mut inputs = self.all_inputs(count, variant);
        inputs.retain(|(field, _)| affine || !only_affine(*field));
        inputs
    }

    fn all_inputs(&self, count: usize, variant: u32) -> Inputs {
        let (shift, d) = (f64::from(variant), self.dimension());
        let wave = |size: usize, rate: f64| (0..size).map(move |k| (rate * k as f64 + shift).sin());
        match &self.part {
            Part::Fluid(scene) => {
                const SPEED: f64 = 1e-3;
                let inertia = scene.density / self.dt;
                let solid: Vec<f64> = wave(count, 0.7).map(|w| 0.2 + 0.1 * w).collect();
                let of_solid =
                    |factor: f64| -> Vec<f64> { solid.iter().map(|s| factor * s).collect() };
                let vector = |factor: f64, rate: f64| -> Vec<f64> {
                    let waves = wave(d * count, rate).enumerate();
                    waves.map(|(k, w)| factor * w * solid[k / d]).collect()
                };
                vec![
                    (Field::Porosity, solid.iter().map(|s| 1.0 - s).collect()),
                    (Field::Drag, of_solid(inertia)),
                    (Field::DragSource, vector(SPEED * inertia, 0.9)),
                    (Field::EntrainedFraction, of_solid(0.5)),
                    (Field::SolidFlux, vector(SPEED, 1.1)),
                    (Field::SolidMobility, of_solid(0.5 / inertia)),
                    (Field::FixedDrag, of_solid(0.5 * inertia)),
                ]
            }
            Part::Particles(scene, grains) => {
                let size = scene.gravity.iter().copied().fold(0.0, f64::hypot);
                let gravity = size.max(1.0);
                let mass = |grain: usize| grains.mass.get(grain).copied().unwrap_or(1.0);
                let drag = wave(count, 0.7).enumerate();
                let force = wave(d * count, 0.9).enumerate();
                vec![
                    (
                        Field::GrainDrag,
                        drag.map(|(k, w)| mass(k) / self.dt * (0.5 + 0.4 * w))
                            .collect(),
                    ),
                    (
                        Field::GrainForce,
                        force
                            .map(|(k, w)| 0.3 * mass(k / d) * gravity * w)
                            .collect(),
                    ),
                ]
            }
        }
    }
}

/// The grains of a scene as an engine receives them.
fn grains(scene: &Scene) -> InitialGrains {
    let table = &scene.grains;
    let volume = |radius: &f64| match scene.coupler.geometry {
        Geometry::Disk => std::f64::consts::PI * radius * radius,
        Geometry::Sphere { .. } => 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
    };
    let volume: Vec<f64> = table.radius.iter().map(volume).collect();
    InitialGrains {
        dimension: scene.coupler.dimension,
        position: table.position.clone(),
        velocity: table.velocity.clone(),
        radius: table.radius.clone(),
        mass: volume
            .iter()
            .zip(&table.density)
            .map(|(v, d)| v * d)
            .collect(),
        volume,
        fixed: table
            .fixed
            .iter()
            .map(|&fixed| f64::from(u8::from(fixed)))
            .collect(),
    }
}
