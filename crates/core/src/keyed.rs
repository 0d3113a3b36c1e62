//! Values that move in time: a constant, or keys in seconds. Before the first key and after the last a value
//! stays what it is there.

use thiserror::Error;

/// What can be interpolated between two keys.
pub trait Interpolate: Clone {
    /// `a + (b − a)·x`, exactly `a` at 0 and `b` at 1.
    fn interpolate(a: &Self, b: &Self, x: f64) -> Self;
    /// Whether values can stand in one track; lists must be equally long. Default yes.
    fn compatible(_a: &Self, _b: &Self) -> bool {
        true
    }
}

impl Interpolate for f32 {
    fn interpolate(a: &Self, b: &Self, x: f64) -> Self {
        (f64::from(*a) * (1.0 - x) + f64::from(*b) * x) as f32
    }
}

impl Interpolate for [f32; 3] {
    fn interpolate(a: &Self, b: &Self, x: f64) -> Self {
        [0, 1, 2].map(|i| f32::interpolate(&a[i], &b[i], x))
    }
}

impl Interpolate for Vec<[f32; 3]> {
    fn interpolate(a: &Self, b: &Self, x: f64) -> Self {
        a.iter().zip(b).map(|(a, b)| Interpolate::interpolate(a, b, x)).collect()
    }

    fn compatible(a: &Self, b: &Self) -> bool {
        a.len() == b.len()
    }
}

/// A value that may move in time.
#[derive(Clone, Debug, PartialEq)]
pub enum Keyed<T> {
    /// The same at all times.
    Constant(T),
    /// Keys by rising time.
    Keys(Keys<T>),
}

/// A track of keys; made by [`Keyed::keys`], so that it is never empty and in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Keys<T> {
    keys: Vec<(f64, T)>,
    ease: bool,
}

/// Why keys do not make a track.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum KeysError {
    /// There are none.
    #[error("a track needs at least one key")]
    Empty,
    /// A time is NaN or infinite, or does not come after the one before.
    #[error("the time of key {index} must be finite and later than the one before")]
    Order {
        /// Which key, from 0.
        index: usize,
    },
    /// A list of points has another length than the first key's.
    #[error("key {index} has another number of points than the first")]
    Length {
        /// Which key, from 0.
        index: usize,
    },
}

impl<T: Interpolate> Keyed<T> {
    /// A track of `(seconds, value)` by strictly rising time, linear between keys, or by `3x² − 2x³` with `ease`.
    pub fn keys(keys: Vec<(f64, T)>, ease: bool) -> Result<Self, KeysError> {
        let Some((_, first)) = keys.first() else { return Err(KeysError::Empty) };
        for (index, (time, value)) in keys.iter().enumerate() {
            if !time.is_finite() || (index > 0 && *time <= keys[index - 1].0) {
                return Err(KeysError::Order { index });
            }
            if !T::compatible(first, value) {
                return Err(KeysError::Length { index });
            }
        }
        Ok(Self::Keys(Keys { keys, ease }))
    }

    /// The value at `seconds`.
    pub fn at(&self, seconds: f64) -> T {
        let Keys { keys, ease } = match self {
            Self::Constant(value) => return value.clone(),
            Self::Keys(keys) => keys,
        };
        let next = keys.partition_point(|(time, _)| *time <= seconds);
        if next == 0 || next == keys.len() {
            return keys[next.saturating_sub(1)].1.clone();
        }
        let ((t0, a), (t1, b)) = (&keys[next - 1], &keys[next]);
        let x = (seconds - t0) / (t1 - t0);
        T::interpolate(a, b, if *ease { x * x * (3.0 - 2.0 * x) } else { x })
    }
}

impl<T> Keyed<T> {
    /// The same keys with other values, of another kind if need be. Lists must become ones that are as long.
    #[must_use]
    pub fn map<U>(&self, mut change: impl FnMut(&T) -> U) -> Keyed<U> {
        match self {
            Self::Constant(value) => Keyed::Constant(change(value)),
            Self::Keys(track) => {
                let keys = track.keys.iter().map(|(time, value)| (*time, change(value))).collect();
                Keyed::Keys(Keys { keys, ease: track.ease })
            }
        }
    }

    /// The times of the keys in seconds, rising; none for a constant.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        let keys = match self {
            Self::Constant(_) => &[][..],
            Self::Keys(track) => &track.keys,
        };
        keys.iter().map(|(time, _)| *time)
    }

    /// Whether it runs by `3x² − 2x³` between keys and not along straight lines; a constant does not.
    pub fn eased(&self) -> bool {
        matches!(self, Self::Keys(Keys { ease: true, .. }))
    }

    /// The time of the last key in seconds; `None` for a constant.
    pub fn last_key(&self) -> Option<f64> {
        match self {
            Self::Constant(_) => None,
            Self::Keys(track) => track.keys.last().map(|(time, _)| *time),
        }
    }

    /// Every value the track holds, in order.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        let (constant, keys) = match self {
            Self::Constant(value) => (Some(value), &[][..]),
            Self::Keys(track) => (None, &track.keys[..]),
        };
        constant.into_iter().chain(keys.iter().map(|(_, value)| value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hold_beyond_their_ends_and_hit_their_values() {
        let track = Keyed::keys(vec![(1.0, 2.0_f32), (3.0, 6.0)], false).unwrap();
        let at = |t| track.at(t);
        assert_eq!([at(0.0), at(1.0), at(2.0), at(3.0), at(9.0)], [2.0, 2.0, 4.0, 6.0, 6.0]);
        assert_eq!(track.last_key(), Some(3.0));
    }

    #[test]
    fn mapped_keys_keep_their_times_and_their_ease() {
        let track = Keyed::keys(vec![(1.0, 2.0_f32), (3.0, 6.0)], true).unwrap();
        let doubled = track.map(|value| 2.0 * value);
        assert_eq!(doubled.times().collect::<Vec<_>>(), [1.0, 3.0]);
        assert!(doubled.eased() && !Keyed::Constant(1.0_f32).eased());
        assert_eq!([1.5, 2.0].map(|t| doubled.at(t)), [1.5, 2.0].map(|t| 2.0 * track.at(t)));
        let constant = Keyed::Constant(2.0_f32).map(|value| value + 1.0);
        assert_eq!((constant.times().count(), constant.at(7.0)), (0, 3.0));
    }

    #[test]
    fn ease_is_smoothstep() {
        let track = Keyed::keys(vec![(0.0, 0.0_f32), (1.0, 1.0)], true).unwrap();
        assert!((track.at(0.25) - 0.156_25).abs() < 1e-7);
    }

    #[test]
    fn bad_tracks_are_refused_at_their_key() {
        assert_eq!(Keyed::<f32>::keys(vec![], false), Err(KeysError::Empty));
        assert_eq!(Keyed::keys(vec![(1.0, 0.0_f32), (1.0, 0.0)], false), Err(KeysError::Order { index: 1 }));
        assert_eq!(Keyed::keys(vec![(f64::NAN, 0.0_f32)], false), Err(KeysError::Order { index: 0 }));
        let lists = vec![(0.0, vec![[0.0; 3]]), (1.0, vec![])];
        assert_eq!(Keyed::keys(lists, false), Err(KeysError::Length { index: 1 }));
    }
}
