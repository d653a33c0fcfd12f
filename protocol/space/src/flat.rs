//! Vectors as the flat numbers (x₀, y₀, x₁, y₁, …) that cross a process boundary, without a copy.

use crate::vector::Vector;

/// Flat numbers as vectors; none when their count is no multiple of `D`.
#[inline]
pub fn vectors<const D: usize>(numbers: &[f64]) -> Option<&[Vector<D>]> {
    bytemuck::try_cast_slice(numbers).ok()
}

/// Flat numbers as vectors to write to; none when their count is no multiple of `D`.
#[inline]
pub fn vectors_mut<const D: usize>(numbers: &mut [f64]) -> Option<&mut [Vector<D>]> {
    bytemuck::try_cast_slice_mut(numbers).ok()
}

/// Vectors as flat numbers.
#[inline]
pub fn numbers<const D: usize>(vectors: &[Vector<D>]) -> &[f64] {
    bytemuck::cast_slice(vectors)
}

/// Vectors as flat numbers to write to.
#[inline]
pub fn numbers_mut<const D: usize>(vectors: &mut [Vector<D>]) -> &mut [f64] {
    bytemuck::cast_slice_mut(vectors)
}

/// One vector from its numbers; none when there are not `D` of them.
#[inline]
pub fn vector<const D: usize>(numbers: &[f64]) -> Option<Vector<D>> {
    Some(Vector::from(<[f64; D]>::try_from(numbers).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_vectors_are_the_same_bytes() {
        let mut flat = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let space: &[Vector<3>] = vectors(&flat).unwrap();
        assert_eq!(space[1], Vector::from([4.0, 5.0, 6.0]));
        assert_eq!(numbers(space), flat);
        vectors_mut::<2>(&mut flat).unwrap()[2][1] = 7.0;
        assert_eq!(flat[5], 7.0);
    }

    #[test]
    fn a_count_that_does_not_fit_is_refused() {
        assert!(vectors::<3>(&[0.0; 4]).is_none());
        assert!(vector::<2>(&[0.0; 3]).is_none());
        assert!(vectors::<2>(&[]).unwrap().is_empty());
    }
}
