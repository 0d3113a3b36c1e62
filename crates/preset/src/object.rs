//! Objects that a preset brings along: primitives, patches, points, or a file.

use std::path::{Path, PathBuf};

use thiserror::Error;
use wirework_surface::{MAX_VERTICES, Mesh, Patch, PatchError, PrimitiveError, Transform, TransformError};

use crate::error::PresetErrorKind;
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};

/// What a preset is shown on where the command line names no input.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What it is.
    pub shape: Shape,
    /// Where it stands.
    pub transform: Transform,
}

/// The kinds of objects. Sizes are metres; vertex orders are documented at the functions of `wirework-surface`.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A flat rectangle about the origin.
    Grid {
        /// Along its first and its second side.
        size: [f32; 2],
        /// Quads along each side. Default 32 × 32.
        cells: [u32; 2],
        /// Where it faces. Default +Y: its sides then are along X and Z.
        normal: [f32; 3],
    },
    /// A cylinder.
    Tube {
        /// Centre of the first ring.
        from: [f32; 3],
        /// Centre of the last ring.
        to: [f32; 3],
        /// Its radius.
        radius: f32,
        /// Vertices of a ring. Default 32.
        sides: u32,
        /// Rings, both ends included. Default 33.
        rings: u32,
        /// Whether its ends are closed. Default true.
        caps: bool,
    },
    /// A sphere by latitude and longitude.
    Sphere {
        /// Its centre. Default the origin.
        center: [f32; 3],
        /// Its radius.
        radius: f32,
        /// Segments round Y and from pole to pole. Default 64 and 32.
        segments: [u32; 2],
    },
    /// A box.
    Box {
        /// The corner with the least coordinates.
        min: [f32; 3],
        /// The opposite corner.
        max: [f32; 3],
        /// Quads along each axis. Default 8 each.
        cells: [u32; 3],
    },
    /// Points without faces.
    Points(Vec<[f32; 3]>),
    /// A tensor-product B-spline surface.
    Patch {
        /// Its control net. Default degree 3 both ways.
        patch: Patch,
        /// Quads along `u` and `v`. Default 32 × 32.
        tessellation: [u32; 2],
    },
    /// A file of its own; as typed, relative to the preset.
    File(PathBuf),
}

/// Why an object cannot be built although each of its values is good: what `f32` makes of them together, a radius
/// added to a far centre for instance.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// A primitive.
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
    /// A patch.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// Its placement.
    #[error(transparent)]
    Transform(#[from] TransformError),
}

/// How large an object is once it is built, known before anything of it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectSize {
    /// Vertices as a renderer counts them, those of seams and hard edges once for each side. At most so many.
    pub vertices: u64,
    /// Indices of its triangles. At most so many.
    pub indices: u64,
}

impl Shape {
    /// How large it will be. 0 for a file, which says so itself.
    pub fn size(&self) -> ObjectSize {
        let product = |a: u32, b: u32| u64::from(a).saturating_mul(u64::from(b));
        // Vertices and quads of a sheet of cells.
        let sheet = |a: u32, b: u32| [product(a.saturating_add(1), b.saturating_add(1)), product(a, b)];
        let [vertices, quads] = match self {
            Self::Grid { cells: [a, b], .. }
            | Self::Sphere { segments: [a, b], .. }
            | Self::Patch { tessellation: [a, b], .. } => sheet(*a, *b),
            Self::Tube { sides, rings, caps, .. } => {
                let [vertices, quads] = sheet(*sides, rings.saturating_sub(1));
                // A cap is a fan: half a quad, a vertex of the rim and the centre.
                let caps = if *caps { u64::from(*sides) } else { 0 };
                [vertices.saturating_add(2 * (caps + 1)), quads.saturating_add(caps)]
            }
            Self::Box { cells: [l, m, n], .. } => {
                let sides = [sheet(*l, *m), sheet(*m, *n), sheet(*n, *l)];
                [0, 1]
                    .map(|i| sides.iter().fold(0, |sum: u64, side| sum.saturating_add(side[i])))
                    .map(|half| half.saturating_mul(2))
            }
            Self::Points(points) => [points.len() as u64, 0],
            Self::File(_) => [0, 0],
        };
        ObjectSize { vertices, indices: quads.saturating_mul(6) }
    }
}

const SHAPES: [&str; 7] = ["Grid", "Tube", "Sphere", "Box", "Points", "Patch", "File"];

impl Object {
    /// The file to read, for an object that is one; `preset_dir` is the folder of the preset.
    pub fn file(&self, preset_dir: &Path) -> Option<PathBuf> {
        match &self.shape {
            Shape::File(path) => Some(preset_dir.join(path)),
            _ => None,
        }
    }

    /// The object as a mesh where it stands. `None` for a file: reading that, and placing it by
    /// [`Object::transform`], is the caller's.
    pub fn build(&self) -> Result<Option<Mesh>, ObjectError> {
        let mut mesh = match &self.shape {
            Shape::Grid { size, cells, normal } => wirework_surface::grid(*size, *cells, *normal)?,
            Shape::Tube { from, to, radius, sides, rings, caps } => {
                wirework_surface::tube(*from, *to, *radius, *sides, *rings, *caps)?
            }
            Shape::Sphere { center, radius, segments } => {
                wirework_surface::sphere(*center, *radius, *segments)?
            }
            Shape::Box { min, max, cells } => wirework_surface::cuboid(*min, *max, *cells)?,
            Shape::Points(points) => Mesh { positions: points.clone(), ..Mesh::default() },
            Shape::Patch { patch, tessellation } => patch.tessellate(*tessellation)?,
            Shape::File(_) => return Ok(None),
        };
        self.transform.apply_to_mesh(&mut mesh)?;
        Ok(Some(mesh))
    }
}

/// Reads an object.
pub(crate) fn object(reader: &mut Reader<'_>, node: &Node) -> Option<Object> {
    let Some(name) = &node.name else {
        return reader.mismatch(node, "an object such as `Grid(size: (2, 2), cells: (64, 64))`");
    };
    let Some(owner) = SHAPES.iter().copied().find(|shape| *shape == name.text) else {
        reader.unknown_name(name, "object", &SHAPES);
        return None;
    };
    // The value of `Points` and `File` may stand alone.
    if let Body::Tuple(items) = &node.body
        && let [item] = items.as_slice()
        && !matches!(item.body, Body::Fields(_))
    {
        let shape = match owner {
            "Points" => point_set(reader, item)?,
            "File" => file(reader, item)?,
            _ => return reader.bad(node, format!("expected `{owner}(field: value, ..)`")),
        };
        return Some(Object { shape, transform: Transform::default() });
    }
    let mut fields = reader.unnamed_fields(node, owner)?;
    let shape = match owner {
        "Grid" => grid(reader, &mut fields),
        "Tube" => tube(reader, &mut fields),
        "Sphere" => sphere(reader, &mut fields),
        "Box" => cuboid(reader, &mut fields),
        "Points" => reader.required(&mut fields, "points", point_set),
        "Patch" => patch(reader, &mut fields),
        _ => reader.required(&mut fields, "path", file),
    };
    let transform = transform(reader, &mut fields);
    reader.finish(fields);
    let shape = shape?;
    vertices(reader, node, &shape)?;
    Some(Object { shape, transform })
}

fn transform(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Transform {
    let rest = Transform::default();
    Transform {
        translation: reader.field(fields, "translation", rest.translation, Reader::point),
        rotation: reader.field(fields, "rotation", rest.rotation, Reader::point),
        scale: reader.field(fields, "scale", rest.scale, |reader, node| {
            // One number scales all axes.
            let scale = match node.body {
                Body::Number { .. } => [reader.number(node, Within::Finite)?; 3],
                _ => reader.point(node)?,
            };
            if scale.contains(&0.0) { reader.bad(node, "`scale` must not be 0") } else { Some(scale) }
        }),
    }
}

/// Refuses an object that is too large before anything of it is allocated.
fn vertices(reader: &mut Reader<'_>, node: &Node, shape: &Shape) -> Option<()> {
    let count = shape.size().vertices;
    let (limit, raise) = if reader.limits.vertices <= MAX_VERTICES {
        (reader.limits.vertices, "--max-vertices raises it")
    } else {
        (MAX_VERTICES, "no flag raises it")
    };
    if count <= limit {
        return Some(());
    }
    let span = node.name.as_ref().map_or(&node.span, |name| &name.span);
    let message = format!("this object has {count} vertices, the limit is {limit} ({raise})");
    reader.error(PresetErrorKind::Limit, span, message, None);
    None
}

/// `N` counts of at least `least` each.
fn counts<const N: usize>(
    reader: &mut Reader<'_>,
    node: &Node,
    least: [u64; N],
    expected: &str,
) -> Option<[u32; N]> {
    let items: &[Node; N] = reader.tuple(node, expected)?;
    let mut least = least.into_iter();
    let read = reader.each(items, |reader, item| {
        let count = reader.count(item, least.next().unwrap_or(1))?;
        u32::try_from(count).ok().or_else(|| reader.bad(item, format!("{count} is too many")))
    })?;
    read.try_into().ok()
}

fn count(reader: &mut Reader<'_>, node: &Node, least: u64) -> Option<u32> {
    let count = reader.count(node, least)?;
    u32::try_from(count).ok().or_else(|| reader.bad(node, format!("{count} is too many")))
}

/// Two lengths greater than 0.
pub(crate) fn size(reader: &mut Reader<'_>, node: &Node) -> Option<[f32; 2]> {
    let items: &[Node; 2] = reader.tuple(node, "two lengths `(a, b)`")?;
    reader.each(items, |reader, item| reader.number(item, Within::Positive))?.try_into().ok()
}

/// A vector that is not 0.
pub(crate) fn direction(reader: &mut Reader<'_>, node: &Node) -> Option<[f32; 3]> {
    let vector = reader.point(node)?;
    if vector == [0.0; 3] { reader.bad(node, "a direction must not be (0, 0, 0)") } else { Some(vector) }
}

fn grid(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let size = reader.required(fields, "size", size);
    let cells =
        reader.field(fields, "cells", [32; 2], |r, node| counts(r, node, [1; 2], "two counts `(a, b)`"));
    let normal = reader.field(fields, "normal", [0.0, 1.0, 0.0], direction);
    Some(Shape::Grid { size: size?, cells, normal })
}

fn tube(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let from = reader.required(fields, "from", Reader::point);
    let to = reader.required(fields, "to", |reader, node| {
        let to = reader.point(node)?;
        if Some(to) == from { reader.bad(node, "`to` must differ from `from`") } else { Some(to) }
    });
    let radius = reader.required(fields, "radius", |reader, node| reader.number(node, Within::Positive));
    let sides = reader.field(fields, "sides", 32, |reader, node| count(reader, node, 3));
    let rings = reader.field(fields, "rings", 33, |reader, node| count(reader, node, 2));
    let caps = reader.field(fields, "caps", true, Reader::flag);
    Some(Shape::Tube { from: from?, to: to?, radius: radius?, sides, rings, caps })
}

fn sphere(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let center = reader.field(fields, "center", [0.0; 3], Reader::point);
    let radius = reader.required(fields, "radius", |reader, node| reader.number(node, Within::Positive));
    let segments = reader.field(fields, "segments", [64, 32], |reader, node| {
        counts(reader, node, [3, 2], "two counts `(around, from pole to pole)`")
    });
    Some(Shape::Sphere { center, radius: radius?, segments })
}

fn cuboid(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let min = reader.required(fields, "min", Reader::point);
    let max = reader.required(fields, "max", |reader, node| {
        let max = reader.point(node)?;
        let flat = min.is_some_and(|min| min.iter().zip(&max).any(|(min, max)| max <= min));
        if flat { reader.bad(node, "`max` must be greater than `min` along each axis") } else { Some(max) }
    });
    let cells =
        reader.field(fields, "cells", [8; 3], |r, node| counts(r, node, [1; 3], "three counts `(l, m, n)`"));
    Some(Shape::Box { min: min?, max: max?, cells })
}

fn point_set(reader: &mut Reader<'_>, node: &Node) -> Option<Shape> {
    let points = reader.points(node)?;
    if points.is_empty() {
        reader.bad(node, "an object needs at least one point")
    } else {
        Some(Shape::Points(points))
    }
}

fn file(reader: &mut Reader<'_>, node: &Node) -> Option<Shape> {
    let path = reader.text(node, "the path of a file")?;
    if path.is_empty() || path.contains('\0') {
        return reader.bad(node, "a path must not be empty or hold a zero character");
    }
    Some(Shape::File(PathBuf::from(path)))
}

fn patch(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let degree = reader.field(fields, "degree", [3; 2], |reader, node| {
        let items: &[Node; 2] = reader.tuple(node, "two degrees `(u, v)`")?;
        let read = reader.each(items, |reader, item| match reader.count(item, 1)? {
            degree @ 1..=3 => u8::try_from(degree).ok(),
            other => reader.bad(item, format!("the degree of a patch is 1, 2 or 3, found {other}")),
        })?;
        read.try_into().ok()
    });
    let patch = reader.required(fields, "points", |reader, node| {
        let rows = reader.list(node, "rows of points `[[(x, y, z), ..], ..]`")?;
        let nets = reader.each(rows, Reader::points)?;
        let error = match Patch::new(degree, &nets) {
            Ok(patch) => return Some(patch),
            Err(error) => error,
        };
        let at = match error {
            PatchError::Ragged { row, .. } => rows.get(row).unwrap_or(node),
            PatchError::TooFew { along: 'v', .. } => rows.first().unwrap_or(node),
            _ => node,
        };
        reader.bad(at, error.to_string())
    });
    let tessellation = reader
        .field(fields, "tessellation", [32; 2], |r, node| counts(r, node, [1; 2], "two counts `(u, v)`"));
    Some(Shape::Patch { patch: patch?, tessellation })
}
