//! Numbers side by side, as many as the processor computes at once, with the operators of plain ones.
//!
//! A thin cover over `pulp`, so that formulas read as formulas. No operation fuses, so every width gives the same bits.
//! A value is made from an instruction set, which is proof that the processor has it.
//!
//! # Notes
//!
//! A closure in code that is generic over the instruction set is a function of its own, compiled without those
//! instructions unless it happens to be inlined; code that uses closures or `array::map` here ran ten times slower than
//! without any vectors. So hot code has only functions marked for inlining.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;
use pulp::Simd;

macro_rules! lanes {
    ($name:ident, $mask:ident, $scalar:ty, $vector:ident, $mask_vector:ident, $lanes:ident,
     $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $neg:ident,
     $less:ident, $less_equal:ident, $select:ident, $and:ident, $or:ident, $not:ident,
     $as_simd:ident, $as_mut_simd:ident) => {
        /// Numbers side by side.
        #[derive(Clone, Copy)]
        pub(crate) struct $name<S: Simd>(pub(crate) S, pub(crate) S::$vector);

        /// Truths side by side.
        #[derive(Clone, Copy)]
        pub(crate) struct $mask<S: Simd>(S, pub(crate) S::$mask_vector);

        impl<S: Simd> $name<S> {
            /// The same number in every lane.
            #[inline(always)]
            pub(crate) fn splat(simd: S, x: $scalar) -> Self {
                Self(simd, simd.$splat(x))
            }

            /// The numbers of a slice as vectors; its length must be a multiple of their width.
            #[inline(always)]
            pub(crate) fn vectors(numbers: &[$scalar]) -> &[S::$vector] {
                S::$as_simd(numbers).0
            }

            /// The same to be written.
            #[inline(always)]
            pub(crate) fn vectors_mut(numbers: &mut [$scalar]) -> &mut [S::$vector] {
                S::$as_mut_simd(numbers).0
            }

            #[inline(always)]
            pub(crate) fn less(self, other: Self) -> $mask<S> {
                $mask(self.0, self.0.$less(self.1, other.1))
            }

            #[inline(always)]
            pub(crate) fn at_most(self, other: Self) -> $mask<S> {
                $mask(self.0, self.0.$less_equal(self.1, other.1))
            }
        }

        impl<S: Simd> $mask<S> {
            /// `yes` where true, `no` where not.
            #[inline(always)]
            pub(crate) fn select(self, yes: $name<S>, no: $name<S>) -> $name<S> {
                $name(self.0, self.0.$select(self.1, yes.1, no.1))
            }
        }

        impl<S: Simd> Add for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                Self(self.0, self.0.$add(self.1, b.1))
            }
        }

        impl<S: Simd> Sub for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                Self(self.0, self.0.$sub(self.1, b.1))
            }
        }

        impl<S: Simd> Mul for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                Self(self.0, self.0.$mul(self.1, b.1))
            }
        }

        impl<S: Simd> Div for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn div(self, b: Self) -> Self {
                Self(self.0, self.0.$div(self.1, b.1))
            }
        }

        impl<S: Simd> Neg for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(self.0, self.0.$neg(self.1))
            }
        }

        impl<S: Simd> BitAnd for $mask<S> {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, b: Self) -> Self {
                Self(self.0, self.0.$and(self.1, b.1))
            }
        }

        impl<S: Simd> BitOr for $mask<S> {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, b: Self) -> Self {
                Self(self.0, self.0.$or(self.1, b.1))
            }
        }

        impl<S: Simd> Not for $mask<S> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(self.0, self.0.$not(self.1))
            }
        }
    };
}

lanes!(
    Floats,
    FloatMask,
    f32,
    f32s,
    m32s,
    F32_LANES,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    neg_f32s,
    less_than_f32s,
    less_than_or_equal_f32s,
    select_f32s,
    and_m32s,
    or_m32s,
    not_m32s,
    as_simd_f32s,
    as_mut_simd_f32s
);
lanes!(
    Doubles,
    DoubleMask,
    f64,
    f64s,
    m64s,
    F64_LANES,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    neg_f64s,
    less_than_f64s,
    less_than_or_equal_f64s,
    select_f64s,
    and_m64s,
    or_m64s,
    not_m64s,
    as_simd_f64s,
    as_mut_simd_f64s
);

impl<S: Simd> Floats<S> {
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f32s(self.1))
    }

    #[inline(always)]
    pub(crate) fn to_bits(self) -> S::u32s {
        self.0.transmute_u32s_f32s(self.1)
    }

    #[inline(always)]
    pub(crate) fn from_bits(simd: S, bits: S::u32s) -> Self {
        Self(simd, simd.transmute_f32s_u32s(bits))
    }

    /// Horner's scheme: `c₀ + c₁ x + ..`.
    #[inline(always)]
    pub(crate) fn polynomial<const N: usize>(self, c: &[f32; N]) -> Self {
        let mut sum = Self::splat(self.0, c[N - 1]);
        for k in (0..N - 1).rev() {
            sum = Self::splat(self.0, c[k]) + self * sum;
        }
        sum
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        let simd = self.0;
        Self::from_bits(simd, simd.and_u32s(self.to_bits(), simd.splat_u32s(0x7fff_ffff)))
    }
}

impl<S: Simd> Doubles<S> {
    /// The dot product of `a` with the same vector in every lane.
    #[inline(always)]
    pub(crate) fn dot(a: [Self; 3], b: DVec3) -> Self {
        let simd = a[0].0;
        a[0] * Self::splat(simd, b.x) + a[1] * Self::splat(simd, b.y) + a[2] * Self::splat(simd, b.z)
    }
}

impl<S: Simd> DoubleMask<S> {
    /// The same number in every lane where true, 0 where not.
    #[inline(always)]
    pub(crate) fn number(self, x: f64) -> Doubles<S> {
        self.select(Doubles::splat(self.0, x), Doubles::splat(self.0, 0.0))
    }
}

/// Three coordinates, side by side.
#[derive(Clone, Copy)]
pub(crate) struct Vectors<S: Simd>(pub(crate) [Floats<S>; 3]);

impl<S: Simd> Vectors<S> {
    /// The polynomial with vector coefficients `c` at `t`.
    #[inline(always)]
    pub(crate) fn polynomial<const N: usize>(t: Floats<S>, c: &[[f32; 3]; N]) -> Self {
        let mut sum = Self::splat(t.0, c[N - 1]);
        for k in (0..N - 1).rev() {
            sum = Self::splat(t.0, c[k]) + sum.times(t);
        }
        sum
    }

    #[inline(always)]
    pub(crate) fn splat(simd: S, v: [f32; 3]) -> Self {
        Self([Floats::splat(simd, v[0]), Floats::splat(simd, v[1]), Floats::splat(simd, v[2])])
    }

    #[inline(always)]
    pub(crate) fn dot(self, b: Self) -> Floats<S> {
        let (a, b) = (self.0, b.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[inline(always)]
    pub(crate) fn cross(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    #[inline(always)]
    pub(crate) fn times(self, s: Floats<S>) -> Self {
        let [x, y, z] = self.0;
        Self([x * s, y * s, z * s])
    }

    /// `yes` where `mask` is true, `no` where not.
    #[inline(always)]
    pub(crate) fn select(mask: FloatMask<S>, yes: Self, no: Self) -> Self {
        let (y, n) = (yes.0, no.0);
        Self([mask.select(y[0], n[0]), mask.select(y[1], n[1]), mask.select(y[2], n[2])])
    }
}

impl<S: Simd> Add for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    }
}

impl<S: Simd> Sub for Vectors<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
    }
}
