//! What multiplies bands or coefficients: zonal kernels, windows, other conventions.

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm::convert::Convention;
use ylm::window::{Window, laplacian_for, least_nonnegative};
use ylm::zonal::Zonal;

use crate::arrays::{
    Array, Number, array_of, bands, coeff_shape, floats, in_precision, numbers, output, rows, same_batch,
    with_last, wrong_shape,
};
use crate::error::refuse;

/// z_l of a function of a name, along z: [n].
#[pyfunction]
pub fn zonal<'py>(py: Python<'py>, kind: &str, parameter: f64, bands: usize) -> PyResult<Bound<'py, PyAny>> {
    let bands = self::bands(bands)?;
    let zonal: Zonal<f64> = match kind {
        "clamped_cosine" => Zonal::clamped_cosine(bands),
        "directional" => Zonal::directional(bands),
        "disc" => Zonal::disc(parameter, bands).map_err(refuse)?,
        "phong" => Zonal::phong(parameter, bands).map_err(refuse)?,
        _ => return Err(PyValueError::new_err(format!("there is no zonal function \"{kind}\""))),
    };
    array_of(py, zonal.coeffs().to_vec(), &[bands.count()])
}

/// Zonal coefficients [n] as a kernel.
fn kernel<T: Number>(zonal: &Array<'_, T>) -> PyResult<Zonal<T>> {
    if zonal.ndim() != 1 {
        return Err(wrong_shape("zonal", zonal.shape(), "(n,), the coefficients of Y_00, Y_10, Y_20, …"));
    }
    Zonal::new(numbers(zonal).to_vec()).map_err(refuse)
}

/// c_lm √(4π/(2l+1)) z_l: [..., n²] and [n], or one kernel for each function, [..., n].
#[pyfunction]
pub fn convolve<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    zonal: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs), ("zonal", zonal)])?, |[coeffs, zonal]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let Some((&count, kernels)) = zonal.shape().split_last().filter(|(n, _)| **n == bands.count()) else {
            let expected = format!("(..., {}), as many bands as coeffs has", bands.count());
            return Err(wrong_shape("zonal", zonal.shape(), &expected));
        };
        let values = numbers(coeffs);
        if kernels.is_empty() {
            let kernel = kernel(zonal)?;
            return output(py, coeffs.shape(), 0, |out| {
                out.copy_from_slice(values);
                kernel.convolve(out)
            });
        }
        same_batch(["coeffs", "zonal"], [batch, kernels])?;
        let zonal = numbers(zonal);
        output(py, coeffs.shape(), 0, |out| {
            out.copy_from_slice(values);
            let pairs = out.chunks_exact_mut(bands.coeff_count()).zip(zonal.chunks_exact(count));
            pairs.into_iter().try_for_each(|(out, zonal)| Zonal::new(zonal.to_vec())?.convolve(out))
        })
    })
}

/// A zonal function [n] with its axis turned to each direction: [..., 3] to [..., n²].
#[pyfunction]
pub fn zonal_rotate<'py>(
    py: Python<'py>,
    zonal: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = [("zonal", zonal), ("directions", directions)];
    in_precision!(floats(&arguments)?, |[zonal, directions]| {
        let kernel = kernel(zonal)?;
        let (batch, directions) = rows::<_, 3>("directions", directions)?;
        let shape = with_last(batch, kernel.bands().coeff_count());
        output(py, &shape, 0, |out| kernel.rotate_batch(directions, out))
    })
}

fn window_of(kind: &str, parameter: f64) -> PyResult<Window> {
    let window = match kind {
        "hann" => Window::Hann(parameter),
        "lanczos" => Window::Lanczos(parameter),
        "gauss" => Window::Gauss(parameter),
        "laplacian" => Window::Laplacian(parameter),
        "poisson" => Window::Poisson(parameter),
        _ => {
            return Err(PyValueError::new_err(format!(
                "kind is \"{kind}\"; expected hann, lanczos, gauss, laplacian or poisson"
            )));
        }
    };
    window.check().map_err(refuse)?;
    Ok(window)
}

/// Each coefficient times the window's weight of its band.
#[pyfunction]
pub fn window<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    kind: &str,
    parameter: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let window = window_of(kind, parameter)?;
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        in_place(py, coeffs, |bands, out| window.apply(bands, out))
    })
}

/// A copy of coefficients, changed in place.
fn in_place<'py, T: Number>(
    py: Python<'py>,
    coeffs: &Array<'py, T>,
    change: impl FnOnce(ylm::Bands, &mut [T]) -> ylm::Result<()> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
    let values = numbers(coeffs);
    output(py, coeffs.shape(), 0, |out| {
        out.copy_from_slice(values);
        change(bands, out)
    })
}

/// The window's weight of each band, [n].
#[pyfunction]
pub fn window_weights<'py>(
    py: Python<'py>,
    kind: &str,
    parameter: f64,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let (window, bands) = (window_of(kind, parameter)?, self::bands(bands)?);
    array_of(py, (0..bands.count()).map(|l| window.weight(l)).collect(), &[bands.count()])
}

/// The radius of the weakest Poisson window that leaves no channel [..., n²] negative; 1 if none is needed.
#[pyfunction]
pub fn least_nonnegative_radius(py: Python<'_>, coeffs: &Bound<'_, PyAny>) -> PyResult<f64> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let values = numbers(coeffs);
        match py.detach(|| least_nonnegative(bands, values)).map_err(refuse)? {
            Some(Window::Poisson(radius)) => Ok(radius),
            Some(other) => Err(PyValueError::new_err(format!("the window is {other:?}, of no radius"))),
            None => Ok(1.0),
        }
    })
}

/// The λ of the Laplacian window that leaves a share of the squared Laplacian.
#[pyfunction]
pub fn laplacian_lambda(py: Python<'_>, coeffs: &Bound<'_, PyAny>, remaining: f64) -> PyResult<f64> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let values = numbers(coeffs);
        match py.detach(|| laplacian_for(bands, values, remaining)).map_err(refuse)? {
            Window::Laplacian(lambda) => Ok(lambda),
            other => Err(PyValueError::new_err(format!("the window is {other:?}, without λ"))),
        }
    })
}

fn convention(name: &str) -> PyResult<Convention> {
    Ok(match name {
        "no-phase" => Convention::NoPhase,
        "four-pi" => Convention::FourPi,
        "polar-y" => Convention::PolarY,
        _ => return Err(PyValueError::new_err(format!("there is no convention \"{name}\""))),
    })
}

/// Coefficients of ylm into those of another convention.
#[pyfunction]
pub fn convert_to<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let convention = convention(name)?;
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        in_place(py, coeffs, |bands, out| convention.write(bands, out))
    })
}

/// Coefficients of another convention into those of ylm.
#[pyfunction]
pub fn convert_from<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let convention = convention(name)?;
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        in_place(py, coeffs, |bands, out| convention.read(bands, out))
    })
}
