//! Sine, cosine, arc tangent and powers of two without branches or calls, so that loops over them become vector code, with the same
//! bits on every processor.
//!
//! The polynomials interpolate at Chebyshev's nodes: `sin x / x` and `cos x` in `x²` on `|x| ≤ π/4`, `atan x / x` in
//! `x²` on `0 ≤ x ≤ 1`, `2^x` on `|x| ≤ ½`, and `log₂ x` in `z = (x − 1)/(x + 1)`. In float32 all are within 1e-7, the last two
//! relative to the result and to 1.

use std::f32::consts::FRAC_2_PI;

const SINE: [f32; 4] = [1.0, -0.166_666_5, 0.008_332_036, -0.000_195_039_04];
const COSINE: [f32; 5] = [1.0, -0.5, 0.041_666_616, -0.001_388_661_8, 2.437_983e-5];
const ARC_TANGENT: [f32; 9] = [
    1.0,
    -0.333_330_37,
    0.199_918_72,
    -0.141_977_98,
    0.106_183_704,
    -0.074_568_55,
    0.042_137_623,
    -0.015_731_25,
    0.002_766_283_5,
];

const POWER: [f32; 7] =
    [1.0, 0.693_147_2, 0.240_226_51, 0.055_503_27, 0.009_618_057, 0.001_340_042_8, 0.000_154_614_45];
const LOGARITHM: [f32; 4] = [2.885_390_1, 0.961_798_84, 0.576_715_2, 0.431_717_7];

/// Added and taken away again, it rounds a number below 2²² to an integer, whose last bits are then the sum's.
const ROUND: f32 = 12_582_912.0;

/// π/2 in three parts (Cody and Waite); the first two have few bits, so that their products with the number of quarter
/// turns are exact up to thousands of them.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// `(sin x, cos x)`; exactly `(0, 1)` at 0.
#[inline(always)]
pub(crate) fn sin_cos(x: f32) -> (f32, f32) {
    let shifted = x * FRAC_2_PI + ROUND;
    let quadrant = shifted.to_bits();
    let turns = shifted - ROUND;
    let r = ((x - turns * QUARTER[0]) - turns * QUARTER[1]) - turns * QUARTER[2];
    let y = r * r;
    let s = r * (SINE[0] + y * (SINE[1] + y * (SINE[2] + y * SINE[3])));
    let c = COSINE[0] + y * (COSINE[1] + y * (COSINE[2] + y * (COSINE[3] + y * COSINE[4])));
    let swap = quadrant & 1 == 1;
    let (sine, cosine) = (if swap { c } else { s }, if swap { s } else { c });
    let sine_sign = (quadrant & 2) << 30;
    let cosine_sign = (quadrant.wrapping_add(1) & 2) << 30;
    (f32::from_bits(sine.to_bits() ^ sine_sign), f32::from_bits(cosine.to_bits() ^ cosine_sign))
}

/// `atan x` for `0 ≤ x ≤ 1`.
#[inline(always)]
pub(crate) fn atan_unit(x: f32) -> f32 {
    let y = x * x;
    let c = &ARC_TANGENT;
    let high = c[4] + y * (c[5] + y * (c[6] + y * (c[7] + y * c[8])));
    x * (c[0] + y * (c[1] + y * (c[2] + y * (c[3] + y * high))))
}

/// `2^x`; 0 below −126, so that no result is subnormal, and at most 2¹²⁷.
#[inline(always)]
pub(crate) fn exp2(x: f32) -> f32 {
    let inside = if x > -126.0 { x } else { -126.0 };
    let inside = if inside < 127.0 { inside } else { 127.0 };
    let shifted = inside + ROUND;
    let whole = shifted - ROUND;
    let r = inside - whole;
    let c = &POWER;
    let p = c[0] + r * (c[1] + r * (c[2] + r * (c[3] + r * (c[4] + r * (c[5] + r * c[6])))));
    let exponent = shifted.to_bits().wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23;
    let power = p * f32::from_bits(exponent);
    if x > -126.0 { power } else { 0.0 }
}

/// `log₂ x` of a positive number; subnormal ones count as the least normal one.
#[inline(always)]
pub(crate) fn log2(x: f32) -> f32 {
    // The bits of √½: subtracting them splits x into 2^e and a mantissa in [√½, √2).
    const HALF_ROOT: u32 = 0x3f35_04f3;
    let x = if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE };
    let bits = x.to_bits().wrapping_sub(HALF_ROOT);
    let exponent = (bits as i32) >> 23;
    let mantissa = f32::from_bits((bits & 0x007f_ffff) + HALF_ROOT);
    let z = (mantissa - 1.0) / (mantissa + 1.0);
    let y = z * z;
    let c = &LOGARITHM;
    exponent as f32 + z * (c[0] + y * (c[1] + y * (c[2] + y * c[3])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_logarithms_are_right() {
        for i in -125_000..=125_000 {
            let x = i as f32 * 0.001;
            let exact = f64::from(x).exp2();
            assert!((f64::from(exp2(x)) / exact - 1.0).abs() < 2.5e-7, "2^{x}");
            let back = log2(exp2(x));
            assert!((back - x).abs() < 4e-7 * x.abs().max(1.0), "log₂ 2^{x} = {back}");
        }
        assert_eq!((exp2(0.0), log2(1.0), exp2(-200.0), exp2(f32::NEG_INFINITY)), (1.0, 0.0, 0.0, 0.0));
        assert_eq!(log2(f32::MIN_POSITIVE), -126.0);
    }

    #[test]
    fn sine_and_cosine_are_right_over_many_turns() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        for i in -100_000..=100_000 {
            let x = i as f32 * 0.000_7;
            let (s, c) = sin_cos(x);
            let (es, ec) = f64::from(x).sin_cos();
            assert!((f64::from(s) - es).abs() < 1.5e-7, "sin {x}");
            assert!((f64::from(c) - ec).abs() < 1.5e-7, "cos {x}");
        }
    }

    #[test]
    fn arc_tangent_is_right() {
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            assert!((f64::from(atan_unit(x)) - f64::from(x).atan()).abs() < 1.2e-7, "atan {x}");
        }
    }
}
