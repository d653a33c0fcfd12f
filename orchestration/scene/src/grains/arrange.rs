//! Arrangements of clouds and boxes: at random without overlap, in the plane as a sunflower.

use std::f64::consts::PI;

use space::Dim;

use super::neighbours::Neighbours;
use super::random::Random;
use crate::dimensions::Scenic;

/// Where a random population goes.
pub enum Region<const D: usize> {
    /// Centres lie within the radius.
    Ball {
        /// Centre \[m\].
        centre: [f64; D],
        /// Radius \[m\].
        radius: f64,
    },
    /// Whole grains lie within, except across sides where the box wraps.
    Box {
        /// Lower corner \[m\].
        lower: [f64; D],
        /// Upper corner \[m\].
        upper: [f64; D],
        /// Does it span a whole period along each axis?
        wraps: [bool; D],
    },
}

impl<const D: usize> Region<D>
where
    Dim<D>: Scenic<D>,
{
    fn sample(&self, grain_radius: f64, random: &mut Random) -> [f64; D] {
        match self {
            Region::Ball { centre, radius } => Dim::<D>::in_ball(centre, *radius, || random.unit()),
            Region::Box {
                lower,
                upper,
                wraps,
            } => std::array::from_fn(|axis| {
                let inset = if wraps[axis] { 0.0 } else { grain_radius };
                random.between(lower[axis] + inset, upper[axis] - inset)
            }),
        }
    }
}

/// Tries for one grain before giving up.
const TRIES_MAX: usize = 200_000;

/// Random sequential placing; the error is how many were placed.
pub fn at_random<const D: usize>(
    region: &Region<D>,
    radii: &[f64],
    fixed: bool,
    random: &mut Random,
    others: &Neighbours<D>,
) -> Result<Vec<([f64; D], f64)>, usize>
where
    Dim<D>: Scenic<D>,
{
    let mut placed: Vec<([f64; D], f64)> = Vec::with_capacity(radii.len());
    let mut own = others.like();
    for &radius in radii {
        let spot = (0..TRIES_MAX)
            .map(|_| region.sample(radius, random))
            .find(|&position| {
                own.overlap(&position, radius, false, 0.0).is_none()
                    && others.overlap(&position, radius, fixed, 0.0).is_none()
            });
        let Some(position) = spot else {
            return Err(placed.len());
        };
        own.insert(&position, radius, false);
        placed.push((position, radius));
    }
    Ok(placed)
}

/// Points on a spiral that turns by the golden angle: every grain has the same share of area.
///
/// ```text
///   ρ_k = R √((k + ½)/N),   θ_k = k π (3 − √5)          (Vogel 1979)
/// ```
pub fn sunflower<const D: usize>(
    centre: &[f64; D],
    cloud_radius: f64,
    radii: &[f64],
) -> Vec<([f64; D], f64)> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let count = radii.len() as f64;
    radii
        .iter()
        .enumerate()
        .map(|(index, &radius)| {
            // A lonely grain has no neighbours to share the area with: it sits in the centre.
            let share = if radii.len() == 1 {
                0.0
            } else {
                (index as f64 + 0.5) / count
            };
            let distance = cloud_radius * share.sqrt();
            let angle = index as f64 * golden_angle;
            let mut place = *centre;
            place[0] += distance * angle.cos();
            place[1] += distance * angle.sin();
            (place, radius)
        })
        .collect()
}
