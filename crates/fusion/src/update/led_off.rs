//! Sources that lead single targets off, by false reports on a target or by an error of propagation.
//!
//! Registration estimates the errors of a source on all targets, not the errors on a single target. Each sensor track
//! has the mean of the latest innovations. At least two other sources may agree on the target while the mean of a
//! source lies apart. The reports of this source on the target are then not used until the means agree again. A filter
//! led along by the source begins anew with the next report of another source.

use source_models::{MEAN_VARIANCE, MeanInnovation, odd_one};

use crate::associate::association_step::Search;
use crate::engine::Engine;
use crate::tables::sensor_tracks::SensorSlot;
use crate::update::compared_means::ComparedMeans;
use crate::update::mean_errors::MEAN_REPORTS_MIN;

/// Squared statistical length of a mean innovation above which means are compared.
const SUSPICIOUS: f64 = 9.2;
/// Squared statistical lengths: a source leads a target off above the first, and no longer below the second.
const LEADS_OFF: f64 = 25.0;
const AGREES: f64 = 9.2;

impl Engine {
    /// Checks whether a source leads the target of a sensor track off, if the track's mean innovation is suspicious.
    #[inline]
    pub(crate) fn look_for_led_off(&mut self, sensor: SensorSlot) {
        let entry = self.tracks.sensors.get(sensor);
        let [east, north] = entry.residual_mean_m;
        let is_suspicious = east * east + north * north > SUSPICIOUS * MEAN_VARIANCE * entry.residual_variance_m2;
        if is_suspicious || entry.is_led_off {
            self.compare_means(sensor);
        }
    }

    #[cold]
    fn compare_means(&mut self, sensor: SensorSlot) {
        let tracks = &mut self.tracks;
        let entry = tracks.sensors.get(sensor);
        let (system, now_ns) = (entry.system, entry.time_ns);
        if entry.is_led_off && !tracks.sources.is_settled(entry.source) {
            // The errors of the source on all targets are unknown again, and hence the errors on this target.
            tracks.sensors.get_mut(sensor).is_led_off = false;
            return;
        }
        let ComparedMeans { mut means, mut members } = std::mem::take(&mut self.compared);
        means.clear();
        members.clear();
        let extent_m = self.settings.association.extent_sigma_m;
        let points_m2 = tracks.sources.possible_points_m2(extent_m * extent_m);
        let tracks = &self.tracks;
        let search = Search {
            settings: &self.settings,
            tracks,
        };
        for (member, other) in tracks.contributing_entries(system, now_ns) {
            let is_known = other.residuals >= MEAN_REPORTS_MIN && tracks.sources.is_settled(other.source);
            if !is_known || members.len() == members.capacity() {
                continue;
            }
            let variance_m2 = MEAN_VARIANCE * other.residual_variance_m2 + points_m2;
            means.push(MeanInnovation {
                source: members.len(),
                mean_m: search.mean_about_point(other),
                covariance_m2: [variance_m2, 0.0, variance_m2],
            });
            members.push(member);
        }
        let tracks = &mut self.tracks;
        let (odd, mut has_led_off) = (odd_one(&mut means), false);
        for (place, member) in members.iter().enumerate() {
            let length = odd
                .and_then(|(odd, length)| (odd == place).then_some(length))
                .unwrap_or_default();
            let entry = tracks.sensors.get_mut(*member);
            let limit = if entry.is_led_off { AGREES } else { LEADS_OFF };
            entry.is_led_off = length > limit;
            has_led_off |= entry.is_led_off;
        }
        tracks.systems.get_mut(system).has_led_off = has_led_off;
        self.compared = ComparedMeans { means, members };
    }
}
