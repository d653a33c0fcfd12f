//! States that a run wrote for ParaView, read back: the list (`.pvd`) and each file (`.vtu`).

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use scene::Error;

/// Times and file names of a list; empty when there is none.
pub fn list(path: &Path) -> Result<Vec<(f64, String)>, Error> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path).map_err(Error::file("cannot read", path))?;
    let mut entries = Vec::new();
    for line in text.lines().filter(|line| line.contains("<DataSet")) {
        let entry = attribute(line, "timestep")
            .and_then(|time| time.parse().ok())
            .zip(attribute(line, "file"));
        let (time, file) = entry.ok_or_else(|| wrong(path, "a DataSet has no timestep or file"))?;
        if file.split('/').any(|part| part == "..") || file.starts_with('/') {
            return Err(wrong(path, &format!("{file} lies outside of the folder")));
        }
        entries.push((time, file.to_string()));
    }
    Ok(entries)
}

/// One state, as text.
pub struct State {
    text: String,
    name: String,
}

impl State {
    /// Read a file.
    pub fn read(path: &Path) -> Result<State, Error> {
        let text = std::fs::read_to_string(path).map_err(Error::file("cannot read", path))?;
        Ok(State {
            text,
            name: path.display().to_string(),
        })
    }

    /// The same from text.
    pub fn from_text(text: String) -> State {
        let name = "a state".to_string();
        State { text, name }
    }

    /// An array of numbers; none when the file does not have it.
    pub fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, Error> {
        self.array(name, f64::from_le_bytes)
    }

    /// An array of whole numbers.
    pub fn indices(&self, name: &str) -> Result<Option<Vec<i64>>, Error> {
        self.array(name, i64::from_le_bytes)
    }

    /// The first `D` of every three components.
    pub fn vectors<const D: usize>(&self, name: &str) -> Result<Option<Vec<[f64; D]>>, Error> {
        let numbers = self.numbers(name)?;
        let first = |v: &[f64]| std::array::from_fn(|axis| v[axis]);
        Ok(numbers.map(|all| all.chunks_exact(3).map(first).collect()))
    }

    fn array<T>(&self, name: &str, number: fn([u8; 8]) -> T) -> Result<Option<Vec<T>>, Error> {
        let Some(bytes) = self.bytes(name)? else {
            return Ok(None);
        };
        let eights = bytes.chunks_exact(8);
        if !eights.remainder().is_empty() {
            return Err(self.refuse(name, "cut off"));
        }
        let number = |chunk: &[u8]| number(std::array::from_fn(|index| chunk[index]));
        Ok(Some(eights.map(number).collect()))
    }

    /// An array as it lies in the file, whose name there may end in its unit: `name [unit]`.
    pub fn bytes(&self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        let found = ["\"", " ["].map(|end| self.text.find(&format!("Name=\"{name}{end}")));
        let Some(start) = found.into_iter().flatten().next() else {
            return Ok(None);
        };
        let mut lines = self.text[start..].lines();
        if !lines.next().is_some_and(|head| head.contains("binary")) {
            return Err(self.refuse(name, "not in binary format"));
        }
        let encoded = lines.next().unwrap_or_default().trim();
        let block = STANDARD
            .decode(encoded)
            .map_err(|error| self.refuse(name, &error.to_string()))?;
        let Some((length, bytes)) = block.split_first_chunk() else {
            return Err(self.refuse(name, "cut off"));
        };
        match u64::from_le_bytes(*length) == bytes.len() as u64 {
            true => Ok(Some(bytes.to_vec())),
            false => Err(self.refuse(name, "its length is not the one it names")),
        }
    }

    /// The error of an array that cannot be used.
    pub fn refuse(&self, name: &str, why: &str) -> Error {
        let file = &self.name;
        Error::Usage(format!(
            "{file}: {name}: {why}; only files that sillage wrote can be read"
        ))
    }
}

fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let rest = line.split_once(&format!("{name}=\""))?.1;
    rest.split_once('"').map(|(value, _)| value)
}

fn wrong(path: &Path, why: &str) -> Error {
    Error::Usage(format!("{}: {why}", path.display()))
}
