//! Linear triangles: shape functions, quadrature, geometry.
//!
//! ```text
//!   N_i(x) = barycentric coordinate of corner i,  ∇N_i constant,  Σ N_i = 1
//!   h = √(4 A/π), the diameter of the disk of the same area
//! ```

/// Barycentric quadrature on a triangle, exact for polynomials of degree 4: six points, each
/// (N_0, N_1, N_2), with weights that sum to one (Strang and Fix 1973).
pub const QUADRATURE: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const WA: f64 = 0.223_381_589_678_011;
    const WB: f64 = 1.0 / 3.0 - WA;
    [
        ([A, A, 1.0 - 2.0 * A], WA),
        ([A, 1.0 - 2.0 * A, A], WA),
        ([1.0 - 2.0 * A, A, A], WA),
        ([B, B, 1.0 - 2.0 * B], WB),
        ([B, 1.0 - 2.0 * B, B], WB),
        ([1.0 - 2.0 * B, B, B], WB),
    ]
};

/// Gauss quadrature on an edge, exact for degree 5: position in (0, 1) and weight.
pub const EDGE_QUADRATURE: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Geometry of one triangle.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    /// ∇N_i \[1/m\].
    pub gradient: [[f64; 2]; 3],
    /// Area \[m²\].
    pub area: f64,
}

impl Triangle {
    /// Geometry from the corners; the area is negative when they are clockwise.
    pub fn new(corner: &[[f64; 2]; 3]) -> Triangle {
        let [a, b, c] = *corner;
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let side =
            |from: [f64; 2], to: [f64; 2]| [(from[1] - to[1]) / twice, (to[0] - from[0]) / twice];
        Triangle {
            gradient: [side(b, c), side(c, a), side(a, b)],
            area: 0.5 * twice,
        }
    }

    /// Diameter of the disk of the same area \[m\].
    pub fn size(&self) -> f64 {
        (4.0 * self.area / std::f64::consts::PI).sqrt()
    }

    /// Gradient of the linear field with these corner values.
    #[inline]
    pub fn gradient_of(&self, value: &[f64; 3]) -> [f64; 2] {
        let g = &self.gradient;
        [0, 1].map(|d| value[0] * g[0][d] + value[1] * g[1][d] + value[2] * g[2][d])
    }
}

/// Value of the linear field with these corner values where the shape functions are `shape`.
#[inline]
pub fn interpolate(shape: &[f64; 3], value: &[f64; 3]) -> f64 {
    shape[0] * value[0] + shape[1] * value[1] + shape[2] * value[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_to_degree_four() {
        // ∫ N_0^a N_1^b over a triangle of unit area = 2 a! b!/(a+b+2)!
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for a in 0..=4u32 {
            for b in 0..=(4 - a) {
                let exact = 2.0 * factorial(a) * factorial(b) / factorial(a + b + 2);
                let sum: f64 = QUADRATURE
                    .iter()
                    .map(|(n, w)| w * n[0].powi(a as i32) * n[1].powi(b as i32))
                    .sum();
                assert!((sum - exact).abs() < 1e-14, "{a} {b}: {sum} {exact}");
            }
        }
    }

    #[test]
    fn gradient_of_a_linear_field_is_exact() {
        let corner = [[0.3, -0.2], [1.7, 0.4], [0.1, 1.9]];
        let triangle = Triangle::new(&corner);
        let value = corner.map(|x| 2.0 - 3.0 * x[0] + 5.0 * x[1]);
        let gradient = triangle.gradient_of(&value);
        assert!((gradient[0] + 3.0).abs() < 1e-14 && (gradient[1] - 5.0).abs() < 1e-14);
        assert!(triangle.area > 0.0);
    }
}
