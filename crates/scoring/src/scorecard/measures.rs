//! Figures that lines of standards limit.

use rustc_hash::{FxHashMap, FxHashSet};

use super::figures::{ErrorSpread, PhaseTable};
use super::samples::{AddressCheck, ErrorSample, TargetSecond, TrackSecond};

/// Figure of a standard's line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineMeasure {
    /// Size of the position error in the plane that this share of the errors does not exceed, metres.
    PositionQuantile(f64),
    /// Root mean square position error in the plane, metres.
    PositionRms,
    /// Share of intervals of so many seconds with a report.
    Update(i64),
    /// Number of gaps between reports of at least and at most so many seconds, per report.
    Gaps(i64, i64),
    /// Longest gap between reports, seconds.
    LongestGap,
    /// Share of reports with the target's address.
    AddressRight,
    /// Share of the reported addresses that are not the target's.
    AddressWrong,
    /// Share of reports that are more than so many metres off their target, or, against a truth, belong to none.
    FalseReports(f64),
    /// Number per hour of tracks without a target of the reference for most of their seconds.
    FalseTracksPerHour,
    /// Share of speeds with an error of at most so many m/s or this share of the speed, whatever is more.
    SpeedWithin(f64, f64),
    /// Size of the error of the course that this share of the errors does not exceed, degrees; above 3 m/s.
    CourseQuantile(f64),
    /// Size of the height error that this share of the errors does not exceed, metres.
    HeightQuantile(f64),
    /// Root mean square error of the velocity in the plane in a phase, m/s.
    VelocityRms(&'static str),
}

/// Value of a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredFigure {
    /// The figure; `None` if nothing was measured.
    pub value: Option<f64>,
    /// Number of cases behind the figure.
    pub samples: u64,
}

impl MeasuredFigure {
    fn share(part: usize, of: usize) -> Self {
        Self {
            value: (of > 0).then(|| part as f64 / of as f64),
            samples: of as u64,
        }
    }

    fn of(value: impl Fn(&ErrorSpread) -> Option<f64>, spread: &ErrorSpread) -> Self {
        Self {
            value: value(spread),
            samples: spread.n,
        }
    }
}

/// Part of the samples that belongs to one card.
pub(crate) struct CardPart<'a> {
    pub(crate) errors: Vec<&'a ErrorSample>,
    pub(crate) phases: &'a PhaseTable,
    pub(crate) reports: ReportTimes,
    pub(crate) tracks: Vec<&'a TrackSecond>,
    pub(crate) seconds: u64,
    /// Whether the truth has every target, so that a report of no target is false.
    pub(crate) is_complete: bool,
}

impl CardPart<'_> {
    /// Returns the figure of a measure.
    pub(crate) fn figure(&self, measure: LineMeasure) -> MeasuredFigure {
        let all = &self.phases.0[0];
        match measure {
            LineMeasure::PositionQuantile(share) => self.quantile(share, |sample| Some(sample.position_m)),
            LineMeasure::CourseQuantile(share) => self.quantile(share, |sample| sample.heading_deg),
            LineMeasure::HeightQuantile(share) => self.quantile(share, |sample| sample.height_m),
            LineMeasure::PositionRms => MeasuredFigure::of(|spread| spread.rms, &all.position),
            LineMeasure::VelocityRms(phase) => match self.phases.named(phase) {
                Some(figures) => MeasuredFigure::of(|spread| spread.rms, &figures.velocity),
                None => MeasuredFigure::share(0, 0),
            },
            LineMeasure::Update(interval_s) => {
                let (reported, intervals) = self.reports.intervals(interval_s);
                MeasuredFigure::share(reported, intervals)
            }
            LineMeasure::Gaps(least_s, most_s) => {
                let gaps = self.reports.gaps_s.iter();
                let counted = gaps.filter(|gap_s| (least_s..=most_s).contains(*gap_s)).count();
                MeasuredFigure::share(counted, self.reports.number)
            }
            LineMeasure::LongestGap => MeasuredFigure {
                value: self.reports.gaps_s.iter().max().map(|gap_s| *gap_s as f64),
                samples: self.reports.gaps_s.len() as u64,
            },
            LineMeasure::AddressRight => {
                let known = self.with_address(|check| check != AddressCheck::Unknown);
                MeasuredFigure::share(self.with_address(|check| check == AddressCheck::Right), known)
            }
            LineMeasure::AddressWrong => {
                let wrong = self.with_address(|check| check == AddressCheck::Wrong);
                let right = self.with_address(|check| check == AddressCheck::Right);
                MeasuredFigure::share(wrong, wrong + right)
            }
            LineMeasure::FalseReports(beyond_m) => self.false_reports(beyond_m),
            LineMeasure::FalseTracksPerHour => MeasuredFigure {
                value: (self.seconds > 0).then(|| self.false_tracks() * 3600.0 / self.seconds as f64),
                samples: self.seconds,
            },
            LineMeasure::SpeedWithin(least_mps, share) => {
                let known = || {
                    self.errors
                        .iter()
                        .filter_map(|sample| Some((sample, sample.speed_mps?)))
                };
                let within = known()
                    .filter(|(sample, error_mps)| error_mps.abs() <= least_mps.max(share * sample.target_speed_mps));
                MeasuredFigure::share(within.count(), known().count())
            }
        }
    }

    fn quantile(&self, share: f64, value: fn(&ErrorSample) -> Option<f64>) -> MeasuredFigure {
        let mut sizes: Vec<f64> = self
            .errors
            .iter()
            .filter_map(|sample| value(sample))
            .map(f64::abs)
            .collect();
        MeasuredFigure {
            value: crate::statistics::quantile(&mut sizes, share),
            samples: sizes.len() as u64,
        }
    }

    fn with_address(&self, counts: impl Fn(AddressCheck) -> bool) -> usize {
        self.errors.iter().filter(|sample| counts(sample.address)).count()
    }

    fn false_reports(&self, beyond_m: f64) -> MeasuredFigure {
        let far = self.errors.iter().filter(|sample| sample.position_m > beyond_m).count();
        let of_none = self.tracks.iter().filter(|track| !track.is_paired).count();
        match self.is_complete {
            true => MeasuredFigure::share(far + of_none, self.errors.len() + of_none),
            false => MeasuredFigure::share(far, self.errors.len()),
        }
    }

    fn false_tracks(&self) -> f64 {
        let mut balance: FxHashMap<i64, i64> = FxHashMap::default();
        for second in &self.tracks {
            *balance.entry(second.track).or_default() += if second.is_paired { 1 } else { -1 };
        }
        balance.values().filter(|balance| **balance < 0).count() as f64
    }
}

/// When targets were reported, by *legs*: seconds in a row in which the target counts.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReportTimes {
    /// For each second of each leg, whether there was a report.
    legs: Vec<Vec<bool>>,
    /// Times between reports in a row; at the ends of a leg from its first second, and to its last.
    gaps_s: Vec<i64>,
    /// Number of reports.
    number: usize,
    /// Number of targets.
    pub(crate) targets: usize,
}

impl ReportTimes {
    /// Divides the seconds of targets into legs.
    pub(crate) fn of(seconds: &[&TargetSecond]) -> Self {
        let mut sorted: Vec<&&TargetSecond> = seconds.iter().collect();
        sorted.sort_unstable_by_key(|second| (second.target, second.second));
        let together =
            |one: &&&TargetSecond, next: &&&TargetSecond| one.target == next.target && next.second == one.second + 1;
        let mut found = Self {
            targets: sorted
                .iter()
                .map(|second| second.target)
                .collect::<FxHashSet<_>>()
                .len(),
            ..Self::default()
        };
        for leg in sorted.chunk_by(together) {
            found.add(leg.iter().map(|second| second.is_reported).collect());
        }
        found
    }

    fn add(&mut self, leg: Vec<bool>) {
        let last = leg.len() as i64 - 1;
        let reports: Vec<i64> = (0..)
            .zip(&leg)
            .filter(|(_, is)| **is)
            .map(|(second, _)| second)
            .collect();
        self.number += reports.len();
        let bounds = [0].into_iter().chain(reports).chain([last]);
        let bounds: Vec<i64> = bounds.collect();
        let gaps = bounds.windows(2).map(|pair| pair[1] - pair[0]);
        self.gaps_s.extend(gaps.filter(|gap_s| *gap_s > 0));
        self.legs.push(leg);
    }

    /// Returns the number of whole intervals with a report, and of all.
    fn intervals(&self, interval_s: i64) -> (usize, usize) {
        let length = usize::try_from(interval_s).unwrap_or(1).max(1);
        let intervals = || self.legs.iter().flat_map(|leg| leg.chunks_exact(length));
        let reported = intervals().filter(|interval| interval.contains(&true)).count();
        (reported, intervals().count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(target: i64, first: i64, reported: &str) -> Vec<TargetSecond> {
        let second = |(second, letter): (i64, char)| TargetSecond {
            target,
            second,
            place_m: [0.0; 2],
            is_reported: letter == 'x',
        };
        (first..).zip(reported.chars()).map(second).collect()
    }

    fn times(seconds: &[TargetSecond]) -> ReportTimes {
        ReportTimes::of(&seconds.iter().collect::<Vec<_>>())
    }

    #[test]
    fn gaps_count_between_reports_and_at_the_ends() {
        let found = times(&seconds(1, 10, "..x...xx."));
        // 2 s to the first report, 4 s, 1 s, and 1 s to the end.
        assert_eq!((found.gaps_s.as_slice(), found.number), ([2, 4, 1, 1].as_slice(), 3));
        assert_eq!(times(&seconds(1, 10, "....")).gaps_s, [3], "never reported");
        assert!(times(&seconds(1, 10, "x")).gaps_s.is_empty());
    }

    #[test]
    fn a_leg_ends_where_the_target_does_not_count() {
        let mut both = seconds(1, 20, "xx");
        both.extend(seconds(1, 10, "x."));
        both.extend(seconds(2, 12, "xx"));
        let found = times(&both);
        assert_eq!((found.legs.len(), found.number, found.targets), (3, 5, 2));
        assert_eq!(found.gaps_s, [1, 1, 1]);
    }

    #[test]
    fn intervals_are_whole() {
        let found = times(&seconds(1, 0, "x...xx."));
        assert_eq!(found.intervals(1), (3, 7));
        assert_eq!(found.intervals(2), (2, 3), "x. .. xx, and half an interval");
        assert_eq!(found.intervals(5), (1, 1));
        assert_eq!(found.intervals(8), (0, 0));
    }
}
