//! `koseki` without `koseki-lab`, and the other way round.

use std::fs;
use std::process::Command;

use crate::common::{Folder, koseki};

#[test]
fn without_the_program_its_commands_name_the_remedy() {
    let folder = Folder::new();
    // A copy in a folder where nothing lies beside it.
    let alone = folder.path("koseki");
    fs::copy(koseki().get_program(), &alone).unwrap();
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
    fs::copy(env!("CARGO_BIN_EXE_koseki-lab"), &alone).unwrap();
    let output = Command::new(&alone)
        .args(["bench", "latency"])
        .env_remove("KOSEKI")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("koseki is neither at $KOSEKI"), "{said}");
}
