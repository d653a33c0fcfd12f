//! Every scene in `scenes/` is valid, and its resolved form says what its file says.

use std::path::{Path, PathBuf};

use scene::plan;

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder of scenes")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    scenes.sort();
    scenes
}

#[test]
fn every_scene_passes_check_and_says_what_it_shows() {
    let scenes = scenes();
    assert!(scenes.len() >= 12, "{} scenes", scenes.len());
    for path in scenes {
        let scene = scene::load(&path, &[], 1).unwrap_or_else(|error| panic!("{error}"));
        println!(
            "{:<18} {:>6} grains, {:?} steps",
            scene.name,
            scene.grains.len(),
            plan::plan(&scene).steps
        );
        assert!(
            scene.warnings.is_empty(),
            "{}: {:?}",
            scene.name,
            scene.warnings
        );
        assert!(
            scene.text.starts_with("# "),
            "{}: no comment on top",
            scene.name
        );
    }
}

#[test]
fn a_plan_holds_grains_against_the_cells_that_follow_them() {
    println!("| scene | diameter over cell | grains are spread |");
    for (name, ratio, spread) in [("cloud", 0.120, false), ("cloud-3d", 0.410, true)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
        let scene = scene::load(&path, &[], 1).expect("a valid scene");
        let choices = plan::plan(&scene).choices;
        let found = choices.iter().find(|own| own.part == "spreading of grains");
        let found = found.expect("a choice");
        let value = found.value.expect("a number");
        println!("| {name} | {value:.3} | {} |", found.chosen);
        assert!((value - ratio).abs() < 1e-3);
        assert_eq!(found.chosen.starts_with("there"), spread);
    }
}

#[test]
fn the_cloud_has_the_numbers_of_its_reference() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cloud.toml");
    let scene = scene::load(&path, &[], 1).expect("a valid scene");
    assert_eq!(scene.grains.len(), 2000);
    let coupler = &scene.coupler;
    let fluid = coupler.fluid.as_ref().expect("fluid");
    // Galilei number of the cloud: ρ f R³/μ² with f = c Δρ g.
    let galilei = fluid.density * 0.2 * 1200.0 * 9.81 * 3.708e-3_f64.powi(3) / 0.12_f64.powi(2);
    println!("Ga = {galilei:.3}");
    assert!((galilei - 10.0).abs() < 0.01);
    assert_eq!(coupler.particles.as_ref().expect("grains").walls.len(), 4);
}

#[test]
fn a_plan_starts_only_the_processes_that_a_scene_needs() {
    for (name, seats) in [
        ("cloud", &["fluid", "particles", "coupler"][..]),
        ("cavity", &["fluid", "coupler"]),
        ("dry-collapse", &["particles", "coupler"]),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
        let scene = scene::load(&path, &[], 1).expect("a valid scene");
        let plan = plan::plan(&scene);
        let found: Vec<&str> = plan
            .processes
            .iter()
            .map(|process| process.seat.as_str())
            .collect();
        println!("{name}: {found:?}");
        assert_eq!(found, seats);
    }
}

#[test]
fn the_resolved_scene_reads_back_to_the_same_scene() {
    for path in scenes() {
        let scene = scene::load(&path, &[], 1).expect("a valid scene");
        let folder = tempfile::tempdir().expect("a folder");
        plan::write_inputs(&scene, folder.path()).expect("written");
        let json = std::fs::read_to_string(folder.path().join("scene.json")).expect("written");
        let back: protocol::scene::CouplerScene = serde_json::from_str(&json).expect("JSON");
        assert_eq!(back, scene.coupler, "{}", scene.name);
        assert_eq!(
            folder.path().join("grains.csv").exists(),
            !scene.grains.is_empty()
        );
    }
}
