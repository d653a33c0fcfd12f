//! What is in a recording, as text that a person can read and compare line by line.

use std::collections::BTreeMap;

use protocol::message::{ToCoupler, ToEngine};

use crate::entry::{Body, Kind, topic};
use crate::error::RecordingError;
use crate::reader::{Ending, Reader};

/// One topic.
#[derive(Default)]
struct Row {
    messages: u64,
    numbers: u64,
    squares: f64,
    largest: f64,
    last: f64,
}

/// Read a recording to its end and tell what is in it: a row a topic. `last` is the root mean square
/// of the topic's last message.
pub fn summary(reader: &mut Reader) -> Result<String, RecordingError> {
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    let (mut engines, mut steps, mut candidates, mut failures) = (Vec::new(), 0_u64, 0_u64, 0_u64);
    while let Some(entry) = reader.next_entry()? {
        let kind = match &entry.body {
            Body::Field(field, _) => Kind::Field(*field),
            Body::Request(_) => Kind::Request,
            Body::Answer(_) | Body::Unreadable(_) => Kind::Answer,
        };
        let row = rows.entry(topic(entry.seat, kind)).or_default();
        row.messages += 1;
        match entry.body {
            Body::Field(_, values) => row.add(&values),
            Body::Answer(ToCoupler::Hello(hello)) => {
                engines.push(format!(
                    "{}: {} {}",
                    hello.role.seat(),
                    hello.engine,
                    hello.version
                ));
            }
            Body::Answer(ToCoupler::Done(_)) => candidates += 1,
            Body::Answer(ToCoupler::Failed(_)) => failures += 1,
            Body::Request(ToEngine::Commit { step }) => steps = steps.max(step),
            _ => {}
        }
    }
    let begin = reader.begin();
    let mut text = format!(
        "protocol {}, format {}, {}\n",
        begin.protocol, begin.format, begin.program
    );
    for engine in engines {
        text += &format!("{engine}\n");
    }
    text += &format!("{steps} steps, {candidates} candidates, {failures} failed\n");
    text += &match reader.ending() {
        Ending::Complete { exit } => format!("complete, exit code {}\n", exit.unwrap_or(0)),
        ending => format!("not complete: {}\n", ending.warning().unwrap_or_default()),
    };
    text += &format!(
        "\n{:31} {:>8} {:>9} {:>16} {:>16} {:>16}\n",
        "topic", "messages", "numbers", "rms", "largest", "last"
    );
    for (topic, row) in rows {
        text += &format!("{topic:31} {:>8}", row.messages);
        if row.numbers > 0 {
            let rms = (row.squares / row.numbers as f64).sqrt();
            text += &format!(
                " {:>9} {rms:>16.9e} {:>16.9e} {:>16.9e}",
                row.numbers, row.largest, row.last
            );
        }
        text += "\n";
    }
    Ok(text)
}

impl Row {
    fn add(&mut self, values: &[f64]) {
        let squares: f64 = values.iter().map(|value| value * value).sum();
        self.numbers += values.len() as u64;
        self.squares += squares;
        self.largest = values
            .iter()
            .fold(self.largest, |largest, value| largest.max(value.abs()));
        self.last = (squares / values.len().max(1) as f64).sqrt();
    }
}
