//! Transmissions that several direction finders hear at the same time.
//!
//! A single finder's number of a track says nothing to the next finder, and a locator needs the bearings of both for
//! one emitter. On a radio channel one station speaks at a time; so what finders hear on a channel at the same time is
//! one transmission. A transmission ends with the report of its end, with a silence of [`SILENCE_MAX_NS`], or when a
//! finder hears it from another direction: then another station answers.
//!
//! # Limits
//!
//! Two stations that are beyond each other's reach may speak at once, each heard by another finder. Their bearings are
//! taken for one transmission, and meet at a wrong place or nowhere.

use std::f64::consts::{PI, SQRT_2, TAU};

use frames::time::NS_PER_S;
use observations::Bearing;

/// Longest silence within a transmission, nanoseconds: some cycles of a finder.
const SILENCE_MAX_NS: u64 = 5 * NS_PER_S.unsigned_abs();
/// Greatest difference of two bearings of a finder within a transmission, in standard deviations of the difference.
const GATE: f64 = 4.0;
/// Most channels that are remembered; the one that has been silent for longest is forgotten.
const CHANNELS_MAX: usize = 64;
/// Most finders of a channel that are remembered.
const FINDERS_MAX: usize = 16;
/// First number of a transmission: above the 16 bits of I205/160.
const FIRST_NUMBER: u32 = 1 << 16;
/// Numbers of transmissions, after which they begin again.
const NUMBERS: u32 = 900_000;

/// A finder: SAC and SIC of the sender, and number of the sensor.
pub(super) type FinderKey = (Option<(u8, u8)>, Option<u8>);

/// Transmissions, by channel.
#[derive(Debug, Default)]
pub(super) struct Transmissions {
    channels: Vec<Channel>,
    begun: u32,
}

/// A channel with its latest transmission.
#[derive(Debug)]
struct Channel {
    name: [u8; 7],
    number: u32,
    latest_ns: i64,
    has_ended: bool,
    /// Latest bearing of each finder, radians.
    bearings_rad: Vec<(FinderKey, f64)>,
}

impl Transmissions {
    /// Number of the transmission on the channel called `name` of which a finder has this bearing.
    pub(super) fn number(&mut self, name: [u8; 7], finder: FinderKey, bearing: &Bearing) -> u32 {
        let place = self.place(name);
        let channel = &mut self.channels[place];
        if !channel.goes_on(finder, bearing) {
            channel.number = FIRST_NUMBER + self.begun % NUMBERS;
            self.begun = self.begun.wrapping_add(1);
            channel.bearings_rad.clear();
            channel.has_ended = false;
        }
        channel.latest_ns = bearing.time_of_measurement_ns;
        let known = channel.bearings_rad.iter().position(|(known, _)| *known == finder);
        match known {
            Some(known) => channel.bearings_rad[known].1 = bearing.bearing_rad,
            None if channel.bearings_rad.len() < FINDERS_MAX => {
                channel.bearings_rad.push((finder, bearing.bearing_rad))
            }
            None => {}
        }
        channel.number
    }

    /// The transmission on a channel has ended.
    pub(super) fn end(&mut self, name: [u8; 7]) {
        let ended = self.channels.iter_mut().find(|channel| channel.name == name);
        ended.into_iter().for_each(|channel| channel.has_ended = true);
    }

    /// Place of the channel in the table.
    fn place(&mut self, name: [u8; 7]) -> usize {
        if let Some(place) = self.channels.iter().position(|channel| channel.name == name) {
            return place;
        }
        if self.channels.len() == CHANNELS_MAX {
            let silent = (0..CHANNELS_MAX).min_by_key(|place| self.channels[*place].latest_ns);
            self.channels.swap_remove(silent.unwrap_or(0));
        }
        self.channels.push(Channel {
            name,
            number: 0,
            latest_ns: 0,
            has_ended: true,
            bearings_rad: Vec::with_capacity(FINDERS_MAX),
        });
        self.channels.len() - 1
    }
}

impl Channel {
    /// Whether a bearing may belong to the latest transmission.
    fn goes_on(&self, finder: FinderKey, bearing: &Bearing) -> bool {
        let is_soon = self.latest_ns.abs_diff(bearing.time_of_measurement_ns) <= SILENCE_MAX_NS;
        let is_from_there = |(_, latest_rad): &(FinderKey, f64)| {
            let turn_rad = (bearing.bearing_rad - latest_rad + PI).rem_euclid(TAU) - PI;
            turn_rad.abs() <= GATE * SQRT_2 * bearing.sigma_rad
        };
        let latest = self.bearings_rad.iter().find(|(known, _)| *known == finder);
        !self.has_ended && is_soon && latest.is_none_or(is_from_there)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEST: FinderKey = (Some((25, 9)), None);
    const EAST: FinderKey = (Some((25, 10)), None);

    fn bearing(second: i64, bearing_deg: f64) -> Bearing {
        Bearing {
            time_of_measurement_ns: second * NS_PER_S,
            emitter_id: None,
            bearing_rad: bearing_deg.to_radians(),
            sigma_rad: 2f64.to_radians(),
            platform_m: [0.0; 3],
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
        }
    }

    #[test]
    fn a_transmission_ends_by_its_report_by_silence_and_by_another_direction() {
        let mut heard = Transmissions::default();
        let mut number = |channel: &[u8; 7], finder, second, degrees| {
            heard.number(*channel, finder, &bearing(second, degrees)) - FIRST_NUMBER
        };
        assert_eq!(number(b"156.800", WEST, 0, 359.0), 0);
        assert_eq!(number(b"156.800", EAST, 1, 300.0), 0, "the same, heard elsewhere");
        assert_eq!(number(b"156.800", WEST, 5, 9.0), 0, "10° off, through north");
        assert_eq!(number(b"156.650", WEST, 5, 9.0), 1, "another channel");
        assert_eq!(number(b"156.800", WEST, 6, 21.0), 2, "12° off: an answer");
        assert_eq!(number(b"156.800", EAST, 6, 200.0), 2, "the answer, heard elsewhere");
        assert_eq!(number(b"156.800", EAST, 12, 200.0), 3, "silence");
        heard.end(*b"156.800");
        heard.end(*b"121.500");
        let next = heard.number(*b"156.800", EAST, &bearing(13, 200.0)) - FIRST_NUMBER;
        assert_eq!(next, 4, "ended");
    }

    #[test]
    fn tables_are_bounded() {
        let mut heard = Transmissions::default();
        for number in 0..1000_u16 {
            let [high, low] = number.to_be_bytes();
            let finder = (Some((high, low)), None);
            heard.number([high, low, 0, 0, 0, 0, 0], finder, &bearing(i64::from(number), 0.0));
            heard.number([0; 7], finder, &bearing(i64::from(number), 0.0));
        }
        assert_eq!(heard.channels.len(), CHANNELS_MAX);
        assert!(
            heard
                .channels
                .iter()
                .all(|channel| channel.bearings_rad.len() <= FINDERS_MAX)
        );
    }
}
