//! Crates of the product's workspace that an edit rebuilds, counted from the dependencies that cargo knows.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::Package;

use super::{normal_dependencies, packages, source, workspace};

/// Crates with algorithms, and the most crates that an edit in each may rebuild besides itself.
const ALGORITHMS: [(&str, usize); 3] = [("fusion", 5), ("tracking", 5), ("locating", 5)];

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

/// Lines of product code in these crates.
fn lines(packages: &BTreeMap<String, &Package>, names: &BTreeSet<String>) -> usize {
    let of_crate = |name: &String| source::sources(packages[name]);
    let texts = names.iter().flat_map(of_crate);
    texts.map(|source| source.text.lines().count()).sum()
}

#[test]
fn an_edit_of_an_algorithm_rebuilds_few_crates() {
    let metadata = workspace();
    let packages = packages(&metadata);
    for (name, most) in ALGORITHMS {
        let rebuilt = dependents(&packages, name);
        let count = rebuilt.len();
        println!(
            "{name}: {count} crates, {} lines: {rebuilt:?}",
            lines(&packages, &rebuilt)
        );
        assert!(count <= most, "an edit of {name} rebuilds {count} crates: {rebuilt:?}");
    }
}

#[test]
fn only_the_outermost_crates_read_the_file_of_a_deployment() {
    let metadata = workspace();
    let readers: BTreeSet<String> = READERS_OF_FILES.map(str::to_owned).into();
    assert_eq!(dependents(&packages(&metadata), "configuration"), readers);
}
