//! What a door leaves unknown is unknown to fusion: every door of tracks, every field that may be left out, and targets
//! that move. An unknown value taken for 0 shows as an error that the stated accuracy does not explain.

use std::collections::BTreeSet;

use formats::rows::Row as _;
use formats::sensor_tracks_csv::{SensorTrackReader, SensorTrackWriter};
use frames::{Geodetic, SystemFrame};
use fusion::settings::{Accuracy, SourceSettings};
use fusion::{Engine, Settings};
use koseki_client::TrackReport;
use koseki_client::observation::{Fields as _, Observation as _};
use messages::admission::Admission as _;
use messages::layout::Sample as _;
use messages::{AXES, Covariance, STATE_LEN, SensorTrack, SystemTrack, TrackState, sensor_track_bits as bits};
use sample_text::{LineFormat, LineWriter, SampleNames};
use test_support::{Random, S};

use super::fields::Fields;
use super::samples;
use super::tapped::TappedLines;

/// Reports after which an estimate is judged, and reports of a target.
const SETTLED: usize = 4;
const REPORTS: usize = 16;
const SEEDS: u64 = 2;
/// Largest mean of normalised squared errors, and share of states more than three standard deviations off: a Gaussian
/// error has 1 and 0.3 %.
const NEES_MAX: f64 = 1.5;
const OUTSIDE_MAX: f64 = 0.02;

/// A moving target and how it is seen.
#[derive(Clone, Copy)]
struct Flight {
    velocity_mps: [f64; AXES],
    period_s: f64,
    sigma_m: f64,
}

impl Flight {
    fn place_m(&self, time_s: f64) -> [f64; AXES] {
        std::array::from_fn(|axis| START_M[axis] + self.velocity_mps[axis] * time_s)
    }
}

const FLIGHTS: [Flight; 5] = [
    Flight {
        velocity_mps: [100.0, 0.0, 0.0],
        period_s: 0.4,
        sigma_m: 15.0,
    },
    Flight {
        velocity_mps: [-120.0, 160.0, 0.0],
        period_s: 1.0,
        sigma_m: 30.0,
    },
    Flight {
        velocity_mps: [90.0, -90.0, 8.0],
        period_s: 4.0,
        sigma_m: 40.0,
    },
    Flight {
        velocity_mps: [3.0, -4.0, 0.0],
        period_s: 3.0,
        sigma_m: 10.0,
    },
    Flight {
        velocity_mps: [0.0, 5.0, 0.0],
        period_s: 10.0,
        sigma_m: 10.0,
    },
];

/// What a sensor sees at a time.
#[derive(Clone, Copy)]
struct Seen {
    time_ns: i64,
    position_m: [f64; AXES],
    velocity_mps: [f64; AXES],
    sigma_m: f64,
}

const VELOCITY_SIGMA_MPS: f64 = 2.0;
const START_M: [f64; AXES] = [4e3, -2e3, 3e3];
const START_NS: i64 = 1_800_000_000_000_000_000;

/// Errors of states: mean of normalised squares, and share beyond three standard deviations.
#[derive(Debug, Default)]
struct Errors {
    square_sum: f64,
    outside: f64,
    states: f64,
}

impl Errors {
    fn add_state(&mut self, track: &SystemTrack, flight: &Flight) -> Result<(), String> {
        if track.velocity_valid == 0 {
            return Err(format!("the velocity of {:?} m/s is unknown", flight.velocity_mps));
        }
        let truth_m = flight.place_m((track.reference_time_ns - START_NS) as f64 / S as f64);
        let axes = if track.height_valid == 0 { 2 } else { AXES };
        for (axis, truth_m) in truth_m.into_iter().enumerate().take(axes) {
            let p = |row, column| track.covariance.get(row, column);
            let error = [
                track.position_m[axis] - truth_m,
                track.velocity_mps[axis] - flight.velocity_mps[axis],
            ];
            let variances = [p(axis, axis), p(axis, axis + AXES), p(axis + AXES, axis + AXES)];
            self.add(error, variances);
        }
        Ok(())
    }

    fn add(&mut self, error: [f64; 2], [pp, pv, vv]: [f64; 3]) {
        let [position, velocity] = error;
        let determinant = pp * vv - pv * pv;
        assert!(determinant > 0.0, "{pp} {pv} {vv}");
        let square = position * position * vv - 2.0 * position * velocity * pv + velocity * velocity * pp;
        self.square_sum += 0.5 * square / determinant;
        self.outside += f64::from(u8::from(position.abs() > 3.0 * pp.sqrt()));
        self.states += 1.0;
    }
}

/// Fuses what `report` makes of all flights, and judges the states; the text of the first refusal if it makes nothing.
fn judge(report: &dyn Fn(&Seen) -> Result<SensorTrack, String>) -> Result<(), String> {
    let mut errors = Errors::default();
    for flight in FLIGHTS {
        for seed in 0..SEEDS {
            let mut random = Random::new(1000 * seed + 7);
            let source = SourceSettings::of("own", flight.period_s, Accuracy::constant(flight.sigma_m));
            let mut engine = Engine::new(Settings::of(vec![source])).unwrap();
            // Sums of uniform numbers, of variance 1.
            let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
            let mut states = 0;
            for step in 0..REPORTS {
                let time_s = flight.period_s * step as f64;
                let seen = Seen {
                    time_ns: START_NS + (time_s * S as f64) as i64,
                    position_m: flight.place_m(time_s).map(|place| place + flight.sigma_m * normal()),
                    velocity_mps: flight.velocity_mps.map(|speed| speed + VELOCITY_SIGMA_MPS * normal()),
                    sigma_m: flight.sigma_m,
                };
                let mut published = None;
                engine.take(&report(&seen)?, &mut |track: &SystemTrack| published = Some(*track));
                // A first report waits for the end of its scan.
                let Some(track) = published.filter(|_| step + 1 >= SETTLED) else {
                    continue;
                };
                states += 1;
                errors.add_state(&track, &flight)?;
            }
            if states < REPORTS - SETTLED {
                return Err(format!("{states} states are published"));
            }
        }
    }
    let (nees, outside) = (errors.square_sum / errors.states, errors.outside / errors.states);
    println!("{nees:.2} {outside:.4}");
    if nees <= NEES_MAX && outside <= OUTSIDE_MAX {
        return Ok(());
    }
    Err(format!(
        "NEES {nees:.2}, {:.1} % beyond three standard deviations",
        100.0 * outside
    ))
}

fn frame() -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap())
}

/// A sample with every field of the motion.
fn whole(seen: &Seen) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: seen.time_ns,
        track_number: 3,
        valid: bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE | bits::OWN_COVARIANCE,
        position_m: seen.position_m,
        velocity_mps: seen.velocity_mps,
        covariance: Covariance::diagonal([seen.sigma_m; AXES], [VELOCITY_SIGMA_MPS; AXES]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// Fields of a sample that need nothing else to be known, by what they are for.
const SAMPLE_NEEDS: [&str; 5] = [
    "time_of_measurement_ns",
    "track_number",
    "source",
    "position_m",
    "state",
];
const SAMPLE_MOTION: [&str; 4] = ["valid", "velocity_mps", "covariance", "trace_m2"];
const SAMPLE_REST: [&str; 19] = [
    "sequence",
    "stages",
    "identity",
    "measured_m",
    "method",
    "alerts",
    "kind",
    "members",
    "level",
    "target_type",
    "extent",
    "movement",
    "shared_sources",
    "origin",
    "level_age_ms",
    "identity_ages",
    "existence",
    "turn_rate_radps",
    "pressure_offset_m",
];

#[test]
fn every_field_of_a_sample_is_walked() {
    let walked: BTreeSet<&str> = [&SAMPLE_NEEDS[..], &SAMPLE_MOTION, &SAMPLE_REST]
        .concat()
        .into_iter()
        .collect();
    let fields: BTreeSet<&str> = SensorTrack::LAYOUT.fields.iter().map(|field| field.name).collect();
    assert_eq!(walked, fields, "a new field needs a place in the walk");
}

#[test]
fn samples_without_bits_and_variances() {
    const OPTIONAL: [u16; 3] = [bits::HEIGHT, bits::VELOCITY, bits::VERTICAL_RATE];
    for unset in 0..1 << OPTIONAL.len() {
        for zeroes in 0..1 << STATE_LEN {
            // A position may lack its variances where the configuration has the accuracy.
            let result = judge(&|seen| {
                let mut report = whole(seen);
                for (place, bit) in OPTIONAL.iter().enumerate() {
                    report.valid &= if unset >> place & 1 == 1 { !bit } else { !0 };
                }
                let zeroed = (0..STATE_LEN).filter(|component| zeroes >> component & 1 == 1);
                zeroed.for_each(|component| report.covariance.set(component, component, 0.0));
                let fault = report.value_fault().map(|fault| fault.field);
                let expected = (0..2).find(|axis| zeroes >> axis & 1 == 1);
                match (&fault, expected) {
                    (None, None) => {}
                    (Some(field), Some(axis)) if field.contains(["east", "north"][axis]) => {}
                    _ => return Err(format!("{fault:?}")),
                }
                Ok(report)
            });
            assert_eq!(result, Ok(()), "bits {unset:03b}, variances {zeroes:06b}");
        }
    }
}

#[test]
fn samples_with_a_leftover_in_unknown_fields() {
    for bit in [bits::HEIGHT, bits::VELOCITY, bits::VERTICAL_RATE] {
        let result = judge(&|seen| {
            let mut report = whole(seen);
            report.valid &= !bit;
            report.position_m[2] = if bit == bits::HEIGHT {
                -9e3
            } else {
                report.position_m[2]
            };
            report.velocity_mps = [-250.0; AXES].map(|speed| if bit == bits::VELOCITY { speed } else { 0.0 });
            if bit != bits::VELOCITY {
                report.velocity_mps = [seen.velocity_mps[0], seen.velocity_mps[1], 300.0];
                report.valid &= !bits::VERTICAL_RATE;
            }
            // Known to a centimetre, says what is not known.
            for component in 3..STATE_LEN {
                let is_unknown = bit == bits::VELOCITY || component == 5;
                report
                    .covariance
                    .set(component, component, if is_unknown { 1e-4 } else { 4.0 });
            }
            Ok(report)
        });
        assert_eq!(result, Ok(()), "{bit}");
    }
}

#[test]
fn samples_with_a_trace_alone() {
    for valid in [0, bits::HEIGHT, bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE] {
        let result = judge(&|seen| {
            let mut report = whole(seen);
            report.valid = valid | bits::TRACE;
            (report.covariance, report.trace_m2) = (Covariance::default(), 2.0 * seen.sigma_m * seen.sigma_m);
            match report.value_fault() {
                Some(fault) => Err(fault.to_string()),
                None => Ok(report),
            }
        });
        assert_eq!(result, Ok(()), "{valid}");
    }
}

#[test]
fn what_is_zero_with_a_variance_is_known() {
    // A target that keeps its place: stated zeroes help, and are not taken for unknown.
    let seen = Seen {
        time_ns: START_NS,
        position_m: START_M,
        velocity_mps: [0.0; AXES],
        sigma_m: 30.0,
    };
    let source = SourceSettings::of("own", 1.0, Accuracy::constant(30.0));
    let mut engine = Engine::new(Settings::of(vec![source])).unwrap();
    let mut published = None;
    engine.take(&whole(&seen), &mut |track: &SystemTrack| published = Some(*track));
    engine.advance(START_NS + 2 * S, &mut |track: &SystemTrack| {
        published = published.or(Some(*track));
    });
    let track = published.unwrap();
    assert_eq!((track.velocity_valid, track.velocity_mps), (1, [0.0; AXES]));
    assert!(track.covariance.get(3, 3) < 4.0 * VELOCITY_SIGMA_MPS * VELOCITY_SIGMA_MPS);
}

/// The fields of a report in degrees, and in metres: value, and whether it may be left out.
fn stated(seen: &Seen, is_geographic: bool) -> Vec<(&'static str, f64)> {
    let [east, north, up] = seen.position_m;
    let [ve, vn, vu] = seen.velocity_mps;
    let mut fields = vec![
        ("sigma_m", seen.sigma_m),
        ("height_sigma_m", seen.sigma_m),
        ("velocity_sigma_mps", VELOCITY_SIGMA_MPS),
    ];
    if is_geographic {
        let place = frame().to_geodetic(seen.position_m);
        fields.extend([
            ("latitude", place.latitude_deg()),
            ("longitude", place.longitude_deg()),
            ("height_m", place.height_m()),
            ("speed_mps", ve.hypot(vn)),
            ("course_deg", ve.atan2(vn).to_degrees()),
            ("climb_mps", vu),
        ]);
    } else {
        fields.extend([
            ("east_m", east),
            ("north_m", north),
            ("up_m", up),
            ("velocity_east_mps", ve),
            ("velocity_north_mps", vn),
            ("velocity_up_mps", vu),
        ]);
    }
    fields
}

/// Fields of a report without which it is refused, and those that only go together.
const REPORT_NEEDS: [&str; 5] = ["sigma_m", "latitude", "longitude", "east_m", "north_m"];
const TOGETHER: [[&str; 3]; 2] = [
    ["speed_mps", "course_deg", "velocity_sigma_mps"],
    ["velocity_east_mps", "velocity_north_mps", "velocity_sigma_mps"],
];

/// How a field is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Absence {
    Missing,
    /// `null`, NaN, an empty cell.
    Nothing,
}

/// The report of the library (Rust, C, Python), or of a line.
fn reported(fields: &[(&str, f64)], without: &[&str], is_line: Option<Absence>) -> Result<SensorTrack, String> {
    let is_left_out = |name: &str| without.contains(&name);
    let report = match is_line {
        None => {
            let mut report = TrackReport {
                track: Some(3),
                ..TrackReport::default()
            };
            for (name, value) in fields.iter().filter(|(name, _)| !is_left_out(name)) {
                *report.number_mut(name).unwrap() = Some(*value);
            }
            report
        }
        Some(absence) => {
            let texts = fields
                .iter()
                .filter_map(|(name, value)| match (is_left_out(name), absence) {
                    (false, _) => Some(format!(", \"{name}\": {value}")),
                    (true, Absence::Nothing) => Some(format!(", \"{name}\": null")),
                    (true, Absence::Missing) => None,
                });
            let line = format!("{{\"track\": 3{}}}", texts.collect::<String>());
            Fields::of_line(line.as_bytes())
                .and_then(samples::track)
                .map_err(|fault| fault.to_string())?
        }
    };
    let sample = report.sample(&frame(), START_NS).map_err(|fault| fault.field)?;
    match sample.value_fault() {
        Some(fault) => Err(fault.field),
        None => Ok(sample),
    }
}

#[test]
fn reports_and_lines_without_fields() {
    let mut walked = BTreeSet::new();
    let seen = Seen {
        time_ns: START_NS,
        position_m: START_M,
        velocity_mps: [10.0, 20.0, 1.0],
        sigma_m: 10.0,
    };
    for is_geographic in [true, false] {
        let names: Vec<&str> = stated(&seen, is_geographic).into_iter().map(|(name, _)| name).collect();
        walked.extend(names.iter().copied());
        let optional: Vec<&str> = names
            .iter()
            .copied()
            .filter(|name| !REPORT_NEEDS.contains(name))
            .collect();
        for subset in 0..1_usize << optional.len() {
            let chosen = optional
                .iter()
                .enumerate()
                .filter(|(place, _)| subset >> place & 1 == 1);
            let without: Vec<&str> = chosen.map(|(_, name)| *name).collect();
            for door in [None, Some(Absence::Missing), Some(Absence::Nothing)] {
                check_report(is_geographic, &without, door);
            }
        }
        for needed in names.iter().filter(|name| REPORT_NEEDS.contains(name)) {
            for door in [None, Some(Absence::Missing), Some(Absence::Nothing)] {
                let refused = reported(&stated(&seen, is_geographic), &[needed], door).unwrap_err();
                assert!(names.contains(&refused.as_str()), "{needed}: {refused}");
            }
        }
    }
    let numbers: BTreeSet<&str> = TrackReport::NUMBERS.iter().copied().collect();
    assert_eq!(walked, numbers, "a new field needs a place in the walk");
}

/// Judges reports without some fields; those of which a part is missing are refused by name.
fn check_report(is_geographic: bool, without: &[&str], door: Option<Absence>) {
    let together = TOGETHER[usize::from(!is_geographic)];
    let climb = if is_geographic { "climb_mps" } else { "velocity_up_mps" };
    let [first, second, sigma] = together.map(|name| !without.contains(&name));
    let has_climb = !without.contains(&climb);
    let is_whole = first == second && (sigma || !(first || has_climb));
    let result = judge(&|seen| {
        let report = reported(&stated(seen, is_geographic), without, door)?;
        Ok(SensorTrack {
            time_of_measurement_ns: seen.time_ns,
            ..report
        })
    });
    match (is_whole, result) {
        (true, result) => assert_eq!(result, Ok(()), "{door:?} without {without:?}"),
        (false, Err(field)) => assert!(together.contains(&field.as_str()), "{without:?}: {field}"),
        (false, Ok(())) => panic!("{door:?} without {without:?} is taken"),
    }
}

#[test]
fn reports_with_deviations_of_zero() {
    for (zero, door) in ["height_sigma_m", "velocity_sigma_mps"].into_iter().flat_map(|zero| {
        let doors = [None, Some(Absence::Missing)];
        doors.map(|door| (zero, door))
    }) {
        let result = judge(&|seen| {
            let mut fields = stated(seen, true);
            fields
                .iter_mut()
                .filter(|(name, _)| *name == zero)
                .for_each(|(_, value)| *value = 0.0);
            // A velocity that nobody measured.
            let is_velocity = |name: &str| zero == "velocity_sigma_mps" && name.ends_with("_mps");
            fields
                .iter_mut()
                .filter(|(name, _)| is_velocity(name))
                .for_each(|(_, value)| *value = 0.0);
            let report = reported(&fields, &[], door)?;
            Ok(SensorTrack {
                time_of_measurement_ns: seen.time_ns,
                ..report
            })
        });
        assert_eq!(result, Ok(()), "{zero} {door:?}");
    }
}

/// Columns of a table that a row needs: removed, or empty; and the variances of a position, which may not be 0 either.
const TABLE_NEEDS: [&str; 5] = ["time_s", "sensor_id", "sensor_track_id", "x", "y"];
const POSITION_VARIANCES: [&str; 2] = ["P00", "P11"];

/// The report of a row in a table without a column (`Missing`), or with another text in its cell.
fn of_table(seen: &Seen, changes: &[(&str, Option<&str>)]) -> Result<SensorTrack, String> {
    let mut writer = SensorTrackWriter::begin(Vec::new(), START_NS).unwrap();
    writer.write(&whole(seen)).unwrap();
    let text = String::from_utf8(writer.into_inner()).unwrap();
    let (header, row) = text.trim_end().split_once('\n').unwrap();
    let changed = |name: &str| {
        changes
            .iter()
            .find(|(column, _)| *column == name)
            .map(|(_, cell)| *cell)
    };
    let kept = header
        .split(',')
        .zip(row.split(','))
        .filter_map(|(name, cell)| match changed(name) {
            Some(None) => None,
            Some(Some(other)) => Some((name, other)),
            None => Some((name, cell)),
        });
    let (names, cells): (Vec<&str>, Vec<&str>) = kept.unzip();
    let table = format!("{}\n{}\n", names.join(","), cells.join(","));
    let reader = SensorTrackReader::new(table.as_bytes(), START_NS, |_| Some(0));
    let mut reader = reader.map_err(|error| error.to_string())?;
    reader.next().unwrap().map_err(|error| error.to_string())
}

#[test]
fn tables_without_columns_and_cells() {
    let header = SensorTrack::columns();
    let is_variance = |name: &str| (0..STATE_LEN).any(|component| name == format!("P{component}{component}"));
    for name in header.split(',') {
        let mut cells = vec![None, Some("")];
        cells.extend(
            is_variance(name)
                .then_some([Some("0"), Some("0.0000")])
                .into_iter()
                .flatten(),
        );
        for cell in cells {
            let result = judge(&|seen| of_table(seen, &[(name, cell)]));
            let needs_column = name.starts_with('P') && cell.is_none();
            if TABLE_NEEDS.contains(&name) || POSITION_VARIANCES.contains(&name) || needs_column {
                let refused = result.unwrap_err();
                // Without the first of them, there are none.
                let has_none = name == "P00" && cell.is_none() && refused.contains("no covariances");
                assert!(refused.contains(name) || has_none, "{name} {cell:?}: {refused}");
            } else {
                assert_eq!(result, Ok(()), "{name} {cell:?}");
            }
        }
    }
    // Several together, as sensors leave them out.
    let velocity = ["vx", "vy", "vz"];
    for groups in [
        &[&velocity[..]][..],
        &[&["z"]],
        &[&velocity, &["z"]],
        &[&["vz"], &["z"]],
    ] {
        for cell in [None, Some("")] {
            let changes: Vec<_> = groups.concat().into_iter().map(|name| (name, cell)).collect();
            assert_eq!(judge(&|seen| of_table(seen, &changes)), Ok(()), "{changes:?}");
        }
    }
    let flagged = [("velocity_valid", Some("0")), ("vx", Some("0")), ("vy", Some("0"))];
    let zeroed = ["P33", "P44", "P55"].map(|name| (name, Some("0")));
    assert_eq!(judge(&|seen| of_table(seen, &[&flagged[..], &zeroed].concat())), Ok(()));
}

#[test]
fn lines_of_tap_without_bits() {
    let names = SampleNames::new(vec!["own".to_owned()], frame());
    let lines = TappedLines::new(vec!["own".to_owned()], frame(), (0, Vec::new()));
    for unset in 0..8_u16 {
        let unknown = [bits::HEIGHT, bits::VELOCITY, bits::VERTICAL_RATE];
        let unknown = unknown.iter().enumerate().filter(|(place, _)| unset >> place & 1 == 1);
        let cleared = unknown.fold(0, |all, (_, bit)| all | bit);
        let result = judge(&|seen| {
            let mut report = whole(seen);
            report.valid &= !cleared;
            let mut text = Vec::new();
            let writer = LineWriter::new(&SensorTrack::LAYOUT, LineFormat::Json, Some(names.clone()));
            writer.write(SensorTrack::octets(&[report]), &mut text);
            let line: serde_json::Map<String, serde_json::Value> = serde_json::from_slice(&text).unwrap();
            for (bit, value) in [
                (bits::HEIGHT, &line["position_m"][2]),
                (bits::HEIGHT, &line["height_m"]),
                (bits::VELOCITY, &line["velocity_mps"][0]),
                (bits::VELOCITY, &line["velocity_mps"][1]),
                (bits::VERTICAL_RATE, &line["velocity_mps"][2]),
            ] {
                assert_eq!(value.is_null(), cleared & bit != 0, "{cleared:b} {line:?}");
            }
            lines.track(&line, 0).map_err(|fault| fault.to_string())
        });
        assert_eq!(result, Ok(()), "{unset:03b}");
    }
}
