//! The plots and tracks of en-route radars, recorded, on their way into sensor tracks.
//!
//! The recordings do not say where the radars stand; any place will do, as what is checked does not depend on it: that
//! each plot comes to lie at its own range, azimuth and height, that aircraft move as their own computers say in
//! register 5,0, and that a radar's track lies where its plot does.

use std::f64::consts::{PI, TAU};

use asterix::{Decoder, Mode, NamedRecord, Record, Value};
use formats::containers::datagrams;
use formats::observation::{self, Reading};
use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{Counter, Counters, SensorTrack, sensor_track_bits as bits};
use observations::Observation;
use reception::{
    ConversionModel, Converter, CovarianceFrom, CovarianceModel, PlausibilityLimits, PoorQuality, PositionForm,
};
use test_support::S;
use test_support::recording;

/// One radar's plots.
const PLOTS: &str = "akapetanovic/Jahorina.raw";
/// A network of several radars, of which four send tracks with their plots.
const TRACKS: &str = "cro/cat_034_048.pcap";

/// The system around the radar's supposed place, 100 km to the south-east.
fn model() -> ConversionModel {
    let system = SystemFrame::at(Geodetic::from_degrees(43.0, 19.3, 0.0).unwrap());
    let place = Geodetic::from_degrees(43.72, 18.57, 1900.0).unwrap();
    ConversionModel {
        is_on_board: false,
        number: 0,
        sac_sic: Some((23, 2)),
        method: Default::default(),
        positions: PositionForm::Any,
        frame: SensorFrame::new(&system, place, 0.0),
        system,
        height_m: place.height_m(),
        assumed_height_m: 5000.0,
        qnh_hpa: messages::STANDARD_PRESSURE_HPA,
        limits: PlausibilityLimits {
            range_m: 400e3,
            height_min_m: -500.0,
            height_max_m: 20e3,
            speed_mps: 350.0,
            jump_m: 1000.0,
            time_step_s: Some(settings::Seconds::of_ns(60 * S)),
            tracks: 1000,
        },
        covariance: CovarianceModel {
            from: CovarianceFrom::Configuration,
            position_sigma_m: 100.0,
            velocity_sigma_mps: 2.0,
            unstated_position_sigma_m: None,
            unstated_velocity_sigma_mps: None,
            height_sigma_m: 50.0,
            range_sigma_m: Some(30.0),
            azimuth_sigma_deg: Some(settings::Degrees::of(0.03)),
            doppler_sigma_mps: None,
            doppler_towards: false,
            poor_quality: PoorQuality::Use,
        },
    }
}

/// One plot, what it became, and the velocity that the aircraft sent with it.
struct Seen {
    plot: Observation,
    track: SensorTrack,
    /// Speed in m/s and true track in rad.
    sent: Option<[f64; 2]>,
}

/// The plots in the order recorded. The recording's second half is of the time before its first: it gets a converter of
/// its own. Gives what was counted by both.
fn convert(bytes: &[u8]) -> (Vec<Seen>, Counters) {
    let mut decoder = Decoder::new(Mode::Strict);
    let mut converters = vec![Converter::new(model(), 0)];
    let mut seen: Vec<Seen> = Vec::new();
    for record in decoder.records(bytes) {
        let record = record.unwrap();
        let sent = register_5_0(&record).and_then(track_and_turn);
        match observation::read(&record) {
            Reading::Target(plot) => {
                if plot.time_of_day_ns.unwrap() < converters[converters.len() - 1].running_ns().unwrap_or(0) - 60 * S {
                    converters.push(Converter::new(model(), 0));
                }
                let converter = converters.last_mut().unwrap();
                if let Some(track) = converter.convert(&plot, 0) {
                    seen.push(Seen { plot, track, sent });
                }
            }
            Reading::Service(service) => {
                let _ = converters.last_mut().unwrap().service(service.time_of_day_ns);
            }
            Reading::Other => panic!("{record:?}"),
        }
    }
    assert_eq!(converters.len(), 2);
    let mut counted = Counters::default();
    converters.iter().for_each(|converter| counted += converter.counters());
    (seen, counted)
}

/// The 56 bits of register 5,0 of the aircraft's transponder, if I048/250 has it.
fn register_5_0(record: &Record<'_>) -> Option<u64> {
    let named = NamedRecord::new(record);
    let Some(Value::List(registers)) = named.get(&["250"]) else {
        return None;
    };
    registers.iter().find_map(|register| {
        let Value::Group(parts) = register else { return None };
        let number = |name| parts.iter().find(|(part, _)| *part == name)?.1.as_u64();
        (number("BDS1") == Some(5) && number("BDS2") == Some(0)).then(|| number("MBDATA"))?
    })
}

/// Ground speed and true track of register 5,0: ICAO Doc 9871, table A-2-80.
fn track_and_turn(bits: u64) -> Option<[f64; 2]> {
    let field = |first: u32, last: u32| bits >> (56 - last) & ((1 << (last - first + 1)) - 1);
    let (has_track, has_speed) = (field(12, 12) == 1, field(24, 24) == 1);
    let track_rad = field(14, 23) as f64 * (PI / 1024.0) - if field(13, 13) == 1 { PI } else { 0.0 };
    let speed_mps = field(25, 34) as f64 * (2.0 * 1852.0 / 3600.0);
    (has_track && has_speed).then_some([speed_mps, track_rad])
}

#[test]
fn every_plot_lies_at_its_range_azimuth_and_height() {
    let Some(bytes) = recording(PLOTS) else { return };
    let (seen, counted) = convert(&bytes);
    let model = model();
    let mut placed = 0;
    for seen in &seen {
        if !seen.track.has(bits::HEIGHT) {
            continue;
        }
        let [range, azimuth] = seen.plot.slant_polar.unwrap();
        let sighting = model.frame.sighting(seen.track.position_m);
        assert!((sighting.slant_range_m - range).abs() < 0.01, "{sighting:?} {range}");
        assert!((sighting.azimuth_rad - azimuth).abs() < 1e-9, "{sighting:?} {azimuth}");
        let height = model.system.to_geodetic(seen.track.position_m).height_m();
        let sent = seen.plot.pressure_altitude_m.unwrap();
        assert!((height - sent).abs() < 0.1, "{height} {sent}");
        placed += 1;
    }
    let count = |counter: Counter| counted[counter];
    // 49 plots have no address to number them by. Two of the rest have no height, nor had their aircraft before.
    let reports = count(Counter::Reports) as usize;
    assert_eq!(
        (reports, seen.len(), count(Counter::RejectedNoTrackNumber)),
        (2050, 2050, 49)
    );
    assert_eq!(
        (placed, count(Counter::HeightAssumed), count(Counter::RejectedJump)),
        (2045, 2, 0)
    );
}

#[test]
fn detections_keep_the_replies_of_their_plots() {
    let Some(bytes) = recording(PLOTS) else { return };
    let (seen, _) = convert(&bytes);
    let mut coded = 0;
    for plot in seen.iter().map(|seen| &seen.plot) {
        let reply = Converter::new(model(), 0).detect(plot).expect("a plot").reply;
        assert_eq!((reply.identity, reply.ages), (plot.identity, Default::default()));
        let level = plot.pressure_altitude_m.and_then(messages::level_of);
        assert_eq!((reply.level, reply.level_age_ms), (level, 0));
        coded += usize::from(reply.identity.mode_3a().is_some() && reply.identity.address().is_some());
    }
    assert!(coded > 1000, "{coded}");
}

#[test]
fn aircraft_move_as_they_say() {
    let Some(bytes) = recording(PLOTS) else { return };
    let (seen, _) = convert(&bytes);
    let model = model();
    let (mut faster, mut right, mut normal) = (vec![], vec![], vec![]);
    for seen in &seen {
        let (Some([speed, track]), true) = (seen.sent, seen.track.has(bits::DERIVED_VELOCITY)) else {
            continue;
        };
        // At the aircraft, where its own north is.
        let here = SensorFrame::new(&model.system, model.system.to_geodetic(seen.track.position_m), 0.0);
        let [east, north] = here.to_velocity([seen.track.velocity_mps[0], seen.track.velocity_mps[1]]);
        faster.push(east.hypot(north) - speed);
        right.push((east.atan2(north) - track + PI).rem_euclid(TAU) - PI);
        let error = [east - speed * track.sin(), north - speed * track.cos()];
        let [xx, xy, yy] = [(3, 3), (3, 4), (4, 4)].map(|(row, column)| seen.track.covariance.get(row, column));
        let square = (yy * error[0] * error[0] - 2.0 * xy * error[0] * error[1] + xx * error[1] * error[1])
            / (xx * yy - xy * xy);
        normal.push(square);
    }
    assert!(faster.len() > 700, "{}", faster.len());
    let [faster, right] = [faster, right].map(median);
    println!(
        "median: {faster:.2} m/s faster, {:.3}° to the right",
        right.to_degrees()
    );
    assert!(faster.abs() < 1.0 && right.to_degrees().abs() < 0.3);
    // Of two components, normal and as large as stated, half of the squares are below 1.4 and 99 % below 9.2. A few
    // plots are far worse than the others.
    let within = normal.iter().filter(|square| **square < 9.2).count() as f64 / normal.len() as f64;
    let typical = median(normal);
    println!(
        "normalised errors: median {typical:.2}, {:.1} % within bounds",
        100.0 * within
    );
    assert!((0.05..1.4).contains(&typical) && within > 0.9);
}

#[test]
fn a_track_lies_where_its_plot_does() {
    let Some(bytes) = recording(TRACKS) else { return };
    let mut decoder = Decoder::new(Mode::Lenient);
    let (mut both, mut curved) = (0, 0);
    for datagram in datagrams(&bytes).flatten() {
        for record in decoder.records(&datagram.bytes).flatten() {
            let Reading::Target(report) = observation::read(&record) else {
                continue;
            };
            // Numbers of different radars are different tracks; each report gets a converter of its own.
            let mut converter = Converter::new(
                ConversionModel {
                    sac_sic: None,
                    ..model()
                },
                0,
            );
            // Some are of tracks that were not seen in this turn, and have no position.
            let Some(track) = converter.convert(&report, 0).filter(|track| track.has(bits::MEASURED)) else {
                continue;
            };
            let [range, _] = report.slant_polar.unwrap();
            let [at, measured] = [track.position_m, track.measured_m].map(|position| model().frame.sighting(position));
            let further = at.slant_range_m - measured.slant_range_m;
            let turned = (at.azimuth_rad - measured.azimuth_rad + PI).rem_euclid(TAU) - PI;
            // The trackers smooth a little: 50 m and 0.08° at most.
            assert!(further.abs() < 50.0, "{further} m further");
            assert!(turned.to_degrees().abs() < 0.08, "{}° turned", turned.to_degrees());
            // Of these radars x and y give the straight distance: along the ground it is much shorter.
            let [x, y] = report.cartesian.unwrap();
            assert!((x.hypot(y) - range).abs() < 50.0);
            let height = report.pressure_altitude_m.unwrap() - model().height_m;
            curved += usize::from(range - (range * range - height * height).sqrt() > 150.0);
            both += 1;
        }
    }
    assert_eq!(both, 64, "tracks with plots");
    assert!(curved >= 25, "{curved} of them where the difference shows");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
