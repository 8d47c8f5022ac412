//! A rotation of its own for each function, by turns about z and fixed quarter turns about x.

use super::quarter::{QuarterTurn, QuarterTurns};
use super::z::turn_each_about_z;
use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::planes::{gather, scatter};
use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes, Level, Operations, count};

/// Rotates many functions from their own frames, with z along a normal, to the world: 16 of them side by side, and no
/// matrix built for any.
///
/// The rotation of an item takes +z to its normal n = (θ, φ_n), after a spin by ψ about z:
/// R = Z(φ_n) Y(θ) Z(ψ), by the ZXZXZ way of [`QuarterTurns`].
///
/// Error: agrees with [`super::Rotation`] to 1e-13 in f64 at 32 bands (tests/rotate.rs).
/// Cost: about 2/3 n³ + 6 n² multiply-adds an item; `ylm-bench rotate`.
///
/// [Green03] "Rotating SH Functions"; [Kautz, Sloan & Snyder 2002] "Fast, Arbitrary BRDF Shading for Low-Frequency
/// Lighting Using Spherical Harmonics", appendix
#[derive(Clone, Debug)]
pub struct FrameRotation<T> {
    quarter: QuarterTurns<T>,
}

impl<T: Real> FrameRotation<T> {
    /// The quarter turns of `bands` bands. Cost: O(n³).
    pub fn new(bands: Bands) -> Self {
        Self { quarter: QuarterTurns::new(bands) }
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        self.quarter.bands()
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
        check_length("spins", spins.len(), normals.len())?;
        let items = normals.chunks(CHUNK).zip(spins.chunks(CHUNK)).enumerate();
        let turns = items.map(|(block, (normals, spins))| Turns::new(normals, Some(spins), block * CHUNK));
        self.turn_all(level, normals.len(), turns, coeffs, out)
    }

    /// Brings each function from the world to the frame of its normal: what [`FrameRotation::apply`] without spins undoes.
    ///
    /// The frame's x is the meridian's direction downwards, and the world's x where the normal is +z.
    ///
    /// Shapes: `coeffs` and `out` [item, n²]; `normals` [item, 3], of any length but zero.
    ///
    /// # Errors
    /// If a length does not fit, or a normal is not finite or zero; `out` is unspecified then.
    pub fn undo(&self, coeffs: &[T], normals: &[[T; 3]], out: &mut [T]) -> Result<()> {
        self.undo_with(Level::best(), coeffs, normals, out)
    }

    /// [`FrameRotation::undo`] with a given instruction set.
    ///
    /// # Errors
    /// As [`FrameRotation::undo`].
    pub fn undo_with(&self, level: Level, coeffs: &[T], normals: &[[T; 3]], out: &mut [T]) -> Result<()> {
        let blocks = normals.chunks(CHUNK).enumerate();
        let turns = blocks.map(|(block, normals)| Ok(Turns::new(normals, None, block * CHUNK)?.inverse()));
        self.turn_all(level, normals.len(), turns, coeffs, out)
    }

    fn turn_all(
        &self,
        level: Level,
        count: usize,
        turns: impl Iterator<Item = Result<Turns<T>>>,
        coeffs: &[T],
        out: &mut [T],
    ) -> Result<()> {
        let width = self.bands().coeff_count();
        check_length("coeffs", coeffs.len(), count * width)?;
        check_length("out", out.len(), coeffs.len())?;
        let mut planes = vec![T::ZERO; 2 * width * CHUNK];
        let (current, other) = planes.split_at_mut(width * CHUNK);
        let values = coeffs.chunks(CHUNK * width).zip(out.chunks_mut(CHUNK * width));
        for (turns, (coeffs, out)) in turns.zip(values) {
            level.run::<T, _>(Apply { rotation: self, turns: turns?, coeffs, out, current, other });
        }
        Ok(())
    }

    /// Turns the functions of `planes` [coeff, CHUNK]; `other` is as large.
    #[inline(always)]
    pub(crate) fn turn_planes<V: Lanes<T>>(&self, turns: &Turns<T>, planes: &mut [T], other: &mut [T]) {
        let n = self.bands().count();
        if let Some(turn) = &turns.first {
            turn_each_about_z::<T, V>(turn, n, planes);
        }
        self.quarter.turn::<V>(QuarterTurn::There, planes, other);
        turn_each_about_z::<T, V>(&turns.middle, n, other);
        self.quarter.turn::<V>(QuarterTurn::Back, other, planes);
        if let Some(turn) = &turns.last {
            turn_each_about_z::<T, V>(turn, n, planes);
        }
    }
}

impl FrameRotation<f32> {
    /// What [`FrameRotation::undo`] takes for one function.
    pub fn undo_operations(&self) -> Operations {
        let width = self.bands().coeff_count();
        let turns = Turns::new(&[[0.6, 0.0, 0.8]; CHUNK], None, 0).expect("normals").inverse();
        let mut memory = vec![0.0; 4 * width * CHUNK];
        let (coeffs, rest) = memory.split_at_mut(width * CHUNK);
        let (out, rest) = rest.split_at_mut(width * CHUNK);
        let (current, other) = rest.split_at_mut(width * CHUNK);
        count(Apply { rotation: self, turns, coeffs, out, current, other })
    }
}

/// cos and sin of turns by an angle of its own of up to [`CHUNK`] items.
type Angles<T> = [[T; CHUNK]; 2];

/// Three turns, about z, y and z, of up to [`CHUNK`] items.
pub(crate) struct Turns<T> {
    first: Option<Angles<T>>,
    middle: Angles<T>,
    last: Option<Angles<T>>,
}

impl<T: Real> Turns<T> {
    /// The spin if there is one, θ, φ_n. `first` is the index of the first item, for errors.
    pub fn new(normals: &[[T; 3]], spins: Option<&[[T; 2]]>, first: usize) -> Result<Self> {
        let mut turns = [[[T::ZERO; CHUNK]; 2]; 3];
        for (i, normal) in normals.iter().enumerate() {
            let [x, y, z] = [normal[0].to_f64(), normal[1].to_f64(), normal[2].to_f64()];
            let [spin_x, spin_y] = spins.map_or([1.0, 0.0], |spins| spins[i].map(T::to_f64));
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
        let [spin, middle, azimuth] = turns;
        Ok(Self { first: spins.map(|_| spin), middle, last: Some(azimuth) })
    }

    /// The turns back.
    pub fn inverse(self) -> Self {
        let back = |[cos, sin]: Angles<T>| [cos, sin.map(|sin| -sin)];
        Self { first: self.last.map(back), middle: back(self.middle), last: self.first.map(back) }
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
        let width = self.rotation.bands().coeff_count();
        gather::<T, V>(self.coeffs, width, self.current);
        self.rotation.turn_planes::<V>(&self.turns, self.current, self.other);
        scatter::<T, V>(self.current, width, self.out);
    }
}
