//! Point caches come back as they went in, whatever the numbers are.

use proptest::prelude::*;
use wirework_bake::{CacheFormat, CacheHead, cache_head, cache_sample_into};

/// Frames of points, of any bits but those that are no numbers.
fn frames() -> impl Strategy<Value = Vec<Vec<[f32; 3]>>> {
    let number = any::<u32>().prop_map(f32::from_bits).prop_filter("a number", |c| !c.is_nan());
    (1..20_usize, 1..6_usize).prop_flat_map(move |(points, frames)| {
        let point = prop::array::uniform3(number.clone());
        prop::collection::vec(prop::collection::vec(point, points), frames)
    })
}

proptest! {
    #[test]
    fn frames_come_back(frames in frames(), first in 0..1000_u32, big in any::<bool>()) {
        let format = if big { CacheFormat::Mdd } else { CacheFormat::Pc2 };
        let times: Vec<f64> = (0..frames.len()).map(|k| (first as f64 + k as f64) / 24.0).collect();
        let head = CacheHead { points: frames[0].len(), first_frame: f64::from(first), times: times.clone() };
        let mut bytes = cache_head(format, &head).unwrap();
        for points in &frames {
            cache_sample_into(format, points, &mut bytes);
        }
        let word = |at: usize| {
            let word = bytes[at..at + 4].try_into().unwrap();
            if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
        };
        let (samples, points, start) = if big {
            for (k, time) in times.iter().enumerate() {
                prop_assert_eq!(f32::from_bits(word(8 + 4 * k)), *time as f32);
            }
            (word(0), word(4), 8 + 4 * frames.len())
        } else {
            prop_assert_eq!(f32::from_bits(word(20)), first as f32);
            (word(28), word(16), 32)
        };
        prop_assert_eq!((samples as usize, points as usize), (frames.len(), frames[0].len()));
        let numbers = frames.iter().flatten().flatten().map(|c| c.to_bits());
        let read = (start..bytes.len()).step_by(4).map(word);
        prop_assert!(read.eq(numbers));
    }
}
