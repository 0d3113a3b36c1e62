//! The same attributes in every morph target of a primitive.
//!
//! The standard lets each target have its own; what one lacks keeps its base value, so that to lack an attribute and to have zeros
//! is the same. Engines do not play it so. three.js takes the *base* attribute for a displacement that is missing as soon as
//! another target has one: a target without positions throws its mesh out by its own size, one without normals bends the normals
//! of all others. Babylon.js morphs an attribute only while every target that plays has it. An input whose targets have no
//! normals, played right alone, would so be played wrong beside ours, that have them. Therefore what some targets of a primitive
//! have the others get, as zeros: the input's, whose own members stay as they are, and ours.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::content::Content;
use crate::document::Gltf;
use crate::edit::{FLOAT, whole};
use crate::error::AssetError;

impl Gltf {
    /// Gives each morph target of the primitives of `mesh` what others of the same primitive have, as zeros.
    pub(crate) fn even_targets(&mut self, mesh: usize) -> Result<(), AssetError> {
        let mut known = BTreeMap::new();
        for primitive in 0..self.primitives_mut(mesh)?.len() {
            for (target, key, like) in self.uneven(mesh, primitive) {
                let zeros = self.zeros(&key, like, &mut known)?;
                let targets =
                    self.primitives_mut(mesh)?.get_mut(primitive).and_then(|p| p.get_mut("targets"));
                let target =
                    targets.and_then(|targets| targets.get_mut(target)).and_then(Value::as_object_mut);
                if let (Some(target), Some(zeros)) = (target, zeros) {
                    target.insert(key, json!(zeros));
                }
            }
        }
        Ok(())
    }

    /// What the targets of a primitive lack: which target, which attribute, and the accessor by which another target has it. Not an
    /// attribute that the primitive itself has not: no target may have that.
    fn uneven(&self, mesh: usize, primitive: usize) -> Vec<(usize, String, usize)> {
        let json = self.list("meshes").get(mesh).and_then(|mesh| mesh.get("primitives")?.get(primitive));
        let part = |key| json.and_then(|json| json.get(key));
        let (Some(base), Some(targets)) = (part("attributes"), part("targets").and_then(Value::as_array))
        else {
            return Vec::new();
        };
        let members = targets.iter().filter_map(Value::as_object).flatten();
        let mut all: Vec<(&String, usize)> = Vec::new();
        for (key, accessor) in members.filter(|(key, _)| base.get(key.as_str()).is_some()) {
            if let Some(accessor) = whole(accessor).filter(|_| all.iter().all(|(known, _)| *known != key)) {
                all.push((key, accessor));
            }
        }
        let lacking = targets.iter().enumerate().flat_map(|(index, target)| {
            let lacks = move |(key, _): &&(&String, usize)| target.get(key.as_str()).is_none();
            all.iter().filter(lacks).map(move |&(key, like)| (index, key.clone(), like))
        });
        lacking.collect()
    }

    /// An accessor of zeros as many and as wide as those of `like`; `known` are those that there are by type and number.
    fn zeros(
        &mut self,
        key: &str,
        like: usize,
        known: &mut BTreeMap<(String, usize, bool), usize>,
    ) -> Result<Option<usize>, AssetError> {
        let like = self.list("accessors").get(like);
        let kind = like.and_then(|like| like.get("type")?.as_str()).map(str::to_owned);
        let count = like.and_then(|like| like.get("count")).and_then(whole);
        let (Some(kind), Some(count)) = (kind, count) else { return Ok(None) };
        // Positions must say how far they go.
        let bounds = key == "POSITION";
        let slot = (kind, count, bounds);
        if let Some(&accessor) = known.get(&slot) {
            return Ok(Some(accessor));
        }
        let accessor = match slot.0.as_str() {
            "VEC3" => self.append_deltas(crate::limits::filled(count, [0.0; 3])?, bounds)?,
            "SCALAR" => self.append_zeros(&slot.0, 1, count)?,
            "VEC2" => self.append_zeros(&slot.0, 2, count)?,
            "VEC4" => self.append_zeros(&slot.0, 4, count)?,
            _ => return Ok(None),
        };
        known.insert(slot, accessor);
        Ok(Some(accessor))
    }

    /// Zeros with one of them said: an accessor with neither data nor sparse elements is refused by several readers.
    fn append_zeros(&mut self, kind: &str, lanes: usize, count: usize) -> Result<usize, AssetError> {
        let indices = self.append_view(vec![0], None)?;
        let values = self.append_view(Content::floats(vec![0.0; lanes]), None)?;
        let sparse = json!({
            "count": 1,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        self.append(
            "accessors",
            json!({ "componentType": FLOAT, "count": count, "type": kind, "sparse": sparse }),
        )
    }
}
