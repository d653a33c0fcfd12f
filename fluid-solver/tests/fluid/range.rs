//! Systems of any stiffness are solved to the last digits.

use std::path::Path;
use std::sync::Arc;

use fluid_solver::boundary::{Condition, Constraints};
use fluid_solver::cost::cpu_seconds;
use fluid_solver::equations::assembly::Assembly;
use fluid_solver::equations::{Carrier, Coefficients, ViscousForm};
use fluid_solver::linear::multifrontal::Multifrontal;
use fluid_solver::linear::pivoting::PivotingLu;
use fluid_solver::linear::plans::Plans;
use fluid_solver::linear::{LinearSolver, Solution, System, measure};
use fluid_solver::mesh::{Mesh, Rectangle};
use fluid_solver::solid::{Solid, SolidFields};
use fluid_solver::state::Flow;
use space::Vector;

use crate::support::{Random, write_system};

/// How stiff a system is, as multiples of what its scene has.
#[derive(Clone, Copy)]
struct Cell {
    dt: f64,
    viscosity: f64,
    speed: f64,
    drag: f64,
}

/// Grains on a mesh, water of this density and viscosity around them.
struct Scene {
    mesh: Mesh<2, 3>,
    solid_fraction: Vec<f64>,
    drag: f64,
    density: f64,
    viscosity: f64,
    speed: f64,
}

const DT: f64 = 5e-3;

impl Scene {
    /// A cloud of a fifth of grains at random in water that is a hundred times as viscous, as a run has them.
    fn cloud(cells: [usize; 2]) -> Scene {
        let mesh = Rectangle::new([-0.037, 0.0], [0.037, 0.222], cells)
            .mesh()
            .unwrap();
        let mut random = Random(5);
        let at = |x: &Vector<2>| {
            let inside = x[0].hypot(x[1] - 0.11) < 0.01;
            if inside {
                0.2 * random.between(0.5, 1.5)
            } else {
                0.0
            }
        };
        Scene {
            solid_fraction: mesh.position.iter().map(at).collect(),
            mesh,
            drag: 9e4,
            density: 1200.0,
            viscosity: 0.12,
            speed: 1e-3,
        }
    }

    /// A bed of three fifths of grains in the lower half.
    fn bed() -> Scene {
        let mesh = Rectangle::new([0.0; 2], [0.05, 0.1], [48, 96])
            .mesh()
            .unwrap();
        let mut random = Random(6);
        let at = |x: &Vector<2>| {
            if x[1] < 0.05 {
                0.6 * random.between(0.9, 1.06)
            } else {
                0.0
            }
        };
        Scene {
            solid_fraction: mesh.position.iter().map(at).collect(),
            mesh,
            drag: 2e6,
            density: 1000.0,
            viscosity: 1e-3,
            speed: 1e-2,
        }
    }

    /// The system of a cell.
    fn fill(&self, system: &mut System<3>, cell: Cell) {
        let porosity: Vec<f64> = self.solid_fraction.iter().map(|s| 1.0 - s).collect();
        let most = self
            .solid_fraction
            .iter()
            .fold(0.0_f64, |most, s| most.max(*s));
        let of_drag = |s: &f64| cell.drag * self.drag * s / most;
        let drag: Vec<f64> = self.solid_fraction.iter().map(of_drag).collect();
        let fields = SolidFields {
            porosity: Some(&porosity),
            drag: Some(&drag),
            entrained_fraction: Some(&self.solid_fraction),
            ..SolidFields::default()
        };
        let solid = Solid::new(&fields, &self.mesh).unwrap();
        let gravity = [0.0, -9.81].into();
        let conditions = vec![Condition::NoSlip; 4];
        let constraints = Constraints::new(&self.mesh, conditions, self.density, &gravity).unwrap();
        let speed = self.speed * cell.speed;
        let swirl = |x: &Vector<2>| -> Vector<2> {
            [speed * (100.0 * x[1]).sin(), speed * (100.0 * x[0]).cos()].into()
        };
        let flow = Flow {
            superficial_velocity: self.mesh.position.iter().map(swirl).collect(),
            porosity: solid.matrix.porosity.clone(),
        };
        let rate = 1.0 / (DT * cell.dt);
        let carriers = [Carrier {
            flow: &flow,
            convects: 1.0,
            history: rate,
        }];
        let terms = Coefficients {
            density: self.density,
            dynamic_viscosity: self.viscosity * cell.viscosity,
            gravity,
            viscous_form: ViscousForm::Symmetric,
            grad_div: 1.0,
            rate,
            newton: false,
            body_force: None,
            time: 0.0,
            carriers: &carriers,
            solid: &solid,
        };
        let assembly = Assembly {
            terms: &terms,
            mesh: &self.mesh,
            constraints: &constraints,
            flux: &vec![0.0; self.mesh.node_count()],
        };
        assembly.fill(system, true);
    }

    /// A solution of the system of a cell, from fluid at rest.
    fn solve(&self, system: &mut System<3>, linear: &mut LinearSolver<3>, cell: Cell) -> Solution {
        self.fill(system, cell);
        linear.factorise(system);
        linear
            .solve(system, &vec![0.0; system.right.len()], None)
            .unwrap()
    }

    /// Walls without slip, and the pressure of a node given.
    fn fixed(&self) -> Vec<bool> {
        let conditions = vec![Condition::NoSlip; 4];
        Constraints::new(&self.mesh, conditions, self.density, &Vector::zeros())
            .unwrap()
            .fixed
    }
}

#[test]
fn systems_of_any_stiffness_are_solved_to_the_last_digits() {
    let (mut cells, mut worst, mut double) = (0, 0.0_f64, 0);
    for (name, scene) in [("cloud", Scene::cloud([40, 120])), ("bed", Scene::bed())] {
        let nodes = scene.mesh.node_count();
        println!("{name}, {nodes} nodes: backward error / solves, d: in double precision");
        let mut system = System::new(nodes, &scene.mesh.simplices);
        let mut linear = LinearSolver::new(&system.pattern, scene.fixed()).unwrap();
        for viscosity in [1.0, 1e-2, 1e-4] {
            for speed in [1.0, 1e3] {
                for drag in [1.0, 1e3, 1e6] {
                    print!("  viscosity {viscosity:.0e} speed {speed:.0e} drag {drag:.0e}:");
                    for dt in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
                        let cell = Cell {
                            dt,
                            viscosity,
                            speed,
                            drag,
                        };
                        let found = scene.solve(&mut system, &mut linear, cell);
                        let mark = ["", "d", "p"][found.fallbacks];
                        print!(" {:.0e}/{}{mark}", found.backward_error, found.solves);
                        worst = worst.max(found.backward_error);
                        cells += 1;
                        double += usize::from(found.fallbacks > 0);
                        assert!(found.fallbacks < 2, "exchanges were needed");
                    }
                    println!();
                }
            }
        }
    }
    println!("{cells} cells, largest backward error {worst:.1e}, {double} in double precision");
    assert!(cells == 180 && worst < 1e-10);
}

/// Median of what some calls cost [ms], CPU time.
fn cost(mut call: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..7)
        .map(|_| {
            let begin = cpu_seconds();
            call();
            1e3 * (cpu_seconds() - begin)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[3]
}

/// Write systems of the cloud for `studies/direct`, and say what our own factors cost on one thread.
#[test]
#[ignore = "times, half a minute"]
fn plane_systems_for_other_solvers() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    let one = one.build().unwrap();
    for cells in [[40, 120], [56, 168], [80, 240], [115, 345]] {
        let scene = Scene::cloud(cells);
        let nodes = scene.mesh.node_count();
        let mut system = System::new(nodes, &scene.mesh.simplices);
        let fixed = scene.fixed();
        let mut linear = LinearSolver::new(&system.pattern, fixed.clone()).unwrap();
        let cell = Cell {
            dt: 1.0,
            viscosity: 1.0,
            speed: 1.0,
            drag: 1.0,
        };
        // as it was a step before
        let earlier = Cell { speed: 0.9, ..cell };
        let last = scene.solve(&mut system, &mut linear, earlier).unknowns;
        let found = scene.solve(&mut system, &mut linear, cell);
        let given = vec![0.0; system.right.len()];
        let file = folder.join(format!("direct-{nodes}.bin"));
        write_system(&system, &fixed, &given, &found.unknowns, &file);
        let [single, solve, double, substitution, faer, of_faer] = one.install(|| {
            let single = cost(|| linear.factorise(&system));
            let mut solves = 0;
            let solve = cost(|| {
                let found = linear.solve(&system, &given, Some(&last)).unwrap();
                solves = found.solves;
            });
            println!("{nodes} nodes: {solves} solves from the last solution");
            let scale = measure::nodal_scale(&system);
            let mut scaled = system.matrix.clone();
            measure::scale_matrix(&system, &scale, &fixed, &mut scaled);
            let plans = Plans::new(&system.pattern).unwrap();
            let mut double = Multifrontal::<f64, 3>::new(Arc::new(plans));
            let factor = cost(|| double.factorise(&scaled));
            let mut x = system.right.clone();
            let substitution = cost(|| double.solve(&mut x));
            let mut faer = PivotingLu::new(&system.pattern).unwrap();
            let columns = system.pattern.by_columns(&scaled);
            let of_faer = cost(|| faer.factorise(&columns).unwrap());
            let of_solve = cost(|| faer.solve(&mut x));
            [single, solve, factor, substitution, of_faer, of_solve]
        });
        println!(
            "own, single      {nodes:7} nodes: factor {single:7.1} ms, solve {solve:6.1} ms with refinement"
        );
        println!(
            "own, double      {nodes:7} nodes: factor {double:7.1} ms, solve {substitution:6.1} ms"
        );
        println!("faer, exchanges  {nodes:7} nodes: factor {faer:7.1} ms, solve {of_faer:6.1} ms");
    }
}
