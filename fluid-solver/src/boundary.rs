//! Boundary conditions, resolved to nodes once for a mesh.
//!
//! Where boundaries with different conditions meet, the node takes the strongest: no-slip, then
//! given velocity (the boundary named first in the mesh), then slip. A corner between two slip
//! walls whose normals differ by more than 37° holds both components; on a gentler bend the
//! length-weighted normal is used. Pressure at an open boundary is given strongly,
//! p = p₀ + ρ g·(x − x_top). In a domain without an open boundary node 0 has p = 0.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::error::FluidError;
use crate::mesh::{BoundaryEdge, Mesh};

/// A velocity that depends on position and time \[m/s\].
pub type VelocityFunction = dyn Fn([f64; 2], f64) -> [f64; 2] + Send + Sync;

/// A condition on one boundary. Velocities are superficial.
#[derive(Clone)]
pub enum Condition {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of a rectangle.
    Periodic,
    /// The same velocity everywhere \[m/s\].
    Uniform([f64; 2]),
    /// Zero at both ends, this velocity in the middle \[m/s\].
    Parabolic([f64; 2]),
    /// Any velocity.
    Function(Arc<VelocityFunction>),
    /// Pressure at the highest point \[Pa\], hydrostatic along the boundary.
    Open(f64),
}

impl std::fmt::Debug for Condition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Condition::NoSlip => f.write_str("NoSlip"),
            Condition::Slip => f.write_str("Slip"),
            Condition::Periodic => f.write_str("Periodic"),
            Condition::Uniform(u) => write!(f, "Uniform({u:?})"),
            Condition::Parabolic(u) => write!(f, "Parabolic({u:?})"),
            Condition::Function(_) => f.write_str("Function"),
            Condition::Open(p) => write!(f, "Open({p})"),
        }
    }
}

/// What is known about the velocity of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
enum NodeVelocity {
    Free,
    /// Normal component zero; the unknowns are turned to (normal, tangential).
    Normal([f64; 2]),
    /// Given by this boundary, times a shape factor.
    Given(usize, f64),
    Zero,
}

/// Conditions on the unknowns of a mesh.
#[derive(Debug, Clone)]
pub struct Constraints {
    conditions: Vec<Condition>,
    velocity: Vec<NodeVelocity>,
    pressure: Vec<(usize, f64)>,
    /// Is there no open boundary, so that node 0 has p = 0?
    pub closed: bool,
    /// Is the unknown given? Three a node: u_x, u_y, p.
    pub fixed: Vec<bool>,
    /// Nodes whose velocity unknowns are (normal, tangential), by node; the normal.
    pub frames: Vec<Option<[f64; 2]>>,
    /// Edges across which the given velocity carries fluid.
    pub flux_edges: Vec<BoundaryEdge>,
    /// Edges of open boundaries.
    pub open_edges: Vec<BoundaryEdge>,
}

/// Conditions by boundary, from a list by name; "all" stands for every boundary not named.
pub fn resolve_names(
    named: &BTreeMap<String, Condition>,
    known: &[String],
) -> Result<Vec<Condition>, FluidError> {
    if let Some(name) = named
        .keys()
        .find(|name| *name != "all" && !known.contains(name))
    {
        return Err(FluidError::UnknownBoundary {
            name: name.clone(),
            allowed: known.to_vec(),
        });
    }
    let condition = |name: &String| named.get(name).or_else(|| named.get("all")).cloned();
    let missing = |name: &String| FluidError::MissingCondition { name: name.clone() };
    known
        .iter()
        .map(|name| condition(name).ok_or_else(|| missing(name)))
        .collect()
}

/// Directions in which a rectangle with these conditions is joined: both sides must say so.
pub fn periodic_directions(named: &BTreeMap<String, Condition>) -> Result<[bool; 2], FluidError> {
    let joined = |name: &str| {
        matches!(
            named.get(name).or_else(|| named.get("all")),
            Some(Condition::Periodic)
        )
    };
    let mut periodic = [false; 2];
    for (direction, [a, b]) in [["left", "right"], ["bottom", "top"]]
        .into_iter()
        .enumerate()
    {
        if joined(a) != joined(b) {
            let (name, other) = if joined(a) { (a, b) } else { (b, a) };
            let why = format!("periodic here needs periodic on {other:?} as well");
            return Err(FluidError::Boundary {
                name: name.into(),
                why,
            });
        }
        periodic[direction] = joined(a);
    }
    Ok(periodic)
}

impl Constraints {
    /// Resolve the conditions, one a boundary of the mesh.
    pub fn new(
        mesh: &Mesh,
        conditions: Vec<Condition>,
        density: f64,
        gravity: [f64; 2],
    ) -> Result<Constraints, FluidError> {
        let mut of_node = vec![NodeVelocity::Free; mesh.node_count()];
        for edge in &mesh.edges {
            for node in edge.node {
                of_node[node] = match (&conditions[edge.boundary], of_node[node]) {
                    (Condition::NoSlip, _) | (_, NodeVelocity::Zero) => NodeVelocity::Zero,
                    (Condition::Periodic, _) => return Err(unjoined(mesh, edge.boundary)),
                    (Condition::Slip | Condition::Open(_), known) => known,
                    (_, NodeVelocity::Given(k, s)) if k <= edge.boundary => {
                        NodeVelocity::Given(k, s)
                    }
                    _ => NodeVelocity::Given(edge.boundary, 1.0),
                };
            }
        }
        slip_normals(mesh, &conditions, &mut of_node);
        parabolic_factors(mesh, &conditions, &mut of_node)?;
        let pressure = open_pressures(mesh, &conditions, density, gravity);
        let of_kind = |wanted: fn(&Condition) -> bool| {
            mesh.edges
                .iter()
                .filter(|edge| wanted(&conditions[edge.boundary]))
                .copied()
                .collect()
        };
        let open_edges: Vec<_> = of_kind(|condition| matches!(condition, Condition::Open(_)));
        let flux_edges = of_kind(|condition| {
            use Condition::{Function, Parabolic, Uniform};
            matches!(condition, Uniform(_) | Parabolic(_) | Function(_))
        });
        let mut constraints = Constraints {
            closed: open_edges.is_empty(),
            fixed: Vec::new(),
            frames: Vec::new(),
            conditions,
            velocity: of_node,
            pressure,
            flux_edges,
            open_edges,
        };
        constraints.mark();
        Ok(constraints)
    }

    /// Fill `fixed` and `frames`.
    fn mark(&mut self) {
        self.fixed = vec![false; 3 * self.velocity.len()];
        self.frames = vec![None; self.velocity.len()];
        for (node, velocity) in self.velocity.iter().enumerate() {
            match *velocity {
                NodeVelocity::Free => {}
                NodeVelocity::Zero | NodeVelocity::Given(..) => {
                    self.fixed[3 * node] = true;
                    self.fixed[3 * node + 1] = true;
                }
                NodeVelocity::Normal([_, 0.0]) => self.fixed[3 * node] = true,
                NodeVelocity::Normal([0.0, _]) => self.fixed[3 * node + 1] = true,
                NodeVelocity::Normal(normal) => {
                    self.fixed[3 * node] = true;
                    self.frames[node] = Some(normal);
                }
            }
        }
        for &(node, _) in &self.pressure {
            self.fixed[3 * node + 2] = true;
        }
        if self.closed {
            self.fixed[2] = true;
        }
    }

    /// The given unknowns at a time; zero where an unknown is free.
    pub fn values(&self, mesh: &Mesh, time: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.fixed.len()];
        for (node, velocity) in self.velocity.iter().enumerate() {
            if let NodeVelocity::Given(boundary, factor) = *velocity {
                let u = match &self.conditions[boundary] {
                    Condition::Uniform(u) | Condition::Parabolic(u) => *u,
                    Condition::Function(u) => u(mesh.position[node], time),
                    _ => [0.0; 2],
                };
                values[3 * node] = factor * u[0];
                values[3 * node + 1] = factor * u[1];
            }
        }
        for &(node, value) in &self.pressure {
            values[3 * node + 2] = value;
        }
        values
    }

    /// ∮ N_i Q_n of the given velocities, by node \[m²/s\]. In a closed domain what interpolation
    /// leaves of the net flux is spread evenly over these edges; more than that is an error.
    pub fn boundary_flux(&self, mesh: &Mesh, values: &[f64]) -> Result<Vec<f64>, FluidError> {
        let mut flux = vec![0.0; mesh.node_count()];
        let (mut net, mut gross, mut length) = (0.0, 0.0, 0.0);
        for edge in &self.flux_edges {
            let normal =
                |n: usize| values[3 * n] * edge.normal[0] + values[3 * n + 1] * edge.normal[1];
            let speed = |n: usize| values[3 * n].hypot(values[3 * n + 1]);
            let [a, b] = edge.node;
            flux[a] += edge.length / 6.0 * (2.0 * normal(a) + normal(b));
            flux[b] += edge.length / 6.0 * (normal(a) + 2.0 * normal(b));
            net += 0.5 * edge.length * (normal(a) + normal(b));
            gross += 0.5 * edge.length * (speed(a) + speed(b));
            length += edge.length;
        }
        if self.closed && net != 0.0 {
            if net.abs() > 0.01 * gross {
                return Err(FluidError::Unbalanced {
                    net: -net,
                    relative: net.abs() / gross,
                });
            }
            for edge in &self.flux_edges {
                for node in edge.node {
                    flux[node] -= 0.5 * edge.length * net / length;
                }
            }
        }
        Ok(flux)
    }

    /// Condition of a boundary.
    pub fn condition(&self, boundary: usize) -> &Condition {
        &self.conditions[boundary]
    }
}

fn unjoined(mesh: &Mesh, boundary: usize) -> FluidError {
    FluidError::Boundary {
        name: mesh.boundary_names[boundary].clone(),
        why: "periodic needs a rectangle and the same condition on the opposite side".into(),
    }
}

/// Unit normals of slip nodes; both components held at sharp corners.
fn slip_normals(mesh: &Mesh, conditions: &[Condition], of_node: &mut [NodeVelocity]) {
    let mut sum = vec![[0.0; 2]; mesh.node_count()];
    let mut first: Vec<Option<[f64; 2]>> = vec![None; mesh.node_count()];
    let mut sharp = vec![false; mesh.node_count()];
    let slip = |edge: &&BoundaryEdge| matches!(conditions[edge.boundary], Condition::Slip);
    for edge in mesh.edges.iter().filter(slip) {
        for node in edge.node {
            let seen = *first[node].get_or_insert(edge.normal);
            sharp[node] |= seen[0] * edge.normal[0] + seen[1] * edge.normal[1] < 0.8;
            for (sum, normal) in sum[node].iter_mut().zip(edge.normal) {
                *sum += edge.length * normal;
            }
        }
    }
    for node in 0..mesh.node_count() {
        if first[node].is_some() && of_node[node] == NodeVelocity::Free {
            let [x, y] = sum[node];
            let length = x.hypot(y);
            // A wall that is straight to round-off keeps its axis.
            let snap = |v: f64| {
                if v.abs() < 1e-12 * length {
                    0.0
                } else {
                    v / length
                }
            };
            of_node[node] = if sharp[node] {
                NodeVelocity::Zero
            } else {
                NodeVelocity::Normal([snap(x), snap(y)])
            };
        }
    }
}

/// 4 t (1 − t) along each parabolic boundary, t from end to end.
fn parabolic_factors(
    mesh: &Mesh,
    conditions: &[Condition],
    of_node: &mut [NodeVelocity],
) -> Result<(), FluidError> {
    for (boundary, condition) in conditions.iter().enumerate() {
        if !matches!(condition, Condition::Parabolic(_)) {
            continue;
        }
        let mut nodes: Vec<usize> = mesh
            .edges
            .iter()
            .filter(|e| e.boundary == boundary)
            .flat_map(|e| e.node)
            .collect();
        nodes.sort_unstable();
        let ends: Vec<_> = nodes
            .chunk_by(|a, b| a == b)
            .filter(|g| g.len() == 1)
            .map(|g| g[0])
            .collect();
        let &[a, b] = ends.as_slice() else {
            return Err(FluidError::Boundary {
                name: mesh.boundary_names[boundary].clone(),
                why: format!(
                    "a parabolic inflow needs one open line with 2 ends; it has {}",
                    ends.len()
                ),
            });
        };
        let (p, q) = (mesh.position[a], mesh.position[b]);
        let along = [q[0] - p[0], q[1] - p[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        for &node in &nodes {
            let x = mesh.position[node];
            let t = ((x[0] - p[0]) * along[0] + (x[1] - p[1]) * along[1]) / squared;
            if let NodeVelocity::Given(k, factor) = &mut of_node[node]
                && *k == boundary
            {
                *factor = 4.0 * t * (1.0 - t);
            }
        }
    }
    Ok(())
}

/// Pressure of the nodes of open boundaries; the boundary named first wins at a shared node.
fn open_pressures(
    mesh: &Mesh,
    conditions: &[Condition],
    density: f64,
    gravity: [f64; 2],
) -> Vec<(usize, f64)> {
    let mut of_node: BTreeMap<usize, f64> = BTreeMap::new();
    for (boundary, condition) in conditions.iter().enumerate() {
        let Condition::Open(top) = condition else {
            continue;
        };
        let nodes = || {
            mesh.edges
                .iter()
                .filter(|e| e.boundary == boundary)
                .flat_map(|e| e.node)
        };
        let depth = |node: usize| {
            let x = mesh.position[node];
            gravity[0] * x[0] + gravity[1] * x[1]
        };
        let highest = nodes().map(depth).fold(f64::INFINITY, f64::min);
        for node in nodes() {
            of_node
                .entry(node)
                .or_insert(top + density * (depth(node) - highest));
        }
    }
    of_node.into_iter().collect()
}
