//! Edges of seams: `Edge(piece: "front", side: UMax)`, or from one point of a border to another, or all of a border.

use wirework_stitch::{Edge, EdgeFault, Run, Side};

use super::pieces::Pieces;
use crate::read::{Fields, Reader};
use crate::tree::Node;

const SIDES: [(&str, Side); 4] =
    [("UMin", Side::UMin), ("UMax", Side::UMax), ("VMin", Side::VMin), ("VMax", Side::VMax)];

/// Reads an `Edge`; the name may be left out.
pub(super) fn edge(reader: &mut Reader<'_>, node: &Node, pieces: &mut Pieces) -> Option<Edge> {
    let mut fields = reader.fields(node, "Edge")?;
    let piece = reader.required(&mut fields, "piece", |reader, node| pieces.number(reader, node));
    let sided = piece.is_none_or(|piece| pieces.may_have_sides(piece));
    let run = run(reader, node, &mut fields, sided);
    reader.finish(fields);
    Some(Edge { piece: piece?, run: run? })
}

/// The field as typed, unless it is `None`.
fn given<'n>(fields: &Fields<'n>, key: &str) -> Option<&'n Node> {
    fields.again(key).filter(|node| !node.is_bare("None"))
}

/// The part of the border. `sided`: whether the piece may have sides.
fn run(reader: &mut Reader<'_>, node: &Node, fields: &mut Fields<'_>, sided: bool) -> Option<Run> {
    let side = reader.optional(fields, "side", |reader, node| {
        let side = reader.choice(node, "side", &SIDES)?;
        if sided { Some(side) } else { reader.bad(node, EdgeFault::NoSides.to_string()) }
    });
    let from = reader.optional(fields, "from", Reader::point);
    let to = reader.optional(fields, "to", Reader::point);
    let long = reader.optional(fields, "long", Reader::flag);
    let around = reader.optional(fields, "loop", Reader::point);
    let ends = ["from", "to"].map(|key| given(fields, key).is_some());
    let (has_side, between, whole) =
        (given(fields, "side").is_some(), ends != [false; 2], given(fields, "loop").is_some());
    match [has_side, between, whole] {
        [false, false, false] => {
            if !["side", "from", "to", "loop"].iter().any(|key| fields.misspelt(key)) {
                reader.lacks(fields, "`Edge` needs a field `side`, or `from` and `to`, or `loop`");
            }
            return None;
        }
        [true, false, false] | [false, true, false] | [false, false, true] => {}
        several => return contradictory(reader, node, several),
    }
    if let Some(node) = given(fields, "long").filter(|_| !between) {
        let message = "`long` is which way to go `from` a point `to` another; this edge has none";
        return reader.within("long", |reader| reader.bad(node, message));
    }
    if between {
        if let Some(missing) = ["from", "to"].into_iter().zip(ends).find_map(|(key, is)| (!is).then_some(key))
        {
            if !fields.misspelt(missing) {
                reader
                    .lacks(fields, format!("`Edge` needs a field `{missing}`: `from` and `to` go together"));
            }
            return None;
        }
        return Some(Run::Between { from: from?, to: to?, long: long.unwrap_or(false) });
    }
    if has_side { side.map(Run::Side) } else { around.map(Run::Loop) }
}

/// Refuses an edge that is said in more than one way.
fn contradictory(reader: &mut Reader<'_>, node: &Node, ways: [bool; 3]) -> Option<Run> {
    let ways = ["`side`", "`from` and `to`", "`loop`"].into_iter().zip(ways);
    let said: Vec<&str> = ways.filter_map(|(way, is)| is.then_some(way)).collect();
    let message =
        format!("an edge is a `side`, or `from` and `to`, or a `loop`; this one has {}", said.join(" and "));
    reader.bad(node, message)
}
