//! Compares the picture with the truth, where the world is simulated.
//!
//! At every whole second of UTC, the latest state of each system track that has arrived by then is carried to that
//! second along its velocity, and held against the targets that some configured sensor can see. That is what a display
//! would show at that moment, delays and coasting included, which is harsher than comparing states at their own times.
//!
//! The first ten seconds are left out: radars need several turns until their targets are confirmed. If fusion is
//! restarted, its picture begins anew, and what is missing until it is complete again does count.

use deployment::{Deployment, Input, Instrument};
use messages::SystemTrack;
use runtime::Options;
use scenario::{SimulatedSensor, TargetState, Truth};
use scoring::{AccuracyReport, AccuracySums, PictureTarget, PictureTrack};

use crate::display::tracks::LatestStates;

/// Time after the start that is left out.
pub(crate) const WARM_UP_NS: i64 = 10 * SECOND_NS;
const SECOND_NS: i64 = 1_000_000_000;

/// Comparison of the picture with the truth, second by second.
#[derive(Debug)]
pub(crate) struct TruthWatch {
    truth: Truth,
    sensors: Vec<SimulatedSensor>,
    start_ns: i64,
    /// The whole second that is to be compared next, UTC.
    due_ns: i64,
    /// Latest states; as many as fusion can hold.
    states: LatestStates,
    accuracy: AccuracySums,
    targets: Vec<PictureTarget>,
    picture: Vec<PictureTrack>,
}

impl TruthWatch {
    /// `None` if no source is simulated.
    ///
    /// # Errors
    /// If the simulated world cannot be made; a checked configuration rules that out.
    pub(crate) fn new(config: &Deployment, options: &Options, begun_utc_ns: i64) -> anyhow::Result<Option<Self>> {
        let start_ns = options.scenario_start_ns;
        let mut sensors = Vec::new();
        for source in &config.sources {
            // What is only heard of is no part of the picture that has to be complete.
            if let Input::Simulated(simulated) = &source.input
                && let Instrument::Sensor(settings) = &simulated.instrument
            {
                sensors.push(SimulatedSensor::new(settings, options.seed, source.number, start_ns)?);
            }
        }
        let Some(world) = config.scenario.as_ref().filter(|_| !sensors.is_empty()) else {
            return Ok(None);
        };
        Ok(Some(Self {
            truth: Truth::new(world, options.seed)?.round(config.frame),
            sensors,
            start_ns,
            due_ns: begun_utc_ns.max(start_ns).saturating_add(WARM_UP_NS + SECOND_NS - 1) / SECOND_NS * SECOND_NS,
            states: LatestStates::new(config.system_tracks.max),
            accuracy: AccuracySums::default(),
            targets: Vec::new(),
            picture: Vec::new(),
        }))
    }

    /// Takes received states; `is_another`: their publisher is not that of the states before.
    pub(crate) fn take(&mut self, is_another: bool, tracks: &[SystemTrack]) {
        if is_another {
            self.states.clear();
        }
        tracks.iter().for_each(|track| self.states.keep(track));
    }

    /// Compares, if a whole second has passed by `now_utc_ns`. Of several, only the last: the states are of now.
    pub(crate) fn pass(&mut self, now_utc_ns: i64) {
        if now_utc_ns < self.due_ns {
            return;
        }
        let second_ns = now_utc_ns / SECOND_NS * SECOND_NS;
        self.due_ns = second_ns + SECOND_NS;
        let time_s = (second_ns - self.start_ns) as f64 / SECOND_NS as f64;
        let sensors = &self.sensors;
        let in_view = |target: &TargetState| sensors.iter().any(|sensor| sensor.observes(target));
        self.targets.clear();
        let seen = self.truth.at(time_s).filter(in_view);
        self.targets.extend(seen.map(|target| PictureTarget {
            id: target.id,
            position_m: target.position_m,
            address: target.address,
        }));
        self.picture.clear();
        let shown = self
            .states
            .iter()
            .filter_map(|track| PictureTrack::from_system_track(track, second_ns));
        self.picture.extend(shown);
        self.accuracy.add_picture(&self.targets, &self.picture);
    }

    /// When the next comparison is due, UTC, nanoseconds.
    pub(crate) fn due_ns(&self) -> i64 {
        self.due_ns
    }

    pub(crate) fn report(&self) -> AccuracyReport {
        self.accuracy.report()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use configuration::{BUILT_IN_DEMO, Config};
    use messages::TrackState;
    use runtime::Speed;

    use super::*;

    const START_NS: i64 = 1_700_000_000 * SECOND_NS;

    fn options() -> Options {
        Options {
            overrides: Vec::new(),
            instance: "test".to_owned(),
            data: "data".into(),
            out: "out".into(),
            speed: Speed::Factor(1.0),
            seed: 3,
            scenario_start_ns: START_NS,
            launcher: None,
        }
    }

    fn watch(overrides: &[&str]) -> TruthWatch {
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        let config = Config::read(Path::new(BUILT_IN_DEMO), &overrides).unwrap();
        TruthWatch::new(&config, &options(), START_NS + 1).unwrap().unwrap()
    }

    /// Confirmed states of every target at a time, one second old.
    fn perfect(watch: &TruthWatch, at_ns: i64) -> Vec<SystemTrack> {
        let time_s = (at_ns - START_NS) as f64 / SECOND_NS as f64;
        let state = |target: TargetState| SystemTrack {
            reference_time_ns: at_ns,
            track_number: target.id + 1,
            position_m: target.position_m,
            velocity_mps: target.velocity_mps,
            identity: messages::Identity::default().with_address(target.address),
            state: TrackState::Confirmed as u8,
            ..SystemTrack::default()
        };
        watch.truth.at(time_s).map(state).collect()
    }

    #[test]
    fn a_perfect_picture_is_found_perfect_and_the_warm_up_is_left_out() {
        let mut watch = watch(&[]);
        watch.pass(START_NS + WARM_UP_NS);
        assert_eq!(watch.report().pictures, 0, "begun a moment after the whole second");
        let at_ns = START_NS + WARM_UP_NS + SECOND_NS;
        let states = perfect(&watch, at_ns - 300_000_000);
        watch.take(true, &states);
        watch.pass(at_ns + 4_000_000);
        let report = watch.report();
        assert_eq!(
            (report.pictures, report.held_once_share, report.targets),
            (1, 1.0, 80.0)
        );
        assert!(report.max_m < 2.0, "carried to the whole second: {report:?}");
        watch.pass(at_ns + 5_000_000);
        assert_eq!(watch.report().pictures, 1, "once a second");
    }

    #[test]
    fn targets_that_nobody_can_see_are_left_out() {
        // Only the radars, which see nothing below 300 m.
        let mut watch = watch(&["source[2].simulated.range_max_m=1", "source[3].simulated.range_max_m=1"]);
        watch.pass(START_NS + 20 * SECOND_NS);
        let report = watch.report();
        assert!(report.targets > 20.0 && report.targets < 65.0, "{report:?}");
        assert_eq!(report.missed_share, 1.0);
    }
}
