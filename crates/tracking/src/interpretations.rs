//! The interpretations of a scan by the hypotheses of one cluster, as ranked assignment problems (HT-5 … HT-8).
//!
//! Each hypothesis of the cluster poses a problem ([`crate::ranked`]): the rows are the cluster's detections, the
//! choices are the possible origins of each, and the costs are the negative logarithms of
//!
//! | taken for | likelihood, relative to false |
//! | --- | --- |
//! | false | 1 |
//! | new | density of new targets / density of false detections |
//! | of track T | probability of detection × density of the innovation / (false detections' density × that of a miss) |
//!
//! with the misses of all tracks and the reliability of the hypothesis as the base cost.
//!
//! If a hypothesis lacks expected tracks, the children with enough tracks are posed as additional problems. The costs
//! of these problems are lowered until the best such child ranks beside the best other child.

use crate::counts::TrackerCounts;
use crate::joined::JoinedClusters;
use crate::limits::{CLUSTER_TRACKS_MAX, PAIRS_MAX};
use crate::parents::Parents;
use crate::ranked::{Alternative, COLUMNS_MAX, OWN, PROBLEMS_MAX, Ranked, Solution};
use crate::settings::Starts;
use crate::unresolved::{PAIRS_OF_HYPOTHESIS_MAX, SHARED};

/// Most ways to begin the tracks that a parent lacks.
const WAYS_MAX: u64 = 64;
/// Meanings of choices that are no pairs.
const FALSE: u32 = u32::MAX;
const NEW: u32 = u32::MAX - 1;

/// Working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct Interpretations {
    ranked: Ranked,
    /// By problem: the parent.
    problems: Vec<InterpretationProblem>,
    /// (row, column, pair) of a hypothesis.
    entries: Vec<(u32, u32, u32)>,
    /// Pairs of a hypothesis that the sensor may not resolve.
    pairs: Vec<u32>,
}

/// A ranked problem: some of the children of a parent.
#[derive(Clone, Copy, Debug)]
struct InterpretationProblem {
    parent: usize,
    /// Only children with enough tracks.
    is_enough: bool,
    /// Reduction of the costs.
    lowered: f64,
}

/// Interpretation and parent hypothesis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interpretation {
    solution: Solution,
    pub(crate) parent: usize,
    /// Logarithm of the child's reliability, less a constant that all children of the cluster share.
    pub(crate) log_reliability: f64,
    /// Set if the child has as many tracks as expected; `None` if none are lacking.
    pub(crate) is_enough: Option<bool>,
}

/// Whether a row starts a new track.
#[derive(Clone, Copy, PartialEq)]
enum TrackStart {
    May,
    Must,
    MayNot,
}

impl Interpretations {
    pub(crate) fn new() -> Self {
        Self {
            ranked: Ranked::new(),
            problems: Vec::with_capacity(PROBLEMS_MAX),
            entries: Vec::with_capacity(CLUSTER_TRACKS_MAX * PAIRS_MAX),
            pairs: Vec::with_capacity(PAIRS_OF_HYPOTHESIS_MAX),
        }
    }

    /// Poses the problem of each parent and, if the parent lacks tracks, the problem of the children with enough
    /// tracks.
    pub(crate) fn pose(&mut self, joined: &JoinedClusters<'_>, parents: &Parents, counts: &mut TrackerCounts) {
        self.ranked.clear();
        self.problems.clear();
        for parent in 0..parents.list.len() {
            self.find_pairs(joined, parents, parent);
            for unresolved in 0..1 << self.pairs.len() {
                self.find_entries(joined, parents, parent, unresolved, counts);
                let base = self.base_cost(joined, parents, parent, unresolved);
                let posed = self.pose_problem(joined, parents, (parent, base), |_| TrackStart::May, counts);
                counts.hypotheses_dropped += u64::from(posed.is_none());
            }
        }
        for plain in 0..self.problems.len() {
            let parent = self.problems[plain].parent;
            let lacking = parents.list[parent].lacking_due;
            if lacking > 0 {
                self.pairs.clear();
                self.find_entries(joined, parents, parent, 0, counts);
                self.pose_enough(joined, parents, plain, lacking, counts);
            }
        }
        self.ranked.begin();
    }

    /// Whether some parent's children with enough tracks are posed apart.
    pub(crate) fn are_apart(&self) -> bool {
        self.problems.iter().any(|problem| problem.is_enough)
    }

    /// Cost of the next interpretation, if any.
    pub(crate) fn next_cost(&self) -> Option<f64> {
        self.ranked.next_cost()
    }

    /// The next interpretation, the likeliest first; `Some(None)` if another problem has the same interpretation, too.
    pub(crate) fn next(&mut self, parents: &Parents) -> Option<Option<Interpretation>> {
        let solution = self.ranked.next()?;
        let problem = self.problems[solution.problem];
        let lacking = parents.list[problem.parent].lacking_due;
        let is_enough = (lacking > 0).then(|| self.new_tracks(solution) >= lacking);
        let of_parent = |other: &InterpretationProblem| other.parent == problem.parent && other.is_enough;
        let is_elsewhere = !problem.is_enough && is_enough == Some(true) && self.problems.iter().any(of_parent);
        Some((!is_elsewhere).then(|| Interpretation {
            solution,
            parent: problem.parent,
            log_reliability: -solution.cost - problem.lowered,
            is_enough,
        }))
    }

    /// Logarithm of a likelihood that all interpretations that have not come out do not exceed together.
    pub(crate) fn log_left(&self) -> f64 {
        self.ranked.log_left()
    }

    /// Pairs that are taken in an interpretation.
    pub(crate) fn pairs(&self, of: &Interpretation) -> impl Iterator<Item = u32> + '_ {
        self.ranked.meanings(of.solution).filter(|meaning| *meaning < NEW)
    }

    /// Rows of detections that begin new tracks in an interpretation.
    pub(crate) fn new_rows(&self, of: &Interpretation) -> impl Iterator<Item = usize> + '_ {
        let rows = self.ranked.meanings(of.solution).enumerate();
        rows.filter(|(_, meaning)| *meaning == NEW).map(|(row, _)| row)
    }

    fn new_tracks(&self, solution: Solution) -> usize {
        self.ranked.meanings(solution).filter(|meaning| *meaning == NEW).count()
    }

    /// Poses the children that begin at least `lacking` new tracks, each child once: the first rows that begin a track
    /// are fixed, and the rows between begin none (WA-4).
    fn pose_enough(
        &mut self,
        joined: &JoinedClusters<'_>,
        parents: &Parents,
        plain: usize,
        lacking: usize,
        counts: &mut TrackerCounts,
    ) {
        let rows = joined.plots.len();
        let ways = binomial(rows, lacking);
        if ways > WAYS_MAX || self.problems.len() + ways as usize > PROBLEMS_MAX {
            counts.wide_area_uncorrected += 1;
            return;
        }
        let (first, parent) = (self.problems.len(), self.problems[plain].parent);
        let mut starts = if ways == 0 { 0 } else { u64::MAX >> (64 - lacking) };
        for _ in 0..ways {
            let last = 63 - starts.leading_zeros() as usize;
            let start = |row: usize| match starts >> row & 1 {
                1 => TrackStart::Must,
                _ if row < last => TrackStart::MayNot,
                _ => TrackStart::May,
            };
            let base = self.base_cost(joined, parents, parent, 0);
            self.pose_problem(joined, parents, (parent, base), start, counts);
            starts = next_of_as_many_bits(starts);
        }
        let best = (first..self.problems.len()).filter_map(|problem| self.ranked.best_cost(problem));
        let best = best.fold(f64::INFINITY, f64::min);
        let Some(lowered) = self.ranked.best_cost(plain).map(|plain| best - plain) else {
            return;
        };
        if lowered.is_finite() {
            for problem in first..self.problems.len() {
                self.ranked.lower(problem, lowered);
                self.problems[problem].lowered = lowered;
                self.problems[problem].is_enough = true;
            }
        }
    }

    /// Poses a problem of the parent with the entries found last. `None` if there is no room.
    fn pose_problem(
        &mut self,
        joined: &JoinedClusters<'_>,
        parents: &Parents,
        (parent, base): (usize, f64),
        start: impl Fn(usize) -> TrackStart,
        counts: &mut TrackerCounts,
    ) -> Option<()> {
        let (scan, sensor) = (joined.scan, joined.scan.sensor);
        self.ranked.begin_problem(base).then_some(())?;
        self.problems.push(InterpretationProblem {
            parent,
            is_enough: false,
            lowered: 0.0,
        });
        let lacking = parents.list[parent].lacking;
        let mut entry = 0;
        for (row, (_, plot)) in joined.plots.iter().enumerate() {
            let log_others = joined.shared[row].log_others;
            let log_clutter = scan.log_clutter[*plot as usize] + log_others;
            let log_weight = scan.log_weight + scan.plots[*plot as usize].log_weight;
            let log_share = log_share_of_new(joined, lacking, row);
            self.ranked.begin_row();
            let mut add = |column, meaning, cost| {
                let added = self.ranked.add(Alternative { column, meaning, cost });
                counts.dropped_pairs += u64::from(!added);
            };
            let start = start(row);
            let is_usable = log_weight > f64::NEG_INFINITY;
            if start != TrackStart::Must {
                add(OWN, FALSE, 0.0);
            }
            if let Some(log_share) = log_share.filter(|_| start != TrackStart::MayNot && is_usable) {
                add(OWN, NEW, log_others - log_share - log_weight);
            }
            while let Some(&(_, column, pair)) = self.entries.get(entry).filter(|(of, _, _)| *of == row as u32) {
                entry += 1;
                if start == TrackStart::Must || !is_usable {
                    continue;
                }
                let (log_likelihood, log_miss) = if pair & SHARED == 0 {
                    let found = scan.gating.pairs[pair as usize];
                    (found.log_likelihood, scan.gating.log_misses[found.track as usize])
                } else {
                    let found = scan.unresolved.detections[(pair & !SHARED) as usize];
                    let two = &scan.unresolved.pairs[found.pair as usize];
                    (found.log_likelihood, two.log_miss)
                };
                let gain = sensor.log_detection + log_likelihood - log_clutter - log_miss;
                add(column as u16, pair, -gain - log_weight);
            }
        }
        Some(())
    }

    /// Finds the pairs of a parent's tracks that the sensor may not resolve: the likeliest, no track twice.
    fn find_pairs(&mut self, joined: &JoinedClusters<'_>, parents: &Parents, parent: usize) {
        self.pairs.clear();
        let all = &joined.scan.unresolved.pairs;
        if all.is_empty() || parents.list[parent].lacking_due > 0 {
            return;
        }
        let members = parents.members(parent);
        let of = |pair: u32| &all[pair as usize];
        while self.pairs.len() < PAIRS_OF_HYPOTHESIS_MAX {
            let is_free = |track: &u32| {
                members.contains(track) && !self.pairs.iter().any(|pair| of(*pair).tracks.contains(track))
            };
            let free = (0..all.len() as u32).filter(|pair| of(*pair).tracks.iter().all(is_free));
            let best = free.max_by(|one, other| of(*one).log_unresolved.total_cmp(&of(*other).log_unresolved));
            let Some(best) = best else { break };
            self.pairs.push(best);
        }
    }

    /// Cost of a parent whose pairs in `unresolved` are, with all tracks missed.
    fn base_cost(&self, joined: &JoinedClusters<'_>, parents: &Parents, parent: usize, unresolved: u32) -> f64 {
        let scan = joined.scan;
        let log_miss = |track: &u32| scan.gating.log_misses[*track as usize];
        let misses: f64 = parents.members(parent).iter().map(log_miss).sum();
        let mut base = -parents.list[parent].log_reliability - misses;
        for (place, pair) in self.pairs.iter().enumerate() {
            let pair = &scan.unresolved.pairs[*pair as usize];
            base -= if unresolved >> place & 1 == 0 {
                pair.log_resolved
            } else {
                pair.log_unresolved + pair.log_miss - pair.tracks.iter().map(log_miss).sum::<f64>()
            };
        }
        base
    }

    /// The pairs of a parent by rows, with columns numbered in the order of the parent's tracks.
    fn find_entries(
        &mut self,
        joined: &JoinedClusters<'_>,
        parents: &Parents,
        parent: usize,
        unresolved: u32,
        counts: &mut TrackerCounts,
    ) {
        self.entries.clear();
        let mut column = 0;
        let all = &joined.scan.unresolved;
        for &pair in bits(&self.pairs, unresolved) {
            for place in all.pairs[pair as usize].detections.clone() {
                if let Some(row) = joined.known_row_of(all.detections[place as usize].plot) {
                    self.entries.push((row, column, SHARED | place));
                }
            }
            column += 1;
        }
        for &track in parents.members(parent) {
            let pairs = joined.pairs(track);
            let is_in_pair =
                || bits(&self.pairs, unresolved).any(|pair| all.pairs[*pair as usize].tracks.contains(&track));
            if pairs.is_empty() || unresolved > 0 && is_in_pair() {
                continue;
            }
            if column as usize >= COLUMNS_MAX {
                counts.dropped_pairs += pairs.len() as u64;
                continue;
            }
            for pair in pairs {
                let row = joined.row_of(joined.scan.gating.pairs[pair].plot);
                self.entries.push((row, column, pair as u32));
            }
            column += 1;
        }
        self.entries.sort_unstable();
    }
}

/// Logarithm of the expected number of new targets per false detection at a row's detection, for a parent that lacks so
/// many tracks; `None` if the detection may not start a track.
fn log_share_of_new(joined: &JoinedClusters<'_>, lacking: usize, row: usize) -> Option<f64> {
    let settings = joined.scan.settings;
    let place = joined.plots[row].1 as usize;
    let plot = &joined.scan.plots[place];
    let is_forbidden = settings.starts == Starts::Designated || joined.is_start_forbidden(row);
    if plot.measurement.place().is_none() || is_forbidden {
        return None;
    }
    let is_echo = joined.scan.gating.is_echo[place];
    let plain = if joined.scan.gating.names[place] {
        // A target that is named as that of a track has not left another track.
        settings.initiation.new_target_share
    } else {
        let (log_clutter, is_inside) = (joined.scan.log_clutter[place], joined.is_in_confirmed_gate(row));
        let departures = &joined.scan.departures;
        departures.new_target_share(place as u32, log_clutter, is_inside, settings)
    };
    let share = joined.support.new_target_share(plain, lacking);
    Some(if is_echo {
        (share * settings.identity.duplicated_probability).ln()
    } else {
        share.ln()
    })
}

/// The pairs of the set bits.
fn bits(pairs: &[u32], set: u32) -> impl Iterator<Item = &u32> {
    pairs
        .iter()
        .enumerate()
        .filter(move |(place, _)| set >> place & 1 == 1)
        .map(|(_, pair)| pair)
}

/// In how many ways `chosen` of `all` can be chosen, or more than are ever wanted.
fn binomial(all: usize, chosen: usize) -> u64 {
    if chosen > all {
        return 0;
    }
    let step = |ways: u64, k: usize| ways.saturating_mul((all - k) as u64) / (k as u64 + 1);
    (0..chosen.min(all - chosen)).fold(1, step)
}

/// The next larger number with as many bits set (R. W. Gosper).
fn next_of_as_many_bits(bits: u64) -> u64 {
    let lowest = bits & bits.wrapping_neg();
    let carried = bits.wrapping_add(lowest);
    if lowest == 0 || carried == 0 {
        return 0;
    }
    carried | (((bits ^ carried) >> 2) / lowest)
}
