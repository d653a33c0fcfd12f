//! A row of the table: how many, how they ended, the largest defects, the longest step.

use std::fmt;

use super::trial::{Defects, Ending};

/// Exit codes of runs that ended early.
const CODES: [i32; 6] = [2, 3, 4, 6, 7, 8];

/// How the scenes of one kind ended.
pub struct Tally {
    name: String,
    drawn: u32,
    skipped: u32,
    /// Refused by `check`.
    refused: u32,
    /// Ran to the end.
    well: u32,
    early: [u32; CODES.len()],
    /// Panicked, hung, or said what is not so.
    pub wrong: u32,
    worst: Defects,
    seconds: f64,
}

impl Tally {
    /// The heads of the columns.
    pub const HEADER: &str = "| scene | drawn | refused | too much work | 0 | 2 | 3 | 4 | 6 | 7 | 8 | wrong | volume | third law | longest step [s] |";

    /// Nothing yet.
    pub fn new(name: &str) -> Tally {
        Tally {
            name: name.to_string(),
            drawn: 0,
            skipped: 0,
            refused: 0,
            well: 0,
            early: [0; CODES.len()],
            wrong: 0,
            worst: Defects::default(),
            seconds: 0.0,
        }
    }

    /// Those that ran, whatever their exit code.
    pub fn ran(&self) -> u32 {
        self.well + self.early.iter().sum::<u32>()
    }

    /// Count one that took no command longer than so many seconds.
    pub fn add(&mut self, ending: Ending, seconds: f64) {
        self.drawn += 1;
        self.seconds = self.seconds.max(seconds);
        match ending {
            Ending::Refused(_) => self.refused += 1,
            Ending::Skipped => self.skipped += 1,
            Ending::Wrong(_) => self.wrong += 1,
            Ending::Early(code, _) => {
                let place = CODES.iter().position(|known| *known == code);
                self.early[place.expect("a code of a run")] += 1;
            }
            Ending::Ran(defects) => {
                self.well += 1;
                self.worst.volume = self.worst.volume.max(defects.volume);
                self.worst.third_law = self.worst.third_law.max(defects.third_law);
            }
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Tally {
            name,
            drawn,
            refused,
            skipped,
            well,
            wrong,
            ..
        } = self;
        let early = self.early.map(|count| count.to_string()).join(" | ");
        let Defects { volume, third_law } = self.worst;
        write!(
            out,
            "| {name} | {drawn} | {refused} | {skipped} | {well} | {early} | {wrong} | {volume:.1e} | {third_law:.1e} | {:.1} |",
            self.seconds
        )
    }
}
