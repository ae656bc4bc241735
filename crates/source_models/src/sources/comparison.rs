//! Comparison of reports of two sources on one target, for estimating systematic errors.

use estimation::AxisNoise;
use messages::{NS_PER_S, sensor_track_bits};

use crate::facts::{ComparedStates, StatedState};
use crate::registration::TargetView;
use crate::settings::{Settings, SourceSettings};
use crate::sources::{Sources, place_of};

impl Sources {
    /// Learns the systematic errors of two sources from reports of both on one target.
    pub(crate) fn compare(&mut self, settings: &Settings, pair: &ComparedStates<'_>) {
        let now_ns = pair.own.report.time_of_measurement_ns;
        let view = |state: &StatedState<'_>| self.view(&settings.sources, state, now_ns);
        let (mut own, other) = (view(&pair.own), view(&pair.other));
        if self.registration.is_young(own.source)
            && let Some(measurement) = pair.measurement
        {
            own.take_measurement(measurement, pair.own.correction);
        } else if self.registration.is_young(other.source) && !self.registration.is_young(own.source) {
            return;
        }
        let extent_m = settings.association.extent_sigma_m;
        let points_m2 = self.possible_points_m2(extent_m * extent_m);
        let reports = f64::from(pair.reports) / self.models.len() as f64;
        self.registration.learn(&own, &other, points_m2, (reports, pair.age_s));
    }

    /// A sensor track as given by its source, at `time_ns`.
    fn view(&self, sources: &[SourceSettings], stated: &StatedState<'_>, time_ns: i64) -> TargetView {
        let report = stated.report;
        let seconds = (time_ns - report.time_of_measurement_ns) as f64 / NS_PER_S;
        let mut state = stated.as_stated();
        if seconds != 0.0 {
            let motion = self.manoeuvres.motion(report.velocity_mps);
            let noise = motion.turns.density_m2ps3;
            state.advance(seconds, noise.map(|density| AxisNoise::white(density, seconds)));
        }
        TargetView {
            source: report.source,
            position_m: state.position_m(),
            covariance_m2: state.position_covariance(),
            velocity_mps: state.velocity_mps(),
            has_velocity: report.has(sensor_track_bits::VELOCITY),
            has_height: report.has(sensor_track_bits::HEIGHT),
            place_m: place_of(&sources[usize::from(report.source)]),
        }
    }
}
