//! Cost of one set of array snapshots: covariance, eigen-decomposition, search and accuracy.
//!
//! `cargo bench -p locating --bench music`.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use locating::music::{AntennaArray, Music, MusicSettings, SimulatedArray, SimulatedWaves, Snapshots, SourceCount};

const FREQUENCY_HZ: f64 = 299_792_458.0;

fn per_measurement(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("music/measurement");
    for (name, antennas, array) in [
        ("line", 8, AntennaArray::line(8, 0.5)),
        ("circle", 5, AntennaArray::circle(5, 0.4)),
        ("circle", 16, AntennaArray::circle(16, 1.2)),
    ] {
        let settings = MusicSettings {
            sources: SourceCount::Mdl,
            frequency_max_hz: FREQUENCY_HZ,
            phase_sigma_rad: 0.01,
            paths: 1,
        };
        let mut music = Music::new(array.expect("usable"), settings).expect("usable");
        let waves = SimulatedWaves::independent(&[0.2, 1.0], 10.0, FREQUENCY_HZ, 100);
        let simulated = SimulatedArray::new(music.array(), waves, 1).expect("usable");
        let mut samples = Vec::new();
        simulated.run(0, &mut samples);
        let snapshots = Snapshots {
            samples: &samples,
            frequency_hz: FREQUENCY_HZ,
        };
        group.bench_function(BenchmarkId::new(name, antennas), |bencher| {
            bencher.iter(|| music.measure(&snapshots).expect("measured").bearings.len())
        });
    }
    group.finish();
}

criterion_group!(benches, per_measurement);
criterion_main!(benches);
