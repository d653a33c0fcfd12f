//! A search for contacts that is kept, and one that is made each time, give the same bits.

use crate::bench_box::*;
use particle_solver::{Forces, Request, Setup};

const DT: f64 = 1e-2;

fn request(step: u64, pass: u32) -> Request {
    Request {
        step,
        pass,
        dt: DT,
        sub_steps: 0,
        tolerance: 0.0,
    }
}

/// Run both ways; searches kept and always, and the step in which the first contact was active.
fn compare(name: &str, build: impl Fn() -> Engine, steps: u64) -> ([u64; 2], Option<u64>) {
    let (mut kept, mut always) = (build(), build());
    always.search_always(true);
    let mut first_contact = None;
    for step in 1..=steps {
        for pass in 0..2 {
            let [a, b] = [&mut kept, &mut always].map(|engine| {
                engine
                    .advance(&request(step, pass), &Forces::default())
                    .unwrap()
                    .clone()
            });
            assert_eq!(a, b, "{name}, step {step}, pass {pass}");
            if a.report.contacts > 0 {
                first_contact.get_or_insert(step);
            }
        }
        kept.commit().unwrap();
        always.commit().unwrap();
    }
    let [few, all] = [&kept, &always].map(Engine::searches);
    println!(
        "{name:<28} {steps:>5} steps, searches {few:?} instead of {all:?}, first contact {first_contact:?}"
    );
    ([few[0], all[0]], first_contact)
}

fn falling(friction: f64, period: [Option<f64>; 2]) -> Setup<2> {
    Setup {
        gravity: [0.0, -9.81].into(),
        walls: box_walls(16.0, 80.0),
        period,
        friction,
        wall_friction: friction,
        tolerance: 1e-3,
        ..empty()
    }
}

#[test]
fn a_heap_that_forms_has_the_bits_of_one_that_searches_always() {
    for friction in [0.0, 0.3] {
        let heap = || engine(falling(friction, [None; 2]), &loose_disks(80, 6, 0.2, 5));
        let ([few, all], contact) = compare("heap", heap, 200);
        assert!(2 * few < all, "{few} and {all}");
        assert!(contact.is_some());
    }
}

#[test]
fn distant_grains_are_searched_once_until_two_of_them_meet() {
    let cloud = || {
        let mut disks = Vec::new();
        for k in 0..20 {
            disks.push(disk(10.0 * f64::from(k), 0.0, 0.5).moving(1.0, 0.3));
        }
        // Comes from the left through step 1 / (1.5 DT) = 67 steps of closing the first gap.
        disks.push(disk(-2.0, 0.0, 0.5).moving(2.5, 0.3));
        engine(empty(), &disks)
    };
    let ([few, all], contact) = compare("one catches up", cloud, 100);
    assert_eq!(contact, Some(67));
    assert!(few < 20 && all >= 400, "{few} and {all}");
}

#[test]
fn a_grain_far_from_all_walls_looks_at_none_until_it_falls_on_one() {
    let drop = || engine(falling(0.0, [None; 2]), &[disk(8.0, 5.5, 0.5)]);
    let (mut kept, mut looks) = (drop(), Vec::new());
    for step in 1..=110 {
        let before = kept.searches()[1];
        let candidate = kept.advance(&request(step, 0), &Forces::default()).unwrap();
        let contacts = candidate.report.contacts;
        kept.commit().unwrap();
        looks.push((kept.searches()[1] > before, contacts));
    }
    let first_look = looks.iter().position(|look| look.0);
    let first_contact = looks.iter().position(|look| look.1 > 0);
    println!("first look in step {first_look:?}, first contact in step {first_contact:?}");
    assert!(first_look > Some(20) && first_look <= first_contact);
    compare("one grain falls", drop, 110);
}
