//! AVX2 with FMA, and AVX-512.

use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

use super::{Kernel, Lanes};
use crate::Real;

/// # Safety
/// The machine has AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn run_avx2<T: Real, K: Kernel<T>>(kernel: K) -> K::Output {
    kernel.run::<T::Avx2>()
}

/// # Safety
/// The machine has AVX-512 F and DQ.
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
pub unsafe fn run_avx512<T: Real, K: Kernel<T>>(kernel: K) -> K::Output {
    kernel.run::<T::Avx512>()
}

macro_rules! vector {
    (
        $(#[$doc:meta])* $name:ident: $raw:ident of $count:literal $float:ident,
        $add:ident, $sub:ident, $mul:ident, $fmadd:ident, $fnmadd:ident, $splat:ident, $load:ident, $store:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($raw);

        // SAFETY (all blocks below): the instruction set is there, by the invariant of the module `simd`.
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: above.
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: above.
                Self(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: above.
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        impl Lanes<$float> for $name {
            const COUNT: usize = $count;

            #[inline(always)]
            fn splat(value: $float) -> Self {
                // SAFETY: above.
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            fn load(from: &[$float]) -> Self {
                let from = &from[..$count];
                // SAFETY: above, and `from` holds that many numbers; the load needs no alignment.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$float]) {
                let to = &mut to[..$count];
                // SAFETY: above, and `to` holds that many numbers; the store needs no alignment.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                // SAFETY: above.
                Self(unsafe { $fmadd(self.0, factor.0, addend.0) })
            }
            #[inline(always)]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                // SAFETY: above.
                Self(unsafe { $fnmadd(self.0, factor.0, addend.0) })
            }
        }
    };
}

vector!(
    /// 8 × f32.
    F32x8: __m256 of 8 f32,
    _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_set1_ps,
    _mm256_loadu_ps, _mm256_storeu_ps
);
vector!(
    /// 4 × f64.
    F64x4: __m256d of 4 f64,
    _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_set1_pd,
    _mm256_loadu_pd, _mm256_storeu_pd
);
vector!(
    /// 16 × f32.
    F32x16: __m512 of 16 f32,
    _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_fmadd_ps, _mm512_fnmadd_ps, _mm512_set1_ps,
    _mm512_loadu_ps, _mm512_storeu_ps
);
vector!(
    /// 8 × f64.
    F64x8: __m512d of 8 f64,
    _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_set1_pd,
    _mm512_loadu_pd, _mm512_storeu_pd
);
