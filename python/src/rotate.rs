//! Rotations of space, and of functions.

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm::rotate::{EulerOrder, FrameRotation, Rotation};

use crate::arrays::{
    Array, array_of, bands, coeff_shape, float_array, floats, in_precision, numbers, output, rows,
    same_batch, shape_text, with_last, wrong_shape,
};
use crate::error::refuse;

/// A rotation of space, d ↦ M d.
#[pyclass(frozen, module = "ylm._native")]
#[derive(Clone, Copy)]
pub struct Turn(ylm::rotate::Turn);

fn order(name: &str) -> PyResult<EulerOrder> {
    let found = EulerOrder::ALL.into_iter().find(|order| format!("{order:?}").eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        let names = EulerOrder::ALL.map(|order| format!("{order:?}").to_lowercase()).join(", ");
        PyValueError::new_err(format!("order is \"{name}\"; expected one of {names}"))
    })
}

#[pymethods]
impl Turn {
    #[new]
    fn new(rotation: &Bound<'_, PyAny>) -> PyResult<Self> {
        match turns(rotation)? {
            (batch, turns) if batch.is_empty() => Ok(Self(turns[0])),
            (batch, _) => Err(PyValueError::new_err(format!(
                "rotation has leading axes {}; expected a single one",
                shape_text(&batch)
            ))),
        }
    }

    #[staticmethod]
    fn from_axis_angle(axis: [f64; 3], angle: f64) -> PyResult<Self> {
        Ok(Self(ylm::rotate::Turn::from_axis_angle(axis, angle).map_err(refuse)?))
    }

    #[staticmethod]
    fn from_euler(order: &str, angles: [f64; 3]) -> PyResult<Self> {
        Ok(Self(ylm::rotate::Turn::from_euler(self::order(order)?, angles).map_err(refuse)?))
    }

    fn as_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, self.0.matrix().as_flattened().to_vec(), &[3, 3])
    }

    fn as_quat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, self.0.quaternion().to_vec(), &[4])
    }

    fn as_axis_angle<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, f64)> {
        let (axis, angle) = self.0.axis_angle();
        Ok((array_of(py, axis.to_vec(), &[3])?, angle))
    }

    fn as_euler<'py>(&self, py: Python<'py>, order: &str) -> PyResult<Bound<'py, PyAny>> {
        array_of(py, self.0.euler(self::order(order)?).to_vec(), &[3])
    }

    fn inverse(&self) -> Self {
        Self(self.0.inverse())
    }

    fn __matmul__(&self, first: &Self) -> Self {
        Self(first.0.then(&self.0))
    }

    fn apply<'py>(&self, py: Python<'py>, directions: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let directions: Array<'_, f64> = float_array(("directions", directions))?;
        let (_, list) = rows::<f64, 3>("directions", &directions)?;
        let turned: Vec<[f64; 3]> = list.iter().map(|direction| self.0.apply(*direction)).collect();
        array_of(py, turned.into_flattened(), directions.shape())
    }

    fn __repr__(&self) -> String {
        let [x, y, z, w] = self.0.quaternion();
        format!("ylm.Turn([{x}, {y}, {z}, {w}])")
    }
}

/// Rotations and their leading axes: a `Turn`, what has `as_matrix()`, matrices [..., 3, 3] or quaternions [..., 4].
fn turns(rotation: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<ylm::rotate::Turn>)> {
    if let Ok(turn) = rotation.cast::<Turn>() {
        return Ok((Vec::new(), vec![turn.get().0]));
    }
    let matrix =
        if rotation.hasattr("as_matrix")? { rotation.call_method0("as_matrix")? } else { rotation.clone() };
    let array: Array<'_, f64> = float_array(("rotation", &matrix))?;
    let values = numbers(&array);
    let (batch, turns): (&[usize], ylm::Result<Vec<_>>) = match array.shape() {
        [batch @ .., 3, 3] => {
            let matrices = values.as_chunks::<3>().0.as_chunks::<3>().0;
            (batch, matrices.iter().map(|matrix| ylm::rotate::Turn::from_matrix(*matrix)).collect())
        }
        [batch @ .., 4] => {
            let quaternions = values.as_chunks::<4>().0;
            (batch, quaternions.iter().map(|q| ylm::rotate::Turn::from_quaternion(*q)).collect())
        }
        shape => return Err(wrong_shape("rotation", shape, "(..., 3, 3), a matrix, or (..., 4), x y z w")),
    };
    Ok((batch.to_vec(), turns.map_err(refuse)?))
}

/// Functions turned by one rotation, or each by its own.
#[pyfunction]
pub fn rotate<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    rotation: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (of_turns, turns) = turns(rotation)?;
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (values, width) = (numbers(coeffs), bands.coeff_count());
        let work = values.len() * bands.count();
        if of_turns.is_empty() {
            return output(py, coeffs.shape(), work, |out| {
                ylm::rotate::rotate(&turns[0], bands, values, out)
            });
        }
        same_batch(["coeffs", "rotation"], [batch, &of_turns])?;
        output(py, coeffs.shape(), work, |out| {
            let pairs = values.chunks_exact(width).zip(out.chunks_exact_mut(width));
            let mut each = pairs.zip(&turns);
            each.try_for_each(|((values, out), turn)| ylm::rotate::rotate(turn, bands, values, out))
        })
    })
}

/// Functions turned about z.
#[pyfunction]
pub fn rotate_z<'py>(py: Python<'py>, coeffs: &Bound<'py, PyAny>, angle: f64) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let values = numbers(coeffs);
        output(py, coeffs.shape(), 0, |out| {
            out.copy_from_slice(values);
            ylm::rotate::rotate_z(angle, bands, out)
        })
    })
}

/// Functions along z turned to normals, each by its spin first: [..., n²], [..., 3], [..., 2].
#[pyfunction]
pub fn rotate_frames<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    normals: &Bound<'py, PyAny>,
    spins: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = [("coeffs", coeffs), ("normals", normals), ("spins", spins)];
    in_precision!(floats(&arguments)?, |[coeffs, normals, spins]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (of_normals, normals) = rows::<_, 3>("normals", normals)?;
        let (of_spins, spins) = rows::<_, 2>("spins", spins)?;
        same_batch(["coeffs", "normals"], [batch, of_normals])?;
        same_batch(["coeffs", "spins"], [batch, of_spins])?;
        let values = numbers(coeffs);
        output(py, coeffs.shape(), values.len() * bands.count(), |out| {
            FrameRotation::new(bands).apply(values, normals, spins, out)
        })
    })
}

/// Functions of the world brought to the frames of normals: [..., n²], [..., 3].
#[pyfunction]
pub fn rotate_into_frames<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    normals: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs), ("normals", normals)])?, |[coeffs, normals]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (of_normals, normals) = rows::<_, 3>("normals", normals)?;
        same_batch(["coeffs", "normals"], [batch, of_normals])?;
        let values = numbers(coeffs);
        output(py, coeffs.shape(), values.len() * bands.count(), |out| {
            FrameRotation::new(bands).undo(values, normals, out)
        })
    })
}

/// The matrices [..., n², n²] that turn columns of coefficients.
#[pyfunction]
pub fn rotation_matrix<'py>(
    py: Python<'py>,
    rotation: &Bound<'py, PyAny>,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = self::bands(bands)?;
    let (batch, turns) = turns(rotation)?;
    let width = bands.coeff_count();
    output::<f64>(py, &with_last(&with_last(&batch, width), width), width * width, |out| {
        for (turn, out) in turns.iter().zip(out.chunks_exact_mut(width * width)) {
            let rotation = Rotation::<f64>::of_turn(turn, bands);
            for l in 0..bands.count() {
                for (row, values) in rotation.band(l)?.chunks_exact(2 * l + 1).enumerate() {
                    out[(l * l + row) * width + l * l..][..values.len()].copy_from_slice(values);
                }
            }
        }
        Ok(())
    })
}
