//! The text of a scene, and the way from a key to its line.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

use crate::error::Error;
use crate::problem::{Problem, Problems};

/// A scene as text and as a tree, with the settings of the command line applied to the tree.
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    /// The tree that is read: the file with `--set` applied.
    pub tree: Value,
    settings: Vec<String>,
}

impl Document {
    /// Read a file and apply `--set KEY=VALUE` to it.
    pub fn load(path: &Path, settings: &[String]) -> Result<Document, Error> {
        let text = std::fs::read_to_string(path).map_err(Error::file("cannot read scene", path));
        let text = text.map_err(|error| match error {
            // A scene that is not there is a usage error, not a broken disk.
            Error::File { .. } => Error::Usage(error.to_string()),
            other => other,
        })?;
        Document::parse(path, text, settings)
    }

    /// The same from text; `path` is used in messages and to find files beside the scene.
    pub fn parse(path: &Path, text: String, settings: &[String]) -> Result<Document, Error> {
        let tree = toml::from_str::<toml::Table>(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_of(&text, span.start));
            Error::Scene(Problems(vec![Problem {
                place: format!("{}:{line}", path.display()),
                key: String::new(),
                value: None,
                message: format!("not valid TOML: {}", error.message().replace('\n', ", ")),
            }]))
        })?;
        let mut document = Document {
            path: path.to_path_buf(),
            text,
            tree: Value::Table(tree),
            settings: Vec::new(),
        };
        for setting in settings {
            document.set(setting)?;
        }
        Ok(document)
    }

    /// Folder of the scene: files named in it are looked for there.
    pub fn folder(&self) -> PathBuf {
        match self.path.parent() {
            Some(parent) if parent != Path::new("") => parent.to_path_buf(),
            _ => PathBuf::from("."),
        }
    }

    /// Name of the scene: its file name without `.toml`.
    pub fn name(&self) -> String {
        self.path
            .file_stem()
            .map_or("scene".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// The text as read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A problem with this key, with its line and its value.
    pub fn problem(&self, key: &str, message: impl Into<String>) -> Problem {
        Problem {
            place: self.place(key),
            key: key.to_string(),
            value: self.value(key).map(short),
            message: message.into(),
        }
    }

    /// "file:line" of a key, of its table when the key is absent, or "--set key".
    fn place(&self, key: &str) -> String {
        if let Some(set) = self.settings.iter().find(|set| covers(set, key)) {
            return format!("--set {set}");
        }
        let line = DeTable::parse(&self.text).map_or(1, |table| {
            line_of(&self.text, offset_in_table(&table, &segments(key)))
        });
        format!("{}:{line}", self.path.display())
    }

    /// The value of a key in the tree.
    pub fn value(&self, key: &str) -> Option<&Value> {
        segments(key)
            .iter()
            .try_fold(&self.tree, |node, segment| match node {
                Value::Table(table) => table.get(segment.as_str()),
                Value::Array(list) => list.get(segment.parse::<usize>().ok()?),
                _ => None,
            })
    }

    /// Apply one `KEY=VALUE`; the value is TOML, or plain text when it is not.
    fn set(&mut self, setting: &str) -> Result<(), Error> {
        let usage = |why: &str| Error::Usage(format!("--set {setting}: {why}"));
        let (key, value) = setting
            .split_once('=')
            .ok_or_else(|| usage("must look like KEY=VALUE"))?;
        let (key, value) = (key.trim(), value.trim());
        let value = toml::from_str::<toml::Table>(&format!("value = {value}"))
            .ok()
            .and_then(|mut table| table.remove("value"))
            .unwrap_or_else(|| Value::String(value.to_string()));
        let path = segments(key);
        let (last, parents) = path
            .split_last()
            .filter(|_| path.iter().all(|part| !part.is_empty()))
            .ok_or_else(|| usage("the key is empty"))?;
        let mut node = &mut self.tree;
        for segment in parents {
            let list = entries(node);
            node = child(node, segment).ok_or_else(|| usage(&no_entry(key, segment, list)))?;
        }
        match node {
            Value::Table(table) => {
                table.insert(last.clone(), value);
            }
            Value::Array(list) => {
                let count = Some(list.len());
                let slot = last
                    .parse::<usize>()
                    .ok()
                    .and_then(|index| list.get_mut(index));
                *slot.ok_or_else(|| usage(&no_entry(key, last, count)))? = value;
            }
            _ => return Err(usage("the key leads into a value that is not a table")),
        }
        self.settings.push(display(&path));
        Ok(())
    }
}

/// Entries of a list; none of what is no list.
fn entries(node: &Value) -> Option<usize> {
    node.as_array().map(Vec::len)
}

/// Why a key stops at this part of it, where it may be a list of so many entries.
fn no_entry(key: &str, part: &str, entries: Option<usize>) -> String {
    let Some(count) = entries else {
        return "the key leads nowhere".to_owned();
    };
    let name = key.split(['.', '[']).next().unwrap_or(key);
    match part.parse::<usize>() {
        Ok(_) => format!("there is no such entry in the list {name}, which has {count}"),
        Err(_) => format!("{name} is a list: name an entry, as in {name}[0].{part}"),
    }
}

/// The named entry of a table (made when absent) or of a list.
fn child<'a>(node: &'a mut Value, segment: &str) -> Option<&'a mut Value> {
    match node {
        Value::Table(table) => Some(
            table
                .entry(segment)
                .or_insert_with(|| Value::Table(toml::Table::new())),
        ),
        Value::Array(list) => list.get_mut(segment.parse::<usize>().ok()?),
        _ => None,
    }
}

/// "grains[0].radius" and "grains.0.radius" → grains, 0, radius.
fn segments(key: &str) -> Vec<String> {
    key.replace('[', ".")
        .replace(']', "")
        .split('.')
        .map(|part| part.trim().to_string())
        .collect()
}

/// grains, 0, radius → "grains[0].radius".
fn display(path: &[String]) -> String {
    let mut text = String::new();
    for part in path {
        if part.parse::<usize>().is_ok() {
            text += &format!("[{part}]");
        } else if text.is_empty() {
            text += part;
        } else {
            text += &format!(".{part}");
        }
    }
    text
}

/// Is `key` the key that was set, or inside it?
fn covers(set: &str, key: &str) -> bool {
    let (set, key) = (segments(set), segments(key));
    key.len() >= set.len() && key[..set.len()] == set[..]
}

/// Byte offset of the deepest part of the path that exists.
fn offset_in_table(table: &Spanned<DeTable<'_>>, path: &[String]) -> usize {
    let Some((first, rest)) = path.split_first() else {
        return table.span().start;
    };
    table
        .get_ref()
        .iter()
        .find(|(key, _)| key.get_ref() == first.as_str())
        .map_or(table.span().start, |(key, value)| {
            offset_in_value(value, rest).unwrap_or(key.span().start)
        })
}

fn offset_in_value(value: &Spanned<DeValue<'_>>, path: &[String]) -> Option<usize> {
    let (first, rest) = path.split_first()?;
    match value.get_ref() {
        DeValue::Table(table) => {
            let (key, inner) = table
                .iter()
                .find(|(key, _)| key.get_ref() == first.as_str())?;
            Some(offset_in_value(inner, rest).unwrap_or(key.span().start))
        }
        DeValue::Array(list) => {
            let entry = list.get(first.parse::<usize>().ok()?)?;
            Some(offset_in_value(entry, rest).unwrap_or(entry.span().start))
        }
        _ => None,
    }
}

/// Line number, from 1, of a byte offset.
fn line_of(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())]
        .iter()
        .filter(|&&byte| byte == b'\n')
        .count()
        + 1
}

/// A value in one short line; a table is not repeated.
fn short(value: &Value) -> String {
    let text = match value {
        Value::Table(_) => "{ … }".to_string(),
        Value::Float(number) if *number != 0.0 && !(1e-3..1e6).contains(&number.abs()) => {
            format!("{number:e}")
        }
        other => other.to_string(),
    };
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
