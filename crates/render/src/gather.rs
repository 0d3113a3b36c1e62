//! One record a pixel: the surface that most of it shows, and how open that lies; then smoothing it along the surface.

use glam::Vec3;
use rayon::prelude::*;

use crate::hit::{GROUND, Hit, Stage};
use crate::light::Lamps;
use crate::pattern::{Pattern, cone, cosine};
use crate::raster::{NONE, Seen};
use crate::rays::Rays;
use crate::scene::Part;
use crate::shade::Open;
use crate::space::Space;

/// How far ambient occlusion reaches, in heights of the picture: about the depth of a form, not of the scene.
const REACH: f32 = 0.16;
/// The radius of the key light at distance 1: the softness of its shadow, as a window beside a table has.
const SPREAD: f32 = 0.09;
/// Farther than anything.
const FAR: f32 = 1e7;
/// Least cosine between normals of one surface, from pixel to pixel.
const SAME_NORMAL: f32 = 0.80;
/// How far apart, in pixels seen at their depth, points may lie across the surface and still be of one.
const SAME_PLANE: f32 = 2.5;
/// No owner: the pixel shows the background.
pub(crate) const NOBODY: u32 = u32::MAX - 1;

/// What a pixel shows.
#[derive(Clone, Copy)]
pub(crate) struct Pixel {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) color: Vec3,
    pub(crate) owner: u32,
    pub(crate) open: Open,
    /// Whether all its samples show this: then they need not be looked at one by one.
    pub(crate) whole: bool,
}

const EMPTY: Pixel = Pixel {
    position: Vec3::ZERO,
    normal: Vec3::ZERO,
    color: Vec3::ZERO,
    owner: NOBODY,
    open: Open::FULL,
    whole: true,
};

/// All that rays need.
pub(crate) struct Tracer<'a> {
    pub(crate) rays: &'a Rays,
    /// What there is, if surfaces with holes are among it.
    pub(crate) holes: Option<Stage<'a>>,
    pub(crate) lamps: &'a Lamps,
    pub(crate) space: &'a Space,
    pub(crate) pattern: Pattern,
    /// Rays of each kind a sample.
    pub(crate) rays_per_sample: usize,
}

impl<'a> Tracer<'a> {
    /// Four rays to the sky for each pixel, or one for each sample where that is more.
    pub(crate) fn new(rays: &'a Rays, lamps: &'a Lamps, stage: Stage<'a>) -> Self {
        let samples = stage.samples * stage.samples;
        let rays_per_sample = 4usize.div_ceil(samples);
        let holes = stage.scene.parts.iter().any(Part::has_holes).then_some(stage);
        let pattern = Pattern::new(samples * rays_per_sample);
        Self { rays, holes, lamps, space: stage.space, pattern, rays_per_sample }
    }

    /// How open a sample lies: the mean over its rays.
    pub(crate) fn open(&self, hit: &Hit, pixel: [usize; 2], sample: usize) -> Open {
        Open { sky: self.sky_open(hit, pixel, sample), key: self.key_open(hit, pixel, sample) }
    }

    fn sky_open(&self, hit: &Hit, pixel: [usize; 2], sample: usize) -> f32 {
        let grounded = self.space.ground.is_some() && hit.owner != GROUND;
        if grounded || self.rays.near(hit.origin, REACH) { self.sky(hit, pixel, sample) } else { 1.0 }
    }

    fn key_open(&self, hit: &Hit, pixel: [usize; 2], sample: usize) -> f32 {
        // Light from behind is the shader's to take away: there, rays would only meet the surface itself.
        let facing = hit.normal.dot(self.lamps.key) > -SPREAD;
        let blocked = facing && self.rays.before(hit.origin, self.lamps.key, SPREAD);
        if blocked { self.key(hit, pixel, sample) } else { 1.0 }
    }

    fn sky(&self, hit: &Hit, pixel: [usize; 2], sample: usize) -> f32 {
        let mut free = 0;
        for i in 0..self.rays_per_sample {
            let point = self.pattern.point(pixel, sample * self.rays_per_sample + i);
            let out = cosine(hit.normal, point);
            // What lies near takes more light away: rays reach unequally far.
            let reach = REACH * (0.1 + 0.9 * point[2]);
            // A direction below the triangle itself meets the neighbour of a smooth edge, not an obstacle.
            free += u8::from(out.dot(hit.face) <= 0.0 || self.clear(hit.origin, out, reach));
        }
        f32::from(free) / self.rays_per_sample as f32
    }

    fn key(&self, hit: &Hit, pixel: [usize; 2], sample: usize) -> f32 {
        let mut free = 0;
        for i in 0..self.rays_per_sample {
            let point = self.pattern.point(pixel, sample * self.rays_per_sample + i);
            let toward = cone(self.lamps.key, SPREAD, point);
            free += u8::from(toward.dot(hit.normal) <= 0.0 || self.free(hit.origin, toward, FAR));
        }
        f32::from(free) / self.rays_per_sample as f32
    }

    fn clear(&self, origin: Vec3, direction: Vec3, reach: f32) -> bool {
        let (rise, up) = (direction.dot(self.space.up), self.space.up);
        let grounded = self.space.ground.is_some_and(|g| rise < 0.0 && (g - origin.dot(up)) / rise < reach);
        !grounded && self.free(origin, direction, reach)
    }

    fn free(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        match self.holes {
            None => self.rays.free(origin, direction, distance, |_, _| true),
            Some(stage) => self
                .rays
                .free(origin, direction, distance, |triangle, point| stage.solid_at_point(triangle, point)),
        }
    }
}

/// Whether a point with a normal lies on the surface that a pixel shows.
pub(crate) fn same(pixel: &Pixel, owner: u32, position: Vec3, normal: Vec3, footprint: f32) -> bool {
    pixel.owner == owner
        && pixel.normal.dot(normal) > SAME_NORMAL
        && (pixel.position - position).dot(pixel.normal).abs() < SAME_PLANE * footprint * -pixel.position.z
}

/// The records of all pixels. Without a tracer everything lies open.
pub(crate) fn gather(stage: Stage<'_>, seen: &[Seen], tracer: Option<&Tracer<'_>>) -> Vec<Pixel> {
    let samples = stage.samples;
    let [width, height] = stage.space.size;
    let columns = width / samples;
    let mut pixels = vec![EMPTY; columns * (height / samples)];
    pixels.par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
        let mut hits: Vec<(usize, Hit)> = Vec::with_capacity(samples * samples);
        for (x, pixel) in row.iter_mut().enumerate() {
            hits.clear();
            let middle = [x, y].map(|i| (i * samples) as f32 + samples as f32 * 0.5);
            for i in 0..samples * samples {
                let seen = seen[(y * samples + i / samples) * width + x * samples + i % samples];
                if seen.triangle == NONE && tracer.is_none() {
                    continue;
                }
                // Samples of one triangle share a point of it.
                let hit = match hits.last() {
                    Some(&(_, last)) if last.triangle == seen.triangle => Some(last),
                    _ => stage.hit(seen, middle),
                };
                hits.extend(hit.map(|hit| (i, hit)));
            }
            *pixel = merge(stage, &hits, [x, y], tracer);
        }
    });
    pixels
}

/// The nearest surface among a pixel's samples, with the means of those that see it.
fn merge(stage: Stage<'_>, hits: &[(usize, Hit)], at: [usize; 2], tracer: Option<&Tracer<'_>>) -> Pixel {
    let nearest = hits.iter().max_by(|a, b| a.1.position.z.total_cmp(&b.1.position.z));
    let Some((_, first)) = nearest else { return EMPTY };
    let samples = stage.samples;
    let footprint = samples as f32 / stage.space.focal;
    let Hit { position, normal, owner, .. } = *first;
    let near = Pixel { position, normal, owner, color: stage.color(first), open: Open::FULL, whole: false };
    let mut sum =
        Pixel { position: Vec3::ZERO, normal: Vec3::ZERO, color: Vec3::ZERO, open: Open::default(), ..near };
    let (mut count, mut last) = (0, Open::FULL);
    for (i, hit) in hits {
        if same(&near, hit.owner, hit.position, hit.normal, footprint) {
            // A shadow's rays differ less than those to the sky: every other sample shares those of the one before.
            let open = match tracer {
                None => Open::FULL,
                Some(t) if count % 2 == 1 => Open { sky: t.sky_open(hit, at, *i), ..last },
                Some(t) => t.open(hit, at, *i),
            };
            last = open;
            sum.position += hit.position;
            sum.normal += hit.normal;
            sum.color += stage.color(hit);
            sum.open = Open { sky: sum.open.sky + open.sky, key: sum.open.key + open.key };
            count += 1;
        }
    }
    // The nearest is the same as itself, unless it lies edge on: then it stands alone.
    if count == 0 {
        return near;
    }
    let share = 1.0 / count as f32;
    Pixel {
        position: sum.position * share,
        normal: sum.normal.normalize_or(near.normal),
        color: sum.color * share,
        owner,
        open: Open { sky: sum.open.sky * share, key: sum.open.key * share },
        whole: count == samples * samples,
    }
}

/// Weights of a blur that is exactly even over patterns that repeat every four pixels: a box of four, centred by halves.
const KERNEL: [f32; 5] = [0.125, 0.25, 0.25, 0.25, 0.125];

/// Smooths openness along each surface, across and then down, twice: first over the pattern of rays, then with wider
/// steps over what jitter is left. (A second pass that kept the edges of shadows cut wide penumbrae into steps.)
pub(crate) fn smooth(pixels: &mut [Pixel], columns: usize, footprint: f32) {
    let rows = pixels.len() / columns;
    let mut open = Vec::new();
    for (step, down) in [(1, false), (1, true), (2, false), (2, true)] {
        let source: &[Pixel] = pixels;
        (0..pixels.len())
            .into_par_iter()
            .with_min_len(columns)
            .map(|i| {
                let (x, y) = (i % columns, i / columns);
                let (at, limit, stride) = if down { (y, rows, columns) } else { (x, columns, 1) };
                blend(source, i, [at, limit, stride], step, footprint * step as f32)
            })
            .collect_into_vec(&mut open);
        pixels.iter_mut().zip(&open).for_each(|(pixel, open)| pixel.open = *open);
    }
}

/// The weighted mean over those of the pixels round `i` on its surface: in its row or column, where it is number `at` of
/// `limit` with `stride` to the next, `step` apart.
fn blend(pixels: &[Pixel], i: usize, [at, limit, stride]: [usize; 3], step: usize, footprint: f32) -> Open {
    let center = &pixels[i];
    if center.owner == NOBODY {
        return Open::FULL;
    }
    let (mut sum, mut total) = (Open::default(), 0.0);
    for (tap, kernel) in KERNEL.into_iter().enumerate() {
        let Some(place) = (at + tap * step).checked_sub(2 * step).filter(|&p| p < limit) else { continue };
        let other = &pixels[i + place * stride - at * stride];
        let weight = if place == at {
            kernel
        } else if same(center, other.owner, other.position, other.normal, footprint) {
            kernel * center.normal.dot(other.normal).max(0.0).powi(4)
        } else {
            continue;
        };
        sum = Open { sky: sum.sky + other.open.sky * weight, key: sum.key + other.open.key * weight };
        total += weight;
    }
    Open { sky: sum.sky / total, key: sum.key / total }
}

/// A fold of this radius, in heights of the picture, is halfway to the darkest or lightest.
const FOLD: f32 = 0.022;
/// Rows of a picture for which the neighbours a pixel is compared with are the next ones but one.
const CAVITY_ROWS: f32 = 320.0;

/// How a pixel's surroundings bend: −1 a deep valley, 0 flat, 1 a sharp ridge, from the normals two steps away on
/// either side.
pub(crate) fn cavity(pixels: &[Pixel], columns: usize, x: usize, y: usize) -> f32 {
    let rows = pixels.len() / columns;
    let center = &pixels[y * columns + x];
    if center.owner >= NOBODY {
        return 0.0;
    }
    let far = (2.0 * rows as f32 / CAVITY_ROWS).round().max(1.0) as usize;
    let bend = |step: usize| {
        let get = |place: Option<usize>, stride: usize, limit: usize, base: usize| {
            let place = place.filter(|&p| p < limit)?;
            let pixel = &pixels[base + place * stride];
            (pixel.owner == center.owner).then_some(pixel)
        };
        let along = |before: Option<&Pixel>, after: Option<&Pixel>| {
            let (a, b) = (before.unwrap_or(center), after.unwrap_or(center));
            let way = b.position - a.position;
            // Across an edge of depth there is no surface to bend.
            let limit = 8.0 * step as f32 / rows as f32 * -center.position.z;
            if way.length_squared() > 0.0 && way.length() < limit {
                (b.normal - a.normal).dot(way) / way.length_squared()
            } else {
                0.0
            }
        };
        let across = along(
            get(x.checked_sub(step), 1, columns, y * columns),
            get(x.checked_add(step), 1, columns, y * columns),
        );
        let down =
            along(get(y.checked_sub(step), columns, rows, x), get(y.checked_add(step), columns, rows, x));
        across + down
    };
    let bent = (bend(far) + bend(far.div_ceil(2))) * 0.5 * FOLD;
    bent / (1.0 + bent.abs())
}
