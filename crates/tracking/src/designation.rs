//! Designations: targets that are to be followed, named by place.
//!
//! An operator, or another system, designates a target, and the tracker follows the target: *maintenance only*. The
//! obvious way, an order beside the data, would be used at a time that depends on the machine. A designation has the
//! time for which the stated place is right, and must be sorted in among the scans; after a late scan the designation
//! must be used again. So a designation is a detection of a separate sensor that `designates`: received like
//! detections, over a topic, as rows or in a file, and recorded with the detections. The same input gives the same
//! tracks.
//!
//! A designation may state the target's velocity: the track begins with this velocity. A fast target is else lost where
//! the next look comes late, or a gate wide enough for every speed takes a false detection.
//!
//! A designated target has a confirmed track at once, unless a confirmed track is there already: an operator's place
//! does not improve a track. Such a designation is counted and explained, so that the sender can find why no track
//! begins. No track is missed by a scan of designations. With `starts = "designated"` nothing else begins a track;
//! tracks end as ever.

use crate::counts::TrackerCounts;
use crate::existence::Survival;
use crate::explanation::{Explanation, Observer, TrackEvent, TrackRecord};
use crate::initiation::{Initiation, first_state};
use crate::measurement::DetectionMeasurement;
use crate::motion::TargetMotion;
use crate::plot::{Plot, Scan};
use crate::population::Population;
use crate::sensor::Sensor;
use crate::settings::Settings;
use crate::track::Track;
use observations::StatedVelocity;

/// Makes the population after a scan of designations.
pub(crate) fn designate(
    scan: &Scan,
    (before, next): (&Population, &mut Population),
    (sensor, survival): (&Sensor, &Survival<'_>),
    settings: &Settings,
    observer: Option<&dyn Observer>,
    counts: &mut TrackerCounts,
) {
    next.carry_on(before);
    for track in &mut next.tracks {
        track.absence = survival.absence(track.absence, track.motion.widest());
    }
    next.time_ns = scan.time_ns;
    next.next_serial = next.next_serial.wrapping_add(scan.plots.len() as u32).max(1);
    counts.scans += 1;
    for (place, plot) in (0..).zip(&scan.plots) {
        if let Some((track, distance, gate)) = followed(next, plot, sensor, settings) {
            counts.designations_followed += 1;
            if let Some(observer) = observer {
                observer.explain(&Explanation::Track {
                    event: TrackEvent::Designated,
                    track: TrackRecord {
                        detection_id: Some(plot.detection_id),
                        ..TrackRecord::of(track, &[], 0)
                    },
                    value: distance,
                    limit: gate,
                });
            }
            continue;
        }
        let serial = before.next_serial.wrapping_add(place);
        let Some(track) = designated(plot, serial, next, settings) else {
            counts.rejected_detections += 1;
            continue;
        };
        if !next.has_room(1, 1, 1) {
            counts.dropped_tracks += 1;
            continue;
        }
        add(next, track);
        counts.confirmed += 1;
        if let Some(observer) = observer {
            observer.explain(&Explanation::Track {
                event: TrackEvent::Confirmed,
                track: TrackRecord::of(&track, &scan.plots, before.next_serial),
                value: track.reliability,
                limit: f64::NAN,
            });
        }
    }
}

/// The first confirmed track that may be of the designated target, with the squared distance and the gate.
fn followed<'a>(
    population: &'a Population,
    plot: &Plot,
    sensor: &Sensor,
    settings: &Settings,
) -> Option<(&'a Track, f64, f64)> {
    let mut confirmed = population.tracks.iter().filter(|track| track.is_confirmed());
    confirmed.find_map(|track| {
        let motion = track.motion_at(plot.time_ns, &settings.motion);
        let innovation = motion.innovation(&plot.measurement)?;
        let (distance, gate) = (innovation.squared_distance, sensor.gates[innovation.dimension - 1]);
        (distance <= gate).then_some((track, distance, gate))
    })
}

/// `None` of a direction alone.
fn designated(plot: &Plot, serial: u32, population: &Population, settings: &Settings) -> Option<Track> {
    let motion = match plot.velocity {
        Some(velocity) => moving(plot, velocity, settings)?,
        None => TargetMotion::first(&plot.measurement, &settings.initiation, &settings.motion)?,
    };
    let mut track = Track {
        number: population.next_number,
        reliability: 1.0,
        ..Track::begun(motion, plot.time_ns, serial, population.next_root)
    };
    track.identity.take(&plot.identity);
    Some(track)
}

/// The motion of a target with a designated velocity: a single assumption, not slow and fast side by side.
fn moving(plot: &Plot, stated: StatedVelocity, settings: &Settings) -> Option<TargetMotion> {
    let guess = Initiation {
        speed_sigma_mps: stated.sigma_mps,
        ..settings.initiation
    };
    // A range rate would be compared with a speed of 0, and the stated velocity contains it.
    let place = DetectionMeasurement {
        range_rate_mps: None,
        ..plot.measurement
    };
    let mut state = first_state(&place, &guess)?;
    for (axis, speed_mps) in (3..).zip(stated.velocity_mps) {
        state.mean[axis] = f64::from(speed_mps);
    }
    Some(TargetMotion::begun(state, &settings.motion))
}

/// Adds a cluster of a certain track, and uses up a root and a number.
fn add(population: &mut Population, track: Track) {
    population.add_certain(track);
    population.next_root = population.next_root.wrapping_add(1).max(1);
    population.next_number = population.next_number.wrapping_add(1).max(1);
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use crate::Tracker;
    use crate::explanation::{Explanation, Observer, TrackEvent};
    use crate::initiation::Starts;
    use crate::settings::{SensorFacts, Settings};
    use crate::testing::{S, position, settings};
    use observations::{Detection, StatedVelocity};

    /// Sensor 2 designates, 300 m accurate.
    fn maintaining() -> Settings {
        let mut chosen = Settings {
            starts: Starts::Designated,
            ..settings()
        };
        chosen.capacity.open_scans = 4;
        let mut operator = SensorFacts {
            sensor_id: 2,
            ..SensorFacts::default()
        };
        operator.model.designates = true;
        chosen.sensors.push(operator);
        chosen
    }

    fn designation(second: i64, east: f64, north: f64) -> Detection {
        Detection {
            sensor_id: 2,
            sigmas: Some([300.0, 300.0, 0.0, 0.0]),
            ..position(second * S, east, north)
        }
    }

    /// Two targets, 5 km apart, which go north.
    fn look(tracker: &mut Tracker, second: i64) {
        let north = 15.0 * second as f64;
        let seen = [0.0, 5e3].map(|east| position(second * S, east, north));
        tracker.scan(1, second * S, &seen).unwrap();
    }

    fn easts(tracker: &Tracker) -> Vec<(u32, i64)> {
        let place = |track: &crate::TrackReport| (track.number, (track.estimate.mean[0] / 10.0).round() as i64);
        tracker.tracks().iter().map(place).collect()
    }

    #[test]
    fn only_designated_targets_are_followed() {
        let mut tracker = Tracker::new(maintaining()).unwrap();
        (0..10).for_each(|second| look(&mut tracker, second));
        assert_eq!((tracker.tracks().len(), tracker.branches()), (0, 0), "none of its own");
        tracker.scan(2, 10 * S, &[designation(10, 5100.0, 250.0)]).unwrap();
        assert_eq!(tracker.tracks().len(), 1, "confirmed at once");
        (11..20).for_each(|second| look(&mut tracker, second));
        assert_eq!(
            easts(&tracker),
            [(1, 500)],
            "from the designated place to the detections"
        );
        // A second designation of the same target changes nothing; a designation of the other target begins a track.
        let before = tracker.tracks()[0].estimate;
        let again = [designation(20, 5200.0, 100.0), designation(20, 100.0, 400.0)];
        tracker.scan(2, 20 * S, &again).unwrap();
        assert_eq!(tracker.tracks().len(), 2);
        assert_eq!(
            tracker.counts().designations_followed,
            1,
            "the second one of the first target"
        );
        assert_eq!(tracker.tracks()[0].estimate.velocity_mps(), before.velocity_mps());
        (21..30).for_each(|second| look(&mut tracker, second));
        assert_eq!(easts(&tracker), [(1, 500), (2, 0)]);
        // Designated at an empty place: the track ends by misses.
        tracker.scan(2, 30 * S, &[designation(30, -20e3, 0.0)]).unwrap();
        (31..60).for_each(|second| look(&mut tracker, second));
        assert_eq!(easts(&tracker), [(1, 500), (2, 0)]);
    }

    #[test]
    fn a_late_designation_is_used_in_its_place() {
        let run = |late: bool| {
            let mut tracker = Tracker::new(maintaining()).unwrap();
            for second in 0..6 {
                if second == 4 + i64::from(late) {
                    tracker.scan(2, 3 * S + S / 2, &[designation(3, 0.0, 0.0)]).unwrap();
                }
                look(&mut tracker, second);
            }
            tracker.tracks().to_vec()
        };
        assert_eq!(run(true).len(), 1);
        assert_eq!(run(true), run(false));
    }

    /// A target of 200 m/s, seen ten seconds after the designation among false detections.
    #[test]
    fn a_designation_with_a_velocity_is_followed_where_it_goes() {
        let run = |velocity: Option<StatedVelocity>| {
            let mut tracker = Tracker::new(maintaining()).unwrap();
            let named = Detection {
                velocity,
                ..designation(0, 0.0, 0.0)
            };
            tracker.scan(2, 0, &[named]).unwrap();
            let begun = tracker.tracks()[0].estimate;
            (10..14).for_each(|second| {
                let seen = [[0.0, 200.0 * second as f64], [300.0, -100.0]];
                let seen = seen.map(|[east, north]| position(second * S, east, north));
                tracker.scan(1, second * S, &seen).unwrap();
            });
            (begun, tracker.tracks().first().map(|track| track.estimate.mean[1]))
        };
        let (begun, north) = run(Some(StatedVelocity {
            velocity_mps: [0.0, 200.0],
            sigma_mps: 5.0,
        }));
        assert_eq!(begun.velocity_mps(), [0.0, 200.0, 0.0]);
        assert_eq!((begun.covariance.get(3, 3), begun.covariance.get(4, 4)), (25.0, 25.0));
        assert!(north.is_some_and(|north| (north - 2600.0).abs() < 30.0), "{north:?}");
        let (_, north) = run(None);
        assert!(north.is_some_and(|north| (north + 100.0).abs() < 30.0), "{north:?}");
    }

    /// A designation of a followed target changes nothing, is counted once however often the scan is processed, and is
    /// explained with the track.
    #[test]
    fn a_second_designation_is_counted_once_and_explained() {
        #[derive(Debug, Default)]
        struct Rows(RefCell<Vec<(u32, Option<u32>, bool)>>);
        impl Observer for Rows {
            fn explain(&self, what: &Explanation<'_>) {
                if let Explanation::Track {
                    event: TrackEvent::Designated,
                    track,
                    value,
                    limit,
                } = what
                {
                    self.0
                        .borrow_mut()
                        .push((track.number, track.detection_id, value <= limit));
                }
            }
        }
        let mut tracker = Tracker::new(maintaining()).unwrap();
        tracker.scan(2, 0, &[designation(0, 0.0, 0.0)]).unwrap();
        look(&mut tracker, 1);
        let rows = Rows::default();
        let again = Detection {
            detection_id: 77,
            ..designation(2, 50.0, 20.0)
        };
        tracker.scan_explained(2, 2 * S, &[again], Some(&rows)).unwrap();
        assert_eq!(*rows.0.borrow(), [(1, Some(77), true)]);
        assert_eq!(tracker.counts().designations_followed, 1);
        // A scan that comes late: the designation is worked off again, and not counted again.
        tracker.scan(1, S + S / 2, &[position(S + S / 2, 0.0, 22.0)]).unwrap();
        assert_eq!(tracker.counts().designations_followed, 1);
        assert_eq!(tracker.tracks().len(), 1);
    }

    #[test]
    fn without_a_designator_a_tracker_must_start_tracks() {
        let chosen = Settings {
            starts: Starts::Designated,
            ..settings()
        };
        let refused = Tracker::new(chosen).unwrap_err();
        assert!(refused.to_string().contains("designates"), "{refused}");
    }
}
