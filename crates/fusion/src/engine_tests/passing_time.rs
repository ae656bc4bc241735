//! How often time is said to have passed changes nothing: reports and their times alone decide.

use messages::{Counters, Decision, FusionRule, SensorTrack, SystemTrack, TrackState};
use proptest::prelude::*;
use settings::Seconds;

use super::{S, random, report, with_address};
use crate::testing::test_settings;
use crate::{Engine, Settings, Sink};

const SOURCES: u16 = 3;
const TARGETS: u32 = 6;

/// Everything that an engine hands out, as text: an absent accuracy value is NaN, and NaN differs from itself.
#[derive(Default)]
struct HandedOut(Vec<String>);

impl Sink for HandedOut {
    fn track(&mut self, track: &SystemTrack) {
        self.0.push(format!("{track:?}"));
    }

    fn decision(&mut self, decision: &Decision) {
        self.0.push(format!("{decision:?}"));
    }
}

/// Reports in the order of their times. Every target falls silent at a source for some scans in a row, so that tracks
/// coast, end and start again; some reports are missing, extrapolated, or the last ones of their tracks; sources
/// renumber; one of them knows addresses.
fn traffic(seed: u64) -> Vec<SensorTrack> {
    let mut random = random(seed);
    let mut reports = Vec::new();
    for scan in 0..20 {
        for (source, target) in (0..SOURCES).flat_map(|source| (0..TARGETS).map(move |target| (source, target))) {
            let silent_from = (target * 5 + u32::from(source) * 3) % 15;
            let chance = 0.5 + random();
            if (silent_from..silent_from + 5).contains(&scan) || chance > 0.9 {
                continue;
            }
            let place = [600.0 * f64::from(target) + 30.0 * random(), 30.0 * random()];
            let time_s = f64::from(scan) + 0.9 * (0.5 + random());
            let mut report = report(source, target + 10 * (scan / 7), time_s, place, [30.0, 0.0]);
            report.state = match chance {
                ..0.7 => TrackState::Confirmed,
                ..0.85 => TrackState::Coasted,
                _ => TrackState::Terminated,
            } as u8;
            reports.push(match source {
                1 => with_address(report, 0x40_0000 + target),
                _ => report,
            });
        }
    }
    reports.sort_by_key(|report| (report.time_of_measurement_ns, report.source));
    reports
}

/// What an engine hands out, has counted and has learned, if before each report it is told of the times that `told`
/// yields for the time since the report before and until it.
fn run(
    settings: &Settings,
    reports: &[SensorTrack],
    mut told: impl FnMut(i64, i64) -> Vec<i64>,
) -> (Vec<String>, Counters, String) {
    let mut engine = Engine::new(settings.clone()).unwrap();
    let mut out = HandedOut::default();
    let mut latest_ns = reports.first().map_or(0, |report| report.time_of_measurement_ns - S);
    let end_ns = latest_ns + 60 * S;
    for report in reports {
        for time_ns in told(latest_ns, report.time_of_measurement_ns) {
            engine.advance(time_ns, &mut out);
        }
        latest_ns = report.time_of_measurement_ns;
        engine.take(report, &mut out);
    }
    for time_ns in told(latest_ns, end_ns) {
        engine.advance(time_ns, &mut out);
    }
    engine.advance(end_ns, &mut out);
    let learned = (0..SOURCES).map(|source| {
        (
            engine.sources().source_errors(source).copied(),
            engine.sources().covariance_scale(source),
        )
    });
    let learned = format!("{:?}", learned.collect::<Vec<_>>());
    (out.0, *engine.counts().total(), learned)
}

fn settings(rule: &str, scan_wait: f64, refresh_ns: Option<i64>, refresh_delay_ns: i64) -> Settings {
    let mut settings = test_settings(usize::from(SOURCES));
    settings.rule.name.0 = FusionRule::from_word(rule).unwrap();
    settings.association.scan_wait = scan_wait;
    settings.life.terminate_s = Some(Seconds::of_ns(3 * S));
    settings.life.tentative_s = Some(Seconds::of_ns(2 * S));
    settings.numbers.rest_s = Seconds::of_ns(8 * S);
    // A part of the table is more places than are looked at for one report.
    settings.capacity.sensor_tracks = Some(400);
    settings.refresh_s = refresh_ns.map(Seconds::of_ns);
    settings.refresh_delay_s = Seconds::of_ns(refresh_delay_ns);
    settings
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn time_that_is_said_to_pass_changes_nothing_that_reports_do_not(
        seed in any::<u64>(),
        rule in prop::sample::select(vec!["auto", "system-filter", "best-source"]),
        scan_wait in prop::sample::select(vec![0.0, 0.1, 0.5]),
        refresh_ns in prop::option::of(prop::sample::select(vec![S / 4, S])),
        refresh_delay_ns in prop::sample::select(vec![0, S / 3, 2 * S]),
        shares in prop::collection::vec(prop::collection::vec(-0.5f64..=1.0, 0..4), 1..50),
    ) {
        let settings = settings(rule, scan_wait, refresh_ns, refresh_delay_ns);
        let reports = traffic(seed);
        let plain = run(&settings, &reports, |_, _| Vec::new());
        let mut turn = shares.iter().cycle();
        let told = run(&settings, &reports, |since_ns, until_ns| {
            // Neither what has passed already nor the time of the very next report is anything new.
            let at = |share: &f64| since_ns + ((until_ns - since_ns) as f64 * share) as i64;
            turn.next().unwrap().iter().map(at).collect()
        });
        let differs = plain.0.iter().zip(&told.0).position(|(plain, told)| plain != told);
        let at = differs.unwrap_or(plain.0.len().min(told.0.len()));
        prop_assert_eq!(plain.0.get(at), told.0.get(at), "row {}", at);
        prop_assert_eq!(plain.1, told.1);
        prop_assert_eq!(plain.2, told.2);
    }
}

#[test]
fn a_deadline_centuries_ago_is_caught_up_with_at_once() {
    let mut settings = test_settings(2);
    settings.life.confirm_reports = 1;
    let mut harness = super::Harness::new(settings);
    harness.take(&report(0, 1, 10.0, [50e3, 0.0], [0.0, 0.0]));
    for (source, time_s) in [(0, -9e9), (1, 10.0)] {
        harness.take(&with_address(report(source, 2, time_s, [0.0; 2], [0.0; 2]), 0x40_0000));
    }
    assert_eq!(harness.live(), 2);
    harness.advance(11.0);
    assert_eq!(harness.live(), 2, "the second report keeps it alive");
    harness.advance(9e9);
    assert_eq!(harness.live(), 0);
}
