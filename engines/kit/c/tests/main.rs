//! The header is what the code says, engines in C compile against it without a warning, conform, and
//! take part in a run.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Once;

use protocol::field::{Exchange, FIELDS, Rank};

const HEADER: &str = "include/sillage_engine.h";

fn kit() -> &'static Path {
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

fn text(output: &Output) -> String {
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
const NO_LEAKS: (&str, &str) = ("ASAN_OPTIONS", "detect_leaks=0");

/// Compile a C file against the header and the library, with sanitizers where the compiler has them.
fn compile(source: &str, folder: &Path) -> PathBuf {
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
        .args(["-lsillage_engine", "-lpthread"])
        .arg(format!("-Wl,-rpath,{}", library().display()))
        .arg("-o")
        .arg(program)
        .output()
        .unwrap_or_else(|error| panic!("{compiler} cannot be started (set CC): {error}"))
}

fn sillage() -> Command {
    let mut command = Command::new(programs().join("sillage"));
    command.env(NO_LEAKS.0, NO_LEAKS.1);
    command
}

/// The numbers of the fields that an engine meets in `advance`, from the table of the protocol.
fn numbers_of_fields() -> String {
    let exchanged = [
        Exchange::ToFluid,
        Exchange::FromFluid,
        Exchange::ToParticles,
        Exchange::FromParticles,
        Exchange::MaybeFromParticles,
    ];
    let mut text = String::new();
    for spec in FIELDS {
        if spec
            .sent
            .iter()
            .any(|exchange| exchanged.contains(exchange))
        {
            let name = spec.name.to_uppercase();
            let rank = match spec.rank {
                Rank::Scalar => "scalar",
                Rank::Spin => "spin",
                _ => "vector",
            };
            text += &format!(
                "\n/*\n {} ({}; {rank})\n */\n#define SILLAGE_FIELD_{name} {}\n",
                spec.meaning.trim(),
                spec.field.unit(2),
                spec.id
            );
        }
    }
    text
}

#[test]
fn the_header_is_what_cbindgen_writes() {
    let config = cbindgen::Config::from_file(kit().join("cbindgen.toml"));
    let config = cbindgen::Config {
        after_includes: Some(numbers_of_fields()),
        ..config.expect("cbindgen.toml")
    };
    let mut written = Vec::new();
    cbindgen::generate_with_config(kit(), config)
        .expect("bindings")
        .write(&mut written);
    let written = String::from_utf8(written).expect("UTF-8");
    let path = kit().join(HEADER);
    if std::env::var_os("SILLAGE_WRITE_HEADER").is_some() {
        std::fs::write(&path, &written).expect("written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = found.lines().zip(written.lines()).position(|(a, b)| a != b);
    assert!(
        found == written,
        "{HEADER} differs from line {differs:?} on; see cbindgen.toml for how to write it"
    );
}

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

#[test]
fn both_engines_in_c_make_a_run_whose_grains_move_as_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let [grains, stream] = ["examples/falling.c", "examples/stream.c"]
        .map(|source| compile(source, folder.path()).display().to_string());
    let scene = kit().join("../../prescribed-fluid/scene.toml");
    let run = folder.path().join("run");
    let output = sillage()
        .arg("run")
        .arg(&scene)
        .args([
            "--set",
            &format!("engines.particles.command=[\"{grains}\"]"),
        ])
        .args([
            "--set",
            &format!("engines.fluid.command=[\"{stream}\", \"0.01\", \"0.002\"]"),
        ])
        .args([
            "--set",
            "grains[0].density=1000.0",
            "--set",
            "grains[1].density=1000.0",
        ])
        .args([
            "--set",
            "run.end_time=0.2",
            "--set",
            "output.frames=false",
            "--out",
        ])
        .arg(&run)
        .output()
        .expect("started");
    assert!(output.status.success(), "{}", text(&output));
    let report = std::fs::read_to_string(run.join("run.json")).expect("run.json");
    assert!(report.contains("falling-c") && report.contains("stream-c"));
    let steps = std::fs::read_to_string(run.join("steps.csv")).expect("steps.csv");
    let column = |line: &str| -> f64 {
        let header = steps.lines().next().expect("a header");
        let place = header
            .split(',')
            .position(|name| name == "fall_speed")
            .expect("a column");
        line.split(',')
            .nth(place)
            .expect("a value")
            .parse()
            .expect("a number")
    };
    let rise = -column(steps.lines().last().expect("a row"));
    println!("neutral grains rise at {rise:.12} m/s in a stream of 0.002 m/s");
    assert!((rise - 0.002).abs() < 1e-9);
}
