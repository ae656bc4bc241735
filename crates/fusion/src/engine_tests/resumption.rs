//! Starts from checkpoints.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use estimation::{FirstVelocity, Gaussian, NearlyConstantVelocity};
use messages::layout::Sample as _;
use source_models::{Fact, FilterInnovation, Fit, Innovation, InnovationFact, ReportFact};
use test_support::Random;

use super::*;
use crate::continuity::checkpoint::{CheckpointClock, Memory, MemoryRefusal, Snapshot};
use crate::settings::SOURCES_MAX;

/// Memory that outlives the engine.
#[derive(Clone, Debug)]
pub(super) struct Shared(Arc<Vec<AtomicU64>>);

impl Memory for Shared {
    fn words(&self) -> &[AtomicU64] {
        &self.0
    }
}

impl Shared {
    fn for_engine(engine: &Engine) -> Self {
        let words = engine.checkpoint_layout().len();
        Self(Arc::new((0..words).map(|_| AtomicU64::new(0)).collect()))
    }
}

const TARGETS: u32 = 12;
const SOURCES: u16 = 3;

/// Report of a target by a source, in one of the scans, one a second; the sources one after another.
fn traffic(scan: u32, source: u16, target: u32) -> SensorTrack {
    let angle = f64::from(target);
    let time_s = f64::from(scan) + 0.3 * f64::from(source) + 0.01 * f64::from(target);
    let place = [3000.0 * angle, 1000.0 * f64::from(source % 2) * 0.02];
    let number = 100 * u32::from(source) + target;
    report(
        source,
        number,
        time_s,
        place,
        [100.0 * angle.cos(), 100.0 * angle.sin()],
    )
}

/// An engine that keeps itself in `memory` from now on.
pub(super) fn kept(mut harness: Harness) -> (Harness, Shared) {
    let memory = Shared::for_engine(&harness.engine);
    harness.engine.keep_checkpoint(Box::new(memory.clone()));
    (harness, memory)
}

fn died(harness: &mut Harness, memory: &Shared) -> Snapshot {
    harness.engine.keep_clock(CheckpointClock {
        epoch: 1,
        ..CheckpointClock::default()
    });
    Snapshot::read(memory.words(), &harness.engine.checkpoint_layout()).unwrap()
}

/// A successor of the engine that kept itself in `memory`.
pub(super) fn successor(mut dead: Harness, memory: &Shared, ends: bool) -> (Harness, Shared) {
    let snapshot = died(&mut dead, memory);
    let mut next = Harness::new(dead.engine.settings().clone());
    let published = &mut next.published;
    next.engine
        .resume(&snapshot, ends, &mut |track: &SystemTrack| published.push(*track));
    kept(next)
}

/// Numbers under which each target was shown when confirmed: by its place across the ground.
fn shown(tracks: &[SystemTrack], into: &mut BTreeMap<u32, Vec<u32>>) {
    for track in tracks.iter().filter(|track| track.state == TrackState::Confirmed as u8) {
        let time_s = track.reference_time_ns as f64 / S as f64;
        let near = |target: &u32| {
            let truth = traffic(0, 0, *target);
            let at = |axis: usize| truth.position_m[axis] + truth.velocity_mps[axis] * time_s;
            (track.position_m[0] - at(0)).hypot(track.position_m[1] - at(1))
        };
        let target = (0..TARGETS).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
        let numbers = into.entry(target).or_default();
        if !numbers.contains(&track.track_number) {
            numbers.push(track.track_number);
        }
    }
}

#[test]
fn as_many_sources_as_there_can_be_see_one_target_and_a_successor_knows_all() {
    let sources = SOURCES_MAX as u16;
    let mut settings = test_settings(usize::from(sources));
    settings.capacity.sensor_tracks = Some(4 * SOURCES_MAX);
    let (mut harness, memory) = kept(Harness::new(settings));
    let take = |harness: &mut Harness, scans: std::ops::Range<u32>| {
        for scan in scans {
            for source in 0..sources {
                let time_s = f64::from(scan) + 0.007 * f64::from(source);
                harness.take(&report(source, 7, time_s, [0.0; 2], [100.0, 0.0]));
            }
        }
    };
    take(&mut harness, 0..8);
    let last = *harness.published.last().unwrap();
    assert_eq!(last.source_count, sources);
    assert_eq!(harness.live(), 1);
    let (mut next, _) = successor(harness, &memory, false);
    take(&mut next, 8..12);
    let shown = next.published.last().unwrap();
    assert_eq!(
        (shown.track_number, shown.source_count, next.live()),
        (last.track_number, sources, 1)
    );
    let contributors = next.engine.tracks.systems.get(0).contributors;
    assert!(contributors.iter().eq(0..sources));
}

#[test]
fn targets_with_addresses_in_a_nearly_full_table_survive_one_kill_after_the_other() {
    let mut settings = test_settings(usize::from(SOURCES));
    let tracks = TARGETS as usize * usize::from(SOURCES);
    settings.capacity.sensor_tracks = Some(tracks + 4);
    let (mut harness, mut memory) = kept(Harness::new(settings));
    let mut numbers = BTreeMap::new();
    for scan in 0..40 {
        for source in 0..SOURCES {
            for target in 0..TARGETS {
                harness.take(&with_address(traffic(scan, source, target), 1 + target));
            }
        }
        shown(&harness.published, &mut numbers);
        if scan % 8 == 7 {
            (harness, memory) = successor(harness, &memory, false);
        }
    }
    assert!(numbers.values().all(|numbers| numbers.len() == 1), "{numbers:?}");
}

#[test]
fn numbers_survive_kills_after_any_report() {
    for rule in [messages::FusionRule::BestSource, messages::FusionRule::SystemFilter] {
        let mut settings = test_settings(usize::from(SOURCES));
        settings.rule.name = crate::settings::RuleName(rule);
        let (mut harness, mut memory) = kept(Harness::new(settings));
        let mut numbers = BTreeMap::new();
        let (mut step, mut kills) = (0u32, 0);
        for scan in 0..30 {
            for source in 0..SOURCES {
                for target in 0..TARGETS {
                    harness.take(&traffic(scan, source, target));
                    step += 1;
                    if scan > 4 && step % 37 == 0 {
                        shown(&harness.published, &mut numbers);
                        (harness, memory) = successor(harness, &memory, false);
                        kills += 1;
                    }
                }
            }
        }
        shown(&harness.published, &mut numbers);
        assert!(kills > 20 && numbers.len() == TARGETS as usize, "{kills} {numbers:?}");
        assert!(numbers.values().all(|numbers| numbers.len() == 1), "{numbers:?}");
        assert_eq!(harness.live(), TARGETS as usize);
        // A new target has a number that none has had.
        let new = report(0, 999, 30.0, [-50_000.0, 0.0], [0.0, 100.0]);
        let first = harness.take(&new).unwrap();
        assert!(numbers.values().flatten().all(|number| *number < first.track_number));
    }
}

#[test]
fn a_checkpoint_that_is_too_old_ends_each_track_once() {
    let (mut harness, memory) = kept(Harness::new(test_settings(usize::from(SOURCES))));
    for scan in 0..8 {
        for target in 0..TARGETS {
            harness.take(&traffic(scan, 0, target));
            harness.take(&traffic(scan, 1, target));
        }
    }
    let (next, memory) = successor(harness, &memory, true);
    let mut ended: Vec<u32> = next.published.iter().map(|track| track.track_number).collect();
    assert!(
        next.published
            .iter()
            .all(|track| track.state == TrackState::Terminated as u8)
    );
    ended.sort_unstable();
    ended.dedup();
    assert_eq!(
        (ended.len(), next.published.len()),
        (TARGETS as usize, TARGETS as usize)
    );
    assert_eq!(next.live(), 0);
    // Killed again at once, its successor says so again: it may not have been sent.
    let (next, _) = successor(next, &memory, false);
    assert_eq!(next.published.len(), TARGETS as usize);
    assert_eq!(next.live(), 0);
}

#[test]
fn a_start_is_a_function_of_the_snapshot_alone() {
    let (mut harness, memory) = kept(Harness::new(test_settings(usize::from(SOURCES))));
    for scan in 0..10 {
        for target in 0..TARGETS {
            harness.take(&traffic(scan, (scan % 3) as u16, target));
        }
    }
    let snapshot = died(&mut harness, &memory);
    let layout = harness.engine.checkpoint_layout();
    let again = Snapshot::of_words(snapshot.words().to_vec(), &layout).unwrap();
    let run = |snapshot: &Snapshot, keeps: bool| {
        let mut next = Harness::new(harness.engine.settings().clone());
        next.engine.resume(snapshot, false, &mut |_: &SystemTrack| {});
        if keeps {
            next = kept(next).0;
        }
        for target in 0..TARGETS {
            next.take(&traffic(11, 2, target));
        }
        SystemTrack::octets(&next.published).to_vec()
    };
    assert!(run(&snapshot, false) == run(&again, true));
    assert_eq!(Snapshot::of_words(Vec::new(), &layout), Err(MemoryRefusal::Foreign));
    let cut = snapshot.words()[..snapshot.words().len() - 1].to_vec();
    assert_eq!(Snapshot::of_words(cut, &layout), Err(MemoryRefusal::Damaged(1)));
}

#[test]
fn what_was_learned_goes_on() {
    let (mut harness, memory) = kept(Harness::new(test_settings(2)));
    // The second source sees everything 20 m too far to the east.
    for scan in 0..200 {
        for target in 0..TARGETS {
            harness.take(&traffic(scan, 0, target));
            let mut shifted = traffic(scan, 1, target);
            shifted.position_m[0] += 20.0;
            harness.take(&shifted);
        }
    }
    harness.engine.keep_learned(harness.engine.learned_records());
    let before = *harness.engine.sources().source_errors(1).unwrap();
    assert!(before.samples > 20.0, "{before:?}");
    let (next, _) = successor(harness, &memory, false);
    let after = next.engine.sources().source_errors(1).unwrap();
    assert_eq!(
        (before.errors, before.samples, before.removed),
        (after.errors, after.samples, after.removed)
    );
}

/// A fusion that is killed every fourth scan takes no track of its sources for a young one: the gains of a young track
/// say nothing of the measurements of an old one.
#[test]
fn a_sources_tracker_stays_known_over_many_restarts() {
    const SIGMA_M: f64 = 20.0;
    let mut random = Random::new(11);
    let mut normal = || SIGMA_M * ((0..12).map(|_| random.unit()).sum::<f64>() - 6.0);
    let model = NearlyConstantVelocity::new(5.0, 1.0);
    let variances = [SIGMA_M * SIGMA_M, 0.0, 0.0, SIGMA_M * SIGMA_M, 0.0, 100.0];
    let first = FirstVelocity {
        horizontal_sigma_mps: 150.0,
        vertical_sigma_mps: 5.0,
    };
    let mut tracks: Vec<Option<Gaussian>> = vec![None; TARGETS as usize];
    let (mut harness, mut memory) = kept(Harness::new(test_settings(1)));
    for scan in 0..400 {
        for target in 0..TARGETS {
            let mut report = traffic(scan, 0, target);
            let [x, y, z] = report.position_m;
            let measured = [x + normal(), y + normal(), z];
            let track = &mut tracks[target as usize];
            let updated = match track {
                None => Gaussian::from_first_position::<3>(measured, &variances, first),
                Some(before) => {
                    let mut predicted = model.predicted(before, 1.0);
                    predicted.update_position::<3>(measured, &variances).unwrap();
                    predicted
                }
            };
            *track = Some(updated);
            report.position_m = updated.position_m();
            report.velocity_mps = updated.velocity_mps();
            report.covariance = Covariance::diagonal([30.0, 30.0, 100.0], [5.0; 3]);
            harness.take(&report);
        }
        if scan >= 40 && scan % 4 == 0 {
            harness.engine.keep_learned(harness.engine.learned_records());
            (harness, memory) = successor(harness, &memory, false);
        }
    }
    let learned = harness.engine.sources().learned(0).unwrap();
    let [long_m, short_m] = learned.measurement_sigma_m.expect("the tracker is undone");
    assert!((0.8 * SIGMA_M..1.25 * SIGMA_M).contains(&long_m), "{long_m}");
    assert!((0.8 * SIGMA_M..1.25 * SIGMA_M).contains(&short_m), "{short_m}");
}

proptest! {
    /// Whatever happens to the memory, it is refused or every track is one that was kept.
    #[test]
    fn damaged_memory_is_never_half_used(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u64>()), 1..4),
    ) {
        let (mut harness, memory) = kept(Harness::new(test_settings(2)));
        for scan in 0..4 {
            for target in 0..TARGETS {
                harness.take(&traffic(scan, (scan % 2) as u16, target));
            }
        }
        let whole = died(&mut harness, &memory);
        for (place, word) in &damage {
            memory.0[place.index(memory.0.len())].store(*word, Relaxed);
        }
        let layout = harness.engine.checkpoint_layout();
        let Ok(snapshot) = Snapshot::read(memory.words(), &layout) else {
            return Ok(());
        };
        let resumed = |snapshot: &Snapshot| {
            let mut next = Harness::new(harness.engine.settings().clone());
            next.engine.resume(snapshot, true, &mut |track: &SystemTrack| next.published.push(*track));
            let numbers: Vec<u32> = next.published.iter().map(|track| track.track_number).collect();
            numbers
        };
        let (all, found) = (resumed(&whole), resumed(&snapshot));
        prop_assert!(found.iter().all(|number| all.contains(number)));
        prop_assert!(found.len() + 1 >= all.len());
        let refused = Snapshot::read(&memory.words()[1..], &layout);
        prop_assert_eq!(refused, Err(MemoryRefusal::Foreign));
    }
}

#[test]
fn how_targets_turn_and_which_sources_copy_is_still_known() {
    let mut harness = Harness::new(test_settings(usize::from(SOURCES)));
    let engine = &mut harness.engine;
    let fast_mps = [100.0, 0.0, 0.0];
    let innovation = FilterInnovation {
        residual_m: [0.0; 2],
        covariance_m2: [1.0, 0.0, 1.0],
        squared: 0.0,
        gain: 0.5,
        fit: Fit::Turning(50.0),
        manoeuvre: None,
        straight_s: 0.0,
        begins_turn: false,
    };
    let mut learn = |fact: Fact<'_>| engine.tracks.sources.learn(&engine.settings, fact);
    for step in 0..100 {
        let report = traffic(step, 0, 1);
        learn(Fact::Report(ReportFact::Original(&report)));
        learn(Fact::Report(ReportFact::Original(&SensorTrack { source: 1, ..report })));
        learn(Fact::Innovation(InnovationFact::Used(Innovation {
            source: 2,
            report: &report,
            target: 0,
            innovation: &innovation,
            nis: 2.0,
            moves_mps: Some(fast_mps),
            about_mean_m: None,
            shows_errors: false,
            shows_accuracy: false,
            steadiness: 0.0,
            apart: None,
            height: None,
        })));
    }
    let known = |harness: &Harness| {
        let sources = harness.engine.sources();
        (
            sources.motion(fast_mps).turns.density_m2ps3,
            [0, 1, 2].map(|source| sources.group_of(source)),
        )
    };
    let learned = known(&harness);
    assert!(learned.0[0] > 60.0 && learned.1 == [0, 0, 2], "{learned:?}");
    let (dead, memory) = kept(harness);
    let (next, _) = successor(dead, &memory, false);
    assert_eq!(known(&next), learned);
}
