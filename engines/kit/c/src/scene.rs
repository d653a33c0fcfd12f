//! What a fluid engine is configured with.

use std::ffi::{CString, c_char};

use protocol::scene::{
    self, Convection, Diagonals, MeshSource, Nonlinear, Profile, TimeScheme, ViscousForm,
};

use crate::sizes::{Sizes, SizesView};

/// Boundary: u = 0.
pub const SILLAGE_NO_SLIP: u32 = 0;
/// Boundary: u.n = 0, no tangential traction.
pub const SILLAGE_SLIP: u32 = 1;
/// Boundary: joined with the opposite side.
pub const SILLAGE_PERIODIC: u32 = 2;
/// Boundary: superficial velocity given, the same everywhere.
pub const SILLAGE_INFLOW_UNIFORM: u32 = 3;
/// Boundary: superficial velocity given, zero at both ends and `velocity` in the middle.
pub const SILLAGE_INFLOW_PARABOLIC: u32 = 4;
/// Boundary: pressure given at its highest point, hydrostatic along it.
pub const SILLAGE_OPEN: u32 = 5;
/// Boundary: a wall that moves along itself, u = velocity.
pub const SILLAGE_MOVING_WALL: u32 = 6;

/// Time scheme: backward Euler.
pub const SILLAGE_BACKWARD_EULER: u32 = 0;
/// Time scheme: second order, the first step backward Euler.
pub const SILLAGE_BDF2: u32 = 1;
/// Time scheme: one advance() is the steady state.
pub const SILLAGE_STEADY: u32 = 2;

/// The condition on a named boundary. Velocities are superficial.
#[repr(C)]
#[derive(Debug)]
pub struct Boundary {
    /// Its name: left, right, bottom, top of a rectangle or box, back, front of a box, or the mesh's.
    pub name: *const c_char,
    /// One of SILLAGE_NO_SLIP, SILLAGE_SLIP, SILLAGE_PERIODIC, SILLAGE_INFLOW_UNIFORM,
    /// SILLAGE_INFLOW_PARABOLIC, SILLAGE_OPEN, SILLAGE_MOVING_WALL.
    pub condition: u32,
    /// Velocity of an inflow or a moving wall (m/s), `dimension` numbers; NULL where there is none.
    pub velocity: *const f64,
    /// Pressure of an open boundary (Pa).
    pub pressure: f64,
}

/// What a fluid engine is configured with. Vectors have `dimension` numbers.
#[repr(C)]
#[derive(Debug)]
pub struct FluidScene {
    /// Dimension of the space, 2 or 3. An engine that cannot do it fails with SILLAGE_FAILURE_SCENE.
    pub dimension: u32,
    /// Number of boundaries.
    pub boundary_count: u32,
    /// Boundaries.
    pub boundaries: *const Boundary,
    /// Density (kg/m3).
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    pub dynamic_viscosity: f64,
    /// g (m/s2), a vector.
    pub gravity: *const f64,
    /// A Gmsh file, 2.2 or 4.1, ASCII or binary; NULL: a rectangle, in space a box. See `mesh_scale` and `mesh_surfaces`.
    pub mesh_file: *const c_char,
    /// Rectangle or box: corner with the lowest coordinates (m), a vector; NULL with a file.
    pub lower: *const f64,
    /// Rectangle or box: corner with the highest coordinates (m), a vector; NULL with a file.
    pub upper: *const f64,
    /// Rectangle or box: cells along each axis, two triangles or six tetrahedra each; NULL with a file.
    pub cells: *const u64,
    /// Rectangle: ratio of the largest to the smallest cell along each axis, both ends refined; a box has
    /// 1; NULL with a file.
    pub grading: *const f64,
    /// Rectangle: 0: diagonals alternate from cell to cell, 1: all the same, as in a box.
    pub uniform_diagonals: u32,
    /// 0: creeping flow, no v.grad v.
    pub convection: u32,
    /// One of SILLAGE_BACKWARD_EULER, SILLAGE_BDF2, SILLAGE_STEADY.
    pub time_scheme: u32,
    /// 0: -div(2 mu phi D(v)), 1: the paper's three terms as printed.
    pub paper_literal_viscosity: u32,
    /// Newton to this relative residual within a step; 0: one linear solve.
    pub newton_tolerance: f64,
    /// Iterations of Newton allowed.
    pub newton_iterations_max: u64,
    /// Factor of a grad-div stabilisation.
    pub grad_div: f64,
    /// Uniform initial superficial velocity (m/s), a vector.
    pub initial_velocity: *const f64,
    /// Threads the engine may use.
    pub threads: u32,
    /// Number of surfaces; 0: the file has one.
    pub mesh_surface_count: u32,
    /// Surfaces of the file that are filled, by name or number.
    pub mesh_surfaces: *const *const c_char,
    /// Metres of a unit of the file.
    pub mesh_scale: f64,
    /// How large the cells of the first mesh are to be; NULL: as they stand here. Only where
    /// SILLAGE_ADAPTS is declared.
    pub refinement: *const Sizes,
}

/// A scene for C, with what its pointers point to.
pub(crate) struct View {
    pub(crate) scene: FluidScene,
    _names: Vec<CString>,
    _boundaries: Vec<Boundary>,
    _file: Option<CString>,
    _surfaces: (Vec<CString>, Vec<*const c_char>),
    _cells: Vec<u64>,
    _refinement: Vec<SizesView>,
}

impl View {
    /// Valid as long as both it and `scene` are.
    pub(crate) fn of(scene: &scene::FluidScene) -> View {
        let names: Vec<CString> = scene.boundaries.keys().map(|name| c_text(name)).collect();
        let conditions = names.iter().zip(scene.boundaries.values());
        let boundaries: Vec<Boundary> = conditions
            .map(|(name, condition)| boundary(name, condition))
            .collect();
        let (file, rectangle) = match &scene.mesh {
            MeshSource::File { path, .. } => (Some(c_text(path)), None),
            MeshSource::Rectangle {
                lower,
                upper,
                cells,
                diagonals,
                grading,
            } => (None, Some((lower, upper, cells, *diagonals, &grading[..]))),
            MeshSource::Box {
                lower,
                upper,
                cells,
            } => (
                None,
                Some((lower, upper, cells, Diagonals::Uniform, &[1.0; 3][..])),
            ),
        };
        let cells: Vec<u64> = rectangle.map_or_else(Vec::new, |(_, _, cells, ..)| {
            cells.iter().map(|&cells| cells as u64).collect()
        });
        let surfaces = surfaces(&scene.mesh);
        let refinement: Vec<SizesView> = scene
            .refinement
            .iter()
            .map(|sizes| SizesView::of(sizes, scene.dimension))
            .collect();
        let mut view = plain(scene);
        view.refinement = refinement
            .first()
            .map_or(std::ptr::null(), |view| &raw const view.sizes);
        (view.mesh_surface_count, view.mesh_surfaces) =
            (surfaces.1.len() as u32, surfaces.1.as_ptr());
        (view.boundary_count, view.boundaries) = (boundaries.len() as u32, boundaries.as_ptr());
        view.mesh_file = file.as_ref().map_or(std::ptr::null(), |file| file.as_ptr());
        if let Some((lower, upper, _, diagonals, grading)) = rectangle {
            (view.lower, view.upper) = (lower.as_ptr(), upper.as_ptr());
            (view.cells, view.grading) = (cells.as_ptr(), grading.as_ptr());
            view.uniform_diagonals = u32::from(diagonals == Diagonals::Uniform);
        }
        View {
            scene: view,
            _names: names,
            _boundaries: boundaries,
            _file: file,
            _surfaces: surfaces,
            _cells: cells,
            _refinement: refinement,
        }
    }
}

/// What needs no memory of its own.
fn plain(scene: &scene::FluidScene) -> FluidScene {
    let (newton_tolerance, newton_iterations_max) = match scene.nonlinear {
        Nonlinear::Picard => (0.0, 0),
        Nonlinear::Newton {
            tolerance,
            iterations_max,
        } => (tolerance, iterations_max as u64),
    };
    FluidScene {
        dimension: scene.dimension as u32,
        boundary_count: 0,
        boundaries: std::ptr::null(),
        density: scene.density,
        dynamic_viscosity: scene.dynamic_viscosity,
        gravity: scene.gravity.as_ptr(),
        mesh_file: std::ptr::null(),
        lower: std::ptr::null(),
        upper: std::ptr::null(),
        cells: std::ptr::null(),
        grading: std::ptr::null(),
        uniform_diagonals: 0,
        convection: u32::from(scene.convection != Convection::Never),
        time_scheme: match scene.time_scheme {
            TimeScheme::BackwardEuler => SILLAGE_BACKWARD_EULER,
            TimeScheme::Bdf2 => SILLAGE_BDF2,
            TimeScheme::Steady => SILLAGE_STEADY,
        },
        paper_literal_viscosity: u32::from(scene.viscous_form == ViscousForm::PaperLiteral),
        newton_tolerance,
        newton_iterations_max,
        grad_div: scene.grad_div,
        initial_velocity: scene.initial_velocity.as_ptr(),
        threads: u32::try_from(scene.threads).unwrap_or(u32::MAX),
        mesh_surface_count: 0,
        mesh_surfaces: std::ptr::null(),
        mesh_scale: match scene.mesh {
            MeshSource::File { scale, .. } => scale,
            MeshSource::Rectangle { .. } | MeshSource::Box { .. } => 1.0,
        },
        refinement: std::ptr::null(),
    }
}

/// Names of the surfaces of a file, and where each is.
fn surfaces(mesh: &MeshSource) -> (Vec<CString>, Vec<*const c_char>) {
    let names: Vec<CString> = match mesh {
        MeshSource::File { surfaces, .. } => surfaces.iter().map(|name| c_text(name)).collect(),
        MeshSource::Rectangle { .. } | MeshSource::Box { .. } => Vec::new(),
    };
    let places = names.iter().map(|name| name.as_ptr()).collect();
    (names, places)
}

/// A text for C; what it cannot hold is cut out.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

fn boundary(name: &CString, condition: &scene::Boundary) -> Boundary {
    let none = std::ptr::null();
    let (condition, velocity, pressure) = match condition {
        scene::Boundary::NoSlip => (SILLAGE_NO_SLIP, none, 0.0),
        scene::Boundary::Slip => (SILLAGE_SLIP, none, 0.0),
        scene::Boundary::Periodic => (SILLAGE_PERIODIC, none, 0.0),
        scene::Boundary::Inflow { velocity, profile } => match profile {
            Profile::Uniform => (SILLAGE_INFLOW_UNIFORM, velocity.as_ptr(), 0.0),
            Profile::Parabolic => (SILLAGE_INFLOW_PARABOLIC, velocity.as_ptr(), 0.0),
        },
        scene::Boundary::Open { pressure } => (SILLAGE_OPEN, none, *pressure),
        scene::Boundary::MovingWall { velocity } => (SILLAGE_MOVING_WALL, velocity.as_ptr(), 0.0),
    };
    Boundary {
        name: name.as_ptr(),
        condition,
        velocity,
        pressure,
    }
}
