//! The iterative solver in space: its iterations do not depend on mesh, time step, inertia or drag, and what it finds
//! is what the direct solver finds.

use std::path::Path;

use fluid_solver::boundary::Condition;

use crate::space_bench::{Bench, Case, Grains, apart, cloud};

impl Bench {
    /// Solve a case, print a line of the table, and compare with the direct solver where that is asked for.
    fn line(&mut self, name: &str, case: &Case, most_apart: Option<f64>) -> usize {
        let found = self.solve(case);
        let krylov = found.solution.krylov.unwrap();
        let mut line = format!(
            "{name:<34} {:>3} its, omega {:.1e}; {:.3} + {:.3} s",
            krylov.iterations, found.solution.backward_error, found.setup, found.solve
        );
        assert_eq!(krylov.fallbacks, 0, "{line}");
        if let Some(most) = most_apart {
            let [u, p] = apart(&found.solution.unknowns, &self.directly());
            line += &format!("; u {u:.1e}, p {p:.1e} from the direct one");
            assert!(u < most && p < most, "{line}");
        }
        println!("{line}");
        krylov.iterations
    }

    fn head(&self) {
        println!("levels {:?}", self.levels);
    }
}

fn held(drag: f64, dt: f64) -> Case {
    Case {
        grains: Grains::Held(drag),
        ..cloud(0.4, dt)
    }
}

fn convecting(galileo: f64, dt: f64) -> Case {
    Case {
        convects: true,
        ..cloud(galileo, dt)
    }
}

#[test]
fn what_it_finds_is_what_the_direct_solver_finds() {
    let mut bench = Bench::graded(3.0, 0.4, 2.7);
    bench.head();
    bench.line("cloud", &cloud(0.4, 0.25), Some(1e-8));
    bench.line("cloud, Ga 100", &convecting(100.0, 1.0), Some(1e-8));
    bench.line("held", &held(9e4, 1.0), Some(1e-8));
}

#[test]
fn joined_open_and_oblique_sides_are_solved_alike() {
    println!("slip walls that follow no axis, one side open");
    let mut bench = Bench::turned();
    bench.head();
    let its = bench.line("cloud", &cloud(0.4, 0.25), Some(1e-8));
    assert!(its <= 16, "{its}");
    println!("two sides joined, an odd number of cells");
    let mut bench = Bench::uniform(13, [true, false, false], vec![Condition::Slip; 6]);
    bench.head();
    let its = bench.line("cloud", &cloud(0.4, 0.25), Some(1e-8));
    assert!(its <= 16, "{its}");
}

/// The lines of the table; returns the most iterations.
fn table(bench: &mut Bench, finest: f64) -> usize {
    bench.head();
    let mut most = 0;
    for exponent in [-4, -2, 0, 2, 5] {
        let dt = 10f64.powi(exponent);
        let name = format!("cloud, Ga .4, dt 1e{exponent}");
        most = most.max(bench.line(&name, &cloud(0.4, dt), None));
    }
    let steps = [
        (10.0, 0.25),
        (10.0, 10.0),
        (100.0, 0.25),
        (100.0, 10.0),
        (1000.0, 1.0),
        (1000.0, 100.0),
    ];
    for (galileo, dt) in steps {
        let name = format!("cloud, Ga {galileo}, dt {dt}");
        most = most.max(bench.line(&name, &convecting(galileo, dt), None));
    }
    for stiff in [0.0, 1e2, 1e4, 1e6, 1e8] {
        for dt in [1e-4, 1.0, 1e5] {
            let name = format!("held, beta h2/mu {stiff:.0e}, dt {dt:.0e}");
            most = most.max(bench.line(&name, &held(stiff * finest * finest, dt), None));
        }
    }
    most
}

#[test]
fn iterations_do_not_depend_on_step_inertia_or_drag() {
    let mut bench = Bench::graded(4.0, 0.4, 2.2);
    let most = table(&mut bench, 4.0);
    println!("at most {most}");
    assert!(most <= 13);
}

#[test]
#[ignore = "minutes; prints a table"]
fn table_of_large_meshes() {
    let none = [false; 3];
    let walls = || vec![Condition::NoSlip; 6];
    let meshes: [(&str, f64, usize, &dyn Fn() -> Bench); 5] = [
        ("graded, R/6, slope .28", 6.0, 13, &|| {
            Bench::graded(6.0, 0.28, 2.2)
        }),
        ("graded, R/12, slope .28", 12.0, 18, &|| {
            Bench::graded(12.0, 0.28, 2.2)
        }),
        ("uniform, 20 x 20 x 40", 4.0, 16, &|| {
            Bench::uniform(20, none, walls())
        }),
        ("uniform, 30 x 30 x 60", 6.0, 17, &|| {
            Bench::uniform(30, none, walls())
        }),
        ("uniform, 48 x 48 x 96", 9.6, 20, &|| {
            Bench::uniform(48, none, walls())
        }),
    ];
    let mut least: Option<(f64, f64)> = None;
    for (name, finest, bound, make) in meshes {
        println!("{name}");
        let mut bench = make();
        let most = table(&mut bench, finest);
        let found = bench.solve(&cloud(0.4, 0.25));
        let (nodes, seconds) = (bench.levels[0] as f64, found.setup + found.solve);
        let (n, s) = *least.get_or_insert((nodes, seconds));
        println!(
            "at most {most} iterations; {:.0} bytes a node; {seconds:.2} s, {:.2} of n^1.1 from the first mesh",
            bench.bytes(),
            seconds / s / (nodes / n).powf(1.1)
        );
        // Graded 13, but 18 at Ga 1000 and a step in which the flow crosses hundreds of cells; uniform more with every
        // mesh, of held beds most.
        assert!(most <= bound, "{most} of {bound}");
    }
}

/// What `studies/mumps` solves as well.
#[test]
#[ignore = "writes hundreds of megabytes"]
fn systems_for_other_solvers() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (name, finest) in [("13k", 6.0), ("52k", 12.0)] {
        let mut bench = Bench::graded(finest, 0.28, 2.2);
        for _ in 0..3 {
            let found = bench.solve(&cloud(0.4, 0.25));
            let file = folder.join(format!("system-{name}.bin"));
            bench.write(&found.solution, &file);
            println!(
                "{name}: {} nodes, {:.3} + {:.3} s, {}",
                bench.levels[0],
                found.setup,
                found.solve,
                file.display()
            );
        }
    }
}
