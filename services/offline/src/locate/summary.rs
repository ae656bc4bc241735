//! Summary of inputs and results, as text or as JSON.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use locating::settings::Settings;
use locating::{Decision, Locator, LocatorCounts, LocatorDecisionKind};
use messages::NS_PER_S;
use serde_json::{Value, json};

use crate::args::Locate;
use crate::files::output_name;
use crate::host::Host;

use super::input::MeasurementInput;

/// Counts during the run.
#[derive(Debug, Default)]
pub(super) struct LocateSummary {
    /// Emitters with a fix.
    pub(super) emitters: BTreeSet<u32>,
    /// Time spent in the locator alone, nanoseconds.
    pub(super) locator_ns: i64,
    /// Preferred motion model of each emitter.
    models: BTreeMap<u32, &'static str>,
    times_set_aside: u64,
    restarts: u64,
}

impl LocateSummary {
    /// Counts the decisions on a bearing.
    pub(super) fn count(&mut self, decisions: &[Decision]) {
        for decision in decisions {
            match decision.kind {
                LocatorDecisionKind::ModelLeads(motion) => _ = self.models.insert(decision.emitter, motion.word()),
                LocatorDecisionKind::BearingsSetAside(_) => self.times_set_aside += 1,
                LocatorDecisionKind::ModelRestarted(_) => self.restarts += 1,
                _ => {}
            }
        }
    }

    /// Shows the summary: as JSON on standard output, else as text on standard error.
    ///
    /// # Errors
    /// If standard output fails.
    pub(super) fn show(
        &self,
        host: &dyn Host,
        locate: &Locate,
        locator: &Locator,
        input: &MeasurementInput<'_>,
    ) -> anyhow::Result<()> {
        let json = locate.json.then(|| self.as_json(locate, locator, input));
        host.show(json, || self.as_text(locate, locator, input))
    }

    fn as_json(&self, locate: &Locate, locator: &Locator, input: &MeasurementInput<'_>) -> Value {
        let refusals = &input.refusals;
        let (counts, settings) = (locator.counts(), locator.settings());
        json!({
            "out": locate.out.display().to_string(),
            "filter": settings.motion.filter.word(),
            "select": settings.selection.select.word(),
            "rows": counts.fixes,
            "bearings": counts.bearings,
            "arrivals": counts.arrivals,
            "references": counts.references,
            "ready_fixes": counts.ready_fixes,
            "without_fix": counts.without_fix,
            "set_aside": counts.set_aside,
            "times_set_aside": self.times_set_aside,
            "models_restarted": self.restarts,
            "associated": counts.associated,
            "emitters": counts.emitters,
            "emitters_with_fix": self.emitters.len(),
            "emitters_by_model": self.by_model(),
            "rows_refused": refusals.rows(),
            "refused": refusals.by_reason,
            "first_refused": refusals.first,
            "assumed": assumed(input, settings),
            "locator_s": self.locator_ns as f64 / NS_PER_S,
            "us_per_bearing": self.us_per_bearing(locator),
        })
    }

    fn as_text(&self, locate: &Locate, locator: &Locator, input: &MeasurementInput<'_>) -> String {
        let (counts, settings) = (locator.counts(), locator.settings());
        let mut text = input.refusals.as_text();
        for what in assumed(input, settings) {
            let _ = writeln!(text, "assumed: {what}");
        }
        let models: Vec<String> = (self.by_model().iter())
            .map(|(motion, emitters)| format!("{emitters} {motion}"))
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} of {} emitters; {} with a fix: {}",
            taken(counts),
            counts.emitters,
            self.emitters.len(),
            if models.is_empty() {
                "none".to_owned()
            } else {
                models.join(", ")
            }
        );
        let _ = writeln!(
            text,
            "{} {} before the geometry allowed a fix; {} set aside because they disagreed, {} times",
            counts.without_fix,
            if counts.arrivals + counts.ready_fixes == 0 {
                "bearings"
            } else {
                "measurements"
            },
            counts.set_aside,
            self.times_set_aside
        );
        let _ = writeln!(
            text,
            "filter {}, select {}: {:.3} s of the locator, {:.2} us a bearing",
            settings.motion.filter.word(),
            settings.selection.select.word(),
            self.locator_ns as f64 / NS_PER_S,
            self.us_per_bearing(locator)
        );
        let _ = writeln!(text, "{}: {} rows", output_name(&locate.out), counts.fixes);
        text
    }

    fn by_model(&self) -> BTreeMap<&'static str, u64> {
        let mut by_model = BTreeMap::new();
        for motion in self.models.values() {
            *by_model.entry(*motion).or_default() += 1;
        }
        by_model
    }

    fn us_per_bearing(&self, locator: &Locator) -> f64 {
        self.locator_ns as f64 * 1e-3 / locator.counts().measurements().max(1) as f64
    }
}

/// What was assumed, a sentence each.
fn assumed(input: &MeasurementInput<'_>, settings: &Settings) -> Vec<String> {
    let sigma_deg = settings.bearing_sigma_deg.deg();
    let is_default = input.has_recordings && settings.bearing_sigma_deg == Settings::default().bearing_sigma_deg;
    let accuracy = format!(
        "bearings of recordings have a standard deviation of {sigma_deg}°: no report states one; --bearing-sigma-deg \
         sets another"
    );
    let of_plane = input.plane.assumed.iter().cloned();
    of_plane.chain(is_default.then_some(accuracy)).collect()
}

/// Taken measurements, by kind.
fn taken(counts: &LocatorCounts) -> String {
    let kinds = [
        (counts.bearings, "bearings"),
        (counts.arrivals, "arrivals"),
        (counts.ready_fixes, "fixes"),
    ];
    let there_are = kinds.iter().filter(|(count, _)| *count > 0);
    let words: Vec<String> = there_are.map(|(count, word)| format!("{count} {word}")).collect();
    match words.is_empty() {
        true => "0 measurements".to_owned(),
        false => words.join(", "),
    }
}
