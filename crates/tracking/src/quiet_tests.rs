use std::cell::Cell;

use crate::explanation::{Explanation, Observer};
use crate::settings::Settings;
use crate::testing::{position, settings};
use crate::tracker::Tracker;

thread_local! {
    /// Updates by the quick way in this thread.
    pub(super) static UPDATES: Cell<u64> = const { Cell::new(0) };
}

/// With an observer, every cluster goes through the general update.
#[derive(Debug)]
struct Watching(Cell<u64>);

impl Observer for Watching {
    fn explain(&self, _: &Explanation<'_>) {
        self.0.set(self.0.get() + 1);
    }
}

/// Deterministic numbers from 0 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Targets among false detections, seen at this interval; with fast looks, with slow ones, and with few detections.
fn both_ways(chosen: &Settings, interval_ns: i64, detected: f64) -> [Tracker; 2] {
    let mut trackers = [0, 1].map(|_| Tracker::new(chosen.clone()).unwrap());
    let (mut numbers, watching) = (Numbers(7), Watching(Cell::new(0)));
    for scan in 1..150_i64 {
        let time_ns = scan * interval_ns;
        let mut detections = Vec::new();
        for target in 0..6 {
            if numbers.next() < detected {
                let east = 1000.0 * f64::from(target) + 50.0 * time_ns as f64 / 1e9;
                detections.push(position(time_ns, east + 9.0 * numbers.next(), 9.0 * numbers.next()));
            }
        }
        for _ in 0..8 {
            detections.push(position(time_ns, 8000.0 * numbers.next(), 8000.0 * numbers.next()));
        }
        let [quick, general] = &mut trackers;
        quick.scan(1, time_ns, &detections).unwrap();
        general
            .scan_explained(1, time_ns, &detections, Some(&watching))
            .unwrap();
        assert_eq!(quick.tracks(), general.tracks(), "scan {scan}");
        assert_eq!(
            quick.latest().clusters.len(),
            general.latest().clusters.len(),
            "scan {scan}"
        );
        assert_eq!(quick.latest().tracks, general.latest().tracks, "scan {scan}");
        let logs = |tracker: &Tracker| -> Vec<u64> {
            let hypotheses = tracker.latest().hypotheses.iter();
            hypotheses
                .map(|hypothesis| hypothesis.log_reliability.to_bits())
                .collect()
        };
        assert_eq!(logs(quick), logs(general), "scan {scan}");
    }
    assert!(watching.0.get() > 0 && UPDATES.with(Cell::take) > 100);
    trackers
}

#[test]
fn a_quiet_cluster_is_updated_as_by_the_general_update() {
    for (interval_ns, detected) in [(4_000_000_000, 0.9), (50_000_000, 0.9), (1_000_000_000, 0.3)] {
        let mut chosen = settings();
        chosen.sensors[0].model.clutter_density = Some(1e-7);
        let [quick, general] = both_ways(&chosen, interval_ns, detected);
        assert_eq!(quick.counts(), general.counts());
        assert!(quick.counts().confirmed > 3);
        chosen.confirmation.span_min_s = Some(2.5 * interval_ns as f64 / 1e9);
        chosen.confirmation.interval_max_s = Some(6.0 * interval_ns as f64 / 1e9);
        let [quick, general] = both_ways(&chosen, interval_ns, detected);
        assert_eq!(quick.counts(), general.counts());
    }
}

/// A sensor that looks 250 times a second: a false detection is forgotten at the next look, a target is not.
#[test]
fn a_first_detection_that_is_missed_at_once_is_forgotten() {
    let mut tracker = Tracker::new(settings()).unwrap();
    let mut time_ns = 0;
    let mut look = |tracker: &mut Tracker, places: &[[f64; 2]]| {
        time_ns += 4_000_000;
        let detections = places.iter().map(|[east, north]| position(time_ns, *east, *north));
        tracker.scan(1, time_ns, &detections.collect::<Vec<_>>()).unwrap();
        let tracks = tracker.latest().tracks.iter();
        tracks.filter(|track| track.motion.mean()[0] > 2500.0).count()
    };
    for _ in 0..20 {
        look(&mut tracker, &[[0.0, 0.0]]);
    }
    // Nor are the target's detections those of two tracks in turn.
    assert_eq!(tracker.tracks().len(), 1);
    let with_start = look(&mut tracker, &[[0.0, 0.0], [5000.0, 0.0]]);
    assert_eq!(with_start, 1);
    let left: Vec<usize> = (0..4).map(|_| look(&mut tracker, &[])).collect();
    assert_eq!(left, [0; 4]);
}
