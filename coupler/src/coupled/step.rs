//! One coupling step: the staggered scheme of Constant, Dubois, Lambrechts and Legat with the
//! solid's response and, where contacts demand it, further passes.
//!
//! ```text
//!   S1  place grains at xⁿ + ½Δt vⁿ; porosity, γ, response z + λ D q          (response.rs)
//!   S0  where grains touch: a contact solve with the old fluid fields predicts z and who is held
//!       repeat
//!   S2    fluid: w, G, p at tⁿ⁺¹ under φ, β, s, c, j⁰, κ
//!   S3    q = γ N w − V N G
//!   S4-5  grains: free velocities, contacts → v̄
//!   S6    r = v̄ − (z + λ D q): accept when its force is below the tolerance,
//!         else z ← v̄ − λ D q, accelerated, with the matrix kept               (iterate.rs, lambda.rs)
//! ```
//!
//! A fluid without the affine response is given c = κ = 0, so that the deferred correction holds all of
//! both, at the last known w* and G*; passes then go on until these stand still.

use protocol::scene::Scheme;
use space::{Dim, Dimension};

use crate::coupled::carry;
use crate::coupled::comparison;
use crate::coupled::engines::Engines;
use crate::coupled::iterate::Iterate;
use crate::coupled::lambda::Policy;
use crate::coupled::outcome::{Outcome, Pass};
use crate::coupled::setting::{Deferred, Setting};
use crate::error::CouplerError;
use crate::immersion::Immersion;
use crate::seats::particles::Forces;
use crate::seats::request::Request;
use crate::state::{Contact, State, count_contacts};

/// Fluid and grains that feel each other.
pub struct Coupled<const D: usize, const N: usize> {
    /// Who computes.
    pub engines: Engines<D, N>,
    /// The grains in their fluid.
    pub immersion: Immersion<D, N>,
    /// How they are coupled.
    pub scheme: Scheme,
    /// The first λ of a step.
    pub policy: Policy,
    /// The deferred correction.
    pub deferred: Deferred,
}

/// When passes end.
#[derive(Debug, Clone, Copy)]
struct End {
    tolerance: f64,
    passes_max: u32,
}

impl<const D: usize, const N: usize> Coupled<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// A step of length dt under the scene's scheme; nothing is accepted.
    pub fn step(&mut self, state: &State<D>, dt: f64) -> Result<Outcome<D, N>, CouplerError> {
        let (tolerance, passes_max) = match self.scheme {
            Scheme::Staggered => (f64::INFINITY, 1),
            Scheme::Iterated {
                tolerance,
                passes_max,
            } => (tolerance, passes_max),
            Scheme::SemiImplicit => {
                return comparison::semi_implicit(&mut self.engines, &self.immersion, state, dt);
            }
            Scheme::Explicit => {
                return comparison::explicit(&mut self.engines, &self.immersion, state, dt);
            }
        };
        let end = End {
            tolerance,
            passes_max,
        };
        self.passes(state, dt, end)
    }

    /// S1 to S6.
    fn passes(
        &mut self,
        state: &State<D>,
        dt: f64,
        end: End,
    ) -> Result<Outcome<D, N>, CouplerError> {
        let (immersion, grains) = (&self.immersion, &state.grains);
        let placement = immersion.place(grains, dt)?; // S1
        let porosity = immersion.porosity(grains, &placement)?;
        let setting = Setting {
            immersion,
            placement: &placement,
            grains,
            dt,
            affine: self.engines.fluid.takes_affine_response(),
            deferred: self.deferred,
        };
        let mut iterate = predict(&mut self.engines, &self.policy, &setting, state, porosity)?; // S0
        let mut number = 1;
        loop {
            let request = Request::after(state, number, dt);
            iterate.set_sources(&setting);
            let flow = self.engines.solve_fluid(&request, &iterate.response)?; // S2
            let force = setting.force(&flow, &iterate.model.drag); // S3
            let forces = Forces::new(&iterate.model.drag, &force);
            let (engines, sub_steps) = (&mut self.engines, iterate.sub_steps);
            let moved = engines.move_grains(&request, grains, forces, sub_steps)?; // S4, S5
            let residual = iterate.model.residual(&force, &moved); // S6
            let pass = setting.measure(&iterate.model, flow, force, moved, residual);
            let change = iterate.correction_change(&setting, &pass, number);
            log(&request, &iterate, &pass, change);
            if pass.defect.relative <= end.tolerance && change <= end.tolerance {
                return Ok(accepted(&setting, iterate, pass, number));
            }
            if number == end.passes_max {
                return Err(not_converged(&request, &pass, change, end.tolerance));
            }
            iterate.improve(&setting, &self.policy, &pass, end.tolerance);
            number += 1;
        }
    }
}

/// The first model: from a contact solve with the old fluid fields where grains touch (S0).
fn predict<const D: usize, const N: usize>(
    engines: &mut Engines<D, N>,
    policy: &Policy,
    setting: &Setting<'_, D, N>,
    state: &State<D>,
    porosity: Vec<f64>,
) -> Result<Iterate<D>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let (grains, flow) = (&state.grains, &state.flow);
    let drag = setting.drag(flow, &porosity);
    // at the start nobody knows yet who touches
    if !touching(&grains.contact) && state.step > 0 {
        let mut model = setting.free_model(drag, 1);
        policy.choose(&mut model.lambda, &grains.fixed, &[]);
        return Ok(Iterate::new(
            setting,
            porosity,
            model,
            flow.clone(),
            0,
            false,
        ));
    }
    let force = setting.force(flow, &drag);
    let request = Request::after(state, 0, setting.dt);
    let forces = Forces::new(&drag, &force);
    let candidate = engines.move_grains(&request, grains, forces, 0)?;
    let mut model = setting.free_model(drag, candidate.sub_steps);
    policy.choose(&mut model.lambda, &grains.fixed, &candidate.contact);
    model.calibrate(&candidate, &force);
    // where nothing touches, the new flow and not the old one decides how far grains move
    let sub_steps = match touching(&candidate.contact) {
        true => candidate.sub_steps,
        false => 0,
    };
    Ok(Iterate::new(
        setting,
        porosity,
        model,
        flow.clone(),
        sub_steps,
        true,
    ))
}

fn touching(contact: &[Contact]) -> bool {
    contact.iter().any(|&state| state >= Contact::Touches)
}

/// The pass that ended a step, and what it owes the next.
fn accepted<const D: usize, const N: usize>(
    setting: &Setting<'_, D, N>,
    iterate: Iterate<D>,
    pass: Pass<D>,
    passes: u32,
) -> Outcome<D, N>
where
    Dim<D>: Dimension<D>,
{
    let lagged = setting.lagged_force(&iterate.model, &iterate.reference, &pass.flow);
    Outcome {
        passes,
        placement: setting.placement.clone(),
        carried_force: carry::carried_force(&pass, &iterate.model.drag, &lagged),
        lagged,
        model: iterate.model,
        response: iterate.response,
        pass,
    }
}

fn not_converged<const D: usize>(
    request: &Request,
    pass: &Pass<D>,
    change: f64,
    tolerance: f64,
) -> CouplerError {
    let (held, touching) = count_contacts(&pass.grains.contact);
    CouplerError::NotConverged {
        step: request.step,
        defect: pass.defect.relative.max(change),
        tolerance,
        passes: request.pass,
        held,
        touching,
        grains: pass.grains.position.len(),
    }
}

fn log<const D: usize>(request: &Request, iterate: &Iterate<D>, pass: &Pass<D>, change: f64) {
    let (held, touching) = count_contacts(&pass.grains.contact);
    let lambda = &iterate.model.lambda;
    let count = |value: f64| lambda.iter().filter(|&&lambda| lambda == value).count();
    tracing::debug!(
        step = request.step,
        pass = request.pass,
        defect = pass.defect.relative,
        change,
        held,
        touching,
        lambda_zero = count(0.0),
        lambda_half = count(0.5),
        sub_steps = pass.grains.sub_steps,
        "pass"
    );
}
