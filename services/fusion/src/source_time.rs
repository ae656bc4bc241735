//! Time in order `arrival`: judges of the sources' clocks, and the passage of time.
//!
//! Time passes by the engine's clock ([`crate::clocks`]), never by the claim of a report. The offset of a live source
//! is measured against times of receipt. The source's adapter measures, with the kernel's stamps, and states the offset
//! in slices; for a topic published by an external process, the measurement is here. A source far from the host offset
//! is isolated. A replayed recording is of another day, and has a separate clock. This clock began with the recording's
//! first time when the first slice was sent, and runs as fast as the replay. At the greatest speed there is no such
//! clock; then time passes to the point that all recordings report to have reached.

use deployment::{Input, Source};
use estimation::SourceClock;
use runtime::{Now, Speed};

use crate::clocks::{ClockReading, agrees};

/// Age above which a slice's stated time of sending is invalid, nanoseconds.
const UNDERWAY_MAX_NS: i64 = 10_000_000_000;

/// Offsets that hold for all sources, seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CommonOffsets {
    /// Of sound clocks against the engine's time.
    pub(crate) host_offset_s: f64,
    /// Of the engine's time against the machine's UTC.
    pub(crate) ahead_s: f64,
}

/// Time of a source.
#[derive(Clone, Debug)]
pub(crate) enum SourceTime {
    /// Judged by the offset in each slice, as stated by the adapter.
    Stated {
        /// Offset against the machine's UTC, seconds; `None` while unknown.
        offset_s: Option<f64>,
        /// Greatest distance from the host offset, seconds.
        step_s: f64,
    },
    /// By the time of receipt.
    Received {
        clock: SourceClock,
        /// Greatest distance from the host offset, seconds.
        step_s: f64,
    },
    /// By the clock of a replay.
    Paced {
        clock: SourceClock,
        /// Seconds of the recording per second.
        factor: f64,
        /// Time of the recording (UTC) and of the machine (monotonic) at the begin, nanoseconds.
        began: Option<(i64, i64)>,
    },
    /// By nothing: a replay as fast as can be.
    Unpaced,
}

impl SourceTime {
    /// That of `source`; recordings are replayed at `speed`.
    pub(crate) fn of(source: &Source, speed: Speed) -> Self {
        let step_s = source.clock_step.s();
        let clock = SourceClock::new(step_s);
        match (&source.input, speed) {
            (Input::External, _) => Self::Received { clock, step_s },
            (input, Speed::Factor(factor)) if input.is_recorded() => Self::Paced {
                clock,
                factor,
                began: None,
            },
            (input, Speed::Max) if input.is_recorded() => Self::Unpaced,
            (Input::Live(_) | Input::Simulated(_) | Input::Recorded(_) | Input::Tracker(_), _) => {
                Self::Stated { offset_s: None, step_s }
            }
        }
    }

    /// Takes the offset of the source's clock stated in a slice, milliseconds; 0: unknown.
    pub(crate) fn state(&mut self, offset_ms: i32) {
        if let Self::Stated { offset_s, .. } = self {
            // A publisher beside the adapter states no offset: that is no reason for more trust in the source.
            *offset_s = if offset_ms == 0 {
                *offset_s
            } else {
                Some(1e-3 * f64::from(offset_ms))
            };
        }
    }

    /// The source's clock against the engine's time, which is `ahead_s` ahead of the machine's UTC; `None` while
    /// unknown, and for recordings.
    pub(crate) fn known(&self, ahead_s: f64) -> Option<ClockReading> {
        let (offset_s, step_s) = match self {
            Self::Stated { offset_s, step_s } => (offset_s.map(|offset_s| offset_s - ahead_s), *step_s),
            Self::Received { clock, step_s } => (clock.offset().map(|(offset_s, _)| offset_s), *step_s),
            Self::Paced { .. } | Self::Unpaced => return None,
        };
        offset_s.map(|offset_s| ClockReading { offset_s, step_s })
    }

    /// Returns whether the clock is a recording's, which waits for the readers.
    pub(crate) fn is_of_recording(&self) -> bool {
        matches!(self, Self::Paced { .. } | Self::Unpaced)
    }

    /// Adds a slice sent at `sent_ns` (monotonic) that states or shows the source's progress to `time_ns`.
    pub(crate) fn begin(&mut self, time_ns: i64, sent_ns: i64) {
        if let Self::Paced { began, .. } = self {
            began.get_or_insert((time_ns, sent_ns));
        }
    }

    /// Returns whether a report's time `time_ns` is valid; `sent_ns` is the slice's time of sending (monotonic). `now`
    /// has the engine's time, and `clocks` the offset of sound clocks.
    pub(crate) fn believes(&mut self, time_ns: i64, sent_ns: i64, now: Now, clocks: CommonOffsets) -> bool {
        match self {
            Self::Unpaced => return true,
            Self::Stated { step_s, .. } => {
                // An unknown clock is taken for a sound clock.
                let sound = ClockReading {
                    offset_s: clocks.host_offset_s,
                    step_s: *step_s,
                };
                let known = self.known(clocks.ahead_s).unwrap_or(sound);
                // Adapters mark reports that are farther ahead; a publisher beside the adapter may not.
                let ahead_s = time_ns.saturating_sub(now.utc_ns) as f64 / messages::NS_PER_S;
                return agrees(&known, clocks.host_offset_s) && ahead_s <= known.offset_s + known.step_s;
            }
            Self::Received { .. } | Self::Paced { .. } => {}
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
            Self::Received { clock, .. } => clock.believes(time_ns, sent.utc_ns, Some(clocks.host_offset_s)),
            Self::Paced { clock, .. } => due_ns.is_none_or(|due_ns| clock.believes(time_ns, due_ns, Some(0.0))),
            Self::Stated { .. } | Self::Unpaced => true,
        }
    }

    /// Returns the present time of a replay; `None` before the start, or without a replay.
    pub(crate) fn paced_ns(&self, now: Now) -> Option<i64> {
        let Self::Paced { factor, began, .. } = self else {
            return None;
        };
        let (data_ns, mono_ns) = (*began)?;
        let passed_ns = now.mono_ns.saturating_sub(mono_ns) as f64 * factor;
        // `as` saturates.
        Some(data_ns.saturating_add(passed_ns as i64))
    }

    /// Offset of the source's clock against the machine's UTC, and the offset's standard deviation from report to
    /// report, seconds. The engine's time is `ahead_s` ahead of UTC. `None` while the offset is unknown, or known
    /// elsewhere.
    pub(crate) fn clock_offset(&self, ahead_s: f64) -> Option<(f64, f64)> {
        match self {
            Self::Received { clock, .. } => clock.offset().map(|(offset_s, sigma_s)| (offset_s + ahead_s, sigma_s)),
            Self::Paced { clock, .. } => clock.offset(),
            Self::Stated { .. } | Self::Unpaced => None,
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
                time.believes(
                    BEGIN_NS + 10 * second * S,
                    sent_ns,
                    at(second + 2),
                    CommonOffsets::default()
                ),
                "{second}"
            );
        }
        assert!(!time.believes(BEGIN_NS + 250 * S, at(20).mono_ns, at(20), CommonOffsets::default()));
        assert!(time.clock_offset(0.0).is_some());
    }

    #[test]
    fn a_report_far_ahead_beside_an_adapter_is_not_believed() {
        let mut time = SourceTime::Stated {
            offset_s: None,
            step_s: 5.0,
        };
        let mut believes = |offset_ms, ahead_s: i64| {
            time.state(offset_ms);
            time.believes(at(ahead_s).utc_ns, at(0).mono_ns, at(0), CommonOffsets::default())
        };
        assert!(!believes(0, 700), "before anything is known of the clock");
        assert!(believes(0, 0) && believes(0, 4), "as of a sound clock");
        assert!(believes(-200, 0) && believes(-200, 4), "what its adapter lets pass");
        assert!(!believes(0, 700), "a publisher that states no offset");
        assert!(believes(0, 0) && believes(0, -60), "old reports change no track");
    }

    #[test]
    fn what_had_to_wait_here_is_not_late_and_a_slice_cannot_claim_to_be_old() {
        let mut time = SourceTime::Received {
            clock: SourceClock::new(5.0),
            step_s: 5.0,
        };
        let mut believes = |time_ns, sent_ns, now| time.believes(time_ns, sent_ns, now, CommonOffsets::default());
        assert!(believes(at(0).utc_ns, at(0).mono_ns, at(8)));
        assert!(!believes(at(0).utc_ns, at(0).mono_ns, at(70)));
        for strange_ns in [i64::MIN, 0, i64::MAX] {
            assert!(!believes(strange_ns, strange_ns, at(0)));
        }
    }

    #[test]
    fn a_stated_offset_is_judged_by_the_host_offset() {
        let mut time = SourceTime::Stated {
            offset_s: None,
            step_s: 5.0,
        };
        let believes = |time: &mut SourceTime, host_offset_s, ahead_s| {
            let common = CommonOffsets { host_offset_s, ahead_s };
            time.believes(at(0).utc_ns, at(0).mono_ns, at(0), common)
        };
        assert!(believes(&mut time, 0.0, 0.0), "nothing is known yet");
        time.state(30_000);
        assert!(!believes(&mut time, 0.0, 0.0));
        assert!(believes(&mut time, 28.0, 0.0), "others say the same");
        assert!(believes(&mut time, 0.0, 29.0), "the machine was set back by as much");
        time.state(0);
        assert!(
            !believes(&mut time, 0.0, 0.0),
            "a publisher beside the adapter states none"
        );
    }
}
