//! Tells the program which commit it was built from, and with which version of the transport.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=../../.git/logs/HEAD");
    println!("cargo:rerun-if-changed=../../Cargo.lock");
    let git = Command::new("git")
        .args(["rev-parse", "--short=12", "HEAD"])
        .output();
    let commit = match git {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).into_owned()
        }
        _ => String::new(),
    };
    println!("cargo:rustc-env=SILLAGE_COMMIT={}", commit.trim());
    println!(
        "cargo:rustc-env=SILLAGE_ICEORYX2={}",
        locked_version("iceoryx2")
    );
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
