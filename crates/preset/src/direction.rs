//! \[SF98\] §3.1: directions of directional dropoffs, which count as seen along the wire: one along it has no effect.

use glam::{DVec3, Vec3};
use wirework_core::{Curve, Keyed};

use crate::keyed_wire::KeyedWire;
use crate::moments::{key_nodes, moments};
use crate::read::{Fields, Reader};
use crate::tree::{Body, Node};

/// Two directions are one, or opposite, where the sine between them is less: what is left across then is mostly rounding.
const PARALLEL: f64 = 1e-4;

/// Places along the wire that are looked at.
const SAMPLES: u16 = 33;

/// Tangents cost this part of a look at closest points.
const PART_OF_LOOK: usize = 8;

/// A † direction that is nowhere 0, not between its keys either.
pub(crate) fn keyed_direction(reader: &mut Reader<'_>, node: &Node) -> Option<Keyed<[f32; 3]>> {
    let mut before: Option<[f32; 3]> = None;
    reader.keyed(node, "a direction `(x, y, z)`", |reader, value| {
        let now = reader.direction(value)?;
        match before.replace(now) {
            Some(before) if are_opposite(before, now) => reader.bad(
                value,
                "a direction cannot turn straight round: half way from the key before it would be (0, 0, 0); \
                 put a key between",
            ),
            _ => Some(now),
        }
    })
}

/// The vector of length 1; none where it has no direction.
fn unit(v: [f32; 3]) -> Option<DVec3> {
    Vec3::from_array(v).as_dvec3().try_normalize()
}

/// Whether unit vectors point the same way or opposite ways.
fn are_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() < PARALLEL
}

/// Whether the straight way from one direction to the other leads through 0.
fn are_opposite(a: [f32; 3], b: [f32; 3]) -> bool {
    let (Some(a), Some(b)) = (unit(a), unit(b)) else { return false };
    a.dot(b) < 0.0 && are_parallel(a, b)
}

/// Refuses directions along the wire, at all places where they count; a warning where they run along it at some. None where the
/// reader has looked at enough.
pub(crate) fn check_directions(reader: &mut Reader<'_>, fields: &Fields<'_>, wire: &KeyedWire) -> Option<()> {
    let in_locators = wire.locators.iter().any(|values| values.direction.is_some());
    if let (Some(track), Some(node), false) = (&wire.values.direction, fields.again("direction"), in_locators)
    {
        let samples: Vec<f32> = (0..SAMPLES).map(|i| f32::from(i) / f32::from(SAMPLES - 1)).collect();
        reader.within("direction", |reader| check_direction(reader, node, wire, track, &samples))?;
    }
    let Some(Node { body: Body::List(items), .. }) = fields.again("locators") else { return Some(()) };
    let mut before: Option<&Keyed<[f32; 3]>> = None;
    for (i, ((item, values), at)) in items.iter().zip(&wire.locators).zip(&wire.fixed.locators).enumerate() {
        let (Some(track), Some(node)) = (&values.direction, item.field("direction")) else { continue };
        reader.within("locators", |reader| {
            reader.within(format!("[{i}]"), |reader| {
                reader.within("direction", |reader| {
                    lint_opposite(reader, node, before.replace(track), track);
                    check_direction(reader, node, wire, track, &[at.u])
                })
            })
        })?;
    }
    Some(())
}

/// Between two locators the direction runs straight from the one to the other.
fn lint_opposite(
    reader: &mut Reader<'_>,
    node: &Node,
    before: Option<&Keyed<[f32; 3]>>,
    now: &Keyed<[f32; 3]>,
) {
    let (Some(Keyed::Constant(before)), Keyed::Constant(now)) = (before, now) else { return };
    if are_opposite(*before, *now) {
        let message = "on the way from the locator before, this direction passes (0, 0, 0) and has no effect \
                       there; put a locator between";
        reader.warn(&node.span, message);
    }
}

/// One direction as typed, which counts at the parameters `at`.
fn check_direction(
    reader: &mut Reader<'_>,
    node: &Node,
    wire: &KeyedWire,
    track: &Keyed<[f32; 3]>,
    at: &[f32],
) -> Option<()> {
    let cost = (wire.fixed.reference.points().len() * at.len()).div_ceil(PART_OF_LOOK);
    // What moves is looked at where it is known: at its own keys, or else at those of the wire.
    if let Keyed::Constant(direction) = track {
        let mut all = Vec::new();
        for seconds in moments(reader, [&wire.reference])? {
            reader.look(cost)?;
            all.extend(tangents(&wire.reference_at(seconds), at));
        }
        judge(reader, node, *direction, &all);
        return Some(());
    }
    let mut now: Vec<(f32, DVec3)> = Vec::new();
    for (i, ((seconds, node), &value)) in key_nodes(node).zip(track.values()).enumerate() {
        if i == 0 || wire.reference.is_some() {
            reader.look(cost)?;
            now = tangents(&wire.reference_at(seconds), at);
        }
        judge(reader, node, value, &now);
    }
    Some(())
}

/// Where the wire has a direction, and which.
fn tangents(curve: &Curve, at: &[f32]) -> Vec<(f32, DVec3)> {
    at.iter().filter_map(|&u| Some((u, unit(curve.tangent(u))?))).collect()
}

fn judge(reader: &mut Reader<'_>, node: &Node, direction: [f32; 3], tangents: &[(f32, DVec3)]) {
    let Some(direction) = unit(direction) else { return };
    let along = |(_, tangent): &&(f32, DVec3)| are_parallel(direction, *tangent);
    let Some((u, _)) = tangents.iter().find(along) else { return };
    if tangents.iter().filter(along).count() == tangents.len() {
        let message =
            "a direction points sideways from the wire; this one runs along it, and would have no effect";
        let _: Option<()> = reader.bad(node, message);
    } else {
        reader.warn(&node.span, format!("at u = {u} this direction runs along the wire and has no effect"));
    }
}
