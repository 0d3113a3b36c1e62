//! Which triangle each sample sees.
//!
//! Triangles are clipped to what is in front of the camera, snapped to 1/256 of a sample, sorted into bands of rows,
//! and each band is filled by one thread, triangle after triangle in the order of the scene. Edge functions on
//! integers are exact, so a sample on an edge belongs to one of the two triangles and never to none or both; a
//! nearer triangle wins, of equally near ones the first.

use glam::Vec3;
use rayon::prelude::*;

use crate::hit::Stage;
use crate::scene::Part;
use crate::space::{Geometry, Space};

/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;
/// The nearest depth that is seen, in heights of the picture at the target: close enough to walk into an object.
pub(crate) const NEAR: f32 = 1e-3;
/// Snapped positions a sample.
const SUBPIXEL: f64 = 256.0;
/// Triangles are cut this many samples beside the picture: further out, products of snapped positions would overflow
/// 64 bits; nearer, every large triangle would be cut.
const GUARD: f32 = 2_000_000.0;
/// Rows of samples a thread fills at once.
const BAND: usize = 32;
/// Triangles set up at once.
const CHUNK: usize = 4096;

/// What one sample sees.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    /// The inverse of the depth; 0 for nothing.
    pub(crate) nearness: f32,
    /// The triangle, or [`NONE`].
    pub(crate) triangle: u32,
}

impl Seen {
    pub(crate) const NOTHING: Self = Self { nearness: 0.0, triangle: NONE };
}

/// A triangle on the screen, counter-clockwise in snapped positions with y down, with area.
struct Flat {
    corners: [[i64; 2]; 3],
    nearness: [f32; 3],
    /// The samples its box touches: first and last column, first and last row.
    columns: [usize; 2],
    rows: [usize; 2],
    triangle: u32,
    /// Whether there may be holes in it.
    holes: bool,
}

/// What every sample sees, row by row.
pub(crate) fn rasterize(stage: Stage<'_>, seen: &mut Vec<Seen>) {
    let Stage { scene, geometry, space, .. } = stage;
    let [width, height] = space.size;
    let holes = scene.parts.iter().any(Part::has_holes);
    let flats: Vec<Vec<Flat>> = geometry
        .triangles
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, triangles)| {
            let mut flats = Vec::with_capacity(triangles.len());
            for i in 0..triangles.len() {
                flatten(geometry, space, (chunk * CHUNK + i) as u32, &mut flats);
            }
            for flat in flats.iter_mut().filter(|_| holes) {
                flat.holes = scene.parts.get(geometry.part(flat.triangle)).is_some_and(Part::has_holes);
            }
            flats
        })
        .collect();
    let mut bands: Vec<Vec<&Flat>> = vec![Vec::new(); height.div_ceil(BAND)];
    for flat in flats.iter().flatten() {
        for band in &mut bands[flat.rows[0] / BAND..=flat.rows[1] / BAND] {
            band.push(flat);
        }
    }
    seen.clear();
    seen.resize(width * height, Seen::NOTHING);
    seen.par_chunks_mut(width * BAND).zip(&bands).enumerate().for_each(|(i, (samples, band))| {
        for flat in band {
            fill(flat, stage, i * BAND, samples);
        }
    });
}

/// Adds a triangle's visible pieces as they lie on the screen.
fn flatten(geometry: &Geometry, space: &Space, triangle: u32, out: &mut Vec<Flat>) {
    let corners = geometry.corners(triangle);
    let reach = GUARD / space.focal;
    let inside = |p: &Vec3| -p.z >= NEAR && p.x.abs().max(p.y.abs()) <= -p.z * reach;
    if corners.iter().all(inside) {
        out.extend(snap(corners, space, triangle));
        return;
    }
    let mut polygon = corners.to_vec();
    // Signed distances to the planes of the cut, of any scale.
    let planes: [&dyn Fn(Vec3) -> f32; 5] =
        [&|p| -p.z - NEAR, &|p| -p.z * reach - p.x, &|p| -p.z * reach + p.x, &|p| -p.z * reach - p.y, &|p| {
            -p.z * reach + p.y
        }];
    for plane in planes {
        polygon = cut(&polygon, plane);
    }
    for i in 2..polygon.len() {
        out.extend(snap([polygon[0], polygon[i - 1], polygon[i]], space, triangle));
    }
}

/// The part of a convex polygon where `plane` is not negative.
fn cut(polygon: &[Vec3], plane: &dyn Fn(Vec3) -> f32) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (da, db) = (plane(a), plane(b));
        if da >= 0.0 {
            kept.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            // From the inside outwards, whichever way the edge runs, so that both its triangles get the same point.
            let (p, q, dp, dq) = if da >= 0.0 { (a, b, da, db) } else { (b, a, db, da) };
            kept.push(p + (q - p) * (dp / (dp - dq)));
        }
    }
    kept
}

/// A triangle on the screen, unless it covers no sample.
fn snap(corners: [Vec3; 3], space: &Space, triangle: u32) -> Option<Flat> {
    let mut at = corners.map(|p| {
        // The cut leaves depths a rounding below the limit.
        let p = Vec3::new(p.x, p.y, p.z.min(-NEAR * 0.5));
        space.project(p).map(|c| (f64::from(c) * SUBPIXEL).round() as i64)
    });
    let mut nearness = corners.map(|p| 1.0 / p.z.min(-NEAR * 0.5).abs());
    let area = cross(at[0], at[1], at[2]);
    if area == 0 {
        return None;
    }
    if area < 0 {
        at.swap(1, 2);
        nearness.swap(1, 2);
    }
    let range = |axis: usize| {
        let (low, high) = at.iter().fold((i64::MAX, i64::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        // The centres of samples are at 128 + 256 i.
        let (first, last) = ((low + 127).div_euclid(256).max(0), (high - 128).div_euclid(256));
        let last = last.min(whole(space.size[axis]) - 1);
        (first <= last).then_some([first as usize, last as usize])
    };
    Some(Flat { corners: at, nearness, columns: range(0)?, rows: range(1)?, triangle, holes: false })
}

/// A row or column, which [`MAX_SIDE`](crate::MAX_SIDE) keeps small.
fn whole(i: usize) -> i64 {
    i64::from(i as u32)
}

/// Twice the signed area of a, b, p.
fn cross(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Fills the rows of one band; the first is row `top` of the picture.
fn fill(flat: &Flat, stage: Stage<'_>, top: usize, samples: &mut [Seen]) {
    let width = stage.space.size[0];
    let [a, b, c] = flat.corners;
    let center = |i: usize| whole(i) * 256 + 128;
    // Edge functions, 0 or more inside; an edge that runs down, or level to the right, has its own samples.
    let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let owns = dy > 0 || (dy == 0 && dx > 0);
        let at = |column, row| cross(p, q, [center(column), center(row)]) - i64::from(!owns);
        (at(flat.columns[0], 0), -dy * 256, dx * 256)
    });
    // Nearness is linear on the screen. A sliver's slope may be absurd: it stays between its corners'.
    let area = cross(a, b, c) as f64;
    let [n0, n1, n2] = flat.nearness;
    let (low, high) = (n0.min(n1).min(n2), n0.max(n1).max(n2));
    let (d1, d2) = (f64::from(n1 - n0), f64::from(n2 - n0));
    let slope_x = (d1 * (c[1] - a[1]) as f64 - d2 * (b[1] - a[1]) as f64) / area;
    let slope_y = (d2 * (b[0] - a[0]) as f64 - d1 * (c[0] - a[0]) as f64) / area;
    let step = (slope_x * SUBPIXEL) as f32;
    let last = flat.rows[1].min(top + samples.len() / width - 1);
    for row in flat.rows[0].max(top)..=last {
        let mut values = edges.map(|(start, _, down)| start + down * whole(row));
        let dx = (center(flat.columns[0]) - a[0]) as f64;
        let dy = (center(row) - a[1]) as f64;
        let start = (f64::from(n0) + slope_x * dx + slope_y * dy) as f32;
        let line = &mut samples[(row - top) * width..][flat.columns[0]..=flat.columns[1]];
        let mut entered = false;
        for (i, seen) in line.iter_mut().enumerate() {
            if values[0] | values[1] | values[2] >= 0 {
                entered = true;
                let nearness = (start + step * i as f32).clamp(low, high);
                let at = || [flat.columns[0] + i, row].map(|c| c as f32 + 0.5);
                if nearness > seen.nearness && (!flat.holes || stage.solid_at_sample(flat.triangle, at())) {
                    *seen = Seen { nearness, triangle: flat.triangle };
                }
            } else if entered {
                break;
            }
            for (value, (_, right, _)) in values.iter_mut().zip(&edges) {
                *value += right;
            }
        }
    }
}
