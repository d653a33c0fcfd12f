//! JSON Schemas of the protocol's enums, for editors.

use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::Value;

/// Names of the drag laws.
pub const DRAG_LAWS: [&str; 7] = [
    "dallavalle",
    "di-felice",
    "wen-yu",
    "gidaspow",
    "beetstra",
    "stokes",
    "migflow",
];

pub(super) fn drag(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": DRAG_LAWS })
}

pub(super) fn convection(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": [true, false, "auto"] })
}

pub(super) fn time_scheme(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["backward-euler", "bdf2", "steady"] })
}

pub(super) fn viscous_form(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["symmetric", "paper-literal"] })
}

pub(super) fn compression(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["zstd", "none"] })
}

pub(super) fn diagonals(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["alternate", "uniform"] })
}

pub(super) fn profile(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": ["uniform", "parabolic"] })
}

pub(super) fn nonlinear(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "oneOf": [
        { "const": "picard" },
        tagged("newton", &[("tolerance", "number"), ("iterations_max", "integer")]),
    ] })
}

pub(super) fn scheme(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "oneOf": [
        { "enum": ["staggered", "semi-implicit", "explicit"] },
        tagged("iterated", &[("tolerance", "number"), ("passes_max", "integer")]),
    ] })
}

pub(super) fn geometry(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "oneOf": [{ "const": "disk" }, tagged("sphere", &[("depth", "number")])] })
}

pub(super) fn adaptive(_: &mut SchemaGenerator) -> Schema {
    let keys = [
        ("step_min", "number"),
        ("step_max", "number"),
        ("courant", "number"),
    ];
    Schema::try_from(table(&keys)).unwrap_or_default()
}

/// { name = { key = …, … } } with every key required.
fn tagged(name: &str, keys: &[(&str, &str)]) -> Value {
    serde_json::json!({
        "type": "object",
        "properties": { name: table(keys) },
        "required": [name],
        "additionalProperties": false,
    })
}

fn table(keys: &[(&str, &str)]) -> Value {
    let properties: serde_json::Map<String, Value> = keys
        .iter()
        .map(|(key, kind)| (key.to_string(), serde_json::json!({ "type": kind })))
        .collect();
    let required: Vec<&str> = keys.iter().map(|(key, _)| *key).collect();
    serde_json::json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}
