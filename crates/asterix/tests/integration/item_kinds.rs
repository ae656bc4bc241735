//! Each kind of item, from hand-made bytes.

use asterix::named::UNKNOWN_EXTENSION;
use asterix::{JsonLines, Mode, NamedRecord, Value};

use crate::sample::{PLOT_OR_TRACK, SAMPLE, item, read};

fn group(members: &[(&'static str, Value)]) -> Value {
    Value::Group(members.to_vec())
}

fn list(numbers: &[u64]) -> Value {
    Value::List(numbers.iter().map(|&number| Value::Unsigned(number)).collect())
}

#[test]
fn a_group_skips_spare_bits_and_crosses_octets() {
    let expected = group(&[
        ("F", Value::Unsigned(1)),
        ("HIGH", Value::Unsigned(0xAB)),
        ("LOW", Value::Unsigned(0xC)),
    ]);
    assert_eq!(item("010", &[0b1000_1010, 0b1011_1100]), expected);
    assert_eq!(item("010", &[0b1111_1010, 0b1011_1100]), expected, "spare bits set");
}

#[test]
fn a_quantity_is_the_number_times_the_lsb() {
    assert_eq!(item("020", &[0xFF, 0xFF]), Value::Quantity(32_767.5));
    assert_eq!(item("030", &[0xFF, 0xFF]), Value::Quantity(-0.25));
    assert_eq!(item("030", &[0x80, 0x00]), Value::Quantity(-8192.0));
}

#[test]
fn integers_have_a_sign_where_the_table_says_so() {
    assert_eq!(
        item("040", &[0xFF]),
        group(&[("U", Value::Unsigned(15)), ("S", Value::Signed(-1))])
    );
}

#[test]
fn texts_are_packed_in_eight_six_or_three_bits() {
    let expected = group(&[
        ("A", Value::Text("Ab".into())),
        ("I", Value::Text("Z9".into())),
        ("O", Value::Text("7654".into())),
    ]);
    // "Ab", then 011010 111001 ("Z9") and 111 110 101 100
    assert_eq!(
        item("050", &[b'A', b'b', 0b0110_1011, 0b1001_1111, 0b1010_1100]),
        expected
    );
}

#[test]
fn an_extended_item_ends_at_a_clear_fx_bit() {
    assert_eq!(item("060", &[0x0A]), group(&[("A", Value::Unsigned(5))]));
    assert_eq!(
        item("060", &[0x0B, 0xFF, 0xFC]),
        group(&[("A", Value::Unsigned(5)), ("B", Value::Quantity(-2.0))]),
        "a part of two octets"
    );
}

#[test]
fn octets_beyond_the_last_part_are_kept_as_unknown() {
    let expected = group(&[
        ("A", Value::Unsigned(5)),
        ("B", Value::Quantity(-2.0)),
        ("C", Value::Unsigned(1)),
        (UNKNOWN_EXTENSION, Value::Bytes(vec![0x41, 0x42])),
    ]);
    assert_eq!(item("060", &[0x0B, 0xFF, 0xFD, 0x03, 0x41, 0x42]), expected);
}

#[test]
fn the_last_part_of_an_extended_item_may_have_no_fx_bit() {
    assert_eq!(item("130", &[0x0A]), group(&[("A", Value::Unsigned(5))]));
    assert_eq!(
        item("130", &[0x0B, 0xFF]),
        group(&[("A", Value::Unsigned(5)), ("B", Value::Unsigned(0xFF))])
    );
}

#[test]
fn a_repetitive_item_has_as_many_values_as_it_counts() {
    assert_eq!(item("070", &[0]), list(&[]));
    assert_eq!(item("070", &[2, 0x01, 0x00, 0x00, 0x02]), list(&[256, 2]));
}

#[test]
fn a_repetitive_item_by_fx_ends_at_a_clear_fx_bit() {
    assert_eq!(item("080", &[0x03, 0x05, 0x06]), list(&[1, 2, 3]));
    let first = group(&[("UNIT", Value::Unsigned(7)), ("TRACK", Value::Unsigned(1))]);
    let second = group(&[("UNIT", Value::Unsigned(8)), ("TRACK", Value::Unsigned(0x7FFF))]);
    assert_eq!(
        item("090", &[7, 0x00, 0x03, 8, 0xFF, 0xFE]),
        Value::List(vec![first, second])
    );
}

#[test]
fn a_compound_item_holds_what_its_fspec_announces() {
    let three = || group(&[("T", Value::Unsigned(1))]);
    assert_eq!(
        item("100", &[0b1010_0000, 0x2A, 0x02]),
        group(&[("ONE", Value::Unsigned(0x2A)), ("THREE", three())])
    );
    assert_eq!(
        item("100", &[0b0010_0001, 0b1000_0000, 0x02, 2, 5, 6]),
        group(&[("THREE", three()), ("EIGHT", list(&[5, 6]))]),
        "the eighth subitem is the first of the second FSPEC octet"
    );
}

#[test]
fn the_content_of_an_element_may_depend_on_one_before_it() {
    let speed = |octets: &[u8]| item("110", octets).get("SPEED").cloned();
    assert_eq!(speed(&[0x00, 0x03]), Some(Value::Quantity(1.5)));
    assert_eq!(speed(&[0x83, 0x20]), Some(Value::Quantity(800.0 * 0.001)));
}

#[test]
fn a_group_within_a_part_keeps_its_name() {
    let inner = group(&[("EP", Value::Unsigned(1)), ("VAL", Value::Unsigned(2))]);
    assert_eq!(
        item("120", &[0b0110_0000]),
        group(&[("A", Value::Unsigned(0)), ("B", inner)])
    );
}

#[test]
fn an_explicit_item_counts_its_length_octet() {
    assert_eq!(item("RE", &[4, 0xDE, 0xAD, 0x01]), Value::Bytes(vec![0xDE, 0xAD, 0x01]));
    assert_eq!(item("RE", &[1]), Value::Bytes(vec![]));
}

#[test]
fn a_random_field_sequence_holds_items_in_any_order_and_more_than_once() {
    assert_eq!(item("RFS", &[0]), Value::List(vec![]));
    // Three fields: FRN 6, which goes on for two parts, FRN 2 and FRN 6 again.
    let field = |name, value| group(&[(name, value)]);
    let long = group(&[("A", Value::Unsigned(5)), ("B", Value::Quantity(-2.0))]);
    assert_eq!(
        item("RFS", &[3, 6, 0x0B, 0xFF, 0xFC, 2, 0x00, 0x04, 6, 0x02]),
        Value::List(vec![
            field("060", long),
            field("020", Value::Quantity(2.0)),
            field("060", group(&[("A", Value::Unsigned(1))])),
        ])
    );
}

#[test]
fn a_record_gives_its_items_in_the_order_sent() {
    let body = [0b1100_0001, 0b1000_0000, 0x80, 0x00, 0x00, 0x04, 0x06];
    read(&SAMPLE, Mode::Strict, &body, |record| {
        let record = record.unwrap();
        let items: Vec<_> = record
            .items()
            .map(|(item, octets)| (item.name, octets.to_vec()))
            .collect();
        assert_eq!(
            items,
            [
                ("010", vec![0x80, 0x00]),
                ("020", vec![0x00, 0x04]),
                ("080", vec![0x06])
            ]
        );
        assert_eq!((record.offset(), record.bytes()), (3, &body[..]));
        assert_eq!(record.frns().map(|frn| frn.get()).collect::<Vec<_>>(), [1, 2, 8]);
        assert_eq!(record.item_named("030"), None);
    });
}

#[test]
fn an_element_decides_between_profiles() {
    let names = |body: &[u8]| {
        let mut names = vec![];
        read(&PLOT_OR_TRACK, Mode::Lenient, body, |record| {
            names.extend(record.unwrap().items().map(|(item, _)| item.name));
        });
        names
    };
    assert_eq!(names(&[0b1110_0000, 1, 2, 0x00, 0, 9]), ["010", "020", "040"]);
    assert_eq!(names(&[0b1110_0000, 1, 2, 0x40, 0, 9, 9]), ["010", "020", "161"]);
}

#[test]
fn json_has_numbers_texts_hexadecimal_octets_and_the_category() {
    let body = [
        0b0010_1001,
        0b0000_0010,
        0xFF,
        0xFF,
        b'A',
        b'b',
        0x6B,
        0x9F,
        0xAC,
        3,
        0x0F,
        0xF0,
    ];
    read(&SAMPLE, Mode::Lenient, &body, |record| {
        let record = record.unwrap();
        let mut named = NamedRecord::new(&record);
        let expected = r#"{"030":-0.25,"050":{"A":"Ab","I":"Z9","O":"7654"},"RE":"0ff0","_c":250}"#;
        let mut line = vec![];
        named.write_json(&mut line);
        assert_eq!(String::from_utf8(line).unwrap(), expected);
        assert_eq!(named.get(&["050", "O"]), Some(&Value::Text("7654".into())));
        assert_eq!(named.get(&["030"]).and_then(Value::as_f64), Some(-0.25));
        assert_eq!(named.get(&["050", "X"]), None);
        named.time_stamp_s = Some(1.5);
        assert_eq!(named.to_json()["_ts"], 1.5);
        for time_stamp_s in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
            let mut lines = JsonLines::default();
            lines.write(&record, Some(time_stamp_s), None);
            let expected = expected.replace("250}", "250,\"_ts\":null}\n");
            assert_eq!(str::from_utf8(lines.text()).unwrap(), expected);
        }
    });
}
