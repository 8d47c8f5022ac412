//! Sums of chosen rows of a table.

/// Rows are padded to a multiple of this.
pub const ROW_UNIT: usize = 8;

/// Words of bits after which a partial sum is closed: keeps the rounding of long sums down.
const WORDS_A_PART: usize = 16;

/// Writes to `sum` the sum of those rows of `table` whose bits are set.
///
/// Shapes: `table` [row, width], width a multiple of [`ROW_UNIT`]; `bits` one bit a row; `sum` width.
/// The order of additions is fixed, so every instruction set gives the same sum.
pub fn sum_rows(table: &[f32], bits: &[u64], sum: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1") {
        // SAFETY: just detected.
        return unsafe { sum_rows_avx2(table, bits, sum) };
    }
    sum_rows_in(table, bits, sum)
}

/// # Safety
/// The machine has AVX2 and BMI1.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1")]
unsafe fn sum_rows_avx2(table: &[f32], bits: &[u64], sum: &mut [f32]) {
    sum_rows_in(table, bits, sum)
}

// The compiler vectorises the loops over columns for the instruction set at hand.
#[inline(always)]
fn sum_rows_in(table: &[f32], bits: &[u64], sum: &mut [f32]) {
    let width = sum.len();
    sum.fill(0.0);
    for (part, bits) in bits.chunks(WORDS_A_PART).enumerate() {
        let table = &table[part * WORDS_A_PART * 64 * width..];
        let mut column = 0;
        while width - column >= 8 * ROW_UNIT {
            add_columns::<{ 8 * ROW_UNIT }>(table, bits, column, sum);
            column += 8 * ROW_UNIT;
        }
        while width - column >= 4 * ROW_UNIT {
            add_columns::<{ 4 * ROW_UNIT }>(table, bits, column, sum);
            column += 4 * ROW_UNIT;
        }
        while column < width {
            add_columns::<ROW_UNIT>(table, bits, column, sum);
            column += ROW_UNIT;
        }
    }
}

/// Adds `N` columns from `first`, held in registers.
#[inline(always)]
fn add_columns<const N: usize>(table: &[f32], bits: &[u64], first: usize, sum: &mut [f32]) {
    let width = sum.len();
    let mut total = [0.0f32; N];
    for (word, &bits) in bits.iter().enumerate() {
        let mut bits = bits;
        while bits != 0 {
            let row = word * 64 + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let values = &table[row * width + first..][..N];
            for k in 0..N {
                total[k] += values[k];
            }
        }
    }
    for k in 0..N {
        sum[first + k] += total[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_rows_are_summed_on_every_instruction_set() {
        for (width, rows) in [(8usize, 1usize), (40, 65), (128, 1500), (104, 64)] {
            let table: Vec<f32> = (0..rows * width).map(|i| (i % 1009) as f32 - 500.0).collect();
            let mut bits = vec![0u64; rows.div_ceil(64)];
            let mut expected = vec![0.0; width];
            for row in (0..rows).filter(|row| row * row % 7 < 4) {
                bits[row / 64] |= 1 << (row % 64);
                for k in 0..width {
                    // Whole numbers below 2^24: exact.
                    expected[k] += table[row * width + k];
                }
            }
            let (mut best, mut portable) = (vec![f32::NAN; width], vec![f32::NAN; width]);
            sum_rows(&table, &bits, &mut best);
            sum_rows_in(&table, &bits, &mut portable);
            assert_eq!(best, expected);
            assert_eq!(portable, expected);
        }
    }
}
