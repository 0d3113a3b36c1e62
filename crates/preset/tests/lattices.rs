//! `Lattice`, `WireLattice` and `deform: ControlPoints`.

mod common;

use common::{check, errors};
use wirework_core::{CurveKind, Density, Lattice};
use wirework_preset::{
    Action, Deform, KeyedWire, Limits, Object, Parsed, PatchDeform, PresetErrorKind, Shape, parse,
};

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

fn deform(text: &str) -> Deform {
    match parsed(text).preset.effects.remove(0).action {
        Action::Deform(deform) => deform,
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => panic!(),
    }
}

/// A box of 2 × 4 × 6 about the origin with some wires, and one point of them that moves.
fn net(fields: &str) -> String {
    format!("Deform(wires: [WireLattice(min: (-1, -2, -3), max: (1, 2, 3), {fields})])")
}

fn wires(fields: &str) -> Vec<KeyedWire> {
    deform(&net(fields)).wires
}

#[test]
fn lattices_have_the_documented_defaults() {
    let wire = "wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: 2)]";
    assert_eq!(deform(&format!("Deform({wire})")).lattice, None);
    assert_eq!(deform(&format!("Deform({wire}, lattice: None)")).lattice, None);
    let found = deform(&format!("Deform({wire}, lattice: Lattice(min: (0, 0, 0), max: (1, 2, 3)))")).lattice;
    assert_eq!(found, Some(Lattice { min: [0.0; 3], max: [1.0, 2.0, 3.0], cells: [3; 3] }));
    let found =
        deform(&format!("Deform({wire}, lattice: (cells: (1, 32, 2), min: (0, 0, 0), max: (1, 2, 3)))"));
    assert_eq!(found.lattice.map(|lattice| lattice.cells), Some([1, 32, 2]));
}

#[test]
fn a_wire_runs_along_each_line() {
    let wires = wires("lines: (2, 3, 4), degree: 1, radius: 5, scale: 2");
    // 3·4 along X, 2·4 along Y, 2·3 along Z.
    assert_eq!(wires.len(), 12 + 8 + 6);
    let points: Vec<&[[f32; 3]]> = wires.iter().map(|wire| wire.reference().points()).collect();
    assert_eq!(points[0], [[-1.0, -2.0, -3.0], [1.0, -2.0, -3.0]]);
    assert_eq!(points[1], [[-1.0, 0.0, -3.0], [1.0, 0.0, -3.0]]);
    assert_eq!(points[3], [[-1.0, -2.0, -1.0], [1.0, -2.0, -1.0]]);
    assert_eq!(points[12], [[-1.0, -2.0, -3.0], [-1.0, 0.0, -3.0], [-1.0, 2.0, -3.0]]);
    assert_eq!(points[13], [[1.0, -2.0, -3.0], [1.0, 0.0, -3.0], [1.0, 2.0, -3.0]]);
    assert_eq!(points[25], [[1.0, 2.0, -3.0], [1.0, 2.0, -1.0], [1.0, 2.0, 1.0], [1.0, 2.0, 3.0]]);
    for wire in &wires {
        let wire = wire.at(0.0);
        assert_eq!((wire.reference.kind(), wire.radius), (CurveKind::BSpline { degree: 1 }, 5.0));
        assert_eq!(wire.pose, wire.reference.points());
        assert_eq!(wire.check(), Ok(()));
    }
}

#[test]
fn by_default_there_are_27_cubic_wires() {
    let wires = wires("scale: 2");
    assert_eq!(wires.len(), 27);
    assert!(wires.iter().all(|wire| wire.reference().kind() == CurveKind::BSpline { degree: 3 }));
}

#[test]
fn by_default_the_wires_reach_twice_the_largest_side() {
    // The box is 2 × 4 × 6.
    assert!(wires("scale: 2").iter().all(|wire| wire.at(0.0).radius == 12.0));
    assert!(wires("scale: 2, radius: 1").iter().all(|wire| wire.at(0.0).radius == 1.0));
    for (min, max, radius) in [("-3e38", "3e38", f32::MAX), ("0", "1e-45", 2.0 * f32::from_bits(1))] {
        let text = format!(
            "Deform(wires: [WireLattice(min: ({min}, {min}, {min}), max: ({max}, {max}, {max}), scale: 2)])"
        );
        assert!(deform(&text).wires.iter().all(|wire| wire.at(0.0).radius == radius), "{text}");
    }
}

#[test]
fn a_move_takes_along_the_points_with_its_indices() {
    let moves = "moves: [Move(x: 2, by: Keys([(0, (0, 0, 0)), (2, (1, 0, 0))])), Move(x: 2, y: 1, z: 0, by: (0, 0, 0.5))]";
    let wires = wires(moves);
    for (seconds, dx) in [(0.0, 0.0), (1.0, 0.5), (5.0, 1.0)] {
        let mut corners = 0;
        for keyed in &wires {
            let mut wire = keyed.at(9.0);
            keyed.at_into(seconds, &mut wire);
            assert_eq!(wire, keyed.at(seconds));
            for (rest, now) in wire.reference.points().iter().zip(&wire.pose) {
                let one = *rest == [1.0, 0.0, -3.0];
                let x = if rest[0] == 1.0 { rest[0] + dx } else { rest[0] };
                let z = if one { -2.5 } else { rest[2] };
                assert_eq!(*now, [x, rest[1], z], "{rest:?} at {seconds} s");
                corners += usize::from(one);
            }
        }
        assert_eq!(corners, 3, "each point lies on three lines");
    }
    let preset = parsed(&net(moves)).preset;
    assert_eq!((preset.duration, preset.animated), (2.0, true));
}

#[test]
fn a_pose_has_all_points_and_moves_come_on_top() {
    let mut points = Vec::new();
    for z in [-3.0_f32, 3.0] {
        for y in [-2.0_f32, 2.0] {
            points.extend([-1.0_f32, 1.0].map(|x| [x, y, z]));
        }
    }
    let shifted: Vec<[f32; 3]> = points.iter().map(|p| [p[0] + 2.0, p[1], p[2] * 0.5]).collect();
    let text = |points: &[[f32; 3]]| {
        let points: Vec<String> = points.iter().map(|[x, y, z]| format!("({x:?}, {y:?}, {z:?})")).collect();
        format!("[{}]", points.join(", "))
    };
    let pose = format!("Keys([(0, {}), (1, {})])", text(&points), text(&shifted));
    let found = wires(&format!("lines: (2, 2, 2), pose: {pose}, moves: [Move(by: (0, 8, 0))]"));
    assert_eq!(found.len(), 12);
    for wire in found {
        let (rest, end) = (wire.at(0.0), wire.at(1.0));
        for (i, p) in rest.reference.points().iter().enumerate() {
            assert_eq!(rest.pose[i], [p[0], p[1] + 8.0, p[2]]);
            assert_eq!(end.pose[i], [p[0] + 2.0, p[1] + 8.0, p[2] * 0.5]);
        }
    }
    let still = wires(&format!("lines: (2, 2, 2), pose: {}", text(&shifted)));
    assert_eq!(still[0].at(3.0).pose, [[1.0, -2.0, -1.5], [3.0, -2.0, -1.5]]);
}

#[test]
fn every_wire_of_a_lattice_has_its_fields() {
    let fields = "radius: Keys([(0, 1), (2, 3)]), amplitude: 0.5, rotation: 0, twist: 90, density: Linear, bend: Transport,
        correspondence: ArcLength, interpolation: Smooth, closest: Blended(0.5), exponent: 2, only: Nodes([\"a\"]),
        mask: VertexColor(G), moves: [Move(x: 0, by: (1, 0, 0))]";
    for keyed in wires(fields) {
        let wire = keyed.at(1.0);
        assert_eq!((wire.radius, wire.amplitude, wire.rotation, wire.exponent), (2.0, 0.5, 0.0, Some(2.0)));
        assert_eq!((wire.twist, wire.density), (std::f32::consts::FRAC_PI_2, Density::Linear));
        assert_eq!(wire.closest, wirework_core::Closest::Blended(0.5));
        assert!(keyed.only().is_some() && keyed.mask().is_some());
    }
}

#[test]
fn lattices_without_volume_are_refused_at_their_place() {
    let wire = "wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: 2)]";
    for (lattice, message) in [
        ("Lattice(min: (0, 0, 0), max: «(1, 0, 1)»)", "`max` must be greater than `min` along each axis"),
        ("Lattice(min: (0, 0, 0), max: «(1, 1, -1)»)", "`max` must be greater than `min` along each axis"),
        ("Lattice(min: (0, 0, 0), max: (1, «inf», 1))", "finite"),
        ("Lattice(min: (0, 0, 0), max: (1, 1, 1), cells: (3, «0», 3))", "at least 1"),
        ("Lattice(min: (0, 0, 0), max: (1, 1, 1), cells: (3, 3, «33»))", "from 1 to 32, found 33"),
        ("Lattice(min: (0, 0, 0), max: (1, 1, 1), cells: (3, 3, «256»))", "from 1 to 32, found 256"),
        ("Lattice(min: (0, 0, 0), max: (1, 1, 1), cells: «3»)", "expected three counts of cells `(l, m, n)`"),
        ("«7»", "expected `Lattice(field: value, ..)`"),
    ] {
        check(&format!("Deform({wire}, lattice: {lattice})"), PresetErrorKind::Value, message, None);
    }
    let text = format!("Deform({wire}, lattice: «Lattice»(min: (0, 0, 0)))");
    check(&text, PresetErrorKind::Name, "`Lattice` needs a field `max`", None);
    let text = format!("Deform({wire}, lattice: «Latice»(min: (0, 0, 0)))");
    check(&text, PresetErrorKind::Name, "no struct `Latice`", Some("`Lattice`"));
}

#[test]
fn bad_wire_lattices_are_refused_at_their_place() {
    for (fields, message) in [
        ("lines: (3, «1», 3)", "at least 2"),
        ("lines: («17», 3, 3)", "from 2 to 16, found 17"),
        ("lines: («18446744073709551615», 3, 3)", "from 2 to 16"),
        ("lines: «[3, 3, 3]»", "expected three counts of points `(x, y, z)`"),
        ("degree: «4»", "1, 2 or 3, found 4"),
        ("radius: «0»", "greater than 0"),
        ("closest: Blended(«0»)", "greater than 0"),
        ("moves: [Move(x: «3», by: (0, 0, 0))]", "the points along x have the indices 0 to 2, found 3"),
        (
            "lines: (2, 9, 2), moves: [Move(y: «9», by: (0, 0, 0))]",
            "the points along y have the indices 0 to 8, found 9",
        ),
        ("moves: [Move(z: «-1», by: (0, 0, 0))]", "expected a whole number of at least 0"),
        ("moves: [Move(x: 0, by: Keys([(0, (0, 0, 0)), (1, «1»)]))]", "expected a point `(x, y, z)`"),
        ("moves: [Move(x: 0, by: (0, «NaN», 0))]", "finite"),
        ("pose: «[(0, 0, 0)]»", "a pose has all points of the lattice, 3 × 3 × 3 = 27; found 1"),
        ("lines: (2, 2, 3), pose: Keys([(0, «[]»)])", "2 × 2 × 3 = 12; found 0"),
    ] {
        check(&net(fields), PresetErrorKind::Value, message, None);
    }
    check(&net("moves: [«Move»(x: 1)]"), PresetErrorKind::Name, "`Move` needs a field `by`", None);
    check(&net("moves: [«Mvoe»(x: 1)]"), PresetErrorKind::Name, "no struct `Mvoe`", Some("`Move`"));
    for fields in ["reference", "locators", "domains", "direction", "angle", "group"] {
        let found = errors(&net(&format!("{fields}: None")));
        assert_eq!(found.len(), 1, "{fields}");
        assert!(found[0].message.contains("`WireLattice` has no field"), "{}", found[0].message);
    }
    let flat = "Deform(wires: [WireLattice(min: (0, 0, 0), max: «(1, 1, 0)»)])";
    check(flat, PresetErrorKind::Value, "`max` must be greater than `min`", None);
    let wire = "Deform(wires: [«WireLatice»(min: (0, 0, 0), max: (1, 1, 1))])";
    check(
        wire,
        PresetErrorKind::Name,
        "no wire `WireLatice`; expected `Wire` or `WireLattice`",
        Some("`WireLattice`"),
    );
}

#[test]
fn lattices_that_do_nothing_are_warnings() {
    let of = |text: &str| -> Vec<(usize, String)> {
        parsed(text).warnings.into_iter().map(|w| (w.span.start, w.message)).collect()
    };
    for fields in
        ["", "moves: [Move(x: 1, by: (0, 0, 0))]", "moves: [Move(x: 1, by: (1, 0, 0))], amplitude: 0"]
    {
        let text = net(fields);
        let found = of(&text);
        let [(at, message)] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(Some(*at), text.find("WireLattice"));
        assert!(message.contains("these wires move nothing"), "{message}");
    }
    assert_eq!(
        of(&net("moves: [Move(x: 2, by: (1, 0, 0))]")),
        [],
        "most of its wires are still, but not all"
    );
    let text = net("moves: [Move(by: (1, 0, 0))]");
    let found = of(&text);
    assert_eq!(found.len(), 1);
    assert!(found[0].1.contains("without an index this moves the whole lattice"));
    assert_eq!(Some(found[0].0), text.find("Move("));
}

#[test]
fn generated_wires_count_as_if_they_were_typed() {
    let lattice = "WireLattice(min: (0, 0, 0), max: (1, 1, 1), lines: (16, 16, 16), scale: 2),";
    let many = format!("Deform(wires: [{}])", lattice.repeat(400));
    let start = std::time::Instant::now();
    let found = parse(many.as_bytes(), &Limits::default()).unwrap_err();
    assert!(found.is_limit() && found.to_string().contains("--max-preset-bytes"), "{found}");
    // Keys are in every wire.
    let keys = (0..5_000).map(|i| format!("({i}, 1),")).collect::<Vec<_>>().concat();
    let keyed =
        format!("Deform(wires: [{}])", lattice.replace("scale: 2", &format!("scale: Keys([{keys}])")));
    assert!(parse(keyed.as_bytes(), &Limits::default()).unwrap_err().is_limit());
    let large = Limits { bytes: 1 << 30, ..Limits::default() };
    assert!(parse(many.replace(&lattice.repeat(390), "").as_bytes(), &large).is_ok());
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn a_patch_says_what_is_deformed() {
    let object = |rest: &str| -> Object {
        let text = format!(
            "Deform(object: Patch(points: [[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]], {rest}),
                wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: 2)])"
        );
        parsed(&text).preset.object.expect("an object")
    };
    for (rest, expected) in [
        ("", PatchDeform::Points),
        ("deform: Points", PatchDeform::Points),
        ("deform: ControlPoints", PatchDeform::ControlPoints),
    ] {
        assert!(matches!(object(rest).shape, Shape::Patch { deform, .. } if deform == expected), "{rest}");
    }
    let text = "Deform(object: Patch(points: [[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]], deform: «ControlPoint»),
        wires: [Wire(curve: Polyline([(0, 0, 0)]))])";
    check(text, PresetErrorKind::Name, "no value of `deform`", Some("`ControlPoints`"));
}
