//! The figures of a document by which engines are judged.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use wirework_asset::printable;

use crate::inspect::{list, number};

/// A document in figures.
pub(super) struct Sheet<'a> {
    pub(super) meshes: Vec<Mesh>,
    pub(super) required: BTreeSet<&'a str>,
    /// Accessors with neither a view nor sparse values.
    pub(super) empty: Vec<usize>,
    /// Accessors with sparse values and no view.
    pub(super) baseless: Vec<usize>,
    /// Clips with a channel that names no node.
    pub(super) nodeless_clips: Vec<usize>,
    /// Scenes that list no nodes.
    pub(super) nodeless_scenes: Vec<usize>,
    /// How many joints each skin has.
    pub(super) joints: Vec<usize>,
    /// Nodes with the same names from the root on, of which clips move at least one, together.
    pub(super) twins: Vec<Vec<usize>>,
}

/// A mesh.
pub(super) struct Mesh {
    /// As messages call it: by its name, or else its number.
    pub(super) label: String,
    /// The most targets of its primitives.
    pub(super) targets: usize,
    /// The fewest.
    pub(super) fewest: usize,
    /// Whether it has default weights.
    pub(super) weights: bool,
    /// How many names of targets have a colon.
    pub(super) colons: usize,
    pub(super) primitives: Vec<Primitive>,
}

/// A primitive.
pub(super) struct Primitive {
    pub(super) vertices: u64,
    /// The accessor that has them.
    pub(super) at: Option<usize>,
    pub(super) targets: usize,
    /// How many of the targets move positions, normals, tangents.
    pub(super) positions: usize,
    pub(super) normals: usize,
    pub(super) tangents: usize,
    /// Whether vertices may hang on more than four joints.
    pub(super) many_joints: bool,
    /// The kind of its elements, as the standard numbers them.
    pub(super) mode: usize,
    /// Whether indices make triangles of vertices that have no normals.
    pub(super) bare: bool,
}

/// What the standard calls `TRIANGLES`, its default.
const TRIANGLES: usize = 4;

impl<'a> Sheet<'a> {
    pub(super) fn of(json: &'a Value) -> Self {
        let viewless = |sparse: bool| {
            indices(json, "accessors", |accessor| {
                accessor.get("bufferView").is_none() && accessor.get("sparse").is_some() == sparse
            })
        };
        Self {
            meshes: list(json, "meshes")
                .iter()
                .enumerate()
                .map(|(i, mesh)| Mesh::of(json, i, mesh))
                .collect(),
            required: list(json, "extensionsRequired").iter().filter_map(Value::as_str).collect(),
            empty: viewless(false),
            baseless: viewless(true),
            nodeless_clips: indices(json, "animations", |clip| {
                list(clip, "channels").iter().any(|channel| channel.pointer("/target/node").is_none())
            }),
            nodeless_scenes: indices(json, "scenes", |scene| scene.get("nodes").is_none()),
            joints: list(json, "skins").iter().map(|skin| list(skin, "joints").len()).collect(),
            twins: twins(json),
        }
    }
}

/// See [`Sheet::twins`].
fn twins(json: &Value) -> Vec<Vec<usize>> {
    let nodes = list(json, "nodes");
    let children = |node: usize| {
        list(&nodes[node], "children").iter().filter_map(index).filter(|child| *child < nodes.len())
    };
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (node, child) in (0..nodes.len()).flat_map(|node| children(node).map(move |child| (node, child))) {
        parents[child] = Some(node);
    }
    let channels = list(json, "animations").iter().flat_map(|clip| list(clip, "channels"));
    let moved = channels.filter_map(|channel| index(channel.pointer("/target/node")?));
    let moved: BTreeSet<usize> = moved.filter(|node| *node < nodes.len()).collect();
    // Only what is below roots with something that moves plays clips. Each node is come by once, whatever loops a document holds.
    let mut live = vec![false; nodes.len()];
    let mut roots = BTreeSet::new();
    for &node in &moved {
        let mut next = Some(node);
        while let Some(node) = next.filter(|&node| !std::mem::replace(&mut live[node], true)) {
            next = parents[node];
            if next.is_none() {
                roots.insert(node);
            }
        }
    }
    let mut paths: BTreeMap<(usize, Cow<'_, str>), usize> = BTreeMap::new();
    let mut same: Vec<Vec<usize>> = Vec::new();
    let mut seen = BTreeSet::new();
    let mut stack: Vec<(usize, usize)> = roots.into_iter().map(|root| (usize::MAX, root)).collect();
    while let Some((above, node)) = stack.pop() {
        if !seen.insert(node) {
            continue;
        }
        let name = match nodes[node].get("name").and_then(Value::as_str) {
            Some(name) => Cow::Borrowed(name),
            None => Cow::Owned(format!("GltfNode{node}")),
        };
        let path = *paths.entry((above, name)).or_insert(same.len());
        if path == same.len() {
            same.push(Vec::new());
        }
        same[path].push(node);
        stack.extend(children(node).map(|child| (path, child)));
    }
    same.retain(|own| own.len() > 1 && own.iter().any(|node| moved.contains(node)));
    for own in &mut same {
        own.sort_unstable();
    }
    same.sort_unstable();
    same
}

fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// The numbers of those entries of a table for which this holds.
fn indices(json: &Value, table: &str, holds: impl Fn(&Value) -> bool) -> Vec<usize> {
    list(json, table).iter().enumerate().filter(|(_, entry)| holds(entry)).map(|(index, _)| index).collect()
}

impl Mesh {
    fn of(json: &Value, index: usize, mesh: &Value) -> Self {
        let primitives = list(mesh, "primitives").iter();
        let primitives: Vec<Primitive> = primitives.map(|primitive| Primitive::of(json, primitive)).collect();
        let targets = || primitives.iter().map(|primitive| primitive.targets);
        let name = mesh.get("name").and_then(Value::as_str);
        let names = mesh.get("extras").map_or(&[][..], |extras| list(extras, "targetNames"));
        let colon = |name: &&Value| name.as_str().is_some_and(|name| name.contains(':'));
        Self {
            label: name.map_or(format!("mesh {index}"), |name| format!("mesh \"{}\"", printable(name))),
            targets: targets().max().unwrap_or(0),
            fewest: targets().min().unwrap_or(0),
            weights: mesh.get("weights").is_some(),
            colons: names.iter().filter(colon).count(),
            primitives,
        }
    }
}

impl Primitive {
    fn of(json: &Value, primitive: &Value) -> Self {
        let attributes = primitive.get("attributes");
        let at = attributes.and_then(|attributes| number(attributes, "POSITION"));
        let accessor = at.and_then(|at| list(json, "accessors").get(at));
        let targets = list(primitive, "targets");
        let mode = number(primitive, "mode").unwrap_or(TRIANGLES);
        let with = |key| targets.iter().filter(|target| target.get(key).is_some()).count();
        Self {
            vertices: accessor.and_then(|accessor| number(accessor, "count")).unwrap_or(0) as u64,
            at,
            targets: targets.len(),
            positions: with("POSITION"),
            normals: with("NORMAL"),
            tangents: with("TANGENT"),
            many_joints: attributes.is_some_and(|attributes| attributes.get("JOINTS_1").is_some()),
            bare: mode == TRIANGLES
                && primitive.get("indices").is_some()
                && attributes.is_none_or(|own| own.get("NORMAL").is_none()),
            mode,
        }
    }
}
