//! Median time of a round trip between the coupler and an engine that computes nothing, as one JSON
//! object: a point of the study `exchange`.

use std::process::ExitCode;
use std::time::Instant;

use serde_json::{Value, json};
use tests::arguments::{self, Arguments};
use tests::exchange::{Socket, Steps, be_the_partner_if_asked};

const HELP: &str = "exchange-time transport=shared-memory|threads|unix-socket numbers=10000
  transport  shared memory to another process, a thread, or a socket with the same bytes
  numbers    numbers there; 3.5 times as many come back
Prints the median and the 95th percentile of a round trip in µs as JSON.";

/// Time spent on measuring \[s\], and least round trips.
const DURATION: f64 = 1.0;
const COUNT_MIN: usize = 20;

fn main() -> ExitCode {
    be_the_partner_if_asked().unwrap_or_else(|| arguments::answer(HELP, measure))
}

fn measure(arguments: &Arguments) -> Result<Value, String> {
    let numbers = arguments.number("numbers", 1e4)? as usize;
    let mut times = match arguments.word("transport", "shared-memory") {
        "shared-memory" => steps(Steps::to_process(numbers)),
        "threads" => steps(Steps::to_thread(numbers)),
        "unix-socket" => socket(numbers).map_err(|error| error.to_string()),
        other => Err(format!(
            "transport={other}: allowed: shared-memory, threads, unix-socket"
        )),
    }?;
    times.sort_by(f64::total_cmp);
    let at = |share: f64| 1e6 * times[((times.len() - 1) as f64 * share) as usize];
    Ok(json!({ "median": at(0.5), "percentile_95": at(0.95), "steps": times.len() }))
}

fn steps(link: Result<Steps, protocol::Error>) -> Result<Vec<f64>, String> {
    let run = || {
        let mut link = link?;
        let times = repeat(|| link.round_trip())?;
        link.finish()?;
        Ok(times)
    };
    run().map_err(|error: protocol::Error| error.to_string())
}

fn socket(numbers: usize) -> std::io::Result<Vec<f64>> {
    let mut link = Socket::to_process(numbers, 7 * numbers / 2)?;
    let times = repeat(|| link.round_trip())?;
    link.finish()?;
    Ok(times)
}

/// Seconds of each round trip, after as many again to warm up.
fn repeat<E>(mut round_trip: impl FnMut() -> Result<(), E>) -> Result<Vec<f64>, E> {
    let mut times = Vec::new();
    for phase in 0..2 {
        let begun = Instant::now();
        times.clear();
        while begun.elapsed().as_secs_f64() < 0.5 * DURATION * f64::from(1 + phase)
            || times.len() < COUNT_MIN
        {
            let start = Instant::now();
            round_trip()?;
            times.push(start.elapsed().as_secs_f64());
        }
    }
    Ok(times)
}
