//! Search for the system tracks that a report could belong to (TI-3, BF-2).
//!
//! Choosing the nearest system track flickers: of two aircraft side by side, noise makes now the first, now the second
//! the nearest. Therefore a sensor track *stays* after joining: sensors track their targets well, and track numbers
//! are stronger evidence than a position. This module is called only for sensor tracks without a system track, or
//! alone on a system track. The result: the fitting system tracks nearby, with their distances.
//!
//! The measure is the statistical distance of position and velocity between the sensor track and the system filter.
//! Both lag behind the same manoeuvre. Their errors are therefore correlated, and the difference is smaller than the
//! sum of both covariances: for the nearly constant velocity filters of the literature, d² averages 1.1 instead of 2.
//! Distances are scaled up by a configured correlation. If sources see different points of large targets, the
//! configured or learned spread of these points is added.
//!
//! A distance must lie inside the gates (`Search::compare`): the join gate for position and for height, the scan gate
//! for position, velocity and height together. A sensor track leaves its system track by the wider keep gate (module
//! `linking`). The values of the gates are keys of `[fusion.association]` (`settings/association.rs`).

use estimation::{ComparedComponents, Gaussian, length, statistical_distance};
use messages::{Covariance, Identity, NS_PER_S, SensorTrack, TrackState, sensor_track_bits};
use source_models::{SILENT, gaussian_of};

use crate::associate::identity;
use crate::settings::{Settings, SourceSet};
use crate::tables::sensor_tracks::{NO_SYSTEM, SensorEntry, SensorSlot};
use crate::tables::system_tracks::{Bond, SystemEntry, SystemSlot};
use crate::tables::tracks::Tracks;

/// Most cells of the grid along one side of a search.
pub(crate) const SEARCH_CELLS_MAX: i32 = 16;
/// Variance added to a difference of velocities, m²/s²: smoothing lags in turns, independent of the stated accuracy.
const VELOCITY_FLOOR_M2PS2: f64 = 4.0;
/// Gate for coming back after a start, relative to the gate for staying.
const RESUMPTION: f64 = 4.0;
/// Variance added to a difference of heights, m²: pressure altitude comes in steps of 100 ft, and drifts with the
/// weather.
const HEIGHT_FLOOR_M2: f64 = 900.0;

/// Variance per axis of detection points on a target while a second track beside the target waits, m²: larger than
/// for joins, because waiting costs less than a wrong join.
const DOUBTED_SPREAD_M2: f64 = 15.0 * 15.0;

/// Unpredictable acceleration between two reports of a sensor track, metres per second squared.
const ACCELERATION_MPS2: f64 = 5.0;

/// Largest difference of two velocities of a target, apart from noise, as a part of the speed, if a source rotates
/// positions about its sensor: about 3°.
const TURNED: f64 = 0.05;

/// A search for fitting system tracks.
pub(crate) struct Search<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) tracks: &'a Tracks,
}

/// Largest assumed error of sources without known errors, metres.
const UNKNOWN_M: f64 = 600.0;
/// The same for a track that is not new, in standard deviations of the track.
const SIGMAS: f64 = 4.0;
/// Time for which a system track of sensor tracks from another system track waits, nanoseconds.
const LEFT_NS: i64 = 20_000_000_000;

/// Largest distance of a new track of a sensor in a turn from its possible target, metres.
const FOLLOWED_M: f64 = 1000.0;

impl Search<'_> {
    /// Calls `visit` with every system track that the sensor track in `own` could join, and with d².
    pub(crate) fn admissible(&self, own: SensorSlot, mut visit: impl FnMut(SystemSlot, f64)) {
        let entry = self.tracks.sensors.get(own);
        let report = &entry.latest;
        let state = gaussian_of(report);
        let namesake = self.namesake(own).filter(|(system, _)| self.is_open_to(own, *system));
        if let Some((system, d2)) = namesake {
            return visit(system, d2);
        }
        self.near(report, &state, |system| {
            if system == entry.system || !self.is_open_to(own, system) {
                return;
            }
            if let Some(d2) = self.distance(report, &state, system) {
                visit(system, d2);
            }
        });
    }

    /// Whether no other track of the same source, no order and no younger number keeps a sensor track from `system`.
    pub(crate) fn is_open_to(&self, own: SensorSlot, system: SystemSlot) -> bool {
        let entry = self.tracks.sensors.get(own);
        !self.are_kept_apart(entry.system, system)
            && self
                .tracks
                .primary_of(system, entry.source, own, entry.time_ns)
                .is_none()
            && !self.must_wait_for(own, system)
    }

    /// Returns whether a sensor track may be of a target with another number at the same source, silent for the
    /// greater part of a period: the source may have restarted its numbering, before enough reports show the restart.
    pub(crate) fn may_be_renumbered(&self, own: SensorSlot) -> bool {
        let SensorEntry {
            latest: report,
            time_ns,
            ..
        } = self.tracks.sensors.get(own);
        let period_ns = self.settings.sources[usize::from(report.source)].period_ns;
        let state = gaussian_of(report);
        let is_silent = |primary: SensorSlot| {
            let silence_ns = time_ns.saturating_sub(self.tracks.sensors.get(primary).time_ns);
            silence_ns as f64 >= SILENT * period_ns as f64
        };
        let mut may_be = false;
        self.near(report, &state, |system| {
            may_be |= self
                .tracks
                .primary_of(system, report.source, own, *time_ns)
                .is_some_and(is_silent)
                && self.distance(report, &state, system).is_some();
        });
        may_be
    }

    /// Returns a system track already tracked by the sensor track's source, with an extent that covers the sensor
    /// track, and the distance in metres: the sensor track is then another part of this target.
    pub(crate) fn other_part(&self, own: SensorSlot) -> Option<(SystemSlot, f64)> {
        let report = &self.tracks.sensors.get(own).latest;
        let state = gaussian_of(report);
        let now_ns = report.time_of_measurement_ns;
        let mut best: Option<(f64, u32, SystemSlot)> = None;
        self.near(report, &state, |system| {
            let Some(primary) = self.tracks.primary_of(system, report.source, own, now_ns) else {
                return;
            };
            let latest = &self.tracks.sensors.get(primary).latest;
            let other = gaussian_of(latest);
            let seconds = (now_ns - latest.time_of_measurement_ns) as f64 / NS_PER_S;
            let both = report.has(sensor_track_bits::HEIGHT) && latest.has(sensor_track_bits::HEIGHT);
            let apart = |axis: usize| state.mean[axis] - other.mean[axis] - other.mean[axis + 3] * seconds;
            let metres = length([apart(0), apart(1)]);
            let number = self.tracks.systems.get(system).number;
            if metres <= self.settings.association.target_extent_m
                && !(both && height_distance(&state, &other) > self.settings.association.join_gate())
                && self.is_compatible(report, system)
                && best.is_none_or(|(least, least_number, _)| (metres, number) < (least, least_number))
            {
                best = Some((metres, number, system));
            }
        });
        best.map(|(metres, _, system)| (system, metres))
    }

    /// Returns a possible duplicate of `own` with d²: a system track without a common source and with an agreeing
    /// state, while no system track of another target nearly agrees. A system track without a source in common with
    /// the duplicate may be a further duplicate, and is no hindrance.
    pub(crate) fn duplicate(&self, own: SystemSlot, now_ns: i64) -> Option<(SystemSlot, f64)> {
        const MARGIN: f64 = 6.0;
        if let Some(namesake) = self.namesake_of_system(own, now_ns) {
            return Some(namesake);
        }
        let mut best: Option<(f64, SystemSlot)> = None;
        let spread_m2 = self.tracks.sources.spread_m2(&self.settings.association, None);
        self.alike(own, now_ns, spread_m2, |system, d2| {
            if best.is_none_or(|(least, slot)| (d2, system) < (least, slot)) {
                best = Some((d2, system));
            }
        });
        let (least, duplicate) = best?;
        let sources = self.tracks.sources_of(duplicate, now_ns);
        let mut second = f64::INFINITY;
        self.alike(own, now_ns, spread_m2, |system, d2| {
            if system != duplicate && self.tracks.sources_of(system, now_ns).meets(sources) {
                second = second.min(d2);
            }
        });
        (second > least + MARGIN).then_some((duplicate, least))
    }

    /// Whether the target of the system track `own` may be shown already: as a system track without a common source,
    /// and with an agreeing state, if need be as two points of a large target. While the spread of the points is
    /// unknown, they may lie as far apart as the target is large.
    pub(crate) fn is_shown_already(&self, own: SystemSlot, now_ns: i64) -> bool {
        let learned_m2 = self.tracks.sources.spread_m2(&self.settings.association, None);
        let mut is_shown = false;
        self.alike(own, now_ns, learned_m2.max(DOUBTED_SPREAD_M2), |system, _| {
            is_shown |= self.is_shown(system);
        });
        self.points_aside(own, now_ns, |system| is_shown |= self.is_shown(system));
        is_shown
    }

    /// Whether the target of the system track `own` may be shown already, if all sources of `own` place their targets
    /// elsewhere than other sources: as a track of other sources within `identity.reach_m` with similar velocity,
    /// while the error of the sources is not corrected.
    pub(crate) fn is_shown_elsewhere(&self, own: SystemSlot, now_ns: i64) -> bool {
        let sources = self.tracks.sources_of(own, now_ns);
        let is_doubtful = |source: u16| self.tracks.sources.is_doubtful(source);
        if !sources.iter().all(is_doubtful) {
            return false;
        }
        self.is_shown_within(own, now_ns, self.settings.identity.reach_m)
    }

    /// Returns whether a track that is shown lies [aside](Self::aside) of `own`.
    fn is_shown_within(&self, own: SystemSlot, now_ns: i64, reach_m: f64) -> bool {
        let mut is_shown = false;
        self.aside(own, now_ns, reach_m, |system, _| is_shown |= self.is_shown(system));
        is_shown
    }

    /// Whether the target of the system track `own` may be shown already, as a nearby track of other sources with
    /// similar velocity, while the errors of `own`'s sources are unknown. The errors are unknown in two cases:
    /// - No source of `own` has been compared enough, and the track `is_new` or the sources cannot be compared, since
    ///   their errors change with the place.
    /// - All sensor tracks of `own` have just left another system track, where their stated accuracy was wrong.
    pub(crate) fn is_shown_aside(&self, own: SystemSlot, now_ns: i64, is_new: bool) -> bool {
        let sources = self.tracks.sources_of(own, now_ns);
        let mut own_sources = sources.iter();
        let is_acquainted = |source| self.tracks.sources.is_acquainted(source);
        let is_comparable = own_sources
            .clone()
            .any(|source| self.settings.sources[usize::from(source)].is_registered);
        let is_unknown = (is_new || !is_comparable) && !own_sources.any(is_acquainted);
        let has_just_left = now_ns.saturating_sub(self.tracks.systems.get(own).first_seen_ns) < LEFT_NS
            && self
                .tracks
                .contributing_entries(own, now_ns)
                .all(|(_, entry)| entry.has_left);
        if !(is_unknown || has_just_left) {
            return false;
        }
        let state = self.state(own, now_ns);
        let variance_m2 = state.covariance.get(0, 0) + state.covariance.get(1, 1);
        let reach_m = if is_new {
            UNKNOWN_M
        } else {
            UNKNOWN_M.min(SIGMAS * variance_m2.sqrt())
        };
        self.is_shown_within(own, now_ns, reach_m)
    }

    /// Sources with a track of their own that may be [another point](Self::points_aside) of the target of `own`:
    /// their silence here is no evidence. Of a target that may be large, also the reports of these tracks, which are
    /// reports of the same target.
    pub(crate) fn sources_aside(&self, own: SystemSlot, now_ns: i64) -> (SourceSet, u32) {
        let (mut aside, mut reports) = (SourceSet::EMPTY, 0u32);
        self.points_aside(own, now_ns, |system| {
            aside |= self.tracks.sources_of(system, now_ns);
            reports = reports.saturating_add(self.tracks.systems.get(system).reports);
        });
        let pools = !aside.is_empty() && self.may_be_large(own, now_ns);
        (aside, if pools { reports } else { 0 })
    }

    /// Whether the target of `own` may be larger than most.
    pub(crate) fn may_be_large(&self, own: SystemSlot, now_ns: i64) -> bool {
        self.size_m(own, now_ns) > self.settings.target_size.unknown_m
    }

    /// Returns the tentative track that shows the target of `own` at [another point](Self::points_aside), of a source
    /// that comes first: the point to be kept.
    pub(crate) fn leader_aside(&self, own: SystemSlot, now_ns: i64) -> Option<SystemSlot> {
        let first = |system| {
            let members = self.tracks.contributing_entries(system, now_ns);
            members.map(|(_, entry)| self.settings.rank(entry.source)).min()
        };
        let (mut least, mut leader) = (first(own), None);
        let least_reports = match self.may_be_large(own, now_ns) {
            true => 0,
            false => self.settings.life.confirm_reports,
        };
        self.points_aside(own, now_ns, |system| {
            let (rank, other) = (first(system), self.tracks.systems.get(system));
            let is_ready = other.life == TrackState::Tentative && other.reports >= least_reports;
            if is_ready && rank.is_some() && rank < least {
                (least, leader) = (rank, Some(system));
            }
        });
        leader
    }

    /// Calls `visit` with every system track that may be another point of the target of `own`: it moves alike and lies
    /// no farther away than the target may be large. None while the spread of the points that the sources see is known.
    fn points_aside(&self, own: SystemSlot, now_ns: i64, mut visit: impl FnMut(SystemSlot)) {
        let members = self.tracks.contributing_entries(own, now_ns);
        let unknown = members.filter(|(_, entry)| !self.tracks.sources.knows_spread(entry.source));
        let sizes = unknown.map(|(_, entry)| entry.size_m(&self.settings.target_size));
        if let Some(size_m) = sizes.reduce(f64::max) {
            self.aside(own, now_ns, size_m, |system, apart_m| {
                if apart_m <= size_m {
                    visit(system);
                }
            });
        }
    }

    /// Largest size of the target of `own` by its type and speed, metres.
    pub(crate) fn size_m(&self, own: SystemSlot, now_ns: i64) -> f64 {
        let members = self.tracks.contributing_entries(own, now_ns);
        members
            .map(|(_, member)| member.size_m(&self.settings.target_size))
            .fold(0.0, f64::max)
    }

    /// Returns the system track that may show the target of `own` at another point, and the log-likelihood ratio of one
    /// target to two, as far as silence shows it: of two targets so near, each source follows one and not the other.
    /// The ratio is −∞ before each source had time for both. `None` while another target near by, followed by one of
    /// the sources as well, makes the choice ambiguous.
    pub(crate) fn other_point(&self, own: SystemSlot, now_ns: i64) -> Option<(SystemSlot, f64)> {
        let entry = self.tracks.systems.get(own);
        let size_m = self.size_m(own, now_ns);
        if size_m <= self.settings.target_size.unknown_m {
            return None;
        }
        let gate = self.settings.association.join_gate();
        // Nearer points join by their distance alone.
        if entry.is_foreign || size_m * size_m < gate * entry.filter.variance_m2() {
            return None;
        }
        let (state, own_sources) = (self.state(own, now_ns), self.tracks.sources_of(own, now_ns));
        let [x, y, _] = state.position_m();
        let (mut best, mut seen, mut is_ambiguous): (Option<(f64, SystemSlot)>, SourceSet, bool) =
            (None, own_sources, false);
        self.tracks.systems.grid.near(x, y, size_m, SEARCH_CELLS_MAX, |system| {
            if system == own || is_ambiguous {
                return;
            }
            let sources = self.tracks.sources_of(system, now_ns);
            if sources.is_empty() {
                return;
            }
            let (other, theirs) = (self.tracks.systems.get(system), self.state(system, now_ns));
            let metres = length([state.mean[0] - theirs.mean[0], state.mean[1] - theirs.mean[1]]);
            let heights = entry.filter.has_height && other.filter.has_height;
            let is_level = !heights
                || height_distance(&state, &theirs) <= gate
                    && (state.mean[2] - theirs.mean[2]).abs() <= self.settings.association.height_gate_m;
            if metres > size_m || !is_level || !move_alike(&state, &theirs) {
                return;
            }
            // Another target near by stays in question, whatever its size: it makes the choice ambiguous.
            is_ambiguous |= sources.meets(seen);
            seen |= sources;
            // A source that has followed a target as one with others does not see another point of it.
            let has_followed = |one: &SystemEntry, others: SourceSet| !one.has_points && one.contributors.meets(others);
            let may_be_one = !other.is_foreign
                && metres <= self.size_m(system, now_ns)
                && !has_followed(entry, sources)
                && !has_followed(other, own_sources)
                && entry.bond != Bond::Apart(other.number)
                && !self.are_two_targets(own, system);
            if may_be_one && best.is_none_or(|(least, _)| metres < least) {
                best = Some((metres, system));
            }
        });
        let (_, system) = best.filter(|_| !is_ambiguous)?;
        let other = self.tracks.systems.get(system);
        let began_ns = entry.first_seen_ns.max(other.first_seen_ns);
        let silence = |sources: SourceSet, place_m: [f64; 3]| {
            sources
                .iter()
                .map(|source| {
                    let period_ns = self.settings.sources[usize::from(source)].period_ns;
                    let had_time = now_ns - began_ns >= period_ns + self.tracks.sources.late_ns(source);
                    let detection = self.tracks.sources.follows_at(source, place_m, now_ns);
                    let shown = detection.map_or(0.0, |detection| detection.shown);
                    if had_time {
                        -(1.0 - shown).ln()
                    } else {
                        f64::NEG_INFINITY
                    }
                })
                .sum::<f64>()
        };
        let theirs = silence(
            self.tracks.sources_of(system, now_ns),
            entry.filter.estimate.position_m(),
        );
        let ratio = theirs + silence(own_sources, other.filter.estimate.position_m());
        let least = self.settings.life.confirm_reports;
        // Two false tracks near each other would bear witness to each other.
        let is_believed = self.is_shown(own) || self.is_shown(system);
        let is_ready = is_believed && entry.reports >= least && other.reports >= least;
        Some((system, if is_ready { ratio } else { f64::NEG_INFINITY }))
    }

    /// Returns whether a sensor track apart from its system track is of another target: another source of the system
    /// track follows a target there, or its own source follows a target at the place of the system track.
    #[cold]
    pub(crate) fn is_apart_from_two(&self, own: SensorSlot) -> bool {
        let entry = self.tracks.sensors.get(own);
        let now_ns = entry.time_ns;
        let sources = self.tracks.sources_of(entry.system, now_ns);
        let others = sources.without(SourceSet::of(entry.source));
        let mut are_two = false;
        self.admissible(own, |system, _| {
            are_two |= self.tracks.sources_of(system, now_ns).meets(others)
        });
        let target = self.state(entry.system, now_ns);
        let [x, y, _] = target.position_m();
        let reach_m = self.reach(&target, 0.0);
        self.tracks
            .systems
            .grid
            .near(x, y, reach_m, SEARCH_CELLS_MAX, |system| {
                are_two |= system != entry.system
                    && self.tracks.sources_of(system, now_ns).contains(entry.source)
                    && self.compare(&target, &self.state(system, now_ns), false, 0.0).is_some();
            });
        are_two
    }

    /// Calls `visit` with every system track some `reach_m` from `own` that moves alike, at the same height if both are
    /// known, and may be of the same target ([`Self::others`]), and with the distance in the plane, metres.
    fn aside(&self, own: SystemSlot, now_ns: i64, reach_m: f64, mut visit: impl FnMut(SystemSlot, f64)) {
        let state = self.state(own, now_ns);
        let gate = self.settings.association.join_gate();
        self.others(own, now_ns, (&state, reach_m), |system, theirs, heights| {
            if move_alike(&state, theirs) && !(heights && height_distance(&state, theirs) > gate) {
                visit(
                    system,
                    length([state.mean[0] - theirs.mean[0], state.mean[1] - theirs.mean[1]]),
                );
            }
        });
    }

    fn is_shown(&self, system: SystemSlot) -> bool {
        let life = self.tracks.systems.get(system).life;
        matches!(life, TrackState::Confirmed | TrackState::Coasted)
    }

    /// Whether the target of the system track `own`, with restarted sources only, may be shown already: as a nearby
    /// track that these sources followed before and follow no more. In its first reports, a sensor's track lags in
    /// turns by more than the stated accuracy.
    pub(crate) fn was_followed(&self, own: SystemSlot, now_ns: i64) -> bool {
        let known = &self.tracks.sources;
        let sources = self.tracks.sources_of(own, now_ns);
        let began_ns = self.tracks.systems.get(own).first_seen_ns;
        let has_restarted = |source: u16| known.has_restarted_before(source, began_ns);
        if !sources.iter().all(has_restarted) {
            return false;
        }
        let state = self.state(own, now_ns);
        let mut is_shown = false;
        self.others(own, now_ns, (&state, FOLLOWED_M), |system, _, _| {
            let life = self.tracks.systems.get(system).life;
            let mut members = self.tracks.member_entries(system);
            is_shown |= matches!(life, TrackState::Confirmed | TrackState::Coasted)
                && members.any(|(_, member)| {
                    sources.contains(member.source) && known.is_before_restart(member.source, member.time_ns)
                });
        });
        is_shown
    }

    /// Calls `visit` with every system track without a common source that agrees with `own`, and with d²; detection
    /// points on a target are spread by `spread_m2` per axis.
    fn alike(&self, own: SystemSlot, now_ns: i64, spread_m2: f64, mut visit: impl FnMut(SystemSlot, f64)) {
        let state = self.state(own, now_ns);
        let reach_m = self.reach(&state, spread_m2);
        self.others(own, now_ns, (&state, reach_m), |system, theirs, heights| {
            if let Some(d2) = self.compare(&state, theirs, heights, spread_m2) {
                visit(system, d2);
            }
        });
    }

    /// State of a system track at `now_ns`.
    fn state(&self, system: SystemSlot, now_ns: i64) -> Gaussian {
        let filter = &self.tracks.systems.get(system).filter;
        filter.at(now_ns, self.tracks.sources.motion(filter.velocity_mps()))
    }

    /// Calls `visit` with every system track within `reach_m` of the `state` of `own` that neither a common source, an
    /// order nor a name shows to be of another target. Further arguments: the state, and whether both have a height.
    fn others(
        &self,
        own: SystemSlot,
        now_ns: i64,
        (state, reach_m): (&Gaussian, f64),
        mut visit: impl FnMut(SystemSlot, &Gaussian, bool),
    ) {
        let entry = self.tracks.systems.get(own);
        let sources = self.tracks.sources_of(own, now_ns);
        let [x, y, _] = state.position_m();
        self.tracks
            .systems
            .grid
            .near(x, y, reach_m, SEARCH_CELLS_MAX, |system| {
                if system == own || self.tracks.sources_of(system, now_ns).meets(sources) {
                    return;
                }
                let other = self.tracks.systems.get(system);
                if entry.bond == Bond::Apart(other.number) {
                    return;
                }
                if self.settings.association.use_identity
                    && identity::contradict(&entry.identity, &other.identity, &self.settings.association.exponents)
                {
                    return;
                }
                let heights = entry.filter.has_height && other.filter.has_height;
                visit(system, &self.state(system, now_ns), heights);
            });
    }

    /// Calls `visit` with every system track near a report.
    pub(crate) fn near(&self, report: &SensorTrack, state: &Gaussian, visit: impl FnMut(SystemSlot)) {
        let reach = self.reach(state, self.tracks.sources.spread_m2(&self.settings.association, None));
        self.tracks.systems.grid.near(
            report.position_m[0],
            report.position_m[1],
            reach,
            SEARCH_CELLS_MAX,
            visit,
        );
    }

    /// Largest distance of a system track of the same target from `state`; detection points on a target are spread by
    /// `spread_m2` per axis.
    fn reach(&self, state: &Gaussian, spread_m2: f64) -> f64 {
        let settings = &self.settings.association;
        let [xx, xy, _, yy, ..] = state.position_covariance();
        let sigma = association::distance::largest_sigma2([xx, xy, yy]);
        let sigma = (sigma * sigma + spread_m2).sqrt();
        let speed = length([state.mean[3], state.mean[4]]);
        // The system track was placed at its latest report; half a cell covers the uncertainty of that place.
        let moved = speed * self.settings.longest_period_s();
        (settings.join_gate().sqrt() * sigma).max(settings.target_extent_m) + 0.5 * settings.cell_m + moved
    }

    /// d² in the plane between a sensor track and its system track from before the start, if that is still possible.
    pub(crate) fn resumption_distance(&self, own: SensorSlot, system: SystemSlot) -> Option<f64> {
        let report = &self.tracks.sensors.get(own).latest;
        let entry = self.tracks.systems.get(system);
        let mut expected = entry.filter.at(
            report.time_of_measurement_ns,
            self.tracks.sources.motion(entry.filter.velocity_mps()),
        );
        for axis in 0..2 {
            expected.covariance.upper[Covariance::index(axis, axis)] += self
                .tracks
                .sources
                .spread_m2(&self.settings.association, Some(report.source));
        }
        let d2 = statistical_distance(&gaussian_of(report), &expected, ComparedComponents::HorizontalPosition);
        (self.is_compatible(report, system) && d2 <= self.resumption_gate()).then_some(d2)
    }

    /// Gate for this d²: wider than for staying, because the last comparison is old. The gate rejects sensor tracks
    /// of a source that has restarted its numbering.
    pub(crate) fn resumption_gate(&self) -> f64 {
        RESUMPTION * self.settings.association.keep_gate
    }

    fn distance(&self, report: &SensorTrack, state: &Gaussian, system: SystemSlot) -> Option<f64> {
        if !self.is_compatible(report, system) {
            return None;
        }
        let filter = &self.tracks.systems.get(system).filter;
        let other = filter.at(
            report.time_of_measurement_ns,
            self.tracks.sources.motion(filter.velocity_mps()),
        );
        let heights = filter.has_height && report.has(sensor_track_bits::HEIGHT);
        self.compare(
            state,
            &other,
            heights,
            self.tracks
                .sources
                .spread_m2(&self.settings.association, Some(report.source)),
        )
    }

    /// d² between two states of one time, inside the gates.
    pub(crate) fn compare(&self, a: &Gaussian, b: &Gaussian, heights: bool, spread_m2: f64) -> Option<f64> {
        let settings = &self.settings.association;
        let mut wider = *a;
        for axis in 0..2 {
            wider.covariance.upper[Covariance::index(axis, axis)] += spread_m2;
            wider.covariance.upper[Covariance::index(axis + 3, axis + 3)] += VELOCITY_FLOOR_M2PS2;
        }
        let exponents = &settings.exponents;
        let scale = 1.0 / (1.0 - settings.error_correlation);
        let stated = scale * statistical_distance(&wider, b, ComparedComponents::HorizontalPosition);
        let position = exponents.position * stated;
        if position > settings.join_gate() {
            return None;
        }
        let both = scale * statistical_distance(&wider, b, ComparedComponents::HorizontalPositionAndVelocity);
        // Contribution of the velocity, given the position.
        let both = if exponents.weighs_motion() {
            position + exponents.velocity * (both - stated)
        } else {
            both
        };
        let height = if heights {
            exponents.height * height_distance(a, b)
        } else {
            0.0
        };
        // Written so that NaN is refused.
        let inside = height <= settings.join_gate() && both + height <= settings.scan_gate();
        inside.then_some(both + height)
    }

    /// Returns whether an order keeps `own`, unless [`NO_SYSTEM`], and another system track apart.
    fn are_kept_apart(&self, own: SystemSlot, system: SystemSlot) -> bool {
        let number = self.tracks.systems.get(system).number;
        own != NO_SYSTEM && self.tracks.systems.get(own).bond == Bond::Apart(number)
    }

    /// Whether the sensor track in `own` has to stay for `system` to come to it: between two system tracks with a
    /// single source each, only the sensor track of the younger moves. The older number stays, and the two do not swap
    /// places.
    fn must_wait_for(&self, own: SensorSlot, system: SystemSlot) -> bool {
        let entry = self.tracks.sensors.get(own);
        entry.system != NO_SYSTEM
            && self.tracks.systems.get(system).number > self.tracks.systems.get(entry.system).number
            && self.tracks.has_one_source(system, entry.latest.time_of_measurement_ns)
    }

    /// Whether both identity and height permit that the report belongs to the system track.
    pub(crate) fn is_compatible(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let entry = self.tracks.systems.get(system);
        let exponents = &self.settings.association.exponents;
        let forbidden = self.settings.association.use_identity
            && identity::contradict(&report.identity, &entry.identity, exponents);
        !forbidden && self.can_be_seen_together(report, system)
    }

    /// Returns whether a report under the number of a sensor track, after a missed scan, is of another target: the
    /// report fits neither the course of the sensor track nor the system track, but a third track.
    pub(crate) fn is_of_another(&self, own: SensorSlot, report: &SensorTrack) -> bool {
        let entry = self.tracks.sensors.get(own);
        let last = &entry.latest;
        let numbers = [last, report].map(|report| report.identity.unique_number());
        if entry.system == NO_SYSTEM || (numbers[0].is_some() && numbers[0] == numbers[1]) {
            return false;
        }
        let mut corrected = *report;
        for (place, shift) in corrected.position_m.iter_mut().zip(entry.correction().shift_m) {
            *place -= shift;
        }
        let seconds = (report.time_of_measurement_ns - last.time_of_measurement_ns) as f64 / NS_PER_S;
        let apart =
            |axis: usize| corrected.position_m[axis] - last.position_m[axis] - last.velocity_mps[axis] * seconds;
        let unforeseen_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
        let spread_m2 = self
            .tracks
            .sources
            .spread_m2(&self.settings.association, Some(report.source));
        let variance_m2 = |axis: usize| {
            let of_velocity = last.covariance.get(axis + 3, axis + 3) * seconds * seconds;
            last.covariance.get(axis, axis) + report.covariance.get(axis, axis) + of_velocity
        };
        let variance_m2 = variance_m2(0) + variance_m2(1) + spread_m2 + unforeseen_m * unforeseen_m;
        let gate = self.settings.association.keep_gate;
        // Written so that NaN is no evidence.
        let has_jumped = apart(0) * apart(0) + apart(1) * apart(1) > gate * variance_m2;
        has_jumped && self.fits_another(entry.system, &corrected, gate)
    }

    /// Returns whether a report fits another system track, and does not fit `own` even with this gate.
    #[cold]
    fn fits_another(&self, own: SystemSlot, report: &SensorTrack, gate: f64) -> bool {
        let state = gaussian_of(report);
        let filter = &self.tracks.systems.get(own).filter;
        let expected = filter.at(
            report.time_of_measurement_ns,
            self.tracks.sources.motion(filter.velocity_mps()),
        );
        if statistical_distance(&state, &expected, ComparedComponents::HorizontalPosition) <= gate {
            return false;
        }
        let mut fits = false;
        self.near(report, &state, |system| {
            fits |= system != own && self.distance(report, &state, system).is_some();
        });
        fits
    }

    /// Returns whether the addresses of two system tracks, or of their sensor tracks, show two targets: then no
    /// agreement of the states shows a single target.
    pub(crate) fn are_two_targets(&self, one: SystemSlot, other: SystemSlot) -> bool {
        let members = self.tracks.member_entries(one);
        let mut identities = members.map(|(_, member)| &member.latest.identity);
        self.excludes(other, &self.tracks.systems.get(one).identity)
            || identities.any(|identity| self.excludes(other, identity))
    }

    /// Returns whether the address of a system track, or of a sensor track of it, contradicts `identity`.
    pub(crate) fn excludes(&self, system: SystemSlot, identity: &Identity) -> bool {
        let is_other = |theirs: &Identity| identity.has_other_number(theirs);
        let mut members = self.tracks.member_entries(system);
        self.settings.association.uses_addresses()
            && (is_other(&self.tracks.systems.get(system).identity)
                || members.any(|(_, member)| is_other(&member.latest.identity)))
    }

    /// Heights must agree if known, and be within the coverage of every source concerned.
    pub(crate) fn can_be_seen_together(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let entry = self.tracks.systems.get(system);
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
                self.tracks
                    .contributing(system, report.time_of_measurement_ns)
                    .all(|member| z <= ceiling(self.tracks.sensors.get(member).source))
            })
    }
}

/// Whether two velocities may be of the same target, if a source rotates positions about its sensor.
fn move_alike(a: &Gaussian, b: &Gaussian) -> bool {
    const SIGMAS: f64 = 3.0;
    let variance = (3..5)
        .map(|axis| a.covariance.get(axis, axis) + b.covariance.get(axis, axis))
        .sum::<f64>();
    let apart_mps = length([a.mean[3] - b.mean[3], a.mean[4] - b.mean[4]]);
    apart_mps <= SIGMAS * (variance + VELOCITY_FLOOR_M2PS2).sqrt() + TURNED * length([a.mean[3], a.mean[4]])
}

/// d² of two heights.
fn height_distance(a: &Gaussian, b: &Gaussian) -> f64 {
    let variance = a.covariance.get(2, 2) + b.covariance.get(2, 2) + HEIGHT_FLOOR_M2;
    let apart_m = a.mean[2] - b.mean[2];
    apart_m * apart_m / variance
}
