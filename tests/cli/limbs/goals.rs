//! Goals in time: keys and curves, and that no frame depends on another.

use glam::DVec3;

use super::{limb, vertices};
use crate::place::Place;

#[test]
fn a_keyed_goal_is_reached_at_each_moment() {
    let place = Place::new();
    let keys = [DVec3::new(3.0, 0.0, 0.0), DVec3::new(2.0, 1.5, 0.0), DVec3::new(1.0, 1.0, 1.0)];
    let list: Vec<String> =
        keys.iter().enumerate().map(|(t, key)| format!("({t}, {})", super::point(*key))).collect();
    for elasticity in [0, 1] {
        let preset =
            |kind: &str| limb(&format!("elasticity: {elasticity}, goal: {kind}([{}])", list.join(", ")));
        for (t, from, x) in
            [(0.0, 0, 0.0), (0.25, 0, 0.25), (1.0, 1, 0.0), (1.5, 1, 0.5), (2.0, 1, 1.0), (7.0, 1, 1.0)]
        {
            for (kind, x) in [("Keys", x), ("Ease", x * x * (3.0 - 2.0 * x))] {
                let goal = keys[from].lerp(keys[from + 1], x);
                let tip = place.shape(&preset(kind), t).tip();
                assert!(tip.distance(goal) < 1e-3, "{kind} at {t} s: {tip}, not {goal}");
            }
        }
    }
}

#[test]
fn a_goal_on_a_curve_gets_along_it_once() {
    let place = Place::new();
    let curve = "Curve(Polyline([(3, 0, 0), (2, 2, 0), (1, 1, 1)]))";
    let [a, b, c] = [DVec3::new(3.0, 0.0, 0.0), DVec3::new(2.0, 2.0, 0.0), DVec3::new(1.0, 1.0, 1.0)];
    for (fields, whole) in [("", 2.0), ("duration: 5,", 5.0), ("twist: Keys([(0, 0), (3, 10)]),", 3.0)] {
        let preset = limb(&format!("{fields} elasticity: 0, goal: {curve}"));
        for (u, goal) in
            [(0.0, a), (0.25, a.midpoint(b)), (0.5, b), (0.875, b.lerp(c, 0.75)), (1.0, c), (1.5, c)]
        {
            let tip = place.shape(&preset, u * whole).tip();
            assert!(tip.distance(goal) < 1e-3, "{fields} at {u} of it: {tip}, not {goal}");
        }
        place.write("long.ron", preset);
        let told = place.run("apply long.ron --dry-run --fps 10").expect(0).err();
        assert!(told.contains(&format!("{} frames", 10.0 * whole + 1.0)), "{told}");
    }
}

/// The last key of anything ends the animation.
#[test]
fn all_that_is_keyed_counts_for_the_duration() {
    let place = Place::new();
    for (fields, frames) in [
        ("goal: (2, 1, 0)", 1),
        ("goal: Keys([(0, (3, 0, 0)), (0.5, (2, 1, 0))])", 13),
        ("goal: (2, 1, 0), elasticity: Keys([(0, 0), (1, 1)])", 25),
        ("goal: (2, 1, 0), pole: Ease([(0, (0, 9, 0)), (1.5, (0, 0, 9))])", 37),
        ("goal: (2, 1, 0), twist: Keys([(0, 0), (2, 90)])", 49),
        ("goal: (2, 1, 0), pins: [(1, Keys([(0, (1, 0, 0)), (0.25, (1, 0.1, 0))]))]", 7),
        ("goal: Keys([(0, (3, 0, 0)), (0.5, (2, 1, 0))]), duration: 0.25", 7),
    ] {
        place.write("keyed.ron", limb(fields));
        let report = place.run("apply keyed.ron --dry-run --report -").expect(0).out();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        assert_eq!((&report["frames"], &report["wires"]), (&frames.into(), &1.into()), "{fields}");
    }
}

#[test]
fn frames_depend_on_nothing_but_their_time() {
    let place = Place::new();
    // Past the direction opposite the rest, through the root and out of reach.
    let preset = limb(
        "goal: Keys([(0, (3, 0, 0)), (0.5, (0, 2, 0.1)), (1, (-3, 0.1, 0)), (1.4, (0, 0, 0)), (2, (9, 3, 1))]),
        elasticity: Keys([(0, 0), (2, 1)]), pole: Keys([(0, (0, 5, 0)), (2, (0, 0, 5))]), twist: Keys([(0, 0), (2, 200)]),
        limits: [170, 120, 120], stiffness: [0, 0.5, 0]",
    );
    place.write("move.ron", &preset);
    place.run("apply move.ron -o a####.obj --fps 8 -q --threads 1").expect(0);
    place.run("apply move.ron -o b####.obj --fps 8 -q --threads 2").expect(0);
    place.run("apply move.ron -o c####.obj --fps 8 -q --frames 11..13").expect(0);
    let mut before = Vec::new();
    for k in 0..=16 {
        let frame = place.read(&format!("a{k:04}.obj"));
        assert!(frame == place.read(&format!("b{k:04}.obj")), "frame {k}");
        let still = place.still(&preset, f64::from(k) / 8.0);
        assert!(still == vertices(&frame), "frame {k} as a still");
        assert!(still != before, "frame {k} moves");
        before = still;
    }
    for k in 11..13 {
        assert!(place.read(&format!("c{k:04}.obj")) == place.read(&format!("a{k:04}.obj")), "{k} alone");
    }
    for bake in ["auto", "frames"] {
        for threads in [1, 2] {
            place
                .run(&format!(
                    "apply move.ron -o t{threads}.glb --fps 8 -q --bake {bake} --threads {threads}"
                ))
                .expect(0);
        }
        assert!(place.read("t1.glb") == place.read("t2.glb"), "--bake {bake}");
    }
}
