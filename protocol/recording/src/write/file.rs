//! The file of a recording: channels, chunks, the first and the last message.

use std::collections::BTreeMap;
use std::fs::File;
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};

use protocol::codec;
use protocol::header::FieldHeader;
use protocol::message::{Role, ToCoupler, ToEngine};

use crate::begin::{BEGIN, Compression, END, End, FORMAT, PROFILE};
use crate::entry::{Kind, encode, to_bytes, topic};

use super::feed::{Payload, Raw, now};

/// A chunk is closed when it is older, so that little is lost when the run is killed.
pub(crate) const CHUNK_AGE: Duration = Duration::from_secs(1);
/// A chunk is closed when it is larger \[bytes\].
const CHUNK_SIZE: u64 = 1 << 20;
/// Largest message \[bytes\]; readers refuse chunks above twice that.
const MESSAGE_MAX: usize = 1 << 29;

/// A message of another file.
pub(crate) struct Copied {
    pub(crate) seat: Role,
    pub(crate) kind: Kind,
    pub(crate) log_time: u64,
    pub(crate) publish_time: u64,
    pub(crate) bytes: Vec<u8>,
}

/// Where messages are written; every error is told in words.
pub(crate) struct Output {
    writer: Writer<NoSeek<File>>,
    /// The same open file.
    file: File,
    channels: BTreeMap<(u8, Kind), u16>,
    written: u32,
    /// Largest key.
    latest: u64,
    chunk_since: Instant,
    /// Size of the file up to its last whole chunk.
    sound: u64,
    bytes: Vec<u8>,
    payload: Vec<u8>,
    /// Of the space of the run, for the units of its fields.
    dimension: usize,
}

fn words(error: McapError) -> String {
    match error {
        McapError::Io(error) => format!("the file cannot be written: {error}"),
        error => format!("the recording cannot be written: {error}"),
    }
}

impl Output {
    /// Write the first message.
    pub(crate) fn create(
        file: File,
        compression: Compression,
        begin: &[u8],
        dimension: usize,
    ) -> Result<Output, String> {
        let same = file
            .try_clone()
            .map_err(|error| words(McapError::Io(error)))?;
        let compression = match compression {
            Compression::Zstd => Some(mcap::Compression::Zstd),
            Compression::None => None,
        };
        let writer = WriteOptions::new()
            .profile(PROFILE)
            .library(concat!("sillage ", env!("CARGO_PKG_VERSION")))
            .compression(compression)
            // On this thread: the cores belong to the engines.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_SIZE))
            // Chunks are built in memory and written whole: a killed run leaves no half header.
            .disable_seeking(true)
            .create(NoSeek::new(file))
            .map_err(words)?;
        let mut output = Output {
            writer,
            file: same,
            channels: BTreeMap::new(),
            written: 0,
            latest: 0,
            chunk_since: Instant::now(),
            sound: 0,
            bytes: Vec::new(),
            payload: Vec::new(),
            dimension,
        };
        output.own(BEGIN, begin)?;
        output.flush()?;
        Ok(output)
    }

    /// A message of the recorder itself.
    fn own(&mut self, topic: &str, json: &[u8]) -> Result<(), String> {
        let metadata = BTreeMap::from([("format".to_owned(), FORMAT.to_string())]);
        let id = self
            .writer
            .add_channel(0, topic, "json", &metadata)
            .map_err(words)?;
        let header = FieldHeader::message(0, 0, json.len());
        encode(&header, 0, json, &mut self.bytes);
        // Not before any other, for readers that sort.
        self.put(id, self.latest, now())
    }

    pub(crate) fn message(&mut self, raw: &Raw) -> Result<(), String> {
        match &raw.payload {
            Payload::Numbers(values) => to_bytes(values, &mut self.payload),
            Payload::Bytes(bytes) => self.payload = json(raw.kind, bytes),
        }
        if self.payload.len() > MESSAGE_MAX {
            return Err(format!(
                "{} has {} bytes, a recording holds messages of at most {MESSAGE_MAX}",
                raw.kind.name(),
                self.payload.len()
            ));
        }
        let id = self.channel(raw.seat, raw.kind)?;
        encode(&raw.header, raw.key.attempt, &self.payload, &mut self.bytes);
        self.put(id, raw.key.log_time(), raw.wall)?;
        if self.chunk_since.elapsed() > CHUNK_AGE {
            self.flush()?;
        }
        Ok(())
    }

    fn put(&mut self, channel_id: u16, log_time: u64, publish_time: u64) -> Result<(), String> {
        self.latest = self.latest.max(log_time);
        let header = MessageHeader {
            channel_id,
            sequence: self.written,
            log_time,
            publish_time,
        };
        self.written = self.written.wrapping_add(1);
        self.writer
            .write_to_known_channel(&header, &self.bytes)
            .map_err(words)
    }

    fn channel(&mut self, seat: Role, kind: Kind) -> Result<u16, String> {
        if let Some(&id) = self.channels.get(&(seat as u8, kind)) {
            return Ok(id);
        }
        let (encoding, metadata) = match kind {
            Kind::Field(field) => (
                "f64le",
                vec![
                    ("unit", field.unit(self.dimension).to_owned()),
                    ("components", field.components(self.dimension).to_string()),
                    ("support", field.support().name().to_owned()),
                ],
            ),
            Kind::Request | Kind::Answer => ("json", Vec::new()),
        };
        let metadata = metadata
            .into_iter()
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        let id = self
            .writer
            .add_channel(0, &topic(seat, kind), encoding, &metadata)
            .map_err(words)?;
        self.channels.insert((seat as u8, kind), id);
        Ok(id)
    }

    /// A message of a link of an earlier recording, as it stands there.
    pub(crate) fn copy(&mut self, message: &Copied) -> Result<(), String> {
        let id = self.channel(message.seat, message.kind)?;
        self.bytes.clone_from(&message.bytes);
        self.put(id, message.log_time, message.publish_time)
    }

    /// Close the chunk, and wait until it is on the disk.
    pub(crate) fn settle(&mut self) -> Result<(), String> {
        self.flush()?;
        self.file
            .sync_data()
            .map_err(|error| words(McapError::Io(error)))
    }

    /// Close the chunk.
    pub(crate) fn flush(&mut self) -> Result<(), String> {
        self.chunk_since = Instant::now();
        self.writer.flush().map_err(words)?;
        self.sound = self.size()?;
        Ok(())
    }

    /// Write the last message and the index; messages before it and bytes in all.
    pub(crate) fn end(
        mut self,
        why: Option<String>,
        exit: Option<i32>,
    ) -> Result<(u64, u64), String> {
        let messages = u64::from(self.written);
        let end = End {
            complete: why.is_none(),
            why,
            exit,
            messages,
        };
        let json = serde_json::to_vec(&end).map_err(|error| error.to_string())?;
        let written = self
            .own(END, &json)
            .and_then(|()| self.flush())
            .and_then(|()| self.writer.finish().map_err(words));
        match written {
            Ok(_) => Ok((messages, self.size()?)),
            Err(why) => {
                self.abandon();
                Err(why)
            }
        }
    }

    fn size(&self) -> Result<u64, String> {
        let metadata = self.file.metadata();
        metadata
            .map(|metadata| metadata.len())
            .map_err(|error| words(McapError::Io(error)))
    }

    /// Writing failed: cut the file after its last whole chunk.
    pub(crate) fn abandon(self) {
        let Output {
            writer,
            file,
            sound,
            ..
        } = self;
        drop(writer.into_inner());
        // What cannot be cut is read as far as it is whole.
        let _ = file.set_len(sound);
    }
}

/// A control message as JSON; bytes that are none, as hexadecimal text.
fn json(kind: Kind, bytes: &[u8]) -> Vec<u8> {
    let text = match kind {
        Kind::Request => codec::decode::<ToEngine>(bytes)
            .ok()
            .and_then(|message| serde_json::to_vec(&message).ok()),
        _ => codec::decode::<ToCoupler>(bytes)
            .ok()
            .and_then(|message| serde_json::to_vec(&message).ok()),
    };
    text.unwrap_or_else(|| {
        let hexadecimal: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("\"{hexadecimal}\"").into_bytes()
    })
}
