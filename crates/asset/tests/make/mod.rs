//! Small documents made by hand.

use serde_json::{Value, json};
use wirework_asset::{AssetError, Gltf, Limits, Rest};

/// A document under construction.
pub(crate) struct Doc {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Doc {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [],
        });
        Self { json, bin: Vec::new() }
    }

    fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().div_ceil(4) * 4, 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub(crate) fn accessor(&mut self, mut accessor: Value, bytes: &[u8]) -> usize {
        accessor["bufferView"] = json!(self.view(bytes));
        self.push("accessors", accessor)
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let lanes = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(json!({ "componentType": 5126, "type": kind, "count": values.len() / lanes }), &bytes)
    }

    pub(crate) fn mesh(&mut self, primitive: &Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    pub(crate) fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let mut bin = self.bin.clone();
        bin.resize(bin.len().div_ceil(4) * 4, 0);
        if !bin.is_empty() {
            json["buffers"] = json!([{ "byteLength": bin.len() }]);
        }
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().div_ceil(4) * 4, b' ');
        let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, data) in [(b"JSON", &text), (b"BIN\0", &bin)] {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(data);
        }
        let total = out.len() as u32;
        out[8..12].copy_from_slice(&total.to_le_bytes());
        out
    }

    pub(crate) fn open(&self) -> Result<Gltf, AssetError> {
        Gltf::from_slice(&self.glb(), "made.glb", &Limits::default())
    }

    pub(crate) fn rest(&self) -> Result<Rest, AssetError> {
        self.open()?.rest()
    }
}

/// A triangle in the plane z = 0 with normals along z, shown by `node`.
pub(crate) fn triangle(mut node: Value) -> Doc {
    let mut doc = Doc::new();
    let positions = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let normals = doc.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    node["mesh"] = json!(doc.mesh(&json!({ "attributes": { "POSITION": positions, "NORMAL": normals } })));
    doc.node(node);
    doc
}

/// Two joints, the second moved by (0, 0, 3) from where it was bound; `weights` of the first vertex.
pub(crate) fn skinned(weights: [f32; 4]) -> Doc {
    let mut doc = triangle(json!({ "skin": 0, "translation": [100, 0, 0] }));
    doc.node(json!({ "translation": [0, 0, 3], "children": [2] }));
    doc.node(json!({ "translation": [0, 5, 0] }));
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut binds = identity.to_vec();
    binds[14] = -3.0;
    binds.extend(identity);
    binds[29] = -5.0;
    let binds = doc.floats("MAT4", &binds);
    doc.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    let joints =
        doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[0, 1, 0, 0].repeat(3));
    let mut all = weights.to_vec();
    all.extend([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let weights = doc.floats("VEC4", &all);
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    doc
}
