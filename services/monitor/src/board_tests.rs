//! The board for Grafana, against the metrics that exist.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

const BOARD: &str = include_str!("../../../packaging/grafana/koseki.json");
/// What `exposition` writes; its own test keeps it true.
const METRICS: &str = include_str!("../tests/golden/metrics.txt");

/// Labels that Prometheus adds itself.
const OF_PROMETHEUS: [&str; 3] = ["instance", "__name__", "le"];

fn is_of_name(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_'
}

/// Each metric by its name, with the names of its labels.
fn metrics() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut found: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for line in METRICS.lines().filter(|line| !line.starts_with('#')) {
        let name = line.split(['{', ' ']).next().unwrap();
        let labels = line.split('=').map(|part| part.rsplit([',', '{']).next().unwrap());
        let labels = labels.filter(|label| label.chars().all(is_of_name));
        found.entry(name).or_default().extend(labels);
    }
    found
}

/// Every text below a key of this name.
fn texts<'a>(value: &'a Value, key: &str, found: &mut Vec<&'a str>) {
    match value {
        Value::Object(fields) => {
            for (name, inner) in fields {
                found.extend(inner.as_str().filter(|_| name == key));
                texts(inner, key, found);
            }
        }
        Value::Array(values) => values.iter().for_each(|inner| texts(inner, key, found)),
        _ => {}
    }
}

/// Names of metrics in an expression.
fn named(expression: &str) -> Vec<&str> {
    let words = expression.split(|letter| !is_of_name(letter));
    words.filter(|word| word.starts_with("koseki_")).collect()
}

/// Names of labels that an expression compares or groups by.
fn labels(expression: &str) -> Vec<&str> {
    let compared = expression
        .match_indices('=')
        .filter(|(place, _)| expression[*place + 1..].starts_with(['"', '~']) && !expression[..*place].ends_with('='))
        .map(|(place, _)| expression[..place].trim_end_matches('!'))
        .map(|before| before.rsplit(|letter| !is_of_name(letter)).next().unwrap());
    let grouped = expression.split("by (").skip(1);
    let grouped = grouped.flat_map(|rest| rest.split(')').next().unwrap().split(", "));
    compared.chain(grouped).collect()
}

#[test]
fn every_metric_and_label_of_the_board_exists() {
    let metrics = metrics();
    let board: Value = serde_json::from_str(BOARD).unwrap();
    let mut expressions = Vec::new();
    texts(&board, "expr", &mut expressions);
    assert!(expressions.len() > 15, "{}", expressions.len());
    for expression in expressions {
        let names = named(expression);
        assert!(!names.is_empty(), "{expression}");
        for name in names {
            // What a name's beginning ends with an underscore for is a family of counters.
            let meant: Vec<_> = match name.ends_with('_') {
                true => metrics.iter().filter(|(known, _)| known.starts_with(name)).collect(),
                false => metrics.get_key_value(name).into_iter().collect(),
            };
            assert!(!meant.is_empty(), "no metric {name}: {expression}");
            for label in labels(expression) {
                let has = OF_PROMETHEUS.contains(&label) || meant.iter().all(|(_, of)| of.contains(label));
                assert!(has, "{name} has no label {label}: {expression}");
            }
        }
    }
}

#[test]
fn names_and_labels_of_an_expression_are_found() {
    let expression = r#"sum by (le, source) (rate(koseki_a_bucket{stage!="age",x=~"$x"}[5m])) / (koseki_b == 1)"#;
    assert_eq!(named(expression), ["koseki_a_bucket", "koseki_b"]);
    assert_eq!(labels(expression), ["stage", "x", "le", "source"]);
    assert!(metrics()["koseki_alarm"].contains("partner") && !metrics().contains_key("koseki_alarms"));
}
