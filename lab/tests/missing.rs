//! `koseki` without `koseki-lab`, and the other way round.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use crate::common::{Folder, koseki};

/// Copies a program by another process: were the copy written here, a process that another test starts meanwhile would
/// hold it open for writing, and the system starts no such program.
fn copy(program: impl AsRef<OsStr>, to: &Path) {
    assert!(Command::new("cp").arg(program).arg(to).status().unwrap().success());
}

#[test]
fn without_the_program_its_commands_name_the_remedy() {
    let folder = Folder::new();
    // A copy in a folder where nothing lies beside it.
    let alone = folder.path("koseki");
    copy(koseki().get_program(), &alone);
    for command in ["bench", "torture"] {
        let output = Command::new(&alone)
            .args([command, "--help"])
            .env_remove("KOSEKI_LAB")
            .env("PATH", "/nowhere")
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{said}");
        let words = ["koseki-lab is not at $KOSEKI_LAB", "--manifest-path lab/Cargo.toml"];
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
}

#[test]
fn without_koseki_the_program_measures_nothing() {
    let folder = Folder::new();
    let alone = folder.path("koseki-lab");
    copy(env!("CARGO_BIN_EXE_koseki-lab"), &alone);
    let output = Command::new(&alone)
        .args(["bench", "latency"])
        .env_remove("KOSEKI")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("koseki is neither at $KOSEKI"), "{said}");
}
