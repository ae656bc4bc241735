//! Tests of samples as events and for Foxglove, over real sockets.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use configuration::ConfigWith;
use messages::layout::Sample as _;
use messages::{Alarm, SystemTrack};
use serde_json::{Value, json};
use web::{ForeignPages, Guard, Server};

use crate::feed::{Feed, WAITING_MAX};
use crate::foxglove::FOXGLOVE;
use crate::moments::Moments;
use crate::pages::router;
use crate::pages::tests::{LONG, Socket, now, track, until};
use crate::settings::Keys;
use crate::settings::MapFiles;
use crate::shared::{Desk, SharedState};
use crate::world::World;

const SITE: &str = include_str!("../../../config/barcelona.toml");
const SDK: &str = "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n";

/// Server of a deployment's feed, and the place of the system tracks.
fn served() -> (Arc<SharedState>, Server, usize) {
    let config = ConfigWith::<Keys>::parse(Path::new("test.toml"), SITE, &[]).unwrap();
    let world = World::new("test", Vec::new(), 600, 1_000_000);
    let shared = SharedState::fed(world, MapFiles::default(), now, Feed::of(&config), Desk::default());
    let guard = Guard {
        foreign: Some(ForeignPages {
            path: FOXGLOVE,
            sites: vec!["https://app.example".to_owned()],
        }),
        ..Guard::default()
    };
    let server = Server::start(
        "pages",
        "127.0.0.1:0".parse().unwrap(),
        guard,
        router(Moments::of_deployment(Arc::clone(&shared))),
    )
    .unwrap();
    let place = shared.feed.place_of("system/tracks").unwrap();
    (shared, server, place)
}

/// Publishes a state of the track `number`.
fn publish(shared: &SharedState, place: usize, number: u32) {
    let octets = SystemTrack::octets(&[track(number, 1_000.0)]).to_vec();
    shared.feed.publish(place, &octets, now().utc_ns);
}

fn events(server: &Server, query: &str) -> BufReader<TcpStream> {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    write!(stream, "GET /api/events{query} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    BufReader::new(stream)
}

/// Returns the lines up to one with this beginning, and the rest of that line.
fn line(reader: &mut impl std::io::BufRead, beginning: &str) -> String {
    for line in reader.lines() {
        if let Some(rest) = line.unwrap().strip_prefix(beginning) {
            return rest.to_owned();
        }
    }
    panic!("the stream ends before a line with \"{beginning}\"");
}

#[test]
fn samples_are_events_with_the_names_of_the_fields() {
    let (shared, server, place) = served();
    let mut reader = events(&server, "?topics=tracks");
    let mut other = events(&server, "?topics=system%2Falarms");
    // The head is sent after the subscription.
    for reader in [&mut reader, &mut other] {
        assert_eq!(line(reader, "content-type: "), "text/event-stream");
    }
    let alarms = shared.feed.place_of("alarms").unwrap();
    shared.feed.publish(alarms, &vec![0; Alarm::LAYOUT.size], now().utc_ns);
    assert_eq!(line(&mut other, "event: "), "system/alarms");
    publish(&shared, place, 7);
    publish(&shared, place, 9);
    for number in [7, 9] {
        assert_eq!(line(&mut reader, "event: "), "tracks");
        let sample: Value = serde_json::from_str(&line(&mut reader, "data: ")).unwrap();
        assert_eq!(
            (&sample["track_number"], &sample["state"]),
            (&json!(number), &json!("confirmed"))
        );
        assert!(
            sample["latitude"].is_f64() && sample["contributions"][0]["source"].is_string(),
            "{sample}"
        );
    }
    assert_eq!(shared.audience().clients, 2);
    drop((reader, other));
    // A comment or a sample shows that the client has left.
    until("the seat is free", || {
        publish(&shared, place, 7);
        shared.feed.publish(alarms, &vec![0; Alarm::LAYOUT.size], now().utc_ns);
        shared.audience().clients == 0
    });
}

#[test]
fn an_unknown_topic_is_refused_with_the_known_ones() {
    let (_, server, _) = served();
    let mut answer = String::new();
    events(&server, "?topics=trakcs").read_to_string(&mut answer).unwrap();
    assert!(
        answer.starts_with("HTTP/1.1 404") && answer.contains("system/tracks, system/alarms"),
        "{answer}"
    );
}

#[test]
fn a_reader_that_falls_behind_is_dropped_and_counted() {
    let (shared, server, place) = served();
    let mut reader = events(&server, "");
    line(&mut reader, "content-type: ");
    let reading = std::thread::spawn(move || {
        while line(&mut reader, "event: ") != "lost" {}
        let lost: Value = serde_json::from_str(&line(&mut reader, "data: ")).unwrap();
        let mut rest = String::new();
        reader.read_to_string(&mut rest).unwrap();
        (lost, rest)
    });
    // Bytes are copied faster than text is made of them, so the reader is overtaken.
    let many = SystemTrack::octets(&[track(7, 0.0); 64]).to_vec();
    until("the reader is dropped", || {
        for _ in 0..2 * WAITING_MAX {
            shared.feed.publish(place, &many, now().utc_ns);
        }
        shared.traffic.refused.load(Ordering::Relaxed) == 1
    });
    let (lost, rest) = reading.join().unwrap();
    assert!(lost["slices"].as_u64() > Some(0), "{lost}");
    assert!(!rest.contains("event"), "{rest}");
    assert_eq!(shared.audience().clients, 0);
}

#[test]
fn foxglove_gets_the_samples_of_its_subscriptions_and_can_do_nothing_else() {
    let (shared, server, place) = served();
    let mut client = Socket::open_at(&server, FOXGLOVE, SDK).unwrap();
    let text = |client: &mut Socket| -> Value {
        let (code, octets) = client.receive().unwrap();
        assert_eq!(code, 1, "{octets:?}");
        serde_json::from_slice(&octets).unwrap()
    };
    assert_eq!(text(&mut client)["op"], "serverInfo");
    let channels = text(&mut client);
    let channel = &channels["channels"][place];
    assert_eq!(
        (&channel["topic"], &channel["encoding"]),
        (&json!("system/tracks"), &json!("cdr"))
    );
    assert_eq!(channel["schema"], SystemTrack::LAYOUT.ros2_schema());
    client.wish(&json!({"op": "subscribe", "subscriptions": [{"id": 5, "channelId": channel["id"]}]}));
    client.wish(&json!({"op": "subscribe", "subscriptions": [{"id": 6, "channelId": channel["id"]}]}));
    assert_eq!(text(&mut client)["level"], 2, "a channel has one subscription");
    client.wish(&json!({"op": "setParameters", "parameters": []}));
    assert_eq!(text(&mut client)["level"], 2, "the server only sends");
    publish(&shared, place, 7);
    let (code, octets) = client.receive().unwrap();
    let sample = [track(7, 1_000.0)];
    let expected = [
        &[1, 5, 0, 0, 0][..],
        &now().utc_ns.to_le_bytes(),
        &[0, 1, 0, 0],
        SystemTrack::octets(&sample),
    ];
    assert!((code, octets) == (2, expected.concat()));
    client.wish(&json!({"op": "unsubscribe", "subscriptionIds": [5]}));
    client.wish(&json!({"op": "subscribe", "subscriptions": [{"id": 6, "channelId": 9_999}]}));
    assert_eq!(text(&mut client)["level"], 2, "there is no such channel");
    publish(&shared, place, 8);
    client
        .wish(&json!({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": place}, {"id": 7, "channelId": 0}]}));
    assert_eq!(text(&mut client)["level"], 2, "no sample came between");
}

#[test]
fn foxglove_needs_a_subprotocol_and_a_known_site() {
    let (_, server, _) = served();
    let open = |path: &str, lines: &str| Socket::open_at(&server, path, lines).map(drop);
    let status = |path: &str, lines: &str| open(path, lines).unwrap_err()[..12].to_owned();
    assert_eq!(status(FOXGLOVE, ""), "HTTP/1.1 400");
    assert_eq!(status(FOXGLOVE, "Sec-WebSocket-Protocol: other\r\n"), "HTTP/1.1 400");
    assert_eq!(
        status(FOXGLOVE, &format!("{SDK}Origin: https://evil.example\r\n")),
        "HTTP/1.1 403"
    );
    assert_eq!(status("/ws", "Origin: https://app.example\r\n"), "HTTP/1.1 403");
    assert_eq!(open(FOXGLOVE, &format!("{SDK}Origin: https://app.example\r\n")), Ok(()));
    assert_eq!(open(FOXGLOVE, &format!("{SDK}Origin: http://localhost\r\n")), Ok(()));
    assert_eq!(
        open(FOXGLOVE, "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"),
        Ok(())
    );
}
