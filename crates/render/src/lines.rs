//! Polylines and discs over the picture, tested against the depths of its samples.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::RenderError;
use crate::raster::{NEAR, Seen};
use crate::scene::Scene;
use crate::space::Space;

/// Rows of a band: pieces of lines are sorted into bands, so that a row does not look at all of them.
const BAND: usize = 16;

/// How much of a line is left where a surface hides it.
const HIDDEN: f32 = 0.38;
/// Lines lie this much nearer than they are, in heights of the picture at the target: most lie in the very surface they
/// move. More would let lines shine through folds.
const BIAS: f32 = 0.008;
/// Width of the darker rim that sets a line off from what is behind it, pixels, how dense it is, and how much of the
/// line's colour it has.
const RIM: f32 = 1.2;
pub(crate) const RIM_DENSITY: f32 = 0.45;
pub(crate) const RIM_SHADE: f32 = 0.12;
/// Wider lines are drawn this wide, pixels.
const MAX_WIDTH: f32 = 256.0;

/// A piece of a line on the screen, in pixels: two ends with the inverses of their depths.
struct Capsule {
    from: Vec2,
    to: Vec2,
    nearness: [f32; 2],
}

/// Capsules of one colour that are blended as one.
struct Stroke {
    capsules: Vec<Capsule>,
    color: Vec3,
    radius: f32,
}

/// Draws all lines and dots over linear `colors`, in the scene's order.
pub(crate) fn draw(
    scene: &Scene,
    space: &Space,
    samples: usize,
    seen: &[Seen],
    colors: &mut [Vec3],
) -> Result<(), RenderError> {
    let strokes = strokes(scene, space, samples)?;
    if strokes.is_empty() {
        return Ok(());
    }
    let columns = space.size[0] / samples;
    let bands = bands(&strokes, space.size[1] / samples);
    colors.par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
        let Some(band) = bands.get(y / BAND).filter(|band| !band.is_empty()) else { return };
        // For each pixel: covered by the core, of it seen; covered by core and rim, of it seen.
        let mut cover = vec![[0.0_f32; 4]; columns];
        for pieces in band.chunk_by(|a, b| a.0 == b.0) {
            let Some(stroke) = pieces.first().and_then(|&(stroke, _)| strokes.get(stroke as usize)) else {
                continue;
            };
            let capsules = pieces.iter().filter_map(|&(_, capsule)| stroke.capsules.get(capsule as usize));
            let Some((first, last)) = stroke.row(capsules, y, &mut cover, space.size[0], samples, seen)
            else {
                continue;
            };
            for (x, c) in cover.iter_mut().enumerate().take(last + 1).skip(first) {
                let dimmed = |all: f32, seen: f32| seen + (all - seen).max(0.0) * HIDDEN;
                let (core, whole) = (dimmed(c[0], c[1]), dimmed(c[2], c[3]));
                let rim = (whole - core).max(0.0) * RIM_DENSITY;
                row[x] = row[x].lerp(stroke.color * RIM_SHADE, rim).lerp(stroke.color, core);
                *c = [0.0; 4];
            }
        }
    });
    Ok(())
}

/// Which pieces may touch the rows of each band: numbers of strokes and of their capsules, in their order.
fn bands(strokes: &[Stroke], rows: usize) -> Vec<Vec<(u32, u32)>> {
    let mut bands = vec![Vec::new(); rows.div_ceil(BAND)];
    for (stroke, number) in strokes.iter().zip(0..) {
        let outer = stroke.outer();
        for (capsule, piece) in stroke.capsules.iter().zip(0..) {
            let (low, high) =
                (capsule.from.y.min(capsule.to.y) - outer, capsule.from.y.max(capsule.to.y) + outer);
            // Floats beyond the range of whole numbers end at its ends; NaN at 0.
            let first = low.max(0.0) as usize / BAND;
            let last = (high.max(0.0) as usize / BAND).min(bands.len().saturating_sub(1));
            if high >= 0.0 {
                for band in bands.iter_mut().take(last + 1).skip(first) {
                    band.push((number, piece));
                }
            }
        }
    }
    bands
}

fn strokes(scene: &Scene, space: &Space, samples: usize) -> Result<Vec<Stroke>, RenderError> {
    let mut strokes = Vec::new();
    let mut points = Vec::new();
    let radius = |width: f32| (width * 0.5).clamp(0.0, MAX_WIDTH * 0.5);
    for (number, line) in scene.lines.iter().enumerate() {
        points.clear();
        space.points("line", number, &line.points, &mut points)?;
        let single = [points.first().copied(), points.first().copied()];
        let pairs = points.windows(2).map(|w| [w[0], w[1]]);
        let alone =
            single.into_iter().flatten().take(if points.len() == 1 { 2 } else { 0 }).collect::<Vec<_>>();
        let ends = pairs.chain(alone.chunks_exact(2).map(|w| [w[0], w[1]]));
        let capsules = ends.filter_map(|e| capsule(e, space, samples)).collect();
        strokes.push(Stroke { capsules, color: line.color.into(), radius: radius(line.width) });
    }
    for (number, dots) in scene.dots.iter().enumerate() {
        points.clear();
        space.points("dots", number, &dots.points, &mut points)?;
        // From far to near, each over the ones before; of equally far ones in their order.
        points.sort_by(|a, b| a.z.total_cmp(&b.z));
        strokes.extend(points.iter().map(|&p| Stroke {
            capsules: capsule([p, p], space, samples).into_iter().collect(),
            color: dots.color.into(),
            radius: radius(dots.width),
        }));
    }
    strokes.retain(|s| !s.capsules.is_empty() && s.radius > 0.0);
    Ok(strokes)
}

/// The part of a piece that is in front of the camera, on the screen.
fn capsule([mut a, mut b]: [Vec3; 2], space: &Space, samples: usize) -> Option<Capsule> {
    if a.z > -NEAR && b.z > -NEAR {
        return None;
    }
    if a.z > -NEAR {
        a = b + (a - b) * ((b.z + NEAR) / (b.z - a.z));
    } else if b.z > -NEAR {
        b = a + (b - a) * ((a.z + NEAR) / (a.z - b.z));
    }
    let at = |p: Vec3| Vec2::from(space.project(p.with_z(p.z.min(-NEAR * 0.5)))) / samples as f32;
    let nearness = [a, b].map(|p| 1.0 / p.z.min(-NEAR * 0.5).abs());
    Some(Capsule { from: at(a), to: at(b), nearness })
}

impl Stroke {
    /// How far from the middle of a piece a pixel may be touched.
    fn outer(&self) -> f32 {
        self.radius + RIM + 0.5
    }

    /// Adds what the stroke covers of row `y`; the first and last pixel it touches.
    fn row<'c>(
        &self,
        capsules: impl Iterator<Item = &'c Capsule>,
        y: usize,
        cover: &mut [[f32; 4]],
        width: usize,
        samples: usize,
        seen: &[Seen],
    ) -> Option<(usize, usize)> {
        let middle = y as f32 + 0.5;
        let outer = self.outer();
        let mut touched: Option<(usize, usize)> = None;
        for capsule in capsules {
            let (low, high) = (capsule.from.y.min(capsule.to.y), capsule.from.y.max(capsule.to.y));
            if middle < low - outer || middle > high + outer {
                continue;
            }
            let Some((left, right)) = capsule.span(middle, outer, cover.len()) else { continue };
            for (x, c) in cover.iter_mut().enumerate().take(right + 1).skip(left) {
                let (distance, nearness) = capsule.nearest(Vec2::new(x as f32 + 0.5, middle));
                let core = (self.radius + 0.5 - distance).clamp(0.0, 1.0) * (self.radius * 2.0).min(1.0);
                let whole = (self.radius + RIM + 0.5 - distance).clamp(0.0, 1.0);
                if whole > 0.0 {
                    let free = visible([x, y], nearness, width, samples, seen);
                    *c = [c[0].max(core), c[1].max(core * free), c[2].max(whole), c[3].max(whole * free)];
                }
            }
            touched = Some(touched.map_or((left, right), |(l, r)| (l.min(left), r.max(right))));
        }
        touched
    }
}

impl Capsule {
    /// The pixels of a row that may be within `outer` of the piece.
    fn span(&self, y: f32, outer: f32, columns: usize) -> Option<(usize, usize)> {
        // The part of the piece within `outer` above and below the row.
        let way = self.to - self.from;
        let mut range = [0.0_f32, 1.0];
        if way.y.abs() > 1e-6 {
            let ends = [y - outer, y + outer].map(|edge| ((edge - self.from.y) / way.y).clamp(0.0, 1.0));
            range = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        }
        let xs = range.map(|t| self.from.x + way.x * t);
        let (left, right) = ((xs[0].min(xs[1]) - outer).floor(), (xs[0].max(xs[1]) + outer).ceil());
        if right < 0.0 || left >= columns as f32 {
            return None;
        }
        Some((left.max(0.0) as usize, (right as usize).min(columns - 1)))
    }

    /// Distance from a pixel to the piece, and how near that point of the piece is to the camera.
    fn nearest(&self, p: Vec2) -> (f32, f32) {
        let way = self.to - self.from;
        let length = way.length_squared();
        let t = if length > 0.0 { ((p - self.from).dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
        (p.distance(self.from + way * t), self.nearness[0] + (self.nearness[1] - self.nearness[0]) * t)
    }
}

/// The share of a pixel's samples before which a line is.
fn visible([x, y]: [usize; 2], nearness: f32, width: usize, samples: usize, seen: &[Seen]) -> f32 {
    let nearness = 1.0 / (1.0 / nearness - BIAS).max(NEAR);
    let mut free = 0;
    for row in 0..samples {
        let start = (y * samples + row) * width + x * samples;
        free += seen[start..start + samples].iter().filter(|s| s.nearness <= nearness).count();
    }
    free as f32 / (samples * samples) as f32
}
