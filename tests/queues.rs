//! The longest queue of a reader of the system tracks, as configured.

use std::fs;

use bus::{Bus, BusError, SharedMemory};

use crate::common::{Home, PLACE};

/// A deployment that permits queues of `length` slices.
fn site(length: usize) -> String {
    let [latitude, longitude] = PLACE;
    format!(
        "name = \"t\"\n[frame]\nlatitude_deg = {latitude}\nlongitude_deg = {longitude}\n[[source]]\nname = \"own\"\n\
         [source.external]\n[machine]\nqueue_slices = {length}\n[recorder]\nenabled = false\n[display]\nlisten = \"off\"\n"
    )
}

#[test]
fn a_deployment_permits_the_configured_queue_and_no_longer_one() {
    const LENGTH: usize = 1000;
    let home = Home::new();
    fs::write(home.path("site.toml"), site(LENGTH)).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "reader").unwrap();
    let limit = |topic: &messages::Topic<messages::SystemTrack>| {
        let refused = bus.subscriber_with_queue(topic, usize::MAX, || 0).unwrap_err();
        let BusError::Queue { limit, .. } = refused else {
            panic!("{refused}")
        };
        limit
    };
    let topic = messages::system_tracks();
    assert_eq!(limit(&topic), LENGTH);
    assert!(bus.subscriber_with_queue(&topic, LENGTH, || 0).is_ok());
    drop(bus);
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
}
