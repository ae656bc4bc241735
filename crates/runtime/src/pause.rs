//! Pause between two looks of a process that nobody wakes.
//!
//! Publishers of a deployment wake few readers: each wake-up is a system call in a real-time loop. The others look at
//! times. A short fixed pause wakes an idle machine some hundred times a second, and a long one lets queues overflow
//! under load. Therefore the pause is short while looks find something, and doubles with each look that finds nothing.

use std::time::Duration;

/// Pause that grows while looks find nothing.
#[derive(Clone, Copy, Debug)]
pub struct LookPause {
    least: Duration,
    most: Duration,
    present: Duration,
}

impl LookPause {
    /// A pause from `least` to `most`.
    pub fn between(least: Duration, most: Duration) -> Self {
        let most = most.max(least);
        Self {
            least,
            most,
            present: least,
        }
    }

    /// Returns the pause after a look that has `found` something or nothing.
    pub fn after(&mut self, found: bool) -> Duration {
        self.present = match found {
            true => self.least,
            false => (2 * self.present).min(self.most),
        };
        self.present
    }

    /// The pause after the last look.
    pub fn present(&self) -> Duration {
        self.present
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pause_doubles_in_vain_and_is_short_after_a_find() {
        let [least, most] = [5, 40].map(Duration::from_millis);
        let mut pause = LookPause::between(least, most);
        assert_eq!(pause.present(), least);
        let grown = [false, false, false, false, true, false].map(|found| pause.after(found).as_millis());
        assert_eq!(grown, [10, 20, 40, 40, 5, 10]);
        assert_eq!(LookPause::between(most, least).after(false), most);
    }
}
