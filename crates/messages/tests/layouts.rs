//! The layouts that other languages see are those that Rust compiled (PL-2).

use std::path::{Path, PathBuf};
use std::process::Command;

use messages::layout;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("layout")
}

fn assert_current(file: &str, expected: &str) {
    let found = std::fs::read_to_string(folder().join(file)).unwrap();
    assert!(
        found == expected,
        "{file} no longer matches the samples; run `cargo run -p messages --example layouts` and raise SCHEMA_VERSION"
    );
}

#[test]
fn the_c_header_is_current() {
    assert_current("koseki_messages.h", &layout::c_header());
}

#[test]
fn the_python_module_is_current() {
    assert_current("koseki_messages.py", &layout::python_module());
}

#[test]
fn a_c_compiler_agrees_with_every_offset() {
    let scratch = tempfile::tempdir().unwrap();
    let source = scratch.path().join("check.c");
    std::fs::write(
        &source,
        "#include \"koseki_messages.h\"\nint main(void) { return 0; }\n",
    )
    .unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let result = Command::new(&compiler)
        .args(["-std=c11", "-Wall", "-Werror", "-fsyntax-only", "-I"])
        .arg(folder())
        .arg(&source)
        .output()
        .unwrap_or_else(|error| panic!("the C compiler {compiler}: {error}"));
    assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
}

#[test]
fn python_agrees_with_every_offset() {
    let result = Command::new("python3")
        .arg(folder().join("koseki_messages.py"))
        .output();
    let Ok(result) = result else {
        println!("skipped: no python3 on this machine");
        return;
    };
    assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
}

#[test]
fn a_swapped_field_changes_the_fingerprint() {
    // The hash covers names and offsets, so it is not the sum of its parts: any two layouts differ in it.
    let mut names: Vec<_> = layout::ALL.iter().map(|layout| layout.name).collect();
    names.dedup();
    assert_eq!(names.len(), layout::ALL.len());
    assert_ne!(layout::fingerprint(), 0);
}
