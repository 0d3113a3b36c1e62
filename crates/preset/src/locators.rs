//! \[SF98\] §3.1 as a preset: `Locator(u: 0.5, radius: .., ..)`, and the attributes that wires and locators share.

use crate::direction::keyed_direction;
use crate::keyed_wire::{ATTRIBUTES, Values};
use crate::read::{Fields, Reader, Within};
use crate::tree::Node;

impl Values {
    /// The numbers that a wire of any kind has.
    pub(crate) fn read(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Self {
        let mut number =
            |key, within| reader.optional(fields, key, |reader, node| reader.keyed_number(node, within));
        Self {
            radius: number("radius", Within::Positive),
            scale: number("scale", Within::Finite),
            rotation: number("rotation", Within::Finite),
            amplitude: number("amplitude", Within::Finite),
            twist: reader
                .optional(fields, "twist", |reader, node| reader.keyed_degrees(node, Within::Finite)),
            ..Self::default()
        }
    }

    /// All of them, with those of the directional dropoff.
    pub(crate) fn read_directed(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Self {
        let numbers = Self::read(reader, fields);
        let direction = reader.optional(fields, "direction", keyed_direction);
        let angle =
            reader.optional(fields, "angle", |reader, node| reader.keyed_degrees(node, Within::Positive));
        Self { angle, direction, ..numbers }
    }
}

/// Locators by rising `u`, each with what it carries.
pub(crate) fn locators(reader: &mut Reader<'_>, node: &Node) -> Option<Vec<(f32, Values)>> {
    let items = reader.list(node, "a list of locators `[Locator(u: .., ..), ..]`")?;
    // The last place, and what the locators there carry.
    let mut last: Option<(f32, [bool; ATTRIBUTES.len()])> = None;
    reader.each(items, |reader, item| {
        let mut fields = reader.fields(item, "Locator")?;
        let u = reader.required(&mut fields, "u", |reader, node| {
            let u = reader.number(node, Within::Unit)?;
            match last {
                Some((last, _)) if u < last => reader.bad(
                    node,
                    format!("locators stand by rising `u`; the one before is at {last}, this one at {u}"),
                ),
                _ => Some(u),
            }
        });
        let values = Values::read_directed(reader, &mut fields);
        reader.finish(fields);
        let u = u?;
        let (here, carried) = (values.carried(), last.filter(|(at, _)| *at == u));
        let before = carried.map_or([false; ATTRIBUTES.len()], |(_, carried)| carried);
        last = Some((u, std::array::from_fn(|i| before[i] || here[i])));
        let mut twice = ATTRIBUTES.into_iter().zip(before).zip(here).filter(|((_, a), b)| *a && *b);
        match twice.next() {
            None => Some((u, values)),
            Some(((attribute, _), _)) => {
                reader.bad(item, format!("another locator at u = {u} carries `{attribute}` already"))
            }
        }
    })
}

/// An attribute of the wire that is written down and then overridden along its whole length.
pub(crate) fn lint_overridden(reader: &mut Reader<'_>, fields: &mut Fields<'_>, locators: &[(f32, Values)]) {
    for (i, key) in ATTRIBUTES.into_iter().enumerate() {
        let carried =
            locators.iter().any(|(_, values)| values.carried().get(i).is_some_and(|carried| *carried));
        if let Some(node) = fields.again(key).filter(|node| carried && !node.is_bare("None")) {
            let message =
                format!("the wire's `{key}` has no effect: locators override it along the whole wire");
            reader.within(key, |reader| reader.warn(&node.span, message));
        }
    }
}
