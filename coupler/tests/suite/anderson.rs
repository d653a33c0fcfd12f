//! (N1) in maps whose fixed points are known.

use coupler::coupled::anderson::Anderson;

/// x after this many iterations of an affine map from 0.
fn iterated(
    depth: usize,
    weights: Vec<f64>,
    iterations: usize,
    map: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let mut x = vec![0.0; weights.len()];
    let mut anderson = Anderson::new(depth, weights);
    for _ in 0..iterations {
        let image = map(&x);
        x = anderson.next(&x, &image);
    }
    x
}

#[test]
fn one_unknown_is_a_secant_step() {
    let map = |x: &[f64]| vec![-3.0 * x[0] + 8.0];
    assert_eq!(iterated(5, vec![1.0], 1, map), [8.0]);
    let second = iterated(5, vec![1.0], 2, map)[0];
    assert!((second - 2.0).abs() < 1e-14, "{second}");
    let not_affine = |x: &[f64]| vec![x[0].cos()];
    let root = iterated(1, vec![1.0], 8, not_affine)[0];
    assert!((root - 0.739_085_133_215_160_6).abs() < 1e-9, "{root}");
}

#[test]
fn two_unknowns_end_with_the_third_iteration_unless_only_one_change_is_kept() {
    let map = |x: &[f64]| vec![0.5 * x[0] + x[1] + 1.0, -0.25 * x[0] + 0.3 * x[1] - 2.0];
    // (I − A) x = b
    let expected = [-2.166_666_666_666_666_7, -2.083_333_333_333_333_5];
    let error = |depth| {
        let x = iterated(depth, vec![1.0; 2], 3, map);
        (x[0] - expected[0]).hypot(x[1] - expected[1])
    };
    println!("{:e} {:e} {:e}", error(10), error(2), error(1));
    assert!(error(10) < 1e-9 && error(2) < 1e-9);
    assert!(error(1) > 1e-3);
}

#[test]
fn weights_say_which_residual_matters() {
    // one change of x, two residuals that it cannot both bring to zero
    let next = |weights: Vec<f64>| {
        let mut anderson = Anderson::new(4, weights);
        anderson.next(&[0.0, 0.0], &[1.0, 2.0]);
        anderson.next(&[1.0, 1.0], &[3.0, 2.0])
    };
    // f₀ = (1, 2), f₁ = (2, 1), Δf = (1, −1), Δg = (2, 0); θ = (2 w₀² − w₁²)/(w₀² + w₁²)
    for (weights, theta) in [
        ([1.0, 1.0], 0.5),
        ([2.0, 1.0], 7.0 / 5.0),
        ([1.0, 3.0], -0.7),
    ] {
        let found = next(weights.to_vec());
        let expected = [3.0 - 2.0 * theta, 2.0];
        let error = (found[0] - expected[0]).abs() + (found[1] - expected[1]).abs();
        assert!(error < 1e-12, "{found:?} for {expected:?}");
    }
}

#[test]
fn changes_that_repeat_each_other_are_dropped() {
    let mut anderson = Anderson::new(10, vec![1.0; 2]);
    anderson.next(&[0.0, 0.0], &[1.0, 1.0]);
    anderson.next(&[1.0, 1.0], &[1.5, 1.5]);
    anderson.next(&[2.0, 2.0], &[2.0, 2.0]);
    let next = anderson.next(&[4.0, 4.0], &[3.0, 3.0]);
    assert!(next.iter().all(|x| (x - 2.0).abs() < 1e-6), "{next:?}");
}

#[test]
fn a_linear_map_of_four_unknowns_ends_within_six_iterations_even_where_plain_iteration_diverges() {
    let map = |x: &[f64]| -> Vec<f64> {
        let factors = [-3.0, 0.5, 0.9, 0.99];
        (0..4).map(|i| factors[i] * x[i] + 1.0 + i as f64).collect()
    };
    let mut anderson = Anderson::new(10, vec![1.0; 4]);
    let mut x = vec![0.0; 4];
    let mut residual = 0.0;
    for iteration in 0..7 {
        let image = map(&x);
        residual = image
            .iter()
            .zip(&x)
            .map(|(a, b)| a - b)
            .fold(0.0_f64, |max, value: f64| max.max(value.abs()));
        println!("{iteration} {residual:.3e}");
        x = anderson.next(&x, &image);
    }
    assert!(residual < 1e-6, "residual {residual}");
}
