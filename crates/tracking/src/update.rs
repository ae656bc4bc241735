//! One cluster, one scan: from its hypotheses before to its hypotheses after (HT-5 … HT-8).
//!
//! Each hypothesis of the cluster poses one ranked assignment problem ([`crate::ranked`]): its rows are the cluster's
//! detections, what each may be taken for are its choices, and their costs are negative logarithms of
//!
//! | taken for | likelihood, relative to false |
//! | --- | --- |
//! | false | 1 |
//! | new | density of new targets / density of false detections |
//! | of track T | probability of detection × density of the innovation / density of false detections / probability of a miss |
//!
//! with the misses of all its tracks and its own reliability as the problem's base. The children come out likeliest first;
//! their tracks are made when the first of them needs one, and shared by all that have it.

use std::ops::Range;

use messages::NS_PER_S;

use crate::counts::Counts;
use crate::directions::{Claims, Directions};
use crate::explanation::{ClusterRecord, CorrectionRecord, Explanation, Observer, TrackEvent, TrackRecord};
use crate::gating::NONE;
use crate::life::Deletion;
use crate::limits::{CLUSTER_TRACKS_MAX, HYPOTHESES_MAX, PAIRS_MAX};
use crate::log_sum::log_sum;
use crate::motion::Motion;
use crate::parents::{Asked, Parents};
use crate::population::{Cluster, Population};
use crate::ranked::{COLUMNS_MAX, Choice, OWN, PROBLEMS_MAX, ROWS_MAX, Ranked, Solution};
use crate::scan_context::ScanContext;
use crate::splitting::{DetectionCounts, Limits, mean_motion};
use crate::stage::Stage;
use crate::track::{NO_DETECTION, TENTATIVE, Track};
use crate::wide_area::correction::{Gains, Rule, has_enough};
use crate::wide_area::expectation::Expectation;
use crate::wide_area::settings::{EarlyConfirmation, EarlyDeletion};

/// Most children drawn for each that may be kept: some break the limits of SP-3 and SP-5.
const DRAWN_PER_KEPT: usize = 8;
/// Most children kept until they are reduced: twice as many where a wide-area report asks for those with enough tracks.
const CHILDREN_MAX: usize = 2 * HYPOTHESES_MAX;
/// Most ways to begin the tracks that a parent lacks of a wide-area report.
const WAYS_MAX: u64 = 64;
/// Meanings of choices that are no pairs.
const FALSE: u32 = u32::MAX;
const NEW: u32 = u32::MAX - 1;
/// Places of tracks that have not been made yet, or will not be.
const UNMADE: u32 = u32::MAX;
const REMOVED: u32 = u32::MAX - 1;

/// Working memory for one cluster after the other.
#[derive(Clone, Debug)]
pub(crate) struct Update {
    parents: Parents,
    ranked: Ranked,
    stage: Stage,
    /// By detection: its row in its cluster.
    row_of: Vec<u32>,
    /// By track: the pair that the present child takes, or [`NONE`].
    taken: Vec<u32>,
    /// By track, by pair, by row: where on the stage it is continued without a detection, updated, begun.
    missed: Vec<u32>,
    updated: Vec<u32>,
    begun: [u32; ROWS_MAX],
    in_confirmed_gate: [bool; ROWS_MAX],
    /// By problem: whose it is.
    posed: Vec<Posed>,
    /// By child that was made: its parent, and whether it has as many tracks as a wide-area report asks for.
    kin: Vec<(usize, bool)>,
    /// (row, column, pair) of one hypothesis.
    entries: Vec<(u32, u32, u32)>,
    /// (number, reliability) of confirmed tracks.
    numbers: Vec<(u32, f64)>,
    /// Branches of one of them.
    branches: Vec<u32>,
}

/// What one cluster's update works with.
struct Group<'a> {
    scan: &'a ScanContext<'a>,
    /// (cluster that stands for all, cluster).
    clusters: &'a [(u32, u32)],
    /// (cluster that stands for all, detection).
    plots: &'a [(u32, u32)],
    has_confirmed: bool,
    limits: Limits,
    /// WA-8: wide-area reports show nothing where any of the clusters is.
    is_absent: bool,
}

/// A ranked problem: some of the children of a parent.
#[derive(Clone, Copy, Debug)]
struct Posed {
    parent: usize,
    /// Only those with as many tracks as a wide-area report asks for.
    is_enough: bool,
    /// By how much their costs were lowered, so that they come out in the order of their corrected reliabilities, nearly.
    lowered: f64,
}

/// Whether a row starts a new track.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    May,
    Must,
    MayNot,
}

impl<'a> Group<'a> {
    fn clusters(&self) -> impl Iterator<Item = &'a Cluster> + use<'a> {
        let before = self.scan.before;
        self.clusters
            .iter()
            .map(|(_, cluster)| &before.clusters[*cluster as usize])
    }

    fn tracks(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.clusters().flat_map(|cluster| cluster.tracks.clone())
    }

    fn expectations(&self) -> impl Iterator<Item = Expectation> + use<'a> {
        let expectations = self.scan.expectations;
        self.clusters.iter().map(|(_, cluster)| expectations.of(*cluster))
    }

    /// WA-4: by the rule where a report is due; later, by the one that holds.
    fn asked(&self, expectation: &Expectation) -> Asked {
        let held = self.scan.settings.wide_area.held;
        let held = held.filter(|_| self.has_confirmed && expectation.targets.is_some());
        let correction = self.correction();
        Asked {
            targets: expectation.targets,
            correction: if expectation.is_due { correction } else { held },
            corrects_children: expectation.is_due && correction.is_some(),
        }
    }

    /// WA-4: how reports that are due correct.
    fn correction(&self) -> Option<Rule> {
        let wide_area = &self.scan.settings.wide_area;
        wide_area
            .correction
            .filter(|_| self.has_confirmed || !wide_area.corrects_confirmed_only)
    }

    /// WA-8: when tracks are given up where wide-area reports show none.
    fn early_deletion(&self) -> Option<EarlyDeletion> {
        self.scan.settings.wide_area.deletion.filter(|_| self.is_absent)
    }

    fn easier_confirmation(&self) -> Option<EarlyConfirmation> {
        let early = self.scan.settings.wide_area.confirmation;
        early.filter(|early| self.has_confirmed || !early.beside_confirmed_only)
    }

    /// WA-6: when tracks are believed, where wide-area reports show more targets than there are `confirmed` tracks.
    fn early_confirmation(&self, confirmed: usize) -> Option<EarlyConfirmation> {
        let targets: f64 = self.expectations().filter_map(|expectation| expectation.targets).sum();
        self.easier_confirmation().filter(|_| !has_enough(confirmed, targets))
    }

    fn pairs(&self, track: u32) -> Range<usize> {
        self.scan.gating.pairs_of(track)
    }
}

impl Update {
    pub(crate) fn new(tracks_max: usize, plots_max: usize) -> Self {
        let staged_tracks = CLUSTER_TRACKS_MAX * (PAIRS_MAX + 1) + ROWS_MAX;
        let members = CHILDREN_MAX * (CLUSTER_TRACKS_MAX + ROWS_MAX);
        Self {
            parents: Parents::new(HYPOTHESES_MAX, CLUSTER_TRACKS_MAX),
            ranked: Ranked::new(),
            stage: Stage::new(staged_tracks, CHILDREN_MAX, members),
            row_of: vec![NONE; plots_max],
            taken: vec![NONE; tracks_max],
            missed: vec![UNMADE; tracks_max],
            updated: vec![UNMADE; 4 * tracks_max + PAIRS_MAX],
            begun: [UNMADE; ROWS_MAX],
            in_confirmed_gate: [false; ROWS_MAX],
            posed: Vec::with_capacity(PROBLEMS_MAX),
            kin: Vec::with_capacity(CHILDREN_MAX),
            entries: Vec::with_capacity(CLUSTER_TRACKS_MAX * PAIRS_MAX),
            numbers: Vec::with_capacity(CLUSTER_TRACKS_MAX),
            branches: Vec::with_capacity(CLUSTER_TRACKS_MAX),
        }
    }

    /// Works off the clusters that the scan has joined with each other, and writes what they become to `next`.
    pub(crate) fn run(
        &mut self,
        scan: &ScanContext<'_>,
        clusters: &[(u32, u32)],
        plots: &[(u32, u32)],
        next: &mut Population,
        counts: &mut Counts,
    ) {
        let mut group = Group {
            scan,
            clusters,
            plots,
            has_confirmed: false,
            limits: Limits::NONE,
            is_absent: false,
        };
        group.is_absent = group.expectations().all(|expectation| expectation.is_absent);
        let (counted, first_number) = (*counts, next.next_number);
        let detections = DetectionCounts::of(group.clusters(), plots.len());
        self.prepare(&mut group, &detections, counts);
        let reduction = &scan.settings.reduction;
        let asked = group.expectations().map(|expectation| group.asked(&expectation));
        let clusters = group.clusters().zip(asked);
        let mut dropped = self.parents.gather(scan.before, clusters, reduction.hypotheses_max);
        let confirmed = self.numbers.len();
        self.pose(&group, counts);
        dropped += self.draw(&group, next, counts);
        let uncorrected = scan.observer.map(|_| self.share_of_enough());
        self.correct_children(group.correction());
        if let (Some(observer), Some(before)) = (scan.observer, uncorrected) {
            self.explain_corrections(&group, observer, before);
        }
        counts.wide_area_corrections += u64::from(self.parents.corrected);
        dropped += self.stage.reduce(reduction, counts);
        counts.drop_probability(dropped);
        let confirmation = &scan.settings.confirmation;
        let may_be = |track: &Track| confirmation.is_met(track);
        self.stage.confirm(may_be, &mut next.next_number, counts);
        let first_early = next.next_number;
        if let Some(early) = group.early_confirmation(confirmed) {
            let before = counts.confirmed;
            let may_be = |track: &Track| early.is_met(track);
            self.stage.confirm(may_be, &mut next.next_number, counts);
            counts.wide_area_confirmations += counts.confirmed - before;
        }
        if let Some(observer) = scan.observer {
            self.explain(
                &group,
                observer,
                [first_number, first_early],
                (&counted, counts),
                dropped,
            );
        }
        self.stage.separate(next, reduction, &detections, counts);
    }

    /// Tells what became of the cluster: before its parts are separated, when all of it is still there.
    fn explain(
        &self,
        group: &Group<'_>,
        observer: &dyn Observer,
        [first_number, first_early]: [u32; 2],
        (before, after): (&Counts, &Counts),
        dropped_probability: f64,
    ) {
        let scan = group.scan;
        let record = |track: &Track| TrackRecord::of(track, scan.plots, scan.first_serial);
        let staged = || self.stage.hypotheses().flat_map(|(_, tracks)| tracks);
        let (plain, early) = (&scan.settings.confirmation, group.easier_confirmation());
        for (place, track) in self.stage.tracks.iter().enumerate() {
            let earlier = &self.stage.tracks[..place];
            let is_new = track.number >= first_number && !earlier.iter().any(|other| other.number == track.number);
            if is_new {
                let branches = self.stage.tracks.iter().filter(|other| other.number == track.number);
                let best = branches.max_by(|one, other| one.reliability.total_cmp(&other.reliability));
                let best = best.unwrap_or(track);
                let (event, limit) = match early {
                    Some(early) if track.number >= first_early => {
                        (TrackEvent::ConfirmedEarly, early.confirmation.reliability_min)
                    }
                    _ => (TrackEvent::Confirmed, plain.reliability_min),
                };
                scan.explain(event, best, best.reliability, limit);
            }
        }
        for (place, number) in group.tracks().enumerate() {
            let track = &scan.before.tracks[number as usize];
            let root = |number: u32| scan.before.tracks[number as usize].root;
            let is_first = !group.tracks().take(place).any(|earlier| root(earlier) == track.root);
            if is_first && !staged().any(|left| left.root == track.root) {
                scan.explain(TrackEvent::Ended, track, f64::NAN, f64::NAN);
            }
        }
        let forbidden = |counts: &Counts| counts.too_many_new_tracks + counts.too_many_tentative_tracks;
        observer.explain(&Explanation::Cluster(ClusterRecord {
            plots: scan.plots,
            of_cluster: group.plots,
            tracks: group.tracks().count(),
            hypotheses: group.clusters().map(|cluster| cluster.hypotheses.len()).sum(),
            considered: after.hypotheses_drawn - before.hypotheses_drawn,
            forbidden: forbidden(after) - forbidden(before),
            merged: after.hypotheses_merged - before.hypotheses_merged,
            dropped: after.hypotheses_dropped - before.hypotheses_dropped,
            dropped_probability: dropped_probability.min(1.0),
        }));
        for (reliability, tracks) in self.stage.hypotheses() {
            observer.explain(&Explanation::Hypothesis { reliability });
            tracks.for_each(|track| observer.explain(&Explanation::Member(record(track))));
        }
    }

    /// Tells how wide-area reports corrected the clusters before the scan, and the children that are now on the stage; of
    /// these so large a share had enough tracks before.
    fn explain_corrections(&self, group: &Group<'_>, observer: &dyn Observer, before: f64) {
        let hypotheses = &group.scan.before.hypotheses;
        for (cluster, expectation) in group.clusters().zip(group.expectations()) {
            let range = cluster.hypotheses.start as usize..cluster.hypotheses.end as usize;
            if let Some(correction) = group.asked(&expectation).explained(&hypotheses[range]) {
                observer.explain(&Explanation::Correction(correction));
            }
        }
        let after = self.share_of_enough();
        // Written so that NaN, of no children at all, explains nothing.
        if after > before {
            let due = group.expectations().filter(|expectation| expectation.is_due);
            observer.explain(&Explanation::Correction(CorrectionRecord {
                targets: due.filter_map(|expectation| expectation.targets).sum(),
                before,
                after,
                of_children: true,
            }));
        }
    }

    /// Share of the children's reliability that those have with as many tracks as a due wide-area report asks for.
    fn share_of_enough(&self) -> f64 {
        let children = (0..self.stage.len()).map(|child| self.stage.log_reliability(child));
        let enough = children.clone().zip(&self.kin).filter(|(_, (_, is_enough))| *is_enough);
        (log_sum(enough.map(|(log_reliability, _)| log_reliability)) - log_sum(children)).exp()
    }

    /// Lets the tracks of a cluster take the directions in their gates ([`crate::directions`]); its hypotheses stay, but for
    /// the tracks that have been silent for too long.
    pub(crate) fn take_in(
        &mut self,
        scan: &ScanContext<'_>,
        cluster: &Cluster,
        claims: &[Claims],
        next: &mut Population,
        counts: &mut Counts,
    ) {
        let directions = Directions::of(scan);
        self.stage.clear();
        for number in cluster.tracks.clone() {
            let mut track = scan.before.tracks[number as usize];
            directions.take_in(&mut track, claims);
            self.missed[number as usize] = if scan.settings.deletion.is_met(&track, scan.time_ns) {
                explain_end(scan, &track, &scan.settings.deletion, TrackEvent::ENDS);
                REMOVED
            } else {
                self.stage.add_track(track).unwrap_or(UNMADE)
            };
        }
        for hypothesis in &scan.before.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize] {
            for member in scan.before.members_of(hypothesis) {
                self.add_member(self.missed[*member as usize], counts);
            }
            self.stage.finish_child(hypothesis.log_reliability);
        }
        let detections = DetectionCounts {
            detections: cluster.detections,
            scans: cluster.scans,
        };
        self.stage.separate(next, &scan.settings.reduction, &detections, counts);
    }

    fn prepare(&mut self, group: &mut Group<'_>, detections: &DetectionCounts, counts: &mut Counts) {
        self.stage.clear();
        self.begun = [UNMADE; ROWS_MAX];
        self.in_confirmed_gate = [false; ROWS_MAX];
        self.numbers.clear();
        for (row, (_, plot)) in (0..).zip(group.plots) {
            self.row_of[*plot as usize] = row;
        }
        let scan = group.scan;
        for track in group.tracks() {
            self.missed[track as usize] = UNMADE;
            let number = scan.before.tracks[track as usize].number;
            if number != TENTATIVE {
                self.numbers.push((number, 0.0));
            }
            for pair in group.pairs(track) {
                self.updated[pair] = UNMADE;
                let row = self.row_of[scan.gating.pairs[pair].plot as usize] as usize;
                self.in_confirmed_gate[row] |= number != TENTATIVE;
            }
        }
        self.numbers.sort_unstable_by_key(|(number, _)| *number);
        self.numbers.dedup_by_key(|(number, _)| *number);
        group.has_confirmed = !self.numbers.is_empty();
        let splitting = &scan.settings.splitting;
        group.limits = Limits::of(splitting, self.numbers.len(), detections.mean());
        if group.has_confirmed && splitting.start_in_confirmed_gates {
            let outside = self.in_confirmed_gate[..group.plots.len()].iter();
            counts.starts_forbidden += outside.filter(|inside| !**inside).count() as u64;
        }
    }

    /// Poses the problem of each hypothesis; then, where a wide-area report asks for more tracks than it has, its children
    /// with enough of them.
    fn pose(&mut self, group: &Group<'_>, counts: &mut Counts) {
        self.ranked.clear();
        self.posed.clear();
        for parent in 0..self.parents.list.len() {
            self.find_entries(group, parent, counts);
            if self.pose_problem(group, parent, |_| Start::May, counts).is_none() {
                counts.refused_hypotheses += 1;
            }
        }
        for plain in 0..self.posed.len() {
            let parent = self.posed[plain].parent;
            let lacking = self.parents.list[parent].lacking_due;
            if lacking > 0 {
                self.find_entries(group, parent, counts);
                self.pose_enough(group, plain, lacking, counts);
            }
        }
        self.ranked.begin();
    }

    /// Children that begin at least `lacking` new tracks, each of them once: the first so many rows that begin one are
    /// given, and the rows between them do not (WA-4).
    fn pose_enough(&mut self, group: &Group<'_>, plain: usize, lacking: usize, counts: &mut Counts) {
        let rows = group.plots.len();
        let ways = binomial(rows, lacking);
        if ways > WAYS_MAX || self.posed.len() + ways as usize > PROBLEMS_MAX {
            counts.wide_area_uncorrected += 1;
            return;
        }
        let first = self.posed.len();
        let mut starts = if ways == 0 { 0 } else { u64::MAX >> (64 - lacking) };
        for _ in 0..ways {
            let last = 63 - starts.leading_zeros() as usize;
            let start = |row: usize| match starts >> row & 1 {
                1 => Start::Must,
                _ if row < last => Start::MayNot,
                _ => Start::May,
            };
            self.pose_problem(group, self.posed[plain].parent, start, counts);
            starts = next_of_as_many_bits(starts);
        }
        let best = (first..self.posed.len()).filter_map(|problem| self.ranked.best_cost(problem));
        let best = best.fold(f64::INFINITY, f64::min);
        let Some(lowered) = self.ranked.best_cost(plain).map(|plain| best - plain) else {
            return;
        };
        if lowered.is_finite() {
            for problem in first..self.posed.len() {
                self.ranked.lower(problem, lowered);
                self.posed[problem].lowered = lowered;
                self.posed[problem].is_enough = true;
            }
        }
    }

    /// Poses a problem of the parent whose entries were found last. `None` if there is no room.
    fn pose_problem(
        &mut self,
        group: &Group<'_>,
        parent: usize,
        start: impl Fn(usize) -> Start,
        counts: &mut Counts,
    ) -> Option<()> {
        let (scan, sensor) = (group.scan, group.scan.sensor);
        let members = self.parents.members(parent).iter();
        let misses: f64 = members.map(|track| scan.gating.log_misses[*track as usize]).sum();
        let base = -self.parents.list[parent].log_reliability - misses;
        self.ranked.begin_problem(base).then_some(())?;
        self.posed.push(Posed {
            parent,
            is_enough: false,
            lowered: 0.0,
        });
        let mut entry = 0;
        for row in 0..group.plots.len() {
            let log_clutter = scan.log_clutter[group.plots[row].1 as usize];
            let log_weight = scan.log_weight + scan.plots[group.plots[row].1 as usize].log_weight;
            let log_share = self.log_share_of_new(group, parent, row);
            self.ranked.begin_row();
            let mut add = |column, meaning, cost| {
                let added = self.ranked.add(Choice { column, meaning, cost });
                counts.dropped_pairs += u64::from(!added);
            };
            let start = start(row);
            let is_usable = log_weight > f64::NEG_INFINITY;
            if start != Start::Must {
                add(OWN, FALSE, 0.0);
            }
            if let Some(log_share) = log_share.filter(|_| start != Start::MayNot && is_usable) {
                add(OWN, NEW, -log_share - log_weight);
            }
            while let Some(&(_, column, pair)) = self.entries.get(entry).filter(|(of, _, _)| *of == row as u32) {
                entry += 1;
                if start == Start::Must || !is_usable {
                    continue;
                }
                let found = scan.gating.pairs[pair as usize];
                let log_miss = scan.gating.log_misses[found.track as usize];
                let gain = sensor.log_detection + found.log_likelihood - log_clutter - log_miss;
                add(column as u16, pair, -gain - log_weight);
            }
        }
        Some(())
    }

    /// Logarithm of how many new targets a row's detection is expected to be, per false detection; `None` if it may not
    /// start a track.
    fn log_share_of_new(&self, group: &Group<'_>, parent: usize, row: usize) -> Option<f64> {
        let settings = group.scan.settings;
        let splitting = &settings.splitting;
        let plot = &group.scan.plots[group.plots[row].1 as usize];
        let may_split = self.in_confirmed_gate[row];
        let is_guarded = group.has_confirmed && splitting.start_in_confirmed_gates && !may_split;
        if plot.measurement.place().is_none() || is_guarded {
            return None;
        }
        let of_split = splitting.new_target_share.filter(|_| may_split);
        let plain = of_split.unwrap_or(settings.new_target_share);
        let early = group
            .easier_confirmation()
            .filter(|_| self.parents.list[parent].lacking > 0);
        Some(early.map_or(plain, |early| early.new_target_share.max(plain)).ln())
    }

    /// The pairs of a hypothesis by rows, with columns numbered in the order of its tracks.
    fn find_entries(&mut self, group: &Group<'_>, parent: usize, counts: &mut Counts) {
        self.entries.clear();
        let mut column = 0;
        for &track in self.parents.members(parent) {
            let pairs = group.pairs(track);
            if pairs.is_empty() {
                continue;
            }
            if column as usize >= COLUMNS_MAX {
                counts.dropped_pairs += pairs.len() as u64;
                continue;
            }
            for pair in pairs {
                let row = self.row_of[group.scan.gating.pairs[pair].plot as usize];
                self.entries.push((row, column, pair as u32));
            }
            column += 1;
        }
        self.entries.sort_unstable();
    }

    /// Draws children, likeliest first, until there are enough or the rest cannot matter. Returns a bound on the share
    /// of the probability that was left behind.
    fn draw(&mut self, group: &Group<'_>, next: &mut Population, counts: &mut Counts) -> f64 {
        let reduction = &group.scan.settings.reduction;
        let Some(best) = self.ranked.next_cost() else {
            return 0.0;
        };
        self.kin.clear();
        let corrects = self.posed.iter().any(|posed| posed.is_enough);
        let children_max = if corrects { 2 } else { 1 } * reduction.hypotheses_max;
        let (mut drawn, mut taken, mut fallback) = (0, 0.0, None);
        while let Some(cost) = self.ranked.next_cost() {
            let enough = self.stage.len() >= children_max;
            // Its reliability is below its share of it and the best one together.
            let unreliable = (best - cost).exp() < reduction.reliability_min;
            if enough || unreliable || drawn >= DRAWN_PER_KEPT * children_max {
                break;
            }
            let Some(solution) = self.ranked.next() else { break };
            drawn += 1;
            if self.is_drawn_elsewhere(solution) {
                continue;
            }
            taken += (best - cost).exp();
            if !self.make_child(group, solution, group.limits, next, counts) {
                // Something must stay even if every child breaks the limits: the likeliest.
                fallback = fallback.or(Some(solution));
            }
        }
        counts.hypotheses_drawn += drawn as u64;
        if let Some(solution) = fallback.filter(|_| self.stage.len() == 0) {
            self.make_child(group, solution, Limits::NONE, next, counts);
        }
        let left = (self.ranked.log_left() + best).exp();
        left / (left + taken)
    }

    /// Whether a child of a plain problem comes out of one that holds only those with enough tracks, too.
    fn is_drawn_elsewhere(&self, solution: Solution) -> bool {
        let posed = self.posed[solution.problem];
        let of_parent = |other: &Posed| other.parent == posed.parent && other.is_enough;
        !posed.is_enough && self.has_enough(solution) == Some(true) && self.posed.iter().any(of_parent)
    }

    /// Whether a child has as many tracks as a wide-area report asks for; `None` if none asks.
    fn has_enough(&self, solution: Solution) -> Option<bool> {
        let lacking = self.parents.list[self.posed[solution.problem].parent].lacking_due;
        let new_tracks = self.ranked.meanings(solution).filter(|meaning| *meaning == NEW).count();
        (lacking > 0).then_some(new_tracks >= lacking)
    }

    /// WA-4, to each parent's children.
    fn correct_children(&mut self, correction: Option<Rule>) {
        let Some(rule) = correction else { return };
        for parent in 0..self.parents.list.len() {
            if self.parents.list[parent].lacking_due == 0 {
                continue;
            }
            let kin = || (0..self.kin.len()).filter(|child| self.kin[*child].0 == parent);
            let rated = kin().map(|child| (self.stage.log_reliability(child), self.kin[child].1));
            let gains = Gains::of_all(rated, rule);
            self.parents.corrected |= gains != Gains::NONE;
            for (child, (of, is_enough)) in self.kin.iter().enumerate() {
                if *of == parent {
                    self.stage.raise(child, gains.gain(*is_enough));
                }
            }
        }
    }

    /// `false` if the child breaks the limits or finds no room.
    fn make_child(
        &mut self,
        group: &Group<'_>,
        solution: Solution,
        limits: Limits,
        next: &mut Population,
        counts: &mut Counts,
    ) -> bool {
        let new_tracks = self.ranked.meanings(solution).filter(|meaning| *meaning == NEW).count();
        if new_tracks > limits.new_tracks_max {
            counts.too_many_new_tracks += 1;
            return false;
        }
        for meaning in self.ranked.meanings(solution).filter(|meaning| *meaning < NEW) {
            let track = group.scan.gating.pairs[meaning as usize].track;
            self.taken[track as usize] = meaning;
        }
        let posed = self.posed[solution.problem];
        let mut room = true;
        for place in 0..self.parents.members(posed.parent).len() {
            let track = self.parents.members(posed.parent)[place];
            let pair = std::mem::replace(&mut self.taken[track as usize], NONE);
            let staged = if pair == NONE {
                self.missed_track(group, track, counts)
            } else {
                self.updated_track(group, track, pair, counts)
            };
            room &= self.add_member(staged, counts);
        }
        for row in 0..group.plots.len() {
            let is_new = self.ranked.meanings(solution).nth(row) == Some(NEW);
            if is_new {
                let staged = self.new_track(group, row, next, counts);
                room &= self.add_member(staged, counts);
            }
        }
        if limits.forbids(self.stage.tentative_members()) {
            counts.too_many_tentative_tracks += 1;
            self.stage.drop_child();
            return false;
        }
        if !room {
            self.stage.drop_child();
            counts.refused_hypotheses += 1;
            return false;
        }
        let finished = self.stage.finish_child(-solution.cost - posed.lowered);
        if finished {
            let is_enough = self.has_enough(solution).unwrap_or(true);
            self.kin.push((posed.parent, is_enough));
        }
        finished
    }

    /// `false` if there is no room.
    fn add_member(&mut self, staged: u32, counts: &mut Counts) -> bool {
        match staged {
            REMOVED => true,
            UNMADE => {
                counts.refused_tracks += 1;
                false
            }
            staged => self.stage.add_member(staged),
        }
    }

    /// The memory track (HT-3), unless it has been silent for too long.
    fn missed_track(&mut self, group: &Group<'_>, number: u32, counts: &mut Counts) -> u32 {
        if self.missed[number as usize] == UNMADE {
            let scan = group.scan;
            let mut track = scan.before.tracks[number as usize];
            let log_miss = scan.gating.log_misses[number as usize];
            track.missed += 1;
            track.log_silence += log_miss;
            track.log_likelihood_ratio += log_miss;
            // A quick sensor that finds nothing here must not push out of the memory what a slow one has left open.
            if !group.plots.is_empty() || scan.sensor.worth >= 1.0 {
                track.remember(NO_DETECTION);
            }
            let in_time = scan.settings.deletion.is_met(&track, scan.time_ns);
            let early = group.early_deletion().map(|early| early.deletion).filter(|_| !in_time);
            let early = early.filter(|deletion| deletion.is_met(&track, scan.time_ns));
            counts.wide_area_deletions += u64::from(early.is_some());
            let gone = in_time || early.is_some();
            let apart = self.lacks_company(group, &track);
            if gone {
                let events = early.map_or(TrackEvent::ENDS, |_| TrackEvent::ABSENT_ENDS);
                explain_end(scan, &track, &early.unwrap_or(scan.settings.deletion), events);
            } else if apart {
                explain_company(scan, &track);
            }
            self.missed[number as usize] = if gone || apart {
                REMOVED
            } else {
                self.stage.add_track(track).unwrap_or(UNMADE)
            };
        }
        self.missed[number as usize]
    }

    /// The updated track (HT-3).
    fn updated_track(&mut self, group: &Group<'_>, number: u32, pair: u32, counts: &mut Counts) -> u32 {
        if self.updated[pair as usize] == UNMADE {
            let scan = group.scan;
            let found = scan.gating.pairs[pair as usize];
            let plot = &scan.plots[found.plot as usize];
            let mut track = scan.before.tracks[number as usize];
            track.motion = track.motion_at(plot.time_ns, &scan.settings.motion);
            // It was compared before, so it can be done.
            let _ = track.motion.update(&plot.measurement.worth(scan.sensor.worth));
            (track.time_ns, track.seen_ns) = (plot.time_ns, plot.time_ns);
            (track.missed, track.log_silence) = (0, 0.0);
            track.detections += 1;
            track.in_company += u32::from(self.in_confirmed_gate[self.row_of[found.plot as usize] as usize]);
            track.log_likelihood_ratio +=
                scan.sensor.log_detection + found.log_likelihood - scan.log_clutter[found.plot as usize];
            track.remember(scan.first_serial.wrapping_add(found.plot));
            self.updated[pair as usize] = if self.lacks_company(group, &track) {
                counts.out_of_company += 1;
                explain_company(scan, &track);
                REMOVED
            } else {
                self.stage.add_track(track).unwrap_or(UNMADE)
            };
        }
        self.updated[pair as usize]
    }

    /// SP-7.
    fn lacks_company(&self, group: &Group<'_>, track: &Track) -> bool {
        let judged = group.has_confirmed && !track.is_confirmed() && track.detections > 1;
        let least = group.scan.settings.splitting.company_min.filter(|_| judged);
        least.is_some_and(|least| track.company() < least)
    }

    /// The new track (HT-3) that begins at a row's detection.
    fn new_track(&mut self, group: &Group<'_>, row: usize, next: &mut Population, counts: &mut Counts) -> u32 {
        if self.begun[row] == UNMADE {
            let plot = group.plots[row].1;
            let inherited = self.parents_motion(group, row);
            counts.starts_with_parents_motion += u64::from(inherited.is_some());
            let in_company = u32::from(self.in_confirmed_gate[row]);
            self.begun[row] = match begin(group.scan, plot, inherited, next.next_root) {
                Some(track) => {
                    next.next_root = next.next_root.wrapping_add(1).max(1);
                    self.stage.add_track(Track { in_company, ..track }).unwrap_or(UNMADE)
                }
                None => REMOVED,
            };
        }
        self.begun[row]
    }

    /// SP-2: the motion of the most reliable confirmed track in whose gate the row's detection lies.
    fn parents_motion(&mut self, group: &Group<'_>, row: usize) -> Option<Motion> {
        let scan = group.scan;
        let branches_max = scan.settings.splitting.parents_motion?;
        let plot = group.plots[row].1;
        self.numbers.clear();
        self.branches.clear();
        for number in group.tracks() {
            let track = &scan.before.tracks[number as usize];
            let in_gate = || group.pairs(number).any(|pair| scan.gating.pairs[pair].plot == plot);
            if !track.is_confirmed() || !in_gate() {
                continue;
            }
            self.branches.push(number);
            match self.numbers.iter_mut().find(|(other, _)| *other == track.number) {
                Some((_, reliability)) => *reliability += track.reliability,
                None => self.numbers.push((track.number, track.reliability)),
            }
        }
        let best = self.numbers.iter();
        let (number, _) = best
            .copied()
            .max_by(|one, other| one.1.total_cmp(&other.1).then(other.0.cmp(&one.0)))?;
        let of = |track: &u32| &scan.before.tracks[*track as usize];
        self.branches.retain(|track| of(track).number == number);
        self.branches.sort_unstable_by(|one, other| {
            of(other)
                .reliability
                .total_cmp(&of(one).reliability)
                .then(one.cmp(other))
        });
        let time_ns = scan.plots[plot as usize].time_ns;
        let best = self.branches.iter().take(branches_max).map(of);
        mean_motion(best.map(|track| (track.motion_at(time_ns, &scan.settings.motion), track.reliability)))
    }
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

fn explain_end(scan: &ScanContext<'_>, track: &Track, deletion: &Deletion, [missed, silent]: [TrackEvent; 2]) {
    if deletion.is_missed_too_often(track) {
        let limit = deletion.missed_probability;
        scan.explain(missed, track, track.log_silence.exp(), limit);
    } else {
        let silent_ns = scan.time_ns.saturating_sub(track.seen_ns);
        let [silent_s, limit_s] = [silent_ns, deletion.silent_ns].map(|time_ns| time_ns as f64 / NS_PER_S);
        scan.explain(silent, track, silent_s, limit_s);
    }
}

fn explain_company(scan: &ScanContext<'_>, track: &Track) {
    let limit = scan.settings.splitting.company_min.unwrap_or(f64::NAN);
    let share = track.company();
    scan.explain(TrackEvent::OutOfCompany, track, share, limit);
}

/// A new track, with an inherited motion or with what a first detection tells. `None` of a direction alone.
pub(crate) fn begin(scan: &ScanContext<'_>, plot: u32, inherited: Option<Motion>, root: u32) -> Option<Track> {
    let found = &scan.plots[plot as usize];
    let settings = scan.settings;
    let updated = inherited.and_then(|mut motion| motion.update(&found.measurement).map(|_| motion));
    let motion = updated.or_else(|| Motion::first(&found.measurement, &settings.first_guess, &settings.motion))?;
    let serial = scan.first_serial.wrapping_add(plot);
    Some(Track {
        log_likelihood_ratio: settings.new_target_share.ln(),
        ..Track::begun(motion, found.time_ns, serial, root)
    })
}
