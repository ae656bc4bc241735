//! Confirmation by identity: a second report with the same address.
//!
//! A position without a name may be noise, and noise has to repeat itself several times before it is believed. Noise
//! has no address: a second report with one, where the target of the first can have come to, is of the same target.
//! That holds however long the time between the two, so that a target that is reported once a minute is shown as soon
//! as it can be.
//!
//! The exception is an address with wrong bits. Each transponder is misread now and then, the same bit comes again
//! after some hundred reports, and both lie on the path of one aircraft. A report inside the gate of a confirmed track
//! with another address therefore recognises nothing. Where the two addresses differ in few bits ([`ALIKE_BITS`]), the
//! report is no evidence of a further target at all, unless the source has reported the confirmed target besides, in the
//! same scan: a misread report takes the place of the right one. [`TOGETHER`] such scans distinguish the two.
//!
//! Limit: two targets with addresses alike, one of them always in the gate of the other, that no source reports in one
//! scan, are shown as one.

use estimation::{ComparedComponents, Gaussian, statistical_distance};
use messages::{NS_PER_S, SensorTrack, TrackState, UniqueNumber, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::association_step::{SEARCH_CELLS_MAX, Search};
use crate::engine::Engine;
use crate::measurement::gaussian_of;
use crate::sensor_tracks::SensorSlot;
use crate::system_tracks::SystemSlot;

/// Bits in which addresses of which one is a misreading of the other differ, at most: with four, the same misreading
/// comes twice in ten thousand.
const ALIKE_BITS: u32 = 3;
/// Scans with both targets that show that they are two. Where reports follow no rhythm, the right one lies near the
/// misread one by chance in two of five cases.
const TOGETHER: u8 = 3;
/// Standard deviations by which a position may lie off.
const POSITION_SIGMAS: f64 = 5.0;
const VELOCITY_SIGMAS: f64 = 3.0;
/// Greatest acceleration of a target between two reports, m/s².
const MANOEUVRE_MPS2: f64 = 10.0;
/// Greatest speed of a confirmed target that is looked for where it was last placed, m/s.
const SPEED_MPS: f64 = 350.0;

/// What the reports of a system track that has an address, and was never shown, have shown of that.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Recognition {
    /// Whether a report agreed with the one before, away from any confirmed track of another address.
    is_sure: bool,
    /// Whether the latest report may be a misreading of another address.
    is_doubted: bool,
    /// Scans with this target and the one that it may be.
    together: u8,
}

/// What lies where a report with an address is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Beside {
    /// No confirmed track of another address.
    Nothing,
    /// One; its address may be the right one of this report or not, and the source may have reported it, too.
    Other { is_alike: bool, is_together: bool },
}

impl Recognition {
    /// Whether the identity shows that there is a target.
    pub(crate) fn is_sure(&self) -> bool {
        self.is_sure
    }

    /// Whether the address may be a misreading of another one.
    pub(crate) fn is_doubted(&self) -> bool {
        self.is_doubted
    }

    fn note(&mut self, agrees: bool, beside: Beside) {
        let (is_alike, is_together) = match beside {
            Beside::Nothing => (false, false),
            Beside::Other { is_alike, is_together } => (is_alike, is_together),
        };
        self.is_sure |= agrees && beside == Beside::Nothing;
        self.together = self.together.saturating_add(u8::from(is_together));
        self.is_doubted = !self.is_sure && is_alike && self.together < TOGETHER;
    }
}

impl Engine {
    /// Compares the latest report of a sensor track with what its system track, which was never shown, was before.
    #[cold]
    pub(crate) fn recognise(&mut self, sensor: SensorSlot, system: SystemSlot) {
        let entry = self.tracks.systems.get(system);
        if !self.settings.association.use_identity || self.settings.association.exponents.address == 0.0 {
            return;
        }
        let report = &self.tracks.sensors.get(sensor).latest;
        let Some(address) = report.identity.unique_number() else {
            return;
        };
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
            sources: &self.sources,
        };
        let agrees = entry.reports > 0 && search.is_within_reach(report, system);
        let beside = search.beside(report, system, address);
        self.tracks.systems.get_mut(system).recognition.note(agrees, beside);
    }
}

impl Search<'_> {
    /// Whether the target of a system track can have come to where a later report is.
    fn is_within_reach(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let filter = &self.tracks.systems.get(system).filter;
        let seconds = (report.time_of_measurement_ns - filter.time_ns) as f64 / NS_PER_S;
        seconds > 0.0 && can_come_to(&filter.estimate, &gaussian_of(report), seconds)
    }

    /// The confirmed track of another address than `address` in whose gate a report of `own` is: one that may be meant
    /// first.
    fn beside(&self, report: &SensorTrack, own: SystemSlot, address: UniqueNumber) -> Beside {
        let (state, now_ns) = (gaussian_of(report), report.time_of_measurement_ns);
        let mut beside = Beside::Nothing;
        let reach_m = 0.5 * self.settings.association.cell_m + 2.0 * SPEED_MPS * self.settings.longest_period_s();
        let [x, y, _] = report.position_m;
        let systems = &self.tracks.systems;
        systems.grid.near(x, y, reach_m, SEARCH_CELLS_MAX, |system| {
            let other = systems.get(system);
            let is_shown = matches!(other.life, TrackState::Confirmed | TrackState::Coasted);
            let theirs = other.identity.unique_number().filter(|theirs| *theirs != address);
            let Some(theirs) = theirs.filter(|_| system != own && is_shown) else {
                return;
            };
            let heights = other.filter.has_height && report.has(sensor_track_bits::HEIGHT);
            let apart_m = (other.filter.estimate.mean[2] - report.position_m[2]).abs();
            if heights && apart_m > self.settings.association.height_gate_m {
                return;
            }
            let expected = other.filter.at(now_ns, self.sources.motion_of(&other.filter));
            let d2 = statistical_distance(&state, &expected, ComparedComponents::HorizontalPosition);
            if d2 > self.settings.association.keep_gate {
                return;
            }
            let Some(is_together) = self.are_together(report, own, system) else {
                return;
            };
            let is_alike = (theirs.to_bits() ^ address.to_bits()).count_ones() <= ALIKE_BITS;
            if beside == Beside::Nothing || is_alike {
                beside = Beside::Other { is_alike, is_together };
            }
        });
        beside
    }

    /// Whether the source of a report of `own` has reported the target `other` in the scan of this report, or of the
    /// one before; `None` if the source does not follow `other`.
    fn are_together(&self, report: &SensorTrack, own: SystemSlot, other: SystemSlot) -> Option<bool> {
        let last_ns = self.tracks.systems.get(own).last_report_ns;
        let usual_ns = self.settings.sources[usize::from(report.source)].period_ns;
        let half_ns = self.tracks.systems.get(other).rhythm.interval_ns().max(usual_ns) / 2;
        let scans_ns = [report.time_of_measurement_ns, last_ns];
        let members = self.tracks.member_entries(other).map(|(_, member)| member);
        members
            .filter(|member| member.source == report.source)
            .fold(None, |any, member| {
                let is_together = scans_ns
                    .iter()
                    .any(|scan_ns| (member.time_ns - scan_ns).abs() < half_ns);
                Some(any.unwrap_or(false) || is_together)
            })
    }
}

/// Whether the target of one report can have come to where a later one is.
pub(crate) fn is_reachable(before: &SensorTrack, report: &SensorTrack) -> bool {
    let seconds = (report.time_of_measurement_ns - before.time_of_measurement_ns) as f64 / NS_PER_S;
    seconds > 0.0 && can_come_to(&gaussian_of(before), &gaussian_of(report), seconds)
}

/// Whether a target in one state can be in another one `seconds` later: by straight flight, or by manoeuvres in which
/// it is nowhere faster than it is in both.
fn can_come_to(before: &Gaussian, after: &Gaussian, seconds: f64) -> bool {
    let sigma = |axis: usize| {
        let variance = |state: &Gaussian| state.covariance.get(axis, axis) + state.covariance.get(axis + 1, axis + 1);
        (variance(before) + variance(after)).sqrt()
    };
    let apart = |axis: usize| after.mean[axis] - before.mean[axis] - seconds * before.mean[axis + 3];
    let speed = |state: &Gaussian| state.mean[3].hypot(state.mean[4]);
    let turned_mps = (0.5 * MANOEUVRE_MPS2 * seconds).min(2.0 * speed(before).max(speed(after)));
    let reach_m = POSITION_SIGMAS * sigma(0) + (VELOCITY_SIGMAS * sigma(3) + turned_mps) * seconds;
    apart(0).hypot(apart(1)) <= reach_m
}
