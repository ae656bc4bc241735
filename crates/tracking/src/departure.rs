//! Departures: detections outside the gates of confirmed tracks, possibly of targets that left the tracks (SP-1, SP-2).
//!
//! A target that splits off is new in the gate of the confirmed track, where new targets are expected. But if the
//! sensor misses the new target in the first scans, its first own detection lies outside the gate: the track has
//! followed the other target. There the detection looked like any first detection, most likely false and of unknown
//! speed, and the split was shown scans later. So a detection outside all gates is compared with the targets that may
//! have left a confirmed track `splitting.departed_s` ago: with the change of velocity of a manoeuvre since then. A
//! track that begins there inherits this motion, in which place and velocity are correlated, and new targets are as
//! frequent as in the gates.
//!
//! Limit: of several tracks that a target may have left, the likeliest counts.

use crate::gating::Gating;
use crate::limits::COMPARISONS_MAX;
use crate::motion::TargetMotion;
use crate::plot::Plot;
use crate::population::Population;
use crate::sensor::Sensor;
use crate::settings::{Settings, Splitting, Starts};
use crate::track::Track;

/// Least reliability of the branch that a target has left: an unlikely branch shows nothing.
const RELIABILITY_MIN: f64 = 0.3;

/// A target that may have left a confirmed track.
#[derive(Clone, Copy, Debug)]
struct Departure {
    motion: TargetMotion,
    /// Logarithm of the density of the detection.
    log_likelihood: f64,
    /// Whether the detection is in the gate of a confirmed track.
    is_inside: bool,
}

/// Departures of a scan; working memory, reused for each scan.
#[derive(Clone, Debug)]
pub(crate) struct Departures {
    /// By detection: the motion of a target that left.
    of_plot: Vec<Option<Departure>>,
    near: Vec<u32>,
}

impl Departures {
    pub(crate) fn new(plots_max: usize) -> Self {
        Self {
            of_plot: Vec::with_capacity(plots_max),
            near: Vec::with_capacity(plots_max),
        }
    }

    /// Finds the departures of a scan; `is_inside` marks the detections in a confirmed track's gate. Returns the number
    /// of comparisons left out: a track has at most [`COMPARISONS_MAX`].
    pub(crate) fn find(
        &mut self,
        (before, plots): (&Population, &[Plot]),
        gating: &Gating,
        is_inside: &[bool],
        sensor: &Sensor,
        settings: &Settings,
    ) -> u64 {
        self.clear();
        let starts = settings.starts != Starts::Designated && settings.splitting.parents_motion.is_some();
        let is_possible = starts && !plots.is_empty();
        let Some(departed_s) = settings.splitting.departed_s.filter(|_| is_possible) else {
            return 0;
        };
        let mut dropped = 0;
        self.of_plot.resize(plots.len(), None);
        let motion = &settings.motion;
        let left = |track: &Track, time_ns| track.motion_at(time_ns, motion).left(departed_s, motion);
        let confirmed = before.tracks.iter().filter(|track| track.is_confirmed());
        for track in confirmed.filter(|track| track.reliability >= RELIABILITY_MIN) {
            gating.near(&left(track, plots[0].time_ns), sensor.gates[1], &mut self.near);
            let made = self.near.len().min(COMPARISONS_MAX);
            dropped += (self.near.len() - made) as u64;
            let compared = self.near[..made].iter();
            for &item in compared.filter(|item| !gating.names[**item as usize]) {
                let plot = &plots[item as usize];
                let departed = left(track, plot.time_ns);
                let Some(innovation) = departed.innovation(&plot.measurement) else {
                    continue;
                };
                let log_likelihood = innovation.log_likelihood + track.reliability.ln();
                let found = &mut self.of_plot[item as usize];
                let is_better = found.as_ref().is_none_or(|best| log_likelihood > best.log_likelihood);
                if is_better && innovation.squared_distance <= sensor.gates[innovation.dimension - 1] {
                    *found = Some(Departure {
                        motion: departed,
                        log_likelihood,
                        is_inside: is_inside[item as usize],
                    });
                }
            }
        }
        dropped
    }

    /// Forgets the departures of the scan before.
    pub(crate) fn clear(&mut self) {
        self.of_plot.clear();
    }

    /// Expected new targets per false detection at a detection. Where a target may have left a confirmed track, these
    /// are at most `splitting.new_target_share`, and at most `splitting.leaving_max` targets per track and scan. In the
    /// gate of a confirmed track, they are `splitting.new_target_share`. The number is nowhere less than
    /// `initiation.new_target_share`: beside tracks, too, targets appear.
    pub(crate) fn new_target_share(&self, plot: u32, log_clutter: f64, is_inside: bool, settings: &Settings) -> f64 {
        let splitting = &settings.splitting;
        let in_gate = splitting.new_target_share.filter(|_| is_inside);
        let of_split = self.share(plot, log_clutter, splitting).or(in_gate);
        let anywhere = settings.initiation.new_target_share;
        of_split.map_or(anywhere, |share| share.max(anywhere))
    }

    fn share(&self, plot: u32, log_clutter: f64, splitting: &Splitting) -> Option<f64> {
        let found = self.of_plot.get(plot as usize)?.as_ref()?;
        let per_false = (found.log_likelihood - log_clutter).exp();
        let most = splitting.leaving_max.map_or(f64::INFINITY, |most| most * per_false);
        splitting.new_target_share.map(|share| share.min(most))
    }

    /// The motion of a target that left a confirmed track and may have caused the detection.
    pub(crate) fn motion(&self, plot: u32) -> Option<TargetMotion> {
        let found = self.of_plot.get(plot as usize)?.as_ref()?;
        (!found.is_inside).then_some(found.motion)
    }
}

#[cfg(test)]
mod tests {
    use observations::Detection;

    use super::*;
    use crate::Tracker;
    use crate::testing::{S, position, settings};

    /// A target flies east, and from 40 s on a second target separates to the north. The sensor misses the second
    /// target in the first `missed` scans of 4 s. Own detections of the second target until both have a track.
    fn own_detections_until_shown(missed: i64, departed_s: Option<f64>) -> i64 {
        let mut chosen = Settings {
            sensors: settings().sensors,
            capacity: settings().capacity,
            ..Settings::default()
        };
        chosen.splitting.departed_s = departed_s;
        chosen.sensors[0].model.clutter_density = Some(2.5e-8);
        let mut tracker = Tracker::new(chosen).unwrap();
        for step in 0..30 {
            let time_ns = 4 * step * S;
            let (east, since) = (440.0 * step as f64, step - 10);
            let coarse = |north| Detection {
                sigmas: Some([50.0, 50.0, 0.0, 0.0]),
                ..position(time_ns, east, north)
            };
            let mut seen = vec![coarse(0.0)];
            if since > missed {
                seen.push(coarse(150.0 * since as f64));
            }
            tracker.scan(1, time_ns, &seen).unwrap();
            if tracker.tracks().len() == 2 {
                return since - missed;
            }
        }
        i64::MAX
    }

    #[test]
    fn a_target_that_left_unseen_is_shown_at_its_third_detection() {
        let departed_s = Settings::default().splitting.departed_s;
        for missed in [2, 3] {
            assert!(own_detections_until_shown(missed, departed_s) <= 3);
            let unlike = own_detections_until_shown(missed, None);
            assert!(unlike > 3, "of any speed, and most likely false");
        }
    }

    #[test]
    fn where_false_detections_are_dense_fewer_are_of_targets_that_left() {
        let measurement = position(0, 0.0, 0.0);
        let measurement = crate::measurement::DetectionMeasurement::of(&measurement, None).unwrap();
        let chosen = settings();
        let motion = TargetMotion::first(&measurement, &chosen.initiation, &chosen.motion).unwrap();
        let mut departures = Departures::new(1);
        departures.of_plot.push(Some(Departure {
            motion,
            log_likelihood: -10.0,
            is_inside: true,
        }));
        let mut splitting = Splitting {
            leaving_max: Some(0.5),
            ..Splitting::default()
        };
        let share = |log_clutter, splitting: &Splitting| departures.share(0, log_clutter, splitting).unwrap();
        assert_eq!(share(-15.0, &splitting), splitting.new_target_share.unwrap());
        assert!((share(-10.0, &splitting) - 0.5).abs() < 1e-12);
        splitting.leaving_max = None;
        assert_eq!(share(-10.0, &splitting), splitting.new_target_share.unwrap());
        assert!(departures.motion(0).is_none() && departures.share(1, 0.0, &splitting).is_none());
        // Among dense false detections, a target may appear beside a track as anywhere.
        let share = |plot, log_clutter, is_inside| departures.new_target_share(plot, log_clutter, is_inside, &chosen);
        let anywhere = chosen.initiation.new_target_share;
        assert_eq!([share(0, 20.0, true), share(1, 0.0, false)], [anywhere; 2]);
        assert_eq!(share(1, 0.0, true), chosen.splitting.new_target_share.unwrap());
    }
}
