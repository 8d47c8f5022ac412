//! Products with functions around an axis: what depends on the kernel is made once, in the precision of what is multiplied.

use std::sync::OnceLock;

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm::product::{axial, gaunt, turned};
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};

use crate::arrays::{
    Array, Number, bands, coeff_shape, float_array, floats, in_precision, numbers, output, rows, same_batch,
    shape_text, wrong_shape,
};
use crate::error::refuse;

/// A kernel k(cos θ) with all of its bands, for functions of n bands.
#[pyclass(frozen, module = "ylm._native")]
pub struct AxialProduct {
    kernel: Kernel,
    single: OnceLock<axial::AxialProduct<f32>>,
    double: OnceLock<axial::AxialProduct<f64>>,
}

/// A kernel that is cut to n bands, for products by the sparse tensor.
#[pyclass(frozen, module = "ylm._native")]
pub struct TurnedProduct {
    kernel: Kernel,
    single: OnceLock<turned::TurnedProduct<f32>>,
    double: OnceLock<turned::TurnedProduct<f64>>,
}

/// What both are made of.
struct Kernel {
    zonal: Zonal<f64>,
    bands: Bands,
}

impl Kernel {
    fn new(kernel: &Bound<'_, PyAny>, bands: usize, max: usize) -> PyResult<Self> {
        let kernel: Array<'_, f64> = float_array(("kernel", kernel))?;
        if kernel.ndim() != 1 {
            let expected = "(k,), the coefficients of Y_00, Y_10, Y_20, …";
            return Err(wrong_shape("kernel", kernel.shape(), expected));
        }
        if let Some(value) = numbers(&kernel).iter().find(|value| !value.is_finite()) {
            let message = format!("a coefficient of the kernel is {value}; it must be finite");
            return Err(PyValueError::new_err(message));
        }
        if !(1..=max).contains(&bands) {
            return Err(refuse(ylm::Error::Bands { bands, min: 1, max }));
        }
        let zonal = Zonal::new(numbers(&kernel).to_vec()).map_err(refuse)?;
        Ok(Self { zonal, bands: self::bands(bands)? })
    }
}

/// What is there already, or is made now.
fn made<P>(cell: &OnceLock<P>, make: impl FnOnce() -> ylm::Result<P>) -> ylm::Result<&P> {
    match cell.get() {
        Some(product) => Ok(product),
        None => {
            let product = make()?;
            Ok(cell.get_or_init(|| product))
        }
    }
}

/// The product of a precision.
trait Held: Number {
    fn axial(of: &AxialProduct) -> ylm::Result<&axial::AxialProduct<Self>>;
    fn turned(of: &TurnedProduct) -> ylm::Result<&turned::TurnedProduct<Self>>;
}

macro_rules! held {
    ($number:ty, $cell:ident) => {
        impl Held for $number {
            fn axial(of: &AxialProduct) -> ylm::Result<&axial::AxialProduct<Self>> {
                made(&of.$cell, || axial::AxialProduct::new(of.kernel.bands, &of.kernel.zonal))
            }

            fn turned(of: &TurnedProduct) -> ylm::Result<&turned::TurnedProduct<Self>> {
                made(&of.$cell, || turned::TurnedProduct::new(of.kernel.bands, &of.kernel.zonal))
            }
        }
    };
}
held!(f32, single);
held!(f64, double);

/// The leading axes of functions that have as many bands as a product.
fn fitting<'a, T: Number>(coeffs: &'a Array<'_, T>, bands: Bands) -> PyResult<&'a [usize]> {
    let (batch, of_coeffs) = coeff_shape("coeffs", coeffs.shape())?;
    if of_coeffs == bands {
        return Ok(batch);
    }
    Err(PyValueError::new_err(format!(
        "coeffs has shape {}, of {} bands; expected (..., {}), the {} bands of the product",
        shape_text(coeffs.shape()),
        of_coeffs.count(),
        bands.coeff_count(),
        bands.count()
    )))
}

/// In which frames functions and axes are.
#[derive(Clone, Copy)]
enum Way {
    IntoFrames,
    InWorld,
}

impl AxialProduct {
    fn around<'py>(
        &self,
        py: Python<'py>,
        coeffs: &Bound<'py, PyAny>,
        axes: &Bound<'py, PyAny>,
        way: Way,
    ) -> PyResult<Bound<'py, PyAny>> {
        in_precision!(floats(&[("coeffs", coeffs), ("axes", axes)])?, |[coeffs, axes]| {
            let batch = fitting(coeffs, self.kernel.bands)?;
            let (of_axes, axes) = rows::<_, 3>("axes", axes)?;
            same_batch(["coeffs", "axes"], [batch, of_axes])?;
            let values = numbers(coeffs);
            output(py, coeffs.shape(), values.len() * self.kernel.bands.count(), |out| {
                let product = Held::axial(self)?;
                match way {
                    Way::IntoFrames => product.into_frames(values, axes, out),
                    Way::InWorld => product.in_world(values, axes, out),
                }
            })
        })
    }
}

#[pymethods]
impl AxialProduct {
    #[new]
    fn new(kernel: &Bound<'_, PyAny>, bands: usize) -> PyResult<Self> {
        let kernel = Kernel::new(kernel, bands, axial::MAX_BANDS)?;
        Ok(Self { kernel, single: OnceLock::new(), double: OnceLock::new() })
    }

    #[getter]
    fn bands(&self) -> usize {
        self.kernel.bands.count()
    }

    #[getter]
    fn entry_count(&self, py: Python<'_>) -> PyResult<usize> {
        py.detach(|| Ok(<f32 as Held>::axial(self)?.entry_count())).map_err(refuse)
    }

    /// Products of functions around +z.
    fn in_frame<'py>(&self, py: Python<'py>, coeffs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
            fitting(coeffs, self.kernel.bands)?;
            let values = numbers(coeffs);
            output(py, coeffs.shape(), values.len() * self.kernel.bands.count(), |out| {
                Held::axial(self)?.in_frame(values, out)
            })
        })
    }

    /// Products of functions of the world [..., n²] around axes [..., 3], in the frames of the axes.
    #[expect(clippy::wrong_self_convention, reason = "the functions go into frames, not the product")]
    fn into_frames<'py>(
        &self,
        py: Python<'py>,
        coeffs: &Bound<'py, PyAny>,
        axes: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.around(py, coeffs, axes, Way::IntoFrames)
    }

    /// The same in the world.
    fn in_world<'py>(
        &self,
        py: Python<'py>,
        coeffs: &Bound<'py, PyAny>,
        axes: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.around(py, coeffs, axes, Way::InWorld)
    }
}

#[pymethods]
impl TurnedProduct {
    #[new]
    fn new(kernel: &Bound<'_, PyAny>, bands: usize) -> PyResult<Self> {
        let kernel = Kernel::new(kernel, bands, gaunt::MAX_BANDS)?;
        Ok(Self { kernel, single: OnceLock::new(), double: OnceLock::new() })
    }

    #[getter]
    fn bands(&self) -> usize {
        self.kernel.bands.count()
    }

    #[getter]
    fn term_count(&self, py: Python<'_>) -> PyResult<usize> {
        py.detach(|| Ok(<f32 as Held>::turned(self)?.term_count())).map_err(refuse)
    }

    /// Products of functions [..., n²] with the kernel turned to directions [..., 3].
    fn product<'py>(
        &self,
        py: Python<'py>,
        coeffs: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        in_precision!(floats(&[("coeffs", coeffs), ("directions", directions)])?, |[coeffs, directions]| {
            let batch = fitting(coeffs, self.kernel.bands)?;
            let (of_directions, directions) = rows::<_, 3>("directions", directions)?;
            same_batch(["coeffs", "directions"], [batch, of_directions])?;
            let values = numbers(coeffs);
            output(py, coeffs.shape(), values.len() * self.kernel.bands.coeff_count(), |out| {
                Held::turned(self)?.product(values, directions, out, &mut Workspace::new())
            })
        })
    }
}
