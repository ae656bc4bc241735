//! Looks of the standby at the leader: when the next look is due, and when the leader counts as hung.
//!
//! The leader's *silence* is the time since the last sign of life. A stall of the whole machine also makes a silence:
//! neither process runs during the stall, and the standby's look is late. Therefore a silence of sufficient length is
//! not enough. After a *long* look the standby must look again, for some 30 ms in short looks. A leader that lives
//! gives a sign of life every 20 ms, also without work.
//!
//! Each look wakes the machine, so looks are as rare as the take-over time permits: the next look is due while there is
//! still time for the short looks, counted from the last sign of life.

use std::time::Duration;

use runtime::LookPause;

/// Time between two looks at the leader while many reports come.
pub(crate) const LOOK: Duration = Duration::from_millis(5);
/// Longest time between two looks while few reports come.
const LOOK_IDLE: Duration = Duration::from_millis(100);
/// Time of short looks without a sign of life after a long look, nanoseconds: longer than the 20 ms of an idle leader.
const SURE_NS: i64 = 30_000_000;
/// Long looks in a row without a sign of life after which the leader counts as hung: each look of a standby on an
/// overloaded machine may be late.
const LONG_LOOKS: u32 = 8;

/// Looks of the standby at leader after leader.
#[derive(Debug)]
pub(crate) struct StandbyLooks {
    takeover_ns: i64,
    /// Longest time from a sign of life to the next look, nanoseconds.
    calm_ns: i64,
    pause: LookPause,
    /// Last look, and last sign of life, monotonic, nanoseconds.
    looked_ns: i64,
    sign_ns: i64,
    /// Time of short looks without a sign of life since the last long look, nanoseconds.
    sure_ns: i64,
    /// Long looks in a row without a sign of life.
    long_looks: u32,
    /// Whether the last look found no new sign of life.
    is_still: bool,
}

impl StandbyLooks {
    /// Creates the looks of a standby that takes over after `takeover_ns` without a sign of life.
    pub(crate) fn new(takeover_ns: i64, now_ns: i64) -> Self {
        // Looks are somewhat late; with a short take-over time, few looks are left as compensation.
        let spare_ns = (takeover_ns / 20).max(SURE_NS - takeover_ns / 4);
        // A hang after the last sign of life leaves time for the short looks.
        let calm_ns = (takeover_ns - SURE_NS - spare_ns).max(LOOK.as_nanos() as i64);
        let idle = Duration::from_nanos(calm_ns.unsigned_abs());
        Self {
            takeover_ns,
            calm_ns,
            pause: LookPause::between(LOOK, idle.clamp(LOOK, LOOK_IDLE)),
            looked_ns: now_ns,
            sign_ns: now_ns,
            sure_ns: 0,
            long_looks: 0,
            is_still: false,
        }
    }

    /// Begins with another leader, which counts as alive.
    pub(crate) fn begin(&mut self, now_ns: i64) {
        (self.sign_ns, self.looked_ns) = (now_ns, now_ns);
        (self.sure_ns, self.long_looks, self.is_still) = (0, 0, false);
    }

    /// Notes a look at `now_ns`, with the time of a new `sign` of life, if any, and whether many reports came.
    pub(crate) fn note(&mut self, now_ns: i64, sign: Option<i64>, is_busy: bool) {
        self.pause.after(is_busy);
        let passed_ns = now_ns.saturating_sub(self.looked_ns);
        let is_long = passed_ns > self.takeover_ns / 4;
        self.is_still = sign.is_none();
        if let Some(sign_ns) = sign {
            // The leader may have stopped at once after that sign of life.
            self.sign_ns = sign_ns.max(self.looked_ns).min(now_ns);
            (self.sure_ns, self.long_looks) = (0, 0);
        } else if is_long {
            self.sure_ns = 0;
            self.long_looks += 1;
        } else {
            self.sure_ns = self.sure_ns.saturating_add(passed_ns);
            self.long_looks = 0;
        }
        self.looked_ns = now_ns;
    }

    /// Whether the leader counts as hung, if a silence of `least_ns` is permitted in any case.
    pub(crate) fn leader_hangs(&self, least_ns: i64) -> bool {
        let is_sure = self.sure_ns >= SURE_NS || self.long_looks >= LONG_LOOKS;
        is_sure && self.silence_ns() >= self.takeover_ns.max(least_ns)
    }

    fn silence_ns(&self) -> i64 {
        self.looked_ns - self.sign_ns
    }

    /// Time until the next look: half of a long look while the leader is silent, so that a look may be somewhat late.
    pub(crate) fn pause(&self) -> Duration {
        let is_silent = self.is_still || self.silence_ns() >= self.takeover_ns / 4;
        let most_ns = if is_silent {
            let short_ns = self.takeover_ns / 8;
            let left_ns = self.takeover_ns.saturating_sub(self.silence_ns());
            short_ns.min(left_ns.max(LOOK.as_nanos() as i64))
        } else {
            (self.calm_ns - self.silence_ns()).max(LOOK.as_nanos() as i64)
        };
        self.pause.present().min(Duration::from_nanos(most_ns.unsigned_abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;
    const TAKEOVERS_MS: [i64; 5] = [50, 60, 100, 250, 2000];

    fn pause_ns(looks: &StandbyLooks) -> i64 {
        looks.pause().as_nanos() as i64
    }

    /// Looks at a leader without reports, which gives a sign of life at each look, until the pause is the longest.
    fn idle(takeover_ns: i64) -> StandbyLooks {
        let mut looks = StandbyLooks::new(takeover_ns, 0);
        for _ in 0..50 {
            let now_ns = looks.looked_ns + pause_ns(&looks);
            looks.note(now_ns, Some(now_ns), false);
        }
        looks
    }

    /// Time from the last sign of life, `after_ns` after a look, until the leader counts as hung, with looks that are
    /// each `late_ns` late.
    fn found_ns(takeover_ns: i64, after_ns: i64, late_ns: i64) -> i64 {
        let mut looks = idle(takeover_ns);
        let sign_ns = looks.looked_ns + after_ns;
        let mut sign = Some(sign_ns);
        while !looks.leader_hangs(0) {
            let now_ns = looks.looked_ns + pause_ns(&looks) + late_ns;
            assert!(now_ns - sign_ns < 100 * takeover_ns);
            let new = if now_ns >= sign_ns { sign.take() } else { Some(now_ns) };
            looks.note(now_ns, new, false);
        }
        looks.looked_ns - sign_ns
    }

    #[test]
    fn an_idle_pause_leaves_time_for_the_short_looks() {
        for takeover_ns in TAKEOVERS_MS.map(|takeover_ms| takeover_ms * MS) {
            let pause_ns = pause_ns(&idle(takeover_ns));
            assert!(pause_ns <= takeover_ns - SURE_NS, "{pause_ns} of {takeover_ns}");
            assert!(pause_ns >= LOOK.as_nanos() as i64, "{pause_ns} of {takeover_ns}");
        }
        assert_eq!(pause_ns(&idle(100 * MS)), 65 * MS);
        assert_eq!(pause_ns(&idle(2000 * MS)), 100 * MS);
    }

    /// Looks a second at a leader that gives a sign of life every 20 ms.
    fn looks_a_second(takeover_ns: i64) -> i64 {
        let mut looks = idle(takeover_ns);
        let (begin_ns, mut count) = (looks.looked_ns, 0);
        while looks.looked_ns < begin_ns + 10_000 * MS {
            let now_ns = looks.looked_ns + pause_ns(&looks) + MS / 10;
            looks.note(now_ns, Some(now_ns - now_ns % (20 * MS)), false);
            count += 1;
        }
        count / 10
    }

    #[test]
    fn a_standby_wakes_the_machine_seldom() {
        let counts = [100, 250, 2000].map(|takeover_ms| looks_a_second(takeover_ms * MS));
        assert!(counts[0] <= 17 && counts[1] <= 10 && counts[2] <= 10, "{counts:?}");
    }

    #[test]
    fn a_hang_is_found_within_the_takeover_time_and_one_short_look() {
        for takeover_ns in TAKEOVERS_MS.map(|takeover_ms| takeover_ms * MS) {
            for after_ns in (0..=takeover_ns / 2).step_by(MS as usize / 4) {
                let found_ns = found_ns(takeover_ns, after_ns, 0);
                let most_ns = takeover_ns + takeover_ns / 8;
                assert!(
                    (takeover_ns..=most_ns).contains(&found_ns),
                    "{found_ns} of {takeover_ns}, {after_ns}"
                );
            }
        }
    }

    #[test]
    fn late_looks_find_a_hang_somewhat_later() {
        for takeover_ns in [100 * MS, 250 * MS, 2000 * MS] {
            for (late_ms, after_ms) in (0..=12).flat_map(|late_ms| (0..50).map(move |after_ms| (late_ms, after_ms))) {
                let found_ns = found_ns(takeover_ns, after_ms * MS, late_ms * MS);
                assert!(
                    10 * found_ns <= 13 * takeover_ns,
                    "{found_ns} of {takeover_ns}, {late_ms} ms late, {after_ms} ms"
                );
            }
        }
        // All looks are long: the standby of an overloaded machine is slow, and takes over all the same.
        assert!(found_ns(100 * MS, 0, 40 * MS) < 600 * MS);
    }

    #[test]
    fn a_long_look_of_any_length_is_followed_by_a_short_look_before_a_leader_hangs() {
        for takeover_ns in TAKEOVERS_MS.map(|takeover_ms| takeover_ms * MS) {
            for length_ns in [takeover_ns / 4 + 1, takeover_ns / 2, takeover_ns, 100 * takeover_ns] {
                for has_sign in [false, true] {
                    let mut looks = idle(takeover_ns);
                    // Silence that is nearly sufficient, in short looks.
                    for _ in 0..7 {
                        looks.note(looks.looked_ns + takeover_ns / 8, None, false);
                    }
                    assert!(!looks.leader_hangs(0));
                    let sign = has_sign.then_some(looks.looked_ns);
                    looks.note(looks.looked_ns + length_ns, sign, false);
                    assert!(!looks.leader_hangs(0), "{length_ns} of {takeover_ns}");
                    assert!(looks.pause().as_nanos() as i64 <= takeover_ns / 4);
                }
            }
        }
    }

    /// Whether a leader that gives a sign of life every 20 ms counts as hung, with a stall of the machine of `stall_ns`
    /// from `begins_ns` on, and the next sign of life 25 ms after the stall.
    fn hangs_after_stall(takeover_ns: i64, begins_ns: i64, stall_ns: i64) -> bool {
        let mut looks = idle(takeover_ns);
        let (first_ns, every_ns) = (looks.looked_ns, 20 * MS);
        let (begins_ns, ends_ns) = (first_ns + begins_ns, first_ns + begins_ns + stall_ns);
        let last_sign_ns = |now_ns: i64| {
            let until_ns = now_ns.min(begins_ns);
            let after_ns = now_ns - ends_ns - 25 * MS;
            match after_ns >= 0 {
                true => now_ns - after_ns % every_ns,
                false => until_ns - (until_ns - first_ns) % every_ns,
            }
        };
        let mut seen_ns = first_ns;
        let mut has_hung = false;
        while looks.looked_ns < ends_ns + 100 * MS {
            let due_ns = looks.looked_ns + pause_ns(&looks);
            let now_ns = if (begins_ns..ends_ns).contains(&due_ns) {
                ends_ns
            } else {
                due_ns
            };
            let sign_ns = last_sign_ns(now_ns);
            looks.note(now_ns, (sign_ns != seen_ns).then_some(sign_ns), false);
            seen_ns = sign_ns;
            has_hung |= looks.leader_hangs(0);
        }
        has_hung
    }

    #[test]
    fn a_pause_of_the_machine_is_no_hang_if_a_sign_of_life_follows_within_25_ms() {
        for takeover_ns in [70 * MS, 100 * MS, 250 * MS, 2000 * MS] {
            for stall_ns in (0..300).step_by(3).chain([1000, 60_000]).map(|stall_ms| stall_ms * MS) {
                for begins_ns in (0..200).step_by(3).map(|begins_ms| begins_ms * MS) {
                    assert!(
                        !hangs_after_stall(takeover_ns, begins_ns, stall_ns),
                        "{stall_ns} at {begins_ns} of {takeover_ns}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_leader_that_begins_may_be_silent_for_longer_and_another_leader_begins_alive() {
        let mut looks = idle(100 * MS);
        for _ in 0..20 {
            looks.note(looks.looked_ns + 10 * MS, None, false);
        }
        assert!(looks.leader_hangs(0) && !looks.leader_hangs(1000 * MS));
        looks.begin(looks.looked_ns);
        looks.note(looks.looked_ns + 5 * MS, None, true);
        assert!(!looks.leader_hangs(0));
        assert_eq!(looks.pause(), LOOK);
    }
}
