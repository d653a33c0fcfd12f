//! `sillage conform`: the built-in engines keep the contract, an engine that breaks one rule fails
//! the check of that rule and no other.

use std::process::{Command, Output};
use std::sync::Mutex;

use serde_json::Value;

use crate::background::{need_programs, programs};
use crate::conform_toy::FAULT;

fn conform(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sillage"))
        .arg("conform")
        .args(arguments)
        .output()
        .expect("started")
}

fn document(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        let words = String::from_utf8_lossy(&output.stderr);
        panic!("no JSON document ({error}): {words}")
    })
}

/// Names of the checks with this result.
fn with_result(document: &Value, result: &str) -> Vec<String> {
    let rows = document["checks"].as_array().expect("checks");
    rows.iter()
        .filter(|row| row["result"] == result)
        .map(|row| row["check"].as_str().expect("a name").to_owned())
        .collect()
}

#[test]
fn the_built_in_engines_pass_every_check() {
    need_programs();
    let space = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/engines/space.toml");
    for (seat, program, checks, scene) in [
        ("fluid", "sillage-fluid", 42, &[][..]),
        ("particles", "sillage-particles", 44, &[]),
        ("fluid", "sillage-fluid", 42, &["--scene", space]),
        ("particles", "sillage-particles", 44, &["--scene", space]),
    ] {
        let program = programs().join(program).to_string_lossy().into_owned();
        let output = conform(&[scene, &["--as", seat, "--", &program]].concat());
        let words = String::from_utf8_lossy(&output.stdout);
        println!("{words}");
        assert_eq!(output.status.code(), Some(0));
        let summary = format!("{checks} passed, 0 failed, 0 skipped");
        assert!(words.contains(&summary), "expected {summary}");
    }
}

/// Run the whole suite on the toy with a fault.
fn toy(fault: &str) -> (Option<i32>, Value) {
    let program = std::env::current_exe().expect("this program");
    let (program, fault) = (program.to_string_lossy(), format!("{FAULT}={fault}"));
    let entry = [
        "--exact",
        "conform_toy::child",
        "--nocapture",
        "--test-threads=1",
    ];
    let mut arguments = vec![
        "--as",
        "particles",
        "--limit",
        "10",
        "--json",
        "--",
        "env",
        &fault,
        &program,
    ];
    arguments.extend(entry);
    let output = conform(&arguments);
    (output.status.code(), document(&output))
}

#[test]
fn an_engine_written_by_hand_passes() {
    let (code, document) = toy("none");
    println!("{document:#}");
    assert_eq!(code, Some(0));
    assert_eq!(document["passed"], 44);
}

/// Run the whole suite for each fault, several at once; each must fail the check of its name alone.
fn each_fails_its_check(faults: &[&str]) {
    let left = Mutex::new(faults.iter());
    let wrong = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                loop {
                    let Some(&fault) = left.lock().expect("a list").next() else {
                        return;
                    };
                    let (code, document) = toy(fault);
                    let failed = with_result(&document, "failed");
                    let rows = document["checks"].as_array().expect("checks");
                    let why = rows
                        .iter()
                        .find(|row| row["check"] == fault)
                        .map(|row| row["why"].clone());
                    println!(
                        "{fault:<22} {failed:?}, {} skipped: {}",
                        document["skipped"],
                        why.unwrap_or_default()
                    );
                    if code != Some(1) || failed != [fault] {
                        let others = rows.iter().filter(|row| row["result"] == "failed");
                        let whys: Vec<String> = others
                            .map(|row| format!("{}: {}", row["check"], row["why"]))
                            .collect();
                        wrong.lock().expect("a list").push((fault, code, whys));
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().expect("a list");
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn an_engine_that_breaks_a_rule_of_the_exchange_fails_that_check_alone() {
    each_fails_its_check(&[
        "no-run",
        "hello",
        "no-coupler",
        "seat-taken",
        "ready",
        "advance",
        "defaults",
        "many-steps",
        "finish",
        "advance-first",
        "other-seat",
        "configure-twice",
        "step-left-out",
    ]);
}

#[test]
fn an_engine_that_breaks_a_rule_of_states_fails_that_check_alone() {
    each_fails_its_check(&[
        "commit-nothing",
        "commit-other-step",
        "commit-twice",
        "fresh-process",
        "same-request",
        "same-passes",
        "smaller-step",
        "larger-step",
        "discarded-candidate",
        "commit",
        "checkpoint",
        "withheld",
        "remove",
        "bad-checkpoint",
    ]);
}

#[test]
fn an_engine_that_takes_what_it_must_refuse_fails_that_check_alone() {
    each_fails_its_check(&[
        "nan",
        "infinity",
        "count",
        "epoch",
        "header",
        "request",
        "grain-count",
        "protocol-of-message",
        "protocol-of-field",
        "garbage",
    ]);
}

#[test]
fn an_engine_that_ends_badly_fails_that_check_alone() {
    each_fails_its_check(&[
        "told-to-end",
        "silent-coupler",
        "death-before-hello",
        "death-after-hello",
        "death-configured",
        "death-within-advance",
        "death-after-commit",
    ]);
}

#[test]
fn what_cannot_be_started_is_told_from_what_is_no_engine_and_from_wrong_usage() {
    for (arguments, code, words) in [
        (
            &["--as", "fluid", "--", "/no/such/engine"][..],
            4,
            "cannot be started",
        ),
        (&["--as", "fluid"], 2, "COMMAND"),
        (
            &["--as", "coupler", "--", "true"],
            2,
            "possible values: fluid, particles",
        ),
        (
            &["--as", "fluid", "--limit=-1", "--", "true"],
            2,
            "positive",
        ),
        (
            &["--as", "fluid", "--check", "speed", "--", "true"],
            2,
            "there are no-run, hello",
        ),
        (
            &["--as", "fluid", "--scene", "no.toml", "--", "true"],
            2,
            "no.toml",
        ),
    ] {
        let output = conform(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        println!("{arguments:?}: {:?} {said}", output.status.code());
        assert_eq!(output.status.code(), Some(code));
        assert!(said.contains(words), "{said}");
    }
    let output = conform(&[
        "--as",
        "fluid",
        "--json",
        "--",
        "sh",
        "-c",
        "echo no such mesh >&2; exit 9",
    ]);
    let document = document(&output);
    println!("{document:#}");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(with_result(&document, "failed"), ["no-run", "hello"]);
    let hello = document["checks"][1]["why"].as_str().expect("why");
    assert!(
        hello.contains("exit code 9") && hello.contains("no such mesh"),
        "{hello}"
    );
}
