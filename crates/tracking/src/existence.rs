//! Existence of targets: birth, survival and misses in one probability (HT-10).
//!
//! The obvious sign of an end is a number of misses in a row. Five of them prove nothing of a sensor that detects half
//! of the targets, and too much of one that looked ten times within a second. Besides, a limit for the end is no limit
//! for the output: a target missed twice is shown too long, and a track that is dropped at once returns under a new
//! number.
//!
//! So each branch has the probability that its target has gone since the latest detection. A detection sets the
//! probability to 0, for in hypotheses with this branch the target was there. From then on the target leaves with a
//! constant hazard, the inverse of the mean life T, and a look that finds nothing weighs both cases (Bayes):
//!
//! ```text
//! a ← 1 − (1 − a)·exp(−t / T)                  t: time since the look before
//! a ← a / (a + (1 − a)·q)                      q: probability that the sensor misses a target that is there
//! ```
//!
//! Outside every field of view no look finds anything: there the hazard is larger by 1 / `deletion.exit_s`, times the
//! probability of being outside. The mean life is learned: the time for which confirmed tracks have followed targets,
//! by the number of targets that have gone ([`LifeEstimate`]).
//!
//! In the weights of the hypotheses, a detection of the track has the factor 1 − a: a target that has probably gone
//! explains few detections. Of several targets together, one may be missed because the sensor does not resolve them: in
//! clusters with a confirmed track and another track, the factor is 1. A miss keeps the likelihood q there. With a + (1
//! − a)·q, hypotheses with a target that has gone would stand for long beside those without it, and targets that the
//! sensor does not resolve would end.
//!
//! Birth is the expected number of new targets per false detection ([`crate::initiation`]). Output and deletion are
//! limits on 1 − a. A track below the limit of the output is kept with its number: its target may be found again.
//!
//! Limits: all targets have the same mean life. Occlusion counts as misses, which are correlated only within
//! `deletion.coherence_s`. Unresolved targets are missed in turn; a count by a wide-area sensor shows that none has
//! gone, and `resolution_cell` models them.
//!
//! Source: D. Mušicki, R. Evans, S. Stanković, *Integrated probabilistic data association*, IEEE Transactions on
//! Automatic Control 39 (1994).

use estimation::Gaussian;

use crate::life::DeletionSettings;
use crate::sensor::{Sensor, SensorMemory};

/// Largest probability of absence: a detection must be able to bring any track back.
const ABSENCE_MAX: f64 = 1.0 - 1e-9;

/// Mean life before anything is known, seconds; it is worth the exit of one target.
const PRIOR_S: f64 = 1000.0;
/// Exits over which the mean life is learned.
const EXITS: f64 = 50.0;
/// Least and largest mean life that is learned, seconds.
const LEARNED_S: [f64; 2] = [30.0, 1e5];

/// Estimate of the targets' mean life: the time for which confirmed tracks have followed targets, by the number of
/// targets that have gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LifeEstimate {
    seconds: f64,
    exits: f64,
}

impl LifeEstimate {
    pub(crate) const NONE: Self = Self {
        seconds: PRIOR_S,
        exits: 1.0,
    };

    /// Learns from a scan, `seconds` after the scan before: expected numbers of targets that confirmed tracks followed
    /// before the scan and follow after it, and number of tracks confirmed by it. Where fewer are left than there were
    /// and have come, the others have gone; a target that is found again has not.
    pub(crate) fn count(&mut self, seconds: f64, [present, left]: [f64; 2], confirmed: u32) {
        self.exits = (self.exits + present + f64::from(confirmed) - left).max(1.0);
        self.seconds += present * seconds;
        let forgotten = (EXITS / self.exits).min(1.0);
        self.exits *= forgotten;
        self.seconds = (self.seconds * forgotten).min(LEARNED_S[1] * self.exits);
    }

    pub(crate) fn mean_s(&self) -> f64 {
        (self.seconds / self.exits).max(LEARNED_S[0])
    }
}

/// The time since the previous scan, and what it means for the existence of targets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Survival<'a> {
    seconds: f64,
    /// Share of the targets in view that are still there.
    inside: f64,
    exit_s: f64,
    /// The sensors in the order of the settings, and what each remembers.
    sensors: &'a [Sensor],
    memories: &'a [SensorMemory],
}

impl<'a> Survival<'a> {
    /// Between two scans that are so many seconds apart, by sensors in the order of the settings.
    pub(crate) fn new(
        seconds: f64,
        life: &LifeEstimate,
        (sensors, memories): (&'a [Sensor], &'a [SensorMemory]),
        settings: &DeletionSettings,
    ) -> Self {
        let mean_life_s = settings.mean_life_s.unwrap_or_else(|| life.mean_s());
        Self {
            seconds,
            inside: (-seconds / mean_life_s).exp(),
            exit_s: settings.exit_s,
            sensors,
            memories,
        }
    }

    /// Probability that a target of this predicted state has gone.
    pub(crate) fn absence(&self, before: f64, predicted: &Gaussian) -> f64 {
        let mut there = (1.0 - before) * self.inside;
        let outside = 1.0 - self.in_view(predicted);
        if outside > 0.0 {
            there *= (-self.seconds * outside / self.exit_s).exp();
        }
        1.0 - there
    }

    /// Probability that a target is in the field of view of the sensor that covers its place best.
    fn in_view(&self, predicted: &Gaussian) -> f64 {
        let mut best: f64 = 0.0;
        for (sensor, memory) in self.sensors.iter().zip(self.memories) {
            best = best.max(memory.covers(sensor.field_of_view.as_ref(), predicted));
            if best >= 1.0 {
                break;
            }
        }
        best
    }
}

/// Probability of absence after evidence with the given likelihood if the target is there, relative to its absence.
pub(crate) fn weighed(absence: f64, likelihood: f64) -> f64 {
    (absence / (absence + (1.0 - absence) * likelihood)).min(ABSENCE_MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field_of_view::FieldOfView;
    use crate::settings::Settings;
    use crate::testing::{S, position, settings};
    use crate::{TrackReport, Tracker};

    /// Numbers of the output tracks after scans of a target that a sensor sees where `sees` holds.
    fn numbers(settings: &Settings, scans: i64, sees: impl Fn(i64) -> bool) -> Vec<Vec<u32>> {
        let mut tracker = Tracker::new(settings.clone()).unwrap();
        let scan = |second: i64| {
            let seen = [position(second * S, 15.0 * second as f64, 0.0)];
            tracker
                .scan(1, second * S, &seen[usize::from(!sees(second))..])
                .unwrap();
            tracker
                .tracks()
                .iter()
                .map(|track: &TrackReport| track.number)
                .collect()
        };
        (0..scans).map(scan).collect()
    }

    #[test]
    fn misses_and_time_make_a_target_absent() {
        let survival = Survival {
            seconds: 10.0,
            inside: (-0.1_f64).exp(),
            exit_s: 1.0,
            sensors: &[],
            memories: &[],
        };
        // Outside every field of view both hazards add up: 1.01 per second.
        let predicted = Gaussian {
            mean: [0.0; 6],
            covariance: messages::Covariance::diagonal([1.0; 3], [1.0; 3]),
        };
        assert!((survival.absence(0.5, &predicted) - (1.0 - 0.5 * (-10.1_f64).exp())).abs() < 1e-12);
        assert!((weighed(0.1, 0.25) - 0.1 / (0.1 + 0.9 * 0.25)).abs() < 1e-12);
        assert_eq!((weighed(0.0, 0.1), weighed(0.3, 1.0)), (0.0, 0.3), "nothing is learned");
        assert!(weighed(0.5, 1e-300) < 1.0, "a detection brings any track back");
    }

    #[test]
    fn a_track_that_is_probably_gone_is_kept_and_returns_with_its_number() {
        let shown = numbers(&settings(), 16, |second| !(8..13).contains(&second));
        assert_eq!(shown[8..16], [&[1][..], &[1], &[1], &[], &[], &[1], &[1], &[1]]);
        let mut all = settings();
        all.deletion.shown_min = 0.0;
        assert_eq!(numbers(&all, 13, |second| second < 8)[12], [1]);
        // Shorter lives: one miss is enough.
        let mut short = settings();
        short.deletion.mean_life_s = Some(2.0);
        assert!(numbers(&short, 9, |second| second < 8)[8].is_empty());
    }

    #[test]
    fn outside_every_field_of_view_a_target_goes_for_good() {
        let mut chosen = settings();
        chosen.sensors[0].model.field_of_view = Some(FieldOfView {
            range_m: [0.0, 150.0],
            sector_deg: None,
            position_m: Some([0.0, 0.0]),
        });
        let branches = |exit_s| {
            let mut chosen = chosen.clone();
            chosen.deletion.exit_s = exit_s;
            let mut tracker = Tracker::new(chosen).unwrap();
            for second in 0..25 {
                let seen = [position(second * S, 15.0 * second as f64, 0.0)];
                tracker.scan(1, second * S, &seen[usize::from(second > 10)..]).unwrap();
            }
            tracker.branches()
        };
        assert_eq!(branches(1.0), 0);
        assert!(branches(1e9) > 0, "it may come back");
    }

    #[test]
    fn the_mean_life_is_learned_from_the_targets_that_go() {
        // A new target each 20 s, seen for 10 s.
        let mut tracker = Tracker::new(settings()).unwrap();
        let lives = |tracker: &Tracker| tracker.latest().life.mean_s();
        assert_eq!(lives(&tracker), PRIOR_S);
        for second in 0..1000 {
            let seen = [position(second * S, 1e4 * (second / 20) as f64, 15.0 * second as f64)];
            tracker
                .scan(1, second * S, &seen[usize::from(second % 20 >= 10)..])
                .unwrap();
        }
        assert!((30.0..60.0).contains(&lives(&tracker)), "{}", lives(&tracker));
        // One that stays makes lives longer again; a target that is found again has not gone.
        let mut tracker = Tracker::new(settings()).unwrap();
        for second in 0..1000 {
            let seen = [position(second * S, 15.0 * second as f64, 0.0)];
            tracker
                .scan(1, second * S, &seen[usize::from(second % 20 >= 16)..])
                .unwrap();
        }
        assert!(lives(&tracker) > 900.0, "{}", lives(&tracker));
    }
}
