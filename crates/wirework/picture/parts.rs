//! What the parts of a model look like, wherever their vertices are.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use wirework_asset::{Alpha, Gltf, Limits, Look, Place, Rest, Stroke, TextureUse, Warning, printable};
use wirework_render::{CLAY, Dots, Line, LineKind, Part, Scene, Texture, Wrap};

use crate::JobError;
use crate::decode::decode;
use crate::picture::overlay::thickness;

/// Diameter of a model's points and width of its lines, pixels in a picture of the usual height.
const POINT: f32 = 6.0;
const LINE: f32 = 1.6;
/// Bytes of a texture's pixel: four channels, a third more for smaller copies, and while it is made as many again.
const TEXEL: usize = 10;

/// The alpha of a surface that covers as much as it lets through.
const HALF: f32 = 0.5;

/// The parts of a model without their places.
pub(crate) struct Drawn {
    surfaces: Vec<Surface>,
    strokes: Vec<(Stroke, [f32; 3])>,
    /// The vertices of all of them, each once, rising: others are in no picture.
    pub(crate) seen: Vec<u32>,
}

/// A part with triangles.
struct Surface {
    /// Its vertices among those of the model, each once.
    vertices: Vec<u32>,
    /// All of it but positions and normals.
    part: Part,
}

/// Reads what the parts of `rest` look like; what has no colour, texture or vertex colours is clay, on which relief reads better
/// than on white. `colors`, one a vertex, are in the place of those of a model that has none in its document. What cannot be
/// read is told, and done without.
pub(crate) fn drawn(
    gltf: &Gltf,
    rest: &Rest,
    colors: Option<&[[f32; 3]]>,
    limits: &Limits,
    warnings: &mut Vec<String>,
) -> Result<Drawn, JobError> {
    let (looks, doubts) = gltf.looks(rest);
    let doubts = doubts.iter().filter(|doubt| !gltf.tells_of(doubt));
    warnings.extend(doubts.map(|doubt| format!("{}: {doubt}", printable(gltf.file()))));
    let of_blocks = gltf.colors(rest).unwrap_or_else(|error| {
        warnings.push(format!("{error}; the colours of vertices are left out"));
        vec![None; rest.blocks.len()]
    });
    let mut reader = Reader { gltf, rest, limits: *limits, textures: BTreeMap::new(), warnings };
    let mut picked = Picked::new(rest.positions.len());
    let mut surfaces = Vec::new();
    for (index, (part, look)) in rest.parts.iter().zip(&looks).enumerate() {
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        let (Some(block), Some(triangles)) = (rest.blocks.get(part.block), rest.triangles.get(range)) else {
            continue;
        };
        if triangles.is_empty() || is_cut_away(look) {
            continue;
        }
        let (vertices, triangles) = picked.pick(triangles);
        let own = of_blocks.get(part.block).and_then(Option::as_ref);
        let color = |&v: &u32| match (own, colors) {
            (Some(own), _) => own.get(v as usize - block.first).map(|&[r, g, b, _]| [r, g, b]),
            (None, Some(colors)) => colors.get(v as usize).copied(),
            (None, None) => None,
        };
        let colors: Vec<[f32; 3]> = vertices.iter().filter_map(color).collect();
        let plain = look.color.is_none() && look.texture.is_none() && colors.is_empty();
        let color = if plain { CLAY } else { rgb(look) };
        let mut shown = Part { triangles, color, colors, ..Part::default() };
        if let Some(texture) = &look.texture {
            reader.dress(&mut shown, &vertices, index, texture);
            if shown.texture.is_some() {
                shown.cutoff = cutoff(look);
            } else if look.color.is_none() && shown.colors.is_empty() {
                shown.color = CLAY;
            }
        }
        surfaces.push(Surface { vertices, part: shown });
    }
    let color = |stroke: &Stroke| match looks.get(stroke.part) {
        Some(look) if look.color.is_some() => rgb(look),
        _ => LineKind::Point.color(),
    };
    let strokes = gltf.strokes(rest)?.into_iter().filter(|stroke| !stroke.points.is_empty());
    let strokes = strokes.map(|stroke| (color(&stroke), stroke));
    let strokes: Vec<_> = strokes.map(|(color, stroke)| (stroke, color)).collect();
    let points = strokes.iter().flat_map(|(stroke, _)| &stroke.points);
    let seen: BTreeSet<u32> =
        surfaces.iter().flat_map(|surface| &surface.vertices).chain(points).copied().collect();
    Ok(Drawn { surfaces, strokes, seen: seen.into_iter().collect() })
}

/// Picks the vertices of some triangles out of those of a model.
struct Picked {
    /// For each vertex of the model which list has it, counted from 1, and as which.
    places: Vec<(u32, u32)>,
    lists: u32,
}

impl Picked {
    fn new(vertices: usize) -> Self {
        Self { places: vec![(0, 0); vertices], lists: 0 }
    }

    /// The vertices of the triangles, each once, and the triangles between them.
    fn pick(&mut self, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
        self.lists += 1;
        let mut vertices = Vec::new();
        let mut own = |v: u32| {
            let Some(place) = self.places.get_mut(v as usize) else { return 0 };
            if place.0 != self.lists {
                *place = (self.lists, vertices.len() as u32);
                vertices.push(v);
            }
            place.1
        };
        let triangles = triangles.iter().map(|t| t.map(&mut own)).collect();
        (vertices, triangles)
    }
}

/// The alpha below which a surface is not there. Nothing is half there in these pictures: what lets more than half of what is behind
/// through is left out.
fn least(alpha: Alpha) -> f32 {
    match alpha {
        Alpha::Opaque => 0.0,
        Alpha::Mask(cutoff) => cutoff,
        Alpha::Blend => HALF,
    }
}

fn alpha(look: &Look) -> f32 {
    look.color.map_or(1.0, |[.., alpha]| alpha)
}

/// Whether nothing of a part is there, whatever its texture: that can only take away.
fn is_cut_away(look: &Look) -> bool {
    alpha(look) < least(look.alpha)
}

/// The alpha of its texture below which a surface is not there.
fn cutoff(look: &Look) -> Option<f32> {
    (look.alpha != Alpha::Opaque).then(|| least(look.alpha) / alpha(look).max(f32::MIN_POSITIVE))
}

fn rgb(look: &Look) -> [f32; 3] {
    let [r, g, b, _] = look.color.unwrap_or([1.0; 4]);
    [r, g, b]
}

/// Reads textures, each image once.
struct Reader<'a> {
    gltf: &'a Gltf,
    rest: &'a Rest,
    /// What is left of the limit on decoded bytes: all textures are held at once.
    limits: Limits,
    textures: BTreeMap<usize, Option<Arc<Texture>>>,
    warnings: &'a mut Vec<String>,
}

impl Reader<'_> {
    /// Gives a part its texture, where both image and coordinates can be read.
    fn dress(&mut self, part: &mut Part, vertices: &[u32], index: usize, texture: &TextureUse) {
        let Some(image) = self.texture(texture.image) else { return };
        match self.gltf.texture_coordinates(self.rest, index, texture) {
            Ok(uvs) => {
                let block = self.rest.parts.get(index).and_then(|part| self.rest.blocks.get(part.block));
                let first = block.map_or(0, |block| block.first);
                let uv = |&v: &u32| uvs.get(v as usize - first).copied().unwrap_or_default();
                part.uvs = vertices.iter().map(uv).collect();
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
            let place = Place::Pointer(format!("/images/{image}"));
            let name = self.gltf.json()["images"][image]["name"].as_str();
            let name = name.map_or_else(String::new, |name| format!("\"{name}\": "));
            let doubt = Warning { code: "image", place, message: format!("{name}{message}; it is left out") };
            if !self.gltf.tells_of(&doubt) {
                self.warnings.push(format!("{}: {doubt}", printable(self.gltf.file())));
            }
        }
        self.textures.entry(image).or_insert(read.ok()).clone()
    }

    fn decoded(&mut self, image: usize) -> Result<Texture, String> {
        let encoded = self.gltf.image(image).map_err(|error| error.to_string())?;
        let decoded = decode(&encoded.bytes, TEXEL, &self.limits).map_err(|refusal| {
            let kind = encoded
                .media_type
                .as_deref()
                .map_or_else(String::new, |kind| format!(" ({})", printable(kind)));
            format!("the image{kind} {}", refusal.message)
        })?;
        let pixels = decoded.into_rgba8();
        let (width, height) = pixels.dimensions();
        let bytes = u64::from(width) * u64::from(height) * TEXEL as u64;
        self.limits.expanded_bytes = self.limits.expanded_bytes.saturating_sub(bytes);
        let pixels = pixels.pixels().map(|pixel| pixel.0).collect();
        Texture::new(width, height, pixels).map_err(|error| error.to_string())
    }
}

impl Drawn {
    /// Whether nothing of it can be seen: no point, no line, and no triangle with an area.
    pub(crate) fn is_empty(&self, positions: &[[f32; 3]]) -> bool {
        let seen = |surface: &Surface| {
            let place = |v: u32| positions.get(*surface.vertices.get(v as usize)? as usize).copied();
            let corners = |t: &[u32; 3]| t.map(place);
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
            let of = |list: &[[f32; 3]]| {
                surface.vertices.iter().filter_map(|&v| list.get(v as usize).copied()).collect::<Vec<_>>()
            };
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
