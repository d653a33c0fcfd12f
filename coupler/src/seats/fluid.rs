//! The fluid engine's seat.

use std::time::Instant;

use protocol::engine::MeshDescription;
use protocol::field::Field;
use protocol::message::{Capability, Diagnostic};
use protocol::partner::Partner;
use protocol::process;
use protocol::report::{FluidReport, Report};
use protocol::scene::{FluidScene, Refinement};
use space::{Dim, Dimension, flat};

use crate::error::CouplerError;
use crate::seats::door::{self, can, withhold};
use crate::seats::request::Request;
use crate::state::{Flow, Response};
use crate::transfer::mesh::Mesh;

/// A fluid engine that has been configured.
pub struct FluidSeat<const D: usize, const N: usize> {
    partner: Partner,
    /// May fields that are zero everywhere stay away?
    leaves_out: bool,
    /// Fields that it keeps back until somebody reads them.
    withheld: Vec<Field>,
    /// The mesh as it was told.
    pub description: MeshDescription,
    /// The mesh it solves on.
    pub mesh: Mesh<D, N>,
    /// h of its smallest cell \[m\].
    pub smallest_cell: f64,
    /// Nodal pressure \[Pa\].
    pressure: Vec<f64>,
    /// Is it that of the last candidate?
    pressure_is_new: bool,
    /// What the engine told of the last candidate.
    pub report: FluidReport,
    /// Numbers of the last candidate, for people.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall time waited for it \[s\].
    pub wall: f64,
}

impl<const D: usize, const N: usize> FluidSeat<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Configure an engine that has said hello, and let it keep back what is not read in every pass.
    pub fn new(
        mut partner: Partner,
        scene: &FluidScene,
        unread: &[Field],
    ) -> Result<FluidSeat<D, N>, CouplerError> {
        let description = partner.configure_fluid(scene)?;
        let mesh: Mesh<D, N> = door::mesh(&description)?;
        Ok(FluidSeat {
            withheld: withhold(&mut partner, unread)?,
            partner,
            leaves_out: process::may_leave_out(),
            smallest_cell: mesh.smallest_cell(),
            mesh,
            pressure: vec![0.0; description.nodal_mass.len()],
            description,
            pressure_is_new: true,
            report: FluidReport::default(),
            diagnostics: Vec::new(),
            wall: 0.0,
        })
    }

    /// Does it take the entrained fraction c and the mobility κ?
    pub fn takes_affine_response(&self) -> bool {
        can(&self.partner, Capability::AffineResponse)
    }

    /// The engine behind the seat.
    pub fn partner(&mut self) -> &mut Partner {
        &mut self.partner
    }

    /// The same, to look at.
    pub fn engine(&self) -> &Partner {
        &self.partner
    }

    /// Epoch of the mesh.
    pub fn epoch(&self) -> u64 {
        self.partner.epoch()
    }

    /// Ask for cells of these sizes before this step; true where the mesh is another one, of this epoch, from now on.
    /// The pressure is known again with the next step.
    pub fn adapt(
        &mut self,
        (step, epoch): (u64, u64),
        sizes: &Refinement,
    ) -> Result<bool, CouplerError> {
        let begin = Instant::now();
        let told = self.partner.adapt((step, epoch), sizes)?;
        let changed = told.is_some();
        if let Some(description) = told {
            self.mesh = door::mesh(&description)?;
            self.smallest_cell = self.mesh.smallest_cell();
            self.pressure = vec![0.0; description.nodal_mass.len()];
            self.pressure_is_new = step == 1;
            self.description = description;
        }
        self.wall += begin.elapsed().as_secs_f64();
        Ok(changed)
    }

    /// One solve (S2); without a response the fluid is alone.
    pub fn advance(
        &mut self,
        request: &Request,
        response: Option<&Response<D>>,
    ) -> Result<Flow<D>, CouplerError> {
        let begin = Instant::now();
        let inputs = response.map_or_else(Vec::new, |response| self.inputs(response));
        let (mut velocity, mut gradient) = (Vec::new(), Vec::new());
        let mut outputs = vec![
            (Field::InterstitialVelocity, &mut velocity),
            (Field::PressureGradient, &mut gradient),
            (Field::Pressure, &mut self.pressure),
        ];
        outputs.retain(|(field, _)| !self.withheld.contains(field));
        let request = request.advance(0, 0.0);
        let done = self.partner.advance(&request, &inputs, &mut outputs)?;
        self.pressure_is_new = !self.withheld.contains(&Field::Pressure);
        if let Report::Fluid(report) = done.report {
            self.report = report;
        }
        self.diagnostics = done.diagnostics;
        let flow = Flow {
            velocity: door::vectors(&velocity, "interstitial_velocity")?,
            pressure_gradient: door::vectors(&gradient, "pressure_gradient")?,
        };
        self.wall += begin.elapsed().as_secs_f64();
        Ok(flow)
    }

    /// The fields of a response that this engine takes and that say more than their default.
    fn inputs<'a>(&self, response: &'a Response<D>) -> Vec<(Field, &'a [f64])> {
        let mut inputs: Vec<(Field, &[f64])> = vec![
            (Field::Porosity, &response.porosity),
            (Field::Drag, &response.drag),
            (Field::DragSource, flat::numbers(&response.drag_source)),
            (Field::SolidFlux, flat::numbers(&response.solid_flux)),
            (Field::FixedDrag, &response.fixed_drag),
        ];
        if self.takes_affine_response() {
            inputs.push((Field::EntrainedFraction, &response.entrained_fraction));
            inputs.push((Field::SolidMobility, &response.solid_mobility));
        }
        if self.leaves_out {
            inputs.retain(|(field, values)| must_be_sent(*field, values));
        }
        inputs
    }

    /// Nodal pressure of the accepted state \[Pa\]; zero before the first step. Comes from the engine
    /// when it is read.
    pub fn pressure(&mut self) -> Result<&[f64], CouplerError> {
        if !self.pressure_is_new {
            self.partner
                .tell(&mut [(Field::Pressure, &mut self.pressure)])?;
            self.pressure_is_new = true;
        }
        Ok(&self.pressure)
    }
}

/// Where nothing can be entrained, as in a bed of fixed grains, or nothing is fixed, as in a suspension, these
/// fields are zero everywhere: what an engine takes for a field that does not come (protocol, §3).
fn must_be_sent(field: Field, values: &[f64]) -> bool {
    let zero_when_absent = matches!(
        field,
        Field::SolidFlux | Field::EntrainedFraction | Field::SolidMobility | Field::FixedDrag
    );
    !zero_when_absent || values.iter().any(|&value| value != 0.0)
}
