//! Settings of a simulated sensor.
//!
//! One flat table of settings serves all kinds; omitted values default to the values of the kind.
//! [`SensorSettings`] holds the values as written; [`CheckedSensor`] holds the complete values used by the sensor.

use estimation::{FirstVelocity, NearlyConstantVelocity};
use settings::{SettingsError, within};

/// Reason for rejecting a key of plots in a sensor that delivers tracks.
const WITH_PLOTS: &str = "only a sensor with plots = true has it";

settings::words! {
    /// Kinds of simulated sensors.
    pub enum SensorKind {
        /// Rotating antenna; measures range and azimuth of each target when the antenna points at the target.
        Radar = "radar",
        /// Ground stations locate transponder replies; all targets at the same times.
        Multilateration = "multilateration",
        /// Targets broadcast self-determined positions, each target at different times.
        AdsB = "ads-b",
    }

    /// Identity of a target as reported by a sensor.
    pub enum SensorIdentity {
        /// No identity (a primary radar).
        None = "none",
        /// Mode 3/A code.
        Mode3A = "mode-3a",
        /// 24-bit address and callsign.
        Address = "address",
        /// Mode 3/A code, 24-bit address and callsign.
        Full = "full",
    }
}

settings::settings! {
    /// A simulated sensor. Of three defaults the first is for radar, the second for multilateration, the third for
    /// ADS-B.
    pub struct SensorSettings {
        check SensorSettings::check;
        /// Kind of sensor.
        kind: SensorKind;
        /// Place of the sensor, or of the middle of its coverage: east, north, up.
        position_m: Option<[f64; 3]> = None, in [-1e7, 1e7], usually "0, 0, 0";
        /// Largest distance in the plane.
        range_max_m: Option<f64> = None, in [1, 1e6], usually "250000; 200000; 300000";
        /// Lowest height that is seen.
        height_min_m: Option<f64> = None, in [-1e4, 1e5], usually "300; −100; −100";
        /// Greatest height that is seen.
        height_max_m: Option<f64> = None, in [-1e4, 1e6], usually "30000";
        /// Time between two looks at a target.
        period_s: Option<f64> = None, in [0.05, 60], usually "4; 1; 1";
        /// Time when the first period begins, up to the period. A radar then points north.
        phase_s: Option<f64> = None, in [0, 60], usually "0";
        /// Deliveries per period: the sectors of a radar's turn.
        deliveries_per_period: Option<u32> = None, in [1, 64], usually "16; 1; 20";
        /// Time from the end of a delivery's interval to the delivery.
        delay_s: Option<f64> = None, in [0, 60], usually "0.02";
        /// Probability that a look finds the target.
        detection_probability: Option<f64> = None, in [1e-3, 1], usually "0.95; 0.98; 0.97";
        /// Share of the targets that have the equipment this sensor needs.
        equipped_share: Option<f64> = None, in [0, 1], usually "1; 1; 0.9";
        /// Standard deviation of range; of radars only.
        range_sigma_m: Option<f64> = None, in [1e-3, 1e5], usually "50";
        /// Standard deviation of azimuth; of radars only.
        azimuth_sigma_rad: Option<f64> = None, in [1e-7, 0.2], usually "0.0012";
        /// Standard deviation east and of that north; not of radars.
        horizontal_sigma_m: Option<f64> = None, in [1e-3, 1e5], usually "–; 20; 10";
        /// Standard deviation of height. A radar with identity "none" has no height unless given.
        height_sigma_m: Option<f64> = None, in [1e-3, 1e5], usually "15; 20; 10";
        /// Constant bias of every position: east, north, up.
        bias_m: Option<[f64; 3]> = None, in [-1e5, 1e5], usually "0, 0, 0";
        /// Constant bias of every range; radars only.
        range_bias_m: Option<f64> = None, in [-1e5, 1e5], usually "0";
        /// Constant bias of every azimuth; radars only.
        azimuth_bias_rad: Option<f64> = None, in [-0.5, 0.5], usually "0";
        /// Kind of identity that the sensor obtains of a target.
        identity: Option<SensorIdentity> = None, usually "mode-3a; full; address";
        /// Number of times per hour that each target disappears from the sensor for a while.
        dropouts_per_hour: Option<f64> = None, in [0, 360], usually "0";
        /// Duration of a dropout.
        dropout_duration_s: Option<f64> = None, in [0, 1e5], usually "20";
        /// Mean number of false tracks that begin per period; not of ADS-B.
        false_tracks_per_period: Option<f64> = None, in [0, 20], usually "0";
        /// Whether the radar delivers detections (plots) instead of tracks; radars only.
        plots: bool = false;
        /// Mean number of false plots per period; with `plots` only.
        false_plots_per_period: Option<f64> = None, in [0, 5000], usually "0";
        /// Probability that a plot has the address and callsign of its target; with `plots` only.
        address_probability: Option<f64> = None, in [0, 1], usually "0";
        /// Probability that a plot has the Mode 3/A code of its target; with `plots` only.
        code_probability: Option<f64> = None, in [0, 1], usually "0";
        /// Probability that an address or code of a plot is a wrong one; with one of them only.
        garbled_probability: Option<f64> = None, in [0, 1], usually "0";
        /// Range resolution: two targets that differ in range by less than this value, and in azimuth by less than
        /// `azimuth_resolution_rad`, give a single plot in their middle. With `plots` only; without both keys, every
        /// target gives its own plot.
        range_resolution_m: Option<f64> = None, in [1e-3, 1e5], usually "150 if the other is given";
        /// Azimuth resolution; see `range_resolution_m`.
        azimuth_resolution_rad: Option<f64> = None, in [1e-7, 0.5], usually "0.026 if the other is given, a beam of 1.5°";
        /// Probability that two such neighbours are nevertheless resolved in a turn; with a resolution only.
        resolved_probability: Option<f64> = None, in [0, 1], usually "0";
        /// Spectral density of the acceleration in the sensor's own filter, east and north; vertically a tenth. With
        /// the default, covariances are right on straight legs and in turns with 25° of bank.
        acceleration_density_m2ps3: Option<f64> = None, in [1e-6, 1e6], usually "20";
        /// Standard deviation of a velocity not yet observed, horizontally; vertically a tenth.
        first_speed_sigma_mps: Option<f64> = None, in [1e-3, 1e4], usually "150";
        /// Number of detections of a target before its track is confirmed.
        confirming_hits: Option<u32> = None, in [1, 100], usually "3";
        /// Looks in a row without the target that end a tentative track.
        misses_max_tentative: Option<u32> = None, in [1, 100], usually "2";
        /// Looks in a row without the target that end a confirmed track.
        misses_max: Option<u32> = None, in [1, 100], usually "3";
    }
}

/// Checks that a phase is at most a period.
pub(crate) fn phase_within(phase_s: f64, period_s: f64) -> Result<(), SettingsError> {
    within("phase_s", phase_s, 0.0, period_s)
}

impl SensorSettings {
    /// Creates a sensor with the defaults of its kind.
    pub fn new(kind: SensorKind) -> Self {
        Self {
            kind,
            ..Self::default()
        }
    }

    /// Whether the sensor's plots have the replies of transponders.
    pub fn receives_replies(&self) -> bool {
        self.replies().are_received()
    }

    /// Returns the sensors of the demonstration with their names: two radars that cover each other's far side,
    /// multilateration around the airport, and ADS-B. Only the last two cover the surface.
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

    fn check(&self) -> Result<(), SettingsError> {
        self.check_kind()?;
        let schedule = self.schedule();
        phase_within(schedule.phase_s, schedule.period_s)?;
        let coverage = self.coverage();
        within("height_max_m", coverage.height_max_m, coverage.height_min_m, 1e6)?;
        if let Some(value) = self.resolved_probability.filter(|_| self.resolution().is_none()) {
            let what = format!("{value} needs range_resolution_m or azimuth_resolution_rad beside it");
            return Err(SettingsError::new("resolved_probability", what));
        }
        match self.dropouts() {
            Some(Dropouts { every_s, duration_s }) if duration_s > every_s => {
                let what = format!(
                    "{duration_s} is out of range; it must lie between 0 and {every_s}, the time from one dropout to the next"
                );
                Err(SettingsError::new("dropout_duration_s", what))
            }
            _ => Ok(()),
        }
    }

    /// Rejects settings of other kinds.
    fn check_kind(&self) -> Result<(), SettingsError> {
        let is_radar = self.kind == SensorKind::Radar;
        let may_have_false_tracks = self.kind != SensorKind::AdsB;
        let false_tracks = self.false_tracks_per_period.filter(|number| *number != 0.0);
        let wrong = [
            (is_radar, "only a radar has it", "range_sigma_m", self.range_sigma_m),
            (
                is_radar,
                "only a radar has it",
                "azimuth_sigma_rad",
                self.azimuth_sigma_rad,
            ),
            (is_radar, "only a radar has it", "range_bias_m", self.range_bias_m),
            (
                is_radar,
                "only a radar has it",
                "azimuth_bias_rad",
                self.azimuth_bias_rad,
            ),
            (
                !is_radar,
                "a radar has range_sigma_m and azimuth_sigma_rad",
                "horizontal_sigma_m",
                self.horizontal_sigma_m,
            ),
            (
                self.plots,
                WITH_PLOTS,
                "false_plots_per_period",
                self.false_plots_per_period,
            ),
            (self.plots, WITH_PLOTS, "address_probability", self.address_probability),
            (self.plots, WITH_PLOTS, "code_probability", self.code_probability),
            (
                self.replies().are_received(),
                "it needs address_probability or code_probability",
                "garbled_probability",
                self.garbled_probability,
            ),
            (self.plots, WITH_PLOTS, "range_resolution_m", self.range_resolution_m),
            (
                self.plots,
                WITH_PLOTS,
                "azimuth_resolution_rad",
                self.azimuth_resolution_rad,
            ),
            (
                self.plots,
                WITH_PLOTS,
                "resolved_probability",
                self.resolved_probability,
            ),
            (
                may_have_false_tracks,
                "ADS-B has no false tracks",
                "false_tracks_per_period",
                false_tracks,
            ),
        ];
        for (may_have, reason, key, value) in wrong {
            if let (false, Some(value)) = (may_have, value) {
                return Err(SettingsError::new(key, format!("{value}: leave it out; {reason}")));
            }
        }
        match self.plots && !is_radar {
            true => Err(SettingsError::new(
                "plots",
                "true: leave it out; only a radar delivers plots",
            )),
            false => Ok(()),
        }
    }

    /// Returns the complete settings.
    ///
    /// # Errors
    /// The first invalid setting.
    pub(crate) fn checked(&self) -> Result<CheckedSensor, SettingsError> {
        settings::check(self)?;
        let detection_probability = self.of_kind(self.detection_probability, [0.95, 0.98, 0.97]);
        Ok(CheckedSensor {
            kind: self.kind,
            schedule: self.schedule(),
            coverage: self.coverage(),
            errors: self.errors(),
            detection_probability,
            equipped_share: self.of_kind(self.equipped_share, [1.0, 1.0, 0.9]),
            false_tracks_per_period: self.false_tracks_per_period.unwrap_or(0.0),
            false_plots_per_period: self.false_plots_per_period.unwrap_or(0.0),
            replies: self.replies(),
            resolution: self.resolution(),
            identity: self.identity_or_usual(),
            dropouts: self.dropouts(),
            tracking: self.tracking(),
        })
    }

    /// Returns the given value, or the default of the kind: radar, multilateration, ADS-B.
    fn of_kind<T: Copy>(&self, given: Option<T>, usual: [T; 3]) -> T {
        given.unwrap_or(usual[self.kind as usize])
    }

    fn identity_or_usual(&self) -> SensorIdentity {
        let usual = [SensorIdentity::Mode3A, SensorIdentity::Full, SensorIdentity::Address];
        self.of_kind(self.identity, usual)
    }

    fn schedule(&self) -> ScheduleSettings {
        ScheduleSettings {
            period_s: self.of_kind(self.period_s, [4.0, 1.0, 1.0]),
            phase_s: self.phase_s.unwrap_or(0.0),
            deliveries: self.of_kind(self.deliveries_per_period, [16, 1, 20]),
            delay_s: self.delay_s.unwrap_or(0.02),
        }
    }

    fn coverage(&self) -> SensorCoverage {
        SensorCoverage {
            position_m: self.position_m.unwrap_or([0.0; 3]),
            range_max_m: self.of_kind(self.range_max_m, [250_000.0, 200_000.0, 300_000.0]),
            height_min_m: self.of_kind(self.height_min_m, [300.0, -100.0, -100.0]),
            height_max_m: self.height_max_m.unwrap_or(30_000.0),
        }
    }

    fn errors(&self) -> MeasurementErrors {
        let plane = match self.kind {
            SensorKind::Radar => PlaneErrors::Polar {
                range_sigma_m: self.range_sigma_m.unwrap_or(50.0),
                azimuth_sigma_rad: self.azimuth_sigma_rad.unwrap_or(0.0012),
                range_bias_m: self.range_bias_m.unwrap_or(0.0),
                azimuth_bias_rad: self.azimuth_bias_rad.unwrap_or(0.0),
            },
            SensorKind::Multilateration | SensorKind::AdsB => PlaneErrors::Cartesian {
                sigma_m: self.of_kind(self.horizontal_sigma_m, [f64::NAN, 20.0, 10.0]),
            },
        };
        let is_primary = self.kind == SensorKind::Radar && self.identity_or_usual() == SensorIdentity::None;
        MeasurementErrors {
            plane,
            height_sigma_m: match (is_primary, self.height_sigma_m) {
                (true, given) => given,
                (false, given) => Some(self.of_kind(given, [15.0, 20.0, 10.0])),
            },
            bias_m: self.bias_m.unwrap_or([0.0; 3]),
        }
    }

    fn replies(&self) -> ReplySettings {
        ReplySettings {
            address_probability: self.address_probability.unwrap_or(0.0),
            code_probability: self.code_probability.unwrap_or(0.0),
            garbled_probability: self.garbled_probability.unwrap_or(0.0),
        }
    }

    fn resolution(&self) -> Option<ResolutionCell> {
        self.range_resolution_m.or(self.azimuth_resolution_rad)?;
        Some(ResolutionCell {
            range_m: self.range_resolution_m.unwrap_or(150.0),
            azimuth_rad: self.azimuth_resolution_rad.unwrap_or(0.026),
            resolved_probability: self.resolved_probability.unwrap_or(0.0),
        })
    }

    fn dropouts(&self) -> Option<Dropouts> {
        let per_hour = self.dropouts_per_hour.filter(|per_hour| *per_hour > 0.0)?;
        Some(Dropouts {
            every_s: 3600.0 / per_hour,
            duration_s: self.dropout_duration_s.unwrap_or(20.0),
        })
    }

    fn tracking(&self) -> SensorTracker {
        let density = self.acceleration_density_m2ps3.unwrap_or(20.0);
        let sigma = self.first_speed_sigma_mps.unwrap_or(150.0);
        SensorTracker {
            motion: NearlyConstantVelocity::new(density, density / 10.0),
            first_velocity: FirstVelocity {
                horizontal_sigma_mps: sigma,
                vertical_sigma_mps: sigma / 10.0,
            },
            confirming_hits: self.confirming_hits.unwrap_or(3),
            misses_max_tentative: self.misses_max_tentative.unwrap_or(2),
            misses_max: self.misses_max.unwrap_or(3),
        }
    }
}

/// Complete settings that passed every check.
#[derive(Clone, Debug)]
pub(crate) struct CheckedSensor {
    pub(crate) kind: SensorKind,
    pub(crate) schedule: ScheduleSettings,
    pub(crate) coverage: SensorCoverage,
    pub(crate) errors: MeasurementErrors,
    pub(crate) detection_probability: f64,
    pub(crate) equipped_share: f64,
    pub(crate) false_tracks_per_period: f64,
    pub(crate) false_plots_per_period: f64,
    pub(crate) replies: ReplySettings,
    /// `None`: all targets are resolved.
    pub(crate) resolution: Option<ResolutionCell>,
    pub(crate) identity: SensorIdentity,
    pub(crate) dropouts: Option<Dropouts>,
    pub(crate) tracking: SensorTracker,
}

/// Schedule of the sensor's looks and deliveries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScheduleSettings {
    pub(crate) period_s: f64,
    pub(crate) phase_s: f64,
    pub(crate) deliveries: u32,
    pub(crate) delay_s: f64,
}

/// Region in which the sensor observes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorCoverage {
    pub(crate) position_m: [f64; 3],
    pub(crate) range_max_m: f64,
    pub(crate) height_min_m: f64,
    pub(crate) height_max_m: f64,
}

impl SensorCoverage {
    /// Whether an object at a position, and at a height above the ellipsoid, is within coverage.
    pub(crate) fn contains(&self, position_m: [f64; 3], height_m: f64) -> bool {
        let [dx, dy] = [0, 1].map(|axis| position_m[axis] - self.position_m[axis]);
        dx.hypot(dy) <= self.range_max_m && (self.height_min_m..=self.height_max_m).contains(&height_m)
    }
}

/// Errors of measurements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasurementErrors {
    pub(crate) plane: PlaneErrors,
    /// `None`: height is not observed.
    pub(crate) height_sigma_m: Option<f64>,
    pub(crate) bias_m: [f64; 3],
}

/// Errors of measurements in the plane.
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

/// Replies in the plots of a radar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReplySettings {
    pub(crate) address_probability: f64,
    pub(crate) code_probability: f64,
    pub(crate) garbled_probability: f64,
}

/// Resolution of a radar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolutionCell {
    pub(crate) range_m: f64,
    pub(crate) azimuth_rad: f64,
    /// Probability that neighbours in one cell are resolved nevertheless.
    pub(crate) resolved_probability: f64,
}

/// One outage of `duration_s` in each stretch of `every_s`, per target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dropouts {
    pub(crate) every_s: f64,
    pub(crate) duration_s: f64,
}

/// Parameters of the sensor's own tracker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorTracker {
    pub(crate) motion: NearlyConstantVelocity,
    pub(crate) first_velocity: FirstVelocity,
    pub(crate) confirming_hits: u32,
    pub(crate) misses_max_tentative: u32,
    pub(crate) misses_max: u32,
}

#[cfg(test)]
#[path = "sensor_settings_tests.rs"]
mod tests;
