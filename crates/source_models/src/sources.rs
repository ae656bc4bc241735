//! What is known of the sources as a whole: what they were learned to be worth, their systematic errors, and how
//! targets move.

mod changes;
mod comparison;

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

use crate::TICK_NS;
use crate::alignment::Alignment;
use crate::credibility::Credibility;
use crate::dependence::Dependence;
use crate::detection_map::DetectionMap;
use crate::lifetimes::Lifetimes;
use crate::manoeuvres::Manoeuvres;
use crate::moving_sources::MovingSources;
use crate::points::Points;
use crate::pressure::PressureOffsets;
use crate::purity::Purity;
use crate::registration::{ClockError, Registration};
use crate::settings::{AccuracyBase, Settings, SourceSettings};
use crate::source_model::SourceModel;
use crate::step_memory::StepMemory;

/// Offset of a clock, seconds, that is no error beside the others.
const CLOCK_SOUND_S: f64 = 0.5;
/// The sources, each by its number.
#[derive(Debug, Serialize, Deserialize)]
pub struct Sources {
    pub(crate) models: Vec<SourceModel>,
    pub(crate) registration: Registration,
    pub(crate) alignment: Alignment,
    /// How targets manoeuvre.
    pub(crate) manoeuvres: Manoeuvres,
    pub(crate) credibility: Credibility,
    /// The points of targets that the sources see.
    pub(crate) points: Points,
    /// How long reports and tracks of the sources live.
    pub(crate) lifetimes: Lifetimes,
    pub(crate) dependence: Dependence,
    /// How many new tracks of each source turned out to be targets.
    pub(crate) purity: Purity,
    /// Where each source follows targets.
    pub(crate) coverage: DetectionMap,
    /// From where the sources that move see.
    pub(crate) moving: MovingSources,
    /// Pressure altitude and height, by region.
    pub(crate) pressure: PressureOffsets,
    /// Share of each self-reporting source's reports that measuring sensors contradict.
    pub(crate) contradicted: Vec<f64>,
    /// Error of each source's clock.
    pub(crate) clocks: Vec<ClockError>,
    /// Whether the clock of some source is taken off.
    pub(crate) corrects_clocks: bool,
    /// By how much covariances that show no filter are too small, as a factor.
    pub(crate) usual_claim: f64,
    /// Sources that were set aside at the last look, as bits.
    pub(crate) was_set_aside: u64,
    pub(crate) before_step: StepMemory,
}

/// Number of cells of the learned coverage table, and their width.
const COVERAGE_CELLS: usize = 4096;
const COVERAGE_CELL_M: f64 = 5000.0;

impl Sources {
    /// Models of which nothing is known yet, with all tables allocated.
    pub fn new(settings: &Settings) -> Self {
        let count = settings.sources.len();
        let registration = &settings.registration;
        let tick_s = TICK_NS as f64 / NS_PER_S;
        Self {
            models: vec![SourceModel::default(); count],
            alignment: Alignment::new(&settings.registration, &settings.sources),
            registration: Registration::new(
                count,
                registration.reference_source.as_ref().map(|source| source.number),
                registration.memory_s,
                tick_s,
            ),
            manoeuvres: Manoeuvres::new(settings.process_noise_m2ps3),
            credibility: Credibility::new(count),
            points: Points::new(count),
            lifetimes: Lifetimes::new(&settings.life, &settings.sources),
            dependence: Dependence::new(&settings.sources),
            purity: Purity::new(count),
            coverage: DetectionMap::new(
                settings.sources.iter().map(|source| source.coverage.clone()).collect(),
                COVERAGE_CELLS,
                COVERAGE_CELL_M,
            ),
            moving: MovingSources::new(count),
            pressure: PressureOffsets::new(),
            contradicted: vec![0.0; count],
            clocks: vec![ClockError::default(); count],
            corrects_clocks: false,
            usual_claim: 1.0,
            was_set_aside: 0,
            before_step: StepMemory::new(count),
        }
    }

    /// Sets the offset of a source's clock against sound clocks, seconds; `None` if it is not known.
    pub fn set_clock(&mut self, sources: &[SourceSettings], source: u16, offset_s: Option<f64>) {
        let Some(clock) = self.clocks.get_mut(usize::from(source)) else {
            return;
        };
        // Data that are late need not have a wrong clock: they may take a period to come.
        let late_s = sources[usize::from(source)].period_ns as f64 / NS_PER_S;
        let offset_s = offset_s.unwrap_or_default();
        let excess_s = (offset_s.max(-offset_s - late_s) - CLOCK_SOUND_S).max(0.0);
        // A clock that is ahead of the receipt is wrong. One that is behind may be that of data that take long to come.
        let is_wrong = excess_s > 0.0 && (offset_s > 0.0 || clock.removed_s < 0.0);
        let removed_s = if is_wrong { offset_s } else { 0.0 };
        clock.offset_s = offset_s;
        if (removed_s - clock.removed_s).abs() > CLOCK_SOUND_S || removed_s == 0.0 {
            self.take_off_clock(source, removed_s);
        }
        let clock = &mut self.clocks[usize::from(source)];
        clock.excess_s = if clock.removed_s == 0.0 { excess_s } else { 0.0 };
    }

    /// Takes `removed_s` off the times of all reports of a source from now on.
    fn take_off_clock(&mut self, source: u16, removed_s: f64) {
        let clock = &mut self.clocks[usize::from(source)];
        if clock.removed_s != removed_s {
            (clock.removed_s, clock.excess_s) = (removed_s, 0.0);
            self.corrects_clocks = self.clocks.iter().any(|clock| clock.removed_s != 0.0);
            self.registration.forget(usize::from(source));
            self.alignment.begin_epoch(source);
        }
    }

    /// Takes off the clocks that are late by the times of receipt, where comparison with other sources shows the same.
    pub(crate) fn correct_late_clocks(&mut self) {
        for source in 0..self.clocks.len() as u16 {
            let clock = self.clocks[usize::from(source)];
            let known = self.registration.of(source);
            let is_late = clock.excess_s > 0.0 && clock.offset_s < 0.0;
            if is_late && known.time_offset_s() < 0.5 * clock.offset_s {
                self.take_off_clock(source, clock.offset_s);
            }
        }
    }
}

/// Where a source that measures range and azimuth stands, metres; `None` for others.
pub fn place_of(source: &SourceSettings) -> Option<[f64; 2]> {
    source.place_m.or(match source.accuracy.base {
        AccuracyBase::Polar { place_m, .. } => Some(place_m),
        _ => None,
    })
}
