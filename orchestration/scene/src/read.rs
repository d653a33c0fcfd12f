//! From the document to its keys; what serde says is put in the words of a scene.

use serde_json::{Value as Json, json};
use toml::Value;

use crate::document::Document;
use crate::error::Error;
use crate::keys::{SceneFile, form as form_of};
use crate::problem::{Problem, Problems};

/// What says in how many dimensions a scene is.
const DIMENSION: &str = "the domain says it: fluid.domain.rectangle is of the plane, fluid.domain.box of space; with a \
     mesh or without a fluid the numbers of particles.domain, or of gravity";

/// What has become of the length that all grains were smoothed over.
const NO_LENGTH: &str = "no longer a key: every grain is spread over its own size, as far as the cells around \
     it need; remove this line";

/// In how many dimensions a scene is: as its domain says; without one as its first vector.
pub fn dimension(document: &Document) -> usize {
    let is_there = |key: &str| document.value(key).is_some();
    if is_there("fluid.domain.box") || is_there("fluid.domain.rectangle") {
        return if is_there("fluid.domain.box") { 3 } else { 2 };
    }
    let numbers = |key: &str| document.value(key)?.as_array().map(Vec::len);
    let vectors = ["particles.domain.lower", "gravity.acceleration"];
    match vectors.iter().find_map(|key| numbers(key)) {
        Some(3) => 3,
        _ => 2,
    }
}

/// All keys of a document; unknown keys and wrong types are refused with file and line.
pub fn read<const D: usize>(document: &Document) -> Result<SceneFile<D>, Error> {
    let read = serde_path_to_error::deserialize::<Value, SceneFile<D>>(document.tree.clone());
    let keys = read.map_err(|error| {
        let path = error.path().to_string();
        let message = error.inner().message().to_string();
        Error::Scene(Problems(vec![explain(document, &path, &message)]))
    })?;
    match out_of_form(&document.tree, &json!(keys)) {
        Some((path, message)) => {
            let problem = document.problem(path.trim_start_matches('.'), message);
            Err(Error::Scene(Problems(vec![problem])))
        }
        None => Ok(keys),
    }
}

/// A table that is written as a list of its values, or a name as a table: serde takes either, with values
/// in an order that nobody has promised. Its key, after a dot, and what is expected.
fn out_of_form(written: &Value, read: &Json) -> Option<(String, &'static str)> {
    let inside = |key: String, written: &Value, read: &Json| {
        let (path, message) = out_of_form(written, read)?;
        Some((key + &path, message))
    };
    match (written, read) {
        (Value::Table(table), Json::Object(keys)) => table
            .iter()
            .find_map(|(key, value)| inside(format!(".{key}"), value, keys.get(key)?)),
        (Value::Array(list), Json::Array(entries)) => {
            let mut pairs = list.iter().zip(entries).enumerate();
            pairs.find_map(|(index, (value, entry))| inside(format!("[{index}]"), value, entry))
        }
        (Value::Array(_), Json::Object(_)) => {
            Some((String::new(), "wrong type: list, expected a table { … }"))
        }
        (Value::Table(_), _) => Some((String::new(), "wrong type: table, expected a name alone")),
        _ => None,
    }
}

/// The problem behind a message of serde at `path`.
fn explain(document: &Document, path: &str, message: &str) -> Problem {
    let names = quoted(message);
    let (first, known) = names
        .split_first()
        .map_or(("", &[][..]), |(first, rest)| (*first, rest));
    if message.starts_with("unknown field") {
        let key = join(path, first);
        if key == "dimension" {
            return document.problem(&key, format!("not a key: {DIMENSION}"));
        }
        if key == "coupling.smoothing_length" {
            return document.problem(&key, NO_LENGTH);
        }
        return document.problem(
            &key,
            format!("unknown key{}", hint(first, known, "keys here")),
        );
    }
    if message.starts_with("unknown variant") {
        return document.problem(
            path,
            format!("not allowed{}", hint(first, known, "allowed")),
        );
    }
    if message.starts_with("missing field") {
        return document.problem(&join(path, first), missing(&join(path, first)));
    }
    let key = if path == "." { "" } else { path };
    document.problem(key, plain(message))
}

/// What to write for a key that is missing.
fn missing(key: &str) -> String {
    let example = match key {
        "run" => "[run] with end_time and coupling_step in s",
        "gravity" => "[gravity] acceleration = [0.0, -9.81] (or zeros), in m/s²",
        "fluid.boundaries" => "[fluid.boundaries] all = \"no-slip\"",
        "fluid.domain" => "[fluid.domain] with rectangle = { … }, box = { … } or mesh = \"….msh\"",
        "contact.tolerance" => "tolerance = 1e-3 (of |g| Δt)",
        _ => return "missing, and it has no default".to_string(),
    };
    format!("missing, and it has no default: write {example}")
}

/// "; did you mean `x`? (keys here: a, b)".
fn hint(word: &str, known: &[&str], label: &str) -> String {
    let list = known.join(", ");
    match nearest(word, known) {
        Some(name) => format!("; did you mean {name}? ({label}: {list})"),
        None => format!(" ({label}: {list})"),
    }
}

/// The known word nearest to `word`, when it is near enough to be meant.
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|name| {
            (
                strsim::damerau_levenshtein(word, name),
                strsim::jaro_winkler(word, name),
                *name,
            )
        })
        .filter(|(edits, likeness, name)| {
            *edits <= 1 + word.len().max(name.len()) / 4 || *likeness > 0.85
        })
        .min_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)))
        .map(|(_, _, name)| name)
}

/// Words between back quotes.
fn quoted(message: &str) -> Vec<&str> {
    message.split('`').skip(1).step_by(2).collect()
}

/// Path and key in one; serde names the key itself in some paths and its table in others.
fn join(path: &str, key: &str) -> String {
    match path {
        "." | "" => key.to_string(),
        _ if path == key || path.ends_with(&format!(".{key}")) => path.to_string(),
        _ => format!("{path}.{key}"),
    }
}

/// Rust's type names in plain words.
fn plain(message: &str) -> String {
    let mut text = message.trim().replace('\n', ", ");
    if let Some((count, form)) = text
        .strip_prefix("invalid length ")
        .and_then(|rest| rest.split_once(", expected "))
        && [form_of(2), form_of(3)].contains(&form)
    {
        return format!("has {count} numbers, must have {form}: {DIMENSION}");
    }
    for (rust, words) in [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number, 0 or more"),
        ("expected u64", "expected a whole number, 0 or more"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected a boolean", "expected true or false"),
        ("expected a sequence", "expected a list [ … ]"),
        ("expected a map", "expected a table"),
        ("invalid type: ", "wrong type: "),
        ("unit variant", "a name alone"),
    ] {
        text = text.replace(rust, words);
    }
    match text.find("expected struct ") {
        Some(at) => format!("{}expected a table {{ … }}", &text[..at]),
        None => text,
    }
}
