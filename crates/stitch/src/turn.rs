//! How much of the bend from `R′` to `W′` a surface may follow without folding over itself.
//!
//! A wire turns what lies `v` off it by `θ·F`. Where `θ` changes along the wire by more than `1 / (v·F)` a length, as at the ends of a tear,
//! rows of the surface pass each other. So there the rotation is held back, to nothing in the worst case, which shears the surface instead.
//! What is held back fades over about a radius to both sides, so that it shows no end.

use glam::{DQuat, DVec3};
use wirework_core::Curve;

use crate::side::Side;

/// The most that rows may be pushed together: of `dθ/ds·v·F`, of which 1 is a fold.
const TIGHTEST: f64 = 0.7;
/// The largest `x·f(x)`, of the paper's quartic; other densities differ little.
const REACH: f64 = 0.286;

/// The factor on the rotation at each vertex of an edge, 0 to 1; none where all of it may be followed.
pub(crate) fn rotations(side: &Side, pose: &Curve, radius: f64) -> Option<Vec<f64>> {
    let most = TIGHTEST / (REACH * radius);
    let tangents = pose.at(side.parameters());
    let bends: Vec<DVec3> = side
        .frames
        .iter()
        .zip(&tangents)
        .map(|(frame, (_, along))| bend(frame.along, (*along).into()))
        .collect();
    let count = bends.len();
    let segments = side.track.path.segments();
    let lengths: Vec<f64> = (0..segments).map(|i| side.own[i].distance(side.own[(i + 1) % count])).collect();
    let allowed = |i: usize| {
        let change = bends[i].distance(bends[(i + 1) % count]);
        if change > most * lengths[i] { most * lengths[i] / change } else { 1.0 }
    };
    let allowed: Vec<f64> = (0..segments).map(allowed).collect();
    if allowed.iter().all(|share| *share >= 1.0) {
        return None;
    }
    let mut out = vec![1.0_f64; count];
    for (i, share) in allowed.iter().enumerate() {
        for end in [i, (i + 1) % count] {
            out[end] = out[end].min(*share);
        }
    }
    // Lowest first along the edge, then back; twice, so that on a loop it goes all round.
    let closed = side.track.path.closed;
    for _ in 0..=usize::from(closed) {
        for i in 0..segments {
            let next = (i + 1) % count;
            out[next] = out[next].min(out[i] + lengths[i] / radius);
        }
        for i in (0..segments).rev() {
            let next = (i + 1) % count;
            out[i] = out[i].min(out[next] + lengths[i] / radius);
        }
    }
    Some(out)
}

/// The rotation vector of the least rotation from one direction to another.
fn bend(from: DVec3, to: DVec3) -> DVec3 {
    if from == DVec3::ZERO || to == DVec3::ZERO {
        return DVec3::ZERO;
    }
    DQuat::from_rotation_arc(from, to).to_scaled_axis()
}
