//! `quality-factor`: a source has a weight by the recent confirmations of its track (QF-4 … QF-7).
//!
//! M is the number of scans, of the last N due scans, that confirmed the source's track; its quality factor is C = M
//! / Σ M. A source with a tentative track is omitted. Without any source the system track coasts.

use messages::TrackState;

use super::combination::combine;
use super::{RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::RuleSettings;
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::QualityFactor,
    summary: "all sources, each with a weight proportional to its track's confirmed scans among the last N",
    assumption: "any: the covariance bounds the error whatever the correlation between sources",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

fn fuse(_: &RuleSettings, target: &Target<'_>, _: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    let index = |place: usize| match target.candidates[place].life {
        TrackState::Tentative | TrackState::Suspended | TrackState::Terminated => 0,
        TrackState::Confirmed | TrackState::Coasted => target.candidates[place].quality,
    };
    let total: u32 = (0..shares.len()).map(index).sum();
    if total == 0 {
        return None;
    }
    for (place, share) in shares.iter_mut().enumerate() {
        share.weight = [f64::from(index(place)) / f64::from(total); 3];
    }
    Some(combine(target.candidates, shares))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{Candidate, testing};

    #[test]
    fn weights_are_proportional_to_confirmed_scans_of_tracks_believed_now() {
        let candidate = |source: u16, quality: u32, life: TrackState| Candidate {
            source,
            quality,
            life,
            ..Candidate::default()
        };
        let mut candidates = [
            candidate(0, 3, TrackState::Confirmed),
            candidate(1, 9, TrackState::Confirmed),
            candidate(2, 8, TrackState::Tentative),
        ];
        let (_, shares) = testing::fused(&ENTRY, &candidates);
        assert_eq!(shares.map(|share| share.weight[0]), [0.25, 0.75, 0.0]);
        for candidate in &mut candidates {
            candidate.quality = 0;
        }
        let (state, shares) = testing::fused(&ENTRY, &candidates);
        assert_eq!(state, None);
        assert_eq!(shares.map(|share| share.weight[0]), [0.0; 3]);
    }
}
