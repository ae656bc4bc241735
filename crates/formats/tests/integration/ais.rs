//! Messages of AIS from the literature: values, statements, times, centres of hulls.
//!
//! Expected values are those that the sources print with the sentences (E. S. Raymond, "AIVDM/AIVDO protocol decoding";
//! the tests of `pyais`), else those of `pyais` 3.3.

use formats::ais::{AisOutput, AisReader, AisRejection, AisSettings};
use formats::feed::{Fed, FeedReader, FeedSettings};
use observations::{
    AidKind, Axes, Emergency, FixedStation, NavigationStatus, Observation, Quality, Statement, TargetCategory,
};

const S: i64 = 1_000_000_000;
/// 2020-01-01, 12:00:20.
const RECEIVED_NS: i64 = (1_577_836_800 + 43_220) * S;
const KT: f64 = 1852.0 / 3600.0;
/// A virtual aid to navigation.
const AID: &str = "!AIVDM,1,1,,B,E>lt;MIas0h3V:@;4a::h0b7W005Jh4nq:3l800003v010,4*09";

pub(crate) fn reader() -> AisReader {
    AisReader::new(AisSettings::default())
}

/// All that the lines give, received at `received_ns` on the first connection.
pub(crate) fn outputs(reader: &mut AisReader, lines: &[&str], received_ns: i64) -> Vec<AisOutput> {
    let mut found = Vec::new();
    for line in lines {
        let taken = reader.take(0, line.as_bytes(), received_ns, |_, output| found.push(output));
        taken.unwrap_or_else(|error| panic!("{error}"));
    }
    found
}

pub(crate) fn target(outputs: &[AisOutput]) -> Observation {
    match outputs.first() {
        Some(AisOutput::Target(observation)) => *observation,
        other => panic!("{other:?}"),
    }
}

fn statement(outputs: &[AisOutput]) -> Statement {
    match outputs.last() {
        Some(AisOutput::Statement(statement)) => *statement,
        other => panic!("{other:?}"),
    }
}

/// The only thing that a line gives in a feed: a statement of a station.
fn fixed(line: &str) -> (Statement, FixedStation) {
    let mut found = Vec::new();
    let mut feed = FeedReader::new(FeedSettings::Ais(AisSettings::default()));
    feed.take(line.as_bytes(), Some(RECEIVED_NS), &mut |fed| match fed {
        Fed::Statement(transmission, stated) => {
            assert_eq!(transmission.utc_ns, RECEIVED_NS);
            found.push(*stated);
        }
        Fed::Target(_, target) => panic!("{target:?}"),
        Fed::Refused(reason, _) => panic!("{reason}"),
    });
    assert_eq!((found.len(), feed.counts().records), (1, 1));
    (found[0], found[0].station.unwrap())
}

fn assert_at(position_rad: Option<[f64; 2]>, expected_deg: [f64; 2]) {
    let found = position_rad.unwrap().map(f64::to_degrees);
    let is_near = (0..2).all(|axis| (found[axis] - expected_deg[axis]).abs() < 1e-6);
    assert!(is_near, "{found:?} {expected_deg:?}");
}

/// A sentence with a payload that the library encodes.
pub(crate) fn sentence(message: &aivdm::AisMessage) -> String {
    let mut line = [0; 200];
    let written = aivdm::encode_line(message, aivdm::Channel::A, false, &mut line).unwrap();
    String::from_utf8(written.to_vec()).unwrap()
}

/// The report of a ship of class A in the first sentence, changed.
pub(crate) fn class_a(change: impl FnOnce(&mut aivdm::message::PositionReportClassA)) -> String {
    let payload = b"177KQJ5000G?tO`K>RA1wUbN0TKH";
    let Ok(aivdm::AisMessage::PositionReportClassA(mut report)) = aivdm::decode_payload(payload, 0) else {
        panic!()
    };
    change(&mut report);
    sentence(&aivdm::AisMessage::PositionReportClassA(report))
}

#[test]
fn a_moored_ship_of_class_a() {
    let found = outputs(
        &mut reader(),
        &["!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C"],
        RECEIVED_NS,
    );
    let ship = target(&found);
    assert_at(ship.geodetic, [47.582_833_3, -122.345_833_3]);
    assert_eq!(
        (ship.track_number, ship.identity.mmsi()),
        (Some(477_553_000), Some(477_553_000))
    );
    assert_eq!((ship.velocity, ship.axes), (Some([0.0, 0.0]), Axes::Target));
    assert_eq!(ship.time_of_day_ns, Some(43_215 * S), "its second is 15");
    let Quality::Covariance([east, _, north]) = ship.quality else {
        panic!()
    };
    // 12.3 m of the receiver; the antenna is somewhere along the hull, which lies north and south.
    assert!(
        (east.sqrt() - 12.28).abs() < 0.01 && (north.sqrt() - 41.8).abs() < 0.1,
        "{east} {north}"
    );
    assert!(!ship.test);
    let stated = statement(&found);
    assert_eq!(
        (stated.navigation, stated.track_number),
        (NavigationStatus::Moored, 477_553_000)
    );
    assert_eq!((stated.category, stated.emergency), Default::default());
}

#[test]
fn ships_of_class_b_near_and_far() {
    let found = outputs(
        &mut reader(),
        &["!AIVDM,1,1,,A,B5NJ;PP005l4ot5Isbl03wsUkP06,0*76"],
        RECEIVED_NS,
    );
    assert_eq!(found.len(), 1, "class B states no status");
    assert_at(target(&found).geodetic, [37.785_035, -122.267_32]);
    assert_eq!(target(&found).time_of_day_ns, Some(43_195 * S), "its second is 55");
    let line = "!AIVDM,1,1,,B,C5N3SRgPEnJGEBT>NhWAwwo862PaLELTBJ:V00000000S0D:R220,0*0B";
    let found = outputs(&mut reader(), &[line], RECEIVED_NS);
    let (ship, stated) = (target(&found), statement(&found));
    assert_eq!(ship.identity.name(), Some("CAPT.J.RIMES"));
    assert_eq!(
        (stated.category, stated.size_m),
        (TargetCategory::Cargo, Some([26.0, 8.0]))
    );
    // The antenna at 29.543695 N, 88.810392 W is 8 m ahead of the centre; the course is 335.9°.
    let [north_m, east_m] = [-8.0 * 335.9f64.to_radians().cos(), -8.0 * 335.9f64.to_radians().sin()];
    let per_degree_m = [110_850.0, 96_924.0];
    assert_at(
        ship.geodetic,
        [
            29.543_695 + north_m / per_degree_m[0],
            -88.810_391_7 + east_m / per_degree_m[1],
        ],
    );
    let [east, north] = ship.velocity.unwrap();
    assert!((east.hypot(north) - 8.7 * KT).abs() < 1e-9);
    assert!((east.atan2(north).to_degrees() + 360.0 - 335.9).abs() < 1e-9);
    let found = outputs(
        &mut reader(),
        &["!AIVDM,1,1,,B,KC5E2b@U19PFdLbMuc5=ROv62<7m,0*16"],
        RECEIVED_NS,
    );
    let ship = target(&found);
    assert_at(ship.geodetic, [4.84, 137.023_333_3]);
    assert_eq!(ship.time_of_day_ns, Some(43_220 * S), "that of receipt");
    let Quality::Covariance([east, _, north]) = ship.quality else {
        panic!()
    };
    // 53.5 m of the grid, 12.3 m of the receiver, and 40 m along a course of 167°.
    assert!((north.sqrt() - 67.29).abs() < 0.01 && east < north, "{east} {north}");
    assert_eq!(statement(&found).navigation, NavigationStatus::NotUnderCommand);
}

#[test]
fn a_rescue_aircraft_states_its_height() {
    let found = outputs(
        &mut reader(),
        &["!AIVDM,1,1,,B,91b55wi;hbOS@OdQAC062Ch2089h,0*30"],
        RECEIVED_NS,
    );
    let aircraft = target(&found);
    assert_at(aircraft.geodetic, [58.144, -6.278_843_3]);
    assert_eq!(
        (aircraft.geometric_height_m, aircraft.pressure_altitude_m),
        (Some(303.0), None)
    );
    let [east, north] = aircraft.velocity.unwrap();
    assert!((east.hypot(north) - 42.0 * KT).abs() < 1e-9, "whole knots");
    assert_eq!(statement(&found).category, TargetCategory::Rescue);
}

#[test]
fn static_data_name_the_reports_after_them() {
    let mut reader = reader();
    let static_data = [
        "!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C",
        "!AIVDM,2,2,1,A,88888888880,2*25",
    ];
    let found = outputs(&mut reader, &static_data, RECEIVED_NS);
    let stated = statement(&found);
    assert_eq!(
        (stated.track_number, stated.category),
        (351_759_000, TargetCategory::Cargo)
    );
    assert_eq!((stated.size_m, found.len()), (Some([295.0, 32.0]), 1));
    let report = |heading: u16, speed: u16, second: u8| {
        class_a(|report| {
            report.mmsi = aivdm::Mmsi::from_raw(351_759_000);
            report.latitude = aivdm::Latitude::from_raw(0);
            report.longitude = aivdm::Longitude::from_raw(0);
            report.heading = aivdm::Heading::from_raw(heading);
            report.sog = aivdm::Sog::from_raw(speed);
            report.cog = aivdm::Cog::from_raw(1800);
            report.timestamp = aivdm::Timestamp::Second(second);
        })
    };
    // The centre is 77.5 m ahead of the antenna and 15 m to starboard.
    for (line, [north_m, east_m]) in [
        (report(0, 0, 1), [77.5, 15.0]),
        (report(90, 0, 2), [-15.0, 77.5]),
        (report(511, 21, 3), [-77.5, -15.0]),
        (report(511, 20, 4), [0.0, 0.0]),
    ] {
        let ship = target(&outputs(&mut reader, &[&line], RECEIVED_NS));
        assert_eq!(
            (ship.identity.name(), ship.identity.callsign()),
            (Some("EVER DIADEM"), Some("3FOF8"))
        );
        assert_at(ship.geodetic, [north_m / 110_574.0, east_m / 111_320.0]);
    }
    let late = target(&outputs(&mut reader, &[&report(0, 0, 5)], RECEIVED_NS + 1801 * S));
    assert_eq!(late.identity.name(), None, "static data age");
}

#[test]
fn static_data_of_class_b_come_in_two_messages() {
    let mut reader = reader();
    let found = outputs(
        &mut reader,
        &[
            "!AIVDM,1,1,,A,H42O55i18tMET00000000000000,2*6D",
            "!AIVDM,1,1,,A,H42O55lt0000000D3nink000?0500,0*70",
        ],
        RECEIVED_NS,
    );
    assert_eq!(found.len(), 1, "a name alone is no statement");
    assert_eq!(
        (statement(&found).category, statement(&found).size_m),
        (TargetCategory::Passenger, Some([15.0, 5.0]))
    );
    let line = class_a(|report| report.mmsi = aivdm::Mmsi::from_raw(271_041_815));
    let ship = target(&outputs(&mut reader, &[&line], RECEIVED_NS));
    assert_eq!(
        (ship.identity.name(), ship.identity.callsign()),
        (Some("PROGUY"), Some("TC6163"))
    );
    // Bow and port at 0: the antenna's place is not stated.
    assert_at(ship.geodetic, [47.582_833_3, -122.345_833_3]);
}

#[test]
fn stations_that_are_no_targets_state_their_places_and_are_not_observed() {
    let (stated, base) = fixed("!AIVDM,1,1,,A,403OviQuMGCqWrRO9>E6fE700@GO,0*4D");
    assert_eq!(
        (stated.category, stated.track_number),
        (TargetCategory::BaseStation, 3_669_702)
    );
    assert_eq!((base.aid, base.name), (AidKind::Unknown, [b' '; 20]));
    assert_at(Some(base.place_rad), [36.883_766_7, -76.352_361_7]);
    let (stated, aid) = fixed(AID);
    assert_eq!(
        (stated.category, &aid.name),
        (TargetCategory::Aid, b"S6A GLT VIRTU ATON  ")
    );
    assert_eq!(
        (aid.aid, aid.is_virtual, aid.is_off_position),
        (AidKind::SpecialBeacon, true, false)
    );
    assert_at(Some(aid.place_rad), [-23.917_385, 151.497_903_3]);
}

#[test]
fn an_aid_is_off_its_position_where_its_receiver_works() {
    let sent = |change: fn(&mut aivdm::message::AidToNavigationReport)| {
        let Ok(aivdm::AisMessage::AidToNavigationReport(mut aid)) =
            aivdm::decode_payload(AID.split(',').nth(5).unwrap().as_bytes(), 4)
        else {
            panic!("no aid");
        };
        (aid.off_position, aid.virtual_aid) = (true, false);
        change(&mut aid);
        fixed(&sentence(&aivdm::AisMessage::AidToNavigationReport(aid)))
    };
    let (_, aid) = sent(|aid| aid.timestamp = aivdm::Timestamp::Second(7));
    assert!(aid.is_off_position && !aid.is_virtual);
    let (_, aid) = sent(|aid| aid.timestamp = aivdm::Timestamp::Inoperative);
    assert!(!aid.is_off_position);
    let (stated, _) = sent(|aid| {
        (aid.dimension_to_bow, aid.dimension_to_stern) = (3, 3);
        (aid.dimension_to_port, aid.dimension_to_starboard) = (2, 2);
    });
    assert_eq!(stated.size_m, Some([6.0, 4.0]));
}

#[test]
fn devices_in_distress_state_it_unless_they_are_tested() {
    const ACTIVE: &str = "!AIVDM,1,1,,A,1>M4nfNP03OrAjPLqGH0I?vuP000,0*14";
    const TESTED: &str = "!AIVDM,1,1,,A,1>M4nfOP03OrAjPLqGH0I?vuP000,0*15";
    const TEST_TEXT: &str = "!AIVDM,1,1,,A,>>M4nfA<59B1@E=@,2*2F";
    let emergency = |lines: &[&str]| {
        let found = outputs(&mut reader(), lines, RECEIVED_NS);
        let (device, stated) = (target(&found), statement(&found));
        assert_eq!(stated.category, TargetCategory::RescueTransmitter);
        assert_eq!(device.alerts.stated, messages::alert_bits::EMERGENCY);
        assert_eq!(device.alerts.raised != 0, stated.emergency == Emergency::Distress);
        (stated.emergency, stated.navigation, device.test)
    };
    assert_eq!(
        emergency(&[ACTIVE]),
        (Emergency::Distress, NavigationStatus::Rescue, false)
    );
    assert_eq!(emergency(&[TESTED]), (Emergency::None, NavigationStatus::Unknown, true));
    assert_eq!(
        emergency(&[TEST_TEXT, ACTIVE]),
        (Emergency::None, NavigationStatus::Rescue, true)
    );
    // Without a position, the distress is stated all the same.
    let lost = |mmsi: u32| {
        class_a(|report| {
            report.mmsi = aivdm::Mmsi::from_raw(mmsi);
            report.navigation_status = aivdm::NavigationStatus::AisSartMobEpirb;
            report.latitude = aivdm::Latitude::from_raw(91 * 600_000);
        })
    };
    for (mmsi, category, emergency) in [
        (972_000_001, TargetCategory::ManOverboard, Emergency::Distress),
        (974_000_001, TargetCategory::RescueBeacon, Emergency::Distress),
        (211_000_001, TargetCategory::Unknown, Emergency::Unknown),
    ] {
        let mut reader = reader();
        let found = outputs(&mut reader, &[&lost(mmsi)], RECEIVED_NS);
        assert_eq!(
            (statement(&found).category, statement(&found).emergency),
            (category, emergency)
        );
        assert_eq!((found.len(), reader.counters().without_position), (1, 1));
    }
}

#[test]
fn values_that_are_not_available_are_unknown() {
    let line = class_a(|report| {
        report.sog = aivdm::Sog::from_raw(1023);
        report.timestamp = aivdm::Timestamp::DeadReckoning;
        report.navigation_status = aivdm::NavigationStatus::NotDefined;
    });
    let found = outputs(&mut reader(), &[&line], RECEIVED_NS);
    let ship = target(&found);
    assert_eq!((ship.velocity, ship.quality, found.len()), (None, Quality::Unknown, 1));
    assert_eq!(ship.time_of_day_ns, Some(43_220 * S));
    for (speed, course, velocity) in [
        (1, 3600, Some([0.0, 0.0])),
        (2, 3600, None),
        (1022, 0, None),
        (100, 900, Some([10.0 * KT, 0.0])),
    ] {
        let line = class_a(|report| {
            report.sog = aivdm::Sog::from_raw(speed);
            report.cog = aivdm::Cog::from_raw(course);
        });
        let found = target(&outputs(&mut reader(), &[&line], RECEIVED_NS)).velocity;
        let same = |[one, other]: [[f64; 2]; 2]| (one[0] - other[0]).hypot(one[1] - other[1]) < 1e-9;
        assert!(
            found == velocity || found.zip(velocity).is_some_and(|(a, b)| same([a, b])),
            "{speed} {found:?}"
        );
    }
}

#[test]
fn a_second_is_that_of_the_latest_minute_that_it_fits() {
    // The received second of the day, the stated second of the minute, the time of measurement.
    for (received_ms, second, measured_ms) in [
        (43_220_000, 20, 43_220_000),
        (43_220_500, 20, 43_220_000),
        (43_220_000, 22, 43_222_000),
        (43_220_000, 23, 43_220_000),
        (43_220_000, 50, 43_190_000),
        (43_220_000, 49, 43_220_000),
        (1_000, 59, 86_399_000),
        (86_399_000, 0, 0),
    ] {
        let line = class_a(|report| report.timestamp = aivdm::Timestamp::Second(second));
        let received_ns = 20_000 * 86_400 * S + received_ms * 1_000_000;
        let found = target(&outputs(&mut reader(), &[&line], received_ns));
        assert_eq!(
            found.time_of_day_ns,
            Some(measured_ms * 1_000_000),
            "{received_ms} {second}"
        );
    }
}

#[test]
fn own_ship_is_apart_and_impossible_numbers_are_refused() {
    let line = class_a(|_| {}).replace("VDM", "VDO");
    let sum = line[1..line.len() - 3].bytes().fold(0, |sum, octet| sum ^ octet);
    let line = format!("{}*{sum:02X}", &line[..line.len() - 3]);
    let found = outputs(&mut reader(), &[&line], RECEIVED_NS);
    assert!(matches!(found[0], AisOutput::OwnShip(_)), "{found:?}");
    for mmsi in [0, 1_193_046, 1_000_000_000] {
        let line = class_a(|report| report.mmsi = aivdm::Mmsi::from_raw(mmsi));
        let error = reader()
            .take(0, line.as_bytes(), 0, |_, _| panic!())
            .unwrap_err()
            .rejection;
        assert_eq!(error, AisRejection::Mmsi);
    }
}
