//! Limbs among other effects, on a part of an object, and in parts of its size.

use glam::DVec3;

use super::made::{figure, middle, played, ring, target, trunk};
use super::{LENGTH, apart, limb, vertices};
use crate::place::Place;

const CHAIN: &str = "chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)])";
/// Swells the middle of the tube, more and more.
const SWELL: &str =
    "wires: [Wire(curve: Polyline([(1, 0, 0), (2, 0, 0)]), radius: 0.7, scale: Keys([(0, 1), (1, 2)]))]";

#[test]
fn effects_work_on_the_result_of_the_one_before() {
    let place = Place::new();
    place.write("rest.obj", place.tube_at_rest());
    let reach = format!("Ik({CHAIN}, goal: Keys([(0, (3, 0, 0)), (1, (2.5, 0.6, 0.2))]))");
    let swell = format!("Deform({SWELL})");
    for [first, second] in [[&swell, &reach], [&reach, &swell]] {
        for t in [0.0, 0.5, 1.0] {
            place.write("half.obj", {
                place.of(first, "rest.obj", t);
                place.read("still.obj")
            });
            let apart_from = place.of(second, "half.obj", t);
            let together = place.of(&format!("Stack([{first}, {second}])"), "rest.obj", t);
            let off = apart(&apart_from, &together);
            assert!(off < 1e-5, "{first} at {t} s: {off}");
            let alone = apart(&together, &place.of(first, "rest.obj", t));
            assert_eq!(alone > 0.02, t > 0.0, "{first} at {t} s: the second moves {alone}");
        }
    }
}

#[test]
fn a_skin_is_posed_below_and_above_other_effects() {
    let place = Place::new();
    place.write("figure.glb", figure(true).glb());
    let reach = "Ik(chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights, goal: Node(\"target\"), elasticity: 0)";
    // Lifts the trunk, and nothing of the arm.
    let lift = "Deform(only: Joints([\"hips\"]), wires: [Wire(curve: Polyline([(0, 0.5, 0), (0, 1, 0)]), radius: 0.4,
        pose: Keys([(0, [(0, 0.5, 0), (0, 1, 0)]), (2, [(0, 0.5, 0.3), (0, 1, 0.3)])]))])";
    for stack in [format!("Stack([{lift}, {reach}])"), format!("Stack([{reach}, {lift}])")] {
        place.write("stack.ron", &stack);
        place.run("apply stack.ron figure.glb -o out.glb --bake frames --fps 4 --into swing -q").expect(0);
        let [old, new] = ["figure.glb", "out.glb"].map(|name| place.read(name));
        for frame in 0..=8 {
            let t = f64::from(frame) / 4.0;
            let [before, after] = [&old, &new].map(|glb| played(glb, Some("swing"), t));
            let hand = middle(&after, &ring(0.8));
            assert!(hand.distance(target(t)) < 2e-5, "at {t} s: {hand}, not {}", target(t));
            let lifted = middle(&after, &trunk()) - middle(&before, &trunk());
            assert_eq!(lifted.length() > 0.01, frame > 0, "at {t} s: {lifted}");
        }
    }
}

#[test]
fn only_what_is_named_follows() {
    let place = Place::new();
    place.write("figure.glb", figure(false).glb());
    let preset = |only: &str| {
        format!(
            "Ik(chain: Skin(root: \"upper\", tip: \"hand\"), {only} goal: (0.5, 1.5, 0.4), elasticity: 0)"
        )
    };
    let rest = place.untouched("figure.glb", 0.0);
    let free = place.of(&preset(""), "figure.glb", 0.0);
    assert!(trunk().iter().all(|&v| free[v] != rest[v]), "without it all follow");
    for only in ["only: Joints([\"fore\", \"hand\"]),", "only: Joints([\"hand\"]),"] {
        let now = place.of(&preset(only), "figure.glb", 0.0);
        for v in trunk().into_iter().chain(ring(0.3)) {
            assert!(now[v] == rest[v], "{only} vertex {v}");
        }
        for v in ring(0.8) {
            assert!(now[v].distance(free[v]) < 1e-6, "{only} vertex {v}: {} {}", now[v], free[v]);
        }
    }
}

#[test]
fn painted_influence_multiplies() {
    let place = Place::new();
    let line = |i: i32| format!("v {} 0 0 {} 0.5 0\n", f64::from(i) / 4.0, f64::from(12 - i) / 12.0);
    place.write("line.obj", (0..=12).map(line).collect::<String>());
    let preset = |mask: &str| {
        format!("Ik({CHAIN}, goal: (4.5, 0, 0), elasticity: 1, max_stretch: 3, volume: 0, {mask})")
    };
    for (mask, part) in [
        ("", &(|_| 1.0) as &dyn Fn(f64) -> f64),
        ("mask: VertexColor(G)", &|_| 0.5),
        ("mask: VertexColor(R)", &|x| 1.0 - x / LENGTH),
    ] {
        let now = place.of(&preset(mask), "line.obj", 0.0);
        for (i, p) in now.iter().enumerate() {
            let x = i as f64 / 4.0;
            let expected = DVec3::X * (x + 0.5 * x * part(x));
            assert!(p.distance(expected) < 1e-5, "{mask} {x}: {p}, not {expected}");
        }
    }
}

#[test]
fn parts_of_the_size_give_the_same_shape_at_any_size() {
    let place = Place::new();
    let rest = vertices(&place.tube_at_rest());
    let sized = |factor: f64| {
        let points: Vec<String> = rest
            .iter()
            .map(|p| *p * factor + DVec3::new(7.0, -2.0, 1.0))
            .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z))
            .collect();
        points.concat()
    };
    place.write("small.obj", sized(1.0));
    place.write("large.obj", sized(10.0));
    let fields = "pole: (0, 0.5, 0.4), pins: [(1, (-0.2, 0.1, 0))], elasticity: 0.3, goal: (0.1, 0.3, 0.2)";
    let preset = format!(
        "Ik(units: Bounds, chain: Joints([(-0.5, 0, 0), (-0.1666667, 0, 0), (0.1666667, 0, 0), (0.5, 0, 0)]), {fields})"
    );
    let moved = DVec3::new(7.0, -2.0, 1.0);
    let [small, large] = ["small.obj", "large.obj"].map(|name| place.of(&preset, name, 0.0));
    for (a, b) in small.iter().zip(&large) {
        let (a, b) = (*a - moved, (*b - moved) / 10.0);
        assert!(a.distance(b) < 1e-4, "{a} {b}");
    }
    // The same in metres, about the middle of the tube.
    let metres =
        limb("pole: (1.5, 1.5, 1.2), pins: [(1, (0.9, 0.3, 0))], elasticity: 0.3, goal: (1.8, 0.9, 0.6)");
    let own = place.still(&metres, 0.0);
    let off = small.iter().zip(&own).map(|(p, q)| (*p - moved).distance(*q)).fold(0.0, f64::max);
    assert!(off < 1e-4, "{off}");
}

#[test]
fn influence_ends_at_its_radius() {
    let place = Place::new();
    let points: Vec<String> = (0..=10).map(|i| format!("v 1.5 {} 0\n", f64::from(i) / 10.0)).collect();
    place.write("line.obj", points.concat());
    let preset = |influence: &str| {
        format!(
            "Ik({CHAIN}, goal: (4.5, 0, 0), elasticity: 1, max_stretch: 3, volume: 0, influence: {influence})"
        )
    };
    let now = place.of(&preset("Radius(0.5)"), "line.obj", 0.0);
    for (i, p) in now.iter().enumerate() {
        let y = i as f64 / 10.0;
        let x = (y / 0.5).min(1.0);
        let expected = DVec3::new(1.5 + 0.75 * (1.0 - x * x).powi(2), y, 0.0);
        assert!(p.distance(expected) < 1e-5, "{p}, not {expected}");
        assert!(y < 0.5 || (p.x, p.z) == (1.5, 0.0), "{p}");
    }
    assert!(place.of(&preset("All"), "line.obj", 0.0).iter().all(|p| (p.x - 2.25).abs() < 1e-5));
}
