//! A direction finder on an aircraft that banks and turns: its bearings are from the bow, and the states of its
//! platform place them, live and in `koseki locate --platform` (EL-2, EL-11). A killed adapter continues with the same
//! fix.

use std::collections::BTreeMap;
use std::fs;
use std::net::{SocketAddr, UdpSocket};

use bus::{Bus, SharedMemory};
use messages::{SensorBearing, SensorTrack};
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::{Home, PLACE, free_address, kill, since_first_day_ns, until, utc_ns};

const EMITTER_M: [f64; 2] = [4e3, 3e3];
/// Circle of the aircraft: radius, and turn rate, radians per second.
const RADIUS_M: f64 = 13e3;
const TURN_RADPS: f64 = 0.015;
/// Right wing below the horizon, radians.
const ROLL_RAD: f64 = 0.4;
/// Standard deviations: of a bearing against the deck, of the heading and of the roll, radians; of the position,
/// metres.
const SIGMA_RAD: f64 = 0.002;
const ANGLE_SIGMA_RAD: f64 = 0.003;
const POSITION_SIGMA_M: f64 = 4.0;

/// The flight: what the aircraft sends, and all rows so far.
struct Flight {
    socket: UdpSocket,
    bearings_at: SocketAddr,
    states_at: SocketAddr,
    begun_ns: i64,
    sent_ns: i64,
    bearings: String,
    states: String,
}

const BEARINGS: &str = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n";
const STATES: &str = "time_s,px,py,pz,vx,vy,vz,heading_rad,pitch_rad,roll_rad,position_sigma_m,heading_sigma_rad,\
                      pitch_sigma_rad,roll_sigma_rad\n";

impl Flight {
    /// Seconds since midnight (UTC) of the first day.
    fn time_s(&self, time_ns: i64) -> String {
        let ns = since_first_day_ns(self.begun_ns, time_ns);
        format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
    }

    /// Place and heading at a time.
    fn at(&self, time_ns: i64) -> ([f64; 2], f64) {
        let heading_rad = TURN_RADPS * (time_ns - self.begun_ns) as f64 * 1e-9;
        let (sine, cosine) = heading_rad.sin_cos();
        ([RADIUS_M * (1.0 - cosine), RADIUS_M * sine], heading_rad)
    }

    /// Sends a bearing and the state of ten milliseconds later, if the last ones are so old.
    fn go_on(&mut self) {
        let now_ns = utc_ns() / 1_000_000 * 1_000_000;
        if now_ns - self.sent_ns < 20_000_000 {
            return;
        }
        self.sent_ns = now_ns;
        let ([east, north], heading_rad) = self.at(now_ns);
        let (sine, cosine) = heading_rad.sin_cos();
        let away = [EMITTER_M[0] - east, EMITTER_M[1] - north];
        let (ahead, right) = (away[0] * sine + away[1] * cosine, away[0] * cosine - away[1] * sine);
        let bearing_rad = (right * ROLL_RAD.cos()).atan2(ahead);
        // The stated place is none: the platform has it.
        let row = format!("{},4,{bearing_rad},{SIGMA_RAD},9e5,-9e5,0\n", self.time_s(now_ns));
        let state_ns = now_ns + 10_000_000;
        let ([east, north], heading_rad) = self.at(state_ns);
        let speed_mps = RADIUS_M * TURN_RADPS;
        let (sine, cosine) = heading_rad.sin_cos();
        let state = format!(
            "{},{east},{north},0,{},{},0,{heading_rad},0,{ROLL_RAD},{POSITION_SIGMA_M},{ANGLE_SIGMA_RAD},\
             {ANGLE_SIGMA_RAD},{ANGLE_SIGMA_RAD}\n",
            self.time_s(state_ns),
            speed_mps * sine,
            speed_mps * cosine
        );
        self.socket
            .send_to(format!("{BEARINGS}{row}").as_bytes(), self.bearings_at)
            .unwrap();
        self.socket
            .send_to(format!("{STATES}{state}").as_bytes(), self.states_at)
            .unwrap();
        self.bearings.push_str(&row);
        self.states.push_str(&state);
    }
}

fn off_m(place: [f64; 2]) -> f64 {
    (place[0] - EMITTER_M[0]).hypot(place[1] - EMITTER_M[1])
}

#[test]
fn the_platform_places_bearings_live_and_offline_and_a_killed_adapter_goes_on() {
    let home = Home::new();
    let (bearings_at, states_at) = (free_address(), free_address());
    let text = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n\
         [[receiver]]\nname = \"lan\"\n[receiver.udp]\nlisten = \"{bearings_at}\"\n\
         [[platform]]\nname = \"aircraft\"\n[platform.live]\nudp = {{ listen = \"{states_at}\" }}\n\
         [[source]]\nname = \"finder\"\nperiod_s = 0.1\nfresh_s = 3.0\n[source.live]\nreceiver = \"lan\"\n\
         [source.locator]\n[source.on_board]\nplatform = \"aircraft\"\n",
        PLACE[0], PLACE[1]
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    for name in ["lan", "aircraft"] {
        until("it runs", || home.status_row(name).state == "running");
    }
    let bus: Bus<SharedMemory> = Bus::open(&home.root("test"), "reader").unwrap();
    let open = || mono_ns() as u64;
    let mut located = bus.subscriber(&messages::sensor_tracks("finder"), open).unwrap();
    let mut carried = bus.subscriber(&messages::sensor_bearings("finder"), open).unwrap();
    let mut flight = Flight {
        socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
        bearings_at,
        states_at,
        begun_ns: utc_ns(),
        sent_ns: 0,
        bearings: BEARINGS.to_owned(),
        states: STATES.to_owned(),
    };
    let (mut latest, mut bearings): (Option<(u64, SensorTrack)>, Vec<SensorBearing>) = (None, Vec::new());
    let mut go_on =
        |flight: &mut Flight, latest: &mut Option<(u64, SensorTrack)>, bearings: &mut Vec<SensorBearing>| {
            flight.go_on();
            carried.take(256, |_, slice| bearings.extend_from_slice(slice)).unwrap();
            located
                .take(256, |header, slice| {
                    *latest = slice.last().map(|track| (header.incarnation, *track)).or(*latest)
                })
                .unwrap();
        };
    until("the emitter is located", || {
        go_on(&mut flight, &mut latest, &mut bearings);
        latest.is_some_and(|(_, track)| off_m([track.position_m[0], track.position_m[1]]) < 50.0)
            && bearings.len() > 150
    });
    placed_by_the_platform(&flight, &bearings);

    let (dead, before) = latest.unwrap();
    kill(home.status_row("lan").pid, Signal::KILL);
    until("the successor publishes", || {
        go_on(&mut flight, &mut latest, &mut bearings);
        latest.is_some_and(|(incarnation, _)| incarnation != dead)
    });
    let (_, after) = latest.unwrap();
    let variance_m2 = |track: &SensorTrack| track.covariance.get(0, 0) + track.covariance.get(1, 1);
    assert_eq!(after.track_number, before.track_number);
    assert!(variance_m2(&after) < 1.5 * variance_m2(&before), "the fixes are kept");
    drop((carried, located, bus));
    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
    located_again(&home, &flight);
}

/// Published bearings are from north, at the place of the platform, with the errors of both instruments.
fn placed_by_the_platform(flight: &Flight, bearings: &[SensorBearing]) {
    for bearing in bearings {
        let ([east, north], _) = flight.at(bearing.time_of_measurement_ns);
        let true_rad = (EMITTER_M[0] - east).atan2(EMITTER_M[1] - north);
        assert!((bearing.bearing_rad - true_rad).sin().abs() < 1e-4, "{bearing:?}");
        assert!((bearing.platform_m[0] - east).hypot(bearing.platform_m[1] - north) < 1.0);
        assert!(
            bearing.sigma_rad > SIGMA_RAD.hypot(0.9 * ANGLE_SIGMA_RAD) && bearing.sigma_rad < 0.02,
            "{bearing:?}"
        );
    }
}

/// `koseki locate` makes the published tracks of the recorded bearings, to the last digit, and of the bearings as sent
/// with the states of the platform, to the metre.
fn located_again(home: &Home, flight: &Flight) {
    fs::write(home.path("sent.csv"), &flight.bearings).unwrap();
    fs::write(home.path("states.csv"), &flight.states).unwrap();
    let locate = |arguments: &[&str]| {
        let output = home.run(&[&["locate", "--out", "again.csv"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        rows(home, "again.csv", &[0, 2, 3])
    };
    let published = rows(home, "out/latest/sensor_tracks_finder.csv", &[0, 3, 4]);
    assert!(published.len() > 100, "{} tracks", published.len());
    let recorded = locate(&["--bearings", "out/latest/bearings_finder.csv"]);
    for (time, place) in &published {
        assert_eq!(recorded.get(time), Some(place), "at {time}");
    }
    let sent = locate(&["--bearings", "sent.csv", "--platform", "states.csv"]);
    // Until the kill: the bearings that have come to no adapter change what follows.
    for (time, place) in published.iter().take(100) {
        let again = sent.get(time).expect("a fix of every bearing");
        let apart = [0, 1].map(|axis| again[axis].parse::<f64>().unwrap() - place[axis].parse::<f64>().unwrap());
        assert!(apart[0].hypot(apart[1]) < 1.0, "{apart:?} m apart at {time}");
    }
}

/// Places by time.
fn rows(home: &Home, name: &str, [time, east, north]: &[usize; 3]) -> BTreeMap<String, [String; 2]> {
    let text = fs::read_to_string(home.path(name)).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (
            cells[*time].to_owned(),
            [cells[*east].to_owned(), cells[*north].to_owned()],
        )
    };
    text.lines().skip(1).map(row).collect()
}
