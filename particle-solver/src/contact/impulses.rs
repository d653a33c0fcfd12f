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
    /// Of the contacts that are left when these of `count` grains go, by ascending numbers; the others
    /// keep their order, so the entries stay sorted.
    pub fn without(&self, gone: &[usize], count: usize) -> Impulses<D> {
        let left = (count - gone.len()) as u32;
        let number = |grain: u32| match gone.binary_search(&(grain as usize)) {
            Ok(_) => None,
            Err(before) => Some(grain - before as u32),
        };
        let second = |second: u32| match (second as usize).checked_sub(count) {
            Some(feature) => Some(left + feature as u32),
            None => number(second),
        };
        let entries = self.entries.iter().filter_map(|(key, impulse)| {
            let key = Key {
                first: number(key.first)?,
                second: second(key.second)?,
                ..*key
            };
            Some((key, *impulse))
        });
        Impulses {
            dt: self.dt,
            entries: entries.collect(),
        }
    }

    /// Impulses for these sorted contacts in a sub-step of length `dt`; 0 for new ones.
    pub fn recall(&self, keys: impl Iterator<Item = Key>, dt: f64) -> Vec<Local<D>> {
        let rescale = if self.dt > 0.0 { dt / self.dt } else { 0.0 };
        let mut remembered = self.entries.iter().peekable();
        keys.map(|key| {
            while remembered.peek().is_some_and(|entry| entry.0 < key) {
                remembered.next();
            }
            match remembered.peek() {
                Some((known, impulse)) if *known == key => impulse.times(rescale),
                _ => Local::default(),
            }
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_of_grains_that_go_are_forgotten_and_walls_stay_walls() {
        let key = |first, second| Key {
            first,
            second,
            ..Key::default()
        };
        let with = |keys: &[Key]| Impulses::<2> {
            dt: 0.5,
            entries: keys.iter().map(|&key| (key, Local::default())).collect(),
        };
        // Five grains; 5 and 7 are features of walls.
        let before = with(&[key(0, 2), key(0, 5), key(1, 2), key(2, 4), key(4, 7)]);
        let after = with(&[key(0, 1), key(0, 3), key(1, 2), key(2, 5)]);
        assert_eq!(before.without(&[1, 3], 5), after);
        assert_eq!(before.without(&[], 5), before);
    }
}
