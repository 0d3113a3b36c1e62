//! The exact nearest point of a surface, for many queries.
//!
//! A tree of boxes over the triangles, halved at the median of the centres along the longest side. The tree is
//! complete, so that its shape follows from the number of triangles alone and a node is nothing but its box. `obvhs`
//! builds better trees but walks them with rays only and brings a radix sort along; `parry3d` has the query and
//! with it a collision engine; the walk is the part that must be exact and resolve ties here.

use glam::{DVec3, Vec3};
use thiserror::Error;

use crate::vector::{narrow, wide};

/// Triangles in a leaf, at most: fewer makes more boxes than triangles, more tests triangles for nothing.
const LEAF: usize = 4;
/// Below this many triangles halving a range is not worth a second thread.
const PARALLEL: usize = 8192;
/// Squared distances this close, relative to the larger or to the square of the largest coordinate, are a tie: a
/// point on an edge is found from both sides with other rounding.
const TIE: f64 = 1e-14;
/// Below this squared sine of its angle a triangle is its edges: no point of it is farther from them than the
/// rounding of f32, and the weights of a foot on its plane would be rounding alone.
const SLIVER: f64 = 1e-16;
/// Interpolated normals shorter than this have cancelled and say nothing about the outside.
const CANCELLED: f64 = 1e-3;

/// The triangles of a surface, ready for queries.
#[derive(Clone, Debug)]
pub struct Nearest {
    triangles: Vec<[u32; 3]>,
    positions: Vec<[f32; 3]>,
    /// Numbers of triangles; each leaf has a range of them.
    order: Vec<u32>,
    /// Heap order: the children of `i` are `2 i + 1` and `2 i + 2`.
    boxes: Vec<(Vec3, Vec3)>,
    /// What counts as a tie at distance 0.
    grain: f64,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle it lies in; of equally near ones the first.
    pub triangle: u32,
    /// Weights of the triangle's corners, each 0 or more, adding up to 1.
    pub barycentric: [f32; 3],
    /// The point itself.
    pub position: [f32; 3],
    /// How far the query was.
    pub distance: f32,
}

/// Why a surface cannot be searched.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NearestError {
    /// There are no triangles.
    #[error("the surface has no faces")]
    NoFaces,
    /// A triangle refers to a vertex that is not there or not finite.
    #[error("triangle {triangle} refers to vertex {vertex}, which is missing or not finite")]
    Vertex {
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex.
        vertex: u32,
    },
}

/// Refuses a surface without triangles, or with a vertex that is missing or not finite.
pub(crate) fn check(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), NearestError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        let bad = |v: &&u32| positions.get(**v as usize).is_none_or(|p| p.iter().any(|c| !c.is_finite()));
        if let Some(&vertex) = corners.iter().find(bad) {
            return Err(NearestError::Vertex { triangle, vertex });
        }
    }
    if triangles.is_empty() { Err(NearestError::NoFaces) } else { Ok(()) }
}

impl Nearest {
    /// Builds the tree. The triangles may be without area.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, NearestError> {
        check(positions, triangles)?;
        // A third of each corner, so that the sum stays in range.
        let center = |t: &[u32; 3]| t.iter().map(|&v| Vec3::from(positions[v as usize]) / 3.0).sum::<Vec3>();
        let mut items: Vec<(Vec3, u32)> = triangles.iter().zip(0..).map(|(t, i)| (center(t), i)).collect();
        let levels = items.len().div_ceil(LEAF).next_power_of_two().trailing_zeros();
        halve(&mut items, levels);
        let reach = positions.iter().flatten().fold(0.0_f32, |m, c| m.max(c.abs()));
        let mut nearest = Self {
            triangles: triangles.to_vec(),
            positions: positions.to_vec(),
            order: items.iter().map(|&(_, i)| i).collect(),
            boxes: vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); (2 << levels) - 1],
            grain: TIE * f64::from(reach) * f64::from(reach) * TIE,
        };
        nearest.fit(0, 0, triangles.len());
        Ok(nearest)
    }

    /// The nearest point; `None` only for a query that is not finite.
    pub fn nearest(&self, query: [f32; 3]) -> Option<SurfacePoint> {
        let q = wide(query);
        if !q.is_finite() {
            return None;
        }
        let mut best = (f64::INFINITY, u32::MAX, [1.0, 0.0, 0.0]);
        let mut stack = vec![(0.0, 0, 0, self.order.len())];
        while let Some((bound, node, start, end)) = stack.pop() {
            if bound > self.slack(best.0) {
                continue;
            }
            if 2 * node + 1 >= self.boxes.len() {
                for &triangle in &self.order[start..end] {
                    self.test(q, triangle, &mut best);
                }
                continue;
            }
            let middle = start + (end - start) / 2;
            let near = |node: usize| box_distance_squared(self.boxes[node], q);
            let (a, b) = (near(2 * node + 1), near(2 * node + 2));
            let (left, right) = ((a, 2 * node + 1, start, middle), (b, 2 * node + 2, middle, end));
            // The nearer one is taken up next.
            stack.extend(if a <= b { [right, left] } else { [left, right] });
        }
        let (square, triangle, weights) = best;
        let corners = self.triangles.get(triangle as usize)?.map(|v| wide(self.positions[v as usize]));
        Some(SurfacePoint {
            triangle,
            barycentric: weights.map(|w| w as f32),
            position: narrow(blend(corners, weights)),
            distance: square.sqrt() as f32,
        })
    }

    /// The unit normal of a triangle; `None` where it has no area or is not there.
    pub fn face_normal(&self, triangle: u32) -> Option<[f32; 3]> {
        let corners = self.triangles.get(triangle as usize)?.map(|v| wide(self.positions[v as usize]));
        crate::smooth::face_normal(corners).map(narrow)
    }

    /// Normals of the vertices, interpolated at a point and brought to length 1; the face's where they cancel or are
    /// missing.
    pub fn interpolated_normal(&self, at: &SurfacePoint, normals: &[[f32; 3]]) -> Option<[f32; 3]> {
        let corners = self.triangles.get(at.triangle as usize)?;
        let normal = |v: u32| normals.get(v as usize).map_or(DVec3::ZERO, |&n| wide(n));
        let sum = blend(corners.map(normal), at.barycentric.map(f64::from));
        if sum.length() > CANCELLED { Some(narrow(sum.normalize())) } else { self.face_normal(at.triangle) }
    }

    fn slack(&self, square: f64) -> f64 {
        square * (1.0 + TIE) + self.grain
    }

    fn test(&self, query: DVec3, triangle: u32, best: &mut (f64, u32, [f64; 3])) {
        let corners = self.triangles[triangle as usize].map(|v| wide(self.positions[v as usize]));
        let weights = closest(corners, query);
        let square = blend(corners, weights).distance_squared(query);
        let tie = square <= self.slack(best.0) && best.0 <= self.slack(square);
        if (tie && triangle < best.1) || (!tie && square < best.0) {
            *best = (square, triangle, weights);
        }
    }

    /// Fits the boxes of a node and all below it.
    fn fit(&mut self, node: usize, start: usize, end: usize) {
        let mut sides = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        if 2 * node + 1 >= self.boxes.len() {
            for &triangle in &self.order[start..end] {
                for v in self.triangles[triangle as usize] {
                    let p = Vec3::from(self.positions[v as usize]);
                    sides = (sides.0.min(p), sides.1.max(p));
                }
            }
        } else {
            let middle = start + (end - start) / 2;
            self.fit(2 * node + 1, start, middle);
            self.fit(2 * node + 2, middle, end);
            let (a, b) = (self.boxes[2 * node + 1], self.boxes[2 * node + 2]);
            sides = (a.0.min(b.0), a.1.max(b.1));
        }
        self.boxes[node] = sides;
    }
}

/// Sorts triangles into the ranges of the leaves. Equal centres go by number, so that there is one order only.
fn halve(items: &mut [(Vec3, u32)], levels: u32) {
    if levels == 0 || items.len() < 2 {
        return;
    }
    let (low, high) =
        items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), i| (l.min(i.0), h.max(i.0)));
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (left, right) = items.split_at_mut(middle);
    if middle > PARALLEL {
        rayon::join(|| halve(left, levels - 1), || halve(right, levels - 1));
    } else {
        halve(left, levels - 1);
        halve(right, levels - 1);
    }
}

fn box_distance_squared((low, high): (Vec3, Vec3), q: DVec3) -> f64 {
    if low.x > high.x {
        return f64::INFINITY;
    }
    q.distance_squared(q.clamp(low.as_dvec3(), high.as_dvec3()))
}

fn blend(corners: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// The weights of the point of a triangle nearest to `q`: the foot on its plane if that lies inside, or the
/// nearest point of the three edges.
fn closest([a, b, c]: [DVec3; 3], q: DVec3) -> [f64; 3] {
    let along = |from: DVec3, to: DVec3| {
        let way = to - from;
        let square = way.length_squared();
        let t = if square > 0.0 { ((q - from).dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
        ((from + way * t).distance_squared(q), t)
    };
    if let Some(weights) = foot([a, b, c], q) {
        return weights;
    }
    let (ab, bc, ca) = (along(a, b), along(b, c), along(c, a));
    if ab.0 <= bc.0 && ab.0 <= ca.0 {
        [1.0 - ab.1, ab.1, 0.0]
    } else if bc.0 <= ca.0 {
        [0.0, 1.0 - bc.1, bc.1]
    } else {
        [ca.1, 0.0, 1.0 - ca.1]
    }
}

/// The weights of the foot of `q` on a triangle's plane; `None` outside of it and for slivers.
fn foot([a, b, c]: [DVec3; 3], q: DVec3) -> Option<[f64; 3]> {
    let (ab, ac, aq) = (b - a, c - a, q - a);
    let normal = ab.cross(ac);
    let square = normal.length_squared();
    if square <= SLIVER * ab.length_squared() * ac.length_squared() {
        return None;
    }
    let (y, z) = (aq.cross(ac).dot(normal) / square, ab.cross(aq).dot(normal) / square);
    // 1 − y − z may round below 0 where y + z rounds to 1.
    (y >= 0.0 && z >= 0.0 && y + z <= 1.0).then(|| [(1.0 - y - z).max(0.0), y, z])
}

#[cfg(test)]
#[path = "nearest_tests.rs"]
mod tests;
