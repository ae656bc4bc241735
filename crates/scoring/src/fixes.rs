//! Quality of the fixes of a bearings-only locator, in three scripted cases.
//!
//! Bearings of one emitter from a moving platform determine its position, but slowly, and biased bearings bias the
//! position. The cases cover the difficulties: the use of the available information ([`FixCase::Fixed`], compared
//! with the Cramér–Rao bound), a moving emitter ([`FixCase::Drop`]), and wrong bearings while the platform turns
//! ([`FixCase::Turn`]). Each row contains two fixes: the output, after selection and prediction, and the raw fix of
//! the filter.
//!
//! A case has many runs, one per emitter, with different noise. Several files of one case are pooled: their runs
//! count together.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;

use csv_table::{CsvError, Table};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::bound::{BroadsideBound, straight_bound_m};
use crate::near::distance;
use crate::statistics::{circular_deviation, mean, root_mean, standard_deviation};
use crate::words::Word;

/// Time from which the platform of case `turn` has flown long enough for a first fix, seconds.
const TURN_SINCE_S: f64 = 500.0;
/// Number of rows between samples of the fixes' motion.
const MOTION_ROWS: usize = 10;
/// Minimum speed of fixes with a direction, m/s.
const STILL_MPS: f64 = 1e-9;

/// Scripted case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FixCase {
    /// Emitter 50 km broadside of a straight baseline; 61 bearings along the baseline.
    Fixed,
    /// An aircraft drops a transmitter and flies ellipses of 8 by 4 km at 100 m/s, with a bearing of 2° every 2 s
    /// for 3,600 s. The transmitter drifts straight at 4 m/s to 060°.
    Drop,
    /// The aircraft flies past a fixed transmitter, turns by 180° with wrong bearings during the turn, and flies
    /// back.
    Turn,
}

/// Description beside a case's files: the case and its settings.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct CaseSettings {
    /// Scripted case.
    pub case: FixCase,
    /// Length of the baseline of case `fixed`, metres.
    #[serde(rename = "baseline")]
    pub baseline_m: f64,
    /// Standard deviation of its bearings, degrees.
    pub sigma_deg: f64,
    /// Number of emitters.
    pub runs: u64,
}

impl CaseSettings {
    /// Whether runs of both can be pooled: the bound of case `fixed` belongs to one geometry.
    fn poolable_with(&self, other: &Self) -> bool {
        let geometry = |of: &Self| (of.case == FixCase::Fixed).then_some((of.baseline_m, of.sigma_deg));
        self.case == other.case && geometry(self) == geometry(other)
    }
}

impl fmt::Display for CaseSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            baseline_m, sigma_deg, ..
        } = self;
        match self.case {
            FixCase::Fixed => write!(f, "case fixed, baseline {baseline_m} m, sigma {sigma_deg} deg"),
            FixCase::Drop => write!(f, "case drop"),
            FixCase::Turn => write!(f, "case turn"),
        }
    }
}

/// Reason why fixes cannot be scored.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FixError {
    /// No fix has a known time and emitter.
    #[error("no fix has the time and the emitter of any row of the truth; are both of the same case?")]
    NoFix,
    /// No emitter has fixes in the scored time.
    #[error("no emitter has two fixes at or after {since_s} s, from when on fixes are scored")]
    NoLateFix {
        /// Start of the scored time, seconds.
        since_s: f64,
    },
    /// The settings describe no geometry with a bound.
    #[error(
        "bearings with sigma_deg = {sigma_deg} along a baseline of {baseline_m} m fix no emitter; both must be positive"
    )]
    NoBound {
        /// Length of the baseline, metres.
        baseline_m: f64,
        /// Standard deviation of the bearings, degrees.
        sigma_deg: f64,
    },
}

/// Runs of one case, with their fixes.
#[derive(Clone, Debug)]
pub struct FixRuns {
    settings: CaseSettings,
    runs: Vec<Vec<ScoredFix>>,
}

/// Row of fixes, with the truth of its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ScoredFix {
    time_s: f64,
    truth_m: [f64; 2],
    output_m: [f64; 2],
    raw_m: [f64; 2],
    velocity_mps: [f64; 2],
}

impl ScoredFix {
    fn values(&self) -> [f64; 9] {
        let ([a, b], [c, d], [e, f], [g, h]) = (self.truth_m, self.output_m, self.raw_m, self.velocity_mps);
        [self.time_s, a, b, c, d, e, f, g, h]
    }
}

/// Figures of a case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FixScore {
    /// Emitters with a fix.
    pub runs: u64,
    /// Emitters without a fix.
    pub runs_without_fix: i64,
    /// Emitters whose fixes end before the scored time; the other figures exclude them.
    #[serde(skip_serializing_if = "is_zero")]
    pub runs_too_short: u64,
    /// The other figures.
    #[serde(flatten)]
    pub figures: FixFigures,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Figures that depend on the case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum FixFigures {
    /// Figures of case `fixed`.
    Broadside(BroadsideFigures),
    /// Figures of the cases `drop` and `turn`.
    Course(CourseFigures),
}

/// Errors of the last raw fixes in case `fixed`, and the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BroadsideFigures {
    /// Root mean square error along the line of sight, metres.
    pub range_rmse: f64,
    /// Lowest possible value of the previous figure, metres.
    pub range_bound: f64,
    /// Root mean square error across the line of sight, metres.
    pub cross_rmse: f64,
    /// Lowest possible value of the previous figure, metres.
    pub cross_bound: f64,
    /// Error over bound.
    pub range_ratio: f64,
    /// Error over bound.
    pub cross_ratio: f64,
}

/// Errors over the scored time of the cases `drop` (its second half) and `turn` (from 500 s on).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CourseFigures {
    /// Root mean square error of the output, metres.
    pub rmse: f64,
    /// … of the raw fixes.
    pub raw_rmse: f64,
    /// Root mean square error of the last output, metres.
    #[serde(rename = "final")]
    pub last: f64,
    /// … of the last raw fix.
    #[serde(rename = "raw_final")]
    pub raw_last: f64,
    /// Largest step of the output beyond its own velocity, metres.
    pub jump_m: f64,
    /// Standard deviation of the output's speed over ten rows, m/s, average over runs; `None` if all runs are
    /// shorter.
    pub speed_spread: Option<f64>,
    /// … of the raw fixes'.
    pub raw_speed_spread: Option<f64>,
    /// Standard deviation of the direction of the output's motion over ten rows, degrees, average over runs.
    pub direction_spread_deg: Option<f64>,
    /// … of the raw fixes'.
    pub raw_direction_spread_deg: Option<f64>,
    /// Case `drop`: lowest possible root mean square error at the end, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub straight_bound: Option<f64>,
}

/// Meanings of the words of a [`FixScore`].
pub const FIX_WORDS: &[Word] = &[
    Word::new("runs", "", "emitters with a fix"),
    Word::new("runs_without_fix", "", "emitters without any"),
    Word::new(
        "runs_too_short",
        "",
        "emitters whose fixes end before the time that counts",
    ),
    Word::new("range_rmse", "m", "last raw fix, error along the line of sight"),
    Word::new("range_bound", "m", "its Cramér-Rao bound"),
    Word::new("cross_rmse", "m", "last raw fix, error across the line of sight"),
    Word::new("cross_bound", "m", "its Cramér-Rao bound"),
    Word::new("range_ratio", "", "error over bound, along"),
    Word::new("cross_ratio", "", "error over bound, across"),
    Word::new("rmse", "m", "error of the output"),
    Word::new("raw_rmse", "m", "error of the raw fixes"),
    Word::new("final", "m", "error of the last output"),
    Word::new("raw_final", "m", "error of the last raw fix"),
    Word::new("jump_m", "m", "largest step of the output beyond its own velocity"),
    Word::new("speed_spread", "m/s", "spread of the output's speed over ten rows"),
    Word::new(
        "raw_speed_spread",
        "m/s",
        "spread of the raw fixes' speed over ten rows",
    ),
    Word::new(
        "direction_spread_deg",
        "deg",
        "spread of the output's direction over ten rows",
    ),
    Word::new(
        "raw_direction_spread_deg",
        "deg",
        "spread of the raw fixes' direction over ten rows",
    ),
    Word::new(
        "straight_bound",
        "m",
        "final error at best, if the motion is known to be straight",
    ),
];

impl FixRuns {
    /// Creates an empty set of runs of the case in `settings`.
    pub fn new(settings: CaseSettings) -> Self {
        Self {
            settings: CaseSettings { runs: 0, ..settings },
            runs: Vec::new(),
        }
    }

    /// Adds the emitters of one set of files: their settings, their truth (`time_s,emitter_id,x,y` by name) and
    /// their fixes (`time_s,emitter_id,x,y,raw_x,raw_y,vx,vy`). Fixes of times or emitters absent from the truth
    /// are omitted.
    ///
    /// # Errors
    /// The fault, and the input that has it.
    pub fn add(&mut self, settings: &CaseSettings, truth: impl Read, fixes: impl Read) -> Result<(), FixInputError> {
        if !self.settings.poolable_with(settings) {
            return Err(FixInputError::Settings {
                found: *settings,
                expected: self.settings,
            });
        }
        let truth = EmitterTruth::read(truth).map_err(FixInputError::Truth)?;
        let runs = truth.runs(fixes).map_err(FixInputError::Fixes)?;
        self.settings.runs += settings.runs;
        self.runs.extend(runs);
        Ok(())
    }

    /// Returns the figures of all runs.
    ///
    /// # Errors
    /// If there are no fixes to score.
    pub fn score(&self) -> Result<FixScore, FixError> {
        if self.runs.is_empty() {
            return Err(FixError::NoFix);
        }
        let runs = self.runs.len() as u64;
        let (figures, scored) = match self.settings.case {
            FixCase::Fixed => (FixFigures::Broadside(self.broadside()?), runs),
            FixCase::Drop | FixCase::Turn => self.course()?,
        };
        Ok(FixScore {
            runs,
            runs_without_fix: self.settings.runs as i64 - runs as i64,
            runs_too_short: runs - scored,
            figures,
        })
    }

    fn broadside(&self) -> Result<BroadsideFigures, FixError> {
        let CaseSettings {
            baseline_m, sigma_deg, ..
        } = self.settings;
        let bound = (baseline_m > 0.0 && sigma_deg > 0.0)
            .then(|| BroadsideBound::new(baseline_m, sigma_deg.to_radians()))
            .flatten()
            .ok_or(FixError::NoBound { baseline_m, sigma_deg })?;
        let last = self.runs.iter().filter_map(|run| run.last());
        let squares = |axis: usize| -> Vec<f64> {
            let square = |fix: &ScoredFix| (fix.raw_m[axis] - fix.truth_m[axis]).powi(2);
            last.clone().map(square).collect()
        };
        let rmse = |axis: usize| root_mean(&squares(axis)).ok_or(FixError::NoFix);
        let (cross_rmse, range_rmse) = (rmse(0)?, rmse(1)?);
        Ok(BroadsideFigures {
            range_rmse,
            range_bound: bound.range_m,
            cross_rmse,
            cross_bound: bound.cross_m,
            range_ratio: range_rmse / bound.range_m,
            cross_ratio: cross_rmse / bound.cross_m,
        })
    }

    /// Returns the figures of the scored time, and the number of runs in them.
    fn course(&self) -> Result<(FixFigures, u64), FixError> {
        let ends_s = self.runs.iter().filter_map(|run| run.last()).map(|fix| fix.time_s);
        let since_s = match self.settings.case {
            FixCase::Turn => TURN_SINCE_S,
            FixCase::Fixed | FixCase::Drop => ends_s.fold(f64::NEG_INFINITY, f64::max) / 2.0,
        };
        let late = |run: &Vec<ScoredFix>| run.partition_point(|fix| fix.time_s < since_s);
        let late: Vec<&[ScoredFix]> = self
            .runs
            .iter()
            .map(|run| &run[late(run)..])
            .filter(|run| run.len() > 1)
            .collect();
        let nothing = FixError::NoLateFix { since_s };
        let rms = |runs: &[&[ScoredFix]], of: Of| {
            let fixes = runs.iter().copied().flatten();
            root_mean(&fixes.map(|fix| error_square_m2(fix, of)).collect::<Vec<_>>()).ok_or(nothing.clone())
        };
        let ends: Vec<&[ScoredFix]> = late.iter().map(|run| &run[run.len() - 1..]).collect();
        let steps = late.iter().flat_map(|run| run.windows(2));
        let (output, raw) = (
            MotionUnsteadiness::new(&late, Of::Output),
            MotionUnsteadiness::new(&late, Of::Raw),
        );
        let figures = CourseFigures {
            rmse: rms(&late, Of::Output)?,
            raw_rmse: rms(&late, Of::Raw)?,
            last: rms(&ends, Of::Output)?,
            raw_last: rms(&ends, Of::Raw)?,
            jump_m: steps.map(|step| jump_m(&step[0], &step[1])).fold(0.0, f64::max),
            speed_spread: output.speed_mps,
            raw_speed_spread: raw.speed_mps,
            direction_spread_deg: output.direction_deg,
            raw_direction_spread_deg: raw.direction_deg,
            straight_bound: (self.settings.case == FixCase::Drop).then(straight_bound_m).flatten(),
        };
        Ok((FixFigures::Course(figures), late.len() as u64))
    }
}

/// Choice between the two fixes of a row.
#[derive(Clone, Copy)]
enum Of {
    Output,
    Raw,
}

fn place_m(fix: &ScoredFix, of: Of) -> [f64; 2] {
    match of {
        Of::Output => fix.output_m,
        Of::Raw => fix.raw_m,
    }
}

fn error_square_m2(fix: &ScoredFix, of: Of) -> f64 {
    let error_m = distance(&place_m(fix, of), &fix.truth_m);
    error_m * error_m
}

/// Returns the distance of the output from the position predicted with its previous velocity.
fn jump_m(before: &ScoredFix, after: &ScoredFix) -> f64 {
    let seconds = after.time_s - before.time_s;
    let expected = [0, 1].map(|axis| before.output_m[axis] + before.velocity_mps[axis] * seconds);
    distance(&after.output_m, &expected)
}

/// Unsteadiness of the motion of fixes, averaged over runs.
struct MotionUnsteadiness {
    speed_mps: Option<f64>,
    direction_deg: Option<f64>,
}

impl MotionUnsteadiness {
    fn new(runs: &[&[ScoredFix]], of: Of) -> Self {
        let (mut speeds, mut directions) = (Vec::new(), Vec::new());
        for run in runs {
            let motion = motion_mps(run, of);
            let speed: Vec<f64> = motion.iter().map(|[x, y]| x.hypot(*y)).collect();
            let moving = motion.iter().zip(&speed).filter(|(_, speed)| **speed > STILL_MPS);
            let direction: Vec<f64> = moving.map(|([x, y], _)| x.atan2(*y)).collect();
            if let Some(spread) = standard_deviation(&speed) {
                speeds.push(spread);
                directions.push(circular_deviation(&direction).unwrap_or(0.0).to_degrees());
            }
        }
        Self {
            speed_mps: mean(&speeds),
            direction_deg: mean(&directions),
        }
    }
}

/// Returns the velocities between every tenth fix and the next such fix.
fn motion_mps(run: &[ScoredFix], of: Of) -> Vec<[f64; 2]> {
    let sampled: Vec<&ScoredFix> = run.iter().step_by(MOTION_ROWS).collect();
    let steps = sampled.windows(2).filter(|step| step[1].time_s > step[0].time_s);
    let motion = steps.map(|step| {
        let seconds = step[1].time_s - step[0].time_s;
        [0, 1].map(|axis| (place_m(step[1], of)[axis] - place_m(step[0], of)[axis]) / seconds)
    });
    motion.collect()
}

/// Unusable input.
#[derive(Debug, Error)]
pub enum FixInputError {
    /// Settings that differ.
    #[error("{found}; this cannot be pooled with {expected}: score them one by one")]
    Settings {
        /// Settings of the new input.
        found: CaseSettings,
        /// Settings of the earlier runs.
        expected: CaseSettings,
    },
    /// Faulty truth.
    #[error("{0}")]
    Truth(CsvError),
    /// Faulty fixes.
    #[error("{0}")]
    Fixes(CsvError),
}

/// Positions of emitters by time. The text in the column names an emitter, numeric or not.
struct EmitterTruth {
    emitters: FxHashMap<String, u32>,
    places_m: FxHashMap<(u32, u64), [f64; 2]>,
}

impl EmitterTruth {
    fn read(input: impl Read) -> Result<Self, CsvError> {
        let mut table = Table::new(input)?;
        let (time, emitter) = (table.required("time_s")?, table.required("emitter_id")?);
        let place = table.all(["x", "y"])?;
        let mut truth = Self {
            emitters: FxHashMap::default(),
            places_m: FxHashMap::default(),
        };
        while let Some(row) = table.next_row() {
            let row = row?;
            let place_m = [row.number(place[0])?, row.number(place[1])?];
            let name = row.text(emitter)?.unwrap_or_default();
            let number = match truth.emitters.get(name) {
                Some(number) => *number,
                None => {
                    let number = truth.emitters.len() as u32;
                    truth.emitters.insert(name.to_owned(), number);
                    number
                }
            };
            truth.places_m.insert((number, key(row.time_s(time)?)), place_m);
        }
        Ok(truth)
    }

    /// Returns the fixes by emitter, each run in the order of time.
    fn runs(&self, fixes: impl Read) -> Result<Vec<Vec<ScoredFix>>, CsvError> {
        let mut table = Table::new(fixes)?;
        let (time, emitter) = (table.required("time_s")?, table.required("emitter_id")?);
        let columns = table.all(["x", "y", "raw_x", "raw_y", "vx", "vy"])?;
        let mut runs: BTreeMap<u32, Vec<ScoredFix>> = BTreeMap::new();
        while let Some(row) = table.next_row() {
            let row = row?;
            let time_s = row.time_s(time)?;
            let Some(&number) = self.emitters.get(row.text(emitter)?.unwrap_or_default()) else {
                continue;
            };
            let Some(&truth_m) = self.places_m.get(&(number, key(time_s))) else {
                continue;
            };
            let mut values = [0.0; 6];
            for (value, column) in values.iter_mut().zip(columns) {
                *value = row.number(column)?;
            }
            let [x, y, raw_x, raw_y, vx, vy] = values;
            runs.entry(number).or_default().push(ScoredFix {
                time_s,
                truth_m,
                output_m: [x, y],
                raw_m: [raw_x, raw_y],
                velocity_mps: [vx, vy],
            });
        }
        let mut runs: Vec<Vec<ScoredFix>> = runs.into_values().collect();
        for run in &mut runs {
            // Values order two fixes at one time, so that the order in the file does not matter.
            run.sort_by(|one, other| {
                one.values()
                    .partial_cmp(&other.values())
                    .unwrap_or(std::cmp::Ordering::Equal)
            });
        }
        Ok(runs)
    }
}

/// Returns a time as a key; zero has two signs.
fn key(time_s: f64) -> u64 {
    (time_s + 0.0).to_bits()
}
