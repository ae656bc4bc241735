//! Targets that are reported seldom beside others that are reported often: one number each, shown as soon as they can
//! be, and no target made of misread addresses.

use std::collections::{BTreeMap, BTreeSet};

use test_support::Random;

use super::*;

/// What names a target.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Name {
    Address,
    Mmsi,
    /// The number of its sensor track alone.
    Number,
}

/// Time between two reports of a slow target, seconds.
#[derive(Clone, Copy, Debug)]
enum Gaps {
    Regular(f64),
    Between(f64, f64),
    /// Exponential, with this mean.
    Random(f64),
}

impl Gaps {
    fn draw(self, random: &mut Random) -> f64 {
        match self {
            Self::Regular(seconds) => seconds,
            Self::Between(least, most) => least + (most - least) * random.unit(),
            Self::Random(mean) => 1.0 - mean * (1.0 - random.unit()).ln(),
        }
    }
}

const QUICK: u32 = 4;
const SLOW: u32 = 4;
const QUICK_S: f64 = 5.0;

fn named(mut report: SensorTrack, name: Name, target: u32) -> SensorTrack {
    let identity = Identity::default();
    report.identity = match name {
        Name::Address => identity.with_address(0x4b_0000 + 977 * target),
        Name::Mmsi => identity.with_mmsi(211_000_000 + target),
        Name::Number => identity,
    };
    report
}

/// Times of the reports of all targets, in order.
fn schedule(gaps: Gaps, until_s: f64, random: &mut Random) -> Vec<(f64, u32)> {
    let mut times = Vec::new();
    for target in 0..QUICK + SLOW {
        let mut time_s = QUICK_S * random.unit();
        while time_s < until_s {
            times.push((time_s, target));
            time_s += if target < QUICK { QUICK_S } else { gaps.draw(random) };
        }
    }
    times.sort_by(|one, other| one.0.total_cmp(&other.0));
    times
}

/// What became of a target.
#[derive(Clone, Debug, Default)]
struct Fate {
    reports: u32,
    numbers: BTreeSet<u32>,
    /// Reports until it was confirmed.
    confirmed_by: Option<u32>,
}

/// Flies targets 10 km apart, each by its own velocity, and judges what became of the slow ones with three reports or
/// more.
fn judge(name: Name, gaps: Gaps, seed: u64, renumbers_s: f64) {
    let mut settings = test_settings(1);
    settings.sources[0].learns_period = true;
    let mut harness = Harness::new(settings);
    let random = &mut Random::new(seed);
    let speeds: Vec<[f64; 2]> = (0..QUICK + SLOW)
        .map(|_| [4.0 * (random.unit() - 0.5), 300.0 * (random.unit() - 0.5)])
        .collect();
    let mut fates = vec![Fate::default(); (QUICK + SLOW) as usize];
    for (time_s, target) in schedule(gaps, 1200.0, random) {
        let place = [10e3 * f64::from(target), 4.0 * (random.unit() - 0.5)];
        let number = target + 1 + if time_s > renumbers_s { 1000 } else { 0 };
        let one = named(report(0, number, time_s, place, speeds[target as usize]), name, target);
        let fate = &mut fates[target as usize];
        fate.reports += 1;
        // What time alone changes is published, too.
        if let Some(track) = harness.take(&one).filter(|track| track.trigger_source == 0) {
            fate.numbers.insert(track.track_number);
            if track.state == TrackState::Confirmed as u8 {
                fate.confirmed_by.get_or_insert(fate.reports);
            }
        }
    }
    // A number alone is no evidence: its source's reputation counts as for any other track.
    let most = if name == Name::Number { 6 } else { 2 };
    for fate in fates[QUICK as usize..].iter().filter(|fate| fate.reports >= 3) {
        let is_soon = fate.confirmed_by.is_some_and(|reports| reports <= most);
        assert!(fate.numbers.len() == 1 && is_soon, "{name:?} {gaps:?} {seed}: {fate:?}");
    }
    for fate in &fates[..QUICK as usize] {
        assert_eq!(fate.numbers.len(), 1, "{name:?} {gaps:?} {seed}: {fate:?}");
    }
}

#[test]
fn a_target_that_reports_slowly_among_quick_ones_is_shown_under_one_number() {
    for seed in 1..=6 {
        for name in [Name::Address, Name::Mmsi, Name::Number] {
            let regular = [20.0, 60.0, 180.0].map(Gaps::Regular);
            let irregular = [Gaps::Between(10.0, 200.0), Gaps::Random(20.0), Gaps::Random(60.0)];
            // Without an address, a long silence leaves too little to take a target for the former one.
            let most = if name == Name::Number { 1 } else { 3 };
            for gaps in regular.into_iter().chain(irregular.into_iter().take(most)) {
                judge(name, gaps, seed, f64::INFINITY);
            }
        }
    }
}

#[test]
fn a_source_that_numbers_its_tracks_anew_keeps_its_slow_targets() {
    for seed in 1..=6 {
        for gaps in [Gaps::Regular(40.0), Gaps::Between(10.0, 200.0)] {
            judge(Name::Address, gaps, seed, 600.0);
        }
    }
}

#[test]
fn a_slow_target_is_shown_between_its_reports_and_a_quick_one_no_longer_for_that() {
    let mut harness = Harness::new(test_settings(1));
    for second in 0..=600 {
        let time_s = f64::from(second);
        if second <= 300 {
            harness.take(&report(0, 1, time_s, [0.0, 0.0], [100.0, 0.0]));
        }
        if second <= 300 && second % 30 == 0 {
            harness.take(&with_address(
                report(0, 2, time_s, [0.0, 20e3], [100.0, 0.0]),
                0x40_0001,
            ));
        }
        harness.advance(time_s);
    }
    let changes = |number: u32| {
        let of_track = harness.published.iter().filter(|track| track.track_number == number);
        let mut states: Vec<(TrackState, i64)> = of_track
            .filter(|track| track.reference_time_ns >= 90 * S)
            .map(|track| (TrackState::from_code(track.state).unwrap(), track.reference_time_ns / S))
            .collect();
        states.dedup_by_key(|(state, _)| *state);
        states
    };
    use TrackState::{Coasted, Confirmed, Suspended, Terminated};
    // The quick one by its source's period, the slow one by its own.
    assert_eq!(
        changes(1),
        [(Confirmed, 90), (Coasted, 302), (Suspended, 320), (Terminated, 440)]
    );
    assert_eq!(changes(2), [(Confirmed, 90), (Coasted, 375), (Suspended, 420)]);
}

/// Reports of `targets` in scans of five seconds, one in fifty with a wrong bit in its address; how many tracks were
/// confirmed, and how many reports there were. The number at the source is that of the target, or goes with the address
/// as for plots.
fn garbled(seed: u64, goes_with_address: bool, jitter_s: f64) -> (usize, u32) {
    const TARGETS: u32 = 20;
    const SCANS: u32 = 500;
    let mut settings = test_settings(1);
    settings.sources[0].learns_period = true;
    settings.capacity.system_tracks = Some(2000);
    settings.capacity.sensor_tracks = Some(8000);
    let mut harness = Harness::new(settings);
    let random = &mut Random::new(seed);
    let mut reports = BTreeMap::new();
    for scan in 0..SCANS {
        for target in 0..TARGETS {
            let time_s = QUICK_S * (f64::from(scan) + f64::from(target) / 40.0) + jitter_s * random.unit();
            let mut address = 0x4b_0000 + 977 * target;
            if random.unit() < 0.02 {
                address ^= 1 << (24.0 * random.unit()) as u32;
            }
            let number = if goes_with_address { address } else { target };
            reports.insert((time_s * 1e6) as i64, (target, number, address));
        }
    }
    for (time_us, (target, number, address)) in &reports {
        let noise = [20.0 * (random.unit() - 0.5), 20.0 * (random.unit() - 0.5)];
        let place = [10e3 * f64::from(*target) + noise[0], noise[1]];
        let one = report(0, *number, *time_us as f64 / 1e6, place, [0.0, 100.0]);
        harness.take(&with_address(one, *address));
    }
    let shown = harness
        .published
        .iter()
        .filter(|track| track.state == TrackState::Confirmed as u8);
    let numbers: BTreeSet<u32> = shown.map(|track| track.track_number).collect();
    (numbers.len() - TARGETS as usize, TARGETS * SCANS)
}

#[test]
fn misread_addresses_make_no_targets() {
    for goes_with_address in [false, true] {
        for jitter_s in [0.0, 4.0] {
            let (mut wrong, mut reports) = (0, 0);
            for seed in 1..=4 {
                let run = garbled(seed, goes_with_address, jitter_s);
                (wrong, reports) = (wrong + run.0, reports + run.1);
            }
            let rate = wrong as f64 / f64::from(reports);
            assert!(rate <= 1e-4, "{wrong} of {reports}: {goes_with_address} {jitter_s}");
        }
    }
}

#[test]
fn two_targets_side_by_side_are_both_shown() {
    for (other, apart_m) in [(0x4b_0001, 300.0), (0x12_3456, 300.0), (0x12_3456, 20.0)] {
        let mut harness = Harness::new(test_settings(1));
        let mut shown = BTreeMap::new();
        for second in 0..12 {
            let time_s = f64::from(second);
            let pair = [
                with_address(report(0, 1, time_s, [0.0, 0.0], [0.0, 100.0]), 0x4b_0000),
                with_address(report(0, 2, time_s + 0.01, [apart_m, 0.0], [0.0, 100.0]), other),
            ];
            for (track, which) in pair.iter().zip(0..).filter(|(_, which)| *which == 0 || second >= 5) {
                let track = harness.take(track).map(|track| (track, which));
                if let Some((track, which)) = track.filter(|(track, _)| track.state == TrackState::Confirmed as u8) {
                    shown.entry(which).or_insert((track.track_number, second));
                }
            }
        }
        assert_eq!(shown.len(), 2, "{other:x} {apart_m}");
        assert!(shown[&1].1 <= 7, "{other:x} {apart_m}: {shown:?}");
    }
}
