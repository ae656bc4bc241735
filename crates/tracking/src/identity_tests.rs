//! Identity as evidence: worked checks of the ratios, properties, and what becomes of targets that name themselves.

use std::collections::BTreeSet;

use messages::Identity;
use observations::{Detection, TransponderReply};
use proptest::prelude::*;

use super::*;
use crate::testing::{S, position, settings};
use crate::{Settings, Tracker};

const ONE: u32 = 0x4c_a7b3;
const OTHER: u32 = 0x3c_65ac;
const USUAL: IdentitySettings = IdentitySettings {
    used: true,
    garbled_probability: 0.01,
    swapped_probability: 0.002,
    changed_probability: 0.001,
    duplicated_probability: 1e-4,
    existence_min: 1e-5,
};

fn reply(address: Option<u32>, code: Option<u16>) -> TransponderReply {
    let mut identity = Identity::default();
    if let Some(address) = address {
        identity = identity.with_address(address);
    }
    if let Some(code) = code {
        identity = identity.with_mode_3a(code);
    }
    TransponderReply {
        identity,
        ..TransponderReply::default()
    }
}

fn of(reply: &TransponderReply) -> PlotIdentity {
    PlotIdentity::of(reply, 0, false)
}

fn track(replies: &[TransponderReply]) -> TrackIdentity {
    let mut track = TrackIdentity::NONE;
    replies.iter().for_each(|reply| track.take(&of(reply)));
    track
}

/// The ratio of the reply `seen` in a scan with these replies.
fn ratio(track: &TrackIdentity, scan: &[TransponderReply], seen: &TransponderReply) -> f64 {
    let scan: Vec<_> = scan.iter().chain([seen]).map(of).collect();
    let mut replies = ScanReplies::new(scan.len(), USUAL, 5000.0);
    replies.read(scan.iter());
    replies.log_ratio(track, &of(seen)).exp()
}

fn assert_near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} instead of {expected}");
}

#[test]
fn an_address_counts_by_duplicates_and_against_by_garbled_ones() {
    let known = track(&[reply(Some(ONE), None); 2]);
    assert_near(
        ratio(&known, &[], &reply(Some(ONE), None)),
        0.998 * (0.99 / 1e-4 + 0.01) + 0.002,
    );
    assert_near(ratio(&known, &[], &reply(Some(OTHER), None)), 0.998 * 0.01 + 0.002);
    // A single detection may be the garbled one.
    let new = track(&[reply(Some(ONE), None)]);
    assert_near(ratio(&new, &[], &reply(Some(OTHER), None)), 0.998 * 0.02 + 0.002);
    assert_near(
        ratio(&new, &[], &reply(Some(ONE), None)),
        0.998 * (0.99 * 0.99 / 1e-4 + 0.02) + 0.002,
    );
}

#[test]
fn nothing_stated_and_the_addresses_of_none_say_nothing() {
    let known = track(&[reply(Some(ONE), Some(0o4213)); 2]);
    for silent in [reply(None, None), reply(Some(0), None), reply(Some(0xff_ffff), None)] {
        assert_eq!(ratio(&known, &[], &silent), 1.0);
        assert_eq!(ratio(&track(&[silent; 3]), &[], &reply(Some(ONE), None)), 1.0);
        assert_eq!(track(&[silent; 3]), TrackIdentity::NONE);
    }
    // A ship whose number has the digits of an aircraft's address.
    let mut ship = TransponderReply::default();
    ship.identity = ship.identity.with_mmsi(ONE);
    assert!(ratio(&known, &[], &ship) < 0.02);
    assert_eq!(track(&[ship; 2]).reported().identity.mmsi(), Some(ONE));
}

/// Ten codes in all, one of them shown by four others: a share of 4 among 9, with the ten codes that the list is worth.
#[test]
fn a_code_counts_by_how_rare_it_is() {
    let code = |code| reply(None, Some(code));
    let scan: Vec<_> = [0o4213; 4].into_iter().chain(0o101..0o106).map(code).collect();
    let known = track(&[code(0o4213); 2]);
    let share = (10.0 / 4096.0 + 4.0) / 19.0;
    let expected = 0.99 / share + 0.01 / (4096.0 * share) + 0.001;
    assert_near(ratio(&known, &scan, &code(0o4213)), 0.998 * expected + 0.002);
    // Alone in the scan it is as rare as any, and strong; a code of visual flight is not.
    assert_near(
        ratio(&known, &[], &code(0o4213)),
        0.998 * (0.99 * 4096.0 + 0.011) + 0.002,
    );
    let visual = track(&[code(0o7000); 2]);
    let of_list = ratio(&visual, &[], &code(0o7000));
    assert!((5.0..15.0).contains(&of_list), "{of_list}");
    // Another code: garbled or changed.
    assert_near(ratio(&known, &[], &code(0o5555)), 0.998 * (0.01 + 0.001) + 0.002);
}

#[test]
fn a_changed_code_is_followed_and_a_garbled_one_is_not() {
    let code = |code| reply(None, Some(code));
    let mut one = track(&[code(0o4213); 5]);
    one.take(&of(&code(0o5555)));
    assert_eq!(one.reported().identity.mode_3a(), Some(0o4213), "not yet believed");
    let changed = 0.001 / 0.011;
    assert_near(
        ratio(&one, &[], &code(0o5555)),
        0.998 * (changed * 0.99 * 4096.0 + 0.011) + 0.002,
    );
    assert!(ratio(&one, &[], &code(0o4213)) > 3000.0);
    let mut garbled = one;
    garbled.take(&of(&code(0o4213)));
    garbled.take(&of(&code(0o5555)));
    assert_eq!(garbled.reported().identity.mode_3a(), Some(0o4213));
    one.take(&of(&code(0o5555)));
    assert_eq!(one.reported().identity.mode_3a(), Some(0o5555));
    assert!(ratio(&one, &[], &code(0o4213)) < 0.02, "the old code is gone");
}

#[test]
fn an_address_is_worn_down_and_does_not_change() {
    let mut one = track(&[reply(Some(ONE), None); 20]);
    for contradictions in 1..=6 {
        one.take(&of(&reply(Some(OTHER), None)));
        let found = one.reported().identity.address();
        let expected = match contradictions {
            1..=4 => Some(ONE),
            5 => None,
            _ => Some(OTHER),
        };
        assert_eq!(found, expected, "{contradictions}");
        if contradictions < 5 {
            assert!(ratio(&one, &[], &reply(Some(OTHER), None)) < 0.02);
        }
    }
}

#[test]
fn the_price_of_a_whole_reply_is_limited() {
    let known = track(&[reply(Some(ONE), Some(0o4213)); 4]);
    let strange = ratio(&known, &[], &reply(Some(OTHER), Some(0o5555)));
    assert_near(strange, 0.998 * 0.01 * 0.011 + 0.002);
}

#[test]
fn a_callsign_counts_only_where_the_address_decides_nothing() {
    let called = |name: &[u8; 8], address| {
        let mut reply = reply(address, None);
        reply.identity = reply.identity.with_callsign(*name);
        reply
    };
    let known = track(&[called(b"RYR48CP ", None); 2]);
    assert!(ratio(&known, &[], &called(b"RYR48CP ", None)) > 5000.0);
    assert_near(ratio(&known, &[], &called(b"VLG20PM ", None)), 0.998 * 0.011 + 0.002);
    let named = track(&[called(b"RYR48CP ", Some(ONE)); 2]);
    let by_address = ratio(&named, &[], &reply(Some(ONE), None));
    assert_eq!(ratio(&named, &[], &called(b"VLG20PM ", Some(ONE))), by_address);
}

#[test]
fn a_level_counts_where_the_height_is_not_measured() {
    let at = |level| TransponderReply {
        level: Some(level),
        ..TransponderReply::default()
    };
    let seen = |level: i16, time_ns, has_height| {
        let mut known = TrackIdentity::NONE;
        known.take(&PlotIdentity::of(&at(1400), 0, has_height));
        let seen = PlotIdentity::of(&at(level), time_ns, has_height);
        let mut replies = ScanReplies::new(1, USUAL, 5000.0);
        replies.read([seen].iter());
        replies.log_ratio(&known, &seen).exp()
    };
    // 100 feet are 4 steps; their rounding has a deviation of 8.8 m, two of them 12.4 m.
    let sigma_m = 100.0 * 0.3048 / 12f64.sqrt() * 2f64.sqrt();
    assert_near(seen(1400, 0, false), 0.998 * (0.99 * 5000.0 / sigma_m + 0.01) + 0.002);
    assert!(seen(1404, 4 * S, false) > 50.0, "a climb within a turn");
    assert!(seen(1480, 4 * S, false) < 0.05, "2000 feet");
    assert_eq!(seen(1480, 4 * S, true), 1.0, "the height is in the measurement");
}

#[test]
fn united_detections_keep_what_they_agree_on() {
    let mut one = of(&reply(Some(ONE), Some(0o4213)));
    one.unite(&of(&reply(Some(ONE), Some(0o5555))));
    assert_eq!(
        one,
        PlotIdentity {
            stated_ns: one.stated_ns,
            ..of(&reply(Some(ONE), None))
        }
    );
    let mut none = of(&reply(None, None));
    none.unite(&of(&reply(Some(OTHER), None)));
    assert_eq!(none.values[ADDRESS], u64::from(OTHER));
}

/// Detection at a place of a target that states a reply.
fn stating(time_ns: i64, [east, north]: [f64; 2], reply: TransponderReply) -> Detection {
    Detection {
        reply,
        ..position(time_ns, east, north)
    }
}

/// Numbers of the tracks nearest to a place, over the scans.
fn numbers_at(places: &[[f64; 2]], pictures: &[Vec<(u32, [f64; 2])>]) -> BTreeSet<u32> {
    let nearest = |place: &[f64; 2], picture: &Vec<(u32, [f64; 2])>| {
        let away = |at: &[f64; 2]| (at[0] - place[0]).hypot(at[1] - place[1]);
        let near = picture.iter().filter(|(_, at)| away(at) < 300.0);
        near.min_by(|one, other| away(&one.1).total_cmp(&away(&other.1)))
            .map(|(number, _)| *number)
    };
    let both = places.iter().zip(pictures);
    both.filter_map(|(place, picture)| nearest(place, picture)).collect()
}

/// Flies targets with their replies, a scan a second, and returns their numbers.
fn fly(settings: &Settings, paths: &[Vec<([f64; 2], TransponderReply)>]) -> (Vec<BTreeSet<u32>>, Tracker) {
    let mut tracker = Tracker::new(settings.clone()).unwrap();
    let mut pictures = Vec::new();
    for second in 0..paths[0].len() {
        let time_ns = second as i64 * S;
        let scan: Vec<_> = paths
            .iter()
            .map(|path| stating(time_ns, path[second].0, path[second].1))
            .collect();
        tracker.scan(1, time_ns, &scan).unwrap();
        let tracks = tracker.tracks().iter();
        pictures.push(
            tracks
                .map(|track| (track.number, [track.estimate.mean[0], track.estimate.mean[1]]))
                .collect::<Vec<_>>(),
        );
    }
    let places = |path: &Vec<([f64; 2], TransponderReply)>| path.iter().map(|(place, _)| *place).collect::<Vec<_>>();
    let numbers = paths.iter().map(|path| numbers_at(&places(path), &pictures)).collect();
    (numbers, tracker)
}

fn unused(settings: &Settings) -> Settings {
    let mut unused = settings.clone();
    unused.identity.used = false;
    unused
}

/// Two targets fly towards each other and each turns back where they meet: by motion alone they pass.
#[test]
fn targets_that_turn_back_where_they_meet_keep_their_numbers() {
    let path = |side: f64, address: u32| {
        let at = |second: i32| [side * (5.0 + 15.0 * f64::from((second - 12).abs())), 0.0];
        (0..24)
            .map(|second| (at(second), reply(Some(address), None)))
            .collect::<Vec<_>>()
    };
    let paths = [path(-1.0, ONE), path(1.0, OTHER)];
    let west = |tracker: &Tracker| {
        let mut tracks = tracker.tracks().iter();
        let west = tracks.find(|track| track.estimate.mean[0] < 0.0).unwrap();
        (west.number, west.identity.identity.address())
    };
    let (_, tracker) = fly(&settings(), &paths);
    let (_, by_motion) = fly(&unused(&settings()), &paths);
    assert_eq!((west(&tracker), west(&by_motion).0), ((1, Some(ONE)), 2));
    assert_eq!((tracker.counts().confirmed, by_motion.counts().confirmed), (2, 2));
}

/// A turn by a right angle within a scan, sharper than the model allows.
#[test]
fn a_sharp_turn_is_followed_by_the_target_that_names_itself() {
    let at = |second: i32| match second {
        0..10 => [60.0 * f64::from(second), 0.0],
        _ => [600.0, 60.0 * f64::from(second - 10)],
    };
    for named in [reply(Some(ONE), None), reply(None, Some(0o4213))] {
        let path: Vec<_> = (0..20).map(|second| (at(second), named)).collect();
        let mut settings = settings();
        settings.initiation.speed_sigma_mps = 60.0;
        let (numbers, tracker) = fly(&settings, std::slice::from_ref(&path));
        assert_eq!(numbers[0].len(), 1, "{numbers:?}");
        assert_eq!(tracker.tracks().len(), 1);
        let (by_motion, _) = fly(&unused(&settings), &[path]);
        assert!(by_motion[0].len() > 1, "{by_motion:?}");
    }
}

#[test]
fn bad_decodes_start_no_ghost_and_break_no_track() {
    let at = |second: u32| [15.0 * f64::from(second), 0.0];
    let bad = [
        reply(Some(OTHER), Some(0o7777)),
        reply(Some(0x12_3456), Some(0o0001)),
        reply(None, None),
    ];
    let path: Vec<_> = (0..40)
        .map(|second| {
            let good = reply(Some(ONE), Some(0o4213));
            let reply = if second % 5 == 4 {
                bad[second as usize % 3]
            } else {
                good
            };
            (at(second), reply)
        })
        .collect();
    let (numbers, tracker) = fly(&settings(), &[path]);
    assert_eq!(numbers[0].len(), 1, "{numbers:?}");
    assert_eq!((tracker.tracks().len(), tracker.counts().confirmed), (1, 1));
    let identity = tracker.tracks()[0].identity.identity;
    assert_eq!((identity.address(), identity.mode_3a()), (Some(ONE), Some(0o4213)));
}

/// Where the target is missed, its neighbour's detection is in its gate, with another address, code and callsign.
#[test]
fn a_neighbour_with_another_address_moves_no_track_and_lends_it_no_code() {
    let of_neighbour = TransponderReply {
        identity: Identity::default()
            .with_address(OTHER)
            .with_mode_3a(0o7777)
            .with_callsign(*b"VLG20PM "),
        ..TransponderReply::default()
    };
    for missed in [1, 2] {
        let mut tracker = Tracker::new(settings()).unwrap();
        for second in 0..20i64 {
            let is_missed = (10..10 + missed).contains(&second);
            let scan = match is_missed {
                true => stating(second * S, [15.0 * second as f64, 12.0], of_neighbour),
                false => stating(second * S, [15.0 * second as f64, 0.0], reply(Some(ONE), None)),
            };
            tracker.scan(1, second * S, &[scan]).unwrap();
            let known = |track: &&crate::TrackReport| track.identity.identity.address() == Some(ONE);
            let Some(track) = tracker.tracks().iter().find(known) else {
                assert!(second < 5, "{second}: no track");
                continue;
            };
            let [east, north, ..] = track.estimate.mean;
            let away_m = (east - 15.0 * second as f64).hypot(north);
            assert!(away_m < 1.0 || second < 10, "{second}: {away_m} m");
            let identity = track.identity.identity;
            assert_eq!((identity.mode_3a(), identity.callsign()), (None, None), "{second}");
            assert_eq!(track.number, 1);
        }
        let names = tracker.tracks().iter().map(|track| track.identity.identity.address());
        assert_eq!(names.collect::<Vec<_>>(), [Some(ONE)]);
    }
}

/// One bit of an address is wrong in some replies, first of all in the first one: one track, under the right address.
#[test]
fn garbled_addresses_end_no_track_and_start_none_that_is_shown() {
    for garbled in [&[0][..], &[1], &[7], &[0, 12, 25], &[6, 12, 18, 24, 30, 36]] {
        let path: Vec<_> = (0..40)
            .map(|second| {
                let bit = if garbled.contains(&second) {
                    1 << (second % 24)
                } else {
                    0
                };
                ([15.0 * f64::from(second), 0.0], reply(Some(ONE ^ bit), Some(0o4213)))
            })
            .collect();
        let (numbers, tracker) = fly(&settings(), &[path]);
        assert_eq!(numbers[0].len(), 1, "{garbled:?}: {numbers:?}");
        assert_eq!(
            (tracker.tracks().len(), tracker.counts().confirmed),
            (1, 1),
            "{garbled:?}"
        );
        let identity = tracker.tracks()[0].identity.identity;
        assert_eq!((identity.address(), identity.mode_3a()), (Some(ONE), Some(0o4213)));
    }
}

/// Beside a neighbour, a garbled address starts no track that lives on the neighbour's detections, or on its own.
#[test]
fn garbled_addresses_of_neighbours_start_no_ghosts() {
    let path = |north: f64, address: u32, phase: u32| {
        let at = |second: u32| {
            let bit = if (second + phase).is_multiple_of(5) {
                1 << (second % 24)
            } else {
                0
            };
            ([15.0 * f64::from(second), north], reply(Some(address ^ bit), None))
        };
        (0..80).map(at).collect::<Vec<_>>()
    };
    let (_, tracker) = fly(&settings(), &[path(0.0, ONE, 0), path(30.0, OTHER, 2)]);
    assert_eq!((tracker.tracks().len(), tracker.counts().confirmed), (2, 2));
    let addresses: BTreeSet<_> = tracker
        .tracks()
        .iter()
        .map(|track| track.identity.identity.address())
        .collect();
    assert_eq!(addresses, BTreeSet::from([Some(ONE), Some(OTHER)]));
}

#[test]
fn a_reply_with_another_address_gives_a_track_nothing_else() {
    let mut one = track(&[reply(Some(ONE), None)]);
    one.take(&of(&reply(Some(OTHER), Some(0o7777))));
    assert_eq!(
        one.reported().identity,
        Identity::default(),
        "one of both addresses is garbled"
    );
    one.take(&of(&reply(Some(ONE), Some(0o4213))));
    let identity = one.reported().identity;
    assert_eq!((identity.address(), identity.mode_3a()), (Some(ONE), Some(0o4213)));
}

#[test]
fn a_track_follows_its_target_to_another_code() {
    let path: Vec<_> = (0..30)
        .map(|second| {
            let code = if second < 15 { 0o4213 } else { 0o7700 };
            ([15.0 * f64::from(second), 0.0], reply(None, Some(code)))
        })
        .collect();
    let (numbers, tracker) = fly(&settings(), &[path]);
    assert_eq!((numbers[0].len(), tracker.counts().confirmed), (1, 1));
    assert_eq!(tracker.tracks()[0].identity.identity.mode_3a(), Some(0o7700));
}

/// Replies of two targets far outside each other's gates are exchanged in single scans: neither jumps.
#[test]
fn exchanged_replies_exchange_no_tracks() {
    let path = |north: f64, [own, other]: [u32; 2]| {
        (0..30)
            .map(|second: u32| {
                let address = if second % 9 == 8 { other } else { own };
                ([15.0 * f64::from(second), north], reply(Some(address), None))
            })
            .collect::<Vec<_>>()
    };
    let paths = [path(0.0, [ONE, OTHER]), path(120.0, [OTHER, ONE])];
    let (numbers, tracker) = fly(&settings(), &paths);
    assert!(numbers.iter().all(|numbers| numbers.len() == 1), "{numbers:?}");
    assert_eq!(tracker.counts().confirmed, 2);
}

/// The scan has the target twice: a new track at the second detection would be a ghost.
#[test]
fn a_second_detection_of_one_address_starts_no_ghost() {
    let path = |off: f64, from: u32| {
        (0..20)
            .map(|second: u32| {
                let east = if second < from {
                    90e3
                } else {
                    off + 15.0 * f64::from(second)
                };
                let silent = if second < from {
                    reply(None, None)
                } else {
                    reply(Some(ONE), None)
                };
                ([east, 0.0], silent)
            })
            .collect::<Vec<_>>()
    };
    let paths = [path(0.0, 0), path(25.0, 8)];
    let (_, tracker) = fly(&settings(), &paths);
    let (_, by_motion) = fly(&unused(&settings()), &paths);
    let along = |tracker: &Tracker| {
        tracker
            .tracks()
            .iter()
            .filter(|track| track.estimate.mean[0] < 1000.0)
            .count()
    };
    assert_eq!((along(&tracker), along(&by_motion)), (1, 2));
}

#[test]
fn a_target_that_names_itself_is_missed_for_longer() {
    let lives = |reply| {
        let mut tracker = Tracker::new(settings()).unwrap();
        for second in 0..10 {
            let scan = [stating(4 * second * S, [15.0 * second as f64, 0.0], reply)];
            tracker.scan(1, 4 * second * S, &scan).unwrap();
        }
        let mut scans = 0;
        while tracker.branches() > 0 {
            scans += 1;
            tracker.scan(1, 4 * (9 + scans) * S, &[]).unwrap();
        }
        scans
    };
    // Until the existence is below 1e-3 and 1e-5.
    assert_eq!(lives(reply(None, None)), 6);
    assert_eq!(lives(reply(None, Some(0o7000))), 6, "one of many");
    assert_eq!(lives(reply(Some(ONE), None)), 8);
    assert_eq!(lives(reply(None, Some(0o4213))), 8);
}

#[test]
fn two_targets_of_one_address_are_two_tracks() {
    let path = |north: f64| {
        (0..20)
            .map(|second: u32| ([15.0 * f64::from(second), north], reply(Some(ONE), None)))
            .collect::<Vec<_>>()
    };
    let (numbers, tracker) = fly(&settings(), &[path(0.0), path(60.0), path(5000.0)]);
    assert!(numbers.iter().all(|numbers| numbers.len() == 1), "{numbers:?}");
    assert_eq!((tracker.tracks().len(), tracker.counts().confirmed), (3, 3));
}

#[test]
fn tracks_state_their_identity_with_its_age() {
    let mut stated = reply(Some(ONE), Some(0o4213));
    stated.identity = stated.identity.with_callsign(*b"RYR48CP ");
    stated.level = Some(1441);
    stated.level_age_ms = 500;
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..8 {
        // The last detections have only the code.
        let reply = if second < 6 { stated } else { reply(None, Some(0o4213)) };
        let scan = [stating(second * S, [15.0 * second as f64, 0.0], reply)];
        tracker.scan(1, second * S, &scan).unwrap();
    }
    tracker.scan(1, 8 * S, &[]).unwrap();
    let track = tracker.tracks()[0].sensor_track(0);
    assert_eq!(track.identity, stated.identity);
    let ages = track.identity_ages;
    assert_eq!((ages.address_ms, ages.mode_3a_ms, ages.callsign_ms), (3000, 1000, 3000));
    assert!(track.has(messages::sensor_track_bits::LEVEL));
    assert_eq!((track.level, track.level_age_ms), (1441, 3500));
    let mut picture = Vec::new();
    tracker.picture_at(10 * S, &mut picture);
    assert_eq!(picture[0].sensor_track(0).identity_ages.mode_3a_ms, 3000);
}

proptest! {
    /// No reply is dearer than an exchange, none is worth more than its rarest values, and all ratios are numbers.
    #[test]
    fn any_replies_have_a_bounded_ratio(
        values in prop::collection::vec((prop::option::of(0u32..4), prop::option::of(0u16..3)), 1..20),
        of_track in 0usize..20,
    ) {
        let replies: Vec<_> = values
            .iter()
            .map(|(address, code)| reply(address.map(|address| address * 0x55_5555), *code))
            .collect();
        let known = track(&replies[..of_track.min(replies.len())]);
        for seen in &replies {
            let found = ratio(&known, &replies, seen);
            prop_assert!((USUAL.swapped_probability..=1e4 * 4096.0).contains(&found), "{found}");
        }
    }

    /// Over all codes, weighed by how often other targets show them, the ratio is one: it is a ratio of probabilities.
    #[test]
    fn the_ratios_of_all_codes_have_the_mean_one(history in prop::collection::vec(0u16..3, 1..8)) {
        let known = track(&history.iter().map(|code| reply(None, Some(*code + 1))).collect::<Vec<_>>());
        let mut replies = ScanReplies::new(1, USUAL, 5000.0);
        let any = of(&reply(None, Some(9)));
        replies.read([any].iter());
        let ratios = (0..4096u16).filter(|code| !is_common((*code).into())).map(|code| {
            replies.log_ratio(&known, &of(&reply(None, Some(code)))).exp()
        });
        let mean = ratios.sum::<f64>() / 4091.0;
        prop_assert!((mean - 1.0).abs() < 0.03, "{mean}");
    }

    /// Replies that are not used, and none, give the same motion to the bit.
    #[test]
    fn without_evidence_tracks_are_the_same_to_the_bit(
        places in prop::collection::vec(prop::array::uniform2(-200.0..200.0f64), 30),
    ) {
        let mut plain = Tracker::new(settings()).unwrap();
        let mut deaf = Tracker::new(unused(&settings())).unwrap();
        for (second, places) in (0..).zip(places.chunks(3)) {
            let at = |reply: TransponderReply| {
                let scan = places.iter().map(|place| stating(second * S, *place, reply));
                scan.collect::<Vec<_>>()
            };
            plain.scan(1, second * S, &at(TransponderReply::default())).unwrap();
            deaf.scan(1, second * S, &at(reply(Some(ONE), Some(0o4213)))).unwrap();
            let motion = |tracker: &Tracker| {
                let tracks = tracker.tracks().iter();
                tracks.map(|track| (track.number, track.estimate, track.reliability)).collect::<Vec<_>>()
            };
            prop_assert_eq!(motion(&plain), motion(&deaf));
        }
    }
}

#[test]
fn a_ship_keeps_its_name_and_every_number_its_kind() {
    let named = |mmsi: u32, name: &str| TransponderReply {
        identity: Identity::default().with_mmsi(mmsi).with_name(name),
        ..TransponderReply::default()
    };
    let unnamed = reply(None, None);
    let found = track(&[named(227_000_000, "TWENTY CHARACTERS OK"), unnamed, unnamed])
        .reported()
        .identity;
    assert_eq!(found, named(227_000_000, "TWENTY CHARACTERS OK").identity);
    // The latest name counts; one alone is a reply, too.
    let renamed = track(&[named(1, "OLD"), named(1, "NEW")]).reported().identity;
    assert_eq!((renamed.mmsi(), renamed.name()), (Some(1), Some("NEW")));
    let name = Identity::default().with_name("ANNA");
    let alone = TransponderReply {
        identity: name,
        ..TransponderReply::default()
    };
    assert_eq!(track(&[alone]).reported().identity, name);
    // All ones in 24 bits is no address, but a ship's number; the number 0 is no ship's.
    assert_eq!(
        track(&[named(0x00ff_ffff, "A")]).reported().identity.mmsi(),
        Some(0x00ff_ffff)
    );
    assert_eq!(track(&[named(0, "A")]).reported().identity.mmsi(), None);
    for number in (0..30).map(|bit| 1u32 << bit) {
        assert_eq!(track(&[named(number, "A")]).reported().identity.mmsi(), Some(number));
        if number < 1 << 24 {
            let found = track(&[reply(Some(number), None)]).reported().identity;
            assert_eq!((found.address(), found.mmsi()), (Some(number), None));
        }
    }
}

#[test]
fn the_two_numbers_of_a_rescue_aircraft_do_not_contradict() {
    let mut by_ais = TransponderReply::default();
    by_ais.identity = by_ais.identity.with_mmsi(111_227_506);
    let by_radar = reply(Some(ONE), None);
    for [first, second] in [[by_ais, by_radar], [by_radar, by_ais]] {
        let known = track(&[first; 2]);
        assert_eq!(ratio(&known, &[], &second), 1.0);
        assert!(!known.has_another_address_than(&of(&second), true));
        let both = track(&[first, second, second, second, second, second, second]);
        assert_eq!(both.reported().identity, first.identity);
    }
}
