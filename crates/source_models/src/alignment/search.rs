//! Search for the biases that would bring the tracks of two sources together.
//!
//! Problem: a source that is half a degree off shows a target at 100 km nearly a kilometre aside. No tracks join, so
//! the assignment of tracks between the two sources is unknown. A comparison of only the nearest tracks would find the
//! density of the traffic, not the bias.
//!
//! Method: a generalised Hough transform, a bounded number of pairs of tracks with each report.
//! 1. *Collect* the latest report of each fast, confirmed track in a part of the area. The part narrows until no source
//!    has more than [`TRACKS_MAX`] tracks there, so that all sources contribute the same targets.
//! 2. *Compare* every two sources, at first without a bias: if most tracks fit, the two sources agree. Of many sources,
//!    each is compared with [`PARTNERS_MAX`] others, and with those to which it seemed to be off.
//! 3. *Vote*: each pair of tracks that move alike implies one value of each kind of bias. Values of pairs of different
//!    targets are scattered; values of pairs of the same target pile up in a bin of the histogram.
//! 4. *Refine* the fullest bin of each kind by the weighted mean of the fitting pairs, then *try* the refined value on
//!    all tracks. The score is the number of explained tracks, each reduced by its distance.
//!    If enough tracks of both sources bear the same rare name (module `pairing`), only these pairs are compared, and
//!    smaller biases show.
//! 5. *Record* the score in the [`PairFindings`]. A bias counts when collections of different parts of the area agree.
//!
//! Limits: slow targets carry too little information; biases beyond the histogram and two kinds at once are not found.
//!
//! Source: D. H. Ballard, *Generalizing the Hough transform to detect arbitrary shapes*, Pattern Recognition 13 (1981).

use estimation::length;
use messages::{BiasKind, Identity, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::alignment::findings::{BiasEstimate, GATE, HYPOTHESES, PairFindings, Side, WINDOWS_MIN, bin};
use crate::alignment::pairing::{DirectedSums, NAMED_SURE, TrackNames, are_near, is_named_bias};
use crate::alignment::votes::Votes;
use crate::gross::{Sigma, TrackMotion};
use crate::settings::{IdentitySettings, SourceSettings, longest_period_s};

/// Largest and smallest number of compared tracks of a source.
pub(super) const TRACKS_MAX: usize = 40;
pub(super) const TRACKS_MIN: usize = 4;
/// Largest number of other sources that a source is compared with, beside those that it differed from before: a verdict
/// needs two that disagree, and one with which either agrees. The work of a search grows with the sources, not with
/// their square.
const PARTNERS_MAX: usize = 8;
/// Largest number of pairs of tracks compared with a report, minus the pairs of one track.
const STEP_PAIRS: usize = 128;
/// Half-width of the searched part of the area, at first and at most, metres, and factors of change.
const REACH_MAX_M: f64 = 400e3;
const NARROWER: f64 = 0.8;
const WIDER: f64 = 1.5;
/// Duration of a collection: in periods of the slowest source, and least and largest duration, seconds.
const COLLECT_PERIODS: f64 = 1.3;
const COLLECT_S: [f64; 2] = [4.0, 15.0];
/// Pause before the next collection: after agreement of all sources, after a disagreement, and after an error, seconds.
const PAUSE_S: [f64; 3] = [15.0, 3.0, 0.0];
/// Least speed of a track with enough information, metres per second.
const SPEED_MIN_MPS: f64 = 5.0;
/// Additional deviations between two tracks of a target, metres and metres per second, and the unpredictable
/// acceleration, metres per second squared.
const POSITION_FLOOR_M: f64 = 40.0;
const VELOCITY_FLOOR_MPS: f64 = 5.0;
const ACCELERATION_MPS2: f64 = 2.0;
/// Greatest difference of heights, metres.
const HEIGHT_GATE_M: f64 = 400.0;
/// Share of fitting tracks at which two sources agree, and below which two sources disagree; least share of tracks
/// explained by a bias, and least improvement over no bias.
const AGREES: f64 = 0.6;
const DISAGREES: f64 = 0.3;
const EXPLAINS: f64 = 0.4;
const GAINS: f64 = 0.35;
/// Latest report of a track.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct TrackSample {
    time_ns: i64,
    track_number: u32,
    height_m: Option<f64>,
    identity: Identity,
    names: TrackNames,
    motion: TrackMotion,
    /// Variances per axis, m² and m²/s².
    position_m2: f64,
    velocity_m2ps2: f64,
}

impl TrackSample {
    /// Motion at `time_ns`, and the added variance per axis, m².
    fn at(&self, time_ns: i64) -> (TrackMotion, f64) {
        let seconds = (time_ns - self.time_ns) as f64 / NS_PER_S;
        let mut motion = self.motion;
        for axis in 0..2 {
            motion.position_m[axis] += motion.velocity_mps[axis] * seconds;
        }
        let unforeseen_m = (0.5 * ACCELERATION_MPS2 * seconds * seconds).min(ACCELERATION_MPS2 * 4.0 * seconds.abs());
        let passed_s2 = seconds * seconds;
        (motion, self.velocity_m2ps2 * passed_s2 + unforeseen_m * unforeseen_m)
    }
}

/// Stage of the search.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Phase {
    /// No work until this time, nanoseconds.
    Pause(i64),
    /// Collection of reports until this time, nanoseconds.
    Collect(i64),
    /// Comparison of two sources.
    Compare,
}

/// Part of the comparison of two sources.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Job {
    /// Phase of the search: fit without a bias.
    AsTheyAre,
    /// Votes: errors implied by pairs of tracks.
    Vote,
    /// Refinement of a roughly found error.
    Refine(usize),
    /// Phase of the search: fit after removal of the bias.
    Try(usize),
}

/// Search over all pairs of sources.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct BiasSearch {
    places_m: Vec<Option<[f64; 2]>>,
    /// Tracks collected of each source.
    samples: Vec<Vec<TrackSample>>,
    phase: Phase,
    /// Centre and half-width of the part of the area with collected tracks.
    focus_m: Option<[f64; 2]>,
    reach_m: f64,
    /// Rank of each source among those with enough tracks, and the number of these.
    ranks: Vec<Option<usize>>,
    ranked: usize,
    /// Compared sources, present stage, and the next track of the first source.
    pair: (usize, usize),
    job: Job,
    row: usize,
    votes: Box<Votes>,
    /// Sums of the present stage, and results so far.
    sum: [f64; 4],
    as_they_are: f64,
    values: [[f64; 2]; HYPOTHESES.len()],
    scores: [f64; HYPOTHESES.len()],
    same_address: u32,
    /// Track of the second source with the name of each track of the first source, if names suffice.
    partners: Vec<Option<u8>>,
    named: usize,
    directed: DirectedSums,
    pairs: Vec<PairFindings>,
    /// Worst result of the present comparisons: 0 agreement, 1 disagreement, 2 a bias.
    amiss: usize,
}

impl BiasSearch {
    pub(super) fn new(sources: &[SourceSettings]) -> Self {
        let count = sources.len();
        Self {
            places_m: sources.iter().map(|source| source.place_m).collect(),
            samples: (0..count).map(|_| Vec::with_capacity(TRACKS_MAX)).collect(),
            phase: Phase::Pause(i64::MIN),
            focus_m: None,
            reach_m: REACH_MAX_M,
            ranks: vec![None; count],
            ranked: 0,
            pair: (0, 0),
            job: Job::AsTheyAre,
            row: 0,
            votes: Box::default(),
            sum: [0.0; 4],
            as_they_are: 0.0,
            values: [[0.0; 2]; HYPOTHESES.len()],
            scores: [0.0; HYPOTHESES.len()],
            same_address: 0,
            partners: Vec::with_capacity(TRACKS_MAX),
            named: 0,
            directed: DirectedSums::default(),
            pairs: vec![PairFindings::default(); count * count],
            amiss: 0,
        }
    }

    /// Places of the sources' sensors, east and north, metres.
    pub(super) fn places_m(&self) -> &[Option<[f64; 2]>] {
        &self.places_m
    }

    /// Findings on all pairs of sources, by first × number of sources + second.
    pub(super) fn pairs(&self) -> &[PairFindings] {
        &self.pairs
    }

    pub(super) fn pair_mut(&mut self, place: usize) -> &mut PairFindings {
        &mut self.pairs[place]
    }

    /// Whether a source disagrees with two others that agree with each other.
    pub(super) fn is_doubtful(&self, source: usize) -> bool {
        let count = self.samples.len();
        let pair = |one: usize, other: usize| &self.pairs[one.min(other) * count + one.max(other)];
        let disagrees = |other: usize| other != source && pair(source, other).disagree;
        (0..count)
            .filter(|one| disagrees(*one))
            .any(|one| (one + 1..count).any(|other| disagrees(other) && pair(one, other).agree))
    }

    /// Continues the search with a valid report; true when all pairs of sources have been compared.
    pub(super) fn take(
        &mut self,
        report: &SensorTrack,
        now_ns: i64,
        (sources, identity): (&[SourceSettings], Option<&IdentitySettings>),
    ) -> bool {
        match self.phase {
            Phase::Pause(until_ns) if now_ns >= until_ns => {
                let [least_s, most_s] = COLLECT_S;
                let collect_s = (COLLECT_PERIODS * longest_period_s(sources)).clamp(least_s, most_s);
                self.begin(now_ns.saturating_add((collect_s * NS_PER_S) as i64));
                self.collect(report, identity);
            }
            Phase::Pause(_) => {}
            Phase::Collect(until_ns) if now_ns >= until_ns => {
                self.reach_m = (self.reach_m * WIDER).min(REACH_MAX_M);
                self.amiss = 0;
                self.phase = Phase::Compare;
                self.pair = (0, 0);
                self.rank();
                self.next_pair();
                if self.pair.0 == self.samples.len() {
                    // Tracks are young, or few: the next collection should not be late.
                    self.amiss = 1;
                }
            }
            Phase::Collect(_) => self.collect(report, identity),
            Phase::Compare => return self.step(now_ns),
        }
        false
    }

    fn begin(&mut self, until_ns: i64) {
        self.phase = Phase::Collect(until_ns);
        self.focus_m = None;
        self.samples.iter_mut().for_each(Vec::clear);
    }

    fn collect(&mut self, report: &SensorTrack, identity: Option<&IdentitySettings>) {
        let source = usize::from(report.source);
        let [vx, vy, _] = report.velocity_mps;
        let [x, y, _] = report.position_m;
        let is_informative = report.state == TrackState::Confirmed as u8
            && report.has(sensor_track_bits::VELOCITY)
            && vx * vx + vy * vy > SPEED_MIN_MPS * SPEED_MIN_MPS;
        if !is_informative {
            return;
        }
        let focus_m = *self.focus_m.get_or_insert([x, y]);
        if !is_near(&[x, y], &focus_m, self.reach_m) {
            return;
        }
        let variance = |index: usize| report.covariance.get(index, index);
        let sample = TrackSample {
            time_ns: report.time_of_measurement_ns,
            track_number: report.track_number,
            height_m: report.has(sensor_track_bits::HEIGHT).then_some(report.position_m[2]),
            identity: report.identity,
            names: identity.map_or(TrackNames::default(), |settings| {
                TrackNames::of(&report.identity, settings)
            }),
            motion: TrackMotion {
                position_m: [x, y],
                velocity_mps: [vx, vy],
                place_m: self.places_m[source],
            },
            position_m2: 0.5 * (variance(0) + variance(1)),
            velocity_m2ps2: 0.5 * (variance(3) + variance(4)),
        };
        let tracks = &mut self.samples[source];
        let known = tracks
            .iter()
            .position(|sample| sample.track_number == report.track_number);
        if let Some(place) = known {
            tracks[place] = sample;
            return;
        }
        while self.samples[source].len() == TRACKS_MAX {
            // A narrower area, so that all sources contribute the same targets.
            self.reach_m *= NARROWER;
            for tracks in &mut self.samples {
                tracks.retain(|sample| is_near(&sample.motion.position_m, &focus_m, self.reach_m));
            }
        }
        if is_near(&[x, y], &focus_m, self.reach_m) {
            self.samples[source].push(sample);
        }
    }

    /// Ranks the sources with enough tracks.
    fn rank(&mut self) {
        self.ranked = 0;
        for (rank, tracks) in self.ranks.iter_mut().zip(&self.samples) {
            *rank = (tracks.len() >= TRACKS_MIN).then_some(self.ranked);
            self.ranked += usize::from(rank.is_some());
        }
    }

    /// Whether two sources are to be compared.
    fn is_wanted(&self, first: usize, second: usize) -> bool {
        let Some((one, other)) = self.ranks[first].zip(self.ranks[second]) else {
            return false;
        };
        let apart = one.abs_diff(other);
        let round = apart.min(self.ranked - apart);
        round <= PARTNERS_MAX / 2
            || self.ranked <= PARTNERS_MAX + 1
            || self.pairs[first * self.samples.len() + second].is_open()
    }

    /// Turns to the next two sources to be compared; a pause follows the last pair.
    fn next_pair(&mut self) {
        let count = self.samples.len();
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
            if self.is_wanted(first, second) {
                self.pair = (first, second);
                self.turn_to(Job::AsTheyAre);
                self.same_address = 0;
                self.find_partners(first, second);
                return;
            }
        }
    }

    /// Finds the pairs of tracks with the same name, if enough for a comparison of only these pairs.
    fn find_partners(&mut self, first: usize, second: usize) {
        self.partners.clear();
        self.directed = DirectedSums::default();
        let [own, others] = [first, second].map(|source| &self.samples[source]);
        for track in own {
            let alike = |other: &&TrackSample| {
                track.names.name(&other.names)
                    && are_near(&track.motion, &other.motion)
                    && comparable(track, other).is_some()
            };
            let mut found = others.iter().enumerate().filter(|(_, other)| alike(other));
            let is_alone = || own.iter().filter(|other| track.names.name(&other.names)).count() == 1;
            let partner = found.next().filter(|_| found.next().is_none() && is_alone());
            self.partners.push(partner.map(|(index, _)| index as u8));
        }
        self.named = self.partners.iter().flatten().count();
        if self.named < TRACKS_MIN {
            self.named = 0;
        }
    }

    fn turn_to(&mut self, job: Job) {
        (self.job, self.row, self.sum) = (job, 0, [0.0; 4]);
    }

    /// Compares some pairs of tracks; true when all pairs of sources have been compared.
    fn step(&mut self, now_ns: i64) -> bool {
        let (first, second) = self.pair;
        if first == self.samples.len() {
            let pause_s = PAUSE_S[self.amiss];
            self.phase = Phase::Pause(now_ns.saturating_add((pause_s * NS_PER_S) as i64));
            return true;
        }
        let mut work = 0;
        while work < STEP_PAIRS && self.row < self.samples[first].len() {
            self.compare_row(first, second);
            work += if self.named > 0 { 1 } else { self.samples[second].len() };
            self.row += 1;
        }
        if self.row == self.samples[first].len() {
            self.finish(first, second);
        }
        false
    }

    /// Compares a track of the first source with all tracks of the second source.
    fn compare_row(&mut self, first: usize, second: usize) {
        let own = self.samples[first][self.row];
        let mut best: Option<(f64, [f64; 2], f64, bool)> = None;
        let compared = match self.partners[self.row] {
            _ if self.named == 0 => 0..self.samples[second].len(),
            Some(partner) => usize::from(partner)..usize::from(partner) + 1,
            None => 0..0,
        };
        for other in compared {
            let other = &self.samples[second][other];
            let Some((motion, sigma)) = comparable(&own, other) else {
                continue;
            };
            if self.named > 0 && matches!(self.job, Job::AsTheyAre) {
                self.directed.add(&own.motion, &motion, sigma.position_m);
            }
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
                        _ => (Side::First, BiasKind::Position, [0.0; 2]),
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
                            // An arc of a given length is a smaller angle farther away.
                            (BiasKind::Azimuth, Some([east, north])) => {
                                let (dx, dy) = (erring.position_m[0] - east, erring.position_m[1] - north);
                                dx * dx + dy * dy
                            }
                            (BiasKind::Time, _) => {
                                let [vx, vy] = erring.velocity_mps;
                                vx * vx + vy * vy
                            }
                            _ => 1.0,
                        } / (sigma.position_m * sigma.position_m);
                        let address = own.identity.unique_number();
                        let same = self.named > 0 || (address.is_some() && address == other.identity.unique_number());
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

    /// Evaluates a completed job, and turns to the next.
    fn finish(&mut self, first: usize, second: usize) {
        let fewer = match self.named {
            0 => self.samples[first].len().min(self.samples[second].len()),
            named => named,
        } as f64;
        let [score, east, north, weights] = self.sum;
        let state = first * self.samples.len() + second;
        match self.job {
            Job::AsTheyAre => {
                self.as_they_are = score;
                let is_settled = match self.named {
                    0 => score >= AGREES * fewer,
                    _ => score >= AGREES * fewer && !self.directed.are_suspicious(),
                };
                if is_settled {
                    return self.record_agreement(state);
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
                let has_bias = (0..HYPOTHESES.len()).any(|hypothesis| self.explains(hypothesis, fewer));
                if self.named > 0 && !has_bias && self.as_they_are >= AGREES * fewer {
                    return self.record_agreement(state);
                }
                self.record(state, fewer);
                self.next_pair();
            }
        }
    }

    /// Records that two sources agree, and turns to the next pair.
    fn record_agreement(&mut self, state: usize) {
        self.pairs[state] = PairFindings {
            agree: true,
            ..PairFindings::default()
        };
        self.next_pair();
    }

    /// Records the scores of two sources; the source with fewer tracks has `fewer`.
    fn record(&mut self, state: usize, fewer: f64) {
        let explained: [bool; HYPOTHESES.len()] = std::array::from_fn(|hypothesis| self.explains(hypothesis, fewer));
        let state = &mut self.pairs[state];
        state.agree = false;
        state.disagree = self.as_they_are < DISAGREES * fewer;
        state.addresses = self.same_address;
        for (hypothesis, (_, kind)) in HYPOTHESES.iter().enumerate() {
            let (score, value) = (self.scores[hypothesis], self.values[hypothesis]);
            let estimate = &mut state.estimates[hypothesis];
            if !explained[hypothesis] {
                *estimate = BiasEstimate::default();
                continue;
            }
            self.amiss = 2;
            let is_same = (0..2).all(|axis| (value[axis] - estimate.value[axis]).abs() <= 2.0 * bin(*kind));
            if estimate.windows == 0 || !is_same {
                *estimate = BiasEstimate::default();
            }
            let sum = estimate.score + score;
            for (mean, value) in estimate.value.iter_mut().zip(value) {
                *mean += (value - *mean) * score / sum;
            }
            let windows = if self.named >= NAMED_SURE { WINDOWS_MIN } else { 1 };
            (estimate.score, estimate.windows) = (sum, estimate.windows + windows);
        }
    }

    /// Whether a tried hypothesis explains the tracks; the source with fewer tracks has `fewer`.
    fn explains(&self, hypothesis: usize, fewer: f64) -> bool {
        let (score, (_, kind)) = (self.scores[hypothesis], HYPOTHESES[hypothesis]);
        let gain = score - self.as_they_are;
        let improves = match self.named {
            0 => gain >= GAINS * score,
            _ => is_named_bias(kind, self.values[hypothesis], gain, fewer),
        };
        score >= (TRACKS_MIN as f64 - 1.0).max(EXPLAINS * fewer) && improves
    }

    /// Discards the findings on a source and all others.
    pub(super) fn forget(&mut self, source: usize) {
        let count = self.samples.len();
        for other in (0..count).filter(|other| *other != source) {
            let (first, second) = (source.min(other), source.max(other));
            self.pairs[first * count + second] = PairFindings::default();
        }
    }
}

/// Whether a place is within a square of this half-width.
fn is_near(place_m: &[f64; 2], middle_m: &[f64; 2], reach_m: f64) -> bool {
    (0..2).all(|axis| (place_m[axis] - middle_m[axis]).abs() <= reach_m)
}

/// The source with the error, and the source taken as true.
fn sides<'a>(side: Side, own: &'a TrackMotion, other: &'a TrackMotion) -> (&'a TrackMotion, &'a TrackMotion) {
    match side {
        Side::First => (own, other),
        Side::Second => (other, own),
    }
}

/// Returns the other track at the time of the own track, and the permitted deviations apart from a bias; `None` for
/// certainly different targets.
fn comparable(own: &TrackSample, other: &TrackSample) -> Option<(TrackMotion, Sigma)> {
    let heights = own.height_m.zip(other.height_m);
    let speed = |sample: &TrackSample| length(sample.motion.velocity_mps);
    let velocity_m2ps2 = own.velocity_m2ps2 + other.velocity_m2ps2 + VELOCITY_FLOOR_MPS * VELOCITY_FLOOR_MPS;
    let velocity_mps = velocity_m2ps2.sqrt();
    if heights.is_some_and(|(own_m, other_m)| (own_m - other_m).abs() > HEIGHT_GATE_M)
        || (speed(own) - speed(other)).abs() > 3.0 * velocity_mps
        || own.identity.contradicts(&other.identity)
    {
        return None;
    }
    let (motion, moved_m2) = other.at(own.time_ns);
    let position_m2 = own.position_m2 + other.position_m2 + moved_m2 + POSITION_FLOOR_M * POSITION_FLOOR_M;
    let sigma = Sigma {
        position_m: position_m2.sqrt(),
        velocity_mps,
    };
    Some((motion, sigma))
}

/// d² between two simultaneous motions with these deviations per axis; `None` beyond the gate.
fn fits(a: &TrackMotion, b: &TrackMotion, sigma: Sigma) -> Option<f64> {
    let squared = |a: [f64; 2], b: [f64; 2], sigma: f64| {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        (dx * dx + dy * dy) / (sigma * sigma)
    };
    let d2 = squared(a.position_m, b.position_m, sigma.position_m)
        + squared(a.velocity_mps, b.velocity_mps, sigma.velocity_mps);
    (d2 <= GATE).then_some(d2)
}
