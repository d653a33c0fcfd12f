//! When the mesh follows the grains and the flow, and how fine it is where.
//!
//! ```text
//!   grains   cells of edge `margin` that grains are in are wished small: h = near_grains, two rings, one of them inner
//!   flow     cells of edge 4 h that the indicator wishes small, for h = smallest · √2ᵏ: one ring, an inner one
//! ```
//!
//! ([`layer`], (A1); [`indicator`], (I1)). A grain is at least two margins from the edge of a new zone, and one margin
//! when the mesh follows.

pub mod indicator;
pub mod layer;

use protocol::scene::{self, NearGrains, REGIONS_MAX, Refinement, Region};
use serde::{Deserialize, Serialize};
use space::{Dim, Dimension, Period};

use crate::error::CouplerError;
use crate::follow::indicator::Indicator;
use crate::follow::layer::{Cell, Layer, Rule, cells_of, sorted};
use crate::state::{Grains, State};
use crate::transfer::deposit::Transfer;
use crate::transfer::mesh::Mesh;

/// Of the zone around grains.
const GRAINS: Rule = Rule {
    outer: 2,
    inner: 1,
    too_large: 1.2,
};
/// Of zones where the flow bends: what is wished for comes and goes by a little.
const FLOW: Rule = Rule {
    outer: 1,
    inner: 1,
    too_large: 2.0,
};
/// Edge of the cells where the flow bends, in h there.
const EDGE: f64 = 4.0;
/// Layers are of sizes that halves make in the plane, so √2 apart: a wish is for the next one, and urgent where it is
/// for that one or a smaller one.
const APART: f64 = std::f64::consts::SQRT_2;

/// All cells of a lattice that is so often coarser by two are a few around the origin.
const COARSEST: u32 = 42;

/// What the mesh has been asked for, kept in checkpoints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// Epoch of the mesh since.
    pub epoch: u64,
    /// Cells that were wished small, by layer.
    cells: Vec<Vec<i64>>,
}

/// Follows the flow: of layers from fine to coarse.
struct Flow<const D: usize, const N: usize> {
    asked: scene::Indicator,
    /// Of the mesh of this epoch.
    indicator: Option<(u64, Indicator<D, N>)>,
    layers: Vec<Layer<D>>,
}

/// Follows grains and flow.
pub struct Follow<const D: usize, const N: usize> {
    sizes: Refinement,
    grains: Option<Layer<D>>,
    flow: Option<Flow<D, N>>,
}

/// Cells that are wished small, and urgently.
type Wished<const D: usize> = (Vec<Cell<D>>, Vec<Cell<D>>);

impl<const D: usize, const N: usize> Follow<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// In a scene that asks for it; `coarsest` are the largest cells of the first mesh \[m\].
    pub fn new(
        sizes: Option<&Refinement>,
        near: Option<NearGrains>,
        indicator: Option<scene::Indicator>,
        (coarsest, period): (f64, &Period<D>),
    ) -> Option<Follow<D, N>> {
        if near.is_none() && indicator.is_none() {
            return None;
        }
        let flow = |asked: scene::Indicator| {
            let size = |k: i32| asked.smallest * APART.powi(k);
            let sizes = (0..).map(size).take_while(|size| *size < coarsest);
            let layer = |size: f64| Layer::new(size, EDGE * size, period, FLOW);
            Flow {
                asked,
                indicator: None,
                layers: sizes.map(layer).collect(),
            }
        };
        Some(Follow {
            sizes: sizes?.clone(),
            grains: near.map(|near| Layer::new(near.size, near.margin, period, GRAINS)),
            flow: indicator.map(flow),
        })
    }

    /// The sizes to ask for now, where the mesh must follow (A1); this is its epoch.
    pub fn wish(&mut self, state: &State<D>, mesh: &Mesh<D, N>, epoch: u64) -> Option<Refinement> {
        let mut wished: Vec<Wished<D>> = Vec::new();
        if let Some(layer) = &self.grains {
            let cells = around_grains(layer, &state.grains);
            wished.push((cells.clone(), cells));
        }
        if let Some(flow) = &mut self.flow {
            wished.extend(flow.wished(state, mesh, epoch));
        }
        let outdated = self
            .layers()
            .zip(&wished)
            .any(|(layer, (cells, urgent))| layer.is_outdated(cells, urgent));
        outdated.then(|| self.ask(wished.into_iter().map(|(cells, _)| cells)))
    }

    /// The sizes of a mesh that was asked for earlier; none where the cells are none.
    pub fn again(&mut self, asked: &Asked) -> Option<Refinement> {
        let cells = asked.cells.iter().map(|numbers| cells_of(numbers));
        let cells: Vec<Vec<Cell<D>>> = cells.collect::<Option<_>>()?;
        (cells.len() == self.layers().count()).then(|| self.ask(cells))
    }

    /// What was asked for, since when the mesh is of this epoch.
    pub fn asked(&self, epoch: u64) -> Asked {
        Asked {
            epoch,
            cells: self.layers().map(Layer::asked).collect(),
        }
    }

    fn layers(&self) -> impl Iterator<Item = &Layer<D>> {
        let flow = self.flow.iter().flat_map(|flow| &flow.layers);
        self.grains.iter().chain(flow)
    }

    fn ask(&mut self, cells: impl IntoIterator<Item = Vec<Cell<D>>>) -> Refinement {
        let flow = self.flow.iter_mut().flat_map(|flow| &mut flow.layers);
        let layers = self.grains.iter_mut().chain(flow);
        layers
            .zip(cells)
            .for_each(|(layer, cells)| layer.ask(cells));
        let mut sizes = self.sizes.clone();
        let most = REGIONS_MAX - sizes.regions.len().min(REGIONS_MAX);
        sizes.regions.extend(self.zones(most));
        sizes
    }

    /// The zones of all layers as boxes; where they are more than `most`, that of the most is made of a coarser lattice,
    /// again and again.
    fn zones(&self, most: usize) -> Vec<Region> {
        let layers: Vec<&Layer<D>> = self.layers().collect();
        let mut zones: Vec<_> = layers.iter().map(|layer| (0, layer.zone(0))).collect();
        while zones.iter().map(|(_, zone)| zone.len()).sum::<usize>() > most {
            let counts = zones.iter().map(|(_, zone)| zone.len()).enumerate();
            let Some((number, _)) = counts.max_by_key(|(_, count)| *count) else {
                break;
            };
            if zones[number].0 == COARSEST {
                break;
            }
            let coarser = zones[number].0 + 1;
            zones[number] = (coarser, layers[number].zone(coarser));
        }
        zones.into_iter().flat_map(|(_, zone)| zone).collect()
    }
}

impl<const D: usize, const N: usize> Flow<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// By layer. Of a flow that nobody has computed yet nothing is wished.
    fn wished(&mut self, state: &State<D>, mesh: &Mesh<D, N>, epoch: u64) -> Vec<Wished<D>> {
        if state.step == 0 {
            return vec![(Vec::new(), Vec::new()); self.layers.len()];
        }
        let known = self.indicator.take().filter(|(of, _)| *of == epoch);
        let (_, indicator) = self
            .indicator
            .insert(known.unwrap_or_else(|| (epoch, Indicator::new(self.asked, mesh))));
        let wishes = indicator.wishes(&state.flow.velocity);
        let of = |layer: &Layer<D>, limit: f64| {
            let mut cells = Vec::new();
            for (place, _) in wishes.iter().filter(|(_, wish)| *wish <= limit) {
                layer.add(place, 0.0, &mut cells);
            }
            sorted(cells)
        };
        let layers = self.layers.iter();
        layers
            .map(|layer| (of(layer, APART.sqrt() * layer.size), of(layer, layer.size)))
            .collect()
    }
}

/// The flow and porosity of a state, from one mesh to the nodes of another.
pub fn carry<const D: usize, const N: usize>(
    from: &Transfer<D, N>,
    to: &Mesh<D, N>,
    state: &mut State<D>,
) -> Result<(), CouplerError>
where
    Dim<D>: Dimension<D>,
{
    // nodes are grains of no size
    let sizes = vec![0.0; to.node_position.len()];
    let nodes = from.place(&to.node_position, &sizes)?;
    let State { flow, porosity, .. } = state;
    // a field that nobody reads is not there
    for field in [&mut flow.velocity, &mut flow.pressure_gradient] {
        if !field.is_empty() {
            *field = from.sample(&nodes, field);
        }
    }
    if !porosity.is_empty() {
        *porosity = from.sample(&nodes, porosity);
    }
    Ok(())
}

/// Cells that grains are in.
fn around_grains<const D: usize>(layer: &Layer<D>, grains: &Grains<D>) -> Vec<Cell<D>> {
    let mut cells = Vec::with_capacity(grains.count());
    for (position, radius) in grains.position.iter().zip(&grains.radius) {
        layer.add(position, *radius, &mut cells);
    }
    sorted(cells)
}

#[cfg(test)]
mod tests {
    use space::Vector;

    use super::*;

    type Follows = Follow<2, 3>;

    const SIZES: Refinement = Refinement {
        growth: 0.2,
        largest: None,
        regions: Vec::new(),
    };

    fn grains(positions: &[[f64; 2]]) -> State<2> {
        let grains = Grains {
            position: positions.iter().map(|&x| x.into()).collect(),
            radius: vec![1e-4; positions.len()],
            mass: vec![1.0; positions.len()],
            ..Grains::default()
        };
        State {
            grains,
            ..State::default()
        }
    }

    fn near(period: Period<2>) -> Follows {
        let follow = Follow::new(Some(&SIZES), Some(NEAR_GRAINS), None, (1.0, &period));
        follow.expect("asked for")
    }

    /// What is wished where no indicator looks at the mesh.
    fn wish(follow: &mut Follows, state: &State<2>) -> Option<Refinement> {
        follow.wish(state, &square(1), 1)
    }

    const NEAR_GRAINS: NearGrains = NearGrains {
        size: 0.02,
        margin: 0.1,
    };

    fn is_in(region: &Region, point: [f64; 2]) -> bool {
        let Region::Box { lower, upper, .. } = region else {
            return false;
        };
        (0..2).all(|d| lower[d] - 1e-12 <= point[d] && point[d] <= upper[d] + 1e-12)
    }

    #[test]
    fn the_mesh_follows_when_a_grain_has_gone_a_margin_or_the_zone_is_too_large() {
        let mut follow = near([None; 2]);
        let first = wish(&mut follow, &grains(&[[0.55, 0.55]])).expect("never asked");
        for reach in [[0.2, 0.0], [0.0, -0.2], [0.2, 0.2]] {
            let point = [0.55 + reach[0], 0.55 + reach[1]];
            assert!(first.regions.iter().any(|region| is_in(region, point)));
        }
        assert_eq!(first.regions.len(), 1);
        assert_eq!(wish(&mut follow, &grains(&[[0.64, 0.46]])), None);
        let there = grains(&[[0.55, 0.34]]);
        let asked = wish(&mut follow, &there).expect("it is beyond the ring");
        assert_eq!(wish(&mut follow, &there), None);
        // the same wherever it came from, and from a checkpoint
        let mut other = near([None; 2]);
        assert_eq!(wish(&mut other, &there).as_ref(), Some(&asked));
        let kept = follow.asked(7);
        assert_eq!(other.again(&kept).as_ref(), Some(&asked));
        // two grains that have come together
        wish(&mut follow, &grains(&[[0.15, 0.15], [0.85, 0.85]])).expect("far");
        let near = wish(&mut follow, &grains(&[[0.15, 0.15], [0.16, 0.15]]));
        assert_eq!(near.map(|sizes| sizes.regions.len()), Some(1));
    }

    #[test]
    fn across_a_period_and_with_many_grains_every_grain_is_in_a_region() {
        let period = [Some(1.0), None];
        let mut follow = near(period);
        let number = |k: usize| (k as f64 * 0.618_033_988_75).fract();
        let at = |k: usize| [number(k), 300.0 * number(7 * k)];
        let positions: Vec<[f64; 2]> = (0..3000).map(at).collect();
        let asked = wish(&mut follow, &grains(&positions)).expect("never asked");
        println!("{} regions", asked.regions.len());
        assert!(asked.regions.len() <= REGIONS_MAX);
        for point in positions {
            assert!(asked.regions.iter().any(|region| is_in(region, point)));
        }
        // nobody is left: a mesh without a zone, asked for once
        assert_eq!(
            wish(&mut follow, &grains(&[])).map(|sizes| sizes.regions.len()),
            Some(0)
        );
        assert_eq!(wish(&mut follow, &grains(&[])), None);
        let lost = grains(&[[1e300, f64::NAN], [-1e300, 0.0]]);
        assert!(wish(&mut follow, &lost).is_some());
        let moved = grains(&[[-0.01, 0.0], [0.99, 0.0], [1.99, 0.0]]);
        let few = wish(&mut near(period), &moved);
        println!("{few:?}");
        let count = few.map(|sizes| sizes.regions.len());
        assert_eq!(count, Some(2), "both ends of the period");
    }

    /// The unit square in n × n squares of two triangles.
    fn square(n: usize) -> Mesh<2, 3> {
        let at = |k: usize| Vector::from([(k % (n + 1)) as f64, (k / (n + 1)) as f64]) / n as f64;
        let node_position: Vec<Vector<2>> = (0..(n + 1) * (n + 1)).map(at).collect();
        let two = |k: usize| {
            let a = (k / n * (n + 1) + k % n) as u32;
            let (b, c) = (a + 1, a + n as u32 + 1);
            [[a, b, c + 1], [a, c + 1, c]]
        };
        let simplices: Vec<[u32; 3]> = (0..n * n).flat_map(two).collect();
        let corners = simplices.iter();
        let corners = corners.map(|nodes| nodes.map(|node| node_position[node as usize]));
        Mesh {
            corners: corners.collect(),
            nodal_mass: vec![1.0; node_position.len()],
            node_position,
            simplices,
            period: [None; 2],
        }
    }

    #[test]
    fn cells_are_small_where_a_flow_bends_and_stay_while_it_stays() {
        let asked = scene::Indicator {
            jump: 0.1,
            smallest: 0.01,
        };
        let mesh = square(32);
        let state = |profile: fn(f64) -> f64| {
            let at = |x: &Vector<2>| Vector::from([profile(x[1]), 0.0]);
            let mut state = State::<2> {
                step: 1,
                ..State::default()
            };
            state.flow.velocity = mesh.node_position.iter().map(at).collect();
            state
        };
        // (I1) of a parabola: |D²v| is the same everywhere
        let indicator = Indicator::new(asked, &mesh);
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        let parabola = state(|y| y * (1.0 - y));
        for (_, wish) in indicator.wishes(&parabola.flow.velocity) {
            if wish.is_finite() {
                (least, most) = (least.min(wish), most.max(wish));
            }
        }
        let exact = (0.1 * 0.25 / 2.0_f64).sqrt();
        println!(
            "wishes from {least:.4} to {most:.4}, {exact:.4} for |D²v| along the flow's normal"
        );
        assert!(least > 0.5 * exact && most < 1.5 * exact);
        let follow = || {
            let follow = Follow::new(Some(&SIZES), None, Some(asked), (0.2, &[None; 2]));
            follow.expect("asked for")
        };
        // straight profiles, and a flow at rest, ask for nothing
        for profile in [|_: f64| 0.0, |y: f64| 3.0 * y] {
            let mut follow: Follows = follow();
            assert_eq!(follow.wish(&state(profile), &mesh, 1), None);
        }
        // a shear layer asks for small cells in it, and for no others while it stays
        let layer = state(|y| ((y - 0.5) / 0.05).tanh());
        let mut follow = follow();
        let sizes = follow.wish(&layer, &mesh, 1).expect("it bends");
        let smallest = |y: f64| {
            let regions = sizes
                .regions
                .iter()
                .filter(|region| is_in(region, [0.5, y]));
            regions.map(Region::size).fold(f64::INFINITY, f64::min)
        };
        println!(
            "h = {} beside the middle, {} far away",
            smallest(0.54),
            smallest(0.95)
        );
        assert!(smallest(0.54) <= 0.02 && smallest(0.95) >= 0.08);
        assert_eq!(follow.wish(&layer, &mesh, 1), None);
        // and is found again by what a checkpoint keeps
        let kept = follow.asked(3);
        let mut other: Follows =
            Follow::new(Some(&SIZES), None, Some(asked), (0.2, &[None; 2])).expect("asked for");
        assert_eq!(other.again(&kept), Some(sizes));
        assert_eq!(
            other.again(&Asked {
                epoch: 3,
                cells: vec![vec![1, 2]]
            }),
            None
        );
    }
}
