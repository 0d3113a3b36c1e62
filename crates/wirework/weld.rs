//! Points that stand for all vertices at one place.
//!
//! A renderer's vertices are split at texture seams and hard edges. The effects see each place once, so that no seam
//! can open: two vertices of one place get the same bits.

use std::collections::HashMap;

/// The places of a list of positions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weld {
    /// Each place once, in the order of first use.
    pub(crate) points: Vec<[f32; 3]>,
    /// For each position its place.
    pub(crate) point_of: Vec<u32>,
}

impl Weld {
    pub(crate) fn new(positions: &[[f32; 3]]) -> Self {
        let mut places = HashMap::with_capacity(positions.len());
        let mut weld = Self { points: Vec::new(), point_of: Vec::with_capacity(positions.len()) };
        for p in positions {
            // Adding 0 makes −0 equal to 0.
            let place = *places.entry(p.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                weld.points.push(*p);
                weld.points.len() as u32 - 1
            });
            weld.point_of.push(place);
        }
        weld
    }

    /// Positions that are all different.
    pub(crate) fn distinct(positions: &[[f32; 3]]) -> Self {
        Self { points: positions.to_vec(), point_of: (0..positions.len() as u32).collect() }
    }

    /// Triangles of positions as triangles of points.
    pub(crate) fn triangles(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let point = |i: u32| self.point_of.get(i as usize).copied().unwrap_or(0);
        triangles.iter().map(|t| t.map(point)).collect()
    }
}

/// Takes the present place of each point to its positions. A position whose point has not moved keeps its own bits.
pub(crate) fn spread(
    point_of: &[u32],
    points: &[[f32; 3]],
    now: &[[f32; 3]],
    rest: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    for ((out, &place), own) in out.iter_mut().zip(point_of).zip(rest) {
        let place = place as usize;
        *out = match (points.get(place), now.get(place)) {
            (Some(before), Some(now)) if bits(*before) != bits(*now) => *now,
            _ => *own,
        };
    }
}

pub(crate) fn bits(p: [f32; 3]) -> [u32; 3] {
    p.map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_shared_and_positions_keep_their_own_zero() {
        let positions = [[0.0, 1.0, 2.0], [3.0, 0.0, 0.0], [-0.0, 1.0, 2.0]];
        let weld = Weld::new(&positions);
        assert_eq!(weld.point_of, [0, 1, 0]);
        assert_eq!(weld.triangles(&[[2, 1, 0]]), [[0, 1, 0]]);
        let mut out = positions;
        spread(&weld.point_of, &weld.points, &[[0.0, 1.0, 2.0], [9.0; 3]], &positions, &mut out);
        assert!(out[2][0].is_sign_negative());
        assert_eq!(out[1], [9.0; 3]);
    }
}
