//! Every kind of input from outside is taken or refused: what is right, what fuzzing has found, and both changed
//! at random, always in the same way. No panic, no hang, and no more memory than [`ROOM`].

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use tests::grains::Noise;
use tests::inputs::{TARGETS, seeds};

/// Of each kind.
const CHANGED: usize = 3000;
/// Memory that this process may ask for beyond what it has at the start \[bytes\].
const ROOM: u64 = 1 << 30;
/// No input takes this long.
const LONGEST: Duration = Duration::from_secs(60);

/// A whole number below a bound.
fn below(random: &mut Noise, bound: usize) -> usize {
    (random.draw() * bound as f64) as usize
}

/// Words and bytes that programs trip over.
const WORDS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"1e300",
    b"-1e-300",
    b"nan",
    b"inf",
    b"9223372036854775807",
    b"99999999999999999999",
    b"[",
    b"}\n",
    b"\"",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
    b"\x00\x00\x00\x00\x00\x00\x00\x80",
    b"\xfd\xff\xff\xff\xff\xff\xff\xff\x0f",
    b"\xf0\x9f\x8c\x8a",
    b"",
];

/// An input changed in one to four places.
fn changed(of: &[u8], other: &[u8], random: &mut Noise) -> Vec<u8> {
    let mut bytes = of.to_vec();
    for _ in 0..1 + below(random, 4) {
        let length = bytes.len();
        let from = below(random, length + 1);
        let to = (from + below(random, 9)).min(length);
        match below(random, 6) {
            0 if from < length => bytes[from] ^= 1 << below(random, 8),
            1 => _ = bytes.splice(from..to, WORDS[below(random, WORDS.len())].iter().copied()),
            2 => bytes.truncate(from),
            3 => _ = bytes.drain(from..below(random, length + 1).max(from)),
            4 => {
                let piece = bytes[from..(from + below(random, 64)).min(length)].to_vec();
                bytes.splice(from..from, piece);
            }
            _ => {
                let begin = below(random, other.len() + 1);
                let end = (begin + below(random, 200)).min(other.len());
                bytes.splice(from..from, other[begin..end].iter().copied());
            }
        }
    }
    bytes
}

fn bound_memory() {
    let (_, hard) = getrlimit(Resource::RLIMIT_AS).expect("known");
    let held = std::fs::read_to_string("/proc/self/statm").expect("known");
    let pages: u64 = held
        .split(' ')
        .next()
        .and_then(|n| n.parse().ok())
        .expect("a number");
    setrlimit(Resource::RLIMIT_AS, 4096 * pages + ROOM, hard).expect("set");
}

/// Ends this process when an input takes too long.
fn watch(done: &'static AtomicU64) {
    std::thread::spawn(move || {
        loop {
            let before = done.load(Ordering::Relaxed);
            std::thread::sleep(LONGEST);
            if done.load(Ordering::Relaxed) == before {
                eprintln!("the input above takes more than {} s", LONGEST.as_secs());
                std::process::abort();
            }
        }
    });
}

#[test]
fn every_input_is_taken_or_refused() {
    static DONE: AtomicU64 = AtomicU64::new(0);
    let last = Path::new(env!("CARGO_TARGET_TMPDIR")).join("input");
    let kinds: Vec<_> = TARGETS
        .iter()
        .map(|(kind, read)| (*kind, *read, seeds::of(kind), seeds::found(kind)))
        .collect();
    watch(&DONE);
    bound_memory();
    println!("each of them lies in {} while it is read", last.display());
    println!("kind        right  found  changed");
    for (kind, read, right, found) in kinds {
        println!(
            "{kind:<10} {:>6} {:>6} {CHANGED:>8}",
            right.len(),
            found.len()
        );
        assert!(!right.is_empty());
        let all = [right, found].concat();
        let mut random = Noise::new(1);
        let pick = |random: &mut Noise| &all[below(random, all.len())];
        let draws = (0..CHANGED).map(|_| {
            let (of, other) = (pick(&mut random), pick(&mut random));
            changed(of, other, &mut random)
        });
        for input in all.iter().cloned().chain(draws) {
            std::fs::write(&last, &input).expect("written");
            read(&input);
            DONE.fetch_add(1, Ordering::Relaxed);
        }
    }
}
