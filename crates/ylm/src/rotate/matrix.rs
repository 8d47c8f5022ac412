//! Rotations of space: what is one, and what is not.

use crate::error::{Error, Result};

/// |MᵀM − 1| of a single-precision matrix after a few hundred products.
const TOLERANCE: f64 = 1e-4;

/// The rotation nearest to a matrix that is one but for rounding.
///
/// # Errors
/// If an entry is not finite, the columns are not orthonormal, or the matrix is a reflection.
pub fn nearest_rotation(matrix: [[f64; 3]; 3]) -> Result<[[f64; 3]; 3]> {
    if let Some(&value) = matrix.iter().flatten().find(|value| !value.is_finite()) {
        let range = "it must be finite";
        return Err(Error::Range { what: "an entry of the rotation matrix", value, range });
    }
    let deviation = gram(&matrix).iter().enumerate().fold(0.0, |largest: f64, (i, row)| {
        (row.iter().enumerate()).fold(largest, |largest, (j, v)| largest.max((v - identity(i, j)).abs()))
    });
    if deviation > TOLERANCE {
        let what = "the largest entry of MᵀM − 1 of the rotation matrix M";
        let range = "it must be at most 1e-4: the columns of a rotation are orthonormal";
        return Err(Error::Range { what, value: deviation, range });
    }
    let [a, b, c] = matrix;
    let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    if determinant < 0.0 {
        let what = "the determinant of the rotation matrix";
        let range = "it must be 1: this is a reflection, which is no rotation";
        return Err(Error::Range { what, value: determinant, range });
    }
    Ok(orthonormalized(matrix))
}

/// The rotation nearest to a matrix within 1e-4 of one.
pub fn orthonormalized(mut rotation: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    // Newton's iteration for the orthogonal polar factor, M (3 − MᵀM) / 2: the error squares, 1e-4 → 1e-8 → 1e-16.
    for _ in 0..3 {
        let gram = gram(&rotation);
        rotation = rotation.map(|row| {
            [0, 1, 2].map(|j| {
                1.5 * row[j] - 0.5 * (row[0] * gram[0][j] + row[1] * gram[1][j] + row[2] * gram[2][j])
            })
        });
    }
    rotation
}

/// MᵀM.
fn gram(matrix: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix.iter().map(|row| row[i] * row[j]).sum()))
}

fn identity(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { 0.0 }
}

/// The matrix of d ↦ q d q⁻¹ for a quaternion [x, y, z, w] of any length but zero.
///
/// # Errors
/// If a component is not finite, or all are zero.
pub fn of_quaternion(quaternion: [f64; 4]) -> Result<[[f64; 3]; 3]> {
    if let Some(&value) = quaternion.iter().find(|value| !value.is_finite()) {
        return Err(Error::Range {
            what: "a component of the quaternion",
            value,
            range: "it must be finite",
        });
    }
    let largest = quaternion.iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
    if largest == 0.0 {
        let range = "it must not be 0: a rotation's quaternion has a direction";
        return Err(Error::Range { what: "the length of the quaternion", value: 0.0, range });
    }
    let scaled = quaternion.map(|v| v / largest);
    let length = scaled.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [x, y, z, w] = scaled.map(|v| v / length);
    Ok([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ])
}
