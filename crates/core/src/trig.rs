//! Sine, cosine, arc tangent, powers and logarithms of numbers side by side, without branches or calls of a library, with
//! the same bits on every processor.
//!
//! The polynomials interpolate at Chebyshev's nodes: `sin x / x` and `cos x` in `x²` on `|x| ≤ π/4`, `atan x / x` in
//! `x²` on `0 ≤ x ≤ 1`, `2^x` on `|x| ≤ ½`, and `log₂ x` in `z = (x − 1)/(x + 1)`. In float32 all are within 1e-7, the last two
//! relative to the result and to 1.

use std::f32::consts::{FRAC_2_PI, LN_2};

use pulp::Simd;

use crate::simd::{FloatMask, Floats};

const SINE: [f32; 4] = [1.0, -0.166_666_5, 0.008_332_036, -0.000_195_039_04];
const COSINE: [f32; 5] = [1.0, -0.5, 0.041_666_616, -0.001_388_661_8, 2.437_983e-5];
const ARC_TANGENT: [f32; 9] = [
    1.0,
    -0.333_330_37,
    0.199_918_72,
    -0.141_977_98,
    0.106_183_7,
    -0.074_568_55,
    0.042_137_623,
    -0.015_731_25,
    0.002_766_283_5,
];
const POWER: [f32; 7] =
    [1.0, LN_2, 0.240_226_5, 0.055_503_27, 0.009_618_057, 0.001_340_042_8, 0.000_154_614_45];
const LOGARITHM: [f32; 4] = [2.885_39, 0.961_798_84, 0.576_715_2, 0.431_717_7];

/// Added and taken away again, it rounds a number below 2²² to an integer, whose last bits are then the sum's.
const ROUND: f32 = 12_582_912.0;

/// π/2 in three parts (Cody and Waite); the first two have few bits, so that their products with the number of quarter
/// turns are exact up to thousands of them.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// `(sin x, cos x)`; exactly `(0, 1)` at 0.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd>(x: Floats<S>) -> (Floats<S>, Floats<S>) {
    let simd = x.0;
    let round = Floats::splat(simd, ROUND);
    let shifted = x * Floats::splat(simd, FRAC_2_PI) + round;
    let turns = shifted - round;
    let r = x - turns * Floats::splat(simd, QUARTER[0]);
    let r = r - turns * Floats::splat(simd, QUARTER[1]);
    let r = r - turns * Floats::splat(simd, QUARTER[2]);
    let y = r * r;
    let (s, c) = (r * y.polynomial(&SINE), y.polynomial(&COSINE));
    let quadrant = shifted.to_bits();
    let one = simd.splat_u32s(1);
    let swap = simd.equal_u32s(simd.and_u32s(quadrant, one), one);
    let (sine, cosine) = (simd.select_f32s(swap, c.1, s.1), simd.select_f32s(swap, s.1, c.1));
    (flipped(Floats(simd, sine), quadrant), flipped(Floats(simd, cosine), simd.add_u32s(quadrant, one)))
}

/// `x`, negated where `quadrant` has the bit for 2.
#[inline(always)]
fn flipped<S: Simd>(x: Floats<S>, quadrant: S::u32s) -> Floats<S> {
    let simd = x.0;
    let sign = simd.wrapping_dyn_shl_u32s(simd.and_u32s(quadrant, simd.splat_u32s(2)), simd.splat_u32s(30));
    Floats::from_bits(simd, simd.xor_u32s(x.to_bits(), sign))
}

/// `atan x` for `0 ≤ x ≤ 1`.
#[inline(always)]
pub(crate) fn atan_unit<S: Simd>(x: Floats<S>) -> Floats<S> {
    x * (x * x).polynomial(&ARC_TANGENT)
}

/// `2^x`; 0 below −126, so that no result is subnormal, and at most 2¹²⁷.
#[inline(always)]
pub(crate) fn exp2<S: Simd>(x: Floats<S>) -> Floats<S> {
    let simd = x.0;
    let (least, most) = (Floats::splat(simd, -126.0), Floats::splat(simd, 127.0));
    let round = Floats::splat(simd, ROUND);
    let large = least.less(x);
    let inside = large.select(x, least);
    let inside = inside.less(most).select(inside, most);
    let shifted = inside + round;
    let r = inside - (shifted - round);
    let bias = simd.splat_u32s(127_u32.wrapping_sub(ROUND.to_bits()));
    let exponent = simd.wrapping_dyn_shl_u32s(simd.add_u32s(shifted.to_bits(), bias), simd.splat_u32s(23));
    let power = r.polynomial(&POWER) * Floats::from_bits(simd, exponent);
    large.select(power, Floats::splat(simd, 0.0))
}

/// `log₂ x` of a positive number; subnormal ones count as the least normal one.
#[inline(always)]
pub(crate) fn log2<S: Simd>(x: Floats<S>) -> Floats<S> {
    /// The bits of √½: subtracting them splits `x` into `2^e` and a mantissa in `[√½, √2)`.
    const HALF_ROOT: u32 = 0x3f35_04f3;
    /// Keeps the exponent positive while it is shifted.
    const BIAS: u32 = 128;
    /// A number whose last bits count ones.
    const ONES: u32 = 0x4b00_0000;
    let simd = x.0;
    let least = Floats::splat(simd, f32::MIN_POSITIVE);
    let x = least.less(x).select(x, least);
    let bits = simd.add_u32s(x.to_bits(), simd.splat_u32s((BIAS << 23).wrapping_sub(HALF_ROOT)));
    let exponent = simd.or_u32s(simd.wrapping_dyn_shr_u32s(bits, simd.splat_u32s(23)), simd.splat_u32s(ONES));
    let exponent = Floats::from_bits(simd, exponent) - Floats::splat(simd, f32::from_bits(ONES + BIAS));
    let mantissa = simd.and_u32s(bits, simd.splat_u32s(0x007f_ffff));
    let mantissa = Floats::from_bits(simd, simd.add_u32s(mantissa, simd.splat_u32s(HALF_ROOT)));
    let one = Floats::splat(simd, 1.0);
    let z = (mantissa - one) / (mantissa + one);
    exponent + z * (z * z).polynomial(&LOGARITHM)
}

/// `2^x` where `mask` is true, 0 where not.
#[inline(always)]
pub(crate) fn exp2_where<S: Simd>(mask: FloatMask<S>, x: Floats<S>) -> Floats<S> {
    mask.select(exp2(x), Floats::splat(x.0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, Scalar, WithSimd};

    type Function = fn(f32) -> [f32; 4];

    /// All functions on many numbers, in vectors.
    struct All<'a>(&'a [f32], &'a mut [[f32; 4]]);

    impl WithSimd for All<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let mut store = [[0.0; 64]; 4];
            for (x, out) in self.0.chunks(64).zip(self.1.chunks_mut(64)) {
                let mut padded = [0.0; 64];
                padded[..x.len()].copy_from_slice(x);
                for (i, v) in Floats::<S>::vectors(&padded).iter().enumerate() {
                    let v = Floats(simd, *v);
                    let (s, c) = sin_cos(v);
                    for (row, result) in [s, c, exp2(v), log2(v)].into_iter().enumerate() {
                        Floats::<S>::vectors_mut(&mut store[row])[i] = result.1;
                    }
                }
                for (i, out) in out.iter_mut().enumerate() {
                    *out = [0, 1, 2, 3].map(|row| store[row][i]);
                }
            }
        }
    }

    fn scalar(f: fn(Floats<Scalar>) -> Floats<Scalar>, x: f32) -> f32 {
        f(Floats(Scalar, x)).1
    }

    #[test]
    fn every_width_gives_the_same_bits() {
        let x: Vec<f32> = (-5000..5000).map(|i| i as f32 * 0.013).collect();
        let mut wide = vec![[0.0; 4]; x.len()];
        Arch::new().dispatch(All(&x, &mut wide));
        let narrow: Function = |x| {
            let (s, c) = sin_cos(Floats(Scalar, x));
            [s.1, c.1, scalar(exp2, x), scalar(log2, x)]
        };
        for (x, wide) in x.iter().zip(&wide) {
            assert_eq!(narrow(*x).map(f32::to_bits), wide.map(f32::to_bits), "{x}");
        }
    }

    #[test]
    fn sine_and_cosine_are_right_over_many_turns() {
        let at = |x| sin_cos(Floats(Scalar, x));
        assert_eq!((at(0.0).0.1, at(0.0).1.1), (0.0, 1.0));
        for i in -100_000..=100_000 {
            let x = i as f32 * 0.000_7;
            let (s, c) = at(x);
            let (es, ec) = f64::from(x).sin_cos();
            assert!((f64::from(s.1) - es).abs() < 1.5e-7, "sin {x}");
            assert!((f64::from(c.1) - ec).abs() < 1.5e-7, "cos {x}");
        }
    }

    #[test]
    fn arc_tangent_is_right() {
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            assert!((f64::from(scalar(atan_unit, x)) - f64::from(x).atan()).abs() < 1.2e-7, "atan {x}");
        }
    }

    #[test]
    fn powers_and_logarithms_are_right() {
        for i in -125_000..=125_000 {
            let x = i as f32 * 0.001;
            let power = scalar(exp2, x);
            assert!((f64::from(power) / f64::from(x).exp2() - 1.0).abs() < 2.5e-7, "2^{x}");
            let back = scalar(log2, power);
            assert!((back - x).abs() < 4e-7 * x.abs().max(1.0), "log₂ 2^{x} = {back}");
        }
        assert_eq!((scalar(exp2, 0.0), scalar(log2, 1.0), scalar(exp2, -200.0)), (1.0, 0.0, 0.0));
        assert_eq!((scalar(exp2, f32::NEG_INFINITY), scalar(log2, f32::MIN_POSITIVE)), (0.0, -126.0));
    }
}
