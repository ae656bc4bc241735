//! Finding the items of a record and reading typed fields from it does not allocate.

use std::hint::black_box;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use asterix::typed::*;
use asterix::{Decoder, Mode, registry};

use crate::generator::Entropy;
use crate::sample::block;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn typed_reading_does_not_allocate() {
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
                black_box(cat001::TargetReport::read(&record));
                black_box(cat002::ServiceMessage::read(&record));
                black_box(cat010::TargetReport::read(&record));
                black_box(cat010::ServiceMessage::read(&record));
                black_box(cat019::ServiceMessage::read(&record));
                black_box(cat020::TargetReport::read(&record));
                black_box(cat021_v0::TargetReport::read(&record));
                black_box(cat021_v2::TargetReport::read(&record));
                black_box(cat023::ServiceMessage::read(&record));
                black_box(cat034::ServiceMessage::read(&record));
                black_box(cat048::TargetReport::read(&record));
                black_box(cat048::registers(&record).count());
                black_box(cat062::TrackMessage::read(&record));
                black_box(cat063::SensorMessage::read(&record));
                black_box(cat065::ServiceMessage::read(&record));
                read += 1;
            }
        });
        assert_eq!(read, 256, "{table}");
    }
}
