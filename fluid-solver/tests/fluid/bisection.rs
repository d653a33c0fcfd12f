//! Meshes that are bisected from the root, in the plane and in space: whatever the size function, they are
//! conforming, fill the box, keep the shape of their simplices, and are found again by their points.

use std::collections::BTreeMap;

use fluid_solver::mesh::{Bisection, Mesh, Place, Root, Sizes, Spot, Zone};
use space::{Dim, Dimension, Vector, simplex, vector};

use crate::support::Random;

const SIMPLICES_MAX: usize = 2_000_000;

/// A root of 1 to 4 cells along each axis, some axes joined; random places where cells are up to `finest` times
/// smaller than those of the root.
fn random<const D: usize>(random: &mut Random, finest: f64) -> (Root<D>, Vec<Zone<D>>, f64) {
    let cells: [usize; D] = std::array::from_fn(|_| 1 + (4.0 * random.unit()) as usize);
    let root = Root {
        lower: vector::from_fn(|_| random.between(-1.0, 1.0)),
        upper: vector::from_fn(|d| 1.0 + 0.5 * cells[d] as f64),
        cells,
        periodic: std::array::from_fn(|_| random.unit() < 0.3),
    };
    let zones = (0..1 + (5.0 * random.unit()) as usize).map(|_| {
        let inside = |random: &mut Random| -> Vector<D> {
            vector::from_fn(|d| random.between(root.lower[d], root.upper[d]))
        };
        let at = inside(random);
        let place = match random.unit() < 0.5 {
            true => Place::Ball {
                centre: at,
                radius: 0.1 * random.unit(),
            },
            false => Place::Box {
                lower: at,
                upper: at.add_scalar(0.1 * random.unit()),
            },
        };
        let size = root.size() * finest.powf(random.unit());
        Zone { place, size }
    });
    let zones: Vec<Zone<D>> = zones.collect();
    (root.clone(), zones, random.between(0.15, 0.8))
}

/// How near to regular: 1; after Liu and Joe (1994), mean ratio of volume and edges.
fn quality<const D: usize, const N: usize>(corners: &[Vector<D>; N]) -> f64
where
    Dim<D>: Dimension<D>,
{
    let mut squares = 0.0;
    for i in 0..N {
        for j in i + 1..N {
            squares += (corners[i] - corners[j]).norm_squared();
        }
    }
    let determinant = simplex::determinant(corners);
    match D {
        2 => 2.0 * 3f64.sqrt() * determinant / squares,
        _ => 12.0 * (0.5 * determinant).powf(2.0 / 3.0) / squares,
    }
}

/// Every side of a simplex belongs to two, or lies on a side of the box.
fn require_conforming<const D: usize, const N: usize>(mesh: &Mesh<D, N>, root: &Root<D>) {
    // by the middle of the side: with one cell across a period nodes do not tell sides apart
    let length = (root.upper - root.lower).max();
    let mut sides: BTreeMap<[i64; D], usize> = BTreeMap::new();
    for corners in &mesh.corners {
        for k in 0..N {
            let facet = simplex::facet_corners::<D>(k);
            let middle = facet
                .iter()
                .fold(Vector::<D>::zeros(), |sum, &c| sum + corners[c]);
            let middle = middle / D as f64 - root.lower;
            let key = std::array::from_fn(|d| {
                let period = root.upper[d] - root.lower[d];
                let place = match root.periodic[d] && (middle[d] - period).abs() < 1e-12 * length {
                    true => 0.0,
                    false => middle[d],
                };
                (place / length * 2f64.powi(40)).round() as i64
            });
            *sides.entry(key).or_default() += 1;
        }
    }
    let single = sides.values().filter(|&&count| count == 1).count();
    assert!(sides.values().all(|&count| count <= 2));
    assert_eq!(single, mesh.facets.len());
}

/// Of halves: round-off of a long sum is not that of the mesh.
pub fn sum(values: &[f64]) -> f64 {
    match values.len() {
        0..=8 => values.iter().sum(),
        count => sum(&values[..count / 2]) + sum(&values[count / 2..]),
    }
}

/// Each node of another mesh is the mean of the nodes around it; one that is in both is found as itself.
pub fn require_found<const D: usize, const N: usize>(
    spots: &[Spot<N>],
    mesh: &Mesh<D, N>,
    other: &Mesh<D, N>,
    apart: impl Fn(&Vector<D>, &Vector<D>) -> Vector<D>,
) {
    assert_eq!(spots.len(), other.node_count());
    for ((nodes, weights), position) in spots.iter().zip(&other.position) {
        assert!(weights.iter().all(|&weight| weight >= 0.0), "{weights:?}");
        assert_eq!(weights.iter().sum::<f64>(), 1.0);
        let mut mean = Vector::<D>::zeros();
        for (node, weight) in nodes.iter().zip(weights) {
            mean += apart(&mesh.position[*node as usize], position) * *weight;
        }
        assert!(mean.norm() < 1e-12, "{mean}");
        let same = |&node: &u32| mesh.position[node as usize] == *position;
        if let Some(k) = nodes.iter().position(same) {
            assert_eq!(weights[k], 1.0);
        }
    }
}

/// 300 random size functions: worst quality of those of this root's shape, and the largest mesh.
fn any_size_function<const D: usize, const N: usize>(finest: f64)
where
    Dim<D>: Dimension<D>,
{
    let mut random_numbers = Random(7);
    let (mut worst, mut largest, mut deepest, mut defect) = (f64::INFINITY, 0, 1.0_f64, 0.0_f64);
    for _ in 0..300 {
        let (root, zones, growth) = random::<D>(&mut random_numbers, finest);
        let sizes = Sizes::new(zones.clone(), growth, root.size(), root.period());
        let (bisection, mesh) = Bisection::<_, D, N>::new(&root, &sizes, SIMPLICES_MAX).unwrap();
        require_conforming(&mesh, &root);
        let extent = root.upper - root.lower;
        let volume: f64 = extent.iter().product();
        defect = defect.max((sum(&mesh.nodal_mass) / volume - 1.0).abs());
        // (B2) at every corner and in the middle, and no larger than the root
        for (corners, shape) in mesh.corners.iter().zip(&mesh.geometry) {
            let size = simplex::cube_edge::<D>(simplex::determinant(corners));
            let least = corners
                .iter()
                .map(|x| sizes.at(x))
                .fold(f64::INFINITY, f64::min);
            assert!(
                size <= least * (1.0 + 1e-8),
                "{size} where {least} is asked"
            );
            deepest = deepest.min(size / root.size());
            // of simplices of the unit cube: the map of a cell onto it keeps (B1)
            let scale: [f64; D] = std::array::from_fn(|d| root.cells[d] as f64 / extent[d]);
            let unit = corners.map(|x| vector::from_fn(|d| x[d] * scale[d]));
            worst = worst.min(quality(&unit));
            assert!(shape.volume > 0.0);
        }
        largest = largest.max(mesh.node_count());
        // the same bits in another order
        let turned: Vec<_> = zones.iter().rev().copied().collect();
        let again = Sizes::new(turned, growth, root.size(), root.period());
        let (_, again) = Bisection::<_, D, N>::new(&root, &again, SIMPLICES_MAX).unwrap();
        assert!(again.position == mesh.position && again.simplices == mesh.simplices);
        // a node of another mesh is the mean of the nodes around it
        let (_, others, _) = random::<D>(&mut random_numbers, finest);
        let sizes = Sizes::new(others, growth, root.size(), root.period());
        let (other, nodes) = Bisection::<_, D, N>::new(&root, &sizes, SIMPLICES_MAX).unwrap();
        // with a cell or two across a period the nearest image need not be the corner
        let near = (0..D).all(|d| !root.periodic[d] || root.cells[d] > 2);
        let apart =
            |a: &Vector<D>, b: &Vector<D>| space::periodic::shortest_image(a - b, &root.period());
        if near {
            require_found(&bisection.spots_of(&other), &mesh, &nodes, apart);
        }
    }
    println!(
        "{D}D: worst quality {worst:.3}, volume to {defect:.1e}, largest {largest} nodes, smallest cell {deepest:.1e} of the root"
    );
    assert!(defect < 1e-12);
    assert!(worst > if D == 2 { 0.8659 } else { 0.7559 });
}

#[test]
fn any_size_function_gives_a_conforming_mesh_of_the_shapes_of_its_root() {
    any_size_function::<2, 3>(1.0 / 1024.0);
    any_size_function::<3, 4>(1.0 / 24.0);
}

/// One point as fine as 2^−20 of the root, and the same with a coarser wish: every vertex of it is one of the finer.
fn deep<const D: usize, const N: usize>(levels: i32)
where
    Dim<D>: Dimension<D>,
{
    let root = Root {
        lower: Vector::<D>::zeros(),
        upper: vector::from_fn(|_| 1.0),
        cells: [1; D],
        periodic: [false; D],
    };
    let place = Place::Ball {
        centre: vector::from_fn(|d| 0.3 + 0.1 * d as f64),
        radius: 0.0,
    };
    let mesh = |levels: i32| {
        let size = 2f64.powi(-levels);
        let sizes = Sizes::new(vec![Zone { place, size }], 1.0, 1.0, [None; D]);
        Bisection::<_, D, N>::new(&root, &sizes, SIMPLICES_MAX)
            .unwrap()
            .1
    };
    let (fine, coarse) = (mesh(levels), mesh(levels - 3));
    let worst = fine
        .corners
        .iter()
        .map(quality)
        .fold(f64::INFINITY, f64::min);
    let mut places: Vec<_> = fine.position.iter().map(|x| x.map(f64::to_bits)).collect();
    places.sort_by_key(|x| x.iter().copied().collect::<Vec<u64>>());
    let nested = coarse.position.iter().all(|x| {
        let key: Vec<u64> = x.iter().map(|x| x.to_bits()).collect();
        places
            .binary_search_by_key(&key, |x| x.iter().copied().collect())
            .is_ok()
    });
    let volume: f64 = fine.nodal_mass.iter().sum();
    println!(
        "{D}D, {levels} halvings: {} nodes, worst quality {worst:.3}, volume to {:.0e}",
        fine.node_count(),
        (volume - 1.0).abs()
    );
    assert!(nested && (volume - 1.0).abs() < 1e-12);
    require_conforming(&fine, &root);
}

#[test]
fn twenty_levels_keep_the_shape_and_coarser_wishes_are_nested() {
    deep::<2, 3>(20);
    deep::<3, 4>(20);
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let root = |cells: usize| Root {
        lower: Vector::<2>::zeros(),
        upper: [1.0, 1.0].into(),
        cells: [cells, 1],
        periodic: [false; 2],
    };
    let point = |size: f64| Zone {
        place: Place::Ball {
            centre: [0.5, 0.5].into(),
            radius: 0.4,
        },
        size,
    };
    for (cells, size, named) in [
        (0, 0.1, "0 cells along an axis"),
        (4096, 0.1, "4096 cells along an axis"),
        (1, 1e-4, "more than 1000 triangles"),
    ] {
        let sizes = Sizes::new(vec![point(size)], 0.2, 1.0, [None; 2]);
        let refused = Bisection::<_, 2, 3>::new(&root(cells), &sizes, 1000);
        let words = refused.map(drop).unwrap_err().to_string();
        println!("{words}");
        assert!(words.contains(named), "{words}");
    }
}
