//! After its construction the locator allocates nothing, whatever it is given; nor does measuring, once an array is
//! prepared.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use locating::music::{AntennaArray, Music, MusicSettings, SimulatedArray, SimulatedWaves, Snapshots, SourceCount};
use locating::selection::Select;
use locating::{Locator, Settings};
use observations::Bearing;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn random(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Emitters that come and go, labelled and not, seen from a platform that circles; now and then something impossible.
fn bearing(second: i64, state: &mut u64) -> Bearing {
    let emitter = (40.0 * random(state)) as u32;
    let angle = second as f64 / 40.0;
    let platform_m = [5e3 * angle.sin(), 5e3 * angle.cos(), 3e3];
    let place = [1e3 * f64::from(emitter) + 3.0 * second as f64, 20e3];
    let bearing_rad = (place[0] - platform_m[0]).atan2(place[1] - platform_m[1]) + 0.05 * (random(state) - 0.5);
    Bearing {
        time_of_measurement_ns: second * 1_000_000_000,
        emitter_id: (!emitter.is_multiple_of(3)).then_some(emitter),
        bearing_rad: if random(state) < 0.001 { f64::NAN } else { bearing_rad },
        sigma_rad: 0.02,
        platform_m,
        heading_rad: Some(angle + 1.57),
        frequency_hz: (emitter.is_multiple_of(6)).then_some(1e8 + 1e6 * f64::from(emitter)),
        pulse_interval_s: None,
    }
}

#[test]
fn bearings_allocate_nothing() {
    for select in Select::ALL {
        let mut settings = Settings {
            emitters_max: 20,
            ..Settings::default()
        };
        settings.selection.select = select;
        settings.association.silent_max_s = 15.0;
        settings.consistency.disagreement_max_s = 20.0;
        settings.consistency.disagreement_bearings = 5;
        let mut locator = Locator::new(settings).unwrap();
        let mut state = 12345;
        for step in 0..20_000 {
            let bearing = bearing(step / 8, &mut state);
            let _ = assert_no_alloc(|| locator.bearing(&bearing));
        }
        let counts = locator.counts();
        let happened = [
            counts.fixes,
            counts.table_full,
            counts.unusable,
            counts.emitters_dropped,
            counts.associated,
        ];
        assert!(happened.iter().all(|count| *count > 0), "{counts:?}");
    }
}

#[test]
fn measuring_allocates_nothing() {
    for antennas in [2, 8, 16] {
        let array = AntennaArray::circle(antennas, 0.4).expect("usable");
        let settings = MusicSettings {
            sources: SourceCount::Mdl,
            frequency_max_hz: 3e8,
            phase_sigma_rad: 0.01,
            paths: 1,
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
