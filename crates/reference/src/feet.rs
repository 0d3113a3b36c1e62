//! `closest: Blended(width)`: several feet of one point, and what each counts. \[SF98\] §6 leaves the step across the medial
//! axis open.
//!
//! By flooding: the local minima of the distance along the curve are valleys. Water rises from the deepest floor to `width`
//! above it. Under water up to `h` a valley with floor `a` weighs `B(h − a)`, `B(s) = q / (1 − q)`, `q = t²(3 − 2t)`, `t = s
//! / (2 width)`. Where two pools meet, at `s`, their feet share the new pool as the pools weighed, and it weighs the sum;
//! what that is more than its deepest valley alone fades as `1 − 3x² + 2x³`, `x = (h − s) / width`. At the top a pool has its
//! weight in parts of all.
//!
//! # Corner cases
//!
//! - Minima with no ridge between them, as at coincident control points, are one.
//! - Of more than 64 feet each share is lessened by that of the 65th, so that no more are left and none steps.

use crate::curve::Place;
use crate::foot::{Foot, Samples};
use glam::DVec3;
use wirework_core::{Closest, Curve};

/// The feet of `p` that count, by rising `u`, and their shares, which sum to 1.
pub fn feet(curve: &Curve, closest: Closest, p: [f64; 3]) -> Vec<(Foot, f64)> {
    shares(&Samples::new(curve), closest, DVec3::from_array(p))
}

pub(crate) fn shares(samples: &Samples, closest: Closest, p: DVec3) -> Vec<(Foot, f64)> {
    let width = match closest {
        Closest::Blended(width) if p.is_finite() => f64::from(width),
        _ => return vec![(samples.closest(p), 1.0)],
    };
    let mut minima = samples.minima(p);
    if minima.len() < 2 {
        return vec![(samples.closest(p), 1.0)];
    }
    minima.sort_by(|a, b| a.0.u(&samples.curve).total_cmp(&b.0.u(&samples.curve)));
    let minima = parted(samples, p, minima);
    let floors: Vec<f64> = minima.iter().map(|m| m.1).collect();
    let shares = flood(&floors, &passes(samples, p, &minima), width);
    let feet = minima.iter().zip(shares).filter(|(_, share)| *share > 0.0);
    feet.map(|(&(place, distance), share)| (samples.foot(p, place, distance), share)).collect()
}

/// A ridge parts two minima where it stands out by more than this part of the largest coordinate: by more than the
/// rounding of float64.
const RIDGE: f64 = 1e-13;

/// Of minima with no ridge between them only the nearer; of equal ones that of the smaller `u`.
fn parted(samples: &Samples, p: DVec3, mut minima: Vec<(Place, f64)>) -> Vec<(Place, f64)> {
    let nothing = RIDGE * samples.extent(p);
    let mut i = 0;
    while minima.len() > 1 && i < minima.len() {
        let next = (i + 1) % minima.len();
        let pass = passes(samples, p, &minima)[i];
        if pass - minima[i].1.max(minima[next].1) > nothing {
            i += 1;
            continue;
        }
        let (first, second) = (i.min(next), i.max(next));
        let gone = if minima[second].1 < minima[first].1 - nothing { first } else { second };
        minima.remove(gone);
        i = 0;
    }
    minima
}

/// The highest ridge between each valley and the next one; after the last that round to the first, infinite on an open curve.
fn passes(samples: &Samples, p: DVec3, minima: &[(Place, f64)]) -> Vec<f64> {
    let u = |place: Place| place.u(&samples.curve);
    let ridges: Vec<(f64, f64)> = samples.ridges(p).into_iter().map(|(place, d)| (u(place), d)).collect();
    let highest = |on_the_way: &dyn Fn(f64) -> bool| {
        ridges.iter().filter(|(u, _)| on_the_way(*u)).map(|r| r.1).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut passes: Vec<f64> = minima
        .windows(2)
        .map(|pair| highest(&|at| u(pair[0].0) < at && at < u(pair[1].0)).max(pair[0].1.max(pair[1].1)))
        .collect();
    let (first, last) = (minima[0], minima[minima.len() - 1]);
    let round = highest(&|at| at < u(first.0) || at > u(last.0)).max(first.1.max(last.1));
    passes.push(if samples.curve.closed() { round } else { f64::INFINITY });
    passes
}

/// Valleys that the water has made one.
struct Pool {
    /// Each valley and its share of the pool.
    members: Vec<(usize, f64)>,
    floor: f64,
    /// What it weighed more than its deepest valley when it came to be, and the level then.
    excess: f64,
    since: f64,
}

impl Pool {
    fn weight(&self, level: f64, width: f64) -> f64 {
        let x = ((level - self.since) / width).clamp(0.0, 1.0);
        alone(level - self.floor, width) + self.excess * (1.0 - 3.0 * x * x + 2.0 * x * x * x)
    }
}

/// The share of each valley.
fn flood(floors: &[f64], passes: &[f64], width: f64) -> Vec<f64> {
    let single =
        |(i, &floor): (usize, &f64)| Pool { members: vec![(i, 1.0)], floor, excess: 0.0, since: floor };
    let mut pools: Vec<Pool> = floors.iter().enumerate().map(single).collect();
    let top = floors.iter().copied().fold(f64::INFINITY, f64::min) + width;
    let mut order: Vec<usize> = (0..passes.len()).filter(|&i| passes[i] < top).collect();
    order.sort_by(|&a, &b| passes[a].total_cmp(&passes[b]));
    for pass in order {
        let holds = |valley: usize| pools.iter().position(|pool| pool.members.iter().any(|m| m.0 == valley));
        let (Some(a), Some(b)) = (holds(pass), holds((pass + 1) % floors.len())) else { continue };
        if a != b {
            let (a, b) = (pools.swap_remove(a.max(b)), pools.swap_remove(a.min(b)));
            pools.push(meet(&a, &b, passes[pass], width));
        }
    }
    let sum: f64 = pools.iter().map(|pool| pool.weight(top, width)).sum();
    let mut shares = vec![0.0; floors.len()];
    for pool in &pools {
        for &(valley, part) in &pool.members {
            shares[valley] = part * pool.weight(top, width) / sum;
        }
    }
    limited(shares)
}

fn meet(a: &Pool, b: &Pool, level: f64, width: f64) -> Pool {
    let (weight_a, weight_b) = (a.weight(level, width), b.weight(level, width));
    let sum = weight_a + weight_b;
    let part = |weight: f64| if sum > 0.0 { weight / sum } else { 0.5 };
    let of_a = a.members.iter().map(|&(i, share)| (i, share * part(weight_a)));
    let of_b = b.members.iter().map(|&(i, share)| (i, share * part(weight_b)));
    let floor = a.floor.min(b.floor);
    Pool {
        members: of_a.chain(of_b).collect(),
        floor,
        excess: sum - alone(level - floor, width),
        since: level,
    }
}

/// `B`.
fn alone(depth: f64, width: f64) -> f64 {
    let t = 0.5 * (depth / width).clamp(0.0, 1.0);
    let q = t * t * (3.0 - 2.0 * t);
    q / (1.0 - q)
}

/// No more than 64 shares above 0.
fn limited(shares: Vec<f64>) -> Vec<f64> {
    const MOST: usize = 64;
    let mut falling = shares.clone();
    falling.sort_by(|a, b| b.total_cmp(a));
    let Some(&next) = falling.get(MOST) else { return shares };
    let lessened: Vec<f64> = shares.iter().map(|share| (share - next).max(0.0)).collect();
    let sum: f64 = lessened.iter().sum();
    if sum > 0.0 { lessened.into_iter().map(|share| share / sum).collect() } else { shares }
}
