//! Gross errors of one radar, among three and among two: told within a minute of data, taken off where it is sure whose
//! they are.

use std::collections::BTreeSet;

use ::settings::Degrees;
use fusion::settings::{AccuracyTable, CorrectionTable, Settings, SourceSettings, Weighing};
use fusion::{Engine, Sink};
use messages::{Bias, BiasKind, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use scenario::{ScenarioSettings, SensorIdentity, SensorKind, SensorSettings, SimulatedSensor, Truth};
use test_support::S;

const PLACES_M: [[f64; 2]; 3] = [[50e3, 0.0], [-30e3, 45e3], [-25e3, -40e3]];
const PERIODS_S: [f64; 3] = [4.0, 5.0, 6.0];
/// Place of a radar, east and north, metres, and its period, seconds: of further radars, on a circle.
fn site(number: usize) -> ([f64; 2], f64) {
    let Some((place_m, period_s)) = PLACES_M.get(number).zip(PERIODS_S.get(number)) else {
        let (north, east) = (2.4 * number as f64).sin_cos();
        return ([40e3 * east, 40e3 * north], 4.0 + (number % 3) as f64);
    };
    (*place_m, *period_s)
}

/// The radar that is off.
const ERRING: usize = 1;
/// Data that must be enough to tell, seconds.
const ENOUGH_S: f64 = 60.0;

#[derive(Clone, Copy)]
struct Case {
    kind: BiasKind,
    value: f64,
}

const CASES: [Case; 4] = [
    Case {
        kind: BiasKind::Azimuth,
        value: 0.5 * std::f64::consts::PI / 180.0,
    },
    Case {
        kind: BiasKind::Azimuth,
        value: 3.0 * std::f64::consts::PI / 180.0,
    },
    Case {
        kind: BiasKind::Range,
        value: 500.0,
    },
    Case {
        kind: BiasKind::Time,
        value: 30.0,
    },
];

/// Reports of so many radars of `seconds` of one world, in the order of the times they came; one has the error.
fn reports(seed: u64, radars: usize, seconds: f64, case: Option<Case>) -> Vec<(i64, SensorTrack)> {
    reports_of(seed, radars, seconds, case, SensorIdentity::None)
}

/// The same with what the radars tell of identities.
fn reports_of(
    seed: u64,
    radars: usize,
    seconds: f64,
    case: Option<Case>,
    identity: SensorIdentity,
) -> Vec<(i64, SensorTrack)> {
    let world = ScenarioSettings {
        targets: 30,
        terminal_share: 0.0,
        holding_share: 0.0,
        surface_share: 0.0,
        ..ScenarioSettings::default()
    };
    let truth = Truth::new(&world, seed).unwrap();
    let mut all = Vec::new();
    for number in 0..radars {
        let (place_m, period_s) = site(number);
        let mut settings = SensorSettings {
            position_m: Some([place_m[0], place_m[1], 0.0]),
            period_s: Some(period_s),
            identity: Some(identity),
            height_sigma_m: Some(50.0),
            ..SensorSettings::new(SensorKind::Radar)
        };
        let error = case.filter(|_| number == ERRING);
        match error {
            Some(Case {
                kind: BiasKind::Azimuth,
                value,
            }) => settings.azimuth_bias_rad = Some(value),
            Some(Case {
                kind: BiasKind::Range,
                value,
            }) => settings.range_bias_m = Some(value),
            _ => {}
        }
        let fast_ns = match error {
            Some(Case {
                kind: BiasKind::Time,
                value,
            }) => (value * S as f64) as i64,
            _ => 0,
        };
        let mut sensor = SimulatedSensor::new(&settings, seed, number as u16, 0).unwrap();
        let mut found = Vec::new();
        while sensor.next_scan_time_s() < seconds {
            sensor.scan(&truth, &mut found);
        }
        all.extend(found.iter().map(|report| {
            let mut report = *report;
            let came_ns = report.time_of_measurement_ns;
            report.source = number as u16;
            report.time_of_measurement_ns += fast_ns;
            (came_ns, report)
        }));
    }
    all.sort_by_key(|(came_ns, report)| (*came_ns, report.source, report.track_number));
    all
}

fn settings(radars: usize, gross: bool) -> Settings {
    let source = |number: usize| {
        let (place_m, period_s) = site(number);
        let usual = (period_s, number as u32);
        let name = format!("radar-{number}");
        let accuracy = AccuracyTable::default();
        let mut source = SourceSettings::new(&name, &Weighing::default(), usual, place_m, &accuracy).unwrap();
        source.place_m = Some(place_m);
        source
    };
    let mut settings = Settings::default();
    settings.registration.gross = gross;
    settings.with_sources((0..radars).map(source).collect()).unwrap()
}

/// Lets an engine take the reports in the order in which they came; a clock that is far off is marked, as adapters do.
fn run(settings: Settings, reports: &[(i64, SensorTrack)], sink: &mut impl Sink) -> Engine {
    let mut engine = Engine::new(settings).unwrap();
    for (came_ns, report) in reports {
        let mut report = *report;
        if (report.time_of_measurement_ns - came_ns).abs() > 5 * S {
            report.valid |= sensor_track_bits::WILD_CLOCK;
        }
        engine.take_at(&report, *came_ns, sink);
    }
    engine
}

fn nobody() -> impl Sink {
    |_: &SystemTrack| {}
}

fn is_near(error: Bias, case: Case) -> bool {
    error.kind == case.kind && (error.value[0] - case.value).abs() < 0.1 * case.value
}

#[test]
fn of_three_radars_the_one_that_is_off_is_told_and_put_right_where_that_is_wanted() {
    for (seed, case) in (1..).zip(CASES) {
        let reports = reports(seed, 3, ENOUGH_S, Some(case));
        for gross in [false, true] {
            let engine = run(settings(3, gross), &reports, &mut nobody());
            let error = engine.sources().gross_error(ERRING as u16).expect("an error is told");
            assert!(is_near(error, case), "{error}");
            assert_eq!((error.is_certain, error.is_removed), (true, gross), "{error}");
            for other in [0, 2] {
                assert_eq!(engine.sources().gross_error(other), None, "{error}");
            }
        }
    }
}

#[test]
fn of_twenty_radars_the_one_that_is_off_is_told_although_not_all_pairs_are_compared() {
    for case in CASES {
        let engine = run(settings(20, true), &reports(3, 20, ENOUGH_S, Some(case)), &mut nobody());
        let found: Vec<usize> = (0..20u16)
            .filter(|source| engine.sources().gross_error(*source).is_some())
            .map(usize::from)
            .collect();
        assert_eq!(found, [ERRING], "{:?} {}", case.kind, case.value);
        assert!(is_near(engine.sources().gross_error(ERRING as u16).unwrap(), case));
    }
}

#[test]
fn of_two_radars_nobody_knows_which_is_off_and_nothing_is_taken_off() {
    for (seed, case) in (11..).zip(CASES) {
        let reports = reports(seed, 2, ENOUGH_S, Some(case));
        let engine = run(settings(2, true), &reports, &mut nobody());
        let told: Vec<Bias> = (0..2)
            .filter_map(|source| engine.sources().gross_error(source))
            .collect();
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(!told[0].is_certain && !told[0].is_removed, "{told:?}");
        // It may be that the other one is off the other way.
        let of_erring = engine.sources().gross_error(ERRING as u16).is_some();
        let sign = if of_erring { 1.0 } else { -1.0 };
        let as_told = Case {
            value: case.value,
            ..case
        };
        let turned = Bias {
            value: told[0].value.map(|part| sign * part),
            ..told[0]
        };
        assert!(is_near(turned, as_told), "{told:?}");
    }
}

#[test]
fn a_reference_source_says_which_of_two_is_off() {
    for (seed, case) in (21..).zip(CASES) {
        let reports = reports(seed, 2, ENOUGH_S, Some(case));
        let mut settings = settings(2, true);
        settings.registration.reference_source = Some(0.into());
        let engine = run(settings, &reports, &mut nobody());
        let error = engine.sources().gross_error(ERRING as u16).expect("an error is told");
        assert!(is_near(error, case) && error.is_removed, "{error}");
    }
}

#[test]
fn codes_show_half_a_degree_within_a_minute_and_the_value_that_is_told_ends_it() {
    let degrees = |value: f64| value * std::f64::consts::PI / 180.0;
    for seed in 51..54 {
        let case = Case {
            kind: BiasKind::Azimuth,
            value: degrees(0.5),
        };
        let reports = reports_of(seed, 2, ENOUGH_S, Some(case), SensorIdentity::Mode3A);
        let told = run(settings(2, false), &reports, &mut nobody());
        let told: Vec<(u16, Bias)> = (0..2)
            .filter_map(|source| Some((source, told.sources().gross_error(source)?)))
            .collect();
        let &[(source, error)] = &told[..] else {
            panic!("seed {seed}: {told:?}");
        };
        let size = error.value[0].abs();
        assert!(
            error.kind == BiasKind::Azimuth && (size - degrees(0.5)).abs() < degrees(0.05),
            "{error}"
        );
        // Whichever of the two is blamed: with its value taken off, both agree.
        let mut mended = settings(2, false);
        mended.sources[usize::from(source)].correction = Some(CorrectionTable {
            azimuth_deg: Degrees::of(error.value[0].to_degrees()),
            ..CorrectionTable::default()
        });
        let engine = run(mended, &reports, &mut nobody());
        assert!(
            (0..2).all(|source| engine.sources().gross_error(source).is_none()),
            "seed {seed}"
        );
    }
}

#[test]
fn sound_radars_have_no_gross_errors() {
    for seed in 31..35 {
        for radars in [2, 3] {
            let engine = run(
                settings(radars, true),
                &reports(seed, radars, 90.0, None),
                &mut nobody(),
            );
            for source in 0..radars as u16 {
                assert_eq!(engine.sources().gross_error(source), None);
            }
        }
    }
}

#[test]
fn what_is_taken_off_lets_the_tracks_join() {
    for (seed, case) in (42..).zip(&CASES[1..]) {
        let case = *case;
        let reports = reports(seed, 3, 120.0, Some(case));
        let end_ns = reports.last().unwrap().0;
        let together = |gross: bool| {
            let mut with = 0;
            run(settings(3, gross), &reports, &mut |track: &SystemTrack| {
                let late = track.reference_time_ns > end_ns - 20 * S;
                let sources = track.contributions().iter().map(|contribution| contribution.source);
                let erring = sources.clone().any(|source| usize::from(source) == ERRING);
                with += u32::from(late && erring && sources.count() > 1);
            });
            with
        };
        let (without, with) = (together(false), together(true));
        assert!(with > 100 && with > 2 * without, "{:?} {without} {with}", case.kind);
    }
}

/// Numbers of tracks shown in the last minute: those of the erring radar alone, and the others.
fn shown(reports: &[(i64, SensorTrack)]) -> (usize, usize) {
    let end_ns = reports.last().unwrap().0;
    let [mut alone, mut others] = [(); 2].map(|()| BTreeSet::new());
    let mut settings = settings(3, false);
    // Claims of the radar alone are believed soon.
    settings.existence.persistence = 1.0;
    run(settings, reports, &mut |track: &SystemTrack| {
        let is_shown = [TrackState::Confirmed as u8, TrackState::Coasted as u8].contains(&track.state);
        if is_shown && track.reference_time_ns > end_ns - 60 * S {
            let sources = track
                .contributions()
                .iter()
                .map(|contribution| usize::from(contribution.source));
            let is_alone = sources.clone().count() > 0 && sources.clone().all(|source| source == ERRING);
            let set = if is_alone { &mut alone } else { &mut others };
            set.insert(track.track_number);
        }
    });
    (alone.len(), others.len())
}

#[test]
fn targets_of_a_radar_that_is_off_are_not_shown_twice_unless_their_codes_are_others() {
    let case = Case {
        kind: BiasKind::Azimuth,
        value: 2.0 * std::f64::consts::PI / 180.0,
    };
    let (alone, others) = shown(&reports(52, 3, 240.0, Some(case)));
    assert!(others >= 20 && alone <= 2, "{alone} beside {others}");
    let mut named = reports_of(52, 3, 240.0, Some(case), SensorIdentity::Mode3A);
    for (_, report) in named
        .iter_mut()
        .filter(|(_, report)| usize::from(report.source) == ERRING)
    {
        let code = report.identity.mode_3a().unwrap();
        report.identity = report.identity.with_mode_3a(code ^ 0o1111);
    }
    let (alone, others) = shown(&named);
    assert!(others >= 20 && alone >= 20, "{alone} beside {others}");
}
