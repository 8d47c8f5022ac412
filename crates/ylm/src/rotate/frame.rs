//! A rotation of its own for each function, by turns about z and fixed quarter turns about x.

use super::recursion;
use crate::bands::{Bands, degree_order};
use crate::error::{Error, Result, check_length};
use crate::planes::{gather, scatter};
use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes, Level};

/// Rotates many functions from their own frames, with z along a normal, to the world: 16 of them side by side, and no
/// matrix built for any.
///
/// The rotation of an item takes +z to its normal n = (θ, φ_n), after a spin by ψ about z:
/// R = Z(φ_n) Y(θ) Z(ψ), and Y(θ) = X(−90°) Z(θ) X(90°). A turn about z mixes orders ±m only, and of the matrix of the
/// quarter turn X(90°), which is the same for all, three entries of four are zero: the ZXZXZ way.
///
/// Error: agrees with [`super::Rotation`] to 1e-13 in f64 at 32 bands (tests/rotate.rs).
/// Cost: about 2/3 n³ + 6 n² multiply-adds an item; `ylm-bench rotate`.
///
/// [Green03] "Rotating SH Functions"; [Kautz, Sloan & Snyder 2002] "Fast, Arbitrary BRDF Shading for Low-Frequency
/// Lighting Using Spherical Harmonics", appendix
#[derive(Clone, Debug)]
pub struct FrameRotation<T> {
    bands: Bands,
    quarter: Vec<Sector<T>>,
    quarter_back: Vec<Sector<T>>,
}

/// The entries of a quarter turn between the coefficients of one band that share their symmetries.
///
/// The turn keeps the parity in x, and makes the parity in y that in z: two of four sign patterns of the columns meet
/// exactly one of the rows.
#[derive(Clone, Debug)]
struct Sector<T> {
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Row-major.
    entries: Vec<T>,
}

impl<T: Real> FrameRotation<T> {
    /// The quarter turns of `bands` bands. Cost: O(n³).
    pub fn new(bands: Bands) -> Self {
        let mut quarter = Vec::new();
        let mut l = 0;
        let about_x = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
        recursion::band_matrices(about_x, bands.count(), |matrix| {
            quarter.extend(sectors(matrix, l));
            l += 1;
        });
        let quarter_back = quarter.iter().map(Sector::transposed).collect();
        Self { bands, quarter, quarter_back }
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Rotates each function by its own rotation, Z(φ_n) Y(θ) Z(ψ).
    ///
    /// Shapes: `coeffs` [item, n²]; `normals` [item, 3], of any length but zero; `spins` [item, 2], each [cos ψ, sin ψ]
    /// up to a positive factor; `out` [item, n²]. φ_n = 0 where the normal is along z.
    ///
    /// # Errors
    /// If a length does not fit, or a normal or a spin is not finite or zero; `out` is unspecified then.
    pub fn apply(&self, coeffs: &[T], normals: &[[T; 3]], spins: &[[T; 2]], out: &mut [T]) -> Result<()> {
        self.apply_with(Level::best(), coeffs, normals, spins, out)
    }

    /// [`FrameRotation::apply`] with a given instruction set.
    ///
    /// # Errors
    /// As [`FrameRotation::apply`].
    pub fn apply_with(
        &self,
        level: Level,
        coeffs: &[T],
        normals: &[[T; 3]],
        spins: &[[T; 2]],
        out: &mut [T],
    ) -> Result<()> {
        let width = self.bands.coeff_count();
        check_length("coeffs", coeffs.len(), normals.len() * width)?;
        check_length("spins", spins.len(), normals.len())?;
        check_length("out", out.len(), coeffs.len())?;
        let mut planes = vec![T::ZERO; 2 * width * CHUNK];
        let (current, other) = planes.split_at_mut(width * CHUNK);
        let items = normals.chunks(CHUNK).zip(spins.chunks(CHUNK)).enumerate();
        let values = coeffs.chunks(CHUNK * width).zip(out.chunks_mut(CHUNK * width));
        for ((block, (normals, spins)), (coeffs, out)) in items.zip(values) {
            let turns = Turns::new(normals, spins, block * CHUNK)?;
            level.run::<T, _>(Apply { rotation: self, turns, coeffs, out, current, other });
        }
        Ok(())
    }
}

/// The parity of a coefficient in x, y and z: true if the harmonic is odd.
fn parity(i: usize) -> [bool; 3] {
    let (l, m) = degree_order(i);
    let odd = m % 2 != 0;
    // cos m(π − φ) = (−1)^m cos mφ, sin m(π − φ) = −(−1)^m sin mφ.
    [odd == (m >= 0), m < 0, (l % 2 != 0) != odd]
}

/// The sectors of the quarter turn's matrix of band `l`.
fn sectors<T: Real>(matrix: &[f64], l: usize) -> Vec<Sector<T>> {
    let indices = l * l..(l + 1) * (l + 1);
    let mut sectors = Vec::new();
    for odd_x in [false, true] {
        for odd_z in [false, true] {
            let rows: Vec<usize> =
                indices.clone().filter(|&i| parity(i)[0] == odd_x && parity(i)[2] == odd_z).collect();
            let columns: Vec<usize> =
                indices.clone().filter(|&i| parity(i)[0] == odd_x && parity(i)[1] == odd_z).collect();
            let entry = |row: usize, column: usize| matrix[(row - l * l) * (2 * l + 1) + column - l * l];
            let entries = (rows.iter())
                .flat_map(|&row| columns.iter().map(move |&column| T::from_f64(entry(row, column))))
                .collect();
            sectors.push(Sector { rows, columns, entries });
        }
    }
    sectors.retain(|sector: &Sector<T>| !sector.entries.is_empty());
    sectors
}

impl<T: Real> Sector<T> {
    fn transposed(&self) -> Self {
        let entry = |row: usize, column: usize| self.entries[row * self.columns.len() + column];
        let entries = (0..self.columns.len())
            .flat_map(|column| (0..self.rows.len()).map(move |row| entry(row, column)))
            .collect();
        Self { rows: self.columns.clone(), columns: self.rows.clone(), entries }
    }
}

/// cos and sin of the three turns about z of up to [`CHUNK`] items: spin, θ, φ_n.
struct Turns<T> {
    turns: [[[T; CHUNK]; 2]; 3],
}

impl<T: Real> Turns<T> {
    fn new(normals: &[[T; 3]], spins: &[[T; 2]], first: usize) -> Result<Self> {
        let mut turns = [[[T::ZERO; CHUNK]; 2]; 3];
        for (i, (normal, spin)) in normals.iter().zip(spins).enumerate() {
            let [x, y, z] = [normal[0].to_f64(), normal[1].to_f64(), normal[2].to_f64()];
            let [spin_x, spin_y] = [spin[0].to_f64(), spin[1].to_f64()];
            // Along z there is no φ_n; 0 is as good as any.
            let azimuth = unit(x, y).unwrap_or([1.0, 0.0]);
            let horizontal = x * azimuth[0] + y * azimuth[1];
            let polar =
                unit(z, horizontal).ok_or(Error::Direction { index: first + i, direction: [x, y, z] })?;
            let spin = unit(spin_x, spin_y).ok_or(Error::Range {
                what: "a spin's cos² + sin²",
                value: spin_x * spin_x + spin_y * spin_y,
                range: "it must be finite and not 0",
            })?;
            for (turn, [cos, sin]) in turns.iter_mut().zip([spin, polar, azimuth]) {
                (turn[0][i], turn[1][i]) = (T::from_f64(cos), T::from_f64(sin));
            }
        }
        Ok(Self { turns })
    }
}

/// (x, y) at unit length; none for zero or what is not finite.
#[inline]
fn unit(x: f64, y: f64) -> Option<[f64; 2]> {
    let square = x * x + y * y;
    if (1e-200..1e200).contains(&square) {
        let scale = 1.0 / square.sqrt();
        return Some([x * scale, y * scale]);
    }
    // The squares may have overflowed or vanished.
    let largest = x.abs().max(y.abs());
    let (x, y) = (x / largest, y / largest);
    let length = x.hypot(y);
    length.is_finite().then(|| [x / length, y / length])
}

struct Apply<'a, T> {
    rotation: &'a FrameRotation<T>,
    turns: Turns<T>,
    coeffs: &'a [T],
    out: &'a mut [T],
    current: &'a mut [T],
    other: &'a mut [T],
}

impl<T: Real> Kernel<T> for Apply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let n = self.rotation.bands.count();
        let [spin, polar, azimuth] = &self.turns.turns;
        gather::<T, V>(self.coeffs, n * n, self.current);
        turn_about_z::<T, V>(spin, n, self.current);
        quarter_turn::<T, V>(&self.rotation.quarter, self.current, self.other);
        turn_about_z::<T, V>(polar, n, self.other);
        quarter_turn::<T, V>(&self.rotation.quarter_back, self.other, self.current);
        turn_about_z::<T, V>(azimuth, n, self.current);
        scatter::<T, V>(self.current, n * n, self.out);
    }
}

/// Turns each lane about z by its own angle: (c_m, c_−m) ← (c_m cos mα − c_−m sin mα, c_−m cos mα + c_m sin mα).
#[inline(always)]
fn turn_about_z<T: Real, V: Lanes<T>>([cos, sin]: &[[T; CHUNK]; 2], n: usize, planes: &mut [T]) {
    for lane in (0..CHUNK).step_by(V::COUNT) {
        let (cos_1, sin_1) = (V::load(&cos[lane..]), V::load(&sin[lane..]));
        let (mut cos, mut sin) = (cos_1, sin_1);
        for m in 1..n {
            for l in m..n {
                let middle = l * (l + 1);
                let (positive, negative) = ((middle + m) * CHUNK + lane, (middle - m) * CHUNK + lane);
                let (p, q) = (V::load(&planes[positive..]), V::load(&planes[negative..]));
                q.neg_mul_add(sin, p * cos).store(&mut planes[positive..]);
                p.mul_add(sin, q * cos).store(&mut planes[negative..]);
            }
            (cos, sin) = (sin.neg_mul_add(sin_1, cos * cos_1), cos.mul_add(sin_1, sin * cos_1));
        }
    }
}

/// The planes `after` = quarter turn · `before`.
#[inline(always)]
fn quarter_turn<T: Real, V: Lanes<T>>(sectors: &[Sector<T>], before: &[T], after: &mut [T]) {
    for Sector { rows, columns, entries } in sectors {
        let width = columns.len();
        let mut groups = rows.chunks_exact(2).zip(entries.chunks_exact(2 * width));
        for (rows, entries) in &mut groups {
            multiply_sector_rows::<T, V, 2>(rows, columns, entries, before, after);
        }
        if rows.len() % 2 == 1 {
            let last = rows.len() - 1;
            multiply_sector_rows::<T, V, 1>(&rows[last..], columns, &entries[last * width..], before, after);
        }
    }
}

#[inline(always)]
fn multiply_sector_rows<T: Real, V: Lanes<T>, const R: usize>(
    rows: &[usize],
    columns: &[usize],
    entries: &[T],
    before: &[T],
    after: &mut [T],
) {
    let entries = &entries[..R * columns.len()];
    for lane in (0..CHUNK).step_by(V::COUNT) {
        let mut sums = [V::splat(T::ZERO); R];
        for (k, &column) in columns.iter().enumerate() {
            let value = V::load(&before[column * CHUNK + lane..]);
            for r in 0..R {
                sums[r] = value.mul_add(V::splat(entries[r * columns.len() + k]), sums[r]);
            }
        }
        for r in 0..R {
            sums[r].store(&mut after[rows[r] * CHUNK + lane..]);
        }
    }
}
