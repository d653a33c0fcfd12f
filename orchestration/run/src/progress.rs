//! How far a run is: a bar on a terminal, plain lines otherwise, both on stderr.

use std::io::{IsTerminal, stderr, stdin};
use std::time::{Duration, Instant};

use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use protocol::message::Diagnostic;

use crate::tell;
use crate::tell::told;

/// Between two plain lines.
const QUIET: Duration = Duration::from_secs(5);
/// Of a bar, in a second.
const DRAWS: u8 = 10;

/// A bar on stderr, where that is a terminal.
fn bar(length: u64, style: &str) -> Option<ProgressBar> {
    stderr().is_terminal().then(|| {
        let target = ProgressDrawTarget::term(Term::read_write_pair(stdin(), told()), DRAWS);
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        bar
    })
}

/// Shows how far many quiet runs are; nothing yet when it is new.
pub struct Gauge {
    bar: Option<ProgressBar>,
    spoken: Option<Instant>,
}

impl Default for Gauge {
    fn default() -> Gauge {
        Gauge {
            bar: bar(1, "{msg}"),
            spoken: None,
        }
    }
}

impl Gauge {
    /// How far they are, in words: the line is rewritten on a terminal, else said now and then.
    pub fn show(&mut self, line: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(line.to_owned()),
            None if self.spoken.is_none_or(|spoken| spoken.elapsed() >= QUIET) => {
                self.spoken = Some(Instant::now());
                tell!("{line}");
            }
            None => {}
        }
    }

    /// They are over.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Shows how far a run is.
pub struct Progress {
    end_time: f64,
    silent: bool,
    bar: Option<ProgressBar>,
    begun: Instant,
    spoken: Option<Instant>,
    /// The last step accepted.
    pub step: u64,
    /// Its time \[s\].
    pub time: f64,
}

impl Progress {
    /// Of a run until `end_time` \[s\].
    pub fn new(end_time: f64) -> Self {
        Progress {
            end_time,
            silent: false,
            bar: bar(1000, "{bar:30} {msg}   {elapsed} elapsed, {eta} left"),
            begun: Instant::now(),
            spoken: None,
            step: 0,
            time: 0.0,
        }
    }

    /// Of a run that others report on: it only counts.
    pub fn silent(end_time: f64) -> Self {
        Progress {
            end_time,
            silent: true,
            bar: None,
            begun: Instant::now(),
            spoken: None,
            step: 0,
            time: 0.0,
        }
    }

    /// A step was accepted.
    pub fn step(&mut self, values: &[Diagnostic]) {
        let value = |name: &str| values.iter().find(|v| v.name == name).map(|v| v.value);
        self.step = value("step").map_or(self.step + 1, |step| step as u64);
        self.time = value("time").unwrap_or(self.time);
        if self.silent {
            return;
        }
        let mut text = format!(
            "step {}, t = {:.4} of {} s",
            self.step, self.time, self.end_time
        );
        if let Some(passes) = value("passes").filter(|passes| *passes > 1.0) {
            text += &format!(", {passes} passes");
        }
        let share = (self.time / self.end_time).clamp(0.0, 1.0);
        match &self.bar {
            Some(bar) => {
                bar.set_position((1000.0 * share) as u64);
                bar.set_message(text);
            }
            None if self.spoken.is_none_or(|spoken| spoken.elapsed() >= QUIET) => {
                self.spoken = Some(Instant::now());
                let elapsed = self.begun.elapsed().as_secs_f64();
                tell!("{text} ({:.0} %), {elapsed:.1} s elapsed", 100.0 * share);
            }
            None => {}
        }
    }

    /// Say something without disturbing the bar.
    pub fn say(&self, text: &str) {
        match &self.bar {
            _ if self.silent => {}
            Some(bar) => bar.suspend(|| tell!("{text}")),
            None => tell!("{text}"),
        }
    }

    /// The run is over.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Six digits, with an exponent where it is shorter.
pub fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e5).contains(&size) => {
            let decimals = (5 - size.log10().floor() as i32).clamp(0, 8) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.5e}"),
    }
}
