//! When to start a child again that has ended: deciding only, apart from doing.
//!
//! An immediate restart is right for the first end of a child, because most ends are accidents. A child that always
//! fails at the start would then be started hundreds of times a second. Therefore the pause doubles with each end, up
//! to a limit, and is reset after a child has lived for a while. Restarts never stop: a port in use may be free
//! tomorrow, and until then the other processes work.
//!
//! Fusion is different: an absence longer than the greatest age of tracks terminates the tracks. The pause of fusion
//! has a separate limit, and a fusion process that had come up is restarted at once while no other process can lead.

use std::time::Duration;

/// Pause before the first restart.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// Longest pause.
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
/// Life time after which a child counts as healthy, and earlier ends are forgotten.
const WELL: Duration = Duration::from_secs(10);

/// The history of a child, as far as relevant for the next start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backoff {
    pause: Duration,
    longest: Duration,
    failures: u32,
}

impl Backoff {
    /// Nothing has happened yet.
    pub(crate) fn new() -> Self {
        Self::with_longest(LONGEST_PAUSE)
    }

    /// The same, with no pause longer than `longest`.
    pub(crate) fn with_longest(longest: Duration) -> Self {
        let longest = longest.min(LONGEST_PAUSE);
        Self {
            pause: FIRST_PAUSE.min(longest),
            longest,
            failures: 0,
        }
    }

    /// Ends in a row, none of which came after a life that was long enough.
    pub(crate) fn failures(&self) -> u32 {
        self.failures
    }

    /// Notes the end of the child after the life time `lived`. Returns the pause before the next start.
    pub(crate) fn ended(&mut self, lived: Duration, came_up: bool) -> Duration {
        if came_up && lived >= WELL {
            *self = Self::with_longest(self.longest);
        }
        self.failures += 1;
        let pause = self.pause;
        self.pause = (2 * pause).min(self.longest);
        pause
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
        for pause in [100, 200, 400, 800, 1600, 3200, 6400, 12_800, 25_600, 30_000, 30_000] {
            assert_eq!(backoff.ended(ms(2000), true), ms(pause));
        }
        assert_eq!(backoff.failures(), 11);
        assert_eq!(backoff.ended(WELL, false), LONGEST_PAUSE, "it lived, but never came up");
        assert_eq!((backoff.ended(WELL, true), backoff.failures()), (FIRST_PAUSE, 1));
        assert_eq!(backoff.ended(ms(9999), true), ms(200));
    }

    #[test]
    fn no_pause_is_longer_than_its_limit() {
        let mut backoff = Backoff::with_longest(ms(250));
        let pauses: Vec<Duration> = (0..5).map(|_| backoff.ended(ms(10), true)).collect();
        assert_eq!(pauses, [ms(100), ms(200), ms(250), ms(250), ms(250)]);
        assert_eq!(backoff.ended(WELL, true), FIRST_PAUSE);
        assert_eq!(backoff.ended(ms(10), true), ms(200));
        assert_eq!(Backoff::with_longest(ms(5)).ended(ms(0), false), ms(5));
    }
}
