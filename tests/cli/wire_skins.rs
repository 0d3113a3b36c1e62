//! Wires that only move as skins: exact, by another reader too, and refused where they would not be.

use glam::DVec3;
use serde_json::{Value, json};
use wirework::asset::{Clip, Gltf, JointTrack, Tracks};

use crate::document::{Document, list};
use crate::make::Doc;
use crate::oracle;
use crate::place::{LIFT, Place};
use crate::wrinkles::vertices;

/// Float32, in parts of the diagonal.
const EXACT: f64 = 4e-7;

/// Frames a second of effects of one second.
const FPS: usize = 8;

/// A preset on a grid of 2 by 2 metres.
fn deform(wires: &[String], fields: &str) -> String {
    let object = "object: Grid(size: (2, 2), cells: (20, 20))";
    format!("Deform({object}, wires: [{}], {fields})", wires.join(", "))
}

/// A wire across the grid at `z`, whose control points all go somewhere else.
fn wire(kind: &str, count: usize, z: f64, fields: &str) -> String {
    let x = |i: usize| 2.0 * i as f64 / (count - 1) as f64 - 1.0;
    let rest: Vec<String> = (0..count).map(|i| format!("({}, 0, {z})", x(i))).collect();
    let way = |i: usize| [0.1 * i as f64 - 0.2, 0.4 - 0.15 * (i % 3) as f64, 0.1 * (i % 2) as f64];
    let pose: Vec<String> = (0..count)
        .map(|i| {
            let [a, b, c] = way(i);
            format!("({:.3}, {b:.3}, {:.3})", x(i) + a, z + c)
        })
        .collect();
    let [rest, pose] = [rest, pose].map(|list| list.join(", "));
    let curve = kind.replace("POINTS", &format!("points: [{rest}]"));
    format!("Wire(curve: {curve}, pose: Ease([(0, [{rest}]), (1, [{pose}])]), {fields})")
}

#[test]
fn keys_closer_than_a_file_can_tell_are_both_there() {
    let place = Place::new();
    let pose = |y: f64| format!("[(-1, {y}, 0), (1, {y}, 0)]");
    let [low, high] = [pose(0.0), pose(0.5)];
    let keys = format!("Keys([(0, {low}), (0.5, {low}), (0.50000001, {high}), (1, {low})])");
    let wire = format!("Wire(curve: Polyline(points: {low}), pose: {keys}, {OWN})");
    place.write("p.ron", deform(&[wire], ""));
    place.exact("");
}

const QUADRATIC: &str = "BSpline(degree: 2, POINTS)";
const OWN: &str = "radius: 0.7, rotation: 0";

fn far(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Eased poses are followed as closely as this between their keys.
const BETWEEN: f64 = 6e-6;

impl Place {
    /// Bakes `p.ron` as a skin into `out.glb` and compares it with the effect itself, as told and as another reader plays it. The
    /// report.
    #[track_caller]
    fn exact(&self, input: &str) -> Value {
        self.run(&format!("apply p.ron {input} -o out.glb --bake skin --fps {FPS} --report out.json -q"))
            .expect(0);
        let report: Value = serde_json::from_slice(&self.read("out.json")).unwrap();
        let told = report["skeleton"]["residual_of_diagonal"].as_f64().unwrap();
        assert!(told < BETWEEN, "{report}");
        let glb = self.read("out.glb");
        gltf::Gltf::from_slice(&glb).unwrap();
        let mut moved = 0.0_f64;
        let rest = self.still_at(input, 0.0);
        let most = rest.iter().map(|p| p.length()).fold(0.0, f64::max);
        for frame in 0..=FPS {
            let seconds = frame as f64 / FPS as f64;
            let played: Vec<DVec3> = oracle::evaluate_clip(&glb, |_| Some(0), seconds, true)
                .into_iter()
                .flat_map(|shown| shown.positions)
                .collect();
            let still = self.still_at(input, seconds);
            let off = far(&played, &still);
            assert!(off < 2.0 * EXACT * most, "{off:e} at {seconds} s");
            moved = moved.max(far(&still, &rest));
        }
        assert!(moved > 0.05, "the effect moves something");
        report
    }

    fn still_at(&self, input: &str, seconds: f64) -> Vec<DVec3> {
        self.run(&format!("apply p.ron {input} --at {seconds} -o still.obj -q")).expect(0);
        vertices(&self.read("still.obj"))
    }

    /// What is said where `p.ron` is refused.
    #[track_caller]
    fn refused(&self, input: &str, options: &str, code: i32) -> String {
        let line = format!("apply p.ron {input} -o no.glb --bake skin --frames 0..3 {options}");
        let told = self.run(&line).expect(code).err();
        assert!(!self.files().contains(&"no.glb".to_owned()), "{told}");
        told
    }
}

#[test]
fn a_wire_of_each_kind_is_exact_by_as_many_joints_as_its_degree_and_two_more() {
    let place = Place::new();
    for (kind, count, influences) in [
        ("Polyline(POINTS)", 4, 3),
        ("BSpline(degree: 1, POINTS)", 4, 3),
        (QUADRATIC, 5, 4),
        ("BSpline(degree: 3, POINTS)", 6, 5),
        ("Bezier(POINTS)", 7, 5),
        ("BSpline(degree: 2, closed: true, POINTS)", 5, 4),
        ("BSpline(degree: 3, closed: true, POINTS)", 6, 5),
    ] {
        place.write("p.ron", deform(&[wire(kind, count, 0.1, OWN)], ""));
        let report = place.exact("");
        let skeleton = &report["skeleton"];
        assert_eq!(skeleton["influences"], influences, "{kind}");
        assert_eq!((&skeleton["joints"], &skeleton["made"]), (&count.into(), &count.into()), "{kind}");
        assert_eq!(skeleton["gains"], json!([1.0]), "{kind}");
        assert!(skeleton["normals_degrees"].as_f64().unwrap() > 5.0, "joints that only move turn no normal");
        let warned = report["warnings"].to_string().contains("[skin-influences]");
        assert_eq!(warned, influences > 4, "{kind}: {report}");
        let json = Document::open(&place.path("out.glb")).json;
        let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
        assert_eq!(attributes.get("JOINTS_1").is_some(), influences > 4, "{kind}");
        // One root, which stays and carries a joint for each control point where that is at rest.
        let root = &json["nodes"][1];
        assert_eq!((&root["name"], list(root, "children").len()), (&json!("wires"), count));
        let named = |k: usize| json["nodes"][2 + k]["name"] == format!("wire0_p{k}");
        assert!((0..count).all(named), "{}", json["nodes"]);
    }
}

#[test]
fn what_is_known_at_binding_is_in_the_weights() {
    let place = Place::new();
    let domain = "domains: [Domain(curve: Polyline([(-1, 0, 0.4), (1, 0, 0.5)]), delta: 0.3)]";
    for fields in [
        "rotation: 0, locators: [Locator(u: 0.1, radius: 0.2, amplitude: 0.5), Locator(u: 0.8, radius: 1.2, amplitude: 1)], interpolation: Smooth",
        &format!("rotation: 0, radius: 0.8, {domain}"),
        "rotation: 0, radius: 0.8, direction: (0, 0, 1), angle: 120",
        "rotation: 0, radius: 1, density: Sextic",
        "rotation: 0, radius: 1.5, closest: Blended(0.4)",
        "radius: 0.8, locators: [Locator(u: 0.5, rotation: 0)]",
    ] {
        place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.0, fields)], ""));
        place.exact("");
    }
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.0, OWN)], "units: Bounds"));
    place.exact("");
}

#[test]
fn amplitudes_beyond_weights_are_in_the_way_joints_go() {
    let place = Place::new();
    for (amplitude, gain) in [("0.4", 1.0), ("2.5", 2.5), ("-0.5", -1.0), ("-3", -3.0)] {
        place.write(
            "p.ron",
            deform(&[wire(QUADRATIC, 5, 0.1, &format!("{OWN}, amplitude: {amplitude}"))], ""),
        );
        assert_eq!(place.exact("")["skeleton"]["gains"], json!([gain]), "{amplitude}");
    }
    let both =
        "rotation: 0, radius: 0.7, locators: [Locator(u: 0, amplitude: 1), Locator(u: 1, amplitude: -1)]";
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.1, both)], ""));
    assert!(place.refused("", "", 2).contains("`wires[0].amplitude` is below 0 at some places"));
}

#[test]
fn wires_whose_blend_is_fixed_are_exact() {
    let place = Place::new();
    let two = |fields: &str| [wire(QUADRATIC, 5, -0.3, fields), wire("Polyline(POINTS)", 4, 0.3, fields)];
    let apart = two("radius: 0.29, rotation: 0");
    for (wires, fields) in [
        (two(OWN), "blend: Blend(localize: 1)"),
        (two(OWN), "blend: Blend(localize: 1, crossing: 0.3, locality: 2.5, exponent: 4)"),
        (two(&format!("{OWN}, group: \"one\"")), ""),
        (apart, ""),
    ] {
        place.write("p.ron", deform(&wires, fields));
        let report = place.exact("");
        assert_eq!(report["skeleton"]["gains"], json!([1.0, 1.0]), "{fields}");
    }
    // Between them both add up to more than 1.
    place.write("p.ron", deform(&two(OWN), "blend: Blend(crossing: 1, localize: 0.4)"));
    let gains = place.exact("")["skeleton"]["gains"].clone();
    assert!(gains[0] == gains[1] && gains[0].as_f64().unwrap() > 1.05, "{gains}");
    // A wire that lies where it was anchors what is near, and bends nothing whatever its rotation.
    let anchor = "Wire(curve: Polyline([(-1, 0, 0.5), (1, 0, 0.5)]), radius: 0.6)".to_owned();
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.0, OWN), anchor], "blend: Blend(localize: 1)"));
    place.exact("");
    // So is one that moves all its points alike.
    place.write("p.ron", LIFT);
    place.exact("");
}

#[test]
fn keys_are_the_poses_own_but_for_eased_ones() {
    let place = Place::new();
    let times = || -> Vec<f64> {
        let json = Document::open(&place.path("out.glb")).json;
        let samplers = list(&json["animations"][0], "samplers");
        let accessor = samplers.iter().map(|s| s["input"].as_u64().unwrap() as usize).next().unwrap();
        let document = Document::open(&place.path("out.glb"));
        let view = json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        document.view(view).as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect()
    };
    let track = |name: &str| {
        let still = "[(-1, 0, 0), (1, 0, 0)]";
        let pose = format!("{name}([(0.1, {still}), (0.4, [(-1, 0.5, 0), (1, 0.2, 0)]), (1, {still})])");
        format!("Wire(curve: Polyline({still}), pose: {pose}, radius: 0.5, rotation: 0)")
    };
    let close = |found: Vec<f64>, wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?}");
    };
    let residual = |report: &Value| report["skeleton"]["residual_of_diagonal"].as_f64().unwrap();
    place.write("p.ron", deform(&[track("Keys")], ""));
    assert!(residual(&place.exact("")) < EXACT);
    close(times(), &[0.0, 0.1, 0.4, 1.0]);
    place.write("p.ron", deform(&[track("Ease")], ""));
    let report = place.exact("");
    let keys = times();
    for time in [0.0, 0.1, 0.125, 0.25, 0.375, 0.4, 0.5, 0.625, 0.75, 0.875, 1.0] {
        assert!(keys.iter().any(|key| (key - time).abs() < 1e-7), "{time}: {keys:?}");
    }
    assert!(keys.len() < 400 && keys.iter().filter(|key| **key < 0.1).count() == 1, "{keys:?}");
    // What is told is what is played between them, and nowhere more.
    let glb = place.read("out.glb");
    let off = |seconds: f64| {
        let played = oracle::evaluate_clip(&glb, |_| Some(0), seconds, true);
        let played: Vec<DVec3> = played.into_iter().flat_map(|shown| shown.positions).collect();
        far(&played, &place.still_at("", seconds))
    };
    let [told, seconds] = ["residual", "seconds"].map(|key| report["skeleton"][key].as_f64().unwrap());
    assert!((off(seconds) - told).abs() < 1e-6 && told > 1e-6, "{told} at {seconds} s");
    for seconds in [0.1313, 0.2718, 0.3142, 0.4567, 0.7123, 0.9] {
        assert!(off(seconds) < 1.1 * told, "{seconds}");
    }
    // The base and whatever does not move has none.
    let json = Document::open(&place.path("out.glb")).json;
    let channels = list(&json["animations"][0], "channels");
    assert!(
        channels.len() == 2 && channels.iter().all(|c| c["target"]["path"] == "translation"),
        "{channels:?}"
    );
}

/// Three sheets: one under turned, scaled and mirrored nodes, one moved, one far away; the first two show one mesh.
fn sheets() -> Doc {
    let mut doc = Doc::new();
    let n = 9_usize;
    let at = |k: usize| k as f32 / (n - 1) as f32 - 0.5;
    let points: Vec<f32> = (0..n * n).flat_map(|i| [at(i % n), 0.0, at(i / n)]).collect();
    let position = doc.floats("VEC3", &points);
    doc.json["accessors"][position]["min"] = json!([-0.5, 0.0, -0.5]);
    doc.json["accessors"][position]["max"] = json!([0.5, 0.0, 0.5]);
    let corners = |i: usize| [i, i + n, i + 1, i + 1, i + n, i + n + 1];
    let squares = (0..n * (n - 1)).filter(|i| i % n + 1 < n);
    let indices: Vec<u8> = squares.flat_map(corners).map(|i| i as u8).collect();
    let count = indices.len();
    let indices = doc.accessor(json!({ "componentType": 5121, "type": "SCALAR", "count": count }), &indices);
    let primitive = json!({ "attributes": { "POSITION": position }, "indices": indices });
    let (shared, alone) = (doc.mesh(&primitive), doc.mesh(&primitive));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    doc.node(json!({ "name": "turn", "rotation": [0.0, half, 0.0, half], "translation": [-0.6, 0.1, 0.0],
        "scale": [-1.3, 1.0, 0.8], "children": [1] }));
    doc.node(
        json!({ "name": "mirrored", "mesh": shared, "translation": [0.0, 0.05, 0.1], "scale": [1, -1, 1] }),
    );
    doc.node(json!({ "name": "plain", "mesh": shared, "translation": [0.6, 0.0, 0.1] }));
    doc.node(json!({ "name": "far", "mesh": alone, "translation": [0, 0, 9] }));
    doc.json["scenes"] = json!([{ "nodes": [0, 2, 3] }]);
    doc
}

#[test]
fn meshes_hang_where_their_nodes_have_them_and_others_stay_as_they_are() {
    let place = Place::new();
    place.write("in.glb", sheets().glb());
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.1, OWN)], ""));
    place.exact("in.glb");
    let [old, new] = ["in.glb", "out.glb"].map(|name| Document::open(&place.path(name)));
    let skin = |node: usize| new.json["nodes"][node].get("skin").is_some();
    assert_eq!([0, 1, 2, 3].map(skin), [false, true, true, false]);
    // The mesh of the far one, and all that was there, is where it was, to the byte.
    assert_eq!(old.json["nodes"][3], new.json["nodes"][3]);
    // What hangs on joints is a root, and has no place of its own.
    let mut above = old.json["nodes"][0].clone();
    above.as_object_mut().unwrap().remove("children");
    assert_eq!(new.json["nodes"][0], above);
    assert_eq!(new.json["nodes"][1], json!({ "name": "mirrored", "mesh": 2, "skin": 0 }));
    assert_eq!(new.json["scenes"][0]["nodes"], json!([0, 1, 2, 3, 4]));
    assert_eq!(old.json["meshes"][1], new.json["meshes"][1]);
    let bytes = |document: &Document| document.bin.clone().unwrap();
    let length = old.json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert!(bytes(&new)[..length] == bytes(&old)[..length]);
    // The rest, without the clip.
    let rest = |glb: &[u8]| -> Vec<DVec3> {
        oracle::evaluate_clip(glb, |_| None, 0.0, true)
            .into_iter()
            .flat_map(|shown| shown.positions)
            .collect()
    };
    assert!(far(&rest(&place.read("in.glb")), &rest(&place.read("out.glb"))) < 1e-6);
    // By `only` a sheet that would be reached stays, too.
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.1, OWN)], "only: Nodes([\"plain\"])"));
    place.exact("in.glb");
    let new = Document::open(&place.path("out.glb")).json;
    assert!(new["nodes"][1] == old.json["nodes"][1] && new["nodes"][2].get("skin").is_some());
}

#[test]
fn what_nothing_reaches_gets_no_skin() {
    let place = Place::new();
    place.write("in.glb", sheets().glb());
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 40.0, OWN)], ""));
    let told = place.run("apply p.ron in.glb -o out.glb --bake skin").expect(0).err();
    assert!(told.contains("[no-reach]"), "{told}");
    let json = Document::open(&place.path("out.glb")).json;
    assert!(json.get("skins").is_none() && json.get("animations").is_none());
}

#[test]
fn what_is_no_skin_is_refused_by_its_field() {
    let place = Place::new();
    let own = |fields: &str| deform(&[wire(QUADRATIC, 5, 0.1, fields)], "");
    let two = [wire(QUADRATIC, 5, -0.3, OWN), wire(QUADRATIC, 5, 0.3, OWN)];
    let still = "[(-1, 0, 0.1), (-0.5, 0, 0.1), (0, 0, 0.1), (0.5, 0, 0.1), (1, 0, 0.1)]";
    for (preset, told) in [
        (own("radius: 0.7"), "`wires[0].rotation` is 1,"),
        (own("radius: 0.7, rotation: 0.5"), "with `rotation: 0` it is exact"),
        (own(&format!("{OWN}, scale: 1.2")), "`wires[0].scale` is 1.2"),
        (own(&format!("{OWN}, twist: 90")), "`wires[0].twist` is 1.57"),
        (own(&format!("{OWN}, locators: [Locator(u: 0, scale: 1), Locator(u: 1, scale: 2)]")), "`wires[0].locators[1].scale` is 2"),
        (own(&format!("{OWN}, correspondence: ArcLength")), "`wires[0].correspondence` is `ArcLength`"),
        (deform(&[wire("CatmullRom(POINTS)", 5, 0.1, OWN)], ""), "`wires[0].curve` is a `CatmullRom`"),
        (own(&format!("{OWN}, amplitude: Keys([(0, 0), (1, 1)])")), "`wires[0].amplitude` moves in time"),
        (own("rotation: 0, radius: Ease([(0, 0.5), (1, 0.7)])"), "`wires[0].radius` moves in time"),
        (own(&format!("{OWN}, reference: Keys([(0, {still}), (1, {})])", still.replace("0.1", "0.2"))), "`wires[0].reference` moves in time"),
        (deform(&two, ""), "`wires[0]` and `wires[1]` reach the same vertices"),
        (deform(&two, "blend: Blend(localize: 0.5)"), "`localize: 1`, `crossing: 1` or one `group`"),
        (deform(&["WireLattice(min: (-1, -1, -1), max: (1, 1, 1), lines: (3, 3, 3), moves: [Move(x: 2, by: Keys([(0, (0, 0, 0)), (1, (0, 1, 0))]))])".into()], ""), "wire 0.rotation"),
        (deform(&two[..1], "lattice: Lattice(min: (-1, -1, -1), max: (1, 1, 1))"), "`lattice`: the wires move its control points"),
    ] {
        place.write("p.ron", &preset);
        let found = place.refused("", "", 2);
        assert!(found.contains(told) && found.contains("`--bake auto` takes it"), "{preset}: {found}");
    }
    place.write("p.ron", own(OWN));
    assert!(place.refused("", "--joints 2", 2).contains("wires have one a control point"));
}

#[test]
fn nodes_that_clips_move_and_skins_that_are_there_are_refused() {
    let place = Place::new();
    place.write("p.ron", deform(&[wire(QUADRATIC, 5, 0.1, OWN)], ""));
    let moving = |node: usize| {
        let mut gltf: Gltf = sheets().open().unwrap();
        let track =
            JointTrack { node, translations: vec![[0.0; 3], [0.0, 1.0, 0.0]], ..JointTrack::default() };
        let tracks = Tracks { times: &[0.0, 1.0], joints: &[track], ..Tracks::default() };
        gltf.add_tracks(&Clip::New("walk".into()), &tracks).unwrap();
        gltf.to_glb().unwrap()
    };
    // The node above the one that shows the mesh.
    place.write("in.glb", moving(0));
    let told = place.refused("in.glb", "", 2);
    assert!(told.contains("clip 0 of the input moves node 1 \"mirrored\""), "{told}");
    // What the wire does not reach may move.
    place.write("far.glb", moving(3));
    place.run("apply p.ron far.glb -o far_out.glb --bake skin -q").expect(0);
    place.write("in.glb", sheets().glb());
    place.run("apply p.ron in.glb -o skinned.glb --bake skin -q").expect(0);
    let told = place.refused("skinned.glb", "", 3);
    assert!(told.contains("which has a skin already"), "{told}");
}

#[test]
fn threads_change_no_byte_of_a_wire_skin() {
    let place = Place::new();
    place.write("p.ron", deform(&[wire("BSpline(degree: 3, POINTS)", 6, 0.1, OWN)], ""));
    let bytes = ["1", "3"].map(|threads| {
        place.run(&format!("apply p.ron -o out.glb --bake skin -q --threads {threads}")).expect(0);
        place.read("out.glb")
    });
    assert!(bytes[0] == bytes[1]);
}
