//! One message of a recording: its key, its topic, its bytes.

use protocol::field::Field;
use protocol::header::FieldHeader;
use protocol::message::{Role, ToCoupler, ToEngine};

/// Bytes before each payload.
const HEADER: usize = 64;

/// Where in the run a message was exchanged; ordered as the exchange was.
///
/// ```text
///   log_time = step · 10⁹ + attempt · 10⁷ + pass · 10³ + place
/// ```
///
/// so that viewers which take it for nanoseconds show steps as seconds. An attempt, pass or place that
/// does not fit its digits is recorded as the largest that does; the order in the file stays right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Step, 0 before the first.
    pub step: u64,
    /// Attempt at this step, from 0: grows when the step is tried again with another length.
    pub attempt: u32,
    /// Pass within the attempt.
    pub pass: u32,
    /// Running number within the pass, both links together.
    pub place: u32,
}

const STEP: u64 = 1_000_000_000;
const ATTEMPT: u64 = 10_000_000;
const PASS: u64 = 1_000;

impl Key {
    /// The key as the time stamp of a message.
    pub fn log_time(self) -> u64 {
        let digits = |value: u32, room: u64| u64::from(value).min(room - 1);
        self.step
            .saturating_mul(STEP)
            .saturating_add(digits(self.attempt, STEP / ATTEMPT) * ATTEMPT)
            .saturating_add(digits(self.pass, ATTEMPT / PASS) * PASS)
            .saturating_add(digits(self.place, PASS))
    }

    /// The key in a time stamp.
    pub fn from_log_time(time: u64) -> Key {
        let within = time % STEP;
        Key {
            step: time / STEP,
            attempt: (within / ATTEMPT) as u32,
            pass: (within % ATTEMPT / PASS) as u32,
            place: (within % PASS) as u32,
        }
    }
}

/// What a message carries.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// Numbers of a field.
    Field(Field, Vec<f64>),
    /// Coupler → engine.
    Request(ToEngine),
    /// Engine → coupler.
    Answer(ToCoupler),
    /// A control message that was none: its bytes, as hexadecimal text.
    Unreadable(String),
}

/// One message of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Where in the run.
    pub key: Key,
    /// Number of the message in the file.
    pub sequence: u32,
    /// Wall clock when it passed \[ns since 1970\].
    pub wall: u64,
    /// The engine of the link.
    pub seat: Role,
    /// Its header on the wire, `check` left out.
    pub header: FieldHeader,
    /// What it carries.
    pub body: Body,
}

/// Kind of a message, and last part of its topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Field(Field),
    Request,
    Answer,
}

impl Kind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Field(field) => field.name(),
            Kind::Request => "request",
            Kind::Answer => "answer",
        }
    }
}

/// "fluid/porosity".
pub(crate) fn topic(seat: Role, kind: Kind) -> String {
    format!("{}/{}", seat.seat(), kind.name())
}

/// The seat and the kind of a topic, where it is one of ours.
pub(crate) fn parse_topic(topic: &str) -> Option<(Role, Kind)> {
    let (seat, name) = topic.split_once('/')?;
    let seat = [Role::Fluid, Role::Particles]
        .into_iter()
        .find(|role| role.seat() == seat)?;
    let kind = match name {
        "request" => Kind::Request,
        "answer" => Kind::Answer,
        name => Kind::Field(Field::ALL.into_iter().find(|field| field.name() == name)?),
    };
    Some((seat, kind))
}

/// Header with check sum and attempt, then the payload.
pub(crate) fn encode(header: &FieldHeader, attempt: u32, payload: &[u8], bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.reserve(HEADER + payload.len());
    for word in [header.protocol, header.field] {
        bytes.extend(word.to_le_bytes());
    }
    for word in [header.epoch, header.step] {
        bytes.extend(word.to_le_bytes());
    }
    for word in [
        header.pass,
        header.stage,
        header.components,
        header.reserved,
    ] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(header.count.to_le_bytes());
    bytes.extend(header.time.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(attempt.to_le_bytes());
    bytes.extend_from_slice(payload);
    let sum = check_sum(bytes);
    bytes[56..60].copy_from_slice(&sum.to_le_bytes());
}

/// CRC-32C of everything but the sum itself.
fn check_sum(bytes: &[u8]) -> u32 {
    crc32c::crc32c_append(crc32c::crc32c(&bytes[..56]), &bytes[60..])
}

/// The header and the payload; an error says what does not fit.
pub(crate) fn decode(bytes: &[u8]) -> Result<(FieldHeader, &[u8]), String> {
    let Some((head, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(format!(
            "{} bytes are less than a header of {HEADER}",
            bytes.len()
        ));
    };
    let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 4)) << 32;
    let (stored, computed) = (word(56), check_sum(bytes));
    if stored != computed {
        return Err(format!(
            "its CRC-32C is {computed:08x}, {stored:08x} was written"
        ));
    }
    let header = FieldHeader {
        protocol: word(0),
        field: word(4),
        epoch: long(8),
        step: long(16),
        pass: word(24),
        stage: word(28),
        components: word(32),
        reserved: word(36),
        count: long(40),
        time: f64::from_bits(long(48)),
        check: 0,
    };
    Ok((header, payload))
}

/// Numbers as bytes, little endian.
pub(crate) fn to_bytes(values: &[f64], bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.resize(8 * values.len(), 0);
    for (place, value) in bytes.chunks_exact_mut(8).zip(values) {
        place.copy_from_slice(&value.to_le_bytes());
    }
}

/// Numbers from bytes, little endian.
pub(crate) fn to_numbers(bytes: &[u8]) -> Result<Vec<f64>, String> {
    let (numbers, rest) = bytes.as_chunks::<8>();
    if !rest.is_empty() {
        return Err(format!("{} bytes are no whole numbers", bytes.len()));
    }
    Ok(numbers
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_ordered_as_their_time_stamps_and_read_back() {
        let key = |step, attempt, pass, place| Key {
            step,
            attempt,
            pass,
            place,
        };
        let keys = [
            key(0, 0, 0, 0),
            key(0, 0, 0, 999),
            key(1, 0, 0, 0),
            key(1, 0, 1, 3),
            key(1, 0, 9_999, 0),
            key(1, 1, 0, 0),
            key(1, 99, 9_999, 999),
            key(2, 0, 0, 0),
            key(10_000_000_000, 0, 1, 1),
        ];
        for pair in keys.windows(2) {
            assert!(pair[0].log_time() < pair[1].log_time(), "{pair:?}");
        }
        for key in keys {
            assert_eq!(Key::from_log_time(key.log_time()), key);
        }
        assert_eq!(
            key(3, 500, 20_000, 5_000).log_time(),
            key(3, 99, 9_999, 999).log_time()
        );
    }

    #[test]
    fn any_changed_byte_of_an_entry_is_refused() {
        let header = FieldHeader::message(7, 3, 5);
        let mut bytes = Vec::new();
        encode(&header, 2, b"hello", &mut bytes);
        assert_eq!(decode(&bytes), Ok((header, &b"hello"[..])));
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0x10;
            assert!(decode(&changed).is_err(), "byte {place}");
        }
        assert!(decode(&bytes[..63]).is_err());
        assert!(decode(&[]).is_err());
    }

    #[test]
    fn topics_name_the_seat_and_the_field() {
        for seat in [Role::Fluid, Role::Particles] {
            for kind in Field::ALL
                .map(Kind::Field)
                .into_iter()
                .chain([Kind::Request, Kind::Answer])
            {
                assert_eq!(parse_topic(&topic(seat, kind)), Some((seat, kind)));
            }
        }
        for foreign in ["", "fluid", "fluid/", "air/porosity", "/tf", "fluid/camera"] {
            assert_eq!(parse_topic(foreign), None, "{foreign}");
        }
    }
}
