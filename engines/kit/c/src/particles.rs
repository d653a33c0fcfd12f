//! The particle seat.

use std::ffi::{c_char, c_void};
use std::path::Path;

use protocol::engine::{self, InitialGrains, ParticleEngine, serve_particles};
use protocol::ipc::engine_link;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind, Role};
use protocol::scene;

use crate::calls::{Border, missing};
use crate::handle::{Engine, Request, WRONG, guarded, handle};

/// A wall segment from a to b (m): grains stay on the left of a to b, and off both ends.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Wall {
    /// Start.
    pub a: [f64; 2],
    /// End.
    pub b: [f64; 2],
}

/// What a particle engine is configured with.
#[repr(C)]
#[derive(Debug)]
pub struct ParticleScene {
    /// g (m/s2); the engine applies the whole weight m g.
    pub gravity: [f64; 2],
    /// Period in x and y (m); 0: not periodic.
    pub period: [f64; 2],
    /// Number of walls.
    pub wall_count: u64,
    /// Walls.
    pub walls: *const Wall,
    /// Coulomb coefficient between grains.
    pub friction: f64,
    /// Coulomb coefficient between grains and walls.
    pub wall_friction: f64,
    /// Moment of inertia over m r2: 1/2 for disks, 2/5 for spheres.
    pub inertia_factor: f64,
    /// Contact residual at which a solve stops, relative to |g| dt.
    pub tolerance: f64,
    /// Sweeps allowed; more is an error.
    pub sweeps_max: u64,
    /// Sub-steps allowed in a step; more is an error.
    pub sub_steps_max: u32,
    /// Threads the engine may use.
    pub threads: u32,
}

/// The grains when a run begins. The engine may change the numbers, and lower `count` to run the
/// first ones only; the arrays stay the library's.
#[repr(C)]
#[derive(Debug)]
pub struct Grains {
    /// Number of grains.
    pub count: u64,
    /// Centres (m), 2 count numbers.
    pub position: *mut f64,
    /// Velocities (m/s), 2 count numbers.
    pub velocity: *mut f64,
    /// Radii (m).
    pub radius: *mut f64,
    /// Masses (kg; disks: kg per metre of depth).
    pub mass: *mut f64,
    /// Volumes (m3; disks: m2).
    pub volume: *mut f64,
    /// 1 for a grain that never moves, else 0.
    pub fixed: *mut f64,
}

/// What the fluid does to the grains over a step; NULL: zero.
#[repr(C)]
#[derive(Debug)]
pub struct FluidForces {
    /// Number of grains.
    pub count: u64,
    /// Drag coefficient (kg/s), constant over the step, to be taken implicitly: the drag on a grain is
    /// -drag v.
    pub drag: *const f64,
    /// Force that does not depend on the grain's velocity (N), 2 count numbers.
    pub force: *const f64,
}

/// The candidate, to be filled: every number is NaN before, and refused if it stays so.
#[repr(C)]
#[derive(Debug)]
pub struct GrainAnswer {
    /// Number of grains.
    pub count: u64,
    /// Centres at the end of the step (m), 2 count numbers.
    pub position: *mut f64,
    /// Velocities at the end of the step (m/s), 2 count numbers.
    pub velocity: *mut f64,
    /// Displacement over the step divided by dt (m/s), 2 count numbers.
    pub mean_velocity: *mut f64,
    /// 0: free, 1: touches, 2: held by a wall or a fixed grain (where SILLAGE_CONTACT_STATE is
    /// declared).
    pub contact: *mut f64,
}

/// The functions of a particle engine. Each returns 0, or what sillage_fail() returned. `user` is
/// what was given to sillage_run_particles(). `save` and `restore` may be NULL where
/// SILLAGE_CHECKPOINT is not declared; the others may not.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ParticleCalls {
    /// Take the scene and the grains.
    pub configure: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            scene: *const ParticleScene,
            grains: *mut Grains,
        ) -> i32,
    >,
    /// Compute a candidate from the accepted state, which must not change.
    pub advance: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            request: *const Request,
            fluid: *const FluidForces,
            answer: *const GrainAnswer,
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

/// Take the particle seat of the run that the environment names, serve the coupler until the run is
/// over, and return the exit code for the process (0, or 2 to 8: protocol/README.md); -1 when the
/// arguments are not usable. Blocks. To be called once in a process, from its first thread, before
/// others are started.
///
/// # Safety
///
/// `engine` came from sillage_engine_new() and is not freed before this returns; `calls` points to
/// functions that keep what this header says; `user` is passed on untouched.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sillage_run_particles(
    engine: *mut Engine,
    calls: *const ParticleCalls,
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
        border.run(Role::Particles, given, |run| {
            let mut foreign = Foreign { border, calls };
            serve_particles(&mut foreign, engine_link(run, Role::Particles)?)
        })
    })
}

/// The engine behind the border.
struct Foreign<'a> {
    border: Border<'a>,
    calls: ParticleCalls,
}

pub(crate) fn or_null(values: Option<&[f64]>) -> *const f64 {
    values.map_or(std::ptr::null(), <[f64]>::as_ptr)
}

impl ParticleEngine for Foreign<'_> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.border.this.identity()
    }

    fn capabilities(&self) -> Vec<Capability> {
        self.border.this.capabilities()
    }

    fn configure(
        &mut self,
        scene: &scene::ParticleScene,
        mut grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        let configure = self.calls.configure.ok_or_else(|| missing("configure"))?;
        let walls: Vec<Wall> = scene
            .walls
            .iter()
            .map(|wall| Wall {
                a: wall.a,
                b: wall.b,
            })
            .collect();
        let scene = ParticleScene {
            gravity: scene.gravity,
            period: scene.period.map(|period| period.unwrap_or(0.0)),
            wall_count: walls.len() as u64,
            walls: walls.as_ptr(),
            friction: scene.friction,
            wall_friction: scene.wall_friction,
            inertia_factor: scene.inertia_factor,
            tolerance: scene.tolerance,
            sweeps_max: scene.sweeps_max as u64,
            sub_steps_max: scene.sub_steps_max,
            threads: u32::try_from(scene.threads).unwrap_or(u32::MAX),
        };
        let given = grains.radius.len();
        let mut view = Grains {
            count: given as u64,
            position: grains.position.as_mut_ptr(),
            velocity: grains.velocity.as_mut_ptr(),
            radius: grains.radius.as_mut_ptr(),
            mass: grains.mass.as_mut_ptr(),
            volume: grains.volume.as_mut_ptr(),
            fixed: grains.fixed.as_mut_ptr(),
        };
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("configure", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe { configure(engine, user, &raw const scene, &raw mut view) }
        })?;
        if view.count > given as u64 {
            let why = format!("configure set {} grains, {given} were given", view.count);
            return Err(Failure::new(FailureKind::Engine, why));
        }
        let kept = view.count as usize;
        for vector in [&mut grains.position, &mut grains.velocity] {
            vector.truncate(2 * kept);
        }
        for scalar in [
            &mut grains.radius,
            &mut grains.mass,
            &mut grains.volume,
            &mut grains.fixed,
        ] {
            scalar.truncate(kept);
        }
        Ok(grains)
    }

    fn advance(
        &mut self,
        request: &Advance,
        fluid: &engine::FluidForces<'_>,
        answer: engine::GrainAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        let advance = self.calls.advance.ok_or_else(|| missing("advance"))?;
        let count = answer.contact.len() as u64;
        let request = Request::of(request);
        let fluid = FluidForces {
            count,
            drag: or_null(fluid.drag),
            force: or_null(fluid.force),
        };
        let answer = GrainAnswer {
            count,
            position: answer.position.as_mut_ptr(),
            velocity: answer.velocity.as_mut_ptr(),
            mean_velocity: answer.mean_velocity.as_mut_ptr(),
            contact: answer.contact.as_mut_ptr(),
        };
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("advance", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe {
                advance(
                    engine,
                    user,
                    &raw const request,
                    &raw const fluid,
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
