//! The rules of ARCHITECTURE.md that a program can check.

mod mechanisms;
mod modules;
pub(crate) mod prose;
mod rebuilds;
mod source;

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{Dependency, DependencyKind, Metadata, MetadataCommand, Package};
use source::sources;

use crate::common::{repository, texts};

/// Dependencies run from right to left only: a crate may depend on crates that stand before it.
const ORDER: &[&str] = &[
    "test-support",
    "settings",
    "frames",
    "messages",
    "deployment",
    "observations",
    "platform",
    "csv_table",
    "sample_text",
    "estimation",
    "kept",
    "telemetry",
    "alarms",
    "observed",
    "areas",
    "association",
    "alerts",
    "scenario",
    "scoring",
    "fusion_settings",
    "fusion_rules",
    "source_models",
    "fusion",
    "tracking",
    "locating",
    "asterix",
    "outgoing",
    "formats",
    "recording",
    "reception",
    "sources",
    "bus",
    "koseki-client",
    "net",
    "web",
    "runtime",
    "command_line",
    "configuration",
    "adapter",
    "fusion-service",
    "alerts-service",
    "monitor",
    "recorder",
    "gateway",
    "display",
    "simulator",
    "launcher",
    "bench-service",
    "torture",
    "offline",
    "koseki",
    "koseki-lab",
];

/// Services talk through messages only, never to each other.
const SERVICES: &[&str] = &[
    "adapter",
    "fusion-service",
    "alerts-service",
    "monitor",
    "recorder",
    "gateway",
    "display",
    "simulator",
    "launcher",
    "bench-service",
];

/// Crates that may know the outside world; all others are pure.
const OUTSIDE: &[&str] = &[
    "test-support",
    "bus",
    "koseki-client",
    "net",
    "web",
    "deployment",
    "runtime",
    "configuration",
    "adapter",
    "fusion-service",
    "alerts-service",
    "monitor",
    "recorder",
    "gateway",
    "display",
    "simulator",
    "launcher",
    "bench-service",
    "torture",
    "offline",
    "koseki",
    "koseki-lab",
];

/// Ways to read a clock.
const CLOCKS: &[&str] = &[
    "Instant::now",
    "SystemTime::now",
    ".elapsed()",
    "clock_gettime",
    "Timestamp::now",
    "Zoned::now",
];

/// Files outside of `runtime` that may read one, and why.
const MAY_READ_CLOCKS: &[(&str, &str, &str)] = &[
    (
        "bus",
        "seal.rs",
        "limits how long a claim waits; `runtime` stands on the bus",
    ),
    (
        "bus",
        "service.rs",
        "limits how long a topic is asked for; `runtime` stands on the bus",
    ),
    (
        "bus",
        "waiter.rs",
        "spins and sleeps for the time asked for; `runtime` stands on the bus",
    ),
    (
        "koseki-client",
        "clock.rs",
        "stamps what programs of others publish; `runtime` is too large for them",
    ),
    (
        "test-support",
        "page.rs",
        "measures whether a server is held up; for tests only",
    ),
];

/// Crates that may hold `unsafe`, each use with its reason.
const MAY_BE_UNSAFE: &[&str] = &["bus", "frames", "messages", "net"];

/// The workspace of the product.
fn workspace() -> Metadata {
    metadata("Cargo.toml")
}

/// The same, with the crates of the lab.
fn workspace_and_lab() -> Metadata {
    let mut both = workspace();
    both.packages.extend(metadata("lab/Cargo.toml").packages);
    both
}

fn metadata(manifest: &str) -> Metadata {
    MetadataCommand::new()
        .manifest_path(repository(manifest))
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
    let name = |dependency: &Dependency| dependency.rename.as_ref().unwrap_or(&dependency.name).clone();
    normal.map(name).collect()
}

/// Packages by their names inside of the workspace: a published one has the name of its library, with a prefix.
fn packages(metadata: &Metadata) -> BTreeMap<String, &Package> {
    let name = |package: &Package| {
        let library = package.targets.iter().find(|target| target.is_lib());
        match library.map(|library| library.name.as_str()) {
            Some(library) if package.name.as_str() == format!("koseki-{library}") => library.to_owned(),
            _ => package.name.to_string(),
        }
    };
    metadata
        .packages
        .iter()
        .map(|package| (name(package), package))
        .collect()
}

#[test]
fn dependencies_run_one_way() {
    let metadata = workspace_and_lab();
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

/// `.cargo/config.toml` has the seed, and cargo hands it to tests.
#[test]
fn property_tests_draw_the_same_cases_in_every_run() {
    let seed = std::env::var("PROPTEST_RNG_SEED").unwrap_or_default();
    assert!(
        seed.parse::<u64>().is_ok(),
        "PROPTEST_RNG_SEED is \"{seed}\": run cargo inside the repository"
    );
}

#[test]
fn only_the_bus_knows_iceoryx2() {
    let metadata = workspace_and_lab();
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
    let metadata = workspace_and_lab();
    let outside = ["std::fs", "std::net", "std::thread", "SystemTime", "rustix::"];
    let forbidden = [CLOCKS, &outside].concat();
    for (name, package) in packages(&metadata)
        .into_iter()
        .filter(|(name, _)| !OUTSIDE.contains(&name.as_str()))
    {
        for source in sources(package) {
            for word in &forbidden {
                assert!(!source.text.contains(word), "{name}: {} uses {word}", source.path);
            }
        }
    }
}

#[test]
fn unsafe_code_stays_where_it_may_be() {
    let metadata = workspace_and_lab();
    for (name, package) in packages(&metadata) {
        for source in sources(package) {
            let is_root = ["lib.rs", "main.rs"].contains(&source.path.as_str());
            let forbids = source.text.contains("#![forbid(unsafe_code)]");
            assert!(
                !is_root || forbids || MAY_BE_UNSAFE.contains(&name.as_str()),
                "{name}: {} does not forbid unsafe code",
                source.path
            );
        }
    }
}

#[test]
fn only_the_runtime_reads_clocks() {
    let metadata = workspace_and_lab();
    let mut allowed: BTreeSet<&(&str, &str, &str)> = BTreeSet::new();
    for (name, package) in packages(&metadata).into_iter().filter(|(name, _)| name != "runtime") {
        for source in sources(package) {
            let Some(word) = CLOCKS.iter().find(|word| source.text.contains(**word)) else {
                continue;
            };
            let place = MAY_READ_CLOCKS
                .iter()
                .find(|(of, path, _)| *of == name && *path == source.path);
            assert!(
                place.is_some(),
                "{name}: {} reads a clock ({word}); `runtime::clock` does that",
                source.path
            );
            allowed.extend(place);
        }
    }
    assert_eq!(
        allowed.len(),
        MAY_READ_CLOCKS.len(),
        "not needed any more: {MAY_READ_CLOCKS:?} without {allowed:?}"
    );
}

/// `doctest = false` saves a second per crate and run. It must not hide an example.
#[test]
fn examples_of_documentation_are_tested() {
    let metadata = workspace();
    for (name, package) in packages(&metadata) {
        let mut targets = package.targets.iter();
        let is_tested = targets.any(|target| target.doctest);
        let has_examples = sources(package).iter().any(|source| has_example(&source.text));
        assert_eq!(is_tested, has_examples, "{name}: `doctest` in its Cargo.toml is wrong");
    }
}

/// Whether a comment of the documentation has a block of Rust code.
fn has_example(text: &str) -> bool {
    let lines = text.lines().map(str::trim_start);
    let lines = lines.filter_map(|line| line.strip_prefix("///").or(line.strip_prefix("//!")));
    // Every second fence closes a block.
    let mut opening = lines
        .filter_map(|line| line.trim_start().strip_prefix("```"))
        .step_by(2);
    opening.any(|language| ["", "rust", "no_run", "should_panic", "compile_fail"].contains(&language.trim()))
}

#[test]
fn an_example_is_found_behind_other_blocks() {
    assert!(has_example(
        "//! ```text\n//! a\n//! ```\n    /// ```no_run\n    /// b\n    /// ```\n"
    ));
    assert!(!has_example("/// ```text\n/// a\n/// ```\nlet a = \"```\";\n"));
}

#[test]
fn modules_do_not_use_each_other_in_circles() {
    let others = ["link", "c", "python"].map(|workspace| metadata(&format!("{workspace}/Cargo.toml")));
    for metadata in [workspace_and_lab()].iter().chain(&others) {
        for (name, package) in packages(metadata) {
            let cycles = modules::cycles(&sources(package));
            assert!(cycles.is_empty(), "{name}: {cycles:?}");
        }
    }
    let cycles = modules::python_cycles(&repository("python/koseki"));
    assert!(cycles.is_empty(), "{cycles:?}");
}

/// What rustfmt does to code; it leaves comments alone.
#[test]
fn comments_and_configurations_keep_to_the_line_width() {
    for (path, text) in texts(&["rs", "toml"]) {
        for (number, line) in (1..).zip(text.lines()) {
            let is_code = path.ends_with(".rs") && !line.trim_start().starts_with("//");
            let width = line.chars().count();
            assert!(is_code || width <= 120, "{path}:{number} has {width} characters");
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
