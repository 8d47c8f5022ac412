//! WebAssembly SIMD128; it has no fused multiply-add.

use std::arch::wasm32::*;
use std::ops::{Add, Mul, Sub};

use super::Lanes;

macro_rules! vector {
    (
        $(#[$doc:meta])* $name:ident of $count:literal $float:ident,
        $add:ident, $sub:ident, $mul:ident, $splat:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name(v128);

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self($add(self.0, other.0))
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self($sub(self.0, other.0))
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                Self($mul(self.0, other.0))
            }
        }
        // SAFETY: a register of that many numbers.
        unsafe impl Lanes<$float> for $name {
            const COUNT: usize = $count;

            #[inline(always)]
            fn splat(value: $float) -> Self {
                Self($splat(value))
            }
            #[inline(always)]
            fn load(from: &[$float]) -> Self {
                let from = &from[..$count];
                // SAFETY: `from` holds that many numbers; the load needs no alignment.
                Self(unsafe { v128_load(from.as_ptr().cast()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$float]) {
                let to = &mut to[..$count];
                // SAFETY: `to` holds that many numbers; the store needs no alignment.
                unsafe { v128_store(to.as_mut_ptr().cast(), self.0) }
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                self * factor + addend
            }
            #[inline(always)]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                addend - self * factor
            }
        }
    };
}

vector!(
    /// 4 × f32.
    F32x4 of 4 f32, f32x4_add, f32x4_sub, f32x4_mul, f32x4_splat
);
vector!(
    /// 2 × f64.
    F64x2 of 2 f64, f64x2_add, f64x2_sub, f64x2_mul, f64x2_splat
);
