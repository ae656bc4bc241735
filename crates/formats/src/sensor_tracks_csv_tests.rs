//! Tests of sensor tracks as CSV rows.

use messages::Identity;
use proptest::prelude::*;

use super::*;
use crate::identity_columns::callsign;

const HEADER: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,P02,P03,P04,P05,P11,P12,P13,P14,P15,\
                      P22,P23,P24,P25,P33,P34,P35,P44,P45,P55,state";
const VARIANCES: &str = "25,0,0,0,0,0,25,0,0,0,0,100,0,0,0,4,0,0,4,0,9";

/// The tracks of `rows` below a header with further `columns`; sensor 9 is no source.
fn read(columns: &str, rows: &str) -> Vec<Result<SensorTrack, String>> {
    let text = format!("{HEADER}{columns}\n{rows}");
    let source_of = |sensor: u32| (sensor < 9).then_some(sensor as u16 + 100);
    let reader = SensorTrackReader::new(text.as_bytes(), 1_000, source_of).unwrap();
    reader.map(|row| row.map_err(|error| error.to_string())).collect()
}

#[test]
fn a_row_without_further_columns_is_a_whole_report() {
    let rows = format!("2.5,3,42,1,-2,3.25,4,5,-6,{VARIANCES},coasted,7\n");
    let found = read(",truth_id", &rows);
    let mut covariance = Covariance::diagonal([5.0, 5.0, 10.0], [2.0, 2.0, 3.0]);
    let expected = SensorTrack {
        time_of_measurement_ns: 2_500_001_000,
        track_number: 42,
        source: 103,
        valid: bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE | bits::OWN_COVARIANCE,
        position_m: [1.0, -2.0, 3.25],
        velocity_mps: [4.0, 5.0, -6.0],
        covariance,
        state: TrackState::Coasted as u8,
        ..SensorTrack::default()
    };
    assert_eq!(found, [Ok(expected)]);
    covariance.set(1, 4, -3.5);
    let correlated = rows.replace("25,0,0,0,0,100", "25,0,0,-3.5,0,100");
    assert_eq!(
        read(",truth_id", &correlated)[0].as_ref().unwrap().covariance,
        covariance
    );
}

#[test]
fn further_columns_are_read_by_name_and_may_be_empty() {
    let columns = ",velocity_valid,callsign,method,address,trace,mode_3a,height_valid";
    let row = |further: &str| format!("0,1,1,0,0,0,0,0,0,{VARIANCES},tentative,{further}\n");
    let track = read(columns, &row("1,VLG 20,3,3444cf,50.5,0412,0"))[0].clone().unwrap();
    let identity = Identity::default()
        .with_address(0x3444cf)
        .with_mode_3a(0o412)
        .with_callsign(*b"VLG 20  ");
    assert_eq!((track.identity, track.method, track.trace_m2), (identity, 3, 50.5));
    assert_eq!(track.valid, bits::VELOCITY | bits::OWN_COVARIANCE | bits::TRACE);
    let track = read(columns, &row(",,,,,,"))[0].clone().unwrap();
    assert_eq!((track.identity, track.method), (Identity::default(), 0));
    assert!(track.has(bits::HEIGHT | bits::VELOCITY) && !track.has(bits::TRACE));
}

#[test]
fn a_row_may_have_the_trace_in_place_of_the_covariance() {
    let none = ",".repeat(COVARIANCE_COLUMNS.len() - 1);
    let row = |covariance: &str, trace: &str| format!("0,1,1,7,0,0,9,0,0,{covariance},confirmed,{trace}\n");
    let track = read(",trace", &row(&none, "200"))[0].clone().unwrap();
    assert_eq!((track.trace_m2, track.covariance), (200.0, Covariance::default()));
    assert!(track.has(bits::TRACE) && !track.has(bits::OWN_COVARIANCE));
    let error = read(",trace", &row(&none, "")).remove(0).unwrap_err();
    assert!(error.contains("P00"), "{error}");

    let header = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,state,trace";
    let text = format!("{header}\n0,1,1,7,0,0,9,0,0,confirmed,200\n1,1,1,7,0,0,9,0,0,confirmed,\n");
    let reader = SensorTrackReader::new(text.as_bytes(), 0, |_| Some(101)).unwrap();
    let [whole, short] = &reader.collect::<Vec<_>>()[..] else {
        panic!("two rows")
    };
    assert_eq!(
        whole.as_ref().unwrap(),
        &SensorTrack {
            time_of_measurement_ns: 0,
            ..track
        }
    );
    assert!(short.as_ref().unwrap_err().to_string().contains("column trace"));
    let missing = SensorTrackReader::new(&header.as_bytes()[..header.len() - 6], 0, |_| Some(101));
    assert!(missing.err().is_some_and(|error| error.to_string().contains("P00")));
}

#[test]
fn kind_and_type_are_read_and_what_contradicts_itself_is_refused() {
    let read_row = |columns: &str, further: &str| {
        let rows = format!("0,1,1,0,0,0,0,0,0,{VARIANCES},confirmed,{further}\n");
        let found = read(columns, &rows).remove(0);
        found.map(|track| (track.kind, track.members, track.target_type))
    };
    let all = ",kind,members,type,type_confidence";
    let (single, group) = (TrackKind::Single as u8, TrackKind::Group as u8);
    let patrol = TargetType::new("patrol 7", 0.7).unwrap();
    assert_eq!(read_row(all, "group,4,patrol 7,0.7"), Ok((group, 4, patrol)));
    assert_eq!(read_row(all, "single,0,patrol 7,0.7"), Ok((single, 0, patrol)));
    assert_eq!(read_row(all, ",,,"), Ok((single, 0, TargetType::default())));
    assert_eq!(
        read_row(",members,kind", "2,group"),
        Ok((group, 2, TargetType::default()))
    );
    for (columns, further, expected) in [
        (
            all,
            "flock,4,,",
            "column kind: \"flock\" is no kind of track; write single or group",
        ),
        (all, "group,,,", "column members: \"\" does not fit the kind"),
        (all, "group,0,,", "column members: \"0\" does not fit the kind"),
        (all, "single,3,,", "column members: \"3\" does not fit the kind"),
        (all, ",3,,", "column members: \"3\" does not fit the kind"),
        (
            all,
            "group,70000,,",
            "column members: \"70000\" is no whole number of the kind u16",
        ),
        (
            ",kind",
            "group",
            "column kind: \"group\" does not fit the kind: a group has members",
        ),
        (all, ",,patrol 7,", "column type: \"patrol 7\" needs a type_confidence"),
        (",type", "patrol 7", "column type: \"patrol 7\" needs a type_confidence"),
        (all, ",,,0.5", "column type_confidence: \"0.5\" is of no type"),
        (
            all,
            ",,patrol 7,1.5",
            "column type: \"patrol 7\" with confidence 1.5 is no type",
        ),
        (
            all,
            ",,patrol 7,0",
            "column type: \"patrol 7\" with confidence 0 is no type",
        ),
        (all, ",,thirteen char,0.5", "is no type; write 1 to 12 characters"),
    ] {
        let text = read_row(columns, further).unwrap_err();
        assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
    }
}

#[test]
fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
    let columns = ",address,mode_3a,callsign,method,trace,height_valid";
    let good = format!("0,1,1,0,0,0,0,0,0,{VARIANCES},confirmed,,,,,,");
    read(columns, &good)[0].as_ref().unwrap();
    for (from, to, expected) in [
        ("0,1,1", "0,9,1", "column sensor_id: \"9\" is no sensor of this run"),
        ("0,1,1", "0,1,-1", "column sensor_track_id: \"-1\" is no whole number"),
        ("0,1,1,0", "0,1,1,NaN", "column x: \"NaN\" is not finite"),
        ("25,0,0", "-25,0,0", "column P00: \"-25\" is negative"),
        (
            "25,0,0",
            "25,25.1,0",
            "column P01: \"25.1\" is beyond the product of its standard deviations, 25.0011",
        ),
        (
            "confirmed",
            "Confirmed",
            "column state: \"Confirmed\" is no state; write one of tentative, confirmed",
        ),
        (
            "confirmed,",
            "confirmed,3444CFF",
            "column address: \"3444CFF\" is not an address",
        ),
        (
            "confirmed,",
            "confirmed,+44",
            "column address: \"+44\" is not an address",
        ),
        (
            "confirmed,,",
            "confirmed,,7800",
            "column mode_3a: \"7800\" is not a Mode 3/A code",
        ),
        (
            "confirmed,,,",
            "confirmed,,,TOOLONG12",
            "column callsign: \"TOOLONG12\" is no callsign",
        ),
        ("confirmed,,,", "confirmed,,,É", "column callsign: \"É\" is no callsign"),
        (
            "confirmed,,,,",
            "confirmed,,,,256",
            "column method: \"256\" is no whole number of the kind u8",
        ),
        ("confirmed,,,,,", "confirmed,,,,,-1", "column trace: \"-1\" is negative"),
        (
            "confirmed,,,,,,",
            "confirmed,,,,,,yes",
            "column height_valid: \"yes\" is neither 0 nor 1",
        ),
    ] {
        let row = good.replacen(from, to, 1);
        let [found] = &read(columns, &row)[..] else {
            panic!("{row}")
        };
        let text = found.as_ref().unwrap_err();
        assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
    }
}

/// A standard deviation of 5 mm/s is written as a variance of 0.0000.
#[test]
fn a_covariance_beside_a_variance_that_rounding_took_is_read() {
    let mut covariance = Covariance::default();
    for (line, other, value) in [(0, 0, 1e4), (1, 1, 1.0), (3, 3, 25e-6), (0, 3, 0.4)] {
        covariance.set(line, other, value);
    }
    let track = SensorTrack {
        covariance,
        valid: bits::OWN_COVARIANCE | bits::VELOCITY,
        track_number: 1,
        ..SensorTrack::default()
    };
    let mut text = Vec::new();
    SensorTrackWriter::begin(&mut text, 0).unwrap().write(&track).unwrap();
    let mut found = SensorTrackReader::new(&text[..], 0, |_| Some(0)).unwrap();
    assert_eq!(found.next().unwrap().unwrap().covariance.get(0, 3), 0.4);
}

/// A track whose numbers have no more decimals than files carry.
fn track() -> impl Strategy<Value = SensorTrack> {
    let thousandths =
        || prop::array::uniform3(-1_000_000_000i64..1_000_000_000).prop_map(|all| all.map(|one| one as f64 / 1e3));
    let sigmas = prop::array::uniform6(0.0f64..1e4);
    let correlation = -0.9f64..0.9;
    let identity = (
        prop::option::of((any::<bool>(), 0u32..1_000_000_000)),
        prop::option::of(0u16..0o10000),
        prop::option::of("[A-Z0-9]{1,8}"),
        prop::option::of("[A-Z]{1,9}( [A-Z0-9]{1,9})?"),
    );
    let flags = (0u16..16, 0u8..4, any::<u8>());
    let members = prop::option::of(1u16..=u16::MAX);
    let target_type = prop::option::of(("[A-Za-z0-9]{1,6}[ -]?[A-Z0-9]{1,5}", 1e-6f64..=1.0));
    (
        (0i64..4_000_000_000_000_000, 0u16..1000, any::<u32>()),
        (thousandths(), thousandths(), sigmas, correlation),
        (identity, flags, 0i64..1_000_000_000, members, target_type),
    )
        .prop_map(
            |((time_ns, source, number), (position_m, velocity_mps, sigmas, correlation), rest)| {
                let ((of_target, code, of_radio, name), (flags, state, method), trace, members, target_type) = rest;
                let mut identity = Identity::default();
                identity = match of_target {
                    Some((true, mmsi)) => identity.with_mmsi(mmsi),
                    Some((false, address)) => identity.with_address(address),
                    None => identity,
                };
                identity = code.map_or(identity, |code| identity.with_mode_3a(code));
                if let Some(text) = of_radio {
                    identity = identity.with_callsign(callsign(&text).unwrap());
                }
                if let Some(name) = name {
                    identity = identity.with_name(&name);
                }
                let mut covariance = Covariance::default();
                for line in 0..STATE_LEN {
                    for other in line..STATE_LEN {
                        let share = if line == other { 1.0 } else { correlation };
                        let value = sigmas[line] * sigmas[other] * share;
                        covariance.set(line, other, (value * 1e4).round() / 1e4);
                    }
                }
                let bit = |place: u16, bit: u16| if flags >> place & 1 == 1 { bit } else { 0 };
                let (height, velocity, trace_bit) = (bit(0, bits::HEIGHT), bit(1, bits::VELOCITY), bit(2, bits::TRACE));
                let vertical = if height != 0 && velocity != 0 {
                    bits::VERTICAL_RATE
                } else {
                    0
                };
                SensorTrack {
                    time_of_measurement_ns: time_ns,
                    source,
                    track_number: number,
                    identity,
                    position_m,
                    velocity_mps,
                    covariance,
                    trace_m2: if trace_bit != 0 { trace as f64 / 1e4 } else { 0.0 },
                    state,
                    method,
                    valid: bits::OWN_COVARIANCE | height | velocity | vertical | trace_bit,
                    kind: members.map_or(TrackKind::Single, |_| TrackKind::Group) as u8,
                    members: members.unwrap_or(0),
                    target_type: target_type
                        .map(|(name, confidence)| TargetType::new(&name, confidence).unwrap())
                        .unwrap_or_default(),
                    ..SensorTrack::default()
                }
            },
        )
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(tracks in prop::collection::vec(track(), 0..4), first_day_ns in 0i64..1 << 60) {
        let write = |tracks: &[SensorTrack]| {
            let mut text = Vec::new();
            let mut writer = SensorTrackWriter::begin(&mut text, first_day_ns).unwrap();
            for track in tracks {
                writer.write(track).unwrap();
            }
            text
        };
        let moved = |mut track: SensorTrack| {
            track.time_of_measurement_ns += first_day_ns;
            track
        };
        let tracks: Vec<_> = tracks.into_iter().map(moved).collect();
        let text = write(&tracks);
        let source_of = |sensor: u32| u16::try_from(sensor - 1).ok();
        let reader = SensorTrackReader::new(&text[..], first_day_ns, source_of).unwrap();
        let found: Vec<_> = reader.map(Result::unwrap).collect();
        prop_assert_eq!(&found, &tracks);
        prop_assert_eq!(write(&found), text);
    }
}

#[test]
fn ships_have_columns_of_their_own() {
    let row = |values: &str| format!("1,1,1,0,0,0,0,0,0,{VARIANCES},confirmed,{values}\n");
    let rows = [row(",227000000,QUEEN MARY 2"), row(",2275400,"), row("87BEC0,,")].concat();
    let found: Vec<Identity> = read(",address,mmsi,name", &rows)
        .into_iter()
        .map(|track| track.unwrap().identity)
        .collect();
    let ship = Identity::default().with_mmsi(227_000_000).with_name("QUEEN MARY 2");
    assert_eq!(found[0], ship);
    assert_eq!(
        (found[1].mmsi(), found[2].address()),
        (Some(2_275_400), Some(0x87_bec0))
    );
    for (values, expected) in [
        ("87BEC0,227000000,", "stands beside an address"),
        (",2270000001,", "is not an MMSI of nine digits"),
        (
            ",227000000,A NAME OF TWENTY-ONE..",
            "is no name; write up to 20 characters",
        ),
    ] {
        let text = read(",address,mmsi,name", &row(values)).remove(0).unwrap_err();
        assert!(text.contains(expected), "{text}");
    }
}
