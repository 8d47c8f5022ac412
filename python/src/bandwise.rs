//! What multiplies bands or coefficients: zonal kernels, windows, other conventions.

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use ylm::convert::Convention;
use ylm::product::zonal::ZonalZonal;
use ylm::window::{Window, laplacian_for, least_nonnegative};
use ylm::zonal::Zonal;

use crate::arrays::{
    Array, Arrays, Number, array_of, bands, coeff_shape, float_array, floats, in_precision, numbers, output,
    rows, same_batch, shape_text, with_last, wrong_shape,
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
        "henyey_greenstein" => Zonal::henyey_greenstein(parameter, bands).map_err(refuse)?,
        _ => return Err(PyValueError::new_err(format!("there is no zonal function \"{kind}\""))),
    };
    array_of(py, zonal.coeffs().to_vec(), &[bands.count()])
}

/// z_l of a function that is tabulated over cos θ, [k] and [k] to [n].
#[pyfunction]
pub fn zonal_tabulated<'py>(
    py: Python<'py>,
    cosines: &Bound<'py, PyAny>,
    values: &Bound<'py, PyAny>,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = self::bands(bands)?;
    let (cosines, values): (Array<'_, f64>, Array<'_, f64>) =
        (float_array(("cosines", cosines))?, float_array(("values", values))?);
    if cosines.ndim() != 1 || cosines.shape() != values.shape() {
        let expected = format!("(k,), as cosines, which has {}", shape_text(cosines.shape()));
        return Err(wrong_shape("values", values.shape(), &expected));
    }
    let table: Vec<[f64; 2]> =
        numbers(&cosines).iter().zip(numbers(&values)).map(|(&x, &y)| [x, y]).collect();
    let zonal = py.detach(|| Zonal::<f64>::tabulated(&table, bands)).map_err(refuse)?;
    array_of(py, zonal.coeffs().to_vec(), &[bands.count()])
}

/// √(4π/(2l+1)) z_l, [n].
#[pyfunction]
pub fn zonal_band_factors<'py>(py: Python<'py>, zonal: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("zonal", zonal)])?, |[zonal]| {
        let kernel = kernel(zonal)?;
        let factors = (0..kernel.bands().count()).map(|l| kernel.band_factor(l)).collect();
        array_of(py, factors, zonal.shape())
    })
}

/// The product of zonal functions [..., n] around the same axis.
#[pyfunction]
pub fn zonal_multiply<'py>(py: Python<'py>, zonals: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let zonals: Vec<Bound<'py, PyAny>> = zonals.iter().collect();
    let arguments: Vec<_> = zonals.iter().map(|zonal| ("a zonal function", zonal)).collect();
    match floats(&arguments)? {
        Arrays::Single(found) => multiplied(py, &found),
        Arrays::Double(found) => multiplied(py, &found),
    }
}

fn multiplied<'py, T: Number>(py: Python<'py>, zonals: &[Array<'py, T>]) -> PyResult<Bound<'py, PyAny>> {
    let Some(first) = zonals.first() else {
        return Err(PyValueError::new_err("there are no zonal functions; a product takes 1 to 32"));
    };
    let Some(&count) = first.shape().last() else {
        return Err(wrong_shape("a zonal function", first.shape(), "(..., n)"));
    };
    for zonal in zonals {
        same_batch(["a zonal function", "another"], [first.shape(), zonal.shape()])?;
    }
    let bands = bands(count)?;
    let slices: Vec<&[T]> = zonals.iter().map(numbers).collect();
    output(py, first.shape(), slices[0].len() * count * slices.len(), |out| {
        let product = ZonalZonal::with_factors(bands, slices.len())?;
        for (row, out) in out.chunks_exact_mut(count).enumerate() {
            let factors: Vec<&[T]> = slices.iter().map(|slice| &slice[row * count..][..count]).collect();
            product.product(&factors, out)?;
        }
        Ok(())
    })
}

/// ∫ (Δf)² over the sphere, summed over functions [..., n²].
#[pyfunction]
pub fn squared_laplacian(coeffs: &Bound<'_, PyAny>) -> PyResult<f64> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        ylm::window::squared_laplacian(bands, numbers(coeffs)).map_err(refuse)
    })
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

/// A window by its name.
pub fn window_of(kind: &str, parameter: f64) -> PyResult<Window> {
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
