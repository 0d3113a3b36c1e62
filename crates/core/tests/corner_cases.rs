//! The corner cases of the contract, one test each.

use wirework_core::{Bend, Binding, Blend, Correspondence, Curve, CurveKind, Density, Locator, Wire};
use wirework_reference as reference;

fn deform(wires: &[Wire], points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut out = vec![[9.0; 3]; points.len()];
    Binding::new(wires, points).unwrap().deform_into(wires, &Blend::default(), &mut out).unwrap();
    out
}

/// Against the reference, to `tolerance`.
fn conforms(wires: &[Wire], points: &[[f32; 3]], tolerance: f64) {
    let exact = reference::deform(wires, &Blend::default(), points);
    for ((p, q), e) in points.iter().zip(deform(wires, points)).zip(exact) {
        let error = (0..3).map(|i| (f64::from(q[i]) - e[i]).abs()).fold(0.0, f64::max);
        assert!(error <= tolerance, "{p:?} went to {q:?}, not {e:?}, {wires:?}");
    }
}

fn polyline(points: &[[f32; 3]]) -> Curve {
    Curve::polyline(points.to_vec()).unwrap()
}

/// Points about the origin, on it and a little off it.
fn around() -> Vec<[f32; 3]> {
    let c = [-0.8_f32, -0.3, 0.0, 1e-7, 0.4, 1.0];
    let at = |i: usize| [c[i % 6], c[i / 6 % 6], c[i / 36]];
    (0..216).map(at).collect()
}

#[test]
fn a_wire_of_length_zero_translates_and_scales() {
    for kind in
        [CurveKind::BSpline { degree: 3 }, CurveKind::Polyline, CurveKind::CatmullRom, CurveKind::Bezier]
    {
        for (bend, correspondence) in
            [(Bend::Tangent, Correspondence::Parameter), (Bend::Transport, Correspondence::ArcLength)]
        {
            let reference = Curve::new(kind, false, vec![[0.1, 0.0, 0.0]; 4]).unwrap();
            let mut wire = Wire { scale: 1.5, twist: 1.0, bend, correspondence, ..Wire::new(reference) };
            wire.pose = vec![[0.1, 0.5, 0.0]; 4];
            conforms(&[wire.clone()], &around(), 1e-6);
            // Posed at length.
            wire.pose = vec![[0.1, 0.5, 0.0], [1.0, 0.5, 0.0], [1.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
            conforms(&[wire.clone()], &around(), 1e-6);
            // From length to a point.
            let reference = wire.reference.posed(wire.pose.clone()).unwrap();
            wire = Wire { reference, pose: vec![[0.1, 0.5, 0.0]; 4], ..wire };
            conforms(&[wire], &around(), 2e-6);
        }
    }
}

#[test]
fn one_control_point_is_a_point() {
    for (kind, closed) in [
        (CurveKind::BSpline { degree: 2 }, false),
        (CurveKind::BSpline { degree: 2 }, true),
        (CurveKind::Polyline, true),
        (CurveKind::CatmullRom, false),
        (CurveKind::CatmullRom, true),
        (CurveKind::Bezier, false),
    ] {
        let curve = Curve::new(kind, closed, vec![[0.0, 0.2, 0.0]]).unwrap();
        assert_eq!((curve.point(0.5), curve.tangent(0.5), curve.length()), ([0.0, 0.2, 0.0], [0.0; 3], 0.0));
        let foot = curve.closest([0.0, 3.2, 4.0]).unwrap();
        assert_eq!((foot.u, foot.distance, foot.point), (0.0, 5.0, [0.0, 0.2, 0.0]));
        let wire = Wire { pose: vec![[0.0, 0.2, 1.0]], ..Wire::new(curve) };
        conforms(&[wire], &around(), 1e-6);
    }
}

#[test]
fn a_point_on_the_curve_tracks_it_exactly() {
    let mut wire = Wire::new(polyline(&[[0.0; 3], [4.0, 0.0, 0.0]]));
    (wire.scale, wire.twist) = (3.0, 2.0);
    wire.pose = vec![[0.0, 1.0, 0.0], [0.0, 1.0, 4.0]];
    let points = [0.0, 1.0, 2.5, 4.0].map(|x| [x, 0.0, 0.0]);
    assert_eq!(deform(&[wire], &points), [0.0, 1.0, 2.5, 4.0].map(|z| [0.0, 1.0, z]));
}

#[test]
fn antiparallel_tangents_turn_about_the_documented_axis() {
    // R along x: least aligned is y, X × Y = Z. Half a turn by F = 9/16.
    let (sin, cos) = (std::f64::consts::PI * 0.5625).sin_cos();
    for bend in [Bend::Tangent, Bend::Transport] {
        let mut wire = Wire { radius: 2.0, bend, ..Wire::new(polyline(&[[0.0; 3], [4.0, 0.0, 0.0]])) };
        wire.pose = vec![[0.0; 3], [-4.0, 0.0, 0.0]];
        let [q] = deform(&[wire.clone()], &[[0.0, 1.0, 0.0]])[..] else { panic!() };
        assert!(
            (f64::from(q[0]) + sin).abs() < 1e-6 && (f64::from(q[1]) - cos).abs() < 1e-6,
            "{bend:?}: {q:?}"
        );
        conforms(&[wire], &around(), 4e-6);
        // Along every axis and an odd direction, W reversed.
        for end in [[0.0, 3.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 1.0], [-0.3, 2.0, 0.7]] {
            let mut wire = Wire { bend, ..Wire::new(polyline(&[[0.0; 3], end])) };
            wire.pose = vec![end, [0.0; 3]];
            conforms(&[wire], &around(), 1e-5);
        }
    }
}

#[test]
fn coincident_control_points_are_no_trouble() {
    let shapes: [&[[f32; 3]]; 4] = [
        &[[-1.0, 0.0, 0.0], [0.0; 3], [0.0; 3], [1.0, 0.5, 0.0]],
        &[[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        &[[0.0; 3], [0.0; 3], [0.0; 3], [1.0, 1.0, 0.0]],
        &[[-1.0, 0.0, 0.0], [0.0, 0.7, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.7, 0.0]],
    ];
    for points in shapes {
        for kind in [
            CurveKind::BSpline { degree: 3 },
            CurveKind::BSpline { degree: 2 },
            CurveKind::Polyline,
            CurveKind::CatmullRom,
            CurveKind::Bezier,
        ] {
            let curve = Curve::new(kind, false, points.to_vec()).unwrap();
            let mut wire = Wire { scale: 1.2, rotation: 0.0, ..Wire::new(curve) };
            wire.pose = points.iter().map(|p| [p[0], p[1] + 0.3, p[2] + 0.2 * p[0]]).collect();
            let points: Vec<[f32; 3]> =
                around().iter().map(|p| [p[0] + 0.013, p[1] - 0.017, p[2] + 0.05]).collect();
            conforms(&[wire.clone()], &points, 5e-6);
            // With its bend: finite, whatever the direction where the curve stands still.
            for bend in [Bend::Tangent, Bend::Transport] {
                let wire = Wire { rotation: 1.0, bend, ..wire.clone() };
                assert!(deform(&[wire], &points).iter().flatten().all(|c| c.is_finite()));
            }
        }
    }
}

#[test]
fn no_points_and_no_wires() {
    let wire = Wire::new(polyline(&[[0.0; 3], [1.0, 0.0, 0.0]]));
    assert!(deform(std::slice::from_ref(&wire), &[]).is_empty());
    assert!(deform(&[], &[]).is_empty());
    let points = [[1.0, -0.0, 3.0], [f32::MAX, f32::MIN_POSITIVE, 0.0]];
    assert_eq!(deform(&[], &points), points);
    assert_eq!(deform(&[wire], &points), points);
}

#[test]
fn points_that_are_not_finite_stay_and_do_not_disturb_others() {
    let mut wire = Wire::new(polyline(&[[0.0; 3], [1.0, 0.0, 0.0]]));
    wire.pose = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let odd = [[f32::NAN, 0.0, 0.0], [0.5, f32::INFINITY, 0.0], [0.5, 0.1, f32::NEG_INFINITY], [f32::NAN; 3]];
    let mut points: Vec<[f32; 3]> = (0..200_u8).map(|i| [f32::from(i) / 200.0, 0.2, 0.0]).collect();
    let clean = deform(std::slice::from_ref(&wire), &points);
    for (i, p) in odd.into_iter().enumerate() {
        points.insert(i * 50, p);
    }
    let mut found = deform(std::slice::from_ref(&wire), &points);
    for (i, p) in odd.into_iter().enumerate().rev() {
        let q = found.remove(i * 50);
        assert_eq!(q.map(f32::to_bits), p.map(f32::to_bits));
    }
    assert_eq!(found, clean);
    assert!(wire.reference.closest([0.0, f32::NAN, 0.0]).is_none());
}

#[test]
fn points_far_away_and_huge_are_no_trouble() {
    let mut wire = Wire::new(polyline(&[[0.0; 3], [1.0, 0.0, 0.0]]));
    wire.pose = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let points = [[f32::MAX; 3], [f32::MIN, 0.0, f32::MAX], [1e30, 1e-30, 0.0], [0.5, 0.0, 0.0]];
    let found = deform(&[wire], &points);
    assert_eq!(found[..3], points[..3]);
    assert_eq!(found[3], [0.5, 0.0, 1.0]);
}

#[test]
fn at_the_centre_of_a_circle_the_smallest_parameter() {
    // A closed polygon: all feet are equally near. Turned, its float32 corners are not equally far to the last place.
    for turn in 0..24_u8 {
        let corner = |i: u8| {
            let a = std::f64::consts::TAU * (f64::from(i) / 6.0 + f64::from(turn) / 100.0);
            [a.cos() as f32, a.sin() as f32, 0.25]
        };
        let ring: Vec<[f32; 3]> = (0..6).map(corner).collect();
        let curve = Curve::new(CurveKind::Polyline, true, ring.clone()).unwrap();
        let foot = curve.closest([0.0, 0.0, 0.25]).unwrap();
        assert!((foot.u - 1.0 / 12.0).abs() < 1e-6, "turn {turn}: {foot:?}");
        let mut wire = Wire { radius: 2.0, ..Wire::new(curve) };
        wire.pose = ring.iter().map(|p| [p[0], p[1], p[0]]).collect();
        conforms(&[wire], &[[0.0, 0.0, 0.25]], 2e-6);
        // A spline's ring is nearest in the middle of its segments or at its joints.
        let spline = Curve::new(CurveKind::BSpline { degree: 3 }, true, ring).unwrap();
        let exact = reference::closest(&spline, [0.0, 0.0, 0.25]);
        let foot = spline.closest([0.0, 0.0, 0.25]).unwrap();
        assert!((f64::from(foot.u) - exact.u).abs() < 1e-5, "turn {turn}: {foot:?}, not {exact:?}");
    }
}

#[test]
fn a_tie_is_kept_for_a_single_point_and_in_a_crowd() {
    // Feet equal to rounding: the fork of a vee, its second arm nearer by the last place.
    let vee = [[-1.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0]];
    let mut wire = Wire { radius: 2.0, ..Wire::new(polyline(&vee)) };
    wire.pose = vec![[-1.0, 1.0, 1.0], [0.0; 3], [1.0, 1.0, -1.0]];
    for x in [0.0, 1e-8, 3e-8, 1e-7] {
        let p = [x, 0.75, 0.0];
        assert!(wire.reference.closest(p).unwrap().u < 0.5, "x = {x}");
        assert!(deform(&[wire.clone()], &[p])[0][2] > 0.1, "x = {x}: alone");
        assert!(deform(&[wire.clone()], &[p; 70]).iter().all(|q| q[2] > 0.1), "x = {x}: in company");
    }
}

#[test]
fn a_hairpin_keeps_its_two_sides_apart() {
    let arms = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.02, 0.0], [0.0, 0.02, 0.0]];
    let mut wire = Wire { radius: 0.5, ..Wire::new(polyline(&arms)) };
    wire.pose = vec![arms[0], arms[1], [2.0, 0.02, 0.3], [0.0, 0.02, 0.3]];
    let points: Vec<[f32; 3]> =
        (0..40_u8).map(|i| [0.05 + f32::from(i) * 0.04, f32::from(i % 7) * 0.01 - 0.025, 0.01]).collect();
    conforms(&[wire.clone()], &points, 4e-6);
    let mut smooth = Wire { radius: 0.5, ..Wire::new(Curve::bspline(3, arms.to_vec()).unwrap()) };
    smooth.pose = wire.pose;
    conforms(&[smooth], &points, 4e-6);
}

#[test]
fn a_density_is_never_negative() {
    for density in
        [Density::Quartic, Density::Sextic, Density::Smoothstep, Density::Linear, Density::Fold(2.5)]
    {
        let mut x = 1.0_f64;
        for _ in 0..200 {
            x = x.next_down();
            assert!(density.at(x) >= 0.0, "{density:?} at {x:e}: {:e}", density.at(x));
        }
    }
}

#[test]
fn a_pose_that_does_not_fit_is_refused() {
    let mut wire = Wire::new(polyline(&[[0.0; 3], [1.0, 0.0, 0.0]]));
    let good = vec![wire.clone()];
    wire.pose.pop();
    assert!(Binding::new(std::slice::from_ref(&wire), &[[0.0; 3]]).is_err());
    let mut binding = Binding::new(&good, &[[0.0; 3]]).unwrap();
    let mut out = [[0.0; 3]];
    assert!(binding.deform_into(&[wire], &Blend::default(), &mut out).is_err(), "too short a pose");
    assert!(binding.deform_into(&[], &Blend::default(), &mut out).is_err(), "too few wires");
    assert!(binding.deform_into(&good, &Blend::default(), &mut []).is_err(), "too short a buffer");
    let nowhere = Wire { pose: vec![[f32::NAN; 3]; 2], ..good[0].clone() };
    assert!(binding.deform_into(&[nowhere], &Blend::default(), &mut out).is_err(), "a pose that is no place");
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let wire = Wire { radius, ..good[0].clone() };
        assert!(Binding::new(&[wire], &[[0.0; 3]]).is_err(), "radius {radius}");
    }
    assert!(binding.deform_into(&good, &Blend::default(), &mut out).is_ok(), "and goes on after a refusal");
}

#[test]
fn values_out_of_range_are_refused() {
    let wire = Wire::new(Curve::bspline(2, vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 1.0, 0.0]]).unwrap());
    let points = [[0.5, 0.1, 0.0]];
    let refused = |wire: Wire| Binding::new(&[wire], &points).is_err();
    assert!(!refused(wire.clone()));
    for density in [Density::Fold(f32::NAN), Density::Fold(0.5), Density::Fold(-1.0)] {
        assert!(refused(Wire { density, ..wire.clone() }));
    }
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(refused(Wire { radius, ..wire.clone() }));
    }
    assert!(refused(Wire { twist: 1e12, ..wire.clone() }));
    assert!(refused(Wire { exponent: Some(f32::NAN), ..wire.clone() }));
    let locators = vec![Locator { u: 0.5, ..Locator::default() }, Locator { u: 0.4, ..Locator::default() }];
    assert!(refused(Wire { locators, ..wire.clone() }));
    let mut binding = Binding::new(std::slice::from_ref(&wire), &points).unwrap();
    let mut out = [[7.0; 3]];
    let blend = Blend { crossing: f32::NAN, ..Blend::default() };
    assert!(binding.deform_into(&[wire], &blend, &mut out).is_err());
    assert_eq!(out, [[7.0; 3]], "nothing is written");
}
