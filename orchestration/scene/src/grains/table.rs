//! The grains of a scene, an array a property.

use std::fmt::Write;

/// The grains of a scene, a line per array.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GrainTable {
    /// Centres \[m\].
    pub position: Vec<[f64; 2]>,
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Densities \[kg/m³\].
    pub density: Vec<f64>,
    /// Velocities \[m/s\].
    pub velocity: Vec<[f64; 2]>,
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

    /// Area of all disks \[m²\].
    pub fn area(&self) -> f64 {
        self.radius
            .iter()
            .map(|radius| std::f64::consts::PI * radius * radius)
            .sum()
    }

    /// The table as CSV: x,y,radius,density,vx,vy,fixed; numbers read back to the same bits.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("x,y,radius,density,vx,vy,fixed\n");
        for index in 0..self.len() {
            let ([x, y], [vx, vy]) = (self.position[index], self.velocity[index]);
            let (radius, density) = (self.radius[index], self.density[index]);
            let fixed = u8::from(self.fixed[index]);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{x:e},{y:e},{radius:e},{density:e},{vx:e},{vy:e},{fixed}"
            );
        }
        text
    }

    pub(super) fn push(&mut self, grain: Grain) {
        self.position.push(grain.position);
        self.radius.push(grain.radius);
        self.density.push(grain.density);
        self.velocity.push(grain.velocity);
        self.fixed.push(grain.fixed);
    }
}

/// One grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grain {
    pub position: [f64; 2],
    pub radius: f64,
    pub density: f64,
    pub velocity: [f64; 2],
    pub fixed: bool,
}
