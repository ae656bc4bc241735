//! Several models of one emitter's motion side by side; the bearings decide (EL-2).
//!
//! The motion of an emitter is unknown beforehand. A filter for fixed points is wrong for a moving emitter, and a
//! filter for straight motion is less accurate: from a platform that flies straight it cannot determine the range at
//! all. So the models run side by side, and the simplest model without contrary evidence is chosen.
//!
//! | filter | in the order of simplicity |
//! | --- | --- |
//! | auto | fixed point, straight motion, manoeuvring |
//! | fixed | fixed point, wandering |
//! | straight | straight motion, manoeuvring |
//!
//! There are two kinds of contrary evidence. Against the fixed point: the velocity found by the straight motion, if
//! rest is far from it (a Bayes factor, for some bearings in a row). Against each model without process noise:
//! bearings that disagree for long while the platform does not turn. The model then restarts: straight motion at the
//! state of the manoeuvring model, a fixed point with its last lines. The model can be chosen again when its
//! bearings have agreed for a while, twice as many after each such failure. Meanwhile the model with process noise
//! replaces it.
//!
//! While the simplest model only lacks geometry, no fix is published: a model with more freedom cannot be more
//! accurate.

use kept::{Get, Kept, Put, kept};
use nalgebra::Matrix4;

use crate::explanation::LocatorDecisionKind;
use crate::line_of_bearing::LineOfBearing;
use crate::motion::MotionModel;
use crate::settings::{ConsistencySettings, EmitterMotionSettings};
use crate::smoother::{BearingTreatment, Bounds, Model, Smoother, StartPoint};

/// Most models of one emitter.
pub(crate) const MODELS_MAX: usize = 3;
/// Bearings that have to agree with a model that failed, the first time and at most.
const PATIENCE_MIN: u32 = 128;
const PATIENCE_MAX: u32 = 1024;

/// Fix of the filters, before selection and prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawFix {
    /// Position east and north in the system frame, metres.
    pub position_m: [f64; 2],
    /// Velocity east and north, metres per second; 0 for a fixed point.
    pub velocity_mps: [f64; 2],
    /// Covariance of (east, north, velocity east, velocity north): m², m²/s and m²/s².
    pub covariance: Matrix4<f64>,
    /// Model of motion that is believed.
    pub motion: MotionModel,
    /// Set if the bearings agree with the fix; otherwise the fix is from older bearings.
    pub is_agreed: bool,
}

impl RawFix {
    /// The variance value: sum of the position's variances over east and north, m² (EL-3).
    pub fn variance_m2(&self) -> f64 {
        self.covariance[(0, 0)] + self.covariance[(1, 1)]
    }
}

/// A filter of either kind.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "both are windows of lines; the rest is little")]
enum EmitterFilter {
    Point(Smoother<2>),
    Motion(Smoother<4>),
}

/// The same question to either kind.
macro_rules! either {
    ($filter:expr, $inner:ident => $answer:expr) => {
        match $filter {
            EmitterFilter::Point($inner) => $answer,
            EmitterFilter::Motion($inner) => $answer,
        }
    };
}

/// A model with its filter.
#[derive(Clone, Debug)]
struct BankMember {
    motion: MotionModel,
    filter: EmitterFilter,
    /// Time, and number of bearings, for which bearings have disagreed without a turn.
    disagreed_s: f64,
    disagreed: u32,
    /// For how many bearings in a row they have agreed, and have to.
    agreed: u32,
    patience: u32,
}

/// The filters of one emitter.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    members: [Option<BankMember>; MODELS_MAX],
    chosen: Option<usize>,
    /// Set if the evidence shows a moving emitter, and the number of bearings with evidence for the opposite.
    is_moving: bool,
    doubts: u32,
}

/// Decisions of a bank on a bearing; room for two per model and one more.
pub(crate) type BankNotes = crate::explanation::Notes<{ 2 * MODELS_MAX + 1 }>;

impl Bank {
    pub(crate) fn new(settings: &EmitterMotionSettings, start: Option<StartPoint>) -> Self {
        let motions = MotionModel::of(settings.filter);
        let member = |place| Some(BankMember::new(*motions.get(place)?, settings, start));
        Self {
            members: std::array::from_fn(member),
            chosen: None,
            is_moving: false,
            doubts: 0,
        }
    }

    /// Fix at a time; `None` while the geometry does not allow one.
    pub(crate) fn fix_at(&self, time_ns: i64) -> Option<RawFix> {
        let member = self.members[self.chosen?].as_ref()?;
        if !member.filter.is_located() {
            return None;
        }
        let (position_m, velocity_mps, covariance) = member.filter.state_at(time_ns);
        Some(RawFix {
            position_m,
            velocity_mps,
            covariance,
            motion: member.motion,
            is_agreed: !member.filter.is_distrusting(),
        })
    }

    /// Comparison of a line of bearing with the fix: squared normalised innovation, logarithm of its variance.
    pub(crate) fn compare(&self, line: &LineOfBearing) -> Option<(f64, f64)> {
        self.members[self.chosen?].as_ref()?.filter.compare(line)
    }

    /// Takes the next line, `after_s` seconds after the last one.
    pub(crate) fn add(
        &mut self,
        line: &LineOfBearing,
        after_s: f64,
        turning_since_ns: Option<i64>,
        (motion, consistency): (&EmitterMotionSettings, &ConsistencySettings),
        notes: &mut BankNotes,
    ) {
        let is_turning = turning_since_ns.is_some();
        let bounds = Bounds {
            limit: match is_turning {
                true => consistency.limit_turning,
                false => consistency.limit,
            },
            turning_since_ns,
        };
        // The chosen model first: while the platform turns, its outliers are wrong for all models.
        let believed = self.chosen;
        let verdict = believed.map(|place| self.add_to(place, line, bounds, notes));
        let is_wrong = is_turning && verdict.is_some_and(|taken| !taken.is_used());
        let since_ns = turning_since_ns.filter(|_| matches!(verdict, Some(BearingTreatment::Distrusted(_))));
        for place in (0..MODELS_MAX).filter(|place| Some(*place) != believed) {
            match (is_wrong, &mut self.members[place]) {
                (true, Some(member)) => member.filter.set_aside(line, since_ns),
                _ => _ = self.add_to(place, line, bounds, notes),
            }
        }
        for place in 0..MODELS_MAX {
            let Some(member) = &mut self.members[place] else {
                continue;
            };
            member.count_agreement(after_s, is_turning);
            if member.has_disagreed_too_long(consistency) {
                notes.note(
                    LocatorDecisionKind::ModelRestarted(member.motion),
                    member.disagreed_s,
                    consistency.disagreement_max_s,
                );
                self.restart(place);
            }
        }
        self.begin_stand_in();
        self.reconsider(line);
        let evidence = self.weigh_motion(motion);
        self.choose(evidence, motion.evidence_min, notes);
    }

    /// Gives a model the line.
    fn add_to(
        &mut self,
        place: usize,
        line: &LineOfBearing,
        bounds: Bounds,
        notes: &mut BankNotes,
    ) -> BearingTreatment {
        let Some(member) = &mut self.members[place] else {
            return BearingTreatment::Used;
        };
        let taken = member.filter.add(line, bounds);
        match taken {
            BearingTreatment::Distrusted(sum) => {
                notes.note(
                    LocatorDecisionKind::BearingsSetAside(member.motion),
                    sum.abs(),
                    bounds.limit,
                );
            }
            BearingTreatment::Trusted => {
                let disagreed = f64::from(member.disagreed);
                notes.note(LocatorDecisionKind::BearingsAgree(member.motion), disagreed, f64::NAN);
            }
            BearingTreatment::Used | BearingTreatment::SetAside => {}
        }
        taken
    }

    /// Starts the model with process noise at the state of the model without, as soon as the latter has settled.
    fn begin_stand_in(&mut self) {
        let [.., one, other] = match &mut self.members {
            [first, second, None] => [None, first.as_mut(), second.as_mut()],
            [first, second, third] => [first.as_mut(), second.as_mut(), third.as_mut()],
        };
        match (one.map(|member| &member.filter), other.map(|member| &mut member.filter)) {
            (Some(EmitterFilter::Point(base)), Some(EmitterFilter::Point(filter))) if !filter.is_settled() => {
                filter.restart_like(base);
            }
            (Some(EmitterFilter::Motion(base)), Some(EmitterFilter::Motion(filter))) if !filter.is_settled() => {
                filter.restart_like(base);
            }
            _ => {}
        }
    }

    /// Shows the straight motion where the fixed point is, if there is one.
    fn reconsider(&mut self, latest: &LineOfBearing) {
        let fixed = self
            .members
            .iter()
            .flatten()
            .find(|member| member.motion == MotionModel::Fixed);
        let position_m = fixed
            .filter(|member| member.filter.is_located() && !member.filter.is_distrusting())
            .map(|member| member.filter.state_at(latest.time_ns).0);
        for member in self.members.iter_mut().flatten() {
            if let EmitterFilter::Motion(filter) = &mut member.filter {
                filter.reconsider(position_m, latest);
            }
        }
    }

    /// Switches between moving and resting once the evidence has lasted long enough.
    fn weigh_motion(&mut self, settings: &EmitterMotionSettings) -> f64 {
        let straight = self
            .members
            .iter()
            .flatten()
            .find(|member| member.motion == MotionModel::Straight);
        let Some(evidence) = straight
            .filter(|member| !member.filter.is_distrusting())
            .and_then(|member| member.filter.evidence_of_motion())
        else {
            return f64::NAN;
        };
        let is_doubtful = match self.is_moving {
            true => evidence < 0.0,
            false => evidence > settings.evidence_min,
        };
        self.doubts = if is_doubtful { self.doubts + 1 } else { 0 };
        if self.doubts >= settings.evidence_bearings {
            self.is_moving = !self.is_moving;
            self.doubts = 0;
        }
        evidence
    }

    /// Returns the simplest model without contrary evidence; otherwise the previous model, or the model with most
    /// freedom.
    fn choose(&mut self, evidence: f64, evidence_min: f64, notes: &mut BankNotes) {
        let is_moving = self.is_moving;
        let speaks_against = |member: &BankMember| member.motion == MotionModel::Fixed && is_moving;
        let mut located = (0..MODELS_MAX).filter(|place| self.is_located(*place));
        let good = located.clone().find(|place| {
            let member = self.members[*place].as_ref();
            member.is_some_and(|member| member.agreed >= member.patience && !speaks_against(member))
        });
        let first = self.members[0].as_ref();
        let is_open = self.chosen.is_none() && first.is_some_and(|member| member.is_open());
        let best = match self.chosen.filter(|chosen| self.is_located(*chosen)) {
            Some(chosen) => good.or(Some(chosen)),
            None => good.or_else(|| located.next_back()),
        };
        if best == self.chosen || is_open {
            return;
        }
        if let Some(member) = best.and_then(|best| self.members[best].as_ref()) {
            notes.note(LocatorDecisionKind::ModelChosen(member.motion), evidence, evidence_min);
            self.chosen = best;
        }
    }

    fn is_located(&self, place: usize) -> bool {
        self.members[place]
            .as_ref()
            .is_some_and(|member| member.filter.is_located())
    }

    fn restart(&mut self, place: usize) {
        let like = self.members.iter().flatten().find_map(|member| match &member.filter {
            EmitterFilter::Motion(filter) if member.motion == MotionModel::Manoeuvring => Some(filter.clone()),
            _ => None,
        });
        let Some(member) = &mut self.members[place] else { return };
        if member.motion == MotionModel::Straight {
            // The velocity estimate of the restarted model is void.
            (self.is_moving, self.doubts) = (false, 0);
        }
        match &mut member.filter {
            EmitterFilter::Motion(filter) => {
                if !like.is_some_and(|like| filter.restart_like(&like)) {
                    filter.restart();
                }
            }
            EmitterFilter::Point(filter) => filter.restart(),
        }
        (member.disagreed_s, member.disagreed, member.agreed) = (0.0, 0, 0);
        member.patience = (2 * member.patience).clamp(PATIENCE_MIN, PATIENCE_MAX);
    }
}

impl BankMember {
    fn new(motion: MotionModel, settings: &EmitterMotionSettings, start: Option<StartPoint>) -> Self {
        let model = Model {
            start,
            ..motion.model(settings)
        };
        let filter = match motion {
            MotionModel::Fixed | MotionModel::Wandering => EmitterFilter::Point(Smoother::new(model)),
            MotionModel::Straight | MotionModel::Manoeuvring => EmitterFilter::Motion(Smoother::new(model)),
        };
        Self {
            motion,
            filter,
            disagreed_s: 0.0,
            disagreed: 0,
            agreed: 0,
            patience: 0,
        }
    }

    /// Returns whether the model only lacks geometry.
    fn is_open(&self) -> bool {
        self.filter.is_open() && self.patience == 0
    }

    fn count_agreement(&mut self, after_s: f64, is_turning: bool) {
        if !self.filter.is_distrusting() {
            (self.disagreed_s, self.disagreed) = (0.0, 0);
            self.agreed = self.agreed.saturating_add(u32::from(self.filter.is_located()));
        } else if !is_turning {
            self.disagreed_s += after_s;
            self.disagreed += 1;
        }
    }

    fn has_disagreed_too_long(&self, settings: &ConsistencySettings) -> bool {
        self.disagreed >= settings.disagreement_bearings && self.disagreed_s >= settings.disagreement_max_s
    }
}

impl EmitterFilter {
    fn add(&mut self, line: &LineOfBearing, bounds: Bounds) -> BearingTreatment {
        either!(self, filter => filter.add(line, bounds))
    }

    fn set_aside(&mut self, line: &LineOfBearing, since_ns: Option<i64>) {
        either!(self, filter => filter.set_aside(line, since_ns));
    }

    fn compare(&self, line: &LineOfBearing) -> Option<(f64, f64)> {
        either!(self, filter => filter.compare(line))
    }

    fn is_located(&self) -> bool {
        either!(self, filter => filter.is_located())
    }

    fn is_distrusting(&self) -> bool {
        either!(self, filter => filter.is_distrusting())
    }

    fn is_open(&self) -> bool {
        either!(self, filter => filter.is_open())
    }

    fn evidence_of_motion(&self) -> Option<f64> {
        either!(self, filter => filter.evidence_of_motion())
    }

    fn state_at(&self, time_ns: i64) -> ([f64; 2], [f64; 2], Matrix4<f64>) {
        either!(self, filter => filter.state_at(time_ns))
    }
}

kept!(Bank {
    members: [Option<BankMember>; MODELS_MAX],
    chosen: Option<usize>,
    is_moving: bool,
    doubts: u32,
});
kept!(BankMember {
    motion: MotionModel,
    filter: EmitterFilter,
    disagreed_s: f64,
    disagreed: u32,
    agreed: u32,
    patience: u32,
});

/// The kind in one word, then the filter; the record has room for the larger kind.
impl Kept for EmitterFilter {
    const WORDS: usize = 1 + Smoother::<4>::WORDS;

    fn put(&self, to: &mut Put<'_>) {
        match self {
            Self::Point(filter) => {
                true.put(to);
                filter.put(to);
                (Smoother::<2>::WORDS..Smoother::<4>::WORDS).for_each(|_| to.word(0));
            }
            Self::Motion(filter) => {
                false.put(to);
                filter.put(to);
            }
        }
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        if !bool::get(from)? {
            return Smoother::get(from).map(Self::Motion);
        }
        let filter = Smoother::get(from)?;
        from.0 = from.0.get(Smoother::<4>::WORDS - Smoother::<2>::WORDS..)?;
        Some(Self::Point(filter))
    }
}
