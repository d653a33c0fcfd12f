//! How large cells are to be, for C.

use protocol::scene::{self, Refinement};

/// A place where cells are small: all that is within `radius` of the box from `lower` to `upper`. A ball
/// has its centre in both.
#[repr(C)]
#[derive(Debug)]
pub struct Region {
    /// Lower corner (m), a vector.
    pub lower: *const f64,
    /// Upper corner (m), a vector.
    pub upper: *const f64,
    /// How far it reaches around the box (m).
    pub radius: f64,
    /// Cells in it (m).
    pub size: f64,
}

/// How large cells are to be at x (m): h(x) is the smallest of `largest` and, for each region, of its
/// `size` + `growth` times the distance of x from it, along a period from its nearest image. All numbers are
/// in range.
#[repr(C)]
#[derive(Debug)]
pub struct Sizes {
    /// Dimension of the space: a vector has as many numbers.
    pub dimension: u32,
    /// Number of regions, at most 512.
    pub region_count: u32,
    /// Regions.
    pub regions: *const Region,
    /// By how much cells grow away from a region, in metres a metre.
    pub growth: f64,
    /// Largest cells (m); INFINITY: those that the scene's mesh has.
    pub largest: f64,
}

/// Sizes for C, with what their pointers point to.
pub(crate) struct SizesView {
    pub(crate) sizes: Sizes,
    _regions: Vec<Region>,
}

impl SizesView {
    /// Valid as long as both it and `sizes` are.
    pub(crate) fn of(sizes: &Refinement, dimension: usize) -> SizesView {
        let regions: Vec<Region> = sizes.regions.iter().map(region).collect();
        SizesView {
            sizes: Sizes {
                dimension: dimension as u32,
                region_count: regions.len() as u32,
                regions: regions.as_ptr(),
                growth: sizes.growth,
                largest: sizes.largest.unwrap_or(f64::INFINITY),
            },
            _regions: regions,
        }
    }
}

fn region(region: &scene::Region) -> Region {
    let (lower, upper, radius) = match region {
        scene::Region::Ball { centre, radius, .. } => (centre, centre, *radius),
        scene::Region::Box { lower, upper, .. } => (lower, upper, 0.0),
    };
    Region {
        lower: lower.as_ptr(),
        upper: upper.as_ptr(),
        radius,
        size: region.size(),
    }
}
