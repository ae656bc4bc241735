//! The bare ports: what goes in comes out, in order, and the oldest gives way.

use std::time::Duration;

use bus::{BareReceiver, BareSender, BareSettings, Bus, Root, SharedMemory};
use messages::SensorTrack;

fn with_bus(test: impl FnOnce(&Bus<SharedMemory>)) {
    let base = tempfile::Builder::new().prefix("k").tempdir_in("/tmp").unwrap();
    let root = Root::in_base(base.path(), "bare").unwrap();
    let claim = root.claim().unwrap();
    let bus = Bus::open(&root, "both-ends").unwrap();
    test(&bus);
    drop(bus);
    claim.remove().unwrap();
}

fn track(track_number: u32) -> SensorTrack {
    SensorTrack {
        track_number,
        ..SensorTrack::default()
    }
}

#[test]
fn slices_arrive_whole_and_in_order_and_the_oldest_give_way() {
    with_bus(|bus| {
        let settings = BareSettings {
            depth: 4,
            slice_len: 3,
            events: false,
        };
        let receiver = BareReceiver::<SensorTrack>::open(bus, "bench/test", settings).unwrap();
        let sender = BareSender::<SensorTrack>::open(bus, "bench/test", settings).unwrap();
        assert!(!receiver.receive(|_: &[SensorTrack]| ()).unwrap());
        for slice in 0..6 {
            sender.send(3, |index| track(10 * slice + index as u32)).unwrap();
        }
        let mut numbers = Vec::new();
        while receiver
            .receive(|tracks| numbers.extend(tracks.iter().map(|track| track.track_number)))
            .unwrap()
        {}
        assert_eq!(numbers, [20, 21, 22, 30, 31, 32, 40, 41, 42, 50, 51, 52]);
        let too_long = sender.send(4, |_| track(0)).unwrap_err();
        assert!(too_long.to_string().contains("bench/test"), "{too_long}");
    });
}

#[test]
fn a_receiver_with_events_is_woken() {
    with_bus(|bus| {
        let settings = BareSettings {
            depth: 4,
            slice_len: 1,
            events: true,
        };
        let receiver = BareReceiver::<SensorTrack>::open(bus, "bench/test", settings).unwrap();
        let sender = BareSender::<SensorTrack>::open(bus, "bench/test", settings).unwrap();
        sender.send(1, |_| track(7)).unwrap();
        let mut number = None;
        while number.is_none() {
            receiver.wait(Duration::from_secs(60)).unwrap();
            receiver
                .receive(|tracks| number = Some(tracks[0].track_number))
                .unwrap();
        }
        assert_eq!(number, Some(7));
    });
}
