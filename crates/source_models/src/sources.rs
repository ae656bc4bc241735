//! Models of all sources together: learned quality, systematic errors, and motion of targets.

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
use crate::sampling::Sampling;
use crate::settings::{AccuracyBase, Settings, SourceSet, SourceSettings};
use crate::source_model::SourceModel;
use crate::stamps::Stamps;
use crate::step_memory::StepMemory;

/// Largest offset of a sound clock, seconds.
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
    /// Detection points of targets by source.
    pub(crate) points: Points,
    /// How long reports and tracks of the sources live.
    pub(crate) lifetimes: Lifetimes,
    pub(crate) dependence: Dependence,
    /// How many new tracks of each source turned out to be targets.
    pub(crate) purity: Purity,
    /// Coverage of each source.
    pub(crate) coverage: DetectionMap,
    /// Platforms of moving sources.
    pub(crate) moving: MovingSources,
    /// Pressure altitude and height, by region.
    pub(crate) pressure: PressureOffsets,
    /// Share of each self-reporting source's reports contradicted by measuring sensors.
    pub(crate) contradicted: Vec<f64>,
    /// Error of each source's clock.
    pub(crate) clocks: Vec<ClockError>,
    /// Whether the clock of some source is taken off.
    pub(crate) corrects_clocks: bool,
    /// Usual factor between true and stated covariances without indication of a filter.
    pub(crate) usual_claim: f64,
    /// Sources set aside at the last look, as bits.
    pub(crate) was_set_aside: SourceSet,
    pub(crate) before_step: StepMemory,
    /// Which reports teach.
    pub(crate) sampling: Sampling,
    /// Time stamps of each source.
    pub(crate) stamps: Vec<Stamps>,
    /// Whether some source's stamps are multiples of a coarse step.
    pub(crate) has_coarse_stamps: bool,
    /// Whether the heights of some source have slow errors.
    pub(crate) has_slow_heights: bool,
}

/// Number of cells of the learned coverage table, and their width.
const COVERAGE_CELLS: usize = 4096;
const COVERAGE_CELL_M: f64 = 5000.0;

impl Sources {
    /// Models without knowledge, with all tables allocated.
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
            was_set_aside: SourceSet::EMPTY,
            before_step: StepMemory::new(count),
            sampling: Sampling::new(count),
            stamps: vec![Stamps::default(); count],
            has_coarse_stamps: false,
            has_slow_heights: false,
        }
    }

    /// Sets the offset of a source's clock against sound clocks, seconds; `None` if unknown.
    pub fn set_clock(&mut self, sources: &[SourceSettings], source: u16, offset_s: Option<f64>) {
        let Some(clock) = self.clocks.get_mut(usize::from(source)) else {
            return;
        };
        // Late data do not imply a wrong clock: the delay may be up to a period.
        let late_s = sources[usize::from(source)].period_ns as f64 / NS_PER_S;
        let offset_s = offset_s.unwrap_or_default();
        let excess_s = (offset_s.max(-offset_s - late_s) - CLOCK_SOUND_S).max(0.0);
        // A clock ahead of the receipt is wrong. A clock behind may come from a long delay of the data.
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

    /// Corrects the clocks found late by the times of receipt, if comparison with other sources shows the same.
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

/// Place of a source with measurements of range and azimuth, metres; `None` for others.
pub fn place_of(source: &SourceSettings) -> Option<[f64; 2]> {
    source.place_m.or(match source.accuracy.base {
        AccuracyBase::Polar { place_m, .. } => Some(place_m),
        _ => None,
    })
}
