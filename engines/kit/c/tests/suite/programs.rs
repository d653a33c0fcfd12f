//! Programs: those of a run, and C files that are compiled.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Once;

/// The folder of this crate.
pub fn kit() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// `target/release` (or debug): where programs and the library are.
fn programs() -> PathBuf {
    let this = std::env::current_exe().expect("this program");
    let folder = this.ancestors().nth(2).expect("two folders up");
    folder.to_path_buf()
}

/// Where `cargo build` puts the library.
fn library() -> PathBuf {
    programs()
}

/// The programs of a run and the library, built when they are not there yet: `cargo test` alone
/// makes neither.
fn need_programs() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let names = [
            "sillage",
            "sillage-fluid",
            "sillage-particles",
            "sillage-coupler",
            "libsillage_engine.so",
        ];
        if names.iter().all(|name| programs().join(name).exists()) {
            return;
        }
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--workspace", "--bins", "--lib"]);
        if programs().ends_with("release") {
            cargo.arg("--release");
        }
        let status = cargo.current_dir(kit()).status().expect("cargo");
        assert!(status.success(), "the programs cannot be built");
    });
}

pub fn text(output: &Output) -> String {
    let (out, err) = (&output.stdout, &output.stderr);
    String::from_utf8_lossy(out).into_owned() + &String::from_utf8_lossy(err)
}

/// What the compiler adds to find reads and writes that go astray, and what the language does not define.
const SANITIZERS: [&str; 3] = [
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
];

/// The name of an engine lives as long as its process, and so does what an engine leaves to its end: no leaks.
pub const NO_LEAKS: (&str, &str) = ("ASAN_OPTIONS", "detect_leaks=0");

/// Compile a C file against the header and the library, with sanitizers where the compiler has them.
pub fn compile(source: &str, folder: &Path) -> PathBuf {
    need_programs();
    let program = folder.join(Path::new(source).file_stem().expect("a name"));
    let output = compile_with(&SANITIZERS, source, &program);
    if output.status.success() {
        return program;
    }
    println!("without sanitizers: {}", text(&output));
    let output = compile_with(&[], source, &program);
    assert!(output.status.success(), "{source}: {}", text(&output));
    program
}

fn compile_with(more: &[&str], source: &str, program: &Path) -> Output {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "gcc".to_owned());
    Command::new(&compiler)
        .args([
            "-std=c11",
            "-O2",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Wconversion",
            "-Werror",
        ])
        .args(more)
        .arg("-I")
        .arg(kit().join("include"))
        .arg(kit().join(source))
        .arg("-L")
        .arg(library())
        .args(["-lsillage_engine", "-lpthread", "-lm"])
        .arg(format!("-Wl,-rpath,{}", library().display()))
        .arg("-o")
        .arg(program)
        .output()
        .unwrap_or_else(|error| panic!("{compiler} cannot be started (set CC): {error}"))
}

pub fn sillage() -> Command {
    let mut command = Command::new(programs().join("sillage"));
    command.env(NO_LEAKS.0, NO_LEAKS.1);
    command
}
