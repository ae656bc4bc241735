//! Documents of any octets, and of any values under the keys that are read.

use proptest::prelude::*;

use super::documents;
use super::tests::{is_whole, reader, take};

fn key() -> impl Strategy<Value = String> {
    prop::sample::select(vec![
        "now",
        "aircraft",
        "ac",
        "icao",
        "timestamp",
        "trace",
        "hex",
        "lat",
        "lon",
        "alt_baro",
        "gs",
        "track",
        "seen_pos",
        "seen",
        "flight",
        "squawk",
        "emergency",
        "category",
        "nac_p",
        "mlat",
        "type",
        "alert",
    ])
    .prop_map(|key| format!("\"{key}\""))
}

fn value() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        any::<f64>().prop_map(|number| serde_json::json!(number).to_string()),
        (-400i32..2_000_000_000).prop_map(|number| number.to_string()),
        prop::sample::select(vec![
            "null",
            "true",
            "1767261600",
            "\"3c1a2b\"",
            "\"~3c1a2b\"",
            "\"ground\"",
            "\"A1\"",
            "\"general\"",
            "[\"lat\"]",
        ])
        .prop_map(str::to_owned),
        any::<String>().prop_map(|text| serde_json::json!(text).to_string()),
    ];
    leaf.prop_recursive(4, 40, 12, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..12).prop_map(|values| format!("[{}]", values.join(","))),
            prop::collection::vec((key(), inner), 0..12).prop_map(|pairs| {
                let pairs: Vec<_> = pairs.into_iter().map(|(key, value)| format!("{key}:{value}")).collect();
                format!("{{{}}}", pairs.join(","))
            }),
        ]
    })
}

proptest! {
    #[test]
    fn any_octets_are_counted_once(file in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut reader = reader();
        let mut count = 0;
        for document in documents(&file) {
            count += 1;
            reader.take(document, |_, _| {});
        }
        is_whole(reader.counters(), count);
    }

    #[test]
    fn any_json_is_counted_once_and_gives_numbers_only(
        pairs in prop::collection::vec((key(), value()), 0..8),
        states in prop::collection::vec(value(), 0..4),
    ) {
        let mut reader = reader();
        let pairs: Vec<_> = pairs.into_iter().map(|(key, value)| format!("{key}:{value}")).collect();
        let documents = [
            format!("{{{}}}", pairs.join(",")),
            format!("{{\"now\":1767261600,\"aircraft\":[{}]}}", states.join(",")),
            format!("{{\"icao\":\"3c1a2b\",\"timestamp\":1767261600,\"trace\":[{}]}}", states.join(",")),
            format!("{{\"now\":1767261600,\"aircraft\":[{{\"hex\":\"3c1a2b\",{}}}]}}", pairs.join(",")),
        ];
        for document in &documents {
            for (_, message) in take(&mut reader, document) {
                prop_assert!(message.observation.is_some() || message.statement.is_some());
                let observation = message.observation.unwrap_or_default();
                let values = observation.geodetic.into_iter().chain(observation.velocity).flatten();
                prop_assert!(values.chain(observation.pressure_altitude_m).all(f64::is_finite));
            }
        }
        is_whole(reader.counters(), documents.len() as u64);
    }
}
