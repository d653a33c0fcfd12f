//! An engine in its seat: from the loop's fields to the engine's, and back.

use std::path::Path;

use crate::language::field::Field;
use crate::language::header::Stage;
use crate::language::message::{
    Advance, Capability, Configure, Diagnostic, Failure, FailureKind, Ready, Role,
};
use crate::language::report::Report;
use crate::language::scene::{FluidScene, ParticleScene, Refinement};
use crate::transport::exchange::{Counts, Moment, receive_grains};

use super::fields::{Inputs, Outputs};
use super::session::{Seat, Session, Trouble, guarded, out_of_order};
use super::told::{InitialGrains, MeshDescription};
use super::traits::{FluidEngine, ParticleEngine};

/// The epoch of the first mesh and of the first grains.
const FIRST_EPOCH: u64 = 1;

/// A fluid engine in its seat.
pub(crate) struct FluidSeat<'a, E>(pub &'a mut E);

/// A particle engine in its seat.
pub(crate) struct ParticleSeat<'a, E>(pub &'a mut E);

fn wrong_seat(role: Role) -> Trouble {
    let why = format!("Configure is not for the {} engine", role.seat());
    Trouble::Failed(Failure::new(FailureKind::Engine, why))
}

fn unusable(why: String) -> Trouble {
    Trouble::Failed(Failure::new(FailureKind::Scene, why))
}

/// An engine that answers in another dimension than it was asked for is broken.
fn same_dimension(asked: usize, told: usize) -> Result<(), Trouble> {
    if asked == told {
        return Ok(());
    }
    let why = format!("the engine answers in {told} dimensions, the scene has {asked}");
    Err(Trouble::Failed(Failure::new(FailureKind::Engine, why)))
}

impl<E: FluidEngine> FluidSeat<'_, E> {
    fn build(&mut self, scene: &FluidScene, session: &mut Session) -> Result<Ready, Trouble> {
        scene.check().map_err(unusable)?;
        let mesh = guarded(|| self.0.configure(scene))?;
        same_dimension(scene.dimension, mesh.dimension)?;
        ready(mesh, FIRST_EPOCH, session)
    }
}

/// Tell the mesh of this epoch.
fn ready(mesh: MeshDescription, epoch: u64, session: &mut Session) -> Result<Ready, Trouble> {
    session.counts = Counts {
        epoch,
        dimension: mesh.dimension,
        nodes: mesh.node_count(),
        simplices: mesh.simplex_count(),
        facets: mesh.facets.count(),
        grains: 0,
    };
    send_mesh(&mesh, session)?;
    Ok(Ready::Mesh {
        epoch,
        dimension: mesh.dimension as u32,
        nodes: session.counts.nodes as u64,
        simplices: session.counts.simplices as u64,
        period: mesh.period,
        facets: session.counts.facets as u64,
        boundaries: mesh.facets.boundaries,
    })
}

fn send_mesh(mesh: &MeshDescription, session: &mut Session) -> Result<(), Trouble> {
    let corners = mesh.corner_numbers();
    let fields: [(Field, &[f64]); 4] = [
        (Field::NodePosition, &mesh.node_position),
        (Field::SimplexNodes, &corners),
        (Field::SimplexPosition, &mesh.simplex_position),
        (Field::NodalMass, &mesh.nodal_mass),
    ];
    send_all(&fields, session)?;
    if mesh.facets.count() == 0 {
        return Ok(());
    }
    let boundary = mesh.facets.boundary_numbers();
    let fields: [(Field, &[f64]); 3] = [
        (Field::FacetPosition, &mesh.facets.position),
        (Field::FacetBoundary, &boundary),
        (Field::FacetVelocity, &mesh.facets.velocity),
    ];
    send_all(&fields, session)
}

fn send_all(fields: &[(Field, &[f64])], session: &mut Session) -> Result<(), Trouble> {
    let (counts, moment) = (session.counts, Moment::at(Stage::Ready));
    for &(field, values) in fields {
        counts.send(&mut *session.channel, field, moment, values)?;
    }
    Ok(())
}

impl<E: FluidEngine> Seat for FluidSeat<'_, E> {
    const ROLE: Role = Role::Fluid;

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
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<(Report, Vec<Diagnostic>), Failure> {
        let computed = self.0.advance(request, inputs, outputs)?;
        Ok((Report::Fluid(computed.report), computed.diagnostics))
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }

    fn adapt(
        &mut self,
        epoch: u64,
        sizes: &Refinement,
        session: &mut Session,
    ) -> Result<Option<Ready>, Trouble> {
        let dimension = session.counts.dimension;
        let checked = sizes.check(dimension);
        checked.map_err(|why| out_of_order(format!("Adapt whose {why}")))?;
        let Some(mesh) = guarded(|| self.0.adapt(sizes))? else {
            return Ok(None);
        };
        same_dimension(dimension, mesh.dimension)?;
        // what was kept back is of the mesh before
        session.withheld.moment = None;
        ready(mesh, epoch, session).map(Some)
    }

    fn remove(&mut self, _: &[usize], _: &mut Session) -> Result<Ready, Trouble> {
        Err(out_of_order("Remove, and a fluid has no grains".to_owned()))
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
        scene.check().map_err(unusable)?;
        let grains = given_grains(scene, count, session)?;
        let grains = guarded(|| self.0.configure(scene, grains))?;
        same_dimension(scene.dimension, grains.dimension)?;
        session.counts = Counts {
            epoch: FIRST_EPOCH,
            dimension: grains.dimension,
            grains: grains.count(),
            ..Counts::default()
        };
        send_all(&grains.slices(), session)?;
        Ok(Ready::Grains {
            epoch: FIRST_EPOCH,
            dimension: grains.dimension as u32,
            grains: grains.count() as u64,
        })
    }
}

fn given_grains(
    scene: &ParticleScene,
    count: u64,
    session: &mut Session,
) -> Result<InitialGrains, Trouble> {
    let given = Counts {
        dimension: scene.dimension,
        grains: count as usize,
        ..Counts::default()
    };
    let wait = session.field_wait();
    Ok(receive_grains(
        &given,
        &mut *session.channel,
        Stage::Configure,
        wait,
    )?)
}

impl<E: ParticleEngine> Seat for ParticleSeat<'_, E> {
    const ROLE: Role = Role::Particles;

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
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<(Report, Vec<Diagnostic>), Failure> {
        let computed = self.0.advance(request, inputs, outputs)?;
        Ok((Report::Particles(computed.report), computed.diagnostics))
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }

    fn adapt(&mut self, _: u64, _: &Refinement, _: &mut Session) -> Result<Option<Ready>, Trouble> {
        Err(out_of_order("Adapt, and grains have no mesh".to_owned()))
    }

    fn remove(&mut self, grains: &[usize], session: &mut Session) -> Result<Ready, Trouble> {
        let left = guarded(|| self.0.remove(grains))?;
        let expected = session.counts.grains - grains.len();
        if left.count() != expected {
            let why = format!(
                "{} grains are left after Remove, expected {expected}",
                left.count()
            );
            return Err(Trouble::Failed(Failure::new(FailureKind::Engine, why)));
        }
        session.withheld.remove(grains, session.counts.dimension);
        session.counts.epoch += 1;
        session.counts.grains = expected;
        send_all(&left.slices(), session)?;
        Ok(Ready::Grains {
            epoch: session.counts.epoch,
            dimension: session.counts.dimension as u32,
            grains: expected as u64,
        })
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}
