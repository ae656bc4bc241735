//! The engine's settings: the keys of `[fusion]`, and the properties of each source.
//!
//! Plain data with the checks of their keys, without the engine: an edit in the engine rebuilds no reader of
//! configurations.

#![forbid(unsafe_code)]

mod association;
mod border;
mod coverage;
mod doubts;
mod existence;
mod identity;
mod numbers;
pub mod qnh;
pub mod region;
mod registration;
mod rule;
mod source;
mod source_ref;
mod source_set;
mod target_size;

pub use association::{AssociationSettings, GateProbability};
pub use identity::{CodePattern, FactorExponents, IdentitySettings};
pub use numbers::NumbersSettings;
pub use source::{
    Accuracy, AccuracyBase, AccuracyModel, AccuracyTable, CorrectionTable, MethodAccuracy, ReportLimits, Shares,
    SourceSettings, StampRounding, Weighing,
};
pub use source::{FRESH_PERIODS, longest_period_s};

use messages::NO_SOURCE;
use settings::{Seconds, SettingsError};

pub use border::{BorderSettings, Gap};
pub use coverage::{CoverageArea, CoverageTable};
pub use existence::ExistenceSettings;
pub use qnh::RegionalQnh;
pub use registration::RegistrationSettings;
pub use rule::{
    DropOut, HandOverSettings, Intersection, MosaicCell, MosaicSettings, OrderedEta, PairRamp, RAMP_MAX, ResidualKind,
    RuleName, RuleSettings, Tie,
};
pub use source_ref::{SOURCES_MAX, SourceRef};
pub use source_set::{SourceIter, SourceSet};
pub use target_size::TargetSizeSettings;

/// Most scans that the index can look back over: one bit each.
pub const SCANS_MAX: u32 = 64;
/// Most stored reports per source and target.
pub const STORED_REPORTS_MAX: usize = 64;
/// Condition (weather) in which no factor of a condition applies.
pub const NORMAL: &str = "normal";
/// Usual window of late reports, seconds.
const LATE_WINDOW_S: f64 = 10.0;

settings::settings! {
    /// Fusion.
    pub struct Settings beside [sources: Vec<SourceSettings>, qnh: Vec<RegionalQnh>] {
        /// Spectral density of the white-noise acceleration in the prediction of states.
        process_noise_m2ps3: f64 = 1.0, in [0, 1e6];
        /// Whether optimistic covariances are enlarged (BF-5).
        consistency: bool = true;
        /// Time between two states of a system track: published at its whole multiples for every system track (QF-6).
        refresh_s: Option<Seconds> = None, in [1e-3, 3600], usually "whenever a report has changed a system track";
        /// Delay of the states after their refresh time. Reports measured during the delay permit interpolation of
        /// slow sources instead of extrapolation (QF-6).
        refresh_delay_s: Seconds = Seconds::default(), in [0, 3600];
        /// Time by which a report may be older than its track's state and still change the state as if it had come in
        /// time; older ones are carried forward. 0: all are.
        late_window_s: Option<Seconds> = None, in [0, 60], usually "10 in order `arrival`, and offline for files with `arrival_s`; else 0";
        /// Age of the states on a further topic, `system/smoothed`: they are smoothed with the measurements since then,
        /// and up to a quarter older. A thread of its own makes them.
        smoothing_lag_s: Option<Seconds> = None, in [1, 60], usually "no such topic";
        /// Publication of a further track picture from local sources only, for other centres.
        exchange: bool = false;
        /// Borders with other centres.
        border: BorderSettings = BorderSettings::default();
        /// Sizes of the tables.
        capacity: Capacity = Capacity::default();
        /// Association of reports with system tracks (TI-3).
        association: AssociationSettings = AssociationSettings::default();
        /// Identity as evidence for one target (TI-3).
        identity: IdentitySettings = IdentitySettings::default();
        /// Life of system tracks.
        life: LifeSettings = LifeSettings::default();
        /// Numbers of system tracks.
        numbers: NumbersSettings = NumbersSettings::default();
        /// Existence of targets, estimated from reports and missing reports of sources (BF-2).
        existence: ExistenceSettings = ExistenceSettings::default();
        /// Systematic errors of the sources (BF-3).
        registration: RegistrationSettings = RegistrationSettings::default();
        /// Largest sizes of targets, by type.
        target_size: TargetSizeSettings = TargetSizeSettings::default();
        /// Weighing of the sources.
        rule: RuleSettings = RuleSettings::default();
    }

    /// Sizes of the tables. All tables are allocated at the start; a full table rejects new entries and counts them
    /// (PL-4). A source may always use its fair share of a table (equal shares), and additionally the unused room.
    #[derive(Copy)]
    pub struct Capacity {
        /// System tracks.
        system_tracks: Option<usize> = None, in [1, 1e6], usually "2000; offline as seen";
        /// Live sensor tracks of all sources together.
        sensor_tracks: Option<usize> = None, in [1, 1e7], usually "8000; offline as seen";
        /// Earlier reports kept per source and target, beside the latest (N of TI-4).
        stored_reports: usize = 5, in [1, STORED_REPORTS_MAX];
        /// Measurements kept for late reports, of all system tracks together.
        kept_measurements: Option<usize> = None, in [1, 1e8], usually "32 for each system track";
        /// Reports that wait per source in order `time`: a source must be able to hand over a whole slice at any time.
        queue: usize = 4096, in [128, 1e7];
    }

    /// Life of system tracks (QF-8 names the counts; TI has none).
    #[derive(Copy)]
    pub struct LifeSettings {
        /// Reports until a tentative track is confirmed; two suffice where both have the same address or MMSI.
        confirm_reports: u32 = 3, in [1, 1e6];
        /// Time without a report after which a confirmed track ends.
        terminate_s: Option<Seconds> = None, in [1e-3, 1e5], usually "20, and more than the slowest source's `fresh_s`; up to 60, as long as the gaps that the track's sources leave; 4 intervals of a target that is reported less often than others";
        /// Time without a report after which a tentative track ends.
        tentative_s: Option<Seconds> = None, in [1e-3, 1e5], usually "6, at least the slowest source's `fresh_s`; 2.5 intervals of a target that is reported less often than others";
    }
}

impl Capacity {
    /// System tracks.
    pub fn system_tracks(&self) -> usize {
        self.system_tracks.unwrap_or(2_000)
    }

    /// Live sensor tracks of all sources together.
    pub fn sensor_tracks(&self) -> usize {
        self.sensor_tracks.unwrap_or(8_000)
    }

    /// Measurements kept for late reports.
    pub fn kept_measurements(&self) -> usize {
        self.kept_measurements.unwrap_or(32 * self.system_tracks())
    }
}

impl LifeSettings {
    /// Time without a report after which a confirmed track ends, nanoseconds, where reports count for up to `fresh_ns`.
    pub fn terminate_ns(&self, fresh_ns: i64) -> i64 {
        self.terminate_s.map_or(20_000_000_000.max(fresh_ns + 1), Seconds::ns)
    }

    /// Time without a report after which a tentative track ends, nanoseconds, where reports count for up to `fresh_ns`.
    pub fn tentative_ns(&self, fresh_ns: i64) -> i64 {
        self.tentative_s.map_or(6_000_000_000.max(fresh_ns), Seconds::ns)
    }
}

impl Settings {
    /// Default settings for these sources.
    pub fn of(sources: Vec<SourceSettings>) -> Self {
        Self {
            sources,
            ..Self::default()
        }
    }

    /// Names of the conditions (weather) that can hold, each in its place: first the one that does at the start. A name
    /// may come again.
    pub fn conditions(&self) -> impl Iterator<Item = &str> {
        let of_sources = self.sources.iter().flat_map(|source| source.accuracy.condition_names());
        std::iter::once(NORMAL).chain(of_sources)
    }

    /// Rank of a source where one has to come first, the least being the first: the reference source, then by priority.
    pub fn rank(&self, source: u16) -> (bool, u32, u16) {
        let reference = self.registration.reference_source.as_ref();
        let is_reference = reference.is_some_and(|reference| reference.number == source);
        (!is_reference, self.sources[usize::from(source)].priority, source)
    }

    /// Whether one source comes before another, if there are both.
    pub fn comes_before(&self, source: u16, other: u16) -> bool {
        source != NO_SOURCE && other != NO_SOURCE && self.rank(source) < self.rank(other)
    }

    /// The settings for these sources, with the numbers of those that keys name.
    ///
    /// # Errors
    /// A key, beginning with that of a table of `[fusion]`, whose source there is not.
    pub fn with_sources(mut self, mut sources: Vec<SourceSettings>) -> Result<Self, SettingsError> {
        let rule = &mut self.rule;
        let mut named = vec![(
            "registration.reference_source".to_owned(),
            self.registration.reference_source.as_mut(),
        )];
        named.push(("rule.reference_source".to_owned(), rule.reference_source.as_mut()));
        for (index, pair) in rule.hand_over.pairs.iter_mut().enumerate() {
            named.push((format!("rule.hand_over.pair[{index}].from"), Some(&mut pair.from)));
            named.push((format!("rule.hand_over.pair[{index}].to"), Some(&mut pair.to)));
        }
        named.extend(
            rule.mosaic
                .default
                .iter_mut()
                .map(|source| ("rule.mosaic.default".to_owned(), Some(source))),
        );
        for (index, cell) in rule.mosaic.cells.iter_mut().enumerate() {
            let key = format!("rule.mosaic.cell[{index}].sources");
            named.extend(cell.sources.iter_mut().map(|source| (key.clone(), Some(source))));
        }
        let names: Vec<String> = sources.iter().map(|source| source.name.clone()).collect();
        for source in &mut sources {
            for (key, others) in [
                ("shares", &mut source.shares),
                ("independent_of", &mut source.independent_of),
            ] {
                named.extend(others.iter_mut().map(|other| (key.to_owned(), Some(other))));
            }
        }
        for (key, source) in named {
            let Some(source) = source.filter(|source| !source.name.is_empty()) else {
                continue;
            };
            let number = names.iter().position(|other| *other == source.name);
            source.number = number.ok_or_else(|| {
                let what = format!(
                    "there is no source named \"{}\"; there are: {}",
                    source.name,
                    names.join(", ")
                );
                SettingsError::new(key, what)
            })? as u16;
        }
        self.rule.mosaic.cells.sort_by_key(|cell| (cell.east, cell.north));
        self.sources = sources;
        self.check_sources()?;
        Ok(self)
    }

    /// Looks for settings that cannot work.
    ///
    /// # Errors
    /// The first such setting, with key, value and remedy.
    pub fn check(&self) -> Result<(), SettingsError> {
        settings::check(self)?;
        self.check_sources()
    }

    /// Whether all rules give accuracy values (TI-9).
    pub fn accuracy_values(&self) -> bool {
        self.rule.accuracy_values.unwrap_or(self.refresh_s.is_some())
    }

    /// Time between two states of a system track, nanoseconds; `None`: whenever a report has changed a system track.
    pub fn refresh_ns(&self) -> Option<i64> {
        self.refresh_s.map(Seconds::ns)
    }

    /// Age of smoothed states, nanoseconds; `None`: there are none.
    pub fn smoothing_lag_ns(&self) -> Option<i64> {
        self.smoothing_lag_s.map(Seconds::ns)
    }

    /// Gives the window of late reports its usual length, unless it is stated.
    pub fn expect_late_reports(&mut self) {
        self.late_window_s.get_or_insert(Seconds::of(LATE_WINDOW_S));
    }

    /// Greatest age of a report that changes its track's state as if it had come in time, nanoseconds; 0: none does.
    pub fn late_window_ns(&self) -> i64 {
        self.late_window_s.map_or(0, Seconds::ns)
    }

    /// Longest time between two reports of any source, seconds.
    pub fn longest_period_s(&self) -> f64 {
        longest_period_s(&self.sources)
    }

    /// TI-8: alpha cannot be normalised by a source whose alpha is 0.
    fn check_sources(&self) -> Result<(), SettingsError> {
        let refused = |source: &str, reason: &str| {
            let what = format!("{source}: {reason}");
            Err(SettingsError::new("rule.reference_source", what))
        };
        if !(1..=SOURCES_MAX).contains(&self.sources.len()) {
            let what = format!("{} sources; there must be 1 to {SOURCES_MAX}", self.sources.len());
            return Err(SettingsError::new("", what));
        }
        for source in &self.sources {
            source.check_correction()?;
        }
        let Some(reference) = &self.rule.reference_source else {
            return Ok(());
        };
        let number = reference.number;
        let Some(source) = self.sources.get(usize::from(number)) else {
            return refused(&number.to_string(), "there is no such source");
        };
        let smallest = match source.accuracy.base {
            AccuracyBase::Constant { sigma_m } => sigma_m,
            AccuracyBase::Polar { range_sigma_m, .. } => range_sigma_m,
            AccuracyBase::Estimated { initial_m, .. } => initial_m,
            AccuracyBase::Reported => {
                let reason = "its accuracy is what it reports, so nothing is known of it where it reports nothing; \
                              name a source with another model";
                return refused(&source.name, reason);
            }
        };
        if source.adjustment * smallest > 0.0 {
            return Ok(());
        }
        let reason = "its adjustment × accuracy is 0, so nothing can be expressed relative to it; \
                      give that source an accuracy and an adjustment above 0, or name another";
        refused(&source.name, reason)
    }
}
