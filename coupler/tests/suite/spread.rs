//! The kernel belongs to the grain: what a grain of any size makes of the porosity around it, and what
//! walls, periods and corners do to it.

use coupler::transfer::{Mesh, Placement, Transfer};
use space::{Dim, Dimension, Simplex, Vector, vector};

use crate::mesh::{cube, noise, points};

/// The unit cube of a mesh, stretched to these sides \[m\].
fn stretched<const D: usize, const N: usize>(
    cells: usize,
    shift: f64,
    periodic: bool,
    sides: [f64; D],
) -> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    let mut mesh = cube::<D, N>(cells, shift, periodic);
    let stretch = |x: &mut Vector<D>| *x = vector::from_fn(|axis| x[axis] * sides[axis]);
    mesh.node_position.iter_mut().for_each(stretch);
    mesh.corners.as_flattened_mut().iter_mut().for_each(stretch);
    let volume: f64 = sides.iter().product();
    mesh.nodal_mass.iter_mut().for_each(|mass| *mass *= volume);
    mesh.period[0] = mesh.period[0].map(|length| length * sides[0]);
    mesh
}

/// 1 − T(V) of disks or balls of these radii \[m\].
fn porosity<const D: usize, const N: usize>(
    transfer: &Transfer<D, N>,
    placement: &Placement,
    radii: &[f64],
) -> Vec<f64>
where
    Dim<D>: Dimension<D>,
{
    let ball = [
        0.0,
        2.0,
        std::f64::consts::PI,
        4.0 / 3.0 * std::f64::consts::PI,
    ][D];
    let solid = transfer.deposit(placement, |i| ball * radii[i].powi(D as i32));
    solid.iter().map(|solid| 1.0 - solid).collect()
}

fn total<const D: usize, const N: usize>(transfer: &Transfer<D, N>, placement: &Placement) -> f64
where
    Dim<D>: Dimension<D>,
{
    let nodal = transfer.deposit(placement, |_| 1.0);
    nodal
        .iter()
        .zip(transfer.nodal_mass())
        .map(|(c, l)| c * l)
        .sum()
}

#[test]
fn a_large_grain_above_a_suspension_of_small_ones_leaves_clear_fluid_between_them() {
    // 5 × 20 mm, the lower half with grains of 0.1 mm at c = 0.1, one of 3 mm at y = 18 mm
    let mesh = stretched::<2, 3>(80, 0.0, false, [5e-3, 20e-3]);
    let transfer = Transfer::new(&mesh, 1.0);
    let spacing = 0.05e-3 * (std::f64::consts::PI / 0.1).sqrt();
    let (columns, rows) = ((5e-3 / spacing) as usize, (10e-3 / spacing) as usize);
    let at = |k: usize| [k % columns, k / columns].map(|i| (i as f64 + 0.5) * spacing);
    let mut positions: Vec<Vector<2>> = (0..columns * rows).map(|k| Vector::from(at(k))).collect();
    let mut radii = vec![0.05e-3; positions.len()];
    positions.push(Vector::from([2.5e-3, 18e-3]));
    radii.push(1.5e-3);
    let placement = transfer.place(&positions, &radii).expect("inside");
    let porosity = porosity(&transfer, &placement, &radii);
    let (mut between, mut below, mut inside) = (Vec::new(), Vec::new(), Vec::new());
    for (x, phi) in mesh.node_position.iter().zip(&porosity) {
        match x[1] {
            y if y > 11e-3 && y < 12.5e-3 => between.push(*phi),
            y if y > 1e-3 && y < 9e-3 => below.push(*phi),
            _ if (x - positions[positions.len() - 1]).norm() < 1.5e-3 => inside.push(*phi),
            _ => {}
        }
    }
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    println!(
        "between {}, below {}, inside {}",
        mean(&between),
        mean(&below),
        mean(&inside)
    );
    assert!(between.iter().all(|&phi| phi == 1.0), "{between:?}");
    assert!((mean(&below) - 0.9).abs() < 0.01, "{}", mean(&below));
    assert!(inside.iter().all(|&phi| phi > 0.1), "{inside:?}");
}

/// Smallest porosity of one grain of `wide` cells in the middle of a mesh, and the porosity of its centre.
fn alone<const D: usize, const N: usize>(cells: usize, wide: f64) -> [f64; 2]
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(cells, 0.3, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let radii = [0.5 * wide / cells as f64];
    let centre: Vector<D> = vector::from_fn(|axis| 0.5 + 0.1 * axis as f64 / cells as f64);
    let placement = transfer.place(&[centre], &radii).expect("inside");
    let porosity = porosity(&transfer, &placement, &radii);
    let far = mesh.node_position.iter().zip(&porosity);
    let beyond = (2.75 * radii[0]).max(2.0 / cells as f64) + 2.2 / cells as f64;
    for (x, phi) in far.filter(|(x, _)| (*x - centre).norm() > beyond) {
        assert_eq!(*phi, 1.0, "{x}");
    }
    let sampled = transfer.sample(&placement, &porosity)[0];
    [porosity.into_iter().fold(f64::INFINITY, f64::min), sampled]
}

#[test]
fn the_porosity_is_positive_inside_a_grain_of_any_size() {
    println!("| D | d/h | least φ | φ that it feels |");
    for wide in [0.3, 1.0, 3.0, 10.0] {
        let [least, felt] = alone::<2, 3>(48, wide);
        println!("| 2 | {wide} | {least:.3} | {felt:.3} |");
        assert!(least > 0.5 && felt > least, "{wide}: {least} {felt}");
    }
    for wide in [0.3, 1.0, 4.0] {
        let [least, felt] = alone::<3, 4>(14, wide);
        println!("| 3 | {wide} | {least:.3} | {felt:.3} |");
        assert!(least > 0.7 && felt > least, "{wide}: {least} {felt}");
    }
}

fn meets_walls<const D: usize, const N: usize>(cells: usize, periodic: bool)
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(cells, 0.3, periodic);
    let transfer = Transfer::new(&mesh, 1.0);
    for (k, mut at) in points::<D>(20).into_iter().enumerate() {
        at[k % D] = [0.0, 1e-3, 1.0 - 1e-3, 1.0][k % 4]; // across a side, and corners
        at[(k + 1) % D] *= noise(k).round();
        for wide in [0.4, 2.0, 6.0] {
            let radii = [0.5 * wide / cells as f64];
            let placement = transfer.place(&[at], &radii).expect("inside");
            let (_, weights) = placement.entries(0);
            assert!(weights.iter().all(|&weight| weight > 0.0));
            let total = total(&transfer, &placement);
            assert!((total - 1.0).abs() < 1e-14, "{at}: {total}");
        }
    }
}

#[test]
fn a_grain_that_overlaps_walls_and_corners_gives_all_its_volume_to_the_nodes() {
    for periodic in [false, true] {
        meets_walls::<2, 3>(12, periodic);
        meets_walls::<3, 4>(6, periodic);
    }
}

/// Grains on a square or cubic lattice that begins half a spacing from every wall.
fn fills<const D: usize, const N: usize>(cells: usize, side: usize, radius: f64)
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(cells, 0.0, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let place = |k: usize| -> Vector<D> {
        vector::from_fn(|axis| ((k / side.pow(axis as u32) % side) as f64 + 0.5) / side as f64)
    };
    let positions: Vec<Vector<D>> = (0..side.pow(D as u32)).map(place).collect();
    let radii = vec![radius; positions.len()];
    let placement = transfer.place(&positions, &radii).expect("inside");
    let porosity = porosity(&transfer, &placement, &radii);
    let [least, most] =
        [f64::min, f64::max].map(|f| porosity.iter().copied().reduce(f).expect("nodes"));
    println!("| {D} | {least:.4} | {most:.4} |");
    assert!(most - least < 0.1 * (1.0 - least), "{least} {most}");
}

#[test]
fn a_bed_is_as_dense_along_its_walls_and_in_its_corners_as_inside() {
    println!("| D | least φ | most φ |");
    fills::<2, 3>(16, 20, 0.02);
    fills::<3, 4>(8, 10, 0.04);
}

fn leaves_linear_fields<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(12, 0.3, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let at = |x: &Vector<D>| 2.0 + 3.0 * x[0] - x[D - 1];
    let linear: Vec<f64> = mesh.node_position.iter().map(at).collect();
    let inside: Vec<Vector<D>> = points::<D>(50)
        .into_iter()
        .map(|x| vector::from_fn(|axis| 0.4 + 0.2 * x[axis]))
        .collect();
    for radius in [0.02, 0.05, 0.14] {
        let placement = transfer.place(&inside, &[radius; 50]).expect("inside");
        for (felt, x) in transfer.sample(&placement, &linear).iter().zip(&inside) {
            assert!((felt - at(x)).abs() < 1e-12, "{radius} {x}: {felt}");
        }
    }
}

#[test]
fn a_grain_away_from_walls_feels_a_linear_field_as_its_centre_does() {
    leaves_linear_fields::<2, 3>();
    leaves_linear_fields::<3, 4>();
}

#[test]
fn a_kernel_does_not_cross_a_wall_that_stands_between() {
    // two boxes that share a side but no node: a wall without thickness
    let left = cube::<2, 3>(8, 0.0, false);
    let mut both = cube::<2, 3>(8, 0.0, false);
    let count = left.node_position.len() as u32;
    let right = |x: &Vector<2>| x + Vector::from([1.0, 0.0]);
    both.node_position
        .extend(left.node_position.iter().map(right));
    both.corners.extend(
        left.corners
            .iter()
            .map(|corners| corners.map(|x| right(&x))),
    );
    both.simplices.extend(
        left.simplices
            .iter()
            .map(|nodes| nodes.map(|node| node + count)),
    );
    both.nodal_mass.extend(&left.nodal_mass);
    let transfer = Transfer::new(&both, 1.0);
    let placement = transfer
        .place(&[Vector::from([0.9, 0.5])], &[0.1])
        .expect("inside");
    let (nodes, _) = placement.entries(0);
    assert!(nodes.iter().all(|&node| node < count), "{nodes:?}");
}

#[test]
fn a_period_of_one_cell_wraps_a_kernel_that_is_wider() {
    // a column one cell wide, periodic across: all nodes of a row are one
    let (rows, width, height) = (20, 0.25, 5.0);
    let mut mesh = Mesh::<2, 3> {
        node_position: (0..=rows)
            .map(|j| Vector::from([0.0, height * j as f64 / rows as f64]))
            .collect(),
        simplices: Vec::new(),
        corners: Vec::new(),
        nodal_mass: vec![0.0; rows + 1],
        period: [Some(width), None],
    };
    for j in 0..rows {
        let [low, high] = [j, j + 1].map(|j| height * j as f64 / rows as f64);
        let (a, b) = (j as u32, j as u32 + 1);
        let corner = |x: f64, y: f64| Vector::from([x, y]);
        let (p, q) = (corner(0.0, low), corner(width, high));
        mesh.simplices.push([a, a, b]);
        mesh.corners.push([p, corner(width, low), q]);
        mesh.simplices.push([a, b, b]);
        mesh.corners.push([p, q, corner(0.0, high)]);
    }
    for (nodes, corners) in mesh.simplices.iter().zip(&mesh.corners) {
        for &node in nodes {
            mesh.nodal_mass[node as usize] += Simplex::new(corners).volume / 3.0;
        }
    }
    let transfer = Transfer::new(&mesh, 1.0);
    for x in [0.0, 0.1, 0.2499] {
        let placement = transfer
            .place(&[Vector::from([x, 2.5])], &[0.3])
            .expect("inside");
        let height: Vec<f64> = mesh.node_position.iter().map(|x| x[1]).collect();
        let felt = transfer.sample(&placement, &height)[0];
        assert!((felt - 2.5).abs() < 1e-12, "{felt}");
        let (_, weights) = placement.entries(0);
        assert!(weights.len() >= 5, "{weights:?}");
    }
}
