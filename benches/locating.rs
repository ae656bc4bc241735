//! Cost of one bearing in the locator: all models, choice and selection, without any file or bus.
//!
//! `cargo bench -p koseki --bench locating`. A thousand emitters with ten bearings a second each are 10,000
//! bearings a second. The cost must not grow with the duration of reception.

use std::sync::atomic::AtomicU64;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use locating::settings::FilterChoice;
use locating::{EmitterMemory, Locator, Settings};
use observations::Bearing;

const PERIOD_NS: u64 = 100_000_000;
const SIGMA_RAD: f64 = 0.03;

/// Emitters on a grid 1 km apart, every other emitter moving, observed from an aircraft that circles around them.
fn bearing(next: u64, emitters: u64) -> Bearing {
    let (emitter, round) = (next % emitters, next / emitters);
    let second = (round * PERIOD_NS) as f64 * 1e-9;
    let drift = if emitter.is_multiple_of(2) { 0.0 } else { 3.0 * second };
    let place = [1e3 * (emitter % 32) as f64 + drift, 1e3 * (emitter / 32) as f64];
    let angle = second / 300.0;
    let platform = [16e3 + 30e3 * angle.sin(), 16e3 + 30e3 * angle.cos()];
    // Equivalent to noise for a filter: all errors of an emitter differ.
    let error = ((next.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33) as f64 / (1u64 << 30) as f64 - 1.0) * 1.7 * SIGMA_RAD;
    Bearing {
        time_of_measurement_ns: (round * PERIOD_NS) as i64,
        emitter_id: Some(emitter as u32),
        bearing_rad: (place[0] - platform[0]).atan2(place[1] - platform[1]) + error,
        sigma_rad: SIGMA_RAD,
        platform_m: [platform[0], platform[1], 3_000.0],
        heading_rad: Some(angle + std::f64::consts::FRAC_PI_2),
        frequency_hz: None,
        pulse_interval_s: None,
    }
}

fn per_bearing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("locator/bearing");
    group.throughput(Throughput::Elements(1));
    for filter in FilterChoice::ALL {
        for (emitters, seconds) in [(1, 20), (1_000, 20), (1_000, 300)] {
            let mut settings = Settings {
                emitters_max: emitters as usize,
                ..Settings::default()
            };
            settings.motion.filter = filter;
            let mut locator = Locator::new(settings).expect("sound settings");
            let mut next = 0u64;
            let mut one = |locator: &mut Locator| {
                let taken = locator.bearing(&bearing(next, emitters));
                next += 1;
                taken.expect("sound bearings").is_some()
            };
            for _ in 0..emitters * seconds * 10 {
                one(&mut locator);
            }
            let of = format!("{emitters} emitters after {seconds} s");
            group.bench_function(BenchmarkId::new(filter.word(), of), |bencher| {
                bencher.iter(|| one(&mut locator))
            });
        }
    }
    group.finish();
}

/// The same with each emitter kept for a successor of the process, as in a live adapter.
fn kept(criterion: &mut Criterion) {
    let (emitters, seconds) = (1_000, 20);
    let settings = Settings {
        emitters_max: emitters as usize,
        ..Settings::default()
    };
    let words = EmitterMemory::words(&settings);
    println!(
        "memory for each of {emitters} emitters: {} bytes",
        8 * words as u64 / emitters
    );
    let memory: Vec<AtomicU64> = (0..words).map(|_| AtomicU64::new(0)).collect();
    let mut memory = EmitterMemory::begin(Box::new(memory), "bench", &settings);
    let mut locator = Locator::new(settings).expect("sound settings");
    let mut next = 0u64;
    let mut one = |locator: &mut Locator| {
        let taken = locator.bearing(&bearing(next, emitters));
        locator.keep(&mut memory, next as i64);
        next += 1;
        taken.expect("sound bearings").is_some()
    };
    for _ in 0..emitters * seconds * 10 {
        one(&mut locator);
    }
    criterion.bench_function("locator/bearing/auto, kept", |bencher| {
        bencher.iter(|| one(&mut locator))
    });
}

criterion_group!(benches, per_bearing, kept);
criterion_main!(benches);
