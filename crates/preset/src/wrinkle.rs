//! \[SF98\] §5.1 as a preset: `Wrinkle(pattern: Tangential, creases: 5, thickness: .., ..)`.

use wirework_core::Keyed;
use wirework_wrinkle::{
    Branches, Curtain, Drawn, Layout, Motion, Pattern, Rail, Strain, Wrinkle, WrinkleError,
};

use crate::curve::keyed_curve;
use crate::deform::blend;
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};

/// The patterns by name; the first is the format's default.
const PATTERNS: [&str; 5] = ["Tangential", "Radial", "Ripple", "Drawn", "Auto"];
/// The fields that place and count the creases of all patterns but `Drawn`.
const LAYOUT: [&str; 4] = ["center", "direction", "size", "creases"];

/// Reads the fields of `Wrinkle` that are its own.
pub(crate) fn wrinkle(
    reader: &mut Reader<'_>,
    fields: &mut Fields<'_>,
    clock: &mut Clock,
) -> Option<Wrinkle> {
    let pattern = pattern(reader, fields, clock);
    let rest = Wrinkle::drawn(Vec::new());
    let number = |reader: &mut Reader<'_>, fields: &mut Fields<'_>, key, default| {
        reader.field(fields, key, default, |reader, node| reader.number(node, Within::Unit))
    };
    let keyed = |reader: &mut Reader<'_>, fields: &mut Fields<'_>, key, default: &Keyed<f32>, within| {
        reader.field(fields, key, default.clone(), |reader, node| reader.keyed_number(node, within))
    };
    let thickness = keyed(reader, fields, "thickness", &rest.thickness, Within::Positive);
    let intensity = keyed(reader, fields, "intensity", &rest.intensity, Within::Finite);
    let stiffness = number(reader, fields, "stiffness", rest.stiffness);
    let resistance = number(reader, fields, "resistance", rest.resistance);
    let propagation = keyed(reader, fields, "propagation", &rest.propagation, Within::Unit);
    for track in [&thickness, &intensity, &propagation] {
        clock.track(track);
    }
    let compression =
        reader.optional(fields, "compression", |reader, node| reader.number(node, Within::BelowOne));
    if compression.is_some() {
        unused(reader, fields, &["intensity"], "where `compression` sets the height");
    }
    let motion = reader.field(fields, "motion", Motion::Anchored, |reader, node| motion(reader, node, clock));
    let hangs = matches!(motion, Motion::Curtain(_));
    for (key, track) in
        [("intensity", &intensity), ("propagation", &propagation)].into_iter().filter(|_| !hangs)
    {
        if let Some(node) = fields.again(key).filter(|_| track.values().all(|&value| value == 0.0)) {
            reader.within(key, |reader| reader.warn(&node.span, format!("with `{key}` 0 nothing moves")));
        }
    }
    if motion != Motion::Anchored {
        clock.flows();
    }
    let drive = reader.optional(fields, "drive", strain);
    if drive.is_some() {
        clock.follows();
    }
    let wrinkle = Wrinkle {
        drive,
        pattern: pattern.clone().unwrap_or(rest.pattern),
        thickness,
        intensity,
        stiffness,
        resistance,
        propagation,
        randomness: number(reader, fields, "randomness", rest.randomness),
        seed: reader.field(fields, "seed", rest.seed, |reader, node| reader.count(node, 0)),
        motion,
        compression,
        blend: reader.field(fields, "blend", rest.blend, blend),
    };
    pattern?;
    whole(reader, fields, wrinkle)
}

/// Refuses more creases than can be laid, and what does not go together.
fn whole(reader: &mut Reader<'_>, fields: &Fields<'_>, wrinkle: Wrinkle) -> Option<Wrinkle> {
    let (error, keys): (WrinkleError, &[&str]) = match wrinkle.check() {
        Err(error @ WrinkleError::TooMany { .. }) => (error, &["branches", "creases", "pattern"]),
        Err(error @ WrinkleError::Undriven) => (error, &["pattern"]),
        Err(error @ WrinkleError::DrivenMoves) => (error, &["motion", "pattern", "drive"]),
        Err(error @ (WrinkleError::ClosedRopes | WrinkleError::Value { .. })) => {
            (error, &["motion", "pattern"])
        }
        _ => return Some(wrinkle),
    };
    let key = keys.iter().copied().find(|key| fields.again(key).is_some())?;
    let node = fields.again(key)?;
    reader.within(key, |reader| reader.bad(node, error.to_string()))
}

/// Warns of fields that do nothing where they differ from what is typed by default.
fn unused(reader: &mut Reader<'_>, fields: &Fields<'_>, keys: &[&'static str], why: &str) {
    for key in keys {
        if let Some(node) = fields.again(key) {
            reader.within(*key, |reader| reader.warn(&node.span, format!("`{key}` has no effect {why}")));
        }
    }
}

/// The pattern, and the fields that place and count its creases.
fn pattern(reader: &mut Reader<'_>, fields: &mut Fields<'_>, clock: &mut Clock) -> Option<Pattern> {
    let center = reader.field(fields, "center", [0.0; 3], Reader::point);
    let direction = reader.field(fields, "direction", [1.0, 0.0, 0.0], Reader::direction);
    let size = reader.field(fields, "size", [1.0; 2], Reader::size);
    let creases = reader.field(fields, "creases", 5, |reader, node| {
        let count = reader.count(node, 1)?;
        Some(u32::try_from(count).unwrap_or(u32::MAX))
    });
    let layout = Layout { center, direction, size, creases };
    let branches = reader.field(fields, "branches", Branches::default(), branches);
    let mut given = true;
    let named = reader.field(fields, "pattern", Pattern::Tangential(layout), |reader, node| {
        let pattern = named(reader, node, layout, branches, clock);
        given = pattern.is_some();
        pattern
    });
    let spare = |key: &&'static str| {
        let default = Layout { center: [0.0; 3], direction: [1.0, 0.0, 0.0], size: [1.0; 2], creases: 5 };
        match *key {
            "center" => layout.center != default.center,
            "direction" => layout.direction != default.direction,
            "size" => layout.size != default.size,
            _ => layout.creases != default.creases,
        }
    };
    let (auto, drawn) = (matches!(named, Pattern::Auto { .. }), matches!(named, Pattern::Drawn(_)));
    if auto || drawn {
        let spare: Vec<&'static str> =
            LAYOUT.into_iter().filter(spare).filter(|key| drawn || *key != "creases").collect();
        unused(
            reader,
            fields,
            &spare,
            if drawn { "on drawn creases" } else { "on creases that are looked for" },
        );
    }
    if given && !matches!(named, Pattern::Radial(..)) && branches != Branches::default() {
        unused(reader, fields, &["branches"], "but on radial creases");
    }
    given.then_some(named)
}

fn named(
    reader: &mut Reader<'_>,
    node: &Node,
    layout: Layout,
    branches: Branches,
    clock: &mut Clock,
) -> Option<Pattern> {
    if node.name() == Some("Drawn") {
        return drawn(reader, node, clock).map(Pattern::Drawn);
    }
    let patterns = [
        (PATTERNS[0], Some(Pattern::Tangential(layout))),
        (PATTERNS[1], Some(Pattern::Radial(layout, branches))),
        (PATTERNS[2], Some(Pattern::Ripple(layout))),
        (PATTERNS[3], None),
        (PATTERNS[4], Some(Pattern::Auto { creases: layout.creases })),
    ];
    reader.choice(node, "pattern", &patterns)?
}

/// `Drawn([curve, ..])`, each with points that may move.
fn drawn(reader: &mut Reader<'_>, node: &Node, clock: &mut Clock) -> Option<Vec<Drawn>> {
    const EXPECTED: &str = "`Drawn([curve, ..])`";
    let items = match &node.body {
        Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], EXPECTED)?,
        _ => return reader.bad(node, format!("expected {EXPECTED}")),
    };
    if items.is_empty() {
        return reader.bad(node, "`Drawn` needs at least one curve");
    }
    reader.each(items, |reader, item| {
        let (curve, points) = keyed_curve(reader, item)?;
        if let Some(points) = &points {
            clock.track(points);
        }
        Some(Drawn { curve, points })
    })
}

/// `(count: 3, depth: 1)`.
fn branches(reader: &mut Reader<'_>, node: &Node) -> Option<Branches> {
    if !matches!(node.body, Body::Fields(_)) {
        return reader.mismatch(node, "`(count: 3, depth: 1)`");
    }
    let mut fields = reader.fields(node, "branches")?;
    let mut number = |reader: &mut Reader<'_>, key| {
        reader.field(&mut fields, key, 0, |reader, node| {
            Some(u32::try_from(reader.count(node, 0)?).unwrap_or(u32::MAX))
        })
    };
    let (count, depth) = (number(reader, "count"), number(reader, "depth"));
    reader.finish(fields);
    if (count == 0) != (depth == 0) {
        reader.warn(&node.span, "branches need a `count` and a `depth` greater than 0");
    }
    Some(Branches { count, depth })
}

/// `Strain(from: 0.02, to: 0.2, radius: None, settle: 0.1)`.
fn strain(reader: &mut Reader<'_>, node: &Node) -> Option<Strain> {
    if node.name() != Some("Strain") {
        let drives = [("Strain", None)];
        return if node.name.is_some() {
            reader.choice(node, "drive", &drives)?
        } else {
            reader.mismatch(node, "`None` or `Strain(..)`")
        };
    }
    if matches!(node.body, Body::Bare) {
        return Some(Strain::default());
    }
    let rest = Strain::default();
    let mut fields = reader.fields(node, "Strain")?;
    let from =
        reader.field(&mut fields, "from", rest.from, |reader, node| reader.number(node, Within::BelowOne));
    let to = reader.field(&mut fields, "to", rest.to, |reader, node| {
        let to = reader.number(node, Within::Unit)?;
        if to > from {
            Some(to)
        } else {
            reader.bad(node, format!("`to` must be greater than `from`, {from}, found {to}"))
        }
    });
    let radius = reader.optional(&mut fields, "radius", |reader, node| reader.number(node, Within::Positive));
    let settle = reader
        .field(&mut fields, "settle", rest.settle, |reader, node| reader.number(node, Within::NotNegative));
    if let Some(node) = fields.again("from").filter(|_| fields.again("to").is_none() && to <= from) {
        let message =
            format!("`from` must be less than `to`, which is {to} where it is not given; found {from}");
        return reader.within("from", |reader| reader.bad(node, message));
    }
    reader.finish(fields);
    Some(Strain { from, to, radius, settle })
}

/// `Anchored`, `Travelling(velocity: (along, across))` or `Curtain(..)`.
fn motion(reader: &mut Reader<'_>, node: &Node, clock: &mut Clock) -> Option<Motion> {
    match node.name() {
        Some("Travelling") => travelling(reader, node),
        Some("Curtain") => curtain(reader, node, clock).map(|curtain| Motion::Curtain(Box::new(curtain))),
        _ => {
            let motions = [("Anchored", Some(Motion::Anchored)), ("Travelling", None), ("Curtain", None)];
            reader.choice(node, "motion", &motions)?
        }
    }
}

fn travelling(reader: &mut Reader<'_>, node: &Node) -> Option<Motion> {
    if !matches!(node.body, Body::Fields(_)) {
        return reader.mismatch(node, "`Travelling(velocity: (along, across))`");
    }
    let mut fields = reader.fields(node, "Travelling")?;
    let velocity = reader.required(&mut fields, "velocity", |reader, node| {
        let items: &[Node; 2] = reader.tuple(node, "metres a second `(along, across)`")?;
        reader.each(items, |reader, item| reader.number(item, Within::Finite))?.try_into().ok()
    });
    reader.finish(fields);
    let velocity: [f32; 2] = velocity?;
    if velocity == [0.0; 2] {
        reader.warn(&node.span, "with a velocity of 0 the creases stay");
    }
    Some(Motion::Travelling { velocity })
}

/// `Curtain(rail: None, gravity: (0, -9.81, 0), damping: 1.5, ..)`.
fn curtain(reader: &mut Reader<'_>, node: &Node, clock: &mut Clock) -> Option<Curtain> {
    let rest = Curtain::default();
    if matches!(node.body, Body::Bare) {
        return Some(rest);
    }
    let mut fields = reader.fields(node, "Curtain")?;
    let rail = reader.optional(&mut fields, "rail", |reader, node| {
        let (curve, points) = keyed_curve(reader, node)?;
        let points = points.unwrap_or_else(|| Keyed::Constant(curve.points().to_vec()));
        clock.track(&points);
        Some(Rail { curve, points })
    });
    let wind = reader.field(&mut fields, "wind", rest.wind, |reader, node| {
        let wind = reader.keyed(node, "a vector `(x, y, z)`", Reader::point)?;
        clock.track(&wind);
        Some(wind)
    });
    let curtain = Curtain {
        rail,
        wind,
        gravity: reader.field(&mut fields, "gravity", rest.gravity, Reader::point),
        damping: reader.field(&mut fields, "damping", rest.damping, |reader, node| {
            reader.number(node, Within::NotNegative)
        }),
        gusts: reader
            .field(&mut fields, "gusts", rest.gusts, |reader, node| reader.number(node, Within::Unit)),
        stiffness: reader.field(&mut fields, "stiffness", rest.stiffness, |reader, node| {
            reader.number(node, Within::Unit)
        }),
        settle: reader.field(&mut fields, "settle", rest.settle, |reader, node| {
            reader.number(node, Within::NotNegative)
        }),
    };
    reader.finish(fields);
    Some(curtain)
}
