//! Rules that every registered table must keep, and the registry itself.

use std::collections::HashSet;

use asterix::table::{Content, Item, Layout, Part, TextCoding};
use asterix::{Edition, registry};

use crate::values::profiles;

#[test]
fn item_names_are_unique_in_a_profile() {
    for table in registry::REGISTRY {
        for uap in profiles(table) {
            let names: Vec<_> = uap.names().filter(|name| !name.is_empty()).collect();
            let distinct: HashSet<_> = names.iter().collect();
            assert_eq!(distinct.len(), names.len(), "{table}: an item twice in a profile");
        }
    }
}

#[test]
fn elements_are_named_once_and_depend_on_elements_before_them() {
    for table in registry::REGISTRY {
        let items = profiles(table).into_iter().flat_map(|uap| uap.items).flatten();
        items.for_each(|item| check_item(&table.to_string(), item));
    }
    for expansion in registry::EXPANSIONS {
        let place = format!("CAT{:03}/RE ed {}", expansion.number, expansion.edition);
        let items = || expansion.items.iter().flatten();
        let names: HashSet<_> = items().map(|item| item.name).collect();
        assert_eq!(names.len(), items().count(), "{place}: an item twice");
        items().for_each(|item| check_item(&place, item));
    }
}

fn check_item(table: &str, item: &Item) {
    assert!(
        !item.name.is_empty() && !item.title.is_empty(),
        "{table}: an item without name"
    );
    check_layout(table, item.name, &item.layout);
}

fn check_layout(table: &str, item: &str, layout: &Layout) {
    let place = format!("{table} item {item}");
    match layout {
        Layout::Element(bits, content) => check_content(&place, *bits, content, &[]),
        Layout::Group(parts) => check_parts(&place, parts, &mut vec![]),
        Layout::Extended(extension) => {
            assert!(!extension.is_empty(), "{place}: no part");
            let mut before = vec![];
            extension
                .iter()
                .for_each(|parts| check_parts(&place, parts, &mut before));
        }
        Layout::Repetitive(inner) | Layout::RepetitiveFx(inner) => check_layout(table, item, inner),
        Layout::Explicit | Layout::RandomSequence => {}
        Layout::Compound(subitems) => {
            let mut names = HashSet::new();
            for subitem in subitems.iter().flatten() {
                assert!(names.insert(subitem.name), "{place}: {} twice", subitem.name);
                check_item(table, subitem);
            }
            assert!(subitems.last().is_some_and(Option::is_some), "{place}: ends in nothing");
        }
    }
}

fn check_parts(place: &str, parts: &[Part], before: &mut Vec<&'static str>) {
    for part in parts {
        match part {
            Part::Spare(bits) => assert!(*bits > 0, "{place}: no spare bits"),
            Part::Element {
                name, bits, content, ..
            } => {
                assert!(!before.contains(name), "{place}: {name} twice");
                check_content(&format!("{place} {name}"), *bits, content, before);
                before.push(name);
            }
            Part::Group(name, inner) => {
                assert!(!before.contains(name), "{place}: {name} twice");
                check_parts(&format!("{place} {name}"), inner, &mut vec![]);
                before.push(name);
            }
        }
    }
}

fn check_content(place: &str, bits: u8, content: &Content, before: &[&str]) {
    assert!((1..=64).contains(&bits), "{place}: {bits} bits");
    match content {
        Content::Raw | Content::Integer { .. } => {}
        Content::Quantity { lsb, .. } => {
            assert!(lsb.is_finite() && *lsb > 0.0, "{place}: an LSB of {lsb}");
        }
        Content::Text(coding) => {
            let width = match coding {
                TextCoding::Ascii => 8,
                TextCoding::Icao => 6,
                TextCoding::Octal => 3,
            };
            assert_eq!(bits % width, 0, "{place}: not whole characters");
        }
        Content::Depends { on, cases, otherwise } => {
            assert!(before.contains(on), "{place}: depends on {on}, which is not before it");
            let values: HashSet<_> = cases.iter().map(|(value, _)| value).collect();
            assert_eq!(values.len(), cases.len(), "{place}: a case twice");
            for content in cases.iter().map(|(_, content)| content).chain([*otherwise]) {
                check_content(place, bits, content, before);
            }
        }
    }
}

#[test]
fn the_registry_finds_editions_and_defaults() {
    let mut seen = HashSet::new();
    for table in registry::REGISTRY {
        assert!(seen.insert((table.number, table.edition)), "{table} twice");
        let found = registry::find(table.number, table.edition).expect("a registered table");
        assert!(std::ptr::eq(found, *table));
        assert!(registry::default_edition(table.number).is_some());
    }
    assert!(registry::find(21, Edition::new(0, 23)).is_some());
    assert!(registry::find(21, Edition::new(0, 99)).is_none());
    assert!(registry::default_edition(0).is_none());
    let numbers: Vec<_> = registry::defaults().map(|table| table.number).collect();
    let distinct: HashSet<_> = numbers.iter().collect();
    assert_eq!(distinct.len(), numbers.len(), "two defaults for a category");
}

#[test]
fn categories_without_a_table_have_names_by_number() {
    assert_eq!(registry::name_without_table(240), Some("radar video"));
    assert_eq!([48, 0].map(registry::name_without_table), [None; 2]);
    let numbers = registry::WITHOUT_TABLE.iter().map(|(number, _)| number);
    assert!(numbers.is_sorted_by(|a, b| a < b));
}

#[test]
fn editions_that_only_add_have_the_same_field_reference_numbers() {
    for table in registry::REGISTRY {
        let from_one_on = registry::editions(table.number).filter(|other| other.edition.major > 0);
        for other in from_one_on.filter(|other| other.edition.major == table.edition.major) {
            for (uap, first) in profiles(table).into_iter().zip(profiles(other)) {
                assert!(uap.names().eq(first.names()), "{table}");
            }
        }
    }
}

#[test]
fn the_registry_finds_expansions() {
    for expansion in registry::EXPANSIONS {
        let found = registry::find_expansion(expansion.number, expansion.edition).expect("a registered expansion");
        assert!(std::ptr::eq(found, *expansion), "{} twice", expansion.edition);
        assert!(registry::default_edition(expansion.number).is_some());
    }
    assert!(registry::find_expansion(48, Edition::new(9, 9)).is_none());
}

#[test]
fn editions_are_read_and_shown_alike() {
    for table in registry::REGISTRY {
        assert_eq!(table.edition.to_string().parse(), Ok(table.edition));
    }
    assert!(Edition::new(0, 9) < Edition::new(0, 23));
    let error = "2".parse::<Edition>().unwrap_err();
    assert_eq!(
        error.to_string(),
        r#""2" is no edition; write an edition as in 1.9 or 0.23"#
    );
}
