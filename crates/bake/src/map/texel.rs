//! From samples to texels.

use glam::DVec3;
use rayon::prelude::*;

use super::frame::{Frame, double_area, weights, wide};
use super::raster::{Flat, Gone, NONE, Owner, Samples, fill};
use super::{Facts, Maps, Settings, Surface};

/// Rows of texels that a thread fills at once.
const BAND: usize = 16;

/// Maps, and which of their texels are covered.
pub(super) struct Bare {
    pub(super) maps: Maps,
    pub(super) covered: Vec<bool>,
}

/// What all bands look at.
struct Ground<'a> {
    surface: &'a Surface,
    frames: Vec<Option<Frame>>,
    flats: Vec<Flat>,
    samples: Samples,
    /// Samples along a side of a texel.
    each: usize,
    width: usize,
}

/// The texels of a band.
struct Slots<'a> {
    normals: &'a mut [[f32; 3]],
    heights: &'a mut [f32],
    covered: &'a mut [bool],
    shares: &'a mut [f32],
}

/// Maps without padding.
pub(super) fn maps(surface: &Surface, settings: &Settings) -> Bare {
    let [width, height] = settings.size.map(|side| side as usize);
    let each = settings.samples as usize;
    let samples = settings.size.map(|side| i64::from(side) * i64::from(settings.samples));
    let frames: Vec<Option<Frame>> = surface.faces.par_iter().map(Frame::new).collect();
    let mut facts = Facts { samples: samples[0] as u64 * samples[1] as u64, ..Facts::default() };
    facts.degenerate = frames.iter().filter(|frame| frame.is_none()).count();
    let flats = flats(surface, &frames, samples, &mut facts);
    let ground = Ground { surface, frames, flats, samples, each, width };
    let bands = ground.bands(height.div_ceil(BAND));
    let count = surface.shares.len();
    let texels = width * height;
    let mut out = Bare {
        maps: Maps {
            size: settings.size,
            normals: vec![[0.0, 0.0, 1.0]; texels],
            heights: vec![0.0; texels],
            shares: vec![0.0; texels * count],
            facts,
        },
        covered: vec![false; texels],
    };
    let found: Vec<Facts> = slots(&mut out, width * BAND, count)
        .into_par_iter()
        .zip(&bands)
        .enumerate()
        .map(|(band, (mut slots, flats))| ground.fill(band * BAND, flats, &mut slots))
        .collect();
    for band in found {
        out.maps.facts.covered += band.covered;
        out.maps.facts.overlapping += band.overlapping;
        out.maps.facts.folded += band.folded;
    }
    out
}

/// The triangles that cover anything; what is odd about the others is noted.
fn flats(surface: &Surface, frames: &[Option<Frame>], size: Samples, facts: &mut Facts) -> Vec<Flat> {
    let flat = |index: usize| {
        let framed = frames[surface.triangles[index].face as usize].is_some();
        framed.then(|| Flat::new(surface, index, size))
    };
    let all: Vec<_> = (0..surface.triangles.len()).into_par_iter().filter_map(flat).collect();
    facts.tiled = all.iter().filter(|flat| matches!(flat, Err(Gone::Tiled))).count();
    let flats: Vec<Flat> = all.into_iter().filter_map(Result::ok).collect();
    facts.wrapped = flats.iter().filter(|flat| flat.wraps(size)).count();
    flats
}

fn slots(out: &mut Bare, texels: usize, shares: usize) -> Vec<Slots<'_>> {
    let mut of_shares = out.maps.shares.chunks_mut((texels * shares).max(1));
    let rows = out.maps.normals.chunks_mut(texels).zip(out.maps.heights.chunks_mut(texels));
    let rows = rows.zip(out.covered.chunks_mut(texels));
    rows.map(|((normals, heights), covered)| Slots {
        normals,
        heights,
        covered,
        shares: of_shares.next().unwrap_or_default(),
    })
    .collect()
}

impl Ground<'_> {
    /// For each band of rows the triangles in it, in their order, each with how many tiles it is shifted.
    fn bands(&self, count: usize) -> Vec<Vec<(u32, i64)>> {
        let rows = whole(BAND * self.each);
        let mut bands = vec![Vec::new(); count];
        for (index, flat) in self.flats.iter().enumerate() {
            let [first, last] = flat.rows;
            for tile in first.div_euclid(self.samples[1])..=last.div_euclid(self.samples[1]) {
                let shift = tile * self.samples[1];
                let low = (first - shift).max(0) / rows;
                let high = (last - shift).min(self.samples[1] - 1) / rows;
                for band in &mut bands[low as usize..=high as usize] {
                    band.push((index as u32, tile));
                }
            }
        }
        bands
    }

    fn fill(&self, top: usize, flats: &[(u32, i64)], slots: &mut Slots<'_>) -> Facts {
        let rows = slots.heights.len() / self.width;
        let across = self.samples[0] as usize;
        let mut owners = vec![Owner::NOBODY; rows * self.each * across];
        let first = top * self.each;
        for &(flat, tile) in flats {
            fill(&self.flats[flat as usize], tile, whole(first), self.samples, &mut owners);
        }
        let mut facts = Facts::default();
        let count = self.surface.shares.len();
        let mut sums = vec![0.0_f64; count];
        for texel in 0..rows * self.width {
            let (x, y) = (texel % self.width * self.each, texel / self.width * self.each);
            let mut normal = DVec3::ZERO;
            let (mut height, mut n) = (0.0, 0.0);
            sums.fill(0.0);
            for (row, column) in (y..y + self.each).flat_map(|r| (x..x + self.each).map(move |c| (r, c))) {
                let owner = owners[row * across + column];
                if owner.triangle == NONE {
                    continue;
                }
                facts.covered += 1;
                facts.overlapping += u64::from(owner.overlapping);
                let Some(sample) = self.sample(owner, [column, first + row], &mut sums) else { continue };
                facts.folded += u64::from(sample.normal.z <= 0.0);
                normal += sample.normal;
                height += sample.height;
                n += 1.0;
            }
            if n > 0.0 {
                slots.normals[texel] = outward(normal / n).as_vec3().to_array();
                slots.heights[texel] = (height / n) as f32;
                slots.covered[texel] = true;
                for (slot, sum) in slots.shares[texel * count..][..count].iter_mut().zip(&sums) {
                    *slot = (sum / n) as f32;
                }
            }
        }
        facts
    }

    /// What a sample shows; its shares are added up.
    fn sample(&self, owner: Owner, at: [usize; 2], sums: &mut [f64]) -> Option<Sample> {
        let uv = [0, 1].map(|k| f64::from(owner.tile[k]) + (at[k] as f64 + 0.5) / self.samples[k] as f64);
        let triangle = self.surface.triangles[owner.triangle as usize];
        let vertices = triangle.vertices.map(|v| v as usize);
        let corners = vertices.map(|v| self.surface.uvs[v].map(f64::from));
        // A sliver that only snapping gave an area is all its corners alike.
        let weights =
            weights(&corners, uv).filter(|_| double_area(&corners) != 0.0).unwrap_or([1.0 / 3.0; 3]);
        let (n, matrix) = self.frames[triangle.face as usize].as_ref()?.at(uv)?;
        let between = |list: &[[f32; 3]]| (0..3).map(|k| wide(list[vertices[k]]) * weights[k]).sum::<DVec3>();
        let turned = between(&self.surface.turned);
        // Where nothing has turned, no rounding of the frame may say otherwise.
        let normal = if turned == DVec3::ZERO {
            DVec3::Z
        } else {
            (matrix.inverse() * (n + turned)).normalize_or(DVec3::Z)
        };
        for (sum, list) in sums.iter_mut().zip(&self.surface.shares) {
            *sum += (0..3).map(|k| f64::from(list[vertices[k]]) * weights[k]).sum::<f64>();
        }
        Some(Sample { normal, height: between(&self.surface.moved).dot(n) })
    }
}

/// A row of samples, which [`MAX_SIDE`](super::MAX_SIDE) keeps small.
fn whole(row: usize) -> i64 {
    i64::from(row as u32)
}

struct Sample {
    normal: DVec3,
    height: f64,
}

/// The direction of a mean of normals, with what points inwards laid into the plane: a viewer lights no back side.
pub(super) fn outward(mean: DVec3) -> DVec3 {
    DVec3::new(mean.x, mean.y, mean.z.max(0.0)).normalize_or(DVec3::Z)
}
