//! How a run ended: exit code and reason, from what was said and how the processes ended.

use crate::launch::Process;
use scene::error::exit_code;

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Exit code of the run.
    pub code: i32,
    /// Who, at which step, waiting for what; none when all went well.
    pub why: Option<String>,
}

/// What the coupler said last.
#[derive(Debug, Clone, PartialEq)]
pub enum LastWord {
    /// The run ended as asked.
    Finished,
    /// It ended early.
    Stopped {
        /// Exit code of the run, as the coupler sees it.
        code: i32,
        /// Why.
        why: String,
    },
}

/// What is known when all processes have ended.
pub struct Evidence<'a> {
    /// The processes.
    pub processes: &'a [Process],
    /// What the coupler said last.
    pub last_word: Option<&'a LastWord>,
    /// Why no more could be heard from it.
    pub broken: Option<&'a (i32, String)>,
    /// Steps accepted.
    pub steps: u64,
}

impl Evidence<'_> {
    /// The first of these that applies: somebody was killed; the coupler knows the reason; a
    /// process failed; the coupler lost somebody; the run finished; silence.
    pub fn verdict(&self) -> Verdict {
        self.killed()
            .or_else(|| self.stopped(|code| code != exit_code::PARTNER_LOST))
            .or_else(|| self.failed())
            .or_else(|| self.stopped(|_| true))
            .or_else(|| self.finished())
            .unwrap_or_else(|| self.silence())
    }

    /// "at step 12": the one that was being computed.
    fn moment(&self) -> String {
        match self.steps {
            0 => "before the first step was accepted".into(),
            steps => format!("at step {}", steps + 1),
        }
    }

    /// "; coupler: …" when it said why it stopped.
    fn words(&self) -> String {
        match self.last_word {
            Some(LastWord::Stopped { why, .. }) => format!("; coupler: {why}"),
            _ => String::new(),
        }
    }

    fn killed(&self) -> Option<Verdict> {
        let victim = self.processes.iter().find(|process| process.was_killed())?;
        let Process { seat, id, .. } = victim;
        let mut why = format!(
            "the {seat} (process {id}) {} {}",
            victim.ending(),
            self.moment()
        );
        match self.words() {
            words if words.is_empty() => {
                why += &format!(
                    ", while the next message was awaited; {} steps are written",
                    self.steps
                );
            }
            words => why += &words,
        }
        Some(Verdict {
            code: exit_code::PARTNER_LOST,
            why: Some(why),
        })
    }

    fn stopped(&self, applies: impl Fn(i32) -> bool) -> Option<Verdict> {
        match self.last_word {
            Some(LastWord::Stopped { code, why }) if applies(*code) => Some(Verdict {
                code: *code,
                why: Some(why.clone()),
            }),
            _ => None,
        }
    }

    /// A process that failed knows better than those that lost it.
    fn failed(&self) -> Option<Verdict> {
        let lost_or_well = |process: &&Process| {
            process.signalled || matches!(process.code(), None | Some(0 | exit_code::PARTNER_LOST))
        };
        let process = self
            .processes
            .iter()
            .find(|process| !lost_or_well(process))?;
        let said = process.reason();
        let said = if said.is_empty() {
            said
        } else {
            format!(" ({said})")
        };
        let why = format!(
            "the {} {}{said} {}{}",
            process.seat,
            process.ending(),
            self.moment(),
            self.words()
        );
        Some(Verdict {
            code: known(process.code()?),
            why: Some(why),
        })
    }

    fn finished(&self) -> Option<Verdict> {
        if self.last_word != Some(&LastWord::Finished) {
            return None;
        }
        let unwell: Vec<String> = self
            .processes
            .iter()
            .filter(|process| process.code() != Some(0))
            .map(|process| format!("the {} {}", process.seat, process.ending()))
            .collect();
        if unwell.is_empty() {
            return Some(Verdict {
                code: exit_code::OK,
                why: None,
            });
        }
        let why = format!("all steps were computed, but {}", unwell.join(", "));
        Some(Verdict {
            code: exit_code::PARTNER_LOST,
            why: Some(why),
        })
    }

    fn silence(&self) -> Verdict {
        let (code, why) = self.broken.cloned().unwrap_or_else(|| {
            let why = format!("the processes left {} without a word", self.moment());
            (exit_code::PARTNER_LOST, why)
        });
        Verdict {
            code,
            why: Some(why),
        }
    }
}

/// Exit codes outside the contract (a foreign engine's own) count as a failed engine.
fn known(code: i32) -> i32 {
    match code {
        exit_code::SCENE..=exit_code::NOT_CONVERGED | exit_code::INTERRUPTED => code,
        _ => exit_code::ENGINE,
    }
}
