//! Buffer views compressed by meshoptimizer: read as what they were made of, and written as they came.

use base64::Engine;
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{IndexEncoding, VertexEncoding, encode_index_buffer, encode_vertex_buffer};
use serde_json::{Value, json};
use wirework_asset::{ErrorClass, Format, Gltf, Limits, Place};

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.25], [1.0, 1.0, 0.125], [0.0, 1.0, -3.0]];
const CORNERS: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// A square whose positions and indices are compressed, as a `.gltf` with its data in itself.
fn square(extension: &str) -> Value {
    let mut workspace = Workspace::default();
    let bytes: Vec<u8> = SQUARE.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    // The older extension has the older streams.
    let version = u8::from(extension.starts_with("KHR"));
    let encoding = VertexEncoding::new(version, 2).unwrap();
    let mut data = encode_vertex_buffer(&bytes, 4, 12, encoding, &mut workspace).unwrap();
    let first = data.len();
    data.extend(encode_index_buffer(&CORNERS, IndexEncoding::DEFAULT, &mut workspace).unwrap());
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(&data)
    );
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": [extension],
        "extensionsRequired": [extension],
        "buffers": [
            { "byteLength": data.len(), "uri": uri },
            { "byteLength": 72, "extensions": { extension: { "fallback": true } } },
        ],
        "bufferViews": [
            { "buffer": 1, "byteOffset": 0, "byteLength": 48, "byteStride": 12, "extensions": { extension: {
                "buffer": 0, "byteOffset": 0, "byteLength": first, "byteStride": 12, "count": 4, "mode": "ATTRIBUTES" } } },
            { "buffer": 1, "byteOffset": 48, "byteLength": 24, "extensions": { extension: {
                "buffer": 0, "byteOffset": first, "byteLength": data.len() - first, "byteStride": 4, "count": 6,
                "mode": "TRIANGLES" } } },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4,
              "min": [0.0, 0.0, -3.0], "max": [1.0, 1.0, 0.5] },
            { "bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 6 },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "nodes": [{ "mesh": 0 }],
    })
}

fn open(json: &Value) -> Result<Gltf, wirework_asset::AssetError> {
    Gltf::from_slice(&serde_json::to_vec(json).unwrap(), "square.gltf", &Limits::default())
}

fn sorted(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    // The codec may turn a triangle; it keeps its sense.
    let turn = |t: &[u32; 3]| {
        let at = (0..3).min_by_key(|&k| t[k]).unwrap();
        [t[at], t[(at + 1) % 3], t[(at + 2) % 3]]
    };
    triangles.iter().map(turn).collect()
}

#[test]
fn compressed_views_are_read() {
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let rest = open(&square(extension)).unwrap().rest().unwrap();
        assert_eq!(rest.positions, SQUARE);
        assert_eq!(sorted(&rest.triangles), [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn what_is_written_keeps_them_compressed() {
    let mut gltf = open(&square("EXT_meshopt_compression")).unwrap();
    let rest = gltf.rest().unwrap();
    let moved: Vec<[f32; 3]> = rest.positions.iter().map(|[x, y, z]| [x + 1.0, *y, *z]).collect();
    gltf.set_still(&rest, &moved, None, None).unwrap();
    for format in [Format::Glb, Format::Gltf] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join(if format == Format::Glb { "a.glb" } else { "a.gltf" });
        let files = gltf.files(&out, format).unwrap();
        let bytes: usize = files.iter().map(|file| file.bytes().unwrap().len()).sum();
        assert!(bytes < 4000, "{bytes}");
        wirework_asset::write_files(&files).unwrap();
        let again = Gltf::read(&out, &Limits::default()).unwrap();
        assert_eq!(again.rest().unwrap().positions, moved);
        let buffers = again.json()["buffers"].as_array().unwrap();
        let apart = buffers.iter().find(|buffer| buffer.get("extensions").is_some()).unwrap();
        assert_eq!(apart["byteLength"], json!(72));
        assert!(apart.get("uri").is_none());
        // The old view still decodes to the old indices.
        assert_eq!(sorted(&again.rest().unwrap().triangles), [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn what_cannot_be_decoded_is_refused_where_it_is_read() {
    let base = "/bufferViews/0/extensions/EXT_meshopt_compression";
    for (place, value, named) in [
        ("/mode", json!("POINTS"), "/mode"),
        ("/filter", json!("COLOR"), "/filter"),
        ("/count", json!(5), ""),
        ("/byteStride", json!(16), ""),
        ("/byteLength", json!(9), ""),
        ("/byteLength", json!(99_999), "/byteLength"),
        ("/byteOffset", json!(3), ""),
        ("/buffer", json!(7), "/buffer"),
    ] {
        let mut json = square("EXT_meshopt_compression");
        let entry = json.pointer_mut(base).unwrap();
        entry[&place[1..]] = value;
        let gltf = open(&json).unwrap();
        assert!(gltf.warnings().iter().any(|warning| warning.code == "compressed-view"), "{place}");
        let error = gltf.rest().unwrap_err();
        assert_eq!((error.class, error.place), (ErrorClass::Asset, Place::Pointer(format!("{base}{named}"))));
        assert!(error.found.len() > 5);
    }
    // One that no geometry reads is only told.
    let mut json = square("EXT_meshopt_compression");
    let spare = json["bufferViews"][1].clone();
    json["bufferViews"].as_array_mut().unwrap().push(spare);
    json["bufferViews"][2]["extensions"]["EXT_meshopt_compression"]["byteLength"] = json!(1);
    let gltf = open(&json).unwrap();
    assert!(gltf.warnings().iter().any(|warning| warning.code == "compressed-view"));
    assert!(gltf.rest().is_ok());
}

#[test]
fn a_buffer_without_data_is_charged_before_it_is_made() {
    let mut json = square("EXT_meshopt_compression");
    json["buffers"][1]["byteLength"] = json!(1_u64 << 60);
    assert_eq!(open(&json).unwrap_err().class, ErrorClass::Limit);
}
