//! A rotation of space: made from whatever describes one, and described in any of these ways again.

use super::matrix;
use crate::error::{Error, Result};
use crate::real::Real;

/// A rotation of space, d ↦ M d.
///
/// Angles are radians and right-handed: a positive turn about z takes x towards y.
///
/// Error: entries of the matrix 4e-16 from every constructor; every description gives the same matrix back to 4e-15,
/// at and near gimbal lock as elsewhere (tests/turn.rs).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    matrix: [[f64; 3]; 3],
}

/// The axes of three turns, intrinsic: `Xyz` with angles [a, b, c] turns by a about x, then by b about the y axis as
/// the first turn left it, then by c about the z axis as both left it, so that M = X(a) · Y(b) · Z(c).
///
/// Extrinsic turns, about axes that stay, are the same three read backwards: first Z(c), then Y(b), then X(a).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "each name is its meaning")]
pub enum EulerOrder {
    Xyz,
    Xzy,
    Yxz,
    Yzx,
    Zxy,
    Zyx,
    Xyx,
    Xzx,
    Yxy,
    Yzy,
    Zxz,
    Zyz,
}

impl EulerOrder {
    /// All of them: six of three different axes (Tait–Bryan), then six whose third axis is the first (proper Euler).
    pub const ALL: [Self; 12] = [
        Self::Xyz,
        Self::Xzy,
        Self::Yxz,
        Self::Yzx,
        Self::Zxy,
        Self::Zyx,
        Self::Xyx,
        Self::Xzx,
        Self::Yxy,
        Self::Yzy,
        Self::Zxz,
        Self::Zyz,
    ];

    /// The three axes, x = 0, y = 1, z = 2.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Self::Xyz => [0, 1, 2],
            Self::Xzy => [0, 2, 1],
            Self::Yxz => [1, 0, 2],
            Self::Yzx => [1, 2, 0],
            Self::Zxy => [2, 0, 1],
            Self::Zyx => [2, 1, 0],
            Self::Xyx => [0, 1, 0],
            Self::Xzx => [0, 2, 0],
            Self::Yxy => [1, 0, 1],
            Self::Yzy => [1, 2, 1],
            Self::Zxz => [2, 0, 2],
            Self::Zyz => [2, 1, 2],
        }
    }
}

impl Turn {
    /// No turn.
    pub const IDENTITY: Self = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// From a 3 × 3 matrix that acts on columns: `matrix[row][column]`, d ↦ matrix · d.
    ///
    /// The matrix may be as far off as single precision leaves it after many products (|MᵀM − 1| ≤ 1e-4); the nearest
    /// rotation is taken.
    ///
    /// # Errors
    /// If an entry is not finite, the columns are not orthonormal, or the matrix is a reflection.
    pub fn from_matrix<T: Real>(matrix: [[T; 3]; 3]) -> Result<Self> {
        Ok(Self { matrix: matrix::nearest_rotation(matrix.map(|row| row.map(T::to_f64)))? })
    }

    /// From a quaternion [x, y, z, w] of any length but zero: d ↦ q d q⁻¹.
    ///
    /// # Errors
    /// If a component is not finite, or all are zero.
    pub fn from_quaternion<T: Real>(quaternion: [T; 4]) -> Result<Self> {
        Ok(Self { matrix: matrix::of_quaternion(quaternion.map(T::to_f64))? })
    }

    /// By an angle about an axis of any length but zero.
    ///
    /// # Errors
    /// If the axis is not finite or zero, or the angle is not finite.
    pub fn from_axis_angle<T: Real>(axis: [T; 3], angle: T) -> Result<Self> {
        let direction = axis.map(T::to_f64);
        let largest = direction.iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
        if !(direction.iter().all(|v| v.is_finite()) && largest > 0.0) {
            return Err(Error::Direction { index: 0, direction });
        }
        // Scaled first: the squares of a long or short axis leave the range.
        let scaled = direction.map(|v| v / largest);
        let length = scaled.iter().map(|v| v * v).sum::<f64>().sqrt();
        let (sin, cos) = (checked_angle(angle.to_f64())? / 2.0).sin_cos();
        let [x, y, z] = scaled.map(|v| v / length * sin);
        Ok(Self { matrix: matrix::of_quaternion([x, y, z, cos])? })
    }

    /// By three turns about the axes of `order`; see [`EulerOrder`].
    ///
    /// # Errors
    /// If an angle is not finite.
    pub fn from_euler<T: Real>(order: EulerOrder, angles: [T; 3]) -> Result<Self> {
        let mut turn = Self::IDENTITY;
        for (axis, angle) in order.axes().into_iter().zip(angles) {
            turn = Self::about(axis, angle.to_f64())?.then(&turn);
        }
        Ok(turn)
    }

    /// By an angle about the axis x = 0, y = 1 or z = 2.
    fn about(axis: usize, angle: f64) -> Result<Self> {
        let (sin, cos) = checked_angle(angle)?.sin_cos();
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turn = Self::IDENTITY;
        (turn.matrix[next][next], turn.matrix[next][last]) = (cos, -sin);
        (turn.matrix[last][next], turn.matrix[last][last]) = (sin, cos);
        Ok(turn)
    }

    /// The matrix that acts on columns, row by row.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        self.matrix
    }

    /// Where a direction is turned to.
    pub fn apply(&self, direction: [f64; 3]) -> [f64; 3] {
        self.matrix.map(|row| row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2])
    }

    /// The turn back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.matrix[j][i])) }
    }

    /// This turn and after it `next`: the matrix `next` · `self`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let product =
            next.matrix.map(|row| [0, 1, 2].map(|j| (0..3).map(|k| row[k] * self.matrix[k][j]).sum()));
        Self { matrix: matrix::orthonormalized(product) }
    }

    /// The unit quaternion [x, y, z, w] with w ≥ 0.
    ///
    /// [Shepperd 1978] "Quaternion from rotation matrix": the largest component is found first, the others by it.
    pub fn quaternion(&self) -> [f64; 4] {
        let m = &self.matrix;
        let trace = m[0][0] + m[1][1] + m[2][2];
        // 4 q² of each component, less 1; the largest is at least 0.
        let squares = [2.0 * m[0][0] - trace, 2.0 * m[1][1] - trace, 2.0 * m[2][2] - trace, trace];
        let largest = (0..4).fold(3, |best, k| if squares[k] > squares[best] { k } else { best });
        let mut q = [0.0; 4];
        q[largest] = 0.5 * (1.0 + squares[largest]).sqrt();
        let quarter = 0.25 / q[largest];
        if largest == 3 {
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                q[i] = (m[k][j] - m[j][k]) * quarter;
            }
        } else {
            let i = largest;
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            q[j] = (m[i][j] + m[j][i]) * quarter;
            q[k] = (m[i][k] + m[k][i]) * quarter;
            q[3] = (m[k][j] - m[j][k]) * quarter;
        }
        if q[3] < 0.0 { q.map(|v| -v) } else { q }
    }

    /// The unit axis and the angle in [0, π]; without a turn the axis is z.
    pub fn axis_angle(&self) -> ([f64; 3], f64) {
        let [x, y, z, w] = self.quaternion();
        let sin = x.hypot(y).hypot(z);
        let axis = if sin > 0.0 { [x / sin, y / sin, z / sin] } else { [0.0, 0.0, 1.0] };
        (axis, 2.0 * sin.atan2(w))
    }

    /// The angles of three turns about the axes of `order`: the first and third in (−π, π], the second in [0, π] for
    /// proper Euler orders and in [−π/2, π/2] for Tait–Bryan ones.
    ///
    /// Gimbal lock: where the first and the third axis coincide, only the sum or the difference of their angles is
    /// defined; the third angle is 0 there. Near it both angles are as uncertain as the matrix makes them, but not
    /// what they are together.
    ///
    /// [Bernardes & Viollet 2022] "Quaternion to Euler angles conversion: A direct, general and computationally
    /// efficient method"
    pub fn euler(&self, order: EulerOrder) -> [f64; 3] {
        let [i, j, third] = order.axes();
        let k = 3 - i - j;
        let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
        let q = self.quaternion();
        let (w, qi, qj, qk) = (q[3], q[i], q[j], sign * q[k]);
        let proper = third == i;
        // Tait–Bryan angles are those of the proper order after a quarter turn about the second axis.
        let [a, b, c, d] = if proper { [w, qi, qj, qk] } else { [w - qj, qi - qk, qj + w, qk + qi] };
        let (sum, difference) = (b.atan2(a), d.atan2(c));
        let (near, far) = (a.hypot(b), c.hypot(d));
        let second = 2.0 * far.atan2(near);
        // a² + b² + c² + d² is 1 or 2; what is 1e-16 of it is rounding.
        let (first, last) = if far <= LOCKED {
            (2.0 * sum, 0.0)
        } else if near <= LOCKED {
            (2.0 * difference, 0.0)
        } else {
            (sum + difference, sum - difference)
        };
        let second = if proper { second } else { second - std::f64::consts::FRAC_PI_2 };
        let last = if proper { last } else { -sign * last };
        [wrapped(first), second, wrapped(last)]
    }
}

/// Half the sine of an angle between axes below which they coincide but for rounding.
const LOCKED: f64 = 1e-15;

/// The angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::PI;
    if angle > PI {
        angle - 2.0 * PI
    } else if angle <= -PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}

/// An angle that is one.
pub(super) fn checked_angle(angle: f64) -> Result<f64> {
    if angle.is_finite() {
        return Ok(angle);
    }
    Err(Error::Range { what: "an angle of rotation", value: angle, range: "it must be finite" })
}
