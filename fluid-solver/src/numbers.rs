//! Named numbers of a candidate, for people.

/// Names and values, in a fixed order.
pub type Numbers = Vec<(String, f64)>;

/// Numbers from names that are known at compile time.
pub(crate) fn named<const K: usize>(numbers: [(&str, f64); K]) -> Numbers {
    numbers
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
}
