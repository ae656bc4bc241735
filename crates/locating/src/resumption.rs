//! Going on with the emitters of a locator whose process was killed.
//!
//! Kept is what tells emitters apart: their numbers, their frequencies and their last bearings, and the number that
//! comes next. So the next bearing of an emitter finds it, and its track keeps its number. The fix itself follows from
//! many bearings; it is found anew from those that come.

use std::sync::atomic::AtomicU64;

use kept::{Memory, Picture, Refused, kept};

use crate::locator::{Known, Locator};
use crate::settings::Settings;

kept! {
    /// Numbers and times of a locator.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Front {
        kept_ns: i64,
        next_number: u32,
    }
}

/// Memory in which a locator keeps its emitters.
#[derive(Debug)]
pub struct EmitterMemory {
    picture: Picture<Front, Known>,
    known: Vec<Known>,
}

impl EmitterMemory {
    /// Words that it takes for a locator with these settings.
    pub fn words(settings: &Settings) -> usize {
        Picture::<Front, Known>::words(settings.emitters_max)
    }

    /// In `memory`, which is blank; `owner` tells whose locator it is.
    pub fn begin(memory: Box<dyn Memory>, owner: &str, settings: &Settings) -> Self {
        Self {
            picture: Picture::begin(memory, owner, settings.emitters_max),
            known: Vec::with_capacity(settings.emitters_max),
        }
    }
}

/// Emitters that another locator has left.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftEmitters {
    front: Front,
    emitters: Vec<Known>,
}

impl LeftEmitters {
    /// Reads what a locator with the same settings has kept; `None` if it has kept nothing yet.
    ///
    /// # Errors
    /// If it is not whole, or another one's.
    pub fn read(memory: &[AtomicU64], owner: &str, settings: &Settings) -> Result<Option<Self>, Refused> {
        let found = Picture::read(memory, owner, settings.emitters_max)?;
        Ok(found.map(|(front, emitters)| Self { front, emitters }))
    }

    /// Time at which they were kept, UTC, nanoseconds.
    pub fn kept_ns(&self) -> i64 {
        self.front.kept_ns
    }

    /// Forgets the emitters; their numbers stay taken.
    pub fn end(&mut self) {
        self.emitters.clear();
    }
}

impl Locator {
    /// Keeps the emitters; it is `now_ns` (UTC, nanoseconds).
    pub fn keep(&self, memory: &mut EmitterMemory, now_ns: i64) {
        let EmitterMemory { picture, known } = memory;
        let front = Front {
            kept_ns: now_ns,
            next_number: self.next_number(),
        };
        known.clear();
        known.extend(self.known());
        picture.write(&front, known.iter());
    }

    /// Goes on with the emitters that another one has left. To be said before the first bearing.
    pub fn resume(&mut self, left: &LeftEmitters) {
        self.resume_numbers(left.front.next_number);
        left.emitters.iter().for_each(|emitter| self.resume_emitter(emitter));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use observations::Bearing;

    use super::*;

    /// Bearings of two emitters, told apart by their frequencies, from a platform that flies east.
    fn bearings(second: i64) -> [Bearing; 2] {
        [(0.0, 20_000.0, 9.0e9), (10_000.0, 30_000.0, 9.4e9)].map(|(east, north, frequency_hz)| {
            let platform_m = [100.0 * second as f64, 0.0, 1000.0];
            Bearing {
                time_of_measurement_ns: second * 1_000_000_000,
                bearing_rad: f64::atan2(east - platform_m[0], north),
                sigma_rad: 0.01,
                platform_m,
                frequency_hz: Some(frequency_hz),
                emitter_id: None,
                heading_rad: None,
                pulse_interval_s: None,
            }
        })
    }

    #[test]
    fn a_successor_gives_each_emitter_its_number_and_none_twice() {
        let settings = Settings::default();
        let memory = Arc::new(
            (0..EmitterMemory::words(&settings))
                .map(|_| AtomicU64::new(0))
                .collect::<Vec<_>>(),
        );
        let mut kept = EmitterMemory::begin(Box::new(memory.clone()), "finder", &settings);
        let mut first = Locator::new(settings).unwrap();
        // The second one is heard first by the successor.
        let numbers = |locator: &mut Locator, seconds: std::ops::Range<i64>| {
            let mut numbers = [0; 2];
            for second in seconds {
                let heard = bearings(second);
                for place in [1, 0] {
                    if let Some(report) = locator.bearing(&heard[place]).unwrap() {
                        numbers[place] = report.number;
                    }
                }
            }
            numbers
        };
        let before = numbers(&mut first, 0..120);
        first.keep(&mut kept, 7);
        let mut left = LeftEmitters::read(memory.words(), "finder", &settings)
            .unwrap()
            .unwrap();
        assert_eq!(left.kept_ns(), 7);
        let mut second = Locator::new(settings).unwrap();
        second.resume(&left);
        assert_eq!(numbers(&mut second, 120..240), before);
        left.end();
        let mut third = Locator::new(settings).unwrap();
        third.resume(&left);
        let anew = numbers(&mut third, 120..240);
        assert!(
            anew.iter().all(|number| number > before.iter().max().unwrap()),
            "{anew:?} {before:?}"
        );
    }
}
