//! Reads a recording from its start to its end and checks everything on the way.
//!
//! Checked are the CRC of each chunk (before anything in it is used), of the whole file and of its
//! index, the CRC-32C of each message, that no message is missing, and that headers, topics and
//! payloads fit together. A file that was cut is read up to its last whole chunk; a file in which
//! bytes changed is refused there.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use mcap::records::{Channel, MessageHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use protocol::PROTOCOL_VERSION;
use protocol::header::FieldHeader;
use protocol::message::Role;

use crate::begin::{BEGIN, Begin, END, End, FORMAT, PROFILE};
use crate::chunks;
use crate::entry::{Body, Entry, Key, Kind, decode, parse_topic, to_numbers};
use crate::error::RecordingError;
use crate::lengths;
use crate::write::file::Copied;

/// Largest record or chunk that is read \[bytes\]; the writer keeps messages below half of it.
const RECORD_MAX: u64 = 1 << 30;
/// In a small file a smaller one: so many bytes, or so many times those of the file. A chunk is as large as the
/// writer makes it, or holds one message, and numbers of a run do not compress much.
const RECORD_IN_SMALL_FILE: u64 = 1 << 26;
const COMPRESSION_MAX: u64 = 64;
/// Bytes taken from the file at once: a length that is wrong cannot ask for much memory.
const PIECE: usize = 1 << 16;

/// How a recording ends.
#[derive(Debug, Clone, PartialEq)]
pub enum Ending {
    /// Every message of the run is there.
    Complete {
        /// Exit code of the run.
        exit: Option<i32>,
    },
    /// The recorder gave up before the run ended.
    GaveUp {
        /// Why.
        why: String,
    },
    /// The file was cut: the run was killed, or a copy is not whole.
    Cut {
        /// Messages that were read.
        messages: u64,
    },
}

impl Ending {
    /// A warning, unless all is there.
    pub fn warning(&self) -> Option<String> {
        match self {
            Ending::Complete { .. } => None,
            Ending::GaveUp { why } => Some(format!(
                "it ends before the run does: {why}; only what is there is used"
            )),
            Ending::Cut { messages } => Some(format!(
                "it was cut (the run was killed, or the copy is not whole): only its first {messages} \
                 messages, up to the last whole chunk, are used"
            )),
        }
    }
}

/// A recording that is read from its start.
pub struct Reader {
    path: PathBuf,
    input: BufReader<File>,
    linear: LinearReader,
    topics: BTreeMap<u16, String>,
    begin: Begin,
    end: Option<End>,
    messages: u32,
    last: String,
    over: bool,
    cut: bool,
}

/// What is of interest in a record.
enum Found {
    Nothing,
    Header {
        profile: String,
    },
    Message {
        topic: String,
        header: MessageHeader,
        bytes: Vec<u8>,
    },
}

impl Reader {
    /// Open a recording; its first message is read and its version checked.
    pub fn open(path: &Path) -> Result<Reader, RecordingError> {
        let (file, length) = File::open(path)
            .and_then(|file| match file.metadata()? {
                about if about.is_dir() => Err(ErrorKind::IsADirectory.into()),
                about => Ok((file, about.len())),
            })
            .map_err(|error| RecordingError::file("cannot read the recording", path, error))?;
        let unchecked = chunks::unchecked(&file)
            .map_err(|error| RecordingError::file("cannot read the recording", path, error))?;
        if let Some(place) = unchecked {
            return Err(RecordingError::Damaged {
                path: path.to_path_buf(),
                place: format!("at byte {place}"),
                why: "the chunk there has no check sum".to_owned(),
            });
        }
        let most =
            (COMPRESSION_MAX * length.min(RECORD_MAX)).clamp(RECORD_IN_SMALL_FILE, RECORD_MAX);
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true)
            .with_record_length_limit(most as usize);
        let mut input = BufReader::new(file);
        let mut linear = LinearReader::new_with_options(options);
        let mut topics = BTreeMap::new();
        let begin = first_message(path, &mut input, &mut linear, &mut topics)?;
        Ok(Reader {
            path: path.to_path_buf(),
            input,
            linear,
            topics,
            begin,
            end: None,
            messages: 1,
            last: "after its first message".to_owned(),
            over: false,
            cut: false,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the recording says about itself.
    pub fn begin(&self) -> &Begin {
        &self.begin
    }

    /// The next message of a link; none at the end.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, RecordingError> {
        let Some((topic, header, bytes)) = self.next_message()? else {
            return Ok(None);
        };
        let refuse = |why: String| self.damaged(format!("{topic}: {why}"));
        let (wire, payload) = decode(&bytes).map_err(refuse)?;
        let (seat, body) = body(&topic, &wire, payload).map_err(refuse)?;
        let entry = Entry {
            key: Key::from_log_time(header.log_time),
            sequence: header.sequence,
            wall: header.publish_time,
            seat,
            header: wire,
            body,
        };
        self.note(&topic, &header);
        Ok(Some(entry))
    }

    /// The same as it stands in the file, to be written to another one.
    pub(crate) fn next_copied(&mut self) -> Result<Option<Copied>, RecordingError> {
        let Some((topic, header, bytes)) = self.next_message()? else {
            return Ok(None);
        };
        let refuse = |why: String| self.damaged(format!("{topic}: {why}"));
        decode(&bytes).map_err(refuse)?;
        let told = parse_topic(&topic).ok_or("no topic of a recording".to_owned());
        let (seat, kind) = told.map_err(refuse)?;
        self.note(&topic, &header);
        Ok(Some(Copied {
            seat,
            kind,
            log_time: header.log_time,
            publish_time: header.publish_time,
            bytes,
        }))
    }

    /// The next message of a link, in its order; none at the end.
    fn next_message(&mut self) -> Result<Option<(String, MessageHeader, Vec<u8>)>, RecordingError> {
        while !self.over {
            let found = match next_record(&mut self.input, &mut self.linear, &mut self.topics) {
                Ok(Some(found)) => found,
                Ok(None) => {
                    self.over = true;
                    self.check_whole()?;
                    break;
                }
                Err(McapError::UnexpectedEof) => {
                    (self.over, self.cut) = (true, true);
                    break;
                }
                Err(error) => return Err(self.damaged(error.to_string())),
            };
            let Found::Message {
                topic,
                header,
                bytes,
            } = found
            else {
                continue;
            };
            if header.sequence != self.messages {
                return Err(self.damaged(format!(
                    "message {} follows, message {} is missing",
                    header.sequence, self.messages
                )));
            }
            if self.end.is_some() {
                return Err(self.damaged(format!("{topic} follows {END}")));
            }
            if topic != END {
                return Ok(Some((topic, header, bytes)));
            }
            let refuse = |why: String| self.damaged(format!("{topic}: {why}"));
            let (_, payload) = decode(&bytes).map_err(refuse)?;
            let end = serde_json::from_slice(payload).map_err(|e| refuse(e.to_string()))?;
            self.end = Some(end);
            self.note(&topic, &header);
        }
        Ok(None)
    }

    /// A message has been read.
    fn note(&mut self, topic: &str, header: &MessageHeader) {
        let step = Key::from_log_time(header.log_time).step;
        self.messages = self.messages.wrapping_add(1);
        self.last = format!("after message {} ({topic}, step {step})", header.sequence);
    }

    /// How the recording ends; after [`Reader::next_entry`] has returned none.
    pub fn ending(&self) -> Ending {
        match &self.end {
            Some(end) if !self.cut && end.complete => Ending::Complete { exit: end.exit },
            Some(end) if !self.cut => Ending::GaveUp {
                why: end.why.clone().unwrap_or_default(),
            },
            _ => Ending::Cut {
                messages: self.messages.into(),
            },
        }
    }

    /// A file with an index has an end, with the right number of messages.
    fn check_whole(&self) -> Result<(), RecordingError> {
        match &self.end {
            None => Err(self.damaged(format!("{END} is missing"))),
            Some(end) if end.messages + 1 != u64::from(self.messages) => {
                Err(self.damaged(format!(
                    "{} messages before {END}, {} were written",
                    self.messages - 1,
                    end.messages
                )))
            }
            Some(_) => Ok(()),
        }
    }

    fn damaged(&self, why: String) -> RecordingError {
        RecordingError::Damaged {
            path: self.path.clone(),
            place: self.last.clone(),
            why,
        }
    }
}

/// The first message of a file, when it is one of ours.
fn first_message(
    path: &Path,
    input: &mut BufReader<File>,
    linear: &mut LinearReader,
    topics: &mut BTreeMap<u16, String>,
) -> Result<Begin, RecordingError> {
    let foreign = |why: &str| RecordingError::foreign(path, why);
    let mut ours = false;
    loop {
        let found = next_record(input, linear, topics).map_err(|error| match error {
            McapError::BadMagic => foreign("it is no MCAP file"),
            McapError::UnexpectedEof => foreign("it ends before its first message"),
            McapError::Io(error) => RecordingError::file("cannot read the recording", path, error),
            error if ours => RecordingError::Damaged {
                path: path.to_path_buf(),
                place: "before its first message".to_owned(),
                why: error.to_string(),
            },
            error => foreign(&error.to_string()),
        })?;
        match found {
            Some(Found::Header { profile }) if profile == PROFILE => ours = true,
            Some(Found::Header { profile }) => {
                let why = format!("its MCAP profile is `{profile}`, `{PROFILE}` was expected");
                return Err(foreign(&why));
            }
            Some(Found::Message {
                topic,
                header,
                bytes,
            }) => {
                if !ours || topic != BEGIN || header.sequence != 0 {
                    return Err(foreign(&format!("its first message is `{topic}`")));
                }
                return read_begin(path, &bytes);
            }
            Some(Found::Nothing) => {}
            None => return Err(foreign("it has no messages")),
        }
    }
}

/// Versions first: the rest of another version may have another shape.
fn read_begin(path: &Path, bytes: &[u8]) -> Result<Begin, RecordingError> {
    let damaged = |why: String| RecordingError::Damaged {
        path: path.to_path_buf(),
        place: format!("in {BEGIN}"),
        why,
    };
    let (_, payload) = decode(bytes).map_err(damaged)?;
    let value: serde_json::Value =
        serde_json::from_slice(payload).map_err(|error| damaged(error.to_string()))?;
    let number = |name: &str| value[name].as_u64().unwrap_or(0);
    if number("format") != u64::from(FORMAT) {
        return Err(RecordingError::Version {
            path: path.to_path_buf(),
            what: "format",
            theirs: number("format"),
            ours: FORMAT,
        });
    }
    if number("protocol") != u64::from(PROTOCOL_VERSION) {
        return Err(RecordingError::protocol(path, number("protocol")));
    }
    serde_json::from_value(value).map_err(|error| damaged(error.to_string()))
}

/// The next record, with what it means for the channels taken over; none after the end of the file.
fn next_record(
    input: &mut BufReader<File>,
    linear: &mut LinearReader,
    topics: &mut BTreeMap<u16, String>,
) -> McapResult<Option<Found>> {
    while let Some(event) = linear.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let length = wanted.min(PIECE);
                let read = input.read(linear.insert(length))?;
                linear.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => {
                return found(opcode, data, topics).map(Some);
            }
        }
    }
    Ok(None)
}

fn found(opcode: u8, data: &[u8], topics: &mut BTreeMap<u16, String>) -> McapResult<Found> {
    // Others are not looked at: what they could say stands in messages, with a check sum.
    if !matches!(opcode, op::HEADER | op::CHANNEL | op::MESSAGE) {
        return Ok(Found::Nothing);
    }
    if !lengths::fit(opcode, data) {
        let why = format!("record {opcode:#04x} has a text that is longer than itself");
        return Err(std::io::Error::new(ErrorKind::InvalidData, why).into());
    }
    Ok(match mcap::parse_record(opcode, data)? {
        Record::Header(header) => Found::Header {
            profile: header.profile,
        },
        Record::Channel(Channel { id, topic, .. }) => {
            topics.insert(id, topic);
            Found::Nothing
        }
        Record::Message { header, data } => Found::Message {
            topic: topics
                .get(&header.channel_id)
                .cloned()
                .ok_or(McapError::UnknownChannel(
                    header.sequence,
                    header.channel_id,
                ))?,
            header,
            bytes: data.into_owned(),
        },
        _ => Found::Nothing,
    })
}

/// What a message carries; its header must say the same.
fn body(topic: &str, header: &FieldHeader, payload: &[u8]) -> Result<(Role, Body), String> {
    let (seat, kind) = parse_topic(topic).ok_or("no topic of a recording")?;
    let body = match kind {
        Kind::Field(field) => {
            let values = to_numbers(payload)?;
            if header.field != field.id() || header.count != values.len() as u64 {
                return Err(format!(
                    "{} numbers of field {}, its header says {} of field {}",
                    values.len(),
                    field.id(),
                    header.count,
                    header.field
                ));
            }
            Body::Field(field, values)
        }
        Kind::Request => match serde_json::from_slice(payload) {
            Ok(message) => Body::Request(message),
            Err(error) => unreadable(payload).ok_or(error.to_string())?,
        },
        Kind::Answer => match serde_json::from_slice(payload) {
            Ok(message) => Body::Answer(message),
            Err(error) => unreadable(payload).ok_or(error.to_string())?,
        },
    };
    Ok((seat, body))
}

/// Hexadecimal text of a control message that was none.
fn unreadable(payload: &[u8]) -> Option<Body> {
    let text: String = serde_json::from_slice(payload).ok()?;
    let hexadecimal = text.chars().all(|c| c.is_ascii_hexdigit());
    hexadecimal.then_some(Body::Unreadable(text))
}
