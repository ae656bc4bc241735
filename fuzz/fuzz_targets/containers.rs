//! Recordings: containers, and the selection of plausible records.
//!
//! The first byte forces a kind of container or leaves the choice to the content; the rest is the recording. Every
//! byte must be accounted for, and the content of all datagrams must be surveyed and read to the end.

#![no_main]

use formats::containers::{Container, Datagrams};
use formats::recording::RecordingBytes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let Some((&choice, bytes)) = input.split_first() else {
        return;
    };
    let container = Container::ALL
        .get(usize::from(choice))
        .copied()
        .unwrap_or_else(|| Container::detect(bytes));
    let mut datagrams = Datagrams::new(container, bytes);
    let octets: u64 = datagrams
        .by_ref()
        .flatten()
        .map(|datagram| datagram.bytes.len() as u64)
        .sum();
    let counts = *datagrams.counts();
    assert_eq!(octets, counts.datagram_octets);
    assert_eq!(
        counts.datagram_octets + counts.framing_octets + counts.octets_skipped,
        bytes.len() as u64,
        "{counts:?}"
    );
    let recording = RecordingBytes::new(bytes).in_container(container);
    let survey = recording.survey();
    let mut records = 0;
    let read: Result<(), ()> = recording.for_each(&survey, |_| {
        records += 1;
        Ok(())
    });
    assert!(read.is_ok() && records <= bytes.len());
});
