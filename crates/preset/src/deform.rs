//! \[SF98\] §2 to §4 as a preset: `Deform(wires: [Wire(..), ..], blend: Blend(..))`.

use std::collections::BTreeMap;
use std::ops::Range;

use wirework_core::{Bend, Blend, Correspondence, Curve, Density, Interpolation, Keyed, Locator, Wire};

use crate::curve::{curve, density};
use crate::later;
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::tree::Node;

/// Wires and how they blend.
#[derive(Clone, Debug, PartialEq)]
pub struct Deform {
    /// The wires, in the order of the preset.
    pub wires: Vec<KeyedWire>,
    /// How their displacements become one.
    pub blend: Blend,
}

/// A wire that moves in time. Made by reading a preset, so that all its values are good at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedWire {
    /// The wire with everything that does not move.
    fixed: Wire,
    pose: Keyed<Vec<[f32; 3]>>,
    /// The wire's own values, every one of them.
    values: Values,
    locators: Vec<Values>,
}

/// The attributes that both a wire and its locators have. `None`: not carried.
#[derive(Clone, Debug, Default, PartialEq)]
struct Values {
    radius: Option<Keyed<f32>>,
    scale: Option<Keyed<f32>>,
    rotation: Option<Keyed<f32>>,
    amplitude: Option<Keyed<f32>>,
    twist: Option<Keyed<f32>>,
}

/// Names of the attributes, in the order of [`Values::all`].
const ATTRIBUTES: [&str; 5] = ["radius", "scale", "rotation", "amplitude", "twist"];

impl Values {
    fn all(&self) -> [Option<&Keyed<f32>>; 5] {
        [&self.radius, &self.scale, &self.rotation, &self.amplitude, &self.twist].map(Option::as_ref)
    }

    /// What is missing is as in `wire`.
    fn or(self, wire: &Wire) -> Self {
        let or = |value: Option<Keyed<f32>>, default| value.or(Some(Keyed::Constant(default)));
        Self {
            radius: or(self.radius, wire.radius),
            scale: or(self.scale, wire.scale),
            rotation: or(self.rotation, wire.rotation),
            amplitude: or(self.amplitude, wire.amplitude),
            twist: or(self.twist, wire.twist),
        }
    }

    fn read(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Self {
        let mut number =
            |key, within| reader.optional(fields, key, |reader, node| reader.keyed_number(node, within));
        Self {
            radius: number("radius", Within::Positive),
            scale: number("scale", Within::Finite),
            rotation: number("rotation", Within::Finite),
            amplitude: number("amplitude", Within::Finite),
            twist: reader.optional(fields, "twist", Reader::keyed_degrees),
        }
    }
}

impl KeyedWire {
    /// `R`, which does not move.
    pub fn reference(&self) -> &Curve {
        &self.fixed.reference
    }

    /// The wire at a time in seconds.
    pub fn at(&self, seconds: f64) -> Wire {
        let mut wire = self.fixed.clone();
        self.at_into(seconds, &mut wire);
        wire
    }

    /// Moves a wire that [`KeyedWire::at`] made to another time. Its reference curve stays untouched.
    pub fn at_into(&self, seconds: f64, wire: &mut Wire) {
        if self.pose.last_key().is_some() {
            wire.pose = self.pose.at(seconds);
        }
        let Values { radius, scale, rotation, amplitude, twist } = &self.values;
        for (keyed, value) in [
            (radius, &mut wire.radius),
            (scale, &mut wire.scale),
            (rotation, &mut wire.rotation),
            (amplitude, &mut wire.amplitude),
            (twist, &mut wire.twist),
        ] {
            if let Some(keyed) = keyed {
                *value = keyed.at(seconds);
            }
        }
        for (keyed, locator) in self.locators.iter().zip(&mut wire.locators) {
            let now = |value: &Option<Keyed<f32>>| value.as_ref().map(|value| value.at(seconds));
            *locator = Locator {
                u: locator.u,
                radius: now(&keyed.radius),
                scale: now(&keyed.scale),
                rotation: now(&keyed.rotation),
                amplitude: now(&keyed.amplitude),
                twist: now(&keyed.twist),
                ..*locator
            };
        }
    }

    /// Tells a clock every track.
    fn time(&self, clock: &mut Clock) {
        clock.track(&self.pose);
        for values in [&self.values].into_iter().chain(&self.locators) {
            values.all().into_iter().flatten().for_each(|track| clock.track(track));
        }
    }

    /// Whether the wire leaves the object as it is at all times.
    fn is_still(&self) -> bool {
        let all = |get: fn(&Values) -> &Option<Keyed<f32>>, rest: f32| {
            [&self.values].into_iter().chain(&self.locators).all(|values| {
                get(values).as_ref().is_none_or(|track| track.values().all(|&value| value == rest))
            })
        };
        let pose = self.pose.values().all(|points| points == self.fixed.reference.points());
        all(|v| &v.amplitude, 0.0) || (pose && all(|v| &v.scale, 1.0) && all(|v| &v.twist, 0.0))
    }
}

/// Reads the fields of `Deform` that are its own.
pub(crate) fn deform(reader: &mut Reader<'_>, fields: &mut Fields<'_>, clock: &mut Clock) -> Option<Deform> {
    let blend = reader.field(fields, "blend", Blend::default(), blend);
    let mut groups = Groups::default();
    let wires = reader.required(fields, "wires", |reader, node| {
        let items = reader.list(node, "a list of wires `[Wire(..), ..]`")?;
        if items.is_empty() {
            return reader.bad(node, "`wires` needs at least one wire");
        }
        let wires = reader.each(items, |reader, item| wire(reader, item, &mut groups))?;
        // A still wire is an anchor where the blend is local.
        if blend.localize == 0.0 {
            for (i, (_, item)) in wires.iter().zip(items).enumerate().filter(|(_, (wire, _))| wire.is_still())
            {
                let why = "its pose is its curve, its scale 1 and its twist 0, or its amplitude is 0";
                let message = format!("this wire moves nothing: {why}");
                reader.within(format!("[{i}]"), |reader| reader.warn(&head(item), message));
            }
        }
        Some(wires)
    })?;
    groups.lint(reader);
    for wire in &wires {
        wire.time(clock);
    }
    Some(Deform { wires, blend })
}

/// The name of a node, or else its first byte: a caret under a whole wire would be many lines long.
fn head(node: &Node) -> Range<usize> {
    node.name.as_ref().map_or(node.span.start..node.span.start + 1, |name| name.span.clone())
}

/// Group names by number, in the order of their first use.
#[derive(Default)]
struct Groups(BTreeMap<String, (u32, usize, Range<usize>)>);

impl Groups {
    fn number(&mut self, name: &str, span: &Range<usize>) -> u32 {
        let next = u32::try_from(self.0.len()).unwrap_or(u32::MAX);
        let group = self.0.entry(name.to_owned()).or_insert((next, 0, span.clone()));
        group.1 += 1;
        group.0
    }

    fn lint(&self, reader: &mut Reader<'_>) {
        for (name, (_, wires, span)) in &self.0 {
            if *wires == 1 {
                let name = crate::error::escape(name);
                reader.warn(span, format!("the group \"{name}\" has only this wire, so it changes nothing"));
            }
        }
    }
}

fn wire(reader: &mut Reader<'_>, node: &Node, groups: &mut Groups) -> Option<KeyedWire> {
    if let Some(name) = &node.name {
        if later::WIRES.contains(&name.text.as_str()) {
            later::refuse(reader, node, &name.text, None);
            return None;
        }
        if name.text != "Wire" {
            reader.unknown_name(name, "wire", &[&["Wire"], later::WIRES].concat());
            return None;
        }
    }
    let mut fields = reader.fields(node, "Wire")?;
    let reference = reader.required(&mut fields, "curve", curve);
    let count = reference.as_ref().map(|curve| curve.points().len());
    let pose = reader.optional(&mut fields, "pose", |reader, node| pose(reader, node, count));
    let values = Values::read(reader, &mut fields);
    let density = reader.field(&mut fields, "density", Density::Quartic, density);
    let located = reader.field(&mut fields, "locators", Vec::new(), locators);
    lint_overridden(reader, &mut fields, &located);
    let interpolation = reader.field(&mut fields, "interpolation", Interpolation::Linear, |reader, node| {
        let names = [("Linear", Interpolation::Linear), ("Smooth", Interpolation::Smooth)];
        reader.choice(node, "interpolation", &names)
    });
    let correspondence =
        reader.field(&mut fields, "correspondence", Correspondence::Parameter, |reader, node| {
            let names = [("Parameter", Correspondence::Parameter), ("ArcLength", Correspondence::ArcLength)];
            reader.choice(node, "correspondence", &names)
        });
    let bend = reader.field(&mut fields, "bend", Bend::Tangent, |reader, node| {
        reader.choice(node, "bend", &[("Tangent", Bend::Tangent), ("Transport", Bend::Transport)])
    });
    let group = reader.optional(&mut fields, "group", |reader, node| {
        reader.text(node, "the name of a group").map(|name| groups.number(name, &node.span))
    });
    let exponent =
        reader.optional(&mut fields, "exponent", |reader, node| reader.number(node, Within::Finite));
    reader.finish(fields);
    let (at, locators): (Vec<f32>, Vec<Values>) = located.into_iter().unzip();
    let locators_at_rest = at.into_iter().map(|u| Locator { u, ..Locator::default() }).collect();
    let mut rest = Wire::new(reference?);
    let pose = pose.unwrap_or_else(|| Keyed::Constant(rest.pose.clone()));
    rest.pose = pose.at(0.0);
    let values = values.or(&rest);
    let fixed = Wire {
        density,
        locators: locators_at_rest,
        interpolation,
        correspondence,
        bend,
        group,
        exponent,
        ..rest
    };
    Some(KeyedWire { fixed, pose, values, locators })
}

/// The control points of `W`, as many as the curve has.
fn pose(reader: &mut Reader<'_>, node: &Node, count: Option<usize>) -> Option<Keyed<Vec<[f32; 3]>>> {
    reader.keyed(node, "a list of points", |reader, value| {
        let points = reader.points(value)?;
        match count {
            Some(count) if count != points.len() => {
                let found = points.len();
                reader.bad(value, format!("a pose has as many points as its curve, {count}; found {found}"))
            }
            _ => Some(points),
        }
    })
}

/// Locators by rising `u`, each with what it carries.
fn locators(reader: &mut Reader<'_>, node: &Node) -> Option<Vec<(f32, Values)>> {
    let items = reader.list(node, "a list of locators `[Locator(u: .., ..), ..]`")?;
    let mut before: Vec<(f32, Values)> = Vec::new();
    reader.each(items, |reader, item| {
        let mut fields = reader.fields(item, "Locator")?;
        let u = reader.required(&mut fields, "u", |reader, node| {
            let u = reader.number(node, Within::Unit)?;
            match before.last() {
                Some((last, _)) if u < *last => reader.bad(
                    node,
                    format!("locators stand by rising `u`; the one before is at {last}, this one at {u}"),
                ),
                _ => Some(u),
            }
        });
        let values = Values::read(reader, &mut fields);
        reader.finish(fields);
        let u = u?;
        let twice = before.iter().rev().take_while(|(other, _)| *other == u).find_map(|(_, other)| {
            let both =
                other.all().into_iter().zip(values.all()).position(|(a, b)| a.is_some() && b.is_some())?;
            ATTRIBUTES.get(both)
        });
        before.push((u, values.clone()));
        match twice {
            None => Some((u, values)),
            Some(attribute) => {
                reader.bad(item, format!("another locator at u = {u} carries `{attribute}` already"))
            }
        }
    })
}

/// An attribute of the wire that is written down and then overridden along its whole length.
fn lint_overridden(reader: &mut Reader<'_>, fields: &mut Fields<'_>, locators: &[(f32, Values)]) {
    for (i, key) in ATTRIBUTES.into_iter().enumerate() {
        let carried = locators.iter().any(|(_, values)| values.all().get(i).is_some_and(Option::is_some));
        if let Some(node) = fields.again(key).filter(|_| carried) {
            let message =
                format!("the wire's `{key}` has no effect: locators override it along the whole wire");
            reader.within(key, |reader| reader.warn(&node.span, message));
        }
    }
}

/// `Blend(exponent, crossing, localize, locality)`.
pub(crate) fn blend(reader: &mut Reader<'_>, node: &Node) -> Option<Blend> {
    let mut fields = reader.fields(node, "Blend")?;
    let rest = Blend::default();
    let blend = Blend {
        exponent: reader
            .field(&mut fields, "exponent", rest.exponent, |r, node| r.number(node, Within::Finite)),
        crossing: reader
            .field(&mut fields, "crossing", rest.crossing, |r, node| r.number(node, Within::Unit)),
        localize: reader
            .field(&mut fields, "localize", rest.localize, |r, node| r.number(node, Within::Unit)),
        // A negative k would let F → 0 outweigh everything.
        locality: reader
            .field(&mut fields, "locality", rest.locality, |r, node| r.number(node, Within::NotNegative)),
    };
    reader.finish(fields);
    Some(blend)
}
