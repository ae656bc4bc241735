//! Crowds and pairs: clusters that are coupled, trees that are confirmed, detections of two targets.

use proptest::prelude::*;

use crate::settings::SensorFacts;
use crate::testing::{S, position, settings};
use crate::{ResolutionCell, Settings, Tracker};
use observations::Detection;
use settings::Degrees;

/// A number that looks random, in [-1, 1], for each step.
fn noise(step: u64) -> f64 {
    let mixed = (step + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Settings under which the gates of new tracks reach to the next targets.
fn crowded() -> Settings {
    let mut crowded = settings();
    crowded.initiation.speed_sigma_mps = 100.0;
    crowded.sensors[0].model.clutter_density = Some(2.8e-6);
    crowded
}

/// Targets that fly in all directions, and as many false detections among them.
fn crowd(second: i64) -> Vec<Detection> {
    let (time, mut scan) = (second * S, Vec::new());
    for target in 0..64u64 {
        let [east, north] = [target % 8, target / 8].map(|place| 600.0 * place as f64);
        let [speed_east, speed_north] = [0, 1].map(|axis| 30.0 * noise(2 * target + axis));
        let step = 1000 + 500 * second as u64 + 4 * target;
        if noise(step) < 0.8 {
            let [x, y] = [noise(step + 1), noise(step + 2)].map(|noise| 10.0 * noise);
            let moved = [speed_east, speed_north].map(|speed| speed * second as f64);
            scan.push(position(time, east + moved[0] + x, north + moved[1] + y));
        }
        let [x, y] = [step + 3, step + 90_000].map(|step| 2100.0 + 2400.0 * noise(step));
        scan.push(position(time, x, y));
    }
    scan
}

fn shown_after(scans: i64, settings: Settings) -> usize {
    let mut tracker = Tracker::new(settings).unwrap();
    for second in 0..scans {
        tracker.scan(1, second * S, &crowd(second)).unwrap();
    }
    tracker.tracks().len()
}

#[test]
fn a_crowd_is_confirmed_although_its_gates_overlap() {
    let mut of_the_source = crowded();
    of_the_source.reduction.join_probability_min = 0.0;
    let (coupled, joined) = (shown_after(8, crowded()), shown_after(8, of_the_source));
    assert!(
        (50..80).contains(&coupled) && joined < coupled - 4,
        "{coupled} {joined}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    /// Clusters that were not joined may both take a detection; joined later, no hypothesis has it twice.
    #[test]
    fn no_hypothesis_gives_a_detection_to_two_tracks(
        scans in prop::collection::vec(prop::collection::vec((-200.0..200.0f64, -200.0..200.0f64), 0..8), 1..8),
    ) {
        let mut loose = settings();
        loose.reduction.join_probability_min = 0.2;
        loose.reduction.join_detections = 0;
        let mut tracker = Tracker::new(loose).unwrap();
        for (second, places) in (0..).zip(&scans) {
            let scan: Vec<_> = places.iter().map(|(east, north)| position(second * S, *east, *north)).collect();
            tracker.scan(1, second * S, &scan).unwrap();
            let population = tracker.latest();
            for hypothesis in &population.hypotheses {
                let tracks: Vec<_> = population.members_of(hypothesis).iter().map(|track| &population.tracks[*track as usize]).collect();
                for (place, one) in tracks.iter().enumerate() {
                    for other in &tracks[place + 1..] {
                        let common = one.history.iter().any(|serial| *serial != 0 && other.history.contains(serial));
                        prop_assert!(!common, "two tracks with the same detection");
                    }
                }
            }
        }
    }
}

/// Two targets that fly north side by side, from 20 s to 60 s 40 m apart, before and after 100 m. Within the cell they
/// give one detection between them in seven of eight scans.
fn abreast(second: i64) -> Vec<Detection> {
    let time_s = second as f64;
    let apart = 40.0 + 60.0 * ((20.0 - time_s).max(time_s - 60.0) / 20.0).clamp(0.0, 1.0);
    let north = 2000.0 + 15.0 * time_s;
    let seen = |east: f64, step: u64| {
        let [x, y] = [noise(step), noise(step + 7)].map(|noise| 8.0 * noise);
        position(second * S, east + x, north + y)
    };
    let step = 100 + 20 * second as u64;
    if apart < 50.0 && second % 8 != 0 {
        vec![seen(0.0, step)]
    } else {
        vec![seen(-0.5 * apart, step), seen(0.5 * apart, step + 3)]
    }
}

/// (number, east) of the tracks each second.
fn shown_abreast(cell: Option<ResolutionCell>) -> Vec<Vec<(u32, f64)>> {
    let mut chosen = settings();
    chosen.sensors[0].model.resolution_cell = cell;
    let mut tracker = Tracker::new(chosen).unwrap();
    let mut shown = Vec::new();
    for second in 0..80 {
        tracker.scan(1, second * S, &abreast(second)).unwrap();
        let tracks = tracker.tracks().iter();
        shown.push(tracks.map(|track| (track.number, track.estimate.mean[0])).collect());
    }
    shown
}

/// Targets nearer than 60 m are seen as one at 2 km and beyond.
const CELL: ResolutionCell = ResolutionCell {
    range_m: 60.0,
    bearing_deg: Degrees::of(1.5),
};

#[test]
fn targets_that_are_not_resolved_keep_both_tracks() {
    let shown = shown_abreast(Some(CELL));
    for (second, tracks) in shown.iter().enumerate().take(62).skip(8) {
        let [(1, one), (2, other)] = tracks[..] else {
            panic!("{second} s: {tracks:?}")
        };
        assert!((one - other).abs() > 12.0, "{second} s: {tracks:?}");
    }
    assert_eq!(shown[79].len(), 2, "{:?}", shown[79]);
    let without = shown_abreast(None);
    let both = |shown: &[Vec<(u32, f64)>]| {
        let apart = |tracks: &&Vec<(u32, f64)>| tracks.len() == 2 && (tracks[0].1 - tracks[1].1).abs() > 12.0;
        shown[20..60].iter().filter(apart).count()
    };
    assert!(
        both(&shown) == 40 && both(&without) < 30,
        "{} {}",
        both(&shown),
        both(&without)
    );
}

#[test]
fn a_track_without_a_detection_of_its_own_ends() {
    let mut chosen = settings();
    chosen.sensors[0].model.resolution_cell = Some(CELL);
    let mut tracker = Tracker::new(chosen).unwrap();
    let mut numbers = Vec::new();
    for second in 0..140 {
        let between = position(second * S, 8.0 * noise(second as u64), 2000.0 + 15.0 * second as f64);
        let scan = if second <= 20 { abreast(second) } else { vec![between] };
        tracker.scan(1, second * S, &scan).unwrap();
        numbers.push(tracker.tracks().len());
    }
    assert_eq!((numbers[30], numbers[139]), (2, 1), "{numbers:?}");
}

#[test]
fn a_cell_needs_two_sizes() {
    let faulty = [(0.0, 1.0), (60.0, 0.0), (f64::NAN, 1.0), (60.0, 181.0)];
    for (range_m, bearing_deg) in faulty {
        let mut wrong = settings();
        wrong.sensors[0] = SensorFacts {
            ..wrong.sensors[0].clone()
        };
        wrong.sensors[0].model.resolution_cell = Some(ResolutionCell {
            range_m,
            bearing_deg: Degrees::of(bearing_deg),
        });
        assert!(Tracker::new(wrong).is_err(), "{range_m} {bearing_deg}");
    }
}
