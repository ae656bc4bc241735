//! Sources that say the same: one measurement that is heard twice is no second witness.
//!
//! A radar whose tracks come over two networks looks like two radars that agree perfectly. Believed, they confirm each
//! other's false tracks, and the covariance of what they say together is half of what it should be. Two measurements of
//! one target are never the same; so a report that repeats the time and the place of another source's is a copy, and
//! where most of a source's reports are, the source says nothing of its own. Sources that share something otherwise,
//! like a centre that has made its tracks from ours, cannot be recognised so; the configuration says it of them.
//!
//! Dependent sources are a group, in which one at a time speaks of a target: as of several tracks of one source.
//!
//! The latest reports are kept in a table by time and place, in which later ones take the place of earlier ones.

use messages::SensorTrack;
use serde::{Deserialize, Serialize};

use crate::settings::Settings;

/// Reports that are remembered.
const PLACES: usize = 4096;
/// Places are the same to so many metres, times to so many nanoseconds.
const SAME_M: f64 = 0.5;
const SAME_NS: i64 = 1_000_000;
/// Weight of a report in the share of copies, the share from which a source is dependent, and that below which it is
/// not any more.
const GAIN: f64 = 1.0 / 8.0;
const DEPENDENT: f64 = 0.5;
const INDEPENDENT: f64 = 0.2;

/// Dependence of the sources on each other.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Dependence {
    recent: Vec<(u64, u16)>,
    /// Share of each source's reports that repeat those of each other source.
    copies: Vec<f64>,
    /// Whether the first source may be found to depend on the second.
    may_depend: Vec<bool>,
    stated: Vec<bool>,
    learned: Vec<bool>,
    /// The first source of each one's group.
    groups: Vec<u16>,
}

impl Dependence {
    pub(crate) fn new(settings: &Settings) -> Self {
        let count = settings.sources.len();
        let mut new = Self {
            recent: vec![(0, u16::MAX); PLACES],
            copies: vec![0.0; count * count],
            may_depend: vec![true; count * count],
            stated: vec![false; count * count],
            learned: vec![false; count * count],
            groups: Vec::with_capacity(count),
        };
        for (number, source) in settings.sources.iter().enumerate() {
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

    /// Finding on two sources, by the place of their pair: the share of copies, and whether that makes them dependent.
    pub(crate) fn kept(&self, place: usize) -> (f64, bool) {
        (self.copies[place], self.learned[place])
    }

    /// Goes on with a finding that was [kept](Self::kept).
    pub(crate) fn resume(&mut self, place: usize, (copies, depends): (f64, bool)) {
        self.copies[place] = copies;
        self.learned[place] = depends && self.may_depend[place];
        self.regroup();
    }

    /// The group of a source: the number of its first one.
    pub(crate) fn group_of(&self, source: u16) -> u16 {
        self.groups[usize::from(source)]
    }

    /// Learns from a report as its source gave it.
    pub(crate) fn learn(&mut self, report: &SensorTrack) {
        let count = self.groups.len();
        if count < 2 {
            return;
        }
        let [x, y, _] = report.position_m.map(|part| (part / SAME_M).round() as i64 as u64);
        let time = (report.time_of_measurement_ns / SAME_NS) as u64;
        let mix = |sum: u64, part: u64| (sum ^ part).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        let key = mix(mix(mix(0, time), x), y);
        let place = &mut self.recent[(key >> 20) as usize % PLACES];
        let original = (place.0 == key && place.1 != report.source).then_some(place.1);
        *place = (key, report.source);
        let own = usize::from(report.source);
        for other in 0..count {
            let index = own * count + other;
            let is_copy = original == Some(other as u16);
            let copies = &mut self.copies[index];
            if !is_copy && *copies == 0.0 {
                continue;
            }
            *copies += GAIN * (f64::from(u8::from(is_copy)) - *copies);
            let limit = if self.learned[index] { INDEPENDENT } else { DEPENDENT };
            let depends = *copies > limit && self.may_depend[index];
            if depends != self.learned[index] {
                self.learned[index] = depends;
                self.regroup();
            }
        }
    }

    /// Finds the groups anew: sources that depend on each other, directly or by way of others.
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
        let mut dependence = Dependence::new(&test_settings(3));
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
    fn what_is_stated_holds() {
        let mut settings = test_settings(4);
        settings.sources[3].shares = vec![1.into()];
        settings.sources[2].independent_of = vec![0.into()];
        let mut dependence = Dependence::new(&settings);
        for step in 0..20 {
            for source in [0, 2] {
                dependence.learn(&report(source, step, 0.0));
            }
        }
        assert_eq!([0, 1, 2, 3].map(|source| dependence.group_of(source)), [0, 1, 2, 1]);
    }
}
