//! A vector of eight numbers, for each instruction set.
//!
//! Invariant: `Avx2` is only ever named by [`Isa`]'s dispatch, and an [`Isa`] above portable only ever comes from detection. That is
//! what makes the safe methods of [`Lanes`] sound.

use super::node::WIDTH;

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// Plain arrays.
    Portable,
    /// 256 bits and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 256 bits too, with the 32 registers and the masks of AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// Portable first, best last.
    pub fn available() -> Vec<Isa> {
        #[allow(unused_mut, reason = "some machines have the portable one alone")]
        let mut available = vec![Isa::Portable];
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
        {
            available.push(Isa::Avx2);
            let avx512 = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
            if avx512 && is_x86_feature_detected!("avx512dq") {
                available.push(Isa::Avx512);
            }
        }
        available
    }

    /// The best of this machine.
    pub fn best() -> Isa {
        *Self::available().last().expect("portable is always there")
    }
}

/// Eight numbers.
pub trait Lanes: Copy {
    fn splat(value: f32) -> Self;
    fn load(from: &[f32; WIDTH]) -> Self;
    fn store(self, to: &mut [f32; WIDTH]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// `self · factor − subtrahend`, rounded once or twice as the machine has it: only where rounding is covered.
    fn mul_sub(self, factor: Self, subtrahend: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    /// Bit i: lane i of `self` ≤ lane i of `other`.
    fn le(self, other: Self) -> u32;
    /// Bit i: the lanes differ.
    fn ne(self, other: Self) -> u32;
    /// Bit r of result c: bit c of byte r.
    fn transpose(bytes: &[u8; 64]) -> [u64; WIDTH];
}

/// Plain arrays.
#[derive(Clone, Copy)]
pub struct Portable([f32; WIDTH]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..WIDTH).fold(0, |bits, i| bits | u32::from(f(self.0[i], other.0[i])) << i)
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; WIDTH])
    }
    #[inline(always)]
    fn load(from: &[f32; WIDTH]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; WIDTH]) {
        *to = self.0;
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, subtrahend: Self) -> Self {
        self.mul(factor).sub(subtrahend)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn ne(self, other: Self) -> u32 {
        self.bits(other, |a, b| a != b)
    }
    #[inline(always)]
    fn transpose(bytes: &[u8; 64]) -> [u64; WIDTH] {
        let mut columns = [0; WIDTH];
        for (group, eight) in bytes.chunks_exact(8).enumerate() {
            // Swaps bits, pairs and quads across the diagonal. [Warren 2012] "Hacker's Delight", 7-3
            let mut x = u64::from_le_bytes(eight.try_into().expect("eight bytes"));
            for (shift, mask) in [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0xf0f0_f0f0)]
            {
                let swap = (x ^ (x >> shift)) & mask;
                x ^= swap ^ (swap << shift);
            }
            for (column, byte) in columns.iter_mut().zip(x.to_le_bytes()) {
                *column |= u64::from(byte) << (8 * group);
            }
        }
        columns
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Lanes, WIDTH};

    /// 256 bits.
    #[derive(Clone, Copy)]
    pub struct Avx2(__m256);

    // SAFETY (all blocks below): the instruction set is there, by the invariant of the module `lanes`; loads and
    // stores go through references to whole arrays.
    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_set1_ps(value) })
        }
        #[inline(always)]
        fn load(from: &[f32; WIDTH]) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; WIDTH]) {
            // SAFETY: above.
            unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn div(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_div_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul_sub(self, factor: Self, subtrahend: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, subtrahend.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> u32 {
            // SAFETY: above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn ne(self, other: Self) -> u32 {
            // SAFETY: above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn transpose(bytes: &[u8; 64]) -> [u64; WIDTH] {
            // SAFETY: above.
            unsafe {
                let low = _mm256_loadu_si256(bytes.as_ptr().cast());
                let high = _mm256_loadu_si256(bytes.as_ptr().add(32).cast());
                let mut columns = [0; WIDTH];
                for c in 0..WIDTH {
                    let shift = _mm_cvtsi32_si128(7 - c as i32);
                    let low = _mm256_movemask_epi8(_mm256_sll_epi64(low, shift)) as u32;
                    let high = _mm256_movemask_epi8(_mm256_sll_epi64(high, shift)) as u32;
                    columns[c] = u64::from(low) | u64::from(high) << 32;
                }
                columns
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::Avx2;
