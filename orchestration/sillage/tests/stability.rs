//! `sillage stability`: the maps, kept runs, and what it refuses.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::background::need_programs;

fn stability(folder: &Path, arguments: &[&str]) -> Output {
    need_programs();
    Command::new(env!("CARGO_BIN_EXE_sillage"))
        .arg("stability")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("started")
}

fn document(output: &Output) -> Value {
    println!("{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn the_default_is_stable_at_the_corners_of_a_map_and_the_explicit_scheme_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--quick", "--axes", "stiffness-porosity", "--json"];
    let first = stability(folder.path(), &arguments);
    let found = document(&first);
    println!("{:#}", found["counts"]);
    assert_eq!(first.status.code(), Some(0));
    assert_eq!(found["default_failed"], 0);
    assert_eq!(found["complete"], true);
    assert_eq!(found["counts"]["iterated"]["stable"], 12);
    // a map in which nothing can fail shows nothing
    assert!(found["counts"]["explicit"]["growth"].as_u64() >= Some(2));
    assert!(found["counts"]["semi-implicit"]["growth"].as_u64() >= Some(1));
    let out = folder.path().join("stability");
    let table = std::fs::read_to_string(out.join("stability.csv")).expect("a table");
    assert_eq!(table.lines().count(), 1 + 12 + 3 * 4);
    let png = std::fs::read(out.join("heat/stiffness-porosity.png")).expect("a picture");
    assert!(png.starts_with(b"\x89PNG"));
    let svg = std::fs::read_to_string(out.join("heat/stiffness-porosity.svg")).expect("a picture");
    assert!(svg.contains("growth") && svg.contains("iterated (default)"));

    // What was run is not run again: the run folders keep what was put there.
    let cell = out.join("cells/stiffness-porosity/1e-3_0.1/iterated");
    std::fs::write(cell.join("logs/mine.txt"), "").expect("written");
    let second = document(&stability(folder.path(), &arguments));
    assert_eq!(second["counts"], found["counts"]);
    assert!(cell.join("logs/mine.txt").exists());
}

#[test]
fn the_maps_of_space_are_those_of_the_plane_and_the_default_is_stable_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = |dimension: &str| -> Vec<String> {
        let list = document(&stability(
            folder.path(),
            &["--dimension", dimension, "--list", "--json"],
        ));
        let maps = list.as_array().expect("a list").iter();
        maps.map(|map| {
            assert_eq!(map["dimension"].to_string(), dimension);
            map["name"].as_str().expect("a name").to_owned()
        })
        .collect()
    };
    assert_eq!(names("2"), names("3"));
    let arguments = [
        "--dimension",
        "3",
        "--quick",
        "--axes",
        "stiffness-porosity",
        "--json",
    ];
    let output = stability(folder.path(), &arguments);
    let found = document(&output);
    println!("{:#}", found["counts"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(found["maps"][0]["dimension"], 3);
    assert_eq!(found["counts"]["iterated"]["stable"], 12);
    assert!(found["counts"]["explicit"]["growth"].as_u64() >= Some(1));
    let out = folder.path().join("stability-3d");
    let table = std::fs::read_to_string(out.join("stability.csv")).expect("a table");
    assert_eq!(table.lines().count(), 1 + 12 + 3 * 4);
    let refused = stability(folder.path(), &["--dimension", "4"]);
    let words = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2));
    assert!(words.contains("2, the plane, or 3, space"), "{words}");
}

#[test]
fn pairs_of_axes_are_listed_and_an_unknown_one_is_refused_with_the_nearest() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = document(&stability(folder.path(), &["--list", "--json"]));
    let maps = list.as_array().expect("a list");
    println!("{} maps", maps.len());
    assert!(maps.iter().any(|map| map["name"] == "radius-contacts"));
    let refused = stability(folder.path(), &["--axes", "stifness-porosity"]);
    let words = String::from_utf8_lossy(&refused.stderr);
    println!("{words}");
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        words.contains("did you mean stiffness-porosity?"),
        "{words}"
    );
    assert!(!folder.path().join("stability").exists());
}
