//! What good presets become.

use std::f32::consts::PI;
use std::path::Path;

use wirework_core::{Bend, Blend, Correspondence, Curve, CurveKind, Density, Interpolation, Wire};
use wirework_preset::{Action, Deform, Limits, Object, Parsed, PatchDeform, Preset, Shape, parse};
use wirework_surface::VertexMesh;

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

fn preset(text: &str) -> Preset {
    parsed(text).preset
}

fn deform(text: &str) -> Deform {
    match preset(text).effects.remove(0).action {
        Action::Deform(deform) => deform,
        other => panic!("{other:?}"),
    }
}

fn wire(fields: &str) -> Wire {
    wire_at(fields, 0.0)
}

fn wire_at(fields: &str, seconds: f64) -> Wire {
    let text = format!("Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), {fields})])");
    deform(&text).wires[0].at(seconds)
}

fn object(text: &str) -> Object {
    preset(&format!("Deform(object: {text}, wires: [Wire(curve: Polyline([(0, 0, 0)]))])"))
        .object
        .expect("an object")
}

#[test]
fn what_is_left_out_has_the_documented_default() {
    let curve = Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0]]).unwrap();
    assert_eq!(wire(""), Wire::new(curve));
    let wire = wire("");
    assert_eq!(
        (wire.radius, wire.scale, wire.rotation, wire.amplitude, wire.twist),
        (1.0, 1.0, 1.0, 1.0, 0.0)
    );
    assert_eq!((wire.density, wire.bend), (Density::Quartic, Bend::Tangent));
    assert_eq!((wire.interpolation, wire.correspondence), (Interpolation::Linear, Correspondence::Parameter));
    assert_eq!((wire.group, wire.exponent, wire.locators.len()), (None, None, 0));
    let text = "Deform(wires: [Wire(curve: BSpline(points: [(0, 0, 0)]))])";
    assert_eq!(
        deform(text).blend,
        Blend { exponent: 1.0, crossing: 0.0, localize: 0.0, locality: 1.0, pinned: false }
    );
    assert_eq!(deform(text).wires[0].reference().kind(), CurveKind::BSpline { degree: 3 });
    assert!(!deform(text).wires[0].reference().closed());
    let preset = preset(text);
    assert_eq!((preset.duration, preset.animated, preset.object), (0.0, false, None));
}

#[test]
fn objects_have_the_documented_defaults() {
    let shape = |text: &str| object(text).shape;
    assert_eq!(
        shape("Grid(size: (2, 3))"),
        Shape::Grid { size: [2.0, 3.0], cells: [32, 32], normal: [0.0, 1.0, 0.0] }
    );
    assert_eq!(
        shape("Sphere(radius: 2)"),
        Shape::Sphere { center: [0.0; 3], radius: 2.0, segments: [64, 32] }
    );
    assert_eq!(
        shape("Box(min: (0, 0, 0), max: (1, 1, 1))"),
        Shape::Box { min: [0.0; 3], max: [1.0; 3], cells: [8; 3] }
    );
    let Shape::Tube { caps, .. } = shape("Tube(from: (0, 0, 0), to: (1, 0, 0), radius: 1)") else { panic!() };
    assert!(caps);
    let Shape::Patch { patch, tessellation, deform } =
        shape("Patch(points: [[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]])")
    else {
        panic!()
    };
    assert_eq!((patch.size(), tessellation, deform), ([2, 2], [32, 32], PatchDeform::Points));
}

#[test]
fn objects_become_meshes_where_they_stand() {
    let mesh = |text: &str| object(text).build().unwrap().expect("a mesh");
    assert_eq!(mesh("Grid(size: (2, 2), cells: (4, 3))").positions.len(), 5 * 4);
    assert_eq!(
        mesh("Tube(from: (0, 0, 0), to: (1, 0, 0), radius: 1, sides: 5, rings: 4)").positions.len(),
        22
    );
    let placed = mesh("Points(points: [(1, 0, 0)], translation: (0, 0, 5), rotation: (0, 0, 90), scale: 2)");
    for (found, expected) in placed.positions[0].iter().zip([0.0, 2.0, 5.0]) {
        assert!((found - expected).abs() < 1e-6, "{placed:?}");
    }
    assert_eq!(mesh("Points([(1, 2, 3)])").positions, [[1.0, 2.0, 3.0]]);
    let file = object("File(\"a/b.glb\")");
    assert_eq!(file.file(Path::new("presets")), Some(Path::new("presets").join("a/b.glb")));
    assert_eq!(file.build(), Ok(None));
    assert_eq!(object("File(path: \"a.obj\", scale: (1, 2, 3))").transform.scale, [1.0, 2.0, 3.0]);
    assert!(object("Sphere(center: (3e38, 0, 0), radius: 3e38)").build().is_err());
}

#[test]
fn keys_and_degrees() {
    let fields = "radius: Keys([(0, 1), (2, 3)]), twist: Ease([(0, 0), (1, 720)]), locators: [
        Locator(u: 0, twist: 90), Locator(u: 1, twist: Keys([(0, 0), (1, -180)]), scale: 3)]";
    let wire = wire_at(fields, 0.5);
    assert_eq!((wire.radius, wire.twist), (1.5, 2.0 * PI));
    let [first, last] = wire.locators.as_slice() else { panic!() };
    assert_eq!((first.u, first.twist, first.scale), (0.0, Some(PI / 2.0), None));
    assert_eq!((last.u, last.twist, last.scale), (1.0, Some(-PI / 2.0), Some(3.0)));
}

#[test]
fn a_pose_moves_and_the_reference_does_not() {
    let text = "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]),
        pose: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (2, [(0, 4, 0), (1, 0, 0)])]))])";
    let keyed = &deform(text).wires[0];
    let mut wire = keyed.at(0.0);
    let reference = wire.reference.clone();
    for (seconds, y) in [(0.5, 1.0), (9.0, 4.0), (-3.0, 0.0)] {
        keyed.at_into(seconds, &mut wire);
        assert_eq!((wire.pose[0], &wire.reference), ([0.0, y, 0.0], &reference));
        assert_eq!(wire, keyed.at(seconds));
    }
    assert_eq!(preset(text).duration, 2.0);
    let bare = "pose: [(0, 1, 0), (1, 0, 0)]";
    assert_eq!(wire_at(bare, 7.0).pose, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
}

#[test]
fn duration_and_animation() {
    let of = |fields: &str, rest: &str| {
        let text = format!("Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), {fields})], {rest})");
        let parsed = parsed(&text);
        (parsed.preset.duration, parsed.preset.animated, parsed.warnings.len())
    };
    assert_eq!(of("scale: 2", ""), (0.0, false, 0));
    assert_eq!(of("scale: Keys([(0, 1), (3, 2)])", ""), (3.0, true, 0));
    assert_eq!(of("scale: Keys([(0, 1), (3, 2)])", "duration: 5"), (5.0, true, 0));
    assert_eq!(of("scale: Keys([(0, 1), (3, 2)])", "duration: 2"), (2.0, true, 1));
    assert_eq!(of("scale: Keys([(1, 2)])", ""), (1.0, false, 0));
    assert_eq!(of("scale: 2", "duration: Some(1)"), (1.0, false, 0));
    assert_eq!(of("scale: Keys([(-2, 1), (-1, 2)])", ""), (0.0, false, 0));
    assert_eq!(of("scale: 2, locators: [Locator(u: 0, twist: Keys([(0, 1), (4, 9)]))]", ""), (4.0, true, 0));
    let stack = "Stack([
        Deform(object: Sphere(radius: 1), wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: Keys([(0, 1), (3, 2)]))]),
        Deform(wires: [Wire(curve: Polyline([(0, 0, 0)]), twist: Keys([(0, 1), (4, 2)]))]),
    ])";
    let stack = preset(stack);
    assert_eq!((stack.duration, stack.animated, stack.object.is_some()), (4.0, true, true));
    assert_eq!(stack.effects.len(), 2);
    assert_eq!(stack.key_times, [0.0, 3.0, 4.0]);
}

#[test]
fn groups_become_numbers_by_name() {
    let wires: String = ["\"b\"", "None", "Some(\"a\")", "\"b\"", "\"a\""]
        .map(|group| format!("Wire(curve: Polyline(points: [(0, 0, 0)]), scale: 2, group: {group}),"))
        .concat();
    let groups: Vec<Option<u32>> =
        deform(&format!("Deform(wires: [{wires}])")).wires.iter().map(|wire| wire.at(0.0).group).collect();
    assert_eq!(groups, [Some(0), None, Some(1), Some(0), Some(1)]);
}

#[test]
fn ron_in_its_variants() {
    let variants = [
        "Deform(wires: [Wire(curve: BSpline(degree: 2, points: [(0, 0, 0), (1, 0, 0)]), radius: 2)])",
        "Deform(wires: [(curve: BSpline(degree: 2.0, points: [(0.0, -0.0, 0), (1e0, 0, 0x0),],), radius: 2.0,),],)",
        "#![enable(implicit_some)]\n/* a /* nested */ comment */ Deform // x\n (wires: [Wire(radius: 2_0e-1, curve: BSpline([(0, 0, 0), (1, 0, 0)]))])",
        "#![enable(unwrap_newtypes)]\r\nDeform((wires: [Wire(radius: Some(2), curve: BSpline(r#points: [(0, 0, 0), (+1, 0, 0f32)]))]))",
    ];
    let expected = wire("radius: 2");
    for text in variants {
        let found = deform(text).wires[0].at(0.0);
        assert_eq!((found.radius, found.reference.points()), (2.0, expected.reference.points()), "{text}");
    }
    let other = "Wrinkle(pattern: Drawn([CatmullRom(points: [(0, 0, 0)], closed: true), Bezier([(0, 0, 0)])]), seed: 18446744073709551615)";
    assert!(matches!(preset(other).effects[0].action, Action::Wrinkle(_)));
    let file = object(r##"File(r#"a"b.glb"#)"##);
    assert_eq!(file.shape, Shape::File("a\"b.glb".into()));
    assert_eq!(object(r#"File("\u{e9}\t.glb")"#).shape, Shape::File("é\t.glb".into()));
}

#[test]
fn what_is_hardly_meant_is_a_warning() {
    let warnings = |text: &str| -> Vec<(usize, String)> {
        parsed(text).warnings.into_iter().map(|w| (w.span.start, w.message)).collect()
    };
    let curve = "curve: Polyline(points: [(0, 0, 0)])";
    for (text, at, message) in [
        (format!("Deform(wires: [Wire({curve})])"), "Wire(", "moves nothing"),
        (format!("Deform(wires: [Wire({curve}, scale: 2, amplitude: 0)])"), "Wire(", "moves nothing"),
        (
            format!("Deform(wires: [Wire({curve}, scale: 2, locators: [Locator(u: 0, scale: 3)])])"),
            "2,",
            "override",
        ),
        (format!("Deform(wires: [Wire({curve}, scale: 2, group: \"g\")])"), "\"g\"", "only this wire"),
        ("Wrinkle(pattern: Drawn([Polyline([(0, 0, 0)])]), intensity: 0)".to_owned(), "0)", "nothing moves"),
        (
            "Wrinkle(pattern: Drawn([Polyline([(0, 0, 0)])]), creases: 7)".to_owned(),
            "7",
            "no effect on drawn",
        ),
    ] {
        let found = warnings(&text);
        assert_eq!(found.len(), 1, "{text}\n{found:?}");
        assert!(found[0].1.contains(message), "{found:?}");
        let at = if at == "0)" { text.len() - 2 } else { text.find(at).expect("the place") };
        assert_eq!(found[0].0, at, "{text}\n{found:?}");
    }
    let anchor = format!("Deform(wires: [Wire({curve})], blend: Blend(localize: 1))");
    assert_eq!(warnings(&anchor), [], "a still wire anchors a local blend");
}

#[test]
fn the_size_of_an_object_is_known_before_it_is_built() {
    for (text, exact) in [
        ("Grid(size: (1, 1), cells: (3, 5))", true),
        ("Tube(from: (0, 0, 0), to: (0, 1, 0), radius: 1, sides: 5, rings: 4)", true),
        ("Tube(from: (0, 0, 0), to: (0, 1, 0), radius: 1, sides: 3, rings: 2, caps: false)", false),
        ("Sphere(radius: 1, segments: (7, 4))", false),
        ("Box(min: (0, 0, 0), max: (1, 1, 1), cells: (1, 4, 2))", true),
        ("Points([(0, 0, 0), (1, 0, 0)])", true),
        ("Patch(points: [[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]], tessellation: (3, 2))", true),
    ] {
        let object = object(text);
        let mesh = VertexMesh::new(&object.build().unwrap().expect("a mesh")).unwrap();
        let found = [mesh.positions.len() as u64, 3 * mesh.triangles.len() as u64];
        let size = object.shape.size();
        let bound = [size.vertices, size.indices];
        assert!(found[0] <= bound[0] && found[1] <= bound[1], "{text}: {found:?} {bound:?}");
        assert!(!exact || found == bound, "{text}: {found:?} {bound:?}");
    }
}
