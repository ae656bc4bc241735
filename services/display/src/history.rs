//! Past of the track picture: every state of every system track, within the configured time span and memory.
//!
//! States are stored in the order of arrival, each with the picture's time at that moment. A picture of the past is
//! therefore exactly the picture shown then. Periodic notes list the latest state of every track; a search starts
//! at the note before the wanted moment and visits only the states after it. Once half of the memory is used, the
//! history stores one state per track and second, plus every state in which anything but the motion has changed.

use std::collections::{BTreeMap, VecDeque};

use messages::picture::PictureTrack;
use messages::{Contribution, SystemTrack, TrackState};

/// Time between two notes of the latest states, nanoseconds.
const NOTE_NS: i64 = 5_000_000_000;
/// Time between two stored states of a track when memory is scarce, nanoseconds.
const STEP_NS: i64 = 1_000_000_000;
/// Backward step of the picture's clock that clears the past, nanoseconds.
const LEAP_NS: i64 = 10_000_000_000;
/// Number that stands for no state.
const NONE: u64 = u64::MAX;

/// State of a track; number 0 marks the end of all tracks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Time of the picture at the state's arrival, UTC, nanoseconds.
    pub(crate) at_ns: i64,
    /// Reference time, UTC, nanoseconds.
    pub(crate) time_ns: i64,
    /// Time of the latest measurement, UTC, nanoseconds.
    pub(crate) measured_ns: i64,
    /// Normalised innovation squared of the causing report; 0 if there was no report.
    pub(crate) nis: f32,
    /// Record of the state; its ages are not set.
    pub(crate) track: PictureTrack,
    /// Number of the state's first contribution.
    contribution: u64,
    /// Number of the previous state of the same track.
    previous: u64,
}

/// History of system tracks, see the module's documentation.
#[derive(Debug)]
pub(crate) struct History {
    span_ns: i64,
    octets_max: usize,
    moments: VecDeque<Moment>,
    /// Number of the oldest state.
    first: u64,
    contributions: VecDeque<Contribution>,
    first_contribution: u64,
    notes: VecDeque<Note>,
    /// Number of the latest state of each track.
    latest: BTreeMap<u32, u64>,
    /// The same of tracks of replaced fusion processes: their successor may continue them under the same numbers.
    ended: BTreeMap<u32, u64>,
}

/// Latest states of all tracks before the state `next`.
#[derive(Debug)]
struct Note {
    next: u64,
    latest: Vec<(u32, u64)>,
}

/// Tracks at a moment, by the numbers of their states.
#[derive(Clone, Debug, Default)]
pub(crate) struct Then {
    /// State number by track number.
    pub(crate) states: BTreeMap<u32, u64>,
    /// Number of the first later state.
    next: u64,
}

impl History {
    /// Creates an empty history for the last `span_ns`, in at most `octets_max` bytes.
    pub(crate) fn new(span_ns: i64, octets_max: usize) -> Self {
        Self {
            span_ns,
            octets_max,
            moments: VecDeque::new(),
            first: 0,
            contributions: VecDeque::new(),
            first_contribution: 0,
            notes: VecDeque::new(),
            latest: BTreeMap::new(),
            ended: BTreeMap::new(),
        }
    }

    /// Stores a state that arrived at picture time `at_ns`.
    pub(crate) fn keep(&mut self, at_ns: i64, record: PictureTrack, measured_ns: i64, track: &SystemTrack) {
        let at_ns = self.in_order(at_ns);
        let running = self.latest.get(&record.number).copied();
        if self.octets() > self.octets_max / 2
            && let Some(before) = running.and_then(|number| self.moment(number))
            && at_ns - before.at_ns < STEP_NS
            && (before.track.state, before.track.main_source) == (record.state, record.main_source)
        {
            return;
        }
        let previous = running.or_else(|| self.ended.remove(&record.number)).unwrap_or(NONE);
        let contribution = self.first_contribution + self.contributions.len() as u64;
        self.contributions.extend(track.contributions());
        let number = self.push(Moment {
            at_ns,
            time_ns: track.reference_time_ns,
            measured_ns,
            nis: track.nis,
            track: record,
            contribution,
            previous,
        });
        match TrackState::is_off(record.state) {
            true => self.latest.remove(&record.number),
            false => self.latest.insert(record.number, number),
        };
    }

    /// Ends all tracks because their fusion process was replaced.
    pub(crate) fn end_all(&mut self, at_ns: i64) {
        let at_ns = self.in_order(at_ns);
        let first = self.first;
        self.ended.append(&mut self.latest);
        self.ended.retain(|_, state| *state >= first);
        self.push(Moment {
            at_ns,
            time_ns: at_ns,
            measured_ns: at_ns,
            nis: 0.0,
            track: PictureTrack::default(),
            contribution: self.first_contribution + self.contributions.len() as u64,
            previous: NONE,
        });
    }

    /// Returns a time not before the stored states: a machine's clock that is set may go back a little. After a
    /// larger step back, the stored states are useless and are dropped.
    fn in_order(&mut self, at_ns: i64) -> i64 {
        let last_ns = self.moments.back().map_or(at_ns, |last| last.at_ns);
        if at_ns >= last_ns - LEAP_NS {
            return at_ns.max(last_ns);
        }
        while !self.moments.is_empty() {
            self.forget();
        }
        self.notes.clear();
        self.latest.clear();
        self.ended.clear();
        at_ns
    }

    fn push(&mut self, moment: Moment) -> u64 {
        let number = self.first + self.moments.len() as u64;
        let noted = self.notes.back().map(|note| note.next);
        let noted_ns = noted.and_then(|next| self.moment(next)).map(|moment| moment.at_ns);
        if noted_ns.is_none_or(|noted_ns| moment.at_ns - noted_ns >= NOTE_NS) {
            self.notes.push_back(Note {
                next: number,
                latest: self.latest.iter().map(|(track, state)| (*track, *state)).collect(),
            });
        }
        self.moments.push_back(moment);
        while self
            .moments
            .front()
            .is_some_and(|oldest| oldest.at_ns < moment.at_ns - self.span_ns)
            || (self.octets() > self.octets_max && self.moments.len() > 1)
        {
            self.forget();
        }
        number
    }

    fn forget(&mut self) {
        self.moments.pop_front();
        self.first += 1;
        let kept = self.moments.front().map_or(u64::MAX, |oldest| oldest.contribution);
        while self.first_contribution < kept && self.contributions.pop_front().is_some() {
            self.first_contribution += 1;
        }
        while self.notes.front().is_some_and(|note| note.next < self.first) {
            self.notes.pop_front();
        }
    }

    /// Returns the memory in use, bytes.
    fn octets(&self) -> usize {
        let notes = self.notes.len() * self.latest.len() * size_of::<(u32, u64)>();
        size_of::<Moment>() * self.moments.len() + size_of::<Contribution>() * self.contributions.len() + notes
    }

    /// Returns start and end of the history, UTC, nanoseconds; `None` while it is empty.
    pub(crate) fn span_ns(&self) -> Option<[i64; 2]> {
        Some([self.moments.front()?.at_ns, self.moments.back()?.at_ns])
    }

    /// Returns the state of this number; `None` if it was dropped or never existed.
    pub(crate) fn moment(&self, number: u64) -> Option<&Moment> {
        self.moments.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    /// Returns the contributions to the state of this number.
    pub(crate) fn contributions(&self, number: u64) -> impl Iterator<Item = &Contribution> {
        let end = self.first_contribution + self.contributions.len() as u64;
        let range = self.moment(number).map_or(end..end, |moment| {
            let next = self.moment(number + 1).map_or(end, |next| next.contribution);
            moment.contribution..next
        });
        let place = |number: u64| (number.saturating_sub(self.first_contribution)) as usize;
        self.contributions.range(place(range.start)..place(range.end))
    }

    /// Returns the states of a track up to `until_ns`, the latest first, with their numbers.
    pub(crate) fn of_track(&self, track: u32, until_ns: i64) -> impl Iterator<Item = (u64, &Moment)> {
        let number = match self.latest.get(&track) {
            Some(number) => *number,
            None => {
                let ended = self.moments.iter().rposition(|moment| moment.track.number == track);
                ended.map_or(NONE, |place| self.first + place as u64)
            }
        };
        let states = self.numbered_back_from(number);
        states.skip_while(move |(_, moment)| moment.at_ns > until_ns)
    }

    /// Returns the state of this number and the earlier states of the same track, the latest first.
    pub(crate) fn back_from(&self, number: u64) -> impl Iterator<Item = &Moment> {
        self.numbered_back_from(number).map(|(_, moment)| moment)
    }

    fn numbered_back_from(&self, mut number: u64) -> impl Iterator<Item = (u64, &Moment)> {
        std::iter::from_fn(move || {
            let found = (number, self.moment(number)?);
            number = found.1.previous;
            Some(found)
        })
    }

    /// Moves `then` to the time `at_ns`.
    pub(crate) fn go_to(&self, then: &mut Then, at_ns: i64) {
        let end = self.first + self.moments.partition_point(|moment| moment.at_ns <= at_ns) as u64;
        let note = self.notes.iter().rfind(|note| note.next <= end);
        if then.next > end || note.is_some_and(|note| note.next > then.next) || then.next < self.first {
            let latest = note.map(|note| note.latest.iter().copied());
            then.states = latest
                .into_iter()
                .flatten()
                .filter(|(_, state)| *state >= self.first)
                .collect();
            then.next = note.map_or(self.first, |note| note.next);
        }
        for number in then.next..end {
            let Some(moment) = self.moment(number) else { break };
            match moment.track.number {
                0 => then.states.clear(),
                gone if TrackState::is_off(moment.track.state) => drop(then.states.remove(&gone)),
                track => drop(then.states.insert(track, number)),
            }
        }
        then.next = end;
        // Dropped states are too old to be shown.
        then.states.retain(|_, state| *state >= self.first);
    }
}

#[cfg(test)]
mod tests {
    use test_support::{Random, S};

    use super::*;

    fn state(number: u32, east_m: f32, state: TrackState) -> PictureTrack {
        PictureTrack {
            number,
            east_m,
            state: state as u8,
            ..PictureTrack::default()
        }
    }

    fn track(weights: &[f64]) -> SystemTrack {
        let mut track = SystemTrack {
            contribution_count: weights.len() as u16,
            ..SystemTrack::default()
        };
        for (part, weight) in track.contributions.iter_mut().zip(weights) {
            part.weight = *weight;
        }
        track
    }

    fn below(random: &mut Random, bound: usize) -> usize {
        (random.unit() * bound as f64) as usize
    }

    fn shown(history: &History, then: &Then) -> Vec<(u32, f32)> {
        let place = |(track, state): (&u32, &u64)| (*track, history.moment(*state).unwrap().track.east_m);
        then.states.iter().map(place).collect()
    }

    #[test]
    fn the_past_is_what_was_shown_whichever_way_one_comes_there() {
        let mut history = History::new(1_000 * S, usize::MAX);
        let (mut random, mut present, mut pictures) = (Random::new(5), BTreeMap::new(), Vec::new());
        for step in 0..3_000_i64 {
            let at_ns = step * S / 20;
            let number = 1 + below(&mut random, 30) as u32;
            if step == 1_700 {
                history.end_all(at_ns);
                present.clear();
            } else if below(&mut random, 9) == 0 {
                let off = [TrackState::Suspended, TrackState::Terminated][below(&mut random, 2)];
                history.keep(at_ns, state(number, 0.0, off), 0, &track(&[]));
                present.remove(&number);
            } else {
                history.keep(
                    at_ns,
                    state(number, step as f32, TrackState::Confirmed),
                    0,
                    &track(&[0.25, 0.75]),
                );
                present.insert(number, step as f32);
            }
            pictures.push((at_ns, present.clone().into_iter().collect::<Vec<_>>()));
        }
        let mut then = Then::default();
        for step in 0..500 {
            // Small steps forwards, and an occasional jump to a random place.
            let place = if step % 50 == 0 {
                below(&mut random, 3_000)
            } else {
                (step * 7) % 3_000
            };
            let (at_ns, expected) = &pictures[place];
            history.go_to(&mut then, *at_ns);
            assert_eq!(shown(&history, &then), *expected, "{at_ns}");
        }
        let (number, _) = history.of_track(7, i64::MAX).next().unwrap();
        let parts: Vec<f64> = history.contributions(number).map(|part| part.weight).collect();
        assert!(parts == [0.25, 0.75] || parts.is_empty(), "{parts:?}");
    }

    #[test]
    fn a_track_that_another_fusion_continues_keeps_its_past() {
        // Half of the memory is in use: states are stored once a second.
        for is_scarce in [false, true] {
            let mut history = History::new(600 * S, usize::MAX);
            for second in 0..4 {
                history.keep(
                    second * S,
                    state(7, second as f32, TrackState::Confirmed),
                    0,
                    &track(&[1.0]),
                );
                history.keep(
                    second * S,
                    state(8, second as f32, TrackState::Confirmed),
                    0,
                    &track(&[1.0]),
                );
            }
            if is_scarce {
                history.octets_max = history.octets() * 19 / 10;
            }
            history.end_all(3 * S + S / 10);
            history.keep(3 * S + S / 5, state(7, 4.0, TrackState::Confirmed), 0, &track(&[1.0]));
            let east = |history: &History| -> Vec<f32> {
                let states = history.of_track(7, i64::MAX);
                states.map(|(_, moment)| moment.track.east_m).collect()
            };
            assert_eq!(east(&history), [4.0, 3.0, 2.0, 1.0, 0.0]);
            let mut then = Then::default();
            history.go_to(&mut then, 4 * S);
            assert_eq!(shown(&history, &then), [(7, 4.0)], "track 8 has not come again");
            history.end_all(5 * S);
            history.keep(6 * S, state(8, 6.0, TrackState::Confirmed), 0, &track(&[1.0]));
            history.keep(6 * S, state(7, 6.0, TrackState::Terminated), 0, &track(&[1.0]));
            assert_eq!(history.of_track(8, i64::MAX).count(), 5);
            history.keep(7 * S, state(7, 7.0, TrackState::Confirmed), 0, &track(&[1.0]));
            assert_eq!(east(&history), [7.0], "a number that ended begins anew");
        }
    }

    #[test]
    fn a_clock_that_goes_back_a_little_stands_still_and_one_that_leaps_begins_anew() {
        let mut history = History::new(600 * S, usize::MAX);
        for at_s in [100, 101, 99, 102] {
            history.keep(
                at_s * S,
                state(1, at_s as f32, TrackState::Confirmed),
                0,
                &track(&[1.0]),
            );
        }
        let mut then = Then::default();
        history.go_to(&mut then, 101 * S);
        assert_eq!(shown(&history, &then), [(1, 99.0)], "in the order of arrival");
        history.keep(10 * S, state(2, 10.0, TrackState::Confirmed), 0, &track(&[1.0]));
        assert_eq!(history.span_ns(), Some([10 * S, 10 * S]));
        history.go_to(&mut then, 10 * S);
        assert_eq!(shown(&history, &then), [(2, 10.0)]);
    }

    #[test]
    fn memory_is_bounded_and_the_oldest_is_forgotten_first() {
        let octets_max = 100_000;
        let mut history = History::new(100 * S, octets_max);
        for step in 0..20_000_i64 {
            let record = state(1 + (step % 50) as u32, step as f32, TrackState::Confirmed);
            history.keep(step * S / 100, record, 0, &track(&[0.5; 3]));
            assert!(history.octets() <= octets_max, "{}", history.octets());
        }
        let [from_ns, to_ns] = history.span_ns().unwrap();
        assert!(from_ns >= to_ns - 100 * S && from_ns < to_ns);
        assert!(history.first > 0 && history.moments.len() > 100);
        let mut then = Then::default();
        history.go_to(&mut then, to_ns);
        assert_eq!(then.states.len(), 50);
        let rows: Vec<f32> = history
            .of_track(3, i64::MAX)
            .map(|(_, moment)| moment.track.east_m)
            .collect();
        assert!(rows.len() > 1 && rows.is_sorted_by(|a, b| a > b), "{rows:?}");
        history.go_to(&mut then, 0);
        assert!(then.states.is_empty(), "before everything that is known");
    }
}
