//! Which sides of simplices are the boundary: those of single simplices, each with one name.

use space::simplex::facet_corners;
use space::{Dim, Dimension, hypot};

use super::facet::BoundaryFacet;
use super::simplices::Mesh;
use crate::error::{FluidError, places};

/// A side of a simplex: its nodes ascending, the simplex, the corner opposite to it.
type Side<const D: usize> = ([usize; D], usize, usize);

impl<const D: usize, const N: usize> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// The facet of simplex `t` opposite to its corner `k`, as one of `boundary`.
    pub(crate) fn facet(&self, t: usize, k: usize, boundary: usize) -> BoundaryFacet<D> {
        let corner = facet_corners::<D>(k);
        let normal = Dim::<D>::facet_normal(&corner.map(|c| self.corners[t][c]));
        let length = hypot(&normal);
        BoundaryFacet {
            corner,
            node: corner.map(|c| self.simplices[t][c]),
            simplex: t,
            boundary,
            normal: normal.map(|component| component / length),
            size: length / space::dimension::factorial(D - 1) as f64,
        }
    }

    /// Names for the sides of single simplices, in the order of the simplices.
    pub(super) fn match_facets(
        &self,
        named: &[([usize; D], usize)],
    ) -> Result<Vec<BoundaryFacet<D>>, FluidError> {
        let names = self.sorted_names(named)?;
        let sides = self.sorted_sides();
        let mut facets = Vec::new();
        for group in sides.chunk_by(|p, q| p.0 == q.0) {
            let (key, t, k) = group[0];
            let name = names.binary_search_by(|entry| entry.0.cmp(&key));
            match (group.len(), name) {
                (1, Ok(at)) => facets.push(self.facet(t, k, names[at].1)),
                (1, Err(_)) => return Err(self.unnamed(&key)),
                (2, Err(_)) => {}
                (2, Ok(at)) => return Err(self.inside(&key, names[at].1)),
                (count, _) => return Err(self.crowded(&key, count)),
            }
        }
        if facets.len() != names.len() {
            return Err(self.stray(&names, &sides));
        }
        facets.sort_unstable_by_key(|facet| (facet.simplex, facet.corner[0]));
        Ok(facets)
    }

    /// The named facets, nodes ascending, each once.
    fn sorted_names(
        &self,
        named: &[([usize; D], usize)],
    ) -> Result<Vec<([usize; D], usize)>, FluidError> {
        let mut names: Vec<_> = named.iter().map(|&(f, name)| (ordered(f), name)).collect();
        names.sort_unstable();
        names.dedup();
        match names.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            None => Ok(names),
            Some(pair) => Err(FluidError::FacetInTwoBoundaries {
                facet: Dim::<D>::FACET,
                corners: self.ends(&pair[0].0),
                first: self.boundary_names[pair[0].1].clone(),
                second: self.boundary_names[pair[1].1].clone(),
            }),
        }
    }

    fn sorted_sides(&self) -> Vec<Side<D>> {
        let mut sides = Vec::with_capacity(N * self.simplices.len());
        for (t, nodes) in self.simplices.iter().enumerate() {
            for k in 0..N {
                let facet = facet_corners::<D>(k).map(|corner| nodes[corner]);
                sides.push((ordered(facet), t, k));
            }
        }
        sides.sort_unstable();
        sides
    }

    /// The corners of a facet, for messages.
    fn ends(&self, nodes: &[usize; D]) -> String {
        places(&nodes.map(|node| self.position[node]), " to ")
    }

    fn unnamed(&self, nodes: &[usize; D]) -> FluidError {
        FluidError::UnnamedFacet {
            facet: Dim::<D>::FACET,
            corners: self.ends(nodes),
            names: self.boundary_names.clone(),
        }
    }

    fn inside(&self, nodes: &[usize; D], boundary: usize) -> FluidError {
        let (facet, simplex) = (Dim::<D>::FACET, Dim::<D>::SIMPLEX);
        let (ends, name) = (self.ends(nodes), &self.boundary_names[boundary]);
        FluidError::Mesh(format!(
            "{facet} {ends} of boundary {name:?} lies inside the domain; \
             only {facet}s of a single {simplex} can carry a condition"
        ))
    }

    fn crowded(&self, nodes: &[usize; D], count: usize) -> FluidError {
        let (facet, simplex) = (Dim::<D>::FACET, Dim::<D>::SIMPLEX);
        let ends = self.ends(nodes);
        FluidError::Mesh(format!(
            "{facet} {ends} belongs to {count} {simplex}s; at most 2"
        ))
    }

    /// A name whose facet is there in no simplex.
    fn stray(&self, names: &[([usize; D], usize)], sides: &[Side<D>]) -> FluidError {
        let there = |nodes: &[usize; D]| sides.binary_search_by(|side| side.0.cmp(nodes)).is_ok();
        let stray = names.iter().find(|(nodes, _)| !there(nodes));
        let (nodes, boundary) = stray.unwrap_or(&names[0]);
        let (facet, simplex) = (Dim::<D>::FACET, Dim::<D>::SIMPLEX);
        let (ends, name) = (self.ends(nodes), &self.boundary_names[*boundary]);
        FluidError::Mesh(format!(
            "{facet} {ends} of boundary {name:?} is no side of a {simplex}"
        ))
    }
}

fn ordered<const D: usize>(mut nodes: [usize; D]) -> [usize; D] {
    nodes.sort_unstable();
    nodes
}
