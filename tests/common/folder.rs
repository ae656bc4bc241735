//! A folder in which the executable is called as a user calls it.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A folder to work in.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder not in `$TMPDIR`, because the paths of sockets must be short.
    pub(crate) fn of_short_path() -> Self {
        Self(tempfile::Builder::new().prefix("k").tempdir_in("/tmp").unwrap())
    }

    /// A folder with these files.
    pub(crate) fn with<T: AsRef<[u8]>>(files: &[(&str, T)]) -> Self {
        let folder = Self::new();
        for (name, content) in files {
            folder.write(name, content);
        }
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names of the files that are there.
    pub(crate) fn names(&self) -> BTreeSet<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    /// `koseki` in the folder, with arguments apart by blanks.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = super::koseki();
        command.args(arguments.split_whitespace()).current_dir(self.0.path());
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// What it prints where it succeeds: standard output, standard error.
    pub(crate) fn succeed(&self, arguments: &str) -> (String, String) {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {output:?}");
        let text = |octets| String::from_utf8(octets).unwrap();
        (text(output.stdout), text(output.stderr))
    }

    pub(crate) fn json(&self, arguments: &str) -> Value {
        serde_json::from_str(&self.succeed(arguments).0).unwrap()
    }

    /// The one line with which a call fails or is refused, after this exit code.
    pub(crate) fn line_of(&self, code: i32, arguments: &str) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {output:?}");
        assert!(output.stdout.is_empty(), "{output:?}");
        let line = String::from_utf8(output.stderr).unwrap();
        assert_eq!(line.lines().count(), 1, "{line}");
        line
    }

    /// The one line with which a call is refused.
    pub(crate) fn refusal(&self, arguments: &str) -> String {
        self.line_of(2, arguments)
    }
}
