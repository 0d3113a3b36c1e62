//! Arc length, by quadrature, and the place at a fraction of it: `correspondence: ArcLength`, \[SF98\] §2.

use crate::curve::{Place, segment_count, slope};
use wirework_core::Curve;

/// The length of the whole curve.
pub fn length(curve: &Curve) -> f64 {
    Lengths::new(curve).total()
}

/// The `u` at `fraction` of the length; at a curve of length zero `None`.
pub fn at_length(curve: &Curve, fraction: f64) -> Option<f64> {
    Some(Lengths::new(curve).place(fraction)?.u(curve))
}

/// Cells a segment is cut into. A cell is short enough that the speed is smooth in it, but for a cusp, which
/// costs 1e-8 of the length at most.
const CELLS: usize = 64;

/// A place this near to a joint, in segments, is the joint. The lengths of `R` and `W` come from float32 points,
/// so where both have a corner the fraction hits it only within that rounding, and the tangent at the corner is
/// the mean of its sides.
const JOINT: f64 = 1e-6;

/// The length up to the end of each cell.
#[derive(Clone, Debug)]
pub(crate) struct Lengths {
    curve: Curve,
    /// `[0]` is 0, `[i]` the length of the first `i` cells.
    sums: Vec<f64>,
}

impl Lengths {
    pub(crate) fn new(curve: &Curve) -> Self {
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for segment in 0..segment_count(curve) {
            for cell in 0..CELLS {
                let edge = |i: usize| i as f64 / CELLS as f64;
                sum += measure(curve, segment, edge(cell), edge(cell + 1));
                sums.push(sum);
            }
        }
        Self { curve: curve.clone(), sums }
    }

    pub(crate) fn total(&self) -> f64 {
        self.sums[self.sums.len() - 1]
    }

    /// The fraction of the length at a place, 0 for a curve without length.
    pub(crate) fn fraction(&self, place: Place) -> f64 {
        let cell = ((place.t * CELLS as f64) as usize).min(CELLS - 1);
        let rest = measure(&self.curve, place.segment, cell as f64 / CELLS as f64, place.t);
        let sum = self.sums[place.segment * CELLS + cell] + rest;
        if self.total() > 0.0 { (sum / self.total()).min(1.0) } else { 0.0 }
    }

    /// The place at `fraction` of the length. Where the curve stands still there are many: the last, or at the very end
    /// the first, so that the tangent is one the curve moves along.
    pub(crate) fn place(&self, fraction: f64) -> Option<Place> {
        let total = self.total();
        if total <= 0.0 {
            return None;
        }
        let wanted = fraction * total;
        let before = |&sum: &f64| if wanted < total { sum <= wanted } else { sum < wanted };
        let cell = self.sums.partition_point(before).saturating_sub(1);
        let cell = cell.min(self.sums.len() - 2);
        let (segment, start) = (cell / CELLS, (cell % CELLS) as f64 / CELLS as f64);
        let (mut low, mut high) = (start, start + 1.0 / CELLS as f64);
        let mut t = 0.5 * (low + high);
        for _ in 0..STEPS {
            let missing = wanted - self.sums[cell] - measure(&self.curve, segment, start, t);
            *(if missing > 0.0 { &mut low } else { &mut high }) = t;
            let newton = t + missing / slope(&self.curve, Place { segment, t }).length();
            if (newton - t).abs() < SETTLED {
                break;
            }
            // Half the bracket where the step leaves it.
            t = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        }
        let t = if t < JOINT {
            0.0
        } else if t > 1.0 - JOINT {
            1.0
        } else {
            t
        };
        Some(Place { segment, t })
    }
}

/// At most so many steps to a place; halving alone takes a cell down to 1e-12 of a segment in as many.
const STEPS: usize = 34;

/// A step this small, in segments, is the last.
const SETTLED: f64 = 1e-14;

/// `∫ ‖C′‖ dt` by Gauss and Legendre, 8 points.
fn measure(curve: &Curve, segment: usize, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let speed = |t: f64| slope(curve, Place { segment, t }).length();
    let pair = |&(x, weight): &(f64, f64)| weight * (speed(middle - half * x) + speed(middle + half * x));
    half * GAUSS_8.iter().map(pair).sum::<f64>()
}

/// Abscissae and weights, both signs each.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
