//! Points that stand for all vertices at one place.
//!
//! A renderer's vertices are split at texture seams and hard edges. The effects see each place once, so that no seam
//! can open: two vertices of one place get the same bits.

use rayon::prelude::*;
use wirework_surface::Distinct;

use crate::Pieces;

/// So many positions are placed by one thread at a time.
const BLOCK: usize = 1 << 12;

/// No number of its own.
pub(crate) const ANY: u32 = u32::MAX;

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
        let Distinct { of, first } = Distinct::new(positions.len(), |i| positions[i]);
        Self { points: first.iter().map(|&i| positions[i as usize]).collect(), point_of: of }
    }

    /// The same of positions in pieces: those of one piece that are at one place are one, unless each has a number of its `own`
    /// and these differ.
    pub(crate) fn in_pieces(positions: &[[f32; 3]], pieces: &[u32], own: &[u32]) -> Self {
        let row = |i: usize| {
            let [x, y, z] = positions[i];
            let piece = pieces.get(i).copied().unwrap_or(Pieces::NONE);
            let own = own.get(i).copied().unwrap_or(ANY);
            // Halves of a number are numbers that `f32` has.
            let halves = |number: u32| [(number & 0xffff) as f32, (number >> 16) as f32];
            let ([a, b], [c, d]) = (halves(piece), halves(own));
            [x, y, z, a, b, c, d]
        };
        let Distinct { of, first } = Distinct::new(positions.len(), row);
        Self { points: first.iter().map(|&i| positions[i as usize]).collect(), point_of: of }
    }

    /// Positions that are all different.
    pub(crate) fn distinct(positions: &[[f32; 3]]) -> Self {
        Self { points: positions.to_vec(), point_of: (0..positions.len() as u32).collect() }
    }

    /// Triangles of positions as triangles of points.
    pub(crate) fn triangles(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let point = |i: u32| self.point_of.get(i as usize).copied().unwrap_or(0);
        triangles.par_iter().map(|t| t.map(point)).collect()
    }
}

/// Takes the present place of each point to its positions, `rest` before. A position whose point has not moved keeps its own bits.
pub(crate) fn spread(
    point_of: &[u32],
    points: &[[f32; 3]],
    now: &[[f32; 3]],
    rest: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    let one = |((out, &place), own): ((&mut [f32; 3], &u32), &[f32; 3])| {
        let place = place as usize;
        *out = match (points.get(place), now.get(place)) {
            (Some(before), Some(now)) if bits(*before) == bits(*now) => *own,
            (Some(before), Some(now)) if own == before => *now,
            // A clip has taken it away from its point: it keeps as far.
            (Some(before), Some(now)) => std::array::from_fn(|k| own[k] + (now[k] - before[k])),
            _ => *own,
        };
    };
    out.par_iter_mut().zip(point_of).zip(rest).with_min_len(BLOCK).for_each(one);
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
