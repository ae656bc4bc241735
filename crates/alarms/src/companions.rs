//! Detection of sources that observe the same targets without association.
//!
//! If the position of a sensor is configured wrongly, each of its targets is tracked twice: at its true position by
//! the other sources, and at a displaced position by that sensor. Neither track shows an error, and no counter
//! grows. But the two tracks fly side by side, and unlike two aircraft on one airway, *all* such pairs have the
//! same shift. The search covers tracks with a contribution from only one of two sources. It looks for a shift that
//! maps several tracks of one source onto tracks of the other, with the same velocity. Two sources with a recent
//! common track are associated, and are excluded.
//!
//! Limits: a sensor with an azimuth bias or a clock offset moves each target by a different shift; the estimates of
//! azimuth bias and clock offset reveal these faults. Cost: quadratic in the number of tracks with a single source,
//! of which a limited number is compared.

use std::collections::BTreeMap;

use messages::{NS_PER_S, SystemTrack, TrackState};

/// Maximum number of stored tracks, and of compared single-source tracks per source.
const TRACKS_MAX: usize = 8192;
const LONE_MAX: usize = 64;
/// Minimum time between two updates of one track, nanoseconds: states arrive more often.
const LOOK_NS: i64 = 1_000_000_000;
/// Maximum number of shifts tested.
const SHIFTS_MAX: usize = 256;
/// Time without a state after which a track is dropped, and time for which a common track associates two sources,
/// nanoseconds.
const GONE_NS: i64 = 30_000_000_000;
const JOINED_NS: i64 = 600_000_000_000;
/// Minimum time with a single source, and minimum speed, of a track to compare.
const LONE_NS: i64 = 30_000_000_000;
const SPEED_MIN_MPS: f64 = 20.0;
/// Maximum shift, and maximum difference between the shifts of pairs with the same shift, metres.
const SHIFT_MAX_M: f64 = 50_000.0;
const SAME_SHIFT_M: f64 = 2_000.0;
/// Maximum difference between equal velocities: this, or two standard deviations up to the next.
const SAME_VELOCITY_MPS: f64 = 2.0;
const SAME_VELOCITY_MAX_MPS: f64 = 15.0;
/// Minimum number of pairs, and their minimum share of the tracks of the source with fewer tracks.
const PAIRS_MIN: usize = 3;
const PAIRS_SHARE: f64 = 0.5;

/// System tracks and their contributing sources.
#[derive(Clone, Debug, Default)]
pub struct Companions {
    incarnation: u64,
    tracks: BTreeMap<u32, CompanionTrack>,
    /// Time of the latest common track of two sources, monotonic, nanoseconds.
    joined_ns: BTreeMap<(u16, u16), i64>,
}

#[derive(Clone, Copy, Debug)]
struct CompanionTrack {
    heard_ns: i64,
    /// Single source and its start time; `None` for several sources.
    only: Option<(u16, i64)>,
    reference_ns: i64,
    position_m: [f64; 2],
    velocity_mps: [f64; 2],
    velocity_variance: f64,
}

/// Two sources with tracks side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Number of the first source.
    pub source: u16,
    /// Number of the second source, which is larger.
    pub partner: u16,
    /// Number of pairs of tracks with the same shift.
    pub pairs: usize,
    /// Position of the partner's tracks less that of the source's, east and north, metres.
    pub shift_m: [f64; 2],
}

impl Companions {
    /// Adds a state received at `now_ns` (monotonic, nanoseconds) from the fusion process of `incarnation`.
    pub fn take(&mut self, incarnation: u64, track: &SystemTrack, now_ns: i64) {
        if incarnation != self.incarnation {
            *self = Self {
                incarnation,
                ..Self::default()
            };
        }
        if track.state != TrackState::Confirmed.code() {
            self.tracks.remove(&track.track_number);
            return;
        }
        let before = self.tracks.get(&track.track_number);
        if before.is_some_and(|before| now_ns - before.heard_ns < LOOK_NS) {
            return;
        }
        let contributions = track.contributions();
        for (place, one) in contributions.iter().enumerate() {
            for other in &contributions[place + 1..] {
                self.joined_ns.insert(ordered(one.source, other.source), now_ns);
            }
        }
        let source = match contributions {
            [only] => Some(only.source),
            _ => None,
        };
        if before.is_none() && self.tracks.len() == TRACKS_MAX {
            return;
        }
        let since_ns = before
            .and_then(|before| before.only)
            .filter(|(of, _)| Some(*of) == source);
        let [vx, vy] = [3, 4].map(|axis| track.covariance.get(axis, axis));
        let state = CompanionTrack {
            heard_ns: now_ns,
            only: source.map(|source| (source, since_ns.map_or(now_ns, |(_, since_ns)| since_ns))),
            reference_ns: track.reference_time_ns,
            position_m: [track.position_m[0], track.position_m[1]],
            velocity_mps: [track.velocity_mps[0], track.velocity_mps[1]],
            velocity_variance: 0.5 * (vx + vy),
        };
        self.tracks.insert(track.track_number, state);
    }

    /// Returns pairs of sources that observe the same targets without any common track, at `now_ns` (monotonic,
    /// nanoseconds).
    pub fn apart(&mut self, now_ns: i64) -> Vec<Apart> {
        self.tracks.retain(|_, track| now_ns - track.heard_ns < GONE_NS);
        self.joined_ns.retain(|_, joined_ns| now_ns - *joined_ns < JOINED_NS);
        let mut lone: BTreeMap<u16, Vec<&CompanionTrack>> = BTreeMap::new();
        for track in self.tracks.values() {
            let [east, north] = track.velocity_mps;
            let moves = east.hypot(north) > SPEED_MIN_MPS;
            if let Some((source, _)) = track.only.filter(|(_, since_ns)| moves && now_ns - since_ns > LONE_NS) {
                let of_source = lone.entry(source).or_default();
                if of_source.len() < LONE_MAX {
                    of_source.push(track);
                }
            }
        }
        let sources: Vec<(&u16, &Vec<&CompanionTrack>)> = lone.iter().collect();
        let mut apart = Vec::new();
        for (place, (source, of_source)) in sources.iter().enumerate() {
            for (partner, of_partner) in &sources[place + 1..] {
                if self.joined_ns.contains_key(&(**source, **partner)) {
                    continue;
                }
                let (pairs, shift_m) = same_shift(of_source, of_partner);
                let fewer = of_source.len().min(of_partner.len()) as f64;
                if pairs >= PAIRS_MIN && pairs as f64 >= PAIRS_SHARE * fewer {
                    apart.push(Apart {
                        source: **source,
                        partner: **partner,
                        pairs,
                        shift_m,
                    });
                }
            }
        }
        apart
    }
}

fn ordered(one: u16, other: u16) -> (u16, u16) {
    (one.min(other), one.max(other))
}

/// Returns the shift that maps the most tracks of `of_source` onto tracks of `of_partner`, with their number.
fn same_shift(of_source: &[&CompanionTrack], of_partner: &[&CompanionTrack]) -> (usize, [f64; 2]) {
    // A track has one companion per shift, so the tracks are counted, not the pairs.
    let shifts: Vec<(usize, [f64; 2])> = of_source
        .iter()
        .enumerate()
        .flat_map(|(index, track)| {
            let companions = of_partner.iter().filter_map(|other| shift(track, other));
            companions.map(move |shift_m| (index, shift_m))
        })
        .collect();
    let with = |of: [f64; 2]| {
        let near = shifts
            .iter()
            .filter(|(_, shift_m)| distance(*shift_m, of) < SAME_SHIFT_M);
        let mut tracks: Vec<usize> = near.map(|(index, _)| *index).collect();
        tracks.dedup();
        (tracks.len(), of)
    };
    let tried = shifts.iter().step_by(1 + shifts.len() / SHIFTS_MAX);
    let candidates = tried.map(|(_, shift_m)| with(*shift_m));
    candidates.max_by_key(|(tracks, _)| *tracks).unwrap_or_default()
}

/// Returns the shift from a track to another at the same time, if both have the same velocity and are near enough.
fn shift(track: &CompanionTrack, other: &CompanionTrack) -> Option<[f64; 2]> {
    let sigma_mps = (track.velocity_variance + other.velocity_variance).max(0.0).sqrt();
    let same_mps = (2.0 * sigma_mps).clamp(SAME_VELOCITY_MPS, SAME_VELOCITY_MAX_MPS);
    if distance(track.velocity_mps, other.velocity_mps) > same_mps {
        return None;
    }
    let seconds = (track.reference_ns - other.reference_ns) as f64 / NS_PER_S;
    let shift_m = std::array::from_fn(|axis| {
        other.position_m[axis] + seconds * other.velocity_mps[axis] - track.position_m[axis]
    });
    (distance(shift_m, [0.0; 2]) < SHIFT_MAX_M).then_some(shift_m)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use messages::{Contribution, Covariance};
    use test_support::S;

    use super::*;

    /// State of a track at `now_s` with a speed of 200 m/s in the direction `heading`, and with these contributors.
    fn state(number: u32, now_s: i64, [x, y]: [f64; 2], heading: f64, sources: &[u16]) -> SystemTrack {
        let velocity = [200.0 * heading.cos(), 200.0 * heading.sin()];
        let mut track = SystemTrack {
            track_number: number,
            reference_time_ns: now_s * S,
            state: TrackState::Confirmed.code(),
            position_m: [x + velocity[0] * now_s as f64, y + velocity[1] * now_s as f64, 9000.0],
            velocity_mps: [velocity[0], velocity[1], 0.0],
            covariance: Covariance::diagonal([50.0; 3], [2.0; 3]),
            contribution_count: sources.len() as u16,
            ..SystemTrack::default()
        };
        for (place, source) in sources.iter().enumerate() {
            track.contributions[place] = Contribution {
                source: *source,
                ..Contribution::default()
            };
        }
        track
    }

    /// Ten targets, observed for two minutes by source 1 and, displaced by `shift`, by source 4.
    fn seen(companions: &mut Companions, shift: impl Fn(u32) -> [f64; 2]) -> Vec<Apart> {
        for now_s in 0..120 {
            for number in 0..10 {
                let place = [
                    f64::from(number * 7_919 % 40) * 1_000.0,
                    f64::from(number * 104_729 % 40) * 1_000.0,
                ];
                let heading = f64::from(number);
                let [east, north] = shift(number);
                companions.take(1, &state(number, now_s, place, heading, &[1]), now_s * S);
                let beside = [place[0] + east, place[1] + north];
                companions.take(1, &state(100 + number, now_s, beside, heading, &[4]), now_s * S);
            }
        }
        companions.apart(119 * S)
    }

    #[test]
    fn a_sensor_in_the_wrong_place_is_found() {
        let mut companions = Companions::default();
        let found = seen(&mut companions, |_| [8_000.0, -3_000.0]);
        let [apart] = &found[..] else { panic!("{found:?}") };
        assert_eq!((apart.source, apart.partner, apart.pairs), (1, 4, 10));
        assert!(distance(apart.shift_m, [8_000.0, -3_000.0]) < 1.0);
        // One track gets both sources: the sources are associated.
        companions.take(1, &state(3, 121, [0.0; 2], 1.0, &[1, 4]), 121 * S);
        assert_eq!(companions.apart(121 * S), []);
        assert_eq!(companions.apart(1_000 * S), [], "nothing was heard for long");
    }

    #[test]
    fn traffic_that_flies_side_by_side_by_chance_is_not() {
        let mut companions = Companions::default();
        let scattered = |number: u32| [f64::from(number) * 4_000.0 - 20_000.0, f64::from(number % 3) * 9_000.0];
        assert_eq!(seen(&mut companions, scattered), []);
        let one_airway = |number: u32| if number < 2 { [8_000.0, 0.0] } else { [1e6, 0.0] };
        assert_eq!(seen(&mut Companions::default(), one_airway), []);
    }

    #[test]
    fn a_restarted_fusion_begins_anew_and_memory_is_bounded() {
        let mut companions = Companions::default();
        for number in 0..2 * TRACKS_MAX as u32 {
            companions.take(1, &state(number, 0, [0.0; 2], 0.0, &[1]), 0);
        }
        assert_eq!(companions.tracks.len(), TRACKS_MAX);
        companions.take(2, &state(1, 0, [0.0; 2], 0.0, &[1]), 0);
        assert_eq!(companions.tracks.len(), 1);
        let ended = SystemTrack {
            state: TrackState::Terminated.code(),
            ..state(1, 1, [0.0; 2], 0.0, &[1])
        };
        companions.take(2, &ended, S);
        assert!(companions.tracks.is_empty());
    }
}
