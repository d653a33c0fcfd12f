//! What the schema that `sillage check --schema` prints has against a scene.

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

/// A key without numbers of entries.
pub fn plain(key: &str) -> String {
    key.split(['[', ']']).step_by(2).collect()
}
