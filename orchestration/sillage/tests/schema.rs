//! Every scene that a test hands to a command, held against the schema that `sillage check --schema` prints.

#[path = "../../scene/tests/suite/validator.rs"]
mod validator;

use std::path::Path;

use scene::Error;
use scene::document::Document;

use validator::{complaint, plain};

/// Keys that the program alone refuses, as they go with others or with what is there: sides, files, programs,
/// room. Whole numbers are among them: 80.0 is one to JSON, and none to the program.
const BEYOND: [&str; 35] = [
    "contact.sub_steps_max",
    "contact.sweeps_max",
    "coupling.adaptive.step_max",
    "coupling.scheme.iterated.passes_max",
    "engines.fluid.command",
    "engines.particles.command",
    "fluid.boundaries",
    "fluid.domain.box.cells",
    "fluid.domain.box.upper",
    "fluid.domain.mesh",
    "fluid.domain.rectangle.cells",
    "fluid.domain.rectangle.upper",
    "fluid.mean_flow",
    "fluid.nonlinear.newton.iterations_max",
    "grains",
    "grains.box",
    "grains.box.seed",
    "grains.box.upper",
    "grains.cloud",
    "grains.cloud.count",
    "grains.cloud.seed",
    "grains.file",
    "grains.lattice",
    "grains.lattice.seed",
    "grains.lattice.upper",
    "grains.radius.max",
    "output.every",
    "output.fields",
    "particles.boundaries",
    "particles.domain",
    "particles.domain.upper",
    "run.coupling_step",
    "run.step_min",
    "walls.to",
    "walls.velocity",
];

/// Hold the scene of a command against the schema, if it reads one; relative to a folder.
pub fn of_command<S: AsRef<str>>(folder: &Path, arguments: &[S]) {
    let mut words = arguments.iter().map(AsRef::as_ref);
    if !matches!(words.next(), Some("check" | "plan" | "run")) {
        return;
    }
    let Some(path) = words.find(|word| word.ends_with(".toml")) else {
        return;
    };
    let mut settings = Vec::new();
    while let Some(word) = words.next() {
        if word == "--set" {
            settings.extend(words.next().map(str::to_owned));
        }
    }
    // What is no tree, no schema can judge.
    if let Ok(document) = Document::load(&folder.join(path), &settings) {
        let keys = match scene::from_document(&document, 1) {
            Ok(_) => Vec::new(),
            Err(Error::Scene(problems)) => problems.0.into_iter().map(|p| p.key).collect(),
            Err(error) => panic!("{error}"),
        };
        agree(&document, &keys).unwrap_or_else(|why| panic!("{path} {settings:?}: {why}"));
    }
}

/// The schema refuses what the program refuses for these keys, but for those that are beyond it, and takes what
/// the program takes, which is what has no such key.
pub fn agree(document: &Document, refused: &[String]) -> Result<(), String> {
    match (complaint(document), refused) {
        (Some(complaint), []) => Err(format!("refused by the schema alone: {complaint}")),
        (Some(_), _) => Ok(()),
        (None, _) => {
            let unknown = |key: &&String| {
                !BEYOND.contains(&unnamed(key).as_str()) && !is_of_other_dimension(document, key)
            };
            match refused.iter().find(unknown) {
                Some(key) => Err(format!(
                    "{key} is refused by the program and taken by the schema"
                )),
                None => Ok(()),
            }
        }
    }
}

/// Is it a vector of another dimension than the scene's, which the schema does not know?
fn is_of_other_dimension(document: &Document, key: &str) -> bool {
    let numbers = document.value(key).and_then(|value| value.as_array());
    numbers.is_some_and(|numbers| {
        let count = numbers.len();
        (2..=3).contains(&count) && count != scene::read::dimension(document)
    })
}

/// A key without numbers of entries and names of sides.
fn unnamed(key: &str) -> String {
    let key = plain(key);
    let sides = key.find(".boundaries.").map(|at| at + ".boundaries".len());
    key[..sides.unwrap_or(key.len())].to_string()
}
