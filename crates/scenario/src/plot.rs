//! Plots: detections of a sensor before its own tracking.
//!
//! Plots replace a sensor's tracks as input of a tracker under test. A plot carries no information about earlier
//! looks; only the truth identifies the target.

use messages::Identity;
use observations::DetectionTruth as Of;
use rand::RngExt as _;
use rand_distr::{Distribution as _, Poisson};

use crate::measurement::SimulatedMeasurement;
use crate::random::{Purpose, stream};
use crate::schedule::Slot;
use crate::sensor_settings::{CheckedSensor, MeasurementErrors, PlaneErrors};

/// One detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarPlot {
    /// Time of measurement, UTC, nanoseconds since 1970.
    pub time_of_measurement_ns: i64,
    /// Number of the sensor's period (a radar's turn), from 0.
    pub scan: u64,
    /// Truth of the plot.
    pub of: Of,
    /// Measured position: east, north, up, metres; up is 0 without a height.
    pub position_m: [f64; 3],
    /// Standard deviations of the position as stated by the sensor, metres; 0 for an unmeasured height.
    pub sigma_m: [f64; 3],
    /// Whether height was measured.
    pub height: bool,
    /// Position of the sensor: east, north, up, metres.
    pub site_m: [f64; 3],
    /// For a radar: standard deviations of range, metres, and azimuth, radians.
    pub polar_sigma: Option<[f64; 2]>,
    /// Identity in the transponder's reply.
    pub identity: Identity,
    /// Level in the transponder's reply, in steps of 25 feet; `None` of a radar that receives no replies.
    pub level: Option<i16>,
}

impl RadarPlot {
    pub(crate) fn new(
        (time_of_measurement_ns, scan): (i64, u64),
        of: Of,
        found: &SimulatedMeasurement,
        site_m: [f64; 3],
        errors: &MeasurementErrors,
    ) -> Self {
        Self {
            time_of_measurement_ns,
            scan,
            of,
            position_m: found.position_m,
            sigma_m: [0, 3, 5].map(|place| found.covariance_m2[place].sqrt()),
            height: found.height,
            site_m,
            polar_sigma: match errors.plane {
                PlaneErrors::Polar {
                    range_sigma_m,
                    azimuth_sigma_rad,
                    ..
                } => Some([range_sigma_m, azimuth_sigma_rad]),
                PlaneErrors::Cartesian { .. } => None,
            },
            identity: Identity::default(),
            level: None,
        }
    }

    /// Draws the false plots of a radar in one delivery: anywhere in its coverage, without a reply and so without a
    /// height.
    pub(crate) fn false_ones(
        settings: &CheckedSensor,
        (seed, source): (u64, u16),
        slot: &Slot,
        mut each: impl FnMut(f64, SimulatedMeasurement),
    ) {
        let (schedule, coverage) = (&settings.schedule, &settings.coverage);
        let mean = settings.false_plots_per_period / f64::from(schedule.deliveries);
        // A mean of zero has no distribution, and no plots.
        let Ok(poisson) = Poisson::new(mean) else { return };
        let mut random = stream(seed, Purpose::FalsePlots, source, slot.number, 0);
        let count = poisson.sample(&mut random) as usize;
        for _ in 0..count {
            let time_s = slot.time_within_s(random.random_range(0.0..1.0));
            let turned = (time_s - schedule.phase_s) / schedule.period_s;
            let (sin, cos) = (std::f64::consts::TAU * turned.fract()).sin_cos();
            let range = coverage.range_max_m * random.random_range(0.0..1.0f64).sqrt();
            let [east, north, _] = coverage.position_m;
            let place = [east + range * sin, north + range * cos, 0.0];
            let mut found = settings.errors.measure(coverage.position_m, place, &mut random);
            (found.height, found.position_m[2], found.covariance_m2[5]) = (false, 0.0, 0.0);
            each(time_s, found);
        }
    }

    /// Returns the range in the plane, metres, and the azimuth from the sensor, radians clockwise from north, 0 to
    /// 2π.
    pub fn polar(&self) -> [f64; 2] {
        let [east, north] = [0, 1].map(|axis| self.position_m[axis] - self.site_m[axis]);
        [east.hypot(north), east.atan2(north).rem_euclid(std::f64::consts::TAU)]
    }
}
