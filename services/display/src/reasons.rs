//! Reasons of the weights of a selected track, and what each rule would give now.
//!
//! The weights come from fusion; the reasons are derived here, from the reports of the contributors, the state, and
//! what fusion has learned of the sources (health messages). All values are those at the reference time of the state.
//! A residual is the difference between the contributor's last report, without its known biases and moved to the
//! reference time, and the state. Its length in standard deviations uses the covariances of both as if these were
//! independent, so that it is a lower bound for sources with a large share.

use std::borrow::Cow;

use fusion_rules::State;
use fusion_rules::comparison::{Comparison, compare, without_errors};
use fusion_settings::Settings;
use messages::{Contribution, Covariance, FusionRule, Registration, SensorTrack, SystemTrack, contribution_bits};
use serde_json::{Value, json};

use crate::records::ellipse;
use crate::world::World;

/// Ratio from which a difference between two sources is a reason.
const CLEAR: f64 = 1.25;
/// Residual from which a report contradicts the state, standard deviations.
const CONTRADICTS_SIGMAS: f64 = 3.0;

/// Facts on one contribution.
#[derive(Debug)]
pub(crate) struct ContributionFacts {
    source: u16,
    name: String,
    weight: f64,
    accuracy: Option<f64>,
    is_fresh: bool,
    age_s: f64,
    period_s: Option<f64>,
    /// Half axes of the ellipse of one standard deviation, with the covariance scaling; `None`: not stated.
    sigma_m: Option<[f32; 2]>,
    /// The same of the measurements behind the reports, as learned by fusion.
    learned_sigma_m: Option<[f32; 2]>,
    inflation: f64,
    residual_m: Option<[f64; 2]>,
    residual_sigmas: Option<f64>,
    /// Bias removed from the report, east, north, up.
    bias_m: Option<[f64; 3]>,
    dependent: Vec<(u16, f32)>,
    gross: Option<String>,
}

/// Returns the facts on the contributions to `track`, in the order of the contributions.
pub(crate) fn facts(world: &World, track: &SystemTrack) -> Vec<ContributionFacts> {
    let state = state_of(track);
    track.listed().iter().map(|part| fact(world, part, &state)).collect()
}

fn fact(world: &World, part: &Contribution, state: &State) -> ContributionFacts {
    let known = world.observed.source(part.source).registration;
    let key = (part.source, part.track_number);
    let report = world.recent.until(key, part.time_of_measurement_ns).last();
    let corrected = report.map(|report| corrected(world, report, &known, state.time_ns));
    let inflation = known.covariance_inflation.max(1.0);
    let scaled = corrected.as_ref().map(|report| scaled(&report.covariance, inflation));
    let residual_m = corrected.as_ref().map(|report| {
        let later_s = state.time_ns.saturating_sub(report.time_of_measurement_ns) as f64 / messages::NS_PER_S;
        [0, 1].map(|axis| report.position_m[axis] + report.velocity_mps[axis] * later_s - state.position_m[axis])
    });
    let removed = report
        .zip(corrected.as_ref())
        .map(|(report, corrected)| [0, 1, 2].map(|axis| report.position_m[axis] - corrected.position_m[axis]));
    let period_ns = world.source_fact(part.source).map(|fact| fact.source.period_ns);
    ContributionFacts {
        source: part.source,
        name: world.observed.source_name(part.source),
        weight: part.weight,
        accuracy: Some(part.accuracy).filter(|accuracy| accuracy.is_finite()),
        is_fresh: part.flags & contribution_bits::FRESH != 0,
        age_s: state.time_ns.saturating_sub(part.time_of_measurement_ns) as f64 / messages::NS_PER_S,
        period_s: period_ns.map(|period_ns| period_ns as f64 / messages::NS_PER_S),
        sigma_m: scaled.as_ref().and_then(axes),
        learned_sigma_m: Some([known.long_sigma_m, known.short_sigma_m]).filter(|[_, short]| *short > 0.0),
        inflation: known.covariance_inflation,
        residual_m,
        residual_sigmas: residual_m
            .zip(scaled)
            .and_then(|(residual_m, scaled)| length(residual_m, &scaled, &state.covariance)),
        bias_m: removed.filter(|bias_m| bias_m.iter().any(|part| part.abs() > 0.05)),
        dependent: dependent(&known).collect(),
        gross: known
            .gross_error()
            .filter(|gross| !gross.is_removed)
            .map(|gross| gross.to_string()),
    }
}

/// Returns the sources with errors that depend on those of a source, each with its correlation.
pub(crate) fn dependent(known: &Registration) -> impl Iterator<Item = (u16, f32)> {
    let pairs = known.dependent_sources.into_iter().zip(known.dependence);
    pairs.filter(|(_, correlation)| *correlation > 0.0)
}

/// Returns the report as fusion uses it: without the biases of its source.
fn corrected<'a>(world: &World, report: &'a SensorTrack, known: &Registration, now_ns: i64) -> Cow<'a, SensorTrack> {
    let source = world
        .engine
        .as_ref()
        .and_then(|engine| engine.sources.get(usize::from(report.source)));
    match source {
        Some(source) => Cow::Owned(without_errors(report, source, known, now_ns)),
        None => Cow::Borrowed(report),
    }
}

fn state_of(track: &SystemTrack) -> State {
    State {
        time_ns: track.reference_time_ns,
        position_m: track.position_m,
        velocity_mps: track.velocity_mps,
        covariance: track.covariance,
        has_height: track.height_valid != 0,
    }
}

fn scaled(covariance: &Covariance, inflation: f64) -> Covariance {
    Covariance {
        upper: covariance.upper.map(|value| value * inflation),
    }
}

/// Returns the half axes of the ellipse; `None` for a covariance that is not stated.
fn axes(covariance: &Covariance) -> Option<[f32; 2]> {
    let [longer, shorter, _] = ellipse(covariance);
    (longer > 0.0).then_some([longer, shorter])
}

/// Returns the length of a horizontal difference in standard deviations by the sum of two covariances; `None` for sums
/// that are not positive definite.
fn length([east, north]: [f64; 2], one: &Covariance, other: &Covariance) -> Option<f64> {
    let sum = |row: usize, column: usize| one.get(row, column) + other.get(row, column);
    let (a, b, c) = (sum(0, 0), sum(0, 1), sum(1, 1));
    let determinant = a * c - b * b;
    (a > 0.0 && determinant > 0.0)
        .then(|| ((c * east * east - 2.0 * b * east * north + a * north * north) / determinant).sqrt())
}

impl ContributionFacts {
    /// Adds the facts to the JSON of the contribution. `others`: the facts on all contributions to the same track.
    pub(crate) fn add_to(&self, world: &World, others: &[Self], rule: Option<FusionRule>, object: &mut Value) {
        let names: Vec<(String, f32)> = self.named(world).collect();
        let facts = json!({
            "age_s": self.age_s,
            "period_s": self.period_s,
            "sigma_m": self.sigma_m,
            "learned_sigma_m": self.learned_sigma_m,
            "residual_m": self.residual_m,
            "residual_sigmas": self.residual_sigmas,
            "inflation": self.inflation,
            "bias_m": self.bias_m,
            "depends_on": names,
            "reason": self.reason(world, others, rule),
        });
        if let (Some(object), Value::Object(facts)) = (object.as_object_mut(), facts) {
            object.extend(facts);
        }
    }

    fn named(&self, world: &World) -> impl Iterator<Item = (String, f32)> {
        let name = |number: u16| world.observed.source_name(number);
        self.dependent
            .iter()
            .map(move |(number, correlation)| (name(*number), *correlation))
    }

    /// Returns the reason of the weight in sentences.
    fn reason(&self, world: &World, others: &[Self], rule: Option<FusionRule>) -> String {
        let mut sentences = vec![self.main_reason(others, rule)];
        if let Some(gross) = &self.gross {
            sentences.push(format!("Its reports are off, {gross}, and that is not taken off."));
        }
        if self.inflation > 1.05 {
            sentences.push(format!(
                "Its covariances are scaled by {:.1}: it overstates its accuracy.",
                self.inflation
            ));
        }
        if let Some([east, north, _]) = self.bias_m {
            sentences.push(format!("A bias of {:.0} m is taken off.", east.hypot(north)));
        }
        let is_here = |number: u16| others.iter().any(|other| other.source == number);
        for (number, correlation) in self.dependent.iter().filter(|(number, _)| is_here(*number)) {
            let name = world.observed.source_name(*number);
            sentences.push(format!(
                "Its errors follow those of {name} (correlation {correlation:.1}): both count as one."
            ));
        }
        sentences.join(" ")
    }

    /// Returns the clearest difference from the contribution with the largest weight; for that contribution, from the
    /// next.
    fn main_reason(&self, others: &[Self], rule: Option<FusionRule>) -> String {
        if !self.is_fresh {
            let periods = self
                .periods()
                .map_or(String::new(), |periods| format!(", {periods:.1} periods"));
            return format!(
                "No report for {:.1} s{periods}: it no longer counts as fresh.",
                self.age_s
            );
        }
        let rivals = others
            .iter()
            .filter(|other| other.source != self.source && other.is_fresh);
        let Some(rival) = rivals.max_by(|one, other| one.weight.total_cmp(&other.weight)) else {
            return "The only source with a fresh report.".to_owned();
        };
        if self.residual_sigmas.is_some_and(|sigmas| sigmas > CONTRADICTS_SIGMAS) && self.weight < rival.weight {
            let [east, north] = self.residual_m.unwrap_or_default();
            let (metres, sigmas) = (east.hypot(north), self.residual_sigmas.unwrap_or_default());
            return format!("Contradicts the track: {metres:.0} m away, {sigmas:.1} σ.");
        }
        let is_by_accuracy = matches!(rule, Some(FusionRule::BestSource | FusionRule::QualityFactor));
        match is_by_accuracy {
            true => self.by_accuracy(rival),
            false => self.by_information(rival),
        }
    }

    fn by_accuracy(&self, rival: &Self) -> String {
        let name = &rival.name;
        match (self.accuracy, rival.accuracy) {
            (None, _) => "No accuracy value yet: a single report.".to_owned(),
            (Some(own), Some(other)) if self.weight >= rival.weight && own <= other => {
                format!("Smallest accuracy value, {own:.2}; {name} has {other:.2}.")
            }
            (Some(own), Some(other)) if self.weight >= rival.weight => {
                format!("Chosen before and kept: accuracy value {own:.2}, {name} has {other:.2}.")
            }
            (Some(own), Some(other)) => format!("Accuracy value {own:.2}; {name} has {other:.2}."),
            (Some(own), None) => format!("Accuracy value {own:.2}; {name} has none yet."),
        }
    }

    /// The reason where a share is a part of the information: accuracy, rate and age of the reports.
    fn by_information(&self, rival: &Self) -> String {
        let (name, leads) = (&rival.name, self.weight >= rival.weight);
        let sign = if leads { 1.0 } else { -1.0 };
        let mut reasons: Vec<(f64, String)> = Vec::new();
        let mut add = |exponent: f64, own: f64, other: f64, text: String| {
            reasons.push((exponent * sign * (other / own).ln(), text));
        };
        if let (Some(own), Some(other)) = (self.sigma(), rival.sigma()) {
            let word = if leads { "More accurate" } else { "Less accurate" };
            // Information goes with the variance.
            add(
                2.0,
                own,
                other,
                format!("{word} than {name}: σ {own:.0} m against {other:.0} m."),
            );
        }
        if let (Some(own), Some(other)) = (self.period_s, rival.period_s) {
            let word = if leads { "more" } else { "less" };
            let text = format!("Reports {word} often than {name}: every {own:.1} s against {other:.1} s.");
            add(1.0, own, other, text);
        }
        // Up to a period, age comes with the rate.
        if let (Some(own), Some(other)) = (self.periods(), rival.periods()) {
            let text = match leads {
                true => format!("{name} has missed reports: its last one is {:.1} s old.", rival.age_s),
                false => format!("Has missed reports: its last one is {:.1} s old.", self.age_s),
            };
            add(1.0, own.max(1.0), other.max(1.0), text);
        }
        let clearest = reasons.into_iter().max_by(|one, other| one.0.total_cmp(&other.0));
        match clearest {
            Some((clear, text)) if clear > CLEAR.ln() => text,
            _ => format!("About as accurate, as frequent and as new as {name}."),
        }
    }

    /// Standard deviation of a measurement, metres: as learned from a source that smooths, else as stated.
    fn sigma(&self) -> Option<f64> {
        self.learned_sigma_m
            .or(self.sigma_m)
            .map(|[long, short]| f64::from(long * short).sqrt())
    }

    /// Age of the last report in periods of the source.
    fn periods(&self) -> Option<f64> {
        self.period_s.map(|period_s| self.age_s / period_s)
    }
}

/// Returns the results of all rules for `track`, and a sentence where there are none: `rules`, `rules_missing`.
pub(crate) fn rules(world: &World, track: &SystemTrack) -> (Vec<Value>, Option<&'static str>) {
    let Some(engine) = &world.engine else {
        return (
            Vec::new(),
            Some("Rules need the configuration: start the display with --config, or with the deployment."),
        );
    };
    let state = state_of(track);
    let comparison = comparison(world, engine, track, &state);
    let rows = comparison.results.iter().map(|result| {
        let shares = comparison.candidates.iter().zip(&result.shares);
        let shares: Vec<Value> = shares
            .map(|(candidate, share)| {
                let name = world.observed.source_name(candidate.source);
                json!([candidate.source, name, share.weight.iter().sum::<f64>() / 3.0])
            })
            .collect();
        let apart_m = result.state.as_ref().map(|other| {
            let [east, north] = [0, 1].map(|axis| other.position_m[axis] - state.position_m[axis]);
            east.hypot(north)
        });
        json!({
            "rule": result.rule.name(),
            "summary": result.rule.summary,
            "in_force": result.rule.code.code() == track.rule,
            "shares": shares,
            "apart_m": apart_m,
            "sigma_m": result.state.as_ref().and_then(|state| axes(&state.covariance)),
        })
    });
    (rows.collect(), None)
}

fn comparison(world: &World, engine: &Settings, track: &SystemTrack, state: &State) -> Comparison {
    let listed = track
        .listed()
        .iter()
        .filter(|part| part.flags & contribution_bits::FRESH != 0);
    let reports: Vec<Vec<SensorTrack>> = listed
        .map(|part| {
            let known = world.observed.source(part.source).registration;
            let recent = world
                .recent
                .until((part.source, part.track_number), part.time_of_measurement_ns);
            let corrected = recent
                .iter()
                .map(|report| corrected(world, report, &known, state.time_ns));
            corrected.map(Cow::into_owned).collect()
        })
        .collect();
    let reports: Vec<&[SensorTrack]> = reports.iter().map(Vec::as_slice).collect();
    compare(engine, &reports, state, state.time_ns)
}

#[cfg(test)]
mod tests {
    use runtime::Now;
    use test_support::S;

    use super::*;
    use crate::world::SourceFact;

    const NOW: Now = Now {
        mono_ns: 100 * S,
        utc_ns: 1_700_000_000 * S,
    };

    fn world() -> World {
        let source = |(number, name, period_s): (u16, &str, i64)| SourceFact {
            source: deployment::SourceFacts {
                number,
                name: name.to_owned(),
                adapter: name.to_owned(),
                sensor_of: None,
                is_external: false,
                silent_after_ns: None,
                period_ns: period_s * S,
                north_offset_rad: None,
            },
            kind: "radar",
            site_m: None,
        };
        let sources = [(0, "radar", 4), (1, "ads-b", 1)].map(source);
        World::new("test", sources.into(), 600, 1_000_000)
    }

    /// Report of a target 1 km east at the time of the state, at 100 m/s east, `off_m` too far east.
    fn report(source: u16, age_s: i64, sigma_m: f64, off_m: f64) -> SensorTrack {
        SensorTrack {
            source,
            track_number: 7,
            time_of_measurement_ns: NOW.utc_ns - age_s * S,
            position_m: [1_000.0 - 100.0 * age_s as f64 + off_m, 0.0, 0.0],
            velocity_mps: [100.0, 0.0, 0.0],
            covariance: Covariance::diagonal([sigma_m; 3], [1.0; 3]),
            ..SensorTrack::default()
        }
    }

    /// System track with these contributions: report, weight, and whether it is fresh.
    fn track(parts: &[(SensorTrack, f64, bool)]) -> SystemTrack {
        let mut track = SystemTrack {
            track_number: 3,
            reference_time_ns: NOW.utc_ns,
            position_m: [1_000.0, 0.0, 0.0],
            velocity_mps: [100.0, 0.0, 0.0],
            covariance: Covariance::diagonal([3.0; 3], [1.0; 3]),
            contribution_count: parts.len() as u16,
            ..SystemTrack::default()
        };
        for (place, (report, weight, is_fresh)) in track.contributions.iter_mut().zip(parts) {
            *place = Contribution {
                time_of_measurement_ns: report.time_of_measurement_ns,
                weight: *weight,
                accuracy: f64::NAN,
                track_number: report.track_number,
                source: report.source,
                flags: if *is_fresh { contribution_bits::FRESH } else { 0 },
                ..Contribution::default()
            };
        }
        track
    }

    fn reasons_of(parts: &[(SensorTrack, f64, bool)]) -> Vec<String> {
        let mut world = world();
        let reports: Vec<SensorTrack> = parts.iter().map(|(report, ..)| *report).collect();
        world.hear_sensor_tracks(&reports, NOW);
        let facts = facts(&world, &track(parts));
        facts
            .iter()
            .map(|fact| fact.reason(&world, &facts, Some(FusionRule::Auto)))
            .collect()
    }

    #[test]
    fn facts_are_those_at_the_time_of_the_state() {
        let mut world = world();
        let reports = [report(0, 3, 40.0, 30.0), report(1, 0, 10.0, 0.0)];
        // A later report has no part in the state.
        let later = report(0, -1, 40.0, 500.0);
        world.hear_sensor_tracks(&[reports[0], reports[1], later], NOW);
        let facts = facts(&world, &track(&[(reports[0], 0.1, true), (reports[1], 0.9, true)]));
        let radar = &facts[0];
        assert_eq!(
            (radar.age_s, radar.period_s, radar.sigma_m),
            (3.0, Some(4.0), Some([40.0, 40.0]))
        );
        assert_eq!(radar.residual_m, Some([30.0, 0.0]));
        assert!((radar.residual_sigmas.unwrap() - 30.0 / 40.0_f64.hypot(3.0)).abs() < 1e-9);
        assert_eq!((radar.bias_m, radar.inflation), (None, 1.0));
    }

    #[test]
    fn the_clearest_difference_is_the_reason() {
        let exact = reasons_of(&[
            (report(0, 1, 200.0, 0.0), 0.1, true),
            (report(1, 0, 10.0, 0.0), 0.9, true),
        ]);
        assert_eq!(exact[0], "Less accurate than ads-b: σ 200 m against 10 m.");
        assert_eq!(exact[1], "More accurate than radar: σ 10 m against 200 m.");
        let frequent = reasons_of(&[
            (report(0, 1, 10.0, 0.0), 0.2, true),
            (report(1, 0, 10.0, 0.0), 0.8, true),
        ]);
        assert_eq!(frequent[0], "Reports less often than ads-b: every 4.0 s against 1.0 s.");
        let far = reasons_of(&[
            (report(0, 1, 10.0, 900.0), 0.2, true),
            (report(1, 0, 10.0, 0.0), 0.8, true),
        ]);
        assert!(
            far[0].starts_with("Contradicts the track: 900 m away, 86.2 σ."),
            "{far:?}"
        );
        let silent = reasons_of(&[
            (report(0, 20, 10.0, 0.0), 0.0, false),
            (report(1, 0, 10.0, 0.0), 1.0, true),
        ]);
        assert_eq!(
            silent[0],
            "No report for 20.0 s, 5.0 periods: it no longer counts as fresh."
        );
        assert_eq!(silent[1], "The only source with a fresh report.");
    }

    #[test]
    fn rules_need_the_configuration_and_report_every_rule_that_works_on_candidates() {
        let mut world = world();
        let parts = [
            (report(0, 3, 40.0, 30.0), 0.1, true),
            (report(1, 0, 10.0, 0.0), 0.9, true),
        ];
        world.hear_sensor_tracks(&[parts[0].0, parts[1].0], NOW);
        let track = track(&parts);
        let (rows, missing) = rules(&world, &track);
        assert!(rows.is_empty() && missing.unwrap().contains("--config"));
        let accuracy = || fusion_settings::Accuracy {
            base: fusion_settings::AccuracyBase::Constant { sigma_m: 20.0 },
            per_speed_s: 0.0,
            conditions: Vec::new(),
            methods: Vec::new(),
        };
        let sources = [("radar", 4.0), ("ads-b", 1.0)];
        let sources = sources.map(|(name, period_s)| fusion_settings::SourceSettings::of(name, period_s, accuracy()));
        world.engine = Some(std::sync::Arc::new(Settings::of(sources.into())));
        let (rows, missing) = rules(&world, &track);
        assert_eq!(missing, None);
        let row = |name: &str| rows.iter().find(|row| row["rule"] == name).unwrap();
        let shares = row("inverse-trace")["shares"].as_array().unwrap();
        assert_eq!(
            (shares[0][1].as_str(), shares[1][1].as_str()),
            (Some("radar"), Some("ads-b"))
        );
        assert!(shares[1][2].as_f64().unwrap() > 0.8, "{shares:?}");
        assert!(row("inverse-trace")["apart_m"].as_f64().unwrap() > 0.0);
        assert!(rows.iter().all(|row| row["rule"] != "system-filter"));
    }
}
