//! What a step asks of the engines: nothing that its scheme does not use.

use std::path::Path;
use std::sync::{Arc, Mutex};

use coupler::simulation::Simulation;
use protocol::engine::{
    FluidAnswer, FluidEngine, FluidForces, GrainAnswer, InitialGrains, MeshDescription,
    ParticleEngine, SolidResponse,
};
use protocol::local::{LIMITS, spawn_fluid, spawn_particles};
use protocol::message::{Advance, Diagnostic, Failure};
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
    fn capabilities(&self) -> Vec<protocol::message::Capability> {
        Vec::new()
    }
    fn configure(&mut self, _: &FluidScene) -> Result<MeshDescription, Failure> {
        Ok(MeshDescription {
            node_position: vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_position: vec![
                [0.0, 0.0, 1.0, 0.0, 1.0, 1.0],
                [0.0, 0.0, 1.0, 1.0, 0.0, 1.0],
            ],
            nodal_mass: vec![1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0, 1.0 / 6.0],
            period: [None, None],
        })
    }
    fn advance(
        &mut self,
        _: &Advance,
        _: &SolidResponse<'_>,
        answer: FluidAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        answer.interstitial_velocity.fill(0.0);
        answer.pressure_gradient.fill(0.0);
        answer.pressure.fill(0.0);
        Ok(Vec::new())
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
    sub_steps: Option<f64>,
    grains: InitialGrains,
}

impl ParticleEngine for Touching {
    fn identity(&self) -> (&'static str, &'static str) {
        ("touching", "0")
    }
    fn capabilities(&self) -> Vec<protocol::message::Capability> {
        vec![protocol::message::Capability::ContactState]
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
        _: &FluidForces<'_>,
        answer: GrainAnswer<'_>,
    ) -> Result<Vec<Diagnostic>, Failure> {
        self.asked.lock().expect("one thread").push(request.pass);
        answer.position.copy_from_slice(&self.grains.position);
        answer.velocity.fill(0.0);
        answer.mean_velocity.fill(0.0);
        answer.contact.fill(1.0);
        let told = |value| Diagnostic {
            name: "sub_steps".to_owned(),
            value,
        };
        Ok(self.sub_steps.map(told).into_iter().collect())
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
    let gravity = [0.0, 0.0];
    let fluid = FluidScene {
        density: 1000.0,
        dynamic_viscosity: 1e-3,
        gravity,
        mesh: MeshSource::Rectangle {
            lower: [0.0, 0.0],
            upper: [1.0, 1.0],
            cells: [1, 1],
            diagonals: Diagonals::Uniform,
            grading: [1.0, 1.0],
        },
        boundaries: [("all".to_owned(), Boundary::NoSlip)].into(),
        convection: Convection::Never,
        time_scheme: TimeScheme::BackwardEuler,
        nonlinear: Nonlinear::Picard,
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        initial_velocity: [0.0, 0.0],
        threads: 1,
    };
    let particles = ParticleScene {
        gravity,
        walls: Vec::new(),
        period: [None, None],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1e-3,
        sweeps_max: 1,
        sub_steps_max: 1,
        threads: 1,
    };
    CouplerScene {
        end_time: 1.0,
        coupling_step: 0.1,
        adaptive: None,
        gravity,
        fluid: Some(fluid),
        particles: Some(particles),
        grains_stay: false,
        grains_file: None,
        scheme,
        drag: DragLaw::Stokes,
        geometry: Geometry::Disk,
        reaction: true,
        smoothing_length: Some(0.0),
        output_every: None,
        limits: LIMITS,
    }
}

fn one_grain() -> InitialGrains {
    InitialGrains {
        position: vec![0.4, 0.5],
        velocity: vec![0.0, 0.0],
        radius: vec![0.01],
        mass: vec![1.0],
        volume: vec![3e-4],
        fixed: vec![0.0],
    }
}

fn couple(scheme: Scheme, sub_steps: Option<f64>, asked: &Asked) -> Simulation<2, 3> {
    let asked = Arc::clone(asked);
    let particles = spawn_particles(move || Touching {
        asked,
        sub_steps,
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
        let mut coupling = couple(scheme, Some(1.0), &asked);
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
fn an_engine_that_does_not_tell_its_sub_steps_is_named() {
    for told in [None, Some(0.0)] {
        let error = couple(Scheme::Staggered, told, &Asked::default())
            .advance(0.1)
            .expect_err("no number of sub-steps");
        println!("{error}");
        assert!(error.to_string().contains("`touching`"), "{error}");
        assert_eq!(error.exit_code(), 7);
    }
}
