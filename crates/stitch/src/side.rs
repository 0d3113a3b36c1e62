//! One edge of a seam on the surface as it is: where its vertices are, which way it runs and where its surface lies.

use glam::{DQuat, DVec3};
use wirework_core::{Curve, CurveError, CurveKind};

use crate::pairing::{Place, Track};
use crate::surfaces::wide;

/// How the surface stands at a point of an edge. All unit, or zero where there is none.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    /// `R′`.
    pub(crate) along: DVec3,
    /// Across the edge, into the surface.
    pub(crate) inward: DVec3,
    /// Outwards.
    pub(crate) normal: DVec3,
}

/// An edge and what it is paired with.
#[derive(Clone, Debug)]
pub(crate) struct Side {
    pub(crate) track: Track,
    /// For each vertex its place on the other edge.
    pub(crate) other: Vec<Place>,
    /// The triangles at each vertex.
    fans: Vec<Vec<[u32; 3]>>,
    /// `R`.
    pub(crate) reference: Curve,
    /// The vertices where they are.
    pub(crate) own: Vec<DVec3>,
    pub(crate) frames: Vec<Frame>,
}

impl Side {
    /// `R` goes through the vertices of the edge: smooth, so that the surface follows smoothly, and exact at the vertices.
    pub(crate) fn new(
        track: Track,
        other: &Track,
        fans: Vec<Vec<[u32; 3]>>,
        positions: &[[f32; 3]],
    ) -> Result<Self, CurveError> {
        let places = track.t.iter().map(|&t| other.place(t)).collect();
        let points = vertices(&track, positions);
        let closed = track.path.closed && points.len() > 2;
        let reference = Curve::new(CurveKind::CatmullRom, closed, points)?;
        let mut side = Self { other: places, fans, reference, own: Vec::new(), frames: Vec::new(), track };
        side.measure(positions);
        Ok(side)
    }

    /// Takes the edge to where its vertices are now.
    pub(crate) fn follow(&mut self, positions: &[[f32; 3]]) {
        if let Ok(reference) = self.reference.posed(vertices(&self.track, positions)) {
            self.reference = reference;
        }
        self.measure(positions);
    }

    fn measure(&mut self, positions: &[[f32; 3]]) {
        self.own = self.reference.points().iter().map(|p| wide(*p)).collect();
        let tangents = self.reference.at(self.parameters());
        let path = &self.track.path;
        let count = path.vertices.len();
        // The vertices before and behind on the edge.
        let beside = |i: usize| {
            let before =
                if i > 0 || path.closed { Some(path.vertices[(i + count - 1) % count]) } else { None };
            let after =
                if i + 1 < count || path.closed { Some(path.vertices[(i + 1) % count]) } else { None };
            [before, after]
        };
        let vertices = self.fans.iter().zip(&self.own).zip(tangents).enumerate();
        self.frames = vertices
            .map(|(i, ((fan, p), (_, along)))| frame(fan, beside(i), *p, along.into(), positions))
            .collect();
    }

    /// The parameter of each vertex on the curve through them.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = f64> + use<> {
        let segments = self.track.path.segments().max(1) as f64;
        (0..self.track.path.vertices.len()).map(move |i| i as f64 / segments)
    }

    /// The point at a place: just a vertex where there is one.
    pub(crate) fn points_at(&self, places: &[Place]) -> Vec<DVec3> {
        let segments = self.track.path.segments().max(1) as f64;
        let u = |place: &Place| (place.segment as f64 + place.x) / segments;
        let between = self.reference.at(places.iter().map(u));
        let exact = |(place, (p, _)): (&Place, ([f64; 3], [f64; 3]))| match self.track.vertex(*place) {
            Some(vertex) => self.own[vertex],
            None => p.into(),
        };
        places.iter().zip(between).map(exact).collect()
    }

    /// The frame at a place.
    pub(crate) fn frame_at(&self, place: Place) -> Frame {
        let count = self.frames.len();
        let [a, b] = [place.segment, place.segment + 1].map(|i| self.frames[i % count]);
        let mix = |a: DVec3, b: DVec3| a.lerp(b, place.x).normalize_or_zero();
        Frame {
            along: mix(a.along, b.along),
            inward: mix(a.inward, b.inward),
            normal: mix(a.normal, b.normal),
        }
    }
}

impl Frame {
    /// The frame after the least rotation that takes its direction to another.
    pub(crate) fn bent(&self, along: DVec3) -> Self {
        if self.along == DVec3::ZERO || along == DVec3::ZERO {
            return *self;
        }
        let turn = DQuat::from_rotation_arc(self.along, along);
        let across = |v: DVec3| (turn * v).reject_from_normalized(along).normalize_or_zero();
        Self { along, inward: across(self.inward), normal: across(self.normal) }
    }
}

/// The vertices of an edge; one that is not finite is taken to be at the origin, as nothing is bound there.
fn vertices(track: &Track, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let at =
        |&vertex: &u32| positions.get(vertex as usize).copied().filter(|p| p.iter().all(|c| c.is_finite()));
    track.path.vertices.iter().map(|vertex| at(vertex).unwrap_or_default()).collect()
}

/// How the surface stands at a vertex `p` with these triangles. Which way leads into it is said by those along the edge alone: where the
/// edge ends in a slit there are others all round.
fn frame(
    fan: &[[u32; 3]],
    beside: [Option<u32>; 2],
    p: DVec3,
    along: DVec3,
    positions: &[[f32; 3]],
) -> Frame {
    let (mut normal, mut middle) = (DVec3::ZERO, DVec3::ZERO);
    for triangle in fan {
        let [a, b, c] = triangle.map(|v| positions.get(v as usize).map_or(p, |q| wide(*q)));
        let area = (b - a).cross(c - a);
        normal += area;
        if beside.iter().flatten().any(|next| triangle.contains(next)) {
            middle += ((a + b + c) / 3.0 - p) * area.length();
        }
    }
    let normal = normal.reject_from_normalized(along).normalize_or_zero();
    let across = normal.cross(along);
    let inward = if across.dot(middle) < 0.0 { -across } else { across };
    Frame { along, inward, normal }
}
