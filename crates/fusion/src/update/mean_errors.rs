//! What is left of a sensor track's innovations on the average: its source sees another point of the target than the
//! others do, errs on this target, or the track belongs elsewhere.
//!
//! Each sensor track keeps the mean of its latest innovations and their variance. Here these means are compared
//! with those of the other sensor tracks of the target. What the comparison shows of a source is passed on to the
//! models of the sources.

use messages::TrackState;
use source_models::{
    Fact, FilterInnovation, Innovation, InnovationFact, MEAN_GAIN, MEAN_VARIANCE, MeanApart, Measurement, from_body,
};

use crate::associate::association_step::Search;
use crate::engine::Engine;
use crate::tables::sensor_tracks::{SensorEntry, SensorSlot};

/// Innovations of one sensor track before their mean is used.
pub(crate) const MEAN_REPORTS_MIN: u32 = 4;
/// Every how many innovations of a sensor track its mean teaches where detection points lie: in between it hardly
/// changes.
const SPREAD_EVERY: u32 = 4;

impl SensorEntry {
    /// Adds an innovation to the mean. Returns the innovation about the mean before, metres; `None` while that was not
    /// known, or if the report was repaired.
    fn add_innovation(&mut self, innovation: &FilterInnovation) -> Option<[f64; 2]> {
        let [xx, _, yy] = innovation.covariance_m2;
        let before_m = self.residual_mean_m;
        let is_known = self.residuals >= MEAN_REPORTS_MIN && !self.repaired;
        self.residuals = self.residuals.saturating_add(1);
        let gain = (1.0 / f64::from(self.residuals)).max(MEAN_GAIN);
        for (mean, residual) in self.residual_mean_m.iter_mut().zip(innovation.residual_m) {
            *mean += gain * (residual - *mean);
        }
        self.residual_variance_m2 += gain * (0.5 * (xx + yy) - self.residual_variance_m2);
        is_known.then(|| std::array::from_fn(|axis| innovation.residual_m[axis] - before_m[axis]))
    }
}

impl Engine {
    /// Adds the innovation of a measurement, with its normalised square `nis`, to its sensor track's mean, and lets the
    /// models of the sources learn from it, unless a step of a source's errors has misled filters (`is_misled`).
    /// `moves_mps` is the target's velocity where the innovation shows how targets move.
    pub(crate) fn learn_of_innovation(
        &mut self,
        sensor: SensorSlot,
        (innovation, nis, measurement): (&FilterInnovation, f64, &Measurement),
        moves_mps: Option<[f64; 3]>,
        is_misled: bool,
    ) {
        let about_mean_m = self.tracks.sensors.get_mut(sensor).add_innovation(innovation);
        if about_mean_m.is_some() {
            self.look_for_led_off(sensor);
        }
        let entry = self.tracks.sensors.get(sensor);
        let target = self.tracks.systems.get(entry.system);
        let is_led_or_leapt = entry.is_led_off || entry.point.has_leapt;
        let registered = |source: u16| self.settings.sources[usize::from(source)].is_registered;
        let is_compared = registered(entry.source) && target.life == TrackState::Confirmed;
        let looks = about_mean_m.is_some()
            && is_compared
            && !is_led_or_leapt
            && (self.tracks.sources.knows_spread_badly(entry.source) || entry.residuals.is_multiple_of(SPREAD_EVERY));
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
        };
        let apart = looks.then(|| search.offset(sensor, registered)).flatten();
        let shown = Innovation {
            source: entry.source,
            report: &entry.latest,
            target: entry.system,
            innovation,
            nis,
            moves_mps,
            about_mean_m,
            shows_errors: is_compared && !entry.point.has_leapt,
            shows_accuracy: !is_misled && !entry.is_led_off,
            steadiness: target.filter.steadiness(),
            apart: apart.map(|(offset_m, noise_m2)| MeanApart {
                offset_m,
                noise_m2,
                measured_m2: measurement.variance_m2(),
                size_m: self.settings.target_size.of(&entry.latest.target_type),
            }),
        };
        self.tracks
            .sources
            .learn(&self.settings, Fact::Innovation(InnovationFact::Used(shown)));
    }
}

impl Search<'_> {
    /// The mean innovation of a sensor track, east and north, metres, without what its source is suspected to err on
    /// all targets, and about its detection point if that has leapt.
    pub(crate) fn mean_about_point(&self, entry: &SensorEntry) -> [f64; 2] {
        let shift_m = self
            .tracks
            .sources
            .suspected_shift_m(entry.source, entry.latest.velocity_mps);
        let point_m = match entry.point.has_leapt {
            true => from_body(entry.point.offset_m, self.tracks.systems.get(entry.system).course),
            false => [0.0; 2],
        };
        std::array::from_fn(|axis| entry.residual_mean_m[axis] - shift_m[axis] - point_m[axis])
    }

    /// The difference of a sensor track's mean innovation from that of the others of its system track, east and north,
    /// metres, and the variance per axis that noise explains; `None` while too little is known. A turn moves all of
    /// them to the same side, a wrong association does not. Only sources that are `compared` count among the others.
    fn offset(&self, sensor: SensorSlot, compared: impl Fn(u16) -> bool) -> Option<([f64; 2], f64)> {
        let entry = self.tracks.sensors.get(sensor);
        let (system, now_ns) = (entry.system, entry.time_ns);
        let (mut sum, mut count, mut variance) = ([0.0; 2], 0.0, 0.0);
        for (member, other) in self.tracks.contributing_entries(system, now_ns) {
            if member != sensor && compared(other.source) && other.residuals >= MEAN_REPORTS_MIN {
                let mean_m = self.mean_about_point(other);
                for axis in 0..2 {
                    sum[axis] += mean_m[axis];
                }
                variance += other.residual_variance_m2;
                count += 1.0;
            }
        }
        if count == 0.0 || entry.residuals < MEAN_REPORTS_MIN {
            return None;
        }
        let mean_m = self.mean_about_point(entry);
        let offset = std::array::from_fn(|axis| mean_m[axis] - sum[axis] / count);
        let variance_m2 = MEAN_VARIANCE * (entry.residual_variance_m2 + variance / (count * count));
        Some((offset, variance_m2))
    }

    /// d² of a sensor track's offset from the others, in view of noise and of how far detection points lie apart;
    /// `None` while too little is known.
    pub(crate) fn offset_from_others(&self, sensor: SensorSlot) -> Option<f64> {
        // Of two that differ, one is at least half as far from the filter as they are from each other.
        let entry = self.tracks.sensors.get(sensor);
        let [east, north] = entry.residual_mean_m;
        let settings = &self.settings.association;
        if 4.0 * (east * east + north * north) < settings.keep_gate * MEAN_VARIANCE * entry.residual_variance_m2 {
            return Some(0.0);
        }
        let (offset, noise_m2) = self.offset(sensor, |_| true)?;
        let spread_m2 = self.tracks.sources.spread_m2(settings, None);
        Some((offset[0] * offset[0] + offset[1] * offset[1]) / (noise_m2 + 2.0 * spread_m2))
    }
}
