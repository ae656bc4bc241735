//! Sources that end while others go on: their tracks leave the picture after the configured time.

use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::process::{ChildStdin, Stdio};
use std::thread;
use std::time::Duration;

use bus::{Bus, SharedMemory, Subscriber};
use messages::{SystemTrack, TrackState};
use runtime::clock::mono_ns;

use crate::common::{Folder, Home, PLACE, Running, S, free_address, until, utc_ns};
use crate::orders::ask;

/// Life of a track without reports, seconds.
const LIFE_S: i64 = 3;
/// Time between two reports.
const STEP: Duration = Duration::from_millis(200);

/// What feeds one of the two targets.
enum Feed {
    /// `koseki feed`, which ends with its standard input.
    Lines(Running, ChildStdin),
    /// The connection of a receiver, which closes.
    Receiver(TcpStream),
}

/// A deployment with an external source, a receiver of transponders, and the display.
struct Site {
    running: Running,
    display: String,
    tracks: Subscriber<SharedMemory, SystemTrack>,
    bus: Bus<SharedMemory>,
    /// States of the target since its feed began: their times, and their kinds.
    seen: Vec<(i64, u8)>,
    home: Home,
}

impl Site {
    fn start(receiver: &TcpListener) -> Self {
        let home = Home::new();
        let display = free_address().to_string();
        let [latitude, longitude] = PLACE;
        let text = format!(
            r#"name = "test"
frame = {{ latitude_deg = {latitude}, longitude_deg = {longitude} }}
recorder = {{ enabled = false }}
display = {{ listen = "{display}" }}
fusion = {{ life = {{ terminate_s = {LIFE_S}, tentative_s = 2 }} }}
receiver = [{{ name = "box", sbs = {{ connect = "{}" }} }}]
[[source]]
name = "own"
period_s = 0.2
external = {{}}
[[source]]
name = "base"
period_s = 0.2
live = {{ receiver = "box" }}
"#,
            receiver.local_addr().unwrap()
        );
        home.write("site.toml", text);
        let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        let bus = Bus::<SharedMemory>::open(&home.root("test"), "picture").unwrap();
        Self {
            running,
            display,
            tracks: bus.subscriber(&messages::system_tracks(), || mono_ns() as u64).unwrap(),
            bus,
            seen: Vec::new(),
            home,
        }
    }

    fn look(&mut self) {
        let seen = &mut self.seen;
        self.tracks
            .take(usize::MAX, |_, states| {
                seen.extend(states.iter().map(|state| (state.reference_time_ns, state.state)));
            })
            .unwrap();
    }

    fn has(&self, state: TrackState) -> bool {
        self.seen.iter().any(|(_, seen)| *seen == state as u8)
    }

    /// Tracks on the page.
    fn shown(&self) -> usize {
        let (status, tracks) = ask(&self.display, "GET /api/tracks.json", &[], "");
        assert_eq!(status, 200, "{tracks}");
        let tracks: serde_json::Value = serde_json::from_str(&tracks).unwrap();
        tracks["tracks"].as_array().unwrap().len()
    }

    /// Feeds a target until its track is confirmed and shown; returns the time of the last report.
    fn feed(&mut self, feed: &mut Feed) -> i64 {
        self.seen.clear();
        let mut sent_ns = 0;
        until("the track is confirmed and shown", || {
            sent_ns = utc_ns();
            let sent = match feed {
                Feed::Lines(_, input) => writeln!(
                    input,
                    "{{\"track\": 1, \"time_ns\": {sent_ns}, \"latitude\": {}, \"longitude\": {}, \"sigma_m\": 10}}",
                    PLACE[0] + 0.1,
                    PLACE[1]
                ),
                Feed::Receiver(stream) => stream.write_all(b"MSG,3,1,1,4CA2D6,1,,,,,,10000,,,41.5,2.3,,,0,0,0,0\r\n"),
            };
            sent.unwrap();
            thread::sleep(STEP);
            self.look();
            self.has(TrackState::Confirmed) && self.shown() == 1
        });
        sent_ns
    }
}

#[test]
fn tracks_of_a_feed_and_of_a_receiver_that_end_leave_output_and_page_in_the_stated_time() {
    let receiver = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut site = Site::start(&receiver);
    let mut command = site.home.command(&["feed", "--instance", "test", "--source", "own"]);
    let mut lines = site.home.start_command(command.stdin(Stdio::piped()));
    let input = lines.child.stdin.take().unwrap();
    let connection = receiver.accept().unwrap().0;
    for mut feed in [Feed::Lines(lines, input), Feed::Receiver(connection)] {
        let last_ns = site.feed(&mut feed);
        match feed {
            Feed::Lines(running, input) => {
                drop(input);
                let (status, said) = running.end();
                assert!(status.success(), "{said}");
            }
            Feed::Receiver(connection) => drop(connection),
        }
        until("the track is suspended", || {
            site.look();
            site.has(TrackState::Suspended)
        });
        let after_ns = site.seen.last().unwrap().0 - last_ns;
        // The receiver's reports have the time at which they came.
        assert!(
            (after_ns - LIFE_S * S).abs() < S / 2,
            "{after_ns} ns after the last report"
        );
        until("the page is empty", || site.shown() == 0);
    }
    let Site {
        running,
        tracks,
        bus,
        home,
        ..
    } = site;
    drop((tracks, bus));
    running.stop();
    home.assert_nothing_is_left("test");
}

/// Reports of a target each second, as the file of a sensor.
fn file(sensor: u32, north_m: f64, seconds: u32) -> String {
    let rows = (0..seconds).map(|second| {
        let east_m = 50 * second;
        format!("{second},{sensor},1,{east_m},{north_m},0,50,0,0,200,confirmed\n")
    });
    format!(
        "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,trace,state\n{}",
        rows.collect::<String>()
    )
}

#[test]
fn the_track_of_a_file_that_ends_before_another_ends_in_the_stated_time() {
    let settings = format!("[fusion.life]\nterminate_s = {LIFE_S}\n");
    let folder = Folder::with(&[
        ("short.csv", file(1, 0.0, 20)),
        ("long.csv", file(2, 30e3, 60)),
        ("settings.toml", settings),
    ]);
    folder.succeed("fuse --tracks short.csv long.csv --config settings.toml --refresh 1 --out fused.csv");
    let fused = folder.read("fused.csv");
    let last_s = |north: &str| -> f64 {
        let [times_s, norths] = ["time_s", "y"].map(|name| test_support::column(&fused, name));
        let mut rows = times_s.iter().zip(norths).filter(|(_, y)| y.starts_with(north));
        rows.next_back().unwrap().0.parse().unwrap()
    };
    let (short_s, long_s) = (last_s("0"), last_s("30000"));
    assert!((19.0..=19.0 + LIFE_S as f64).contains(&short_s), "{short_s}");
    assert!(long_s >= 59.0, "{long_s}");
}
