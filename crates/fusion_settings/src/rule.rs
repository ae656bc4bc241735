//! Settings of the rule by which sources are weighed, and of hand-over and mosaic.

use std::collections::BTreeSet;

use messages::{FusionRule, NO_SOURCE};
use settings::SettingsError;

use crate::SCANS_MAX;
use crate::source_ref::SourceRef;

/// Most refreshes that a hand-over can take.
pub const RAMP_MAX: usize = 256;

settings::settings! {
    /// Weighing of the sources.
    pub struct RuleSettings {
        /// Name of the rule (list: `koseki fuse --help`).
        name: RuleName = RuleName::default();
        /// Residual V (TI-6): `position`, norm of the position difference over the axes; `velocity`, of the velocity
        /// difference; `per-axis`, position difference with an accuracy value, a choice and a weight per axis;
        /// `innovation`, |measured − predicted| where raw detections are delivered, else `position`.
        residual: ResidualKind = ResidualKind::Position;
        /// Weight of an earlier report relative to the next newer one in the mean of second positions (TI-5); 1 is
        /// plain.
        recency: f64 = 1.0, in [1e-6, 1];
        /// Name of the source with alpha normalised to 1 (TI-8).
        reference_source: Option<SourceRef> = None;
        /// Accuracy values lambda (TI-9) also for rules that do not need lambda and use the target's filter: the last
        /// reports of each sensor track are then kept. With a state per report, the engine's work increases by 7 %.
        accuracy_values: Option<bool> = None, usually "true with refresh_s, else false";
        /// Decision between equal accuracy values (TI-11): the source chosen last time, then priority; or priority
        /// alone.
        tie: Tie = Tie::LastThenPriority;
        /// Age after which a source has missed its expected report, in periods of the source (TI-15).
        overdue_periods: f64 = 1.5, in [0.5, 1e3];
        /// Due scans over which the quality index is summed (N of QF-4).
        quality_scans: u32 = 10, in [2, SCANS_MAX];
        /// Factor by which another source's lambda must be below that of the present one (h of TI-18); 1 is TI-11.
        hysteresis: f64 = 1.0, in [1e-6, 1];
        /// Refreshes for which a chosen source is kept at least (TI-18).
        hold_refreshes: u32 = 0, in [0, 1e6];
        /// Measure that covariance intersection makes small: the determinant of the covariance of position and
        /// velocity, or the trace of that of position.
        intersection: Intersection = Intersection::Determinant;
        /// Spectral density of the process noise that the sources' errors have in common.
        common_noise_m2ps3: Option<f64> = None, in [0, 1e6], usually "that of fusion";
        /// Passing of the output from one source to another (TI-13 … TI-16).
        hand_over: HandOverSettings = HandOverSettings::default();
        /// Cells of the area, each with a priority list of sources (QF-9).
        mosaic: MosaicSettings = MosaicSettings::default();
    }

    /// Passing of the output from one source to another (TI-13 … TI-16).
    pub struct HandOverSettings beside [ordered: Vec<OrderedEta>] {
        check HandOverSettings::check;
        /// Coefficients eta_0 of the new source at the first refresh and the following, increasing; after the last
        /// coefficient 1. Empty: 1 at once.
        ramp: Vec<f64> = Vec::new(), in [0, 1];
        /// Eta_0 comes from the covariance traces of both sources, for one refresh (TI-16). If a trace is unusable, the
        /// ramp applies.
        by_traces: bool = false;
        /// Blending if the previous source has missed its expected report (TI-15): `switch`, the new source gets the
        /// whole weight at once; `blend`, with the last stored report of the previous source, moved to the reference
        /// time.
        drop_out: DropOut = DropOut::Switch;
        /// Ordered pair of sources with a ramp of its own.
        pairs as "pair": Vec<PairRamp> = Vec::new();
    }

    /// Ramp from the previous source to the new source.
    pub struct PairRamp {
        check PairRamp::check;
        /// Name of the previous source.
        from: SourceRef;
        /// Name of the new source.
        to: SourceRef;
        /// Coefficients eta_0 at successive refreshes, instead of the general `ramp`.
        ramp: Vec<f64>, in [0, 1];
    }

    /// Cells of the area, each with a priority list of sources (QF-9).
    pub struct MosaicSettings {
        check MosaicSettings::check;
        /// Width of a cell. Cell (0, 0) begins at the system origin and lies north-east of it.
        cell_m: f64 = 10_000.0, in [1, 1e7];
        /// Names of sources, most preferred first, outside the listed cells. Empty: by the sources' priorities.
        default: Vec<SourceRef> = Vec::new();
        /// Smallest quality index (QF-4) with which a source is chosen, in scans of the last `quality_scans`; below it,
        /// the next source of the list is chosen. Where no source reaches it, the first present source is chosen.
        quality_min: u32 = 0, in [0, SCANS_MAX];
        /// Cell with a separate list.
        cells as "cell": Vec<MosaicCell> = Vec::new();
    }

    /// A cell.
    pub struct MosaicCell {
        /// Column, counted from the system origin to the east.
        east: i32;
        /// Row, counted from the system origin to the north.
        north: i32;
        /// Names of sources, most preferred first. Other sources are not used in the cell.
        sources: Vec<SourceRef>;
    }
}

/// Coefficient eta_0 that an order sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderedEta {
    /// Source that is left; 65535: any.
    pub from: u16,
    /// Source that takes over; 65535: any.
    pub to: u16,
    /// eta_0 at the first refresh.
    pub eta: [f64; 1],
}

settings::words! {
    /// Variants of the residual V (TI-6).
    pub enum ResidualKind {
        /// Norm of the position difference over the axes.
        Position = "position",
        /// Norm of the velocity difference over the axes.
        Velocity = "velocity",
        /// Position difference, each axis on its own: an accuracy value, a choice and a weight per axis.
        PerAxis = "per-axis",
        /// |measured − predicted| where raw detections are delivered; `Position` for sources that deliver none.
        Innovation = "innovation",
    }

    /// Decision between equal accuracy values (TI-11).
    pub enum Tie {
        /// The source chosen last time, then priority.
        LastThenPriority = "last-then-priority",
        /// Priority alone.
        Priority = "priority",
    }

    /// Blending when the source that is left has missed its expected report (TI-15).
    pub enum DropOut {
        /// The new one gets all at once.
        Switch = "switch",
        /// It is blended by its last stored report, moved to the reference time.
        Blend = "blend",
    }

    /// Measure that covariance intersection makes small.
    pub enum Intersection {
        /// The determinant of the covariance of position and velocity.
        Determinant = "determinant",
        /// The trace of the covariance of position.
        Trace = "trace",
    }
}

/// The name of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RuleName(pub FusionRule);

impl Default for RuleName {
    /// The best there is for unknown data.
    fn default() -> Self {
        Self(FusionRule::Auto)
    }
}

settings::spelt_as!(
    RuleName,
    String,
    "name of a rule",
    |word| FusionRule::from_word(&word)
        .map(Self)
        .ok_or_else(|| settings::not_known(&word, &FusionRule::ALL.map(FusionRule::word))),
    |rule| rule.0.word().to_owned()
);

/// A rising sequence within [0, 1] (TI-14).
fn check_ramp(ramp: &[f64]) -> Result<(), SettingsError> {
    let what = match ramp.len() {
        length if length > RAMP_MAX => format!("{length} values; at most {RAMP_MAX} are possible"),
        _ if !ramp.is_sorted() => format!("{ramp:?}: a ramp must rise"),
        _ => return Ok(()),
    };
    Err(SettingsError::new("ramp", what))
}

impl PairRamp {
    fn check(&self) -> Result<(), SettingsError> {
        check_ramp(&self.ramp)
    }
}

impl HandOverSettings {
    fn check(&self) -> Result<(), SettingsError> {
        check_ramp(&self.ramp)?;
        let mut known = BTreeSet::new();
        for (index, pair) in self.pairs.iter().enumerate() {
            let (from, to) = (&pair.from, &pair.to);
            if !known.insert([(&from.name, from.number), (&to.name, to.number)]) {
                let what = format!("from \"{}\" to \"{}\" has been given before", from.name, to.name);
                return Err(SettingsError::new(format!("pair[{index}].from"), what));
            }
        }
        Ok(())
    }

    /// The coefficient that an order in force sets for hand-overs from source `from` to source `to`: the newest.
    pub fn ordered(&self, from: u16, to: u16) -> Option<&[f64]> {
        let holds = |ordered: &&OrderedEta| {
            let is_meant = |named: u16, source: u16| named == NO_SOURCE || named == source;
            is_meant(ordered.from, from) && is_meant(ordered.to, to)
        };
        self.ordered.iter().rev().find(holds).map(|ordered| &ordered.eta[..])
    }

    /// The ramp from source `from` to source `to`.
    pub fn ramp(&self, from: u16, to: u16) -> &[f64] {
        if let Some(ordered) = self.ordered(from, to) {
            return ordered;
        }
        let pair = self
            .pairs
            .iter()
            .find(|pair| (pair.from.number, pair.to.number) == (from, to));
        pair.map_or(&self.ramp, |pair| &pair.ramp)
    }
}

impl MosaicSettings {
    fn check(&self) -> Result<(), SettingsError> {
        let mut known = BTreeSet::new();
        for (index, cell) in self.cells.iter().enumerate() {
            if !known.insert((cell.east, cell.north)) {
                let what = format!("cell {} east, {} north has been given before", cell.east, cell.north);
                return Err(SettingsError::new(format!("cell[{index}].east"), what));
            }
        }
        Ok(())
    }

    /// The list that holds at a place (east, north, up, metres); `None` where priorities decide.
    pub fn list_at(&self, place_m: [f64; 3]) -> Option<&[SourceRef]> {
        let cell = |metres: f64| (metres / self.cell_m).floor() as i32;
        let here = (cell(place_m[0]), cell(place_m[1]));
        match self.cells.binary_search_by_key(&here, |cell| (cell.east, cell.north)) {
            Ok(index) => Some(&self.cells[index].sources),
            Err(_) => (!self.default.is_empty()).then_some(&self.default),
        }
    }
}
