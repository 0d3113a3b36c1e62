//! \[SF98\] §2, §3 as a preset: `Wire(curve: .., pose: .., ..)`.

use std::f32::consts::PI;

use wirework_core::{Bend, Correspondence, Density, Domain, Interpolation, Keyed, Locator, Wire};

use crate::curve::{curve, density};
use crate::deform::Groups;
use crate::direction::check_directions;
use crate::domain::{check_domains, domains, lint_bounds};
use crate::keyed_wire::{KeyedWire, Values};
use crate::locators::{lint_overridden, locators};
use crate::read::{Fields, Reader, Within};
use crate::scope::{Mask, Only, scope};
use crate::tree::{Body, Entry, Node};

/// The fields that wires of any kind have beside their numbers.
pub(crate) struct Manner {
    density: Density,
    interpolation: Interpolation,
    correspondence: Correspondence,
    bend: Bend,
    width: Option<Keyed<f32>>,
    exponent: Option<f32>,
    pub(crate) only: Option<Only>,
    pub(crate) mask: Option<Mask>,
}

impl Manner {
    pub(crate) fn read(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Self {
        let density = reader.field(fields, "density", Density::Quartic, density);
        let interpolation = reader.field(fields, "interpolation", Interpolation::Linear, |reader, node| {
            let names = [("Linear", Interpolation::Linear), ("Smooth", Interpolation::Smooth)];
            reader.choice(node, "interpolation", &names)
        });
        let correspondence =
            reader.field(fields, "correspondence", Correspondence::Parameter, |reader, node| {
                let names =
                    [("Parameter", Correspondence::Parameter), ("ArcLength", Correspondence::ArcLength)];
                reader.choice(node, "correspondence", &names)
            });
        let bend = reader.field(fields, "bend", Bend::Tangent, |reader, node| {
            reader.choice(node, "bend", &[("Tangent", Bend::Tangent), ("Transport", Bend::Transport)])
        });
        let width = closest(reader, fields, |reader, node| reader.keyed_number(node, Within::Positive));
        let exponent =
            reader.optional(fields, "exponent", |reader, node| reader.number(node, Within::Finite));
        let (only, mask) = scope(reader, fields);
        Self { density, interpolation, correspondence, bend, width, exponent, only, mask }
    }

    /// `rest` with these fields, and nothing that moves but the numbers.
    pub(crate) fn wire(&self, rest: Wire, values: Values) -> KeyedWire {
        let values = values.or(&rest);
        let fixed = Wire {
            density: self.density.clone(),
            interpolation: self.interpolation,
            correspondence: self.correspondence,
            bend: self.bend,
            exponent: self.exponent,
            ..rest
        };
        KeyedWire {
            fixed,
            reference: None,
            pose: None,
            shifts: Vec::new(),
            values,
            locators: Vec::new(),
            domains: Vec::new(),
            width: self.width.clone(),
            only: self.only.clone(),
            mask: self.mask.clone(),
        }
    }
}

/// The width of `closest: Blended(width)` through `read`; none for `Smallest`.
pub(crate) fn closest<T>(
    reader: &mut Reader<'_>,
    fields: &mut Fields<'_>,
    read: impl FnOnce(&mut Reader<'_>, &Node) -> Option<T>,
) -> Option<T> {
    let node = fields.get("closest").filter(|node| !node.is_bare("Smallest"))?;
    reader.within("closest", |reader| {
        let Some(name) = &node.name else {
            return reader.mismatch(node, "`Smallest` or `Blended(width)`");
        };
        match (name.text.as_str(), &node.body) {
            ("Blended", Body::Tuple(items)) if items.len() == 1 => {
                let width = items.first()?;
                reader.within("width", |reader| read(reader, width))
            }
            ("Smallest", _) => reader.bad(node, "`Smallest` stands alone, without parentheses"),
            ("Blended", Body::Fields(entries)) => {
                let width = match entries.as_slice() {
                    [Entry { value: Node { body: Body::Number { value, .. }, .. }, .. }] => value.to_string(),
                    _ => "width".to_owned(),
                };
                reader.bad(node, format!("the width stands alone, without a name: `Blended({width})`"))
            }
            ("Blended", _) => reader.bad(node, "expected `Blended(width)`"),
            _ => {
                reader.unknown_name(name, "value of `closest`", &["Smallest", "Blended"]);
                None
            }
        }
    })
}

/// Reads a `Wire`; the name may be left out.
pub(crate) fn wire(reader: &mut Reader<'_>, node: &Node, groups: &mut Groups) -> Option<KeyedWire> {
    let mut fields = reader.fields(node, "Wire")?;
    let curve = reader.required(&mut fields, "curve", curve);
    let count = curve.as_ref().map(|curve| curve.points().len());
    let points = |reader: &mut Reader<'_>, fields: &mut Fields<'_>, key, what: &str| {
        reader.optional(fields, key, |reader, node| reader.keyed_points(node, what, count))
    };
    let pose = points(reader, &mut fields, "pose", "a pose");
    let values = Values::read_directed(reader, &mut fields);
    let located = reader.field(&mut fields, "locators", Vec::new(), locators);
    lint_overridden(reader, &mut fields, &located);
    lint_angle(reader, &fields, &values, &located);
    let domains = reader.field(&mut fields, "domains", Vec::new(), domains);
    let reference = points(reader, &mut fields, "reference", "a reference");
    let manner = Manner::read(reader, &mut fields);
    let group = reader.optional(&mut fields, "group", |reader, node| {
        reader.text(node, "the name of a group").map(|name| groups.number(name, &node.span))
    });
    let wire = curve.map(|curve| {
        let (at, locators): (Vec<f32>, Vec<Values>) = located.into_iter().unzip();
        let (curves, domains): (Vec<Domain>, Vec<_>) = domains.into_iter().unzip();
        let mut rest = Wire::new(curve);
        rest.locators = at.into_iter().map(|u| Locator { u, ..Locator::default() }).collect();
        rest.domains = curves;
        rest.group = group;
        KeyedWire { reference, pose, locators, domains, ..manner.wire(rest, values) }.settled()
    });
    if let Some(wire) = &wire {
        lint_bounds(reader, &fields, wire);
        // Where there is too much to look at the rest goes unchecked.
        let _ = check_directions(reader, &fields, wire).and_then(|()| check_domains(reader, &fields, wire));
    }
    reader.finish(fields);
    wire
}

/// An angle, other than the default, of a directional dropoff that there is not.
fn lint_angle(reader: &mut Reader<'_>, fields: &Fields<'_>, own: &Values, locators: &[(f32, Values)]) {
    let directed = own.direction.is_some() || locators.iter().any(|(_, values)| values.direction.is_some());
    // A bad direction is reported as such.
    if directed || fields.again("direction").is_some_and(|node| !node.is_bare("None")) {
        return;
    }
    let message = "`angle` has no effect without a `direction`";
    let default = |track: &Keyed<f32>| track.values().all(|angle| *angle == PI);
    let unused = |values: &Values| values.angle.as_ref().is_some_and(|angle| !default(angle));
    if let Some(node) = fields.again("angle").filter(|_| unused(own)) {
        reader.within("angle", |reader| reader.warn(&node.span, message));
    }
    let Some(Node { body: Body::List(items), .. }) = fields.again("locators") else { return };
    for (i, (item, (_, values))) in items.iter().zip(locators).enumerate() {
        let Some(angle) = item.field("angle").filter(|_| unused(values)) else { continue };
        reader.within("locators", |reader| {
            reader.within(format!("[{i}]"), |reader| {
                reader.within("angle", |reader| reader.warn(&angle.span, message));
            });
        });
    }
}
