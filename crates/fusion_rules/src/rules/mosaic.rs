//! `mosaic`: the area is divided into cells, each with a priority list of sources (QF-9).
//!
//! The output is that of the first present source of the list with a confirmed track. A source missing in the list of
//! its cell gives no output there. Without a list, the sources' priorities decide. With `quality_min`, a source with a
//! quality index (QF-4) below `quality_min` gives way to the next source with a sufficient index.

use messages::TrackState;

use super::combination::combine;
use super::{Candidate, RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::history::moved;
use crate::settings::RuleSettings;
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::Mosaic,
    summary: "the confirmed source that comes first in the list of the target's cell",
    assumption: "none: one source at a time, so correlation between sources does not matter",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

fn fuse(settings: &RuleSettings, target: &Target<'_>, memory: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    let last = target.last;
    let place_m = moved(last.position_m, last.velocity_mps, target.reference_ns - last.time_ns);
    let list = settings.mosaic.list_at(place_m);
    let rank = |candidate: &Candidate| match list {
        Some(list) => list.iter().position(|source| source.number == candidate.source),
        None => Some(candidate.priority as usize),
    };
    let is_poor = |candidate: &Candidate| candidate.quality < settings.mosaic.quality_min;
    let (_, _, source) = target
        .candidates
        .iter()
        .filter(|candidate| candidate.life == TrackState::Confirmed)
        .filter_map(|candidate| Some((is_poor(candidate), rank(candidate)?, candidate.source)))
        .min()?;
    memory.selected = [source; 3];
    for (share, candidate) in shares.iter_mut().zip(target.candidates) {
        share.weight = [f64::from(u8::from(candidate.source == source)); 3];
    }
    Some(combine(target.candidates, shares))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules;
    use crate::settings::{MosaicCell, MosaicSettings, RuleName};

    fn selected(settings: &RuleSettings, candidates: &[Candidate], place_m: [f64; 3]) -> Option<u16> {
        let target = Target {
            candidates,
            reference_ns: 0,
            last: &State {
                position_m: place_m,
                ..State::default()
            },
            process_noise_m2ps3: 1.0,
        };
        let mut memory = RuleMemory::default();
        rules::fuse(
            fuse,
            settings,
            &target,
            &mut memory,
            &mut vec![Share::default(); candidates.len()],
        )?;
        Some(memory.selected[0])
    }

    #[test]
    fn the_cell_decides_who_speaks() {
        let mut settings = RuleSettings {
            name: RuleName(ENTRY.code),
            mosaic: MosaicSettings {
                cell_m: 1000.0,
                default: Vec::new(),
                quality_min: 0,
                cells: vec![MosaicCell {
                    east: -1,
                    north: 0,
                    sources: vec![2.into(), 1.into()],
                }],
            },
            ..RuleSettings::default()
        };
        let mut candidates = [0, 1, 2].map(|source| Candidate {
            source,
            priority: u32::from(source),
            ..Candidate::default()
        });
        let (inside, outside) = ([-500.0, 10.0, 0.0], [500.0, 10.0, 0.0]);
        assert_eq!(selected(&settings, &candidates, inside), Some(2));
        assert_eq!(selected(&settings, &candidates, outside), Some(0), "by priority");
        candidates[2].life = TrackState::Tentative;
        assert_eq!(selected(&settings, &candidates, inside), Some(1));
        assert_eq!(
            selected(&settings, &candidates[..1], inside),
            None,
            "not in the list of this cell"
        );
        settings.mosaic.default = vec![1.into()];
        assert_eq!(selected(&settings, &candidates, outside), Some(1));
    }

    #[test]
    fn a_source_of_fallen_quality_gives_way_to_the_next() {
        let mut settings = RuleSettings {
            name: RuleName(ENTRY.code),
            ..RuleSettings::default()
        };
        settings.mosaic.quality_min = 6;
        let mut candidates = [(0, 5), (1, 6), (2, 10)].map(|(source, quality)| Candidate {
            source,
            quality,
            priority: u32::from(source),
            ..Candidate::default()
        });
        assert_eq!(selected(&settings, &candidates, [0.0; 3]), Some(1));
        candidates[1].quality = 0;
        candidates[2].quality = 0;
        assert_eq!(selected(&settings, &candidates, [0.0; 3]), Some(0), "none reaches it");
        settings.mosaic.quality_min = 0;
        assert_eq!(selected(&settings, &candidates, [0.0; 3]), Some(0));
    }
}
