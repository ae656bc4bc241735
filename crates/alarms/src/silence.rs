//! Silence of observed processes and sources.
//!
//! A counter that does not grow means silence only while the observer runs. A monitor that was itself delayed (by a
//! loaded machine, a debugger, a suspended laptop) receives everything late, and would report all processes as
//! silent. After a gap between its own polls, silence therefore counts from the end of the gap.

/// Pause between two polls above which the time between them counts as unobserved, nanoseconds.
const GAP_NS: i64 = 2_000_000_000;

/// Silence of several counted things.
#[derive(Clone, Debug)]
pub struct Silence {
    last: Vec<Last>,
    looked_ns: i64,
    /// Start of the present sequence of regular polls.
    awake_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    count: u64,
    grew_ns: i64,
}

impl Silence {
    /// Creates the state of `count` things without any activity before `now_ns` (monotonic, nanoseconds).
    pub fn new(count: usize, now_ns: i64) -> Self {
        let last = Last {
            count: 0,
            grew_ns: now_ns,
        };
        Self {
            last: vec![last; count],
            looked_ns: now_ns,
            awake_ns: now_ns,
        }
    }

    /// Begins a poll at `now_ns`; returns the start of the present sequence of regular polls. Both are monotonic,
    /// nanoseconds.
    pub fn look(&mut self, now_ns: i64) -> i64 {
        if now_ns - self.looked_ns > GAP_NS {
            self.awake_ns = now_ns;
        }
        self.looked_ns = now_ns;
        self.awake_ns
    }

    /// Returns the duration of the silence of thing number `index` at the latest poll, nanoseconds; `count` is its
    /// present count. With `may_be_silent` (the thing is absent, or no activity is expected), the duration is 0.
    pub fn of(&mut self, index: usize, count: u64, may_be_silent: bool) -> i64 {
        let last = &mut self.last[index];
        if last.count != count || may_be_silent {
            *last = Last {
                count,
                grew_ns: self.looked_ns,
            };
        }
        self.looked_ns - last.grew_ns.max(self.awake_ns)
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn silence_lasts_from_the_last_growth() {
        let mut silence = Silence::new(2, 0);
        let mut look = |now_s: i64, count, may| {
            silence.look(now_s * S);
            silence.of(1, count, may) / S
        };
        let found = [
            (1, 0, false),
            (2, 4, false),
            (3, 4, false),
            (4, 4, false),
            (5, 5, false),
            (6, 5, true),
            (7, 5, false),
        ];
        assert_eq!(
            found.map(|(now, count, may)| look(now, count, may)),
            [1, 0, 1, 2, 0, 0, 1]
        );
    }

    #[test]
    fn whoever_did_not_listen_knows_of_no_silence() {
        let mut silence = Silence::new(1, 0);
        silence.look(S);
        assert_eq!(silence.of(0, 7, false), 0);
        silence.look(60 * S);
        assert_eq!(silence.of(0, 7, false), 0);
        silence.look(61 * S);
        assert_eq!(silence.of(0, 7, false), S);
    }
}
