//! Reasons for the output: a record per decision (`--explain`).

use crate::cue::TurnSide;
use crate::motion::MotionModel;
use crate::selection::{SelectionReason, SelectionStage};

/// Decision on an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Time of the deciding bearing, nanoseconds.
    pub time_ns: i64,
    /// The emitter's number.
    pub emitter: u32,
    /// Decision.
    pub kind: LocatorDecisionKind,
    /// Compared value; NaN if there is none.
    pub value: f64,
    /// Limit for the value; NaN if there is none.
    pub limit: f64,
}

/// Kind of a decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocatorDecisionKind {
    /// An emitter was seen for the first time. Value: emitters there are; limit: places.
    EmitterStarted,
    /// The place of an emitter that had been silent (value, seconds) was given to another.
    EmitterDropped,
    /// Another model is the most probable model. Value: the probability.
    ModelLeads(MotionModel),
    /// The range is not observable, and would be after a turn of the platform to this side. Value: course after the
    /// turn; limit: present course; degrees from north.
    RangeNeedsTurn(TurnSide),
    /// A model's bearings disagree, and are set aside from now on: running sum of innovations in standard deviations.
    BearingsSetAside(MotionModel),
    /// A model's bearings agree again, after so many without a turn.
    BearingsAgree(MotionModel),
    /// A model restarts: the bearings disagreed for this many seconds without a turn.
    ModelRestarted(MotionModel),
    /// The selection went to another stage, used a fix, or did not. Value: the fix's variance, m²; limit: the
    /// threshold; or the times that were compared, seconds.
    Selection(SelectionStage, SelectionReason),
}

impl LocatorDecisionKind {
    /// The word for the reason.
    pub fn word(self) -> &'static str {
        match self {
            Self::EmitterStarted => "emitter_started",
            Self::EmitterDropped => "emitter_dropped",
            Self::ModelLeads(_) => "model_leads",
            Self::RangeNeedsTurn(_) => "range_needs_turn",
            Self::BearingsSetAside(_) => "bearings_set_aside",
            Self::BearingsAgree(_) => "bearings_agree",
            Self::ModelRestarted(_) => "model_restarted",
            Self::Selection(..) => "selection",
        }
    }

    /// Subject: the model or the stage; empty if there is none.
    pub fn subject(self) -> &'static str {
        match self {
            Self::EmitterStarted | Self::EmitterDropped => "",
            Self::ModelLeads(motion)
            | Self::BearingsSetAside(motion)
            | Self::BearingsAgree(motion)
            | Self::ModelRestarted(motion) => motion.word(),
            Self::RangeNeedsTurn(side) => side.word(),
            Self::Selection(stage, _) => stage.word(),
        }
    }

    /// Reason, in a few words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::EmitterStarted => "first bearing of it",
            Self::EmitterDropped => "silent while another emitter needed its place",
            Self::ModelLeads(_) => "the most probable model of those that are mixed",
            Self::RangeNeedsTurn(_) => "not observable on this course: a turn to the course in value would show it",
            Self::BearingsSetAside(_) => "they have errors to the same side",
            Self::BearingsAgree(_) => "they are at their expected values",
            Self::ModelRestarted(_) => "bearings disagreed for long without a turn",
            Self::Selection(_, reason) => reason.sentence(),
        }
    }
}

/// A few decisions without time and emitter, which are added later. Decisions beyond the capacity are dropped; the
/// models never make so many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Notes<const N: usize> {
    notes: [Option<(LocatorDecisionKind, f64, f64)>; N],
    len: usize,
}

impl<const N: usize> Notes<N> {
    pub(crate) const EMPTY: Self = Self {
        notes: [None; N],
        len: 0,
    };

    pub(crate) fn note(&mut self, kind: LocatorDecisionKind, value: f64, limit: f64) {
        if let Some(place) = self.notes.get_mut(self.len) {
            *place = Some((kind, value, limit));
            self.len += 1;
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (LocatorDecisionKind, f64, f64)> {
        self.notes.iter().flatten().copied()
    }
}
