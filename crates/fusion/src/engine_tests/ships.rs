//! Ships that report who they are, among sensors that see them without knowing it.

use std::collections::BTreeMap;

use messages::{Identity, IdentityKind, SensorTrack, SystemTrack, TrackState};
use test_support::{Random, S};

use super::{Harness, report, with_address};
use crate::testing::test_settings;

const SHIPS: u32 = 30;

fn ship(target: u32) -> Identity {
    Identity::default()
        .with_mmsi(227_000_000 + 7_919 * target)
        .with_name(&format!("SHIP {target}"))
}

/// Reports of one source every `period_s` from `begin_s` to the end of the third minute, as `identity` names them.
fn reports(
    source: u16,
    (begin_s, period_s): (f64, f64),
    identity: impl Fn(u32) -> Identity,
    random: &mut Random,
) -> Vec<SensorTrack> {
    let mut all = Vec::new();
    for target in 0..SHIPS {
        let mut time_s = begin_s + 0.01 * f64::from(target);
        let heading = f64::from(target);
        let velocity = [8.0 * heading.cos(), 8.0 * heading.sin()];
        while time_s < 180.0 {
            let mut noise = || 10.0 * (random.unit() - 0.5);
            let place = [
                4e3 * f64::from(target % 6) + noise(),
                4e3 * f64::from(target / 6) + noise(),
            ];
            let mut one = report(source, target, time_s, place, velocity);
            one.identity = identity(target);
            all.push(one);
            time_s += period_s;
        }
    }
    all
}

/// The states at the end, by number, of all tracks that are shown.
fn shown(mut all: Vec<SensorTrack>, periods_s: [f64; 2]) -> (BTreeMap<u32, SystemTrack>, Harness) {
    let mut settings = test_settings(2);
    for (source, period_s) in settings.sources.iter_mut().zip(periods_s) {
        source.period_ns = (period_s * S as f64) as i64;
        source.fresh_ns = 3 * source.period_ns;
    }
    let mut harness = Harness::new(settings);
    all.sort_by_key(|one| one.time_of_measurement_ns);
    for one in &all {
        harness.take(one);
    }
    let latest: BTreeMap<u32, SystemTrack> = harness
        .published
        .iter()
        .map(|track| (track.track_number, *track))
        .collect();
    let is_live = |track: &SystemTrack| track.state == TrackState::Confirmed.code();
    (
        latest.into_iter().filter(|(_, track)| is_live(track)).collect(),
        harness,
    )
}

#[test]
fn ships_keep_mmsi_name_and_kind_when_a_radar_sees_them_too() {
    let radar = |_| Identity::default();
    for (periods_s, begins_s) in [
        ([6.0, 2.5], [0.0, 0.0]),
        ([10.0, 3.0], [40.0, 0.0]),
        ([2.0, 4.0], [0.0, 40.0]),
    ] {
        let mut random = Random::new(11);
        let mut all = reports(0, (begins_s[0], periods_s[0]), ship, &mut random);
        all.extend(reports(1, (begins_s[1], periods_s[1]), radar, &mut random));
        let (tracks, harness) = shown(all, periods_s);
        assert_eq!(tracks.len(), SHIPS as usize, "{periods_s:?}");
        let mut found: Vec<Identity> = tracks.values().map(|track| track.identity).collect();
        found.sort_by_key(|identity| identity.mmsi());
        let expected: Vec<Identity> = (0..SHIPS).map(ship).collect();
        assert_eq!(found, expected, "{periods_s:?}");
        let joint = tracks.values().filter(|track| track.contributions().len() == 2);
        assert_eq!(joint.count(), SHIPS as usize, "{periods_s:?}");
        assert_eq!(harness.count(messages::Counter::IdentityConflicts), 0);
        // Not even for a moment was one an aircraft, or another ship.
        let mut names: BTreeMap<u32, Identity> = BTreeMap::new();
        for track in &harness.published {
            assert_ne!(track.identity.kind, IdentityKind::Aircraft.code());
            if track.identity.mmsi().is_some() {
                let first = names.entry(track.track_number).or_insert(track.identity);
                assert_eq!(first.mmsi(), track.identity.mmsi());
            }
        }
    }
}

#[test]
fn a_ships_number_comes_with_the_first_report_that_has_it_and_a_changed_name_is_taken() {
    let mut harness = Harness::new(test_settings(2));
    let mut last = None;
    for step in 0..12 {
        let time_s = f64::from(step);
        let mut ais = report(0, 1, time_s, [0.0; 2], [5.0, 0.0]);
        if step > 3 {
            ais.identity = Identity::default().with_mmsi(2_275_400);
        }
        if step > 6 {
            ais.identity = ais.identity.with_name(if step > 8 { "NEW NAME" } else { "OLD NAME" });
        }
        harness.take(&ais);
        last = harness.take(&report(1, 1, time_s + 0.3, [5.0, 0.0], [5.0, 0.0]));
    }
    let identity = last.unwrap().identity;
    assert_eq!((identity.mmsi(), identity.name()), (Some(2_275_400), Some("NEW NAME")));
}

/// Two sources name one target by `numbers`, the second from the tenth second on; the tracks shown at the end.
fn named_twice(numbers: [Identity; 2], random: &mut Random) -> (Vec<Identity>, u64) {
    let begins_s = [0.0, 10.0];
    let mut all = Vec::new();
    for source in 0..2_u16 {
        let mut time_s = begins_s[usize::from(source)] + 0.3 * f64::from(source);
        while time_s < 90.0 {
            let mut noise = || 10.0 * (random.unit() - 0.5);
            let mut one = report(source, 5, time_s, [noise(), noise()], [60.0, 20.0]);
            one.identity = numbers[usize::from(source)];
            all.push(one);
            time_s += 1.0;
        }
    }
    let (tracks, harness) = shown(all, [1.0; 2]);
    let found = tracks.values().map(|track| track.identity).collect();
    (found, harness.count(messages::Counter::IdentityConflicts))
}

#[test]
fn a_rescue_aircraft_is_one_track_by_its_first_number_and_the_other_one_is_counted() {
    let mmsi = Identity::default().with_mmsi(111_227_506).with_name("RESCUE 6");
    let address = Identity::default().with_address(0x39_ab01).with_callsign(*b"SAR06   ");
    for numbers in [[mmsi, address], [address, mmsi]] {
        let (found, conflicts) = named_twice(numbers, &mut Random::new(3));
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!(one.unique_number(), numbers[0].unique_number());
        // What has a place beside the number is kept of both.
        assert_eq!((one.name(), one.callsign()), (Some("RESCUE 6"), Some("SAR06")));
        assert!(conflicts > 50, "{conflicts}");
    }
}

#[test]
fn an_aircraft_above_a_ship_is_another_target() {
    let ship = Identity::default().with_mmsi(227_000_000);
    let aircraft = Identity::default().with_address(0x87_bec0);
    let (found, _) = named_twice([ship, aircraft], &mut Random::new(4));
    let mut numbers: Vec<_> = found.iter().map(Identity::unique_number).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, [aircraft.unique_number(), ship.unique_number()]);
}

#[test]
fn two_ships_never_share_a_number_and_an_aircraft_of_the_same_digits_is_a_third() {
    let mut harness = Harness::new(test_settings(2));
    // By their low 24 bits all three would be one.
    let numbers = [227_000_000, 227_000_000 - (1 << 24)];
    for step in 0..20 {
        let time_s = f64::from(step);
        for (target, mmsi) in (1..).zip(numbers) {
            let place = [2e3 * f64::from(target), 0.0];
            let mut ais = report(0, target, time_s, place, [5.0, 0.0]);
            ais.identity = Identity::default().with_mmsi(mmsi);
            harness.take(&ais);
            harness.take(&report(1, target, time_s + 0.2, place, [5.0, 0.0]));
        }
        harness.take(&with_address(report(0, 3, time_s, [0.0; 2], [70.0, 0.0]), 227_000_000));
    }
    let latest: BTreeMap<u32, SystemTrack> = harness
        .published
        .iter()
        .map(|track| (track.track_number, *track))
        .collect();
    let found: Vec<_> = latest
        .values()
        .map(|track| (track.identity.mmsi(), track.identity.address()))
        .collect();
    assert_eq!(found.len(), 3, "{found:?}");
    for expected in [
        (Some(numbers[0]), None),
        (Some(numbers[1]), None),
        (None, Some(0x87_bec0)),
    ] {
        assert!(found.contains(&expected), "{found:?}");
    }
}
