//! \[SF98\] §2 to §4 as a preset: `Deform(wires: [Wire(..), ..], blend: Blend(..))`.

use std::collections::BTreeMap;
use std::ops::Range;

use wirework_core::{Blend, Lattice};

use crate::keyed_wire::KeyedWire;
use crate::lattice::{lattice, wire_lattice};
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};
use crate::wire::wire;

/// Wires and how they blend.
#[derive(Clone, Debug, PartialEq)]
pub struct Deform {
    /// The wires, in the order of the preset; those of a `WireLattice` along X, then Y, then Z.
    pub wires: Vec<KeyedWire>,
    /// How their displacements become one.
    pub blend: Blend,
    /// Where there is one, the wires move its control points, and it moves the object.
    pub lattice: Option<Lattice>,
}

/// Reads the fields of `Deform` that are its own.
pub(crate) fn deform(reader: &mut Reader<'_>, fields: &mut Fields<'_>, clock: &mut Clock) -> Option<Deform> {
    let blend = reader.field(fields, "blend", Blend::default(), blend);
    let given = fields.again("lattice").is_some();
    let lattice = reader.optional(fields, "lattice", lattice);
    let mut groups = Groups::default();
    let wires = reader.required(fields, "wires", |reader, node| {
        let items = reader.list(node, "a list of wires `[Wire(..), ..]`")?;
        if items.is_empty() {
            return reader.bad(node, "`wires` needs at least one wire");
        }
        let wires = reader.each(items, |reader, item| {
            let wires = entry(reader, item, &mut groups)?;
            // A still wire is an anchor where the blend is local.
            if blend.localize == 0.0 && wires.iter().all(KeyedWire::is_still) {
                lint_still(reader, item);
            }
            Some(wires)
        })?;
        if given && lattice.is_some() {
            refuse_scopes(reader, items)?;
        }
        Some(wires.concat())
    })?;
    groups.lint(reader);
    for wire in &wires {
        wire.time(clock);
    }
    Some(Deform { wires, blend, lattice })
}

/// One entry of `wires`: a wire, or those of a lattice.
fn entry(reader: &mut Reader<'_>, node: &Node, groups: &mut Groups) -> Option<Vec<KeyedWire>> {
    match &node.name {
        Some(name) if name.text == "WireLattice" => wire_lattice(reader, node),
        Some(name) if name.text != "Wire" => {
            reader.unknown_name(name, "wire", &["Wire", "WireLattice"]);
            None
        }
        _ => wire(reader, node, groups).map(|wire| vec![wire]),
    }
}

fn lint_still(reader: &mut Reader<'_>, node: &Node) {
    let (this, why) = if node.name() == Some("WireLattice") {
        ("these wires move", "no point of them moves")
    } else {
        ("this wire moves", "its pose is its curve")
    };
    let message = format!("{this} nothing: {why}, its scale is 1 and its twist 0, or its amplitude is 0");
    reader.warn(&head(node), message);
}

/// Wires that move a lattice act on its control points, which have neither names nor colours.
fn refuse_scopes(reader: &mut Reader<'_>, items: &[Node]) -> Option<()> {
    let mut good = Some(());
    for (i, item) in items.iter().enumerate() {
        let Body::Fields(entries) = &item.body else { continue };
        for entry in entries.iter().filter(|entry| !entry.value.is_bare("None")) {
            let key = entry.key.text.as_str();
            if !["only", "mask"].contains(&key) {
                continue;
            }
            let message = format!(
                "a wire with `{key}` cannot move a lattice, whose control points are no vertices of the object; \
                 write `{key}` for the whole effect"
            );
            good = reader.within(format!("[{i}]"), |reader| {
                reader.within(key, |reader| reader.bad(&entry.value, message))
            });
        }
    }
    good
}

/// The name of a node, or else its first byte: a caret under a whole wire would be many lines long.
pub(crate) fn head(node: &Node) -> Range<usize> {
    node.name.as_ref().map_or(node.span.start..node.span.start + 1, |name| name.span.clone())
}

/// Group names by number, in the order of their first use.
#[derive(Default)]
pub(crate) struct Groups(BTreeMap<String, (u32, usize, Range<usize>)>);

impl Groups {
    pub(crate) fn number(&mut self, name: &str, span: &Range<usize>) -> u32 {
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
        pinned: rest.pinned,
    };
    reader.finish(fields);
    Some(blend)
}
