//! Where a surface is compressed most in the course of time, and lines across that: creases that nobody has to draw.
//!
//! At each place the strain `FᵀF − I` of the triangles round it is averaged by area, and its least eigenvalue kept where it is less than
//! ever before, with the direction. Lines are then laid one after the other, each from the place of greatest compression that none is near
//! yet, both ways across the direction of compression, as long as that lasts: evenly spaced streamlines, after Jobard and
//! Lefer, "Creating evenly-spaced streamlines of arbitrary density" (1997).

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;
use wirework_core::{Curve, CurveKind};
use wirework_surface::{NearBuffer, Step, Terrain, Walker};

use crate::ground::wide;
use crate::strain::COLLAPSED;
use crate::{Pattern, SurfaceView, Wrinkle, WrinkleError};

/// Steps of a line in the length of a thickness, and how far it may turn in one, radians: a fold as thick as that cannot turn faster.
const STEPS_A_THICKNESS: f64 = 2.0;
const SHARPEST: f64 = 0.6;
/// How far apart lines are, in parts of the thickness: folds touch.
const SPACING: f64 = 2.0;
/// A line ends where it comes so near to another, in parts of that spacing.
const MEETING: f64 = 0.6;
/// A line shorter than so many thicknesses is none.
const SHORTEST: f64 = 2.0;
/// No line has more steps than this either way: one that runs in rings round a limb ends where it meets itself before.
const MOST_STEPS: usize = 512;

/// The greatest compression of a surface over time.
#[derive(Clone, Debug)]
pub struct Field {
    terrain: Terrain,
    /// For each triangle its rest shape.
    facets: Vec<Option<Facet>>,
    /// For each vertex the greatest compression so far, a part of the length, and its direction.
    peaks: Vec<(f32, [f32; 3])>,
}

/// A triangle at rest.
#[derive(Clone, Copy, Debug)]
struct Facet {
    /// Orthonormal, in its plane.
    axes: [DVec3; 2],
    /// From edges to those axes.
    inverse: DMat2,
    area: f64,
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Option<Self> {
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let x = e.try_normalize()?;
        let normal = e.cross(f).try_normalize()?;
        let y = normal.cross(x);
        let edges = DMat2::from_cols(DVec2::new(e.length(), 0.0), DVec2::new(f.dot(x), f.dot(y)));
        let inverse = edges.inverse();
        inverse.is_finite().then_some(Self { axes: [x, y], inverse, area: e.cross(f).length() / 2.0 })
    }

    /// `FᵀF − I` where its corners have moved; none where they are no numbers, or it has collapsed.
    fn strain(&self, corners: [DVec3; 3]) -> Option<DMat2> {
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let metric = DMat2::from_cols_array(&[e.dot(e), e.dot(f), e.dot(f), f.dot(f)]);
        let strain = self.inverse.transpose() * metric * self.inverse - DMat2::IDENTITY;
        // What is left of the length where it is shortest, squared. NaN is not greater.
        let left = 1.0 - largest(-strain).0;
        (left > f64::from(COLLAPSED * COLLAPSED)).then_some(strain)
    }
}

impl Field {
    /// A surface at rest.
    ///
    /// # Errors
    ///
    /// It has no faces, or vertices that are not there or not finite.
    pub fn new(surface: &SurfaceView<'_>) -> Result<Self, WrinkleError> {
        let terrain = Terrain::new(surface.positions, surface.triangles)?;
        let facet = |triangle| Facet::new(terrain.corners_of(triangle as u32).map(DVec3::from));
        let facets = (0..surface.triangles.len()).into_par_iter().map(facet).collect();
        Ok(Self { terrain, facets, peaks: vec![(0.0, [0.0; 3]); surface.positions.len()] })
    }

    /// Looks at one more moment: where the vertices are. Fewer than there are at rest are not looked at.
    pub fn add(&mut self, now: &[[f32; 3]]) {
        if now.len() < self.peaks.len() {
            return;
        }
        let strain = |(triangle, facet): (usize, &Option<Facet>)| {
            let corners = self.terrain.places_of(triangle as u32).map(|place| wide(now[place as usize]));
            facet.as_ref()?.strain(corners)
        };
        let strains: Vec<Option<DMat2>> = self.facets.par_iter().enumerate().map(strain).collect();
        let (terrain, facets) = (&self.terrain, &self.facets);
        self.peaks.par_iter_mut().enumerate().with_min_len(256).for_each(|(place, peak)| {
            if let Some(found) = compression(terrain, facets, &strains, place as u32)
                && found.0 > peak.0
            {
                *peak = found;
            }
        });
    }

    /// Lines for the creases of a wrinkle, at most as many as it has creases, the most compressed first; none where nothing is compressed by more
    /// than its drive begins at. They are on the surface, one a crease, for [`Pattern::Drawn`].
    pub fn lines(&self, settings: &Wrinkle) -> Vec<Curve> {
        let thickness = settings.thickness.values().copied().fold(f32::INFINITY, f32::min);
        let from = settings.drive.map_or(0.0, |strain| strain.from).max(f32::MIN_POSITIVE);
        let most =
            if let Pattern::Auto { creases } = settings.pattern { creases as usize } else { usize::MAX };
        let mut seeds: Vec<u32> =
            (0..self.peaks.len() as u32).filter(|&i| self.peaks[i as usize].0 > from).collect();
        seeds.sort_by(|&a, &b| self.peaks[b as usize].0.total_cmp(&self.peaks[a as usize].0).then(a.cmp(&b)));
        let mut laying = Laying {
            field: self,
            thickness: f64::from(thickness),
            from: f64::from(from),
            near: vec![false; self.peaks.len()],
            met: vec![false; self.peaks.len()],
            buffer: NearBuffer::default(),
        };
        let mut lines = Vec::new();
        for seed in seeds {
            if lines.len() >= most {
                break;
            }
            if !laying.near[seed as usize] {
                lines.extend(laying.line(seed));
            }
        }
        lines
    }

    /// The compression at a point of the surface, and its direction, of length 1 along the surface.
    fn at(&self, step: &Step, normal: DVec3) -> (f64, DVec3) {
        let (a, b) = normal.any_orthonormal_pair();
        let (mut size, mut dyads) = (0.0, DMat2::ZERO);
        for (place, weight) in self.terrain.places_of(step.triangle).into_iter().zip(step.weights) {
            let (compression, direction) = self.peaks[place as usize];
            let direction = wide(direction);
            let flat = DVec2::new(direction.dot(a), direction.dot(b));
            size += weight * f64::from(compression);
            dyads += DMat2::from_cols(flat * flat.x, flat * flat.y) * (weight * f64::from(compression));
        }
        let (_, axis) = largest(dyads);
        (size, a * axis.x + b * axis.y)
    }
}

/// The compression at a place, and its direction; none without faces whose strain is known.
fn compression(
    terrain: &Terrain,
    facets: &[Option<Facet>],
    strains: &[Option<DMat2>],
    place: u32,
) -> Option<(f32, [f32; 3])> {
    let normal = DVec3::from(terrain.normal_of_vertex(place)?);
    let (a, b) = normal.any_orthonormal_pair();
    let (mut sum, mut area) = (DMat2::ZERO, 0.0);
    for &triangle in terrain.fan(place) {
        let (Some(facet), Some(strain)) = (&facets[triangle as usize], strains[triangle as usize]) else {
            continue;
        };
        // Its axes, seen along the normal of the place.
        let [x, y] = facet.axes.map(|axis| DVec2::new(axis.dot(a), axis.dot(b)));
        let turn = DMat2::from_cols(x, y);
        sum += turn * strain * turn.transpose() * facet.area;
        area += facet.area;
    }
    if area <= 0.0 {
        return None;
    }
    let (least, axis) = largest(sum * (-1.0 / area));
    let compression = 1.0 - (1.0 - least).max(0.0).sqrt();
    compression.is_finite().then(|| (compression as f32, (a * axis.x + b * axis.y).as_vec3().to_array()))
}

/// The largest eigenvalue of a symmetric matrix, and its direction.
fn largest(m: DMat2) -> (f64, DVec2) {
    let (half, off) = ((m.x_axis.x - m.y_axis.y) / 2.0, m.y_axis.x);
    let value = f64::midpoint(m.x_axis.x, m.y_axis.y) + half.hypot(off);
    (value, DVec2::from_angle(off.atan2(half) / 2.0))
}

struct Laying<'a> {
    field: &'a Field,
    thickness: f64,
    from: f64,
    /// Whether a vertex is too near to a line for another to start there, and for one to go on.
    near: Vec<bool>,
    met: Vec<bool>,
    buffer: NearBuffer,
}

impl Laying<'_> {
    /// The line through a vertex; none where it would be too short.
    fn line(&mut self, seed: u32) -> Option<Curve> {
        let terrain = &self.field.terrain;
        let step = terrain.at_vertex(seed)?;
        let normal = DVec3::from(terrain.normal_at(&step)?);
        let (_, across) = self.field.at(&step, normal);
        let walker = terrain.walker_at(&step, normal.cross(across).to_array())?;
        let mut back = walker.clone();
        back.turn(std::f64::consts::PI);
        let mut steps = self.follow(back);
        steps.reverse();
        steps.push(step);
        steps.extend(self.follow(walker));
        let length: f64 = steps
            .windows(2)
            .map(|pair| DVec3::from(pair[0].position).distance(DVec3::from(pair[1].position)))
            .sum();
        // However short it is, no other is to start where it lies.
        self.mark(&steps);
        if length < SHORTEST * self.thickness {
            return None;
        }
        let points = steps.iter().map(|step| step.position.map(|c| c as f32)).collect();
        Curve::new(CurveKind::CatmullRom, false, points).ok()
    }

    /// Walks across the compression as long as that lasts and no other line is met.
    fn follow(&self, mut walker: Walker<'_>) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        let stride = self.thickness / STEPS_A_THICKNESS;
        for _ in 0..MOST_STEPS {
            let (walked, _) = walker.walk(stride, |_, _| {});
            let step = walker.step();
            if walked < stride * 0.5 || self.is_met(&step) {
                break;
            }
            let normal = DVec3::from(walker.normal());
            let (compression, across) = self.field.at(&step, normal);
            if compression < self.from {
                break;
            }
            steps.push(step);
            if walked < stride {
                break;
            }
            let (ahead, left) = (DVec3::from(walker.heading()), normal.cross(DVec3::from(walker.heading())));
            let mut along = normal.cross(across);
            if along.dot(ahead) < 0.0 {
                along = -along;
            }
            walker.turn(along.dot(left).atan2(along.dot(ahead)).clamp(-SHARPEST, SHARPEST));
        }
        steps
    }

    fn is_met(&self, step: &Step) -> bool {
        let corners = self.field.terrain.places_of(step.triangle);
        let heaviest = (0..3).max_by(|&a, &b| step.weights[a].total_cmp(&step.weights[b])).unwrap_or(0);
        self.met[corners[heaviest] as usize]
    }

    fn mark(&mut self, steps: &[Step]) {
        let spacing = SPACING * self.thickness;
        for (radius, marks) in [(spacing, &mut self.near), (spacing * MEETING, &mut self.met)] {
            for vertex in self.field.terrain.near(steps, radius, &mut self.buffer).vertices {
                marks[vertex as usize] = true;
            }
            for corner in steps.iter().flat_map(|step| self.field.terrain.places_of(step.triangle)) {
                marks[corner as usize] = true;
            }
        }
    }
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
