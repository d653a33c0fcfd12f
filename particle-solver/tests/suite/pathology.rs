//! Scenes that break contact solvers: finite, no energy gained, and never silently wrong.

use crate::bench_box::*;
use particle_solver::{ContactEngine, Error, Forces, Grains, Request, Setup, State};
use space::Vector;

const G: f64 = 9.81;

fn max_speed(engine: &Engine) -> f64 {
    engine
        .accepted()
        .velocity
        .iter()
        .map(|v| v[0].hypot(v[1]))
        .fold(0.0, f64::max)
}

#[test]
fn coincident_centres_part_along_a_fixed_direction_without_gaining_speed() {
    let run = || {
        let mut engine = engine(empty(), &[disk(0.5, 0.5, 0.1), disk(0.5, 0.5, 0.1)]);
        let mut distances = Vec::new();
        for number in 1..=200 {
            step(&mut engine, &request(number, 1e-2));
            let [a, b] = [engine.accepted().position[0], engine.accepted().position[1]];
            distances.push((a[0] - b[0]).hypot(a[1] - b[1]));
        }
        assert_eq!(max_speed(&engine), 0.0);
        (distances, engine.accepted().clone())
    };
    let (distances, end) = run();
    println!(
        "distance / 2r after 1, 20, 100, 200 steps: {:?}",
        [1, 20, 100, 200].map(|n| distances[n - 1] / 0.2)
    );
    assert!(distances.windows(2).all(|pair| pair[1] >= pair[0]));
    assert!((0.999..1.0).contains(&(distances[199] / 0.2)));
    assert_eq!(end, run().1);
}

#[test]
fn a_large_first_overlap_is_removed_without_energy() {
    let setup = Setup {
        walls: box_walls(4.0, 10.0),
        ..empty()
    };
    let disks = [
        disk(0.4, 1.0, 1.0),
        disk(1.2, 0.5, 1.0),
        disk(1.0, 1.4, 0.5),
    ];
    let mut engine = engine(setup, &disks);
    println!("step  largest overlap / r   kinetic energy");
    let mut overlap = 1.0;
    for number in 1..=400 {
        overlap = step(&mut engine, &request(number, 1e-2))
            .report
            .penetration_max;
        if number % 80 == 0 {
            println!(
                "{number:4}  {overlap:.3e}             {:.1e}",
                kinetic_energy(&engine)
            );
        }
        assert_eq!(kinetic_energy(&engine), 0.0);
    }
    assert!(overlap < 2e-4);
}

#[test]
fn a_corner_and_doubled_walls_hold_a_grain_like_simple_ones() {
    let rest = |extra: bool| {
        let mut walls = box_walls(3.0, 9.0);
        if extra {
            let copies = walls.clone();
            walls.extend(copies);
            walls.push(wall([-1.0, 0.0], [4.0, 0.0]));
        }
        let setup = Setup {
            gravity: [-3.0, -G].into(),
            walls,
            tolerance: 1e-10,
            ..empty()
        };
        let mut engine = engine(setup, &[disk(1.01, 1.02, 1.0).of_mass(2.0)]);
        let mut sum = [0.0; 2];
        for number in 1..=50 {
            sum = [0.0; 2];
            for active in step(&mut engine, &request(number, 1e-2)).active {
                sum[0] += active.force.normal * active.pair.normal[0];
                sum[1] += active.force.normal * active.pair.normal[1];
            }
        }
        (sum, engine.accepted().position[0])
    };
    println!("walls    wall forces             position");
    for extra in [false, true] {
        let (sum, position) = rest(extra);
        println!(
            "{}  {sum:?}  {position:?}",
            if extra { "doubled" } else { "simple " }
        );
        assert!((sum[0] - 6.0).abs() < 1e-7 && (sum[1] - 2.0 * G).abs() < 1e-7);
        assert!((position[0] - 1.0).abs() < 1e-9 && (position[1] - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_grain_falls_around_the_end_of_a_plate_and_off_its_back_side() {
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: vec![wall([-2.0, 0.0], [0.0, 0.0])],
        tolerance: 1e-10,
        ..empty()
    };
    // Over the end: its centre stays a radius away from the end point while it falls past it.
    let mut over = engine(setup.clone(), &[disk(0.05, 0.5, 0.5)]);
    let mut nearest = f64::INFINITY;
    for number in 1..=1500 {
        step(&mut over, &request(number, 1e-3));
        let [x, y] = xy(over.accepted().position[0]);
        if x > 0.0 {
            nearest = nearest.min(x.hypot(y) - 0.5);
        }
    }
    println!(
        "smallest gap to the end {nearest:.2e}, ends at {:?}",
        over.accepted().position[0]
    );
    assert!(nearest > -1e-9 && over.accepted().position[0][1] < -1.0);
    // Solid on its right only: a grain below the plate is not seen.
    let mut below = engine(setup, &[disk(-1.0, -0.6, 0.5).moving(0.0, 1.0)]);
    let free = step(&mut below, &request(1, 1e-2)).report.contacts;
    assert_eq!(free, 0);
}

#[test]
fn a_radius_ratio_of_a_hundred_settles_without_overlap() {
    let mut random = Random(3);
    let mut disks = vec![disk(5.0, 1.0, 1.0), disk(7.5, 1.0, 1.0)];
    for place in 0..400 {
        let x = 4.0 + 0.045 * (place % 100) as f64 + 0.004 * random.next();
        disks.push(disk(
            x,
            2.1 + 0.05 * (place / 100) as f64,
            0.01 + 0.01 * random.next(),
        ));
    }
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: box_walls(10.0, 20.0),
        friction: 0.3,
        wall_friction: 0.3,
        tolerance: 1e-3,
        ..empty()
    };
    let mut engine = engine(setup, &disks);
    let height = |engine: &Engine| -> f64 {
        let position = &engine.accepted().position;
        position
            .iter()
            .zip(&engine.grains().mass)
            .map(|(x, m)| G * m * x[1])
            .sum()
    };
    let (mut overlap, mut energy) = (0.0f64, height(&engine));
    for number in 1..=200 {
        let report = step(
            &mut engine,
            &Request {
                sub_steps: 0,
                ..request(number, 2e-3)
            },
        )
        .report;
        overlap = overlap.max(report.penetration_max);
        let now = height(&engine) + kinetic_energy(&engine);
        assert!(
            now <= energy + 1e-9 * energy.abs(),
            "step {number}: {now} above {energy}"
        );
        energy = now;
    }
    println!("largest overlap {overlap:.2e} of the smaller radius, energy never grew");
    assert!(overlap < 1e-2);
}

#[test]
fn a_heavy_grain_on_light_ones_is_right_or_an_error_with_numbers() {
    println!("mass ratio  sweeps_max  outcome");
    for (ratio, sweeps_max) in [(1e2, 20_000), (1e4, 20_000), (1e6, 200_000), (1e6, 50)] {
        let setup = Setup {
            gravity: [0.0, -G].into(),
            walls: box_walls(8.0, 9.0),
            tolerance: 1e-3,
            sweeps_max,
            ..empty()
        };
        let disks = [
            disk(3.0, 1.0, 1.0).of_mass(1.0),
            disk(5.0, 1.0, 1.0).of_mass(1.0),
            disk(4.0, 1.0 + 3f64.sqrt(), 1.0)
                .of_mass(ratio)
                .moving(0.0, -1.0),
            disk(1.0, 1.0, 1.0).of_mass(1.0),
            disk(7.0, 1.0, 1.0).of_mass(1.0),
        ];
        let mut engine = engine(setup, &disks);
        let before = kinetic_energy(&engine);
        let mut outcome = String::from("converged in all steps");
        for number in 1..=20 {
            match try_step(&mut engine, &request(number, 1e-3)) {
                Ok(candidate) => assert!(candidate.report.residual.rms <= 1e-3),
                Err(error) => {
                    assert!(matches!(error, Error::NotConverged { .. }), "{error}");
                    outcome = format!("step {number}: {error}");
                    break;
                }
            }
            engine.accepted().check_finite().unwrap();
            let fallen = G * 1e-3 * number as f64;
            assert!(kinetic_energy(&engine) <= before + ratio * fallen * (1.0 + fallen));
        }
        println!("{ratio:.0e}       {sweeps_max:6}      {outcome}");
        assert!(sweeps_max > 50 || outcome.contains("after 50 of 50 sweeps"));
    }
}

#[test]
fn grains_meet_across_a_periodic_boundary_also_when_the_period_is_short() {
    println!("period  v0 after       v1 after");
    for period in [40.0, 5.0, 4.2] {
        let setup = Setup {
            period: [Some(period), None],
            ..empty()
        };
        // Surfaces 0.1 apart across the seam, approaching; far apart inside.
        let disks = [
            disk(0.55, 0.0, 1.0).moving(-1.0, 0.0),
            disk(period - 1.55, 0.0, 1.0).moving(1.0, 0.0),
        ];
        let mut engine = engine(setup, &disks);
        for number in 1..=10 {
            step(&mut engine, &request(number, 0.02));
        }
        let velocity = &engine.accepted().velocity;
        let apart = engine.accepted().position[0][0] + period - engine.accepted().position[1][0];
        println!(
            "{period:5}   {:+.2e}      {:+.2e}      gap {:.1e}",
            velocity[0][0],
            velocity[1][0],
            apart - 2.0
        );
        assert!(velocity.iter().all(|v| v[0].abs() < 1e-9) && (apart - 2.0).abs() < 1e-9);
    }
}

#[test]
fn a_pair_squeezed_by_both_of_its_images_stops() {
    // Period 4 + 0.1: two disks of diameter 2 have 0.1 of free path in all.
    let setup = Setup {
        period: [Some(4.1), None],
        gravity: [0.0, 0.0].into(),
        ..empty()
    };
    let disks = [
        disk(1.0, 0.0, 1.0).moving(1.0, 0.0),
        disk(3.05, 0.0, 1.0).moving(-1.0, 0.0),
    ];
    let mut engine = engine(setup, &disks);
    for number in 1..=3 {
        step(&mut engine, &request(number, 0.1));
    }
    let apart = engine.accepted().position[1][0] - engine.accepted().position[0][0];
    println!("distance {apart}");
    assert!((apart - 2.0).abs() < 1e-9);
    // Pushed around a closed ring by one force, the chain moves as one.
    let force = [[1.0, 0.0], [0.0, 0.0]].map(Vector::from);
    let forces = Forces {
        drag: None,
        force: Some(&force),
    };
    engine.advance(&request(4, 0.1), &forces).unwrap();
    engine.commit().unwrap();
    let velocity = &engine.accepted().velocity;
    assert!((velocity[0][0] - velocity[1][0]).abs() < 1e-9 && velocity[0][0] > 0.0);
}

#[test]
fn a_fast_cloud_needs_no_more_sub_steps_than_one_at_rest() {
    let run = |speed: f64| {
        let mut disks = loose_disks(100, 10, 0.1, 9);
        let mut random = Random(4);
        for disk in &mut disks {
            disk.velocity = [speed + random.next() - 0.5, -speed + random.next() - 0.5];
        }
        let mut engine = engine(
            Setup {
                tolerance: 1e-6,
                ..empty()
            },
            &disks,
        );
        let request = Request {
            sub_steps: 0,
            ..request(1, 2.0)
        };
        let report = engine.advance(&request, &Forces::default()).unwrap().report;
        (report.sub_steps, report.candidates, report.contacts)
    };
    println!("speed  sub_steps, candidates, contacts");
    for speed in [0.0, 10.0, 1e4] {
        println!("{speed:5}  {:?}", run(speed));
        assert_eq!(run(speed), run(0.0));
        let (sub_steps, _, contacts) = run(speed);
        assert!(
            sub_steps > 1 && contacts > 0,
            "grains must meet for this to say anything"
        );
    }
}

#[test]
fn a_grain_that_passes_another_is_not_stopped_by_its_tangent_line() {
    println!("miss / R  sub_steps  velocity after");
    for miss in [1.02, 1.2, 2.0] {
        let disks = [
            disk(0.0, 0.0, 1.0),
            disk(-3.0, 2.0 * miss, 1.0).moving(10.0, 0.0),
        ];
        let mut engine = engine(empty(), &disks);
        let report = step(
            &mut engine,
            &Request {
                sub_steps: 0,
                ..request(1, 0.5)
            },
        )
        .report;
        let velocity = xy(engine.accepted().velocity[1]);
        println!("{miss:5}     {:3}        {velocity:?}", report.sub_steps);
        assert_eq!(velocity, [10.0, 0.0]);
        assert_eq!(report.contacts, 0);
    }
}

#[test]
fn a_dilute_cloud_costs_no_sweeps() {
    let mut disks = loose_disks(200, 20, 0.1, 2);
    for (number, disk) in disks.iter_mut().enumerate() {
        disk.position = [3.0 * disk.position[0], 3.0 * disk.position[1]];
        disk.velocity = [(number as f64).sin(), (number as f64).cos()];
    }
    let mut engine = engine(
        Setup {
            gravity: [0.0, -G].into(),
            ..empty()
        },
        &disks,
    );
    let candidate = step(
        &mut engine,
        &Request {
            sub_steps: 0,
            ..request(1, 0.1)
        },
    );
    println!("{:?}", candidate.report);
    assert_eq!((candidate.report.sweeps, candidate.report.contacts), (0, 0));
    assert!(candidate.contact.iter().all(|&contact| contact == 0));
}

#[test]
fn too_many_sub_steps_are_an_error_that_names_the_pair() {
    let setup = Setup {
        sub_steps_max: 10,
        ..empty()
    };
    let disks = [
        disk(0.0, 0.0, 1.0),
        disk(-30.0, 1.0, 1.0).moving(100.0, 0.0),
    ];
    let error = engine(setup, &disks)
        .advance(
            &Request {
                sub_steps: 0,
                ..request(1, 1.0)
            },
            &Forces::default(),
        )
        .unwrap_err()
        .to_string();
    println!("{error}");
    assert!(error.contains("grains 0 and 1") && error.contains("at most 10"));
}

/// Disks in a square, thrown through each other: they all meet in its middle after so long.
fn thrown_through_each_other(along: usize, meet: f64) -> Engine {
    let mut disks = loose_disks(along * along, along, 0.0, 1);
    let middle = 1.1 * along as f64;
    for disk in &mut disks {
        disk.velocity = disk.position.map(|place| (middle - place) / meet);
    }
    engine(empty(), &disks)
}

#[test]
fn a_search_is_given_up_where_all_fly_past_all() {
    // 142 796 550 pairs of 16 900 grains, in one sub-step and also in a part of a step.
    for sub_steps in [0, 1] {
        let mut engine = thrown_through_each_other(130, 1e-2);
        let request = Request {
            sub_steps,
            ..request(1, 1.0)
        };
        let error = try_step(&mut engine, &request).unwrap_err();
        println!("{error}, after {} searches", engine.searches()[0]);
        assert!(matches!(
            error,
            Error::TooFar {
                most: 33_800_000,
                grains: 16_900
            }
        ));
        // parts of the step: 1, 2, 4 … 64
        assert!(engine.searches()[0] <= 7);
    }
}

#[test]
fn a_sub_step_in_which_all_may_meet_all_is_refused_as_too_long() {
    // 404 550 pairs of 900 grains.
    let mut engine = thrown_through_each_other(30, 0.1);
    let error = try_step(&mut engine, &request(1, 1.0)).unwrap_err();
    println!("{error}");
    assert!(matches!(
        error,
        Error::Crowded {
            most: 28_800,
            grains: 900
        }
    ));
    let short = try_step(&mut engine, &request(1, 1e-4)).expect("a shorter one is solved");
    println!("{} candidates in a shorter one", short.report.candidates);
}

#[test]
fn unusable_input_is_refused_with_its_place() {
    let grains = Grains {
        radius: vec![1.0],
        mass: vec![1.0],
        fixed: vec![false],
    };
    let at =
        |x: f64, y: f64| State::new(&grains, vec![Vector::from([x, y])], vec![Vector::zeros()]);
    let floor = || Setup {
        walls: vec![wall([-5.0, 0.0], [5.0, 0.0])],
        ..empty()
    };
    let point = Setup {
        walls: vec![wall([1.0, 1.0], [1.0, 1.0])],
        ..empty()
    };
    let narrow = Setup {
        period: [Some(1.5), None],
        ..empty()
    };
    let weightless = Grains {
        mass: vec![0.0],
        ..grains.clone()
    };
    let errors = [
        at(f64::NAN, 0.0).unwrap_err(),
        ContactEngine::new(floor(), grains.clone(), at(0.0, -0.2).unwrap()).unwrap_err(),
        ContactEngine::new(point, grains.clone(), at(0.0, 0.0).unwrap()).unwrap_err(),
        ContactEngine::new(narrow, grains.clone(), at(0.0, 0.0).unwrap()).unwrap_err(),
        ContactEngine::new(empty(), weightless, at(0.0, 0.0).unwrap()).unwrap_err(),
        ContactEngine::new(
            Setup {
                friction: -0.1,
                ..empty()
            },
            grains.clone(),
            at(0.0, 0.0).unwrap(),
        )
        .unwrap_err(),
    ];
    let words = [
        "NaN",
        "behind wall 0",
        "wall 0",
        "period",
        "mass of grain 0",
        "friction is -0.1",
    ];
    for (error, word) in errors.iter().zip(words) {
        println!("{error}");
        assert!(error.to_string().contains(word));
    }
    let mut engine = ContactEngine::new(floor(), grains.clone(), at(0.0, 1.0).unwrap()).unwrap();
    assert!(engine.commit().is_err());
    let inf = [f64::INFINITY];
    let forces = Forces {
        drag: Some(&inf),
        force: None,
    };
    assert!(matches!(
        engine.advance(&request(1, 0.1), &forces),
        Err(Error::NotFinite { .. })
    ));
    assert!(
        engine
            .advance(&request(1, -1.0), &Forces::default())
            .is_err()
    );
}

#[test]
fn no_grains_and_only_fixed_grains_are_scenes_too() {
    let setup = Setup {
        gravity: [0.0, -G].into(),
        walls: box_walls(4.0, 4.0),
        ..empty()
    };
    let mut nobody = engine(setup.clone(), &[]);
    let choose = Request {
        sub_steps: 0,
        ..request(1, 1.0)
    };
    assert!(step(&mut nobody, &choose).contact.is_empty());
    let disks = [disk(1.0, 1.0, 1.0), disk(1.5, 1.0, 1.0).moving(3.0, 0.0)];
    let mut fixed = engine_with_fixed(setup, &disks, &[0, 1]);
    let before = fixed.accepted().position.clone();
    let candidate = step(
        &mut fixed,
        &Request {
            sub_steps: 0,
            ..request(1, 1.0)
        },
    );
    println!("{:?} {:?}", candidate.report, candidate.contact);
    assert_eq!(
        (candidate.contact, fixed.accepted().position.clone()),
        (vec![2, 2], before)
    );
}

#[test]
fn a_grain_rests_on_a_fixed_one_and_a_given_number_of_sub_steps_is_used() {
    let setup = Setup {
        gravity: [0.0, -G].into(),
        tolerance: 1e-10,
        ..empty()
    };
    let disks = [disk(0.0, 0.0, 1.0), disk(0.0, 2.0, 1.0).of_mass(3.0)];
    let mut engine = engine_with_fixed(setup, &disks, &[0]);
    let candidate = step(
        &mut engine,
        &Request {
            sub_steps: 7,
            ..request(1, 0.1)
        },
    );
    println!(
        "{:?}, force {:?}",
        candidate.report, candidate.active[0].force
    );
    assert_eq!(
        (candidate.report.sub_steps, candidate.contact),
        (7, vec![2, 2])
    );
    assert!((candidate.active[0].force.normal - 3.0 * G).abs() < 1e-7);
    assert_eq!(xy(candidate.mean_velocity[0]), [0.0, 0.0]);
}
