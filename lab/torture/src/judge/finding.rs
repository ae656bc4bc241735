//! Findings: each kind of fault with its number and its first examples.

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
    EndedWithoutCause,
    NeverTerminated,
    TwoTracks,
    NotBack,
    OutageMedian,
    Outage99,
    OutageWorst,
    Blind,
    Position,
    Frozen,
    NotFinite,
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
            Self::EndedWithoutCause => "tracks were terminated while their target was reported",
            Self::NeverTerminated => "tracks fell silent and were never terminated",
            Self::TwoTracks => "targets had two tracks for too long",
            Self::NotBack => "targets or processes did not come back",
            Self::OutageMedian => "median of outages above its limit",
            Self::Outage99 => "99 % of outages above its limit",
            Self::OutageWorst => "outages above the limit of the worst",
            Self::Blind => "times in which one target in ten coasted for too long",
            Self::Position => "targets shown far from where they were",
            Self::Frozen => "positions stood still while the target moved",
            Self::NotFinite => "states with a value that is not finite",
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
