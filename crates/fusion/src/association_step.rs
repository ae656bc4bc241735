//! Deciding which system track a report could belong to (TI-3, BF-2).
//!
//! The obvious answer, "the nearest", flickers: of two aircraft side by side, noise makes now one, now the other the
//! nearest. So a sensor track, once joined, *stays*: sensors track their targets well, and their track numbers carry
//! more evidence than one position. What is here is asked only for sensor tracks that belong nowhere, or stand alone:
//! which system tracks near them fit, and how well.
//!
//! How well is the statistical distance of position and velocity between the sensor track and the system filter. Both
//! lag behind the same manoeuvre, so their errors are correlated and their difference is smaller than the sum of their
//! covariances says: for the nearly constant velocity filters of the literature d² averages 1.1 instead of 2. Distances
//! are scaled up by what a configured correlation leaves. Where sources see different points of large targets, the
//! spread of these points is added, as configured or as learned.

use estimation::{ComparedComponents, Gaussian, NearlyConstantVelocity, statistical_distance};
use messages::{SensorTrack, TrackState, sensor_track_bits};

use crate::engine::gaussian_of;
use crate::sensor_tracks::{NO_SYSTEM, Role, SensorSlot, SensorTracks};
use crate::settings::Settings;
use crate::source_model::SourceModel;
use crate::system_tracks::{SystemSlot, SystemTracks};

/// Most cells of the grid along one side of a search.
const SEARCH_CELLS_MAX: i32 = 16;
/// Variance added to a difference of velocities, m²/s²: smoothing lags in turns, whatever a source claims.
const VELOCITY_FLOOR_M2PS2: f64 = 4.0;
/// Variance added to a difference of heights, m²: pressure altitude comes in steps of 100 ft, and drifts with the weather.
const HEIGHT_FLOOR_M2: f64 = 900.0;

/// What a search needs to look at, borrowed from the engine.
pub(crate) struct Search<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) sensors: &'a SensorTracks,
    pub(crate) systems: &'a SystemTracks,
    pub(crate) models: &'a [SourceModel],
    pub(crate) motion: &'a NearlyConstantVelocity,
}

impl Search<'_> {
    /// Calls `visit` with every system track that the sensor track in `own` could join, and their d².
    pub(crate) fn admissible(&self, own: SensorSlot, mut visit: impl FnMut(SystemSlot, f64)) {
        let entry = self.sensors.get(own);
        let report = &entry.latest;
        let state = gaussian_of(report);
        self.near(report, &state, |system| {
            if system == entry.system
                || self
                    .speaker(system, report.source, own, report.time_of_measurement_ns)
                    .is_some()
                || self.must_wait_for(own, system)
            {
                return;
            }
            if let Some(d2) = self.distance(report, &state, system) {
                visit(system, d2);
            }
        });
    }

    /// A system track that the sensor track's source already follows and whose extent covers it, with the distance in
    /// metres: then it is another part of that target.
    pub(crate) fn other_part(&self, own: SensorSlot) -> Option<(SystemSlot, f64)> {
        let report = &self.sensors.get(own).latest;
        let state = gaussian_of(report);
        let now_ns = report.time_of_measurement_ns;
        let mut best: Option<(f64, u32, SystemSlot)> = None;
        self.near(report, &state, |system| {
            let Some(speaker) = self.speaker(system, report.source, own, now_ns) else {
                return;
            };
            let latest = &self.sensors.get(speaker).latest;
            let other = gaussian_of(latest);
            let seconds = (now_ns - latest.time_of_measurement_ns) as f64 / messages::NS_PER_S;
            let both = report.has(sensor_track_bits::HEIGHT) && latest.has(sensor_track_bits::HEIGHT);
            let apart = |axis: usize| state.mean[axis] - other.mean[axis] - other.mean[axis + 3] * seconds;
            let metres = apart(0).hypot(apart(1));
            let number = self.systems.get(system).number;
            if metres <= self.settings.association.target_extent_m
                && !(both && height_distance(&state, &other) > self.settings.association.join_gate)
                && self.is_compatible(report, system)
                && best.is_none_or(|(least, least_number, _)| (metres, number) < (least, least_number))
            {
                best = Some((metres, number, system));
            }
        });
        best.map(|(metres, _, system)| (system, metres))
    }

    /// Another system track that could be the same target as `own`, with their d²: no source follows both, their states
    /// agree, and no further one comes near to agreeing.
    pub(crate) fn twin(&self, own: SystemSlot, now_ns: i64) -> Option<(SystemSlot, f64)> {
        const MARGIN: f64 = 6.0;
        let entry = self.systems.get(own);
        let state = entry.filter.full_at(now_ns, self.motion);
        let sources = self.sources_of(own, now_ns);
        let (mut best, mut second): (Option<(f64, SystemSlot)>, f64) = (None, f64::INFINITY);
        let reach = self.reach(&state);
        self.systems
            .grid
            .near(state.mean[0], state.mean[1], reach, SEARCH_CELLS_MAX, |system| {
                if system == own || self.sources_of(system, now_ns) & sources != 0 {
                    return;
                }
                let other = self.systems.get(system);
                if entry.identity.contradicts(&other.identity) && self.settings.association.use_identity {
                    return;
                }
                let theirs = other.filter.full_at(now_ns, self.motion);
                let heights = entry.filter.has_height && other.filter.has_height;
                if let Some(d2) = self.compare(&state, &theirs, heights, self.spread_m2(None)) {
                    if best.is_none_or(|(least, slot)| (d2, system) < (least, slot)) {
                        second = best.map_or(f64::INFINITY, |(least, _)| least);
                        best = Some((d2, system));
                    } else {
                        second = second.min(d2);
                    }
                }
            });
        best.filter(|(d2, _)| second > d2 + MARGIN)
            .map(|(d2, system)| (system, d2))
    }

    /// Fresh sources of a system track, as bits.
    pub(crate) fn sources_of(&self, system: SystemSlot, now_ns: i64) -> u64 {
        self.fresh_primaries(system, now_ns)
            .fold(0, |bits, member| bits | 1 << self.sensors.get(member).source)
    }

    /// Calls `visit` with every system track near a report.
    fn near(&self, report: &SensorTrack, state: &Gaussian, visit: impl FnMut(SystemSlot)) {
        let reach = self.reach(state);
        self.systems.grid.near(
            report.position_m[0],
            report.position_m[1],
            reach,
            SEARCH_CELLS_MAX,
            visit,
        );
    }

    /// How far from `state` a system track of the same target can have been placed.
    fn reach(&self, state: &Gaussian) -> f64 {
        let settings = &self.settings.association;
        let p = &state.covariance;
        let sigma = association::distance::largest_sigma2([p[(0, 0)], p[(0, 1)], p[(1, 1)]]);
        let sigma = sigma.hypot(self.spread_m2(None).sqrt());
        let speed = state.mean[3].hypot(state.mean[4]);
        // The system track was placed at its latest report; its own uncertainty is covered by half a cell.
        let moved = speed * self.settings.longest_period_s();
        (settings.join_gate.sqrt() * sigma).max(settings.target_extent_m) + 0.5 * settings.cell_m + moved
    }

    /// d² between a report and a system track; `None` if the report may not join it.
    fn distance(&self, report: &SensorTrack, state: &Gaussian, system: SystemSlot) -> Option<f64> {
        if !self.is_compatible(report, system) {
            return None;
        }
        let filter = &self.systems.get(system).filter;
        let other = filter.full_at(report.time_of_measurement_ns, self.motion);
        let heights = filter.has_height && report.has(sensor_track_bits::HEIGHT);
        self.compare(state, &other, heights, self.spread_m2(Some(report.source)))
    }

    /// d² between two states of one time, inside the gates.
    fn compare(&self, a: &Gaussian, b: &Gaussian, heights: bool, spread_m2: f64) -> Option<f64> {
        let settings = &self.settings.association;
        let mut wider = *a;
        for axis in 0..2 {
            wider.covariance[(axis, axis)] += spread_m2;
            wider.covariance[(axis + 3, axis + 3)] += VELOCITY_FLOOR_M2PS2;
        }
        let scale = 1.0 / (1.0 - settings.error_correlation);
        let position = scale * statistical_distance(&wider, b, ComparedComponents::HorizontalPosition);
        if position > settings.join_gate {
            return None;
        }
        let both = scale * statistical_distance(&wider, b, ComparedComponents::HorizontalPositionAndVelocity);
        let height = if heights { height_distance(a, b) } else { 0.0 };
        // Written so that NaN is refused.
        let inside = height <= settings.join_gate && both + height <= settings.scan_gate();
        inside.then_some(both + height)
    }

    /// Variance per axis of where detection points lie on a target, m²: configured, or learned if that is more.
    pub(crate) fn spread_m2(&self, source: Option<u16>) -> f64 {
        let configured = self.settings.association.extent_sigma_m * self.settings.association.extent_sigma_m;
        let learned = |model: &SourceModel| model.spread_m2();
        match source {
            Some(source) => configured.max(learned(&self.models[usize::from(source)])),
            None => self.models.iter().map(learned).fold(configured, f64::max),
        }
    }

    /// Of two system tracks with one source each, the sensor track of the younger moves, so that the older number stays
    /// and they do not swap places.
    fn must_wait_for(&self, own: SensorSlot, system: SystemSlot) -> bool {
        let entry = self.sensors.get(own);
        entry.system != NO_SYSTEM
            && self.systems.get(system).number > self.systems.get(entry.system).number
            && self.has_one_source(system, entry.latest.time_of_measurement_ns)
    }

    /// Whether no other source contributes to the system track of `own`.
    pub(crate) fn is_alone(&self, own: SensorSlot, now_ns: i64) -> bool {
        let system = self.sensors.get(own).system;
        self.fresh_primaries(system, now_ns).all(|member| member == own)
    }

    /// Whether at most one source contributes to `system`.
    pub(crate) fn has_one_source(&self, system: SystemSlot, now_ns: i64) -> bool {
        self.fresh_primaries(system, now_ns).nth(1).is_none()
    }

    /// The fresh primary of `source` in `system`, other than `own`.
    pub(crate) fn speaker(&self, system: SystemSlot, source: u16, own: SensorSlot, now_ns: i64) -> Option<SensorSlot> {
        self.fresh_primaries(system, now_ns)
            .find(|member| *member != own && self.sensors.get(*member).source == source)
    }

    /// The sensor tracks that contribute to `system` at `now_ns`.
    pub(crate) fn fresh_primaries(&self, system: SystemSlot, now_ns: i64) -> impl Iterator<Item = SensorSlot> {
        self.systems.members(self.sensors, system).filter(move |member| {
            let entry = self.sensors.get(*member);
            entry.role == Role::Primary && self.is_fresh(entry.source, entry.time_ns, now_ns)
        })
    }

    fn is_fresh(&self, source: u16, time_ns: i64, now_ns: i64) -> bool {
        now_ns - time_ns <= self.settings.sources[usize::from(source)].fresh_ns
    }

    /// Whether the source has made enough of its track for it to be compared with others.
    pub(crate) fn is_established(&self, sensor: SensorSlot) -> bool {
        let entry = self.sensors.get(sensor);
        entry.reports >= 2 || entry.latest.state == TrackState::Confirmed as u8
    }

    /// Whether neither identity nor height forbids that the report belongs to the system track.
    fn is_compatible(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let entry = self.systems.get(system);
        let identity = !self.settings.association.use_identity || !report.identity.contradicts(&entry.identity);
        identity && self.can_be_seen_together(report, system)
    }

    /// Heights must agree where known, and lie within what every source concerned can see.
    fn can_be_seen_together(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let entry = self.systems.get(system);
        let height = report.has(sensor_track_bits::HEIGHT).then_some(report.position_m[2]);
        let theirs = entry.filter.has_height.then_some(entry.filter.estimate.mean[2]);
        let ceiling = |source: u16| self.settings.sources[usize::from(source)].ceiling_m;
        if let (Some(a), Some(b)) = (height, theirs)
            && (a - b).abs() > self.settings.association.height_gate_m
        {
            return false;
        }
        theirs.is_none_or(|z| z <= ceiling(report.source))
            && height.is_none_or(|z| {
                self.fresh_primaries(system, report.time_of_measurement_ns)
                    .all(|member| z <= ceiling(self.sensors.get(member).source))
            })
    }
}

/// d² of two heights.
fn height_distance(a: &Gaussian, b: &Gaussian) -> f64 {
    let variance = a.covariance[(2, 2)] + b.covariance[(2, 2)] + HEIGHT_FLOOR_M2;
    let apart_m = a.mean[2] - b.mean[2];
    apart_m * apart_m / variance
}
