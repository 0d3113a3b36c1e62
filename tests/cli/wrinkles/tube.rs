//! Round a tube: patterns wrap, and crests stand off it.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{HIGH, WIDE};
use crate::place::Place;

const RADIUS: f64 = 0.3;

/// A tube of 2 m along y with a ring at `y = 0` and vertices at every multiple of 45°.
fn tube(fields: &str) -> String {
    format!(
        "Wrinkle(object: Tube(from: (0, -1, 0), to: (0, 1, 0), radius: {RADIUS}, sides: 64, rings: 81, caps: false), \
         center: (0, 0, {RADIUS}), thickness: {WIDE}, intensity: {HIGH}, {fields})"
    )
}

/// How far round a point is from the centre of the patterns, −π to π.
fn angle(p: DVec3) -> f64 {
    p.x.atan2(p.z)
}

fn stands(p: DVec3) -> f64 {
    p.x.hypot(p.z) - RADIUS
}

#[test]
fn crests_stand_off_a_tube_by_the_intensity() {
    let place = Place::new();
    let eighth = TAU * RADIUS / 8.0;
    for stiffness in [0.0, 0.3, 1.0] {
        let preset = tube(&format!(
            "direction: (0, 1, 0), size: (1.2, {}), creases: 3, stiffness: {stiffness}",
            3.0 * eighth
        ));
        let rest = place.still(&preset.replace("intensity: ", "propagation: 0, intensity: "), 0.0);
        let points = place.still(&preset, 0.0);
        let mut on = 0;
        for (p, r) in points.iter().zip(&rest) {
            let place = angle(*r) * RADIUS / eighth;
            let crest = (place - place.round()).abs() < 1e-4 && place.abs() < 1.5;
            if crest && r.y.abs() < 0.6 - 1e-6 {
                assert!((stands(*p) / HIGH - 1.0).abs() < 0.03, "stiffness {stiffness} at {r}: {p}");
                let off = (*p - *r).reject_from(DVec3::new(r.x, 0.0, r.z).normalize()).length();
                assert!(off < 0.02 * HIGH, "it rises straight off: {p} from {r}");
                on += 1;
            }
            assert!(stands(*p) < 1.001 * HIGH && stands(*p) > -1e-6, "{p}");
            if angle(*r).abs() > 0.75 * PI {
                assert_eq!(p, r, "what is behind does not move");
            }
        }
        assert!(on > 3 * 40, "{on}");
    }
}

#[test]
fn a_crease_goes_round_as_far_as_it_is_long() {
    let place = Place::new();
    let length = 0.9 * TAU * RADIUS;
    let points = place.still(&tube(&format!("direction: (1, 0, 0), size: ({length}, 1), creases: 1")), 0.0);
    let ring: Vec<DVec3> = points.iter().copied().filter(|p| p.y.abs() < 1e-6).collect();
    assert_eq!(ring.len(), 64);
    for p in ring {
        if angle(p).abs() < 0.89 * PI {
            assert!((stands(p) / HIGH - 1.0).abs() < 0.03, "{p}");
        }
    }
    let short =
        place.still(&tube(&format!("direction: (1, 0, 0), size: ({}, 1), creases: 1", length / 2.0)), 0.0);
    let gap = 0.45 * PI + 1.05 * WIDE / RADIUS;
    assert!(short.iter().all(|p| angle(*p).abs() < gap || stands(*p).abs() < 1e-6));
}

#[test]
fn a_ripple_of_half_the_circumference_reaches_round() {
    let place = Place::new();
    let half = PI * RADIUS;
    let one = place.still(&tube(&format!("pattern: Ripple, size: ({}, 1), creases: 1", 2.0 * half)), 0.0);
    let mut far = 0;
    for p in &one {
        let way = (angle(*p) * RADIUS).hypot(p.y);
        if (way - half).abs() < 0.002 {
            assert!((stands(*p) / HIGH - 1.0).abs() < 0.05, "{p}");
            far += usize::from(angle(*p).abs() > 0.95 * PI);
        }
        if way < half - 1.05 * WIDE {
            assert!(stands(*p).abs() < 1e-6, "{p}");
        }
    }
    assert!(far > 0, "its crest has come to the back");
    // Rings by their order, along the middle.
    let preset = tube(&format!("pattern: Ripple, size: ({}, 1), creases: 4, stiffness: 0.6", 2.0 * half));
    let points = place.still(&preset, 0.0);
    let line = |side: f64| -> Vec<(f64, f64)> {
        let on = points
            .iter()
            .filter(|p| p.y.abs() < 1e-6 && (side * angle(**p) > -1e-6 || angle(**p).abs() > 0.999 * PI));
        let mut out: Vec<_> = on.map(|p| (angle(*p).abs() * RADIUS, stands(*p))).collect();
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        out
    };
    for side in [1.0, -1.0] {
        let found = super::crests(&line(side), HIGH);
        assert_eq!(found.len(), 4, "{found:?}");
        for (i, (at, height)) in found.iter().enumerate() {
            assert!((at - half * (i + 1) as f64 / 4.0).abs() < 0.02, "{found:?}");
            assert!((height / HIGH - 1.0).abs() < 0.05, "{found:?}");
        }
    }
}

#[test]
fn folds_walk_round_at_their_velocity() {
    let place = Place::new();
    // Across is normal × direction: Z × Y = −X. A quarter round in a second.
    let speed = TAU * RADIUS / 4.0;
    let preset = tube(&format!(
        "direction: (0, 1, 0), size: (1.2, 1), creases: 1, motion: Travelling(velocity: (0, {speed}))"
    ));
    for (t, at) in [(0.0, 0.0), (0.5, -PI / 4.0), (1.0, -PI / 2.0), (2.0, PI), (3.5, PI / 4.0)] {
        let points = place.still(&preset, t);
        for p in points.iter().filter(|p| p.y.abs() < 0.5) {
            let off = ((angle(*p) - at + 3.0 * PI).rem_euclid(TAU) - PI).abs();
            if off < 1e-4 {
                assert!((stands(*p) / HIGH - 1.0).abs() < 0.03, "at {t} s: {p}");
            }
            if off * RADIUS > 1.05 * WIDE {
                assert!(stands(*p).abs() < 1e-6, "at {t} s: {p}");
            }
        }
    }
}
