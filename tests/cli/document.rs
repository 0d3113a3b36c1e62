//! Documents as bare JSON and bytes, read without the library: what two of them differ in.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use percent_encoding::percent_decode_str;
use serde_json::{Value, json};

/// A document and the bytes of its buffers.
pub(crate) struct Document {
    pub(crate) json: Value,
    pub(crate) buffers: Vec<Vec<u8>>,
    /// The BIN chunk, padding included.
    pub(crate) bin: Option<Vec<u8>>,
}

impl Document {
    pub(crate) fn open(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let (json, bin) = if bytes.starts_with(b"glTF") { chunks(&bytes) } else { (parse(&bytes), None) };
        let load = |buffer: &Value| match buffer["uri"].as_str() {
            None => bin.clone().expect("a BIN chunk"),
            Some(uri) => match uri.split_once(";base64,") {
                Some((_, data)) => STANDARD.decode(data).expect("base64"),
                None => std::fs::read(beside(path, uri)).expect("a buffer"),
            },
        };
        let buffers = list(&json, "buffers").iter().map(load).collect();
        Self { json, buffers, bin }
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, index: usize) -> &[u8] {
        let view = &self.json["bufferViews"][index];
        let number = |key: &str| view[key].as_u64().unwrap_or(0) as usize;
        &self.buffers[number("buffer")][number("byteOffset")..][..number("byteLength")]
    }
}

/// The file that a URI names beside a document.
pub(crate) fn beside(document: &Path, uri: &str) -> PathBuf {
    document.with_file_name(percent_decode_str(uri).decode_utf8().expect("UTF-8").as_ref())
}

/// The files beside a document that it refers to.
pub(crate) fn uris(json: &Value) -> Vec<String> {
    let entries = ["buffers", "images"].into_iter().flat_map(|key| list(json, key));
    let uris = entries.filter_map(|entry| entry["uri"].as_str());
    uris.filter(|uri| !uri.starts_with("data:")).map(str::to_owned).collect()
}

pub(crate) fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn parse(text: &[u8]) -> Value {
    serde_json::from_slice(text).expect("JSON")
}

/// The JSON and the BIN chunk of a GLB.
pub(crate) fn chunks(glb: &[u8]) -> (Value, Option<Vec<u8>>) {
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("4 bytes")) as usize;
    let end = 20 + length(12);
    let bin = (glb.len() > end).then(|| glb[end + 8..][..length(end)].to_vec());
    (parse(&glb[20..end]), bin)
}

/// A GLB of these chunks.
pub(crate) fn glb(json: &Value, bin: Option<&[u8]>) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).expect("JSON");
    text.resize(text.len().div_ceil(4) * 4, b' ');
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let chunks = [(b"JSON", Some(text.as_slice())), (b"BIN\0", bin)];
    for (kind, data) in chunks.into_iter().filter_map(|(kind, data)| Some((kind, data?))) {
        out.extend((data.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(data);
    }
    let total = (out.len() as u32).to_le_bytes();
    out[8..12].copy_from_slice(&total);
    out
}

/// Something that two values differ in: where, what was there and what is.
#[derive(Debug)]
pub(crate) struct Difference {
    /// Keys and numbers from the root on.
    pub(crate) path: Vec<String>,
    pub(crate) old: Option<Value>,
    pub(crate) new: Option<Value>,
}

/// All that two values differ in. `extensions` and `extras` are compared as text: order and spelling count there.
pub(crate) fn differences(old: &Value, new: &Value) -> Vec<Difference> {
    let mut out = Vec::new();
    compare(&mut Vec::new(), old, new, &mut out);
    out
}

fn compare(path: &mut Vec<String>, old: &Value, new: &Value, out: &mut Vec<Difference>) {
    let mut differ = |path: &[String], old: Option<&Value>, new: Option<&Value>| {
        out.push(Difference { path: path.to_vec(), old: old.cloned(), new: new.cloned() });
    };
    let unknown = path.iter().any(|key| key == "extensions" || key == "extras");
    let pairs: Vec<(String, Option<&Value>, Option<&Value>)> = match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            // What was there keeps its order.
            let kept: Vec<_> = b.keys().filter(|key| a.contains_key(*key)).collect();
            let order = a.keys().filter(|key| b.contains_key(*key)).eq(kept);
            if unknown && !order {
                differ(path, Some(old), Some(new));
            }
            let added =
                b.iter().filter(|(key, _)| !a.contains_key(*key)).map(|(k, v)| (k.clone(), None, Some(v)));
            a.iter().map(|(key, value)| (key.clone(), Some(value), b.get(key))).chain(added).collect()
        }
        (Value::Array(a), Value::Array(b)) => {
            (0..a.len().max(b.len())).map(|i| (i.to_string(), a.get(i), b.get(i))).collect()
        }
        _ => {
            // Numbers are equal that are spelt alike.
            if old != new {
                differ(path, Some(old), Some(new));
            }
            return;
        }
    };
    for (key, old, new) in pairs {
        path.push(key);
        match (old, new) {
            (Some(old), Some(new)) => compare(path, old, new, out),
            _ => out.push(Difference { path: path.clone(), old: old.cloned(), new: new.cloned() }),
        }
        path.pop();
    }
}

/// Puts something that nobody knows into every object that the standard lets have it.
pub(crate) fn plant(json: &mut Value) {
    // Numbers in spellings that a float or an integer of 64 bits would not bring back.
    let text = r#"{"z": [1.50, -0.0, 12345678901234567890123, 1e-7], "a": {"é": null, "mesh": 0}}"#;
    let unknown: Value = serde_json::from_str(text).expect("JSON");
    plant_below(json, &unknown);
    match json.get_mut("extensionsUsed").and_then(Value::as_array_mut) {
        Some(used) => used.push(json!("EXT_nobody_knows")),
        None => json["extensionsUsed"] = json!(["EXT_nobody_knows"]),
    }
}

fn plant_below(value: &mut Value, unknown: &Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| plant_below(item, unknown)),
        Value::Object(members) => {
            for (name, member) in members.iter_mut() {
                if !["extensions", "extras", "attributes", "targets"].contains(&name.as_str()) {
                    plant_below(member, unknown);
                }
            }
            members.entry("extras").or_insert_with(|| unknown.clone());
            let extensions = members.entry("extensions").or_insert_with(|| json!({}));
            extensions["EXT_nobody_knows"] = unknown.clone();
        }
        _ => {}
    }
}

#[test]
fn every_kind_of_difference_is_found() {
    let parse = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    let old = parse(r#"{"a": [1, 2], "b": {"c": 1.50}, "extras": {"x": 1, "y": 2}}"#);
    assert!(differences(&old, &old.clone()).is_empty());
    for (new, place) in [
        (r#"{"a": [1], "b": {"c": 1.50}, "extras": {"x": 1, "y": 2}}"#, "a/1"),
        (r#"{"a": [1, 2, 3], "b": {"c": 1.50}, "extras": {"x": 1, "y": 2}}"#, "a/2"),
        (r#"{"a": [1, 2], "b": {"c": 1.5}, "extras": {"x": 1, "y": 2}}"#, "b/c"),
        (r#"{"a": [1, 2], "b": {}, "extras": {"x": 1, "y": 2}}"#, "b/c"),
        (r#"{"a": [1, 2], "b": {"c": 1.50}, "extras": {"y": 2, "x": 1}}"#, "extras"),
    ] {
        let found = differences(&old, &parse(new));
        let places: Vec<String> = found.iter().map(|difference| difference.path.join("/")).collect();
        assert_eq!(places, [place], "{new}");
    }
}
