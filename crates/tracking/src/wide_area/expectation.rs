//! Expected targets of each cluster in a scan, derived from the reports.
//!
//! Reports of the same time of observation add up for the same cluster: a sensor may report targets singly or together.
//! Among different times the latest report holds. Reports that are matched one to one ([`super::matching`]) are handled
//! together, observation by observation.

use association::Grid;
use messages::{AXES, NS_PER_S};
use observations::WideAreaReport;

use super::choice::{Centre, nearest};
use super::distribution::share;
use super::identification::Origin;
use super::matching::{Matcher, Matching, TOGETHER_MAX};
use super::report;
use super::settings::SupportSettings;
use crate::counts::TrackerCounts;
use crate::population::{Cluster, Population};
use crate::track::Track;

/// Side of the cells in the search for centres, metres, and number of cells of a search in one direction.
const CELL_M: f64 = 5000.0;
const CELLS_MAX: i32 = 16;
/// Maximum of centres compared directly, without a grid.
const FEW: usize = 16;

/// Knowledge of a cluster from reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Expectation {
    /// Number of targets, `None` if no valid report means the cluster.
    pub(crate) targets: Option<f64>,
    /// Whether the report is due in this scan.
    pub(crate) is_due: bool,
    /// Set if a report covers the cluster's place and shows no target around.
    pub(crate) is_absent: bool,
    /// Origin of the targets.
    pub(crate) origin: Option<Origin>,
    /// Time of the observation that `targets` is from, nanoseconds.
    observed_ns: i64,
}

/// A scan with one-to-one matching of the reports of an observation.
struct MatchedScan<'a> {
    /// Whether these reports are due in the scan.
    is_due: bool,
    /// Time of the centres, nanoseconds.
    reference_ns: i64,
    settings: &'a SupportSettings,
}

/// Working memory, reused for each scan.
#[derive(Clone, Debug)]
pub(crate) struct Expectations {
    /// By cluster; empty if nothing is known of any.
    list: Vec<Expectation>,
    /// Pairs (cluster, centre) of the candidates for a report.
    centres: Vec<(u32, Centre)>,
    /// Positions of the centres, unless few; and the greatest speed of a centre, metres per second.
    grid: Grid,
    in_grid: usize,
    speed_max_mps: f64,
    /// Places in the list of centres, for the centres that may be within range of the report at hand, in no order.
    near: Vec<u32>,
    /// By candidate: share of the targets.
    shares: Vec<f64>,
    /// Reports that have been taken into a group.
    grouped: Vec<bool>,
    matcher: Matcher,
}

impl Expectations {
    pub(crate) fn new(clusters_max: usize) -> Self {
        Self {
            list: Vec::with_capacity(clusters_max),
            centres: Vec::with_capacity(clusters_max),
            grid: Grid::new(CELL_M, clusters_max),
            in_grid: 0,
            speed_max_mps: 0.0,
            near: Vec::with_capacity(clusters_max),
            shares: Vec::with_capacity(clusters_max),
            grouped: Vec::with_capacity(super::report::REPORTS_MAX),
            matcher: Matcher::new(clusters_max),
        }
    }

    /// Whether no cluster has an expectation.
    pub(crate) fn are_none(&self) -> bool {
        self.list.is_empty()
    }

    pub(crate) fn of(&self, cluster: u32) -> Expectation {
        self.list.get(cluster as usize).copied().unwrap_or_default()
    }

    /// For the scan at `time_ns` after the population `before`; `lasting` expectations even if no report is due in the
    /// scan.
    pub(crate) fn find(
        &mut self,
        before: &Population,
        time_ns: i64,
        reports: &[WideAreaReport],
        settings: &SupportSettings,
        lasting: bool,
        counts: &mut TrackerCounts,
    ) {
        self.list.clear();
        let is_due = |report: &WideAreaReport| report::is_due(report, before.support.reports_ns, time_ns);
        let matters =
            |report: &WideAreaReport| is_due(report) || report::is_valid(report, time_ns, settings.valid_s.ns());
        let needed = |report: &WideAreaReport| if lasting { matters(report) } else { is_due(report) };
        if before.clusters.is_empty() || !reports.iter().any(needed) {
            return;
        }
        self.list.resize(before.clusters.len(), Expectation::default());
        self.find_centres(before, settings);
        self.grouped.clear();
        self.grouped.resize(reports.len(), false);
        for place in 0..reports.len() {
            if self.grouped[place] || !matters(&reports[place]) {
                continue;
            }
            if settings.matching == Matching::OneToOne {
                let scan = MatchedScan {
                    is_due: is_due(&reports[place]),
                    reference_ns: before.time_ns,
                    settings,
                };
                self.take_together(reports, place, &scan, matters, counts);
                continue;
            }
            let report = self.group(reports, place, settings, matters);
            let is_due = is_due(&report);
            counts.wide_area_reports_used += u64::from(is_due);
            let met = self.take(&report, is_due, before.time_ns, settings);
            counts.wide_area_reports_unmatched += u64::from(is_due && !met);
        }
        if settings.deletion.is_some() {
            self.find_absences(before, time_ns, reports, settings);
        }
    }

    fn find_centres(&mut self, before: &Population, settings: &SupportSettings) {
        self.centres.clear();
        // Most clusters are clutter and need no centre.
        let is_believed = |cluster: &Cluster| {
            let expected: f64 = tracks_of(cluster, before).iter().map(|track| track.reliability).sum();
            expected > 0.0 && expected >= settings.tracks_min
        };
        let believed = (0..).zip(&before.clusters).filter(|(_, cluster)| is_believed(cluster));
        self.centres
            .extend(believed.map(|(place, cluster)| (place, centre_of(cluster, before))));
        (0..self.in_grid).for_each(|item| self.grid.remove(item as u32));
        self.in_grid = if self.centres.len() > FEW {
            self.centres.len()
        } else {
            0
        };
        for (item, (_, centre)) in (0..).zip(&self.centres[..self.in_grid]) {
            let [east, north, _] = centre.position_m;
            self.grid.place(item, east, north);
        }
        let speeds = self.centres.iter().map(|(_, centre)| centre.speed_mps());
        self.speed_max_mps = speeds.fold(0.0, f64::max);
    }

    /// Finds the centres that may be within range of a place, so long after or before the population.
    fn search(&mut self, place_m: [f64; AXES], seconds: f64, range_m: f64) {
        self.near.clear();
        let reach_m = range_m + self.speed_max_mps * seconds.abs();
        // Written so that NaN looks at all.
        if self.in_grid > 0 && 2.0 * reach_m <= f64::from(CELLS_MAX - 1) * CELL_M {
            let near = &mut self.near;
            self.grid
                .near(place_m[0], place_m[1], reach_m, CELLS_MAX, |item| near.push(item));
        } else {
            self.near.extend(0..self.centres.len() as u32);
        }
    }

    /// Collects a report and the reports of the same group (WA-5).
    fn group(
        &mut self,
        reports: &[WideAreaReport],
        place: usize,
        settings: &SupportSettings,
        matters: impl Fn(&WideAreaReport) -> bool,
    ) -> WideAreaReport {
        let mut sum = reports[place];
        let Some(size_m) = settings.sharing.and_then(|sharing| sharing.group_m) else {
            return sum;
        };
        let first = reports[place];
        for (other, report) in reports.iter().enumerate().skip(place + 1) {
            let same = (report.time_ns, report.arrival_ns) == (first.time_ns, first.arrival_ns);
            let away = |axis: usize| report.position_m[axis] - first.position_m[axis];
            if !same || !matters(report) || away(0).hypot(away(1)) > size_m || sum.targets + report.targets == 0 {
                continue;
            }
            self.grouped[other] = true;
            let weight = f64::from(report.targets) / f64::from(sum.targets + report.targets);
            for axis in 0..AXES {
                sum.position_m[axis] += weight * (report.position_m[axis] - sum.position_m[axis]);
            }
            sum.targets += report.targets;
        }
        sum
    }

    /// Adds a report to the matching clusters. `false` if no cluster fits. The centres are at `reference_ns`.
    fn take(&mut self, report: &WideAreaReport, is_due: bool, reference_ns: i64, settings: &SupportSettings) -> bool {
        if report.targets == 0 {
            // Nothing to correct; absence is another matter.
            return true;
        }
        let seconds = report.time_ns.saturating_sub(reference_ns) as f64 / NS_PER_S;
        self.search(report.position_m, seconds, settings.range_m);
        let targets = f64::from(settings.knowledge.targets(report));
        if let Some(sharing) = settings.sharing {
            // Largest remainders go by order.
            self.near.sort_unstable();
            let near = self.near.iter().map(|place| &self.centres[*place as usize].1);
            let distances = near.map(|centre| (centre.distance_m(report.position_m, seconds), centre.tracks));
            share(targets, distances, settings.range_m, &sharing, &mut self.shares);
            let shared = self.near.iter().zip(&self.shares).filter(|(_, share)| **share > 0.0);
            let mut any = false;
            for (place, share) in shared {
                let (cluster, _) = self.centres[*place as usize];
                self.list[cluster as usize].expect(*share, report, is_due);
                any = true;
            }
            return any;
        }
        let distance_m = |place: u32| self.centres[place as usize].1.distance_m(report.position_m, seconds);
        let distances = self.near.iter().map(|place| (*place as usize, distance_m(*place)));
        let in_range = distances.filter(|(_, distance)| *distance < settings.range_m);
        let mut elsewhere = 0.0;
        let counted = in_range.inspect(|(place, _)| elsewhere += self.centres[*place].1.tracks.round());
        let Some(chosen) = nearest(counted, settings.range_m) else {
            return false;
        };
        let (cluster, centre) = &self.centres[chosen];
        elsewhere -= centre.tracks.round();
        let left = if settings.others_count {
            targets - elsewhere
        } else {
            targets
        };
        if left > 0.0 {
            self.list[*cluster as usize].expect(left, report, is_due);
        }
        true
    }

    /// Matches the reports of the same observation and arrival as the report at `place` one to one, and adds each to
    /// the matched cluster.
    fn take_together(
        &mut self,
        reports: &[WideAreaReport],
        place: usize,
        scan: &MatchedScan<'_>,
        matters: impl Fn(&WideAreaReport) -> bool,
        counts: &mut TrackerCounts,
    ) {
        let (first, settings) = (&reports[place], scan.settings);
        let seconds = first.time_ns.saturating_sub(scan.reference_ns) as f64 / NS_PER_S;
        self.matcher.clear();
        for (other, report) in reports.iter().enumerate().skip(place) {
            let same = (report.time_ns, report.arrival_ns) == (first.time_ns, first.arrival_ns);
            if !same || self.grouped[other] || !matters(report) || self.matcher.reports.len() == TOGETHER_MAX {
                continue;
            }
            self.grouped[other] = true;
            // Nothing is to be corrected for a report of no targets; absence is another matter.
            if report.targets > 0 {
                self.search(report.position_m, seconds, settings.range_m);
                let centres = &self.centres;
                let distances = self
                    .near
                    .iter()
                    .map(|near| (*near, centres[*near as usize].1.distance_m(report.position_m, seconds)));
                self.matcher
                    .add(other, distances.filter(|(_, distance)| *distance < settings.range_m));
            } else {
                counts.wide_area_reports_used += u64::from(scan.is_due);
            }
        }
        self.matcher.solve(settings.range_m);
        for row in 0..self.matcher.reports.len() {
            let report = &reports[self.matcher.reports[row]];
            counts.wide_area_reports_used += u64::from(scan.is_due);
            let Some(chosen) = self.matcher.chosen(row) else {
                counts.wide_area_reports_unmatched += u64::from(scan.is_due);
                continue;
            };
            let targets = f64::from(settings.knowledge.targets(report));
            let elsewhere = if settings.others_count {
                self.unreported(report, seconds, settings.range_m)
            } else {
                0.0
            };
            if targets > elsewhere {
                let (cluster, _) = self.centres[chosen as usize];
                self.list[cluster as usize].expect(targets - elsewhere, report, scan.is_due);
            }
        }
    }

    /// Tracks within range of a report in clusters that no report of the observation means.
    fn unreported(&mut self, report: &WideAreaReport, seconds: f64, range_m: f64) -> f64 {
        self.search(report.position_m, seconds, range_m);
        let others = self.near.iter().filter(|near| !self.matcher.is_meant(**near));
        let centres = others.map(|near| &self.centres[*near as usize].1);
        let in_range = centres.filter(|centre| centre.distance_m(report.position_m, seconds) < range_m);
        in_range.map(|centre| centre.tracks.round()).sum()
    }

    /// WA-8: silence or lack of coverage is not absence.
    fn find_absences(
        &mut self,
        before: &Population,
        time_ns: i64,
        reports: &[WideAreaReport],
        settings: &SupportSettings,
    ) {
        let coverage = settings.deletion.and_then(|early| early.coverage);
        for (expectation, cluster) in self.list.iter_mut().zip(&before.clusters) {
            let centre = centre_of(cluster, before);
            // Among several valid reports on the place, the latest holds.
            let (mut latest_ns, mut is_absent) = (i64::MIN, false);
            let mut none_ns = i64::MIN;
            for report in reports
                .iter()
                .filter(|report| report::is_valid(report, time_ns, settings.valid_s.ns()))
            {
                let seconds = report.time_ns.saturating_sub(before.time_ns) as f64 / NS_PER_S;
                let is_near = centre.distance_m(report.position_m, seconds) < settings.range_m;
                if is_near && report.targets == 0 {
                    none_ns = none_ns.max(report.time_ns);
                }
                let covers = coverage.is_some_and(|circle| {
                    let [east, north] = circle.centre_m;
                    centre.distance_m([east, north, 0.0], seconds) <= circle.radius_m
                });
                let says = if is_near {
                    Some(report.targets == 0)
                } else {
                    covers.then_some(true)
                };
                if let Some(none) = says {
                    // At the same time, a target nearby outweighs coverage.
                    if report.time_ns > latest_ns {
                        (latest_ns, is_absent) = (report.time_ns, none);
                    } else if report.time_ns == latest_ns {
                        is_absent &= none;
                    }
                }
            }
            // A later report on other targets does not remove reported targets; a report of no targets does.
            let is_over = expectation.targets.is_none() || none_ns > expectation.observed_ns;
            expectation.is_absent = is_absent && is_over;
        }
    }
}

fn tracks_of<'a>(cluster: &Cluster, before: &'a Population) -> &'a [Track] {
    &before.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize]
}

/// Centre of the cluster's tracks at the time of the population.
fn centre_of(cluster: &Cluster, before: &Population) -> Centre {
    let moved = |track: &Track| {
        let mean = track.motion.mean();
        let seconds = before.time_ns.saturating_sub(track.time_ns) as f64 / NS_PER_S;
        let velocity_mps: [f64; AXES] = std::array::from_fn(|axis| mean[axis + AXES]);
        let position_m = std::array::from_fn(|axis| mean[axis] + velocity_mps[axis] * seconds);
        (position_m, velocity_mps, track.reliability)
    };
    Centre::of(tracks_of(cluster, before).iter().map(moved)).unwrap_or_default()
}

impl Expectation {
    fn expect(&mut self, targets: f64, report: &WideAreaReport, is_due: bool) {
        let observed_ns = report.time_ns;
        match self.targets {
            Some(_) if observed_ns < self.observed_ns => {}
            Some(sum) if observed_ns == self.observed_ns => {
                self.targets = Some(sum + targets);
                self.is_due |= is_due;
            }
            _ => {
                *self = Self {
                    targets: Some(targets),
                    is_due,
                    is_absent: false,
                    origin: Some(Origin::of(report)),
                    observed_ns,
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracker;
    use crate::testing::{S, position, settings};

    /// Targets three kilometres apart; the report of the second lies nearer to the first.
    #[test]
    fn reports_matched_one_to_one_ask_each_cluster_for_its_own_targets() {
        let mut tracker = Tracker::new(settings()).unwrap();
        for second in 0..10 {
            let seen = [0.0, 3000.0].map(|north| position(second * S, 15.0 * second as f64, north));
            tracker.scan(1, second * S, &seen).unwrap();
        }
        let report = |north: f64, targets| WideAreaReport {
            time_ns: 9 * S,
            arrival_ns: 10 * S,
            position_m: [135.0, north, 0.0],
            velocity_mps: [15.0, 0.0, 0.0],
            targets,
            origin_m: None,
        };
        let asked = |matching, reports: &[WideAreaReport]| {
            let settings = SupportSettings {
                matching,
                ..SupportSettings::default()
            };
            let (mut expectations, mut counts) = (Expectations::new(64), TrackerCounts::default());
            expectations.find(tracker.latest(), 10 * S, reports, &settings, false, &mut counts);
            let mut targets: Vec<_> = (0..tracker.clusters() as u32)
                .map(|cluster| expectations.of(cluster).targets)
                .collect();
            targets.sort_by(|one, other| one.partial_cmp(other).unwrap());
            (
                targets,
                counts.wide_area_reports_used,
                counts.wide_area_reports_unmatched,
            )
        };
        let both = [report(100.0, 2), report(1400.0, 1)];
        assert_eq!(asked(Matching::Nearest, &both), (vec![None, Some(1.0)], 2, 0));
        assert_eq!(asked(Matching::OneToOne, &both), (vec![Some(1.0), Some(2.0)], 2, 0));
        // A report alone leaves out the track beside; a third report finds no cluster, and a report of zero targets is
        // not matched.
        assert_eq!(asked(Matching::OneToOne, &both[..1]), (vec![None, Some(1.0)], 1, 0));
        let many = [both[0], both[1], report(500.0, 4), report(0.0, 0)];
        assert_eq!(asked(Matching::OneToOne, &many).2, 1);
        assert_eq!(asked(Matching::OneToOne, &many).1, 4);
    }
}
