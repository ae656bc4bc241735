//! Tracker processes: the detections of several sensors become the tracks of one source, and `koseki track` makes the
//! same tracks of the recording (HT-12).

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufReader, Read as _};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::time::Duration;

use bus::{Bus, Mark, Publisher, SharedMemory};
use messages::layout::Sample as _;
use messages::{Cue, DetectionKind, SensorDetection, sensor_detection_bits};
use runtime::clock::mono_ns;
use rustix::process::Signal;
use test_support::Random;

use crate::common::{Home, PLACE, Running, free_address, kill, repository, since_first_day_ns, until, utc_ns};

/// Time between two scans of the fastest sensor.
const STEP: Duration = Duration::from_millis(100);
const TARGETS: usize = 3;

/// Values of the columns that two tables of tracks have in common, row by row. Columns of one table only are those of
/// the process (stages, sensor) or of the tracker (hypotheses, reliability).
pub(crate) fn common_columns(one: &str, other: &str) -> [Vec<Vec<String>>; 2] {
    let header = |text: &str| -> Vec<String> {
        let line = text.lines().next().unwrap_or_default();
        line.split(',').map(str::to_owned).collect()
    };
    let names = [header(one), header(other)];
    let is_common = |name: &&String| *name != "sensor_id" && names[1].contains(name);
    let common: Vec<&String> = names[0].iter().filter(is_common).collect();
    assert!(common.len() > 30 && common[0] == "time_s", "{common:?}");
    [(one, &names[0]), (other, &names[1])].map(|(text, names)| {
        let places: Vec<usize> = common
            .iter()
            .map(|name| names.iter().position(|other| other == *name).unwrap())
            .collect();
        let row = |line: &str| {
            let values: Vec<&str> = line.split(',').collect();
            places.iter().map(|place| values[*place].to_owned()).collect()
        };
        text.lines().skip(1).map(row).collect()
    })
}

/// The recording of all topics of the latest run.
fn recording(home: &Home) -> String {
    let files = fs::read_dir(home.path("out/latest")).unwrap();
    let names = files.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let names: Vec<String> = names.filter(|name| name.ends_with(".mcap")).collect();
    assert_eq!(names.len(), 1, "{names:?}");
    format!("out/latest/{}", names[0])
}

/// What `koseki track` makes of the recording: its summary, and its tracks beside the published tracks.
pub(crate) fn tracked_again(home: &Home, tracker: &str) -> (serde_json::Value, [Vec<Vec<String>>; 2]) {
    let recording = recording(home);
    let output = home.run(&["track", "--detections", &recording, "--out", "again.csv", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = serde_json::from_slice(&output.stdout).unwrap();
    let read = |name: &str| fs::read_to_string(home.path(name)).unwrap();
    let published = read(&format!("out/latest/sensor_tracks_{tracker}.csv"));
    (said, common_columns(&read("again.csv"), &published))
}

pub(crate) fn assert_equal([again, published]: &[Vec<Vec<String>>; 2]) {
    let differs = again
        .iter()
        .zip(published)
        .find(|(again, published)| again != published);
    assert!(differs.is_none(), "{differs:?}");
    assert_eq!(again.len(), published.len());
}

/// The rows without numbers, which are free, and without the mark of pictures that show no new scan.
pub(crate) fn free(rows: Vec<Vec<String>>) -> Vec<Vec<String>> {
    let row = |row: Vec<String>| [&row[..1], &row[2..11]].concat();
    rows.into_iter().map(row).collect()
}

struct Site {
    home: Home,
    socket: UdpSocket,
    to: SocketAddr,
    random: Random,
    begun_ns: i64,
    steps: u64,
    // The publisher ends before its bus.
    sonar: Option<(Publisher<SharedMemory, SensorDetection>, Bus<SharedMemory>)>,
}

impl Site {
    /// A lidar and a camera that send rows to one socket, and a sonar whose program publishes its detections.
    fn new() -> Self {
        Self::with("wait_s = 0.3\n", "")
    }

    /// The same with these keys of the tracker, and with these tables.
    fn with(keys: &str, tables: &str) -> Self {
        let home = Home::new();
        let to = free_address();
        let text = format!(
            "name = \"test\"\n[frame]\nlatitude_deg = {}\nlongitude_deg = {}\n\
             [[receiver]]\nname = \"rows\"\n[receiver.udp]\nlisten = \"{to}\"\n\
             [[tracker]]\nname = \"ship\"\nperiod_s = 0.5\nfresh_s = 5.0\n{keys}\
             [tracker.settings.motion]\nprocess_noise_m2ps3 = [1.0, 1.0]\n\
             [tracker.settings.initiation]\nspeed_sigma_mps = 30.0\n\
             [tracker.settings.capacity]\ndetections = 256\ntracks = 1024\n\
             [[tracker.sensor]]\nname = \"lidar\"\n\
             [tracker.sensor.live]\nreceiver = \"rows\"\nformat = \"rows\"\nsensor_id = 1\n\
             [[tracker.sensor]]\nname = \"camera\"\nsigmas = [0.01]\ndetection_probability = 0.6\n\
             [tracker.sensor.live]\nreceiver = \"rows\"\nformat = \"rows\"\nsensor_id = 2\n\
             [[tracker.sensor]]\nname = \"sonar\"\nscans = \"period\"\nperiod_s = 0.7\n\
             [tracker.sensor.external]\n\
             [recorder]\nformat = [\"csv\", \"mcap\"]\n{tables}",
            PLACE[0], PLACE[1]
        );
        fs::write(home.path("site.toml"), text).unwrap();
        Self {
            home,
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            to,
            random: Random::new(1),
            begun_ns: 0,
            steps: 0,
            sonar: None,
        }
    }

    fn start(&mut self) -> Running {
        let running = self
            .home
            .start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
        running.until_said("instance test runs");
        for name in ["rows", "ship"] {
            until("it runs", || self.home.status_row(name).state == "running");
        }
        self.begun_ns = utc_ns();
        let bus = Bus::<SharedMemory>::open(&self.home.root("test"), "sonar").unwrap();
        let topic = messages::sensor_detections("ship.sonar");
        self.sonar = Some((bus.publisher(&topic, mono_ns() as u64).unwrap(), bus));
        running
    }

    /// Publishes what the sonar measures at a time: all targets, and one detection farther away than any can be.
    fn ping(&mut self, time_s: f64) {
        let mut samples = Vec::new();
        for number in 0..=TARGETS {
            let [east, north] = Self::target(number, time_s);
            let range_m = if number == TARGETS {
                1e7
            } else {
                east.hypot(north) + self.noise()
            };
            samples.push(SensorDetection {
                time_of_measurement_ns: self.begun_ns + (time_s * 1e9) as i64,
                kind: DetectionKind::RangeBearing.code(),
                values: [range_m, east.atan2(north), 0.0],
                sigmas: [3.0, 0.02, 0.0, 0.0],
                valid: sensor_detection_bits::SIGMAS,
                ..SensorDetection::default()
            });
        }
        let (publisher, _) = self.sonar.as_mut().unwrap();
        let sent_ns = mono_ns();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns,
            end: false,
        };
        let sent = publisher.send(mark, samples.len(), |index, sequence| {
            let mut sample = samples[index];
            (sample.sequence, sample.stages.ingested_ns, sample.stages.published_ns) = (sequence, sent_ns, sent_ns);
            sample
        });
        sent.unwrap();
    }

    /// Sends a table of rows.
    fn send(&self, to: SocketAddr, rows: &[String]) {
        let header = "time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,pz";
        let text = format!("{header}\n{}\n", rows.join("\n"));
        self.socket.send_to(text.as_bytes(), to).unwrap();
    }

    fn noise(&mut self) -> f64 {
        4.0 * (self.random.unit() - 0.5)
    }

    /// Where a target is at a time since the beginning.
    fn target(number: usize, time_s: f64) -> [f64; 2] {
        [200.0 + 150.0 * number as f64, 300.0 + 5.0 * time_s]
    }

    /// The next tenth of a second: a lidar each half second, a camera each step, now and then with nothing in sight.
    /// Every seventh lidar scan comes 0.2 s late, which the wait covers; every eleventh 0.8 s, which it does not.
    fn step(&mut self) {
        let step = self.steps;
        self.steps += 1;
        let since_s = |step: u64| 0.1 * step as f64;
        let time_of_day = |begun_ns: i64, since_s: f64| {
            let ns = since_first_day_ns(begun_ns, begun_ns + (since_s * 1e9) as i64);
            format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
        };
        let begun_ns = self.begun_ns;
        let late = |scan: u64| match (scan % 11, scan % 7) {
            (10, _) => 8,
            (_, 6) => 2,
            _ => 0,
        };
        // Of the lidar, the scan that is sent in this step: measured some steps ago.
        let sent = (0..=8).filter_map(|ago| step.checked_sub(ago).filter(|at| at % 5 == 0 && late(at / 5) == ago));
        for at in sent.collect::<Vec<_>>() {
            let time_s = since_s(at);
            let rows: Vec<String> = (0..TARGETS)
                .map(|number| {
                    let [east, north] = Self::target(number, time_s);
                    let (east, north) = (east + self.noise(), north + self.noise());
                    let time = time_of_day(begun_ns, time_s);
                    format!(
                        "{time},1,{},{number},position2,{east:.3},{north:.3},,,2,2,,,0,0,0",
                        at / 5
                    )
                })
                .collect();
            self.send(self.to, &rows);
        }
        let time_s = since_s(step);
        let time = time_of_day(begun_ns, time_s);
        let rows: Vec<String> = (0..TARGETS)
            .filter(|number| !(step as usize + number).is_multiple_of(3) && step % 8 != 7)
            .map(|number| {
                let [east, north] = Self::target(number, time_s);
                let bearing = east.atan2(north) + 0.005 * self.noise();
                format!("{time},2,{step},{number},bearing,{bearing:.6},,,,,,,,0,0,0")
            })
            .collect();
        if step % 7 == 3 {
            self.ping(time_s);
        }
        match rows.is_empty() {
            true => self.send(self.to, &[format!("{time},2,{step},,none,,,,,,,,,,,")]),
            false => self.send(self.to, &rows),
        }
        // Steps follow the clock, however long other things take.
        let due_ns = self.begun_ns + (self.steps * STEP.as_nanos() as u64) as i64;
        let until_due = u64::try_from(due_ns - utc_ns()).unwrap_or(0);
        std::thread::sleep(Duration::from_nanos(until_due));
    }

    fn steps_until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) {
        for step in 0..1200 {
            if step % 20 == 0 && holds(self) {
                return;
            }
            self.step();
        }
        panic!("never happened: {what}");
    }

    fn tracks(&self) -> String {
        fs::read_to_string(self.home.path("out/latest/sensor_tracks_ship.csv")).unwrap_or_default()
    }
}

#[test]
fn detections_of_several_live_sensors_become_tracks_and_their_recording_gives_the_same_again() {
    let mut site = Site::new();
    let running = site.start();
    for _ in 0..170 {
        site.step();
    }
    site.sonar = None;
    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    let (summary, tracks) = tracked_again(&site.home, "ship");
    assert_equal(&tracks);
    assert!(tracks[0].len() > 150, "{} rows: {summary}", tracks[0].len());
    let numbers: BTreeSet<&String> = tracks[0].iter().map(|row| &row[1]).collect();
    assert_eq!(numbers.len(), TARGETS, "{numbers:?}");
    // The same detections are late.
    let refused = summary["refused"].as_object().unwrap();
    let late: u64 = refused.values().map(|count| count.as_u64().unwrap()).sum();
    assert!(
        late > 0 && refused.keys().all(|reason| reason.starts_with("late: ")),
        "{summary}"
    );
    let report = fs::read_to_string(site.home.path("out/latest/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let ship = report["sources"]
        .as_array()
        .unwrap()
        .iter()
        .find(|source| source["name"] == "ship")
        .unwrap();
    let rejected = ship["adapter"]["rejected_late"].as_u64();
    assert_eq!(rejected, Some(late), "{ship}");
    let sonar = report["sources"]
        .as_array()
        .unwrap()
        .iter()
        .find(|source| source["name"] == "ship.sonar")
        .unwrap();
    assert!(sonar["adapter"]["rejected_position"].as_u64() > Some(10), "{sonar}");
    site.home.assert_nothing_is_left("test");
}

/// Ids of the sensors in a table of cues, with and without a header line.
fn cued(rows: &str) -> BTreeSet<String> {
    let rows = rows.lines().filter(|line| !line.starts_with("made_s"));
    rows.filter_map(|row| row.split(',').nth(2).map(str::to_owned))
        .collect()
}

/// Pictures go on while all sensors are silent, and the recording gives the same ones again. Cues of each sensor leave
/// the machine in datagrams and over connections, and are recorded (WA-11, WA-12).
#[test]
fn pictures_and_cues_of_several_sensors_go_out_and_are_recorded() {
    let controller = UdpSocket::bind("127.0.0.1:0").unwrap();
    controller.set_nonblocking(true).unwrap();
    let (to, at) = (controller.local_addr().unwrap(), free_address());
    let tables = format!(
        "[[cue_outlet]]\nname = \"looks\"\nsource = \"ship\"\nsend_to = \"{to}\"\n\
         [[cue_outlet]]\nname = \"lines\"\nsource = \"ship\"\nlisten = \"{at}\"\n"
    );
    // The wait exceeds the period of the sonar's scans: whatever their phase, none is late.
    let mut site = Site::with("wait_s = 1.2\noutput_period_s = 0.5\ncues = true\n", &tables);
    let running = site.start();
    until("the outlets run", || {
        ["looks", "lines"].map(|name| site.home.status_row(name).state) == ["running", "running"].map(str::to_owned)
    });
    let mut lines = TcpStream::connect(at).unwrap();
    lines.set_nonblocking(true).unwrap();
    let (mut datagrams, mut connected, mut octets) = (String::new(), String::new(), [0; 65_536]);
    let mut take = || {
        while let Ok(length) = controller.recv(&mut octets) {
            datagrams += std::str::from_utf8(&octets[..length]).unwrap();
        }
        while let Ok(length @ 1..) = lines.read(&mut octets) {
            connected += std::str::from_utf8(&octets[..length]).unwrap();
        }
        [cued(&datagrams), cued(&connected)]
    };
    let all: BTreeSet<String> = ["2", "3", "4"].map(str::to_owned).into();
    site.steps_until("each sensor has cues", |site| {
        take().iter().all(|sensors| *sensors == all) && site.tracks().lines().count() > 60
    });
    // From now on all sensors are silent.
    site.sonar = None;
    let last_ns = site.begun_ns + (0.1e9 * site.steps as f64) as i64;
    let newest_s = |site: &Site| -> f64 {
        let tracks = site.tracks();
        let row = tracks.lines().last().unwrap_or_default();
        row.split(',').next().and_then(|time| time.parse().ok()).unwrap_or(0.0)
    };
    let silent_s = since_first_day_ns(site.begun_ns, last_ns) as f64 / 1e9;
    until("pictures go on", || newest_s(&site) > silent_s + 3.0);
    let (ended, said) = running.stop();
    assert_eq!(ended.code(), Some(0), "{said}");
    let (summary, tracks) = tracked_again(&site.home, "ship");
    assert_equal(&tracks);
    assert!(tracks[0].len() > 60, "{summary}");
    assert_eq!(
        cued(&fs::read_to_string(site.home.path("out/latest/cues_ship.csv")).unwrap()),
        all
    );
    let mut recorded = BTreeSet::new();
    let mut file = BufReader::new(fs::File::open(site.home.path(&recording(&site.home))).unwrap());
    let read = ::recording::read::<_, ::recording::RecordingError>(&mut file, |item| {
        if let ::recording::Item::Sample {
            topic: "sensor/ship/cues",
            octets,
        } = item
        {
            recorded.extend(Cue::of_octets(octets).map(|cue| cue.source));
        }
        Ok(())
    });
    read.unwrap();
    assert_eq!(recorded, BTreeSet::from([1, 2, 3]));
    site.home.assert_nothing_is_left("test");
}

/// Kills the tracker process this many times while its targets go on.
fn killed(times: usize) {
    let mut site = Site::new();
    let running = site.start();
    for _ in 0..120 {
        site.step();
    }
    let known = |text: &str| -> Vec<(String, f64)> {
        let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
        rows.map(|row| (row[2].to_owned(), row[3].parse().unwrap())).collect()
    };
    let number_at = |rows: &[(String, f64)], target: usize| {
        let east = 200.0 + 150.0 * target as f64;
        let mut near = rows.iter().rev().filter(|(_, at)| (at - east).abs() < 30.0);
        near.next().map(|(number, _)| number.clone())
    };
    let first = known(&site.tracks());
    let numbers: Vec<String> = (0..TARGETS).map(|target| number_at(&first, target).unwrap()).collect();
    for kill_number in 0..times {
        let before = site.home.status_row("ship");
        kill(before.pid, Signal::KILL);
        let had = site.tracks().lines().count();
        site.steps_until("it goes on", |site| {
            let row = site.home.status_row("ship");
            row.pid != before.pid && row.state == "running" && site.tracks().lines().count() > had + 30
        });
        // A process that lives for ten seconds is restarted without a pause the next time.
        if times > 5 {
            (0..105).for_each(|_| site.step());
        }
        let rows = known(&site.tracks());
        for (target, number) in numbers.iter().enumerate() {
            assert_eq!(
                number_at(&rows, target).as_ref(),
                Some(number),
                "kill {kill_number}, target {target}"
            );
        }
    }
    site.sonar = None;
    let (status, said) = running.stop();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(!said.contains("the tracks kept of"), "{said}");
    site.home.assert_nothing_is_left("test");
}

#[test]
fn a_killed_tracker_process_resumes_its_numbers() {
    killed(2);
}

#[test]
#[ignore = "takes minutes: a campaign"]
fn a_tracker_process_killed_fifty_times_renumbers_nothing() {
    // A kill takes thirteen seconds here, a quarter of that in other campaigns.
    let count = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    killed(count.map_or(50, |kills: usize| (kills / 4).max(1)));
}

/// The scenarios of the ferry through one tracker process: its pictures are those that `koseki track` makes of the
/// files, whose figures `track_ferry` measures, and of the recording.
#[test]
fn a_ferry_is_tracked_live_as_its_files_are() {
    for (number, date) in [
        (2, "2021-05-04"),
        (3, "2021-05-04"),
        (13, "2021-05-05"),
        (16, "2021-05-05"),
    ] {
        let file = format!("autoferry/scenario{number}/scenario{number}_detections.json");
        let Some(detections) = test_support::recording(&file) else {
            return;
        };
        let home = Home::new();
        fs::create_dir_all(home.path(&file).parent().unwrap()).unwrap();
        fs::write(home.path(&file), detections).unwrap();
        let config = repository("config/ferry.toml");
        let mut arguments = vec![
            "up".to_owned(),
            config.display().to_string(),
            "--instance".into(),
            "test".into(),
        ];
        arguments.extend(["--data", ".", "--speed", "max", "--out", "out", "--set"].map(str::to_owned));
        arguments.push(format!("time.date=\"{date}\""));
        for sensor in 0..4 {
            arguments.push("--set".to_owned());
            arguments.push(format!("tracker[0].sensor[{sensor}].recorded.file=\"{file}\""));
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (status, said) = home.start(&arguments).end();
        assert_eq!(status.code(), Some(0), "{said}");
        let (_, tracks) = tracked_again(&home, "ferry");
        assert_equal(&tracks);
        let published = fs::read_to_string(home.path("out/latest/sensor_tracks_ferry.csv")).unwrap();
        let settings = repository("examples/autoferry.toml").display().to_string();
        let offline = [
            "track",
            "--detections",
            &file,
            "--config",
            &settings,
            "--period",
            "1",
            "--out",
            "offline.csv",
        ];
        let output = home.run(&offline);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let offline = fs::read_to_string(home.path("offline.csv")).unwrap();
        let [offline, published] = common_columns(&offline, &published);
        assert_equal(&[free(offline), free(published)]);
        home.assert_nothing_is_left("test");
    }
}
