use pulp::WithSimd;

use super::*;
use crate::{Bend, Bounded, Closest, Correspondence, Curve, CurveKind, Domain, Locator};

/// Wires that take every road through search and kernel.
fn wires() -> Vec<Wire> {
    let point = |i: u8, side: f32| {
        let a = f32::from(i) * 0.7;
        [a.cos() + 0.1 * f32::from(i), 0.2 * side * a.sin(), a.sin() * side]
    };
    let wire = |kind, closed, side| {
        let curve = Curve::new(kind, closed, (0..7).map(|i| point(i, side)).collect()).unwrap();
        let mut wire = Wire { scale: 1.3, twist: 0.4, radius: 1.1, ..Wire::new(curve) };
        for (i, p) in wire.pose.iter_mut().enumerate() {
            p[1] += 0.3 + 0.1 * i as f32;
        }
        wire
    };
    let mut bounded = wire(CurveKind::BSpline { degree: 3 }, false, 1.0);
    let domain = Curve::polyline(vec![[-2.0, 0.3, 0.9], [2.0, 0.1, 0.9]]).unwrap();
    bounded.domains = [Bounded::Influence, Bounded::Twist, Bounded::Scale]
        .map(|bounds| Domain { bounds, delta: 0.3, ..Domain::new(domain.clone()) })
        .to_vec();
    bounded.direction = Some([0.1, 1.0, 0.3]);
    let twist = |u, twist| Locator { u, twist: Some(twist), ..Locator::default() };
    bounded.locators = vec![twist(0.2, 0.0), twist(0.7, 3.0)];
    let blended =
        Wire { closest: Closest::Blended(0.5), ..wire(CurveKind::BSpline { degree: 2 }, true, -1.0) };
    let transported = Wire {
        bend: Bend::Transport,
        correspondence: Correspondence::ArcLength,
        exponent: Some(-1.5),
        ..wire(CurveKind::CatmullRom, false, 0.8)
    };
    vec![bounded, blended, transported, wire(CurveKind::Polyline, false, -0.6)]
}

#[test]
fn one_number_at_a_time_gives_the_same_bits() {
    let wires = wires();
    let points: Vec<[f32; 3]> = (0..50_u16 * 50)
        .map(|i| [f32::from(i % 50) * 0.06 - 1.2, 0.05, f32::from(i / 50) * 0.06 - 1.5])
        .collect();
    let blend = Blend { crossing: 0.2, localize: 0.3, locality: 1.5, ..Blend::default() };
    let mut binding = Binding::new(&wires, &points).unwrap();
    let mut fast = points.clone();
    binding.deform_into(&wires, &blend, &mut fast).unwrap();
    assert!(points.iter().zip(&fast).filter(|(p, q)| p != q).count() > 1000);

    let mut slow = points.clone();
    let mut scratch: Scratch = (Vec::new(), None);
    for (index, (tile, out)) in binding.tiles.list.iter().zip(slow.chunks_mut(TILE)).enumerate() {
        let (bound, unit, scratch) = (&binding.wires[..], binding.unit, &mut scratch);
        let task = DeformTile { bound, wires: &wires, blend: &blend, unit, index, tile, scratch, out };
        task.with_simd(pulp::Scalar);
    }
    let bits = |points: &[[f32; 3]]| points.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&fast), bits(&slow));
    for bound in &binding.wires {
        let sought = bound.bound().sought;
        for (i, (tile, balls)) in binding.tiles.list.iter().zip(&binding.tiles.balls).enumerate() {
            let count = (points.len() - i * TILE).min(TILE);
            let [fast, slow] = [true, false].map(|fast| sought.both(tile, balls, count, fast));
            assert_eq!(fast, slow, "tile {i}");
        }
    }
}
