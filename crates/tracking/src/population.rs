//! All tracks, hypotheses and clusters after a scan.
//!
//! Four flat tables: clusters own a range of tracks and a range of hypotheses, a hypothesis owns a range of members,
//! and a member is the place of a track. Each scan writes a whole new population from the population before, in the
//! order of clusters; so nothing is ever moved, freed or fragmented, and the population before late scans is still
//! there ([`crate::Tracker`]).

use std::ops::Range;

use messages::NS_PER_S;

use crate::crossing_memory::CrossingMemory;
use crate::existence::LifeEstimate;
use crate::limits::{DETECTION_COUNTS, HYPOTHESES_MAX};
use crate::sensor::SensorMemory;
use crate::track::Track;
use crate::wide_area::carried::SupportState;

/// Consistent explanation of all detections in a cluster.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hypothesis {
    /// Logarithm; the reliabilities of a cluster sum to 1.
    pub(crate) log_reliability: f64,
    /// Places of the hypothesis's tracks in the table of members.
    pub(crate) members: Range<u32>,
}

/// Tracks that compete for detections.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cluster {
    pub(crate) tracks: Range<u32>,
    /// Most reliable first.
    pub(crate) hypotheses: Range<u32>,
    /// Numbers of detections in the last scans, latest first; fractions after an inheritance from a separated
    /// cluster.
    pub(crate) detections: [f32; DETECTION_COUNTS],
    /// Number of scans counted, at most [`DETECTION_COUNTS`].
    pub(crate) scans: u32,
}

/// The tables.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Population {
    pub(crate) time_ns: i64,
    pub(crate) tracks: Vec<Track>,
    pub(crate) hypotheses: Vec<Hypothesis>,
    pub(crate) members: Vec<u32>,
    pub(crate) clusters: Vec<Cluster>,
    /// By sensor.
    pub(crate) sensors: Vec<SensorMemory>,
    pub(crate) life: LifeEstimate,
    pub(crate) support: SupportState,
    pub(crate) crossings: CrossingMemory,
    /// Serial number of the next detection, of the next track's root, of the next confirmed track.
    pub(crate) next_serial: u32,
    pub(crate) next_root: u32,
    pub(crate) next_number: u32,
}

impl Population {
    pub(crate) fn new(tracks_max: usize, sensors: usize, types: usize) -> Self {
        Self {
            time_ns: i64::MIN,
            tracks: Vec::with_capacity(tracks_max),
            hypotheses: Vec::with_capacity(2 * tracks_max + HYPOTHESES_MAX),
            members: Vec::with_capacity(8 * tracks_max + HYPOTHESES_MAX),
            clusters: Vec::with_capacity(tracks_max),
            sensors: vec![SensorMemory::NONE; sensors],
            life: LifeEstimate::NONE,
            support: SupportState::new(tracks_max, types),
            crossings: CrossingMemory::new(),
            next_serial: 1,
            next_root: 1,
            next_number: 1,
        }
    }

    /// Clears the tables for the successors of `before`.
    pub(crate) fn follow(&mut self, before: &Self, time_ns: i64) {
        self.time_ns = time_ns;
        self.support.follow(&before.support);
        self.crossings.follow(&before.crossings);
        self.tracks.clear();
        self.hypotheses.clear();
        self.members.clear();
        self.clusters.clear();
        self.sensors.copy_from_slice(&before.sensors);
        self.life = before.life;
        self.next_serial = before.next_serial;
        self.next_root = before.next_root;
        self.next_number = before.next_number;
    }

    /// Copies `before`, including the time, for a scan that does not count as a look.
    pub(crate) fn carry_on(&mut self, before: &Self) {
        self.follow(before, before.time_ns);
        self.tracks.extend_from_slice(&before.tracks);
        self.hypotheses.extend_from_slice(&before.hypotheses);
        self.members.extend_from_slice(&before.members);
        self.clusters.extend_from_slice(&before.clusters);
    }

    /// Returns whether a cluster has a confirmed track and another track, branches not counted: each of several targets
    /// may be missed because the sensor does not resolve them.
    pub(crate) fn has_several(&self, cluster: &Cluster) -> bool {
        let tracks = &self.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize];
        let mut numbers = tracks.iter().map(|track| track.number);
        let first = numbers.next();
        numbers.any(|number| Some(number) != first)
    }

    /// Seconds to a later scan; 0 before the first scan.
    pub(crate) fn seconds_until(&self, time_ns: i64) -> f64 {
        match self.time_ns {
            i64::MIN => 0.0,
            before_ns => time_ns.saturating_sub(before_ns).max(0) as f64 / NS_PER_S,
        }
    }

    /// Expected number of targets that confirmed tracks follow.
    pub(crate) fn present(&self) -> f64 {
        let confirmed = self.tracks.iter().filter(|track| track.is_confirmed());
        confirmed.map(Track::presence).sum()
    }

    /// Whether so much fits in.
    pub(crate) fn has_room(&self, tracks: usize, hypotheses: usize, members: usize) -> bool {
        let fits = |used: usize, more: usize, room: usize| used + more <= room;
        fits(self.tracks.len(), tracks, self.tracks.capacity())
            && fits(self.hypotheses.len(), hypotheses, self.hypotheses.capacity())
            && fits(self.members.len(), members, self.members.capacity())
            && fits(self.clusters.len(), 1, self.clusters.capacity())
    }

    /// Adds a cluster of a track that is certain. There must be room.
    pub(crate) fn add_certain(&mut self, track: Track) {
        let [place, hypothesis, member] =
            [self.tracks.len(), self.hypotheses.len(), self.members.len()].map(|count| count as u32);
        self.tracks.push(track);
        self.members.push(place);
        self.hypotheses.push(Hypothesis {
            log_reliability: 0.0,
            members: member..member + 1,
        });
        self.clusters.push(Cluster {
            tracks: place..place + 1,
            hypotheses: hypothesis..hypothesis + 1,
            detections: [0.0; DETECTION_COUNTS],
            scans: 0,
        });
    }

    /// Adds a cluster of a track that may be false, and uses up a root. `false` without room.
    pub(crate) fn add_tentative(&mut self, track: Track) -> bool {
        if !self.has_room(1, 2, 1) {
            return false;
        }
        let reliability = track.reliability;
        self.next_root = self.next_root.wrapping_add(1).max(1);
        let (place, hypothesis, member) = (
            self.tracks.len() as u32,
            self.hypotheses.len() as u32,
            self.members.len() as u32,
        );
        self.tracks.push(track);
        self.members.push(place);
        let mut both = [
            ((1.0 - reliability).ln(), member..member),
            (reliability.ln(), member..member + 1),
        ];
        if reliability > 0.5 {
            both.swap(0, 1);
        }
        self.hypotheses
            .extend(both.into_iter().map(|(log_reliability, members)| Hypothesis {
                log_reliability,
                members,
            }));
        let mut detections = [0.0; DETECTION_COUNTS];
        detections[0] = 1.0;
        self.clusters.push(Cluster {
            tracks: place..place + 1,
            hypotheses: hypothesis..hypothesis + 2,
            detections,
            scans: 1,
        });
        true
    }

    pub(crate) fn members_of(&self, hypothesis: &Hypothesis) -> &[u32] {
        &self.members[hypothesis.members.start as usize..hypothesis.members.end as usize]
    }
}
