//! What the parts of a model look like, wherever their vertices are.

use std::collections::BTreeMap;
use std::sync::Arc;

use wirework_asset::{Alpha, Gltf, Limits, Look, Rest, Stroke, TextureUse, Warning, printable};
use wirework_render::{CLAY, Dots, Line, LineKind, Part, Scene, Texture, Wrap};

use crate::JobError;
use crate::decode::decode;
use crate::picture::overlay::thickness;

/// Diameter of a model's points and width of its lines, pixels in a picture of the usual height.
const POINT: f32 = 6.0;
const LINE: f32 = 1.6;
/// Bytes of a texture's pixel: four channels, and a third more for smaller copies.
const TEXEL: usize = 6;

/// The alpha of a surface that covers as much as it lets through.
const HALF: f32 = 0.5;

/// The parts of a model without their places.
pub(crate) struct Drawn {
    surfaces: Vec<Surface>,
    strokes: Vec<(Stroke, [f32; 3])>,
}

/// A part with triangles.
struct Surface {
    /// Its run of vertices.
    first: usize,
    count: usize,
    /// All of it but positions and normals.
    part: Part,
}

/// Reads what the parts of `rest` look like; what has no colour, texture or vertex colours is clay, on which relief reads better than
/// on white. What cannot be read of it is told, and does without.
pub(crate) fn drawn(
    gltf: &Gltf,
    rest: &Rest,
    limits: &Limits,
    warnings: &mut Vec<String>,
) -> Result<Drawn, JobError> {
    let mut reader = Reader { gltf, rest, limits, textures: BTreeMap::new(), warnings };
    let (looks, doubts) = gltf.looks(rest);
    for doubt in &doubts {
        reader.warn(doubt);
    }
    let colors = gltf.colors(rest).unwrap_or_else(|error| {
        reader.warnings.push(format!("{error}; the colours of vertices are left out"));
        vec![None; rest.blocks.len()]
    });
    let mut surfaces = Vec::new();
    for (index, (part, look)) in rest.parts.iter().zip(&looks).enumerate() {
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        let (Some(block), Some(triangles)) = (rest.blocks.get(part.block), rest.triangles.get(range)) else {
            continue;
        };
        if triangles.is_empty() {
            continue;
        }
        let first = block.first as u32;
        let colors = colors.get(part.block).and_then(Option::as_ref);
        let colors: Vec<[f32; 3]> = colors.into_iter().flatten().map(|&[r, g, b, _]| [r, g, b]).collect();
        let plain = look.color.is_none() && look.texture.is_none() && colors.is_empty();
        let mut shown = Part {
            positions: Vec::new(),
            normals: Vec::new(),
            triangles: triangles.iter().map(|t| t.map(|v| v - first)).collect(),
            color: if plain { CLAY } else { rgb(look) },
            colors,
            uvs: Vec::new(),
            texture: None,
            wrap: [Wrap::Repeat; 2],
            cutoff: None,
        };
        if let Some(texture) = &look.texture {
            reader.dress(&mut shown, index, texture);
            shown.cutoff = shown.texture.as_ref().and_then(|_| cutoff(look));
        }
        surfaces.push(Surface { first: block.first, count: block.count, part: shown });
    }
    let color = |stroke: &Stroke| match looks.get(stroke.part) {
        Some(look) if look.color.is_some() => rgb(look),
        _ => LineKind::Point.color(),
    };
    let strokes = gltf.strokes(rest)?.into_iter().map(|stroke| {
        let color = color(&stroke);
        (stroke, color)
    });
    Ok(Drawn { surfaces, strokes: strokes.collect() })
}

fn rgb(look: &Look) -> [f32; 3] {
    let [r, g, b, _] = look.color.unwrap_or([1.0; 4]);
    [r, g, b]
}

/// The alpha of the texture below which a surface is not there. Nothing is half there in these pictures: what would let more than
/// half of what is behind through is left out.
fn cutoff(look: &Look) -> Option<f32> {
    let factor = look.color.map_or(1.0, |[.., alpha]| alpha);
    let least = match look.alpha {
        Alpha::Opaque => return None,
        Alpha::Mask(cutoff) => cutoff,
        Alpha::Blend => HALF,
    };
    (factor > 0.0).then(|| least / factor)
}

/// Reads textures, each image once.
struct Reader<'a> {
    gltf: &'a Gltf,
    rest: &'a Rest,
    limits: &'a Limits,
    textures: BTreeMap<usize, Option<Arc<Texture>>>,
    warnings: &'a mut Vec<String>,
}

impl Reader<'_> {
    fn warn(&mut self, warning: &Warning) {
        self.warnings.push(format!("{}: {warning}", printable(self.gltf.file())));
    }

    /// Gives a part its texture, where both image and coordinates can be read.
    fn dress(&mut self, part: &mut Part, index: usize, texture: &TextureUse) {
        let Some(image) = self.texture(texture.image) else { return };
        match self.gltf.texture_coordinates(self.rest, index, texture) {
            Ok(uvs) => {
                part.uvs = uvs;
                part.texture = Some(image);
                part.wrap = texture.wrap.map(|wrap| match wrap {
                    wirework_asset::Wrap::Repeat => Wrap::Repeat,
                    wirework_asset::Wrap::Clamp => Wrap::Clamp,
                    wirework_asset::Wrap::Mirror => Wrap::Mirror,
                });
            }
            Err(error) => self.warnings.push(format!("{error}; the texture is left out")),
        }
    }

    fn texture(&mut self, image: usize) -> Option<Arc<Texture>> {
        if let Some(known) = self.textures.get(&image) {
            return known.clone();
        }
        let read = self.decoded(image).map(Arc::new);
        if let Err(message) = &read {
            let file = printable(self.gltf.file());
            self.warnings.push(format!("{file}: /images/{image}: {message}; it is left out [image]"));
        }
        self.textures.entry(image).or_insert(read.ok()).clone()
    }

    fn decoded(&self, image: usize) -> Result<Texture, String> {
        let encoded = self.gltf.image(image).map_err(|error| error.to_string())?;
        let decoded = decode(&encoded.bytes, TEXEL, self.limits).map_err(|refusal| {
            let kind = encoded
                .media_type
                .as_deref()
                .map_or_else(String::new, |kind| format!(" ({})", printable(kind)));
            format!("the image{kind} {}", refusal.message)
        })?;
        let pixels = decoded.into_rgba8();
        let (width, height) = pixels.dimensions();
        let pixels = pixels.pixels().map(|pixel| pixel.0).collect();
        Texture::new(width, height, pixels).map_err(|error| error.to_string())
    }
}

impl Drawn {
    /// Whether nothing of it can be seen: no point, no line, and no triangle with an area.
    pub(crate) fn is_empty(&self, positions: &[[f32; 3]]) -> bool {
        let seen = |surface: &Surface| {
            let corners = |t: &[u32; 3]| t.map(|v| positions.get(surface.first + v as usize).copied());
            surface.part.triangles.iter().any(|triangle| match corners(triangle) {
                [Some(a), Some(b), Some(c)] => area(a, b, c) > 0.0,
                _ => false,
            })
        };
        self.strokes.is_empty() && !self.surfaces.iter().any(seen)
    }

    /// The parts where they are now, in a picture of so many rows; `normals` are as many as the positions, or none.
    pub(crate) fn scene(&self, positions: &[[f32; 3]], normals: &[[f32; 3]], rows: u32) -> Scene {
        let place = |surface: &Surface| {
            let range = surface.first..surface.first + surface.count;
            let of = |list: &[[f32; 3]]| list.get(range.clone()).unwrap_or(&[]).to_vec();
            Part { positions: of(positions), normals: of(normals), ..surface.part.clone() }
        };
        let mut scene = Scene { parts: self.surfaces.iter().map(place).collect(), ..Scene::default() };
        let kind = LineKind::Point;
        for (stroke, color) in &self.strokes {
            let of = |list: &[u32]| -> Vec<[f32; 3]> {
                list.iter().filter_map(|&v| positions.get(v as usize).copied()).collect()
            };
            if stroke.line_ends.is_empty() {
                let width = POINT * thickness(rows);
                scene.dots.push(Dots { points: of(&stroke.points), color: *color, width, kind });
            }
            let line = |points| Line { points, color: *color, width: LINE * thickness(rows), kind };
            scene.lines.extend(stroke.lines().map(|points| line(of(points))));
        }
        scene
    }
}

/// Twice the area of a triangle, squared.
fn area(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> f64 {
    let way = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let (u, v) = (way(b), way(c));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    cross.iter().map(|x| x * x).sum()
}
