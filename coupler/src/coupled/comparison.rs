//! Schemes of other codes, to be compared with: one pass, nothing tested, nothing carried on.
//!
//! ```text
//!   semi-implicit   fluid   β = T(γ), s = T(γ vⁿ), j⁰ = T(V vⁿ), c = κ = 0
//!                   grains  γ and q = γ N w − V N G, drag implicit                        (C1)
//!   explicit        fluid   β = 0, s = −T(γ (N wⁿ − vⁿ)), j⁰ = T(V vⁿ), c = κ = 0
//!                   grains  the force γ (N wⁿ − vⁿ) − V N G, no drag coefficient          (C2)
//! ```
//!
//! (C1) is the affine model of `response.rs` with λ = 0 and z = vⁿ. Its lagged solid flux amplifies
//! by 1/φ² − 1 a step in stiff free motion and by the added mass, (1−φ)ρ/(φρ_p), at any step: it
//! diverges below φ = 0.707 where stiff, and wherever grains are light for their porosity. The fluid
//! feels γ vⁿ and the grains γ vⁿ⁺¹: the difference is reported as `momentum_defect` and lost.
//!
//! (C2) conserves momentum and diverges once Δt (1/τ_p + 1/τ_f) > 2, with τ_p = m/γ and τ_f = φρ/β.
//! Both lack the deferred correction.

use space::{Dim, Dimension, Vector};

use crate::coupled::engines::Engines;
use crate::coupled::outcome::Outcome;
use crate::coupled::response::{Correction, Model};
use crate::coupled::setting::{Deferred, Setting};
use crate::error::CouplerError;
use crate::immersion::Immersion;
use crate::seats::particles::Forces;
use crate::seats::request::Request;
use crate::state::{Response, State};

/// What a scheme gives the grains.
struct Given<const D: usize> {
    /// γ that they take implicitly \[kg/s\].
    drag: Vec<f64>,
    /// Force known beforehand, its reaction on the fluid included \[N\].
    force: Vec<Vector<D>>,
}

/// A step of (C1); nothing is accepted.
pub fn semi_implicit<const D: usize, const N: usize>(
    engines: &mut Engines<D, N>,
    immersion: &Immersion<D, N>,
    state: &State<D>,
    dt: f64,
) -> Result<Outcome<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    lagged_step(engines, immersion, state, dt, |setting, porosity| Given {
        drag: setting.drag(&state.flow, porosity),
        force: vec![Vector::zeros(); state.grains.count()],
    })
}

/// A step of (C2); nothing is accepted.
pub fn explicit<const D: usize, const N: usize>(
    engines: &mut Engines<D, N>,
    immersion: &Immersion<D, N>,
    state: &State<D>,
    dt: f64,
) -> Result<Outcome<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let (grains, flow) = (&state.grains, &state.flow);
    lagged_step(engines, immersion, state, dt, |setting, porosity| {
        let drag = immersion.drag(grains, flow, setting.placement, porosity, None);
        let fluid = immersion.transfer.sample(setting.placement, &flow.velocity);
        let slip = fluid.iter().zip(&grains.velocity).map(|(w, v)| w - v);
        Given {
            force: slip.zip(&drag).map(|(slip, drag)| slip * *drag).collect(),
            drag: vec![0.0; grains.count()],
        }
    })
}

/// One pass with λ = 0 and z = vⁿ.
fn lagged_step<const D: usize, const N: usize>(
    engines: &mut Engines<D, N>,
    immersion: &Immersion<D, N>,
    state: &State<D>,
    dt: f64,
    given: impl FnOnce(&Setting<'_, D, N>, &[f64]) -> Given<D>,
) -> Result<Outcome<D, N>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let grains = &state.grains;
    let placement = immersion.place(grains, dt)?;
    let porosity = immersion.porosity(grains, &placement)?;
    let setting = Setting {
        immersion,
        placement: &placement,
        grains,
        dt,
        affine: true,
        deferred: Deferred::LeftOut,
    };
    let given = given(&setting, &porosity);
    let mut model = setting.free_model(given.drag, 1);
    model.lambda.fill(0.0);
    model.free_velocity.copy_from_slice(&grains.velocity);
    let response = response(&setting, porosity, &model, &given.force);
    let request = Request::after(state, 1, dt);
    let flow = engines.solve_fluid(&request, &response)?;
    let mut force = setting.force(&flow, &model.drag);
    let known = force.iter_mut().zip(&given.force);
    known.for_each(|(q, own)| *q += own);
    let moved = engines.move_grains(&request, grains, Forces::new(&model.drag, &force), 0)?;
    let residual = moved.mean_velocity.iter().zip(&grains.velocity);
    let residual = residual.map(|(new, old)| new - old).collect();
    let pass = setting.measure(&model, flow, force, moved, residual);
    let none = vec![Vector::zeros(); grains.count()];
    Ok(Outcome {
        pass,
        passes: 1,
        model,
        response,
        lagged: none.clone(),
        carried_force: none,
        placement,
    })
}

/// What the fluid is given; it feels the reaction of a force given to the grains.
fn response<const D: usize, const N: usize>(
    setting: &Setting<'_, D, N>,
    porosity: Vec<f64>,
    model: &Model<D>,
    force: &[Vector<D>],
) -> Response<D>
where
    Dim<D>: Dimension<D>,
{
    let transfer = &setting.immersion.transfer;
    let no_correction = Correction::none(transfer.node_count());
    let reaction: Vec<Vector<D>> = force.iter().map(|force| -force).collect();
    let mut response = setting.matrix_response(porosity, model);
    response.set_sources(
        transfer,
        setting.placement,
        model,
        &no_correction,
        &reaction,
    );
    response
}
