//! When a frame was received.
//!
//! Ticks of receivers count from a start that nothing dates, so the time of receipt here is better in live operation,
//! and a file of ticks needs a given start. A time in the frame's own line comes first: whoever wrote the line was
//! closer to the receiver. Limits: the delay of the network is in times of receipt; the time stamps of receivers with
//! GPS, which are times of day, are read as ticks.

use frames::time::NS_PER_S;

use super::framing::FrameStamp;

/// Ticks of a receiver, per second.
const TICKS_PER_S: i128 = 12_000_000;
/// Bits of a count of ticks: it wraps after 271 days.
const TICK_BITS: u32 = 48;
/// Ticks that are further back than this belong to a count that has begun anew, nanoseconds.
const BACK_MAX_NS: i64 = NS_PER_S;

/// Clock by which a frame is dated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameClock {
    /// Time in the frame's own line.
    Line,
    /// Time of receipt here.
    Receipt,
    /// Ticks of the receiver since the stream's first frame. A frame without ticks has the time of the frame before.
    Ticks,
}

impl FrameClock {
    /// Name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Line => "time of the line",
            Self::Receipt => "time of receipt",
            Self::Ticks => "ticks since the first frame",
        }
    }
}

/// Dates the frames of a stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamClock {
    /// UTC of the latest ticks, nanoseconds.
    utc_ns: i64,
    /// Latest ticks.
    ticks: Option<u64>,
    pub(super) restarts: u64,
}

impl StreamClock {
    /// Returns a clock whose first ticks are of `utc_ns`.
    pub(super) fn starting_at(utc_ns: i64) -> Self {
        Self {
            utc_ns,
            ticks: None,
            restarts: 0,
        }
    }

    /// Time of a frame, UTC, nanoseconds since 1970; `None` if nothing dates the frame.
    pub(super) fn date(&mut self, stamp: FrameStamp, received_utc_ns: Option<i64>) -> Option<(FrameClock, i64)> {
        match (stamp, received_utc_ns) {
            (FrameStamp::Utc(utc_ns), _) => Some((FrameClock::Line, utc_ns)),
            (_, Some(received_utc_ns)) => Some((FrameClock::Receipt, received_utc_ns)),
            (FrameStamp::Ticks(ticks), None) => Some((FrameClock::Ticks, self.of_ticks(ticks))),
            (FrameStamp::None, None) => self.ticks.map(|_| (FrameClock::Ticks, self.utc_ns)),
        }
    }

    fn of_ticks(&mut self, ticks: u64) -> i64 {
        let last = self.ticks.unwrap_or(ticks);
        // The shorter way around, with its sign.
        let unused = u64::BITS - TICK_BITS;
        let elapsed = (ticks.wrapping_sub(last) << unused) as i64 >> unused;
        let elapsed_ns = (i128::from(elapsed) * i128::from(NS_PER_S) / TICKS_PER_S) as i64;
        if (-BACK_MAX_NS..0).contains(&elapsed_ns) {
            return self.utc_ns.saturating_add(elapsed_ns);
        }
        self.ticks = Some(ticks);
        match elapsed_ns {
            0.. => self.utc_ns = self.utc_ns.saturating_add(elapsed_ns),
            _ => self.restarts += 1,
        }
        self.utc_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START_NS: i64 = 1_700_000_000 * NS_PER_S;

    #[test]
    fn ticks_wrap_go_back_a_little_and_begin_anew() {
        let mut clock = StreamClock::starting_at(START_NS);
        assert_eq!(clock.date(FrameStamp::None, None), None);
        let mut since_start = |ticks: u64| {
            let (source, utc_ns) = clock.date(FrameStamp::Ticks(ticks), None).unwrap();
            assert_eq!(source, FrameClock::Ticks);
            (utc_ns - START_NS, clock.restarts)
        };
        let full = 1 << TICK_BITS;
        assert_eq!(since_start(full - 12_000_000), (0, 0));
        assert_eq!(since_start(12_000_000), (2 * NS_PER_S, 0));
        assert_eq!(
            since_start(6_000_000),
            (NS_PER_S * 3 / 2, 0),
            "another receiver of the same feed"
        );
        assert_eq!(since_start(24_000_000), (3 * NS_PER_S, 0));
        assert_eq!(since_start(12), (3 * NS_PER_S, 1), "the receiver has started again");
        assert_eq!(since_start(12_000_012), (4 * NS_PER_S, 1));
    }

    #[test]
    fn the_line_comes_before_receipt_and_ticks() {
        let mut clock = StreamClock::starting_at(START_NS);
        assert_eq!(clock.date(FrameStamp::Utc(7), Some(9)), Some((FrameClock::Line, 7)));
        assert_eq!(
            clock.date(FrameStamp::Ticks(5), Some(9)),
            Some((FrameClock::Receipt, 9))
        );
        assert_eq!(clock.date(FrameStamp::None, Some(9)), Some((FrameClock::Receipt, 9)));
    }
}
