//! Every shipped scene is valid by the schema, and so is every point of the studies; every value of them and
//! of a scene with every key is changed in every way that a schema may see.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use scene::document::Document;
use toml::Value;

use crate::schema;
use crate::validator::{complaint, plain};

/// Keys whose numbers the program alone refuses, as they go with others or with what is there.
const BEYOND: [&str; 16] = [
    "coupling.adaptive.step_max", // step_min
    "fluid.domain.box.upper",
    "fluid.domain.rectangle.upper",
    "grains.box.upper",
    "grains.lattice.upper",
    "grains.radius.max",   // min
    "numbers of a vector", // how many dimensions the scene has
    "output.every",        // the smallest step, how many states there are
    "output.fields",       // is there a fluid, are there grains?
    "particles.domain.upper",
    "run.coupling_step", // end_time
    "run.step_min",      // coupling_step
    "walls.corners",     // are they flat, how many dimensions?
    "walls.cylinder",    // its two ends
    "walls.to",          // from
    "walls.velocity",    // the way of the wall
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn in_folder(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).expect(folder);
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect()
}

/// Every scene that is shipped: those to run, of studies, of engines, and the one that `conform` plays.
fn shipped() -> Vec<PathBuf> {
    let engines = std::fs::read_dir(root().join("engines")).expect("engines");
    let engines = engines.map(|entry| entry.expect("an entry").path().join("scene.toml"));
    let mut paths: Vec<PathBuf> = engines.filter(|path| path.exists()).collect();
    paths.extend(in_folder("scenes"));
    paths.extend(in_folder("studies/scenes"));
    paths.push(root().join("orchestration/conform/src/scene.toml"));
    paths.sort();
    paths
}

/// Scenes that have every key there is.
fn every_key() -> [PathBuf; 4] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/every-key");
    ["rectangle.toml", "mesh.toml", "refined.toml", "space.toml"].map(|name| folder.join(name))
}

fn load(path: &Path, settings: &[String]) -> Document {
    Document::load(path, settings).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene with another tree.
fn with_tree(path: &Path, tree: Value) -> Document {
    let mut document = Document::parse(path, String::new(), &[]).expect("TOML");
    document.tree = tree;
    document
}

#[test]
fn every_shipped_scene_is_valid_by_the_schema() {
    let paths = shipped();
    for path in &paths {
        println!("{}", path.display());
        schema::takes(&load(path, &[]));
    }
    assert!(paths.len() >= 22, "{} scenes", paths.len());
}

#[test]
fn every_point_of_the_studies_is_valid_by_the_schema() {
    let mut points = 0;
    for path in in_folder("studies") {
        let text = std::fs::read_to_string(&path).expect("a study");
        let study: Value = toml::from_str(&text).expect("TOML");
        let Some(scene) = study.get("scene").and_then(Value::as_str) else {
            continue;
        };
        let scene = path.parent().expect("a folder").join(scene);
        let own = settings(&study);
        for point in list(&study, "axis").flat_map(|axis| list(axis, "points")) {
            schema::takes(&load(&scene, &[own.clone(), settings(point)].concat()));
            points += 1;
        }
    }
    println!("{points} points");
    assert!(points >= 50);
}

/// Settings of a study, or of a point of it.
fn settings(table: &Value) -> Vec<String> {
    let words = list(table, "set").map(|word| word.as_str().expect("KEY=VALUE"));
    words.map(str::to_string).collect()
}

fn list<'a>(table: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    let entries = table.get(key).and_then(Value::as_array);
    entries.into_iter().flatten()
}

#[test]
fn the_schema_names_every_key_and_lets_no_other_pass() {
    let schema = scene::keys::scene_schema();
    let documents = every_key().map(|path| load(&path, &[]));
    let mut used = BTreeSet::new();
    for document in &documents {
        keys_of(&document.tree, &mut used);
    }
    let mut tables = 0;
    let definitions = schema["$defs"].as_object().expect("definitions").values();
    for table in definitions.chain([&schema]) {
        let Some(properties) = table["properties"].as_object() else {
            continue;
        };
        assert_eq!(table["additionalProperties"], false, "{table:#}");
        for key in properties.keys() {
            assert!(
                used.contains(key.as_str()),
                "{key} is in no scene of those that have every key"
            );
        }
        tables += 1;
    }
    println!("{} keys in {tables} tables", used.len());
    assert!(!schema.to_string().contains("null"), "TOML has none");
    let laws = schema["$defs"]["DragLaw"]["oneOf"].as_array();
    assert!(laws.map_or(0, Vec::len) >= 7, "{laws:?}");
}

/// Every name of a key.
fn keys_of<'a>(value: &'a Value, found: &mut BTreeSet<&'a str>) {
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| {
            found.insert(key);
            keys_of(value, found);
        }),
        Value::Array(list) => list.iter().for_each(|value| keys_of(value, found)),
        _ => {}
    }
}

#[test]
fn the_schema_refuses_what_the_reader_refuses_and_nothing_that_the_program_takes() {
    let paths = shipped().into_iter().chain(every_key());
    let (mut trees, mut beyond) = (0, BTreeSet::new());
    for path in paths {
        let document = load(&path, &[]);
        schema::takes(&document);
        scene::from_document(&document, 1).unwrap_or_else(|error| panic!("{error}"));
        for tree in changes(&document.tree) {
            trees += 1;
            compare(&with_tree(&path, tree), &mut beyond);
        }
    }
    println!("{trees} trees; the program alone refuses {beyond:#?}");
    assert_eq!(Vec::from_iter(beyond), BEYOND);
}

/// Hold the schema against the program; keys that only the program refuses.
fn compare(document: &Document, beyond: &mut BTreeSet<String>) {
    let complaint = complaint(document);
    let problems = match (scene::problems_of_keys(document), &complaint) {
        (Ok(problems), _) => problems,
        (Err(_), Some(_)) => return,
        // The schema does not know in how many dimensions a scene is.
        (Err(error), None) if error.to_string().contains("numbers, must have") => {
            beyond.insert("numbers of a vector".to_owned());
            return;
        }
        (Err(error), None) => panic!("taken by the schema: {error}\n{:#?}", document.tree),
    };
    match complaint {
        None => beyond.extend(problems.iter().map(|problem| plain(&problem.key))),
        Some(complaint) if problems.is_empty() => {
            let loaded = scene::from_document(document, 1);
            assert!(loaded.is_err(), "refused by the schema alone: {complaint}");
        }
        Some(_) => {}
    }
}

/// What a value is changed into.
fn others() -> [Value; 9] {
    [
        Value::Integer(-1),
        Value::Integer(0),
        Value::Float(0.5),
        Value::Float(1.5),
        Value::Float(f64::NAN),
        Value::String("word".into()),
        Value::Boolean(true),
        Value::Array(Vec::new()),
        Value::Table(toml::Table::new()),
    ]
}

/// A tree with one value changed, taken away, or put in, everywhere.
fn changes(tree: &Value) -> Vec<Value> {
    let mut changed = Vec::from(others());
    match tree {
        Value::Table(table) => {
            for (key, value) in table {
                let with = |new: Option<Value>| {
                    let mut table = table.clone();
                    match new {
                        Some(new) => table.insert(key.clone(), new),
                        None => table.remove(key),
                    };
                    Value::Table(table)
                };
                changed.push(with(None));
                changed.extend(changes(value).into_iter().map(|new| with(Some(new))));
            }
            let mut more = table.clone();
            more.insert("no_such_key".into(), Value::Float(1.0));
            changed.push(Value::Table(more));
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                let with = |new: Value| {
                    let mut list = list.clone();
                    list[index] = new;
                    Value::Array(list)
                };
                changed.extend(changes(value).into_iter().map(with));
            }
            let more = list.iter().chain(list.last()).cloned();
            changed.push(Value::Array(more.collect()));
            changed.push(Value::Array(list[..list.len().saturating_sub(1)].to_vec()));
        }
        _ => {}
    }
    changed
}
