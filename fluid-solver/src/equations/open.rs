//! Momentum at a facet of an open boundary.
//!
//! ```text
//!   − ∮ μφ (∇v)ᵀn·w                      in the symmetric viscous form                     (O1)
//!   + ∮ ½ ρφ (a·n)₋ v·w,   (x)₋ = max(0, −x)                                                (O2)
//! ```
//!
//! Fluid that enters with velocity v brings the energy ½ρφ (a·n)₋ |v|² a time and an area. Without (O2) it
//! comes from nowhere, and what flows in by one open side and out by another grows without bound. With it
//! the fluid comes from rest: the given pressure is that of the resting fluid outside, p + ½ρ|v|² where it
//! enters (Bruneau and Fabrie 1994; Bazilevs et al. 2009). Where all flows out nothing is added.

use space::simplex::combine;
use space::{Dim, Dimension, Vector, dot, quadrature};

use super::element::Element;
use super::momentum::Matrix;
use super::point::Point;
use crate::mesh::facet::BoundaryFacet;

/// − ∮ μφ (∇v)ᵀn·w (O1): the natural condition becomes μφ ∂v/∂n = 0, which a
/// fully developed flow satisfies, in place of 2μφ D(v) n = 0, which bends it.
pub fn add_traction<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    facet: &BoundaryFacet<D>,
    matrix: &mut Matrix<N>,
) where
    Dim<D>: Dimension<D>,
{
    for (on_facet, weight) in quadrature::points::<D>() {
        let shape = facet.shape(&on_facet);
        let at = element.point(shape, weight * facet.size);
        for i in facet.corner {
            for j in 0..N {
                for d in 0..D {
                    let traction = at.viscosity * at.test_gradient[j][d];
                    for f in 0..D {
                        matrix[i][j][d][f] -= at.weight * at.test[i] * traction * facet.normal[f];
                    }
                }
            }
        }
    }
}

/// Does the convecting velocity enter somewhere on the facet?
pub fn flows_in<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    facet: &BoundaryFacet<D>,
) -> bool
where
    Dim<D>: Dimension<D>,
{
    let mut points = quadrature::points::<D>();
    points.any(|(on_facet, _)| entering(element, facet, &facet.shape(&on_facet)) > 0.0)
}

/// (O2).
pub fn add_inflow<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    facet: &BoundaryFacet<D>,
    matrix: &mut Matrix<N>,
) where
    Dim<D>: Dimension<D>,
{
    for (at, brake) in brakes(element, facet) {
        for i in facet.corner {
            for j in facet.corner {
                let entry = at.weight * brake * at.test[i] * at.test[j];
                (0..D).for_each(|d| matrix[i][j][d][d] += entry);
            }
        }
    }
}

/// The power that (O2) takes from a flow with these superficial velocities \[W/m\].
pub fn inflow_power<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    facet: &BoundaryFacet<D>,
    u: &[Vector<D>; N],
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let power = |(at, brake): (Point<D, N>, f64)| {
        let v = combine(&at.test, u);
        at.weight * brake * dot(&v, &v)
    };
    brakes(element, facet).map(power).sum()
}

/// The quadrature points of a facet, each with ½ ρφ (a·n)₋ \[kg/(m² s)\].
fn brakes<'a, const D: usize, const N: usize>(
    element: &'a Element<'_, D, N>,
    facet: &'a BoundaryFacet<D>,
) -> impl Iterator<Item = (Point<D, N>, f64)> + 'a
where
    Dim<D>: Dimension<D>,
{
    quadrature::points::<D>().map(|(on_facet, weight)| {
        let shape = facet.shape(&on_facet);
        let at = element.point(shape, weight * facet.size);
        let brake = 0.5 * at.inertia * entering(element, facet, &shape);
        (at, brake)
    })
}

/// (a·n)₋ \[m/s\]
fn entering<const D: usize, const N: usize>(
    element: &Element<'_, D, N>,
    facet: &BoundaryFacet<D>,
    shape: &[f64; N],
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let a = element.carried(shape, |carrier| carrier.convects);
    (-dot(&a, &facet.normal)).max(0.0)
}
