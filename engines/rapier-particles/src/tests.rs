//! Closed forms: the drag in the free motion and in the contacts, rolling and slipping, the overlap
//! at rest.

use rapier2d_f64::prelude::PhysicsPipeline;

use crate::contacts::{Contacts, crossing};
use crate::world::{Model, Segment, Settings, World};

const TUNED: Settings = Settings {
    frequency: 400.0,
    damping_ratio: 1.0,
    iterations: 4,
    sub_step_max: 2e-3,
};

fn model(count: usize, radius: f64, gravity: [f64; 2], walls: &[Segment]) -> Model {
    Model {
        settings: TUNED,
        gravity,
        walls: walls.to_vec(),
        friction: [0.0; 2],
        radius: vec![radius; count],
        mass: vec![1.0; count],
        inertia: vec![0.5 * radius * radius; count],
        fixed: vec![false; count],
    }
}

/// Sub-steps under constant drag and forces.
fn steps(world: &mut World, model: &Model, dt: f64, steps: usize, drag: &[f64], force: &[f64]) {
    let mut pipeline = PhysicsPipeline::new();
    for _ in 0..steps {
        world
            .step(model, &mut pipeline, dt, Some(drag), Some(force))
            .expect("finite");
    }
}

#[test]
fn a_free_grain_takes_a_drag_of_any_size_implicitly() {
    const DT: f64 = 1e-3;
    let model = model(1, 0.5, [0.0, -9.81], &[]);
    for drag in [0.0, 1.0, 1e3, 1e8] {
        let mut world = World::new(&model, &[0.0, 0.0], &[1.0, 0.0]);
        steps(&mut world, &model, DT, 10, &[drag], &[2.0, 0.0]);
        let mut expected = [1.0, 0.0];
        for _ in 0..10 {
            let push = [2.0, -9.81];
            expected = [0, 1].map(|k| (expected[k] + DT * push[k]) / (1.0 + drag * DT));
        }
        let found = world.velocity(0);
        println!("drag {drag:e}: {found:?}, {expected:?}");
        for k in 0..2 {
            assert!((found[k] - expected[k]).abs() <= 1e-12 * expected[k].abs());
        }
    }
}

/// Two grains pressed together move at Σf/Σγ: only when the drag is in the contacts' mass, too.
#[test]
fn pressed_grains_share_the_velocity_that_their_drags_allow() {
    println!("drags            velocity         closed form");
    for [first, second] in [[1e2, 1.0], [1e4, 1e1], [1e6, 1e3]] {
        let model = model(2, 0.5, [0.0, 0.0], &[]);
        let mut world = World::new(&model, &[0.0, 0.0, -1.0, 0.0], &[0.0; 4]);
        // The light drag pushes from the left, the heavy one resists.
        steps(
            &mut world,
            &model,
            1e-2,
            400,
            &[first, second],
            &[-10.0, 0.0, 30.0, 0.0],
        );
        let (found, expected) = (world.velocity(0)[0], 20.0 / (first + second));
        println!("{first:.0e} {second:.0e}      {found:.9e}  {expected:.9e}");
        assert!((found - expected).abs() < 1e-6 * expected);
    }
}

#[test]
fn a_grain_at_rest_overlaps_the_floor_by_what_its_spring_says() {
    let floor = [Segment {
        a: [-10.0, 0.0],
        b: [10.0, 0.0],
    }];
    for frequency in [100.0, 400.0, 1000.0] {
        let mut model = model(1, 0.5, [0.0, -9.81], &floor);
        model.settings.frequency = frequency;
        let mut world = World::new(&model, &[0.0, 0.5], &[0.0, 0.0]);
        steps(&mut world, &model, 2e-3, 1000, &[0.0], &[0.0, 0.0]);
        let contacts = Contacts::of(&world, &model);
        let overlap = 0.5 * contacts.penetration;
        let spring = 9.81 / (2.0 * std::f64::consts::PI * frequency).powi(2);
        println!("{frequency} Hz: overlap {overlap:.3e} m, g/(2πf)² {spring:.3e} m");
        assert_eq!(contacts.state, [2.0]);
        assert!(overlap > 0.1 * spring && overlap < 1.1 * spring);
        assert!(world.velocity(0)[1].abs() < 1e-6);
    }
}

#[test]
fn a_disk_on_a_slope_rolls_or_slips_as_its_friction_says() {
    let angle = 30f64.to_radians();
    let gravity = [9.81 * angle.sin(), -9.81 * angle.cos()];
    let floor = [Segment {
        a: [-5.0, 0.0],
        b: [20.0, 0.0],
    }];
    for (friction, acceleration) in [
        (0.5, 9.81 * angle.sin() * 2.0 / 3.0),
        (0.1, 9.81 * (angle.sin() - 0.1 * angle.cos())),
    ] {
        let mut model = model(1, 0.5, gravity, &floor);
        // The wall's coefficient counts there, whatever the grains' is.
        model.friction = [0.0, friction];
        let mut world = World::new(&model, &[0.0, 0.5], &[0.0, 0.0]);
        steps(&mut world, &model, 1e-3, 1000, &[0.0], &[0.0, 0.0]);
        let found = world.velocity(0)[0];
        println!("μ = {friction}: {found:.6} m/s after 1 s, closed form {acceleration:.6}");
        assert!((found - acceleration).abs() < 1e-4 * acceleration);
    }
}

#[test]
fn fixed_grains_stay_and_hold_what_lies_on_them() {
    let mut model = model(3, 0.5, [0.0, -9.81], &[]);
    model.fixed[0] = true;
    let start = [0.0, 0.0, 0.0, 1.0, 5.0, 5.0];
    let mut world = World::new(&model, &start, &[0.0; 6]);
    steps(&mut world, &model, 1e-3, 100, &[0.0; 3], &[0.0; 6]);
    let contacts = Contacts::of(&world, &model);
    println!("{:?}, {} active", contacts.state, contacts.active);
    assert_eq!(world.position(0), [0.0, 0.0]);
    assert_eq!(contacts.state, [2.0, 2.0, 0.0]);
}

#[test]
fn a_grain_that_crosses_a_wall_is_noticed() {
    let wall = [Segment {
        a: [0.0, 0.0],
        b: [1.0, 0.0],
    }];
    let model = model(1, 0.1, [0.0, 0.0], &wall);
    for (before, after, crosses) in [
        ([0.5, 0.2], [0.5, -0.2], Some((0, 0))),
        ([0.5, 0.2], [0.5, 0.1], None),
        ([1.5, 0.2], [1.5, -0.2], None),
        ([0.5, -0.2], [0.5, 0.2], None),
    ] {
        assert_eq!(
            crossing(&model, &before, &after),
            crosses,
            "{before:?} {after:?}"
        );
    }
}
