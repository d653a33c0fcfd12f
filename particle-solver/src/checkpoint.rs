//! Checkpoint files: the accepted state, bit by bit.
//!
//! ```text
//!   "SILLGRN\0"  version u32  dimension D u32  grains u64  contacts u64  searched u64   header
//!   radius, mass (f64), fixed (u8) of each grain                          whose state it is
//!   x (D f64), v (D f64), ω (1 f64; in space 3) of each grain             the state
//!   δt (f64); first, second (u32), image (u8), R_n (f64), R_t (1 f64; in space 3) of each contact
//!   X (D f64), s (f64) of each searched grain: all or none                the last search
//!   FNV-1a of all before (u64)                                            all little-endian
//! ```
//!
//! With the search of contacts before the state, later ones come in the same steps as without an interruption.

use std::fs;
use std::path::Path;

use space::periodic::Image;
use space::vector::from_fn;
use space::{Dim, Dimension, Linear, Spin, Tangent, Vector};

use crate::contact::impulses::{Impulses, Key};
use crate::contact::law::Local;
use crate::error::Error;
use crate::grains::{Grains, State};

const MAGIC: [u8; 8] = *b"SILLGRN\0";
const VERSION: u32 = 3;
/// Bytes of what a grain is.
const PROPERTIES: usize = 8 + 8 + 1;
/// Bytes of the key of a contact.
const KEY: usize = 4 + 4 + 1;

/// An accepted state, and the search before it: where the grains were, and how far around it looked \[m\].
type Accepted<'a, const D: usize> = (&'a State<D>, (&'a [Vector<D>], &'a [f64]));
/// The same, read.
type Restored<const D: usize> = (State<D>, (Vec<Vector<D>>, Vec<f64>));

/// Write the state; the file appears complete or not at all.
pub fn save<const D: usize>(
    path: &Path,
    grains: &Grains,
    accepted: Accepted<'_, D>,
) -> Result<(), Error>
where
    Dim<D>: Dimension<D>,
{
    let bytes = encode(grains, accepted);
    let failed = |error: std::io::Error| broken(path, format!("cannot be written: {error}"));
    let mut partial = path.as_os_str().to_owned();
    partial.push(".part");
    fs::write(&partial, bytes).map_err(failed)?;
    fs::rename(&partial, path).map_err(failed)
}

/// Read a state of these grains.
pub fn restore<const D: usize>(path: &Path, grains: &Grains) -> Result<Restored<D>, Error>
where
    Dim<D>: Dimension<D>,
{
    let bytes = fs::read(path).map_err(|error| broken(path, format!("cannot be read: {error}")))?;
    decode(&bytes, grains).map_err(|why| broken(path, why))
}

fn broken(path: &Path, why: String) -> Error {
    Error::Checkpoint {
        path: path.to_owned(),
        why,
    }
}

/// Bytes of the state of a grain, and of a contact.
fn sizes<const D: usize>() -> [usize; 2]
where
    Dim<D>: Dimension<D>,
{
    let grain = PROPERTIES + 8 * (2 * D + <Spin<D> as Linear>::COMPONENTS);
    [grain, KEY + 8 * (1 + <Tangent<D> as Linear>::COMPONENTS)]
}

fn encode<const D: usize>(grains: &Grains, (state, (reference, spare)): Accepted<'_, D>) -> Vec<u8>
where
    Dim<D>: Dimension<D>,
{
    let entries = &state.impulses.entries;
    let mut bytes = Vec::new();
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((D as u32).to_le_bytes());
    bytes.extend((grains.count() as u64).to_le_bytes());
    bytes.extend((entries.len() as u64).to_le_bytes());
    bytes.extend((reference.len() as u64).to_le_bytes());
    for grain in 0..grains.count() {
        put(&mut bytes, [grains.radius[grain], grains.mass[grain]]);
        bytes.push(u8::from(grains.fixed[grain]));
    }
    for grain in 0..grains.count() {
        put(&mut bytes, state.position[grain].iter().copied());
        put(&mut bytes, state.velocity[grain].iter().copied());
        put(&mut bytes, components(&state.spin[grain]));
    }
    put(&mut bytes, [state.impulses.dt]);
    for (key, impulse) in entries {
        bytes.extend(key.first.to_le_bytes());
        bytes.extend(key.second.to_le_bytes());
        bytes.push(key.image.0);
        put(&mut bytes, [impulse.normal]);
        put(&mut bytes, components(&impulse.tangential));
    }
    for (place, spare) in reference.iter().zip(spare) {
        put(&mut bytes, place.iter().copied().chain([*spare]));
    }
    let check = checksum(&bytes);
    bytes.extend(check.to_le_bytes());
    bytes
}

fn put(bytes: &mut Vec<u8>, numbers: impl IntoIterator<Item = f64>) {
    for number in numbers {
        bytes.extend(number.to_le_bytes());
    }
}

fn components<T: Linear>(of: &T) -> impl Iterator<Item = f64> {
    (0..T::COMPONENTS).map(|k| of.component(k))
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

    fn count(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }
}

/// Bytes of the header, of δt and of the checksum.
const LEAST: usize = 8 + 4 + 4 + 3 * 8 + 8 + 8;

fn decode<const D: usize>(bytes: &[u8], grains: &Grains) -> Result<Restored<D>, String>
where
    Dim<D>: Dimension<D>,
{
    if bytes.len() < LEAST {
        return Err(format!("{} bytes, too short for a header", bytes.len()));
    }
    let (content, check) = bytes.split_at(bytes.len() - 8);
    let mut reader = Reader(content);
    let [contact_count, searched] = read_header::<D>(&mut reader, grains, bytes.len())?;
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
    let state = read_state(&mut reader, grains.count(), contact_count);
    let (mut reference, mut spare) = (Vec::new(), Vec::new());
    for _ in 0..searched {
        reference.push(from_fn(|_| reader.number()));
        spare.push(reader.number());
    }
    Ok((state, (reference, spare)))
}

/// Is it a state of so many grains, as long as it should be? How many contacts and searched grains it holds.
fn read_header<const D: usize>(
    reader: &mut Reader<'_>,
    grains: &Grains,
    length: usize,
) -> Result<[u64; 2], String>
where
    Dim<D>: Dimension<D>,
{
    if reader.take() != MAGIC {
        return Err("not a state of this engine".into());
    }
    let version = u32::from_le_bytes(reader.take());
    if version != VERSION {
        return Err(format!(
            "its format is version {version}, this engine reads {VERSION}: take the sillage that wrote it"
        ));
    }
    let dimension = u32::from_le_bytes(reader.take());
    if dimension as usize != D {
        return Err(format!("{dimension} dimensions, the scene has {D}"));
    }
    let [grain_count, contact_count, searched] = [(); 3].map(|()| reader.count());
    if grain_count != grains.count() as u64 {
        let own = grains.count();
        return Err(format!("{grain_count} grains, the scene has {own}"));
    }
    if searched != 0 && searched != grain_count {
        return Err(format!("a search of {searched} of {grain_count} grains"));
    }
    // the content that is left, and the checksum, are not of the header
    let header = length - reader.0.len();
    let [grain, contact] = sizes::<D>().map(|size| size as u128);
    let promised = u128::from(grain_count) * grain
        + u128::from(contact_count) * contact
        + u128::from(searched) * (8 * (D as u128 + 1))
        + (header + 8) as u128;
    if promised != length as u128 {
        return Err(format!("{length} bytes, its header promises {promised}"));
    }
    Ok([contact_count, searched])
}

fn read_state<const D: usize>(
    reader: &mut Reader<'_>,
    grain_count: usize,
    contact_count: u64,
) -> State<D>
where
    Dim<D>: Dimension<D>,
{
    let mut state = State::default();
    for _ in 0..grain_count {
        state.position.push(from_fn(|_| reader.number()));
        state.velocity.push(from_fn(|_| reader.number()));
        state
            .spin
            .push(Linear::from_components(|_| reader.number()));
    }
    let dt = reader.number();
    let mut entries = Vec::new();
    for _ in 0..contact_count {
        let key = Key {
            first: u32::from_le_bytes(reader.take()),
            second: u32::from_le_bytes(reader.take()),
            image: Image(reader.take::<1>()[0]),
        };
        let impulse = Local {
            normal: reader.number(),
            tangential: Linear::from_components(|_| reader.number()),
        };
        entries.push((key, impulse));
    }
    state.impulses = Impulses { dt, entries };
    state
}

/// FNV-1a, 64 bits: finds a damaged file, guards against nothing else.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use space::Vector;

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        let grains = Grains {
            radius: vec![1.0, 2.0],
            mass: vec![3.0, 4.0],
            fixed: vec![false, true],
        };
        let place = |x: f64| Vector::from([x, -x]);
        let still = vec![Vector::zeros(); 2];
        let mut state = State::new(&grains, vec![place(0.5), place(7.0)], still).unwrap();
        state.spin[0] = 0.25;
        let impulse = Local {
            normal: 2.0,
            tangential: -1.0,
        };
        state.impulses.dt = 1e-3;
        state.impulses.entries.push((Key::default(), impulse));
        let (reference, spare) = (vec![place(0.4), place(7.1)], vec![0.1, 0.2]);
        for (reference, spare) in [(reference, spare), Default::default()] {
            let bytes = encode(&grains, (&state, (&reference, &spare)));
            let expected = (state.clone(), (reference, spare));
            assert_eq!(decode(&bytes, &grains), Ok(expected));
            let in_space = decode::<3>(&bytes, &grains).unwrap_err();
            assert_eq!(in_space, "2 dimensions, the scene has 3");
            for place in 0..bytes.len() {
                let mut flipped = bytes.clone();
                flipped[place] ^= 0x10;
                assert!(decode::<2>(&flipped, &grains).is_err(), "byte {place}");
                assert!(
                    decode::<2>(&bytes[..place], &grains).is_err(),
                    "cut at {place}"
                );
            }
        }
    }
}
