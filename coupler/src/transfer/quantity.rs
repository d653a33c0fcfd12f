//! What a grain or a node has: a number, or a vector.

use std::ops::{AddAssign, DivAssign, Mul};

use space::{Vector, vector};

/// Something that can be spread over nodes and gathered from them, component by component.
pub trait Quantity: Copy + AddAssign + DivAssign<f64> + Mul<f64, Output = Self> {
    /// Numbers in it.
    const COMPONENTS: usize;
    /// One of them.
    fn component(&self, index: usize) -> f64;
    /// From its components.
    fn from_components(component: impl FnMut(usize) -> f64) -> Self;
}

impl Quantity for f64 {
    const COMPONENTS: usize = 1;
    #[inline(always)]
    fn component(&self, _: usize) -> f64 {
        *self
    }
    #[inline(always)]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> f64 {
        component(0)
    }
}

impl<const D: usize> Quantity for Vector<D> {
    const COMPONENTS: usize = D;
    #[inline(always)]
    fn component(&self, index: usize) -> f64 {
        self[index]
    }
    #[inline(always)]
    fn from_components(component: impl FnMut(usize) -> f64) -> Vector<D> {
        vector::from_fn(component)
    }
}

/// √(Σ_α ℓ_α |x_α|²) of a nodal field.
pub fn nodal_norm<Q: Quantity>(mass: &[f64], field: &[Q]) -> f64 {
    let mut sum = 0.0;
    for (mass, value) in mass.iter().zip(field) {
        for index in 0..Q::COMPONENTS {
            sum += mass * value.component(index) * value.component(index);
        }
    }
    sum.sqrt()
}
