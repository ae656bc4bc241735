//! Sensor accuracy s and observation error coefficient alpha = k·s (TI-7, TI-8).

use crate::settings::{Accuracy, AccuracyBase, MethodAccuracy, NORMAL, Settings, SourceSettings};
use messages::Covariance;
use serde::{Deserialize, Serialize};

/// The sensor accuracies of all sources under the present condition.
#[derive(Debug, Serialize, Deserialize)]
pub struct Accuracies {
    /// Factors of the present condition, per source.
    factors: Vec<ConditionFactors>,
    /// Running mean square of residuals, per source, m²; used if the accuracy is estimated.
    mean_squares: Vec<Option<f64>>,
}

/// Factors of the present condition for a source.
#[derive(Debug, Serialize, Deserialize)]
struct ConditionFactors {
    source: f64,
    /// Numbers of the source's methods of observation, each with a factor in place of the source's factor.
    methods: Vec<(u8, f64)>,
}

impl ConditionFactors {
    /// Factors under the condition `name`: 1 if the condition is not named.
    fn under(accuracy: &Accuracy, name: &str) -> Self {
        let named = accuracy.conditions.iter().find(|(condition, _)| condition == name);
        let source = named.map_or(1.0, |(_, factor)| *factor);
        let of_method = |method: &MethodAccuracy| {
            let condition = method.conditions.get(name).copied().unwrap_or(source);
            (method.number, method.factor * condition)
        };
        Self {
            source,
            methods: accuracy.methods.iter().map(of_method).collect(),
        }
    }

    fn of_method(&self, method: u8) -> f64 {
        let of_method = self.methods.iter().find(|(number, _)| *number == method);
        of_method.map_or(self.source, |(_, factor)| *factor)
    }
}

/// Stated accuracy of a report.
#[derive(Clone, Copy, Debug)]
pub struct StatedAccuracy<'a> {
    /// Covariance of the report.
    pub covariance: &'a Covariance,
    /// Method of observation; 0 for a single method.
    pub method: u8,
}

impl Accuracies {
    /// The accuracy values from the settings of the sources.
    pub fn new(sources: &[SourceSettings]) -> Self {
        Self {
            factors: sources
                .iter()
                .map(|source| ConditionFactors::under(&source.accuracy, NORMAL))
                .collect(),
            mean_squares: vec![None; sources.len()],
        }
    }

    /// Mean square of the residuals of the source with this number, m²; `None` before the first.
    pub fn mean_square_mut(&mut self, source: usize) -> &mut Option<f64> {
        &mut self.mean_squares[source]
    }

    /// Sets the condition `name` for a single source, or for all sources (TI-7). Sources without this condition have
    /// factor 1.
    pub fn set_condition(&mut self, sources: &[SourceSettings], name: &str, only: Option<u16>) {
        for (index, (factor, source)) in self.factors.iter_mut().zip(sources).enumerate() {
            if only.is_some_and(|only| usize::from(only) != index) {
                continue;
            }
            *factor = ConditionFactors::under(&source.accuracy, name);
        }
    }

    /// Learns from a residual of `source` (horizontal, metres), if the accuracy of `source` is to be estimated.
    #[inline]
    pub fn learn(&mut self, sources: &[SourceSettings], source: u16, residual: [f64; 3]) {
        let index = usize::from(source);
        let AccuracyBase::Estimated { memory, .. } = sources[index].accuracy.base else {
            return;
        };
        let square = 0.5 * (residual[0] * residual[0] + residual[1] * residual[1]);
        let mean = self.mean_squares[index].get_or_insert(square);
        *mean += (square - *mean) / memory;
    }

    /// alpha of `source` (TI-8) for a target at this place, metres, with this velocity, m/s, and with this accuracy
    /// stated by the source.
    #[inline]
    pub fn alpha(
        &self,
        settings: &Settings,
        source: u16,
        target: ([f64; 3], [f64; 3]),
        stated: StatedAccuracy<'_>,
    ) -> f64 {
        let alpha = |of: u16| {
            let settings = &settings.sources[usize::from(of)];
            // The report names a method of its own source only.
            let method = if of == source { stated.method } else { 0 };
            settings.adjustment * self.s(&settings.accuracy, of, target, StatedAccuracy { method, ..stated })
        };
        match settings.rule.reference_source.as_ref().map(|source| source.number) {
            // A reference that is without error now, by its condition or as estimated, cannot be a unit.
            Some(reference) if alpha(reference) > 0.0 => alpha(source) / alpha(reference),
            _ => alpha(source),
        }
    }

    /// s of `source` (TI-7).
    #[inline]
    fn s(
        &self,
        accuracy: &Accuracy,
        source: u16,
        (position_m, velocity_mps): ([f64; 3], [f64; 3]),
        stated: StatedAccuracy<'_>,
    ) -> f64 {
        let index = usize::from(source);
        let estimated = self.mean_squares[index].filter(|_| matches!(accuracy.base, AccuracyBase::Estimated { .. }));
        let base = match (estimated, accuracy.base.configured_m(position_m)) {
            (Some(square_m2), _) => square_m2.sqrt(),
            (None, Some(configured_m)) => configured_m,
            (None, None) => {
                let reported = stated.covariance;
                (0.5 * (reported.get(0, 0) + reported.get(1, 1))).sqrt()
            }
        };
        let by_speed = match accuracy.per_speed_s {
            0.0 => 0.0,
            per_speed_s => per_speed_s * velocity_mps[0].hypot(velocity_mps[1]),
        };
        (base + by_speed) * self.factors[index].of_method(stated.method)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::test_settings;
    use messages::COVARIANCE_LEN;

    /// Accuracy of a report without a stated accuracy, by the only method of its source.
    const STATED: StatedAccuracy<'_> = StatedAccuracy {
        covariance: &Covariance {
            upper: [0.0; COVARIANCE_LEN],
        },
        method: 0,
    };

    #[test]
    fn a_polar_sensor_is_less_accurate_far_away() {
        let mut settings = test_settings(1);
        settings.sources[0].adjustment = 2.0;
        settings.sources[0].accuracy.base = AccuracyBase::Polar {
            place_m: [1000.0, 0.0],
            range_sigma_m: 30.0,
            azimuth_sigma_rad: 0.001,
        };
        let alpha =
            |position| Accuracies::new(&settings.sources).alpha(&settings, 0, (position, [0.0, 0.0, 0.0]), STATED);
        assert!((alpha([1000.0, 0.0, 0.0]) - 60.0).abs() < 1e-9);
        assert!(
            (alpha([1000.0, 40_000.0, 0.0]) - 100.0).abs() < 1e-9,
            "30 m along, 40 m across"
        );
    }

    #[test]
    fn a_reference_without_error_is_no_unit() {
        let mut settings = test_settings(2);
        settings.rule.reference_source = Some(1.into());
        settings.sources[1].accuracy.conditions = vec![("calm".to_owned(), 0.0)];
        let mut accuracies = Accuracies::new(&settings.sources);
        let here = ([0.0; 3], [0.0; 3]);
        assert_eq!(accuracies.alpha(&settings, 0, here, STATED), 1.0);
        accuracies.set_condition(&settings.sources, "calm", None);
        let alphas = [0, 1].map(|source| accuracies.alpha(&settings, source, here, STATED));
        assert_eq!(alphas, [10.0, 0.0]);
    }

    #[test]
    fn conditions_and_speed_change_s_while_running() {
        let mut settings = test_settings(2);
        settings.sources[0].accuracy.per_speed_s = 0.1;
        settings.sources[0].accuracy.conditions = vec![("rain".to_owned(), 3.0)];
        let mut accuracies = Accuracies::new(&settings.sources);
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [50.0, 0.0, 0.0]), STATED) - 15.0).abs() < 1e-9);
        accuracies.set_condition(&settings.sources, "rain", None);
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [50.0, 0.0, 0.0]), STATED) - 45.0).abs() < 1e-9);
        assert!(
            (accuracies.alpha(&settings, 1, ([0.0; 3], [50.0, 0.0, 0.0]), STATED) - 10.0).abs() < 1e-9,
            "not named: factor 1"
        );
        accuracies.set_condition(&settings.sources, "normal", None);
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [50.0, 0.0, 0.0]), STATED) - 15.0).abs() < 1e-9);
    }

    #[test]
    fn a_source_that_changes_its_method_is_judged_by_the_method_of_the_report() {
        let method = |number, factor, conditions: &[(&str, f64)]| MethodAccuracy {
            number,
            factor,
            conditions: conditions
                .iter()
                .map(|(name, factor)| ((*name).to_owned(), *factor))
                .collect(),
        };
        let mut settings = test_settings(2);
        settings.sources[0].accuracy.conditions = vec![("rain".to_owned(), 3.0)];
        settings.sources[0].accuracy.methods = vec![method(1, 0.5, &[]), method(2, 4.0, &[("rain", 1.0)])];
        let mut accuracies = Accuracies::new(&settings.sources);
        let alphas = |accuracies: &Accuracies, source| {
            [0, 1, 2, 9].map(|method| {
                accuracies.alpha(
                    &settings,
                    source,
                    ([0.0; 3], [0.0; 3]),
                    StatedAccuracy { method, ..STATED },
                )
            })
        };
        assert_eq!(alphas(&accuracies, 0), [10.0, 5.0, 40.0, 10.0]);
        assert_eq!(alphas(&accuracies, 1), [10.0; 4], "another source has other methods");
        accuracies.set_condition(&settings.sources, "rain", None);
        assert_eq!(alphas(&accuracies, 0), [30.0, 15.0, 40.0, 30.0]);
        let twice = vec![method(2, 1.0, &[]), method(2, 3.0, &[])];
        let table = crate::settings::AccuracyTable {
            methods: twice,
            ..Default::default()
        };
        assert!(table.check().unwrap_err().to_string().contains("method[1].number"));
    }

    #[test]
    fn an_estimated_accuracy_follows_the_residuals() {
        let mut settings = test_settings(1);
        settings.sources[0].accuracy.base = AccuracyBase::Estimated {
            initial_m: 7.0,
            memory: 20.0,
        };
        let mut accuracies = Accuracies::new(&settings.sources);
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [0.0, 0.0, 0.0]), STATED) - 7.0).abs() < 1e-9);
        for step in 0..200 {
            let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
            accuracies.learn(&settings.sources, 0, [30.0 * sign, -30.0 * sign, 0.0]);
        }
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [0.0, 0.0, 0.0]), STATED) - 30.0).abs() < 1e-6);
    }

    #[test]
    fn the_reference_source_has_alpha_1() {
        let mut settings = test_settings(2);
        settings.sources[1].accuracy.base = AccuracyBase::Constant { sigma_m: 25.0 };
        settings.rule.reference_source = Some(0.into());
        let accuracies = Accuracies::new(&settings.sources);
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [0.0, 0.0, 0.0]), STATED) - 1.0).abs() < 1e-12);
        assert!((accuracies.alpha(&settings, 1, ([0.0; 3], [0.0, 0.0, 0.0]), STATED) - 2.5).abs() < 1e-12);
        settings.sources[0].adjustment = 0.0;
        assert!(settings.check().unwrap_err().to_string().contains("reference_source"));
    }

    #[test]
    fn what_a_source_reports_of_itself_can_be_its_accuracy() {
        let mut settings = test_settings(2);
        settings.sources[0].accuracy.base = AccuracyBase::Reported;
        settings.sources[0].adjustment = 2.0;
        let accuracies = Accuracies::new(&settings.sources);
        let stated = StatedAccuracy {
            covariance: &Covariance::diagonal([35.0; 3], [1.0; 3]),
            method: 0,
        };
        assert!((accuracies.alpha(&settings, 0, ([0.0; 3], [0.0; 3]), stated) - 70.0).abs() < 1e-9);
        settings.rule.reference_source = Some(0.into());
        assert!(settings.check().unwrap_err().to_string().contains("what it reports"));
    }
}
