//! What random rigs have besides plain wires: directions, domain curves, blended feet, masks; biased to trouble as the rest.

use crate::random::Random;
use crate::rigs::{Frame, KINDS, Rig, controls};
use crate::{closest, point};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use wirework_core::{Bounded, Closest, Curve, Domain, Wire};

/// Every wire of a rig with one feature or several or none, points where they matter, masks for all points.
pub(crate) fn add(rig: &mut Rig, frame: &Frame, random: &mut Random) {
    for wire in &mut rig.wires {
        if random.one_in(3) {
            directions(wire, random);
        }
        if random.one_in(3) {
            let width = random.pick(&[1e-3, 0.05, 0.3, 1.0, 10.0]);
            wire.closest = Closest::Blended((frame.size * width) as f32);
        }
        if random.one_in(2) {
            wire.domains = domains(wire, frame, random);
            rig.points.extend(wire.domains.iter().flat_map(|domain| edges(wire, domain, frame, random)));
        }
    }
    let count = rig.points.len();
    let mut mask = |_: &Wire| {
        let mut values = || (0..count).map(|_| value(random)).collect();
        let values: Vec<f32> = values();
        random.one_in(4).then_some(values)
    };
    rig.masks = rig.wires.iter().map(&mut mask).collect();
}

fn value(random: &mut Random) -> f32 {
    let anything = random.range(0.0, 1.0) as f32;
    random.pick(&[0.0, 0.5, 1.0, anything, anything])
}

/// A direction of the wire's own, or of some of its locators, or both.
fn directions(wire: &mut Wire, random: &mut Random) {
    let axes = [DVec3::X, DVec3::NEG_Y, DVec3::Z * 1e-3];
    let axis = |random: &mut Random| {
        let anything = DVec3::from_array(random.vector(3.0));
        random.pick(&[axes[0], axes[1], axes[2], anything, anything]).as_vec3().to_array()
    };
    let angle = |random: &mut Random| random.pick(&[0.3, 1.0, FRAC_PI_2, PI, 4.0]) as f32;
    wire.angle = angle(random);
    wire.direction = (!random.one_in(4)).then(|| axis(random));
    for locator in &mut wire.locators {
        locator.direction = random.one_in(2).then(|| axis(random));
        locator.angle = random.one_in(2).then(|| angle(random));
    }
}

/// One to three domains of the influence, of an attribute, or of several things.
fn domains(wire: &Wire, frame: &Frame, random: &mut Random) -> Vec<Domain> {
    let all = [Bounded::Influence, Bounded::Scale, Bounded::Rotation, Bounded::Amplitude, Bounded::Twist];
    let first = random.pick(&[all[0], all[0], all[0], all[1], all[2], all[3], all[4]]);
    let mut domains = Vec::new();
    for bounds in all {
        if bounds == first || random.one_in(6) {
            let count = random.pick(&[1, 1, 2, 3]);
            domains.extend((0..count).map(|_| Domain {
                curve: curve(wire, frame, random),
                delta: random.pick(&[0.0, 0.0, 0.2, 0.5, 0.9, 0.01]),
                exponent: random.pick(&[1.0, 1.0, 0.0, 2.0, 30.0, -1.0, -2.5]),
                bounds,
            }));
        }
    }
    random.shuffle(&mut domains);
    domains
}

/// Beside the reference, or anywhere.
fn curve(wire: &Wire, frame: &Frame, random: &mut Random) -> Curve {
    let shift = DVec3::from_array(random.vector(0.8));
    if random.one_in(2) {
        let rest = wire.reference.points();
        let moved = rest.iter().map(|&p| (crate::wide(p) + frame.size * shift).as_vec3().to_array());
        return wire.reference.posed(moved.collect()).expect("as many points");
    }
    let (kind, closed) = (random.pick(&KINDS), random.one_in(3));
    let size = random.pick(&[0.6, 1.5]);
    let points = controls(random, kind, closed, true);
    let points = points.iter().map(|&p| frame.place(p * size + 0.3 * shift)).collect();
    Curve::new(kind, closed, points).expect("as many points as the kind needs")
}

/// Points on a domain curve, at its radius, and to both sides of where it begins to act.
fn edges(wire: &Wire, domain: &Domain, frame: &Frame, random: &mut Random) -> Vec<[f32; 3]> {
    let mut points = Vec::new();
    for _ in 0..4 {
        let d = DVec3::from_array(point(&domain.curve, random.pick(&[0.0, 0.4, 1.0])));
        let on = DVec3::from_array(closest(&wire.reference, d.to_array()).point);
        let aside = (d - on).cross(DVec3::from_array(random.vector(1.0))).normalize_or_zero();
        let reach = f64::from(wire.radius) * random.range(0.1, 0.9);
        points.push(d);
        points.push(on + (d - on) * random.pick(&[0.5, 1.0 - 1e-6, 1.0 + 1e-6]));
        points.push(on + aside * reach);
        points.push(on + aside * reach + (d - on) * random.pick(&[1e-4, -1e-4, 0.3]));
        points.push(on + DVec3::from_array(random.vector(0.5)) * frame.size);
    }
    points.iter().map(|p| p.as_vec3().to_array()).collect()
}
