//! Plain arrays: the twin that every machine has, and the one that Miri and the tests compare with.

use std::ops::{Add, Mul, Sub};

use super::{Lanes, SimdReal};
use crate::Real;

/// `N` numbers in an array; the compiler vectorises what it can.
#[derive(Clone, Copy)]
pub struct Array<T, const N: usize>([T; N]);

macro_rules! operator {
    ($trait:ident, $method:ident, $symbol:tt) => {
        impl<T: Real, const N: usize> $trait for Array<T, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] $symbol other.0[i]))
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);

// SAFETY: an array of at most 4 f32 or 2 f64.
unsafe impl<T: Real, const N: usize> Lanes<T> for Array<T, N> {
    const COUNT: usize = N;
    const PLAIN: bool = true;

    #[inline(always)]
    fn splat(value: T) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn load(from: &[T]) -> Self {
        Self(std::array::from_fn(|i| from[..N][i]))
    }
    #[inline(always)]
    fn store(self, to: &mut [T]) {
        to[..N].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], addend.0[i])))
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        Self(std::array::from_fn(|i| (-self.0[i]).mul_add(factor.0[i], addend.0[i])))
    }
}

/// Every instruction set's vector types, named in one place.
macro_rules! impl_simd_real {
    ($float:ident, $portable:literal, $avx2:ident, $avx512:ident, $neon:ident, $wasm128:ident) => {
        impl SimdReal for $float {
            #[inline(always)]
            fn fused_mul_add(self, factor: Self, addend: Self) -> Self {
                <$float>::mul_add(self, factor, addend)
            }
            type Portable = Array<$float, $portable>;
            #[cfg(target_arch = "x86_64")]
            type Avx2 = super::x86::$avx2;
            #[cfg(target_arch = "x86_64")]
            type Avx512 = super::x86::$avx512;
            #[cfg(target_arch = "aarch64")]
            type Neon = super::neon::$neon;
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            type Wasm128 = super::wasm128::$wasm128;
        }
    };
}
impl_simd_real!(f32, 4, F32x8, F32x16, F32x4, F32x4);
impl_simd_real!(f64, 2, F64x4, F64x8, F64x2, F64x2);
