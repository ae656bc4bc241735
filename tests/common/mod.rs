//! What tests of the executable share: a deployment of their own.

use std::path::Path;
use std::process::Command;

/// A place where a test's deployment lives, apart from every other one's.
pub(crate) struct Deployment {
    folder: tempfile::TempDir,
    name: String,
}

impl Deployment {
    /// A place for a deployment that will run as `name`.
    pub(crate) fn new(name: &str) -> Self {
        // Not `$TMPDIR`: names of sockets must be short.
        let folder = tempfile::Builder::new().prefix("ks").tempdir_in("/tmp").unwrap();
        Self {
            folder,
            name: name.to_owned(),
        }
    }

    /// A folder that is removed with the deployment.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The executable with arguments, to be run in this place.
    pub(crate) fn koseki(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_koseki"));
        command
            .args(arguments)
            .env("XDG_RUNTIME_DIR", self.folder())
            .env_remove("KOSEKI_DATA");
        command
    }

    /// Asserts that the deployment, which has ended, has left neither process nor file.
    pub(crate) fn assert_nothing_left(&self) {
        let root = bus::Root::in_base(self.folder().join("koseki"), &self.name).unwrap();
        let shared = std::fs::read_dir("/dev/shm")
            .unwrap()
            .map(|entry| entry.unwrap().file_name());
        let ours: Vec<_> = shared
            .filter(|name| name.to_string_lossy().starts_with(root.prefix()))
            .collect();
        assert!(ours.is_empty(), "left in shared memory: {ours:?}");
        assert!(!root.path().exists(), "left behind: {}", root.path().display());
    }
}
