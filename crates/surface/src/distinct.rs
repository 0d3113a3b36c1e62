//! What is equal among many rows of numbers, such as vertices at one place.

use std::hash::{BuildHasher, RandomState};

/// Rows of numbers by what they are equal to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Distinct {
    /// For each row which of the different ones it is, numbered as they first occur.
    pub of: Vec<u32>,
    /// The first row of each of those.
    pub first: Vec<u32>,
}

impl Distinct {
    /// Of `count` rows, less than 2³², which `row` gives. Numbers are equal whose bits are, and 0 and −0.
    pub fn new<const N: usize>(count: usize, row: impl Fn(usize) -> [f32; N]) -> Self {
        // A table with open addresses: a fraction of the memory of a map of the standard library, and of its time. A slot has
        // one more than the number of a row; 0 is free. At most half of them are taken, so that free ones are near.
        let mut slots = vec![0_u32; (2 * count).next_power_of_two()];
        let mask = slots.len() - 1;
        // Other ones on each run, so that no file can be made to share slots. What comes out does not depend on them.
        let random = RandomState::new();
        let keys: [u64; 2] = [random.hash_one(0), random.hash_one(1)];
        // Adding 0 makes −0 equal to 0.
        let bits = |i: usize| row(i).map(|c| (c + 0.0).to_bits());
        let mut out = Self { of: Vec::with_capacity(count), first: Vec::with_capacity(count) };
        for i in 0..count {
            let own = bits(i);
            let mut at = hash(&own, keys) & mask;
            let number = loop {
                let Some(number) = slots[at].checked_sub(1) else {
                    out.first.push(i as u32);
                    slots[at] = out.first.len() as u32;
                    break slots[at] - 1;
                };
                if bits(out.first[number as usize] as usize) == own {
                    break number;
                }
                at = (at + 1) & mask;
            };
            out.of.push(number);
        }
        out
    }
}

/// Products of halves that are folded: no pattern of a mesh survives that.
fn hash<const N: usize>(words: &[u32; N], [mut state, key]: [u64; 2]) -> usize {
    let (pairs, rest) = words.as_chunks::<2>();
    let pairs = pairs.iter().map(|&[low, high]| u64::from(low) | u64::from(high) << 32);
    for word in pairs.chain(rest.iter().map(|&word| u64::from(word))) {
        let product = u128::from(state ^ word) * u128::from(key | 1);
        state = product as u64 ^ (product >> 64) as u64;
    }
    state as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbered_as_they_first_occur() {
        // Each place twice, in two orders, some with the sign of zero turned.
        let place = |i: u32| [(i % 7) as f32, (i / 7 % 11) as f32 * -0.5, (i / 77) as f32];
        let mirrored = |i: u32| place(i).map(|c| if c == 0.0 { -c } else { c });
        let rows: Vec<_> = (0..1000).map(place).chain((0..1000).rev().map(mirrored)).collect();
        let found = Distinct::new(rows.len(), |i| rows[i]);
        assert!(found.of.iter().copied().eq((0..1000).chain((0..1000).rev())));
        assert!(found.first.iter().copied().eq(0..1000));
        assert_eq!(Distinct::new(0, |_| [0.0; 5]), Distinct::default());
        assert_eq!(Distinct::new(3, |i| [f32::NAN, i as f32 % 2.0]).of, [0, 1, 0], "by their bits");
    }
}
