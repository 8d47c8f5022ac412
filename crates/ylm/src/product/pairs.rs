//! Products of two functions row by row, one row a lane: what the sparse tensor and the straight-line code share.

use super::grid::kernel::{gather, scatter};
use crate::error::{Result, check_length};
use crate::simd::{Kernel, Lanes};
use crate::{Real, Workspace};

/// The most coefficients of a function: 32 bands.
const MAX_COEFFS: usize = super::gaunt::MAX_BANDS * super::gaunt::MAX_BANDS;

/// Coefficients stand where they stood.
static IN_PLACE: [u32; MAX_COEFFS] = {
    let mut slots = [0; MAX_COEFFS];
    let mut i = 0;
    while i < MAX_COEFFS {
        slots[i] = i as u32;
        i += 1;
    }
    slots
};

/// A product of two functions whose coefficients are vectors, one row a lane.
pub trait Pairwise<T> {
    /// Coefficients of a function, at most 32².
    fn coeff_count(&self) -> usize;
    /// Overwrites `product` with the product of `a` and `b`; implementations are `#[inline(always)]`.
    fn multiply<V: Lanes<T>>(&self, a: &[V], b: &[V], product: &mut [V]);
}

/// A batch of products.
pub struct Pairs<'a, T, P> {
    method: &'a P,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
    workspace: &'a mut Workspace,
}

impl<'a, T: Real, P: Pairwise<T>> Pairs<'a, T, P> {
    /// Shapes: all rows × the method's coefficients.
    ///
    /// # Errors
    /// If the lengths differ or are no whole rows.
    pub fn new(
        method: &'a P,
        a: &'a [T],
        b: &'a [T],
        out: &'a mut [T],
        workspace: &'a mut Workspace,
    ) -> Result<Self> {
        check_length("the product", out.len(), out.len() / method.coeff_count() * method.coeff_count())?;
        check_length("the first factor", a.len(), out.len())?;
        check_length("the second factor", b.len(), out.len())?;
        Ok(Self { method, a, b, out, workspace })
    }
}

impl<T: Real, P: Pairwise<T>> Kernel<T> for Pairs<'_, T, P> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { method, a, b, out, workspace } = self;
        let width = method.coeff_count();
        let slots = &IN_PLACE[..width];
        let (left, rest) = workspace.vectors::<T, V>(3 * width).split_at_mut(width);
        let (right, product) = rest.split_at_mut(width);
        let rows = width * V::COUNT;
        for ((a, b), out) in a.chunks(rows).zip(b.chunks(rows)).zip(out.chunks_mut(rows)) {
            let count = out.len() / width;
            gather::<T, V>(a, width, count, slots, left);
            gather::<T, V>(b, width, count, slots, right);
            method.multiply(left, right, product);
            scatter::<T, V>(product, slots, count, width, out);
        }
    }
}
