//! Which clock is right, in order `arrival`: the machine's, or the sources'?
//!
//! Times of receipt are the machine's, times of measurement the sources'. If a single source's clock is far from the
//! times of receipt of its reports, the source is wrong. If several sources have the same offset, the machine is wrong:
//! two sensors hardly ever err alike. So each known clock has a vote, and the machine's clock half a vote: the offset
//! with most votes is the *host offset*. A lone source is followed, since only the machine contradicts this source.
//! Module `source_time` isolates a source far from the host offset; the monitor raises the alarm
//! (`services/monitor/src/conditions/sources.rs`).
//!
//! The engine's time is none of these clocks. Engine time begins with the machine's UTC and runs with the monotonic
//! clock, so that no process can set this time ([`SteadyClock`]). The engine takes the host offset off the sources'
//! times and adds the offset to the times of states. So neither a step of the machine's clock nor a step of all sources
//! disturbs a track, and states have the sources' time.
//!
//! Limits: a host offset is a whole number of seconds, and is not used below the limit on time steps; a common
//! error smaller than that moves all states alike.

use runtime::Now;
use runtime::clock::SteadyClock;

/// Time between two looks at the clocks, nanoseconds.
const LOOK_NS: i64 = 100_000_000;
/// Time for which an offset must have had most votes before being the host offset, nanoseconds.
const HOLDS_NS: i64 = 500_000_000;
/// Votes of a source and of the machine.
const SOURCE_VOTES: u32 = 2;
const MACHINE_VOTES: u32 = 1;
const NS_PER_S: i64 = 1_000_000_000;

/// Clock of a source with recent reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockReading {
    /// Offset against the engine's time, seconds.
    pub(crate) offset_s: f64,
    /// Greatest distance of a clock that agrees with this clock, seconds.
    pub(crate) step_s: f64,
}

/// The clocks of the machine and of all sources.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clocks {
    /// The engine's time; `None` before the begin.
    engine: Option<SteadyClock>,
    host_offset_ns: i64,
    /// Offset that has most votes besides, and since when (monotonic), nanoseconds.
    rival: Option<(i64, i64)>,
    looked_ns: Option<i64>,
}

impl Clocks {
    /// Continues at `now` with the engine's time and the host offset of the previous fusion process: `ahead_ns` is
    /// that time minus the machine's.
    pub(crate) fn resume(&mut self, now: Now, ahead_ns: i64, host_offset_ns: i64) {
        self.engine = Some(SteadyClock::of(now).moved(ahead_ns));
        self.host_offset_ns = host_offset_ns;
    }

    /// Both clocks at `now`, with the engine's time in place of the machine's UTC. The engine's time begins with the
    /// machine's.
    #[inline]
    pub(crate) fn engine_time(&mut self, now: Now) -> Now {
        let engine = *self.engine.get_or_insert_with(|| SteadyClock::of(now));
        Now {
            utc_ns: engine.utc_ns(now.mono_ns),
            ..now
        }
    }

    /// By how much the engine's time is ahead of the machine's UTC, nanoseconds.
    pub(crate) fn ahead_ns(&self, now: Now) -> i64 {
        self.engine.map_or(0, |engine| engine.ahead_of(now))
    }

    /// Offset of sound clocks against the engine's time, seconds.
    pub(crate) fn host_offset_s(&self) -> f64 {
        self.host_offset_ns as f64 / messages::NS_PER_S
    }

    /// Whether it is time to look at the clocks.
    #[inline]
    pub(crate) fn is_due(&self, now: Now) -> bool {
        self.looked_ns
            .is_none_or(|looked_ns| now.mono_ns.saturating_sub(looked_ns) >= LOOK_NS)
    }

    /// Looks at the clocks of the sources; returns a changed host offset, nanoseconds.
    pub(crate) fn look(&mut self, sources: impl Iterator<Item = ClockReading> + Clone, now: Now) -> Option<i64> {
        self.looked_ns = Some(now.mono_ns);
        let machine_s = -(self.ahead_ns(now) as f64) / messages::NS_PER_S;
        let votes = |of_s: f64| {
            let agreeing = sources.clone().filter(|known| agrees(known, of_s));
            let machine = (machine_s - of_s).abs() <= least_step_s(sources.clone());
            SOURCE_VOTES * agreeing.count() as u32 + if machine { MACHINE_VOTES } else { 0 }
        };
        let candidates = sources.clone().map(|known| known.offset_s).chain([machine_s]);
        let present_s = self.host_offset_s();
        let mut best = (votes(present_s), present_s);
        for of_s in candidates {
            let count = votes(of_s);
            // With equal votes, the present offset stays.
            if count > best.0 {
                best = (count, of_s);
            }
        }
        let of_s = best.1;
        if of_s == present_s || sources.clone().next().is_none() {
            self.rival = None;
            return None;
        }
        let host_offset_ns = shared_ns(of_s, machine_s, sources);
        let since_ns = match self.rival {
            Some((rival_ns, since_ns)) if (rival_ns - host_offset_ns).abs() <= NS_PER_S => since_ns,
            _ => now.mono_ns,
        };
        self.rival = Some((host_offset_ns, since_ns));
        if now.mono_ns - since_ns < HOLDS_NS || host_offset_ns == self.host_offset_ns {
            return None;
        }
        (self.host_offset_ns, self.rival) = (host_offset_ns, None);
        Some(host_offset_ns)
    }
}

/// Whether a source's clock is near a clock with this offset, seconds.
pub(crate) fn agrees(known: &ClockReading, of_s: f64) -> bool {
    (known.offset_s - of_s).abs() <= known.step_s
}

fn least_step_s(sources: impl Iterator<Item = ClockReading>) -> f64 {
    sources.map(|known| known.step_s).fold(f64::MAX, f64::min)
}

/// Returns the host offset of clocks that agree with `of_s`: none if an unadjusted machine clock is among these, else
/// the mean in whole seconds.
fn shared_ns(of_s: f64, machine_s: f64, sources: impl Iterator<Item = ClockReading> + Clone) -> i64 {
    let zero_is_among = machine_s == 0.0 && of_s.abs() <= least_step_s(sources.clone());
    if zero_is_among {
        return 0;
    }
    let agreeing = sources.filter(|known| agrees(known, of_s));
    let (sum, count) = agreeing.fold((0.0, 0.0), |(sum, count), known| (sum + known.offset_s, count + 1.0));
    let mean_s = if count > 0.0 { sum / count } else { of_s };
    // `as` saturates.
    (mean_s.round() as i64).saturating_mul(NS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    fn at(tenths: i64) -> Now {
        Now {
            mono_ns: 100 * S + tenths * S / 10,
            utc_ns: 1_700_000_000 * S + tenths * S / 10,
        }
    }

    fn known(offset_s: f64) -> ClockReading {
        ClockReading { offset_s, step_s: 5.0 }
    }

    fn begun() -> Clocks {
        let mut clocks = Clocks::default();
        clocks.engine_time(at(0));
        clocks
    }

    /// Looks for two seconds from `tenths` on; the host offset after that, seconds.
    fn settled(clocks: &mut Clocks, tenths: i64, machine_set_s: f64, offsets_s: &[f64]) -> f64 {
        for look in tenths..tenths + 20 {
            let mut now = at(look);
            now.utc_ns += (machine_set_s * S as f64) as i64;
            clocks.look(offsets_s.iter().map(|offset_s| known(*offset_s)), now);
        }
        clocks.host_offset_s()
    }

    #[test]
    fn what_two_sources_share_is_the_hosts_and_one_alone_beside_a_sound_one_is_wrong() {
        for (offsets_s, host_s) in [
            (vec![], 0.0),
            (vec![0.1], 0.0),
            (vec![-0.4, -1.2, 30.0], 0.0),
            (vec![30.0, -0.2], 0.0),
            (vec![6.0, 6.1], 6.0),
            (vec![-5.5, -5.4], -5.0),
            (vec![3600.2, 3599.9, 0.0], 3600.0),
            (vec![-3600.0, -3601.0, -3599.0, 50.0], -3600.0),
            (vec![30.0], 30.0),
            (vec![4.0, 4.5], 0.0),
        ] {
            let mut clocks = begun();
            let found_s = settled(&mut clocks, 0, 0.0, &offsets_s);
            assert!((found_s - host_s).abs() < 1.0, "{offsets_s:?}: {found_s}");
        }
    }

    #[test]
    fn a_step_of_the_machines_clock_moves_nothing() {
        let mut clocks = begun();
        assert_eq!(settled(&mut clocks, 0, 0.0, &[-0.1, -0.2]), 0.0);
        // Against the engine's time the sources are as before.
        assert_eq!(settled(&mut clocks, 20, 7.0, &[-0.1, -0.2]), 0.0);
        assert_eq!(clocks.engine_time(at(40)).utc_ns, at(40).utc_ns);
        let mut set = at(40);
        set.utc_ns += 7 * S;
        assert_eq!(clocks.ahead_ns(set), -7 * S);
    }

    #[test]
    fn a_lone_source_is_followed_until_others_contradict_it() {
        let mut clocks = begun();
        assert_eq!(settled(&mut clocks, 0, 0.0, &[30.0]), 30.0);
        assert_eq!(settled(&mut clocks, 20, 0.0, &[30.0, 0.0]), 0.0);
        assert_eq!(settled(&mut clocks, 40, 0.0, &[30.0, 30.5, 0.0]), 30.0);
    }

    #[test]
    fn an_offset_must_hold_before_it_is_the_hosts() {
        let mut clocks = begun();
        for look in 0..40 {
            // Never half a second at the same offset.
            let offset_s = 100.0 * (look / 3) as f64;
            clocks.look([known(offset_s), known(offset_s)].into_iter(), at(look));
            assert_eq!(clocks.host_offset_ns, 0, "{look}");
        }
    }

    #[test]
    fn a_successor_goes_on_with_the_time_of_the_one_before() {
        let mut clocks = begun();
        settled(&mut clocks, 0, 0.0, &[12.0, 12.0]);
        let mut set = at(30);
        set.utc_ns -= 50 * S;
        let mut next = Clocks::default();
        next.resume(set, clocks.ahead_ns(set), clocks.host_offset_ns);
        assert_eq!(next.engine_time(set), clocks.engine_time(set));
        assert_eq!(next.host_offset_ns, 12 * S);
    }
}
