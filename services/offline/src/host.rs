//! Environment in which a command runs.

use std::fmt::Debug;
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use configuration::{Config, ConfigError};

use crate::files::InputError;

/// Environment of a command: provides tables, receives output and messages, and tracks progress.
pub trait Host {
    /// Opens an input.
    ///
    /// # Errors
    /// If the input cannot be read.
    fn open(&self, path: &Path) -> Result<TableInput, InputError>;

    /// Begins an output.
    ///
    /// # Errors
    /// If the output cannot be written.
    fn begin(&self, path: &Path) -> anyhow::Result<Box<dyn TableOutput>>;

    /// Makes a folder for outputs.
    ///
    /// # Errors
    /// If the folder cannot be made.
    fn make_folder(&self, path: &Path) -> io::Result<()>;

    /// Prints the answer.
    ///
    /// # Errors
    /// If the answer cannot be printed.
    fn print(&self, text: &str) -> anyhow::Result<()>;

    /// Prints a message beside the answer; failures are ignored.
    fn say(&self, text: &str);

    /// Reports the progress of a pass, in any unit. Called often: for each report or scan.
    ///
    /// # Errors
    /// If the command is to end.
    fn progress(&self, done: u64, of: u64) -> io::Result<()>;

    /// Reports the end of a pass.
    fn passed(&self);

    /// Reads `text` as the file `path` of a deployment. By default, the keys of services are ignored: these keys do not
    /// change the results, and a host need not contain the services.
    ///
    /// # Errors
    /// If a key is refused.
    fn deployment(&self, path: &Path, text: &str, overrides: &[String]) -> Result<Config, ConfigError> {
        Config::parse(path, text, overrides)
    }
}

impl dyn Host + '_ {
    /// Reads the text of a whole input.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub(crate) fn text(&self, path: &Path) -> Result<String, InputError> {
        let mut text = String::new();
        let read = self.open(path)?.read_to_string(&mut text);
        read.map_err(|error| InputError::unreadable(path, &error))?;
        Ok(text)
    }

    /// Shows a summary: JSON as the answer, else text beside the answer.
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

/// Bytes that can be read repeatedly.
trait ByteSource: Read + Seek {}

impl<T: Read + Seek> ByteSource for T {}

/// Input table.
pub struct TableInput {
    octets: Box<dyn ByteSource>,
    /// Size, bytes; 0 if unknown.
    pub length: u64,
}

impl TableInput {
    /// Creates an input from bytes and the number of bytes.
    pub fn new(octets: impl Read + Seek + 'static, length: u64) -> Self {
        Self {
            octets: Box::new(octets),
            length,
        }
    }
}

impl Read for TableInput {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.octets.read(buffer)
    }
}

impl Seek for TableInput {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.octets.seek(to)
    }
}

/// Output table that appears when complete.
pub trait TableOutput: Write + Debug {
    /// Moves the table to the final place.
    ///
    /// # Errors
    /// If the table cannot be stored.
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}
