//! Which triangle each sample of a map belongs to.
//!
//! Texture coordinates are snapped to 1/256 of a sample; edge functions on integers are exact, so that a sample on an edge
//! belongs to one of the two triangles and never to none or both. Of triangles of different faces the first wins, and the sample counts as one
//! where they overlap.

use super::{Facts, Surface, Triangle};

/// No triangle.
pub(super) const NONE: u32 = u32::MAX;
/// Snapped positions a sample.
const SUBSAMPLE: i64 = 256;
/// How many tiles away from 0 a triangle may lie: farther out floats no longer tell texels apart.
const FARTHEST: f64 = 1024.0;

/// A triangle in the plane of texture coordinates, counter-clockwise in snapped positions with `v` down, with an area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    corners: [[i64; 2]; 3],
    /// Which triangle of the surface it is, and its face.
    pub(super) triangle: u32,
    face: u32,
    /// The samples its box touches, first and last; they may lie in any tile.
    columns: [i64; 2],
    pub(super) rows: [i64; 2],
}

/// Why a triangle is in no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gone {
    /// It covers no sample.
    Small,
    /// It reaches over too many tiles, or is too far away.
    Tiled,
}

/// All samples of a map: columns and rows.
pub(super) type Samples = [i64; 2];

impl Flat {
    pub(super) fn new(surface: &Surface, index: usize, size: Samples) -> Result<Self, Gone> {
        let Triangle { vertices, face } = surface.triangles[index];
        let uvs = vertices.map(|v| surface.uvs[v as usize].map(f64::from));
        let near = |x: &f64| x.is_finite() && x.abs() <= FARTHEST;
        if !uvs.as_flattened().iter().all(near) {
            return Err(Gone::Tiled);
        }
        let snap = |uv: [f64; 2]| [0, 1].map(|k| (uv[k] * (size[k] * SUBSAMPLE) as f64).round() as i64);
        let mut corners = uvs.map(snap);
        let area = cross(corners[0], corners[1], corners[2]);
        if area == 0 {
            return Err(Gone::Small);
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let range = |k: usize| {
            let (low, high) =
                corners.iter().fold((i64::MAX, i64::MIN), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            if high - low > size[k] * SUBSAMPLE * i64::from(Facts::TILES) {
                return Err(Gone::Tiled);
            }
            // The centres of samples are at 128 + 256 i.
            let (first, last) = ((low + 127).div_euclid(SUBSAMPLE), (high - 128).div_euclid(SUBSAMPLE));
            if first <= last { Ok([first, last]) } else { Err(Gone::Small) }
        };
        let (columns, rows) = (range(0)?, range(1)?);
        Ok(Self { corners, triangle: index as u32, face, columns, rows })
    }

    /// Whether it reaches beyond the map.
    pub(super) fn wraps(&self, size: Samples) -> bool {
        let out = |[first, last]: [i64; 2], count| first < 0 || last >= count;
        out(self.columns, size[0]) || out(self.rows, size[1])
    }
}

/// A sample: the triangle that it belongs to, and in which tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    pub(super) triangle: u32,
    face: u32,
    pub(super) tile: [i32; 2],
    pub(super) overlapping: bool,
}

impl Owner {
    pub(super) const NOBODY: Self = Self { triangle: NONE, face: NONE, tile: [0; 2], overlapping: false };
}

/// Gives samples of the rows from `top` on to a triangle, shifted up by so many tiles.
pub(super) fn fill(flat: &Flat, tile: i64, top: i64, size: Samples, owners: &mut [Owner]) {
    let [a, b, c] = flat.corners;
    let center = |i: i64| i * SUBSAMPLE + SUBSAMPLE / 2;
    // Edge functions, 0 or more inside; an edge that runs down, or level to the right, has its own samples.
    let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let owns = dy > 0 || (dy == 0 && dx > 0);
        (p, q, i64::from(!owns), -dy * SUBSAMPLE)
    });
    let shift = tile * size[1];
    let bottom = top + (owners.len() as u64).cast_signed() / size[0];
    let first = flat.rows[0].max(top + shift);
    let last = flat.rows[1].min(bottom - 1 + shift);
    for row in first..=last {
        let line = &mut owners[((row - shift - top) * size[0]) as usize..][..size[0] as usize];
        let mut values =
            edges.map(|(p, q, bias, _)| cross(p, q, [center(flat.columns[0]), center(row)]) - bias);
        let mut entered = false;
        for column in flat.columns[0]..=flat.columns[1] {
            if values[0] | values[1] | values[2] >= 0 {
                entered = true;
                let (x, own) = (column.rem_euclid(size[0]), column.div_euclid(size[0]));
                take(&mut line[x as usize], flat, [own as i32, tile as i32]);
            } else if entered {
                break;
            }
            for (value, (.., right)) in values.iter_mut().zip(&edges) {
                *value += right;
            }
        }
    }
}

fn take(owner: &mut Owner, flat: &Flat, tile: [i32; 2]) {
    if owner.triangle == NONE {
        *owner = Owner { triangle: flat.triangle, face: flat.face, tile, overlapping: false };
    } else if owner.face != flat.face || owner.tile != tile {
        owner.overlapping = true;
    }
}

/// Twice the signed area of a, b, p.
fn cross(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}
