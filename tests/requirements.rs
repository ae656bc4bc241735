//! Requirements that are named by their ids are defined: each in a sentence in `docs/requirements.md`.

use std::collections::BTreeSet;
use std::fs;

use crate::common::{repository, texts};

const METHODS: [&str; 9] = ["TI", "QF", "HT", "SP", "WA", "EL", "PL", "BF", "FM"];

/// Every id in a text, as method and number.
fn cited(text: &str) -> Vec<(&str, u32)> {
    let is_word = |character: char| character.is_ascii_alphanumeric() || character == '_';
    let mut found = Vec::new();
    for (at, _) in text.match_indices('-') {
        let before = &text[..at];
        let Some(method) = METHODS.into_iter().find(|method| before.ends_with(method)) else {
            continue;
        };
        let starts = !before[..at - method.len()].ends_with(is_word);
        let after = &text[at + 1..];
        let digits = after
            .find(|character: char| !character.is_ascii_digit())
            .unwrap_or(after.len());
        if let (true, Ok(number)) = (starts, after[..digits].parse()) {
            found.push((method, number));
        }
    }
    found
}

#[test]
fn every_requirement_is_defined_once_and_in_order() {
    let text = fs::read_to_string(repository("docs/requirements.md")).unwrap();
    let defined: Vec<(&str, u32)> = text
        .lines()
        .filter_map(|line| line.strip_prefix("- **")?.split_once("**"))
        .filter_map(|(id, sentence)| Some((cited(id).pop()?, sentence)))
        .map(|(id, sentence)| {
            assert!(sentence.len() > 20, "{id:?}:{sentence}");
            id
        })
        .collect();
    for method in METHODS {
        let numbers: Vec<u32> = defined
            .iter()
            .filter(|(of, _)| *of == method)
            .map(|(_, number)| *number)
            .collect();
        assert!(
            numbers.len() >= 5 && numbers.iter().copied().eq(1..=numbers.len() as u32),
            "{method}: {numbers:?}"
        );
    }
    let defined: BTreeSet<(&str, u32)> = defined.into_iter().collect();
    let mut citations = 0;
    for (path, text) in texts(&["rs", "md", "toml"]) {
        for id in cited(&text) {
            assert!(
                defined.contains(&id),
                "{path} names {}-{}, of which docs/requirements.md knows nothing",
                id.0,
                id.1
            );
            citations += 1;
        }
    }
    assert!(citations > 400, "only {citations} citations found");
}
