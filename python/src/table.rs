//! A table of an analysis as Arrow.

use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList, PyTuple};
use tables::column::{self, Column, Values};

use crate::error::refusal;

/// Name of a capsule with a stream of batches, by the PyCapsule interface of Arrow.
const STREAM: &CStr = c"arrow_array_stream";
/// Name of a capsule with a schema.
const SCHEMA: &CStr = c"arrow_schema";
/// Most rows of a batch: texts of a batch are addressed by 32 bits.
const BATCH_ROWS: usize = 4 << 20;

/// Table of an analysis.
///
/// pandas, polars, pyarrow and duckdb take it without a copy of its numbers, by the PyCapsule interface of Arrow:
/// ``table.to_pandas()``, ``polars.DataFrame(table)``, ``pyarrow.table(table)``. Each field has the metadata `unit`
/// and `meaning`; an unknown number is NaN.
///
/// Examples
/// --------
/// >>> result = fb.analyze("study/")                                   # doctest: +SKIP
/// >>> result.instances["gap_at_crest_m"].mean()                       # doctest: +SKIP
#[pyclass(frozen, module = "friction_bench")]
#[derive(Debug)]
pub(crate) struct Table {
    name: &'static str,
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Table {
    /// Takes over the columns of a table; numbers are not copied.
    pub(crate) fn new(table: column::Table) -> PyResult<Self> {
        let rows = table.len();
        let metadata = [("name", table.name), ("row", table.row)];
        let metadata = metadata.map(|(key, text)| (key.to_owned(), text.to_owned()));
        let fields: Vec<Field> = table.columns.iter().map(field).collect();
        let schema = Arc::new(Schema::new_with_metadata(fields, metadata.into()));
        let starts: Vec<usize> = (0..rows.max(1)).step_by(BATCH_ROWS).collect();
        let mut parts: Vec<Vec<ArrayRef>> = starts.iter().map(|_| Vec::new()).collect();
        for column in table.columns {
            for (part, array) in parts.iter_mut().zip(arrays(column.values, &starts)) {
                part.push(array);
            }
        }
        let batches = parts.into_iter();
        let batches = batches.map(|columns| RecordBatch::try_new(Arc::clone(&schema), columns));
        Ok(Self {
            name: table.name,
            batches: batches.collect::<Result<_, _>>().map_err(refusal)?,
            schema,
        })
    }

    fn rows(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }
}

fn field(column: &Column) -> Field {
    let data_type = match column.values {
        Values::Flag(_) => DataType::Boolean,
        Values::Text(_) => DataType::Utf8,
        Values::Integer(_) => DataType::Int64,
        Values::Real(_) => DataType::Float64,
    };
    Field::new(&*column.name, data_type, false).with_metadata(HashMap::from([
        ("unit".to_owned(), column.unit.to_owned()),
        ("meaning".to_owned(), column.meaning.to_string()),
    ]))
}

/// Returns the values in parts of at most [`BATCH_ROWS`] rows.
fn arrays(values: Values, starts: &[usize]) -> Vec<ArrayRef> {
    let array: ArrayRef = match values {
        Values::Flag(values) => Arc::new(BooleanArray::from(values)),
        Values::Integer(values) => Arc::new(Int64Array::from(values)),
        Values::Real(values) => Arc::new(Float64Array::from(values)),
        Values::Text(texts) => {
            let part = |start: &usize| {
                let texts = texts.iter().skip(*start).take(BATCH_ROWS);
                Arc::new(StringArray::from_iter_values(texts)) as ArrayRef
            };
            return starts.iter().map(part).collect();
        }
    };
    let part = |start: &usize| array.slice(*start, BATCH_ROWS.min(array.len() - start));
    starts.iter().map(part).collect()
}

#[pymethods]
impl Table {
    /// Name of the table, which its files of `analyze --tables` have.
    #[getter]
    fn name(&self) -> &'static str {
        self.name
    }

    /// Number of rows.
    #[getter]
    fn num_rows(&self) -> usize {
        self.rows()
    }

    /// Names of the columns, each of a quantity with its SI unit at its end.
    #[getter]
    fn column_names(&self) -> Vec<&str> {
        let fields = self.schema.fields().iter();
        fields.map(|field| field.name().as_str()).collect()
    }

    /// Units of the columns, by name: ``1`` for a pure number, empty for a text or truth value.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.metadata(py, "unit")
    }

    /// Meanings of the columns, by name.
    #[getter]
    fn meanings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.metadata(py, "meaning")
    }

    /// Return the columns as a dict of arrays, by name.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for name in self.column_names() {
            dict.set_item(name, self.__getitem__(py, name)?)?;
        }
        Ok(dict)
    }

    /// Return the table as a pandas.DataFrame; its numbers are not copied where pandas is 3.0 or later, with pyarrow.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let frame = slf.py().import("pandas")?.getattr("DataFrame")?;
        match frame.getattr_opt("from_arrow")? {
            Some(from_arrow) => from_arrow.call1((slf,)),
            None => frame.call1((slf.get().to_dict(slf.py())?,)),
        }
    }

    /// Iterate over the rows, each as a dict.
    ///
    /// ``pandas.DataFrame(table)`` reads the rows so; `to_pandas` takes the columns as they are, which is faster.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Rows>> {
        let columns = self.to_dict(py)?.values().try_iter()?;
        let columns = columns.map(|column| column?.call_method0("tolist"));
        let columns = PyTuple::new(py, columns.collect::<PyResult<Vec<_>>>()?)?;
        let zip = py.import("builtins")?.getattr("zip")?;
        let rows = Rows {
            names: PyList::new(py, self.column_names())?.unbind(),
            values: zip.call1(columns)?.unbind(),
        };
        Bound::new(py, rows)
    }

    fn __len__(&self) -> usize {
        self.rows()
    }

    fn __contains__(&self, name: &str) -> bool {
        self.schema.index_of(name).is_ok()
    }

    /// Return a column as a numpy array: a read-only view of its numbers, an array of texts, or of truth values.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Ok(index) = self.schema.index_of(name) else {
            return Err(PyKeyError::new_err(format!(
                "the table {} has no column {name}",
                self.name
            )));
        };
        let numpy = py.import("numpy")?;
        let parts = self.batches.iter();
        let parts = parts.map(|batch| part(py, &numpy, batch.column(index)));
        let mut parts: Vec<_> = parts.collect::<PyResult<_>>()?;
        match parts.len() {
            1 => Ok(parts.remove(0)),
            _ => numpy.call_method1("concatenate", (parts,)),
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "<friction_bench.Table {}: {} rows, {} columns>",
            self.name,
            self.rows(),
            self.schema.fields().len()
        )
    }

    /// Return the schema by the PyCapsule interface of Arrow.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(&*self.schema).map_err(refusal)?;
        PyCapsule::new_with_value(py, schema, SCHEMA)
    }

    /// Return the batches by the PyCapsule interface of Arrow, in the table's own schema.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The interface lets a producer answer with the schema that it has.
        let _ = requested_schema;
        let batches = self.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, Arc::clone(&self.schema));
        let stream = FFI_ArrowArrayStream::new(Box::new(reader));
        PyCapsule::new_with_value(py, stream, STREAM)
    }
}

impl Table {
    fn metadata<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for field in self.schema.fields() {
            dict.set_item(field.name(), field.metadata().get(key))?;
        }
        Ok(dict)
    }
}

/// Rows of a table.
#[pyclass(frozen, module = "friction_bench")]
struct Rows {
    names: Py<PyList>,
    /// Iterator over the values of each row.
    values: Py<PyAny>,
}

#[pymethods]
impl Rows {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let mut values = self.values.bind(py).try_iter()?;
        let Some(values) = values.next() else {
            return Ok(None);
        };
        let row = PyDict::new(py);
        for (name, value) in self.names.bind(py).iter().zip(values?.try_iter()?) {
            row.set_item(name, value?)?;
        }
        Ok(Some(row))
    }
}

/// Numbers of a column, which numpy reads in place.
#[pyclass(frozen, module = "friction_bench")]
struct NumberColumn {
    array: ArrayRef,
    address: usize,
    type_name: &'static str,
}

#[pymethods]
impl NumberColumn {
    /// Description of the memory by numpy's array interface, version 3.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let order = if cfg!(target_endian = "little") {
            '<'
        } else {
            '>'
        };
        dict.set_item("version", 3)?;
        dict.set_item("shape", (self.array.len(),))?;
        dict.set_item("typestr", format!("{order}{}", self.type_name))?;
        dict.set_item("data", (self.address, true))?;
        Ok(dict)
    }
}

/// Returns a part of a column as a numpy array.
fn part<'py>(
    py: Python<'py>,
    numpy: &Bound<'py, PyModule>,
    array: &ArrayRef,
) -> PyResult<Bound<'py, PyAny>> {
    let number = |address: usize, type_name| {
        let column = NumberColumn {
            array: Arc::clone(array),
            address,
            type_name,
        };
        numpy.call_method1("asarray", (Bound::new(py, column)?,))
    };
    if let Some(reals) = array.as_primitive_opt::<Float64Type>() {
        return number(reals.values().as_ptr().addr(), "f8");
    }
    if let Some(integers) = array.as_primitive_opt::<Int64Type>() {
        return number(integers.values().as_ptr().addr(), "i8");
    }
    if let Some(flags) = array.as_boolean_opt() {
        let flags: Vec<bool> = flags.values().iter().collect();
        return Ok(PyArray1::from_vec(py, flags).into_any());
    }
    let texts = array.as_string::<i32>();
    let mut known: HashMap<&str, Bound<'py, PyAny>> = HashMap::new();
    let list = PyList::empty(py);
    for text in texts.iter().flatten() {
        let object = match known.get(text) {
            Some(object) => object.clone(),
            None => {
                let object = text.into_pyobject(py)?.into_any();
                known.insert(text, object.clone());
                object
            }
        };
        list.append(object)?;
    }
    let options = PyDict::new(py);
    options.set_item("dtype", "object")?;
    numpy.call_method("array", (list,), Some(&options))
}
