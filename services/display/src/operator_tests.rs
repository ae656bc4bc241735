//! Tests of what operators do besides orders, and of what guests see of it, over real sockets.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Arc;

use messages::{Alarm, AlarmEvent, AlarmSeverity, BatchHeader};
use serde_json::{Value, json};
use web::{Guard, Server, WriteAccess};

use crate::feed::Feed;
use crate::moments::Moments;
use crate::operator;
use crate::pages::router;
use crate::pages::tests::{LONG, now};
use crate::settings::MapFiles;
use crate::shared::{Desk, SharedState};
use crate::views::Views;
use crate::world::World;

const TOKEN: &str = "0perator-of-tests";

/// Server of a deployment with one standing alarm, whose views are kept in `folder`.
fn served(folder: &tempfile::TempDir) -> Server {
    let mut world = World::new("test", Vec::new(), 600, 1_000_000);
    let alarm = Alarm {
        time_ns: now().utc_ns,
        raised_ns: now().utc_ns,
        code: 1,
        severity: AlarmSeverity::Major as u8,
        event: AlarmEvent::Raised as u8,
        ..Alarm::default()
    };
    let header = BatchHeader {
        sent_ns: now().mono_ns,
        ..BatchHeader::default()
    };
    world.hear_alarms(&header, &[alarm.with_text("radar-north is silent.")]);
    let desk = Desk {
        has_operators: true,
        views: Views::open("theme=day", Some(folder.path().join("views.json"))).unwrap(),
    };
    let shared = SharedState::fed(world, MapFiles::default(), now, Feed::default(), desk);
    let guard = Guard {
        writer: Some(WriteAccess {
            token: TOKEN.to_owned(),
            paths: operator::PATHS,
            login: operator::LOGIN,
        }),
        ..Guard::default()
    };
    Server::start(
        "pages",
        "127.0.0.1:0".parse().unwrap(),
        guard,
        router(Moments::of_deployment(Arc::clone(&shared))),
    )
    .unwrap()
}

/// Returns status and body of the answer to a request; with a body, the request is a `POST` by an operator.
fn ask(server: &Server, path: &str, body: Option<&Value>) -> (u16, String) {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    let request = match body {
        Some(body) => {
            let body = body.to_string();
            let length = body.len();
            format!(
                "POST {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}\r\nContent-Type: \
                 application/json\r\nContent-Length: {length}\r\n\r\n{body}"
            )
        }
        None => format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"),
    };
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head[9..12].parse().unwrap(), body.to_owned())
}

fn read(server: &Server, path: &str) -> Value {
    serde_json::from_str(&ask(server, path, None).1).unwrap()
}

#[test]
fn everybody_sees_what_an_operator_has_done_about_an_alarm() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(&folder);
    let id = read(&server, "/api/alarms.json")["alarms"][0]["id"].clone();
    let act = |act: &str| json!({"alarm": id, "act": act, "operator": "anna", "for_s": 600});
    assert_eq!(ask(&server, operator::ALARM, Some(&act("acknowledge"))).0, 204);
    assert_eq!(ask(&server, operator::ALARM, Some(&act("shelve"))).0, 204);
    let seen = read(&server, "/api/alarms.json");
    let alarm = &seen["alarms"][0];
    assert_eq!(alarm["acknowledged"]["operator"], "anna");
    let until_s = now().utc_ns as f64 / 1e9 + 600.0;
    assert_eq!(alarm["shelved"], json!({"operator": "anna", "until_s": until_s}));
    let words: Vec<&Value> = seen["events"]
        .as_array()
        .unwrap()
        .iter()
        .map(|event| &event["event"])
        .collect();
    assert_eq!(words, ["shelved", "acknowledged", "raised"]);
    assert_eq!(seen["events"][2]["text"], "radar-north is silent.");
    assert_eq!(ask(&server, operator::ALARM, Some(&act("restore"))).0, 204);
    assert_eq!(
        read(&server, "/api/alarms.json")["alarms"][0]["acknowledged"],
        Value::Null
    );
}

#[test]
fn wrong_acts_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(&folder);
    let id = read(&server, "/api/alarms.json")["alarms"][0]["id"].clone();
    let cases = [
        (
            json!({"alarm": id, "act": "forget", "operator": "anna"}),
            "acknowledge, shelve or restore",
        ),
        (json!({"alarm": id, "act": "acknowledge"}), "operator must be a text"),
        (
            json!({"alarm": id, "act": "acknowledge", "operator": ""}),
            "operator must be a name",
        ),
        (
            json!({"alarm": "99/1/1/", "act": "acknowledge", "operator": "anna"}),
            "no longer stands",
        ),
        (
            json!({"alarm": "x", "act": "acknowledge", "operator": "anna"}),
            "There is no alarm x",
        ),
        (
            json!({"alarm": id, "act": "shelve", "operator": "anna"}),
            "between 1 and 86400",
        ),
        (
            json!({"alarm": id, "act": "shelve", "operator": "anna", "for_s": 1e9}),
            "between 1 and 86400",
        ),
    ];
    for (body, said) in cases {
        let (status, text) = ask(&server, operator::ALARM, Some(&body));
        assert!(status == 409 && text.contains(said), "{body}: {status} {text}");
    }
    assert_eq!(ask(&server, operator::ALARM, Some(&json!([1]))).0, 400);
    let long = json!({"alarm": "x".repeat(5000)});
    assert_eq!(ask(&server, operator::ALARM, Some(&long)).0, 415);
}

#[test]
fn guests_read_the_views_that_operators_keep() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(&folder);
    let view = json!({"name": "tower", "address": "#scale=20", "operator": "anna"});
    assert_eq!(ask(&server, operator::VIEWS, Some(&view)).0, 204);
    let views = read(&server, "/api/views.json");
    assert_eq!(views["start"], "theme=day");
    assert_eq!(
        views["views"],
        json!([{"name": "tower", "address": "scale=20", "operator": "anna"}])
    );
    let gone = json!({"name": "tower", "address": null, "operator": "anna"});
    assert_eq!(ask(&server, operator::VIEWS, Some(&gone)).0, 204);
    assert_eq!(read(&server, "/api/views.json")["views"], json!([]));
    let kinds = &read(&server, "/api/orders.json")["kinds"];
    let out = kinds
        .as_array()
        .unwrap()
        .iter()
        .find(|kind| kind["kind"] == "out")
        .unwrap();
    assert_eq!((&out["needs"], &out["lasts"]), (&json!(["source"]), &json!(true)));
}
