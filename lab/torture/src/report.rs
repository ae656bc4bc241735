//! Result of a run, as JSON and as text.

use std::path::Path;

use anyhow::Context as _;
use serde::Serialize;

use super::judge::Verdict;
use super::resources::{self, Resources};

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Outcome {
    /// The run has not ended yet, or was killed.
    #[default]
    Running,
    /// Nothing was wrong.
    Sound,
    /// Something was wrong with the deployment: see `findings`.
    Faulty,
    /// This command failed: see `failure`. There is no verdict on the deployment.
    Failed,
    /// Interrupted early; nothing was wrong until then.
    Interrupted,
}

/// Result of a run.
#[derive(Debug, Default, Serialize)]
pub(super) struct Report {
    pub(super) outcome: Outcome,
    /// Failure of this command itself.
    pub(super) failure: Option<String>,
    pub(super) seed: u64,
    pub(super) seconds: f64,
    /// Limits in words.
    pub(super) limits: Option<String>,
    pub(super) faults: Vec<Happened>,
    /// Number of take-overs by a standby, and of take-overs from a process that did not advance.
    pub(super) take_overs: u64,
    pub(super) take_overs_from_still: u64,
    #[serde(flatten)]
    pub(super) verdict: Option<Verdict>,
    /// Use of the machine, a look each quarter of a minute.
    pub(super) resources: Vec<Resources>,
}

/// A fault that was caused.
#[derive(Debug, Serialize)]
pub(super) struct Happened {
    pub(super) at_s: f64,
    pub(super) fault: &'static str,
    pub(super) act: String,
    /// Time until all processes were there and states came again; `None` otherwise.
    pub(super) back_s: Option<f64>,
}

impl Report {
    /// Writes the report as JSON, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(&self, path: Option<&Path>) -> anyhow::Result<()> {
        let Some(path) = path else { return Ok(()) };
        let text = serde_json::to_string_pretty(self)? + "\n";
        let write = || {
            let mut beside = path.as_os_str().to_owned();
            beside.push(".part");
            std::fs::write(&beside, &text)?;
            std::fs::rename(&beside, path)
        };
        write().with_context(|| format!("writing {}", path.display()))
    }

    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        if !self.resources.is_empty() {
            let growth = resources::growth(&self.resources);
            text += &format!("resident memory, MiB, at first, in the middle and at last: {growth}\n");
        }
        if let Some(verdict) = &self.verdict {
            let faults = (
                self.faults.len(),
                self.seconds,
                self.take_overs,
                self.take_overs_from_still,
            );
            text += &summary(verdict, faults);
        }
        if let Some(limits) = &self.limits {
            text += &format!("limits: {limits}\n");
        }
        text
    }

    /// All that was wrong, in a single line.
    pub(super) fn wrong(&self) -> String {
        self.verdict.as_ref().map_or_else(String::new, Verdict::wrong)
    }
}

/// Figures of a verdict; faults are a count, the run's seconds, and take-overs.
fn summary(verdict: &Verdict, (faults, seconds, take_overs, from_still): (usize, f64, u64, u64)) -> String {
    let figures = &verdict.figures;
    let spread = |spread: &Option<_>| match spread {
        Some(spread) => format!("{spread}"),
        None => "none".to_owned(),
    };
    format!(
        "{faults} faults in {seconds:.0} s, {} states of {} targets and {} epochs, {} lost and counted, {take_overs} \
         take-overs ({from_still} from one that stood still): {} targets renumbered, {} numbers given twice, {} tracks \
         never terminated, {} times started again by this command\n\
         {} outages of targets, s: {}; {} at rebuilds: {}\n\
         {} targets times {} seconds: missing {}, second tracks {}, tracks without a target {}\n\
         errors of positions, m: {}; without faults: {}\n",
        figures.states,
        figures.targets,
        figures.epochs,
        figures.lost,
        figures.renumbered,
        figures.given_twice,
        figures.never_terminated,
        figures.helped,
        figures.outages,
        spread(&figures.outage_s),
        figures.rebuild_outages,
        spread(&figures.rebuild_outage_s),
        figures.targets,
        figures.picture.seconds,
        figures.picture.missing_s,
        figures.picture.double_s,
        figures.picture.ghosts_s,
        spread(&figures.position_error_m[0]),
        spread(&figures.position_error_m[1]),
    )
}

/// A single verdict, as text.
pub(super) fn verdict_text(verdict: &Verdict, limits: &str) -> String {
    let figures = &verdict.figures;
    summary(verdict, (figures.faults, figures.seconds, 0, 0)) + &format!("limits: {limits}\n")
}
