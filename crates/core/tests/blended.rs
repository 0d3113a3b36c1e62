//! `closest: Blended` against `Smallest` inside hairpins: \[SF98\] §6 leaves the step across the medial axis open.
//!
//! The legs of a hairpin `b` off the middle come apart, one up and one down, so that the deformation steps where the foot
//! changes legs. Shares of two feet on opposite sides change at most by 1.5 / width a unit (`q′ = 6t(1 − t)`, the distances
//! differ by two units a unit): for `width = 0.2·b`, `b = 0.25`, by 0.03 in a thousandth. The rest of a twentieth is for
//! what the deformation changes anyway.

use std::f32::consts::PI;
use wirework_core::{Binding, Blend, Closest, Curve, CurveKind, Wire};
use wirework_reference::{feet, point};

fn deform(wire: &Wire, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; points.len()];
    let wires = std::slice::from_ref(wire);
    Binding::new(wires, points).unwrap().deform_into(wires, &Blend::default(), &mut out).unwrap();
    out
}

/// How the legs are joined.
const BENDS: [Bend; 5] = [Bend::Spline, Bend::Rounded, Bend::Square, Bend::Fork, Bend::Ring];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bend {
    /// A cubic B-spline.
    Spline,
    /// Catmull-Rom through a half circle.
    Rounded,
    /// A polyline with two corners.
    Square,
    /// A polyline with one: the legs leave it at an angle.
    Fork,
    /// A closed B-spline: a bend at both ends.
    Ring,
}

/// Legs along x at `±b`, joined about the origin; the upper one lifted and turned, the lower one sunk.
fn hairpin(bend: Bend, b: f32) -> Wire {
    let leg = [3.5, 2.5, 1.5, 0.5].map(|x| [x, b, 0.0]);
    let half = (1..8_u8).map(|i| PI * f32::from(i) / 8.0).map(|a| [-b * a.sin(), b * a.cos(), 0.0]);
    let upper = match bend {
        Bend::Spline | Bend::Square => [&leg[..], &[[-b, b, 0.0]]].concat(),
        Bend::Rounded => [&leg[..], &[[0.0, b, 0.0]]].concat(),
        Bend::Fork => vec![[3.5, 2.0 * b, 0.0], [1.0, b, 0.0]],
        Bend::Ring => [&[[4.5, b, 0.0]], &leg[..], &[[-b, b, 0.0]]].concat(),
    };
    let between: Vec<[f32; 3]> = match bend {
        Bend::Rounded => half.collect(),
        Bend::Fork => vec![[-1.5, 0.0, 0.0]],
        _ => Vec::new(),
    };
    let lower = upper.iter().rev().map(|p| [p[0], -p[1], 0.0]);
    let points: Vec<[f32; 3]> = upper.iter().copied().chain(between).chain(lower).collect();
    let kind = match bend {
        Bend::Spline | Bend::Ring => CurveKind::BSpline { degree: 3 },
        Bend::Rounded => CurveKind::CatmullRom,
        Bend::Square | Bend::Fork => CurveKind::Polyline,
    };
    let mut wire = Wire::new(Curve::new(kind, bend == Bend::Ring, points).unwrap());
    wire.radius = 3.0 * b;
    for p in &mut wire.pose {
        let rise = if p[1] > 0.0 { 0.3 + 0.1 * p[0] } else { -0.2 };
        p[2] = if p[1] == 0.0 { 0.0 } else { rise };
    }
    wire
}

/// Samples 1e-3 apart across the middle, from leg to leg, straight and slanted, in the plane and off it; clear of the bends
/// and so of the evolute's cusps.
fn lines(b: f32) -> Vec<Vec<[f32; 3]>> {
    let mut lines = Vec::new();
    for x in [1.4_f32, 1.9, 2.45] {
        for (slant, z) in [(0.0, 0.0), (0.5, 0.0), (-0.3, 0.4 * b), (1.0, -0.7 * b)] {
            let count = (1.8 * b / 1e-3) as u16;
            let (way, steps) = (f32::hypot(1.0, slant), f32::from(count));
            let at = |i: u16| (f32::from(i) - 0.5 * steps) * 1e-3;
            lines.push((0..=count).map(|i| [x + at(i) * slant / way, at(i) / way, z]).collect());
        }
    }
    lines
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt()
}

fn displacement(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| q[i] - p[i])
}

/// The largest difference of the displacements of neighbours.
fn jump(line: &[[f32; 3]], moved: &[[f32; 3]]) -> f32 {
    let displacements: Vec<[f32; 3]> = line.iter().zip(moved).map(|(p, q)| displacement(*p, *q)).collect();
    displacements.windows(2).map(|w| apart(w[0], w[1])).fold(0.0, f32::max)
}

#[test]
fn jumps_across_the_medial_axis_fall_twentyfold() {
    for bend in BENDS {
        for b in [0.25_f32, 0.35, 0.5] {
            let smallest = hairpin(bend, b);
            for line in lines(b) {
                let before = jump(&line, &deform(&smallest, &line));
                assert!(before > 0.1, "{bend:?} {b}: the line from {:?} crosses nothing", line[0]);
                for share in [0.2, 0.5, 1.0, 4.0] {
                    let blended = Wire { closest: Closest::Blended(share * b), ..smallest.clone() };
                    let after = jump(&line, &deform(&blended, &line));
                    assert!(
                        after <= before / 20.0,
                        "{bend:?} {b}, width {share} b: {after} after {before}, from {:?}",
                        line[0]
                    );
                }
            }
        }
    }
}

#[test]
fn a_dent_in_a_leg_does_not_count_it_twice() {
    // Two feet of one leg, on both sides of the dent, weigh no more than the leg did.
    for dent in [0.0005_f32, 0.002, 0.02] {
        let upper = [[2.0, 0.5, 0.0], [1.0, 0.5 + dent, 0.0], [0.0, 0.5, 0.0]];
        let points: Vec<[f32; 3]> = upper.into_iter().chain([[0.0, -0.5, 0.0], [2.0, -0.5, 0.0]]).collect();
        let mut wire = Wire { radius: 2.0, rotation: 0.0, ..Wire::new(Curve::polyline(points).unwrap()) };
        for p in &mut wire.pose {
            p[2] = 0.4 * p[1].signum();
        }
        let blended = Wire { closest: Closest::Blended(0.2), ..wire.clone() };
        let along: Vec<[f32; 3]> = (0..800_u16).map(|i| [0.6 + 1e-3 * f32::from(i), 0.02, 0.0]).collect();
        let across: Vec<[f32; 3]> = (0..600_u16).map(|i| [1.0, 1e-3 * f32::from(i) - 0.3, 0.0]).collect();
        let before = jump(&across, &deform(&wire, &across));
        for line in [along, across] {
            let after = jump(&line, &deform(&blended, &line));
            assert!(after <= before / 20.0, "dent {dent}: {after} after {before}");
        }
    }
}

#[test]
fn away_from_the_medial_axis_both_agree() {
    let (mut agreed, mut differed) = (0, 0);
    for bend in BENDS {
        let b = 0.35;
        let smallest = hairpin(bend, b);
        let width = 0.6 * b;
        let blended = Wire { closest: Closest::Blended(width), ..smallest.clone() };
        // Inside and outside of the bend.
        let line: Vec<[f32; 3]> = lines(b)
            .into_iter()
            .flatten()
            .step_by(29)
            .chain((0..200_u8).map(|i| [-1.6 + 0.01 * f32::from(i), 0.2 - 0.002 * f32::from(i), 0.1]))
            .collect();
        // By sampling: one unbroken stretch of the curve is nearer than the least distance and the width.
        let samples: Vec<[f64; 3]> =
            (0..=1200).map(|i| point(&smallest.reference, f64::from(i) / 1200.0)).collect();
        let alone = |p: [f32; 3]| {
            let away = |q: &[f64; 3]| (0..3).map(|i| (q[i] - f64::from(p[i])).powi(2)).sum::<f64>().sqrt();
            let distances: Vec<f64> = samples.iter().map(away).collect();
            let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
            // A little wider, for points at the very end of the width.
            let near: Vec<bool> = distances.iter().map(|d| *d < least + 1.01 * f64::from(width)).collect();
            let starts = near.windows(2).filter(|w| !w[0] && w[1]).count() + usize::from(near[0]);
            let ring = smallest.reference.closed() && near[0] && near[near.len() - 1];
            starts - usize::from(ring && starts > 1) == 1
        };
        let found = deform(&smallest, &line).into_iter().zip(deform(&blended, &line));
        for (&p, (one, other)) in line.iter().zip(found) {
            if alone(p) && feet(&blended.reference, Closest::Blended(width), p.map(f64::from)).len() == 1 {
                assert!(apart(one, other) <= 1e-6, "{bend:?} {p:?}: {one:?} or {other:?}");
                agreed += 1;
            }
            differed += usize::from(apart(one, other) > 1e-3);
        }
    }
    assert!(agreed > 800 && differed > 100, "{agreed} agreed, {differed} differed");
}

#[test]
fn on_the_medial_axis_the_deformation_is_the_mean_of_both_sides() {
    let b = 0.25;
    let (smallest, z) = (hairpin(Bend::Square, b), 0.1);
    let blended = Wire { closest: Closest::Blended(0.2 * b), ..smallest.clone() };
    let sides = deform(&smallest, &[[2.0, 1e-6, z], [2.0, -1e-6, z]]);
    let found = deform(&blended, &[[2.0, 0.0, z]])[0];
    for i in 0..3 {
        assert!((found[i] - 0.5 * (sides[0][i] + sides[1][i])).abs() < 1e-5, "{found:?}, {sides:?}");
    }
}

#[test]
fn a_straight_wire_has_one_foot_and_keeps_its_bits() {
    let mut wire = Wire::new(Curve::polyline(vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).unwrap());
    wire.pose = vec![[-1.0, 0.0, 0.3], [1.0, 0.2, 0.0]];
    let points: Vec<[f32; 3]> =
        (0..200_u8).map(|i| [0.013 * f32::from(i) - 1.3, 0.4, 0.01 * f32::from(i) - 1.0]).collect();
    let blended = Wire { closest: Closest::Blended(0.5), ..wire.clone() };
    assert_eq!(deform(&wire, &points), deform(&blended, &points));
}

/// Curves on a coarse lattice: symmetric, with feet exactly at joints and ends, coincident control points, folds.
fn lattice_curves() -> Vec<Curve> {
    let sets: [&[[f32; 2]]; 8] = [
        &[[1.5, 0.5], [0.0, 0.5], [0.0, -0.5], [1.5, -0.5]],
        &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
        &[[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]],
        &[[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0]],
        &[[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0]],
        &[[-1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0]],
        &[[-1.0, 0.0], [1.0, 0.0], [-1.0, 0.0]],
        &[[0.5, 0.5], [0.5, 0.5], [0.5, 0.5]],
    ];
    let kinds = [
        CurveKind::Polyline,
        CurveKind::BSpline { degree: 2 },
        CurveKind::BSpline { degree: 3 },
        CurveKind::CatmullRom,
    ];
    let mut curves = Vec::new();
    for set in sets {
        let points: Vec<[f32; 3]> = set.iter().map(|p| [p[0], p[1], 0.0]).collect();
        for (kind, closed) in kinds.into_iter().flat_map(|kind| [(kind, false), (kind, true)]) {
            curves.push(Curve::new(kind, closed, points.clone()).unwrap());
        }
    }
    curves
}

#[test]
fn feet_at_joints_and_ends_count_once() {
    // At a standstill of the curve, as where three control points coincide, the parameter of a foot hangs on few bits.
    const TOLERANCE: f32 = 1e-3;
    let points: Vec<[f32; 3]> = (0..13 * 13_u8)
        .map(|i| [f32::from(i % 13) * 0.25 - 1.5, f32::from(i / 13) * 0.25 - 1.5, 0.25])
        .collect();
    let mut wrong = Vec::new();
    for curve in lattice_curves() {
        for width in [0.5, 3.0] {
            let closest = Closest::Blended(width);
            let mut wire = Wire { radius: 3.0, rotation: 0.0, closest, ..Wire::new(curve.clone()) };
            for (i, p) in wire.pose.iter_mut().enumerate() {
                p[2] += [1.0, 0.5, 2.0, -1.0, 0.3][i];
            }
            let exact = wirework_reference::deform(std::slice::from_ref(&wire), &Blend::default(), &points);
            for ((p, found), exact) in points.iter().zip(deform(&wire, &points)).zip(exact) {
                if apart(found, exact.map(|c| c as f32)) > TOLERANCE {
                    wrong.push(format!("{p:?} to {found:?}, not {exact:?}, width {width}, {curve:?}"));
                }
            }
        }
    }
    let some: Vec<&String> = wrong.iter().step_by(1 + wrong.len() / 8).collect();
    assert!(wrong.is_empty(), "{} points: {some:#?}", wrong.len());
}
