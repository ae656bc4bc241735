//! Fusion judged by a sensor that it was not given.
//!
//! The Barcelona recordings have no truth, but three sensors that err independently. Fusion gets two of them; the third
//! says where the aircraft really were, within its own error. What is measured is the horizontal distance between the
//! report of the third and the system track with its address, interpolated to the time of that report, median and 95th
//! percentile. The third sensor's own error is in every figure, so they rank rules and say little about any one of
//! them.
//!
//! Aircraft are large: the radar sees the middle of the echo, the others antennas. Where radar reports are mixed in,
//! they move the track from one point of the aircraft to another; so the moments in which the radar contributes are
//! shown apart.

use std::collections::BTreeMap;
use std::path::Path;

use adapter::recorded_source::RecordedSource;
use configuration::Config;
use deployment::Input;
use fusion::smoothing::Trajectories;
use fusion::{Engine, FilterInput, Settings, Sink};
use messages::{FusionRule, SensorTrack, SystemTrack, TrackState};
use test_support::recordings;

use crate::common::{S, repository};

/// States of a system track are interpolated over no more than this.
const GAP_NS: i64 = 2 * S;
/// A report is used as truth if the standard deviation that it states itself is no more than this, metres per axis: for
/// ADS-B its best class, for multilateration where its dilution of precision is low.
const TRUTH_SIGMA_M: [f64; 3] = [0.0, 15.0, 40.0];
/// Aircraft are compared this near to the airport: farther out, multilateration is off by kilometres.
const NEAR_M: f64 = 10_000.0;
const RADAR: u16 = 0;
const MLAT: u16 = 1;
const ADSB: u16 = 2;

/// All reports in the order of their times, and the settings of `config/barcelona.toml`.
struct Recorded {
    settings: Settings,
    reports: Vec<SensorTrack>,
}

fn recorded(data: &Path) -> Recorded {
    let config = Config::read(&repository("config/barcelona.toml"), &[]).unwrap();
    let mut reports: Vec<SensorTrack> = Vec::new();
    for (source, reading) in config.sources.iter().zip(&config.readings.sources) {
        let Input::Recorded(recorded) = &source.input else {
            panic!("not recorded")
        };
        let bytes = std::fs::read(data.join(&recorded.file)).unwrap();
        reports.extend(RecordedSource::new(bytes, recorded, (source, reading), config.first_day_ns.unwrap()).unwrap());
    }
    reports.sort_by_key(|report| report.time_of_measurement_ns);
    Recorded {
        settings: config.engine,
        reports,
    }
}

/// Confirmed states of tracks with an address, and all that smoothing needs.
#[derive(Default)]
struct Collected {
    trajectories: Trajectories,
    states: Vec<SystemTrack>,
}

impl Sink for Collected {
    fn track(&mut self, track: &SystemTrack) {
        self.trajectories.state(track);
        if track.identity.address().is_some() && track.state == TrackState::Confirmed as u8 {
            self.states.push(*track);
        }
    }

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        self.trajectories.input(input);
    }
}

fn by_address<'a>(states: impl Iterator<Item = &'a SystemTrack>) -> BTreeMap<u32, Vec<SystemTrack>> {
    let mut tracks: BTreeMap<u32, Vec<SystemTrack>> = BTreeMap::new();
    for state in states {
        let address = state.identity.address().unwrap_or_default();
        tracks.entry(address).or_default().push(*state);
    }
    tracks
}

impl Recorded {
    /// The states of all confirmed system tracks with an address, by address, if fusion is given everything but
    /// `held_out`.
    fn fused_without(&self, held_out: u16, rule: FusionRule) -> BTreeMap<u32, Vec<SystemTrack>> {
        by_address(self.collected_without(held_out, rule).1.states.iter())
    }

    /// The same, smoothed with later reports, beside the states that were smoothed.
    fn smoothed_without(&self, held_out: u16) -> [BTreeMap<u32, Vec<SystemTrack>>; 2] {
        let (engine, collected) = self.collected_without(held_out, FusionRule::Auto);
        let Collected { trajectories, states } = collected;
        let smoothed = trajectories.smooth(&engine, |_| Ok::<(), ()>(())).unwrap();
        let after: Vec<SystemTrack> = states.iter().filter_map(|state| smoothed.of(state)).collect();
        [by_address(states.iter()), by_address(after.iter())]
    }

    fn collected_without(&self, held_out: u16, rule: FusionRule) -> (Engine, Collected) {
        let mut settings = self.settings.clone();
        settings.rule.name.0 = rule;
        if settings
            .registration
            .reference_source
            .as_ref()
            .is_some_and(|source| source.number == held_out)
        {
            settings.registration.reference_source = Some(if held_out == MLAT { ADSB } else { MLAT }.into());
        }
        let mut engine = Engine::new(settings).unwrap();
        let mut collected = Collected::default();
        for report in self.reports.iter().filter(|report| report.source != held_out) {
            engine.take(report, &mut collected);
        }
        (engine, collected)
    }

    /// The reports of one source that are good enough to judge by.
    fn truth(&self, source: u16) -> impl Iterator<Item = &SensorTrack> {
        let limit_m2 = TRUTH_SIGMA_M[usize::from(source)].powi(2);
        let good = move |report: &&SensorTrack| {
            let [x, y, _] = report.position_m;
            x.hypot(y) <= NEAR_M && (0..2).all(|axis| report.covariance.get(axis, axis) <= limit_m2)
        };
        let of_source = self.reports.iter().filter(move |report| report.source == source);
        of_source
            .filter(|report| report.state != TrackState::Terminated as u8)
            .filter(good)
    }
}

/// Distances in metres, in ascending order.
#[derive(Default)]
struct Distances(Vec<f64>);

impl Distances {
    fn percentile(&self, share: f64) -> f64 {
        let last = self.0.len().saturating_sub(1);
        self.0
            .get((share * last as f64).round() as usize)
            .copied()
            .unwrap_or(f64::NAN)
    }

    fn row(&self) -> String {
        format!(
            "{:>6} {:>6.1} {:>6.1}",
            self.0.len(),
            self.percentile(0.5),
            self.percentile(0.95)
        )
    }
}

/// Distances of system tracks from the reports of a held-out source: all of them, and those with the radar.
fn judge<'a>(
    tracks: &BTreeMap<u32, Vec<SystemTrack>>,
    truth: impl Iterator<Item = &'a SensorTrack>,
) -> (Distances, Distances) {
    let (mut all, mut with_radar) = (Distances::default(), Distances::default());
    for report in truth {
        let states = report.identity.address().and_then(|address| tracks.get(&address));
        let Some((metres, radar)) = states.and_then(|states| distance(states, report)) else {
            continue;
        };
        all.0.push(metres);
        if radar {
            with_radar.0.push(metres);
        }
    }
    all.0.sort_by(f64::total_cmp);
    with_radar.0.sort_by(f64::total_cmp);
    (all, with_radar)
}

/// How far the report is from the track, and whether the radar contributed to it then.
fn distance(states: &[SystemTrack], report: &SensorTrack) -> Option<(f64, bool)> {
    let now_ns = report.time_of_measurement_ns;
    let next = states.partition_point(|state| state.reference_time_ns <= now_ns);
    let (before, after) = (states.get(next.checked_sub(1)?)?, states.get(next)?);
    let span_ns = after.reference_time_ns - before.reference_time_ns;
    if span_ns > GAP_NS || before.track_number != after.track_number {
        return None;
    }
    let share = (now_ns - before.reference_time_ns) as f64 / span_ns as f64;
    let apart = |axis: usize| {
        let place = before.position_m[axis] + share * (after.position_m[axis] - before.position_m[axis]);
        report.position_m[axis] - place
    };
    let contributions = &before.contributions[..usize::from(before.contribution_count)];
    let radar = contributions
        .iter()
        .any(|contribution| contribution.source == RADAR && now_ns - contribution.time_of_measurement_ns <= 3 * S);
    Some((apart(0).hypot(apart(1)), radar))
}

/// The default rule keeps to aircraft that it sees through other sensors.
#[test]
fn the_default_rule_agrees_with_the_sensor_it_was_not_given() {
    let Some(data) = recordings("lebl2016") else { return };
    let recorded = recorded(&data);
    let rule = FusionRule::Auto;
    for (held_out, enough) in [(ADSB, 15_000), (MLAT, 2_000)] {
        let tracks = recorded.fused_without(held_out, rule);
        let (all, with_radar) = judge(&tracks, recorded.truth(held_out));
        println!(
            "without source {held_out}: {}, with radar {}",
            all.row(),
            with_radar.row()
        );
        assert!(all.0.len() > enough, "only {} comparisons", all.0.len());
        assert!(all.percentile(0.5) < 20.0, "{:.1} m", all.percentile(0.5));
        // On the ground, where an aircraft is as large as its distance from the next one.
        assert!(
            with_radar.0.len() > enough / 2,
            "the radar contributes to {} only",
            with_radar.0.len()
        );
        let p95_m = with_radar.percentile(0.95);
        assert!(p95_m < 45.0, "{p95_m:.1} m");
    }
}

/// Smoothed trajectories agree better with it than live tracks: their errors are smaller, its own remain.
/// `cargo test --release -p koseki --test integration smoothed_tracks_agree -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes without optimisation"]
fn smoothed_tracks_agree_better_with_the_sensor_they_were_not_given() {
    let Some(data) = recordings("lebl2016") else { return };
    let recorded = recorded(&data);
    let [before, after] = recorded
        .smoothed_without(ADSB)
        .map(|tracks| judge(&tracks, recorded.truth(ADSB)).0);
    println!("without ADS-B: {}, smoothed {}", before.row(), after.row());
    assert_eq!(before.0.len(), after.0.len());
    for share in [0.5, 0.95] {
        let [before_m, after_m] = [&before, &after].map(|distances| distances.percentile(share));
        assert!(after_m <= before_m, "{after_m:.1} m, before {before_m:.1} m");
    }
}

/// The same for every rule, as a table:
/// `cargo test --release -p koseki --test integration every_rule_agrees -- --ignored --nocapture`.
#[test]
#[ignore = "a table that is there to be read; the test above asserts what must hold"]
fn every_rule_agrees_more_or_less() {
    let Some(data) = recordings("lebl2016") else { return };
    let recorded = recorded(&data);
    println!("horizontal distance from the sensor that fusion was not given, metres: number, 50 %, 95 %");
    println!("{:<24}{:^42}{:^42}", "", "judged by ADS-B", "judged by multilateration");
    println!(
        "{:<24}{:^21}{:^21}{:^21}{:^21}",
        "rule", "all", "with radar", "all", "with radar"
    );
    for rule in FusionRule::ALL {
        let mut line = format!("{:<24}", rule.word());
        for held_out in [ADSB, MLAT] {
            let (all, with_radar) = judge(&recorded.fused_without(held_out, rule), recorded.truth(held_out));
            line.push_str(&format!("{} {} ", all.row(), with_radar.row()));
            assert!(all.percentile(0.5) < 50.0, "{}", rule.word());
        }
        println!("{line}");
    }
}
