//! Values of the kernels for tests/test_bits.py, which compares them with what Python gets, bit by bit.
//!
//! Writes to standard output, for f32 and then f64, one array of little-endian numbers after the other: the directions
//! and coefficients that it drew, then the results in the order of `results`.

use std::io::Write;

use ylm::product::axial::AxialProduct;
use ylm::product::turned::TurnedProduct;
use ylm::product::{Method, product};
use ylm::rotate::{FrameRotation, Turn};
use ylm::zonal::Zonal;
use ylm::{Bands, Real, Workspace};

const ROWS: usize = 37;
const BANDS: usize = 6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = Vec::new();
    results::<f32>(&mut out)?;
    results::<f64>(&mut out)?;
    std::io::stdout().write_all(&out)?;
    Ok(())
}

/// Numbers in [−1, 1) by a linear congruence: any will do.
fn drawn<T: Real>(count: usize, mut state: u64) -> Vec<T> {
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        T::from_f64((state >> 40) as f64 / (1u64 << 23) as f64 - 1.0)
    };
    (0..count).map(|_| next()).collect()
}

fn results<T: Real + Bytes>(out: &mut Vec<u8>) -> ylm::Result<()> {
    let bands = Bands::new(BANDS)?;
    let width = bands.coeff_count();
    let directions = drawn::<T>(3 * ROWS, 1);
    let (f, g) = (drawn::<T>(ROWS * width, 2), drawn::<T>(ROWS * width, 3));
    let list = directions.as_chunks::<3>().0;
    let mut write = |values: &[T]| values.iter().for_each(|value| value.write(out));
    write(&directions);
    write(&f);
    write(&g);

    let mut basis = vec![T::ZERO; ROWS * width];
    ylm::basis::basis(list, bands, &mut basis)?;
    write(&basis);
    for coeffs in f.chunks_exact(width) {
        let mut values = vec![T::ZERO; ROWS];
        ylm::eval::eval_batch(coeffs, list, &mut values)?;
        write(&values);
    }
    let mut turned = f.clone();
    ylm::rotate::rotate(&Turn::from_quaternion([0.1, 0.2, 0.3, 0.9])?, bands, &f, &mut turned)?;
    write(&turned);
    let mut both = f.clone();
    product(bands, &[&f, &g], Method::Auto, &mut both)?;
    write(&both);
    product(bands, &[&f, &g, &f], Method::Auto, &mut both)?;
    write(&both);
    let mut convolved = f.clone();
    Zonal::<T>::clamped_cosine(bands).convolve(&mut convolved)?;
    write(&convolved);
    let mut projected = vec![T::ZERO; width];
    ylm::project::project_values(list, &f[..ROWS], bands, &mut projected)?;
    write(&projected);
    let cosine = AxialProduct::<T>::clamped_cosine(bands)?;
    cosine.in_frame(&f, &mut both)?;
    write(&both);
    cosine.in_world(&f, list, &mut both)?;
    write(&both);
    let kernel = Zonal::<f64>::henyey_greenstein(0.5, bands)?;
    TurnedProduct::<T>::new(bands, &kernel)?.product(&f, list, &mut both, &mut Workspace::new())?;
    write(&both);
    FrameRotation::<T>::new(bands).undo(&f, list, &mut both)?;
    write(&both);
    Ok(())
}

trait Bytes {
    fn write(&self, out: &mut Vec<u8>);
}

impl Bytes for f32 {
    fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }
}

impl Bytes for f64 {
    fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }
}
