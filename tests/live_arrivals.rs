//! Arrival times, bearings and fixes of others in a running deployment: one source locates from all of them, publishes
//! each kind on its topic, and the recorded tables give the same fixes again (EL-12, FM-7).

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::net::UdpSocket;

use bus::{Bus, SharedMemory};
use messages::{SensorArrival, SensorFix, SensorTrack};
use runtime::clock::mono_ns;

use crate::common::{Home, PLACE, free_address, until, utc_ns};

const C: f64 = 299_792_458.0;
const EMITTER_M: [f64; 2] = [3e3, -4e3];
const REFERENCE_M: [f64; 2] = [-1e3, 500.0];
/// Receivers, and how far their clocks are ahead, seconds.
const RECEIVERS: [(&str, [f64; 2], f64); 4] = [
    ("south-west", [-10e3, -10e3], 0.0),
    ("south-east", [10e3, -10e3], 2e-6),
    ("north-east", [10e3, 10e3], -3e-6),
    ("north-west", [-10e3, 10e3], 5e-6),
];

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// Seconds since midnight (UTC), `later_ms` from now, to the millisecond.
fn time_s(now_ns: i64, later_ms: i64) -> f64 {
    let ms = now_ns / 1_000_000 + later_ms;
    ms.rem_euclid(86_400_000) as f64 / 1e3
}

/// Tables of one look: arrivals of a reference emitter, of the emitter, a bearing, and a fix, each some milliseconds
/// after the one before.
fn tables(now_ns: i64) -> [String; 3] {
    let mut arrivals =
        "time_s,emitter_id,kind,receiver,t_s,sigma_s,px,py,pz,reference_x,reference_y,reference_z\n".to_owned();
    for (number, (emitter, place, known)) in [(9, REFERENCE_M, "-1000,500,0"), (4, EMITTER_M, ",,")]
        .into_iter()
        .enumerate()
    {
        let sent_s = time_s(now_ns, 3 * number as i64);
        for (name, at, ahead_s) in RECEIVERS {
            let t_s = sent_s + distance(at, place) / C + ahead_s;
            writeln!(
                arrivals,
                "{sent_s:.3},{emitter},toa,{name},{t_s:.12},5e-8,{},{},0,{known}",
                at[0], at[1]
            )
            .unwrap();
        }
    }
    let at = [20e3, -5e3];
    let bearing_rad = (EMITTER_M[0] - at[0]).atan2(EMITTER_M[1] - at[1]);
    let heard_s = time_s(now_ns, 6);
    let bearings = format!(
        "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n{heard_s:.3},4,{bearing_rad},0.002,{},{},0\n",
        at[0], at[1]
    );
    let found_s = time_s(now_ns, 9);
    let fixes = format!("time_s,emitter_id,x,y,z,Pxx,Pxy,Pyy\n{found_s:.3},4,3010,-4020,0,2500,300,1600\n");
    [arrivals, bearings, fixes]
}

#[test]
fn a_recorded_source_of_arrivals_bearings_and_fixes_is_located_again() {
    let (home, to) = (Home::new(), free_address());
    let text = format!(
        "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n[[receiver]]\nname = \"lan\"\n\
         [receiver.udp]\n\
         listen = \"{to}\"\n[[source]]\nname = \"net\"\nperiod_s = 0.1\nfresh_s = 3.0\n[source.live]\n\
         receiver = \"lan\"\n\
         [source.locator.arrivals]\nclocks = \"estimated\"\n[recorder]\nformat = [\"csv\", \"mcap\"]\n",
        PLACE[0], PLACE[1]
    );
    fs::write(home.path("site.toml"), text).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    until("the adapter listens", || home.status_row("lan").state == "running");
    let bus: Bus<SharedMemory> = Bus::open(&home.root("test"), "reader").unwrap();
    let open = || mono_ns() as u64;
    let mut located = bus.subscriber(&messages::sensor_tracks("net"), open).unwrap();
    let mut arrivals = bus.subscriber(&messages::sensor_arrivals("net"), open).unwrap();
    let mut fixes = bus.subscriber(&messages::sensor_fixes("net"), open).unwrap();

    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut sent_ns = 0;
    let (mut tracks, mut times, mut places) = (
        Vec::<SensorTrack>::new(),
        Vec::<SensorArrival>::new(),
        Vec::<SensorFix>::new(),
    );
    until("the emitter is located often enough", || {
        if utc_ns() - sent_ns > 20_000_000 {
            sent_ns = utc_ns();
            for table in tables(sent_ns) {
                socket.send_to(table.as_bytes(), to).unwrap();
            }
        }
        located.take(256, |_, slice| tracks.extend_from_slice(slice)).unwrap();
        arrivals.take(256, |_, slice| times.extend_from_slice(slice)).unwrap();
        fixes.take(256, |_, slice| places.extend_from_slice(slice)).unwrap();
        tracks.len() > 100 && times.len() > 200 && places.len() > 20
    });
    let last = tracks.last().unwrap();
    let off_m = distance([last.position_m[0], last.position_m[1]], EMITTER_M);
    assert!(off_m < 30.0, "{off_m} m off");
    assert_eq!(places[0].position_m[..2], [3010.0, -4020.0]);
    drop((located, arrivals, fixes, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
    located_again(&home, [times.len(), places.len()]);
}

/// `koseki locate` makes the published tracks of the recorded tables, to the last digit.
fn located_again(home: &Home, received: [usize; 2]) {
    let rows = |name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(home.path(name)).unwrap();
        let cells = |line: &str| line.split(',').map(str::to_owned).collect();
        text.lines().skip(1).map(cells).collect()
    };
    let folder = "out/latest";
    let tables = ["arrivals", "bearings", "fixes"].map(|kind| format!("{folder}/{kind}_net.csv"));
    for (table, received) in [&tables[0], &tables[2]].into_iter().zip(received) {
        assert!(
            rows(table).len() >= received,
            "{table} has less than a reader has received"
        );
    }
    let [arrivals, bearings, fixes] = &tables;
    let arguments = [
        "locate",
        "--bearings",
        arrivals,
        "--bearings",
        bearings,
        "--fixes",
        fixes,
        "--out",
        "again.csv",
    ];
    let output = home.run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    // Time, number and place; a sensor track has its sensor between the first two.
    let again: BTreeSet<Vec<String>> = rows("again.csv").into_iter().map(|row| row[..5].to_vec()).collect();
    let published = rows(&format!("{folder}/sensor_tracks_net.csv"));
    for row in &published {
        let made = [&row[..1], &row[2..6]].concat();
        assert!(again.contains(&made), "{made:?} is not among {} fixes", again.len());
    }
    // The last transmission waits for further receivers when the deployment stops.
    let missing = again.len() - published.len();
    assert!(
        published.len() > 100 && missing <= 1,
        "{missing} of {} were not published",
        again.len()
    );
}
