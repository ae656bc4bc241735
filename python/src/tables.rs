//! Commands on tables for Python: the executable's commands on files, applied to columns.
//!
//! The commands read and write tables of text. Columns are therefore converted to text in memory and back, with
//! numbers in the shortest form that reads as the same number. Results equal those of the executable to the digit.
//! An error names the line of the table as in a file whose first line holds the columns' names.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use frames::{Geodetic, SystemFrame};
use offline::{Host, InputError, TableCommand, TableInput, TableOutput};
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyList};

/// Time between two checks for Ctrl-C, with progress reports to Python.
const LOOKS: Duration = Duration::from_millis(50);
/// Columns that stay text regardless of content: an address may look like a number.
const TEXTS: [&str; 10] = [
    "address", "callsign", "lambda", "mmsi", "mode_3a", "name", "sources", "state", "type", "weights",
];

/// Table from Python.
#[derive(FromPyObject)]
pub(super) enum Given {
    Text(String),
    Columns(Vec<(String, GivenColumn)>),
}

/// Values of one column.
#[derive(FromPyObject)]
pub(super) enum GivenColumn {
    Numbers(PyBuffer<f64>),
    Wholes(PyBuffer<i64>),
    Texts(Vec<String>),
}

enum Values {
    Numbers(Vec<f64>),
    Wholes(Vec<i64>),
    Texts(Vec<String>),
}

impl GivenColumn {
    fn values(&self, py: Python<'_>) -> PyResult<Values> {
        Ok(match self {
            Self::Numbers(buffer) => Values::Numbers(buffer.to_vec(py)?),
            Self::Wholes(buffer) => Values::Wholes(buffer.to_vec(py)?),
            Self::Texts(texts) => Values::Texts(texts.clone()),
        })
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Wholes(wholes) => wholes.len(),
            Self::Texts(texts) => texts.len(),
        }
    }

    /// Appends the value of a row; nothing for a missing value.
    fn write(&self, row: usize, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Numbers(numbers) if numbers[row].is_nan() => Ok(()),
            Self::Numbers(numbers) => write!(text, "{}", numbers[row]),
            Self::Wholes(wholes) => write!(text, "{}", wholes[row]),
            Self::Texts(texts) => text.write_str(&texts[row]),
        };
    }

    /// Converts values to numbers if all of them are numbers or missing.
    fn of(name: &str, texts: Vec<&str>) -> Self {
        if !TEXTS.contains(&name) {
            if let Ok(wholes) = texts.iter().map(|text| text.parse()).collect() {
                return Self::Wholes(wholes);
            }
            let number = |text: &&str| if text.is_empty() { Ok(f64::NAN) } else { text.parse() };
            if let Ok(numbers) = texts.iter().map(number).collect() {
                return Self::Numbers(numbers);
            }
        }
        Self::Texts(texts.into_iter().map(str::to_owned).collect())
    }

    /// Returns the numpy type and bytes, or a list.
    fn handed_out<'py>(&self, py: Python<'py>) -> PyResult<(&'static str, Bound<'py, PyAny>)> {
        fn octets<const N: usize, T: Copy>(values: &[T], octets: fn(T) -> [u8; N]) -> Vec<u8> {
            values.iter().flat_map(|value| octets(*value)).collect()
        }
        Ok(match self {
            Self::Numbers(numbers) => (
                "<f8",
                PyByteArray::new(py, &octets(numbers, f64::to_le_bytes)).into_any(),
            ),
            Self::Wholes(wholes) => (
                "<i8",
                PyByteArray::new(py, &octets(wholes, i64::to_le_bytes)).into_any(),
            ),
            Self::Texts(texts) => ("O", PyList::new(py, texts)?.into_any()),
        })
    }
}

/// Returns the text of a table, or the fault of its columns.
fn as_text(columns: &[(String, Values)]) -> Result<String, String> {
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    let mut text = String::new();
    for (place, (name, values)) in columns.iter().enumerate() {
        if values.len() != rows {
            return Err(format!(
                "column {name} has {} values, {} has {rows}",
                values.len(),
                columns[0].0
            ));
        }
        if let Values::Texts(texts) = values
            && let Some(row) = texts.iter().position(|text| text.contains([',', '\n', '\r']))
        {
            let (line, value) = (row + 2, &texts[row]);
            return Err(format!(
                "line {line}, column {name}: {value:?} holds a comma or the end of a line"
            ));
        }
        text.push_str(if place == 0 { "" } else { "," });
        text.push_str(name);
    }
    text.push('\n');
    for row in 0..rows {
        for (place, (_, values)) in columns.iter().enumerate() {
            text.push_str(if place == 0 { "" } else { "," });
            values.write(row, &mut text);
        }
        text.push('\n');
    }
    Ok(text)
}

/// Returns the columns of a table written by a command.
fn as_columns(text: &str) -> Vec<(String, Values)> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, value) in columns.iter_mut().zip(line.split(',')) {
            column.push(value);
        }
    }
    let named = names.into_iter().zip(columns);
    named
        .map(|(name, texts)| (name.to_owned(), Values::of(name, texts)))
        .collect()
}

/// Request from Python to end a command: Ctrl-C, or an exception in its progress function.
struct Watch {
    progress: Option<Py<PyAny>>,
    looked: Cell<Instant>,
    failed: RefCell<Option<PyErr>>,
}

impl Watch {
    /// Checks regularly, at most every `LOOKS`.
    fn look(&self, share: Option<f64>) -> io::Result<()> {
        match self.looked.get().elapsed() < LOOKS {
            true => Ok(()),
            false => self.look_now(share),
        }
    }

    fn look_now(&self, share: Option<f64>) -> io::Result<()> {
        let ended = || io::Error::other("given up");
        if self.failed.borrow().is_some() {
            return Err(ended());
        }
        self.looked.set(Instant::now());
        let looked = Python::attach(|py| {
            py.check_signals()?;
            match (&self.progress, share) {
                (Some(progress), Some(share)) => progress.call1(py, (share,)).map(|_| ()),
                _ => Ok(()),
            }
        });
        looked.map_err(|error| {
            self.failed.replace(Some(error));
            ended()
        })
    }
}

/// Input that permits Python to end the command during reading.
struct InterruptibleInput<T> {
    octets: T,
    watch: Rc<Watch>,
}

impl<T: Read> Read for InterruptibleInput<T> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.watch.look(None)?;
        self.octets.read(buffer)
    }
}

impl<T: Seek> Seek for InterruptibleInput<T> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.octets.seek(to)
    }
}

type WrittenTables = Rc<RefCell<BTreeMap<PathBuf, Vec<u8>>>>;

/// Tables in memory by name; other names refer to files. All output stays in memory.
struct TableMemory {
    tables: BTreeMap<PathBuf, Arc<[u8]>>,
    written: WrittenTables,
    answer: RefCell<String>,
    said: RefCell<String>,
    watch: Rc<Watch>,
}

impl TableMemory {
    fn watched(&self, octets: impl Read + Seek + 'static, length: u64) -> TableInput {
        let watch = Rc::clone(&self.watch);
        TableInput::new(InterruptibleInput { octets, watch }, length)
    }
}

impl Host for TableMemory {
    fn open(&self, path: &Path) -> Result<TableInput, InputError> {
        if let Some(table) = self.tables.get(path) {
            return Ok(self.watched(Cursor::new(Arc::clone(table)), table.len() as u64));
        }
        let file: File = offline::open(path)?;
        let length = file.metadata().map_or(0, |found| found.len());
        Ok(self.watched(file, length))
    }

    fn begin(&self, path: &Path) -> anyhow::Result<Box<dyn TableOutput>> {
        Ok(Box::new(OutputTable {
            path: path.to_owned(),
            octets: Vec::new(),
            written: Rc::clone(&self.written),
        }))
    }

    fn make_folder(&self, _path: &Path) -> io::Result<()> {
        Ok(())
    }

    fn print(&self, text: &str) -> anyhow::Result<()> {
        self.answer.borrow_mut().push_str(text);
        Ok(())
    }

    fn say(&self, text: &str) {
        self.said.borrow_mut().push_str(text);
    }

    fn progress(&self, done: u64, of: u64) -> io::Result<()> {
        self.watch.look(Some(done as f64 / of.max(1) as f64))
    }

    fn passed(&self) {
        // A failure is detected below.
        let _ = self.watch.look_now(Some(1.0));
    }
}

/// Output table.
#[derive(Debug)]
struct OutputTable {
    path: PathBuf,
    octets: Vec<u8>,
    written: WrittenTables,
}

impl Write for OutputTable {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.octets.write(octets)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl TableOutput for OutputTable {
    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        let OutputTable { path, octets, written } = *self;
        written.borrow_mut().insert(path, octets);
        Ok(())
    }
}

type OutputColumns<'py> = BTreeMap<String, Vec<(String, (&'static str, Bound<'py, PyAny>))>>;

/// Executes the command `words`; returns the written tables, the answer, and the messages beside it.
#[pyfunction]
pub(super) fn run<'py>(
    py: Python<'py>,
    words: Vec<String>,
    tables: BTreeMap<String, Given>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(OutputColumns<'py>, String, String)> {
    let mut texts = BTreeMap::new();
    let mut columns = BTreeMap::new();
    for (name, given) in tables {
        match given {
            Given::Text(text) => _ = texts.insert(name, text),
            Given::Columns(given) => {
                let values = given
                    .iter()
                    .map(|(name, column)| Ok((name.clone(), column.values(py)?)));
                columns.insert(name, values.collect::<PyResult<Vec<_>>>()?);
            }
        }
    }
    let (written, answer, said) = py.detach(move || {
        let command = TableCommand::of(&words).map_err(|error| PyValueError::new_err(error.to_string()))?;
        for (name, columns) in columns {
            let text = as_text(&columns).map_err(|fault| PyValueError::new_err(format!("{name}: {fault}")))?;
            texts.insert(name, text);
        }
        let table = |(name, text): (String, String)| (PathBuf::from(name), Arc::from(text.into_bytes()));
        let memory = TableMemory {
            tables: texts.into_iter().map(table).collect(),
            written: Rc::default(),
            answer: RefCell::default(),
            said: RefCell::default(),
            watch: Rc::new(Watch {
                progress,
                looked: Cell::new(Instant::now()),
                failed: RefCell::default(),
            }),
        };
        let done = command.run(&memory);
        if let Some(error) = memory.watch.failed.take() {
            return Err(error);
        }
        done.map_err(|error| failed(&error))?;
        let written = memory.written.take().into_iter().map(|(path, octets)| {
            let columns = as_columns(&String::from_utf8_lossy(&octets));
            (path.to_string_lossy().into_owned(), columns)
        });
        let written: Vec<_> = written.collect();
        Ok((written, memory.answer.take(), memory.said.take()))
    })?;
    let handed_out = written.iter().map(|(path, columns)| {
        let columns = columns
            .iter()
            .map(|(name, values)| Ok((name.clone(), values.handed_out(py)?)));
        Ok((path.clone(), columns.collect::<PyResult<_>>()?))
    });
    Ok((handed_out.collect::<PyResult<_>>()?, answer, said))
}

/// Columns that state a place on the earth, which needs the origin of the system frame.
const PLACES: [&str; 3] = ["latitude", "longitude", "flight_level"];

type HandedOut<'py> = Vec<(String, (&'static str, Bound<'py, PyAny>))>;

/// Samples called `sample` as the columns of the recorder's tables. Times count from `first_day_ns`; `origin` is the
/// latitude and longitude (degrees) and the height (m) of the system frame's origin.
#[pyfunction]
pub(super) fn of_samples<'py>(
    py: Python<'py>,
    sample: &str,
    octets: &[u8],
    origin: Option<(f64, f64, f64)>,
    first_day_ns: i64,
) -> PyResult<HandedOut<'py>> {
    let (latitude, longitude, height_m) = origin.unwrap_or_default();
    let origin_place = Geodetic::from_degrees(latitude, longitude, height_m)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let columns = py.detach(|| {
        let text = recorder::table(sample, octets, &SystemFrame::at(origin_place), first_day_ns)?;
        Some(as_columns(&text))
    });
    let columns = columns.ok_or_else(|| PyValueError::new_err(format!("{sample} has no table")))?;
    let is_known = |(name, _): &&(String, Values)| origin.is_some() || !PLACES.contains(&name.as_str());
    let handed_out = columns.iter().filter(is_known);
    handed_out
        .map(|(name, values)| Ok((name.clone(), values.handed_out(py)?)))
        .collect()
}

/// Converts an error: a rejected input or option becomes a `ValueError`, other errors a failure of the engine.
fn failed(error: &anyhow::Error) -> PyErr {
    let text = format!("{error:#}");
    match offline::is_refused(error) {
        true => PyValueError::new_err(text),
        false => super::raised("KosekiError", text),
    }
}
