//! How many records a second the two ways of decoding give, on one file of ASTERIX blocks held in memory.
//!
//! ```text
//! cargo run --release -p formats --example decode_speed -- FILE [CATEGORY=EDITION ...]
//! ```
//!
//! `21=0.23` reads category 021 with this edition's table instead of the default.

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::time::Instant;

use formats::asterix::typed::*;
use formats::asterix::{Category, Decoder, Mode, NamedRecord, Record, registry};
use formats::reports::observation;

/// Each way is timed as often as this; the fastest pass counts.
const PASSES: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, choices @ ..] = arguments.as_slice() else {
        return Err("usage: decode_speed FILE [CATEGORY=EDITION ...]".into());
    };
    let mut tables = Vec::new();
    for choice in choices {
        let (category, edition) = choice.split_once('=').ok_or("write CATEGORY=EDITION")?;
        tables.push(registry::find(category.parse()?, edition.parse()?).ok_or("no such table")?);
    }
    let bytes = fs::read(file)?;
    measure("items found", &bytes, &tables, |record| {
        black_box(record);
    });
    measure("typed", &bytes, &tables, read_typed);
    measure("observation", &bytes, &tables, |record| {
        black_box(observation::read(record));
    });
    measure("named", &bytes, &tables, |record| {
        black_box(NamedRecord::new(record));
    });
    let mut line = Vec::new();
    measure("named, JSON", &bytes, &tables, |record| {
        line.clear();
        NamedRecord::new(record).write_json(&mut line);
        black_box(&line);
    });
    Ok(())
}

fn read_typed(record: &Record<'_>) {
    macro_rules! read {
        ($read:expr) => {{
            black_box($read(record));
        }};
    }
    match record.table().number {
        1 => read!(cat001::TargetReport::read),
        2 => read!(cat002::ServiceMessage::read),
        10 => read!(cat010::TargetReport::read),
        19 => read!(cat019::ServiceMessage::read),
        20 => read!(cat020::TargetReport::read),
        21 if record.table().edition.major == 0 => read!(cat021_v0::TargetReport::read),
        21 => read!(cat021_v2::TargetReport::read),
        23 => read!(cat023::ServiceMessage::read),
        34 => read!(cat034::ServiceMessage::read),
        48 => read!(cat048::TargetReport::read),
        62 => read!(cat062::TrackMessage::read),
        63 => read!(cat063::SensorMessage::read),
        65 => read!(cat065::ServiceMessage::read),
        other => unreachable!("there is no table for category {other}"),
    }
}

fn measure(label: &str, bytes: &[u8], tables: &[&'static Category], mut read: impl FnMut(&Record<'_>)) {
    let mut fastest_s = f64::INFINITY;
    let mut records = 0;
    for _ in 0..PASSES {
        let mut decoder = Decoder::new(Mode::Lenient);
        for table in tables {
            decoder = decoder.with_table(table);
        }
        let begin = Instant::now();
        decoder.records(bytes).flatten().for_each(|record| read(&record));
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
        records = decoder.counts().records;
    }
    println!("{label:>12}: {:>12.0} records/s", records as f64 / fastest_s);
}
