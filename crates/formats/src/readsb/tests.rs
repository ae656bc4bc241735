//! Documents of all kinds.

use observations::{Emergency, Observation, Quality, TargetCategory};
use test_support::recordings;

use super::*;
use crate::target_message::TargetMessage;

const NOW_S: i64 = 1_767_261_600;
const MS: i64 = 1_000_000;

pub(super) fn reader() -> ReadsbReader {
    ReadsbReader::new(ReadsbSettings::default())
}

pub(super) fn take(reader: &mut ReadsbReader, document: &str) -> Vec<(Origin, TargetMessage)> {
    let mut found = Vec::new();
    reader.take(document.as_bytes(), |origin, message| found.push((origin, message)));
    found
}

/// A list of one state.
fn list(now: &str, state: &str) -> String {
    format!("{{\"now\": {now}, \"messages\": 7, \"aircraft\": [{{{state}}}]}}")
}

/// Asserts that a count is in exactly one place for each document and state.
pub(super) fn is_whole(counters: &ReadsbCounters, documents: u64) {
    assert_eq!(counters.documents + counters.refused_documents, documents);
    let ways = [
        counters.observations,
        counters.repetitions,
        counters.without_position,
        counters.refused_states,
    ];
    assert_eq!(ways.iter().sum::<u64>(), counters.states);
    let refused: u64 = counters.refused.iter().sum();
    assert_eq!(refused, counters.refused_documents + counters.refused_states);
}

/// Asserts that two numbers are equal but for rounding.
fn near(found: Option<f64>, expected: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() < 1e-7 * expected.abs(), "{found} {expected}");
}

const WHOLE: &str = r#""hex":"3c1a2b","type":"adsb_icao","flight":"DLH9AB  ","alt_baro":36000,"alt_geom":36500,
    "gs":450.0,"track":90.0,"baro_rate":-64,"geom_rate":0,"squawk":"1000","emergency":"none","category":"A3",
    "nav_altitude_mcp":32000,"lat":51.5,"lon":-1.25,"nic":8,"rc":186,"seen_pos":0.5,"version":2,"nac_p":9,"nac_v":2,
    "sil":3,"alert":0,"spi":1,"mlat":[],"tisb":[],"messages":500,"seen":0.1,"rssi":-5.5"#;

#[test]
fn a_state_has_all_values() {
    let mut reader = reader();
    let found = take(&mut reader, &list("1767261600.25", WHOLE));
    let [(Origin::Own, message)] = found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(message.time_ns, NOW_S * 1000 * MS - 250 * MS);
    let observation = message.observation.unwrap();
    assert_eq!(observation.time_of_day_ns, Some(message.time_ns % 86_400_000_000_000));
    assert_eq!(observation.track_number, Some(0x3c_1a2b));
    assert_eq!(
        observation.geodetic,
        Some([51.5f64.to_radians(), (-1.25f64).to_radians()])
    );
    let identity = observation.identity;
    assert_eq!(
        (identity.address(), identity.callsign(), identity.mode_3a()),
        (Some(0x3c_1a2b), Some("DLH9AB"), Some(0o1000))
    );
    near(observation.pressure_altitude_m, 10_972.8);
    near(observation.ellipsoid_height_m, 11_125.2);
    near(observation.vertical_rate_mps, -0.32512);
    let [east, north] = observation.velocity.unwrap();
    assert!((east - 231.5).abs() < 1e-9 && north.abs() < 1e-9);
    assert!(observation.velocity_covariance.is_some() && !observation.on_ground);
    near(
        radius95(&observation),
        30.0_f64.hypot(2.447_746_8 * 5.09 / 12f64.sqrt()),
    );
    assert_eq!(observation.alerts.raised, messages::alert_bits::SPECIAL_IDENTIFICATION);
    let statement = message.statement.unwrap();
    assert_eq!(
        (statement.track_number, statement.category, statement.emergency),
        (0x3c_1a2b, TargetCategory::Large, Emergency::None)
    );
    near(statement.selected_altitude_m.map(f64::from), 9_753.6);
    is_whole(reader.counters(), 1);
}

#[test]
fn a_position_and_a_statement_are_given_once() {
    let mut reader = reader();
    let counts = |found: &[(Origin, TargetMessage)]| {
        let observations = found.iter().filter(|(_, message)| message.observation.is_some());
        let statements = found.iter().filter(|(_, message)| message.statement.is_some());
        (observations.count(), statements.count())
    };
    let mut take = |now: &str, state: &str| counts(&take(&mut reader, &list(now, state)));
    assert_eq!(take("1767261600.0", WHOLE), (1, 1));
    // A second later the position is a second older, but for rounding.
    assert_eq!(
        take("1767261601.0", &WHOLE.replace("seen_pos\":0.5", "seen_pos\":1.6")),
        (0, 0)
    );
    assert_eq!(take("1767261602.0", WHOLE), (1, 0), "the same place at another time");
    assert_eq!(take("1767261603.0", &WHOLE.replace("51.5", "51.6")), (1, 0));
    let emergency = WHOLE.replace("51.5", "51.7").replace("\"none\"", "\"nordo\"");
    assert_eq!(take("1767261604.0", &emergency), (1, 1));
    // Another category, without a position: news of its own.
    let heavy = r#""hex":"3c1a2b","category":"A5""#;
    assert_eq!(take("1767261605.0", heavy), (0, 1));
    assert_eq!(take("1767261606.0", heavy), (0, 0));
    let counters = reader.counters();
    assert_eq!(
        (counters.observations, counters.repetitions, counters.without_position),
        (4, 1, 2)
    );
    assert_eq!(counters.statements, 3);
    is_whole(counters, 7);
}

#[test]
fn missing_values_are_unknown_and_old_names_are_read() {
    let mut reader = reader();
    let found = take(
        &mut reader,
        &list("1767261600", r#""hex":"3c1a2b","lat":1.0,"lon":2.0"#),
    );
    let observation = found[0].1.observation.unwrap();
    assert_eq!((found[0].0, found[0].1.statement), (Origin::Own, None));
    assert_eq!((observation.velocity, observation.pressure_altitude_m), (None, None));
    assert_eq!(
        (observation.vertical_rate_mps, observation.quality),
        (None, Quality::Unstated)
    );
    assert_eq!(
        (observation.identity.callsign(), observation.identity.mode_3a()),
        (None, None)
    );
    let old = r#""hex":"3c1a2c","lat":1.0,"lon":2.0,"altitude":1000,"speed":100,"track":0,"vert_rate":640,"nucp":7"#;
    let found = take(&mut reader, &list("1767261600", old));
    let observation = found[0].1.observation.unwrap();
    near(observation.pressure_altitude_m, 304.8);
    near(observation.vertical_rate_mps, 3.2512);
    assert!(observation.velocity.is_some());
    let ground = r#""hex":"3c1a2d","lat":1.0,"lon":2.0,"alt_baro":"ground","alt_geom":300,"gs":0"#;
    let found = take(&mut reader, &list("1767261600", ground));
    let observation = found[0].1.observation.unwrap();
    assert!(observation.on_ground);
    assert_eq!(
        (observation.pressure_altitude_m, observation.ellipsoid_height_m),
        (None, None)
    );
    assert_eq!(observation.velocity, Some([0.0; 2]));
}

#[test]
fn altitude_and_velocity_are_not_used_with_an_old_position() {
    let mut reader = reader();
    for (latitude, age, seen, is_used) in [(1, "5.0", "0", true), (2, "5.1", "0", false), (3, "25", "20", true)] {
        let state = WHOLE.replace("\"seen_pos\":0.5", &format!("\"seen_pos\":{age}"));
        let state = state.replace("\"seen\":0.1", &format!("\"seen\":{seen}"));
        let state = state.replace("51.5", &format!("{latitude}.5"));
        let found = take(&mut reader, &list("1767261600", &state));
        let observation = found[0].1.observation.unwrap();
        assert_eq!(observation.velocity.is_some(), is_used, "{age}");
        assert_eq!(observation.pressure_altitude_m.is_some(), is_used, "{age}");
        assert_eq!(observation.identity.callsign(), Some("DLH9AB"));
    }
}

fn radius95(observation: &Observation) -> Option<f64> {
    match observation.quality {
        Quality::Radius95(radius_m) => Some(radius_m),
        _ => None,
    }
}

#[test]
fn integrity_decides_where_the_accuracy_is_missing() {
    for (categories, expected) in [
        ("", Quality::Unstated),
        (r#","nic":8,"sil":3,"nac_p":0"#, Quality::Unstated),
        (r#","nic":8,"sil":3"#, Quality::Unstated),
        (r#","nic":0,"sil":3"#, Quality::Unknown),
        (r#","nic":8,"sil":0,"nac_p":0"#, Quality::Unknown),
        (r#","nac_p":0,"sil":0"#, Quality::Unknown),
    ] {
        let state = format!(r#""hex":"3c1a2b","type":"adsb_icao","lat":1.0,"lon":2.0{categories}"#);
        let found = take(&mut reader(), &list("1767261600", &state));
        assert_eq!(found[0].1.observation.unwrap().quality, expected, "{categories}");
    }
}

#[test]
fn an_address_of_another_kind_is_another_track_without_an_address() {
    let mut reader = reader();
    let state = r#""hex":"~3c1a2b","type":"tisb_trackfile","lat":1.0,"lon":2.0,"nac_p":8"#;
    let found = take(&mut reader, &list("1767261600", state));
    let observation = found[0].1.observation.unwrap();
    assert_eq!(found[0].0, Origin::Traffic);
    assert_eq!(
        (observation.track_number, observation.identity.address()),
        (Some(0x13c_1a2b), None)
    );
    let state = r#""hex":"3c1a2b","type":"mlat","mlat":["lat","lon"],"lat":1.0,"lon":2.0,"nac_p":8"#;
    let found = take(&mut reader, &list("1767261600", state));
    let observation = found[0].1.observation.unwrap();
    assert_eq!(
        (found[0].0, observation.quality),
        (Origin::Multilateration, Quality::Unstated)
    );
    assert_eq!(observation.track_number, Some(0x3c_1a2b));
}

#[test]
fn a_wrong_value_refuses_its_state_and_no_other() {
    for (good, bad, words) in [
        ("\"3c1a2b\"", "\"3c1a2\"", ["hex \"3c1a2\"", "six hexadecimal digits"]),
        ("51.5", "91", ["lat \"91\"", "-90 to 90"]),
        ("\"lon\":-1.25,", "", ["lat without lon", "longitude"]),
        (":36000", ":200000", ["alt_baro \"200000\"", "126750"]),
        (":36000", ":\"sky\"", ["alt_baro \"sky\"", "ground"]),
        (":450.0", ":-1", ["gs \"-1\"", "6000"]),
        (":90.0", ":361", ["track \"361\"", "360"]),
        (":-64", ":40000", ["baro_rate \"40000\"", "32640"]),
        ("\"1000\"", "\"1800\"", ["squawk \"1800\"", "octal"]),
        ("DLH9AB  ", "DLH-9AB", ["flight \"DLH-9AB\"", "letters and digits"]),
        ("\"A3\"", "\"E3\"", ["category \"E3\"", "A0 to D7"]),
        ("seen_pos\":0.5", "seen_pos\":-1", ["seen_pos \"-1\"", "0 to 86400"]),
        (":450.0", ":[]", ["JSON", "invalid type"]),
    ] {
        let mut reader = reader();
        let state = WHOLE.replace(good, bad);
        let document = format!("{{\"now\":{NOW_S},\"aircraft\":[{{{state}}},[\"3c1a2b\"],{{{WHOLE}}}]}}");
        assert_eq!(take(&mut reader, &document).len(), 1, "{bad}");
        let counters = reader.counters();
        assert_eq!((counters.refused_states, counters.observations), (2, 1), "{bad}");
        is_whole(counters, 1);
        let mut reader = self::reader();
        take(&mut reader, &list(&NOW_S.to_string(), &state));
        let text = reader.refused().unwrap().to_string();
        assert!(words.iter().all(|words| text.contains(words)), "{text}");
    }
}

#[test]
fn wrong_documents_are_counted_by_reason() {
    let mut reader = reader();
    for (document, reason) in [
        ("", ReadsbReason::Json),
        ("{\"now\":1767261600,\"aircraft\":[", ReadsbReason::Json),
        ("[1767261600,[]]", ReadsbReason::Json),
        ("{\"now\":1767261600}", ReadsbReason::Kind),
        ("{\"aircraft\":[]}", ReadsbReason::Kind),
        ("{\"now\":-5,\"aircraft\":[]}", ReadsbReason::Time),
        ("{\"now\":1e300,\"hex\":\"3c1a2b\"}", ReadsbReason::Time),
        ("\u{1f}\u{8b}", ReadsbReason::Json),
    ] {
        let before = reader.counters().refused[reason as usize];
        assert_eq!(take(&mut reader, document), []);
        assert_eq!(reader.counters().refused[reason as usize], before + 1, "{document}");
    }
    reader.take(&vec![b' '; DOCUMENT_OCTETS_MAX + 1], |_, _| {});
    assert!(reader.refused().unwrap().to_string().contains("16777217"));
    is_whole(reader.counters(), 9);
    // Milliseconds, and the other name of the list.
    let found = take(
        &mut reader,
        r#"{"ac":[{"hex":"3c1a2b","lat":1,"lon":2}],"now":1767261600123}"#,
    );
    assert_eq!(found[0].1.time_ns, NOW_S * 1000 * MS + 123 * MS);
}

#[test]
fn a_trace_has_a_state_in_each_row() {
    let mut reader = reader();
    let trace = r#"{"icao":"3c1a2b","r":"D-ABCD","timestamp":1767261600.5,"trace":[
        [0.0,50.0,10.0,"ground",12.0,90.0,2,null,
         {"type":"adsb_icao","flight":"DLH1    ","squawk":"1000","nac_p":10,"category":"A3"}],
        [10.0,50.1,10.1,1000,120.0,90.0,0,640,null,"adsb_icao",1200,600,110,2.5],
        [20.0,50.2,10.2,2000,120.0,90.0,12,640,null,"mlat",null,null,null,null,"more"],
        [61.0,50.3,10.3,null,null,null,1,null,null],
        [-1,50.3,10.3,null,null,null,1,null,null]]}"#;
    let found = take(&mut reader, trace);
    let seconds: Vec<_> = found
        .iter()
        .map(|(_, message)| message.time_ns / MS - NOW_S * 1000)
        .collect();
    assert_eq!(seconds, [500, 10_500, 20_500, 61_500]);
    let origins: Vec<_> = found.iter().map(|(origin, _)| *origin).collect();
    assert_eq!(
        origins,
        [Origin::Own, Origin::Own, Origin::Multilateration, Origin::Own]
    );
    let [ground, climbing, geometric, late] = [0, 1, 2, 3].map(|row: usize| found[row].1.observation.unwrap());
    assert!(ground.on_ground && ground.velocity.is_none(), "a heading is no track");
    assert!(climbing.velocity.is_some() && !climbing.on_ground);
    near(climbing.pressure_altitude_m, 304.8);
    near(climbing.ellipsoid_height_m, 365.76);
    near(climbing.vertical_rate_mps, 3.2512);
    assert_eq!(
        (geometric.pressure_altitude_m, geometric.quality),
        (None, Quality::Unstated)
    );
    near(geometric.ellipsoid_height_m, 609.6);
    near(radius95(&climbing), 10.0_f64.hypot(2.447_746_8 * 5.09 / 12f64.sqrt()));
    assert_eq!(climbing.identity.callsign(), Some("DLH1"));
    assert_eq!(
        (late.identity.callsign(), late.quality),
        (None, Quality::Unstated),
        "too old"
    );
    let statements = found.iter().filter(|(_, message)| message.statement.is_some());
    assert_eq!((statements.count(), reader.counters().refused_states), (1, 1));
    is_whole(reader.counters(), 1);
}

#[test]
fn a_file_is_divided_into_its_documents() {
    let file = b"\n {\"a\":[\n1]}{\"b\":2}\n{\"c\":\nx}\n\"d\" 5";
    let parts: Vec<_> = documents(file)
        .map(|part| String::from_utf8_lossy(part).into_owned())
        .collect();
    assert_eq!(parts, ["{\"a\":[\n1]}", "{\"b\":2}", "{\"c\":", "x}", "\"d\"", "5"]);
    assert_eq!(documents(b" \n").count(), 0);
}

/// A history of a minute, a state in each line: two aircraft that alternate every second.
#[test]
fn lines_of_history_are_states() {
    const CASE: &str = "round4/text-kinds/history.jsonl";
    let Some(data) = recordings(CASE) else { return };
    let file = std::fs::read(data.join(CASE)).unwrap();
    let (mut reader, mut found, mut lines) = (reader(), Vec::new(), 0);
    for document in documents(&file) {
        lines += 1;
        reader.take(document, |origin, message| found.push((origin, message)));
    }
    let counters = reader.counters();
    is_whole(counters, lines);
    assert_eq!(
        (counters.documents, counters.states, counters.observations),
        (lines, lines, lines)
    );
    assert!(
        found
            .windows(2)
            .all(|pair| pair[1].1.time_ns - pair[0].1.time_ns == 1000 * MS)
    );
    assert!(
        found
            .iter()
            .all(|(_, message)| message.observation.unwrap().velocity.is_some())
    );
}
