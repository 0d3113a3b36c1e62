//! `closest: Blended(width)`: all feet of a point that count, with weights that make the deformation continuous where the closest
//! one jumps, on the medial axis of the curve. \[SF98\] §6 leaves this open.
//!
//! Along the curve the distance from the point rises and falls; the feet are its valleys, parted by ridges. Of two feet with
//! distances `d₁ ≤ d₂` the farther has the share `q(t) = t²(3 − 2t)`, `t = (1 − (d₂ − d₁)/width)/2`: a half on the medial axis, 0 where it is
//! `width` farther. That alone would step where a valley fills up and is none any more: there the ridge is no higher than the
//! valley. So with the ridge at `S` the farther foot's weight is also multiplied by `B(S − d₂) / B(S − d₁)`, which is 1 on the medial
//! axis, however low the ridge, and 0 where the valley ends; `B` does not grow beyond `width`, so that a high ridge leaves the weights
//! alone.
//!
//! Of several nearer feet the one that leaves the least counts. When one of these ends, it ends in the basin of a nearer one yet, which
//! lies behind the same ridge and leaves no more; so nothing steps then either.
//!
//! # Deviations
//!
//! At a cusp of the evolute two valleys and their ridge come together: ridge and distances are equal, and the weights of
//! both, which nothing defines there, are taken as they would be on the medial axis.

use glam::DVec3;

use crate::closest::Pieces;
use crate::piece::Piece;
use crate::quintic;

/// A foot that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weighted {
    pub(crate) span: u32,
    pub(crate) t: f64,
    pub(crate) distance: f64,
    /// Its share; those of a point's feet sum to 1.
    pub(crate) weight: f64,
}

/// Room for the valleys and ridges of one point.
#[derive(Debug, Default)]
pub(crate) struct Profile {
    valleys: Vec<Weighted>,
    /// The ridge before each valley, the highest of several; after the last valley one more.
    ridges: Vec<f64>,
    /// The ridge on the way back to each valley.
    back: Vec<f64>,
    /// [`FLAT`] in units of length.
    flat: f64,
}

/// Two valleys whose ridge is no higher than the higher one by this part of the coordinates are one: at a joint rounding may find
/// the same valley on both sides.
const FLAT: f64 = 1e-13;

fn is_flat(a: &Weighted, ridge: f64, b: &Weighted, flat: f64) -> bool {
    ridge <= a.distance.max(b.distance) + flat
}

impl Profile {
    /// The feet that count of a point `p` (relative to the curve's origin) whose closest foot is at distance `least`; the closest
    /// comes first.
    pub(crate) fn feet(&mut self, pieces: &Pieces, p: DVec3, least: f64) -> &[Weighted] {
        let width = pieces.width;
        self.survey(pieces, p, least + 2.0 * width);
        let count = self.valleys.len();
        let mut sum = 0.0;
        for i in 0..count {
            let x = (self.valleys[i].distance - least) / width;
            let weight =
                if x < 1.0 { nearness(x.max(0.0)) * self.standing(i, pieces.closed, width) } else { 0.0 };
            self.valleys[i].weight = weight;
            sum += weight;
        }
        self.valleys.retain(|valley| valley.weight > 0.0);
        self.valleys.iter_mut().for_each(|valley| valley.weight /= sum);
        let nearest =
            |(_, a): &(usize, &Weighted), (_, b): &(usize, &Weighted)| a.distance.total_cmp(&b.distance);
        if let Some((first, _)) = self.valleys.iter().enumerate().min_by(nearest) {
            self.valleys.swap(0, first);
        }
        &self.valleys
    }

    /// Valleys and ridges along the curve. What lies beyond the `horizon` is a ridge: as high as any that counts.
    fn survey(&mut self, pieces: &Pieces, p: DVec3, horizon: f64) {
        self.valleys.clear();
        self.ridges.clear();
        self.ridges.push(0.0);
        self.flat = FLAT * (p.length() + pieces.ball.radius);
        for piece in &pieces.list {
            if piece.chord_distance(p) - piece.stray > horizon {
                self.ridge(f64::INFINITY);
                continue;
            }
            let c = piece.coefficients(p);
            let starts_below = c[0] < 0.0;
            // Before an open curve starts everything falls towards it.
            let came_below = piece.before.is_none_or(|(a, b)| a - p.dot(b) < 0.0);
            match (came_below, starts_below) {
                (true, false) => self.valley(piece, p, 0.0),
                (false, true) => self.ridge(piece.cubic.at(0.0).distance(p)),
                _ => {}
            }
            quintic::roots(&c, &mut |s, rises| {
                if rises {
                    self.valley(piece, p, s);
                } else {
                    self.ridge(piece.cubic.at(s).distance(p));
                }
            });
            if piece.last && c[5] < 0.0 {
                self.valley(piece, p, 1.0);
            }
        }
        if pieces.closed {
            self.close();
        }
    }

    /// A valley where the curve closes is there once.
    fn close(&mut self) {
        let (Some(first), Some(last)) = (self.valleys.first(), self.valleys.last()) else { return };
        let ridge = self.ridges[0].max(self.ridges[self.valleys.len()]);
        if self.valleys.len() > 1 && is_flat(last, ridge, first, self.flat) {
            if last.distance < first.distance {
                self.valleys[0] = *last;
                self.ridges[1] = self.ridges[1].max(ridge);
                self.ridges[0] = 0.0;
            } else {
                self.ridges[0] = ridge;
            }
            self.valleys.pop();
            self.ridges.pop();
        }
    }

    fn valley(&mut self, piece: &Piece, p: DVec3, s: f64) {
        let (span, t) = piece.place(s);
        let valley = Weighted { span, t, distance: piece.cubic.at(s).distance(p), weight: 0.0 };
        let ridge = self.ridges.last().copied().unwrap_or_default();
        if let Some(last) = self.valleys.last_mut().filter(|last| is_flat(last, ridge, &valley, self.flat)) {
            if valley.distance < last.distance {
                // The ridge now lies before the valley.
                *last = valley;
                self.ridges.pop();
                self.ridge(ridge);
                self.ridges.push(0.0);
            }
        } else {
            self.valleys.push(valley);
            self.ridges.push(0.0);
        }
    }

    fn ridge(&mut self, height: f64) {
        if let Some(last) = self.ridges.last_mut() {
            *last = last.max(height);
        }
    }

    /// What nearer feet leave of the `i`-th valley.
    fn standing(&mut self, i: usize, closed: bool, width: f64) -> f64 {
        let (count, own) = (self.valleys.len(), self.valleys[i].distance);
        // The way back, and the way on; round a closed curve both lead everywhere, and the lower one counts.
        self.back.clear();
        self.back.resize(count, f64::INFINITY);
        let mut ridge: f64 = 0.0;
        for other in (0..i).rev() {
            ridge = ridge.max(self.ridges[other + 1]);
            self.back[other] = ridge;
        }
        ridge = ridge.max(self.ridges[0]).max(self.ridges[count]);
        for other in (i + 1..count).rev().filter(|_| closed) {
            self.back[other] = ridge;
            ridge = ridge.max(self.ridges[other]);
        }
        let mut least = f64::INFINITY;
        let mut ridge: f64 = 0.0;
        for step in 1..count {
            let other = (i + step) % count;
            if other == 0 {
                ridge =
                    if closed { ridge.max(self.ridges[count]).max(self.ridges[0]) } else { f64::INFINITY };
            } else {
                ridge = ridge.max(self.ridges[other]);
            }
            let (ridge, nearer) = (ridge.min(self.back[other]), self.valleys[other].distance);
            if nearer < own {
                least = least.min(ratio(ridge - own, ridge - nearer, width));
            }
        }
        least.min(1.0)
    }
}

/// The weight of a foot beside the closest, `x` widths farther: their shares are `q` and `1 − q`.
fn nearness(x: f64) -> f64 {
    let t = 0.5 * (1.0 - x);
    let q = t * t * (3.0 - 2.0 * t);
    q / (1.0 - q)
}

/// `B(own) / B(other)` of the heights of a ridge over two valleys, `own ≤ other`.
fn ratio(own: f64, other: f64, width: f64) -> f64 {
    let b = |s: f64| {
        let x = (s / width).clamp(0.0, 1.0);
        x * (2.0 - x)
    };
    if b(other) > 0.0 { b(own) / b(other) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spans::{Spans, to_dvec3};
    use crate::{Curve, CurveKind};

    fn feet(curve: &Curve, p: [f32; 3], width: f64) -> Vec<Weighted> {
        let pieces = Pieces::new(&Spans::new(curve), width);
        let mut block = pieces.block();
        block.push(to_dvec3(p));
        let least = curve.closest(p).unwrap().distance;
        Profile::default().feet(&pieces, block.at(0), f64::from(least)).to_vec()
    }

    /// Two legs a unit apart, joined at x = 0.
    fn hairpin() -> Curve {
        Curve::polyline(vec![[2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 1.0, 0.0]]).unwrap()
    }

    #[test]
    fn between_two_legs_the_nearer_has_its_share() {
        let halves = feet(&hairpin(), [1.5, 0.5, 0.0], 0.2);
        assert_eq!(halves.iter().map(|f| f.weight).collect::<Vec<_>>(), [0.5, 0.5]);
        // A quarter of the way from the medial axis to where the other leg is `width` farther; the bend's ridge is high.
        let feet = feet(&hairpin(), [1.5, 0.525, 0.0], 0.2);
        let t = 0.5 * (1.0 - 0.25_f64);
        assert!((feet[1].weight - t * t * (3.0 - 2.0 * t)).abs() < 1e-6, "{feet:?}");
        assert!((feet[0].span, feet[1].span) == (2, 0));
    }

    #[test]
    fn a_foot_alone_weighs_one() {
        for p in [[1.5, 0.4, 0.0], [1.5, -3.0, 0.0], [-1.0, 0.5, 0.0]] {
            let feet = feet(&hairpin(), p, 0.1);
            assert_eq!((feet.len(), feet[0].weight), (1, 1.0), "{p:?}");
        }
    }

    #[test]
    fn a_valley_on_a_joint_counts_once() {
        // A ring with a point twice; rounding finds the foot at the end of one segment and again at the start of the next.
        let (a, b) = (0.028_923_566, 0.020_452_049);
        let ring = [
            [a, 0.0],
            [a, 0.0],
            [1.771_057_6e-18, a],
            [-b, b],
            [-a, 3.542_115e-18],
            [-b, -b],
            [-5.313_173e-18, -a],
            [b, -b],
        ];
        let points = ring.iter().map(|p| [p[0], 0.0, p[1]]).collect();
        let curve = Curve::new(CurveKind::BSpline { degree: 2 }, true, points).unwrap();
        let feet = feet(&curve, [-0.005_222_310_3, 0.001_807_722_8, -0.005_222_310_3], 0.36);
        assert_eq!(feet.len(), 2, "{feet:?}");
    }

    #[test]
    fn where_the_curve_stands_still_there_is_no_ridge() {
        // Along this ring the distance falls, stands still at a double point, and falls on.
        let ring = [
            [-0.048_797_62, 0.193_252_28, -0.204_224_57],
            [-0.029_508_688, -0.009_611_746, 0.048_505_124],
            [0.014_474_574, 0.174_755_33, -0.174_370_21],
            [0.079_572_66, 0.106_616_5, -0.075_324_03],
            [0.079_572_66, 0.106_616_5, -0.075_324_03],
            [-0.087_948_18, 0.123_526_4, 0.103_034_87],
        ];
        let curve = Curve::new(CurveKind::BSpline { degree: 2 }, true, ring.to_vec()).unwrap();
        let feet = feet(&curve, [-0.030_221_02, 0.010_461_123, -0.030_221_02], 2.092_224_4);
        // The third foot's ridge is hardly higher than itself.
        assert_eq!(feet.len(), 3);
        assert!(feet[2].weight < 0.002 && feet[1].weight > 0.29, "{feet:?}");
    }

    #[test]
    fn a_valley_that_fills_up_weighs_nothing_in_the_end() {
        // The parabola y = x² for x = 3u − 1.5; the evolute is crossed at x = 4·6^(−3/2) = 0.272, y = 1.
        let points = vec![[-1.5, 2.25, 0.0], [0.0, -2.25, 0.0], [1.5, 2.25, 0.0]];
        let curve = Curve::bspline(2, points).unwrap();
        let mut before: Option<f64> = None;
        let mut several = 0;
        for i in 0..800_u16 {
            let feet = feet(&curve, [f32::from(i) * 5e-4, 1.0, 0.0], 2.0);
            several += usize::from(feet.len() > 1);
            let u: f64 = feet.iter().map(|f| f.weight * f.t).sum();
            if let Some(last) = before {
                assert!((u - last).abs() < 0.01, "{i}: from {last} to {u}, {feet:?}");
            }
            before = Some(u);
        }
        assert!((540..=548).contains(&several), "{several}");
    }
}
