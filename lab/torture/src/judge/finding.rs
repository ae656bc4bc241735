//! Findings: each kind of fault with count and first examples.

use std::collections::BTreeMap;

use serde::Serialize;

/// Examples that are kept of each kind.
const EXAMPLES: usize = 5;

/// Kinds of findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Finding {
    Renumbered,
    NumberGivenTwice,
    OlderEpoch,
    Epoch,
    Times,
    Late,
    Repeated,
    EndedWithoutCause,
    NeverTerminated,
    Missing,
    Double,
    Ghost,
    Lacks,
    Rate,
    Position,
    Height,
    Velocity,
    Whole,
    NotFinite,
    NoNumber,
    NotBack,
    UncountedLoss,
    Helped,
    LeftBehind,
}

impl Finding {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Renumbered => "targets went on under another number",
            Self::NumberGivenTwice => "numbers were given twice",
            Self::OlderEpoch => "states were sent by a fusion after a newer one had begun",
            Self::Epoch => "epochs began without a reason, or are impossible",
            Self::Times => "states with impossible times",
            Self::Late => "states were late",
            Self::Repeated => "states or samples came again",
            Self::EndedWithoutCause => "tracks were terminated while their target was reported",
            Self::NeverTerminated => "tracks fell silent and were never terminated",
            Self::Missing => "targets that a sensor sees were not shown",
            Self::Double => "tracks stood beside another track of their target",
            Self::Ghost => "tracks stood where no target is, or had the address of none",
            Self::Lacks => "tracks had lost an address, a height or a velocity that their sources state",
            Self::Rate => "targets had too few states, or too many",
            Self::Position => "positions were wrong",
            Self::Height => "heights were wrong",
            Self::Velocity => "velocities were wrong",
            Self::Whole => "times in which the errors of all targets were greater than without faults",
            Self::NotFinite => "states with a value that is not finite",
            Self::NoNumber => "states without a number",
            Self::NotBack => "processes did not come back, or nothing was shown at all",
            Self::UncountedLoss => "times at which losses were miscounted",
            Self::Helped => "times that the deployment did not heal by itself and had to be started again",
            Self::LeftBehind => "things were left behind",
        }
    }
}

/// How often something was found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Found {
    pub(crate) finding: Finding,
    pub(crate) count: u64,
    pub(crate) examples: Vec<String>,
}

/// All findings of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings(BTreeMap<Finding, Found>);

impl Findings {
    pub(crate) fn add(&mut self, finding: Finding, example: impl FnOnce() -> String) {
        let found = self.0.entry(finding).or_insert(Found {
            finding,
            count: 0,
            examples: Vec::new(),
        });
        found.count += 1;
        if found.examples.len() < EXAMPLES {
            found.examples.push(example());
        }
    }

    pub(crate) fn list(&self) -> Vec<Found> {
        self.0.values().cloned().collect()
    }

    /// How many there are in all.
    pub(crate) fn total(&self) -> u64 {
        self.0.values().map(|found| found.count).sum()
    }

    pub(crate) fn count(&self, finding: Finding) -> u64 {
        self.0.get(&finding).map_or(0, |found| found.count)
    }
}
