//! The nodes of each grain and their weights: where it is on the mesh.

use space::{Dim, Dimension, Vector};

use crate::transfer::bell::Bell;
use crate::transfer::locate::Stencil;
use crate::transfer::path::{Ground, Spot};

/// Where a set of grains is on the mesh. The weights of a grain are ≥ 0 and sum to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// First and one past the last entry of every grain.
    span: Vec<[usize; 2]>,
    nodes: Vec<u32>,
    weights: Vec<f64>,
}

impl Placement {
    /// Of this many grains, which are all still to be set; there is room for this many nodes in all.
    pub fn with_capacity(grains: usize, nodes: usize) -> Placement {
        Placement {
            span: vec![[0, 0]; grains],
            nodes: Vec::with_capacity(nodes),
            weights: Vec::with_capacity(nodes),
        }
    }

    /// Number of grains.
    pub fn grain_count(&self) -> usize {
        self.span.len()
    }

    /// Nodes of a grain and their weights.
    #[inline]
    pub fn entries(&self, grain: usize) -> (&[u32], &[f64]) {
        let [begin, end] = self.span[grain];
        (&self.nodes[begin..end], &self.weights[begin..end])
    }

    /// The same of a grain that is the point of one simplex: their number is known.
    #[inline]
    pub fn corners<const N: usize>(&self, grain: usize) -> Option<(&[u32; N], &[f64; N])> {
        let (nodes, weights) = self.entries(grain);
        Some((nodes.try_into().ok()?, weights.try_into().ok()?))
    }

    /// Where a grain is; grains come in any order, each once.
    pub fn set(&mut self, grain: usize, nodes: &[u32], weights: impl IntoIterator<Item = f64>) {
        let begin = self.nodes.len();
        self.nodes.extend_from_slice(nodes);
        self.weights.extend(weights);
        debug_assert_eq!(self.nodes.len(), self.weights.len());
        self.span[grain] = [begin, self.nodes.len()];
    }
}

/// Gathers the weights that the points of one grain give to nodes.
#[derive(Debug)]
pub struct Gather {
    /// Of every node of the mesh; 0 between grains.
    weight: Vec<f64>,
    touched: Vec<u32>,
}

impl Gather {
    /// For a mesh with this many nodes.
    pub fn new(node_count: usize) -> Gather {
        Gather {
            weight: vec![0.0; node_count],
            touched: Vec::new(),
        }
    }

    /// Spread a grain, by its number, whose centre is there over points, told in spacings of its bell. Each point is sought from the one before it, or from the
    /// centre where that is nearer or a wall came between; one that is never reached (`path`) leaves its
    /// weight to the others.
    pub fn spread<const D: usize, const N: usize>(
        &mut self,
        grain: usize,
        (bell, points): (Bell, &[(Vector<D>, f64)]),
        centre: &Stencil<N>,
        ground: Ground<'_, D, N>,
        placement: &mut Placement,
    ) where
        Dim<D>: Dimension<D>,
    {
        let centre = Spot {
            simplex: centre.simplex,
            point: ground.locator.point(centre),
        };
        let mut last: Option<(Spot<D>, Vector<D>)> = None;
        for (point, weight) in points {
            let offset = point * bell.spacing();
            let near = last.and_then(|(spot, at)| {
                let by = offset - at;
                let nearer = by.norm_squared() < offset.norm_squared();
                let end = nearer.then(|| ground.go(spot, &by)).flatten();
                end.filter(|end| !end.thrown_back)
            });
            let Some(end) = near.or_else(|| ground.go(centre, &offset)) else {
                continue;
            };
            last = (!end.thrown_back).then_some((end.spot, offset));
            self.add(
                ground.locator.nodes(end.spot.simplex),
                &end.weights,
                *weight,
            );
        }
        let gathered = |&node: &u32| self.weight[node as usize];
        let total: f64 = self.touched.iter().map(gathered).sum();
        let shares = self.touched.iter().map(|&node| {
            let gathered = std::mem::take(&mut self.weight[node as usize]);
            gathered / total
        });
        placement.set(grain, &self.touched, shares);
        self.touched.clear();
    }

    fn add<const N: usize>(&mut self, nodes: &[u32; N], shape: &[f64; N], weight: f64) {
        let corners = nodes.iter().zip(shape);
        for (&node, &shape) in corners.filter(|&(_, &shape)| shape > 0.0) {
            let gathered = &mut self.weight[node as usize];
            if *gathered == 0.0 {
                self.touched.push(node);
            }
            *gathered += weight * shape;
        }
    }
}
