//! Time in order `arrival`: by what each source's clock is judged, and how far time has passed.
//!
//! Time passes by the machine's clock, never by what a report claims. A live source is judged by when its reports are
//! received: by its adapter, which has the kernel's stamps, or here, where a process of somebody's own publishes the
//! topic. A recording that is replayed is of another day, and has a clock of its own: it began with the recording's
//! first time when the first slice was sent, and runs as fast as the replay. At the greatest speed there is none; then
//! time passes to where all recordings say that they have got.

use configuration::{Input, Source};
use estimation::SourceClock;
use runtime::{Now, Speed};

/// A slice that claims to be older was not sent when it says, nanoseconds.
const UNDERWAY_MAX_NS: i64 = 10_000_000_000;

/// One source's time.
#[derive(Clone, Debug)]
pub(crate) enum SourceTime {
    /// Its adapter has judged its clock.
    Judged,
    /// By the time of receipt.
    Received(SourceClock),
    /// By the clock of a replay.
    Paced {
        clock: SourceClock,
        /// Seconds of the recording per second.
        factor: f64,
        /// Time of the recording (UTC) and of the machine (monotonic) when it began, nanoseconds.
        began: Option<(i64, i64)>,
    },
    /// By nothing: a replay as fast as can be.
    Unpaced,
}

impl SourceTime {
    /// That of `source`; recordings are replayed at `speed`.
    pub(crate) fn of(source: &Source, speed: Speed) -> Self {
        let clock = SourceClock::new(source.model.limits.clock_step().s());
        match (&source.input, speed) {
            (Input::External, _) => Self::Received(clock),
            (Input::Recorded(_), Speed::Factor(factor)) => Self::Paced {
                clock,
                factor,
                began: None,
            },
            (Input::Recorded(_), Speed::Max) => Self::Unpaced,
            (Input::Live(_) | Input::Simulated(_), _) => Self::Judged,
        }
    }

    /// Whether it is that of a recording, which waits for its readers.
    pub(crate) fn is_of_recording(&self) -> bool {
        matches!(self, Self::Paced { .. } | Self::Unpaced)
    }

    /// A slice was sent at `sent_ns` (monotonic) that says or shows that the source has come to `time_ns`.
    pub(crate) fn begin(&mut self, time_ns: i64, sent_ns: i64) {
        if let Self::Paced { began, .. } = self {
            began.get_or_insert((time_ns, sent_ns));
        }
    }

    /// Whether the time of a report may be believed that claims to be of `time_ns`; its slice says that it was sent at
    /// `sent_ns` (monotonic).
    pub(crate) fn believes(&mut self, time_ns: i64, sent_ns: i64, now: Now) -> bool {
        if matches!(self, Self::Judged | Self::Unpaced) {
            return true;
        }
        // A report that had to wait here is not late for that.
        let underway_ns = now.mono_ns.saturating_sub(sent_ns);
        let underway_ns = if (0..=UNDERWAY_MAX_NS).contains(&underway_ns) {
            underway_ns
        } else {
            0
        };
        let sent = Now {
            mono_ns: now.mono_ns - underway_ns,
            utc_ns: now.utc_ns - underway_ns,
        };
        let due_ns = self.paced_ns(sent);
        match self {
            Self::Received(clock) => clock.believes(time_ns, sent.utc_ns),
            Self::Paced { clock, .. } => due_ns.is_none_or(|due_ns| clock.believes(time_ns, due_ns)),
            Self::Judged | Self::Unpaced => true,
        }
    }

    /// Where a replay's clock stands; `None` before it began, or without one.
    pub(crate) fn paced_ns(&self, now: Now) -> Option<i64> {
        let Self::Paced { factor, began, .. } = self else {
            return None;
        };
        let (data_ns, mono_ns) = (*began)?;
        let passed_ns = now.mono_ns.saturating_sub(mono_ns) as f64 * factor;
        // `as` saturates.
        Some(data_ns.saturating_add(passed_ns as i64))
    }

    /// Offset of the source's clock and its standard deviation from report to report, seconds; `None` while it is not
    /// known, or known elsewhere.
    pub(crate) fn clock_offset(&self) -> Option<(f64, f64)> {
        match self {
            Self::Received(clock) | Self::Paced { clock, .. } => clock.offset(),
            Self::Judged | Self::Unpaced => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    const BEGIN_NS: i64 = 1_463_000_000 * S;

    fn at(seconds: i64) -> Now {
        Now {
            mono_ns: 100 * S + seconds * S,
            utc_ns: 1_700_000_000 * S + seconds * S,
        }
    }

    #[test]
    fn a_replay_is_judged_by_its_own_clock_at_whatever_speed() {
        let mut time = SourceTime::Paced {
            clock: SourceClock::new(5.0),
            factor: 10.0,
            began: None,
        };
        assert_eq!(time.paced_ns(at(0)), None);
        time.begin(BEGIN_NS, at(0).mono_ns);
        time.begin(BEGIN_NS + S, at(1).mono_ns);
        assert_eq!(time.paced_ns(at(3)), Some(BEGIN_NS + 30 * S));
        for second in 0..20 {
            let sent_ns = at(second).mono_ns;
            assert!(
                time.believes(BEGIN_NS + 10 * second * S, sent_ns, at(second + 2)),
                "{second}"
            );
        }
        assert!(!time.believes(BEGIN_NS + 250 * S, at(20).mono_ns, at(20)));
        assert!(time.clock_offset().is_some());
    }

    #[test]
    fn what_had_to_wait_here_is_not_late_and_a_slice_cannot_claim_to_be_old() {
        let mut time = SourceTime::Received(SourceClock::new(5.0));
        assert!(time.believes(at(0).utc_ns, at(0).mono_ns, at(8)));
        assert!(!time.believes(at(0).utc_ns, at(0).mono_ns, at(70)));
        for strange_ns in [i64::MIN, 0, i64::MAX] {
            assert!(!time.believes(strange_ns, strange_ns, at(0)));
        }
    }
}
