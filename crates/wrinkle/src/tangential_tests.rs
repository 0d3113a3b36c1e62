use glam::DVec3;
use wirework_core::Keyed;
use wirework_surface::{grid, tube};

use crate::ground::wide;
use crate::test_support::{LAYOUT, deform, lay, plane, wires};
use crate::{Layout, Motion, Pattern, Wrinkle};

#[test]
fn parallel_creases_lie_where_they_are_to() {
    let settings = Wrinkle::new(Pattern::Tangential(LAYOUT));
    let wires = wires(&lay(&plane(64), &settings).unwrap(), 0.0);
    assert_eq!(wires.len(), 5);
    for (i, wire) in wires.iter().enumerate() {
        // Across is normal × direction: −z.
        let z = -((i as f64 + 0.5) / 5.0 - 0.5);
        for k in 0..=20 {
            let u = k as f32 / 20.0;
            let expected = DVec3::new(f64::from(u) - 0.5, 0.0, z);
            assert!(wide(wire.reference.point(u)).distance(expected) < 1e-5, "crease {i} at {u}");
        }
    }
}

/// Local maxima of a section higher than `least`, its neighbours at least so far below.
fn crests(section: &[f64], least: f64) -> usize {
    let flat: Vec<f64> = section.to_vec();
    (1..flat.len() - 1)
        .filter(|&i| flat[i] > least && flat[i] > flat[i - 1] && flat[i] >= flat[i + 1])
        .count()
}

#[test]
fn a_section_has_a_crest_for_each_crease_of_the_height_asked_for() {
    let mesh = plane(200);
    for creases in [1, 3, 8] {
        let layout = Layout { creases, ..LAYOUT };
        let laid = lay(
            &mesh,
            &Wrinkle { thickness: Keyed::Constant(0.06), ..Wrinkle::new(Pattern::Tangential(layout)) },
        );
        let out = deform(&mesh, &laid.unwrap(), 0.0);
        for x in [-0.4, 0.0, 0.3] {
            let section: Vec<f64> =
                out.iter().filter(|p| (p[0] - x).abs() < 0.004).map(|p| f64::from(p[1])).collect();
            assert_eq!(crests(&section, 0.02), creases as usize, "{creases} at {x}");
            let highest = section.iter().copied().fold(0.0, f64::max);
            assert!((highest - 0.05).abs() < 0.03 * 0.05, "{highest}");
        }
    }
}

#[test]
fn creases_wrap_round_a_tube_and_stand_off_it() {
    let radius = 0.4;
    let mesh = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], radius, 128, 121, false).unwrap();
    // Round the tube, and nearly closed there.
    let layout = Layout { center: [0.5, 0.0, 0.0], direction: [0.0, 0.0, 1.0], size: [2.4, 0.8], creases: 4 };
    let laid = lay(&mesh, &Wrinkle::new(Pattern::Tangential(layout))).unwrap();
    assert_eq!(laid.warnings(), []);
    for (i, wire) in wires(&laid, 0.0).iter().enumerate() {
        let y = (i as f64 + 0.5) / 4.0 * 0.8 - 0.4;
        for k in 0..=40 {
            let u = k as f32 / 40.0;
            let (r, w) = (
                wide(wire.reference.point(u)),
                wide(wire.reference.posed(wire.pose.clone()).unwrap().point(u)),
            );
            let angle = -(f64::from(u) - 0.5) * 2.4 / f64::from(radius);
            let exact = DVec3::new(angle.cos(), 0.0, -angle.sin()) * f64::from(radius);
            // Normal × direction points down for a normal +X and a direction +Z.
            assert!(r.distance(exact - DVec3::Y * y) < 0.004, "{i} {u}: {r} {exact} {y}");
            let off = w - r;
            assert!(off.distance(exact.normalize() * 0.05) < 0.002, "{off} at {r}");
        }
    }
}

#[test]
fn travelling_folds_keep_their_height_and_speed_and_stop_at_a_border() {
    let mesh = plane(64);
    let layout = Layout { creases: 2, size: [0.6, 0.4], ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.05, 0.1] },
        thickness: Keyed::Constant(0.1),
        ..Wrinkle::new(Pattern::Tangential(layout))
    };
    let mut creases = lay(&mesh, &settings).unwrap();
    assert!(creases.moves());
    for seconds in [0.0, 1.0, 3.5] {
        creases.at(seconds, None).unwrap();
        for (i, wire) in wires(&creases, seconds).iter().enumerate() {
            let middle = wide(wire.reference.point(0.5));
            let z = 0.2 * (0.5 - i as f64) - 0.1 * seconds;
            assert!(middle.distance(DVec3::new(0.05 * seconds, 0.0, z)) < 1e-5, "{middle} at {seconds}");
            assert!(wire.pose.iter().all(|p| (p[1] - 0.05).abs() < 1e-6));
        }
    }
    // The border is at z = −1: the first stops there, the second a thickness behind.
    let mut before = [f64::NAN; 2];
    for i in 0..=600 {
        let seconds = f64::from(i) * 0.05;
        creases.at(seconds, None).unwrap();
        let now = [0, 1].map(|i| wide(wires(&creases, seconds)[i].reference.point(0.5)).z);
        for (a, b) in before.into_iter().zip(now) {
            assert!(a.is_nan() || (b <= a + 1e-9 && a - b < 0.0051), "{a} to {b}");
        }
        before = now;
    }
    assert!((before[1] + 1.0).abs() < 1e-5 && (before[0] + 0.9).abs() < 1e-5, "{before:?}");
    assert!((wide(wires(&creases, 30.0)[0].reference.point(1.0)).x - 1.0).abs() < 1e-5);
}

#[test]
fn a_last_step_too_short_to_be_seen_in_the_length_is_no_number_divided_by_nothing() {
    let layout = Layout { size: [0.6; 2], ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.0, 0.5] },
        ..Wrinkle::new(Pattern::Tangential(layout))
    };
    let mut creases = lay(&plane(60), &settings).unwrap();
    for seconds in [0.2, 0.21, 0.22] {
        creases.at(seconds, None).unwrap();
        let wires = wires(&creases, seconds);
        assert_eq!(wires.len(), 5);
        let points = wires.iter().flat_map(|wire| wire.pose.iter().chain(wire.reference.points()));
        assert!(points.flatten().all(|c| c.is_finite()), "at {seconds}");
    }
}

#[test]
fn compression_takes_up_that_part_of_the_length() {
    let mesh = grid([2.0, 2.0], [4, 2000], [0.0, 1.0, 0.0]).unwrap();
    for compression in [0.03, 0.1, 0.25] {
        let layout = Layout { creases: 8, size: [1.9, 1.6], ..LAYOUT };
        let settings = Wrinkle {
            compression: Some(compression),
            thickness: Keyed::Constant(0.11),
            stiffness: 0.5,
            ..Wrinkle::new(Pattern::Tangential(layout))
        };
        let out = deform(&mesh, &lay(&mesh, &settings).unwrap(), 0.0);
        // From crest to crest over six folds.
        let section: Vec<DVec3> =
            out.iter().filter(|p| p[0] == 0.0 && p[2].abs() <= 0.6001).map(|p| wide(*p)).collect();
        let folded: f64 = section.windows(2).map(|w| w[0].distance(w[1])).sum();
        let taken = 1.0 - 1.2 / folded;
        assert!((taken / f64::from(compression) - 1.0).abs() < 0.02, "{compression}: {taken}");
    }
}
