//! Blended feet: shares against the formula on curves whose feet are known, and no step where a foot comes or goes.

use glam::DVec3;
use wirework_core::{Closest, Curve, CurveKind, Wire};
use wirework_reference::{Random, closest, displacement, feet, influence};

fn shares(curve: &Curve, width: f32, p: [f64; 3]) -> Vec<(f64, f64)> {
    feet(curve, Closest::Blended(width), p).into_iter().map(|(foot, share)| (foot.u, share)).collect()
}

fn polyline(points: &[[f32; 3]]) -> Curve {
    Curve::polyline(points.to_vec()).unwrap()
}

/// Of two feet `x` widths apart, the share of the farther, ridges left aside.
fn lesser(x: f64) -> f64 {
    let t = 0.5 * (1.0 - x);
    t * t * (3.0 - 2.0 * t)
}

/// What a valley weighs alone under water of depth `s`, in widths.
fn alone(s: f64) -> f64 {
    let q = lesser(1.0 - s.clamp(0.0, 1.0));
    q / (1.0 - q)
}

/// Two parallel legs, 2 apart, joined at `x = 0`; far from the joint.
fn legs() -> Curve {
    polyline(&[[9.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [9.0, -1.0, 0.0]])
}

#[test]
fn two_feet_share_by_their_distances_where_a_ridge_parts_them() {
    let legs = legs();
    for (y, width) in [(0.0, 0.5), (0.1, 0.5), (-0.1, 0.5), (0.2, 0.5), (0.3, 0.5), (-0.4, 1.0)] {
        let found = shares(&legs, width, [6.0, y, 0.0]);
        let far = 2.0 * y.abs() / f64::from(width);
        if far >= 1.0 {
            assert_eq!(found.len(), 1, "{y} of {width}");
            continue;
        }
        let nearer = usize::from(y < 0.0);
        assert!((found[nearer].1 - (1.0 - lesser(far))).abs() < 1e-12, "{y} of {width}: {found:?}");
        assert!((found[1 - nearer].1 - lesser(far)).abs() < 1e-12);
    }
}

#[test]
fn a_foot_near_its_ridge_counts_less() {
    // The legs of a corner: feet 4/5 along, the corner the ridge between them. P is y off the middle, d = the distance.
    let corner = polyline(&[[4.0, 3.0, 0.0], [0.0; 3], [4.0, -3.0, 0.0]]);
    let (x, y) = (1.0, 0.05);
    let (near, far) = (0.6 * x - 0.8 * y, 0.6 * x + 0.8 * y);
    let pass = f64::hypot(x, y);
    let width = 2.0;
    // They meet below the top, and share by what they weigh there.
    let (a, b) = (alone((pass - near) / width), alone((pass - far) / width));
    let found = shares(&corner, 2.0, [x, y, 0.0]);
    assert!((found[1].1 - b / (a + b)).abs() < 1e-12, "{found:?}");
    assert!((found[0].0 - 0.5 * (1.0 - (0.8 * x + 0.6 * y) / 5.0)).abs() < 1e-12);
}

#[test]
fn round_a_closed_curve_the_lower_pass_counts() {
    // A rectangle; P below the middle of its width: the ends' ridges are corners, the left ones nearer to P.
    let corners = vec![[0.0; 3], [8.0, 0.0, 0.0], [8.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let closed = Curve::new(CurveKind::Polyline, true, corners).unwrap();
    let (x, y, width) = (1.5, 0.8, 1.0_f64);
    let found = shares(&closed, width as f32, [x, y, 0.0]);
    // Feet: below at 0.8, above at 1.2, left at 1.5; passes at the corners: 1.7 (left, below) and hypot(1.5, 1.2).
    let (below, left, above) = (0.8, 1.5, 1.2);
    let (low, high) = (f64::hypot(x, y), f64::hypot(x, 2.0 - y));
    assert!(low < below + width && high > below + width);
    // Left and below meet round the start; above stays a pool of its own.
    let (part_below, part_left) = (alone(low - below), alone(low - left));
    let x = below + width - low;
    let pool = 1.0 + part_left * (1.0 - x * x * (3.0 - 2.0 * x));
    let weight_above = alone(below + width - above);
    let sum = pool + weight_above;
    let of_pool = pool / (part_below + part_left) / sum;
    let expected = [part_below * of_pool, weight_above / sum, part_left * of_pool];
    assert_eq!(found.len(), 3);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found.1 - expected).abs() < 1e-12, "{found:?}, not {expected}");
    }
}

#[test]
fn coincident_control_points_and_points_are_one_foot() {
    let doubled = polyline(&[[-1.0, 1.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3], [1.0, 1.0, 0.0]]);
    assert_eq!(shares(&doubled, 0.5, [0.0, -1.0, 0.0]), [(0.25, 1.0)]);
    let point = polyline(&[[1.0, 2.0, 3.0]; 3]);
    assert_eq!(shares(&point, 0.5, [0.0; 3]), [(0.0, 1.0)]);
    let circle = (0..4_u8)
        .map(|i| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]][usize::from(i)]);
    let closed = Curve::new(CurveKind::BSpline { degree: 3 }, true, circle.collect()).unwrap();
    let sum: f64 = shares(&closed, 0.5, [0.0; 3]).iter().map(|s| s.1).sum();
    assert!((sum - 1.0).abs() < 1e-12);
}

#[test]
fn feet_that_do_not_reach_dilute() {
    let mut wire = Wire { radius: 1.05, closest: Closest::Blended(1.0), ..Wire::new(legs()) };
    wire.pose.iter_mut().for_each(|p| p[2] = 1.0);
    let p = [6.0, 0.1, 0.0];
    let f = |d: f64| (1.0 - (d / f64::from(1.05_f32)).powi(2)).powi(2);
    let expected = (1.0 - lesser(0.2)) * f(0.9);
    assert!((influence(&wire, p) - expected).abs() < 1e-12);
    assert!((displacement(&wire, p)[2] - expected).abs() < 1e-12);
    // Away from the middle both ways of choosing agree.
    let smallest = Wire { closest: Closest::Smallest, ..wire.clone() };
    assert_eq!(displacement(&wire, [6.0, 0.55, 0.2]), displacement(&smallest, [6.0, 0.55, 0.2]));
}

/// The mean of the feet by their shares, which steps wherever a share does; and how many feet there are.
fn moment(curve: &Curve, width: f32, p: DVec3) -> (DVec3, usize) {
    let feet = feet(curve, Closest::Blended(width), p.to_array());
    (feet.iter().map(|(foot, share)| DVec3::from_array(foot.point) * *share).sum(), feet.len())
}

/// The step at the worst place of a line, found by halving the interval with the larger difference.
fn step(curve: &Curve, width: f32, mut ends: [DVec3; 2]) -> f64 {
    let mut values = ends.map(|p| moment(curve, width, p).0);
    for _ in 0..30 {
        let middle = 0.5 * (ends[0] + ends[1]);
        let value = moment(curve, width, middle).0;
        let later = values[1].distance(value) > values[0].distance(value);
        let replaced = usize::from(!later);
        (ends[replaced], values[replaced]) = (middle, value);
    }
    values[0].distance(values[1])
}

#[test]
fn no_weight_steps_with_three_feet_and_more() {
    const SAMPLES: usize = 120;
    let cases = std::env::var("WIREWORK_LINES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let mut random = Random::new(8);
    let (mut worst, mut many, mut jumps) = (0.0_f64, 0, 0);
    for case in 0..cases {
        let kind = random.pick(&[
            CurveKind::BSpline { degree: 3 },
            CurveKind::CatmullRom,
            CurveKind::Polyline,
            CurveKind::BSpline { degree: 2 },
        ]);
        let closed = random.one_in(2);
        // Nearly in a plane, so that points lie among many feet.
        let points = (0..7).map(|_| random.vector(1.0)).map(|[x, y, z]| [x as f32, y as f32, 0.1 * z as f32]);
        let curve = Curve::new(kind, closed, points.collect()).unwrap();
        let width = random.pick(&[0.2, 0.6, 2.0]) as f32;
        let ends = [0; 2].map(|_| DVec3::from_array(random.vector(1.0)) * DVec3::new(1.0, 1.0, 0.0));
        let at = |i: usize| ends[0].lerp(ends[1], i as f64 / SAMPLES as f64);
        let found: Vec<(DVec3, usize)> = (0..=SAMPLES).map(|i| moment(&curve, width, at(i))).collect();
        many += usize::from(found.iter().any(|f| f.1 > 2));
        for i in (0..SAMPLES).filter(|&i| found[i].0.distance(found[i + 1].0) > 0.02) {
            let step = step(&curve, width, [at(i), at(i + 1)]);
            assert!(step < 1e-4, "case {case}: a step of {step} near {}: {curve:?}, width {width}", at(i));
            worst = worst.max(step);
        }
        let nearest = |i: usize| DVec3::from_array(closest(&curve, at(i).to_array()).point);
        jumps += usize::from((0..SAMPLES).any(|i| nearest(i).distance(nearest(i + 1)) > 0.2));
    }
    println!("worst {worst:e}");
    assert!(
        many * 2 > cases && jumps * 2 > cases,
        "{many} lines with three feet, {jumps} with a jump of the nearest"
    );
}
