//! A clip as the tracks of nodes.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use crate::attributes;
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::graph::{Graph, Pose};
use crate::json::Json;
use crate::limits::Budget;
use crate::track::{Path, Track};

/// A track and the node that it moves.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    pub(crate) node: usize,
    pub(crate) path: Path,
    pub(crate) track: Track,
}

impl Gltf {
    /// Reads and checks all channels of a clip. Those that move no property of a node are passed over.
    pub(crate) fn channels(
        &self,
        clip: usize,
        graph: &Graph,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<Channel>, AssetError> {
        let clip = match self.table("animations")? {
            Some(table) => table.item(clip)?,
            None => return Err(AssetError::file("a document without clips", format!("a clip {clip}"))),
        };
        let samplers = clip.need("samplers")?;
        let count = samplers.array()?.len();
        let (mut taken, mut known) = (BTreeSet::new(), BTreeMap::new());
        let mut out = Vec::new();
        for channel in clip.need("channels")?.items()? {
            let sampler = channel.need("sampler")?.index("sampler", count)?;
            let target = channel.need("target")?;
            let Some((node, path)) = self.target(target, graph, &mut known, warnings)? else { continue };
            if !taken.insert((node, path)) {
                let found = format!("another track of the {} of node {node}", path.name());
                return Err(target.found(found, "one track of each property"));
            }
            let track = Track::read(self, samplers.item(sampler)?, path, budget, warnings)?;
            out.push(Channel { node, path, track });
        }
        Ok(out)
    }

    /// The node and the property that a channel moves; `known` are the numbers of targets of some meshes.
    fn target(
        &self,
        target: Json<'_>,
        graph: &Graph,
        known: &mut BTreeMap<usize, usize>,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<(usize, Path)>, AssetError> {
        let mut passed = |at: Json<'_>, what: String| {
            let message = format!("a track of {what}; it is not played");
            warnings.push(Warning::new("track", at.place(), message));
        };
        let name = target.need("path")?;
        let Some(reference) = target.get("node")? else {
            passed(target, "something that is no node".to_owned());
            return Ok(None);
        };
        let node = reference.index("node", graph.nodes.len())?;
        let path = match name.string()? {
            "translation" => Path::Translation,
            "rotation" => Path::Rotation,
            "scale" => Path::Scale,
            "weights" => Path::Weights(self.targets(node, reference, graph, known)?),
            other => {
                passed(name, format!("the property {other:?}"));
                return Ok(None);
            }
        };
        if matches!(graph.nodes[node].pose, Pose::Matrix(_)) && !matches!(path, Path::Weights(_)) {
            let found = format!("node {node}, which has a matrix");
            return Err(reference.found(found, "a node with translation, rotation and scale"));
        }
        Ok(Some((node, path)))
    }

    /// How many morph targets the mesh of a node has, at least one.
    fn targets(
        &self,
        node: usize,
        reference: Json<'_>,
        graph: &Graph,
        known: &mut BTreeMap<usize, usize>,
    ) -> Result<usize, AssetError> {
        let count = match graph.nodes[node].mesh {
            None => 0,
            Some(mesh) => match known.entry(mesh) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(slot) => {
                    let mesh = self.root().need("meshes")?.item(mesh)?;
                    *slot.insert(attributes::target_count(mesh.need("primitives")?)?)
                }
            },
        };
        if count == 0 {
            let found = format!("node {node}, which shows no morph targets");
            return Err(reference.found(found, "a node whose mesh has some"));
        }
        Ok(count)
    }
}

impl Path {
    fn name(self) -> &'static str {
        match self {
            Self::Translation => "translation",
            Self::Rotation => "rotation",
            Self::Scale => "scale",
            Self::Weights(_) => "weights",
        }
    }
}
