//! Every chunk must have a check sum: the library takes one without as it is, and trusts the lengths in it.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek};

use mcap::records::op;

/// Of a record: its kind, its length.
const HEAD: u64 = 1 + 8;
/// Of a chunk: times of its first and last message, its length and its check sum before compression.
const CHUNK: usize = 8 + 8 + 8 + 4;

/// Where the first chunk without a check sum begins \[bytes\]; a file that was cut is looked at as far as it goes.
pub fn unchecked(file: &File) -> io::Result<Option<u64>> {
    let mut input = BufReader::with_capacity(256, file);
    let first = first_unchecked(&mut input);
    input.rewind()?;
    match first {
        // It was cut, or a length leads out of it; who reads it will say so.
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::UnexpectedEof | ErrorKind::InvalidInput
            ) =>
        {
            Ok(None)
        }
        other => other,
    }
}

fn first_unchecked(input: &mut BufReader<&File>) -> io::Result<Option<u64>> {
    if next::<8>(input)?[..] != *mcap::MAGIC {
        return Ok(None);
    }
    let mut place = mcap::MAGIC.len() as u64;
    loop {
        let kind: [u8; 1] = next(input)?;
        let length = u64::from_le_bytes(next(input)?);
        let mut left = length;
        if kind == [op::CHUNK] {
            let about: [u8; CHUNK] = next(input)?;
            left = left.saturating_sub(CHUNK as u64);
            if about[CHUNK - 4..] == [0; 4] {
                return Ok(Some(place));
            }
        }
        place = place.saturating_add(HEAD).saturating_add(length);
        input.seek_relative(i64::try_from(left).map_err(|_| ErrorKind::InvalidInput)?)?;
    }
}

fn next<const N: usize>(input: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}
