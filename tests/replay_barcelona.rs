//! The Barcelona recording through the live processes, judged against the decoded inputs.
//!
//! Every run here starts the real processes over shared memory (`koseki up … --speed …`) and reads what the recorder
//! wrote. What a correct picture is follows from the reports themselves: multilateration and ADS-B carry addresses, so
//! whoever reads the addresses knows which reports belong together, whether or not fusion was allowed to use them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::OnceLock;

use adapter::recorded_source::RecordedSource;
use configuration::Config;
use deployment::Input;
use messages::{Counter, SensorTrack, TrackState};
use rustix::process::Signal;
use test_support::recordings;

use crate::common::{Home, Running, S, counter, kill, repository, until};
use crate::golden::{COVARIANCE, golden, hash_of_columns};

/// A report is fresh at a whole second if it is not older than this.
const FRESH_NS: i64 = 3 * S;
/// What is new waits so long for the rest of its scan, so the first state of a system track may come after later states
/// of others: the twentieth part of a second's turn.
const SCAN_WAIT_NS: i64 = S / 20;
const RADAR: usize = 0;
const MLAT: usize = 1;
const ADSB: usize = 2;

/// One row of `system_tracks.csv`.
#[derive(Clone, Debug)]
struct Row {
    time_ns: i64,
    track: u32,
    position: [f64; 2],
    state: String,
    address: Option<u32>,
    /// Source (from 0), sensor track, time of its latest report.
    contributions: Vec<(usize, u32, i64)>,
}

impl Row {
    fn is_shown(&self) -> bool {
        self.state == "confirmed" || self.state == "coasted"
    }

    fn fresh(&self, source: usize, now_ns: i64) -> Option<(u32, i64)> {
        let found = self
            .contributions
            .iter()
            .find(|(of, _, time_ns)| *of == source && now_ns - time_ns <= FRESH_NS);
        found.map(|(_, track, time_ns)| (*track, *time_ns))
    }
}

/// The decoded inputs: what a valid report is, independent of the pipeline.
struct Inputs {
    reports: [Vec<SensorTrack>; 3],
    first_day_ns: i64,
    rejected: [messages::Counters; 3],
}

/// The configuration of the recorded airport.
const CONFIGURATION: &str = "config/barcelona.toml";

fn decode_inputs(data: &Path) -> Inputs {
    let config = Config::read(&repository(CONFIGURATION), &[]).unwrap();
    let first_day_ns = config.first_day_ns.unwrap();
    let mut rejected = [messages::Counters::default(); 3];
    let reports = std::array::from_fn(|index| {
        let processed = (&config.sources[index], &config.readings.sources[index]);
        let Input::Recorded(recorded) = &processed.0.input else {
            panic!("not recorded")
        };
        let bytes = std::fs::read(data.join(&recorded.file)).unwrap();
        let mut recording = RecordedSource::new(bytes, recorded, processed, first_day_ns).unwrap();
        let mut reports: Vec<SensorTrack> = recording.by_ref().collect();
        for report in &mut reports {
            report.time_of_measurement_ns -= first_day_ns;
        }
        rejected[index] = recording.counters();
        reports
    });
    Inputs {
        reports,
        first_day_ns,
        rejected,
    }
}

fn parse_time(text: &str) -> i64 {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    whole.parse::<i64>().unwrap() * S + format!("{fraction:0<9}").parse::<i64>().unwrap()
}

fn read_system_tracks(files: &Files) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(&files["system_tracks.csv"][..]);
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| {
        headers
            .iter()
            .position(|header| header == name)
            .unwrap_or_else(|| panic!("no {name}"))
    };
    let [time, track, x, y, state, address, sources, ids, times] = [
        "time_s",
        "system_track_id",
        "x",
        "y",
        "state",
        "address",
        "sources",
        "sensor_track_ids",
        "report_times_s",
    ]
    .map(column);
    let parts = |text: &str| -> Vec<String> {
        text.split('|')
            .filter(|part| !part.is_empty())
            .map(str::to_owned)
            .collect()
    };
    reader
        .records()
        .map(|record| {
            let record = record.unwrap();
            let contributions = parts(&record[sources])
                .iter()
                .zip(parts(&record[ids]))
                .zip(parts(&record[times]))
                .map(|((source, id), time)| {
                    (
                        source.parse::<usize>().unwrap() - 1,
                        id.parse().unwrap(),
                        parse_time(&time),
                    )
                })
                .collect();
            Row {
                time_ns: parse_time(&record[time]),
                track: record[track].parse().unwrap(),
                position: [record[x].parse().unwrap(), record[y].parse().unwrap()],
                state: record[state].to_owned(),
                address: (!record[address].is_empty()).then(|| u32::from_str_radix(&record[address], 16).unwrap()),
                contributions,
            }
        })
        .collect()
}

/// What the picture and the inputs are at one whole second.
struct Moment<'a> {
    now_ns: i64,
    tracks: &'a BTreeMap<u32, Row>,
    radar: &'a BTreeMap<u32, SensorTrack>,
    mlat: &'a BTreeMap<u32, SensorTrack>,
    adsb: &'a BTreeMap<u32, SensorTrack>,
}

impl Moment<'_> {
    fn is_fresh(&self, report: &SensorTrack) -> bool {
        self.now_ns - report.time_of_measurement_ns <= FRESH_NS
    }

    /// Where the target of `report` is now, in the plane.
    fn place(&self, report: &SensorTrack) -> [f64; 2] {
        let seconds = (self.now_ns - report.time_of_measurement_ns) as f64 / S as f64;
        [0, 1].map(|axis| report.position_m[axis] + report.velocity_mps[axis] * seconds)
    }

    fn apart(&self, a: &SensorTrack, b: &SensorTrack) -> f64 {
        let (a, b) = (self.place(a), self.place(b));
        (a[0] - b[0]).hypot(a[1] - b[1])
    }
}

/// Calls `judge` at every whole second of the recording.
fn at_whole_seconds(inputs: &Inputs, rows: &[Row], mut judge: impl FnMut(&Moment<'_>)) {
    let starts = inputs.reports.iter().map(|reports| reports[0].time_of_measurement_ns);
    let ends = inputs
        .reports
        .iter()
        .map(|reports| reports[reports.len() - 1].time_of_measurement_ns);
    let (first, last) = (starts.min().unwrap() / S + 1, ends.max().unwrap() / S);
    let (mut tracks, mut next_row) = (BTreeMap::new(), 0);
    let (mut latest, mut next) = ([const { BTreeMap::new() }; 3], [0; 3]);
    for second in first..=last {
        let now_ns = second * S;
        while let Some(row) = rows.get(next_row).filter(|row| row.time_ns <= now_ns) {
            if row.state == "terminated" {
                tracks.remove(&row.track);
            } else {
                tracks.insert(row.track, row.clone());
            }
            next_row += 1;
        }
        for source in [RADAR, MLAT, ADSB] {
            let due = |report: &&SensorTrack| report.time_of_measurement_ns <= now_ns;
            while let Some(report) = inputs.reports[source].get(next[source]).filter(due) {
                let key = if source == RADAR {
                    report.track_number
                } else {
                    report.identity.address().unwrap()
                };
                if report.state == TrackState::Terminated as u8 {
                    latest[source].remove(&key);
                } else {
                    latest[source].insert(key, *report);
                }
                next[source] += 1;
            }
        }
        let [radar, mlat, adsb] = &latest;
        judge(&Moment {
            now_ns,
            tracks: &tracks,
            radar,
            mlat,
            adsb,
        });
    }
}

/// A share of aircraft-seconds.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    good: u32,
    of: u32,
}

impl Share {
    fn add(&mut self, good: bool) {
        self.of += 1;
        self.good += u32::from(good);
    }

    fn at_least(self, what: &str, limit: f64, of_at_least: u32) {
        let share = f64::from(self.good) / f64::from(self.of.max(1));
        println!(
            "{what}: {:.2} % of {} aircraft-seconds (at least {:.0} %)",
            100.0 * share,
            self.of,
            100.0 * limit
        );
        assert!(
            self.of >= of_at_least,
            "{what}: only {} aircraft-seconds to judge",
            self.of
        );
        assert!(share >= limit, "{what}: {share:.4} < {limit}");
    }
}

/// The instance of a replay.
const INSTANCE: &str = "bcn";

/// Starts a replay of the recordings that writes to `out`.
fn start(home: &Home, data: &Path, more: &[&str]) -> Running {
    let (configuration, data) = (repository(CONFIGURATION), data.to_str().unwrap());
    let up = [
        "up",
        configuration.to_str().unwrap(),
        "--instance",
        INSTANCE,
        "--data",
        data,
        "--out",
        "out",
    ];
    home.start(&[&up, more].concat())
}

/// Files of a run, by their names.
type Files = BTreeMap<String, Vec<u8>>;

/// What a replay of the recordings at full speed writes.
fn replay(data: &Path, more: &[&str]) -> Files {
    let home = Home::new();
    let (status, said) = start(&home, data, &[&["--speed", "max"], more].concat()).end();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left(INSTANCE);
    files_of(&home.path("out/latest"))
}

/// The same of a replay that nothing disturbs: several tests compare others with it.
fn undisturbed(data: &Path) -> &'static Files {
    static FILES: OnceLock<Files> = OnceLock::new();
    FILES.get_or_init(|| replay(data, &[]))
}

fn files_of(folder: &Path) -> Files {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files
        .filter(|path| path.is_file())
        .map(|path| {
            let bytes = std::fs::read(&path).unwrap();
            (path.file_name().unwrap().to_str().unwrap().to_owned(), bytes)
        })
        .collect()
}

/// The tables, without alarms and orders: these have the machine and its time in them, which differ from run to run.
fn tables(files: &Files) -> BTreeMap<&str, &[u8]> {
    let is_table = |name: &str| name.ends_with(".csv") && !["alarms.csv", "orders.csv"].contains(&name);
    let files = files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]));
    files.filter(|(name, _)| is_table(name)).collect()
}

#[test]
fn with_identity_every_aircraft_has_one_track_and_nothing_is_lost() {
    let Some(data) = recordings("lebl2016") else { return };
    let inputs = decode_inputs(&data);
    let files = undisturbed(&data);
    let rows = read_system_tracks(files);

    let (mut one_track, mut radar_joined) = (Share::default(), Share::default());
    at_whole_seconds(&inputs, &rows, |moment| {
        for (address, mlat) in moment.mlat.iter().filter(|(_, report)| moment.is_fresh(report)) {
            if moment.adsb.get(address).is_some_and(|report| moment.is_fresh(report)) {
                let carriers = moment
                    .tracks
                    .values()
                    .filter(|row| row.is_shown() && row.address == Some(*address));
                one_track.add(carriers.count() == 1);
            }
            judge_radar(moment, *address, mlat, &mut radar_joined);
        }
    });
    one_track.at_least("one track carries the address", 0.99, 15_000);
    radar_joined.at_least("the radar contributes", 0.90, 5_000);

    check_addresses(&rows);
    check_contributions(&inputs, &rows);
    check_midnight(&inputs, &rows);
    check_nothing_lost(&inputs, files);
    check_registration(files);
}

fn judge_radar(moment: &Moment<'_>, address: u32, mlat: &SensorTrack, share: &mut Share) {
    let [vx, vy, _] = mlat.velocity_mps;
    let crowded = [moment.mlat, moment.adsb]
        .into_iter()
        .flatten()
        .any(|(other, report)| *other != address && moment.is_fresh(report) && moment.apart(mlat, report) <= 160.0);
    let seen = moment
        .radar
        .values()
        .any(|radar| moment.is_fresh(radar) && moment.apart(mlat, radar) <= 80.0);
    if vx.hypot(vy) <= 3.0 || crowded || !seen {
        return;
    }
    let mine = moment
        .tracks
        .values()
        .find(|row| row.is_shown() && row.address == Some(address));
    share.add(mine.is_some_and(|row| row.contributions.iter().any(|(source, ..)| *source == RADAR)));
}

/// No system track ever carries two addresses, and none that of a field monitor.
fn check_addresses(rows: &[Row]) {
    let mut carried = BTreeMap::new();
    for row in rows {
        let Some(address) = row.address else { continue };
        assert_eq!(
            *carried.entry(row.track).or_insert(address),
            address,
            "track {} carries two addresses",
            row.track
        );
        // The six field monitors of the multilateration system.
        assert!(
            !(0x34_2380..=0x34_238f).contains(&address),
            "a system track at field monitor {address:06X}"
        );
    }
}

/// Every contribution is a report that passed the checks, so no position stems from an impossible one.
fn check_contributions(inputs: &Inputs, rows: &[Row]) {
    let valid: BTreeSet<(usize, u32, i64)> = inputs
        .reports
        .iter()
        .enumerate()
        .flat_map(|(source, reports)| {
            reports
                .iter()
                .map(move |r| (source, r.track_number, r.time_of_measurement_ns))
        })
        .collect();
    for row in rows {
        for contribution in &row.contributions {
            assert!(valid.contains(contribution), "{contribution:?} is no valid report");
        }
        // The last row of a track is carried on over the rest of its number.
        let is_over = row.state == "terminated";
        assert!(is_over || row.position[0].hypot(row.position[1]) < 300e3, "{row:?}");
    }
    let rejected = |source: usize, counter: Counter| inputs.rejected[source][counter];
    assert_eq!(rejected(MLAT, Counter::RejectedFieldMonitor), 41_548);
    assert_eq!(
        rejected(ADSB, Counter::RejectedPosition),
        30,
        "positions at the other end of the world"
    );
    assert_eq!(inputs.reports[RADAR].len(), 62_819);
    assert_eq!(inputs.reports[MLAT].len(), 28_385);
}

/// Time runs on across midnight: no gap, no step back, no position that jumps.
fn check_midnight(inputs: &Inputs, rows: &[Row]) {
    let midnight_ns = 86_400 * S;
    assert!(inputs.first_day_ns > 0);
    let mut latest_ns = i64::MIN;
    for row in rows {
        assert!(row.time_ns + SCAN_WAIT_NS >= latest_ns, "{row:?} comes too late");
        latest_ns = latest_ns.max(row.time_ns);
    }
    let around = |second: i64| rows.iter().filter(move |row| row.time_ns.div_euclid(S) == second);
    for second in midnight_ns / S - 10..midnight_ns / S + 10 {
        assert!(around(second).count() >= 5, "a gap at {second}");
    }
    let mut last: BTreeMap<u32, &Row> = BTreeMap::new();
    let mut crossed = 0;
    for row in rows
        .iter()
        .filter(|row| (row.time_ns - midnight_ns).abs() < 10 * S && row.state == "confirmed")
    {
        if let Some(before) = last.insert(row.track, row) {
            let step = (row.position[0] - before.position[0]).hypot(row.position[1] - before.position[1]);
            let seconds = (row.time_ns - before.time_ns) as f64 / S as f64;
            // 100 m/s, and what sensors may disagree by at a hand-over.
            assert!(
                step <= 100.0 * seconds + 250.0,
                "track {} jumps {step:.0} m at midnight",
                row.track
            );
            crossed += usize::from(before.time_ns < midnight_ns && row.time_ns >= midnight_ns);
        }
    }
    assert!(crossed >= 3, "only {crossed} tracks live across midnight");
}

/// What the adapters published is what fusion took and the recorder wrote, report by report.
fn check_nothing_lost(inputs: &Inputs, files: &Files) {
    for (index, name) in ["radar", "multilateration", "ads-b"].iter().enumerate() {
        let mut reader = csv::Reader::from_reader(&files[&format!("sensor_tracks_{name}.csv")][..]);
        assert_eq!(reader.records().count(), inputs.reports[index].len(), "{name}");
    }
    let report: serde_json::Value = serde_json::from_slice(&files["report.json"]).unwrap();
    assert_eq!(
        report["alarms"].as_array().map(Vec::len),
        Some(0),
        "{:#}",
        report["alarms"]
    );
    for (index, source) in report["sources"].as_array().unwrap().iter().enumerate() {
        let fusion = &source["fusion"];
        assert_eq!(counter(fusion, "lost"), 0, "{source}");
        assert_eq!(fusion["taken"], inputs.reports[index].len(), "{source}");
    }
}

/// What fusion says of the radar is what the recordings say: the mean, over the 29 aircraft that both see moving, of
/// the differences between radar reports and multilateration is 6.1 m east and 5.1 m north. In the end few move, of
/// which the points of the radar are those of single aircraft.
fn check_registration(files: &Files) {
    let report: serde_json::Value = serde_json::from_slice(&files["report.json"]).unwrap();
    let registration = &report["sources"][RADAR]["registration"];
    for (axis, expected_m) in [6.1, 5.1].into_iter().enumerate() {
        let offset_m = registration["offset_m"][axis].as_f64().unwrap();
        let sigma_m = registration["offset_sigma_m"][axis].as_f64().unwrap();
        assert!(
            sigma_m < 6.0 && (offset_m - expected_m).abs() < 2.0 * sigma_m,
            "{registration}"
        );
    }
}

#[test]
fn without_identity_position_and_motion_join_the_same_reports() {
    let Some(data) = recordings("lebl2016") else { return };
    let inputs = decode_inputs(&data);
    let rows = read_system_tracks(&replay(&data, &["--set", "fusion.association.use_identity=false"]));
    let address_of: BTreeMap<(u32, i64), u32> = inputs.reports[MLAT]
        .iter()
        .map(|report| {
            (
                (report.track_number, report.time_of_measurement_ns),
                report.identity.address().unwrap(),
            )
        })
        .collect();

    let (mut agree, mut joined) = (Share::default(), Share::default());
    at_whole_seconds(&inputs, &rows, |moment| {
        for row in moment.tracks.values() {
            if let (Some(mlat), Some((adsb, _))) = (row.fresh(MLAT, moment.now_ns), row.fresh(ADSB, moment.now_ns)) {
                // An ADS-B track is numbered by its address.
                agree.add(address_of[&mlat] == adsb);
            }
        }
        for (address, mlat) in moment.mlat.iter().filter(|(_, report)| moment.is_fresh(report)) {
            let Some(adsb) = moment.adsb.get(address).filter(|report| moment.is_fresh(report)) else {
                continue;
            };
            if moment.apart(mlat, adsb) <= 60.0 {
                joined.add(moment.tracks.values().any(|row| {
                    let of =
                        |source: usize, track: u32| row.fresh(source, moment.now_ns).is_some_and(|(id, _)| id == track);
                    of(MLAT, mlat.track_number) && of(ADSB, *address)
                }));
            }
        }
    });
    agree.at_least("joined reports agree in address", 0.99, 10_000);
    joined.at_least("reports within 60 m are joined", 0.90, 10_000);
}

/// At full speed, and at a speed at which the processes wait for each other in other ways.
#[test]
fn the_files_are_the_same_in_every_run_and_at_every_speed() {
    let Some(data) = recordings("lebl2016") else { return };
    let files = undisturbed(&data);
    let slower = files_at("1500", &|home, speed| start(home, &data, &["--speed", speed]));
    assert_equal(files, &slower);
    let files = tables(files);
    assert_eq!(files.len(), 4, "{:?}", files.keys());
    assert!(files.values().all(|bytes| bytes.len() > 1_000_000));
    golden("replay_2016.txt", &hashes(&files));
}

/// Another day, on which many tracks end as others begin: two sensors without ADS-B.
#[test]
fn the_files_of_a_busy_day_are_the_same_in_every_run_and_at_every_speed() {
    let Some(data) = recordings("lebl2020") else { return };
    let text = std::fs::read_to_string(repository(CONFIGURATION)).unwrap();
    let ads_b = text.rfind("[[source]]").unwrap()..text.find("[fusion]\n").unwrap();
    assert!(text[ads_b.clone()].contains("name = \"ads-b\""));
    let text = text.replace(&text[ads_b], "").replace("2016-05-10", "2020-10-02");
    let text = text.replace(
        "lebl2016/160510-lebl-220001_SMR_cat10.ast",
        "lebl2020/201002-lebl-080001_SMR_cat10.ast",
    );
    let text = text.replace(
        "lebl2016/160510-lebl-220001_MLAT_cat20.ast",
        "lebl2020/201002-lebl-080001_MLAT_cat10.ast",
    );
    let text = text.replace(
        "editions = { \"19\" = \"1.3\", \"20\" = \"1.9\" }",
        "editions = { \"10\" = \"1.1\" }",
    );
    let start = |home: &Home, speed: &str| {
        home.write("day.toml", &text);
        let up = [
            "up",
            "day.toml",
            "--instance",
            INSTANCE,
            "--data",
            data.to_str().unwrap(),
            "--out",
            "out",
        ];
        home.start(&[&up[..], &["--speed", speed]].concat())
    };
    let [files, slower] = ["max", "1000"].map(|speed| files_at(speed, &start));
    assert_equal(&files, &slower);
    let files = tables(&files);
    assert_eq!(files.len(), 3, "{:?}", files.keys());
    golden("replay_2020.txt", &hashes(&files));
}

/// The files of a replay at this speed.
fn files_at(speed: &str, start: &dyn Fn(&Home, &str) -> Running) -> Files {
    let home = Home::new();
    let (status, said) = start(&home, speed).end();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left(INSTANCE);
    files_of(&home.path("out/latest"))
}

/// Two runs have the same tables.
fn assert_equal(first: &Files, second: &Files) {
    let (first, second) = (tables(first), tables(second));
    assert!(
        first.keys().eq(second.keys()),
        "{:?}, {:?}",
        first.keys(),
        second.keys()
    );
    let differs = first.iter().find(|(name, bytes)| second[*name] != **bytes);
    assert!(differs.is_none(), "{} differs", differs.unwrap().0);
}

/// A line about the states in each of these files.
fn hashes(files: &BTreeMap<&str, &[u8]>) -> String {
    let state = ["time_s", "x", "y", "z", "vx", "vy", "vz", "state", "address"];
    let mut out = String::new();
    for (name, bytes) in files {
        let text = std::str::from_utf8(bytes).unwrap();
        out += &hash_of_columns(&format!("{name}, states"), text, state);
        out += &hash_of_columns(&format!("{name}, covariances"), text, COVARIANCE);
    }
    let fused = std::str::from_utf8(files["system_tracks.csv"]).unwrap();
    let of_fusion = [
        "system_track_id",
        "sources",
        "weights",
        "selected",
        "lambda",
        "sensor_track_ids",
    ];
    out + &hash_of_columns("system_tracks.csv, contributions", fused, of_fusion)
}

/// Rows that died with a recorder are missed and said to be, to the row; nothing is written twice, whoever is killed.
#[test]
fn what_died_with_a_recorder_is_counted_and_nothing_is_written_twice() {
    let Some(data) = recordings("lebl2016") else { return };
    let undisturbed = undisturbed(&data);
    let home = Home::new();
    // More than a minute, most of which is left when all kills have come: on a busy machine, too, they come before the
    // recordings end.
    let running = start(&home, &data, &["--speed", "100"]);
    let file = home.path("out/latest/sensor_tracks_ads-b.csv");
    let size = || std::fs::metadata(&file).map_or(0, |file| file.len());
    for name in [
        "recorder",
        "multilateration",
        "recorder",
        "fusion",
        "recorder",
        "ads-b",
        "recorder",
        "radar",
    ] {
        let before = size();
        until("work goes on", || size() > before + 100_000);
        let victim = home.status_row(name).pid;
        kill(victim, Signal::KILL);
        until("it is back", || {
            let row = home.status_row(name);
            row.pid != victim && row.state == "running"
        });
    }
    let before = size();
    until("work goes on", || size() > before + 100_000);
    let (status, said) = running.stop();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left(INSTANCE);
    let report: serde_json::Value = serde_json::from_str(&home.read("out/latest/report.json")).unwrap();
    let hops = report["losses"]["hops"].as_array().unwrap();
    let mut missing = 0;
    for name in ["radar", "multilateration", "ads-b"] {
        let file = format!("sensor_tracks_{name}.csv");
        let whole = std::str::from_utf8(&undisturbed[&file]).unwrap();
        let found = home.read(&format!("out/latest/{file}"));
        let mut rest = whole.lines();
        let mut lacks = 0;
        // In the same order, each at most once.
        for row in found.lines() {
            let Some(passed_over) = rest.position(|other| other == row) else {
                panic!("{name}: {row} comes twice, or was never published")
            };
            lacks += passed_over as u64;
        }
        let announced: u64 = hops
            .iter()
            .filter(|hop| hop["from"] == name && hop["to"] == "recorder")
            .map(|hop| hop["lost"].as_u64().unwrap())
            .sum();
        assert_eq!(lacks, announced, "{name}: {report}");
        missing += lacks;
    }
    println!("{missing} rows died with four recorders");
}

#[test]
fn a_killed_adapter_leaves_no_trace_in_the_files() {
    let Some(data) = recordings("lebl2016") else { return };
    let home = Home::new();
    let running = start(&home, &data, &["--speed", "1500"]);
    for name in ["multilateration", "radar"] {
        let file = home.path(&format!("out/latest/sensor_tracks_{name}.csv"));
        // Killed in the middle of its work, not while it starts.
        until("it has begun", || {
            std::fs::metadata(&file).is_ok_and(|file| file.len() > 200_000)
        });
        let victim = home.status_row(name).pid;
        kill(victim, Signal::KILL);
        until("it is back", || home.status_row(name).pid != victim);
    }
    let (status, said) = running.end();
    assert!(status.success(), "{said}");
    home.assert_nothing_is_left(INSTANCE);
    assert_equal(undisturbed(&data), &files_of(&home.path("out/latest")));
    assert!(
        home.read("out/latest/report.json").contains("SIGKILL"),
        "the report says so"
    );
}
