//! Once a socket is open, receiving and sending allocate nothing.

use std::time::Duration;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use net::{AllowedSenders, ReceiverSettings, SenderSettings, UdpReceiver, UdpSender};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn datagrams_are_received_and_sent_without_allocation() {
    let mut receiver = UdpReceiver::open(&ReceiverSettings {
        allowed_senders: AllowedSenders::parse(["192.0.2.0/24", "127.0.0.0/8"]).unwrap(),
        receive_buffer_octets: 8_192,
        ..ReceiverSettings::new("127.0.0.1".parse().unwrap(), 0)
    })
    .unwrap();
    let mut sender = UdpSender::open(&SenderSettings::new(receiver.local_address())).unwrap();
    let mut octets = 0;
    assert_no_alloc(|| {
        for _ in 0..50 {
            for length in [1, 1400, 0, 70_000, 100] {
                let _ = sender.send(&[0; 70_000][..length]);
            }
            let _ = receiver.receive(Duration::from_millis(1), |datagram| octets += datagram.bytes.len());
            let _ = receiver.receive(Duration::from_micros(1), |datagram| octets += datagram.bytes.len());
        }
    });
    assert_eq!(octets as u64, receiver.counters().octets);
    assert!(octets > 0 && sender.counters().failed == 50);
}
