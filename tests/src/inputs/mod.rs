//! What comes from outside, as bytes: each kind is read as the programs read it, and must be taken or refused.
//!
//! The replay of the corpus (`--test inputs`) and the targets of `fuzz/` call these; a panic, a hang, or memory
//! that the bytes do not account for is a fault.

pub mod seeds;

use std::cell::RefCell;
use std::path::Path;

use coupler::checkpoint::Kept;
use gmsh::{Options, survey};
use protocol::codec;
use protocol::engine::{FluidEngine, InitialGrains, ParticleEngine};
use protocol::field::Field;
use protocol::header::{Expected, FieldHeader, Stage};
use protocol::message::{FromOrchestrator, ToCoupler, ToEngine, ToOrchestrator};
use protocol::runspace::RunSpace;
use recording::Reader;
use scene::document::Document;
use tempfile::TempDir;

use crate::grains::disks;

/// Reads one kind of input.
pub type Target = fn(&[u8]);

/// All kinds, by the names of their folders in `fuzz/corpus`.
pub const TARGETS: [(&str, Target); 8] = [
    ("scene", scene),
    ("mesh", mesh),
    ("csv", csv),
    ("recording", recording),
    ("checkpoint", checkpoint),
    ("message", message),
    ("header", header),
    ("token", token),
];

/// The text of a scene, with the grains that it places.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    // Files beside it: none.
    let path = in_folder(|folder| folder.join("scene.toml"));
    if let Ok(document) = Document::parse(&path, text.to_owned(), &[]) {
        let _ = scene::from_document(&document, 1);
    }
}

/// A file of Gmsh, in the plane and in space.
pub fn mesh(bytes: &[u8]) {
    let Ok(file) = gmsh::File::parse(Path::new("mesh.msh"), bytes) else {
        return;
    };
    let options = Options::default();
    if let Ok(mesh) = gmsh::Mesh::<2, 3>::of(&file, &options) {
        survey::quality(&mesh);
    }
    let _ = gmsh::Mesh::<3, 4>::of(&file, &options);
    survey::groups::<2>(&file);
}

/// A table of grains.
pub fn csv(bytes: &[u8]) {
    in_folder(|folder| {
        let path = folder.join("grains.csv");
        std::fs::write(&path, bytes).expect("written");
        let _ = scene::grains::of_run(&path, 2);
    });
}

/// A recording, read to its end.
pub fn recording(bytes: &[u8]) {
    in_folder(|folder| {
        let path = folder.join("exchange.mcap");
        std::fs::write(&path, bytes).expect("written");
        if let Ok(mut reader) = Reader::open(&path) {
            while let Ok(Some(_)) = reader.next_entry() {}
            reader.ending();
        }
    });
}

/// A file of a checkpoint; the first byte says which.
pub fn checkpoint(bytes: &[u8]) {
    let Some((which, content)) = bytes.split_first() else {
        return;
    };
    KEEPERS.with_borrow_mut(|keepers| {
        let step = keepers.folder.path().join("checkpoints/step-000000000001");
        std::fs::create_dir_all(&step).expect("made");
        let file = |name: &str, content: &[u8]| {
            let path = step.join(name);
            std::fs::write(&path, content).expect("written");
            path
        };
        match which % 4 {
            0 => _ = keepers.fluid.restore(&file("fluid", content)),
            1 => {
                // A checksum that fits: what is behind it is to be looked at.
                let sum = content
                    .iter()
                    .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
                        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
                    });
                let whole = [content, &sum.to_le_bytes()].concat();
                _ = keepers.particles.restore(&file("particles", &whole));
            }
            2 => {
                file("coupler", content);
                let scene = crate::scene(None, None, 1.0, 1);
                _ = Kept::<2>::read(&step, &scene);
            }
            _ => {
                file("manifest.json", content);
                _ = run::folder::checkpoint::newest(keepers.folder.path(), None, |_| {});
            }
        }
    });
}

/// A control message to any process.
pub fn message(bytes: &[u8]) {
    let _ = codec::decode::<ToEngine>(bytes);
    let _ = codec::decode::<ToCoupler>(bytes);
    let _ = codec::decode::<ToOrchestrator>(bytes);
    let _ = codec::decode::<FromOrchestrator>(bytes);
}

/// The header of a field, and its payload.
pub fn header(bytes: &[u8]) {
    let Some((head, payload)) = bytes.split_at_checked(64) else {
        return;
    };
    let mut words = head.chunks_exact(4).map(|word| {
        let word: [u8; 4] = word.try_into().unwrap_or_default();
        u32::from_le_bytes(word)
    });
    let mut word = || words.next().unwrap_or_default();
    let long = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    let header = FieldHeader {
        protocol: word(),
        field: word(),
        epoch: long(word(), word()),
        step: long(word(), word()),
        pass: word(),
        stage: word(),
        components: word(),
        reserved: word(),
        count: long(word(), word()),
        time: f64::from_bits(long(word(), word())),
        check: long(word(), word()),
    };
    let numbers = payload.chunks_exact(8).map(|number| {
        let number: [u8; 8] = number.try_into().unwrap_or_default();
        f64::from_le_bytes(number)
    });
    let numbers: Vec<f64> = numbers.collect();
    let _ = header.validate_message("fluid", payload.len());
    let expected = Expected {
        field: Field::from_id(header.field).unwrap_or(Field::Porosity),
        epoch: 1,
        step: 1,
        pass: 0,
        stage: Stage::Done,
        dimension: 2,
        entities: 3,
        time: 0.5,
    };
    let _ = header.validate("fluid", &expected, &numbers);
}

/// What stands in the folder of a run in shared memory: its token, and who has a seat.
pub fn token(bytes: &[u8]) {
    let runspace = RunSpace::create().expect("shared memory");
    let root = Path::new("/dev/shm").join(format!("sillage-{}", runspace.id()));
    std::fs::write(root.join("token"), bytes).expect("written");
    std::fs::write(root.join("members/fluid"), bytes).expect("written");
    runspace.to_environment();
    runspace.stopped();
    let _ = RunSpace::leftovers();
    if let Ok(name) = str::from_utf8(bytes) {
        let _ = RunSpace::named(name);
    }
}

/// Engines with a state of their own, and a folder of a run.
struct Keepers {
    folder: TempDir,
    fluid: fluid_solver::serve::Engine,
    particles: particle_solver::serve::Engine,
}

thread_local! {
    static KEEPERS: RefCell<Keepers> = RefCell::new(Keepers::new());
}

impl Keepers {
    fn new() -> Keepers {
        let folder = tempfile::tempdir().expect("a folder");
        let mut fluid = fluid_solver::serve::Engine::default();
        let (gravity, square) = ([0.0, -1.0], ([0.0; 2], [1.0; 2], [2, 2]));
        let told = fluid.configure(&crate::fluid(
            1.0, 1.0, gravity, square.0, square.1, square.2,
        ));
        assert!(told.is_ok());
        let mut particles = particle_solver::serve::Engine::default();
        let told = particles.configure(&crate::particles(gravity), two_grains());
        assert!(told.is_ok());
        Keepers {
            folder,
            fluid,
            particles,
        }
    }
}

fn two_grains() -> InitialGrains {
    disks(&[[0.25, 0.5], [0.75, 0.5]], &[0.1, 0.1], 2.0)
}

fn in_folder<T>(work: impl FnOnce(&Path) -> T) -> T {
    KEEPERS.with_borrow(|keepers| work(keepers.folder.path()))
}
