//! Resumption of the emitters of a locator whose process was killed.
//!
//! The saved data distinguish emitters: their numbers, frequencies and last bearings, and the next free number. So
//! the next bearing of an emitter is associated with it, and its track keeps its number. The fix itself depends on
//! many bearings and is found again from new bearings.

use std::sync::atomic::AtomicU64;

use kept::{Memory, MemoryRefusal, Picture, kept};

use crate::locator::{EmitterRecord, Locator};
use crate::settings::Settings;

kept! {
    /// Numbers and times of a locator.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct LocatorHead {
        kept_ns: i64,
        next_number: u32,
    }
}

/// Memory for a locator's emitters.
#[derive(Debug)]
pub struct EmitterMemory {
    picture: Picture<LocatorHead, EmitterRecord>,
    known: Vec<EmitterRecord>,
}

impl EmitterMemory {
    /// Size in words of the memory for a locator with these settings.
    pub fn words(settings: &Settings) -> usize {
        Picture::<LocatorHead, EmitterRecord>::words(settings.emitters_max)
    }

    /// Begins in `memory`, which is blank; `owner` identifies the locator.
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
    front: LocatorHead,
    emitters: Vec<EmitterRecord>,
}

impl LeftEmitters {
    /// Reads the emitters saved by a locator with the same settings; `None` if none are saved yet.
    ///
    /// # Errors
    /// If the memory is incomplete, or belongs to another locator.
    pub fn read(memory: &[AtomicU64], owner: &str, settings: &Settings) -> Result<Option<Self>, MemoryRefusal> {
        let found = Picture::read(memory, owner, settings.emitters_max)?;
        Ok(found.map(|(front, emitters)| Self { front, emitters }))
    }

    /// Time of the saved emitters, UTC, nanoseconds.
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
        let front = LocatorHead {
            kept_ns: now_ns,
            next_number: self.next_number(),
        };
        known.clear();
        known.extend(self.known());
        picture.write(&front, known.iter());
    }

    /// Resumes the emitters of another locator. Must be called before the first bearing.
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

    /// Bearings of two emitters, distinguished by their frequencies, from a platform that flies east.
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
        // The successor receives the second emitter first.
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
