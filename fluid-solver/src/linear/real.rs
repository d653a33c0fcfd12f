//! The numbers of a factor: of single or of double precision.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// Pivots of a panel.
pub const PANEL: usize = 16;
/// A block of as many rows and columns, by columns.
pub type Panel<T> = [[T; PANEL]; PANEL];

/// A number of single or of double precision.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 1
    const ONE: Self;
    /// The smallest pivot that is trusted, of a matrix with a unit diagonal.
    const PIVOT_MIN: f64;
    /// 1 below the diagonal, 0 elsewhere: a product with it is a choice without a branch.
    const BELOW: Panel<Self>;
    /// 1 above the diagonal, 0 elsewhere.
    const ABOVE: Panel<Self>;

    /// 0 instead of what is smaller than the root of the least number with all its digits: products of what is left
    /// have them, and processors take a hundred times longer where they have not.
    fn flushed(self) -> Self;
    /// The nearest to a number.
    fn of(value: f64) -> Self;
    /// As a number of double precision.
    fn to_f64(self) -> f64;
}

/// 1 where the row is larger than the column, or the column larger than the row.
macro_rules! mask {
    ($larger:expr, $smaller:expr) => {{
        let mut mask = [[0.0; PANEL]; PANEL];
        let mut k = 0;
        while k < PANEL * PANEL {
            let place = [k % PANEL, k / PANEL];
            if place[$larger] > place[$smaller] {
                mask[k / PANEL][k % PANEL] = 1.0;
            }
            k += 1;
        }
        mask
    }};
}

macro_rules! real {
    ($number:ty, $pivot:expr, $tiny:expr) => {
        impl Real for $number {
            const ONE: $number = 1.0;
            const PIVOT_MIN: f64 = $pivot;
            const BELOW: Panel<$number> = mask!(0, 1);
            const ABOVE: Panel<$number> = mask!(1, 0);

            #[inline(always)]
            fn flushed(self) -> $number {
                if self.abs() <= $tiny { 0.0 } else { self }
            }

            #[inline(always)]
            fn of(value: f64) -> $number {
                value as $number
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    };
}

real!(f32, 1e-6, 1.1e-19);
real!(f64, 1e-12, 1.5e-154);
