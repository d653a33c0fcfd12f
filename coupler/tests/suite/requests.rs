//! What a step asks of the engines: nothing that its scheme does not use.

use std::path::Path;
use std::sync::{Arc, Mutex};

use coupler::simulation::Simulation;
use protocol::engine::{
    Computed, FacetDescription, FluidEngine, InitialGrains, Inputs, MeshDescription, Outputs,
    ParticleEngine,
};
use protocol::field::Field;
use protocol::local::{LIMITS, spawn_fluid, spawn_particles};
use protocol::message::{Advance, Capability, Failure};
use protocol::report::{FluidReport, ParticleReport};
use protocol::scene::{
    Boundary, Convection, CouplerScene, Diagonals, DragLaw, FluidScene, Geometry, MeshSource,
    Nonlinear, ParticleScene, Scheme, TimeScheme, ViscousForm,
};

/// Pass of every request, in order.
type Asked = Arc<Mutex<Vec<u32>>>;

/// A fluid at rest on two triangles.
struct Still;

impl FluidEngine for Still {
    fn identity(&self) -> (&'static str, &'static str) {
        ("still", "0")
    }
    fn capabilities(&self) -> Vec<Capability> {
        Vec::new()
    }
    fn configure(&mut self, _: &FluidScene) -> Result<MeshDescription, Failure> {
        Ok(MeshDescription {
            node_position: vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0],
            dimension: 2,
            simplex_nodes: vec![0, 1, 2, 0, 2, 3],
            simplex_position: vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0],
            nodal_mass: vec![1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0, 1.0 / 6.0],
            period: vec![None, None],
            facets: FacetDescription::default(),
        })
    }
    fn advance(
        &mut self,
        _: &Advance,
        _: &Inputs<'_>,
        outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        for (_, room) in outputs.into_all() {
            room.fill(0.0);
        }
        Ok(FluidReport::default().into())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        Ok(())
    }
    fn save(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
    fn restore(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
}

/// One grain that touches something, and an engine that keeps what it is asked.
struct Touching {
    asked: Asked,
    able: Vec<Capability>,
    grains: InitialGrains,
}

impl ParticleEngine for Touching {
    fn identity(&self) -> (&'static str, &'static str) {
        ("touching", "0")
    }
    fn capabilities(&self) -> Vec<Capability> {
        self.able.clone()
    }
    fn configure(
        &mut self,
        _: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        self.grains = grains.clone();
        Ok(grains)
    }
    fn advance(
        &mut self,
        request: &Advance,
        _: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        self.asked.lock().expect("one thread").push(request.pass);
        let position = outputs.take(Field::GrainPosition);
        position.copy_from_slice(&self.grains.position);
        outputs.take(Field::GrainVelocity).fill(0.0);
        outputs.take(Field::GrainMeanVelocity).fill(0.0);
        outputs.take(Field::GrainContact).fill(1.0);
        outputs.take(Field::GrainSpin).fill(request.step as f64);
        Ok(ParticleReport::one_step().into())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        Ok(())
    }
    fn save(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
    fn restore(&mut self, _: &Path) -> Result<(), Failure> {
        Ok(())
    }
}

fn scene(scheme: Scheme) -> CouplerScene {
    let gravity = vec![0.0, 0.0];
    let fluid = FluidScene {
        dimension: 2,
        density: 1000.0,
        dynamic_viscosity: 1e-3,
        gravity: gravity.clone(),
        mesh: MeshSource::Rectangle {
            lower: vec![0.0, 0.0],
            upper: vec![1.0, 1.0],
            cells: vec![1, 1],
            diagonals: Diagonals::Uniform,
            grading: vec![1.0, 1.0],
        },
        boundaries: [("all".to_owned(), Boundary::NoSlip)].into(),
        convection: Convection::Never,
        time_scheme: TimeScheme::BackwardEuler,
        nonlinear: Nonlinear::Picard,
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        initial_velocity: vec![0.0, 0.0],
        threads: 1,
        mean_flow: Default::default(),
        refinement: None,
    };
    let particles = ParticleScene {
        dimension: 2,
        gravity: gravity.clone(),
        walls: Vec::new(),
        period: vec![None, None],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1e-3,
        solver: None,
        sweeps_max: 1,
        sub_steps_max: 1,
        threads: 1,
    };
    CouplerScene {
        dimension: 2,
        end_time: 1.0,
        coupling_step: 0.1,
        step_min: None,
        adaptive: None,
        gravity,
        fluid: Some(fluid),
        particles: Some(particles),
        grains_stay: false,
        grain_boundaries: None,
        grain_exits: Vec::new(),
        near_grains: None,
        indicator: None,
        grains_file: None,
        scheme,
        drag: DragLaw::Stokes,
        geometry: Geometry::Disk,
        reaction: true,
        output_every: None,
        limits: LIMITS,
    }
}

fn one_grain() -> InitialGrains {
    InitialGrains {
        dimension: 2,
        position: vec![0.4, 0.5],
        velocity: vec![0.0, 0.0],
        radius: vec![0.01],
        mass: vec![1.0],
        volume: vec![3e-4],
        fixed: vec![0.0],
    }
}

fn couple(scheme: Scheme, asked: &Asked, able: &[Capability]) -> Simulation<2, 3> {
    let (asked, able) = (Arc::clone(asked), able.to_vec());
    let particles = spawn_particles(move || Touching {
        asked,
        able,
        grains: InitialGrains::default(),
    });
    let fluid = spawn_fluid(|| Still).expect("a fluid");
    let particles = particles.expect("grains");
    Simulation::new(scene(scheme), Some(fluid), Some(particles), &one_grain())
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn only_schemes_with_a_response_predict_contacts_before_the_first_pass() {
    let iterated = Scheme::Iterated {
        tolerance: 1e-3,
        passes_max: 5,
    };
    let cases = [
        (Scheme::Explicit, vec![1, 1]),
        (Scheme::SemiImplicit, vec![1, 1]),
        (Scheme::Staggered, vec![0, 1, 0, 1]),
        (iterated, vec![0, 1, 0, 1]),
    ];
    println!("| scheme | passes asked of the grains in two steps |");
    for (scheme, expected) in cases {
        let asked = Asked::default();
        let mut coupling = couple(scheme, &asked, &[Capability::ContactState]);
        for _ in 0..2 {
            coupling
                .advance(0.1)
                .unwrap_or_else(|error| panic!("{error}"));
        }
        let passes = asked.lock().expect("one thread").clone();
        println!("| {scheme:?} | {passes:?} |");
        assert_eq!(passes, expected, "{scheme:?}");
    }
}

#[test]
fn spins_come_with_a_state_that_is_put_out_from_engines_that_have_them() {
    for (able, told) in [
        (vec![Capability::Spin], vec![2.0]),
        (Vec::new(), Vec::new()),
    ] {
        let mut coupling = couple(Scheme::Staggered, &Asked::default(), &able);
        let start = vec![0.0; told.len()];
        assert_eq!(coupling.state.grains.spin, start);
        for _ in 0..2 {
            coupling
                .advance(0.1)
                .unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(coupling.state.grains.spin, start, "not with a step");
        }
        coupling
            .fetch_unread()
            .unwrap_or_else(|error| panic!("{error}"));
        println!("{able:?}: {:?}", coupling.state.grains.spin);
        assert_eq!(coupling.state.grains.spin, told);
    }
}
