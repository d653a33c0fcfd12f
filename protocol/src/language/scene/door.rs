//! Does what a scene says fit its dimension?

/// The dimension, where it is one that there can be.
pub(crate) fn dimension(dimension: usize) -> Result<usize, String> {
    match dimension {
        2 | 3 => Ok(dimension),
        other => Err(format!("dimension is {other}, must be 2 or 3")),
    }
}

/// Has a vector as many numbers as the space has dimensions?
pub(crate) fn fits<T>(dimension: usize, what: &str, vector: &[T]) -> Result<(), String> {
    if vector.len() == dimension {
        return Ok(());
    }
    let count = vector.len();
    Err(format!("{what} has {count} numbers, must have {dimension}"))
}

/// The numbers of a vector for a reader that is made for `D` dimensions; an error where the scene has
/// others.
pub fn fixed<const D: usize, T: Copy>(vector: &[T]) -> Result<[T; D], String> {
    <[T; D]>::try_from(vector).map_err(|_| {
        let asked = vector.len();
        format!("{asked} dimensions are asked for, only {D} can be done here")
    })
}
