//! Numbers or vectors that add, scale and have a length.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};

use crate::vector::{Vector, dot, from_fn, norm};

/// What is a number in the plane and a vector in space: a spin, a tangential impulse.
pub trait Linear:
    Copy
    + Default
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// How many numbers it is.
    const COMPONENTS: usize;

    /// The one whose component k is `component(k)`.
    fn from_components(component: impl FnMut(usize) -> f64) -> Self;

    /// Component k.
    fn component(&self, k: usize) -> f64;

    /// Product with another one, summed in the order of the components.
    fn dot(self, other: Self) -> f64;

    /// Its length: the absolute value of a number.
    fn length(self) -> f64;
}

impl Linear for f64 {
    const COMPONENTS: usize = 1;

    #[inline(always)]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> f64 {
        component(0)
    }

    #[inline(always)]
    fn component(&self, _: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn dot(self, other: f64) -> f64 {
        self * other
    }

    #[inline(always)]
    fn length(self) -> f64 {
        self.abs()
    }
}

impl Linear for Vector<3> {
    const COMPONENTS: usize = 3;

    #[inline(always)]
    fn from_components(component: impl FnMut(usize) -> f64) -> Vector<3> {
        from_fn(component)
    }

    #[inline(always)]
    fn component(&self, k: usize) -> f64 {
        self[k]
    }

    #[inline(always)]
    fn dot(self, other: Vector<3>) -> f64 {
        dot(&self, &other)
    }

    #[inline(always)]
    fn length(self) -> f64 {
        norm(&self)
    }
}
