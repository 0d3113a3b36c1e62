//! Directional dropoff, domain curves and masks against closed forms.

use std::f64::consts::{FRAC_PI_2, PI};
use wirework_core::{Blend, Bounded, Curve, Density, Domain, Locator, Wire};
use wirework_reference::{Doubt, Scene, displacement, influence};

fn line(from: [f32; 3], to: [f32; 3]) -> Curve {
    Curve::polyline(vec![from, to]).unwrap()
}

/// Along x from the origin, length 4, radius 2, lifted by 1 along z.
fn lifted() -> Wire {
    let mut wire = Wire { radius: 2.0, ..Wire::new(line([0.0; 3], [4.0, 0.0, 0.0])) };
    wire.pose.iter_mut().for_each(|p| p[2] = 1.0);
    wire
}

/// Parallel to it at `(y, z)`.
fn beside(y: f32, z: f32) -> Domain {
    Domain::new(line([-1.0, y, z], [5.0, y, z]))
}

fn quartic(x: f64) -> f64 {
    if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 1e-12
}

#[test]
fn a_direction_falls_off_by_the_angle_about_the_wire() {
    // The part along the wire does not count.
    let wire = Wire { direction: Some([5.0, 3.0, 0.0]), angle: 2.0, ..lifted() };
    for degrees in [0.0_f64, 20.0, 90.0, 114.0, 115.0, 180.0, 270.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let angle = degrees.min(360.0 - degrees).to_radians();
        let expected = 0.5625 * quartic(angle / 2.0);
        assert!(close(influence(&wire, [1.0, cos, sin]), expected), "{degrees}");
    }
    assert_eq!(influence(&wire, [1.0, 0.0, 0.0]), 1.0, "on the wire");
    assert_eq!(influence(&wire, [-1.0, 0.0, 0.0]), 0.5625, "in line with it");
    let along = Wire { direction: Some([1.0, 0.0, 0.0]), ..wire.clone() };
    assert_eq!(influence(&along, [1.0, -1.0, 0.0]), 0.5625);
    // Beyond the end the arm has a part along the wire too.
    assert!(close(influence(&wire, [-1.0, -1.0, 0.0]), 0.0));
    assert!(close(influence(&wire, [-1.0, 0.0, 1.0]), 0.25 * quartic(FRAC_PI_2 / 2.0)));
    let linear = Wire { density: Density::Linear, ..wire };
    assert!(close(influence(&linear, [1.0, 0.0, 1.0]), 0.5 * (1.0 - FRAC_PI_2 / 2.0)));
}

#[test]
fn locators_turn_the_direction_and_open_its_angle() {
    let at = |u, direction, angle| Locator { u, direction, angle, ..Locator::default() };
    let wire = Wire {
        locators: vec![
            at(0.0, Some([0.0, 1.0, 0.0]), Some(1.0)),
            at(0.5, None, Some(3.0)),
            at(1.0, Some([0.0, 0.0, 3.0]), None),
        ],
        direction: Some([0.0, -1.0, 0.0]),
        ..lifted()
    };
    // At u = 1/4 the axis is (0, 3/4, 3/4): 45°, the angle 2.
    let f = |p: [f64; 3]| influence(&wire, p);
    assert!(close(f([1.0, 1.0, 0.0]), 0.5625 * quartic(0.75_f64.atan2(0.75) / 2.0)));
    assert!(close(f([1.0, 0.6, 0.8]), 0.5625 * quartic((0.8_f64.atan2(0.6) - PI / 4.0).abs() / 2.0)));
    assert!(close(f([0.0, 1.0, 0.0]), 0.5625));
    assert!(close(f([4.0, 0.0, 1.0]), 0.5625));
    let bare = Wire { locators: vec![at(0.5, None, Some(0.1))], ..lifted() };
    assert_eq!(influence(&bare, [1.0, -1.0, 0.0]), 0.5625, "no direction, no dropoff");
}

#[test]
fn a_domain_sets_the_radius_on_its_side() {
    for (distance, delta) in [(1.0_f32, 0.0_f32), (3.0, 0.0), (1.0, 0.5), (3.0, 0.25)] {
        let wire = Wire { domains: vec![Domain { delta, ..beside(distance, 0.0) }], ..lifted() };
        for degrees in [0.0_f64, 30.0, 61.0, 70.0, 89.0, 90.0, 100.0, 180.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (delta, d) = (f64::from(delta), f64::from(distance));
            let radius = match cos {
                c if c < 1e-9 => 2.0,
                c if c >= delta => d,
                c => {
                    let x = c / delta;
                    2.0 + (d - 2.0) * (3.0 - 2.0 * x) * x * x
                }
            };
            for from in [0.3, 0.9, 1.5, 2.5] {
                // cos 90° is not 0 to the bit.
                let y = if degrees == 90.0 { 0.0 } else { from * cos };
                let found = influence(&wire, [1.0, y, from * sin]);
                assert!(close(found, quartic(from / radius)), "{distance} {delta} {degrees} {from}: {found}");
            }
        }
        assert_eq!(influence(&wire, [1.0, 0.0, 0.0]), 1.0, "on R");
    }
}

#[test]
fn the_foot_on_a_domain_is_that_of_the_point() {
    // D runs across: from (1, 1, 0) up. The point (3, 2, 0) has R's foot at x = 3, D's foot at (1, 2, 0).
    let domain = Domain::new(line([1.0, 1.0, 0.0], [1.0, 9.0, 0.0]));
    let wire = Wire { domains: vec![domain], radius: 9.0, ..lifted() };
    // ‖R − D‖ = √8.
    assert!(close(influence(&wire, [3.0, 2.0, 0.0]), quartic(2.0 / 8.0_f64.sqrt())));
    // Of two feet as near as each other the one of smaller u.
    let fork = Curve::polyline(vec![[0.0, 4.0, 0.0], [1.0, 1.0, 0.0], [2.0, 4.0, 0.0]]).unwrap();
    let wire = Wire { domains: vec![Domain::new(fork)], radius: 9.0, ..lifted() };
    // (1, 3, 0): foot on the left leg at a distance of 2·(1/√10), that is (0.4, 2.8, 0).
    let radius = (0.6_f64.powi(2) + 2.8_f64.powi(2)).sqrt();
    assert!(close(influence(&wire, [1.0, 3.0, 0.0]), quartic(3.0 / radius)));
}

#[test]
fn several_domains_unite_or_tend_to_the_smallest() {
    let two = |m| {
        let domains = [beside(3.0, 0.0), beside(4.0, 0.5)].map(|d| Domain { exponent: m, ..d });
        Wire { domains: domains.to_vec(), ..lifted() }
    };
    let p = [1.0, 1.0, 0.0];
    let (a, b) = (quartic(1.0 / 3.0), quartic(1.0 / 16.25_f64.sqrt()));
    for m in [1.0_f32, -1.0, 0.0, 2.5] {
        let weight = |f: f64| f.powf(m.into());
        let expected = (a * weight(a) + b * weight(b)) / (weight(a) + weight(b));
        assert!(close(influence(&two(m), p), expected), "m = {m}");
    }
    assert!(close(influence(&two(3e4), p), b));
    assert!(close(influence(&two(-3e4), p), a));
    // One that does not reach is left out whatever its exponent; where none does there is nothing.
    let mut wire = two(-1.0);
    wire.domains[0] = beside(0.5, 0.0);
    assert!(close(influence(&wire, p), b));
    wire.domains[1] = beside(0.75, 0.0);
    assert_eq!(influence(&wire, p), 0.0);
    let mixed =
        Wire { domains: vec![beside(3.0, 0.0), Domain { exponent: -1.0, ..beside(4.0, 0.5) }], ..lifted() };
    assert!(close(influence(&mixed, p), (a * a + 1.0) / (a + 1.0 / b)));
}

#[test]
fn a_domain_bounds_one_attribute_alone() {
    let p = [1.0, 1.0, 0.0];
    let f = 0.5625;
    let part = quartic(1.0 / 1.5);
    let bounded = |bounds, wire: Wire| Wire { domains: vec![Domain { bounds, ..beside(1.5, 0.0) }], ..wire };
    let still = Wire::new(line([0.0; 3], [4.0, 0.0, 0.0]));
    let still = Wire { radius: 2.0, ..still };
    let all = [Bounded::Scale, Bounded::Rotation, Bounded::Amplitude, Bounded::Twist];
    for bounds in all {
        assert_eq!(influence(&bounded(bounds, still.clone()), p), f);
    }
    let scaled = bounded(Bounded::Scale, Wire { scale: 3.0, ..still.clone() });
    assert!(close(displacement(&scaled, p)[1], 2.0 * part));
    let twisted = bounded(Bounded::Twist, Wire { twist: 1.0, ..still.clone() });
    assert!(close(displacement(&twisted, p)[2], part.sin()));
    let lower = bounded(Bounded::Amplitude, lifted());
    assert!(close(displacement(&lower, p)[2], part));
    let mut bent = Wire { rotation: 0.5, ..still };
    bent.pose = vec![[0.0; 3], [0.0, 4.0, 0.0]];
    let bent = bounded(Bounded::Rotation, bent);
    let turned = displacement(&bent, [0.0, 1.0, 0.0]);
    assert!(close(turned[0], -(FRAC_PI_2 * 0.5 * part).sin()));
    // On the far side, and on the wire, it acts in full.
    assert!(close(displacement(&lower, [1.0, -1.0, 0.0])[2], f));
    assert!(close(displacement(&lower, [1.0, 0.0, 0.0])[2], 1.0));
    // Beyond D it does nothing, where the influence reaches on.
    assert_eq!(displacement(&lower, [1.0, 1.6, 0.0]), [0.0; 3]);
    assert!(influence(&lower, [1.0, 1.6, 0.0]) > 0.0);
}

#[test]
fn a_mask_multiplies_the_influence_in_every_use() {
    let wires = [lifted(), Wire { pose: vec![[0.0; 3], [4.0, 0.0, 0.0]], ..lifted() }];
    let (p, blend) = ([1.0, 1.0, 0.0], Blend { localize: 1.0, ..Blend::default() });
    let height = |blend: &Blend, masks: &[f32]| Scene::new(&wires, blend).deform_masked(p, masks)[2];
    let f = 0.5625;
    assert!(close(height(&Blend::default(), &[]), f));
    assert!(close(height(&Blend::default(), &[0.5]), 0.5 * f));
    assert_eq!(height(&Blend::default(), &[0.0]), 0.0);
    // The resting wire anchors by its own masked influence.
    assert!(close(height(&blend, &[1.0, 0.5]), f / 1.5));
    assert!(close(height(&blend, &[0.5, 1.0]), 0.5 * f / 3.0));
    assert!(close(height(&blend, &[0.5, 0.0]), 0.5 * f));
    assert_eq!(Scene::new(&wires, &blend).contributions(p, &[0.5, 0.0])[1].0, 0.0);
}

#[test]
fn the_side_of_a_domain_and_the_axis_of_a_wire_are_doubtful() {
    let doubt = |wire: Wire, p| Doubt::new(&[wire], &Blend::default(), 1e-6).of(p);
    let sided = |delta| Wire { domains: vec![Domain { delta, ..beside(1.0, 0.0) }], ..lifted() };
    assert!(doubt(sided(0.0), [1.0, 0.0, 0.9]) > 0.1);
    assert!(doubt(sided(0.0), [1.0, -0.1, 0.9]) < 1e-4);
    assert!(doubt(sided(0.5), [1.0, 0.0, 0.9]) < 1e-4);
    let directed = Wire { direction: Some([0.0, 1.0, 0.0]), ..lifted() };
    assert!(doubt(directed.clone(), [1.0, 0.0, 0.0]) > 0.1);
    assert!(doubt(directed, [1.0, 0.1, 0.0]) < 1e-4);
}
