//! Once an array is prepared, measuring allocates nothing.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use locating::music::{AntennaArray, Music, MusicSettings, SimulatedArray, SimulatedWaves, Snapshots, SourceCount};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn measuring_allocates_nothing() {
    for antennas in [2, 8, 16] {
        let array = AntennaArray::circle(antennas, 0.4).expect("usable");
        let settings = MusicSettings {
            sources: SourceCount::Mdl,
            frequency_max_hz: 3e8,
            phase_sigma_rad: 0.01,
        };
        let mut music = Music::new(array, settings).expect("usable");
        let mut samples = Vec::new();
        for (run, frequency_hz) in [3e8, 3e8, 2e8].into_iter().enumerate() {
            let waves = SimulatedWaves::independent(&[1.0], 15.0, frequency_hz, 50);
            let simulated = SimulatedArray::new(music.array(), waves, 3).expect("usable");
            simulated.run(run as u64, &mut samples);
            let snapshots = Snapshots {
                samples: &samples,
                frequency_hz,
            };
            let bearings = assert_no_alloc(|| music.measure(&snapshots).map(|measured| measured.bearings.len()));
            assert!(bearings.expect("measured") >= 1);
        }
    }
}
