//! The fluid seat.

use std::ffi::{CString, c_char, c_void};
use std::path::Path;

use protocol::engine::{self, FluidEngine, MeshDescription, serve_fluid};
use protocol::ipc::engine_link;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind, Role};
use protocol::scene::{
    self, Convection, Diagonals, MeshSource, Nonlinear, Profile, TimeScheme, ViscousForm,
};

use crate::calls::{Border, missing};
use crate::handle::{Engine, Request, WRONG, guarded, handle};
use crate::particles::or_null;

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
    /// Its name: left, right, bottom, top of a rectangle, or the mesh's.
    pub name: *const c_char,
    /// One of SILLAGE_NO_SLIP, SILLAGE_SLIP, SILLAGE_PERIODIC, SILLAGE_INFLOW_UNIFORM,
    /// SILLAGE_INFLOW_PARABOLIC, SILLAGE_OPEN.
    pub condition: u32,
    /// Velocity of an inflow (m/s).
    pub velocity: [f64; 2],
    /// Pressure of an open boundary (Pa).
    pub pressure: f64,
}

/// What a fluid engine is configured with.
#[repr(C)]
#[derive(Debug)]
pub struct FluidScene {
    /// Density (kg/m3).
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    pub dynamic_viscosity: f64,
    /// g (m/s2).
    pub gravity: [f64; 2],
    /// A Gmsh 4.1 file; NULL: a rectangle.
    pub mesh_file: *const c_char,
    /// Rectangle: lower left corner (m).
    pub lower: [f64; 2],
    /// Rectangle: upper right corner (m).
    pub upper: [f64; 2],
    /// Rectangle: cells in x and y, two triangles each.
    pub cells: [u64; 2],
    /// Rectangle: ratio of the largest to the smallest cell in x and y, both ends refined.
    pub grading: [f64; 2],
    /// Rectangle: 0: diagonals alternate from cell to cell, 1: all the same.
    pub uniform_diagonals: u32,
    /// Number of boundaries.
    pub boundary_count: u32,
    /// Boundaries.
    pub boundaries: *const Boundary,
    /// 0: creeping flow, no v.grad v.
    pub convection: u32,
    /// One of SILLAGE_BACKWARD_EULER, SILLAGE_BDF2, SILLAGE_STEADY.
    pub time_scheme: u32,
    /// Newton to this relative residual within a step; 0: one linear solve.
    pub newton_tolerance: f64,
    /// Iterations of Newton allowed.
    pub newton_iterations_max: u64,
    /// 0: -div(2 mu phi D(v)), 1: the paper's three terms as printed.
    pub paper_literal_viscosity: u32,
    /// Threads the engine may use.
    pub threads: u32,
    /// Factor of a grad-div stabilisation.
    pub grad_div: f64,
    /// Uniform initial superficial velocity (m/s).
    pub initial_velocity: [f64; 2],
}

/// The mesh, to be filled by configure(): pointers to the engine's arrays, which must stay until it
/// has returned. Every pointer is NULL before.
#[repr(C)]
#[derive(Debug)]
pub struct Mesh {
    /// Number of nodes.
    pub node_count: u64,
    /// Node coordinates (m), 2 node_count numbers.
    pub node_position: *const f64,
    /// Number of triangles.
    pub triangle_count: u64,
    /// Nodes of each triangle, counter-clockwise, 3 triangle_count numbers.
    pub triangles: *const u32,
    /// Corner coordinates of each triangle (m), unwrapped across periodic sides, 6 triangle_count
    /// numbers; NULL: those of its nodes.
    pub triangle_position: *const f64,
    /// Integral of each node's shape function (m2); NULL: a third of its triangles.
    pub nodal_mass: *const f64,
    /// Period in x and y (m); 0: not periodic.
    pub period: [f64; 2],
}

/// What the coupler tells about the grains, at the nodes; NULL: porosity 1, all others 0.
#[repr(C)]
#[derive(Debug)]
pub struct SolidResponse {
    /// Number of nodes.
    pub count: u64,
    /// Porosity phi.
    pub porosity: *const f64,
    /// Drag beta (kg/(m3 s)).
    pub drag: *const f64,
    /// Drag source s (N/m3), 2 count numbers.
    pub drag_source: *const f64,
    /// Entrained solid fraction c.
    pub entrained_fraction: *const f64,
    /// Solid flux (m/s), 2 count numbers.
    pub solid_flux: *const f64,
    /// Solid mobility kappa (m3 s/kg).
    pub solid_mobility: *const f64,
}

/// The candidate, to be filled: every number is NaN before, and refused if it stays so.
#[repr(C)]
#[derive(Debug)]
pub struct FluidAnswer {
    /// Number of nodes.
    pub count: u64,
    /// Interstitial velocity u/phi (m/s), 2 count numbers.
    pub interstitial_velocity: *mut f64,
    /// Pressure gradient averaged with each node's shape function (Pa/m), 2 count numbers.
    pub pressure_gradient: *mut f64,
    /// Pressure (Pa).
    pub pressure: *mut f64,
}

/// The functions of a fluid engine. Each returns 0, or what sillage_fail() returned. `user` is what
/// was given to sillage_run_fluid(). `save` and `restore` may be NULL where SILLAGE_CHECKPOINT is not
/// declared; the others may not.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct FluidCalls {
    /// Take the scene, build the mesh, fill it in.
    pub configure: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            scene: *const FluidScene,
            mesh: *mut Mesh,
        ) -> i32,
    >,
    /// Compute a candidate from the accepted state, which must not change.
    pub advance: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            request: *const Request,
            solid: *const SolidResponse,
            answer: *const FluidAnswer,
        ) -> i32,
    >,
    /// The last candidate becomes the accepted state.
    pub commit: Option<unsafe extern "C" fn(engine: *mut Engine, user: *mut c_void) -> i32>,
    /// Write the accepted state to a file.
    pub save: Option<
        unsafe extern "C" fn(engine: *mut Engine, user: *mut c_void, path: *const c_char) -> i32,
    >,
    /// Read the accepted state from a file.
    pub restore: Option<
        unsafe extern "C" fn(engine: *mut Engine, user: *mut c_void, path: *const c_char) -> i32,
    >,
}

/// Take the fluid seat of the run that the environment names, serve the coupler until the run is
/// over, and return the exit code for the process (0, or 2 to 8: protocol/README.md); -1 when the
/// arguments are not usable. Blocks. To be called once in a process, from its first thread, before
/// others are started.
///
/// # Safety
///
/// `engine` came from sillage_engine_new() and is not freed before this returns; `calls` points to
/// functions that keep what this header says; `user` is passed on untouched.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_run_fluid(
    engine: *mut Engine,
    calls: *const FluidCalls,
    user: *mut c_void,
) -> i32 {
    guarded(WRONG, || {
        // SAFETY: as the caller promises.
        let (this, calls) = unsafe { (handle(engine)?, calls.as_ref()) };
        let calls = *calls.ok_or("calls is a null pointer")?;
        let border = Border {
            this,
            engine,
            user,
            commit: calls.commit,
            save: calls.save,
            restore: calls.restore,
        };
        let given = (calls.configure.is_some(), calls.advance.is_some());
        border.run(Role::Fluid, given, |run| {
            let mut foreign = Foreign { border, calls };
            serve_fluid(&mut foreign, engine_link(run, Role::Fluid)?)
        })
    })
}

/// The engine behind the border.
struct Foreign<'a> {
    border: Border<'a>,
    calls: FluidCalls,
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

impl Mesh {
    /// A copy of what the engine filled in, with what it left to us; the coupler checks the rest.
    ///
    /// # Safety
    ///
    /// Every pointer is null or points to as many numbers as the counts say.
    unsafe fn description(&self) -> Result<MeshDescription, Failure> {
        const MOST: u64 = 1 << 28;
        if self.node_count > MOST || self.triangle_count > MOST {
            return Err(broken(format!(
                "{} nodes and {} triangles, at most {MOST} are possible",
                self.node_count, self.triangle_count
            )));
        }
        let (nodes, triangles) = (self.node_count as usize, self.triangle_count as usize);
        // SAFETY: as the caller promises.
        let (position, corners, unwrapped, mass) = unsafe {
            (
                copied(self.node_position, 2 * nodes),
                copied(self.triangles, 3 * triangles),
                copied(self.triangle_position, 6 * triangles),
                copied(self.nodal_mass, nodes),
            )
        };
        let node_position = position.ok_or_else(|| broken("mesh.node_position was left NULL"))?;
        let corners = corners.ok_or_else(|| broken("mesh.triangles was left NULL"))?;
        let triangles = corners.as_chunks::<3>().0.to_vec();
        if let Some(corner) = corners.iter().position(|&node| node as usize >= nodes) {
            let (triangle, node) = (corner / 3, corners[corner]);
            return Err(broken(format!(
                "triangle {triangle} has node {node}, there are {nodes}"
            )));
        }
        let place = |node: u32| [0, 1].map(|axis| node_position[2 * node as usize + axis]);
        let triangle_position: Vec<[f64; 6]> = match unwrapped {
            Some(numbers) => numbers.as_chunks::<6>().0.to_vec(),
            None => triangles
                .iter()
                .map(|nodes| {
                    let [p, q, r] = nodes.map(place);
                    [p[0], p[1], q[0], q[1], r[0], r[1]]
                })
                .collect(),
        };
        let nodal_mass = mass.unwrap_or_else(|| {
            let mut mass = vec![0.0; nodes];
            for (nodes, p) in triangles.iter().zip(&triangle_position) {
                let twice = (p[2] - p[0]) * (p[5] - p[1]) - (p[4] - p[0]) * (p[3] - p[1]);
                nodes
                    .iter()
                    .for_each(|&node| mass[node as usize] += twice / 6.0);
            }
            mass
        });
        Ok(MeshDescription {
            node_position,
            triangles,
            triangle_position,
            nodal_mass,
            period: self.period.map(|period| (period != 0.0).then_some(period)),
        })
    }
}

/// A text for C; what it cannot hold is cut out.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

fn boundary(name: &CString, condition: &scene::Boundary) -> Boundary {
    let (condition, velocity, pressure) = match condition {
        scene::Boundary::NoSlip => (SILLAGE_NO_SLIP, [0.0; 2], 0.0),
        scene::Boundary::Slip => (SILLAGE_SLIP, [0.0; 2], 0.0),
        scene::Boundary::Periodic => (SILLAGE_PERIODIC, [0.0; 2], 0.0),
        scene::Boundary::Inflow { velocity, profile } => match profile {
            Profile::Uniform => (SILLAGE_INFLOW_UNIFORM, *velocity, 0.0),
            Profile::Parabolic => (SILLAGE_INFLOW_PARABOLIC, *velocity, 0.0),
        },
        scene::Boundary::Open { pressure } => (SILLAGE_OPEN, [0.0; 2], *pressure),
    };
    Boundary {
        name: name.as_ptr(),
        condition,
        velocity,
        pressure,
    }
}

impl FluidEngine for Foreign<'_> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.border.this.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.border.this.capabilities()
    }

    fn configure(&mut self, scene: &scene::FluidScene) -> Result<MeshDescription, Failure> {
        let configure = self.calls.configure.ok_or_else(|| missing("configure"))?;
        let names: Vec<CString> = scene.boundaries.keys().map(|name| c_text(name)).collect();
        let conditions = names.iter().zip(scene.boundaries.values());
        let boundaries: Vec<Boundary> = conditions
            .map(|(name, condition)| boundary(name, condition))
            .collect();
        let file = match &scene.mesh {
            MeshSource::File { path } => Some(c_text(path)),
            MeshSource::Rectangle { .. } => None,
        };
        let (newton_tolerance, newton_iterations_max) = match scene.nonlinear {
            Nonlinear::Picard => (0.0, 0),
            Nonlinear::Newton {
                tolerance,
                iterations_max,
            } => (tolerance, iterations_max as u64),
        };
        let mut view = FluidScene {
            density: scene.density,
            dynamic_viscosity: scene.dynamic_viscosity,
            gravity: scene.gravity,
            mesh_file: file.as_ref().map_or(std::ptr::null(), |file| file.as_ptr()),
            lower: [0.0; 2],
            upper: [0.0; 2],
            cells: [0; 2],
            grading: [1.0; 2],
            uniform_diagonals: 0,
            boundary_count: boundaries.len() as u32,
            boundaries: boundaries.as_ptr(),
            convection: u32::from(scene.convection != Convection::Never),
            time_scheme: match scene.time_scheme {
                TimeScheme::BackwardEuler => SILLAGE_BACKWARD_EULER,
                TimeScheme::Bdf2 => SILLAGE_BDF2,
                TimeScheme::Steady => SILLAGE_STEADY,
            },
            newton_tolerance,
            newton_iterations_max,
            paper_literal_viscosity: u32::from(scene.viscous_form == ViscousForm::PaperLiteral),
            threads: u32::try_from(scene.threads).unwrap_or(u32::MAX),
            grad_div: scene.grad_div,
            initial_velocity: scene.initial_velocity,
        };
        if let MeshSource::Rectangle {
            lower,
            upper,
            cells,
            diagonals,
            grading,
        } = scene.mesh
        {
            (view.lower, view.upper, view.grading) = (lower, upper, grading);
            view.cells = cells.map(|cells| cells as u64);
            view.uniform_diagonals = u32::from(diagonals == Diagonals::Uniform);
        }
        let mut mesh = Mesh {
            node_count: 0,
            node_position: std::ptr::null(),
            triangle_count: 0,
            triangles: std::ptr::null(),
            triangle_position: std::ptr::null(),
            nodal_mass: std::ptr::null(),
            period: [0.0; 2],
        };
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("configure", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe { configure(engine, user, &raw const view, &raw mut mesh) }
        })?;
        // SAFETY: the engine filled it in as the header asks.
        unsafe { mesh.description() }
    }

    fn advance(
        &mut self,
        request: &Advance,
        solid: &engine::SolidResponse<'_>,
        answer: engine::FluidAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        let advance = self.calls.advance.ok_or_else(|| missing("advance"))?;
        let count = answer.pressure.len() as u64;
        let request = Request::of(request);
        let solid = SolidResponse {
            count,
            porosity: or_null(solid.porosity),
            drag: or_null(solid.drag),
            drag_source: or_null(solid.drag_source),
            entrained_fraction: or_null(solid.entrained_fraction),
            solid_flux: or_null(solid.solid_flux),
            solid_mobility: or_null(solid.solid_mobility),
        };
        let answer = FluidAnswer {
            count,
            interstitial_velocity: answer.interstitial_velocity.as_mut_ptr(),
            pressure_gradient: answer.pressure_gradient.as_mut_ptr(),
            pressure: answer.pressure.as_mut_ptr(),
        };
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("advance", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe {
                advance(
                    engine,
                    user,
                    &raw const request,
                    &raw const solid,
                    &raw const answer,
                )
            }
        })
    }

    fn commit(&mut self) -> Result<(), Failure> {
        self.border.commit()
    }

    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.border.save(path)
    }

    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.border.restore(path)
    }
}
