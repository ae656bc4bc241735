//! The content of reserved expansion fields, from hand-made bytes and from any.

use asterix::categories::{CAT021_V2_4, CAT048_RE_V1_12, CAT048_V1_31, CAT062_RE_V1_2, CAT062_V1_18};
use asterix::named::UNKNOWN_EXTENSION;
use asterix::{Category, Error, Expansion, Mode, Value, registry};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::sample::{block, only_block};

/// Reads the field of a record that holds nothing else.
fn read(table: &'static Category, expansion: &'static Expansion, field: &[u8]) -> Result<Option<Value>, Error> {
    let frn = usize::from(table.uap().frn("RE").get());
    let mut body = vec![0x01; (frn - 1) / 7];
    body.push(0x80 >> ((frn - 1) % 7));
    body.extend(field);
    let bytes = block(table.number, &body);
    let record = only_block(&bytes)
        .records(table, Mode::Lenient)
        .next()
        .expect("a record");
    expansion.read(&record.expect("a good record"))
}

fn group(members: &[(&'static str, Value)]) -> Value {
    Value::Group(members.to_vec())
}

#[test]
fn a_field_holds_what_its_flags_announce() {
    // 0000 1010: ERR, 0x012345 / 256 NM, and CPC with its first subitem, PNB.
    let field = [8, 0x0A, 0x01, 0x23, 0x45, 0x80, 0x12, 0x34];
    let expected = group(&[
        ("ERR", Value::Quantity(f64::from(0x01_2345) / 256.0)),
        ("CPC", group(&[("PNB", Value::Unsigned(0x1234))])),
    ]);
    assert_eq!(read(&CAT048_V1_31, &CAT048_RE_V1_12, &field), Ok(Some(expected)));
}

#[test]
fn a_field_may_hold_nothing() {
    for field in [&[1][..], &[2, 0]] {
        assert_eq!(read(&CAT062_V1_18, &CAT062_RE_V1_2, field), Ok(Some(group(&[]))));
    }
    assert_eq!(
        read(&CAT021_V2_4, &CAT062_RE_V1_2, &[2, 0]),
        Ok(None),
        "the coding rules of another category"
    );
}

#[test]
fn octets_behind_the_last_subitem_are_kept_as_unknown() {
    let beyond = Value::Bytes(vec![0xAB, 0xCD]);
    let velocity = group(&[("VX", Value::Quantity(0.25)), ("VY", Value::Quantity(-0.25))]);
    assert_eq!(
        read(&CAT062_V1_18, &CAT062_RE_V1_2, &[8, 0x20, 0, 1, 0xFF, 0xFF, 0xAB, 0xCD]),
        Ok(Some(group(&[("TVS", velocity), (UNKNOWN_EXTENSION, beyond)])))
    );
}

#[test]
fn a_flag_without_meaning_is_an_error() {
    let error = read(&CAT062_V1_18, &CAT062_RE_V1_2, &[2, 0x08]).unwrap_err();
    let expected = "byte 8: I062/RE announces a subitem at position 5, where this edition defines none";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_subitem_ends_within_the_field() {
    let error = read(&CAT062_V1_18, &CAT062_RE_V1_2, &[5, 0x20, 0, 1, 0xFF]).unwrap_err();
    let expected = "byte 10: I062/TVS takes at least 4 octets, 3 left";
    assert_eq!(error.to_string(), expected);
}

proptest! {
    #[test]
    fn any_field_is_read_or_refused(content in vec(any::<u8>(), 0..60)) {
        let field = [&[content.len() as u8 + 1][..], &content].concat();
        for expansion in registry::EXPANSIONS {
            let table = registry::default_edition(expansion.number).expect("a table of the category");
            let end = 3 + table.uap().items.len().div_ceil(7) + field.len();
            if let Err(error) = read(table, expansion, &field) {
                prop_assert!(error.offset() <= end);
            }
        }
    }
}
