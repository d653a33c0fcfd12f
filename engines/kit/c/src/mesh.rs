//! The mesh that a fluid engine answers with.

use protocol::engine::{FacetDescription, MeshDescription};
use protocol::message::{Failure, FailureKind};

/// The mesh, to be filled by configure() and adapt(): pointers to the engine's arrays, which must outlive
/// the call and are copied right after it. Every pointer is NULL and every count 0 before. d is the
/// scene's dimension.
#[repr(C)]
#[derive(Debug)]
pub struct Mesh {
    /// Number of nodes.
    pub node_count: u64,
    /// Node coordinates (m), d node_count numbers.
    pub node_position: *const f64,
    /// Number of simplices: triangles in the plane, tetrahedra in space.
    pub simplex_count: u64,
    /// Nodes of each simplex, (d + 1) simplex_count numbers, positively oriented: in the plane
    /// counter-clockwise, in space so that (x1 - x0) x (x2 - x0) points to the side of x3.
    pub simplex_nodes: *const u32,
    /// Coordinates of each simplex's corners (m), unwrapped across periodic sides, d (d + 1)
    /// simplex_count numbers; NULL: those of its nodes.
    pub simplex_position: *const f64,
    /// Integral of each node's shape function (m2; in space m3); NULL: an equal share of its simplices.
    pub nodal_mass: *const f64,
    /// Period along each axis (m), d numbers, 0 where there is none; NULL: not periodic.
    pub period: *const f64,
}

fn broken(why: impl Into<String>) -> Failure {
    Failure::new(FailureKind::Engine, why)
}

/// Numbers of the engine, copied.
///
/// # Safety
///
/// `from` is null or points to `count` numbers.
unsafe fn copied<T: Copy>(from: *const T, count: usize) -> Option<Vec<T>> {
    // SAFETY: not null, and as long as the caller promises.
    (!from.is_null()).then(|| unsafe { std::slice::from_raw_parts(from, count) }.to_vec())
}

/// The numbers of an array, all finite.
///
/// # Safety
///
/// `from` is null or points to `count` numbers.
unsafe fn finite(name: &str, from: *const f64, count: usize) -> Result<Option<Vec<f64>>, Failure> {
    // SAFETY: as the caller promises.
    let numbers = unsafe { copied(from, count) };
    let odd = |number: &f64| !number.is_finite();
    match numbers.as_deref().and_then(|all| all.iter().position(odd)) {
        None => Ok(numbers),
        Some(place) => {
            let number = numbers.map_or(f64::NAN, |numbers| numbers[place]);
            let why = format!("mesh.{name}[{place}] is {number}, must be finite");
            Err(Failure::new(FailureKind::NotFinite, why))
        }
    }
}

impl Mesh {
    /// Nothing yet.
    pub(crate) fn empty() -> Mesh {
        Mesh {
            node_count: 0,
            node_position: std::ptr::null(),
            simplex_count: 0,
            simplex_nodes: std::ptr::null(),
            simplex_position: std::ptr::null(),
            nodal_mass: std::ptr::null(),
            period: std::ptr::null(),
        }
    }

    /// Is it as it was given?
    pub(crate) fn is_untouched(&self) -> bool {
        let arrays = [
            self.node_position,
            self.simplex_position,
            self.nodal_mass,
            self.period,
        ];
        let none = arrays.iter().all(|array| array.is_null()) && self.simplex_nodes.is_null();
        none && (self.node_count, self.simplex_count) == (0, 0)
    }

    /// A copy of what the engine filled in, with what it left to us; the coupler checks the rest.
    ///
    /// # Safety
    ///
    /// Every pointer is null or points to as many numbers as the counts say.
    pub(crate) unsafe fn description(&self, d: usize) -> Result<MeshDescription, Failure> {
        const MOST: u64 = 1 << 28;
        if self.node_count > MOST || self.simplex_count > MOST {
            return Err(broken(format!(
                "{} nodes and {} simplices, at most {MOST} are possible",
                self.node_count, self.simplex_count
            )));
        }
        let (nodes, simplices) = (self.node_count as usize, self.simplex_count as usize);
        // SAFETY: as the caller promises.
        let (position, corners, unwrapped, mass, period) = unsafe {
            (
                finite("node_position", self.node_position, d * nodes)?,
                copied(self.simplex_nodes, (d + 1) * simplices),
                finite(
                    "simplex_position",
                    self.simplex_position,
                    d * (d + 1) * simplices,
                )?,
                finite("nodal_mass", self.nodal_mass, nodes)?,
                finite("period", self.period, d)?,
            )
        };
        let node_position = position.ok_or_else(|| broken("mesh.node_position was left NULL"))?;
        let corners = corners.ok_or_else(|| broken("mesh.simplex_nodes was left NULL"))?;
        if let Some(corner) = corners.iter().position(|&node| node as usize >= nodes) {
            let (simplex, node) = (corner / (d + 1), corners[corner]);
            return Err(broken(format!(
                "simplex {simplex} has node {node}, there are {nodes}"
            )));
        }
        let place = |&node: &u32| &node_position[d * node as usize..d * (node as usize + 1)];
        let at_nodes = || corners.iter().flat_map(place).copied().collect();
        let period = period.unwrap_or_else(|| vec![0.0; d]);
        let mut mesh = MeshDescription {
            dimension: d,
            simplex_position: unwrapped.unwrap_or_else(at_nodes),
            nodal_mass: mass.unwrap_or_default(),
            period: period
                .iter()
                .map(|&period| (period != 0.0).then_some(period))
                .collect(),
            simplex_nodes: corners,
            node_position,
            facets: FacetDescription::default(),
        };
        if let Some(turned) = (0..simplices).find(|&simplex| mesh.measure(simplex) <= 0.0) {
            return Err(broken(format!(
                "simplex {turned} has measure {:e} m^{d}: its corners must be positively oriented (in the plane counter-clockwise)",
                mesh.measure(turned)
            )));
        }
        if self.nodal_mass.is_null() {
            mesh.nodal_mass = equal_shares(&mesh, nodes);
        }
        Ok(mesh)
    }
}

/// Of each simplex, an equal part for each of its corners.
fn equal_shares(mesh: &MeshDescription, nodes: usize) -> Vec<f64> {
    let corners = mesh.dimension + 1;
    let mut mass = vec![0.0; nodes];
    for (simplex, nodes) in mesh.simplex_nodes.chunks_exact(corners).enumerate() {
        let share = mesh.measure(simplex) / corners as f64;
        nodes.iter().for_each(|&node| mass[node as usize] += share);
    }
    mass
}
