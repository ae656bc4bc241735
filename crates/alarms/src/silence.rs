//! How long somebody has been silent, as far as one can tell.
//!
//! A counter that does not grow is silence only while the listener listens: a monitor that was itself held up (by a
//! machine under load, a debugger, a suspended laptop) hears everything late, and would call everyone silent. So after
//! a gap in its own looks, silence counts from its end.

/// Pause between two looks after which nothing is known of the time between, nanoseconds.
const GAP_NS: i64 = 2_000_000_000;

/// Silence of several things that count.
#[derive(Clone, Debug)]
pub struct Silence {
    last: Vec<Last>,
    looked_ns: i64,
    /// Since when looks have come regularly.
    awake_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    count: u64,
    grew_ns: i64,
}

impl Silence {
    /// Of `count` things, of which nothing was heard before `now_ns` (monotonic, nanoseconds).
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

    /// Begins a look at `now_ns`; since when looks have come regularly, both monotonic, nanoseconds.
    pub fn look(&mut self, now_ns: i64) -> i64 {
        if now_ns - self.looked_ns > GAP_NS {
            self.awake_ns = now_ns;
        }
        self.looked_ns = now_ns;
        self.awake_ns
    }

    /// For how long, at the latest look, thing number `index` has been silent, which has counted `count` by now,
    /// nanoseconds. One that `may_be_silent` (it is not there, or nothing is expected of it) is not.
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
