//! What a simulated sensor is like.
//!
//! One flat table of settings serves all kinds; what is not given is as usual for the kind. [`SensorSettings`] is as
//! written; [`Checked`] is what the sensor runs on.

use estimation::{FirstVelocity, NearlyConstantVelocity};
use serde::Deserialize;

use crate::error::{SettingsError, count_within, within};

/// How a sensor observes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensorKind {
    /// A rotating antenna measures range and azimuth, each target when the antenna points at it.
    Radar,
    /// Ground stations locate transponder replies; all targets at the same times.
    Multilateration,
    /// Targets broadcast the position they have found themselves, each at times of its own.
    #[serde(rename = "ads-b")]
    AdsB,
}

/// What a sensor learns of a target's identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensorIdentity {
    /// Nothing (a primary radar).
    None,
    /// The Mode 3/A code.
    #[serde(rename = "mode-3a")]
    Mode3A,
    /// 24-bit address and callsign.
    Address,
    /// Mode 3/A code, 24-bit address and callsign.
    Full,
}

/// One simulated sensor. `kind` is required; for anything else that is not given, the usual value of the kind is
/// taken: the first of three values in brackets is for radar, the second for multilateration, the third for ADS-B.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// How the sensor observes.
    pub kind: SensorKind,
    /// Place of the sensor, or of the middle of its coverage: east, north, up, metres (0, 0, 0).
    pub position_m: Option<[f64; 3]>,
    /// Largest distance in the plane, metres (250,000; 200,000; 300,000).
    pub range_max_m: Option<f64>,
    /// Lowest height that is seen, metres (300; −100; −100).
    pub height_min_m: Option<f64>,
    /// Greatest height that is seen, metres (30,000).
    pub height_max_m: Option<f64>,
    /// Time between two looks at one target, seconds (4; 1; 1).
    pub period_s: Option<f64>,
    /// When the first period begins: 0 to the period, seconds (0). A radar then points north.
    pub phase_s: Option<f64>,
    /// How often per period the sensor delivers, 1 to 64 (16; 1; 20): the sectors of a radar's turn.
    pub deliveries_per_period: Option<u32>,
    /// Time from the end of a delivery's interval to the delivery, seconds (0.02).
    pub delay_s: Option<f64>,
    /// Probability that a look finds the target, above 0 (0.95; 0.98; 0.97).
    pub detection_probability: Option<f64>,
    /// Share of the targets that have the equipment this sensor needs (1; 1; 0.9).
    pub equipped_share: Option<f64>,
    /// Standard deviation of range, metres (radar only: 50).
    pub range_sigma_m: Option<f64>,
    /// Standard deviation of azimuth, radians (radar only: 0.0012).
    pub azimuth_sigma_rad: Option<f64>,
    /// Standard deviation east and of that north, metres (not for radar; 20; 10).
    pub horizontal_sigma_m: Option<f64>,
    /// Standard deviation of height, metres (15; 20; 10). A radar with identity "none" has no height unless given.
    pub height_sigma_m: Option<f64>,
    /// Constant error of every position that the sensor does not know of: east, north, up, metres (0, 0, 0).
    pub bias_m: Option<[f64; 3]>,
    /// Constant error of every range that the radar does not know of, metres (radar only: 0).
    pub range_bias_m: Option<f64>,
    /// Constant error of every azimuth that the radar does not know of, radians (radar only: 0).
    pub azimuth_bias_rad: Option<f64>,
    /// What is learned of the identity ("mode-3a"; "full"; "address").
    pub identity: Option<SensorIdentity>,
    /// How often per hour each target disappears from the sensor for a while (0).
    pub dropouts_per_hour: Option<f64>,
    /// For how long it disappears, seconds (20).
    pub dropout_duration_s: Option<f64>,
    /// How many false tracks begin per period, on average, 0 to 20 (0; not for ADS-B).
    pub false_tracks_per_period: Option<f64>,
    /// Whether it delivers what it detects, plots, and no tracks (no; radar only).
    #[serde(default)]
    pub plots: bool,
    /// How many false plots it has per period, on average, 0 to 5000 (0; with `plots` only).
    pub false_plots_per_period: Option<f64>,
    /// Two targets that differ in range by less than this, and in azimuth by less than `azimuth_resolution_rad`, give one plot
    /// in their middle, metres (150 if only the other is given; with `plots` only. Neither given: one plot each).
    pub range_resolution_m: Option<f64>,
    /// See `range_resolution_m`, radians (0.026, the width of a beam of 1.5 degrees).
    pub azimuth_resolution_rad: Option<f64>,
    /// Probability that two such neighbours are resolved in a turn all the same (0; with a resolution only).
    pub resolved_probability: Option<f64>,
    /// Spectral density of the acceleration that the sensor's own filter allows for, east and north, m²/s³; a tenth
    /// of it upwards (20: honest on straight legs and in turns at 25° of bank alike).
    pub acceleration_density_m2ps3: Option<f64>,
    /// Standard deviation of a velocity not yet observed, m/s (150); a tenth of it upwards.
    pub first_speed_sigma_mps: Option<f64>,
    /// Looks that must have found a target before its track is confirmed (3).
    pub confirming_hits: Option<u32>,
    /// Looks in a row without the target that end a tentative track (2).
    pub misses_max_tentative: Option<u32>,
    /// Looks in a row without the target that end a confirmed track (3).
    pub misses_max: Option<u32>,
}

impl SensorSettings {
    /// A sensor with the usual values of its kind.
    pub fn new(kind: SensorKind) -> Self {
        Self {
            kind,
            position_m: None,
            range_max_m: None,
            height_min_m: None,
            height_max_m: None,
            period_s: None,
            phase_s: None,
            deliveries_per_period: None,
            delay_s: None,
            detection_probability: None,
            equipped_share: None,
            range_sigma_m: None,
            azimuth_sigma_rad: None,
            horizontal_sigma_m: None,
            height_sigma_m: None,
            bias_m: None,
            range_bias_m: None,
            azimuth_bias_rad: None,
            identity: None,
            dropouts_per_hour: None,
            dropout_duration_s: None,
            false_tracks_per_period: None,
            plots: false,
            false_plots_per_period: None,
            range_resolution_m: None,
            azimuth_resolution_rad: None,
            resolved_probability: None,
            acceleration_density_m2ps3: None,
            first_speed_sigma_mps: None,
            confirming_hits: None,
            misses_max_tentative: None,
            misses_max: None,
        }
    }

    /// The sensors of the demonstration with their names: two radars that see each other's far side, multilateration
    /// about the airport, and ADS-B. The surface is seen by the last two only.
    pub fn demonstration() -> [(&'static str, Self); 4] {
        let radar_west = Self {
            position_m: Some([-40_000.0, 10_000.0, 0.0]),
            dropouts_per_hour: Some(1.0),
            false_tracks_per_period: Some(0.05),
            ..Self::new(SensorKind::Radar)
        };
        let radar_east = Self {
            position_m: Some([55_000.0, -20_000.0, 0.0]),
            period_s: Some(5.0),
            phase_s: Some(1.3),
            range_sigma_m: Some(40.0),
            dropouts_per_hour: Some(1.0),
            false_tracks_per_period: Some(0.05),
            ..Self::new(SensorKind::Radar)
        };
        let multilateration = Self {
            phase_s: Some(0.4),
            dropouts_per_hour: Some(0.5),
            ..Self::new(SensorKind::Multilateration)
        };
        [
            ("radar-west", radar_west),
            ("radar-east", radar_east),
            ("multilateration", multilateration),
            ("ads-b", Self::new(SensorKind::AdsB)),
        ]
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first setting that cannot be used, with its value and what it has to be.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.checked().map(drop)
    }

    pub(crate) fn checked(&self) -> Result<Checked, SettingsError> {
        self.refuse_settings_of_other_kinds()?;
        let schedule = self.schedule()?;
        let coverage = self.coverage()?;
        let errors = self.errors()?;
        let detection_probability = self.detection_probability.unwrap_or(match self.kind {
            SensorKind::Radar => 0.95,
            SensorKind::Multilateration => 0.98,
            SensorKind::AdsB => 0.97,
        });
        within("detection_probability", detection_probability, 1e-3, 1.0)?;
        let equipped_share = self
            .equipped_share
            .unwrap_or(if self.kind == SensorKind::AdsB { 0.9 } else { 1.0 });
        within("equipped_share", equipped_share, 0.0, 1.0)?;
        let false_tracks_per_period = self.false_tracks_per_period.unwrap_or(0.0);
        within("false_tracks_per_period", false_tracks_per_period, 0.0, 20.0)?;
        let false_plots_per_period = self.false_plots_per_period.unwrap_or(0.0);
        within("false_plots_per_period", false_plots_per_period, 0.0, 5000.0)?;
        Ok(Checked {
            kind: self.kind,
            schedule,
            coverage,
            errors,
            detection_probability,
            equipped_share,
            false_tracks_per_period,
            false_plots_per_period,
            resolution: self.resolution()?,
            identity: self.identity_or_usual(),
            dropouts: self.dropouts()?,
            tracking: self.tracking()?,
        })
    }

    fn identity_or_usual(&self) -> SensorIdentity {
        self.identity.unwrap_or(match self.kind {
            SensorKind::Radar => SensorIdentity::Mode3A,
            SensorKind::Multilateration => SensorIdentity::Full,
            SensorKind::AdsB => SensorIdentity::Address,
        })
    }

    fn refuse_settings_of_other_kinds(&self) -> Result<(), SettingsError> {
        let radar = self.kind == SensorKind::Radar;
        let of_radars = [
            ("range_sigma_m", self.range_sigma_m),
            ("azimuth_sigma_rad", self.azimuth_sigma_rad),
            ("range_bias_m", self.range_bias_m),
            ("azimuth_bias_rad", self.azimuth_bias_rad),
        ];
        for (key, value) in of_radars {
            if let (false, Some(value)) = (radar, value) {
                return Err(SettingsError::new(key, value, "left out: only a radar has it"));
            }
        }
        if let (true, Some(value)) = (radar, self.horizontal_sigma_m) {
            let limit = "left out: a radar has range_sigma_m and azimuth_sigma_rad";
            return Err(SettingsError::new("horizontal_sigma_m", value, limit));
        }
        let of_plots = [
            ("false_plots_per_period", self.false_plots_per_period),
            ("range_resolution_m", self.range_resolution_m),
            ("azimuth_resolution_rad", self.azimuth_resolution_rad),
            ("resolved_probability", self.resolved_probability),
        ];
        for (key, value) in of_plots {
            if let (false, Some(value)) = (self.plots, value) {
                let limit = "left out: only a sensor with plots = true has it";
                return Err(SettingsError::new(key, value, limit));
            }
        }
        if self.plots && !radar {
            let limit = "left out: only a radar delivers plots";
            return Err(SettingsError::new("plots", self.plots, limit));
        }
        if let (SensorKind::AdsB, Some(value)) = (self.kind, self.false_tracks_per_period)
            && value != 0.0
        {
            let limit = "left out: ADS-B has no false tracks";
            return Err(SettingsError::new("false_tracks_per_period", value, limit));
        }
        Ok(())
    }

    fn schedule(&self) -> Result<ScheduleSettings, SettingsError> {
        let radar = self.kind == SensorKind::Radar;
        let period_s = self.period_s.unwrap_or(if radar { 4.0 } else { 1.0 });
        within("period_s", period_s, 0.05, 60.0)?;
        let phase_s = self.phase_s.unwrap_or(0.0);
        within("phase_s", phase_s, 0.0, period_s)?;
        let deliveries = self.deliveries_per_period.unwrap_or(match self.kind {
            SensorKind::Radar => 16,
            SensorKind::Multilateration => 1,
            SensorKind::AdsB => 20,
        });
        count_within("deliveries_per_period", deliveries, 1, 64)?;
        let delay_s = self.delay_s.unwrap_or(0.02);
        within("delay_s", delay_s, 0.0, 60.0)?;
        Ok(ScheduleSettings {
            period_s,
            phase_s,
            deliveries,
            delay_s,
        })
    }

    fn coverage(&self) -> Result<Coverage, SettingsError> {
        let position_m = self.position_m.unwrap_or([0.0; 3]);
        for value in position_m {
            within("position_m", value, -1e7, 1e7)?;
        }
        let range_max_m = self.range_max_m.unwrap_or(match self.kind {
            SensorKind::Radar => 250_000.0,
            SensorKind::Multilateration => 200_000.0,
            SensorKind::AdsB => 300_000.0,
        });
        within("range_max_m", range_max_m, 1.0, 1e6)?;
        let radar = self.kind == SensorKind::Radar;
        let height_min_m = self.height_min_m.unwrap_or(if radar { 300.0 } else { -100.0 });
        within("height_min_m", height_min_m, -1e4, 1e5)?;
        let height_max_m = self.height_max_m.unwrap_or(30_000.0);
        within("height_max_m", height_max_m, height_min_m, 1e6)?;
        Ok(Coverage {
            position_m,
            range_max_m,
            height_min_m,
            height_max_m,
        })
    }

    fn errors(&self) -> Result<MeasurementErrors, SettingsError> {
        let plane = if self.kind == SensorKind::Radar {
            let range_sigma_m = self.range_sigma_m.unwrap_or(50.0);
            within("range_sigma_m", range_sigma_m, 1e-3, 1e5)?;
            let azimuth_sigma_rad = self.azimuth_sigma_rad.unwrap_or(0.0012);
            within("azimuth_sigma_rad", azimuth_sigma_rad, 1e-7, 0.2)?;
            let range_bias_m = self.range_bias_m.unwrap_or(0.0);
            within("range_bias_m", range_bias_m, -1e5, 1e5)?;
            let azimuth_bias_rad = self.azimuth_bias_rad.unwrap_or(0.0);
            within("azimuth_bias_rad", azimuth_bias_rad, -0.5, 0.5)?;
            PlaneErrors::Polar {
                range_sigma_m,
                azimuth_sigma_rad,
                range_bias_m,
                azimuth_bias_rad,
            }
        } else {
            let usual = if self.kind == SensorKind::AdsB { 10.0 } else { 20.0 };
            let sigma_m = self.horizontal_sigma_m.unwrap_or(usual);
            within("horizontal_sigma_m", sigma_m, 1e-3, 1e5)?;
            PlaneErrors::Cartesian { sigma_m }
        };
        let height_sigma_m = self.height_sigma_m.or(match self.kind {
            SensorKind::Radar if self.identity_or_usual() == SensorIdentity::None => None,
            SensorKind::Radar => Some(15.0),
            SensorKind::Multilateration => Some(20.0),
            SensorKind::AdsB => Some(10.0),
        });
        if let Some(sigma) = height_sigma_m {
            within("height_sigma_m", sigma, 1e-3, 1e5)?;
        }
        let bias_m = self.bias_m.unwrap_or([0.0; 3]);
        for value in bias_m {
            within("bias_m", value, -1e5, 1e5)?;
        }
        Ok(MeasurementErrors {
            plane,
            height_sigma_m,
            bias_m,
        })
    }

    fn resolution(&self) -> Result<Option<ResolutionCell>, SettingsError> {
        let resolved_probability = self.resolved_probability.unwrap_or(0.0);
        if self.range_resolution_m.is_none() && self.azimuth_resolution_rad.is_none() {
            return match self.resolved_probability {
                None => Ok(None),
                Some(value) => {
                    let limit = "left out: needs range_resolution_m or azimuth_resolution_rad beside it";
                    Err(SettingsError::new("resolved_probability", value, limit))
                }
            };
        }
        within("resolved_probability", resolved_probability, 0.0, 1.0)?;
        let range_m = self.range_resolution_m.unwrap_or(150.0);
        within("range_resolution_m", range_m, 1e-3, 1e5)?;
        let azimuth_rad = self.azimuth_resolution_rad.unwrap_or(0.026);
        within("azimuth_resolution_rad", azimuth_rad, 1e-7, 0.5)?;
        Ok(Some(ResolutionCell {
            range_m,
            azimuth_rad,
            resolved_probability,
        }))
    }

    fn dropouts(&self) -> Result<Option<Dropouts>, SettingsError> {
        let per_hour = self.dropouts_per_hour.unwrap_or(0.0);
        within("dropouts_per_hour", per_hour, 0.0, 360.0)?;
        let duration_s = self.dropout_duration_s.unwrap_or(20.0);
        if per_hour == 0.0 {
            within("dropout_duration_s", duration_s, 0.0, 3600.0)?;
            return Ok(None);
        }
        let every_s = 3600.0 / per_hour;
        if !(0.0..=every_s).contains(&duration_s) {
            return Err(SettingsError::new(
                "dropout_duration_s",
                duration_s,
                format_args!("between 0 and {every_s}, the time from one dropout to the next"),
            ));
        }
        Ok(Some(Dropouts { every_s, duration_s }))
    }

    fn tracking(&self) -> Result<Tracking, SettingsError> {
        let density = self.acceleration_density_m2ps3.unwrap_or(20.0);
        within("acceleration_density_m2ps3", density, 1e-6, 1e6)?;
        let sigma = self.first_speed_sigma_mps.unwrap_or(150.0);
        within("first_speed_sigma_mps", sigma, 1e-3, 1e4)?;
        let confirming_hits = self.confirming_hits.unwrap_or(3);
        count_within("confirming_hits", confirming_hits, 1, 100)?;
        let misses_max_tentative = self.misses_max_tentative.unwrap_or(2);
        count_within("misses_max_tentative", misses_max_tentative, 1, 100)?;
        let misses_max = self.misses_max.unwrap_or(3);
        count_within("misses_max", misses_max, 1, 100)?;
        Ok(Tracking {
            motion: NearlyConstantVelocity::new(density, density / 10.0),
            first_velocity: FirstVelocity {
                horizontal_sigma_mps: sigma,
                vertical_sigma_mps: sigma / 10.0,
            },
            confirming_hits,
            misses_max_tentative,
            misses_max,
        })
    }
}

/// Settings that passed every check, with nothing left open.
#[derive(Clone, Debug)]
pub(crate) struct Checked {
    pub(crate) kind: SensorKind,
    pub(crate) schedule: ScheduleSettings,
    pub(crate) coverage: Coverage,
    pub(crate) errors: MeasurementErrors,
    pub(crate) detection_probability: f64,
    pub(crate) equipped_share: f64,
    pub(crate) false_tracks_per_period: f64,
    pub(crate) false_plots_per_period: f64,
    /// `None`: targets are always told apart.
    pub(crate) resolution: Option<ResolutionCell>,
    pub(crate) identity: SensorIdentity,
    pub(crate) dropouts: Option<Dropouts>,
    pub(crate) tracking: Tracking,
}

/// When the sensor looks and delivers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScheduleSettings {
    pub(crate) period_s: f64,
    pub(crate) phase_s: f64,
    pub(crate) deliveries: u32,
    pub(crate) delay_s: f64,
}

/// Where the sensor sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coverage {
    pub(crate) position_m: [f64; 3],
    pub(crate) range_max_m: f64,
    pub(crate) height_min_m: f64,
    pub(crate) height_max_m: f64,
}

impl Coverage {
    pub(crate) fn contains(&self, position_m: [f64; 3]) -> bool {
        let [dx, dy] = [0, 1].map(|axis| position_m[axis] - self.position_m[axis]);
        dx.hypot(dy) <= self.range_max_m && (self.height_min_m..=self.height_max_m).contains(&position_m[2])
    }
}

/// How measurements err.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasurementErrors {
    pub(crate) plane: PlaneErrors,
    /// `None`: height is not observed.
    pub(crate) height_sigma_m: Option<f64>,
    pub(crate) bias_m: [f64; 3],
}

/// How measurements err in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PlaneErrors {
    Polar {
        range_sigma_m: f64,
        azimuth_sigma_rad: f64,
        range_bias_m: f64,
        azimuth_bias_rad: f64,
    },
    Cartesian {
        sigma_m: f64,
    },
}

/// What a radar can tell apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolutionCell {
    pub(crate) range_m: f64,
    pub(crate) azimuth_rad: f64,
    /// Probability that neighbours in one cell are told apart all the same.
    pub(crate) resolved_probability: f64,
}

/// One outage of `duration_s` in each stretch of `every_s`, per target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dropouts {
    pub(crate) every_s: f64,
    pub(crate) duration_s: f64,
}

/// How the sensor's own tracker works.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tracking {
    pub(crate) motion: NearlyConstantVelocity,
    pub(crate) first_velocity: FirstVelocity,
    pub(crate) confirming_hits: u32,
    pub(crate) misses_max_tentative: u32,
    pub(crate) misses_max: u32,
}

#[cfg(test)]
#[path = "sensor_settings_tests.rs"]
mod tests;
