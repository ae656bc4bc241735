//! Offset of the data from the machine's clock, by the newest states.
//!
//! The age of a received state is its time on the way, or more if the state is an extrapolation. The newest state of
//! several seconds is therefore decisive: it is late by its time on the way alone, or ahead because of a wrong clock.

/// Half of a window, nanoseconds.
const HALF_NS: i64 = 2_500_000_000;

/// Offset of the data from the machine's clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct DataOffset {
    /// Number of the present half, counted from zero of the monotonic clock.
    half: i64,
    /// Offset of the newest state in the present half and in the half before; `None` without states.
    newest: [Option<i64>; 2],
}

impl DataOffset {
    /// Takes a state of the time `time_ns`, received at `mono_ns` and `utc_ns`.
    pub fn take(&mut self, time_ns: i64, mono_ns: i64, utc_ns: i64) {
        self.newest = self.halves(mono_ns);
        self.half = mono_ns.div_euclid(HALF_NS);
        self.newest[0] = self.newest[0].max(Some(time_ns.saturating_sub(utc_ns)));
    }

    /// Returns the offset at `mono_ns`, nanoseconds, positive if the data are ahead; `None` without recent states.
    pub fn ns(&self, mono_ns: i64) -> Option<i64> {
        let [now, before] = self.halves(mono_ns);
        now.max(before)
    }

    fn halves(&self, mono_ns: i64) -> [Option<i64>; 2] {
        match mono_ns.div_euclid(HALF_NS) - self.half {
            0 => self.newest,
            1 => [None, self.newest[0]],
            _ => [None; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;
    const UTC: i64 = 1_700_000_000 * S;

    #[test]
    fn the_newest_state_of_some_seconds_counts() {
        let mut offset = DataOffset::default();
        assert_eq!(offset.ns(0), None);
        for step in 0..100_i64 {
            let mono_ns = step * S / 10;
            // One track is late by a tenth of a second, the other by four seconds.
            offset.take(UTC + mono_ns - S / 10, mono_ns, UTC + mono_ns);
            offset.take(UTC + mono_ns - 4 * S, mono_ns, UTC + mono_ns);
            assert_eq!(offset.ns(mono_ns), Some(-S / 10));
        }
        offset.take(UTC + 17 * S, 10 * S, UTC + 10 * S);
        assert_eq!(offset.ns(12 * S), Some(7 * S));
        assert_eq!(offset.ns(20 * S), None, "nothing came lately");
        offset.take(UTC + 21 * S, 21 * S, UTC + 21 * S);
        assert_eq!(offset.ns(21 * S), Some(0), "one state ahead is forgotten");
    }
}
