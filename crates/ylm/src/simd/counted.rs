//! A vector that counts what is done to it: how the operations of a kernel are told without a formula for them.

use std::cell::Cell;
use std::ops::{Add, Mul, Sub};

use super::{Kernel, Lanes, MAX_COUNT};

/// How many operations on numbers a kernel takes; a multiply-add is one of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Multiplications.
    pub multiplications: u64,
    /// Additions and subtractions.
    pub additions: u64,
}

impl Operations {
    /// Both together: what a machine without multiply-adds has to do.
    pub fn total(self) -> u64 {
        self.multiplications + self.additions
    }
}

impl Add for Operations {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            multiplications: self.multiplications + other.multiplications,
            additions: self.additions + other.additions,
        }
    }
}

thread_local! {
    static DONE: Cell<Operations> = const { Cell::new(Operations { multiplications: 0, additions: 0 }) };
}

/// The operations on vectors that a kernel takes. With a whole batch of side-by-side items that is what one of them takes.
pub fn count<K: Kernel<f32>>(kernel: K) -> Operations {
    let before = DONE.replace(Operations::default());
    kernel.run::<Counted>();
    DONE.replace(before)
}

fn done(multiplications: u64, additions: u64) {
    DONE.set(DONE.get() + Operations { multiplications, additions });
}

#[derive(Clone, Copy)]
struct Counted([f32; MAX_COUNT]);

impl Counted {
    fn of(value: impl FnMut(usize) -> f32) -> Self {
        Self(std::array::from_fn(value))
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        done(0, 1);
        Self::of(|i| self.0[i] + other.0[i])
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        done(0, 1);
        Self::of(|i| self.0[i] - other.0[i])
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        done(1, 0);
        Self::of(|i| self.0[i] * other.0[i])
    }
}

// SAFETY: 16 f32 and nothing else: 64 bytes.
unsafe impl Lanes<f32> for Counted {
    const COUNT: usize = MAX_COUNT;

    fn splat(value: f32) -> Self {
        Self([value; MAX_COUNT])
    }
    fn load(from: &[f32]) -> Self {
        Self::of(|i| from[..MAX_COUNT][i])
    }
    fn store(self, to: &mut [f32]) {
        to[..MAX_COUNT].copy_from_slice(&self.0);
    }
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        done(1, 1);
        Self::of(|i| self.0[i] * factor.0[i] + addend.0[i])
    }
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        done(1, 1);
        Self::of(|i| addend.0[i] - self.0[i] * factor.0[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Some;

    impl Kernel<f32> for Some {
        type Output = ();
        fn run<V: Lanes<f32>>(self) {
            let a = V::load(&[2.0; MAX_COUNT]);
            let mut out = [0.0; MAX_COUNT];
            ((a + a) * a - a.mul_add(a, a)).neg_mul_add(V::splat(3.0), a).store(&mut out);
            // a − 3 (2 a² − a² − a) of 2.
            assert_eq!(out[..V::COUNT], vec![-4.0; V::COUNT]);
        }
    }

    #[test]
    fn every_operation_is_counted_once() {
        assert_eq!(count(Some), Operations { multiplications: 3, additions: 4 });
        assert_eq!(count(Some).total(), 7);
    }
}
