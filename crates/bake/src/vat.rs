//! Vertex animation textures as [`OpenVAT`](https://openvat.org) lays them out: a picture that has, for every vertex and frame, how far the
//! vertex is from where the mesh has it, and a mesh whose second texture coordinates say where in the picture its vertices are.
//!
//! For `n` vertices and `F` frames in a picture of `W`×`H`, counted from its upper left corner as glTF does, vertex `i` has
//!
//! `u = (i mod W + ½) / W`, `v = ((i div W)·F + ½) / H`
//!
//! and frame `f` is `f/H` further down. Red, green and blue are `(delta − Min) / (Max − Min)`, 0 to 1, in Blender's axes: X, −Z and Y of
//! glTF's. Normals are `(n + 1)/2` in the same axes, half a picture further down, or in a picture of their own. Sides are powers of two, at
//! most [`MAX_SIDE`]. (Blender, and so `OpenVAT`'s own text, counts `v` upwards: there it is 1 − this.)

mod exr;
mod png;

use serde_json::json;
use thiserror::Error;

pub use exr::write_exr;
pub use png::write_png;

/// The longest side: what `OpenVAT` writes, and every GPU of the last ten years takes.
pub const MAX_SIDE: usize = 4096;

/// The steps of 16 bits.
const STEPS: f64 = 65535.0;

/// Where normals go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VatNormals {
    /// Into the lower half of the picture: what the players for Godot and Bevy need.
    #[default]
    Packed,
    /// Into a picture of their own, so that twice as much fits.
    Separate,
}

/// How a picture keeps its numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VatFormat {
    /// A PNG of 16 bits a channel: exact to 1/131070 of the range of each axis.
    #[default]
    Png,
    /// An `OpenEXR` of 32-bit floats, not compressed.
    Exr,
}

impl VatFormat {
    /// What the name of a file ends with.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// A number from 0 to 1 as a reader gets it back.
    fn kept(self, t: f64) -> f64 {
        match self {
            Self::Png => (t * STEPS).round() / STEPS,
            Self::Exr => f64::from(t as f32),
        }
    }
}

/// Why there can be no texture.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{vertices} vertices in {frames} frames are more than a texture of {MAX_SIDE}×{MAX_SIDE} holds{}: {}", beside(*.normals), fits(*.most_frames, *.most_vertices))]
pub struct VatError {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Frames.
    pub frames: usize,
    /// Where normals were to go.
    pub normals: VatNormals,
    /// As many frames fit for so many vertices; 0 where none does.
    pub most_frames: usize,
    /// As many vertices fit for so many frames; 0 where none does.
    pub most_vertices: usize,
}

fn beside(normals: VatNormals) -> &'static str {
    match normals {
        VatNormals::Packed => " with their normals",
        VatNormals::Separate => "",
    }
}

fn fits(frames: usize, vertices: usize) -> String {
    match (frames, vertices) {
        (0, 0) => "neither does one frame fit, nor one vertex".to_owned(),
        (0, vertices) => format!("at most {vertices} vertices fit, and so many not even once"),
        (frames, 0) => format!("at most {frames} frames fit"),
        (frames, vertices) => {
            format!("{frames} frames fit, or {vertices} vertices")
        }
    }
}

/// Where vertices and frames are in a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VatLayout {
    /// Texels across.
    pub width: usize,
    /// Texels down, normals included.
    pub height: usize,
    /// Vertices, at least 1.
    pub vertices: usize,
    /// Frames, at least 1.
    pub frames: usize,
    /// Where normals go.
    pub normals: VatNormals,
}

impl VatLayout {
    /// The smallest texture that holds so much, the squarest of several; no vertices or frames count as one.
    ///
    /// # Errors
    ///
    /// It would be larger than [`MAX_SIDE`] on a side.
    pub fn new(vertices: usize, frames: usize, normals: VatNormals) -> Result<Self, VatError> {
        let (vertices, frames) = (vertices.max(1), frames.max(1));
        let halves = if normals == VatNormals::Packed { 2 } else { 1 };
        let sides = (0..).map(|k| 1_usize << k).take_while(|&side| side <= MAX_SIDE);
        let tried = sides.filter_map(|width| {
            let rows = vertices.div_ceil(width).checked_mul(frames)?;
            let height = rows.checked_next_power_of_two()?.checked_mul(halves)?;
            (height <= MAX_SIDE).then_some(Self { width, height, vertices, frames, normals })
        });
        let skew = |layout: &Self| layout.width.max(layout.height) / layout.width.min(layout.height);
        tried.min_by_key(|layout| (layout.width * layout.height, skew(layout))).ok_or_else(|| {
            let down = MAX_SIDE / halves;
            let most_frames = down / vertices.div_ceil(MAX_SIDE);
            VatError { vertices, frames, normals, most_frames, most_vertices: down / frames * MAX_SIDE }
        })
    }

    /// Where a vertex is at the first frame, as the second texture coordinates of a glTF mesh.
    pub fn uv(&self, vertex: usize) -> [f32; 2] {
        let middle = |texel: usize, side: usize| ((texel as f64 + 0.5) / side as f64) as f32;
        [middle(vertex % self.width, self.width), middle(vertex / self.width * self.frames, self.height)]
    }

    /// The number of a vertex's texel at a frame, rows from the top.
    fn texel(&self, vertex: usize, frame: usize) -> usize {
        (vertex / self.width * self.frames + frame) * self.width + vertex % self.width
    }
}

/// The least and the largest of all deltas, in Blender's axes, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VatRange {
    /// The least.
    pub min: [f32; 3],
    /// The largest.
    pub max: [f32; 3],
}

impl VatRange {
    /// That of no delta: any makes it its own.
    pub const NONE: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Takes in where vertices are at a frame, that are at `rest` in the mesh.
    pub fn grow(&mut self, rest: &[[f32; 3]], now: &[[f32; 3]]) {
        for (rest, now) in rest.iter().zip(now) {
            for (k, delta) in delta(*rest, *now).into_iter().enumerate() {
                // Outwards, so that no delta is beyond it.
                self.min[k] = self.min[k].min(below(delta));
                self.max[k] = self.max[k].max(-below(-delta));
            }
        }
    }
}

/// The largest `f32` that is not above a number.
fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// A vector of glTF in Blender's axes.
fn z_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

fn delta(rest: [f32; 3], now: [f32; 3]) -> [f64; 3] {
    z_up([0, 1, 2].map(|k| f64::from(now[k]) - f64::from(rest[k])))
}

/// A texture in the making.
#[derive(Clone, Debug)]
pub struct Vat {
    layout: VatLayout,
    range: VatRange,
    format: VatFormat,
    positions: Vec<[f32; 3]>,
    /// The normals where they have a picture of their own.
    normals: Vec<[f32; 3]>,
    /// How far a vertex is at most from where it is to be, metres.
    rounding: f64,
}

impl Vat {
    /// An empty one for deltas within `range`.
    pub fn new(layout: VatLayout, range: VatRange, format: VatFormat) -> Self {
        let texels = layout.width * layout.height;
        let own = if layout.normals == VatNormals::Separate { texels } else { 0 };
        let (positions, normals) = (vec![[0.0; 3]; texels], vec![[0.0; 3]; own]);
        Self { layout, range, format, positions, normals, rounding: 0.0 }
    }

    /// Sets a frame: where vertices are that are at `rest` in the mesh, and their unit normals. What is beyond the layout is passed over.
    pub fn set(&mut self, frame: usize, rest: &[[f32; 3]], now: &[[f32; 3]], normals: &[[f32; 3]]) {
        let Self { layout, range, format, .. } = *self;
        if frame >= layout.frames {
            return;
        }
        let half = layout.width * layout.height / 2;
        for (vertex, ((rest, now), normal)) in
            rest.iter().zip(now).zip(normals).enumerate().take(layout.vertices)
        {
            let texel = layout.texel(vertex, frame);
            let delta = delta(*rest, *now);
            let kept = [0, 1, 2].map(|k| format.kept(part(delta[k], range.min[k], range.max[k])));
            let off = [0, 1, 2].map(|k| whole(kept[k], range.min[k], range.max[k]) - delta[k]);
            self.rounding = self.rounding.max(off.iter().map(|c| c * c).sum::<f64>().sqrt());
            self.positions[texel] = kept.map(|t| t as f32);
            let normal = z_up(normal.map(f64::from)).map(|c| format.kept(c.midpoint(1.0)) as f32);
            match layout.normals {
                VatNormals::Packed => self.positions[texel + half] = normal,
                VatNormals::Separate => self.normals[texel] = normal,
            }
        }
    }

    /// The layout.
    pub fn layout(&self) -> &VatLayout {
        &self.layout
    }

    /// How far a vertex is at most from where it is to be, metres, over all frames that were set: what the format rounds away.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// The texels of the deltas, red, green and blue from 0 to 1, rows from the top; with normals in the lower half where they are packed.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// The texels of the normals where they have a picture of their own.
    pub fn normals(&self) -> Option<&[[f32; 3]]> {
        (!self.normals.is_empty()).then_some(self.normals.as_slice())
    }

    /// Writes texels of this texture as a picture of its format.
    ///
    /// # Errors
    ///
    /// What `out` says.
    pub fn write(&self, texels: &[[f32; 3]], out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let size = [self.layout.width, self.layout.height];
        match self.format {
            VatFormat::Png => write_png(texels, size, out),
            VatFormat::Exr => write_exr(texels, size, out),
        }
    }
}

/// How far a delta is from the least to the largest: 0 to 1, and 0 where these are equal.
fn part(delta: f64, min: f32, max: f32) -> f64 {
    let (min, max) = (f64::from(min), f64::from(max));
    if max > min { ((delta - min) / (max - min)).clamp(0.0, 1.0) } else { 0.0 }
}

fn whole(t: f64, min: f32, max: f32) -> f64 {
    f64::from(min) + t * (f64::from(max) - f64::from(min))
}

/// A clip of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VatClip<'a> {
    /// Its name.
    pub name: &'a str,
    /// Frames a second.
    pub fps: f64,
    /// Whether it ends as it begins.
    pub looping: bool,
}

/// What the texture's `NAME-remap_info.json` holds: the range, how many frames there are, and a clip from the first to the last.
pub fn remap_info(range: &VatRange, frames: usize, clip: &VatClip<'_>) -> String {
    let VatClip { name, fps, looping } = *clip;
    // Some readers want a whole number where there is one.
    let rate = if fps.fract() == 0.0 && fps < 1e9 { json!(fps as u64) } else { json!(fps) };
    let numbers = |v: [f32; 3]| v.map(|c| f64::from(c) + 0.0);
    let info = json!({
        "os-remap": { "Min": numbers(range.min), "Max": numbers(range.max), "Frames": frames },
        "animations": {
            name: { "startFrame": 0, "endFrame": frames.saturating_sub(1), "framerate": rate, "looping": looping },
        },
    });
    // Numbers and text only: this cannot fail.
    let mut text = serde_json::to_string_pretty(&info).unwrap_or_default();
    text.push('\n');
    text
}

#[cfg(test)]
#[path = "vat/tests.rs"]
mod tests;
