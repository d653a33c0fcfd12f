//! (B1)–(B3) on steps that are balanced by construction, and on one that can be done by hand.

use coupler::budget::{Budget, of_coupled_step};
use coupler::coupled::defect::Defect;
use coupler::coupled::outcome::{Outcome, Pass};
use coupler::drag::Fluid;
use coupler::immersion::Immersion;
use coupler::state::{Candidate, Grains, Response};
use coupler::transfer::Transfer;
use protocol::scene::DragLaw;
use space::{Dim, Dimension, Vector, dot, hypot, vector};

use crate::mesh::cube;
use crate::response::{flow, grains, model};

const DT: f64 = 0.01;
const DENSITY: f64 = 3.0;

fn immersion<const D: usize, const N: usize>(depth: f64) -> Immersion<D, N>
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(4, 0.3, false);
    Immersion {
        transfer: Transfer::new(&mesh, depth),
        fluid: Fluid {
            density: DENSITY,
            dynamic_viscosity: 1.0,
        },
        gravity: vector::from_fn(|axis| 0.3 - 9.81 * axis as f64),
        law: DragLaw::Stokes,
        shapes: Vec::new(),
        exits: Default::default(),
    }
}

/// A pass in which grains do what the model says, plus `residual`.
fn outcome<const D: usize, const N: usize>(
    immersion: &Immersion<D, N>,
    grains: &Grains<D>,
    residual: f64,
) -> Outcome<D, N>
where
    Dim<D>: Dimension<D>,
{
    let transfer = &immersion.transfer;
    let placement = transfer
        .place(&grains.position, &grains.radius)
        .expect("inside");
    let model = model(grains, DT);
    let mut porosity = transfer.deposit(&placement, |i| grains.volume[i]);
    porosity.iter_mut().for_each(|value| *value = 1.0 - *value);
    let flow = flow::<D>(transfer.node_count(), 500);
    let mut response = Response::of_matrix(transfer, &placement, porosity, &model);
    let correction = response.correction(transfer, &placement, &model, &flow);
    let owed = &grains.carried_force;
    response.set_sources(transfer, &placement, &model, &correction, owed);
    let force = immersion.force(grains, &flow, &placement, &model.drag);
    let residual: Vec<Vector<D>> = grains.velocity.iter().map(|v| v * residual).collect();
    let modelled = model.velocity(&force);
    let mean_velocity = modelled.iter().zip(&residual).map(|(v, r)| v + r);
    Outcome {
        passes: 1,
        pass: Pass {
            grains: Candidate {
                mean_velocity: mean_velocity.collect(),
                velocity: grains.mean_velocity.clone(),
                ..Candidate::default()
            },
            flow,
            force,
            residual,
            defect: Defect {
                momentum: 0.125,
                ..Defect::default()
            },
        },
        placement,
        model,
        response,
        lagged: vec![Vector::zeros(); grains.count()],
        carried_force: Vec::new(),
    }
}

fn balanced<const D: usize, const N: usize>(depth: f64)
where
    Dim<D>: Dimension<D>,
{
    let immersion = immersion::<D, N>(depth);
    let mut grains = grains::<D>(20);
    let unbalanced = outcome(&immersion, &grains, 0.5);
    let with_residual = of_coupled_step(&immersion, &grains, &unbalanced, 0.0, DT);
    grains.carried_force.fill(Vector::zeros());
    let exact = outcome(&immersion, &grains, 0.0);
    let budget = of_coupled_step(&immersion, &grains, &exact, 0.0, DT);
    println!(
        "| {D} | {depth} | {:.1e} | {:.1e} | {:.1e} |",
        budget.volume_defect, with_residual.third_law_defect, budget.energy_defect
    );
    assert!(budget.volume_defect < 1e-14);
    assert!(budget.third_law_defect < 1e-12);
    // what is owed and what was owed are in it
    assert!(with_residual.third_law_defect < 1e-12);
    assert_eq!(with_residual.momentum_defect, 0.125);
    assert!(budget.energy_defect < 1e-12);
    assert!(with_residual.energy_defect > 1e-3);
    powers(&immersion, &grains, &exact, &budget);
    // nothing weighs: relative to the forces that there are
    let weightless = Immersion {
        gravity: Vector::zeros(),
        ..immersion
    };
    let exact = outcome(&weightless, &grains, 0.0);
    let budget = of_coupled_step(&weightless, &grains, &exact, 0.0, DT);
    assert!(budget.third_law_defect < 1e-12 && budget.energy_defect < 1e-12);
}

/// Powers of the grains one by one.
fn powers<const D: usize, const N: usize>(
    immersion: &Immersion<D, N>,
    grains: &Grains<D>,
    outcome: &Outcome<D, N>,
    budget: &Budget,
) where
    Dim<D>: Dimension<D>,
{
    let pass = &outcome.pass;
    let fluid = immersion
        .transfer
        .sample(&outcome.placement, &pass.flow.velocity);
    let (mut gravity, mut drag, mut contact) = (0.0, 0.0, 0.0);
    for i in 0..grains.count() {
        let mean = pass.grains.mean_velocity[i];
        let on_grain = pass.force[i] - mean * outcome.model.drag[i];
        let change = (pass.grains.velocity[i] - grains.velocity[i]) * (grains.mass[i] / DT);
        let in_fluid = grains.mass[i] - DENSITY * grains.volume[i];
        gravity += in_fluid * dot(&immersion.gravity, &mean);
        drag += outcome.model.drag[i] * hypot(&(fluid[i] - mean)).powi(2);
        let contact_force = change - on_grain - immersion.gravity * grains.mass[i];
        contact -= dot(&contact_force, &mean);
    }
    for (found, expected) in [
        (budget.gravity_power, gravity),
        (budget.drag_dissipation, drag),
        (budget.contact_dissipation, contact),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
    }
    // P_nod is −P_int − drag where (B3) holds: what the fluid says enters the loss with a minus
    let scale = gravity.abs().max(drag);
    let told = of_coupled_step(immersion, grains, outcome, 2.0, DT);
    let step = (budget.transfer_loss - told.transfer_loss) * scale;
    assert!((step / (2.0 * immersion.transfer.depth()) - 1.0).abs() < 1e-9);
    let interaction: f64 = (0..grains.count())
        .map(|i| {
            let mean = pass.grains.mean_velocity[i];
            dot(&(pass.force[i] - mean * outcome.model.drag[i]), &mean)
        })
        .sum();
    let nodal = -interaction - drag;
    assert!((budget.transfer_loss * scale / nodal - 1.0).abs() < 1e-9);
}

#[test]
fn a_step_that_follows_the_model_balances_volume_momentum_and_energy() {
    println!("| D | depth | volume | third law | energy |");
    balanced::<2, 3>(1.0);
    balanced::<2, 3>(0.3);
    balanced::<3, 4>(1.0);
}

#[test]
fn what_is_missing_is_told_over_the_weight_and_the_volume() {
    let immersion = immersion::<2, 3>(1.0);
    let mut grains = grains::<2>(20);
    let mut outcome = outcome(&immersion, &grains, 0.0);
    let weight: f64 = (0..20)
        .map(|i| (grains.mass[i] - DENSITY * grains.volume[i]).abs())
        .sum::<f64>()
        * hypot(&immersion.gravity);
    // 6 N in x and 8 N in y that the fluid was not told of
    outcome.lagged[3] = Vector::from([6.0, 8.0]);
    let budget = of_coupled_step(&immersion, &grains, &outcome, 0.0, DT);
    assert!((budget.third_law_defect * weight / 10.0 - 1.0).abs() < 1e-10);
    let all: f64 = grains.volume.iter().sum();
    grains.volume[0] += 0.5 * all;
    let budget = of_coupled_step(&immersion, &grains, &outcome, 0.0, DT);
    assert!((budget.volume_defect * 3.0 - 1.0).abs() < 1e-12);
}
