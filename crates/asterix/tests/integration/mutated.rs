//! Blocks of recordings, damaged: bits flipped, lengths changed, ends cut off, halves of two blocks joined.
//!
//! Random bytes hardly ever get past the FSPEC; a recorded block with one wrong bit goes deep, and is what a bad line
//! or a wrong edition makes. Each mutation has a number and is made from that number alone, so one that fails can be
//! made again. `KOSEKI_MUTATIONS` sets how many there are:
//!
//! ```text
//! KOSEKI_MUTATIONS=3000000 cargo test --release -p asterix --test integration mutated
//! ```

use std::collections::BTreeMap;
use std::env;
use std::thread;

use asterix::{Block, Category, Mode, blocks, registry};
use test_support::{Dice, mutated};

use crate::{any_bytes, files};

/// Mutations where the environment does not say: a few seconds of testing.
const MUTATIONS: u64 = 100_000;

/// Recordings from which the blocks are taken; blocks of categories without a table are left out.
const RECORDINGS: &[&str] = &[
    "lebl2016/160510-lebl-220001_SMR_cat10.ast",
    "lebl2016/160510-lebl-220001_MLAT_cat10.ast",
    "lebl2016/160510-lebl-220001_MLAT_cat20.ast",
    "lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast",
    "akapetanovic/Jahorina.raw",
    "cro/cat048.raw",
    "cro/cat062cat065.raw",
    "cro/cat21_re.ast",
    "cro/cat_034_048.pcap",
    "cro/cat_062_065.pcap",
    "cro/asterix.pcap", // of an edition before 1.0
];

/// Number of blocks of each recording, spread over it.
const BLOCKS_PER_RECORDING: usize = 5000;

#[test]
fn damaged_recordings_are_read_to_their_end() {
    let recordings: Vec<Vec<u8>> = RECORDINGS.iter().filter_map(|name| files::recording(name)).collect();
    let sources: Vec<Block<'_>> = recordings.iter().flat_map(|bytes| some_blocks(bytes)).collect();
    if sources.is_empty() {
        return;
    }
    let mutations = env::var("KOSEKI_MUTATIONS").map_or(MUTATIONS, |number| number.parse().expect("a whole number"));
    let all: Vec<&[u8]> = sources.iter().map(|block| block.bytes).collect();
    let threads = thread::available_parallelism().map_or(1, usize::from) as u64;
    let mut totals = Totals::default();
    thread::scope(|scope| {
        let parts: Vec<_> = (0..threads)
            .map(|first| {
                let (sources, all) = (&sources, &all);
                scope.spawn(move || {
                    let mut totals = Totals::default();
                    (first..mutations)
                        .step_by(threads as usize)
                        .for_each(|number| check(sources, all, number, &mut totals));
                    totals
                })
            })
            .collect();
        for part in parts {
            totals.add(part.join().expect("a panic was shown above"));
        }
    });
    println!("{mutations} mutations: {totals:?}");
    assert_eq!(totals.mutations, mutations);
    assert!(totals.records > mutations / 4, "much of what is damaged stays readable");
    assert!(totals.errors.len() >= 8, "errors of many kinds are met");
}

fn some_blocks(bytes: &[u8]) -> impl Iterator<Item = Block<'_>> {
    let all: Vec<_> = blocks(bytes)
        .flatten()
        .filter(|block| table(block, 0).is_some())
        .collect();
    let step = (all.len() / BLOCKS_PER_RECORDING).max(1);
    all.into_iter().step_by(step)
}

/// Edition of the block's category.
fn table(block: &Block<'_>, choice: u64) -> Option<&'static Category> {
    let editions = registry::editions(block.category).count().max(1) as u64;
    registry::editions(block.category).nth((choice % editions) as usize)
}

/// Errors met, to see that the damage reaches everywhere.
#[derive(Debug, Default)]
struct Totals {
    mutations: u64,
    records: u64,
    /// Number of errors by the name of the kind.
    errors: BTreeMap<String, u64>,
}

impl Totals {
    fn add(&mut self, other: Totals) {
        self.mutations += other.mutations;
        self.records += other.records;
        for (kind, count) in other.errors {
            *self.errors.entry(kind).or_default() += count;
        }
    }
}

fn check(sources: &[Block<'_>], all: &[&[u8]], number: u64, totals: &mut Totals) {
    let mut random = Dice::new(number);
    let source = &sources[random.below(sources.len())];
    let table = table(source, random.bits()).expect("blocks with a table were chosen");
    let bytes = mutated(source.bytes, all, &mut random);
    let _shown = Shown {
        number,
        table,
        bytes: &bytes,
    };
    totals.mutations += 1;
    for mode in [Mode::Strict, Mode::Lenient] {
        let reading = any_bytes::check(table, mode, &bytes);
        totals.records += reading.counts.records;
        for error in reading.errors {
            let shown = format!("{error:?}");
            let kind = shown.split(' ').next().unwrap_or_default();
            *totals.errors.entry(kind.to_owned()).or_default() += 1;
        }
    }
}

/// Says which mutation it was if reading it panics.
struct Shown<'a> {
    number: u64,
    table: &'static Category,
    bytes: &'a [u8],
}

impl Drop for Shown<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            eprintln!("mutation {} read as {}: {:02x?}", self.number, self.table, self.bytes);
        }
    }
}
