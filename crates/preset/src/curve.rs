//! Curves and densities as typed: `BSpline(degree: 3, points: [..], closed: false)`, `Quartic`, `Profile([..])`.

use wirework_core::{Curve, CurveError, CurveKind, Density, Profile, ProfileError};

use crate::keyed_wire::Points;
use crate::moments::key_nodes;
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};

/// The kinds of curves.
pub(crate) const CURVES: [&str; 4] = ["BSpline", "Polyline", "CatmullRom", "Bezier"];

/// Degree of a B-spline where none is given: cubic.
const DEFAULT_DEGREE: u8 = 3;

/// A curve. `points` may also stand alone: `Polyline([..])`.
pub(crate) fn curve(reader: &mut Reader<'_>, node: &Node) -> Option<Curve> {
    of_points(reader, node, build)
}

/// A curve, and its control points where they have keys.
pub(crate) fn keyed_curve(reader: &mut Reader<'_>, node: &Node) -> Option<(Curve, Option<Points>)> {
    of_points(reader, node, |reader, owner, degree, closed, node| {
        if node.name.is_none() {
            return Some((build(reader, owner, degree, closed, node)?, None));
        }
        let points = reader.keyed_points(node, "a key", None)?;
        for (_, value) in key_nodes(node) {
            build(reader, owner, degree, closed, value)?;
        }
        let curve = Curve::new(kind(owner, degree), closed, points.at(0.0)).ok()?;
        Some((curve, Some(points)))
    })
}

/// What `build` makes of the kind, degree, closedness and points of a curve.
fn of_points<T>(
    reader: &mut Reader<'_>,
    node: &Node,
    build: impl Fn(&mut Reader<'_>, &str, u8, bool, &Node) -> Option<T>,
) -> Option<T> {
    let Some(name) = &node.name else {
        return reader.mismatch(node, &format!("a curve such as `{}(points: [(x, y, z), ..])`", CURVES[0]));
    };
    let Some(owner) = CURVES.iter().copied().find(|curve| *curve == name.text) else {
        reader.unknown_name(name, "curve", &CURVES);
        return None;
    };
    if let Body::Tuple(items) = &node.body
        && let [points] = items.as_slice()
        && (matches!(points.body, Body::List(_)) || points.name.is_some())
    {
        return build(reader, owner, DEFAULT_DEGREE, false, points);
    }
    let mut fields = reader.unnamed_fields(node, owner)?;
    let degree = if owner == "BSpline" { degree(reader, &mut fields) } else { DEFAULT_DEGREE };
    let closed = reader.field(&mut fields, "closed", false, Reader::flag);
    let curve =
        reader.required(&mut fields, "points", |reader, points| build(reader, owner, degree, closed, points));
    reader.finish(fields);
    curve
}

/// The field `degree` of a B-spline.
pub(crate) fn degree(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> u8 {
    reader.field(fields, "degree", DEFAULT_DEGREE, |reader, node| reader.degree(node, "a B-spline"))
}

fn kind(owner: &str, degree: u8) -> CurveKind {
    match owner {
        "BSpline" => CurveKind::BSpline { degree },
        "Polyline" => CurveKind::Polyline,
        "CatmullRom" => CurveKind::CatmullRom,
        _ => CurveKind::Bezier,
    }
}

fn build(reader: &mut Reader<'_>, owner: &str, degree: u8, closed: bool, node: &Node) -> Option<Curve> {
    let points = reader.points(node)?;
    match Curve::new(kind(owner, degree), closed, points) {
        Ok(curve) => Some(curve),
        Err(CurveError::NotFinite { index }) => {
            let Body::List(items) = &node.body else { return None };
            reader.bad(items.get(index).unwrap_or(node), "a control point must be finite")
        }
        Err(error) => reader.bad(node, error.to_string()),
    }
}

/// A density.
pub(crate) fn density(reader: &mut Reader<'_>, node: &Node) -> Option<Density> {
    if node.name() == Some("Profile") {
        return profile(reader, node).map(Density::Profile);
    }
    let names = [
        ("Quartic", Some(Density::Quartic)),
        ("Sextic", Some(Density::Sextic)),
        ("Smoothstep", Some(Density::Smoothstep)),
        ("Linear", Some(Density::Linear)),
        ("Profile", None),
    ];
    reader.choice(node, "density", &names)?
}

fn profile(reader: &mut Reader<'_>, node: &Node) -> Option<Profile> {
    const EXPECTED: &str = "`Profile([(x, f), ..])`";
    let items = match &node.body {
        Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], EXPECTED)?,
        _ => return reader.bad(node, format!("expected {EXPECTED}")),
    };
    let points = reader.each(items, |reader, item| {
        let [x, f]: &[Node; 2] = reader.tuple(item, "a point `(x, f)`")?;
        let (x, f) = (reader.seconds(x, Within::Unit), reader.seconds(f, Within::Unit));
        Some((x?, f?))
    })?;
    let error = match Profile::new(&points) {
        Ok(profile) => return Some(profile),
        Err(error) => error,
    };
    let index = match error {
        ProfileError::Outside { index } | ProfileError::Order { index } | ProfileError::Ends { index } => {
            index
        }
        _ => items.len(),
    };
    reader.bad(items.get(index).unwrap_or(node), error.to_string())
}
