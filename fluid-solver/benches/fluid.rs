//! Assembly, factor and solve at 80 × 240 cells, the mesh of `scenes/cloud-uniform.toml`.

#![allow(missing_docs, reason = "criterion's macro makes a public function")]

use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fluid_solver::boundary::{Condition, Constraints};
use fluid_solver::equations::assembly::Assembly;
use fluid_solver::equations::{Carrier, Coefficients, ViscousForm};
use fluid_solver::linear::LinearSolver;
use fluid_solver::linear::System;
use fluid_solver::mesh::{Bisection, Mesh, Place, Rectangle, Root, Sizes, Zone};
use fluid_solver::solid::{Solid, SolidFields};
use fluid_solver::state::Flow;
use space::{Dim, Dimension, Vector};

fn mesh() -> Mesh<2, 3> {
    Rectangle::new([-0.037, 0.0], [0.037, 0.222], [80, 240])
        .mesh()
        .expect("a valid rectangle")
}

/// A cloud of drag and reduced porosity in the middle.
fn solid(mesh: &Mesh<2, 3>) -> Solid<2> {
    let inside = |x: Vector<2>| x[0].hypot(x[1] - 0.11) < 0.01;
    let choose = |solid: f64, clear: f64| -> Vec<f64> {
        mesh.position
            .iter()
            .map(|x| if inside(*x) { solid } else { clear })
            .collect()
    };
    let (porosity, drag, entrained) = (choose(0.8, 1.0), choose(1e8, 0.0), choose(0.19, 0.0));
    let fields = SolidFields {
        porosity: Some(&porosity),
        drag: Some(&drag),
        entrained_fraction: Some(&entrained),
        ..SolidFields::default()
    };
    Solid::new(&fields, mesh).expect("valid fields")
}

/// Cells of R/12 near a ball of radius 1.5 R, the domain 20 R wide: nodes a second.
fn bisect<const D: usize, const N: usize>(c: &mut Criterion, cells: [usize; D], growth: f64)
where
    Dim<D>: Dimension<D>,
{
    let root = Root {
        lower: Vector::<D>::zeros(),
        upper: space::vector::from_fn(|d| cells[d] as f64 * 4.0 / 3.0),
        cells,
        periodic: [false; D],
    };
    let place = Place::Ball {
        centre: (root.lower + root.upper) * 0.5,
        radius: 1.5,
    };
    let size = 1.0 / 12.0;
    let sizes = Sizes::new(vec![Zone { place, size }], growth, 2.2, root.period());
    let make = || Bisection::<_, D, N>::new(&root, &sizes, 4_000_000).expect("a mesh");
    let mut group = c.benchmark_group(format!("bisection {D}D"));
    group.throughput(Throughput::Elements(make().1.node_count() as u64));
    group
        .sample_size(10)
        .bench_function("mesh", |b| b.iter(make));
    group.finish();
}

fn bisection(c: &mut Criterion) {
    bisect::<2, 3>(c, [15, 45], 0.2);
    bisect::<3, 4>(c, [12, 12, 24], 0.28);
}

fn bench(c: &mut Criterion) {
    let mesh = mesh();
    let solid = solid(&mesh);
    let conditions = vec![Condition::NoSlip; 4];
    let constraints = Constraints::new(&mesh, conditions, 1200.0, &[0.0, -9.81].into())
        .expect("valid conditions");
    let swirl = |x: &Vector<2>| -> Vector<2> {
        [1e-3 * (100.0 * x[1]).sin(), 1e-3 * (100.0 * x[0]).cos()].into()
    };
    let flow = Flow {
        superficial_velocity: mesh.position.iter().map(swirl).collect(),
        porosity: solid.matrix.porosity.clone(),
    };
    let carriers = [Carrier {
        flow: &flow,
        convects: 1.0,
        history: 200.0,
    }];
    let terms = Coefficients {
        density: 1200.0,
        dynamic_viscosity: 0.12,
        gravity: [0.0, -9.81].into(),
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        rate: 200.0,
        newton: false,
        body_force: None,
        time: 0.0,
        carriers: &carriers,
        solid: &solid,
    };
    let mut system = System::new(mesh.node_count(), &mesh.simplices);
    let flux = vec![0.0; mesh.node_count()];
    let assembly = Assembly {
        terms: &terms,
        mesh: &mesh,
        constraints: &constraints,
        flux: &flux,
    };
    let given = vec![0.0; system.pattern.unknowns()];
    let mut linear =
        LinearSolver::new(&system.pattern, constraints.fixed.clone()).expect("an order");

    // One thread, so that numbers compare.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    let one = one.build().expect("a thread");
    assembly.fill(&mut system, true);
    let mut group = c.benchmark_group("80x240");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(5));
    group.bench_function("assembly", |b| {
        one.install(|| b.iter(|| assembly.fill(&mut system, true)));
    });
    group.bench_function("right side only", |b| {
        one.install(|| b.iter(|| assembly.fill(&mut system, false)));
    });
    group.bench_function("factor", |b| {
        one.install(|| b.iter(|| linear.factorise(&system)))
    });
    linear.factorise(&system);
    group.bench_function("solve with refinement", |b| {
        one.install(|| b.iter(|| linear.solve(&system, &given, None).expect("a solution")));
    });
    group.finish();
}

criterion_group!(benches, bisection, bench);
criterion_main!(benches);
