//! A box of bins, numbered along the first axis first.

use space::{Vector, dimension::factorial, simplex, vector};

/// Bins of one size that fill a box.
#[derive(Debug)]
pub struct Bins<const D: usize> {
    lower: Vector<D>,
    size: Vector<D>,
    counts: [usize; D],
}

impl<const D: usize> Bins<D> {
    /// Bins over the box from `lower` to `upper`, nearly cubes, each about as large as one of
    /// `simplex_count` simplices; along each axis at most as many as there are simplices.
    pub fn new(lower: Vector<D>, upper: Vector<D>, simplex_count: usize) -> Bins<D> {
        let extent = upper - lower;
        let volume: f64 = extent.iter().product();
        let cubes = simplex_count.max(1) as f64 / factorial(D) as f64;
        let edge = simplex::cube_edge::<D>(volume / cubes);
        let most = simplex_count.max(1);
        let along = |axis: usize| (extent[axis] / edge).ceil() as usize;
        // in a box like a needle cubes as wide as it is are more than any memory holds
        let counts = std::array::from_fn(|axis| along(axis).clamp(1, most));
        Bins {
            lower,
            size: vector::from_fn(|axis| extent[axis] / counts[axis] as f64),
            counts,
        }
    }

    /// Lower and upper corner of a bin \[m\].
    pub fn bounds(&self, bin: &[usize; D]) -> [Vector<D>; 2] {
        let corner = |shift: usize| {
            let along = |axis: usize| self.size[axis] * (bin[axis] + shift) as f64;
            self.lower + vector::from_fn(along)
        };
        [corner(0), corner(1)]
    }

    /// Lower corner of the box \[m\].
    pub fn lower(&self) -> &Vector<D> {
        &self.lower
    }

    /// Number of bins.
    pub fn count(&self) -> usize {
        self.counts.iter().product()
    }

    /// The bin of a point, or the nearest one.
    pub fn of(&self, point: &Vector<D>) -> [usize; D] {
        std::array::from_fn(|axis| {
            let bin = (point[axis] - self.lower[axis]) / self.size[axis];
            (bin.max(0.0) as usize).min(self.counts[axis] - 1)
        })
    }

    /// Numbers of the bins from `first` to `last`, both included.
    pub fn range(&self, first: [usize; D], last: [usize; D]) -> impl Iterator<Item = usize> + '_ {
        boxes(first, last).map(move |bin| self.number(bin))
    }

    /// All bins, by their numbers.
    pub fn all(&self) -> impl Iterator<Item = [usize; D]> + use<D> {
        boxes([0; D], self.counts.map(|count| count - 1))
    }

    /// Numbers of the bins at this distance (in bins) from one.
    pub fn ring(&self, centre: [usize; D], distance: usize) -> impl Iterator<Item = usize> + '_ {
        let first = centre.map(|bin| bin.saturating_sub(distance));
        let last = std::array::from_fn(|k| (centre[k] + distance).min(self.counts[k] - 1));
        boxes(first, last)
            .filter(move |bin| {
                let apart = bin.iter().zip(&centre).map(|(a, b)| a.abs_diff(*b));
                apart.max() == Some(distance)
            })
            .map(move |bin| self.number(bin))
    }

    /// Number of a bin.
    pub fn number(&self, bin: [usize; D]) -> usize {
        let along = (0..D).rev();
        along.fold(0, |number, axis| number * self.counts[axis] + bin[axis])
    }
}

/// Bins, each with what reaches into it.
#[derive(Debug)]
pub struct Lists<const D: usize> {
    /// The bins.
    pub bins: Bins<D>,
    /// Members of bin b: `members[start[b]..start[b + 1]]`.
    start: Vec<usize>,
    members: Vec<u32>,
}

impl<const D: usize> Lists<D> {
    /// Sort members by their boxes, from the lower to the upper corner \[m\].
    pub fn new(bins: Bins<D>, boxes: &[(Vector<D>, Vector<D>)], members: &[u32]) -> Lists<D> {
        let mut sorted = vec![Vec::new(); bins.count()];
        for &member in members {
            let (low, high) = &boxes[member as usize];
            for bin in bins.range(bins.of(low), bins.of(high)) {
                sorted[bin].push(member);
            }
        }
        let mut start = vec![0];
        start.extend(sorted.iter().scan(0, |count, bin| {
            *count += bin.len();
            Some(*count)
        }));
        let members = sorted.concat();
        Lists {
            bins,
            start,
            members,
        }
    }

    /// What reaches into a bin, in the order it was given.
    pub fn members(&self, bin: usize) -> &[u32] {
        &self.members[self.start[bin]..self.start[bin + 1]]
    }
}

/// All whole coordinates from `first` to `last`, the first axis fastest.
fn boxes<const D: usize>(first: [usize; D], last: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    let next = move |at: &[usize; D]| {
        let mut at = *at;
        for axis in 0..D {
            if at[axis] < last[axis] {
                at[axis] += 1;
                return Some(at);
            }
            at[axis] = first[axis];
        }
        None
    };
    std::iter::successors(Some(first), next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bins of a plane box of this height and width 1, with 100 simplices.
    fn bins(height: f64) -> Bins<2> {
        Bins::new(Vector::zeros(), Vector::from([1.0, height]), 100)
    }

    #[test]
    fn a_box_like_a_needle_has_no_more_bins_than_simplices() {
        for height in [1.0, 10.0, 1e6, 1e15] {
            let bins = bins(height);
            println!("height {height:e}: {} bins", bins.count());
            assert!(bins.count() <= 100);
            let last = bins.of(&Vector::from([1.0, height]));
            assert_eq!(bins.range(last, last).next(), Some(bins.count() - 1));
        }
        assert_eq!(bins(10.0).counts, [3, 23]);
    }
}
