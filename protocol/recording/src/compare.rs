//! Differences between two sequences of the same field.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::entry::Key;

/// Where the largest difference is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Place {
    /// Step.
    pub step: u64,
    /// Attempt at the step, from 0.
    pub attempt: u32,
    /// Pass.
    pub pass: u32,
    /// Node, triangle or grain.
    pub index: usize,
    /// Component within it.
    pub component: usize,
    /// Value in the first sequence.
    pub first: f64,
    /// Value in the second.
    pub second: f64,
}

/// Differences of one field over all its messages.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Messages compared.
    pub messages: u64,
    /// Numbers compared.
    pub numbers: u64,
    /// Numbers of which any bit differs.
    pub unequal: u64,
    /// Largest absolute value in the first sequence: the scale of the tolerance.
    pub scale: f64,
    /// Largest absolute difference; infinite where only one of the two is finite.
    pub max: f64,
    /// Root of the mean square of the differences.
    pub rms: f64,
    /// Where the largest difference is; none where there is none.
    pub place: Option<Place>,
    #[serde(skip)]
    squares: f64,
}

impl Difference {
    /// Compare one message of both sequences. An error says that their lengths differ.
    pub fn add(
        &mut self,
        key: Key,
        components: usize,
        first: &[f64],
        second: &[f64],
    ) -> Result<(), String> {
        if first.len() != second.len() {
            return Err(format!("{} and {} numbers", first.len(), second.len()));
        }
        self.messages += 1;
        self.numbers += first.len() as u64;
        for (k, (&a, &b)) in first.iter().zip(second).enumerate() {
            if a.is_finite() {
                self.scale = self.scale.max(a.abs());
            }
            if a.to_bits() == b.to_bits() {
                continue;
            }
            self.unequal += 1;
            let difference = if a.is_finite() && b.is_finite() {
                (a - b).abs()
            } else {
                f64::INFINITY
            };
            self.squares += difference * difference;
            if difference > self.max {
                self.max = difference;
                self.place = Some(Place {
                    step: key.step,
                    attempt: key.attempt,
                    pass: key.pass,
                    index: k / components,
                    component: k % components,
                    first: a,
                    second: b,
                });
            }
        }
        self.rms = (self.squares / self.numbers.max(1) as f64).sqrt();
        Ok(())
    }

    /// Largest difference over the largest magnitude of the field; 0 only when there is none.
    pub fn relative(&self) -> f64 {
        if self.max == 0.0 {
            0.0
        } else {
            self.max / self.scale
        }
    }

    /// The row as JSON, with its verdict; what is not finite is null.
    pub fn to_json(&self, tolerance: f64) -> serde_json::Value {
        let mut row = serde_json::to_value(self).unwrap_or_default();
        row["relative"] = self.relative().into();
        row["within"] = self.within(tolerance).into();
        row
    }

    /// Is it at most `tolerance` of the largest magnitude?
    pub fn within(&self, tolerance: f64) -> bool {
        self.relative() <= tolerance
    }
}

/// Differences by name.
pub type Table = BTreeMap<String, Difference>;

/// The table as text: a row a field.
pub fn text(table: &Table, tolerance: f64) -> String {
    let width = table.keys().map(String::len).max().unwrap_or(0).max(5);
    let mut text = format!(
        "{:width$}  {:>8}  {:>10}  {:>10}  {:>10}  {:>10}  where\n",
        "field", "numbers", "max", "rms", "of largest", "unequal"
    );
    for (name, row) in table {
        let place = row.place.map_or("–".to_owned(), |place| {
            let attempt = match place.attempt {
                0 => String::new(),
                attempt => format!(" attempt {attempt}"),
            };
            format!(
                "step {}{attempt} pass {}, number {} component {}: {:e} and {:e}",
                place.step, place.pass, place.index, place.component, place.first, place.second
            )
        });
        let verdict = if row.within(tolerance) {
            ""
        } else {
            "  OUTSIDE"
        };
        text += &format!(
            "{name:width$}  {:>8}  {:>10.3e}  {:>10.3e}  {:>10.3e}  {:>10}  {place}{verdict}\n",
            row.numbers,
            row.max,
            row.rms,
            row.relative(),
            row.unequal
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_found_with_its_place_and_its_share_of_the_scale() {
        let mut row = Difference::default();
        let key = Key {
            step: 3,
            attempt: 0,
            pass: 2,
            place: 7,
        };
        row.add(key, 2, &[1.0, -4.0, 2.0, 0.0], &[1.0, -4.0, 2.0, -0.0])
            .expect("lengths");
        assert_eq!((row.max, row.unequal, row.place), (0.0, 1, None));
        assert!(row.within(0.0));
        row.add(key, 2, &[1.0, -4.0, 2.0, 0.0], &[1.0, -4.0, 2.0, 0.5])
            .expect("lengths");
        assert_eq!((row.max, row.scale, row.relative()), (0.5, 4.0, 0.125));
        assert_eq!(row.rms, (0.25_f64 / 8.0).sqrt());
        let place = row.place.expect("a place");
        assert_eq!((place.step, place.pass), (3, 2));
        assert_eq!((place.index, place.component), (1, 1));
        assert!(row.within(0.125) && !row.within(0.124));
        assert!(row.add(key, 1, &[1.0], &[1.0, 2.0]).is_err());
    }

    #[test]
    fn what_is_not_finite_in_one_of_both_is_infinitely_far_and_in_both_with_the_same_bits_equal() {
        let key = Key::default();
        let nan = f64::NAN;
        let mut row = Difference::default();
        row.add(key, 1, &[nan, 1.0], &[nan, 1.0]).expect("lengths");
        assert!(row.within(0.0));
        row.add(key, 1, &[1.0], &[nan]).expect("lengths");
        assert!(!row.within(1e300), "{row:?}");
        let mut zeros = Difference::default();
        zeros.add(key, 1, &[0.0], &[1e-300]).expect("lengths");
        assert!(
            !zeros.within(1e300),
            "against nothing, anything is too much"
        );
    }
}
