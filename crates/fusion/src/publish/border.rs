//! Borders: owners of targets, if centres have regions.
//!
//! Each centre has regions of the ground, polygons. The centre of the region with a target owns the target. A target in
//! flight along a border must not change its owner at every turn: the handover follows after some time beyond the
//! border, by some distance. Both centres decide by their own track pictures, which are nearly equal.
//!
//! A target keeps its number at each centre, independent of its owner; a track owned by another centre contains the
//! target's number there. Near the border, both numbers are therefore known on both sides. A silent owner gives no
//! number: the track is then owned locally until the owner returns.
//!
//! Other centres receive the targets in a strip along the border: targets in the region of another centre, or nearer
//! to the region than the width of the strip.

use messages::SystemTrack;
use serde::{Deserialize, Serialize};

use crate::settings::BorderSettings;
use crate::settings::region::Region;

/// Centre that owns a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ownership {
    /// `origin` of the owning centre, if another; else 0.
    other: u32,
    /// Number of the track at the owning centre; 0 while that centre does not contribute.
    number: u32,
    /// Whether ownership was ever decided.
    is_known: bool,
    /// Time since when the target has been in a region of a centre other than the owner, ns.
    since_ns: Option<i64>,
}

impl Ownership {
    /// Decides by the place of the target at `now_ns`, east and north, metres.
    pub(crate) fn look(&mut self, settings: &BorderSettings, place: [f64; 2], now_ns: i64) {
        // A silent owner owns nothing that other centres could request: a new report of the owner is required.
        self.number = 0;
        let here = settings.regions.iter().find(|region| region.contains(place));
        let Some(here) = here.filter(|region| !self.is_known || self.other != other(region)) else {
            self.since_ns = None;
            return;
        };
        let mut owned = settings.regions.iter().filter(|region| other(region) == self.other);
        let is_far = !owned.any(|region| region.distance_m(place) < settings.hand_over_m);
        if !is_far && self.is_known {
            self.since_ns = None;
            return;
        }
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        if !self.is_known || now_ns - since_ns >= settings.hand_over_s.ns() {
            *self = Self {
                other: other(here),
                is_known: true,
                ..Self::default()
            };
        }
    }

    /// Stores the target's number at another centre.
    pub(crate) fn hear(&mut self, origin: u32, number: u32) {
        if self.other == origin && origin != 0 {
            self.number = number;
        }
    }

    /// Writes the owner of the target.
    pub(crate) fn write(&self, message: &mut SystemTrack) {
        message.owner_track_number = if self.other == 0 { 0 } else { self.number };
    }
}

/// Origin of a region of another centre; 0 for an own region.
fn other(region: &Region) -> u32 {
    if region.is_own { 0 } else { region.origin }
}

#[cfg(test)]
mod tests {
    use settings::Seconds;

    use super::*;

    /// East of 0 is the other centre's region, a rectangle as configured in the west.
    fn settings() -> BorderSettings {
        let region = |origin, is_own, east: [f64; 2]| Region {
            origin,
            is_own,
            corners_m: vec![[east[0], -1e5], [east[1], -1e5], [east[1], 1e5], [east[0], 1e5]],
        };
        BorderSettings {
            regions: vec![region(1, true, [-1e5, 0.0]), region(2, false, [0.0, 1e5])],
            strip_m: 20e3,
            hand_over_m: 500.0,
            hand_over_s: Seconds::of(10.0),
        }
    }

    #[test]
    fn a_target_changes_hands_once_when_it_has_gone_over() {
        let settings = settings();
        let mut owner = Ownership::default();
        let mut changes = Vec::new();
        for second in 0..200i64 {
            // Along the border first, on both sides, then across.
            let east_m = if second < 100 {
                400.0 * (second as f64).sin()
            } else {
                100.0 * (second - 100) as f64
            };
            let before = owner;
            owner.look(&settings, [east_m - 300.0, 0.0], second * 1_000_000_000);
            owner.hear(2, 77);
            owner.hear(3, 99);
            if (before.other, before.is_known) != (owner.other, owner.is_known) {
                changes.push((second, owner.other));
            }
        }
        // 500 m beyond at 108 s, and 10 s more.
        assert_eq!(changes, [(0, 0), (118, 2)]);
        let mut message = SystemTrack::default();
        owner.write(&mut message);
        assert_eq!(message.owner_track_number, 77);
    }

    #[test]
    fn regions_that_nearly_meet_leave_a_gap() {
        for (east_m, expected) in [(0.0, 0), (0.5, 0), (300.0, 2), (30e3, 0)] {
            let mut settings = settings();
            for corner in &mut settings.regions[1].corners_m {
                corner[0] += east_m;
            }
            let gaps = settings.gaps();
            assert_eq!(gaps.len(), expected, "{gaps:?}");
            assert!(gaps.iter().all(|gap| (gap.width_m - east_m).abs() < 1e-6), "{gaps:?}");
        }
    }

    #[test]
    fn others_are_told_of_targets_in_the_strip() {
        let mut settings = settings();
        let told = [-50e3, -20_001.0, -19_999.0, 30e3].map(|east_m| settings.is_in_strip([east_m, 0.0]));
        assert_eq!(told, [false, false, true, true]);
        settings.regions.clear();
        assert!(settings.is_in_strip([-50e3, 0.0]), "without regions, of all");
    }
}
