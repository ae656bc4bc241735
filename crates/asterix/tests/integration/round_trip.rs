//! There and back: values into bytes and the same values again; bytes into values and the same bytes again.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use asterix::categories::CAT021_V0_23;
use asterix::encode_error::EncodeFault;
use asterix::table::Uap;
use asterix::text::UNDEFINED;
use asterix::{Category, Decoder, EncodeError, Error, Mode, NamedRecord, Record, Value, registry};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use crate::files;
use crate::generator::Entropy;
use crate::sample::{PLOT_OR_TRACK, SAMPLE, block};
use crate::values::profiles;

/// Every profile of every registered table, and of the invented ones.
static PROFILES: LazyLock<Vec<(&Category, &Uap)>> = LazyLock::new(|| {
    let tables = registry::REGISTRY.iter().copied().chain([&SAMPLE, &PLOT_OR_TRACK]);
    tables
        .flat_map(|table| profiles(table).into_iter().map(move |uap| (table, uap)))
        .collect()
});

fn encode(record: &NamedRecord, table: &'static Category) -> Result<Vec<u8>, EncodeError> {
    let mut octets = vec![];
    record.encode(table, &mut octets).map(|()| octets)
}

/// The only record in these bytes.
fn decode<T>(octets: &[u8], table: &'static Category, mode: Mode, see: impl FnOnce(&Record<'_>) -> T) -> T {
    let bytes = block(table.number, octets);
    let mut decoder = Decoder::new(mode).with_table(table);
    let record = decoder
        .records(&bytes)
        .next()
        .expect("a record")
        .expect("a good record");
    assert_eq!(record.bytes(), octets, "nothing is left over");
    see(&record)
}

fn check_values(record: &NamedRecord, table: &'static Category) {
    let octets = encode(record, table).unwrap_or_else(|error| panic!("{table}: {error} in {record:?}"));
    decode(&octets, table, Mode::Lenient, |decoded| {
        assert_eq!(&NamedRecord::new(decoded), record, "{table}: {octets:02x?}");
        if decoded.unknown_extension_octets() == 0 {
            decode(&octets, table, Mode::Strict, |strict| {
                assert_eq!(strict.bytes(), octets)
            });
        }
    });
}

proptest! {
    #[test]
    fn values_of_every_item_come_back(octets in vec(any::<u8>(), 1..300)) {
        for &(table, uap) in PROFILES.iter() {
            for name in uap.names().filter(|name| !name.is_empty()) {
                check_values(&Entropy::new(&octets).named_record_with(table, uap, &[name]), table);
            }
        }
    }

    #[test]
    fn values_of_records_come_back((table, uap) in select(&**PROFILES), octets in vec(any::<u8>(), 1..300)) {
        check_values(&Entropy::new(&octets).named_record(table, uap), table);
    }

    #[test]
    fn the_order_of_items_does_not_matter((table, uap) in select(&**PROFILES), octets in vec(any::<u8>(), 1..300)) {
        let mut record = Entropy::new(&octets).named_record(table, uap);
        let in_order = encode(&record, table);
        record.items.reverse();
        prop_assert_eq!(encode(&record, table), in_order);
    }

    #[test]
    fn canonical_octets_come_back((table, uap) in select(&**PROFILES), octets in vec(any::<u8>(), 1..300)) {
        let octets = Entropy::new(&octets).canonical_record(table, uap);
        decode(&octets, table, Mode::Strict, |record| {
            assert!(std::ptr::eq(record.uap(), uap));
            let named = NamedRecord::new(record);
            assert_eq!(encode(&named, table).as_ref(), Ok(&octets), "{named:?}");
        });
    }
}

/// A recording; the tables it is read with where they are not the default; how many of its records are written as they
/// were read; and what the others have that is not written. Everything else in them comes back.
type Expected = (
    &'static str,
    &'static [&'static Category],
    usize,
    &'static [(&'static str, usize)],
);

#[rustfmt::skip]
static RECORDINGS: &[Expected] = &[
    ("lebl2016/160510-lebl-220001_SMR_cat10.ast", &[], 77_345, &[]),
    ("lebl2016/160510-lebl-220001_MLAT_cat10.ast", &[], 84_453, &[]),
    ("lebl2016/160510-lebl-220001_MLAT_cat20.ast", &[], 77_314, &[]),
    ("lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast", &[&CAT021_V0_23], 42_491, &[(SPARE_BIT, 948), (UNDEFINED_CHARACTER, 5891)]),
    ("akapetanovic/Jahorina.raw", &[], 2119, &[]),
    ("cro/cat048.raw", &[], 1, &[]),
    ("cro/cat062cat065.raw", &[], 2, &[(UNDEFINED_CHARACTER, 1)]),
    ("cro/cat21_re.ast", &[], 2, &[]),
    ("cro/cat_034_048.pcap", &[], 160, &[(UNDEFINED_CHARACTER, 2)]),
    ("cro/cat_062_065.pcap", &[], 3, &[]),
];

const SPARE_BIT: &str = "spare bits that are set";
const UNDEFINED_CHARACTER: &str = "a text with codes that are no characters";
const EMPTY_FSPEC_OCTET: &str = "FSPEC octets that announce nothing";

#[test]
fn recordings_come_back_octet_by_octet() {
    for (name, tables, alike, others) in RECORDINGS {
        let Some(bytes) = files::recording(name) else {
            continue;
        };
        let mut written = BTreeMap::new();
        let decoder = Decoder::new(Mode::Lenient);
        let mut decoder = tables.iter().fold(decoder, |decoder, table| decoder.with_table(table));
        for record in decoder.records(&bytes) {
            *written.entry(write_again(&record.unwrap())).or_insert(0) += 1;
        }
        let expected = others.iter().map(|(reason, count)| (Some(*reason), *count));
        assert_eq!(written, expected.chain([(None, *alike)]).collect(), "{name}");
    }
}

/// Writes what was read, and says why that was not the same again.
fn write_again(record: &Record<'_>) -> Option<&'static str> {
    let named = NamedRecord::new(record);
    match encode(&named, record.table()) {
        Ok(octets) if octets == record.bytes() => None,
        Ok(octets) => {
            let again = decode(&octets, record.table(), Mode::Strict, NamedRecord::new);
            assert_eq!(again, named, "the values come back");
            Some(not_canonical(record, &octets))
        }
        Err(error) => {
            let undefined = matches!(
                error.fault,
                EncodeFault::Character {
                    character: UNDEFINED,
                    ..
                }
            );
            assert!(undefined, "{error} in {named:?}");
            check_others(record, named, &error.place.path[0]);
            Some(UNDEFINED_CHARACTER)
        }
    }
}

/// All items but one come back byte by byte.
fn check_others(record: &Record<'_>, mut named: NamedRecord, except: &str) {
    named.items.retain(|(name, _)| *name != except);
    let octets = encode(&named, record.table()).expect("nothing else is wrong with it");
    decode(&octets, record.table(), Mode::Strict, |written| {
        let others = record.items().filter(|(item, _)| item.name != except);
        assert!(
            others
                .map(|(_, octets)| octets)
                .eq(written.items().map(|(_, octets)| octets))
        );
    });
}

/// Why the bytes of a record are not the ones that its values have been given.
fn not_canonical(record: &Record<'_>, written: &[u8]) -> &'static str {
    let fspec_octets = |octets: &[u8]| 1 + octets.iter().take_while(|octet| *octet & 1 == 1).count();
    let read = record.bytes();
    let (begin, begin_written) = (fspec_octets(read), fspec_octets(written));
    if read[begin..] == written[begin_written..] {
        let needless = &read[begin_written..begin];
        assert!(!needless.is_empty() && needless.iter().all(|octet| octet & 0xFE == 0));
        return EMPTY_FSPEC_OCTET;
    }
    let bytes = block(record.table().number, read);
    let refused = Decoder::new(Mode::Strict)
        .with_table(record.table())
        .records(&bytes)
        .any(|record| matches!(record, Err(Error::SpareBitSet { .. })));
    assert!(
        refused && read.len() == written.len(),
        "{read:02x?} became {written:02x?}"
    );
    SPARE_BIT
}

#[test]
fn what_does_not_come_back_is_told_by_reason() {
    let reason = |octets: &[u8]| decode(octets, &SAMPLE, Mode::Lenient, write_again);
    assert_eq!(reason(&[0xC0, 0x80, 0x00, 0x12, 0x34]), None);
    assert_eq!(reason(&[0xC0, 0xC0, 0x00, 0x12, 0x34]), Some(SPARE_BIT));
    assert_eq!(reason(&[0xC1, 0x00, 0x80, 0x00, 0x12, 0x34]), Some(EMPTY_FSPEC_OCTET));
    assert_eq!(
        reason(&[0x88, 0x80, 0x00, b'A', 0x07, 0, 0, 0]),
        Some(UNDEFINED_CHARACTER)
    );
}

#[test]
fn values_are_made_of_numbers_and_texts() {
    assert_eq!(Value::from(7u64), Value::Unsigned(7));
    assert_eq!(Value::from(-7i64), Value::Signed(-7));
    assert_eq!(Value::from(0.5), Value::Quantity(0.5));
    assert_eq!(Value::from("A"), Value::Text("A".to_owned()));
    assert_eq!(Value::from(7u64).as_u64(), Some(7));
    assert_eq!(Value::from(0.5).as_u64(), None);
}
