//! Numpy arrays in and out: f32 and f64 as they are, other numbers as f64; batch axes lead.

use numpy::{
    Element, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use ylm::{Bands, Real};

use crate::error::refuse;

/// The two precisions, as numpy has them.
pub trait Number: Real + Element {}
impl Number for f32 {}
impl Number for f64 {}

/// A contiguous array that is read.
pub type Array<'py, T> = PyReadonlyArrayDyn<'py, T>;

/// Arrays of one precision: single if all were, double otherwise.
pub enum Arrays<'py> {
    Single(Vec<Array<'py, f32>>),
    Double(Vec<Array<'py, f64>>),
}

/// An argument and its name, for messages.
pub type Argument<'a, 'py> = (&'a str, &'a Bound<'py, PyAny>);

/// Runs `$body` with `$arrays` as slices of arrays of either precision.
macro_rules! in_precision {
    ($found:expr, |$arrays:pat_param| $body:expr) => {
        match $found {
            $crate::arrays::Arrays::Single(found) => {
                let $arrays = found.as_slice() else { unreachable!("as many as were asked for") };
                $body
            }
            $crate::arrays::Arrays::Double(found) => {
                let $arrays = found.as_slice() else { unreachable!("as many as were asked for") };
                $body
            }
        }
    };
}
pub(crate) use in_precision;

/// Arguments as contiguous arrays of one precision, without a copy where they are that already.
///
/// What is no array (a list, a number) takes the precision of the arrays beside it.
pub fn floats<'py>(arguments: &[Argument<'_, 'py>]) -> PyResult<Arrays<'py>> {
    let singles = arguments.iter().map(|(_, object)| as_it_is::<f32>(object)).collect::<Option<Vec<_>>>();
    if let Some(singles) = singles {
        return Ok(Arrays::Single(singles));
    }
    let doubles = arguments.iter().map(|(_, object)| as_it_is::<f64>(object)).collect::<Option<Vec<_>>>();
    if let Some(doubles) = doubles {
        return Ok(Arrays::Double(doubles));
    }
    let is_array = |object: &Bound<'py, PyAny>| object.cast::<PyUntypedArray>().is_ok();
    let is_single = |object: &Bound<'py, PyAny>| {
        object.cast::<PyUntypedArray>().is_ok_and(|array| {
            let kind = array.dtype();
            kind.kind() == b'f' && kind.itemsize() == 4
        })
    };
    let mut arrays = arguments.iter().filter(|(_, object)| is_array(object)).peekable();
    if arrays.peek().is_some() && arrays.all(|(_, object)| is_single(object)) {
        Ok(Arrays::Single(arguments.iter().map(converted).collect::<PyResult<_>>()?))
    } else {
        Ok(Arrays::Double(arguments.iter().map(converted).collect::<PyResult<_>>()?))
    }
}

/// One argument in a given precision.
pub fn float_array<'py, T: Number>(argument: Argument<'_, 'py>) -> PyResult<Array<'py, T>> {
    as_it_is(argument.1).map_or_else(|| converted(&argument), Ok)
}

/// The array itself, if it is one of this type, contiguous and aligned.
fn as_it_is<'py, T: Number>(object: &Bound<'py, PyAny>) -> Option<Array<'py, T>> {
    let array = object.cast::<PyArrayDyn<T>>().ok()?;
    if !array.is_c_contiguous() {
        return None;
    }
    let array = array.try_readonly().ok()?;
    array.as_slice().is_ok().then_some(array)
}

/// A contiguous array of this type with the argument's numbers.
fn converted<'py, T: Number>((what, object): &Argument<'_, 'py>) -> PyResult<Array<'py, T>> {
    let py = object.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (object,))?;
    let kind = array.cast::<PyUntypedArray>()?.dtype();
    if !matches!(kind.kind(), b'f' | b'i' | b'u' | b'b') {
        let message = format!("{what} is an array of {kind}; expected real numbers");
        return Err(PyTypeError::new_err(message));
    }
    let needs = ("C_CONTIGUOUS", "ALIGNED");
    let array = numpy.call_method1("require", (array, numpy::dtype::<T>(py), needs))?;
    Ok(array.cast::<PyArrayDyn<T>>()?.try_readonly()?)
}

/// The numbers of an array that [`floats`] made.
pub fn numbers<'a, T: Number>(array: &'a Array<'_, T>) -> &'a [T] {
    array.as_slice().expect("made contiguous")
}

/// "(2, 3)", as Python writes a shape.
pub fn shape_text(shape: &[usize]) -> String {
    match shape {
        [only] => format!("({only},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// "coeffs has shape (2, 5); expected …"
pub fn wrong_shape(what: &str, shape: &[usize], expected: &str) -> PyErr {
    PyValueError::new_err(format!("{what} has shape {}; expected {expected}", shape_text(shape)))
}

/// The leading axes and the bands of an array of coefficients.
pub fn coeff_shape<'a>(what: &str, shape: &'a [usize]) -> PyResult<(&'a [usize], Bands)> {
    let bands = shape.split_last().and_then(|(count, batch)| {
        let n = count.isqrt();
        (n * n == *count).then(|| Bands::new(n).ok())?.map(|bands| (batch, bands))
    });
    bands.ok_or_else(|| wrong_shape(what, shape, "(..., n²) for n bands, n = 1 to 256"))
}

/// The leading axes of an array whose last axis is `N` long, and its rows.
pub fn rows<'a, T: Number, const N: usize>(
    what: &str,
    array: &'a Array<'_, T>,
) -> PyResult<(&'a [usize], &'a [[T; N]])> {
    match array.shape().split_last() {
        Some((&last, batch)) if last == N => Ok((batch, numbers(array).as_chunks().0)),
        _ => Err(wrong_shape(what, array.shape(), &format!("(..., {N})"))),
    }
}

/// Checks that two arguments have the same leading axes.
pub fn same_batch(what: [&str; 2], [a, b]: [&[usize]; 2]) -> PyResult<()> {
    if a == b {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{} and {} have leading axes {} and {}; expected the same",
        what[0],
        what[1],
        shape_text(a),
        shape_text(b)
    )))
}

/// n.
pub fn bands(n: usize) -> PyResult<Bands> {
    Bands::new(n).map_err(refuse)
}

/// Leading axes and one more.
pub fn with_last(batch: &[usize], last: usize) -> Vec<usize> {
    [batch, &[last]].concat()
}

/// From how many numbers of output or work on other Python threads may run meanwhile; fewer take no longer than to switch.
const WORTH_RELEASING: usize = 2048;

/// Runs long work without the interpreter's lock.
pub fn released<R: Send>(py: Python<'_>, work: usize, run: impl FnOnce() -> R + Send) -> R {
    if work >= WORTH_RELEASING { py.detach(run) } else { run() }
}

/// A new array that `fill` writes; of no axes, a scalar.
pub fn output<'py, T: Number>(
    py: Python<'py>,
    shape: &[usize],
    work: usize,
    fill: impl FnOnce(&mut [T]) -> ylm::Result<()> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = zeros::<T>(py, shape)?;
    {
        let mut writer = array.try_readwrite()?;
        let out = writer.as_slice_mut()?;
        released(py, work.max(out.len()), || fill(out)).map_err(refuse)?;
    }
    if shape.is_empty() { array.get_item(()) } else { Ok(array.into_any()) }
}

/// Zeros; by way of numpy where they may be more than there is memory, which it says with a `MemoryError`.
fn zeros<'py, T: Number>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let count = shape.iter().try_fold(1usize, |count, axis| count.checked_mul(*axis));
    if count.is_some_and(|count| count < 1 << 24) {
        return Ok(PyArrayDyn::zeros(py, shape, false));
    }
    let zeros = py.import("numpy")?.call_method1("zeros", (shape.to_vec(), numpy::dtype::<T>(py)))?;
    Ok(zeros.cast_into::<PyArrayDyn<T>>()?)
}

/// A vector as an array of a shape, without a copy.
pub fn array_of<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let flat = numpy::PyArray1::from_vec(py, values);
    Ok(flat.reshape(numpy::ndarray::IxDyn(shape))?.into_any())
}
