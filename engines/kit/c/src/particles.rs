//! The particle seat.

use std::ffi::{c_char, c_void};
use std::path::Path;

use protocol::engine::{self, Computed, InitialGrains, ParticleEngine, serve_particles};
use protocol::field::Field;
use protocol::ipc::engine_link;
use protocol::message::{Advance, Capability, Failure, FailureKind, Role};
use protocol::{report, scene};

use crate::calls::{Border, missing};
use crate::exchange::{Inputs, Outputs};
use crate::handle::{Engine, Request, WRONG, guarded, handle};

/// What a particle engine is configured with.
#[repr(C)]
#[derive(Debug)]
pub struct ParticleScene {
    /// Dimension d of the space, 2 or 3. An engine that cannot do it fails with SILLAGE_FAILURE_SCENE.
    pub dimension: u32,
    /// Threads the engine may use.
    pub threads: u32,
    /// g (m/s2), d numbers; the engine applies the whole weight m g.
    pub gravity: *const f64,
    /// Period along each axis (m), d numbers; 0: not periodic.
    pub period: *const f64,
    /// Number of walls.
    pub wall_count: u64,
    /// Walls (m): d corners each, of d numbers. In the plane a segment from its first to its second
    /// corner: grains stay on the left of it, and off both ends. In space a triangle: grains stay on the
    /// side from which its corners are seen clockwise, and off its edges.
    pub walls: *const f64,
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
}

/// The grains when a run begins, or those that are left when others have gone. The arrays stay the
/// library's. In configure() the engine may change the numbers, and lower `count` to run the first ones
/// only.
#[repr(C)]
#[derive(Debug)]
pub struct Grains {
    /// Number of grains.
    pub count: u64,
    /// Centres (m), d count numbers.
    pub position: *mut f64,
    /// Velocities (m/s), d count numbers.
    pub velocity: *mut f64,
    /// Radii (m), of disks or spheres.
    pub radius: *mut f64,
    /// Masses (kg; disks: kg per metre of depth).
    pub mass: *mut f64,
    /// Volumes (m3; disks: m2).
    pub volume: *mut f64,
    /// 1 for a grain that never moves, else 0.
    pub fixed: *mut f64,
}

impl Grains {
    /// Valid as long as `grains` are and keep their numbers where they are.
    fn of(grains: &mut InitialGrains) -> Grains {
        Grains {
            count: grains.count() as u64,
            position: grains.position.as_mut_ptr(),
            velocity: grains.velocity.as_mut_ptr(),
            radius: grains.radius.as_mut_ptr(),
            mass: grains.mass.as_mut_ptr(),
            volume: grains.volume.as_mut_ptr(),
            fixed: grains.fixed.as_mut_ptr(),
        }
    }
}

/// What a particle engine tells of a candidate.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ParticleReport {
    /// Sub-steps that were taken: 0 before, which is refused, so it must be set.
    pub sub_steps: u32,
    /// Contacts that carry an impulse; -1 before: not known.
    pub touching: i64,
}

impl ParticleReport {
    const NOTHING: ParticleReport = ParticleReport {
        sub_steps: 0,
        touching: -1,
    };

    fn report(&self) -> Result<report::ParticleReport, Failure> {
        let report = report::ParticleReport::new(self.sub_steps).ok_or_else(|| {
            let why = "advance left report->sub_steps 0: it must tell how many it took";
            Failure::new(FailureKind::Engine, why)
        })?;
        Ok(report::ParticleReport {
            touching: u64::try_from(self.touching).ok(),
            ..report
        })
    }
}

/// The functions of a particle engine. Each returns 0, or what sillage_fail() returned. `user` is
/// what was given to sillage_run_particles(). `save` and `restore` may be NULL where
/// SILLAGE_CHECKPOINT is not declared, `remove` where SILLAGE_REMOVES_GRAINS is not; the others may not.
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
            inputs: *const Inputs,
            outputs: *const Outputs,
            report: *mut ParticleReport,
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
    /// Before a step: take `gone_count` grains out of the accepted state, by their numbers in the present
    /// order, ascending. The others keep their order; tell them in `left`, which has them already but for
    /// their positions and velocities in the accepted state, which are NaN before.
    pub remove: Option<
        unsafe extern "C" fn(
            engine: *mut Engine,
            user: *mut c_void,
            gone: *const u64,
            gone_count: u64,
            left: *mut Grains,
        ) -> i32,
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
        let removes = this.declares(Capability::RemovesGrains);
        let own = [
            ("configure", calls.configure.is_some()),
            ("advance", calls.advance.is_some()),
            ("remove", calls.remove.is_some() || !removes),
        ];
        border.run(Role::Particles, &own, |run| {
            let mut foreign = Foreign {
                border,
                calls,
                dimension: 0,
                grains: InitialGrains::default(),
            };
            serve_particles(&mut foreign, engine_link(run, Role::Particles)?)
        })
    })
}

/// The engine behind the border.
struct Foreign<'a> {
    border: Border<'a>,
    calls: ParticleCalls,
    dimension: usize,
    /// As they were told last.
    grains: InitialGrains,
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
        let corners = scene.walls.iter().flat_map(|wall| wall.corners.iter());
        let walls: Vec<f64> = corners.flatten().copied().collect();
        let period: Vec<f64> = scene.period.iter().map(|p| p.unwrap_or(0.0)).collect();
        self.dimension = scene.dimension;
        let scene = ParticleScene {
            dimension: scene.dimension as u32,
            threads: u32::try_from(scene.threads).unwrap_or(u32::MAX),
            gravity: scene.gravity.as_ptr(),
            period: period.as_ptr(),
            wall_count: scene.walls.len() as u64,
            walls: walls.as_ptr(),
            friction: scene.friction,
            wall_friction: scene.wall_friction,
            inertia_factor: scene.inertia_factor,
            tolerance: scene.tolerance,
            sweeps_max: scene.sweeps_max as u64,
            sub_steps_max: scene.sub_steps_max,
        };
        let given = grains.count();
        let mut view = Grains::of(&mut grains);
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
            vector.truncate(self.dimension * kept);
        }
        for scalar in [
            &mut grains.radius,
            &mut grains.mass,
            &mut grains.volume,
            &mut grains.fixed,
        ] {
            scalar.truncate(kept);
        }
        self.grains.clone_from(&grains);
        Ok(grains)
    }

    fn advance(
        &mut self,
        request: &Advance,
        inputs: &engine::Inputs<'_>,
        outputs: engine::Outputs<'_>,
    ) -> Result<Computed<report::ParticleReport>, Failure> {
        let advance = self.calls.advance.ok_or_else(|| missing("advance"))?;
        let (outputs, count) = Outputs::of(outputs, self.dimension);
        let inputs = Inputs::of(inputs);
        let request = Request::of(request, count, self.dimension);
        let mut told = ParticleReport::NOTHING;
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
            report: told.report()?,
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

    fn remove(&mut self, gone: &[usize]) -> Result<InitialGrains, Failure> {
        let remove = self.calls.remove.ok_or_else(|| missing("remove"))?;
        let mut left = self.grains.without(gone);
        for told in [&mut left.position, &mut left.velocity] {
            told.fill(f64::NAN);
        }
        let gone: Vec<u64> = gone.iter().map(|&grain| grain as u64).collect();
        let mut view = Grains::of(&mut left);
        let (engine, user) = (self.border.engine, self.border.user);
        self.border.this.call("remove", || {
            // SAFETY: the structures outlive the call and their arrays have the lengths they tell.
            unsafe {
                let count = gone.len() as u64;
                remove(engine, user, gone.as_ptr(), count, &raw mut view)
            }
        })?;
        if view.count != left.count() as u64 {
            let (told, count) = (view.count, left.count());
            let why = format!("remove set {told} grains, {count} are left");
            return Err(Failure::new(FailureKind::Engine, why));
        }
        for (field, numbers) in left.slices() {
            require_told(field, numbers, self.dimension)?;
        }
        self.grains.clone_from(&left);
        Ok(left)
    }
}

/// A number of a grain that is left and was not told.
fn require_told(field: Field, numbers: &[f64], dimension: usize) -> Result<(), Failure> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(place) => {
            let (name, grain) = (field.name(), place / field.components(dimension));
            let why = format!("remove left {name} of grain {grain} at {}", numbers[place]);
            Err(Failure::new(FailureKind::NotFinite, why))
        }
    }
}
