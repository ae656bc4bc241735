//! Latest states of the system tracks, and their rows for people.

use std::collections::BTreeMap;

use frames::SystemFrame;
use messages::{Contribution, SystemTrack, TrackState, contribution_bits};
use serde::Serialize;

/// One hour, nanoseconds: older data come from a recording.
const RECORDING_NS: i64 = 3_600_000_000_000;

/// Latest state of each system track that lives.
#[derive(Clone, Debug)]
pub(crate) struct LatestStates {
    capacity: usize,
    tracks: BTreeMap<u32, SystemTrack>,
}

impl LatestStates {
    /// No states, and room for the states of `capacity` tracks.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            capacity,
            tracks: BTreeMap::new(),
        }
    }

    /// Removes all states: another fusion process publishes a new picture.
    pub(crate) fn clear(&mut self) {
        self.tracks.clear();
    }

    /// Keeps a received state.
    pub(crate) fn keep(&mut self, track: &SystemTrack) {
        if TrackState::is_off(track.state) {
            self.tracks.remove(&track.track_number);
        } else if self.tracks.len() < self.capacity || self.tracks.contains_key(&track.track_number) {
            self.tracks.insert(track.track_number, *track);
        }
    }

    /// The states, in the order of the track numbers.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &SystemTrack> {
        self.tracks.values()
    }

    /// Rows for people; `frame` is the system frame, if known. Ages count to `utc_ns`, and in a recording to the latest
    /// of the states.
    pub(crate) fn rows(&self, frame: Option<&SystemFrame>, utc_ns: i64) -> Vec<TrackRow> {
        let latest_ns = self.iter().map(|track| track.reference_time_ns).max().unwrap_or(utc_ns);
        let is_recording = utc_ns.saturating_sub(latest_ns) > RECORDING_NS;
        let now_ns = if is_recording { latest_ns } else { utc_ns };
        self.iter().map(|track| TrackRow::new(track, frame, now_ns)).collect()
    }
}

/// A system track.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct TrackRow {
    pub(crate) number: u32,
    /// Call sign or name, else address, MMSI or Mode 3/A code; empty if nothing is known.
    pub(crate) identity: String,
    pub(crate) state: &'static str,
    /// Degrees; `None` until the system frame is known.
    pub(crate) latitude_deg: Option<f64>,
    pub(crate) longitude_deg: Option<f64>,
    /// Hundreds of feet; `None` if no source observes height.
    pub(crate) flight_level: Option<f64>,
    /// Over the ground, metres per second.
    pub(crate) speed_mps: Option<f64>,
    /// Numbers of the contributing sources, as in files from 1.
    pub(crate) sources: Vec<u32>,
    /// Contributing sources that are other centres, and former contributing centres that have fallen silent.
    pub(crate) centres: Vec<u32>,
    pub(crate) silent_centres: Vec<u32>,
    /// Time since the latest report that contributes, seconds; `None` if none does.
    pub(crate) age_s: Option<f64>,
}

impl TrackRow {
    fn new(track: &SystemTrack, frame: Option<&SystemFrame>, now_ns: i64) -> Self {
        let place = frame.map(|frame| frame.to_geodetic(track.position_m));
        let [east, north, _] = track.velocity_mps;
        let parts = track.contributions();
        let latest_ns = parts.iter().map(|part| part.time_of_measurement_ns).max();
        // In files, sources count from 1.
        let number = |part: &Contribution| u32::from(part.source) + 1;
        let centres = parts.iter().filter(|part| part.flags & contribution_bits::CENTRE != 0);
        Self {
            number: track.track_number,
            identity: identity(track),
            state: TrackState::from_code(track.state).map_or("", TrackState::word),
            latitude_deg: place.map(|place| place.latitude_deg()),
            longitude_deg: place.map(|place| place.longitude_deg()),
            flight_level: place
                .filter(|_| track.height_valid == 1)
                .map(|place| place.flight_level()),
            speed_mps: (track.velocity_valid == 1).then(|| east.hypot(north)),
            sources: parts.iter().map(number).collect(),
            centres: centres.map(number).collect(),
            silent_centres: track.listed()[parts.len()..].iter().map(number).collect(),
            age_s: latest_ns.map(|latest_ns| frames::time::seconds(now_ns.saturating_sub(latest_ns))),
        }
    }
}

fn identity(track: &SystemTrack) -> String {
    let identity = &track.identity;
    let name = identity.callsign().or(identity.name()).map(str::to_owned);
    let address = || identity.address_text().map(|address| address.to_string());
    let mmsi = || identity.mmsi_text().map(|mmsi| mmsi.to_string());
    let code = || identity.mode_3a_text().map(|code| format!("A{code}"));
    name.or_else(address).or_else(mmsi).or_else(code).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;
    use messages::Identity;
    use test_support::S;

    use super::*;

    fn track(number: u32, state: TrackState) -> SystemTrack {
        SystemTrack {
            track_number: number,
            state: state as u8,
            ..SystemTrack::default()
        }
    }

    #[test]
    fn a_restarted_fusion_begins_a_new_picture_and_ended_tracks_are_gone() {
        let mut states = LatestStates::new(2);
        states.keep(&track(1, TrackState::Confirmed));
        states.clear();
        for number in [2, 4, 6, 4] {
            states.keep(&track(number, TrackState::Confirmed));
        }
        let numbers = |states: &LatestStates| states.iter().map(|track| track.track_number).collect::<Vec<_>>();
        assert_eq!(numbers(&states), [2, 4], "no room for a third");
        states.keep(&track(2, TrackState::Terminated));
        assert_eq!(numbers(&states), [4]);
        states.keep(&track(4, TrackState::Suspended));
        assert_eq!(numbers(&states), [0; 0]);
    }

    #[test]
    fn rows_say_where_a_target_is_in_the_worlds_terms() {
        let origin = Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap();
        let mut state = SystemTrack {
            position_m: [0.0, 0.0, 3048.0],
            velocity_mps: [3.0, 4.0, 9.0],
            height_valid: 1,
            velocity_valid: 1,
            identity: Identity::default().with_address(0x3444cf).with_callsign(*b"VLG20M  "),
            contribution_count: 3,
            reference_time_ns: 100 * S,
            ..track(7, TrackState::Coasted)
        };
        let (centre, fresh) = (contribution_bits::CENTRE, contribution_bits::FRESH);
        for (index, (time_s, flags)) in [(98, fresh), (97, centre | fresh), (95, centre)]
            .into_iter()
            .enumerate()
        {
            state.contributions[index] = Contribution {
                source: index as u16,
                time_of_measurement_ns: time_s * S,
                flags,
                ..Contribution::default()
            };
        }
        let mut states = LatestStates::new(9);
        states.keep(&state);
        let row = |utc_ns| states.rows(Some(&SystemFrame::at(origin)), utc_ns).remove(0);
        let at_once = row(101 * S);
        assert_eq!((at_once.identity.as_str(), at_once.state), ("VLG20M", "coasted"));
        let near = |value: Option<f64>, expected: f64| (value.unwrap() - expected).abs() < 1e-6;
        assert!(
            near(at_once.latitude_deg, 41.3) && near(at_once.longitude_deg, 2.1),
            "{at_once:?}"
        );
        assert!(
            near(at_once.flight_level, 100.0) && at_once.speed_mps == Some(5.0),
            "{at_once:?}"
        );
        assert_eq!((at_once.sources, at_once.age_s), (vec![1, 2], Some(3.0)));
        assert_eq!((at_once.centres, at_once.silent_centres), (vec![2], vec![3]));
        assert_eq!(row(9_000 * S).age_s, Some(2.0), "a recording: to its latest state");
        let unknown = &states.rows(None, 101 * S)[0];
        assert_eq!((unknown.latitude_deg, unknown.flight_level), (None, None));
    }

    #[test]
    fn the_best_identity_is_shown() {
        let none = Identity::default();
        for (known, shown) in [
            (none, ""),
            (none.with_mode_3a(0o7000), "A7000"),
            (none.with_mode_3a(0o7000).with_address(0xabc), "000ABC"),
            (none.with_mmsi(211_000_001), "211000001"),
            (none.with_mmsi(2_275_400), "002275400"),
            (none.with_mmsi(211_000_001).with_name("ANNA"), "ANNA"),
        ] {
            let track = SystemTrack {
                identity: known,
                ..SystemTrack::default()
            };
            assert_eq!(identity(&track), shown);
        }
    }
}
