//! The matrices of a rotation, band from band.
//!
//! Harmonics of band l are sums of products of those of bands 1 and l − 1: Y_l = C_l (Y_1 ⊗ Y_{l−1}), where each row of
//! C_l has the up to five weights u, v, w of Ivanic and Ruedenberg. So R_l = C_l (R_1 ⊗ R_{l−1}) C_lᵀ.
//!
//! [Ivanic & Ruedenberg 1996] use the weights for the rows alone and reach each column through one of its products,
//! dividing by that product's weight. Where the weight is small errors grow: exponentially with l, to 2e-11 at 64
//! bands and beyond any meaning at 256. C_l has orthonormal rows; used on both sides, as here, nothing grows.
//!
//! The weights are those of [Ivanic & Ruedenberg 1996], Table 1 and 2, as corrected in [Ivanic & Ruedenberg 1998].
//! Their harmonics have no Condon–Shortley phase: an entry here is theirs times (−1)^(m + m′).

/// A product of C_l: its weight and the index of (i, μ) in 3 × (2l − 1) products, i of band 1, μ of band l − 1.
#[derive(Clone, Copy, Default)]
struct Term {
    weight: f64,
    i: usize,
    mu: usize,
}

/// The products of one harmonic; unused ones have weight 0.
type Terms = [Term; 5];

/// Brings the row-major matrices of bands 0 … n−1 of a rotation of space, one after the other.
pub fn band_matrices(rotation: [[f64; 3]; 3], n: usize, mut bring: impl FnMut(&[f64])) {
    bring(&[1.0]);
    if n == 1 {
        return;
    }
    // Orders −1, 0, 1 are y, z, x.
    const AXES: [usize; 3] = [1, 2, 0];
    let first = AXES.map(|row| AXES.map(|column| rotation[row][column]));
    let mut previous = first.concat();
    let mut signed = Vec::new();
    bring_signed(&previous, 1, &mut signed, &mut bring);
    for l in 2..n {
        previous = band_after(&previous, &first, l);
        bring_signed(&previous, l, &mut signed, &mut bring);
    }
}

/// Brings a matrix with the Condon–Shortley phase put in.
fn bring_signed(matrix: &[f64], l: usize, signed: &mut Vec<f64>, bring: &mut impl FnMut(&[f64])) {
    let size = 2 * l + 1;
    signed.clear();
    for (row, values) in matrix.chunks_exact(size).enumerate() {
        signed.extend(
            values.iter().enumerate().map(|(column, v)| if (row + column) % 2 == 0 { *v } else { -*v }),
        );
    }
    bring(signed);
}

/// The matrix of band `l` ≥ 2 from that of band l − 1 and that of band 1.
fn band_after(previous: &[f64], first: &[[f64; 3]; 3], l: usize) -> Vec<f64> {
    let (size, inner) = (2 * l + 1, 2 * l - 1);
    let terms: Vec<Terms> = (0..size).map(|order| terms(l, order as isize - l as isize)).collect();
    let mut matrix = vec![0.0; size * size];
    // Row m of C_l (R_1 ⊗ R_{l−1}): three rows, one for each column of R_1.
    let mut products = vec![0.0; 3 * inner];
    for (row, row_terms) in matrix.chunks_exact_mut(size).zip(&terms) {
        products.fill(0.0);
        for term in row_terms.iter().filter(|term| term.weight != 0.0) {
            let source = &previous[term.mu * inner..][..inner];
            for (products, entry) in products.chunks_exact_mut(inner).zip(first[term.i]) {
                for (product, value) in products.iter_mut().zip(source) {
                    *product += term.weight * entry * value;
                }
            }
        }
        for (entry, column_terms) in row.iter_mut().zip(&terms) {
            *entry = column_terms.iter().map(|term| term.weight * products[term.i * inner + term.mu]).sum();
        }
    }
    matrix
}

/// The row `m` of C_l, l ≥ 2.
fn terms(l: usize, m: isize) -> Terms {
    const MINUS: usize = 0;
    const ZERO: usize = 1;
    const PLUS: usize = 2;
    let (lf, mf) = (l as f64, m.unsigned_abs() as f64);
    let norm = 1.0 / (lf * (2.0 * lf - 1.0)).sqrt();
    let u = norm * ((lf + mf) * (lf - mf)).sqrt();
    let v = 0.5 * norm * ((lf + mf - 1.0) * (lf + mf)).sqrt();
    let w = -0.5 * norm * ((lf - mf - 1.0) * (lf - mf)).sqrt();
    let root_2 = std::f64::consts::SQRT_2;
    // V, then W: (weight, i, μ).
    let products = match m {
        0 => [(-v * root_2, PLUS, 1), (-v * root_2, MINUS, -1), (0.0, PLUS, 0), (0.0, PLUS, 0)],
        1 => [(v * root_2, PLUS, 0), (0.0, PLUS, 0), (w, PLUS, 2), (w, MINUS, -2)],
        -1 => [(v * root_2, MINUS, 0), (0.0, PLUS, 0), (w, PLUS, -2), (-w, MINUS, 2)],
        2.. => [(v, PLUS, m - 1), (-v, MINUS, 1 - m), (w, PLUS, m + 1), (w, MINUS, -m - 1)],
        _ => [(v, PLUS, m + 1), (v, MINUS, -m - 1), (w, PLUS, m - 1), (-w, MINUS, 1 - m)],
    };
    let mut terms = Terms::default();
    for (term, (weight, i, mu)) in terms.iter_mut().zip([(u, ZERO, m)].into_iter().chain(products)) {
        // At the ends u or w is 0, and there is no harmonic μ.
        if mu.unsigned_abs() < l {
            *term = Term { weight, i, mu: (mu + l as isize - 1) as usize };
        }
    }
    terms
}
