//! Engines in C under `sillage conform`, and what is wrong with their calls and answers.

use std::process::Command;

use crate::programs::{NO_LEAKS, compile, kit, sillage, text};

#[test]
fn wrong_calls_are_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(compile("tests/misuse.c", folder.path()))
        .env(NO_LEAKS.0, NO_LEAKS.1)
        .output()
        .expect("started");
    println!("{}", text(&output));
    assert!(output.status.success());
}

#[test]
fn engines_in_c_pass_every_check() {
    let folder = tempfile::tempdir().expect("a folder");
    let space = kit().join("../../../orchestration/sillage/tests/engines/space.toml");
    let space = ["--scene".to_owned(), space.display().to_string()];
    for (seat, source, scene, skipped) in [
        ("particles", "examples/falling.c", &[][..], 0),
        ("fluid", "examples/stream.c", &[], 1),
        ("particles", "examples/falling.c", &space, 0),
        ("fluid", "examples/stream.c", &space, 1),
    ] {
        let program = compile(source, folder.path());
        let mut command = sillage();
        command.args(["conform", "--as", seat]).args(scene);
        command.arg("--").arg(program);
        if seat == "fluid" {
            command.args(["0.01", "0", "0.02"]);
        }
        let output = command.output().expect("started");
        let words = text(&output);
        println!("{words}");
        assert!(output.status.success(), "{source}");
        assert!(
            words.contains(&format!("0 failed, {skipped} skipped")),
            "{source}"
        );
    }
}

#[test]
fn wrong_answers_of_engines_in_c_are_refused_in_words() {
    let place = tempfile::tempdir().expect("a folder");
    let program = compile("tests/answers.c", place.path());
    for (seat, check, how, words) in [
        ("fluid", "adapt", "keeps", "it keeps its mesh"),
        (
            "fluid",
            "adapt",
            "silent",
            "adapt returned 1 and did not say why",
        ),
        ("fluid", "adapt", "fails", "no such triangles after 9 tries"),
        (
            "fluid",
            "adapt",
            "no-nodes",
            "mesh.node_position was left NULL",
        ),
        (
            "fluid",
            "adapt",
            "no-simplices",
            "mesh.simplex_nodes was left NULL",
        ),
        (
            "fluid",
            "adapt",
            "many-nodes",
            "nodes and 2 simplices, at most 268435456",
        ),
        (
            "fluid",
            "adapt",
            "many-simplices",
            "4 nodes and 18446744073709551615 simplices",
        ),
        (
            "fluid",
            "adapt",
            "far-node",
            "simplex 1 has node 9, there are 4",
        ),
        (
            "fluid",
            "adapt",
            "turned",
            "simplex 1 has measure -5e-1 m^2",
        ),
        ("fluid", "adapt", "odd-node", "mesh.node_position[3] is NaN"),
        (
            "fluid",
            "adapt",
            "odd-corner",
            "mesh.simplex_position[3] is NaN",
        ),
        ("fluid", "adapt", "odd-mass", "mesh.nodal_mass[3] is NaN"),
        ("fluid", "adapt", "odd-period", "mesh.period[1] is NaN"),
        (
            "particles",
            "remove",
            "silent",
            "remove returned 1 and did not say why",
        ),
        ("particles", "remove", "fails", "they hold on to each other"),
        (
            "particles",
            "remove",
            "tells-nothing",
            "grain_position of grain 0 at NaN",
        ),
        (
            "particles",
            "remove",
            "no-velocity",
            "grain_velocity of grain 0 at NaN",
        ),
        (
            "particles",
            "remove",
            "one-more",
            "remove set 28 grains, 27 are left",
        ),
        (
            "particles",
            "remove",
            "one-less",
            "remove set 26 grains, 27 are left",
        ),
        (
            "particles",
            "remove",
            "odd-mass",
            "grain_mass of grain 2 at inf",
        ),
        (
            "particles",
            "remove",
            "elsewhere",
            "grain_position of grain 0 is not what it was",
        ),
    ] {
        let mut command = sillage();
        command.args(["conform", "--as", seat, "--check", check, "--"]);
        let output = command.arg(&program).args([seat, how]).output();
        let output = output.expect("started");
        let told = text(&output);
        let code = if how == "keeps" { 0 } else { 1 };
        println!("{seat} {how}: {words}");
        assert!(told.contains(words), "{seat} {how}: {told}");
        assert_eq!(output.status.code(), Some(code), "{seat} {how}");
    }
}
