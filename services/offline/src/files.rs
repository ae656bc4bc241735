//! Input and output files of commands.
//!
//! An output file appears complete or not at all: a command writes the file under another name in the same folder and
//! renames the complete file. A command that fails or is killed leaves no partial table under the final name, and the
//! result of an earlier run remains until a new result replaces it. `-` is standard output.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read as _, Write};
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

/// Size of read and write buffers, bytes. Data written in pieces of this size are not copied together.
pub const BUFFER_OCTETS: usize = 1 << 18;

/// Output that is standard output.
const STANDARD_OUTPUT: &str = "-";

/// Command line that is well-formed but contradictory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Unusable input file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", file.display())]
pub struct InputError {
    file: PathBuf,
    what: String,
}

impl InputError {
    /// Creates the error of a file with a fault.
    pub fn new(file: &Path, what: impl std::fmt::Display) -> Self {
        Self {
            file: file.to_owned(),
            what: what.to_string(),
        }
    }

    /// Creates the error of a file that the system does not give, or not as text.
    pub fn unreadable(file: &Path, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::InvalidData => Self::new(file, "is no text in UTF-8"),
            _ => Self::new(file, format!("cannot be read: {error}")),
        }
    }

    /// Adds the purpose of the file to the message.
    pub(crate) fn with(mut self, needed: &str) -> Self {
        self.what = format!("{}; {needed}", self.what);
        self
    }
}

/// Opens an input file.
///
/// # Errors
/// If the file cannot be read.
pub fn open(file: &Path) -> Result<File, InputError> {
    let failed = |error| InputError::unreadable(file, &error);
    let opened = File::open(file).map_err(failed)?;
    if opened.metadata().map_err(failed)?.is_dir() {
        return Err(InputError::new(file, "is a folder; name a file"));
    }
    Ok(opened)
}

/// Reads a whole input file.
///
/// # Errors
/// If the file cannot be read.
pub fn read(file: &Path) -> Result<Vec<u8>, InputError> {
    let mut octets = Vec::new();
    let read = open(file)?.read_to_end(&mut octets);
    read.map_err(|error| InputError::unreadable(file, &error))?;
    Ok(octets)
}

/// Reads a whole input file of text.
///
/// # Errors
/// If the file cannot be read, or is no text.
pub fn read_text(file: &Path) -> Result<String, InputError> {
    let as_text = |error: std::string::FromUtf8Error| io::Error::new(io::ErrorKind::InvalidData, error);
    String::from_utf8(read(file)?).map_err(|error| InputError::unreadable(file, &as_text(error)))
}

/// Returns the name of an output in a message: the path, or the words for standard output.
pub(crate) fn output_name(path: &Path) -> std::path::Display<'_> {
    let is_standard = path == Path::new(STANDARD_OUTPUT);
    if is_standard {
        Path::new("standard output")
    } else {
        path
    }
    .display()
}

/// Whether two paths refer to the same existing file.
pub fn is_same_file(one: &Path, other: &Path) -> bool {
    matches!((fs::canonicalize(one), fs::canonicalize(other)), (Ok(one), Ok(other)) if one == other)
}

/// Finds a file named twice: the reports would count twice.
pub(crate) fn named_twice(files: &[PathBuf]) -> Option<&Path> {
    let twice = files.iter().enumerate().find(|(place, file)| {
        let before = &files[..*place];
        before.iter().any(|other| is_same_file(other, file))
    });
    twice.map(|(_, file)| file.as_path())
}

/// Rejects outputs that would overwrite an input or another output.
///
/// # Errors
/// The option and the named file.
pub fn check_outputs<'a>(
    inputs: impl IntoIterator<Item = &'a PathBuf> + Clone,
    outputs: &[(&str, Option<&PathBuf>)],
) -> Result<(), Usage> {
    for (place, (option, file)) in outputs.iter().enumerate() {
        let Some(file) = file else { continue };
        if inputs.clone().into_iter().any(|input| is_same_file(input, file)) {
            let what = format!("{option} {} is an input; name another file", file.display());
            return Err(Usage(what));
        }
        for (other_option, other) in &outputs[place + 1..] {
            if other.is_some_and(|other| other == *file || is_same_file(other, file)) {
                return Err(Usage(format!("{option} and {other_option} name one file; name two")));
            }
        }
    }
    Ok(())
}

/// Rejects an output to standard output beside an answer as JSON, which goes there, too.
///
/// # Errors
/// The option.
pub(crate) fn check_answer(json: bool, outputs: &[(&str, Option<&PathBuf>)]) -> Result<(), Usage> {
    let is_there = |file: Option<&PathBuf>| file.is_some_and(|file| file == Path::new(STANDARD_OUTPUT));
    match outputs.iter().find(|(_, file)| json && is_there(*file)) {
        Some((option, _)) => Err(Usage(format!(
            "{option} - and --json would mix on standard output: give {option} a file"
        ))),
        None => Ok(()),
    }
}

/// Output file that appears when complete.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    /// Path written until completion; `None` for a device, a pipe or standard output, which are written directly.
    unfinished: Option<PathBuf>,
    /// `None` once the file is complete, or standard output is closed by the reader.
    writer: Option<BufWriter<File>>,
    /// Whether the reader has closed standard output, as `| head` does.
    is_closed: bool,
}

impl OutputFile {
    /// Begins the file that becomes `path`.
    ///
    /// # Errors
    /// If the file cannot be written there, which is wrong usage: the path is of the command line.
    pub fn begin(path: &Path) -> anyhow::Result<Self> {
        if path == Path::new(STANDARD_OUTPUT) {
            let duplicate = io::stdout().as_fd().try_clone_to_owned();
            let file = File::from(duplicate.context("standard output cannot be written")?);
            return Ok(Self {
                path: "standard output".into(),
                unfinished: None,
                writer: Some(BufWriter::with_capacity(BUFFER_OCTETS, file)),
                is_closed: false,
            });
        }
        let is_device = fs::metadata(path).is_ok_and(|found| !found.is_file());
        let unfinished = (!is_device).then(|| unfinished_name(path));
        let at = unfinished.as_deref().unwrap_or(path);
        let opened = if is_device {
            File::options().write(true).open(at)
        } else {
            File::create(at)
        };
        let file = opened.map_err(|error| unwritable(path, &error))?;
        Ok(Self {
            path: path.to_owned(),
            unfinished,
            writer: Some(BufWriter::with_capacity(BUFFER_OCTETS, file)),
            is_closed: false,
        })
    }

    /// Where the complete file will be.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Moves the complete file to the final place.
    ///
    /// # Errors
    /// If the file cannot be completed or moved.
    pub fn finish(mut self) -> anyhow::Result<()> {
        let finished = self.flush();
        self.writer = None;
        finished
            .and_then(|()| match &self.unfinished {
                Some(unfinished) => fs::rename(unfinished, &self.path),
                None => Ok(()),
            })
            .with_context(|| format!("{} cannot be written", self.path.display()))?;
        self.unfinished = None;
        Ok(())
    }
}

impl OutputFile {
    /// Result of a write to a file, or to standard output: a closed reader is no failure.
    fn written<T>(&mut self, outcome: io::Result<T>, all: T) -> io::Result<T> {
        match outcome {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe && self.unfinished.is_none() => {
                // The buffer's content is not written again on dropping.
                let _ = self.writer.take().map(BufWriter::into_parts);
                self.is_closed = true;
                Ok(all)
            }
            outcome => outcome,
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        let outcome = match &mut self.writer {
            Some(writer) => writer.write(octets),
            None if self.is_closed => return Ok(octets.len()),
            None => return Err(io::ErrorKind::NotConnected.into()),
        };
        self.written(outcome, octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let outcome = self.writer.as_mut().map_or(Ok(()), Write::flush);
        self.written(outcome, ())
    }
}

impl io::Seek for OutputFile {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        match &mut self.writer {
            Some(writer) => writer.seek(to),
            None => Err(io::ErrorKind::NotConnected.into()),
        }
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Some(unfinished) = &self.unfinished {
            drop(self.writer.take());
            let _ = fs::remove_file(unfinished);
        }
    }
}

/// The place of an output cannot be used.
pub fn unwritable(path: &Path, error: &io::Error) -> Usage {
    Usage(format!(
        "{}: cannot be written: {error}; name another place",
        path.display()
    ))
}

/// Returns a name beside `path`, so that a rename suffices. The name contains the process number, so that two processes
/// do not share a name.
fn unfinished_name(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}
