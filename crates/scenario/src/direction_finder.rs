//! Simulated direction finder: an aircraft on a racetrack that measures bearings of transmitters.
//!
//! The flight begins with a leg. The finder measures bearings only; its own position and heading are exact. Some
//! targets carry a transmitter, each on its own frequency, and the finder distinguishes all transmitters. All bearings
//! of a period are measured at one time. A bearing is the true bearing with a normal error. A finder with an antenna
//! array delivers snapshots instead ([`ArrayGeometry`]): one measurement for each transmitter, at its frequency.

use std::f64::consts::TAU;

use messages::NS_PER_S;
use observations::{Bearing, SnapshotBlock};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use settings::SettingsError;

use crate::path::{ClosedPath, Kinematics, Waypoint};
use crate::random::{Purpose, stream};
use crate::simulated_array::ArrayGeometry;
use crate::target::TargetState;
use crate::truth::Truth;

/// Lateral acceleration of the platform in turns, m/s² (25° of bank).
const TURN_ACCELERATION_MPS2: f64 = 4.57;
/// Frequencies of the transmitters, hertz: maritime and airborne radars.
const FREQUENCIES_HZ: std::ops::Range<f64> = 2.9e9..9.5e9;

settings::settings! {
    /// A simulated direction finder.
    pub struct DirectionFinderSettings {
        /// Middle of the racetrack and its height: east, north, up.
        position_m: [f64; 3] = [0.0, 0.0, 3000.0], in [-1e6, 1e6];
        /// Direction of the racetrack's legs, clockwise from north.
        course_rad: f64 = 0.0, in [-7, 7];
        /// Length of the legs.
        leg_m: f64 = 40_000.0, in [0, 1e6];
        /// Speed of the platform.
        speed_mps: f64 = 120.0, in [10, 400];
        /// Time between two bearings of a transmitter.
        period_s: f64 = 1.0, in [0.01, 60];
        /// Time from a measurement to its delivery.
        delay_s: f64 = 0.02, in [0, 60];
        /// Standard deviation of a bearing.
        bearing_sigma_rad: f64 = 0.0087, in [1e-5, 0.5];
        /// Constant bias of every bearing.
        bearing_bias_rad: f64 = 0.0, in [-0.5, 0.5];
        /// Probability of receiving a transmitter in a period.
        detection_probability: f64 = 0.9, in [1e-3, 1];
        /// Greatest distance of a received transmitter in the plane.
        range_max_m: f64 = 200_000.0, in [1, 2e6];
        /// Greatest height of a received transmitter; 100 for ships and vehicles alone.
        height_max_m: f64 = 1e6, in [-1e4, 1e6];
        /// Share of the targets that transmit.
        transmitting_share: f64 = 1.0, in [0, 1];
        /// Standard deviation of a measured frequency.
        frequency_sigma_hz: f64 = 1e6, in [0, 1e9];
        /// With `[source.array]`: number of snapshots of a transmitter in a period.
        snapshots: u32 = 100, in [1, 4000];
        /// With `[source.array]`: power of a transmitter at one antenna over that of the noise.
        snr_db: f64 = 10.0, in [-60, 100];
    }
}

impl DirectionFinderSettings {
    fn turn_radius_m(&self) -> f64 {
        self.speed_mps.powi(2) / TURN_ACCELERATION_MPS2
    }

    /// Returns the duration of the quarter turn at the start of the path: the platform has completed this turn at
    /// the scenario's start.
    fn first_turn_s(&self) -> f64 {
        std::f64::consts::FRAC_PI_2 * self.turn_radius_m() / self.speed_mps
    }

    /// Returns the path of two legs; their distance is that of two turns.
    fn path(&self) -> ClosedPath {
        let turn_radius_m = self.turn_radius_m();
        let (sin, cos) = self.course_rad.sin_cos();
        let half_length_m = 0.5 * self.leg_m + turn_radius_m;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[along, across]| {
            let (along_m, right_m) = (along * half_length_m, across * turn_radius_m);
            Waypoint {
                position_m: [
                    self.position_m[0] + along_m * sin + right_m * cos,
                    self.position_m[1] + along_m * cos - right_m * sin,
                ],
                height_m: self.position_m[2],
                speed_mps: self.speed_mps,
                turn_radius_m,
                stop_s: 0.0,
            }
        });
        ClosedPath::new(&corners)
    }
}

/// Position, velocity and heading of a platform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformPose {
    /// East, north, up, metres.
    pub position_m: [f64; 3],
    /// East, north, up, metres per second.
    pub velocity_mps: [f64; 3],
    /// Radians clockwise from north, 0 to 2π.
    pub heading_rad: f64,
}

/// Simulated direction finder, see the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedDirectionFinder {
    settings: DirectionFinderSettings,
    path: ClosedPath,
    seed: u64,
    source: u16,
    start_utc_ns: i64,
    /// Number of the next period.
    period: u64,
    /// Number of the next measurement of an array.
    measurement: u32,
}

/// Transmitter that the finder receives.
#[derive(Clone, Copy, Debug)]
struct Received {
    id: u32,
    /// True bearing with the finder's bias, radians clockwise from north.
    bearing_rad: f64,
    frequency_hz: f64,
}

impl SimulatedDirectionFinder {
    /// Creates a finder that starts at the scenario's start `start_utc_ns` (UTC, nanoseconds since 1970), as source
    /// number `source`.
    ///
    /// # Errors
    /// An invalid setting.
    pub fn new(
        settings: &DirectionFinderSettings,
        seed: u64,
        source: u16,
        start_utc_ns: i64,
    ) -> Result<Self, SettingsError> {
        settings::check(settings)?;
        Ok(Self {
            path: settings.path(),
            settings: settings.clone(),
            seed,
            source,
            start_utc_ns,
            period: 0,
            measurement: 0,
        })
    }

    /// Restarts with the first delivery at or after `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        self.period = ((time_s - self.settings.delay_s) / self.settings.period_s)
            .ceil()
            .max(0.0) as u64;
    }

    /// Returns the time of the next delivery, seconds from the scenario's start.
    pub fn next_delivery_s(&self) -> f64 {
        self.measured_s() + self.settings.delay_s
    }

    /// Returns the measurement time of the next delivery's bearings, seconds from the scenario's start.
    pub fn measured_s(&self) -> f64 {
        self.period as f64 * self.settings.period_s
    }

    /// Returns the platform's pose `time_s` seconds after the scenario's start.
    pub fn platform_at(&self, time_s: f64) -> PlatformPose {
        let Kinematics {
            position_m,
            velocity_mps,
        } = self.path.at(time_s + self.settings.first_turn_s());
        PlatformPose {
            position_m,
            velocity_mps,
            heading_rad: velocity_mps[0].atan2(velocity_mps[1]).rem_euclid(TAU),
        }
    }

    /// Whether `target` carries a transmitter.
    pub fn transmits(&self, target: &TargetState) -> bool {
        self.transmitter(target.id).is_some()
    }

    /// Appends the bearings of the next delivery, in the order of the target numbers (which are also the
    /// transmitter numbers), and advances to the next delivery.
    pub fn listen(&mut self, truth: &Truth, out: &mut Vec<Bearing>) {
        let (platform, time_of_measurement_ns) = self.present();
        let settings = &self.settings;
        self.each_received(truth, &platform, |received, random| {
            let errors: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(random));
            let bearing_rad = received.bearing_rad + settings.bearing_sigma_rad * errors[0];
            out.push(Bearing {
                time_of_measurement_ns,
                emitter_id: Some(received.id),
                bearing_rad: bearing_rad.rem_euclid(TAU),
                sigma_rad: settings.bearing_sigma_rad,
                platform_m: platform.position_m,
                heading_rad: Some(platform.heading_rad),
                frequency_hz: Some(received.frequency_hz + settings.frequency_sigma_hz * errors[1]),
                pulse_interval_s: None,
            });
        });
        self.period += 1;
    }

    /// Appends the snapshots of the next delivery at an array, each block a whole measurement, in the order of the
    /// target numbers, and advances to the next delivery. Measurements of one period are a microsecond apart, since
    /// each is later than the one before.
    pub fn take_snapshots(&mut self, array: &ArrayGeometry, truth: &Truth, out: &mut Vec<SnapshotBlock>) {
        let (platform, mut time_ns) = self.present();
        let (settings, mut measurement) = (&self.settings, self.measurement);
        let amplitude = 10.0_f64.powf(settings.snr_db / 20.0);
        self.each_received(truth, &platform, |received, random| {
            let direction_rad = received.bearing_rad - platform.heading_rad - array.forward_rad;
            if !array.receives(direction_rad, received.frequency_hz) {
                return;
            }
            let error: f64 = StandardNormal.sample(random);
            let mut samples = Vec::with_capacity(settings.snapshots as usize * array.antennas_m.len());
            let wave = (direction_rad, received.frequency_hz, amplitude);
            array.measure(wave, settings.snapshots, random, &mut samples);
            out.push(SnapshotBlock {
                time_ns,
                measurement,
                total: settings.snapshots,
                first: 0,
                antennas: array.antennas_m.len() as u16,
                frequency_hz: received.frequency_hz + settings.frequency_sigma_hz * error,
                platform_m: Some(platform.position_m),
                heading_rad: Some(platform.heading_rad),
                samples,
            });
            time_ns += 1_000;
            measurement = measurement.wrapping_add(1);
        });
        self.measurement = measurement;
        self.period += 1;
    }

    /// Pose of the platform and time (UTC, nanoseconds) of the next delivery's measurements.
    fn present(&self) -> (PlatformPose, i64) {
        let time_s = self.measured_s();
        let time_ns = self.start_utc_ns + (time_s * NS_PER_S).round() as i64;
        (self.platform_at(time_s), time_ns)
    }

    /// Passes the transmitters received in the next delivery to `each`, with the random numbers of their measurement.
    fn each_received(&self, truth: &Truth, platform: &PlatformPose, mut each: impl FnMut(Received, &mut ChaCha8Rng)) {
        let settings = &self.settings;
        for target in truth.at(self.measured_s()) {
            let [east, north] = [0, 1].map(|axis| target.position_m[axis] - platform.position_m[axis]);
            let Some(frequency_hz) = self.transmitter(target.id) else {
                continue;
            };
            let mut random = stream(
                self.seed,
                Purpose::Bearing,
                self.source,
                u64::from(target.id),
                self.period,
            );
            let is_in_reach =
                east.hypot(north) <= settings.range_max_m && target.position_m[2] <= settings.height_max_m;
            if !is_in_reach || !random.random_bool(settings.detection_probability) {
                continue;
            }
            let received = Received {
                id: target.id,
                bearing_rad: east.atan2(north) + settings.bearing_bias_rad,
                frequency_hz,
            };
            each(received, &mut random);
        }
    }

    /// Returns the frequency of the target's transmitter, if any; the same for every finder.
    fn transmitter(&self, target: u32) -> Option<f64> {
        let mut random = stream(self.seed, Purpose::Transmitter, 0, u64::from(target), 0);
        let (share, frequency_hz) = (random.random_range(0.0..1.0), random.random_range(FREQUENCIES_HZ));
        (share < self.settings.transmitting_share).then_some(frequency_hz)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::settings::ScenarioSettings;

    fn truth() -> Truth {
        let settings = ScenarioSettings {
            targets: 12,
            ship_share: 1.0,
            ..ScenarioSettings::without_others()
        };
        Truth::new(&settings, 3).expect("valid")
    }

    fn finder(settings: &DirectionFinderSettings) -> SimulatedDirectionFinder {
        SimulatedDirectionFinder::new(settings, 3, 5, 1_000).expect("valid")
    }

    /// Errors are normal with the stated deviation about the true bearing from the platform's reported position.
    #[test]
    fn bearings_are_as_stated() {
        let (truth, settings) = (truth(), DirectionFinderSettings::default());
        let mut finder = finder(&settings);
        let (mut out, mut squares, mut count) = (Vec::new(), 0.0, 0);
        for period in 0..2000u32 {
            let time_s = finder.measured_s();
            assert_eq!(
                (time_s, finder.next_delivery_s()),
                (f64::from(period), f64::from(period) + 0.02)
            );
            out.clear();
            finder.listen(&truth, &mut out);
            for bearing in &out {
                assert_eq!(
                    bearing.time_of_measurement_ns,
                    1_000 + i64::from(period) * 1_000_000_000
                );
                let target = truth.target_at(bearing.emitter_id.expect("known") as usize, time_s);
                let [east, north] = [0, 1].map(|axis| target.position_m[axis] - bearing.platform_m[axis]);
                let error = (bearing.bearing_rad - east.atan2(north) + PI).rem_euclid(TAU) - PI;
                squares += (error / bearing.sigma_rad).powi(2);
                count += 1;
            }
        }
        let (mean, four_sigma) = (squares / f64::from(count), 4.0 * (2.0 / f64::from(count)).sqrt());
        assert!((mean - 1.0).abs() < four_sigma, "{mean}");
        let share = f64::from(count) / (2000.0 * 12.0);
        assert!((share - 0.9).abs() < 0.02, "heard {share}");
    }

    #[test]
    fn the_platform_flies_its_racetrack() {
        let settings = DirectionFinderSettings {
            course_rad: 0.5 * PI,
            ..DirectionFinderSettings::default()
        };
        let finder = finder(&settings);
        let mut headings = [0; 2];
        for step in 0..2000 {
            let pose = finder.platform_at(f64::from(step));
            let speed = pose.velocity_mps[0].hypot(pose.velocity_mps[1]);
            assert!((speed - 120.0).abs() < 1e-9);
            assert_eq!(pose.position_m[2], 3000.0);
            let [east, north] = [pose.position_m[0], pose.position_m[1]];
            assert!(east.abs() <= 23_152.0 && north.abs() <= 3_152.0, "{pose:?}");
            for (heading, count) in [0.5 * PI, 1.5 * PI].iter().zip(&mut headings) {
                *count += u32::from((pose.heading_rad - heading).abs() < 1e-9);
            }
        }
        assert!(headings.iter().all(|&count| count > 600), "east and west: {headings:?}");
    }

    /// A finder started in mid-scenario measures the same as a finder that ran throughout.
    #[test]
    fn restarted_it_measures_the_same() {
        let (truth, settings) = (truth(), DirectionFinderSettings::default());
        let (mut through, mut restarted) = (finder(&settings), finder(&settings));
        let mut all = Vec::new();
        for _ in 0..50 {
            all.clear();
            through.listen(&truth, &mut all);
        }
        restarted.restart_at(48.9);
        assert_eq!(restarted.measured_s(), 49.0);
        let mut again = Vec::new();
        restarted.listen(&truth, &mut again);
        assert_eq!(all, again);
    }

    /// The mean of the errors of bearings is the bias; frequencies scatter by their standard deviation.
    #[test]
    fn bias_and_scatter_of_frequency_are_as_set() {
        let truth = truth();
        let errors = |bearing_bias_rad: f64, frequency_sigma_hz: f64| {
            let settings = DirectionFinderSettings {
                bearing_bias_rad,
                frequency_sigma_hz,
                ..DirectionFinderSettings::default()
            };
            let mut finder = finder(&settings);
            let (mut out, mut bias, mut squares, mut count) = (Vec::new(), 0.0, 0.0, 0.0);
            for _ in 0..500 {
                let time_s = finder.measured_s();
                out.clear();
                finder.listen(&truth, &mut out);
                for bearing in &out {
                    let number = bearing.emitter_id.expect("known");
                    let target = truth.target_at(number as usize, time_s);
                    let [east, north] = [0, 1].map(|axis| target.position_m[axis] - bearing.platform_m[axis]);
                    bias += (bearing.bearing_rad - east.atan2(north) + PI).rem_euclid(TAU) - PI;
                    let exact_hz = finder.transmitter(target.id).expect("transmits");
                    squares += (bearing.frequency_hz.expect("measured") - exact_hz).powi(2);
                    count += 1.0;
                }
            }
            assert!(count > 4000.0, "{count}");
            (bias / count, (squares / count).sqrt())
        };
        let (bias_rad, sigma_hz) = errors(0.05, 2e6);
        assert!((bias_rad - 0.05).abs() < 6e-4, "{bias_rad}");
        assert!((sigma_hz / 2e6 - 1.0).abs() < 0.05, "{sigma_hz}");
        let (bias_rad, sigma_hz) = errors(0.0, 0.0);
        assert!(bias_rad.abs() < 6e-4 && sigma_hz == 0.0, "{bias_rad}, {sigma_hz}");
    }

    /// Two antennas: the phase between their samples shows the direction, and the seed every sample.
    #[test]
    fn snapshots_show_the_direction_of_each_transmitter_in_the_sector() {
        let (truth, settings) = (
            truth(),
            DirectionFinderSettings {
                course_rad: 1.0,
                snr_db: 60.0,
                frequency_sigma_hz: 0.0,
                detection_probability: 1.0,
                ..DirectionFinderSettings::default()
            },
        );
        let array = ArrayGeometry {
            antennas_m: vec![[0.0, 0.0], [0.01, 0.0]],
            forward_rad: 0.5 * PI,
            sector_rad: [-0.5 * PI, 0.5 * PI],
            frequency_max_hz: 8e9,
        };
        let (mut finder, mut again) = (finder(&settings), finder(&settings));
        let (mut bearings, mut blocks, mut same) = (Vec::new(), Vec::new(), Vec::new());
        finder.clone().listen(&truth, &mut bearings);
        finder.take_snapshots(&array, &truth, &mut blocks);
        again.take_snapshots(&array, &truth, &mut same);
        assert_eq!(blocks, same);
        assert_eq!(finder.measured_s(), 1.0);
        let platform = again.platform_at(0.0);
        let in_sector = bearings.iter().filter(|bearing| {
            let target = truth.target_at(bearing.emitter_id.expect("known") as usize, 0.0);
            let [east, north] = [0, 1].map(|axis| target.position_m[axis] - platform.position_m[axis]);
            // The array looks to the right.
            let right_rad = east.atan2(north) - platform.heading_rad;
            right_rad.sin() >= 0.0 && bearing.frequency_hz.expect("measured") <= 8e9
        });
        assert_eq!(blocks.len(), in_sector.clone().count());
        assert!((2..bearings.len()).contains(&blocks.len()), "{}", blocks.len());
        for (number, (block, bearing)) in blocks.iter().zip(in_sector).enumerate() {
            assert_eq!(
                (block.measurement, block.time_ns),
                (number as u32, 1_000 + 1_000 * number as i64)
            );
            assert_eq!((block.total, block.samples.len()), (100, 200));
            let target = truth.target_at(bearing.emitter_id.expect("known") as usize, 0.0);
            let [east, north] = [0, 1].map(|axis| target.position_m[axis] - platform.position_m[axis]);
            let direction_rad = east.atan2(north) - platform.heading_rad - array.forward_rad;
            let expected_rad = TAU * block.frequency_hz / 299_792_458.0 * 0.01 * direction_rad.sin();
            for pair in block.samples.chunks(2) {
                let [a, b] = [pair[0], pair[1]].map(|[re, im]| f64::from(im).atan2(f64::from(re)));
                // A weak sample of the signal has a large error of phase.
                if f64::from(pair[0][0]).hypot(f64::from(pair[0][1])) > 500.0 {
                    assert!((b - a - expected_rad).sin().abs() < 0.02, "{} of {expected_rad}", b - a);
                }
            }
        }
    }

    #[test]
    fn some_targets_are_silent() {
        let truth = truth();
        let settings = DirectionFinderSettings {
            transmitting_share: 0.5,
            detection_probability: 1.0,
            ..DirectionFinderSettings::default()
        };
        let mut finder = finder(&settings);
        let transmitting = truth.at(0.0).filter(|target| finder.transmits(target)).count();
        let mut out = Vec::new();
        finder.listen(&truth, &mut out);
        assert!((1..12).contains(&transmitting), "{transmitting}");
        assert_eq!(out.len(), transmitting);
    }

    #[test]
    fn messages_name_key_value_and_limit() {
        let read = |text: &str| {
            let document = settings::Document::parse(text, &[]).expect("well-formed");
            document
                .read::<DirectionFinderSettings>()
                .expect_err("not usable")
                .to_string()
        };
        assert_eq!(
            read("speed_mps = 0"),
            "speed_mps: 0 is out of range; it must lie between 10 and 400"
        );
        assert_eq!(
            read("bearing_sigma_rad = nan"),
            "bearing_sigma_rad: NaN is out of range; it must lie between 0.00001 and 0.5"
        );
        assert!(read("sigma = 1").starts_with("sigma: unknown key"));
    }
}
