//! Objects as typed: `Grid(size: (2, 2), translation: (0, 1, 0))`.

use std::path::PathBuf;

use wirework_surface::{MAX_VERTICES, Patch, PatchError, Transform};

use super::{Object, PatchDeform, Shape};
use crate::deform::head;
use crate::error::PresetErrorKind;
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};

const SHAPES: [&str; 7] = ["Grid", "Tube", "Sphere", "Box", "Points", "Patch", "File"];

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
    within_limit(reader, node, shape.size().vertices, "this object has")?;
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

/// Refuses too many vertices before any is allocated. `who`: what has them, for instance `this object has`.
pub(crate) fn within_limit(reader: &mut Reader<'_>, node: &Node, count: u64, who: &str) -> Option<()> {
    let (limit, raise) = if reader.limits.vertices <= MAX_VERTICES {
        (reader.limits.vertices, "--max-vertices raises it")
    } else {
        (MAX_VERTICES, "no flag raises it")
    };
    if count <= limit {
        return Some(());
    }
    let message = format!("{who} {count} vertices, the limit is {limit} ({raise})");
    reader.error(PresetErrorKind::Limit, &head(node), message, None);
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
    let read = reader.each(items, |reader, item| count(reader, item, least.next().unwrap_or(1)))?;
    read.try_into().ok()
}

fn count(reader: &mut Reader<'_>, node: &Node, least: u64) -> Option<u32> {
    let count = reader.count(node, least)?;
    u32::try_from(count).ok().or_else(|| reader.bad(node, format!("{count} is too many")))
}

fn grid(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let size = reader.required(fields, "size", Reader::size);
    let cells =
        reader.field(fields, "cells", [32; 2], |r, node| counts(r, node, [1; 2], "two counts `(a, b)`"));
    let normal = reader.field(fields, "normal", [0.0, 1.0, 0.0], Reader::direction);
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
    let (min, max) = reader.corners(fields);
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
    reader.path(node, "the path of a file").map(|path| Shape::File(PathBuf::from(path)))
}

fn patch(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Shape> {
    let degree = reader.field(fields, "degree", [3; 2], |reader, node| {
        let items: &[Node; 2] = reader.tuple(node, "two degrees `(u, v)`")?;
        reader.each(items, |reader, item| reader.degree(item, "a patch"))?.try_into().ok()
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
    let deform = reader.field(fields, "deform", PatchDeform::Points, |reader, node| {
        let names = [("Points", PatchDeform::Points), ("ControlPoints", PatchDeform::ControlPoints)];
        reader.choice(node, "value of `deform`", &names)
    });
    Some(Shape::Patch { patch: patch?, tessellation, deform })
}
