//! Crates of the product's workspace that an edit rebuilds, counted from the dependencies that cargo knows.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::Package;

use test_support::assert_golden;

use super::{normal_dependencies, packages, workspace};
use crate::common::repository;

/// Around the table of rebuilds in ARCHITECTURE.md.
const BEGIN: &str = "<!-- rebuilds: made by tests/architecture/rebuilds.rs -->\n\n";
const END: &str = "<!-- end of rebuilds -->";
/// Most crates that a row names; of more it states the number.
const NAMED_MAX: usize = 6;

/// Most crates that an edit in each crate may rebuild besides itself. A greater bound needs a reason in its commit.
const BOUNDS: &[(&str, usize)] = &[
    ("adapter", 1),
    ("alarms", 6),
    ("alerts", 4),
    ("alerts-service", 1),
    ("areas", 7),
    ("association", 16),
    ("asterix", 9),
    ("bench-service", 0),
    ("bus", 15),
    ("command_line", 2),
    ("configuration", 2),
    ("csv_table", 9),
    ("deployment", 17),
    ("display", 1),
    ("estimation", 26),
    ("formats", 6),
    ("frames", 33),
    ("fusion", 3),
    ("fusion-service", 1),
    ("fusion_rules", 6),
    ("fusion_settings", 8),
    ("gateway", 1),
    ("kept", 22),
    ("koseki", 0),
    ("koseki-client", 2),
    ("launcher", 1),
    ("locating", 5),
    ("messages", 40),
    ("monitor", 1),
    ("net", 10),
    ("observations", 14),
    ("observed", 4),
    ("offline", 1),
    ("outgoing", 4),
    ("platform", 10),
    ("reception", 5),
    ("recorder", 1),
    ("recording", 4),
    ("runtime", 13),
    ("sample_text", 2),
    ("scenario", 4),
    ("scoring", 3),
    ("settings", 32),
    ("simulator", 2),
    ("source_models", 4),
    ("sources", 4),
    ("telemetry", 7),
    ("test-support", 0),
    ("tracking", 5),
    ("web", 3),
];

/// Crates that read the file of a deployment; every other crate gets what it needs as data.
const READERS_OF_FILES: [&str; 2] = ["offline", "koseki"];

/// Crates that depend on `name`, directly or through others.
fn dependents(packages: &BTreeMap<String, &Package>, name: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::from([name.to_owned()]);
    loop {
        let depends = |(_, package): &(&String, &&Package)| !normal_dependencies(package).is_disjoint(&found);
        let more: BTreeSet<String> = packages.iter().filter(depends).map(|(name, _)| name.clone()).collect();
        if more.is_subset(&found) {
            break;
        }
        found.extend(more);
    }
    found.remove(name);
    found
}

#[test]
fn an_edit_rebuilds_no_more_crates_than_its_bound() {
    let metadata = workspace();
    let packages = packages(&metadata);
    let bounds: BTreeMap<&str, usize> = BOUNDS.iter().copied().collect();
    for name in packages.keys() {
        let rebuilt = dependents(&packages, name);
        let bound = *bounds
            .get(name.as_str())
            .unwrap_or_else(|| panic!("{name} has no bound"));
        assert!(
            rebuilt.len() <= bound,
            "an edit of {name} rebuilds {} crates, and its bound is {bound}: {rebuilt:?}",
            rebuilt.len()
        );
        assert_eq!(rebuilt.len(), bound, "the bound of {name} is greater than needed");
    }
    assert_eq!(bounds.len(), packages.len(), "a bound is of no crate");
}

#[test]
fn the_table_of_rebuilds_is_that_of_the_workspace() {
    let metadata = workspace();
    let packages = packages(&metadata);
    let mut table = "| an edit in | rebuilds, besides itself |\n| --- | --- |\n".to_owned();
    let mut by_names: BTreeMap<(usize, BTreeSet<String>), Vec<&str>> = BTreeMap::new();
    for name in packages.keys() {
        let rebuilt = dependents(&packages, name);
        by_names.entry((rebuilt.len(), rebuilt)).or_default().push(name);
    }
    for ((count, rebuilt), names) in by_names {
        let quoted = |names: &mut dyn Iterator<Item = &str>| {
            let quoted: Vec<String> = names.map(|name| format!("`{name}`")).collect();
            quoted.join(", ")
        };
        let what = match count {
            0 => "nothing".to_owned(),
            1..=NAMED_MAX => quoted(&mut rebuilt.iter().map(String::as_str)),
            _ => format!("{count} crates"),
        };
        table += &format!("| {} | {what} |\n", quoted(&mut names.into_iter()));
    }
    let path = repository("ARCHITECTURE.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(BEGIN).expect("the table has a begin");
    let (_, after) = rest.split_once(END).expect("the table has an end");
    assert_golden(&path, &format!("{before}{BEGIN}{table}\n{END}{after}"));
}

#[test]
fn only_the_outermost_crates_read_the_file_of_a_deployment() {
    let metadata = workspace();
    let readers: BTreeSet<String> = READERS_OF_FILES.map(str::to_owned).into();
    assert_eq!(dependents(&packages(&metadata), "configuration"), readers);
}
