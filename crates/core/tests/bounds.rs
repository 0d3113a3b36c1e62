//! What bounds an influence: \[SF98\] §3.1, directional dropoff, §3.2 and §4, domain curves, and masks. Closed forms; and
//! `F` on dense lines, which changes no faster than its formula lets it.
//!
//! The wires are lifted by one unit, so that the displacement is `F`.

use glam::DVec3;
use wirework_core::{Binding, Blend, Bounded, Curve, Density, Domain, Locator, Mask, Wire};
use wirework_reference::{Random, Rig, Scene};

fn deform(wires: &[Wire], points: &[[f32; 3]], masks: &[Option<&[f32]>]) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; points.len()];
    let masks: Vec<_> = masks.iter().map(|mask| mask.map(Mask::Dense)).collect();
    let mut binding = Binding::masked(wires, points, &masks).unwrap();
    binding.deform_into(wires, &Blend::default(), &mut out).unwrap();
    out
}

fn segment(from: [f32; 3], to: [f32; 3]) -> Curve {
    Curve::polyline(vec![from, to]).unwrap()
}

/// Along x from -2 to 2, radius 2, lifted by one unit.
fn lifted() -> Wire {
    let mut wire = Wire { radius: 2.0, ..Wire::new(segment([-2.0, 0.0, 0.0], [2.0, 0.0, 0.0])) };
    wire.pose.iter_mut().for_each(|p| p[2] = 1.0);
    wire
}

/// Parallel to it.
fn beside(y: f32, z: f32) -> Domain {
    Domain::new(segment([-3.0, y, z], [3.0, y, z]))
}

/// `F` of a lifted wire at every point, to the rounding of positions up to 4.
fn influences(wire: &Wire, points: &[[f32; 3]]) -> Vec<f64> {
    let found = deform(std::slice::from_ref(wire), points, &[]);
    points.iter().zip(found).map(|(p, q)| f64::from(q[2]) - f64::from(p[2])).collect()
}

/// The spacing of float32 at 4.
const ROUNDING: f64 = 5e-7;

fn quartic(x: f64) -> f64 {
    if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}

/// Points at an angle about the wire, from `+y` towards `+z`.
fn around(x: f32, distance: f32, degrees: f32) -> [f32; 3] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    // A quarter's cosine is not 0 to the bit.
    let cos = if degrees.abs() == 90.0 { 0.0 } else { cos };
    [x, distance * cos, distance * sin]
}

#[test]
fn a_parallel_domain_sets_the_radius_on_its_side() {
    for (far, delta) in [(1.0_f32, 0.0_f32), (3.0, 0.0), (1.0, 0.5), (3.0, 0.25), (0.5, 0.99)] {
        let wire = Wire { domains: vec![Domain { delta, ..beside(far, 0.0) }], ..lifted() };
        for degrees in [0.0_f32, 30.0, 61.0, 70.0, 89.0, 90.0, 100.0, 180.0, -80.0, -20.0] {
            let cos = if degrees.abs() == 90.0 { 0.0 } else { f64::from(degrees).to_radians().cos() };
            let x = if delta == 0.0 { 1.0 } else { (cos / f64::from(delta)).min(1.0) };
            let far = f64::from(far);
            let radius = if cos <= 0.0 { 2.0 } else { 2.0 + (far - 2.0) * x * x * (3.0 - 2.0 * x) };
            let distances = [0.0_f32, 0.3, 0.9, 1.5, 2.5];
            let points = distances.map(|distance| around(0.7, distance, degrees));
            for (found, distance) in influences(&wire, &points).into_iter().zip(distances) {
                let expected = quartic(f64::from(distance) / radius);
                assert!(
                    (found - expected).abs() < 2e-6,
                    "{far} {delta} at {degrees}° {distance}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn two_domains_unite_or_tend_to_the_smallest() {
    let points = [around(0.2, 0.5, 10.0), around(0.2, 1.1, 20.0), around(0.2, 1.7, 0.0)];
    for m in [1.0_f32, -1.0, 3.0] {
        let two = [beside(2.5, 0.0), beside(1.5, 0.5)].map(|d| Domain { exponent: m, ..d });
        let wire = Wire { domains: two.to_vec(), ..lifted() };
        for (found, p) in influences(&wire, &points).into_iter().zip(points) {
            let distance = f64::from(p[1]).hypot(p[2].into());
            let (a, b) = (quartic(distance / 2.5), quartic(distance / 1.5_f64.hypot(0.5)));
            let weight = |f: f64| if f > 0.0 { f.powf(m.into()) } else { 0.0 };
            let expected = (a * weight(a) + b * weight(b)) / (weight(a) + weight(b));
            assert!((found - expected).abs() < 2e-6, "m = {m}, {p:?}: {found}, not {expected}");
        }
    }
}

#[test]
fn a_domain_bounds_the_twist_alone() {
    let mut wire =
        Wire { twist: 1.2, domains: vec![Domain { bounds: Bounded::Twist, ..beside(1.0, 0.0) }], ..lifted() };
    wire.pose = wire.reference.points().to_vec();
    let angle = |p: [f32; 3], q: [f32; 3]| {
        let [a, b] = [p, q].map(|p| f64::from(p[2]).atan2(p[1].into()));
        b - a
    };
    let points =
        [around(0.0, 0.5, 15.0), around(0.0, 0.9, -20.0), around(1.0, 1.5, 0.0), around(0.0, 1.5, 120.0)];
    for (p, q) in points.into_iter().zip(deform(&[wire.clone()], &points, &[])) {
        let distance = f64::from(p[1]).hypot(p[2].into());
        // On the far side the twist goes as far as the wire.
        let far = if p[1] > 0.0 { 1.0 } else { 2.0 };
        let expected = f64::from(1.2_f32) * quartic(distance / far);
        assert!((angle(p, q) - expected).abs() < 2e-6, "{p:?}: {}, not {expected}", angle(p, q));
    }
    // The lift goes on where the twist has ended.
    let both = Wire { pose: lifted().pose, ..wire };
    let found = deform(&[both], &points[2..3], &[])[0];
    assert!((f64::from(found[2]) - quartic(0.75)).abs() < 1e-6 && found[1] == 1.5, "{found:?}");
}

#[test]
fn a_wire_that_is_masked_out_is_no_rival_in_its_group() {
    // Two wires on one curve share the points between them by their masks.
    let mut wires = [lifted(), lifted()];
    for (wire, height) in wires.iter_mut().zip([1.0, 3.0]) {
        wire.group = Some(0);
        wire.pose.iter_mut().for_each(|p| p[2] = height);
    }
    let points = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let (left, right) = ([1.0, 0.0, 1.0], [0.0, 1.0, 1.0]);
    let heights: Vec<f32> =
        deform(&wires, &points, &[Some(&left), Some(&right)]).iter().map(|q| q[2]).collect();
    assert_eq!(heights, [1.0, 3.0, 1.0]);
}

#[test]
fn a_direction_falls_off_by_the_angle() {
    // The part along the wire does not count.
    let wire = Wire { direction: Some([7.0, 0.0, 2.0]), angle: 2.0, ..lifted() };
    for degrees in [90.0_f32, 91.0, 60.0, 0.0, 180.0, 200.0, -20.0, -25.0, 270.0] {
        let away = f64::from((degrees - 90.0).abs()).to_radians();
        let expected = quartic(0.5) * quartic(away / 2.0);
        let found = influences(&wire, &[around(0.3, 1.0, degrees)])[0];
        assert!((found - expected).abs() < 2e-6, "{degrees}°: {found}, not {expected}");
    }
    let on = influences(&wire, &[[0.5, 0.0, 0.0], [-3.0, 0.0, 0.0]]);
    assert!(
        (on[0] - 1.0).abs() < 1e-6 && (on[1] - quartic(0.5)).abs() < 1e-6,
        "{on:?}: on the wire and in line with it"
    );
}

#[test]
fn on_the_wire_and_along_it_there_is_no_dropoff_whatever_the_signs() {
    for signs in 0..8_u8 {
        let sign = |bit: u8| if signs & bit == 0 { 1.0_f32 } else { -1.0 };
        let way = [sign(1), sign(2), 0.0];
        let ends = [way.map(|c| -c), way];
        let mut wire = Wire { radius: 2.0, ..Wire::new(segment(ends[0], ends[1])) };
        wire.pose = ends.map(|p| [p[0], p[1], 1.0]).to_vec();
        // On the wire: any axis, towards every side.
        for axis in [[1.0, 1.0, 1.0], [-1.0, -1.0, -1.0], [0.0, 0.0, -3.0], [-1.0, 2.0, 0.5]] {
            wire.direction = Some(axis);
            let points: Vec<[f32; 3]> =
                (0..=9_u8).map(|i| way.map(|c| c * (f32::from(i) * 0.15 - 0.6))).collect();
            for (p, found) in points.iter().zip(influences(&wire, &points)) {
                assert!((found - 1.0).abs() < 1e-6, "{axis:?} at {p:?} on {way:?}: {found}");
            }
        }
        // The axis along the wire: on every side of it.
        wire.direction = Some(way.map(|c| c * 3.0));
        for side in 0..8_u8 {
            let side = |bit: u8| if side & bit == 0 { 0.25 } else { -0.25 };
            let p = [side(1), side(2), side(4)];
            let along = 0.5 * (p[0] * way[0] + p[1] * way[1]);
            let off: f32 = [0, 1, 2].map(|i| p[i] - along * way[i]).iter().map(|c| c * c).sum();
            let found = influences(&wire, &[p])[0];
            assert!(
                (found - quartic(f64::from(off).sqrt() / 2.0)).abs() < 1e-6,
                "{p:?} beside {way:?}: {found}"
            );
        }
    }
}

#[test]
fn locators_turn_the_direction() {
    let at = |u, direction, angle| Locator {
        u,
        direction: Some(direction),
        angle: Some(angle),
        ..Locator::default()
    };
    let locators = vec![at(0.0, [0.0, 1.0, 0.0], 1.0), at(1.0, [0.0, 0.0, 3.0], 3.0)];
    let wire = Wire { locators, ..lifted() };
    for (x, degrees) in [(-2.0_f32, 30.0_f32), (-1.0, 10.0), (0.0, 60.0), (1.0, 120.0), (2.0, 0.0)] {
        let u = f64::from(x) / 4.0 + 0.5;
        let axis = (3.0 * u).atan2(1.0 - u);
        let expected =
            quartic(0.5) * quartic((f64::from(degrees).to_radians() - axis).abs() / (1.0 + 2.0 * u));
        let found = influences(&wire, &[around(x, 1.0, degrees)])[0];
        assert!((found - expected).abs() < 2e-6, "{x} {degrees}°: {found}, not {expected}");
    }
}

#[test]
fn a_mask_of_nothing_keeps_the_bits_and_of_a_half_halves_the_lift() {
    let wire = Wire { domains: vec![Domain { delta: 0.3, ..beside(1.0, 0.0) }], ..lifted() };
    let points: Vec<[f32; 3]> =
        (0..300_u16).map(|i| around(f32::from(i) * 0.01, 0.8, f32::from(i))).collect();
    let [none, half, one] = [0.0, 0.5, 1.0].map(|mask| vec![mask; points.len()]);
    let with = |mask: &[f32]| deform(std::slice::from_ref(&wire), &points, &[Some(mask)]);
    let plain = deform(std::slice::from_ref(&wire), &points, &[]);
    assert_eq!(bits(&with(&none)), bits(&points));
    assert_eq!(bits(&with(&one)), bits(&plain));
    assert_eq!(bits(&deform(std::slice::from_ref(&wire), &points, &[None])), bits(&plain));
    for ((p, q), found) in points.iter().zip(&plain).zip(with(&half)) {
        assert!((found[2] - 0.5 * (p[2] + q[2])).abs() < 1e-6, "{p:?}: {found:?}, half of {q:?}");
    }
    // Of two wires each has its own.
    let wires = [wire.clone(), Wire { group: None, ..wire }];
    let halves: Vec<f32> = (0..points.len()).map(|i| if i % 2 == 0 { 0.0 } else { 1.0 }).collect();
    let found = deform(&wires, &points, &[Some(&halves), Some(&none)]);
    for (i, q) in found.iter().enumerate() {
        let expected = if i % 2 == 0 { points[i] } else { plain[i] };
        assert!((0..3).all(|k| (q[k] - expected[k]).abs() < 1e-6), "{i}: {q:?}, not {expected:?}");
    }
}

fn bits(points: &[[f32; 3]]) -> Vec<[u32; 3]> {
    points.iter().map(|p| p.map(f32::to_bits)).collect()
}

/// The largest `|f′|`: of the quartic `8 / (3√3)`, of the sextic `96 / (25√5)`, of the smoothstep 3/2.
fn densities() -> [(Density, f64); 4] {
    [
        (Density::Quartic, 1.5397),
        (Density::Sextic, 1.7173),
        (Density::Smoothstep, 1.5),
        (Density::Linear, 1.0),
    ]
}

/// The largest `|s′|` of the smoothstep from one radius to the other.
const STEEPEST: f64 = 1.5;

/// A line of points 1e-3 apart near the wire.
fn line(random: &mut Random) -> Vec<[f32; 3]> {
    let ends = [0; 2].map(|_| random.vector(3.0));
    let length = (0..3).map(|i| (ends[1][i] - ends[0][i]).powi(2)).sum::<f64>().sqrt();
    let count = (length / 1e-3).ceil().max(1.0);
    let at = |i: usize| [0, 1, 2].map(|k| (ends[0][k] + (ends[1][k] - ends[0][k]) * i as f64 / count) as f32);
    (0..=count as usize).map(at).collect()
}

/// The largest change of `F` a unit of way, what rounding accounts for left aside.
fn steepness(line: &[[f32; 3]], influences: &[f64]) -> f64 {
    let way = |a: [f32; 3], b: [f32; 3]| {
        (0..3).map(|i| (f64::from(b[i]) - f64::from(a[i])).powi(2)).sum::<f64>().sqrt()
    };
    let slope = |i: usize| {
        let change = (influences[i + 1] - influences[i]).abs() - 2.0 * ROUNDING;
        change / way(line[i], line[i + 1])
    };
    (0..line.len() - 1).map(slope).fold(0.0, f64::max)
}

/// The point of a segment closest to a point.
fn foot(segment: &Curve, p: DVec3) -> DVec3 {
    let [a, b] = [0, 1].map(|i| DVec3::from_array(segment.points()[i].map(f64::from)));
    a + (b - a) * ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0)
}

/// The distance of two segments, none longer than 9, from below.
fn clearance(a: &Curve, b: &Curve) -> f64 {
    let [start, end] = [0, 1].map(|i| DVec3::from_array(a.points()[i].map(f64::from)));
    let at = |i: u16| start.lerp(end, f64::from(i) / 1000.0);
    (0..=1000).map(|i| at(i).distance(foot(b, at(i)))).fold(f64::INFINITY, f64::min) - 0.0045
}

/// A segment anywhere near the wire, but not on it.
fn segment_off(wire: &Wire, random: &mut Random) -> (Curve, f64) {
    loop {
        let [a, b] = [0; 2].map(|_| random.vector(2.5).map(|c| c as f32));
        let curve = segment(a, b);
        let clear = clearance(&wire.reference, &curve);
        if clear > 0.3 {
            return (curve, clear);
        }
    }
}

/// How fast `F` may change beside a segment `R` with a domain segment `D` at least `near` from it.
///
/// The feet on both and `v = P − R(p)` change no faster than `P`, so `n = D(p_D) − R(p_R)` by at most 2 and `cosangle` by
/// `1 / ‖v‖ + 2 / ‖n‖`. With `ρ = r + (‖n‖ − r)·s(cosangle / δ)`, nowhere below `ρ₀ = min(r, near)`, and `‖v‖ < ρ` where
/// `F > 0`, the change of `‖v‖ / ρ` is at most
/// `1/ρ + ‖v‖/ρ²·(2 + |‖n‖ − r|·s′/δ·(1/‖v‖ + 2/‖n‖)) ≤ (3 + |‖n‖ − r|·s′/δ·(1/ρ₀ + 2/near)) / ρ₀`.
fn steepest_beside(wire: &Wire, line: &[[f32; 3]], near: f64, slope: f64) -> f64 {
    let r = f64::from(wire.radius);
    let [reference, domain] = [&wire.reference, &wire.domains[0].curve];
    let gap = |p: &[f32; 3]| {
        let p = DVec3::from_array(p.map(f64::from));
        (foot(reference, p).distance(foot(domain, p)) - r).abs()
    };
    // Between samples the gap changes by no more than 2 · 20 · 1e-3.
    let gap = line.iter().step_by(20).map(gap).fold(0.0, f64::max) + 0.04;
    let (floor, delta) = (r.min(near), f64::from(wire.domains[0].delta));
    slope * (3.0 + gap * STEEPEST / delta * (1.0 / floor + 2.0 / near)) / floor
}

#[test]
fn the_influence_is_continuous_across_a_domain_with_delta() {
    let mut random = Random::new(1);
    let mut steps = 0;
    for case in 0..60 {
        let mut wire = Wire { radius: random.range(0.5, 2.0) as f32, ..lifted() };
        let (curve, near) = segment_off(&wire, &mut random);
        let delta = random.pick(&[0.1, 0.3, 0.6, 0.95]);
        wire.domains = vec![Domain { delta, ..Domain::new(curve) }];
        let (density, slope) = random.pick(&densities());
        wire.density = density;
        let line = line(&mut random);
        let found = steepness(&line, &influences(&wire, &line));
        let allowed = steepest_beside(&wire, &line, near, slope);
        assert!(found <= allowed, "case {case}: {found} a unit, allowed {allowed}, {wire:#?}");
        wire.domains[0].delta = 0.0;
        steps += usize::from(steepness(&line, &influences(&wire, &line)) > 1.1 * allowed);
    }
    assert!(steps > 5, "without delta F steps, or this shows nothing: {steps}");
}

#[test]
fn the_influence_is_continuous_across_several_domains_with_positive_exponents() {
    // |∂F/∂Fⱼ| ≤ 1 for m = 1: (a² + 2ab − b²) / (a + b)² lies between -1 and 1. So the bounds add up.
    let mut random = Random::new(2);
    for case in 0..30 {
        let mut wire = Wire { radius: random.range(0.5, 2.0) as f32, ..lifted() };
        let line = line(&mut random);
        let mut allowed = 0.0;
        let mut domains = Vec::new();
        for _ in 0..2 {
            let (curve, near) = segment_off(&wire, &mut random);
            wire.domains = vec![Domain { delta: random.pick(&[0.2, 0.5]), ..Domain::new(curve) }];
            allowed += steepest_beside(&wire, &line, near, 1.5397);
            domains.append(&mut wire.domains);
        }
        wire.domains = domains;
        let found = steepness(&line, &influences(&wire, &line));
        assert!(found <= allowed, "case {case}: {found} a unit, allowed {allowed}, {wire:#?}");
    }
}

#[test]
fn the_influence_is_continuous_across_the_radius_and_the_angle() {
    // ‖v‖ / r changes by (1 + |r′|) / r, where the radius changes by r′ a unit along the wire; φ / a by 1 / (a·‖v‖) beside the
    // wire. Beyond its ends the arm across it may be short: only points beside count, and only those off it.
    let mut random = Random::new(3);
    for case in 0..60 {
        let radii = [0; 2].map(|_| random.range(0.6, 2.0) as f32);
        let at = |u, radius| Locator { u, radius: Some(radius), ..Locator::default() };
        let mut wire = lifted();
        wire.locators = vec![at(0.0, radii[0]), at(1.0, radii[1])];
        let (density, slope) = random.pick(&densities());
        wire.density = density;
        let line = line(&mut random);
        let (least, change) = (radii[0].min(radii[1]), (radii[0] - radii[1]).abs());
        let radial = slope * (1.0 + f64::from(change) / 4.0) / f64::from(least);
        let found = steepness(&line, &influences(&wire, &line));
        assert!(found <= radial, "case {case}: {found} a unit, allowed {radial}, {wire:#?}");

        let [_, y, z] = random.vector(1.0);
        wire.direction = Some([0.3, y as f32, z as f32]);
        wire.angle = random.range(0.3, 4.0) as f32;
        let off = 0.2_f64;
        let beside = |p: &[f32; 3]| p[0].abs() <= 2.0 && f64::from(p[1]).hypot(p[2].into()) > off;
        for part in line.split(|p| !beside(p)).filter(|part| part.len() > 1) {
            let allowed = radial + slope / (f64::from(wire.angle) * off);
            let found = steepness(part, &influences(&wire, part));
            assert!(found <= allowed, "case {case}: {found} a unit, allowed {allowed}, {wire:#?}");
        }
    }
}

#[test]
fn bits_stay_where_no_influence_reaches() {
    let mut random = Random::new(4);
    let (mut within, mut bounded) = (0, 0);
    for seed in 0..40 {
        let rig = Rig::new(seed);
        let (scene, plain) = (Scene::new(&rig.wires, &rig.blend), Rig::plain(seed));
        let plain = Scene::new(&plain.wires, &rig.blend);
        let extent = rig.points.iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
        let mut out = vec![[0.0; 3]; rig.points.len()];
        let mut binding = Binding::masked(&rig.wires, &rig.points, &rig.masks()).unwrap();
        binding.deform_into(&rig.wires, &rig.blend, &mut out).unwrap();
        for (i, (&p, q)) in rig.points.iter().zip(&out).enumerate().step_by(2) {
            let masks = rig.masks_at(i);
            // Of the neighbourhood too, in which rounding may decide.
            let nothing = |p| scene.contributions(p, &masks).iter().all(|c| c.0 == 0.0);
            let mut near = || p.map(|c| c + extent * random.range(-4e-6, 4e-6) as f32);
            if nothing(p) && (0..3).all(|_| nothing(near())) {
                assert_eq!(p.map(f32::to_bits), q.map(f32::to_bits), "seed {seed}: {p:?}, {:#?}", rig.wires);
                within += 1;
                bounded += usize::from(plain.contributions(p, &[]).iter().any(|c| c.0 > 0.0));
            }
        }
    }
    assert!(
        within > 500 && bounded > 100,
        "{within} points without influence, {bounded} of them by their bounds"
    );
}
