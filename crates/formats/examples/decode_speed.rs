//! How many records a second the two ways of decoding give, on one file of ASTERIX blocks held in memory.
//!
//! ```text
//! cargo run --release -p formats --example decode_speed -- FILE
//! ```

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::time::Instant;

use formats::asterix::categories::CAT021_V0_23;
use formats::asterix::typed::{cat010, cat019, cat020, cat021_v0_23};
use formats::asterix::{Decoder, Mode, NamedRecord, Record};

/// Each way is timed as often as this; the fastest pass counts.
const PASSES: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("usage: decode_speed FILE")?;
    let bytes = fs::read(file)?;
    measure("items found", &bytes, |record| {
        black_box(record);
    });
    measure("typed", &bytes, |record| match record.table().number {
        10 => {
            black_box(cat010::TargetReport::read(record));
        }
        19 => {
            black_box(cat019::ServiceMessage::read(record));
        }
        20 => {
            black_box(cat020::TargetReport::read(record));
        }
        _ => {
            black_box(cat021_v0_23::TargetReport::read(record));
        }
    });
    measure("named", &bytes, |record| {
        black_box(NamedRecord::new(record));
    });
    let mut line = Vec::new();
    measure("named, JSON", &bytes, |record| {
        line.clear();
        NamedRecord::new(record).write_json(&mut line);
        black_box(&line);
    });
    Ok(())
}

fn measure(label: &str, bytes: &[u8], mut read: impl FnMut(&Record<'_>)) {
    let mut fastest_s = f64::INFINITY;
    let mut records = 0;
    for _ in 0..PASSES {
        let mut decoder = Decoder::new(Mode::Lenient).with_table(&CAT021_V0_23);
        let begin = Instant::now();
        decoder.records(bytes).flatten().for_each(|record| read(&record));
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
        records = decoder.counts().records;
    }
    println!("{label:>12}: {:>12.0} records/s", records as f64 / fastest_s);
}
