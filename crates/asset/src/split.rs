//! Joints of a skin made finer: more joints where one was, so that a limb of few bones can bend as a curve does.
//!
//! New joints are children of the one whose work they share, so they go where it goes until something moves them: the rest and all clips
//! stay as they are. What hung on it hangs on it and them by where along the limb it lies, on two at most: between neighbours by hats.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DAffine3, DVec3};
use serde_json::{Value, json};

use crate::document::Gltf;
use crate::edit::{drop_compressed, whole};
use crate::error::{AssetError, ErrorClass, Place};
use crate::frame::Frame;
use crate::graph::{Graph, columns};
use crate::hang::Vertices;
use crate::limits::{Budget, Of};
use crate::rest::Rest;
use crate::skin::{Influences, Skin};

/// The most joints that the vertices of a skin can name.
const MOST_JOINTS: usize = 1 << 16;

/// A joint that gets others beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split<'a> {
    /// Its node.
    pub node: usize,
    /// How far along the limb it is.
    pub along: f64,
    /// Where there may be joints besides, rising along the limb; one as far along as the joint itself is that.
    pub knots: &'a [Knot],
}

/// A place for a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// How far along the limb it is, in the measure of the vertices.
    pub along: f64,
    /// Where it is, in the space of the joint that is split.
    pub at: [f64; 3],
}

/// A skin that holds joints that are split.
struct Held {
    skin: Skin,
    /// For each of its joints which of the splits it is.
    splits: Vec<Option<usize>>,
}

/// A joint of a split: the one that is split, or that of a knot.
type Stop = Option<usize>;

/// What a vertex has of a joint that is split.
struct Share {
    slot: usize,
    weight: f32,
    /// The joint by its number in the skin, and which split it is.
    of: (u16, usize),
    /// The joints between which the vertex lies, and the weight that goes to the second one.
    before: Stop,
    after: Stop,
    beyond: f32,
}

/// What is split, and what hangs on it.
struct Work<'a> {
    rest: &'a Rest,
    along: &'a [f32],
    /// The skin of each block, as far as it holds something that is split.
    skins: Vec<Option<usize>>,
    held: BTreeMap<usize, Held>,
    /// For each split its joints, rising along the limb.
    stops: Vec<Vec<(f64, Stop)>>,
}

/// What the primitives of a node's mesh hang on from now on, where that changes.
type Change<'a> = Vec<Option<&'a Influences>>;

impl Gltf {
    /// Adds joints beside others, and has hang on them what hung on those: gives for each split the node of each of its knots, none for a
    /// knot on which nothing would hang.
    ///
    /// `rest` is the rest of this document, and `along` how far along the limb each of its vertices lies. Each skin that holds a joint
    /// gets the new ones behind those that it has, bound so that nothing moves, at rest and in every clip, until something moves them.
    /// A vertex hangs on the two joints between which it lies; on the nearer one where none of its places for joints is
    /// free. Meshes get new joints and weights where that changes anything; one that nodes need in several ways is copied. The rest of
    /// the document has to be read anew.
    ///
    /// # Errors
    ///
    /// Nodes that are not there or come twice, knots that do not rise, another number of places than there are vertices, numbers that are
    /// not finite; a skin that is malformed, or gets more joints than 16 bits count; the limits. Nothing is changed then.
    pub fn split_joints(
        &mut self,
        rest: &Rest,
        splits: &[Split<'_>],
        along: &[f32],
    ) -> Result<Vec<Vec<Option<usize>>>, AssetError> {
        self.append_split(rest, splits, along).map_err(|error| error.in_file(&self.file))
    }

    fn append_split(
        &mut self,
        rest: &Rest,
        splits: &[Split<'_>],
        along: &[f32],
    ) -> Result<Vec<Vec<Option<usize>>>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let graph = self.graph(&mut budget, &mut Vec::new())?;
        check(&graph, rest, splits, along)?;
        let held = self.held(&graph, splits, &mut budget)?;
        let work = Work::new(&graph, rest, splits, along, held)?;
        let nodes = work.nodes(splits, graph.nodes.len(), &mut budget)?;
        let numbers = self.numbers(&work, &nodes)?;
        let bindings = work.bindings(splits, &nodes)?;
        let name = |skin: usize, split: usize, knot: usize| numbers[&(skin, split, knot)];
        let hung = work.rehung(name, &mut budget)?;
        self.append_joints(splits, &nodes)?;
        for ((&index, held), matrices) in work.held.iter().zip(bindings) {
            let joints: Vec<usize> = held.skin.joints.iter().copied().chain(held.added(&nodes)).collect();
            if joints.len() == held.skin.joints.len() {
                continue;
            }
            let matrices = self.append_tuples(matrices, "MAT4")?;
            let skin = self.entry_mut("skins", index)?;
            skin.insert("joints".to_owned(), json!(joints));
            skin.insert("inverseBindMatrices".to_owned(), json!(matrices));
        }
        self.rehang(rest, &hung)?;
        Ok(nodes)
    }

    /// The skins that hold joints that are split.
    fn held(
        &self,
        graph: &Graph,
        splits: &[Split<'_>],
        budget: &mut Budget,
    ) -> Result<BTreeMap<usize, Held>, AssetError> {
        let split_of = |node: usize| splits.iter().position(|split| split.node == node);
        let mut out = BTreeMap::new();
        for (index, skin) in self.list("skins").iter().enumerate() {
            let joints = skin.get("joints").and_then(Value::as_array).into_iter().flatten();
            if joints.filter_map(whole).any(|joint| split_of(joint).is_some()) {
                let json = self.root().need("skins")?.item(index)?;
                let skin = Skin::read(self, json, graph.nodes.len(), budget, &mut Vec::new())?;
                let splits = skin.joints.iter().map(|&joint| split_of(joint)).collect();
                out.insert(index, Held { skin, splits });
            }
        }
        Ok(out)
    }

    /// The numbers that new joints have in each skin, by the split and its knot.
    fn numbers(
        &self,
        work: &Work<'_>,
        nodes: &[Vec<Option<usize>>],
    ) -> Result<BTreeMap<(usize, usize, usize), u16>, AssetError> {
        let mut out = BTreeMap::new();
        for (&index, held) in &work.held {
            let most = held.skin.joints.len() + held.added(nodes).count();
            if most > MOST_JOINTS {
                let list = self.root().need("skins")?.item(index)?.need("joints")?;
                let found = list.found(format!("{most} joints with the new ones"), "at most 65 536");
                return Err(found.of_class(ErrorClass::Limit));
            }
            let mut next = held.skin.joints.len();
            for (split, knots) in nodes.iter().enumerate().filter(|(split, _)| held.holds(*split)) {
                for (knot, _) in knots.iter().enumerate().filter(|(_, node)| node.is_some()) {
                    out.insert((index, split, knot), next as u16);
                    next += 1;
                }
            }
        }
        Ok(out)
    }

    /// Appends the nodes of the new joints, and makes them children of those that are split.
    fn append_joints(
        &mut self,
        splits: &[Split<'_>],
        nodes: &[Vec<Option<usize>>],
    ) -> Result<(), AssetError> {
        let names = self.list("nodes").iter().filter_map(|node| node.get("name")?.as_str());
        let mut taken: BTreeSet<String> = names.map(str::to_owned).collect();
        for (split, new) in splits.iter().zip(nodes) {
            let new: Vec<(usize, &Knot)> =
                new.iter().zip(split.knots).filter_map(|(node, knot)| Some(((*node)?, knot))).collect();
            if new.is_empty() {
                continue;
            }
            let own =
                self.node_name(split.node).map_or_else(|| format!("joint_{}", split.node), str::to_owned);
            for (k, (_, knot)) in new.iter().enumerate() {
                let name = unused(&taken, &format!("{own}_{}", k + 1));
                self.append("nodes", json!({ "name": name, "translation": knot.at }))?;
                taken.insert(name);
            }
            let children =
                self.entry_mut("nodes", split.node)?.entry("children").or_insert_with(|| json!([]));
            let children = children.as_array_mut().into_iter();
            children.for_each(|list| list.extend(new.iter().map(|(node, _)| json!(node))));
        }
        Ok(())
    }

    /// Gives the primitives of nodes new joints and weights, those that are `hung` anew, block by block.
    fn rehang(&mut self, rest: &Rest, hung: &[Option<Influences>]) -> Result<(), AssetError> {
        let mut meshes: BTreeMap<usize, Vec<(usize, Change<'_>)>> = BTreeMap::new();
        for part in &rest.parts {
            let nodes = meshes.entry(part.mesh).or_default();
            if nodes.last().is_none_or(|(node, _)| *node != part.node) {
                nodes.push((part.node, Change::new()));
            }
            if let Some((_, change)) = nodes.last_mut() {
                change.resize(change.len().max(part.primitive + 1), None);
                change[part.primitive] = hung.get(part.block).and_then(Option::as_ref);
            }
        }
        for (mesh, mut nodes) in meshes {
            nodes.retain(|(_, change)| change.iter().any(Option::is_some));
            for (mesh, change) in self.meshes_for(mesh, nodes)? {
                self.rehang_primitives(mesh, &change)?;
            }
        }
        Ok(())
    }

    fn rehang_primitives(&mut self, mesh: usize, change: &Change<'_>) -> Result<(), AssetError> {
        // Primitives of one block share what they hang on.
        let mut written: Vec<(&Influences, Vec<[usize; 2]>)> = Vec::new();
        for (index, influences) in change.iter().enumerate() {
            let Some(influences) = influences else { continue };
            let known = written.iter().find(|(known, _)| *known == *influences).map(|(_, sets)| sets.clone());
            let sets = if let Some(sets) = known {
                sets
            } else {
                let sets = self.append_vertices_of(as_written(influences))?;
                written.push((influences, sets.clone()));
                sets
            };
            let primitive = self.primitives_mut(mesh)?.get_mut(index).and_then(Value::as_object_mut);
            let Some(primitive) = primitive else { continue };
            drop_compressed(primitive);
            let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) else {
                continue;
            };
            for (set, [joints, weights]) in sets.iter().enumerate() {
                attributes.insert(format!("JOINTS_{set}"), json!(joints));
                attributes.insert(format!("WEIGHTS_{set}"), json!(weights));
            }
        }
        Ok(())
    }
}

impl Held {
    fn holds(&self, split: usize) -> bool {
        self.splits.contains(&Some(split))
    }

    /// The nodes of the joints that it gets.
    fn added(&self, nodes: &[Vec<Option<usize>>]) -> impl Iterator<Item = usize> {
        let own = nodes.iter().enumerate().filter(|(split, _)| self.holds(*split));
        own.flat_map(|(_, knots)| knots.iter().flatten().copied())
    }
}

impl Share {
    fn new(slot: usize, stops: &[(f64, Stop)], along: f64, weight: f32, of: (u16, usize)) -> Self {
        let next = stops.partition_point(|(stop, _)| *stop <= along);
        let ((a, before), (b, after)) = (stops[next.saturating_sub(1)], stops[next.min(stops.len() - 1)]);
        let part = if b > a { ((along - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        Self { slot, weight, of, before, after, beyond: (f64::from(weight) * part) as f32 }
    }

    /// The weight that would be misplaced if all of it hung on the nearer one.
    fn lost(&self) -> f32 {
        self.beyond.min(self.weight - self.beyond)
    }
}

impl<'a> Work<'a> {
    fn new(
        graph: &Graph,
        rest: &'a Rest,
        splits: &[Split<'_>],
        along: &'a [f32],
        held: BTreeMap<usize, Held>,
    ) -> Result<Self, AssetError> {
        let mut skins = Vec::with_capacity(rest.blocks.len());
        for block in &rest.blocks {
            let skin = graph.nodes.get(block.node).and_then(|node| node.skin);
            let skin = skin.filter(|skin| held.contains_key(skin));
            let joints = skin.map(|skin| held[&skin].splits.len());
            if joints.is_some() && joints != block.joints().map(<[_]>::len) {
                return Err(AssetError::file("vertices of another document", "the rest of this one"));
            }
            skins.push(skin);
        }
        let stops = |split: &Split<'_>| {
            let own = std::iter::once((split.along, None));
            let knots = split.knots.iter().enumerate().filter(|(_, knot)| knot.along != split.along);
            let mut all: Vec<(f64, Stop)> = own.chain(knots.map(|(k, knot)| (knot.along, Some(k)))).collect();
            all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            all
        };
        Ok(Self { rest, along, skins, held, stops: splits.iter().map(stops).collect() })
    }

    /// The nodes that knots get, from `next` on: those on which something hangs.
    fn nodes(
        &self,
        splits: &[Split<'_>],
        next: usize,
        budget: &mut Budget,
    ) -> Result<Vec<Vec<Option<usize>>>, AssetError> {
        let mut used = BTreeSet::new();
        let mark = |_, split, knot| {
            used.insert((split, knot));
            0
        };
        self.rehung(mark, budget)?;
        budget.charge(Of::Nodes, used.len() as u64, || Place::Pointer("/nodes".to_owned()))?;
        let mut nodes: Vec<Vec<Option<usize>>> =
            splits.iter().map(|split| vec![None; split.knots.len()]).collect();
        for (node, (split, knot)) in (next..).zip(used) {
            nodes[split][knot] = Some(node);
        }
        Ok(nodes)
    }

    /// What the vertices of each block hang on from now on, none where that stays. `name` gives the number in a skin of the joint of a
    /// split's knot.
    fn rehung(
        &self,
        mut name: impl FnMut(usize, usize, usize) -> u16,
        budget: &mut Budget,
    ) -> Result<Vec<Option<Influences>>, AssetError> {
        let mut out = Vec::with_capacity(self.rest.blocks.len());
        for (block, skin) in self.rest.blocks.iter().zip(&self.skins) {
            let (Some(skin), Frame::Skin { influences, .. }) = (skin, &block.frame) else {
                out.push(None);
                continue;
            };
            let place = || Place::Pointer(format!("/meshes/{}/primitives", block.mesh));
            budget.charge(Of::ExpandedBytes, influences.bytes(), place)?;
            let mut new = influences.clone();
            let mut changed = false;
            let along = &self.along[block.first..block.first + block.count];
            for (vertex, along) in along.iter().enumerate() {
                let mut name = |split, knot| name(*skin, split, knot);
                changed |= self.resettle(&mut new, (vertex, f64::from(*along)), &self.held[skin], &mut name);
            }
            out.push(changed.then_some(new));
        }
        Ok(out)
    }

    /// Shares out what a vertex has of joints that are split. Says whether that changes anything.
    fn resettle(
        &self,
        hung: &mut Influences,
        (vertex, along): (usize, f64),
        held: &Held,
        name: &mut impl FnMut(usize, usize) -> u16,
    ) -> bool {
        let mut shares: Vec<Share> = Vec::new();
        for slot in 0..hung.slots() {
            let (joint, weight) = hung.slot(vertex, slot);
            let split = held.splits.get(usize::from(joint)).copied().flatten().filter(|_| weight > 0.0);
            shares.extend(
                split.map(|split| Share::new(slot, &self.stops[split], along, weight, (joint, split))),
            );
        }
        // Places for joints go first to those that lose most without.
        shares.sort_by(|a, b| b.lost().total_cmp(&a.lost()));
        let mut changed = false;
        for share in shares {
            let (joint, split) = share.of;
            let mut named = |stop: Stop| stop.map_or(joint, |knot| name(split, knot));
            let free = (0..hung.slots()).find(|&slot| hung.slot(vertex, slot).1 == 0.0);
            let (weight, beyond) = (share.weight, share.beyond);
            if let Some(free) = free.filter(|_| beyond > 0.0 && beyond < weight) {
                hung.set(vertex, share.slot, (named(share.before), weight - beyond));
                hung.set(vertex, free, (named(share.after), beyond));
                changed = true;
            } else {
                let nearer = if beyond > weight - beyond { share.after } else { share.before };
                hung.set(vertex, share.slot, (named(nearer), weight));
                changed |= nearer.is_some();
            }
        }
        changed
    }

    /// The inverse bind matrices of each skin, those of the new joints behind its own.
    fn bindings(
        &self,
        splits: &[Split<'_>],
        nodes: &[Vec<Option<usize>>],
    ) -> Result<Vec<Vec<[f32; 16]>>, AssetError> {
        let of_skin = |(index, held): (&usize, &Held)| {
            let own = |joint: usize| held.skin.inverse.get(joint).copied().unwrap_or(DAffine3::IDENTITY);
            let mut out: Vec<[f32; 16]> =
                (0..held.skin.joints.len()).map(|joint| columns(&own(joint))).collect();
            for (number, (split, nodes)) in splits.iter().zip(nodes).enumerate() {
                let Some(joint) = held.splits.iter().position(|of| *of == Some(number)) else { continue };
                let new = split.knots.iter().zip(nodes).filter(|(_, node)| node.is_some());
                let back = |(knot, _): (&Knot, _)| DAffine3::from_translation(-DVec3::from_array(knot.at));
                out.extend(new.map(|new| columns(&(back(new) * own(joint)))));
            }
            if out.as_flattened().iter().any(|c| !c.is_finite()) {
                let place = Place::Pointer(format!("/skins/{index}"));
                let expected = "joints within the range of floats";
                return Err(AssetError::new(place, "new joints whose matrices overflow", expected));
            }
            Ok(out)
        };
        self.held.iter().map(of_skin).collect()
    }
}

fn check(graph: &Graph, rest: &Rest, splits: &[Split<'_>], along: &[f32]) -> Result<(), AssetError> {
    let fault = |found: String, expected: &str| Err(AssetError::file(found, expected));
    let mut seen = BTreeSet::new();
    for Split { node, along, knots } in splits {
        if *node >= graph.nodes.len() || !seen.insert(*node) {
            return fault(format!("node {node} to be split"), "nodes that are there, each once");
        }
        let finite = along.is_finite() && knots.iter().all(|knot| knot.along.is_finite());
        let finite = finite && knots.iter().flat_map(|knot| knot.at).all(f64::is_finite);
        if !finite || !knots.windows(2).all(|pair| pair[0].along < pair[1].along) {
            return fault(format!("the knots of node {node}"), "finite ones that rise along the limb");
        }
    }
    if along.len() != rest.positions.len() || along.iter().any(|along| !along.is_finite()) {
        let expected = format!("a finite one for each of {} vertices", rest.positions.len());
        return fault(format!("{} places along a limb", along.len()), &expected);
    }
    Ok(())
}

/// Joints and weights as files have them.
fn as_written(influences: &Influences) -> Vec<Vertices> {
    let small = influences.sets.iter().all(|set| set.joints.as_flattened().iter().all(|&joint| joint < 256));
    let bytes = if small { 1 } else { 2 };
    influences
        .sets
        .iter()
        .map(|set| Vertices {
            joints: set
                .joints
                .as_flattened()
                .iter()
                .flat_map(|joint| joint.to_le_bytes().into_iter().take(bytes))
                .collect(),
            component: if small { 5121 } else { 5123 },
            weights: set.weights.clone(),
        })
        .collect()
}

/// A name that no node has: this one, or else one with a number behind it.
fn unused(taken: &BTreeSet<String>, name: &str) -> String {
    let numbered = (2_usize..).map(|n| format!("{name}_{n}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or_default()
}
