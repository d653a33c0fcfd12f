//! The impulses of contacts, remembered by pair from one solve to the next.

use space::periodic::Image;
use space::{Dim, Dimension, Vector};

use crate::contact::law::Local;

/// Which contact it is: the same key means the same pair, whatever the step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// A grain.
    pub first: u32,
    /// A grain of larger number, or the number of grains plus a wall feature.
    pub second: u32,
    /// Periodic image of the pair.
    pub image: Image,
}

/// A pair that may touch within a sub-step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<const D: usize> {
    /// Which.
    pub key: Key,
    /// Unit normal from the second to the first.
    pub normal: Vector<D>,
    /// Distance of the surfaces \[m\], negative when they overlap.
    pub gap: f64,
}

/// Impulses by contact, sorted by key; only those that act.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Impulses<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Length of the sub-step that they belong to \[s\].
    pub dt: f64,
    /// Of each contact \[N s\].
    pub entries: Vec<(Key, Local<D>)>,
}

impl<const D: usize> Impulses<D>
where
    Dim<D>: Dimension<D>,
{
    /// Impulses for these sorted pairs in a sub-step of length `dt`; 0 for new contacts.
    pub fn recall(&self, pairs: &[Pair<D>], dt: f64) -> Vec<Local<D>> {
        let rescale = if self.dt > 0.0 { dt / self.dt } else { 0.0 };
        let mut remembered = self.entries.iter().peekable();
        let mut impulses = Vec::with_capacity(pairs.len());
        for pair in pairs {
            while remembered.peek().is_some_and(|entry| entry.0 < pair.key) {
                remembered.next();
            }
            impulses.push(match remembered.peek() {
                Some((key, impulse)) if *key == pair.key => impulse.times(rescale),
                _ => Local::default(),
            });
        }
        impulses
    }
}
