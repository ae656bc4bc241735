//! Dependent sources: a measurement received twice is a single measurement.
//!
//! A radar with tracks over two networks looks like two radars in perfect agreement. Treated as independent, they
//! confirm each other's false tracks, and the covariance of their combination is half of the right value. Two effects
//! reveal dependence:
//! - **Copies.** Two measurements of a target are never equal. A report with the time and place of another source's
//!   report is a copy; a source with mostly copies has no information of its own. The latest reports are kept in a
//!   table by time and place; later reports replace earlier reports.
//! - **Correlated errors.** Copies may have been rounded, delayed or filtered. The difference of two independent
//!   estimates of a target at the same time has the sum of the two covariances. For dependent estimates, twice the
//!   covariance of the errors is subtracted. Therefore the normalised square of the difference of coinciding reports of
//!   two sources is tracked; a mean far below 1 indicates mostly common errors. Pessimistic covariances also reduce the
//!   mean; each covariance is therefore scaled by its source's normalised innovations. Nothing is learned if both are
//!   far too pessimistic, or from standing and slow targets, on which sources agree by nature.
//!
//! Sources with a smaller part of the errors in common still share measurements, and therefore false tracks. The filter
//! uses both sources, but for the existence of a target both are a single witness.
//!
//! Sources with a still smaller common part, such as a centre with many radars including ours, cannot be distinguished
//! from good sources; the dependence must be configured.
//!
//! Dependent sources form a group; one source of the group at a time contributes to a target, as with several tracks
//! of a single source.

use association::distance::squared2;
use messages::{NS_PER_S, SensorTrack};
use serde::{Deserialize, Serialize};

use crate::settings::{SourceSet, SourceSettings};

/// Number of reports in the table.
const PLACES: usize = 4096;
/// Places are the same to so many metres, times to so many nanoseconds.
const SAME_M: f64 = 0.5;
const SAME_NS: i64 = 1_000_000;
/// Weight of a report in the share of copies, share from which a source is dependent, and share below which the
/// dependence ends.
const GAIN: f64 = 1.0 / 8.0;
const DEPENDENT: f64 = 0.5;
const INDEPENDENT: f64 = 0.2;
/// Reports of two sources coincide if their times differ by no more than so many nanoseconds.
const COINCIDENT_NS: i64 = 500_000_000;
/// Least time between two compared reports of a sensor track, nanoseconds: the errors have changed by then.
const COMPARED_EVERY_NS: i64 = 4_000_000_000;
/// Weight of a new value in means of normalised squares, and upper bound of a value.
const SQUARE_GAIN: f64 = 1.0 / 64.0;
const SQUARE_MAX: f64 = 4.0;
/// Mean normalised innovation squared below which a source's covariances are no measure: two precise sources with
/// pessimistic covariances agree better than stated. The mean of a copy is small by itself; therefore a value above
/// this limit for either source is enough.
const HONEST: f64 = 0.5;
/// Mean of normalised squares of differences below which two sources are dependent, and above which the dependence
/// ends.
const SAME_ERRORS: f64 = 0.12;
const OWN_ERRORS: f64 = 0.25;
/// Mean below which the common errors of two sources are so large that the false tracks of both are the same.
const SHARED_ERRORS: f64 = 0.65;

/// Returns the nearest whole number, ties away from 0. `f64::round` is a call on processors without an instruction for
/// rounding.
fn rounded(value: f64) -> i64 {
    let whole = value as i64;
    let rest = value - whole as f64;
    whole.saturating_add(i64::from(rest >= 0.5) - i64::from(rest <= -0.5))
}

/// Dependence of the sources on each other.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Dependence {
    recent: Vec<(u64, u16)>,
    /// Share of each source's reports that repeat reports of each other source.
    copies: Vec<f64>,
    /// Mean normalised squares of the difference of coinciding reports for each pair of sources, per axis. The first
    /// value has the second report moved to the time of the first, the second value unmoved, in case only the time
    /// stamp differs.
    differences: Vec<[f64; 2]>,
    /// Mean normalised innovation squared of each source, per axis, at most 1.
    innovations: Vec<f64>,
    /// Whether the first source may be found to depend on the second.
    may_depend: Vec<bool>,
    stated: Vec<bool>,
    learned: Vec<bool>,
    /// The first source of each source's group.
    groups: Vec<u16>,
}

impl Dependence {
    pub(crate) fn new(sources: &[SourceSettings]) -> Self {
        let count = sources.len();
        let mut new = Self {
            recent: vec![(0, u16::MAX); PLACES],
            copies: vec![0.0; count * count],
            differences: vec![[1.0; 2]; count * count],
            innovations: vec![1.0; count],
            may_depend: vec![true; count * count],
            stated: vec![false; count * count],
            learned: vec![false; count * count],
            groups: Vec::with_capacity(count),
        };
        for (number, source) in sources.iter().enumerate() {
            for other in source.independent_of.iter().map(|other| usize::from(other.number)) {
                new.may_depend[number * count + other] = false;
                new.may_depend[other * count + number] = false;
            }
            for other in source.shares.iter().map(|other| usize::from(other.number)) {
                new.stated[number * count + other] = true;
            }
        }
        new.groups.extend(0..count as u16);
        new.regroup();
        new
    }

    /// Finding on a pair of sources: share of copies, mean squares of differences, and whether the pair is dependent.
    pub(crate) fn kept(&self, place: usize) -> ((f64, [f64; 2]), bool) {
        ((self.copies[place], self.differences[place]), self.learned[place])
    }

    /// Continues with a [kept](Self::kept) finding.
    pub(crate) fn resume(&mut self, place: usize, ((copies, difference), depends): ((f64, [f64; 2]), bool)) {
        self.copies[place] = copies;
        self.differences[place] = difference;
        self.learned[place] = depends && self.may_depend[place];
        self.regroup();
    }

    /// Forgets the findings on a source and each other source.
    pub(crate) fn forget(&mut self, source: u16) {
        let (own, count) = (usize::from(source), self.groups.len());
        for other in 0..count {
            for index in [own * count + other, other * count + own] {
                (self.copies[index], self.differences[index], self.learned[index]) = (0.0, [1.0; 2], false);
            }
        }
        self.innovations[own] = 1.0;
        self.regroup();
    }

    /// Returns the group of a source: the number of its first source.
    #[inline]
    pub(crate) fn group_of(&self, source: u16) -> u16 {
        self.groups[usize::from(source)]
    }

    /// Returns the sources that depend on `source` or on which `source` depends, with the correlation of the errors, in
    /// (0, 1]: the first `N` by number. The rest of the array has a correlation of 0.
    pub(crate) fn partners<const N: usize>(&self, source: u16) -> [(u16, f64); N] {
        let (own, count) = (usize::from(source), self.groups.len());
        let mut partners = [(0, 0.0); N];
        let of_group = (0..count).filter(|other| *other != own && self.groups[*other] == self.groups[own]);
        for (place, other) in partners.iter_mut().zip(of_group) {
            let both = [own * count + other, other * count + own];
            let differences = both.iter().flat_map(|index| self.differences[*index]);
            let least = differences.fold(1.0, f64::min);
            let copied = both.iter().map(|index| self.copies[*index]).fold(0.0, f64::max);
            // A configured dependence without evidence from reports counts as complete.
            let correlation = if least < 1.0 || copied > 0.0 {
                (1.0 - least).max(copied)
            } else {
                1.0
            };
            *place = (other as u16, correlation.clamp(0.01, 1.0));
        }
        partners
    }

    /// Whether a source is an independent witness beside the sources in `others`: a source with shared
    /// errors repeats the measurements and the false tracks of the others.
    pub(crate) fn is_witness_beside(&self, source: u16, others: SourceSet) -> bool {
        let count = self.groups.len();
        let shares = |one: usize, other: usize| {
            let index = one * count + other;
            self.may_depend[index] && self.differences[index].iter().any(|mean| *mean < SHARED_ERRORS)
        };
        let own = usize::from(source);
        let mut others = others.iter().map(usize::from);
        others.all(|other| !shares(own, other) && !shares(other, own))
    }

    /// How many of the sources in `sources` bear witness beside each other.
    pub(crate) fn witnesses_among(&self, sources: SourceSet) -> u32 {
        let mut witnesses = SourceSet::EMPTY;
        for source in sources.iter() {
            if self.is_witness_beside(source, witnesses) {
                witnesses.insert(source);
            }
        }
        witnesses.count()
    }

    /// Learns from a report in the source's original form.
    pub(crate) fn learn(&mut self, report: &SensorTrack) {
        let count = self.groups.len();
        if count < 2 {
            return;
        }
        let [x, y, _] = report.position_m.map(|part| rounded(part / SAME_M) as u64);
        let time = (report.time_of_measurement_ns / SAME_NS) as u64;
        let mix = |sum: u64, part: u64| (sum ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        let key = mix(mix(mix(0, time), x), y);
        let place = &mut self.recent[(key >> 20) as usize % PLACES];
        let original = (place.0 == key && place.1 != report.source).then_some(place.1);
        *place = (key, report.source);
        let own = usize::from(report.source);
        if original.is_none() && self.copies[own * count..][..count].iter().all(|copies| *copies == 0.0) {
            return;
        }
        for other in 0..count {
            let index = own * count + other;
            let is_copy = original == Some(other as u16);
            let copies = &mut self.copies[index];
            if !is_copy && *copies == 0.0 {
                continue;
            }
            *copies += GAIN * (f64::from(u8::from(is_copy)) - *copies);
            self.judge(index);
        }
    }

    /// Learns from a normalised innovation squared of a source, per axis.
    #[inline]
    pub(crate) fn learn_innovation(&mut self, source: u16, squared: f64) {
        let mean = &mut self.innovations[usize::from(source)];
        *mean += SQUARE_GAIN * (squared.min(SQUARE_MAX) - *mean);
    }

    /// Returns whether a report of a source with this period is compared; `reports` is the number of earlier reports
    /// of its track.
    #[inline]
    pub(crate) fn compares(reports: u32, period_ns: i64) -> bool {
        let every = COMPARED_EVERY_NS
            .div_euclid(period_ns.max(1))
            .clamp(1, COMPARED_EVERY_NS);
        i64::from(reports) % every == 0
    }

    /// Learns from the latest reports of two sources on one target.
    pub(crate) fn compare(&mut self, own: &SensorTrack, other: &SensorTrack) {
        let later_ns = own.time_of_measurement_ns - other.time_of_measurement_ns;
        if later_ns.abs() > COINCIDENT_NS || own.source == other.source {
            return;
        }
        let seconds = later_ns as f64 / NS_PER_S;
        let [one, another] = [own, other].map(|report| usize::from(report.source));
        let scales = [one, another].map(|source| self.innovations[source].min(1.0));
        if scales[0].max(scales[1]) < HONEST {
            return;
        }
        let sum =
            |row, column| scales[0] * own.covariance.get(row, column) + scales[1] * other.covariance.get(row, column);
        let sums = [sum(0, 0), sum(0, 1), sum(1, 1)];
        let moved_m = |axis: usize| own.velocity_mps[axis] * COMPARED_EVERY_NS as f64 / NS_PER_S;
        if moved_m(0) * moved_m(0) + moved_m(1) * moved_m(1) < sum(0, 0) + sum(1, 1) {
            return;
        }
        let index = one * self.groups.len() + another;
        for (mean, moved_s) in self.differences[index].iter_mut().zip([seconds, 0.0]) {
            let difference =
                |axis: usize| own.position_m[axis] - other.position_m[axis] - moved_s * other.velocity_mps[axis];
            let squared = squared2([difference(0), difference(1)], sums);
            *mean += SQUARE_GAIN * ((0.5 * squared).min(SQUARE_MAX) - *mean);
        }
        self.judge(index);
    }

    /// Decides whether the two sources of a pair depend on each other.
    fn judge(&mut self, index: usize) {
        let (copies, difference) = if self.learned[index] {
            (INDEPENDENT, OWN_ERRORS)
        } else {
            (DEPENDENT, SAME_ERRORS)
        };
        let same = self.copies[index] > copies || self.differences[index].iter().any(|mean| *mean < difference);
        let depends = same && self.may_depend[index];
        if depends != self.learned[index] {
            self.learned[index] = depends;
            self.regroup();
        }
    }

    /// Finds the groups anew: sources that depend on each other, directly or through other sources.
    fn regroup(&mut self) {
        let count = self.groups.len();
        for (source, group) in self.groups.iter_mut().enumerate() {
            *group = source as u16;
        }
        for first in 0..count {
            for second in 0..count {
                let index = first * count + second;
                if self.stated[index] || self.learned[index] {
                    let [one, other] = [first, second].map(|source| self.groups[source]);
                    let joined = |group: &mut u16| {
                        *group = if *group == one.max(other) {
                            one.min(other)
                        } else {
                            *group
                        }
                    };
                    self.groups.iter_mut().for_each(joined);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::test_settings;
    use test_support::S;

    fn report(source: u16, step: u32, place_m: f64) -> SensorTrack {
        SensorTrack {
            source,
            time_of_measurement_ns: i64::from(step) * S,
            position_m: [place_m, 100.0 * f64::from(step), 0.0],
            ..SensorTrack::default()
        }
    }

    #[test]
    fn a_copy_is_recognised_within_a_few_reports_and_given_up_when_it_is_none_any_more() {
        let mut dependence = Dependence::new(&test_settings(3).sources);
        for step in 0..20 {
            for source in [0, 2, 1] {
                let error = if source == 2 { 30.0 } else { 0.0 };
                dependence.learn(&report(source, step, error));
            }
            let expected = if step < 5 { [0, 1, 2] } else { [0, 0, 2] };
            assert_eq!([0, 1, 2].map(|source| dependence.group_of(source)), expected, "{step}");
        }
        for step in 20..60 {
            for source in [0, 1] {
                dependence.learn(&report(source, step, f64::from(source) * 25.0));
            }
        }
        assert_eq!(dependence.group_of(1), 1);
    }

    #[test]
    fn numbers_are_rounded_as_by_the_library() {
        for value in [
            0.0,
            0.5,
            -0.5,
            0.49999999999999994,
            1.5,
            2.5,
            -2.5,
            4503599627370497.5,
            1e17,
            -1e300,
            f64::NAN,
        ] {
            assert_eq!(rounded(value), value.round() as i64, "{value}");
        }
    }

    #[test]
    fn what_is_stated_holds() {
        let mut settings = test_settings(4);
        settings.sources[3].shares = vec![1.into()];
        settings.sources[2].independent_of = vec![0.into()];
        let mut dependence = Dependence::new(&settings.sources);
        for step in 0..20 {
            for source in [0, 2] {
                dependence.learn(&report(source, step, 0.0));
            }
        }
        assert_eq!([0, 1, 2, 3].map(|source| dependence.group_of(source)), [0, 1, 2, 1]);
    }

    #[test]
    fn sources_with_errors_partly_in_common_bear_witness_once() {
        // Normalised squares of the differences: 1 for independent errors, 1/2 if half of the errors is common.
        for (square, witnesses) in [(1.0, 2), (0.5, 1)] {
            let mut dependence = Dependence::new(&test_settings(3).sources);
            for step in 0..300 {
                let moving = |source: u16, off_m: f64| SensorTrack {
                    velocity_mps: [0.0, 100.0, 0.0],
                    covariance: messages::Covariance::diagonal([10.0; 3], [2.0; 3]),
                    ..report(source, step, off_m)
                };
                let off_m = (2.0 * square * 200.0f64).sqrt();
                dependence.compare(&moving(1, off_m), &moving(0, 0.0));
            }
            assert_eq!(dependence.group_of(1), 1, "the filter takes both");
            assert_eq!(dependence.witnesses_among([0, 1].into_iter().collect()), witnesses);
            assert_eq!(
                dependence.witnesses_among([0, 1, 2].into_iter().collect()),
                witnesses + 1
            );
        }
    }
}
