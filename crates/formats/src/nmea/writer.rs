//! States of a platform as sentences: what a simulated navigation sends.
//!
//! GGA gives the place with its height above the ellipsoid, RMC the velocity, PASHR the attitude with standard
//! deviations. Numbers have more decimals than devices give, so that a simulated error is the only error.

use std::fmt::Write as _;

use platform::Navigation;

use super::fields::KNOT_MPS;

const NS_PER_S: i64 = 1_000_000_000;
const S_PER_DAY: i64 = 86_400;

/// Appends the sentences of a state that has a place; each ends with a line end.
pub fn write_sentences(navigation: &Navigation, out: &mut String) {
    let second = navigation.time_ns.div_euclid(NS_PER_S);
    let (day, second) = (second.div_euclid(S_PER_DAY), second.rem_euclid(S_PER_DAY));
    let part_ns = navigation.time_ns.rem_euclid(NS_PER_S);
    let time = format!(
        "{:02}{:02}{:02}.{part_ns:09}",
        second / 3600,
        second / 60 % 60,
        second % 60
    );
    let Some(place) = navigation.place else { return };
    let latitude = coordinate(place.latitude_deg(), 2, ["N", "S"]);
    let longitude = coordinate(place.longitude_deg(), 3, ["E", "W"]);
    let height_m = place.height_m();
    framed(
        &format!("GPGGA,{time},{latitude},{longitude},1,12,0.8,{height_m:.4},M,0.0,M,,"),
        out,
    );
    if let Some([east, north]) = navigation.velocity_mps {
        let knots = east.hypot(north) / KNOT_MPS;
        let course = east.atan2(north).to_degrees().rem_euclid(360.0);
        let date = date(day);
        framed(
            &format!("GPRMC,{time},A,{latitude},{longitude},{knots:.6},{course:.6},{date},,,A"),
            out,
        );
    }
    let heading = navigation.heading_rad.map(|angle| angle.to_degrees().rem_euclid(360.0));
    let [pitch, roll] = degrees(navigation.tilt_rad);
    let [pitch_sigma, roll_sigma] = degrees(navigation.tilt_sigmas_rad);
    let heading_sigma = number(navigation.heading_sigma_rad.map(f64::to_degrees));
    let heading = number(heading);
    framed(
        &format!("PASHR,{time},{heading},T,{roll},{pitch},0.0,{roll_sigma},{pitch_sigma},{heading_sigma},1,1"),
        out,
    );
}

fn framed(text: &str, out: &mut String) {
    let sum = text.bytes().fold(0, |sum, octet| sum ^ octet);
    // Writing into memory does not fail.
    let _ = write!(out, "${text}*{sum:02X}\r\n");
}

fn degrees(angles: Option<[f64; 2]>) -> [String; 2] {
    let each = |place: usize| number(angles.map(|angles| angles[place].to_degrees()));
    [each(0), each(1)]
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:.6}"))
}

/// Degrees, minutes and hemisphere.
fn coordinate(degrees: f64, whole: usize, [plus, minus]: [&str; 2]) -> String {
    let side = if degrees < 0.0 { minus } else { plus };
    // Rounded as a whole, so that no 60 minutes are written.
    let minutes = (degrees.abs() * 60.0 * 1e8).round() / 1e8;
    let full = (minutes / 60.0).floor();
    let rest = minutes - 60.0 * full;
    format!("{full:0whole$.0}{rest:011.8},{side}")
}

/// Day, month and year of a day since 1970 (H. Hinnant, "chrono-compatible low-level date algorithms").
fn date(days: i64) -> String {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year + era * 400 + i64::from(month <= 2);
    format!("{day:02}{month:02}{:02}", year % 100)
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;
    use proptest::prelude::*;

    use super::*;
    use crate::nmea::{NmeaReader, NmeaSettings};

    proptest! {
        /// What is written is read back: the parts of one time together are the state.
        #[test]
        fn sentences_read_back(
            // Dates of sentences have two digits of the year: 1980 to 2079.
            time_ns in 315_532_800_000_000_000i64..3_471_292_800_000_000_000,
            (latitude, longitude, height_m) in (-89.0f64..89.0, -179.9f64..179.9, -100f64..9000.0),
            (east, north) in (-30f64..30.0, -30f64..30.0),
            (heading, pitch, roll) in (0f64..6.0, -1f64..1.0, -1f64..1.0),
            sigma in 1e-4f64..0.1,
        ) {
            let navigation = Navigation {
                time_ns,
                place: Some(Geodetic::from_degrees(latitude, longitude, height_m).unwrap()),
                velocity_mps: Some([east, north]),
                heading_rad: Some(heading),
                tilt_rad: Some([pitch, roll]),
                heading_sigma_rad: Some(sigma),
                tilt_sigmas_rad: Some([sigma, 2.0 * sigma]),
            };
            let mut text = String::new();
            write_sentences(&navigation, &mut text);
            let settings = NmeaSettings { receipt_sigma_s: 0.0, heading_sigma_rad: 1.0 };
            let (mut reader, mut read) = (NmeaReader::new(settings), Vec::new());
            reader.take(text.as_bytes(), Some(time_ns + 1000), |state| read.push(state));
            prop_assert_eq!((read.len(), reader.counts().refused()), (3, 0), "{}", text);
            prop_assert!(read.iter().all(|state| state.time_ns == time_ns), "{}", text);
            let place = read[0].place.unwrap();
            prop_assert!((place.latitude_deg() - latitude).abs() < 1e-9);
            prop_assert!((place.longitude_deg() - longitude).abs() < 1e-9);
            prop_assert!((place.height_m() - height_m).abs() < 1e-3);
            let [e, n] = read[1].velocity_mps.unwrap();
            prop_assert!((e - east).hypot(n - north) < 1e-5);
            prop_assert!((read[2].heading_rad.unwrap() - heading).abs() < 1e-7);
            let [p, r] = read[2].tilt_rad.unwrap();
            prop_assert!((p - pitch).hypot(r - roll) < 1e-7);
            let [p, r] = read[2].tilt_sigmas_rad.unwrap();
            prop_assert!((p - sigma).hypot(r - 2.0 * sigma) < 1e-7);
            prop_assert!((read[2].heading_sigma_rad.unwrap() - sigma).abs() < 1e-7);
        }
    }
}
