//! The mechanisms of ARCHITECTURE.md: each stands in its place, and no idea has more of them than its bound.

use std::collections::BTreeMap;

use super::source::sources;
use super::{packages, workspace_and_lab};
use crate::common::repository;

/// Most mechanisms of each idea.
const BOUNDS: &[(&str, usize)] = &[
    ("waits for time", 7),
    ("learns of a source", 1),
    ("outlives a process", 5),
    ("text of a sample", 3),
    ("figures of a deployment", 5),
    ("past of the picture", 2),
];

/// The cells of the table's rows.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(repository("ARCHITECTURE.md")).unwrap();
    let section = text.split("\n## ").find(|section| section.starts_with("Mechanisms"));
    let lines = section.expect("a section Mechanisms").lines();
    let cells = |line: &str| {
        line.trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    lines.filter(|line| line.starts_with('|')).skip(2).map(cells).collect()
}

#[test]
fn each_mechanism_stands_in_its_place_and_no_idea_has_more_than_its_bound() {
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for row in rows() {
        let [idea, mechanism, place, reason] = &row[..] else {
            panic!("{row:?} has not four cells");
        };
        let place = place.trim_matches('`');
        assert!(repository(place).exists(), "{place} ({mechanism}) does not exist");
        assert!(!mechanism.is_empty() && !reason.is_empty(), "{place} has no reason");
        *found.entry(idea.clone()).or_default() += 1;
    }
    let bounds: BTreeMap<String, usize> = BOUNDS.iter().map(|(idea, most)| ((*idea).to_owned(), *most)).collect();
    assert_eq!(found, bounds, "rows of each idea, and their bounds");
}

/// A queue with a time of its own waits for time: it is not to be missed in the table.
#[test]
fn what_waits_by_time_is_in_the_table() {
    let listed: Vec<String> = rows()
        .into_iter()
        .map(|row| row[2].trim_matches('`').to_owned())
        .collect();
    let metadata = workspace_and_lab();
    let mut missing = Vec::new();
    for package in packages(&metadata).values() {
        for source in sources(package) {
            let keeps = ["VecDeque<", "BinaryHeap<"]
                .iter()
                .any(|word| source.text.contains(word));
            let has_time = ["watermark_ns:", "reached_ns:", "window_ns:"]
                .iter()
                .any(|word| source.text.contains(word));
            let place = package.manifest_path.with_file_name("src").join(&source.path);
            if keeps && has_time && !listed.iter().any(|listed| place.as_str().ends_with(listed.as_str())) {
                missing.push(place.to_string());
            }
        }
    }
    assert!(
        missing.is_empty(),
        "not in ARCHITECTURE.md's table of mechanisms: {missing:#?}"
    );
}
