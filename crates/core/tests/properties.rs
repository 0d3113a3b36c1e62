//! What every rig obeys, whatever its numbers: \[SF98\] §2's list of properties, §4's requirements, symmetry.

use glam::{DQuat, DVec3};
use std::cell::OnceCell;
use wirework_core::{Bend, Binding, Blend, Correspondence, Curve, CurveKind, Density, Wire};
use wirework_reference::{Doubt, Random, Rig, Scene, influence, point};

fn deform(wires: &[Wire], blend: &Blend, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; points.len()];
    Binding::new(wires, points).unwrap().deform_into(wires, blend, &mut out).unwrap();
    out
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn deform_rig(rig: &Rig) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; rig.points.len()];
    let mut binding = Binding::masked(&rig.wires, &rig.points, &rig.masks()).unwrap();
    binding.deform_into(&rig.wires, &rig.blend, &mut out).unwrap();
    out
}

/// Deforming and mapping in either order is the same within `tolerance` diagonals, but for a few points at which the
/// rounding of the mapped input decides.
fn commutes(seed: u64, rig: &Rig, map: impl Fn(DVec3) -> DVec3, factor: f32, tolerance: f64) -> usize {
    let after = deform_rig(rig);
    let other = rig.mapped(&map, factor);
    let before = deform_rig(&other);
    let diagonal = other.diagonal();
    let (exact, mut left_out) = (OnceCell::new(), 0);
    for (i, (&a, &b)) in after.iter().zip(&before).enumerate() {
        let error = map(wide(a)).distance(wide(b)) / diagonal;
        if error > tolerance {
            // Half a turn takes its axis from the coordinate axes: there the contract itself does not commute.
            let (doubt, one, two) = exact.get_or_init(|| {
                let scene = |rig: &Rig| Scene::new(&rig.wires, &rig.blend);
                (Doubt::new(&other.wires, &other.blend, 4e-7), scene(rig), scene(&other))
            });
            let masks = rig.masks_at(i);
            let one = DVec3::from_array(one.deform_masked(rig.points[i], &masks));
            let two = DVec3::from_array(two.deform_masked(other.points[i], &masks));
            let moves = doubt.of_masked(other.points[i], &masks).max(map(one).distance(two)) / diagonal;
            assert!(
                moves > 0.25 * tolerance,
                "seed {seed}, {:?}: off by {error:e}, {:#?}",
                rig.points[i],
                rig.wires
            );
            left_out += 1;
        }
    }
    left_out
}

/// Left out points may be so many of all, in hundredths.
fn few(left_out: usize, all: usize, hundredths: usize) {
    assert!(left_out * 100 <= hundredths * all, "{left_out} of {all} points left out");
}

#[test]
fn rigid_motions_commute_with_the_deformation() {
    let (mut left_out, mut all) = (0, 0);
    for seed in 0..40 {
        let rig = Rig::new(seed);
        let mut random = Random::new(!seed);
        let turn = DQuat::from_scaled_axis(DVec3::from_array(random.vector(3.0)));
        let shift = DVec3::from_array(random.vector(0.5 * rig.diagonal()));
        left_out += commutes(seed, &rig, |p| turn * p + shift, 1.0, 2e-5);
        all += rig.points.len();
    }
    // Many of the points lie at exactly r, or where a domain curve begins to count.
    few(left_out, all, 9);
}

#[test]
fn uniform_scalings_commute_with_the_deformation() {
    let (mut left_out, mut all) = (0, 0);
    for seed in 0..40 {
        let rig = Rig::new(seed);
        // A power of two rounds nothing.
        assert_eq!(commutes(seed, &rig, |p| p * 64.0, 64.0, 1e-6), 0, "seed {seed}");
        left_out += commutes(seed, &rig, |p| p * f64::from(0.37_f32), 0.37, 2e-5);
        all += rig.points.len();
    }
    few(left_out, all, 4);
}

#[test]
fn outside_the_radius_nothing_moves() {
    let mut random = Random::new(3);
    for seed in 0..60 {
        let wire = Rig::plain(seed).wires.swap_remove(0);
        let wire = Wire { locators: Vec::new(), ..wire };
        let r = f64::from(wire.radius);
        let points: Vec<[f32; 3]> = (0..200)
            .map(|_| {
                let on = DVec3::from_array(point(&wire.reference, random.range(0.0, 1.0)));
                (on + DVec3::from_array(random.vector(3.0 * r))).as_vec3().to_array()
            })
            .collect();
        for (&p, &q) in points.iter().zip(&deform(std::slice::from_ref(&wire), &Blend::default(), &points)) {
            let foot = wirework_reference::closest(&wire.reference, p.map(f64::from));
            if foot.distance > r * (1.0 + 1e-6) {
                assert_eq!(p.map(f32::to_bits), q.map(f32::to_bits), "seed {seed}");
            }
        }
    }
}

#[test]
fn points_on_the_reference_track_the_wire() {
    let (mut left_out, mut all) = (0, 0);
    for seed in 0..100 {
        let wire = Rig::plain(seed).wires.swap_remove(0);
        let wire =
            Wire { locators: Vec::new(), amplitude: 1.0, correspondence: Correspondence::Parameter, ..wire };
        let pose = wire.reference.posed(wire.pose.clone()).unwrap();
        let on: Vec<DVec3> =
            (0..50).map(|i| DVec3::from_array(point(&wire.reference, f64::from(i) / 49.0))).collect();
        let points: Vec<[f32; 3]> = on.iter().map(|p| p.as_vec3().to_array()).collect();
        let (wires, blend) = (vec![wire.clone()], Blend::default());
        let rig = Rig { wires, blend, points: points.clone(), masks: vec![None] };
        let diagonal = rig.diagonal();
        let doubt = OnceCell::new();
        for (&p, &q) in points.iter().zip(&deform(&rig.wires, &rig.blend, &points)) {
            // Where the curve meets itself, or stands nearly still, its foot is not its own.
            let foot = wirework_reference::closest(&wire.reference, p.map(f64::from));
            let target = DVec3::from_array(point(&pose, foot.u));
            let error = wide(q).distance(target);
            // f(x) = 1 − x falls with the rounding of x, the others with its square.
            let allowed = if wire.density == Density::Linear { 5e-6 } else { 4e-6 } * diagonal;
            if error > allowed {
                let doubt = doubt.get_or_init(|| Doubt::new(&rig.wires, &rig.blend, 1.2e-7));
                assert!(doubt.of(p) > 0.25 * allowed, "seed {seed}, {p:?}: {error:e}, {wire:#?}");
                left_out += 1;
            }
            all += 1;
        }
    }
    few(left_out, all, 4);
}

/// Both halves of a Bézier chain's middle segment as chains of their own, exactly: control points on a coarse lattice.
fn cut(points: &[[f32; 3]]) -> [Vec<[f32; 3]>; 2] {
    let mid = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    let segment = points.len() / 3 / 2 * 3;
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| points[segment + i]);
    let (ab, bc, cd) = (mid(a, b), mid(b, c), mid(c, d));
    let (abc, bcd) = (mid(ab, bc), mid(bc, cd));
    let middle = mid(abc, bcd);
    [
        [&points[..=segment], &[ab, abc, middle]].concat(),
        [&[middle, bcd, cd], &points[segment + 3..]].concat(),
    ]
}

#[test]
fn a_wire_cut_in_two_in_one_group_deforms_as_one() {
    let mut random = Random::new(11);
    for case in 0..60 {
        let count = 1 + 3 * random.pick(&[1, 2, 3]);
        let mut lattice = |size: f64| -> Vec<[f32; 3]> {
            (0..count).map(|_| random.vector(size).map(|c| (c * 16.0).round() as f32 / 16.0)).collect()
        };
        let (rest, shift) = (lattice(1.0), lattice(0.4));
        let pose: Vec<[f32; 3]> =
            rest.iter().zip(&shift).map(|(a, b)| [0, 1, 2].map(|i| a[i] + b[i])).collect();
        let wire = |rest: &[[f32; 3]], pose: &[[f32; 3]]| {
            let reference = Curve::new(CurveKind::Bezier, false, rest.to_vec()).unwrap();
            Wire {
                pose: pose.to_vec(),
                radius: 0.7,
                scale: 1.3,
                twist: 0.4,
                group: Some(5),
                ..Wire::new(reference)
            }
        };
        let whole = vec![wire(&rest, &pose)];
        let (rests, poses) = (cut(&rest), cut(&pose));
        let halves = vec![wire(&rests[0], &poses[0]), wire(&rests[1], &poses[1])];
        let points: Vec<[f32; 3]> = (0..200).map(|_| random.vector(1.2).map(|c| c as f32)).collect();
        let blend = Blend::default();
        let (doubt, mut left_out) = (OnceCell::new(), 0);
        let both = deform(&whole, &blend, &points).into_iter().zip(deform(&halves, &blend, &points));
        for (&p, (a, b)) in points.iter().zip(both) {
            if wide(a).distance(wide(b)) > 4e-6 {
                let doubt = doubt.get_or_init(|| Doubt::new(&whole, &blend, 2.4e-7));
                assert!(doubt.of(p) > 1e-6, "case {case}, {p:?}: {a:?} or {b:?}");
                left_out += 1;
            }
        }
        assert!(left_out <= 4, "case {case}: {left_out} left out");
    }
}

#[test]
fn two_equal_wires_act_as_one() {
    for seed in 0..60 {
        let mut rig = Rig::plain(seed);
        rig.wires.truncate(1);
        rig.blend.crossing = 0.0;
        let once = deform(&rig.wires, &rig.blend, &rig.points);
        rig.wires.push(rig.wires[0].clone());
        let twice = deform(&rig.wires, &rig.blend, &rig.points);
        for (a, b) in once.iter().zip(&twice) {
            assert!(wide(*a).distance(wide(*b)) <= 1e-6 * rig.diagonal(), "seed {seed}: {a:?}, {b:?}");
        }
    }
}

#[test]
fn influence_one_carries_all_the_way_and_zero_not_at_all() {
    let mut wire = Wire::new(Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0]]).unwrap());
    wire.pose = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let points: Vec<[f32; 3]> = (0..=20_u8).map(|i| [0.5, f32::from(i) / 20.0, 0.0]).collect();
    let found = deform(std::slice::from_ref(&wire), &Blend::default(), &points);
    for (p, q) in points.iter().zip(&found) {
        assert!((f64::from(q[2]) - influence(&wire, p.map(f64::from))).abs() < 1e-6);
    }
    assert_eq!((found[0], found[20]), ([0.5, 0.0, 1.0], [0.5, 1.0, 0.0]));
}

/// Two straight wires that cross at the origin, raised by `a` and `b`.
fn crossing(a: f32, b: f32) -> Vec<Wire> {
    let raised = |end: [f32; 3], height: f32| {
        let start = end.map(|c| -c);
        let mut wire = Wire { radius: 2.0, ..Wire::new(Curve::polyline(vec![start, end]).unwrap()) };
        wire.pose = vec![start, end].into_iter().map(|p| [p[0], p[1], height]).collect();
        wire
    };
    vec![raised([1.0, 0.0, 0.0], a), raised([0.0, 1.0, 0.0], b)]
}

fn height(wires: &[Wire], exponent: f32) -> f32 {
    deform(wires, &Blend { exponent, ..Blend::default() }, &[[0.0; 3]])[0][2]
}

#[test]
fn the_exponent_runs_from_the_smallest_over_the_mean_to_the_largest() {
    let wires = crossing(1.0, 3.0);
    for (m, expected) in [(-60.0, 1.0), (-1.0, 1.5), (0.0, 2.0), (1.0, 2.5), (2.0, 2.8), (60.0, 3.0)] {
        assert!((height(&wires, m) - expected).abs() < 2e-6, "m = {m}: {}", height(&wires, m));
    }
    assert!(height(&wires, f32::MAX).is_finite() && height(&wires, f32::MIN).is_finite());
    // Far apart: the small one alone for m < 0, nothing of it for m > 0, and never NaN.
    let wires = crossing(1e-20, 1.0);
    for (m, expected) in [(-8.0, 0.0), (-1.0, 0.0), (0.0, 0.5), (1.0, 1.0), (8.0, 1.0)] {
        assert!((height(&wires, m) - expected).abs() < 1e-6, "m = {m}: {}", height(&wires, m));
    }
}

#[test]
fn pinned_wires_alone_move_the_points_on_them_and_share_the_others_smoothly() {
    let blend = Blend { localize: 1.0, pinned: true, ..Blend::default() };
    let mut wires = crossing(1.0, 3.0);
    let along = |t: f32| [[t, 0.0, 0.0], [0.0, t, 0.0]];
    for t in [1.0, 0.5, 0.1, 0.01] {
        let [a, b] = along(t).map(|p| deform(&wires, &blend, &[p])[0]);
        assert!((a[2] - 1.0).abs() < 1e-5 && (b[2] - 3.0).abs() < 1e-5, "at {t}: {a:?} {b:?}");
    }
    // Where both lie, both have the same say.
    assert_eq!(deform(&wires, &blend, &[[0.0; 3]])[0][2], 2.0);
    // Between the two no step, and the weights are what the formula says.
    let arc: Vec<[f32; 3]> =
        (0..=900).map(|i| (i as f32 * 0.1).to_radians()).map(|a| [a.cos(), a.sin(), 0.0]).collect();
    let heights: Vec<f32> = deform(&wires, &blend, &arc).iter().map(|p| p[2]).collect();
    assert!(heights.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01));
    for (p, z) in arc.iter().zip(&heights) {
        let [f, g] = [p[1], p[0]].map(|d| f64::from(1.0 - (d * 0.5).powi(2)).powi(2));
        let [v, w] = [f / (1.0 - f).max(1e-7), g / (1.0 - g).max(1e-7)];
        let expected = (v * f + w * g * 3.0) / (v + w);
        assert!((f64::from(*z) - expected).abs() < 2e-5, "at {p:?}: {z}, not {expected}");
    }
    // One without amplitude has no say, not even on its own reference; one that does not move holds.
    wires[1].amplitude = 0.0;
    let (both, one) =
        (deform(&wires, &blend, &arc[450..451])[0], deform(&wires[..1], &blend, &arc[450..451])[0]);
    assert!((both[2] - one[2]).abs() < 1e-6, "{both:?} {one:?}");
    wires[1] = Wire { pose: wires[1].reference.points().to_vec(), amplitude: 1.0, ..wires[1].clone() };
    let held = deform(&wires, &blend, &[[0.0, 0.5, 0.0]])[0];
    assert!(held[2].abs() < 1e-9, "{held:?}");
}

#[test]
fn a_wire_that_moves_nothing_is_left_out_whatever_the_exponent() {
    let wires = crossing(0.0, 1.0);
    for m in [-8.0, -1.0, 0.0, 1.0, 8.0] {
        assert_eq!(height(&wires, m), 1.0, "m = {m}");
    }
}

#[test]
fn transport_does_not_step_where_tangents_pass_each_other() {
    // W winds once and a half against a straight R; neighbours must stay neighbours.
    let n = 61_u8;
    let rest: Vec<[f32; 3]> = (0..n).map(|i| [f32::from(i) * 0.1, 0.0, 0.0]).collect();
    let winding = |i: u8| {
        let angle = 3.0 * std::f32::consts::PI * f32::from(i) / f32::from(n - 1);
        [angle.sin(), 1.0 - angle.cos(), 0.0]
    };
    let mut wire = Wire { radius: 1.0, ..Wire::new(Curve::bspline(3, rest).unwrap()) };
    wire.pose = (0..n).map(winding).collect();
    let points: Vec<[f32; 3]> = (0..2000_u16).map(|i| [f32::from(i) * 0.003, 0.4, 0.1]).collect();
    let jump = |bend| {
        let wire = Wire { bend, ..wire.clone() };
        let found = deform(&[wire], &Blend::default(), &points);
        found.windows(2).map(|w| wide(w[0]).distance(wide(w[1]))).fold(0.0, f64::max)
    };
    assert!(jump(Bend::Transport) < 0.03, "{}", jump(Bend::Transport));
    assert!(jump(Bend::Tangent) > 0.3, "Tangent steps here, or this shows nothing");
}

#[test]
fn what_is_carried_keeps_its_feet() {
    // A bent wire, points on both sides of its medial axis; all of it turned and moved is the same deformation turned and moved.
    let turn = |p: [f32; 3]| [2.0 - p[1], 1.0 + p[0], p[2] - 3.0];
    let curve = |f: &dyn Fn([f32; 3]) -> [f32; 3]| {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.2, 1.0, 0.1]];
        Curve::bspline(2, points.map(f).to_vec()).unwrap()
    };
    let points: Vec<[f32; 3]> = (0..4000)
        .map(|i| [(i % 20) as f32 * 0.07, (i / 20 % 20) as f32 * 0.07, (i / 400) as f32 * 0.03])
        .collect();
    let lifted = |p: [f32; 3]| [p[0], p[1] * 1.3, p[2] + 0.4 * p[0]];
    let mut wires = [Wire { radius: 0.6, ..Wire::new(curve(&|p| p)) }];
    let mut binding = Binding::new(&wires, &points).unwrap();
    wires[0].pose = wires[0].pose.iter().map(|p| lifted(*p)).collect();
    let mut rest = points.clone();
    binding.deform_into(&wires, &Blend::default(), &mut rest).unwrap();

    let carried: Vec<[f32; 3]> = points.iter().map(|p| turn(*p)).collect();
    wires[0].pose = wires[0].pose.iter().map(|p| turn(*p)).collect();
    wires[0].reference = curve(&turn);
    binding.carry(&wires, &carried).unwrap();
    let mut out = carried.clone();
    binding.deform_into(&wires, &Blend::default(), &mut out).unwrap();
    let far = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
    assert!(out.iter().zip(&rest).all(|(now, rest)| far(now, &turn(*rest)) < 1e-5));

    // Straightened, a point is moved as its own foot is, not as the curve that is nearest to it now.
    let straight: Vec<[f32; 3]> = (0..4).map(|i| [i as f32, 0.0, 0.0]).collect();
    wires[0] = Wire { radius: 0.6, rotation: 0.0, ..Wire::new(Curve::bspline(2, straight).unwrap()) };
    let end = [0.2, 1.05, 0.1];
    let mut alone = Binding::new(&[Wire { radius: 0.6, ..Wire::new(curve(&|p| p)) }], &[end]).unwrap();
    // It has been carried to the root.
    alone.carry(&wires, &[[0.0, 0.05, 0.0]]).unwrap();
    wires[0].pose[3][1] += 1.0;
    let mut out = [[0.0; 3]];
    alone.deform_into(&wires, &Blend::default(), &mut out).unwrap();
    assert!(out[0][1] > 0.8, "{out:?}");
}
