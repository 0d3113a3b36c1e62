//! Weights of control points against the deformation itself, on random rigs whose wires only translate.

use glam::DVec3;
use wirework_core::{
    Binding, Blend, Bounded, Closest, Correspondence, Curve, CurveKind, Domain, Locator, Weight, Weights,
    WeightsError, Wire,
};
use wirework_reference::{Random, Rig};

/// Float32 in the deformation, in parts of the diagonal; amplitudes go up to 1.
const OFF: f64 = 2e-6;

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// The rig with wires that only translate; a Catmull-Rom spline gets another kind.
fn tamed(mut rig: Rig) -> Rig {
    for wire in &mut rig.wires {
        (wire.rotation, wire.scale, wire.twist) = (0.0, 1.0, 0.0);
        for locator in &mut wire.locators {
            (locator.rotation, locator.scale, locator.twist) = (None, None, None);
        }
        wire.correspondence = Correspondence::Parameter;
        let reference = &wire.reference;
        if reference.kind() == CurveKind::CatmullRom {
            let (kind, points) = (CurveKind::BSpline { degree: 3 }, reference.points().to_vec());
            wire.reference = Curve::new(kind, reference.closed(), points).unwrap();
        }
    }
    if rig.blend.crossing != 1.0 {
        rig.blend.localize = 1.0;
    }
    rig
}

fn moved(weights: &Weights, wires: &[Wire], points: &[[f32; 3]]) -> Vec<DVec3> {
    let part = |&Weight { wire, control, weight }: &Weight| {
        let (wire, control) = (&wires[wire as usize], control as usize);
        (wide(wire.pose[control]) - wide(wire.reference.points()[control])) * weight
    };
    let point = |(i, p): (usize, &[f32; 3])| wide(*p) + weights.of(i).iter().map(part).sum::<DVec3>();
    points.iter().enumerate().map(point).collect()
}

/// How far weights are from the deformation, in diagonals: as posed, and with poses that they were not made with.
#[track_caller]
fn check(rig: &Rig, what: &str) -> Weights {
    let mut binding = Binding::masked(&rig.wires, &rig.points, &rig.masks()).unwrap();
    let weights = binding.weights(&rig.wires, &rig.blend).unwrap();
    assert_eq!(weights.point_count(), rig.points.len());
    assert_eq!(weights.of(rig.points.len()), []);
    let mut random = Random::new(7);
    let mut wires = rig.wires.clone();
    let mut out = vec![[0.0; 3]; rig.points.len()];
    for round in 0..3 {
        binding.deform_into(&wires, &rig.blend, &mut out).unwrap();
        let diagonal = Rig { wires: wires.clone(), ..rig.clone() }.diagonal();
        let own = moved(&weights, &wires, &rig.points);
        for ((i, weighed), deformed) in own.iter().enumerate().zip(&out) {
            let off = weighed.distance(wide(*deformed)) / diagonal;
            assert!(off < OFF, "{what}, pose {round}, point {i}: {off:e}\n{:#?}", rig.wires);
        }
        for wire in &mut wires {
            for point in &mut wire.pose {
                let step = DVec3::from_array(random.vector(0.2 * rig.diagonal()));
                *point = (wide(*point) + step).as_vec3().to_array();
            }
        }
    }
    weights
}

#[test]
fn weights_are_what_random_rigs_do() {
    let (mut open, mut closed, mut several, mut blended) = (0, 0, 0, 0);
    for seed in 0..240 {
        let rig = tamed(Rig::new(seed));
        let weights = check(&rig, &format!("seed {seed}"));
        for wire in &rig.wires {
            *(if wire.reference.closed() { &mut closed } else { &mut open }) += 1;
            blended += usize::from(wire.closest != Closest::Smallest);
        }
        let wires_of = |point: usize| {
            let mut wires: Vec<u32> = weights.of(point).iter().map(|part| part.wire).collect();
            wires.dedup();
            wires.len()
        };
        several += (0..rig.points.len()).filter(|point| wires_of(*point) > 1).count();
    }
    assert!(
        open > 200 && closed > 100 && several > 1000 && blended > 50,
        "{open} {closed} {several} {blended}"
    );
}

/// A wire along x, and points about it.
fn line(kind: CurveKind, count: usize) -> Rig {
    let x = |i: usize| 2.0 * i as f32 / (count.max(2) - 1) as f32 - 1.0;
    let points = (0..count).map(|i| [x(i), 0.0, 0.0]).collect();
    let mut wire = Wire::new(Curve::new(kind, false, points).unwrap());
    wire.rotation = 0.0;
    wire.pose.iter_mut().enumerate().for_each(|(i, p)| p[1] = 0.3 + 0.1 * i as f32);
    let cell = |i: usize| i as f32 / 10.0 - 1.5;
    let points = (0..31 * 31).map(|i| [cell(i % 31), 0.0, cell(i / 31)]).collect();
    Rig { wires: vec![wire], blend: Blend::default(), points, masks: vec![None] }
}

#[test]
fn a_point_has_as_many_weights_as_the_degree_and_one_more() {
    for (kind, count, most) in [
        (CurveKind::Polyline, 5, 2),
        (CurveKind::BSpline { degree: 1 }, 5, 2),
        (CurveKind::BSpline { degree: 2 }, 5, 3),
        (CurveKind::BSpline { degree: 3 }, 7, 4),
        (CurveKind::Bezier, 7, 4),
        // With too few points the degree is lower; one point is no curve.
        (CurveKind::BSpline { degree: 3 }, 3, 3),
        (CurveKind::CatmullRom, 1, 1),
    ] {
        let rig = line(kind, count);
        let weights = check(&rig, &format!("{kind:?}"));
        let found = (0..rig.points.len()).map(|i| weights.of(i).len()).max().unwrap();
        assert_eq!(found, most, "{kind:?}");
        for (i, p) in rig.points.iter().enumerate() {
            let sum: f64 = weights.of(i).iter().map(|part| part.weight).sum();
            let f = rig.wires[0].density.at(f64::from(p[2].hypot((p[0].abs() - 1.0).max(0.0))));
            // Of one point the distance is another.
            assert!(count == 1 || (sum - f).abs() < 1e-6, "{kind:?} {p:?}: {sum} for F = {f}");
            assert!(weights.of(i).iter().all(|part| part.weight > 0.0));
        }
    }
}

#[test]
fn locators_domains_directions_and_amplitudes_are_in_the_weights() {
    let mut rig = line(CurveKind::BSpline { degree: 2 }, 5);
    let at = |u, radius, amplitude| Locator { u, radius, amplitude, ..Locator::default() };
    rig.wires[0].locators =
        vec![at(0.1, Some(0.2), Some(0.2)), at(0.6, Some(1.4), None), at(0.9, None, Some(1.7))];
    rig.wires[0].direction = Some([0.0, 0.3, 1.0]);
    let aside = Curve::polyline(vec![[-1.5, 0.0, 0.5], [1.5, 0.0, 0.4]]).unwrap();
    for bounds in [Bounded::Influence, Bounded::Amplitude] {
        rig.wires[0].domains = vec![Domain { delta: 0.4, bounds, ..Domain::new(aside.clone()) }];
        let weights = check(&rig, &format!("{bounds:?}"));
        assert!((0..rig.points.len()).any(|i| !weights.of(i).is_empty()));
    }
}

#[test]
fn wires_of_a_group_and_wires_that_do_not_meet_need_no_blend() {
    let mut rig = line(CurveKind::Polyline, 3);
    let mut other = rig.wires[0].clone();
    other.reference =
        other.reference.posed(vec![[-1.0, 0.0, 0.6], [0.0, 0.0, 0.6], [1.0, 0.0, 0.6]]).unwrap();
    rig.wires.push(other);
    rig.masks.push(None);
    let told = Binding::new(&rig.wires, &rig.points).unwrap().weights(&rig.wires, &rig.blend);
    assert!(matches!(told, Err(WeightsError::Blend { wires: [0, 1], .. })), "{told:?}");
    for blend in [Blend { localize: 1.0, ..rig.blend }, Blend { crossing: 1.0, localize: 0.4, ..rig.blend }] {
        check(&Rig { blend, ..rig.clone() }, &format!("{blend:?}"));
    }
    rig.wires.iter_mut().for_each(|wire| wire.group = Some(3));
    check(&rig, "a group");
    rig.wires.iter_mut().for_each(|wire| (wire.group, wire.radius) = (None, 0.29));
    check(&rig, "apart");
}

#[test]
fn a_pinned_blend_has_its_own_shares() {
    let mut rig = line(CurveKind::Polyline, 3);
    let mut other = rig.wires[0].clone();
    other.reference =
        other.reference.posed(vec![[0.0, 0.0, -1.0], [0.0, 0.0, 0.1], [0.0, 0.0, 1.0]]).unwrap();
    other.amplitude = 0.7;
    rig.wires.push(other);
    rig.masks.push(None);
    rig.blend = Blend { localize: 1.0, pinned: true, ..Blend::default() };
    check(&rig, "pinned");
}

#[test]
fn what_does_more_than_translate_is_told() {
    let told = |change: &dyn Fn(&mut Wire)| {
        let mut rig = line(CurveKind::BSpline { degree: 2 }, 5);
        change(&mut rig.wires[0]);
        Binding::new(&rig.wires, &rig.points).unwrap().weights(&rig.wires, &rig.blend).unwrap_err()
    };
    let attribute = |locator, attribute, found, expected| WeightsError::Attribute {
        wire: 0,
        locator,
        attribute,
        found,
        expected,
    };
    assert_eq!(told(&|wire| wire.rotation = 1.0), attribute(None, "rotation", 1.0, 0.0));
    assert_eq!(told(&|wire| wire.scale = 0.9), attribute(None, "scale", 0.9, 1.0));
    assert_eq!(told(&|wire| wire.twist = 2.0), attribute(None, "twist", 2.0, 0.0));
    let locator = |rotation| Locator { u: 0.5, rotation: Some(rotation), ..Locator::default() };
    let second = attribute(Some(1), "rotation", 0.5, 0.0);
    assert_eq!(told(&|wire| wire.locators = vec![locator(0.0), locator(0.5)]), second);
    let by_length = told(&|wire| wire.correspondence = Correspondence::ArcLength);
    assert_eq!(by_length, WeightsError::ArcLength { wire: 0 });
    let through = |wire: &mut Wire| {
        let points = wire.reference.points().to_vec();
        wire.reference = Curve::new(CurveKind::CatmullRom, false, points).unwrap();
    };
    assert_eq!(told(&through), WeightsError::CatmullRom { wire: 0 });
    let mut rig = line(CurveKind::Polyline, 3);
    // Where locators carry it the wire's own has no say.
    rig.wires[0].rotation = 1.0;
    rig.wires[0].locators = vec![locator(0.0)];
    check(&rig, "overridden");
    let mut binding = Binding::new(&rig.wires, &rig.points).unwrap();
    assert!(matches!(binding.weights(&[], &rig.blend), Err(WeightsError::Bind(_))));
}
