//! \[SF98\] §5.3 as a preset: `Ik(chain: Joints([(x, y, z), ..]), goal: (x, y, z), elasticity: 0.5, ..)`.

mod chain;

use wirework_core::{Closest, Curve, Keyed};
use wirework_ik::{ChainCurve, Ik, Influence, ScaleBy, Tip};

use self::chain::{chain, limits, pins, stiffness};
use crate::curve::{CURVES, curve};
use crate::deform::head;
use crate::error::PresetErrorKind;
use crate::preset::Clock;
use crate::read::{Fields, Reader, Within};
use crate::scope::Named;
use crate::tree::{Body, Node};
use crate::wire::closest;

/// A limb and where its tip is to go.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Its joints.
    pub chain: Chain,
    /// Where its tip is to go.
    pub goal: Goal,
    /// All else. Lists fit the chain where its joints are known, and no joint is pinned twice.
    pub ik: Ik,
}

impl Limb {
    /// Whether it looks at joints or nodes of a model, which a clip may move.
    pub fn watches(&self) -> bool {
        matches!(self.chain, Chain::Skin { .. }) || matches!(self.goal, Goal::Node(_))
    }
}

/// The joints of a limb, from its root to its tip.
#[derive(Clone, Debug, PartialEq)]
pub enum Chain {
    /// Where they are at rest; at least two, and none on the one before.
    Joints(Vec<[f32; 3]>),
    /// Joints of the object's skin: one, and those from it down to another, which is not the same.
    Skin {
        /// The joint that the limb hangs on.
        root: Named,
        /// The joint at its end.
        tip: Named,
    },
}

/// Where the tip of a limb is to go.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// To a point.
    Point(Keyed<[f32; 3]>),
    /// Along a curve, which is more than a point: from its start to its end once in the length of the preset.
    Curve(Curve),
    /// To where the node of this name is.
    Node(Named),
}

/// A point, for messages.
const POINT: &str = "a point `(x, y, z)`";

/// Reads the fields of `Ik` that are its own.
pub(crate) fn ik(reader: &mut Reader<'_>, fields: &mut Fields<'_>, clock: &mut Clock) -> Option<Limb> {
    let chain = reader.required(fields, "chain", chain);
    let goal = reader.required(fields, "goal", goal);
    let count = match &chain {
        Some(Chain::Joints(joints)) => Some(joints.len()),
        _ => None,
    };
    let mut ik = Ik::default();
    ik.curve = reader.field(fields, "curve", ik.curve, chain_curve);
    ik.pole = pole(reader, fields);
    ik.elasticity = reader
        .field(fields, "elasticity", ik.elasticity, |reader, node| reader.keyed_number(node, Within::Unit));
    ik.stiffness =
        reader.field(fields, "stiffness", Vec::new(), |reader, node| stiffness(reader, node, count));
    ik.limits = reader.field(fields, "limits", Vec::new(), |reader, node| limits(reader, node, count));
    ik.pins = reader.field(fields, "pins", Vec::new(), |reader, node| pins(reader, node, count));
    numbers(reader, fields, &mut ik);
    ik.twist =
        reader.field(fields, "twist", ik.twist, |reader, node| reader.keyed_degrees(node, Within::Finite));
    ik.tip = reader.field(fields, "tip", ik.tip, tip);
    ik.influence = reader.field(fields, "influence", ik.influence, influence);
    let width = closest(reader, fields, |reader, node| reader.number(node, Within::Positive));
    ik.closest = width.map_or(Closest::Smallest, Closest::Blended);
    lint(reader, fields, &ik);
    if let Some(node) = fields.again("chain").filter(|_| matches!(chain, Some(Chain::Skin { .. })))
        && ["influence", "only", "mask"].iter().all(|key| fields.again(key).is_none())
    {
        let message = "everything follows this limb, not only what hangs on its joints: `influence: SkinWeights` is for that, `All` says that it is meant";
        reader.within("chain", |reader| reader.warn(&head(node), message));
    }
    let limb = Limb { chain: chain?, goal: goal?, ik };
    limb.time(clock);
    Some(limb)
}

/// How far a limb stretches, and what comes of it.
fn numbers(reader: &mut Reader<'_>, fields: &mut Fields<'_>, ik: &mut Ik) {
    for (key, within, number) in [
        ("max_stretch", Within::AtLeastOne, &mut ik.max_stretch),
        ("min_stretch", Within::Unit, &mut ik.min_stretch),
        ("softness", Within::Unit, &mut ik.softness),
        ("volume", Within::Unit, &mut ik.volume),
    ] {
        *number = reader.field(fields, key, *number, |reader, node| reader.number(node, within));
    }
    ik.scale_by = reader.field(fields, "scale_by", ik.scale_by, |reader, node| {
        let lengths = [("Length", ScaleBy::Length), ("Local", ScaleBy::Local)];
        reader.choice(node, "value of `scale_by`", &lengths)
    });
}

impl Limb {
    /// Tells a clock every track, and what else moves the limb.
    fn time(&self, clock: &mut Clock) {
        match &self.goal {
            Goal::Point(point) => clock.track(point),
            Goal::Curve(_) => clock.flows(),
            Goal::Node(_) => clock.follows(),
        }
        if matches!(self.chain, Chain::Skin { .. }) {
            clock.follows();
        }
        let pins = self.ik.pins.iter().map(|pin| &pin.point);
        pins.chain(&self.ik.pole).for_each(|track| clock.track(track));
        clock.track(&self.ik.elasticity);
        clock.track(&self.ik.twist);
    }
}

/// Warns of what has no effect beside the other fields. What is not typed is not meant.
fn lint(reader: &mut Reader<'_>, fields: &Fields<'_>, ik: &Ik) {
    let always = |elasticity: f32| ik.elasticity.values().all(|&value| value == elasticity);
    let stiff = ik.stiffness.iter().any(|&bone| bone > 0.0);
    for (key, idle, why) in [
        // A stiff bone in a rubber band is a bone.
        (
            "pole",
            always(1.0) && ik.pole.is_some() && !stiff,
            "with `elasticity` 1: a rubber band has no bend",
        ),
        ("stiffness", always(0.0) && stiff, "with `elasticity` 0: every bone keeps its length"),
        ("softness", ik.max_stretch == 1.0 && ik.softness > 0.0, "with `max_stretch` 1: nothing stretches"),
    ] {
        if let Some(node) = fields.again(key).filter(|_| idle) {
            reader.within(key, |reader| reader.warn(&node.span, format!("`{key}` has no effect {why}")));
        }
    }
}

/// A point that moves, `Curve(..)` or `Node("name")`.
fn goal(reader: &mut Reader<'_>, node: &Node) -> Option<Goal> {
    match (node.name(), &node.body) {
        (Some("Curve"), Body::Tuple(items)) if items.len() == 1 => {
            let at = items.first()?;
            let curve = curve(reader, at)?;
            if curve.points().iter().any(|point| Some(point) != curve.points().first()) {
                Some(Goal::Curve(curve))
            } else {
                reader.bad(at, "a goal goes along its curve, and this one is a single point")
            }
        }
        (Some("Curve"), _) => reader.bad(node, "expected `Curve(..)` around a curve"),
        (Some("Node"), Body::Tuple(items)) if items.len() == 1 => {
            let at = items.first()?;
            let name = reader.text(at, "the name of a node")?;
            Some(Goal::Node(reader.named(name, &at.span)))
        }
        (Some("Node"), _) => reader.bad(node, "expected `Node(\"name\")`"),
        (Some(kind), _) if CURVES.contains(&kind) => {
            let span = node.name.as_ref().map_or(&node.span, |name| &name.span);
            let help = Some(format!("write `Curve({kind}(..))`"));
            reader.error(PresetErrorKind::Name, span, "a curve as a goal stands in `Curve(..)`", help);
            None
        }
        _ => {
            let what = format!("{POINT}, `Curve(..)`, `Node(\"name\")`");
            reader.keyed_among(node, &what, &["Curve", "Node"], Reader::point).map(Goal::Point)
        }
    }
}

/// The field `pole`: a point that moves; none for `Auto`.
fn pole(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Option<Keyed<[f32; 3]>> {
    let node = fields.get("pole").filter(|node| !node.is_bare("Auto"))?;
    reader.within("pole", |reader| {
        if node.name() == Some("Auto") {
            return reader.bad(node, "`Auto` stands alone, without parentheses");
        }
        reader.keyed_among(node, &format!("`Auto`, {POINT}"), &["Auto"], Reader::point)
    })
}

/// `Rounded(0.25)`, `Rounded` or `Chain`.
fn chain_curve(reader: &mut Reader<'_>, node: &Node) -> Option<ChainCurve> {
    match (node.name(), &node.body) {
        (Some("Rounded"), Body::Tuple(items)) if items.len() == 1 => {
            let fraction = items.first()?;
            let read = |reader: &mut Reader<'_>| reader.number(fraction, Within::Half);
            reader.within("fraction", read).map(ChainCurve::Rounded)
        }
        (Some("Rounded"), Body::Tuple(_) | Body::Fields(_)) => {
            reader.bad(node, "expected `Rounded(fraction)`")
        }
        _ => {
            let curves = [("Rounded", Ik::default().curve), ("Chain", ChainCurve::Chain)];
            reader.choice(node, "value of `curve`", &curves)
        }
    }
}

/// `Follow` or `Hold((x, y, z))`, degrees.
fn tip(reader: &mut Reader<'_>, node: &Node) -> Option<Tip> {
    match (node.name(), &node.body) {
        (Some("Hold"), Body::Tuple(items)) if items.len() == 1 => {
            let angles: &[Node; 3] = reader.tuple(items.first()?, "degrees `(x, y, z)`")?;
            let angles = reader.each(angles, |reader, angle| reader.degrees(angle, Within::Finite))?;
            angles.try_into().ok().map(Tip::Hold)
        }
        (Some("Hold"), _) => reader.bad(node, "expected `Hold((x, y, z))`"),
        _ => reader.choice(node, "value of `tip`", &[("Follow", Some(Tip::Follow)), ("Hold", None)])?,
    }
}

/// `All`, `Radius(r)` or `SkinWeights`.
fn influence(reader: &mut Reader<'_>, node: &Node) -> Option<Influence> {
    match (node.name(), &node.body) {
        (Some("Radius"), Body::Tuple(items)) if items.len() == 1 => {
            let radius = items.first()?;
            let read = |reader: &mut Reader<'_>| reader.number(radius, Within::Positive);
            reader.within("radius", read).map(Influence::Radius)
        }
        (Some("Radius"), _) => reader.bad(node, "expected `Radius(r)`"),
        _ => {
            let skin = ("SkinWeights", Some(Influence::SkinWeights));
            reader.choice(node, "influence", &[("All", Some(Influence::All)), ("Radius", None), skin])?
        }
    }
}
