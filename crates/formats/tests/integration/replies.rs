//! Columns of transponders' replies in files of detections.

use formats::detections_csv::{DetectionReader, DetectionWriter, RepliedDetection, RepliedDetectionWriter};
use messages::{Identity, IdentityAges};
use observations::{Detection, DetectionKind, DetectionPlatform, TransponderReply};
use proptest::prelude::*;

const HEADER: &str = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz,truth_id";
const ROW: &str = "2,1,1,7,position2,1,2,,,5,5,,,0,0,0,3";

fn read(columns: &str, values: &str) -> Result<Detection, String> {
    let text = format!("{HEADER},{columns}\n{ROW},{values}\n");
    let mut reader = DetectionReader::new(text.as_bytes(), 0).map_err(|error| error.to_string())?;
    reader.next().unwrap().map_err(|error| error.to_string())
}

#[test]
fn replies_are_read_from_any_of_their_columns() {
    let found = read("address,mode_3a,callsign,level", "4ca7b3,4213,RYR48CP,360.25")
        .unwrap()
        .reply;
    let identity = Identity::default().with_address(0x4c_a7b3).with_mode_3a(0o4213);
    assert_eq!(found.identity, identity.with_callsign(*b"RYR48CP "));
    assert_eq!((found.level, found.ages), (Some(1441), IdentityAges::default()));
    let ship = read("mmsi,address_age_s", "211234560,2.5").unwrap().reply;
    assert_eq!((ship.identity.mmsi(), ship.ages.address_ms), (Some(211_234_560), 2500));
    assert_eq!(read("address,level", ",").unwrap().reply, TransponderReply::default());
}

#[test]
fn what_no_transponder_states_is_refused() {
    for (columns, values, expected) in [
        ("address", "XYZ", "column address: \"XYZ\" is not an address"),
        ("mode_3a", "4218", "column mode_3a: \"4218\" is not a Mode 3/A code"),
        (
            "address,mmsi",
            "4CA7B3,211234560",
            "column mmsi: \"211234560\" stands beside an address",
        ),
        ("callsign", "TOO LONG A NAME", "is no callsign"),
        ("level", "9000", "is no flight level"),
        ("level,level_age_s", "300,-1", "is no age"),
    ] {
        let error = read(columns, values).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

fn reply() -> impl Strategy<Value = TransponderReply> {
    let number = prop_oneof![
        Just(Identity::default()),
        (0u32..1 << 24).prop_map(|address| Identity::default().with_address(address)),
        (0u32..1_000_000_000).prop_map(|mmsi| Identity::default().with_mmsi(mmsi)),
    ];
    let others = (prop::option::of(0u16..4096), prop::option::of("[A-Z0-9]{1,8}"));
    let ages = prop::array::uniform4(0u32..4_000_000);
    let others = (others.0, others.1, prop::option::of("[A-Z]{1,9}( [A-Z0-9]{1,9})?"));
    (number, others, prop::option::of(any::<i16>()), ages).prop_map(
        |(mut identity, (code, callsign, name), level, ages)| {
            if let Some(name) = name {
                identity = identity.with_name(&name);
            }
            if let Some(code) = code {
                identity = identity.with_mode_3a(code);
            }
            if let Some(callsign) = callsign {
                let padded = format!("{callsign:8}");
                identity = identity.with_callsign(padded.as_bytes().try_into().unwrap());
            }
            TransponderReply {
                identity,
                ages: IdentityAges {
                    address_ms: ages[0],
                    mode_3a_ms: ages[1],
                    callsign_ms: ages[2],
                },
                level,
                level_age_ms: ages[3],
            }
        },
    )
}

proptest! {
    #[test]
    fn replies_are_read_as_they_were_written(replies in prop::collection::vec(reply(), 1..8)) {
        let detection = |reply| Detection {
            time_of_measurement_ns: 2_000_000_000,
            sensor_id: 1,
            scan: 1,
            detection_id: 7,
            kind: DetectionKind::Position2,
            values: [1.0, 2.0, 0.0],
            range_rate_mps: None,
            sigmas: Some([5.0, 5.0, 0.0, 0.0]),
            platform_m: [0.0; 3],
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply,
            truth: None,
        };
        let detections: Vec<_> = replies.into_iter().map(detection).collect();
        let mut writer = RepliedDetectionWriter::begin(Vec::new(), 0).unwrap();
        let mut plain = DetectionWriter::begin(Vec::new(), 0).unwrap();
        for detection in &detections {
            writer.write(&RepliedDetection(*detection)).unwrap();
            plain.write(detection).unwrap();
        }
        let text = writer.into_inner();
        let found: Vec<_> = DetectionReader::new(&text[..], 0).unwrap().map(Result::unwrap).collect();
        prop_assert_eq!(found, detections);
        // The other columns stand before, as without replies.
        let (text, plain) = (String::from_utf8(text).unwrap(), String::from_utf8(plain.into_inner()).unwrap());
        for (line, before) in text.lines().zip(plain.lines()) {
            prop_assert!(line.starts_with(&format!("{before},")), "{}", line);
        }
    }
}
