//! Quality of a picture of tracks, second by second, against a known truth.
//!
//! At each whole second, the newest state of every track is moved to that second along its velocity and compared
//! with the targets of that second. The figures cover three aspects: the distance of the picture from the truth and
//! its causes ([`crate::gospa`]), the accuracy of the tracks paired with a target, and the continuity of each
//! target's track (pairs carried from second to second).
//!
//! What is not known is not compared. A second without any row of the truth is left out: a truth does not state whether
//! the sky was empty or nobody looked. If a target or a track has no height or no velocity, the pair is compared in the
//! rest. [`Compared`] states what remained.
//!
//! Limits: a target absent from the truth at a whole second does not exist in that second, if others do. Only numbers
//! distinguish tracks, so a file with the tracks of several sensors is not one picture.

use std::io::Read;

use csv_table::CsvError;
use messages::Covariance;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;
use thiserror::Error;

use crate::basis::FileBasis;
use crate::continuity::Continuity;
use crate::gospa::Metric;
use crate::normalised::{covariance_after, normalised_square};
use crate::states::{Instant, KinematicState, PictureSeries, StateFilter, StateRows, SteadyKnowledge, Walk, positions};
use crate::statistics::{mean, quantile, root_mean, standard_deviation};
use crate::words::Word;

/// Tolerance after a whole second within which a state counts for it, seconds: decimals in files are rounded.
const ROUNDING_S: f64 = 1e-9;
/// Maximum age of a row of truth at a whole second, seconds.
const TRUTH_AGE_MAX_S: f64 = 1e-3;
/// Columns that identify targets or tracks; the first in a file counts.
const IDS: [&str; 3] = ["target_id", "system_track_id", "sensor_track_id"];
/// The same for a truth: the tracks of a sensor are none.
const TRUTH_IDS: [&str; 2] = [IDS[0], IDS[1]];
/// Seconds after the begin of the truth that are not compared by default: sensors need several looks before tracks are
/// confirmed.
const BEGIN_S: i64 = 10;

/// Settings of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureSettings {
    /// Distance from which a track does not belong to a target, metres (500).
    pub cut_off_m: f64,
    /// Maximum age of a displayed state, seconds (1).
    pub age_max_s: f64,
    /// First whole second (10: sensors need several looks before tracks are confirmed).
    pub first_s: i64,
    /// Last whole second; if not given, the last second of the truth.
    pub last_s: Option<i64>,
    /// Distance up to which a target keeps its track, metres (250).
    pub gate_m: f64,
    /// Minimum speed in the plane of targets whose directions are compared, m/s (5).
    pub moving_mps: f64,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            cut_off_m: 500.0,
            age_max_s: 1.0,
            first_s: 10,
            last_s: None,
            gate_m: 250.0,
            moving_mps: 5.0,
        }
    }
}

/// States of targets or tracks by whole seconds.
#[derive(Clone, Debug)]
pub struct Timeline {
    age_max_s: f64,
    /// Whether a second without states is one of which nothing is known.
    has_gaps: bool,
    basis: FileBasis,
    pictures: PictureSeries<3>,
    /// Earliest time of any row.
    begin_s: Option<f64>,
    /// Rows that no whole second shows.
    between: u64,
    /// Latest time of any row.
    end_s: Option<f64>,
    /// Latest time of each track, for the rate of updates.
    updated_s: FxHashMap<i64, f64>,
    updates: u64,
    /// Number of updates after the previous state's display time, and the sum of the times since that state,
    /// seconds.
    late_updates: (u64, f64),
}

impl Timeline {
    /// Reads a truth file: `time_s,target_id,x,y,z,vx,vy,vz` by name; other columns are ignored. In place of x and y,
    /// a file may have `latitude,longitude`, degrees, with `height_m` above the ellipsoid; velocities are optional
    /// there. Times may count from 1970.
    ///
    /// # Errors
    /// If a column is missing, a value is invalid for its column, or the input fails.
    pub fn truth(input: impl Read) -> Result<Self, CsvError> {
        Self::truth_on(FileBasis::default(), input)
    }

    /// Reads a truth file on the basis of other tracks ([`Timeline::basis`]).
    ///
    /// # Errors
    /// As [`Timeline::truth`], and if the places of the files have no frame in common.
    pub fn truth_on(basis: FileBasis, input: impl Read) -> Result<Self, CsvError> {
        let mut timeline = Self::of_truth();
        timeline.basis = read_states((input, basis), (&TRUTH_IDS, IDS[0]), |state| timeline.keep(state))?;
        Ok(timeline)
    }

    /// Reads tracks with a display time of `age_max_s` seconds: columns as in a truth file, but with
    /// `system_track_id` or `sensor_track_id`. Rows with `state` `tentative`, `suspended` or `terminated` are
    /// omitted.
    ///
    /// # Errors
    /// As [`Timeline::truth`].
    pub fn tracks(input: impl Read, age_max_s: f64) -> Result<Self, CsvError> {
        Self::tracks_on(FileBasis::default(), input, age_max_s)
    }

    /// Reads tracks on a given basis.
    ///
    /// # Errors
    /// As [`Timeline::truth_on`].
    pub fn tracks_on(basis: FileBasis, input: impl Read, age_max_s: f64) -> Result<Self, CsvError> {
        let mut timeline = Self::empty(age_max_s);
        timeline.basis = read_states((input, basis), (&IDS, IDS[1]), |state| timeline.keep(state))?;
        Ok(timeline)
    }

    /// Returns the basis on which another file is read for a comparison with this one.
    pub fn basis(&self) -> FileBasis {
        self.basis.for_another(self.begin_s)
    }

    /// Creates an empty timeline of targets.
    pub(crate) fn of_truth() -> Self {
        Self {
            has_gaps: true,
            ..Self::empty(TRUTH_AGE_MAX_S)
        }
    }

    /// Reads the states of targets in the order of the rows; returns what they refer to.
    ///
    /// # Errors
    /// As [`Timeline::truth_on`].
    pub(crate) fn each_state(
        basis: FileBasis,
        input: impl Read,
        take: impl FnMut(KinematicState<3>),
    ) -> Result<FileBasis, CsvError> {
        read_states((input, basis), (&IDS, IDS[0]), take)
    }

    /// Replaces what the times and places refer to.
    pub(crate) fn with_basis(self, basis: FileBasis) -> Self {
        Self { basis, ..self }
    }

    /// Returns the first second that is compared with this truth by default: 10 s after its begin, or the begin of a
    /// truth that is no longer than that. `None` without rows.
    pub fn compared_from_s(&self) -> Option<i64> {
        let (first_s, last_s) = (self.first_second()?, self.last_second()?);
        let usual_s = first_s + BEGIN_S;
        Some(if usual_s <= last_s { usual_s } else { first_s })
    }

    /// Whether a second with these states can be compared.
    pub(crate) fn knows(&self, states: &[KinematicState<3>]) -> bool {
        !self.has_gaps || !states.is_empty()
    }

    /// Returns the first whole second with a displayed state; `None` if there is none.
    pub fn first_second(&self) -> Option<i64> {
        self.pictures.first()
    }

    /// Returns the last whole second reached by the rows; `None` without rows.
    pub fn last_second(&self) -> Option<i64> {
        self.end_s.map(|end_s| end_s.floor() as i64)
    }

    /// Checks that a picture of these tracks can show anything in the time of this truth.
    ///
    /// # Errors
    /// If both have rows, and no time in common.
    pub fn check_times(&self, tracks: &Self) -> Result<(), PictureError> {
        let span_s = |timeline: &Self| Some([timeline.begin_s?, timeline.end_s?]);
        let (Some(truth_s), Some(tracks_s)) = (span_s(self), span_s(tracks)) else {
            return Ok(());
        };
        let is_common = tracks_s[0] <= truth_s[1] && truth_s[0] <= tracks_s[1] + tracks.age_max_s;
        is_common
            .then_some(())
            .ok_or(PictureError::NoCommonTime { truth_s, tracks_s })
    }

    /// Returns the first and the last second of a comparison with this truth, the last one by default its end.
    ///
    /// # Errors
    /// If there is no second to compare.
    pub(crate) fn span(&self, first_s: i64, last_s: Option<i64>) -> Result<(i64, i64), PictureError> {
        let end_s = self.end_s.ok_or(PictureError::NoTruth)?;
        let last_s = last_s.unwrap_or(end_s as i64);
        match first_s <= last_s {
            true => Ok((first_s, last_s)),
            false => Err(PictureError::NoSecond { first_s, last_s }),
        }
    }

    /// Creates an empty timeline of tracks with a display time of `age_max_s` seconds.
    pub fn empty(age_max_s: f64) -> Self {
        Self {
            age_max_s,
            has_gaps: false,
            basis: FileBasis::default(),
            begin_s: None,
            between: 0,
            // Of two rows at one time, the later row counts.
            pictures: PictureSeries::new(|state, kept| state.time_s >= kept.time_s),
            end_s: None,
            updated_s: FxHashMap::default(),
            updates: 0,
            late_updates: (0, 0.0),
        }
    }

    /// Returns the mean time between two states of a track, seconds, if most states arrive after the display time
    /// of the previous state: live tracks are then missing from the pictures in between.
    pub fn period_of_gaps_s(&self) -> Option<f64> {
        let (late, sum_s) = self.late_updates;
        (2 * late > self.updates).then(|| sum_s / late as f64)
    }

    /// Adds a state, like a row of a file.
    pub fn add(&mut self, state: &ShownState) {
        let counted = KinematicState {
            id: state.number,
            time_s: state.time_s,
            position_m: state.position_m,
            velocity_mps: state.velocity_mps,
            covariance: Some(state.covariance),
            steady: SteadyKnowledge::default(),
            address: None,
            has_height: state.has_height,
            has_velocity: true,
        };
        self.keep(counted);
    }

    pub(crate) fn keep(&mut self, state: KinematicState<3>) {
        if let Some(before_s) = self.updated_s.insert(state.id, state.time_s) {
            let period_s = state.time_s - before_s;
            self.updates += 1;
            if period_s > self.age_max_s {
                self.late_updates = (self.late_updates.0 + 1, self.late_updates.1 + period_s);
            }
        }
        let second = first_whole_second(state.time_s);
        if is_fresh(state.time_s, second, self.age_max_s) {
            let seconds = second as f64 - state.time_s;
            let covariance = state.covariance.map(|stated| covariance_after(&stated, seconds));
            self.pictures.keep(second, KinematicState { covariance, ..state });
        } else {
            self.between += 1;
        }
        self.begin_s = Some(self.begin_s.map_or(state.time_s, |begin_s| begin_s.min(state.time_s)));
        self.end_s = Some(self.end_s.map_or(state.time_s, |end_s| end_s.max(state.time_s)));
    }
}

/// Reads states; the first of `ids` in the header identifies them. Returns what they refer to.
fn read_states(
    (input, basis): (impl Read, FileBasis),
    (ids, usual): (&[&'static str], &'static str),
    mut take: impl FnMut(KinematicState<3>),
) -> Result<FileBasis, CsvError> {
    let mut rows = StateRows::<_, 3>::new(input, ids, usual, StateFilter::NotUnconfirmed)?.on(basis);
    while let Some(state) = rows.next()? {
        take(state);
    }
    Ok(rows.basis())
}

/// State of a confirmed or coasted track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownState {
    /// Number of the track.
    pub number: i64,
    /// Time of the second, seconds.
    pub time_s: f64,
    /// Position east, north, up in the frame of the files, metres.
    pub position_m: [f64; 3],
    /// Velocity east, north, up, m/s.
    pub velocity_mps: [f64; 3],
    /// Covariance of position and velocity.
    pub covariance: Covariance,
    /// Whether the height is known.
    pub has_height: bool,
}

/// Returns the first whole second at which a state of `time_s` is visible.
pub(crate) fn first_whole_second(time_s: f64) -> Instant {
    let above = time_s.ceil();
    let just_missed = time_s <= above - 1.0 + ROUNDING_S;
    above as Instant - Instant::from(just_missed)
}

fn is_fresh(time_s: f64, second: Instant, age_max_s: f64) -> bool {
    time_s > second as f64 - age_max_s + ROUNDING_S
}

/// Reason why two files cannot be compared.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PictureError {
    /// The truth has no rows.
    #[error("the truth has no rows; nothing can be compared with it")]
    NoTruth,
    /// The compared interval contains no second.
    #[error("no whole second lies between {first_s} s, the first to be compared, and {last_s} s, the last")]
    NoSecond {
        /// The first second.
        first_s: i64,
        /// The last second.
        last_s: i64,
    },
    /// The truth has no row at any second of the interval.
    #[error(
        "the truth has no row at a whole second from {first_s} s to {last_s} s; rows at other times are compared with \
         --reference independent"
    )]
    NoTruthAt {
        /// The first second.
        first_s: i64,
        /// The last second.
        last_s: i64,
    },
    /// The tracks have other times than the truth.
    #[error(
        "the truth lasts from {} s to {} s, the tracks from {} s to {} s: no second is common to both",
        truth_s[0], truth_s[1], tracks_s[0], tracks_s[1]
    )]
    NoCommonTime {
        /// First and last time of the truth.
        truth_s: [f64; 2],
        /// First and last time of the tracks.
        tracks_s: [f64; 2],
    },
}

/// What a comparison had to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Compared {
    /// First whole second that was compared.
    pub first_s: i64,
    /// Last such second.
    pub last_s: i64,
    /// Number of compared seconds.
    pub seconds: u64,
    /// Seconds between the first and the last for which the truth has no row.
    pub seconds_without_truth: u64,
    /// Rows of the truth that are not at a whole second.
    pub truth_rows_between: u64,
    /// Number of targets.
    pub targets: u64,
    /// Number of their seconds.
    pub target_seconds: u64,
    /// Number of tracks.
    pub tracks: u64,
    /// Number of their seconds.
    pub track_seconds: u64,
    /// Tracks that are shown in other seconds only.
    pub tracks_elsewhere: u64,
    /// Targets and tracks that GOSPA pairs, over the seconds.
    pub pairs: u64,
    /// Pairs in which a height is not known: they are compared in the plane.
    pub pairs_without_height: u64,
    /// Pairs in which a velocity is not known.
    pub pairs_without_velocity: u64,
}

/// Quality of a picture. Averages are over seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureScore {
    /// Average GOSPA, metres.
    pub gospa: f64,
    /// Average part due to position errors, metres.
    pub loc: f64,
    /// Average part due to missed targets, metres.
    pub missed: f64,
    /// Average part due to false tracks, metres.
    #[serde(rename = "false")]
    pub false_tracks: f64,
    /// Average OSPA, metres.
    pub ospa: f64,
    /// Root mean square position error of the pairs, metres; `None` without any.
    pub rmse_pos: Option<f64>,
    /// Root mean square velocity error of the pairs, m/s.
    pub rmse_vel: Option<f64>,
    /// Number of changes of a target's track.
    pub id_switches: u64,
    /// Number of times that a target regained a track.
    pub breaks: u64,
    /// Share of the targets' seconds with a track, 0 to 1.
    pub completeness: f64,
    /// Tracks without a target for most of their time.
    pub spurious: u64,
    /// Total number of tracks.
    pub system_tracks: u64,
    /// 95th percentile of the second-to-second movements of the error, metres.
    pub wander_p95: Option<f64>,
    /// Maximum of these movements, metres.
    pub wander_max: Option<f64>,
    /// Standard deviation of the direction, degrees.
    pub direction_std_deg: Option<f64>,
    /// Mean number of targets without a track.
    pub missed_per_s: f64,
    /// Mean number of tracks without a target.
    pub false_per_s: f64,
    /// Mean normalised squared position error of the pairs, divided by its three dimensions; `None` if no track
    /// states a covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nees_pos: Option<f64>,
    /// What was compared.
    #[serde(skip)]
    pub compared: Compared,
}

/// Meanings of the words of a [`PictureScore`].
pub const PICTURE_WORDS: &[Word] = &[
    Word::new("gospa", "m", "distance between picture and truth, average over seconds"),
    Word::new("loc", "m", "its part from position errors"),
    Word::new("missed", "m", "its part from targets without a track"),
    Word::new("false", "m", "its part from tracks without a target"),
    Word::new("ospa", "m", "distance per target, average over seconds"),
    Word::new("rmse_pos", "m", "position error of the pairs"),
    Word::new("rmse_vel", "m/s", "velocity error of the pairs"),
    Word::new("id_switches", "", "times a target got another track"),
    Word::new("breaks", "", "times a target had lost its track and got one again"),
    Word::new("completeness", "", "share of the targets' seconds with a track"),
    Word::new("spurious", "", "tracks without a target for most of their seconds"),
    Word::new("system_tracks", "", "tracks in all"),
    Word::new("wander_p95", "m", "movement of the error from second to second, 95 %"),
    Word::new("wander_max", "m", "the largest such movement"),
    Word::new(
        "direction_std_deg",
        "deg",
        "direction of the velocity, standard deviation",
    ),
    Word::new("missed_per_s", "", "targets without a track, average over seconds"),
    Word::new("false_per_s", "", "tracks without a target, average over seconds"),
    Word::new(
        "nees_pos",
        "",
        "position error squared over the stated covariance: 1 if that is right, more if it is too small",
    ),
];

/// Compares tracks with the truth.
///
/// # Errors
/// If there is no second to compare.
pub fn score_picture(
    truth: &Timeline,
    tracks: &Timeline,
    settings: &PictureSettings,
) -> Result<PictureScore, PictureError> {
    let (first_s, last_s) = truth.span(settings.first_s, settings.last_s)?;
    let (mut targets, mut shown) = (TimelinePass::new(truth), TimelinePass::new(tracks));
    let mut sums = PictureSums::new(settings);
    for second in first_s..=last_s {
        let (targets, shown) = (targets.at(second), shown.at(second));
        match truth.knows(&targets) {
            true => sums.add(second, &targets, &shown),
            false => sums.pass_over(),
        }
    }
    if sums.compared.seconds == 0 {
        return Err(PictureError::NoTruthAt { first_s, last_s });
    }
    let mut score = sums.score();
    score.compared.truth_rows_between = if truth.has_gaps { truth.between } else { 0 };
    score.compared.tracks_elsewhere = (tracks.updated_s.len() as u64).saturating_sub(score.compared.tracks);
    Ok(score)
}

/// Pass through a timeline.
pub(crate) struct TimelinePass<'a> {
    walk: Walk<'a, 3>,
    age_max_s: f64,
}

impl<'a> TimelinePass<'a> {
    pub(crate) fn new(timeline: &'a Timeline) -> Self {
        Self {
            walk: timeline.pictures.walk(),
            age_max_s: timeline.age_max_s,
        }
    }

    /// Returns the states shown at `second`, moved to that time; calls must be in the order of seconds.
    pub(crate) fn at(&mut self, second: Instant) -> Vec<KinematicState<3>> {
        let age_max_s = self.age_max_s;
        self.walk
            .at(second, second as f64, |time_s| is_fresh(time_s, second, age_max_s))
    }
}

/// Sums over the seconds so far.
struct PictureSums {
    metric: Metric,
    /// By second: GOSPA, its three parts, and OSPA.
    distances_m: [Vec<f64>; 5],
    position_squares_m2: Vec<f64>,
    velocity_squares_m2ps2: Vec<f64>,
    normalised_squares: Vec<f64>,
    missed: Vec<f64>,
    false_tracks: Vec<f64>,
    continuity: Continuity,
    /// Targets so far.
    targets: FxHashSet<i64>,
    compared: Compared,
    /// Seconds without truth since the last compared second.
    passed: u64,
}

impl PictureSums {
    fn new(settings: &PictureSettings) -> Self {
        Self {
            metric: Metric {
                cut_off_m: settings.cut_off_m,
                power: 2,
            },
            distances_m: Default::default(),
            position_squares_m2: Vec::new(),
            velocity_squares_m2ps2: Vec::new(),
            normalised_squares: Vec::new(),
            missed: Vec::new(),
            false_tracks: Vec::new(),
            continuity: Continuity::new(settings.gate_m, settings.moving_mps),
            targets: FxHashSet::default(),
            compared: Compared::default(),
            passed: 0,
        }
    }

    /// Passes over a second without truth.
    fn pass_over(&mut self) {
        self.continuity.pause();
        // Those before the first compared second are not between.
        self.passed += u64::from(self.compared.seconds > 0);
    }

    fn add(&mut self, second: Instant, targets: &[KinematicState<3>], tracks: &[KinematicState<3>]) {
        let found = self.metric.compare(&positions(targets), &positions(tracks));
        let distances = [
            found.gospa_m(),
            found.localisation_m(),
            found.missed_m(),
            found.false_m(),
            found.ospa_m(),
        ];
        for (of_second, distance_m) in self.distances_m.iter_mut().zip(distances) {
            of_second.push(distance_m);
        }
        for pair in &found.pairs {
            let (target, track) = (&targets[pair.target], &tracks[pair.track]);
            self.position_squares_m2.push(pair.distance_m * pair.distance_m);
            let [have_height, have_velocity] = [
                target.has_height && track.has_height,
                target.has_velocity && track.has_velocity,
            ];
            if have_velocity {
                let mut apart = [0, 1, 2].map(|axis| track.velocity_mps[axis] - target.velocity_mps[axis]);
                if !have_height {
                    apart[2] = 0.0;
                }
                self.velocity_squares_m2ps2
                    .push(apart.iter().map(|speed| speed * speed).sum());
            }
            let [east, north, up] = [0, 1, 2].map(|axis| track.position_m[axis] - target.position_m[axis]);
            let square = track.covariance.as_ref().and_then(|covariance| match have_height {
                true => normalised_square([east, north, up], covariance, [0, 1, 2]),
                false => normalised_square([east, north], covariance, [0, 1]),
            });
            self.normalised_squares.extend(square);
            self.compared.pairs += 1;
            self.compared.pairs_without_height += u64::from(!have_height);
            self.compared.pairs_without_velocity += u64::from(!have_velocity);
        }
        self.note(second, targets, tracks);
        self.missed.push(found.missed as f64);
        self.false_tracks.push(found.false_tracks as f64);
        self.continuity.add(targets, tracks);
    }

    /// Records that a second was compared.
    fn note(&mut self, second: Instant, targets: &[KinematicState<3>], tracks: &[KinematicState<3>]) {
        let compared = &mut self.compared;
        if compared.seconds == 0 {
            compared.first_s = second;
        }
        compared.last_s = second;
        compared.seconds += 1;
        compared.seconds_without_truth += std::mem::take(&mut self.passed);
        compared.target_seconds += targets.len() as u64;
        compared.track_seconds += tracks.len() as u64;
        self.targets.extend(targets.iter().map(|target| target.id));
    }

    fn score(mut self) -> PictureScore {
        let average = |values: &[f64]| mean(values).unwrap_or(0.0);
        let [gospa, loc, missed, false_tracks, ospa] = self.distances_m.each_ref().map(|values| average(values));
        let found = &mut self.continuity.found;
        PictureScore {
            gospa,
            loc,
            missed,
            false_tracks,
            ospa,
            rmse_pos: root_mean(&self.position_squares_m2),
            rmse_vel: root_mean(&self.velocity_squares_m2ps2),
            id_switches: found.switches,
            breaks: found.breaks,
            completeness: found.covered as f64 / found.target_seconds.max(1) as f64,
            wander_p95: quantile(&mut found.wander_m, 0.95),
            wander_max: quantile(&mut found.wander_m, 1.0),
            direction_std_deg: standard_deviation(&found.angles_rad).map(f64::to_degrees),
            missed_per_s: average(&self.missed),
            false_per_s: average(&self.false_tracks),
            nees_pos: mean(&self.normalised_squares),
            spurious: self.continuity.spurious(),
            system_tracks: self.continuity.tracks(),
            compared: Compared {
                targets: self.targets.len() as u64,
                tracks: self.continuity.tracks(),
                ..self.compared
            },
        }
    }
}
