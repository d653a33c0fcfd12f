//! The grains of a scene, an array a property.

use std::fmt::Write;

use space::Dim;

use crate::dimensions::{AXES, Scenic};

/// The grains of a scene, a line per array.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GrainTable {
    /// Numbers of a vector; 0 without grains.
    pub dimension: usize,
    /// Centres \[m\], flat.
    pub position: Vec<f64>,
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Densities \[kg/m³\].
    pub density: Vec<f64>,
    /// Velocities \[m/s\], flat.
    pub velocity: Vec<f64>,
    /// Grains that never move.
    pub fixed: Vec<bool>,
}

impl GrainTable {
    /// Number of grains.
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }

    /// Is there a grain, and does none move?
    pub fn all_fixed(&self) -> bool {
        !self.is_empty() && self.fixed.iter().all(|&fixed| fixed)
    }

    /// Centre of a grain \[m\].
    pub fn place(&self, grain: usize) -> &[f64] {
        &self.position[self.dimension * grain..][..self.dimension]
    }

    /// Content of all grains: the area of disks \[m²\], in space the volume of spheres \[m³\].
    pub fn content(&self) -> f64 {
        (0..self.len()).map(|grain| self.content_of(grain)).sum()
    }

    /// That of a grain.
    pub fn content_of(&self, grain: usize) -> f64 {
        let radius = self.radius[grain];
        match self.dimension {
            3 => <Dim<3>>::grain(radius),
            _ => <Dim<2>>::grain(radius),
        }
    }

    /// The table as CSV: x,y,radius,density,vx,vy,fixed, in space with z and vz; numbers read back to the same
    /// bits.
    pub fn to_csv(&self) -> String {
        let axes = &AXES[..self.dimension];
        let mut text = format!(
            "{},radius,density,v{},fixed\n",
            axes.join(","),
            axes.join(",v")
        );
        let numbers = |text: &mut String, numbers: &[f64]| {
            // Writing to a string cannot fail.
            numbers.iter().for_each(|x| _ = write!(text, "{x:e},"));
        };
        for index in 0..self.len() {
            numbers(&mut text, self.place(index));
            numbers(&mut text, &[self.radius[index], self.density[index]]);
            numbers(
                &mut text,
                &self.velocity[self.dimension * index..][..self.dimension],
            );
            let _ = writeln!(text, "{}", u8::from(self.fixed[index]));
        }
        text
    }

    pub(super) fn push<const D: usize>(&mut self, grain: Grain<D>) {
        self.dimension = D;
        self.position.extend(grain.position);
        self.radius.push(grain.radius);
        self.density.push(grain.density);
        self.velocity.extend(grain.velocity);
        self.fixed.push(grain.fixed);
    }
}

/// One grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grain<const D: usize> {
    pub position: [f64; D],
    pub radius: f64,
    pub density: f64,
    pub velocity: [f64; D],
    pub fixed: bool,
}
