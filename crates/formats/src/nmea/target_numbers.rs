//! Track numbers of a radar's targets.
//!
//! A radar numbers its targets from 0 to 999, and gives the number of a lost target to another one. Lines may come from
//! several radars, which differ in talker or station. The track number therefore has three parts: radar in order of
//! appearance, use of the number, number. The first target 11 of the first radar is track 11, the next one 1011; of the
//! second radar, 1000011.

use super::target_counters::RadarTargetRejection;

/// Most radars in the lines of one reader.
pub(super) const RADARS_MAX: usize = 16;
/// Numbers of a radar: 0 to 999.
const NUMBERS: u32 = 1000;
/// Uses of a number that are told apart.
const USES: u32 = 1000;
/// Silence after which a number is of another target, nanoseconds: the line that states the loss may be missing.
pub(super) const SILENCE_MAX_NS: u64 = 60_000_000_000;
/// Time after TTM for which TLL of the same target repeats what TTM has stated, nanoseconds: some turns of the antenna.
const TTM_AGE_MAX_NS: u64 = 10_000_000_000;

/// What distinguishes a radar: a hash of its talker and its station.
pub(super) type RadarKey = u64;

/// Numbers in use.
#[derive(Debug)]
pub(super) struct TargetNumbers {
    radars: Vec<(RadarKey, Vec<Number>)>,
}

/// Use of a number.
#[derive(Clone, Copy, Debug, Default)]
struct Number {
    /// Targets that had the number before.
    earlier: u32,
    /// Time of the latest line of the present target; `None` if there is none.
    last_ns: Option<i64>,
    /// Time of the latest TTM with a position.
    ttm_ns: Option<i64>,
}

impl TargetNumbers {
    pub(super) fn new() -> Self {
        Self {
            radars: Vec::with_capacity(RADARS_MAX),
        }
    }

    /// Track number of the radar's target `number` (0 to 999) at `now_ns`.
    pub(super) fn used(&mut self, radar: RadarKey, number: u32, now_ns: i64) -> Result<u32, RadarTargetRejection> {
        let (place, of_radar) = self.of(radar)?;
        let found = &mut of_radar[number as usize % NUMBERS as usize];
        if found
            .last_ns
            .is_some_and(|last_ns| now_ns.abs_diff(last_ns) > SILENCE_MAX_NS)
        {
            found.end();
        }
        found.last_ns = Some(now_ns);
        Ok(found.track(place, number))
    }

    /// Track number of a target that is lost; `None` if no target has the number.
    pub(super) fn lost(&mut self, radar: RadarKey, number: u32) -> Option<u32> {
        let place = self.radars.iter().position(|(key, _)| *key == radar)?;
        let found = &mut self.radars[place].1[number as usize % NUMBERS as usize];
        found.last_ns?;
        let track = found.track(place, number);
        found.end();
        Some(track)
    }

    /// Notes a TTM with a position at `now_ns`.
    pub(super) fn ttm(&mut self, radar: RadarKey, number: u32, now_ns: i64) {
        if let Ok((_, of_radar)) = self.of(radar) {
            of_radar[number as usize % NUMBERS as usize].ttm_ns = Some(now_ns);
        }
    }

    /// Whether TTM states the position of the target already.
    pub(super) fn has_ttm(&mut self, radar: RadarKey, number: u32, now_ns: i64) -> bool {
        let of_radar = self.radars.iter().find(|(key, _)| *key == radar);
        let ttm_ns = of_radar.and_then(|(_, numbers)| numbers[number as usize % NUMBERS as usize].ttm_ns);
        ttm_ns.is_some_and(|ttm_ns| now_ns.abs_diff(ttm_ns) <= TTM_AGE_MAX_NS)
    }

    fn of(&mut self, radar: RadarKey) -> Result<(usize, &mut Vec<Number>), RadarTargetRejection> {
        let place = match self.radars.iter().position(|(key, _)| *key == radar) {
            Some(place) => place,
            None if self.radars.len() == RADARS_MAX => return Err(RadarTargetRejection::Radars),
            None => {
                self.radars.push((radar, vec![Number::default(); NUMBERS as usize]));
                self.radars.len() - 1
            }
        };
        Ok((place, &mut self.radars[place].1))
    }
}

impl Number {
    fn track(&self, radar: usize, number: u32) -> u32 {
        (radar as u32 * USES + self.earlier) * NUMBERS + number
    }

    fn end(&mut self) {
        *self = Self {
            earlier: (self.earlier + 1) % USES,
            ..Self::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn a_number_is_of_a_new_track_after_a_loss_and_after_silence() {
        let mut numbers = TargetNumbers::new();
        assert_eq!(numbers.lost(7, 11), None);
        assert_eq!(numbers.used(7, 11, 0), Ok(11));
        assert_eq!(numbers.used(7, 11, 60 * S), Ok(11));
        assert_eq!(numbers.lost(7, 11), Some(11));
        assert_eq!(numbers.lost(7, 11), None, "stated again");
        assert_eq!(numbers.used(7, 11, 61 * S), Ok(1_011));
        assert_eq!(numbers.used(7, 11, 122 * S), Ok(2_011), "silence");
        assert_eq!(numbers.used(8, 11, 122 * S), Ok(1_000_011), "another radar");
    }

    #[test]
    fn numbers_are_bounded() {
        let mut numbers = TargetNumbers::new();
        for radar in 0..RADARS_MAX as u64 {
            assert!(numbers.used(radar, 999, 0).is_ok());
        }
        assert_eq!(numbers.used(99, 1, 0), Err(RadarTargetRejection::Radars));
        for _ in 0..USES {
            numbers.lost(15, 999);
            assert!(numbers.used(15, 999, 0).unwrap() < RADARS_MAX as u32 * USES * NUMBERS);
        }
        assert_eq!(numbers.used(15, 999, 0), Ok(15_000_999), "the uses begin again");
    }

    #[test]
    fn tll_repeats_ttm_for_some_turns() {
        let mut numbers = TargetNumbers::new();
        assert!(!numbers.has_ttm(7, 1, 0));
        numbers.ttm(7, 1, 0);
        assert!(numbers.has_ttm(7, 1, 10 * S) && !numbers.has_ttm(7, 1, 11 * S) && !numbers.has_ttm(7, 2, 0));
    }
}
