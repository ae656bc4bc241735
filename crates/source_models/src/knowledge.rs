//! Knowledge of the sources, as fusion reads the models.

use messages::{NS_PER_S, SensorTrack};

use crate::credibility::Judgement;
use crate::dependence::Dependence;
use crate::detection_map::DetectionProbability;
use crate::error_shape::Stretch;
use crate::measurement::Correction;
use crate::motion::Motion;
use crate::points::Points;
use crate::registration::SourceErrors;
use crate::rhythm::Rhythm;
use crate::settings::{AssociationSettings, CoverageArea, Settings, SourceSet, SourceSettings};
use crate::source_model::SourceModel;
use crate::sources::{Sources, place_of};

/// Share of a self-reporting source's reports that measuring sensors contradict, from which the source is biased.
const SHARE_MAX: f64 = 0.5;

/// Position of a report relative to the estimate of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearness {
    /// The source is exempt from comparison at present.
    Exempt,
    /// The report needs no comparison.
    Near,
    /// The report needs a comparison with other sources.
    Far {
        /// Variance per axis of the points of a target that sources see, m².
        spread_m2: f64,
    },
}

/// Times.
impl Sources {
    /// Whether the clock of some source is taken off.
    #[inline]
    pub fn corrects_clocks(&self) -> bool {
        self.corrects_clocks
    }

    /// Returns a valid report, which came at `now_ns`, without the gross error of its source, and without the error of
    /// the source's clock; `None` if neither is taken off.
    #[inline]
    pub fn aligned(&self, settings: &Settings, report: &SensorTrack, now_ns: i64) -> Option<SensorTrack> {
        let removed_s = self.clocks[usize::from(report.source)].removed_s;
        if (removed_s == 0.0 && !self.alignment.corrects(report.source)) || !is_aligned(settings, report) {
            return None;
        }
        Some(self.without_gross_error(report, removed_s, now_ns))
    }

    /// A report without the error of its source's clock, and without the source's gross error.
    #[cold]
    fn without_gross_error(&self, report: &SensorTrack, removed_s: f64, now_ns: i64) -> SensorTrack {
        let mut in_time = *report;
        if removed_s != 0.0 {
            in_time.time_of_measurement_ns -= (removed_s * NS_PER_S) as i64;
        }
        self.alignment.corrected(&in_time, now_ns).unwrap_or(in_time)
    }

    /// Age up to which a report of `source` counts, nanoseconds.
    #[inline]
    pub fn fresh_ns(&self, source: u16) -> i64 {
        self.lifetimes.fresh_ns(source)
    }

    /// How late most reports of `source` are, nanoseconds.
    #[inline]
    pub fn late_ns(&self, source: u16) -> i64 {
        self.lifetimes.late_ns(source)
    }

    /// Time without a report after which a track of `source` ends, nanoseconds.
    #[inline]
    pub fn silence_ns(&self, source: u16) -> i64 {
        self.lifetimes.silence_ns(source)
    }

    /// The same of a target with this rhythm, where a track ends after `usual_ns` otherwise.
    #[inline]
    pub fn silence_at(&self, rhythm: Rhythm, usual_ns: i64) -> i64 {
        self.lifetimes.silence_at(rhythm, usual_ns)
    }

    /// Time without a report after which a confirmed track of these sources ends, nanoseconds.
    pub fn silence_of(&self, sources: SourceSet) -> i64 {
        self.lifetimes.silence_of(sources)
    }

    /// Time without a report after which a tentative track ends, nanoseconds.
    #[inline]
    pub fn tentative_ns(&self) -> i64 {
        self.lifetimes.tentative_ns
    }

    /// Least time without a report after which a confirmed track ends, nanoseconds.
    #[inline]
    pub fn terminate_ns(&self) -> i64 {
        self.lifetimes.terminate_ns
    }

    /// Lets the rhythm of a target, which may have an address or MMSI, follow a report of `source`, so long after the
    /// one before.
    #[inline]
    pub fn follow_rhythm(&self, rhythm: &mut Rhythm, of: (u16, bool), interval_ns: i64) {
        self.lifetimes.learn_rhythm(rhythm, of, interval_ns);
    }

    /// Whether a track of `source` with its latest report at `time_ns` is of before a restart of the source.
    #[inline]
    pub fn is_before_restart(&self, source: u16, time_ns: i64) -> bool {
        self.lifetimes.restarts.is_before(source, time_ns)
    }

    /// Whether `source` has restarted shortly before a time, at which a track of it began.
    pub fn has_restarted_before(&self, source: u16, began_ns: i64) -> bool {
        self.lifetimes.restarts.is_shortly_before(source, began_ns)
    }
}

/// Errors.
impl Sources {
    /// Rest of the biases of a report's source, metres, and the variance of the biases, m²; `None` before the biases
    /// are learned.
    #[inline]
    fn bias_left(&self, sources: &[SourceSettings], report: &SensorTrack) -> Option<(f64, f64)> {
        let place_m = place_of(&sources[usize::from(report.source)]);
        self.registration
            .left(report.source, report.position_m, report.velocity_mps, place_m)
    }

    /// Distance at which two reports of one target can lie by the biases of their sources, metres: the reach of
    /// identity until both are learned.
    pub fn bias_reach_m(&self, settings: &Settings, one: &SensorTrack, other: &SensorTrack) -> f64 {
        const SIGMAS: f64 = 4.0;
        let most_m = settings.identity.reach_m;
        let left = |report| self.bias_left(&settings.sources, report);
        match (left(one), left(other)) {
            (Some(a), Some(b)) => (a.0 + b.0 + SIGMAS * (a.1 + b.1).sqrt()).min(most_m),
            _ => most_m,
        }
    }

    /// The known errors of a report.
    #[inline]
    pub fn correction_of(&self, sources: &[SourceSettings], report: &SensorTrack) -> Correction {
        let place_m = place_of(&sources[usize::from(report.source)]);
        let model = &self.models[usize::from(report.source)];
        Correction {
            shift_m: self
                .registration
                .shift(report.source, report.position_m, report.velocity_mps, place_m),
            covariance_scale: model.covariance_scale(),
            stretch: place_m.map_or(Stretch::NONE, |place_m| model.shape.stretch(report.position_m, place_m)),
        }
    }

    /// Variance per axis of errors that no measurement shows, m²: of the point that filters follow, and of errors that
    /// the sources have in common.
    pub fn common_error_m2(&self) -> f64 {
        self.points.spread_m2() + self.registration.common_error_m2()
    }

    /// Whether some source's time stamps are multiples of a coarse step.
    #[inline]
    pub fn has_coarse_stamps(&self) -> bool {
        self.has_coarse_stamps
    }

    /// Whether the heights of some source have slow errors.
    #[inline]
    pub fn has_slow_heights(&self) -> bool {
        self.has_slow_heights
    }

    /// Variance of a height to which sources contribute by these weights, with the sum 1, m²: slow errors of heights.
    pub fn height_m2(&self, weights: impl Iterator<Item = (u16, f64)>) -> f64 {
        let slow_m2 = |source: u16| self.models[usize::from(source)].heights.variance_m2();
        weights.map(|(source, weight)| weight * weight * slow_m2(source)).sum()
    }

    /// The same of a state to which all sources contribute alike, m².
    pub fn mean_height_m2(&self) -> f64 {
        if !self.has_slow_heights {
            return 0.0;
        }
        let weight = 1.0 / self.models.len() as f64;
        self.height_m2((0..self.models.len() as u16).map(|source| (source, weight)))
    }

    /// Variance of the time of a state to which sources contribute by these weights, with the sum 1, s²: the errors of
    /// coarse time stamps. The offset that registered sources have in common is one error; the others are independent.
    pub fn course_s2(&self, weights: impl Iterator<Item = (u16, f64)>) -> f64 {
        let (mut independent_s2, mut common) = (0.0, 0.0);
        for (source, weight) in weights {
            let errors = self.registration.of(source);
            if !errors.stamps.is_coarse() {
                continue;
            }
            let is_settled = self.registration.is_settled(source);
            let own_s2 = if is_settled {
                errors.time_left_s2()
            } else {
                errors.stamps.variance_s2
            };
            independent_s2 += weight * weight * own_s2;
            common += if is_settled { weight } else { 0.0 };
        }
        independent_s2 + common * common * self.registration.common_time_s2()
    }

    /// The same of a state to which all sources contribute alike, s².
    pub fn mean_course_s2(&self) -> f64 {
        if !self.has_coarse_stamps {
            return 0.0;
        }
        let weight = 1.0 / self.models.len() as f64;
        self.course_s2((0..self.models.len() as u16).map(|source| (source, weight)))
    }

    /// Returns whether the innovations of a source on the system track with this number teach now: those of all
    /// targets, or of a part of the targets of a source with many reports.
    #[inline]
    pub fn teaches(&self, source: u16, system_track: u32) -> bool {
        self.sampling.includes(source, system_track)
    }

    /// Estimated systematic errors of a source that exists.
    #[inline]
    pub fn errors(&self, source: u16) -> &SourceErrors {
        self.registration.of(source)
    }

    /// Suspected error of a source on all targets with this velocity, east and north, metres.
    #[inline]
    pub fn suspected_shift_m(&self, source: u16, velocity_mps: [f64; 3]) -> [f64; 2] {
        self.registration.suspected_shift(source, velocity_mps)
    }

    /// Variance per axis of a source's errors that are known and not removed, m².
    #[inline]
    pub fn doubt_m2(&self, source: u16) -> f64 {
        self.registration.doubt_m2(source)
    }

    /// Whether the errors of a source have been estimated for some time.
    #[inline]
    pub fn is_settled(&self, source: u16) -> bool {
        self.registration.is_settled(source)
    }

    /// Whether the errors of a source have been estimated for a long time.
    pub fn is_acquainted(&self, source: u16) -> bool {
        self.registration.is_acquainted(source)
    }

    /// Whether the errors of a source changed so recently that the states of the source's tracker lag behind.
    #[inline]
    pub fn is_young(&self, source: u16) -> bool {
        self.registration.is_young(source)
    }

    /// Whether a step of some source's errors has just misled filters.
    #[inline]
    pub fn has_misled_filters(&self) -> bool {
        self.registration.has_misled_filters()
    }

    /// Whether tracks that join nothing show a gross error of a source that is not removed.
    pub fn is_doubtful(&self, source: u16) -> bool {
        self.alignment.is_doubtful(source)
    }

    /// Number of removals of gross errors of a source: tracks of before lie elsewhere.
    #[inline]
    pub fn epoch_of(&self, source: u16) -> u8 {
        self.alignment.epoch_of(source)
    }

    /// Whether the covariances of a source show a filter that cannot be undone.
    #[inline]
    pub fn cannot_be_undone(&self, source: u16) -> bool {
        self.models[usize::from(source)].cannot_be_undone()
    }

    /// Returns whether enough targets have shown the spread of a source's detection points.
    #[inline]
    pub fn knows_spread(&self, source: u16) -> bool {
        self.models[usize::from(source)].knows_spread()
    }

    /// Whether enough targets have shown the detection points of a source that each further target matters little.
    #[inline]
    pub fn knows_spread_well(&self, source: u16) -> bool {
        self.models[usize::from(source)].knows_spread_well()
    }

    /// Variance per axis of where detection points may lie on a target, m²: configured, or learned of `source` (of all
    /// sources if `None`) if that is more.
    #[inline]
    pub fn spread_m2(&self, settings: &AssociationSettings, source: Option<u16>) -> f64 {
        let extent_m = settings.extent_sigma_m;
        let configured = extent_m * extent_m;
        match source {
            Some(source) => configured.max(self.models[usize::from(source)].possible_spread_m2()),
            None => self
                .models
                .iter()
                .map(SourceModel::possible_spread_m2)
                .fold(configured, f64::max),
        }
    }

    /// The largest spread of detection points that was learned of any source, as a variance per axis, m², of each
    /// source at most that of points of one target; at least `least_m2`.
    #[inline]
    pub fn possible_points_m2(&self, least_m2: f64) -> f64 {
        let points_m2 = |model: &SourceModel| model.spread_m2().min(model.largest_points_m2());
        self.models.iter().map(points_m2).fold(least_m2, f64::max)
    }

    /// Variance per axis of the point that a filter follows about the target's middle, m²: the mean of the sources'
    /// points, of which few tell badly how far they lie apart, or one of them if it `keeps_one`. A source's point is
    /// known relative to those of the others.
    pub(crate) fn followed_point_m2(&self, keeps_one: bool) -> f64 {
        let known = self.models.iter().filter(|model| model.knows_spread());
        let (sum_m2, count) = known.fold((0.0, 0.0), |(sum, count), model| {
            (sum + model.spread_m2().min(model.largest_points_m2()), count + 1.0)
        });
        if count < 2.0 {
            return 0.0;
        }
        let others = (count - 1.0) / count;
        let mean = others / count * (count + 1.0) / (count - 1.0);
        sum_m2 / count * if keeps_one { others * others } else { mean }
    }

    /// The points of targets that the sources see.
    #[inline]
    pub fn points(&self) -> &Points {
        &self.points
    }
}

/// Trust.
impl Sources {
    /// How a report of a target, expected at some place, is to be judged.
    #[inline]
    pub fn nearness(&self, settings: &AssociationSettings, placed: (&SensorTrack, [f64; 2])) -> Nearness {
        let least_m2 = settings.extent_sigma_m * settings.extent_sigma_m;
        if self.credibility.is_exempt(placed.0.source) {
            return Nearness::Exempt;
        }
        // A larger spread only brings the report nearer.
        if self.credibility.is_near(placed, least_m2) {
            return Nearness::Near;
        }
        let spread_m2 = learned_spread_m2(&self.models, least_m2);
        match self.credibility.is_near(placed, spread_m2) {
            true => Nearness::Near,
            false => Nearness::Far { spread_m2 },
        }
    }

    /// Judges a report by the `others` of its target.
    pub fn judge<'a, O: Iterator<Item = &'a SensorTrack>>(
        &self,
        report: &'a SensorTrack,
        spread_m2: f64,
        others: impl Fn() -> O,
    ) -> Judgement {
        self.credibility.judge(report, spread_m2, &self.clocks, others)
    }

    /// How targets with this velocity, m/s, move.
    #[inline]
    pub fn motion(&self, velocity_mps: [f64; 3]) -> &Motion {
        self.manoeuvres.motion(velocity_mps)
    }

    /// Whether a judged report may be used.
    pub fn admits(&self, judgement: &Judgement) -> bool {
        self.credibility.admits(judgement)
    }

    /// Whether there are enough sources to decide on an open judgement.
    pub fn others_can_decide(&self) -> bool {
        self.credibility.others_can_decide()
    }

    /// Whether a source is set aside, since others contradict most of its reports.
    #[inline]
    pub fn is_set_aside(&self, source: u16) -> bool {
        self.credibility.is_set_aside(source)
    }

    /// Whether any source is set aside.
    #[inline]
    pub fn sets_aside(&self) -> bool {
        self.credibility.sets_aside()
    }

    /// Whether sensors contradict so many of a self-reporting source's positions that a bias is the cause.
    pub fn is_biased(&self, source: u16) -> bool {
        self.contradicted[usize::from(source)] > SHARE_MAX
    }

    /// First source of the group of dependent sources of a source.
    #[inline]
    pub fn group_of(&self, source: u16) -> u16 {
        self.dependence.group_of(source)
    }

    /// Whether a source is a witness beside others, without errors in common.
    pub fn is_witness_beside(&self, source: u16, others: SourceSet) -> bool {
        self.dependence.is_witness_beside(source, others)
    }

    /// How many of these sources bear witness beside each other.
    pub fn witnesses_among(&self, sources: SourceSet) -> u32 {
        self.dependence.witnesses_among(sources)
    }

    /// Whether the next report of a sensor track with so many before is compared for dependence.
    #[inline]
    pub fn compares(reports: u32, period_ns: i64) -> bool {
        Dependence::compares(reports, period_ns)
    }

    /// Share of false tracks among the new tracks of a source; 0 before any.
    pub fn false_share(&self, source: u16) -> f64 {
        self.purity.false_share(source)
    }

    /// Logarithm of the odds that a new track of a source is a target; at most 0.
    #[inline]
    pub fn target_log_odds(&self, source: u16) -> f64 {
        self.purity.log_odds(source)
    }
}

/// Detection.
impl Sources {
    /// Probability that a scan of a source detects a target that the source tracks.
    #[inline]
    pub fn detection(&self, source: u16) -> f64 {
        self.models[usize::from(source)].detection
    }

    /// Probability that a source follows a target at a place; `None` if the place of the source is unknown.
    #[inline]
    pub fn follows_at(&self, source: u16, place_m: [f64; 3], now_ns: i64) -> Option<DetectionProbability> {
        let area: Option<&CoverageArea> = self.coverage.area(source.into());
        let place_m = self.moving.seen_from(source, place_m, now_ns, area)?;
        Some(self.coverage.probability(source, place_m))
    }

    /// Height less pressure altitude at a place, and the standard deviation, metres; `None` if unknown.
    pub fn pressure_offset_m(&self, place_m: [f64; 3]) -> Option<[f64; 2]> {
        self.pressure.at(place_m)
    }
}

/// Whether gross errors are looked for in a report.
#[inline]
pub(crate) fn is_aligned(settings: &Settings, report: &SensorTrack) -> bool {
    let source = &settings.sources[usize::from(report.source)];
    settings.registration.enabled && settings.sources.len() >= 2 && !source.is_centre && source.is_registered
}

/// The largest learned spread of any source, at least `least_m2`. A point of the target, taken for the middle, is as
/// far off as points are from each other.
#[inline]
fn learned_spread_m2(models: &[SourceModel], least_m2: f64) -> f64 {
    models.iter().map(SourceModel::spread_m2).fold(least_m2, f64::max)
}
