//! What wind does to a rope.

use glam::DVec3;
use wirework_core::Keyed;

use crate::Curtain;
use crate::ground::wide;
use crate::random::{Jitter, smooth};

/// Seconds from one turn of the gusts to the next, of those that all ropes feel and of each rope's own: about what one sees in a
/// curtain. Their ratio is no simple fraction, so that they do not pause together.
const SHARED: f64 = 1.3;
const OWN: f64 = 0.8;

/// The wind in time.
#[derive(Clone, Debug)]
pub(crate) struct Wind {
    mean: Keyed<[f32; 3]>,
    gusts: f64,
    seed: u64,
}

impl Wind {
    pub(crate) fn new(curtain: &Curtain, seed: u64) -> Self {
        Self { mean: curtain.wind.clone(), gusts: f64::from(curtain.gusts), seed }
    }

    /// The acceleration of rope number `rope`. Before 0 s gusts go on, the keys stay.
    pub(crate) fn at(&self, seconds: f64, rope: usize) -> DVec3 {
        let mean = wide(self.mean.at(seconds.max(0.0)));
        if self.gusts == 0.0 || mean == DVec3::ZERO {
            return mean;
        }
        let shared = smooth(self.seed, 0, Jitter::SharedGust, seconds / SHARED);
        let own = smooth(self.seed, rope, Jitter::Gust, seconds / OWN);
        mean * (1.0 + self.gusts * 0.5 * (shared + own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wind(gusts: f32, seed: u64) -> Wind {
        Wind::new(&Curtain { wind: Keyed::Constant([2.0, 0.0, 0.0]), gusts, ..Curtain::default() }, seed)
    }

    #[test]
    fn without_gusts_it_is_the_keys() {
        assert_eq!(wind(0.0, 1).at(3.3, 2), DVec3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn gusts_are_smooth_and_between_nothing_and_twice_the_wind() {
        let (wind, step) = (wind(1.0, 1), 1e-3);
        let all: Vec<f64> = (-2000..60_000).map(|i| wind.at(f64::from(i) * step, 4).x).collect();
        assert!(all.iter().all(|x| (0.0..=4.0).contains(x)));
        // A quintic over 0.8 s changes by 15/8 of twice its share in it at most, and the shared one more slowly.
        assert!(all.windows(2).all(|w| (w[1] - w[0]).abs() < 2.0 * (15.0 / 8.0) / OWN * 2.0 * step));
        let (low, high) = all.iter().fold((2.0_f64, 2.0_f64), |(l, h), x| (l.min(*x), h.max(*x)));
        assert!(low < 1.0 && high > 3.0, "{low} to {high}");
    }

    #[test]
    fn ropes_and_seeds_have_their_own() {
        assert_eq!(wind(0.5, 1).at(2.2, 0), wind(0.5, 1).at(2.2, 0));
        assert_ne!(wind(0.5, 1).at(2.2, 0), wind(0.5, 1).at(2.2, 1));
        assert_ne!(wind(0.5, 1).at(2.2, 0), wind(0.5, 2).at(2.2, 0));
    }
}
