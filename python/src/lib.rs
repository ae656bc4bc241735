//! `koseki-client` for Python: the native part of `koseki/__init__.py`, which documents the interface.
//!
//! A slice is passed to Python as a buffer: numpy reads it in place, and it is returned when the last array over it
//! is dropped. Waiting releases the interpreter lock for other Python threads.

mod decoding;
mod observations;
mod tables;

use std::collections::BTreeMap;
use std::ffi::{CStr, c_int, c_void};
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::path::PathBuf;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use koseki_client::by_name::{self, AnyPublisher, AnySlice, AnySubscription};
use koseki_client::messages::OrderState;
use koseki_client::messages::layout::{ALL, Layout, Sample as _};
use koseki_client::{Error, ErrorKind, Orders, Root};
use observations::Columns;
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyBufferError, PyValueError};
use pyo3::ffi;
use pyo3::prelude::*;
use recording::{Item, RecordingError};

/// Maximum wait before Python checks for Ctrl-C.
const SIGNALS: Duration = Duration::from_millis(200);

/// Converts an error: the Python side raises an exception of its kind.
fn failed(error: Error) -> PyErr {
    let kind = match error.kind() {
        ErrorKind::NotRunning => "NotRunning",
        ErrorKind::Ended => "Ended",
        ErrorKind::Schema => "SchemaMismatch",
        ErrorKind::NoSuchTopic => "NoSuchTopic",
        ErrorKind::Full => "NoPlaceLeft",
        ErrorKind::Borrowed => "BorrowLimit",
        ErrorKind::Argument => return PyValueError::new_err(error.to_string()),
        ErrorKind::Fed => "AlreadyFed",
        ErrorKind::System => "KosekiError",
    };
    raised(kind, error.to_string())
}

/// Creates an exception of the package, of the class called `kind`.
fn raised(kind: &str, text: String) -> PyErr {
    Python::attach(|py| {
        let class = py.import("koseki._errors").and_then(|module| module.getattr(kind));
        class
            .and_then(|class| class.call1((text,)))
            .map_or_else(|error| error, PyErr::from_value)
    })
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

type FieldRow = (&'static str, &'static str, usize, usize, &'static str);

/// Returns the fields of a sample (name, Rust type, offset, size and documentation of each) and the size of the
/// sample, bytes.
fn fields(layout: &Layout) -> (Vec<FieldRow>, usize) {
    let of = |field: &koseki_client::messages::layout::SampleField| {
        (field.name, field.kind, field.offset, field.size, field.doc.trim())
    };
    (layout.fields.iter().map(of).collect(), layout.size)
}

/// Memory maps of all samples: name, fields, size in bytes.
#[pyfunction]
fn layouts() -> Vec<(&'static str, (Vec<FieldRow>, usize))> {
    ALL.iter().map(|layout| (layout.name, fields(layout))).collect()
}

/// Names of the running instances.
#[pyfunction]
fn instances(py: Python<'_>) -> PyResult<Vec<String>> {
    py.detach(koseki_client::instances).map_err(failed)
}

/// Names of the topics of an instance.
#[pyfunction]
fn topics(py: Python<'_>, instance: &str) -> PyResult<Vec<String>> {
    py.detach(|| koseki_client::topics(&Root::new(instance)?))
        .map_err(failed)
}

/// Names of the sources of an instance, by number.
#[pyfunction]
fn sources(instance: &str) -> PyResult<Vec<String>> {
    let root = Root::new(instance).map_err(|error| failed(error.into()))?;
    Ok(koseki_client::sources(&root))
}

/// The layout's name and all bytes of each topic.
type ReadTopics = BTreeMap<String, (&'static str, Vec<u8>)>;

/// Samples of a recording of all topics; damaged parts that were skipped, and their bytes.
#[pyfunction]
fn read(py: Python<'_>, path: PathBuf) -> PyResult<(ReadTopics, u64, u64)> {
    py.detach(|| {
        let mut file = File::open(&path)?;
        let mut topics = ReadTopics::new();
        let (mut damaged, mut damaged_bytes) = (0, 0);
        let shown = recording::read(&mut file, |item| {
            match item {
                Item::Topic { name, fingerprint, .. } => {
                    let same = |layout: &&Layout| format!("{:016x}", layout.fingerprint()) == fingerprint;
                    let Some(layout) = ALL.iter().find(same) else {
                        return Err(Unreadable::Schema(name.to_owned()));
                    };
                    topics.entry(name.to_owned()).or_insert((layout.name, Vec::new()));
                }
                Item::Sample { topic, octets } => {
                    let known = topics.get_mut(topic);
                    known.into_iter().for_each(|(_, all)| all.extend_from_slice(octets));
                }
                Item::Damaged { bytes, .. } => {
                    damaged += 1;
                    damaged_bytes += bytes.end - bytes.start;
                }
                Item::Facts(_) | Item::Slice { .. } => {}
            }
            Ok(())
        });
        match shown {
            Ok(_) => Ok((topics, damaged, damaged_bytes)),
            Err(Unreadable::Schema(topic)) => Err(failed(Error::Schema { topic })),
            Err(Unreadable::File(error)) => Err(PyValueError::new_err(format!("{}: {error}", path.display()))),
        }
    })
}

enum Unreadable {
    Schema(String),
    File(RecordingError),
}

impl From<RecordingError> for Unreadable {
    fn from(error: RecordingError) -> Self {
        Self::File(error)
    }
}

/// Reader of a topic.
#[pyclass(frozen)]
struct Subscription(Mutex<Option<Box<dyn AnySubscription>>>);

fn closed() -> PyErr {
    PyValueError::new_err("it is closed")
}

#[pymethods]
impl Subscription {
    #[new]
    fn open(py: Python<'_>, instance: &str, topic: &str, queue: Option<usize>) -> PyResult<Self> {
        let open = || by_name::subscribe(&Root::new(instance)?, topic, queue);
        let opened = py.detach(open).map_err(failed)?;
        Ok(Self(Mutex::new(Some(opened))))
    }

    /// Returns the next slice; `None` if none arrives within `timeout_s` seconds. A timeout of `None` waits without
    /// limit.
    fn receive(&self, py: Python<'_>, timeout_s: Option<f64>) -> PyResult<Option<Slice>> {
        let timeout = timeout_s.map(|seconds| Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX));
        let mut left = timeout.unwrap_or(Duration::MAX);
        loop {
            let time = left.min(SIGNALS);
            let next = py.detach(|| {
                let mut subscription = lock(&self.0);
                subscription.as_mut().map(|subscription| subscription.next(time))
            });
            match next.ok_or_else(closed)?.map_err(failed)? {
                Some(slice) => return Ok(Some(Slice(slice))),
                None => py.check_signals()?,
            }
            left = left.saturating_sub(time);
            if left.is_zero() {
                return Ok(None);
            }
        }
    }

    fn fileno(&self) -> PyResult<c_int> {
        let subscription = lock(&self.0);
        let fd = subscription
            .as_ref()
            .map(|subscription| subscription.as_fd().as_raw_fd());
        fd.ok_or_else(closed)
    }

    /// Returns the numbers of samples taken, lost and of older epochs, and the epoch.
    fn counts(&self) -> PyResult<(u64, u64, u64, u64)> {
        let subscription = lock(&self.0);
        let counts = subscription.as_ref().map(|subscription| subscription.counts());
        let counts = counts.ok_or_else(closed)?;
        Ok((counts.taken, counts.lost, counts.of_older_epochs, counts.epoch))
    }

    /// Returns the name of the sample type.
    fn sample(&self) -> PyResult<&'static str> {
        let subscription = lock(&self.0);
        let name = subscription.as_ref().map(|subscription| subscription.layout().name);
        name.ok_or_else(closed)
    }

    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(lock(&self.0).take()));
    }
}

/// Slice in shared memory, as a buffer of bytes.
#[pyclass(frozen)]
struct Slice(Box<dyn AnySlice>);

// SAFETY: a slice is only read after its creation.
unsafe impl Sync for Slice {}

#[pymethods]
impl Slice {
    #[getter]
    fn lost(&self) -> u64 {
        self.0.lost()
    }

    #[getter]
    fn starts_epoch(&self) -> bool {
        self.0.starts_epoch()
    }

    #[getter]
    fn sent_ns(&self) -> i64 {
        self.0.header().sent_ns
    }

    #[getter]
    fn epoch(&self) -> u64 {
        self.0.header().epoch
    }

    /// # Safety
    /// Python's buffer protocol is the only caller.
    unsafe fn __getbuffer__(slf: PyRef<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        const OCTETS: &CStr = c"B";
        if view.is_null() || flags & ffi::PyBUF_WRITABLE != 0 {
            return Err(PyBufferError::new_err("a slice in shared memory can only be read"));
        }
        let octets = slf.0.octets();
        let (start, length) = (octets.as_ptr(), octets.len().cast_signed());
        // SAFETY: Python passes a view to fill. The bytes stay in place while the slice lives, and the view holds a
        // reference to the slice. Nothing writes through the view, since it is marked as read-only.
        let outcome = unsafe {
            let format = OCTETS.as_ptr();
            let outcome =
                ffi::PyBuffer_FillInfo(view, slf.as_ptr(), start.cast_mut().cast::<c_void>(), length, 1, flags);
            if outcome == 0 && flags & ffi::PyBUF_FORMAT != 0 {
                (*view).format = format.cast_mut();
            }
            (*view).internal = ptr::null_mut();
            outcome
        };
        match outcome {
            0 => Ok(()),
            _ => Err(PyErr::fetch(slf.py())),
        }
    }
}

/// Writer of a topic.
#[pyclass(frozen)]
struct Publisher(Mutex<Option<Box<dyn AnyPublisher>>>);

#[pymethods]
impl Publisher {
    #[new]
    fn open(py: Python<'_>, instance: &str, topic: &str) -> PyResult<Self> {
        let open = || by_name::publisher(&Root::new(instance)?, topic);
        let opened = py.detach(open).map_err(failed)?;
        Ok(Self(Mutex::new(Some(opened))))
    }

    /// Feeds a source with what it takes.
    #[staticmethod]
    fn feed(py: Python<'_>, instance: &str, source: &str) -> PyResult<Self> {
        let open = || by_name::feed(&Root::new(instance)?, source);
        let opened = py.detach(open).map_err(failed)?;
        Ok(Self(Mutex::new(Some(opened))))
    }

    /// Publishes observations as columns of `rows` values; with `are_tracks` reports of tracks, else detections.
    fn send_observations(
        &self,
        py: Python<'_>,
        are_tracks: bool,
        rows: usize,
        numbers: Vec<(String, PyBuffer<f64>)>,
        wholes: Vec<(String, PyBuffer<i64>)>,
        callsigns: Option<Vec<String>>,
    ) -> PyResult<()> {
        let columns = Columns::of(py, rows, numbers, wholes, callsigns)?;
        let sent = py.detach(|| {
            lock(&self.0)
                .as_mut()
                .map(|publisher| columns.send(are_tracks, &mut **publisher))
        });
        sent.ok_or_else(closed)?.map_err(failed)
    }

    /// Sets the largest distance of a time from this machine's clock, seconds.
    fn limit_clock(&self, limit_s: f64) -> PyResult<()> {
        let limit = by_name::clock_limit(limit_s).map_err(failed)?;
        lock(&self.0).as_mut().ok_or_else(closed)?.limit_clock(limit);
        Ok(())
    }

    fn publish(&self, py: Python<'_>, octets: &[u8]) -> PyResult<()> {
        let published = py.detach(|| lock(&self.0).as_mut().map(|publisher| publisher.publish(octets)));
        published.ok_or_else(closed)?.map_err(failed)
    }

    fn sent(&self) -> PyResult<u64> {
        lock(&self.0)
            .as_ref()
            .map(|publisher| publisher.sent())
            .ok_or_else(closed)
    }

    /// Returns the name of the sample type.
    fn sample(&self) -> PyResult<&'static str> {
        lock(&self.0)
            .as_ref()
            .map(|publisher| publisher.layout().name)
            .ok_or_else(closed)
    }

    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(lock(&self.0).take()));
    }
}

/// Gives an order and returns the bytes of its state; `None` if no answer arrives in time.
#[pyfunction]
fn order(
    py: Python<'_>,
    instance: &str,
    words: &str,
    operator: &str,
    lasts_s: Option<f64>,
    timeout_s: f64,
) -> PyResult<Option<Vec<u8>>> {
    let timeout = Duration::try_from_secs_f64(timeout_s.max(0.0)).unwrap_or(Duration::MAX);
    let give = || {
        let mut orders = Orders::open(instance, operator)?;
        let order = orders.of_words(words)?;
        orders.give(&order, lasts_s, timeout)
    };
    let answer = py.detach(give).map_err(failed)?;
    Ok(answer.map(|state| OrderState::octets(std::slice::from_ref(&state)).to_vec()))
}

#[pymodule]
fn _koseki(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Subscription>()?;
    module.add_class::<Slice>()?;
    module.add_class::<Publisher>()?;
    module.add_class::<decoding::Records>()?;
    module.add_function(wrap_pyfunction!(decoding::records, module)?)?;
    module.add_function(wrap_pyfunction!(decoding::columns, module)?)?;
    module.add_function(wrap_pyfunction!(observations::observation_column, module)?)?;
    module.add_function(wrap_pyfunction!(observations::observation_numbers, module)?)?;
    module.add_function(wrap_pyfunction!(tables::run, module)?)?;
    module.add_function(wrap_pyfunction!(tables::of_samples, module)?)?;
    module.add_function(wrap_pyfunction!(instances, module)?)?;
    module.add_function(wrap_pyfunction!(topics, module)?)?;
    module.add_function(wrap_pyfunction!(sources, module)?)?;
    module.add_function(wrap_pyfunction!(order, module)?)?;
    module.add_function(wrap_pyfunction!(layouts, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)
}
