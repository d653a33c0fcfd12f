//! Arguments `key=value` of the small programs that studies run, and their one JSON answer.

use std::collections::BTreeMap;
use std::process::ExitCode;

use serde_json::Value;

/// What the command line said.
#[derive(Debug, Default)]
pub struct Arguments(BTreeMap<String, String>);

impl Arguments {
    /// A word, or what it is when nothing is said.
    pub fn word<'a>(&'a self, key: &str, otherwise: &'a str) -> &'a str {
        self.0.get(key).map_or(otherwise, String::as_str)
    }

    /// A positive number, or what it is when nothing is said.
    pub fn number(&self, key: &str, otherwise: f64) -> Result<f64, String> {
        let Some(text) = self.0.get(key) else {
            return Ok(otherwise);
        };
        let number = text.parse::<f64>().ok();
        number
            .filter(|value| *value > 0.0 && value.is_finite())
            .ok_or_else(|| format!("{key}={text}: must be a positive number"))
    }
}

/// Read the command line, do the work, print the answer; exit code 2 where either is refused.
/// `help` names every key in its first line as `key=`.
pub fn answer(help: &str, work: impl FnOnce(&Arguments) -> Result<Value, String>) -> ExitCode {
    match read(help).and_then(|arguments| work(&arguments)) {
        Ok(answer) => {
            println!("{answer}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}

fn read(help: &str) -> Result<Arguments, String> {
    let usage = help.lines().next().unwrap_or_default();
    let mut arguments = Arguments::default();
    for argument in std::env::args().skip(1) {
        let (key, value) = argument.split_once('=').ok_or_else(|| help.to_owned())?;
        if !usage.contains(&format!(" {key}=")) {
            return Err(format!("{argument}: no such key\n{help}"));
        }
        arguments.0.insert(key.to_owned(), value.to_owned());
    }
    Ok(arguments)
}
