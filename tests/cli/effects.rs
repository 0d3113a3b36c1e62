//! What effects may move and in which units, from outside: `only`, `mask`, `units`, lattices, control points.

use std::fmt::Write;

use glam::DVec3;
use wirework::asset::{Gltf, Limits, Obj};

use crate::oracle;
use crate::place::{Place, shared};

/// Wires along both arms and round the waist, a lattice over all and a crease on the chest: in parts of the largest side, for a
/// figure that stands upright and faces +Z.
const DRESSED: &str = "Stack([
    Deform(units: Bounds, wires: [
        Wire(curve: BSpline(points: [(0.05, 0.35, 0), (0.1, 0.3, 0), (0.15, 0.2, 0), (0.2, 0.1, 0)]),
            locators: [Locator(u: 0, radius: 0.04), Locator(u: 1, radius: 0.12, scale: 1.3, twist: 30)],
            pose: Keys([(0, [(0.05, 0.35, 0), (0.1, 0.3, 0), (0.15, 0.2, 0), (0.2, 0.1, 0)]),
                        (1, [(0.05, 0.35, 0), (0.1, 0.34, 0.02), (0.15, 0.34, 0), (0.2, 0.4, 0)])])),
        Wire(curve: Polyline(points: [(-0.2, 0.05, 0), (-0.1, 0.3, 0)]), radius: 0.1,
            pose: [(-0.25, 0.05, 0.1), (-0.1, 0.3, 0)]),
    ]),
    Deform(units: Bounds, lattice: Lattice(min: (-0.6, -0.6, -0.6), max: (0.6, 0.6, 0.6), cells: (2, 3, 2)),
        wires: [Wire(curve: Polyline(points: [(-0.6, 0.6, -0.6), (0.6, 0.6, 0.6)]), radius: 0.9,
            pose: [(-0.5, 0.7, -0.6), (0.6, 0.65, 0.7)])]),
    Wrinkle(units: Bounds, pattern: Drawn([Polyline(points: [(-0.05, 0.2, 0.1), (0.05, 0.22, 0.1)])]),
        thickness: 0.02, intensity: 0.01),
])";

/// An OBJ text with every position times a factor.
fn scaled(text: &str, factor: f64) -> String {
    let mut out = String::new();
    for line in text.lines() {
        if let Some(point) = line.strip_prefix("v ") {
            let numbers: Vec<f64> = point.split_whitespace().map(|n| n.parse().unwrap()).collect();
            let [x, y, z] = [0, 1, 2].map(|i| numbers[i] * factor);
            writeln!(out, "v {x} {y} {z}").unwrap();
        } else {
            writeln!(out, "{line}").unwrap();
        }
    }
    out
}

/// A closed sleeve-like surface 14 m tall about a point off the origin, in faces of four.
fn figure() -> String {
    let (sides, rings) = (40, 60);
    let mut text = String::new();
    for ring in 0..rings {
        for side in 0..sides {
            let (y, angle) = (
                f64::from(ring) / f64::from(rings - 1),
                f64::from(side) / f64::from(sides) * std::f64::consts::TAU,
            );
            let radius = 1.5 + 1.2 * (y * 5.0).sin() * y;
            writeln!(text, "v {} {} {}", 0.5 + radius * angle.sin(), 14.0 * y - 3.0, radius * angle.cos())
                .unwrap();
        }
    }
    for ring in 0..rings - 1 {
        for side in 0..sides {
            let (a, b) = (ring * sides + side + 1, ring * sides + (side + 1) % sides + 1);
            writeln!(text, "f {a} {b} {} {}", b + sides, a + sides).unwrap();
        }
    }
    text
}

#[test]
fn parts_of_the_bounds_give_the_same_shape_at_any_size() {
    let place = Place::new();
    place.write("dressed.ron", DRESSED);
    let suit = shared("garment/male_casualsuit04.obj");
    for text in suit.iter().map(|path| std::fs::read_to_string(path).unwrap()).chain([figure()]) {
        place.write("large.obj", scaled(&text, 1.0));
        place.write("small.obj", scaled(&text, 0.1));
        let positions = |name: &str| Obj::read(&place.path(name), &Limits::default()).unwrap().mesh.positions;
        let wide = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
        let (large, small) = (positions("large.obj"), positions("small.obj"));
        let range = |get: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|a| large.iter().map(|p| f64::from(p[a])).reduce(get).unwrap())
        };
        let diagonal = DVec3::from_array(range(f64::min)).distance(DVec3::from_array(range(f64::max)));
        assert!(diagonal > 10.0 && small.len() == large.len());
        for name in ["large", "small"] {
            let (input, out) = (format!("{name}.obj"), format!("{name}_now.obj"));
            let done =
                place.run_with(["apply", "dressed.ron", &input, "-o", &out, "--at", "0.7"], b"").expect(0);
            // The suit is too coarse for a fold so thin.
            let told = |line: &&str| line.contains("warning") && !line.contains("[coarse]");
            assert_eq!(done.err().lines().find(told), None);
        }
        let (large_now, small_now) = (positions("large_now.obj"), positions("small_now.obj"));
        let moved = large.iter().zip(&large_now).filter(|(a, b)| wide(a).distance(wide(b)) > 0.01 * diagonal);
        assert!(moved.count() > large.len() / 4);
        for (i, (a, b)) in large_now.iter().zip(&small_now).enumerate() {
            let off = wide(a).distance(wide(b) * 10.0) / diagonal;
            assert!(off < 1e-5, "vertex {i}: {a:?}, a tenth of it {b:?}, {off} diagonals off");
        }
    }
}

#[test]
fn only_the_joints_of_an_arm_leaves_the_bits_of_the_rest() {
    let Some(path) = shared("rigged/cesium_man.glb") else { return };
    let place = Place::new();
    let preset = |only: &str| {
        format!(
            "Deform({only} wires: [Wire(curve: Polyline(points: [(0, 1.02, 0.2), (0.1, 0.85, 0.5)]), radius: 0.6,
                pose: [(0, 1.02, 0.2), (0.1, 1.3, 0.4)])])"
        )
    };
    // Shoulder, elbow and hand of the left arm; none of the joints has a name.
    place.write("arm.ron", preset("only: Joints([\"13\", \"14\", \"15\"]),"));
    place.write("all.ron", preset(""));
    let input = path.to_str().unwrap();
    let read = |path: &std::path::Path| Gltf::read(path, &Limits::default()).unwrap();
    let before = read(&path);
    let rest = before.rest().unwrap();
    let weights = before.joint_weights(&rest, &[13, 14, 15]).unwrap().of_vertices;
    let mut torso = Vec::new();
    for name in ["arm", "all"] {
        let (preset, out) = (format!("{name}.ron"), format!("{name}.glb"));
        place.run_with(["apply", &preset, input, "-o", &out, "--at", "0"], b"").expect(0);
        let now = read(&place.path(&out)).rest().unwrap().positions;
        let moved = |hangs: bool| {
            let pairs = now.iter().zip(&rest.positions).zip(&weights);
            pairs
                .filter(|((a, b), w)| (**w > 0.0) == hangs && a.map(f32::to_bits) != b.map(f32::to_bits))
                .count()
        };
        assert!(moved(true) > 150, "{}", moved(true));
        torso.push(moved(false));
    }
    assert_eq!(torso[0], 0, "vertices that do not hang on the arm");
    assert!(torso[1] > 200, "which the wire reaches without `only`: {}", torso[1]);
}

#[test]
fn names_and_images_that_are_not_there_are_told_at_their_place() {
    let place = Place::new();
    place.write("two.obj", "o left\nv 0 0 0\nv 1 0 0\nv 0 0 -1\no right\nf 1 2 3\n");
    let wire = "wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), pose: [(0, 1, 0), (1, 1, 0)])]";
    place.write("name.ron", format!("Deform(\n    only: Nodes([\"rihgt\"]),\n    {wire},\n)"));
    place.write("image.ron", format!("Deform(mask: Image(\"no.png\"), {wire})"));
    place.write("own.ron", format!("Deform(object: Grid(size: (1, 1)), only: Nodes([\"gird\"]), {wire})"));
    place.write("sheet.ron", format!("Deform(object: Grid(size: (1, 1)), only: Nodes([\"sheet\"]), {wire})"));
    let caret = |err: &str, found: &str| {
        let at = err.lines().find(|line| line.contains("^^^")).expect(err).find('^');
        assert_eq!(
            at,
            err.lines().find(|line| line.contains("| ") && line.contains(found)).unwrap().find(found)
        );
    };
    let before = place.files();
    for line in ["apply name.ron two.obj -o out.obj", "apply name.ron two.obj --dry-run"] {
        let err = place.run(line).expect(4).err();
        for part in ["name.ron:2:", "rihgt", "did you mean \"right\"?", "only"] {
            assert!(err.contains(part), "{part:?} in\n{err}");
        }
        caret(&err, "\"rihgt");
    }
    let err = place.run("apply image.ron two.obj -o out.obj").expect(4).err();
    assert!(err.contains("image.ron:1:") && err.contains("no.png"), "{err}");
    caret(&err, "\"no.png\")");
    // Without an object a preset can be checked for what it reads.
    let err = place.run("check image.ron").expect(4).err();
    assert!(err.contains("image.ron:1:") && err.contains("no.png"), "{err}");
    place.run("check name.ron").expect(0);
    // An object of its own is a node with the name of the preset.
    place.run("check sheet.ron").expect(0);
    for (line, code) in [("check own.ron", 0), ("check --strict own.ron", 4), ("apply own.ron -o out.glb", 4)]
    {
        let err = place.run(line).expect(code).err();
        assert!(err.contains("own.ron:1:") && err.contains("\"gird\""), "{err}");
    }
    assert_eq!(place.files(), before, "nothing is written");
}

#[test]
fn painted_colours_multiply_the_influence_of_an_effect_or_of_a_wire() {
    let place = Place::new();
    // Red falls from 1 to 0 along x, green is a half everywhere.
    let point = |i: i32| format!("v {i} 0 0 {} 0.5 0\n", f64::from(4 - i) / 4.0);
    place.write("painted.obj", (0..5).map(point).collect::<String>());
    let wire = |mask: &str, y: i32| {
        format!(
            "Wire(curve: Polyline(points: [(0, 0, 0), (4, 0, 0)]), rotation: 0, pose: [(0, {y}, 0), (4, {y}, 0)]{mask})"
        )
    };
    let (red, green) = (", mask: VertexColor(R)", "mask: VertexColor(G),");
    for (name, effect, wires, height) in [
        ("whole", green, wire("", 1), &(|_| 0.5) as &dyn Fn(f64) -> f64),
        ("wire", "", wire(red, 1), &|x| 1.0 - x / 4.0),
        ("both", green, wire(red, 1), &|x| 0.5 * (1.0 - x / 4.0)),
        // The second pulls down, of equal weight where both move a point as far; the plain sum of both.
        ("two", "blend: Blend(crossing: 1),", format!("{}, {}", wire(red, 1), wire("", -1)), &|x| -x / 4.0),
        (
            "lattice",
            "mask: VertexColor(R), lattice: Lattice(min: (0, -1, -1), max: (4, 1, 1), cells: (2, 2, 2)),",
            wire("", 1).replace("rotation", "radius: 1e9, rotation"),
            &|x| 1.0 - x / 4.0,
        ),
    ] {
        place.write("paint.ron", format!("Deform({effect} wires: [{wires}])"));
        place.run("apply paint.ron painted.obj -o out.obj").expect(0);
        let now = Obj::read(&place.path("out.obj"), &Limits::default()).unwrap().mesh.positions;
        for (i, p) in now.iter().enumerate() {
            let want = [i as f32, height(i as f64) as f32, 0.0];
            assert!((0..3).all(|a| (p[a] - want[a]).abs() < 1e-6), "{name}: {p:?}, not {want:?}");
        }
    }
    // An image is not to be written over.
    place.write("mask.obj", "an image, by its name in the preset");
    place.write("over.ron", format!("Deform(wires: [{}])", wire(", mask: Image(\"mask.obj\")", 1)));
    for line in ["-o mask.obj", "-o out.obj --report mask.obj"] {
        place.run(&format!("apply over.ron painted.obj {line}")).expect(2);
    }
}

#[test]
fn what_lies_outside_a_lattice_is_a_warning() {
    let place = Place::new();
    let preset = |min: f32| {
        format!(
            "Deform(object: Grid(size: (2, 2), cells: (4, 4)),
                lattice: Lattice(min: ({min}, -1, -1), max: (9, 1, 1), cells: (1, 1, 1)),
                wires: [Wire(curve: Polyline(points: [(9, 1, -1), (9, 1, 1)]), pose: [(9, 2, -1), (9, 2, 1)])])"
        )
    };
    place.write("some.ron", preset(-0.25));
    place.write("none.ron", preset(2.0));
    for command in ["check some.ron", "apply some.ron -o some.obj"] {
        let err = place.run(command).expect(0).err();
        assert!(
            err.contains("warning: some.ron: 10 of 25 points lie outside the lattice"),
            "{command}: {err}"
        );
        place.run(&format!("{command} --strict")).expect(3);
    }
    let err = place.run("apply none.ron -o none.obj").expect(0).err();
    assert!(
        err.contains("all points lie outside the lattice of the effect, from (2, -1, -1) to (9, 1, 1)"),
        "{err}"
    );
    assert_eq!(err.matches("warning").count(), 1, "{err}");
    place.write("flat.ron", preset(9.0));
    let err = place.run("check flat.ron").expect(4).err();
    assert!(err.contains("flat.ron:2:"), "{err}");
}

/// A net of 4 × 4 control points whose inner ones a wire lifts.
const NET: &str = "Deform(
    object: Patch(points: [
        [(-1, 0, 1), (-1, 0, 0.33), (-1, 0, -0.33), (-1, 0, -1)],
        [(-0.33, 0, 1), (-0.33, 0, 0.33), (-0.33, 0, -0.33), (-0.33, 0, -1)],
        [(0.33, 0, 1), (0.33, 0, 0.33), (0.33, 0, -0.33), (0.33, 0, -1)],
        [(1, 0, 1), (1, 0, 0.33), (1, 0, -0.33), (1, 0, -1)],
    ], tessellation: (24, 24), deform: ControlPoints),
    wires: [Wire(curve: Polyline(points: [(-0.33, 0, 0.33), (0.33, 0, 0.33)]), radius: 0.5,
        pose: Keys([(0, [(-0.33, 0, 0.33), (0.33, 0, 0.33)]), (1, [(-0.33, 0.9, 0.33), (0.33, 0.9, 0.33)])]))],
)";

#[test]
fn control_points_carry_the_surface_and_its_normals() {
    let place = Place::new();
    place.write("net.ron", NET);
    let report = place.run("apply net.ron -o net.glb --report -").expect(0).out();
    assert!(report.contains("\"points\": 625"), "{report}");
    let glb = place.read("net.glb");
    for t in [0.0, 0.5, 1.0] {
        let shown = oracle::evaluate(&glb, Some("wirework"), t);
        let oracle::Shown { positions, normals: Some(normals), .. } = &shown[0] else { panic!("normals") };
        assert_eq!(positions.len(), 625);
        for (i, (p, n)) in positions.iter().zip(normals).enumerate() {
            // Two of the points rise: the weights of cubic Bernstein polynomials, B₁ + B₂ along u and B₁ along v.
            let (u, v) = ((i / 25) as f64 / 24.0, (i % 25) as f64 / 24.0);
            let (a, b) = (3.0 * u * (1.0 - u), 3.0 * v * (1.0 - v).powi(2));
            let lift = 0.9 * f64::from(t);
            assert!((p.y - lift * a * b).abs() < 2e-4, "vertex {i} at {t} s: {p}");
            let (du, dv) = (3.0 * (1.0 - 2.0 * u) * b * lift, a * 3.0 * (1.0 - v) * (1.0 - 3.0 * v) * lift);
            let exact = DVec3::new(2.0, du, 0.0).cross(DVec3::new(0.0, dv, -2.0)).normalize();
            let bound = if t == 0.0 { 1e-6 } else { 0.12 };
            assert!(n.distance(exact) < bound, "vertex {i} at {t} s: {n}, not {exact}");
        }
    }
}

#[test]
fn inspect_tells_what_an_effect_may_move() {
    let place = Place::new();
    place.write(
        "scope.ron",
        "Stack([
            Deform(units: Bounds, only: Joints([\"arm\", \"hand\"]), mask: VertexColor(G),
                lattice: Lattice(min: (-1, -1, -1), max: (1, 1, 1), cells: (2, 3, 4)),
                wires: [WireLattice(min: (-1, -1, -1), max: (1, 1, 1), radius: 0.4, moves: [Move(y: 2, by: (0, 1, 0))])]),
            Wrinkle(mask: Image(\"a.png\", A), pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])])),
        ])",
    );
    let table = place.run("inspect scope.ron").expect(0).out();
    for line in [
        "effect 0     Deform: 27 wires, a lattice of 2 x 3 x 4 cells, only: Joints([\"arm\", \"hand\"]), mask: VertexColor(G), units: Bounds",
        "effect 1     Wrinkle: 1 wire, mask: Image(\"a.png\", A)",
    ] {
        assert!(table.contains(line), "{line} in\n{table}");
    }
    let json = place.run("inspect scope.ron --json").expect(0).out();
    let facts: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(facts["effects"][0]["lattice"], serde_json::json!([2, 3, 4]));
    assert_eq!(facts["effects"][0]["units"], "Bounds");
    assert_eq!(facts["effects"][1]["only"], serde_json::Value::Null);
}
