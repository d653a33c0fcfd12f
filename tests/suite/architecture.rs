//! Who depends on whom: `space` on nobody, `protocol` on it, every product crate on these two; the
//! coupler and the orchestrator also on `recording`, the crates of the orchestrator on each other in one
//! direction.

use std::process::Command;

/// What a package may depend on among its siblings.
fn allowed(name: &str) -> &'static [&'static str] {
    match name {
        "space" => &[],
        "protocol" => &["space"],
        "coupler" | "scene" => &["space", "protocol", "recording"],
        "run" => &["space", "protocol", "recording", "scene"],
        "show" | "conform" => &["space", "protocol", "recording", "scene", "run"],
        "study" | "stability" => &["protocol", "scene", "run", "show"],
        "sillage" => &[
            "protocol",
            "recording",
            "scene",
            "run",
            "show",
            "study",
            "stability",
            "conform",
        ],
        _ => &["space", "protocol"],
    }
}

#[test]
fn nobody_links_an_engine_and_only_one_file_of_an_engine_names_the_protocol() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(root)
        .output()
        .expect("cargo metadata");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let siblings: Vec<&str> = packages
        .iter()
        .filter_map(|package| package["name"].as_str())
        .collect();
    println!("| package | depends on siblings |");
    for package in packages {
        let name = package["name"].as_str().expect("a name");
        let mut on: Vec<&str> = package["dependencies"]
            .as_array()
            .expect("dependencies")
            .iter()
            .filter(|dependency| dependency["kind"].is_null())
            .filter_map(|dependency| dependency["name"].as_str())
            .filter(|dependency| siblings.contains(dependency))
            .collect();
        on.sort_unstable();
        println!("| {name} | {on:?} |");
        if name == "tests" {
            continue;
        }
        let allowed = allowed(name);
        let foreign: Vec<&&str> = on.iter().filter(|on| !allowed.contains(on)).collect();
        assert!(foreign.is_empty(), "{name} depends on {foreign:?}");
    }
    for engine in [
        "fluid-solver",
        "particle-solver",
        "engines/prescribed-fluid",
        "engines/frozen-particles",
        "engines/rapier-particles",
    ] {
        let naming = files_naming_the_protocol(&format!("{root}/{engine}/src"));
        println!("{engine}: {naming:?}");
        assert!(
            naming
                .iter()
                .all(|file| file == "serve.rs" || file == "main.rs"),
            "{engine}: {naming:?}"
        );
    }
}

/// The orchestrator links no engine and tells this bound from its own copy.
#[test]
fn the_bound_that_a_plan_tells_is_that_of_the_engine() {
    use scene::plan::choices;
    let (told, own) = (
        choices::CREEPING_REYNOLDS,
        fluid_solver::config::CREEPING_REYNOLDS,
    );
    println!("Reynolds number below which convection is left out: {told}");
    assert_eq!(told, own);
}

fn files_naming_the_protocol(folder: &str) -> Vec<String> {
    let mut naming = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        if text.contains("protocol::") {
            naming.push(
                path.file_name()
                    .expect("a name")
                    .to_string_lossy()
                    .into_owned(),
            );
        }
    }
    naming
}
