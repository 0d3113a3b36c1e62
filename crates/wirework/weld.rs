//! Points that stand for all vertices at one place.
//!
//! A renderer's vertices are split at texture seams and hard edges. The effects see each place once, so that no seam
//! can open: two vertices of one place get the same bits.

use std::hash::{BuildHasher, RandomState};

use rayon::prelude::*;

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
        let mut places = Places::new(positions.len());
        let point_of = positions.iter().map(|p| places.place(p)).collect();
        Self { points: places.points, point_of }
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

/// Places that have been seen, found by their bits in a table with open addresses: a fraction of the memory of a map of the
/// standard library, and of its time.
struct Places {
    points: Vec<[f32; 3]>,
    /// One more than the index of a point, in the first slot from its hash on that was free; 0 is free.
    slots: Vec<u32>,
    /// Other ones on each run, so that no file can be made to share slots. What comes out does not depend on them.
    keys: [u64; 2],
}

impl Places {
    fn new(count: usize) -> Self {
        let random = RandomState::new();
        // At most half full, so that free slots are near.
        let slots = vec![0; (2 * count).next_power_of_two()];
        Self { points: Vec::with_capacity(count), slots, keys: [random.hash_one(0), random.hash_one(1)] }
    }

    /// The point at the place `p`, a new one where there is none.
    fn place(&mut self, p: &[f32; 3]) -> u32 {
        let key = place_bits(p);
        let mask = self.slots.len() - 1;
        let mut at = self.hash(key) & mask;
        loop {
            match self.slots[at].checked_sub(1) {
                None => {
                    self.points.push(*p);
                    self.slots[at] = self.points.len() as u32;
                    return self.slots[at] - 1;
                }
                Some(point) if place_bits(&self.points[point as usize]) == key => return point,
                Some(_) => at = (at + 1) & mask,
            }
        }
    }

    fn hash(&self, [x, y, z]: [u32; 3]) -> usize {
        let (low, high) = (u64::from(x) | u64::from(y) << 32, u64::from(z));
        let product = u128::from(low ^ self.keys[0]) * u128::from(high ^ self.keys[1]);
        (product as u64 ^ (product >> 64) as u64) as usize
    }
}

/// The bits of a place: adding 0 makes −0 equal to 0.
fn place_bits(p: &[f32; 3]) -> [u32; 3] {
    bits(p.map(|c| c + 0.0))
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
    fn as_many_points_as_places() {
        // Each place twice, in two orders, some with the sign of zero turned.
        let place = |i: u32| [(i % 7) as f32, (i / 7 % 11) as f32 * -0.5, (i / 77) as f32];
        let first = (0..1000).map(place);
        let second = (0..1000).rev().map(|i| place(i).map(|c| if c == 0.0 { -c } else { c }));
        let weld = Weld::new(&first.chain(second).collect::<Vec<_>>());
        assert_eq!(weld.points, (0..1000).map(place).collect::<Vec<_>>());
        assert!(weld.point_of.iter().copied().eq((0..1000).chain((0..1000).rev())));
        assert!(Weld::new(&[]).points.is_empty());
    }

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
