//! Mean innovations of sensor tracks. A mean apart from the others has three possible causes: another detection point
//! of the source, an error of the source on this target, or a wrong association.
//!
//! Each sensor track keeps the mean and the variance of the latest innovations. This module compares the means of the
//! sensor tracks of a target. The results on a source are passed on to the models of the sources.

use messages::{AXES, TrackState};
use source_models::{
    Fact, FilterInnovation, HeightApart, Innovation, InnovationFact, MEAN_GAIN, MEAN_VARIANCE, MeanApart, Measurement,
    from_body,
};

use crate::associate::association_step::Search;
use crate::engine::Engine;
use crate::tables::sensor_tracks::{SensorEntry, SensorSlot};

/// Innovations of a sensor track before the mean is used.
pub(crate) const MEAN_REPORTS_MIN: u32 = 4;
/// Number of innovations of a sensor track between two uses of the mean for the spread of detection points: in between
/// the mean hardly changes.
const SPREAD_EVERY: u32 = 4;

impl SensorEntry {
    /// Adds an innovation to the mean. Returns the innovation relative to the previous mean, metres; `None` if the
    /// previous mean was unknown or the report was repaired.
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

impl SensorEntry {
    /// Adds the difference of a measured height from the filter, with the variance of the measurement, to the mean.
    fn add_height(&mut self, off_m: f64, variance_m2: f64) {
        let gain = if self.height_variance_m2 == 0.0 { 1.0 } else { MEAN_GAIN };
        for (mean, value) in [
            (&mut self.height_mean_m, off_m),
            (&mut self.height_variance_m2, variance_m2),
        ] {
            *mean += (gain * (value - f64::from(*mean))) as f32;
        }
    }
}

impl Engine {
    /// Adds the innovation of a measurement, with the normalised square `nis`, to the sensor track's mean. The models
    /// of the sources learn from the innovation if the target [teaches](source_models::Sources::teaches), unless a step
    /// of a source's errors has misled filters (`is_misled`).
    /// `moves_mps` is the target's velocity if the innovation shows the motion of targets.
    pub(crate) fn learn_of_innovation(
        &mut self,
        sensor: SensorSlot,
        (innovation, nis, measurement): (&FilterInnovation, f64, &Measurement),
        moves_mps: Option<[f64; 3]>,
        is_misled: bool,
    ) {
        let filter = &self.tracks.systems.get(self.tracks.sensors.get(sensor).system).filter;
        let (height_m, filter_ns) = (filter.estimate.mean[2], filter.time_ns);
        let entry = self.tracks.sensors.get_mut(sensor);
        if measurement.axes == AXES && filter_ns == entry.time_ns {
            entry.add_height(measurement.position_m[2] - height_m, measurement.covariance_m2[5]);
        }
        let about_mean_m = entry.add_innovation(innovation);
        if about_mean_m.is_some() {
            self.look_for_led_off(sensor);
        }
        let entry = self.tracks.sensors.get(sensor);
        let target = self.tracks.systems.get(entry.system);
        if !self.tracks.sources.teaches(entry.source, target.number) {
            return;
        }
        let is_led_or_apart = entry.is_led_off || entry.point.stands_apart();
        let registered = |source: u16| self.settings.sources[usize::from(source)].is_registered;
        let is_compared = registered(entry.source) && target.life == TrackState::Confirmed;
        let looks = about_mean_m.is_some()
            && is_compared
            && !is_led_or_apart
            && (!self.tracks.sources.knows_spread_well(entry.source) || entry.residuals.is_multiple_of(SPREAD_EVERY));
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
            shows_errors: is_compared && !entry.point.stands_apart(),
            shows_accuracy: !is_misled && !entry.is_led_off,
            steadiness: target.filter.steadiness(),
            height: looks.then(|| search.height_apart(sensor)).flatten(),
            apart: apart.map(|(offset_m, noise_m2)| MeanApart {
                offset_m,
                noise_m2,
                measured_m2: measurement.variance_m2(),
                size_m: entry.size_m(&self.settings.target_size),
            }),
        };
        self.tracks
            .sources
            .learn(&self.settings, Fact::Innovation(InnovationFact::Used(shown)));
    }
}

impl Search<'_> {
    /// Returns the mean innovation of a sensor track, east and north, metres, without the suspected errors of the
    /// source on all targets, and relative to a detection point that stands apart.
    pub(crate) fn mean_about_point(&self, entry: &SensorEntry) -> [f64; 2] {
        let shift_m = self
            .tracks
            .sources
            .suspected_shift_m(entry.source, entry.latest.velocity_mps);
        let point_m = match entry.point.stands_apart() {
            true => from_body(entry.point.offset_m, self.tracks.systems.get(entry.system).course),
            false => [0.0; 2],
        };
        std::array::from_fn(|axis| entry.residual_mean_m[axis] - shift_m[axis] - point_m[axis])
    }

    /// Returns the difference of a sensor track's mean innovation from the mean of the other sensor tracks, east and
    /// north, metres, and the variance per axis due to noise. `None` while data are too few. A turn moves all means to
    /// the same side, a wrong association does not. Only `compared` sources count among the others.
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

    /// Returns the difference of a sensor track's mean height from those of the other sensor tracks; `None` while data
    /// are too few.
    fn height_apart(&self, sensor: SensorSlot) -> Option<HeightApart> {
        let entry = self.tracks.sensors.get(sensor);
        let known = |entry: &SensorEntry| entry.residuals >= MEAN_REPORTS_MIN && entry.height_variance_m2 > 0.0;
        let (mut sum_m, mut variance_m2, mut others) = (0.0, 0.0, 0.0);
        for (member, other) in self.tracks.contributing_entries(entry.system, entry.time_ns) {
            if member != sensor && known(other) {
                sum_m += f64::from(other.height_mean_m);
                variance_m2 += f64::from(other.height_variance_m2);
                others += 1.0;
            }
        }
        (known(entry) && others > 0.0).then(|| HeightApart {
            offset_m: f64::from(entry.height_mean_m) - sum_m / others,
            noise_m2: MEAN_VARIANCE * (f64::from(entry.height_variance_m2) + variance_m2 / (others * others)),
            others,
        })
    }

    /// Returns d² of a sensor track's offset from the others, given the noise and the spread of detection points;
    /// `None` while data are too few.
    pub(crate) fn offset_from_others(&self, sensor: SensorSlot) -> Option<f64> {
        // Of two different means, the farther is at least half the difference away from the filter.
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
