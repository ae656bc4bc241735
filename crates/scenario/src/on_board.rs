//! A ship that rolls and turns, with a radar of detections on board (HT-12, EL-11).
//!
//! The ship sails a circle. Its navigation states position, velocity and attitude with errors; its radar, away from the
//! place of the navigation, measures range and bearing in the plane of the rolling deck. The same looks from a radar at
//! rest, with the same total errors, show what the motion costs: each random number is drawn once and scaled for both.
//!
//! The errors of the navigation are new in each state, or change slowly ([`OnBoardSettings::error_time_s`]).

use std::f64::consts::TAU;

use messages::DetectionKind;
use observations::{Detection, DetectionPlatform, DetectionTruth, TransponderReply};
use platform::{Attitude, Mount, State};
use rand::{Rng, RngExt as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Poisson, StandardNormal};
use settings::Degrees;

use crate::random::{Purpose, stream};

/// Share of the period in which the targets are looked at, one after the other.
const LOOKS_SHARE: f64 = 0.8;
/// Number of the only sensor in detections.
const SENSOR_ID: u32 = 1;
const NS_PER_S: f64 = 1e9;
/// Time after which each target turns back, seconds.
const TURNS_BACK_S: f64 = 3600.0;

settings::settings! {
    /// The ship, its radar and its targets.
    #[derive(Copy)]
    pub struct OnBoardSettings {
        /// Targets that cross the sea.
        targets: u32 = 12, in [1, 200];
        /// Spectral density of the targets' accelerations, m²/s³; 0: they keep their velocity.
        acceleration_m2ps3: f64 = 0.02, in [0, 10];
        /// Speed of the ship.
        speed_mps: f64 = 8.0, in [0, 100];
        /// Rate of its turn to the right, per second.
        turn_degps: Degrees = Degrees::of(2.0), in [-30, 30];
        /// Largest roll.
        roll_deg: Degrees = Degrees::of(10.0), in [0, 60];
        /// Period of the roll.
        roll_period_s: f64 = 10.0, in [1, 100];
        /// Largest pitch.
        pitch_deg: Degrees = Degrees::of(3.0), in [0, 45];
        /// Period of the pitch.
        pitch_period_s: f64 = 7.0, in [1, 100];
        /// States of the navigation per second.
        states_per_s: f64 = 10.0, in [0.1, 1000];
        /// Standard deviation of stated heading, pitch and roll.
        attitude_sigma_deg: Degrees = Degrees::of(0.3), in [0.001, 20];
        /// Standard deviation of each coordinate of stated positions.
        position_sigma_m: f64 = 3.0, in [0.001, 1e4];
        /// Time in which the errors of the navigation change; 0: from state to state.
        error_time_s: f64 = 0.0, in [0, 1e4];
        /// Place of the radar, seen from the place of the navigation: forward, right, up.
        lever_arm_m: [f64; 3] = [20.0, 2.0, 15.0], in [-1e3, 1e3];
        /// Period of the radar.
        period_s: f64 = 2.0, in [0.1, 60];
        /// Standard deviation of ranges.
        range_sigma_m: f64 = 20.0, in [0.001, 1e4];
        /// Standard deviation of bearings against the deck.
        bearing_sigma_deg: Degrees = Degrees::of(0.3), in [0.001, 20];
        /// Probability that a look detects its target.
        detection_probability: f64 = 0.95, in [0.01, 1];
        /// Expected false detections per period.
        false_plots_per_period: f64 = 3.0, in [0, 1e4];
        /// Largest range of false detections.
        range_max_m: f64 = 20e3, in [1e3, 1e6];
    }
}

/// State of a target at a whole second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeaTarget {
    /// Time from the start, seconds.
    pub time_s: f64,
    /// Number.
    pub id: u32,
    /// Position east and north, metres; at sea level.
    pub position_m: [f64; 2],
    /// Velocity, metres per second.
    pub velocity_mps: [f64; 2],
}

/// A simulated voyage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Voyage {
    /// States of the ship's navigation.
    pub states: Vec<State>,
    /// Detections of the radar on board, relative to the bow.
    pub on_board: Vec<Detection>,
    /// The same looks from a radar at rest at the origin, relative to north.
    pub at_rest: Vec<Detection>,
    /// Targets at whole seconds.
    pub truth: Vec<SeaTarget>,
}

/// A ship that sails as long as it is asked, for live simulations.
#[derive(Debug)]
pub struct SimulatedShip {
    settings: OnBoardSettings,
    seed: u64,
    paths: Vec<Path>,
    instruments: Instruments,
    /// Number of the next scan.
    scan: u32,
    looked: Voyage,
}

/// The ship's navigation, state by state.
#[derive(Debug)]
struct Instruments {
    random: ChaCha8Rng,
    /// Errors of position, heading, pitch and roll in standard deviations.
    errors: [f64; 6],
    step_s: f64,
    /// Part of the errors that remains from state to state.
    kept: f64,
    /// Number of the next state.
    number: i64,
}

/// Path of a target: positions and velocities second by second, or the start alone of a target that keeps its course.
#[derive(Clone, Debug)]
struct Path(Vec<([f64; 2], [f64; 2])>);

impl Path {
    /// Position and velocity at a time.
    fn at(&self, time_s: f64) -> ([f64; 2], [f64; 2]) {
        // A target turns back before it has left the sea.
        let turned = (time_s / TURNS_BACK_S) as i64 % 2 != 0;
        let since_s = time_s % TURNS_BACK_S;
        let (time_s, way) = if turned {
            (TURNS_BACK_S - since_s, -1.0)
        } else {
            (since_s, 1.0)
        };
        let second = (time_s as usize).min(self.0.len() - 1);
        let (start, velocity) = self.0[second];
        let over_s = time_s - second as f64;
        let position = [0, 1].map(|axis| start[axis] + velocity[axis] * over_s);
        (position, velocity.map(|speed| way * speed))
    }
}

impl OnBoardSettings {
    /// Mounting of the radar.
    pub fn mount(&self) -> Mount {
        Mount {
            lever_arm_m: self.lever_arm_m,
            ..Mount::default()
        }
    }

    /// Simulates the voyage from time 0 to `end_s`. The same seed gives the same numbers.
    pub fn voyage(&self, seed: u64, end_s: f64) -> Voyage {
        let paths = self.paths(seed, end_s + self.period_s);
        let mut voyage = Voyage {
            states: self.states(seed, end_s),
            ..Voyage::default()
        };
        let mut scan = 0;
        while f64::from(scan) * self.period_s < end_s {
            self.scan(seed, scan, &paths, &mut voyage);
            scan += 1;
        }
        for second in 0..=end_s as u32 {
            let time_s = f64::from(second);
            let targets = paths.iter().zip(0..).map(|(path, id)| {
                let (position_m, velocity_mps) = path.at(time_s);
                SeaTarget {
                    time_s,
                    id,
                    position_m,
                    velocity_mps,
                }
            });
            voyage.truth.extend(targets);
        }
        voyage
    }

    /// Paths of the targets until a time.
    fn paths(&self, seed: u64, end_s: f64) -> Vec<Path> {
        let seconds = match self.acceleration_m2ps3 > 0.0 {
            true => end_s.min(TURNS_BACK_S).ceil() as usize,
            false => 0,
        };
        (0..self.targets).map(|id| self.path(seed, id, seconds)).collect()
    }

    fn path(&self, seed: u64, id: u32, seconds: usize) -> Path {
        let mut random = stream(seed, Purpose::Target, 0, u64::from(id), 0);
        let [bearing, course] = [random.random_range(0.0..TAU), random.random_range(0.0..TAU)];
        let (range_m, speed_mps) = (random.random_range(3e3..15e3), random.random_range(4.0..15.0));
        let start = [range_m * bearing.sin(), range_m * bearing.cos()];
        let mut states = vec![(start, [speed_mps * course.sin(), speed_mps * course.cos()])];
        let mut random = stream(seed, Purpose::Target, 1, u64::from(id), 0);
        let step_mps = self.acceleration_m2ps3.sqrt();
        for _ in 0..seconds {
            let (position, velocity) = states[states.len() - 1];
            let position = [0, 1].map(|axis| position[axis] + velocity[axis]);
            states.push((position, velocity.map(|speed| speed + step_mps * normal(&mut random))));
        }
        Path(states)
    }

    /// Position, velocity and attitude of the ship. The circle begins at the origin.
    fn ship(&self, time_s: f64) -> ([f64; 3], [f64; 3], Attitude) {
        let rate = self.turn_degps.rad();
        let heading_rad = rate * time_s;
        let (sin, cos) = heading_rad.sin_cos();
        let [east, north] = match rate.abs() > 1e-9 {
            true => [self.speed_mps / rate * (1.0 - cos), self.speed_mps / rate * sin],
            false => [0.0, self.speed_mps * time_s],
        };
        let attitude = Attitude {
            heading_rad,
            pitch_rad: self.pitch_deg.rad() * (TAU * time_s / self.pitch_period_s).sin(),
            roll_rad: self.roll_deg.rad() * (TAU * time_s / self.roll_period_s).sin(),
        };
        (
            [east, north, 0.0],
            [self.speed_mps * sin, self.speed_mps * cos, 0.0],
            attitude,
        )
    }

    fn states(&self, seed: u64, end_s: f64) -> Vec<State> {
        // The first and the last state lie outside of the scans.
        let count = ((end_s + self.period_s) * self.states_per_s).ceil() as usize + 2;
        let mut navigation = Instruments::new(self, seed);
        (0..count).map(|_| navigation.next(self)).collect()
    }

    /// Looks at each target once, and draws false detections.
    fn scan(&self, seed: u64, scan: u32, paths: &[Path], voyage: &mut Voyage) {
        let begin_s = f64::from(scan) * self.period_s;
        let (range_sigma_m, bearing_sigma) = (self.range_sigma_m, self.bearing_sigma_deg.rad());
        let mut number = 0;
        for (path, id) in paths.iter().zip(0u32..) {
            let mut random = stream(seed, Purpose::Look, 0, scan.into(), id.into());
            let [off_range, off_bearing] = [normal(&mut random), normal(&mut random)];
            if !random.random_bool(self.detection_probability) {
                continue;
            }
            let time_s = begin_s + LOOKS_SHARE * self.period_s * f64::from(id) / paths.len() as f64;
            let ([east, north], _) = path.at(time_s);
            let (position, _, attitude) = self.ship(time_s);
            let [forward, right, up] = self.lever_arm_m;
            let arm = attitude.to_world([right, forward, up]);
            let line = [0, 1, 2].map(|axis| [east, north, 0.0][axis] - position[axis] - arm[axis]);
            let [x, y, z] = attitude.to_body(line);
            let seen = [
                x.hypot(y).hypot(z) + range_sigma_m * off_range,
                x.atan2(y) + bearing_sigma * off_bearing,
            ];
            let truth = DetectionTruth::Target(id);
            let on_board = detection(time_s, (scan, number), seen, [range_sigma_m, bearing_sigma], truth);
            voyage.on_board.push(on_board);

            let distance = east.hypot(north);
            let sigmas = [
                range_sigma_m.hypot(self.position_sigma_m),
                bearing_sigma
                    .hypot(self.attitude_sigma_deg.rad())
                    .hypot(self.position_sigma_m / distance),
            ];
            let seen = [
                distance.hypot(up) + sigmas[0] * off_range,
                east.atan2(north) + sigmas[1] * off_bearing,
            ];
            voyage.at_rest.push(Detection {
                platform_m: [0.0, 0.0, up],
                ..detection(time_s, (scan, number), seen, sigmas, truth)
            });
            number += 1;
        }
        let mut random = stream(seed, Purpose::FalsePlots, 0, scan.into(), 0);
        // A mean of zero has no distribution, and no detections.
        let Ok(poisson) = Poisson::new(self.false_plots_per_period) else {
            return;
        };
        let count = poisson.sample(&mut random) as u32;
        for _ in 0..count {
            let time_s = begin_s + LOOKS_SHARE * self.period_s * random.random_range(0.0..1.0);
            let range_m = self.range_max_m * random.random_range(0.0..1.0f64).sqrt();
            let seen = [range_m, random.random_range(-3.1..3.1)];
            let found = |sigmas| detection(time_s, (scan, number), seen, sigmas, DetectionTruth::FalseAlarm);
            voyage.on_board.push(found([range_sigma_m, bearing_sigma]));
            let at_rest = found([range_sigma_m, bearing_sigma.hypot(self.attitude_sigma_deg.rad())]);
            voyage.at_rest.push(Detection {
                platform_m: [0.0, 0.0, self.lever_arm_m[2]],
                ..at_rest
            });
            number += 1;
        }
    }
}

impl Instruments {
    fn new(settings: &OnBoardSettings, seed: u64) -> Self {
        let mut random = stream(seed, Purpose::Navigation, 0, 0, 0);
        let errors = std::array::from_fn(|_| normal(&mut random));
        let step_s = 1.0 / settings.states_per_s;
        let kept = match settings.error_time_s > 0.0 {
            true => (-step_s / settings.error_time_s).exp(),
            false => 0.0,
        };
        Self {
            random,
            errors,
            step_s,
            kept,
            number: -1,
        }
    }

    fn next_s(&self) -> f64 {
        self.number as f64 * self.step_s
    }

    fn next(&mut self, settings: &OnBoardSettings) -> State {
        let time_s = self.next_s();
        self.number += 1;
        let renewed = (1.0 - self.kept * self.kept).sqrt();
        let random = &mut self.random;
        self.errors = self.errors.map(|error| self.kept * error + renewed * normal(random));
        let errors = &self.errors;
        let (position, velocity, attitude) = settings.ship(time_s);
        let (sigma_m, sigma_rad) = (settings.position_sigma_m, settings.attitude_sigma_deg.rad());
        State {
            time_ns: (time_s * NS_PER_S).round() as i64,
            position_m: Some(std::array::from_fn(|axis| position[axis] + sigma_m * errors[axis])),
            velocity_mps: Some(velocity),
            heading_rad: Some((attitude.heading_rad + sigma_rad * errors[3]).rem_euclid(TAU)),
            tilt_rad: Some([
                attitude.pitch_rad + sigma_rad * errors[4],
                attitude.roll_rad + sigma_rad * errors[5],
            ]),
            position_sigma_m: Some(sigma_m),
            velocity_sigma_mps: Some(0.1),
            heading_sigma_rad: Some(sigma_rad),
            tilt_sigmas_rad: Some([sigma_rad; 2]),
        }
    }
}

impl SimulatedShip {
    /// The ship of these settings at time 0.
    pub fn new(settings: OnBoardSettings, seed: u64) -> Self {
        Self {
            settings,
            seed,
            paths: settings.paths(seed, TURNS_BACK_S),
            instruments: Instruments::new(&settings, seed),
            scan: 0,
            looked: Voyage::default(),
        }
    }

    /// Continues at `time_s`.
    pub fn restart_at(&mut self, time_s: f64) {
        // Errors of the navigation that change slowly go on from where they would be.
        while self.instruments.next_s() < time_s {
            self.instruments.next(&self.settings);
        }
        self.scan = (time_s / self.settings.period_s).ceil().max(0.0) as u32;
    }

    /// Time of the next state or complete scan, seconds.
    pub fn due_s(&self) -> f64 {
        self.instruments.next_s().min(self.scan_done_s())
    }

    /// The state, if it is next.
    pub fn next_state(&mut self) -> Option<State> {
        let is_next = self.instruments.next_s() <= self.scan_done_s();
        is_next.then(|| self.instruments.next(&self.settings))
    }

    /// Detections of the radar in its next scan, relative to the bow, in the order of their times.
    pub fn next_scan(&mut self) -> &[Detection] {
        self.looked.on_board.clear();
        self.looked.at_rest.clear();
        self.settings.scan(self.seed, self.scan, &self.paths, &mut self.looked);
        self.scan += 1;
        self.looked
            .on_board
            .sort_by_key(|detection| detection.time_of_measurement_ns);
        &self.looked.on_board
    }

    fn scan_done_s(&self) -> f64 {
        (f64::from(self.scan) + LOOKS_SHARE) * self.settings.period_s
    }
}

fn normal(random: &mut impl Rng) -> f64 {
    StandardNormal.sample(random)
}

fn detection(
    time_s: f64,
    (scan, detection_id): (u32, u32),
    [range_m, bearing_rad]: [f64; 2],
    sigmas: [f64; 2],
    truth: DetectionTruth,
) -> Detection {
    Detection {
        time_of_measurement_ns: (time_s * NS_PER_S).round() as i64,
        sensor_id: SENSOR_ID,
        scan,
        detection_id,
        kind: DetectionKind::RangeBearing,
        values: [range_m.max(0.0), bearing_rad, 0.0],
        range_rate_mps: None,
        sigmas: Some([sigmas[0], sigmas[1], 0.0, 0.0]),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: Some(truth),
    }
}

#[cfg(test)]
mod tests {
    use platform::{Assumed, History};

    use super::*;

    /// A ship that is asked step by step sends what the whole voyage has, also after a restart.
    #[test]
    fn a_ship_step_by_step_is_the_whole_voyage() {
        let settings = OnBoardSettings::default();
        let voyage = settings.voyage(5, 30.0);
        let mut ship = SimulatedShip::new(settings, 5);
        let (mut states, mut detections) = (Vec::new(), Vec::new());
        while ship.due_s() < 30.0 {
            match ship.next_state() {
                Some(state) => states.push(state),
                None => detections.extend_from_slice(ship.next_scan()),
            }
        }
        assert_eq!(states[..], voyage.states[..states.len()]);
        assert_eq!(states.len(), 301);
        let mut expected = voyage.on_board;
        expected.sort_by_key(|detection| (detection.scan, detection.time_of_measurement_ns));
        assert_eq!(detections, expected);
        let mut again = SimulatedShip::new(settings, 5);
        again.restart_at(12.0);
        assert_eq!(again.next_state(), Some(states[121]));
        assert!(again.next_scan().iter().all(|detection| detection.scan == 6));
    }

    /// Carried into the system's terms, the detections on board lie at the targets, with the stated errors.
    #[test]
    fn detections_on_board_lie_at_their_targets() {
        let settings = OnBoardSettings::default();
        let voyage = settings.voyage(3, 120.0);
        assert_eq!(voyage, settings.voyage(3, 120.0));
        assert_eq!(voyage.on_board.len(), voyage.at_rest.len());
        let mut history = History::new(Assumed::default(), voyage.states.len());
        for state in &voyage.states {
            history.add(state);
        }
        let paths = settings.paths(3, 122.0);
        let (mut sum, mut rest, mut count) = ([0.0; 2], [0.0; 2], 0.0);
        for (measured, still) in voyage.on_board.iter().zip(&voyage.at_rest) {
            let Some(DetectionTruth::Target(id)) = measured.truth else {
                continue;
            };
            let time_s = measured.time_of_measurement_ns as f64 / NS_PER_S;
            let (target, _) = paths[id as usize].at(time_s);
            let pose = history.at(measured.time_of_measurement_ns).unwrap();
            let carried = settings.mount().carry(measured, &pose, None, None).unwrap().detection;
            for (detection, sum) in [(&carried, &mut sum), (still, &mut rest)] {
                let line = [0, 1].map(|axis| target[axis] - detection.platform_m[axis]);
                let range_m = line[0].hypot(line[1]).hypot(detection.platform_m[2]);
                let off = detection.values[1] - line[0].atan2(line[1]);
                let off = (off + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
                let sigmas = detection.sigmas.unwrap();
                sum[0] += ((detection.values[0] - range_m) / sigmas[0]).powi(2);
                sum[1] += (off / sigmas[1]).powi(2);
            }
            count += 1.0;
        }
        for (carried, still) in sum.iter().zip(rest) {
            // Between two states with independent errors, the errors are smaller than stated.
            assert!((0.7..1.15).contains(&(carried / count)), "{}", carried / count);
            assert!((0.85..1.15).contains(&(still / count)), "{}", still / count);
        }
    }

    #[test]
    fn a_ship_pitches_rolls_and_reports_as_stated() {
        let settings = OnBoardSettings {
            pitch_deg: Degrees::of(6.0),
            pitch_period_s: 8.0,
            roll_deg: Degrees::of(10.0),
            roll_period_s: 20.0,
            states_per_s: 4.0,
            ..OnBoardSettings::default()
        };
        let tilt_deg = |time_s| {
            let (_, _, attitude) = settings.ship(time_s);
            [attitude.pitch_rad, attitude.roll_rad].map(|angle: f64| (angle.to_degrees() * 1e6).round() / 1e6)
        };
        assert_eq!((tilt_deg(2.0)[0], tilt_deg(6.0)[0]), (6.0, -6.0));
        assert_eq!((tilt_deg(5.0)[1], tilt_deg(15.0)[1]), (10.0, -10.0));
        let times_ns: Vec<i64> = settings.states(1, 5.0).iter().map(|state| state.time_ns).collect();
        assert!(
            times_ns.windows(2).all(|pair| pair[1] - pair[0] == 250_000_000),
            "{times_ns:?}"
        );
    }
}
