//! A box of cells from which a mesh is refined.
//!
//! ```text
//!   cell → D! simplices (Kuhn): corner, then along the axes in one of D! orders
//!   simplex (x0 … xD) of generation g, k = D − (g mod D)  →  z = (x0 + xk)/2,
//!       (x0 … xk−1, z, xk+1 … xD)  and  (x1 … xk, z, xk+1 … xD)                                       (B3)
//! ```
//!
//! (B3) is Maubach, SIAM J. Sci. Comput. 16 (1995): of all generations, simplices have D shapes.

use space::{Dim, Dimension, Vector, dimension::factorial, simplex, vector};

use super::bisection::{Forest, INSIDE, LEVELS, Part, Vertex};
use crate::error::FluidError;

/// Cells along an axis at most: whole coordinates fit 32 bits.
pub const CELLS_MAX: usize = 1 << (31 - LEVELS);
/// Names of the sides, in the order of their numbers.
const SIDES: [&str; 6] = ["left", "right", "bottom", "top", "back", "front"];

/// Whole coordinates: a cell is 2^[`LEVELS`] long along each axis.
type Point<const D: usize> = [u32; D];

/// A box of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Root<const D: usize> {
    /// Lower corner \[m\].
    pub lower: Vector<D>,
    /// Upper corner \[m\].
    pub upper: Vector<D>,
    /// Cells along each axis.
    pub cells: [usize; D],
    /// Axes along which opposite sides are joined.
    pub periodic: [bool; D],
}

impl<const D: usize> Root<D> {
    /// Edge of a cube as large as a cell \[m\].
    pub fn size(&self) -> f64 {
        let edges = (0..D).map(|d| (self.upper[d] - self.lower[d]) / self.cells[d] as f64);
        simplex::cube_edge::<D>(edges.product())
    }

    /// Period along each axis \[m\].
    pub fn period(&self) -> space::Period<D> {
        std::array::from_fn(|d| self.periodic[d].then(|| self.upper[d] - self.lower[d]))
    }

    /// Whole coordinate of the upper end of an axis.
    fn end(&self, axis: usize) -> u32 {
        (self.cells[axis] as u32) << LEVELS
    }

    /// One of the D! simplices of a cell; size is that of all.
    fn kuhn<const N: usize>(
        &self,
        corner: Point<D>,
        order: [usize; D],
        home: usize,
        size: f64,
    ) -> Part<Point<D>, N> {
        let mut corners = [corner; N];
        for (k, &axis) in order.iter().enumerate() {
            corners[k + 1] = corners[k];
            corners[k + 1][axis] += 1 << LEVELS;
        }
        let mut sides = [INSIDE; N];
        let (first, last) = (order[0], order[D - 1]);
        if !self.periodic[first] && corners[D][first] == self.end(first) {
            sides[0] = 2 * first as u16 + 1;
        }
        if !self.periodic[last] && corner[last] == 0 {
            sides[D] = 2 * last as u16;
        }
        Part {
            corners,
            sides,
            generation: 0,
            home: home as u32,
            size,
        }
    }
}

/// All orders of the axes.
fn orders<const D: usize>() -> impl Iterator<Item = [usize; D]> {
    (0..factorial(D)).map(|mut code| {
        let mut left: Vec<usize> = (0..D).collect();
        std::array::from_fn(|d| {
            let choices = D - d;
            let chosen = code % choices;
            code /= choices;
            left.remove(chosen)
        })
    })
}

impl<const D: usize, const N: usize> Forest<D, N> for Root<D>
where
    Dim<D>: Dimension<D>,
{
    type Point = Point<D>;
    type Coordinate = u32;

    fn validate(&self) -> Result<(), FluidError> {
        for d in 0..D {
            let (lower, upper, cells) = (self.lower[d], self.upper[d], self.cells[d]);
            if !(lower.is_finite() && upper.is_finite() && upper > lower) {
                let why = format!("box: upper corner {upper} must exceed lower corner {lower}");
                return Err(FluidError::Mesh(why));
            }
            if !(1..=CELLS_MAX).contains(&cells) {
                return Err(FluidError::Mesh(format!(
                    "{cells} cells along an axis; a mesh that is refined begins with 1 to {CELLS_MAX}"
                )));
            }
        }
        Ok(())
    }

    fn simplices(&self) -> impl Iterator<Item = Part<Point<D>, N>> + '_ {
        let cells = 0..self.cells.iter().product();
        let size = self.size();
        cells.flat_map(move |cell: usize| {
            let mut rest = cell;
            let corner: Point<D> = std::array::from_fn(|d| {
                let at = rest % self.cells[d];
                rest /= self.cells[d];
                (at as u32) << LEVELS
            });
            let orders = orders::<D>().enumerate();
            orders.map(move |(k, order)| self.kuhn(corner, order, cell * factorial(D) + k, size))
        })
    }

    #[inline]
    fn vertex(&self, point: &Point<D>) -> Vertex<u32, D> {
        Vertex(std::array::from_fn(|d| {
            let joined = self.periodic[d] && point[d] == self.end(d);
            if joined { 0 } else { point[d] }
        }))
    }

    fn position(&self, point: &Point<D>) -> Vector<D> {
        vector::from_fn(|d| match self.end(d) {
            end if point[d] == end => self.upper[d],
            end => {
                let share = f64::from(point[d]) / f64::from(end);
                self.lower[d] + (self.upper[d] - self.lower[d]) * share
            }
        })
    }

    fn place(&self, vertex: &Vertex<u32, D>) -> Vector<D> {
        <Self as Forest<D, N>>::position(self, &vertex.0)
    }

    #[inline]
    fn middle(&self, a: &Point<D>, b: &Point<D>) -> Option<Point<D>> {
        let even = (0..D).all(|d| (a[d] + b[d]).is_multiple_of(2));
        even.then(|| std::array::from_fn(|d| (a[d] + b[d]) / 2))
    }

    #[inline]
    fn edge(&self, part: &Part<Point<D>, N>) -> (usize, usize) {
        (0, D - part.generation as usize % D)
    }

    /// (B3)
    #[inline]
    fn halves<T: Copy>((_, k): (usize, usize), whole: &[T; N], middle: T) -> [[T; N]; 2] {
        let (mut first, mut second) = (*whole, *whole);
        first[k] = middle;
        second.copy_within(1..=k, 0);
        second[k] = middle;
        [first, second]
    }

    fn boundary_names(&self) -> Vec<String> {
        SIDES[..2 * D].iter().map(ToString::to_string).collect()
    }

    fn period(&self) -> space::Period<D> {
        Root::period(self)
    }

    fn coarser(&self) -> Option<Self> {
        let cells = self.cells.map(|cells| cells.div_ceil(2));
        (cells != self.cells).then(|| Root {
            cells,
            ..self.clone()
        })
    }

    fn home(&self, place: &Vector<D>) -> Option<u32> {
        let within: [f64; D] = std::array::from_fn(|d| {
            (place[d] - self.lower[d]) / (self.upper[d] - self.lower[d]) * self.cells[d] as f64
        });
        let at: [usize; D] = std::array::from_fn(|d| (within[d] as usize).min(self.cells[d] - 1));
        let mut order: [usize; D] = std::array::from_fn(|d| d);
        let share = |d: usize| within[d] - at[d] as f64;
        order.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
        let cell = (0..D).rev().fold(0, |sum, d| sum * self.cells[d] + at[d]);
        let number = orders::<D>().position(|own| own == order);
        number.map(|number| (cell * factorial(D) + number) as u32)
    }
}
