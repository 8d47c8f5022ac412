//! The product of each point's visibilities, points with as many factors together.

use ylm::product::plan::MAX_FACTORS;
use ylm::product::{Method, chain, plan};
use ylm::{Bands, Workspace};

use super::FieldProduct;
use super::seen::Seen;
use crate::error::{Error, Result};
use crate::field::WHITE;

/// Multiplies visibilities.
pub struct Multiply {
    pub bands: Bands,
    pub product: FieldProduct,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct Scratch {
    /// The chosen pairs of each point, with the factor that each goes into, and where they begin.
    pairs: Vec<(u32, u8)>,
    starts: Vec<usize>,
    /// How many factors beside its own visibility each point has.
    counts: Vec<usize>,
    /// The groups that the factors of a point stand for.
    groups: Vec<u8>,
    group: Vec<usize>,
    factors: Vec<Vec<f32>>,
    out: Vec<f32>,
}

impl Multiply {
    /// Writes the visibility of points behind all objects of pairs that `counts` takes.
    ///
    /// Shapes: `own` and `out` are points × n².
    pub fn all(
        &self,
        own: &[f32],
        seen: &Seen,
        counts: &dyn Fn(usize) -> bool,
        out: &mut [f32],
        scratch: &mut Scratch,
        workspace: &mut Workspace,
    ) -> Result<()> {
        let width = self.bands.coeff_count();
        let point_count = own.len() / width;
        let Scratch { pairs, starts, counts: factor_counts, groups, group, factors, out: product } = scratch;
        pairs.clear();
        starts.clear();
        factor_counts.clear();
        for point in 0..point_count {
            starts.push(pairs.len());
            groups.clear();
            for pair in seen.pairs_of(point).filter(|&pair| counts(pair)) {
                let group = seen.group_of(pair);
                let factor = groups.iter().position(|known| *known == group).unwrap_or_else(|| {
                    groups.push(group);
                    groups.len() - 1
                });
                pairs.push((pair as u32, factor as u8));
            }
            factor_counts.push(groups.len());
        }
        starts.push(pairs.len());
        let count_of = |point: usize| factor_counts[point];
        let most = factor_counts.iter().copied().max().unwrap_or(0);
        if most + 1 > MAX_FACTORS {
            return Err(Error::Request(format!(
                "{most} objects in front of each other hide something from one point, and a product has at most {}; take fields \
                 with a larger --error, which reach less far",
                MAX_FACTORS - 1
            )));
        }
        for count in 0..=most {
            group.clear();
            group.extend((0..point_count).filter(|&point| count_of(point) == count));
            if count == 0 {
                for &point in &*group {
                    let range = point * width..(point + 1) * width;
                    out[range.clone()].copy_from_slice(&own[range]);
                }
                continue;
            }
            if group.is_empty() {
                continue;
            }
            factors.resize_with(factors.len().max(count + 1), Vec::new);
            factors.iter_mut().for_each(Vec::clear);
            for &point in &*group {
                let first = factors[0].len();
                factors[0].extend_from_slice(&own[point * width..(point + 1) * width]);
                for &(pair, factor) in &pairs[starts[point]..starts[point + 1]] {
                    let row = &seen.rows()[pair as usize * width..][..width];
                    let factor = &mut factors[1 + usize::from(factor)];
                    if factor.len() == first {
                        factor.extend_from_slice(row);
                    } else {
                        // What is blocked adds up: 1 − A − B.
                        let sum = &mut factor[first..];
                        sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
                        sum[0] -= WHITE;
                    }
                }
            }
            product.resize(group.len() * width, 0.0);
            let factors: Vec<&[f32]> = factors[..=count].iter().map(Vec::as_slice).collect();
            match self.product {
                FieldProduct::Chain | FieldProduct::SparseChain => {
                    let method = match self.product {
                        FieldProduct::SparseChain => Method::Gaunt,
                        _ => Method::Auto,
                    };
                    chain::product(&factors, product, |a, b, out| {
                        plan::product_in(self.bands, &[a, b], method, out, workspace)
                    })?;
                }
                _ => plan::product_in(self.bands, &factors, Method::Auto, product, workspace)?,
            }
            for (&point, row) in group.iter().zip(product.chunks_exact(width)) {
                out[point * width..(point + 1) * width].copy_from_slice(row);
            }
        }
        Ok(())
    }
}
