//! What a ball costs beside a disk: memory, search, sweeps.

use std::env::current_exe;
use std::fs::read_to_string;
use std::process::Command;

use crate::bench_balls::{G, floor};
use crate::bench_box::{Random, choose, cost, median, wall};
use particle_solver::contact::delassus::{Material, System};
use particle_solver::contact::impulses::Pair;
use particle_solver::contact::law::Friction;
use particle_solver::contact::loads::Loads;
use particle_solver::contact::pairs::{Margin, pairs};
use particle_solver::search::neighbours::Neighbours;
use particle_solver::small::near::{Found, find};
use particle_solver::small::stretch::Stretch;
use particle_solver::solve::schedule::Goal;
use particle_solver::solve::sweep::{RELAXATION, sweep};
use particle_solver::step::sub_step::Stage;
use particle_solver::walls::near::Walls;
use particle_solver::{ContactEngine, Facet, Forces, Grains, Setup, State};
use space::vector::from_fn;
use space::{Dim, Dimension, Vector};

const COUNT: usize = 8000;
const DT: f64 = 4e-3;
const PITCH: f64 = 1.22;

/// A bed of balls or disks of radius 0.5 (1 ± 0.2) on a floor, periodic along it, dropped from a lattice and settled.
fn settled<const D: usize>(across: usize, floor: Vec<Facet<D>>, steps: u64) -> ContactEngine<D>
where
    Dim<D>: Dimension<D>,
{
    let mut random = Random(12_345);
    let (mut grains, mut position) = (Grains::default(), Vec::new());
    for place in 0..COUNT {
        let radius = 0.5 * (0.8 + 0.4 * random.next());
        grains.radius.push(radius);
        grains.mass.push(radius.powi(D as i32));
        grains.fixed.push(false);
        position.push(from_fn(|axis| {
            let cell = place / across.pow(axis as u32);
            let cell = if axis + 1 < D { cell % across } else { cell };
            PITCH * (cell as f64 + 0.5) + 0.02 * random.next()
        }));
    }
    let setup = Setup {
        gravity: from_fn(|axis| if axis + 1 < D { 0.0 } else { -G }),
        walls: floor,
        period: std::array::from_fn(|axis| (axis + 1 < D).then_some(PITCH * across as f64)),
        friction: 0.3,
        wall_friction: 0.3,
        inertia_factor: if D == 2 { 0.5 } else { 0.4 },
        tolerance: 1e-2,
        solver: None,
        sweeps_max: 100_000,
        sub_steps_max: 100,
    };
    let state = State::new(&grains, position, vec![Vector::zeros(); COUNT]).expect("finite");
    let mut engine = ContactEngine::new(setup, grains, state).expect("valid");
    for step in 1..=steps {
        engine
            .advance(&choose(step, DT), &Forces::default())
            .expect("converges");
        engine.commit().expect("has a candidate");
    }
    engine
}

fn balls(steps: u64) -> ContactEngine<3> {
    settled(32, floor(120.0, 1), steps)
}

fn disks(steps: u64) -> ContactEngine<2> {
    settled(400, vec![wall([-600.0, 0.0], [1200.0, 0.0])], steps)
}

/// Settled grains, ready to be searched and swept again and again.
struct Bench<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    engine: ContactEngine<D>,
    walls: Walls<D>,
}

impl<const D: usize> Bench<D>
where
    Dim<D>: Dimension<D>,
{
    fn new(engine: ContactEngine<D>) -> Bench<D> {
        let setup = engine.setup();
        let walls = Walls::new(&setup.walls, &setup.period).expect("valid");
        Bench { engine, walls }
    }

    fn loads(&self) -> Loads<'_, D> {
        Loads {
            dt: DT,
            gravity: self.engine.setup().gravity,
            drag: None,
            force: None,
        }
    }

    /// Pairs of a step, searched anew or from the list that `neighbours` keeps.
    fn pairs(&self, neighbours: &mut Neighbours<D>) -> Vec<Pair<D>> {
        let grains = self.engine.grains();
        let free = self.loads().free_motion(grains, self.engine.accepted());
        let push: Vec<f64> = grains.radius.iter().map(|radius| 0.02 * radius).collect();
        let stage = self.stage();
        let place = stage.place(&self.engine.accepted().position);
        let margin = Margin {
            dt: DT,
            free_velocity: &free.velocity,
            push: &push,
        };
        pairs(neighbours, &place, &margin).expect("few enough")
    }

    /// Candidates of small steps.
    fn near(&self, neighbours: &mut Neighbours<D>) -> Found<D> {
        let (grains, state) = (self.engine.grains(), self.engine.accepted());
        let free = self.loads().free_motion(grains, state);
        let stage = self.stage();
        find(neighbours, &stage.place(&state.position), free.velocity, DT).expect("few enough")
    }

    fn stage(&self) -> Stage<'_, D> {
        let setup = self.engine.setup();
        Stage {
            grains: self.engine.grains(),
            walls: &self.walls,
            period: setup.period,
            material: setup.material(),
            goal: Goal {
                wished: setup.tolerance,
                required: setup.tolerance,
            },
            sweeps_max: setup.sweeps_max,
        }
    }

    fn stretch<'a>(&self, stage: &'a Stage<'_, D>, found: &'a Found<D>) -> Stretch<'a, D> {
        let loads = Loads {
            dt: DT / 20.0,
            ..self.loads()
        };
        Stretch::new(stage, self.engine.accepted(), &loads, found)
    }

    fn system(&self, friction: f64) -> System<D> {
        let grains = self.engine.grains();
        let friction = Friction {
            grains: friction,
            walls: friction,
        };
        let material = Material {
            friction,
            inertia_factor: self.engine.setup().inertia_factor,
        };
        let loads = self.loads();
        let free = loads.free_motion(grains, self.engine.accepted());
        let pairs = self.pairs(&mut Neighbours::default());
        System::assemble(
            grains,
            &material,
            &loads,
            &free,
            (&pairs, self.walls.grounds()),
        )
    }
}

/// A row of costs of a contact, disks and balls in turn.
fn row(name: &str, contacts: [usize; 2], mut disks: impl FnMut(), mut balls: impl FnMut()) -> f64 {
    let mut samples = [Vec::new(), Vec::new()];
    for _ in 0..101 {
        samples[0].push(cost(&mut disks) / contacts[0] as f64);
        samples[1].push(cost(&mut balls) / contacts[1] as f64);
    }
    let [disk, ball] = samples.each_mut().map(|samples| median(samples));
    println!(
        "| {name} | {disk:.1} ns | {ball:.1} ns | {:.2} |",
        ball / disk
    );
    ball / disk
}

/// `cargo test --release -p particle-solver --test suite a_contact_of_balls -- --ignored --nocapture`
#[test]
#[ignore = "a bench"]
fn a_contact_of_balls_beside_one_of_disks() {
    let (plane, space) = (Bench::new(disks(400)), Bench::new(balls(400)));
    let found = [
        plane.pairs(&mut Neighbours::default()).len(),
        space.pairs(&mut Neighbours::default()).len(),
    ];
    let each = found.map(|pairs| pairs as f64 / COUNT as f64);
    println!(
        "{COUNT} disks with {:.2} pairs each, {COUNT} balls with {:.2}",
        each[0], each[1]
    );
    println!("| of a pair, medians of 101 | disks | balls | ratio |");
    let mut kept = (Neighbours::default(), Neighbours::default());
    row(
        "found in the list",
        found,
        || drop(plane.pairs(&mut kept.0)),
        || drop(space.pairs(&mut kept.1)),
    );
    row(
        "searched anew",
        found,
        || drop(plane.pairs(&mut Neighbours::default())),
        || drop(space.pairs(&mut Neighbours::default())),
    );
    for friction in [0.0, 0.3] {
        let (mut one, mut two) = (plane.system(friction), space.system(friction));
        let name = format!("sweep, friction {friction}");
        row(
            &name,
            found,
            || _ = sweep(&mut one, RELAXATION),
            || _ = sweep(&mut two, RELAXATION),
        );
    }
}

/// What small steps cost: of a candidate and sub-step, the grains' part in it, and of a candidate found.
#[test]
#[ignore = "a bench"]
fn a_small_step_of_balls_beside_one_of_disks() {
    let (plane, space) = (Bench::new(disks(400)), Bench::new(balls(400)));
    let found = [
        plane.near(&mut Neighbours::default()).near.len(),
        space.near(&mut Neighbours::default()).near.len(),
    ];
    println!("{COUNT} disks and balls with {found:?} candidates");
    println!("| of a candidate, medians of 101 | disks | balls | ratio |");
    let mut kept = (Neighbours::default(), Neighbours::default());
    row(
        "found in the list",
        found,
        || drop(plane.near(&mut kept.0)),
        || drop(space.near(&mut kept.1)),
    );
    let near = (
        plane.near(&mut Neighbours::default()),
        space.near(&mut Neighbours::default()),
    );
    let (one, two) = (plane.stage(), space.stage());
    let (mut one, mut two) = (plane.stretch(&one, &near.0), space.stretch(&two, &near.1));
    row("a sub-step", found, || _ = one.run(1), || _ = two.run(1));
}

/// A number of kilobytes of /proc/self/status in bytes.
fn status(name: &str) -> f64 {
    let text = read_to_string("/proc/self/status").expect("Linux");
    let line = text.lines().find(|line| line.starts_with(name));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1));
    1024.0 * kilobytes.expect("known").parse::<f64>().expect("a number")
}

/// What this process takes for grains after so many steps, and took at most.
fn memory<const D: usize>(name: &str, settled: impl FnOnce() -> ContactEngine<D>)
where
    Dim<D>: Dimension<D>,
{
    let before = status("VmRSS");
    let engine = settled();
    let [now, most] = ["VmRSS", "VmHWM"].map(|name| (status(name) - before) / COUNT as f64);
    let acting = engine.accepted().impulses.entries.len() as f64 / COUNT as f64;
    let pairs = Bench::new(engine).pairs(&mut Neighbours::default()).len();
    let pairs = pairs as f64 / COUNT as f64;
    println!("| {name} | {pairs:.2} | {acting:.2} | {now:.0} B | {most:.0} B |");
}

/// Names the grains that a process of its own measures.
const CASE: &str = "GRAINS_TO_MEASURE";

/// `cargo test --release -p particle-solver --test suite memory_of_a_ball -- --ignored --nocapture`
#[test]
#[ignore = "a bench"]
fn memory_of_a_ball() {
    match std::env::var(CASE).as_deref() {
        Ok("balls apart") => memory("balls apart", || balls(1)),
        Ok("balls in a heap") => memory("balls in a heap", || balls(400)),
        Ok("disks in a heap") => memory("disks in a heap", || disks(400)),
        _ => {
            println!("| grains | pairs each | contacts each | memory of one | at its largest |");
            for case in ["balls apart", "balls in a heap", "disks in a heap"] {
                let mut test = Command::new(current_exe().expect("this test"));
                let name = "unit_costs::memory_of_a_ball";
                test.args(["--exact", name, "--ignored", "--nocapture"]);
                let out = test.env(CASE, case).output().expect("it starts");
                let text = String::from_utf8_lossy(&out.stdout);
                let row = text.lines().find(|line| line.starts_with('|'));
                println!("{}", row.expect("a row"));
            }
        }
    }
}
