//! \[SF98\] §5.2, Figure 18 (f): where a seam is open at a moment.

use crate::settings::Tear;

/// A tear at a moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TearNow {
    at: f64,
    half: f64,
    opening: f64,
    gape: f64,
    plateau: f64,
}

/// How far a seam is open at a place of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gap {
    /// 0 shut, 1 open.
    pub(crate) open: f64,
    /// How far edges are drawn into their own surface.
    pub(crate) gape: f64,
}

impl TearNow {
    pub(crate) fn of(tear: &Tear, seconds: f64) -> Self {
        let [at, width, opening, gape, plateau] =
            [&tear.at, &tear.width, &tear.opening, &tear.gape, &tear.plateau]
                .map(|keyed| f64::from(keyed.at(seconds)));
        Self { at, half: width / 2.0, opening, gape, plateau }
    }

    /// How far it is open at `t`; round a loop both ways.
    fn open(&self, t: f64, closed: bool) -> f64 {
        let off = (t - self.at).abs();
        let off = if closed { off.min(1.0 - off) } else { off };
        if self.half <= 0.0 || off >= self.half {
            return 0.0;
        }
        let flat = self.plateau * self.half;
        let x = ((off - flat) / (self.half - flat)).max(0.0);
        self.opening * (1.0 - x * x).powi(2)
    }

    /// How far it goes from an end of the seam, 0 or 1, where it is open there, else 0.
    pub(crate) fn reach(&self, end: f64) -> f64 {
        let off = (self.at - end).abs();
        if off < self.half { self.half + off } else { 0.0 }
    }
}

/// What all tears make of a seam at `t`: each multiplies what is left of the closure; edges are drawn as far into their surface as by the one
/// that draws most.
pub(crate) fn gap(tears: &[TearNow], t: f64, closed: bool) -> Gap {
    let add = |gap: Gap, tear: &TearNow| {
        let open = tear.open(t, closed);
        let gape = tear.gape * open;
        let gape = if gape.abs() > gap.gape.abs() { gape } else { gap.gape };
        Gap { open: gap.open + (1.0 - gap.open) * open, gape }
    };
    tears.iter().fold(Gap::default(), add)
}

#[cfg(test)]
mod tests {
    use wirework_core::Keyed;

    use super::*;

    fn now(tear: &Tear) -> [TearNow; 1] {
        [TearNow::of(tear, 0.0)]
    }

    #[test]
    fn a_tear_opens_inside_its_width_and_nowhere_else() {
        let tear = Tear { gape: Keyed::Constant(0.1), ..Tear::new(0.5, 0.2) };
        let at = |t| gap(&now(&tear), t, false);
        assert_eq!((at(0.5).open, at(0.5).gape), (1.0, f64::from(0.1_f32)));
        assert_eq!([at(0.39), at(0.61), at(0.0)], [Gap::default(); 3]);
        assert!((at(0.55).open - 0.5625).abs() < 1e-6);
        // A plateau is all open, and what is left of the width falls as before.
        let wide = Tear { plateau: Keyed::Constant(0.5), ..tear.clone() };
        let at = |t| gap(&now(&wide), t, false);
        assert_eq!(at(0.549).open, 1.0);
        assert!((at(0.575).open - 0.5625).abs() < 1e-6);
        assert_eq!(at(0.601).open, 0.0);
    }

    #[test]
    fn tears_that_overlap_multiply_and_go_round_loops() {
        let half = Tear { opening: Keyed::Constant(0.5), ..Tear::new(0.5, 0.2) };
        let both = [now(&half)[0]; 2];
        assert_eq!(gap(&both, 0.5, false).open, 0.75);
        let end = Tear::new(0.0, 0.2);
        let [before, after] = [0.95, 0.05].map(|t| gap(&now(&end), t, true).open);
        assert!(before > 0.5 && (before - after).abs() < 1e-12);
        assert_eq!(gap(&now(&end), 0.95, false), Gap::default());
        let none = Tear::new(0.5, 0.0);
        assert_eq!(gap(&now(&none), 0.5, false), Gap::default());
    }
}
