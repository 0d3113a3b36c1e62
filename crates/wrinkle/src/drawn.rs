//! Curves dropped onto a surface by nearest point.

use glam::DVec3;
use wirework_core::Curve;
use wirework_surface::{Nearest, NearestError, smooth_normals};

use crate::random::{Jitter, unit};
use crate::{SurfaceView, Wrinkle, WrinkleError};

/// Samples of a drawn curve: at least so many, for its shape, and at most, for the time it takes.
const SAMPLES: std::ops::RangeInclusive<usize> = 65..=4097;
/// Samples in the length of a thickness: what happens between two of them is small against the crease.
const SAMPLES_A_THICKNESS: f32 = 4.0;
/// A curve whose trace on the surface is shorter than this part of it has collapsed.
const COLLAPSED: f64 = 1e-3;
/// Two neighbouring samples this many times farther apart than they were drawn have jumped over a part of the surface.
const JUMP: f64 = 4.0;
/// How often a jump is halved, a point of the surface put between.
const HALVINGS: u32 = 5;

/// A surface ready to receive curves.
pub(crate) struct Ground {
    nearest: Nearest,
    normals: Vec<[f32; 3]>,
}

/// A point of the surface and the outward direction there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footing {
    pub(crate) position: DVec3,
    /// Of length 1.
    pub(crate) normal: DVec3,
    /// Where that is on the surface, however it moves.
    pub(crate) anchor: Anchor,
}

/// A point of a surface by its material: a triangle, and the weights of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    triangle: u32,
    weights: [f32; 3],
}

/// Interpolated normals shorter than this have cancelled, and the face's own stands in for them.
const CANCELLED: f64 = 1e-3;

impl Anchor {
    /// The corner that is not there or not finite, if there is one.
    pub(crate) fn check(&self, surface: &SurfaceView<'_>) -> Result<(), NearestError> {
        let triangle = self.triangle as usize;
        let corners = surface.triangles.get(triangle).ok_or(NearestError::NoFaces)?;
        let good =
            |v: &&u32| surface.positions.get(**v as usize).is_some_and(|p| p.iter().all(|c| c.is_finite()));
        match corners.iter().find(|v| !good(v)) {
            Some(&vertex) => Err(NearestError::Vertex { triangle, vertex }),
            None => Ok(()),
        }
    }

    /// Where it is on a surface of the same triangles; `normals` are those of its vertices. `None` where the surface
    /// has no normal.
    pub(crate) fn footing(&self, surface: &SurfaceView<'_>, normals: &[[f32; 3]]) -> Option<Footing> {
        let corners = *surface.triangles.get(self.triangle as usize)?;
        // Rounded to f32 the weights add up to 1 only nearly, which far from the origin would be seen.
        let weights = self.weights.map(f64::from);
        let sum: f64 = weights.iter().sum();
        let blend = |values: &[[f32; 3]]| {
            let mut blended = DVec3::ZERO;
            for (&v, weight) in corners.iter().zip(weights) {
                blended += wide(*values.get(v as usize)?) * (weight / sum);
            }
            Some(blended)
        };
        let (position, mut normal) = (blend(surface.positions)?, blend(normals)?);
        if normal.length() <= CANCELLED {
            let corner = |i: usize| surface.positions.get(corners[i] as usize).copied().map(wide);
            let (a, b, c) = (corner(0)?, corner(1)?, corner(2)?);
            normal = (b - a).cross(c - a);
        }
        Some(Footing { position, normal: normal.try_normalize()?, anchor: *self })
    }
}

impl Ground {
    pub(crate) fn new(surface: &SurfaceView<'_>) -> Result<Self, WrinkleError> {
        let nearest = Nearest::new(surface.positions, surface.triangles)?;
        Ok(Self { nearest, normals: smooth_normals(surface.positions, surface.triangles) })
    }

    /// The nearest point of the surface; `None` only where it has no normal or `p` is out of range.
    pub(crate) fn footing(&self, p: DVec3) -> Option<Footing> {
        let hit = self.nearest.nearest(p.as_vec3().to_array())?;
        let normal = self.nearest.interpolated_normal(&hit, &self.normals)?;
        let anchor = Anchor { triangle: hit.triangle, weights: hit.barycentric };
        Some(Footing { position: wide(hit.position), normal: wide(normal), anchor })
    }

    /// How far a point is from the surface.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        let hit = self.nearest.nearest(p.as_vec3().to_array());
        hit.map_or(f64::INFINITY, |hit| f64::from(hit.distance))
    }

    fn position(&self, p: DVec3) -> DVec3 {
        self.nearest.nearest(p.as_vec3().to_array()).map_or(p, |hit| wide(hit.position))
    }
}

pub(crate) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// The trace of a curve: a fine polyline on the surface, with its arc length.
pub(crate) struct Trace {
    points: Vec<DVec3>,
    /// Arc length up to each point.
    lengths: Vec<f64>,
    /// What is used of it, as lengths.
    from: f64,
    to: f64,
}

impl Trace {
    /// Drops curve number `index` onto the surface, jittered as the settings say.
    pub(crate) fn drop(
        ground: &Ground,
        curve: &Curve,
        index: usize,
        settings: &Wrinkle,
        thickness: f32,
    ) -> Result<Self, WrinkleError> {
        let length = curve.length();
        let wanted = (length / thickness * SAMPLES_A_THICKNESS) as usize;
        let mut drawn: Vec<DVec3> =
            curve.spread(wanted.clamp(*SAMPLES.start(), *SAMPLES.end())).into_iter().map(wide).collect();
        let distance = drawn.iter().map(|&p| ground.distance(p)).fold(f64::INFINITY, f64::min);
        if length <= 0.0 {
            return Err(WrinkleError::Collapsed { curve: index });
        }
        if distance > f64::from(length) {
            return Err(WrinkleError::TooFar { curve: index, distance: distance as f32, length });
        }
        if curve.closed() {
            drawn.push(drawn[0]);
        }
        let step = f64::from(length) / (drawn.len() - 1) as f64;
        let mut points: Vec<DVec3> = drawn.iter().map(|&p| ground.position(p)).collect();
        let shift = f64::from(settings.randomness)
            * f64::from(thickness)
            * (2.0 * unit(settings.seed, index, Jitter::Sideways) - 1.0);
        if shift != 0.0 {
            points = sideways(ground, &points, shift, curve.closed());
        }
        let mut trace = Self::along(ground, &points, step * JUMP);
        if trace.to <= COLLAPSED * f64::from(length) {
            return Err(WrinkleError::Collapsed { curve: index });
        }
        if !curve.closed() {
            let trim = |what| f64::from(settings.randomness) * 0.25 * unit(settings.seed, index, what);
            trace.from = trim(Jitter::Start) * trace.to;
            trace.to -= trim(Jitter::End) * trace.to;
        }
        Ok(trace)
    }

    fn along(ground: &Ground, points: &[DVec3], jump: f64) -> Self {
        let mut trace = Self { points: points[..1].to_vec(), lengths: vec![0.0], from: 0.0, to: 0.0 };
        for &point in &points[1..] {
            trace.extend(ground, point, jump, HALVINGS);
        }
        trace
    }

    /// Goes on to `point`, over the surface rather than through the air where it is far.
    fn extend(&mut self, ground: &Ground, point: DVec3, jump: f64, halvings: u32) {
        let Some(&last) = self.points.last() else { return };
        let way = last.distance(point);
        if way > jump && halvings > 0 {
            self.extend(ground, ground.position((last + point) * 0.5), jump, halvings - 1);
            self.extend(ground, point, jump, halvings - 1);
        } else if way > 0.0 {
            self.to += way;
            self.points.push(point);
            self.lengths.push(self.to);
        }
    }

    /// Its length, what was trimmed left out.
    pub(crate) fn length(&self) -> f64 {
        self.to - self.from
    }

    /// The point of the surface at a fraction `0 ..= 1` of the length.
    pub(crate) fn footing(&self, ground: &Ground, fraction: f64) -> Option<Footing> {
        let s = self.from + (self.to - self.from) * fraction;
        let next = self.lengths.partition_point(|&l| l <= s).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[next - 1], self.lengths[next]);
        let x = ((s - a) / (b - a)).clamp(0.0, 1.0);
        ground.footing(self.points[next - 1].lerp(self.points[next], x))
    }
}

/// The points moved across their line by `shift` and dropped again.
fn sideways(ground: &Ground, points: &[DVec3], shift: f64, closed: bool) -> Vec<DVec3> {
    let last = points.len() - 1;
    let moved = |i: usize| {
        // The last point of a closed line is its first.
        let i = if closed && i == last { 0 } else { i };
        let before = if closed && i == 0 { points[last - 1] } else { points[i.saturating_sub(1)] };
        let along = points[(i + 1).min(last)] - before;
        let normal = ground.footing(points[i]).map_or(DVec3::ZERO, |f| f.normal);
        ground.position(points[i] + normal.cross(along).normalize_or_zero() * shift)
    };
    (0..points.len()).map(moved).collect()
}
