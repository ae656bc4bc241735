//! Cost of one record, decoding and encoding: items found, typed fields, named values, JSON, encoding.
//!
//! `cargo bench -p asterix --bench asterix`. Inputs are recordings of several sensors, held in memory, if present,
//! else radar reports made by the encoder. One element of the throughput is one record.

#[path = "../crates/asterix/tests/files/mod.rs"]
mod files;

use std::hint::black_box;
use std::time::Duration;

use asterix::categories::{CAT021_V0_23, CAT048_V1_31};
use asterix::{BlockWriter, Category, Decoder, Mode, NamedRecord, Record, Value, blocks};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use formats::observation;

const RECORDINGS: &[(&str, &str)] = &[
    ("cat010 radar", "lebl2016/160510-lebl-220001_SMR_cat10.ast"),
    ("cat010 multilateration", "lebl2016/160510-lebl-220001_MLAT_cat10.ast"),
    ("cat020 multilateration", "lebl2016/160510-lebl-220001_MLAT_cat20.ast"),
    ("cat021 ads-b", "lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast"),
    ("cat048 radar", "akapetanovic/Jahorina.raw"),
];

/// Number of blocks read from each recording: a hundredth of a second and more.
const BLOCKS: usize = 10_000;
/// Number of records made in the absence of recordings.
const RECORDS: u64 = 10_000;
/// Maximum size of a block in an Ethernet frame with headers of IPv4 and UDP, bytes.
const BLOCK_OCTETS_MAX: u16 = 1472;

fn asterix(criterion: &mut Criterion) {
    let recorded: Vec<(&str, Vec<u8>)> = RECORDINGS
        .iter()
        .filter_map(|(label, file)| Some((*label, first_blocks(&files::recording(file)?))))
        .collect();
    let sources = match recorded.is_empty() {
        true => vec![("made", made_blocks())],
        false => recorded,
    };
    for (label, bytes) in sources {
        let mut group = criterion.benchmark_group(format!("asterix/{label}"));
        group.sample_size(20).measurement_time(Duration::from_secs(3));
        decoding(&mut group, &bytes);
        encoding(&mut group, &bytes);
        group.finish();
    }
}

fn decoder() -> Decoder {
    Decoder::new(Mode::Lenient).with_table(&CAT021_V0_23) // the recording's edition
}

fn decoding(group: &mut BenchmarkGroup<'_, WallTime>, bytes: &[u8]) {
    let records = decoder().records(bytes).flatten().count();
    group.throughput(Throughput::Elements(records as u64));
    let mut measure = |way: &str, read: &mut dyn FnMut(&Record<'_>)| {
        group.bench_function(way, |bencher| {
            bencher.iter(|| decoder().records(bytes).flatten().for_each(|record| read(&record)));
        });
    };
    measure("items", &mut |record| {
        black_box(record);
    });
    measure("typed", &mut |record| {
        black_box(observation::read(record));
    });
    measure("named", &mut |record| {
        black_box(NamedRecord::new(record));
    });
    let mut line = Vec::new();
    measure("json", &mut |record| {
        line.clear();
        NamedRecord::new(record).write_json(&mut line);
        black_box(&line);
    });
}

fn encoding(group: &mut BenchmarkGroup<'_, WallTime>, bytes: &[u8]) {
    let mut octets = Vec::new();
    let records: Vec<(&Category, NamedRecord)> = decoder()
        .records(bytes)
        .flatten()
        .map(|record| (record.table(), NamedRecord::new(&record)))
        .filter(|(table, record)| record.encode(table, &mut octets).is_ok()) // texts may have codes without character
        .collect();
    group.throughput(Throughput::Elements(records.len() as u64));
    group.bench_function("encode", |bencher| {
        bencher.iter(|| {
            for (table, record) in &records {
                octets.clear();
                black_box(record.encode(table, &mut octets)).expect("encoded before");
            }
        });
    });
}

fn first_blocks(bytes: &[u8]) -> Vec<u8> {
    let end = blocks(bytes)
        .flatten()
        .take(BLOCKS)
        .map(|block| block.bytes.len())
        .sum();
    bytes[..end].to_vec()
}

fn made_blocks() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = BlockWriter::new(CAT048_V1_31.number, BLOCK_OCTETS_MAX);
    let mut octets = Vec::new();
    for number in 0..RECORDS {
        octets.clear();
        let record = radar_report(number);
        record.encode(&CAT048_V1_31, &mut octets).expect("values in range");
        bytes.extend(writer.push(&octets).expect("a short record").into_iter().flatten());
    }
    bytes.extend(writer.finish().into_iter().flatten());
    bytes
}

/// Track report of a Mode S radar, in the most common form.
fn radar_report(number: u64) -> NamedRecord {
    let flags = |names: &[&'static str]| names.iter().map(|name| (*name, 0u64.into())).collect::<Vec<_>>();
    let with = |names: &[&'static str], members: &[(&'static str, Value)]| {
        Value::group(flags(names).into_iter().chain(members.iter().cloned()))
    };
    let turn = number as f64 % 360.0;
    NamedRecord::of(
        CAT048_V1_31.number,
        [
            ("010", Value::group([("SAC", 25u64.into()), ("SIC", 1u64.into())])),
            ("140", (number as f64 / 128.0).into()),
            ("020", with(&["SIM", "RDP", "SPI", "RAB"], &[("TYP", 5u64.into())])),
            (
                "040",
                Value::group([("RHO", (turn / 4.0).into()), ("THETA", turn.into())]),
            ),
            ("070", with(&["V", "G", "L"], &[("MODE3A", "4321".into())])),
            ("090", with(&["V", "G"], &[("FL", 330.25.into())])),
            ("220", (0x3C_0000 + number % 500).into()),
            ("240", "KSK123  ".into()),
            ("161", Value::group([("TRN", (number % 4096).into())])),
            ("200", Value::group([("GSP", 0.125.into()), ("HDG", turn.into())])),
            ("170", with(&["CNF", "RAD", "DOU", "MAH", "CDM"], &[])),
        ],
    )
}

criterion_group!(benches, asterix);
criterion_main!(benches);
