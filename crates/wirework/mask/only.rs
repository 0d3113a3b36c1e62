//! `only`: the vertices of nodes, of materials, or bound to joints.

use std::collections::{BTreeMap, BTreeSet};

use wirework_asset::{Gltf, Obj, Rest, printable};
use wirework_preset::{Effect, Named, Only, PresetError};

use super::{Lack, MISSING_LISTED};
use crate::limbs::weighing;
use crate::parts::of_positions;
use crate::{MeshPart, Model, Pieces, Subject};

/// So many joints without a name are many: their numbers tell nobody where they are.
const MANY_NUMBERS: usize = 4;

/// So many nodes that show a mesh are listed.
const NODES_LISTED: usize = 8;

/// The factor of each point: the least of its vertices.
///
/// - `Nodes`: 1 at vertices of a mesh that a node of such a name shows, else 0. A node without a mesh stands for all below it.
///   In an OBJ file, objects and groups are the nodes; without any, and in what a preset makes, they are those that
///   it has when it is written as glTF.
/// - `Materials`: 1 at vertices all of whose faces have such a material.
/// - `Joints`: the sum of the vertex's normalised weights for these joints; 0 without a skin.
///
/// All that share a name are meant by it. In a glTF document a number that is no name is an index, of a node or a material: many
/// have no names.
pub(super) fn factors(only: &Only, subject: &Subject, warnings: &mut Vec<String>) -> Result<Vec<f32>, Lack> {
    let of_vertices = match &subject.model {
        Model::Gltf { gltf, rest } => of_gltf(only, (gltf, rest), &subject.pieces, warnings)?,
        Model::Mesh { parts, mesh, obj } => {
            of_mesh(only, parts, mesh.positions.len(), obj.as_deref(), warnings)?
        }
    };
    if subject.net.is_some() {
        // What a preset makes is one node: all of it or, above, an error.
        return Ok(vec![1.0; subject.points.len()]);
    }
    let mut out = vec![1.0; subject.points.len()];
    least(&mut out, subject, &of_vertices);
    if matches!(only, Only::Nodes(_)) {
        warnings.extend(shared(&of_vertices, subject, &out));
    }
    Ok(out)
}

/// A warning where vertices of named nodes stay because others, which may not move, are at their places.
fn shared(of_vertices: &[f32], subject: &Subject, of_points: &[f32]) -> Option<String> {
    let stays = |(&point, &factor): (&u32, &f32)| factor > 0.0 && of_points.get(point as usize) == Some(&0.0);
    let stay = subject.point_of.iter().zip(of_vertices).filter(|pair| stays(*pair)).count();
    let message = || {
        let stay = if stay == 1 { "1 vertex stays".to_owned() } else { format!("{stay} vertices stay") };
        format!("`only: Nodes([..])`: {stay}, for other nodes have vertices at the same places [only-shared]")
    };
    (stay > 0).then(message)
}

/// The factor of each point for a limb: the sum of its vertices' weights for the limb's joints, the least of its vertices; 1 where the limb does not
/// ask for weights.
pub(super) fn weighed(
    effect: &Effect,
    subject: &Subject,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>, Lack> {
    let mut out = vec![1.0; subject.points.len()];
    let Model::Gltf { gltf, rest } = &subject.model else { return Ok(out) };
    let joints = weighing(gltf, effect).map_err(|error| Lack::Missing(vec![error]))?;
    let Some(joints) = joints else { return Ok(out) };
    let weights = gltf.joint_weights(rest, &joints)?;
    if weights.used.is_empty() {
        warnings.push("the joints of the limb carry no vertex [only-empty]".to_owned());
    }
    least(&mut out, subject, &weights.of_vertices);
    Ok(out)
}

/// Gives each point the least factor of its vertices.
fn least(out: &mut [f32], subject: &Subject, of_vertices: &[f32]) {
    for (&point, &factor) in subject.point_of.iter().zip(of_vertices) {
        if let Some(slot) = out.get_mut(point as usize) {
            *slot = factor.min(*slot);
        }
    }
}

fn of_gltf(
    only: &Only,
    (gltf, rest): (&Gltf, &Rest),
    pieces: &Pieces,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>, Lack> {
    match only {
        Only::Nodes(_) => {
            let table = Table::new((0..gltf.node_count()).map(|node| (gltf.node_name(node), node)));
            let mut nodes = Vec::new();
            for (named, mut list) in table.look_up(only, |named| shown_mesh(gltf, named))? {
                list.extend(pieces.nodes(&named.name));
                let shown = gltf.mesh_nodes(&list);
                if !rest.blocks.iter().any(|block| shown.binary_search(&block.node).is_ok()) {
                    warnings.push(without(named, "shows no vertex of the scene"));
                }
                nodes.extend(shown);
            }
            Ok(ones(&gltf.vertices_of_nodes(rest, &nodes)))
        }
        Only::Materials(_) => {
            let table = Table::new(
                (0..gltf.material_count()).map(|material| (gltf.material_name(material), material)),
            );
            let mut materials = Vec::new();
            for (named, list) in table.look_up(only, |_| None)? {
                if !rest
                    .parts
                    .iter()
                    .any(|part| part.material.is_some_and(|material| list.contains(&material)))
                {
                    warnings.push(without(named, "is on no vertex of the scene"));
                }
                materials.extend(list);
            }
            Ok(ones(&gltf.vertices_of_materials(rest, &materials)?))
        }
        Only::Joints(_) => {
            let table = Table::new(gltf.joint_nodes().into_iter().map(|node| (gltf.node_name(node), node)));
            let many = table.bare.len() >= MANY_NUMBERS;
            let advice = format!("`wirework inspect {}` tells where each joint is", printable(gltf.file()));
            let found = table.look_up(only, |_| many.then(|| advice.clone()))?;
            let joints: Vec<usize> = found.iter().flat_map(|(_, list)| list.iter().copied()).collect();
            let weights = gltf.joint_weights(rest, &joints)?;
            for (named, list) in found {
                if !list.iter().any(|joint| weights.used.binary_search(joint).is_ok()) {
                    warnings.push(without(named, "carries no vertex"));
                }
            }
            Ok(weights.of_vertices)
        }
    }
}

fn of_mesh(
    only: &Only,
    parts: &[MeshPart],
    count: usize,
    obj: Option<&Obj>,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>, Lack> {
    let mut known: BTreeSet<String> = match (only, obj) {
        (Only::Nodes(_), Some(obj)) => obj.group_names().into_iter().collect(),
        (Only::Materials(_), Some(obj)) => obj.material_names().into_iter().collect(),
        _ => BTreeSet::new(),
    };
    let whole = matches!(only, Only::Nodes(_)) && known.is_empty();
    known.extend(parts.iter().filter(|_| whole).map(|part| part.name.clone()));
    let list: Vec<&str> = known.iter().map(String::as_str).collect();
    let missing = only.names().iter().filter(|named| !known.contains(&named.name));
    let missing: Vec<PresetError> =
        missing.take(MISSING_LISTED).map(|named| named.unknown(only.what(), &list)).collect();
    if !missing.is_empty() {
        return Err(Lack::Missing(missing));
    }
    let names: Vec<&str> = only.names().iter().map(|named| named.name.as_str()).collect();
    let members = match (only, obj.filter(|_| !whole)) {
        (Only::Nodes(_), Some(obj)) => obj.in_groups(&names),
        (Only::Materials(_), Some(obj)) => obj.of_materials(&names),
        _ => {
            let is_named = |part: &MeshPart| names.contains(&part.name.as_str());
            let named: Vec<bool> = parts.iter().map(is_named).collect();
            let of = of_positions(parts, count);
            let is_member = |part: &u32| named.get(*part as usize) == Some(&true);
            return Ok(ones(&of.iter().map(is_member).collect::<Vec<_>>()));
        }
    };
    let idle = only.names().iter().filter(|named| !members.used.contains(&named.name));
    warnings.extend(idle.map(|named| without(named, "has no face")));
    Ok(ones(&members.of_positions))
}

/// What can be named.
struct Table<'a> {
    named: BTreeMap<&'a str, Vec<usize>>,
    /// What has no name.
    bare: BTreeSet<usize>,
    all: BTreeSet<usize>,
}

impl<'a> Table<'a> {
    fn new(entries: impl Iterator<Item = (Option<&'a str>, usize)>) -> Self {
        let mut table = Self { named: BTreeMap::new(), bare: BTreeSet::new(), all: BTreeSet::new() };
        for (name, index) in entries {
            table.all.insert(index);
            match name {
                Some(name) => table.named.entry(name).or_default().push(index),
                None => {
                    table.bare.insert(index);
                }
            }
        }
        table
    }

    /// All that has a name, or else the one with that index.
    fn get(&self, named: &Named, what: &str) -> Result<Vec<usize>, PresetError> {
        if let Some(list) = self.named.get(named.name.as_str()) {
            return Ok(list.clone());
        }
        let index = named.name.parse().ok().filter(|index| self.all.contains(index));
        index.map(|index| vec![index]).ok_or_else(|| {
            let bare: Vec<String> = self.bare.iter().map(usize::to_string).collect();
            let known: Vec<&str> =
                self.named.keys().copied().chain(bare.iter().map(String::as_str)).collect();
            named.unknown(what, &known)
        })
    }

    /// All that is named, or the names that are not there, each with what `advice` has to say about it.
    fn look_up<'n>(
        &self,
        only: &'n Only,
        advice: impl Fn(&Named) -> Option<String>,
    ) -> Result<Vec<(&'n Named, Vec<usize>)>, Lack> {
        let (mut found, mut missing) = (Vec::new(), Vec::new());
        for named in only.names() {
            if missing.len() >= MISSING_LISTED {
                break;
            }
            match self.get(named, only.what()) {
                Ok(list) => found.push((named, list)),
                Err(error) => {
                    let parts: Vec<String> =
                        [advice(named), error.help.clone()].into_iter().flatten().collect();
                    let help = (!parts.is_empty()).then(|| parts.join("; "));
                    missing.push(PresetError { help, ..error });
                }
            }
        }
        if missing.is_empty() { Ok(found) } else { Err(Lack::Missing(missing)) }
    }
}

/// That a name is that of a mesh, and which nodes show it.
fn shown_mesh(gltf: &Gltf, named: &Named) -> Option<String> {
    let list =
        |key: &str| gltf.json().get(key).and_then(|list| list.as_array()).map_or(&[][..], Vec::as_slice);
    let mesh = (0..list("meshes").len()).find(|&mesh| gltf.mesh_name(mesh) == Some(named.name.as_str()))?;
    let shows =
        |node: &serde_json::Value| node.get("mesh").and_then(serde_json::Value::as_u64) == Some(mesh as u64);
    let nodes = list("nodes").iter().enumerate().filter(|(_, node)| shows(node));
    let nodes: Vec<String> = nodes.take(NODES_LISTED).map(|(node, _)| node.to_string()).collect();
    Some(match nodes.as_slice() {
        [] => format!("that is mesh {mesh}, which no node shows"),
        [node] => format!("that is mesh {mesh}, shown by node {node}"),
        nodes => format!("that is mesh {mesh}, shown by nodes {}", nodes.join(", ")),
    })
}

/// The warning that a name is there in vain.
fn without(named: &Named, what: &str) -> String {
    let message = format!("\"{}\" {what}", printable(&named.name));
    format!("`only` at {} [only-empty]", named.refused(message))
}

fn ones(members: &[bool]) -> Vec<f32> {
    members.iter().map(|&member| f32::from(u8::from(member))).collect()
}
