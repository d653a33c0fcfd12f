//! Everything that can go wrong in the fluid engine, with the number, the bound and the place.

use std::path::PathBuf;

use space::Vector;

/// An error of the fluid engine.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FluidError {
    /// A mesh file cannot be used.
    #[error(transparent)]
    MeshFile(#[from] gmsh::Error),
    /// The mesh as a whole is unusable.
    #[error("mesh: {0}")]
    Mesh(String),
    /// Cells as small as asked are more than there is room for.
    #[error(
        "mesh: cells as small as asked for are more than {most} {simplex}s: ask for larger ones, or for small ones in \
         fewer places"
    )]
    TooFine {
        /// What they are called.
        simplex: &'static str,
        /// How many there may be.
        most: usize,
    },
    /// A simplex is degenerate or left-handed (clockwise).
    #[error(
        "mesh: {simplex} {number} with corners ({corners}) has the signed {measure} {volume:e} {unit}; \
         corners must be counter-clockwise and the {measure} positive"
    )]
    InvertedSimplex {
        /// What it is called.
        simplex: &'static str,
        /// Its number (Gmsh: element tag).
        number: usize,
        /// Its corners \[m\].
        corners: String,
        /// What its size is called.
        measure: &'static str,
        /// Signed size.
        volume: f64,
        /// Unit of that.
        unit: &'static str,
    },
    /// A facet of the boundary belongs to no named boundary.
    #[error(
        "mesh: the boundary {facet} from {corners} belongs to no named boundary; \
         give its curve one of the physical names {names:?} or a new one"
    )]
    UnnamedFacet {
        /// What it is called.
        facet: &'static str,
        /// Its corners \[m\].
        corners: String,
        /// Names of the mesh.
        names: Vec<String>,
    },
    /// A facet belongs to two named boundaries.
    #[error(
        "mesh: the {facet} from {corners} belongs to two boundaries, {first:?} and {second:?}; \
         every boundary {facet} needs exactly one name"
    )]
    FacetInTwoBoundaries {
        /// What it is called.
        facet: &'static str,
        /// Its corners \[m\].
        corners: String,
        /// One name.
        first: String,
        /// The other name.
        second: String,
    },
    /// A condition names a boundary that the mesh does not have.
    #[error("boundary {name:?} is not in the mesh; its boundaries are {allowed:?}, or \"all\"")]
    UnknownBoundary {
        /// The name.
        name: String,
        /// Names of the mesh.
        allowed: Vec<String>,
    },
    /// A boundary of the mesh has no condition.
    #[error(
        "boundary {name:?} has no condition; allowed are no-slip, slip, inflow, open and periodic"
    )]
    MissingCondition {
        /// The name.
        name: String,
    },
    /// A condition that cannot be imposed.
    #[error("boundary {name:?}: {why}")]
    Boundary {
        /// The name.
        name: String,
        /// Why not, and what is allowed.
        why: String,
    },
    /// A closed domain into which more flows than out of it.
    #[error(
        "closed domain: the given velocities bring in {net:e} m²/s net, {relative:.3} of what crosses the \
         boundary; at most 0.01 (what interpolation leaves) is allowed without an open boundary"
    )]
    Unbalanced {
        /// Net inflow \[m²/s\].
        net: f64,
        /// Net over absolute flux.
        relative: f64,
    },
    /// A parameter out of range.
    #[error("{name} = {value:e}: {why}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The bound.
        why: &'static str,
    },
    /// A field with the wrong number of values.
    #[error("field {field}: {got} values for {expected} expected")]
    Shape {
        /// Its name.
        field: &'static str,
        /// How many came.
        got: usize,
        /// How many the mesh needs.
        expected: usize,
    },
    /// Porosity not positive at a node.
    #[error(
        "porosity {value:e} at node {node} ({place}) must be positive: too many grains there for the mesh; use larger cells or fewer grains"
    )]
    Porosity {
        /// The node.
        node: usize,
        /// Its position.
        place: String,
        /// The value.
        value: f64,
    },
    /// A value that is not finite.
    #[error("{what} is {value} at node {node} ({place})")]
    NotFinite {
        /// Which field.
        what: &'static str,
        /// The node.
        node: usize,
        /// Its position.
        place: String,
        /// The value.
        value: f64,
    },
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Threads(String),
    /// The factorisation broke down.
    #[error("linear solver: {0}")]
    Factorisation(String),
    /// The refined solution is not accurate enough.
    #[error("linear solver: backward error {residual:e} after {solves} solves, bound {bound:e}")]
    LinearResidual {
        /// Componentwise backward error.
        residual: f64,
        /// Solves with the last factor.
        solves: usize,
        /// The bound.
        bound: f64,
    },
    /// The iterative solver did not converge, and a direct factor does not fit.
    #[error(
        "linear solver: relative residual {residual:e} after {iterations} iterations, tolerance {tolerance:e}; \
         {nodes} nodes are too many for a direct factor, which takes up to {most}"
    )]
    Krylov {
        /// Relative residual reached.
        residual: f64,
        /// Iterations done, of all preconditioners.
        iterations: usize,
        /// The tolerance.
        tolerance: f64,
        /// Nodes of the mesh.
        nodes: usize,
        /// Most nodes that a direct factor takes.
        most: usize,
    },
    /// The nonlinear iteration did not converge.
    #[error(
        "nonlinear solve: relative residual {residual:e} after {iterations} iterations, tolerance {tolerance:e}"
    )]
    NotConverged {
        /// Relative residual.
        residual: f64,
        /// Iterations done.
        iterations: usize,
        /// The tolerance.
        tolerance: f64,
    },
    /// `commit` without a candidate.
    #[error("commit without a candidate: advance first")]
    NoCandidate,
    /// A checkpoint that cannot be written, read or used here.
    #[error("checkpoint {path}: {why}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// Why not.
        why: String,
    },
}

/// Corners as they are printed: `[0.0, 1.0] to [2.0, 3.0]`.
pub(crate) fn places<const D: usize>(corners: &[Vector<D>], between: &str) -> String {
    let corners: Vec<String> = corners
        .iter()
        .map(|x| format!("{:?}", x.as_slice()))
        .collect();
    corners.join(between)
}

/// A point as it is printed: `1e-3 m, 2e0 m`.
pub(crate) fn place<const D: usize>(point: &Vector<D>) -> String {
    let components: Vec<String> = point.iter().map(|x| format!("{x:e} m")).collect();
    components.join(", ")
}
