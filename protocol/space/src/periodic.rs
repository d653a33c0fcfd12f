//! Images across periodic sides.

use crate::vector::{Vector, from_fn};

/// Period along each axis \[m\]; none where there is no period.
pub type Period<const D: usize> = [Option<f64>; D];

/// Is there a period along some axis?
pub fn is_periodic<const D: usize>(period: &Period<D>) -> bool {
    period.iter().any(Option::is_some)
}

/// The shortest of the periodic images of `apart`.
#[inline]
pub fn shortest_image<const D: usize>(apart: Vector<D>, period: &Period<D>) -> Vector<D> {
    let mut image = apart;
    for axis in 0..D {
        if let Some(length) = period[axis] {
            image[axis] -= length * (image[axis] / length).round();
        }
    }
    image
}

/// The image of a point in the box that begins at `lower`.
#[inline]
pub fn into_box<const D: usize>(
    point: &Vector<D>,
    lower: &Vector<D>,
    period: &Period<D>,
) -> Vector<D> {
    from_fn(|axis| match period[axis] {
        Some(length) => point[axis] - ((point[axis] - lower[axis]) / length).floor() * length,
        None => point[axis],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_the_nearest_and_inside() {
        let period = [Some(2.0), None, Some(0.5)];
        let apart = Vector::from([1.5, 9.0, -0.3]);
        let nearest = shortest_image(apart, &period);
        assert_eq!(nearest, Vector::from([-0.5, 9.0, 0.2]));
        let point = into_box(&Vector::from([-3.5, 9.0, 1.3]), &Vector::zeros(), &period);
        assert!((point - Vector::from([0.5, 9.0, 0.3])).norm() < 1e-15);
    }
}
