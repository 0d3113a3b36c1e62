//! Limbs of a subject: which joints they have, and what they reach for.

use wirework_asset::{Gltf, Rest, printable};
use wirework_core::{Curve, Keyed, Wire};
use wirework_ik::{BoneFrame, IkError, Influence, Limb, Pose};
use wirework_preset::{Action, Chain, Effect, Goal, Named, PresetError, PresetErrorKind};
use wirework_surface::Bounds;

use crate::evaluate::bounds_frame;
use crate::{EvaluateError, JobError, Model, Subject};

/// A limb, at rest and as its model's clip poses it at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Reach {
    rest: Limb,
    /// The same as the rest where nothing poses it.
    now: Limb,
    /// The nodes of its joints, from the root to the tip; none of a chain that stands in the preset.
    nodes: Vec<usize>,
    target: Target,
}

/// What a limb reaches for.
#[derive(Clone, Debug)]
enum Target {
    Point(Keyed<[f32; 3]>),
    /// Travelled once in so many seconds.
    Curve(Curve, f64),
    /// A node of the model, and where it is now.
    Node(usize, [f64; 3]),
}

impl Reach {
    /// The wire at rest.
    pub(crate) fn wire(&self) -> Wire {
        self.rest.wire()
    }

    /// Where the joints are at a time.
    pub(crate) fn pose(&self, seconds: f64) -> Pose {
        let goal = match &self.target {
            Target::Point(track) => track.at(seconds).map(f64::from),
            Target::Curve(curve, duration) => {
                let u = if *duration > 0.0 { seconds / duration } else { 0.0 };
                curve.at([u.clamp(0.0, 1.0)])[0].0
            }
            Target::Node(_, place) => *place,
        };
        self.now.pose(goal, seconds)
    }

    /// Brings the limb's wire to a time.
    pub(crate) fn wire_into(&self, seconds: f64, wire: &mut Wire) {
        self.now.wire_into(&self.pose(seconds), seconds, wire);
    }

    /// What becomes of each bone at a time, where `wire` has been brought to it.
    pub(crate) fn bone_frames(&self, seconds: f64, wire: &Wire) -> Vec<BoneFrame> {
        self.now.bone_frames(&self.pose(seconds), wire)
    }

    /// The limb at rest.
    pub(crate) fn rest(&self) -> &Limb {
        &self.rest
    }

    /// The nodes of its joints, from the root to the tip; none of a chain that stands in the preset.
    pub(crate) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Whether it looks at nodes, which a clip may move.
    pub(crate) fn watches(&self) -> bool {
        !self.nodes.is_empty() || matches!(self.target, Target::Node(..))
    }

    /// Takes up where nodes are.
    pub(crate) fn follow(&mut self, place: impl Fn(usize) -> Option<[f64; 3]>) -> Result<(), IkError> {
        if let Target::Node(node, at) = &mut self.target {
            *at = place(*node).map_or(*at, as_kept);
        }
        if self.nodes.is_empty() {
            return Ok(());
        }
        let joints = places(&self.nodes, place);
        let are_of =
            |limb: &Limb| limb.joints().map(|joint| joint.map(|c| c as f32)).eq(joints.iter().copied());
        // Whatever was before: a moment by itself is the moment of a run.
        if are_of(&self.rest) {
            self.now.clone_from(&self.rest);
        } else if !are_of(&self.now) {
            self.now = self.rest.moved(&joints)?;
        }
        Ok(())
    }
}

/// Where nodes are, as joints are kept.
fn places(nodes: &[usize], place: impl Fn(usize) -> Option<[f64; 3]>) -> Vec<[f32; 3]> {
    nodes.iter().map(|&node| place(node).unwrap_or_default().map(|c| c as f32)).collect()
}

/// A place as precise as joints are kept: a goal on the tip is where the tip is, to the bit.
fn as_kept(place: [f64; 3]) -> [f64; 3] {
    place.map(|c| f64::from(c as f32))
}

/// The limbs of `effects`, none where one is no limb; goals on curves get there in `duration` seconds.
///
/// # Errors
///
/// [`JobError::Preset`]: joints that are not there or make no chain, at their place in the preset.
pub(crate) fn limbs(
    subject: &Subject,
    effects: &[Effect],
    duration: f64,
) -> Result<Vec<Option<Reach>>, JobError> {
    let frame = bounds_frame(subject.bounds());
    let reach = |effect: &Effect| {
        let Action::Ik(limb) = effect.placed(&frame).action else { return Ok(None) };
        let refuse = |field: &str, message: String| {
            Err(JobError::Preset(Box::new(effect.typed.error(field, PresetErrorKind::Value, message, None))))
        };
        let nodes = match &limb.chain {
            Chain::Joints(_) if limb.ik.influence == Influence::SkinWeights => {
                let message = "`SkinWeights` are those of joints of a model: it needs `chain: Skin(..)`";
                return refuse("influence", message.to_owned());
            }
            Chain::Joints(_) => Vec::new(),
            Chain::Skin { root, tip } => match &subject.model {
                Model::Gltf { gltf, .. } => chain(gltf, root, tip).map_err(refused(gltf))?,
                Model::Mesh { .. } => {
                    return refuse(
                        "chain",
                        "the object has no joints: give a model that has a skin, or say where they are with `Joints([..])`".to_owned(),
                    );
                }
            },
        };
        let goal = match &limb.goal {
            Goal::Node(named) => Some(match &subject.model {
                Model::Gltf { gltf, .. } => node(gltf, named).map_err(refused(gltf))?,
                Model::Mesh { .. } => {
                    return refuse(
                        "goal",
                        "the object has no nodes but its own: give a model that has, or a point".to_owned(),
                    );
                }
            }),
            _ => None,
        };
        let at = match &subject.model {
            Model::Gltf { gltf, rest } if goal.is_some() || !nodes.is_empty() => Some(at_rest(gltf, rest)?),
            _ => None,
        };
        let place = |node: usize| at.as_ref().and_then(|at| at.get(node).copied());
        let joints = match &limb.chain {
            Chain::Joints(joints) => joints.clone(),
            Chain::Skin { .. } => places(&nodes, place),
        };
        let rest = match Limb::new(&joints, &limb.ik) {
            Ok(rest) => rest,
            Err(error) => return refuse(&error.path(), error.to_string()),
        };
        let target = match limb.goal {
            Goal::Point(track) => Target::Point(track),
            Goal::Curve(curve) => Target::Curve(curve, duration),
            Goal::Node(_) => {
                let node = goal.unwrap_or_default();
                Target::Node(node, place(node).map_or([0.0; 3], as_kept))
            }
        };
        Ok(Some(Reach { now: rest.clone(), rest, nodes, target }))
    };
    effects.iter().map(reach).collect()
}

/// The limbs of effects on bare points.
///
/// # Errors
///
/// One that needs a model, or a time to get to its goal in; a chain that is no limb.
pub(crate) fn bare_limbs(
    effects: &[Effect],
    bounds: Option<Bounds>,
) -> Result<Vec<Option<Reach>>, EvaluateError> {
    let frame = bounds_frame(bounds);
    let reach = |(index, effect): (usize, &Effect)| {
        let Action::Ik(limb) = effect.placed(&frame).action else { return Ok(None) };
        let (Chain::Joints(joints), Goal::Point(track)) = (limb.chain, limb.goal) else {
            return Err(EvaluateError::Scoped { effect: index });
        };
        if limb.ik.influence == Influence::SkinWeights {
            return Err(EvaluateError::Scoped { effect: index });
        }
        let rest =
            Limb::new(&joints, &limb.ik).map_err(|error| EvaluateError::Limb { effect: index, error })?;
        let target = Target::Point(track);
        Ok(Some(Reach { now: rest.clone(), rest, nodes: Vec::new(), target }))
    };
    effects.iter().enumerate().map(reach).collect()
}

/// The joints by which vertices follow a limb: the chain's, and all below them. Nothing where it asks for no weights.
///
/// # Errors
///
/// Names that are not there.
pub(crate) fn weighing(gltf: &Gltf, effect: &Effect) -> Result<Option<Vec<usize>>, PresetError> {
    let Action::Ik(limb) = &effect.action else { return Ok(None) };
    let Chain::Skin { root, tip } = &limb.chain else { return Ok(None) };
    if limb.ik.influence != Influence::SkinWeights {
        return Ok(None);
    }
    let chain = chain(gltf, root, tip)?;
    let Some(&root) = chain.first() else { return Ok(None) };
    let mut joints = gltf.descendants(root);
    joints.push(root);
    Ok(Some(joints))
}

/// The nodes from a root to a tip.
fn chain(gltf: &Gltf, root: &Named, tip: &Named) -> Result<Vec<usize>, PresetError> {
    let (above, below) = (joint(gltf, root)?, joint(gltf, tip)?);
    gltf.node_path(above, below).filter(|path| path.len() > 1).ok_or_else(|| {
        let turned = gltf.node_path(below, above).is_some_and(|path| path.len() > 1);
        let help = if turned { "; the other way round they make a chain" } else { "" };
        tip.refused(format!("\"{}\" is not below \"{}\"{help}", printable(&tip.name), printable(&root.name)))
    })
}

/// A joint of that name, or else any node.
fn joint(gltf: &Gltf, named: &Named) -> Result<usize, PresetError> {
    let joints = gltf.joint_nodes();
    let is_named = |node: &usize| gltf.node_name(*node) == Some(named.name.as_str());
    let numbered = || named.name.parse().ok().filter(|node| joints.contains(node));
    let found = joints.iter().copied().find(is_named).or_else(|| (0..gltf.node_count()).find(is_named));
    found.or_else(numbered).ok_or_else(|| {
        let known: Vec<String> = joints.iter().map(|&node| name(gltf, node)).collect();
        unknown(named, "joint", &known)
    })
}

fn node(gltf: &Gltf, named: &Named) -> Result<usize, PresetError> {
    let all = 0..gltf.node_count();
    let numbered = || named.name.parse().ok().filter(|node| all.contains(node));
    let found = all.clone().find(|&node| gltf.node_name(node) == Some(named.name.as_str()));
    found.or_else(numbered).ok_or_else(|| {
        let known: Vec<String> = all.clone().map(|node| name(gltf, node)).collect();
        unknown(named, "node", &known)
    })
}

/// The name of a node, or else its number.
fn name(gltf: &Gltf, node: usize) -> String {
    gltf.node_name(node).map_or_else(|| node.to_string(), str::to_owned)
}

fn unknown(named: &Named, what: &str, known: &[String]) -> PresetError {
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    named.unknown(what, &known)
}

/// The error that the names of a preset do not fit a document.
fn refused(gltf: &Gltf) -> impl Fn(PresetError) -> JobError {
    let file = printable(gltf.file());
    move |error| {
        JobError::Preset(Box::new(PresetError { message: format!("{file}: {}", error.message), ..error }))
    }
}

/// Where all nodes are at rest.
fn at_rest(gltf: &Gltf, rest: &Rest) -> Result<Vec<[f64; 3]>, JobError> {
    let player = gltf.player(rest, None)?;
    let place = |node| player.node_transform(node).map_or([0.0; 3], |columns| columns[3]);
    Ok((0..gltf.node_count()).map(place).collect())
}
