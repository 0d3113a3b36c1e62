//! Accessors of a document, from bare JSON and bytes: no line of it is shared with the library.

use serde_json::Value;

use crate::document::Document;

impl Document {
    /// The elements of an accessor, in every form that the standard lets numbers have.
    pub(crate) fn elements(&self, reference: &Value) -> Vec<Vec<f64>> {
        let json = &self.json["accessors"][reference.as_u64().expect("an accessor") as usize];
        let number = |json: &Value, key: &str| json[key].as_u64().unwrap_or(0) as usize;
        let lanes = match json["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        let (kind, normalized) = (number(json, "componentType"), json["normalized"] == true);
        let size = component(kind, false, &[0; 4]).1;
        let read =
            |place: &Value, count: usize, kind: usize, lanes: usize, normalized: bool| -> Vec<Vec<f64>> {
                let view = number(place, "bufferView");
                let size = component(kind, false, &[0; 4]).1;
                let stride = self.json["bufferViews"][view]["byteStride"].as_u64();
                let stride = stride.map_or(size * lanes, |stride| stride as usize);
                let bytes = &self.view(view)[number(place, "byteOffset")..];
                let lane =
                    |i: usize, k: usize| component(kind, normalized, &bytes[i * stride + k * size..]).0;
                (0..count).map(|i| (0..lanes).map(|k| lane(i, k)).collect()).collect()
            };
        let count = number(json, "count");
        let mut out = vec![vec![0.0; lanes]; count];
        if json.get("bufferView").is_some() {
            assert!(size > 0);
            out = read(json, count, kind, lanes, normalized);
        }
        if let Some(sparse) = json.get("sparse") {
            let count = number(sparse, "count");
            let which =
                read(&sparse["indices"], count, number(&sparse["indices"], "componentType"), 1, false);
            let values = read(&sparse["values"], count, kind, lanes, normalized);
            which.iter().zip(values).for_each(|(i, value)| out[i[0] as usize] = value);
        }
        out
    }
}

/// The component that `bytes` start with, and its size.
fn component(kind: usize, normalized: bool, bytes: &[u8]) -> (f64, usize) {
    let (value, size, most) = match kind {
        5120 => (f64::from(bytes[0].cast_signed()), 1, 127.0),
        5121 => (f64::from(bytes[0]), 1, 255.0),
        5122 => (f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 2, 32_767.0),
        5123 => (f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 2, 65_535.0),
        5125 => (f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])), 4, 1.0),
        _ => (f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])), 4, 1.0),
    };
    (if normalized { (value / most).max(-1.0) } else { value }, size)
}
