//! The dependency law (ARCHITECTURE.md), read from `cargo metadata` and from the files.

use std::path::Path;
use std::process::Command;

use crate::sources::{crates, root, sources};

/// Which siblings a crate may name outside of its tests. Nobody may name an engine or the coupler.
fn allowed(name: &str) -> &'static [&'static str] {
    match name {
        "space" => &[],
        "protocol" | "gmsh" => &["space"],
        "coupler" => &["space", "protocol", "recording"],
        "scene" => &["space", "gmsh", "protocol", "recording"],
        "fluid-solver" => &["space", "gmsh", "protocol"],
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
        // Solvers, kits and engines.
        _ => &["space", "protocol"],
    }
}

fn siblings() -> Vec<(String, Vec<String>)> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(root())
        .output()
        .expect("cargo metadata");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let name = |value: &serde_json::Value| value["name"].as_str().expect("a name").to_owned();
    let all: Vec<String> = packages.iter().map(name).collect();
    let on = |package: &serde_json::Value| {
        let dependencies = package["dependencies"].as_array().expect("dependencies");
        let product = dependencies.iter().filter(|on| on["kind"].is_null());
        let mut on: Vec<String> = product.map(name).filter(|on| all.contains(on)).collect();
        on.sort_unstable();
        on
    };
    packages
        .iter()
        .map(|package| (name(package), on(package)))
        .collect()
}

#[test]
fn crates_depend_on_each_other_as_the_law_says_and_nobody_links_an_engine() {
    println!("| crate | depends on |");
    for (name, on) in siblings().iter().filter(|(name, _)| name != "tests") {
        println!("| {name} | {} |", on.join(", "));
        let allowed = allowed(name);
        let beyond: Vec<_> = on
            .iter()
            .filter(|on| !allowed.contains(&on.as_str()))
            .collect();
        assert!(beyond.is_empty(), "{name} names {beyond:?}");
    }
}

#[test]
fn only_serve_and_main_of_an_engine_name_the_protocol() {
    for folder in crates() {
        let name = folder.strip_prefix(root()).expect("below the root");
        let engine = name == Path::new("fluid-solver")
            || name == Path::new("particle-solver")
            || (name.starts_with("engines") && !name.starts_with("engines/kit"));
        if !engine {
            continue;
        }
        let naming: Vec<_> = sources(&folder)
            .into_iter()
            .filter(|source| source.text.contains("protocol::"))
            .map(|source| {
                source
                    .path
                    .strip_prefix(name)
                    .expect("of the crate")
                    .to_path_buf()
            })
            .collect();
        println!("{}: {naming:?}", name.display());
        for file in naming {
            let allowed = ["src/serve.rs", "src/main.rs"].map(Path::new);
            assert!(
                allowed.contains(&file.as_path()),
                "{}: {}",
                name.display(),
                file.display()
            );
        }
    }
}

#[test]
fn only_the_command_knows_how_it_is_called_and_only_a_main_ends_the_process() {
    for folder in crates() {
        for source in sources(&folder) {
            let path = source.path.display();
            let command = source.path.starts_with("orchestration/sillage");
            if source.path.starts_with("orchestration") && !command {
                assert!(!source.text.contains("clap"), "{path} names clap");
            }
            if source.text.contains("process::exit(") {
                assert!(source.path.ends_with("main.rs"), "{path} ends the process");
            }
        }
    }
}
