//! The cell grid against all distances, in the plane and in space.

use crate::grid::{Grid, TooFar};
use crate::periodic::{Image, Period, each_image, shifted, shortest_image};
use crate::vector::{Vector, dot, from_fn};

/// A small generator, so that the test needs nothing else.
fn random(seed: &mut u64) -> f64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

type Pairs = Vec<(usize, usize, Image)>;

fn brute_force<const D: usize>(position: &[Vector<D>], reach: &[f64], period: &Period<D>) -> Pairs {
    let mut pairs = Vec::new();
    for i in 0..position.len() {
        for j in i + 1..position.len() {
            let nearest = shortest_image(position[i] - position[j], period);
            each_image(period, |shift| {
                let apart = shifted(&nearest, shift, period);
                let sum = reach[i] + reach[j];
                if dot(&apart, &apart) <= sum * sum {
                    pairs.push((i, j, Image::of(shift)));
                }
            });
        }
    }
    pairs
}

/// Bodies in a box three times as long as it is wide, reaches from `least` to `ratio` times that.
fn check<const D: usize>(least: f64, ratio: f64, period: Period<D>) -> usize {
    let mut seed = 7;
    let count = 300;
    let position: Vec<Vector<D>> = (0..count)
        .map(|_| {
            from_fn(|axis| {
                let place = random(&mut seed);
                if axis == 0 { 3.0 * place - 1.0 } else { place }
            })
        })
        .collect();
    let reach: Vec<f64> = (0..count)
        .map(|_| least * ratio.powf(random(&mut seed)).min(10.0))
        .collect();
    let mut found = Pairs::new();
    Grid::build(&position, &reach, &period)
        .for_each_pair(|i, j, _, image| found.push((i, j, image)));
    found.sort_unstable();
    let expected = brute_force(&position, &reach, &period);
    println!("{ratio:5}  {period:?}  {}", expected.len());
    assert_eq!(found, expected, "ratio {ratio}, period {period:?}");
    expected.len()
}

#[test]
fn the_cells_find_exactly_the_pairs_that_all_distances_find() {
    println!("ratio  period              pairs");
    for (ratio, period) in [
        (1.0, [None, None]),
        (100.0, [None, None]),
        (1.0, [Some(1.0), None]),
        (30.0, [Some(0.3), Some(1.0)]),
        (2.0, [Some(0.05), Some(0.07)]),
        (5.0, [None, Some(0.11)]),
    ] {
        assert!(check::<2>(0.01, ratio, period) >= 10);
    }
}

#[test]
fn the_cells_of_space_find_exactly_the_pairs_that_all_distances_find() {
    println!("ratio  period                    pairs");
    for (ratio, period) in [
        (1.0, [None; 3]),
        (100.0, [None; 3]),
        (1.0, [Some(1.0), None, None]),
        (30.0, [Some(0.5), Some(1.0), Some(0.9)]),
        (2.0, [Some(0.2), Some(0.3), Some(0.25)]),
        (5.0, [None, Some(0.5), None]),
        (5.0, [None, None, Some(0.5)]),
    ] {
        assert!(check::<3>(0.04, ratio, period) >= 10);
    }
}

#[test]
fn the_work_told_is_about_that_of_the_pairs() {
    // A lattice with one body a cell: each looks at half of its 3^D − 1 neighbours.
    let lattice: Vec<Vector<3>> = (0..1000)
        .map(|k| Vector::from([k % 10, k / 10 % 10, k / 100].map(f64::from)))
        .collect();
    let grid = Grid::build(&lattice, &[0.499; 1000], &[None; 3]);
    let told = (0..100).find(|most| grid.works_within(f64::from(1000 * most)));
    println!("{told:?} distances a body");
    assert!(told.is_some_and(|told| (4..24).contains(&told)));
}

#[test]
fn a_search_with_a_limit_visits_no_more_pairs_and_says_so() {
    // All in one cell: 1 999 000 pairs.
    let (count, most) = (2000, 50_000);
    let (position, reach) = (vec![Vector::<2>::zeros(); count], vec![1.0; count]);
    let grid = Grid::build(&position, &reach, &[None; 2]);
    let mut visited = 0;
    let outcome = grid.for_each_pair_within(most, |_, _, _, _| visited += 1);
    println!("{visited} pairs visited, {outcome:?}");
    assert_eq!(outcome, Err(TooFar { most }));
    // a body is looked at to its end
    assert!(visited > 0 && visited <= most + count);
    assert!(!grid.works_within(most as f64));
    let mut all = 0;
    let outcome = grid.for_each_pair_within(count * count, |_, _, _, _| all += 1);
    assert_eq!((outcome, all), (Ok(()), count * (count - 1) / 2));
    assert!(grid.works_within(4.5 * (count * count) as f64));
}
