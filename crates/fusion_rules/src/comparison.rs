//! Results of all rules for one target, for readers of the reports outside of fusion.
//!
//! An operator asks for the present result of another rule. A second engine per rule would need all reports of all
//! targets. The rules themselves need the last reports of a single target only, available on the topics. [`compare`]
//! makes the same candidates as the engine, and calls the same rules.
//!
//! Three things remain unknown outside of the engine. Rules begin without memory, so that no hand-over is in progress.
//! Estimated accuracies (TI-7) have their initial values, and the condition is `normal`. Rules on the target's filter
//! have no result: the filter has every earlier report.

use messages::{Registration, SensorTrack, TrackState};

use crate::accuracy::{Accuracies, StatedAccuracy};
use crate::candidate::{candidate_of, value};
use crate::gross;
use crate::history::Histories;
use crate::quality::Qualities;
use crate::rules::{self, Candidate, REGISTRY, RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::{Settings, SourceSettings};
use crate::state::State;

/// Result of a rule for a target.
#[derive(Clone, Debug)]
pub struct RuleResult {
    /// The rule.
    pub rule: &'static RuleEntry,
    /// State at the reference time; `None`: the rule uses none of the contributions.
    pub state: Option<State>,
    /// Share per contribution, in the order of the sources.
    pub shares: Vec<Share>,
}

/// Comparison of the rules.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Contributions at the reference time, in the order of the sources.
    pub candidates: Vec<Candidate>,
    /// A result per rule on candidates.
    pub results: Vec<RuleResult>,
}

/// Returns the report without the configured and the estimated biases of the source. `now_ns`: reference time, UTC,
/// nanoseconds.
pub fn without_errors(report: &SensorTrack, source: &SourceSettings, known: &Registration, now_ns: i64) -> SensorTrack {
    let correction = source.correction.unwrap_or_default().with_estimated(known);
    gross::without_biases(report, (&correction, source.place_m), now_ns)
}

/// Applies every rule to the contributions to a target at `reference_ns` (UTC, nanoseconds).
///
/// `tracks` has the last reports of each contributing sensor track, the oldest first, at most one track per source;
/// tracks without reports or of unknown sources are ignored. `last` is the system track's state.
pub fn compare(settings: &Settings, tracks: &[&[SensorTrack]], last: &State, reference_ns: i64) -> Comparison {
    let accuracies = Accuracies::new(&settings.sources);
    let known = tracks.iter().filter_map(|reports| Some((*reports, reports.last()?)));
    let known = known.filter(|(_, latest)| usize::from(latest.source) < settings.sources.len());
    let mut candidates: Vec<Candidate> = known
        .map(|(reports, latest)| candidate(settings, &accuracies, (reports, latest), reference_ns))
        .collect();
    candidates.sort_by_key(|candidate| candidate.source);
    candidates.dedup_by_key(|candidate| candidate.source);
    candidates.truncate(messages::CONTRIBUTIONS_MAX);
    value(&mut candidates);
    let target = Target {
        candidates: &candidates,
        reference_ns,
        last,
        process_noise_m2ps3: settings.process_noise_m2ps3,
    };
    let results = REGISTRY.iter().filter_map(|entry| {
        let RuleMethod::Candidates(rule) = entry.method else {
            return None;
        };
        let mut shares = vec![Share::default(); candidates.len()];
        let weigh =
            |shares: &mut [Share]| rules::fuse(rule, &settings.rule, &target, &mut RuleMemory::default(), shares);
        Some(RuleResult {
            rule: entry,
            state: if candidates.is_empty() {
                None
            } else {
                weigh(&mut shares)
            },
            shares,
        })
    });
    Comparison {
        results: results.collect(),
        candidates,
    }
}

/// Returns the contribution of a sensor track with these reports.
fn candidate(
    settings: &Settings,
    accuracies: &Accuracies,
    (reports, latest): (&[SensorTrack], &SensorTrack),
    reference_ns: i64,
) -> Candidate {
    let (source, rule) = (&settings.sources[usize::from(latest.source)], &settings.rule);
    let kept = settings.capacity.stored_reports + 1;
    let mut histories = Histories::new(1, kept, rule.recency);
    let mut qualities = Qualities::new(1);
    for report in &reports[reports.len().saturating_sub(kept)..] {
        histories.push(0, report);
        let is_confirmed = report.state == TrackState::Confirmed as u8;
        qualities.push(0, report.time_of_measurement_ns, source.period_ns, is_confirmed);
    }
    let state = State::of_report(latest).at(reference_ns, settings.process_noise_m2ps3);
    let stated = StatedAccuracy {
        covariance: &latest.covariance,
        method: latest.method,
    };
    let target = (state.position_m, state.velocity_mps);
    let is_believed = latest.state != TrackState::Tentative as u8;
    Candidate {
        alpha: accuracies.alpha(settings, latest.source, target, stated),
        residual: is_believed
            .then(|| histories.residual(0, rule.residual, reference_ns))
            .flatten(),
        quality: qualities.index(0, reference_ns, source.period_ns, rule.quality_scans),
        ..candidate_of(settings, latest, state, reference_ns)
    }
}

#[cfg(test)]
mod tests {
    use messages::{Covariance, FusionRule, registration_bits};
    use test_support::S;

    use super::*;
    use crate::testing::test_settings;

    /// Three reports, a second apart, of a target at 100 m/s east; the last report is `off_m` farther east.
    fn reports(source: u16, sigma_m: f64, off_m: f64) -> Vec<SensorTrack> {
        let report = |second: i64| SensorTrack {
            source,
            time_of_measurement_ns: second * S,
            position_m: [100.0 * second as f64 + if second == 2 { off_m } else { 0.0 }, 0.0, 0.0],
            velocity_mps: [100.0, 0.0, 0.0],
            covariance: Covariance::diagonal([sigma_m; 3], [1.0; 3]),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        (0..3).map(report).collect()
    }

    #[test]
    fn each_rule_weighs_as_in_the_engine_and_bad_tracks_are_ignored() {
        let settings = test_settings(2);
        let [good, bad] = [reports(1, 10.0, 0.0), reports(0, 40.0, 30.0)];
        let unknown = reports(7, 1.0, 0.0);
        let tracks: [&[SensorTrack]; 4] = [&bad, &good, &unknown, &[]];
        let comparison = compare(&settings, &tracks, &State::default(), 3 * S);
        let sources: Vec<u16> = comparison.candidates.iter().map(|candidate| candidate.source).collect();
        assert_eq!(sources, [0, 1]);
        let of = |code: FusionRule| {
            comparison
                .results
                .iter()
                .find(|result| result.rule.code == code)
                .unwrap()
        };
        let best = of(FusionRule::BestSource);
        assert_eq!(best.shares[1].weight, [1.0; 3], "source 1 predicts itself");
        assert_eq!(best.state.unwrap().position_m[0], 300.0);
        let share = of(FusionRule::InverseTrace).shares[1].weight[0];
        assert!(
            (0.85..0.96).contains(&share),
            "variances 1 to 16, with the same growth: {share}"
        );
        for result in &comparison.results {
            let total: f64 = result.shares.iter().map(|share| share.weight[0]).sum();
            assert!((total - 1.0).abs() < 1e-9, "{}: {total}", result.rule.name());
        }
    }

    #[test]
    fn without_contributions_no_rule_has_a_result() {
        let comparison = compare(&test_settings(1), &[], &State::default(), S);
        assert!(!comparison.results.is_empty());
        assert!(
            comparison
                .results
                .iter()
                .all(|result| result.state.is_none() && result.shares.is_empty())
        );
    }

    #[test]
    fn learned_biases_are_taken_off_a_report_only_where_fusion_removes_them() {
        let settings = test_settings(1);
        let report = reports(0, 10.0, 0.0)[2];
        let mut known = Registration {
            offset_m: [50.0, -20.0, 0.0],
            ..Registration::default()
        };
        let place = |known: &Registration| without_errors(&report, &settings.sources[0], known, 2 * S).position_m;
        assert_eq!(place(&known), report.position_m);
        known.removed = registration_bits::EAST | registration_bits::NORTH;
        assert_eq!(place(&known), [150.0, 20.0, 0.0]);
    }
}
