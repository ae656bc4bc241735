//! Selection of fixes, and the smooth path through the selected fixes (EL-4 … EL-10).
//!
//! The fixes of a bearings-only filter wander in arcs, because range comes slowly, and jump when bearings are wrong.
//! This module selects the trustworthy fixes and joins these fixes by straight, continuous motion. Its inputs are time,
//! position and variance, not bearings, so fixes of any other origin will do (ultrasound, radar; EL-12).
//!
//! # One rule
//!
//! Let S(n) be the fix that is selected at t(n), and P(n) where the output is then. From there the output moves on with
//!
//! ```text
//! V(n) = (S(n) − P(n−1)) / (t(n) − t(n−1))          the way from where the output was to where the emitter is
//! ```
//!
//! The formula combines EL-6, P(n+1) = P(n) + S(n) − P(n−1), for selections a fixed interval apart, and EL-9, for
//! selections at minima of the variance. Both differ in the time of selection and in the replacement of S(n) and P(n−1)
//! when the variance is too large. Option a has none: V stays. Option b uses the motion up to the rise of the variance
//! above the threshold, and from the fall below (EL-7 and EL-8).
//!
//! # States
//!
//! ```text
//!                        below the threshold               next selection, below
//!  ┌─────────┐ (minimum: a minimum below it) ┌───────┐ ─────────────┬────────────▶ ┌──────────┐
//!  │ passing │ ────────────────────────────▶ │ first │              │              │ interval │
//!  └─────────┘                               └───────┘              │              └──────────┘
//!   │ ▲  ↓ auto: below the threshold, and not falling by a fifth    │   staged: minima │ ▲ staged: no
//!   ▼ │  ↑ auto: the fixes have left the output                     │     come often   ▼ │ minimum for long
//!  ┌─────────┐                                                      │              ┌──────────┐
//!  │ steered │                                                      └────────────▶ │ minimum  │
//!  └─────────┘                                                        minimum      └──────────┘
//! ```
//!
//! In `passing` and `first` fixes are output unchanged. In all other states the output is continuous: each step is
//! exactly the output's velocity times the time. A filter with a monotonically falling variance has no minimum; then
//! minimum selection outputs the fixes, and staged selection stays with intervals.
//!
//! # What it costs
//!
//! With equal intervals and S(n) = truth + e(n), the error of the output obeys p(n+1) − p(n) + p(n−1) = e(n). The free
//! oscillation, of period six intervals, is not damped: an interval of a sixth of the period of the filter's errors
//! (often the period of the platform's circles) causes resonance. Longer intervals, or minima, do not. `Steered` is our
//! own addition for filters that are already good: at every fix the output heads to the position that the filter
//! predicts a little later. The output then neither oscillates nor jumps.
//!
//! Source: patent JP7553304B2.

use ::settings::Degrees;
use kept::{Get, Kept, Put, kept, kept_variants};

/// Steered: while the variance falls by this share from fix to fix, fixes are passed on, if the output is more than a
/// standard deviation away.
const FALLING_SHARE: f64 = 0.2;
/// Steered: an output this many standard deviations away from the fix, for so many fixes in a row, is given up.
const DEPARTED_SIGMAS: f64 = 3.0;
const DEPARTED_FIXES: u32 = 2;

settings::words! {
    /// Choice of the fixes that steer the output.
    pub enum Select {
        /// The best there is for unknown data: every fix steers the output.
        Auto = "auto",
        /// Fixes are passed on.
        None = "none",
        /// One each interval (EL-5).
        Interval = "interval",
        /// One at each minimum of the variance (EL-9).
        Minimum = "minimum",
        /// Each interval at first, then at minima (EL-10).
        Staged = "staged",
    }

    /// What ends an interval of interval selection (EL-5).
    pub enum SelectionInterval {
        /// Time.
        Time = "time",
        /// A change of the direction from the platform to the emitter.
        Geometry = "geometry",
    }

    /// Motion while the variance is above its threshold (EL-7, EL-8).
    pub enum AboveThreshold {
        /// Option a: direction and speed stay as they are.
        Continue = "continue",
        /// Option b: they become those up to the fix at which the variance rose, and after it fell.
        UseCrossings = "use-crossings",
    }
}

settings::settings! {
    /// How fixes are selected.
    #[derive(Copy)]
    pub struct SelectionSettings {
        /// Selection: `auto`, every fix steers the output, best for unknown data; `none`, fixes without selection;
        /// `interval`, a fix per interval; `minimum`, a fix at each minimum of the variance; `staged`, intervals at
        /// first, later minima.
        select: Select = Select::Auto;
        /// Square root of the threshold of the variance value.
        position_sigma_max_m: f64 = 500.0, in [above 0];
        /// End of an interval: `time`, after `interval_s`; `geometry`, after a change of the emitter's direction from
        /// the platform by `interval_deg`.
        interval: SelectionInterval = SelectionInterval::Time;
        /// Time between selections; longer than between fixes.
        interval_s: f64 = 250.0, in [above 0];
        /// Change of the emitter's direction between selections.
        interval_deg: Degrees = Degrees::of(60.0), in [1, 180];
        /// Motion above the threshold: `continue` keeps direction and speed; `use-crossings` uses the direction and
        /// speed between the fix before the variance rose and the fix after it fell.
        above_threshold: AboveThreshold = AboveThreshold::Continue;
        /// Least relative rise of the variance after a minimum for the minimum to count; 0: every minimum counts.
        minimum_rise: f64 = 0.3, in [from 0];
        /// Least time from the last selection to a minimum; earlier minima do not count.
        minimum_gap_s: f64 = 100.0, in [from 0];
        /// Staged: number of minima below the threshold, each within `minimum_wait_s` of the previous one, after which
        /// minima are used.
        settled_minima: u32 = 2;
        /// Staged: time without a minimum after which intervals are used again.
        minimum_wait_s: f64 = 750.0, in [above 0];
        /// `auto`: each fix turns the output towards the emitter's predicted position after this time.
        steering_s: f64 = 30.0, in [above 0];
    }
}

impl SelectionSettings {
    /// Threshold of the variance value, m².
    fn variance_max_m2(&self) -> f64 {
        self.position_sigma_max_m * self.position_sigma_max_m
    }
}

/// Fix of any origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Time, seconds.
    pub time_s: f64,
    /// Position, east, north and up in the system frame, metres.
    pub position_m: [f64; 3],
    /// Velocity, east, north and up, m/s; 0 if unknown. The velocity is output with unchanged fixes, and steers.
    pub velocity_mps: [f64; 3],
    /// Variance of the position (EL-3), m².
    pub variance_m2: f64,
    /// Direction of the position from the platform, radians clockwise from north; `None` if unknown: intervals are then
    /// of time.
    pub direction_rad: Option<f64>,
}

/// Output for a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Position of the emitter, east, north and up in the system frame, metres.
    pub position_m: [f64; 3],
    /// Velocity at which the output moves on from here, east, north and up, m/s.
    pub velocity_mps: [f64; 3],
    /// State of the selection.
    pub stage: SelectionStage,
    /// Whether a fix was selected.
    pub is_selected: bool,
    /// Decision, with the values that were compared, if any were.
    pub decision: Option<(SelectionReason, f64, f64)>,
}

/// States of the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectionStage {
    /// No fix is selected yet; fixes are passed on.
    Passing,
    /// A single selection exists, and fixes are passed on until the second.
    First,
    /// A straight line until the next interval is over.
    Interval,
    /// A straight line until the next minimum.
    Minimum,
    /// Headed to the filter's prediction.
    Steered,
}

impl SelectionStage {
    /// The word for the state.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passing => "passing",
            Self::First => "first",
            Self::Interval => "interval",
            Self::Minimum => "minimum",
            Self::Steered => "steered",
        }
    }
}

/// Reason of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectionReason {
    /// The variance is below the threshold for the first time.
    FirstBelow,
    /// The first minimum below the threshold.
    FirstMinimum,
    /// The second selection: the line begins.
    Second,
    /// The second selection would be due, and the variance is above.
    SecondWaits,
    /// An interval is over, and the fix is used.
    IntervalOver,
    /// A minimum, and the fix is used.
    AtMinimum,
    /// The variance is above: direction and speed stay.
    HeldAbove,
    /// The variance is above: motion up to the last fix below.
    UpCrossing,
    /// The variance is below again: motion since the first fix below.
    DownCrossing,
    /// Minima come often enough to be used.
    Settled,
    /// No minimum came for long.
    MinimaRare,
    /// The fix has left the output behind: fixes are passed on.
    Departed,
}

impl SelectionReason {
    /// Meaning of the reason, in a few words.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::FirstBelow => "variance below its threshold for the first time",
            Self::FirstMinimum => "first minimum of the variance below its threshold",
            Self::Second => "second selection: the line begins",
            Self::SecondWaits => "second selection waits: variance above its threshold",
            Self::IntervalOver => "interval over: the fix is used",
            Self::AtMinimum => "minimum of the variance: the fix is used",
            Self::HeldAbove => "variance above its threshold: direction and speed stay",
            Self::UpCrossing => "variance above its threshold: motion up to the last fix below it",
            Self::DownCrossing => "variance below its threshold again: motion since the first fix below it",
            Self::Settled => "minima come often enough: they are used from now on",
            Self::Departed => "the fixes have left the output: they are passed on",
            Self::MinimaRare => "no minimum for long: intervals are used from now on",
        }
    }
}

/// A position at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    time_s: f64,
    position_m: [f64; 3],
}

/// The state machine: fixes in, output out.
#[derive(Clone, Debug)]
pub struct Selector {
    settings: SelectionSettings,
    stage: SelectionStage,
    /// Beginning and velocity of the present line.
    line: Point,
    velocity_mps: [f64; 3],
    /// t(n−1), and P(n−1); while there is a single selection, S1.
    previous: Point,
    /// End of the next interval, seconds; and the direction at the beginning.
    due_s: f64,
    begun_rad: Option<f64>,
    /// The fix before, and whether this fix was below the threshold.
    last: Option<(Point, bool)>,
    /// Steered: variance of the fix before, and the number of fixes during which the output has been far off.
    last_variance_m2: f64,
    departed: u32,
    was_above_at_selection: bool,
    /// Last fix before the variance rose above the threshold, first fix after the fall below.
    up: Option<Point>,
    down: Option<Point>,
    valley: Valley,
    /// Staged: the last minimum below the threshold, and how many have come in close succession.
    last_minimum_s: f64,
    minima: u32,
}

impl Selector {
    /// A selector that has seen no fix. The settings must have passed [`settings::check`].
    pub fn new(settings: SelectionSettings) -> Self {
        let nowhere = Point {
            time_s: 0.0,
            position_m: [0.0; 3],
        };
        Self {
            settings,
            stage: SelectionStage::Passing,
            line: nowhere,
            velocity_mps: [0.0; 3],
            previous: nowhere,
            due_s: f64::INFINITY,
            begun_rad: None,
            last: None,
            last_variance_m2: f64::INFINITY,
            departed: 0,
            was_above_at_selection: false,
            up: None,
            down: None,
            valley: Valley::default(),
            last_minimum_s: f64::NEG_INFINITY,
            minima: 0,
        }
    }

    /// Takes the next fix. `None`, and no change, for a fix older than the last, or with a value that is no number.
    pub fn fix(&mut self, fix: &Fix) -> Option<Output> {
        let values = fix.position_m.iter().chain(&fix.velocity_mps);
        let is_finite = values.chain([&fix.time_s]).all(|value| value.is_finite());
        let is_late = self.last.is_some_and(|(last, _)| fix.time_s < last.time_s);
        if !is_finite || fix.variance_m2.is_nan() || is_late {
            return None;
        }
        let seen = Point {
            time_s: fix.time_s,
            position_m: fix.position_m,
        };
        let is_below = fix.variance_m2 < self.settings.variance_max_m2();
        self.note_crossing(seen, is_below);
        let before = self.output_at(seen);
        let minimum = self
            .valley
            .next(self.settings.minimum_rise, fix.variance_m2, seen, before);
        let decision = match self.settings.select {
            Select::None => None,
            Select::Auto => self.steer(fix, before, is_below),
            Select::Interval => self.at_interval(fix, seen, before, is_below),
            Select::Minimum => self.at_minimum(fix, minimum, before),
            Select::Staged => self.staged(fix, seen, before, is_below, minimum),
        };
        self.last = Some((seen, is_below));
        self.last_variance_m2 = fix.variance_m2;
        let after = self.output_at(seen);
        let is_line = !matches!(self.stage, SelectionStage::Passing | SelectionStage::First);
        Some(Output {
            position_m: after.position_m,
            velocity_mps: if is_line { self.velocity_mps } else { fix.velocity_mps },
            stage: self.stage,
            is_selected: match decision {
                Some((reason, ..)) => reason.uses_fix(),
                None => self.stage == SelectionStage::Steered,
            },
            decision,
        })
    }

    /// Position of the output at the time of a fix, metres.
    fn output_at(&self, seen: Point) -> Point {
        let position_m = match self.stage {
            SelectionStage::Passing | SelectionStage::First => seen.position_m,
            _ => moved(self.line.position_m, self.velocity_mps, seen.time_s - self.line.time_s),
        };
        Point { position_m, ..seen }
    }

    fn note_crossing(&mut self, seen: Point, is_below: bool) {
        match self.last {
            Some((last, true)) if !is_below => self.up = Some(last),
            Some((_, false)) | None if is_below => self.down = Some(seen),
            _ => {}
        }
    }

    /// Every fix heads the output to where the emitter will be a steering time later.
    fn steer(&mut self, fix: &Fix, before: Point, is_below: bool) -> Option<(SelectionReason, f64, f64)> {
        let is_first = self.stage != SelectionStage::Steered;
        let is_falling = fix.variance_m2 < (1.0 - FALLING_SHARE) * self.last_variance_m2;
        if is_first && (!is_below || is_falling) {
            return None;
        }
        let off_m2 = squared_distance(fix.position_m, before.position_m);
        if self.has_departed(off_m2, fix.variance_m2) || (is_falling && off_m2 > fix.variance_m2) {
            self.stage = SelectionStage::Passing;
            return Some((
                SelectionReason::Departed,
                off_m2.sqrt(),
                DEPARTED_SIGMAS * fix.variance_m2.sqrt(),
            ));
        }
        // The next fix must not come after the output has passed the aim.
        let last_step_s = self.last.map_or(0.0, |(last, _)| fix.time_s - last.time_s);
        let steering_s = self.settings.steering_s.max(last_step_s);
        self.stage = SelectionStage::Steered;
        self.line = before;
        self.velocity_mps = std::array::from_fn(|axis| {
            fix.velocity_mps[axis] + (fix.position_m[axis] - before.position_m[axis]) / steering_s
        });
        is_first.then_some((
            SelectionReason::FirstBelow,
            fix.variance_m2,
            self.settings.variance_max_m2(),
        ))
    }

    /// Steered: whether the fixes have left the output, because the belief about the emitter has changed.
    fn has_departed(&mut self, off_m2: f64, variance_m2: f64) -> bool {
        let is_far = off_m2 > DEPARTED_SIGMAS * DEPARTED_SIGMAS * variance_m2;
        self.departed = if is_far { self.departed + 1 } else { 0 };
        self.departed >= DEPARTED_FIXES
    }

    /// EL-4 … EL-8.
    fn at_interval(
        &mut self,
        fix: &Fix,
        seen: Point,
        before: Point,
        is_below: bool,
    ) -> Option<(SelectionReason, f64, f64)> {
        let found = |reason| Some((reason, fix.variance_m2, self.settings.variance_max_m2()));
        if self.stage == SelectionStage::Passing {
            if !is_below {
                return None;
            }
            let found = found(SelectionReason::FirstBelow);
            self.stage = SelectionStage::First;
            self.previous = seen;
            self.due_s = fix.time_s + self.settings.interval_s;
            self.begun_rad = fix.direction_rad;
            return found;
        }
        if !self.is_due(fix) {
            return None;
        }
        self.begun_rad = fix.direction_rad;
        self.due_s = next_due(self.due_s, self.settings.interval_s, fix.time_s);
        if self.stage == SelectionStage::First {
            if !is_below {
                return found(SelectionReason::SecondWaits);
            }
            let found = found(SelectionReason::Second);
            self.turn(SelectionStage::Interval, before, Some((self.previous, seen)), before);
            return found;
        }
        let (reason, way) = self.way(seen, is_below);
        let found = found(reason);
        self.was_above_at_selection = !is_below;
        self.turn(SelectionStage::Interval, before, way, before);
        found
    }

    /// Whether an interval is over: of time (EL-5), or of the change of direction.
    fn is_due(&self, fix: &Fix) -> bool {
        let is_geometric = self.settings.interval == SelectionInterval::Geometry;
        match self.begun_rad.zip(fix.direction_rad).filter(|_| is_geometric) {
            Some((begun_rad, direction_rad)) => {
                let change = direction_rad - begun_rad;
                change.sin().atan2(change.cos()).abs() >= self.settings.interval_deg.rad()
            }
            None => fix.time_s >= self.due_s,
        }
    }

    /// Start and end of the way that gives the output's next velocity, at a selection time; `None`: the velocity
    /// stays.
    fn way(&self, seen: Point, is_below: bool) -> (SelectionReason, Option<(Point, Point)>) {
        let crossings = self.settings.above_threshold == AboveThreshold::UseCrossings;
        if !is_below {
            let rose = self.up.filter(|up| up.time_s > self.previous.time_s);
            return match rose.filter(|_| crossings && !self.was_above_at_selection) {
                Some(up) => (SelectionReason::UpCrossing, Some((self.previous, up))),
                None => (SelectionReason::HeldAbove, None),
            };
        }
        let fell = self.down.filter(|down| down.time_s < seen.time_s);
        match fell.filter(|_| crossings && self.was_above_at_selection) {
            Some(down) => (SelectionReason::DownCrossing, Some((down, seen))),
            None => (SelectionReason::IntervalOver, Some((self.previous, seen))),
        }
    }

    /// EL-9. A minimum is known once the variance has risen: the output turns then, based on the position at the
    /// minimum.
    fn at_minimum(&mut self, fix: &Fix, minimum: Option<Minimum>, now: Point) -> Option<(SelectionReason, f64, f64)> {
        let minimum = minimum?;
        let limit = self.settings.variance_max_m2();
        let is_below = minimum.variance_m2 < limit;
        let found = |reason| Some((reason, minimum.variance_m2, limit));
        match self.stage {
            SelectionStage::Passing if is_below => {
                self.stage = SelectionStage::First;
                self.previous = minimum.seen;
                found(SelectionReason::FirstMinimum)
            }
            SelectionStage::Passing => None,
            _ if minimum.seen.time_s - self.previous.time_s <= self.settings.minimum_gap_s => None,
            SelectionStage::First if !is_below => found(SelectionReason::SecondWaits),
            SelectionStage::First => {
                // Fixes are passed on up to now, so the line begins at the present fix.
                let begin = Point {
                    time_s: fix.time_s,
                    position_m: fix.position_m,
                };
                self.turn(
                    SelectionStage::Minimum,
                    begin,
                    Some((self.previous, minimum.seen)),
                    minimum.output,
                );
                found(SelectionReason::Second)
            }
            _ if is_below => {
                self.turn(
                    SelectionStage::Minimum,
                    now,
                    Some((self.previous, minimum.seen)),
                    minimum.output,
                );
                found(SelectionReason::AtMinimum)
            }
            _ => {
                self.turn(SelectionStage::Minimum, now, None, minimum.output);
                found(SelectionReason::HeldAbove)
            }
        }
    }

    /// EL-10.
    fn staged(
        &mut self,
        fix: &Fix,
        seen: Point,
        before: Point,
        is_below: bool,
        minimum: Option<Minimum>,
    ) -> Option<(SelectionReason, f64, f64)> {
        let wait_s = self.settings.minimum_wait_s;
        if let Some(minimum) = minimum.filter(|minimum| minimum.variance_m2 < self.settings.variance_max_m2()) {
            let is_soon = minimum.seen.time_s - self.last_minimum_s <= wait_s;
            self.minima = if is_soon { self.minima + 1 } else { 1 };
            self.last_minimum_s = minimum.seen.time_s;
        }
        if self.stage == SelectionStage::Minimum {
            let silent_s = fix.time_s - self.last_minimum_s;
            if silent_s <= wait_s {
                return self.at_minimum(fix, minimum, before);
            }
            self.minima = 0;
            self.due_s = fix.time_s;
            let (_, way) = self.way(seen, is_below);
            self.was_above_at_selection = !is_below;
            self.turn(SelectionStage::Interval, before, way, before);
            self.due_s = fix.time_s + self.settings.interval_s;
            self.begun_rad = fix.direction_rad;
            return Some((SelectionReason::MinimaRare, silent_s, wait_s));
        }
        if self.stage == SelectionStage::Interval && minimum.is_some() && self.minima >= self.settings.settled_minima {
            self.stage = SelectionStage::Minimum;
            // A minimum too soon after the last interval changes the stage, but not yet the direction.
            self.at_minimum(fix, minimum, before);
            let needed = f64::from(self.settings.settled_minima);
            return Some((SelectionReason::Settled, f64::from(self.minima), needed));
        }
        self.at_interval(fix, seen, before, is_below)
    }

    /// Continues the output from `begin` with the velocity of a way, or unchanged; `p` is P(n).
    fn turn(&mut self, stage: SelectionStage, begin: Point, way: Option<(Point, Point)>, p: Point) {
        if let Some((from, to)) = way {
            let duration_s = to.time_s - from.time_s;
            if duration_s > 0.0 {
                self.velocity_mps =
                    std::array::from_fn(|axis| (to.position_m[axis] - from.position_m[axis]) / duration_s);
            }
        }
        self.stage = stage;
        self.line = begin;
        self.previous = p;
    }
}

impl SelectionReason {
    fn uses_fix(self) -> bool {
        !matches!(self, Self::SecondWaits | Self::HeldAbove | Self::UpCrossing)
    }
}

fn moved(position_m: [f64; 3], velocity_mps: [f64; 3], after_s: f64) -> [f64; 3] {
    std::array::from_fn(|axis| position_m[axis] + velocity_mps[axis] * after_s)
}

fn squared_distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum()
}

/// The first selection time after `now_s`; intervals that passed without a fix are passed over.
fn next_due(due_s: f64, interval_s: f64, now_s: f64) -> f64 {
    due_s + interval_s * (((now_s - due_s) / interval_s).floor() + 1.0)
}

/// A minimum of the variance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Minimum {
    variance_m2: f64,
    /// The fix then.
    seen: Point,
    /// The output then.
    output: Point,
}

/// Finds minima: where the variance has fallen, and then risen by a share.
#[derive(Clone, Copy, Debug, Default)]
struct Valley {
    /// The minimum since the last fall; `None` while the variance rises.
    least: Option<Minimum>,
    /// The greatest during a rise.
    greatest: Option<f64>,
}

impl Valley {
    fn next(&mut self, rise: f64, variance_m2: f64, seen: Point, output: Point) -> Option<Minimum> {
        let here = Minimum {
            variance_m2,
            seen,
            output,
        };
        if let Some(least) = self.least {
            if variance_m2 <= least.variance_m2 {
                self.least = Some(here);
            } else if variance_m2 > least.variance_m2 * (1.0 + rise) {
                *self = Self {
                    least: None,
                    greatest: Some(variance_m2),
                };
                return Some(least);
            }
            return None;
        }
        // The first fix of all is no minimum: nothing has fallen before.
        let greatest = self.greatest.map_or(variance_m2, |greatest| greatest.max(variance_m2));
        self.greatest = Some(greatest);
        if variance_m2 * (1.0 + rise) < greatest {
            self.least = Some(here);
        }
        None
    }
}

kept_variants!(SelectionStage {
    Passing,
    First,
    Interval,
    Minimum,
    Steered,
});
kept!(Point {
    time_s: f64,
    position_m: [f64; 3],
});
kept!(Minimum {
    variance_m2: f64,
    seen: Point,
    output: Point,
});
kept!(Valley {
    least: Option<Minimum>,
    greatest: Option<f64>,
});

/// State of a selector in the memory for a successor, which has the settings.
impl Selector {
    pub(crate) const KEPT_WORDS: usize = SelectionStage::WORDS
        + 2 * Point::WORDS
        + <[f64; 3]>::WORDS
        + <[f64; 2]>::WORDS
        + f64::WORDS
        + Option::<f64>::WORDS
        + <[u32; 2]>::WORDS
        + bool::WORDS
        + Option::<(Point, bool)>::WORDS
        + 2 * Option::<Point>::WORDS
        + Valley::WORDS;

    pub(crate) fn put(&self, to: &mut Put<'_>) {
        let Self {
            settings: _,
            stage,
            line,
            velocity_mps,
            previous,
            due_s,
            begun_rad,
            last,
            last_variance_m2,
            departed,
            was_above_at_selection,
            up,
            down,
            valley,
            last_minimum_s,
            minima,
        } = self;
        stage.put(to);
        line.put(to);
        velocity_mps.put(to);
        previous.put(to);
        due_s.put(to);
        begun_rad.put(to);
        last.put(to);
        last_variance_m2.put(to);
        departed.put(to);
        was_above_at_selection.put(to);
        up.put(to);
        down.put(to);
        valley.put(to);
        last_minimum_s.put(to);
        minima.put(to);
    }

    pub(crate) fn get(settings: SelectionSettings, from: &mut Get<'_>) -> Option<Self> {
        Some(Self {
            settings,
            stage: Kept::get(from)?,
            line: Kept::get(from)?,
            velocity_mps: Kept::get(from)?,
            previous: Kept::get(from)?,
            due_s: Kept::get(from)?,
            begun_rad: Kept::get(from)?,
            last: Kept::get(from)?,
            last_variance_m2: Kept::get(from)?,
            departed: Kept::get(from)?,
            was_above_at_selection: Kept::get(from)?,
            up: Kept::get(from)?,
            down: Kept::get(from)?,
            valley: Kept::get(from)?,
            last_minimum_s: Kept::get(from)?,
            minima: Kept::get(from)?,
        })
    }
}

#[cfg(test)]
#[path = "selection_tests.rs"]
mod tests;
