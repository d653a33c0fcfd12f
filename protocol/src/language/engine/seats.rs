//! The two engine traits behind one loop: fields by name in, fields by name out.

use std::path::Path;

use super::session::{Seat, Session, Trouble, guarded};
use super::traits::{
    FluidAnswer, FluidEngine, FluidForces, GrainAnswer, ParticleEngine, SolidResponse,
};
use crate::language::field::{FROM_FLUID, FROM_PARTICLES, Field};
use crate::language::header::Stage;
use crate::language::message::{
    Advance, Capability, Configure, Diagnostic, Failure, FailureKind, Ready, Role,
};
use crate::language::scene::{FluidScene, ParticleScene};
use crate::transport::exchange::{Counts, Moment, receive_grains};

/// Meshes and grain sets are numbered from 1; 0 is "before the first".
const FIRST_EPOCH: u64 = 1;

/// A fluid engine in its seat.
pub(crate) struct FluidSeat<'a, E>(pub &'a mut E);

/// A particle engine in its seat.
pub(crate) struct ParticleSeat<'a, E>(pub &'a mut E);

fn find<'a>(inputs: &[(Field, &'a [f64])], wanted: Field) -> Option<&'a [f64]> {
    inputs
        .iter()
        .find(|(field, _)| *field == wanted)
        .map(|&(_, values)| values)
}

fn wrong_seat(role: Role) -> Trouble {
    let why = format!("Configure is not for the {} engine", role.seat());
    Trouble::Failed(Failure::new(FailureKind::Engine, why))
}

impl<E: FluidEngine> FluidSeat<'_, E> {
    fn build(&mut self, scene: &FluidScene, session: &mut Session) -> Result<Ready, Trouble> {
        let mesh = guarded(|| self.0.configure(scene))?;
        let counts = Counts {
            epoch: FIRST_EPOCH,
            nodes: mesh.nodal_mass.len(),
            triangles: mesh.triangles.len(),
            grains: 0,
        };
        session.counts = counts;
        let corners: Vec<f64> = mesh
            .triangles
            .iter()
            .flatten()
            .map(|&node| f64::from(node))
            .collect();
        let fields = [
            (Field::NodePosition, mesh.node_position.as_slice()),
            (Field::TriangleNodes, corners.as_slice()),
            (
                Field::TrianglePosition,
                mesh.triangle_position.as_flattened(),
            ),
            (Field::NodalMass, mesh.nodal_mass.as_slice()),
        ];
        for (field, values) in fields {
            counts.send(
                &mut *session.channel,
                field,
                Moment::at(Stage::Ready),
                values,
            )?;
        }
        let (nodes, triangles) = (counts.nodes as u64, counts.triangles as u64);
        Ok(Ready::Mesh {
            epoch: counts.epoch,
            nodes,
            triangles,
            period: mesh.period,
        })
    }
}

impl<E: FluidEngine> Seat for FluidSeat<'_, E> {
    const ROLE: Role = Role::Fluid;
    const ANSWER: &'static [Field] = &FROM_FLUID;

    fn identity(&self) -> (&'static str, &'static str) {
        self.0.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.0.capabilities()
    }

    fn configure(&mut self, configure: Configure, session: &mut Session) -> Result<Ready, Trouble> {
        match configure {
            Configure::Fluid(scene) => self.build(&scene, session),
            Configure::Particles { .. } => Err(wrong_seat(Self::ROLE)),
        }
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &[(Field, &[f64])],
        outputs: &mut [&mut [f64]],
    ) -> Result<Vec<Diagnostic>, Failure> {
        let solid = SolidResponse {
            porosity: find(inputs, Field::Porosity),
            drag: find(inputs, Field::Drag),
            drag_source: find(inputs, Field::DragSource),
            entrained_fraction: find(inputs, Field::EntrainedFraction),
            solid_flux: find(inputs, Field::SolidFlux),
            solid_mobility: find(inputs, Field::SolidMobility),
        };
        // The order of `FROM_FLUID`.
        let [velocity, gradient, pressure] = outputs else {
            return Err(Failure::new(FailureKind::Engine, "three outputs expected"));
        };
        let answer = FluidAnswer {
            interstitial_velocity: velocity,
            pressure_gradient: gradient,
            pressure,
        };
        self.0.advance(request, &solid, answer)
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}

impl<E: ParticleEngine> ParticleSeat<'_, E> {
    fn build(
        &mut self,
        scene: &ParticleScene,
        count: u64,
        session: &mut Session,
    ) -> Result<Ready, Trouble> {
        let wait = session.field_wait();
        let given = Counts {
            grains: count as usize,
            ..Counts::default()
        };
        let grains = receive_grains(&given, &mut *session.channel, Stage::Configure, wait)?;
        let grains = guarded(|| self.0.configure(scene, grains))?;
        session.counts = Counts {
            epoch: FIRST_EPOCH,
            grains: grains.radius.len(),
            ..Counts::default()
        };
        let counts = session.counts;
        for (field, values) in grains.slices() {
            counts.send(
                &mut *session.channel,
                field,
                Moment::at(Stage::Ready),
                values,
            )?;
        }
        Ok(Ready::Grains {
            epoch: counts.epoch,
            grains: counts.grains as u64,
        })
    }
}

impl<E: ParticleEngine> Seat for ParticleSeat<'_, E> {
    const ROLE: Role = Role::Particles;
    const ANSWER: &'static [Field] = &FROM_PARTICLES;

    fn identity(&self) -> (&'static str, &'static str) {
        self.0.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.0.capabilities()
    }

    fn configure(&mut self, configure: Configure, session: &mut Session) -> Result<Ready, Trouble> {
        match configure {
            Configure::Particles { scene, grain_count } => self.build(&scene, grain_count, session),
            Configure::Fluid(_) => Err(wrong_seat(Self::ROLE)),
        }
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &[(Field, &[f64])],
        outputs: &mut [&mut [f64]],
    ) -> Result<Vec<Diagnostic>, Failure> {
        let fluid = FluidForces {
            drag: find(inputs, Field::GrainDrag),
            force: find(inputs, Field::GrainForce),
        };
        // The order of `FROM_PARTICLES`.
        let [position, velocity, mean_velocity, contact] = outputs else {
            return Err(Failure::new(FailureKind::Engine, "four outputs expected"));
        };
        let answer = GrainAnswer {
            position,
            velocity,
            mean_velocity,
            contact,
        };
        self.0.advance(request, &fluid, answer)
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}
