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
        assert_eq!(relative(1e-20, present(0.0, 0.0)), 0.0);
        assert_eq!(relative(1e-20, present(0.0, 1e-3)), 1e-17);
        assert_eq!(relative(1e-20, present(1e-30, 1e-3)), 1e-17);
        assert_eq!(relative(1e-20, present(1e-4, 1e-3)), 1e-16);
    }
}
