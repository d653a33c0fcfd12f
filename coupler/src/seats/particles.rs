//! The particle engine's seat.

use std::time::Instant;

use protocol::engine::InitialGrains;
use protocol::error::Error;
use protocol::field::Field;
use protocol::message::{Capability, Diagnostic, REMOVED_MAX};
use protocol::partner::Partner;
use protocol::report::{ParticleReport, Report};
use protocol::scene::ParticleScene;
use space::{Vector, flat};

use crate::error::CouplerError;
use crate::seats::door::{self, can, withhold};
use crate::seats::request::Request;
use crate::state::{Candidate, Contact, Grains};

/// What the fluid does to the grains.
#[derive(Debug, Clone, Copy)]
pub struct Forces<'a, const D: usize> {
    /// γ \[kg/s\]
    pub drag: &'a [f64],
    /// q = γ v_f − V∇p \[N\]
    pub force: &'a [Vector<D>],
}

impl<'a, const D: usize> Forces<'a, D> {
    /// Of these coefficients and forces.
    pub fn new(drag: &'a [f64], force: &'a [Vector<D>]) -> Forces<'a, D> {
        Forces { drag, force }
    }
}

/// Who moves the grains.
pub enum ParticleSeat<const D: usize> {
    /// An engine.
    Engine(Box<Engine>),
    /// Nobody: all are fixed, at these places.
    Fixed(Vec<Vector<D>>),
}

/// A particle engine that has been configured.
pub struct Engine {
    partner: Partner,
    /// Fields that it keeps back until somebody reads them.
    withheld: Vec<Field>,
    /// Contact residual asked of it, of |g|Δt.
    tolerance: f64,
    /// What the engine told of the last candidate; none before the first.
    report: Option<ParticleReport>,
    /// Numbers of the last candidate, for people.
    diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    wall: f64,
}

impl<const D: usize> ParticleSeat<D> {
    /// Configure an engine that has said hello, and let it keep back what is not read in every pass;
    /// with the grains that it runs. `tolerance`: of its contact solve.
    pub fn new(
        mut partner: Partner,
        scene: &ParticleScene,
        grains: &InitialGrains,
        unread: &[Field],
        tolerance: f64,
    ) -> Result<(ParticleSeat<D>, Grains<D>), CouplerError> {
        can_move_walls(&partner, scene)?;
        let mut grains = door::grains(&partner.configure_particles(scene, grains)?)?;
        if can(&partner, Capability::Spin) {
            grains.spin = no_spin(&grains);
        }
        let engine = Engine {
            withheld: withhold(&mut partner, unread)?,
            partner,
            tolerance,
            report: None,
            diagnostics: Vec::new(),
            wall: 0.0,
        };
        Ok((ParticleSeat::Engine(Box::new(engine)), grains))
    }

    /// Grains that stay where they are, without an engine.
    pub fn fixed(grains: &InitialGrains) -> Result<(ParticleSeat<D>, Grains<D>), CouplerError> {
        let mut grains = door::grains::<D>(grains)?;
        grains.velocity.fill(Vector::zeros());
        grains.mean_velocity.fill(Vector::zeros());
        grains.spin = no_spin(&grains);
        Ok((ParticleSeat::Fixed(grains.position.clone()), grains))
    }

    /// Does it tell which grains a wall holds?
    pub fn tells_contacts(&self) -> bool {
        let engine = self.engine();
        engine.is_none_or(|partner| can(partner, Capability::ContactState))
    }

    /// The engine behind the seat, if there is one.
    pub fn engine(&self) -> Option<&Partner> {
        match self {
            ParticleSeat::Engine(engine) => Some(&engine.partner),
            ParticleSeat::Fixed(_) => None,
        }
    }

    /// The same, to speak with.
    pub fn partner(&mut self) -> Option<&mut Partner> {
        match self {
            ParticleSeat::Engine(engine) => Some(&mut engine.partner),
            ParticleSeat::Fixed(_) => None,
        }
    }

    /// Contacts that carry an impulse in the last candidate, where the engine tells.
    pub fn touching(&self) -> Option<u64> {
        match self {
            ParticleSeat::Engine(engine) => engine.report.and_then(|report| report.touching),
            ParticleSeat::Fixed(_) => None,
        }
    }

    /// Numbers of the last candidate, for people.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        match self {
            ParticleSeat::Engine(engine) => &engine.diagnostics,
            ParticleSeat::Fixed(_) => &[],
        }
    }

    /// Wall time waited for the engine so far \[s\].
    pub fn wall(&self) -> f64 {
        match self {
            ParticleSeat::Engine(engine) => engine.wall,
            ParticleSeat::Fixed(_) => 0.0,
        }
    }

    /// Free velocities and contacts (S4, S5) under the fluid's forces; without them the grains are dry.
    /// `sub_steps` 0 lets the engine choose.
    pub fn advance(
        &mut self,
        request: &Request,
        forces: Option<Forces<'_, D>>,
        sub_steps: u32,
    ) -> Result<Candidate<D>, CouplerError> {
        match self {
            ParticleSeat::Engine(engine) => engine.advance(request, forces, sub_steps),
            ParticleSeat::Fixed(position) => Ok(stay(position)),
        }
    }

    /// Grains have left, by their numbers before; `left` are the others. The engine must have the same.
    pub fn remove(
        &mut self,
        gone: &[usize],
        left: &Grains<D>,
        step: u64,
    ) -> Result<(), CouplerError> {
        let ParticleSeat::Engine(engine) = self else {
            return Ok(());
        };
        // from the end, so that the numbers of those before stay what they were
        let mut told = InitialGrains::default();
        for some in gone.rchunks(REMOVED_MAX) {
            told = engine.partner.remove(some)?;
        }
        require_same(&door::grains(&told)?, left, step)
    }

    /// Bring what did not come with the accepted step.
    pub fn fetch(&mut self, grains: &mut Grains<D>, step: u64) -> Result<(), CouplerError> {
        match self {
            ParticleSeat::Engine(engine) => engine.fetch(grains, step),
            ParticleSeat::Fixed(_) => Ok(()),
        }
    }
}

impl Engine {
    fn advance<const D: usize>(
        &mut self,
        request: &Request,
        forces: Option<Forces<'_, D>>,
        sub_steps: u32,
    ) -> Result<Candidate<D>, CouplerError> {
        let begin = Instant::now();
        let inputs: Vec<(Field, &[f64])> = forces.map_or_else(Vec::new, |forces| {
            let force = flat::numbers(forces.force);
            vec![(Field::GrainDrag, forces.drag), (Field::GrainForce, force)]
        });
        let [mut position, mut velocity, mut mean] = [const { Vec::new() }; 3];
        let [mut contact, mut spin] = [const { Vec::new() }; 2];
        let mut outputs = vec![
            (Field::GrainPosition, &mut position),
            (Field::GrainVelocity, &mut velocity),
            (Field::GrainMeanVelocity, &mut mean),
            (Field::GrainContact, &mut contact),
            (Field::GrainSpin, &mut spin),
        ];
        let told = self.partner.hello().answer();
        outputs.retain(|(field, _)| told.contains(field) && !self.withheld.contains(field));
        let advance = request.advance(sub_steps, self.tolerance);
        let done = self.partner.advance(&advance, &inputs, &mut outputs)?;
        let Report::Particles(report) = done.report else {
            let why = "it is that of a fluid";
            return Err(Error::invalid("particles", request.step, "report", why).into());
        };
        self.report = Some(report);
        self.diagnostics = done.diagnostics;
        let candidate = Candidate {
            position: door::vectors(&position, "grain_position")?,
            velocity: door::vectors(&velocity, "grain_velocity")?,
            mean_velocity: door::vectors(&mean, "grain_mean_velocity")?,
            contact: door::contacts(&contact, request.step)?,
            spin,
            sub_steps: report.sub_steps.get(),
        };
        self.wall += begin.elapsed().as_secs_f64();
        Ok(candidate)
    }

    fn fetch<const D: usize>(
        &mut self,
        grains: &mut Grains<D>,
        step: u64,
    ) -> Result<(), CouplerError> {
        let [mut contact, mut spin] = [const { Vec::new() }; 2];
        let mut outputs = vec![
            (Field::GrainContact, &mut contact),
            (Field::GrainSpin, &mut spin),
        ];
        outputs.retain(|(field, _)| self.withheld.contains(field));
        if outputs.is_empty() {
            return Ok(());
        }
        self.partner.tell(&mut outputs)?;
        if self.withheld.contains(&Field::GrainContact) {
            grains.contact = door::contacts(&contact, step)?;
        }
        if self.withheld.contains(&Field::GrainSpin) {
            grains.spin = spin;
        }
        Ok(())
    }
}

/// Has an engine the grains that it should have?
fn require_same<const D: usize>(
    told: &Grains<D>,
    own: &Grains<D>,
    step: u64,
) -> Result<(), CouplerError> {
    let first = |same: &dyn Fn(usize) -> bool| (0..own.count()).find(|&grain| !same(grain));
    let looks: [(Field, &dyn Fn(usize) -> bool); 6] = [
        (Field::GrainPosition, &|i| {
            told.position[i] == own.position[i]
        }),
        (Field::GrainVelocity, &|i| {
            told.velocity[i] == own.velocity[i]
        }),
        (Field::GrainRadius, &|i| told.radius[i] == own.radius[i]),
        (Field::GrainMass, &|i| told.mass[i] == own.mass[i]),
        (Field::GrainVolume, &|i| told.volume[i] == own.volume[i]),
        (Field::GrainFixed, &|i| told.fixed[i] == own.fixed[i]),
    ];
    for (field, same) in looks {
        if let Some(grain) = first(same) {
            let why = format!("after grains have left, that of grain {grain} is not what it was");
            return Err(Error::invalid("particles", step, field.name(), why).into());
        }
    }
    Ok(())
}

/// An engine that does not say that it can would take a wall that moves for one at rest.
fn can_move_walls(partner: &Partner, scene: &ParticleScene) -> Result<(), CouplerError> {
    let moves = scene.walls.iter().any(|wall| wall.velocity.is_some());
    if !moves || scene.wall_friction == 0.0 || can(partner, Capability::MovingWalls) {
        return Ok(());
    }
    let engine = &partner.hello().engine;
    Err(CouplerError::Walls {
        why: format!(
            "the particle engine {engine} knows no walls that move: take another one, or set \
             contact.wall_friction = 0.0"
        ),
    })
}

/// 0 of every grain.
fn no_spin<const D: usize>(grains: &Grains<D>) -> Vec<f64> {
    vec![0.0; grains.count() * Field::GrainSpin.components(D)]
}

/// What an engine would answer for grains that are all fixed.
fn stay<const D: usize>(position: &[Vector<D>]) -> Candidate<D> {
    let rest = vec![Vector::zeros(); position.len()];
    Candidate {
        position: position.to_vec(),
        velocity: rest.clone(),
        mean_velocity: rest,
        contact: vec![Contact::Held; position.len()],
        spin: Vec::new(),
        sub_steps: 1,
    }
}
