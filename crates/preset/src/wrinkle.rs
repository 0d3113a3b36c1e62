//! \[SF98\] §5.1 as a preset: `Wrinkle(pattern: Drawn([..]), thickness: .., ..)`.

use wirework_core::{Curve, Keyed};
use wirework_wrinkle::Wrinkle;

use crate::curve::curve;
use crate::deform::blend;
use crate::later;
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::tree::Body;

/// Reads the fields of `Wrinkle` that are its own.
pub(crate) fn wrinkle(
    reader: &mut Reader<'_>,
    fields: &mut Fields<'_>,
    clock: &mut Clock,
) -> Option<Wrinkle> {
    unused_by_drawn(reader, fields);
    let curves = pattern(reader, fields);
    let rest = Wrinkle::drawn(curves.clone().unwrap_or_default());
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
    for (key, track) in [("intensity", &intensity), ("propagation", &propagation)] {
        if let Some(node) = fields.again(key).filter(|_| track.values().all(|&value| value == 0.0)) {
            reader.within(key, |reader| reader.warn(&node.span, format!("with `{key}` 0 nothing moves")));
        }
    }
    let wrinkle = Wrinkle {
        pattern: rest.pattern,
        thickness,
        intensity,
        stiffness,
        resistance,
        propagation,
        randomness: number(reader, fields, "randomness", rest.randomness),
        seed: reader.field(fields, "seed", rest.seed, |reader, node| reader.count(node, 0)),
        blend: reader.field(fields, "blend", rest.blend, blend),
    };
    curves.map(|_| wrinkle)
}

/// Checks the fields that place and count the creases of the generated patterns. Drawn creases lie where they are
/// drawn, so that here these fields do nothing.
fn unused_by_drawn(reader: &mut Reader<'_>, fields: &mut Fields<'_>) {
    let center = reader.field(fields, "center", [0.0; 3], Reader::point) == [0.0; 3];
    let along = reader.field(fields, "direction", [1.0, 0.0, 0.0], Reader::direction) == [1.0, 0.0, 0.0];
    let size = reader.field(fields, "size", [1.0; 2], Reader::size) == [1.0; 2];
    let creases = reader.field(fields, "creases", 5, |reader, node| reader.count(node, 1)) == 5;
    for (key, default) in [("center", center), ("direction", along), ("size", size), ("creases", creases)] {
        if let Some(node) = fields.again(key).filter(|_| !default) {
            let message = format!("`{key}` has no effect on drawn creases");
            reader.within(key, |reader| reader.warn(&node.span, message));
        }
    }
}

/// `Drawn([curve, ..])`. The format's default is a pattern that this version does not have, so it must be given.
fn pattern(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Vec<Curve>> {
    const EXPECTED: &str = "`Drawn([curve, ..])`";
    let hint = format!("write `pattern: {}`", EXPECTED.trim_matches('`'));
    reader.required(fields, "pattern", |reader, node| {
        let Some(name) = &node.name else {
            return reader.mismatch(node, EXPECTED);
        };
        if later::PATTERNS.contains(&name.text.as_str()) {
            later::refuse(reader, node, &name.text, Some(&hint));
            return None;
        }
        if name.text != "Drawn" {
            reader.unknown_name(name, "pattern", &[&["Drawn"], later::PATTERNS].concat());
            return None;
        }
        let items = match &node.body {
            Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], EXPECTED)?,
            _ => return reader.bad(node, format!("expected {EXPECTED}")),
        };
        if items.is_empty() {
            return reader.bad(node, "`Drawn` needs at least one curve");
        }
        reader.each(items, curve)
    })
}
