//! The states of a run that its contact sheet may show.

use scene::Error;
use serde::{Deserialize, Serialize};

use super::sheet::PANELS;
use super::state::State;

/// States kept for the sheet: at most twice `PANELS` and a few, always evenly spread.
#[derive(Debug)]
pub struct Album<const D: usize, const N: usize> {
    kept: Vec<State<D, N>>,
    last: Option<State<D, N>>,
    stride: usize,
    seen: usize,
}

/// Which states an album has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    stride: usize,
    seen: usize,
}

impl<const D: usize, const N: usize> Default for Album<D, N> {
    fn default() -> Self {
        Album {
            kept: Vec::new(),
            last: None,
            stride: 0,
            seen: 0,
        }
    }
}

impl<const D: usize, const N: usize> Album<D, N> {
    /// Which states it has.
    pub fn shown(&self) -> Shown {
        Shown {
            stride: self.stride.max(1),
            seen: self.seen,
        }
    }

    /// The album of these states, each by its number.
    pub fn again(
        shown: Shown,
        state: impl Fn(usize) -> Result<State<D, N>, Error>,
    ) -> Result<Self, Error> {
        let Shown { stride, seen } = shown;
        let numbers = (0..seen).step_by(stride.max(1));
        let last = seen.checked_sub(1).filter(|last| last % stride.max(1) != 0);
        Ok(Album {
            kept: numbers.map(&state).collect::<Result<_, _>>()?,
            last: last.map(&state).transpose()?,
            stride,
            seen,
        })
    }

    /// Keep a state, or drop every second one when there are too many.
    pub fn add(&mut self, state: State<D, N>) {
        let stride = self.stride.max(1);
        if self.seen.is_multiple_of(stride) {
            self.kept.push(state);
            self.last = None;
        } else {
            self.last = Some(state);
        }
        self.seen += 1;
        // An odd number stays even in time when every second one goes.
        if self.kept.len() > 4 * PANELS {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride = 2 * stride;
        }
    }

    /// The states kept, and the last one in any case.
    pub fn states(&self) -> Vec<&State<D, N>> {
        self.kept.iter().chain(&self.last).collect()
    }
}
