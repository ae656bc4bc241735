//! Division of a recording into pieces sent at once, with times.

use std::borrow::Cow;

use asterix::choice::ChosenEdition;
use asterix::times::{TICKS_PER_S, first_time_of_day, move_times};
use asterix::{Category, blocks, registry};
use csv_table::CsvError;
use formats::containers::{Container, Datagrams, TimeStamp};
use formats::foreign::Foreign;
use formats::sbs::{SbsLine, moved_line, stamped_ns};
use formats::snapshot_datagram;
use frames::time::{DayUnroller, NS_PER_DAY, NS_PER_S};

use super::snapshots;

/// Nanoseconds in a tick of ASTERIX.
const TICK_NS: i64 = NS_PER_S / TICKS_PER_S as i64;

/// Kind of pieces that a recording is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PieceKind {
    /// Datagrams: data blocks of ASTERIX, or snapshots of an antenna array.
    Datagrams,
    /// Lines of a transponder receiver.
    Lines,
}

/// Datagram or line of a recording.
#[derive(Clone, Debug)]
pub(super) struct Piece<'a> {
    pub(super) octets: Cow<'a, [u8]>,
    /// Time of recording, nanoseconds since the recording's own origin.
    recorded_ns: Option<i64>,
    /// Time stated by the first record or line, nanoseconds: of records, since midnight.
    stated_ns: Option<i64>,
}

impl Piece<'_> {
    /// Returns the time of the piece: time of recording, or the time stated in the records; `None` without both.
    fn time_ns(&self) -> Option<i64> {
        self.recorded_ns.or(self.stated_ns)
    }
}

/// The pieces of a recording.
#[derive(Debug)]
pub(super) struct Pieces<'a> {
    content: &'a [u8],
    tables: Vec<&'static Category>,
    kind: PieceKind,
    /// Datagrams of a table of snapshots, with their times, nanoseconds.
    snapshots: Option<Vec<(i64, Vec<u8>)>>,
    /// Length of the recording.
    pub(super) octets: usize,
}

impl<'a> Pieces<'a> {
    /// Returns the pieces of the recording `content`, with the given editions, or default editions, of categories.
    ///
    /// # Errors
    /// A row of a table of snapshots that cannot be read.
    pub(super) fn of(content: &'a [u8], editions: &[ChosenEdition]) -> Result<Self, CsvError> {
        let table = |chosen: &ChosenEdition| match chosen {
            ChosenEdition::Category(table) => Some(*table),
            ChosenEdition::Expansion(_) => None,
        };
        // Behind comments, too.
        let is_line = Foreign::of(content) == Some(Foreign::Sbs);
        let snapshots = snapshots::antennas(content).map(|antennas| snapshots::datagrams(content, antennas));
        Ok(Self {
            content,
            tables: editions.iter().filter_map(table).collect(),
            kind: if is_line {
                PieceKind::Lines
            } else {
                PieceKind::Datagrams
            },
            snapshots: snapshots.transpose()?,
            octets: content.len(),
        })
    }

    pub(super) fn kind(&self) -> PieceKind {
        self.kind
    }

    /// Whether the pieces are data blocks, or datagrams of a capture.
    pub(super) fn are_blocks(&self) -> bool {
        self.kind == PieceKind::Datagrams && self.snapshots.is_none()
    }

    /// Octets behind the last data block of a recording without a container.
    pub(super) fn octets_left_out(&self) -> usize {
        if !self.are_blocks() || Container::detect(self.content) != Container::Raw {
            return 0;
        }
        let error = blocks(self.content).find_map(Result::err);
        error.map_or(0, |error| self.octets - error.offset())
    }

    /// All, in the order of the recording.
    pub(super) fn iter(&self) -> Box<dyn Iterator<Item = Piece<'a>> + '_> {
        if let Some(snapshots) = &self.snapshots {
            return Box::new(snapshots.iter().map(|(time_ns, octets)| Piece {
                octets: Cow::Owned(octets.clone()),
                recorded_ns: None,
                stated_ns: Some(*time_ns),
            }));
        }
        match (self.kind, Container::detect(self.content)) {
            (PieceKind::Lines, _) => Box::new(self.lines()),
            // The recording does not contain the datagrams.
            (PieceKind::Datagrams, Container::Raw) => Box::new(self.blocks()),
            (PieceKind::Datagrams, container) => Box::new(self.datagrams(container)),
        }
    }

    fn table(&self, category: u8) -> Option<&'static Category> {
        let chosen = self.tables.iter().find(|table| table.number == category);
        chosen.copied().or_else(|| registry::default_edition(category))
    }

    fn stated_ns(&self, octets: &[u8]) -> Option<i64> {
        if let Some(time_ns) = snapshot_datagram::stated_ns(octets) {
            return Some(time_ns);
        }
        let ticks = first_time_of_day(octets, |category| self.table(category))?;
        Some(i64::from(ticks) * TICK_NS)
    }

    fn datagrams(&self, container: Container) -> impl Iterator<Item = Piece<'a>> + '_ {
        let is_known = |octets: &[u8]| {
            snapshot_datagram::is_snapshots(octets) || blocks(octets).next().is_some_and(|block| block.is_ok())
        };
        let known = Datagrams::new(container, self.content)
            .filter_map(Result::ok)
            .filter(move |datagram| is_known(&datagram.bytes));
        known.map(|datagram| Piece {
            recorded_ns: datagram.time_stamp.map(TimeStamp::ns),
            stated_ns: self.stated_ns(&datagram.bytes),
            octets: datagram.bytes,
        })
    }

    fn blocks(&self) -> impl Iterator<Item = Piece<'a>> + '_ {
        blocks(self.content).map_while(Result::ok).map(|block| Piece {
            octets: Cow::Borrowed(block.bytes),
            recorded_ns: None,
            stated_ns: self.stated_ns(block.bytes),
        })
    }

    fn lines(&self) -> impl Iterator<Item = Piece<'a>> + '_ {
        self.content.split_inclusive(|octet| *octet == b'\n').map(|line| {
            let stamped_ns = match SbsLine::parse(line) {
                Ok(SbsLine::Message(message)) => stamped_ns(message.received),
                _ => None,
            };
            Piece {
                octets: Cow::Borrowed(line),
                recorded_ns: stamped_ns,
                stated_ns: stamped_ns,
            }
        })
    }
}

/// The pieces of a recording with due times.
pub(super) struct Timed<'a, 'p> {
    pieces: Box<dyn Iterator<Item = Piece<'a>> + 'p>,
    first_ns: Option<i64>,
    since_first_ns: i64,
}

impl<'a, 'p> Timed<'a, 'p> {
    pub(super) fn new(pieces: &'p Pieces<'a>) -> Self {
        Self {
            pieces: pieces.iter(),
            first_ns: None,
            since_first_ns: 0,
        }
    }
}

impl<'a> Iterator for Timed<'a, '_> {
    /// A piece and its time since the first, nanoseconds; times never decrease.
    type Item = (i64, Piece<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let piece = self.pieces.next()?;
        if let Some(time_ns) = piece.time_ns() {
            let first_ns = *self.first_ns.get_or_insert(time_ns);
            let mut since_ns = time_ns - first_ns;
            if piece.recorded_ns.is_none() {
                // Times of day, round midnight.
                let ahead_ns = within_half_a_day(since_ns - self.since_first_ns);
                since_ns = self.since_first_ns + ahead_ns;
            }
            self.since_first_ns = self.since_first_ns.max(since_ns);
        }
        Some((self.since_first_ns, piece))
    }
}

/// Difference of two times of day, nanoseconds, from minus to plus half a day.
fn within_half_a_day(difference_ns: i64) -> i64 {
    (difference_ns + NS_PER_DAY / 2).rem_euclid(NS_PER_DAY) - NS_PER_DAY / 2
}

/// Returns the time of day of the recording's start, by the records, else by the time of recording, nanoseconds.
pub(super) fn begins_ns(pieces: &Pieces<'_>) -> Option<i64> {
    let stated = Timed::new(pieces).find_map(|(since_ns, piece)| Some(piece.stated_ns? - since_ns));
    let begins_ns = stated.or_else(|| pieces.iter().find_map(|piece| piece.time_ns()))?;
    Some(begins_ns)
}

/// Returns starts of recordings (nanoseconds, some of them times of day only) relative to the earliest.
pub(super) fn offsets_ns(begins_ns: &[Option<i64>]) -> Vec<i64> {
    let Some(first_ns) = begins_ns.iter().flatten().next() else {
        return vec![0; begins_ns.len()];
    };
    let behind = |begins_ns: &Option<i64>| begins_ns.map_or(0, |begins_ns| within_half_a_day(begins_ns - first_ns));
    let behind: Vec<i64> = begins_ns.iter().map(behind).collect();
    let earliest_ns = behind.iter().copied().min().unwrap_or(0);
    behind.iter().map(|behind_ns| behind_ns - earliest_ns).collect()
}

/// Moves the times that pieces state, all by the same.
#[derive(Debug)]
pub(super) struct Mover {
    /// Nanoseconds, whole seconds.
    by_ns: i64,
    /// The present day, for times with a stated day.
    days: DayUnroller,
    moved: Vec<u8>,
    /// Times that were moved so far.
    pub(super) count: u64,
}

impl Mover {
    /// Moves a recording that starts at `begins_ns` to `now_ns` (both nanoseconds), by whole seconds, so that no time
    /// is later than now.
    pub(super) fn new(begins_ns: i64, now_ns: i64) -> Self {
        Self {
            by_ns: (now_ns - begins_ns).div_euclid(NS_PER_S) * NS_PER_S,
            days: DayUnroller::near(now_ns),
            moved: Vec::new(),
            count: 0,
        }
    }

    /// Octets of a piece of `pieces` with its times moved.
    pub(super) fn moved(&mut self, piece: &Piece<'_>, pieces: &Pieces<'_>) -> &[u8] {
        let moved = &mut self.moved;
        moved.clear();
        match pieces.kind() {
            PieceKind::Datagrams => {
                moved.extend_from_slice(&piece.octets);
                if let Some(time_ns) = snapshot_datagram::stated_ns(moved) {
                    let day_ns = time_ns.saturating_add(self.by_ns).rem_euclid(NS_PER_DAY);
                    snapshot_datagram::set_time(moved, self.days.utc_ns(day_ns));
                    self.count += 1;
                    return moved;
                }
                let by = self.by_ns.rem_euclid(NS_PER_DAY) / TICK_NS;
                self.count += move_times(moved, by as u32, |category| pieces.table(category)) as u64;
            }
            PieceKind::Lines => self.count += u64::from(moved_line(&piece.octets, self.by_ns, moved)),
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_due_by_times_of_day_round_midnight_and_never_go_back() {
        let block = |tod_s: u32| {
            let [_, high, middle, low] = (tod_s * TICKS_PER_S).to_be_bytes();
            [48, 0, 9, 0xC0, 1, 2, high, middle, low]
        };
        let content: Vec<u8> = [86_398, 86_399, 86_397, 1].into_iter().flat_map(block).collect();
        let pieces = Pieces::of(&content, &[]).unwrap();
        let due: Vec<i64> = Timed::new(&pieces).map(|(due_ns, _)| due_ns / NS_PER_S).collect();
        assert_eq!(due, [0, 1, 1, 3]);
        assert_eq!(begins_ns(&pieces), Some(86_398 * NS_PER_S));
    }

    #[test]
    fn recordings_of_several_sensors_keep_their_distance() {
        let at = |seconds: i64| Some(seconds * NS_PER_S);
        let offsets =
            |begins: &[Option<i64>]| -> Vec<i64> { offsets_ns(begins).iter().map(|ns| ns / NS_PER_S).collect() };
        assert_eq!(offsets(&[at(10), at(7), None]), [3, 0, 3]);
        assert_eq!(offsets(&[at(5), at(86_395), at(16_931 * 86_400 + 8)]), [10, 0, 13]);
        assert_eq!(offsets(&[None, None]), [0, 0]);
    }
}
