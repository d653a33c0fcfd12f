//! Who touches, and who hangs on a wall: a union-find over active contacts.

/// Contact states gathered over the sub-steps of a step.
#[derive(Debug)]
pub struct Touched {
    /// Parent of each grain; the last one is the ground.
    parent: Vec<u32>,
    touches: Vec<bool>,
}

impl Touched {
    /// Nobody touches.
    pub fn new(grain_count: usize) -> Touched {
        Touched {
            parent: (0..=grain_count as u32).collect(),
            touches: vec![false; grain_count],
        }
    }

    /// A force acts between a grain and another one, or a wall (any larger number).
    pub fn join(&mut self, first: usize, second: usize, fixed: &[bool]) {
        let ground = self.touches.len();
        for body in [first, second.min(ground)] {
            if body < ground {
                self.touches[body] = true;
            }
        }
        let anchored = |body: usize| {
            if fixed.get(body).copied().unwrap_or(true) {
                ground
            } else {
                body
            }
        };
        let (one, two) = (self.root(anchored(first)), self.root(anchored(second)));
        // The larger number becomes the root, so the ground stays one.
        self.parent[one.min(two)] = one.max(two) as u32;
    }

    fn root(&mut self, mut body: usize) -> usize {
        while self.parent[body] as usize != body {
            let above = self.parent[self.parent[body] as usize];
            self.parent[body] = above;
            body = above as usize;
        }
        body
    }

    /// 0 free, 1 touches, 2 force-connected to a wall or a fixed grain, or fixed itself.
    pub fn answer(mut self, fixed: &[bool]) -> Vec<u8> {
        let ground = self.touches.len();
        (0..ground)
            .map(|grain| match (fixed[grain], self.touches[grain]) {
                (true, _) => 2,
                (false, false) => 0,
                (false, true) => 1 + u8::from(self.root(grain) == ground),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_chains_that_reach_a_wall_or_a_fixed_grain_are_held() {
        // 0–1–2–wall, 3–4, 5 alone, 6–7 with 7 fixed, 8 fixed and alone.
        let mut fixed = [false; 9];
        (fixed[7], fixed[8]) = (true, true);
        let mut touched = Touched::new(9);
        for (first, second) in [(0, 1), (1, 2), (3, 4), (2, 12), (6, 7)] {
            touched.join(first, second, &fixed);
        }
        let answer = touched.answer(&fixed);
        println!("{answer:?}");
        assert_eq!(answer, [2, 2, 2, 1, 1, 0, 2, 2, 2]);
    }
}
