//! The pieces of a stitch: those that it lists, or those that its edges name.

use std::collections::{BTreeMap, BTreeSet};

use super::Piece;
use crate::error::{PresetErrorKind, escape};
use crate::object::{Object, PatchDeform, Shape, object, within_limit};
use crate::preset::TAKEN_OVER;
use crate::read::{Fields, Reader};
use crate::scope::Named;
use crate::tree::{Body, Node};

/// Names that an unknown one is compared with, which takes a microsecond each: nobody sews more.
const NAMES_COMPARED: usize = 1024;

/// The pieces there are so far.
pub(super) struct Pieces {
    list: Vec<Piece>,
    numbers: BTreeMap<String, usize>,
    /// Whether edges may name others: none are listed, or not all of those that are could be read.
    open: bool,
}

impl Pieces {
    /// The field `patches`.
    pub(super) fn read(reader: &mut Reader<'_>, fields: &mut Fields<'_>, first: bool) -> Self {
        let list = reader.field(fields, "patches", Vec::new(), |reader, node| pieces(reader, node, first));
        let numbers = list.iter().enumerate().map(|(i, piece)| (piece.name.name.clone(), i)).collect();
        Self { open: list.is_empty(), list, numbers }
    }

    pub(super) fn into_list(self) -> Vec<Piece> {
        self.list
    }

    /// The number of the piece that an edge names.
    pub(super) fn number(&mut self, reader: &mut Reader<'_>, node: &Node) -> Option<usize> {
        let name = reader.text(node, "the name of a piece")?;
        if let Some(&number) = self.numbers.get(name) {
            return Some(number);
        }
        if !self.open {
            let known = self.list.iter().take(NAMES_COMPARED).map(|piece| piece.name.name.as_str());
            reader.unknown_text(name, &node.span, "piece", known);
            return None;
        }
        let name = named(reader, node)?;
        let number = self.list.len();
        self.numbers.insert(name.name.clone(), number);
        self.list.push(Piece { name, object: None });
        Some(number)
    }

    /// Whether a piece has the sides of a patch, as far as is known before nodes are looked up.
    pub(super) fn may_have_sides(&self, number: usize) -> bool {
        let object = self.list.get(number).and_then(|piece| piece.object.as_ref());
        object.is_none_or(|object| matches!(object.shape, Shape::Patch { .. } | Shape::Grid { .. }))
    }
}

fn pieces(reader: &mut Reader<'_>, node: &Node, first: bool) -> Option<Vec<Piece>> {
    let items = reader.list(node, "a list of pieces `[Piece(name: \"..\", object: ..), ..]`")?;
    let mut names = BTreeSet::new();
    let mut vertices = 0_u64;
    reader.each(items, |reader, item| {
        let piece = piece(reader, item, first, &mut names)?;
        let size = piece.object.as_ref().map_or(0, |object| object.shape.size().vertices);
        vertices = vertices.saturating_add(size);
        within_limit(reader, item, vertices, "the pieces up to this one have")?;
        Some(piece)
    })
}

/// Reads a `Piece`, or its name alone.
fn piece<'n>(
    reader: &mut Reader<'_>,
    node: &'n Node,
    first: bool,
    names: &mut BTreeSet<&'n str>,
) -> Option<Piece> {
    let mut new_name = |reader: &mut Reader<'_>, node: &'n Node| {
        let name = named(reader, node)?;
        let Body::Text(text) = &node.body else { return None };
        if names.insert(text) {
            Some(name)
        } else {
            reader.bad(node, format!("there is a piece \"{}\" before this one", escape(text)))
        }
    };
    if node.name.is_none() && !matches!(node.body, Body::Fields(_) | Body::Tuple(_)) {
        return Some(Piece { name: new_name(reader, node)?, object: None });
    }
    let mut fields = reader.fields(node, "Piece")?;
    let name = reader.required(&mut fields, "name", new_name);
    let object = reader.optional(&mut fields, "object", |reader, node| {
        let object = object(reader, node);
        if !first {
            reader.error(PresetErrorKind::Value, &node.span, TAKEN_OVER, None);
            return None;
        }
        surface(reader, node, object?)
    });
    reader.finish(fields);
    Some(Piece { name: name?, object })
}

/// The name of a piece.
fn named(reader: &mut Reader<'_>, node: &Node) -> Option<Named> {
    let name = reader.text(node, "the name of a piece")?;
    if name.is_empty() {
        reader.bad(node, "a piece needs a name")
    } else {
        Some(reader.named(name, &node.span))
    }
}

/// Refuses a net of control points: its surface has other borders than the points that would be sewn.
fn surface(reader: &mut Reader<'_>, node: &Node, object: Object) -> Option<Object> {
    if !matches!(object.shape, Shape::Patch { deform: PatchDeform::ControlPoints, .. }) {
        return Some(object);
    }
    let inner = match &node.body {
        Body::Tuple(items) => items.first().unwrap_or(node),
        _ => node,
    };
    let at = inner.field("deform").unwrap_or(node);
    let message = "a piece is deformed by the points of its surface: `deform: Points`";
    reader.within("deform", |reader| reader.bad(at, message))
}
