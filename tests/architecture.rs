//! The rules of ARCHITECTURE.md that a program can check.

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::{BTreeMap, BTreeSet};

use crate::common::repository;

/// Dependencies run from right to left only: a crate may depend on crates that stand before it.
const ORDER: &[&str] = &[
    "test-support",
    "frames",
    "messages",
    "observations",
    "csv_table",
    "estimation",
    "telemetry",
    "association",
    "scenario",
    "scoring",
    "fusion",
    "tracking",
    "locating",
    "asterix",
    "outgoing",
    "formats",
    "reception",
    "bus",
    "net",
    "runtime",
    "configuration",
    "adapter",
    "fusion-service",
    "monitor",
    "recorder",
    "gateway",
    "simulator",
    "launcher",
    "bench-service",
    "koseki",
];

/// Services talk through messages only, never to each other.
const SERVICES: &[&str] = &[
    "adapter",
    "fusion-service",
    "monitor",
    "recorder",
    "gateway",
    "simulator",
    "launcher",
    "bench-service",
];

/// Crates that may know the outside world; all others are pure.
const OUTSIDE: &[&str] = &[
    "test-support",
    "bus",
    "net",
    "runtime",
    "configuration",
    "adapter",
    "fusion-service",
    "monitor",
    "recorder",
    "gateway",
    "simulator",
    "launcher",
    "bench-service",
    "koseki",
];

/// Crates that may hold `unsafe`, each use with its reason.
const MAY_BE_UNSAFE: &[&str] = &["bus", "frames", "messages", "net"];

fn workspace() -> Metadata {
    MetadataCommand::new()
        .manifest_path(repository("Cargo.toml"))
        .no_deps()
        .other_options(vec!["--offline".to_owned()])
        .exec()
        .unwrap()
}

fn normal_dependencies(package: &Package) -> BTreeSet<String> {
    let normal = package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind == DependencyKind::Normal);
    normal.map(|dependency| dependency.name.clone()).collect()
}

fn packages(metadata: &Metadata) -> BTreeMap<String, &Package> {
    metadata
        .packages
        .iter()
        .map(|package| (package.name.to_string(), package))
        .collect()
}

/// Every Rust source file of a package, with its text.
fn sources(package: &Package) -> Vec<(String, String)> {
    let mut folders = vec![package.manifest_path.parent().unwrap().join("src").into_std_path_buf()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found
}

#[test]
fn dependencies_run_one_way() {
    let metadata = workspace();
    let packages = packages(&metadata);
    let listed: BTreeSet<&str> = ORDER.iter().copied().collect();
    let present: BTreeSet<&str> = packages.keys().map(String::as_str).collect();
    assert_eq!(present, listed, "a crate is missing from ORDER, or the other way round");
    for (place, name) in ORDER.iter().enumerate() {
        for dependency in normal_dependencies(packages[*name]) {
            if let Some(other) = ORDER.iter().position(|crate_name| *crate_name == dependency) {
                assert!(other < place, "{name} may not depend on {dependency}");
                let both = SERVICES.contains(name) && SERVICES.contains(&dependency.as_str());
                assert!(!both, "services never depend on each other: {name} on {dependency}");
            }
        }
    }
}

#[test]
fn only_the_bus_knows_iceoryx2() {
    let metadata = workspace();
    for (name, package) in packages(&metadata) {
        for dependency in normal_dependencies(package)
            .iter()
            .filter(|dependency| dependency.starts_with("iceoryx2"))
        {
            let trait_crate = name == "messages" && dependency == "iceoryx2-bb-elementary-traits";
            assert!(name == "bus" || trait_crate, "{name} names {dependency}");
        }
    }
}

#[test]
fn pure_crates_have_no_clock_thread_file_or_socket() {
    let metadata = workspace();
    let forbidden = [
        "std::fs",
        "std::net",
        "std::thread",
        "Instant::now",
        "SystemTime",
        "rustix::",
    ];
    for (name, package) in packages(&metadata)
        .into_iter()
        .filter(|(name, _)| !OUTSIDE.contains(&name.as_str()))
    {
        for (path, text) in sources(package) {
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            for word in forbidden {
                assert!(!text.contains(word), "{path} ({name}) uses {word}");
            }
        }
    }
}

#[test]
fn unsafe_code_stays_where_it_may_be() {
    let metadata = workspace();
    for (name, package) in packages(&metadata) {
        let roots = sources(package)
            .into_iter()
            .filter(|(path, _)| path.ends_with("lib.rs") || path.ends_with("main.rs"));
        for (path, text) in roots {
            let forbids = text.contains("#![forbid(unsafe_code)]");
            assert!(
                forbids || MAY_BE_UNSAFE.contains(&name.as_str()),
                "{path} does not forbid unsafe code"
            );
        }
    }
}

#[test]
fn only_the_runtime_reads_clocks() {
    let metadata = workspace();
    for (name, package) in packages(&metadata).into_iter().filter(|(name, _)| name != "runtime") {
        for (path, text) in sources(package) {
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            assert!(
                !text.contains("SystemTime::now") && !text.contains("clock_gettime"),
                "{path} ({name}) reads a clock"
            );
        }
    }
}

#[test]
fn both_commands_stand_in_the_readme() {
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    for command in ["cargo run --release -- demo", "cargo test --workspace"] {
        assert!(readme.contains(command), "{command}");
    }
}
