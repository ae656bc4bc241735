//! Positions of one aircraft from its compact ones.
//!
//! A position in compact form is a place within a zone; a wrong zone is wrong by a hundred kilometres and more, and a
//! decoder that finds each position near the last one never leaves a wrong zone. So each position must be in the
//! receiver's range and where the aircraft can have come since the last position. A pair of an even and an odd frame
//! is independent of earlier positions: a pair that contradicts the last position refuses its position, and positions
//! are taken from pairs only, until a pair confirms the last position, or two pairs without a common frame agree on
//! another place. Frames of two aircraft with one address contradict each other and give few positions. A transmission
//! that comes twice, by two receivers, counts once.

use frames::time::NS_PER_S;

use super::cpr::{CprPosition, distance_m};
use super::refusal::ModeSRefusal;

const NM_M: f64 = 1852.0;
/// Longest time between the frames of a pair in the air, nanoseconds.
const AIR_PAIR_NS: i64 = 10 * NS_PER_S;
/// The same on the ground, of slow aircraft, and of others.
const SURFACE_PAIR_NS: [i64; 2] = [50 * NS_PER_S, 25 * NS_PER_S];
/// Speed up to which an aircraft on the ground is slow, metres per second: 25 knots.
const SLOW_MPS: f64 = 25.0 * NM_M / 3600.0;
/// Time for which a place serves as reference, nanoseconds.
pub(super) const PLACE_AGE_MAX_NS: i64 = 600 * NS_PER_S;
/// Distance from the reference up to which a single frame is unambiguous, metres: in the air, on the ground.
const NEAR_M: [f64; 2] = [180.0 * NM_M, 45.0 * NM_M];
/// Speed that no aircraft exceeds, metres per second: in the air, on the ground.
const SPEED_MAX_MPS: [f64; 2] = [1000.0, 150.0];
/// Distance by which places of no motion may differ, metres: in the air, on the ground.
const MARGIN_M: [f64; 2] = [2000.0, 500.0];
/// Shortest time between two transmissions of a position, nanoseconds: less than the least that the standard permits.
const REPEATED_NS: i64 = NS_PER_S / 5;

/// The receiver's place and range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverRange {
    /// Latitude and longitude, degrees.
    pub place_deg: [f64; 2],
    /// Greatest distance of an aircraft from the receiver, metres.
    pub range_m: f64,
}

/// Positions of one aircraft.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PositionDecoder {
    /// Latest even and odd frame.
    halves: [Option<Half>; 2],
    last: Option<Place>,
    /// Place of a pair that contradicts `last`.
    contradiction: Option<Place>,
}

#[derive(Clone, Copy, Debug)]
struct Half {
    cpr: CprPosition,
    time_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    degrees: [f64; 2],
    time_ns: i64,
    is_surface: bool,
}

impl PositionDecoder {
    /// Takes the position of a frame of `time_ns`. Returns latitude and longitude, degrees; `None` where the frame has
    /// to wait for its pair. On the ground, `speed_mps` permits older pairs.
    ///
    /// # Errors
    /// Reason for which the position is refused: [`ModeSRefusal::Repeated`] and those behind it.
    pub(super) fn take(
        &mut self,
        cpr: CprPosition,
        time_ns: i64,
        speed_mps: Option<f64>,
        receiver: Option<&ReceiverRange>,
    ) -> Result<Option<[f64; 2]>, ModeSRefusal> {
        let is_recent = |place: &Place| time_ns.abs_diff(place.time_ns) <= PLACE_AGE_MAX_NS.unsigned_abs();
        self.last = self.last.filter(is_recent);
        self.contradiction = self.contradiction.filter(is_recent);
        let half = Half { cpr, time_ns };
        let before = self.halves[usize::from(cpr.is_odd)].replace(half);
        if before.is_some_and(|before| half.repeats(&before)) {
            return Err(ModeSRefusal::Repeated);
        }
        let pair = self.halves[usize::from(!cpr.is_odd)].filter(|other| half.is_pair(other, speed_mps));
        let by_pair = match pair {
            Some(other) => half.with(&other, self.last, receiver)?.map(|found| (found, other)),
            None => None,
        };
        let found = match by_pair {
            Some((found, other)) => {
                in_range(found.degrees, receiver)?;
                self.judge(found, &other)?;
                self.contradiction = None;
                Some(found)
            }
            None => self.near_last(&half, receiver)?,
        };
        if let Some(found) = found {
            self.last = Some(found);
            return Ok(Some(found.degrees));
        }
        // A frame that waits, or one whose pair has no solution.
        if pair.is_none() {
            Ok(None)
        } else {
            Err(ModeSRefusal::Zone)
        }
    }

    /// Whether the place of a pair with an older half is to be believed.
    fn judge(&mut self, found: Place, older: &Half) -> Result<(), ModeSRefusal> {
        if self.last.is_none_or(|last| found.is_reachable(&last)) {
            return Ok(());
        }
        let agreeing = self.contradiction.filter(|other| found.is_reachable(other));
        if agreeing.is_some_and(|other| older.time_ns > other.time_ns) {
            return Ok(());
        }
        self.contradiction = agreeing.or(Some(found));
        Err(ModeSRefusal::Speed)
    }

    /// Place of a single frame near the last place, unless that is in doubt.
    fn near_last(&self, half: &Half, receiver: Option<&ReceiverRange>) -> Result<Option<Place>, ModeSRefusal> {
        let Some(last) = self.last.filter(|_| self.contradiction.is_none()) else {
            return Ok(None);
        };
        let found = half.near(&last).filter(|found| found.is_reachable(&last));
        let found = found.ok_or(ModeSRefusal::Speed)?;
        in_range(found.degrees, receiver)?;
        Ok(Some(found))
    }
}

impl Half {
    fn is_pair(&self, other: &Self, speed_mps: Option<f64>) -> bool {
        let most_ns = match (self.cpr.is_surface, speed_mps) {
            (false, _) => AIR_PAIR_NS,
            (true, Some(speed_mps)) if speed_mps <= SLOW_MPS => SURFACE_PAIR_NS[0],
            (true, _) => SURFACE_PAIR_NS[1],
        };
        self.cpr.is_surface == other.cpr.is_surface && self.time_ns.abs_diff(other.time_ns) <= most_ns.unsigned_abs()
    }

    /// Whether both frames are one transmission, which two receivers or two ways have passed on.
    fn repeats(&self, before: &Self) -> bool {
        self.cpr == before.cpr && self.time_ns.abs_diff(before.time_ns) < REPEATED_NS.unsigned_abs()
    }

    /// Place by a pair; `None` if the pair has no solution.
    fn with(
        &self,
        other: &Self,
        last: Option<Place>,
        receiver: Option<&ReceiverRange>,
    ) -> Result<Option<Place>, ModeSRefusal> {
        // The receiver's place first: a wrong last place would be confirmed by itself.
        let reference = receiver
            .map(|receiver| receiver.place_deg)
            .or(last.map(|last| last.degrees));
        match reference {
            None if self.cpr.is_surface => Err(ModeSRefusal::Reference),
            reference => Ok(self
                .cpr
                .with(&other.cpr, reference.unwrap_or_default())
                .map(|found| self.at(found))),
        }
    }

    /// Place of the frame alone.
    fn near(&self, last: &Place) -> Option<Place> {
        let found = self.cpr.near(last.degrees)?;
        let most_m = NEAR_M[usize::from(self.cpr.is_surface)];
        (distance_m(found, last.degrees) <= most_m).then(|| self.at(found))
    }

    fn at(&self, degrees: [f64; 2]) -> Place {
        Place {
            degrees,
            time_ns: self.time_ns,
            is_surface: self.cpr.is_surface,
        }
    }
}

impl Place {
    fn is_reachable(&self, from: &Self) -> bool {
        let on_ground = usize::from(self.is_surface && from.is_surface);
        let elapsed_s = frames::time::seconds((self.time_ns - from.time_ns).abs());
        let most_m = MARGIN_M[on_ground] + SPEED_MAX_MPS[on_ground] * elapsed_s;
        distance_m(self.degrees, from.degrees) <= most_m
    }
}

fn in_range(degrees: [f64; 2], receiver: Option<&ReceiverRange>) -> Result<(), ModeSRefusal> {
    let is_within = |receiver: &ReceiverRange| distance_m(degrees, receiver.place_deg) <= receiver.range_m;
    receiver.is_none_or(is_within).then_some(()).ok_or(ModeSRefusal::Range)
}
