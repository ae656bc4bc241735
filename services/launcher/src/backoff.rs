//! When to start a child again that has ended: deciding only, apart from doing.
//!
//! Starting it again at once is right for the first time: most ends are accidents. One that always fails at its start
//! would then be started hundreds of times a second. So the pause doubles with each end, up to a limit, and is
//! forgotten once a child has lived for a while. And what has failed at once many times in a row will not be cured by
//! one more start: a person must look.

use std::time::Duration;

/// Pause before the first restart.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// Longest pause.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// A child that has lived this long was well: what came before is forgotten.
const WELL: Duration = Duration::from_secs(10);
/// A child that ended within this time failed at its start.
const AT_ONCE: Duration = Duration::from_secs(1);
/// So many failures at the start, one after the other, are enough.
pub(crate) const FAILURES_MAX: u32 = 10;

/// The history of one child, as far as it matters for the next start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backoff {
    pause: Duration,
    failures: u32,
}

/// What to do about an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Start it again after this time.
    RestartIn(Duration),
    /// Do not start it again.
    GiveUp,
}

impl Backoff {
    /// Nothing has happened yet.
    pub(crate) fn new() -> Self {
        Self {
            pause: FIRST_PAUSE,
            failures: 0,
        }
    }

    /// The child has ended after having lived so long.
    pub(crate) fn ended(&mut self, lived: Duration) -> Verdict {
        if lived >= WELL {
            self.pause = FIRST_PAUSE;
        }
        self.failures = if lived < AT_ONCE { self.failures + 1 } else { 0 };
        if self.failures >= FAILURES_MAX {
            return Verdict::GiveUp;
        }
        let pause = self.pause;
        self.pause = (2 * pause).min(LONGEST_PAUSE);
        Verdict::RestartIn(pause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(count: u64) -> Duration {
        Duration::from_millis(count)
    }

    #[test]
    fn pauses_double_up_to_a_limit_and_are_forgotten() {
        let mut backoff = Backoff::new();
        for pause in [100, 200, 400, 800, 1600, 3200, 5000, 5000] {
            assert_eq!(backoff.ended(ms(2000)), Verdict::RestartIn(ms(pause)));
        }
        assert_eq!(backoff.ended(WELL), Verdict::RestartIn(FIRST_PAUSE));
        assert_eq!(backoff.ended(ms(9999)), Verdict::RestartIn(ms(200)));
    }

    #[test]
    fn ten_failures_at_the_start_are_enough() {
        let mut backoff = Backoff::new();
        for _ in 0..9 {
            assert!(matches!(backoff.ended(ms(20)), Verdict::RestartIn(_)));
        }
        assert_eq!(backoff.ended(ms(20)), Verdict::GiveUp);
    }

    #[test]
    fn one_that_lived_longer_starts_the_count_anew() {
        let mut backoff = Backoff::new();
        for _ in 0..9 {
            backoff.ended(ms(20));
        }
        backoff.ended(AT_ONCE);
        for _ in 0..9 {
            assert!(matches!(backoff.ended(ms(20)), Verdict::RestartIn(_)));
        }
        assert_eq!(backoff.ended(ms(20)), Verdict::GiveUp);
    }
}
