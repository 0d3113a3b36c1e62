//! Shares of a point's feet for `closest: Blended(width)`, by flooding.
//!
//! Along the curve the distance from the point rises and falls. Its valleys are the feet, parted by ridges. Water rises from
//! the deepest valley's floor to `width` above it; what it does not reach has no share. At level `h` a valley with floor `a`
//! weighs `B(h − a)`. Where two pools meet over a ridge they become one: their feet share it by the weights they have there,
//! and it weighs the sum. As the water rises on, what the pool weighs more than its deepest valley alone would fades, and is
//! gone a `width` higher. At the top each pool has its weight in parts of all.
//!
//! `B(s) = q / (1 − q)`, `q = t²(3 − 2t)`, `t = s / (2 width)`: so of two feet that a high ridge parts the nearer has a share
//! that runs smoothly from a half to the whole as the other becomes `width` farther, with the least slope there is. What
//! fades does so as `1 − 3x² + 2x³`.
//!
//! No share steps. A valley that fills up, where its ridge is no higher than its floor, weighs nothing there. Two that are
//! equally deep and parted by next to no ridge weigh as much as one. Where ridges change order the pools meet at one level,
//! and sums do not depend on the order. At a cusp of the evolute, where two valleys and their ridge come together, their
//! shares of the pool step, but the feet are at one place.

/// A point keeps at most so many feet; of more, each share is lessened by that of the next one, so that none steps.
const MOST: usize = 64;

/// A pool: a single valley, or two pools that have met.
#[derive(Clone, Copy, Debug)]
struct Pool {
    /// Its deepest floor.
    floor: f64,
    /// What it weighs more than its deepest valley alone, at `level`.
    excess: f64,
    level: f64,
    /// The first of its valleys along the curve.
    first: usize,
    /// The pools it is made of, and the share of the first of them.
    parts: Option<(usize, usize, f64)>,
    /// Its share of all.
    share: f64,
    /// The pool it has become part of; itself at first.
    into: usize,
}

/// Room for the pools of one point.
#[derive(Debug, Default)]
pub(crate) struct Flood {
    pools: Vec<Pool>,
    /// Height of a ridge, and the valleys on both sides.
    ridges: Vec<(f64, usize, usize)>,
    sorted: Vec<f64>,
    /// Ridges no higher than this over both floors are rounding. Default 0.
    pub(crate) flat: f64,
}

impl Flood {
    /// Floods the valleys, given the floors in their order along the curve, of which the least is `least`, and the ridges:
    /// one before each valley and one after the last. Round a closed curve the first and the last are one.
    pub(crate) fn fill(
        &mut self,
        floors: impl ExactSizeIterator<Item = f64>,
        ridges: &[f64],
        closed: bool,
        least: f64,
        width: f64,
    ) {
        let count = floors.len();
        let single = |(i, floor)| Pool {
            floor,
            excess: 0.0,
            level: floor,
            first: i,
            parts: None,
            share: 0.0,
            into: i,
        };
        self.pools.clear();
        self.pools.extend(floors.enumerate().map(single));
        self.ridges.clear();
        self.ridges.extend((1..count).map(|i| (ridges[i], i - 1, i)));
        if closed && count > 1 {
            self.ridges.push((ridges[0].max(ridges[count]), count - 1, 0));
        }
        let top = least + width;
        self.ridges.retain(|ridge| ridge.0 < top);
        self.ridges.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 0..self.ridges.len() {
            let (level, a, b) = self.ridges[i];
            let (a, b) = (self.find(a), self.find(b));
            if a != b {
                self.meet(level, a, b, width);
            }
        }
        self.share_out(top, width);
        self.limit(count);
    }

    /// The share of the `i`-th valley.
    pub(crate) fn share(&self, i: usize) -> f64 {
        self.pools[i].share
    }

    fn find(&mut self, mut pool: usize) -> usize {
        while self.pools[pool].into != pool {
            let next = self.pools[pool].into;
            self.pools[pool].into = self.pools[next].into;
            pool = next;
        }
        pool
    }

    fn meet(&mut self, level: f64, a: usize, b: usize, width: f64) {
        let (pool_a, pool_b) = (self.pools[a], self.pools[b]);
        let (weight_a, weight_b) = (pool_a.weight(level, width), pool_b.weight(level, width));
        let sum = weight_a + weight_b;
        let floor = pool_a.floor.min(pool_b.floor);
        let excess = (sum - valley(level - floor, width)).max(0.0);
        // With no ridge between them they are one foot, the first.
        let share = if level - floor <= self.flat {
            f64::from(u8::from(pool_a.first < pool_b.first))
        } else {
            weight_a / sum
        };
        let (into, first) = (self.pools.len(), pool_a.first.min(pool_b.first));
        self.pools.push(Pool { floor, excess, level, first, parts: Some((a, b, share)), share: 0.0, into });
        (self.pools[a].into, self.pools[b].into) = (into, into);
    }

    /// Shares of all pools, from the last down to the valleys.
    fn share_out(&mut self, top: f64, width: f64) {
        let mut sum = 0.0;
        for (i, pool) in self.pools.iter_mut().enumerate() {
            if pool.into == i {
                pool.share = pool.weight(top, width);
                sum += pool.share;
            }
        }
        for i in (0..self.pools.len()).rev() {
            let pool = &mut self.pools[i];
            if pool.into == i {
                pool.share /= sum;
            }
            let share = pool.share;
            if let Some((a, b, part)) = pool.parts {
                self.pools[a].share = share * part;
                self.pools[b].share = share * (1.0 - part);
            }
        }
    }

    /// Keeps the largest shares of the first `count` pools, no more than [`MOST`].
    fn limit(&mut self, count: usize) {
        if count <= MOST {
            return;
        }
        self.sorted.clear();
        self.sorted.extend(self.pools[..count].iter().map(|pool| pool.share));
        self.sorted.sort_by(|a, b| b.total_cmp(a));
        let next = self.sorted[MOST];
        let left: f64 = self.sorted[..MOST].iter().map(|share| share - next).sum();
        for pool in &mut self.pools[..count] {
            // All alike: nothing tells them apart, and none is left out.
            pool.share = if left > 0.0 { (pool.share - next).max(0.0) / left } else { pool.share };
        }
    }
}

impl Pool {
    fn weight(&self, level: f64, width: f64) -> f64 {
        let x = ((level - self.level) / width).clamp(0.0, 1.0);
        valley(level - self.floor, width) + self.excess * (1.0 - x * x * (3.0 - 2.0 * x))
    }
}

/// `B`: what a single valley weighs under water of depth `s`.
fn valley(s: f64, width: f64) -> f64 {
    let t = 0.5 * (s / width).clamp(0.0, 1.0);
    let q = t * t * (3.0 - 2.0 * t);
    q / (1.0 - q)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an open curve with width 1: valleys and ridges by turns.
    fn shares(profile: &[f64]) -> Vec<f64> {
        let floors: Vec<f64> = profile.iter().copied().step_by(2).collect();
        let between = profile.iter().copied().skip(1).step_by(2);
        let ridges: Vec<f64> = [9.0].into_iter().chain(between).chain([9.0]).collect();
        let least = floors.iter().copied().fold(f64::INFINITY, f64::min);
        let (mut flood, count) = (Flood::default(), floors.len());
        flood.fill(floors.into_iter(), &ridges, false, least, 1.0);
        (0..count).map(|i| flood.share(i)).collect()
    }

    fn close(found: &[f64], expected: &[f64]) {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.len() == expected.len() && off < 1e-9, "{found:?}, not {expected:?}");
    }

    #[test]
    fn across_a_high_ridge_the_share_runs_from_a_half_to_the_whole() {
        for (farther, share) in [(0.0, 0.5), (0.5, 0.15625), (1.0, 0.0), (1.5, 0.0)] {
            close(&shares(&[0.0, 5.0, farther]), &[1.0 - share, share]);
        }
    }

    #[test]
    fn valleys_with_next_to_no_ridge_between_weigh_as_one() {
        close(&shares(&[0.0, 0.0, 0.0]), &[1.0, 0.0]);
        close(&shares(&[0.0, 1e-6, 0.0]), &[0.5, 0.5]);
        close(&shares(&[0.0, 5.0, 0.0, 1e-9, 0.0]), &[0.5, 0.25, 0.25]);
        close(&shares(&[0.0, 5.0, 0.0, 5.0, 0.0]), &[1.0 / 3.0; 3]);
    }

    #[test]
    fn a_valley_that_fills_up_has_nothing() {
        close(&shares(&[0.0, 0.3, 0.3]), &[1.0, 0.0]);
        close(&shares(&[0.2, 5.0, 0.1, 0.4, 0.4]), &shares(&[0.2, 5.0, 0.1, 0.4, 0.4 - 1e-12]));
    }

    /// Valleys and ridges by turns of a sampled function, and the places of the valleys.
    fn profile(f: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut profile, mut places): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let last = f.len() - 1;
        for i in 0..=last {
            let (left, right) = (if i > 0 { f[i - 1] } else { 9.0 }, if i < last { f[i + 1] } else { 9.0 });
            if f[i] < left && f[i] <= right {
                profile.push(f[i]);
                places.push(i as f64 / last as f64);
            } else if f[i] >= left && f[i] > right && !profile.is_empty() {
                profile.push(f[i]);
            }
        }
        (profile, places)
    }

    #[test]
    fn the_mean_place_steps_nowhere() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let mut several = 0;
        for _ in 0..40 {
            // Waves from one shape to another: valleys wander, end, begin and change order.
            let waves: Vec<[f64; 2]> = (0..7).map(|_| [random(), random()]).collect();
            let at = |x: f64, u: f64| -> f64 {
                let wave = |(k, [a, b]): (usize, &[f64; 2])| {
                    (a + (b - a) * x) * (std::f64::consts::PI * (k + 1) as f64 * u).cos()
                };
                waves.iter().enumerate().map(wave).sum()
            };
            let mut before: Option<f64> = None;
            for step in 0..=1000 {
                let f: Vec<f64> =
                    (0..=300).map(|i| at(f64::from(step) / 1000.0, f64::from(i) / 300.0)).collect();
                let (profile, places) = profile(&f);
                let shares = shares(&profile);
                several += usize::from(shares.iter().filter(|share| **share > 0.0).count() > 2);
                let mean: f64 = shares.iter().zip(&places).map(|(a, b)| a * b).sum();
                // A valley wanders by the root of the step where it ends, and by samples.
                assert!(
                    before.is_none_or(|before| (mean - before).abs() < 0.02),
                    "{waves:?} at {step}: {before:?}, {mean}"
                );
                before = Some(mean);
            }
        }
        assert!(several > 5000, "{several} with three feet or more");
    }

    #[test]
    fn of_very_many_feet_the_largest_shares_are_kept() {
        let profile: Vec<f64> =
            (0..999).map(|i| if i % 2 == 1 { 5.0 } else { f64::from(i) * 1e-4 }).collect();
        let found = shares(&profile);
        let kept = found.iter().filter(|share| **share > 0.0).count();
        assert!(kept == MOST && (found.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{kept}");
    }
}
