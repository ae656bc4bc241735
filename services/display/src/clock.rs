//! Time of the track picture.
//!
//! In live operation the picture's time is the machine's clock. The data do not influence it;
//! `telemetry::DataOffset` shows the distance of the newest states from it. If inputs are recordings, the picture's
//! time is data time: it starts at the latest state and then runs at the machine's rate.
//!
//! A data clock never goes back, because the past of the picture is stored in its order. If all states are behind
//! the clock for [`PATIENCE_NS`], the clock is ahead, as after a standstill of the machine. The clock then waits
//! for the states.

use runtime::Now;

/// Time for which all states must be behind the clock before the clock waits, nanoseconds.
const PATIENCE_NS: i64 = 5_000_000_000;
/// Permitted lag of states behind the clock, nanoseconds: the latency of processing.
const BEHIND_NS: i64 = 500_000_000;

/// Clock of the track picture, see the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PictureClock {
    /// Machine clock, valid from the first state on.
    Machine {
        /// Whether a state has arrived.
        has_begun: bool,
    },
    /// Data clock.
    Data(DataClock),
}

impl PictureClock {
    /// Creates the clock for a deployment with recorded or live inputs.
    pub(crate) fn of(is_recorded: bool) -> Self {
        match is_recorded {
            true => Self::Data(DataClock::default()),
            false => Self::Machine { has_begun: false },
        }
    }

    /// Restarts the clock because the publisher of the states was replaced.
    pub(crate) fn restart(&mut self) {
        if let Self::Data(clock) = self {
            *clock = DataClock::default();
        }
    }

    /// Updates the clock with a state of the time `time_ns`.
    pub(crate) fn hear(&mut self, time_ns: i64, now: Now) {
        match self {
            Self::Machine { has_begun } => *has_begun = true,
            Self::Data(clock) => clock.hear(time_ns, now.mono_ns),
        }
    }

    /// Whether the time is known: a machine clock's always, a data clock's from the first state on.
    pub(crate) fn is_set(&self) -> bool {
        match self {
            Self::Machine { .. } => true,
            Self::Data(clock) => clock.set.is_some(),
        }
    }

    /// Returns the time of the picture, UTC, nanoseconds; `None` before the first state.
    pub(crate) fn at(&self, now: Now) -> Option<i64> {
        match self {
            Self::Machine { has_begun } => has_begun.then_some(now.utc_ns),
            Self::Data(clock) => clock.at(now.mono_ns),
        }
    }
}

/// Clock that follows the data.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DataClock {
    set: Option<Set>,
}

/// Reference point of the clock: its time, the monotonic time, and the accumulated wait.
#[derive(Clone, Copy, Debug)]
struct Set {
    time_ns: i64,
    mono_ns: i64,
    wait_ns: i64,
    /// Start and smallest amount of the current lag of all states.
    behind_since_ns: i64,
    behind_ns: i64,
}

impl DataClock {
    fn hear(&mut self, time_ns: i64, mono_ns: i64) {
        let running_ns = self.at(mono_ns);
        if running_ns.is_none_or(|running_ns| time_ns > running_ns) {
            self.set(time_ns, mono_ns, 0);
            return;
        }
        let (Some(running_ns), Some(set)) = (running_ns, &mut self.set) else {
            return;
        };
        set.behind_ns = set.behind_ns.min(running_ns - time_ns);
        if mono_ns - set.behind_since_ns < PATIENCE_NS {
            return;
        }
        let wait_ns = set.behind_ns;
        if wait_ns > BEHIND_NS {
            self.set(running_ns, mono_ns, wait_ns);
        } else {
            (set.behind_since_ns, set.behind_ns) = (mono_ns, i64::MAX);
        }
    }

    fn set(&mut self, time_ns: i64, mono_ns: i64, wait_ns: i64) {
        self.set = Some(Set {
            time_ns,
            mono_ns,
            wait_ns,
            behind_since_ns: mono_ns + wait_ns,
            behind_ns: i64::MAX,
        });
    }

    fn at(&self, mono_ns: i64) -> Option<i64> {
        let set = self.set?;
        Some(set.time_ns + (mono_ns - set.mono_ns - set.wait_ns).max(0))
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    const UTC: i64 = 1_700_000_000 * S;

    fn now(mono_ns: i64) -> Now {
        Now {
            mono_ns,
            utc_ns: UTC + mono_ns,
        }
    }

    #[test]
    fn live_the_machine_says_what_time_it_is() {
        let mut clock = PictureClock::of(false);
        clock.hear(UTC + 7 * S, now(0));
        assert_eq!(clock.at(now(S)), Some(UTC + S));
    }

    #[test]
    fn of_recordings_the_latest_state_does_and_time_goes_on() {
        let mut clock = PictureClock::of(true);
        assert_eq!(clock.at(now(S)), None);
        clock.hear(100 * S, now(S));
        clock.hear(99 * S, now(2 * S));
        assert_eq!(clock.at(now(3 * S)), Some(102 * S));
        clock.restart();
        clock.hear(50 * S, now(4 * S));
        assert_eq!(clock.at(now(4 * S)), Some(50 * S));
    }

    #[test]
    fn a_clock_that_is_ahead_waits_for_the_data_and_does_not_go_back() {
        let mut clock = PictureClock::of(true);
        clock.hear(107 * S, now(0));
        let mut last_ns = 0;
        for step in 1..400 {
            let mono_ns = step * S / 10;
            // States are a tenth of a second old.
            clock.hear(100 * S + mono_ns - S / 10, now(mono_ns));
            let at_ns = clock.at(now(mono_ns)).unwrap();
            assert!(at_ns >= last_ns, "{step}");
            last_ns = at_ns;
        }
        let expected_ns = 100 * S + 399 * S / 10;
        assert!((last_ns - expected_ns).abs() <= S / 2, "{last_ns} {expected_ns}");
    }

    #[test]
    fn data_that_come_together_every_few_seconds_do_not_stop_it() {
        let mut clock = PictureClock::of(true);
        for cycle in 0..10 {
            for track in 0..20 {
                let mono_ns = cycle * 5 * S + track * S / 1_000;
                clock.hear(cycle * 5 * S, now(mono_ns));
            }
            let late = now((cycle * 5 + 4) * S);
            assert_eq!(clock.at(late), Some((cycle * 5 + 4) * S), "{cycle}");
        }
    }
}
