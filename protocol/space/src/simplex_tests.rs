//! Both simplices against what holds for every one.

use proptest::prelude::*;

use crate::dimension::{Dim, Dimension};
use crate::simplex::{Simplex, combine, determinant, facet_corners, project, weights};
use crate::vector::{Vector, dot, from_fn};

fn check<const D: usize, const N: usize>(numbers: &[f64]) -> Result<(), TestCaseError>
where
    Dim<D>: Dimension<D>,
{
    let mut corners: [Vector<D>; N] = std::array::from_fn(|i| from_fn(|d| numbers[D * i + d]));
    if determinant(&corners) < 0.0 {
        corners.swap(0, 1);
    }
    prop_assume!(determinant(&corners) > 1e-2);
    let simplex = Simplex::new(&corners);
    for i in 0..N {
        for k in 0..N {
            // N_i is linear: 1 at its corner, 0 at the others.
            let at = 1.0 + dot(&simplex.gradient[i], &(corners[k] - corners[i]));
            prop_assert!((at - f64::from(i == k)).abs() < 1e-9, "{i} {k} {at}");
        }
        // Outward: away from the corner that the facet lies opposite to.
        let facet = facet_corners::<D>(i).map(|corner| corners[corner]);
        let outward = Dim::<D>::facet_normal(&facet);
        prop_assert!(dot(&outward, &(corners[i] - facet[0])) < 0.0);
    }
    let sum = simplex
        .gradient
        .iter()
        .fold(Vector::<D>::zeros(), |sum, g| sum + g);
    prop_assert!(sum.norm() < 1e-9);
    let inside: [f64; N] = std::array::from_fn(|i| (1.0 + i as f64) / (N * (N + 1) / 2) as f64);
    let point = combine(&inside, &corners);
    let found = weights(&corners, &point);
    for i in 0..N {
        prop_assert!((found[i] - inside[i]).abs() < 1e-9);
    }
    prop_assert_eq!(project(&found, &corners, &point).1, 0.0);
    let beyond = corners[0] + (corners[0] - point);
    let (clipped, distance) = project(&weights(&corners, &beyond), &corners, &beyond);
    prop_assert!(distance > 0.0 && clipped.iter().all(|&weight| weight >= 0.0));
    Ok(())
}

proptest! {
    #[test]
    fn a_triangle_is_a_simplex(numbers in prop::collection::vec(-1.0..1.0f64, 6)) {
        check::<2, 3>(&numbers)?;
    }

    #[test]
    fn a_tetrahedron_is_a_simplex(numbers in prop::collection::vec(-1.0..1.0f64, 12)) {
        check::<3, 4>(&numbers)?;
    }
}

#[test]
fn sizes_are_diameters_of_the_equal_disk_and_ball() {
    let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::from);
    let tetrahedron =
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from);
    let (disk, ball) = (Simplex::new(&triangle), Simplex::new(&tetrahedron));
    assert_eq!((disk.volume, ball.volume), (0.5, 1.0 / 6.0));
    let (d, b) = (disk.size(), ball.size());
    assert!((std::f64::consts::PI * d * d / 4.0 - disk.volume).abs() < 1e-15);
    assert!((std::f64::consts::PI * b * b * b / 6.0 - ball.volume).abs() < 1e-15);
}
