//! A source's clock, judged by the times of receipt of reports.
//!
//! Each report carries a time of measurement and arrives a little later: after the time for measuring, processing
//! and sending. A wrong clock appears as an additional offset. A small steady offset is harmless and can be
//! corrected. A time is rejected if the clock jumps, or if the time is far from the caller's reference clock. This
//! module does not judge the reference: a steady offset common to several sources belongs to the receiver.
//!
//! The offset is followed as a mean over the latest reports that agree with each other. Single reports far from the
//! offset do not move the offset; several in a row that agree with each other do, since then the clock was set. A
//! source that is wild too often is wild as a whole, until for a while it hardly was wild (hysteresis).
//!
//! A report may be *late* while the clock is sound: ground stations and centres hold single reports back for seconds. A
//! time behind the offset is therefore believed up to [`LATE_S`], unless several in a row agree: the clock was set
//! back. Reports that arrive together count as a single statement, since held-back reports are sent together.
//!
//! Reports *saved* during an interruption arrive after a silence, in a burst: the times continue from the begin of the
//! silence, and come nearer to the present faster than the present passes. A clock that was set back meanwhile stays
//! behind. Saved reports are believed and do not move the offset; users of saved reports count too old reports as late.

use messages::NS_PER_S;

/// Successive reports that must agree with each other, against the estimate, before the estimate follows; and reports
/// after which the offset is known.
const AGREEING: u32 = 8;
/// Greatest delay of a late report behind the others, seconds: the window in which fusion uses late reports.
const LATE_S: f64 = 10.0;
/// Late reports in a row that agree with each other and are still believed.
const LATE_AGREEING: u32 = 3;
/// Reports received within this time arrive together, nanoseconds.
const TOGETHER_NS: u64 = 50_000_000;
/// Share of the present's passing by which saved reports at least approach the present.
const DRAINING: f64 = 0.5;
/// Smallest weight of a new report in the offset.
const GAIN_MIN: f64 = 1.0 / 64.0;
/// Weight of a late report against a clock: a clock with mostly late reports is not sound.
const LATE_ODDITY: f64 = 0.5;
/// Weight of a new report in the share of wild reports, and the shares from which and below which the source as a whole
/// is wild and no longer is.
const SHARE_GAIN: f64 = 1.0 / 16.0;
const WILD_FROM: f64 = 0.3;
const WILD_UNTIL: f64 = 0.05;

/// Estimated state of a source's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceClock {
    /// Greatest distance from another clock that is believed; half of this distance is a jump.
    step_s: f64,
    offset_s: f64,
    variance_s2: f64,
    /// Reports that agreed with the offset.
    reports: u32,
    /// Mean offset of the latest reports that agreed with each other and with nothing before, and the number of these
    /// reports.
    apart: (f64, u32),
    /// Time of receipt of the latest of these that was counted, UTC, nanoseconds.
    apart_ns: i64,
    /// Newest believed time of measurement, and the time of receipt of the latest report, UTC, nanoseconds.
    newest_ns: i64,
    received_ns: i64,
    /// End of the latest silence, UTC, nanoseconds, and the length of the silence, seconds.
    silence: (i64, f64),
    wild_share: f64,
    /// Time of receipt of the latest report that counted for the share, UTC, nanoseconds.
    judged_ns: i64,
    is_wild: bool,
}

impl SourceClock {
    /// Nothing is known yet; jumps beyond half of `step_s` (seconds) will not be believed.
    pub fn new(step_s: f64) -> Self {
        Self {
            step_s,
            offset_s: 0.0,
            variance_s2: 0.0,
            reports: 0,
            apart: (0.0, 0),
            apart_ns: i64::MIN,
            newest_ns: i64::MIN,
            received_ns: i64::MIN,
            silence: (i64::MIN, 0.0),
            wild_share: 0.0,
            judged_ns: i64::MIN,
            is_wild: false,
        }
    }

    /// Returns whether the time `time_ns` of a report received at `received_ns` is credible; both UTC in nanoseconds,
    /// any value. `common_s` is the offset (seconds) of sound clocks against times of receipt; the time may not be
    /// farther from this offset than the greatest distance. Without `common_s` only jumps count and, until the offset
    /// is known, the distance from the time of receipt.
    pub fn believes(&mut self, time_ns: i64, received_ns: i64, common_s: Option<f64>) -> bool {
        let offset_s = time_ns.saturating_sub(received_ns) as f64 / NS_PER_S;
        let is_known = self.reports >= AGREEING;
        let jumps = is_known && !self.is_near(offset_s, self.offset_s);
        let delay_s = self.offset_s - offset_s;
        let is_saved = jumps && self.is_saved(time_ns, received_ns, delay_s);
        self.received_ns = received_ns;
        if is_saved {
            self.newest_ns = time_ns;
            return !self.is_wild;
        }
        self.follow(offset_s, received_ns);
        let is_sound = common_s.is_none_or(|common_s| (self.offset_s - common_s).abs() <= self.step_s);
        let is_late = jumps && is_sound && (0.0..=LATE_S).contains(&delay_s) && self.apart.1 <= LATE_AGREEING;
        let common_s = common_s.or((!is_known).then_some(0.0));
        let is_far = common_s.is_some_and(|common_s| (offset_s - common_s).abs() > self.step_s);
        let is_odd = (is_far || jumps) && !is_late;
        if received_ns.abs_diff(self.judged_ns) >= TOGETHER_NS || self.reports < AGREEING {
            self.judged_ns = received_ns;
            let oddity = match (is_odd, is_late) {
                (true, _) => 1.0,
                (false, true) => LATE_ODDITY,
                (false, false) => 0.0,
            };
            self.wild_share += SHARE_GAIN * (oddity - self.wild_share);
            self.is_wild = self.wild_share > if self.is_wild { WILD_UNTIL } else { WILD_FROM };
        }
        let is_believed = !is_odd && !self.is_wild;
        if is_believed {
            self.newest_ns = self.newest_ns.max(time_ns);
        }
        is_believed
    }

    /// Whether a report that is `delay_s` behind the others was saved during the latest silence.
    fn is_saved(&mut self, time_ns: i64, received_ns: i64, delay_s: f64) -> bool {
        let seconds = |from_ns: i64, to_ns: i64| to_ns.saturating_sub(from_ns) as f64 / NS_PER_S;
        let silent_s = seconds(self.received_ns, received_ns);
        if silent_s > 0.5 * self.step_s {
            self.silence = (received_ns, silent_s);
        }
        let (ended_ns, silence_s) = self.silence;
        let left_s = silence_s - DRAINING * seconds(ended_ns, received_ns);
        (0.0..=left_s + 0.5 * self.step_s).contains(&delay_s) && left_s > 0.0 && time_ns >= self.newest_ns
    }

    /// Offset of the clock against times of receipt and the standard deviation from report to report, seconds; positive
    /// if the clock is ahead. `None` while too few reports are known.
    pub fn offset(&self) -> Option<(f64, f64)> {
        (self.reports >= AGREEING).then(|| (self.offset_s, self.variance_s2.sqrt()))
    }

    fn is_near(&self, offset_s: f64, other_s: f64) -> bool {
        (offset_s - other_s).abs() <= 0.5 * self.step_s
    }

    fn follow(&mut self, offset_s: f64, received_ns: i64) {
        if self.reports == 0 || self.is_near(offset_s, self.offset_s) {
            self.apart.1 = 0;
            self.reports = self.reports.saturating_add(1);
            let gain = (1.0 / f64::from(self.reports)).max(GAIN_MIN);
            let rest = if self.reports == 1 {
                0.0
            } else {
                offset_s - self.offset_s
            };
            self.offset_s = if self.reports == 1 {
                offset_s
            } else {
                self.offset_s + gain * rest
            };
            self.variance_s2 += gain * (rest * rest - self.variance_s2);
            return;
        }
        let (mean_s, count) = self.apart;
        if count > 0 && self.is_near(offset_s, mean_s) {
            if received_ns.abs_diff(self.apart_ns) < TOGETHER_NS {
                return;
            }
            self.apart = (mean_s + (offset_s - mean_s) / f64::from(count + 1), count + 1);
        } else {
            self.apart = (offset_s, 1);
        }
        self.apart_ns = received_ns;
        if self.apart.1 >= AGREEING {
            (self.offset_s, self.reports) = self.apart;
            self.apart.1 = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const S: i64 = 1_000_000_000;
    const NOW: i64 = 1_700_000_000 * S;

    /// How many of a hundred reports with these offsets (seconds) are believed.
    fn believed(clock: &mut SourceClock, offset_s: impl Fn(i64) -> f64) -> usize {
        let report = |step: &i64| {
            let received_ns = NOW + step * S / 10;
            clock.believes(
                received_ns + (offset_s(*step) * S as f64) as i64,
                received_ns,
                Some(0.0),
            )
        };
        (0..100).filter(report).count()
    }

    #[test]
    fn a_sound_clock_is_believed_and_its_delay_known() {
        let mut clock = SourceClock::new(5.0);
        assert_eq!(clock.offset(), None);
        assert_eq!(believed(&mut clock, |step| -0.4 - 0.1 * (step % 3) as f64), 100);
        let (offset_s, sigma_s) = clock.offset().unwrap();
        assert!(
            (offset_s + 0.5).abs() < 0.02 && (0.05..0.12).contains(&sigma_s),
            "{offset_s} {sigma_s}"
        );
    }

    #[test]
    fn a_clock_far_off_is_not_believed_and_its_offset_known() {
        for offset_s in [-30.0, 5.1, 30.0, 50.0, 70.0] {
            let mut clock = SourceClock::new(5.0);
            assert_eq!(believed(&mut clock, |_| offset_s), 0);
            assert!((clock.offset().unwrap().0 - offset_s).abs() < 1e-6);
        }
    }

    #[test]
    fn single_wild_times_harm_nobody() {
        for first in [0, 1, 7] {
            let mut clock = SourceClock::new(5.0);
            let offset_s = |step: i64| if step % 50 == first { 50.0 } else { 0.1 };
            assert_eq!(believed(&mut clock, offset_s), 98);
            assert!((clock.offset().unwrap().0 - 0.1).abs() < 1e-6);
        }
    }

    #[test]
    fn late_reports_of_a_sound_clock_are_believed_up_to_the_window() {
        for (delay_s, expected) in [(4.0, 100), (9.5, 100), (10.6, 91), (30.0, 91)] {
            let mut clock = SourceClock::new(5.0);
            believed(&mut clock, |_| -0.4);
            let offset_s = |step: i64| if step % 11 == 5 { -0.4 - delay_s } else { -0.4 };
            assert_eq!(believed(&mut clock, offset_s), expected, "{delay_s}");
            assert!((clock.offset().unwrap().0 + 0.4).abs() < 1e-6);
        }
    }

    #[test]
    fn reports_held_back_together_are_one_late_statement() {
        let mut clock = SourceClock::new(5.0);
        believed(&mut clock, |_| -0.4);
        for minute in 1..=3 {
            let received_ns = NOW + minute * 60 * S;
            let held_back = |index: i64| received_ns - 4 * S + index * S / 50;
            assert!((0..13).all(|index| clock.believes(held_back(index), received_ns, Some(0.0))));
            assert!((0..13).all(|index| clock.believes(received_ns - index * S / 50, received_ns, Some(0.0))));
        }
        assert!((clock.offset().unwrap().0 + 0.4).abs() < 0.2);
    }

    #[test]
    fn a_clock_of_which_most_reports_are_late_is_not_sound() {
        // Twenty reports at a time, as far off as the step.
        for offsets_s in [[4.5, -4.5, 0.0], [-4.5, 0.0, 4.5], [0.0, 4.5, -4.5]] {
            let mut clock = SourceClock::new(5.0);
            let report = |clock: &mut SourceClock, step: usize| {
                let received_ns = NOW + step as i64 * S / 10;
                clock.believes(
                    received_ns + (offsets_s[step % 3] * S as f64) as i64,
                    received_ns,
                    Some(0.0),
                )
            };
            let believed = (0..280)
                .flat_map(|step| [step; 20])
                .filter(|step| report(&mut clock, *step))
                .count();
            assert!(believed < 280 * 20 / 2, "{offsets_s:?}: {believed}");
        }
    }

    #[test]
    fn reports_saved_through_a_cut_are_believed_and_move_nothing() {
        // Seconds of the cut, and how many times faster than the present the saved reports arrive.
        for (cut_s, speed) in [(6, 1000), (6, 5), (30, 1000), (30, 20), (120, 50)] {
            let mut clock = SourceClock::new(5.0);
            believed(&mut clock, |_| -0.4);
            let begun_ns = NOW + 10 * S;
            let saved = (0..10 * cut_s).map(|step| {
                let received_ns = begun_ns + cut_s * S + step * S / 10 / speed;
                (begun_ns + step * S / 10 - 4 * S / 10, received_ns)
            });
            let mut last_ns = 0;
            for (time_ns, received_ns) in saved {
                last_ns = received_ns;
                assert!(
                    clock.believes(time_ns, received_ns, Some(0.0)),
                    "{cut_s} s, {speed} times"
                );
            }
            for step in 1..100 {
                let received_ns = last_ns + step * S / 10;
                assert!(
                    clock.believes(received_ns - 4 * S / 10, received_ns, Some(0.0)),
                    "{cut_s} s, {speed} times"
                );
            }
            assert!(
                (clock.offset().unwrap().0 + 0.4).abs() < 0.1,
                "{cut_s} s, {speed} times"
            );
        }
    }

    #[test]
    fn a_clock_that_comes_back_wrong_after_a_silence_is_followed_or_refused() {
        for (silence_s, offset_s, is_refused) in
            [(30, -4.0, false), (30, -8.0, true), (10, -9.0, true), (30, 20.0, true)]
        {
            let mut clock = SourceClock::new(5.0);
            believed(&mut clock, |_| -0.4);
            let outcomes: Vec<bool> = (0..1000)
                .map(|step| {
                    let received_ns = NOW + (10 + silence_s) * S + step * S / 10;
                    clock.believes(received_ns + (offset_s * S as f64) as i64, received_ns, Some(0.0))
                })
                .collect();
            let found_s = clock.offset().unwrap().0;
            assert!((found_s - offset_s).abs() < 0.1, "{silence_s} {offset_s}: {found_s}");
            assert_eq!(outcomes[999], !is_refused, "{silence_s} {offset_s}");
            let believed = outcomes.iter().filter(|is_believed| **is_believed).count();
            assert!(!is_refused || believed < 700, "{silence_s} {offset_s}: {believed}");
        }
    }

    #[test]
    fn a_clock_set_back_is_not_late_for_long() {
        let mut clock = SourceClock::new(5.0);
        believed(&mut clock, |_| 0.0);
        let outcomes = std::array::from_fn::<_, 20, _>(|step| {
            let received_ns = NOW + (100 + step as i64) * S / 10;
            clock.believes(received_ns - 4 * S, received_ns, Some(0.0))
        });
        assert_eq!(
            outcomes.iter().position(|is_believed| !is_believed),
            Some(3),
            "{outcomes:?}"
        );
        assert!((clock.offset().unwrap().0 + 4.0).abs() < 1e-6, "the clock is followed");
    }

    #[test]
    fn a_clock_that_jumps_is_wild_as_a_whole_and_believed_again_when_it_is_sound() {
        let mut clock = SourceClock::new(5.0);
        assert_eq!(believed(&mut clock, |_| 0.0), 100);
        let jumping = believed(&mut clock, |step| if step % 3 == 0 { 4.0 } else { -0.5 });
        assert!(jumping < 20, "{jumping}");
        let sound = believed(&mut clock, |_| 0.0);
        assert!((40..80).contains(&sound), "{sound}: not at once, and for good");
        assert_eq!(believed(&mut clock, |_| 0.0), 100);
    }

    #[test]
    fn a_clock_that_was_set_is_followed() {
        let mut clock = SourceClock::new(5.0);
        believed(&mut clock, |_| 0.0);
        believed(&mut clock, |_| 3.0);
        assert_eq!(believed(&mut clock, |_| 3.0), 100);
        assert!((clock.offset().unwrap().0 - 3.0).abs() < 0.1);
    }

    #[test]
    fn a_steady_offset_is_far_from_one_clock_and_near_to_another() {
        for (common_s, least, most) in [(Some(0.0), 0, 0), (Some(28.0), 100, 100), (None, 40, 70)] {
            let mut clock = SourceClock::new(5.0);
            let believed = (0..100)
                .filter(|step| clock.believes(NOW + (step + 30) * S, NOW + step * S, common_s))
                .count();
            assert!((least..=most).contains(&believed), "{common_s:?}: {believed}");
        }
        let mut clock = SourceClock::new(5.0);
        let jumping = (0..100)
            .filter(|step| clock.believes(NOW + (step + 50 * (step % 2)) * S, NOW + step * S, None))
            .count();
        assert!(jumping < 10, "{jumping}");
    }

    proptest! {
        #[test]
        fn any_times_are_judged(times in prop::collection::vec((any::<i64>(), any::<i64>()), 0..200)) {
            let mut clock = SourceClock::new(5.0);
            for (time_ns, received_ns) in times {
                let believed = clock.believes(time_ns, received_ns, Some(0.0));
                let apart = i128::from(time_ns) - i128::from(received_ns);
                prop_assert!(!believed || apart <= 5 * i128::from(S) && apart >= -15 * i128::from(S));
                prop_assert!(clock.offset().is_none_or(|(offset_s, sigma_s)| offset_s.is_finite() && sigma_s >= 0.0));
            }
        }
    }
}
