//! The tables against machine-readable definitions of the documents (zoranbosnjak/asterix-specs, JSON), where these are
//! present: width, sign, least significant bit, unit and kind of each element.
//!
//! A wrong sign or scale is invisible to every test of the tables alone: they decode and encode consistently.

use std::collections::BTreeMap;

use asterix::Edition;
use asterix::registry;
use asterix::table::{Category, Content, Item, Layout, Part, Profile, TextCoding};
use serde_json::Value;
use test_support::recordings;

/// Elements that differ from the definition on purpose: category, path, and how.
const KNOWN: &[(u8, &str, &str)] = &[
    (
        10,
        "202/VX",
        "LSB 0.25 m/s: I010/200, positions and CAT020 agree; the definition has 2^-4",
    ),
    (10, "202/VY", "as VX"),
    (
        10,
        "210/AX",
        "LSB 0.25 m/s2: changes of velocity agree; the definition has 2^-4",
    ),
    (10, "210/AY", "as AX"),
    (
        10,
        "500/COVXY",
        "a covariance is in square metres; the definition has metres",
    ),
    (21, "090/PA", "a category from 0 to 9, which the definition has signed"),
    (
        48,
        "090/FL",
        "two's complement as in edition 1.32; the definitions before it state no sign",
    ),
];
/// Folder of the definitions.
const FOLDER: &str = "asterix-specs";
/// Fewest elements that must be compared, and fewest of them that are quantities.
const LEAST: [usize; 2] = [1200, 350];

/// Elements of a table by path: width, and content as text.
type Elements = BTreeMap<String, (u64, String)>;

#[test]
fn every_element_has_the_sign_and_the_scale_of_its_document() {
    let Some(folder) = recordings(FOLDER) else { return };
    let mut files: Vec<_> = std::fs::read_dir(folder.join(FOLDER))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let (mut faults, mut met, mut compared) = (Vec::new(), BTreeMap::new(), [0, 0]);
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let Ok(document) = serde_json::from_str::<Value>(&text) else {
            continue;
        };
        let Some((category, edition)) = category_of(&document) else {
            continue;
        };
        let Some(table) = registry::find(category, edition) else {
            println!("skipped: no table of category {category} edition {edition}");
            continue;
        };
        let (ours, theirs) = (of_table(table), of_document(&document["contents"]["catalogue"]));
        for (path, expected) in &theirs {
            let Some(found) = ours.get(path) else {
                faults.push(format!("{table}: {path} is not in the table"));
                continue;
            };
            compared[0] += 1;
            compared[1] += usize::from(expected.1.contains("LSB"));
            let known = KNOWN.iter().find(|(of, at, _)| (*of, *at) == (category, path));
            if let Some((_, _, reason)) = known {
                *met.entry((category, path.clone(), *reason)).or_insert(0) += usize::from(found != expected);
            } else if found != expected {
                faults.push(format!("{table}: {path} is {found:?}, in the document {expected:?}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for ((category, path, reason), times) in met {
        assert!(times > 0, "I{category:03}/{path} no longer differs: {reason}");
    }
    assert!(compared[0] >= LEAST[0] && compared[1] >= LEAST[1], "{compared:?}");
}

fn category_of(document: &Value) -> Option<(u8, Edition)> {
    let contents = &document["contents"];
    // Definitions of a reserved expansion field have no profile.
    contents.get("uap")?;
    let edition = &contents["edition"];
    let minor = edition["minor"].as_u64()? as u8;
    Some((
        contents["category"].as_u64()? as u8,
        Edition::new(edition["major"].as_u64()? as u8, minor),
    ))
}

fn of_table(table: &Category) -> Elements {
    let mut found = Elements::new();
    let profiles: Vec<_> = match &table.profile {
        Profile::Single(uap) => vec![uap],
        Profile::Depends { cases, .. } => cases.iter().map(|(_, uap)| uap).collect(),
    };
    for item in profiles.into_iter().flat_map(|uap| uap.items.iter().flatten()) {
        layout(item.name, &item.layout, &mut found);
    }
    found
}

fn layout(path: &str, of: &Layout, found: &mut Elements) {
    match of {
        Layout::Element(bits, content) => {
            found.insert(path.to_owned(), (u64::from(*bits), described(content)));
        }
        Layout::Group(inner) => parts(path, inner, found),
        Layout::Extended(all) => all.iter().for_each(|inner| parts(path, inner, found)),
        Layout::Repetitive(inner) | Layout::RepetitiveFx(inner) => layout(path, inner, found),
        Layout::Compound(items) => {
            let inner = items.iter().flatten();
            inner.for_each(|item: &Item| layout(&format!("{path}/{}", item.name), &item.layout, found));
        }
        Layout::Explicit | Layout::RandomSequence => {}
    }
}

fn parts(path: &str, of: &[Part], found: &mut Elements) {
    for part in of {
        match part {
            Part::Element {
                name, bits, content, ..
            } => {
                found.insert(format!("{path}/{name}"), (u64::from(*bits), described(content)));
            }
            Part::Group(name, inner) => parts(&format!("{path}/{name}"), inner, found),
            Part::Spare(_) => {}
        }
    }
}

fn described(content: &Content) -> String {
    match content {
        Content::Raw => "raw".to_owned(),
        Content::Integer { signed } => number(*signed),
        Content::Quantity { signed, lsb, unit } => quantity(*signed, *lsb, unit),
        Content::Text(coding) => match coding {
            TextCoding::Ascii => "StringAscii".to_owned(),
            TextCoding::Icao => "StringICAO".to_owned(),
            TextCoding::Octal => "StringOctal".to_owned(),
        },
        Content::Depends { cases, .. } => {
            let cases = cases
                .iter()
                .map(|(value, content)| format!("{value}: {}", described(content)));
            cases.collect::<Vec<_>>().join("; ")
        }
    }
}

fn number(signed: bool) -> String {
    format!("whole{}", if signed { ", signed" } else { "" })
}

fn quantity(signed: bool, lsb: f64, unit: &str) -> String {
    // Twelve digits: 360/2^16 and 0.0054931640625 are the same.
    format!("LSB {lsb:.11e} {unit}{}", if signed { ", signed" } else { "" })
}

fn of_document(catalogue: &Value) -> Elements {
    let mut found = Elements::new();
    for item in catalogue.as_array().into_iter().flatten() {
        named("", item, &mut found);
    }
    found
}

/// An item, subitem or element with name and rule.
fn named(path: &str, of: &Value, found: &mut Elements) {
    let Some(name) = of["name"].as_str() else { return };
    let path = if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}/{name}")
    };
    variation(&path, &of["rule"]["contents"], found);
}

fn variation(path: &str, of: &Value, found: &mut Elements) {
    let contents = &of["contents"];
    match of["tag"].as_str() {
        Some("Element") => {
            let bits = contents["bitSize"].as_u64().unwrap();
            found.insert(path.to_owned(), (bits, content_of_rule(&contents["rule"])));
        }
        Some("Repetitive") => variation(path, &contents["variation"], found),
        Some("Group" | "Extended") => {
            for part in contents
                .as_array()
                .into_iter()
                .flatten()
                .filter(|part| part["tag"] == "Item")
            {
                named(path, &part["contents"], found);
            }
        }
        Some("Compound") => contents
            .as_array()
            .into_iter()
            .flatten()
            .for_each(|item| named(path, item, found)),
        _ => {}
    }
}

fn content_of_rule(rule: &Value) -> String {
    match rule["tag"].as_str() {
        Some("Dependent") => {
            let cases = rule["contents"]["cases"].as_array().unwrap().iter();
            let cases = cases.map(|case| format!("{}: {}", case[0][0], content(&case[1])));
            cases.collect::<Vec<_>>().join("; ")
        }
        _ => content(&rule["contents"]),
    }
}

fn content(of: &Value) -> String {
    let contents = &of["contents"];
    let signed = contents["signedness"]["tag"] == "Signed";
    match of["tag"].as_str() {
        Some("ContentInteger") => number(signed),
        Some("ContentQuantity") => {
            let unit = contents["unit"].as_str().unwrap();
            quantity(signed, value(&contents["lsb"]), unit)
        }
        Some("ContentString") => contents["tag"].as_str().unwrap().to_owned(),
        _ => "raw".to_owned(),
    }
}

/// Value of an expression: a number, a power, a quotient or a product.
fn value(of: &Value) -> f64 {
    let contents = &of["contents"];
    match of["tag"].as_str() {
        Some("NumInt") => contents.as_f64().unwrap(),
        Some("NumPow") => {
            let [base, exponent] = ["base", "exponent"].map(|name| contents[name].as_f64().unwrap());
            base.powf(exponent)
        }
        Some("NumDiv") => value(&contents["numerator"]) / value(&contents["denominator"]),
        other => panic!("an expression of the kind {other:?}"),
    }
}
