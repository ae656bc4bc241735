//! After its construction the locator allocates nothing, whatever it is given; nor does measuring, once an array is
//! prepared.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use locating::music::{AntennaArray, Music, MusicSettings, SimulatedArray, SimulatedWaves, Snapshots, SourceCount};
use locating::selection::Select;
use locating::{Locator, Settings};
use observations::{Arrival, ArrivalTime, Bearing, ReadyFix, Receiver, ReceiverName};

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
        for step in 0..5_000 {
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

/// Arrivals of emitters that come and go, some of them late; now and then a reference emitter, and a fix.
#[test]
fn arrivals_and_fixes_allocate_nothing() {
    let mut settings = Settings {
        emitters_max: 20,
        ..Settings::default()
    };
    settings.association.silent_max_s = 5.0;
    let mut locator = Locator::new(settings).unwrap();
    let mut state = 4321;
    for step in 0..3_000i64 {
        let time_of_measurement_ns = step * 250_000_000;
        let emitter_id = (30.0 * random(&mut state)) as u32;
        let place = [1e3 * f64::from(emitter_id), 2e3];
        for (number, at) in [[-1e4, -1e4], [1e4, -1e4], [1e4, 1e4], [-1e4, 1e4]]
            .into_iter()
            .enumerate()
        {
            let way_m = f64::hypot(at[0] - place[0], at[1] - place[1]) + 60.0 * random(&mut state);
            let late_m = if random(&mut state) < 0.2 {
                2e4 * random(&mut state)
            } else {
                0.0
            };
            let arrival = Arrival {
                time_of_measurement_ns,
                emitter_id,
                time: ArrivalTime::At {
                    receiver: Receiver {
                        name: ReceiverName::new(["a", "b", "c", "d"][number]).unwrap(),
                        position_m: [at[0], at[1], 0.0],
                    },
                    t_s: step as f64 * 0.25 + (way_m + late_m) / 299_792_458.0,
                },
                sigma_s: 7e-8,
                reference_m: emitter_id.is_multiple_of(5).then_some([place[0], place[1], 0.0]),
            };
            assert_no_alloc(|| {
                while locator.complete(Some(time_of_measurement_ns)).is_some() {}
                let _ = locator.arrival(&arrival);
            });
        }
        let fix = ReadyFix {
            time_of_measurement_ns,
            emitter_id: 4,
            position_m: [4e3, 2e3, 0.0],
            covariance_m2: [1e4, 1e3, 2e4],
        };
        let _ = assert_no_alloc(|| locator.fix(&fix));
    }
    let counts = locator.counts();
    let happened = [
        counts.fixes,
        counts.references,
        counts.clock_unknown,
        counts.ready_fixes,
        counts.emitters_dropped,
    ];
    assert!(happened.iter().all(|count| *count > 0), "{counts:?}");
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
