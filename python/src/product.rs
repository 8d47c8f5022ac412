//! Products of functions.

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use ylm::product::band_forms::{BandForms, PAIRS};
use ylm::product::cap::CapProduct;
use ylm::product::gaunt::{BruteForce, Gaunt, tripling};
use ylm::product::grid::{Factor, Grid};
use ylm::product::matrix::ProductMatrix;
use ylm::product::zonal::ZonalProduct;
use ylm::product::{Method, chain, plan};
use ylm::{Bands, Level, Workspace};

use crate::arrays::{
    Array, Number, array_of, bands, coeff_shape, floats, in_precision, numbers, output, rows, same_batch,
    with_last, wrong_shape,
};
use crate::error::refuse;

/// Factors of one precision and shape, and their bands.
macro_rules! in_precision_of_factors {
    ($factors:expr, |$shape:ident, $bands:ident, $slices:ident| $body:expr) => {{
        let arguments: Vec<_> = $factors.iter().map(|factor| ("a factor", factor)).collect();
        match floats(&arguments)? {
            crate::arrays::Arrays::Single(found) => {
                let ($shape, $bands, $slices) = same_shapes(&found)?;
                $body
            }
            crate::arrays::Arrays::Double(found) => {
                let ($shape, $bands, $slices) = same_shapes(&found)?;
                $body
            }
        }
    }};
}

/// The shape of all factors, its bands, and their numbers.
type Factors<'a, T> = (&'a [usize], Bands, Vec<&'a [T]>);

/// Factors, if they are of one shape.
fn same_shapes<'a, T: Number>(factors: &'a [Array<'_, T>]) -> PyResult<Factors<'a, T>> {
    let Some(first) = factors.first() else {
        return Err(PyValueError::new_err("there are no factors; a product takes 1 to 32"));
    };
    let (_, bands) = coeff_shape("a factor", first.shape())?;
    for factor in factors {
        same_batch(["a factor", "another"], [first.shape(), factor.shape()])?;
    }
    Ok((first.shape(), bands, factors.iter().map(numbers).collect()))
}

/// The factors of a call, whose objects live as long as it.
fn listed<'py>(factors: &Bound<'py, PyTuple>) -> Vec<Bound<'py, PyAny>> {
    factors.iter().collect()
}

/// The product of factors of one shape [..., n²], by a method of a name.
#[pyfunction]
pub fn product<'py>(
    py: Python<'py>,
    factors: &Bound<'py, PyTuple>,
    method: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let way = match method {
        "auto" | "chain" | "brute-force" => Method::Auto,
        "unrolled" => Method::Unrolled,
        "gaunt" => Method::Gaunt,
        "fourier" => Method::Fourier,
        "grid" => Method::Grid,
        "grid-in-double" => Method::GridInDouble,
        _ => {
            return Err(PyValueError::new_err(format!(
                "method is \"{method}\"; expected auto, unrolled, gaunt, fourier, grid, grid-in-double, chain or brute-force"
            )));
        }
    };
    let factors = listed(factors);
    in_precision_of_factors!(factors, |shape, bands, slices| {
        let work = slices.len() * slices[0].len() * bands.count();
        output(py, shape, work, |out| match method {
            "chain" => chain::product(&slices, out, |a, b, out| {
                ylm::product::product(bands, &[a, b], Method::Auto, out)
            }),
            "brute-force" => {
                let tensor = BruteForce::new(bands, slices.len())?;
                let width = bands.coeff_count();
                for (row, out) in out.chunks_exact_mut(width).enumerate() {
                    let factors: Vec<_> = slices.iter().map(|slice| &slice[row * width..][..width]).collect();
                    tensor.product(&factors, out)?;
                }
                Ok(())
            }
            _ => ylm::product::product(bands, &slices, way, out),
        })
    })
}

/// The name of the method that is taken for so many products of so many functions, of single or double precision.
#[pyfunction]
pub fn product_method(bands: usize, factors: usize, rows: usize, precision: &str) -> PyResult<&'static str> {
    let bands = self::bands(bands)?;
    let method = match precision {
        "float32" => plan::choose::<f32>(bands, factors, rows),
        "float64" => plan::choose::<f64>(bands, factors, rows),
        _ => {
            let message = format!("dtype is {precision}; expected float32 or float64");
            return Err(PyValueError::new_err(message));
        }
    };
    Ok(match method.map_err(refuse)? {
        Method::Auto => "auto",
        Method::Unrolled => "unrolled",
        Method::Gaunt => "gaunt",
        Method::Fourier => "fourier",
        Method::Grid => "grid",
        Method::GridInDouble => "grid-in-double",
    })
}

/// The integral over the sphere of the product of factors of one shape: [..., n²] to [...].
#[pyfunction]
pub fn product_integral<'py>(py: Python<'py>, factors: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let factors = listed(factors);
    in_precision_of_factors!(factors, |shape, bands, slices| {
        let batch = &shape[..shape.len() - 1];
        let work = slices.len() * slices[0].len() * bands.count();
        output(py, batch, work, |out| {
            let grid = Grid::new(bands, slices.len().saturating_sub(1).max(1))?;
            let rows: Vec<_> = slices.iter().map(|factor| Factor::Rows(factor)).collect();
            grid.integral(&rows, 1, out, &mut Workspace::new())
        })
    })
}

/// What each band of f and g, [..., n²], adds to ∫ f g h of the bands below, h one function [n²]: [..., n].
#[pyfunction]
pub fn band_integrals<'py>(
    py: Python<'py>,
    f: &Bound<'py, PyAny>,
    g: &Bound<'py, PyAny>,
    h: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("f", f), ("g", g), ("h", h)])?, |[f, g, h]| {
        let (batch, bands) = coeff_shape("f", f.shape())?;
        same_batch(["f", "g"], [f.shape(), g.shape()])?;
        let width = bands.coeff_count();
        if *h.shape() != [width] {
            return Err(wrong_shape("h", h.shape(), &format!("({width},), one function of as many bands")));
        }
        let (f, g, h) = (numbers(f), numbers(g), numbers(h));
        output(py, &with_last(batch, bands.count()), (f.len() + h.len()) * width, |out| {
            let forms = BandForms::new(&[h], &mut Workspace::new())?;
            let pairs = f.chunks_exact(width).zip(g.chunks_exact(width));
            for (out, (f, g)) in out.chunks_exact_mut(bands.count()).zip(pairs) {
                let alone = |row: &[_]| row.iter().map(|&value| [value; PAIRS]).collect::<Vec<_>>();
                let (f, g) = (alone(f), alone(g));
                for (l, out) in out.iter_mut().enumerate() {
                    let mut sums = [[*out; PAIRS]];
                    forms.add_band(l, &f, &g, &mut sums, Level::best())?;
                    *out = sums[0][0];
                }
            }
            Ok(())
        })
    })
}

/// The matrices [..., n², n²] of multiplication by functions [..., n²].
#[pyfunction]
pub fn product_matrix<'py>(py: Python<'py>, coeffs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (values, width) = (numbers(coeffs), bands.coeff_count());
        let work = values.len() * width;
        output(py, &with_last(coeffs.shape(), width), work, |out| {
            let mut workspace = Workspace::new();
            for (coeffs, out) in values.chunks_exact(width).zip(out.chunks_exact_mut(width * width)) {
                let matrix = ProductMatrix::new(coeffs, &mut workspace)?;
                for (i, out) in out.chunks_exact_mut(width).enumerate() {
                    out.copy_from_slice(matrix.row(i));
                }
            }
            Ok(())
        })
    })
}

/// The product of functions [..., n²] with one zonal function along z, [n].
#[pyfunction]
pub fn zonal_product<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    zonal: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs), ("zonal", zonal)])?, |[coeffs, zonal]| {
        let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
        if *zonal.shape() != [bands.count()] {
            return Err(wrong_shape("zonal", zonal.shape(), &format!("({},)", bands.count())));
        }
        let (values, zonal) = (numbers(coeffs), numbers(zonal));
        output(py, coeffs.shape(), values.len() * bands.count(), |out| {
            let way = ZonalProduct::new(bands)?;
            way.product(&way.values(zonal)?, values, out, &mut Workspace::new())
        })
    })
}

/// What of functions [..., n²] is within caps around axes [..., 3] of half-angles [...].
#[pyfunction]
pub fn cap_product<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    axes: &Bound<'py, PyAny>,
    half_angles: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let half_angles: Array<'_, f64> = crate::arrays::float_array(("half_angles", half_angles))?;
    in_precision!(floats(&[("coeffs", coeffs), ("axes", axes)])?, |[coeffs, axes]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (of_axes, axes) = rows::<_, 3>("axes", axes)?;
        same_batch(["coeffs", "axes"], [batch, of_axes])?;
        same_batch(["coeffs", "half_angles"], [batch, half_angles.shape()])?;
        let (values, half_angles) = (numbers(coeffs), numbers(&half_angles));
        output(py, coeffs.shape(), values.len() * bands.count(), |out| {
            CapProduct::new(bands).inside(values, axes, half_angles, out)
        })
    })
}

/// ‖f_l‖² of each band: [..., n²] to [..., n].
#[pyfunction]
pub fn band_energies<'py>(py: Python<'py>, coeffs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let functions = numbers(coeffs).chunks_exact(bands.coeff_count());
        let energies =
            functions.map(chain::band_energies).collect::<ylm::Result<Vec<_>>>().map_err(refuse)?;
        array_of(py, energies.concat(), &with_last(batch, bands.count()))
    })
}

/// What a chain of factors with these band energies is off by: estimate, expected norm, bound.
#[pyfunction]
pub fn chain_truncation(energies: Vec<Vec<f64>>) -> PyResult<(f64, f64, f64)> {
    let found = chain::truncation(&energies).map_err(refuse)?;
    Ok((found.estimate, found.expected_norm, found.bound))
}

/// ∫ Y_i Y_j Y_k dω, where it is not 0: indices [terms, 3] in rising order of k, and values [terms].
#[pyfunction]
pub fn gaunt(py: Python<'_>, bands: usize) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let bands = self::bands(bands)?;
    let tensor = py.detach(|| Gaunt::<f64>::new(bands)).map_err(refuse)?;
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for k in 0..bands.coeff_count() {
        for term in tensor.terms(k) {
            indices.extend([i64::from(term.i), i64::from(term.j), k as i64]);
            values.push(term.value);
        }
    }
    let count = values.len();
    Ok((array_of(py, indices, &[count, 3])?, array_of(py, values, &[count])?))
}

/// ∫ Y_i Y_j Y_k dω of one triple.
#[pyfunction]
pub fn tripling_coefficient(i: usize, j: usize, k: usize) -> PyResult<f64> {
    let most = ylm::product::gaunt::MAX_BANDS.pow(2);
    match [i, j, k].into_iter().find(|index| *index >= most) {
        Some(index) => {
            Err(PyValueError::new_err(format!("index {index} is too large; expected 0 to {}", most - 1)))
        }
        None => Ok(tripling(i, j, k)),
    }
}

/// Wigner's 3j symbol of degrees and orders.
#[pyfunction]
pub fn wigner_3j(degrees: [usize; 3], orders: [isize; 3]) -> PyResult<f64> {
    let most = ylm::product::gaunt::MAX_BANDS - 1;
    match degrees.into_iter().find(|degree| *degree > most) {
        Some(degree) => {
            Err(PyValueError::new_err(format!("degree {degree} is too large; expected 0 to {most}")))
        }
        None => Ok(ylm::product::gaunt::wigner_3j(degrees, orders)),
    }
}
