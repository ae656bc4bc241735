//! CAT062, in every edition, against what the tracks say.

use std::collections::HashMap;

use asterix::table::Edition;
use asterix::{Category, registry};
use deployment::Technology;
use messages::{Movement, SystemTrack, TrackState, alert_bits, contribution_bits, movement_bits};
use outgoing::{HeightReference, SystemReports, SystemSource};
use proptest::prelude::*;

use crate::model::{self, FOOT_M, LEVEL_M, SOURCES, World, gradient, system_track, world};
use crate::reading::{Sent, records};

/// The kinds, and the name of each in I062/290.
const KINDS: [(Technology, &str); 5] = [
    (Technology::Primary, "PSR"),
    (Technology::Secondary, "SSR"),
    (Technology::ModeS, "MDS"),
    (Technology::AdsB, "ES"),
    (Technology::Multilateration, "MLT"),
];
const POSITION_LSB_DEG: f64 = 180.0 / (1 << 25) as f64;
const CLIMB_LSB_MPS: f64 = 6.25 * FOOT_M / 60.0;

fn technology(source: u16) -> Technology {
    KINDS
        .get(usize::from(source))
        .map_or(Technology::Other, |(kind, _)| *kind)
}

/// Codes of a source: the first source has none.
fn code(source: u16) -> Option<[u8; 2]> {
    (source > 0).then_some([9, source as u8])
}

/// A source of every kind; the last of the numbers is not listed.
fn sources(kinds: &[bool]) -> Vec<SystemSource> {
    let listed = (0..SOURCES - 1).filter(|number| kinds.get(usize::from(*number)).copied().unwrap_or(true));
    listed
        .map(|number| SystemSource {
            number,
            technology: technology(number),
            code: code(number),
        })
        .collect()
}

/// History of a track, as the test remembers it.
#[derive(Default)]
struct History {
    number: u16,
    ended: bool,
    last_ns: HashMap<usize, i64>,
    /// Kinds when last any source supported it, and whether another source did.
    kinds: Vec<usize>,
    other: bool,
    sources: u16,
}

/// Facts that are to be true of a record.
struct Expected<'t> {
    track: &'t SystemTrack,
    is_first: bool,
    history: &'t History,
}

struct Case {
    world: World,
    height: HeightReference,
    has_kind: Vec<bool>,
    with_tentative: bool,
}

/// I062/200 has its own codes: 0 for what is constant, 3 for what is not known.
fn check_movement(sent: &Sent<'_>, movement: &Movement) {
    let modes = [movement.horizontal, movement.longitudinal, movement.vertical];
    assert_eq!(sent.has(&["200", "TRANS"]), modes != [0; 3], "{}", sent.table);
    if modes == [0; 3] {
        return;
    }
    sent.is(&["200", "TRANS"], [3u64, 0, 2, 1][usize::from(movement.horizontal)]);
    sent.is(&["200", "LONG"], [3u64, 0, 1, 2][usize::from(movement.longitudinal)]);
    sent.is(&["200", "VERT"], [3u64, 0, 1, 2][usize::from(movement.vertical)]);
}

impl Case {
    fn run(&self, table: &'static Category, tracks: &[SystemTrack]) {
        let mut sender = SystemReports::new(table, 0x14, 0x2A, self.world.system, &sources(&self.has_kind), 1400)
            .unwrap()
            .with_height(self.height);
        if self.with_tentative {
            sender = sender.with_tentative().with_target_identification();
        }
        let mut histories = HashMap::<u32, History>::new();
        let mut sent_before = 0;
        for track in tracks {
            let mut bytes = vec![];
            sender.report(track, &mut |block| bytes.extend_from_slice(block));
            sender.flush(&mut |block| bytes.extend_from_slice(block));
            let found = records(table, &bytes);
            let Some(is_first) = self.remember(&mut histories, track) else {
                assert!(found.is_empty(), "{table}: sent a state that is to be withheld");
                continue;
            };
            let [record] = found.as_slice() else {
                panic!("{table}: {} records of one track", found.len());
            };
            let sent = Sent { record, table };
            let history = histories.get_mut(&track.track_number).unwrap();
            let number = sent.number(&["040"]) as u16;
            if is_first && history.number == 0 {
                history.number = number;
            }
            assert_eq!(number, history.number, "{table}: a track keeps its number");
            let others = histories.iter().filter(|(key, _)| **key != track.track_number);
            assert!(number != 0 && others.clone().all(|(_, other)| other.ended || other.number != number));
            self.check(
                &sent,
                &Expected {
                    track,
                    is_first,
                    history: &histories[&track.track_number],
                },
            );
            sent_before += 1;
        }
        let counts = sender.counts();
        assert_eq!((counts.records, counts.refused()), (sent_before, 0));
        assert_eq!(counts.withheld, tracks.len() as u64 - sent_before);
    }

    /// Tells whether a state is sent, and if so whether it is its track's first.
    fn remember(&self, histories: &mut HashMap<u32, History>, track: &SystemTrack) -> Option<bool> {
        let state = TrackState::from_code(track.state).unwrap();
        if state == TrackState::Tentative && !self.with_tentative {
            return None;
        }
        let is_live = histories.get(&track.track_number).is_some_and(|history| !history.ended);
        if TrackState::is_off(track.state) {
            let history = histories.get_mut(&track.track_number).filter(|_| is_live)?;
            history.ended = true;
            return Some(false);
        }
        let history = histories.entry(track.track_number).or_default();
        if history.ended {
            *history = History {
                number: history.number,
                ..History::default()
            };
        }
        if !track.contributions().is_empty() {
            (history.kinds, history.other, history.sources) = (vec![], false, track.source_count);
        }
        for contribution in track.contributions() {
            let kind = usize::from(contribution.source);
            if kind < KINDS.len() && self.has_kind[kind] {
                let last_ns = history.last_ns.entry(kind).or_insert(i64::MIN);
                *last_ns = (*last_ns).max(contribution.time_of_measurement_ns);
                history.kinds.push(kind);
            } else {
                history.other = true;
            }
        }
        Some(!is_live)
    }

    fn check(&self, sent: &Sent<'_>, expected: &Expected<'_>) {
        let track = expected.track;
        sent.is(&["010", "SAC"], 0x14u64);
        sent.is(&["010", "SIC"], 0x2Au64);
        sent.near_time(&["070"], track.reference_time_ns);
        sent.near_place("105", self.world.system.to_geodetic(track.position_m), POSITION_LSB_DEG);
        sent.near(&["100", "X"], track.position_m[0], 0.5);
        sent.near(&["100", "Y"], track.position_m[1], 0.5);
        let has_height = track.height_valid != 0;
        let [east, north, up] = self.world.velocity(track.position_m, track.velocity_mps, has_height);
        let has_velocity = track.velocity_valid != 0;
        sent.near_if(&["185", "VX"], has_velocity.then_some(east), 0.25);
        sent.near_if(&["185", "VY"], has_velocity.then_some(north), 0.25);
        self.check_motion(sent, track, up);
        self.check_height(sent, track);
        self.check_identity(sent, track);
        self.check_measured(sent, track);
        self.check_status(sent, expected);
        self.check_ages(sent, expected);
        self.check_accuracies(sent, track);
        for absent in ["015", "390", "510", "RE", "SP"] {
            assert!(!sent.has(&[absent]), "{}: {absent}", sent.table);
        }
    }

    /// I062/200, 210 and 220; `up_mps` is the rate of the height by the velocity.
    fn check_motion(&self, sent: &Sent<'_>, track: &SystemTrack, up_mps: f64) {
        let has_height = track.height_valid != 0;
        let [vx, vy, _] = track.velocity_mps;
        let climb_mps = match track.climb_rate_variance > 0.0 {
            true => self
                .world
                .velocity(track.position_m, [vx, vy, f64::from(track.climb_rate_mps)], true)[2],
            false => up_mps,
        };
        sent.near_if(&["220"], has_climb(track).then_some(climb_mps * 60.0 / FOOT_M), 6.25);
        let stated = track.movement.acceleration_mps2.map(f64::from);
        // To the right of the velocity for a turn to the right: its direction turned clockwise.
        let rate = f64::from(track.turn_rate_radps);
        let (speed, course) = (vx.hypot(vy), vx.atan2(vy) + std::f64::consts::FRAC_PI_2);
        let turned = [rate * speed * course.sin(), rate * speed * course.cos(), 0.0];
        let is_updated = [TrackState::Tentative as u8, TrackState::Confirmed as u8].contains(&track.state);
        let sigma = track.turn_rate_sigma_radps;
        let is_sure = is_updated && sigma > 0.0 && track.turn_rate_radps.abs() > 2.0 * sigma;
        let acceleration = match track.movement.valid & movement_bits::ACCELERATION != 0 {
            true => Some(stated),
            false => is_sure.then_some(turned),
        };
        let along = acceleration.map(|acceleration| self.world.velocity(track.position_m, acceleration, has_height));
        sent.near_if(&["210", "AX"], along.map(|[east, _, _]| east), 0.25);
        sent.near_if(&["210", "AY"], along.map(|[_, north, _]| north), 0.25);
        check_movement(sent, &track.movement);
    }

    fn check_height(&self, sent: &Sent<'_>, track: &SystemTrack) {
        let height_m = self.world.system.to_geodetic(track.position_m).height_m();
        let known = track.height_valid != 0;
        let geometric = known && self.height == HeightReference::Geometric;
        let feet = |height_m: f64| (-1500.0..=150_000.0).contains(&(height_m / FOOT_M));
        let above_m = height_m - track.pressure_offset().unwrap_or_default();
        let has_both = known && track.pressure_offset().is_some();
        let feet = feet(above_m);
        sent.near_if(
            &["130"],
            ((geometric || has_both) && feet).then_some(above_m / FOOT_M),
            6.25,
        );
        let sent_m = track.altitude().unwrap_or(height_m);
        let levels = (-15.0..=1500.0).contains(&(sent_m / LEVEL_M));
        let barometric = known && self.height == HeightReference::Barometric && levels;
        sent.near_if(&["135", "CTB"], barometric.then_some(sent_m / LEVEL_M), 0.25);
        sent.is(&["135", "QNH"], u64::from(barometric && track.altitude().is_some()));
        sent.is(&["080", "MRH"], u64::from(geometric));
        sent.is(&["080", "SRC"], 0u64);
    }

    fn check_identity(&self, sent: &Sent<'_>, track: &SystemTrack) {
        let identity = &track.identity;
        let call_sign = model::call_sign(identity);
        assert_eq!(sent.text(&["060", "MODE3A"]).map(str::to_owned), model::code(identity));
        assert_eq!(sent.has(&["380", "ADR"]), identity.address().is_some());
        sent.is(&["380", "ADR"], identity.address().unwrap_or(0));
        assert_eq!(sent.text(&["380", "ID"]), call_sign.as_deref());
        // Asked for together with tentative tracks, to try both.
        let old = call_sign.filter(|_| self.with_tentative);
        assert_eq!(sent.text(&["245", "CHR"]), old.as_deref());
        sent.is(&["245", "STI"], 0u64);
    }

    /// I062/136, 295 and 340.
    fn check_measured(&self, sent: &Sent<'_>, track: &SystemTrack) {
        let level = (track.level_valid != 0).then_some(f64::from(track.level) / 4.0);
        let allowed = level.filter(|level| (-15.0..=1500.0).contains(level));
        sent.near_if(&["136"], allowed, 0.25);
        let seconds = |age_ms: u32| (f64::from(age_ms) / 1e3).min(63.75);
        sent.near_if(&["295", "MFL"], level.map(|_| seconds(track.level_age_ms)), 0.25);
        let mode_3a = model::code(&track.identity);
        let code_age_ms = track.identity_ages.mode_3a_ms;
        sent.near_if(&["295", "MDA"], mode_3a.as_ref().map(|_| seconds(code_age_ms)), 0.25);
        let trigger = track.trigger_source;
        let is_listed = trigger < SOURCES - 1 && self.has_kind.get(usize::from(trigger)).copied().unwrap_or(true);
        let sensor = code(trigger).filter(|_| is_listed && technology(trigger) != Technology::AdsB);
        assert_eq!(sent.has(&["340"]), sensor.is_some(), "{}", sent.table);
        let Some([sac, sic]) = sensor else { return };
        sent.is(&["340", "SID", "SAC"], sac);
        sent.is(&["340", "SID", "SIC"], sic);
        let age_ms = (track.reference_time_ns - track.time_of_measurement_ns) / 1_000_000;
        let is_new = |value_ms: u32| i64::from(value_ms) == age_ms;
        let new_level = allowed.filter(|_| is_new(track.level_age_ms));
        sent.near_if(&["340", "MDC", "LMC"], new_level, 0.25);
        let new_code = mode_3a.filter(|_| is_new(code_age_ms));
        assert_eq!(sent.text(&["340", "MDA", "MODE3A"]).map(str::to_owned), new_code);
        let kind = match technology(trigger) {
            Technology::Primary => 1u64,
            Technology::Secondary => 2,
            _ => 0,
        };
        sent.is(&["340", "TYP", "TYP"], kind);
        assert!(!sent.has(&["340", "POS"]) && !sent.has(&["340", "HEIGHT"]));
    }

    fn check_status(&self, sent: &Sent<'_>, expected: &Expected<'_>) {
        let track = expected.track;
        let state = TrackState::from_code(track.state).unwrap();
        let edition = sent.table.edition;
        sent.is(&["080", "MON"], u64::from(expected.history.sources == 1));
        let special = track.alerts & alert_bits::SPECIAL_IDENTIFICATION != 0;
        sent.is(&["080", "SPI"], u64::from(special));
        sent.is(&["080", "CNF"], u64::from(state == TrackState::Tentative));
        sent.is(&["080", "SIM"], 0u64);
        sent.is(&["080", "TSE"], u64::from(TrackState::is_off(state as u8)));
        sent.is(&["080", "TSB"], u64::from(expected.is_first));
        sent.is(&["080", "CST"], u64::from(state == TrackState::Coasted));
        sent.is(&["080", "EMS"], model::emergency(track.alerts));
        let fresh = |kind: usize| {
            let of_kind = |source: u16| usize::from(source) == kind;
            let mut fresh = track
                .contributions()
                .iter()
                .filter(|part| part.flags & contribution_bits::FRESH != 0);
            fresh.any(|part| of_kind(part.source))
        };
        for (kind, flag) in ["PSR", "SSR", "MDS", "ADS", "MLAT"].into_iter().enumerate() {
            let can_be_said = flag != "MLAT" || edition >= Edition::new(1, 20);
            let stale = can_be_said && self.has_kind[kind] && !fresh(kind);
            sent.is(&["080", flag], u64::from(stale));
        }
        let primary = expected.history.kinds.contains(&0);
        let co_operative = expected.history.kinds.iter().any(|kind| *kind != 0);
        let source = match (primary, co_operative, expected.history.other) {
            (true, true, _) => 0u64,
            (false, true, false) => 1,
            (true, false, false) => 2,
            _ => 3,
        };
        sent.is(&["080", "SDS"], source);
        let on_ground = track.on_ground != 0 && edition >= Edition::new(1, 18);
        sent.is(&["080", "SFC"], u64::from(on_ground));
        for flag in [
            "FPC", "AFF", "STP", "KOS", "AMA", "MD4", "ME", "MI", "MD5", "SUC", "AAC", "PFT", "FPLT", "DUPT",
        ] {
            sent.is(&["080", flag], 0u64);
        }
    }

    fn check_ages(&self, sent: &Sent<'_>, expected: &Expected<'_>) {
        for (kind, (_, subitem)) in KINDS.iter().enumerate() {
            let last_ns = expected.history.last_ns.get(&kind);
            let age_s = last_ns.map(|last_ns| (expected.track.reference_time_ns - last_ns) as f64 / 1e9);
            sent.near_if(&["290", subitem], age_s.map(|age_s| age_s.clamp(0.0, 63.75)), 0.25);
        }
        assert!(!sent.has(&["290", "TRK"]));
    }

    fn check_accuracies(&self, sent: &Sent<'_>, track: &SystemTrack) {
        let covariance = &track.covariance;
        let sigma = |axis: usize| covariance.get(axis, axis).sqrt();
        sent.near_sigma(&["500", "APC", "X"], sigma(0), 0.5, 65_535);
        sent.near_sigma(&["500", "APC", "Y"], sigma(1), 0.5, 65_535);
        let root = covariance.get(0, 1).abs().sqrt().min(16_383.5);
        sent.near(&["500", "COV"], root.copysign(covariance.get(0, 1)), 0.5);
        let has_height = track.height_valid != 0;
        let row = |axis: usize| {
            let known = gradient(|vector| self.world.at_target(track.position_m, vector)[axis]);
            let level = gradient(|vector| self.world.velocity(track.position_m, vector, has_height)[axis]);
            (known, level)
        };
        assert_eq!(sent.has(&["500", "ATV"]), track.velocity_valid != 0);
        for (axis, element) in [(0, "X"), (1, "Y")] {
            if track.velocity_valid == 0 {
                continue;
            }
            let (_, row) = row(axis);
            let variance = World::velocity_covariance(covariance, row, row);
            sent.near_sigma(&["500", "ATV", element], variance.sqrt(), 0.25, 255);
        }
        let (up, _) = row(2);
        let height_sigma_m = World::position_covariance(covariance, up, up).sqrt();
        let climb_sigma_mps = match track.climb_rate_variance > 0.0 {
            true => f64::from(track.climb_rate_variance).sqrt(),
            false => World::velocity_covariance(covariance, up, up).sqrt(),
        };
        let of_height = |reference| has_height && self.height == reference;
        assert_eq!(sent.has(&["500", "AGA"]), of_height(HeightReference::Geometric));
        assert_eq!(sent.has(&["500", "ABA"]), of_height(HeightReference::Barometric));
        assert_eq!(sent.has(&["500", "ARC"]), has_climb(track));
        if of_height(HeightReference::Geometric) {
            sent.near_sigma(&["500", "AGA"], height_sigma_m / FOOT_M, 6.25, 255);
        }
        if of_height(HeightReference::Barometric) {
            sent.near_sigma(&["500", "ABA"], height_sigma_m / LEVEL_M, 0.25, 255);
        }
        if has_climb(track) {
            sent.near_sigma(&["500", "ARC"], climb_sigma_mps / CLIMB_LSB_MPS * 6.25, 6.25, 255);
        }
    }
}

/// Whether the rate of climb is known: half of the variance of an unknown one is 200 m²/s².
fn has_climb(track: &SystemTrack) -> bool {
    let is_sure = track.climb_rate_variance > 0.0 || track.covariance.get(5, 5) < 200.0;
    track.height_valid != 0 && track.velocity_valid != 0 && is_sure
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Every state that is to be sent is, and says what the track says, within half an LSB.
    #[test]
    fn records_say_what_the_tracks_say(
        world in world(), tracks in prop::collection::vec(system_track(), 1..16),
        barometric in any::<bool>(), has_kind in prop::collection::vec(any::<bool>(), 5),
        with_tentative in any::<bool>(),
    ) {
        let height = if barometric { HeightReference::Barometric } else { HeightReference::Geometric };
        let case = Case { world, height, has_kind, with_tentative };
        for table in registry::editions(62) {
            case.run(table, &tracks);
        }
    }
}

#[test]
fn a_track_without_covariance_has_no_accuracies() {
    let world = World::simple(45.0, 11.25);
    let table = registry::default_edition(62).unwrap();
    let mut sender = SystemReports::new(table, 1, 2, world.system, &[], 1400).unwrap();
    let mut bytes = vec![];
    let track = SystemTrack {
        state: TrackState::Confirmed as u8,
        ..SystemTrack::default()
    };
    sender.report(&track, &mut |block| bytes.extend_from_slice(block));
    sender.flush(&mut |block| bytes.extend_from_slice(block));
    let found = records(table, &bytes);
    assert!(found[0].get(&["500"]).is_none() && found[0].get(&["290"]).is_none() && found[0].get(&["380"]).is_none());
}

#[test]
fn positions_that_are_none_are_refused() {
    let world = World::simple(45.0, 11.25);
    let table = registry::default_edition(62).unwrap();
    let mut sender = SystemReports::new(table, 1, 2, world.system, &[], 1400).unwrap();
    for position_m in [[f64::NAN; 3], [1e9, 0.0, 0.0], [0.0, 0.0, f64::NEG_INFINITY]] {
        let track = SystemTrack {
            position_m,
            state: TrackState::Confirmed as u8,
            ..SystemTrack::default()
        };
        sender.report(&track, &mut |_| panic!("a block of nothing"));
    }
    let odd_state = SystemTrack {
        state: 77,
        ..SystemTrack::default()
    };
    sender.report(&odd_state, &mut |_| panic!("a block of nothing"));
    sender.flush(&mut |_| panic!("a block of nothing"));
    let counts = sender.counts();
    assert_eq!((counts.refused_position, counts.refused(), counts.withheld), (3, 3, 1));
}

#[test]
fn track_numbers_run_out_and_come_back() {
    let world = World::simple(45.0, 11.25);
    let table = registry::default_edition(62).unwrap();
    let mut sender = SystemReports::new(table, 1, 2, world.system, &[], 1400).unwrap();
    let mut report = |track_number: u32, state: TrackState, reference_time_ns: i64| {
        let track = SystemTrack {
            track_number,
            state: state as u8,
            reference_time_ns,
            ..SystemTrack::default()
        };
        sender.report(&track, &mut |_| ());
        sender.counts().refused_number
    };
    let refused = (1..=20_000)
        .map(|number| report(number, TrackState::Confirmed, 0))
        .last()
        .unwrap();
    assert_eq!(refused, 20_000 - 16_384);
    report(1, TrackState::Terminated, 1);
    assert_eq!(
        report(30_000, TrackState::Confirmed, 2),
        refused + 1,
        "the number rests"
    );
    assert_eq!(
        report(30_000, TrackState::Confirmed, 61_000_000_000),
        refused + 1,
        "and is free"
    );
}
