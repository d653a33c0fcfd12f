//! Recordings that went wrong: what is damaged is refused, what is cut is used up to its last whole
//! chunk, what is foreign is named; and disks that fail do not touch the run.

use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

use protocol::codec;
use protocol::header::FieldHeader;
use protocol::local::{self, LIMITS};
use protocol::message::Role;
use protocol::partner::Partner;
use recording::{Begin, Body, Ending, Entry, Options, Reader, Recorder, RecordingError};

use crate::runs::{begin, read, record, run};

/// All entries, or the first error.
fn try_read(path: &Path) -> Result<(Vec<Entry>, Ending), RecordingError> {
    let mut reader = Reader::open(path)?;
    let mut entries = Vec::new();
    while let Some(entry) = reader.next_entry()? {
        entries.push(entry);
    }
    Ok((entries, reader.ending()))
}

#[test]
fn a_flipped_bit_anywhere_is_an_error_or_the_end_of_what_is_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 3);
    let (entries, _) = read(&path);
    let sound = std::fs::read(&path).expect("bytes");
    let (mut refused, mut cut) = (0, 0);
    for place in (0..sound.len()).step_by(5) {
        let mut bytes = sound.clone();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(&path, &bytes).expect("written");
        match try_read(&path) {
            Err(error) => {
                assert!(matches!(error.exit_code(), 2 | 3), "{error}");
                refused += 1;
            }
            // A length that points beyond the file looks like a cut; nothing wrong is handed out.
            Ok((found, ending)) => {
                assert!(
                    matches!(ending, Ending::Cut { .. }),
                    "byte {place}: {ending:?}"
                );
                assert_eq!(found[..], entries[..found.len()], "byte {place}");
                cut += 1;
            }
        }
    }
    println!(
        "{} bytes, every fifth changed: {refused} refused, {cut} taken for a cut",
        sound.len()
    );
    assert!(refused > 9 * cut);
    std::fs::write(&path, &sound).expect("written");
    let mut bytes = sound.clone();
    let middle = bytes.len() / 3;
    bytes[middle] ^= 4;
    std::fs::write(&path, &bytes).expect("written");
    let words = try_read(&path).expect_err("damaged").to_string();
    println!("{words}");
    assert!(
        words.contains("is damaged after") && words.contains("CRC"),
        "{words}"
    );
}

#[test]
fn a_chunk_without_a_check_sum_is_refused() {
    const CHUNK: u8 = 6;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    record(&path, Options::default(), 3);
    let mut bytes = std::fs::read(&path).expect("bytes");
    // Magic, then the header: kind, length, content.
    let length = u64::from_le_bytes(bytes[9..17].try_into().expect("eight"));
    let chunk = 17 + length as usize;
    assert_eq!(bytes[chunk], CHUNK);
    bytes[chunk + 9 + 24..][..4].fill(0);
    std::fs::write(&path, &bytes).expect("written");
    let words = try_read(&path).expect_err("refused").to_string();
    println!("{words}");
    let expected = format!("is damaged at byte {chunk}: the chunk there has no check sum");
    assert!(words.contains(&expected), "{words}");
}

#[test]
fn what_was_overwritten_anywhere_is_never_taken_for_what_was_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    let options = Options {
        compression: recording::Compression::None,
        ..Options::default()
    };
    record(&path, options, 3);
    let (entries, _) = read(&path);
    let sound = std::fs::read(&path).expect("bytes");
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % below
    };
    let mut refused = 0;
    for _ in 0..500 {
        let mut bytes = sound.clone();
        let (place, length) = (draw(sound.len()), 1 + draw(16));
        for byte in bytes.iter_mut().skip(place).take(length) {
            *byte = draw(256) as u8;
        }
        if bytes == sound {
            continue;
        }
        std::fs::write(&path, &bytes).expect("written");
        match try_read(&path) {
            Err(_) => refused += 1,
            Ok((found, ending)) => {
                assert!(matches!(ending, Ending::Cut { .. }), "{place} {length}");
                assert_eq!(found[..], entries[..found.len()]);
            }
        }
    }
    println!("{refused} of 500 refused");
    assert!(refused > 350);
}

#[test]
fn a_file_cut_anywhere_gives_its_first_chunks_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    // Large enough for several chunks.
    record(&path, Options::default(), 20_000);
    let (entries, _) = read(&path);
    let sound = std::fs::read(&path).expect("bytes");
    let mut seen = Vec::new();
    println!("| part of the file | messages of {} |", entries.len());
    for part in 0..=20 {
        let length = sound.len() * part / 20 - usize::from(part == 20);
        std::fs::write(&path, &sound[..length]).expect("written");
        match try_read(&path) {
            Ok((found, ending)) => {
                println!("| {:.2} | {} |", part as f64 / 20.0, found.len());
                let warning = ending.warning().expect("a warning");
                assert!(warning.contains("it was cut"), "{warning}");
                assert_eq!(found[..], entries[..found.len()]);
                seen.push(found.len());
            }
            Err(error) => {
                println!("| {:.2} | {error} |", part as f64 / 20.0);
                assert!(part == 0, "{error}");
            }
        }
    }
    assert!(seen.is_sorted());
    // Half of the bytes hold a third of the messages: those of the grains come last and are small.
    assert!(seen[9] > entries.len() / 4, "{seen:?}");
}

#[test]
fn a_foreign_file_is_named_and_another_version_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("foreign.mcap");
    let words = |expected: &str, code: i32| {
        let error = Reader::open(&path).err().expect("refused");
        println!("{} ({error})", error.exit_code());
        assert!(error.to_string().contains(expected), "{error}");
        assert_eq!(error.exit_code(), code);
    };
    words("cannot read the recording", 2);
    for (content, expected) in [
        (&b""[..], "it ends before its first message"),
        (b"step,time,dt\n1,0.1,0.1\n", "it is no MCAP file"),
        (b"\x89MCAP0\r\n", "it ends before its first message"),
    ] {
        std::fs::write(&path, content).expect("written");
        words(expected, 2);
    }
    let mut other = mcap::Writer::new(Cursor::new(Vec::new())).expect("a writer");
    other.finish().expect("finished");
    std::fs::write(&path, other.into_inner().into_inner()).expect("written");
    words("its MCAP profile is ``, `sillage` was expected", 2);
    for (begin, expected) in [
        (
            Begin {
                protocol: 7,
                ..begin(3)
            },
            "records protocol 7, this program reads 2",
        ),
        (
            Begin {
                format: 2,
                ..begin(3)
            },
            "records format 2, this program reads 1",
        ),
    ] {
        let recorder = Recorder::create(&path, Options::default(), &begin).expect("a recorder");
        run(Some(&recorder), 3);
        assert!(recorder.finish(0).complete);
        words(expected, 3);
    }
    let error = Reader::open(folder.path()).err().expect("refused");
    assert!(error.to_string().contains("is a directory"), "{error}");
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_run() {
    let (bits, outcome) = record(Path::new("/dev/full"), Options::default(), 8);
    println!("{outcome:?}");
    assert_eq!(bits, run(None, 8));
    assert!(!outcome.complete);
    let why = outcome.why.expect("a reason");
    assert!(why.contains("No space left on device"), "{why}");
}

#[test]
fn a_disk_that_hangs_ends_the_recording_and_not_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pipe");
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mkfifoat(rustix::fs::CWD, &path, mode).expect("a pipe");
    // Somebody who opens the pipe and never reads from it.
    let reader = std::fs::File::options()
        .read(true)
        .write(true)
        .open(&path)
        .expect("a reader");
    let options = Options {
        queue: 4 << 20,
        patience: Duration::from_millis(300),
        ..Options::default()
    };
    let begun = Instant::now();
    let (bits, outcome) = record(&path, options, 20_000);
    println!("{outcome:?} after {:.2?}", begun.elapsed());
    assert_eq!(bits, run(None, 20_000));
    assert!(!outcome.complete);
    let why = outcome.why.expect("a reason");
    assert!(why.contains("waited for the disk"), "{why}");
    assert!(begun.elapsed() < Duration::from_secs(20));
    drop(reader);
}

#[test]
fn a_full_queue_ends_the_recording_which_says_so_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    let options = Options {
        queue: 1,
        ..Options::default()
    };
    let (bits, outcome) = record(&path, options, 50_000);
    println!("{outcome:?}");
    assert_eq!(bits, run(None, 50_000));
    assert!(!outcome.complete);
    let (entries, ending) = read(&path);
    println!("{} entries, {ending:?}", entries.len());
    let warning = ending.warning().expect("a warning");
    assert!(warning.contains("waited for the disk"), "{warning}");
    assert_eq!(entries.len() as u64 + 1, outcome.messages);
}

#[test]
fn a_message_that_is_none_is_recorded_as_it_came() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("toy.mcap");
    let recorder = Recorder::create(&path, Options::default(), &begin(3)).expect("a recorder");
    let garbage = [0xfe, 0xed, 0x01];
    let link = local::connect(Role::Fluid, move |mut link| {
        let header = FieldHeader::message(0, 0, garbage.len());
        while !link.send_message(header, &garbage)? {
            std::thread::sleep(Duration::from_millis(10));
        }
        link.wait_for_leave(Duration::from_secs(5));
        Ok(())
    })
    .expect("a link");
    let tapped = recorder.tap(Role::Fluid, link);
    let error = Partner::greet(Role::Fluid, tapped, &LIMITS).expect_err("no greeting");
    println!("{error}");
    assert!(codec::decode::<protocol::message::ToCoupler>(&garbage).is_err());
    recorder.finish(error.exit_code());
    let (entries, ending) = read(&path);
    assert_eq!(ending, Ending::Complete { exit: Some(7) });
    assert_eq!(entries.len(), 1);
    assert_eq!(entries[0].body, Body::Unreadable("feed01".to_owned()));
}
