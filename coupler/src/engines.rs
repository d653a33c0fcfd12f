//! The two seats as the scheme sees them: typed calls over the protocol's partners.

use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::Field;
use protocol::messages::{Advance, Capability, Diagnostic, Hello};
use protocol::partner::Partner;
use protocol::process;

use crate::error::CouplerError;
use crate::response::{FluidState, NodalResponse};

/// Position of a candidate in the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Step number, from 1.
    pub step: u64,
    /// Pass within the step.
    pub pass: u32,
    /// Start of the step \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub dt: f64,
}

impl Request {
    fn advance(&self, sub_steps: u32, tolerance: f64) -> Advance {
        Advance {
            step: self.step,
            pass: self.pass,
            time: self.time,
            dt: self.dt,
            sub_steps,
            tolerance,
            fields: Vec::new(),
        }
    }
}

/// The fluid engine's seat.
pub struct FluidSeat {
    partner: Partner,
    /// May fields that say nothing stay away?
    leaves_out: bool,
    /// The mesh it solves on.
    pub mesh: MeshDescription,
    /// Nodal pressure of the last candidate \[Pa\].
    pub pressure: Vec<f64>,
    /// Numbers of the last candidate.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    pub wall: f64,
}

impl FluidSeat {
    /// Configure an engine that has said hello.
    pub fn new(
        mut partner: Partner,
        scene: &protocol::configure::FluidScene,
    ) -> Result<FluidSeat, CouplerError> {
        let mesh = partner.configure_fluid(scene)?;
        let pressure = vec![0.0; mesh.nodal_mass.len()];
        Ok(FluidSeat {
            partner,
            leaves_out: process::may_leave_out(),
            mesh,
            pressure,
            diagnostics: Vec::new(),
            wall: 0.0,
        })
    }

    /// What the engine said about itself.
    pub fn hello(&self) -> &Hello {
        self.partner.hello()
    }

    /// Does it take the entrained fraction c and the mobility κ?
    pub fn takes_affine_response(&self) -> bool {
        has(self.hello(), Capability::AffineResponse)
    }

    /// The engine behind the seat.
    pub fn partner(&mut self) -> &mut Partner {
        &mut self.partner
    }

    /// One solve (S2); without a response the fluid is alone.
    pub fn advance(
        &mut self,
        request: &Request,
        response: Option<&NodalResponse>,
    ) -> Result<FluidState, CouplerError> {
        let begin = std::time::Instant::now();
        let mut inputs: Vec<(Field, &[f64])> = response.map_or_else(Vec::new, |fields| {
            vec![
                (Field::Porosity, fields.porosity.as_slice()),
                (Field::Drag, &fields.drag),
                (Field::DragSource, &fields.drag_source),
                (Field::SolidFlux, &fields.solid_flux),
                (Field::EntrainedFraction, &fields.entrained_fraction),
                (Field::SolidMobility, &fields.solid_mobility),
            ]
        });
        if !self.takes_affine_response() {
            inputs.truncate(4);
        }
        if self.leaves_out {
            inputs.retain(|(field, values)| says_something(*field, values));
        }
        let mut state = FluidState::default();
        let mut outputs = [
            (Field::InterstitialVelocity, &mut state.velocity),
            (Field::PressureGradient, &mut state.pressure_gradient),
            (Field::Pressure, &mut self.pressure),
        ];
        let done = self
            .partner
            .advance(&request.advance(0, 0.0), &inputs, &mut outputs)?;
        self.diagnostics = done.diagnostics;
        self.wall += begin.elapsed().as_secs_f64();
        Ok(state)
    }
}

/// Where nothing can be entrained, as in a bed of fixed grains, these fields are zero everywhere: what
/// an engine takes for a field that does not come (protocol, §3).
fn says_something(field: Field, values: &[f64]) -> bool {
    let zero_when_absent = matches!(
        field,
        Field::SolidFlux | Field::EntrainedFraction | Field::SolidMobility
    );
    !zero_when_absent || values.iter().any(|&value| value != 0.0)
}

/// A candidate of the particle engine. Vectors are interleaved.
#[derive(Debug, Clone, Default)]
pub struct GrainCandidate {
    /// x at the end \[m\]
    pub position: Vec<f64>,
    /// v at the end \[m/s\]
    pub velocity: Vec<f64>,
    /// v̄ = (xⁿ⁺¹ − xⁿ)/Δt \[m/s\]
    pub mean_velocity: Vec<f64>,
    /// 0 free, 1 touches, 2 held
    pub contact: Vec<f64>,
    /// Sub-steps used
    pub sub_steps: u32,
}

/// The particle engine's seat.
pub struct ParticleSeat {
    partner: Partner,
    /// The grains it runs, as they began.
    pub grains: InitialGrains,
    /// Numbers of the last candidate.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    pub wall: f64,
}

impl ParticleSeat {
    /// Configure an engine that has said hello.
    pub fn new(
        mut partner: Partner,
        scene: &protocol::configure::ParticleScene,
        grains: &InitialGrains,
    ) -> Result<ParticleSeat, CouplerError> {
        let grains = partner.configure_particles(scene, grains)?;
        Ok(ParticleSeat {
            partner,
            grains,
            diagnostics: Vec::new(),
            wall: 0.0,
        })
    }

    /// What the engine said about itself.
    pub fn hello(&self) -> &Hello {
        self.partner.hello()
    }

    /// Does it tell which grains a wall holds?
    pub fn tells_contacts(&self) -> bool {
        has(self.hello(), Capability::ContactState)
    }

    /// The engine behind the seat.
    pub fn partner(&mut self) -> &mut Partner {
        &mut self.partner
    }

    /// Free velocities and contacts (S4, S5) under γ and q; without them the grains are dry.
    /// `sub_steps` 0 lets the engine choose; `tolerance` is that of its contact solve.
    pub fn advance(
        &mut self,
        request: &Request,
        forces: Option<(&[f64], &[f64])>,
        sub_steps: u32,
        tolerance: f64,
    ) -> Result<GrainCandidate, CouplerError> {
        let begin = std::time::Instant::now();
        let inputs: Vec<(Field, &[f64])> = forces.map_or_else(Vec::new, |(drag, force)| {
            vec![(Field::GrainDrag, drag), (Field::GrainForce, force)]
        });
        let mut candidate = GrainCandidate::default();
        let mut outputs = [
            (Field::GrainPosition, &mut candidate.position),
            (Field::GrainVelocity, &mut candidate.velocity),
            (Field::GrainMeanVelocity, &mut candidate.mean_velocity),
            (Field::GrainContact, &mut candidate.contact),
        ];
        let done = self.partner.advance(
            &request.advance(sub_steps, tolerance),
            &inputs,
            &mut outputs,
        )?;
        self.diagnostics = done.diagnostics;
        candidate.sub_steps =
            value(&self.diagnostics, "sub_steps").map_or(1, |count| count.max(1.0) as u32);
        self.wall += begin.elapsed().as_secs_f64();
        Ok(candidate)
    }
}

fn has(hello: &Hello, capability: Capability) -> bool {
    hello.capabilities.contains(&capability)
}

/// The value of a diagnostic, if the engine reported it.
pub fn value(diagnostics: &[Diagnostic], name: &str) -> Option<f64> {
    diagnostics
        .iter()
        .find(|diagnostic| diagnostic.name == name)
        .map(|diagnostic| diagnostic.value)
}
