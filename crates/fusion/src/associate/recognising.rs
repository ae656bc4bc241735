//! Surroundings of a report with an address: evidence for the confirmation by identity (module `recognition`).

use estimation::{ComparedComponents, statistical_distance};
use messages::{NS_PER_S, SensorTrack, TrackState, UniqueNumber, sensor_track_bits};
use source_models::gaussian_of;

use crate::associate::association_step::{SEARCH_CELLS_MAX, Search};
use crate::associate::recognition::{Beside, can_come_to};
use crate::engine::Engine;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::SystemSlot;

/// Most differing bits of two addresses for one to be a misreading of the other. With four, the same misreading comes
/// twice in ten thousand.
const ALIKE_BITS: u32 = 3;
/// Greatest assumed speed of a confirmed target, searched for at its last place, m/s.
const SPEED_MPS: f64 = 350.0;

impl Engine {
    /// Compares the latest report of a sensor track with the earlier state of its system track, which was never shown.
    #[cold]
    pub(crate) fn recognise(&mut self, sensor: SensorSlot, system: SystemSlot) {
        let entry = self.tracks.systems.get(system);
        if !self.settings.association.uses_addresses() {
            return;
        }
        let report = &self.tracks.sensors.get(sensor).latest;
        let Some(address) = report.identity.unique_number() else {
            return;
        };
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
        };
        let agrees = entry.reports > 0 && search.is_within_reach(report, system);
        let beside = search.beside(report, system, address);
        self.tracks.systems.get_mut(system).recognition.note(agrees, beside);
    }
}

impl Search<'_> {
    /// Whether the target of a system track can have reached the place of a later report.
    fn is_within_reach(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let filter = &self.tracks.systems.get(system).filter;
        let seconds = (report.time_of_measurement_ns - filter.time_ns) as f64 / NS_PER_S;
        seconds > 0.0 && can_come_to(&filter.estimate, &gaussian_of(report), seconds)
    }

    /// The confirmed track of an address other than `address` with a gate that contains a report of `own`; a track
    /// that may be meant comes first.
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
            let expected = other
                .filter
                .at(now_ns, self.tracks.sources.motion(other.filter.velocity_mps()));
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

    /// Whether the source of a report of `own` has reported the target `other` in the scan of this report, or in the
    /// previous scan; `None` if the source does not follow `other`.
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
