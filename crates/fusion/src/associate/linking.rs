//! Membership of sensor tracks in system tracks: joining, leaving, moving (TI-3, QF-3, BF-2).
//!
//! A sensor track stays with its system track, and leaves only under these conditions:
//! - its identity contradicts: an address belongs to exactly one system track, and a system track has one address;
//! - its innovations repeatedly deviate to the same side (a wrong association, or the sensor has swapped targets);
//! - it repeatedly appears crossed with another track of its source, on a neighbouring target ([`crossing`]);
//! - the sensor track, or its whole system track, repeatedly agrees with another system track without a common source
//!   (a target started twice);
//! - its system track repeatedly lies beside another one that may be of the same target, no farther off than the target
//!   may be large, and each source follows one of the two only (two points of a long ship).
//!
//! The points of a long ship keep their distance in the frame of its course. The first source by priority gives the
//! reference point (module `reference_point`). Until two such tracks are one, the covariance of the shown one contains
//! the way to the point of the first source. If a source turns out to follow a target at both places, the two were
//! two targets, and the sensor track leaves.
//!
//! Two system tracks with different addresses are two targets, however well they agree, and are never merged: a sensor
//! track without an address that fits the other system track better goes there alone.

use messages::{Counter, Decision, DecisionKind, NO_SOURCE, SensorTrack, TrackState};

use estimation::{ComparedComponents, statistical_distance};
use source_models::{DetectionPoint, gaussian_of, to_body};

use crate::associate::association_step::Search;
use crate::associate::crossing::{self, CROSSED};
use crate::explanation::Sink;
use crate::publish::outlet::Outlet;
use crate::settings::{Settings, SourceSet};
use crate::tables::sensor_tracks::{NO_SYSTEM, Role, SensorEntry, SensorSlot};
use crate::tables::system_tracks::{Bond, SystemEntry, SystemSlot};
use crate::tables::tracks::Tracks;
use crate::update::filter::TargetFilter;
use crate::update::reference_point::change_to;

/// Time between two checks of a system track for duplicates, nanoseconds.
const DUPLICATE_EVERY_NS: i64 = 1_000_000_000;

/// Log-likelihood ratio of one target to two from which two system tracks apart are merged.
const OTHER_POINT: f64 = 4.0;
/// Least part of the ratio that silence shows.
const SILENCE_MIN: f64 = 1.5;
/// Number of reports of a system track from which other points of its target are looked for only at every so many.
const LONE_REPORTS: u32 = 16;
const LONE_EVERY: u32 = 8;

/// Remaining work for a sensor track.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub(crate) enum Next {
    /// Nothing.
    Done,
    /// The sensor track waits until its scan is complete.
    Wait,
    /// A system track has lost all its sensor tracks to another system track, and terminates.
    End(MergedTrack),
}

/// A system track taken over by another system track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MergedTrack {
    pub(crate) ended: SystemSlot,
    /// Number of the other system track.
    pub(crate) into: u32,
    pub(crate) time_ns: i64,
}

/// Period from which the first report of a sensor track may join. The second report of a faster source comes soon, and
/// distinguishes the points of large targets, visible to faster sources.
const SLOW_NS: i64 = 2_500_000_000;

/// The links between sensor tracks and system tracks, about to change.
pub(crate) struct Linking<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) tracks: &'a mut Tracks,
}

impl Linking<'_> {
    /// Associates a sensor track, with `report` just taken, with a system track.
    pub(crate) fn associate<S: Sink>(
        &mut self,
        sensor: SensorSlot,
        report: &SensorTrack,
        out: &mut Outlet<'_, S>,
    ) -> Next {
        if self.tracks.sensors.get(sensor).system == NO_SYSTEM {
            self.place(sensor, out)
        } else {
            self.reassociate(sensor, report, out)
        }
    }

    fn search(&self) -> Search<'_> {
        Search {
            settings: self.settings,
            tracks: self.tracks,
        }
    }

    /// Associates a sensor track without a system track: by an address at once; without an address at the end of its
    /// scan.
    #[cold]
    fn place<S: Sink>(&mut self, sensor: SensorSlot, out: &mut Outlet<'_, S>) -> Next {
        let entry = self.tracks.sensors.get(sensor);
        if entry.blocked {
            return Next::Done;
        }
        let address = entry.latest.identity.unique_number();
        let known = address
            .filter(|_| self.settings.association.uses_addresses())
            .and_then(|address| self.tracks.systems.with_address(address));
        if let Some(system) = known {
            self.tracks.join(sensor, system);
            let kind = DecisionKind::JoinedByAddress;
            out.decision(&self.tracks.decision(sensor, kind, f64::NAN, f64::NAN));
        } else if let Some((system, d2)) = self.recall(sensor, false) {
            self.tracks.join(sensor, system);
            // The engine explains a resumption.
            if self.tracks.systems.get(system).life != TrackState::Suspended {
                let gate = self.search().resumption_gate();
                out.decision(&self.tracks.decision(sensor, DecisionKind::Joined, d2, gate));
            }
        } else if self.tracks.is_established(sensor) || self.is_slow(sensor) {
            return Next::Wait;
        }
        Next::Done
    }

    /// Whether the period of the sensor track's source is long enough to make a search for its first report
    /// worthwhile.
    fn is_slow(&self, sensor: SensorSlot) -> bool {
        let source = self.tracks.sensors.get(sensor).source;
        self.settings.sources[usize::from(source)].period_ns >= SLOW_NS
    }

    /// Returns the former system track of the sensor track, from before a restart or a suspension, if still possible,
    /// with d². A system track that was never shown is considered only if `is_last`.
    pub(crate) fn recall(&mut self, sensor: SensorSlot, is_last: bool) -> Option<(SystemSlot, f64)> {
        let system = self.tracks.recall(sensor, is_last)?;
        let d2 = match self.tracks.systems.get(system).life {
            TrackState::Suspended => self.search().number_resumes(sensor, system)?,
            _ => self.search().resumption_distance(sensor, system)?,
        };
        Some((system, d2))
    }

    /// Starts a system track from a sensor track, first checked at `deadline_ns`; `false` if the table is full.
    pub(crate) fn start<S: Sink>(&mut self, sensor: SensorSlot, deadline_ns: i64, out: &mut Outlet<'_, S>) -> bool {
        let report = &self.tracks.sensors.get(sensor).latest;
        let (source, filter) = (report.source, TargetFilter::of_report(report));
        let Some(system) = self.tracks.systems.insert(source, filter, deadline_ns) else {
            out.count(source, Counter::DroppedTable);
            return false;
        };
        out.count(source, Counter::TracksStarted);
        self.tracks.reserve_numbers();
        self.tracks.join(sensor, system);
        let is_foreign = {
            let entry = self.tracks.sensors.get_mut(sensor);
            entry.share = 1.0;
            entry.is_foreign
        };
        let entry = self.tracks.systems.get_mut(system);
        (entry.is_foreign, entry.contributors) = (is_foreign, SourceSet::of(source));
        out.decision(&self.tracks.decision(sensor, DecisionKind::Started, f64::NAN, f64::NAN));
        self.tracks.assign_role(sensor);
        true
    }

    /// Decides whether the sensor track stays, or on its new system track.
    fn reassociate<S: Sink>(&mut self, sensor: SensorSlot, report: &SensorTrack, out: &mut Outlet<'_, S>) -> Next {
        let entry = self.tracks.sensors.get(sensor);
        let (system, identity) = (entry.system, entry.latest.identity);
        let mine = identity
            .unique_number()
            .filter(|_| self.settings.association.uses_addresses());
        if let Some(mine) = mine {
            let theirs = self.tracks.systems.get(system).identity.unique_number();
            if theirs.is_some_and(|theirs| theirs.excludes(mine)) && self.is_free(system) {
                out.count(report.source, Counter::IdentityConflicts);
                let kind = DecisionKind::IdentityConflict;
                out.decision(&self.tracks.decision(sensor, kind, f64::NAN, f64::NAN));
                return self.leave(sensor, out);
            }
            let known = self.tracks.systems.with_address(mine);
            if let Some(other) = known.filter(|other| *other != system && self.is_free(system)) {
                return self.move_to(sensor, other, f64::NAN, out);
            }
            self.tracks.systems.identify(system, &identity);
        }
        let now_ns = report.time_of_measurement_ns;
        let (sources, is_alone) = self.tracks.sources_beside(sensor, now_ns);
        if is_alone {
            return Next::Wait;
        }
        if crossing::is_due(self.tracks.sensors.get(sensor)) && self.is_free(system) {
            if self.uncross(sensor, out) {
                return Next::Done;
            }
            if let Some((other, d2)) = self.stray(sensor)
                && let Some(next) = self.vote_to_merge(sensor, other, d2, out)
            {
                return next;
            }
        }
        if mine.is_none() && self.tracks.systems.get(system).bond != Bond::Joined && self.has_split(sensor, out) {
            out.count(report.source, Counter::ContributionsSplit);
            return self.leave(sensor, out);
        }
        self.look_for_duplicate(system, (now_ns, sources), out)
    }

    /// Returns whether no order binds a system track. Identities and crossings decide nothing about a bound track.
    #[cold]
    fn is_free(&self, system: SystemSlot) -> bool {
        self.tracks.systems.get(system).bond == Bond::Free
    }

    /// The system track with the rare name of the sensor track, while no other member of its own system track has the
    /// name.
    fn stray(&self, sensor: SensorSlot) -> Option<(SystemSlot, f64)> {
        let search = self.search();
        if search.has_company(sensor) {
            return None;
        }
        let (system, d2) = search.namesake(sensor)?;
        let is_apart = self.is_free(system) && search.is_open_to(sensor, system) && !search.is_held(sensor);
        is_apart.then_some((system, d2))
    }

    /// Exchanges sensor tracks that repeatedly look crossed with sensor tracks of another system track; whether any
    /// moved.
    fn uncross<S: Sink>(&mut self, sensor: SensorSlot, out: &mut Outlet<'_, S>) -> bool {
        let found = self.search().crossing(sensor).map(|crossing| {
            let number = self.tracks.systems.get(crossing.there).number;
            let before = self.tracks.sensors.get(sensor).crossed;
            let sum = before
                .filter(|(last, _)| *last == number)
                .map_or(0.0, |(_, sum)| f64::from(sum));
            (crossing, number, (sum + crossing.ratio).max(0.0))
        });
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.crossed = found.map(|(_, number, sum)| (number, sum as f32));
        let here = entry.system;
        let Some((crossing, _, sum)) = found.filter(|(_, _, sum)| *sum >= CROSSED) else {
            return false;
        };
        for (mine, theirs) in crossing.crossed() {
            for (moved, to) in [(mine, crossing.there), (theirs, here)] {
                self.tracks.unlink(moved);
                self.tracks.join(moved, to);
                out.decision(&self.tracks.decision(moved, DecisionKind::Uncrossed, sum, CROSSED));
            }
        }
        for (mine, theirs) in crossing.crossed() {
            self.tracks.assign_role(mine);
            self.tracks.assign_role(theirs);
        }
        true
    }

    /// Removes a sensor track from its system track; the scan, or the address, decides on its new system track.
    #[cold]
    fn leave<S: Sink>(&mut self, sensor: SensorSlot, out: &mut Outlet<'_, S>) -> Next {
        self.tracks.unlink(sensor);
        self.place(sensor, out)
    }

    /// Whether the mean innovation of the sensor track differs from that of the others by more than noise, in several
    /// successive reports.
    fn has_split<S: Sink>(&mut self, sensor: SensorSlot, out: &mut Outlet<'_, S>) -> bool {
        let gate = self.settings.association.keep_gate * self.settings.association.exponents.number;
        let entry = self.tracks.sensors.get(sensor);
        if entry.role == Role::Duplicate || entry.is_foreign {
            return self.part_has_split(sensor);
        }
        let search = self.search();
        let is_of_another = entry.point.is_apart && search.is_apart_from_two(sensor);
        let d2 = match search.offset_from_others(sensor) {
            Some(d2) => d2,
            None if is_of_another => 0.0,
            None => return false,
        };
        let split = self.misfits(sensor, (d2 > gate || is_of_another) && !self.search().is_held(sensor));
        if split {
            out.decision(&self.tracks.decision(sensor, DecisionKind::Split, d2, gate));
            self.tracks.sensors.get_mut(sensor).has_left = true;
        }
        split
    }

    /// Whether, in several successive reports, a second track of a source has left the target's extent, or a track of
    /// a dependent source the target.
    fn part_has_split(&mut self, sensor: SensorSlot) -> bool {
        let entry = self.tracks.sensors.get(sensor);
        let filter = &self.tracks.systems.get(entry.system).filter;
        let estimate = filter.at(
            entry.latest.time_of_measurement_ns,
            self.tracks.sources.motion(filter.velocity_mps()),
        );
        let apart = |axis: usize| entry.latest.position_m[axis] - estimate.mean[axis];
        let now_ns = entry.latest.time_of_measurement_ns;
        let is_part = self
            .tracks
            .primary_of(entry.system, entry.source, sensor, now_ns)
            .is_some();
        let outside = if is_part {
            apart(0).hypot(apart(1)) > 2.0 * self.settings.association.target_extent_m
        } else {
            let own = gaussian_of(&entry.latest);
            let d2 = statistical_distance(&own, &estimate, ComparedComponents::HorizontalPosition);
            d2 > self.settings.association.keep_gate
        };
        self.misfits(sensor, outside)
    }

    /// Returns whether the number of successive misfits, including the present `misfit`, makes the sensor track leave.
    fn misfits(&mut self, sensor: SensorSlot, misfit: bool) -> bool {
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.misfits = if misfit { entry.misfits + 1 } else { 0 };
        entry.misfits >= self.settings.association.split_reports
    }

    /// Counts successive assignments of a lone sensor track to the same system track, and moves the sensor track there
    /// when there are enough; returns whether it moved.
    pub(crate) fn vote_to_merge<S: Sink>(
        &mut self,
        sensor: SensorSlot,
        system: SystemSlot,
        d2: f64,
        out: &mut Outlet<'_, S>,
    ) -> Option<Next> {
        let number = self.tracks.systems.get(system).number;
        let entry = self.tracks.sensors.get_mut(sensor);
        let hits = hits_in_a_row(entry.competing, number);
        entry.competing = Some((number, hits));
        (hits >= self.settings.association.merge_reports).then(|| self.move_to(sensor, system, d2, out))
    }

    /// Checks once a second for a duplicate of the system track with these contributing sources, as bits; merges into
    /// the older track after repeated findings.
    fn look_for_duplicate<S: Sink>(
        &mut self,
        system: SystemSlot,
        (now_ns, sources): (i64, SourceSet),
        out: &mut Outlet<'_, S>,
    ) -> Next {
        let entry = self.tracks.systems.get(system);
        let complete = self.settings.sources.len() as u32;
        if sources.count() >= complete {
            self.tracks.systems.get_mut(system).aside_m = [0.0; 2];
            return Next::Done;
        }
        if now_ns < entry.duplicate_due_ns {
            return Next::Done;
        }
        let found = self.search().duplicate(system, now_ns).map(|(duplicate, d2)| {
            let number = self.tracks.systems.get(duplicate).number;
            (duplicate, d2, number, hits_in_a_row(entry.duplicate, number))
        });
        let entry = self.tracks.systems.get_mut(system);
        entry.duplicate = found.map(|(_, _, number, hits)| (number, hits));
        entry.duplicate_due_ns = now_ns.saturating_add(DUPLICATE_EVERY_NS);
        match found {
            Some((duplicate, d2, _, hits)) if hits >= self.settings.association.merge_reports => {
                self.merge(system, duplicate, now_ns, d2, out)
            }
            Some(_) => Next::Done,
            None => self.look_for_other_point(system, now_ns, out),
        }
    }

    /// Checks a system track that agrees with no other for another system track of its target, at another point of the
    /// target; joins the two after repeated findings.
    pub(crate) fn look_for_other_point<S: Sink>(
        &mut self,
        system: SystemSlot,
        now_ns: i64,
        out: &mut Outlet<'_, S>,
    ) -> Next {
        let entry = self.tracks.systems.get(system);
        // A track that has long been alone seldom turns out to be of another target: the other, younger one looks too.
        let is_settled = entry.other_point.is_none() && entry.reports > LONE_REPORTS;
        if is_settled && !entry.reports.is_multiple_of(LONE_EVERY) {
            return Next::Done;
        }
        let found = self.search().other_point(system, now_ns).map(|(other, ratio)| {
            let number = self.tracks.systems.get(other).number;
            (
                other,
                ratio,
                number,
                hits_in_a_row(self.tracks.systems.get(system).other_point, number),
            )
        });
        let entry = self.tracks.systems.get_mut(system);
        entry.other_point = found.map(|(_, _, number, hits)| (number, hits));
        let own = entry.number;
        let Some((other, silence, _, hits)) = found else {
            self.tracks.systems.get_mut(system).aside_m = [0.0; 2];
            return Next::Done;
        };
        self.note_aside(system, other, now_ns);
        // The other track looks likewise.
        let theirs = self.tracks.systems.get(other).other_point;
        let hits = hits + theirs.filter(|(number, _)| *number == own).map_or(0, |(_, hits)| hits);
        let ratio = silence + self.settings.existence.persistence * f64::from(hits);
        let is_shown = silence > SILENCE_MIN && ratio > OTHER_POINT;
        if hits < self.settings.association.merge_reports || !is_shown {
            return Next::Done;
        }
        self.merge_points(system, other, now_ns, out)
    }

    /// Notes with the one of two system tracks of a target whose point comes last how far away the other point is.
    fn note_aside(&mut self, one: SystemSlot, other: SystemSlot, now_ns: i64) {
        let rank = |system: SystemSlot| {
            let members = self.tracks.member_entries(system);
            members.map(|(_, member)| self.settings.rank(member.source)).min()
        };
        let (first, last) = if rank(one) < rank(other) {
            (one, other)
        } else {
            (other, one)
        };
        let apart_m = self.apart_m(last, first, now_ns);
        self.tracks.systems.get_mut(first).aside_m = [0.0; 2];
        self.tracks.systems.get_mut(last).aside_m = apart_m.map(|way| way as f32);
    }

    /// Way from one system track to another, east and north, metres.
    fn apart_m(&self, from: SystemSlot, to: SystemSlot, now_ns: i64) -> [f64; 2] {
        let [from, to] = [from, to].map(|system| {
            let filter = &self.tracks.systems.get(system).filter;
            filter
                .at(now_ns, self.tracks.sources.motion(filter.velocity_mps()))
                .position_m()
        });
        [to[0] - from[0], to[1] - from[1]]
    }

    /// Merges two system tracks that follow different points of their target.
    #[cold]
    fn merge_points<S: Sink>(&mut self, a: SystemSlot, b: SystemSlot, now_ns: i64, out: &mut Outlet<'_, S>) -> Next {
        let (into, from) = self.in_order(a, b);
        let apart_m = to_body(self.apart_m(into, from, now_ns), self.tracks.systems.get(into).course);
        let [first, second] = [into, from].map(|system| self.anchor(system));
        if let Some(first) = first {
            let point = self.tracks.sources.points().apart([0.0; 2]);
            self.tracks.sensors.get_mut(first).point = DetectionPoint {
                is_reference: true,
                ..point
            };
        }
        let entry = self.tracks.systems.get_mut(into);
        (entry.has_points, entry.aside_m) = (true, [0.0; 2]);
        let next = self.merge_at(into, from, (now_ns, f64::NAN), Some(apart_m), out);
        let ranks = [first, second]
            .map(|anchor| anchor.map(|sensor| self.settings.rank(self.tracks.sensors.get(sensor).source)));
        if let (Some(second), [Some(kept), Some(other)]) = (second, ranks)
            && other < kept
        {
            change_to(self.tracks, second);
            out.input(|| self.tracks.input(second, None));
        }
        next
    }

    /// The sensor track whose point the filter of a system track follows: the reference, or else the first by priority
    /// that stands not apart.
    fn anchor(&self, system: SystemSlot) -> Option<SensorSlot> {
        let points = self.tracks.sources.points();
        let members = self.tracks.member_entries(system).filter(|(_, member)| {
            member.role == Role::Primary && (member.point.is_reference || !points.follows(&member.point))
        });
        members
            .min_by_key(|(_, member)| (!member.point.is_reference, self.settings.rank(member.source)))
            .map(|(sensor, _)| sensor)
    }

    /// Moves a sensor track to another system track, unless the addresses differ. If nothing fresh stays behind, the
    /// two system tracks are merged, if they can be of the same target.
    fn move_to<S: Sink>(&mut self, sensor: SensorSlot, target: SystemSlot, d2: f64, out: &mut Outlet<'_, S>) -> Next {
        let entry = self.tracks.sensors.get(sensor);
        let (old, now_ns) = (entry.system, entry.latest.time_of_measurement_ns);
        let search = self.search();
        if !search.are_two_targets(old, target) {
            if self.tracks.is_alone(sensor, now_ns) {
                return self.merge(old, target, now_ns, d2, out);
            }
        } else if search.excludes(target, &entry.latest.identity) {
            return Next::Done;
        }
        self.tracks.unlink(sensor);
        self.tracks.join(sensor, target);
        Next::Done
    }

    /// Merges two system tracks, unless the addresses differ.
    pub(crate) fn merge<S: Sink>(
        &mut self,
        a: SystemSlot,
        b: SystemSlot,
        now_ns: i64,
        d2: f64,
        out: &mut Outlet<'_, S>,
    ) -> Next {
        if self.search().are_two_targets(a, b) {
            return Next::Done;
        }
        let (into, from) = self.in_order(a, b);
        self.merge_at(into, from, (now_ns, d2), None, out)
    }

    /// The one of two system tracks that survives a merge, and the other: the confirmed track survives; of two equal
    /// tracks the older.
    fn in_order(&self, a: SystemSlot, b: SystemSlot) -> (SystemSlot, SystemSlot) {
        let rank = |slot: SystemSlot| {
            let entry = self.tracks.systems.get(slot);
            (entry.life == TrackState::Tentative, entry.number)
        };
        if rank(a) < rank(b) { (a, b) } else { (b, a) }
    }

    /// Merges the system track `from` into another. Its filter follows a point `apart_m` from that of the other, along
    /// and across the course, metres; `None` if both follow the same point.
    fn merge_at<S: Sink>(
        &mut self,
        into: SystemSlot,
        from: SystemSlot,
        (now_ns, d2): (i64, f64),
        apart_m: Option<[f64; 2]>,
        out: &mut Outlet<'_, S>,
    ) -> Next {
        let SystemEntry {
            reports,
            point_source,
            filter,
            is_foreign,
            contributors,
            number: ended,
            ..
        } = *self.tracks.systems.get(from);
        let kept_source = self.tracks.systems.get(into).point_source;
        let reanchor = self.settings.comes_before(point_source, kept_source);
        while let Some(member) = self.tracks.systems.get(from).members {
            let SensorEntry {
                role, source, point, ..
            } = *self.tracks.sensors.get(member);
            self.tracks.unlink(member);
            self.tracks.join(member, into);
            if let Some(apart_m) = apart_m {
                let points = self.tracks.sources.points();
                let own_m = if points.follows(&point) {
                    point.offset_m
                } else {
                    [0.0; 2]
                };
                let offset_m = std::array::from_fn(|axis| own_m[axis] + apart_m[axis]);
                self.tracks.sensors.get_mut(member).point = points.apart(offset_m);
            }
            if role == Role::Primary && self.tracks.primary_of(into, source, member, now_ns).is_none() {
                self.tracks.sensors.get_mut(member).role = Role::Primary;
            }
        }
        if reanchor && apart_m.is_none() {
            // The filter follows the point of another source than the source that is now first: the point is chosen
            // anew.
            self.tracks
                .for_members(into, |member| member.point = DetectionPoint::default());
        }
        let entry = self.tracks.systems.get_mut(into);
        entry.reports = entry.reports.saturating_add(reports);
        // The knowledge of sources here is not mixed with reports of other centres.
        let takes_over = match (entry.is_foreign, is_foreign) {
            (true, false) => true,
            (false, true) => false,
            _ if apart_m.is_some() => false,
            _ => filter.is_surer_than(&entry.filter),
        };
        if takes_over {
            (entry.filter, entry.is_foreign) = (filter, is_foreign);
        }
        entry.contributors |= contributors;
        if takes_over {
            self.tracks.kept.take_over(from, into);
        }
        let into = self.tracks.systems.get(into).number;
        out.decision(&Decision {
            time_ns: now_ns,
            kind: DecisionKind::Merged.code(),
            system_track: ended,
            other_system_track: into,
            value: d2,
            limit: self.settings.association.scan_gate(),
            ..Decision::default()
        });
        out.count(NO_SOURCE, Counter::TracksMerged);
        Next::End(MergedTrack {
            ended: from,
            into,
            time_ns: now_ns,
        })
    }
}

/// Number of successive findings of `number`, the present included, given the `last` number and its findings.
fn hits_in_a_row(last: Option<(u32, u32)>, number: u32) -> u32 {
    match last {
        Some((last, hits)) if last == number => hits + 1,
        _ => 1,
    }
}
