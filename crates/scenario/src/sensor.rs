//! Simulated sensor: observes the truth, tracks the detections, and delivers sensor tracks.
//!
//! The sensor has one track per target and never confuses two targets. Its errors concern positions (noise,
//! biases), presence (misses, dropouts, false targets), and identity over time (a terminated track returns with a
//! new number).

use messages::SensorTrack;
use observations::DetectionTruth as Of;
use settings::SettingsError;

use crate::false_target::FalseTarget;
use crate::look::{LookParameters, SensorTarget, Told, VisibleTarget};
use crate::plot::RadarPlot;
use crate::resolution::Company;
use crate::schedule::Slot;
use crate::sensor_settings::SensorSettings;
use crate::target::TargetState;
use crate::truth::Truth;

/// Maximum number of concurrent false targets of a sensor; further false targets do not appear.
pub const FALSE_TARGETS_MAX: usize = 256;
/// Track numbers reserved per delivery, so that a sensor started in mid-scenario does not reuse numbers. A sensor
/// may use this many new tracks per delivery on average.
const NUMBERS_PER_SLOT: u64 = 64;

/// Simulated sensor, see the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedSensor {
    looks: LookParameters,
    slot: Slot,
    next_number: u32,
    /// By number of the target.
    targets: Vec<SensorTarget>,
    false_targets: Vec<(FalseTarget, SensorTarget)>,
}

impl SimulatedSensor {
    /// Creates a sensor that starts at the scenario's start `start_utc_ns` (UTC, nanoseconds since 1970). It
    /// reports as source number `source`, which also separates the random numbers of different sensors.
    ///
    /// # Errors
    /// An invalid setting.
    pub fn new(settings: &SensorSettings, seed: u64, source: u16, start_utc_ns: i64) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        Ok(Self {
            slot: Slot::new(0, &settings),
            looks: LookParameters {
                settings,
                seed,
                source,
                start_utc_ns,
            },
            next_number: 1,
            targets: Vec::new(),
            false_targets: Vec::with_capacity(FALSE_TARGETS_MAX),
        })
    }

    /// Restarts without tracks, with the first delivery at or after `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        self.slot = Slot::first_delivered_from(time_s, &self.looks.settings);
        self.next_number = ((self.slot.number * NUMBERS_PER_SLOT) as u32).saturating_add(1);
        self.targets.clear();
        self.false_targets.clear();
    }

    /// Returns the time of the next delivery, seconds from the scenario's start.
    pub fn next_scan_time_s(&self) -> f64 {
        self.slot.delivered_s(&self.looks.settings)
    }

    /// Returns the earliest measurement time in any later delivery, seconds from the scenario's start.
    pub fn progress_s(&self) -> f64 {
        self.slot.begin_s()
    }

    /// Returns the start of the period, seconds from the scenario's start, when a radar's antenna points north;
    /// `None` unless the next delivery is the period's first.
    pub fn period_begins_s(&self) -> Option<f64> {
        let (_, slot_of_period) = self.slot.period(&self.looks.settings);
        (slot_of_period == 0).then_some(self.slot.begin_s())
    }

    /// Returns the time between two looks at one target, seconds.
    pub fn period_s(&self) -> f64 {
        self.looks.settings.schedule.period_s
    }

    /// Whether the sensor could observe `target` at its present position: within coverage, and with the required
    /// equipment. Misses and dropouts do not count: they are failures of the sensor, not absences of the target.
    pub fn observes(&self, target: &TargetState) -> bool {
        self.looks
            .settings
            .coverage
            .contains(target.position_m, target.height_m)
            && self.looks.watched(u64::from(target.id)).equipped
    }

    /// Appends the reports of the next delivery, in order of the time of measurement, and advances to the next
    /// delivery.
    ///
    /// Sequence number and stages are left 0, for the publisher to fill in.
    pub fn scan(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>) {
        self.scan_for(truth, out, None);
    }

    /// Scans as [`SimulatedSensor::scan`], and appends the sensor's detections to `plots`, also in order of time.
    pub fn scan_with_plots(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, plots: &mut Vec<RadarPlot>) {
        let first = plots.len();
        let slot = self.slot;
        self.scan_for(truth, out, Some(plots));
        let looks = &self.looks;
        let settings = &looks.settings;
        RadarPlot::false_ones(settings, (looks.seed, looks.source), &slot, |time_s, found| {
            plots.push(looks.plot(&slot, time_s, Of::FalseAlarm, &found));
        });
        // At equal times, targets are in the order of their numbers, followed by false targets: the sort is stable.
        plots[first..].sort_by_key(|plot| plot.time_of_measurement_ns);
    }

    fn scan_for(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, mut plots: Option<&mut Vec<RadarPlot>>) {
        let first = out.len();
        let looks = &self.looks;
        let mut told = Told {
            next_number: &mut self.next_number,
            out,
        };
        for index in self.targets.len()..truth.len() {
            self.targets.push(looks.watched(index as u64));
        }
        let cell = looks.settings.resolution.as_ref().filter(|_| plots.is_some());
        let company = cell.map(|cell| Company::find(cell, looks, &self.slot, truth, &self.targets));
        for index in 0..truth.len() {
            let see = |time_s| VisibleTarget::target(truth.target_at(index, time_s), looks);
            let look = looks.look(&self.slot, index as u64, &mut self.targets[index], see, &mut told);
            let (Some((time_s, found)), Some(plots)) = (look, &mut plots) else {
                continue;
            };
            let echo = match &company {
                Some(company) => company.echo(looks, &self.slot, (truth, time_s), &self.targets, (index, found)),
                None => found.map(|found| (Of::Target(index as u32), found)),
            };
            plots.extend(echo.map(|(of, found)| {
                let state = truth.target_at(index, time_s);
                looks.replied_plot(&self.slot, time_s, of, (&found, &state))
            }));
        }

        let (period, slot_of_period) = self.slot.period(&looks.settings);
        if slot_of_period == 0 {
            for index in 0..FalseTarget::count(&looks.settings, looks.seed, looks.source, period) {
                let target = FalseTarget::new(&looks.settings, looks.seed, looks.source, period, index);
                if self.false_targets.len() < FALSE_TARGETS_MAX {
                    let mut watched = looks.watched(target.thing);
                    watched.equipped = true;
                    self.false_targets.push((target, watched));
                }
            }
        }
        for (target, watched) in &mut self.false_targets {
            let see = |time_s| VisibleTarget::false_target(target, time_s);
            let look = looks.look(&self.slot, target.thing, watched, see, &mut told);
            if let (Some((time_s, Some(found))), Some(plots)) = (look, &mut plots) {
                plots.push(looks.plot(&self.slot, time_s, Of::FalseAlarm, &found));
            }
        }
        let over_s = self.slot.begin_s();
        self.false_targets
            .retain(|(target, watched)| target.lasts_at(over_s) || watched.track.is_some());

        out[first..].sort_unstable_by_key(|report| (report.time_of_measurement_ns, report.track_number));
        self.slot = Slot::new(self.slot.number + 1, &looks.settings);
    }
}
