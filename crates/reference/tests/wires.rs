//! One wire and many against closed forms.

use std::f64::consts::{FRAC_PI_2, PI};
use wirework_core::{Bend, Blend, Correspondence, Curve, CurveKind, Density, Interpolation, Locator, Wire};
use wirework_reference::{deform, displacement, influence, unsteadiness};

fn near(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() <= tolerance)
}

fn line(from: [f32; 3], to: [f32; 3]) -> Curve {
    Curve::polyline(vec![from, to]).unwrap()
}

/// From the origin along x, length 4, radius 2.
fn straight() -> Wire {
    Wire { radius: 2.0, ..Wire::new(line([0.0; 3], [4.0, 0.0, 0.0])) }
}

#[test]
fn a_translated_wire_carries_by_influence() {
    let mut wire = straight();
    wire.pose = vec![[0.0, 0.0, 3.0], [4.0, 0.0, 3.0]];
    // f(1/2) = (1 − 1/4)² = 9/16.
    assert_eq!(influence(&wire, [1.0, 1.0, 0.0]), 0.5625);
    assert!(near(displacement(&wire, [1.0, 1.0, 0.0]), [0.0, 0.0, 3.0 * 0.5625], 1e-14));
    wire.amplitude = -0.5;
    assert!(near(displacement(&wire, [1.0, 1.0, 0.0]), [0.0, 0.0, -1.5 * 0.5625], 1e-14));
    assert_eq!(displacement(&wire, [1.0, 2.0, 0.0]), [0.0; 3], "at exactly r");
}

#[test]
fn densities_are_theirs() {
    let mut wire = straight();
    for (density, at_half) in [
        (Density::Quartic, 0.5625),
        (Density::Sextic, 0.421_875),
        (Density::Smoothstep, 0.5),
        (Density::Linear, 0.5),
        (Density::Fold(1.0), 0.25),
    ] {
        wire.density = density;
        assert_eq!(influence(&wire, [1.0, 1.0, 0.0]), at_half);
    }
}

#[test]
fn scale_moves_away_from_the_wire_and_twist_about_it() {
    let mut wire = Wire { scale: 3.0, ..straight() };
    assert!(near(displacement(&wire, [1.0, 1.0, 0.0]), [0.0, 2.0 * 0.5625, 0.0], 1e-14));
    wire.scale = 1.0;
    wire.twist = (FRAC_PI_2 / 0.5625) as f32;
    assert!(near(displacement(&wire, [1.0, 1.0, 0.0]), [0.0, -1.0, 1.0], 1e-6));
}

#[test]
fn a_bend_turns_by_its_angle_times_influence_and_rotation() {
    // W leaves R's start upwards: a quarter turn about z, by F = 9/16.
    let mut wire = straight();
    wire.pose = vec![[0.0; 3], [0.0, 4.0, 0.0]];
    let angle = FRAC_PI_2 * 0.5625;
    let (sin, cos) = angle.sin_cos();
    assert!(near(displacement(&wire, [0.0, 1.0, 0.0]), [-sin, cos - 1.0, 0.0], 1e-12));
    wire.rotation = 0.0;
    assert!(near(displacement(&wire, [0.0, 1.0, 0.0]), [0.0; 3], 1e-15));
}

#[test]
fn antiparallel_tangents_turn_about_the_documented_axis() {
    let mut wire = straight();
    wire.pose = vec![[0.0; 3], [-4.0, 0.0, 0.0]];
    // X × Y = Z, half a turn times 9/16.
    let (sin, cos) = (PI * 0.5625).sin_cos();
    assert!(near(displacement(&wire, [0.0, 1.0, 0.0]), [-sin, cos - 1.0, 0.0], 1e-12));
    wire.bend = Bend::Transport;
    assert!(near(displacement(&wire, [0.0, 1.0, 0.0]), [-sin, cos - 1.0, 0.0], 1e-12));
}

#[test]
fn locators_override_and_interpolate() {
    let mut wire = straight();
    wire.pose = vec![[0.0, 0.0, 1.0], [4.0, 0.0, 1.0]];
    wire.locators = vec![
        Locator { u: 0.25, amplitude: Some(1.0), ..Locator::default() },
        Locator { u: 0.5, radius: Some(4.0), ..Locator::default() },
        Locator { u: 0.75, amplitude: Some(3.0), ..Locator::default() },
    ];
    let height = |wire: &Wire, x: f64| displacement(wire, [x, 0.0, 0.0])[2];
    for (x, amplitude) in [(0.0, 1.0), (1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (3.5, 3.0)] {
        assert!((height(&wire, x) - amplitude).abs() < 1e-12);
    }
    assert_eq!(influence(&wire, [0.0, 2.0, 0.0]), 0.5625, "the one radius holds everywhere");
    wire.interpolation = Interpolation::Smooth;
    assert!((height(&wire, 1.5) - (1.0 + 2.0 * 0.156_25)).abs() < 1e-12);
}

#[test]
fn locators_wrap_round_a_closed_curve() {
    let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut wire = Wire::new(Curve::new(CurveKind::Polyline, true, square).unwrap());
    wire.radius = 0.5;
    wire.pose.iter_mut().for_each(|p| p[2] = 1.0);
    wire.locators = vec![
        Locator { u: 0.25, amplitude: Some(2.0), ..Locator::default() },
        Locator { u: 0.75, amplitude: Some(4.0), ..Locator::default() },
    ];
    // u = 1/8 lies a quarter of the way from 0.25 back to 0.75.
    assert!((displacement(&wire, [0.5, 0.0, 0.0])[2] - 2.5).abs() < 1e-12);
}

#[test]
fn by_arc_length_the_fraction_of_the_way_decides() {
    let mut wire = Wire::new(Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]).unwrap());
    wire.pose = vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    assert!(near(displacement(&wire, [0.5, 0.0, 0.0]), [1.0, 0.0, 0.0], 1e-12));
    wire.correspondence = Correspondence::ArcLength;
    assert!(near(displacement(&wire, [0.5, 0.0, 0.0]), [0.0; 3], 1e-12));
    wire.pose = vec![[0.0, 1.0, 0.0]; 3];
    assert!(near(displacement(&wire, [0.5, 0.0, 0.0]), [-0.5, 1.0, 0.0], 1e-12), "W a point");
}

#[test]
fn transport_of_a_planar_bend_is_the_angle_in_the_plane_past_half_a_turn() {
    // W winds 1.4 turns over R's length; Tangent sees at most half of one.
    let n = 57;
    let reference: Vec<[f32; 3]> = (0..n).map(|i| [i as f32 * 0.25, 0.0, 0.0]).collect();
    let pose: Vec<[f32; 3]> = (0..n)
        .map(|i| {
            let angle = 2.8 * PI * f64::from(i) / f64::from(n - 1);
            [(2.0 * angle.sin()) as f32, (2.0 - 2.0 * angle.cos()) as f32, 0.0]
        })
        .collect();
    let mut wire =
        Wire { radius: 1.0, bend: Bend::Transport, ..Wire::new(Curve::bspline(3, reference).unwrap()) };
    wire.pose = pose;
    for (x, y) in [(4.0_f32, 0.25_f32), (9.0, 0.5), (11.5, 0.5)] {
        let foot = wirework_reference::closest(&wire.reference, [x.into(), 0.0, 0.0]);
        let posed = wire.reference.posed(wire.pose.clone()).unwrap();
        let tangent = wirework_reference::tangent(&posed, foot.u);
        // The angle of the tangent, unwound.
        let turns = foot.u * 1.4;
        let raw = tangent[1].atan2(tangent[0]);
        let angle = raw + 2.0 * PI * ((turns * 2.0 * PI - raw) / (2.0 * PI)).round();
        let f = influence(&wire, [x.into(), y.into(), 0.0]);
        let on = wirework_reference::point(&posed, foot.u);
        let (sin, cos) = (angle * f).sin_cos();
        let y = f64::from(y);
        let expected = [-y * sin + (on[0] - f64::from(x)) * f, y * (cos - 1.0) + on[1] * f, 0.0];
        let found = displacement(&wire, [x.into(), y, 0.0]);
        assert!(near(found, expected, 1e-6), "at {x}: {found:?}, not {expected:?}");
    }
}

#[test]
fn at_a_corner_transport_has_turned_by_half() {
    let mut wire = straight();
    wire.reference = Curve::polyline(vec![[0.0; 3], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]]).unwrap();
    wire.pose = vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]];
    for bend in [Bend::Tangent, Bend::Transport] {
        wire.bend = bend;
        let (sin, cos) = (0.5 * FRAC_PI_2 * 0.5625).sin_cos();
        assert!(near(displacement(&wire, [2.0, 1.0, 0.0]), [-sin, cos - 1.0, 0.0], 1e-12), "{bend:?}");
    }
}

#[test]
fn transport_along_a_helix_keeps_the_frame_from_turning() {
    // R straight, W a helix of pitch angle α: along it the minimising frame turns against the Frenet frame by the
    // torsion, sin α · (turned angle); the rotation from the start is known in closed form.
    let (n, turned, radius, rise): (usize, f64, f64, f64) = (40, 0.8 * PI, 1.0, 0.5);
    // Cubic Hermite pieces, so that the tangents at the joints are the helix's.
    let reference: Vec<[f32; 3]> = (0..=3 * n).map(|i| [(4 * i) as f32 / (3 * n) as f32, 0.0, 0.0]).collect();
    let step = turned / n as f64;
    let pose: Vec<[f32; 3]> = (0..=3 * n)
        .map(|i| {
            let joint = (i + 1) / 3;
            let (sin, cos) = (step * joint as f64).sin_cos();
            let along = step / 3.0 * (i as f64 - 3.0 * joint as f64);
            let x = rise * (step * joint as f64 + along);
            [x, radius * (cos - sin * along), radius * (sin + cos * along)].map(|c| c as f32)
        })
        .collect();
    let reference = Curve::new(CurveKind::Bezier, false, reference).unwrap();
    let mut wire = Wire { radius: 1.0, bend: Bend::Transport, ..Wire::new(reference) };
    wire.pose = pose;
    let speed = (radius * radius + rise * rise).sqrt();
    let frame = |a: f64| {
        let (sin, cos) = a.sin_cos();
        let t = [rise / speed, -radius * sin / speed, radius * cos / speed];
        let n = [0.0, -cos, -sin];
        let b = [t[1] * n[2] - t[2] * n[1], t[2] * n[0] - t[0] * n[2], t[0] * n[1] - t[1] * n[0]];
        // Minimising: turned back by ∫ torsion ds = rise / speed · a.
        let (s, c) = (-rise / speed * a).sin_cos();
        let m = [0, 1, 2].map(|i| c * n[i] + s * b[i]);
        let k = [0, 1, 2].map(|i| c * b[i] - s * n[i]);
        [t, m, k].map(glam::DVec3::from_array)
    };
    let matrix = |f: [glam::DVec3; 3]| glam::DMat3::from_cols(f[0], f[1], f[2]);
    let first = frame(0.0);
    let least = wirework_reference::least_rotation([1.0, 0.0, 0.0], first[0].to_array());
    let start = glam::DQuat::from_scaled_axis(glam::DVec3::from_array(least));
    for u in [0.25, 0.5, 0.9] {
        let bend = matrix(frame(turned * u)) * matrix(first).transpose() * glam::DMat3::from_quat(start);
        let (axis, angle) = glam::DQuat::from_mat3(&bend).to_axis_angle();
        let p = glam::DVec3::new(4.0 * u, 0.3, 0.0);
        let f = influence(&wire, p.to_array());
        let v = glam::DVec3::new(0.0, 0.3, 0.0);
        let posed = wire.reference.posed(wire.pose.clone()).unwrap();
        let on = glam::DVec3::from_array(wirework_reference::point(&posed, u));
        let expected = glam::DQuat::from_axis_angle(axis, angle * f) * v - v + (on - (p - v)) * f;
        let found = displacement(&wire, p.to_array());
        assert!(near(found, expected.to_array(), 1e-5), "at {u}: {found:?}, not {expected}");
    }
}

/// Two straight wires across the origin, raised by `a` and `b`.
fn crossing(a: f32, b: f32) -> Vec<Wire> {
    let raised = |from, to, height: f32| {
        let mut wire = Wire { radius: 2.0, ..Wire::new(line(from, to)) };
        wire.pose.iter_mut().for_each(|p| p[2] += height);
        wire
    };
    vec![raised([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], a), raised([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], b)]
}

fn height(wires: &[Wire], blend: Blend, p: [f32; 3]) -> f64 {
    deform(wires, &blend, &[p])[0][2] - f64::from(p[2])
}

#[test]
fn the_blend_is_the_weighted_mean() {
    let m = |exponent| Blend { exponent, ..Blend::default() };
    let wires = crossing(1.0, 3.0);
    for (exponent, expected) in [(0.0, 2.0), (1.0, 2.5), (-1.0, 1.5), (2.0, 2.8), (80.0, 3.0), (-80.0, 1.0)] {
        assert!((height(&wires, m(exponent), [0.0; 3]) - expected).abs() < 1e-12, "m = {exponent}");
    }
    let half = Blend { crossing: 0.5, ..Blend::default() };
    assert!((height(&wires, half, [0.0; 3]) - 3.25).abs() < 1e-12);
    let mut mixed = wires.clone();
    mixed[0].exponent = Some(0.0);
    // Weights 1 and (3/3)¹.
    assert!((height(&mixed, m(1.0), [0.0; 3]) - 2.0).abs() < 1e-12);
    mixed[1].exponent = Some(0.0);
    mixed[0].exponent = Some(1.0);
    // Weights 1/3 and 1.
    assert!((height(&mixed, m(5.0), [0.0; 3]) - 2.5).abs() < 1e-12);
}

#[test]
fn a_wire_that_moves_nothing_is_left_out_of_the_blend_and_anchors_locally() {
    let wires = crossing(1.0, 0.0);
    for exponent in [-3.0, 0.0, 1.0] {
        assert_eq!(height(&wires, Blend { exponent, ..Blend::default() }, [0.0; 3]), 1.0);
    }
    let local = Blend { localize: 1.0, ..Blend::default() };
    assert!((height(&wires, local, [0.0; 3]) - 0.5).abs() < 1e-12);
    // At (1, 0, 0) the second wire is 1 off: F = 9/16 against 1.
    assert!((height(&wires, local, [1.0, 0.0, 0.0]) - 1.0 / 1.5625).abs() < 1e-12);
    let squared = Blend { locality: 2.0, ..local };
    assert!((height(&wires, squared, [1.0, 0.0, 0.0]) - 1.0 / (1.0 + 0.5625 * 0.5625)).abs() < 1e-12);
}

#[test]
fn of_a_group_the_nearest_acts_whatever_its_radius() {
    let mut wires = crossing(1.0, 3.0);
    for wire in &mut wires {
        wire.group = Some(7);
    }
    wires[1].radius = 0.001;
    let raised = |p| height(&wires, Blend::default(), p);
    assert_eq!(raised([0.5, 0.0, 0.0]), 1.0);
    assert_eq!(raised([0.0, 0.5, 0.0]), 3.0);
    assert_eq!(raised([0.1, 0.5, 0.0]), 0.0, "the nearest does not reach");
    assert_eq!(raised([0.0; 3]), 1.0, "on a tie the first");
}

#[test]
fn untouched_points_come_back_as_they_are() {
    let points = [[9.0, 9.0, 9.0], [-0.0, 3.5, 0.0], [f32::NAN, 0.0, 0.0]];
    let found = deform(&crossing(1.0, 3.0), &Blend::default(), &points);
    for (p, q) in points.iter().zip(found) {
        assert_eq!(p.map(|c| f64::from(c).to_bits()), q.map(f64::to_bits));
    }
    assert_eq!(deform(&[], &Blend::default(), &[[1.0; 3]]), vec![[1.0; 3]]);
    assert!(deform(&crossing(1.0, 3.0), &Blend::default(), &[]).is_empty());
    assert_eq!(height(&crossing(0.0, 0.0), Blend::default(), [0.3, 0.1, 0.0]), 0.0, "rest");
}

#[test]
fn steps_are_unsteady_and_slopes_are_not() {
    let bend = |p| {
        let mut wire = straight();
        wire.reference = Curve::polyline(vec![[-1.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0]]).unwrap();
        wire.pose = vec![[-1.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 2.0]];
        unsteadiness(&[wire], &Blend::default(), p, 1e-6)
    };
    assert!(bend([0.0, 0.8, 0.0]) > 0.01, "the middle of the fork");
    assert!(bend([0.4, 0.8, 0.0]) < 1e-4);
}
