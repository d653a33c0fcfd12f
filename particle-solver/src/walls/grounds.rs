//! What a grain at a wall rubs on: the ground, at rest or moving along the wall.

use space::Vector;

/// The different velocities of walls, each a body of the contact problem.
#[derive(Debug, Clone)]
pub struct Grounds<const D: usize> {
    /// Each once \[m/s\]; the first one rests.
    pub velocity: Vec<Vector<D>>,
    /// Which one a face or a ridge is part of.
    of_feature: Vec<u32>,
}

impl<const D: usize> Default for Grounds<D> {
    fn default() -> Grounds<D> {
        Grounds::new(&[])
    }
}

impl<const D: usize> Grounds<D> {
    /// Of walls with these velocities \[m/s\], feature by feature.
    pub fn new(velocities: &[Vector<D>]) -> Grounds<D> {
        let mut velocity = vec![Vector::zeros()];
        let mut number = |moving: &Vector<D>| {
            let known = velocity.iter().position(|known| known == moving);
            known.unwrap_or_else(|| {
                velocity.push(*moving);
                velocity.len() - 1
            }) as u32
        };
        let of_feature = velocities.iter().map(&mut number).collect();
        Grounds {
            velocity,
            of_feature,
        }
    }

    /// The body that a face or a ridge is part of.
    pub fn of(&self, feature: usize) -> u32 {
        self.of_feature.get(feature).copied().unwrap_or(0)
    }
}
