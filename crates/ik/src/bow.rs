//! Bones on a circle: of all ways in which bones of given lengths can span a distance, the one that bends evenly.
//!
//! The joints of a *bow* lie on a circle on which the line from its first to its last joint is a chord. A polygon of given sides whose
//! corners lie on a circle is unique (it is the one that encloses most), and there is one whenever there is a polygon at all:
//! so a bow spans whatever bones can span, it changes steadily with the distance, and two bones make the triangle that there is.
//! One number, the *arch*, runs through all bows: half the angle under which the centre sees the longest bone.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::root::root;

/// All bows of bones of given lengths.
#[derive(Clone, Debug)]
pub(crate) struct Bows {
    lengths: Vec<f64>,
    /// The first of the longest bones.
    longest: usize,
    /// The arch of the bow whose ends are nearest to each other.
    closed: f64,
}

impl Bows {
    /// The bows of at least one bone, all of positive lengths.
    pub(crate) fn new(lengths: Vec<f64>) -> Self {
        let mut longest = 0;
        for (i, length) in lengths.iter().enumerate() {
            if *length > lengths[longest] {
                longest = i;
            }
        }
        let mut bows = Self { lengths, longest, closed: PI };
        // Closed where it has gone all the way round; where the longest bone is longer than all others together it never does, and the
        // others lie on it in the end.
        let round = |arch: f64| bows.half_turn(arch) - PI;
        let others = bows.lengths.iter().sum::<f64>() - bows.lengths[bows.longest];
        if round(FRAC_PI_2) >= 0.0 {
            bows.closed = root(round, 0.0, FRAC_PI_2);
        } else if others > bows.lengths[bows.longest] {
            // At half a turn it is round in any case.
            bows.closed = root(|arch| if arch == PI { 1.0 } else { round(arch) }, FRAC_PI_2, PI);
        }
        bows
    }

    /// The least distance that a bow spans.
    pub(crate) fn least(&self) -> f64 {
        self.span(self.closed)
    }

    /// The arch of the bow that spans a distance, or comes nearest to that.
    pub(crate) fn spanning(&self, distance: f64) -> f64 {
        root(|arch| distance - self.span(arch), 0.0, self.closed)
    }

    /// How far the ends are from each other.
    fn span(&self, arch: f64) -> f64 {
        let mut angles = Angles::new(self, arch);
        self.lengths.iter().map(|length| length * angles.next(self).cos()).sum()
    }

    /// Half the angle under which the centre sees a bone.
    fn half_angle(&self, bone: usize, arch: f64) -> f64 {
        if bone == self.longest {
            return arch;
        }
        (arch.sin() * self.lengths[bone] / self.lengths[self.longest]).clamp(0.0, 1.0).asin()
    }

    fn half_turn(&self, arch: f64) -> f64 {
        (0..self.lengths.len()).map(|bone| self.half_angle(bone, arch)).sum()
    }

    /// The angle of each bone against the line between the ends, rising.
    pub(crate) fn angles_into(&self, arch: f64, out: &mut Vec<f64>) {
        let mut angles = Angles::new(self, arch);
        out.clear();
        out.extend(self.lengths.iter().map(|_| angles.next(self)));
    }
}

/// The angles of bones, one after the other.
struct Angles {
    arch: f64,
    bone: usize,
    /// The direction of the circle where the next bone begins.
    tangent: f64,
}

impl Angles {
    fn new(bows: &Bows, arch: f64) -> Self {
        Self { arch, bone: 0, tangent: -bows.half_turn(arch) }
    }

    fn next(&mut self, bows: &Bows) -> f64 {
        let half = bows.half_angle(self.bone, self.arch);
        self.bone += 1;
        let angle = self.tangent + half;
        self.tangent = angle + half;
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(bows: &Bows, arch: f64) -> (f64, f64) {
        let mut angles = Vec::new();
        bows.angles_into(arch, &mut angles);
        let along = angles.iter().zip(&bows.lengths).map(|(a, l)| l * a.cos()).sum();
        (along, angles.iter().zip(&bows.lengths).map(|(a, l)| l * a.sin()).sum())
    }

    #[test]
    fn bows_span_whatever_bones_can() {
        let chains: [&[f64]; 7] =
            [&[1.0], &[1.0, 1.0], &[1.0, 0.4], &[0.3, 1.0, 0.2], &[1.0; 3], &[0.2, 0.9, 0.7, 0.1], &[0.5; 8]];
        for lengths in chains {
            let bows = Bows::new(lengths.to_vec());
            let total: f64 = lengths.iter().sum();
            let longest = lengths.iter().copied().fold(0.0, f64::max);
            let least = (2.0 * longest - total).max(0.0);
            assert!((ends(&bows, bows.closed).0 - least).abs() < 1e-9, "{lengths:?}");
            let mut before = f64::INFINITY;
            for i in 0..=200 {
                let (along, across) = ends(&bows, bows.closed * f64::from(i) / 200.0);
                assert!(across.abs() < 1e-9, "the ends are on the line");
                assert!(along < before + 1e-12, "{lengths:?}: {along} after {before}");
                before = along;
                let distance = least + (total - least) * f64::from(i) / 200.0;
                let (along, _) = ends(&bows, bows.spanning(distance));
                assert!((along - distance).abs() < 1e-9 * total, "{lengths:?}: {along} for {distance}");
            }
        }
    }

    #[test]
    fn joints_lie_on_a_circle() {
        let bows = Bows::new(vec![0.5, 0.3, 0.8, 0.2]);
        let mut angles = Vec::new();
        bows.angles_into(bows.spanning(1.2), &mut angles);
        let mut joints = vec![[0.0, 0.0]];
        for (angle, length) in angles.iter().zip(&bows.lengths) {
            let [x, y] = joints[joints.len() - 1];
            joints.push([x + length * angle.cos(), y + length * angle.sin()]);
        }
        // The centre lies on the line's bisector; which one, three joints say.
        let [x, y] = joints[1];
        let height = (x * x + y * y - 1.2 * x) / (2.0 * y);
        let radius = 0.6_f64.hypot(height);
        for [x, y] in joints {
            assert!(((x - 0.6).hypot(y - height) - radius).abs() < 1e-9);
        }
    }
}
