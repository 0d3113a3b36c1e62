//! What in a document refers to its tables by number, the common extensions included, and how that is moved up.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use super::moved;
use crate::schema::Kind::{Index, List, Map as Values, Object};
use crate::schema::{Kind, Member, may};

/// Tables that extensions have at the root of a document: `extension/table` is what others call one.
pub(super) const ROOT_TABLES: &[(&str, &str, &[Member])] = &[
    ("KHR_lights_punctual", "lights", &[]),
    ("KHR_materials_variants", "variants", &[]),
    ("KHR_xmp_json_ld", "packets", &[]),
    ("EXT_lights_image_based", "lights", &[may("specularImages", List(&List(&Index("images"))))]),
    ("KHR_techniques_webgl", "programs", PROGRAM),
    ("KHR_techniques_webgl", "shaders", &[may("bufferView", Index("bufferViews"))]),
    ("KHR_techniques_webgl", "techniques", &[may("program", Index("KHR_techniques_webgl/programs"))]),
];

const PROGRAM: &[Member] = &[
    may("fragmentShader", Index("KHR_techniques_webgl/shaders")),
    may("vertexShader", Index("KHR_techniques_webgl/shaders")),
];

const SOURCE: &[Member] = &[may("source", Index("images"))];
const MAPPING: &[Member] =
    &[may("material", Index("materials")), may("variants", List(&Index("KHR_materials_variants/variants")))];

/// What an extension refers to where it stands in an object.
const EXTENSIONS: &[(&str, &[Member])] = &[
    ("EXT_lights_image_based", &[may("light", Index("EXT_lights_image_based/lights"))]),
    ("EXT_mesh_gpu_instancing", &[may("attributes", Values(&Index("accessors")))]),
    // Which buffer it is has been seen to with the buffers.
    ("EXT_meshopt_compression", &[]),
    ("EXT_texture_avif", SOURCE),
    ("EXT_texture_webp", SOURCE),
    ("KHR_draco_mesh_compression", &[may("bufferView", Index("bufferViews"))]),
    ("KHR_lights_punctual", &[may("light", Index("KHR_lights_punctual/lights"))]),
    ("KHR_materials_variants", &[may("mappings", List(&Object(MAPPING)))]),
    ("KHR_mesh_quantization", &[]),
    ("KHR_meshopt_compression", &[]),
    ("KHR_node_visibility", &[]),
    ("KHR_techniques_webgl", &[may("technique", Index("KHR_techniques_webgl/techniques"))]),
    ("KHR_texture_basisu", SOURCE),
    ("KHR_texture_transform", &[]),
    ("KHR_xmp_json_ld", &[may("packet", Index("KHR_xmp_json_ld/packets"))]),
    ("MSFT_texture_dds", SOURCE),
];

/// Refers by a path in the document.
const POINTER: &str = "KHR_animation_pointer";
/// Every extension of this family refers to nothing but textures.
const MATERIALS: &str = "KHR_materials_";

/// By how much the indices of each table are moved.
#[derive(Debug, Default)]
pub(super) struct Shift {
    pub(super) by: BTreeMap<String, usize>,
    /// Extensions that are unknown and may hold indices.
    pub(super) doubts: BTreeSet<String>,
    in_material: bool,
}

impl Shift {
    /// Whether it is known what an extension has at the root.
    pub(super) fn has_tables(extension: &str) -> bool {
        ROOT_TABLES.iter().any(|&(name, _, _)| name == extension)
    }

    /// An entry of a table.
    pub(super) fn entry(&mut self, table: &str, entry: &mut Value, members: &'static [Member]) {
        self.in_material = table == "materials";
        self.value(entry, &Object(members));
    }

    /// What an extension has at the root.
    pub(super) fn whole_document(&mut self, extension: &str, value: &mut Value) {
        self.in_material = false;
        if !Self::has_tables(extension) {
            self.doubt(extension, value);
            return;
        }
        for &(_, key, members) in ROOT_TABLES.iter().filter(|(name, _, _)| *name == extension) {
            for entry in value.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten() {
                self.value(entry, &Object(members));
            }
        }
    }

    fn value(&mut self, value: &mut Value, kind: &Kind) {
        match (*kind, value) {
            (Index(table), value) => {
                if let Some(index) = self.by.get(table).and_then(|&by| moved(value, by)) {
                    *value = index;
                }
            }
            (List(kind), Value::Array(items)) => items.iter_mut().for_each(|item| self.value(item, kind)),
            (Values(kind), Value::Object(object)) => {
                object.values_mut().for_each(|value| self.value(value, kind));
            }
            (Object(members), Value::Object(object)) => self.object(object, members),
            _ => {}
        }
    }

    fn object(&mut self, object: &mut Map<String, Value>, members: &'static [Member]) {
        for (key, value) in object {
            if let ("extensions", Value::Object(extensions)) = (key.as_str(), &mut *value) {
                for (name, extension) in extensions {
                    self.extension(name, extension);
                }
            } else if let Some(member) = members.iter().find(|member| member.key == key) {
                self.value(value, &member.kind);
            }
        }
    }

    fn extension(&mut self, name: &str, value: &mut Value) {
        if name == POINTER {
            self.pointer(value);
        } else if let Some((_, members)) = EXTENSIONS.iter().find(|(known, _)| *known == name) {
            self.value(value, &Object(members));
            if self.in_material && name == "KHR_techniques_webgl" {
                value.get_mut("values").into_iter().for_each(|values| self.textures(values));
            }
        } else if self.in_material {
            self.textures(value);
            if !name.starts_with(MATERIALS) {
                self.doubt(name, value);
            }
        } else {
            self.doubt(name, value);
        }
    }

    /// Moves the `index` of whatever has one: under a material that is a texture.
    fn textures(&self, value: &mut Value) {
        match value {
            Value::Array(items) => items.iter_mut().for_each(|item| self.textures(item)),
            Value::Object(object) => {
                for (key, value) in object {
                    let by = self.by.get("textures").filter(|_| key == "index");
                    match by.and_then(|&by| moved(value, by)) {
                        Some(index) => *value = index,
                        None => self.textures(value),
                    }
                }
            }
            _ => {}
        }
    }

    /// Moves the number in a path such as `/nodes/3/scale` or `/extensions/KHR_lights_punctual/lights/0/color`.
    fn pointer(&self, value: &mut Value) {
        let Some(Value::String(path)) = value.get_mut("pointer") else { return };
        let mut steps: Vec<String> = path.split('/').map(str::to_owned).collect();
        let (table, place) = match steps.as_slice() {
            [_, root, extension, key, ..] if root == "extensions" => (format!("{extension}/{key}"), 4),
            [_, table, ..] => (table.clone(), 2),
            _ => return,
        };
        let Some(&by) = self.by.get(&table) else { return };
        let step = steps.get_mut(place);
        if let Some((step, index)) =
            step.and_then(|step| step.parse::<usize>().ok().map(|index| (step, index)))
        {
            *step = index.saturating_add(by).to_string();
            *path = steps.join("/");
        }
    }

    /// Notes an extension if it holds what may be indices of something that has moved.
    fn doubt(&mut self, name: &str, value: &Value) {
        if self.by.values().any(|&by| by > 0) && may_refer(value, self.in_material) {
            self.doubts.insert(name.to_owned());
        }
    }
}

/// Whether there is a whole number somewhere in a value; textures of a material do not count.
fn may_refer(value: &Value, in_material: bool) -> bool {
    match value {
        Value::Array(items) => items.iter().any(|item| may_refer(item, in_material)),
        Value::Object(object) => object.iter().any(|(key, value)| {
            !(in_material && matches!(key.as_str(), "index" | "texCoord")) && may_refer(value, in_material)
        }),
        Value::Number(number) => number.is_u64(),
        _ => false,
    }
}
