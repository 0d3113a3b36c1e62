//! The joints of a limb, and what is said of each.

use std::collections::BTreeSet;

use wirework_ik::Pin;

use super::{Chain, POINT};
use crate::read::{Reader, Within, found};
use crate::tree::{Body, Node};

/// Joints that are nearer to each other than this part of their chain's length are one: in f32 the direction of a shorter bone is
/// noise.
const LEAST_BONE: f64 = 1e-6;

/// `Joints([(x, y, z), ..])` or `Skin(root: "a", tip: "b")`.
pub(super) fn chain(reader: &mut Reader<'_>, node: &Node) -> Option<Chain> {
    const EXPECTED: &str = "`Joints([(x, y, z), ..])` or `Skin(root: \"name\", tip: \"name\")`";
    let Some(name) = &node.name else {
        return reader.mismatch(node, EXPECTED);
    };
    match (name.text.as_str(), &node.body) {
        ("Joints", Body::Tuple(items)) if items.len() == 1 => {
            let at = items.first()?;
            let joints = reader.points(at)?;
            apart(reader, at, &joints)?;
            Some(Chain::Joints(joints))
        }
        ("Joints", _) => reader.bad(node, "expected `Joints([(x, y, z), ..])`"),
        ("Skin", Body::Bare) => reader.bad(node, "expected `Skin(root: \"name\", tip: \"name\")`"),
        ("Skin", _) => skin(reader, node),
        _ => {
            reader.unknown_name(name, "chain", &["Joints", "Skin"]);
            None
        }
    }
}

/// Refuses what has no bones, and joints that lie on those before them.
fn apart(reader: &mut Reader<'_>, node: &Node, joints: &[[f32; 3]]) -> Option<()> {
    if joints.len() < 2 {
        let few = if joints.is_empty() { "no joints" } else { "one joint" };
        return reader.bad(node, format!("a chain of {few} has no bone; it needs two joints or more"));
    }
    let lengths: Vec<f64> = joints.windows(2).map(|bone| distance(bone[0], bone[1])).collect();
    let least = LEAST_BONE * lengths.iter().sum::<f64>();
    let items = reader.list(node, "joints")?;
    let mut good = Some(());
    for (i, item) in items.iter().enumerate().skip(1) {
        let length = lengths.get(i - 1).copied().unwrap_or_default();
        if length == 0.0 || length < least {
            let lies = if length == 0.0 { "lies" } else { "all but lies" };
            let message = format!("joint {i} {lies} on joint {}: a bone has a length", i - 1);
            good = reader.within(format!("[{i}]"), |reader| reader.bad(item, message));
        }
    }
    good
}

/// In f64 it neither overflows nor vanishes.
fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(b)).powi(2)).sum::<f64>().sqrt()
}

/// `Skin(root: "a", tip: "b")`, or `Skin("a", "b")`.
fn skin(reader: &mut Reader<'_>, node: &Node) -> Option<Chain> {
    let joint = |reader: &mut Reader<'_>, node: &Node| {
        let name = reader.text(node, "the name of a joint")?;
        Some(reader.named(name, &node.span))
    };
    let mut fields;
    let (root, tip, at) = match &node.body {
        Body::Tuple(items) if items.len() == 2 => {
            let mut names = items
                .iter()
                .enumerate()
                .map(|(i, item)| reader.within(format!("[{i}]"), |reader| joint(reader, item)));
            (names.next()?, names.next()?, items.last())
        }
        _ => {
            fields = reader.unnamed_fields(node, "Skin")?;
            let root = reader.required(&mut fields, "root", joint);
            let tip = reader.required(&mut fields, "tip", joint);
            let at = fields.again("tip");
            reader.finish(fields);
            (root, tip, at)
        }
    };
    let (root, tip) = (root?, tip?);
    if root == tip {
        return reader.bad(at?, "a chain of one joint has no bone; `tip` is the joint at the other end");
    }
    Some(Chain::Skin { root, tip })
}

/// One number a bone. `joints`: how many the chain has, where that is known.
pub(super) fn stiffness(reader: &mut Reader<'_>, node: &Node, joints: Option<usize>) -> Option<Vec<f32>> {
    let items = reader.list(node, "a list of numbers, one a bone, `[0, 1, ..]`")?;
    let good = match joints {
        Some(joints) if !items.is_empty() && items.len() + 1 != joints => {
            let (bones, found) = (joints - 1, items.len());
            let message = format!("`stiffness` has one number a bone; this chain has {bones}, found {found}");
            reader.bad(node, message)
        }
        _ => Some(()),
    };
    let numbers = reader.each(items, |reader, item| reader.number(item, Within::Unit));
    good.and(numbers)
}

/// One angle a joint; the tip needs none.
pub(super) fn limits(reader: &mut Reader<'_>, node: &Node, joints: Option<usize>) -> Option<Vec<f32>> {
    let items = reader.list(node, "a list of degrees, one a joint, `[30, 45, ..]`")?;
    let good = match joints {
        Some(joints) if !items.is_empty() && ![joints - 1, joints].contains(&items.len()) => {
            let (inner, found) = (joints - 1, items.len());
            reader.bad(
                node,
                format!(
                    "`limits` has one angle a joint; this chain has {joints}, or {inner} without the tip, \
                     which needs none; found {found}"
                ),
            )
        }
        _ => Some(()),
    };
    let angles = reader.each(items, |reader, item| reader.degrees(item, Within::HalfTurn));
    good.and(angles)
}

/// `[(joint, point), ..]`.
pub(super) fn pins(reader: &mut Reader<'_>, node: &Node, joints: Option<usize>) -> Option<Vec<Pin>> {
    let items = reader.list(node, "a list of pins `[(joint, point), ..]`")?;
    let mut before = BTreeSet::new();
    reader.each(items, |reader, item| {
        let [joint, point]: &[Node; 2] = reader.tuple(item, "a pin `(joint, point)`")?;
        let joint = reader.within("[0]", |reader| pinned(reader, joint, joints, &mut before));
        let point = reader.within("[1]", |reader| reader.keyed(point, POINT, Reader::point));
        Some(Pin { joint: joint?, point: point? })
    })
}

/// A joint that is neither the tip nor pinned before.
fn pinned(
    reader: &mut Reader<'_>,
    node: &Node,
    joints: Option<usize>,
    before: &mut BTreeSet<usize>,
) -> Option<usize> {
    let joint = usize::try_from(reader.count(node, 0)?).unwrap_or(usize::MAX);
    if let Some(tip) = joints.map(|joints| joints - 1)
        && joint >= tip
    {
        let tells = if joint == tip { ", the tip, which has the goal" } else { "" };
        let range = if tip == 1 { "joint 0".to_owned() } else { format!("one of joints 0 to {}", tip - 1) };
        let (count, found) = (tip + 1, found(node));
        return reader
            .bad(node, format!("a pin holds {range} of this chain of {count}, found {found}{tells}"));
    }
    if before.insert(joint) {
        Some(joint)
    } else {
        reader.bad(node, format!("joint {joint} is pinned before this one"))
    }
}
