//! What defects are relative to: a scale that the scene has.

/// Part of all that acts to which a scale must amount, or it is nothing but round-off.
const ROUND_OFF: f64 = 1e-12;

/// The scale meant, or all that acts where there is none of it, as of weights where nothing weighs.
pub fn present(meant: f64, all: f64) -> f64 {
    if meant > ROUND_OFF * all { meant } else { all }
}

/// A size over a scale; 0 where there is nothing at all.
pub fn relative(size: f64, scale: f64) -> f64 {
    if scale > 0.0 { size / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_relative_to_nothing_and_weightless_grains_to_their_forces() {
        let small = 0.5_f64.powi(80);
        assert_eq!(relative(small, present(0.0, 0.0)), 0.0);
        assert_eq!(relative(small, present(0.0, 0.25)), 4.0 * small);
        assert_eq!(relative(small, present(small, 0.25)), 4.0 * small);
        assert_eq!(relative(small, present(0.125, 0.25)), 8.0 * small);
    }
}
