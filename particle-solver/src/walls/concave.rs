//! How far a face may reach beyond a concave side.

use space::dot;

use crate::walls::facet::Face;

/// From a side to the farthest corner, along the face, of the faces that rise from it and from each other
/// \[m\]. `place` is the side's number, `rising` has the faces that rise from each side: D sides a face.
///
/// Over these faces the wall only turns towards the grains, so the face lies behind it. Farther on the wall may turn
/// away, and the face would stick out.
pub fn beyond<const D: usize>(faces: &[Face<D>], rising: &[Vec<usize>], place: usize) -> f64 {
    let own = &faces[place / D];
    let side = &own.sides[place % D];
    let mut seen = vec![false; faces.len()];
    seen[place / D] = true;
    let mut waiting = rising[place].clone();
    let mut farthest = 0.0f64;
    while let Some(number) = waiting.pop() {
        if std::mem::replace(&mut seen[number], true) {
            continue;
        }
        let face = &faces[number];
        for corner in &face.corners {
            let offset = face.middle + corner - own.middle;
            farthest = farthest.max(-side.distance - dot(&offset, &side.inward));
        }
        waiting.extend((0..D).flat_map(|k| &rising[D * number + k]));
    }
    farthest
}
