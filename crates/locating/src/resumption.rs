//! Resumption of the emitters of a locator after a kill of the process.
//!
//! Each emitter is a separate record: number, frequency and last bearing, by which the next bearing finds the emitter,
//! and the state of the filters and of the selection to the last bit. A successor thus continues as if nothing had
//! happened: the same bearings give the same fixes. Only emitters with new bearings are written, so the cost does not
//! depend on the number of emitters. A kill between two stores costs a record the last change ([`kept::RecordArea`]).
//!
//! The state of a filter has a meaning only for the settings used: the memory of a locator with other settings is
//! refused.

use std::sync::atomic::AtomicU64;

use kept::{Get, HEAD, Kept, Memory, MemoryRefusal, Put, RecordArea, RecordState, is_marked, kept, mark, mixed};

use crate::bank::Bank;
use crate::locator::{EmitterRecord, Locator};
use crate::selection::Selector;
use crate::settings::Settings;

kept! {
    /// Numbers and times of a locator.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct LocatorHead {
        kept_ns: i64,
        next_number: u32,
    }
}

/// Records in the memory of a locator.
#[derive(Clone, Copy, Debug)]
struct EmitterAreas {
    head: RecordArea,
    emitters: RecordArea,
    fingerprint: u64,
}

impl EmitterAreas {
    fn of(owner: &str, settings: &Settings) -> Self {
        let head = RecordArea {
            first: HEAD,
            places: 1,
            words: LocatorHead::WORDS,
        };
        let emitters = RecordArea {
            first: HEAD + head.len(),
            places: settings.emitters_max,
            words: EmitterRecord::WORDS + Bank::WORDS + Selector::KEPT_WORDS,
        };
        let stated = format!("{owner} {settings:?} {}", emitters.words);
        Self {
            head,
            emitters,
            fingerprint: stated.bytes().fold(0, |hash, octet| mixed(hash ^ u64::from(octet))),
        }
    }

    fn words(&self) -> usize {
        HEAD + self.head.len() + self.emitters.len()
    }
}

/// Memory for a locator's emitters.
#[derive(Debug)]
pub struct EmitterMemory {
    memory: Box<dyn Memory>,
    areas: EmitterAreas,
    /// Numbers of writes: of the head, and of each emitter.
    head_times: u64,
    times: Vec<u64>,
    words: Vec<u64>,
}

impl EmitterMemory {
    /// Size in words of the memory for a locator with these settings.
    pub fn words(settings: &Settings) -> usize {
        EmitterAreas::of("", settings).words()
    }

    /// Begins in `memory`, which is blank; `owner` identifies the locator.
    pub fn begin(memory: Box<dyn Memory>, owner: &str, settings: &Settings) -> Self {
        let areas = EmitterAreas::of(owner, settings);
        mark(memory.words(), areas.fingerprint);
        Self {
            memory,
            areas,
            head_times: 0,
            times: vec![0; areas.emitters.places],
            words: vec![0; areas.emitters.words.max(areas.head.words)],
        }
    }
}

/// Emitters that another locator has left.
#[derive(Clone, Debug)]
pub struct LeftEmitters {
    head: LocatorHead,
    emitters: Vec<(EmitterRecord, Bank, Selector)>,
}

impl LeftEmitters {
    /// Reads the emitters saved by a locator with the same settings; `None` if none are saved yet.
    ///
    /// # Errors
    /// If the memory is incomplete, or belongs to another locator or a locator with other settings.
    pub fn read(memory: &[AtomicU64], owner: &str, settings: &Settings) -> Result<Option<Self>, MemoryRefusal> {
        let areas = EmitterAreas::of(owner, settings);
        if !is_marked(memory, areas.words(), areas.fingerprint) {
            return Err(MemoryRefusal::Foreign);
        }
        let mut words = Vec::new();
        let head = match areas.head.read(memory, 0, &mut words) {
            RecordState::Nothing | RecordState::Torn { has_other: false } => return Ok(None),
            RecordState::Damaged => return Err(MemoryRefusal::Damaged(1)),
            RecordState::Whole | RecordState::Torn { has_other: true } => LocatorHead::get(&mut Get(&words)),
        };
        let head = head.ok_or(MemoryRefusal::Damaged(1))?;
        let (mut emitters, mut damaged) = (Vec::new(), 0);
        for place in 0..areas.emitters.places {
            match areas.emitters.read(memory, place, &mut words) {
                RecordState::Nothing | RecordState::Torn { has_other: false } => {}
                RecordState::Damaged => damaged += 1,
                RecordState::Whole | RecordState::Torn { has_other: true } => match emitter(&words, settings) {
                    Some(emitter) => emitters.push(emitter),
                    None => damaged += 1,
                },
            }
        }
        match damaged {
            0 => Ok(Some(Self { head, emitters })),
            records => Err(MemoryRefusal::Damaged(records)),
        }
    }

    /// Time of the saved emitters, UTC, nanoseconds.
    pub fn kept_ns(&self) -> i64 {
        self.head.kept_ns
    }

    /// Forgets the emitters; the numbers stay taken.
    pub fn end(&mut self) {
        self.emitters.clear();
    }
}

/// The emitter of a record.
fn emitter(words: &[u64], settings: &Settings) -> Option<(EmitterRecord, Bank, Selector)> {
    let mut from = Get(words);
    Some((
        EmitterRecord::get(&mut from)?,
        Bank::get(&mut from)?,
        Selector::get(settings.selection, &mut from)?,
    ))
}

impl Locator {
    /// Keeps the emitters that have changed, in new memory all emitters; the time is `now_ns` (UTC, nanoseconds).
    pub fn keep(&mut self, memory: &mut EmitterMemory, now_ns: i64) {
        let EmitterMemory {
            memory,
            areas,
            head_times,
            times,
            words,
        } = memory;
        let (head, is_new) = (
            LocatorHead {
                kept_ns: now_ns,
                next_number: self.next_number(),
            },
            *head_times == 0,
        );
        self.each_changed(is_new, |place, record, bank, selector| {
            let mut put = Put::new(words);
            record.put(&mut put);
            bank.put(&mut put);
            selector.put(&mut put);
            times[place] += 1;
            let of_record = &words[..areas.emitters.words];
            areas.emitters.write(memory.words(), place, times[place], of_record);
        });
        *head_times += 1;
        head.put(&mut Put::new(words));
        areas
            .head
            .write(memory.words(), 0, *head_times, &words[..areas.head.words]);
    }

    /// Resumes the emitters of another locator. Must be called before the first bearing.
    pub fn resume(&mut self, left: &LeftEmitters) {
        self.resume_numbers(left.head.next_number);
        for (record, bank, selector) in &left.emitters {
            self.resume_emitter(record, bank.clone(), selector.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::Ordering::Relaxed;

    use observations::{Bearing, ReadyFix};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::EmitterReport;
    use crate::selection::{Select, SelectionSettings};
    use crate::settings::{EmitterMotionSettings, FilterChoice};

    fn blank(settings: &Settings) -> Arc<Vec<AtomicU64>> {
        Arc::new((0..EmitterMemory::words(settings)).map(|_| AtomicU64::new(0)).collect())
    }

    fn begun(memory: &Arc<Vec<AtomicU64>>, settings: &Settings) -> EmitterMemory {
        EmitterMemory::begin(Box::new(Arc::clone(memory)), "finder", settings)
    }

    fn read(memory: &Arc<Vec<AtomicU64>>, settings: &Settings) -> Result<Option<LeftEmitters>, MemoryRefusal> {
        LeftEmitters::read(memory, "finder", settings)
    }

    fn few(filter: FilterChoice, select: Select) -> Settings {
        Settings {
            emitters_max: 4,
            motion: EmitterMotionSettings {
                filter,
                ..EmitterMotionSettings::default()
            },
            selection: SelectionSettings {
                select,
                interval_s: 40.0,
                minimum_gap_s: 20.0,
                ..SelectionSettings::default()
            },
            ..Settings::default()
        }
    }

    /// Bearings of two emitters, of which a single emitter sails at this speed, by frequencies, from a platform that
    /// circles.
    fn bearings(seconds: i64, speed_mps: f64) -> Vec<Bearing> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut all = Vec::new();
        for second in 0..seconds {
            let time_s = second as f64;
            let turn = time_s / 60.0;
            let platform_m = [4_000.0 * turn.sin(), 4_000.0 * turn.cos(), 1_000.0];
            for (east, north, frequency_hz) in
                [(0.0, 20_000.0, 9.0e9), (10_000.0 + speed_mps * time_s, 30_000.0, 9.4e9)]
            {
                let error: f64 = StandardNormal.sample(&mut random);
                all.push(Bearing {
                    time_of_measurement_ns: second * 1_000_000_000,
                    bearing_rad: f64::atan2(east - platform_m[0], north - platform_m[1]) + 0.01 * error,
                    sigma_rad: 0.01,
                    platform_m,
                    frequency_hz: Some(frequency_hz),
                    emitter_id: None,
                    heading_rad: Some(turn + std::f64::consts::FRAC_PI_2),
                    pulse_interval_s: None,
                });
            }
        }
        all
    }

    fn reports(locator: &mut Locator, bearings: &[Bearing]) -> Vec<Option<EmitterReport>> {
        bearings
            .iter()
            .map(|bearing| locator.bearing(bearing).unwrap())
            .collect()
    }

    /// A locator with these settings gives the same reports of `all` if killed after each of these numbers of bearings.
    fn check_successors<M>(
        settings: Settings,
        all: &[M],
        kills: &[usize],
        take: impl Fn(&mut Locator, &M) -> Option<EmitterReport>,
    ) {
        let mut through = Locator::new(settings).unwrap();
        let whole: Vec<_> = all.iter().map(|measured| take(&mut through, measured)).collect();
        let (filter, select) = (settings.motion.filter, settings.selection.select);
        assert!(
            whole.iter().flatten().count() > 300,
            "{filter:?} {select:?}: hardly a fix"
        );
        for killed_after in kills {
            let (before, after) = all.split_at(*killed_after);
            let memory = blank(&settings);
            let mut kept = begun(&memory, &settings);
            let mut first = Locator::new(settings).unwrap();
            for (nth, measured) in before.iter().enumerate() {
                take(&mut first, measured);
                first.keep(&mut kept, nth as i64);
            }
            let left = read(&memory, &settings).unwrap().unwrap();
            assert_eq!(left.kept_ns(), *killed_after as i64 - 1);
            let mut second = Locator::new(settings).unwrap();
            second.resume(&left);
            let continued: Vec<_> = after.iter().map(|measured| take(&mut second, measured)).collect();
            assert!(
                continued == whole[*killed_after..],
                "{filter:?} {select:?} after {killed_after}"
            );
        }
    }

    #[test]
    fn a_successor_gives_the_same_fixes_to_the_last_bit() {
        let heard = bearings(500, 8.0);
        for filter in FilterChoice::ALL {
            for select in Select::ALL {
                let take = |locator: &mut Locator, bearing: &Bearing| locator.bearing(bearing).unwrap();
                check_successors(few(filter, select), &heard, &[1, 7, 60, 191, 514, 803], take);
            }
        }
    }

    /// Fixes of others without a filter: the selection is all that is kept.
    #[test]
    fn a_successor_selects_fixes_as_they_are_to_the_last_bit() {
        let fixes: Vec<ReadyFix> = (0..400)
            .map(|second| {
                let turn = f64::from(second) / 30.0;
                let variance_m2 = 2_500.0 + 2_000.0 * (0.7 * turn).sin();
                ReadyFix {
                    time_of_measurement_ns: i64::from(second) * 1_000_000_000,
                    emitter_id: 7,
                    position_m: [50.0 * turn.sin() + f64::from(second), 80.0 * turn.cos(), 0.0],
                    covariance_m2: [variance_m2, 300.0, variance_m2],
                }
            })
            .collect();
        for select in Select::ALL {
            let take = |locator: &mut Locator, fix: &ReadyFix| locator.fix(fix).unwrap();
            check_successors(few(FilterChoice::None, select), &fixes, &[1, 7, 60, 191, 350], take);
        }
    }

    /// A successor keeps all emitters in new memory at once, and not only the emitters that have bearings again.
    #[test]
    fn a_second_kill_loses_no_emitter_that_was_silent_between() {
        let settings = few(FilterChoice::Auto, Select::Auto);
        let heard = bearings(200, 0.0);
        let of = |place: usize| heard.iter().copied().skip(place).step_by(2).collect::<Vec<_>>();
        let mut first = Locator::new(settings).unwrap();
        let numbers: Vec<u32> = [of(0), of(1)]
            .iter()
            .map(|own| reports(&mut first, own).last().unwrap().unwrap().number)
            .collect();
        let (memory, again) = (blank(&settings), blank(&settings));
        first.keep(&mut begun(&memory, &settings), 1);
        let mut second = Locator::new(settings).unwrap();
        second.resume(&read(&memory, &settings).unwrap().unwrap());
        let mut kept = begun(&again, &settings);
        second.keep(&mut kept, 2);
        let later = |bearing: &Bearing| Bearing {
            time_of_measurement_ns: bearing.time_of_measurement_ns + 200_000_000_000,
            ..*bearing
        };
        reports(&mut second, &[later(&of(0)[199])]);
        second.keep(&mut kept, 3);
        let mut third = Locator::new(settings).unwrap();
        third.resume(&read(&again, &settings).unwrap().unwrap());
        assert_eq!(third.emitters(), 2);
        let found = reports(&mut third, &[later(&of(1)[199])]);
        assert_eq!(found[0].map(|report| report.number), Some(numbers[1]));
    }

    #[test]
    fn memory_of_another_locator_is_refused_and_so_is_a_damaged_or_cut_one() {
        let settings = few(FilterChoice::Auto, Select::Auto);
        let memory = blank(&settings);
        let mut kept = begun(&memory, &settings);
        assert_eq!(
            read(&memory, &settings).unwrap().map(|_| ()),
            None,
            "nothing is kept yet"
        );
        let mut locator = Locator::new(settings).unwrap();
        let heard = bearings(60, 0.0);
        for bearing in &heard {
            locator.bearing(bearing).unwrap();
            locator.keep(&mut kept, 5);
        }
        let refusal = |found: Result<Option<LeftEmitters>, MemoryRefusal>| found.map(|_| ()).unwrap_err();
        let foreign = MemoryRefusal::Foreign;
        assert_eq!(refusal(LeftEmitters::read(&memory, "other", &settings)), foreign);
        let mut others = settings;
        others.motion.range_sigma_m += 1.0;
        assert_eq!(refusal(read(&memory, &others)), foreign);
        assert_eq!(refusal(LeftEmitters::read(&memory[1..], "finder", &settings)), foreign);
        assert_eq!(
            refusal(LeftEmitters::read(&memory[..memory.len() - 1], "finder", &settings)),
            foreign
        );
        // A kill during a write leaves the emitter in the previous state.
        let areas = EmitterAreas::of("finder", &settings);
        let copy = areas.emitters.len() / areas.emitters.places / 2;
        let word_of = |copy_number: usize| &memory[areas.emitters.first + copy_number * copy + 5];
        word_of(heard.len() / 2 % 2).fetch_xor(1, Relaxed);
        assert_eq!(read(&memory, &settings).unwrap().unwrap().emitters.len(), 2);
        word_of((heard.len() / 2 + 1) % 2).fetch_xor(1, Relaxed);
        assert_eq!(refusal(read(&memory, &settings)), MemoryRefusal::Damaged(1));
    }

    #[test]
    fn a_successor_gives_each_emitter_its_number_and_none_twice() {
        let settings = few(FilterChoice::Auto, Select::Auto);
        let (memory, heard) = (blank(&settings), bearings(240, 0.0));
        let mut first = Locator::new(settings).unwrap();
        let numbers = |locator: &mut Locator, heard: &[Bearing]| {
            let found = reports(locator, heard);
            [found[found.len() - 2], found[found.len() - 1]].map(|report| report.unwrap().number)
        };
        let before = numbers(&mut first, &heard[..240]);
        first.keep(&mut begun(&memory, &settings), 7);
        let mut left = read(&memory, &settings).unwrap().unwrap();
        let mut second = Locator::new(settings).unwrap();
        second.resume(&left);
        assert_eq!(numbers(&mut second, &heard[240..]), before);
        // Emitters that are too old leave only numbers.
        left.end();
        let mut third = Locator::new(settings).unwrap();
        third.resume(&left);
        let anew = numbers(&mut third, &heard[240..]);
        let greatest = before.iter().max().unwrap();
        assert!(anew.iter().all(|number| number > greatest), "{anew:?} {before:?}");
    }
}
