//! ASTERIX records for Python: as successive dicts, or as columns.
//!
//! Both decode without the interpreter lock. Dicts are made while another thread decodes the next records. A column
//! is created when an element of a name first appears, and holds a value or none for each record of its category.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use asterix::choice::ChosenEdition;
use asterix::{NamedRecord, Value};
use formats::containers::TimeStamp;
use formats::recording::{Expansions, RecordingBytes, RecordingSurvey};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyString};

/// Number of records passed between threads at a time.
const BATCH: usize = 256;
/// Maximum number of waiting batches.
const BATCHES_WAITING: usize = 4;

fn chosen(editions: &[String]) -> PyResult<Vec<ChosenEdition>> {
    let parsed = editions.iter().map(|edition| edition.parse());
    parsed.collect::<Result<_, String>>().map_err(PyValueError::new_err)
}

/// Looks at the blocks of `path`.
///
/// # Errors
/// `ValueError` if it is no recording, with its kind.
fn surveyed(path: &Path, octets: &[u8], editions: &[ChosenEdition]) -> PyResult<RecordingSurvey> {
    let survey = RecordingBytes::new(octets).with_editions(editions).survey();
    match survey.foreign(octets) {
        None => Ok(survey),
        Some(kind) => {
            let what = format!("{}: no record of ASTERIX can be read: {kind}", path.display());
            Err(PyValueError::new_err(what))
        }
    }
}

/// Passes every plausible record to `visit`, until `visit` fails.
fn for_each<E>(
    octets: &[u8],
    survey: &RecordingSurvey,
    editions: &[ChosenEdition],
    mut visit: impl FnMut(NamedRecord) -> Result<(), E>,
) -> Result<(), E> {
    let recording = RecordingBytes::new(octets).with_editions(editions);
    let mut expansions = Expansions::new(editions);
    recording.for_each(survey, |found| {
        let mut named = NamedRecord::new(found.record);
        named.time_stamp_s = found.time_stamp.map(TimeStamp::seconds);
        expansions.read(found.record, &mut named);
        visit(named)
    })
}

fn octets_of(path: &Path) -> PyResult<Vec<u8>> {
    Ok(fs::read(path)?)
}

/// Records of a recording as dicts.
#[pyclass]
pub(super) struct Records {
    batches: Mutex<Receiver<Vec<NamedRecord>>>,
    batch: std::vec::IntoIter<NamedRecord>,
    names: Names,
}

/// Starts decoding.
#[pyfunction]
pub(super) fn records(py: Python<'_>, path: PathBuf, editions: Vec<String>) -> PyResult<Records> {
    let editions = chosen(&editions)?;
    let (octets, survey) = py.detach(|| {
        let octets = octets_of(&path)?;
        let survey = surveyed(&path, &octets, &editions)?;
        PyResult::Ok((octets, survey))
    })?;
    let (sender, batches) = sync_channel(BATCHES_WAITING);
    thread::spawn(move || {
        let mut batch = Vec::with_capacity(BATCH);
        // Sending fails after the receiver was dropped.
        let sent = for_each(&octets, &survey, &editions, |record| {
            batch.push(record);
            match batch.len() {
                BATCH => sender.send(std::mem::replace(&mut batch, Vec::with_capacity(BATCH))),
                _ => Ok(()),
            }
        });
        let _ = sent.and_then(|()| sender.send(batch));
    });
    Ok(Records {
        batches: Mutex::new(batches),
        batch: Vec::new().into_iter(),
        names: Names::default(),
    })
}

#[pymethods]
impl Records {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        if self.batch.len() == 0 {
            // The sender is dropped after the last record.
            let next = py.detach(|| super::lock(&self.batches).recv());
            self.batch = next.unwrap_or_default().into_iter();
        }
        let record = self.batch.next();
        record.map(|record| self.names.record(py, &record)).transpose()
    }
}

/// Python strings of the names, by address and length of the Rust text.
#[derive(Default)]
struct Names(HashMap<(usize, usize), Py<PyString>>);

impl Names {
    fn name<'py>(&mut self, py: Python<'py>, name: &'static str) -> Bound<'py, PyString> {
        let known = self.0.entry((name.as_ptr().addr(), name.len()));
        known
            .or_insert_with(|| PyString::intern(py, name).unbind())
            .bind(py)
            .clone()
    }

    fn record<'py>(&mut self, py: Python<'py>, record: &NamedRecord) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.dict(py, &record.items)?;
        dict.set_item(self.name(py, "_c"), record.category)?;
        if let Some(time_stamp_s) = record.time_stamp_s {
            dict.set_item(self.name(py, "_ts"), time_stamp_s)?;
        }
        Ok(dict)
    }

    fn dict<'py>(&mut self, py: Python<'py>, members: &[(&'static str, Value)]) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, value) in members {
            dict.set_item(self.name(py, name), self.value(py, value)?)?;
        }
        Ok(dict)
    }

    /// Converts a value to the form used in JSON.
    fn value<'py>(&mut self, py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
        Ok(match value {
            Value::Unsigned(number) => number.into_pyobject(py)?.into_any(),
            Value::Signed(number) => number.into_pyobject(py)?.into_any(),
            Value::Quantity(number) => number.into_pyobject(py)?.into_any(),
            Value::Text(text) => PyString::new(py, text).into_any(),
            Value::Bytes(octets) => {
                let digits: String = octets.iter().map(|octet| format!("{octet:02x}")).collect();
                PyString::new(py, &digits).into_any()
            }
            Value::Group(members) => self.dict(py, members)?.into_any(),
            Value::List(values) => {
                let list = PyList::empty(py);
                values
                    .iter()
                    .try_for_each(|value| list.append(self.value(py, value)?))?;
                list.into_any()
            }
        })
    }
}

/// Columns of one category.
#[derive(Default)]
struct CategoryColumns {
    rows: usize,
    columns: Vec<CategoryColumn>,
    root: NameNode,
}

/// Child names of a name, and the column of its values.
#[derive(Default)]
struct NameNode {
    members: Vec<(&'static str, NameNode)>,
    column: Option<usize>,
}

struct CategoryColumn {
    name: String,
    values: RecordValues,
}

/// One value per record; values of trailing records without the element may be absent.
enum RecordValues {
    Numbers(Vec<f64>),
    Others(Vec<Option<Value>>),
}

impl RecordValues {
    fn put(&mut self, row: usize, value: Value) {
        if let Self::Numbers(numbers) = self {
            if let Some(number) = value.as_f64() {
                numbers.resize(row, f64::NAN);
                numbers.push(number);
                return;
            }
            // An element whose content depends on another element may be a number in some records and a text in
            // others.
            let known = numbers
                .iter()
                .map(|number| (!number.is_nan()).then_some(Value::Quantity(*number)));
            *self = Self::Others(known.collect());
        }
        if let Self::Others(others) = self {
            others.resize(row, None);
            others.push(Some(value));
        }
    }
}

impl CategoryColumns {
    fn add(&mut self, record: NamedRecord) {
        let row = self.rows;
        self.rows += 1;
        let columns = &mut self.columns;
        for (name, value) in record.items {
            self.root.member(name).put(columns, &[name], row, value);
        }
        if let Some(time_stamp_s) = record.time_stamp_s {
            let name = "_ts";
            self.root
                .member(name)
                .put(columns, &[name], row, Value::Quantity(time_stamp_s));
        }
    }
}

impl NameNode {
    fn member(&mut self, name: &'static str) -> &mut NameNode {
        let place = self
            .members
            .iter()
            .position(|(known, _)| std::ptr::eq(*known, name) || *known == name);
        let place = place.unwrap_or_else(|| {
            self.members.push((name, NameNode::default()));
            self.members.len() - 1
        });
        &mut self.members[place].1
    }

    fn put(&mut self, columns: &mut Vec<CategoryColumn>, path: &[&'static str], row: usize, value: Value) {
        if let Value::Group(members) = value {
            for (name, value) in members {
                let path = [path, &[name]].concat();
                self.member(name).put(columns, &path, row, value);
            }
            return;
        }
        let place = *self.column.get_or_insert_with(|| {
            let values = match value.as_f64() {
                Some(_) => RecordValues::Numbers(Vec::new()),
                None => RecordValues::Others(Vec::new()),
            };
            columns.push(CategoryColumn {
                name: path.join("."),
                values,
            });
            columns.len() - 1
        });
        columns[place].values.put(row, value);
    }
}

type ColumnValues<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// Returns the columns of each category: the bytes of 64-bit floats, or a list.
#[pyfunction]
pub(super) fn columns<'py>(
    py: Python<'py>,
    path: PathBuf,
    editions: Vec<String>,
) -> PyResult<BTreeMap<u8, (usize, ColumnValues<'py>)>> {
    let editions = chosen(&editions)?;
    let tables = py.detach(|| {
        let octets = octets_of(&path)?;
        let survey = surveyed(&path, &octets, &editions)?;
        let mut tables: BTreeMap<u8, CategoryColumns> = BTreeMap::new();
        for_each(&octets, &survey, &editions, |record| {
            tables.entry(record.category).or_default().add(record);
            PyResult::Ok(())
        })?;
        PyResult::Ok(tables)
    })?;
    let mut names = Names::default();
    let table = |(category, table): (u8, CategoryColumns)| {
        let rows = table.rows;
        let columns = table.columns.into_iter().map(|column| {
            let values = match column.values {
                RecordValues::Numbers(mut numbers) => {
                    numbers.resize(rows, f64::NAN);
                    let octets: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
                    PyBytes::new(py, &octets).into_any()
                }
                RecordValues::Others(mut others) => {
                    others.resize(rows, None);
                    let list = PyList::empty(py);
                    for value in others {
                        match value {
                            Some(value) => list.append(names.value(py, &value)?)?,
                            None => list.append(py.None())?,
                        }
                    }
                    list.into_any()
                }
            };
            Ok((column.name, values))
        });
        Ok((category, (rows, columns.collect::<PyResult<_>>()?)))
    };
    tables.into_iter().map(table).collect()
}
