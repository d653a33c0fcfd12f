//! Closed forms, in the plane and in space: the drag in the free motion and in the contacts, rolling and
//! slipping, the overlap at rest.

use space::{Dim, Dimension, Vector};

use crate::bodies::Bodies;
use crate::contacts::Contacts;
use crate::model::{Model, Settings, crossing};
use crate::{plane, solid};

const TUNED: Settings = Settings {
    frequency: 400.0,
    damping_ratio: 1.0,
    iterations: 4,
    sub_step_max: 2e-3,
};

/// A vector of the plane of x and y.
fn at<const D: usize>(x: f64, y: f64) -> Vector<D> {
    space::vector::from_fn(|axis| [x, y, 0.0][axis])
}

/// I/(m r²).
fn inertia_factor<const D: usize>() -> f64 {
    if D == 2 { 0.5 } else { 0.4 }
}

fn model<const D: usize>(
    count: usize,
    radius: f64,
    gravity: [f64; 2],
    walls: &[[Vector<D>; D]],
) -> Model<D> {
    Model {
        settings: TUNED,
        gravity: at(gravity[0], gravity[1]),
        walls: walls.to_vec(),
        friction: [0.0; 2],
        radius: vec![radius; count],
        mass: vec![1.0; count],
        inertia: vec![inertia_factor::<D>() * radius * radius; count],
        fixed: vec![false; count],
    }
}

/// A floor at y = 0 below the plane of x and y: a segment, or two triangles.
trait Floor<const D: usize> {
    fn floor(from: f64, to: f64) -> Vec<[Vector<D>; D]>;
}

impl Floor<2> for Dim<2> {
    fn floor(from: f64, to: f64) -> Vec<[Vector<2>; 2]> {
        vec![[at(from, 0.0), at(to, 0.0)]]
    }
}

impl Floor<3> for Dim<3> {
    fn floor(from: f64, to: f64) -> Vec<[Vector<3>; 3]> {
        let [a, b, c, d] = [(from, -3.0), (to, -3.0), (to, 4.0), (from, 4.0)];
        let corner = |(x, z): (f64, f64)| Vector::from([x, 0.0, z]);
        vec![[a, b, c].map(corner), [a, c, d].map(corner)]
    }
}

/// Sub-steps under constant drag and forces.
fn steps<const D: usize, W: Bodies<D>>(
    world: &mut W,
    model: &Model<D>,
    dt: f64,
    steps: usize,
    drag: &[f64],
    force: &[Vector<D>],
) where
    Dim<D>: Dimension<D>,
{
    let mut pipeline = W::Pipeline::default();
    for _ in 0..steps {
        world
            .step(model, &mut pipeline, dt, Some(drag), Some(force))
            .expect("finite");
    }
}

fn contacts<const D: usize, W: Bodies<D>>(world: &W, model: &Model<D>) -> Contacts
where
    Dim<D>: Dimension<D>,
{
    Contacts::of(&world.pairs(model), &model.fixed)
}

fn free<const D: usize, W: Bodies<D>>()
where
    Dim<D>: Dimension<D>,
{
    const DT: f64 = 1e-3;
    let model = model::<D>(1, 0.5, [0.0, -9.81], &[]);
    for drag in [0.0, 1.0, 1e3, 1e8] {
        let mut world = W::new(&model, &[at(0.0, 0.0)], &[at(1.0, 0.0)]);
        steps(&mut world, &model, DT, 10, &[drag], &[at(2.0, 0.0)]);
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

#[test]
fn a_free_grain_takes_a_drag_of_any_size_implicitly() {
    free::<2, plane::World>();
    free::<3, solid::World>();
}

fn pressed<const D: usize, W: Bodies<D>>()
where
    Dim<D>: Dimension<D>,
{
    println!("drags            velocity         closed form");
    for [first, second] in [[1e2, 1.0], [1e4, 1e1], [1e6, 1e3]] {
        let model = model::<D>(2, 0.5, [0.0, 0.0], &[]);
        let mut world = W::new(&model, &[at(0.0, 0.0), at(-1.0, 0.0)], &[at(0.0, 0.0); 2]);
        // The light drag pushes from the left, the heavy one resists.
        let force = [at(-10.0, 0.0), at(30.0, 0.0)];
        steps(&mut world, &model, 1e-2, 400, &[first, second], &force);
        let (found, expected) = (world.velocity(0)[0], 20.0 / (first + second));
        println!("{first:.0e} {second:.0e}      {found:.9e}  {expected:.9e}");
        assert!((found - expected).abs() < 1e-6 * expected);
    }
}

/// Two grains pressed together move at Σf/Σγ: only when the drag is in the contacts' mass, too.
#[test]
fn pressed_grains_share_the_velocity_that_their_drags_allow() {
    pressed::<2, plane::World>();
    pressed::<3, solid::World>();
}

fn resting<const D: usize, W: Bodies<D>>()
where
    Dim<D>: Dimension<D> + Floor<D>,
{
    let floor = Dim::<D>::floor(-10.0, 10.0);
    for frequency in [100.0, 400.0, 1000.0] {
        let mut model = model(1, 0.5, [0.0, -9.81], &floor);
        model.settings.frequency = frequency;
        let mut world = W::new(&model, &[at(1.0, 0.5)], &[at(0.0, 0.0)]);
        steps(&mut world, &model, 2e-3, 1000, &[0.0], &[at(0.0, 0.0)]);
        let contacts = contacts(&world, &model);
        let overlap = 0.5 * contacts.penetration;
        let spring = 9.81 / (2.0 * std::f64::consts::PI * frequency).powi(2);
        println!("{frequency} Hz: overlap {overlap:.3e} m, g/(2πf)² {spring:.3e} m");
        assert_eq!(contacts.state, [2.0]);
        assert!(overlap > 0.1 * spring && overlap < 1.1 * spring);
        assert!(world.velocity(0)[1].abs() < 1e-6);
    }
}

#[test]
fn a_grain_at_rest_overlaps_the_floor_by_what_its_spring_says() {
    resting::<2, plane::World>();
    resting::<3, solid::World>();
}

fn slope<const D: usize, W: Bodies<D>>()
where
    Dim<D>: Dimension<D> + Floor<D>,
{
    let angle = 30f64.to_radians();
    let gravity = [9.81 * angle.sin(), -9.81 * angle.cos()];
    let floor = Dim::<D>::floor(-5.0, 20.0);
    for (friction, acceleration) in [
        (0.5, 9.81 * angle.sin() / (1.0 + inertia_factor::<D>())),
        (0.1, 9.81 * (angle.sin() - 0.1 * angle.cos())),
    ] {
        let mut model = model(1, 0.5, gravity, &floor);
        // The wall's coefficient counts there, whatever the grains' is.
        model.friction = [0.0, friction];
        let mut world = W::new(&model, &[at(0.0, 0.5)], &[at(0.0, 0.0)]);
        steps(&mut world, &model, 1e-3, 1000, &[0.0], &[at(0.0, 0.0)]);
        let found = world.velocity(0)[0];
        println!("μ = {friction}: {found:.6} m/s after 1 s, closed form {acceleration:.6}");
        assert!((found - acceleration).abs() < 1e-4 * acceleration);
    }
}

#[test]
fn a_grain_on_a_slope_rolls_or_slips_as_its_friction_says() {
    slope::<2, plane::World>();
    slope::<3, solid::World>();
}

fn holding<const D: usize, W: Bodies<D>>()
where
    Dim<D>: Dimension<D>,
{
    let mut model = model::<D>(3, 0.5, [0.0, -9.81], &[]);
    model.fixed[0] = true;
    let start = [at(0.0, 0.0), at(0.0, 1.0), at(5.0, 5.0)];
    let mut world = W::new(&model, &start, &[at(0.0, 0.0); 3]);
    let force = [at(0.0, 0.0); 3];
    steps(&mut world, &model, 1e-3, 100, &[0.0; 3], &force);
    let contacts = contacts(&world, &model);
    println!("{:?}, {} active", contacts.state, contacts.active);
    assert_eq!(world.position(0), at::<D>(0.0, 0.0));
    assert_eq!(contacts.state, [2.0, 2.0, 0.0]);
}

#[test]
fn fixed_grains_stay_and_hold_what_lies_on_them() {
    holding::<2, plane::World>();
    holding::<3, solid::World>();
}

fn crossed<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D> + Floor<D>,
{
    let model = model(1, 0.1, [0.0, 0.0], &Dim::<D>::floor(0.0, 1.0));
    for (before, after, crosses) in [
        ([0.5, 0.2], [0.5, -0.2], true),
        ([0.5, 0.0], [0.5, -0.2], true),
        ([0.5, 0.2], [0.5, 0.1], false),
        ([1.5, 0.2], [1.5, -0.2], false),
        ([0.5, -0.2], [0.5, 0.2], false),
    ] {
        let [p, q] = [before, after].map(|[x, y]| at(x, y));
        let found = crossing::<D, N>(&model, &[p], &[q]);
        assert_eq!(found.is_some(), crosses, "{before:?} {after:?}");
        assert!(found.is_none_or(|(grain, wall)| grain == 0 && wall < model.walls.len()));
    }
}

#[test]
fn a_grain_that_crosses_a_wall_is_noticed() {
    crossed::<2, 3>();
    crossed::<3, 4>();
}

/// Through the edge that two triangles share, and beside it.
#[test]
fn no_way_leads_between_two_triangles() {
    let model = model(1, 0.1, [0.0, 0.0], &Dim::<3>::floor(0.1, 1.3));
    for k in 0..=1000 {
        let share = f64::from(k) / 1000.0;
        let (x, z) = (0.1 + 1.2 * share, -3.0 + 7.0 * share);
        let [p, q] = [0.1 * share + 0.3, -0.7].map(|y| Vector::from([x, y, z]));
        assert!(crossing::<3, 4>(&model, &[p], &[q]).is_some(), "{p:?}");
    }
}

/// Two springs at once for a moment, and an edge ahead of the grain: what both do to the way.
#[test]
fn a_sphere_rolls_across_the_edge_of_two_triangles() {
    let angle = 30f64.to_radians();
    let gravity = [9.81 * angle.sin(), -9.81 * angle.cos()];
    let floor = Dim::<3>::floor(-5.0, 20.0);
    let mut model = model(1, 0.5, gravity, &floor);
    model.friction = [0.0, 0.5];
    // The edge lies across its way 1.07 m ahead.
    let start = Vector::from([0.0, 0.5, -1.3]);
    let mut world = solid::World::new(&model, &[start], &[Vector::zeros()]);
    let mut bounce: f64 = 0.0;
    for _ in 0..1000 {
        steps(&mut world, &model, 1e-3, 1, &[0.0], &[Vector::zeros()]);
        bounce = bounce.max(world.position(0)[1] - 0.5);
    }
    let (velocity, expected) = (world.velocity(0), 9.81 * angle.sin() / 1.4);
    println!("{velocity:?}, closed form {expected:.6}; highest {bounce:.1e} m above the floor");
    assert!(world.position(0)[0] > 1.6, "it is across");
    assert!((velocity[0] - expected).abs() < 1e-3 * expected);
    assert!(velocity[2].abs() < 1e-3 * expected && bounce < 1e-4);
}
