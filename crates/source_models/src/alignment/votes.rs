//! Votes of pairs of tracks for the errors that would bring them together.

use messages::BiasKind;
use serde::{Deserialize, Serialize};

use crate::alignment::findings::{HYPOTHESES, bin};

/// Bins of a histogram along one axis, to either side of 0.
const BINS: usize = 60;
const ROW: usize = 2 * BINS + 1;

/// Histograms of the errors implied by pairs of tracks, and the fullest place of each so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Votes {
    lines: [VoteAxis; HYPOTHESES.len()],
    #[serde(with = "serde_arrays")]
    plane: [VoteAxis; ROW],
    /// Votes, and bins from the first.
    best: [(u32, [usize; 2]); HYPOTHESES.len()],
}

/// Votes along one axis.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct VoteAxis(#[serde(with = "serde_arrays")] [u16; ROW]);

impl Default for Votes {
    fn default() -> Self {
        Self {
            lines: [VoteAxis([0; ROW]); HYPOTHESES.len()],
            plane: [VoteAxis([0; ROW]); ROW],
            best: [(0, [BINS; 2]); HYPOTHESES.len()],
        }
    }
}

impl Votes {
    /// Adds a vote; values beyond the histogram have none.
    pub(super) fn add(&mut self, hypothesis: usize, kind: BiasKind, value: [f64; 2]) {
        let place = |part: f64| {
            let bins = (part / bin(kind)).round() + BINS as f64;
            (0.0..ROW as f64).contains(&bins).then_some(bins as usize)
        };
        let (Some(column), Some(row)) = (place(value[0]), place(value[1])) else {
            return;
        };
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(ROW);
        let sum = |line: &VoteAxis| line.0[near(column)].iter().map(|votes| u32::from(*votes)).sum::<u32>();
        let votes = if kind == BiasKind::Position {
            self.plane[row].0[column] += 1;
            self.plane[near(row)].iter().map(sum).sum()
        } else {
            self.lines[hypothesis].0[column] += 1;
            sum(&self.lines[hypothesis])
        };
        let best = &mut self.best[hypothesis];
        if votes > best.0 {
            *best = (votes, [column, row]);
        }
    }

    /// Place of the greatest concentration of votes, in bins from 0.
    pub(super) fn fullest(&self, hypothesis: usize) -> [f64; 2] {
        self.best[hypothesis].1.map(|index| index as f64 - BINS as f64)
    }
}
