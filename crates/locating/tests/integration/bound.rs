//! What the locator reaches, beside what nobody can exceed, in small versions of the scripted cases.

use crate::common::{Noise, bearing};
use locating::selection::Select;
use locating::settings::FilterChoice;
use locating::{DroppedEmitter, EmitterReport, Locator, LocatorDecisionKind, MotionModel, Settings, TurnSide};
use observations::Bearing;

/// The last report of a flight.
fn located(settings: Settings, bearings: impl IntoIterator<Item = Bearing>) -> Option<EmitterReport> {
    let mut locator = Locator::new(settings).unwrap();
    let mut last = None;
    for bearing in bearings {
        last = locator.bearing(&bearing).unwrap().or(last);
    }
    last
}

fn with_filter(filter: FilterChoice) -> Settings {
    let mut settings = Settings {
        emitters_max: 1,
        ..Settings::default()
    };
    settings.motion.filter = filter;
    settings
}

/// An emitter 50 km broadside of a straight baseline, `bearings` bearings in ten minutes.
fn broadside(seed: u64, baseline_m: f64, sigma_rad: f64, bearings: u32) -> Vec<Bearing> {
    let mut noise = Noise::new(seed);
    (0..bearings)
        .map(|step| {
            let share = f64::from(step) / f64::from(bearings - 1);
            let platform = [baseline_m * (share - 0.5), 0.0];
            bearing(
                600.0 * share,
                platform,
                [0.0, 50e3],
                sigma_rad,
                sigma_rad * noise.next(),
            )
        })
        .collect()
}

/// Cramér–Rao bound of the same, variances across and along.
fn bound_m2(baseline_m: f64, sigma_rad: f64, bearings: u32) -> [f64; 2] {
    let (mut across, mut along) = (0.0, 0.0);
    for step in 0..bearings {
        let east = baseline_m * (f64::from(step) / f64::from(bearings - 1) - 0.5);
        let squared = east * east + 2.5e9;
        across += (50e3 / squared / sigma_rad).powi(2);
        along += (east / squared / sigma_rad).powi(2);
    }
    // Broadside the two do not depend on each other.
    [1.0 / across, 1.0 / along]
}

/// Normalised squared error of the raw fix.
fn normalised(report: &EmitterReport, truth: [f64; 2]) -> f64 {
    let p = &report.raw.covariance;
    let [x, y] = [0, 1].map(|axis| report.raw.position_m[axis] - truth[axis]);
    let determinant = p[(0, 0)] * p[(1, 1)] - p[(0, 1)] * p[(0, 1)];
    (x * x * p[(1, 1)] - 2.0 * x * y * p[(0, 1)] + y * y * p[(0, 0)]) / determinant
}

/// Errors against the bound, and normalised: over 300 runs a root mean square is known to 4 %, a mean of chi-square
/// with two degrees of freedom to 0.12; limits are three times that.
fn check_broadside(filter: FilterChoice, baseline_m: f64, sigma_deg: f64, bearings: u32) {
    const RUNS: u64 = 300;
    let sigma_rad = f64::to_radians(sigma_deg);
    let (mut across, mut along, mut consistency) = (0.0, 0.0, 0.0);
    for seed in 0..RUNS {
        let flight = broadside(seed + 1, baseline_m, sigma_rad, bearings);
        let report = located(with_filter(filter), flight).expect("the geometry allows a fix");
        let [x, y] = report.raw.position_m;
        across += x * x / RUNS as f64;
        along += (y - 50e3).powi(2) / RUNS as f64;
        consistency += normalised(&report, [0.0, 50e3]) / RUNS as f64;
    }
    let bound = bound_m2(baseline_m, sigma_rad, bearings);
    let ratios = [(across / bound[0]).sqrt(), (along / bound[1]).sqrt()];
    assert!(ratios.iter().all(|ratio| *ratio < 1.12), "{ratios:?}");
    // The mixture admits that an emitter which seems fixed may drift, so its covariance is larger.
    let least = if filter == FilterChoice::Auto { 1.2 } else { 1.65 };
    assert!(
        (least..2.35).contains(&consistency),
        "normalised error squared {consistency}"
    );
}

#[test]
fn a_fixed_emitter_is_located_as_well_as_can_be() {
    for filter in [FilterChoice::Fixed, FilterChoice::Auto] {
        check_broadside(filter, 10e3, 1.0, 61);
        check_broadside(filter, 20e3, 1.0, 61);
        check_broadside(filter, 10e3, 0.5, 61);
    }
}

#[test]
fn many_bearings_in_bounded_memory_are_as_good() {
    check_broadside(FilterChoice::Fixed, 10e3, 2.0, 601);
}

/// A platform circles about a drifting emitter; the truth at the end beside it.
fn drifting(seed: u64, seconds: u32, velocity: [f64; 2]) -> (Vec<Bearing>, [f64; 2]) {
    let mut noise = Noise::new(seed);
    let place = |time: f64| velocity.map(|speed| speed * time);
    let sigma = f64::to_radians(2.0);
    let bearings = (0..seconds / 2).map(|step| {
        let time = 2.0 * f64::from(step);
        let angle = time / 60.0;
        let platform = [6e3 * angle.sin(), 6e3 * (1.0 - angle.cos()) + 100.0];
        bearing(time, platform, place(time), sigma, sigma * noise.next())
    });
    (bearings.collect(), place(f64::from(2 * (seconds / 2 - 1))))
}

#[test]
fn a_drifting_emitter_is_followed_and_a_still_one_is_known_to_be_still() {
    for seed in 1..=10 {
        let (bearings, truth) = drifting(seed, 1_800, [3.5, 2.0]);
        let report = located(with_filter(FilterChoice::Auto), bearings).unwrap();
        assert_eq!(report.raw.motion, MotionModel::Straight);
        assert!(normalised(&report, truth) < 16.0);
        assert!((report.raw.velocity_mps[0] - 3.5).abs() < 0.3 && (report.raw.velocity_mps[1] - 2.0).abs() < 0.3);
        let off: f64 = (0..2)
            .map(|axis| (report.output.position_m[axis] - truth[axis]).powi(2))
            .sum();
        assert!(off.sqrt() < 100.0, "output off by {} m", off.sqrt());

        let (bearings, truth) = drifting(seed, 1_800, [0.0, 0.0]);
        let report = located(with_filter(FilterChoice::Auto), bearings).unwrap();
        assert_eq!(report.raw.motion, MotionModel::Fixed);
        assert!(normalised(&report, truth) < 16.0);
    }
}

#[test]
fn an_emitter_that_starts_to_move_is_noticed() {
    let mut noise = Noise::new(3);
    let sigma = f64::to_radians(1.0);
    let mut truth = [1_000.0, 1_000.0];
    let mut locator = Locator::new(with_filter(FilterChoice::Auto)).unwrap();
    let mut last = None;
    for step in 0..3_000 {
        let time = 2.0 * f64::from(step);
        if time > 1_500.0 {
            truth[0] += 2.0 * 8.0;
        }
        let angle = time / 60.0;
        let platform = [truth[0] + 6e3 * angle.sin(), truth[1] + 6e3 * angle.cos()];
        let measured = bearing(time, platform, truth, sigma, sigma * noise.next());
        last = locator.bearing(&measured).unwrap();
        if time == 1_500.0 {
            assert_eq!(last.unwrap().raw.motion, MotionModel::Fixed);
        }
    }
    let raw = last.unwrap().raw;
    let off = (raw.position_m[0] - truth[0]).hypot(raw.position_m[1] - truth[1]);
    assert!(
        raw.motion != MotionModel::Fixed && off < 150.0,
        "{} off by {off} m",
        raw.motion.word()
    );
}

/// Past a still emitter, on for ten minutes, a turn by 180 degrees with bearings that are wrong by up to 9 degrees, and
/// back.
fn turning(seed: u64) -> Vec<Bearing> {
    let mut noise = Noise::new(seed);
    let sigma = f64::to_radians(2.0);
    let sign = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut platform = [0.0, 500.0];
    (0..751)
        .map(|step| {
            let time = 2.0 * f64::from(step);
            let turned = ((time - 600.0) / 60.0).clamp(0.0, 1.0) * std::f64::consts::PI;
            let heading = std::f64::consts::FRAC_PI_2 + turned;
            let wrong = sign * f64::to_radians(9.0) * turned.sin();
            let mut measured = bearing(time, platform, [0.0, 0.0], sigma, sigma * noise.next() + wrong);
            measured.heading_rad = Some(heading);
            platform = [platform[0] + 200.0 * heading.sin(), platform[1] + 200.0 * heading.cos()];
            measured
        })
        .collect()
}

#[test]
fn wrong_bearings_in_a_turn_are_set_aside_and_the_output_does_not_jump() {
    let mut squared = 0.0;
    for seed in 1..=20 {
        let mut locator = Locator::new(with_filter(FilterChoice::Auto)).unwrap();
        let mut before: Option<EmitterReport> = None;
        for measured in turning(seed) {
            let report = locator.bearing(&measured).unwrap();
            if let (Some(before), Some(report)) = (&before, &report)
                && report.time_ns > 500 * crate::common::S
            {
                let seconds = (report.time_ns - before.time_ns) as f64 * 1e-9;
                for axis in 0..2 {
                    let expected = before.output.position_m[axis] + before.output.velocity_mps[axis] * seconds;
                    assert!((report.output.position_m[axis] - expected).abs() < 1e-6);
                }
            }
            before = report.or(before);
        }
        let last = before.unwrap();
        let set_aside = locator.counts().set_aside;
        assert!((10..100).contains(&set_aside), "{set_aside} bearings set aside");
        assert_eq!(last.raw.motion, MotionModel::Fixed);
        squared += (last.raw.position_m[0].powi(2) + last.raw.position_m[1].powi(2)) / 20.0;
    }
    // The bound without the turn's bearings is 16.7 m; 20 runs know a root mean square to 11 %.
    assert!(f64::sqrt(squared) < 22.0, "{} m", squared.sqrt());
}

#[test]
fn every_selection_gives_a_continuous_output() {
    for select in Select::ALL.into_iter().filter(|select| *select != Select::None) {
        for filter in FilterChoice::ALL {
            let mut settings = with_filter(filter);
            settings.selection.select = select;
            let mut locator = Locator::new(settings).unwrap();
            let (mut before, mut lines): (Option<EmitterReport>, u32) = (None, 0);
            for measured in drifting(4, 3_600, [3.5, 2.0]).0 {
                let Some(report) = locator.bearing(&measured).unwrap() else {
                    continue;
                };
                // Fixes that have left the output are passed on; on a line, the output does not jump.
                let is_line = |report: &EmitterReport| !["passing", "first"].contains(&report.output.stage.word());
                if let Some(before) = before.filter(|before| is_line(before) && is_line(&report)) {
                    let seconds = (report.time_ns - before.time_ns) as f64 * 1e-9;
                    let expected = before.output.position_m[0] + before.output.velocity_mps[0] * seconds;
                    assert!(
                        (report.output.position_m[0] - expected).abs() < 1e-6,
                        "{select:?} {filter:?}"
                    );
                    lines += 1;
                }
                before = Some(report);
            }
            let has_minima = filter == FilterChoice::Fixed;
            assert!(
                lines > 500 || (select == Select::Minimum && !has_minima),
                "{select:?} {filter:?}: {lines}"
            );
        }
    }
}

/// Speed of a ship and its course, as a velocity, m/s.
fn sailing(knots: f64, course_deg: f64) -> [f64; 2] {
    let (sine, cosine) = course_deg.to_radians().sin_cos();
    [knots * 0.514_444 * sine, knots * 0.514_444 * cosine]
}

/// A ship 5 km away in bearing 80 degrees on course 220 degrees at 4 knots, heard every minute by another ship, which
/// sails 5 knots on course 140 degrees and, from minute 13 to 17, turns to `course_after_deg`. Each bearing with the
/// truth then. Distances and speeds are `scale` times as great: bearings stay the same.
fn ships(seed: u64, course_after_deg: f64, minutes: u32, scale: f64) -> Vec<(Bearing, [f64; 2])> {
    let mut noise = Noise::new(seed);
    let sigma = f64::to_radians(1.5);
    let start = sailing(scale * 5_000.0 / 0.514_444, 80.0);
    let velocity = sailing(scale * 4.0, 220.0);
    let (mut own, mut heard) = ([0.0; 2], Vec::new());
    for second in 0..=60 * minutes {
        let time = f64::from(second);
        let truth = [0, 1].map(|axis| start[axis] + velocity[axis] * time);
        if second.is_multiple_of(60) {
            heard.push((bearing(time, own, truth, sigma, sigma * noise.next()), truth));
        }
        let turned = ((time / 60.0 - 13.0) / 4.0).clamp(0.0, 1.0);
        let way = sailing(scale * 5.0, 140.0 + turned * (course_after_deg - 140.0));
        own = [own[0] + way[0], own[1] + way[1]];
    }
    heard
}

/// Until own ship turns, the range of a ship that may move is not observable: no fix is better than a certain one.
/// After the turn fixes are as good as the bearings allow (Cramér–Rao bounds without prior knowledge).
fn check_encounter(settings: Settings, scale: f64) {
    const RUNS: u64 = 60;
    let bounds_m = [(20, 162.0), (22, 73.0), (25, 43.6), (30, 52.4)].map(|(k, bound_m)| (k, scale * bound_m));
    let mut sums = [[0.0; 3]; 4];
    for seed in 1..=RUNS {
        let mut locator = Locator::new(settings).unwrap();
        for (k, (measured, truth)) in ships(seed, 20.0, 30, scale).iter().enumerate() {
            let report = locator.bearing(measured).unwrap();
            assert!(k > 14 || report.is_none(), "a fix after {k} minutes");
            let Some(place) = bounds_m.iter().position(|(at, _)| *at == k) else {
                continue;
            };
            let report = report.expect("the range is observable");
            let squared = |position: [f64; 2]| (position[0] - truth[0]).powi(2) + (position[1] - truth[1]).powi(2);
            let [x, y, _] = report.output.position_m;
            sums[place][0] += squared(report.raw.position_m) / RUNS as f64;
            sums[place][1] += squared([x, y]) / RUNS as f64;
            sums[place][2] += normalised(&report, *truth) / 2.0 / RUNS as f64;
        }
    }
    // 60 runs know a root mean square to 9 %, a mean of chi-square with two degrees of freedom over two to 0.13.
    for ([raw, output, consistency], (k, bound)) in sums.into_iter().zip(bounds_m) {
        assert!(raw.sqrt() < 1.3 * bound, "{} m after {k} minutes", raw.sqrt());
        assert!(
            output < 1.2 * 1.2 * raw,
            "{k}: output {} m, raw {} m",
            output.sqrt(),
            raw.sqrt()
        );
        assert!((0.5..1.6).contains(&consistency), "{consistency} after {k} minutes");
    }
}

#[test]
fn a_moving_ship_has_no_fix_until_its_range_is_observable_and_then_a_true_one() {
    check_encounter(with_filter(FilterChoice::Auto), 1.0);
}

/// An emitter at 41 m/s: with a standard deviation of 2 m/s for the velocities of most emitters, its fixes would come
/// in the second minute, hundred times farther off than stated.
#[test]
fn where_aircraft_are_expected_the_same_holds_for_a_fast_emitter() {
    let mut settings = with_filter(FilterChoice::Auto);
    settings.motion.speed_sigma_mps = 250.0;
    check_encounter(settings, 20.0);
}

#[test]
fn a_range_that_is_not_observable_names_the_turn_that_would_show_it() {
    let cues = |course_after_deg: f64| {
        let mut locator = Locator::new(with_filter(FilterChoice::Auto)).unwrap();
        let (mut cues, mut fix_at) = (Vec::new(), None);
        for (k, (measured, _)) in ships(5, course_after_deg, 30, 1.0).iter().enumerate() {
            let report = locator.bearing(measured).unwrap();
            fix_at = fix_at.or(report.map(|_| k));
            for decision in locator.decisions() {
                if let LocatorDecisionKind::RangeNeedsTurn(side) = decision.kind {
                    cues.push((k, side, decision.value, measured.bearing_rad.to_degrees()));
                }
            }
        }
        (cues, fix_at)
    };
    // Straight on, there is no fix in half an hour, and one cue: at right angles to the bearing, to its other side.
    let (straight_on, fix_at) = cues(140.0);
    assert_eq!(fix_at, None);
    let [(at, side, course_deg, bearing_deg)] = straight_on[..] else {
        panic!("{straight_on:?}");
    };
    assert!((2..=4).contains(&at) && side == TurnSide::Port, "{straight_on:?}");
    let off = (course_deg - bearing_deg + 90.0).to_radians().sin_cos();
    assert!(off.0.abs() < 1e-8 && off.1 > 0.0, "{course_deg} for {bearing_deg}");
    // A ship that follows the cue has a fix soon.
    let (_, fix_at) = cues(course_deg - 360.0);
    assert!(fix_at.is_some_and(|k| (15..=19).contains(&k)), "{fix_at:?}");
}

/// An emitter that was dropped at a known place and drifts: its place is known from the first bearing on, with the
/// covariance that the place, the time since and the bearings allow. Without the drop there is no fix at that time.
#[test]
fn a_dropped_emitter_is_located_by_its_first_bearings() {
    const RUNS: u64 = 400;
    let sigma_rad = f64::to_radians(2.0);
    for filter in [FilterChoice::Auto, FilterChoice::Fixed, FilterChoice::Straight] {
        let (mut consistency, mut located, mut first, mut unknown) = (0.0, 0_u32, 0, 0);
        for seed in 0..RUNS {
            let mut noise = Noise::new(seed + 1);
            let drop_m = [300.0, -200.0].map(|at| at + 50.0 * noise.next());
            let speed_mps = match filter {
                FilterChoice::Straight => [noise.next() * 30.0, noise.next() * 30.0],
                _ => [0.0; 2],
            };
            let heard: Vec<Bearing> = (1..=3)
                .map(|step| {
                    let time_s = 10.0 * f64::from(step);
                    let place = [0, 1].map(|axis| drop_m[axis] + speed_mps[axis] * time_s);
                    bearing(
                        time_s,
                        [3_000.0 + 100.0 * time_s, 5_000.0],
                        place,
                        sigma_rad,
                        sigma_rad * noise.next(),
                    )
                })
                .collect();
            let mut locator = Locator::new(with_filter(filter)).unwrap();
            unknown += u32::from(locator.bearing(&heard[0]).unwrap().is_some());
            let mut locator = Locator::new(with_filter(filter)).unwrap();
            locator.set_dropped(&[DroppedEmitter {
                emitter_id: heard[0].emitter_id.unwrap(),
                time_s: 0.0,
                position_m: [300.0, -200.0],
                sigma_m: 50.0,
            }]);
            let mut reports = heard.iter().map(|bearing| locator.bearing(bearing).unwrap());
            first += u32::from(reports.next().flatten().is_some());
            let last = reports.last().flatten();
            if let Some(report) = last {
                located += 1;
                let truth = [0, 1].map(|axis| drop_m[axis] + speed_mps[axis] * 30.0);
                consistency += 0.5 * normalised(&report, truth);
            }
        }
        let consistency = consistency / f64::from(located);
        println!(
            "{filter:?}: {located} of {RUNS} located by three bearings, normalised error squared {consistency:.2}"
        );
        assert_eq!((unknown, u64::from(located)), (0, RUNS), "{filter:?}");
        assert!(first > 380, "{filter:?}: {first} by the first bearing");
        assert!((0.8..1.25).contains(&consistency), "{filter:?}: {consistency}");
    }
}

/// The day of the drop is the one nearest to the first bearing.
#[test]
fn a_drop_before_midnight_is_of_the_day_before() {
    let midnight_s = 20_000.0 * 86_400.0;
    let sigma_m = |drop_s: f64| {
        let mut locator = Locator::new(with_filter(FilterChoice::Straight)).unwrap();
        let heard = bearing(midnight_s + 5.0, [5_000.0, 0.0], [0.0; 2], 0.01, 0.0);
        locator.set_dropped(&[DroppedEmitter {
            emitter_id: heard.emitter_id.unwrap(),
            time_s: drop_s,
            position_m: [0.0; 2],
            sigma_m: 50.0,
        }]);
        let report = locator.bearing(&heard).unwrap().expect("a place is known");
        report.raw.covariance[(0, 0)].sqrt()
    };
    // A place of 50 m and a speed of 30 m/s: for 15 s over midnight, and for 3 s. After a day there would be no fix.
    for (drop_s, time_s) in [(86_390.0, 15.0), (2.0, 3.0)] {
        let expected_m = f64::hypot(50.0, 30.0 * time_s);
        let sigma_m = sigma_m(drop_s);
        assert!((sigma_m - expected_m).abs() < 1.0, "{sigma_m}, {expected_m}");
    }
}
