//! Global alignment: gross errors of a source, found from tracks that did not join.
//!
//! Registration learns from tracks that were joined. A radar that is half a degree off shows a target at 100 km nearly
//! a kilometre aside: nothing joins, nothing is learned, and every target is shown twice. But all of its tracks are off
//! in the same way. So for every two sources this asks which error of one, an azimuth, a range, a time or a place,
//! brings the most of its tracks onto tracks of the other. Each pair of tracks that move alike implies one value of
//! each kind; of pairs that are not of one target these values lie anywhere, of those that are they pile up (a
//! generalised Hough transform). The fullest bin of each kind's histogram is refined and then tried on all tracks.
//!
//! Reports are collected for a while, of targets in a part of the area that holds as many as can be compared; then the
//! sources are compared two by two, a bounded number of pairs of tracks with each report. An error is believed when a
//! second collection, of another part, has shown it again, and it explains much more than no error does.
//!
//! Two sources show that one of them is off, not which. A third one that agrees with one of them does, or a reference
//! source; addresses do where the error needs a place that only one of them has; and the times of receipt do where it
//! is one of time.
//!
//! Limits: targets that hardly move say too little; errors beyond [`LIMIT`], or two kinds at once, are not found.
//!
//! Source: D. H. Ballard, *Generalizing the Hough transform to detect arbitrary shapes*, Pattern Recognition 13 (1981).

use kept::kept;
use messages::{GrossError, GrossKind, Identity, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::gross::{self, Motion, Sigma};
use crate::registration::ClockError;
use crate::settings::Settings;

/// Tracks of one source that are compared at most, and at least.
const TRACKS_MAX: usize = 40;
const TRACKS_MIN: usize = 4;
/// Pairs of tracks that are compared with one report, less those of one track more.
const STEP_PAIRS: usize = 128;
/// Half-width of the part of the area that is looked at, at first and at most, metres, and how it changes.
const REACH_MAX_M: f64 = 400e3;
const NARROWER: f64 = 0.8;
const WIDER: f64 = 1.5;
/// Periods of the slowest source, up to which time in all, for which reports are collected, seconds.
const COLLECT_PERIODS: f64 = 1.3;
const COLLECT_S: [f64; 2] = [4.0, 15.0];
/// Pause before the next collection where all sources agreed, where some did not, and where an error was found,
/// seconds.
const PAUSE_S: [f64; 3] = [15.0, 3.0, 0.0];
/// Speed below which a track says too little, metres per second.
const SPEED_MIN_MPS: f64 = 5.0;
/// Deviations that every two tracks of one target may have besides what they claim, metres and metres per second, and
/// the acceleration that nobody foresees, metres per second squared.
const POSITION_FLOOR_M: f64 = 40.0;
const VELOCITY_FLOOR_MPS: f64 = 5.0;
const ACCELERATION_MPS2: f64 = 2.0;
/// Greatest difference of heights, metres.
const HEIGHT_GATE_M: f64 = 400.0;
/// Chi-square with four degrees of freedom beyond which two tracks are not of one target.
const GATE: f64 = 20.0;
/// Share of the tracks that must fit as they are for two sources to agree; share of them that an error must explain,
/// and how much of that it must gain over no error.
const AGREES: f64 = 0.6;
const EXPLAINS: f64 = 0.4;
const GAINS: f64 = 0.35;
/// Clock offset, seconds, by which one of two sources must be worse to be the one whose time is wrong.
const CLOCK_WORSE_S: f64 = 0.5;
/// Times that an error must have been found.
const WINDOWS_MIN: u32 = 2;
/// Errors that are looked for: on the side of which source of the two, and of which kind.
const HYPOTHESES: [(Side, GrossKind); 6] = [
    (Side::First, GrossKind::Azimuth),
    (Side::First, GrossKind::Range),
    (Side::First, GrossKind::Time),
    (Side::First, GrossKind::Position),
    (Side::Second, GrossKind::Azimuth),
    (Side::Second, GrossKind::Range),
];
/// Bins of a histogram along one axis, to either side of 0.
const BINS: usize = 60;
const ROW: usize = 2 * BINS + 1;

/// Width of a bin of each kind, in its unit; twice that is the difference up to which two values are the same.
const fn bin(kind: GrossKind) -> f64 {
    match kind {
        GrossKind::Azimuth => 0.0025,
        GrossKind::Range => 100.0,
        GrossKind::Time => 1.0,
        GrossKind::Position => 200.0,
    }
}

/// Which source of a pair an error is one of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Side {
    First,
    Second,
}

/// Latest report of a track.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Seen {
    time_ns: i64,
    track_number: u32,
    height_m: Option<f64>,
    identity: Identity,
    motion: Motion,
    /// Variances per axis, m² and m²/s².
    position_m2: f64,
    velocity_m2ps2: f64,
}

impl Seen {
    /// Motion at `time_ns`, and the deviation per axis that this adds, metres.
    fn at(&self, time_ns: i64) -> (Motion, f64) {
        let seconds = (time_ns - self.time_ns) as f64 / NS_PER_S;
        let mut motion = self.motion;
        for axis in 0..2 {
            motion.position_m[axis] += motion.velocity_mps[axis] * seconds;
        }
        let unforeseen_m = (0.5 * ACCELERATION_MPS2 * seconds * seconds).min(ACCELERATION_MPS2 * 4.0 * seconds.abs());
        (motion, (self.velocity_m2ps2.sqrt() * seconds).hypot(unforeseen_m))
    }
}

kept!(Found {
    value: [f64; 2],
    score: f64,
    windows: u32
});
kept!(PairState {
    found: [Found; HYPOTHESES.len()],
    agree: bool,
    addresses: u32
});

/// Success of one kind of error in explaining two sources, over the collections in a row that found it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Found {
    value: [f64; 2],
    score: f64,
    windows: u32,
}

/// Knowledge of two sources.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PairState {
    found: [Found; HYPOTHESES.len()],
    /// Whether they agree as they are.
    agree: bool,
    /// Pairs of tracks with the same address that fit with the error.
    addresses: u32,
}

impl PairState {
    /// The hypothesis that explains most; `None` if none is believed.
    fn best(&self) -> Option<usize> {
        let believed = (0..HYPOTHESES.len()).filter(|h| self.found[*h].windows >= WINDOWS_MIN);
        believed.max_by(|a, b| self.found[*a].score.total_cmp(&self.found[*b].score))
    }
}

/// Stage of the search.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Phase {
    /// Nothing until then, nanoseconds.
    Pause(i64),
    /// Reports are collected until then.
    Collect(i64),
    /// Two sources are compared.
    Compare,
}

/// Part of the comparison of two sources.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Job {
    /// How well do they fit as they are?
    AsTheyAre,
    /// Which errors do pairs of tracks imply?
    Vote,
    /// Refinement of an error that was found roughly.
    Refine(usize),
    /// How well do they fit without it?
    Try(usize),
}

/// Histograms of the errors that pairs of tracks imply, and the fullest place of each so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Votes {
    lines: [Line; HYPOTHESES.len()],
    #[serde(with = "serde_arrays")]
    plane: [Line; ROW],
    /// Votes, and bins from the first.
    best: [(u32, [usize; 2]); HYPOTHESES.len()],
}

/// Votes along one axis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Line(#[serde(with = "serde_arrays")] [u16; ROW]);

impl Default for Votes {
    fn default() -> Self {
        Self {
            lines: [Line([0; ROW]); HYPOTHESES.len()],
            plane: [Line([0; ROW]); ROW],
            best: [(0, [BINS; 2]); HYPOTHESES.len()],
        }
    }
}

impl Votes {
    /// Adds a vote; values beyond the histogram have none.
    fn add(&mut self, hypothesis: usize, kind: GrossKind, value: [f64; 2]) {
        let place = |part: f64| {
            let bins = (part / bin(kind)).round() + BINS as f64;
            (0.0..ROW as f64).contains(&bins).then_some(bins as usize)
        };
        let (Some(column), Some(row)) = (place(value[0]), place(value[1])) else {
            return;
        };
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(ROW);
        let sum = |line: &Line| line.0[near(column)].iter().map(|votes| u32::from(*votes)).sum::<u32>();
        let votes = if kind == GrossKind::Position {
            self.plane[row].0[column] += 1;
            self.plane[near(row)].iter().map(sum).sum()
        } else {
            self.lines[hypothesis].0[column] += 1;
            sum(&self.lines[hypothesis])
        };
        let best = &mut self.best[hypothesis];
        if votes > best.0 {
            *best = (votes, [column, row]);
        }
    }

    /// Where most votes lie together, in bins from 0.
    fn fullest(&self, hypothesis: usize) -> [f64; 2] {
        self.best[hypothesis].1.map(|index| index as f64 - BINS as f64)
    }
}

/// Gross errors of all sources.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Alignment {
    reference: Option<usize>,
    removes: bool,
    places_m: Vec<Option<[f64; 2]>>,
    /// Tracks collected of each source.
    seen: Vec<Vec<Seen>>,
    phase: Phase,
    /// Middle and half-width of the part of the area that is looked at.
    focus_m: Option<[f64; 2]>,
    reach_m: f64,
    /// The two sources being compared, what of, and the next track of the first one.
    pair: (usize, usize),
    job: Job,
    row: usize,
    votes: Box<Votes>,
    /// Sums of the present job, and results so far.
    sum: [f64; 4],
    as_they_are: f64,
    values: [[f64; 2]; HYPOTHESES.len()],
    scores: [f64; HYPOTHESES.len()],
    same_address: u32,
    pairs: Vec<PairState>,
    /// How much was amiss in the present comparisons: nothing, sources that do not agree, an error.
    amiss: usize,
    /// Error of each source that is believed.
    errors: Vec<Option<GrossError>>,
    /// Errors that are taken off each source's reports.
    removed: Vec<Option<(GrossKind, [f64; 2])>>,
    /// How often that has changed.
    epochs: Vec<u8>,
}

impl Alignment {
    pub(crate) fn new(settings: &Settings) -> Self {
        let count = settings.sources.len();
        let reference = settings.registration.reference_source.as_ref();
        Self {
            reference: reference.map(|source| usize::from(source.number)),
            removes: settings.registration.gross,
            places_m: settings.sources.iter().map(|source| source.place_m).collect(),
            seen: (0..count).map(|_| Vec::with_capacity(TRACKS_MAX)).collect(),
            phase: Phase::Pause(i64::MIN),
            focus_m: None,
            reach_m: REACH_MAX_M,
            pair: (0, 0),
            job: Job::AsTheyAre,
            row: 0,
            votes: Box::default(),
            sum: [0.0; 4],
            as_they_are: 0.0,
            values: [[0.0; 2]; HYPOTHESES.len()],
            scores: [0.0; HYPOTHESES.len()],
            same_address: 0,
            pairs: vec![PairState::default(); count * count],
            amiss: 0,
            errors: vec![None; count],
            removed: vec![None; count],
            epochs: vec![0; count],
        }
    }

    /// Findings on two sources, by the place of their pair.
    pub(crate) fn pair_mut(&mut self, place: usize) -> &mut PairState {
        &mut self.pairs[place]
    }

    /// Errors of a source: the one that is believed, and what is taken off its reports.
    pub(crate) fn kept(&self, source: usize) -> (Option<GrossError>, Option<(GrossKind, [f64; 2])>) {
        (self.errors[source], self.removed[source])
    }

    /// Goes on with errors that were [kept](Self::kept); nothing is taken off where the settings do not say so.
    pub(crate) fn resume(
        &mut self,
        source: usize,
        (error, removed): (Option<GrossError>, Option<(GrossKind, [f64; 2])>),
    ) {
        self.removed[source] = removed.filter(|_| self.removes);
        self.errors[source] = error.map(|error| GrossError {
            is_removed: error.is_removed && self.removes,
            ..error
        });
    }

    /// The gross error of a source, if one is believed.
    pub(crate) fn error_of(&self, source: u16) -> Option<GrossError> {
        self.errors[usize::from(source)]
    }

    /// How often what is removed from the reports of a source has changed: tracks of before are of no use then.
    pub(crate) fn epoch_of(&self, source: u16) -> u8 {
        self.epochs[usize::from(source)]
    }

    /// Reports of a source are others from now on: its tracks of before are of no use.
    pub(crate) fn begin_epoch(&mut self, source: u16) {
        self.epochs[usize::from(source)] = self.epochs[usize::from(source)].wrapping_add(1);
        self.forget(usize::from(source));
    }

    /// The report without the gross error of its source, at `now_ns`; `None` if nothing is taken off it.
    pub(crate) fn corrected(&self, report: &SensorTrack, now_ns: i64) -> Option<SensorTrack> {
        let source = usize::from(report.source);
        let (kind, value) = self.removed[source]?;
        Some(gross::corrected(report, kind, value, self.places_m[source], now_ns))
    }

    /// Takes a valid report, and goes on with the comparison; `now_ns` is the present, and `clocks` the errors of the
    /// sources' clocks by the times of receipt. The source whose correction has changed, if one has.
    pub(crate) fn take(
        &mut self,
        report: &SensorTrack,
        now_ns: i64,
        settings: &Settings,
        clocks: &[ClockError],
    ) -> Option<u16> {
        match self.phase {
            Phase::Pause(until_ns) if now_ns >= until_ns => {
                let [least_s, most_s] = COLLECT_S;
                let collect_s = (COLLECT_PERIODS * settings.longest_period_s()).clamp(least_s, most_s);
                self.begin(now_ns.saturating_add((collect_s * NS_PER_S) as i64));
                self.collect(report);
            }
            Phase::Pause(_) => {}
            Phase::Collect(until_ns) if now_ns >= until_ns => {
                self.reach_m = (self.reach_m * WIDER).min(REACH_MAX_M);
                self.amiss = 0;
                self.phase = Phase::Compare;
                self.pair = (0, 0);
                self.next_pair();
            }
            Phase::Collect(_) => self.collect(report),
            Phase::Compare => return self.step(now_ns, clocks),
        }
        None
    }

    fn begin(&mut self, until_ns: i64) {
        self.phase = Phase::Collect(until_ns);
        self.focus_m = None;
        self.seen.iter_mut().for_each(Vec::clear);
    }

    fn collect(&mut self, report: &SensorTrack) {
        let source = usize::from(report.source);
        let [vx, vy, _] = report.velocity_mps;
        let [x, y, _] = report.position_m;
        let says_enough = report.state == TrackState::Confirmed as u8
            && report.has(sensor_track_bits::VELOCITY)
            && vx.hypot(vy) > SPEED_MIN_MPS;
        if !says_enough {
            return;
        }
        let focus_m = *self.focus_m.get_or_insert([x, y]);
        if !is_near(&[x, y], &focus_m, self.reach_m) {
            return;
        }
        let variance = |index: usize| report.covariance.get(index, index);
        let seen = Seen {
            time_ns: report.time_of_measurement_ns,
            track_number: report.track_number,
            height_m: report.has(sensor_track_bits::HEIGHT).then_some(report.position_m[2]),
            identity: report.identity,
            motion: Motion {
                position_m: [x, y],
                velocity_mps: [vx, vy],
                place_m: self.places_m[source],
            },
            position_m2: 0.5 * (variance(0) + variance(1)),
            velocity_m2ps2: 0.5 * (variance(3) + variance(4)),
        };
        let tracks = &mut self.seen[source];
        let known = tracks.iter().position(|seen| seen.track_number == report.track_number);
        if let Some(place) = known {
            tracks[place] = seen;
            return;
        }
        while self.seen[source].len() == TRACKS_MAX {
            // So that it is the same targets that are seen of all sources.
            self.reach_m *= NARROWER;
            for tracks in &mut self.seen {
                tracks.retain(|seen| is_near(&seen.motion.position_m, &focus_m, self.reach_m));
            }
        }
        if is_near(&[x, y], &focus_m, self.reach_m) {
            self.seen[source].push(seen);
        }
    }

    /// Turns to the next two sources of which enough was seen; after the last ones there is a pause.
    fn next_pair(&mut self) {
        let count = self.seen.len();
        let enough = |source: usize| self.seen[source].len() >= TRACKS_MIN;
        let (mut first, mut second) = self.pair;
        loop {
            second += 1;
            if second >= count {
                first += 1;
                second = first + 1;
            }
            if second >= count {
                self.pair = (count, count);
                return;
            }
            if enough(first) && enough(second) {
                self.pair = (first, second);
                self.turn_to(Job::AsTheyAre);
                self.same_address = 0;
                return;
            }
        }
    }

    fn turn_to(&mut self, job: Job) {
        (self.job, self.row, self.sum) = (job, 0, [0.0; 4]);
    }

    /// Compares some pairs of tracks.
    fn step(&mut self, now_ns: i64, clocks: &[ClockError]) -> Option<u16> {
        let (first, second) = self.pair;
        if first == self.seen.len() {
            let pause_s = PAUSE_S[self.amiss];
            self.phase = Phase::Pause(now_ns.saturating_add((pause_s * NS_PER_S) as i64));
            return self.judge(clocks);
        }
        let mut work = 0;
        while work < STEP_PAIRS && self.row < self.seen[first].len() {
            self.compare_row(first, second);
            work += self.seen[second].len();
            self.row += 1;
        }
        if self.row == self.seen[first].len() {
            self.finish(first, second);
        }
        None
    }

    /// Compares one track of the first source with all of the second one.
    fn compare_row(&mut self, first: usize, second: usize) {
        let own = self.seen[first][self.row];
        let mut best: Option<(f64, [f64; 2], f64, bool)> = None;
        for other in 0..self.seen[second].len() {
            let other = &self.seen[second][other];
            let Some((motion, sigma)) = comparable(&own, other) else {
                continue;
            };
            match self.job {
                Job::Vote => {
                    for (hypothesis, (side, kind)) in HYPOTHESES.iter().enumerate() {
                        let (erring, true_one) = sides(*side, &own.motion, &motion);
                        if let Some(value) = erring.implied(true_one, *kind, sigma)
                            && fits(&erring.without(*kind, value), true_one, sigma.without(*kind, value)).is_some()
                        {
                            self.votes.add(hypothesis, *kind, value);
                        }
                    }
                }
                Job::AsTheyAre | Job::Refine(_) | Job::Try(_) => {
                    let (side, kind, value) = match self.job {
                        Job::Refine(h) | Job::Try(h) => (HYPOTHESES[h].0, HYPOTHESES[h].1, self.values[h]),
                        _ => (Side::First, GrossKind::Position, [0.0; 2]),
                    };
                    let (erring, true_one) = sides(side, &own.motion, &motion);
                    // The bin is coarse.
                    let coarse = if matches!(self.job, Job::Refine(_)) { 2.0 } else { 1.0 };
                    let mut sigma = sigma.without(kind, value);
                    sigma.position_m *= coarse;
                    let d2 = fits(&erring.without(kind, value), true_one, sigma);
                    if let Some(d2) = d2.filter(|d2| best.is_none_or(|(least, ..)| *d2 < least))
                        && let Some(implied) = erring.implied(true_one, kind, sigma)
                    {
                        let weight = match (kind, erring.place_m) {
                            // An arc of so many metres is a smaller angle farther away.
                            (GrossKind::Azimuth, Some([east, north])) => {
                                let range_m = (erring.position_m[0] - east).hypot(erring.position_m[1] - north);
                                range_m * range_m
                            }
                            (GrossKind::Time, _) => {
                                let [vx, vy] = erring.velocity_mps;
                                vx * vx + vy * vy
                            }
                            _ => 1.0,
                        } / (sigma.position_m * sigma.position_m);
                        let address = own.identity.unique_number();
                        let same = address.is_some() && address == other.identity.unique_number();
                        best = Some((d2, implied, weight, same));
                    }
                }
            }
        }
        if let Some((d2, implied, weight, same)) = best {
            let [score, east, north, weights] = &mut self.sum;
            *score += 1.0 - d2 / GATE;
            *east += weight * implied[0];
            *north += weight * implied[1];
            *weights += weight;
            self.same_address += u32::from(same && matches!(self.job, Job::Try(_)));
        }
    }

    /// Draws the conclusion from a job that is done, and turns to the next.
    fn finish(&mut self, first: usize, second: usize) {
        let fewer = self.seen[first].len().min(self.seen[second].len()) as f64;
        let [score, east, north, weights] = self.sum;
        let state = first * self.seen.len() + second;
        match self.job {
            Job::AsTheyAre => {
                self.as_they_are = score;
                if score >= AGREES * fewer {
                    self.pairs[state] = PairState {
                        agree: true,
                        ..PairState::default()
                    };
                    return self.next_pair();
                }
                self.amiss = self.amiss.max(1);
                *self.votes = Votes::default();
                self.turn_to(Job::Vote);
            }
            Job::Vote => {
                for (hypothesis, (_, kind)) in HYPOTHESES.iter().enumerate() {
                    self.values[hypothesis] = self.votes.fullest(hypothesis).map(|bins| bins * bin(*kind));
                }
                self.turn_to(Job::Refine(0));
            }
            Job::Refine(hypothesis) => {
                if weights > 0.0 {
                    self.values[hypothesis] = [east / weights, north / weights];
                }
                self.turn_to(Job::Try(hypothesis));
            }
            Job::Try(hypothesis) => {
                if weights > 0.0 {
                    self.values[hypothesis] = [east / weights, north / weights];
                }
                self.scores[hypothesis] = score;
                if hypothesis + 1 < HYPOTHESES.len() {
                    self.turn_to(Job::Refine(hypothesis + 1));
                    return;
                }
                self.note(state, fewer);
                self.next_pair();
            }
        }
    }

    /// Notes what was found of two sources, of which `fewer` tracks could fit.
    fn note(&mut self, state: usize, fewer: f64) {
        let state = &mut self.pairs[state];
        state.agree = false;
        state.addresses = self.same_address;
        for (hypothesis, (_, kind)) in HYPOTHESES.iter().enumerate() {
            let (score, value) = (self.scores[hypothesis], self.values[hypothesis]);
            let found = &mut state.found[hypothesis];
            let explains =
                score >= (TRACKS_MIN as f64 - 1.0).max(EXPLAINS * fewer) && score - self.as_they_are >= GAINS * score;
            if !explains {
                *found = Found::default();
                continue;
            }
            self.amiss = 2;
            let is_same = (0..2).all(|axis| (value[axis] - found.value[axis]).abs() <= 2.0 * bin(*kind));
            if found.windows == 0 || !is_same {
                *found = Found::default();
            }
            let sum = found.score + score;
            for (mean, value) in found.value.iter_mut().zip(value) {
                *mean += (value - *mean) * score / sum;
            }
            (found.score, found.windows) = (sum, found.windows + 1);
        }
    }

    /// Decides whose error it is; the source whose correction has changed, if one has.
    fn judge(&mut self, clocks: &[ClockError]) -> Option<u16> {
        let count = self.seen.len();
        for source in 0..count {
            let removed = self.removed[source];
            // What is taken off shows no more; that it is, is still to be told.
            self.errors[source] = self.errors[source].filter(|_| removed.is_some());
        }
        let worse_clock = |first: usize, second: usize| {
            let apart_s = clocks[first].excess_s - clocks[second].excess_s;
            (apart_s.abs() > CLOCK_WORSE_S).then_some(if apart_s > 0.0 { first } else { second })
        };
        let mut changed = None;
        for first in 0..count {
            for second in first + 1..count {
                let state = self.pairs[first * count + second];
                let Some(hypothesis) = state.best() else {
                    continue;
                };
                let [of_first, of_second] = [first, second].map(|source| self.supporters(source));
                let agree =
                    |source: usize| (0..count).any(|other| self.pair_of(source, other).is_some_and(|p| p.agree));
                let mut culprit = match HYPOTHESES[hypothesis].0 {
                    Side::First => first,
                    Side::Second => second,
                };
                let mut is_certain = false;
                if self.reference == Some(first) || self.reference == Some(second) {
                    culprit = if self.reference == Some(first) { second } else { first };
                    is_certain = true;
                } else if let (GrossKind::Time, Some(worse)) = (HYPOTHESES[hypothesis].1, worse_clock(first, second)) {
                    (culprit, is_certain) = (worse, true);
                } else if of_first >= 2 && agree(second) && !agree(first) {
                    (culprit, is_certain) = (first, true);
                } else if of_second >= 2 && agree(first) && !agree(second) {
                    (culprit, is_certain) = (second, true);
                } else if state.addresses >= 3 {
                    let kind = HYPOTHESES[hypothesis].1;
                    let other = first + second - culprit;
                    let needs_place = matches!(kind, GrossKind::Azimuth | GrossKind::Range);
                    is_certain = needs_place && self.places_m[other].is_none();
                }
                let Some((kind, value)) = self.error_as(culprit, first, second) else {
                    continue;
                };
                let is_known = |error: GrossError| error.is_certain && !is_certain;
                if self.errors[culprit].is_some_and(is_known) {
                    continue;
                }
                let partner = (first + second - culprit) as u16;
                let is_removed = is_certain && self.removes;
                let mut total = value;
                if is_removed {
                    total = match self.removed[culprit] {
                        Some((before, already)) if before == kind => [0, 1].map(|axis| value[axis] + already[axis]),
                        // It was no error of that kind: all begins anew.
                        Some(_) => [0.0; 2],
                        None => value,
                    };
                    let is_gone = total.iter().all(|part| part.abs() < bin(kind));
                    self.removed[culprit] = (!is_gone).then_some((kind, total));
                    self.epochs[culprit] = self.epochs[culprit].wrapping_add(1);
                    changed = Some(culprit as u16);
                }
                self.errors[culprit] = Some(GrossError {
                    kind,
                    value: total,
                    partner,
                    is_certain,
                    is_removed,
                })
                .filter(|_| !is_removed || self.removed[culprit].is_some());
                if changed.is_some() {
                    // Reports are others from now on.
                    self.forget(culprit);
                    return changed;
                }
            }
        }
        changed
    }

    fn pair_of(&self, one: usize, other: usize) -> Option<&PairState> {
        let (first, second) = (one.min(other), one.max(other));
        (one != other).then(|| &self.pairs[first * self.seen.len() + second])
    }

    /// How many other sources show that `source`, or they, are off.
    fn supporters(&self, source: usize) -> usize {
        let others = 0..self.seen.len();
        others
            .filter(|other| self.pair_of(source, *other).is_some_and(|pair| pair.best().is_some()))
            .count()
    }

    /// The error of `culprit` that explains most of what it shows with the others, and its mean.
    fn error_as(&self, culprit: usize, first: usize, second: usize) -> Option<(GrossKind, [f64; 2])> {
        let side = if culprit == first { Side::First } else { Side::Second };
        let pair = &self.pairs[first * self.seen.len() + second];
        // Times and places differ; whose error it is turns the sign.
        let candidates = HYPOTHESES.iter().enumerate().filter_map(|(hypothesis, (of, kind))| {
            let turns = matches!(kind, GrossKind::Time | GrossKind::Position) && side == Side::Second;
            let found = &pair.found[hypothesis];
            let usable = found.windows >= WINDOWS_MIN && (*of == side || turns);
            let value = if turns {
                found.value.map(|part| -part)
            } else {
                found.value
            };
            usable.then_some((found.score, *kind, value))
        });
        let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, kind, value)| (kind, value))
    }

    fn forget(&mut self, source: usize) {
        let count = self.seen.len();
        for other in (0..count).filter(|other| *other != source) {
            let (first, second) = (source.min(other), source.max(other));
            self.pairs[first * count + second] = PairState::default();
        }
    }
}

/// Whether a place is within a square of this half-width.
fn is_near(place_m: &[f64; 2], middle_m: &[f64; 2], reach_m: f64) -> bool {
    (0..2).all(|axis| (place_m[axis] - middle_m[axis]).abs() <= reach_m)
}

/// The erring one of two, and the one that is taken as true.
fn sides<'a>(side: Side, own: &'a Motion, other: &'a Motion) -> (&'a Motion, &'a Motion) {
    match side {
        Side::First => (own, other),
        Side::Second => (other, own),
    }
}

/// The other track at the time of the own one, and how far the two may be apart besides an error; `None` if they are
/// surely not of one target.
fn comparable(own: &Seen, other: &Seen) -> Option<(Motion, Sigma)> {
    let heights = own.height_m.zip(other.height_m);
    let speed = |seen: &Seen| seen.motion.velocity_mps[0].hypot(seen.motion.velocity_mps[1]);
    let velocity_mps = (own.velocity_m2ps2 + other.velocity_m2ps2)
        .sqrt()
        .hypot(VELOCITY_FLOOR_MPS);
    if heights.is_some_and(|(own_m, other_m)| (own_m - other_m).abs() > HEIGHT_GATE_M)
        || (speed(own) - speed(other)).abs() > 3.0 * velocity_mps
        || own.identity.contradicts(&other.identity)
    {
        return None;
    }
    let (motion, moved_m) = other.at(own.time_ns);
    let position_m = (own.position_m2 + other.position_m2)
        .sqrt()
        .hypot(moved_m)
        .hypot(POSITION_FLOOR_M);
    let sigma = Sigma {
        position_m,
        velocity_mps,
    };
    Some((motion, sigma))
}

/// d² between two motions of one time with these deviations per axis; `None` beyond the gate.
fn fits(a: &Motion, b: &Motion, sigma: Sigma) -> Option<f64> {
    let squared = |a: [f64; 2], b: [f64; 2], sigma: f64| {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        (dx * dx + dy * dy) / (sigma * sigma)
    };
    let d2 = squared(a.position_m, b.position_m, sigma.position_m)
        + squared(a.velocity_mps, b.velocity_mps, sigma.velocity_mps);
    (d2 <= GATE).then_some(d2)
}
