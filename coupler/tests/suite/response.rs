//! (R1)–(R4): the model of a grain, and that the fluid is told what the grains feel.

use coupler::coupled::response::{Model, free_response};
use coupler::state::{Candidate, Flow, Grains, Response};
use coupler::transfer::Transfer;
use space::{Dim, Dimension, Vector, vector};

use crate::mesh::{cube, noise, points};

/// v̄ of (R1), sub-step by sub-step, in one dimension.
fn stepped(mass: f64, drag: f64, dt: f64, sub_steps: u32, velocity: f64, force: f64) -> f64 {
    let step = dt / f64::from(sub_steps);
    let (mut velocity, mut sum) = (velocity, 0.0);
    for _ in 0..sub_steps {
        velocity = (mass * velocity / step + force) / (mass / step + drag);
        sum += velocity;
    }
    sum / f64::from(sub_steps)
}

#[test]
fn the_free_response_is_the_mean_of_implicit_sub_steps() {
    for (mass, drag, dt) in [(2.0, 3.0, 0.7), (1.0, 1e3, 1.0), (5.0, 0.0, 0.1)] {
        for sub_steps in [1, 2, 3, 17] {
            let (keep, mobility) = free_response(mass, drag, dt, sub_steps);
            for (velocity, force) in [(1.0, 0.0), (0.0, 1.0), (-0.3, 2.5)] {
                let found = keep * velocity + mobility * force;
                let expected = stepped(mass, drag, dt, sub_steps, velocity, force);
                assert!(
                    (found - expected).abs() < 1e-14,
                    "{sub_steps}: {found} for {expected}"
                );
            }
        }
    }
    assert_eq!(free_response(2.0, 3.0, 1.0, 1), (0.4, 0.2));
}

/// Some grains of any kind in the unit cube, the third of them fixed.
pub fn grains<const D: usize>(count: usize) -> Grains<D> {
    let some = |seed: usize| -> Vec<Vector<D>> {
        let vector = |i: usize| vector::from_fn(|axis| noise(seed + D * i + axis) - 0.5);
        (0..count).map(vector).collect()
    };
    let positive = |seed: usize| (0..count).map(|i| 0.1 + noise(seed + 3 * i)).collect();
    let volume: Vec<f64> = positive(5);
    Grains {
        position: points(count),
        velocity: some(100),
        mean_velocity: some(200),
        contact: vec![Default::default(); count],
        spin: Vec::new(),
        contact_force: some(300),
        carried_force: some(400),
        mass: positive(6),
        volume: volume.iter().map(|v| 1e-3 * v).collect(),
        radius: positive(7),
        fixed: (0..count).map(|i| i == 2).collect(),
        id: (0..count as u64).collect(),
    }
}

/// λ from 0 to 1, γ up to stiff.
pub fn model<const D: usize>(grains: &Grains<D>, dt: f64) -> Model<D> {
    let drag = (0..grains.count()).map(|i| 10_f64.powf(4.0 * noise(9 * i) - 2.0));
    let gravity = vector::from_fn(|axis| 0.3 - 9.81 * axis as f64);
    let mut model = Model::free(grains, drag.collect(), &gravity, dt, 2);
    for (i, lambda) in model.lambda.iter_mut().enumerate() {
        *lambda = [0.0, 0.5, 0.8, 1.0][i % 4];
    }
    model
}

/// Rough nodal fields.
pub fn flow<const D: usize>(nodes: usize, seed: usize) -> Flow<D> {
    let some = |seed: usize| -> Vec<Vector<D>> {
        let vector = |a: usize| vector::from_fn(|axis| noise(seed + D * a + axis) - 0.5);
        (0..nodes).map(vector).collect()
    };
    Flow {
        velocity: some(seed),
        pressure_gradient: some(seed + 77).iter().map(|g| g * 1e2).collect(),
    }
}

/// Largest difference over largest size.
pub fn apart<const D: usize>(a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
    let size =
        |all: &mut dyn Iterator<Item = Vector<D>>| all.fold(0.0_f64, |max, v| max.max(v.amax()));
    let largest = size(&mut b.iter().copied());
    size(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest
}

fn tells_what_grains_feel<const D: usize, const N: usize>(radius: f64, depth: f64)
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(4, 0.3, false);
    let transfer = Transfer::new(&mesh, depth);
    let mut grains = grains::<D>(30);
    grains.radius = vec![radius; 30];
    let model = model(&grains, 0.01);
    let placement = transfer
        .place(&grains.position, &grains.radius)
        .expect("inside");
    let porosity = vec![1.0; transfer.node_count()];
    let reference = flow::<D>(transfer.node_count(), 1000);
    let mut response = Response::of_matrix(&transfer, &placement, porosity, &model);
    let correction = response.correction(&transfer, &placement, &model, &reference);
    let owed = &grains.carried_force;
    response.set_sources(&transfer, &placement, &model, &correction, owed);
    // at w* and G* the fluid is told exactly what the model of each grain feels, node by node
    let velocity = transfer.sample(&placement, &reference.velocity);
    let gradient = transfer.sample(&placement, &reference.pressure_gradient);
    let force: Vec<Vector<D>> = (0..grains.count())
        .map(|i| velocity[i] * model.drag[i] - gradient[i] * model.volume[i])
        .collect();
    let modelled = model.velocity(&force);
    let on_fluid = transfer.deposit(&placement, |i| {
        let drag = (modelled[i] - velocity[i]) * model.drag[i];
        drag + owed[i]
    });
    let flux = transfer.deposit(&placement, |i| modelled[i] * model.volume[i]);
    let nodes = 0..transfer.node_count();
    let told: Vec<Vector<D>> = nodes
        .clone()
        .map(|a| {
            response.drag_source[a]
                - reference.velocity[a] * response.drag[a]
                - reference.pressure_gradient[a] * response.entrained_fraction[a]
        })
        .collect();
    let told_flux: Vec<Vector<D>> = nodes
        .map(|a| {
            response.solid_flux[a] + reference.velocity[a] * response.entrained_fraction[a]
                - reference.pressure_gradient[a] * response.solid_mobility[a]
        })
        .collect();
    let (force, flux) = (apart(&told, &on_fluid), apart(&told_flux, &flux));
    println!("| {D} | {radius} | {depth} | {force:.1e} | {flux:.1e} |");
    assert!(force < 1e-12 && flux < 1e-12, "{force} {flux}");
}

#[test]
fn at_the_reference_the_fluid_is_told_what_every_grain_feels() {
    println!("| D | r | depth | force | flux |");
    for radius in [0.01, 0.2] {
        tells_what_grains_feel::<2, 3>(radius, 1.0);
        tells_what_grains_feel::<2, 3>(radius, 0.3);
        tells_what_grains_feel::<3, 4>(radius, 1.0);
    }
}

fn entrains<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D>,
{
    // one grain on a node: T is a division by ℓ
    let mesh = cube::<D, N>(2, 0.0, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let node = mesh.node_position.len() / 2;
    let at = mesh.node_position[node];
    let placement = transfer.place(&[at], &[0.0]).expect("inside");
    let model = Model::<D> {
        drag: vec![4.0],
        volume: vec![0.2],
        mobility: vec![0.15],
        lambda: vec![0.5],
        free_velocity: vec![Vector::zeros()],
        fixed: vec![true],
    };
    assert!((model.entrainment(0) - 0.3).abs() < 1e-15);
    let response = Response::of_matrix(&transfer, &placement, Vec::new(), &model);
    let mass = mesh.nodal_mass[node];
    for (found, expected) in [
        (response.drag[node], 4.0 * 0.7 / mass),
        (response.fixed_drag[node], 4.0 * 0.7 / mass),
        (response.entrained_fraction[node], 0.2 * 0.3 / mass),
        (response.solid_mobility[node], 0.04 * 0.5 * 0.15 / mass),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn a_grain_on_a_node_gives_the_coefficients_of_its_affine_map() {
    entrains::<2, 3>();
    entrains::<3, 4>();
}

#[test]
fn a_calibrated_model_gives_the_candidate_back_and_fixed_grains_do_not_answer() {
    let grains = grains::<3>(9);
    let mut model = model(&grains, 0.1);
    assert_eq!(model.mobility[2], 0.0);
    assert_eq!(model.free_velocity[2], Vector::<3>::zeros());
    let force: Vec<Vector<3>> = grains.contact_force.iter().map(|f| f * 10.0).collect();
    let candidate = Candidate {
        mean_velocity: grains.mean_velocity.clone(),
        ..Candidate::default()
    };
    let before = model.residual(&force, &candidate);
    let one = candidate.mean_velocity[1]
        - (model.free_velocity[1] + force[1] * (0.5 * model.mobility[1]));
    assert!((before[1] - one).norm() < 1e-15);
    model.calibrate(&candidate, &force);
    let after = model.residual(&force, &candidate);
    assert!(after.iter().all(|r| r.norm() < 1e-14), "{after:?}");
}
