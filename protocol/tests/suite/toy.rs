//! Two engines that solve nothing: every output is a fixed function of the inputs and of the
//! accepted state, so that two transports can be compared bit by bit. They can be told to misbehave.
//! With the two runs that tests ask of them.

use std::path::Path;
use std::time::Duration;

use protocol::engine::{
    Computed, FluidEngine, InitialGrains, Inputs, MeshDescription, Outputs, ParticleEngine,
};
use protocol::field::Field;
use protocol::message::{Advance, Capability, Diagnostic, Failure, FailureKind};
use protocol::partner::Partner;
use protocol::report::{FluidReport, ParticleReport};
use protocol::scene::{
    Boundary, Diagonals, FluidScene, MeshSource, Nonlinear, ParticleScene, TimeScheme, ViscousForm,
};

/// What goes wrong, in the second step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    None,
    Panic,
    NotANumber,
    Forgets,
    Refuses,
    Sleeps,
}

impl Fault {
    pub fn named(name: &str) -> Fault {
        match name {
            "panic" => Fault::Panic,
            "nan" => Fault::NotANumber,
            "forgets" => Fault::Forgets,
            "refuses" => Fault::Refuses,
            "sleeps" => Fault::Sleeps,
            _ => Fault::None,
        }
    }
}

/// A fluid engine on a strip of triangles.
pub struct ToyFluid {
    pub fault: Fault,
    accepted: Vec<f64>,
    candidate: Vec<f64>,
}

impl ToyFluid {
    pub fn new(fault: Fault) -> ToyFluid {
        ToyFluid {
            fault,
            accepted: Vec::new(),
            candidate: Vec::new(),
        }
    }
}

/// A scene whose mesh is a strip of `cells` squares.
pub fn fluid_scene(cells: usize) -> FluidScene {
    FluidScene {
        dimension: 2,
        density: 1200.0,
        dynamic_viscosity: 0.12,
        gravity: vec![0.0, -9.81],
        mesh: MeshSource::Rectangle {
            lower: vec![0.0, 0.0],
            upper: vec![1.0, 0.5],
            cells: vec![cells, 1],
            diagonals: Diagonals::Uniform,
            grading: vec![1.0, 1.0],
        },
        boundaries: [("all".to_owned(), Boundary::NoSlip)].into(),
        convection: true.into(),
        time_scheme: TimeScheme::BackwardEuler,
        nonlinear: Nonlinear::Picard,
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        initial_velocity: vec![0.0, 0.0],
        threads: 1,
        mean_flow: Default::default(),
        refinement: None,
    }
}

fn strip(cells: usize) -> MeshDescription {
    let columns = cells + 1;
    let node = |column: usize, row: usize| (row * columns + column) as u32;
    let place = |n: u32| [f64::from(n % columns as u32), f64::from(n / columns as u32)];
    let mut mesh = MeshDescription {
        dimension: 2,
        period: vec![Some(2.0), None],
        ..MeshDescription::default()
    };
    for n in 0..2 * columns as u32 {
        mesh.node_position.extend(place(n));
        mesh.nodal_mass.push(0.25 + f64::from(n));
    }
    for cell in 0..cells {
        let (a, b, c, d) = (
            node(cell, 0),
            node(cell + 1, 0),
            node(cell + 1, 1),
            node(cell, 1),
        );
        mesh.simplex_nodes.extend([a, b, c, a, c, d]);
    }
    mesh.simplex_position = mesh.simplex_nodes.iter().flat_map(|&n| place(n)).collect();
    mesh
}

impl FluidEngine for ToyFluid {
    fn identity(&self) -> (&'static str, &'static str) {
        ("toy-fluid", "1")
    }
    fn capabilities(&self) -> Vec<Capability> {
        vec![Capability::Checkpoint]
    }
    fn configure(&mut self, scene: &FluidScene) -> Result<MeshDescription, Failure> {
        let MeshSource::Rectangle { cells, .. } = &scene.mesh else {
            return Err(Failure::new(FailureKind::Scene, "only rectangles"));
        };
        let mesh = strip(cells[0]);
        self.accepted = vec![0.0; mesh.nodal_mass.len()];
        Ok(mesh)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<FluidReport>, Failure> {
        if request.step == 2 {
            match self.fault {
                Fault::Panic => panic!("the toy breaks"),
                Fault::Refuses => {
                    return Err(Failure::new(
                        FailureKind::NotConverged,
                        "residual 1 above 1e-3",
                    ));
                }
                Fault::Sleeps => std::thread::sleep(Duration::from_secs(30)),
                _ => {}
            }
        }
        let nodes = self.accepted.len();
        let [porosity, source] = [Field::Porosity, Field::DragSource].map(|f| inputs.get(f));
        let porosity = |n: usize| porosity.map_or(1.0, |values| values[n]);
        self.candidate = (0..nodes)
            .map(|n| (self.accepted[n] + request.dt) / porosity(n))
            .collect();
        outputs
            .take(Field::Pressure)
            .copy_from_slice(&self.candidate);
        let velocity = outputs.take(Field::InterstitialVelocity);
        let gradient = outputs.take(Field::PressureGradient);
        for n in 0..nodes {
            let [x, y] = [0, 1].map(|k| source.map_or(0.0, |s| s[2 * n + k]));
            velocity[2 * n..2 * n + 2].copy_from_slice(&[x.sin(), y.cos()]);
            gradient[2 * n..2 * n + 2].copy_from_slice(&[self.candidate[n].sqrt(), request.time]);
        }
        if (request.step, request.pass) == (2, 0) && self.fault == Fault::NotANumber {
            gradient[2 * 3 + 1] = f64::NEG_INFINITY;
        }
        if request.step == 2 && self.fault == Fault::Forgets {
            velocity[4] = f64::NAN;
        }
        Ok(Computed {
            report: FluidReport::default(),
            diagnostics: vec![Diagnostic {
                name: "kinetic_energy".to_owned(),
                value: self.candidate.iter().sum(),
            }],
        })
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.accepted.clone_from(&self.candidate);
        Ok(())
    }
    fn save(&mut self, path: &Path) -> Result<(), Failure> {
        let bytes: Vec<u8> = self
            .accepted
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        std::fs::write(path, bytes).map_err(|e| Failure::new(FailureKind::Engine, e.to_string()))
    }
    fn restore(&mut self, path: &Path) -> Result<(), Failure> {
        let bytes =
            std::fs::read(path).map_err(|e| Failure::new(FailureKind::Engine, e.to_string()))?;
        self.accepted = bytes
            .as_chunks::<8>()
            .0
            .iter()
            .map(|&b| f64::from_le_bytes(b))
            .collect();
        Ok(())
    }
}

/// Grains that fall through everything.
pub struct ToyGrains {
    accepted: InitialGrains,
    candidate: InitialGrains,
}

impl ToyGrains {
    pub fn new() -> ToyGrains {
        ToyGrains {
            accepted: InitialGrains::default(),
            candidate: InitialGrains::default(),
        }
    }
}

pub fn particle_scene() -> ParticleScene {
    ParticleScene {
        dimension: 2,
        gravity: vec![0.0, -9.81],
        walls: Vec::new(),
        period: vec![None, None],
        friction: 0.0,
        wall_friction: 0.0,
        inertia_factor: 0.5,
        tolerance: 1e-3,
        solver: None,
        sweeps_max: 100,
        sub_steps_max: 10,
        threads: 1,
    }
}

/// `count` grains in a row.
pub fn grains(count: usize) -> InitialGrains {
    InitialGrains {
        dimension: 2,
        position: (0..2 * count).map(|k| k as f64 * 0.5).collect(),
        velocity: vec![0.0; 2 * count],
        radius: vec![0.1; count],
        mass: (0..count).map(|k| 1.0 + k as f64).collect(),
        volume: vec![0.0314; count],
        fixed: vec![0.0; count],
    }
}

impl ParticleEngine for ToyGrains {
    fn identity(&self) -> (&'static str, &'static str) {
        ("toy-grains", "1")
    }
    fn capabilities(&self) -> Vec<Capability> {
        vec![Capability::ImplicitDrag]
    }
    fn configure(
        &mut self,
        _scene: &ParticleScene,
        grains: InitialGrains,
    ) -> Result<InitialGrains, Failure> {
        self.accepted = grains.clone();
        Ok(grains)
    }
    fn advance(
        &mut self,
        request: &Advance,
        inputs: &Inputs<'_>,
        mut outputs: Outputs<'_>,
    ) -> Result<Computed<ParticleReport>, Failure> {
        let [drag, force] = [Field::GrainDrag, Field::GrainForce].map(|field| inputs.get(field));
        self.candidate = self.accepted.clone();
        for k in 0..self.accepted.position.len() {
            let mass = self.accepted.mass[k / 2];
            let drag = drag.map_or(0.0, |gamma| gamma[k / 2]);
            let force = force.map_or(0.0, |q| q[k]);
            let velocity = (mass * self.accepted.velocity[k] + request.dt * force)
                / (mass + drag * request.dt);
            self.candidate.velocity[k] = velocity;
            self.candidate.position[k] += request.dt * velocity;
        }
        for (field, values) in [
            (Field::GrainPosition, &self.candidate.position),
            (Field::GrainVelocity, &self.candidate.velocity),
            (Field::GrainMeanVelocity, &self.candidate.velocity),
        ] {
            outputs.take(field).copy_from_slice(values);
        }
        outputs.take(Field::GrainContact).fill(0.0);
        Ok(ParticleReport::one_step().into())
    }
    fn commit(&mut self) -> Result<(), Failure> {
        self.accepted.clone_from(&self.candidate);
        Ok(())
    }
    fn save(&mut self, _path: &Path) -> Result<(), Failure> {
        Err(Failure::new(
            FailureKind::Engine,
            "the toy has no checkpoint",
        ))
    }
    fn restore(&mut self, _path: &Path) -> Result<(), Failure> {
        Err(Failure::new(
            FailureKind::Engine,
            "the toy has no checkpoint",
        ))
    }
}

/// A step that begins at (step − 1) dt.
pub fn request(step: u64, pass: u32) -> Advance {
    const DT: f64 = 0.01;
    Advance {
        step,
        pass,
        time: (step as f64 - 1.0) * DT,
        dt: DT,
        sub_steps: 0,
        tolerance: 1e-3,
        fields: Vec::new(),
    }
}

/// Four steps with two passes each and one rejected step; returns every bit that came back.
pub fn fluid_run(fluid: &mut Partner, cells: usize) -> Vec<u64> {
    let mesh = fluid.configure_fluid(&fluid_scene(cells)).unwrap();
    assert_eq!(mesh.simplex_count(), 2 * cells);
    let nodes = mesh.nodal_mass.len();
    let mut bits: Vec<u64> = mesh.node_position.iter().map(|x| x.to_bits()).collect();
    for step in 1..=4 {
        for pass in 0..2 {
            let porosity: Vec<f64> = (0..nodes)
                .map(|n| 1.0 / (1.1 + n as f64 + f64::from(pass)))
                .collect();
            let source: Vec<f64> = (0..2 * nodes).map(|n| n as f64 * 0.3).collect();
            let inputs = [
                (Field::Porosity, porosity.as_slice()),
                (Field::DragSource, source.as_slice()),
            ];
            let (mut velocity, mut pressure) = (Vec::new(), vec![9.0; 3]);
            let mut outputs = [
                (Field::InterstitialVelocity, &mut velocity),
                (Field::Pressure, &mut pressure),
            ];
            let done = fluid
                .advance(&request(step, pass), &inputs, &mut outputs)
                .unwrap();
            assert_eq!((done.step, done.pass), (step, pass));
            // its own number, then what the loop adds
            let names: Vec<&str> = done.diagnostics.iter().map(|d| d.name.as_str()).collect();
            assert_eq!(names[1..], ["cpu_seconds", "wall_seconds"]);
            assert!(done.diagnostics[1..].iter().all(|d| d.value >= 0.0));
            assert_eq!((velocity.len(), pressure.len()), (2 * nodes, nodes));
            bits.extend(velocity.iter().chain(&pressure).map(|x| x.to_bits()));
            bits.push(done.diagnostics[0].value.to_bits());
        }
        fluid.commit(step).unwrap();
    }
    bits
}

/// Three steps of five grains.
pub fn particle_run(particles: &mut Partner) -> Vec<u64> {
    let grains = grains(5);
    assert_eq!(
        particles
            .configure_particles(&particle_scene(), &grains)
            .unwrap(),
        grains
    );
    let mut bits = Vec::new();
    for step in 1..=3 {
        let (drag, force) = (vec![0.5; 5], vec![-9.81; 10]);
        let (mut position, mut contact) = (Vec::new(), Vec::new());
        let inputs = [
            (Field::GrainDrag, drag.as_slice()),
            (Field::GrainForce, force.as_slice()),
        ];
        let mut outputs = [
            (Field::GrainPosition, &mut position),
            (Field::GrainContact, &mut contact),
        ];
        particles
            .advance(&request(step, 0), &inputs, &mut outputs)
            .unwrap();
        particles.commit(step).unwrap();
        bits.extend(position.iter().chain(&contact).map(|x| x.to_bits()));
    }
    bits
}
