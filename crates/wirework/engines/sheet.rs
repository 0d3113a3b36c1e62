//! The figures of a document by which engines are judged.

use std::collections::BTreeSet;

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
}

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
        }
    }
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
        let with = |key| targets.iter().filter(|target| target.get(key).is_some()).count();
        Self {
            vertices: accessor.and_then(|accessor| number(accessor, "count")).unwrap_or(0) as u64,
            at,
            targets: targets.len(),
            positions: with("POSITION"),
            normals: with("NORMAL"),
            tangents: with("TANGENT"),
            many_joints: attributes.is_some_and(|attributes| attributes.get("JOINTS_1").is_some()),
        }
    }
}
