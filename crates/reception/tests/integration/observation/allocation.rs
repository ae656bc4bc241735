//! Finding the items of a record and making an observation of it does not allocate.

use std::hint::black_box;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use asterix::{Decoder, Mode, registry};
use formats::observation;

use super::block;
use crate::generator::Entropy;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn records_are_read_without_allocation() {
    for table in registry::REGISTRY {
        let mut bytes = vec![];
        for first in 0..=u8::MAX {
            let octets: Vec<u8> = (0..61u8)
                .map(|i| first.wrapping_mul(31).wrapping_add(i.wrapping_mul(i)))
                .collect();
            bytes.extend(block(table.number, &Entropy::new(&octets).record(table).0));
        }
        let mut decoder = Decoder::new(Mode::Lenient).with_table(table);
        let mut read = 0;
        assert_no_alloc(|| {
            for record in decoder.records(&bytes).flatten() {
                black_box(observation::read(&record));
                read += 1;
            }
        });
        assert_eq!(read, 256, "{table}");
    }
}
