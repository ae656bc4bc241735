use frames::{Geodetic, SystemFrame};
use messages::layout::ALL;
use messages::{SensorTrack, SystemTrack};
use test_support::Random;

use super::*;
use crate::{LineFormat, LineWriter, SampleNames, json_schema};

fn sources() -> Vec<String> {
    ["north", "south", "west"].map(str::to_owned).to_vec()
}

fn names() -> SampleNames {
    SampleNames::new(
        sources(),
        SystemFrame::at(Geodetic::from_degrees(45.0, 9.0, 0.0).unwrap()),
    )
}

/// A whole number below `end`.
fn below(end: u64, random: &mut Random) -> u64 {
    (random.unit() * end as f64) as u64
}

fn some_identity(random: &mut Random) -> Identity {
    let mut identity = Identity::default();
    identity = match below(3, random) {
        0 => identity,
        1 => identity.with_address(below(1 << 24, random) as u32),
        _ => identity.with_mmsi(below(1_000_000_000, random) as u32),
    };
    if below(2, random) == 1 {
        identity = identity.with_mode_3a(below(1 << 12, random) as u16);
    }
    if below(2, random) == 1 {
        identity = identity.with_callsign(*b"KOS \"1  ");
    }
    if below(2, random) == 1 {
        identity = identity.with_name("QUEEN, MARY 2");
    }
    identity
}

/// Fills a sample with values that its fields can have.
fn fill(layout: &Layout, octets: &mut [u8], groups: &[CodeGroup], random: &mut Random) {
    if layout.name == Identity::LAYOUT.name {
        octets.copy_from_slice(Identity::octets(&[some_identity(random)]));
        return;
    }
    for field in fields(layout) {
        let octets = &mut octets[field.offset..field.offset + field.size];
        let (kind, count) = field.element();
        if (kind, count.is_some()) == ("u8", true) {
            octets.fill(b' ');
            octets[0] = b'A' + below(26, random) as u8;
            continue;
        }
        for one in octets.chunks_mut(field.size / count.unwrap_or(1)) {
            let bits = match field.codes(groups) {
                _ if SOURCES.contains(&field.name) => [0, 1, 2, u64::from(NO_SOURCE)][below(4, random) as usize],
                Some(group) if group.is_flags => {
                    let chosen = group.constants.iter().filter(|_| below(2, random) == 1);
                    chosen.fold(0, |bits, constant| bits | constant.value)
                }
                Some(group) => group.constants[below(group.constants.len() as u64, random) as usize].value,
                None => below(1 << 53, random).wrapping_mul(0x9e37_79b9_7f4a_7c15),
            };
            match (layout_of(kind), kind) {
                (Some(inner), _) => fill(inner, one, groups, random),
                (_, "f64") if bits % 5 == 0 => one.copy_from_slice(&f64::NAN.to_le_bytes()),
                // With so few digits a number is read exactly.
                (_, "f64") => {
                    let sixty_fourths = ((random.unit() - 0.5) * 1e8).round();
                    one.copy_from_slice(&(sixty_fourths / 64.0).to_le_bytes());
                }
                (_, "f32") if bits % 5 == 0 => one.copy_from_slice(&f32::NAN.to_le_bytes()),
                (_, "f32") => one.copy_from_slice(&((random.unit() - 0.5) as f32 * 1e3).to_le_bytes()),
                _ => one.copy_from_slice(&bits.to_le_bytes()[..one.len()]),
            }
        }
    }
}

fn line(layout: &'static Layout, sample: &[u8], names: Option<SampleNames>) -> Map<String, Value> {
    let mut text = Vec::new();
    LineWriter::new(layout, LineFormat::Json, names).write(sample, &mut text);
    serde_json::from_slice(&text).unwrap()
}

#[test]
fn every_field_of_every_sample_is_read_as_it_was_written() {
    let (groups, mut random) = (code_groups(), Random::new(17));
    for layout in ALL {
        let reader = LineReader::new(layout, sources());
        for _ in 0..40 {
            let mut sample = vec![0; layout.size];
            fill(layout, &mut sample, &groups, &mut random);
            for names in [None, Some(names())] {
                let shown = match &names {
                    Some(_) => LineWriter::new(layout, LineFormat::Json, names.clone()).without_unknown(&sample),
                    None => sample.clone(),
                };
                let line = line(layout, &sample, names);
                let mut found = vec![0; layout.size];
                reader
                    .read(&line, &mut found)
                    .unwrap_or_else(|fault| panic!("{}: {fault}", layout.name));
                let first = (0..layout.size).find(|place| found[*place] != shown[*place]);
                assert_eq!(
                    first.map(|place| layout.name_at(place)),
                    None,
                    "{}: {line:?}",
                    layout.name
                );
            }
        }
    }
}

#[test]
fn any_number_is_read_to_fifteen_digits() {
    let (reader, mut random) = (LineReader::new(&SensorTrack::LAYOUT, sources()), Random::new(5));
    for _ in 0..2000 {
        let stated = SensorTrack {
            trace_m2: (random.unit() - 0.5) * 10f64.powi(below(40, &mut random) as i32 - 20),
            ..SensorTrack::default()
        };
        let mut found = SensorTrack::octets(&[SensorTrack::default()]).to_vec();
        let line = line(&SensorTrack::LAYOUT, SensorTrack::octets(&[stated]), None);
        reader.read(&line, &mut found).unwrap();
        let found = SensorTrack::of_octets(&found).unwrap().trace_m2;
        let apart = (found - stated.trace_m2).abs();
        assert!(apart <= 1e-15 * found.abs(), "{found} {}", stated.trace_m2);
    }
}

#[test]
fn wrong_lines_are_refused_by_field() {
    let read = |text: &str| {
        let mut sample = SensorTrack::octets(&[SensorTrack::default()]).to_vec();
        let line: Map<String, Value> = serde_json::from_str(text).unwrap();
        LineReader::new(&SensorTrack::LAYOUT, sources()).read(&line, &mut sample)
    };
    for (text, field, expected) in [
        (r#"{"speed": 3}"#, "speed", "is no field of a SensorTrack"),
        (
            r#"{"identity": {"address": 8863583}}"#,
            "address",
            "write it as in \"3C6589\"",
        ),
        (r#"{"identity": {"mode_3a": 1216}}"#, "mode_3a", "octal digits, as text"),
        (r#"{"identity": {"mode_3a": "1218"}}"#, "mode_3a", "octal"),
        (r#"{"identity": {"mmsi": 227000000}}"#, "mmsi", "as text"),
        (
            r#"{"identity": {"address": "3C6589", "mmsi": "227000000"}}"#,
            "mmsi",
            "must not stand beside an address",
        ),
        (r#"{"state": "new"}"#, "state", "tentative, confirmed"),
        (r#"{"valid": ["HEIGHT", "WIDTH"]}"#, "valid", "HEIGHT, VELOCITY"),
        (r#"{"track_number": -1}"#, "track_number", "is no value"),
        (r#"{"position_m": [1, 2, 3, 4]}"#, "position_m", "up to 3 values"),
        (r#"{"position_m": ["1", 2, 3]}"#, "position_m", "quotation marks"),
        (r#"{"covariance": 5}"#, "covariance", "must be an object"),
    ] {
        let fault = read(text).unwrap_err();
        assert_eq!(fault.field, field, "{text}");
        assert!(fault.to_string().contains(expected), "{text}: {fault}");
    }
    assert_eq!(read(r#"{"latitude": 41.0, "identity": {"address": null}}"#), Ok(()));
}

/// Visits all properties of a schema, by name.
fn properties(schema: &Value, visit: &mut dyn FnMut(&str, &Value)) {
    match schema {
        Value::Object(members) => {
            if let Some(Value::Object(own)) = members.get("properties") {
                own.iter().for_each(|(name, property)| visit(name, property));
            }
            members.values().for_each(|member| properties(member, visit));
        }
        Value::Array(items) => items.iter().for_each(|item| properties(item, visit)),
        _ => {}
    }
}

#[test]
fn no_key_of_an_identity_has_two_meanings() {
    for layout in ALL {
        let mut found = 0;
        for is_named in [false, true] {
            let schema = json_schema(layout, is_named);
            properties(&schema, &mut |name, property| {
                let Some(text) = IdentityText::ALL.iter().find(|text| text.key == name) else {
                    // What holds such a number has such a key.
                    let about = property["description"].as_str().unwrap_or_default();
                    let is_number = ["MMSI", "24-bit", "Mode 3/A code"]
                        .iter()
                        .any(|word| about.contains(word));
                    assert!(
                        !is_number || name == "alerts" || name == "kind",
                        "{}.{name}: {about}",
                        layout.name
                    );
                    return;
                };
                assert_eq!(
                    property["type"],
                    serde_json::json!(["string", "null"]),
                    "{}.{name}",
                    layout.name
                );
                assert_eq!(property["pattern"], text.pattern, "{}.{name}", layout.name);
                found += 1;
            });
        }
        let has_identity = |layout: &Layout| layout.fields.iter().any(|field| field.kind == "Identity");
        let expected = if has_identity(layout) || layout.name == "Identity" {
            6
        } else {
            0
        };
        assert_eq!(found, expected, "{}", layout.name);
    }
}

#[test]
fn json_and_csv_write_one_spelling_with_words_and_without() {
    let identities = [
        (
            Identity::default().with_address(0x87_3f5f).with_mode_3a(0o2300),
            ["873F5F", "", "2300"],
        ),
        (
            Identity::default().with_address(0xabc).with_mode_3a(0o21),
            ["000ABC", "", "0021"],
        ),
        (Identity::default().with_mmsi(2_275_400), ["", "002275400", ""]),
        (Identity::default(), [""; 3]),
    ];
    for (identity, expected) in identities {
        let track = SystemTrack {
            identity,
            ..SystemTrack::default()
        };
        for names in [None, Some(names())] {
            let json = line(&SystemTrack::LAYOUT, SystemTrack::octets(&[track]), names.clone());
            let lines = LineWriter::new(&SystemTrack::LAYOUT, LineFormat::Csv, names);
            let mut table = lines.head();
            lines.write(SystemTrack::octets(&[track]), &mut table);
            let mut reader = csv::Reader::from_reader(&table[..]);
            let head = reader.headers().unwrap().clone();
            let row = reader.records().next().unwrap().unwrap();
            for (text, expected) in IdentityText::ALL.iter().zip(expected) {
                let value = Some(expected).filter(|text| !text.is_empty());
                assert_eq!(json["identity"][text.key].as_str(), value);
                let column = head
                    .iter()
                    .position(|column| column == format!("identity.{}", text.key));
                assert_eq!(&row[column.unwrap()], expected);
            }
        }
    }
}
