//! Global alignment: large biases of a source, estimated from tracks that are not joined.
//!
//! Registration learns from joined tracks. A large bias prevents joining: nothing is learned, and every target is shown
//! twice. But all tracks of such a source have the same bias, so the bias can be found without an assignment of the
//! tracks. Three steps, each with a separate method:
//! 1. [`search`]: the bias that would bring most tracks of two sources together.
//! 2. [`verdict`]: the source of the pair to which the bias belongs.
//! 3. [`removal`]: the corrections of the reports of this source.
//!
//! Each report advances the search by a bounded amount of work; verdicts follow when all pairs have been compared.

mod findings;
mod pairing;
mod removal;
mod search;
mod verdict;
mod votes;

use messages::{Bias, SensorTrack};
use serde::{Deserialize, Serialize};

pub(crate) use crate::alignment::findings::PairFindings;
pub(crate) use crate::alignment::removal::BiasCorrection;
use crate::alignment::removal::Removal;
use crate::alignment::search::BiasSearch;
use crate::alignment::verdict::Evidence;
use crate::registration::ClockError;
use crate::settings::{IdentitySettings, RegistrationSettings, SourceSettings};

/// Large biases of all sources.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Alignment {
    reference: Option<usize>,
    removes: bool,
    search: BiasSearch,
    removal: Removal,
}

impl Alignment {
    pub(crate) fn new(settings: &RegistrationSettings, sources: &[SourceSettings]) -> Self {
        let reference = settings.reference_source.as_ref();
        Self {
            reference: reference.map(|source| usize::from(source.number)),
            removes: settings.gross,
            search: BiasSearch::new(sources),
            removal: Removal::new(sources.len()),
        }
    }

    /// Findings on two sources, by the place of their pair.
    pub(crate) fn pair_mut(&mut self, place: usize) -> &mut PairFindings {
        self.search.pair_mut(place)
    }

    /// Believed bias and correction of a source.
    pub(crate) fn bias_of(&self, source: usize) -> (Option<Bias>, Option<BiasCorrection>) {
        self.removal.of(source)
    }

    /// Continues with a [bias](Self::bias_of) of a former process; corrections need the present settings' consent.
    pub(crate) fn resume(&mut self, source: usize, bias: (Option<Bias>, Option<BiasCorrection>)) {
        self.removal.resume(source, bias, self.removes);
    }

    /// Believed bias of a source.
    pub(crate) fn error_of(&self, source: u16) -> Option<Bias> {
        self.removal.of(usize::from(source)).0
    }

    /// Whether the tracks of a source fit badly with two other sources that fit each other well. Until a correction,
    /// each track of the source may be a target shown elsewhere by the others.
    pub(crate) fn is_doubtful(&self, source: u16) -> bool {
        self.search.is_doubtful(usize::from(source))
    }

    /// Epoch of a source's correction: tracks of an earlier epoch are not comparable with its reports.
    #[inline]
    pub(crate) fn epoch_of(&self, source: u16) -> u8 {
        self.removal.epoch_of(usize::from(source))
    }

    /// Begins an epoch: the reports of the source have changed for another reason.
    pub(crate) fn begin_epoch(&mut self, source: u16) {
        self.removal.begin_epoch(usize::from(source));
        self.search.forget(usize::from(source));
    }

    /// Returns whether the bias of a source is taken off its reports.
    #[inline]
    pub(crate) fn corrects(&self, source: u16) -> bool {
        self.removal.corrects(usize::from(source))
    }

    /// The report without the bias of its source, at `now_ns`; `None` without correction.
    pub(crate) fn corrected(&self, report: &SensorTrack, now_ns: i64) -> Option<SensorTrack> {
        let place_m = self.search.places_m()[usize::from(report.source)];
        self.removal.corrected(report, place_m, now_ns)
    }

    /// Forgets the findings and the correction of a source.
    pub(crate) fn reset(&mut self, source: u16) {
        self.removal.resume(usize::from(source), (None, None), self.removes);
        self.begin_epoch(source);
    }

    /// Continues the search with a valid report at `now_ns`; `clocks` are the errors of the sources' clocks by the
    /// times of receipt. Returns the source whose correction has changed.
    pub(crate) fn take(
        &mut self,
        report: &SensorTrack,
        now_ns: i64,
        sources: (&[SourceSettings], Option<&IdentitySettings>),
        clocks: &[ClockError],
    ) -> Option<u16> {
        self.search.take(report, now_ns, sources).then(|| self.judge(clocks))?
    }

    /// Applies verdicts until a correction changes; returns the corrected source.
    fn judge(&mut self, clocks: &[ClockError]) -> Option<u16> {
        self.removal.keep_removed();
        let evidence = Evidence {
            pairs: self.search.pairs(),
            places_m: self.search.places_m(),
            clocks,
            reference: self.reference,
        };
        let changed = evidence
            .verdicts()
            .find(|verdict| self.removal.apply(verdict, self.removes))?
            .culprit;
        self.search.forget(changed);
        Some(changed as u16)
    }
}
