//! What a finished step says about contacts: who touches, who is held, how deep.

use crate::bodies::Pair;

/// Contacts of a candidate.
#[derive(Debug, Default)]
pub struct Contacts {
    /// 0 free, 1 touches, 2 held by a wall or a fixed grain through contacts that push.
    pub state: Vec<f64>,
    /// Contacts that push.
    pub active: usize,
    /// Largest overlap, of the smaller radius.
    pub penetration: f64,
}

impl Contacts {
    /// Look at the pairs of the last sub-step, of grains some of which never move.
    pub fn of(pairs: &[Pair], fixed: &[bool]) -> Contacts {
        let count = fixed.len();
        let mut found = Contacts {
            state: vec![0.0; count],
            ..Contacts::default()
        };
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut held: Vec<usize> = (0..count).filter(|&grain| fixed[grain]).collect();
        for pair in pairs {
            let [i, j] = pair.ends;
            found.penetration = found.penetration.max(pair.overlap);
            if !pair.pushes {
                continue;
            }
            found.active += 1;
            match (i < count, j < count) {
                (true, true) => {
                    neighbours[i].push(j);
                    neighbours[j].push(i);
                }
                (true, false) => held.push(i),
                (false, true) => held.push(j),
                (false, false) => {}
            }
        }
        for (grain, touching) in neighbours.iter().enumerate() {
            found.state[grain] = f64::from(u8::from(!touching.is_empty()));
        }
        while let Some(grain) = held.pop() {
            if found.state[grain] < 2.0 {
                found.state[grain] = 2.0;
                held.extend(&neighbours[grain]);
            }
        }
        found
    }
}
