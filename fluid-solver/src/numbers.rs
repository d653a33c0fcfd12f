//! Named numbers of a candidate, for people.

/// Names and values, in a fixed order.
pub type Numbers = Vec<(String, f64)>;

/// Numbers from names that are known at compile time.
pub(crate) fn named<'a>(numbers: impl IntoIterator<Item = (&'a str, f64)>) -> Numbers {
    let numbers = numbers.into_iter();
    numbers
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}
