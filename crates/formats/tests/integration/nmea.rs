//! Sentences of navigation receivers: values, times, faults by reason.

use formats::nmea::{NmeaCounts, NmeaReader, NmeaSettings};
use platform::Navigation;
use proptest::prelude::*;

const SETTINGS: NmeaSettings = NmeaSettings {
    receipt_sigma_s: 0.05,
    heading_sigma_rad: 0.01,
};
const S: i64 = 1_000_000_000;
/// 1994-03-23.
const DAY_NS: i64 = 8847 * 86_400 * S;

fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, octet| sum ^ octet);
    format!("${body}*{sum:02X}\r\n")
}

fn read(reader: &mut NmeaReader, text: &str, received_ns: Option<i64>) -> Vec<Navigation> {
    let mut states = Vec::new();
    reader.take(text.as_bytes(), received_ns, |state| states.push(state));
    states
}

fn one(text: &str, received_ns: Option<i64>) -> Navigation {
    let states = read(&mut NmeaReader::new(SETTINGS), text, received_ns);
    assert_eq!(states.len(), 1, "{text}");
    states[0]
}

#[test]
fn sentences_of_the_standard_are_read() {
    // As printed in the standard's examples.
    let rmc = one(
        "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n",
        None,
    );
    assert_eq!(rmc.time_ns, DAY_NS + (12 * 3600 + 35 * 60 + 19) * S);
    let place = rmc.place.unwrap();
    assert!((place.latitude_deg() - 48.1173).abs() < 1e-9 && (place.longitude_deg() - 11.516_666_667).abs() < 1e-8);
    let [east, north] = rmc.velocity_mps.unwrap();
    assert!((east.hypot(north) - 22.4 * 1852.0 / 3600.0).abs() < 1e-9);
    assert!((east.atan2(north).to_degrees() - 84.4).abs() < 1e-9);
    let noon_ns = DAY_NS + 43_200 * S;
    let gga = one(
        "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n",
        Some(noon_ns),
    );
    assert_eq!(gga.time_ns, rmc.time_ns);
    assert!(
        (gga.place.unwrap().height_m() - 592.3).abs() < 1e-6,
        "above the ellipsoid"
    );
    let hdt = one("$GPHDT,274.07,T*03\r\n", Some(noon_ns));
    assert_eq!((hdt.time_ns, hdt.heading_rad), (noon_ns, Some(274.07f64.to_radians())));
    assert_eq!(hdt.heading_sigma_rad, Some(0.01));
    let ths = one(&sentence("HETHS,338.01,A"), Some(noon_ns));
    assert_eq!(ths.heading_rad, Some(338.01f64.to_radians()));
    let text = sentence("PASHR,123519.50,312.95,T,-08.25,+01.50,-00.49,0.200,0.300,0.400,2,1");
    let pashr = one(&text, Some(noon_ns));
    assert_eq!(pashr.time_ns, rmc.time_ns + S / 2);
    assert_eq!(pashr.tilt_rad, Some([1.5f64.to_radians(), (-8.25f64).to_radians()]));
    assert_eq!(pashr.tilt_sigmas_rad, Some([0.3f64.to_radians(), 0.2f64.to_radians()]));
    assert_eq!(pashr.heading_sigma_rad, Some(0.4f64.to_radians()));
}

#[test]
fn a_velocity_belongs_to_the_latest_fix() {
    let mut reader = NmeaReader::new(SETTINGS);
    let vtg = sentence("GPVTG,090.0,T,,M,010.0,N,018.5,K,A");
    assert!(read(&mut reader, &vtg, Some(DAY_NS)).is_empty());
    let fix = sentence("GPGGA,000001,4807.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,");
    read(&mut reader, &fix, Some(DAY_NS + S));
    let found = read(&mut reader, &vtg, Some(DAY_NS + S + 1));
    assert_eq!(found[0].time_ns, DAY_NS + S);
    assert!((found[0].velocity_mps.unwrap()[0] - 5.144).abs() < 1e-3);
    assert!(read(&mut reader, &vtg, Some(DAY_NS + 10 * S)).is_empty());
    assert_eq!((reader.counts().no_date, reader.counts().no_fix), (1, 1));
}

#[test]
fn midnight_is_passed_with_and_without_a_time_of_receipt() {
    let gga = |time: &str| sentence(&format!("GPGGA,{time},4807.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,"));
    let (before, after) = (gga("235959.90"), gga("000000.10"));
    // The receipt of the first is already on the next day.
    let received_ns = DAY_NS + 86_400 * S + S / 20;
    let mut reader = NmeaReader::new(SETTINGS);
    let found = read(&mut reader, &(before.clone() + &after), Some(received_ns));
    let times: Vec<_> = found.iter().map(|state| state.time_ns).collect();
    let midnight_ns = DAY_NS + 86_400 * S;
    assert_eq!(times, [midnight_ns - S / 10, midnight_ns + S / 10]);
    // A file has no times of receipt: the date comes with RMC, and without one, no time can be placed.
    let mut reader = NmeaReader::new(SETTINGS);
    let rmc = sentence("GPRMC,235959,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W");
    let found = read(&mut reader, &(before.clone() + &rmc + &before + &after), None);
    let times: Vec<_> = found.iter().map(|state| state.time_ns).collect();
    assert_eq!(times, [midnight_ns - S, midnight_ns - S / 10, midnight_ns + S / 10]);
    assert_eq!(reader.counts().no_date, 1);
}

#[test]
fn a_leap_second_is_the_beginning_of_the_next_day() {
    let mut reader = NmeaReader::new(SETTINGS);
    let leap = sentence("GPGGA,235960.50,4807.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,");
    let found = read(&mut reader, &leap, Some(DAY_NS + 86_400 * S));
    assert_eq!(found[0].time_ns, DAY_NS + 86_400 * S + S / 2);
    assert_eq!(reader.counts().leap_seconds, 1);
}

/// A compass states no time. While the ship turns, the unknown delay is an error of the heading.
#[test]
fn a_heading_in_a_turn_is_less_certain() {
    let mut reader = NmeaReader::new(SETTINGS);
    let hdt = |degrees: f64| sentence(&format!("HEHDT,{degrees:.1},T"));
    let first = read(&mut reader, &hdt(359.0), Some(DAY_NS))[0];
    assert_eq!(first.heading_sigma_rad, Some(0.01));
    let second = read(&mut reader, &hdt(1.0), Some(DAY_NS + S))[0];
    let expected = 0.01f64.hypot(2f64.to_radians() * 0.05);
    assert!((second.heading_sigma_rad.unwrap() - expected).abs() < 1e-12);
}

#[test]
fn faults_are_counted_by_reason() {
    let whole = sentence("HEHDT,100.0,T");
    let wrong = whole.replace("100", "101");
    for (text, expected) in [
        (
            wrong.as_str(),
            NmeaCounts {
                checksum: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            "$HEHDT,100.0,T\r\n",
            NmeaCounts {
                partial: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            "$HEHDT,100.0,T*2\r\n",
            NmeaCounts {
                partial: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            "$HEHDT,1$HEHDT,10\r\n",
            NmeaCounts {
                partial: 2,
                ..NmeaCounts::default()
            },
        ),
        (
            "hello\r\n",
            NmeaCounts {
                no_sentence: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            "$HEHDT,\u{e9}*00\r\n",
            NmeaCounts {
                no_sentence: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("XXHDT,100.0,T"),
            NmeaCounts {
                talker: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("HEROT,1.0,A"),
            NmeaCounts {
                other: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("PTNL,1.0,A"),
            NmeaCounts {
                other: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("HEHDT,400.0,T"),
            NmeaCounts {
                field: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("HEHDT,inf,T"),
            NmeaCounts {
                field: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("HEHDT,,T"),
            NmeaCounts {
                no_fix: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("HETHS,10.0,V"),
            NmeaCounts {
                no_fix: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("GPGGA,123519,,,,,0,00,,,M,,M,,"),
            NmeaCounts {
                no_fix: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("GPRMC,123519,V,,,,,,,230394,,"),
            NmeaCounts {
                no_fix: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("GPGGA,253519,4807.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,"),
            NmeaCounts {
                field: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("GPGGA,123519,9807.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,"),
            NmeaCounts {
                field: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &sentence("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,310294,003.1,W"),
            NmeaCounts {
                field: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            // The count of weeks has wrapped: the date is of another year than the receipt.
            &sentence("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230374,003.1,W"),
            NmeaCounts {
                no_date: 1,
                ..NmeaCounts::default()
            },
        ),
        (
            &format!("${}\r\n", "A".repeat(300)),
            NmeaCounts {
                too_long: 1,
                ..NmeaCounts::default()
            },
        ),
    ] {
        let mut reader = NmeaReader::new(SETTINGS);
        assert!(read(&mut reader, text, Some(DAY_NS)).is_empty(), "{text}");
        assert_eq!(reader.counts(), expected, "{text}");
        // The next sentence is read.
        assert_eq!(read(&mut reader, &whole, Some(DAY_NS)).len(), 1, "{text}");
    }
}

fn stream() -> impl Strategy<Value = Vec<u8>> {
    let whole = prop::sample::select(vec![
        sentence("GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        sentence("GPRMC,235960,A,4807.038,N,01131.000,E,022.4,084.4,311298,003.1,W"),
        sentence("GPVTG,054.7,T,034.4,M,005.5,N,010.2,K"),
        sentence("HEHDT,100.0,T"),
        sentence("PASHR,085335.000,224.19,T,-01.26,+00.83,+00.10,0.101,0.113,0.267,1,0"),
    ]);
    let piece = prop_oneof![
        4 => whole.clone().prop_map(String::into_bytes),
        1 => (whole, 0usize..80).prop_map(|(text, length)| text.into_bytes().into_iter().take(length).collect()),
        1 => prop::collection::vec(any::<u8>(), 0..40),
    ];
    prop::collection::vec(piece, 0..20).prop_map(|pieces| pieces.concat())
}

proptest! {
    /// Wherever the pieces of a stream begin and end, the same states come out, and the same counts.
    #[test]
    fn pieces_do_not_matter(bytes in stream(), cuts in prop::collection::vec(0usize..2000, 0..6)) {
        let mut whole = NmeaReader::new(SETTINGS);
        let mut states = Vec::new();
        whole.take(&bytes, Some(DAY_NS), |state| states.push(state));
        let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(bytes.len())).collect();
        cuts.extend([0, bytes.len()]);
        cuts.sort_unstable();
        let mut pieces = NmeaReader::new(SETTINGS);
        let mut found = Vec::new();
        for pair in cuts.windows(2) {
            pieces.take(&bytes[pair[0]..pair[1]], Some(DAY_NS), |state| found.push(state));
        }
        prop_assert_eq!(found, states);
        prop_assert_eq!(pieces.counts(), whole.counts());
    }

    /// A single wrong byte in a sentence never gives a state with another value.
    #[test]
    fn a_wrong_byte_is_noticed(at in 0usize..20, octet in 0x20u8..0x7f) {
        let text = sentence("HEHDT,123.4,T");
        let mut bytes = text.clone().into_bytes();
        let at = at.min(bytes.len() - 3);
        prop_assume!(bytes[at] != octet);
        // The case of a hexadecimal digit changes nothing.
        prop_assume!(!bytes[at].eq_ignore_ascii_case(&octet));
        bytes[at] = octet;
        let mut reader = NmeaReader::new(SETTINGS);
        let mut states = 0;
        reader.take(&bytes, Some(DAY_NS), |_| states += 1);
        prop_assert_eq!(states, 0);
    }
}
