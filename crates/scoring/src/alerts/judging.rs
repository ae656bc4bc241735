//! Alerts beside violations: hits, misses and nuisances.

use std::collections::BTreeMap;

use serde::Serialize;

use super::alert_table::{RaisedAlert, Stated};
use super::followed::Followed;
use super::violations::{Subject, Violation, Violations};
use super::{ALERT_KINDS, APPROACH, AlertScoreSettings, CONFLICT, ENTER};
use crate::statistics::quantile;

/// Lead time that is enough, seconds.
const ENOUGH_S: f64 = 60.0;
/// Time after the first state of a target in which an alert is raised as soon as possible, seconds.
const FIRST_STATE_S: f64 = 5.0;
const S_PER_HOUR: f64 = 3600.0;

/// Figures of a kind of alerts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KindScore {
    /// Kind: one of [`ALERT_KINDS`].
    pub kind: &'static str,
    /// Alerts of the kind.
    pub alerts: u64,
    /// What the truth decides; `None` for a kind that is not judged.
    #[serde(flatten)]
    pub judged: Option<AlertFigures>,
}

/// Figures of alerts that the truth decides.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AlertFigures {
    /// Violations in the truth.
    pub events: u64,
    /// Those with an alert.
    pub hits: u64,
    /// Those without.
    pub misses: u64,
    /// Misses of targets without a track up to the violation's end.
    pub misses_without_track: u64,
    /// Hits whose first alert came after the violation's begin.
    pub late: u64,
    /// Further alerts of a violation that has one.
    pub duplicates: u64,
    /// Alerts without a violation.
    pub nuisance: u64,
    /// Nuisances whose track, or one of the two, follows no target.
    pub nuisance_without_target: u64,
    /// Nuisances per hour of the truth; `None` if the truth is a single second.
    pub nuisance_per_hour: Option<f64>,
    /// Alerts that a longer truth would decide.
    pub undecided: u64,
    /// Median of the time from the first alert to the violation, seconds; negative: late.
    pub lead_s_median: Option<f64>,
    /// Share of the hits at least a minute before, or at the first possible state.
    pub in_time: Option<f64>,
    /// Violations without an alert.
    pub missed: Vec<MissedEvent>,
    /// Numbers of the nuisances, in the order of raising.
    pub nuisance_alerts: Vec<u64>,
}

/// Violation without an alert.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissedEvent {
    /// Numbers of its targets.
    pub targets: Vec<i64>,
    /// Name of the area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<String>,
    /// Its begin, seconds.
    pub begins_s: f64,
}

/// Returns the figures of the kinds with alerts or violations.
pub(super) fn judged(
    violations: &Violations,
    followed: &Followed,
    alerts: &[RaisedAlert],
    settings: &AlertScoreSettings,
    (first_s, last_s): (i64, i64),
) -> Vec<KindScore> {
    let mut kinds = Vec::new();
    for kind in ALERT_KINDS {
        let of_kind: Vec<&RaisedAlert> = alerts.iter().filter(|alert| alert.stated.kind == kind).collect();
        let is_judged = match kind {
            CONFLICT | APPROACH => true,
            _ => kind == ENTER && !violations.area_names.is_empty(),
        };
        let mut figures = AlertFigures::default();
        if is_judged {
            let mut leads = Leads::default();
            for alert in &of_kind {
                judge(alert, (violations, followed), settings, &mut figures, &mut leads);
            }
            count_events(kind, (violations, followed), &leads, &mut figures);
            let hours = (last_s - first_s) as f64 / S_PER_HOUR;
            figures.nuisance_per_hour = (hours > 0.0).then(|| figures.nuisance as f64 / hours);
        }
        if !of_kind.is_empty() || figures.events > 0 {
            kinds.push(KindScore {
                kind,
                alerts: of_kind.len() as u64,
                judged: is_judged.then_some(figures),
            });
        }
    }
    kinds
}

/// Times at which right alerts were raised, by subject and begin of the violation (its bits: begins are compared with
/// themselves only).
#[derive(Debug, Default)]
struct Leads(BTreeMap<(Subject, u64), Vec<f64>>);

fn key(subject: &Subject, violation: &Violation) -> (Subject, u64) {
    (*subject, violation.begins_s.to_bits())
}

fn judge(
    alert: &RaisedAlert,
    (violations, followed): (&Violations, &Followed),
    settings: &AlertScoreSettings,
    figures: &mut AlertFigures,
    leads: &mut Leads,
) {
    let subjects = subjects(&alert.stated, violations, followed);
    let from_s = alert.stated.time_s;
    let to_s = alert
        .cleared_s
        .map(|cleared_s| cleared_s + settings.look_ahead_s(alert.stated.kind));
    let mut is_right = false;
    for subject in &subjects {
        for violation in violations.within(subject, from_s, to_s.unwrap_or(f64::INFINITY)) {
            is_right = true;
            leads.0.entry(key(subject, &violation)).or_default().push(from_s);
        }
    }
    let is_open = |subject: &Subject| to_s.is_none_or(|to_s| to_s > violations.end_s(subject));
    if is_right {
    } else if subjects.iter().any(is_open) {
        figures.undecided += 1;
    } else {
        figures.nuisance += 1;
        figures.nuisance_without_target += u64::from(subjects.is_empty());
        figures.nuisance_alerts.push(alert.number);
    }
}

/// What an alert is about: a subject, or one for each area if it names none; nothing if a track follows no target.
pub(super) fn subjects(stated: &Stated, violations: &Violations, followed: &Followed) -> Vec<Subject> {
    let target = |track| followed.target_of(track, stated.time_s);
    let Some(one) = target(stated.track) else {
        return Vec::new();
    };
    if stated.kind != ENTER {
        let other = stated.other.and_then(target);
        return other
            .map(|other| Subject::pair(stated.kind, one, other))
            .into_iter()
            .collect();
    }
    let is_meant = |name: &String| stated.area.as_ref().is_none_or(|area| area == name);
    let areas = violations
        .area_names
        .iter()
        .enumerate()
        .filter(|(_, name)| is_meant(name));
    let subject = |area| Subject {
        kind: ENTER,
        one,
        other: None,
        area: Some(area),
    };
    areas.map(|(area, _)| subject(area)).collect()
}

fn count_events(
    kind: &str,
    (violations, followed): (&Violations, &Followed),
    leads: &Leads,
    figures: &mut AlertFigures,
) {
    let (mut leads_s, mut in_time) = (Vec::new(), 0);
    for (subject, violation) in violations.of_kind(kind) {
        figures.events += 1;
        // First second in which all targets have a track.
        let firsts: Option<Vec<i64>> = subject.targets().map(|target| followed.since_s(target)).collect();
        let first_s = firsts
            .and_then(|firsts| firsts.into_iter().max())
            .map(|second| second as f64);
        let Some(raised_s) = leads.0.get(&key(&subject, &violation)) else {
            figures.misses += 1;
            figures.misses_without_track += u64::from(first_s.is_none_or(|first_s| first_s > violation.ends_s));
            figures.missed.push(MissedEvent {
                targets: subject.targets().collect(),
                area: subject.area.map(|area| violations.area_names[area].clone()),
                begins_s: violation.begins_s,
            });
            continue;
        };
        let earliest_s = raised_s.iter().copied().fold(f64::INFINITY, f64::min);
        let lead_s = violation.begins_s - earliest_s;
        let is_late_track = first_s
            .is_some_and(|first_s| first_s > violation.begins_s - ENOUGH_S && earliest_s <= first_s + FIRST_STATE_S);
        figures.hits += 1;
        figures.late += u64::from(lead_s < 0.0);
        figures.duplicates += raised_s.len() as u64 - 1;
        in_time += u64::from(lead_s >= ENOUGH_S || is_late_track);
        leads_s.push(lead_s);
    }
    figures.in_time = (figures.hits > 0).then(|| in_time as f64 / figures.hits as f64);
    figures.lead_s_median = quantile(&mut leads_s, 0.5);
}
