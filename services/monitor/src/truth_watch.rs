//! Compares the picture with the truth, where the world is simulated.
//!
//! At every whole second of UTC, the latest arrived state of each system track is carried to that second along its
//! velocity. The result is compared with the targets that some configured sensor can see. A display would show the same
//! at that moment, delays and coasting included, which is harsher than comparing states at their own times.
//!
//! The first ten seconds are left out: radars need several turns until their targets are confirmed. If fusion is
//! restarted, the picture starts again empty, and targets missing until the picture is complete again do count.

use std::fmt;

use messages::SystemTrack;
use scoring::{AccuracyReport, AccuracySums, PictureTarget, PictureTrack};

use crate::display::tracks::LatestStates;

/// Time after the start that is left out.
pub(crate) const WARM_UP_NS: i64 = 10 * SECOND_NS;
const SECOND_NS: i64 = 1_000_000_000;

/// Targets of a simulated world, which the monitor compares the picture with.
#[derive(Debug)]
pub struct SimulatedTargets {
    /// Number of all targets.
    pub count: u32,
    /// Targets that some sensor can see; `None` where no sensor sees targets.
    pub visible: Option<VisibleAt>,
}

/// Adds the targets that some sensor can see at a time, seconds from the world's begin.
pub struct VisibleAt(pub Box<AddVisible>);

type AddVisible = dyn Fn(f64, &mut Vec<PictureTarget>);

impl fmt::Debug for VisibleAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("VisibleAt")
    }
}

/// Comparison of the picture with the truth, second by second.
#[derive(Debug)]
pub(crate) struct TruthWatch {
    visible: VisibleAt,
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
    /// Comparison with the targets of a world that begins at `start_ns` (UTC, nanoseconds), from `begun_utc_ns` on; at
    /// most `tracks_max` tracks are shown.
    pub(crate) fn new(visible: VisibleAt, (start_ns, begun_utc_ns): (i64, i64), tracks_max: usize) -> Self {
        Self {
            visible,
            start_ns,
            due_ns: begun_utc_ns.max(start_ns).saturating_add(WARM_UP_NS + SECOND_NS - 1) / SECOND_NS * SECOND_NS,
            states: LatestStates::new(tracks_max),
            accuracy: AccuracySums::default(),
            targets: Vec::new(),
            picture: Vec::new(),
        }
    }

    /// Takes received states; `is_another`: the publisher differs from the publisher of the states before.
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
        self.targets.clear();
        (self.visible.0)(time_s, &mut self.targets);
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
    use messages::TrackState;

    use super::*;

    const START_NS: i64 = 1_700_000_000 * SECOND_NS;
    /// Velocity of each target, metres per second.
    const VELOCITY_MPS: [f64; 3] = [100.0, 0.0, 0.0];

    /// Eight targets side by side, of which the sensors see the first four.
    fn targets(time_s: f64) -> Vec<PictureTarget> {
        let target = |id: u32| PictureTarget {
            id,
            position_m: [VELOCITY_MPS[0] * time_s, 1e4 * f64::from(id), 1e3],
            address: 0x40_0000 + id,
        };
        (0..8).map(target).collect()
    }

    fn watch() -> TruthWatch {
        let seen = |time_s, seen: &mut Vec<PictureTarget>| seen.extend(targets(time_s).into_iter().take(4));
        TruthWatch::new(VisibleAt(Box::new(seen)), (START_NS, START_NS + 1), 100)
    }

    /// Confirmed states of every target at a time, a second old.
    fn perfect(at_ns: i64) -> Vec<SystemTrack> {
        let time_s = (at_ns - START_NS) as f64 / SECOND_NS as f64;
        let state = |target: PictureTarget| SystemTrack {
            reference_time_ns: at_ns,
            track_number: target.id + 1,
            position_m: target.position_m,
            velocity_mps: VELOCITY_MPS,
            velocity_valid: 1,
            identity: messages::Identity::default().with_address(target.address),
            state: TrackState::Confirmed as u8,
            ..SystemTrack::default()
        };
        targets(time_s).into_iter().map(state).collect()
    }

    #[test]
    fn a_perfect_picture_is_found_perfect_and_the_warm_up_is_left_out() {
        let mut watch = watch();
        watch.pass(START_NS + WARM_UP_NS);
        assert_eq!(watch.report().pictures, 0, "begun a moment after the whole second");
        let at_ns = START_NS + WARM_UP_NS + SECOND_NS;
        let states = perfect(at_ns - 300_000_000);
        watch.take(true, &states[..4]);
        watch.pass(at_ns + 4_000_000);
        let report = watch.report();
        assert_eq!((report.pictures, report.held_once_share, report.targets), (1, 1.0, 4.0));
        assert!(report.max_m < 2.0, "carried to the whole second: {report:?}");
        watch.pass(at_ns + 5_000_000);
        assert_eq!(watch.report().pictures, 1, "once a second");
    }

    #[test]
    fn what_is_not_shown_is_missed_and_what_nobody_can_see_is_left_out() {
        let mut watch = watch();
        watch.pass(START_NS + 20 * SECOND_NS);
        let report = watch.report();
        assert_eq!((report.targets, report.missed_share), (4.0, 1.0));
    }
}
