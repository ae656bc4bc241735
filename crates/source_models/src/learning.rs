//! How the models learn: from facts, where these arise, and from the time that passes.

use estimation::NearlyConstantVelocity;
use messages::{NS_PER_S, SensorTrack};

use crate::TICK_NS;
use crate::facts::{Fact, FollowedTarget, Innovation, InnovationFact, PairFact, ReportFact, TargetFact};
use crate::knowledge::is_aligned;
use crate::measurement::CLAIM_MAX;
use crate::registration::TARGETS_MIN;
use crate::settings::{Settings, SourceSettings};
use crate::source_model::{MEAN_VARIANCE, SourceModel};
use crate::sources::{Sources, place_of};
use crate::stamps::{self, Stamps};

/// Probability of steady motion from which on the shape of errors is learned.
const SHAPE_STEADY_MIN: f64 = 0.5;
/// Weight of one report in the share of contradicted reports of a source.
const SHARE_GAIN: f64 = 1.0 / 64.0;

impl Sources {
    /// Learns from a fact. The order of facts counts: the next read of the models already reflects this fact.
    #[inline(always)]
    pub fn learn(&mut self, settings: &Settings, fact: Fact<'_>) {
        match fact {
            Fact::Report(fact) => self.learn_report(settings, fact),
            Fact::Innovation(InnovationFact::Used(shown)) => self.learn_innovation(settings, &shown),
            Fact::Innovation(InnovationFact::Contradicted {
                source,
                target,
                place_m,
                velocity_mps,
                residual,
            }) => self.learn_contradiction((source, velocity_mps), residual, (target, place_m)),
            Fact::Innovation(InnovationFact::Leapt {
                source,
                time_ns,
                targets,
            }) => self.points.learn_leap(source, time_ns, targets),
            Fact::Pair(fact) => self.learn_pair(settings, fact),
            Fact::Scan { source, is_detected } => self.models[usize::from(source)].learn_detection(is_detected),
            Fact::Target(TargetFact::Followed(target)) => self.learn_coverage(&target),
            Fact::Target(TargetFact::Proved { source, is_target }) => self.purity.learn(source, is_target),
            Fact::Order { source } => self.begin_anew(source),
        }
    }

    #[inline(always)]
    fn learn_report(&mut self, settings: &Settings, fact: ReportFact<'_>) {
        match fact {
            ReportFact::Came { report, now_ns } => self.align(settings, report, now_ns),
            ReportFact::Stamped { source, time_ns } => {
                self.sampling.count(source);
                self.stamps[usize::from(source)].learn(time_ns);
            }
            ReportFact::Late { source, late_ns } => self.lifetimes.learn_lateness(source, late_ns),
            ReportFact::Original(report) => self.dependence.learn(report),
            ReportFact::Timed {
                source,
                time_ns,
                is_first,
            } => self.lifetimes.restarts.take(source, time_ns, is_first),
            ReportFact::Follows {
                source,
                time_ns,
                since_ns,
            } => {
                self.lifetimes.learn(source, time_ns, since_ns);
                self.stamps[usize::from(source)].follow(since_ns.unwrap_or_default());
            }
            ReportFact::Gap { source, gap_ns } => self.lifetimes.learn_gap(source, gap_ns),
            ReportFact::Pressure(report) => {
                let offset_m = f64::from(report.pressure_offset_m);
                self.pressure.learn(report.position_m, offset_m);
            }
        }
    }

    #[inline(always)]
    fn learn_pair(&mut self, settings: &Settings, fact: PairFact<'_>) {
        match fact {
            PairFact::States(states) => self.compare(settings, &states),
            PairFact::Reports(own, other) => self.dependence.compare(own, other),
            PairFact::Near { source } => self.credibility.learn_nearness(source),
            PairFact::Judged(judgement) => self.credibility.learn_judgement(judgement),
            PairFact::Verified {
                source,
                is_contradicted,
            } => {
                let share = &mut self.contradicted[usize::from(source)];
                *share += SHARE_GAIN * (f64::from(u8::from(is_contradicted)) - *share);
            }
        }
    }

    /// Forgets all that was learned of a source.
    fn begin_anew(&mut self, source: u16) {
        let index = usize::from(source);
        self.models[index] = SourceModel::default();
        self.registration.forget(index);
        self.alignment.reset(source);
        self.credibility.reset(source);
        self.coverage.forget(index);
        *self.purity.tally_mut(index) = Default::default();
        self.dependence.forget(source);
        self.stamps[index] = Stamps::default();
    }

    /// Notes where the source of an aligned report, which came at `now_ns`, stands, and looks for gross errors.
    fn align(&mut self, settings: &Settings, report: &SensorTrack, now_ns: i64) {
        self.moving.note(report);
        if !is_aligned(settings, report) {
            return;
        }
        let names = settings.association.use_identity.then_some(&settings.identity);
        if let Some(source) = self
            .alignment
            .take(report, now_ns, (&settings.sources, names), &self.clocks)
        {
            // Estimates from the few joined tracks no longer hold.
            self.registration.forget(usize::from(source));
        }
    }

    /// Learns which sources follow a target.
    fn learn_coverage(&mut self, target: &FollowedTarget) {
        let Self { coverage, moving, .. } = self;
        let [x, y, _] = target.place_m;
        let detects = |source: u16| target.asked.contains(source).then_some(target.follows.contains(source));
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

    /// Learns from an innovation how true its source's covariances are, where its detection points lie, whether its
    /// errors change, and how targets move.
    fn learn_innovation(&mut self, settings: &Settings, shown: &Innovation<'_>) {
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
        if let Some(apart) = &shown.height {
            self.models[index].heights.learn(apart);
        }
    }

    /// Learns from a measurement that other sources contradict: evidence of a step of the source's errors. The
    /// measurement lies `residual` from `place_m`, the place of the target.
    fn learn_contradiction(
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

    /// Continues the estimate of the systematic errors, or begins a new one if it is `due`. `largest_m` is the size of
    /// a target of unknown type; `confirmed` targets are followed now. Long work is spread over the calls. A source
    /// whose estimate had to be dropped is passed to `restarted`.
    pub fn register(&mut self, due: bool, largest_m: f64, confirmed: usize, mut restarted: impl FnMut(u16)) {
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
        // The distances between the points of two sources are the same from either side. The offset of
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

    /// Whether an estimate of the systematic errors is in work.
    #[inline]
    pub fn is_solving(&self) -> bool {
        self.registration.is_solving()
    }

    /// Takes a tick of time: looks at points, motion and periods. Settings follow the learned periods; a rule may keep
    /// a single point of each target. Returns whether a period has changed.
    pub fn tick(&mut self, settings: &mut Settings, now_ns: i64, may_keep_points: bool) -> bool {
        self.sampling.tick(TICK_NS as f64 / NS_PER_S);
        self.look_at_points(may_keep_points);
        self.has_slow_heights = self.models.iter().any(|model| model.heights.variance_m2() > 0.0);
        self.look_at_motion();
        self.look_at_stamps(&settings.sources);
        self.lifetimes.follow(&settings.life, &mut settings.sources, now_ns)
    }

    /// Looks whether the sources see different points of targets, of which a rule may keep one.
    fn look_at_points(&mut self, may_keep: bool) {
        let apart_m2 = self.possible_points_m2(0.0);
        let followed_m2 = [false, true].map(|keeps_one| self.followed_point_m2(keeps_one));
        self.points.look(&self.models, followed_m2, (may_keep, apart_m2));
    }

    /// Looks which sources have coarse clocks, and passes the time offsets that the stamps imply to the registration.
    fn look_at_stamps(&mut self, sources: &[SourceSettings]) {
        let were_coarse = self.has_coarse_stamps;
        self.has_coarse_stamps = stamps::look(&mut self.stamps, sources);
        if were_coarse || self.has_coarse_stamps {
            for (index, (stamps, source)) in self.stamps.iter().zip(sources).enumerate() {
                self.registration.set_stamps(index, stamps.error(source.stamps));
            }
        }
    }

    /// Takes over the process noise of the sources' own trackers: the median over the trackers.
    fn look_at_motion(&mut self) {
        self.look_at_claims();
        let known = || self.models.iter().filter_map(SourceModel::process_noise);
        let order =
            |a: &NearlyConstantVelocity, b: &NearlyConstantVelocity| a.density_m2ps3[0].total_cmp(&b.density_m2ps3[0]);
        let middle = known().count() / 2;
        let is_middle = |motion: &NearlyConstantVelocity| {
            let less = known().filter(|other| order(other, motion).is_lt()).count();
            let equal = known().filter(|other| order(other, motion).is_eq()).count();
            (less..less + equal).contains(&middle)
        };
        if let Some(motion) = known().find(is_middle) {
            self.manoeuvres.assume(motion);
        }
    }
}
