//! One algorithm, every instruction set.
//!
//! A kernel is written once over [`Lanes`], a vector of a few numbers. [`Level::run`] instantiates it for an
//! instruction set inside a function compiled for that set; everything the kernel calls on the way down to the
//! vectors is `#[inline(always)]`, so that it is compiled for that set too. `array::map` and iterators of arrays are not:
//! a kernel loops over indices instead.
//!
//! Invariant: a vector type of an instruction set is only ever named by [`Level::run`], and a [`Level`] above
//! [`Level::Portable`] only ever comes from detection. That is what makes the safe methods of [`Lanes`] sound; the
//! module is private to the crate for the same reason.

mod counted;
mod portable;

#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm128;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, Mul, Sub};

use crate::Real;

pub use counted::{Operations, count};

/// The most numbers that any vector has; every vector's count divides it.
pub const MAX_COUNT: usize = 16;

/// One number as a vector, for code that is written over [`Lanes`] and called on one item.
pub type Single<T> = portable::Array<T, 1>;

/// A vector of [`Lanes::COUNT`] numbers.
///
/// # Safety
/// An implementor is `COUNT` numbers and nothing else, at most 64 bytes, aligned to at most 64: [`crate::Workspace`]
/// makes vectors of plain memory.
pub unsafe trait Lanes<T>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Numbers in the vector.
    const COUNT: usize;
    /// Whether it is an array rather than a vector register.
    const PLAIN: bool = false;

    /// All lanes the same.
    fn splat(value: T) -> Self;
    /// The first `COUNT` numbers of `from`; panics if there are fewer.
    fn load(from: &[T]) -> Self;
    /// Writes the first `COUNT` numbers of `to`; panics if there are fewer.
    fn store(self, to: &mut [T]);
    /// `self · factor + addend`.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// `addend − self · factor`.
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self;

    /// Writes lane i of row r to `to[i · stride + r]`; panics if `to` ends before the last of them.
    #[inline(always)]
    fn store_transposed(rows: [Self; 4], to: &mut [T], stride: usize)
    where
        T: Real,
    {
        let mut lanes = [[T::ZERO; MAX_COUNT]; 4];
        for (row, lanes) in rows.into_iter().zip(&mut lanes) {
            row.store(lanes);
        }
        for i in 0..Self::COUNT {
            for (r, lanes) in lanes.iter().enumerate() {
                to[i * stride + r] = lanes[i];
            }
        }
    }

    /// Row r has `from[i · stride + r]` in lane i; panics if `from` ends before the last of them.
    #[inline(always)]
    fn load_transposed(from: &[T], stride: usize) -> [Self; 4]
    where
        T: Real,
    {
        let mut lanes = [[T::ZERO; MAX_COUNT]; 4];
        for i in 0..Self::COUNT {
            for (r, lanes) in lanes.iter_mut().enumerate() {
                lanes[i] = from[i * stride + r];
            }
        }
        lanes.map(|lanes| Self::load(&lanes))
    }
}

/// An algorithm that runs on any vector type.
pub trait Kernel<T> {
    /// What it returns.
    type Output;
    /// Runs it; implementations are `#[inline(always)]`.
    fn run<V: Lanes<T>>(self) -> Self::Output;
}

/// The vector types of a number type, one for each instruction set. Sealed: `f32` and `f64`.
pub trait SimdReal: Copy {
    /// `self · factor + addend` in one instruction; slow where the code is not compiled for one.
    fn fused_mul_add(self, factor: Self, addend: Self) -> Self;

    /// Plain arrays.
    type Portable: Lanes<Self>;
    /// 256 bits.
    #[cfg(target_arch = "x86_64")]
    type Avx2: Lanes<Self>;
    /// 512 bits.
    #[cfg(target_arch = "x86_64")]
    type Avx512: Lanes<Self>;
    /// 128 bits.
    #[cfg(target_arch = "aarch64")]
    type Neon: Lanes<Self>;
    /// 128 bits.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    type Wasm128: Lanes<Self>;
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Isa);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Isa {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Wasm128,
}

impl Level {
    /// Plain arrays, on every machine.
    pub const PORTABLE: Level = Level(Isa::Portable);

    /// The instruction sets of this machine, portable first, best last.
    pub fn available() -> Vec<Level> {
        #[allow(unused_mut, reason = "some machines have the portable level alone")]
        let mut levels = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 {
                levels.push(Level(Isa::Avx2));
            }
            if avx2 && is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                levels.push(Level(Isa::Avx512));
            }
        }
        #[cfg(target_arch = "aarch64")]
        levels.push(Level(Isa::Neon));
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        levels.push(Level(Isa::Wasm128));
        levels
    }

    /// The best instruction set of this machine. Detected once.
    pub fn best() -> Level {
        static BEST: std::sync::OnceLock<Level> = std::sync::OnceLock::new();
        *BEST.get_or_init(|| *Self::available().last().expect("portable is always there"))
    }

    /// The name as users know it: "AVX-512".
    pub fn name(self) -> &'static str {
        match self.0 {
            Isa::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => "AVX-512",
            #[cfg(target_arch = "aarch64")]
            Isa::Neon => "NEON",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Isa::Wasm128 => "SIMD128",
        }
    }

    /// Runs a kernel on single numbers, compiled for this level: its multiply-adds are one instruction where it has one.
    #[inline]
    pub fn run_single<T: Real, K: Kernel<T>>(self, kernel: K) -> K::Output {
        match self.0 {
            // SAFETY: `available` made this level after detecting the features.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 | Isa::Avx512 => unsafe { x86::run_fused::<T, K>(kernel) },
            _ => kernel.run::<Single<T>>(),
        }
    }

    /// Numbers in a vector of this level.
    pub fn lane_count<T: Real>(self) -> usize {
        struct Count;
        impl<T> Kernel<T> for Count {
            type Output = usize;
            fn run<V: Lanes<T>>(self) -> usize {
                V::COUNT
            }
        }
        self.run::<T, _>(Count)
    }

    /// Runs a kernel compiled for this level. The cost of the choice is one branch: dispatch once a batch.
    #[inline]
    pub fn run<T: Real, K: Kernel<T>>(self, kernel: K) -> K::Output {
        match self.0 {
            Isa::Portable => kernel.run::<T::Portable>(),
            // SAFETY: `available` made this level after detecting the features.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { x86::run_avx2::<T, K>(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { x86::run_avx512::<T, K>(kernel) },
            #[cfg(target_arch = "aarch64")]
            Isa::Neon => kernel.run::<T::Neon>(),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Isa::Wasm128 => kernel.run::<T::Wasm128>(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All operations on the first vectors of a, b, c.
    struct Operations<'a, T>(&'a [T], &'a [T], &'a [T]);

    impl<T: Real> Kernel<T> for Operations<'_, T> {
        type Output = Vec<Vec<T>>;
        fn run<V: Lanes<T>>(self) -> Self::Output {
            let (a, b, c) = (V::load(self.0), V::load(self.1), V::load(self.2));
            [a + b, a - b, a * b, a.mul_add(b, c), a.neg_mul_add(b, c), V::splat(self.0[1])]
                .map(|v| {
                    let mut out = vec![T::ZERO; V::COUNT];
                    v.store(&mut out);
                    out
                })
                .to_vec()
        }
    }

    /// Four functions of the lanes of a vector, stored four to a lane with a gap of one.
    struct Transposed<'a, T>(&'a [T]);

    impl<T: Real> Kernel<T> for Transposed<'_, T> {
        type Output = Vec<T>;
        fn run<V: Lanes<T>>(self) -> Self::Output {
            let a = V::load(self.0);
            let mut out = vec![T::ZERO; 5 * V::COUNT];
            V::store_transposed([a, a + a, a * a, a - V::splat(self.0[1])], &mut out, 5);
            let rows = V::load_transposed(&out, 5);
            let mut back = vec![T::ZERO; 5 * V::COUNT];
            V::store_transposed(rows, &mut back, 5);
            assert_eq!(out, back);
            let mut first = vec![T::ZERO; V::COUNT];
            rows[0].store(&mut first);
            assert_eq!(first, self.0[..V::COUNT]);
            out
        }
    }

    fn every_level_agrees<T: Real>() {
        // Small integers and halves: every operation is exact, so fused and unfused agree to the bit.
        let numbers = |scale: f64| (0..16).map(|i| T::from_f64((i as f64 - 7.0) * scale)).collect::<Vec<_>>();
        let (a, b, c) = (numbers(1.0), numbers(-0.5), numbers(3.0));
        for level in Level::available() {
            let results = level.run::<T, _>(Operations(&a, &b, &c));
            let transposed = level.run::<T, _>(Transposed(&a));
            for (i, rows) in transposed.chunks(5).enumerate() {
                let expected = [a[i], a[i] + a[i], a[i] * a[i], a[i] - a[1], T::ZERO];
                assert_eq!(rows, expected, "{} lane {i}", level.name());
            }
            for lane in 0..level.lane_count::<T>() {
                let (a, b, c) = (a[lane], b[lane], c[lane]);
                let expected = [a + b, a - b, a * b, a * b + c, c - a * b, T::from_f64(-6.0)];
                for (result, expected) in results.iter().zip(expected) {
                    assert_eq!(result[lane], expected, "{} lane {lane}", level.name());
                }
            }
        }
    }

    #[test]
    fn single_numbers_are_computed_the_same_at_every_level() {
        let results = |level: Level| level.run_single::<f32, _>(Operations(&[3.0, -6.0], &[0.5], &[2.0]));
        for level in Level::available() {
            assert_eq!(results(level)[3..5], [[3.5], [0.5]], "{}", level.name());
        }
    }

    #[test]
    fn every_level_computes_the_same_f32() {
        every_level_agrees::<f32>();
    }

    #[test]
    fn every_level_computes_the_same_f64() {
        every_level_agrees::<f64>();
    }
}
