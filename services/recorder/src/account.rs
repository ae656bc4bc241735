//! Account of one topic of the recorded stream: position and losses.
//!
//! Two sequences are followed. Each publisher counts its own samples in the headers of its slices: the [`Tally`]
//! finds samples lost in transit or with a terminated recorder. Samples of a replayed input are also numbered from 0
//! over all publishers of the topic. These [`SampleNumbers`] show samples that a restarted adapter publishes again, and
//! samples lost with an adapter or a recorder.

use std::collections::BTreeSet;

use messages::layout::Layout;
use messages::{BatchHeader, Streamed};
use recording::{Facts, Tally};

/// Position and losses of one topic.
#[derive(Debug)]
pub(crate) struct Account {
    name: String,
    layout: Layout,
    tally: Tally,
    /// Samples lost before the start of this recorder.
    lost_before: u64,
    /// Publishers of which this recorder has had a slice.
    met: BTreeSet<u64>,
    losses: Losses,
    samples: u64,
    numbers: Option<SampleNumbers>,
    progress_ns: i64,
}

/// Samples lost since the start, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Losses {
    /// With an earlier recorder.
    pub(crate) ended: u64,
    /// Recorder too slow.
    pub(crate) behind: u64,
    /// Files that could not be written.
    pub(crate) unwritten: u64,
}

impl Losses {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            ended: self.ended + other.ended,
            behind: self.behind + other.behind,
            unwritten: self.unwritten + other.unwritten,
        }
    }
}

/// Sample numbers of a replayed input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SampleNumbers {
    /// Number of the next sample: earlier samples are recorded or lost, even if published again.
    next: u64,
    /// Missing samples; `None` if the position of an earlier recorder is unknown.
    missing: Option<Missing>,
}

/// Samples of a replayed input that are not recorded, whichever recorder lost them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Missing {
    samples: u64,
    /// Samples already missing at the start of this recorder.
    before: u64,
}

impl SampleNumbers {
    /// Continues at the sample `next` of an input that lacks `missing` earlier samples.
    pub(crate) fn after(next: u64, missing: u64) -> Self {
        let missing = Missing {
            samples: missing,
            before: missing,
        };
        Self {
            next,
            missing: Some(missing),
        }
    }

    /// Notes a sample; returns whether it is new.
    fn add(&mut self, sequence: u64) -> bool {
        let Some(skipped) = sequence.checked_sub(self.next) else {
            return false;
        };
        if let Some(missing) = &mut self.missing {
            missing.samples += skipped;
        }
        self.next = sequence.saturating_add(1);
        true
    }
}

impl Account {
    /// Creates the account of the topic `name` with samples of this layout, from the tally left by an earlier
    /// recorder.
    pub(crate) fn new(name: String, layout: Layout, tally: Tally) -> Self {
        Self {
            name,
            layout,
            lost_before: tally.lost,
            met: BTreeSet::new(),
            losses: Losses::default(),
            tally,
            samples: 0,
            numbers: None,
            progress_ns: i64::MIN,
        }
    }

    /// Follows the sample numbers from this position.
    pub(crate) fn follow(&mut self, numbers: SampleNumbers) {
        self.numbers = Some(numbers);
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Adds the position to the facts for the beginning of a file.
    pub(crate) fn state(&self, facts: &mut Facts) {
        self.tally.state(&self.name, facts);
    }

    /// Notes a slice of `count` samples.
    pub(crate) fn add_slice(&mut self, header: &BatchHeader, count: usize) {
        let before = self.tally.lost;
        self.tally.slice(header, count);
        let lost = self.tally.lost - before;
        // What is missing before the first slice of a publisher went with an earlier recorder.
        match self.met.insert(header.incarnation) {
            true => self.losses.ended += lost,
            false => self.losses.behind += lost,
        }
        self.samples += count as u64;
    }

    /// Notes the samples of a slice; returns the number below which they had been recorded before.
    pub(crate) fn add_samples<T: Streamed>(&mut self, samples: &[T]) -> u64 {
        let from = self.next_sequence();
        for sample in samples {
            let numbers = self.numbers.as_mut();
            if numbers.is_none_or(|numbers| numbers.add(sample.sequence())) {
                self.progress_ns = self.progress_ns.max(sample.time_ns());
            }
        }
        from
    }

    /// Notes that a publisher had sent all samples below this number.
    pub(crate) fn catch_up(&mut self, incarnation: u64, next_sequence: u64) {
        let before = self.tally.lost;
        self.tally.catch_up(incarnation, next_sequence);
        self.losses.ended += self.tally.lost - before;
    }

    /// Notes that samples of added slices could not be written.
    pub(crate) fn add_lost(&mut self, count: u64) {
        self.tally.lost += count;
        self.losses.unwritten += count;
    }

    /// Returns the losses since the start by their causes.
    pub(crate) fn losses(&self) -> Losses {
        self.losses
    }

    /// Returns the next sequence number of a publisher, by its epoch; 0 for an unknown publisher.
    pub(crate) fn next_of(&self, incarnation: u64) -> u64 {
        self.tally.next_of(incarnation)
    }

    /// Returns the number of the next sample of a replayed input; 0 for topics without numbers.
    pub(crate) fn next_sequence(&self) -> u64 {
        self.numbers.map_or(0, |numbers| numbers.next)
    }

    /// Returns the number of samples of all slices since the start.
    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the number of samples lost since the start, including those found missing after an earlier recorder.
    pub(crate) fn lost(&self) -> u64 {
        self.tally.lost - self.lost_before
    }

    /// Returns the number of samples that did not arrive since the start, of which the subscriber missed
    /// `in_transit`. The numbers of a replay are more complete: they include samples lost with a terminated recorder.
    pub(crate) fn not_arrived(&self, in_transit: u64) -> u64 {
        let missing = self.numbers.and_then(|numbers| numbers.missing);
        missing.map_or(in_transit, |missing| missing.samples - missing.before)
    }

    /// Returns the number of missing samples of a replayed input, whichever recorder lost them; 0 for other topics.
    pub(crate) fn missing(&self) -> u64 {
        let missing = self.numbers.and_then(|numbers| numbers.missing);
        missing.map_or(0, |missing| missing.samples)
    }

    /// Returns the latest time of the data, UTC, nanoseconds; `i64::MIN` before the first sample.
    pub(crate) fn progress_ns(&self) -> i64 {
        self.progress_ns
    }
}

#[cfg(test)]
mod tests {
    use messages::SensorTrack;
    use messages::layout::Sample as _;

    use super::*;

    fn samples(numbers: impl IntoIterator<Item = u64>) -> Vec<SensorTrack> {
        let sample = |sequence| SensorTrack {
            sequence,
            time_of_measurement_ns: sequence as i64,
            ..SensorTrack::default()
        };
        numbers.into_iter().map(sample).collect()
    }

    fn account(numbers: Option<SampleNumbers>) -> Account {
        let mut account = Account::new("sensor/a/tracks".to_owned(), SensorTrack::LAYOUT, Tally::default());
        numbers.into_iter().for_each(|numbers| account.follow(numbers));
        account
    }

    #[test]
    fn numbers_show_repeated_and_missing_samples_over_all_publishers() {
        let mut account = account(Some(SampleNumbers::after(4, 1)));
        assert_eq!(account.add_samples(&samples(2..6)), 4);
        assert_eq!((account.next_sequence(), account.missing()), (6, 1));
        assert_eq!(account.add_samples(&samples([8, 9])), 6);
        assert_eq!(
            (account.next_sequence(), account.missing(), account.not_arrived(7)),
            (10, 3, 2)
        );
        account.add_samples(&samples(0..3));
        assert_eq!((account.next_sequence(), account.progress_ns()), (10, 9));
    }

    #[test]
    fn after_an_unknown_position_the_subscriber_counts_losses() {
        let mut account = account(Some(SampleNumbers::default()));
        assert_eq!(account.add_samples(&samples([5, 7])), 0);
        account.add_samples(&samples(2..8));
        assert_eq!(
            (account.next_sequence(), account.missing(), account.not_arrived(3)),
            (8, 0, 3)
        );
    }

    #[test]
    fn topics_without_numbers_count_what_the_subscriber_missed() {
        let mut account = account(None);
        assert_eq!(account.add_samples(&samples([5, 7])), 0);
        assert_eq!((account.next_sequence(), account.not_arrived(3)), (0, 3));
    }
}
