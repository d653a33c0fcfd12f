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

/// Which periodic image: one number for a shift by −1, 0 or 1 period along each axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Image(pub u8);

impl Image {
    /// The number of a shift; the first axis weighs most, so that of no shift is 4 in the plane and
    /// 13 in space.
    #[inline]
    pub fn of<const D: usize>(shift: [i8; D]) -> Image {
        let code = shift.iter().fold(0, |code, &k| 3 * code + (k + 1) as u8);
        Image(code)
    }
}

/// Call `visit` for every shift by −1, 0 or 1 along the periodic axes, the last axis fastest.
#[inline]
pub fn each_image<const D: usize>(period: &Period<D>, mut visit: impl FnMut([i8; D])) {
    let most = period.map(|length| i8::from(length.is_some()));
    let mut shift = most.map(|most| -most);
    loop {
        visit(shift);
        let Some(axis) = (0..D).rev().find(|&axis| shift[axis] < most[axis]) else {
            return;
        };
        shift[axis] += 1;
        for later in axis + 1..D {
            shift[later] = -most[later];
        }
    }
}

/// `apart`, shifted by whole periods.
#[inline]
pub fn shifted<const D: usize>(apart: &Vector<D>, shift: [i8; D], period: &Period<D>) -> Vector<D> {
    from_fn(|axis| apart[axis] + f64::from(shift[axis]) * period[axis].unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_image_is_visited_once_in_the_order_of_its_number() {
        let mut plane = Vec::new();
        each_image(&[Some(1.0), Some(1.0)], |shift| {
            plane.push(Image::of(shift))
        });
        assert_eq!(plane, (0..9).map(Image).collect::<Vec<_>>());
        let mut space = Vec::new();
        each_image(&[Some(1.0), None, Some(1.0)], |shift| space.push(shift));
        assert_eq!(space.len(), 9);
        assert!(space.iter().all(|shift| shift[1] == 0));
        assert!(space.is_sorted());
        let mut alone = 0;
        each_image(&[None; 3], |shift| {
            assert_eq!(Image::of(shift), Image(13));
            alone += 1;
        });
        assert_eq!(alone, 1);
    }

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
