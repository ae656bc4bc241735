//! Measurement of a sensor at a time, not yet part of any track (FM-6).
//!
//! A radar plot, a lidar return or a camera's bearing gives the position or direction of an object, but not the
//! target that it belongs to. Some sensors give two coordinates, some three, some an angle alone; therefore a
//! detection names its kind, and the kind defines the measured quantities in their order. Positions are in the
//! system frame, east, north and up. Angles are radians: bearings clockwise from north, elevations up from the
//! horizontal, both from the sensor's position at that moment.

use messages::{DetectionKind, Identity, IdentityAges, SensorDetection, StageTimes, sensor_detection_bits as bits};

use crate::{Sampled, flag, sensor_id};

/// Most quantities that a detection holds beside the range rate.
pub const QUANTITIES_MAX: usize = 3;

/// Measurement of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Time of measurement, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Number of the sensor in its files.
    pub sensor_id: u32,
    /// The sensor's scan, turn or frame; it rises with time.
    pub scan: u32,
    /// Number of the detection, unique within its scan at least.
    pub detection_id: u32,
    /// Kind: which quantities were measured.
    pub kind: DetectionKind,
    /// Their values, in the order of [`DetectionKind::quantities`]; 0 beyond.
    pub values: [f64; QUANTITIES_MAX],
    /// Speed away from the sensor, metres per second, where it was measured too.
    pub range_rate_mps: Option<f64>,
    /// Standard deviations of the values and, last, of the range rate, all above 0, in the units of the values; 0
    /// where there is no value. `None` where the source states none.
    pub sigmas: Option<[f64; QUANTITIES_MAX + 1]>,
    /// Position of the sensor, metres east, north and up in the system frame.
    pub platform_m: [f64; 3],
    /// Motion and attitude of the platform that carries the sensor, as far as the detection states them.
    pub platform: DetectionPlatform,
    /// Height that the report of a radar on board states beside slant range and bearing, until the platform's state is
    /// known and the elevation follows from it. `None` in samples and rows.
    pub height: Option<StatedHeight>,
    /// Velocity of a designated target; other detections than designations make no use of it. In samples it takes the
    /// place of the platform's velocity.
    pub velocity: Option<StatedVelocity>,
    /// Values that the target's transponder stated.
    pub reply: TransponderReply,
    /// Truth, if known: for scoring, never for tracking.
    pub truth: Option<DetectionTruth>,
}

/// Height of a target, as its report states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedHeight {
    /// Height above the ellipsoid, or up in the system frame where there is no place on the globe, metres.
    pub height_m: f64,
    /// Its standard deviation, metres.
    pub sigma_m: f64,
}

/// Velocity of a target, as its designation states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedVelocity {
    /// East and north in the system frame, metres per second.
    pub velocity_mps: [f32; 2],
    /// Standard deviation of each, metres per second.
    pub sigma_mps: f64,
}

impl StatedVelocity {
    /// What a sample states: `None` without numbers that a velocity and its standard deviation can have.
    fn of_sample(sample: &SensorDetection) -> Option<Self> {
        let ([east, north, _], [.., sigma_mps]) = (sample.platform_velocity_mps, sample.sigmas);
        let is_stated = sample.valid & bits::TARGET_VELOCITY != 0 && sample.valid & bits::RANGE_RATE == 0;
        let fits = is_stated && east.is_finite() && north.is_finite() && sigma_mps > 0.0 && sigma_mps.is_finite();
        fits.then_some(Self {
            velocity_mps: [east, north],
            sigma_mps,
        })
    }
}

/// Values of a detection that the target's transponder stated; most detections have some of them or none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransponderReply {
    /// Address or MMSI, Mode 3/A code, callsign and name.
    pub identity: Identity,
    /// Ages of these values at the time of measurement; 0 for values of this look.
    pub ages: IdentityAges,
    /// Level in steps of 25 feet at 1013.25 hPa.
    pub level: Option<i16>,
    /// Age of the level at the time of measurement, milliseconds.
    pub level_age_ms: u32,
}

/// Motion and attitude of the platform that carries a sensor, as its detection states them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DetectionPlatform {
    /// Velocity east, north, up, metres per second.
    pub velocity_mps: Option<[f32; 3]>,
    /// Heading (clockwise from north), pitch (nose up) and roll (right side down), radians.
    pub attitude_rad: Option<[f32; 3]>,
    /// Standard deviation of each coordinate of the position, metres.
    pub sigma_m: Option<f32>,
    /// Standard deviations of heading, pitch and roll, radians; 0 where unknown.
    pub attitude_sigmas_rad: [f32; 3],
}

/// Truth of a detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetectionTruth {
    /// The target with this number.
    Target(u32),
    /// No target: clutter or noise.
    FalseAlarm,
    /// Several targets that the sensor did not resolve.
    Merged,
}

impl Sampled for Detection {
    type Sample = SensorDetection;

    fn sample(&self, source: u16, stages: StageTimes) -> SensorDetection {
        let velocity = self.velocity.filter(|_| self.range_rate_mps.is_none());
        let mut sigmas = self.sigmas.unwrap_or_default();
        if let Some(stated) = velocity {
            sigmas[QUANTITIES_MAX] = stated.sigma_mps;
        }
        let of_target = velocity.map(
            |StatedVelocity {
                 velocity_mps: [east, north],
                 ..
             }| [east, north, 0.0],
        );
        let platform_velocity_mps = self.platform.velocity_mps.filter(|_| of_target.is_none());
        SensorDetection {
            time_of_measurement_ns: self.time_of_measurement_ns,
            stages,
            scan: self.scan,
            detection_id: self.detection_id,
            values: self.values,
            range_rate_mps: self.range_rate_mps.unwrap_or_default(),
            sigmas,
            platform_m: self.platform_m,
            source,
            kind: self.kind.code(),
            valid: flag(self.range_rate_mps.is_some(), bits::RANGE_RATE)
                | flag(self.sigmas.is_some(), bits::SIGMAS)
                | flag(self.reply.level.is_some(), bits::LEVEL)
                | flag(of_target.is_some(), bits::TARGET_VELOCITY)
                | flag(platform_velocity_mps.is_some(), bits::PLATFORM_VELOCITY)
                | flag(self.platform.attitude_rad.is_some(), bits::PLATFORM_ATTITUDE)
                | flag(self.platform.sigma_m.is_some(), bits::PLATFORM_SIGMA),
            identity: self.reply.identity,
            identity_ages: self.reply.ages,
            level: self.reply.level.unwrap_or_default(),
            level_age_ms: self.reply.level_age_ms,
            platform_velocity_mps: of_target.or(platform_velocity_mps).unwrap_or_default(),
            platform_attitude_rad: self.platform.attitude_rad.unwrap_or_default(),
            platform_sigma_m: self.platform.sigma_m.unwrap_or_default(),
            attitude_sigmas_rad: self.platform.attitude_sigmas_rad,
            ..SensorDetection::default()
        }
    }

    fn of_sample(sample: &SensorDetection) -> Option<Self> {
        if sample.valid & bits::MARK != 0 {
            return None;
        }
        let velocity = StatedVelocity::of_sample(sample);
        let mut sigmas = sample.sigmas;
        if sample.valid & bits::TARGET_VELOCITY != 0 && sample.valid & bits::RANGE_RATE == 0 {
            sigmas[QUANTITIES_MAX] = 0.0;
        }
        Some(Self {
            time_of_measurement_ns: sample.time_of_measurement_ns,
            sensor_id: sensor_id(sample.source),
            scan: sample.scan,
            detection_id: sample.detection_id,
            kind: DetectionKind::from_code(sample.kind)?,
            values: sample.values,
            range_rate_mps: (sample.valid & bits::RANGE_RATE != 0).then_some(sample.range_rate_mps),
            sigmas: (sample.valid & bits::SIGMAS != 0).then_some(sigmas),
            platform_m: sample.platform_m,
            platform: DetectionPlatform {
                velocity_mps: (sample.valid & (bits::PLATFORM_VELOCITY | bits::TARGET_VELOCITY)
                    == bits::PLATFORM_VELOCITY)
                    .then_some(sample.platform_velocity_mps),
                attitude_rad: (sample.valid & bits::PLATFORM_ATTITUDE != 0).then_some(sample.platform_attitude_rad),
                sigma_m: (sample.valid & bits::PLATFORM_SIGMA != 0).then_some(sample.platform_sigma_m),
                attitude_sigmas_rad: sample.attitude_sigmas_rad,
            },
            height: None,
            velocity,
            reply: TransponderReply {
                identity: sample.identity,
                ages: sample.identity_ages,
                level: (sample.valid & bits::LEVEL != 0).then_some(sample.level),
                level_age_ms: sample.level_age_ms,
            },
            truth: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Quantity;

    #[test]
    fn every_kind_is_found_by_its_word_and_fits() {
        for kind in DetectionKind::ALL {
            assert_eq!(DetectionKind::from_word(kind.word()), Some(kind));
            assert!((1..=QUANTITIES_MAX).contains(&kind.quantities().len()));
        }
        assert_eq!(DetectionKind::from_word("Bearing"), None);
    }

    #[test]
    fn a_sample_holds_a_detection_to_the_last_bit() {
        for kind in DetectionKind::ALL {
            for (range_rate_mps, sigmas) in [(None, None), (Some(-3.5), Some([1.0, 0.1, 0.3, 2.0]))] {
                let detection = Detection {
                    time_of_measurement_ns: 1_700_000_000_123_456_789,
                    sensor_id: 5,
                    scan: 77,
                    detection_id: 3,
                    kind,
                    values: [0.1, 0.2, 1.0 / 3.0],
                    range_rate_mps,
                    sigmas,
                    platform_m: [1.0, 2.0, 3.0],
                    platform: DetectionPlatform {
                        velocity_mps: sigmas.map(|_| [1.5, 2.5, 0.0]),
                        attitude_rad: range_rate_mps.map(|_| [0.1, 0.2, -0.3]),
                        sigma_m: sigmas.map(|_| 4.0),
                        attitude_sigmas_rad: [0.01, 0.02, 0.0],
                    },
                    height: None,
                    velocity: None,
                    reply: TransponderReply {
                        identity: Identity::default().with_address(0x4c_a7b3).with_mode_3a(0o7421),
                        ages: IdentityAges {
                            mode_3a_ms: 4000,
                            ..IdentityAges::default()
                        },
                        level: sigmas.map(|_| -3),
                        level_age_ms: 250,
                    },
                    truth: None,
                };
                let stages = StageTimes {
                    ingested_ns: 9,
                    ..StageTimes::default()
                };
                let sample = detection.sample(4, stages);
                assert_eq!(Detection::of_sample(&sample), Some(detection));
                assert_eq!(sample.stages.ingested_ns, 9);
                // The velocity of a designated target has no field of its own.
                let designation = Detection {
                    range_rate_mps: None,
                    sigmas: sigmas.map(|[a, b, c, _]| [a, b, c, 0.0]),
                    platform: DetectionPlatform::default(),
                    velocity: Some(StatedVelocity {
                        velocity_mps: [-3.5, 8.0],
                        sigma_mps: 0.3,
                    }),
                    ..detection
                };
                let found = Detection::of_sample(&designation.sample(4, stages));
                assert_eq!(found, Some(designation));
                assert_eq!(Detection::of_sample(&SensorDetection { kind: 6, ..sample }), None);
            }
        }
    }

    #[test]
    fn degrees_are_noticed() {
        assert_eq!(Quantity::Bearing.fault(-3.1), None);
        assert!(Quantity::Bearing.fault(270.0).unwrap().contains("radians"));
        assert!(Quantity::Elevation.fault(1.6).unwrap().contains("radians"));
        assert!(Quantity::Range.fault(-0.1).is_some());
        assert_eq!(Quantity::Up.fault(-1e4), None);
    }
}
