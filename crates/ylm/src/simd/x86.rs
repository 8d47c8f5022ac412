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

/// # Safety
/// The machine has AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn run_fused<T: Real, K: Kernel<T>>(kernel: K) -> K::Output {
    kernel.run::<Fused<T>>()
}

/// One number, multiplied and added in one instruction.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Fused<T>(T);

impl<T: Real> Add for Fused<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}
impl<T: Real> Sub for Fused<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}
impl<T: Real> Mul for Fused<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}
// SAFETY: one number.
unsafe impl<T: Real> Lanes<T> for Fused<T> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn splat(value: T) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn load(from: &[T]) -> Self {
        Self(from[0])
    }
    #[inline(always)]
    fn store(self, to: &mut [T]) {
        to[0] = self.0;
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(self.0.fused_mul_add(factor.0, addend.0))
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        Self((-self.0).fused_mul_add(factor.0, addend.0))
    }
}

macro_rules! vector {
    (
        $(#[$doc:meta])* $name:ident: $raw:ident of $count:literal $float:ident,
        $add:ident, $sub:ident, $mul:ident, $fmadd:ident, $fnmadd:ident, $splat:ident, $load:ident, $store:ident,
        $store_transposed:ident, $load_transposed:ident
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
        // SAFETY: a register of that many numbers.
        unsafe impl Lanes<$float> for $name {
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
            #[inline(always)]
            fn store_transposed(rows: [Self; 4], to: &mut [$float], stride: usize) {
                let to = &mut to[..($count - 1) * stride + 4];
                // SAFETY: above, and the last four numbers written are the last four of `to`.
                unsafe { $store_transposed([rows[0].0, rows[1].0, rows[2].0, rows[3].0], to.as_mut_ptr(), stride) }
            }
            #[inline(always)]
            fn load_transposed(from: &[$float], stride: usize) -> [Self; 4] {
                let from = &from[..($count - 1) * stride + 4];
                // SAFETY: above, and the last four numbers read are the last four of `from`.
                let [a, b, c, d] = unsafe { $load_transposed(from.as_ptr(), stride) };
                [Self(a), Self(b), Self(c), Self(d)]
            }
        }
    };
}

vector!(
    /// 8 × f32.
    F32x8: __m256 of 8 f32,
    _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_set1_ps,
    _mm256_loadu_ps, _mm256_storeu_ps, store_f32x8, load_f32x8
);
vector!(
    /// 4 × f64.
    F64x4: __m256d of 4 f64,
    _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_set1_pd,
    _mm256_loadu_pd, _mm256_storeu_pd, store_f64x4, load_f64x4
);
vector!(
    /// 16 × f32.
    F32x16: __m512 of 16 f32,
    _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_fmadd_ps, _mm512_fnmadd_ps, _mm512_set1_ps,
    _mm512_loadu_ps, _mm512_storeu_ps, store_f32x16, load_f32x16
);
vector!(
    /// 8 × f64.
    F64x8: __m512d of 8 f64,
    _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_set1_pd,
    _mm512_loadu_pd, _mm512_storeu_pd, store_f64x8, load_f64x8
);

// Transposition: 4 × 4 within each 128-bit quarter by unpacking, the quarters to and from memory one by one.
//
// Plain loops: `array::map` and an array's iterator may stay calls, and those lack the instruction set.
//
// # Safety
// The machine has the instruction set, and memory may be accessed from 0 to (lanes − 1) · stride + 4.

#[inline(always)]
unsafe fn transpose_f32x8([a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    // SAFETY: the caller's.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        let (ab, cd) = (_mm256_castps_pd(ab), _mm256_castps_pd(cd));
        let (ab_high, cd_high) = (_mm256_castps_pd(ab_high), _mm256_castps_pd(cd_high));
        [
            _mm256_castpd_ps(_mm256_unpacklo_pd(ab, cd)),
            _mm256_castpd_ps(_mm256_unpackhi_pd(ab, cd)),
            _mm256_castpd_ps(_mm256_unpacklo_pd(ab_high, cd_high)),
            _mm256_castpd_ps(_mm256_unpackhi_pd(ab_high, cd_high)),
        ]
    }
}

#[inline(always)]
unsafe fn store_f32x8(rows: [__m256; 4], to: *mut f32, stride: usize) {
    // SAFETY: the caller's.
    unsafe {
        let lanes = transpose_f32x8(rows);
        for i in 0..4 {
            _mm_storeu_ps(to.add(i * stride), _mm256_castps256_ps128(lanes[i]));
            _mm_storeu_ps(to.add((4 + i) * stride), _mm256_extractf128_ps::<1>(lanes[i]));
        }
    }
}

#[inline(always)]
unsafe fn load_f32x8(from: *const f32, stride: usize) -> [__m256; 4] {
    // SAFETY: the caller's.
    unsafe {
        let mut lanes = [_mm256_setzero_ps(); 4];
        for i in 0..4 {
            let low = _mm256_castps128_ps256(_mm_loadu_ps(from.add(i * stride)));
            lanes[i] = _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(from.add((4 + i) * stride)));
        }
        transpose_f32x8(lanes)
    }
}

#[inline(always)]
unsafe fn transpose_f32x16([a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    // SAFETY: the caller's.
    unsafe {
        let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        let (ab, cd) = (_mm512_castps_pd(ab), _mm512_castps_pd(cd));
        let (ab_high, cd_high) = (_mm512_castps_pd(ab_high), _mm512_castps_pd(cd_high));
        [
            _mm512_castpd_ps(_mm512_unpacklo_pd(ab, cd)),
            _mm512_castpd_ps(_mm512_unpackhi_pd(ab, cd)),
            _mm512_castpd_ps(_mm512_unpacklo_pd(ab_high, cd_high)),
            _mm512_castpd_ps(_mm512_unpackhi_pd(ab_high, cd_high)),
        ]
    }
}

#[inline(always)]
unsafe fn store_f32x16(rows: [__m512; 4], to: *mut f32, stride: usize) {
    // SAFETY: the caller's.
    unsafe {
        let lanes = transpose_f32x16(rows);
        for i in 0..4 {
            _mm_storeu_ps(to.add(i * stride), _mm512_castps512_ps128(lanes[i]));
            _mm_storeu_ps(to.add((4 + i) * stride), _mm512_extractf32x4_ps::<1>(lanes[i]));
            _mm_storeu_ps(to.add((8 + i) * stride), _mm512_extractf32x4_ps::<2>(lanes[i]));
            _mm_storeu_ps(to.add((12 + i) * stride), _mm512_extractf32x4_ps::<3>(lanes[i]));
        }
    }
}

#[inline(always)]
unsafe fn load_f32x16(from: *const f32, stride: usize) -> [__m512; 4] {
    // SAFETY: the caller's.
    unsafe {
        let mut lanes = [_mm512_setzero_ps(); 4];
        for i in 0..4 {
            let low = _mm512_castps128_ps512(_mm_loadu_ps(from.add(i * stride)));
            let low = _mm512_insertf32x4::<1>(low, _mm_loadu_ps(from.add((4 + i) * stride)));
            let low = _mm512_insertf32x4::<2>(low, _mm_loadu_ps(from.add((8 + i) * stride)));
            lanes[i] = _mm512_insertf32x4::<3>(low, _mm_loadu_ps(from.add((12 + i) * stride)));
        }
        transpose_f32x16(lanes)
    }
}

#[inline(always)]
unsafe fn transpose_f64x4([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: the caller's.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(ab, cd),
            _mm256_permute2f128_pd::<0x20>(ab_high, cd_high),
            _mm256_permute2f128_pd::<0x31>(ab, cd),
            _mm256_permute2f128_pd::<0x31>(ab_high, cd_high),
        ]
    }
}

#[inline(always)]
unsafe fn store_f64x4(rows: [__m256d; 4], to: *mut f64, stride: usize) {
    // SAFETY: the caller's.
    unsafe {
        let lanes = transpose_f64x4(rows);
        for i in 0..4 {
            _mm256_storeu_pd(to.add(i * stride), lanes[i]);
        }
    }
}

#[inline(always)]
unsafe fn load_f64x4(from: *const f64, stride: usize) -> [__m256d; 4] {
    // SAFETY: the caller's.
    unsafe {
        let mut lanes = [_mm256_setzero_pd(); 4];
        for i in 0..4 {
            lanes[i] = _mm256_loadu_pd(from.add(i * stride));
        }
        transpose_f64x4(lanes)
    }
}

#[inline(always)]
unsafe fn store_f64x8(rows: [__m512d; 4], to: *mut f64, stride: usize) {
    // SAFETY: the caller's, once for either half of the lanes.
    unsafe {
        let (mut low, mut high) = ([_mm256_setzero_pd(); 4], [_mm256_setzero_pd(); 4]);
        for i in 0..4 {
            low[i] = _mm512_castpd512_pd256(rows[i]);
            high[i] = _mm512_extractf64x4_pd::<1>(rows[i]);
        }
        store_f64x4(low, to, stride);
        store_f64x4(high, to.add(4 * stride), stride);
    }
}

#[inline(always)]
unsafe fn load_f64x8(from: *const f64, stride: usize) -> [__m512d; 4] {
    // SAFETY: the caller's, once for either half of the lanes.
    unsafe {
        let (low, high) = (load_f64x4(from, stride), load_f64x4(from.add(4 * stride), stride));
        let mut lanes = [_mm512_setzero_pd(); 4];
        for i in 0..4 {
            lanes[i] = _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low[i]), high[i]);
        }
        lanes
    }
}
