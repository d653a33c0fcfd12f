//! Spheres in a fluid of space: drag laws, packed beds, budgets.

use std::f64::consts::PI;

use coupler::simulation::Simulation;
use protocol::scene::{DragLaw, Scheme};
use space::flat::numbers;
use tests::grains::frozen;
use tests::in_space::{
    ball, cubic, fine_ball, fluid, mean, particles, periodic_across, scene, spheres, upward,
};
use tests::reference::{number, rows};
use tests::{couple_in_space, orders, pressure};

const GRAVITY: [f64; 3] = [0.0, -9.81, 0.0];

fn advance(coupling: &mut Simulation<3, 4>, dt: f64) -> coupler::report::StepReport {
    coupling
        .advance(dt)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Drag on a sphere that moves at this speed in clear fluid \[N\], as the authors of each law give it.
fn drag(law: DragLaw, density: f64, viscosity: f64, diameter: f64, speed: f64) -> f64 {
    let reynolds = density * diameter * speed / viscosity;
    let area = 0.25 * PI * diameter * diameter;
    let dallavalle = (0.63 + 4.8 / reynolds.sqrt()).powi(2);
    let coefficient = match law {
        DragLaw::Dallavalle | DragLaw::DiFelice | DragLaw::Migflow => dallavalle,
        DragLaw::WenYu | DragLaw::Gidaspow if reynolds < 1000.0 => {
            24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687))
        }
        DragLaw::WenYu | DragLaw::Gidaspow => 0.44,
        DragLaw::Beetstra => {
            let inertial = (1.0 + 8.4 * reynolds.powf(-0.343)) / (1.0 + reynolds.powf(-0.5));
            24.0 / reynolds * (1.0 + 0.413 / 24.0 * reynolds * inertial)
        }
        DragLaw::Stokes => 24.0 / reynolds,
    };
    0.5 * density * area * coefficient * speed * speed
}

/// Speed at which the drag is this weight, by bisection.
fn terminal_speed(drag: impl Fn(f64) -> f64, weight: f64) -> f64 {
    let (mut low, mut high) = (1e-12, 1e3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        match drag(middle) < weight {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// One sphere in a box that it cannot leave, which does not feel it, after so many steps of this length.
fn fallen(law: DragLaw, (radius, density): (f64, f64), dt: f64, steps: usize, reach: f64) -> f64 {
    let half = 3.0 * reach + 1000.0 * radius;
    let fluid = fluid(1000.0, 1e-3, GRAVITY, [-half; 3], [half; 3], [2; 3]);
    let mut scene = scene(Some(fluid), Some(particles(GRAVITY)), dt, steps);
    (scene.reaction, scene.drag) = (false, law);
    let grains = spheres(
        &[[0.1 * half, 0.2 * half, -0.15 * half]],
        &[radius],
        density,
    );
    let mut coupling = couple_in_space(scene, &grains);
    for _ in 0..steps {
        advance(&mut coupling, dt);
    }
    -numbers(&coupling.state.grains.velocity)[1]
}

#[test]
fn a_sphere_falls_at_the_terminal_velocity_of_each_law() {
    println!("| law | r [m] | Re | speed [m/s] | error |");
    let laws = [
        DragLaw::Dallavalle,
        DragLaw::DiFelice,
        DragLaw::WenYu,
        DragLaw::Gidaspow,
        DragLaw::Beetstra,
        DragLaw::Stokes,
        DragLaw::Migflow,
    ];
    let mut worst: f64 = 0.0;
    for law in laws {
        for (radius, density) in [(5e-5, 2500.0), (5e-4, 2650.0), (5e-3, 2650.0)] {
            let weight = (density - 1000.0) * 4.0 / 3.0 * PI * f64::powi(radius, 3) * 9.81;
            let force = |speed: f64| drag(law, 1000.0, 1e-3, 2.0 * radius, speed);
            let speed = terminal_speed(force, weight);
            let mass = density * weight / ((density - 1000.0) * 9.81);
            let dt = mass * speed / force(speed);
            let found = fallen(law, (radius, density), dt, 80, 80.0 * dt * speed);
            let error = (found / speed - 1.0).abs();
            let reynolds = 2e6 * radius * speed;
            println!("| {law:?} | {radius} | {reynolds:.3e} | {speed:.8e} | {error:.1e} |");
            worst = worst.max(error);
        }
    }
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn the_slip_of_every_material_is_the_closed_form() {
    println!("| material | slip/closed form − 1 |");
    for row in rows("terminal_velocity.csv")
        .iter()
        .filter(|row| row[5] == "3")
    {
        let (grain, radius) = (number(row, 1), number(row, 2));
        let (density, viscosity) = (number(row, 3), number(row, 4));
        let force = |speed: f64| drag(DragLaw::Dallavalle, density, viscosity, 2.0 * radius, speed);
        let weight = (grain - density).abs() * 4.0 / 3.0 * PI * radius.powi(3) * 9.81;
        let error = (terminal_speed(force, weight) / number(row, 6).abs() - 1.0).abs();
        println!("| {} | {error:.1e} |", row[0]);
        assert!(error < 1e-8, "{}", row[0]);
    }
}

#[test]
fn the_start_from_rest_is_of_first_order_and_creeps_to_stokes() {
    // Stokes: v = v_t (1 − exp(−t/τ)), τ = m/(3πμd), without the fluid's inertia.
    let (radius, density) = (5e-5, 2500.0);
    let volume = 4.0 / 3.0 * PI * f64::powi(radius, 3);
    let gamma = 6.0 * PI * 1e-3 * radius;
    let (tau, speed) = (density * volume / gamma, 1500.0 * volume * 9.81 / gamma);
    let exact = speed * (1.0 - (-1.0_f64).exp());
    let error = |steps: usize| {
        let dt = tau / steps as f64;
        let found = fallen(DragLaw::Stokes, (radius, density), dt, steps, tau * speed);
        (dt, (found / exact - 1.0).abs())
    };
    let table = [20, 40, 80].map(error);
    let orders = orders(&table);
    println!("errors {table:?}, orders {orders:?}");
    assert!(orders.iter().all(|order| (0.9..1.1).contains(order)));
}

/// Pressure drop of a periodic column of fixed spheres beyond the weight of the water, over that of the closed form.
fn packed(porosity: f64, radius: f64, speed: f64) -> f64 {
    let spacing = radius * (4.0 / 3.0 * PI / (1.0 - porosity)).cbrt();
    let counts = [4, 16, 4];
    let upper = counts.map(|count| count as f64 * spacing);
    let fluid = fluid(1000.0, 1e-3, GRAVITY, [0.0; 3], upper, [1, 4, 1]);
    let fluid = upward(periodic_across(fluid), speed);
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(upper[0]), None, Some(upper[2])];
    let mut scene = scene(Some(fluid), Some(engine), 1.0, 3);
    (scene.scheme, scene.drag) = (Scheme::Staggered, DragLaw::Gidaspow);
    let centres = cubic([0.0; 3], spacing, counts);
    let count = centres.len();
    let grains = frozen(spheres(&centres, &vec![radius; count], 2500.0));
    let mut coupling = couple_in_space(scene, &grains);
    for _ in 0..12 {
        let report = advance(&mut coupling, 1.0);
        assert!(report.budget.third_law_defect < 1e-12);
    }
    let pressure = pressure(&mut coupling);
    let nodes = &coupling.system.fluid().expect("a fluid").mesh.node_position;
    let level = |y: f64| {
        let at = |node: &usize| (nodes[*node][1] - y).abs() < 1e-9 * upper[1];
        let at: Vec<f64> = (0..nodes.len())
            .filter(at)
            .map(|node| pressure[node])
            .collect();
        at.iter().sum::<f64>() / at.len() as f64
    };
    level(0.0) - level(upper[1]) - 1000.0 * 9.81 * upper[1]
}

#[test]
fn a_lattice_of_fixed_spheres_has_the_pressure_drop_of_ergun() {
    println!("| porosity | Re | Δp/L of Ergun [Pa/m] | relative error |");
    for porosity in [0.48_f64, 0.55, 0.6] {
        for (radius, speed) in [(5e-5, 1e-4), (5e-4, 1e-2), (5e-3, 0.2)] {
            let (solid, diameter) = (1.0 - porosity, 2.0 * radius);
            let viscous = 150.0 * 1e-3 * solid * solid / (porosity.powi(3) * diameter * diameter);
            let inertial = 1.75 * 1000.0 * solid / (porosity.powi(3) * diameter);
            let expected = viscous * speed + inertial * speed * speed;
            let spacing = radius * (4.0 / 3.0 * PI / solid).cbrt();
            let found = packed(porosity, radius, speed) / (16.0 * spacing);
            let error = (found / expected - 1.0).abs();
            let reynolds = 1e6 * diameter * speed;
            println!("| {porosity} | {reynolds:.0e} | {expected:.6e} | {error:.1e} |");
            assert!(error < 1e-6, "φ {porosity}, Re {reynolds}: {error:e}");
        }
    }
}

#[test]
fn a_cloud_of_spheres_keeps_all_budgets() {
    let count = 300;
    let radius = (0.15_f64 / count as f64).cbrt();
    let gravity = [0.0, -1.0, 0.0];
    let fluid = fluid(1.0, 1.0, gravity, [-4.0; 3], [4.0; 3], [4; 3]);
    let fluid = fine_ball(fluid, [0.0; 3], 1.2, (0.5, 0.8));
    let mut scene = scene(Some(fluid), Some(particles(gravity)), 0.2, 6);
    scene.drag = DragLaw::Dallavalle;
    let centres = ball([0.0; 3], 1.0 - radius, count, 2.0 * radius);
    let grains = spheres(&centres, &vec![radius; count], 4.0);
    let mut coupling = couple_in_space(scene, &grains);
    println!("| step | volume | momentum | third law | energy | fall speed |");
    for step in 1..=6 {
        let report = advance(&mut coupling, 0.2);
        let budget = &report.budget;
        let speed = -mean(numbers(&coupling.state.grains.velocity), 1);
        println!(
            "| {step} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {speed:.4} |",
            budget.volume_defect,
            budget.momentum_defect,
            budget.third_law_defect,
            budget.energy_defect
        );
        assert!(budget.volume_defect < 1e-6 && budget.third_law_defect < 1e-12);
        assert!(budget.momentum_defect < 1e-3);
    }
    let across = [0, 2].map(|axis| mean(numbers(&coupling.state.grains.velocity), axis).abs());
    let down = -mean(numbers(&coupling.state.grains.velocity), 1);
    assert!(
        across.iter().all(|speed| *speed < 0.05 * down),
        "{across:?} beside {down}"
    );
}

/// Fall speed of a creeping cloud of radius 1 in a closed box of 16 × 32 × 16, without the slip of its own grains, in
/// units c Δρ g R²/μ; nodes.
fn creeping_fall(
    fraction: f64,
    count: usize,
    size: f64,
    (growth, largest): (f64, f64),
) -> (f64, usize) {
    let (excess, viscosity, density) = (1e-3, 1.0, 1e-3);
    let gravity = [0.0, -1.0 / (fraction * excess), 0.0];
    let fluid = fluid(
        density,
        viscosity,
        gravity,
        [-8.0, -16.0, -8.0],
        [8.0, 16.0, 8.0],
        [6, 12, 6],
    );
    let mut fluid = fine_ball(fluid, [0.0; 3], 1.5, (size, growth));
    if let Some(sizes) = &mut fluid.refinement {
        sizes.largest = Some(largest);
    }
    let scene = scene(Some(fluid), Some(particles(gravity)), 0.5, 3);
    let radius = (fraction / count as f64).cbrt();
    let centres = ball([0.0; 3], 1.0, count, 2.0 * radius);
    let grains = spheres(&centres, &vec![radius; count], density + excess);
    let mut coupling = couple_in_space(scene, &grains);
    for _ in 0..3 {
        advance(&mut coupling, 0.5);
    }
    let speed = -mean(numbers(&coupling.state.grains.velocity), 1);
    // Dallavalle at rest: γ = ½ A 4.8² μ/(φ d) φ^−1.8, less the buoyancy that the porosity makes.
    let porosity = 1.0 - fraction;
    let gamma =
        0.5 * PI * radius * radius * 4.8 * 4.8 * viscosity / (2.0 * radius) * porosity.powf(-2.8);
    let weight = 4.0 / 3.0 * PI * radius.powi(3) / fraction;
    let nodes = coupling
        .system
        .fluid()
        .expect("a fluid")
        .mesh
        .node_position
        .len();
    (speed - weight / gamma, nodes)
}

/// Hadamard (1911) and Rybczyński (1911) for a drop of viscosity ratio φ, in a square duct of half width 8 to first
/// order.
fn expected_fall(fraction: f64) -> f64 {
    let porosity = 1.0 - fraction;
    let free = 2.0 / 3.0 * (1.0 + porosity) / (2.0 + 3.0 * porosity);
    free * (1.0 - 1.9033 * 5.0 / 6.0 / 8.0)
}

/// `cargo test --release --workspace --test suite creeping_cloud -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn a_creeping_cloud_of_spheres_falls_as_a_drop() {
    println!("| c | N | cells | nodes | fall | against the drop |");
    let far = (0.14, 1.1);
    let mut table = Vec::new();
    for halvings in [11.0, 12.0, 14.0] {
        let size = 8.0 / 3.0 * f64::exp2(-halvings / 3.0);
        let (fall, nodes) = creeping_fall(0.02, 20_000, size * (1.0 + 1e-9), far);
        let error = fall / expected_fall(0.02) - 1.0;
        println!(
            "| 0.02 | 20000 | R/{:.2} | {nodes} | {fall:.5} | {:+.2} % |",
            1.0 / size,
            100.0 * error
        );
        table.push((size, error.abs()));
    }
    let [(coarse, first), (fine, last)] = [table[1], table[2]];
    let share = (coarse / fine).powi(2) - 1.0;
    let extrapolated = last - (first - last) / share;
    println!(
        "orders {:?}, extrapolated {:+.2} %",
        orders(&table),
        -100.0 * extrapolated
    );
    let mut falls = Vec::new();
    for fraction in [0.02, 0.1, 0.2] {
        let (fall, nodes) = creeping_fall(fraction, 30_000, 1.0 / 6.0 * (1.0 + 1e-9), (0.28, 2.2));
        let ratio = fall / expected_fall(fraction);
        println!(
            "| {fraction} | 30000 | R/6 | {nodes} | {fall:.5} | {:+.2} % |",
            100.0 * (ratio - 1.0)
        );
        falls.push(ratio);
    }
    assert!(last < 0.015 && extrapolated.abs() < 0.005);
    assert!(
        falls
            .iter()
            .all(|ratio| (ratio / falls[0] - 1.0).abs() < 0.01)
    );
}
