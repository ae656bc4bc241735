//! The simulated world of a deployment: its targets, and what observes them.

use frames::SystemFrame;

use crate::{
    AisSettings, ArrayGeometry, DirectionFinderSettings, OnBoardSettings, ScenarioSettings, SensorSettings,
    SimulatedSensor, TargetState, Truth, WideAreaSettings,
};

/// Instrument of a simulated source.
#[derive(Clone, Debug)]
pub enum Instrument {
    /// A sensor that tracks what it sees.
    Sensor(Box<SensorSettings>),
    /// A direction finder, whose bearings its adapter locates.
    DirectionFinder {
        /// The finder.
        settings: Box<DirectionFinderSettings>,
        /// Array whose snapshots it delivers; `None` if it delivers bearings.
        array: Option<Box<ArrayGeometry>>,
    },
    /// Receivers of AIS.
    Ais(Box<AisSettings>),
}

/// The simulated world of a deployment, and what observes it, each with its number in the deployment.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The targets; `None` where nothing but ships, which bring their targets along, is simulated.
    pub targets: Option<ScenarioSettings>,
    /// Instruments of simulated sources.
    pub instruments: Vec<(u16, Instrument)>,
    /// Simulated wide-area sensors.
    pub counting: Vec<(u16, WideAreaSettings)>,
    /// Simulated platforms.
    pub ships: Vec<(u16, OnBoardSettings)>,
}

impl World {
    /// The instrument of the source `number`; `None` if the source is not simulated.
    pub fn instrument(&self, number: u16) -> Option<&Instrument> {
        let mut instruments = self.instruments.iter();
        instruments.find_map(|(of, instrument)| (*of == number).then_some(instrument))
    }
}

/// The targets of a world that some of its sensors can see. Direction finders do not count: a target with bearings
/// alone is no part of a picture that has to be complete.
#[derive(Debug)]
pub struct VisibleTargets {
    truth: Truth,
    sensors: Vec<SimulatedSensor>,
}

impl VisibleTargets {
    /// Visible targets of `world` with this seed, which begins at `start_utc_ns` (UTC, nanoseconds); `None` without
    /// sensors.
    ///
    /// # Errors
    /// If a setting cannot be used; a checked configuration rules that out.
    pub fn new(
        world: &World,
        frame: SystemFrame,
        seed: u64,
        start_utc_ns: i64,
    ) -> Result<Option<Self>, settings::SettingsError> {
        let mut sensors = Vec::new();
        for (number, instrument) in &world.instruments {
            if let Instrument::Sensor(settings) = instrument {
                sensors.push(SimulatedSensor::new(settings, seed, *number, start_utc_ns)?);
            }
        }
        let Some(targets) = world.targets.as_ref().filter(|_| !sensors.is_empty()) else {
            return Ok(None);
        };
        let truth = Truth::new(targets, seed)?.round(frame);
        Ok(Some(Self { truth, sensors }))
    }

    /// Visible targets at a time, seconds from the world's begin.
    pub fn at(&self, time_s: f64) -> impl Iterator<Item = TargetState> + '_ {
        let in_view = |target: &TargetState| self.sensors.iter().any(|sensor| sensor.observes(target));
        self.truth.at(time_s).filter(in_view)
    }
}
