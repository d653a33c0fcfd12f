//! What a schema can say beyond the types: ranges of numbers, and which keys go together. `check` refuses
//! the same in words, and what no schema can say.

use protocol::monitor::columns;
use schemars::Schema;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::{Value, json};

/// Solid fraction of the densest packing of equal disks; that of equal spheres is 0.7405.
pub const DENSEST: f64 = 0.9069;

/// Greater than 0.
pub fn positive(schema: &mut Schema) {
    schema.insert("exclusiveMinimum".into(), json!(0));
}

/// 0 or more.
pub fn not_negative(schema: &mut Schema) {
    schema.insert("minimum".into(), json!(0));
}

/// 1 or more; of a list, each of its numbers.
pub fn one_or_more(schema: &mut Schema) {
    match schema.get_mut("items").and_then(Value::as_object_mut) {
        Some(items) => items.insert("minimum".into(), json!(1)),
        None => schema.insert("minimum".into(), json!(1)),
    };
}

/// Between 0 and 1, both excluded.
pub fn tolerance(schema: &mut Schema) {
    positive(schema);
    schema.insert("exclusiveMaximum".into(), json!(1));
}

/// Greater than 0 and less than the densest packing.
pub fn solid_fraction(schema: &mut Schema) {
    positive(schema);
    schema.insert("exclusiveMaximum".into(), json!(DENSEST));
}

/// Not empty: a list, a map.
pub fn not_empty(schema: &mut Schema) {
    let key = match schema.get("type").and_then(Value::as_str) {
        Some("object") => "minProperties",
        _ => "minItems",
    };
    schema.insert(key.into(), json!(1));
}

/// Names of fields that are written.
pub fn written_fields(schema: &mut Schema) {
    let names = columns::WRITTEN.map(|field| field.name());
    schema.insert("items".into(), json!({ "enum": names }));
}

/// A table with exactly one of these keys.
pub fn exactly_one_of(keys: &'static [&'static str]) -> impl Transform {
    let each: Vec<Value> = keys
        .iter()
        .map(|key| json!({ "required": [key] }))
        .collect();
    move |schema: &mut Schema| {
        schema.insert("oneOf".into(), json!(each));
    }
}

/// Somewhere cells are small, and a margin is one of grains.
pub fn refined_somewhere(schema: &mut Schema) {
    let somewhere = json!([{ "required": ["near_grains"] }, { "required": ["regions"] }, { "required": ["indicator"] }]);
    schema.insert("anyOf".into(), somewhere);
    schema.insert(
        "dependentRequired".into(),
        json!({ "margin": ["near_grains"] }),
    );
}

/// A scale belongs to a mesh.
pub fn scale_of_mesh(schema: &mut Schema) {
    schema.insert("dependentRequired".into(), json!({ "scale": ["mesh"] }));
}

/// Density and radius of a population come from its file, or stand in the scene.
pub fn grain_properties(schema: &mut Schema) {
    schema.insert("if".into(), json!({ "required": ["file"] }));
    schema.insert("then".into(), json!({ "properties": { "radius": false } }));
    schema.insert("else".into(), json!({ "required": ["density", "radius"] }));
}

/// Fluid, grains or both; contacts where there are grains, a scheme where there are both.
pub fn parts(schema: &mut Schema) {
    let grains = json!({ "required": ["grains"], "properties": { "grains": { "minItems": 1 } } });
    let both = json!({ "required": ["fluid"], "allOf": [grains] });
    let scheme = json!({ "required": ["coupling"], "properties": { "coupling": { "required": ["scheme"] } } });
    schema.insert("anyOf".into(), json!([{ "required": ["fluid"] }, grains]));
    schema.insert(
        "allOf".into(),
        json!([
            { "if": grains, "then": { "required": ["contact"] } },
            { "if": both, "then": scheme },
        ]),
    );
}

/// A key that is left out is not there: TOML has no null.
pub fn without_null() -> impl Transform + Clone + Send {
    RecursiveTransform(|schema: &mut Schema| {
        match schema.get_mut("default") {
            Some(Value::Object(defaults)) => defaults.retain(|_, value| !value.is_null()),
            Some(Value::Null) => _ = schema.remove("default"),
            _ => {}
        }
        if let Some(Value::Array(types)) = schema.get_mut("type") {
            types.retain(|name| name != "null");
            if let [only] = &types[..] {
                let only = only.clone();
                schema.insert("type".into(), only);
            }
        }
        let Some(Value::Array(choices)) = schema.get_mut("anyOf") else {
            return;
        };
        let null = json!({ "type": "null" });
        choices.retain(|choice| *choice != null);
        if let [Value::Object(only)] = &choices[..] {
            let only = only.clone();
            schema.remove("anyOf");
            schema.ensure_object().extend(only);
        }
    })
}
