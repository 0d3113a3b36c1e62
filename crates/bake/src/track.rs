//! Weights over time, without the keys that their neighbours make up.

/// The most keys in a row that are left out: each is looked at again for each that follows.
const MOST: usize = 256;

/// Keys that straight ways between others replace, so that what the weights sum up to is off by less than `slack`, and by nothing where it
/// `rests`: `reach` says by how much a weight of 1 moves anything at most. Gives the indices of those that stay, the first and the
/// last among them, and how far the others are off.
pub(crate) fn thinned(
    times: &[f64],
    (weights, rests): (&[Vec<f64>], &[bool]),
    reach: &[f64],
    slack: f64,
) -> (Vec<usize>, f64) {
    let off = |from: usize, to: usize, k: usize| -> f64 {
        let part = (times[k] - times[from]) / (times[to] - times[from]);
        let lists = weights[from].iter().zip(&weights[k]).zip(&weights[to]).zip(reach);
        lists.map(|(((a, b), c), reach)| (a + part * (c - a) - b).abs() * reach).sum()
    };
    // How far those between two keys are off, where they may be.
    let between = |from: usize, to: usize| {
        (from + 1..to).try_fold(0.0_f64, |most, k| {
            let off = off(from, to, k);
            (off <= if rests[k] { 0.0 } else { slack }).then_some(most.max(off))
        })
    };
    let (mut kept, mut from) = (vec![0], 0);
    let (mut pending, mut most) = (0.0, 0.0_f64);
    for to in 1..times.len() {
        if let Some(off) = between(from, to).filter(|_| to - from <= MOST) {
            pending = off;
        } else {
            from = to - 1;
            kept.push(from);
            most = most.max(std::mem::take(&mut pending));
        }
    }
    if times.len() > 1 {
        kept.push(times.len() - 1);
    }
    (kept, most.max(pending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_stay() {
        let times: Vec<f64> = (0..9).map(f64::from).collect();
        let weights: Vec<Vec<f64>> = (0..9).map(|k| vec![f64::from(k).min(4.0), 1.0]).collect();
        let of = |times: &[f64], weights: &[Vec<f64>], reach: &[f64], slack: f64| {
            thinned(times, (weights, &vec![false; times.len()]), reach, slack)
        };
        assert_eq!(of(&times, &weights, &[1.0, 1.0], 1e-9), (vec![0, 4, 8], 0.0));
        assert_eq!(of(&times, &weights, &[1e-3, 1.0], 1.0), (vec![0, 8], 2e-3));
        assert_eq!(of(&[2.0], &[vec![1.0]], &[1.0], 0.1), (vec![0], 0.0));
    }

    #[test]
    fn what_rests_stays_exact_however_slowly_it_comes_to_rest() {
        let times: Vec<f64> = (0..20).map(f64::from).collect();
        let weight = |k: usize| 1e-6 * (10.0 - k as f64).max(0.0).powi(2);
        let weights: Vec<Vec<f64>> = (0..20).map(|k| vec![weight(k)]).collect();
        let rests: Vec<bool> = (0..20).map(|k| k >= 10).collect();
        let (kept, off) = thinned(&times, (&weights, &rests), &[1.0], 1e-2);
        assert_eq!(kept, [0, 10, 19]);
        assert!((off - 2.5e-5).abs() < 1e-9, "{off}");
    }
}
