//! Walls of space made of triangles: polygons, tubes.

use std::f64::consts::PI;

use space::{Dim, Dimension, Vector, dot, hypot};

use crate::keys::Cylinder;

/// Corners of a triangle \[m\].
type Triangle = [[f64; 3]; 3];

/// How far corners may be from one plane, of their distances.
const FLAT: f64 = 1e-9;

/// Facets of a convex polygon, all from its first corner.
pub fn polygon(corners: &[[f64; 3]]) -> Result<Vec<Triangle>, String> {
    let [first, rest @ ..] = corners else {
        return Err("missing: write three corners or more (m), or cylinder".to_owned());
    };
    if rest.len() < 2 {
        return Err(format!(
            "has {} corners, must have three or more",
            corners.len()
        ));
    }
    let facets: Vec<Triangle> = rest
        .windows(2)
        .map(|pair| [*first, pair[0], pair[1]])
        .collect();
    let normal = |facet: &Triangle| <Dim<3>>::facet_normal(&facet.map(Vector::from));
    let whole = normal(&facets[0]);
    let size = hypot(&whole);
    for facet in &facets {
        let own = normal(facet);
        let along = dot(&own, &whole);
        if !(along > 0.0 && hypot(&own.cross(&whole)) <= FLAT * hypot(&own) * size) {
            let place = format!("{:?}", facet[2]);
            return Err(format!(
                "must be those of a flat convex polygon, one after the other; the one at {place} m is not"
            ));
        }
    }
    Ok(facets)
}

/// Sides of a tube, grains inside.
pub fn tube(cylinder: &Cylinder) -> Result<Vec<Triangle>, String> {
    let [from, to] = [cylinder.from, cylinder.to].map(Vector::from);
    let far = hypot(&(to - from));
    let finite = from.iter().chain(&to).all(|x| x.is_finite());
    if !(finite && far > 0.0 && cylinder.radius > 0.0 && cylinder.radius.is_finite()) {
        return Err("needs two different ends and a radius above 0 (m)".to_owned());
    }
    if !(3..=4096).contains(&cylinder.sides) {
        return Err(format!("has {} sides, must have 3 to 4096", cylinder.sides));
    }
    let [_, u, v] = <Dim<3>>::frame(&((to - from) / far));
    let step = 2.0 * PI / cylinder.sides as f64;
    let reach = cylinder.radius / (0.5 * step).cos();
    let corner = |end: &Vector<3>, k: usize| -> [f64; 3] {
        let (sin, cos) = (step * (k % cylinder.sides) as f64).sin_cos();
        (end + (u * cos + v * sin) * reach).into()
    };
    let side = |k: usize| {
        let [a, b] = [k, k + 1].map(|k| corner(&from, k));
        let [c, d] = [k + 1, k].map(|k| corner(&to, k));
        [[a, b, c], [a, c, d]]
    };
    Ok((0..cylinder.sides).flat_map(side).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_tube_look_inside() {
        let cylinder = Cylinder {
            from: [0.0; 3],
            to: [1.0, 1.0, 0.0],
            radius: 0.5,
            sides: 12,
        };
        for facet in tube(&cylinder).expect("a tube") {
            let middle: [f64; 3] =
                std::array::from_fn(|k| facet.iter().map(|x| x[k]).sum::<f64>() / 3.0);
            let along = 0.5 * (middle[0] + middle[1]);
            let to_axis = Vector::from([along - middle[0], along - middle[1], -middle[2]]);
            let normal = <Dim<3>>::inward_normal(&facet.map(Vector::from));
            let distance = to_axis.dot(&normal) / normal.norm();
            assert!((distance - 0.5).abs() < 1e-12, "{distance}");
        }
    }

    #[test]
    fn a_polygon_must_be_flat_and_convex() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(polygon(&square).map(|facets| facets.len()), Ok(2));
        let mut bent = square;
        bent[3][2] = 0.1;
        assert!(polygon(&bent).is_err());
        assert!(polygon(&[square[0], square[2], square[1], square[3]]).is_err());
        assert!(polygon(&square[..2]).is_err());
    }
}
