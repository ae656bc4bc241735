//! Positions in compact form (CPR).
//!
//! A position has 17 bits of latitude and 17 of longitude: its place within a zone, of which the globe has many. Even
//! and odd frames have zones of different size, so that a pair of them has one solution on the globe in the air, and
//! four of them on the ground, where the zones are a quarter as large: a reference near by chooses. A single frame has
//! one solution near a reference, at most half a zone away. The method, its names and constants: RTCA DO-260B, A.1.7,
//! and ICAO Doc 9871, C.2.6. Angles are degrees here, as there.

use std::f64::consts::{PI, TAU};

/// Number of latitude zones between equator and pole (NZ).
const ZONES: f64 = 15.0;
/// Values of a coordinate.
const STEPS: f64 = 131_072.0;
/// Radius of the earth, metres: distances here are compared, not measured.
const EARTH_M: f64 = 6_371_000.0;

/// Position as a frame has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CprPosition {
    /// Whether the aircraft is on the ground.
    pub is_surface: bool,
    /// Whether the zones are those of odd frames.
    pub is_odd: bool,
    /// Latitude in its zone, steps of 1/131072 of the zone.
    pub latitude: u32,
    /// Longitude in its zone, steps of 1/131072 of the zone.
    pub longitude: u32,
}

impl CprPosition {
    /// The angle that the zones divide.
    fn span(&self) -> f64 {
        if self.is_surface { 90.0 } else { 360.0 }
    }

    fn parity(&self) -> f64 {
        f64::from(u8::from(self.is_odd))
    }

    fn fractions(&self) -> [f64; 2] {
        [f64::from(self.latitude) / STEPS, f64::from(self.longitude) / STEPS]
    }

    /// Size of the longitude zones at a latitude, degrees.
    fn longitude_zone(&self, zones: f64) -> f64 {
        self.span() / (zones - self.parity()).max(1.0)
    }

    /// Latitude and longitude nearest to a reference; `None` beyond the poles.
    pub fn near(&self, [latitude, longitude]: [f64; 2]) -> Option<[f64; 2]> {
        let [y, x] = self.fractions();
        let nearest = |reference: f64, zone: f64, place: f64| zone * ((reference / zone - place + 0.5).floor() + place);
        let latitude = nearest(latitude, self.span() / (4.0 * ZONES - self.parity()), y);
        let longitude = nearest(longitude, self.longitude_zone(zones(latitude)), x);
        (latitude.abs() <= 90.0).then(|| [latitude, wrapped(longitude)])
    }

    /// Latitude and longitude of this position by its pair of the other parity, on the ground the ones nearest to a
    /// reference; `None` if the two lie in different latitude zones, so that the longitudes do not compare.
    ///
    /// # Panics
    /// In debug builds, if the two have the same parity, or only one is on the ground.
    pub fn with(&self, other: &Self, reference: [f64; 2]) -> Option<[f64; 2]> {
        debug_assert!(self.is_odd != other.is_odd && self.is_surface == other.is_surface);
        let (even, odd) = if self.is_odd { (other, self) } else { (self, other) };
        let ([even_y, even_x], [odd_y, odd_x]) = (even.fractions(), odd.fractions());
        let index = (59.0 * even_y - 60.0 * odd_y + 0.5).floor();
        let latitude_of = |cpr: &Self, place: f64| {
            let count = 4.0 * ZONES - cpr.parity();
            self.span() / count * (index.rem_euclid(count) + place)
        };
        let [even_latitude, odd_latitude] = [latitude_of(even, even_y), latitude_of(odd, odd_y)];
        let own = if self.is_odd { odd_latitude } else { even_latitude };
        let south = match self.is_surface {
            true if (own - reference[0]).abs() > (own - 90.0 - reference[0]).abs() => 90.0,
            false if own >= 270.0 => 360.0,
            _ => 0.0,
        };
        let latitude = own - south;
        let zones_here = zones(latitude);
        // The other half may lie on the other side of the equator, where only one of the two is wrapped.
        let other_latitude = wrapped(even_latitude + odd_latitude - own - south);
        if latitude.abs() > 90.0 || zones(other_latitude) != zones_here {
            return None;
        }
        let index = (even_x * (zones_here - 1.0) - odd_x * zones_here + 0.5).floor();
        let count = (zones_here - self.parity()).max(1.0);
        let longitude = self.longitude_zone(zones_here) * (index.rem_euclid(count) + self.fractions()[1]);
        let quarters = if self.is_surface {
            ((reference[1] - longitude) / 90.0).round()
        } else {
            0.0
        };
        Some([latitude, wrapped(longitude + 90.0 * quarters)])
    }
}

/// Number of longitude zones of even frames at a latitude (NL), 1 to 59.
fn zones(latitude: f64) -> f64 {
    let ratio = (1.0 - (PI / (2.0 * ZONES)).cos()) / latitude.to_radians().cos().powi(2);
    // Beyond 87° the angle does not exist, at the equator it divides the circle into 60.
    match latitude.abs() {
        87.0 => 2.0,
        beyond if beyond > 87.0 => 1.0,
        _ => (TAU / (1.0 - ratio).acos()).floor().min(59.0),
    }
}

/// An angle from -180° up to 180°.
fn wrapped(angle: f64) -> f64 {
    (angle + 180.0).rem_euclid(360.0) - 180.0
}

/// Distance along a great circle, metres.
pub(super) fn distance_m(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [[y0, x0], [y1, x1]] = [from, to].map(|place| place.map(f64::to_radians));
    let haversine = ((y1 - y0) / 2.0).sin().powi(2) + y0.cos() * y1.cos() * ((x1 - x0) / 2.0).sin().powi(2);
    2.0 * EARTH_M * haversine.clamp(0.0, 1.0).sqrt().asin()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Encodes a position by the standard's encoding, A.1.7.2.
    fn encoded([latitude, longitude]: [f64; 2], is_surface: bool, is_odd: bool) -> CprPosition {
        let empty = CprPosition {
            is_surface,
            is_odd,
            latitude: 0,
            longitude: 0,
        };
        let zone = empty.span() / (60.0 - empty.parity());
        let y = (STEPS * latitude.rem_euclid(zone) / zone + 0.5).floor();
        let shown = zone * (y / STEPS + (latitude / zone).floor());
        let zone = empty.longitude_zone(zones(shown));
        let x = (STEPS * longitude.rem_euclid(zone) / zone + 0.5).floor();
        CprPosition {
            latitude: y as u32 % STEPS as u32,
            longitude: x as u32 % STEPS as u32,
            ..empty
        }
    }

    #[test]
    fn zones_change_where_the_standard_has_them() {
        // From the table of DO-260B, A.1.7.2.
        for (latitude, below, above) in [
            (10.470_471_30, 59.0, 58.0),
            (29.911_356_86, 52.0, 51.0),
            (59.954_592_77, 30.0, 29.0),
            (83.071_994_45, 7.0, 6.0),
            (86.535_369_98, 3.0, 2.0),
        ] {
            assert_eq!((zones(latitude - 1e-7), zones(-latitude - 1e-7)), (below, above));
        }
        assert_eq!(
            [0.0, 1e-9, 87.0, -87.0, 87.001, 90.0].map(zones),
            [59.0, 59.0, 2.0, 2.0, 1.0, 1.0]
        );
    }

    proptest! {
        #[test]
        fn decoding_undoes_encoding(
            latitude in -89.9f64..89.9,
            longitude in -180.0f64..180.0,
            is_surface: bool,
            is_odd: bool,
            away in [-0.7f64..0.7, -0.7f64..0.7],
        ) {
            let place = [latitude, longitude];
            let near = [(latitude + away[0]).clamp(-90.0, 90.0), wrapped(longitude + away[1])];
            let [own, other] = [is_odd, !is_odd].map(|odd| encoded(place, is_surface, odd));
            // Steps are 5.1 m, on the ground 1.25 m, of latitude; wider of longitude near the poles.
            let most_m = if is_surface { 3.0 } else { 10.0 };
            let single = own.near(near).unwrap();
            prop_assert!(distance_m(single, place) < most_m, "{single:?}");
            // Where a boundary lies between the rounded latitudes, a pair has no solution.
            if let Some(pair) = own.with(&other, near) {
                prop_assert!(distance_m(pair, place) < most_m, "{pair:?}");
            }
        }

        #[test]
        fn any_bits_give_a_place_on_the_globe(
            bits in [0u32..131_072, 0u32..131_072, 0u32..131_072, 0u32..131_072],
            is_surface: bool,
            is_odd: bool,
            reference in [-90.0f64..90.0, -180.0f64..180.0],
        ) {
            let [latitude, longitude, other_latitude, other_longitude] = bits;
            let own = CprPosition { is_surface, is_odd, latitude, longitude };
            let other = CprPosition { is_odd: !is_odd, latitude: other_latitude, longitude: other_longitude, ..own };
            for [latitude, longitude] in own.near(reference).into_iter().chain(own.with(&other, reference)) {
                prop_assert!(latitude.abs() <= 90.0 && (-180.0..180.0).contains(&longitude));
            }
        }
    }
}
