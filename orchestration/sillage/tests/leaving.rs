//! Grains that leave a run of real processes: what its files say of them, and who is refused.

use std::path::Path;

use run::vtu::read::State;

use crate::background::{need_programs, sillage};

/// Eighteen grains of two sizes above an open bottom.
pub const SCENE: &str = r#"
run = { end_time = 0.12, coupling_step = 2e-3 }
gravity.acceleration = [0.0, -9.81]
contact = { friction = 0.3, tolerance = 1e-3 }
coupling = { drag = "dallavalle", scheme = { iterated = { tolerance = 1e-3, passes_max = 40 } } }
output.every = 0.02
[fluid]
density = 1000.0
dynamic_viscosity = 1e-2
domain.rectangle = { lower = [0.0, 0.0], upper = [0.02, 0.04], cells = [5, 10] }
[fluid.boundaries]
top = { open = { pressure = 0.0 } }
bottom = { open = { pressure = 392.4 } }
all = "no-slip"
[[grains]]
density = 2500.0
radius = { min = 0.6e-3, max = 0.9e-3 }
lattice = { lower = [1e-3, 0.001], upper = [0.019, 0.005], spacing = 2e-3, pattern = "square", seed = 1 }
"#;

/// Run the scene with these settings into a folder: exit code and what was said.
fn run(folder: &Path, more: &[&str]) -> (Option<i32>, String) {
    need_programs();
    let scene = folder.join("hopper.toml");
    std::fs::write(&scene, SCENE).expect("written");
    let out = folder.join("out");
    let mut arguments = vec!["run", text(&scene), "--out", text(&out), "--replace"];
    arguments.extend(more.iter().flat_map(|setting| ["--set", setting]));
    let (code, _, words) = sillage(&arguments);
    println!("{more:?}: {code:?} {words}");
    (code, words)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn columns(folder: &Path, names: [&str; 2]) -> Vec<[f64; 2]> {
    let text = std::fs::read_to_string(folder.join("out/steps.csv")).expect("steps");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heads = lines.next().expect("heads");
    let place = names.map(|name| heads.iter().position(|head| *head == name));
    let number = |line: &Vec<&str>, place: Option<usize>| {
        place.map_or(f64::NAN, |place| line[place].parse().expect("a number"))
    };
    lines
        .map(|line| place.map(|place| number(&line, place)))
        .collect()
}

#[test]
fn states_hold_who_is_left_by_number_and_recordings_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, words) = run(folder.path(), &["record.file=\"exchange.mcap\""]);
    assert_eq!(code, Some(0), "{words}");
    let steps = columns(folder.path(), ["grains", "removed_grains"]);
    assert!(steps.iter().all(|[left, gone]| left + gone == 18.0));
    let state = |number: usize| {
        let file = folder
            .path()
            .join(format!("out/vtu/grains_{number:04}.vtu"));
        State::read(&file).expect("a state")
    };
    let numbers = |state: &State, name| state.numbers(name).expect("read").expect("there");
    let radius = numbers(&state(0), "grain_radius");
    let mut counts = Vec::new();
    for place in 0..=6 {
        let state = state(place);
        let id = numbers(&state, "grain_id");
        let own: Vec<f64> = id.iter().map(|&id| radius[id as usize]).collect();
        assert_eq!(
            numbers(&state, "grain_radius"),
            own,
            "radii go with their grains"
        );
        assert!(id.is_sorted() && numbers(&state, "grain_contact").len() == id.len());
        counts.push(id.len());
    }
    let last = steps.last().expect("steps")[0] as usize;
    println!("grains {counts:?}, at the end {last}");
    assert!(counts.is_sorted_by(|a, b| a >= b) && counts[0] == 18 && counts[6] == last);
    assert!(last < 9, "most have left");
    let recording = folder.path().join("out/exchange.mcap");
    for seat in ["fluid", "particles"] {
        let (code, words, _) = sillage(&["replay", text(&recording), "--as", seat]);
        assert_eq!(code, Some(0), "{words}");
    }
    let (code, _, words) = sillage(&["report", text(&folder.path().join("out"))]);
    assert_eq!(code, Some(0), "{words}");
}

#[test]
fn a_side_may_hold_grains_or_end_the_run_and_engines_that_keep_all_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let engine = "engines.particles.command=[\"rapier-particles\"]";
    let (code, words) = run(folder.path(), &[engine]);
    assert_eq!(code, Some(2));
    assert!(
        words.contains("RemovesGrains") && words.contains("bottom, top"),
        "{words}"
    );
    let open = "particles.boundaries={ bottom = \"open\", top = \"open\" }";
    let (code, words) = run(folder.path(), &[open]);
    assert_eq!(code, Some(7));
    assert!(words.contains("\"removed\""), "{words}");
    let walls = "particles.boundaries={ bottom = \"wall\", top = \"wall\" }";
    let (code, words) = run(folder.path(), &[walls, "output.fields=[\"grain_id\"]"]);
    assert_eq!(code, Some(0), "{words}");
    let steps = columns(folder.path(), ["grains", "front"]);
    assert!(
        steps
            .iter()
            .all(|[left, front]| left.is_nan() && *front > 0.0)
    );
    let state = State::read(&folder.path().join("out/vtu/grains_0001.vtu")).expect("a state");
    let id = state.numbers("grain_id").expect("read").expect("asked for");
    assert_eq!(id, (0..18).map(f64::from).collect::<Vec<_>>());
}
