//! `closest: Blended(width)`: several feet of one point, and what each counts. \[SF98\] §6 leaves the step across the
//! medial axis open.
//!
//! Foot `i`, a local minimum of the distance `dᵢ`, weighs `a((dᵢ − min d) / width)·ρᵢ`, with
//! - `a(x) = q / (1 − q)`, `q = t²(3 − 2t)`, `t = (1 − x) / 2`: 1 for the nearest, 0 from `width` farther on;
//! - `ρᵢ = min B(Sᵢⱼ − dᵢ) / B(Sᵢⱼ − dⱼ)` over the nearer feet `j`, `B(s) = x(2 − x)`, `x = min(s / width, 1)`, and `Sᵢⱼ`
//!   the greatest distance between the two along the curve, round a closed one on the way where it is less.
//!
//! # Why no weight steps
//!
//! A minimum `i` comes and goes together with a maximum beside it, beyond which the distance falls to a nearer foot
//! `k`: there `Sᵢₖ − dᵢ` is 0 and `Sᵢₖ − dₖ` is not. No other foot `l` misses `i`: where it is farther than `i`,
//! `Sₗᵢ = Sₗₖ`, since `S` is an ultrametric and `Sᵢₖ = dᵢ` less than both, and so `k` bounds `ρₗ` by less than `i` does. Where
//! two feet change order their ratio is 1. At a cusp of the evolute `k` comes and goes too, and `ρ` is 0 / 0.
//!
//! # Corner cases
//!
//! Two minima with no ridge between them, as at coincident control points, are one: the nearer, of equal ones that of the
//! smaller `u`.

use crate::curve::Place;
use crate::foot::{Foot, Samples};
use glam::DVec3;
use wirework_core::{Closest, Curve};

/// A ridge parts two minima where it stands out by more than this part of the largest coordinate: by more than the
/// rounding of float64.
const RIDGE: f64 = 1e-13;

/// The feet of `p` that count, by rising `u`, and their shares, which sum to 1.
pub fn feet(curve: &Curve, closest: Closest, p: [f64; 3]) -> Vec<(Foot, f64)> {
    shares(&Samples::new(curve), closest, DVec3::from_array(p))
}

pub(crate) fn shares(samples: &Samples, closest: Closest, p: DVec3) -> Vec<(Foot, f64)> {
    let width = match closest {
        Closest::Blended(width) if p.is_finite() => f64::from(width),
        _ => return vec![(samples.closest(p), 1.0)],
    };
    let minima = samples.minima(p);
    if minima.len() < 2 {
        return vec![(samples.closest(p), 1.0)];
    }
    let landscape = Landscape::new(samples, p, minima);
    let weights = landscape.weights(width);
    let sum: f64 = weights.iter().sum();
    let feet = landscape.feet.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
    feet.map(|(foot, weight)| (foot, weight / sum)).collect()
}

/// The distance along a curve, from one point.
struct Landscape {
    /// Local minima that a ridge parts from each other, by rising `u`.
    feet: Vec<Foot>,
    /// `u` and distance wherever the distance may be greatest.
    ridges: Vec<(f64, f64)>,
    closed: bool,
}

impl Landscape {
    fn new(samples: &Samples, p: DVec3, minima: Vec<(Place, f64)>) -> Self {
        let ridges = samples.ridges(p).into_iter().map(|(place, d)| (place.u(&samples.curve), d)).collect();
        let mut landscape = Self { feet: Vec::new(), ridges, closed: samples.curve.closed() };
        let nothing = RIDGE * samples.extent(p);
        for (place, distance) in minima {
            let new = samples.foot(p, place, distance);
            let parted = |old: &Foot| landscape.pass(old, &new) - old.distance.max(distance) > nothing;
            match landscape.feet.iter().position(|old| !parted(old)) {
                Some(i) if distance < landscape.feet[i].distance - nothing => landscape.feet[i] = new,
                Some(_) => {}
                None => landscape.feet.push(new),
            }
        }
        landscape
    }

    /// `S`: the greatest distance on the way from one foot to another.
    fn pass(&self, a: &Foot, b: &Foot) -> f64 {
        let (low, high) = (a.u.min(b.u), a.u.max(b.u));
        let highest = |on_the_way: &dyn Fn(f64) -> bool| {
            let ridges = self.ridges.iter().filter(|(u, _)| on_the_way(*u)).map(|r| r.1);
            ridges.fold(a.distance.max(b.distance), f64::max)
        };
        let between = highest(&|u| low < u && u < high);
        if self.closed { between.min(highest(&|u| u < low || u > high)) } else { between }
    }

    fn weights(&self, width: f64) -> Vec<f64> {
        let least = self.feet.iter().map(|foot| foot.distance).fold(f64::INFINITY, f64::min);
        let weight = |foot: &Foot| {
            let nearer = self.feet.iter().filter(|other| other.distance < foot.distance);
            let steep = nearer.map(|other| {
                let pass = self.pass(foot, other);
                barrier((pass - foot.distance) / width) / barrier((pass - other.distance) / width)
            });
            nearness((foot.distance - least) / width) * steep.fold(1.0, f64::min)
        };
        self.feet.iter().map(weight).collect()
    }
}

/// `a`.
fn nearness(x: f64) -> f64 {
    let t = 0.5 * (1.0 - x.min(1.0));
    let q = t * t * (3.0 - 2.0 * t);
    q / (1.0 - q)
}

/// `B`.
fn barrier(x: f64) -> f64 {
    let x = x.min(1.0);
    x * (2.0 - x)
}
