//! `koseki compare`: all fusion rules on a single input, side by side (FM-8).
//!
//! Each rule has its own engine and reads the same reports anew, so a comparison needs no more memory than a single
//! fusion. The command compares the results that [`crate::fuse`] would write and [`crate::score`] would score,
//! without intermediate files.

mod pictures;
mod table;

use anyhow::Context as _;
use fusion::Engine;
use fusion::rules::{REGISTRY, RuleEntry};
use messages::{Counter, NS_PER_S, SystemTrack, TrackState};
use scoring::{PictureScore, PictureSettings, ShownState, Timeline};
use serde::Serialize;

use crate::args::{Compare, CompareWhat};
use crate::files::InputError;
use crate::host::Host;
use crate::reading::{Setup, SkippedRows, drive};

/// Result of a rule.
#[derive(Debug, Serialize)]
struct RuleOutcome {
    rule: &'static str,
    /// Score against the truth, if a truth is given.
    #[serde(flatten)]
    score: Option<PictureScore>,
    /// Number of confirmed tracks.
    confirmed_tracks: u64,
    merged_tracks: u64,
    /// Number of changes of the selected source.
    hand_overs: u64,
    /// States at whole multiples of the refresh time.
    rows: u64,
    /// Share of coasted states among the rows.
    coasted: f64,
    us_per_report: f64,
}

/// Runs the comparison.
///
/// # Errors
/// If a file or the configuration cannot be used.
pub(crate) fn run(compare: &Compare, host: &dyn Host) -> anyhow::Result<()> {
    match &compare.what {
        Some(CompareWhat::Pictures(asked)) => pictures::run(asked, host),
        None => rules(compare, host),
    }
}

fn rules(compare: &Compare, host: &dyn Host) -> anyhow::Result<()> {
    let read =
        |file: &std::path::PathBuf| Timeline::truth(host.open(file)?).map_err(|error| InputError::new(file, error));
    let truth = compare.truth.as_ref().map(read).transpose()?;
    let begin_s = truth.as_ref().and_then(Timeline::compared_from_s);
    let settings = PictureSettings {
        cut_off_m: compare.c,
        gate_m: compare.gate,
        first_s: compare.t0.or(begin_s).unwrap_or_default(),
        ..PictureSettings::default()
    };
    let mut setup = Setup::of(host, &compare.input)?;
    setup.settings.refresh_s = Some(settings::Seconds::of_ns(compare.refresh.as_nanos() as i64));
    let mut outcomes = Vec::new();
    let mut refusals = SkippedRows::default();
    for rule in REGISTRY {
        setup.settings.rule.name.0 = rule.code;
        let (mut outcome, tracks, refused) = fuse(host, rule, &setup, settings.age_max_s)?;
        refusals = refused;
        if let (Some(truth), Some(file)) = (&truth, &compare.truth) {
            let found = scoring::score_picture(truth, &tracks, &settings);
            outcome.score = Some(found.map_err(|error| InputError::new(file, format!("{error}; see --t0")))?);
        }
        outcomes.push(outcome);
    }
    host.say(&(setup.named.as_text() + &refusals.as_text()));
    if compare.json {
        return host.print(&format!("{}\n", serde_json::json!({ "rules": outcomes })));
    }
    host.print(&table::table(&outcomes, compare.markdown)?)
}

/// Runs a rule; the tracks are shown for `age_max_s` seconds.
fn fuse(
    host: &dyn Host,
    rule: &'static RuleEntry,
    setup: &Setup<'_>,
    age_max_s: f64,
) -> anyhow::Result<(RuleOutcome, Timeline, SkippedRows)> {
    let engine = Engine::new(setup.settings.clone())?;
    let mut tracks = Timeline::empty(age_max_s);
    let (mut rows, mut coasted) = (0, 0);
    let mut reports = setup.reports()?;
    let row = |state: &SystemTrack| {
        let is_coasted = state.state == TrackState::Coasted as u8;
        if is_coasted || state.state == TrackState::Confirmed as u8 {
            rows += 1;
            coasted += u64::from(is_coasted);
            tracks.add(&shown(state));
        }
        Ok(())
    };
    let driven = drive(host, engine, &mut reports, row, |_| Ok(()));
    let (engine, driven) = driven.with_context(|| format!("rule {}", rule.name()))?;
    let count = |counter| engine.counts().get(counter);
    let outcome = RuleOutcome {
        rule: rule.name(),
        score: None,
        confirmed_tracks: count(Counter::TracksConfirmed),
        merged_tracks: count(Counter::TracksMerged),
        hand_overs: count(Counter::HandOvers),
        rows,
        coasted: coasted as f64 / rows.max(1) as f64,
        us_per_report: driven.engine_ns as f64 / 1e3 / driven.reports.max(1) as f64,
    };
    Ok((outcome, tracks, reports.refusals))
}

fn shown(state: &SystemTrack) -> ShownState {
    ShownState {
        number: i64::from(state.track_number),
        time_s: state.reference_time_ns as f64 / NS_PER_S,
        position_m: state.position_m,
        velocity_mps: state.velocity_mps,
        covariance: state.covariance,
        has_height: state.height_valid != 0,
    }
}
