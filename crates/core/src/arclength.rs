//! Arc length of a curve and its inverse, to rounding: §2 names the correspondence by arc length, and locators of
//! later effects are spread by it.

use crate::spans::{Cubic, Spans};

/// Nodes and weights of Gauss and Legendre's rule of eight points on `[−1, 1]`.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// The rule is applied to halves until they agree with the whole to this part of the segment's length; beyond it
/// only rounding is left.
const TOLERANCE: f64 = 1e-12;

/// A cusp, where the speed has a kink, is halved this often and no more: the rest is `2⁻²⁴` of the segment.
const DEPTH: u32 = 24;

/// Length of a segment from `t0` to `t1`.
pub(crate) fn length(cubic: &Cubic, t0: f64, t1: f64) -> f64 {
    if cubic.0[2] == glam::DVec3::ZERO && cubic.0[3] == glam::DVec3::ZERO {
        return (t1 - t0) * cubic.0[1].length();
    }
    let bound = cubic.speed_bound() * (t1 - t0).abs();
    adaptive(cubic, t0, t1, gauss(cubic, t0, t1), bound * TOLERANCE, DEPTH)
}

fn gauss(cubic: &Cubic, t0: f64, t1: f64) -> f64 {
    let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
    let speed = |x: f64| cubic.derivative(middle + half * x).length();
    half * GAUSS.iter().map(|&(x, w)| w * (speed(x) + speed(-x))).sum::<f64>()
}

fn adaptive(cubic: &Cubic, t0: f64, t1: f64, whole: f64, tolerance: f64, depth: u32) -> f64 {
    let middle = 0.5 * (t0 + t1);
    let (left, right) = (gauss(cubic, t0, middle), gauss(cubic, middle, t1));
    let miss = (left + right - whole).abs();
    if depth == 0 || miss <= tolerance || miss.is_nan() {
        return left + right;
    }
    adaptive(cubic, t0, middle, left, 0.5 * tolerance, depth - 1)
        + adaptive(cubic, middle, t1, right, 0.5 * tolerance, depth - 1)
}

/// Arc length from the start of a curve to each joint, in curve units.
#[derive(Clone, Debug, Default)]
pub(crate) struct ArcLength {
    /// `spans + 1` values, from 0 to the whole length.
    joints: Vec<f64>,
}

impl ArcLength {
    pub(crate) fn new(spans: &Spans) -> Self {
        let mut lengths = Self::default();
        lengths.build(spans);
        lengths
    }

    /// Measures `spans` into the buffer that is already there.
    pub(crate) fn build(&mut self, spans: &Spans) {
        self.joints.clear();
        self.joints.push(0.0);
        let mut sum = 0.0;
        for cubic in &spans.cubics {
            sum += length(cubic, 0.0, 1.0);
            self.joints.push(sum);
        }
    }

    pub(crate) fn total(&self) -> f64 {
        self.joints.last().copied().unwrap_or(0.0)
    }

    /// Length from the start of the curve to joint `joint`.
    pub(crate) fn at_joint(&self, joint: usize) -> f64 {
        self.joints[joint]
    }

    /// Length from the start of the curve to `t` in segment `span`.
    pub(crate) fn at(&self, spans: &Spans, span: usize, t: f64) -> f64 {
        self.joints[span] + length(&spans.cubics[span], 0.0, t)
    }

    /// The segment and place where the length from the start is `s`.
    pub(crate) fn inverse(&self, spans: &Spans, s: f64) -> (usize, f64) {
        let n = spans.cubics.len();
        let span = self.joints.partition_point(|&x| x <= s).clamp(1, n) - 1;
        let target = s - self.joints[span];
        let whole = self.joints[span + 1] - self.joints[span];
        if target <= 0.0 || whole <= 0.0 {
            return (span, 0.0);
        }
        if target >= whole {
            return (span, 1.0);
        }
        (span, inverse_in(&spans.cubics[span], target, whole))
    }
}

/// Newton's method on the length, kept inside a bracket that shrinks by halves where it would leave it.
fn inverse_in(cubic: &Cubic, target: f64, whole: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = target / whole;
    let mut reached = length(cubic, 0.0, t);
    for _ in 0..60 {
        let error = reached - target;
        if error.abs() <= 1e-13 * whole {
            break;
        }
        if error > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let speed = cubic.derivative(t).length();
        let newton = t - error / speed;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == t {
            break;
        }
        reached += length(cubic, t.min(next), t.max(next)).copysign(next - t);
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;

    #[test]
    fn a_parabola_has_its_closed_form() {
        // y = x² from 0 to 1 as a quadratic Bézier, raised to a B-spline of degree 2.
        let curve = Curve::bspline(2, vec![[0.0; 3], [0.5, 0.0, 0.0], [1.0, 1.0, 0.0]]).unwrap();
        let spans = Spans::new(&curve);
        let exact = 0.5 * 5.0_f64.sqrt() + 0.25 * 2.0_f64.asinh();
        assert!((ArcLength::new(&spans).total() - exact).abs() < 1e-12);
    }

    #[test]
    fn a_cusp_is_measured_too() {
        // x = t² from both sides of 0: goes back on itself.
        let curve = Curve::bspline(2, vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).unwrap();
        assert!((ArcLength::new(&Spans::new(&curve)).total() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn inverse_undoes_the_length() {
        let points = vec![[0.0; 3], [1.0, 3.0, 0.0], [2.0, -3.0, 1.0], [2.0, 0.0, 0.0], [9.0, 0.0, 4.0]];
        let spans = Spans::new(&Curve::bspline(3, points).unwrap());
        let lengths = ArcLength::new(&spans);
        for i in 0..=50 {
            let s = lengths.total() * f64::from(i) / 50.0;
            let (span, t) = lengths.inverse(&spans, s);
            assert!((lengths.at(&spans, span, t) - s).abs() < 1e-10 * lengths.total());
        }
    }
}
