//! \[SF98\] §5.2 as a preset: `Stitch(patches: [Piece(..), ..], seams: [Seam(a: Edge(..), b: Edge(..)), ..])`.

mod edge;
mod pieces;

use wirework_core::{Density, Keyed};
use wirework_stitch::{
    Continuity, Edge, Order, Pairing, Reversed, Run, Seam, Side, Stitch, StitchError, Tear,
};

use self::edge::edge;
use self::pieces::Pieces;
use crate::curve::density;
use crate::deform::head;
use crate::error::PresetErrorKind;
use crate::object::Object;
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::scope::Named;
use crate::tree::{Body, Node};

/// A stitch and what it sews.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stitching {
    /// The pieces, whose numbers the edges of the seams have: in the order of `patches`, or, where that is empty, in which edges name
    /// them first. No two have one name.
    pub pieces: Vec<Piece>,
    /// The seams, and how they are solved.
    pub stitch: Stitch,
}

/// One of the surfaces that are sewn together.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its name, which is never empty, and where that stands: in `patches`, or else in the edge that names it first.
    pub name: Named,
    /// What it is, in metres whatever the effect's units; no net of control points. None: the node of its name, of the input or of the
    /// effect's own object.
    pub object: Option<Object>,
}

/// Reads the fields of `Stitch` that are its own. `first`: whether it is the first effect, which may bring objects along.
pub(crate) fn stitch(
    reader: &mut Reader<'_>,
    fields: &mut Fields<'_>,
    clock: &mut Clock,
    first: bool,
) -> Option<Stitching> {
    let mut pieces = Pieces::read(reader, fields, first);
    let seams = reader.required(fields, "seams", |reader, node| {
        let items = reader.list(node, "a list of seams `[Seam(a: Edge(..), b: Edge(..)), ..]`")?;
        if items.is_empty() {
            return reader.bad(node, StitchError::NoSeams.to_string());
        }
        reader.each(items, |reader, item| seam(reader, item, &mut pieces, clock))
    });
    let order = reader.field(fields, "order", Order::default(), |reader, node| {
        let orders = [("Simultaneous", Order::Simultaneous), ("Sequential", Order::Sequential)];
        reader.choice(node, "order", &orders)
    });
    Some(Stitching { pieces: pieces.into_list(), stitch: Stitch { seams: seams?, order } })
}

/// Stands in for an edge that is bad, so that the rest of its seam is read.
const NO_EDGE: Edge = Edge { piece: 0, run: Run::Side(Side::UMin) };

/// Reads a `Seam`; the name may be left out.
fn seam(reader: &mut Reader<'_>, node: &Node, pieces: &mut Pieces, clock: &mut Clock) -> Option<Seam> {
    let mut fields = reader.fields(node, "Seam")?;
    let a = reader.required(&mut fields, "a", |reader, node| edge(reader, node, pieces));
    let b = reader.required(&mut fields, "b", |reader, node| edge(reader, node, pieces));
    let mut seam = Seam::new(a.clone().unwrap_or(NO_EDGE), b.clone().unwrap_or(NO_EDGE));
    manner(reader, &mut fields, &mut seam);
    for (key, within, track) in [
        ("bias", Within::Unit, &mut seam.bias),
        ("closure", Within::Unit, &mut seam.closure),
        ("radius", Within::Positive, &mut seam.radius),
        ("scale", Within::Finite, &mut seam.scale),
    ] {
        *track =
            reader.field(&mut fields, key, track.clone(), |reader, node| reader.keyed_number(node, within));
        clock.track(track);
    }
    seam.tears = reader.field(&mut fields, "tears", Vec::new(), |reader, node| {
        let items = reader.list(node, "a list of tears `[Tear(at: 0.5, width: 0.2), ..]`")?;
        reader.each(items, |reader, item| tear(reader, item, clock))
    });
    lint_seam(reader, &fields, &seam);
    reader.finish(fields);
    if a? == b? {
        let message = StitchError::Itself { seam: 0 }.to_string();
        reader.error(PresetErrorKind::Value, &head(node), message, None);
        return None;
    }
    Some(seam)
}

/// How a seam runs and holds: the fields of it that do not move.
fn manner(reader: &mut Reader<'_>, fields: &mut Fields<'_>, seam: &mut Seam) {
    seam.reversed = reader.field(fields, "reversed", seam.reversed, reversed);
    seam.density = reader.field(fields, "density", seam.density.clone(), density);
    seam.pairing = reader.field(fields, "correspondence", seam.pairing, |reader, node| {
        let pairings = [
            ("ArcLength", Pairing::ArcLength),
            ("Parameter", Pairing::Parameter),
            ("Closest", Pairing::Closest),
        ];
        reader.choice(node, "correspondence", &pairings)
    });
    seam.continuity = reader.field(fields, "continuity", seam.continuity, |reader, node| {
        let names = [("Position", Continuity::Position), ("Tangent", Continuity::Tangent)];
        reader.choice(node, "continuity", &names)
    });
    seam.weld = reader.field(fields, "weld", seam.weld, Reader::flag);
}

/// `Auto`, `true` or `false`.
fn reversed(reader: &mut Reader<'_>, node: &Node) -> Option<Reversed> {
    if let Body::Bool(reversed) = node.body {
        return Some(Reversed::Given(reversed));
    }
    // The latter two are no names; they stand here for the list of what is expected.
    let [yes, no] = [true, false].map(Reversed::Given);
    let names = [("Auto", Reversed::Auto), ("true", yes), ("false", no)];
    reader.choice(node, "value of `reversed`", &names)
}

/// Warns of a seam that never sews, and of a weld of what never meets.
fn lint_seam(reader: &mut Reader<'_>, fields: &Fields<'_>, seam: &Seam) {
    lint_still(reader, fields, "closure", &seam.closure, "this seam never sews");
    if let Some(node) = fields.again("density").filter(|_| seam.continuity == Continuity::Tangent)
        && seam.density == Density::Linear
    {
        let message = "with `Linear`, which is not flat at 0, `continuity: Tangent` leaves a crease";
        reader.within("density", |reader| reader.warn(&node.span, message));
    }
    let apart = seam.closure.values().all(|&closure| closure == 0.0);
    let ajar = !apart && seam.closure.values().all(|&closure| closure < 1.0);
    if let Some(node) = fields.again("weld").filter(|_| ajar && seam.weld) {
        let message = "`weld` joins what is closed; with `closure` below 1 this seam never is";
        reader.within("weld", |reader| reader.warn(&node.span, message));
    }
}

/// Warns of a number that is 0 all the time, and of what comes of it.
fn lint_still(
    reader: &mut Reader<'_>,
    fields: &Fields<'_>,
    key: &'static str,
    track: &Keyed<f32>,
    what: &str,
) {
    if let Some(node) = fields.again(key).filter(|_| track.values().all(|&value| value == 0.0)) {
        reader.within(key, |reader| reader.warn(&node.span, format!("with `{key}` 0 {what}")));
    }
}

/// Reads a `Tear`; the name may be left out.
fn tear(reader: &mut Reader<'_>, node: &Node, clock: &mut Clock) -> Option<Tear> {
    let mut fields = reader.fields(node, "Tear")?;
    let at = reader.required(&mut fields, "at", |reader, node| reader.keyed(node, "a number", place));
    let width = reader.required(&mut fields, "width", |reader, node| {
        // A tear may begin as nothing, and be no more than that for ever only by mistake.
        let within = if node.name.is_some() { Within::NotNegative } else { Within::Positive };
        reader.keyed_number(node, within)
    });
    let mut tear = Tear::new(0.5, 1.0);
    for (key, within, track) in [
        ("opening", Within::Unit, &mut tear.opening),
        ("gape", Within::Finite, &mut tear.gape),
        ("plateau", Within::Unit, &mut tear.plateau),
    ] {
        *track =
            reader.field(&mut fields, key, track.clone(), |reader, node| reader.keyed_number(node, within));
    }
    lint_still(reader, &fields, "opening", &tear.opening, NEVER_OPENS);
    if let Some(width) = &width {
        lint_still(reader, &fields, "width", width, NEVER_OPENS);
    }
    reader.finish(fields);
    let tear = Tear { at: at?, width: width?, ..tear };
    for track in [&tear.at, &tear.width, &tear.opening, &tear.gape, &tear.plateau] {
        clock.track(track);
    }
    Some(tear)
}

const NEVER_OPENS: &str = "this tear never opens";

/// The middle of a tear.
fn place(reader: &mut Reader<'_>, node: &Node) -> Option<f32> {
    let at = reader.number(node, Within::Finite)?;
    if (0.0..=1.0).contains(&at) {
        return Some(at);
    }
    reader.bad(node, format!("`at` must lie from 0 to 1, found {at}: there the tear lies outside the seam"))
}
