//! Engines that can do less: the coupler makes up for it, with more passes and the same answer.

use coupler::simulation::Simulation;
use fluid_solver::serve::Engine as Fluid;
use particle_solver::serve::Engine as Particles;
use protocol::engine::{
    Computed, FluidEngine, InitialGrains, Inputs, MeshDescription, Outputs, ParticleEngine,
};
use protocol::field::Field;
use protocol::local::{spawn_fluid, spawn_particles};
use protocol::message::{Advance, Capability, Failure};
use protocol::partner::Partner;
use protocol::report::{FluidReport, ParticleReport};
use protocol::scene::{CouplerScene, FluidScene, ParticleScene, Scheme};
use space::flat::numbers;
use std::path::Path;
use tests::grains::{disks, sunflower};
use tests::{box_walls, fluid, mean, particles, scene};

/// The built-in fluid without c and κ.
#[derive(Default)]
struct PlainFluid(Fluid);

impl FluidEngine for PlainFluid {
    fn identity(&self) -> (&'static str, &'static str) {
        ("plain-fluid", "0")
    }
    fn capabilities(&self) -> Vec<Capability> {
        Vec::new()
    }
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.0.configure(scene)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        for field in [Field::EntrainedFraction, Field::SolidMobility] {
            assert!(inputs.get(field).is_none());
        }
        self.0.advance(request, inputs, outputs)
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}

/// The built-in grains that do not tell who touches, and keep all.
#[derive(Default)]
pub struct SilentGrains(Particles);

impl ParticleEngine for SilentGrains {
    fn identity(&self) -> (&'static str, &'static str) {
        ("silent-grains", "0")
    }
    fn capabilities(&self) -> Vec<Capability> {
        vec![Capability::ImplicitDrag]
    }
    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        self.0.configure(scene, grains)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let computed = self.0.advance(request, inputs, outputs.reborrow())?;
        outputs.take(Field::GrainContact).fill(0.0);
        Ok(computed)
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}

/// An engine that tells what it must and nothing for people.
#[derive(Default)]
struct Curt<E>(E);

impl FluidEngine for Curt<Fluid> {
    fn identity(&self) -> (&'static str, &'static str) {
        FluidEngine::identity(&self.0)
    }
    fn capabilities(&self) -> Vec<Capability> {
        FluidEngine::capabilities(&self.0)
    }
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        self.0.configure(scene)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        let computed = self.0.advance(request, inputs, outputs)?;
        assert!(!computed.diagnostics.is_empty());
        Ok(computed.report.into())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        FluidEngine::commit(&mut self.0)
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        FluidEngine::save(&mut self.0, path)
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        FluidEngine::restore(&mut self.0, path)
    }
}

impl ParticleEngine for Curt<Particles> {
    fn identity(&self) -> (&'static str, &'static str) {
        self.0.identity()
    }
    fn capabilities(&self) -> Vec<Capability> {
        self.0.capabilities()
    }
    fn configure(
        &mut self,
        scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        self.0.configure(scene, grains)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let computed = self.0.advance(request, inputs, outputs)?;
        assert!(!computed.diagnostics.is_empty());
        Ok(computed.report.into())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.0.commit()
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.save(path)
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        self.0.restore(path)
    }
}

const RADIUS: f64 = 3.708e-3;

/// A cloud in glycerine, a = γΔt/m of its grains between 10 and 1e3.
fn cloud(solid_fraction: f64, count: usize, steps: usize) -> (CouplerScene, InitialGrains) {
    let gravity = [0.0, -9.81];
    let (lower, upper) = ([-5.0 * RADIUS, 0.0], [5.0 * RADIUS, 15.0 * RADIUS]);
    let mut part = fluid(1200.0, 0.12, gravity, lower, upper, [40, 60]);
    part.convection = true.into();
    let mut grain_part = particles(gravity);
    grain_part.walls = box_walls(lower, upper);
    let mut scene = scene(Some(part), Some(grain_part), 5.5e-3, steps);
    scene.scheme = Scheme::Iterated {
        tolerance: 1e-3,
        passes_max: 40,
    };
    let grain_radius = RADIUS * (solid_fraction / count as f64).sqrt();
    let centres = sunflower([0.0, 11.0 * RADIUS], RADIUS, count);
    (scene, disks(&centres, &vec![grain_radius; count], 2400.0))
}

/// Run a scene; fall speed at the end, and the most passes of a step.
fn run(scene: &CouplerScene, grains: &InitialGrains, plain: bool, silent: bool) -> (f64, u32, f64) {
    let fluid = match plain {
        true => spawn_fluid(PlainFluid::default),
        false => spawn_fluid(Fluid::default),
    };
    let particles = match silent {
        true => spawn_particles(SilentGrains::default),
        false => spawn_particles(Particles::default),
    };
    let (fluid, particles) = (fluid.expect("a fluid"), particles.expect("grains"));
    let mut coupling = Simulation::<2, 3>::new(scene.clone(), Some(fluid), Some(particles), grains)
        .unwrap_or_else(|error| panic!("{error}"));
    let steps = (scene.end_time / scene.coupling_step).round() as usize;
    let (mut passes, mut third_law) = (0, 0.0_f64);
    for _ in 0..steps {
        let report = coupling
            .advance(scene.coupling_step)
            .unwrap_or_else(|error| panic!("plain {plain}, silent {silent}: {error}"));
        passes = passes.max(report.passes);
        third_law = third_law.max(report.budget.third_law_defect);
    }
    (
        -mean(numbers(&coupling.state.grains.velocity), 1),
        passes,
        third_law,
    )
}

#[test]
fn engines_that_can_do_less_give_the_same_cloud_with_more_passes() {
    println!("| solid fraction | fluid | grains | fall speed | passes | third law |");
    for solid_fraction in [0.05, 0.2] {
        let (scene, grains) = cloud(solid_fraction, 300, 8);
        let (reference, ..) = run(&scene, &grains, false, false);
        for (plain, silent) in [(false, false), (true, false), (false, true), (true, true)] {
            let (speed, passes, third_law) = run(&scene, &grains, plain, silent);
            let fluid = if plain { "without c, κ" } else { "affine" };
            let told = if silent { "silent" } else { "told" };
            println!(
                "| {solid_fraction} | {fluid} | {told} | {speed:.6e} | {passes} | {third_law:.1e} |"
            );
            let off = (speed / reference - 1.0).abs();
            assert!(off < 1e-2, "{speed} {reference}");
            assert!(third_law < 1e-9);
            assert!(passes <= 10);
        }
    }
}

/// Diagnostics are for people: what the coupler goes by is in the report.
#[test]
fn without_diagnostics_a_run_has_the_same_bits() {
    let (scene, grains) = cloud(0.2, 60, 4);
    let run = |fluid: Result<_, _>, grain_engine: Result<_, _>| {
        let fluid: Partner = fluid.unwrap_or_else(|error: protocol::Error| panic!("{error}"));
        let engine = grain_engine.unwrap_or_else(|error: protocol::Error| panic!("{error}"));
        let mut run = Simulation::<2, 3>::new(scene.clone(), Some(fluid), Some(engine), &grains)
            .unwrap_or_else(|error| panic!("{error}"));
        let mut bits = Vec::new();
        for _ in 0..4 {
            let report = run
                .advance(scene.coupling_step)
                .unwrap_or_else(|error| panic!("{error}"));
            let budget = [report.budget.energy_defect, report.budget.transfer_loss];
            let state = [
                numbers(&run.state.grains.position),
                numbers(&run.state.grains.velocity),
                numbers(&run.state.flow.velocity),
                &budget,
            ];
            bits.extend(state.concat().iter().map(|number| number.to_bits()));
            bits.push(report.passes.into());
        }
        bits
    };
    let told = run(
        spawn_fluid(Fluid::default),
        spawn_particles(Particles::default),
    );
    let curt = run(
        spawn_fluid(Curt::<Fluid>::default),
        spawn_particles(Curt::<Particles>::default),
    );
    println!("{} numbers", told.len());
    assert_eq!(told, curt);
}

#[test]
fn a_wall_that_moves_is_refused_where_grains_do_not_know_it() {
    let (mut scene, grains) = cloud(0.1, 10, 1);
    let part = scene.particles.as_mut().expect("grains");
    part.walls[0].velocity = Some(vec![0.1, 0.0]);
    let connect = |scene: &CouplerScene| {
        let fluid = spawn_fluid(Fluid::default).expect("a fluid");
        let particles = spawn_particles(SilentGrains::default).expect("grains");
        Simulation::<2, 3>::new(scene.clone(), Some(fluid), Some(particles), &grains).map(drop)
    };
    assert!(connect(&scene).is_ok(), "nothing rubs without friction");
    scene.particles.as_mut().expect("grains").wall_friction = 0.5;
    let error = connect(&scene).expect_err("a belt");
    println!("{error}");
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("knows no walls that move"));
}
