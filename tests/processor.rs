//! The second program, with instructions of newer processors, and the choice between both.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;

use crate::common::Folder;

/// A folder with the executable as `name`, and beside it a script, which may be executable, as the second program.
fn beside(name: &str, mode: u32) -> Folder {
    let folder = Folder::new();
    let executable = env!("CARGO_BIN_EXE_koseki");
    let place = folder.path(name);
    fs::hard_link(executable, &place)
        .or_else(|_| fs::copy(executable, &place).map(|_| ()))
        .unwrap();
    let faster = folder.path("koseki-x86-64-v3");
    fs::write(&faster, "#!/bin/sh\necho \"faster: $*\"\n").unwrap();
    fs::set_permissions(&faster, fs::Permissions::from_mode(mode)).unwrap();
    folder
}

fn output(folder: &Folder, name: &str, variable: Option<&str>) -> String {
    let mut command = Command::new(folder.path(name));
    command
        .args(["--version", "a b"])
        .envs(variable.map(|name| (name, "1")));
    String::from_utf8(command.output().unwrap().stdout).unwrap()
}

#[test]
#[cfg(target_arch = "x86_64")]
fn a_newer_processor_gets_the_second_program_unless_it_is_refused() {
    let is_newer = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi2");
    if !is_newer {
        println!("skipped: the processor has no AVX2");
        return;
    }
    let folder = beside("koseki", 0o755);
    assert_eq!(output(&folder, "koseki", None), "faster: --version a b\n");
    assert!(output(&folder, "koseki", Some("KOSEKI_ANY_PROCESSOR")).starts_with("koseki 0."));
}

#[test]
fn without_a_second_program_that_runs_the_first_one_serves() {
    let folder = beside("koseki", 0o644);
    assert!(output(&folder, "koseki", None).starts_with("koseki 0."));
    let folder = beside("renamed", 0o755);
    assert!(output(&folder, "renamed", None).contains("0."));
}
