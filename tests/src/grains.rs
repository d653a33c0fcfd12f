//! Sets of grains for tests.

use std::f64::consts::PI;

use protocol::engine::InitialGrains;

/// Disks of one density at these centres, at rest.
pub fn disks(centres: &[[f64; 2]], radii: &[f64], density: f64) -> InitialGrains {
    let volume: Vec<f64> = radii.iter().map(|radius| PI * radius * radius).collect();
    InitialGrains {
        dimension: 2,
        position: centres.iter().flatten().copied().collect(),
        velocity: vec![0.0; 2 * centres.len()],
        radius: radii.to_vec(),
        mass: volume.iter().map(|volume| density * volume).collect(),
        volume,
        fixed: vec![0.0; centres.len()],
    }
}

/// Fix all grains.
pub fn frozen(mut grains: InitialGrains) -> InitialGrains {
    grains.fixed.iter_mut().for_each(|flag| *flag = 1.0);
    grains
}

/// A square lattice with its first grain half a spacing from the lower corner.
pub fn lattice(lower: [f64; 2], spacing: f64, counts: [usize; 2]) -> Vec<[f64; 2]> {
    let place = |index: usize, axis: usize| lower[axis] + (index as f64 + 0.5) * spacing;
    (0..counts[0] * counts[1])
        .map(|k| [place(k % counts[0], 0), place(k / counts[0], 1)])
        .collect()
}

/// Vogel's sunflower: evenly spread points in a disk, without random scatter.
pub fn sunflower(centre: [f64; 2], radius: f64, count: usize) -> Vec<[f64; 2]> {
    let golden = PI * (1.0 + 5.0_f64.sqrt());
    let point = |k: usize| {
        let share = (k as f64 + 0.5) / count as f64;
        let (sine, cosine) = (golden * (k as f64 + 0.5)).sin_cos();
        [
            centre[0] + radius * share.sqrt() * cosine,
            centre[1] + radius * share.sqrt() * sine,
        ]
    };
    (0..count).map(point).collect()
}

/// Numbers in [0, 1) that repeat for a seed (a 64-bit linear congruential generator, Knuth's).
pub struct Noise(u64);

impl Noise {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Noise {
        Noise(seed.wrapping_mul(2).wrapping_add(1))
    }

    /// The next number.
    pub fn draw(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [−half, half).
    pub fn around(&mut self, half: f64) -> f64 {
        half * (2.0 * self.draw() - 1.0)
    }
}
