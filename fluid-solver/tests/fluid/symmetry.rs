//! How far from symmetric the matrix of creeping flow is, rows of continuity turned in sign.

use fluid_solver::boundary::condition::resolve_names;
use fluid_solver::boundary::{Condition, Constraints};
use fluid_solver::equations::assembly::Assembly;
use fluid_solver::equations::{Carrier, Coefficients, ViscousForm};
use fluid_solver::linear::System;
use fluid_solver::mesh::Mesh;
use fluid_solver::mesh::Rectangle;
use fluid_solver::solid::{Solid, SolidFields};
use fluid_solver::state::Flow;
use space::Vector;

use crate::support::Random;

/// ‖S − Sᵀ‖/‖S‖ (Frobenius) of the nodally scaled matrix: all of it, its u,u block, and u,p with p,u.
fn asymmetry(mesh: &Mesh<2, 3>, solid: &Solid<2>, rate: f64) -> [f64; 3] {
    let flow = Flow {
        superficial_velocity: vec![Vector::zeros(); mesh.node_count()],
        porosity: solid.matrix.porosity.clone(),
    };
    let carriers = [Carrier {
        flow: &flow,
        convects: 0.0,
        history: rate,
    }];
    let terms = Coefficients {
        density: 1.0,
        dynamic_viscosity: 1.0,
        gravity: Vector::zeros(),
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        rate,
        newton: false,
        body_force: None,
        time: 0.0,
        carriers: &carriers,
        solid,
    };
    let conditions = [("all".to_owned(), Condition::NoSlip)]
        .into_iter()
        .collect();
    let conditions = resolve_names(&conditions, &mesh.boundary_names).unwrap();
    let constraints = Constraints::new(mesh, conditions, 1.0, &Vector::zeros()).unwrap();
    let mut system = System::new(mesh.node_count(), &mesh.simplices);
    let flux = vec![0.0; mesh.node_count()];
    let assembly = Assembly {
        terms: &terms,
        mesh,
        constraints: &constraints,
        flux: &flux,
    };
    assembly.fill(&mut system, true);
    let count = system.pattern.unknowns();
    let mut dense = vec![0.0; count * count];
    system
        .pattern
        .for_each(&system.matrix, |row, column, value| {
            let sign = if row % 3 == 2 { -1.0 } else { 1.0 };
            dense[row * count + column] = sign * value;
        });
    let scale: Vec<f64> = (0..count)
        .map(|k| dense[k * count + k].abs().sqrt().recip())
        .collect();
    let (mut odd, mut size) = ([0.0; 3], [0.0; 3]);
    for row in 0..count {
        for column in 0..count {
            let at = |i: usize, j: usize| scale[i] * scale[j] * dense[i * count + j];
            let (here, there) = (at(row, column), at(column, row));
            let block = match (row % 3 == 2, column % 3 == 2) {
                (false, false) => Some(1),
                (true, true) => None,
                _ => Some(2),
            };
            for place in [Some(0), block].into_iter().flatten() {
                odd[place] += (here - there).powi(2);
                size[place] += here * here;
            }
        }
    }
    [0, 1, 2].map(|place| f64::sqrt(odd[place] / size[place]))
}

#[test]
fn the_matrix_of_creeping_flow_is_symmetric_in_steady_clear_fluid_alone() {
    let mesh = Rectangle::new([0.0; 2], [1.0; 2], [12, 12]).mesh().unwrap();
    let count = mesh.node_count();
    let mut random = Random(3);
    let mut field = |low: f64, high: f64| -> Vec<f64> {
        (0..count).map(|_| random.between(low, high)).collect()
    };
    let (porosity, drag) = (field(0.6, 1.0), field(0.0, 1e4));
    let entrained: Vec<f64> = porosity.iter().map(|p| 0.9 * (1.0 - p)).collect();
    let clear = SolidFields::default();
    let porous = SolidFields {
        porosity: Some(&porosity),
        ..clear
    };
    let stiff = SolidFields {
        drag: Some(&drag),
        entrained_fraction: Some(&entrained),
        ..porous
    };
    println!("case                         all       u,u       u,p");
    let mut table = Vec::new();
    for (name, fields, rate) in [
        ("clear, steady", clear, 0.0),
        ("clear, ρh²/(μΔt) = 0.7", clear, 1e2),
        ("clear, ρh²/(μΔt) = 70", clear, 1e4),
        ("porosity 0.6 to 1, steady", porous, 0.0),
        ("and drag, entrainment", stiff, 0.0),
    ] {
        let solid = Solid::new(&fields, &mesh).unwrap();
        let row = asymmetry(&mesh, &solid, rate);
        println!(
            "{name:<27}  {:.1e}   {:.1e}   {:.1e}",
            row[0], row[1], row[2]
        );
        table.push(row);
    }
    assert!(table[0][0] < 1e-14);
    assert!(table[1..].iter().all(|row| row[2] > 1e-2), "{table:?}");
}
