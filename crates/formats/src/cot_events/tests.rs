//! Streams of events.

use messages::TrackState;
use observations::{Quality, TargetCategory};
use proptest::prelude::*;

use super::*;
use crate::target_message::{TargetMessage, number_of_name};

const MS: i64 = 1_000_000;
/// 2026-11-30 09:00:00 UTC.
const TIME_S: i64 = 1_796_029_200;

const EVENT: &str = r#"<event version="2.0" uid="ANDROID-1" type="a-f-A-M-F-Q" how="m-g" time="2026-11-30T09:00:00Z"
    start="2026-11-30T09:00:00.25Z" stale="2026-11-30T09:01:00Z"><point lat="52.0" lon="13.0" hae="120.5" ce="4.0"
    le="9999999.0"/><detail><contact callsign="EAGLE1"/><track course="90.0" speed="20.0" slope="45"/><remarks>x &amp;
    y</remarks></detail></event>"#;

fn reader() -> CotReader {
    CotReader::new(CotSettings { things_max: 4 })
}

fn take(reader: &mut CotReader, text: &str) -> Vec<TargetMessage> {
    let mut found = Vec::new();
    reader.take(text.as_bytes(), |message| found.push(message));
    found
}

fn is_whole(counters: &CotCounters) {
    let ways = [
        counters.observations,
        counters.repetitions,
        counters.without_position,
        counters.others,
    ];
    let refused: u64 = counters.refused.iter().sum();
    assert_eq!(ways.iter().sum::<u64>() + refused, counters.events);
}

#[test]
fn an_event_has_all_values() {
    let mut reader = reader();
    let declared = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{EVENT}");
    let found = take(&mut reader, &declared);
    let [message] = found[..] else {
        panic!("{found:?} {:?}", reader.refused())
    };
    assert_eq!(message.time_ns, TIME_S * 1000 * MS + 250 * MS);
    let observation = message.observation.unwrap();
    assert_eq!(observation.time_of_day_ns, Some(9 * 3600 * 1000 * MS + 250 * MS));
    assert_eq!(observation.track_number, Some(number_of_name(b"ANDROID-1")));
    assert_eq!(observation.geodetic, Some([52.0f64.to_radians(), 13.0f64.to_radians()]));
    assert_eq!(
        (observation.ellipsoid_height_m, observation.pressure_altitude_m),
        (Some(120.5), None)
    );
    assert_eq!(observation.quality, Quality::Covariance([16.0, 0.0, 16.0]));
    assert_eq!(observation.identity.callsign(), Some("EAGLE1"));
    let [east, north] = observation.velocity.unwrap();
    assert!((east - 20.0).abs() < 1e-9 && north.abs() < 1e-9);
    assert!((observation.vertical_rate_mps.unwrap() - 20.0).abs() < 1e-9);
    assert_eq!(
        (observation.state, observation.on_ground),
        (TrackState::Confirmed, false)
    );
    assert!(!observation.test);
    let statement = message.statement.unwrap();
    assert_eq!(statement.category, TargetCategory::Unmanned);
    assert_eq!(Some(statement.track_number), observation.track_number);
    assert_eq!(take(&mut reader, EVENT), [], "the same again");
    let counters = reader.counters();
    assert_eq!(
        (counters.events, counters.observations, counters.repetitions),
        (2, 1, 1)
    );
    assert_eq!(reader.octets_between(), 39);
    is_whole(counters);
}

#[test]
fn unknown_values_are_unknown() {
    let mut reader = reader();
    let event = EVENT
        .replace("120.5", "9999999")
        .replace("ce=\"4.0\"", "ce=\"9999999.0\"")
        .replace("speed=\"20.0\"", "speed=\"-1\"")
        .replace("slope=\"45\"", "slope=\"NaN\"");
    let observation = take(&mut reader, &event)[0].observation.unwrap();
    assert_eq!(
        (observation.ellipsoid_height_m, observation.quality),
        (None, Quality::Unstated)
    );
    assert_eq!((observation.velocity, observation.vertical_rate_mps), (None, None));
    // Of TAK's binary form, and no error at all.
    let event = EVENT
        .replace("120.5", "999999")
        .replace("ce=\"4.0\"", "ce=\"0\"")
        .replace("uid=\"A", "uid=\"B");
    let observation = take(&mut reader, &event)[0].observation.unwrap();
    assert_eq!(
        (observation.ellipsoid_height_m, observation.quality),
        (None, Quality::Unstated)
    );
    // A phone without a fix.
    let event = EVENT
        .replace("52.0", "0.0")
        .replace("13.0", "0.0")
        .replace("ce=\"4.0\"", "ce=\"9999999\"")
        .replace("uid=\"A", "uid=\"C");
    let found = take(&mut reader, &event);
    assert_eq!((found[0].observation, reader.counters().without_position), (None, 1));
    is_whole(reader.counters());
}

#[test]
fn an_event_without_details_is_a_place() {
    let mut reader = reader();
    let event = "<event uid='1' type='a-u-G' time='2026-11-30T10:00:00+01:00' start='2026-11-30T10:00:00+01:00' \
                 stale='2026-11-30T10:00:00+01:00' how='m-s'>\
                 <point lat='1' lon='2' hae='3' ce='1' le='1'></point></event >";
    let found = take(&mut reader, event);
    let observation = found[0].observation.unwrap();
    assert_eq!((found[0].time_ns, found[0].statement), (TIME_S * 1000 * MS, None));
    assert!(observation.on_ground && observation.test && observation.velocity.is_none());
    assert_eq!(observation.state, TrackState::Terminated);
    assert_eq!(
        (observation.identity.name(), observation.identity.callsign()),
        (None, None)
    );
    assert_eq!(take(&mut reader, event).len(), 1, "an end is always given");
    // A name that is no call sign, of a ship.
    let event = EVENT
        .replace("a-f-A-M-F-Q", "a-f-S-X-M")
        .replace("EAGLE1", "Sea &lt;Eagle&gt; No. 1 of Kiel");
    let observation = take(&mut reader, &event)[0].observation.unwrap();
    assert_eq!(observation.identity.name(), Some("Sea <Eagle> No. 1 of"));
    // A track of another place than the details is none of the thing.
    let event = EVENT
        .replace("<detail>", "<x>")
        .replace("</detail>", "</x>")
        .replace("uid=\"A", "uid=\"D");
    assert_eq!(take(&mut reader, &event)[0].observation.unwrap().velocity, None);
    is_whole(reader.counters());
}

#[test]
fn events_of_other_kinds_are_counted_and_wrong_ones_refused_with_the_value() {
    let mut reader = reader();
    for kind in ["b-m-p-s-m", "t-x-c-t", "u-d-f"] {
        assert_eq!(take(&mut reader, &EVENT.replace("a-f-A-M-F-Q", kind)), []);
    }
    assert_eq!(reader.counters().others, 3);
    let long = format!("<event uid=\"{}", "x".repeat(EVENT_OCTETS_MAX));
    let many: String = (0..70).map(|number| format!(" x{number}=\"\"")).collect();
    for (good, bad, words) in [
        ("version=\"2.0\"", "version=\"1.1\"", ["version \"1.1\"", "from 2.0 on"]),
        ("uid=\"ANDROID-1\"", "", ["uid \"\"", "is missing"]),
        ("type=\"a-f-A-M-F-Q\"", "type=\"\"", ["type \"\"", "is missing"]),
        (
            "09:00:00.25Z",
            "09:00:00",
            ["start \"2026-11-30T09:00:00\"", "with a zone"],
        ),
        (
            "2026-11-30T09:00:00.25Z",
            "1826-11-30T09:00:00Z",
            ["start \"1826", "date and time"],
        ),
        ("09:01:00Z", "25:01:00Z", ["stale \"2026-11-30T25", "date and time"]),
        ("52.0", "91", ["lat \"91\"", "-90 to 90"]),
        ("lon=\"13.0\"", "", ["lon \"\"", "-180 to 180"]),
        ("52.0", "NaN", ["lat \"NaN\"", "-90 to 90"]),
        ("120.5", "-13000", ["hae \"-13000\"", "ellipsoid"]),
        ("ce=\"4.0\"", "ce=\"-4\"", ["ce \"-4\"", "9999999"]),
        ("le=\"9999999.0\"", "le=\"x\"", ["le \"x\"", "9999999"]),
        ("90.0", "370", ["course \"370\"", "360"]),
        ("speed=\"20.0\"", "speed=\"-2\"", ["speed \"-2\"", "12000"]),
        (
            "/><detail>",
            "/><!DOCTYPE a [<!ENTITY b \"c\">]><detail>",
            ["document type", "XML"],
        ),
        ("EAGLE1", "&eagle;", ["XML", "eagle"]),
        ("</detail>", "</details>", ["XML", "`</details>` was found"]),
        ("</detail>", "", ["XML", "expected `</detail>`"]),
        ("uid=", "uid=\"1\" uid=", ["XML", "duplicate"]),
        (" how=", &format!("{many} how="), ["XML", "too many attributes"]),
        ("<event", &long, ["event \"<event uid", "65536"]),
        ("<event", "<event ><event", ["event \"<event >\"", "was cut"]),
    ] {
        let mut reader = self::reader();
        take(&mut reader, &EVENT.replacen(good, bad, 1));
        let text = reader.refused().map(ToString::to_string).unwrap_or_default();
        let is_named = words.iter().all(|words| text.contains(words));
        assert!(is_named, "{bad}: {text}");
        is_whole(reader.counters());
    }
    let mut octets = EVENT.as_bytes().to_vec();
    octets[20] = 0xff;
    reader.take(&octets, |_| {});
    assert!(
        reader
            .refused()
            .unwrap()
            .to_string()
            .contains("octet \"20\" is not UTF-8")
    );
    reader.take(&EVENT.as_bytes()[..100], |_| {});
    reader.end();
    assert_eq!(reader.counters().refused[CotReason::Partial as usize], 1);
    is_whole(reader.counters());
}

#[test]
fn a_full_table_refuses_further_things() {
    let mut reader = reader();
    for number in 0..6 {
        take(&mut reader, &EVENT.replace("ANDROID-1", &number.to_string()));
    }
    let counters = reader.counters();
    assert_eq!(
        (counters.observations, counters.refused[CotReason::Room as usize]),
        (4, 2)
    );
    is_whole(counters);
}

/// Pieces that events consist of, and some octets.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let pieces = EVENT
        .split_inclusive([' ', '>', '"'])
        .map(|piece| piece.as_bytes().to_vec());
    prop_oneof![
        6 => prop::sample::select(pieces.collect::<Vec<_>>()),
        1 => prop::collection::vec(any::<u8>(), 0..9),
        1 => prop::sample::select(vec![
            "<event ", "</event>", "<![CDATA[", "]]>", "<!--", "-->", "<!DOCTYPE x>", "&#x0;", "1e999",
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
        2 => Just(EVENT.as_bytes().to_vec()),
    ]
}

proptest! {
    #[test]
    fn any_pieces_are_counted_once_wherever_the_stream_is_divided(
        pieces in prop::collection::vec(piece(), 0..60),
        cut in any::<prop::sample::Index>(),
    ) {
        let octets = pieces.concat();
        let cut = cut.index(octets.len() + 1);
        let (mut whole, mut divided) = (reader(), reader());
        let (mut found, mut parts) = (Vec::new(), Vec::new());
        whole.take(&octets, |message| found.push(message));
        whole.end();
        divided.take(&octets[..cut], |message| parts.push(message));
        divided.take(&octets[cut..], |message| parts.push(message));
        divided.end();
        prop_assert_eq!(&found, &parts);
        prop_assert_eq!(whole.counters(), divided.counters());
        is_whole(whole.counters());
    }

    /// A replaced value is refused, or gives numbers.
    #[test]
    fn any_values_give_numbers_only(place in 0usize..18, value in "[0-9eE.+a-zA-Z:-]{0,24}", number in any::<f64>()) {
        for value in [value.clone(), number.to_string()] {
            let mut quoted = EVENT.split('"').map(str::to_owned).collect::<Vec<_>>();
            let index = ((2 * place + 1) % (quoted.len() - 1)) | 1;
            quoted[index] = value;
            let mut reader = reader();
            for message in take(&mut reader, &quoted.join("\"")) {
                let observation = message.observation.unwrap_or_default();
                let values = observation.geodetic.into_iter().chain(observation.velocity).flatten();
                let heights = observation.ellipsoid_height_m.into_iter().chain(observation.vertical_rate_mps);
                prop_assert!(values.chain(heights).all(f64::is_finite));
            }
            is_whole(reader.counters());
        }
    }
}
