//! Inputs to begin with: of each kind some that are right, from the files of the repository and from what the
//! programs write.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use coupler::checkpoint::Kept;
use coupler::clock::Clock;
use protocol::codec;
use protocol::engine::{FluidEngine, ParticleEngine};
use protocol::header::FieldHeader;
use protocol::message::{Diagnostic, FromOrchestrator, ToOrchestrator};
use recording::{Body, Entry, Reader};

use super::Keepers;

/// Messages and fields of a recording that are taken: later ones are like those before.
const ENTRIES: usize = 200;

/// Inputs of a kind.
pub fn of(kind: &str) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    match kind {
        "scene" => ["scenes", "orchestration/scene/tests/suite/every-key"]
            .iter()
            .flat_map(|folder| files(&root.join(folder), "toml"))
            .collect(),
        "mesh" => files(&root.join("protocol/gmsh/tests/files"), "msh"),
        "csv" => {
            let mut all = files(&root.join("scenes/data"), "csv");
            all.push("x [m], radius [um], y;density [g/cm3]\n1,2,3,4\n".into());
            all.push("\u{feff}x;y;radius;density;fixed\r\n\r\n0;1;1e-3;2500;1\r\n".into());
            all
        }
        "recording" => recordings().iter().map(|path| bytes(path)).collect(),
        "checkpoint" => checkpoints(),
        "message" => messages(),
        "header" => entries().iter().map(header).collect(),
        "token" => vec![
            b"0123456789abcdefghijklmno".to_vec(),
            format!("{} 17\n", std::process::id()).into_bytes(),
        ],
        _ => Vec::new(),
    }
}

/// What fuzzing has found of a kind.
pub fn found(kind: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = paths(&folder.join("../fuzz/corpus").join(kind), |_| true);
    all.iter().map(|path| bytes(path)).collect()
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn paths(folder: &Path, wanted: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| wanted(path));
    paths.sort();
    paths
}

fn ends(with: &str) -> impl Fn(&Path) -> bool {
    move |path| path.extension().is_some_and(|this| this == with)
}

fn files(folder: &Path, end: &str) -> Vec<Vec<u8>> {
    let paths = paths(folder, ends(end));
    paths.iter().map(|path| bytes(path)).collect()
}

fn recordings() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
    paths(&folder, ends("mcap"))
}

/// The first entries of each recording, one of a kind.
fn entries() -> Vec<Entry> {
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for path in recordings() {
        let mut reader = Reader::open(&path).expect("a recording");
        for _ in 0..ENTRIES {
            let Some(entry) = reader.next_entry().expect("whole") else {
                break;
            };
            let kind = match &entry.body {
                Body::Field(field, _) => field.name().to_owned(),
                Body::Request(message) => variant(message),
                Body::Answer(message) => variant(message),
                Body::Unreadable(_) => continue,
            };
            if seen.insert((entry.seat.seat(), kind)) {
                all.push(entry);
            }
        }
    }
    all
}

/// The name of a message.
fn variant(message: &impl std::fmt::Debug) -> String {
    let text = format!("{message:?}");
    let end = text.find(|c: char| !c.is_alphanumeric());
    text[..end.unwrap_or(text.len())].to_owned()
}

fn messages() -> Vec<Vec<u8>> {
    let numbers = vec![Diagnostic {
        name: "time".to_owned(),
        value: 0.5,
    }];
    let to_orchestrator = [
        ToOrchestrator::Step(numbers.clone()),
        ToOrchestrator::Checkpoint { step: 3, time: 0.5 },
        ToOrchestrator::Stopped {
            code: 7,
            why: "porosity".to_owned(),
            totals: numbers,
        },
    ];
    let exchanged = entries();
    let exchanged = exchanged.iter().filter_map(|entry| match &entry.body {
        Body::Request(message) => codec::encode(message).ok(),
        Body::Answer(message) => codec::encode(message).ok(),
        _ => None,
    });
    let told = to_orchestrator.iter().filter_map(|m| codec::encode(m).ok());
    let stop = codec::encode(&FromOrchestrator::Stop).ok();
    exchanged.chain(told).chain(stop).collect()
}

/// 64 bytes and the numbers after them.
fn header(entry: &Entry) -> Vec<u8> {
    let FieldHeader {
        protocol,
        field,
        epoch,
        step,
        pass,
        stage,
        components,
        reserved,
        count,
        time,
        check,
    } = entry.header;
    let mut bytes = Vec::new();
    bytes.extend([protocol, field].map(u32::to_le_bytes).as_flattened());
    bytes.extend([epoch, step].map(u64::to_le_bytes).as_flattened());
    let words = [pass, stage, components, reserved];
    bytes.extend(words.map(u32::to_le_bytes).as_flattened());
    bytes.extend(
        [count, time.to_bits(), check]
            .map(u64::to_le_bytes)
            .as_flattened(),
    );
    if let Body::Field(_, values) = &entry.body {
        bytes.extend(values.iter().take(12).flat_map(|value| value.to_le_bytes()));
    }
    bytes
}

/// What the programs keep, after a byte that says what it is.
fn checkpoints() -> Vec<Vec<u8>> {
    let Keepers {
        folder,
        mut fluid,
        mut particles,
    } = Keepers::new();
    let path = |name: &str| folder.path().join(name);
    assert!(fluid.save(&path("fluid")).is_ok());
    assert!(particles.save(&path("particles")).is_ok());
    let scene = crate::scene(None, Some(crate::particles([0.0, -1.0])), 1.0, 1);
    let clock = Clock::new(&scene).memory();
    let simulation = crate::couple(scene, &super::two_grains());
    let kept = Kept::of(&simulation, clock, &[], Some(3));
    kept.write(folder.path()).expect("written");
    let mut particles = bytes(&path("particles"));
    // The checksum is made anew.
    particles.truncate(particles.len() - 8);
    let outputs = br#"{"format":1,"versions":{"sillage":"0.1.0"},"step":1,"time":0.5,"engines":[],"parts":{"outputs":{"bytes":3,"crc32":7}},"checksum":0}"#;
    let parts = [
        bytes(&path("fluid")),
        particles,
        bytes(&path(protocol::checkpoints::COUPLER)),
        outputs.to_vec(),
    ];
    let numbered = parts.into_iter().zip(0_u8..);
    numbered
        .map(|(part, which)| [&[which], &part[..]].concat())
        .collect()
}
