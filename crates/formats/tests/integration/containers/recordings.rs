//! Captures of real networks: how many datagrams they hold, from when to when, and that all of them are blocks.

use std::collections::BTreeMap;

use asterix::blocks;
use formats::containers::{Container, ContainerCounts, TimeStamp, datagrams};
use test_support::recording;

/// The counters, the data blocks of each category, and the first and the last time in ns.
fn describe(bytes: &[u8]) -> (ContainerCounts, BTreeMap<u8, usize>, [i64; 2]) {
    let mut source = datagrams(bytes);
    let (mut categories, mut times) = (BTreeMap::new(), Vec::new());
    for datagram in source.by_ref() {
        let datagram = datagram.unwrap();
        for block in blocks(&datagram.bytes) {
            *categories.entry(block.unwrap().category).or_default() += 1;
        }
        times.extend(datagram.time_stamp.map(TimeStamp::ns));
    }
    assert_eq!(times.len() as u64, source.counts().datagrams);
    (*source.counts(), categories, [times[0], times[times.len() - 1]])
}

fn expect(name: &str, datagrams: u64, categories: &[(u8, usize)], times: [i64; 2]) {
    let Some(bytes) = recording(name) else {
        return;
    };
    assert_eq!(Container::detect(&bytes), Container::Pcap);
    let (counts, found, span) = describe(&bytes);
    assert_eq!(counts.datagrams, datagrams);
    assert_eq!((counts.octets_skipped, counts.damages), (0, 0));
    assert_eq!(counts.datagram_octets + counts.framing_octets, bytes.len() as u64);
    assert_eq!(found.into_iter().collect::<Vec<_>>(), categories);
    assert_eq!(span, times);
}

#[test]
fn seven_radars() {
    expect(
        "cro/cat_034_048.pcap",
        100,
        &[(34, 34), (48, 86)],
        [1_462_433_756_508_910_000, 1_462_433_756_953_471_000],
    );
}

#[test]
fn system_tracks_of_an_older_edition() {
    expect(
        "cro/asterix.pcap",
        100,
        &[(62, 100)],
        [1_210_855_665_763_759_000, 1_210_855_674_965_378_000],
    );
}

#[test]
fn system_tracks_and_their_service() {
    let time = 1_393_332_227_401_501_000;
    expect("cro/cat_062_065.pcap", 1, &[(62, 1), (65, 1)], [time, time]);
}

#[test]
fn raw_recordings_are_recognised() {
    for name in ["akapetanovic/Jahorina.raw", "cro/cat048.raw", "cro/cat21_re.ast"] {
        let Some(bytes) = recording(name) else {
            return;
        };
        assert_eq!(Container::detect(&bytes), Container::Raw, "{name}");
    }
}
