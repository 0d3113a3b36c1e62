//! Key poses: samples between which all others lie on straight ways, as few as will do, taken greedily from the first one on.

use crate::vectors::{Vector, bulge};

/// The most samples, and the most memory, that wait between two keys for the next one: where a way is straight for longer it gets
/// a key that it does not need.
const MOST: usize = 64;
const MOST_BYTES: usize = 96 << 20;

/// Chooses keys as samples come in.
#[derive(Debug)]
pub(crate) struct Keys {
    /// The indices of samples that are keys. The last sample is one too, once all are in.
    chosen: Vec<usize>,
    /// How far a sample is at most from the way between its keys, metres.
    error: f64,
    /// What is allowed.
    tolerance: f64,
    /// And at samples that equal the rest.
    at_rest: f64,
    count: usize,
    key: Option<(f64, Vec<Vector>)>,
    /// The samples since the last key.
    waiting: Vec<Waiting>,
    /// The error over those, were the last of them a key.
    pending: f64,
}

#[derive(Debug)]
struct Waiting {
    time: f64,
    places: Vec<Vector>,
    rests: bool,
}

impl Keys {
    pub(crate) fn new(tolerance: f64, at_rest: f64) -> Self {
        Self {
            chosen: Vec::new(),
            error: 0.0,
            tolerance,
            at_rest,
            count: 0,
            key: None,
            waiting: Vec::new(),
            pending: 0.0,
        }
    }

    /// Takes the next sample; `rests` where it equals the rest.
    pub(crate) fn push(&mut self, time: f64, places: Vec<Vector>, rests: bool) {
        let index = self.count;
        self.count += 1;
        let new = Waiting { time, places, rests };
        let Some(key) = &self.key else {
            self.chosen.push(index);
            self.key = Some((new.time, new.places));
            return;
        };
        let bytes = (self.waiting.len() + 1).saturating_mul(size_of_val(new.places.as_slice()));
        let full = self.waiting.len() >= MOST || bytes > MOST_BYTES;
        match self.straight(key, &new).filter(|_| !full) {
            Some(error) => self.pending = error,
            None => self.close(),
        }
        self.waiting.push(new);
    }

    /// How far what waits is from the way to `new`; nothing where that is too far.
    fn straight(&self, (start, from): &(f64, Vec<Vector>), new: &Waiting) -> Option<f64> {
        let mut most = 0.0_f64;
        // Those in the middle are the farthest, mostly.
        let middle = self.waiting.len() / 2;
        let (before, after) = self.waiting.split_at(middle);
        for one in after.iter().chain(before) {
            let part = (one.time - start) / (new.time - start);
            let off = bulge(from, &one.places, &new.places, part);
            if off > if one.rests { self.at_rest } else { self.tolerance } {
                return None;
            }
            most = most.max(off);
        }
        Some(most)
    }

    /// Makes the last of what waits a key.
    fn close(&mut self) {
        let Some(last) = self.waiting.pop() else { return };
        self.chosen.push(self.count - 2);
        self.error = self.error.max(self.pending);
        self.pending = 0.0;
        self.key = Some((last.time, last.places));
        self.waiting.clear();
    }

    /// The keys, once all samples are in.
    pub(crate) fn finish(mut self) -> (Vec<usize>, f64) {
        if self.count > 1 {
            self.chosen.push(self.count - 1);
            self.error = self.error.max(self.pending);
        }
        (self.chosen, self.error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(values: impl IntoIterator<Item = f32>, tolerance: f64) -> (Vec<usize>, f64) {
        let mut keys = Keys::new(tolerance, 1e-7);
        for (k, x) in values.into_iter().enumerate() {
            keys.push(k as f64, vec![[x, 0.0, 0.0]; 3], x == 0.0);
        }
        keys.finish()
    }

    #[test]
    fn corners_are_keys_and_straight_ways_are_not() {
        let ramp = (0..10).map(|k| k as f32 * 0.5);
        assert_eq!(keys(ramp.clone(), 1e-4).0, [0, 9]);
        let there_and_back = ramp.clone().chain(ramp.rev().skip(1));
        assert_eq!(keys(there_and_back, 1e-4).0, [0, 9, 18]);
        assert_eq!(keys([0.0, 0.0, 0.0, 1.0, 1.0], 1e-4).0, [0, 2, 3, 4]);
        assert_eq!(keys([3.0], 1e-4).0, [0]);
        assert_eq!(keys([0.0; 200], 1e-4).0.first(), Some(&0));
    }

    #[test]
    fn samples_at_rest_are_exact_and_others_within_the_tolerance() {
        let values: Vec<f32> =
            (0..200).map(|k| if k % 17 == 0 { 0.0 } else { (k as f32 * 0.07).sin() }).collect();
        let (keys, error) = keys(values.iter().copied(), 0.02);
        assert!(error <= 0.02 && keys.len() < 120, "{error} {}", keys.len());
        for pair in keys.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            for k in a..b {
                let part = (k - a) as f32 / (b - a) as f32;
                let off = (values[a] + part * (values[b] - values[a]) - values[k]).abs();
                assert!(off <= if values[k] == 0.0 { 2e-7 } else { 0.02 + 1e-6 }, "{k}: {off}");
            }
        }
    }
}
