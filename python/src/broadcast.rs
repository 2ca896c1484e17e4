//! Formulas of single numbers, applied to arrays of Python.
//!
//! Each argument is a number, or an array of any shape; all arrays of a call have one shape, which is that of the result. A formula of
//! numbers alone gives a number. NaN in any argument gives NaN.

use std::array;

use contact::ModelError;
use num_complex::Complex64;
use numpy::{
    Element, IntoPyArray, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray1, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::arrays::{contiguous, numeric};
use crate::error::FrictionBenchError;

/// Elements computed between two looks for Ctrl-C.
const BLOCK: usize = 1 << 16;

/// A number of a formula: its NaN, and its form in Python.
pub(crate) trait Number: Element + Copy + Send + Sync {
    const NAN: Self;

    fn is_nan(self) -> bool;

    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>>;
}

impl Number for f64 {
    const NAN: Self = Self::NAN;

    fn is_nan(self) -> bool {
        self.is_nan()
    }

    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(self.into_pyobject(py)?.into_any())
    }
}

impl Number for Complex64 {
    const NAN: Self = Self::new(f64::NAN, f64::NAN);

    fn is_nan(self) -> bool {
        self.re.is_nan() || self.im.is_nan()
    }

    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let number = pyo3::types::PyComplex::from_doubles(py, self.re, self.im);
        Ok(number.into_any())
    }
}

/// An argument of a formula.
pub(crate) struct Operand<'py, T: Number> {
    name: &'static str,
    /// Shape; empty for a single number.
    shape: Vec<usize>,
    values: PyReadonlyArray1<'py, T>,
}

impl<'py, T: Number> Operand<'py, T> {
    /// Reads real numbers.
    ///
    /// # Errors
    /// The value is neither a real number nor an array of them.
    pub(crate) fn real(name: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        Self::of_array(name, &numeric(value, &format!("`{name}`"))?)
    }

    fn of_array(name: &'static str, array: &Bound<'py, PyUntypedArray>) -> PyResult<Self> {
        let flat = array.call_method0("ravel")?;
        Ok(Self {
            name,
            shape: array.shape().to_vec(),
            values: contiguous(flat.cast::<PyUntypedArray>()?)?,
        })
    }
}

impl<'py> Operand<'py, Complex64> {
    /// Reads complex or real numbers.
    ///
    /// # Errors
    /// The value is neither a number nor an array of numbers.
    pub(crate) fn complex(name: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = value
            .py()
            .import("numpy")?
            .call_method1("asarray", (value,))
            .ok()
            .and_then(|array| array.cast_into::<PyUntypedArray>().ok());
        match array {
            Some(array) if array.dtype().kind() == b'c' => Self::of_array(name, &array),
            _ => Self::real(name, value),
        }
    }
}

/// Applies a formula element by element, without the interpreter's lock.
///
/// # Errors
/// Arrays of different shapes, an element outside the formula's domain, or Ctrl-C.
pub(crate) fn elementwise<'py, const N: usize, T: Number, R: Number>(
    py: Python<'py>,
    operands: [Operand<'py, T>; N],
    formula: impl Fn([T; N]) -> Result<R, ModelError> + Sync,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = common_shape(&operands)?;
    let mut slices: [&[T]; N] = [&[]; N];
    for (slice, operand) in slices.iter_mut().zip(&operands) {
        *slice = operand.values.as_slice()?;
    }
    let is_single: [bool; N] = array::from_fn(|index| operands[index].shape.is_empty());
    let evaluate = |index: usize| {
        let arguments = array::from_fn(|operand| {
            let at = if is_single[operand] { 0 } else { index };
            slices[operand][at]
        });
        if arguments.iter().any(|argument: &T| argument.is_nan()) {
            return Ok(R::NAN);
        }
        formula(arguments)
    };
    let Some(shape) = shape else {
        return evaluate(0).map_err(refused)?.into_python(py);
    };
    let count = shape.iter().product();
    let mut results = vec![R::NAN; count];
    for (block, results) in results.chunks_mut(BLOCK).enumerate() {
        py.detach(|| {
            results
                .iter_mut()
                .enumerate()
                .try_for_each(|(offset, result)| {
                    let index = block * BLOCK + offset;
                    *result = evaluate(index).map_err(|source| ModelError::AtSample {
                        index,
                        source: Box::new(source),
                    })?;
                    Ok(())
                })
        })
        .map_err(refused)?;
        py.check_signals()?;
    }
    Ok(results.into_pyarray(py).reshape(shape)?.into_any())
}

/// Returns an error of the model as the package's exception.
pub(crate) fn refused(error: ModelError) -> PyErr {
    FrictionBenchError::new_err(error.to_string())
}

/// Returns the samples of a record.
///
/// # Errors
/// The argument is no array of one dimension.
pub(crate) fn record<'a, T: Number>(operand: &'a Operand<'_, T>) -> PyResult<&'a [T]> {
    match operand.shape.as_slice() {
        [_] => Ok(operand.values.as_slice()?),
        _ => Err(FrictionBenchError::new_err(format!(
            "`{}` is no record: pass an array of one dimension, evenly sampled",
            operand.name
        ))),
    }
}

/// Returns the shape of all arrays; `None` without an array.
fn common_shape<T: Number>(operands: &[Operand<'_, T>]) -> PyResult<Option<Vec<usize>>> {
    let mut arrays = operands.iter().filter(|operand| !operand.shape.is_empty());
    let Some(first) = arrays.next() else {
        return Ok(None);
    };
    match arrays.find(|other| other.shape != first.shape) {
        None => Ok(Some(first.shape.clone())),
        Some(other) => Err(FrictionBenchError::new_err(format!(
            "`{}` has the shape {} and `{}` {}: pass arrays of one shape, or single numbers",
            first.name,
            shape_text(&first.shape),
            other.name,
            shape_text(&other.shape),
        ))),
    }
}

fn shape_text(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    match lengths.as_slice() {
        [length] => format!("({length},)"),
        lengths => format!("({})", lengths.join(", ")),
    }
}
