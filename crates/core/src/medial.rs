//! `closest: Blended(width)`: all feet of a point that count, with weights that make the deformation continuous where the closest
//! one jumps, on the medial axis of the curve. \[SF98\] §6 leaves this open.
//!
//! The distance from the point along the curve: its valleys, which are the feet, and the ridges between them. What each foot counts
//! is worked out by [`flood`](crate::flood).

use glam::DVec3;

use crate::closest::Pieces;
use crate::flood::Flood;
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

/// A ridge no higher than both its valleys by this part of the coordinates is none: at a joint rounding may find the same valley on
/// both sides.
const FLAT: f64 = 1e-13;

/// Room for the valleys and ridges of one point.
#[derive(Debug, Default)]
pub(crate) struct Profile {
    valleys: Vec<Weighted>,
    /// The ridge before each valley, the highest of several; after the last valley one more.
    ridges: Vec<f64>,
    flood: Flood,
}

impl Profile {
    /// The feet that count of a point `p` (relative to the curve's origin) whose closest foot is at distance `least`; the closest
    /// comes first.
    pub(crate) fn feet(&mut self, pieces: &Pieces, p: DVec3, least: f64) -> &[Weighted] {
        self.survey(pieces, p, least + pieces.width);
        let floors = self.valleys.iter().map(|valley| valley.distance);
        let least = floors.clone().fold(f64::INFINITY, f64::min);
        self.flood.flat = FLAT * (p.length() + pieces.ball.radius);
        self.flood.fill(floors, &self.ridges, pieces.closed, least, pieces.width);
        for (i, valley) in self.valleys.iter_mut().enumerate() {
            valley.weight = self.flood.share(i);
        }
        self.valleys.retain(|valley| valley.weight > 0.0);
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
    }

    fn valley(&mut self, piece: &Piece, p: DVec3, s: f64) {
        let (span, t) = piece.place(s);
        self.valleys.push(Weighted { span, t, distance: piece.cubic.at(s).distance(p), weight: 0.0 });
        self.ridges.push(0.0);
    }

    fn ridge(&mut self, height: f64) {
        if let Some(last) = self.ridges.last_mut() {
            *last = last.max(height);
        }
    }
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
    fn a_valley_found_on_both_sides_of_a_joint_counts_once() {
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
        let of_nearest = |x: f32| feet(&curve, [x, 0.001_807_722_8, -0.005_222_310_3], 0.36)[0].weight;
        assert_eq!(feet(&curve, [-0.005_222_310_3, 0.001_807_722_8, -0.005_222_310_3], 0.36).len(), 2);
        assert!((of_nearest(-0.005_222_310_3) - of_nearest(-0.005_222_4)).abs() < 1e-5);
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
        assert!(feet[2].weight < 0.002 && feet[1].weight > 0.15, "{feet:?}");
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
