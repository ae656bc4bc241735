//! Cost of one report in the engine: association, accuracy values, rule, combination, without any bus.
//!
//! `cargo bench -p koseki --bench engine`. The cost must not grow with the number of targets (PL-7). The second
//! group measures the cost of the checkpoint: two engines, with and without a checkpoint, take the same reports
//! alternately, a thousand each.

use std::sync::atomic::AtomicU64;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fusion::Engine;
use fusion::checkpoint::SourcePosition;
use fusion::settings::{Accuracy, AssociationSettings, Capacity, Settings, SourceSettings};
use messages::{Covariance, Identity, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use test_support::S;

const SOURCES: u16 = 4;

fn settings(targets: usize) -> Settings {
    let source = |number: u16| SourceSettings {
        priority: u32::from(number),
        ..SourceSettings::of(&format!("source{number}"), 1.0, Accuracy::constant(10.0))
    };
    Settings {
        capacity: Capacity {
            system_tracks: Some(2 * targets),
            sensor_tracks: Some(2 * targets * usize::from(SOURCES)),
            stored_reports: 8,
            ..Capacity::default()
        },
        association: AssociationSettings {
            cell_m: 1000.0,
            ..AssociationSettings::default()
        },
        ..Settings::of((0..SOURCES).map(source).collect())
    }
}

/// Targets on a grid 3 km apart, all moving; half of the sources report addresses.
fn report(source: u16, target: u32, side: u32, second: f64) -> SensorTrack {
    let (column, row) = (f64::from(target % side), f64::from(target / side));
    let velocity = [100.0 + column % 7.0, row % 11.0 - 5.0, 0.0];
    let offset = 8.0 * f64::from(source);
    let identity = Identity::default();
    SensorTrack {
        time_of_measurement_ns: (second * S as f64) as i64,
        source,
        track_number: target,
        valid: sensor_track_bits::VELOCITY | sensor_track_bits::HEIGHT,
        identity: if source.is_multiple_of(2) {
            identity.with_address(target)
        } else {
            identity
        },
        position_m: [
            3000.0 * column + velocity[0] * second + offset,
            3000.0 * row + velocity[1] * second,
            5000.0,
        ],
        velocity_mps: velocity,
        covariance: Covariance::diagonal([15.0, 15.0, 30.0], [3.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

fn per_report(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("engine/report");
    group.throughput(Throughput::Elements(1));
    for targets in [1_000u32, 10_000, 100_000] {
        let side = f64::from(targets).sqrt() as u32;
        let mut engine = Engine::new(settings(targets as usize)).expect("sound settings");
        let (mut next, mut published) = (0u64, 0u64);
        let mut one = |engine: &mut Engine| {
            // Sources take turns target by target; one second per round over all targets.
            let (source, target) = (
                (next % u64::from(SOURCES)) as u16,
                (next / u64::from(SOURCES)) % u64::from(targets),
            );
            let second = next as f64 / f64::from(targets) / f64::from(SOURCES);
            engine.take(&report(source, target as u32, side, second), &mut |_: &SystemTrack| {
                published += 1
            });
            next += 1;
        };
        for _ in 0..5 * targets * u32::from(SOURCES) {
            one(&mut engine);
        }
        group.bench_function(BenchmarkId::from_parameter(targets), |bencher| {
            bencher.iter(|| one(&mut engine))
        });
        assert!(published > u64::from(targets), "nothing was fused");
    }
    group.finish();
}

/// Prints the ratio of the times with and without a checkpoint, median of many pairs.
fn checkpoint(_: &mut Criterion) {
    const BLOCK: u64 = 1000;
    for targets in [1_000u32, 10_000] {
        let side = f64::from(targets).sqrt() as u32;
        let mut engines = [(); 2].map(|()| Engine::new(settings(targets as usize)).expect("sound settings"));
        let words = engines[0].checkpoint_layout().len();
        let memory: Vec<AtomicU64> = (0..words).map(|_| AtomicU64::new(0)).collect();
        engines[1].keep_checkpoint(Box::new(memory));
        let block = |engine: &mut Engine, from: u64, is_kept: bool| {
            let begun = Instant::now();
            for next in from..from + BLOCK {
                let (source, target) = (
                    (next % u64::from(SOURCES)) as u16,
                    (next / u64::from(SOURCES)) % u64::from(targets),
                );
                let second = next as f64 / f64::from(targets) / f64::from(SOURCES);
                if is_kept {
                    let position = SourcePosition {
                        incarnation: 1,
                        next_sequence: next,
                    };
                    engine.keep_position(source, position);
                }
                engine.take(&report(source, target as u32, side, second), &mut |_: &SystemTrack| {});
            }
            engine.keep_learned(if is_kept { 40 } else { 0 });
            begun.elapsed().as_secs_f64() * 1e9 / BLOCK as f64
        };
        let warm = u64::from(5 * targets * u32::from(SOURCES)) / BLOCK;
        let mut pairs: Vec<(f64, f64)> = Vec::new();
        for pair in 0..warm + 400 {
            let (without, with) = engines.split_at_mut(1);
            // The first run does not warm the caches for the second: each engine has its own tables.
            let mut run = |is_kept: bool| match is_kept {
                false => block(&mut without[0], pair * BLOCK, false),
                true => block(&mut with[0], pair * BLOCK, true),
            };
            let first = run(pair % 2 == 1);
            let second = run(pair % 2 == 0);
            if pair >= warm {
                pairs.push(if pair % 2 == 1 {
                    (second, first)
                } else {
                    (first, second)
                });
            }
        }
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        println!(
            "checkpoint, {targets} targets: {:.0} ns a report without, {:.0} with; ratio {:.3} (median of {} pairs); {} MB",
            median(pairs.iter().map(|pair| pair.0).collect()),
            median(pairs.iter().map(|pair| pair.1).collect()),
            median(pairs.iter().map(|pair| pair.1 / pair.0).collect()),
            pairs.len(),
            words * 8 / 1_000_000
        );
    }
}

criterion_group!(benches, per_report, checkpoint);
criterion_main!(benches);
