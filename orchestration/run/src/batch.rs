//! Many scenes, each run into a folder of its own. What was run is not run again: `point.json` says
//! of what a folder is the result.

use std::path::Path;
use std::time::Instant;

use scene::Scene;
use scene::error::{Error, exit_code};
use serde_json::{Value, json};

use crate::file;
use crate::folder::document;
use crate::run::Runner;

/// A run that is over.
#[derive(Debug, Clone)]
pub struct Done {
    /// `point.json`: mark, exit code, why, load of the machine.
    pub point: Value,
    /// `run.json`.
    pub document: Value,
}

/// What makes a run the same: its scene as resolved, its grains and its engines.
pub fn mark(scene: &Scene, settings: &[String]) -> Value {
    json!({ "settings": settings, "scene": scene.coupler, "text": scene.text })
}

/// The run that is there already, when it is the same.
pub fn known(place: &Path, mark: &Value) -> Option<Done> {
    let text = std::fs::read_to_string(place.join("point.json")).ok()?;
    let point = serde_json::from_str::<Value>(&text).ok()?;
    if point["mark"] != *mark {
        return None;
    }
    let document = document::read(place).unwrap_or(Value::Null);
    Some(Done { point, document })
}

/// Run a scene; none when it was interrupted. What was run here before was something else: it goes.
pub fn one(
    scene: &Scene,
    place: &Path,
    mark: &Value,
    runner: &Runner,
) -> Result<Option<Done>, Error> {
    if place.join("point.json").is_file() {
        file::remove(place)?;
    }
    // A run of many is begun again where it was not finished.
    let mut scene = scene.clone();
    scene.checkpoint.keep = 0;
    let outcome = runner.run(&scene, place)?;
    if outcome.ending.code == exit_code::INTERRUPTED {
        return Ok(None);
    }
    let ending = &outcome.ending;
    Ok(Some(Done {
        point: write_point(place, mark, ending.code, ending.why.as_deref())?,
        document: outcome.document,
    }))
}

/// Write `point.json`: that it is there says that the run is over.
pub fn write_point(
    place: &Path,
    mark: &Value,
    code: i32,
    why: Option<&str>,
) -> Result<Value, Error> {
    let point = json!({ "mark": mark, "exit": code, "why": why, "load": load() });
    file::write(&place.join("point.json"), format!("{point:#}\n"))?;
    Ok(point)
}

/// A name as that of a folder, another one for each: its letters and digits, and `.-_=`; the rest by number.
pub fn folder_name(name: &str) -> String {
    if name.is_empty() {
        return "%%".to_owned();
    }
    let mut folder = String::new();
    for (place, c) in name.chars().enumerate() {
        let plain = c.is_alphanumeric() || "-_=,".contains(c) || c == '.' && place > 0;
        match (plain, c) {
            (true, _) => folder.push(c),
            (false, ' ') => folder.push('+'),
            (false, _) => folder += &format!("%{:x}%", u32::from(c)),
        }
    }
    folder
}

/// Runnable processes, mean of the last minute.
fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

/// How far many runs are.
pub struct Clock {
    all: usize,
    done: usize,
    ran: usize,
    begun: Instant,
}

impl Clock {
    /// Of so many runs.
    pub fn new(all: usize) -> Self {
        Clock {
            all,
            done: 0,
            ran: 0,
            begun: Instant::now(),
        }
    }

    /// A run was there already.
    pub fn skip(&mut self) {
        self.done += 1;
    }

    /// A run was made.
    pub fn ran(&mut self) {
        self.done += 1;
        self.ran += 1;
    }

    /// A bar, the count, and the time left.
    pub fn line(&self) -> String {
        let filled = 24 * self.done / self.all.max(1);
        let bar = "█".repeat(filled) + &"░".repeat(24 - filled);
        let left = match self.ran {
            0 => String::new(),
            ran => {
                let each = self.begun.elapsed().as_secs_f64() / ran as f64;
                format!(", about {:.0} s left", each * (self.all - self.done) as f64)
            }
        };
        format!("{bar} {} of {} runs{left}", self.done, self.all)
    }
}

#[cfg(test)]
mod tests {
    use super::folder_name;

    #[test]
    fn two_names_never_share_a_folder_and_none_leaves_it() {
        let names = [
            "a/b",
            "a-b",
            "a b",
            "a+b",
            "a%2f%b",
            "",
            "..",
            ".",
            "a.b",
            "Ja, 1.5e-3",
        ];
        let folders = names.map(folder_name);
        println!("{folders:?}");
        let mut sorted = folders.to_vec();
        sorted.sort();
        sorted.dedup();
        assert_eq!(sorted.len(), names.len());
        assert!(
            folders
                .iter()
                .all(|folder| !folder.contains('/') && !folder.starts_with('.'))
        );
        assert_eq!(folders[1], "a-b");
    }
}
