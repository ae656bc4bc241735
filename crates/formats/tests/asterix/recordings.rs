//! Whole recordings of an airport's sensors and of an en-route radar: known totals, and the two ways of decoding
//! compared on every record.

use std::collections::BTreeSet;

use asterix::categories::CAT021_V0_23;
use asterix::typed::fields::{Availability, Callsign};
use asterix::typed::{cat010, cat019, cat020, cat021_v0, cat021_v2, cat034, cat048, cat062, cat065};
use asterix::{Counts, Decoder, Mode, NamedRecord, Record, Value};

use crate::agreement;
use crate::files::recording;

const BARCELONA: &str = "lebl2016/160510-lebl-220001";

/// Every record, decoded in both ways; what was counted; and how many values both ways have.
fn for_each(bytes: &[u8], see: impl FnMut(&Record<'_>)) -> (Counts, usize) {
    for_each_with(Decoder::new(Mode::Lenient), bytes, see)
}

fn for_each_with(mut decoder: Decoder, bytes: &[u8], mut see: impl FnMut(&Record<'_>)) -> (Counts, usize) {
    let mut compared = 0;
    for record in decoder.records(bytes) {
        let record = record.unwrap();
        compared += agreement::check(&record);
        see(&record);
    }
    (*decoder.counts(), compared)
}

fn counts(records: u64) -> Counts {
    Counts {
        blocks: records,
        records,
        ..Counts::default()
    }
}

#[test]
fn surface_movement_radar() {
    let Some(bytes) = recording(&format!("{BARCELONA}_SMR_cat10.ast")) else {
        return;
    };
    let (mut reports, mut cycles, mut states) = (0, 0, 0);
    let mut tracks = BTreeSet::new();
    let (counted, compared) = for_each(&bytes, |record| {
        if let Some(report) = cat010::TargetReport::read(record) {
            reports += 1;
            tracks.extend(report.track_number);
            let ended = report.track_status.unwrap().ended;
            assert_eq!(report.polar_position.is_none(), ended, "a last report has no position");
        }
        if let Some(message) = cat010::ServiceMessage::read(record) {
            match message.message_type {
                cat010::MessageType::StartOfUpdateCycle => cycles += 1,
                cat010::MessageType::PeriodicStatus => states += 1,
                other => panic!("{other:?}"),
            }
        }
    });
    assert_eq!(counted, counts(77_345));
    assert_eq!((reports, cycles, states, tracks.len()), (62_819, 7263, 7263, 730));
    assert!(compared > 1_000_000, "{compared}");
}

#[test]
fn multilateration_as_category_010() {
    let Some(bytes) = recording(&format!("{BARCELONA}_MLAT_cat10.ast")) else {
        return;
    };
    let (mut reports, mut monitors, mut services) = (0, 0, 0);
    let (mut addresses, mut monitor_addresses) = (BTreeSet::new(), BTreeSet::new());
    let (counted, compared) = for_each(&bytes, |record| {
        if let Some(report) = cat010::TargetReport::read(record) {
            reports += 1;
            if report.descriptor.unwrap().field_monitor {
                monitors += 1;
                monitor_addresses.extend(report.address);
            } else {
                addresses.extend(report.address);
            }
        }
        services += usize::from(cat010::ServiceMessage::read(record).is_some());
    });
    assert_eq!(counted, counts(84_453));
    assert_eq!((reports, monitors, services), (69_933, 41_548, 14_520));
    assert_eq!((addresses.len(), monitor_addresses.len()), (31, 6));
    assert!(compared > 1_000_000, "{compared}");
}

#[test]
fn multilateration_as_category_020() {
    let Some(bytes) = recording(&format!("{BARCELONA}_MLAT_cat20.ast")) else {
        return;
    };
    let (mut reports, mut monitors, mut cycles, mut states) = (0, 0, 0, 0);
    let (mut addresses, mut monitor_addresses) = (BTreeSet::new(), BTreeSet::new());
    let (counted, compared) = for_each(&bytes, |record| {
        if let Some(report) = cat020::TargetReport::read(record) {
            reports += 1;
            if report.descriptor.unwrap().field_monitor {
                monitors += 1;
                monitor_addresses.extend(report.address);
            } else {
                addresses.extend(report.address);
            }
            assert!(report.contributing_devices.unwrap() >= 3);
        }
        match cat019::ServiceMessage::read(record).and_then(|message| message.message_type) {
            Some(cat019::MessageType::StartOfUpdateCycle) => cycles += 1,
            Some(cat019::MessageType::PeriodicStatus) => {
                states += 1;
                check_system_state(record);
            }
            Some(other) => panic!("{other:?}"),
            None => {}
        }
    });
    // 121 status messages go on in I019/553 where ed 1.3 ends: three octets for the six transponders of this system.
    let expected = Counts {
        records_extended: 121,
        unknown_extension_octets: 121,
        ..counts(77_314)
    };
    assert_eq!(counted, expected);
    assert_eq!((reports, monitors, cycles, states), (69_933, 41_548, 7260, 121));
    assert_eq!((addresses.len(), monitor_addresses.len()), (31, 6));
    assert!(compared > 1_000_000, "{compared}");
}

fn check_system_state(record: &Record<'_>) {
    let message = cat019::ServiceMessage::read(record).unwrap();
    assert_eq!(message.system_status.unwrap().availability, Availability::Operational);
    let reference = message.reference_position.unwrap();
    assert!((reference.latitude_rad.to_degrees() - 41.297_079).abs() < 1e-6);
    assert!((reference.longitude_rad.to_degrees() - 2.078_463).abs() < 1e-6);
    assert_eq!(
        (message.reference_height_m, message.undulation_m),
        (Some(51.0), Some(0.0))
    );
    let named = NamedRecord::new(record);
    let beyond = named.get(&["553", asterix::named::UNKNOWN_EXTENSION]);
    assert_eq!(beyond, Some(&Value::Bytes(vec![0xCC])));
}

#[test]
fn both_categories_of_the_multilateration_give_the_same_reports() {
    let (Some(cat10), Some(cat20)) = (
        recording(&format!("{BARCELONA}_MLAT_cat10.ast")),
        recording(&format!("{BARCELONA}_MLAT_cat20.ast")),
    ) else {
        return;
    };
    let (mut decoder_10, mut decoder_20) = (Decoder::new(Mode::Lenient), Decoder::new(Mode::Lenient));
    let reports_10 = decoder_10
        .records(&cat10)
        .flatten()
        .filter_map(|r| cat010::TargetReport::read(&r));
    let reports_20 = decoder_20
        .records(&cat20)
        .flatten()
        .filter_map(|r| cat020::TargetReport::read(&r));
    let (mut pairs, mut saturated) = (0, 0);
    for (ours, theirs) in reports_10.zip(reports_20) {
        assert_eq!((ours.time_of_day, ours.address), (theirs.time_of_day, theirs.address));
        let (velocity_10, velocity_20) = (ours.cartesian_velocity.unwrap(), theirs.cartesian_velocity.unwrap());
        assert_eq!(velocity_10, velocity_20, "I010/202 has the LSB of I020/202");
        let (at_10, at_20) = (ours.cartesian_position.unwrap(), theirs.cartesian_position.unwrap());
        // I010/042 has 16 bits of 1 m, I020/042 24 bits of 0.5 m: rounded, and beyond 32,767 m saturated.
        let as_sent_in_010 = |metres: f64| metres.clamp(-32_768.0, 32_767.0);
        assert!((at_10.x_m - as_sent_in_010(at_20.x_m)).abs() <= 0.5);
        assert!((at_10.y_m - as_sent_in_010(at_20.y_m)).abs() <= 0.5);
        saturated += usize::from(at_20.x_m > 32_767.0);
        assert_eq!(
            (ours.mode_3a, ours.identification),
            (theirs.mode_3a, theirs.identification)
        );
        pairs += 1;
    }
    assert_eq!((pairs, saturated), (69_933, 13));
}

#[test]
fn ads_b() {
    let Some(bytes) = recording(&format!("{BARCELONA}_ADSB_cat21_v023.ast")) else {
        return;
    };
    let mut addresses = BTreeSet::new();
    let mut callsigns = BTreeSet::<Callsign>::new();
    let mut without_callsign = 0;
    let decoder = Decoder::new(Mode::Lenient).with_table(&CAT021_V0_23); // not the category's default
    let (counted, compared) = for_each_with(decoder, &bytes, |record| {
        let report = cat021_v0::TargetReport::read(record).unwrap();
        addresses.extend(report.address);
        callsigns.extend(report.callsign);
        let sent = record.item(cat021_v0::item::CALLSIGN);
        without_callsign += usize::from(sent.is_some() && report.callsign.is_none());
    });
    assert_eq!(counted, counts(49_330));
    assert_eq!((addresses.len(), without_callsign), (47, 5891));
    assert!(callsigns.iter().any(|callsign| callsign.as_str() == "IBK3ZR"));
    assert!(compared > 1_000_000, "{compared}");
}

#[test]
fn en_route_radar() {
    let Some(bytes) = recording("akapetanovic/Jahorina.raw") else {
        return;
    };
    let (mut plots, mut north_markers, mut registers) = (0, 0, 0);
    let mut addresses = BTreeSet::new();
    let (mut first_s, mut last_s) = (f64::INFINITY, f64::NEG_INFINITY);
    let (counted, compared) = for_each(&bytes, |record| {
        let named = NamedRecord::new(record);
        assert_eq!(named.get(&["010", "SAC"]), Some(&Value::Unsigned(23)));
        assert_eq!(named.get(&["010", "SIC"]), Some(&Value::Unsigned(2)));
        let time = if named.category == 48 { "140" } else { "030" };
        let time_s = named.get(&[time]).and_then(Value::as_f64).unwrap();
        (first_s, last_s) = (first_s.min(time_s), last_s.max(time_s));
        if named.category == 48 {
            plots += 1;
            if let Some(Value::Unsigned(address)) = named.get(&["220"]) {
                addresses.insert(*address);
            }
            let range_nm = named.get(&["040", "RHO"]).and_then(Value::as_f64).unwrap();
            assert!((5.0..200.0).contains(&range_nm), "{range_nm} NM");
            registers += cat048::registers(record).count();
        } else {
            let message = cat034::ServiceMessage::read(record).unwrap();
            assert_eq!(message.message_type, Some(cat034::MessageType::NorthMarker));
            assert_eq!(message.antenna_period_s, Some(5.007_812_5));
            north_markers += 1;
        }
    });
    let expected = Counts {
        blocks: 642,
        ..counts(2119)
    };
    assert_eq!(counted, expected);
    assert_eq!((plots, north_markers, addresses.len()), (2099, 20, 106));
    assert!(registers > 1000 && compared > 40_000, "{registers}, {compared}");
    assert_eq!((first_s, last_s), (33_932.195_312_5, 34_012.578_125));
}

#[test]
fn single_messages_of_other_systems() {
    let Some(radar) = recording("cro/cat048.raw") else {
        return;
    };
    let (_, compared) = for_each(&radar, |record| {
        let report = cat048::TargetReport::read(record).unwrap();
        assert_eq!((report.track_number, report.address), (Some(3563), Some(3_958_284)));
        assert!((report.slant_position.unwrap().range_m - 197.683_593_75 * 1852.0).abs() < 1e-6);
        assert!(!report.track_status.unwrap().slant_corrected);
    });
    assert_eq!(compared, 30);

    let Some(system) = recording("cro/cat062cat065.raw") else {
        return;
    };
    let (mut tracks, mut batches) = (vec![], vec![]);
    for_each(&system, |record| {
        tracks.extend(cat062::TrackMessage::read(record));
        batches.extend(cat065::ServiceMessage::read(record));
    });
    let numbers: Vec<_> = tracks.iter().map(|track| track.track_number).collect();
    assert_eq!(numbers, [Some(4980), Some(7977)]);
    let aircraft = tracks[1].aircraft;
    assert_eq!(
        (aircraft.address, aircraft.callsign.unwrap().as_str()),
        (Some(3_934_805), "SXD4723")
    );
    assert_eq!(tracks[0].vertical_rate_m_s, Some(-443.75 * 0.3048 / 60.0));
    assert_eq!(batches[0].message_type, Some(cat065::MessageType::EndOfBatch));
    assert_eq!(batches[0].batch, Some(24));

    let Some(ads_b) = recording("cro/cat21_re.ast") else {
        return;
    };
    let mut fractions = vec![];
    for_each(&ads_b, |record| {
        let report = cat021_v2::TargetReport::read(record).unwrap();
        assert!(report.descriptor.unwrap().ground_bit);
        fractions.extend(report.position_reception_fraction);
    });
    let seconds: Vec<_> = fractions
        .iter()
        .map(|time| f64::from(time.fraction) / (1u32 << 30) as f64)
        .collect();
    assert!(
        (seconds[0] - 0.9196).abs() < 1e-6 && (seconds[1] - 0.160_666).abs() < 1e-6,
        "{seconds:?}"
    );
}
