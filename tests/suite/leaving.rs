//! Grains that leave by open sides: what is left, what has left, and that the rest does not notice.

use coupler::simulation::Simulation;
use protocol::engine::InitialGrains;
use protocol::local::spawn_particles;
use protocol::message::Role;
use protocol::scene::{Boundary, CouplerScene};
use tests::grains::disks;
use tests::recorded::leaving;
use tests::{couple, engine, fluid, particles, scene, with_boundaries};

use crate::lesser::SilentGrains;

const GRAVITY: [f64; 2] = [0.0, -9.81];

/// Sums over the grains that are there: volume, mass, momentum, energy (½ m v² − m g·x).
fn present(simulation: &Simulation<2, 3>) -> [f64; 5] {
    let grains = &simulation.state.grains;
    let mut sums = [0.0; 5];
    for i in 0..grains.count() {
        let (mass, speed) = (grains.mass[i], grains.velocity[i]);
        sums[0] += grains.volume[i];
        sums[1] += mass;
        sums[2] += mass * speed[0];
        sums[3] += mass * speed[1];
        sums[4] += mass * (0.5 * speed.norm_squared() + 9.81 * grains.position[i][1]);
    }
    sums
}

/// The same of those that have left.
fn removed(simulation: &Simulation<2, 3>) -> [f64; 5] {
    let removed = &simulation.state.removed;
    let momentum = &removed.momentum;
    [
        removed.volume,
        removed.mass,
        momentum[0],
        momentum[1],
        removed.energy,
    ]
}

fn table(numbers: &[f64]) -> String {
    let numbers = numbers.iter().map(|number| format!("{number:.1e}  "));
    numbers.collect()
}

#[test]
fn a_pile_slides_out_and_all_is_counted() {
    let mut case = leaving();
    case.steps = 40;
    let first = case.grains.count();
    let mut simulation = couple(case.scene, &case.grains);
    let all = present(&simulation)[..2].to_vec();
    let (mut worst, mut passes) = ([0.0_f64; 4], 0);
    println!("step  grains  left   volume defect  third law  momentum  energy  passes");
    for step in 1..=case.steps {
        let before = removed(&simulation);
        let ids = simulation.state.grains.id.clone();
        let report = simulation
            .advance(5e-3)
            .unwrap_or_else(|error| panic!("step {step}: {error}"));
        let (state, budget) = (&simulation.state, &report.budget);
        let count = state.grains.count();
        let defects = [
            budget.volume_defect,
            budget.third_law_defect,
            budget.momentum_defect,
            budget.energy_defect,
        ];
        (0..4).for_each(|k| worst[k] = worst[k].max(defects[k]));
        passes = passes.max(report.passes);
        if step % 4 == 0 {
            let left = state.removed.grains;
            println!(
                "{step:4}  {count:6}  {left:4}   {}  {}",
                table(&defects),
                report.passes
            );
        }
        assert_eq!(count as u64 + state.removed.grains, first as u64);
        let still_there = state
            .grains
            .id
            .iter()
            .filter(|&id| ids.contains(id))
            .count();
        assert!(
            still_there == count && state.grains.id.is_sorted(),
            "ids stay"
        );
        assert!(
            state.grains.position.iter().all(|x| x[1] >= 0.0),
            "none is outside"
        );
        let now = removed(&simulation);
        let gone = (now[1] - before[1]) / all[1];
        assert!(gone >= 0.0 && now[3] <= before[3], "what leaves goes down");
        for k in 0..2 {
            let sum = present(&simulation)[k] + now[k];
            assert!(
                (sum - all[k]).abs() <= 1e-14 * all[k],
                "{sum} of {}",
                all[k]
            );
        }
    }
    println!("worst {}, at most {passes} passes", table(&worst));
    assert!(worst[0] < 1e-12 && worst[1] < 1e-10, "{worst:?}");
    assert!(worst[2] < 1e-3, "{worst:?}");
    assert_eq!(simulation.state.grains.count(), 0, "the last one has left");
    let porosity = &simulation.state.porosity;
    assert!(porosity.iter().all(|&phi| phi == 1.0), "fluid alone");
}

/// Disks that fall side by side in a tall box of thin air, bottom and top open.
fn rain(
    reaction: bool,
    centres: &[[f64; 2]],
    cells: [usize; 2],
    dt: f64,
) -> (CouplerScene, InitialGrains) {
    let air = fluid(1.2, 1.8e-5, GRAVITY, [0.0, 0.0], [0.1, 0.2], cells);
    let open = |pressure| Boundary::Open { pressure };
    let sides = ["left", "right"].map(|side| (side, Boundary::Periodic));
    let ends = [("bottom", open(1.2 * 9.81 * 0.2)), ("top", open(0.0))];
    let air = with_boundaries(air, &[sides, ends].concat());
    let mut engine = particles(GRAVITY);
    engine.period = vec![Some(0.1), None];
    let mut scene = scene(Some(air), Some(engine), dt, 1);
    scene.reaction = reaction;
    scene.grain_exits = vec!["bottom".to_owned(), "top".to_owned()];
    let radii: Vec<f64> = (1..=centres.len())
        .map(|k| 1e-3 + 1e-4 * k as f64)
        .collect();
    (scene, disks(centres, &radii, 2500.0))
}

#[test]
fn those_that_stay_do_not_notice_who_leaves() {
    // The second one leaves first; the fluid does not feel them, so the others must keep their bits.
    let centres = [[0.02, 0.15], [0.05, 0.01], [0.08, 0.12]];
    let (scene, grains) = rain(false, &centres, [5, 10], 2e-3);
    let (mut with, without) = (couple(scene.clone(), &grains), grains.without(&[1]));
    let mut without = couple(scene, &without);
    for step in 1..=60 {
        for simulation in [&mut with, &mut without] {
            simulation
                .advance(2e-3)
                .unwrap_or_else(|error| panic!("step {step}: {error}"));
        }
    }
    let (one, other) = (&with.state.grains, &without.state.grains);
    println!("{:?} {:?}", one.id, one.position);
    assert_eq!((&one.id[..], with.state.removed.grains), (&[0, 2][..], 1));
    assert_eq!(
        (&one.position, &one.velocity),
        (&other.position, &other.velocity)
    );
    assert_eq!(&with.system.immersion().expect("fluid").shapes.len(), &2);
}

#[test]
fn a_grain_that_leaves_by_many_cells_within_a_step_is_placed_on_its_way() {
    // 30 m/s through cells of 10 mm: three cells a step. Before, it ended the run as outside the mesh.
    for (reaction, axis_speed) in [
        (true, [0.0, -30.0]),
        (false, [3.0, 30.0]),
        (true, [40.0, -25.0]),
    ] {
        let (scene, mut grains) = rain(
            reaction,
            &[[0.03, 0.004], [0.06, 0.196], [0.05, 0.1]],
            [10, 20],
            1e-3,
        );
        (0..2).for_each(|grain| grains.velocity[2 * grain..][..2].copy_from_slice(&axis_speed));
        let mut simulation = couple(scene, &grains);
        let kinetic = present(&simulation)[4];
        let mut counts = Vec::new();
        let mut defect = 0.0_f64;
        for step in 1..=12 {
            let report = simulation
                .advance(1e-3)
                .unwrap_or_else(|error| panic!("step {step}: {error}"));
            defect = defect
                .max(report.budget.third_law_defect)
                .max(report.budget.volume_defect);
            counts.push(simulation.state.grains.count());
        }
        let energy = present(&simulation)[4] + removed(&simulation)[4];
        println!(
            "{axis_speed:?}: {counts:?}, energy {kinetic:e} J/m, then {energy:e}, defect {defect:.1e}"
        );
        assert_eq!(
            (counts[0], counts[11], simulation.state.grains.id[0]),
            (2, 1, 2)
        );
        assert!(
            energy <= kinetic * (1.0 + 1e-9) && energy > 0.9 * kinetic,
            "drag takes a little"
        );
        assert!(defect < 1e-10);
    }
}

/// The same scene with an engine that keeps all grains.
fn kept(scene: CouplerScene, grains: &InitialGrains) -> Result<Simulation<2, 3>, String> {
    let keeper = spawn_particles(SilentGrains::default).expect("a hello");
    let fluid = engine(Role::Fluid, None);
    Simulation::new(scene, Some(fluid), Some(keeper), grains).map_err(|error| {
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    })
}

#[test]
fn an_engine_that_keeps_all_is_refused_unless_none_may_leave() {
    let (mut scene, grains) = rain(true, &[[0.05, 0.004]], [5, 10], 2e-3);
    let why = kept(scene.clone(), &grains).err().expect("refused");
    println!("{why}");
    assert!(
        why.contains("silent-grains") && why.contains("bottom, top") && why.contains("\"open\"")
    );
    // A side that is only open: the grain ends the run.
    scene.grain_exits = Vec::new();
    let mut simulation = kept(scene, &grains).expect("taken");
    let error = (0..400).find_map(|_| simulation.advance(2e-3).err());
    let error = error.expect("it leaves the mesh");
    println!("{error}");
    assert_eq!(error.exit_code(), 7);
    assert!(error.to_string().contains("\"removed\""), "the remedy");
}
