//! What nodes say, packed once an assembly: a group gathers few cache lines.

use crate::equations::coefficients::Coefficients;

/// A node in grains, but for the flows.
#[derive(Clone, Copy)]
pub struct Grains<const D: usize> {
    /// φ
    pub porosity: f64,
    /// c
    pub entrained: f64,
    /// c/φ
    pub entrained_ratio: f64,
    /// κ
    pub mobility: f64,
    /// β
    pub drag: f64,
    /// β/φ
    pub drag_ratio: f64,
    /// β of fixed grains, at most β
    pub fixed_drag: f64,
    /// s
    pub source: [f64; D],
    /// j⁰
    pub flux: [f64; D],
}

/// A known flow at a node.
#[derive(Clone, Copy)]
pub struct Known<const D: usize> {
    /// u
    pub velocity: [f64; D],
    /// φ
    pub porosity: f64,
}

/// A node in clear fluid, where v = u.
#[derive(Clone, Copy)]
pub struct Clear<const D: usize> {
    /// a
    pub convecting: [f64; D],
    /// Σ η_k v^k
    pub history: [f64; D],
}

/// Records of all nodes.
pub struct Records<const D: usize> {
    /// What clear nodes need.
    pub clear: Vec<Clear<D>>,
    /// Is a node in clear fluid: φ = 1 now and before, β, c, κ, s and j⁰ = 0?
    is_clear: Vec<bool>,
    /// What the others need.
    pub grains: Vec<Grains<D>>,
    /// Flows, all of one node after the other.
    pub known: Vec<Known<D>>,
}

impl<const D: usize> Records<D> {
    /// Pack what the equations are told.
    pub fn pack(terms: &Coefficients<'_, D>) -> Records<D> {
        let count = terms.solid.matrix.porosity.len();
        let mut records = Records {
            clear: Vec::with_capacity(count),
            is_clear: Vec::with_capacity(count),
            grains: Vec::with_capacity(count),
            known: Vec::with_capacity(terms.carriers.len() * count),
        };
        for node in 0..count {
            records.push(terms, node);
        }
        records
    }

    /// Are all of these nodes in clear fluid?
    #[inline(always)]
    pub fn are_clear<const N: usize>(&self, nodes: &[[usize; N]]) -> bool {
        let mut clear = true;
        for &node in nodes.as_flattened() {
            clear &= self.is_clear[node];
        }
        clear
    }

    #[inline(always)]
    fn push(&mut self, terms: &Coefficients<'_, D>, node: usize) {
        let solid = &terms.solid.matrix;
        let (porosity, entrained) = (solid.porosity[node], solid.entrained_fraction[node]);
        let (drag, mobility) = (solid.drag[node], solid.solid_mobility[node]);
        let fixed = solid.fixed_drag.get(node);
        let (source, flux) = (terms.solid.drag_source[node], terms.solid.solid_flux[node]);
        let mut still = [entrained, drag, mobility]
            .iter()
            .all(|&value| value == 0.0);
        still &= (0..D).all(|d| source[d] == 0.0 && flux[d] == 0.0);
        let mut is_clear = porosity == 1.0 && still;
        let mut clear = Clear {
            convecting: [0.0; D],
            history: [0.0; D],
        };
        for carrier in terms.carriers {
            let velocity = carrier.flow.superficial_velocity[node];
            let known = Known {
                velocity: velocity.into(),
                porosity: carrier.flow.porosity[node],
            };
            is_clear &= known.porosity == 1.0;
            for d in 0..D {
                clear.convecting[d] += carrier.convects * velocity[d];
                clear.history[d] += carrier.history * velocity[d];
            }
            self.known.push(known);
        }
        self.clear.push(clear);
        self.is_clear.push(is_clear);
        self.grains.push(Grains {
            porosity,
            entrained,
            entrained_ratio: entrained / porosity,
            mobility,
            drag,
            drag_ratio: drag / porosity,
            fixed_drag: fixed.map_or(0.0, |fixed| fixed.min(drag).max(0.0)),
            source: source.into(),
            flux: flux.into(),
        });
    }
}
