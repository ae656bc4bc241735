//! Commands on files, run from a command line.

use std::cell::Cell;
use std::fs;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;

use configuration::{Config, ConfigError};

use crate::files::{InputError, OutputFile, open};
use crate::host::{Host, TableInput, TableOutput};

/// Inputs below this size show no progress, bytes.
const SHOWN_OCTETS_MIN: u64 = 64 << 20;

/// Host of a command line: answers go to standard output, messages to standard error. For long work, a terminal
/// shows a percentage that overwrites itself.
#[derive(Debug)]
pub struct Terminal {
    percent: Cell<u64>,
    read: ReadDeployment,
}

/// Reader of a deployment's file, from path, text and replaced values.
type ReadDeployment = fn(&Path, &str, &[String]) -> Result<Config, ConfigError>;

impl Default for Terminal {
    fn default() -> Self {
        Self::reading(Config::parse)
    }
}

impl Terminal {
    /// Creates the host of an executable that reads deployments by `read`.
    pub fn reading(read: ReadDeployment) -> Self {
        Self {
            percent: Cell::default(),
            read,
        }
    }
}

impl Host for Terminal {
    fn open(&self, path: &Path) -> Result<TableInput, InputError> {
        let file = open(path)?;
        let length = file.metadata().map_or(0, |found| found.len());
        Ok(TableInput::new(file, length))
    }

    fn begin(&self, path: &Path) -> anyhow::Result<Box<dyn TableOutput>> {
        Ok(Box::new(OutputFile::begin(path)?))
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        fs::create_dir_all(path)
    }

    /// Prints an answer. A closed reader (`| head`) is no failure.
    fn print(&self, text: &str) -> anyhow::Result<()> {
        match io::stdout().write_all(text.as_bytes()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
            _ => Ok(()),
        }
    }

    fn say(&self, text: &str) {
        let _ = io::stderr().write_all(text.as_bytes());
    }

    fn progress(&self, done: u64, of: u64) -> io::Result<()> {
        if of >= SHOWN_OCTETS_MIN && done * 100 >= (self.percent.get() + 1) * of && io::stderr().is_terminal() {
            self.percent.set(done * 100 / of);
            self.say(&format!("\r{} %", self.percent.get()));
        }
        Ok(())
    }

    fn passed(&self) {
        if self.percent.take() > 0 {
            self.say("\r     \r");
        }
    }

    fn deployment(&self, path: &Path, text: &str, overrides: &[String]) -> Result<Config, ConfigError> {
        (self.read)(path, text, overrides)
    }
}

impl TableOutput for OutputFile {
    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        OutputFile::finish(*self)
    }
}
