//! On a flat grid: how many folds, how high, how wide, how far.

use glam::DVec3;

use super::{HIGH, WIDE, crests, section, width};
use crate::place::Place;

/// A grid of 2 m with vertices wherever crests are, and folds on it.
fn folds(fields: &str) -> String {
    format!(
        "Wrinkle(object: Grid(size: (2, 2), cells: (40, 400)), size: (1.2, 1.6), thickness: {WIDE}, \
         intensity: {HIGH}, {fields})"
    )
}

#[test]
fn there_are_as_many_crests_as_creases_where_they_belong() {
    let place = Place::new();
    for count in [1, 2, 3, 5, 8, 13] {
        let spacing = 1.6 / f64::from(count);
        let preset = folds(&format!("creases: {count}"))
            .replace(&format!("thickness: {WIDE}"), &format!("thickness: {}", 0.4 * spacing));
        let points = place.still(&preset, 0.0);
        for x in [-0.55, 0.0, 0.55] {
            let found = crests(&section(&points, x), HIGH);
            assert_eq!(found.len(), count as usize, "{found:?}");
            for (i, (z, height)) in found.iter().enumerate() {
                // Across is normal × direction, −Z, and the crests are symmetric.
                let at = ((i as f64 + 0.5) / f64::from(count) - 0.5) * 1.6;
                assert!((z - at).abs() < 0.006, "crest {i} of {count} at {z}, not {at}");
                // One between two rows of vertices is not seen whole.
                let seen = if count == 1 || count == 2 || count == 8 { 0.97 } else { 0.9 };
                assert!(*height > seen * HIGH && *height < 1.001 * HIGH, "{height}");
            }
        }
        let beyond = section(&points, 0.8);
        assert!(count < 5 || beyond.iter().all(|s| s.1 == 0.0), "beyond the ends nothing moves");
    }
}

#[test]
fn rings_and_rays_are_as_many_as_creases() {
    let place = Place::new();
    let object = "object: Grid(size: (2, 2), cells: (200, 200))";
    for count in [1, 3, 4] {
        let preset = format!(
            "Wrinkle({object}, pattern: Ripple, size: (1.6, 1), creases: {count}, thickness: 0.08, intensity: {HIGH}, stiffness: 0.8)"
        );
        let found = crests(&section(&place.still(&preset, 0.0), 0.0), HIGH);
        let rings = f64::from(count);
        let wanted: Vec<f64> = (1..=count).map(|i| 0.8 * f64::from(i) / rings).collect();
        let wanted: Vec<f64> = wanted.iter().rev().map(|r| -r).chain(wanted.iter().copied()).collect();
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for ((z, height), at) in found.iter().zip(wanted) {
            assert!((z - at).abs() < 0.011 && (height / HIGH - 1.0).abs() < 0.03, "{z} {height}: {at}");
        }
    }
    for count in [3, 5, 8] {
        let preset = format!(
            "Wrinkle({object}, pattern: Radial, direction: (0, 0, 1), size: (1.8, 1), creases: {count}, thickness: 0.08, intensity: {HIGH}, stiffness: 0.8)"
        );
        let points = place.still(&preset, 0.0);
        // Round a circle by angle from the first axis towards across: Y × Z = X.
        let mut ring: Vec<(f64, f64)> = points
            .iter()
            .filter(|p| (p.x.hypot(p.z) - 0.7).abs() < 0.012)
            .map(|p| (p.x.atan2(p.z).rem_euclid(std::f64::consts::TAU), p.y))
            .collect();
        ring.sort_by(|a, b| a.0.total_cmp(&b.0));
        let tall = |angle: f64| {
            let off = |a: f64| {
                (a - angle + 9.0 * std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI
            };
            ring.iter().filter(|s| off(s.0).abs() < 0.02).map(|s| s.1).fold(0.0, f64::max)
        };
        for i in 0..count {
            let step = std::f64::consts::TAU / f64::from(count);
            let (on, between) = (tall(step * f64::from(i)), tall(step * (f64::from(i) + 0.5)));
            assert!((on / HIGH - 1.0).abs() < 0.03 && between == 0.0, "{i} of {count}: {on} {between}");
        }
        let most = points.iter().map(|p| p.y).fold(0.0, f64::max);
        assert!(most < 1.001 * HIGH, "{most}");
        assert!(points.iter().all(|p| p.y == 0.0 || p.x.hypot(p.z) < 0.9 + 0.08), "beyond the ends");
    }
}

#[test]
fn a_crest_is_as_high_as_it_is_said_to_be_and_stiffness_only_broadens_it() {
    let place = Place::new();
    for sign in [1.0, -1.0] {
        let mut before = 0.0;
        for tenths in 0..=10 {
            let preset = folds(&format!("creases: 4, stiffness: {}", f64::from(tenths) / 10.0))
                .replace("intensity: ", if sign < 0.0 { "intensity: -" } else { "intensity: " });
            let points: Vec<DVec3> = place.still(&preset, 0.0).iter().map(|p| *p * sign).collect();
            for p in &points {
                if p.x.abs() < 0.6 + 1e-6 && [0.2, 0.6].iter().any(|z| (p.z.abs() - z).abs() < 1e-4) {
                    assert!((p.y / HIGH - 1.0).abs() < 0.03, "stiffness {tenths}: {p}");
                }
                assert!(p.y >= 0.0 && p.y < 1.001 * HIGH, "stiffness {tenths}: {p}");
            }
            let wide = width(&section(&points, 0.0), 0.2, HIGH);
            assert!(wide > before + 0.02 * WIDE, "stiffness {tenths}: {wide} after {before}");
            assert!(wide < 2.0 * WIDE);
            before = wide;
        }
    }
}

/// The height on a crest by the fraction of the crease, from the origin on.
fn along(points: &[DVec3]) -> Vec<(f64, f64)> {
    let on = points.iter().filter(|p| (p.z - 0.2).abs() < 1e-4 && p.x.abs() < 0.6 + 1e-6);
    let mut out: Vec<_> = on.map(|p| ((p.x + 0.6) / 1.2, p.y / HIGH)).collect();
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

#[test]
fn resistance_takes_the_far_end_and_the_front_stops_where_it_has_come() {
    let place = Place::new();
    let crest = |fields: &str, t: f64| along(&place.still(&folds(&format!("creases: 4, {fields}")), t));
    let tired = crest("resistance: 1", 0.0);
    assert!(tired[0].1 > 0.97 && tired.last().unwrap().1 < 0.3, "{tired:?}");
    assert!(tired.windows(2).all(|pair| pair[1].1 < pair[0].1 + 1e-3), "it falls all along: {tired:?}");
    let half = crest("resistance: 0.5", 0.0);
    assert!((half.last().unwrap().1 - 0.5).abs() < 0.03 && half[0].1 > 0.97, "{half:?}");
    let keyed = "propagation: Keys([(0, 0), (2, 1)])";
    for (fields, t, front) in [("propagation: 0.5", 0.0, 0.5), (keyed, 1.0, 0.5), (keyed, 0.5, 0.25)] {
        let crest = crest(fields, t);
        for &(x, height) in &crest {
            assert!(x > front || (height - 1.0).abs() < 0.03, "{fields}: {height} at {x}");
            assert!(x < front + 0.12 || height.abs() < 1e-3, "{fields}: {height} at {x}");
        }
    }
    let at = |t: f64| place.still(&folds(&format!("creases: 4, {keyed}")), t);
    assert!(at(0.0).iter().all(|p| p.y == 0.0), "before it starts nothing moves");
    let early = at(0.01).iter().map(|p| p.y).fold(0.0, f64::max);
    assert!(early < 0.2 * HIGH, "it starts continuously: {early}");
    assert!(along(&at(2.0)).iter().all(|x| (x.1 - 1.0).abs() < 0.03), "and is everywhere in the end");
}

#[test]
fn rings_spread_from_the_centre() {
    let place = Place::new();
    let ripple = |fields: &str| {
        let preset = format!(
            "Wrinkle(object: Grid(size: (2, 2), cells: (200, 200)), pattern: Ripple, size: (1.6, 1), creases: 4, \
             thickness: 0.08, intensity: {HIGH}, stiffness: 0.8, {fields})"
        );
        let points = place.still(&preset, 0.0);
        [0.2, 0.4, 0.6, 0.8].map(|r| {
            let ring = points.iter().filter(|p| (p.x.hypot(p.z) - r).abs() < 0.005);
            ring.map(|p| p.y / HIGH).fold(0.0, f64::max)
        })
    };
    let front = ripple("propagation: 0.5");
    assert!(front[0] > 0.97 && front[1] > 0.97 && front[2] < 1e-3 && front[3] < 1e-3, "{front:?}");
    let tired = ripple("resistance: 1");
    assert!(tired.windows(2).all(|pair| pair[1] < pair[0]) && tired[3] < 0.3, "{tired:?}");
}

#[test]
fn compression_makes_the_cross_section_as_long_as_the_cloth() {
    let place = Place::new();
    for (compression, stiffness) in [(0.02, 0.5), (0.1, 0.3), (0.1, 1.0), (0.3, 0.0)] {
        let preset = format!(
            "Wrinkle(object: Grid(size: (2, 2), cells: (4, 1000)), size: (1.9, 1.8), creases: 9, thickness: 0.1, \
             stiffness: {stiffness}, compression: {compression})"
        );
        let section = section(&place.still(&preset, 0.0), 0.0);
        // Between the second crest and the last but one.
        let inner: Vec<_> = section.iter().filter(|s| s.0.abs() < 0.6001).collect();
        let arc: f64 = inner.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum();
        let found = 1.0 - (inner[inner.len() - 1].0 - inner[0].0) / arc;
        eprintln!("compression {compression}, stiffness {stiffness}: {found:.4}");
        assert!((found / compression - 1.0).abs() < 0.04, "{compression} {stiffness}: {found}");
    }
}

#[test]
fn the_seed_decides_and_nothing_else() {
    let place = Place::new();
    let run = |fields: &str, threads: u32| {
        place.write("seed.ron", folds(&format!("creases: 6, {fields}")));
        place.run(&format!("apply seed.ron -o seed.obj --at 0 --threads {threads} -q")).expect(0);
        place.read("seed.obj")
    };
    let first = run("randomness: 0.7, seed: 5", 1);
    assert!(first == run("randomness: 0.7, seed: 5", 2), "the same seed, the same bytes");
    assert!(first != run("randomness: 0.7, seed: 6", 1), "another one, others");
    assert!(run("randomness: 0, seed: 5", 1) == run("seed: 6", 1), "without randomness it says nothing");
    let points = super::vertices(&first);
    let top = points.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!(top < 1.001 * HIGH && top > 0.5 * HIGH, "{top}");
}
