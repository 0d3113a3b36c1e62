//! Folds that walk, and curtains that swing.

use glam::DVec3;

use super::{HIGH, WIDE, crests, section, vertices};
use crate::oracle;
use crate::place::Place;

fn sheet(fields: &str) -> String {
    format!(
        "Wrinkle(object: Grid(size: (2, 2), cells: (40, 400)), size: (1, 0.6), creases: 2, thickness: {WIDE}, \
         intensity: {HIGH}, {fields})"
    )
}

#[test]
fn a_fold_moves_at_its_velocity_and_keeps_its_height() {
    let place = Place::new();
    let preset = sheet("motion: Travelling(velocity: (0.1, 0.2))");
    for t in [0.0, 0.25, 1.0, 2.0] {
        let points = place.still(&preset, t);
        let found = crests(&section(&points, 0.0), HIGH);
        assert_eq!(found.len(), 2, "{found:?}");
        for ((z, height), from) in found.iter().zip([-0.15, 0.15]) {
            // Across is normal × direction, −Z.
            assert!((z - (from - 0.2 * t)).abs() < 0.004, "at {t} s: {found:?}");
            assert!((height / HIGH - 1.0).abs() < 0.03, "at {t} s: {found:?}");
        }
        // Along: the fold has moved by 0.1 m a second.
        let on: Vec<f64> = points
            .iter()
            .filter(|p| (p.z - (0.15 - 0.2 * t)).abs() < 0.003 && p.y > HIGH / 2.0)
            .map(|p| p.x)
            .collect();
        let (first, last) = (on.iter().copied().fold(1.0, f64::min), on.iter().copied().fold(-1.0, f64::max));
        assert!((f64::midpoint(first, last) - 0.1 * t).abs() < 0.03, "at {t} s from {first} to {last}");
    }
    place.write("walk.ron", &preset);
    let told = place.run("apply walk.ron -o walk.glb").expect(0).err();
    assert!(told.contains("49 frames"), "two seconds, without keys: {told}");
    let glb = place.read("walk.glb");
    for t in [0.5, 1.25] {
        let shown = oracle::evaluate(&glb, Some("wirework"), t as f32).swap_remove(0).positions;
        let still = place.still(&preset, t);
        // 1e-4 of the diagonal, the default tolerance.
        let off = shown.iter().zip(&still).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(off < 1.1e-4 * 8.0_f64.sqrt(), "{off}");
    }
}

#[test]
fn a_fold_stops_smoothly_at_the_border() {
    let place = Place::new();
    let preset =
        sheet("duration: 6, motion: Travelling(velocity: (0, 0.3))").replace("creases: 2", "creases: 1");
    place.write("stop.ron", &preset);
    place.run("apply stop.ron -o stop####.obj --fps 6 -q").expect(0);
    let at = |k: usize| {
        let points = vertices(&place.read(&format!("stop{k:04}.obj")));
        let found = crests(&section(&points, 0.0), HIGH);
        assert_eq!(found.len(), 1, "frame {k}: {found:?}");
        assert!((found[0].1 / HIGH - 1.0).abs() < 0.04, "frame {k}: {found:?}");
        found[0].0
    };
    let places: Vec<f64> = (0..=36).map(at).collect();
    let steps: Vec<f64> = places.windows(2).map(|pair| pair[0] - pair[1]).collect();
    assert!(steps[..15].iter().all(|s| (s - 0.05).abs() < 0.006), "{steps:?}");
    assert!(steps.windows(2).all(|pair| pair[1] < pair[0] + 0.006), "it never goes faster: {steps:?}");
    assert!(steps[30..].iter().all(|s| s.abs() < 1e-3), "it rests: {steps:?}");
    assert!(places[36] > -1.01 && places[36] < -0.9, "at the border: {}", places[36]);
}

#[test]
fn rings_run_outwards_and_come_in_again() {
    let place = Place::new();
    let preset = format!(
        "Wrinkle(object: Grid(size: (2, 2), cells: (20, 400)), pattern: Ripple, size: (1.6, 1), creases: 4, thickness: 0.06, \
         intensity: {HIGH}, motion: Travelling(velocity: (0.1, 0)))"
    );
    let rings = |t: f64| -> Vec<(f64, f64)> {
        let points = place.still(&preset, t);
        crests(&section(&points, 0.0), HIGH).into_iter().filter(|c| c.0 > 0.0).collect()
    };
    for t in [0.0, 0.5, 1.0] {
        let found = rings(t);
        for r in [0.4, 0.6].map(|r| r + 0.1 * t) {
            let near = found.iter().find(|c| (c.0 - r).abs() < 0.006);
            let (_, height) = near.unwrap_or_else(|| panic!("no ring at {r}: {found:?}"));
            assert!((height / HIGH - 1.0).abs() < 0.03, "{found:?}");
        }
    }
    // After a whole step between rings they look the same where all are full.
    let [a, b] =
        [0.0, 2.0].map(|t| rings(t).into_iter().filter(|c| c.0 > 0.3 && c.0 < 0.7).collect::<Vec<_>>());
    assert!(a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a.0 - b.0).abs() < 0.006), "{a:?} {b:?}");
}

#[test]
fn drawn_folds_follow_their_keys() {
    let place = Place::new();
    let preset = "Wrinkle(object: Grid(size: (2, 2), cells: (40, 400)), thickness: 0.1, intensity: 0.03, pattern: Drawn([
        Polyline(Keys([(0, [(-0.5, 0, -0.4), (0.5, 0, -0.4)]), (1, [(-0.5, 0, 0.2), (0.5, 0, 0.4)])])),
    ]))";
    for (t, at) in [(0.0, -0.4), (0.5, -0.05), (1.0, 0.3)] {
        let found = crests(&section(&place.still(preset, t), 0.0), HIGH);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            (found[0].0 - at).abs() < 0.006 && (found[0].1 / HIGH - 1.0).abs() < 0.03,
            "at {t} s: {found:?}"
        );
    }
    let driven = preset.replace("thickness", "motion: Travelling(velocity: (0, 0.2)), thickness");
    let found = crests(&section(&place.still(&driven, 0.0), 0.0), HIGH);
    assert!((found[0].0 + 0.4).abs() < 0.006, "{found:?}");
}

#[test]
fn keyed_numbers_are_what_they_are_at_their_time() {
    let place = Place::new();
    let preset = sheet("duration: 3, stiffness: 0.5")
        .replace(&format!("thickness: {WIDE}"), "thickness: Keys([(0, 0.1), (2, 0.05)])")
        .replace(&format!("intensity: {HIGH}"), "intensity: Ease([(0, 0), (2, 0.03)])");
    for (t, wide, high) in [(0.0, 0.1, 0.0), (1.0, 0.075, 0.015), (2.0, 0.05, 0.03), (3.0, 0.05, 0.03)] {
        let points = place.still(&preset, t);
        let section = section(&points, 0.0);
        let top = section.iter().map(|s| s.1).fold(0.0, f64::max);
        assert!((top - high).abs() < 0.03 * HIGH, "at {t} s: {top}");
        for (z, y) in section.iter().filter(|s| (s.0.abs() - 0.15).abs() > wide + 1e-4) {
            assert_eq!(*y, 0.0, "at {t} s beyond its thickness: {z}");
        }
        if high > 0.0 {
            let inner = section
                .iter()
                .filter(|s| (s.0.abs() - 0.15).abs() < 0.9 * wide)
                .map(|s| s.1)
                .fold(1.0, f64::min);
            assert!(inner > 0.0, "at {t} s within its thickness");
        }
    }
    place.write("long.ron", &preset);
    let told = place.run("apply long.ron -o long.glb").expect(0).err();
    assert!(told.contains("73 frames"), "{told}");
}

/// A cloth that hangs from a rail at `y = 1`, which is drawn aside by half a metre in the first second.
fn curtain(fields: &str) -> String {
    format!(
        "Wrinkle(object: Grid(size: (1.6, 2), cells: (64, 40), normal: (0, 0, 1)), duration: 6, direction: (0, -1, 0), \
         size: (2, 1.4), creases: 7, thickness: 0.12, intensity: 0.01, motion: Curtain(rail: Polyline(Ease([\
         (0, [(-0.8, 1, 0), (0.8, 1, 0)]), (1, [(-0.8, 1, 0.5), (0.8, 1, 0.5)])])), {fields}))"
    )
}

#[test]
fn a_curtain_is_the_same_each_time_and_in_any_part() {
    let place = Place::new();
    place.write("curtain.ron", curtain("wind: (0, 0, 2), gusts: 1"));
    place.run("apply curtain.ron -o a####.obj --fps 8 -q --threads 1").expect(0);
    place.run("apply curtain.ron -o b####.obj --fps 8 -q --threads 2").expect(0);
    place.run("apply curtain.ron -o c####.obj --fps 8 -q --frames 21..23").expect(0);
    for k in 0..=48 {
        assert!(place.read(&format!("a{k:04}.obj")) == place.read(&format!("b{k:04}.obj")), "frame {k}");
    }
    for k in 21..23 {
        assert!(
            place.read(&format!("c{k:04}.obj")) == place.read(&format!("a{k:04}.obj")),
            "frame {k} alone"
        );
    }
    assert!(
        !place.files().contains(&"c0023.obj".to_owned()) && !place.files().contains(&"c0020.obj".to_owned())
    );
    let still = place.still(&curtain("wind: (0, 0, 2), gusts: 1"), 21.0 / 8.0);
    assert!(still == vertices(&place.read("a0021.obj")), "and a still of that moment");
}

#[test]
fn the_tops_of_a_curtain_follow_the_rail_and_it_comes_to_rest() {
    let place = Place::new();
    place.write("curtain.ron", curtain(""));
    place.run("apply curtain.ron -o c####.obj --fps 24 -q").expect(0);
    let frames: Vec<Vec<DVec3>> = (0..=144).map(|k| vertices(&place.read(&format!("c{k:04}.obj")))).collect();
    let rest = &frames[0];
    // On a crease, the middle one, at the top.
    let top = (0..rest.len()).find(|&i| rest[i].x.abs() < 1e-6 && (rest[i].y - 1.0).abs() < 1e-6).unwrap();
    let foot = (0..rest.len()).find(|&i| rest[i].x.abs() < 1e-6 && (rest[i].y + 1.0).abs() < 1e-6).unwrap();
    for (k, frame) in frames.iter().enumerate() {
        let x = (k as f64 / 24.0).min(1.0);
        let rail = 0.5 * x * x * (3.0 - 2.0 * x);
        assert!((frame[top].z - 0.01 - rail).abs() < 0.01, "frame {k}: {} at {rail}", frame[top]);
        assert!(frame[top].truncate().distance(DVec3::Y.truncate()) < 0.01, "frame {k}: {}", frame[top]);
    }
    // The free end comes behind, swings and rests below the rail.
    let behind = frames[10][top].z - frames[10][foot].z;
    assert!(behind > 0.02, "{behind}");
    let step =
        |k: usize| (0..rest.len()).map(|i| frames[k][i].distance(frames[k + 1][i])).fold(0.0, f64::max);
    let most = (0..144).map(step).fold(0.0, f64::max);
    assert!(most < 0.12, "no jump: {most}");
    let last = (120..144).map(step).fold(0.0, f64::max);
    eprintln!("curtain: largest step {most:.4}, in the last second {last:.5}");
    assert!(last < 0.1 * most, "{last} of {most}");
    assert!((frames[144][foot].z - 0.51).abs() < 0.05, "{}", frames[144][foot]);
    // Ropes do not stretch: the middle one keeps its length.
    let middle: Vec<usize> = {
        let mut list: Vec<usize> = (0..rest.len()).filter(|&i| rest[i].x.abs() < 1e-6).collect();
        list.sort_by(|&a, &b| rest[b].y.total_cmp(&rest[a].y));
        list
    };
    for frame in &frames {
        let length: f64 = middle.windows(2).map(|pair| frame[pair[0]].distance(frame[pair[1]])).sum();
        assert!((length / 2.0 - 1.0).abs() < 0.02, "{length}");
    }
}
