//! What players make of displacements: how far apart two states of a mesh are in the world.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::frame::Frame;
use crate::rest::{Block, Rest};
use crate::way::double;

/// So many vertices are compared by one thread at a time.
const BLOCK: usize = 1 << 12;

/// Steps towards the longest direction of a transform; each brings it nearer by the square of the ratio of the two longest. Two that are
/// nearly as long are as good as each other.
const STEPS: usize = 24;

impl Rest {
    /// For each vertex of a block by how much displacements grow on their way to the world, at most: the largest singular value of
    /// its transform. Empty where there is no such block.
    pub fn stretches(&self, block: usize) -> Vec<f32> {
        let Some(block) = self.blocks.get(block) else { return Vec::new() };
        if let Frame::Node(way) = &block.frame {
            return vec![largest(way.transpose); block.count];
        }
        (0..block.count).into_par_iter().map(|v| largest(block.frame.way(v).transpose)).collect()
    }

    /// How far two states of a block are apart, metres: the largest distance in the world between a vertex displaced by `a` and the
    /// same one displaced by `b`, both in the space of the mesh. A list that is too short counts as 0 from there on.
    pub fn apart(&self, block: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
        largest_of(self.blocks.get(block), |block, v| {
            let at = |list: &[[f32; 3]]| list.get(v).map_or(DVec3::ZERO, |delta| double(*delta));
            let apart = at(a) - at(b);
            if apart == DVec3::ZERO {
                0.0
            } else {
                (block.frame.way(v).transpose.transpose() * apart).length()
            }
        })
    }

    /// By which angle, radians, the normals that players show with `deltas` added to those of a block are off: against `now`, the
    /// world normals of all vertices. The largest, the sum of all, and how many were compared: those that either is not at rest of. Normals
    /// without a length are passed over.
    pub fn askew(&self, block: usize, deltas: &[[f32; 3]], now: &[[f32; 3]]) -> (f64, f64, usize) {
        let none = (0.0, 0.0, 0);
        let Some(block) = self.blocks.get(block) else { return none };
        let at = |v: usize| -> Option<f64> {
            let (base, rest) = (block.local_normals.as_ref()?.get(v)?, block.normals.as_ref()?.get(v)?);
            let (delta, now) = (deltas.get(v).copied().unwrap_or_default(), now.get(block.first + v)?);
            if delta == [0.0; 3] && now == rest {
                return None;
            }
            let shown = double(block.frame.way(v).normal(double(*base) + double(delta)));
            let now = double(*now);
            (shown != DVec3::ZERO && now != DVec3::ZERO).then(|| shown.angle_between(now))
        };
        let piece = |start: usize| {
            let angles = (start..(start + BLOCK).min(block.count)).filter_map(at);
            angles.fold(none, |(most, sum, count), angle| (most.max(angle), sum + angle, count + 1))
        };
        // Sums are the same on any number of threads.
        let starts: Vec<usize> = (0..block.count).step_by(BLOCK).collect();
        let pieces: Vec<(f64, f64, usize)> = starts.into_par_iter().map(piece).collect();
        pieces.into_iter().fold(none, |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2))
    }
}

impl Block {
    /// Unit normals in the space of the mesh, its morph targets applied; none where the input has none. What
    /// [`LocalDeltas::normals`](crate::LocalDeltas::normals) are added to.
    pub fn local_normals(&self) -> Option<&[[f32; 3]]> {
        self.local_normals.as_deref()
    }

    /// Unit tangents in the space of the mesh, their handedness left out, its morph targets applied; none where the input has none. What
    /// [`LocalDeltas::tangents`](crate::LocalDeltas::tangents) are added to.
    pub fn local_tangents(&self) -> Option<&[[f32; 3]]> {
        self.local_tangents.as_deref()
    }
}

/// The largest of what there is at the vertices of a block.
fn largest_of(block: Option<&Block>, at: impl Fn(&Block, usize) -> f64 + Sync) -> f64 {
    let Some(block) = block else { return 0.0 };
    let vertices = (0..block.count).into_par_iter().with_min_len(BLOCK);
    vertices.map(|v| at(block, v)).reduce(|| 0.0, f64::max)
}

/// The largest singular value. One of the columns to start from is not across the direction that is sought.
fn largest(matrix: DMat3) -> f32 {
    let square = matrix * matrix.transpose();
    let from =
        |start: DVec3| (0..STEPS).fold(start, |direction, _| square * direction.normalize_or_zero()).length();
    [square.x_axis, square.y_axis, square.z_axis].into_iter().map(from).fold(0.0, f64::max).sqrt() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, EulerRot};

    #[test]
    fn the_longest_direction_is_found() {
        let turn = |a: f64| DMat3::from_quat(DQuat::from_euler(EulerRot::XYZ, a, 2.0 * a, 0.3));
        for (size, expected) in
            [([1.0, 1.0, 1.0], 1.0), ([2.0, 2.0, 0.5], 2.0), ([-3.0, 1.0, 2.9], 3.0), ([0.0; 3], 0.0)]
        {
            for angle in [0.0, 0.4, 2.0] {
                let matrix = turn(angle) * DMat3::from_diagonal(DVec3::from_array(size)) * turn(1.1 * angle);
                assert!((f64::from(largest(matrix)) - expected).abs() <= 2e-2 * expected, "{size:?} {angle}");
            }
        }
    }
}
