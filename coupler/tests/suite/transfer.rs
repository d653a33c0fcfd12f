//! The transfer between grains and mesh, in the plane and in space: what it conserves, and that
//! sampling is its adjoint.

use coupler::error::CouplerError;
use coupler::transfer::Transfer;
use space::{Dim, Dimension, Vector, dot, vector};

use crate::mesh::{cube, noise, points};

fn conserves<const D: usize, const N: usize>(cells: usize)
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(cells, 0.4, false);
    let positions = points::<D>(1000);
    let values: Vec<f64> = (0..1000)
        .map(|i| 10_f64.powf(6.0 * noise(3 * i + 1)))
        .collect();
    let force = |i: usize| vector::from_fn::<D>(|axis| values[i] * (noise(11 * i + axis) - 0.5));
    let rough: Vec<Vector<D>> = (0..mesh.nodal_mass.len())
        .map(|a| vector::from_fn(|axis| 1e6 * (noise(7 * a + axis) - 0.5)))
        .collect();
    let transfer = Transfer::new(&mesh, 1.0);
    println!("| D | r/h | volume defect | action + reaction |");
    // points, spread as far as cells need, of their own size, and of sizes 1:30
    for (ratio, sizes) in [(0.1, 1.0), (0.3, 1.0), (1.5, 1.0), (0.05, 30.0)] {
        let radius = |i: usize| ratio / cells as f64 * f64::powf(sizes, noise(5 * i));
        let radii: Vec<f64> = (0..1000).map(radius).collect();
        let placement = transfer.place(&positions, &radii).expect("all inside");
        let nodal = transfer.deposit(&placement, |i| values[i]);
        let total: f64 = values.iter().sum();
        let deposited: f64 = nodal.iter().zip(&mesh.nodal_mass).map(|(c, l)| c * l).sum();
        let sampled = transfer.sample(&placement, &rough);
        let forces = transfer.deposit(&placement, force);
        let on_fluid: f64 = (0..rough.len())
            .map(|a| mesh.nodal_mass[a] * dot(&forces[a], &rough[a]))
            .sum();
        let power = |i: usize| dot(&force(i), &sampled[i]);
        let on_grains: f64 = (0..1000).map(power).sum();
        let size: f64 = (0..1000).map(|i| power(i).abs()).sum();
        let (volume, force) = (
            (deposited / total - 1.0).abs(),
            (on_fluid - on_grains).abs() / size,
        );
        println!("| {D} | {ratio} | {volume:.1e} | {force:.1e} |");
        assert!(volume <= 1e-14, "r/h {ratio}: volume defect {volume}");
        assert!(force <= 1e-14, "r/h {ratio}: force defect {force}");
    }
}

#[test]
fn deposited_volume_is_the_grains_volume_and_sampling_is_the_adjoint_of_deposit() {
    conserves::<2, 3>(16);
    conserves::<3, 4>(6);
}

fn reproduces<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(7, 0.4, false);
    let transfer = Transfer::new(&mesh, 1.0);
    let at = |x: &Vector<D>| 2.0 + 3.0 * x[0] - x[D - 1];
    let linear: Vec<f64> = mesh.node_position.iter().map(at).collect();
    let inside = points::<D>(200);
    let placement = transfer.place(&inside, &[0.0; 200]).expect("inside");
    for (value, point) in transfer.sample(&placement, &linear).iter().zip(&inside) {
        assert!((value - at(point)).abs() < 1e-13, "{point}");
    }
    let mut beyond: Vector<D> = vector::from_fn(|_| 0.4);
    beyond[0] = 1.01;
    let placement = transfer.place(&[beyond], &[0.0]).expect("near the mesh");
    let clipped = transfer.sample(&placement, &linear)[0];
    assert!((clipped - (5.0 - 0.4)).abs() < 0.05, "{clipped}");
    beyond[0] = 3.0;
    let error = transfer
        .place(&[inside[0], beyond], &[0.0; 2])
        .expect_err("outside");
    assert!(matches!(error, CouplerError::GrainOutside { grain: 1, .. }));
    assert!(error.to_string().contains("grain 1 at (3.0"), "{error}");
    beyond[0] = f64::NAN;
    assert!(transfer.place(&[beyond], &[0.0]).is_err());
}

#[test]
fn shape_functions_reproduce_a_linear_field_and_points_just_outside_are_clipped() {
    reproduces::<2, 3>();
    reproduces::<3, 4>();
}

fn wraps<const D: usize, const N: usize>()
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(5, 0.0, true);
    let transfer = Transfer::new(&mesh, 1.0);
    let at = |x: &Vector<D>| (std::f64::consts::TAU * x[0]).cos() + x[D - 1];
    let field: Vec<f64> = mesh.node_position.iter().map(at).collect();
    // points in the last cell before the seam, on it, and images of both
    let sample = |x: f64| {
        let mut point: Vector<D> = vector::from_fn(|axis| 0.3 + 0.1 * axis as f64);
        point[0] = x;
        let placement = transfer.place(&[point], &[0.0]).expect("periodic");
        transfer.sample(&placement, &field)[0]
    };
    for x in [0.0, 0.03, 0.5, 0.87, 0.99] {
        for turns in [-3.0, -1.0, 1.0, 4.0] {
            let apart = (sample(x) - sample(x + turns)).abs();
            assert!(apart < 1e-13, "{x} {turns}: {apart}");
        }
    }
    // linear across the seam: from cos(TAU·0.8) at x = 0.8 to 1 at x = 1, the node of x = 0
    let rise = sample(0.95) - sample(0.9);
    let expected = 0.25 * (1.0 - (std::f64::consts::TAU * 0.8).cos());
    assert!((rise - expected).abs() < 1e-13, "{rise} for {expected}");
}

#[test]
fn points_are_found_across_a_period() {
    wraps::<2, 3>();
    wraps::<3, 4>();
}

fn stops_at_the_rim<const D: usize, const N: usize>(periodic: bool)
where
    Dim<D>: Dimension<D>,
{
    let mesh = cube::<D, N>(5, 0.4, periodic);
    let transfer = Transfer::new(&mesh, 1.0);
    let mut left = 0;
    for (grain, start) in points::<D>(200).iter().enumerate() {
        let by = vector::from_fn::<D>(|axis| 3.0 * (noise(13 * grain + axis) - 0.5));
        let end = transfer
            .last_inside(grain, start, &by)
            .expect("it starts inside");
        // How much of the way there is, axis by axis; along a period it never ends.
        let share = |axis: usize| match by[axis] {
            _ if periodic && axis == 0 => 1.0,
            way if way > 0.0 => (1.0 - start[axis]) / way,
            way => -start[axis] / way,
        };
        let share = (0..D).map(share).fold(1.0, f64::min);
        left += usize::from(share < 1.0);
        for axis in 0..D {
            let apart = end[axis] - (start[axis] + share * by[axis]);
            let apart = if periodic && axis == 0 {
                apart - apart.round()
            } else {
                apart
            };
            assert!(apart.abs() < 1e-10, "{start:?} by {by:?} ends at {end:?}");
        }
        assert!(share == 1.0 || transfer.is_outside(&(start + by)));
    }
    println!("{D} periodic {periodic}: {left} of 200 leave");
    assert!(left > 40);
}

#[test]
fn a_path_that_leaves_ends_where_it_was_inside_for_the_last_time() {
    for periodic in [false, true] {
        stops_at_the_rim::<2, 3>(periodic);
        stops_at_the_rim::<3, 4>(periodic);
    }
}
