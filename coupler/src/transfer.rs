//! Grains ↔ mesh: deposit a quantity of the grains on the nodes, sample a nodal field at the grains.
//!
//! ```text
//!   deposit   c = B⁻¹ Nᵀx,   B = M_ℓ + L²K      (T1)   lumped mass M_ℓ, stiffness K; L = 0: M_ℓ⁻¹ Nᵀx
//!   sample    f_i = (N B⁻¹ M_ℓ f)_i             (T2)   the adjoint of (T1) in the mass M_ℓ
//! ```
//!
//! so that Σ_α ℓ_α f_α c_α = Σ_i x_i f_i for any f, x: action = reaction. K 1 = 0 conserves the sum
//! of what is deposited for every L. L ≥ 2d removes the mesh dependence of large grains. Spheres in
//! a slab are deposited over its depth: the fluid is solved per metre of depth.

use protocol::engine::MeshDescription;

use crate::error::CouplerError;
use crate::locate::{Locator, Stencil};

/// The transfer between one mesh and any set of grains.
#[derive(Debug)]
pub struct Transfer {
    locator: Locator,
    node_position: Vec<f64>,
    nodal_mass: Vec<f64>,
    smoothing: Option<Smoothing>,
    depth: f64,
}

/// Where a set of grains is on the mesh.
#[derive(Debug, Clone, Default)]
pub struct Placement {
    stencils: Vec<Stencil>,
}

impl Transfer {
    /// Transfer on a mesh, smoothed over the length L \[m\] (0: lumped mass); `depth` \[m\] is that
    /// of the slab for spheres, 1 for disks.
    pub fn new(mesh: &MeshDescription, smoothing_length: f64, depth: f64) -> Transfer {
        let smoothing = (smoothing_length > 0.0).then(|| Smoothing::new(mesh, smoothing_length));
        Transfer {
            locator: Locator::new(mesh),
            node_position: mesh.node_position.clone(),
            nodal_mass: mesh.nodal_mass.clone(),
            smoothing,
            depth,
        }
    }

    /// Lumped mass ℓ_α of the nodes \[m²\].
    pub fn nodal_mass(&self) -> &[f64] {
        &self.nodal_mass
    }

    /// Depth of the slab \[m\]; 1 for disks.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Position of a node \[m\].
    pub fn node_position(&self, node: usize) -> [f64; 2] {
        [
            self.node_position[2 * node],
            self.node_position[2 * node + 1],
        ]
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodal_mass.len()
    }

    /// Find grains (interleaved positions \[m\]) on the mesh.
    pub fn place(&self, positions: &[f64]) -> Result<Placement, CouplerError> {
        let stencils = positions
            .chunks_exact(2)
            .enumerate()
            .map(|(grain, point)| self.locator.locate(grain, [point[0], point[1]]))
            .collect::<Result<_, _>>()?;
        Ok(Placement { stencils })
    }

    /// (T1) of a scalar a grain.
    pub fn deposit(&self, placement: &Placement, values: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut nodal = vec![0.0; self.node_count()];
        for (grain, stencil) in placement.stencils.iter().enumerate() {
            let value = values(grain) / self.depth;
            for (&node, &weight) in stencil.nodes.iter().zip(&stencil.weights) {
                nodal[node as usize] += weight * value;
            }
        }
        self.over_mass(&mut nodal);
        nodal
    }

    /// (T1) of a vector a grain; interleaved result.
    pub fn deposit_vector(
        &self,
        placement: &Placement,
        values: impl Fn(usize) -> [f64; 2],
    ) -> Vec<f64> {
        let parts = [0, 1].map(|axis| self.deposit(placement, |grain| values(grain)[axis]));
        interleave(&parts[0], &parts[1])
    }

    /// (T2) of a nodal scalar.
    pub fn sample(&self, placement: &Placement, nodal: &[f64]) -> Vec<f64> {
        let smoothed = self
            .smoothing
            .as_ref()
            .map(|smoothing| smoothing.adjoint(nodal, &self.nodal_mass));
        let field = smoothed.as_deref().unwrap_or(nodal);
        let at = |stencil: &Stencil| {
            let [a, b, c] = stencil.nodes.map(|node| field[node as usize]);
            stencil.weights[0] * a + stencil.weights[1] * b + stencil.weights[2] * c
        };
        placement.stencils.iter().map(at).collect()
    }

    /// (T2) of an interleaved nodal vector field; interleaved result.
    pub fn sample_vector(&self, placement: &Placement, nodal: &[f64]) -> Vec<f64> {
        if self.smoothing.is_some() {
            let parts = [0, 1].map(|axis| self.sample(placement, &component(nodal, axis)));
            return interleave(&parts[0], &parts[1]);
        }
        let mut sampled = Vec::with_capacity(2 * placement.stencils.len());
        for stencil in &placement.stencils {
            for axis in 0..2 {
                let [a, b, c] = stencil.nodes.map(|node| nodal[2 * node as usize + axis]);
                sampled
                    .push(stencil.weights[0] * a + stencil.weights[1] * b + stencil.weights[2] * c);
            }
        }
        sampled
    }

    fn over_mass(&self, nodal: &mut [f64]) {
        match &self.smoothing {
            Some(smoothing) => smoothing.solve(nodal),
            None => nodal
                .iter_mut()
                .zip(&self.nodal_mass)
                .for_each(|(value, mass)| *value /= mass),
        }
    }
}

/// One component of an interleaved field.
pub fn component(interleaved: &[f64], axis: usize) -> Vec<f64> {
    interleaved.iter().skip(axis).step_by(2).copied().collect()
}

fn interleave(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).flat_map(|(&x, &y)| [x, y]).collect()
}

/// B = M_ℓ + L²K in compressed rows, solved by conjugate gradients with a diagonal preconditioner.
/// B is symmetric positive definite with a condition number of about 1 + 8 L²/h².
#[derive(Debug)]
struct Smoothing {
    row_start: Vec<usize>,
    columns: Vec<u32>,
    entries: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Smoothing {
    fn new(mesh: &MeshDescription, length: f64) -> Smoothing {
        let mut triplets: Vec<(u32, u32, f64)> = Vec::with_capacity(9 * mesh.triangles.len());
        for (node, &mass) in mesh.nodal_mass.iter().enumerate() {
            triplets.push((node as u32, node as u32, mass));
        }
        for (nodes, corners) in mesh.triangles.iter().zip(&mesh.triangle_position) {
            let stiffness = triangle_stiffness(corners);
            for i in 0..3 {
                for j in 0..3 {
                    triplets.push((nodes[i], nodes[j], length * length * stiffness[i][j]));
                }
            }
        }
        triplets.sort_by_key(|&(row, column, _)| (row, column)); // stable: a fixed order of sums
        let count = mesh.nodal_mass.len();
        let mut smoothing = Smoothing {
            row_start: vec![0; count + 1],
            columns: Vec::new(),
            entries: Vec::new(),
            diagonal: vec![0.0; count],
        };
        let mut last = None;
        for (row, column, value) in triplets {
            if last == Some((row, column)) {
                *smoothing.entries.last_mut().expect("a previous entry") += value;
            } else {
                smoothing.columns.push(column);
                smoothing.entries.push(value);
                smoothing.row_start[row as usize + 1] += 1;
            }
            last = Some((row, column));
            if row == column {
                smoothing.diagonal[row as usize] = *smoothing.entries.last().expect("this entry");
            }
        }
        for row in 0..count {
            smoothing.row_start[row + 1] += smoothing.row_start[row];
        }
        smoothing
    }

    fn times(&self, x: &[f64], y: &mut [f64]) {
        for (row, value) in y.iter_mut().enumerate() {
            let range = self.row_start[row]..self.row_start[row + 1];
            *value = range
                .map(|k| self.entries[k] * x[self.columns[k] as usize])
                .sum();
        }
    }

    /// B⁻¹ b, in place. Then the sum is restored exactly: 1ᵀB x = 1ᵀM_ℓ x needs no solve.
    fn solve(&self, b: &mut [f64]) {
        let count = b.len();
        let mut x: Vec<f64> = b.iter().zip(&self.diagonal).map(|(b, d)| b / d).collect();
        let mut product = vec![0.0; count];
        self.times(&x, &mut product);
        let mut residual: Vec<f64> = b.iter().zip(&product).map(|(b, p)| b - p).collect();
        let precondition =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect() };
        let mut scaled = precondition(&residual);
        let mut direction = scaled.clone();
        let mut energy = dot(&residual, &scaled);
        let target = 1e-30 * dot(b, &precondition(b));
        for _ in 0..10 * count {
            if energy <= target {
                break;
            }
            self.times(&direction, &mut product);
            let step = energy / dot(&direction, &product);
            for i in 0..count {
                x[i] += step * direction[i];
                residual[i] -= step * product[i];
            }
            scaled = precondition(&residual);
            let next = dot(&residual, &scaled);
            let ratio = next / energy;
            energy = next;
            for i in 0..count {
                direction[i] = scaled[i] + ratio * direction[i];
            }
        }
        b.copy_from_slice(&x);
    }

    /// B⁻¹ M_ℓ f
    fn adjoint(&self, f: &[f64], mass: &[f64]) -> Vec<f64> {
        let mut result: Vec<f64> = f.iter().zip(mass).map(|(f, m)| f * m).collect();
        self.solve(&mut result);
        result
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// ∫∇N_i·∇N_j over one triangle.
fn triangle_stiffness(corners: &[f64; 6]) -> [[f64; 3]; 3] {
    let [ax, ay, bx, by, cx, cy] = *corners;
    let doubled_area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    let edges = [[by - cy, cx - bx], [cy - ay, ax - cx], [ay - by, bx - ax]]; // 2A ∇N_i
    let entry = |i: usize, j: usize| {
        (edges[i][0] * edges[j][0] + edges[i][1] * edges[j][1]) / (2.0 * doubled_area)
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}
