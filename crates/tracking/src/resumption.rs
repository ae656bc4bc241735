//! Resumption of the tracks of a tracker whose process was killed.
//!
//! Other processes hold a tracker's confirmed tracks and track numbers. So after a scan the best branch of each
//! confirmed track is saved completely, together with the next free numbers. The resuming tracker begins with these
//! tracks, each as the only explanation of a separate cluster. Alternatives, tentative tracks and the estimate of false
//! detections form again within a few scans.

use std::sync::atomic::AtomicU64;

use kept::{Memory, MemoryRefusal, Picture, kept};

use crate::settings::Settings;
use crate::track::Track;
use crate::tracker::Tracker;

kept! {
    /// Numbers and times of a tracker.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct TrackerHead {
        kept_ns: i64,
        time_ns: i64,
        next_serial: u32,
        next_root: u32,
        next_number: u32,
    }
}

/// Memory for a tracker's confirmed tracks.
#[derive(Debug)]
pub struct TrackerMemory(Picture<TrackerHead, Track>);

impl TrackerMemory {
    /// Size in words of the memory for a tracker with these settings.
    pub fn words(settings: &Settings) -> usize {
        Picture::<TrackerHead, Track>::words(settings.capacity.tracks())
    }

    /// Begins in `memory`, which is blank; `owner` identifies the tracker.
    pub fn begin(memory: Box<dyn Memory>, owner: &str, settings: &Settings) -> Self {
        Self(Picture::begin(memory, owner, settings.capacity.tracks()))
    }
}

/// Tracks that another tracker has left.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftTracks {
    front: TrackerHead,
    tracks: Vec<Track>,
}

impl LeftTracks {
    /// Reads the tracks saved by a tracker with the same settings; `None` if none are saved yet.
    ///
    /// # Errors
    /// If the memory is incomplete, or belongs to another tracker.
    pub fn read(memory: &[AtomicU64], owner: &str, settings: &Settings) -> Result<Option<Self>, MemoryRefusal> {
        let found = Picture::read(memory, owner, settings.capacity.tracks())?;
        Ok(found.map(|(front, tracks)| Self { front, tracks }))
    }

    /// Time of the saved tracks, UTC, nanoseconds.
    pub fn kept_ns(&self) -> i64 {
        self.front.kept_ns
    }

    /// Forgets the tracks; the numbers stay taken.
    pub fn end(&mut self) {
        self.tracks.clear();
        self.front.time_ns = i64::MIN;
    }
}

impl Tracker {
    /// Keeps the confirmed tracks at the time `now_ns` (UTC, nanoseconds).
    pub fn keep(&self, memory: &mut TrackerMemory, now_ns: i64) {
        let population = self.latest();
        let front = TrackerHead {
            kept_ns: now_ns,
            time_ns: population.time_ns,
            next_serial: population.next_serial,
            next_root: population.next_root,
            next_number: population.next_number,
        };
        let best = self.best_branches().iter();
        memory
            .0
            .write(&front, best.map(|best| &population.tracks[best.track as usize]));
    }

    /// Resumes the tracks of another tracker. Must be called before the first scan.
    pub fn resume(&mut self, left: &LeftTracks) {
        let population = self.first_population();
        population.time_ns = left.front.time_ns;
        population.next_serial = left.front.next_serial;
        population.next_root = left.front.next_root;
        population.next_number = left.front.next_number;
        for track in &left.tracks {
            if !population.has_room(1, 1, 1) {
                break;
            }
            population.add_certain(Track {
                reliability: 1.0,
                ..*track
            });
        }
        self.report(None);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::testing::{position, settings};

    fn scan(tracker: &mut Tracker, second: i64) {
        let detections =
            [0.0, 20_000.0].map(|east| position(second * 1_000_000_000, east + 15.0 * second as f64, 5000.0));
        let sensor = tracker.settings().sensors[0].sensor_id;
        tracker.scan(sensor, second * 1_000_000_000, &detections).unwrap();
    }

    #[test]
    fn a_successor_goes_on_with_the_same_tracks_under_the_same_numbers() {
        let settings = settings();
        let memory = Arc::new(
            (0..TrackerMemory::words(&settings))
                .map(|_| AtomicU64::new(0))
                .collect::<Vec<_>>(),
        );
        let mut kept = TrackerMemory::begin(Box::new(memory.clone()), "radar", &settings);
        let mut first = Tracker::new(settings.clone()).unwrap();
        for second in 0..10 {
            scan(&mut first, second);
            first.keep(&mut kept, second);
        }
        let read = || LeftTracks::read(memory.words(), "radar", &settings).unwrap().unwrap();
        let mut second = Tracker::new(settings.clone()).unwrap();
        assert_eq!(read().kept_ns(), 9);
        second.resume(&read());
        assert_eq!(first.tracks().len(), 2);
        // The detections behind the last reports are not kept.
        let kept = |track: &crate::TrackReport| crate::TrackReport {
            measured_m: None,
            ..*track
        };
        assert!(first.tracks().iter().all(|track| track.measured_m.is_some()));
        assert_eq!(second.tracks(), first.tracks().iter().map(kept).collect::<Vec<_>>());
        for time in 10..20 {
            scan(&mut first, time);
            scan(&mut second, time);
            let numbers = |tracker: &Tracker| tracker.tracks().iter().map(|track| track.number).collect::<Vec<_>>();
            assert_eq!(numbers(&second), numbers(&first), "{time}");
        }
        let mut too_old = read();
        too_old.end();
        let mut third = Tracker::new(settings.clone()).unwrap();
        third.resume(&too_old);
        (10..20).for_each(|time| scan(&mut third, time));
        let highest = first.tracks().iter().map(|track| track.number).max();
        assert_eq!(third.tracks().len(), 2);
        assert!(third.tracks().iter().all(|track| Some(track.number) > highest));
        assert!(LeftTracks::read(memory.words(), "other", &settings).is_err());
    }
}
