//! Points and lines.

use serde_json::json;
use wirework_asset::Stroke;

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::Doc;

/// The strokes of five vertices behind a triangle, joined as `mode` says.
fn strokes(mode: usize, indices: Option<&[u8]>) -> Vec<Stroke> {
    let mut doc = make::triangle(json!({}));
    let positions = doc.floats("VEC3", &[0.5; 15]);
    let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
    if let Some(indices) = indices {
        let accessor = json!({ "componentType": 5121, "type": "SCALAR", "count": indices.len() });
        primitive["indices"] = json!(doc.accessor(accessor, indices));
    }
    let mesh = doc.mesh(&primitive);
    doc.node(json!({ "mesh": mesh }));
    let gltf = doc.open().unwrap();
    gltf.strokes(&gltf.rest().unwrap()).unwrap()
}

fn lines(mode: usize, indices: Option<&[u8]>) -> Vec<Vec<u32>> {
    let strokes = strokes(mode, indices);
    assert_eq!((strokes.len(), strokes[0].part), (1, 1));
    strokes[0].lines().map(<[u32]>::to_vec).collect()
}

#[test]
fn every_mode_gives_its_lines() {
    // The triangle has the vertices 0 to 2.
    assert_eq!(lines(1, None), [[3, 4], [5, 6]], "the odd vertex is left out");
    assert_eq!(lines(1, Some(&[0, 1, 1, 2, 4, 3])), [vec![3, 4, 5], vec![7, 6]], "segments are joined");
    assert_eq!(lines(2, None), [[3, 4, 5, 6, 7, 3]]);
    assert_eq!(lines(2, Some(&[2, 0, 1])), [[5, 3, 4, 5]]);
    assert_eq!(lines(3, None), [[3, 4, 5, 6, 7]]);
    assert_eq!(lines(3, Some(&[4, 0])), [[7, 3]]);
    assert!(lines(3, Some(&[4])).is_empty() && lines(2, Some(&[4])).is_empty());
    assert!(lines(1, Some(&[4])).is_empty());
    assert!(strokes(4, None).is_empty(), "triangles are no lines");
}

#[test]
fn points_are_no_lines() {
    let strokes = strokes(0, Some(&[4, 0, 0]));
    assert_eq!(strokes[0].points, [7, 3, 3]);
    assert!(strokes[0].line_ends.is_empty() && strokes[0].lines().next().is_none());
}

#[test]
fn indices_out_of_range_are_refused_as_the_rest_refuses_them() {
    let line = |last: u8| {
        let mut doc = Doc::new();
        let positions = doc.floats("VEC3", &[0.0; 6]);
        let indices =
            doc.accessor(json!({ "componentType": 5121, "type": "SCALAR", "count": 2 }), &[0, last]);
        let primitive = json!({ "attributes": { "POSITION": positions }, "mode": 1, "indices": indices });
        let mesh = doc.mesh(&primitive);
        doc.node(json!({ "mesh": mesh }));
        doc
    };
    let rest = line(1).rest().unwrap();
    assert!(line(1).open().unwrap().strokes(&rest).is_ok());
    assert!(line(2).open().unwrap().strokes(&rest).is_err() && line(2).rest().is_err());
}
