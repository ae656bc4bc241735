//! Tests of [`RadarTargetReader`].

use frames::{Geodetic, SystemFrame};
use messages::TrackState;
use observations::{Observation, Quality};
use test_support::Dice;

use super::target_counters::RadarTargetRejection as Rejection;
use super::{RadarTargetReader, RadarTargetSettings};

const S: i64 = 1_000_000_000;
/// 2024-06-06 10:00:00 UTC.
const TEN_NS: i64 = 1_717_668_000 * S;
const KNOT_MPS: f64 = 1852.0 / 3600.0;
const OWN_DEG: [f64; 2] = [54.0, 10.5];
const GGA: &str = "$GPGGA,100000.00,5400.0000,N,01030.0000,E,1,08,1.0,20.0,M,,M,,";
const RMC_NORTH_10_KT: &str = "$GPRMC,100000.00,A,5400.0000,N,01030.0000,E,10.0,0.0,060624,,,A";
const HEADING_90: &str = "$HEHDT,90.0,T";

fn summed(sentence: &str) -> String {
    let sum = sentence.bytes().skip(1).fold(0, |sum, octet| sum ^ octet);
    format!("{sentence}*{sum:02X}")
}

fn ashore() -> RadarTargetReader {
    RadarTargetReader::new(RadarTargetSettings {
        place_deg: Some(OWN_DEG),
        ..RadarTargetSettings::default()
    })
}

fn afloat(own: &[&str]) -> RadarTargetReader {
    let mut reader = RadarTargetReader::new(RadarTargetSettings::default());
    for sentence in own {
        assert_eq!(taken(&mut reader, sentence), Ok(None), "{sentence}");
    }
    reader
}

/// Takes a sentence at ten o'clock, with its checksum added.
fn taken(reader: &mut RadarTargetReader, sentence: &str) -> Result<Option<Observation>, Rejection> {
    taken_at(reader, sentence, Some(TEN_NS))
}

fn taken_at(
    reader: &mut RadarTargetReader,
    sentence: &str,
    received_ns: Option<i64>,
) -> Result<Option<Observation>, Rejection> {
    reader
        .take(summed(sentence).as_bytes(), received_ns)
        .map_err(|error| error.rejection)
}

/// Metres towards east and north from own ship.
fn offset_m(observed: &Observation) -> [f64; 2] {
    let place = |[latitude, longitude]: [f64; 2]| Geodetic::from_degrees(latitude, longitude, 0.0).unwrap();
    let found = place(observed.geodetic.unwrap().map(f64::to_degrees));
    let [east, north, _] = SystemFrame::at(place(OWN_DEG)).to_local(found);
    [east, north]
}

fn assert_near(found: [f64; 2], expected: [f64; 2], within: f64) {
    let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
    assert!(off <= within, "{found:?} instead of {expected:?}");
}

#[test]
fn a_true_bearing_and_distance_are_a_place() {
    // 10 NM to the east at 54° N: 10 minutes of arc divided by the cosine of the latitude, on the
    // ellipsoid, whose minute of arc is 1859.4 m there, 16.945'.
    let observed = taken(&mut ashore(), "$RATTM,11,10.0,90.0,T,12.0,180.0,T,,,N,,T,,100001.50,A");
    let observed = observed.unwrap().unwrap();
    let [latitude, longitude] = observed.geodetic.unwrap().map(f64::to_degrees);
    assert!(
        (latitude - 54.0).abs() < 6e-4 && (longitude - (10.5 + 16.945 / 60.0)).abs() < 3e-4,
        "{observed:?}"
    );
    assert_near(offset_m(&observed), [18_520.0, 0.0], 5.0);
    assert_near(observed.velocity.unwrap(), [0.0, -12.0 * KNOT_MPS], 1e-9);
    assert_eq!(
        (observed.track_number, observed.state),
        (Some(11), TrackState::Confirmed)
    );
    assert_eq!(observed.time_of_day_ns, Some(36_001 * S + S / 2));
    // 0.5 % of the range along the line of sight, one degree across it.
    let Quality::Covariance([east, _, north]) = observed.quality else {
        panic!()
    };
    assert!((east.sqrt() - 92.6).abs() < 0.1 && (north.sqrt() - 18_520.0 * 1f64.to_radians()).abs() < 0.2);
}

#[test]
fn a_place_of_its_own_needs_no_ship() {
    let mut reader = RadarTargetReader::new(RadarTargetSettings::default());
    let observed = taken(&mut reader, "$RATLL,01,5400.6000,N,01030.0000,E,BUOY,100000.00,Q,");
    let observed = observed.unwrap().unwrap();
    assert_near(offset_m(&observed), [0.0, 1_113.2], 1.5);
    assert_eq!(
        (observed.state, observed.quality),
        (TrackState::Tentative, Quality::Unstated)
    );
}

#[test]
fn relative_values_are_turned_by_the_heading_and_moved_by_own_velocity() {
    // Own ship goes north with its bow to the east; the target is 30° to starboard of the bow, seen to go astern.
    let mut reader = afloat(&[RMC_NORTH_10_KT, HEADING_90]);
    let observed = taken(&mut reader, "$RATTM,3,2.0,30.0,R,10.0,180.0,R,,,N,,T,,100000.00,M");
    let observed = observed.unwrap().unwrap();
    let azimuth = 120f64.to_radians();
    assert_near(
        offset_m(&observed),
        [3_704.0 * azimuth.sin(), 3_704.0 * azimuth.cos()],
        1.0,
    );
    assert_near(observed.velocity.unwrap(), [-10.0 * KNOT_MPS, 10.0 * KNOT_MPS], 1e-9);
    // Four seconds after the fix, own ship is 20 m further north.
    let later = taken(&mut reader, "$RATTM,4,2.0,90.0,T,,,,,,N,,T,,100004.00,M")
        .unwrap()
        .unwrap();
    assert_near(offset_m(&later), [3_704.0, 40.0 * KNOT_MPS], 1.5);
    assert_eq!(later.velocity, None);
}

#[test]
fn magnetic_headings_serve_with_their_variation_only() {
    let relative = "$RATTM,3,2.0,0.0,R,,,,,,N,,T,,,M";
    let mut reader = afloat(&[GGA, "$HCHDG,87.0,1.0,W,4.0,E"]);
    assert_near(
        offset_m(&taken(&mut reader, relative).unwrap().unwrap()),
        [3_704.0, 0.0],
        1.0,
    );
    let mut reader = afloat(&[GGA, "$HCHDG,87.0,,,,"]);
    assert_eq!(taken(&mut reader, relative), Err(Rejection::OwnHeading));
    // A gyrocompass beside it is the better one.
    let mut reader = afloat(&[GGA, "$HEHDT,0.0,T", "$HCHDG,87.0,,,4.0,E"]);
    assert_near(
        offset_m(&taken(&mut reader, relative).unwrap().unwrap()),
        [0.0, 3_704.0],
        1.0,
    );
    let mut reader = afloat(&["$GPGLL,5400.0000,N,01030.0000,E,100000,A,A", "$HETHS,180.0,A"]);
    assert_near(
        offset_m(&taken(&mut reader, relative).unwrap().unwrap()),
        [0.0, -3_704.0],
        1.0,
    );
}

#[test]
fn what_own_ship_does_not_state_is_named_with_the_remedy() {
    let relative = "$RATTM,3,2.0,30.0,R,10.0,180.0,R,,,N,,T,,,M";
    for (own, rejection, remedy) in [
        (&[HEADING_90][..], Rejection::OwnPlace, "[source.place]"),
        (&[RMC_NORTH_10_KT], Rejection::OwnHeading, "HDT"),
        (&[GGA, HEADING_90], Rejection::OwnVelocity, "VTG"),
    ] {
        let mut reader = afloat(own);
        let line = summed(relative);
        let error = reader.take(line.as_bytes(), Some(TEN_NS)).unwrap_err();
        assert_eq!(error.rejection, rejection);
        assert!(
            error.to_string().contains(remedy) && error.to_string().contains("$RATTM,3"),
            "{error}"
        );
        assert_eq!(reader.counters().rejected(rejection), 1);
    }
    // Values of own ship grow old.
    let mut reader = afloat(&[RMC_NORTH_10_KT, HEADING_90]);
    assert!(taken_at(&mut reader, relative, Some(TEN_NS + 10 * S)).is_ok());
    assert_eq!(
        taken_at(&mut reader, relative, Some(TEN_NS + 11 * S)),
        Err(Rejection::OwnHeading)
    );
    // Nothing has stated a time.
    let mut reader = RadarTargetReader::new(RadarTargetSettings::default());
    let timeless = "$RATLL,01,5400.6000,N,01030.0000,E,,,T,";
    assert_eq!(taken_at(&mut reader, timeless, None), Err(Rejection::NoTime));
}

#[test]
fn a_lost_target_ends_once_and_its_number_is_of_another_one() {
    let mut reader = ashore();
    let tracked = "$RATTM,7,1.0,0.0,T,,,,,,N,,T,,,A";
    let lost = "$RATTM,7,1.0,0.0,T,,,,,,N,,L,,,A";
    assert_eq!(taken(&mut reader, lost), Ok(None), "never seen");
    assert_eq!(taken(&mut reader, tracked).unwrap().unwrap().track_number, Some(7));
    let ended = taken(&mut reader, lost).unwrap().unwrap();
    assert_eq!(
        (ended.track_number, ended.state, ended.geodetic),
        (Some(7), TrackState::Terminated, None)
    );
    assert_eq!(taken(&mut reader, "$RATLL,7,,,,,,,L,"), Ok(None), "stated again");
    assert_eq!(taken(&mut reader, tracked).unwrap().unwrap().track_number, Some(1_007));
    let counted = reader.counters();
    assert_eq!((counted.targets, counted.ended, counted.repeats), (2, 1, 2));
}

#[test]
fn radars_differ_in_talker_and_station() {
    let mut reader = ashore();
    let (first, second) = ("$RATTM,7,1.0,0.0,T,,,,,,N,,T,,,A", "$IITTM,7,1.0,0.0,T,,,,,,N,,T,,,A");
    assert_eq!(taken(&mut reader, first).unwrap().unwrap().track_number, Some(7));
    assert_eq!(
        taken(&mut reader, second).unwrap().unwrap().track_number,
        Some(1_000_007)
    );
    let tag = summed("\\s:RA0002,g:1-1-77");
    let tagged = format!("{tag}\\{}", summed(first));
    let third = reader.take(tagged.as_bytes(), Some(TEN_NS)).unwrap().unwrap();
    assert_eq!(third.track_number, Some(2_000_007));
}

#[test]
fn latitude_and_longitude_beside_a_bearing_are_a_repetition() {
    let mut reader = ashore();
    let (ttm, tll) = (
        "$RATTM,7,1.0,0.0,T,,,,,,N,,T,,,A",
        "$RATLL,07,5401.0000,N,01030.0000,E,,,T,",
    );
    let first = taken(&mut reader, tll).unwrap().unwrap();
    assert!(
        matches!(first.quality, Quality::Covariance(_)),
        "as seen from the place ashore"
    );
    assert!(taken(&mut reader, ttm).unwrap().is_some());
    assert_eq!(taken(&mut reader, tll), Ok(None));
    assert_eq!(reader.counters().repeats, 1);
}

#[test]
fn times_are_of_the_sentence_of_the_line_or_of_receipt() {
    let time_s = |line: &str, received_ns| {
        let observed = ashore().take(line.as_bytes(), received_ns).unwrap().unwrap();
        observed.time_of_day_ns.unwrap() as f64 / S as f64
    };
    let (timed, untimed) = (
        summed("$RATTM,7,1.0,0.0,T,,,,,,N,,T,,095959.75,A"),
        summed("$RATTM,7,1.0,0.0,T,,,,,,N,,T,,,A"),
    );
    assert_eq!(time_s(&timed, Some(TEN_NS)), 35_999.75);
    assert_eq!(time_s(&timed, None), 35_999.75);
    assert_eq!(time_s(&untimed, Some(TEN_NS + S / 2)), 36_000.5);
    assert_eq!(
        time_s(&format!("2024-06-06 10:00:02.5 {untimed}"), Some(TEN_NS)),
        36_002.5
    );
    assert_eq!(time_s(&format!("1717668003 {untimed}"), None), 36_003.0);
    let tag = summed("\\c:1717668004");
    assert_eq!(time_s(&format!("{tag}\\{untimed}"), None), 36_004.0);
}

#[test]
fn midnight_is_passed_without_dates() {
    let mut reader = RadarTargetReader::new(RadarTargetSettings::default());
    let mut times = Vec::new();
    for second in 86_395..86_405 {
        let clock = second % 86_400;
        let text = format!("{:02}{:02}{:02}.00", clock / 3600, clock / 60 % 60, clock % 60);
        let gga = format!("$GPGGA,{text},5400.0000,N,01030.0000,E,1,08,1.0,20.0,M,,M,,");
        assert_eq!(taken_at(&mut reader, &gga, None), Ok(None));
        let ttm = format!("$RATTM,7,1.0,0.0,T,0.0,0.0,R,,,N,,T,,{text},A");
        for sentence in ["$HEHDT,90.0,T", "$GPVTG,0.0,T,,M,10.0,N,18.5,K,A", &ttm] {
            let taken = taken_at(&mut reader, sentence, None).unwrap();
            times.extend(taken.map(|observed| {
                assert_near(offset_m(&observed), [0.0, 1_852.0], 1.0);
                assert_eq!(observed.track_number, Some(7), "the same use of the number");
                observed.time_of_day_ns.unwrap() / S
            }));
        }
    }
    assert_eq!(times, [86_395, 86_396, 86_397, 86_398, 86_399, 0, 1, 2, 3, 4]);
    assert_eq!(reader.counters().first_stated_ns, None);
    assert_eq!(taken_at(&mut reader, RMC_NORTH_10_KT, None), Ok(None));
    assert_eq!(reader.counters().first_stated_ns, Some(TEN_NS));
}

#[test]
fn other_sentences_are_passed_over() {
    let mut reader = ashore();
    for other in [
        "!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C",
        "# a comment",
        "",
        &summed("$SDDBT,,f,10.0,M,,F"),
        "$RARSD,,,,,,,,,2.3,90.0,12,N,H",
    ] {
        assert_eq!(reader.take(other.as_bytes(), Some(TEN_NS)), Ok(None), "{other}");
    }
    assert!(
        taken(&mut reader, "$RATTM,7,1.0,0.0,T,,,,,,N,,T,,,A")
            .unwrap()
            .is_some()
    );
    assert_eq!(reader.counters().others, 5);
}

#[test]
fn damaged_lines_are_counted_and_nothing_panics() {
    let mut dice = Dice::new(7);
    let whole = [
        GGA,
        RMC_NORTH_10_KT,
        HEADING_90,
        "$HCHDG,87.0,1.0,W,4.0,E",
        "$GPGLL,5400.0000,N,01030.0000,E,100000,A,A",
        "$GPVTG,0.0,T,,M,10.0,N,18.5,K,A",
        "$RATTM,3,2.0,30.0,R,10.0,180.0,R,,,N,,T,,100000.00,M",
        "$RATTM,3,2.0,30.0,R,10.0,180.0,R,,,N,,L,,100000.00,M",
        "$RATLL,01,5400.6000,N,01030.0000,E,BUOY,100000.00,Q,",
    ]
    .map(summed);
    let mut reader = RadarTargetReader::new(RadarTargetSettings::default());
    let mut lines = 0;
    for _ in 0..10_000 {
        let mut line = whole[dice.below(whole.len())].clone().into_bytes();
        for _ in 0..dice.below(3) {
            let place = dice.below(line.len());
            match dice.below(5) {
                0 => line[place] ^= 1 << dice.below(8),
                1 => line[place] = dice.bits() as u8,
                2 => line.insert(place, b' ' + dice.below(95) as u8),
                3 => line.extend_from_slice(&whole[dice.below(whole.len())].as_bytes()[..place % 14]),
                _ => line.truncate(place.max(1)),
            }
        }
        let received_ns = (dice.below(10) > 0).then(|| TEN_NS + (dice.below(40) as i64 - 20) * S);
        let _ = reader.take(&line, received_ns);
        lines += 1;
        let counted = reader.counters();
        let used = [
            counted.targets,
            counted.ended,
            counted.without_position,
            counted.repeats,
        ];
        let rest = [counted.own, counted.others, counted.rejected.iter().sum()];
        assert_eq!(used.into_iter().chain(rest).sum::<u64>(), lines);
    }
    let counted = reader.counters();
    assert!(
        counted.targets > 300 && counted.rejected(Rejection::Checksum) > 500,
        "{counted:?}"
    );
}
