//! Weights over time, without the keys that their neighbours make up.

/// The most keys in a row that are left out: each is looked at again for each that follows.
const MOST: usize = 256;

/// Keys that straight ways between others replace, so that what the weights sum up to is off by less than `slack`: `reach` says by how much a
/// weight of 1 moves anything at most. Gives the indices of those that stay, the first and the last among them.
pub(crate) fn thinned(times: &[f64], weights: &[Vec<f64>], reach: &[f64], slack: f64) -> Vec<usize> {
    let off = |from: usize, to: usize, k: usize| -> f64 {
        let part = (times[k] - times[from]) / (times[to] - times[from]);
        let lists = weights[from].iter().zip(&weights[k]).zip(&weights[to]).zip(reach);
        lists.map(|(((a, b), c), reach)| (a + part * (c - a) - b).abs() * reach).sum()
    };
    let (mut kept, mut from) = (vec![0], 0);
    for to in 1..times.len() {
        if to - from > MOST || (from + 1..to).any(|k| off(from, to, k) > slack) {
            from = to - 1;
            kept.push(from);
        }
    }
    if times.len() > 1 {
        kept.push(times.len() - 1);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_stay() {
        let times: Vec<f64> = (0..9).map(f64::from).collect();
        let weights: Vec<Vec<f64>> = (0..9).map(|k| vec![f64::from(k).min(4.0), 1.0]).collect();
        assert_eq!(thinned(&times, &weights, &[1.0, 1.0], 1e-9), [0, 4, 8]);
        assert_eq!(thinned(&times, &weights, &[1e-3, 1.0], 1.0), [0, 8]);
        assert_eq!(thinned(&[2.0], &[vec![1.0]], &[1.0], 0.1), [0]);
    }
}
