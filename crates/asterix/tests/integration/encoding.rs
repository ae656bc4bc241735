//! Each kind of item, into bytes worked out by hand; and records packed into blocks.

use asterix::named::UNKNOWN_EXTENSION;
use asterix::{BlockWriter, EncodeError, NamedRecord, Value, blocks};

use crate::sample::{PLOT_OR_TRACK, SAMPLE, encode_item};

/// The bytes of one item.
fn item(name: &'static str, value: Value) -> Vec<u8> {
    encode_item(name, value).unwrap()
}

fn list(numbers: &[u64]) -> Value {
    Value::list(numbers.iter().map(|&number| number.into()))
}

fn encode(record: &NamedRecord) -> Result<Vec<u8>, EncodeError> {
    let table = if record.category == 250 {
        &SAMPLE
    } else {
        &PLOT_OR_TRACK
    };
    let mut octets = vec![];
    record.encode(table, &mut octets)?;
    Ok(octets)
}

#[test]
fn a_group_leaves_spare_bits_zero_and_crosses_octets() {
    let value = Value::group([("F", 1u64.into()), ("HIGH", 0xAB_u64.into()), ("LOW", 0xC_u64.into())]);
    assert_eq!(item("010", value), [0b1000_1010, 0b1011_1100]);
}

#[test]
fn the_order_of_members_does_not_matter() {
    let value = Value::group([("LOW", 0xC_u64.into()), ("F", 1u64.into()), ("HIGH", 0xAB_u64.into())]);
    assert_eq!(item("010", value), [0b1000_1010, 0b1011_1100]);
}

#[test]
fn a_quantity_is_the_nearest_number_of_lsbs() {
    assert_eq!(item("020", 32_767.5.into()), [0xFF, 0xFF]);
    assert_eq!(item("020", 1.2.into()), [0, 2], "2.4 halves");
    assert_eq!(item("020", 1.3.into()), [0, 3], "2.6 halves");
    assert_eq!(item("020", (-0.2).into()), [0, 0], "rounded before it is checked");
    assert_eq!(item("030", (-0.25).into()), [0xFF, 0xFF]);
    assert_eq!(item("030", (-8192.0).into()), [0x80, 0x00]);
    assert_eq!(item("030", 8191.75.into()), [0x7F, 0xFF]);
}

#[test]
fn integers_have_a_sign_where_the_table_says_so() {
    let value = Value::group([("U", 15u64.into()), ("S", (-1i64).into())]);
    assert_eq!(item("040", value), [0xFF]);
}

#[test]
fn texts_are_packed_in_eight_six_or_three_bits() {
    let value = Value::group([("A", "Ab".into()), ("I", "Z9".into()), ("O", "7654".into())]);
    // "Ab", then 011010 111001 ("Z9") and 111 110 101 100
    let octets = [b'A', b'b', 0b0110_1011, 0b1001_1111, 0b1010_1100];
    assert_eq!(item("050", value), octets);
}

#[test]
fn a_short_text_is_filled_up_with_spaces() {
    let value = Value::group([("A", "A".into()), ("I", "".into()), ("O", "0000".into())]);
    // "A ", then 100000 100000 and four zeros
    let octets = [b'A', b' ', 0b1000_0010, 0b0000_0000, 0b0000_0000];
    assert_eq!(item("050", value), octets);
}

#[test]
fn an_extended_item_has_as_many_parts_as_have_an_element() {
    let a = ("A", Value::from(5u64));
    let b = ("B", Value::from(-2.0));
    let c = ("C", Value::from(1u64));
    assert_eq!(item("060", Value::group([a.clone()])), [0x0A]);
    assert_eq!(item("060", Value::group([a.clone(), b.clone()])), [0x0B, 0xFF, 0xFC]);
    assert_eq!(item("060", Value::group([c, b, a])), [0x0B, 0xFF, 0xFD, 0x02]);
}

#[test]
fn octets_beyond_the_last_part_are_written_back() {
    let value = Value::group([
        ("A", 5u64.into()),
        ("B", (-2.0).into()),
        ("C", 1u64.into()),
        (UNKNOWN_EXTENSION, Value::Bytes(vec![0x41, 0x42])),
    ]);
    assert_eq!(item("060", value), [0x0B, 0xFF, 0xFD, 0x03, 0x41, 0x42]);
}

#[test]
fn a_repetitive_item_counts_its_values() {
    assert_eq!(item("070", list(&[])), [0]);
    assert_eq!(item("070", list(&[256, 2])), [2, 0x01, 0x00, 0x00, 0x02]);
    assert_eq!(item("070", list(&[7; 255])).len(), 1 + 2 * 255);
}

#[test]
fn a_repetitive_item_by_fx_sets_it_in_all_but_the_last() {
    assert_eq!(item("080", list(&[1])), [0x02]);
    assert_eq!(item("080", list(&[1, 2, 3])), [0x03, 0x05, 0x06]);
    let first = Value::group([("UNIT", 7u64.into()), ("TRACK", 1u64.into())]);
    let second = Value::group([("UNIT", 8u64.into()), ("TRACK", 0x7FFF_u64.into())]);
    assert_eq!(
        item("090", Value::list([first, second])),
        [7, 0x00, 0x03, 8, 0xFF, 0xFE]
    );
}

#[test]
fn a_compound_item_announces_what_it_holds() {
    let three = || Value::group([("T", 1u64.into())]);
    assert_eq!(
        item("100", Value::group([("ONE", 0x2A_u64.into()), ("THREE", three())])),
        [0b1010_0000, 0x2A, 0x02]
    );
    assert_eq!(
        item("100", Value::group([("EIGHT", list(&[5, 6])), ("THREE", three())])),
        [0b0010_0001, 0b1000_0000, 0x02, 2, 5, 6],
        "the eighth subitem is the first of the second FSPEC octet"
    );
    assert_eq!(item("100", Value::group([])), [0], "an FSPEC has an octet");
}

#[test]
fn the_content_of_an_element_may_depend_on_one_before_it() {
    let speed = |im: u64, speed: f64| Value::group([("IM", im.into()), ("SPEED", speed.into())]);
    assert_eq!(item("110", speed(0, 1.5)), [0x00, 0x03]);
    assert_eq!(item("110", speed(1, 0.8)), [0x83, 0x20]);
}

#[test]
fn a_group_within_a_part_has_members_of_its_own() {
    let inner = Value::group([("EP", 1u64.into()), ("VAL", 2u64.into())]);
    let value = Value::group([("A", 0u64.into()), ("B", inner)]);
    assert_eq!(item("120", value), [0b0110_0000]);
}

#[test]
fn an_explicit_item_counts_its_length_octet() {
    assert_eq!(item("RE", Value::Bytes(vec![0xDE, 0xAD, 0x01])), [4, 0xDE, 0xAD, 0x01]);
    assert_eq!(item("RE", Value::Bytes(vec![])), [1]);
    assert_eq!(item("RE", Value::Bytes(vec![9; 254]))[..2], [255, 9]);
}

#[test]
fn a_random_field_sequence_names_each_item_by_its_number() {
    let field = |name, value| Value::group([(name, value)]);
    let long = Value::group([("A", 5u64.into()), ("B", (-2.0).into())]);
    let short = Value::group([("A", 1u64.into())]);
    let value = Value::list([field("060", long), field("020", 2.0.into()), field("060", short)]);
    assert_eq!(
        item("RFS", value),
        [3, 6, 0x0B, 0xFF, 0xFC, 2, 0x00, 0x04, 6, 0x02],
        "in the order given"
    );
    assert_eq!(item("RFS", list(&[])), [0]);
}

#[test]
fn a_record_announces_its_items_in_the_profiles_order() {
    let record = NamedRecord::of(
        250,
        [
            ("080", list(&[3])),
            ("020", 2.0.into()),
            (
                "010",
                Value::group([("F", 1u64.into()), ("HIGH", 0u64.into()), ("LOW", 0u64.into())]),
            ),
        ],
    );
    let mut octets = vec![0xEE];
    record.encode(&SAMPLE, &mut octets).unwrap();
    let expected = [0xEE, 0b1100_0001, 0b1000_0000, 0x80, 0x00, 0x00, 0x04, 0x06];
    assert_eq!(octets, expected, "appended, with no FSPEC octet more than it takes");
}

#[test]
fn an_element_decides_between_profiles() {
    let record = |typ: u64, item| {
        NamedRecord::of(
            251,
            [
                ("010", 0x0102_u64.into()),
                ("020", Value::group([("TYP", typ.into())])),
                item,
            ],
        )
    };
    let plot = record(0, ("040", 9.0.into()));
    assert_eq!(encode(&plot), Ok(vec![0b1110_0000, 1, 2, 0x00, 0, 9]));
    let track = record(1, ("040", 9.0.into()));
    assert_eq!(encode(&track), Ok(vec![0b1101_0000, 1, 2, 0x40, 0, 9]));
    let track = record(1, ("161", 9u64.into()));
    assert_eq!(encode(&track), Ok(vec![0b1110_0000, 1, 2, 0x40, 0, 0, 9]));
}

#[test]
fn records_fill_blocks_up_to_their_greatest_size() {
    let mut writer = BlockWriter::new(250, 3 + 10);
    let records: Vec<Vec<u8>> = [4, 4, 2, 10, 1, 9, 1]
        .map(|octets| vec![octets; octets.into()])
        .to_vec();
    let mut written = vec![];
    for record in &records {
        written.extend(writer.push(record).unwrap().map(<[u8]>::to_vec));
    }
    written.extend(writer.finish().map(<[u8]>::to_vec));
    assert_eq!(writer.finish(), None);
    let sizes: Vec<_> = written.iter().map(Vec::len).collect();
    assert_eq!(sizes, [13, 13, 13, 4]);
    let bytes = written.concat();
    let mut bodies = Vec::<u8>::new();
    for block in blocks(&bytes) {
        let block = block.unwrap();
        assert_eq!(block.category, 250);
        bodies.extend(block.body());
    }
    assert_eq!(bodies, records.concat(), "nothing lost, nothing moved");
}

#[test]
fn a_record_that_fits_no_block_is_refused_and_the_others_stay() {
    let mut writer = BlockWriter::new(62, 8);
    assert_eq!(writer.push(&[0x80, 1, 2]), Ok(None));
    let error = writer.push(&[0; 6]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "category 062: a record of 6 octets does not fit a block of at most 8, 3 of them its header"
    );
    assert_eq!(writer.push(&[0x80, 3]), Ok(None));
    assert_eq!(writer.finish(), Some(&[62, 0, 8, 0x80, 1, 2, 0x80, 3][..]));
    assert!(BlockWriter::new(62, 2).push(&[0x80]).is_err(), "no room for a header");
}

#[test]
fn a_block_has_at_most_what_its_length_field_can_give() {
    let mut writer = BlockWriter::new(62, u16::MAX);
    let record = vec![0; 0xFFFF - 3];
    assert_eq!(writer.push(&record), Ok(None));
    assert_eq!(writer.finish().unwrap()[..3], [62, 0xFF, 0xFF]);
    assert!(writer.push(&[&record[..], &[0]].concat()).is_err());
}
