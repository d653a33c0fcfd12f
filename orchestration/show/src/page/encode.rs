//! Numbers on their way into the page: 16 bits where a picture shows no more, 32 otherwise;
//! bytes of equal weight side by side, which deflates to about half; base64.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Numbers as 16-bit shares of the range from `low` to `high`.
#[derive(Debug, Clone, Serialize)]
pub struct Shares {
    /// What 0 stands for.
    pub low: f64,
    /// What 65535 stands for.
    pub high: f64,
    /// The numbers.
    pub data: String,
}

/// Numbers between their extremes; what is not finite counts as the lower one.
pub fn shares(values: &[f64]) -> Shares {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
    let step = (high - low) / 65535.0;
    let words = values.iter().map(|value| {
        let share = if step > 0.0 {
            (value - low) / step
        } else {
            0.0
        };
        // `as` takes NaN to 0 and what lies outside to the nearest end.
        (share.round() as u16).to_le_bytes()
    });
    Shares {
        low,
        high,
        data: pack(words),
    }
}

/// Numbers in single precision.
pub fn singles(values: impl Iterator<Item = f64>) -> String {
    pack(values.map(|value| (value as f32).to_le_bytes()))
}

/// Whole numbers of 32 bits.
pub fn words(values: impl Iterator<Item = u32>) -> String {
    pack(values.map(u32::to_le_bytes))
}

fn pack<const WIDTH: usize>(values: impl Iterator<Item = [u8; WIDTH]>) -> String {
    let values: Vec<[u8; WIDTH]> = values.collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    for plane in 0..WIDTH {
        let bytes: Vec<u8> = values.iter().map(|value| value[plane]).collect();
        // Writing to memory cannot fail.
        let _ = encoder.write_all(&bytes);
    }
    STANDARD.encode(encoder.finish().unwrap_or_default())
}
