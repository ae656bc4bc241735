//! Tests that the layouts of other languages equal those compiled by Rust (PL-2).

use std::path::{Path, PathBuf};
use std::process::Command;

use messages::layout::{self, Sample as _};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("layout")
}

fn assert_current(file: &str, expected: &str) {
    let found = std::fs::read_to_string(folder().join(file)).unwrap();
    assert!(
        found == expected,
        "{file} no longer matches the samples; run `cargo run -p koseki-messages --example layouts` and raise SCHEMA_VERSION where only a meaning changes"
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
fn the_codes_of_the_python_package_are_current() {
    let package = "../../../python/koseki/_codes.py";
    if folder().join(package).is_file() {
        assert_current(package, &layout::python_codes());
    } else {
        println!("skipped: the package is not here");
    }
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
fn a_swapped_field_changes_the_fingerprint_of_its_type_alone() {
    let layout = messages::SystemTrack::LAYOUT;
    let mut fields = layout.fields.to_vec();
    let place = |name: &str| layout.fields.iter().position(|field| field.name == name).unwrap();
    let (position, velocity) = (place("position_m"), place("velocity_mps"));
    (fields[position].name, fields[velocity].name) = (fields[velocity].name, fields[position].name);
    let swapped = layout::Layout {
        fields: fields.leak(),
        ..layout
    };
    assert_ne!(swapped.fingerprint(), layout.fingerprint());
    assert_eq!(messages::SystemTrack::SCHEMA, layout.fingerprint());
    assert_ne!(messages::SystemTrack::SCHEMA, messages::SensorTrack::SCHEMA);
}

#[test]
fn every_contained_layout_counts() {
    let contained = |layout: &layout::Layout| -> usize {
        let kinds = layout.fields.iter().map(|field| field.kind);
        kinds
            .filter(|kind| kind.starts_with(char::is_uppercase) || kind.starts_with("[C"))
            .count()
    };
    for layout in layout::ALL {
        let found = layout.contained().count();
        assert_eq!(found, contained(layout), "{}", layout.name);
    }
}

#[test]
fn names_of_fields_are_those_that_ros_2_allows() {
    for field in layout::ALL.iter().flat_map(|layout| layout.fields) {
        let is_allowed = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
        let name = field.name;
        assert!(name.starts_with(|first: char| first.is_ascii_lowercase()), "{name}");
        assert!(
            name.chars().all(is_allowed) && !name.contains("__") && !name.ends_with('_'),
            "{name}"
        );
    }
}

#[test]
fn a_schema_for_ros_2_has_the_fields_and_those_of_contained_samples_once() {
    let schema = messages::Health::LAYOUT.ros2_schema();
    let (own, contained) = schema.split_once(&"=".repeat(80)).unwrap();
    assert_eq!(own.lines().count(), messages::Health::LAYOUT.fields.len());
    assert!(
        own.contains("\nuint64 incarnation # ") || own.starts_with("uint64 incarnation # "),
        "{own}"
    );
    assert_eq!(
        contained.matches("MSG: koseki/Counters\nuint64[160] values # ").count(),
        1,
        "{contained}"
    );
    let track = messages::SystemTrack::LAYOUT.ros2_schema();
    assert_eq!(track.matches("MSG: koseki/Contribution\n").count(), 1, "{track}");
}

#[test]
fn a_sample_is_its_bytes() {
    let cue = messages::Cue {
        sequence: 7,
        ..messages::Cue::default()
    };
    let octets = messages::Cue::octets(std::slice::from_ref(&cue));
    assert_eq!(octets.len(), messages::Cue::LAYOUT.size);
    assert_eq!(messages::Cue::of_octets(octets), Some(cue));
    assert_eq!(messages::Cue::of_octets(&octets[1..]), None);
}
