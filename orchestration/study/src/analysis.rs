//! Medians, errors, observed orders, the Pareto front.

/// The median; of an even count the mean of the middle two; NaN of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => sorted[count / 2],
        count => 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]),
    }
}

/// |value/truth − 1|, or |value| where the truth is 0.
pub fn error(value: f64, truth: f64) -> f64 {
    if truth == 0.0 {
        value.abs()
    } else {
        (value / truth - 1.0).abs()
    }
}

/// Observed order between each pair of neighbours: none where an error or a size forbids it.
pub fn orders(sizes: &[f64], errors: &[f64]) -> Vec<Option<f64>> {
    let order = |k: usize| {
        let order = (errors[k] / errors[k - 1]).ln() / (sizes[k] / sizes[k - 1]).ln();
        order.is_finite().then_some(order)
    };
    (0..sizes.len())
        .map(|k| if k == 0 { None } else { order(k) })
        .collect()
}

/// Slope of the straight line through logarithms, by least squares.
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    straight(&logs)
}

/// Slope of the straight line through points, by least squares; none of fewer than two.
pub fn straight(points: &[(f64, f64)]) -> Option<f64> {
    let count = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let spread: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    let together: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    (points.len() > 1 && spread > 0.0).then(|| together / spread)
}

/// Which (cost, error) no other one beats in both.
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let known = |p: &(f64, f64)| !p.0.is_nan() && !p.1.is_nan();
    points
        .iter()
        .map(|point| known(point) && !points.iter().any(|other| beats(other, point)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&[f64::NAN, 7.0]), 7.0);
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn the_order_of_a_power_law_is_its_power() {
        let sizes = [0.4, 0.2, 0.1, 0.05];
        let errors = sizes.map(|h: f64| 3.0 * h.powf(1.5));
        let orders = orders(&sizes, &errors);
        println!("{orders:?}");
        assert_eq!(orders[0], None);
        assert!(
            orders[1..]
                .iter()
                .all(|p| (p.expect("an order") - 1.5).abs() < 1e-12)
        );
        let points: Vec<(f64, f64)> = sizes.into_iter().zip(errors).collect();
        assert!((slope(&points).expect("a slope") - 1.5).abs() < 1e-12);
    }

    #[test]
    fn an_exact_answer_or_a_failed_point_has_no_order() {
        assert_eq!(orders(&[0.2, 0.1], &[1e-3, 0.0]), [None, None]);
        assert_eq!(orders(&[0.2, 0.1], &[f64::NAN, 1e-3]), [None, None]);
        assert_eq!(slope(&[(1.0, 2.0)]), None);
    }

    #[test]
    fn the_front_is_what_no_other_point_beats() {
        let points = [
            (1.0, 0.1),
            (2.0, 0.05),
            (3.0, 0.06),
            (4.0, 0.01),
            (f64::NAN, 0.001),
            (2.0, 0.05),
        ];
        assert_eq!(pareto(&points), [true, true, false, true, false, true]);
    }

    #[test]
    fn errors_are_relative_unless_the_truth_is_zero() {
        assert!((error(1.01, 1.0) - 0.01).abs() < 1e-15);
        assert_eq!(error(-2e-9, 0.0), 2e-9);
    }
}
