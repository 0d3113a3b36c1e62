//! What the guide to presets advises is so: presets through the engine, points about one wire.

use wirework_core::{Binding, Wire};
use wirework_preset::{Action, Limits, parse};

/// How far each point is moved by a wire with these fields.
fn displacements(fields: &str, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let text = format!("Deform(wires: [Wire({fields})])");
    let parsed = parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|e| panic!("{text}\n{e}"));
    assert_eq!(parsed.warnings, [], "{text}");
    let Some(Action::Deform(deform)) = parsed.preset.effects.into_iter().next().map(|e| e.action) else {
        panic!("{text}")
    };
    let wires: Vec<Wire> = deform.wires.iter().map(|wire| wire.at(0.0)).collect();
    let mut out = points.to_vec();
    let mut binding = Binding::new(&wires, points).expect("a binding");
    binding.deform_into(&wires, &deform.blend, &mut out).expect("a deformation");
    out.iter().zip(points).map(|(now, rest)| [0, 1, 2].map(|i| now[i] - rest[i])).collect()
}

/// How far a wire along X, lifted by 1, lifts points in the plane Y = 0: that is `F`.
fn lifts(fields: &str, points: &[[f32; 2]]) -> Vec<f32> {
    let wire =
        "curve: Polyline([(-1, 0, 0), (1, 0, 0)]), pose: [(-1, 1, 0), (1, 1, 0)], rotation: 0, radius: 1";
    let points: Vec<[f32; 3]> = points.iter().map(|[x, z]| [*x, 0.0, *z]).collect();
    displacements(&format!("{wire}, {fields}"), &points).iter().map(|by| by[1]).collect()
}

fn length(a: [f32; 3], b: [f32; 3]) -> f32 {
    [0, 1, 2].map(|i| (a[i] - b[i]).powi(2)).iter().sum::<f32>().sqrt()
}

#[test]
fn opposite_domains_unite_and_one_curve_bounds_both_sides() {
    let domain = |z: f32| format!("Domain(curve: Polyline([(-9, 0, {z:?}), (9, 0, {z:?})]), delta: 0.3)");
    let places = [[0.0, 0.3], [0.0, -0.3], [0.0, 0.7], [0.0, -0.7]];
    let f = |x: f32| (1.0 - x * x).powi(2);
    let two = lifts(&format!("domains: [{}, {}]", domain(0.5), domain(-0.5)), &places);
    let (near, far) = (f(0.6), f(0.3));
    let union = (near * near + far * far) / (near + far);
    for (found, wanted) in two.iter().zip([union, union, f(0.7), f(0.7)]) {
        assert!((found - wanted).abs() < 1e-5, "{two:?}, {wanted}");
    }
    for curve in [
        "Polyline(points: [(-2, 0, -0.5), (2, 0, -0.5), (2, 0, 0.5), (-2, 0, 0.5)], closed: true)",
        "Polyline([(-2, 0, -0.5), (2, 0, -0.5), (2, 0, 0.5), (-2, 0, 0.5)])",
    ] {
        let one = lifts(&format!("domains: [Domain(curve: {curve}, delta: 0.3)]"), &places);
        assert!((one[0] - near).abs() < 1e-5 && (one[1] - near).abs() < 1e-5, "{one:?}");
        assert_eq!(one[2..], [0.0, 0.0]);
    }
}

#[test]
fn a_negative_exponent_tends_to_the_smallest_that_reaches() {
    let domain = |z: f32| format!("Domain(curve: Polyline([(-9, 0, {z:?}), (9, 0, {z:?})]), exponent: -60)");
    let of = |z: f32| lifts(&format!("domains: [{}, {}]", domain(0.5), domain(0.9)), &[[0.0, z]])[0];
    let f = |x: f32| (1.0 - x * x).powi(2);
    assert!((of(0.3) - f(0.6)).abs() < 1e-3);
    assert!(of(0.499) < 0.001 && of(0.501) > 0.4, "where the nearer one ends influence steps");
}

#[test]
fn a_domain_beyond_the_radius_extends_the_influence() {
    let found =
        lifts("domains: [Domain(curve: Polyline([(-9, 0, 2), (9, 0, 2)]))]", &[[0.0, 1.5], [0.0, -1.5]]);
    assert!(found[0] > 0.1 && found[1] == 0.0, "{found:?}");
}

#[test]
fn a_delta_mends_the_tear_at_an_open_end() {
    // Off the end at (1, 0) the curve at z = 0.5 lies at a right angle to (a, −2a²).
    let places = [[1.4, -0.319], [1.4, -0.321]];
    let step = |delta: &str| {
        let domain =
            format!("domains: [Domain(curve: Polyline([(-9, 0, 0.5), (9, 0, 0.5)]), delta: {delta})]");
        let found = lifts(&domain, &places);
        (found[0] - found[1]).abs()
    };
    assert!(step("0") > 0.2 && step("0.3") < 0.01, "{} {}", step("0"), step("0.3"));
}

#[test]
fn the_outside_of_a_sharp_corner_tears_unless_the_wire_does_not_turn() {
    // Either side of the place where the feet leave the corner for a leg.
    let places = [[0.3, 0.0, -1e-3], [0.3, 0.0, 1e-3]];
    let step = |curve: &str, fields: &str| {
        let points = "[(-1, 0, 0), (0, 0, 0), (0, 0, 1)]";
        let pose = "[(-1, 0, 0), (0, 0, 0), (0, 0.8, 1)]";
        let wire = format!("curve: {curve}({points}), pose: {pose}, radius: 1, {fields}");
        let found = displacements(&wire, &places);
        length(found[0], found[1])
    };
    for closest in ["", "closest: Blended(0.3)"] {
        assert!(step("Polyline", closest) > 0.02, "{}", step("Polyline", closest));
    }
    assert!(step("Polyline", "rotation: 0") < 0.005);
    assert!(step("BSpline", "") < 0.005);
}

#[test]
fn transported_bends_go_on_into_parts_that_do_not_move() {
    // The first half turns up and down again, the last quarter lies where it lay.
    let wire = "curve: BSpline(points: [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0), (5, 0, 0), (6, 0, 0), (7, 0, 0)]),
        pose: [(0, 0, 0), (1, 2, 0), (2, 0, 2), (3, 0, 0), (4, 0, 0), (5, 0, 0), (6, 0, 0), (7, 0, 0)], radius: 1";
    let place = [[6.5, 0.5, 0.0]];
    let moved = |bend: &str| length(displacements(&format!("{wire}, bend: {bend}"), &place)[0], [0.0; 3]);
    assert!(moved("Tangent") == 0.0 && moved("Transport") > 0.01, "{}", moved("Transport"));
}
