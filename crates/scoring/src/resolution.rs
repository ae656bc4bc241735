//! Resolution of targets by a tracker: one confirmed track for each, at every scan.
//!
//! Two aircraft that fly side by side may give a single detection for minutes. A tracker with both hypotheses
//! should show two tracks soon after they separate, and one track while the number is ambiguous. The figures of a
//! run are:
//!
//! - the share of the truth's times with exactly as many confirmed tracks near targets as targets, each near a
//!   different target;
//! - the time until this is so, from a given time on;
//! - the tracks that were never near a target.
//!
//! Positions are compared in the plane. A track is displayed for four seconds after its newest row, moved along its
//! velocity. Figures of several runs are means over runs, so that every run has equal weight.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use csv_table::{CsvError, Table};
use serde::Serialize;
use thiserror::Error;

use crate::assignment::{CandidatePair, best_pairs};
use crate::near::near_pairs;
use crate::states::{Instant, KinematicState, PictureSeries, StateFilter, StateRows, positions};
use crate::statistics::mean;
use crate::words::Word;

/// Display time of a track after its newest row, seconds.
const AGE_MAX_S: f64 = 4.0;
/// Tolerance after a time within which a row counts for it, seconds: decimals in files are rounded.
const ROUNDING_S: f64 = 1e-6;
/// Decimals that distinguish times in a truth file.
const TIME_DECIMALS: usize = 3;
/// Decimals of shares.
const SHARE_DECIMALS: usize = 4;

/// Settings of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolutionSettings {
    /// Distance below which a track is near a target in the plane, metres (300).
    pub gate_m: f64,
    /// Time from which targets can be resolved, seconds (0).
    pub since_s: f64,
}

impl Default for ResolutionSettings {
    fn default() -> Self {
        Self {
            gate_m: 300.0,
            since_s: 0.0,
        }
    }
}

/// Positions of all targets at each time of a truth file.
#[derive(Clone, Debug)]
pub struct TargetsByTime {
    times_s: Vec<f64>,
    targets_m: Vec<Vec<[f64; 2]>>,
}

impl TargetsByTime {
    /// Reads a truth file: `time_s,x,y` by name, one row per target and time; other columns are ignored.
    ///
    /// # Errors
    /// If a column is missing, a value is invalid for its column, or the input fails.
    pub fn read(input: impl Read) -> Result<Self, CsvError> {
        let mut table = Table::new(input)?;
        let time = table.required("time_s")?;
        let place = table.all(["x", "y"])?;
        let mut by_time: BTreeMap<i64, (f64, Vec<[f64; 2]>)> = BTreeMap::new();
        while let Some(row) = table.next_row() {
            let row = row?;
            let time_s = rounded(row.time_s(time)?, TIME_DECIMALS);
            let key = (time_s * 10f64.powi(TIME_DECIMALS as i32)).round() as i64;
            let position_m = [row.number(place[0])?, row.number(place[1])?];
            by_time.entry(key).or_insert((time_s, Vec::new())).1.push(position_m);
        }
        let (times_s, targets_m) = by_time.into_values().unzip();
        Ok(Self { times_s, targets_m })
    }
}

/// Displayed tracks of a tracker, at the times of a truth.
#[derive(Clone, Debug)]
pub struct ConfirmedTracks {
    pictures: PictureSeries<2>,
}

impl ConfirmedTracks {
    /// Reads tracks: `time_s,sensor_track_id,x,y,vx,vy,state` by name (or `system_track_id`). Only rows with the state
    /// `confirmed` or `coasted` count.
    ///
    /// # Errors
    /// As [`TargetsByTime::read`].
    pub fn read(input: impl Read, truth: &TargetsByTime) -> Result<Self, CsvError> {
        let ids = ["sensor_track_id", "system_track_id"];
        let mut rows = StateRows::<_, 2>::new(input, &ids, ids[0], StateFilter::Confirmed)?;
        let mut tracks = Self {
            pictures: PictureSeries::new(supersedes),
        };
        let times_s = &truth.times_s;
        while let Some(state) = rows.next()? {
            let seen = times_s.partition_point(|time_s| time_s + ROUNDING_S <= state.time_s);
            tracks.pictures.keep(seen as Instant, state);
        }
        Ok(tracks)
    }
}

/// Whether a row replaces a stored row: the newer row wins. Of two rows at one time, greater values win, so that
/// the order in the file does not matter.
fn supersedes(state: &KinematicState<2>, kept: &KinematicState<2>) -> bool {
    let values = |state: &KinematicState<2>| {
        let ([x, y], [vx, vy]) = (state.position_m, state.velocity_mps);
        [state.time_s, x, y, vx, vy]
    };
    values(state) >= values(kept)
}

/// Error of a truth without scored times.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the truth has no row at or after {since_s} s, from when on tracks are to be scored")]
pub struct NoTruthSince {
    since_s: f64,
}

/// Figures of one run. Shares are rounded to four decimals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ResolutionScore {
    /// Share of times with exactly one track near each target and no surplus track, 0 to 1.
    pub count_right: f64,
    /// Share of times with a track for every target.
    pub covered: f64,
    /// Share of the targets with a track, averaged over times.
    pub target_share: f64,
    /// Time until all targets have a track at two successive times, seconds; the whole remaining time if this never
    /// occurs.
    pub delay_s: f64,
    /// Share of the earlier times with several tracks near targets; `None` without such times.
    pub several_before: Option<f64>,
    /// Tracks that were never near a target when shown at a time of the truth.
    pub false_tracks: u64,
    /// Number of tracks shown at a time of the truth.
    pub tracks: u64,
}

/// Figures of several runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PooledResolutionScore {
    /// Number of runs.
    pub runs: usize,
    /// Means over runs, not rounded; the tracks of all runs are summed.
    #[serde(flatten)]
    pub all: ResolutionScore,
    /// Longest delay, seconds.
    pub delay_max_s: f64,
    /// False tracks per run.
    pub false_tracks_per_run: f64,
    /// Figures of each run.
    pub each: Vec<ResolutionScore>,
}

/// Meanings of the words of a [`PooledResolutionScore`], including those of a [`ResolutionScore`].
pub const RESOLUTION_WORDS: &[Word] = &[
    Word::new("runs", "", "runs that are pooled"),
    Word::new(
        "count_right",
        "",
        "share of times with one track for each target and none to spare",
    ),
    Word::new("covered", "", "share of times with a track for every target"),
    Word::new("target_share", "", "share of targets with a track, average over times"),
    Word::new("delay_s", "s", "until all targets have a track for two times running"),
    Word::new("delay_max_s", "s", "the longest of the runs"),
    Word::new(
        "several_before",
        "",
        "share of earlier times with several tracks near targets",
    ),
    Word::new("false_tracks", "", "tracks that never were near a target"),
    Word::new("false_tracks_per_run", "", "the same, average over runs"),
    Word::new("tracks", "", "tracks in all"),
];

impl ResolutionScore {
    /// Scores one run.
    ///
    /// # Errors
    /// If the truth has no times to score.
    pub fn of_run(
        truth: &TargetsByTime,
        tracks: &ConfirmedTracks,
        settings: &ResolutionSettings,
    ) -> Result<Self, NoTruthSince> {
        let since_s = settings.since_s;
        let first = truth.times_s.partition_point(|time_s| *time_s < since_s);
        let Some(last_s) = truth.times_s[first..].last() else {
            return Err(NoTruthSince { since_s });
        };
        let mut found = ResolutionSums::default();
        let (mut walk, mut ever_shown, mut ever_near) = (tracks.pictures.walk(), BTreeSet::new(), BTreeSet::new());
        for (place, (&time_s, targets)) in truth.times_s.iter().zip(&truth.targets_m).enumerate() {
            let shown = walk.at(place as Instant, time_s, |of_s| time_s - of_s <= AGE_MAX_S);
            let near = Nearness::new(targets, &shown, settings.gate_m);
            ever_shown.extend(shown.iter().map(|track| track.id));
            ever_near.extend(near.tracks.iter().map(|track| shown[*track].id));
            if place < first {
                found.add_early(&near);
            } else {
                found.add(&near, targets.len(), time_s - since_s);
            }
        }
        let share = |part: f64, of: u64| rounded(part / of as f64, SHARE_DECIMALS);
        Ok(Self {
            count_right: share(found.right as f64, found.times),
            covered: share(found.covered as f64, found.times),
            target_share: share(found.shares, found.times),
            delay_s: found.delay_s.unwrap_or(last_s - since_s),
            several_before: (found.early > 0).then(|| share(found.early_several as f64, found.early)),
            false_tracks: (ever_shown.len() - ever_near.len()) as u64,
            tracks: ever_shown.len() as u64,
        })
    }

    /// Returns the pooled figures of several runs, and those of each run; `None` without runs.
    pub fn pooled(runs: &[Self]) -> Option<PooledResolutionScore> {
        let average = |figure: fn(&Self) -> f64| mean(&runs.iter().map(figure).collect::<Vec<_>>());
        let several: Vec<f64> = runs.iter().filter_map(|run| run.several_before).collect();
        let total = |count: fn(&Self) -> u64| runs.iter().map(count).sum::<u64>();
        let all = Self {
            count_right: average(|run| run.count_right)?,
            covered: average(|run| run.covered)?,
            target_share: average(|run| run.target_share)?,
            delay_s: average(|run| run.delay_s)?,
            several_before: mean(&several),
            false_tracks: total(|run| run.false_tracks),
            tracks: total(|run| run.tracks),
        };
        Some(PooledResolutionScore {
            runs: runs.len(),
            all,
            delay_max_s: runs.iter().map(|run| run.delay_s).fold(f64::NEG_INFINITY, f64::max),
            false_tracks_per_run: average(|run| run.false_tracks as f64)?,
            each: runs.to_vec(),
        })
    }
}

/// Sums over the times of one run so far.
#[derive(Clone, Copy, Debug, Default)]
struct ResolutionSums {
    /// Times with resolvable targets.
    times: u64,
    right: u64,
    covered: u64,
    /// Sum over those times of the share of covered targets.
    shares: f64,
    /// Earlier times, and the number of them with several tracks near targets.
    early: u64,
    early_several: u64,
    /// First of two successive times with all targets covered.
    delay_s: Option<f64>,
    /// Previous time, if all targets were covered then.
    covered_before_s: Option<f64>,
}

impl ResolutionSums {
    fn add_early(&mut self, near: &Nearness) {
        self.early += 1;
        self.early_several += u64::from(near.tracks.len() > 1);
    }

    /// Adds a time, `after_s` seconds after the targets become resolvable; `targets` is their number.
    fn add(&mut self, near: &Nearness, targets: usize, after_s: f64) {
        let covered = near.paired == targets;
        self.times += 1;
        self.covered += u64::from(covered);
        self.right += u64::from(covered && near.tracks.len() == targets);
        self.shares += near.paired as f64 / targets as f64;
        self.delay_s = self.delay_s.or(self.covered_before_s.filter(|_| covered));
        self.covered_before_s = covered.then_some(after_s);
    }
}

/// Nearness of tracks and targets at one time.
struct Nearness {
    /// Places of the tracks near any target.
    tracks: BTreeSet<usize>,
    /// Maximum number of targets with a separate track.
    paired: usize,
}

impl Nearness {
    fn new(targets: &[[f64; 2]], shown: &[KinematicState<2>], gate_m: f64) -> Self {
        let near = near_pairs(targets, &positions(shown), gate_m);
        // All pairs have equal gain, so the best sum has the most pairs.
        let candidates = near.iter().map(|pair| CandidatePair {
            row: pair.target,
            column: pair.track,
            gain: 1.0,
        });
        let pairs = best_pairs(targets.len(), shown.len(), &candidates.collect::<Vec<_>>());
        Self {
            tracks: near.iter().map(|pair| pair.track).collect(),
            paired: pairs.iter().flatten().count(),
        }
    }
}

/// Rounds `value` to the given number of decimals, as in its decimal text.
fn rounded(value: f64, decimals: usize) -> f64 {
    // The formatted text is a number.
    format!("{value:.decimals$}").parse().unwrap_or(value)
}
