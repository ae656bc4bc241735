//! What the tracker is told beforehand.
//!
//! Only [`SensorSettings`] describe the world; everything else is the tracker's and is meant to be the same for all
//! sensors and scenes. Values are in SI units; densities are those of a single scan.

use crate::field_of_view::FieldOfView;
use crate::initiation::FirstGuess;
pub use crate::life::{Confirmation, Deletion};
use crate::limits::{HISTORY_MAX, HYPOTHESES_MAX};
pub use crate::motion::{Manoeuvres, MotionSettings};
use crate::selection::Selection;
pub use crate::turn::Turn;
use crate::wide_area::settings::WideArea;

/// Everything.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The sensors; detections of others are refused.
    pub sensors: Vec<SensorSettings>,
    /// Probability that a target's detection lies in its gate (HT-2).
    pub gate_probability: f64,
    /// How long a sensor that looks again sees the same: whether it detects a target, and by how much it is wrong, seconds.
    pub coherence_s: f64,
    /// How targets move (HT-13).
    pub motion: MotionSettings,
    /// What is assumed of a target before it was observed.
    pub first_guess: FirstGuess,
    /// Expected new targets per expected false detection (HT-8).
    pub new_target_share: f64,
    /// Which hypotheses are kept (HT-9).
    pub reduction: Reduction,
    /// When a track is believed (HT-10).
    pub confirmation: Confirmation,
    /// When a track is given up (HT-10).
    pub deletion: Deletion,
    /// What is assumed of targets that split (SP-1 … SP-7).
    pub splitting: Splitting,
    /// Which detections are used (WA-1).
    pub selection: Selection,
    /// How reports of a wide-area sensor are used (WA).
    pub wide_area: WideArea,
    /// Sizes of the tables.
    pub capacity: Capacity,
}

/// What an operator knows of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorSettings {
    /// As detections name it.
    pub sensor_id: u32,
    /// Probability that a target in the field of view is detected in a scan.
    pub detection_probability: f64,
    /// How many false detections there are.
    pub clutter: Clutter,
    /// Standard deviations of detections that state none: of the measured quantities in their order, then of the range
    /// rate.
    pub sigmas: Option<[f64; 4]>,
    /// Where it sees targets (`None`: wherever they are). What is missing outside was not missed.
    pub field_of_view: Option<FieldOfView>,
    /// Detections of a scan nearer to each other than this are of one target, metres (`None`: a target gives only one).
    pub resolution_m: Option<f64>,
}

impl Default for SensorSettings {
    /// Sensor 0: nine of ten targets are detected, anywhere, once each; the density of false detections is learned.
    fn default() -> Self {
        Self {
            sensor_id: 0,
            detection_probability: 0.9,
            clutter: Clutter::Learned,
            sigmas: None,
            field_of_view: None,
            resolution_m: None,
        }
    }
}

/// Expected false detections per scan: per square metre of the plane where the sensor measures positions or ranges, per
/// radian of bearing where it measures directions only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clutter {
    /// Known.
    Density(f64),
    /// Learned while running, from detections outside the gates of confirmed tracks.
    Learned,
}

/// HT-9. All are applied, in this order: merging, threshold, number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Hypotheses are merged whose associations over so many scans are the same, at most [`HISTORY_MAX`]; 0: only those
    /// that consist of the same tracks.
    pub merge_scans: usize,
    /// Hypotheses less reliable are dropped.
    pub reliability_min: f64,
    /// At most so many are kept per cluster, at most [`HYPOTHESES_MAX`].
    pub hypotheses_max: usize,
}

/// SP-1 … SP-7: each off or on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Splitting {
    /// Expected new targets per expected false detection in the gates of confirmed tracks (`None`: as elsewhere).
    pub new_target_share: Option<f64>,
    /// SP-1: in a cluster that has a confirmed track, new tracks start only in the gate of one.
    pub start_in_confirmed_gates: bool,
    /// SP-2: they start with the motion of the best so many branches of that track.
    pub parents_motion: Option<usize>,
    /// SP-3, SP-4: most new tracks per interpretation.
    pub new_tracks_max: Limit,
    /// SP-5, SP-6: hypotheses with as many tentative tracks or more are dropped.
    pub tentative_tracks: Limit,
    /// SP-7: smallest share of a tentative track's detections in confirmed tracks' gates.
    pub company_min: Option<f64>,
}

/// A limit that may be computed from how many detections came lately (SP-4, SP-6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Limit {
    /// None.
    #[default]
    Off,
    /// This number.
    Fixed(usize),
    /// Mean number of the cluster's detections over the last [`DETECTION_COUNTS`](crate::DETECTION_COUNTS) scans less the
    /// number of its confirmed tracks, not below 0; for SP-6, one more.
    Computed,
}

/// Sizes of the tables, all allocated at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Most tracks, with all their branches.
    pub tracks: usize,
    /// Most detections in a scan.
    pub detections: usize,
    /// How many scans stay open for late ones to come before them (HT-12).
    pub open_scans: usize,
}

impl Default for Settings {
    /// For aircraft and vessels seen by any sensors; without sensors.
    fn default() -> Self {
        Self {
            sensors: Vec::new(),
            gate_probability: 0.99,
            coherence_s: 1.0,
            motion: MotionSettings {
                process_noise_m2ps3: [5.0, 1.0],
                manoeuvres: Some(Manoeuvres {
                    process_noise_m2ps3: [100.0, 10.0],
                    durations_s: [60.0, 10.0],
                    turn: None,
                }),
            },
            first_guess: FirstGuess {
                speed_sigma_mps: 100.0,
                slow_sigma_mps: Some(10.0),
                climb_sigma_mps: 10.0,
                height_sigma_m: 5000.0,
            },
            new_target_share: 0.04,
            reduction: Reduction {
                merge_scans: 2,
                reliability_min: 1e-3,
                hypotheses_max: 30,
            },
            confirmation: Confirmation {
                reliability_min: 0.99,
                detections_min: 2,
                log_likelihood_ratio_min: None,
            },
            deletion: Deletion {
                missed_probability: 2e-5,
                silent_ns: 60_000_000_000,
            },
            splitting: Splitting {
                new_target_share: Some(1.0),
                parents_motion: Some(4),
                ..Splitting::default()
            },
            selection: Selection::default(),
            wide_area: WideArea::default(),
            capacity: Capacity {
                tracks: 16_384,
                detections: 16_384,
                open_scans: 0,
            },
        }
    }
}

impl Settings {
    /// What is wrong with the settings, in one sentence; `None` if nothing is.
    pub fn fault(&self) -> Option<String> {
        let probability = |value: f64| value > 0.0 && value < 1.0;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let checks = [
            (
                probability(self.gate_probability),
                "the gate probability must lie between 0 and 1",
            ),
            (positive(self.coherence_s), "the coherence time must be positive"),
            (
                self.motion.process_noise_m2ps3.iter().all(|density| positive(*density)),
                "the process noise must be positive",
            ),
            (
                self.motion.manoeuvres.is_none_or(|manoeuvres| {
                    let all = [manoeuvres.process_noise_m2ps3, manoeuvres.durations_s];
                    let turn = |turn: Turn| positive(turn.rate_sigma_radps) && positive(turn.rate_noise_rad2ps3);
                    all.as_flattened().iter().all(|value| positive(*value)) && manoeuvres.turn.is_none_or(turn)
                }),
                "process noise, durations and turn rates of manoeuvres must be positive",
            ),
            (
                positive(self.first_guess.speed_sigma_mps)
                    && self.first_guess.slow_sigma_mps.is_none_or(positive)
                    && positive(self.first_guess.climb_sigma_mps)
                    && positive(self.first_guess.height_sigma_m),
                "the first guess needs positive standard deviations",
            ),
            (
                positive(self.new_target_share) && self.splitting.new_target_share.is_none_or(positive),
                "the share of new targets must be positive",
            ),
            (
                (0.0..0.5).contains(&self.reduction.reliability_min),
                "the least reliability must be at least 0 and below 0.5",
            ),
            (
                (1..=HYPOTHESES_MAX).contains(&self.reduction.hypotheses_max),
                "1 to 64 hypotheses can be kept per cluster",
            ),
            (
                self.reduction.merge_scans <= HISTORY_MAX,
                "hypotheses can be compared over at most 8 scans",
            ),
            (
                self.confirmation.reliability_min > 0.5 && self.confirmation.reliability_min <= 1.0,
                "confirmation needs a reliability above 0.5, at most 1",
            ),
            (
                probability(self.deletion.missed_probability) && self.deletion.silent_ns > 0,
                "tracks must be allowed to miss something before they are deleted",
            ),
            (
                (1..1 << 24).contains(&self.capacity.tracks) && (1..1 << 24).contains(&self.capacity.detections),
                "the tables hold 1 to 16777215 tracks and detections",
            ),
            (self.capacity.open_scans <= 64, "at most 64 scans can stay open"),
        ];
        if let Some((_, sentence)) = checks.iter().find(|(holds, _)| !holds) {
            return Some((*sentence).to_owned());
        }
        if let Some(sentence) = self
            .wide_area
            .fault()
            .or_else(|| self.selection.fault().map(str::to_owned))
        {
            return Some(sentence);
        }
        let faulty = self.sensors.iter().find(|sensor| {
            let density = match sensor.clutter {
                Clutter::Density(density) => positive(density),
                Clutter::Learned => true,
            };
            let view = sensor.field_of_view.is_none_or(|view| view.is_sound());
            let resolution = sensor.resolution_m.is_none_or(positive);
            !(probability(sensor.detection_probability) && density && view && resolution)
        });
        faulty.map(|sensor| {
            format!(
                "sensor {}: the probability of detection must lie between 0 and 1, clutter density and resolution be \
                 positive, the field of view reach from a range of at least 0 to a larger one",
                sensor.sensor_id
            )
        })
    }
}
