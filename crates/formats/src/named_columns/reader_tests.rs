use frames::{Geodetic, SystemFrame};
use messages::{SensorTrack, sensor_track_bits as bits};
use proptest::prelude::*;
use test_support::recording;

use super::*;
use csv_table::{TARGET_COLUMNS, Table, TimeForm};

const SIGMA_M: f64 = 30.0;

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(51.0, -1.0, 0.0).unwrap())
}

/// Outcome of each row, and the names of sources in the order of appearance.
fn read(text: &str) -> (Vec<Result<SensorTrack, String>>, Vec<String>) {
    let mut names: Vec<String> = Vec::new();
    let source_of = |name: &str| {
        let known = names.iter().position(|known| known == name);
        let number = known.unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        });
        Some(RowSource {
            number: number as u16,
            sigma_m: Some(SIGMA_M),
        })
    };
    let reader = NamedTrackReader::new(text.as_bytes(), Some(frame()), "file", source_of).unwrap();
    let rows = reader.map(|row| row.map_err(|error| error.to_string())).collect();
    (rows, names)
}

fn track(text: &str) -> SensorTrack {
    let (rows, _) = read(text);
    rows.into_iter().next().unwrap().unwrap()
}

fn refusal(text: &str) -> String {
    let (rows, _) = read(text);
    rows.into_iter().next().unwrap().unwrap_err()
}

fn header_error(header: &str) -> String {
    let reader = NamedTrackReader::new(header.as_bytes(), None, "file", |_| None);
    reader.err().unwrap().to_string()
}

fn takes(header: &str) -> bool {
    has_named_columns(&Table::new(header.as_bytes()).unwrap())
}

#[test]
fn a_state_vector_of_an_aircraft_is_a_sensor_track() {
    // The first row of a file of the OpenSky Network.
    let track = track(
        "time,icao24,lat,lon,velocity,heading,vertrate,callsign,onground,squawk,baroaltitude,geoaltitude\n\
         1626098400,3c4591,51.46894551939883,-0.4407501220703125,254.65393708930063,99.65260971667908,0.0,BOX413  ,False,\
         1174.0,10668.0,10843.26\n",
    );
    assert_eq!(track.time_of_measurement_ns, 1_626_098_400_000_000_000);
    assert_eq!(
        (track.track_number, track.identity.address()),
        (0x3c_4591, Some(0x3c_4591))
    );
    assert_eq!(
        (track.identity.callsign(), track.identity.mode_3a()),
        (Some("BOX413"), Some(0o1174))
    );
    let place = frame().to_geodetic(track.position_m);
    assert!((place.latitude_deg() - 51.468_945_519_398_83).abs() < 1e-9);
    assert!((place.longitude_deg() + 0.440_750_122_070_312_5).abs() < 1e-9);
    assert!((place.height_m() - 10_668.0).abs() < 1e-3);
    assert!(track.has(bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE | bits::LEVEL | bits::PRESSURE_OFFSET));
    assert!(!track.has(bits::ON_GROUND) && !track.has(bits::OWN_COVARIANCE));
    assert_eq!((track.level, track.pressure_offset_m), (1400, -175.26));
    let vertical = frame().vertical(track.position_m, track.velocity_mps);
    assert!(
        vertical.climb_mps.abs() < 0.01,
        "level, though the horizon is tilted: {vertical:?}"
    );
    let speed: f64 = track.velocity_mps.iter().map(|part| part * part).sum();
    assert!((speed.sqrt() - 254.653_937).abs() < 1e-3);
    let sigma = |part: usize| track.covariance.get(part, part).sqrt();
    assert_eq!(
        [0, 1, 2, 3, 5].map(sigma),
        [SIGMA_M, SIGMA_M, HEIGHT_SIGMA_M, VELOCITY_SIGMA_MPS, VELOCITY_SIGMA_MPS]
    );
}

#[test]
fn a_report_of_a_ship_is_a_sensor_track() {
    let track = track(
        "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n\
         2016-01-12 13:02:11.218,235070762,50.7730133333333,-1.092935,157.8,5.9\n",
    );
    assert_eq!(track.time_of_measurement_ns, 1_452_603_731_218_000_000);
    assert_eq!(
        (track.track_number, track.identity.mmsi()),
        (235_070_762, Some(235_070_762))
    );
    assert!(track.has(bits::VELOCITY) && !track.has(bits::HEIGHT));
    assert_eq!(
        (track.position_m[2], track.covariance.get(2, 2)),
        (0.0, 0.0),
        "no height is stated"
    );
    let [east, north, _] = track.velocity_mps;
    let speed = 5.9 * 1852.0 / 3600.0;
    assert!((east.hypot(north) - speed).abs() < 1e-3);
    assert!((east.atan2(north).to_degrees() - 157.8).abs() < 0.1);
}

#[test]
fn velocities_are_turned_from_the_targets_north_into_the_frame() {
    // At 51° of latitude, 5° further east: the meridian there leans by about 5° sin 51° = 3.9° to the left.
    let track = track("time,lat,lon,speed,course,track_id\n1,51,4,100,0,7\n");
    let [east, north, _] = track.velocity_mps;
    let direction_deg = east.atan2(north).to_degrees();
    assert!((direction_deg + 3.886).abs() < 0.02, "{direction_deg}");
}

#[test]
fn absent_values_stay_unknown() {
    for absent in ["", "nan", "NaN", "null", "None", "NA"] {
        let text = format!(
            "time,lat,lon,sog,cog,altitude_ft,vertrate,sigma_m,on_ground,mmsi\n\
                            1,51,-1,{absent},{absent},{absent},{absent},{absent},{absent},235070762\n"
        );
        let track = track(&text);
        assert_eq!((track.valid, track.velocity_mps), (0, [0.0; 3]), "{absent}");
        assert_eq!([2, 3, 4, 5].map(|part| track.covariance.get(part, part)), [0.0; 4]);
        for (columns, what) in [
            (format!("time,lat,lon,id\n{absent},51,-1,5\n"), "states no time"),
            (format!("time,lat,lon,id\n1,{absent},-1,5\n"), "states no position"),
            (format!("time,lat,lon,id\n1,51,-1,{absent}\n"), "names no target"),
        ] {
            let said = refusal(&columns);
            assert!(said.contains(what) && said.starts_with("line 2, column "), "{said}");
        }
    }
}

#[test]
fn a_speed_alone_is_no_velocity_but_rest_is() {
    let velocity = |speed: &str, course: &str| {
        let track = track(&format!(
            "time,lat,lon,sog,cog,mmsi\n1,51,-1,{speed},{course},235070762\n"
        ));
        track.has(bits::VELOCITY).then_some(track.velocity_mps[1])
    };
    assert_eq!(velocity("5", ""), None);
    assert_eq!(velocity("0", ""), Some(0.0));
    // Values of ships for "not available".
    assert_eq!([velocity("102.3", "10"), velocity("5", "360")], [None, None]);
    assert!((velocity("10", "0").unwrap() - 5.1444).abs() < 1e-3);
    // The nose of an aircraft may point to 360.
    let north = track("time,lat,lon,speed,heading,icao24\n1,51,-1,5,360,abc123\n").velocity_mps[1];
    assert!((north - 5.0).abs() < 1e-6, "{north}");
}

#[test]
fn names_get_numbers_in_the_order_of_appearance() {
    let (rows, sources) = read(
        "time,lat,lon,callsign,name,id,sensor,sigma_m\n\
         1,51,-1,ABC12,,,north,5\n1,51,-1,,Sea Cloud,,south,\n2,51,-1,ABC12,,,north,\n3,51,-1,,,17,south,\n",
    );
    let rows: Vec<SensorTrack> = rows.into_iter().map(Result::unwrap).collect();
    let numbers: Vec<_> = rows.iter().map(|row| (row.track_number, row.source)).collect();
    assert_eq!(numbers, [(1 << 31, 0), ((1 << 31) + 1, 1), (1 << 31, 0), (17, 1)]);
    assert_eq!(sources, ["north", "south"]);
    assert_eq!(rows[1].identity.name(), Some("Sea Cloud"));
    assert_eq!([0, 1].map(|row: usize| rows[row].covariance.get(0, 0)), [25.0, 900.0]);
    assert!(rows[0].has(bits::OWN_COVARIANCE));
    let (rows, sources) = read("time,lat,lon\n1,51,-1\n2,51,-1\n");
    assert!(rows.iter().all(|row| row.as_ref().unwrap().track_number == 1));
    assert_eq!(sources, ["file"]);
}

#[test]
fn a_table_in_metres_keeps_its_plane() {
    let track = track("t,x,y,z,speed_kn,course_deg,id\n12.5,1000,-2000,30,10,90,9\n");
    assert_eq!(
        (track.time_of_measurement_ns, track.position_m),
        (12_500_000_000, [1000.0, -2000.0, 30.0])
    );
    assert!((track.velocity_mps[0] - 5.1444).abs() < 1e-3 && track.velocity_mps[1].abs() < 1e-9);
    assert!(track.has(bits::HEIGHT | bits::VELOCITY));
}

#[test]
fn track_and_heading_mean_the_course_where_nothing_else_does() {
    let of = |header: &str, row: &str| track(&format!("time,lat,lon,{header}\n1,51,-1,{row}\n"));
    let course = |track: &SensorTrack| track.velocity_mps[0].atan2(track.velocity_mps[1]).to_degrees().round();
    let receiver = of("icao24,groundspeed,track", "abc123,400,324.3");
    assert_eq!((course(&receiver), receiver.track_number), (-36.0, 0xab_c123));
    let tracker = of("track,speed,course", "12,10,90");
    assert_eq!((course(&tracker), tracker.track_number), (90.0, 12));
    let numbered = of("track,speed,heading", "12,10,90");
    assert_eq!((course(&numbered), numbered.track_number), (90.0, 12));
    let ship = of("mmsi,sog,cog,heading", "235070762,10,90,511");
    assert_eq!(course(&ship), 90.0);
}

#[test]
fn contradictions_of_a_header_name_both_columns() {
    for (header, words) in [
        (
            "time,timestamp,latitude,longitude",
            "columns time and timestamp state one quantity",
        ),
        ("Time,Lat,Lon,SOG,speed", "columns SOG and speed state one quantity"),
        ("time,lat,lon,x,y", "columns lat and x both state the position"),
        (
            "time,lat,lon,speed,vx,vy",
            "columns speed and vx both state the velocity",
        ),
        ("time,lat", "column longitude is missing"),
        ("lat,lon", "column time is missing"),
    ] {
        let said = header_error(header);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn impossible_values_are_refused_with_their_column() {
    for (header, row, words) in [
        ("lat,lon,id", "91,-1,5", "column lat: \"91\" gives no place"),
        ("lat,lon,id", "51,181,5", "column lon: \"181\" gives no place"),
        ("lat,lon,id", "0,0,5", "without a fix"),
        ("lat,lon,id,sigma_m", "51,-1,5,0", "is no standard deviation"),
        ("lat,lon,id,speed", "51,-1,5,-3", "is no speed"),
        ("lat,lon,id,altitude_m", "51,-1,5,1e9", "beyond what any target does"),
        ("lat,lon,id,on_ground", "51,-1,5,maybe", "is neither true nor false"),
        ("lat,lon,mmsi", "51,-1,x", "is not an MMSI"),
        ("lat,lon,icao24", "51,-1,zz", "is not an address"),
        (
            "lat,lon,mmsi,icao24",
            "51,-1,235070762,abc123",
            "stands beside an address",
        ),
    ] {
        let said = refusal(&format!("time,{header}\n1,{row}\n"));
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn the_header_decides_who_reads_a_table() {
    const SENSOR_TRACKS: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,state";
    assert!(!takes(SENSOR_TRACKS));
    assert!(
        !takes(&format!("{SENSOR_TRACKS},latitude,longitude")),
        "as before, further columns are ignored"
    );
    assert!(!takes("time_s,sensor_id,sensor_track_id,x,y,trace"));
    // A table of sensor tracks that lacks a column keeps its error.
    for part in [
        "time_s,sensor_id,x,y",
        "sensor_track_id,time_s,x,y",
        "time_s,x,y,P00",
        "",
        "a,b",
        "time;lat;lon",
    ] {
        assert!(!takes(part), "{part}");
    }
    for header in [
        "Time,MMSI,Latitude_degrees,Longitude_degrees",
        "time_s,sensor_id,lat,lon",
        "t,x,y,id",
        "lat",
    ] {
        assert!(takes(header), "{header}");
    }
}

#[test]
fn an_outline_has_the_first_place_that_is_valid() {
    let text = "time,lat,lon,altitude\nnoon,50,0,1\n5,91,0,1\n5,0,0,1\n\n6,52.5,-1.5,1\n7,53,0,1\n";
    let outline = TableOutline::of(text.as_bytes()).unwrap().unwrap();
    let (place, line) = outline.first_place.unwrap();
    assert_eq!((place.latitude_deg().round(), line), (53.0, 6));
    assert!((place.latitude_deg() - 52.5).abs() < 1e-9);
    assert_eq!(
        (outline.time_form, outline.ignored),
        (Some(TimeForm::OfDay), vec!["altitude".to_owned()])
    );
    assert_eq!(outline.target_names, TargetNames::One);
}

/// Counts of the rows of a public file that are read, its targets, and the rows that are refused.
fn counts(name: &str) -> Option<(usize, usize, usize)> {
    let text = String::from_utf8(recording(name)?).unwrap();
    let (rows, _) = read(&text);
    let read: Vec<_> = rows.iter().flatten().collect();
    let targets: std::collections::BTreeSet<_> = read.iter().map(|track| track.track_number).collect();
    Some((read.len(), targets.len(), rows.len() - read.len()))
}

#[test]
fn public_files_are_read_as_they_are() {
    if let Some(found) = counts("stonesoup/OpenSky_Plane_States.csv") {
        assert_eq!(found, (6052, 84, 0));
    }
    if let Some(found) = counts("stonesoup/SolentAIS_20160112_130211.csv") {
        assert_eq!(found, (18623, 91, 0));
    }
    if let Some(octets) = recording("stonesoup/UAV_Rot.csv") {
        let said = TableOutline::of(&octets[..]).unwrap_err().to_string();
        assert!(said.contains("columns time and timestamp state one quantity"), "{said}");
        // Without one of them, it is read: a file of a single target.
        let text = String::from_utf8(octets)
            .unwrap()
            .replacen("timestamp", "second_of_day", 1);
        let (rows, _) = read(&text);
        let read: Vec<_> = rows.iter().flatten().collect();
        assert_eq!((rows.len(), read.len()), (965, 965));
        assert!(
            read.iter()
                .all(|track| track.track_number == 1 && track.has(bits::HEIGHT | bits::VELOCITY))
        );
    }
}

/// Cells that are likely to be near a limit of a value.
fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        "[ -~]{0,12}",
        any::<f64>().prop_map(|value| value.to_string()),
        (-200.0..400.0_f64).prop_map(|value| value.to_string()),
        prop::sample::select(vec![
            "",
            "nan",
            "90",
            "-180",
            "1626098400",
            "2016-01-12 13:02:11",
            "3c4591",
            "235070762",
            "\u{e9}"
        ])
        .prop_map(str::to_owned),
    ]
}

proptest! {
    #[test]
    fn any_text_is_refused_or_read_and_each_row_once(
        is_plane: bool,
        names in prop::collection::vec(0..TARGET_COLUMNS.len(), 0..8),
        rows in prop::collection::vec(prop::collection::vec(cell(), 11), 0..12),
    ) {
        let mut header = if is_plane { vec!["time", "x", "y"] } else { vec!["time", "lat", "lon"] };
        header.extend(names.iter().map(|place| TARGET_COLUMNS[*place].name));
        let quoted = |cells: &[String]| {
            let cells = cells.iter().take(header.len()).map(|cell| format!("\"{}\"", cell.replace('"', "\"\"")));
            cells.collect::<Vec<_>>().join(",")
        };
        let lines: Vec<_> = rows.iter().map(|row| quoted(row)).collect();
        let text = format!("{}\n{}\n", header.join(","), lines.join("\n"));
        let source = |_: &str| Some(RowSource { number: 0, sigma_m: Some(SIGMA_M) });
        if let Ok(reader) = NamedTrackReader::new(text.as_bytes(), Some(frame()), "file", source) {
            let found: Vec<_> = reader.collect();
            prop_assert_eq!(found.len(), rows.len());
            for track in found.iter().flatten() {
                prop_assert!(track.has_possible_state() && track.covariance.is_possible(), "{track:?}");
            }
        }
        let _ = TableOutline::of(text.as_bytes());
    }

    #[test]
    fn octets_of_any_kind_do_not_panic(octets in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = TableOutline::of(&octets[..]);
        let mut text = b"time,lat,lon,id\n".to_vec();
        text.extend(octets);
        let source = |_: &str| Some(RowSource { number: 0, sigma_m: None });
        if let Ok(reader) = NamedTrackReader::new(&text[..], Some(frame()), "file", source) {
            for row in reader {
                let _ = row;
            }
        }
    }
}
