//! The engine as the coupler sees it: a scene in, a mesh out, steps, a checkpoint, what cannot be run.

use fluid_solver::serve::Engine;
use protocol::engine::{FluidEngine, Inputs, Outputs};
use protocol::field::Field;
use protocol::message::{Advance, FailureKind};
use protocol::scene::{self, FluidScene, MeanFlow, MeshSource};

fn scene(boundaries: &[(&str, scene::Boundary)]) -> FluidScene {
    FluidScene {
        dimension: 2,
        density: 1200.0,
        dynamic_viscosity: 0.12,
        gravity: vec![0.0, -9.81],
        mesh: MeshSource::Rectangle {
            lower: vec![0.0; 2],
            upper: vec![0.1, 0.3],
            cells: vec![1, 6],
            diagonals: scene::Diagonals::Uniform,
            grading: vec![1.0; 2],
        },
        boundaries: boundaries
            .iter()
            .map(|(name, b)| ((*name).to_owned(), b.clone()))
            .collect(),
        convection: true.into(),
        time_scheme: scene::TimeScheme::Bdf2,
        nonlinear: scene::Nonlinear::Picard,
        viscous_form: scene::ViscousForm::Symmetric,
        grad_div: 1.0,
        initial_velocity: vec![0.0; 2],
        threads: 1,
        mean_flow: MeanFlow::Free,
        refinement: None,
    }
}

fn step(engine: &mut Engine, nodes: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (mut v, mut g, mut p) = (vec![0.0; 2 * nodes], vec![0.0; 2 * nodes], vec![0.0; nodes]);
    let outputs = Outputs::new(vec![
        (Field::InterstitialVelocity, &mut v[..]),
        (Field::PressureGradient, &mut g[..]),
        (Field::Pressure, &mut p[..]),
    ]);
    let fields = Vec::new();
    let request = Advance {
        step: 1,
        pass: 0,
        time: 0.0,
        dt: 0.01,
        sub_steps: 0,
        tolerance: 1e-3,
        fields,
    };
    engine
        .advance(&request, &Inputs::default(), outputs)
        .unwrap();
    engine.commit().unwrap();
    (v, g, p)
}

#[test]
fn a_periodic_column_of_one_cell_rests_and_survives_a_checkpoint() {
    use scene::Boundary::{NoSlip, Periodic};
    let mut engine = Engine::default();
    let sides = [("left", Periodic), ("right", Periodic), ("all", NoSlip)];
    let mesh = engine.configure(&scene(&sides)).unwrap();
    assert_eq!((mesh.node_count(), mesh.simplex_count()), (7, 12));
    assert_eq!(mesh.period, [Some(0.1), None]);
    let (v, g, p) = step(&mut engine, 7);
    assert!(v.iter().all(|v| v.abs() < 1e-12));
    assert!(
        g.chunks(2)
            .all(|g| g[0].abs() < 1e-8 && (g[1] + 11772.0).abs() < 1e-7)
    );
    assert!((p[0] - p[6] - 11772.0 * 0.3).abs() < 1e-8);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state");
    engine.save(&path).unwrap();
    let next = step(&mut engine, 7);
    engine.restore(&path).unwrap();
    assert_eq!(next, step(&mut engine, 7));
}

#[test]
fn a_scene_that_cannot_be_run_is_a_scene_failure() {
    use scene::Boundary::{NoSlip, Open, Periodic};
    let mut one_sided = scene(&[("left", Periodic), ("all", NoSlip)]);
    let unknown = scene(&[("outlet", Open { pressure: 0.0 }), ("all", NoSlip)]);
    let check = |scene: &FluidScene, parts: &[&str]| {
        let failure = Engine::default().configure(scene).unwrap_err();
        println!("{}", failure.why);
        assert_eq!(failure.kind, FailureKind::Scene);
        assert!(parts.iter().all(|part| failure.why.contains(part)));
    };
    check(&one_sided, &["\"left\"", "\"right\"", "periodic"]);
    check(&unknown, &["\"outlet\"", "bottom"]);
    one_sided.mesh = MeshSource::File {
        path: "no/such.msh".into(),
        scale: 1.0,
        surfaces: Vec::new(),
    };
    check(&one_sided, &["no/such.msh"]);
}
