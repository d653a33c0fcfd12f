//! Tells the program which commit it was built from, and with which version of the transport.

use std::process::Command;

fn main() {
    // elsewhere than in .git where this is one of several work trees: a file that is not there is stale always
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]);
    if !log.is_empty() {
        println!("cargo:rerun-if-changed={log}");
    }
    println!("cargo:rerun-if-changed=../../Cargo.lock");
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    println!("cargo:rustc-env=SILLAGE_COMMIT={commit}");
    println!(
        "cargo:rustc-env=SILLAGE_ICEORYX2={}",
        locked_version("iceoryx2")
    );
}

/// What git answers; nothing where it does not.
fn git(arguments: &[&str]) -> String {
    match Command::new("git").args(arguments).output() {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).trim().to_owned()
        }
        _ => String::new(),
    }
}

/// The version of a package in `Cargo.lock`.
fn locked_version(package: &str) -> String {
    let lock = std::fs::read_to_string("../../Cargo.lock").unwrap_or_default();
    let mut lines = lock.lines();
    lines.find(|line| *line == format!("name = \"{package}\""));
    let version = lines
        .next()
        .and_then(|line| line.strip_prefix("version = "));
    version.map_or("unknown".into(), |version| {
        version.trim_matches('"').to_string()
    })
}
