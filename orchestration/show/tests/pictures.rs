//! The run folder from synthetic messages: pictures, ParaView files, steps.csv, run.json.

use std::path::{Path, PathBuf};

use protocol::field::Field;
use protocol::message::{Diagnostic, ToOrchestrator};
use protocol::monitor::Event;
use protocol::scene::MeshSource;
use run::disk::{Disk, PATIENCE};
use run::folder::document::{self, Ending};
use run::folder::run_folder::RunFolder;
use run::folder::writer::Writer;
use scene::Scene;
use show::picture::pictures;

fn scene(name: &str, settings: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
    let settings: Vec<String> = settings.iter().map(|setting| setting.to_string()).collect();
    scene::load(&path, &settings, 1).unwrap_or_else(|error| panic!("{error}"))
}

/// Nodes of a rectangle and its triangles, as a fluid engine describes them.
fn mesh_fields(scene: &Scene) -> Vec<(Field, Vec<f64>)> {
    let Some(MeshSource::Rectangle {
        lower,
        upper,
        cells,
        ..
    }) = scene.coupler.fluid.as_ref().map(|fluid| fluid.mesh.clone())
    else {
        return Vec::new();
    };
    let (nx, ny) = (cells[0], cells[1]);
    let mut position = Vec::new();
    for j in 0..=ny {
        for i in 0..=nx {
            position.push(lower[0] + (upper[0] - lower[0]) * i as f64 / nx as f64);
            position.push(lower[1] + (upper[1] - lower[1]) * j as f64 / ny as f64);
        }
    }
    let mut nodes = Vec::new();
    for j in 0..ny {
        for i in 0..nx {
            let a = j * (nx + 1) + i;
            let (b, c, d) = (a + 1, a + nx + 2, a + nx + 1);
            nodes.extend([a, b, c, a, c, d].map(|node| node as f64));
        }
    }
    let corners: Vec<f64> = nodes
        .iter()
        .flat_map(|&node| [position[2 * node as usize], position[2 * node as usize + 1]])
        .collect();
    vec![
        (Field::NodePosition, position),
        (Field::SimplexNodes, nodes),
        (Field::SimplexPosition, corners),
    ]
}

/// A vortex pair that moves down with the grains inside it: a falling cloud, as far as pictures go.
fn snapshot(scene: &Scene, mesh: &[(Field, Vec<f64>)], number: u64, last: u64) -> Event {
    let time = scene.coupler.end_time * number as f64 / last as f64;
    let share = number as f64 / last as f64;
    let mut fields = Vec::new();
    let fall = 0.6 * share * 0.2;
    let speed = 0.05 * share;
    if let Some((_, position)) = mesh.first() {
        let (mut velocity, mut pressure) = (Vec::new(), Vec::new());
        for at in position.chunks_exact(2) {
            let (x, y) = (at[0] / 6e-3, (at[1] - 0.2002 + fall) / 6e-3);
            let decay = (-0.5 * (x * x + y * y)).exp();
            velocity.extend([speed * x * y * decay, -speed * (1.0 - x * x) * decay]);
            pressure.push(1000.0 * decay);
        }
        fields.push((Field::InterstitialVelocity, velocity));
        fields.push((Field::Pressure, pressure));
    }
    if !scene.grains.is_empty() {
        let position = scene
            .grains
            .position
            .chunks_exact(2)
            .flat_map(|p| [p[0] * (1.0 + share), p[1] - fall]);
        fields.push((Field::GrainPosition, position.collect()));
        let velocity = scene
            .grains
            .position
            .chunks_exact(2)
            .flat_map(|p| [0.0, -speed * (1.0 + p[1])]);
        fields.push((Field::GrainVelocity, velocity.collect()));
    }
    let names = fields.iter().map(|(field, _)| *field).collect();
    Event {
        message: ToOrchestrator::Snapshot {
            step: number,
            time,
            fields: names,
            grains: 0,
        },
        fields,
    }
}

/// Run a scene's output with synthetic states into `folder`.
fn write(scene: &Scene, folder: &Path, last: u64) -> RunFolder {
    let mesh = mesh_fields(scene);
    let writer = Writer::start(
        RunFolder::create(folder, scene).expect("a folder"),
        pictures(scene, folder),
        Disk::new(PATIENCE),
    );
    let mut fields = mesh.clone();
    if !scene.grains.is_empty() {
        fields.push((Field::GrainRadius, scene.grains.radius.clone()));
    }
    let message = ToOrchestrator::Started {
        dimension: 2,
        nodes: 0,
        simplices: 0,
        grains: 0,
        engines: Vec::new(),
    };
    writer.take(Event { message, fields });
    for number in 0..=last {
        if number > 0 {
            let value = |name: &str, value: f64| Diagnostic {
                name: name.into(),
                value,
            };
            let values = vec![
                value("step", number as f64),
                value("time", 0.1 * number as f64),
                value("wall_step", 0.25),
                value("momentum_defect", 2f64.powi(-50) * number as f64),
            ];
            writer.take(Event {
                message: ToOrchestrator::Step(values),
                fields: Vec::new(),
            });
        }
        writer.take(snapshot(scene, &mesh, number, last));
    }
    let (folder, outcome) = writer.finish(|_| {}).expect("joined");
    outcome.unwrap_or_else(|error| panic!("{error}"));
    folder
}

/// Kept when SILLAGE_PICTURES names a folder, to be looked at.
fn place(name: &str) -> (Option<tempfile::TempDir>, PathBuf) {
    match std::env::var_os("SILLAGE_PICTURES") {
        Some(folder) => (None, PathBuf::from(folder).join(name)),
        None => {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join(name);
            (Some(folder), path)
        }
    }
}

#[test]
fn a_run_folder_holds_everything_that_is_promised() {
    let scene = scene("cloud-uniform", &[]);
    let (_kept, path) = place("cloud");
    let folder = write(&scene, &path, 5);
    let ending = Ending {
        code: 0,
        why: None,
        wall: 1.5,
        cpu: Default::default(),
        memory_peak: Default::default(),
        phases: Default::default(),
    };
    document::write(&path, &document::document(&scene, &folder, Some(&ending))).expect("written");
    for file in [
        "run.json",
        "scene.toml",
        "scene.json",
        "grains.csv",
        "steps.csv",
        "fluid.pvd",
        "grains.pvd",
        "vtu/fluid_0000.vtu",
        "vtu/fluid_0005.vtu",
        "vtu/grains_0005.vtu",
        "frames/0000.png",
        "frames/0005.png",
        "overview.png",
        "logs",
    ] {
        assert!(path.join(file).exists(), "{file}");
    }
    let steps = std::fs::read_to_string(path.join("steps.csv")).expect("steps");
    println!("{steps}");
    assert_eq!(
        steps.lines().next(),
        Some("step,time,wall_step,momentum_defect")
    );
    assert_eq!(steps.lines().count(), 6);
    let report = std::fs::read_to_string(path.join("run.json")).expect("run.json");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["steps"], 5);
    assert_eq!(report["cost"]["wall_step"], 1.25);
    assert_eq!(report["worst"]["momentum_defect"], 5.0 * 2f64.powi(-50));
    assert_eq!(report["exit"]["code"], 0);
    assert!(
        report["machine"]["cores"]
            .as_u64()
            .is_some_and(|cores| cores > 0)
    );
}

#[test]
fn scenes_of_every_kind_are_drawn() {
    for (name, settings) in [
        ("cavity", &["fluid.boundaries.top=no-slip"][..]),
        ("dry-collapse", &[]),
        ("settling-column", &[]),
        ("one-grain", &[]),
        ("fixed-bed", &[]),
    ] {
        let scene = scene(name, settings);
        let (_kept, path) = place(name);
        write(&scene, &path, 3);
        let decoder = png::Decoder::new(std::io::BufReader::new(
            std::fs::File::open(path.join("frames/0003.png")).expect("a picture"),
        ));
        let reader = decoder.read_info().expect("a PNG");
        println!("{name}: {} × {}", reader.info().width, reader.info().height);
        assert!(path.join("overview.png").exists());
    }
}

#[test]
fn paraview_files_hold_the_numbers_that_were_sent() {
    let scene = scene("one-grain", &[]);
    let (_kept, path) = place("numbers");
    write(&scene, &path, 1);
    let xml = std::fs::read_to_string(path.join("vtu/grains_0001.vtu")).expect("a file");
    let name = "Name=\"grain_radius [m]\"";
    let start = xml.find(name).expect("the radius");
    let encoded = xml[start..].lines().nth(1).expect("the values");
    use base64::Engine;
    let bytes = base64::engine::general_purpose::STANDARD
        .decode(encoded)
        .expect("base64");
    assert_eq!(bytes[..8], 8u64.to_le_bytes());
    assert_eq!(bytes[8..16], scene.grains.radius[0].to_le_bytes());
    let time = run::vtu::read::State::from_text(xml).numbers("TimeValue");
    assert_eq!(time.expect("read").map(|time| time.len()), Some(1));
    let pvd = std::fs::read_to_string(path.join("fluid.pvd")).expect("a list");
    println!("{pvd}");
    assert_eq!(pvd.matches("<DataSet").count(), 2);
}
