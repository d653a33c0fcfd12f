//! Pressures that are known up to a constant.

/// Parts of a mesh whose pressure is known up to a constant.
#[derive(Debug, Clone, Default)]
pub struct Floating {
    /// A node of each, whose pressure is given.
    pub pinned: Vec<usize>,
    /// For each node the number of its part, or one that there is not.
    pub part: Vec<u32>,
}

impl Floating {
    /// The pinned row of each part, so that all its rows of continuity add up to 0.
    pub fn fill_pinned<const N: usize>(&self, residual: &mut [f64]) {
        let mut sums = vec![0.0; self.pinned.len()];
        for (values, &part) in residual.chunks_exact(N).zip(&self.part) {
            if let Some(sum) = sums.get_mut(part as usize) {
                *sum += values[N - 1];
            }
        }
        for (&node, sum) in self.pinned.iter().zip(sums) {
            residual[N * node + N - 1] -= sum;
        }
    }

    /// Shift the pressures of each part so that it is 0 where it is pinned.
    pub fn level<const N: usize>(&self, x: &mut [f64]) {
        let pinned = self.pinned.iter();
        let shift: Vec<f64> = pinned.map(|&node| x[N * node + N - 1]).collect();
        for (values, &part) in x.chunks_exact_mut(N).zip(&self.part) {
            if let Some(shift) = shift.get(part as usize) {
                values[N - 1] -= shift;
            }
        }
    }
}
