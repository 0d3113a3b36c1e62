//! A polygon in space as triangles.
//!
//! Strictly convex polygons are fans. The rest goes through `earcut`, which is near linear, in the plane of the
//! polygon's mean normal (Newell). `earcut` drops corners that lie on the line between their neighbours; those
//! are put back, because a corner left out of the triangles would open a gap as soon as the mesh deforms.

use std::collections::HashMap;

use earcut::Earcut;
use glam::{DVec2, DVec3};

use crate::vector::wide;

/// A turn whose sine is less than this counts as straight: positions are rounded to f32, so that corners meant to
/// lie on a line turn by about 1e-7. A larger value only sends more polygons through `earcut`.
const STRAIGHT: f64 = 1e-6;

/// Buffers for one polygon after the other.
#[derive(Default)]
pub(crate) struct Triangulator {
    space: Vec<DVec3>,
    plane: Vec<DVec2>,
    cut: Vec<u32>,
}

impl Triangulator {
    /// Appends the triangles of `polygon`, whose corners are numbered from `first`: always two fewer than corners.
    pub(crate) fn triangulate(
        &mut self,
        polygon: impl ExactSizeIterator<Item = [f32; 3]>,
        first: u32,
        out: &mut Vec<[u32; 3]>,
    ) {
        let count = polygon.len() as u32;
        if count == 3 {
            out.push([first, first + 1, first + 2]);
            return;
        }
        self.space.clear();
        self.space.extend(polygon.map(wide));
        if !self.project() || strictly_convex(&self.plane) || !self.cut(first, out) {
            out.extend((2..count).map(|i| [first, first + i - 1, first + i]));
        }
    }

    /// Drops the largest coordinate of the mean normal, so that the polygon runs counter-clockwise in the plane.
    /// False where there is no normal.
    fn project(&mut self) -> bool {
        let normal = newell(&self.space);
        let size = normal.abs();
        if size.max_element() <= 0.0 || !normal.is_finite() {
            return false;
        }
        let axis = size.max_position();
        let (mut a, mut b) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            std::mem::swap(&mut a, &mut b);
        }
        self.plane.clear();
        self.plane.extend(self.space.iter().map(|p| DVec2::new(p[a], p[b])));
        true
    }

    /// Ear clipping. False, and nothing appended, where it does not give all triangles: a polygon that crosses itself.
    fn cut(&mut self, first: u32, out: &mut Vec<[u32; 3]>) -> bool {
        let count = self.plane.len();
        Earcut::new().earcut(self.plane.iter().map(DVec2::to_array), &[], &mut self.cut);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.plane[i as usize]);
            (b - a).perp_dot(c - a)
        };
        let mut triangles: Vec<[u32; 3]> = self.cut.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        for triangle in &mut triangles {
            if area(triangle) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        put_back(count as u32, &mut triangles);
        if triangles.len() != count - 2 {
            return false;
        }
        out.extend(triangles.iter().map(|t| t.map(|i| first + i)));
        true
    }
}

/// Twice the area vector of a closed polygon.
fn newell(points: &[DVec3]) -> DVec3 {
    let Some(&origin) = points.first() else { return DVec3::ZERO };
    points.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum()
}

/// Whether every corner of a counter-clockwise polygon turns left, and all of them together once round.
fn strictly_convex(points: &[DVec2]) -> bool {
    let n = points.len();
    let edge = |i: usize| points[(i + 1) % n] - points[i % n];
    let mut reversals = 0;
    for i in 0..n {
        let (e, f) = (edge(i), edge(i + 1));
        if e.perp_dot(f) <= STRAIGHT * e.length() * f.length() {
            return false;
        }
        reversals += usize::from((e.x < 0.0) != (f.x < 0.0));
    }
    reversals <= 2
}

/// Inserts the corners that no triangle has into the triangle at the edge they lie on.
fn put_back(count: u32, triangles: &mut Vec<[u32; 3]>) {
    let mut kept = vec![false; count as usize];
    for &corner in triangles.iter().flatten() {
        kept[corner as usize] = true;
    }
    let Some(start) = kept.iter().position(|&k| k).map(|i| i as u32) else { return };
    if kept.iter().all(|&k| k) {
        return;
    }
    let mut edges = HashMap::new();
    for (i, t) in triangles.iter().enumerate() {
        edges.extend([((t[0], t[1]), i), ((t[1], t[2]), i), ((t[2], t[0]), i)]);
    }
    let mut from = start;
    while from < start + count {
        let mut to = from + 1;
        while !kept[(to % count) as usize] {
            to += 1;
        }
        if to > from + 1 {
            split(from, to, count, &mut edges, triangles);
        }
        from = to;
    }
}

/// Splits the triangle at the edge `from → to` at every corner between the two.
fn split(
    from: u32,
    to: u32,
    count: u32,
    edges: &mut HashMap<(u32, u32), usize>,
    triangles: &mut Vec<[u32; 3]>,
) {
    let (a, b) = (from % count, to % count);
    let Some(&at) = edges.get(&(a, b)) else { return };
    let Some(&apex) = triangles[at].iter().find(|&&c| c != a && c != b) else { return };
    triangles[at] = [a, (from + 1) % count, apex];
    for corner in from + 1..to {
        let next = (corner + 1) % count;
        triangles.push([corner % count, next, apex]);
    }
    // The far edge of the triangle went to the last part.
    edges.insert((b, apex), triangles.len() - 1);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(polygon: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut out = Vec::new();
        Triangulator::default().triangulate(polygon.iter().copied(), 0, &mut out);
        out
    }

    /// Signed areas along `axis`; all must be positive and add up to the polygon's.
    fn assert_covers(polygon: &[[f32; 3]], triangles: &[[u32; 3]]) {
        assert_eq!(triangles.len(), polygon.len() - 2);
        let points: Vec<DVec3> = polygon.iter().map(|&p| wide(p)).collect();
        let normal = newell(&points);
        let mut sum = 0.0;
        let mut used = vec![false; polygon.len()];
        for t in triangles {
            let [a, b, c] = t.map(|i| points[i as usize]);
            let area = (b - a).cross(c - a).dot(normal.normalize());
            assert!(area > 0.0, "{t:?} has area {area}");
            sum += area;
            for &i in t {
                used[i as usize] = true;
            }
        }
        assert!((sum - normal.length()).abs() < 1e-5 * sum, "{sum} for {}", normal.length());
        assert!(used.iter().all(|&u| u), "a corner is in no triangle");
    }

    #[test]
    fn concave_polygons_are_covered_from_either_side() {
        let mut arrow = vec![[0.0, 0.0, 0.3], [2.0, -1.0, 0.3], [0.5, 0.0, 0.3], [2.0, 1.0, 0.3]];
        for _ in 0..4 {
            assert_covers(&arrow, &triangulate(&arrow));
            arrow.rotate_left(1);
        }
        arrow.reverse();
        assert_covers(&arrow, &triangulate(&arrow));
    }

    #[test]
    fn corners_on_straight_edges_stay_in_the_triangles() {
        let mut polygon = vec![];
        for (a, b) in [([0.0, 0.0], [3.0, 0.0]), ([3.0, 0.0], [3.0, 3.0]), ([3.0, 3.0], [0.0, 0.0])] {
            for i in 0..3 {
                let x = i as f32 / 3.0;
                polygon.push([a[0] + (b[0] - a[0]) * x, 5.0, a[1] + (b[1] - a[1]) * x]);
            }
        }
        for _ in 0..polygon.len() {
            assert_covers(&polygon, &triangulate(&polygon));
            polygon.rotate_left(1);
        }
    }

    #[test]
    fn large_polygons_are_quick() {
        let star = |i: u32| {
            let radius = if i.is_multiple_of(2) { 1.0 } else { 0.9 };
            let angle = f64::from(i) / 50_000.0 * std::f64::consts::TAU;
            [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32, 0.0]
        };
        let polygon: Vec<_> = (0..50_000).map(star).collect();
        let start = std::time::Instant::now();
        let triangles = triangulate(&polygon);
        assert!(start.elapsed().as_secs_f64() < 3.0, "{:?}", start.elapsed());
        assert_covers(&polygon, &triangles);
    }

    #[test]
    fn degenerate_and_crossing_polygons_still_give_their_count() {
        for polygon in [
            vec![[1.0, 1.0, 1.0]; 7],
            (0..6).map(|i| [i as f32, 0.0, 0.0]).collect(),
            vec![[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            vec![[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            (0..5).map(|i| [(i as f32 * 2.513_27).cos(), (i as f32 * 2.513_27).sin(), 0.0]).collect(),
        ] {
            assert_eq!(triangulate(&polygon).len(), polygon.len() - 2, "{polygon:?}");
        }
    }
}
