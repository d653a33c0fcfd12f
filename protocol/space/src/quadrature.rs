//! Rules on simplices: barycentric points with weights that are positive and sum to one.
//!
//! | corners | simplex | points | exact to degree | source |
//! | --- | --- | --- | --- | --- |
//! | 2 | segment | 3 | 5 | Gauss |
//! | 3 | triangle | 6 | 4 | Strang and Fix 1973 |
//! | 4 | tetrahedron | 14 | 5 | Walkington 2000 |

/// A point (N_0, N_1, …) and its weight.
type Sample = (&'static [f64], f64);

/// The points of the rule for simplices with `K` corners, in a fixed order.
#[inline(always)]
pub fn points<const K: usize>() -> impl Iterator<Item = ([f64; K], f64)> {
    let rule = const { rule(K) };
    rule.iter()
        .map(|(point, weight)| (std::array::from_fn(|k| point[k]), *weight))
}

const fn rule(corners: usize) -> &'static [Sample] {
    match corners {
        2 => &SEGMENT,
        3 => &TRIANGLE,
        4 => &TETRAHEDRON,
        _ => panic!("rules are known for segments, triangles and tetrahedra"),
    }
}

const SEGMENT: [Sample; 3] = {
    const LOW: f64 = 0.112_701_665_379_258_31;
    const HIGH: f64 = 0.887_298_334_620_741_7;
    [
        (&[1.0 - LOW, LOW], 5.0 / 18.0),
        (&[0.5, 0.5], 8.0 / 18.0),
        (&[1.0 - HIGH, HIGH], 5.0 / 18.0),
    ]
};

const TRIANGLE: [Sample; 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const WA: f64 = 0.223_381_589_678_011;
    const WB: f64 = 1.0 / 3.0 - WA;
    [
        (&[A, A, 1.0 - 2.0 * A], WA),
        (&[A, 1.0 - 2.0 * A, A], WA),
        (&[1.0 - 2.0 * A, A, A], WA),
        (&[B, B, 1.0 - 2.0 * B], WB),
        (&[B, 1.0 - 2.0 * B, B], WB),
        (&[1.0 - 2.0 * B, B, B], WB),
    ]
};

const TETRAHEDRON: [Sample; 14] = {
    const A: f64 = 0.310_885_919_263_300_6;
    const FAR_A: f64 = 1.0 - 3.0 * A;
    const WA: f64 = 0.112_687_925_718_015_85;
    const B: f64 = 0.092_735_250_310_891_22;
    const FAR_B: f64 = 1.0 - 3.0 * B;
    const WB: f64 = 0.073_493_043_116_361_95;
    const C: f64 = 0.045_503_704_125_649_65;
    const FAR_C: f64 = 0.5 - C;
    const WC: f64 = (1.0 - 4.0 * WA - 4.0 * WB) / 6.0;
    [
        (&[A, A, A, FAR_A], WA),
        (&[A, A, FAR_A, A], WA),
        (&[A, FAR_A, A, A], WA),
        (&[FAR_A, A, A, A], WA),
        (&[B, B, B, FAR_B], WB),
        (&[B, B, FAR_B, B], WB),
        (&[B, FAR_B, B, B], WB),
        (&[FAR_B, B, B, B], WB),
        (&[C, C, FAR_C, FAR_C], WC),
        (&[C, FAR_C, C, FAR_C], WC),
        (&[C, FAR_C, FAR_C, C], WC),
        (&[FAR_C, C, C, FAR_C], WC),
        (&[FAR_C, C, FAR_C, C], WC),
        (&[FAR_C, FAR_C, C, C], WC),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimension::factorial;

    /// Largest error of ∫ Π N_k^p_k over a simplex of unit size, (K−1)! Π p_k!/(K − 1 + Σ p_k)!,
    /// over all powers of N_1, N_2… up to a degree.
    fn error<const K: usize>(degree: usize) -> f64 {
        let mut worst: f64 = 0.0;
        for code in 0..(degree + 1).pow(K as u32 - 1) {
            let power = |k: usize| code / (degree + 1).pow(k as u32 - 1) % (degree + 1);
            let total: usize = (1..K).map(power).sum();
            if total > degree {
                continue;
            }
            let product: usize = (1..K).map(|k| factorial(power(k))).product();
            let exact = (factorial(K - 1) * product) as f64 / factorial(K - 1 + total) as f64;
            let value = |point: &[f64; K]| {
                (1..K)
                    .map(|k| point[k].powi(power(k) as i32))
                    .product::<f64>()
            };
            let sum: f64 = points::<K>()
                .map(|(point, weight)| weight * value(&point))
                .sum();
            worst = worst.max((sum - exact).abs());
        }
        worst
    }

    #[test]
    fn rules_are_exact_to_their_degree_with_positive_weights() {
        let errors = [error::<2>(5), error::<3>(4), error::<4>(5)];
        println!("largest errors {errors:?}");
        assert!(errors.iter().all(|error| *error < 1e-14));
        assert!(error::<2>(6) > 1e-6 && error::<3>(5) > 1e-6 && error::<4>(6) > 1e-6);
        for rule in [&SEGMENT[..], &TRIANGLE, &TETRAHEDRON] {
            for (point, weight) in rule {
                assert!(*weight > 0.0 && (point.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            }
        }
    }
}
