//! Whoever runs a command.

use std::fmt::Debug;
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use crate::files::InputError;

/// Gives a command its tables, takes what it writes and says, and learns how far it is.
pub trait Host {
    /// Opens an input.
    ///
    /// # Errors
    /// If it cannot be read.
    fn open(&self, path: &Path) -> Result<Input, InputError>;

    /// Begins an output.
    ///
    /// # Errors
    /// If it cannot be written.
    fn begin(&self, path: &Path) -> anyhow::Result<Box<dyn Output>>;

    /// Makes a folder for outputs.
    ///
    /// # Errors
    /// If it cannot be made.
    fn make_folder(&self, path: &Path) -> io::Result<()>;

    /// Takes the answer.
    ///
    /// # Errors
    /// If it cannot be printed.
    fn print(&self, text: &str) -> anyhow::Result<()>;

    /// Takes what is said beside the answer; nothing fails if nobody hears it.
    fn say(&self, text: &str);

    /// Learns that so much of a pass is done, in whatever it is counted. Comes often: with each report or scan.
    ///
    /// # Errors
    /// If the command is to end.
    fn progress(&self, done: u64, of: u64) -> io::Result<()>;

    /// Learns that a pass is over.
    fn passed(&self);
}

impl dyn Host + '_ {
    /// Text of a whole input.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn text(&self, path: &Path) -> Result<String, InputError> {
        let mut text = String::new();
        let read = self.open(path)?.read_to_string(&mut text);
        read.map_err(|error| InputError::new(path, format!("cannot be read: {error}")))?;
        Ok(text)
    }

    /// Shows a summary: as JSON for an answer, else as text beside it.
    ///
    /// # Errors
    /// If the answer cannot be printed.
    pub fn show(&self, json: Option<serde_json::Value>, text: impl FnOnce() -> String) -> anyhow::Result<()> {
        match json {
            Some(json) => self.print(&format!("{json}\n")),
            None => {
                self.say(&text());
                Ok(())
            }
        }
    }
}

/// Octets that can be read again.
trait Octets: Read + Seek {}

impl<T: Read + Seek> Octets for T {}

/// A table to be read.
pub struct Input {
    octets: Box<dyn Octets>,
    /// Its size; 0 where that is not known.
    pub length: u64,
}

impl Input {
    /// Octets as an input, and how many they are.
    pub fn new(octets: impl Read + Seek + 'static, length: u64) -> Self {
        Self {
            octets: Box::new(octets),
            length,
        }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.octets.read(buffer)
    }
}

impl Seek for Input {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.octets.seek(to)
    }
}

/// A table that is written, and appears when it is complete.
pub trait Output: Write + Debug {
    /// Puts it in its place.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}
