//! JSON of transponder receivers, in a file of documents.
//!
//! Each document is counted once, each state of a document once, and no value is given that is not finite.

#![no_main]

use formats::readsb::{ReadsbReader, ReadsbSettings, documents};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| {
    let mut reader = ReadsbReader::new(ReadsbSettings { aircraft_max: 4 });
    let mut count = 0;
    for document in documents(file) {
        count += 1;
        reader.take(document, |_, message| {
            let observation = message.observation.unwrap_or_default();
            let pairs = observation.geodetic.into_iter().chain(observation.velocity).flatten();
            let heights = observation
                .pressure_altitude_m
                .into_iter()
                .chain(observation.ellipsoid_height_m);
            assert!(pairs.chain(heights).all(f64::is_finite));
        });
    }
    let counters = reader.counters();
    assert_eq!(counters.documents + counters.refused_documents, count);
    let given = counters.observations + counters.repetitions + counters.without_position;
    assert_eq!(given + counters.refused_states, counters.states);
});
