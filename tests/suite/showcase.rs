//! The splitting cloud (Ga = 10) against an independent two-fluid solver.

use coupler::simulation::Simulation;
use space::flat::numbers;
use tests::reference::{number, rows};
use tests::{couple, mean, node_count, pressure};

use crate::cloud::{Cloud, DENSITY, advance};

#[test]
#[ignore = "takes 15 min: cargo test --release -p tests --test suite -- --ignored showcase --nocapture"]
fn the_showcase_follows_the_independent_two_fluid_solution() {
    follows(None);
}

#[test]
#[ignore = "takes a minute: cargo test --release -p tests --test suite -- --ignored showcase_on_cells --nocapture"]
fn the_showcase_on_cells_that_follow_it_follows_the_independent_two_fluid_solution() {
    follows(Some(3));
}

/// The splitting cloud on cells of R/6 follows the reference, whether they are everywhere or near grains only.
fn follows(halvings: Option<u32>) {
    // viscosity and grain inertia of the reference: c = 0.02 and ρ_p = 11 ρ
    let cloud = Cloud {
        radius: 3.708e-3,
        solid_fraction: 0.02,
        grain_density: 11.0 * DENSITY,
        density: DENSITY,
        gravity: 9.81,
        box_size: [20.0, 60.0],
        centre: 54.0,
        cells_per_radius: 6,
        halvings,
        count: 2000,
        convection: true,
    };
    let scene = cloud.scene(0.4);
    let dt = scene.coupling_step;
    let grains = cloud.grains();
    let start = mean(&grains.position, 1);
    let mut coupling = couple(scene, &grains);
    let reference = rows("cloud_ga10.csv");
    let (mut fastest, mut nodes) = ((0.0, 0.0), 0);
    let (mut off_axis_since, mut wide_since) = (None, None);
    println!("| t* | fall/R | V | width/R | reference fall | V | width |");
    for index in 1..=375 {
        advance(&mut coupling, dt);
        nodes = nodes.max(node_count(&coupling));
        let time = 0.4 * f64::from(index);
        let speed = -mean(numbers(&coupling.state.grains.velocity), 1) / cloud.speed_unit();
        if speed > fastest.1 {
            fastest = (time, speed);
        }
        let (offset, curvature) = overpressure(&mut coupling, &cloud);
        if curvature < 0.0 {
            off_axis_since = None;
        } else if off_axis_since.is_none() {
            off_axis_since = Some(time);
        }
        if offset < 0.5 {
            wide_since = None;
        } else if wide_since.is_none() {
            wide_since = Some(time);
        }
        let Some(row) = reference
            .iter()
            .find(|row| (number(row, 0) - time).abs() < 1e-9)
        else {
            continue;
        };
        let fall = (start - mean(numbers(&coupling.state.grains.position), 1)) / cloud.radius;
        let width = width(&coupling) / cloud.radius;
        let [fall_ref, speed_ref, width_ref] = [4, 8, 12].map(|column| number(row, column));
        println!(
            "| {time:.0} | {fall:.3} | {speed:.4} | {width:.3} | {fall_ref:.3} | {speed_ref:.4} | {width_ref:.3} |"
        );
        if [10.0, 20.0, 40.0, 60.0]
            .iter()
            .any(|t| (t - time).abs() < 1e-9)
        {
            for (found, expected) in [(fall, fall_ref), (speed, speed_ref), (width, width_ref)] {
                assert!(
                    (found / expected - 1.0).abs() < 0.02,
                    "t* {time}: {found} for {expected}"
                );
            }
        }
    }
    let lobes = lobe_count(&coupling, &cloud);
    println!(
        "at most {nodes} nodes; V_max {:.4} at t* = {:.1}; overpressure has a dimple on the axis from t* = {off_axis_since:?}, its maximum half a radius off from {wide_since:?}; lobes {lobes}",
        fastest.1, fastest.0
    );
    assert!((fastest.1 / 0.2005 - 1.0).abs() < 0.02);
    assert!(
        off_axis_since.is_some_and(|time| (time - 70.0).abs() <= 5.0),
        "{off_axis_since:?}"
    );
    assert_eq!(lobes, 2);
}

fn width(coupling: &Simulation<2, 3>) -> f64 {
    let x = numbers(&coupling.state.grains.position).iter().step_by(2);
    x.clone().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) - x.fold(f64::INFINITY, |a, &b| a.min(b))
}

/// How far from the axis the overpressure below the cloud is largest, over R; and the curvature of the
/// overpressure across the axis, positive where the axis is a dimple.
///
/// The overpressure of a column of nodes is its largest value there. Near the splitting it is flat over
/// more than a radius, so that where its maximum lies is a matter of a thousandth; the sign of the
/// curvature of a parabola through all columns within R is not.
fn overpressure(coupling: &mut Simulation<2, 3>, cloud: &Cloud) -> (f64, f64) {
    let pressure = pressure(coupling);
    let seat = coupling.system.fluid().expect("a fluid");
    let heights = numbers(&coupling.state.grains.position)
        .iter()
        .skip(1)
        .step_by(2);
    let centre = mean(numbers(&coupling.state.grains.position), 1);
    let below = heights.fold(f64::INFINITY, |a, &b| a.min(b)) - 2.0 * cloud.radius;
    let mut columns = std::collections::BTreeMap::<i64, f64>::new();
    for (node, pressure) in seat.mesh.node_position.iter().zip(&pressure) {
        if (below..centre + cloud.radius).contains(&node[1]) {
            let column = (node[0] / cloud.radius * cloud.cells_per_radius as f64).round() as i64;
            let over = pressure + cloud.density * cloud.gravity * node[1];
            let largest = columns.entry(column).or_insert(f64::NEG_INFINITY);
            *largest = largest.max(over);
        }
    }
    let position = |column: i64| column as f64 / cloud.cells_per_radius as f64;
    let top = columns.iter().max_by(|a, b| a.1.total_cmp(b.1));
    let offset = position(*top.expect("nodes").0).abs();
    let near: Vec<(f64, f64)> = columns
        .iter()
        .map(|(&column, &over)| (position(column).powi(2), over))
        .filter(|(square, _)| *square <= 1.0)
        .collect();
    let count = near.len() as f64;
    let (x, y) = (
        near.iter().map(|p| p.0).sum::<f64>() / count,
        near.iter().map(|p| p.1).sum::<f64>() / count,
    );
    let covariance: f64 = near.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let variance: f64 = near.iter().map(|p| (p.0 - x).powi(2)).sum();
    (
        offset,
        covariance / variance / (cloud.force() * cloud.radius),
    )
}

/// Peaks of the density of grains across the box, in bins of half a radius, smoothed.
fn lobe_count(coupling: &Simulation<2, 3>, cloud: &Cloud) -> usize {
    let mut bins = [0.0_f64; 40];
    for x in numbers(&coupling.state.grains.position).iter().step_by(2) {
        let bin = ((x / cloud.radius + 10.0) / 0.5).clamp(0.0, 39.0) as usize;
        bins[bin] += 1.0;
    }
    let smooth: Vec<f64> = (0..40)
        .map(|i| {
            (-2_i32..=2)
                .map(|k| bins[(i + k).clamp(0, 39) as usize])
                .sum::<f64>()
                / 5.0
        })
        .collect();
    let floor = 0.5 * smooth.iter().copied().fold(0.0, f64::max);
    (0..40)
        .filter(|&i| smooth[i] > floor && (i == 0 || smooth[i - 1] <= floor))
        .count()
}
