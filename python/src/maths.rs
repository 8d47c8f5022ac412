//! Basis, evaluation, projection, and what else needs no table.

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm::layout::{Grid, Layout};
use ylm::project::{SphereGrid, StratifiedSamples};

use crate::arrays::{
    Array, Number, array_of, bands, coeff_shape, float_array, floats, in_precision, numbers, output,
    released, rows, same_batch, with_last, wrong_shape,
};
use crate::error::refuse;

/// Y at each direction: [..., 3] to [..., n²].
#[pyfunction]
pub fn basis<'py>(
    py: Python<'py>,
    directions: &Bound<'py, PyAny>,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    in_precision!(floats(&[("directions", directions)])?, |[directions]| {
        let (batch, directions) = rows::<_, 3>("directions", directions)?;
        let shape = with_last(batch, bands.coeff_count());
        output(py, &shape, 0, |out| ylm::basis::basis(directions, bands, out))
    })
}

/// f at each direction: [a..., n²] and [b..., 3] to [a..., b...].
#[pyfunction]
pub fn eval<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = [("coeffs", coeffs), ("directions", directions)];
    in_precision!(floats(&arguments)?, |[coeffs, directions]| {
        let (functions, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (batch, directions) = rows::<_, 3>("directions", directions)?;
        let (coeffs, width) = (numbers(coeffs), bands.coeff_count());
        let work = directions.len() * coeffs.len();
        output(py, &[functions, batch].concat(), work, |out| {
            let each = coeffs.chunks_exact(width).zip(out.chunks_mut(directions.len().max(1)));
            each.into_iter().try_for_each(|(coeffs, out)| match directions {
                [direction] => ylm::eval::eval(coeffs, *direction).map(|value| out[0] = value),
                _ => ylm::eval::eval_batch(coeffs, directions, out),
            })
        })
    })
}

/// Σ f_i g_i over the last axis.
#[pyfunction]
pub fn dot<'py>(
    py: Python<'py>,
    f: &Bound<'py, PyAny>,
    g: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("f", f), ("g", g)])?, |[f, g]| {
        let (batch, bands) = coeff_shape("f", f.shape())?;
        same_batch(["f", "g"], [f.shape(), g.shape()])?;
        let (f, g, width) = (numbers(f), numbers(g), bands.coeff_count());
        output(py, batch, f.len(), |out| {
            for ((out, f), g) in out.iter_mut().zip(f.chunks_exact(width)).zip(g.chunks_exact(width)) {
                *out = ylm::eval::dot(f, g)?;
            }
            Ok(())
        })
    })
}

/// Σ_j v_j Y_i(ω_j): values [..., d] at directions [d, 3] to [..., n²].
#[pyfunction]
pub fn project_values<'py>(
    py: Python<'py>,
    values: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    let arguments = [("values", values), ("directions", directions)];
    in_precision!(floats(&arguments)?, |[values, directions]| {
        let (_, list) = rows::<_, 3>("directions", directions)?;
        let [count, 3] = *directions.shape() else {
            return Err(wrong_shape("directions", directions.shape(), "(d, 3)"));
        };
        let batch = leading("values", values.shape(), count)?;
        let (values, width) = (numbers(values), bands.coeff_count());
        output(py, &with_last(batch, width), values.len() * width, |out| {
            for (row, out) in out.chunks_exact_mut(width).enumerate() {
                let values = &values[row * count..][..count];
                ylm::project::project_values(list, values, bands, out)?;
            }
            Ok(())
        })
    })
}

/// The leading axes of values, one for each of `count` directions.
fn leading<'a>(what: &str, shape: &'a [usize], count: usize) -> PyResult<&'a [usize]> {
    match shape.split_last() {
        Some((&last, batch)) if last == count => Ok(batch),
        _ => Err(wrong_shape(what, shape, &format!("(..., {count}), one value a direction"))),
    }
}

/// Directions [d, 3] and weights [d] that integrate polynomials up to a degree.
#[pyfunction]
pub fn sphere_grid(py: Python<'_>, degree: usize) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let grid = SphereGrid::exact_to(degree).map_err(refuse)?;
    let (directions, weights): (Vec<[f64; 3]>, Vec<f64>) = grid.points().unzip();
    let count = weights.len();
    Ok((array_of(py, directions.into_flattened(), &[count, 3])?, array_of(py, weights, &[count])?))
}

/// The coefficients of functions by their values [..., d] on [`sphere_grid`].
#[pyfunction]
pub fn project_grid<'py>(
    py: Python<'py>,
    values: &Bound<'py, PyAny>,
    degree: usize,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    let grid = SphereGrid::exact_to(degree).map_err(refuse)?;
    let count = grid.points().count();
    in_precision!(floats(&[("values", values)])?, |[values]| {
        let batch = leading("the function's result", values.shape(), count)?;
        let (values, width) = (numbers(values), bands.coeff_count());
        output(py, &with_last(batch, width), values.len() * bands.count(), |out| {
            for (row, out) in out.chunks_exact_mut(width).enumerate() {
                let mut values = values[row * count..][..count].iter().copied();
                let coeffs = grid.project(bands, |_| values.next().expect("one a direction"))?;
                out.copy_from_slice(&coeffs);
            }
            Ok(())
        })
    })
}

/// Jittered directions [side², 3], uniform over the sphere.
#[pyfunction]
pub fn stratified_samples(py: Python<'_>, side: usize, seed: u64) -> PyResult<Bound<'_, PyAny>> {
    let samples = StratifiedSamples::<f64>::new(side, seed).map_err(refuse)?;
    array_of(py, samples.directions().as_flattened().to_vec(), &[side * side, 3])
}

/// Names of layouts, as the command line has them and for each shape.
const LAYOUTS: [(&str, Layout); 9] = [
    ("latlong", Layout::LatLong),
    ("angular", Layout::AngularMap),
    ("mirror", Layout::MirrorBall),
    ("vertical-cross", Layout::VerticalCross),
    ("horizontal-cross", Layout::HorizontalCross),
    ("cube-column", Layout::CubeColumn),
    ("cube-row", Layout::CubeRow),
    ("exr-latlong", Layout::OpenExrLatLong),
    ("exr-cube", Layout::OpenExrCube),
];

fn layout(name: Option<&str>, width: usize, height: usize) -> PyResult<Grid> {
    let found = match name {
        Some(name) => LAYOUTS.iter().find(|(known, _)| *known == name).map(|(_, layout)| *layout),
        None => Layout::of_shape(width, height),
    };
    let layout = found.ok_or_else(|| {
        let names = LAYOUTS.map(|(name, _)| name).join(", ");
        PyValueError::new_err(match name {
            Some(name) => format!("layout is \"{name}\"; expected one of {names}"),
            None => {
                format!("a picture {width} wide and {height} high has no usual layout; give one of {names}")
            }
        })
    })?;
    Grid::new(layout, width, height).map_err(refuse)
}

/// A picture of the sphere [h, w, 3] to coefficients [3, n²].
#[pyfunction]
pub fn project_image<'py>(
    py: Python<'py>,
    pixels: &Bound<'py, PyAny>,
    bands: usize,
    layout: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    let pixels: Array<'_, f32> = float_array(("pixels", pixels))?;
    let [height, width, 3] = *pixels.shape() else {
        return Err(wrong_shape("pixels", pixels.shape(), "(height, width, 3)"));
    };
    let grid = self::layout(layout, width, height)?;
    let (_, texels) = rows::<f32, 3>("pixels", &pixels)?;
    let channels = py.detach(|| ylm::layout::project_image(&grid, texels, bands)).map_err(refuse)?;
    array_of(py, channels.concat(), &[3, bands.coeff_count()])
}

/// Middle directions [h, w, 3] and solid angles [h, w] of a picture's texels; both 0 where it shows nothing.
#[pyfunction]
pub fn image_texels<'py>(
    py: Python<'py>,
    height: usize,
    width: usize,
    layout: Option<&str>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let grid = self::layout(layout, width, height)?;
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| {
        grid.cell(x, y).map_or(([0.0; 3], 0.0), |cell| (cell.at([0.5; 2]).0, cell.solid_angle()))
    });
    let (directions, angles): (Vec<[f64; 3]>, Vec<f64>) = cells.unzip();
    let directions = array_of(py, directions.into_flattened(), &[height, width, 3])?;
    Ok((directions, array_of(py, angles, &[height, width])?))
}

/// The name of the layout that pictures of a shape usually have.
#[pyfunction]
pub fn image_layout(height: usize, width: usize) -> Option<&'static str> {
    let found = Layout::of_shape(width, height)?;
    LAYOUTS.iter().find(|(_, layout)| *layout == found).map(|(name, _)| *name)
}

/// Rows and columns [...] of the texels that show directions [..., 3].
#[pyfunction]
pub fn image_locate<'py>(
    py: Python<'py>,
    directions: &Bound<'py, PyAny>,
    height: usize,
    width: usize,
    layout: Option<&str>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let grid = self::layout(layout, width, height)?;
    let directions: Array<'_, f64> = float_array(("directions", directions))?;
    let (batch, list) = rows::<f64, 3>("directions", &directions)?;
    let is_none = |d: &[f64; 3]| d.iter().any(|x| !x.is_finite()) || d.iter().all(|x| *x == 0.0);
    if let Some(row) = list.iter().position(is_none) {
        let message = format!("direction {row} is {:?}; it must be finite and not zero", list[row]);
        return Err(PyValueError::new_err(message));
    }
    let (rows, columns): (Vec<i64>, Vec<i64>) = released(py, list.len() * 10, || {
        list.iter().map(|direction| grid.locate(*direction)).map(|(x, y)| (y as i64, x as i64)).unzip()
    });
    Ok((array_of(py, rows, batch)?, array_of(py, columns, batch)?))
}

/// P̄_lm of order m, l = m … n−1, at cosines [...]: [..., n − m].
#[pyfunction]
pub fn legendre<'py>(
    py: Python<'py>,
    order: usize,
    bands: usize,
    cosines: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    let cosines: Array<'_, f64> = float_array(("cosines", cosines))?;
    if let Some(cosine) = numbers(&cosines).iter().find(|cosine| !(-1.0..=1.0).contains(*cosine)) {
        return Err(PyValueError::new_err(format!("a cosine is {cosine}; it must be between −1 and 1")));
    }
    let Some(count) = bands.count().checked_sub(order).filter(|count| *count > 0) else {
        let message = format!("order is {order}; expected 0 to {}, below bands", bands.count() - 1);
        return Err(PyValueError::new_err(message));
    };
    let values = numbers(&cosines);
    output(py, &with_last(cosines.shape(), count), values.len() * bands.count(), |out| {
        for (&x, out) in values.iter().zip(out.chunks_exact_mut(count)) {
            ylm::legendre::row(order, bands.count(), x, ((1.0 - x) * (1.0 + x)).sqrt(), out);
        }
        Ok(())
    })
}

/// The instruction sets of this machine that kernels have, the one that is used last.
#[pyfunction]
pub fn instruction_sets() -> Vec<&'static str> {
    ylm::Level::available().into_iter().map(ylm::Level::name).collect()
}

/// Nodes and weights of the Gauss–Legendre rule.
#[pyfunction]
pub fn gauss_legendre(py: Python<'_>, count: usize) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let (nodes, weights) = py.detach(|| ylm::quadrature::gauss_legendre(count));
    Ok((array_of(py, nodes, &[count])?, array_of(py, weights, &[count])?))
}

/// ∫ Y_i over a spherical polygon: corners [p, 3] to [n²].
#[pyfunction]
pub fn polygon<'py>(
    py: Python<'py>,
    corners: &Bound<'py, PyAny>,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = self::bands(bands)?;
    let corners: Array<'_, f64> = float_array(("corners", corners))?;
    let (_, list) = corner_list(&corners)?;
    output(py, &[bands.coeff_count()], 0, |out| {
        ylm::polygon::PolygonProjection::new(bands).project(list, out)
    })
}

/// The signed solid angle of a spherical polygon [p, 3].
#[pyfunction]
pub fn solid_angle(corners: &Bound<'_, PyAny>) -> PyResult<f64> {
    let corners: Array<'_, f64> = float_array(("corners", corners))?;
    Ok(ylm::polygon::solid_angle(corner_list(&corners)?.1))
}

fn corner_list<'a>(corners: &'a Array<'_, f64>) -> PyResult<(&'a [usize], &'a [[f64; 3]])> {
    if corners.ndim() != 2 {
        return Err(wrong_shape("corners", corners.shape(), "(p, 3)"));
    }
    rows::<f64, 3>("corners", corners)
}

/// Runs `each` on every function of an array of coefficients, to an array of the same shape.
pub fn each_function<'py, T: Number>(
    py: Python<'py>,
    coeffs: &Array<'py, T>,
    work: usize,
    mut each: impl FnMut(&[T], &mut [T]) -> ylm::Result<()> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let (_, bands) = coeff_shape("coeffs", coeffs.shape())?;
    let (values, width) = (numbers(coeffs), bands.coeff_count());
    output(py, coeffs.shape(), work, |out| {
        let mut pairs = values.chunks_exact(width).zip(out.chunks_exact_mut(width));
        pairs.try_for_each(|(coeffs, out)| each(coeffs, out))
    })
}

/// The exponential of functions: `degree` 0 for the linear form.
#[pyfunction]
pub fn exp<'py>(
    py: Python<'py>,
    coeffs: &Bound<'py, PyAny>,
    degree: usize,
    squarings: usize,
) -> PyResult<Bound<'py, PyAny>> {
    use ylm::exponential::Exp;
    let method = match degree {
        0 => Exp::ScaledLinear { squarings },
        _ => Exp::ScaledSeries { degree, squarings },
    };
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let mut workspace = ylm::Workspace::new();
        let work = numbers(coeffs).len() * 100;
        each_function(py, coeffs, work, |coeffs, out| {
            ylm::exponential::exp(coeffs, method, out, &mut workspace)
        })
    })
}

/// The logarithm of functions; `floor` 0 for the linear form.
#[pyfunction]
pub fn log<'py>(py: Python<'py>, coeffs: &Bound<'py, PyAny>, floor: f64) -> PyResult<Bound<'py, PyAny>> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let mut workspace = ylm::Workspace::new();
        let work = numbers(coeffs).len() * 100;
        each_function(py, coeffs, work, |coeffs, out| match floor {
            0.0 => ylm::exponential::log_linear(coeffs, out),
            _ => ylm::exponential::log(coeffs, floor, out, &mut workspace),
        })
    })
}

/// What a minimum is: values [...], directions [..., 3], uncertainties [...].
type Minima<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// The least value of each function, where it is, and how well it is known.
#[pyfunction]
pub fn minimum<'py>(py: Python<'py>, coeffs: &Bound<'py, PyAny>) -> PyResult<Minima<'py>> {
    in_precision!(floats(&[("coeffs", coeffs)])?, |[coeffs]| {
        let (batch, bands) = coeff_shape("coeffs", coeffs.shape())?;
        let (values, width) = (numbers(coeffs), bands.coeff_count());
        let minima = released(py, usize::MAX, || {
            values.chunks_exact(width).map(ylm::window::minimum).collect::<ylm::Result<Vec<_>>>()
        });
        let minima = minima.map_err(refuse)?;
        let least = array_of(py, minima.iter().map(|m| m.value).collect(), batch)?;
        let directions = minima.iter().flat_map(|m| m.direction).collect();
        let uncertainty = array_of(py, minima.iter().map(|m| m.uncertainty).collect(), batch)?;
        Ok((least, array_of(py, directions, &with_last(batch, 3))?, uncertainty))
    })
}
