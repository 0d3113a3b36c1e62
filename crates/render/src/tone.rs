//! From light to bytes.

use std::sync::OnceLock;

/// Linear light as an sRGB byte, rounded to nearest; below 0 and NaN are 0, above 1 is 255.
///
/// By search in the 255 borders between bytes: the same everywhere, whatever the system's power function rounds to.
pub(crate) fn encode(linear: f32) -> u8 {
    static BORDERS: OnceLock<[f32; 255]> = OnceLock::new();
    let borders = BORDERS.get_or_init(|| std::array::from_fn(|i| decode((i as f64 + 0.5) / 255.0) as f32));
    borders.partition_point(|&border| border <= linear) as u8
}

/// The linear light of each sRGB byte.
pub(crate) fn decode_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|i| decode(i as f64 / 255.0) as f32))
}

/// The sRGB transfer function (IEC 61966-2-1).
fn decode(s: f64) -> f64 {
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

/// Light is scaled by this before the filmic curve, so that a white surface facing the key light stays below white.
const EXPOSURE: f32 = 0.50;

/// The filmic curve of K. Narkowicz's fit (2015) to the ACES reference transform: a soft shoulder, a slight toe.
pub(crate) fn filmic(x: f32) -> f32 {
    let x = x.max(0.0) * EXPOSURE;
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_the_round_trip() {
        for byte in 0..=255 {
            assert_eq!(encode(decode_table()[byte as usize]), byte);
        }
        assert_eq!(
            [encode(-1.0), encode(f32::NAN), encode(0.0), encode(1.0), encode(9.0)],
            [0, 0, 0, 255, 255]
        );
        assert_eq!(encode(0.5), 188);
    }

    #[test]
    fn the_filmic_curve_rises_and_stays_below_one() {
        let values: Vec<f32> = (0..2000).map(|i| filmic(i as f32 * 0.01)).collect();
        assert!(values.is_sorted() && values[0] == 0.0 && values[1999] <= 1.0);
    }
}
