//! What the engine is told once, before its first report.
//!
//! These are checked values: the configuration reader turns its file into them, and [`Settings::check`] refuses what
//! cannot work, naming the key as the file spells it.

use messages::FusionRule;

use crate::quality::SCANS_MAX;

/// Everything the engine needs to know.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The sources; a report's source number is its place here.
    pub sources: Vec<SourceSettings>,
    /// Sizes of all tables.
    pub capacity: Capacity,
    /// Which report belongs to which system track.
    pub association: AssociationSettings,
    /// When a system track is confirmed, coasted, ended.
    pub life: LifeSettings,
    /// How sources are weighed.
    pub rule: RuleSettings,
    /// Spectral density of the white-noise acceleration with which states are carried forward, m²/s³.
    pub process_noise_m2ps3: f64,
    /// Systematic errors of the sources.
    pub registration: RegistrationSettings,
    /// Whether covariances that claim too much are inflated (BF-5).
    pub consistency: bool,
    /// Time between two states of a system track, nanoseconds: published at its whole multiples for every system track
    /// (QF-6). `None`: whenever a report has changed a system track.
    pub refresh_ns: Option<i64>,
    /// How long after a refresh time its states are formed, nanoseconds. Reports measured meanwhile lie on the far side
    /// of it, so that slow sources are interpolated where they would be extrapolated (QF-6).
    pub refresh_delay_ns: i64,
}

/// Sizes of the tables. Everything is allocated at the start; a full table refuses new entries, counted (PL-4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// System tracks.
    pub system_tracks: usize,
    /// Live sensor tracks of all sources together.
    pub sensor_tracks: usize,
    /// N of TI-4: earlier reports kept per source and target, beside the latest.
    pub stored_reports: usize,
}

/// One source (TI-2).
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSettings {
    /// Name, for messages to people.
    pub name: String,
    /// Identity of the sensor, the same in every deployment that hears it; 0: unknown.
    pub sensor_uid: u32,
    /// Time between two reports of one target, nanoseconds.
    pub period_ns: i64,
    /// Age beyond which a report no longer contributes, nanoseconds.
    pub fresh_ns: i64,
    /// Sensor accuracy s (TI-7).
    pub accuracy: Accuracy,
    /// Adjustment coefficient k (TI-8): small for a main source, large for a standby one.
    pub adjustment: f64,
    /// Priority for ties, smaller first (TI-11).
    pub priority: u32,
    /// Targets higher than this above the system origin cannot be seen by this source, metres.
    pub ceiling_m: f64,
    /// Where it sees; `None`: learned from its reports.
    pub coverage: Option<CoverageArea>,
}

/// Where a source sees targets, and how surely.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageArea {
    /// East and north of the sensor in the system frame, metres.
    pub place_m: [f64; 2],
    /// Farthest horizontal distance, metres.
    pub range_m: f64,
    /// First and last azimuth of the sector that is seen, clockwise from north, radians; `None`: all around.
    pub sector_rad: Option<[f64; 2]>,
    /// Corners, east and north in the system frame, metres, of the area that is seen; empty: no further limit.
    pub polygon_m: Vec<[f64; 2]>,
    /// Probability that it follows a target in there.
    pub probability: f64,
}

impl CoverageArea {
    /// Probability that the source follows a target at this place.
    pub fn probability_at(&self, position_m: [f64; 3]) -> f64 {
        let (dx, dy) = (position_m[0] - self.place_m[0], position_m[1] - self.place_m[1]);
        let in_sector = self.sector_rad.is_none_or(|[first, last]| {
            let turn = std::f64::consts::TAU;
            (dx.atan2(dy) - first).rem_euclid(turn) <= (last - first).rem_euclid(turn)
        });
        let inside = dx.hypot(dy) <= self.range_m && in_sector && self.polygon_holds(position_m[0], position_m[1]);
        if inside { self.probability } else { 0.0 }
    }

    /// Whether a ray from (x, y) crosses the polygon's edges an odd number of times.
    fn polygon_holds(&self, x: f64, y: f64) -> bool {
        let corners = &self.polygon_m;
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crosses = |([ax, ay], [bx, by]): &(&[f64; 2], &[f64; 2])| {
            (*ay > y) != (*by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax
        };
        corners.is_empty() || edges.filter(crosses).count() % 2 == 1
    }
}

/// Systematic errors of the sources (BF-3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegistrationSettings {
    /// Whether they are estimated and removed.
    pub enabled: bool,
    /// Source that is taken as true; `None`: the mean of all sources is.
    pub reference_source: Option<u16>,
    /// Time constant with which old comparisons are forgotten, seconds.
    pub memory_s: f64,
}

impl Default for RegistrationSettings {
    fn default() -> Self {
        Self {
            enabled: true,
            reference_source: None,
            memory_s: 600.0,
        }
    }
}

/// Sensor accuracy s ≥ 0 as a function of conditions (TI-7).
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// What s is at rest and in the normal condition.
    pub base: AccuracyBase,
    /// Added per metre per second of target speed, seconds.
    pub per_speed_s: f64,
    /// Factors for named conditions (weather), which can be changed while running; 1 for those not named.
    pub conditions: Vec<(String, f64)>,
}

/// The part of the sensor accuracy that depends on the kind of sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AccuracyBase {
    /// The same everywhere, metres.
    Constant {
        /// s, metres.
        sigma_m: f64,
    },
    /// Range and azimuth errors, turned into a position error at the target's place.
    Polar {
        /// East and north of the sensor in the system frame, metres.
        place_m: [f64; 2],
        /// Range error, metres.
        range_sigma_m: f64,
        /// Azimuth error, radians.
        azimuth_sigma_rad: f64,
    },
    /// Root mean square of the horizontal standard deviations that the source states in its latest report.
    Reported,
    /// Root mean square of the source's own residuals over its recent reports, all targets together.
    Estimated {
        /// s until there are residuals, metres.
        initial_m: f64,
        /// How many residuals the mean reaches back over.
        memory: f64,
    },
}

/// How reports find their system track (TI-3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssociationSettings {
    /// Whether identity is used. Without it only position and motion count; identities are still shown.
    pub use_identity: bool,
    /// Gate on d² in the plane (chi-square, two degrees of freedom) for joining a track.
    pub join_gate: f64,
    /// Gate on d² for staying: wider than joining, so that pairs do not flicker.
    pub keep_gate: f64,
    /// Gate on d² of the horizontal velocity for joining.
    pub velocity_gate: f64,
    /// Standard deviation of where on a target a sensor's detection point lies, metres; for large targets.
    pub extent_sigma_m: f64,
    /// Within this distance a second track of one source is taken for another part of the same target, metres.
    pub target_extent_m: f64,
    /// Largest difference of two known heights for joining, metres.
    pub height_gate_m: f64,
    /// Reports in a row that must miss the keep gate before a sensor track is taken out.
    pub split_reports: u32,
    /// Reports in a row that must find the same other track before two are merged.
    pub merge_reports: u32,
    /// Cell width of the neighbourhood grid, metres.
    pub cell_m: f64,
    /// Part of the variance of a difference that two tracks of one target have in common, in [0, 1): both lag behind
    /// the same manoeuvres.
    pub error_correlation: f64,
    /// How long sensor tracks that belong nowhere yet wait for the rest of their scan, as a part of their source's
    /// period; 0: each is placed at once, without regard to the others.
    pub scan_wait: f64,
}

impl AssociationSettings {
    /// Gate on d² of position, velocity and height together.
    pub fn scan_gate(&self) -> f64 {
        self.join_gate + self.velocity_gate
    }
}

/// Life of a system track (QF-8 names the counts; TI has none).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LifeSettings {
    /// Reports until a tentative track is confirmed.
    pub confirm_reports: u32,
    /// Time without a report after which a confirmed track ends, nanoseconds.
    pub terminate_ns: i64,
    /// Time without a report after which a tentative track ends, nanoseconds.
    pub tentative_ns: i64,
}

/// Which rule weighs, and how it scores.
#[derive(Clone, Debug)]
pub struct RuleSettings {
    /// The rule.
    pub rule: FusionRule,
    /// How residuals are formed (TI-6).
    pub residual: Residual,
    /// Weight of an earlier report relative to the next newer one in the mean of second positions (TI-5); 1 is plain.
    pub recency: f64,
    /// Source whose alpha is normalised to 1 (TI-8).
    pub reference_source: Option<u16>,
    /// How ties are broken (TI-11).
    pub tie: Tie,
    /// Age beyond which a source has missed its expected report, in periods of its own (TI-15).
    pub overdue_periods: f64,
    /// N of QF-4: due scans over which the quality index is summed.
    pub quality_scans: u32,
    /// How the output passes from one source to another.
    pub hand_over: HandOverSettings,
    /// h of TI-18: another source's lambda must be below h times that of the present one; 1 is TI-11.
    pub hysteresis: f64,
    /// Refreshes for which a chosen source is kept at least (TI-18).
    pub hold_refreshes: u32,
    /// Cells and lists of the mosaic rule.
    pub mosaic: MosaicSettings,
    /// What covariance intersection makes small.
    pub intersection: Intersection,
    /// Spectral density of the process noise that the sources' errors have in common, m²/s³; `None`: that with which
    /// fusion carries states forward.
    pub common_noise_m2ps3: Option<f64>,
}

/// How the output passes from one source to another (TI-13 … TI-16).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HandOverSettings {
    /// eta_0 of the new source at the first refresh and those that follow, rising; after the last it is 1. Empty: at
    /// once.
    pub ramp: Vec<f64>,
    /// Ordered pairs of sources with ramps of their own.
    pub pairs: Vec<PairRamp>,
    /// Whether eta_0 comes from the covariance traces of both sources, for one refresh (TI-16); where a trace cannot be
    /// used the ramp holds.
    pub by_traces: bool,
    /// What happens if the previous source has missed its expected report.
    pub drop_out: DropOut,
}

/// The ramp from one source to another.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRamp {
    /// Number of the source that is left.
    pub from: u16,
    /// Number of the source that takes over.
    pub to: u16,
    /// eta_0 at successive refreshes, as for those that are no pair.
    pub ramp: Vec<f64>,
}

/// What happens if the source that is left has missed its expected report (TI-15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DropOut {
    /// The new one gets all at once.
    #[default]
    Switch,
    /// It is blended by its last stored report, moved to the reference time.
    Blend,
}

/// Cells of the area and who speaks there (QF-9).
#[derive(Clone, Debug, PartialEq)]
pub struct MosaicSettings {
    /// Width of a cell, metres. Cell (0, 0) begins at the system origin and lies north-east of it.
    pub cell_m: f64,
    /// Numbers of sources, the most wanted first, where no cell says otherwise. Empty: by the sources' priorities.
    pub default: Vec<u16>,
    /// Cells with lists of their own, in ascending order of (east, north).
    pub cells: Vec<MosaicCell>,
}

/// One cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MosaicCell {
    /// Column, counted from the system origin to the east.
    pub east: i32,
    /// Row, counted from the system origin to the north.
    pub north: i32,
    /// Numbers of sources, the most wanted first. Those left out are not used there.
    pub sources: Vec<u16>,
}

/// What covariance intersection makes small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Intersection {
    /// The determinant of the covariance of position and velocity.
    #[default]
    Determinant,
    /// The trace of the covariance of position.
    Trace,
}

impl HandOverSettings {
    /// The ramp from source `from` to source `to`.
    pub(crate) fn ramp(&self, from: u16, to: u16) -> &[f64] {
        let pair = self.pairs.iter().find(|pair| pair.from == from && pair.to == to);
        pair.map_or(&self.ramp, |pair| &pair.ramp)
    }
}

impl MosaicSettings {
    /// The list that holds at a place (east, north, up, metres); `None` where priorities decide.
    pub(crate) fn list_at(&self, place_m: [f64; 3]) -> Option<&[u16]> {
        let cell = |metres: f64| (metres / self.cell_m).floor() as i32;
        let here = (cell(place_m[0]), cell(place_m[1]));
        match self.cells.binary_search_by_key(&here, |cell| (cell.east, cell.north)) {
            Ok(index) => Some(&self.cells[index].sources),
            Err(_) => (!self.default.is_empty()).then_some(&self.default),
        }
    }
}

/// Variants of the residual V (TI-6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residual {
    /// Norm of the position difference over the axes.
    Position,
    /// Norm of the velocity difference over the axes.
    Velocity,
    /// Position difference, each axis on its own: an accuracy value, a choice and a weight per axis.
    PerAxis,
    /// |measured − predicted| where raw detections are delivered; `Position` for sources that deliver none.
    Innovation,
}

/// What decides between equal accuracy values (TI-11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tie {
    /// The source chosen last time, then priority.
    LastThenPriority,
    /// Priority alone.
    Priority,
}

/// Most stored reports per source and target.
pub const STORED_REPORTS_MAX: usize = 64;
/// Most refreshes that a hand-over can take.
pub const RAMP_MAX: usize = 256;
/// Most sources.
pub const SOURCES_MAX: usize = 64;

/// A setting that cannot work.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {reason}")]
pub struct SettingsError {
    /// Key, as the configuration file spells it; sources are `source[0]`, `source[1]`, …
    pub key: String,
    /// The value found.
    pub value: String,
    /// What is wrong with it, and what would be right.
    pub reason: String,
}

impl Settings {
    /// Looks for settings that cannot work.
    ///
    /// # Errors
    /// The first such setting, with key, value and remedy.
    pub fn check(&self) -> Result<(), SettingsError> {
        let capacity = &self.capacity;
        in_range("fusion.capacity.system_tracks", capacity.system_tracks as f64, 1.0, 1e6)?;
        in_range("fusion.capacity.sensor_tracks", capacity.sensor_tracks as f64, 1.0, 1e7)?;
        in_range(
            "fusion.capacity.stored_reports",
            capacity.stored_reports as f64,
            1.0,
            STORED_REPORTS_MAX as f64,
        )?;
        in_range(
            "source (number of sources)",
            self.sources.len() as f64,
            1.0,
            SOURCES_MAX as f64,
        )?;
        let association = &self.association;
        for (key, value, low, high) in [
            ("join_gate", association.join_gate, 0.1, 1e4),
            ("keep_gate", association.keep_gate, association.join_gate, 1e6),
            ("velocity_gate", association.velocity_gate, 0.1, 1e6),
            ("extent_sigma_m", association.extent_sigma_m, 0.0, 1e4),
            ("target_extent_m", association.target_extent_m, 0.0, 1e4),
            ("height_gate_m", association.height_gate_m, 0.0, 1e5),
            ("split_reports", f64::from(association.split_reports), 1.0, 1e6),
            ("merge_reports", f64::from(association.merge_reports), 1.0, 1e6),
            ("cell_m", association.cell_m, 1.0, 1e6),
            ("error_correlation", association.error_correlation, 0.0, 0.9),
            ("scan_wait", association.scan_wait, 0.0, 1.0),
        ] {
            in_range(&format!("fusion.association.{key}"), value, low, high)?;
        }
        in_range(
            "fusion.life.confirm_reports",
            f64::from(self.life.confirm_reports),
            1.0,
            1e6,
        )?;
        in_range(
            "fusion.life.terminate_s",
            self.life.terminate_ns as f64 / messages::NS_PER_S,
            1e-3,
            1e5,
        )?;
        in_range(
            "fusion.life.tentative_s",
            self.life.tentative_ns as f64 / messages::NS_PER_S,
            1e-3,
            1e5,
        )?;
        in_range("fusion.process_noise_m2ps3", self.process_noise_m2ps3, 0.0, 1e6)?;
        if let Some(refresh_ns) = self.refresh_ns {
            in_range("fusion.refresh_s", refresh_ns as f64 / messages::NS_PER_S, 1e-3, 3600.0)?;
        }
        let delay_s = self.refresh_delay_ns as f64 / messages::NS_PER_S;
        in_range("fusion.refresh_delay_s", delay_s, 0.0, 3600.0)?;
        self.rule.check(self.sources.len())?;
        for (index, source) in self.sources.iter().enumerate() {
            source.check(&format!("source[{index}]"))?;
        }
        self.check_reference()
    }

    /// Longest time between two reports of any source, seconds.
    pub(crate) fn longest_period_s(&self) -> f64 {
        let longest = self.sources.iter().map(|source| source.period_ns).max();
        longest.unwrap_or(0) as f64 / messages::NS_PER_S
    }

    /// TI-8: alpha cannot be normalised by a source whose alpha is 0.
    fn check_reference(&self) -> Result<(), SettingsError> {
        let Some(number) = self.rule.reference_source else {
            return Ok(());
        };
        let Some(source) = self.sources.get(usize::from(number)) else {
            return Err(refused(
                "fusion.rule.reference_source",
                number,
                "there is no such source",
            ));
        };
        let smallest = match source.accuracy.base {
            AccuracyBase::Constant { sigma_m } => sigma_m,
            AccuracyBase::Polar { range_sigma_m, .. } => range_sigma_m,
            AccuracyBase::Estimated { initial_m, .. } => initial_m,
            AccuracyBase::Reported => {
                let reason = "its accuracy is what it reports, so nothing is known of it where it reports nothing; \
                              name a source with another model";
                return Err(refused("fusion.rule.reference_source", &source.name, reason));
            }
        };
        if source.adjustment * smallest > 0.0 {
            return Ok(());
        }
        let reason = "its adjustment × accuracy is 0, so nothing can be expressed relative to it; \
                      give that source an accuracy and an adjustment above 0, or name another";
        Err(refused("fusion.rule.reference_source", &source.name, reason))
    }
}

impl RuleSettings {
    fn check(&self, sources: usize) -> Result<(), SettingsError> {
        let scans = f64::from(self.quality_scans);
        for (key, value, low, high) in [
            ("recency", self.recency, 1e-6, 1.0),
            ("overdue_periods", self.overdue_periods, 0.5, 1e3),
            ("quality_scans", scans, 2.0, f64::from(SCANS_MAX)),
            ("hysteresis", self.hysteresis, 1e-6, 1.0),
            ("hold_refreshes", f64::from(self.hold_refreshes), 0.0, 1e6),
            ("common_noise_m2ps3", self.common_noise_m2ps3.unwrap_or(0.0), 0.0, 1e6),
            ("mosaic.cell_m", self.mosaic.cell_m, 1.0, 1e7),
        ] {
            in_range(&format!("fusion.rule.{key}"), value, low, high)?;
        }
        let check_sources = |key: &str, list: &[u16]| match list.iter().find(|source| usize::from(**source) >= sources)
        {
            Some(source) => Err(refused(key, source, "there is no such source")),
            None => Ok(()),
        };
        check_ramp("fusion.rule.hand_over.ramp", &self.hand_over.ramp)?;
        for (index, pair) in self.hand_over.pairs.iter().enumerate() {
            let key = format!("fusion.rule.hand_over.pair[{index}]");
            check_sources(&key, &[pair.from, pair.to])?;
            check_ramp(&format!("{key}.ramp"), &pair.ramp)?;
        }
        check_sources("fusion.rule.mosaic.default", &self.mosaic.default)?;
        for cell in &self.mosaic.cells {
            check_sources("fusion.rule.mosaic.cell", &cell.sources)?;
        }
        let places = self.mosaic.cells.iter().map(|cell| (cell.east, cell.north));
        if !places.is_sorted_by(|a, b| a < b) {
            let reason = "cells must stand in ascending order of (east, north), each once";
            return Err(refused("fusion.rule.mosaic.cell", "unordered", reason));
        }
        Ok(())
    }
}

/// TI-14: a rising sequence within [0, 1].
fn check_ramp(key: &str, ramp: &[f64]) -> Result<(), SettingsError> {
    for eta in ramp {
        in_range(key, *eta, 0.0, 1.0)?;
    }
    if !ramp.is_sorted() {
        return Err(refused(key, format!("{ramp:?}"), "a ramp must rise"));
    }
    in_range(&format!("{key} (length)"), ramp.len() as f64, 0.0, RAMP_MAX as f64)
}

impl SourceSettings {
    fn check(&self, key: &str) -> Result<(), SettingsError> {
        in_range(
            &format!("{key}.period_s"),
            self.period_ns as f64 / messages::NS_PER_S,
            1e-3,
            3600.0,
        )?;
        in_range(
            &format!("{key}.fresh_s"),
            self.fresh_ns as f64 / messages::NS_PER_S,
            1e-3,
            1e5,
        )?;
        in_range(&format!("{key}.accuracy.adjustment"), self.adjustment, 0.0, 1e9)?;
        in_range(
            &format!("{key}.accuracy.per_speed_s"),
            self.accuracy.per_speed_s,
            0.0,
            1e6,
        )?;
        for (name, factor) in &self.accuracy.conditions {
            in_range(&format!("{key}.accuracy.conditions.{name}"), *factor, 0.0, 1e6)?;
        }
        match self.accuracy.base {
            AccuracyBase::Reported => Ok(()),
            AccuracyBase::Constant { sigma_m } => in_range(&format!("{key}.accuracy.sigma_m"), sigma_m, 0.0, 1e6),
            AccuracyBase::Polar {
                range_sigma_m,
                azimuth_sigma_rad,
                ..
            } => {
                in_range(&format!("{key}.accuracy.range_sigma_m"), range_sigma_m, 0.0, 1e6)?;
                in_range(
                    &format!("{key}.accuracy.azimuth_sigma_deg"),
                    azimuth_sigma_rad.to_degrees(),
                    0.0,
                    90.0,
                )
            }
            AccuracyBase::Estimated { initial_m, memory } => {
                in_range(&format!("{key}.accuracy.initial_m"), initial_m, 1e-3, 1e6)?;
                in_range(&format!("{key}.accuracy.memory"), memory, 1.0, 1e9)
            }
        }
    }
}

fn in_range(key: &str, value: f64, low: f64, high: f64) -> Result<(), SettingsError> {
    // Written so that NaN is refused.
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(refused(key, value, &format!("must lie between {low} and {high}")))
}

fn refused(key: &str, value: impl ToString, reason: &str) -> SettingsError {
    SettingsError {
        key: key.to_owned(),
        value: value.to_string(),
        reason: reason.to_owned(),
    }
}

impl Default for AssociationSettings {
    fn default() -> Self {
        Self {
            use_identity: true,
            join_gate: association::distance::gate2(0.001),
            keep_gate: association::distance::gate2(1e-6),
            velocity_gate: association::distance::gate2(0.001),
            extent_sigma_m: 0.0,
            target_extent_m: 0.0,
            height_gate_m: 600.0,
            split_reports: 5,
            merge_reports: 2,
            cell_m: 1000.0,
            error_correlation: 0.1,
            scan_wait: 0.05,
        }
    }
}

impl Default for LifeSettings {
    fn default() -> Self {
        Self {
            confirm_reports: 3,
            terminate_ns: 20_000_000_000,
            tentative_ns: 6_000_000_000,
        }
    }
}

impl Default for Capacity {
    fn default() -> Self {
        Self {
            system_tracks: 2_000,
            sensor_tracks: 8_000,
            stored_reports: 5,
        }
    }
}

impl Default for MosaicSettings {
    fn default() -> Self {
        Self {
            cell_m: 10_000.0,
            default: Vec::new(),
            cells: Vec::new(),
        }
    }
}

impl Default for RuleSettings {
    fn default() -> Self {
        Self {
            rule: FusionRule::Auto,
            residual: Residual::Position,
            recency: 1.0,
            reference_source: None,
            tie: Tie::LastThenPriority,
            overdue_periods: 1.5,
            quality_scans: 10,
            hand_over: HandOverSettings::default(),
            hysteresis: 1.0,
            hold_refreshes: 0,
            mosaic: MosaicSettings::default(),
            intersection: Intersection::default(),
            common_noise_m2ps3: None,
        }
    }
}
