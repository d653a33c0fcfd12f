//! Lengths of texts in a record, looked at before the record is read: the library makes room for what a length
//! claims before it looks for the text, up to 4 GB.

use mcap::records::op;

/// Do they end within the record? Known are the records that are read: header, channel, message.
pub fn fit(opcode: u8, record: &[u8]) -> bool {
    match opcode {
        // profile, library
        op::HEADER => two_texts(record).is_some(),
        // id, schema, topic, encoding, metadata: its length in bytes, then names and values
        op::CHANNEL => channel(record).is_some(),
        _ => true,
    }
}

fn channel(record: &[u8]) -> Option<()> {
    let (_numbers, rest) = record.split_at_checked(4)?;
    let (mut pairs, _) = text(two_texts(rest)?)?;
    while !pairs.is_empty() {
        pairs = two_texts(pairs)?;
    }
    Some(())
}

/// What comes after two texts.
fn two_texts(bytes: &[u8]) -> Option<&[u8]> {
    let (_, rest) = text(bytes)?;
    Some(text(rest)?.1)
}

/// A text, and what comes after it.
fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(length: u32, text: &str) -> Vec<u8> {
        [&length.to_le_bytes(), text.as_bytes()].concat()
    }

    #[test]
    fn a_length_beyond_the_record_is_seen() {
        let long = u32::MAX - 7;
        let header = |length| [text(length, "sillage"), text(3, "abc")].concat();
        assert!(fit(op::HEADER, &header(7)) && !fit(op::HEADER, &header(long)));
        let channel = |topic, map, value| {
            let pair = [text(1, "k"), text(value, "v")].concat();
            let texts = [text(topic, "fluid"), text(1, "j"), map_of(map, &pair)];
            [vec![1, 0, 2, 0], texts.concat()].concat()
        };
        fn map_of(length: u32, pair: &[u8]) -> Vec<u8> {
            [&length.to_le_bytes(), pair].concat()
        }
        assert!(fit(op::CHANNEL, &channel(5, 10, 1)));
        for wrong in [(long, 10, 1), (5, long, 1), (5, 10, long), (5, 9, 1)] {
            assert!(
                !fit(op::CHANNEL, &channel(wrong.0, wrong.1, wrong.2)),
                "{wrong:?}"
            );
        }
        for cut in 0..header(7).len() {
            assert!(!fit(op::HEADER, &header(7)[..cut]));
        }
    }
}
