//! The schema that `sillage check --schema` prints, held against the program that reads scenes: it takes what
//! the program takes, and refuses what a schema can.

use std::sync::LazyLock;

use boon::{Compiler, SchemaIndex, Schemas};
use scene::document::Document;
use serde_json::Value;

static SCHEMA: LazyLock<(Schemas, SchemaIndex)> = LazyLock::new(|| {
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    let schema = scene::keys::scene_schema();
    let added = compiler.add_resource("scene.json", schema);
    added.expect("a place for the schema");
    let index = compiler.compile("scene.json", &mut schemas);
    let index = index.unwrap_or_else(|error| panic!("no schema: {error:#}"));
    (schemas, index)
});

/// What the schema has against a scene. JSON has no infinite numbers: null stands for them.
pub fn complaint(document: &Document) -> Option<String> {
    let (schemas, index) = &*SCHEMA;
    let tree: Value = serde_json::to_value(&document.tree).expect("a tree");
    let verdict = schemas.validate(&tree, *index);
    verdict.err().map(|error| error.to_string())
}

/// The schema takes a scene: the program takes it as well, or refuses what no schema can.
pub fn takes(document: &Document) {
    if let Some(complaint) = complaint(document) {
        panic!("refused by the schema: {complaint}\n{:#?}", document.tree);
    }
}

/// The schema refuses a scene, as the program does.
pub fn refuses(document: &Document) {
    match complaint(document) {
        Some(complaint) => println!("{complaint}"),
        None => panic!("taken by the schema: {:#?}", document.tree),
    }
}
