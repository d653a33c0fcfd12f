//! Recordings of toy runs, and recordings that went wrong.

mod faults;
mod runs;
#[expect(dead_code, reason = "not every fault of the toys is recorded")]
#[path = "../../../tests/suite/toy.rs"]
mod toy;
