//! Each error of the encoder, with its whole message: where, what, and the limits.

use asterix::encode_error::{EncodeFault, RecordPlace};
use asterix::named::UNKNOWN_EXTENSION;
use asterix::{EncodeError, NamedRecord, Value};

use crate::sample::{PLOT_OR_TRACK, SAMPLE, encode_item};

fn refused(name: &'static str, value: Value, expected: &str) {
    assert_eq!(encode_item(name, value).unwrap_err().to_string(), expected);
}

fn refused_record(record: NamedRecord, expected: &str) {
    let table = if record.category == 251 {
        &PLOT_OR_TRACK
    } else {
        &SAMPLE
    };
    let mut octets = vec![1, 2, 3];
    assert_eq!(record.encode(table, &mut octets).unwrap_err().to_string(), expected);
    assert_eq!(octets, [1, 2, 3], "nothing is left of what was begun");
}

fn list(numbers: &[u64]) -> Value {
    Value::list(numbers.iter().map(|&number| number.into()))
}

#[test]
fn an_error_has_its_place_and_its_fault() {
    let value = Value::group([("U", 16u64.into()), ("S", 0i64.into())]);
    let expected = EncodeError {
        place: RecordPlace {
            category: 250,
            path: vec!["040".to_owned(), "U".to_owned()],
        },
        fault: EncodeFault::NumberOutOfRange {
            value: 16,
            least: 0,
            greatest: 15,
        },
    };
    assert_eq!(encode_item("040", value), Err(expected));
}

#[test]
fn a_record_is_of_its_tables_category_and_has_an_item() {
    let record = NamedRecord::of(48, [("020", 1.0.into())]);
    refused_record(record, "category 250: the record is of category 048");
    refused_record(NamedRecord::of(250, []), "category 250: the record has no item");
}

#[test]
fn items_are_those_of_the_profile_once_each() {
    let items = |names: &[&'static str]| NamedRecord::of(250, names.iter().map(|name| (*name, 1.0.into())));
    refused_record(
        items(&["020", "025"]),
        "I250/025: the edition defines nothing of this name here",
    );
    refused_record(
        items(&["020", ""]),
        "I250/: the edition defines nothing of this name here",
    );
    refused_record(items(&["020", "030", "020"]), "I250/020: is given twice");
    let plot = NamedRecord::of(
        251,
        [("020", Value::group([("TYP", 0u64.into())])), ("161", 5u64.into())],
    );
    refused_record(plot, "I251/161: the edition defines nothing of this name here");
}

#[test]
fn a_profile_is_decided_by_a_value_that_is_there() {
    let record = NamedRecord::of(251, [("040", 9.0.into())]);
    refused_record(record, "category 251: 020 TYP decides the profile, but is absent");
    let record = NamedRecord::of(251, [("020", Value::group([("TYP", 3u64.into())]))]);
    refused_record(
        record,
        "category 251: 020 TYP decides the profile, its value 3 has none",
    );
}

#[test]
fn a_group_is_whole() {
    let group = |names: &[&'static str]| Value::group(names.iter().map(|name| (*name, 0u64.into())));
    let missing = "is missing, but its group is always sent completely";
    refused("010", group(&["F", "LOW"]), &format!("I250/010 HIGH: {missing}"));
    refused("010", group(&[]), &format!("I250/010 F: {missing}"));
    refused("010", group(&["F", "HIGH", "F"]), "I250/010 F: is given twice");
    let unknown = "the edition defines nothing of this name here";
    refused("010", group(&["F", "HIGH", "LAW"]), &format!("I250/010 LAW: {unknown}"));
    refused(
        "010",
        group(&["F", "HIGH", "LOW", UNKNOWN_EXTENSION]),
        &format!("I250/010 {UNKNOWN_EXTENSION}: {unknown}"),
    );
    let value = Value::group([("A", 0u64.into()), ("B", group(&["EP"]))]);
    refused("120", value, &format!("I250/120 B VAL: {missing}"));
}

#[test]
fn parts_of_an_extended_item_are_whole_and_follow_one_another() {
    let a = ("A", Value::from(5u64));
    let b = ("B", Value::from(-2.0));
    let c = ("C", Value::from(1u64));
    let beyond = (UNKNOWN_EXTENSION, Value::Bytes(vec![0x42]));
    let missing = |name: &str| format!("I250/060 {name}: is missing, but its group is always sent completely");
    refused("060", Value::group([]), &missing("A"));
    refused("060", Value::group([b.clone()]), &missing("A"));
    refused("060", Value::group([a.clone(), c.clone()]), &missing("B"));
    refused(
        "060",
        Value::group([a.clone(), b.clone(), beyond.clone()]),
        &missing("C"),
    );
    refused(
        "060",
        Value::group([a.clone(), a.clone()]),
        "I250/060 A: is given twice",
    );
    refused(
        "060",
        Value::group([a, b, c, beyond.clone(), beyond]),
        &format!("I250/060 {UNKNOWN_EXTENSION}: is given twice"),
    );
}

#[test]
fn octets_beyond_the_last_part_end_where_a_reader_ends() {
    let refused = |octets: &[u8], shown: &str| {
        let value = Value::group([
            ("A", 5u64.into()),
            ("B", (-2.0).into()),
            ("C", 1u64.into()),
            (UNKNOWN_EXTENSION, Value::Bytes(octets.to_vec())),
        ]);
        let expected = format!(
            "I250/060 {UNKNOWN_EXTENSION}: {shown} can not follow the last defined part: \
             1 to 4 octets, the FX bit set in all but the last"
        );
        refused("060", value, &expected);
    };
    refused(&[], "[]");
    refused(&[0x41], "[41]");
    refused(&[0x40, 0x40], "[40, 40]");
    refused(&[1, 1, 1, 1, 0], "[01, 01, 01, 01, 00]");
}

#[test]
fn a_value_is_of_the_kind_that_the_table_says() {
    let kinds = [
        ("010", "a group"),
        ("020", "a quantity"),
        ("060", "a group"),
        ("070", "a list"),
        ("080", "a list"),
        ("100", "a group"),
        ("RE", "octets"),
    ];
    for (name, expected) in kinds {
        refused(
            name,
            "x".into(),
            &format!("I250/{name}: takes {expected}, found a text"),
        );
    }
    let group = |u: Value, s: Value| Value::group([("U", u), ("S", s)]);
    refused(
        "040",
        group(1.5.into(), 1i64.into()),
        "I250/040 U: takes a number without sign, found a quantity",
    );
    refused(
        "040",
        group(1u64.into(), 1u64.into()),
        "I250/040 S: takes a number with sign, found a number without sign",
    );
    let texts = Value::group([("A", (-1i64).into()), ("I", "".into()), ("O", "0000".into())]);
    refused("050", texts, "I250/050 A: takes a text, found a number with sign");
    refused("020", list(&[]), "I250/020: takes a quantity, found a list");
    refused("020", Value::group([]), "I250/020: takes a quantity, found a group");
    refused("020", Value::Bytes(vec![]), "I250/020: takes a quantity, found octets");
    let other = Value::group([("IM", 1u64.into()), ("SPEED", 1u64.into())]);
    refused(
        "110",
        other,
        "I250/110 SPEED: takes a quantity, found a number without sign",
    );
}

#[test]
fn numbers_and_quantities_fit_their_bits() {
    let group = |u: u64, s: i64| Value::group([("U", u.into()), ("S", s.into())]);
    refused(
        "040",
        group(16, 0),
        "I250/040 U: 16 is out of range, the least is 0, the greatest 15",
    );
    for s in [-9, 8] {
        refused(
            "040",
            group(0, s),
            &format!("I250/040 S: {s} is out of range, the least is -8, the greatest 7"),
        );
    }
    let quantity = |name, value: f64, expected: &str| {
        let expected = format!("I250/{name}: {value} is out of range, {expected} (all in m)");
        refused(name, value.into(), &expected);
    };
    quantity("020", 32_768.0, "the least is 0, the greatest 32767.5");
    quantity("020", -0.3, "the least is 0, the greatest 32767.5");
    quantity("030", 8192.0, "the least is -8192, the greatest 8191.75");
    quantity("030", -8192.2, "the least is -8192, the greatest 8191.75");
    quantity("030", f64::INFINITY, "the least is -8192, the greatest 8191.75");
    refused("030", f64::NAN.into(), "I250/030: the quantity is no number (NaN)");
    let b = Value::group([("A", 0u64.into()), ("B", 16_384.0.into())]);
    refused(
        "060",
        b,
        "I250/060 B: 16384 is out of range, the least is -16384, the greatest 16383",
    );
}

#[test]
fn texts_have_the_characters_of_their_coding_and_no_more_than_fit() {
    let texts = |a: &str, i: &str, o: &str| Value::group([("A", a.into()), ("I", i.into()), ("O", o.into())]);
    refused(
        "050",
        texts("é", "Z9", "7654"),
        r#"I250/050 A: "é" has the character 'é', which printable ASCII lacks"#,
    );
    refused(
        "050",
        texts("Ab", "z", "7654"),
        r#"I250/050 I: "z" has the character 'z', which the six-bit alphabet lacks"#,
    );
    refused(
        "050",
        texts("Ab", "Z\u{FFFD}", "7654"),
        "I250/050 I: \"Z\u{FFFD}\" has the character '\u{FFFD}', which the six-bit alphabet lacks",
    );
    refused(
        "050",
        texts("Ab", "Z9", "7658"),
        r#"I250/050 O: "7658" has the character '8', which the octal digits lacks"#,
    );
    refused(
        "050",
        texts("Abc", "Z9", "7654"),
        r#"I250/050 A: "Abc" has 3 characters, the least is 0, the most 2"#,
    );
    refused(
        "050",
        texts("Ab", "Z9", "765"),
        r#"I250/050 O: "765" has 3 characters, the least is 4, the most 4"#,
    );
}

#[test]
fn lists_and_contents_have_the_length_that_can_be_given() {
    refused("070", list(&[0; 256]), "I250/070: has 256 values, the most is 255");
    refused("080", list(&[]), "I250/080: has no value, but needs at least one");
    refused(
        "RE",
        Value::Bytes(vec![0; 255]),
        "I250/RE: has 255 octets of content, the most is 254",
    );
}

#[test]
fn a_random_field_sequence_holds_single_items_of_the_profile_and_no_sequence() {
    let field = |name, value| Value::list([Value::group([(name, value)])]);
    let unknown = |name: &'static str| {
        let expected = format!("I250/RFS [1] {name}: the edition defines nothing of this name here");
        refused("RFS", field(name, 1.0.into()), &expected);
    };
    unknown("025");
    unknown("");
    unknown("RFS");
    refused(
        "RFS",
        Value::list([Value::group([])]),
        "I250/RFS [1]: takes a group of one item, found a group",
    );
    refused(
        "RFS",
        field("020", 1u64.into()),
        "I250/RFS [1] 020: takes a quantity, found a number without sign",
    );
}

#[test]
fn a_place_within_a_list_or_a_subitem_is_named_by_the_way_to_it() {
    refused(
        "070",
        list(&[1, 65_536]),
        "I250/070 [2]: 65536 is out of range, the least is 0, the greatest 65535",
    );
    let value = Value::group([("EIGHT", list(&[0, 0, 256]))]);
    refused(
        "100",
        value,
        "I250/100 EIGHT [3]: 256 is out of range, the least is 0, the greatest 255",
    );
    let value = Value::group([("TWO", 1u64.into())]);
    refused(
        "100",
        value,
        "I250/100 TWO: the edition defines nothing of this name here",
    );
    let groups = Value::list([Value::group([("UNIT", 256u64.into()), ("TRACK", 0u64.into())])]);
    refused(
        "090",
        groups,
        "I250/090 [1] UNIT: 256 is out of range, the least is 0, the greatest 255",
    );
}
