//! A simulated sensor: looks at the truth, tracks what it finds, and delivers sensor tracks.
//!
//! The sensor keeps one track per target and never confuses two targets; what it gets wrong is where they are (noise,
//! biases), whether they are there (misses, dropouts, false targets), and what has become of them (a track that ended
//! comes back with a new number).

use messages::SensorTrack;
use observations::Truth as Of;
use settings::SettingsError;

use crate::false_target::FalseTarget;
use crate::look::{Looks, Seen, Told, Watched};
use crate::plot::Plot;
use crate::resolution::Company;
use crate::schedule::Slot;
use crate::sensor_settings::SensorSettings;
use crate::target::TargetState;
use crate::truth::Truth;

/// Most false targets that one sensor follows at a time; further ones do not appear.
pub const FALSE_TARGETS_MAX: usize = 256;
/// Track numbers set aside per delivery, so that a sensor that begins in mid-scenario does not use numbers again that
/// it gave before: it may make this many new tracks per delivery on average.
const NUMBERS_PER_SLOT: u64 = 64;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct SimulatedSensor {
    looks: Looks,
    slot: Slot,
    next_number: u32,
    /// By number of the target.
    targets: Vec<Watched>,
    false_targets: Vec<(FalseTarget, Watched)>,
}

impl SimulatedSensor {
    /// A sensor that begins at the scenario's start, which is at `start_utc_ns` (UTC, nanoseconds since 1970). It
    /// reports as source number `source`, which also sets its random numbers apart from those of other sensors.
    ///
    /// # Errors
    /// A setting that cannot be used.
    pub fn new(settings: &SensorSettings, seed: u64, source: u16, start_utc_ns: i64) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        Ok(Self {
            slot: Slot::new(0, &settings),
            looks: Looks {
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

    /// Begins anew, without tracks, with the first delivery at or after `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        self.slot = Slot::first_delivered_from(time_s, &self.looks.settings);
        self.next_number = ((self.slot.number * NUMBERS_PER_SLOT) as u32).saturating_add(1);
        self.targets.clear();
        self.false_targets.clear();
    }

    /// Time at which the next delivery is due, seconds from the scenario's start.
    pub fn next_scan_time_s(&self) -> f64 {
        self.slot.delivered_s(&self.looks.settings)
    }

    /// Time of measurement before which no later delivery will report, seconds from the scenario's start.
    pub fn progress_s(&self) -> f64 {
        self.slot.begin_s()
    }

    /// Begin of the period, seconds from the scenario's start, when a radar's antenna points north; `None` unless the
    /// next delivery is the period's first.
    pub fn period_begins_s(&self) -> Option<f64> {
        let (_, slot_of_period) = self.slot.period(&self.looks.settings);
        (slot_of_period == 0).then_some(self.slot.begin_s())
    }

    /// Time between two looks at one target, seconds.
    pub fn period_s(&self) -> f64 {
        self.looks.settings.schedule.period_s
    }

    /// Whether the sensor could see `target` where it is now: within coverage, and with the equipment that the sensor
    /// needs. Misses and dropouts do not count: they are the sensor's failures, not the target's absence.
    pub fn observes(&self, target: &TargetState) -> bool {
        self.looks
            .settings
            .coverage
            .contains(target.position_m, target.height_m)
            && self.looks.watched(u64::from(target.id)).equipped
    }

    /// Appends what the next delivery reports, in order of the time of measurement, and goes on to the one after it.
    ///
    /// Sequence number and stages are left 0, for the publisher to fill in.
    pub fn scan(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>) {
        self.scan_for(truth, out, None);
    }

    /// As [`SimulatedSensor::scan`], and appends to `plots` what the sensor detected, in order of the time too.
    pub fn scan_with_plots(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, plots: &mut Vec<Plot>) {
        let first = plots.len();
        let slot = self.slot;
        self.scan_for(truth, out, Some(plots));
        let looks = &self.looks;
        let settings = &looks.settings;
        Plot::false_ones(settings, (looks.seed, looks.source), &slot, |time_s, found| {
            plots.push(looks.plot(&slot, time_s, Of::FalseAlarm, &found));
        });
        // Of one time, targets come in the order of their numbers, false ones after them: the sort is stable.
        plots[first..].sort_by_key(|plot| plot.time_of_measurement_ns);
    }

    fn scan_for(&mut self, truth: &Truth, out: &mut Vec<SensorTrack>, mut plots: Option<&mut Vec<Plot>>) {
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
            let see = |time_s| Seen::target(truth.target_at(index, time_s), looks);
            let look = looks.look(&self.slot, index as u64, &mut self.targets[index], see, &mut told);
            let (Some((time_s, found)), Some(plots)) = (look, &mut plots) else {
                continue;
            };
            let echo = match &company {
                Some(company) => company.echo(looks, &self.slot, (truth, time_s), &self.targets, (index, found)),
                None => found.map(|found| (Of::Target(index as u32), found)),
            };
            plots.extend(echo.map(|(of, found)| looks.plot(&self.slot, time_s, of, &found)));
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
            let see = |time_s| Seen::false_target(target, time_s);
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
