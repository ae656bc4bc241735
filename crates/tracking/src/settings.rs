//! The tracker's settings.
//!
//! Only [`SensorFacts`] describe the world; everything else is the tracker's and is meant to be the same for all
//! sensors and scenes. Densities are those of a single scan. The settings of a part stand beside it.

use std::collections::BTreeSet;

use settings::{KeyValue, Node, Place, Range, SettingsError};

use crate::field_of_view::FieldOfView;
use crate::identity::IdentitySettings;
use crate::initiation::Initiation;
pub use crate::initiation::Starts;
pub use crate::life::{Confirmation, Deletion, DeletionSettings};
use crate::limits::{CLUSTER_TRACKS_MAX, HISTORY_MAX, HYPOTHESES_MAX, OPEN_SCANS_MAX};
pub use crate::motion::{ManoeuvreSettings, MotionSettings};
use crate::resolution_cell::ResolutionCell;
use crate::selection::Selection;
pub use crate::turn::TurnSettings;
use crate::wide_area::settings::SupportSettings;

/// Tracks, and detections in a scan, for which there is room where nobody says more.
const ROOM: usize = 16_384;
/// Most tracks, and most detections in a scan, for which there can be room.
pub const ROOM_MAX: usize = 1 << 20;

settings::settings! {
    /// The tracker and its sensors, for aircraft and vessels seen by any sensors.
    pub struct Settings {
        check Settings::check;
        /// Sensors with known facts; offline, other sensors have default settings.
        sensors as "sensor": Vec<SensorFacts> = Vec::new();
        /// Where tracks start: at detections of every sensor, or only at those of sensors that designate targets
        /// (`designates`).
        starts: Starts = Starts::Any;
        /// Gates around predicted measurements.
        gate: Gate = Gate::default();
        /// Models of motion (HT-13).
        motion: MotionSettings = MotionSettings::default();
        /// Assumptions on a target before its first observation.
        initiation: Initiation = Initiation::default();
        /// Confirmation of tracks (HT-10).
        confirmation: Confirmation = Confirmation::default();
        /// Deletion of tracks (HT-10).
        deletion: DeletionSettings = DeletionSettings::default();
        /// Selection of the hypotheses to keep (HT-9).
        reduction: Reduction = Reduction::default();
        /// Assumptions on targets that split (SP-1 … SP-7).
        splitting: Splitting = Splitting::default();
        /// What transponders' replies say about the track of a detection.
        identity: IdentitySettings = IdentitySettings::default();
        /// Detections that are not used (WA-1).
        selection: Selection = Selection::default();
        /// Use of a wide-area sensor's reports (WA).
        wide_area: SupportSettings = SupportSettings::default();
        /// Sizes of the tables.
        capacity: TrackerCapacity = TrackerCapacity::default();
    }

    /// Facts about a sensor.
    pub struct SensorFacts with model: SensorModel {
        check SensorFacts::check;
        /// Number of the sensor in detections.
        sensor_id as "id": u32;
        /// Standard deviations for detections without their own, of the measured quantities in order: 1 to 3 values.
        sigmas: Option<Vec<f64>> = None, in [1e-9, 1e6];
        /// Standard deviation of range rates of detections that state none; needs `sigmas` beside it.
        range_rate_sigma_mps: Option<f64> = None, in [1e-9, 1e6];
        /// Priority: of scans at the same time (`selection.same_time_s`), only scans of the sensor with the highest
        /// priority are used.
        priority: u32 = 0;
    }

    /// Model of what a sensor detects.
    #[derive(Copy)]
    pub struct SensorModel {
        /// Probability that a target in the field of view is detected in a scan. Without the key, 0.9 at first, and
        /// then learned from confirmed tracks, at most 0.9.
        detection_probability: Option<f64> = None, in [0.01, 0.9999], usually "learned";
        /// Expected false detections per scan: per m² for a sensor of positions or ranges, per radian of bearing for
        /// a sensor of directions only. Without the key, learned from detections outside the gates of confirmed
        /// tracks.
        clutter_density: Option<f64> = None, in [1e-30, 1e6], usually "learned";
        /// Region with detections of targets. Targets outside the region are not missed.
        field_of_view: Option<FieldOfView> = None, usually "everywhere";
        /// Set for a source of designations: each of its detections is a target to follow, and has a confirmed track at
        /// once unless a confirmed track is there.
        designates: bool = false;
        /// Smallest distance between detections of different targets in a scan; without the key, a target gives at
        /// most one detection.
        resolution_m: Option<f64> = None, in [1e-3, 1e5];
        /// Two targets that differ by less in range and bearing give one detection between them.
        resolution_cell: Option<ResolutionCell> = None, usually "targets are resolved";
    }

    /// Gates around predicted measurements (HT-2).
    #[derive(Copy)]
    pub struct Gate {
        /// Probability that a target's detection lies in its gate.
        probability: f64 = 0.99, in [0.5, 0.999_999];
    }

    /// Selection of the hypotheses to keep (HT-9): merging, threshold and number, in this order.
    #[derive(Copy)]
    pub struct Reduction {
        /// Number of scans with equal associations after which hypotheses are merged; 0: only hypotheses with the
        /// same tracks.
        merge_scans: usize = 2, in [0, HISTORY_MAX];
        /// Least reliability of a hypothesis; less reliable hypotheses are dropped.
        reliability_min: f64 = 1e-3, in [0, 0.49];
        /// Clusters are joined if both have the same detection with at least this probability; 0: every detection in
        /// gates of both joins them (HT-4).
        join_probability_min: f64 = 0.02, in [0, 1];
        /// Most tracks of joined clusters that every detection in gates of both joins, if they have few detections,
        /// too.
        join_tracks: usize = 64, in [0, CLUSTER_TRACKS_MAX];
        /// Most detections of joined clusters that every detection in gates of both joins, if they have few tracks,
        /// too.
        join_detections: usize = 16, in [0, 64];
        /// Most hypotheses that are kept per cluster.
        hypotheses_max: usize = 30, in [1, HYPOTHESES_MAX];
    }

    /// Assumptions on targets that split, each off or on (SP-1 … SP-7).
    #[derive(Copy)]
    pub struct Splitting {
        /// Expected new targets per expected false detection in the gates of confirmed tracks; off: the value of
        /// `[initiation]`.
        new_target_share: Option<f64> = Some(3.0), in [1e-6, 1e3];
        /// Most targets that are expected to leave a confirmed track in a scan: where false detections are dense, new
        /// targets in gates are rarer than `new_target_share`; off: they are not. Needs `departed_s` and
        /// `parents_motion`.
        leaving_max: Option<f64> = Some(0.1), in [1e-6, 1e3];
        /// In a cluster with a confirmed track, new tracks start only in the gate of a confirmed track (SP-1).
        start_in_confirmed_gates: bool = false;
        /// Least reliability of a single branch with half of its detections in confirmed tracks' gates, for its
        /// confirmation; off: only `[confirmation]`.
        reliability_min: Option<f64> = Some(0.95), in [0.501, 1];
        /// The same from the third detection of the branch on, if it is less; off: `reliability_min`.
        third_reliability_min: Option<f64> = Some(0.9), in [0.501, 1];
        /// Time since which a target may have left a confirmed track without a detection of its own: where it may have
        /// come since then, new tracks start as in the gate of that track. Needs `parents_motion`; off: in gates only.
        departed_s: Option<f64> = Some(10.0), in [0, 1e3];
        /// Number of the confirmed track's best branches whose motion new tracks start with (SP-2).
        parents_motion: Option<usize> = Some(4), in [1, CLUSTER_TRACKS_MAX];
        /// Most new tracks per interpretation (SP-3, SP-4).
        new_tracks_max: Limit = Limit::Off;
        /// Hypotheses with as many tentative tracks or more are dropped (SP-5, SP-6).
        tentative_tracks: Limit = Limit::Off;
        /// Least share of a tentative track's detections in confirmed tracks' gates (SP-7).
        company_min: Option<f64> = None, in [0, 1];
    }

    /// Sizes of the tables, all allocated at the start.
    #[derive(Copy)]
    pub struct TrackerCapacity {
        /// Largest number of tracks, with all branches.
        tracks: Option<usize> = None, in [1, ROOM_MAX], usually "16384; offline more if a scan needs it";
        /// Most detections in a scan.
        detections: Option<usize> = None, in [1, ROOM_MAX], usually "16384; offline more if a scan needs it";
        /// Number of scans that stay open for late, earlier scans (HT-12); with sensors of different priority, at least
        /// the number of sensors, since scans of the same time are compared while they are open (WA-1).
        open_scans: usize = 0, in [0, OPEN_SCANS_MAX];
    }
}

/// A limit that may be computed from how many detections came lately (SP-4, SP-6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Limit {
    /// None.
    #[default]
    Off,
    /// This number.
    Fixed(usize),
    /// Mean number of the cluster's detections over the last [`DETECTION_COUNTS`](crate::DETECTION_COUNTS) scans less
    /// the number of its confirmed tracks, not below 0; for SP-6, one more.
    Computed,
}

impl KeyValue for Limit {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        *self = match node.get_ref().as_str() {
            Some("off") => Self::Off,
            Some("computed") => Self::Computed,
            Some(other) => return Err(at.error(settings::not_known(other, &["off", "computed", "a whole number"]))),
            None => {
                let mut number = 0;
                KeyValue::read(&mut number, node, range, at)?;
                Self::Fixed(number)
            }
        };
        Ok(())
    }

    fn check(&self, _: Range, _: &Place<'_>) -> Result<(), SettingsError> {
        Ok(())
    }

    fn kind(&self) -> String {
        "whole number, \"computed\" or \"off\"".to_owned()
    }

    fn text(&self) -> String {
        match self {
            Self::Off => "\"off\"".to_owned(),
            Self::Fixed(number) => number.to_string(),
            Self::Computed => "\"computed\"".to_owned(),
        }
    }
}

impl Settings {
    /// Number of scans that stay open beside the latest one.
    pub(crate) fn open_scans(&self) -> usize {
        let mut priorities = self.sensors.iter().map(|sensor| sensor.priority);
        let first = priorities.next().unwrap_or_default();
        let compared = match priorities.all(|priority| priority == first) {
            true => 0,
            false => self.sensors.len().min(OPEN_SCANS_MAX),
        };
        self.capacity.open_scans.max(compared)
    }

    /// No two sensors have one number; tracks can start.
    fn check(&self) -> Result<(), SettingsError> {
        // The sensors of a tracker process are named beside its settings: without any, this is checked later.
        let lacks_designator = !self.sensors.is_empty() && !self.sensors.iter().any(|sensor| sensor.model.designates);
        if self.starts == Starts::Designated && lacks_designator {
            let what = "needs a sensor with designates = true, whose detections are the targets to follow";
            return Err(SettingsError::new("starts", what));
        }
        let mut known = BTreeSet::new();
        let mut sensors = self.sensors.iter().map(|sensor| sensor.sensor_id).enumerate();
        sensors
            .find(|(_, sensor_id)| !known.insert(*sensor_id))
            .map_or(Ok(()), |(index, sensor_id)| {
                let what = format!("{sensor_id} is the id of an earlier sensor; move its keys there");
                Err(SettingsError::new(format!("sensor[{index}].id"), what))
            })
    }
}

impl SensorFacts {
    fn check(&self) -> Result<(), SettingsError> {
        match &self.sigmas {
            None if self.range_rate_sigma_mps.is_some() => {
                Err(SettingsError::new("range_rate_sigma_mps", "needs sigmas beside it"))
            }
            Some(given) if !(1..=3).contains(&given.len()) => {
                let what = format!(
                    "{} values; give one for each quantity that the sensor measures, 1 to 3, in their order",
                    given.len()
                );
                Err(SettingsError::new("sigmas", what))
            }
            _ => Ok(()),
        }
    }

    /// Standard deviations of detections that state none, in the order of their quantities, and then of the range rate;
    /// `None` if none are known. One that is not known is NaN, and makes its detection unusable, as it should.
    pub fn default_sigmas(&self) -> Option<[f64; 4]> {
        let given = self.sigmas.as_ref()?;
        let mut sigmas = [f64::NAN; 4];
        sigmas.iter_mut().zip(given).for_each(|(sigma, given)| *sigma = *given);
        sigmas[3] = self.range_rate_sigma_mps.unwrap_or(f64::NAN);
        Some(sigmas)
    }
}

impl TrackerCapacity {
    /// Most tracks.
    pub fn tracks(&self) -> usize {
        self.tracks.unwrap_or(ROOM)
    }

    /// Most detections in a scan.
    pub fn detections(&self) -> usize {
        self.detections.unwrap_or(ROOM)
    }
}
