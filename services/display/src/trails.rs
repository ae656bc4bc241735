//! Past positions of all tracks: `GET /api/trails?until_s=…`, for a page that was just opened or moved through time.
//!
//! The response is binary, little-endian: the end of the trails (f64, seconds since 1970), then per track its number
//! (u32), the count of its points (u32), and the points, the latest first: age at the end of the trails (s), metres
//! east, metres north (f32 each). JSON of 2,000 tracks would have 10 MB.

use crate::details::seconds;
use crate::history::Then;
use crate::world::World;

/// Length of the trails, nanoseconds.
const SPAN_NS: i64 = 600_000_000_000;
/// Time between two points, nanoseconds.
const STEP_NS: i64 = 4_000_000_000;
/// Maximum number of tracks: with all their points, 18 MB.
const TRACKS_MAX: usize = 10_000;

/// Returns the trails of the tracks present at `until_ns`, UTC, nanoseconds.
pub(crate) fn trails(world: &World, until_ns: i64) -> Vec<u8> {
    let mut then = Then::default();
    world.history.go_to(&mut then, until_ns);
    let mut octets = seconds(until_ns).to_le_bytes().to_vec();
    let mut points: Vec<[f32; 3]> = Vec::new();
    for (number, state) in then.states.iter().take(TRACKS_MAX) {
        points.clear();
        let mut next_ns = i64::MAX;
        for moment in world.history.back_from(*state) {
            if moment.time_ns < until_ns.saturating_sub(SPAN_NS) {
                break;
            }
            if moment.time_ns <= next_ns {
                next_ns = moment.time_ns.saturating_sub(STEP_NS);
                let age_s = seconds(until_ns.saturating_sub(moment.time_ns)) as f32;
                points.push([age_s, moment.track.east_m, moment.track.north_m]);
            }
        }
        octets.extend(number.to_le_bytes());
        octets.extend((points.len() as u32).to_le_bytes());
        octets.extend(points.iter().flatten().flat_map(|value| value.to_le_bytes()));
    }
    octets
}

#[cfg(test)]
mod tests {
    use messages::{SystemTrack, TrackState};
    use runtime::Now;
    use test_support::S;

    use super::*;

    /// Trails by track: points of age and east.
    fn read(octets: &[u8]) -> Vec<(u32, Vec<(f32, f32)>)> {
        let word = |place: usize| <[u8; 4]>::try_from(&octets[place..place + 4]).unwrap();
        let (mut place, mut tracks) = (8, Vec::new());
        while place < octets.len() {
            let count = u32::from_le_bytes(word(place + 4)) as usize;
            let point = |k: usize| {
                let at = place + 8 + 12 * k;
                (f32::from_le_bytes(word(at)), f32::from_le_bytes(word(at + 4)))
            };
            tracks.push((u32::from_le_bytes(word(place)), (0..count).map(point).collect()));
            place += 8 + 12 * count;
        }
        tracks
    }

    #[test]
    fn trails_end_at_the_shown_moment_and_have_bounded_length_and_density() {
        let begin_ns = 1_700_000_000 * S;
        let mut world = World::new("test", Vec::new(), 3_600, 100_000_000);
        for second in 0..1_000 {
            let now = Now {
                mono_ns: second * S,
                utc_ns: begin_ns + second * S,
            };
            let state = |number: u32, state: TrackState| SystemTrack {
                track_number: number,
                reference_time_ns: now.utc_ns,
                position_m: [second as f64, 0.0, 0.0],
                state: state as u8,
                ..SystemTrack::default()
            };
            let other = match second {
                500..900 => vec![state(2, TrackState::Confirmed)],
                900 => vec![state(2, TrackState::Terminated)],
                _ => Vec::new(),
            };
            world.receive(
                &messages::BatchHeader::default(),
                &[state(1, TrackState::Confirmed)],
                now,
            );
            world.receive(&messages::BatchHeader::default(), &other, now);
        }
        let at = |second: i64| read(&trails(&world, begin_ns + second * S));
        let all = at(999);
        assert_eq!(all.len(), 1, "track 2 has ended");
        assert_eq!(all[0].1.len(), 151);
        assert_eq!((all[0].1[0], all[0].1[150]), ((0.0, 999.0), (600.0, 399.0)));
        let then = at(510);
        assert_eq!(then[1], (2, vec![(0.0, 510.0), (4.0, 506.0), (8.0, 502.0)]));
        assert_eq!(then[0].1[0], (0.0, 510.0));
        assert!(at(-10).is_empty());
    }
}
