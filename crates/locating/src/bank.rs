//! Several models of one emitter's motion side by side; the bearings decide (EL-2).
//!
//! Nobody knows beforehand whether an emitter lies still. A filter for fixed points is wrong about one that moves, and one for
//! straight motion pays for its freedom with accuracy: from a platform that flies straight on it cannot tell the range at
//! all. So the models run side by side, and the simplest one is believed until the bearings are much likelier by another.
//!
//! | filter | in the order of simplicity |
//! | --- | --- |
//! | auto | fixed point, straight motion, manoeuvring |
//! | fixed | fixed point, wandering |
//! | straight | straight motion, manoeuvring |
//!
//! A model whose bearings disagree for long while the platform does not turn is wrong about the emitter: it begins anew. One for
//! straight motion begins where the manoeuvring one is.

use nalgebra::Matrix4;

use crate::explanation::DecisionKind;
use crate::settings::{ConsistencySettings, FilterChoice, MotionSettings};
use crate::sighting::Sighting;
use crate::smoother::{Model, Smoother, Taken};

/// A model of an emitter's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A fixed point.
    Fixed,
    /// A point that wanders.
    Wandering,
    /// Straight and uniform.
    Straight,
    /// Straight, with small accelerations.
    Manoeuvring,
}

/// Most models of one emitter.
pub(crate) const MODELS_MAX: usize = 3;

impl Motion {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Wandering => "wandering",
            Self::Straight => "straight",
            Self::Manoeuvring => "manoeuvring",
        }
    }

    /// The models that compete, simplest first.
    fn of(choice: FilterChoice) -> &'static [Self] {
        match choice {
            FilterChoice::Auto => &[Self::Fixed, Self::Straight, Self::Manoeuvring],
            FilterChoice::Fixed => &[Self::Fixed, Self::Wandering],
            FilterChoice::Straight => &[Self::Straight, Self::Manoeuvring],
        }
    }

    fn model(self, settings: &MotionSettings) -> Model {
        let process_noise = match self {
            Self::Fixed | Self::Straight => 0.0,
            Self::Wandering => settings.wandering_noise_m2ps,
            Self::Manoeuvring => settings.manoeuvring_noise_m2ps3,
        };
        Model {
            process_noise,
            range_sigma_m: settings.range_sigma_m,
            speed_sigma_mps: settings.speed_sigma_mps,
            memory: settings.comparison_bearings,
        }
    }
}

/// What the filters know of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawFix {
    /// East and north, metres.
    pub position_m: [f64; 2],
    /// East and north, metres per second; 0 for a fixed point.
    pub velocity_mps: [f64; 2],
    /// Of (east, north, velocity east, velocity north): m², m²/s and m²/s².
    pub covariance: Matrix4<f64>,
    /// By which model.
    pub motion: Motion,
    /// Whether the bearings agree with it; without that it is older ones' fix.
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
enum Filter {
    Point(Smoother<2>),
    Motion(Smoother<4>),
}

/// A model with its filter.
#[derive(Clone, Debug)]
struct Member {
    motion: Motion,
    filter: Filter,
    /// How long, and for how many bearings, bearings have disagreed without a turn.
    disagreed_s: f64,
    disagreed: u32,
}

/// The filters of one emitter.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    members: [Option<Member>; MODELS_MAX],
    chosen: Option<usize>,
}

/// What a bank decided on a bearing; room for two decisions per model and one more.
pub(crate) type Notes = crate::explanation::Notes<{ 2 * MODELS_MAX + 1 }>;

impl Bank {
    pub(crate) fn new(settings: &MotionSettings) -> Self {
        let motions = Motion::of(settings.filter);
        Self {
            members: std::array::from_fn(|place| motions.get(place).map(|motion| Member::new(*motion, settings))),
            chosen: None,
        }
    }

    /// Begins anew with another emitter, in the same memory.
    pub(crate) fn reset(&mut self, settings: &MotionSettings) {
        for member in self.members.iter_mut().flatten() {
            *member = Member::new(member.motion, settings);
        }
        self.chosen = None;
    }

    /// What is known at a time; `None` while the geometry does not allow a fix.
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

    /// How a sighting compares with the fix: squared normalised innovation, logarithm of its variance.
    pub(crate) fn compare(&self, sighting: &Sighting) -> Option<(f64, f64)> {
        self.members[self.chosen?].as_ref()?.filter.compare(sighting)
    }

    /// Takes the next sighting, `after_s` seconds after the last one.
    pub(crate) fn add(
        &mut self,
        sighting: &Sighting,
        after_s: f64,
        is_turning: bool,
        settings: &ConsistencySettings,
        margin: f64,
        notes: &mut Notes,
    ) {
        let limit = match is_turning {
            true => settings.limit_turning,
            false => settings.limit,
        };
        for place in 0..MODELS_MAX {
            let Some(member) = &mut self.members[place] else {
                continue;
            };
            let taken = member.filter.add(sighting, limit);
            match taken {
                Taken::Distrusted(sum) => notes.note(DecisionKind::BearingsSetAside(member.motion), sum.abs(), limit),
                Taken::Trusted => notes.note(
                    DecisionKind::BearingsAgree(member.motion),
                    f64::from(member.disagreed),
                    f64::NAN,
                ),
                Taken::Used | Taken::SetAside => {}
            }
            member.count_disagreement(after_s, is_turning);
            if member.has_disagreed_too_long(settings) {
                notes.note(
                    DecisionKind::ModelRestarted(member.motion),
                    member.disagreed_s,
                    settings.disagreement_max_s,
                );
                self.restart(place);
            }
        }
        self.choose(margin, notes);
    }

    /// The simplest located model, unless another one explains the bearings much better.
    fn choose(&mut self, margin: f64, notes: &mut Notes) {
        for place in 0..MODELS_MAX {
            let Some(candidate) = &self.members[place] else {
                continue;
            };
            if !candidate.filter.is_located() || self.chosen == Some(place) {
                continue;
            }
            let current = self.chosen.and_then(|chosen| self.members[chosen].as_ref());
            let (lead, limit) = match current {
                Some(current) if current.filter.is_located() => {
                    (current.filter.score() - candidate.filter.score(), margin)
                }
                _ => (f64::INFINITY, margin),
            };
            if lead > limit {
                notes.note(DecisionKind::ModelChosen(candidate.motion), lead, limit);
                self.chosen = Some(place);
            }
        }
    }

    fn restart(&mut self, place: usize) {
        let like = self.members.iter().flatten().find_map(|member| match &member.filter {
            Filter::Motion(filter) if member.motion == Motion::Manoeuvring => Some(filter.clone()),
            _ => None,
        });
        let Some(member) = &mut self.members[place] else { return };
        match (&mut member.filter, like) {
            (Filter::Motion(filter), Some(like)) => filter.restart_like(&like),
            (Filter::Motion(filter), None) => filter.restart(),
            (Filter::Point(filter), _) => filter.restart(),
        }
        (member.disagreed_s, member.disagreed) = (0.0, 0);
    }
}

impl Member {
    fn new(motion: Motion, settings: &MotionSettings) -> Self {
        let model = motion.model(settings);
        let filter = match motion {
            Motion::Fixed | Motion::Wandering => Filter::Point(Smoother::new(model)),
            Motion::Straight | Motion::Manoeuvring => Filter::Motion(Smoother::new(model)),
        };
        Self {
            motion,
            filter,
            disagreed_s: 0.0,
            disagreed: 0,
        }
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

/// The same question to either kind.
macro_rules! either {
    ($filter:expr, $inner:ident => $answer:expr) => {
        match $filter {
            Filter::Point($inner) => $answer,
            Filter::Motion($inner) => $answer,
        }
    };
}

impl Filter {
    fn add(&mut self, sighting: &Sighting, limit: f64) -> Taken {
        either!(self, filter => filter.add(sighting, limit))
    }

    fn compare(&self, sighting: &Sighting) -> Option<(f64, f64)> {
        either!(self, filter => filter.compare(sighting))
    }

    fn is_located(&self) -> bool {
        either!(self, filter => filter.is_located())
    }

    fn is_distrusting(&self) -> bool {
        either!(self, filter => filter.is_distrusting())
    }

    fn score(&self) -> f64 {
        either!(self, filter => filter.score())
    }

    fn state_at(&self, time_ns: i64) -> ([f64; 2], [f64; 2], Matrix4<f64>) {
        either!(self, filter => filter.state_at(time_ns))
    }
}
