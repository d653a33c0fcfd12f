//! (P1), (P2): who may touch.

use coupler::coupled::proximity::Proximity;
use coupler::state::{Contact, Grains};
use space::{Period, Vector, hypot};

use crate::mesh::noise;

fn open<const D: usize>(period: Period<D>) -> Proximity<D> {
    Proximity {
        walls: Vec::new(),
        period,
    }
}

fn grains<const D: usize>(position: Vec<Vector<D>>, velocity: Vec<Vector<D>>) -> Grains<D> {
    let count = position.len();
    Grains {
        position,
        velocity,
        radius: vec![0.1; count],
        mass: vec![1.0; count],
        ..Grains::default()
    }
}

fn plane(points: &[[f64; 2]]) -> Vec<Vector<2>> {
    points.iter().map(|&point| Vector::from(point)).collect()
}

fn may_touch<const D: usize>(within: &Proximity<D>, grains: &Grains<D>, dt: f64) -> Vec<bool> {
    let contacts = within.contacts(grains, dt);
    let touches = |state: &Contact| *state == Contact::Touches;
    contacts.iter().map(touches).collect()
}

#[test]
fn only_what_relative_motion_can_bring_together_may_touch() {
    let free = open([None, None]);
    let pair = plane(&[[0.0, 0.0], [0.3, 0.0]]);
    let at = |a: f64, b: f64| grains(pair.clone(), plane(&[[a, 0.0], [b, 0.0]]));
    assert_eq!(may_touch(&free, &at(0.0, 0.0), 0.1), [false; 2]);
    // as a block they keep their distance, at any speed
    assert_eq!(may_touch(&free, &at(9.0, 9.0), 0.1), [false; 2]);
    assert_eq!(may_touch(&free, &at(0.5, -0.5), 0.1), [true; 2]);
    assert_eq!(may_touch(&free, &at(0.5, -0.5), 0.05), [false; 2]);
}

#[test]
fn walls_and_periods_count() {
    let rest = |points: &[[f64; 2]]| grains(plane(points), vec![Vector::zeros(); points.len()]);
    let mut floor = open([None, None]);
    floor.walls = vec![[[-1.0, 0.0], [1.0, 0.0]].map(Vector::from)];
    let over = rest(&[[0.0, 0.103], [0.0, 0.5], [1.0 + 0.103, 0.0], [-1.2, 0.05]]);
    assert_eq!(may_touch(&floor, &over, 1e-3), [true, false, true, false]);
    let ring = open([Some(2.0), None]);
    let across = rest(&[[0.05, 5.0], [1.95, 5.0], [1.0, 5.0]]);
    assert_eq!(may_touch(&ring, &across, 1e-3), [true, true, false]);
    let unwrapped = rest(&[[0.05, 5.0], [-4.05, 5.0], [7.0, 5.0]]);
    assert_eq!(may_touch(&ring, &unwrapped, 1e-3), [true, true, false]);
}

#[test]
fn a_wall_in_space_is_a_triangle() {
    let mut floor = open([None; 3]);
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    floor.walls = vec![corners.map(Vector::from)];
    let places = [
        ([0.5, 0.5, 0.104], true),
        ([0.5, 0.5, 0.106], false),
        ([0.5, -0.104, 0.0], true),
        ([0.5, -0.104, 0.05], false),
        ([1.0 + 0.07, 1.0 + 0.07, 0.0], true),
        ([1.0 + 0.08, 1.0 + 0.08, 0.0], false),
        ([-0.07, -0.07, 0.0], true),
        ([-0.08, -0.08, 0.0], false),
    ];
    for (place, expected) in places {
        let one = grains(vec![Vector::from(place)], vec![Vector::zeros()]);
        assert_eq!(may_touch(&floor, &one, 1e-3), [expected], "{place:?}");
    }
}

fn finds_all<const D: usize>(count: usize, extent: f64) {
    let number = |k: usize| noise(k) - 0.5;
    let vector = |seed: usize| Vector::<D>::from_fn(|axis, _| number(seed + axis));
    let position: Vec<Vector<D>> = (0..count).map(|i| vector(D * i) * extent).collect();
    let velocity: Vec<Vector<D>> = (0..count).map(|i| vector(3 * D * i + 1)).collect();
    let mean = velocity.iter().sum::<Vector<D>>() / count as f64;
    let reach = |i: usize| 0.105 + 0.05 * hypot(&(velocity[i] - mean));
    let near = |i: usize, j: usize| hypot(&(position[i] - position[j])) <= reach(i) + reach(j);
    let expected: Vec<bool> = (0..count)
        .map(|i| (0..count).any(|j| j != i && near(i, j)))
        .collect();
    let touching = expected.iter().filter(|&&may| may).count();
    println!("{touching} of {count} may touch");
    assert!(touching > count / 10 && touching < count);
    let cloud = grains(position.clone(), velocity.clone());
    assert_eq!(may_touch(&open([None; D]), &cloud, 0.05), expected);
}

#[test]
fn the_grid_finds_what_all_pairs_find() {
    finds_all::<2>(200, 6.0);
    finds_all::<3>(200, 2.5);
}

#[test]
fn where_everybody_is_near_everybody_nobody_is_looked_for_one_by_one() {
    // All in one place, but for the last, who is alone.
    let crowd = |count: usize| {
        let mut places = vec![Vector::<2>::zeros(); count];
        places.push(Vector::from([1e3, 0.0]));
        let rest = grains(places, vec![Vector::zeros(); count + 1]);
        may_touch(&open([None; 2]), &rest, 1e-3)
    };
    assert_eq!(crowd(1000).last(), Some(&false));
    // 1.1e8 pairs: more than looking is worth.
    assert!(crowd(15_000).into_iter().all(|may| may));
}
