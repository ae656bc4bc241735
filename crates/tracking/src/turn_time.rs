//! Estimates a sensor's turn time from the data.
//!
//! Scans much shorter than a turn hold a part of the sky each, and a target has no detection in most of them: no track
//! is ever confirmed. So a turn time that is not configured is estimated before the first scan is cut. There are three
//! sources, in this order:
//!
//! 1. The sensor states the turn time (I034/041, I002/041).
//! 2. The sensor reports when the antenna points north. Two successive intervals that agree are a turn.
//! 3. An antenna returns to a direction once in a turn. The times between detections in the same direction, of any
//!    target or false, are therefore a turn, or several after misses. The short intervals that agree are a single turn.
//!    North marks have precedence, so this source waits for three turns.
//!
//! Limits: turns of less than 0.4 s, and sensors without rotation, with detections from all directions at once. Such
//! sensors need a configured period.

use std::f64::consts::{PI, TAU};

use messages::Quantity;
use observations::Detection;

/// Shortest and longest turn that is believed, nanoseconds.
const TURN_MIN_NS: i64 = 400_000_000;
const TURN_MAX_NS: i64 = 60_000_000_000;
/// Number of distinguished directions. Within the shortest turn, an antenna leaves each direction in a few
/// milliseconds.
const DIRECTIONS: usize = 64;
/// Minimum of returns that agree, minimum share of agreeing returns, and the maximum of stored returns.
const AGREEING_MIN: usize = 8;
const AGREEING_SHARE: usize = 4;
const RETURNS_MAX: usize = 256;
/// Times of a turn agree that differ by less than this part.
const AGREEMENT_PARTS: i64 = 20;
/// Turns for which north marks are waited for.
const TURNS_BEFORE: i64 = 3;
/// Returns after which disagreement is certain.
const UNCLEAR_RETURNS: u32 = 1000;

/// Time of a turn, and the source of the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TurnEstimate {
    /// Nanoseconds.
    pub ns: i64,
    /// Origin of the value.
    pub basis: Basis,
}

/// Source of the turn time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The sensor states the turn time.
    Stated,
    /// Intervals of the sensor's north marks.
    NorthMarks,
    /// Times between detections in the same direction.
    Detections,
}

/// Search for the time of a turn.
#[derive(Clone, Debug)]
pub struct TurnTime {
    north_ns: Option<i64>,
    /// Time between the last two north marks.
    interval_ns: Option<i64>,
    /// Time and bearing of the latest detection in each direction.
    seen: [Option<(i64, f64)>; DIRECTIONS],
    first_ns: Option<i64>,
    returns: Vec<i64>,
    returns_in_all: u32,
    turn: Option<TurnEstimate>,
}

impl Default for TurnTime {
    fn default() -> Self {
        Self {
            north_ns: None,
            interval_ns: None,
            seen: [None; DIRECTIONS],
            first_ns: None,
            returns: Vec::with_capacity(RETURNS_MAX),
            returns_in_all: 0,
            turn: None,
        }
    }
}

impl TurnTime {
    /// Turn time, once known; constant afterwards.
    pub fn turn(&self) -> Option<TurnEstimate> {
        self.turn
    }

    /// Returns whether the turn time is still unknown after sufficient data.
    pub fn is_unclear(&self) -> bool {
        self.turn.is_none() && self.returns_in_all > UNCLEAR_RETURNS
    }

    /// The sensor states that a turn takes `turn_ns` nanoseconds.
    pub fn stated(&mut self, turn_ns: i64) {
        self.is(turn_ns, Basis::Stated);
    }

    /// The antenna points north at `time_ns`.
    pub fn north(&mut self, time_ns: i64) {
        let Some(before_ns) = self.north_ns.replace(time_ns) else {
            return;
        };
        let interval_ns = time_ns.saturating_sub(before_ns);
        if interval_ns <= 0 {
            // The same mark again, or a late mark.
            self.north_ns = Some(before_ns);
            return;
        }
        if let Some(other_ns) = self.interval_ns.replace(interval_ns)
            && agree(interval_ns, other_ns)
        {
            self.is(other_ns + (interval_ns - other_ns) / 2, Basis::NorthMarks);
        }
    }

    /// A detection has come.
    pub fn detected(&mut self, detection: &Detection) {
        let Some(bearing_rad) = bearing(detection).filter(|_| self.turn.is_none()) else {
            return;
        };
        let time_ns = detection.time_of_measurement_ns;
        let first_ns = *self.first_ns.get_or_insert(time_ns);
        let direction = (bearing_rad / TAU * DIRECTIONS as f64) as usize % DIRECTIONS;
        let before = self.seen[direction];
        if before.is_some_and(|(before_ns, _)| time_ns < before_ns) {
            return;
        }
        self.seen[direction] = Some((time_ns, bearing_rad));
        let Some((before_ns, before_rad)) = before else {
            return;
        };
        // More than a turn where the detection is further clockwise than the detection before, else less.
        let further = ((bearing_rad - before_rad + PI).rem_euclid(TAU) - PI) / TAU;
        let turn_ns = (time_ns.saturating_sub(before_ns) as f64 / (1.0 + further)) as i64;
        if (TURN_MIN_NS..=TURN_MAX_NS).contains(&turn_ns) {
            self.returned(turn_ns, time_ns.saturating_sub(first_ns));
        }
    }

    /// The antenna has come back to a direction after `turn_ns`, `passed_ns` after the first detection.
    fn returned(&mut self, turn_ns: i64, passed_ns: i64) {
        if self.returns.len() == RETURNS_MAX {
            self.returns.clear();
        }
        self.returns_in_all = self.returns_in_all.saturating_add(1);
        let place = self.returns.partition_point(|other_ns| *other_ns <= turn_ns);
        self.returns.insert(place, turn_ns);
        let short_ns = self.returns[self.returns.len() / 4];
        let begin = self
            .returns
            .partition_point(|other_ns| *other_ns < short_ns && !agree(*other_ns, short_ns));
        let end = self
            .returns
            .partition_point(|other_ns| *other_ns <= short_ns || agree(*other_ns, short_ns));
        let agreeing = &self.returns[begin..end];
        let are_enough = agreeing.len() >= AGREEING_MIN && agreeing.len() * AGREEING_SHARE >= self.returns.len();
        let median_ns = agreeing[agreeing.len() / 2];
        if are_enough && passed_ns > TURNS_BEFORE * median_ns {
            self.is(median_ns, Basis::Detections);
        }
    }

    fn is(&mut self, ns: i64, basis: Basis) {
        if self.turn.is_none() && (TURN_MIN_NS..=TURN_MAX_NS).contains(&ns) {
            self.turn = Some(TurnEstimate { ns, basis });
        }
    }
}

/// Returns whether two times agree as the same turn.
fn agree(one_ns: i64, other_ns: i64) -> bool {
    one_ns.abs_diff(other_ns) as i64 <= one_ns.min(other_ns) / AGREEMENT_PARTS
}

/// Bearing of a detection from the sensor, clockwise from north, 0 to 2π.
fn bearing(detection: &Detection) -> Option<f64> {
    let quantities = detection.kind.quantities();
    let value = |wanted| {
        let place = quantities.iter().position(|quantity| *quantity == wanted)?;
        Some(detection.values[place])
    };
    let [site_east, site_north, _] = detection.platform_m;
    let of_place = || {
        let (east, north) = (value(Quantity::East)?, value(Quantity::North)?);
        Some((east - site_east).atan2(north - site_north))
    };
    let bearing = value(Quantity::Bearing).or_else(of_place)?.rem_euclid(TAU);
    bearing.is_finite().then_some(bearing)
}

#[cfg(test)]
mod tests {
    use test_support::Random;

    use super::*;
    use crate::testing::{S, position};

    /// Detections of an antenna that turns in `turn_s`, for `turns`: targets at these bearings (parts of a turn), each
    /// seen with this probability.
    fn look(turn_s: f64, turns: u32, bearings: &[f64], probability: f64, search: &mut TurnTime) {
        let mut random = Random::new(7);
        let mut bearings = bearings.to_vec();
        bearings.sort_by(f64::total_cmp);
        for turn in 0..turns {
            for bearing in &bearings {
                if random.unit() < probability {
                    let time_ns = ((f64::from(turn) + bearing) * turn_s * 1e9) as i64;
                    let (east, north) = (bearing * TAU).sin_cos();
                    search.detected(&position(time_ns, 50e3 * east, 50e3 * north));
                }
            }
        }
    }

    #[track_caller]
    fn assert_found(search: &TurnTime, turn_s: f64, basis: Basis) {
        let turn = search.turn().expect("found");
        assert_eq!(turn.basis, basis);
        assert!(
            (turn.ns as f64 / 1e9 / turn_s - 1.0).abs() < 0.01,
            "{turn:?} of {turn_s} s"
        );
    }

    #[test]
    fn a_stated_turn_holds_at_once_if_there_is_such_a_turn() {
        let mut search = TurnTime::default();
        search.stated(0);
        search.stated(512 * S);
        assert_eq!(search.turn(), None);
        search.stated(7_625_000_000);
        assert_found(&search, 7.625, Basis::Stated);
        search.stated(4 * S);
        assert_found(&search, 7.625, Basis::Stated);
    }

    #[test]
    fn two_intervals_between_north_marks_that_agree_are_a_turn() {
        let mut search = TurnTime::default();
        // A mark comes twice, and a mark is missing.
        for tenths in [0, 40, 40, 121, 161] {
            search.north(tenths * S / 10);
            assert_eq!(search.turn(), None);
        }
        search.north(20 * S);
        assert_found(&search, 3.95, Basis::NorthMarks);
    }

    #[test]
    fn detections_show_the_turn_of_a_busy_and_of_a_quiet_sky() {
        let busy: Vec<f64> = (0..60).map(|index| (f64::from(index) * 0.618).fract()).collect();
        for (turn_s, bearings, probability) in [
            (1.0, &busy[..], 0.9),
            (4.0, &busy, 0.9),
            (7.63, &busy, 0.5),
            (12.0, &busy, 0.3),
            (12.0, &busy[..3], 0.9),
            (5.0, &busy[..1], 0.8),
        ] {
            let mut search = TurnTime::default();
            look(turn_s, 40, bearings, probability, &mut search);
            assert_found(&search, turn_s, Basis::Detections);
        }
    }

    #[test]
    fn north_marks_come_before_detections() {
        let mut search = TurnTime::default();
        let bearings: Vec<f64> = (0..60).map(|index| f64::from(index) / 60.0).collect();
        look(4.0, 3, &bearings, 1.0, &mut search);
        assert_eq!(search.turn(), None);
        for turn in 0..3 {
            search.north(turn * 4 * S);
        }
        assert_found(&search, 4.0, Basis::NorthMarks);
    }

    #[test]
    fn detections_from_everywhere_at_once_show_no_turn() {
        let mut search = TurnTime::default();
        let mut random = Random::new(3);
        for index in 0..20_000 {
            let (east, north) = (random.unit() * TAU).sin_cos();
            search.detected(&position(index * S / 100, 1e3 * east, 1e3 * north));
        }
        assert_eq!(search.turn(), None);
        assert!(search.is_unclear());
    }
}
