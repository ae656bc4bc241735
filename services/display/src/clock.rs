//! Time of a picture.
//!
//! Live, it is the machine's: what the data say of the time is no measure of it, and how far the newest states are from
//! it is shown (`telemetry::DataOffset`). Where inputs are recordings, it is that of the data: where the latest state
//! was, and from there on it goes as the machine's does.
//!
//! A clock of the data does not go back, since the past of the picture is in its order. States that are all behind it
//! for [`PATIENCE_NS`] show that it is ahead, after the machine stood still: then it waits for them.

use runtime::Now;

/// Time for which all states must be behind the clock before it waits, nanoseconds.
const PATIENCE_NS: i64 = 5_000_000_000;
/// How far states may be behind it, nanoseconds: they take that on their way.
const BEHIND_NS: i64 = 500_000_000;

/// See the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PictureClock {
    /// The machine's, from the first state on.
    Machine {
        /// Whether there was one.
        has_begun: bool,
    },
    /// That of the data.
    Data(DataClock),
}

impl PictureClock {
    /// For a deployment whose inputs are recordings, or are not.
    pub(crate) fn of(is_recorded: bool) -> Self {
        match is_recorded {
            true => Self::Data(DataClock::default()),
            false => Self::Machine { has_begun: false },
        }
    }

    /// Begins anew: whoever made the states is gone.
    pub(crate) fn restart(&mut self) {
        if let Self::Data(clock) = self {
            *clock = DataClock::default();
        }
    }

    /// A state of the time `time_ns` has come.
    pub(crate) fn hear(&mut self, time_ns: i64, now: Now) {
        match self {
            Self::Machine { has_begun } => *has_begun = true,
            Self::Data(clock) => clock.hear(time_ns, now.mono_ns),
        }
    }

    /// Time of the picture, UTC, nanoseconds; `None` before the first state.
    pub(crate) fn at(&self, now: Now) -> Option<i64> {
        match self {
            Self::Machine { has_begun } => has_begun.then_some(now.utc_ns),
            Self::Data(clock) => clock.at(now.mono_ns),
        }
    }
}

/// Time of the data.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DataClock {
    set: Option<Set>,
}

/// Time that the clock had, when (monotonic), and how long it waited then.
#[derive(Clone, Copy, Debug)]
struct Set {
    time_ns: i64,
    mono_ns: i64,
    wait_ns: i64,
    /// Since when all states have been behind, and by how much at least.
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
