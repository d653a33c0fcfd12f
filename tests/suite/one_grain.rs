//! One grain in fluid at rest that does not feel it: the drag law and its time scheme alone.

use coupler::simulation::Simulation;
use coupler::transfer::Transfer;
use protocol::engine::InitialGrains;
use protocol::scene::{CouplerScene, Geometry};
use space::flat::numbers;
use tests::reference::{number, rows};
use tests::{couple, fluid, orders, particles, scene};

/// A row of `terminal_velocity.csv`.
struct Material {
    name: String,
    grain_density: f64,
    radius: f64,
    density: f64,
    viscosity: f64,
    geometry: Geometry,
    terminal_speed: f64,
    relaxation_time: f64,
}

fn materials() -> Vec<Material> {
    let material = |row: &Vec<String>| Material {
        name: row[0].clone(),
        grain_density: number(row, 1),
        radius: number(row, 2),
        density: number(row, 3),
        viscosity: number(row, 4),
        geometry: if row[5] == "2" {
            Geometry::Disk
        } else {
            Geometry::Sphere { depth: 1.0 }
        },
        terminal_speed: number(row, 6),
        relaxation_time: number(row, 9),
    };
    rows("terminal_velocity.csv").iter().map(material).collect()
}

/// The grain of a material falling at `speed` in a box that it cannot leave within `steps`.
fn one_way(
    material: &Material,
    dt: f64,
    steps: usize,
    speed: f64,
) -> (CouplerScene, InitialGrains) {
    let fall = material.terminal_speed.abs() * dt * steps as f64;
    let half = 2.0 * fall + 1000.0 * material.radius;
    let gravity = [0.0, -9.81];
    let fluid = fluid(
        material.density,
        material.viscosity,
        gravity,
        [-half, -half],
        [half, half],
        [2, 2],
    );
    let mut scene = scene(Some(fluid), Some(particles(gravity)), dt, steps);
    scene.reaction = false;
    scene.geometry = material.geometry;
    let disk = std::f64::consts::PI * material.radius.powi(2);
    let volume = match material.geometry {
        Geometry::Disk => disk,
        Geometry::Sphere { .. } => 4.0 / 3.0 * disk * material.radius,
    };
    let grains = InitialGrains {
        dimension: 2,
        position: vec![0.1 * half, 0.2 * half],
        velocity: vec![0.0, -speed],
        radius: vec![material.radius],
        mass: vec![material.grain_density * volume],
        volume: vec![volume],
        fixed: vec![0.0],
    };
    (scene, grains)
}

#[test]
fn the_steady_slip_of_every_material_is_the_closed_form_for_any_step() {
    println!("| material | dim | Δt/τ | slip/closed form − 1 |");
    let mut worst = 0.0_f64;
    for (index, material) in materials().iter().enumerate() {
        // a small step needs 20 τ of steps: once is enough, the others start at rest
        let small = if index == 4 { vec![1e-3] } else { vec![] };
        for ratio in small.into_iter().chain([0.1, 1.0, 1e3, 1e6]) {
            let (steps, start) = match ratio {
                1e-3 => (12_000, 1.0001),
                0.1 => (400, 0.0),
                1.0 => (60, 0.0),
                _ => (12, 0.0),
            };
            let dt = ratio * material.relaxation_time;
            let (scene, grains) = one_way(material, dt, steps, start * material.terminal_speed);
            let mut coupling = couple(scene, &grains);
            for _ in 0..steps {
                coupling
                    .advance(dt)
                    .unwrap_or_else(|error| panic!("{error}"));
            }
            let slip = slip(&coupling);
            let error = (slip.abs() / material.terminal_speed.abs() - 1.0).abs();
            worst = worst.max(error);
            println!(
                "| {} | {:?} | {ratio:e} | {error:.1e} |",
                material.name, material.geometry
            );
            assert!(error < 1e-8, "{} Δt/τ {ratio}: {error}", material.name);
        }
    }
    println!("worst {worst:.1e}");
}

/// Vertical velocity of the grain relative to the fluid around it, which is at rest to round-off.
fn slip(coupling: &Simulation<2, 3>) -> f64 {
    let transfer = Transfer::new(&coupling.system.fluid().expect("a fluid").mesh, 1.0);
    let grains = &coupling.state.grains;
    let back = 0.5 * coupling.scene.coupling_step;
    let middle = grains.position[0] - grains.velocity[0] * back;
    let placement = transfer.place(&[middle], &grains.radius).expect("inside");
    transfer.sample(&placement, &coupling.state.flow.velocity)[0][1] - grains.velocity[0][1]
}

#[test]
fn the_start_from_rest_is_first_order_in_the_step() {
    let materials = materials();
    println!("| material | t/τ | steps | error of u/u_t | order |");
    for row in rows("start_up_of_one_grain.csv")
        .iter()
        .filter(|row| row[1] == "2")
    {
        let Some(material) = materials
            .iter()
            .find(|m| m.name == row[0] && m.geometry == Geometry::Disk)
        else {
            continue;
        };
        let (time, speed) = (number(row, 2), number(row, 3));
        let reached = number(row, 5);
        if !(0.35..0.8).contains(&reached) {
            continue;
        }
        let mut table = Vec::new();
        for steps in [40, 80, 160] {
            let dt = time / steps as f64;
            let (scene, grains) = one_way(material, dt, steps, 0.0);
            let mut coupling = couple(scene, &grains);
            for _ in 0..steps {
                coupling
                    .advance(dt)
                    .unwrap_or_else(|error| panic!("{error}"));
            }
            let found = -numbers(&coupling.state.grains.velocity)[1];
            table.push((dt, (found - speed).abs() / material.terminal_speed.abs()));
        }
        let orders = orders(&table);
        for (index, (dt, error)) in table.iter().enumerate() {
            let order = if index == 0 {
                f64::NAN
            } else {
                orders[index - 1]
            };
            println!(
                "| {} | {:.2} | {:.0} | {error:.2e} | {order:.2} |",
                row[0],
                time / material.relaxation_time,
                time / dt
            );
        }
        assert!(
            orders.iter().all(|order| (0.9..1.2).contains(order)),
            "{}: {orders:?}",
            row[0]
        );
        assert!(table[2].1 < 4e-3, "{}: {:?}", row[0], table[2]);
    }
}
