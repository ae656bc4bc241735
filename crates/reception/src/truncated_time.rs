//! Times that are cut off.
//!
//! The oldest radar format sends the time in two bytes, modulo 512 s from midnight. The missing part is chosen so
//! that the time is nearest to a reference time: the radar's service messages or the receiver's clock. The result is
//! right if the two differ by less than 256 s. A day is no multiple of 512 s: midnight cuts the last period short,
//! and the count restarts.

use frames::time::NS_PER_DAY;
use observations::TRUNCATION_NS;

/// The time of day that ends in `truncated_ns`, nearest to `near_ns` (UTC, nanoseconds).
pub(crate) fn complete(truncated_ns: i64, near_ns: i64) -> i64 {
    let into_day_ns = near_ns.rem_euclid(NS_PER_DAY);
    let last_period = (NS_PER_DAY - 1 - truncated_ns) / TRUNCATION_NS;
    // Seen from the day itself, and from that before and after it.
    let candidates = [-NS_PER_DAY, 0, NS_PER_DAY].map(|day_ns| {
        let wanted_ns = into_day_ns - day_ns;
        let period = (wanted_ns - truncated_ns + TRUNCATION_NS / 2).div_euclid(TRUNCATION_NS);
        let time_of_day_ns = truncated_ns + period.clamp(0, last_period) * TRUNCATION_NS;
        ((time_of_day_ns - wanted_ns).abs(), time_of_day_ns)
    });
    candidates
        .into_iter()
        .min()
        .map_or(truncated_ns, |(_, time_of_day_ns)| time_of_day_ns)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use frames::time::NS_PER_S;

    use super::*;

    const DAY: i64 = 16_931 * NS_PER_DAY;

    #[test]
    fn the_count_begins_anew_at_midnight() {
        let s = NS_PER_S;
        // 86,400 s are 168 periods and 384 s.
        assert_eq!(complete(383 * s, DAY - s), 86_399 * s);
        assert_eq!(complete(383 * s, DAY + s), 86_399 * s, "late by two seconds");
        assert_eq!(complete(2 * s, DAY - s), 2 * s, "of the next day");
        assert_eq!(complete(2 * s, DAY + 600 * s), 514 * s);
        assert_eq!(
            complete(400 * s, DAY - s),
            400 * s,
            "the day before has no such time near its end"
        );
    }

    proptest! {
        #[test]
        fn any_time_is_found_again_from_any_less_than_half_a_period_off(
            time_ns in 0..NS_PER_DAY, off_ns in -TRUNCATION_NS / 2 + 1..TRUNCATION_NS / 2,
        ) {
            // Around midnight two times of one remainder may be nearer to each other than a period.
            prop_assume!((TRUNCATION_NS..NS_PER_DAY - TRUNCATION_NS).contains(&time_ns));
            prop_assert_eq!(complete(time_ns % TRUNCATION_NS, DAY + time_ns + off_ns), time_ns);
        }
    }
}
