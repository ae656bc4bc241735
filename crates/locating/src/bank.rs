//! Several models of an emitter's motion side by side, mixed by evidence (EL-2).
//!
//! The motion of an emitter is unknown beforehand. A filter for fixed points is wrong for a moving emitter, and a
//! filter for straight motion is less accurate: from a platform that flies straight, that filter cannot determine the
//! range at all. A choice between the models is certain and wrong until the evidence is overwhelming. So the models run
//! side by side, and the fix is the mixture: mean and covariance of all models together, each with a probability.
//!
//! | filter | models; the last has process noise |
//! | --- | --- |
//! | auto | fixed point, straight motion, manoeuvring |
//! | fixed | fixed point, wandering |
//! | straight | straight motion, manoeuvring |
//!
//! # Probabilities
//!
//! *Fixed against straight.* A fixed point is a straight motion with velocity zero, so the straight motion alone has
//! the evidence: by how much the bearings have raised the density of rest ([`crate::mixture::slowed`]). "Fixed"
//! includes a slow drift: a first part is the fixed point, a second part the straight motion with a prior of a drifting
//! emitter's velocity. The latter keeps the covariance true for emitters that only seem to rest.
//!
//! *The model with process noise against its base*, the preceding model without. A base whose bearings disagree for
//! long while the platform does not turn has failed: it restarts (straight motion at the state of the model with
//! process noise, a fixed point with the last lines), and has the least probability. From then on both predict each
//! bearing, and the likelihoods' ratio is summed, until the base has the full probability again.
//!
//! # Not yet observable
//!
//! There is no fix before the geometry determines the range even if the emitter moves slowly, that is, before the base
//! has a fix. A fixed point would be certain too early.

use kept::{Get, Kept, Put, kept};
use nalgebra::{Matrix4, Vector4};

use crate::explanation::LocatorDecisionKind;
use crate::line_of_bearing::LineOfBearing;
use crate::mixture::{Slowed, Weighted, matched, slowed};
use crate::motion::MotionModel;
use crate::settings::{ConsistencySettings, EmitterMotionSettings};
use crate::smoother::{BearingTreatment, Bounds, Model, Smoother, StartPoint};

/// Most models of an emitter.
pub(crate) const MODELS_MAX: usize = 3;
/// Bounds of the logarithm of the likelihood ratio between the model with process noise and the base.
const LEAD_MAX: f64 = 10.0;
/// A squared normalised innovation counts at most so much in the ratio.
const SQUARED_MAX: f64 = 16.0;
/// Parts of less probability are left out of the mixture.
const PROBABILITY_MIN: f64 = 1e-7;

/// Fix of the filters, before selection and prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawFix {
    /// Position east and north in the system frame, metres.
    pub position_m: [f64; 2],
    /// Velocity east and north, metres per second.
    pub velocity_mps: [f64; 2],
    /// Covariance of (east, north, velocity east, velocity north): m², m²/s and m²/s².
    pub covariance: Matrix4<f64>,
    /// The most probable model of motion.
    pub motion: MotionModel,
    /// Set if the bearings agree with this model; otherwise the fix is from older bearings.
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

/// A model with a filter.
#[derive(Clone, Debug)]
struct BankMember {
    motion: MotionModel,
    filter: EmitterFilter,
    /// Time, and number of bearings, for which bearings have disagreed without a turn.
    disagreed_s: f64,
    disagreed: u32,
}

/// The filters of an emitter.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    members: [Option<BankMember>; MODELS_MAX],
    /// Probability of each model, and of a drift within that of the fixed point.
    probabilities: [f64; MODELS_MAX],
    drifting: f64,
    /// The most probable model; `None` while the range is not observable.
    leading: Option<usize>,
    /// Logarithm of the likelihood ratio between the model with process noise and the base.
    lead: f64,
    /// Logarithm of the odds of the fixed point, and of a drift, against straight motion.
    log_odds_fixed: [f64; 2],
    /// Way of the platform.
    way: Way,
}

/// Way of a platform, and the duration.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    length_m: f64,
    duration_s: f64,
    last_m: Option<[f64; 2]>,
}

impl Way {
    fn go_on(&mut self, line: &LineOfBearing, after_s: f64) {
        let Some(ray) = line.ray() else { return };
        if let Some(last_m) = self.last_m.replace(ray.platform_m) {
            self.length_m += line.distance_m(last_m);
            self.duration_s += after_s;
        }
    }

    /// Mean speed, m/s; 0 if nothing is known.
    fn speed_mps(&self) -> f64 {
        self.length_m / self.duration_s.max(f64::MIN_POSITIVE)
    }
}

/// Decisions of a bank on a bearing; room for two per model and a single further decision.
pub(crate) type BankNotes = crate::explanation::Notes<{ 2 * MODELS_MAX + 1 }>;

impl Bank {
    pub(crate) fn new(settings: &EmitterMotionSettings, start: Option<StartPoint>) -> Self {
        let motions = MotionModel::of(settings.filter);
        let member = |place| Some(BankMember::new(*motions.get(place)?, settings, start));
        Self {
            members: std::array::from_fn(member),
            probabilities: [0.0; MODELS_MAX],
            drifting: 0.0,
            leading: None,
            lead: -LEAD_MAX,
            log_odds_fixed: [f64::NEG_INFINITY; 2],
            way: Way::default(),
        }
    }

    /// Fix at a time; `None` while the range is not observable.
    pub(crate) fn fix_at(&self, time_ns: i64, settings: &EmitterMotionSettings) -> Option<RawFix> {
        let leading = self.members[self.leading?].as_ref()?;
        let part = |probability: f64, (mean, covariance)| {
            (probability > PROBABILITY_MIN).then(|| Weighted {
                log_weight: probability.ln(),
                mean,
                covariance,
            })
        };
        let mut parts = [None; MODELS_MAX + 1];
        for (place, member) in self.members.iter().enumerate() {
            let Some(member) = member.as_ref().filter(|_| self.probabilities[place] > PROBABILITY_MIN) else {
                continue;
            };
            let drifting = if place == 0 { self.drifting } else { 0.0 };
            parts[place] = part(self.probabilities[place] - drifting, member.filter.state_at(time_ns));
        }
        let straight = self.straight().filter(|straight| straight.filter.is_located());
        if let Some(drift) = straight.and_then(|straight| straight.slowed(time_ns, settings.still_sigma_mps)) {
            // A fixed point is not located better than a drifting emitter.
            if let Some(fixed) = &mut parts[0] {
                let apart = fixed.mean - drift.mean;
                fixed.covariance = drift.covariance + apart * apart.transpose();
            }
            parts[MODELS_MAX] = part(self.drifting, (drift.mean, drift.covariance));
        }
        let (mean, covariance) = matched(&parts)?;
        Some(RawFix {
            position_m: [mean[0], mean[1]],
            velocity_mps: [mean[2], mean[3]],
            covariance,
            motion: leading.motion,
            is_agreed: !leading.filter.is_distrusting(),
        })
    }

    /// Comparison of a line of bearing with the fix: squared normalised innovation, logarithm of the innovation's
    /// variance.
    pub(crate) fn compare(&self, line: &LineOfBearing) -> Option<(f64, f64)> {
        self.members[self.leading?].as_ref()?.filter.compare(line)
    }

    /// Whether the bearings fit together, but do not determine the range.
    pub(crate) fn is_range_open(&self) -> bool {
        let (base, _) = self.pair();
        self.leading.is_none()
            && self.members[base]
                .as_ref()
                .is_some_and(|base| base.filter.is_range_open())
    }

    /// Takes the next line, `after_s` seconds after the last line.
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
        self.way.go_on(line, after_s);
        self.compare_predictions(line);
        // The leading model first: while the platform turns, the outliers of this model are wrong for all models.
        let believed = self.leading;
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
            member.count_disagreement(after_s, is_turning);
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
        self.weigh(line.time_ns, motion);
        self.lead_by_probability(notes);
    }

    /// Corrects the kept differences of arrival times: see [`crate::window::Window::set_clocks`].
    pub(crate) fn set_clocks(&mut self, ahead: &impl Fn([u16; 2], i64) -> Option<(f64, f64)>) {
        for member in self.members.iter_mut().flatten() {
            either!(&mut member.filter, filter => filter.set_clocks(ahead));
        }
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

    /// Places of the model with process noise and the base.
    fn pair(&self) -> (usize, usize) {
        let last = self.members.iter().flatten().count() - 1;
        (last - 1, last)
    }

    /// The straight motion beside a fixed point.
    fn straight(&self) -> Option<&BankMember> {
        let (base, _) = self.pair();
        self.members[base].as_ref().filter(|_| base > 0)
    }

    /// Compares how well the model with process noise and the base predict a line.
    fn compare_predictions(&mut self, line: &LineOfBearing) {
        let (base, stand_in) = self.pair();
        let [base, stand_in] = [base, stand_in].map(|place| self.members[place].as_ref().map(|member| &member.filter));
        let log_likelihood = |filter: &EmitterFilter| {
            let (squared, log_variance) = filter.compare(line)?;
            Some(-0.5 * (squared.min(SQUARED_MAX) + log_variance))
        };
        // Without a failure there is no doubt; and bearings that are set aside are no evidence.
        let has_failed = self.lead > -LEAD_MAX;
        let base = base.filter(|base| has_failed && base.is_settled() && !base.is_distrusting());
        if let (Some(base), Some(stand_in)) = (base.and_then(log_likelihood), stand_in.and_then(log_likelihood)) {
            self.lead = (self.lead + stand_in - base).clamp(-LEAD_MAX, LEAD_MAX);
        }
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

    /// Shows the straight motion the place of the fixed point, if any.
    fn reconsider(&mut self, latest: &LineOfBearing) {
        let fixed = self
            .members
            .iter()
            .flatten()
            .find(|member| member.motion == MotionModel::Fixed);
        let position_m = fixed
            .filter(|member| member.filter.is_located() && !member.filter.is_distrusting())
            .map(|member| {
                let (mean, _) = member.filter.state_at(latest.time_ns);
                [mean[0], mean[1]]
            });
        for member in self.members.iter_mut().flatten() {
            if let EmitterFilter::Motion(filter) = &mut member.filter {
                filter.reconsider(position_m, latest);
            }
        }
    }

    /// Probabilities of the models after a line.
    fn weigh(&mut self, time_ns: i64, settings: &EmitterMotionSettings) {
        let (base, stand_in) = self.pair();
        if let Some(straight) = self.straight().filter(|straight| straight.filter.is_located()) {
            let odds = |speed_mps, share: f64| {
                let slowed = straight.slowed(time_ns, speed_mps);
                slowed.map(|slowed: Slowed| slowed.log_odds + share.ln())
            };
            let slowness = self.way.speed_mps().max(settings.slow_mps()) / settings.slow_mps();
            let [moving, drifting] = [settings.moving_probability, settings.drifting_probability]
                .map(|probability| probability / (slowness * slowness));
            let fixed = odds(0.0, (1.0 - moving - drifting).max(0.0) / moving);
            if let (Some(fixed), Some(drifting)) = (fixed, odds(settings.still_sigma_mps, drifting / moving)) {
                self.log_odds_fixed = [fixed, drifting];
            }
        }
        let mut log_weights = [f64::NEG_INFINITY; MODELS_MAX + 1];
        if base > 0 {
            [log_weights[0], log_weights[MODELS_MAX]] = self.log_odds_fixed;
        }
        (log_weights[base], log_weights[stand_in]) = (0.0, self.lead);
        for (place, weight) in log_weights[..MODELS_MAX].iter_mut().enumerate() {
            if !self.is_located(place) {
                *weight = f64::NEG_INFINITY;
            }
        }
        if self.straight().is_none_or(|straight| !straight.filter.is_located()) {
            log_weights[MODELS_MAX] = f64::NEG_INFINITY;
        }
        let greatest = log_weights
            .iter()
            .fold(f64::NEG_INFINITY, |most, weight| most.max(*weight));
        if greatest == f64::NEG_INFINITY {
            (self.probabilities, self.drifting) = ([0.0; MODELS_MAX], 0.0);
            return;
        }
        let weights = log_weights.map(|weight| (weight - greatest).exp());
        let total: f64 = weights.iter().sum();
        self.drifting = weights[MODELS_MAX] / total;
        self.probabilities = std::array::from_fn(|place| weights[place] / total);
        self.probabilities[0] += self.drifting;
    }

    /// The most probable model leads, once the range is observable, and until no model has a fix.
    fn lead_by_probability(&mut self, notes: &mut BankNotes) {
        let (base, _) = self.pair();
        let is_observable = self.leading.is_some() || self.is_located(base);
        let best = (0..MODELS_MAX)
            .filter(|place| is_observable && self.probabilities[*place] > 0.0)
            .max_by(|one, other| self.probabilities[*one].total_cmp(&self.probabilities[*other]));
        if best == self.leading {
            return;
        }
        if let Some((place, member)) = best.and_then(|best| Some((best, self.members[best].as_ref()?))) {
            notes.note(
                LocatorDecisionKind::ModelLeads(member.motion),
                self.probabilities[place],
                f64::NAN,
            );
        }
        self.leading = best;
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
        match &mut member.filter {
            EmitterFilter::Motion(filter) => {
                if !like.is_some_and(|like| filter.restart_like(&like)) {
                    filter.restart();
                }
            }
            EmitterFilter::Point(filter) => filter.restart(),
        }
        (member.disagreed_s, member.disagreed) = (0.0, 0);
        if place == self.pair().0 {
            self.lead = LEAD_MAX;
        }
    }
}

impl BankMember {
    fn new(motion: MotionModel, settings: &EmitterMotionSettings, start: Option<StartPoint>) -> Self {
        let model = Model {
            start,
            ..motion.model(settings)
        };
        let filter = match motion {
            MotionModel::Fixed | MotionModel::Wandering | MotionModel::Given => {
                EmitterFilter::Point(Smoother::new(model))
            }
            MotionModel::Straight | MotionModel::Manoeuvring => EmitterFilter::Motion(Smoother::new(model)),
        };
        Self {
            motion,
            filter,
            disagreed_s: 0.0,
            disagreed: 0,
        }
    }

    /// The belief of straight motion at a time with another prior of the velocity.
    fn slowed(&self, time_ns: i64, speed_mps: f64) -> Option<Slowed> {
        let EmitterFilter::Motion(filter) = &self.filter else {
            return None;
        };
        let (mean, covariance) = filter.state_at(time_ns);
        let cost_max = if speed_mps == 0.0 {
            filter.cost_of_rest()
        } else {
            f64::INFINITY
        };
        let own_mps = filter.speed_sigma_mps();
        slowed((&mean, &covariance), own_mps, speed_mps.min(0.5 * own_mps), cost_max)
    }

    fn count_disagreement(&mut self, after_s: f64, is_turning: bool) {
        if !self.filter.is_distrusting() {
            (self.disagreed_s, self.disagreed) = (0.0, 0);
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

    fn is_settled(&self) -> bool {
        either!(self, filter => filter.is_settled())
    }

    fn is_range_open(&self) -> bool {
        either!(self, filter => filter.is_range_open())
    }

    fn state_at(&self, time_ns: i64) -> (Vector4<f64>, Matrix4<f64>) {
        either!(self, filter => filter.state_at(time_ns))
    }
}

kept!(Bank {
    members: [Option<BankMember>; MODELS_MAX],
    probabilities: [f64; MODELS_MAX],
    drifting: f64,
    leading: Option<usize>,
    lead: f64,
    log_odds_fixed: [f64; 2],
    way: Way,
});
kept!(Way {
    length_m: f64,
    duration_s: f64,
    last_m: Option<[f64; 2]>,
});
kept!(BankMember {
    motion: MotionModel,
    filter: EmitterFilter,
    disagreed_s: f64,
    disagreed: u32,
});

/// The kind in a single word, then the filter; the record has room for the larger kind.
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
