//! Colours: a sequential map for speeds, and the inks of everything else.

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Paper.
pub const PAPER: Rgb = [255, 255, 255];
/// Text, axes, walls.
pub const INK: Rgb = [33, 37, 41];
/// Secondary lines.
pub const GREY: Rgb = [134, 142, 150];
/// Grains over a fluid: seen on the pale and on the deep end of the map.
pub const GRAIN: Rgb = [214, 86, 18];
/// Grains that never move.
pub const FIXED_GRAIN: Rgb = [92, 84, 78];

/// Anchors of the map of speeds, pale to deep, their lightness falling evenly.
const ANCHORS: [[f64; 3]; 7] = [
    [248.0, 251.0, 253.0],
    [212.0, 231.0, 242.0],
    [160.0, 205.0, 226.0],
    [98.0, 170.0, 206.0],
    [48.0, 128.0, 180.0],
    [22.0, 84.0, 145.0],
    [10.0, 42.0, 92.0],
];

/// Anchors of the map of dry grains: the pale end would vanish on paper.
const DRY_ANCHORS: [[f64; 3]; 6] = [
    [46.0, 42.0, 84.0],
    [52.0, 92.0, 141.0],
    [39.0, 137.0, 141.0],
    [83.0, 178.0, 108.0],
    [181.0, 208.0, 62.0],
    [247.0, 214.0, 72.0],
];

/// Colour of a share between 0 and 1 of a fluid's speed.
pub fn fluid(share: f64) -> Rgb {
    between(&ANCHORS, share)
}

/// Steps of the table of [`FluidColours`].
const STEPS: usize = 1023;

/// Colours of a fluid's speeds, made once for all pixels.
pub struct FluidColours {
    shares: Vec<Rgb>,
    per_speed: f64,
}

impl FluidColours {
    /// With this speed \[m/s\] the deepest one.
    pub fn new(speed_max: f64) -> FluidColours {
        let share = |step: usize| fluid(step as f64 / STEPS as f64);
        FluidColours {
            shares: (0..=STEPS).map(share).collect(),
            per_speed: match speed_max > 0.0 {
                true => STEPS as f64 / speed_max,
                false => 0.0,
            },
        }
    }

    /// That of a speed \[m/s\].
    pub fn of(&self, speed: f64) -> Rgb {
        self.shares[((speed * self.per_speed) as usize).min(STEPS)]
    }
}

/// Colour of a share between 0 and 1 of a grain's speed where there is no fluid.
pub fn dry(share: f64) -> Rgb {
    between(&DRY_ANCHORS, share)
}

fn between(anchors: &[[f64; 3]], share: f64) -> Rgb {
    let last = anchors.len() - 1;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let index = (place as usize).min(last - 1);
    let weight = place - index as f64;
    std::array::from_fn(|channel| {
        let (a, b) = (anchors[index][channel], anchors[index + 1][channel]);
        (a + weight * (b - a)).round() as u8
    })
}
