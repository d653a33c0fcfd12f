//! Fluid that enters by an open side comes from rest outside: it brings no energy of its own.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::equations::ViscousForm;
use fluid_solver::mesh::Rectangle;
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

const WATER: f64 = 1000.0;
const GRAVITY: f64 = -9.81;
const WIDTH: f64 = 0.02;
const HEIGHT: f64 = 0.04;

/// A column of water that moves down, no-slip sides, top and bottom open at hydrostatic pressure.
fn column(cells: [usize; 2], form: ViscousForm, scheme: TimeScheme) -> FluidSolver<2, 3> {
    let mesh = Rectangle::new([0.0; 2], [WIDTH, HEIGHT], cells)
        .mesh()
        .unwrap();
    let mut config = FluidConfig::new(WATER, 1e-2)
        .with("all", Condition::NoSlip)
        .with("top", Condition::Open(0.0))
        .with("bottom", Condition::Open(-WATER * GRAVITY * HEIGHT));
    config.gravity = [0.0, GRAVITY].into();
    config.initial_velocity = [0.0, -0.3].into();
    (config.viscous_form, config.time_scheme) = (form, scheme);
    FluidSolver::new(config, mesh).unwrap()
}

fn table(numbers: &[f64]) -> String {
    let numbers = numbers.iter().map(|number| format!("{number:.2e} "));
    numbers.collect()
}

#[test]
fn a_column_between_two_open_ends_comes_to_rest() {
    // Without what brakes the fluid that enters, its energy was 1.5e5 J/m after 0.25 s.
    println!(
        "cells     form       scheme          energy after 0, 0.25, 0.5, 0.75, 1 s [J/m]   defect"
    );
    for (cells, form, scheme) in [
        ([10, 20], ViscousForm::Symmetric, TimeScheme::BackwardEuler),
        (
            [10, 20],
            ViscousForm::PaperLiteral,
            TimeScheme::BackwardEuler,
        ),
        ([20, 40], ViscousForm::Symmetric, TimeScheme::Bdf2),
    ] {
        let mut solver = column(cells, form, scheme);
        let (mut energy, mut worst) = (Vec::new(), 0.0_f64);
        for step in 1..=500 {
            let found = solver
                .advance(&Request::first(step, 2e-3), &SolidFields::default())
                .unwrap();
            let number = |name: &str| found.number(name).unwrap();
            if step == 1 || step % 125 == 0 {
                energy.push(number("kinetic_energy"));
            }
            let scale = number("inertia_power").abs() + number("viscous_power");
            worst = worst.max(number("energy_defect").abs() / scale);
            solver.commit().unwrap();
        }
        println!(
            "{cells:?}  {form:?}  {scheme:?}  {}  {worst:.0e}",
            table(&energy)
        );
        assert!(
            energy.is_sorted_by(|a, b| a > b),
            "it must decay: {energy:?}"
        );
        assert!(energy[4] < 0.05 * energy[0]);
        assert!(worst < 1e-8, "energy identity");
    }
}

#[test]
fn a_reservoir_drives_a_frictionless_channel_at_bernoullis_speed() {
    println!("p [Pa]   speed    √(2p/ρ)");
    for pressure in [0.5, 8.0] {
        let mesh = Rectangle::new([0.0; 2], [0.1, 0.02], [20, 4])
            .mesh()
            .unwrap();
        let mut config = FluidConfig::new(WATER, 1e-6)
            .with("all", Condition::Slip)
            .with("left", Condition::Open(pressure))
            .with("right", Condition::Open(0.0));
        config.initial_velocity = [0.01, 0.0].into();
        let mut solver = FluidSolver::new(config, mesh).unwrap();
        for step in 1..=400 {
            solver
                .advance(&Request::first(step, 0.1), &SolidFields::default())
                .unwrap();
            solver.commit().unwrap();
        }
        // The flux across the middle, by trapezia.
        let flow = &solver.state().now.superficial_velocity;
        let nodes = solver.mesh().position.iter().zip(flow);
        let middle = nodes.filter(|(x, _)| (x[0] - 0.05).abs() < 1e-9);
        let share = |y: f64| match y == 0.0 || y == 0.02 {
            true => 0.125,
            false => 0.25,
        };
        let speed: f64 = middle.map(|(x, u)| share(x[1]) * u[0]).sum();
        let exact = f64::sqrt(2.0 * pressure / WATER);
        println!("{pressure:4}  {speed:.5}  {exact:.5}");
        assert!((speed / exact - 1.0).abs() < 0.01);
    }
}

#[test]
fn a_plug_that_flows_out_is_not_braked() {
    let mesh = Rectangle::new([0.0; 2], [0.1, 0.02], [20, 4])
        .mesh()
        .unwrap();
    let mut config = FluidConfig::new(1.0, 0.1)
        .with("all", Condition::Slip)
        .with("left", Condition::uniform([1.0, 0.0]))
        .with("right", Condition::Open(0.0));
    config.initial_velocity = [1.0, 0.0].into();
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    let found = solver
        .advance(&Request::first(1, 0.1), &SolidFields::default())
        .unwrap();
    let drop = found.number("pressure_drop").unwrap();
    println!("pressure drop of a plug flow: {drop:e} Pa");
    assert!(drop.abs() < 1e-12);
}
