//! Arrays of Python as slices of Rust.
//!
//! numpy converts any real dtype, byte order and stride. An array that is contiguous, aligned and of the type needed is not copied:
//! the slice is its memory. A label names the argument in errors, as "`drive`" or "the times of `normal`".

use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray1, PyUntypedArray,
    PyUntypedArrayMethods, dtype,
};
use pyo3::prelude::*;
use recording::recorded_arrays::Samples;

use crate::error::FrictionBenchError;

/// Samples of a signal, in the precision of the caller's array.
pub(crate) enum Signal<'py> {
    /// Single precision, as of a sound card.
    Single(PyReadonlyArray1<'py, f32>),
    /// Double precision.
    Double(PyReadonlyArray1<'py, f64>),
}

impl<'py> Signal<'py> {
    /// Reads a signal. NaN is a lost sample.
    ///
    /// # Errors
    /// The value cannot be read as a one-dimensional array of real numbers, is empty, has an infinite value, or has NaN alone.
    pub(crate) fn read(value: &Bound<'py, PyAny>, label: &str) -> PyResult<Self> {
        let array = vector(value, label)?;
        let is_single = array.dtype().kind() == b'f' && array.dtype().itemsize() <= 4;
        if is_single {
            let samples = contiguous::<f32>(&array)?;
            let values = samples.as_slice()?.iter().copied();
            require_samples(values.map(f64::from), label)?;
            Ok(Self::Single(samples))
        } else {
            let samples = contiguous::<f64>(&array)?;
            require_samples(samples.as_slice()?.iter().copied(), label)?;
            Ok(Self::Double(samples))
        }
    }

    /// Returns the number of samples.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Single(samples) => samples.len(),
            Self::Double(samples) => samples.len(),
        }
    }
}

impl Signal<'_> {
    /// Returns the samples.
    pub(crate) fn samples(&self) -> PyResult<Samples<'_>> {
        Ok(match self {
            Self::Single(samples) => Samples::Single(samples.as_slice()?),
            Self::Double(samples) => Samples::Double(samples.as_slice()?),
        })
    }
}

/// Readings of a sensor at their own times.
pub(crate) struct Readings<'py> {
    /// Times, s; finite and ascending.
    pub(crate) time_s: PyReadonlyArray1<'py, f64>,
    /// Values; NaN if lost.
    pub(crate) values: PyReadonlyArray1<'py, f64>,
}

impl<'py> Readings<'py> {
    /// Reads the pair of times and values of the argument `name`.
    ///
    /// # Errors
    /// The value is not a pair of arrays of equal lengths, the times are not finite and ascending, or a value is infinite.
    pub(crate) fn read(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        let parts: PyResult<Vec<_>> = value.try_iter().and_then(Iterator::collect);
        let pair = parts.ok().and_then(|parts| <[_; 2]>::try_from(parts).ok());
        let Some([times, values]) = pair else {
            return refused(format!(
                "`{name}` is no pair of arrays: pass the times in s and the values, as {name}=(time_s, values)"
            ));
        };
        let time_s = ascending(&times, &format!("the times of `{name}`"))?;
        let label = format!("the values of `{name}`");
        let values = lossy(&values, &label)?;
        let (times, count) = (time_s.len(), values.len());
        if times != count {
            return refused(format!(
                "`{name}` has {times} times and {count} values: pass as many times as values"
            ));
        }
        Ok(Self { time_s, values })
    }
}

/// Returns a one-dimensional array of finite numbers.
///
/// # Errors
/// The value is not such an array, or empty; the message names the first NaN or infinite value.
pub(crate) fn finite<'py>(
    value: &Bound<'py, PyAny>,
    label: &str,
) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let array = contiguous::<f64>(&vector(value, label)?)?;
    let values = array.as_slice()?.iter();
    match values.enumerate().find(|(_, value)| !value.is_finite()) {
        None => Ok(array),
        Some((index, value)) => refused(format!(
            "{label}: {} at index {index}; pass finite numbers",
            number(*value)
        )),
    }
}

/// Returns a one-dimensional array of finite, strictly ascending numbers.
///
/// # Errors
/// As [`finite`]; the message names the first number that is not above its predecessor.
pub(crate) fn ascending<'py>(
    value: &Bound<'py, PyAny>,
    label: &str,
) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let array = finite(value, label)?;
    let times = array.as_slice()?;
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(array),
        Some(index) => refused(format!(
            "{label} do not ascend: {} at index {} follows {}; sort them, and remove repeated ones",
            times[index + 1],
            index + 1,
            times[index]
        )),
    }
}

/// Returns a one-dimensional array of numbers, of which some may be lost: NaN.
///
/// # Errors
/// The value is not such an array, or empty; the message names the first infinite value.
pub(crate) fn lossy<'py>(
    value: &Bound<'py, PyAny>,
    label: &str,
) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let array = contiguous::<f64>(&vector(value, label)?)?;
    require_no_infinite(array.as_slice()?.iter().copied(), label)?;
    Ok(array)
}

/// Returns a numpy array of real numbers, of any shape and real dtype.
///
/// # Errors
/// The value has masked values, or values that are no real numbers.
pub(crate) fn numeric<'py>(
    value: &Bound<'py, PyAny>,
    label: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let numpy = value.py().import("numpy")?;
    if numpy
        .getattr("ma")?
        .call_method1("is_masked", (value,))?
        .extract()?
    {
        return refused(format!(
            "{label} is a masked array: replace its masked values, as by .filled(numpy.nan), or remove them, as by .compressed()"
        ));
    }
    let array = numpy.call_method1("asarray", (value,));
    let array = array
        .ok()
        .and_then(|array| array.cast_into::<PyUntypedArray>().ok());
    let Some(array) = array else {
        return refused(format!(
            "{label} is no array: pass a numpy array, or a list of numbers"
        ));
    };
    let remedy = match array.dtype().kind() {
        b'f' | b'i' | b'u' => return Ok(array),
        b'c' => "is complex: pass real samples, as of the instrument, or the real part",
        b'b' => "has True and False: convert it, as by .astype(float)",
        b'm' | b'M' => "has dates or durations: convert them to seconds, as numbers",
        b'S' | b'U' => "has texts: convert them, as by .astype(float)",
        _ => {
            "has values that are no real numbers: convert it, as by numpy.asarray(values, dtype=float)"
        }
    };
    refused(format!("{label} {remedy}"))
}

/// Returns an array as contiguous memory of type `T`: that of the array itself where it is such already.
///
/// # Errors
/// The memory is not enough for a copy.
pub(crate) fn contiguous<'py, T: Element>(
    array: &Bound<'py, PyUntypedArray>,
) -> PyResult<PyReadonlyArray1<'py, T>> {
    let py = array.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("require", (array, dtype::<T>(py), ["C", "A"]))?;
    Ok(array.cast_into::<PyArray1<T>>()?.try_readonly()?)
}

/// Returns a one-dimensional array of real numbers that is not empty.
fn vector<'py>(value: &Bound<'py, PyAny>, label: &str) -> PyResult<Bound<'py, PyUntypedArray>> {
    let array = numeric(value, label)?;
    match array.shape() {
        [] => refused(format!("{label} is one number: pass an array of them")),
        [0] => refused(format!("{label} is empty: pass at least one number")),
        [_] => Ok(array),
        shape => {
            let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
            refused(format!(
                "{label} has the shape ({}): pass one dimension, as one column or .ravel()",
                lengths.join(", ")
            ))
        }
    }
}

fn require_samples(values: impl Iterator<Item = f64> + Clone, label: &str) -> PyResult<()> {
    require_no_infinite(values.clone(), label)?;
    if values.clone().all(f64::is_nan) {
        return refused(format!(
            "{label} has NaN alone: pass the recorded samples, in which NaN is a lost one"
        ));
    }
    Ok(())
}

fn require_no_infinite(mut values: impl Iterator<Item = f64>, label: &str) -> PyResult<()> {
    match values.position(f64::is_infinite) {
        None => Ok(()),
        Some(index) => refused(format!(
            "{label}: an infinite value at index {index}; replace lost values by NaN"
        )),
    }
}

fn number(value: f64) -> &'static str {
    if value.is_nan() {
        "NaN"
    } else {
        "an infinite value"
    }
}

fn refused<T>(message: String) -> PyResult<T> {
    Err(FrictionBenchError::new_err(message))
}
