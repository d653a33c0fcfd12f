//! Engines in C under `sillage conform`, and what is wrong with their calls.

use std::process::Command;

use crate::programs::{NO_LEAKS, compile, sillage, text};

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
    for (seat, source, skipped) in [
        ("particles", "examples/falling.c", 1),
        ("fluid", "examples/stream.c", 2),
    ] {
        let program = compile(source, folder.path());
        let mut command = sillage();
        command.args(["conform", "--as", seat, "--"]).arg(program);
        if seat == "fluid" {
            command.args(["0.01", "0"]);
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
