//! Simulated wide-area sensor: distant, coarse, slow and late, but with the number of targets (WA-2).
//!
//! The sensor watches a circle. Once per period, the sensor reports each group of targets unresolved in position:
//! the group's middle and velocity, with large errors, and its count. The count is available because the sensor has
//! watched the targets since they were apart. A report may include the position of the first sighting. For a
//! limited time, the sensor reports zero targets at the expected position of a vanished group. There is no report
//! of absence near the edge of the circle, because a group there may have left.
//!
//! Simplifications: the sensor never confuses targets, and a wrong count is off by one, never down to zero.

use messages::NS_PER_S;
use observations::WideAreaReport;
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use settings::SettingsError;

use crate::grouping::groups;
use crate::random::{Purpose, stream};
use crate::sensor_settings::phase_within;
use crate::target::TargetState;
use crate::truth::Truth;

/// Time after which an unseen target counts as new, seconds.
const FORGOTTEN_AFTER_S: f64 = 120.0;

settings::settings! {
    /// A simulated wide-area sensor.
    pub struct WideAreaSettings {
        check WideAreaSettings::check;
        /// Centre of the observed area: east and north.
        position_m: [f64; 2] = [0.0; 2], in [-1e6, 1e6];
        /// Radius of the observed area.
        range_max_m: f64 = 200_000.0, in [1, 2e6];
        /// Lowest observed height.
        height_min_m: f64 = 300.0, in [-1e4, 1e5];
        /// Time between two observations.
        period_s: f64 = 8.0, in [0.1, 600];
        /// Time of the first observation, up to the period.
        phase_s: f64 = 0.0, in [0, 600];
        /// Time from an observation to the arrival of its reports.
        delay_s: f64 = 8.0, in [0, 600];
        /// Probability that a group is reported in a period.
        detection_probability: f64 = 1.0, in [1e-3, 1];
        /// Standard deviation of a group's place, east and north.
        position_sigma_m: f64 = 1000.0, in [0, 1e5];
        /// Standard deviation of the reported velocity, east and north.
        velocity_sigma_mps: f64 = 10.0, in [0, 1e3];
        /// Probability that a count is wrong by one.
        count_wrong_probability: f64 = 0.0, in [0, 1];
        /// Greatest count of a group; larger groups are reported with this count.
        counted_max: u32 = 256, in [1, 256];
        /// Distance below which targets are counted in the same report.
        resolution_m: f64 = 5000.0, in [1, 1e6];
        /// Whether reports contain the place of the first observation.
        origins: bool = false;
        /// Time for which the sensor reports zero targets after a group has vanished; 0: no such reports.
        absence_s: f64 = 0.0, in [0, FORGOTTEN_AFTER_S];
    }
}

impl WideAreaSettings {
    fn check(&self) -> Result<(), SettingsError> {
        phase_within(self.phase_s, self.period_s)
    }

    /// Whether the sensor covers a target.
    fn covers(&self, target: &TargetState) -> bool {
        let [east, north, up] = target.position_m;
        self.away_m([east, north]) <= self.range_max_m && up >= self.height_min_m
    }

    /// Returns the distance from the centre of the coverage.
    fn away_m(&self, place_m: [f64; 2]) -> f64 {
        distance_m(self.position_m, place_m)
    }
}

/// Simulated wide-area sensor, see the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedWideAreaSensor {
    settings: WideAreaSettings,
    seed: u64,
    number: u16,
    start_utc_ns: i64,
    /// Number of the next period.
    period: u64,
    /// By number of the target.
    sightings: Vec<Option<GroupReport>>,
}

/// Latest report of a target.
#[derive(Clone, Copy, Debug)]
struct GroupReport {
    time_s: f64,
    /// First member of the group.
    first: u32,
    /// Reported position of the group, metres.
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    /// Position of the first report.
    origin_m: [f64; 2],
}

impl GroupReport {
    fn place_at(&self, time_s: f64) -> [f64; 3] {
        let age_s = time_s - self.time_s;
        std::array::from_fn(|axis| self.position_m[axis] + age_s * self.velocity_mps[axis])
    }
}

impl SimulatedWideAreaSensor {
    /// Creates a sensor that starts at the scenario's start `start_utc_ns` (UTC, nanoseconds since 1970). `number`
    /// separates the random numbers of different wide-area sensors.
    ///
    /// # Errors
    /// An invalid setting.
    pub fn new(settings: &WideAreaSettings, seed: u64, number: u16, start_utc_ns: i64) -> Result<Self, SettingsError> {
        settings::check(settings)?;
        Ok(Self {
            settings: settings.clone(),
            seed,
            number,
            start_utc_ns,
            period: 0,
            sightings: Vec::new(),
        })
    }

    /// Restarts without memory of earlier observations, with the first delivery at or after `time_s` seconds from
    /// the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        let settings = &self.settings;
        let periods = (time_s - settings.delay_s - settings.phase_s) / settings.period_s;
        self.period = periods.ceil().max(0.0) as u64;
        self.sightings.clear();
    }

    /// Returns the time of the next delivery, seconds from the scenario's start.
    pub fn next_delivery_s(&self) -> f64 {
        self.observed_s() + self.settings.delay_s
    }

    /// Returns the observation time of the next delivery's reports, seconds from the scenario's start.
    pub fn observed_s(&self) -> f64 {
        self.settings.phase_s + self.period as f64 * self.settings.period_s
    }

    /// Appends the reports of the next delivery, groups in the order of their first members followed by absences,
    /// and advances to the next delivery.
    pub fn observe(&mut self, truth: &Truth, out: &mut Vec<WideAreaReport>) {
        let time_s = self.observed_s();
        self.sightings.resize(truth.len().max(self.sightings.len()), None);
        let seen: Vec<TargetState> = truth.at(time_s).filter(|target| self.settings.covers(target)).collect();
        let places: Vec<[f64; 2]> = seen.iter().map(|target| plane(target.position_m)).collect();
        let resolution_m = self.settings.resolution_m;
        let apart = |one: usize, other: usize| distance_m(places[one], places[other]) / resolution_m;
        let firsts = groups(&places, resolution_m, apart, |_, _| false);
        for first in (0..seen.len()).filter(|place| firsts[*place] == *place) {
            let members = || {
                seen.iter()
                    .zip(&firsts)
                    .filter(|(_, of)| **of == first)
                    .map(|(target, _)| target)
            };
            self.report(time_s, seen[first].id, members, out);
        }
        self.report_absences(time_s, &seen, out);
        self.period += 1;
    }

    /// Reports a group, unless missed in this period.
    fn report<'a, M: Iterator<Item = &'a TargetState>>(
        &mut self,
        time_s: f64,
        first: u32,
        members: impl Fn() -> M,
        out: &mut Vec<WideAreaReport>,
    ) {
        let settings = &self.settings;
        let mut random = stream(self.seed, Purpose::WideArea, self.number, u64::from(first), self.period);
        let is_reported = random.random_bool(settings.detection_probability);
        let [is_wrong, is_more] = [settings.count_wrong_probability, 0.5].map(|share| random.random_bool(share));
        let errors: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
        let targets = members().count() as u32;
        let mean = |of: fn(&TargetState) -> [f64; 3]| -> [f64; 3] {
            let sum = |axis: usize| members().map(|target| of(target)[axis]).sum::<f64>();
            std::array::from_fn(|axis| sum(axis) / f64::from(targets))
        };
        let mut position_m = mean(|target| target.position_m);
        let mut velocity_mps = mean(|target| target.velocity_mps);
        for axis in 0..2 {
            position_m[axis] += settings.position_sigma_m * errors[axis];
            velocity_mps[axis] += settings.velocity_sigma_mps * errors[2 + axis];
        }
        if !is_reported {
            // The group exists nevertheless; its sighting stays current.
            for target in members() {
                if let Some(sighting) = &mut self.sightings[target.id as usize] {
                    (sighting.position_m, sighting.time_s) = (sighting.place_at(time_s), time_s);
                }
            }
            return;
        }
        for target in members() {
            let known = &mut self.sightings[target.id as usize];
            let before = known.filter(|before| time_s - before.time_s <= FORGOTTEN_AFTER_S);
            *known = Some(GroupReport {
                time_s,
                first,
                position_m,
                velocity_mps,
                origin_m: before.map_or(plane(position_m), |before| before.origin_m),
            });
        }
        let counted = match (is_wrong, is_more || targets == 1) {
            (false, _) => targets,
            (true, true) => targets + 1,
            (true, false) => targets - 1,
        };
        let origin_m = self.sightings[first as usize].map(|sighting| sighting.origin_m);
        let origin_m = origin_m.filter(|_| self.settings.origins);
        let counted = counted.min(self.settings.counted_max);
        out.push(self.stamped(time_s, position_m, velocity_mps, counted, origin_m));
    }

    /// Reports zero targets at the positions of vanished groups, one report for each.
    fn report_absences(&self, time_s: f64, seen: &[TargetState], out: &mut Vec<WideAreaReport>) {
        let settings = &self.settings;
        let mut told: Vec<(f64, u32)> = Vec::new();
        for sighting in self.sightings.iter().flatten() {
            let age_s = time_s - sighting.time_s;
            let group = (sighting.time_s, sighting.first);
            if age_s <= 0.0 || age_s > settings.absence_s || told.contains(&group) {
                continue;
            }
            let place_m = sighting.place_at(time_s);
            let near =
                |target: &TargetState| distance_m(plane(target.position_m), plane(place_m)) < settings.resolution_m;
            let has_left = settings.away_m(plane(place_m)) + settings.resolution_m > settings.range_max_m;
            if has_left || seen.iter().any(near) {
                continue;
            }
            told.push(group);
            out.push(self.stamped(time_s, place_m, sighting.velocity_mps, 0, None));
        }
    }

    fn stamped(
        &self,
        time_s: f64,
        position_m: [f64; 3],
        velocity_mps: [f64; 3],
        targets: u32,
        origin_m: Option<[f64; 2]>,
    ) -> WideAreaReport {
        let utc_ns = |time_s: f64| self.start_utc_ns + (time_s * NS_PER_S).round() as i64;
        WideAreaReport {
            time_ns: utc_ns(time_s),
            arrival_ns: utc_ns(time_s + self.settings.delay_s),
            position_m,
            velocity_mps,
            targets,
            origin_m,
        }
    }
}

fn plane([east, north, _]: [f64; 3]) -> [f64; 2] {
    [east, north]
}

fn distance_m(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}
