//! Blocks, tables and counters together.

use asterix::{Decoder, DecoderCounts, Error, Mode};

use crate::sample::{SAMPLE, block};

#[test]
fn an_error_ends_its_block_and_not_the_reading() {
    let good = [0x80, 0x00, 0x00];
    let bytes = [
        block(250, &[good, good].concat()),
        block(250, &[&good[..], &[0x40, 0x01]].concat()), // a good record, a truncated one
        block(99, &[1, 2, 3, 4]),                         // no table
        block(250, &good),
        vec![250, 0, 0, 0xFF], // no block
    ]
    .concat();
    let mut decoder = Decoder::new(Mode::Lenient).with_table(&SAMPLE);
    let all: Vec<_> = decoder
        .records(&bytes)
        .map(|record| record.map(|record| record.offset()))
        .collect();
    assert_eq!(
        all,
        [
            Ok(3),
            Ok(6),
            Ok(12),
            Err(Error::ItemTruncated {
                offset: 16,
                category: 250,
                item: "020",
                needed: 2,
                available: 1
            }),
            Err(Error::NoTable {
                offset: 17,
                category: 99
            }),
            Ok(27),
            Err(Error::BlockLength {
                offset: 30,
                category: 250,
                length: 0
            }),
        ]
    );
    let expected = DecoderCounts {
        blocks: 4,
        records: 4,
        blocks_refused: 1,
        blocks_without_table: 1,
        blocks_cut: 1,
        octets_skipped: 2 + 4 + 4,
        ..DecoderCounts::default()
    };
    assert_eq!(decoder.counts(), &expected);
    assert_eq!(decoder.counts().entries()[5].2, 10);
}

#[test]
fn extensions_beyond_the_edition_are_counted() {
    let beyond = [0x04, 0x0B, 0xFF, 0xFD, 0x03, 0x01, 0x00];
    let bytes = block(250, &[beyond, beyond].concat());
    let mut lenient = Decoder::new(Mode::Lenient).with_table(&SAMPLE);
    assert_eq!(lenient.records(&bytes).flatten().count(), 2);
    assert_eq!(
        (
            lenient.counts().records_extended,
            lenient.counts().unknown_extension_octets
        ),
        (2, 4)
    );
    let mut strict = Decoder::new(Mode::Strict).with_table(&SAMPLE);
    assert_eq!(strict.records(&bytes).flatten().count(), 0);
    assert_eq!((strict.counts().blocks_cut, strict.counts().octets_skipped), (1, 14));
}
