//! Content of a report: the recovered measurement, with the learned tracker of the source.

use estimation::Gaussian;
use messages::{AXES, SensorTrack, sensor_track_bits};

use crate::corrections::Corrected;
use crate::facts::EarlierReport;
use crate::measurement::{
    Content, CovarianceBasis, Measurement, UnfilteredContent, as_reported, as_stated, gaussian_of,
    recovered_measurement, shows_filter, whole_report,
};
use crate::sources::Sources;
use crate::tracker_gain::{self, Change, GainEvidence};

/// Reports after which the gains of a tracker change no more.
const OLD_REPORTS: u32 = 32;

impl Sources {
    /// Writes the content of a report into an empty `Content`. The report follows `earlier`, the latest report of the
    /// sensor track, after that many seconds. A track without an earlier report `goes_on` if the track had reports
    /// before a restart. Learns the filter of the source, unless the report's covariance was repaired. `place_m` is the
    /// place of the sensor in the plane, if known, metres.
    #[inline]
    pub fn read_content(
        &mut self,
        report: &SensorTrack,
        (earlier, goes_on): (Option<(&EarlierReport<'_>, f64)>, bool),
        (repaired, place_m): (bool, Option<[f64; 2]>),
        content: &mut Content,
    ) {
        let model = &mut self.models[usize::from(report.source)];
        let known = earlier.filter(|(_, seconds)| *seconds > 0.0);
        if let Some((earlier, seconds)) = known {
            let (looks, knows) = (!repaired && model.looks_at_noise(), model.process_noise().is_some());
            if looks || knows {
                let has_height = report.has(sensor_track_bits::HEIGHT);
                let (before, after) = (earlier.stated.as_stated(), gaussian_of(report));
                if looks {
                    model.learn_noise(&before.covariance, &after.covariance, seconds, has_height);
                }
                if let Some(noise) = model.process_noise() {
                    let predicted = noise.predicted(&before, seconds);
                    content.measurement = recovered_measurement(&predicted, &after, has_height);
                    return;
                }
            }
            if !repaired && shows_filter(&report.covariance) {
                let (before, after) = (earlier.stated.as_stated(), gaussian_of(report));
                let has_height =
                    report.has(sensor_track_bits::HEIGHT) && earlier.stated.report.has(sensor_track_bits::HEIGHT);
                let corrected = Corrected::of((&before, seconds), (&after, has_height), place_m);
                model.corrections.learn(&corrected, earlier.reports);
                if model.corrections.is_used() {
                    content.measurement = model.corrections.measurement(&corrected);
                    return;
                }
            }
        }
        content.measurement = Some(as_reported(report));
        let is_hopeless = model.gain().is_hopeless();
        if is_hopeless && !tracker_gain::teaches(report.track_number, report.time_of_measurement_ns) {
            return;
        }
        if !repaired && !shows_filter(&report.covariance) {
            self.read_unfiltered(report, (known, goes_on), content);
        }
    }

    /// Content of a report with a covariance without indication of a filter.
    #[inline(never)]
    fn read_unfiltered(
        &mut self,
        report: &SensorTrack,
        (earlier, goes_on): (Option<(&EarlierReport<'_>, f64)>, bool),
        content: &mut Content,
    ) {
        let mut evidence = earlier.map_or(GainEvidence::NONE, |(before, _)| *before.evidence);
        if goes_on {
            evidence.grow_to(OLD_REPORTS);
        }
        if let Some((before, _)) = earlier
            && self.models[usize::from(report.source)].gain().is_hopeless()
        {
            evidence.grow_to(before.reports);
        }
        let measurement = &mut content.measurement;
        let unfiltered = content.unfiltered.insert(UnfilteredContent::stated(evidence));
        match earlier {
            Some(earlier) => self.undo_tracker(report, earlier, (measurement, unfiltered)),
            None => {
                unfiltered.covariance = self.models[usize::from(report.source)].first_covariance(&report.covariance);
                if unfiltered.covariance.is_some() {
                    unfiltered.basis = CovarianceBasis::Gain;
                }
            }
        }
        self.doubt(report, (measurement, unfiltered));
    }

    /// Assumes the covariance of a report to be as wrong as the covariances of known sources, while the report's own
    /// source is unknown.
    fn doubt(
        &self,
        report: &SensorTrack,
        (measurement, unfiltered): (&mut Option<Measurement>, &mut UnfilteredContent),
    ) {
        if self.usual_claim <= 1.0
            || unfiltered.covariance.is_some()
            || !self.models[usize::from(report.source)].is_open()
        {
            return;
        }
        let mut covariance = report.covariance;
        covariance.upper.iter_mut().for_each(|value| *value *= self.usual_claim);
        unfiltered.covariance = Some(covariance);
        unfiltered.basis = CovarianceBasis::Doubted;
        if let Some(measurement) = measurement {
            let values = measurement.covariance_m2.iter_mut();
            values.for_each(|value| *value *= self.usual_claim);
        }
    }

    /// Content of a report with a covariance without indication of a filter, if its source's tracker can be undone.
    fn undo_tracker(
        &mut self,
        report: &SensorTrack,
        (earlier, seconds): (&EarlierReport<'_>, f64),
        (measurement, unfiltered): (&mut Option<Measurement>, &mut UnfilteredContent),
    ) {
        if report.has_assumed_velocity() || earlier.stated.report.has_assumed_velocity() {
            return;
        }
        let before_m = earlier.stated.stated_m();
        let before_mps = earlier.stated.report.velocity_mps;
        let change = Change {
            position_m: std::array::from_fn(|axis| {
                report.position_m[axis] - before_m[axis] - before_mps[axis] * seconds
            }),
            velocity_mps: std::array::from_fn(|axis| report.velocity_mps[axis] - before_mps[axis]),
            seconds,
            has_height: report.has(sensor_track_bits::HEIGHT) && earlier.stated.report.has(sensor_track_bits::HEIGHT),
        };
        let model = &mut self.models[usize::from(report.source)];
        let Some(undone) = model.undo(&mut unfiltered.evidence, &change, &report.covariance) else {
            return;
        };
        unfiltered.covariance = Some(undone.covariance);
        unfiltered.basis = CovarianceBasis::Gain;
        *measurement = undone.measurement.map(|(innovation_m, covariance_m2)| Measurement {
            position_m: std::array::from_fn(|axis| {
                report.position_m[axis] - change.position_m[axis] + innovation_m[axis]
            }),
            covariance_m2,
            ..whole_report(report)
        });
    }

    /// The measurement between two states of a sensor track of `source`, the first so many seconds earlier; `None` if
    /// no measurement explains the change. `evidence` is the track's evidence of its tracker, `place_m` the place of
    /// the sensor in the plane, if known, metres. Learns nothing.
    pub fn measurement_between(
        &self,
        (source, evidence, place_m): (u16, &GainEvidence, Option<[f64; 2]>),
        (before, seconds): (&Gaussian, f64),
        (after, has_height): (&Gaussian, bool),
    ) -> Option<Measurement> {
        let corrections = &self.models[usize::from(source)].corrections;
        match self.models[usize::from(source)].process_noise() {
            None if corrections.is_used() && shows_filter(&after.covariance) => {
                corrections.measurement(&Corrected::of((before, seconds), (after, has_height), place_m))
            }
            Some(noise) => recovered_measurement(&noise.predicted(before, seconds), after, has_height),
            None => match self.models[usize::from(source)].undone_between(
                evidence,
                &change_between((before, seconds), (after, has_height)),
                &after.covariance,
            ) {
                Some(undone) => {
                    let (moved_m, covariance_m2) = undone.measurement?;
                    let foretold = foretold_m(before, seconds);
                    Some(Measurement {
                        position_m: std::array::from_fn(|axis| foretold[axis] + moved_m[axis]),
                        covariance_m2,
                        ..as_stated(after.position_m(), &after.covariance, has_height)
                    })
                }
                None => Some(as_stated(after.position_m(), &after.covariance, has_height)),
            },
        }
    }
}

/// Returns the change between a state and a later state, `seconds` apart.
fn change_between((before, seconds): (&Gaussian, f64), (after, has_height): (&Gaussian, bool)) -> Change {
    let (foretold, place) = (foretold_m(before, seconds), after.position_m());
    let (former, velocity) = (before.velocity_mps(), after.velocity_mps());
    Change {
        position_m: std::array::from_fn(|axis| place[axis] - foretold[axis]),
        velocity_mps: std::array::from_fn(|axis| velocity[axis] - former[axis]),
        seconds,
        has_height,
    }
}

/// Returns the predicted position `seconds` after a state, metres.
fn foretold_m(state: &Gaussian, seconds: f64) -> [f64; AXES] {
    let (place, velocity) = (state.position_m(), state.velocity_mps());
    std::array::from_fn(|axis| place[axis] + velocity[axis] * seconds)
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;

    #[test]
    fn a_change_is_what_a_state_did_not_foretell() {
        let state = |mean: [f64; 6]| Gaussian {
            mean,
            covariance: Covariance::diagonal([40.0; AXES], [15.0; AXES]),
        };
        let before = state([100.0, 200.0, 300.0, 10.0, -20.0, 1.0]);
        let after = state([125.0, 155.0, 305.0, 11.0, -21.0, 1.5]);
        let change = change_between((&before, 2.0), (&after, true));
        assert_eq!(change.position_m, [5.0, -5.0, 3.0]);
        assert_eq!(change.velocity_mps, [1.0, -1.0, 0.5]);
        assert!(change.has_height && change.seconds == 2.0);
    }
}
