//! Two addresses are two targets, however well their tracks agree.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::Sink;
use messages::{Decision, DecisionKind};

/// A kind of unique number.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Aircraft,
    Ship,
}

/// `report` with the unique number of target `target`.
fn numbered(mut report: SensorTrack, kind: Kind, target: u32) -> SensorTrack {
    report.identity = match kind {
        Kind::Aircraft => report.identity.with_address(0x40_0000 + target),
        Kind::Ship => report.identity.with_mmsi(211_000_000 + target),
    };
    report
}

/// What the engine hands out.
#[derive(Debug, Default)]
struct Record {
    tracks: Vec<SystemTrack>,
    merged: u32,
}

impl Sink for Record {
    fn track(&mut self, track: &SystemTrack) {
        self.tracks.push(*track);
    }

    fn decision(&mut self, decision: &Decision) {
        self.merged += u32::from(decision.kind == DecisionKind::Merged.code());
    }
}

impl Record {
    /// Numbers under which each unique number was shown.
    fn numbers(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut numbers: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for track in &self.tracks {
            if let Some(unique) = track.identity.unique_number() {
                let of_target = numbers.entry(unique.to_bits()).or_default();
                if !of_target.contains(&track.track_number) {
                    of_target.push(track.track_number);
                }
            }
        }
        numbers
    }
}

/// Settings under which nothing is learned of the sources.
fn settings(sources: usize) -> Settings {
    let mut settings = test_settings(sources);
    settings.consistency = false;
    settings.registration.enabled = false;
    settings
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Two targets, `apart_m` from each other, report their numbers through the first source. The second source has no
    /// numbers, and sees the younger one alone. While that one is silent, the second source begins anew: its track
    /// number is now that of the other target.
    #[test]
    fn a_number_that_a_sensor_gives_to_another_target_merges_none(
        apart_m in 100.0..900.0f64, course in 0.0..6.3f64, silent in 8..18i32, exchanged in 0..6i32, gap in 0..4i32,
        step_s in 0.3..1.0f64, kind in prop_oneof![Just(Kind::Aircraft), Just(Kind::Ship)],
    ) {
        let mut engine = Engine::new(settings(3)).unwrap();
        let mut record = Record::default();
        let velocity = [20.0 * course.cos(), 20.0 * course.sin()];
        let places = [[0.0, 0.0], [0.0, apart_m]];
        for scan in 0..50 {
            let time_s = step_s * f64::from(scan);
            for (target, place) in (0..).zip(places) {
                if target == 0 || !(15..15 + silent).contains(&scan) {
                    let said = report(0, target, time_s, place, velocity);
                    engine.take(&numbered(said, kind, target), &mut record);
                }
            }
            let begins = 15 + exchanged;
            if !(begins..begins + gap).contains(&scan) {
                let place = places[usize::from(scan < begins)];
                engine.take(&report(1, 7, time_s + 0.1, place, velocity), &mut record);
            }
        }
        prop_assert_eq!(record.merged, 0);
        for (unique, numbers) in record.numbers() {
            prop_assert_eq!(numbers.len(), 1, "{} was shown as {:?}", unique, numbers);
        }
    }

    /// The radar of the first target gives it a rare code, or call sign, which the second target has as well.
    #[test]
    fn a_name_that_two_addresses_share_merges_none(
        apart_m in 100.0..2_500.0f64, has_code in any::<bool>(),
        kind in prop_oneof![Just(Kind::Aircraft), Just(Kind::Ship)],
    ) {
        let mut engine = Engine::new(settings(4)).unwrap();
        let mut record = Record::default();
        let named = |mut report: SensorTrack| {
            report.identity = match has_code {
                true => report.identity.with_mode_3a(0o1234),
                false => report.identity.with_callsign(*b"KOS12   "),
            };
            report
        };
        for scan in 0..40 {
            let time_s = f64::from(scan);
            let velocity = [80.0, 0.0];
            let (here, there) = ([0.0, 0.0], [0.0, apart_m]);
            engine.take(&numbered(report(0, 1, time_s, here, velocity), kind, 1), &mut record);
            let seen = report(2, 7, time_s + 0.1, here, velocity);
            engine.take(&if scan < 8 { seen } else { named(seen) }, &mut record);
            engine.take(&named(numbered(report(1, 2, time_s + 0.2, there, velocity), kind, 2)), &mut record);
        }
        prop_assert_eq!(record.merged, 0);
        for (unique, numbers) in record.numbers() {
            prop_assert_eq!(numbers.len(), 1, "{} was shown as {:?}", unique, numbers);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// A sensor without numbers of its targets begins anew, after some scans, and gives its track numbers to other
    /// ones: no report of one target moves the track of another, and none is shown twice.
    #[test]
    fn numbers_from_before_a_restart_are_worth_nothing_where_the_position_is_another(
        apart_m in 400.0..5_000.0f64, turned_by in 1..5_u32, silent in 2..4i32, has_addresses in any::<bool>(),
    ) {
        const TARGETS: u32 = 5;
        let mut engine = Engine::new(settings(2)).unwrap();
        let mut record = Record::default();
        for scan in 0..50 {
            let time_s = f64::from(scan);
            for target in 0..TARGETS {
                let place = [0.0, apart_m * f64::from(target)];
                let said = report(0, target, time_s, place, [20.0, 0.0]);
                if !(20..20 + silent).contains(&scan) {
                    engine.take(&if has_addresses { numbered(said, Kind::Aircraft, target) } else { said }, &mut record);
                    let number = if scan < 20 { target } else { (target + turned_by) % TARGETS };
                    engine.take(&report(1, number, time_s + 0.3, place, [20.0, 0.0]), &mut record);
                }
            }
        }
        prop_assert_eq!(record.merged, 0);
        let numbers: std::collections::BTreeSet<u32> = record.tracks.iter().map(|track| track.track_number).collect();
        prop_assert_eq!(numbers.len(), TARGETS as usize, "{:?}", numbers);
        for track in &record.tracks {
            let [_, north, _] = track.position_m;
            let off_m = (north / apart_m - (north / apart_m).round()).abs() * apart_m;
            prop_assert!(off_m < 40.0, "{} at {north}", track.track_number);
        }
    }
}

#[test]
fn one_target_that_was_started_twice_is_merged_as_before() {
    for has_number in [[false, true], [true, false], [true, true]] {
        let mut engine = Engine::new(settings(3)).unwrap();
        let mut record = Record::default();
        for scan in 0..60 {
            let time_s = f64::from(scan);
            let away_m = (1_500.0 - 60.0 * time_s).max(0.0);
            for source in 0..2_u16 {
                let mut seen = report(source, 1, time_s + 0.3 * f64::from(source), [0.0, 0.0], [20.0, 0.0]);
                if source == 1 {
                    seen.position_m[1] += away_m;
                    seen.velocity_mps[1] -= if away_m > 0.0 { 60.0 } else { 0.0 };
                }
                // Both learn the same number once they have met.
                let knows = has_number[usize::from(source)] && (source == 0 || scan > 55);
                engine.take(
                    &if knows { numbered(seen, Kind::Aircraft, 1) } else { seen },
                    &mut record,
                );
            }
        }
        assert_eq!(record.merged, 1, "{has_number:?}");
    }
}
