//! Held zones whose drag differs from node to node, against the same β(x) on a finer mesh.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::mesh::{Mesh, Rectangle};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;
use space::Vector;

use crate::support::{Random, locate};

const CELLS: usize = 16;
const FINER: usize = 4;
/// Solid that follows the fluid through a held zone.
const FINES: f64 = 0.05;

fn channel(cells: usize) -> Mesh<2, 3> {
    Rectangle::new([0.0; 2], [1.0, 4.0], [cells, 4 * cells])
        .mesh()
        .unwrap()
}

/// Steady flow up the channel, 1 in and out, between slip walls, where besides what is held so much solid
/// follows the fluid: drop, velocity by node.
fn through(mesh: Mesh<2, 3>, drag: &[f64], follows: &[f64]) -> (f64, Vec<Vector<2>>, Mesh<2, 3>) {
    let mut config = FluidConfig::new(1.0, 1.0)
        .with("all", Condition::Slip)
        .with("bottom", Condition::uniform([0.0, 1.0]))
        .with("top", Condition::uniform([0.0, 1.0]));
    config.time_scheme = TimeScheme::Steady;
    config.convection = false;
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    let fields = SolidFields {
        drag: Some(drag),
        fixed_drag: Some(drag),
        porosity: Some(&follows.iter().map(|c| 1.0 - c).collect::<Vec<_>>()),
        entrained_fraction: Some(follows),
        ..SolidFields::default()
    };
    let candidate = solver.advance(&Request::first(1, 1.0), &fields).unwrap();
    let state = candidate.state.clone();
    let mesh = solver.mesh().clone();
    let level = |y: f64| {
        let at = mesh.position.iter().zip(&state.pressure);
        let at: Vec<f64> = at
            .filter(|(x, _)| (x[1] - y).abs() < 1e-9)
            .map(|(_, p)| *p)
            .collect();
        at.iter().sum::<f64>() / at.len() as f64
    };
    let drop = level(0.0) - level(4.0);
    (drop, state.now.superficial_velocity, mesh)
}

/// The drag of a zone over that of its nodes on average, by position.
fn zone(name: &str, x: Vector<2>, random: &mut Random) -> f64 {
    let draw = random.between(0.5, 1.5);
    let inside = match name {
        "aligned" | "random" | "fines" => (1.499..2.501).contains(&x[1]),
        "oblique" => (1.8..2.8).contains(&(x[1] + 0.7 * x[0])),
        "one node" => (x[0] - 0.5).abs() < 1e-9 && (x[1] - 2.0).abs() < 1e-9,
        "layer" => x[0] < 0.501 && (0.999..3.001).contains(&x[1]),
        _ => false,
    };
    match (inside, name) {
        (true, "random" | "fines") => draw,
        (true, _) => 1.0,
        _ => 0.0,
    }
}

#[test]
fn held_zones_are_as_right_at_any_drag_whatever_their_edge() {
    println!("| zone | βh²/μ | drop error | velocity error L2 | largest |");
    for name in ["aligned", "random", "fines", "oblique", "one node", "layer"] {
        let mut before = f64::INFINITY;
        for strength in [400.0, 4e4, 4e6] {
            let coarse = channel(CELLS);
            let mut random = Random(7);
            let scale = strength * (CELLS * CELLS) as f64;
            let at = coarse.position.iter();
            let drag: Vec<f64> = at.map(|x| scale * zone(name, *x, &mut random)).collect();
            let fine = channel(FINER * CELLS);
            let refined: Vec<f64> = (fine.position.iter())
                .map(|x| {
                    let (t, shape) = locate(&coarse, *x).unwrap();
                    let nodes = coarse.simplices[t];
                    (0..3).map(|k| shape[k].max(0.0) * drag[nodes[k]]).sum()
                })
                .collect();
            let share = if name == "fines" { FINES } else { 0.0 };
            let follow = |drag: &[f64]| -> Vec<f64> {
                let held = drag.iter().map(|b| (b / scale).min(1.0));
                held.map(|held| share * held).collect()
            };
            let (fines, finer) = (follow(&drag), follow(&refined));
            let (drop, u, coarse) = through(coarse, &drag, &fines);
            let (expected, reference, fine) = through(fine, &refined, &finer);
            let (mut square, mut whole, mut largest) = (0.0, 0.0, 0.0_f64);
            for ((x, mass), u) in coarse.position.iter().zip(&coarse.nodal_mass).zip(&u) {
                let near = |y: &Vector<2>| (x[0] - y[0]).abs() + (x[1] - y[1]).abs() < 1e-9;
                let right = reference[fine.position.iter().position(near).unwrap()];
                for d in 0..2 {
                    let error = u[d] - right[d];
                    square += mass * error * error;
                    whole += mass * right[d] * right[d];
                    largest = largest.max(error.abs());
                }
            }
            let (error, l2) = (drop / expected - 1.0, (square / whole).sqrt());
            println!(
                "| {name} | {strength:.0e} | {:+.2} % | {l2:.3} | {largest:.2} |",
                100.0 * error
            );
            match name {
                // smaller than the mesh can show: only that it does not grow
                "one node" | "layer" => assert!(l2 < 0.1),
                _ => assert!(error.abs() < 0.02, "{name} {strength}: {error}"),
            }
            assert!(l2 < 0.25, "{name} {strength}: {l2}");
            assert!(
                strength < 1e5 || l2 < 1.05 * before,
                "{name}: grows to {l2}"
            );
            before = l2;
        }
    }
}

/// Half of the nodes held, by very unequal drags, between two walls, periodic across: no corner is counted twice.
#[test]
fn action_is_reaction_and_energy_is_accounted_for_where_half_of_the_nodes_are_held() {
    let gravity = [0.0, -9.81];
    println!("| β up to | solid moves | momentum defect | energy defect | largest v at rest |");
    for strength in [1e2, 1e6, 1e8] {
        for moves in [false, true] {
            let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [12; 2]);
            rectangle.periodic = [true, false];
            let mesh = rectangle.mesh().unwrap();
            let mut random = Random(5);
            let n = mesh.node_count();
            let mut porosity = vec![1.0; n];
            let (mut drag, mut source) = (vec![0.0; n], vec![0.0; 2 * n]);
            for node in 0..n {
                if random.unit() < 0.5 {
                    porosity[node] = random.between(0.2, 0.9);
                    drag[node] = strength * random.unit();
                    for d in 0..2 {
                        let velocity = random.between(-1.0, 1.0);
                        source[2 * node + d] = if moves { drag[node] * velocity } else { 0.0 };
                    }
                }
            }
            let mut config = FluidConfig::new(1000.0, 0.1)
                .with("all", Condition::NoSlip)
                .with("left", Condition::Periodic)
                .with("right", Condition::Periodic);
            config.gravity = gravity.into();
            config.convection = false;
            config.time_scheme = TimeScheme::Steady;
            // its test ∇·(P w) has ∇P for uniform w: a force between the grains, as ever
            config.grad_div = 0.0;
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            let fields = SolidFields {
                porosity: Some(&porosity),
                drag: Some(&drag),
                fixed_drag: Some(&drag),
                drag_source: Some(&source),
                ..SolidFields::default()
            };
            let candidate = solver.advance(&Request::first(1, 1.0), &fields).unwrap();
            let energy = candidate.powers.defect().abs() / candidate.powers.scale();
            let v = candidate.interstitial_velocity.clone();
            let slope = candidate.pressure_gradient.clone();
            let forces = candidate.forces.clone();
            let (mut given, mut size) = ([0.0; 2], 0.0);
            for (node, mass) in solver.mesh().nodal_mass.iter().enumerate() {
                for d in 0..2 {
                    let weight = 1000.0 * porosity[node] * gravity[d];
                    let drag = source[2 * node + d] - drag[node] * v[node][d];
                    let buoyancy = (1.0 - porosity[node]) * slope[node][d];
                    given[d] += mass * (weight + drag + buoyancy);
                    size += mass * (weight.abs() + drag.abs());
                }
            }
            let taken = |d: usize| forces.iter().map(|f| f[d]).sum::<f64>();
            let momentum = (0..2).map(|d| (given[d] - taken(d)).abs()).sum::<f64>() / size;
            let largest = v.iter().flatten().fold(0.0_f64, |max, v| max.max(v.abs()));
            println!(
                "| {strength:.0e} | {moves} | {momentum:.1e} | {energy:.1e} | {largest:.1e} |"
            );
            assert!(momentum < 1e-10, "momentum {momentum:e}");
            if moves {
                assert!(energy < 1e-10, "energy {energy:e}");
            } else {
                assert!(largest < 1e-10, "not at rest: {largest:e}");
            }
        }
    }
}

/// Fluid and grains that move alike go on so, whatever holds half of the nodes to them.
#[test]
fn uniform_motion_goes_on_where_half_of_the_nodes_are_held_to_grains() {
    let velocity = [0.7, -0.3];
    println!("| β up to | largest of v − V over V |");
    for strength in [1e2, 1e6, 1e8] {
        let mut rectangle = Rectangle::new([0.0; 2], [1.0; 2], [12; 2]);
        rectangle.periodic = [true, true];
        let mesh = rectangle.mesh().unwrap();
        let mut random = Random(11);
        let n = mesh.node_count();
        let mut porosity = vec![1.0; n];
        let (mut drag, mut source, mut flux) = (vec![0.0; n], vec![0.0; 2 * n], vec![0.0; 2 * n]);
        for node in 0..n {
            if random.unit() < 0.5 {
                porosity[node] = random.between(0.2, 0.9);
                drag[node] = strength * random.unit();
                for d in 0..2 {
                    source[2 * node + d] = drag[node] * velocity[d];
                    flux[2 * node + d] = (1.0 - porosity[node]) * velocity[d];
                }
            }
        }
        let mut config = FluidConfig::new(1000.0, 0.1).with("all", Condition::Periodic);
        config.convection = false;
        config.time_scheme = TimeScheme::Steady;
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            fixed_drag: Some(&drag),
            drag_source: Some(&source),
            solid_flux: Some(&flux),
            ..SolidFields::default()
        };
        let candidate = solver.advance(&Request::first(1, 1.0), &fields).unwrap();
        let off = candidate.interstitial_velocity.iter();
        let off = off.map(|v| (v[0] - velocity[0]).hypot(v[1] - velocity[1]));
        let largest = off.fold(0.0, f64::max) / 0.7_f64.hypot(0.3);
        println!("| {strength:.0e} | {largest:.1e} |");
        assert!(largest < 1e-9, "{strength}: {largest:e}");
    }
}
