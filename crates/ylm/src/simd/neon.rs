//! NEON, which every 64-bit Arm has.

use std::arch::aarch64::*;
use std::ops::{Add, Mul, Sub};

use super::Lanes;

macro_rules! vector {
    (
        $(#[$doc:meta])* $name:ident: $raw:ident of $count:literal $float:ident,
        $add:ident, $sub:ident, $mul:ident, $fma:ident, $fms:ident, $splat:ident, $load:ident, $store:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($raw);

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: NEON is part of the base architecture; so below.
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        // SAFETY: a register of that many numbers.
        unsafe impl Lanes<$float> for $name {
            const COUNT: usize = $count;

            #[inline(always)]
            fn splat(value: $float) -> Self {
                // SAFETY: as above.
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn load(from: &[$float]) -> Self {
                let from = &from[..$count];
                // SAFETY: as above, and `from` holds that many numbers.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$float]) {
                let to = &mut to[..$count];
                // SAFETY: as above, and `to` holds that many numbers.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $fma(addend.0, self.0, factor.0) })
            }
            #[inline(always)]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $fms(addend.0, self.0, factor.0) })
            }
        }
    };
}

vector!(
    /// 4 × f32.
    F32x4: float32x4_t of 4 f32,
    vaddq_f32, vsubq_f32, vmulq_f32, vfmaq_f32, vfmsq_f32, vdupq_n_f32, vld1q_f32, vst1q_f32
);
vector!(
    /// 2 × f64.
    F64x2: float64x2_t of 2 f64,
    vaddq_f64, vsubq_f64, vmulq_f64, vfmaq_f64, vfmsq_f64, vdupq_n_f64, vld1q_f64, vst1q_f64
);
