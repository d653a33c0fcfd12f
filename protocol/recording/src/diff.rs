//! Compares two recordings, message by message.
//!
//! Messages are paired within their step by topic, attempt, pass and order, so that a step with more
//! passes in one recording does not spoil the comparison of the next ones.

use std::collections::BTreeMap;

use serde::Serialize;

use protocol::message::{Diagnostic, ToCoupler, ToEngine};

use crate::compare::Table;
use crate::entry::{Body, Entry, Key, Kind, topic};
use crate::error::RecordingError;
use crate::reader::Reader;

/// What two recordings differ in.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Differences {
    /// Fields, by topic.
    pub fields: Table,
    /// Control messages that are equal (process numbers and times left out).
    pub messages_equal: u64,
    /// Control messages that are not, by topic: how many, and where the first is.
    pub messages_unequal: BTreeMap<String, Unequal>,
    /// Messages that only the first has, by topic.
    pub only_first: BTreeMap<String, Unequal>,
    /// Messages that only the second has.
    pub only_second: BTreeMap<String, Unequal>,
    /// Lines about the scenes and versions.
    pub about: Vec<String>,
    /// Did the scenes differ?
    pub scenes_differ: bool,
}

/// How many, and where the first is.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Unequal {
    /// How many.
    pub count: u64,
    /// Step, attempt and pass of the first.
    pub first: [u64; 3],
}

impl Unequal {
    fn add(table: &mut BTreeMap<String, Unequal>, topic: &str, key: Key) {
        let row = table.entry(topic.to_owned()).or_insert_with(|| Unequal {
            count: 0,
            first: [key.step, key.attempt.into(), key.pass.into()],
        });
        row.count += 1;
    }
}

impl Differences {
    /// Are all fields within the tolerance, and is no message missing on either side? Control messages
    /// and scenes may differ (they hold tolerances, lengths of steps, threads): what matters of that
    /// shows in the fields.
    pub fn within(&self, tolerance: f64) -> bool {
        self.only_first.is_empty()
            && self.only_second.is_empty()
            && self.fields.values().all(|row| row.within(tolerance))
    }
}

/// Compare two recordings from their start to their end.
pub fn diff(first: &mut Reader, second: &mut Reader) -> Result<Differences, RecordingError> {
    let mut differences = Differences::default();
    about(&mut differences, first, second);
    let (mut left, mut right) = (Steps::of(first), Steps::of(second));
    let (mut a, mut b) = (left.next_step()?, right.next_step()?);
    while a.is_some() || b.is_some() {
        // The earlier step alone, or both when they are the same.
        let step = |entries: &Option<Vec<Entry>>| {
            entries
                .as_ref()
                .and_then(|entries| entries.first())
                .map_or(u64::MAX, |entry| entry.key.step)
        };
        let (at, bt) = (step(&a), step(&b));
        let one = if at <= bt { a.take() } else { None };
        let other = if bt <= at { b.take() } else { None };
        pair(
            &mut differences,
            one.unwrap_or_default(),
            other.unwrap_or_default(),
        );
        if at <= bt {
            a = left.next_step()?;
        }
        if bt <= at {
            b = right.next_step()?;
        }
    }
    Ok(differences)
}

fn about(differences: &mut Differences, first: &Reader, second: &Reader) {
    let (a, b) = (first.begin(), second.begin());
    let commit = |commit: &Option<String>| commit.clone().unwrap_or_else(|| "unknown".to_owned());
    for (what, one, other) in [
        ("program", a.program.clone(), b.program.clone()),
        ("commit", commit(&a.commit), commit(&b.commit)),
    ] {
        if one != other {
            differences.about.push(format!("{what}: {one} and {other}"));
        }
    }
    differences.scenes_differ = a.scene != b.scene || a.mesh_file != b.mesh_file;
    let (a, b) = (
        serde_json::to_value(&a.scene).unwrap_or_default(),
        serde_json::to_value(&b.scene).unwrap_or_default(),
    );
    scenes(&mut differences.about, "scene", &a, &b);
}

/// Leaves of two scenes that differ, with their path.
fn scenes(about: &mut Vec<String>, path: &str, a: &serde_json::Value, b: &serde_json::Value) {
    use serde_json::Value::Object;
    match (a, b) {
        (Object(one), Object(other)) => {
            let names: std::collections::BTreeSet<&String> =
                one.keys().chain(other.keys()).collect();
            for name in names {
                let path = format!("{path}.{name}");
                scenes(about, &path, &a[name.as_str()], &b[name.as_str()]);
            }
        }
        _ if a != b => about.push(format!("{path}: {a} and {b}")),
        _ => {}
    }
}

/// Messages of a recording, a step at a time.
struct Steps<'a> {
    reader: &'a mut Reader,
    next: Option<Entry>,
}

impl Steps<'_> {
    fn of(reader: &mut Reader) -> Steps<'_> {
        Steps { reader, next: None }
    }

    /// All messages of the next step; none at the end.
    fn next_step(&mut self) -> Result<Option<Vec<Entry>>, RecordingError> {
        let mut entries: Vec<Entry> = self.next.take().into_iter().collect();
        while let Some(entry) = self.reader.next_entry()? {
            match entries.first() {
                Some(first) if first.key.step != entry.key.step => {
                    self.next = Some(entry);
                    break;
                }
                _ => entries.push(entry),
            }
        }
        Ok((!entries.is_empty()).then_some(entries))
    }
}

/// Topic, attempt, pass, and number among those.
type Name = (String, u32, u32, u32);

fn named(entries: Vec<Entry>) -> BTreeMap<Name, Entry> {
    let mut count: BTreeMap<(String, u32, u32), u32> = BTreeMap::new();
    let mut named = BTreeMap::new();
    for entry in entries {
        let topic = topic(entry.seat, kind(&entry.body));
        let (attempt, pass) = (entry.key.attempt, entry.key.pass);
        let number = count.entry((topic.clone(), attempt, pass)).or_default();
        named.insert((topic, attempt, pass, *number), entry);
        *number += 1;
    }
    named
}

fn kind(body: &Body) -> Kind {
    match body {
        Body::Field(field, _) => Kind::Field(*field),
        Body::Request(_) => Kind::Request,
        // What an engine sent and was none stands where its answers stand.
        Body::Answer(_) | Body::Unreadable(_) => Kind::Answer,
    }
}

fn pair(differences: &mut Differences, first: Vec<Entry>, second: Vec<Entry>) {
    let (first, mut second) = (named(first), named(second));
    for (name, one) in first {
        let topic = &name.0;
        let Some(other) = second.remove(&name) else {
            Unequal::add(&mut differences.only_first, topic, one.key);
            continue;
        };
        match (&one.body, &other.body) {
            (Body::Field(_, a), Body::Field(_, b)) => {
                let row = differences.fields.entry(topic.clone()).or_default();
                if row
                    .add(one.key, one.header.components.max(1) as usize, a, b)
                    .is_err()
                {
                    Unequal::add(&mut differences.only_first, topic, one.key);
                    Unequal::add(&mut differences.only_second, topic, other.key);
                }
            }
            (a, b) if essence(a) == essence(b) => differences.messages_equal += 1,
            _ => Unequal::add(&mut differences.messages_unequal, topic, one.key),
        }
    }
    for ((topic, ..), other) in second {
        Unequal::add(&mut differences.only_second, &topic, other.key);
    }
}

/// A control message without what differs from run to run: processes and times.
fn essence(body: &Body) -> Body {
    let mut body = body.clone();
    match &mut body {
        Body::Answer(ToCoupler::Hello(hello)) => hello.process = 0,
        Body::Answer(ToCoupler::Done(done)) => done
            .diagnostics
            .retain(|Diagnostic { name, .. }| !name.contains("seconds")),
        Body::Request(ToEngine::Save { path } | ToEngine::Restore { path }) => path.clear(),
        _ => {}
    }
    body
}

/// The differences as text.
pub fn text(differences: &Differences, tolerance: f64) -> String {
    let mut text = String::new();
    for line in &differences.about {
        text += &format!("{line}\n");
    }
    text += &crate::compare::text(&differences.fields, tolerance);
    let unequal: u64 = differences
        .messages_unequal
        .values()
        .map(|row| row.count)
        .sum();
    text += &format!(
        "control messages: {} equal, {unequal} not (times left out)\n",
        differences.messages_equal
    );
    for (what, table) in [
        ("differ", &differences.messages_unequal),
        ("only in the first", &differences.only_first),
        ("only in the second", &differences.only_second),
    ] {
        for (topic, Unequal { count, first }) in table {
            let [step, attempt, pass] = first;
            text += &format!(
                "  {topic}: {count} {what}, from step {step} attempt {attempt} pass {pass} on\n"
            );
        }
    }
    text
}
