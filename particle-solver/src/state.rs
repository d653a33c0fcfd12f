//! Checkpoint files: the accepted state, bit by bit.
//!
//! ```text
//!   "SILLGRN\0"  version u32  grains u64  contacts u64                    header
//!   radius, mass (f64), fixed (u8) of each grain                          whose state it is
//!   x, y, vx, vy, ω (f64) of each grain                                   the state
//!   δt (f64); first, second (u32), image (u8), R_n, R_t (f64) of each contact
//!   FNV-1a of all before (u64)                                            all little-endian
//! ```

use std::fs;
use std::path::Path;

use crate::contact::{Impulses, Key};
use crate::error::Error;
use crate::grains::{Grains, State};

const MAGIC: [u8; 8] = *b"SILLGRN\0";
const VERSION: u32 = 1;
const HEADER: usize = 8 + 4 + 8 + 8;
const GRAIN: usize = 7 * 8 + 1;
const CONTACT: usize = 4 + 4 + 1 + 8 + 8;

/// Write the state; the file appears complete or not at all.
pub fn save(path: &Path, grains: &Grains, state: &State) -> Result<(), Error> {
    let bytes = encode(grains, state);
    let failed = |error: std::io::Error| broken(path, format!("cannot be written: {error}"));
    let mut partial = path.as_os_str().to_owned();
    partial.push(".part");
    fs::write(&partial, bytes).map_err(failed)?;
    fs::rename(&partial, path).map_err(failed)
}

/// Read a state of these grains.
pub fn restore(path: &Path, grains: &Grains) -> Result<State, Error> {
    let bytes = fs::read(path).map_err(|error| broken(path, format!("cannot be read: {error}")))?;
    decode(&bytes, grains).map_err(|why| broken(path, why))
}

fn broken(path: &Path, why: String) -> Error {
    Error::Checkpoint {
        path: path.to_owned(),
        why,
    }
}

fn encode(grains: &Grains, state: &State) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(
        HEADER + GRAIN * grains.count() + CONTACT * state.impulses.entries.len() + 16,
    );
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((grains.count() as u64).to_le_bytes());
    bytes.extend((state.impulses.entries.len() as u64).to_le_bytes());
    for grain in 0..grains.count() {
        bytes.extend(grains.radius[grain].to_le_bytes());
        bytes.extend(grains.mass[grain].to_le_bytes());
        bytes.push(u8::from(grains.fixed[grain]));
    }
    for grain in 0..grains.count() {
        let ([x, y], [vx, vy]) = (state.position[grain], state.velocity[grain]);
        for value in [x, y, vx, vy, state.spin[grain]] {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes.extend(state.impulses.dt.to_le_bytes());
    for (key, normal, tangential) in &state.impulses.entries {
        bytes.extend(key.first.to_le_bytes());
        bytes.extend(key.second.to_le_bytes());
        bytes.push(key.image);
        bytes.extend(normal.to_le_bytes());
        bytes.extend(tangential.to_le_bytes());
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

/// Takes values off the front of the bytes; their number has been checked.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self
            .0
            .split_first_chunk()
            .expect("length checked before reading");
        self.0 = rest;
        *head
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}

fn decode(bytes: &[u8], grains: &Grains) -> Result<State, String> {
    if bytes.len() < HEADER + 16 {
        return Err(format!("{} bytes, too short for a header", bytes.len()));
    }
    let (content, check) = bytes.split_at(bytes.len() - 8);
    let mut reader = Reader(content);
    if reader.take() != MAGIC {
        return Err("not a state of this engine".into());
    }
    let version = u32::from_le_bytes(reader.take());
    if version != VERSION {
        return Err(format!("version {version}, this engine reads {VERSION}"));
    }
    let grain_count = u64::from_le_bytes(reader.take());
    let contact_count = u64::from_le_bytes(reader.take());
    if grain_count != grains.count() as u64 {
        return Err(format!(
            "{grain_count} grains, the scene has {}",
            grains.count()
        ));
    }
    let expected = u128::from(grain_count) * GRAIN as u128
        + u128::from(contact_count) * CONTACT as u128
        + (HEADER + 16) as u128;
    if expected != bytes.len() as u128 {
        return Err(format!(
            "{} bytes, its header promises {expected}",
            bytes.len()
        ));
    }
    if check != checksum(content).to_le_bytes() {
        return Err("its checksum does not fit, the file is damaged".into());
    }
    for grain in 0..grains.count() {
        let same = [reader.number(), reader.number()] == [grains.radius[grain], grains.mass[grain]]
            && reader.take() == [u8::from(grains.fixed[grain])];
        if !same {
            return Err(format!("grain {grain} differs from that of the scene"));
        }
    }
    Ok(read_state(&mut reader, grains.count(), contact_count))
}

fn read_state(reader: &mut Reader<'_>, grain_count: usize, contact_count: u64) -> State {
    let mut state = State::default();
    for _ in 0..grain_count {
        state.position.push([reader.number(), reader.number()]);
        state.velocity.push([reader.number(), reader.number()]);
        state.spin.push(reader.number());
    }
    let mut impulses = Impulses {
        dt: reader.number(),
        entries: Vec::new(),
    };
    for _ in 0..contact_count {
        let key = Key {
            first: u32::from_le_bytes(reader.take()),
            second: u32::from_le_bytes(reader.take()),
            image: reader.take::<1>()[0],
        };
        impulses
            .entries
            .push((key, reader.number(), reader.number()));
    }
    state.impulses = impulses;
    state
}

/// FNV-1a, 64 bits: finds a damaged file, guards against nothing else.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
