//! Edges of slip walls in space: the fluid goes along them.

use std::sync::Arc;

use fluid_solver::boundary::Condition;
use fluid_solver::candidate::Request;
use fluid_solver::config::{FluidConfig, TimeScheme};
use fluid_solver::mesh::{Bisection, Mesh, Root, Sizes};
use fluid_solver::solid::SolidFields;
use fluid_solver::step::FluidSolver;
use space::{Vector, vector::from_fn};

use crate::support::{self, turn};

/// Cells of a channel along y.
fn channel(turned: bool) -> Mesh<3, 4> {
    let root = Root {
        lower: Vector::zeros(),
        upper: from_fn(|d| [1.0, 2.0, 1.0][d]),
        cells: [3, 6, 3],
        periodic: [false; 3],
    };
    let any = Sizes::new(vec![], 0.0, f64::INFINITY, root.period());
    let (_, straight) = Bisection::<_, 3, 4>::new(&root, &any, 1_000_000).unwrap();
    match turned {
        true => support::turned(&straight),
        false => straight,
    }
}

#[test]
fn a_plug_flows_along_the_edges_of_slip_walls() {
    println!("| channel | β [kg/(m³ s)] | inertia | largest |u − U|/U |");
    let cases = [(0.0, false), (1e6, false), (0.0, true)];
    for turned in [false, true] {
        for (drag, inertia) in cases {
            let mesh = channel(turned);
            let way = Vector::from([0.0, 1.0, 0.0]);
            let velocity = if turned { turn(&way) } else { way };
            let mut config = FluidConfig::new(1000.0, 1e-3)
                .with("all", Condition::Slip)
                .with(
                    "bottom",
                    Condition::Function(Arc::new(move |_, _| velocity)),
                )
                .with("top", Condition::Open(0.0));
            config.time_scheme = TimeScheme::Steady;
            config.convection = inertia;
            let nodes = mesh.node_count();
            let mut solver = FluidSolver::new(config, mesh).unwrap();
            let (porosity, drag_field) = (vec![0.6; nodes], vec![drag; nodes]);
            let fields = SolidFields {
                porosity: Some(&porosity),
                drag: Some(&drag_field),
                ..SolidFields::default()
            };
            solver.advance(&Request::first(1, 1.0), &fields).unwrap();
            solver.commit().unwrap();
            let found = &solver.state().now.superficial_velocity;
            let apart = found.iter().map(|u| (u - velocity).amax());
            let worst = apart.fold(0.0, f64::max);
            println!(
                "| {} | {drag:.0e} | {inertia} | {worst:.1e} |",
                if turned { "turned" } else { "along y" }
            );
            assert!(worst < 1e-9);
        }
    }
}

/// A corner of three slip walls holds the fluid, their edges only across themselves.
#[test]
fn corners_of_three_slip_walls_hold_and_edges_do_not() {
    let mesh = channel(false);
    let config = FluidConfig::new(1.0, 1.0).with("all", Condition::Slip);
    let walls = |x: &Vector<3>| {
        let upper = [1.0, 2.0, 1.0];
        (0..3).filter(|&d| x[d] == 0.0 || x[d] == upper[d]).count()
    };
    let expected: Vec<usize> = mesh.position.iter().map(walls).collect();
    let solver = FluidSolver::new(config, mesh).unwrap();
    let fixed = &solver.constraints().fixed;
    for (node, &walls) in expected.iter().enumerate() {
        let held = fixed[4 * node..4 * node + 3]
            .iter()
            .filter(|&&own| own)
            .count();
        assert_eq!(held, walls, "node {node}");
    }
}
