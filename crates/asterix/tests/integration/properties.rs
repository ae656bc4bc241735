//! Any bytes whatever: no panic, no endless loop, no byte lost; and what is well-formed is read as it was made.

use asterix::{Category, Decoder, Mode, NamedRecord, registry};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::any_bytes;
use crate::generator::Entropy;
use crate::sample::{PLOT_OR_TRACK, SAMPLE, block};

/// The registered tables and the invented ones. Each case of a property goes through all of them.
fn tables() -> impl Iterator<Item = &'static Category> {
    registry::REGISTRY.iter().copied().chain([&SAMPLE, &PLOT_OR_TRACK])
}

/// Reads everything in every way; gives the number of records.
fn read_all(table: &'static Category, mode: Mode, bytes: &[u8]) -> u64 {
    any_bytes::check(table, mode, bytes).counts.records
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_read_to_their_end(
        bytes in vec(any::<u8>(), 0..400),
        in_a_block in any::<bool>(),
        strict in any::<bool>(),
    ) {
        let mode = if strict { Mode::Strict } else { Mode::Lenient };
        for table in tables() {
            let framed = block(table.number, &bytes);
            read_all(table, mode, if in_a_block { &framed } else { &bytes });
        }
    }

    #[test]
    fn a_well_formed_record_gives_its_items_back(octets in vec(any::<u8>(), 1..300)) {
        for table in tables() {
            let (record, items) = Entropy::new(&octets).record(table);
            let bytes = block(table.number, &record.repeat(3));
            prop_assert_eq!(read_all(table, Mode::Lenient, &bytes), 3);
            for found in Decoder::new(Mode::Lenient).with_table(table).records(&bytes) {
                let found = found.unwrap();
                let found_items: Vec<_> =
                    found.items().map(|(item, octets)| (item.name, octets.to_vec())).collect();
                prop_assert_eq!(&found_items, &items);
                prop_assert_eq!(NamedRecord::new(&found).items.len(), items.len());
            }
        }
    }

    #[test]
    fn a_damaged_block_is_read_to_its_end(
        octets in vec(any::<u8>(), 1..300),
        damage in vec((any::<Index>(), any::<u8>()), 1..6),
        kept in any::<Index>(),
        strict in any::<bool>(),
    ) {
        let mode = if strict { Mode::Strict } else { Mode::Lenient };
        for table in tables() {
            let mut entropy = Entropy::new(&octets);
            let mut bytes = vec![];
            for _ in 0..3 {
                bytes.extend(block(table.number, &entropy.record(table).0));
            }
            for (place, octet) in &damage {
                let place = place.index(bytes.len());
                bytes[place] = *octet;
            }
            read_all(table, mode, &bytes);
            bytes.truncate(kept.index(bytes.len()) + 1);
            read_all(table, mode, &bytes);
        }
    }
}
