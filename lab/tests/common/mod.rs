//! Places in which the executables are called: those of the executable's own tests.

#[allow(dead_code, reason = "other tests use more of it")]
#[path = "../../../tests/common/documented.rs"]
pub(crate) mod documented;
#[allow(dead_code, reason = "other tests use more of it")]
#[path = "../../../tests/common/folder.rs"]
mod folder;
#[allow(dead_code, reason = "other tests use more of it")]
#[path = "../../../tests/common/home.rs"]
mod home;
#[allow(dead_code, reason = "other tests use more of it")]
#[path = "../../../tests/common/report.rs"]
mod report;

use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) use folder::Folder;
pub(crate) use home::{Home, Running, until};

/// The executable of Koseki, with this workspace's program, to be called.
///
/// # Panics
/// If it has not been built.
pub(crate) fn koseki() -> Command {
    let given = std::env::var_os("KOSEKI").map(PathBuf::from);
    let built = ["release", "debug"].map(|profile| repository("target").join(profile).join("koseki"));
    let found = given.into_iter().chain(built).find(|path| path.is_file());
    let koseki = found.expect("koseki is not built, and $KOSEKI names none: cargo build --release");
    let mut command = Command::new(koseki.canonicalize().unwrap());
    command.env("KOSEKI_LAB", env!("CARGO_BIN_EXE_koseki-lab"));
    command
}

/// A file or folder of the repository, by its path there.
pub(crate) fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}
