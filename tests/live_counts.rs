//! Wide-area support in running deployments: counts come in over the network or from recordings and change what a
//! tracker believes, and what was recorded gives the same tracks again (WA).
//!
//! Nothing here waits for a time to pass except for the radar's turns: what has been sent is looked for in shared
//! memory before the radar goes on.

use std::collections::BTreeMap;
use std::fs;

use asterix::registry;
use bus::{Bus, SharedMemory, Subscriber};
use frames::time::NS_PER_DAY;
use messages::{Cue, SystemTrack, TrackState, WideArea};
use outgoing::SystemReports;
use runtime::clock::mono_ns;
use rustix::process::Signal;

use crate::common::counted_pair::{HEADER, NS, ROWS, SPEED_MPS, Site, deployment};
use crate::common::{Home, free_address, kill, since_first_day_ns, system, until, utc_ns};

/// Takes what has been published until there are so many reports.
fn until_published(counts: &mut Subscriber<SharedMemory, WideArea>, seen: &mut Vec<WideArea>, wanted: usize) {
    until("reports are published", || {
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
        seen.len() >= wanted
    });
}

#[test]
fn counts_change_the_tracks_and_the_recording_gives_them_again() {
    let mut site = Site::live(ROWS);
    let running = site.start();
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    let mut seen = Vec::new();
    // What cannot be used is counted, and takes nothing with it: a datagram that is no table, rows among good ones.
    site.send(b"\xff\xfe garbage");
    site.send(&[]);
    let bad = site.row(1.0, 10_000) + &site.row(-5.0, 2) + "1,2,3\n" + &site.row(1.0, 2).replace(",15000,", ",1e9,");
    for turn in 0..51 {
        if turn % 8 == 6 {
            let row = site.row(1.6, 2);
            let table = if turn == 6 {
                format!("{HEADER}{}{bad}{row}", site.row(9.0, 0))
            } else {
                format!("{HEADER}{row}")
            };
            site.send(table.as_bytes());
            let wanted = seen.len() + if turn == 6 { 2 } else { 1 };
            until_published(&mut counts, &mut seen, wanted);
        }
        site.turn();
    }
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert_eq!(
        seen.iter().map(|report| report.targets).collect::<Vec<_>>(),
        [0, 2, 2, 2, 2, 2, 2]
    );
    for (label, expected) in [
        ("rejected_targets", 1),
        ("rejected_time", 1),
        ("rejected_position", 1),
        // A row, and a datagram's header.
        ("blocks_rejected", 2),
        ("wide_area_reports", 7),
        ("wide_area_late", 0),
        ("wide_area_lost", 0),
        ("wide_area_rejected", 0),
    ] {
        assert_eq!(
            site.counted(label),
            expected,
            "{label}: {}",
            site.read("out/latest/report.json")
        );
    }
    assert!(site.counted("wide_area_used") >= 6);
    let recorded = site.read("out/latest/wide_area_remote.csv");
    assert_eq!(recorded.lines().count(), 1 + seen.len(), "{recorded}");
    let published = site.published();
    assert!(published.len() > 40, "{}", published.len());
    assert!(site.tracked("out", true) == published, "the same tracks again");
    assert!(
        site.tracked("out", false) != published,
        "without the counts they are others"
    );
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_silent_sensor_changes_nothing_and_one_that_is_killed_comes_back() {
    let begun_ns = utc_ns();
    let mut site = Site::live(ROWS);
    let running = site.start();
    for _ in 0..12 {
        site.turn();
    }
    let before = site.home.status_row("link");
    kill(before.pid, Signal::KILL);
    let at_kill = site.lines();
    let mut back = false;
    for turn in 0..300 {
        site.turn();
        let row = site.home.status_row("link");
        back = row.pid != before.pid && row.state == "running";
        if back && turn >= 8 {
            break;
        }
    }
    assert!(back, "the adapter is restarted");
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    assert_eq!(
        site.read("out/latest/wide_area_remote.csv").lines().count(),
        0,
        "nothing has been said so far"
    );
    let silent_until = utc_ns();
    site.send(format!("{HEADER}{}", site.row(1.0, 2)).as_bytes());
    until_published(&mut counts, &mut Vec::new(), 1);
    for _ in 0..6 {
        site.turn();
    }
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    let published = site.published();
    assert!(published.len() > at_kill + 8, "the tracker went on");
    assert_eq!(site.counted("wide_area_reports"), 1);
    assert!(site.tracked("out", true) == published);
    // As long as the sensor was silent, the tracks are those of a tracker that hears none.
    let day_s = since_first_day_ns(begun_ns, silent_until) as f64 / NS;
    let early = |rows: Vec<String>| -> Vec<String> {
        let time_s = |row: &String| row.split(',').next().unwrap().parse::<f64>().unwrap();
        rows.into_iter().filter(|row| time_s(row) < day_s).collect()
    };
    let (with, without) = (early(published), early(site.tracked("out", false)));
    assert!(with == without && with.len() > 15, "{}", with.len());
    site.home.assert_nothing_is_left("test");
}

#[test]
fn another_systems_tracks_become_counts() {
    let tracks = "[wide_area_sensor.tracks]\nreceiver = \"link\"\nperiod_s = 1.0\ngroup_m = 500.0\n";
    let mut site = Site::live(tracks);
    let running = site.start();
    let bus = site.bus();
    let mut counts = bus
        .subscriber(&messages::wide_area("remote"), || mono_ns() as u64)
        .unwrap();
    let table = registry::default_edition(62).unwrap();
    let mut centre = SystemReports::new(table, 9, 9, system().1, &[], 1400).unwrap();
    let mut seen: Vec<WideArea> = Vec::new();
    for turn in 0..40 {
        // Two near each other where the radar's targets are, and one far away; told once a second.
        if turn % 5 == 0 {
            let ([east, north], socket, to) = (site.radar.middle_m(), &site.socket, site.remote);
            let time_ns = utc_ns();
            for (number, place) in [[east, north + 100.0], [east, north - 100.0], [40e3, -30e3]]
                .into_iter()
                .enumerate()
            {
                let track = SystemTrack {
                    reference_time_ns: time_ns,
                    time_of_measurement_ns: time_ns,
                    track_number: number as u32 + 1,
                    position_m: [place[0], place[1], 3000.0],
                    velocity_mps: [SPEED_MPS, 0.0, 0.0],
                    velocity_valid: 1,
                    state: TrackState::Confirmed as u8,
                    ..SystemTrack::default()
                };
                centre.report(&track, &mut |block| drop(socket.send_to(block, to)));
            }
            centre.flush(&mut |block| drop(socket.send_to(block, to)));
        }
        site.turn();
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
    }
    until("every picture is counted", || {
        counts.take(64, |_, slice| seen.extend_from_slice(slice)).unwrap();
        seen.iter().map(|report| report.targets).sum::<u32>() >= 24
    });
    drop((counts, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    for picture in seen.chunks(2) {
        let [pair, single] = picture else { panic!("{seen:?}") };
        assert_eq!((pair.targets, single.targets), (2, 1), "{seen:?}");
        assert!(
            (pair.position_m[1] - 15e3).abs() < 20.0 && (single.position_m[0] - 40e3).abs() < 20.0,
            "{seen:?}"
        );
        assert!((pair.velocity_mps[0] - 100.0).abs() < 1.0 && pair.arrival_ns >= pair.time_of_observation_ns);
        assert_eq!(pair.time_of_observation_ns, single.time_of_observation_ns);
    }
    assert!(site.counted("wide_area_reports") > 6);
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_recording_is_supported_alike_at_any_speed() {
    let mut site = Site::live(ROWS);
    site.radar.period_s = 4.0;
    let (mut plots, mut counts) = (Vec::new(), HEADER.to_owned());
    for turn in 0..60_i64 {
        let seconds = 43_200 + 4 * turn;
        if turn % 4 == 2 {
            let [east, north] = site.radar.middle_m();
            let (observed, east) = (seconds - 9, east - 9.0 * SPEED_MPS);
            counts += &format!("{observed},{}.5,{east},{north},0,{SPEED_MPS},0,0,2\n", seconds - 3);
        }
        site.radar
            .turn(1_000_000_000 * seconds, &mut |block| plots.extend_from_slice(block));
    }
    fs::write(site.home.path("plots.ast"), plots).unwrap();
    fs::write(site.home.path("counts.csv"), &counts).unwrap();
    let sensor = "[wide_area_sensor.recorded]\nfile = \"counts.csv\"\n";
    let source = "[source.recorded]\nfile = \"plots.ast\"\n";
    let time = "name = \"test\"\n[time]\norder = \"time\"\ndate = \"2026-05-10\"\n";
    fs::write(
        site.home.path("site.toml"),
        time.to_owned() + &deployment(sensor, source, "4.0"),
    )
    .unwrap();
    for (speed, out) in [("max", "out"), ("20", "slow")] {
        let up = format!("up site.toml --data . --speed {speed} --instance test --out {out}");
        let running = site.home.start(&up.split(' ').collect::<Vec<_>>());
        if out == "slow" {
            // A replay that is killed goes on where the recorder is.
            running.until_said("instance test runs");
            let bus = site.bus();
            let topic = messages::wide_area("remote");
            let mut published = bus.subscriber(&topic, || mono_ns() as u64).unwrap();
            until_published(&mut published, &mut Vec::new(), 3);
            let before = site.home.status_row("remote");
            kill(before.pid, Signal::KILL);
            until("it is restarted", || site.home.status_row("remote").pid != before.pid);
        }
        let (status, said) = running.end();
        assert_eq!(status.code(), Some(0), "{said}");
        site.home.assert_nothing_is_left("test");
    }
    for name in [
        "sensor_tracks_radar.csv",
        "detections_radar.csv",
        "wide_area_remote.csv",
    ] {
        let (fast, slow) = (
            site.read(&format!("out/latest/{name}")),
            site.read(&format!("slow/latest/{name}")),
        );
        let lines = [&fast, &slow].map(|text| text.lines().count());
        assert!(fast == slow && lines[0] > 10, "{name}: {lines:?}");
    }
    let with_route = |line: &str| format!("{line},\n");
    let expected: String = counts.lines().skip(1).map(with_route).collect();
    assert_eq!(
        site.read("out/latest/wide_area_remote.csv").split_once('\n').unwrap().1,
        expected,
        "to the last digit"
    );
    let published = site.published();
    assert!(site.tracked("out", true) == published);
    assert!(site.tracked("out", false) != published);
    // A recording that is not there is said before anything starts.
    fs::remove_file(site.home.path("counts.csv")).unwrap();
    let output = site.home.run(&["check", "site.toml", "--data", "."]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("wide-area sensor \"remote\"") && said.contains("wide_area_sensor[0].recorded.file"),
        "{said}"
    );
}

#[test]
fn cues_and_even_times_in_a_running_deployment() {
    let mut site = Site::live(ROWS);
    let text = site.read("site.toml");
    let keys = "scans = \"turn\"\ncues = true\noutput_period_s = 0.25\n";
    fs::write(
        site.home.path("site.toml"),
        text.replacen("scans = \"turn\"\n", keys, 1),
    )
    .unwrap();
    let running = site.start();
    let bus = site.bus();
    let mut subscriber = bus.subscriber(&messages::cues("radar"), || mono_ns() as u64).unwrap();
    let mut cues: Vec<Cue> = Vec::new();
    for _ in 0..200 {
        site.turn();
        subscriber.take(64, |_, slice| cues.extend_from_slice(slice)).unwrap();
        if cues.len() > 20 && site.lines() > 20 {
            break;
        }
    }
    assert_eq!(subscriber.counts().lost, 0);
    drop((subscriber, bus));
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(cues.len() > 20, "{cues:?}");
    for cue in &cues {
        assert!(
            (cue.position_m[1] - 15e3).abs() < 500.0 && cue.half_axes_m[0] >= cue.half_axes_m[1],
            "{cue:?}"
        );
        assert!(
            cue.half_axes_m[1] > 0.0 && cue.track_number > 0 && cue.stages.published_ns > 0,
            "{cue:?}"
        );
    }
    assert!(
        cues.windows(2)
            .all(|pair| pair[1].sequence == pair[0].sequence + 1 && pair[1].time_ns >= pair[0].time_ns)
    );
    // `koseki track` says the same of the recorded detections.
    let detections = "out/latest/detections_radar.csv";
    let arguments = [
        "track",
        "--detections",
        detections,
        "--config",
        "site.toml",
        "--out",
        "again.csv",
        "--cues",
        "looks.csv",
    ];
    let output = site.home.run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let looks = site.read("looks.csv");
    let recorded = site.read("out/latest/cues_radar.csv");
    assert!(looks.starts_with(&recorded), "{recorded}");
    assert!(recorded.lines().count() > cues.len(), "less than a reader has heard");
    let looks: Vec<Vec<f64>> = looks
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|value| value.parse().unwrap()).collect())
        .collect();
    assert!(looks.len() >= cues.len());
    for (look, cue) in looks.iter().zip(&cues) {
        let [x, y, z] = cue.position_m;
        let [longer, shorter] = cue.half_axes_m;
        // To the last digit of the file.
        let same = |found: &[f64], said: &[f64]| found.iter().zip(said).all(|(one, other)| (one - other).abs() < 6e-4);
        assert!(
            same(&look[4..7], &[x, y, z]) && same(&look[10..], &[longer, shorter, cue.orientation_rad]),
            "{cue:?}"
        );
    }
    let times: Vec<f64> = site
        .published()
        .iter()
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(
        times.len() > 10 && times.is_sorted() && times.iter().all(|time_s| (time_s * 4.0).fract() == 0.0),
        "{times:?}"
    );
    site.home.assert_nothing_is_left("test");
}

#[test]
fn what_a_direction_finder_hears_identifies_a_track() {
    let mut site = Site::live(ROWS);
    let ears = free_address();
    let text = site
        .read("site.toml")
        .replacen("scans = \"turn\"\n", "scans = \"turn\"\nemissions = [\"finder\"]\n", 1);
    let more = format!(
        "[[source.tracker.wide_area.type]]\nname = \"patrol\"\nemissions = [{{ frequency_hz = [9.3e9, 9.5e9] }}]\n\
         [[source.tracker.wide_area.prior]]\ncircle = {{ centre_m = [0.0, 0.0], radius_m = 90e3 }}\ntypes = {{ patrol = 0.6 }}\n\
         [[receiver]]\nname = \"ears\"\n[receiver.udp]\nlisten = \"{ears}\"\n[[source]]\nname = \"finder\"\n[source.live]\n\
         receiver = \"ears\"\n[source.locator]\n"
    );
    fs::write(site.home.path("site.toml"), text + &more).unwrap();
    let running = site.start();
    until("the finder's adapter listens", || {
        site.home.status_row("ears").state == "running"
    });
    let named = |site: &Site| site.read("out/latest/sensor_tracks_radar.csv").contains(",patrol,");
    for turn in 0..200 {
        // Before the second target of the pair has a track, which the bearing would fit as well.
        if turn > 4 {
            let ([east, north], now_s) = (site.radar.middle_m(), utc_ns().rem_euclid(NS_PER_DAY) as f64 / NS);
            let bearing = east.atan2(north).rem_euclid(std::f64::consts::TAU);
            let header = "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,heading_rad,frequency_hz";
            let row = format!("{header}\n{now_s},1,{bearing},0.02,0,0,0,,9.4e9\n{now_s},2,{bearing},0.02,0,0,0,,\n");
            site.socket.send_to(row.as_bytes(), ears).unwrap();
        }
        site.turn();
        if named(&site) {
            break;
        }
    }
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(named(&site), "{}", site.read("out/latest/sensor_tracks_radar.csv"));
    assert!(site.counted("emissions") > 0 && site.counted("emissions_rejected") > 0);
    site.home.assert_nothing_is_left("test");
}

/// A pair that its only radar never resolves but in one turn of five, and everything faster than in life.
const SIMULATED: &str = r#"name = "test"
[frame]
latitude_deg = 34.75
longitude_deg = 139.35
[scenario]
targets = 0
[[scenario.formation]]
spacing_m = 300.0
together_m = [52000.0, 11000.0]
start_m = [50000.0, 50000.0]
[[wide_area_sensor]]
name = "remote"
[wide_area_sensor.simulated]
period_s = 1.0
delay_s = 0.5
[[source]]
name = "radar"
period_s = 0.5
[source.simulated]
kind = "radar"
plots = true
period_s = 0.5
azimuth_resolution_rad = 0.03
resolved_probability = 0.2
[source.covariance]
range_sigma_m = 50.0
azimuth_sigma_deg = 0.069
height_sigma_m = 15.0
[source.tracker]
wide_area_sensors = ["remote"]
[recorder]
enabled = false
"#;

/// In a running deployment the simulator's counts come through the sensor's adapter as late as they are to be, and both
/// members of the pair are in the picture.
#[test]
fn simulated_counts_come_when_they_are_due() {
    let home = Home::new();
    fs::write(home.path("site.toml"), SIMULATED).unwrap();
    let running = home.start(&["up", "site.toml", "--instance", "test", "--seed", "5"]);
    running.until_said("instance test runs");
    let bus = Bus::<SharedMemory>::open(&home.root("test"), "reader").unwrap();
    let open = || mono_ns() as u64;
    let mut counted = bus.subscriber(&messages::wide_area("remote"), open).unwrap();
    let mut fused = bus.subscriber(&messages::system_tracks(), open).unwrap();
    let mut reports = Vec::new();
    let mut picture: BTreeMap<u32, SystemTrack> = BTreeMap::new();
    until("both are in the picture, and counts have come", || {
        counted.take(64, |_, slice| reports.extend_from_slice(slice)).unwrap();
        fused
            .take(256, |_, slice| {
                for track in slice {
                    picture.insert(track.track_number, *track);
                }
            })
            .unwrap();
        let confirmed = |track: &&SystemTrack| track.state == TrackState::Confirmed as u8;
        picture.values().filter(confirmed).count() >= 2 && reports.len() >= 3
    });
    for report in &reports {
        assert_eq!(report.targets, 2, "{report:?}");
        let late_ns = report.arrival_ns - report.time_of_observation_ns;
        assert!(late_ns >= 500_000_000, "{report:?}");
    }
    drop((counted, fused, bus));
    running.signal(Signal::TERM);
    let (status, said) = running.end();
    assert_eq!(status.code(), Some(0), "{said}");
    home.assert_nothing_is_left("test");
}
