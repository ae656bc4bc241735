//! Small cases with figures computed by hand.

use frames::{Geodetic, SystemFrame};
use scoring::{
    CaseSettings, Compared, ConfirmedTracks, FIX_WORDS, FileBasis, FixCase, FixError, FixFigures, FixInputError,
    FixRuns, FixScore, PICTURE_WORDS, PictureError, PictureScore, PictureSettings, RESOLUTION_WORDS, ResolutionScore,
    ResolutionSettings, TargetsByTime, Timeline, Word, score_picture,
};

fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
        "{found}, not {expected}"
    );
}

fn known(found: Option<f64>, expected: f64) {
    close(found.expect("there is such a figure"), expected);
}

// ---------------------------------------------------------------------------------------------------------------------
// Pictures.
// ---------------------------------------------------------------------------------------------------------------------

/// Target 1 flies north at 100 m/s, target 2 stands still.
const TRUTH: &str = "\
time_s,target_id,x,y,z,vx,vy,vz
10,1,0,0,0,0,100,0
10,2,10000,0,1000,0,0,0
11,1,0,100,0,0,100,0
11,2,10000,0,1000,0,0,0
12,1,0,200,0,0,100,0
12,2,10000,0,1000,0,0,0
13,1,0,300,0,0,100,0
13,2,10000,0,1000,0,0,0
";

/// 10 s: both targets have a track, one of them 50 m off. 11 s: target 2 has none (a tentative track does not
/// count), and there is a distant track. 12 s: target 1 has another track, 120 m off and with a course of 45°;
/// target 2's track is half a second old and fits. 13 s: target 2's track is 300 m off: still a pair for GOSPA, too
/// far to continue the pair.
const TRACKS: &str = "\
state,vz,vy,vx,z,y,x,system_track_id,time_s
confirmed,0,100,0,0,40,30,7,10
confirmed,0,0,0,1000,0,10000,9,10
coasted,0,100,0,0,140,30,7,11
tentative,0,0,0,1000,0,10000,12,11
confirmed,0,0,0,0,0,50000,8,11
confirmed,0,100,100,0,320,0,11,12
confirmed,0,0,20,1000,0,9990,9,11.5
confirmed,0,100,0,0,360,0,11,13
confirmed,0,0,0,1000,300,10000,9,13
terminated,0,0,0,1000,0,10000,9,13
";

fn picture(truth: &str, tracks: &str, settings: &PictureSettings) -> Result<PictureScore, PictureError> {
    let truth = Timeline::truth(truth.as_bytes()).unwrap();
    let tracks = Timeline::tracks(tracks.as_bytes(), settings.age_max_s).unwrap();
    score_picture(&truth, &tracks, settings)
}

/// Track 7 from 10 s on, `time,x,y,z` and variances of the position; no velocity, no correlations.
fn with_covariance(rows: &[(&str, [f64; 3])]) -> String {
    let names = (0..6).flat_map(|row| (row..6).map(move |column| format!("P{row}{column}")));
    let mut text = format!(
        "time_s,x,y,z,system_track_id,vx,vy,vz,{}\n",
        names.collect::<Vec<_>>().join(",")
    );
    for (place, [east, north, up]) in rows {
        text += &format!("{place},7,0,0,0,{east},0,0,0,0,0,{north},0,0,0,0,{up},0,0,0,0,0,0,0,0,0\n");
    }
    text
}

#[test]
fn the_normalised_error_says_whether_tracks_know_how_accurate_they_are() {
    let standing = PictureSettings {
        last_s: Some(11),
        ..PictureSettings::default()
    };
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,0,0,0,0\n11,1,0,0,0,0,0,0\n";
    let found = |rows: &[(&str, [f64; 3])]| picture(truth, &with_covariance(rows), &standing).unwrap().nees_pos;
    // (9/9 + 16/4 + 0)/3, and 1.
    known(
        found(&[("10,3,4,0", [9.0, 4.0, 1.0]), ("11,1,1,1", [1.0; 3])]),
        (5.0 / 3.0 + 1.0) / 2.0,
    );
    // A variance of 0 is invalid; without columns there is no covariance.
    known(found(&[("10,3,4,0", [9.0, 0.0, 1.0]), ("11,1,1,1", [1.0; 3])]), 1.0);
    let found = picture(TRUTH, TRACKS, &PictureSettings::default()).unwrap();
    assert_eq!(found.nees_pos, None);
}

#[test]
fn a_picture_of_four_seconds() {
    let found = picture(TRUTH, TRACKS, &PictureSettings::default()).unwrap();
    // Half a squared cut-off is 125,000: for the missed target and for the false track of 11 s.
    close(found.gospa, (50.0 + 252_500f64.sqrt() + 120.0 + 93_600f64.sqrt()) / 4.0);
    close(found.loc, (50.0 + 50.0 + 120.0 + 93_600f64.sqrt()) / 4.0);
    close(found.missed, 125_000f64.sqrt() / 4.0);
    close(found.false_tracks, 125_000f64.sqrt() / 4.0);
    let ospa = [1250.0f64, 126_250.0, 7200.0, 46_800.0].map(f64::sqrt);
    close(found.ospa, ospa.iter().sum::<f64>() / 4.0);
    // 50², 0, 50², 120², 0, 60², 300².
    known(found.rmse_pos, (113_000.0f64 / 7.0).sqrt());
    // 100² and 20², in seven pairs.
    known(found.rmse_vel, (10_400.0f64 / 7.0).sqrt());
    assert_eq!((found.id_switches, found.breaks), (1, 1));
    close(found.completeness, 6.0 / 8.0);
    assert_eq!((found.spurious, found.system_tracks), (1, 4));
    // Movements of the error: 0 m (track 7), 60 m (track 11).
    known(found.wander_p95, 57.0);
    known(found.wander_max, 60.0);
    // 0°, 0°, 45°, 0°: mean 11.25°, mean square about it 379.6875.
    known(found.direction_std_deg, 379.6875f64.sqrt());
    close(found.missed_per_s, 0.25);
    close(found.false_per_s, 0.25);
}

/// Two targets pass each other; at 11 s each track is nearer to the other target. The pairs stay nevertheless.
#[test]
fn pairs_are_kept_while_targets_cross() {
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,0,0,0,0\n10,2,100,0,0,0,0,0\n\
                 11,1,50,0,0,0,0,0\n11,2,60,0,0,0,0,0\n";
    let tracks = "time_s,system_track_id,x,y,z,vx,vy,vz\n10,5,0,0,0,0,0,0\n10,6,100,0,0,0,0,0\n\
                  11,5,60,0,0,0,0,0\n11,6,50,0,0,0,0,0\n";
    let found = picture(truth, tracks, &PictureSettings::default()).unwrap();
    assert_eq!((found.id_switches, found.completeness), (0, 1.0));
    // GOSPA pairs anew, and finds no error.
    assert_eq!(found.gospa, 0.0);
    known(found.wander_max, 10.0);
    assert_eq!(found.direction_std_deg, None);
    // With a narrow gate, each target must take the other's track.
    let narrow = PictureSettings {
        gate_m: 10.0,
        ..PictureSettings::default()
    };
    assert_eq!(picture(truth, tracks, &narrow).unwrap().id_switches, 2);
}

#[test]
fn the_order_of_the_rows_does_not_matter() {
    let turned = |text: &str| {
        let (header, rows) = text.split_once('\n').unwrap();
        let rows: Vec<&str> = rows.lines().rev().collect();
        format!("{header}\n{}\n", rows.join("\n"))
    };
    let settings = PictureSettings::default();
    assert_eq!(
        picture(&turned(TRUTH), &turned(TRACKS), &settings),
        picture(TRUTH, TRACKS, &settings)
    );
}

#[test]
fn without_tracks_everything_is_missed_and_without_truth_there_is_nothing_to_say() {
    let settings = PictureSettings::default();
    let none = "time_s,system_track_id,x,y,z,vx,vy,vz\n";
    let found = picture(TRUTH, none, &settings).unwrap();
    close(found.gospa, 500.0);
    assert_eq!((found.rmse_pos, found.wander_p95, found.system_tracks), (None, None, 0));
    assert_eq!(picture(none, TRACKS, &settings), Err(PictureError::NoTruth));
    let late = PictureSettings {
        first_s: 14,
        ..settings
    };
    let nothing = PictureError::NoSecond {
        first_s: 14,
        last_s: 13,
    };
    assert_eq!(picture(TRUTH, TRACKS, &late), Err(nothing));
}

/// Seconds of the day, hours after midnight: nothing before the truth, in its gap or behind it is compared.
#[test]
fn seconds_without_truth_do_not_count() {
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n43200,1,0,0,0,0,0,0\n43201,1,0,0,0,0,0,0\n43205,1,0,0,0,0,0,0\n";
    let row = |second: u32, id: u32, east: f64| format!("{second},{id},{east},4,0,0,0,0\n");
    let tracks: String = (43_190..43_220)
        .map(|second| row(second, 5, 3.0) + &row(second, 6, 9000.0))
        .chain([row(50_000, 7, 0.0)])
        .collect();
    let tracks = format!("time_s,system_track_id,x,y,z,vx,vy,vz\n{tracks}");
    let settings = PictureSettings {
        last_s: Some(43_210),
        ..PictureSettings::default()
    };
    let found = picture(truth, &tracks, &settings).unwrap();
    close(found.gospa, (25.0f64 + 125_000.0).sqrt());
    close(found.loc, 5.0);
    assert_eq!(
        (found.false_per_s, found.missed_per_s, found.completeness),
        (1.0, 0.0, 1.0)
    );
    assert_eq!(
        (found.spurious, found.system_tracks),
        (1, 2),
        "track 7 is shown much later"
    );
    known(found.wander_max, 0.0);
    let expected = Compared {
        first_s: 43_200,
        last_s: 43_205,
        seconds: 3,
        seconds_without_truth: 3,
        targets: 1,
        target_seconds: 3,
        tracks: 2,
        track_seconds: 6,
        tracks_elsewhere: 1,
        pairs: 3,
        ..Compared::default()
    };
    assert_eq!(found.compared, expected);
    // A truth between whole seconds.
    let between = "time_s,target_id,x,y,z,vx,vy,vz\n10.5,1,0,0,0,0,0,0\n11.5,1,0,0,0,0,0,0\n";
    assert!(matches!(
        picture(between, TRACKS, &PictureSettings::default()),
        Err(PictureError::NoTruthAt { .. })
    ));
}

/// A track of a radar without heights, beside targets at 3,000 m.
#[test]
fn what_a_side_does_not_know_is_not_compared() {
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,3000,100,0,5\n11,1,100,0,3005,100,0,5\n";
    let header = "time_s,system_track_id,x,y,z,vx,vy,vz,height_valid,velocity_valid";
    let found = |rows: &str| picture(truth, &format!("{header}\n{rows}"), &PictureSettings::default()).unwrap();
    let flat = found("10,5,3,4,0,100,3,0,0,1\n11,5,103,4,,100,3,,0,1\n");
    close(flat.gospa, 5.0);
    known(flat.rmse_pos, 5.0);
    known(flat.rmse_vel, 3.0);
    assert_eq!((flat.completeness, flat.spurious), (1.0, 0));
    assert_eq!((flat.compared.pairs, flat.compared.pairs_without_height), (2, 2));
    // The zeros of a track without a velocity are none; it stays where it was seen.
    let still = found("10,5,3,4,3000,0,0,0,1,0\n10.5,5,100,0,3005,50,0,0,1,0\n");
    known(still.rmse_pos, (25.0f64 / 2.0).sqrt());
    assert_eq!((still.rmse_vel, still.direction_std_deg), (None, None));
    assert_eq!(still.compared.pairs_without_velocity, 2);
    // In a known height an error counts.
    assert_eq!(found("10,5,3,4,0,100,3,0,1,1\n").completeness, 0.0);
}

#[test]
fn the_covariance_of_a_track_without_height_is_judged_in_the_plane() {
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,900,0,0,0\n";
    let tracks = with_covariance(&[("10,3,4,0", [9.0, 4.0, 1.0])]);
    let tracks = tracks
        .replacen("P55\n", "P55,height_valid\n", 1)
        .replacen(",0\n", ",0,0\n", 1);
    let found = picture(truth, &tracks, &PictureSettings::default()).unwrap();
    known(found.nees_pos, 5.0 / 2.0);
}

/// The same tracks and targets, counted from 0, from midnight, and from 1970, as metres and as degrees.
#[test]
fn times_and_places_are_brought_together() {
    const MIDNIGHT_S: i64 = 1_767_139_200;
    let frame = SystemFrame::at(Geodetic::from_degrees(41.297063, 2.078447, 30.0).unwrap());
    let degrees = |x: f64, y: f64, z: f64| {
        let place = frame.to_geodetic([x, y, z]);
        (place.latitude_deg(), place.longitude_deg(), place.height_m())
    };
    let truth = |begin_s: i64, is_degrees: bool| {
        let row = |second: i64| {
            let (x, y, z) = (40e3 + 200.0 * second as f64, -20e3, 9000.0);
            let (latitude, longitude, height) = degrees(x, y, z);
            match is_degrees {
                true => format!("{},1,{latitude},{longitude},{height}\n", begin_s + second),
                false => format!("{},1,{x},{y},{z},200,0,0\n", begin_s + second),
            }
        };
        let header = if is_degrees {
            "time_s,target_id,latitude,longitude,height_m\n"
        } else {
            "time_s,target_id,x,y,z,vx,vy,vz\n"
        };
        header.to_owned() + &(0..60).map(row).collect::<String>()
    };
    let tracks = |begin_s: i64| {
        let row = |second: i64| {
            let (x, y, z) = (40e3 + 200.0 * second as f64 + 30.0, -20e3, 9000.0);
            let (latitude, longitude, height) = degrees(x, y, z);
            let level = height / 30.48;
            format!(
                "{},7,{x},{y},{z},200,0,0,{latitude:.7},{longitude:.7},{level:.2}\n",
                begin_s + second
            )
        };
        let header = "time_s,system_track_id,x,y,z,vx,vy,vz,latitude,longitude,flight_level\n";
        header.to_owned() + &(0..60).map(row).collect::<String>()
    };
    let score = |truth: &str, tracks: &str| {
        let tracks = Timeline::tracks(tracks.as_bytes(), 1.0).unwrap();
        let truth = Timeline::truth_on(tracks.basis(), truth.as_bytes()).unwrap();
        truth.check_times(&tracks).unwrap();
        let settings = PictureSettings {
            first_s: truth.compared_from_s().unwrap(),
            ..PictureSettings::default()
        };
        score_picture(&truth, &tracks, &settings).unwrap()
    };
    for (of_truth, of_tracks) in [
        (0, 0),
        (40_000, 40_000),
        (MIDNIGHT_S + 40_000, 40_000),
        (40_000, MIDNIGHT_S + 40_000),
        (MIDNIGHT_S + 40_000, MIDNIGHT_S + 40_000),
        // The tracks count from the midnight of the day before.
        (MIDNIGHT_S + 5, 86_405),
        // Both begin on either side of midnight.
        (MIDNIGHT_S - 5, MIDNIGHT_S - 5),
    ] {
        for is_degrees in [false, true] {
            let found = score(&truth(of_truth, is_degrees), &tracks(of_tracks));
            assert!(
                (found.gospa - 30.0).abs() < 0.2,
                "{of_truth} {of_tracks} {is_degrees}: {}",
                found.gospa
            );
            assert_eq!((found.compared.seconds, found.completeness), (50, 1.0));
            assert_eq!(found.rmse_vel.is_some(), !is_degrees);
        }
    }
    // Nothing in common.
    let tracks = Timeline::tracks(tracks(0).as_bytes(), 1.0).unwrap();
    let truth = Timeline::truth_on(tracks.basis(), truth(40_000, false).as_bytes()).unwrap();
    assert!(matches!(
        truth.check_times(&tracks),
        Err(PictureError::NoCommonTime { .. })
    ));
}

#[test]
fn places_without_a_common_frame_are_refused() {
    let metres = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,0,0,0,0\n";
    let degrees = "time_s,target_id,latitude,longitude\n10,1,41,2\n";
    for (first, second) in [(metres, degrees), (degrees, metres)] {
        let tracks = Timeline::tracks(first.as_bytes(), 1.0).unwrap();
        let line = Timeline::truth_on(tracks.basis(), second.as_bytes())
            .unwrap_err()
            .to_string();
        assert!(line.contains("line 2, column") && line.contains("--origin"), "{line}");
    }
    let basis = FileBasis::at(Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap());
    let tracks = Timeline::tracks_on(basis, metres.as_bytes(), 1.0).unwrap();
    let truth = Timeline::truth_on(tracks.basis(), degrees.as_bytes()).unwrap();
    let found = score_picture(&truth, &tracks, &PictureSettings::default()).unwrap();
    assert!(
        found.gospa < 1e-6 && found.compared.pairs_without_height == 1,
        "{found:?}"
    );
    let mixed = "time_s,target_id,x,y,z,vx,vy,vz\n1767139200,1,0,0,0,0,0,0\n11,1,0,0,0,0,0,0\n";
    let line = Timeline::truth(mixed.as_bytes()).unwrap_err().to_string();
    assert!(line.contains("line 3, column time_s"), "{line}");
    let sensor = "time_s,sensor_track_id,x,y,z,vx,vy,vz\n";
    let line = Timeline::truth(sensor.as_bytes()).unwrap_err().to_string();
    assert!(line.contains("column target_id is missing"), "{line}");
}

#[test]
fn a_state_shows_as_long_as_it_may_and_no_longer() {
    let truth = "time_s,target_id,x,y,z,vx,vy,vz\n10,1,0,0,0,0,0,0\n11,1,0,0,0,0,0,0\n12,1,0,0,0,0,0,0\n";
    let tracks = "time_s,system_track_id,x,y,z,vx,vy,vz\n9.5,5,0,0,0,0,0,0\n";
    let seconds = |age_max_s: f64| {
        let settings = PictureSettings {
            age_max_s,
            ..PictureSettings::default()
        };
        let share = picture(truth, tracks, &settings).unwrap().completeness;
        (3.0 * share).round()
    };
    assert_eq!(
        (seconds(0.5), seconds(1.0), seconds(1.6), seconds(2.6)),
        (0.0, 1.0, 2.0, 3.0)
    );
}

// ---------------------------------------------------------------------------------------------------------------------
// Telling targets apart.
// ---------------------------------------------------------------------------------------------------------------------

/// Two targets, together until they stand 1,000 m apart from 8 s on.
const APART: &str = "\
time_s,target_id,x,y
0,1,0,0
0,2,100,0
4,1,0,0
4,2,100,0
8,1,0,0
8,2,1000,0
12,1,0,0
12,2,1000,0
16,1,0,0
16,2,1000,0
";

/// 4 s: two tracks too early. 8 s: the second track is four seconds old and at the wrong target. 12 s: a track for
/// each target. 16 s: a surplus track near the targets, and a distant track.
const SHOWN: &str = "\
time_s,sensor_track_id,x,y,z,vx,vy,vz,state
0,1,50,0,,0,0,0,confirmed
4,1,50,0,,0,0,0,confirmed
4,2,80,0,,0,0,0,confirmed
8,1,0,0,,0,0,0,coasted
12,1,0,0,,0,0,0,confirmed
12,3,1000,0,,0,0,0,confirmed
12,6,1000,0,,0,0,0,tentative
16,1,0,0,,0,0,0,confirmed
15,3,990,0,,10,0,0,confirmed
16,4,900,0,,0,0,0,confirmed
16,5,5000,0,,0,0,0,confirmed
";

fn resolution(truth: &str, tracks: &str, gate_m: f64, since_s: f64) -> ResolutionScore {
    let truth = TargetsByTime::read(truth.as_bytes()).unwrap();
    let tracks = ConfirmedTracks::read(tracks.as_bytes(), &truth).unwrap();
    ResolutionScore::of_run(&truth, &tracks, &ResolutionSettings { gate_m, since_s }).unwrap()
}

/// A track long after the truth is neither false nor counted.
#[test]
fn tracks_beside_the_times_of_the_truth_do_not_count() {
    let late = format!("{SHOWN}90,9,0,0,,0,0,0,confirmed\n");
    assert_eq!(
        resolution(APART, &late, 300.0, 8.0),
        resolution(APART, SHOWN, 300.0, 8.0)
    );
}

#[test]
fn two_targets_that_part() {
    let expected = ResolutionScore {
        count_right: 0.3333,
        covered: 0.6667,
        // (1/2 + 1 + 1) / 3.
        target_share: 0.8333,
        delay_s: 4.0,
        several_before: Some(0.5),
        false_tracks: 1,
        tracks: 5,
    };
    assert_eq!(resolution(APART, SHOWN, 300.0, 8.0), expected);
    // Never at two successive times: until the end.
    assert_eq!(resolution(APART, SHOWN, 300.0, 15.0).delay_s, 1.0);
    assert_eq!(resolution(APART, SHOWN, 300.0, 0.0).several_before, None);
}

/// The first track is near both targets, the second near a single target: the first must take the target that only
/// it can.
#[test]
fn as_many_targets_as_possible_have_a_track_of_their_own() {
    let truth = "time_s,x,y\n0,0,0\n0,400,0\n";
    let tracks = "time_s,sensor_track_id,x,y,vx,vy,state\n0,1,210,0,0,0,confirmed\n0,2,450,0,0,0,confirmed\n";
    let found = resolution(truth, tracks, 300.0, 0.0);
    assert_eq!((found.count_right, found.covered), (1.0, 1.0));
}

#[test]
fn runs_are_pooled_as_means_and_their_tracks_added_up() {
    let one = resolution(APART, SHOWN, 300.0, 8.0);
    let other = resolution(APART, SHOWN, 300.0, 0.0);
    // Right at 4 s and 12 s of five times.
    assert_eq!((other.count_right, other.delay_s), (0.4, 12.0));
    let pooled = ResolutionScore::pooled(&[one, other]).unwrap();
    assert_eq!((pooled.runs, pooled.each.len()), (2, 2));
    close(pooled.all.count_right, (0.3333 + 0.4) / 2.0);
    assert_eq!((pooled.all.delay_s, pooled.delay_max_s), (8.0, 12.0));
    assert_eq!(pooled.all.several_before, Some(0.5), "of the run that has such times");
    assert_eq!((pooled.all.false_tracks, pooled.all.tracks), (2, 10));
    assert_eq!(pooled.false_tracks_per_run, 1.0);
    assert_eq!(ResolutionScore::pooled(&[]), None);
}

#[test]
fn a_truth_that_ends_too_early_is_refused() {
    let truth = TargetsByTime::read(APART.as_bytes()).unwrap();
    let tracks = ConfirmedTracks::read(SHOWN.as_bytes(), &truth).unwrap();
    let settings = ResolutionSettings {
        since_s: 16.5,
        ..ResolutionSettings::default()
    };
    let line = ResolutionScore::of_run(&truth, &tracks, &settings)
        .unwrap_err()
        .to_string();
    assert!(line.contains("16.5 s"), "{line}");
    let no_state = "time_s,sensor_track_id,x,y,vx,vy\n";
    let line = ConfirmedTracks::read(no_state.as_bytes(), &truth)
        .unwrap_err()
        .to_string();
    assert!(line.contains("column state is missing"), "{line}");
}

// ---------------------------------------------------------------------------------------------------------------------
// Fixes.
// ---------------------------------------------------------------------------------------------------------------------

fn settings(case: FixCase, runs: u64) -> CaseSettings {
    CaseSettings {
        case,
        baseline_m: 10e3,
        sigma_deg: 1.0,
        runs,
    }
}

fn fixes(case: FixCase, runs: u64, truth: &str, fixes: &str) -> Result<FixScore, FixError> {
    let settings = settings(case, runs);
    let mut all = FixRuns::new(settings);
    all.add(&settings, truth.as_bytes(), fixes.as_bytes()).unwrap();
    all.score()
}

const FIX_HEADER: &str = "time_s,emitter_id,x,y,raw_x,raw_y,vx,vy\n";

/// The last raw fixes are 30 m across and 40 m along the line of sight off; earlier fixes and fixes of an unknown
/// time do not count.
#[test]
fn last_fixes_beside_the_bound() {
    let truth = "time_s,emitter_id,x,y\n590.0,0,0,50000\n600.0,0,0,50000\n590.0,b,0,50000\n600.0,b,0,50000\n";
    let rows = "600,0,9,9,30,50040,0,0\n590,0,9,9,7000,7000,0,0\n590,b,9,9,-30,49960,0,0\n605,b,9,9,1,1,0,0\n";
    let found = fixes(FixCase::Fixed, 3, truth, &format!("{FIX_HEADER}{rows}")).unwrap();
    assert_eq!((found.runs, found.runs_without_fix, found.runs_too_short), (2, 1, 0));
    let FixFigures::Broadside(figures) = found.figures else {
        panic!("{found:?}")
    };
    close(figures.range_rmse, 40.0);
    close(figures.cross_rmse, 30.0);
    assert_eq!(
        (figures.range_bound.round(), figures.cross_bound.round()),
        (1916.0, 112.0)
    );
    close(figures.range_ratio * figures.range_bound, 40.0);
    close(figures.cross_ratio * figures.cross_bound, 30.0);
}

/// A fixed transmitter at the origin, a fix every 2 s from 498 s to 540 s. The output stands at (3, 4) but states a
/// velocity of 1 m/s. The raw fix is right except for the tenth and the twentieth row from 500 s on.
fn turn_files() -> (String, String) {
    let (mut truth, mut rows) = ("time_s,emitter_id,x,y\n".to_owned(), FIX_HEADER.to_owned());
    for row in -1..=20 {
        let time_s = 500 + 2 * row;
        truth += &format!("{time_s},0,0,0\n{time_s},1,0,0\n");
        let (raw_x, raw_y) = match row {
            10 => (200, 0),
            20 => (200, 100),
            _ => (0, 0),
        };
        let (x, y) = if row < 0 { (1e6, 1e6) } else { (3.0, 4.0) };
        rows += &format!("{time_s},0,{x},{y},{raw_x},{raw_y},1,0\n");
        if row < 0 {
            rows += &format!("{time_s},1,0,0,0,0,0,0\n");
        }
    }
    (truth, rows)
}

#[test]
fn fixes_while_the_platform_turns() {
    let (truth, rows) = turn_files();
    let found = fixes(FixCase::Turn, 2, &truth, &rows).unwrap();
    assert_eq!((found.runs, found.runs_without_fix, found.runs_too_short), (2, 0, 1));
    let FixFigures::Course(figures) = found.figures else {
        panic!("{found:?}")
    };
    close(figures.rmse, 5.0);
    close(figures.last, 5.0);
    // 200², and 200² + 100², in 21 rows.
    close(figures.raw_rmse, (90_000.0f64 / 21.0).sqrt());
    close(figures.raw_last, 50_000f64.sqrt());
    // The output stays in place instead of moving by 2 m.
    close(figures.jump_m, 2.0);
    assert_eq!(
        (figures.speed_spread, figures.direction_spread_deg),
        (Some(0.0), Some(0.0))
    );
    // 10 m/s to the east, then 5 m/s to the north: two directions at right angles, whose mean has the length √½.
    known(figures.raw_speed_spread, 2.5);
    known(figures.raw_direction_spread_deg, 2f64.ln().sqrt().to_degrees());
    assert_eq!(figures.straight_bound, None);
}

/// The second half counts; the run that ends last determines its start.
#[test]
fn fixes_of_a_drifting_transmitter() {
    let truth = "time_s,emitter_id,x,y\n0,0,0,0\n50,0,0,0\n100,0,0,0\n";
    let rows = format!("{FIX_HEADER}0,0,900,0,900,0,0,0\n50,0,6,0,8,0,0,0\n100,0,8,0,6,0,0,0\n");
    let found = fixes(FixCase::Drop, 1, truth, &rows).unwrap();
    let FixFigures::Course(figures) = found.figures else {
        panic!("{found:?}")
    };
    close(figures.rmse, 50f64.sqrt());
    close(figures.last, 8.0);
    close(figures.raw_last, 6.0);
    close(figures.jump_m, 2.0);
    assert_eq!(figures.speed_spread, None, "ten rows were not there");
    assert!(figures.straight_bound.unwrap() > 0.0);
}

#[test]
fn sets_of_runs_of_one_case_are_pooled() {
    let case = settings(FixCase::Fixed, 1);
    let mut all = FixRuns::new(case);
    let truth = "time_s,emitter_id,x,y\n600,0,0,50000\n";
    for raw in ["30,50000", "-40,50000"] {
        let rows = format!("{FIX_HEADER}600,0,0,0,{raw},0,0\n");
        all.add(&case, truth.as_bytes(), rows.as_bytes()).unwrap();
    }
    let found = all.score().unwrap();
    let FixFigures::Broadside(figures) = found.figures else {
        panic!("{found:?}")
    };
    assert_eq!((found.runs, found.runs_without_fix), (2, 0));
    close(figures.cross_rmse, 1250f64.sqrt());
    let other = CaseSettings { sigma_deg: 0.5, ..case };
    let refused = all.add(&other, truth.as_bytes(), FIX_HEADER.as_bytes()).unwrap_err();
    assert!(matches!(refused, FixInputError::Settings { .. }));
    assert!(refused.to_string().contains("sigma 0.5 deg"), "{refused}");
}

#[test]
fn what_cannot_be_scored_is_said() {
    let truth = "time_s,emitter_id,x,y\n600,0,0,50000\n";
    assert_eq!(fixes(FixCase::Fixed, 1, truth, FIX_HEADER), Err(FixError::NoFix));
    let row = format!("{FIX_HEADER}600,0,0,0,0,0,0,0\n");
    assert_eq!(
        fixes(FixCase::Turn, 1, truth, &row),
        Err(FixError::NoLateFix { since_s: 500.0 })
    );
    let pointless = CaseSettings {
        baseline_m: 0.0,
        ..settings(FixCase::Fixed, 1)
    };
    let mut all = FixRuns::new(pointless);
    all.add(&pointless, truth.as_bytes(), row.as_bytes()).unwrap();
    assert!(matches!(all.score(), Err(FixError::NoBound { .. })));
    let refused = all.add(&pointless, truth.as_bytes(), "time_s,emitter_id\n".as_bytes());
    assert!(matches!(refused, Err(FixInputError::Fixes(_))));
}

// ---------------------------------------------------------------------------------------------------------------------
// Words.
// ---------------------------------------------------------------------------------------------------------------------

/// Every figure has a word with a meaning.
#[test]
fn words_are_those_of_the_figures() {
    let named = |found: &serde_json::Value, words: &[Word]| {
        for key in found.as_object().unwrap().keys().filter(|key| *key != "each") {
            assert!(words.iter().any(|word| word.name == key), "{key} has no word");
        }
    };
    let stated = with_covariance(&[("11,50,0,0", [25.0; 3])]);
    let found = picture(TRUTH, &stated, &PictureSettings::default()).unwrap();
    let found = serde_json::to_value(found).unwrap();
    named(&found, PICTURE_WORDS);
    assert_eq!(found.as_object().unwrap().len(), PICTURE_WORDS.len());
    let run = resolution(APART, SHOWN, 300.0, 8.0);
    let pooled = serde_json::to_value(ResolutionScore::pooled(&[run, run]).unwrap()).unwrap();
    named(&pooled, RESOLUTION_WORDS);
    assert_eq!(pooled.as_object().unwrap().len(), RESOLUTION_WORDS.len() + 1);
    let (truth, rows) = turn_files();
    for case in [FixCase::Fixed, FixCase::Drop, FixCase::Turn] {
        named(
            &serde_json::to_value(fixes(case, 2, &truth, &rows).unwrap()).unwrap(),
            FIX_WORDS,
        );
    }
}
