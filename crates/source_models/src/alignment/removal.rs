//! Removal: biases of all sources, and the corrections of their reports.
//!
//! A certain bias is subtracted from each later report of the source. The next search then uses corrected reports, so
//! the finding is a *residual* bias. A residual of the same kind is added to the correction, and a correction below one
//! bin is dropped. A residual of another kind shows that the first kind was wrong; the correction is dropped, and the
//! search restarts.
//!
//! Each change of a correction begins an epoch of the source: earlier tracks are not comparable with later reports.

use messages::{Bias, BiasKind, SensorTrack};
use serde::{Deserialize, Serialize};

use crate::alignment::findings::bin;
use crate::alignment::verdict::BiasVerdict;
use crate::gross;

/// Kind and value of a bias to subtract from reports.
pub(crate) type BiasCorrection = (BiasKind, [f64; 2]);

/// Biases and corrections of all sources.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Removal {
    /// Believed bias of each source.
    errors: Vec<Option<Bias>>,
    removed: Vec<Option<BiasCorrection>>,
    /// Changes of each source's correction, modulo 256.
    epochs: Vec<u8>,
}

impl Removal {
    pub(super) fn new(sources: usize) -> Self {
        Self {
            errors: vec![None; sources],
            removed: vec![None; sources],
            epochs: vec![0; sources],
        }
    }

    /// Believed bias and correction of a source.
    pub(super) fn of(&self, source: usize) -> (Option<Bias>, Option<BiasCorrection>) {
        (self.errors[source], self.removed[source])
    }

    /// Continues with the bias and the correction of a former process, or without correction unless `removes`.
    pub(super) fn resume(&mut self, source: usize, bias: (Option<Bias>, Option<BiasCorrection>), removes: bool) {
        let (error, removed) = bias;
        self.removed[source] = removed.filter(|_| removes);
        self.errors[source] = error.map(|error| Bias {
            is_removed: error.is_removed && removes,
            ..error
        });
    }

    pub(super) fn epoch_of(&self, source: usize) -> u8 {
        self.epochs[source]
    }

    pub(super) fn begin_epoch(&mut self, source: usize) {
        self.epochs[source] = self.epochs[source].wrapping_add(1);
    }

    /// Returns whether the bias of a source is taken off its reports.
    #[inline]
    pub(super) fn corrects(&self, source: usize) -> bool {
        self.removed[source].is_some()
    }

    /// The report without the bias of its source, at `now_ns`; `None` without correction.
    pub(super) fn corrected(
        &self,
        report: &SensorTrack,
        place_m: Option<[f64; 2]>,
        now_ns: i64,
    ) -> Option<SensorTrack> {
        let (kind, value) = self.removed[usize::from(report.source)]?;
        Some(gross::corrected(report, kind, value, place_m, now_ns))
    }

    /// Drops biases without removal, to be found again. A removed bias leaves no trace in the findings.
    pub(super) fn keep_removed(&mut self) {
        for (error, removed) in self.errors.iter_mut().zip(&self.removed) {
            *error = error.filter(|_| removed.is_some());
        }
    }

    /// Applies a verdict; true if the correction of the culprit has changed. Only with `removes` are biases removed.
    pub(super) fn apply(&mut self, verdict: &BiasVerdict, removes: bool) -> bool {
        let BiasVerdict {
            culprit,
            kind,
            value,
            is_certain,
            ..
        } = *verdict;
        let is_more_certain = |error: Bias| error.is_certain && !is_certain;
        if self.errors[culprit].is_some_and(is_more_certain) {
            return false;
        }
        let is_removed = is_certain && removes;
        let mut total = value;
        if is_removed {
            total = match self.removed[culprit] {
                Some((before, already)) if before == kind => [0, 1].map(|axis| value[axis] + already[axis]),
                Some(_) => [0.0; 2],
                None => value,
            };
            let is_gone = total.iter().all(|part| part.abs() < bin(kind));
            self.removed[culprit] = (!is_gone).then_some((kind, total));
            self.begin_epoch(culprit);
        }
        self.errors[culprit] = Some(Bias {
            kind,
            value: total,
            partner: verdict.partner as u16,
            is_certain,
            is_removed,
        })
        .filter(|_| !is_removed || self.removed[culprit].is_some());
        is_removed
    }
}
