//! The two seats as the scheme sees them: typed calls over the protocol's partners.

use protocol::engine::{InitialGrains, MeshDescription};
use protocol::field::Field;
use protocol::messages::{Advance, Capability, Diagnostic, Hello};
use protocol::partner::Partner;
use protocol::process;

use crate::error::CouplerError;
use crate::response::{FluidState, NodalResponse};
use crate::scheme::HELD;

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
    /// Fields that it keeps back until somebody reads them.
    withheld: Vec<Field>,
    /// The mesh it solves on.
    pub mesh: MeshDescription,
    /// Nodal pressure \[Pa\].
    pressure: Vec<f64>,
    /// Is it that of the last candidate?
    pressure_is_known: bool,
    /// Numbers of the last candidate.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    pub wall: f64,
}

impl FluidSeat {
    /// Configure an engine that has said hello, and let it keep back what is not read in every pass.
    pub fn new(
        mut partner: Partner,
        scene: &protocol::configure::FluidScene,
        unread: &[Field],
    ) -> Result<FluidSeat, CouplerError> {
        let mesh = partner.configure_fluid(scene)?;
        let pressure = vec![0.0; mesh.nodal_mass.len()];
        Ok(FluidSeat {
            withheld: withhold(&mut partner, unread)?,
            partner,
            leaves_out: process::may_leave_out(),
            mesh,
            pressure,
            pressure_is_known: true,
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
        let mut outputs = vec![
            (Field::InterstitialVelocity, &mut state.velocity),
            (Field::PressureGradient, &mut state.pressure_gradient),
            (Field::Pressure, &mut self.pressure),
        ];
        outputs.retain(|(field, _)| !self.withheld.contains(field));
        let done = self
            .partner
            .advance(&request.advance(0, 0.0), &inputs, &mut outputs)?;
        self.pressure_is_known = !self.withheld.contains(&Field::Pressure);
        self.diagnostics = done.diagnostics;
        self.wall += begin.elapsed().as_secs_f64();
        Ok(state)
    }

    /// Nodal pressure of the accepted state \[Pa\]; zero before the first step. Comes from the engine
    /// when it is read.
    pub fn pressure(&mut self) -> Result<&[f64], CouplerError> {
        if !self.pressure_is_known {
            self.partner
                .tell(&mut [(Field::Pressure, &mut self.pressure)])?;
            self.pressure_is_known = true;
        }
        Ok(&self.pressure)
    }
}

/// Let an engine keep back what nobody reads with every candidate; says what it does keep back.
fn withhold(partner: &mut Partner, unread: &[Field]) -> Result<Vec<Field>, CouplerError> {
    if unread.is_empty() || !partner.may_withhold() || !process::may_leave_out() {
        return Ok(Vec::new());
    }
    partner.withhold(unread)?;
    Ok(unread.to_vec())
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
    /// 0 free, 1 touches, 2 held; empty where nobody reads it with every candidate
    pub contact: Vec<f64>,
    /// Sub-steps used
    pub sub_steps: u32,
}

/// The particle engine's seat.
pub struct ParticleSeat {
    /// None where no grain moves and nobody needs to be asked.
    partner: Option<Partner>,
    /// Fields that it keeps back until somebody reads them.
    withheld: Vec<Field>,
    /// The grains it runs, as they began.
    pub grains: InitialGrains,
    /// Numbers of the last candidate.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    pub wall: f64,
}

impl ParticleSeat {
    /// Configure an engine that has said hello, and let it keep back what is not read in every pass.
    pub fn new(
        mut partner: Partner,
        scene: &protocol::configure::ParticleScene,
        grains: &InitialGrains,
        unread: &[Field],
    ) -> Result<ParticleSeat, CouplerError> {
        let grains = partner.configure_particles(scene, grains)?;
        Ok(ParticleSeat {
            withheld: withhold(&mut partner, unread)?,
            partner: Some(partner),
            grains,
            diagnostics: Vec::new(),
            wall: 0.0,
        })
    }

    /// Grains that stay where they are, without an engine.
    pub fn fixed(grains: &InitialGrains) -> ParticleSeat {
        let mut grains = grains.clone();
        grains.velocity.fill(0.0);
        ParticleSeat {
            partner: None,
            withheld: Vec::new(),
            grains,
            diagnostics: Vec::new(),
            wall: 0.0,
        }
    }

    /// What the engine said about itself, if there is one.
    pub fn hello(&self) -> Option<&Hello> {
        self.partner.as_ref().map(Partner::hello)
    }

    /// Does it tell which grains a wall holds?
    pub fn tells_contacts(&self) -> bool {
        self.hello()
            .is_none_or(|hello| has(hello, Capability::ContactState))
    }

    /// The engine behind the seat, if there is one.
    pub fn partner(&mut self) -> Option<&mut Partner> {
        self.partner.as_mut()
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
        let Some(partner) = &mut self.partner else {
            return Ok(self.stay());
        };
        let begin = std::time::Instant::now();
        let inputs: Vec<(Field, &[f64])> = forces.map_or_else(Vec::new, |(drag, force)| {
            vec![(Field::GrainDrag, drag), (Field::GrainForce, force)]
        });
        let mut candidate = GrainCandidate::default();
        let mut outputs = vec![
            (Field::GrainPosition, &mut candidate.position),
            (Field::GrainVelocity, &mut candidate.velocity),
            (Field::GrainMeanVelocity, &mut candidate.mean_velocity),
            (Field::GrainContact, &mut candidate.contact),
        ];
        outputs.retain(|(field, _)| !self.withheld.contains(field));
        let request = request.advance(sub_steps, tolerance);
        let done = partner.advance(&request, &inputs, &mut outputs)?;
        self.diagnostics = done.diagnostics;
        candidate.sub_steps = sub_steps_of(partner.hello(), request.step, &self.diagnostics)?;
        self.wall += begin.elapsed().as_secs_f64();
        Ok(candidate)
    }

    /// Contact states of the accepted step, if they did not come with it.
    pub(crate) fn withheld_contact(&mut self) -> Result<Option<Vec<f64>>, CouplerError> {
        let Some(partner) = self.partner.as_mut().filter(|_| !self.withheld.is_empty()) else {
            return Ok(None);
        };
        let mut contact = Vec::new();
        partner.tell(&mut [(Field::GrainContact, &mut contact)])?;
        Ok(Some(contact))
    }

    /// What an engine would answer for grains that are all fixed.
    fn stay(&self) -> GrainCandidate {
        let count = self.grains.radius.len();
        GrainCandidate {
            position: self.grains.position.clone(),
            velocity: vec![0.0; 2 * count],
            mean_velocity: vec![0.0; 2 * count],
            contact: vec![HELD; count],
            sub_steps: 1,
        }
    }
}

/// Sub-steps of a candidate: the response that the fluid is told is a mean over them, so an engine
/// must say how many it took.
fn sub_steps_of(hello: &Hello, step: u64, diagnostics: &[Diagnostic]) -> Result<u32, CouplerError> {
    match value(diagnostics, "sub_steps") {
        Some(count) if count >= 1.0 => Ok(count as u32),
        told => Err(CouplerError::SubSteps {
            engine: hello.engine.clone(),
            step,
            told: told.map_or("nothing".to_owned(), |count| format!("{count}")),
        }),
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
