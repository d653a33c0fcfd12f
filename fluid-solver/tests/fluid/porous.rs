//! Flow through fixed solids whose pressure drop is known.

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::mesh::Mesh;
use fluid_solver::mesh::Rectangle;
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;

use crate::support::{at_nodes, largest_difference};

/// Steady flow from left to right at superficial velocity `inflow` between slip walls: pressure
/// drop, and the largest deviation of u from the inflow over the inflow.
fn through(mesh: Mesh<2, 3>, inflow: f64, porosity: &[f64], drag: &[f64]) -> (f64, f64) {
    let mut config = FluidConfig::new(1e-3, 1e-2)
        .with("all", Condition::Slip)
        .with("left", Condition::uniform([inflow, 0.0]))
        .with("right", Condition::Open(0.0));
    config.time_scheme = TimeScheme::Steady;
    config.convection = false;
    let mut solver = FluidSolver::new(config, mesh).unwrap();
    let fields = SolidFields {
        porosity: Some(porosity),
        drag: Some(drag),
        ..SolidFields::default()
    };
    let candidate = solver.advance(&Request::first(1, 1.0), &fields).unwrap();
    let u = &candidate.state.now.superficial_velocity;
    let deviation = largest_difference(u, |_| [inflow, 0.0].into()) / inflow;
    (candidate.number("pressure_drop").unwrap(), deviation)
}

#[test]
fn pressure_drop_of_a_uniform_bed_is_exact() {
    println!("beta     pressure drop   relative error  largest |u-U|/U");
    for drag in [1e-3, 1.0, 1e3, 1e6, 1e9, 1e12] {
        let mesh = Rectangle::new([0.0; 2], [4.0, 1.0], [40, 10])
            .mesh()
            .unwrap();
        let n = mesh.node_count();
        let (drop, deviation) = through(mesh, 0.1, &vec![0.4; n], &vec![drag; n]);
        let exact = drag * (0.1 / 0.4) * 4.0 / 0.4;
        let error = (drop / exact - 1.0).abs();
        println!("{drag:6.0e}  {drop:.10e}  {error:.1e}  {deviation:.1e}");
        assert!(error <= 1e-9);
    }
}

/// Below β ~ 1e2 the viscous loss at the two edges (0.8 Pa with this viscosity) is no longer small
/// beside the drag, and the drop has no closed form.
#[test]
fn pressure_drop_of_a_sharp_plug_is_within_two_per_cent_up_to_any_drag() {
    println!("beta     pressure drop  exact        error    largest |u-U|/U");
    for drag in [1e3, 1e6, 1e9, 1e12] {
        let mesh = Rectangle::new([0.0; 2], [3.0, 0.6], [60, 12])
            .mesh()
            .unwrap();
        let inside = at_nodes(&mesh, |x| (1.0 - 1e-9..=2.0 + 1e-9).contains(&x[0]));
        let choose = |solid: f64, clear: f64| -> Vec<f64> {
            inside
                .iter()
                .map(|&inside| if inside { solid } else { clear })
                .collect()
        };
        let (porosity, beta) = (choose(0.4, 1.0), choose(drag, 0.0));
        let (drop, deviation) = through(mesh, 1.0, &porosity, &beta);
        // ∫ βU/φ² with β and φ linear across the one cell of each edge:
        // ∫₀¹ (1−s)/(0.4+0.6s)² ds = (1.5 − ln 2.5)/0.36.
        let ramp = (1.5 - 2.5f64.ln()) / 0.36 / 20.0;
        let exact = drag * (1.0 / 0.16 + 2.0 * ramp);
        let error = drop / exact - 1.0;
        println!("{drag:6.0e}  {drop:.6e}  {exact:.6e}  {error:+.2e}  {deviation:.3}");
        assert!(error.abs() <= 0.02);
    }
}
