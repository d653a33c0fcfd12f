//! Mesh files through whole commands.

use std::path::{Path, PathBuf};

use crate::background::{need_programs, root, sillage};

fn text(path: &Path) -> &str {
    path.to_str().expect("plain")
}

/// Clear water through the channel of this file, in a folder; millimetres.
fn scene(folder: &Path, file: &str) -> PathBuf {
    let files = root().join("protocol/gmsh/tests/files");
    std::fs::copy(files.join(file), folder.join("own.msh")).expect("copied");
    let path = folder.join("channel.toml");
    let text = "[run]\nend_time = 0.03\ncoupling_step = 0.01\n[gravity]\nacceleration = [0.0, 0.0]\n\
        [fluid]\ndensity = 1000.0\ndynamic_viscosity = 1e-3\n[fluid.domain]\nmesh = \"own.msh\"\nscale = 1e-3\n\
        [fluid.boundaries]\ninlet = { inflow = { velocity = [1e-3, 0.0] } }\n\
        outlet = { open = { pressure = 0.0 } }\nall = \"no-slip\"\n[output]\nframes = false\n";
    std::fs::write(&path, text).expect("written");
    path
}

#[test]
fn a_check_tells_what_is_in_a_mesh_and_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene(folder.path(), "channel-2.2-binary.msh");
    let (code, out, _) = sillage(&["check", text(&path), "--mesh"]);
    println!("{out}");
    assert_eq!(code, Some(0));
    for part in [
        "2.2, binary",
        "\"fluid\"",
        "\"inlet\"",
        "1.00000e-3 m",
        "quality",
    ] {
        assert!(out.contains(part), "{part}");
    }
    let (code, out, err) = sillage(&[
        "check",
        text(&path),
        "--mesh",
        "--set",
        "fluid.domain.surfaces=[\"ice\"]",
    ]);
    println!("{out}{err}");
    assert_eq!(code, Some(2));
    assert!(out.contains("no mesh can be made of it") && err.contains("\"ice\""));
    let (code, out, _) = sillage(&["check", text(&path), "--mesh", "--json"]);
    assert_eq!(code, Some(0));
    let document: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(document["mesh"]["groups"].as_array().map(Vec::len), Some(5));
}

/// The bytes of a binary file survive a recording, and what flows through is what was asked for.
#[test]
fn a_binary_mesh_is_run_recorded_and_replayed_without_its_file() {
    need_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene(folder.path(), "channel-4.1-binary.msh");
    let out = folder.path().join("run");
    let (code, _, err) = sillage(&["run", text(&path), "--record", "--out", text(&out)]);
    assert_eq!(code, Some(0), "{err}");
    let steps = std::fs::read_to_string(out.join("steps.csv")).expect("steps");
    let mut lines = steps.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let last: Vec<&str> = lines.last().expect("a step").split(',').collect();
    for name in ["inflow", "outflow"] {
        let at = names.iter().position(|known| *known == name);
        let value: f64 = last[at.expect("a column")].parse().expect("a number");
        assert!((value / 1e-6 - 1.0).abs() < 1e-9, "{name}: {value:e}");
    }
    std::fs::remove_file(folder.path().join("own.msh")).expect("removed");
    let (code, found, _) = sillage(&["replay", text(&out), "--as", "fluid"]);
    assert_eq!(code, Some(0));
    assert!(found.contains("3 steps, 3 answers, within the tolerance"));
}
