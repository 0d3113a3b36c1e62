//! What a scene shows at rest as a document of its own, that shows it without nodes that move, skins, morph targets or clips: for players
//! that place vertices themselves.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use crate::attributes::texture_coordinates;
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::limits::{Budget, reserve};
use crate::primitive::Mode;
use crate::rest::{Block, Part, Rest};

/// Tables that say how surfaces look, which are kept as they are.
const LOOKS: [&str; 4] = ["images", "samplers", "textures", "materials"];

/// What the vertices of a flat document have besides their positions, one entry a vertex of the rest.
#[derive(Clone, Copy, Debug)]
pub struct Flat<'a> {
    /// Unit normals.
    pub normals: &'a [[f32; 3]],
    /// The second texture coordinates; the model's own second ones become the third, and so on.
    pub uvs: &'a [[f32; 2]],
}

impl Gltf {
    /// A document with one node for each that `rest`, the rest of this one, shows, all at the origin: vertices are where they are in the
    /// world, in the order of the rest. Materials and images are kept, with their numbers, texture coordinates and vertex colours as well.
    /// Skins, morph targets, clips, cameras, lights and tangents are not.
    ///
    /// # Errors
    ///
    /// What is read of it and malformed; the limits.
    pub fn flat(&self, rest: &Rest, flat: &Flat<'_>) -> Result<Self, AssetError> {
        self.make_flat(rest, flat).map_err(|error| error.in_file(&self.file))
    }

    fn make_flat(&self, rest: &Rest, flat: &Flat<'_>) -> Result<Self, AssetError> {
        let mut out = Self::from_meshes_within(&self.file, &[], &self.limits)?;
        self.copy_looks(&mut out)?;
        let colors = self.colors(rest)?;
        let mut budget = Budget::new(&self.limits);
        let mut attributes = Vec::with_capacity(rest.blocks.len());
        for ((block, part), colors) in rest.blocks.iter().zip(rest.first_parts()).zip(colors) {
            attributes.push(self.copy_block(&mut out, rest, (block, part), flat, colors, &mut budget)?);
        }
        let mut nodes = Vec::new();
        for parts in rest.parts.chunk_by(|a, b| (a.node, a.mesh) == (b.node, b.mesh)) {
            let mut primitives = Vec::with_capacity(parts.len());
            for part in parts {
                primitives.push(self.copy_part(&mut out, rest, part, &attributes, &mut budget)?);
            }
            let Some(first) = parts.first() else { continue };
            let name = self.node_name(first.node).or(self.mesh_name(first.mesh)).unwrap_or("mesh");
            let mesh = out.append("meshes", json!({ "name": name, "primitives": primitives }))?;
            nodes.push(out.append("nodes", json!({ "name": name, "mesh": mesh }))?);
        }
        out.json["scenes"][0]["nodes"] = json!(nodes);
        out.keep_extensions(&self.json);
        Ok(out)
    }

    /// Copies materials and what they look at; images become part of the document, as far as they can be read.
    fn copy_looks(&self, out: &mut Self) -> Result<(), AssetError> {
        for key in LOOKS {
            if let Some(table) = self.json.get(key) {
                out.json[key] = table.clone();
            }
        }
        if let Some(materials) = out.json.get_mut("materials") {
            count_up(materials);
        }
        let mut budget = Budget::new(&self.limits);
        for index in 0..self.list("images").len() {
            let image = match self.read_image(index, &mut budget) {
                Ok(image) => image,
                Err(error) => {
                    out.warnings.push(Warning::instead(&error, "image", "it is missing"));
                    let entry = out.entry_mut("images", index)?;
                    // A view of this document would be another's data there.
                    if entry.shift_remove("bufferView").is_some() {
                        entry.insert("uri".to_owned(), json!("missing.png"));
                    }
                    continue;
                }
            };
            let media = image.media_type.clone();
            let view = out.append_view(image.bytes.into_owned(), None)?;
            let entry = out.entry_mut("images", index)?;
            entry.shift_remove("uri");
            entry.insert("bufferView".to_owned(), json!(view));
            if let Some(media) = media {
                entry.insert("mimeType".to_owned(), json!(media));
            }
        }
        Ok(())
    }

    /// Copies the vertices of a block, and gives the attributes of primitives that have them.
    fn copy_block(
        &self,
        out: &mut Self,
        rest: &Rest,
        (block, part): (&Block, Option<&Part>),
        flat: &Flat<'_>,
        colors: Option<Vec<[f32; 4]>>,
        budget: &mut Budget,
    ) -> Result<Value, AssetError> {
        let range = block.first..block.first + block.count;
        let fault = || AssetError::file("vertices of another document", "the rest of this one");
        let positions = rest.positions.get(range.clone()).ok_or_else(fault)?.to_vec();
        let normals = flat.normals.get(range.clone()).ok_or_else(fault)?.to_vec();
        let uvs = flat.uvs.get(range).ok_or_else(fault)?.to_vec();
        let mut attributes = Map::new();
        attributes.insert("POSITION".to_owned(), json!(out.append_vertices(positions, true)?));
        attributes.insert("NORMAL".to_owned(), json!(out.append_vertices(normals, false)?));
        // The second coordinates need first ones.
        let first = block.uvs.clone().unwrap_or_else(|| vec![[0.0; 2]; block.count]);
        attributes.insert("TEXCOORD_0".to_owned(), json!(out.append_vertices(first, false)?));
        attributes.insert("TEXCOORD_1".to_owned(), json!(out.append_vertices(uvs, false)?));
        if let Some(part) = part {
            let (primitive, mut told) = (self.primitive(part)?, Vec::new());
            for set in 1.. {
                let Some(own) = texture_coordinates(self, primitive, set, budget, &mut told)? else { break };
                let accessor = out.append_vertices(own, false)?;
                attributes.insert(format!("TEXCOORD_{}", set + 1), json!(accessor));
            }
        }
        if let Some(colors) = colors {
            attributes.insert("COLOR_0".to_owned(), json!(out.append_vertices(colors, false)?));
        }
        Ok(Value::Object(attributes))
    }

    /// Copies what vertices are joined to.
    fn copy_part(
        &self,
        out: &mut Self,
        rest: &Rest,
        part: &Part,
        attributes: &[Value],
        budget: &mut Budget,
    ) -> Result<Value, AssetError> {
        let block = rest.blocks.get(part.block);
        let (first, count) = block.map_or((0, 0), |block| (block.first as u32, block.count));
        let mut primitive = json!({ "attributes": attributes.get(part.block) });
        let joined = rest.triangles.get(part.first_triangle..part.first_triangle + part.triangle_count);
        let mode = match joined {
            Some(triangles) if part.triangle_count > 0 => {
                let mut flat = reserve(3 * triangles.len())?;
                flat.extend(triangles.as_flattened().iter().map(|i| i.saturating_sub(first)));
                primitive["indices"] = json!(out.append_indices(&flat, count)?);
                Mode::Triangles
            }
            _ => {
                if let Some(indices) = self.indices(self.primitive(part)?, count, budget)? {
                    primitive["indices"] = json!(out.append_indices(&indices, count)?);
                }
                part.mode
            }
        };
        if mode != Mode::Triangles {
            primitive["mode"] = json!(mode as u8);
        }
        if let Some(material) = part.material {
            primitive["material"] = json!(material);
        }
        Ok(primitive)
    }

    /// Names the extensions that what was kept makes use of.
    fn keep_extensions(&mut self, old: &Value) {
        let mut there = BTreeSet::new();
        LOOKS.iter().filter_map(|key| self.json.get(key)).for_each(|table| extensions_in(table, &mut there));
        for key in ["extensionsUsed", "extensionsRequired"] {
            let named = old.get(key).and_then(Value::as_array).into_iter().flatten();
            let kept: Vec<&Value> =
                named.filter(|name| name.as_str().is_some_and(|name| there.contains(name))).collect();
            if !kept.is_empty() {
                self.json[key] = json!(kept);
            }
        }
    }
}

/// Notes the names of the extensions in a value.
fn extensions_in(value: &Value, there: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                if key == "extras" {
                    continue;
                }
                if let Some(extensions) = value.as_object().filter(|_| key == "extensions") {
                    there.extend(extensions.keys().cloned());
                }
                extensions_in(value, there);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| extensions_in(item, there)),
        _ => {}
    }
}

/// Counts up the sets of texture coordinates behind the first that materials look at: another one has come before them.
fn count_up(value: &mut Value) {
    match value {
        Value::Object(members) => {
            for (key, value) in members.iter_mut().filter(|(key, _)| *key != "extras") {
                match value.as_u64().filter(|&set| key == "texCoord" && (1..1 << 32).contains(&set)) {
                    Some(set) => *value = json!(set + 1),
                    None => count_up(value),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(count_up),
        _ => {}
    }
}
