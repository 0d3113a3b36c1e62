//! A closed tube round a chain, and what can be measured on it.

use glam::DVec3;
use wirework_core::{Binding, Blend, Wire};
use wirework_ik::{Ik, Limb};

pub(crate) const SIDES: usize = 24;

/// Rings of points round a straight chain along X from 0, of this length and radius.
pub(crate) fn rings(length: f32, radius: f32, count: usize) -> Vec<[f32; 3]> {
    let ring = |i: usize| {
        let x = length * i as f32 / (count - 1) as f32;
        (0..SIDES).map(move |j| {
            let angle = std::f32::consts::TAU * j as f32 / SIDES as f32;
            [x, radius * angle.cos(), radius * angle.sin()]
        })
    };
    (0..count).flat_map(ring).collect()
}

pub(crate) fn double(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// The points as a limb moves them.
pub(crate) fn moved(limb: &Limb, goal: [f64; 3], points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (mut wire, mut out) = (limb.wire(), points.to_vec());
    let mut binding = Binding::new(std::slice::from_ref(&wire), points).unwrap();
    limb.wire_into(&limb.pose(goal, 0.0), 0.0, &mut wire);
    deform(&mut binding, &wire, &mut out);
    out
}

pub(crate) fn deform(binding: &mut Binding, wire: &Wire, out: &mut [[f32; 3]]) {
    binding.deform_into(std::slice::from_ref(wire), &Blend::default(), out).unwrap();
}

/// The middle of each ring.
pub(crate) fn centers(points: &[[f32; 3]]) -> Vec<DVec3> {
    points.chunks(SIDES).map(|ring| ring.iter().map(|p| double(*p)).sum::<DVec3>() / SIDES as f64).collect()
}

/// The volume that rings enclose, both ends closed by fans round their middles.
pub(crate) fn volume(points: &[[f32; 3]]) -> f64 {
    let middles = centers(points);
    let p = |ring: usize, side: usize| double(points[ring * SIDES + side % SIDES]);
    let signed = |a: DVec3, b: DVec3, c: DVec3| a.dot(b.cross(c)) / 6.0;
    let mut sum = 0.0;
    for ring in 1..middles.len() {
        for side in 0..SIDES {
            let [a, b, c, d] = [p(ring - 1, side), p(ring - 1, side + 1), p(ring, side + 1), p(ring, side)];
            sum += signed(a, b, c) + signed(a, c, d);
        }
    }
    for side in 0..SIDES {
        let last = middles.len() - 1;
        sum += signed(middles[0], p(0, side + 1), p(0, side));
        sum += signed(middles[last], p(last, side), p(last, side + 1));
    }
    sum.abs()
}

/// The sum of the distances between neighbours.
pub(crate) fn length(path: &[DVec3]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Three bones of length 1 along X.
pub(crate) const JOINTS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];

pub(crate) fn limb(settings: &Ik) -> Limb {
    Limb::new(&JOINTS, settings).unwrap()
}
