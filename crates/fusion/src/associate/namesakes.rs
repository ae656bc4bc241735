//! Namesakes: system tracks with the rare name of a sensor track (module [`identity`](crate::associate::identity)).
//!
//! The gates of place compare two tracks as if their sources had no bias. For namesakes the possible bias between the
//! two sources is added to the variances: then the join gate lies at the reach.

use messages::{NS_PER_S, sensor_track_bits};
use source_models::gaussian_of;

use crate::associate::association_step::Search;
use crate::associate::identity::{self, DECIDES, Name};
use crate::settings::SourceSet;
use crate::tables::sensor_tracks::{NO_SYSTEM, SensorEntry, SensorSlot};
use crate::tables::system_tracks::{Bond, SystemSlot};

/// Distance within which two tracks with the same name are rivals, in reaches.
const RIVALS: f64 = 4.0;
/// Unpredictable acceleration between two reports, metres per second squared.
const ACCELERATION_MPS2: f64 = 5.0;

impl Search<'_> {
    /// System track indicated by a rare name of the sensor track and all other evidence, with d².
    pub(crate) fn namesake(&self, own: SensorSlot) -> Option<(SystemSlot, f64)> {
        let entry = self.tracks.sensors.get(own);
        let mut best: Option<(f64, SystemSlot)> = None;
        self.visit_namesakes(own, false, |member| {
            let system = self.tracks.sensors.get(member).system;
            if !self.can_be_seen_together(&entry.latest, system) {
                return;
            }
            if let Some(d2) = self.namesake_distance(own, member)
                && best.is_none_or(|(least, slot)| (d2, system) < (least, slot))
            {
                best = Some((d2, system));
            }
        });
        best.map(|(d2, system)| (system, d2))
    }

    /// Whether a rare name holds the sensor track in its system track: a member of another source bears the name
    /// within the reach.
    pub(crate) fn is_held(&self, own: SensorSlot) -> bool {
        let mut held = false;
        self.visit_namesakes(own, true, |member| {
            held |= self.namesake_distance(own, member).is_some()
        });
        held
    }

    /// Whether another contributing member of the sensor track's system track has a common name, rare or not.
    pub(crate) fn has_company(&self, own: SensorSlot) -> bool {
        let entry = self.tracks.sensors.get(own);
        let keys = entry.names.keys();
        let shares = |member| {
            let theirs = self.tracks.sensors.get(member).names.keys();
            member != own
                && keys
                    .iter()
                    .zip(theirs)
                    .any(|(mine, theirs)| *mine != 0 && *mine == theirs)
        };
        keys.iter().all(|key| *key == 0) || self.tracks.contributing(entry.system, entry.time_ns).any(shares)
    }

    /// A system track without a common source, with a rare name of a member of `own`, and d².
    pub(crate) fn namesake_of_system(&self, own: SystemSlot, now_ns: i64) -> Option<(SystemSlot, f64)> {
        let sources = self.tracks.sources_of(own, now_ns);
        self.tracks
            .contributing(own, now_ns)
            .find_map(|member| self.namesake(member))
            .filter(|(system, _)| {
                let both = [own, *system].map(|slot| self.tracks.systems.get(slot));
                !self.tracks.sources_of(*system, now_ns).meets(sources)
                    && both.iter().all(|entry| entry.bond == Bond::Free)
                    && !self.are_two_targets(own, *system)
            })
    }

    /// Returns whether a name (a Mode 3/A code is its own [`Name`]) is rare around a place at `now_ns`: no list has
    /// it, and no source has two fresh tracks with it there. Codes are used again far away.
    pub(crate) fn is_rare(&self, name: Name, place_m: [f64; 2], now_ns: i64) -> bool {
        let mut sources = SourceSet::EMPTY;
        let around_m = RIVALS * self.settings.identity.reach_m;
        let Some(carriers) = self.tracks.sensors.names.carriers(name).filter(|_| name != 0) else {
            return false;
        };
        let mut rivals = carriers
            .iter()
            .map(|slot| self.tracks.sensors.get(*slot))
            .filter(|entry| {
                let [x, y, _] = entry.latest.position_m;
                let (east_m, north_m) = (x - place_m[0], y - place_m[1]);
                self.tracks.is_fresh(entry, now_ns) && east_m * east_m + north_m * north_m <= around_m * around_m
            });
        let is_first = |entry: &SensorEntry| {
            let is_first = !sources.contains(entry.source);
            sources.insert(entry.source);
            is_first
        };
        rivals.all(is_first) && !self.is_shared_code(name)
    }

    /// Calls `visit` with fresh sensor tracks of other sources on a system track, with a rare name of `own`, if the
    /// names decide that both can be of the same target. With `here`, these are members of the same system track,
    /// otherwise of others.
    fn visit_namesakes(&self, own: SensorSlot, here: bool, mut visit: impl FnMut(SensorSlot)) {
        let entry = self.tracks.sensors.get(own);
        if !self.settings.association.use_identity {
            return;
        }
        let exponents = &self.settings.association.exponents;
        let place_m = [entry.latest.position_m[0], entry.latest.position_m[1]];
        for (kind, name) in entry.names.keys().into_iter().enumerate() {
            // Most names have no other carrier, or only other members of the same system track.
            let carriers = self.tracks.sensors.names.carriers(name).filter(|_| name != 0);
            let carriers = carriers.filter(|carriers| carriers.len() > 1).unwrap_or_default();
            let mut is_known_rare = false;
            for member in carriers.iter().copied().filter(|member| *member != own) {
                let other = self.tracks.sensors.get(member);
                let is_fresh = self.tracks.is_fresh(other, entry.time_ns);
                let is_here = other.system == entry.system;
                if is_here != here || !is_fresh || other.system == NO_SYSTEM || other.source == entry.source {
                    continue;
                }
                let class = identity::class_ratio(&entry.latest.target_type, &other.latest.target_type);
                let ratio = entry.names.log_ratio(&other.names, kind, exponents) + exponents.class * class;
                if ratio < DECIDES || self.are_different(own, member) {
                    continue;
                }
                is_known_rare = is_known_rare || self.is_rare(name, place_m, entry.time_ns);
                if !is_known_rare {
                    break;
                }
                visit(member);
            }
        }
    }

    fn is_shared_code(&self, name: Name) -> bool {
        let code = u16::try_from(name).ok();
        code.is_some_and(|code| self.settings.identity.is_shared(code))
    }

    /// Whether the addresses of two sensor tracks differ.
    fn are_different(&self, own: SensorSlot, other: SensorSlot) -> bool {
        let number = |slot| self.tracks.sensors.get(slot).latest.identity.unique_number();
        self.settings.association.exponents.address > 0.0
            && matches!((number(own), number(other)), (Some(a), Some(b)) if a.excludes(b))
    }

    /// d² of two sensor tracks of two sources with the possible bias between the sources, inside the gates.
    fn namesake_distance(&self, own: SensorSlot, member: SensorSlot) -> Option<f64> {
        let [own, other] = [own, member].map(|slot| &self.tracks.sensors.get(slot).latest);
        let seconds = (own.time_of_measurement_ns - other.time_of_measurement_ns) as f64 / NS_PER_S;
        let theirs = gaussian_of(other).moved(seconds, Default::default());
        let unforeseen_m = 0.5 * ACCELERATION_MPS2 * seconds * seconds;
        let heights = own.has(sensor_track_bits::HEIGHT) && other.has(sensor_track_bits::HEIGHT);
        let reach_m = self.tracks.sources.bias_reach_m(self.settings, own, other);
        let spread_m2 = reach_m * reach_m / self.settings.association.join_gate() + unforeseen_m * unforeseen_m;
        self.compare(&gaussian_of(own), &theirs, heights, spread_m2)
    }
}
