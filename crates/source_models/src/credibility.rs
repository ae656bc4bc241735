//! Credibility: a contradictory source is set aside before any effect on a track.
//!
//! A source may be wrong within all limits: a clock offset of some seconds, or a bias of 300 m with a high stated
//! accuracy. A filter trusts covariances, so such a source moves every track. Learned corrections (registration,
//! covariance scaling) take half a minute; until then the tracks are wrong. But other sources observe the same targets.
//! Of three sources on a target, if two agree and the third contradicts both, the third is wrong. Of two sources, the
//! source with a clock offset relative to the times of receipt is wrong.
//!
//! Therefore each report far from its track is compared with the latest reports of the other sources on this target. A
//! contradicted report is not used. The share of contradicted reports of each source is tracked. A source with mostly
//! contradicted reports is *set aside*: until its reports agree again, the source contributes to no track with other
//! contributors. A misled filter restarts from the reports of the other sources. Registration continues its
//! comparisons, so a constant bias is found and removed, and the source returns.
//!
//! Of two contradictory tracks joined only by a code or call sign, a single track is used until a third source decides
//! or the bias between the two sources is known.
//!
//! Limits: two other sources with sound clocks and contradictory reports are both used, as are two pairs with agreement
//! inside each pair. Differences below some five standard deviations are left to registration.

use association::distance::{Symmetric2, squared2};
use messages::{NS_PER_S, SensorTrack};
use serde::{Deserialize, Serialize};

use crate::registration::ClockError;
use crate::settings::SourceSet;

/// d² in the plane up to which two reports of a target agree: beyond in 0.3 % by chance.
pub const AGREES: f64 = 12.0;
/// d² in the plane beyond which two reports contradict each other: in 3 of ten million by chance.
pub const CONTRADICTS: f64 = 30.0;
/// Unpredictable acceleration between two reports, metres per second squared.
const ACCELERATION_MPS2: f64 = 5.0;
/// Number of comparisons of a source before its share counts, and least weight of a new comparison.
const SAMPLES_MIN: u32 = 3;
const GAIN_MIN: f64 = 1.0 / 32.0;
/// Share of contradicted reports from which a source is set aside, and share below which the source returns.
const SET_ASIDE_FROM: f64 = 0.5;
const SET_ASIDE_UNTIL: f64 = 0.2;
/// Difference of clock offsets, seconds, that identifies the wrong source of two.
const CLOCK_WORSE_S: f64 = 0.5;

/// Record of a source.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct SourceRecord {
    /// Share of contradicted reports among the compared reports, weighted towards the latest.
    share: f64,
    samples: u32,
    is_set_aside: bool,
}

/// Credibility of all sources.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Credibility {
    sources: Vec<SourceRecord>,
    /// Sources that are set aside.
    set_aside: SourceSet,
    /// Sources that are not compared.
    passed_over: SourceSet,
}

/// Judgement of a report by the others of the same target.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    source: u16,
    standing: Standing,
    /// Other sources found wrong, and all compared sources.
    wrong: SourceSet,
    others: SourceSet,
}

impl Judgement {
    /// Whether the judgement of the report is open.
    pub fn is_open(&self) -> bool {
        self.standing == Standing::Open
    }
}

/// Result of the comparison of a report with other sources' reports of the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// Others agree, or there are no others.
    Holds,
    /// The report is wrong.
    Contradicted,
    /// Undecided.
    Open,
}

impl Credibility {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            sources: vec![SourceRecord::default(); sources],
            set_aside: SourceSet::EMPTY,
            passed_over: SourceSet::EMPTY,
        }
    }

    /// Forgets the standing of a source.
    pub(crate) fn reset(&mut self, source: u16) {
        self.sources[usize::from(source)] = SourceRecord::default();
        self.set_aside.remove(source);
    }

    /// Whether a source is set aside.
    #[inline]
    pub(crate) fn is_set_aside(&self, source: u16) -> bool {
        self.set_aside.contains(source)
    }

    /// Excludes these sources from comparison: after a step of the error their states lag, their measurements
    /// do not.
    pub(crate) fn pass_over(&mut self, sources: SourceSet) {
        for source in sources.without(self.passed_over).iter() {
            self.reset(source);
        }
        self.passed_over = sources;
    }

    #[inline]
    fn is_passed_over(&self, source: u16) -> bool {
        self.passed_over.contains(source)
    }

    /// Returns the sources that are set aside.
    pub(crate) fn all_set_aside(&self) -> SourceSet {
        self.set_aside
    }

    /// Returns whether any source is set aside.
    #[inline]
    pub(crate) fn sets_aside(&self) -> bool {
        !self.set_aside.is_empty()
    }

    /// Whether a report is near enough to the expected `place_m` of the target to need no comparison. `spread_m2` is
    /// the variance per axis of the detection points on a target. With any source set aside, sources are compared
    /// anyway.
    #[inline]
    pub(crate) fn is_near(&self, (report, place_m): (&SensorTrack, [f64; 2]), spread_m2: f64) -> bool {
        self.set_aside.is_empty() && distance_from(place_m, report, spread_m2) <= AGREES
    }

    /// Whether reports of this source are used without a comparison.
    #[inline]
    pub(crate) fn is_exempt(&self, source: u16) -> bool {
        !self.passed_over.is_empty() && self.is_passed_over(source)
    }

    /// Learns from a report without need of a comparison.
    #[inline]
    pub(crate) fn learn_nearness(&mut self, source: u16) {
        self.sources[usize::from(source)].learn(false);
    }

    /// Judges a report far from its track, or any report while a source is set aside, by the `others`, the latest
    /// reports of other sources on the target.
    #[cold]
    pub(crate) fn judge<'a, O: Iterator<Item = &'a SensorTrack>>(
        &self,
        report: &'a SensorTrack,
        spread_m2: f64,
        clocks: &[ClockError],
        all_others: impl Fn() -> O,
    ) -> Judgement {
        let passed_over = self.passed_over;
        let others = || all_others().filter(move |other| !passed_over.contains(other.source));
        let distance = |other: &SensorTrack| apart(report, other, spread_m2);
        let mut judgement = Judgement {
            source: report.source,
            standing: Standing::Holds,
            wrong: SourceSet::EMPTY,
            others: others().map(|other| other.source).collect(),
        };
        let (mut agreeing, mut against, mut one_against) = (0u32, 0u32, None);
        for other in others() {
            let d2 = distance(other);
            agreeing += u32::from(d2 <= AGREES);
            if d2 > CONTRADICTS {
                against += 1;
                one_against = one_against.or(Some(other));
            }
        }
        let is_worse = |one: u16, other: u16| {
            clocks[usize::from(one)].excess_s > clocks[usize::from(other)].excess_s + CLOCK_WORSE_S
        };
        if let Some(first) = one_against {
            let agrees_with_first = |other: &&SensorTrack| apart(first, other, spread_m2) <= AGREES;
            let united = others()
                .filter(|other| distance(other) > CONTRADICTS)
                .filter(agrees_with_first)
                .count() as u32;
            let is_outvoted = united >= 2 || (against == 1 && is_worse(report.source, first.source));
            judgement.standing = if agreeing + 1 > against {
                Standing::Holds
            } else if agreeing == 0 && is_outvoted {
                Standing::Contradicted
            } else {
                Standing::Open
            };
        }
        if judgement.standing == Standing::Holds {
            // Sources contradicted by the majority are wrong, though their own reports may be near the misled track; a
            // source with a wrong clock is wrong, too.
            let majority = agreeing >= 1;
            let wrong = others()
                .filter(|other| distance(other) > CONTRADICTS && (majority || is_worse(other.source, report.source)));
            judgement.wrong = wrong.map(|other| other.source).collect();
        }
        judgement
    }

    /// Whether a report joined by name alone yields to a contradictory report if neither can be found wrong. With two
    /// sources alone, neither would ever be found wrong, and the unused source would no longer refute false tracks.
    #[inline]
    pub(crate) fn others_can_decide(&self) -> bool {
        self.sources.len() > 2
    }

    /// Learns from a judgement.
    pub(crate) fn learn_judgement(&mut self, judgement: &Judgement) {
        for other in judgement.wrong.iter() {
            self.learn(other, true);
        }
        if judgement.standing != Standing::Open {
            self.learn(judgement.source, judgement.standing == Standing::Contradicted);
        }
    }

    /// Whether a judged report may be used: the report is not wrong, and its source is not set aside beside others.
    pub(crate) fn admits(&self, judgement: &Judgement) -> bool {
        let is_alone = judgement.others.without(self.set_aside).is_empty();
        judgement.standing != Standing::Contradicted && (!self.is_set_aside(judgement.source) || is_alone)
    }

    fn learn(&mut self, source: u16, contradicted: bool) {
        let record = &mut self.sources[usize::from(source)];
        record.learn(contradicted);
        let limit = if record.is_set_aside {
            SET_ASIDE_UNTIL
        } else {
            SET_ASIDE_FROM
        };
        record.is_set_aside = record.samples >= SAMPLES_MIN && record.share >= limit;
        match record.is_set_aside {
            true => self.set_aside.insert(source),
            false => self.set_aside.remove(source),
        }
    }
}

impl SourceRecord {
    #[inline]
    fn learn(&mut self, contradicted: bool) {
        self.samples = self.samples.saturating_add(1);
        // Nearly always.
        if !contradicted && self.share == 0.0 {
            return;
        }
        let gain = (1.0 / f64::from(self.samples)).max(GAIN_MIN);
        self.share += gain * (f64::from(u8::from(contradicted)) - self.share);
    }
}

/// d² in the plane of a report from the expected place of the target, by the report's covariance alone.
#[inline]
pub fn distance_from(place_m: [f64; 2], report: &SensorTrack, spread_m2: f64) -> f64 {
    let apart = [report.position_m[0] - place_m[0], report.position_m[1] - place_m[1]];
    let own = |row, column| report.covariance.get(row, column);
    squared2(apart, [own(0, 0) + spread_m2, own(0, 1), own(1, 1) + spread_m2])
}

/// d² of two reports of a target at the time of the first report.
pub fn apart(report: &SensorTrack, other: &SensorTrack, spread_m2: f64) -> f64 {
    let seconds = (report.time_of_measurement_ns - other.time_of_measurement_ns) as f64 / NS_PER_S;
    let unforeseen_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
    let (own, of_other) = (&report.covariance, &other.covariance);
    let part = |row: usize, column: usize| {
        let carried = of_other.get(row, column)
            + seconds * (of_other.get(row, column + 3) + of_other.get(column, row + 3))
            + seconds * seconds * of_other.get(row + 3, column + 3);
        own.get(row, column) + carried
    };
    let extra_m2 = 2.0 * spread_m2 + unforeseen_m * unforeseen_m;
    let covariance: Symmetric2 = [part(0, 0) + extra_m2, part(0, 1), part(1, 1) + extra_m2];
    let difference = std::array::from_fn(|axis| {
        let carried = other.position_m[axis] + seconds * other.velocity_mps[axis];
        report.position_m[axis] - carried
    });
    squared2(difference, covariance)
}
