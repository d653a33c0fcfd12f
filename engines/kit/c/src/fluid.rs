//! The fluid seat.

use std::ffi::{c_char, c_void};
use std::path::Path;

use protocol::engine::{self, Computed, FluidEngine, MeshDescription, serve_fluid};
use protocol::ipc::engine_link;
use protocol::message::{Advance, Capability, Failure, Role};
use protocol::report;
use protocol::scene::{self, Refinement};

use crate::calls::{Border, missing};
use crate::exchange::{Inputs, Outputs};
use crate::handle::{Engine, Request, WRONG, guarded, handle};
use crate::mesh::Mesh;
use crate::scene::{FluidScene, View};
use crate::sizes::{Sizes, SizesView};

/// What a fluid engine tells of a candidate. All may be left as they are: not known.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct FluidReport {
    /// Power of the solid's terms as the equations had them (W; in the plane W/m); NaN before.
    pub solid_power: f64,
    /// Reynolds number by which the engine judges whether convection matters; NaN before.
    pub reynolds: f64,
    /// Was v.grad v in the equations? 0, 1; -1 before.
    pub convects: i32,
}

impl FluidReport {
    const NOTHING: FluidReport = FluidReport {
        solid_power: f64::NAN,
        reynolds: f64::NAN,
        convects: -1,
    };

    fn report(&self) -> report::FluidReport {
        let told = |value: f64| (!value.is_nan()).then_some(value);
        report::FluidReport {
            solid_power: told(self.solid_power),
            reynolds: told(self.reynolds),
            convects: (self.convects >= 0).then_some(self.convects != 0),
        }
    }
}

/// The functions of a fluid engine. Each returns 0, or what sillage_fail() returned. `user` is what
/// was given to sillage_run_fluid(). `save` and `restore` may be NULL where SILLAGE_CHECKPOINT is not
/// declared, `adapt` where SILLAGE_ADAPTS is not; the others may not.
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
            inputs: *const Inputs,
            outputs: *const Outputs,
            report: *mut FluidReport,
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
    /// Before a step: change to a mesh with cells of these sizes, in place of all asked for before, carry
    /// the accepted state over to it, and fill it in as in configure(). The mesh must depend on the
    /// sizes and the scene alone, not on the meshes before. A mesh that is left as it was given: the
    /// engine keeps the one it has.
    pub adapt: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            sizes: *const Sizes,
            mesh: *mut Mesh,
        ) -> i32,
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
        let adapts = this.declares(Capability::Adapts);
        let own = [
            ("configure", calls.configure.is_some()),
            ("advance", calls.advance.is_some()),
            ("adapt", calls.adapt.is_some() || !adapts),
        ];
        border.run(Role::Fluid, &own, |run| {
            let mut foreign = Foreign {
                border,
                calls,
                dimension: 0,
            };
            serve_fluid(&mut foreign, engine_link(run, Role::Fluid)?)
        })
    })
}

/// The engine behind the border.
struct Foreign<'a> {
    border: Border<'a>,
    calls: FluidCalls,
    dimension: usize,
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
        let (view, mut mesh) = (View::of(scene), Mesh::empty());
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("configure", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe { configure(engine, user, &raw const view.scene, &raw mut mesh) }
        })?;
        self.dimension = scene.dimension;
        // SAFETY: the engine filled it in as the header asks.
        unsafe { mesh.description(scene.dimension) }
    }

    fn adapt(&mut self, sizes: &Refinement) -> Result<Option<MeshDescription>, Failure> {
        let adapt = self.calls.adapt.ok_or_else(|| missing("adapt"))?;
        let view = SizesView::of(sizes, self.dimension);
        let mut mesh = Mesh::empty();
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("adapt", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe { adapt(engine, user, &raw const view.sizes, &raw mut mesh) }
        })?;
        if mesh.is_untouched() {
            return Ok(None);
        }
        // SAFETY: the engine filled it in as the header asks.
        unsafe { mesh.description(self.dimension) }.map(Some)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &engine::Inputs<'_>,
        outputs: engine::Outputs<'_>,
    ) -> Result<Computed<report::FluidReport>, Failure> {
        let advance = self.calls.advance.ok_or_else(|| missing("advance"))?;
        let (outputs, count) = Outputs::of(outputs, self.dimension);
        let inputs = Inputs::of(inputs);
        let request = Request::of(request, count, self.dimension);
        let mut told = FluidReport::NOTHING;
        let (engine, user) = (self.border.engine, self.border.user);
        let diagnostics = self.border.this.call("advance", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe {
                advance(
                    engine,
                    user,
                    &raw const request,
                    &raw const inputs,
                    &raw const outputs,
                    &raw mut told,
                )
            }
        })?;
        Ok(Computed {
            report: told.report(),
            diagnostics,
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
