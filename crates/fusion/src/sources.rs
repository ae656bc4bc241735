//! What is known of the sources as a whole: what they were learned to be worth, their systematic errors, and how
//! targets move.

mod changes;
mod comparison;
mod facts;

use estimation::NearlyConstantVelocity;
use messages::{NS_PER_S, SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};

use crate::alignment::Alignment;
use crate::credibility::{Credibility, Judgement};
use crate::dependence::Dependence;
use crate::detection_map::DetectionMap;
use crate::error_shape::Stretch;
use crate::lifetimes::Lifetimes;
use crate::manoeuvres::Manoeuvres;
use crate::measurement::{
    CLAIM_MAX, Content, Correction, CovarianceBasis, Measurement, UnfilteredContent, as_reported, gaussian_of,
    recovered_measurement, shows_filter, whole_report,
};
use crate::motion::Motion;
use crate::moving_sources::MovingSources;
use crate::points::Points;
use crate::pressure::PressureOffsets;
use crate::purity::Purity;
use crate::registration::{ClockError, Registration, TARGETS_MIN};
use crate::schedule::TICK_NS;
use crate::settings::{AccuracyBase, AssociationSettings, SOURCES_MAX, Settings, SourceSettings};
use crate::source_model::{MEAN_VARIANCE, SourceModel};
use crate::step_memory::StepMemory;
use crate::tracker_gain::{self, Change, GainEvidence};

pub(crate) use facts::{ComparedStates, EarlierReport, FollowedTarget, Innovation, MeanApart, StatedState};

/// Offset of a clock, seconds, that is no error beside the others.
const CLOCK_SOUND_S: f64 = 0.5;
/// Probability of steady motion from which on the shape of errors is learned.
const SHAPE_STEADY_MIN: f64 = 0.5;

/// The sources, each by its number.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Sources {
    pub(crate) models: Vec<SourceModel>,
    pub(crate) registration: Registration,
    pub(crate) alignment: Alignment,
    /// How targets manoeuvre.
    pub(crate) manoeuvres: Manoeuvres,
    pub(crate) credibility: Credibility,
    /// The points of targets that the sources see.
    pub(crate) points: Points,
    /// How long reports and tracks of the sources live.
    pub(crate) lifetimes: Lifetimes,
    pub(crate) dependence: Dependence,
    /// How many new tracks of each source turned out to be targets.
    pub(crate) purity: Purity,
    /// Where each source follows targets.
    pub(crate) coverage: DetectionMap,
    /// From where the sources that move see.
    pub(crate) moving: MovingSources,
    /// Pressure altitude and height, by region.
    pub(crate) pressure: PressureOffsets,
    /// Share of each self-reporting source's reports that measuring sensors contradict.
    contradicted: Vec<f64>,
    /// Error of each source's clock.
    clocks: Vec<ClockError>,
    /// Whether the clock of some source is taken off.
    corrects_clocks: bool,
    /// By how much covariances that show no filter are too small, as a factor.
    usual_claim: f64,
    /// Sources that were set aside at the last look, as bits.
    was_set_aside: u64,
    before_step: StepMemory,
}

/// Number of cells of the learned coverage table, and their width.
const COVERAGE_CELLS: usize = 4096;
const COVERAGE_CELL_M: f64 = 5000.0;

/// Reports after which the gains of a tracker change no more.
const OLD_REPORTS: u32 = 32;

impl Sources {
    pub(crate) fn new(settings: &Settings) -> Self {
        let count = settings.sources.len();
        let registration = &settings.registration;
        let tick_s = TICK_NS as f64 / NS_PER_S;
        Self {
            models: vec![SourceModel::default(); count],
            alignment: Alignment::new(&settings.registration, &settings.sources),
            registration: Registration::new(
                count,
                registration.reference_source.as_ref().map(|source| source.number),
                registration.memory_s,
                tick_s,
            ),
            manoeuvres: Manoeuvres::new(settings.process_noise_m2ps3),
            credibility: Credibility::new(count),
            points: Points::new(count),
            lifetimes: Lifetimes::new(&settings.life, &settings.sources),
            dependence: Dependence::new(&settings.sources),
            purity: Purity::new(count),
            coverage: DetectionMap::new(
                settings.sources.iter().map(|source| source.coverage.clone()).collect(),
                COVERAGE_CELLS,
                COVERAGE_CELL_M,
            ),
            moving: MovingSources::new(count),
            pressure: PressureOffsets::new(),
            contradicted: vec![0.0; count],
            clocks: vec![ClockError::default(); count],
            corrects_clocks: false,
            usual_claim: 1.0,
            was_set_aside: 0,
            before_step: StepMemory::new(count),
        }
    }

    /// Sets the offset of a source's clock against sound clocks, seconds; `None` if it is not known.
    pub(crate) fn set_clock(&mut self, sources: &[SourceSettings], source: u16, offset_s: Option<f64>) {
        let Some(clock) = self.clocks.get_mut(usize::from(source)) else {
            return;
        };
        // Data that are late need not have a wrong clock: they may take a period to come.
        let late_s = sources[usize::from(source)].period_ns as f64 / NS_PER_S;
        let offset_s = offset_s.unwrap_or_default();
        let excess_s = (offset_s.max(-offset_s - late_s) - CLOCK_SOUND_S).max(0.0);
        // A clock that is ahead of the receipt is wrong. One that is behind may be that of data that take long to come.
        let is_wrong = excess_s > 0.0 && (offset_s > 0.0 || clock.removed_s < 0.0);
        let removed_s = if is_wrong { offset_s } else { 0.0 };
        clock.offset_s = offset_s;
        if (removed_s - clock.removed_s).abs() > CLOCK_SOUND_S || removed_s == 0.0 {
            self.take_off_clock(source, removed_s);
        }
        let clock = &mut self.clocks[usize::from(source)];
        clock.excess_s = if clock.removed_s == 0.0 { excess_s } else { 0.0 };
    }

    /// Takes `removed_s` off the times of all reports of a source from now on.
    fn take_off_clock(&mut self, source: u16, removed_s: f64) {
        let clock = &mut self.clocks[usize::from(source)];
        if clock.removed_s != removed_s {
            (clock.removed_s, clock.excess_s) = (removed_s, 0.0);
            self.corrects_clocks = self.clocks.iter().any(|clock| clock.removed_s != 0.0);
            self.registration.forget(usize::from(source));
            self.alignment.begin_epoch(source);
        }
    }

    /// Takes off the clocks that are late by the times of receipt, where comparison with other sources shows the same.
    fn correct_late_clocks(&mut self) {
        for source in 0..self.clocks.len() as u16 {
            let clock = self.clocks[usize::from(source)];
            let known = self.registration.of(source);
            let is_late = clock.excess_s > 0.0 && clock.offset_s < 0.0;
            if is_late && known.time_offset_s() < 0.5 * clock.offset_s {
                self.take_off_clock(source, clock.offset_s);
            }
        }
    }

    /// Whether the clock of some source is taken off.
    #[inline]
    pub(crate) fn corrects_clocks(&self) -> bool {
        self.corrects_clocks
    }

    /// Whether a report of a target, expected at some place, can be used without a comparison with the others; learns
    /// that from it. With the variance per axis of where sources see a target, m², if not.
    #[inline]
    pub(crate) fn needs_comparison(
        &mut self,
        settings: &AssociationSettings,
        placed: (&SensorTrack, [f64; 2]),
    ) -> Option<f64> {
        let (source, least_m2) = (placed.0.source, settings.extent_sigma_m * settings.extent_sigma_m);
        if self.credibility.is_exempt(source) {
            return None;
        }
        // A larger spread only brings the report nearer.
        if self.credibility.is_near(placed, least_m2) {
            self.credibility.learn_nearness(source);
            return None;
        }
        let spread_m2 = learned_spread_m2(&self.models, least_m2);
        if self.credibility.is_near(placed, spread_m2) {
            self.credibility.learn_nearness(source);
            return None;
        }
        Some(spread_m2)
    }

    /// Judges a report by the `others` of its target.
    pub(crate) fn judge<'a, O: Iterator<Item = &'a SensorTrack>>(
        &self,
        report: &'a SensorTrack,
        spread_m2: f64,
        others: impl Fn() -> O,
    ) -> Judgement {
        self.credibility.judge(report, spread_m2, &self.clocks, others)
    }

    /// How targets with this velocity, m/s, move.
    #[inline]
    pub(crate) fn motion(&self, velocity_mps: [f64; 3]) -> &Motion {
        self.manoeuvres.motion(velocity_mps)
    }

    /// Returns a valid report, which came at `now_ns`, without the gross error of its source, and without the error of
    /// the source's clock; `None` if neither is taken off.
    #[inline]
    pub(crate) fn aligned(&self, settings: &Settings, report: &SensorTrack, now_ns: i64) -> Option<SensorTrack> {
        let removed_s = self.clocks[usize::from(report.source)].removed_s;
        if (removed_s == 0.0 && !self.alignment.corrects(report.source)) || !is_aligned(settings, report) {
            return None;
        }
        Some(self.without_gross_error(report, removed_s, now_ns))
    }

    /// Looks for gross errors in an aligned report, which came at `now_ns`.
    pub(crate) fn align(&mut self, settings: &Settings, report: &SensorTrack, now_ns: i64) {
        if !is_aligned(settings, report) {
            return;
        }
        let names = settings.association.use_identity.then_some(&settings.identity);
        if let Some(source) = self
            .alignment
            .take(report, now_ns, (&settings.sources, names), &self.clocks)
        {
            // What was learned from the few tracks that joined is of another source.
            self.registration.forget(usize::from(source));
        }
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

    /// Variance per axis of where detection points may lie on a target, m²: configured, or learned of `source` (of all
    /// sources if `None`) if that is more.
    pub(crate) fn spread_m2(&self, settings: &AssociationSettings, source: Option<u16>) -> f64 {
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

    /// [`learned_spread_m2`], of each source at most that of points of one target.
    pub(crate) fn possible_points_m2(&self, least_m2: f64) -> f64 {
        let points_m2 = |model: &SourceModel| model.spread_m2().min(model.largest_points_m2());
        self.models.iter().map(points_m2).fold(least_m2, f64::max)
    }

    /// Variance per axis of the point that a filter follows about the target's middle, m²: the mean of the sources'
    /// points, of which few tell badly how far they lie apart, or one of them if it `keeps_one`. A source's point is
    /// known relative to those of the others.
    fn followed_point_m2(&self, keeps_one: bool) -> f64 {
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

    /// What is left of the biases of a report's source, metres, and the variance of the biases, m²; `None` while they
    /// are not learned.
    fn bias_left(&self, sources: &[SourceSettings], report: &SensorTrack) -> Option<(f64, f64)> {
        let place_m = place_of(&sources[usize::from(report.source)]);
        self.registration
            .left(report.source, report.position_m, report.velocity_mps, place_m)
    }

    /// Distance at which two reports of one target can lie by the biases of their sources, metres: the reach of
    /// identity until both are learned.
    pub(crate) fn bias_reach_m(&self, settings: &Settings, one: &SensorTrack, other: &SensorTrack) -> f64 {
        const SIGMAS: f64 = 4.0;
        let most_m = settings.identity.reach_m;
        let left = |report| self.bias_left(&settings.sources, report);
        match (left(one), left(other)) {
            (Some(a), Some(b)) => (a.0 + b.0 + SIGMAS * (a.1 + b.1).sqrt()).min(most_m),
            _ => most_m,
        }
    }

    /// Learns which sources follow a target.
    pub(crate) fn learn_coverage(&mut self, target: &FollowedTarget) {
        let Self { coverage, moving, .. } = self;
        let [x, y, _] = target.place_m;
        let detects = |source: u16| (target.asked & (1 << source) != 0).then_some(target.follows & (1 << source) != 0);
        coverage.learn([x, y], target.existence, |source| {
            detects(source).filter(|_| !moving.moves(source))
        });
        for source in (0..self.models.len() as u16).filter(|source| moving.moves(*source)) {
            let area = coverage.area(source.into());
            if let Some([x, y, _]) = moving.seen_from(source, target.place_m, target.time_ns, area) {
                coverage.learn([x, y], target.existence, |asked| {
                    detects(asked).filter(|_| asked == source)
                });
            }
        }
    }

    /// Whether the next report of a sensor track with so many before is compared for dependence.
    #[inline]
    pub(crate) fn compares(reports: u32, period_ns: i64) -> bool {
        Dependence::compares(reports, period_ns)
    }

    /// Share of the reports of a self-reporting source that measuring sensors contradict.
    pub(crate) fn contradicted_share(&mut self, source: u16) -> &mut f64 {
        &mut self.contradicted[usize::from(source)]
    }

    /// The known errors of a report.
    pub(crate) fn correction_of(&self, sources: &[SourceSettings], report: &SensorTrack) -> Correction {
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

    /// Writes the content of a report that follows a sensor track's latest report, `earlier`, that many seconds later,
    /// into an empty one. A track without an earlier report `goes_on` if it had some before a restart. Learns how the
    /// source filters, unless the report's covariance had to be repaired.
    #[inline]
    pub(crate) fn read_content(
        &mut self,
        report: &SensorTrack,
        (earlier, goes_on): (Option<(&EarlierReport<'_>, f64)>, bool),
        repaired: bool,
        content: &mut Content,
    ) {
        let model = &mut self.models[usize::from(report.source)];
        let known = earlier.filter(|(_, seconds)| *seconds > 0.0);
        if let Some((earlier, seconds)) = known {
            let (looks, knows) = (!repaired && model.looks_at_noise(), model.process_noise().is_some());
            if looks || knows {
                let has_height = report.has(sensor_track_bits::HEIGHT);
                let (before, after) = (earlier.stated.as_stated(), gaussian_of(report));
                if looks {
                    model.learn_noise(&before.covariance, &after.covariance, seconds, has_height);
                }
                if let Some(noise) = model.process_noise() {
                    let predicted = noise.predicted(&before, seconds);
                    content.measurement = recovered_measurement(&predicted, &after, has_height);
                    return;
                }
            }
        }
        content.measurement = Some(as_reported(report));
        let is_hopeless = model.gain().is_hopeless();
        if is_hopeless && !tracker_gain::teaches(report.track_number, report.time_of_measurement_ns) {
            return;
        }
        if !repaired && !shows_filter(&report.covariance) {
            self.read_unfiltered(report, (known, goes_on), content);
        }
    }

    /// The content of a report whose covariance shows no filter.
    #[inline(never)]
    fn read_unfiltered(
        &mut self,
        report: &SensorTrack,
        (earlier, goes_on): (Option<(&EarlierReport<'_>, f64)>, bool),
        content: &mut Content,
    ) {
        let mut evidence = earlier.map_or(GainEvidence::NONE, |(before, _)| *before.evidence);
        if goes_on {
            evidence.grow_to(OLD_REPORTS);
        }
        if let Some((before, _)) = earlier
            && self.models[usize::from(report.source)].gain().is_hopeless()
        {
            evidence.grow_to(before.reports);
        }
        let measurement = &mut content.measurement;
        let unfiltered = content.unfiltered.insert(UnfilteredContent::stated(evidence));
        match earlier {
            Some(earlier) => self.undo_tracker(report, earlier, (measurement, unfiltered)),
            None => {
                unfiltered.covariance = self.models[usize::from(report.source)].first_covariance(&report.covariance);
                if unfiltered.covariance.is_some() {
                    unfiltered.basis = CovarianceBasis::Gain;
                }
            }
        }
        self.doubt(report, (measurement, unfiltered));
    }

    /// Takes the covariance of a report for as wrong as those of the sources that are known, while the report's own
    /// source is not.
    fn doubt(
        &self,
        report: &SensorTrack,
        (measurement, unfiltered): (&mut Option<Measurement>, &mut UnfilteredContent),
    ) {
        if self.usual_claim <= 1.0
            || unfiltered.covariance.is_some()
            || !self.models[usize::from(report.source)].is_open()
        {
            return;
        }
        let mut covariance = report.covariance;
        covariance.upper.iter_mut().for_each(|value| *value *= self.usual_claim);
        unfiltered.covariance = Some(covariance);
        unfiltered.basis = CovarianceBasis::Doubted;
        if let Some(measurement) = measurement {
            let values = measurement.covariance_m2.iter_mut();
            values.for_each(|value| *value *= self.usual_claim);
        }
    }

    /// Learns by how much covariances without a filter are too small: the mean over the sources that are known.
    fn look_at_claims(&mut self) {
        let (sum, count) = self
            .models
            .iter()
            .filter_map(SourceModel::claim)
            .fold((0.0, 0.0), |(sum, count), claim| (sum + claim, count + 1.0));
        self.usual_claim = if count > 0.0 {
            (sum / count).clamp(1.0, CLAIM_MAX)
        } else {
            1.0
        };
    }

    /// The content of a report whose covariance shows no filter, if its source's tracker can be undone.
    fn undo_tracker(
        &mut self,
        report: &SensorTrack,
        (earlier, seconds): (&EarlierReport<'_>, f64),
        (measurement, unfiltered): (&mut Option<Measurement>, &mut UnfilteredContent),
    ) {
        if report.has_assumed_velocity() || earlier.stated.report.has_assumed_velocity() {
            return;
        }
        let before_m = earlier.stated.stated_m();
        let before_mps = earlier.stated.report.velocity_mps;
        let change = Change {
            position_m: std::array::from_fn(|axis| {
                report.position_m[axis] - before_m[axis] - before_mps[axis] * seconds
            }),
            velocity_mps: std::array::from_fn(|axis| report.velocity_mps[axis] - before_mps[axis]),
            seconds,
            has_height: report.has(sensor_track_bits::HEIGHT) && earlier.stated.report.has(sensor_track_bits::HEIGHT),
        };
        let model = &mut self.models[usize::from(report.source)];
        let Some(undone) = model.undo(&mut unfiltered.evidence, &change, &report.covariance) else {
            return;
        };
        unfiltered.covariance = Some(undone.covariance);
        unfiltered.basis = CovarianceBasis::Gain;
        *measurement = undone.measurement.map(|(innovation_m, covariance_m2)| Measurement {
            position_m: std::array::from_fn(|axis| {
                report.position_m[axis] - change.position_m[axis] + innovation_m[axis]
            }),
            covariance_m2,
            ..whole_report(report)
        });
    }

    /// Learns from an innovation how true its source's covariances are, where its detection points lie, whether its
    /// errors change, and how targets move.
    pub(crate) fn learn_innovation(&mut self, settings: &Settings, shown: &Innovation<'_>) {
        let Innovation { source, innovation, .. } = *shown;
        let index = usize::from(source);
        self.dependence.learn_innovation(source, 0.5 * shown.nis);
        if let Some(velocity_mps) = shown.moves_mps {
            self.manoeuvres.learn(velocity_mps, innovation);
        }
        let Some(about_mean_m) = shown.about_mean_m else {
            return;
        };
        let (target_m, target_mps) = (shown.report.position_m, shown.report.velocity_mps);
        if settings.registration.enabled && shown.shows_errors {
            self.registration.add_innovation(
                index,
                (innovation.residual_m, innovation.covariance_m2),
                (shown.target, [target_m[0], target_m[1]], target_mps),
            );
        }
        let squared = association::distance::squared2(about_mean_m, innovation.covariance_m2);
        if settings.consistency && squared.is_finite() && shown.shows_accuracy {
            self.models[index].learn_consistency(squared / (1.0 + MEAN_VARIANCE));
            // A turn that the filter does not follow yet has a shape of its own.
            if shown.steadiness > SHAPE_STEADY_MIN
                && let Some(place_m) = place_of(&settings.sources[index])
            {
                let shape = &mut self.models[index].shape;
                shape.learn(about_mean_m, innovation.covariance_m2, (target_m, place_m));
            }
        }
        if let Some(apart) = &shown.apart {
            self.models[index].learn_spread(apart.offset_m, 2.0 * apart.noise_m2, apart.measured_m2, apart.size_m);
        }
    }

    /// Learns from a measurement that is not used since others contradict it: a step of its source's errors. It lies
    /// `residual_m` from `place_m`, where its target is.
    pub(crate) fn learn_contradiction(
        &mut self,
        (source, velocity_mps): (u16, [f64; 3]),
        residual: ([f64; 2], [f64; 3]),
        (target, place_m): (u32, [f64; 2]),
    ) {
        // A source that others contradict all the time does not change.
        if !self.credibility.is_set_aside(source) {
            self.registration
                .add_innovation(usize::from(source), residual, (target, place_m, velocity_mps));
        }
    }

    /// Continues the estimate of the systematic errors, or begins a new one if it is `due`. `largest_m` is the size of
    /// a target of unknown type; `confirmed` targets are followed now. Long work is spread over the calls. A source
    /// whose estimate had to be dropped is passed to `restarted`.
    pub(crate) fn register(&mut self, due: bool, largest_m: f64, confirmed: usize, mut restarted: impl FnMut(u16)) {
        let sees_points = self.points.sees_points();
        if due {
            self.begin_anew_where_set_aside(&mut restarted);
            if sees_points {
                self.registration.pass_over_innovations();
            }
            let knows_spread = self.models.iter().all(SourceModel::knows_spread);
            let points_m2 = match knows_spread {
                true => self.possible_points_m2(0.0),
                false => 0.25 * largest_m * largest_m,
            };
            self.registration.begin((largest_m, points_m2), &mut restarted);
            self.credibility.pass_over(self.registration.with_known_steps());
            self.before_step.look(&self.models, &mut self.manoeuvres);
            if self.registration.takes_step() {
                self.before_step.restore(&mut self.models, &mut self.manoeuvres);
            }
        }
        if !self.registration.is_solving() || !self.registration.step(&self.clocks, restarted) {
            return;
        }
        self.correct_late_clocks();
        // The distances of a source's points from the others' are those of the others' points from its. The offset of
        // few targets may be that of wrong joins, and offsets beside a source that is set aside may be due to that
        // source.
        let learned_m2 = self.possible_points_m2(0.0);
        let largest_m2 = 0.25 * largest_m * largest_m;
        let decides_early = confirmed >= TARGETS_MIN && !self.credibility.sets_aside();
        let spread_m2 = |source: usize| match self.models[source].knows_spread() {
            true => Some(learned_m2),
            false => decides_early.then_some(largest_m2),
        };
        let before = self.registration.removing();
        self.registration
            .decide(&self.clocks, spread_m2, confirmed, sees_points);
        self.trust_found(before);
    }

    /// Looks whether the sources see different points of targets, of which a rule may keep one.
    pub(crate) fn look_at_points(&mut self, may_keep: bool) {
        let apart_m2 = self.possible_points_m2(0.0);
        let followed_m2 = [false, true].map(|keeps_one| self.followed_point_m2(keeps_one));
        self.points.look(&self.models, followed_m2, (may_keep, apart_m2));
    }

    /// Variance per axis of errors that no measurement shows, m²: of the point that filters follow, and of errors that
    /// the sources have in common.
    pub(crate) fn common_error_m2(&self) -> f64 {
        self.points.spread_m2() + self.registration.common_error_m2()
    }

    /// Takes over how the sources' own trackers let their targets move: the median of what they assume.
    pub(crate) fn look_at_motion(&mut self) {
        self.look_at_claims();
        let mut known = [NearlyConstantVelocity::new(0.0, 0.0); SOURCES_MAX];
        let mut count = 0;
        for motion in self.models.iter().filter_map(SourceModel::process_noise) {
            known[count] = motion;
            count += 1;
        }
        if count == 0 {
            return;
        }
        let known = &mut known[..count];
        known.sort_unstable_by(|a, b| a.density_m2ps3[0].total_cmp(&b.density_m2ps3[0]));
        self.manoeuvres.assume(known[count / 2]);
    }
}

/// Whether gross errors are looked for in a report.
#[inline]
fn is_aligned(settings: &Settings, report: &SensorTrack) -> bool {
    let source = &settings.sources[usize::from(report.source)];
    settings.registration.enabled && settings.sources.len() >= 2 && !source.is_centre && source.is_registered
}

/// The largest spread that was learned of any source, at least `least_m2`. One of several points, taken for the
/// target's middle, is as far off as they are from each other.
fn learned_spread_m2(models: &[SourceModel], least_m2: f64) -> f64 {
    models.iter().map(SourceModel::spread_m2).fold(least_m2, f64::max)
}

/// Where a source that measures range and azimuth stands, metres; `None` for others.
pub(crate) fn place_of(source: &SourceSettings) -> Option<[f64; 2]> {
    source.place_m.or(match source.accuracy.base {
        AccuracyBase::Polar { place_m, .. } => Some(place_m),
        _ => None,
    })
}
