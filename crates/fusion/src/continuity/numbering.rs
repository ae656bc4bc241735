//! Numbers of system tracks, none of which is given to two targets within a day.
//!
//! Numbers count up from 1. If the used numbers are unknown, numbering begins at a number derived from the time of day,
//! in the upper half of all numbers. No numbering from 1 reaches the upper half within a day. Later starts begin at
//! higher numbers, and no engine starts tracks faster than these numbers increase (25 in a millisecond). The last
//! number is followed by the first number of the upper half, which belongs to midnight.

/// First number of the upper half.
const FIRST_ANEW: u32 = 1 << 31;
/// Numbers that are reserved at a time; a divisor of [`FIRST_ANEW`].
pub(crate) const BLOCK: u32 = 256;
const DAY_NS: i64 = 86_400_000_000_000;

/// The number after `number`.
pub(crate) fn following(number: u32) -> u32 {
    number.checked_add(1).unwrap_or(FIRST_ANEW)
}

/// The first number that is not reserved when `next` comes next: the end of the block after the block of `next`.
pub(crate) fn reserved(next: u32) -> u32 {
    let end = (u64::from(next / BLOCK) + 2) * u64::from(BLOCK);
    u32::try_from(end).unwrap_or_else(|_| FIRST_ANEW + (end - (1 << 32)) as u32)
}

/// Returns the first number at `utc_ns` (nanoseconds since 1970) if the used numbers are unknown.
pub fn anew(utc_ns: i64) -> u32 {
    let of_day_ns = i128::from(utc_ns.rem_euclid(DAY_NS));
    FIRST_ANEW + (of_day_ns * i128::from(FIRST_ANEW) / i128::from(DAY_NS)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn numbering_anew_rises_through_the_day_and_never_meets_numbers_from_1() {
        let midnight_ns = 20_000 * DAY_NS;
        assert_eq!(anew(midnight_ns), FIRST_ANEW);
        assert_eq!(anew(midnight_ns - 1), u32::MAX);
        let mut last = anew(midnight_ns);
        for time_ns in (midnight_ns + 10 * MS..midnight_ns + DAY_NS).step_by((977 * MS) as usize) {
            let number = anew(time_ns);
            assert!(number >= last + 240, "{number} after {last}");
            last = number;
        }
        assert!(anew(-1) >= FIRST_ANEW, "a clock before 1970");
    }

    #[test]
    fn after_the_last_number_follows_the_place_of_midnight() {
        assert_eq!((following(1), following(u32::MAX)), (2, FIRST_ANEW));
        assert_eq!((reserved(1), reserved(511)), (2 * BLOCK, 3 * BLOCK));
        assert_eq!(reserved(u32::MAX - 2 * BLOCK), u32::MAX - BLOCK + 1);
        assert_eq!(reserved(u32::MAX - BLOCK), FIRST_ANEW);
        assert_eq!(reserved(u32::MAX), FIRST_ANEW + BLOCK);
    }
}
