//! Adding morph targets to a mesh, with all that has to follow: weights, names, and the tracks of other clips.

use serde_json::{Map, Value, json};

use crate::document::Gltf;
use crate::edit::{drop_compressed, whole};
use crate::error::{AssetError, Place, Warning};
use crate::limits::Budget;

/// A morph target of one primitive: accessors of displacements, as [`Gltf::append_deltas`] makes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MorphTarget {
    /// Displacements of the positions.
    pub position: usize,
    /// What to add to the normals; only for a primitive with normals.
    pub normal: Option<usize>,
    /// What to add to the tangents, whose handedness stays; only for a primitive with tangents.
    pub tangent: Option<usize>,
}

/// A morph target for all primitives of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshTarget {
    /// Its name, for `extras.targetNames`.
    pub name: String,
    /// One entry a primitive of the mesh, in their order.
    pub primitives: Vec<MorphTarget>,
}

impl Gltf {
    /// How many morph targets a mesh has.
    pub fn target_count(&self, mesh: usize) -> usize {
        let first =
            self.list("meshes").get(mesh).and_then(|mesh| mesh.get("primitives")?.get(0)?.get("targets"));
        first.and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// The default weights of a node's morph targets: its own, else its mesh's, else zeros.
    pub fn default_weights(&self, node: usize) -> Vec<f32> {
        let Some(json) = self.list("nodes").get(node) else { return Vec::new() };
        let mesh = json.get("mesh").and_then(whole);
        let count = mesh.map_or(0, |mesh| self.target_count(mesh));
        let of_mesh = || mesh.and_then(|mesh| self.list("meshes").get(mesh)?.get("weights"));
        let weights = json.get("weights").or_else(of_mesh).and_then(Value::as_array);
        let number = |k: usize| weights.and_then(|list| list.get(k)?.as_f64()).unwrap_or(0.0) as f32;
        (0..count).map(number).collect()
    }

    /// Appends `targets` to every primitive of `mesh`. Where there were targets, they stay in front; default weights
    /// and the weight tracks of all nodes that show the mesh are continued with zeros. Attributes that only some targets of a
    /// primitive have, old or new, the others get as zeros, since engines play mixed ones wrong.
    ///
    /// # Errors
    ///
    /// A mesh, node or animation that is malformed; a target without an entry for each primitive.
    pub fn add_targets(&mut self, mesh: usize, targets: &[MeshTarget]) -> Result<(), AssetError> {
        let file = self.file.clone();
        self.append_targets(mesh, targets).map_err(|error| error.in_file(&file))
    }

    fn append_targets(&mut self, mesh: usize, targets: &[MeshTarget]) -> Result<(), AssetError> {
        let before = self.target_count(mesh);
        let after = before + targets.len();
        let primitives = self.primitives_mut(mesh)?;
        let count = primitives.len();
        for (index, primitive) in primitives.iter_mut().enumerate() {
            let place = || Place::Pointer(format!("/meshes/{mesh}/primitives/{index}"));
            let Some(primitive) = primitive.as_object_mut() else {
                return Err(AssetError::new(place(), "a value of another kind", "a primitive"));
            };
            let list = primitive.entry("targets").or_insert_with(|| json!([]));
            let Some(list) = list.as_array_mut().filter(|list| list.len() == before) else {
                return Err(AssetError::new(place(), "other morph targets", "those of the first primitive"));
            };
            for target in targets {
                let Some(entry) = target.primitives.get(index) else {
                    let found = format!("{count} primitives");
                    return Err(AssetError::new(place(), found, format!("{}", target.primitives.len())));
                };
                list.push(entry.to_json());
            }
            drop_compressed(primitive);
        }
        self.even_targets(mesh)?;
        let entry = self.entry_mut("meshes", mesh)?;
        extend_weights(entry, after, true);
        if let Err(message) = extend_names(entry, before, targets) {
            let place = Place::Pointer(format!("/meshes/{mesh}/extras"));
            self.warnings.push(Warning::new("target-names", place, message));
        }
        let nodes = self.nodes_of(mesh);
        for &node in &nodes {
            extend_weights(self.entry_mut("nodes", node)?, after, false);
        }
        if before > 0 { self.continue_tracks(&nodes, before, after) } else { Ok(()) }
    }

    /// Gives the weight tracks of `nodes` zeros for new targets: a new output accessor each.
    fn continue_tracks(&mut self, nodes: &[usize], before: usize, after: usize) -> Result<(), AssetError> {
        for clip in 0..self.list("animations").len() {
            let samplers = self.tracks_of(clip, nodes);
            for (sampler, channels, shared) in samplers {
                let Some(values) = self.continued(clip, sampler, before, after)? else { continue };
                let output = self.append_scalars(values, false)?;
                let animation = self.entry_mut("animations", clip)?;
                let Some(list) = animation.get_mut("samplers").and_then(Value::as_array_mut) else {
                    continue;
                };
                let Some(old) = list.get_mut(sampler) else { continue };
                if !shared {
                    old["output"] = json!(output);
                    continue;
                }
                let mut copy = old.clone();
                copy["output"] = json!(output);
                list.push(copy);
                let copy = list.len() - 1;
                let list = animation.get_mut("channels").and_then(Value::as_array_mut);
                for channel in list.into_iter().flatten().enumerate().filter(|(i, _)| channels.contains(i)) {
                    channel.1["sampler"] = json!(copy);
                }
            }
        }
        Ok(())
    }

    /// The samplers of a clip that move the weights of `nodes`: which channels use each for that, and whether other
    /// channels use it too.
    fn tracks_of(&self, clip: usize, nodes: &[usize]) -> Vec<(usize, Vec<usize>, bool)> {
        let channels = self.list("animations").get(clip).and_then(|clip| clip.get("channels")?.as_array());
        let mut out: Vec<(usize, Vec<usize>, bool)> = Vec::new();
        let sampler_of = |channel: &Value| channel.get("sampler").and_then(whole);
        let ours = |channel: &Value| {
            let target = channel.get("target");
            let node = target.and_then(|target| target.get("node")).and_then(whole);
            target.and_then(|target| target.get("path")?.as_str()) == Some("weights")
                && node.is_some_and(|node| nodes.contains(&node))
        };
        let channels = channels.map_or(&[][..], Vec::as_slice);
        for (index, channel) in channels.iter().enumerate().filter(|(_, channel)| ours(channel)) {
            let Some(sampler) = sampler_of(channel) else { continue };
            match out.iter_mut().find(|(known, _, _)| *known == sampler) {
                Some((_, list, _)) => list.push(index),
                None => out.push((sampler, vec![index], false)),
            }
        }
        for (sampler, _, shared) in &mut out {
            *shared = channels.iter().any(|channel| !ours(channel) && sampler_of(channel) == Some(*sampler));
        }
        out
    }

    /// The weights of a sampler, continued with zeros. None, with a warning, where they do not fit the mesh.
    fn continued(
        &mut self,
        clip: usize,
        sampler: usize,
        before: usize,
        after: usize,
    ) -> Result<Option<Vec<f32>>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let json = self.root().need("animations")?.item(clip)?.need("samplers")?.item(sampler)?;
        let keys = self.accessor(json.need("input")?)?.count;
        let output = self.accessor(json.need("output")?)?;
        let parts = match json.get("interpolation")?.map(|value| value.value().as_str()) {
            Some(Some("CUBICSPLINE")) => 3,
            _ => 1,
        };
        let expected = keys.checked_mul(before).and_then(|n| n.checked_mul(parts));
        if output.lanes != 1 || expected != Some(output.count) {
            let message = "the weight track does not fit the mesh's morph targets; it is left as it is";
            let warning = Warning::new("weight-track", json.place(), message);
            self.warnings.push(warning);
            return Ok(None);
        }
        let old = output.floats::<1>(&mut budget)?;
        let mut values = crate::limits::reserve(keys.saturating_mul(after).saturating_mul(parts))?;
        for key in old.chunks(before) {
            values.extend_from_slice(key.as_flattened());
            values.resize(values.len() + after - before, 0.0);
        }
        Ok(Some(values))
    }

    /// Gives each node of the scene that shows `mesh` the targets it needs: where they differ, the mesh is copied.
    /// Nodes that need none share the first mesh; nothing moves them, for the weights of their targets stay 0.
    ///
    /// Pairs of nodes and their targets, all of one mesh.
    ///
    /// # Errors
    ///
    /// A mesh that there is not, or whose primitives are not as the targets say.
    pub fn add_targets_by_node(
        &mut self,
        mesh: usize,
        nodes: &[(usize, &[MeshTarget])],
    ) -> Result<(), AssetError> {
        let mut groups: Vec<(&[MeshTarget], Vec<usize>)> = Vec::new();
        for &(node, targets) in nodes.iter().filter(|(_, targets)| !targets.is_empty()) {
            match groups.iter_mut().find(|(known, _)| *known == targets) {
                Some((_, list)) => list.push(node),
                None => groups.push((targets, vec![node])),
            }
        }
        let file = self.file.clone();
        let mut meshes = Vec::new();
        for (k, (_, nodes)) in groups.iter().enumerate() {
            let of_group = if k == 0 { Ok(mesh) } else { self.copy_mesh(mesh, nodes) };
            meshes.push(of_group.map_err(|error| error.in_file(&file))?);
        }
        for ((targets, _), mesh) in groups.iter().zip(meshes) {
            self.add_targets(mesh, targets)?;
        }
        Ok(())
    }
}

impl MorphTarget {
    fn to_json(self) -> Value {
        let mut target = json!({ "POSITION": self.position });
        for (key, accessor) in [("NORMAL", self.normal), ("TANGENT", self.tangent)] {
            if let Some(accessor) = accessor {
                target[key] = json!(accessor);
            }
        }
        target
    }
}

/// Continues `weights` with zeros; made where missing if `always`.
fn extend_weights(entry: &mut Map<String, Value>, count: usize, always: bool) {
    if always {
        entry.entry("weights").or_insert_with(|| json!([]));
    }
    if let Some(weights) = entry.get_mut("weights").and_then(Value::as_array_mut) {
        weights.resize(count.max(weights.len()), json!(0));
    }
}

/// Continues `extras.targetNames`; targets that had no name get one, so that ours stand at their places.
fn extend_names(
    entry: &mut Map<String, Value>,
    before: usize,
    targets: &[MeshTarget],
) -> Result<(), &'static str> {
    let extras = entry.entry("extras").or_insert_with(|| json!({}));
    let extras = extras.as_object_mut().ok_or("extras is no object; the new morph targets have no names")?;
    let names = extras.entry("targetNames").or_insert_with(|| json!([]));
    let names = names.as_array_mut().ok_or("targetNames is no list; the new morph targets have no names")?;
    names.truncate(before);
    for k in names.len()..before {
        names.push(json!(format!("target_{k}")));
    }
    let mut taken: std::collections::BTreeSet<String> =
        names.iter().filter_map(Value::as_str).map(str::to_owned).collect();
    for target in targets {
        let numbered = (2_usize..).map(|n| format!("{}_{n}", target.name));
        let mut free = std::iter::once(target.name.clone()).chain(numbered);
        let name = free.find(|name| !taken.contains(name)).unwrap_or_default();
        taken.insert(name.clone());
        names.push(json!(name));
    }
    Ok(())
}
