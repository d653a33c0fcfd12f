//! Many grains: they settle, and columns collapse as far as columns do.

use crate::bench_box::*;
use particle_solver::{ContactEngine, Forces, Setup};

#[test]
fn a_random_packing_settles_without_overlap() {
    println!("friction  time  kinetic energy  overlap   contacts  sweeps a step");
    for friction in [0.0, 0.3] {
        let setup = Setup {
            gravity: [0.0, -9.81].into(),
            walls: box_walls(26.0, 200.0),
            friction,
            wall_friction: friction,
            tolerance: 1e-3,
            ..empty()
        };
        let mut engine = engine(setup, &loose_disks(150, 10, 0.2, 21));
        let (mut energies, mut overlap, mut sweeps) = (Vec::new(), 0.0f64, 0);
        for number in 1..=1200 {
            let report = step(&mut engine, &choose(number, 5e-3)).report;
            overlap = overlap.max(report.penetration_max);
            sweeps += report.sweeps;
            if number % 200 == 0 {
                energies.push(kinetic_energy(&engine));
                println!(
                    "{friction:8}  {:.1}   {:.2e}        {overlap:.1e}   {:4}      {:.1}",
                    number as f64 * 5e-3,
                    energies[energies.len() - 1],
                    report.contacts,
                    sweeps as f64 / 200.0
                );
                sweeps = 0;
            }
        }
        assert!(overlap < 5e-4);
        assert!(energies[5] < 1e-2 * energies[0]);
        let held = engine
            .advance(&choose(9999, 5e-3), &Forces::default())
            .unwrap();
        let hanging = held.contact.iter().filter(|&&contact| contact == 2).count();
        println!("{hanging} of 150 held by the walls");
        assert!(hanging > 120);
    }
}

/// A settled column `width` wide between two walls, then without the right one.
fn column(width: f64, count: usize) -> (Engine, f64, f64) {
    let walls = box_walls(width, 400.0);
    let mut floor = walls.clone();
    floor[1] = wall([0.0, 0.0], [400.0, 0.0]);
    let columns = (width / 2.6) as usize;
    let setup = Setup {
        gravity: [0.0, -9.81].into(),
        walls,
        friction: 0.5,
        wall_friction: 0.5,
        tolerance: 1e-2,
        ..empty()
    };
    let mut engine = engine(setup.clone(), &loose_disks(count, columns, 0.2, 77));
    for number in 1..=1500 {
        step(&mut engine, &choose(number, 5e-3));
    }
    let top = engine
        .accepted()
        .position
        .iter()
        .map(|x| x[1] + 1.0)
        .fold(0.0, f64::max);
    let open = Setup {
        walls: vec![floor[0], floor[1]],
        ..setup
    };
    let mut opened =
        ContactEngine::new(open, engine.grains().clone(), engine.accepted().clone()).unwrap();
    let mut state = opened.accepted().clone();
    state.impulses = Default::default();
    opened.set_accepted(state).unwrap();
    (opened, width, top)
}

#[test]
fn a_dry_column_runs_out_as_far_as_columns_do() {
    println!("aspect  run-out / width   2.5 a or 3.25 a^0.7 (Staron and Hinch 2005)   height left");
    for (width, count) in [(20.0, 120), (16.0, 240)] {
        let (mut engine, width, top) = column(width, count);
        let mut sub_steps = 0;
        for number in 1..=2000 {
            sub_steps += step(&mut engine, &choose(number, 5e-3)).report.sub_steps;
        }
        // The pile ends where grains no longer touch the pile: 98th percentile.
        let mut x: Vec<f64> = engine
            .accepted()
            .position
            .iter()
            .map(|x| x[0] + 1.0)
            .collect();
        x.sort_by(f64::total_cmp);
        let end = x[(x.len() * 98) / 100];
        let height = engine
            .accepted()
            .position
            .iter()
            .map(|x| x[1] + 1.0)
            .fold(0.0, f64::max);
        let aspect = top / width;
        let run_out = (end - width) / width;
        let known = if aspect < 2.0 {
            2.5 * aspect
        } else {
            3.25 * aspect.powf(0.7)
        };
        println!(
            "{aspect:.2}    {run_out:.2}              {known:.2}           {:.2} of {aspect:.2}, {:.1} sub-steps a step",
            height / width,
            sub_steps as f64 / 2000.0
        );
        assert!((0.4..1.6).contains(&(run_out / known)));
    }
}

#[test]
fn two_thousand_disks_collapse_the_same_after_a_checkpoint() {
    let setup = Setup {
        gravity: [0.0, -9.81].into(),
        walls: box_walls(100.0, 400.0),
        friction: 0.3,
        wall_friction: 0.3,
        tolerance: 1e-2,
        ..empty()
    };
    let mut engine = engine(setup, &loose_disks(2000, 38, 0.2, 1));
    for number in 1..=200 {
        step(&mut engine, &choose(number, 5e-3));
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    engine.save(&file).unwrap();
    let mut other = engine.clone();
    other.restore(&file).unwrap();
    for number in 201..=400 {
        step(&mut engine, &choose(number, 5e-3));
        step(&mut other, &choose(number, 5e-3));
    }
    println!("kinetic energy {:.6e}", kinetic_energy(&engine));
    assert_eq!(engine.accepted(), other.accepted());
}
