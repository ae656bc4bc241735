//! The live sensor tracks of all sources: latest report, history, and system track.

use std::collections::HashMap;

use estimation::length;
use messages::{AXES, Covariance, Identity, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use serde::{Deserialize, Serialize};
use source_models::{
    CLAIM_MAX, Content, Correction, CovarianceBasis, DetectionPoint, EarlierReport, GainEvidence, Measurement,
    StatedState, Stretch, states_velocity, whole_report,
};

use crate::admit::verification::Verification;
use crate::associate::identity::{KnownNames, NameIndex};
use crate::associate::recognition::is_reachable;
use crate::history::Histories;
use crate::places::{self, TablePlace};
use crate::quality::Qualities;
use crate::settings::TargetSizeSettings;
use crate::tables::description::Description;
use crate::tables::number_hasher::{NumberHasher, table};
use crate::tables::quota::Quota;
use crate::update::filter_input::FilterInput;

/// Place of a sensor track in the table.
pub(crate) type SensorSlot = u32;

/// [`SensorEntry::system`] of a sensor track that belongs to no system track yet.
pub(crate) const NO_SYSTEM: u32 = u32::MAX;

/// Squared deviation from the expected place, in variances per axis, beyond which no measurement caused it.
const DISPLACED: f64 = 30.0;
/// Least share of such a deviation by which the velocity of a track follows, in the period of the reports.
const FOLLOWS: f64 = 0.05;

/// Role of a sensor track in its system track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    /// The primary track, which contributes for its source.
    Primary,
    /// A track whose source already has a primary track there: another part of the target, or a number not yet taken
    /// over.
    Duplicate,
    /// A track contradicted by other sources, without a contribution.
    SetAside,
}

/// The next sensor track of the same system track, if any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct MemberLink(SensorSlot);

impl MemberLink {
    const NONE: Self = Self(SensorSlot::MAX);

    pub(crate) fn to(slot: Option<SensorSlot>) -> Self {
        slot.map_or(Self::NONE, Self)
    }

    pub(crate) fn get(self) -> Option<SensorSlot> {
        (self != Self::NONE).then_some(self.0)
    }
}

/// The sensor tracks of a system track with entries, newest link first.
#[derive(Clone, Debug)]
pub(crate) struct MemberEntries<'a> {
    entries: &'a [SensorEntry],
    next: MemberLink,
}

impl<'a> Iterator for MemberEntries<'a> {
    type Item = (SensorSlot, &'a SensorEntry);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        // The end of the list is a place beyond any table.
        let MemberLink(member) = self.next;
        let entry = self.entries.get(member as usize)?;
        self.next = entry.next;
        Some((member, entry))
    }
}

/// Live sensor track. Fields read by every report of the other members of its system track come first, in one cache
/// line. Small fields stand together: the entry fills thirteen lines.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(crate) struct SensorEntry {
    /// Time of `latest`, nanoseconds.
    pub(crate) time_ns: i64,
    /// Share in the estimate of the system track's filter.
    pub(crate) share: f64,
    /// Mean innovation of the system track's filter over the last reports (east, north), variance per axis, and the
    /// number of innovations so far.
    pub(crate) residual_mean_m: [f64; 2],
    pub(crate) residual_variance_m2: f64,
    pub(crate) residuals: u32,
    /// Mean difference of the measured heights from the filter over the last reports, metres, and variance, m²; 0
    /// before the first height.
    pub(crate) height_mean_m: f32,
    pub(crate) height_variance_m2: f32,
    /// System track of this sensor track, or [`NO_SYSTEM`].
    pub(crate) system: u32,
    pub(crate) next: MemberLink,
    /// Number at the source.
    pub(crate) track_number: u32,
    /// Source of `latest`.
    pub(crate) source: u16,
    pub(crate) role: Role,
    /// Alerts of `latest`, and whether the target is on the ground.
    pub(crate) alerts: u8,
    pub(crate) on_ground: bool,
    /// Whether `latest` states a group or a type.
    pub(crate) is_described: bool,
    /// Whether this is a system track of another centre.
    pub(crate) is_foreign: bool,
    /// The latest report, without the source's known errors.
    pub(crate) latest: SensorTrack,
    /// Whether the covariance of `latest` was repaired: then the source is not judged by this report.
    pub(crate) repaired: bool,
    /// Origin of the covariance of `latest`.
    pub(crate) basis: CovarianceBasis,
    /// True if the source has displaced the track, and nothing supports the new place yet.
    pub(crate) is_displaced: bool,
    /// Whether the source leads the track off the target, as shown by the other sources.
    pub(crate) is_led_off: bool,
    /// Successive reports that did not fit the rest of the system track.
    pub(crate) misfits: u32,
    /// Number of another system track that fitted the last reports, and the number of successive fits.
    pub(crate) competing: Option<(u32, u32)>,
    /// Number of the possibly crossed system track, and the sum of log-likelihood ratios.
    pub(crate) crossed: Option<(u32, f32)>,
    /// Number of earlier changes of the correction of gross errors of the source: `Alignment::epoch_of`.
    pub(crate) epoch: u8,
    /// Whether this place of the table is taken.
    live: bool,
    /// Whether the track waits for the end of a scan.
    pub(crate) waits: bool,
    /// Whether the track has left a system track after a misfit.
    pub(crate) has_left: bool,
    /// True while an order keeps the track from starting or joining a system track.
    pub(crate) blocked: bool,
    /// Correction applied to `latest`.
    correction: Correction,
    /// Reports so far.
    pub(crate) reports: u32,
    /// Successive scans without a report.
    pub(crate) misses: u32,
    /// Time of the first report, nanoseconds.
    pub(crate) started_ns: i64,
    /// Detection point of the source on the target.
    pub(crate) point: DetectionPoint,
    /// Code and call sign from the reports.
    pub(crate) names: KnownNames,
    /// Verification of the positions reported by the target, by sensors.
    pub(crate) verification: Verification,
    /// Evidence from the reports for the gain of the source's tracker.
    pub(crate) evidence: GainEvidence,
    /// Evidence from the measurements for leaps of the detection point.
    pub(crate) leap_watch: LeapWatch,
    /// Distance of `latest` from the place predicted by the previous report, east and north, metres.
    pub(crate) moved_m: [f32; 2],
    /// Factor by which the covariances used by the system filter before `latest` turned out too small.
    pub(crate) claimed_too_much: f64,
}

// Another line would cost a tenth of the engine's data misses.
const _: () = assert!(size_of::<SensorEntry>() == 13 * 64);

/// Evidence for leaps from the measurements of a sensor track.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LeapWatch {
    /// Distance of the first waiting measurement, and number of waiting measurements.
    pub(crate) leap_m: [f32; 2],
    pub(crate) waiting: u8,
    /// Logarithm of the likelihood ratio, from other sources, of a target that has stayed to a target that has moved.
    pub(crate) stayed: f32,
}

impl LeapWatch {
    /// Whether measurements wait.
    pub(crate) fn is_waiting(&self) -> bool {
        self.waiting > 0
    }
}

impl Default for SensorEntry {
    fn default() -> Self {
        Self {
            time_ns: 0,
            track_number: 0,
            source: 0,
            alerts: 0,
            on_ground: false,
            is_described: false,
            is_foreign: false,
            latest: SensorTrack::default(),
            role: Role::Duplicate,
            system: NO_SYSTEM,
            next: MemberLink::NONE,
            repaired: false,
            misfits: 0,
            has_left: false,
            competing: None,
            crossed: None,
            epoch: 0,
            live: false,
            waits: false,
            blocked: false,
            correction: Correction::NONE,
            reports: 0,
            misses: 0,
            started_ns: 0,
            share: 0.0,
            residuals: 0,
            residual_mean_m: [0.0; 2],
            residual_variance_m2: 0.0,
            height_mean_m: 0.0,
            height_variance_m2: 0.0,
            point: DetectionPoint::default(),
            names: KnownNames::default(),
            verification: Verification::default(),
            evidence: GainEvidence::default(),
            is_displaced: false,
            is_led_off: false,
            leap_watch: LeapWatch::default(),
            moved_m: [0.0; 2],
            basis: CovarianceBasis::Stated,
            claimed_too_much: 1.0,
        }
    }
}

impl SensorEntry {
    /// The latest report, and the corrections subtracted.
    #[inline]
    pub(crate) fn stated(&self) -> StatedState<'_> {
        StatedState {
            report: &self.latest,
            correction: &self.correction,
        }
    }

    /// Largest size of the target, metres, by its type and speed. An aircraft address excludes a vessel, however slow
    /// the target is.
    pub(crate) fn size_m(&self, sizes: &TargetSizeSettings) -> f64 {
        let speed_mps = match self.latest.identity.address() {
            Some(_) => f64::INFINITY,
            None => length([self.latest.velocity_mps[0], self.latest.velocity_mps[1]]),
        };
        sizes.of(&self.latest.target_type, speed_mps)
    }

    /// The latest report before the next report is taken.
    #[inline]
    pub(crate) fn earlier(&self) -> EarlierReport<'_> {
        EarlierReport {
            stated: self.stated(),
            evidence: &self.evidence,
            reports: self.reports,
        }
    }

    /// Correction applied to the latest report.
    pub(crate) fn correction(&self) -> &Correction {
        &self.correction
    }

    /// Adds the next report, with the accepted `identity` and the `content`, without the source's known biases.
    pub(crate) fn take(
        &mut self,
        report: &SensorTrack,
        identity: Identity,
        correction: &Correction,
        content: &Content,
    ) {
        let Correction {
            shift_m,
            covariance_scale,
            stretch,
        } = *correction;
        self.claimed_too_much = content.unfiltered.map_or(1.0, |_| self.claimed_before(content));
        let seconds = (report.time_of_measurement_ns - self.time_ns) as f64 / NS_PER_S;
        let (before_m, before_mps) = (self.stated().stated_m(), self.latest.velocity_mps);
        let moved_m = std::array::from_fn(|axis| report.position_m[axis] - before_m[axis] - before_mps[axis] * seconds);
        self.moved_m = moved_m.map(|way_m| way_m as f32);
        self.is_displaced |= self.displaces(report, moved_m, seconds);
        // Written in one go: a read-back of data just written so far away would take as long as the way there.
        self.latest = SensorTrack {
            identity,
            position_m: std::array::from_fn(|axis| report.position_m[axis] - shift_m[axis]),
            ..*report
        };
        self.basis = CovarianceBasis::Stated;
        if let Some(unfiltered) = &content.unfiltered {
            (self.basis, self.evidence) = (unfiltered.basis, unfiltered.evidence);
            if let Some(covariance) = unfiltered.covariance {
                self.latest.covariance = covariance;
            }
        }
        if covariance_scale != 1.0 {
            let upper = &mut self.latest.covariance.upper;
            upper.iter_mut().for_each(|value| *value *= covariance_scale);
        }
        if stretch != Stretch::NONE {
            stretch.apply_to_state(&mut self.latest.covariance);
        }
        self.time_ns = report.time_of_measurement_ns;
        self.alerts = report.alerts;
        self.on_ground = report.has(sensor_track_bits::ON_GROUND);
        self.is_described = Description::is_in(report);
        self.correction = *correction;
        self.reports = self.reports.saturating_add(1);
        self.misses = 0;
    }

    /// Returns whether `report`, the next report, displaces the track: its position is far from the place predicted by
    /// the latest report, by both covariances, and its velocity does not follow. A measurement moves both.
    #[inline]
    fn displaces(&self, report: &SensorTrack, moved_m: [f64; 2], seconds: f64) -> bool {
        let before_mps = &self.latest.velocity_mps;
        let square_m2 = moved_m[0] * moved_m[0] + moved_m[1] * moved_m[1];
        let trace = |of: &Covariance, first: usize| of.get(first, first) + of.get(first + 1, first + 1);
        // The variance of the report alone decides for most.
        if square_m2 <= DISPLACED * 0.5 * trace(&report.covariance, 0) {
            return false;
        }
        let before = &self.latest.covariance;
        let trace_m2 = trace(&report.covariance, 0) + trace(before, 0) + trace(before, AXES) * seconds * seconds;
        let is_far = square_m2 > DISPLACED * 0.5 * trace_m2 && self.reports > 0;
        if !is_far || !states_velocity(report) || !states_velocity(&self.latest) {
            return false;
        }
        let followed = |axis: usize| moved_m[axis] * (report.velocity_mps[axis] - before_mps[axis]) * seconds;
        followed(0) + followed(1) < FOLLOWS * square_m2
    }

    /// Factor by which the covariance of the latest report is too small, as shown by the content of the next report.
    fn claimed_before(&self, content: &Content) -> f64 {
        let is_better_known = content
            .unfiltered
            .is_some_and(|unfiltered| unfiltered.basis > self.basis);
        let before_m2 = self.latest.covariance.get(0, 0) + self.latest.covariance.get(1, 1);
        match &content.measurement {
            Some(measurement) if is_better_known && self.reports > 0 => {
                (2.0 * measurement.variance_m2() / before_m2).clamp(1.0, CLAIM_MAX)
            }
            _ => 1.0,
        }
    }

    /// A measurement in the report, or the whole report, without corrections, as input of the filter of a system
    /// track.
    pub(crate) fn input(&self, system_track: u32, measurement: Option<&Measurement>) -> FilterInput {
        let mut raw = measurement.copied().unwrap_or_else(|| whole_report(&self.latest));
        raw.uncorrect(&self.correction);
        let shift_m = self.correction.shift_m;
        let variance = |axis: usize| self.latest.covariance.get(axis + AXES, axis + AXES);
        FilterInput {
            time_ns: self.time_ns,
            system_track,
            source: self.source,
            begins: measurement.is_none(),
            has_height: raw.axes == AXES,
            position_m: raw.position_m,
            covariance_m2: raw.covariance_m2,
            velocity_mps: self.latest.velocity_mps,
            reported_m: std::array::from_fn(|axis| self.latest.position_m[axis] + shift_m[axis]),
            velocity_m2ps2: std::array::from_fn(variance),
            point_m: [0.0; 2],
            point_m2: 0.0,
            replaces: false,
            sensor_track: self.track_number,
            correction: self.correction,
            assumed: None,
        }
    }

    /// Clears the relation to the last system track before the track joins another.
    pub(crate) fn forget_target(&mut self) {
        self.misfits = 0;
        self.competing = None;
        self.crossed = None;
        self.share = 0.0;
        self.residuals = 0;
        self.residual_mean_m = [0.0; 2];
        self.residual_variance_m2 = 0.0;
        (self.height_mean_m, self.height_variance_m2) = (0.0, 0.0);
        self.point = DetectionPoint::default();
        self.is_displaced = false;
        self.is_led_off = false;
        self.leap_watch = LeapWatch::default();
    }
}

impl TablePlace for SensorEntry {
    fn is_taken(&self) -> bool {
        self.live
    }

    fn free() -> Self {
        Self::default()
    }
}

/// The table: preallocated entries, found by source and track number.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SensorTracks {
    #[serde(with = "places")]
    entries: Vec<SensorEntry>,
    free: Vec<SensorSlot>,
    quota: Quota,
    #[serde(with = "table")]
    by_number: HashMap<(u16, u32), SensorSlot, NumberHasher>,
    /// Sensor tracks by name.
    pub(crate) names: NameIndex,
    /// Start of the next search for silent sensor tracks, and end of the present part of the table.
    swept: usize,
    part_end: usize,
    /// Whether histories are kept, and whether quality indices are.
    looks_back: bool,
    scores: bool,
    pub(crate) histories: Histories,
    pub(crate) qualities: Qualities,
}

impl SensorTracks {
    /// Returns a table for `capacity` sensor tracks of `sources` sources, with the requested histories, and with the
    /// results of recent scans if a rule `scores` these.
    pub(crate) fn new(capacity: usize, sources: usize, histories: Option<Histories>, scores: bool) -> Self {
        // With room for twice the entries, the map clears its tombstones in place and never grows.
        let by_number = HashMap::with_capacity_and_hasher(2 * capacity, NumberHasher::new(2 * capacity));
        Self {
            entries: vec![SensorEntry::default(); capacity],
            free: (0..capacity as SensorSlot).rev().collect(),
            quota: Quota::new(capacity, sources),
            by_number,
            names: NameIndex::new(capacity),
            swept: 0,
            part_end: 0,
            looks_back: histories.is_some(),
            scores,
            histories: histories.unwrap_or(Histories::new(0, 0, 1.0)),
            qualities: Qualities::new(if scores { capacity } else { 0 }),
        }
    }

    /// Largest possible number of sensor tracks.
    pub(crate) fn capacity(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn find(&self, source: u16, number: u32) -> Option<SensorSlot> {
        self.by_number.get(&(source, number)).copied()
    }

    /// A new entry for the sensor track of `report`, which is not taken yet, without a system track; `None` if the
    /// table is full for the source.
    pub(crate) fn insert(&mut self, report: &SensorTrack) -> Option<SensorSlot> {
        let slot = self.quota.take(report.source).then(|| self.free.pop())??;
        self.by_number.insert((report.source, report.track_number), slot);
        if self.looks_back {
            self.histories.clear(slot as usize);
        }
        if self.scores {
            self.qualities.clear(slot as usize);
        }
        self.entries[slot as usize] = SensorEntry {
            source: report.source,
            track_number: report.track_number,
            live: true,
            started_ns: report.time_of_measurement_ns,
            ..SensorEntry::default()
        };
        Some(slot)
    }

    /// Notes the latest report of the sensor track in `slot`, for rules with a history. The source reports every
    /// `period_ns`.
    pub(crate) fn note(&mut self, slot: SensorSlot, period_ns: i64) {
        if !self.looks_back {
            return;
        }
        let latest = &self.entries[slot as usize].latest;
        self.histories.push(slot as usize, latest);
        if self.scores {
            let confirmed = latest.state == TrackState::Confirmed as u8;
            self.qualities
                .push(slot as usize, latest.time_of_measurement_ns, period_ns, confirmed);
        }
    }

    /// Takes the names in the next `report` of `slot`; `identity` is the believed part of the report's identity.
    /// Returns `identity`, without a code or an address that may be garbled.
    #[inline]
    pub(crate) fn believe(&mut self, slot: SensorSlot, report: &SensorTrack, mut identity: Identity) -> Identity {
        let entry = &mut self.entries[slot as usize];
        let reported = &report.identity;
        if entry.names.knows(reported) {
            return identity;
        }
        let before = entry.names.indexed();
        if let Some(address) = reported.unique_number() {
            let may_be_same = entry.reports > 0 && is_reachable(&entry.latest, report);
            if !entry.names.believe_address(address, may_be_same) {
                identity = identity.without_unique_number();
            }
        }
        entry.names.hear(reported);
        let believed = entry.names.believe(identity);
        let after = entry.names.indexed();
        if before != after {
            self.names.replace(slot, before, after);
        }
        believed
    }

    /// Frees `slot`, which no system track may link to any more.
    pub(crate) fn remove(&mut self, slot: SensorSlot) {
        let entry = &mut self.entries[slot as usize];
        self.names.replace(slot, entry.names.indexed(), Default::default());
        entry.waits = false;
        entry.live = false;
        self.by_number.remove(&(entry.source, entry.track_number));
        self.quota.give_back(entry.source);
        self.free.push(slot);
    }

    /// Begins the search of a further part of the table for silent sensor tracks: sources need not report the end of
    /// tracks.
    pub(crate) fn begin_part(&mut self) {
        const PARTS: usize = 16;
        if self.swept == self.entries.len() {
            self.swept = 0;
        }
        self.part_end = (self.swept + self.entries.len() / PARTS + 1).min(self.entries.len());
    }

    /// The next places of that part, few at a time: each costs an access far into memory, and no report should wait
    /// for many accesses.
    pub(crate) fn next_places(&mut self) -> std::ops::Range<SensorSlot> {
        const PLACES: usize = 16;
        let end = (self.swept + PLACES).min(self.part_end);
        let places = self.swept as SensorSlot..end as SensorSlot;
        self.swept = end;
        places
    }

    /// Whether `slot` is taken by a sensor track without report since `since_ns`.
    pub(crate) fn is_silent(&self, slot: SensorSlot, since_ns: i64) -> bool {
        let entry = self.get(slot);
        entry.live && entry.time_ns < since_ns
    }

    /// Returns whether a sensor track of `source` occupies `slot`.
    pub(crate) fn is_of(&self, slot: SensorSlot, source: u16) -> bool {
        let entry = self.get(slot);
        entry.live && entry.source == source
    }

    /// The members of a system track, of which `first` was linked last.
    #[inline]
    pub(crate) fn members_from(&self, first: Option<SensorSlot>) -> MemberEntries<'_> {
        MemberEntries {
            entries: &self.entries,
            next: MemberLink::to(first),
        }
    }

    /// Number of sensor tracks of `source`.
    pub(crate) fn count_of(&self, source: u16) -> usize {
        self.quota.taken(source)
    }

    /// Calls `change` with each of these members; `change` may not link the members elsewhere.
    #[inline]
    pub(crate) fn for_members_from(&mut self, first: Option<SensorSlot>, mut change: impl FnMut(&mut SensorEntry)) {
        let mut at = MemberLink::to(first);
        while let Some(entry) = self.entries.get_mut(at.0 as usize) {
            change(entry);
            at = entry.next;
        }
    }

    pub(crate) fn get(&self, slot: SensorSlot) -> &SensorEntry {
        &self.entries[slot as usize]
    }

    pub(crate) fn get_mut(&mut self, slot: SensorSlot) -> &mut SensorEntry {
        &mut self.entries[slot as usize]
    }
}
