//! Time of day to UTC.
//!
//! ASTERIX and most sensor formats stamp reports with seconds since midnight. The obvious conversion, "add today's
//! date", is wrong for some minutes every night: a report measured at 23:59:59.9 arrives at 00:00:00.1, and a
//! recording may cross midnight. [`DayUnroller`] instead picks, for each stamp, the day that brings it nearest to the
//! source's running time. That is right as long as no report is more than twelve hours early or late.

/// Nanoseconds in a second.
pub const NS_PER_S: i64 = 1_000_000_000;
/// Nanoseconds in a day (UTC without leap seconds, as sensors count it).
pub const NS_PER_DAY: i64 = 86_400 * NS_PER_S;

/// Nanoseconds in `seconds`, rounded.
pub fn ns(seconds: f64) -> i64 {
    (seconds * NS_PER_S as f64).round() as i64
}

/// Seconds in `ns`.
pub fn seconds(ns: i64) -> f64 {
    ns as f64 / NS_PER_S as f64
}

/// Nanoseconds since midnight of a count of 1/128 s, the unit of ASTERIX; exact.
pub fn time_of_day_ns(ticks_128: u32) -> i64 {
    i64::from(ticks_128) * NS_PER_S / 128
}

/// Turns times of day into UTC, across midnight.
#[derive(Clone, Copy, Debug)]
pub struct DayUnroller {
    running_ns: i64,
}

impl DayUnroller {
    /// Makes an unroller for a source with a first report measured within twelve hours of `near_ns` (UTC,
    /// nanoseconds).
    pub fn near(near_ns: i64) -> Self {
        Self { running_ns: near_ns }
    }

    /// UTC of `time_of_day_ns`, on the day that brings it nearest to the running time.
    pub fn utc_ns(&self, time_of_day_ns: i64) -> i64 {
        let midnight = self.running_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        let same_day = midnight + time_of_day_ns;
        let difference = same_day - self.running_ns;
        if difference > NS_PER_DAY / 2 {
            same_day - NS_PER_DAY
        } else if difference < -NS_PER_DAY / 2 {
            same_day + NS_PER_DAY
        } else {
            same_day
        }
    }

    /// Moves the running time, once a stamp has been believed. It never moves back.
    pub fn advance(&mut self, utc_ns: i64) {
        self.running_ns = self.running_ns.max(utc_ns);
    }

    /// The running time: the latest believed time, UTC, nanoseconds.
    pub fn running_ns(&self) -> i64 {
        self.running_ns
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const DAY: i64 = 16_931 * NS_PER_DAY; // 2016-05-10

    #[test]
    fn midnight_is_crossed_once_and_late_reports_stay_on_their_day() {
        let mut clock = DayUnroller::near(DAY + ns(86_399.0));
        for (time_of_day_s, expected_s) in [
            (86_399.5, 86_399.5),
            (0.25, 86_400.25),
            (86_399.9, 86_399.9),
            (0.5, 86_400.5),
            (61.0, 86_461.0),
        ] {
            let utc = clock.utc_ns(ns(time_of_day_s));
            assert_eq!(utc, DAY + ns(expected_s), "time of day {time_of_day_s}");
            clock.advance(utc);
        }
    }

    #[test]
    fn ticks_are_exact() {
        assert_eq!(time_of_day_ns(1), 7_812_500);
        assert_eq!(time_of_day_ns(128 * 86_400 - 1), NS_PER_DAY - 7_812_500);
    }

    proptest! {
        #[test]
        fn any_walk_of_less_than_half_a_day_per_step_is_followed(steps in prop::collection::vec(0..NS_PER_DAY / 2, 1..50)) {
            let mut utc = DAY;
            let mut clock = DayUnroller::near(utc);
            for step in steps {
                utc += step;
                prop_assert_eq!(clock.utc_ns(utc.rem_euclid(NS_PER_DAY)), utc);
                clock.advance(utc);
            }
        }
    }
}
