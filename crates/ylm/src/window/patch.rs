//! A piece of the sphere on which a function is a polynomial of two angles, in Bernstein form: nowhere on the piece is it
//! below the least coefficient.

use std::sync::OnceLock;

/// Values along an edge of a patch.
pub const NODES: usize = 8;

/// The polynomial of degree 7 in each of two directions through 8 × 8 equally spaced values.
///
/// [Lane & Riesenfeld 1981] "Bounds on a polynomial": halving a patch brings the bound four times nearer.
#[derive(Clone)]
pub struct Patch {
    /// Bernstein coefficients, [θ, φ].
    coeffs: [[f64; NODES]; NODES],
    /// Lower corner and size, in patches of the first kind.
    pub corner: [f64; 2],
    pub size: [f64; 2],
}

impl Patch {
    /// Through values at the nodes 0/7, 1/7 … 7/7 in both directions.
    pub fn through(values: &[[f64; NODES]; NODES], corner: [f64; 2]) -> Self {
        let matrix = bernstein_from_values();
        let mut rows = [[0.0; NODES]; NODES];
        for (row, matrix) in rows.iter_mut().zip(matrix) {
            for (weight, values) in matrix.iter().zip(values) {
                for (sum, value) in row.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
        let mut coeffs = [[0.0; NODES]; NODES];
        for (out, row) in coeffs.iter_mut().zip(&rows) {
            for (out, matrix) in out.iter_mut().zip(matrix) {
                *out = matrix.iter().zip(row).map(|(weight, value)| weight * value).sum();
            }
        }
        Self { coeffs, corner, size: [1.0; 2] }
    }

    /// A bound below the polynomial on the whole patch.
    pub fn lower_bound(&self) -> f64 {
        self.coeffs.as_flattened().iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The least value at a corner, and where.
    pub fn least_corner(&self) -> (f64, [f64; 2]) {
        let mut least = (f64::INFINITY, self.corner);
        for (i, row) in [(0.0, 0), (1.0, NODES - 1)] {
            for (j, column) in [(0.0, 0), (1.0, NODES - 1)] {
                let value = self.coeffs[row][column];
                if value < least.0 {
                    least = (value, [self.corner[0] + i * self.size[0], self.corner[1] + j * self.size[1]]);
                }
            }
        }
        least
    }

    /// The two halves, across the direction in which the polynomial is bent more.
    pub fn halves(&self) -> [Self; 2] {
        let mut bends = [0.0f64; 2];
        for i in 0..NODES {
            for k in 1..NODES - 1 {
                let along = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
                let c = &self.coeffs;
                bends[0] = bends[0].max(along(c[k - 1][i], c[k][i], c[k + 1][i]));
                bends[1] = bends[1].max(along(c[i][k - 1], c[i][k], c[i][k + 1]));
            }
        }
        let direction = usize::from(bends[1] > bends[0]);
        let (mut low, mut high) = (self.clone(), self.clone());
        for halves in [&mut low, &mut high] {
            halves.size[direction] *= 0.5;
        }
        high.corner[direction] += high.size[direction];
        for i in 0..NODES {
            let line: [f64; NODES] =
                std::array::from_fn(|k| if direction == 0 { self.coeffs[k][i] } else { self.coeffs[i][k] });
            let (below, above) = split(line);
            for k in 0..NODES {
                if direction == 0 {
                    (low.coeffs[k][i], high.coeffs[k][i]) = (below[k], above[k]);
                } else {
                    (low.coeffs[i][k], high.coeffs[i][k]) = (below[k], above[k]);
                }
            }
        }
        [low, high]
    }
}

/// De Casteljau's halving of a polynomial in one variable.
fn split(mut line: [f64; NODES]) -> ([f64; NODES], [f64; NODES]) {
    let (mut below, mut above) = ([0.0; NODES], [0.0; NODES]);
    for step in 0..NODES {
        below[step] = line[0];
        above[NODES - 1 - step] = line[NODES - 1 - step];
        for k in 0..NODES - 1 - step {
            line[k] = 0.5 * (line[k] + line[k + 1]);
        }
    }
    (below, above)
}

/// The inverse of the matrix of Bernstein polynomials at the nodes.
fn bernstein_from_values() -> &'static [[f64; NODES]; NODES] {
    static MATRIX: OnceLock<[[f64; NODES]; NODES]> = OnceLock::new();
    MATRIX.get_or_init(|| {
        let degree = NODES - 1;
        let mut binomials = [1.0; NODES];
        for k in 1..NODES {
            binomials[k] = binomials[k - 1] * (NODES - k) as f64 / k as f64;
        }
        let values = nalgebra::SMatrix::<f64, NODES, NODES>::from_fn(|node, k| {
            let x = node as f64 / degree as f64;
            binomials[k] * x.powi(k as i32) * (1.0 - x).powi((degree - k) as i32)
        });
        let inverse = values.try_inverse().expect("Bernstein polynomials are a basis");
        std::array::from_fn(|row| std::array::from_fn(|column| inverse[(row, column)]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of degree 7 in both variables, so that the patch is it exactly.
    fn polynomial(x: f64, y: f64) -> f64 {
        (x - 0.3).powi(4) * (y + 0.2).powi(7) - 2.0 * x.powi(7) * y + (y - 0.6).powi(2) - 0.1 * x
    }

    fn patch() -> Patch {
        let at = |k: usize| k as f64 / 7.0;
        let values = std::array::from_fn(|i| std::array::from_fn(|j| polynomial(at(i), at(j))));
        Patch::through(&values, [0.0; 2])
    }

    #[test]
    fn halves_of_halves_have_the_polynomials_corners_and_bounds_below_it() {
        let mut patches = vec![patch()];
        for _ in 0..8 {
            patches = patches.iter().flat_map(Patch::halves).collect();
        }
        let area: f64 = patches.iter().map(|patch| patch.size[0] * patch.size[1]).sum();
        assert!((area - 1.0).abs() <= 1e-15);
        for patch in &patches {
            let (value, [x, y]) = patch.least_corner();
            // Coefficients up to 3, through an inverse of norm 210 in both directions.
            assert!((value - polynomial(x, y)).abs() <= 1e-12);
            for (s, t) in [(0.5, 0.5), (0.1, 0.8), (0.9, 0.3)] {
                let (x, y) = (patch.corner[0] + s * patch.size[0], patch.corner[1] + t * patch.size[1]);
                assert!(polynomial(x, y) >= patch.lower_bound() - 1e-12);
            }
        }
    }

    #[test]
    fn the_bound_comes_nearer_as_patches_shrink() {
        // The least value to 1e-6: no second derivative exceeds 100, and the places are 1/2000 apart.
        let places = |k: usize| k as f64 / 2000.0;
        let values = (0..=2000).flat_map(|i| (0..=2000).map(move |j| polynomial(places(i), places(j))));
        let least = values.fold(f64::INFINITY, f64::min);
        let gap =
            |patches: &[Patch]| least - patches.iter().map(Patch::lower_bound).fold(f64::INFINITY, f64::min);
        let mut patches = vec![patch()];
        for _ in 0..8 {
            patches = patches.iter().flat_map(Patch::halves).collect();
        }
        let before = gap(&patches);
        for _ in 0..8 {
            patches = patches.iter().flat_map(Patch::halves).collect();
        }
        // A quarter with each halving both ways, were the least value always at the same place of its patch: 256. Measured 54.
        assert!(gap(&patches) <= before / 32.0, "{before} to {}", gap(&patches));
    }
}
