//! Masks: what multiplies `F` of a wire at each point.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// What multiplies `F` of a wire at each point: a number from 0 to 1. Numbers outside are taken as the nearer of the two, NaN as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mask<'a> {
    /// A number for each point.
    Dense(&'a [f32]),
    /// Numbers for some points; at the others it is 0. Parts that hold none of them are not even searched.
    Sparse {
        /// Which points, rising.
        points: &'a [u32],
        /// A number for each of them; empty: 1 each.
        factors: &'a [f32],
    },
}

/// A mask as a binding keeps it.
#[derive(Clone, Debug)]
pub(crate) enum KeptMask {
    Dense(Vec<f32>),
    Sparse { points: Vec<u32>, factors: Vec<f32> },
}

impl Mask<'_> {
    /// How many numbers it holds, where that does not fit `points`.
    pub(crate) fn misfit(&self, points: usize) -> Option<usize> {
        match self {
            Mask::Dense(mask) => (mask.len() != points).then_some(mask.len()),
            Mask::Sparse { points: some, factors } => {
                let rising = some.windows(2).all(|pair| pair[0] < pair[1]);
                let inside = some.last().is_none_or(|last| (*last as usize) < points);
                let each = factors.is_empty() || factors.len() == some.len();
                (!rising || !inside || !each).then_some(some.len())
            }
        }
    }

    /// What tells it from masks of other numbers: where these are, and how many.
    fn identity(&self) -> [(usize, usize); 2] {
        match self {
            Mask::Dense(mask) => [(mask.as_ptr().addr(), mask.len()), (0, usize::MAX)],
            Mask::Sparse { points, factors } => {
                [(points.as_ptr().addr(), points.len()), (factors.as_ptr().addr(), factors.len())]
            }
        }
    }
}

impl KeptMask {
    pub(crate) fn new(mask: Mask<'_>) -> Self {
        let in_range = |f: &f32| if f.is_nan() { 0.0 } else { f.clamp(0.0, 1.0) };
        let kept = |factors: &[f32]| factors.iter().map(in_range).collect();
        match mask {
            Mask::Dense(mask) => Self::Dense(kept(mask)),
            Mask::Sparse { points, factors } => {
                Self::Sparse { points: points.to_vec(), factors: kept(factors) }
            }
        }
    }

    /// The factor of a point.
    pub(crate) fn at(&self, point: usize) -> f32 {
        match self {
            Self::Dense(mask) => mask[point],
            Self::Sparse { points, factors } => match points.binary_search(&(point as u32)) {
                Ok(slot) => factors.get(slot).copied().unwrap_or(1.0),
                Err(_) => 0.0,
            },
        }
    }

    /// The factors of consecutive points; none where all of them are 0 for want of a number.
    pub(crate) fn of(&self, range: Range<usize>) -> Option<Cow<'_, [f32]>> {
        let (points, factors) = match self {
            Self::Dense(mask) => return Some(Cow::Borrowed(&mask[range])),
            Self::Sparse { points, factors } => (points, factors),
        };
        let start = points.partition_point(|&point| (point as usize) < range.start);
        let end = start + points[start..].partition_point(|&point| (point as usize) < range.end);
        if start == end {
            return None;
        }
        let mut all = vec![0.0; range.len()];
        for slot in start..end {
            all[points[slot] as usize - range.start] = factors.get(slot).copied().unwrap_or(1.0);
        }
        Some(Cow::Owned(all))
    }
}

/// Each of the masks kept once; wires often share one.
pub(crate) fn keep(masks: &[Option<Mask<'_>>]) -> Vec<Option<Arc<KeptMask>>> {
    let mut given = HashMap::new();
    let mut keep = |mask: Mask<'_>| {
        Arc::clone(given.entry(mask.identity()).or_insert_with(|| Arc::new(KeptMask::new(mask))))
    };
    masks.iter().map(|mask| mask.map(&mut keep)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sparse_masks_say_what_dense_ones_do() {
        let (points, factors) = ([1, 4, 5, 9], [0.5, 2.0, f32::NAN, 0.25]);
        let dense = [0.0, 0.5, 0.0, 0.0, 2.0, -1.0, 0.0, 0.0, 0.0, 0.25];
        let sparse = KeptMask::new(Mask::Sparse { points: &points, factors: &factors });
        let dense = KeptMask::new(Mask::Dense(&dense));
        for i in 0..10 {
            assert_eq!(sparse.at(i), dense.at(i));
        }
        assert_eq!(sparse.of(3..10), dense.of(3..10));
        assert_eq!(sparse.of(6..9), None);
        let ones = KeptMask::new(Mask::Sparse { points: &points, factors: &[] });
        assert_eq!((ones.at(4), ones.at(3)), (1.0, 0.0));
    }

    #[test]
    fn misfits_are_found() {
        let misfit = |points: &[u32], factors: &[f32]| Mask::Sparse { points, factors }.misfit(5).is_some();
        assert!(!misfit(&[], &[]) && !misfit(&[0, 4], &[]) && !misfit(&[0, 4], &[1.0; 2]));
        assert!(
            misfit(&[4, 0], &[]) && misfit(&[1, 1], &[]) && misfit(&[0, 5], &[]) && misfit(&[0], &[1.0; 2])
        );
        assert!(Mask::Dense(&[1.0; 4]).misfit(5) == Some(4) && Mask::Dense(&[1.0; 5]).misfit(5).is_none());
    }

    #[test]
    fn shared_masks_are_kept_once() {
        let (a, b) = ([1.0; 3], [1.0; 3]);
        let kept = keep(&[Some(Mask::Dense(&a)), None, Some(Mask::Dense(&b)), Some(Mask::Dense(&a))]);
        let kept: Vec<_> = kept.iter().map(Option::as_ref).collect();
        assert!(Arc::ptr_eq(kept[0].unwrap(), kept[3].unwrap()) && kept[1].is_none());
        assert!(!Arc::ptr_eq(kept[0].unwrap(), kept[2].unwrap()));
        // The same points with other factors, and fewer of the same numbers, are other masks.
        let points = [0, 1, 2];
        let some = |count: usize, factors| Some(Mask::Sparse { points: &points[..count], factors });
        let kept = keep(&[some(3, &a), some(3, &b), some(3, &[]), some(2, &a[..2]), some(3, &a)]);
        let kept: Vec<_> = kept.iter().flatten().collect();
        for (i, mask) in kept.iter().enumerate() {
            assert_eq!(Arc::ptr_eq(kept[0], mask), i == 0 || i == 4, "{i}");
        }
    }
}
