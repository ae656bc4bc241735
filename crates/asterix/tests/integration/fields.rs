//! Places of elements, as they are looked up for readers, against what the decoder of whole records finds there.

use asterix::field::{Field, added, field, item, subitem};
use asterix::table::{Content, Layout, Part};
use asterix::{Category, Decoder, Mode, NamedRecord, Record, Value, registry};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::generator::Entropy;
use crate::sample::{SAMPLE, block};

/// The paths of all elements of a group, and their contents.
fn elements<'p>(parts: &'static [Part], before: &[&'p str]) -> Vec<(Vec<&'p str>, &'static Content)> {
    let mut found = vec![];
    for part in parts {
        match part {
            Part::Element { name, content, .. } => found.push(([before, &[name]].concat(), content)),
            Part::Group(name, inner) => found.extend(elements(inner, &[before, &[name]].concat())),
            Part::Spare(_) => {}
        }
    }
    found
}

/// Compares the elements of an item or subitem, of which the record has these bytes; gives how many were sent.
fn compare(
    table: &'static Category,
    named: &NamedRecord,
    layout: &'static Layout,
    path: &[&str],
    octets: &[u8],
) -> usize {
    let elements = match layout {
        Layout::Element(_, content) => vec![(path.to_vec(), content)],
        Layout::Group(parts) => elements(parts, path),
        Layout::Extended(extension) => extension.iter().flat_map(|parts| elements(parts, path)).collect(),
        _ => vec![],
    };
    let sent = elements.iter().filter(|(path, content)| {
        let field = field(&[table], path);
        let value = named.get(path);
        assert_eq!(field.number(octets).is_some(), value.is_some(), "{table} {path:?}");
        let Some(value) = value else { return false };
        assert_eq!(field.is_set(octets), field.number(octets) != Some(0));
        compare_value(field, octets, value, content);
        true
    });
    sent.count()
}

fn compare_value(field: Field, octets: &[u8], value: &Value, content: &Content) {
    let (number, integer) = (field.number(octets).unwrap(), field.integer(octets).unwrap());
    match (value, content) {
        (Value::Unsigned(value), _) => assert_eq!(number, *value),
        (Value::Signed(value), _) => assert_eq!(integer, *value),
        (Value::Quantity(value), Content::Quantity { lsb, .. }) => {
            assert_eq!(integer as f64 * lsb, *value);
            assert_eq!(field.quantity(octets), Some(integer as f64 * field.lsb));
        }
        (Value::Quantity(_), Content::Depends { .. }) | (Value::Text(_), Content::Text(_)) => {}
        other => panic!("{other:?}"),
    }
}

fn compare_record(record: &Record<'_>) -> usize {
    let (table, named) = (record.table(), NamedRecord::new(record));
    let mut compared = 0;
    for ((item, octets), frn) in record.items().zip(record.frns()) {
        assert_eq!(record.octets(frn), octets);
        match &item.layout {
            Layout::Compound(subitems) => {
                for (position, octets) in record.subitems(frn) {
                    let part = subitems[position - 1].as_ref().unwrap();
                    assert_eq!(subitem(&[table], item.name, part.name), position);
                    compared += compare(table, &named, &part.layout, &[item.name, part.name], octets);
                }
            }
            layout => compared += compare(table, &named, layout, &[item.name], octets),
        }
    }
    compared
}

proptest! {
    #[test]
    fn every_element_lies_where_the_decoder_finds_it(octets in vec(any::<u8>(), 1..300)) {
        for table in registry::REGISTRY.iter().copied().chain([&SAMPLE]) {
            let bytes = block(table.number, &Entropy::new(&octets).record(table).0);
            for record in Decoder::new(Mode::Lenient).with_table(table).records(&bytes) {
                compare_record(&record.unwrap());
            }
        }
    }
}

#[test]
fn units_become_those_of_the_si() {
    use asterix::categories::*;
    use std::f64::consts::PI;
    let lsb = |editions: &[&Category], path: &[&str]| field(editions, path).lsb;
    assert_eq!(lsb(CAT048, &["040", "RHO"]), 1852.0 / 256.0);
    assert_eq!(lsb(CAT048, &["040", "THETA"]), 2.0 * PI / 65_536.0);
    assert_eq!(lsb(CAT048, &["200", "GSP"]), 1852.0 / 16_384.0);
    assert_eq!(lsb(CAT062, &["105", "LAT"]), PI / f64::from(1 << 25));
    assert_eq!(lsb(CAT062, &["136"]), 0.25 * 30.48);
    assert_eq!(lsb(CAT062, &["130"]), 6.25 * 0.3048);
    assert_eq!(lsb(CAT062, &["220"]), 6.25 * 0.3048 / 60.0);
    assert_eq!(lsb(CAT062, &["380", "TAS"]), 1852.0 / 3600.0);
    assert_eq!(lsb(CAT063, &["070"]), 0.001);
    assert_eq!(lsb(CAT048, &["020", "TYP"]), 1.0);
}

/// A message of the panic with which a constant would fail the build.
fn refused<T>(look_up: impl FnOnce() -> T + std::panic::UnwindSafe) -> String {
    let panic = std::panic::catch_unwind(look_up).map(|_| ()).unwrap_err();
    panic.downcast_ref::<&str>().expect("a message").to_string()
}

#[test]
fn what_is_misspelt_or_differs_between_editions_is_refused() {
    use asterix::categories::*;
    assert_eq!(refused(|| item(CAT048, "041")), "no edition has an item of this name");
    assert_eq!(
        refused(|| field(CAT048, &["040", "ROH"])),
        "no edition has an element of this name"
    );
    assert_eq!(
        refused(|| field(CAT048, &["040"])),
        "no edition has an element of this name",
        "a group is no element"
    );
    assert_eq!(
        refused(|| field(CAT062, &["080", "SFC"])),
        "an edition has no element of this name"
    );
    assert_eq!(
        refused(|| field(CAT021_V0, &["130", "LAT"])),
        "the editions differ in the element"
    );
    assert_eq!(
        refused(|| subitem(CAT062, "380", "XXX")),
        "an edition has no subitem of this name"
    );
    let both: &[&Category] = &[&CAT021_V0_26, &CAT021_V2_1];
    assert_eq!(
        refused(|| item(both, "080")),
        "the editions have the item in different places"
    );
    let surface = added(CAT062, &["080", "SFC"]);
    assert_eq!(surface.since, CAT062_V1_18.edition);
}
