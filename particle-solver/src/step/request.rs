//! What is asked of an advance.

use space::Vector;

use crate::error::Error;
use crate::grains::finite;

/// One call of `advance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step, from 0.
    pub pass: u32,
    /// Length Δt \[s\].
    pub dt: f64,
    /// Sub-steps to use; 0: the engine chooses.
    pub sub_steps: u32,
    /// Contact residual at which a solve stops; 0: that of the setup.
    pub tolerance: f64,
}

/// Which candidate it is: two of the same label may follow each other from pass to pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    /// Number of the step.
    pub step: u64,
    /// Pass within the step.
    pub pass: u32,
    /// Length Δt \[s\]: the passes of a halved step do not follow those of the whole one.
    pub dt: f64,
}

impl Request {
    /// A step of a positive length.
    pub fn check(&self) -> Result<(), Error> {
        if self.dt.is_finite() && self.dt > 0.0 {
            return Ok(());
        }
        let why = format!("step of {} s, must be positive", self.dt);
        Err(Error::Request(why))
    }

    /// Label of the candidate that answers this request.
    pub fn label(&self) -> Label {
        Label {
            step: self.step,
            pass: self.pass,
            dt: self.dt,
        }
    }

    /// Label of the candidate of the pass before; none in pass 0.
    pub fn label_before(&self) -> Option<Label> {
        let pass = self.pass.checked_sub(1)?;
        Some(Label {
            pass,
            ..self.label()
        })
    }
}

/// What the fluid does to the grains during the step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Forces<'a, const D: usize> {
    /// γ \[kg/s\].
    pub drag: Option<&'a [f64]>,
    /// q \[N\].
    pub force: Option<&'a [Vector<D>]>,
}

impl<const D: usize> Forces<'_, D> {
    /// One of each for every grain, finite, and no negative drag.
    pub fn check(&self, count: usize) -> Result<(), Error> {
        let (drag, force) = (
            self.drag.unwrap_or_default(),
            self.force.unwrap_or_default(),
        );
        let lengths = [
            ("drags", self.drag.is_some(), drag.len()),
            ("forces", self.force.is_some(), force.len()),
        ];
        for (what, given, length) in lengths {
            if given && length != count {
                return Err(Error::Request(format!(
                    "{length} {what} for {count} grains"
                )));
            }
        }
        let usable = |drag: &f64| drag.is_finite() && *drag >= 0.0;
        if let Some(grain) = drag.iter().position(|drag| !usable(drag)) {
            return Err(Error::NotFinite {
                what: "drag",
                grain,
                value: drag[grain],
            });
        }
        for (grain, force) in force.iter().enumerate() {
            finite("force", grain, force.iter().copied())?;
        }
        Ok(())
    }
}
