//! Count of a topic's missing samples.
//!
//! The header of each slice states the number of samples that its publisher had sent before. The number of samples
//! between two slices is therefore known, even if the recorder died between them: the next file begins with the
//! progress of each publisher.

use std::collections::BTreeMap;

use messages::BatchHeader;

use crate::Facts;

/// Fact: start of the recording, monotonic, nanoseconds.
pub(crate) const SINCE: &str = "since_ns";

/// Topics of messages between processes. The publishers of one process share its epoch there, so that a gap has no
/// meaning.
const TALK: [&str; 4] = ["health", "control", "progress", "system/frame-origin"];

/// Count of a topic's missing samples.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples published during the recording that are not in the recording.
    pub lost: u64,
    /// Start of the recording, monotonic, nanoseconds: of publishers that started later, every sample is expected.
    pub since_ns: u64,
    /// Next sequence number of each publisher, by its epoch.
    next: BTreeMap<u64, u64>,
    is_talk: bool,
}

impl Tally {
    /// Creates the tally of topic `name` for a recording that starts at this monotonic time, nanoseconds.
    pub fn since(name: &str, since_ns: u64) -> Self {
        Self {
            since_ns,
            is_talk: TALK.contains(&name),
            ..Self::default()
        }
    }

    /// Creates the tally of topic `name` from the facts at the beginning of a file.
    pub fn begin(name: &str, facts: &Facts) -> Self {
        let number = |text: &String| text.parse().unwrap_or(0);
        let publisher = |(key, value): (&String, &String)| {
            let incarnation = key.strip_prefix(&next_key(name, ""))?.parse().ok()?;
            Some((incarnation, number(value)))
        };
        Self {
            lost: facts.get(&lost_key(name)).map_or(0, number),
            since_ns: facts.get(SINCE).map_or(0, number),
            next: facts.iter().filter_map(publisher).collect(),
            is_talk: TALK.contains(&name),
        }
    }

    /// Adds the tally of topic `name` to the facts for the beginning of the next file.
    pub fn state(&self, name: &str, facts: &mut Facts) {
        facts.insert(SINCE.to_owned(), self.since_ns.to_string());
        facts.insert(lost_key(name), self.lost.to_string());
        let next = |(incarnation, next): (&u64, &u64)| (next_key(name, &incarnation.to_string()), next.to_string());
        facts.extend(self.next.iter().map(next));
    }

    /// Removes losses from the facts.
    pub(crate) fn forget_losses(facts: &mut Facts) {
        facts.retain(|name, _| !name.starts_with(&lost_key("")));
    }

    /// Notes a slice of `count` samples.
    pub fn slice(&mut self, header: &BatchHeader, count: usize) {
        let (incarnation, first) = (header.incarnation, header.first_sequence);
        let begin = if incarnation >= self.since_ns { 0 } else { first };
        let next = self.next.entry(incarnation).or_insert(begin);
        self.lost += if self.is_talk { 0 } else { first.saturating_sub(*next) };
        *next = first.saturating_add(count as u64).max(*next);
    }

    /// Returns the next sequence number of a publisher, by its epoch; 0 for an unknown publisher.
    pub fn next_of(&self, incarnation: u64) -> u64 {
        self.next.get(&incarnation).copied().unwrap_or(0)
    }

    /// Notes that a publisher had sent all samples below this number: missing samples among them are lost.
    pub fn catch_up(&mut self, incarnation: u64, next_sequence: u64) {
        let header = BatchHeader {
            incarnation,
            first_sequence: next_sequence,
            ..BatchHeader::default()
        };
        // A publisher that existed before the recording, and of which no slice came, counts no loss.
        if incarnation >= self.since_ns || self.next.contains_key(&incarnation) {
            self.slice(&header, 0);
        }
    }

    /// Returns the publishers with slices.
    pub fn publishers(&self) -> usize {
        self.next.len()
    }
}

fn lost_key(topic: &str) -> String {
    format!("lost/{topic}")
}

fn next_key(topic: &str, incarnation: &str) -> String {
    format!("next/{topic}/{incarnation}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(incarnation: u64, first_sequence: u64) -> BatchHeader {
        BatchHeader {
            incarnation,
            first_sequence,
            ..BatchHeader::default()
        }
    }

    #[test]
    fn gaps_are_counted_for_each_publisher_and_through_the_beginning_of_a_file() {
        let mut tally = Tally::since("a/b", 100);
        tally.slice(&header(99, 7), 3);
        assert_eq!(tally.lost, 0, "it had begun before the recording");
        tally.slice(&header(99, 12), 1);
        tally.slice(&header(100, 4), 1);
        assert_eq!(tally.lost, 6);
        let mut facts = Facts::new();
        tally.state("a/b", &mut facts);
        Tally::default().state("a/b/c", &mut facts);
        facts.insert(SINCE.to_owned(), "100".to_owned());
        let mut after = Tally::begin("a/b", &facts);
        assert_eq!(after, tally);
        after.slice(&header(99, 14), 1);
        after.slice(&header(99, 10), 2);
        assert_eq!((after.lost, after.publishers()), (7, 2));
        after.catch_up(99, 17);
        after.catch_up(98, 1_000);
        after.catch_up(101, 2);
        assert_eq!((after.lost, after.publishers()), (11, 3));
        let mut talk = Tally::since("health", 0);
        talk.slice(&header(1, 22), 1);
        assert_eq!(talk.lost, 0);
    }
}
