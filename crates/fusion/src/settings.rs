//! The engine's settings: the keys of `[fusion]`, and what is known of each source.

use std::collections::{BTreeMap, BTreeSet};

use messages::{FusionRule, NO_SOURCE, NS_PER_S};
use serde::{Deserialize, Serialize};
use settings::{Degrees, Node, Place, Range, Seconds, SettingsError, Value};

use crate::quality::SCANS_MAX;
use crate::region::Region;

/// Most stored reports per source and target.
pub const STORED_REPORTS_MAX: usize = 64;
/// Most refreshes that a hand-over can take.
pub const RAMP_MAX: usize = 256;
/// Most sources.
pub const SOURCES_MAX: usize = 64;
/// The word for `shares` where nobody knows.
const UNKNOWN: &str = "unknown";
/// A report is fresh for so many periods where nobody says more: two may be missed.
pub(crate) const FRESH_PERIODS: f64 = 2.5;

settings::settings! {
    /// Fusion.
    pub struct Settings beside [sources: Vec<SourceSettings>] {
        /// Spectral density of the white-noise acceleration with which states are carried forward.
        process_noise_m2ps3: f64 = 1.0, in [0, 1e6];
        /// Covariances that claim too much are inflated (BF-5).
        consistency: bool = true;
        /// Time between two states of a system track: published at its whole multiples for every system track (QF-6).
        refresh_s: Option<Seconds> = None, in [1e-3, 3600], usually "whenever a report has changed a system track";
        /// Time after a refresh time at which its states are formed. Reports measured meanwhile lie on the far side of
        /// it, so that slow sources are interpolated where they would be extrapolated (QF-6).
        refresh_delay_s: Seconds = Seconds::default(), in [0, 3600];
        /// States by the sources here alone are published for other centres, beside those with what they say.
        exchange: bool = false;
        /// Borders with other centres.
        border: BorderSettings = BorderSettings::default();
        /// Sizes of the tables.
        capacity: Capacity = Capacity::default();
        /// Association of reports with system tracks (TI-3).
        association: AssociationSettings = AssociationSettings::default();
        /// Life of system tracks.
        life: LifeSettings = LifeSettings::default();
        /// Existence of targets, as far as it shows in what sources report and do not report (BF-2).
        existence: ExistenceSettings = ExistenceSettings::default();
        /// Systematic errors of the sources (BF-3).
        registration: RegistrationSettings = RegistrationSettings::default();
        /// Weighing of the sources.
        rule: RuleSettings = RuleSettings::default();
    }

    /// Borders with other centres, where there are regions: `[[region]]`.
    pub struct BorderSettings beside [regions: Vec<Region>] {
        /// Distance from another centre's region within which it is told of targets.
        strip_m: f64 = 20e3, in [0, 1e6];
        /// Distance beyond its owner's region, and time spent there, after which a target changes hands.
        hand_over_m: f64 = 500.0, in [0, 1e5];
        /// See `hand_over_m`.
        hand_over_s: Seconds = Seconds::of(10.0), in [0, 3600];
    }

    /// Sizes of the tables. Everything is allocated at the start; a full table refuses new entries, counted (PL-4). A
    /// source may always have its fair share of a table, an equal part for each; above that it gets what the others
    /// have not needed yet.
    #[derive(Copy)]
    pub struct Capacity {
        /// System tracks.
        system_tracks: Option<usize> = None, in [1, 1e6], usually "2000; offline as seen";
        /// Live sensor tracks of all sources together.
        sensor_tracks: Option<usize> = None, in [1, 1e7], usually "8000; offline as seen";
        /// Earlier reports kept per source and target, beside the latest (N of TI-4).
        stored_reports: usize = 5, in [1, STORED_REPORTS_MAX];
        /// Reports that wait per source in order `time`: a source must be able to hand over a whole slice at any time.
        queue: usize = 4096, in [128, 1e7];
    }

    /// Association of reports with system tracks (TI-3).
    #[derive(Copy)]
    pub struct AssociationSettings {
        check AssociationSettings::check;
        /// Identity is used. Without it only position and motion count; identities are still shown.
        use_identity: bool = true;
        /// Probability that a report of a target lies in the gate for joining a track: on d² in the plane (chi-square,
        /// two degrees of freedom).
        join_probability: GateProbability = GateProbability::of(0.999), in [0.5, 1.0 - 1e-12];
        /// Gate on d² in the plane for staying: wider than joining, so that pairs do not flicker.
        keep_gate: f64 = association::distance::gate2(1e-6), in [0.1, 1e6], usually "27.6: probability 0.999999";
        /// Probability that the gate on d² of position, velocity and height together allows for the horizontal
        /// velocity.
        velocity_probability: GateProbability = GateProbability::of(0.999), in [0.5, 1.0 - 1e-12];
        /// Standard deviation of where on a target a sensor's detection point lies; for large targets.
        extent_sigma_m: f64 = 0.0, in [0, 1e4];
        /// Distance within which a second track of one source is taken for another part of the same target.
        target_extent_m: f64 = 0.0, in [0, 1e4];
        /// Largest difference of two known heights for joining.
        height_gate_m: f64 = 600.0, in [0, 1e5];
        /// Reports in a row that must miss the keep gate before a sensor track is taken out.
        split_reports: u32 = 5, in [1, 1e6];
        /// Reports in a row that must find the same other track before two are merged.
        merge_reports: u32 = 2, in [1, 1e6];
        /// Cell width of the neighbourhood grid.
        cell_m: f64 = 1000.0, in [1, 1e6];
        /// Part of the variance of a difference that two tracks of one target have in common: both lag behind the same
        /// manoeuvres.
        error_correlation: f64 = 0.1, in [0, 0.9];
        /// Time for which sensor tracks that belong nowhere yet wait for the rest of their scan, as a part of their
        /// source's period; 0: each is placed at once, without regard to the others.
        scan_wait: f64 = 0.05, in [0, 1];
    }

    /// Life of system tracks (QF-8 names the counts; TI has none).
    #[derive(Copy)]
    pub struct LifeSettings {
        /// Reports until a tentative track is confirmed.
        confirm_reports: u32 = 3, in [1, 1e6];
        /// Time without a report after which a confirmed track ends.
        terminate_s: Option<Seconds> = None, in [1e-3, 1e5], usually "20, and more than the slowest source's `fresh_s`";
        /// Time without a report after which a tentative track ends.
        tentative_s: Option<Seconds> = None, in [1e-3, 1e5], usually "6, at least the slowest source's `fresh_s`";
    }

    /// Existence of targets, as far as it shows in what sources report and do not report (BF-2). Worths are logarithms
    /// of how much likelier a target is than a false track; those of one claim add up.
    #[derive(Copy)]
    pub struct ExistenceSettings {
        /// Worth above which a target is believed that one source alone reports; the silence of each source that covers
        /// the place counts against it.
        believed: f64 = -0.7, in [-20, 20], usually "-0.7: about one to two against it";
        /// Worth of each further report of the claim's sensor track: −ln of the share of false tracks that go on.
        persistence: f64 = 0.223, in [0, 10], usually "0.223: one false track in five ends with each report";
        /// Reports before persistence counts.
        persistence_reports: u32 = 3, in [0, 1e6];
        /// Worth of an address: noise does not answer interrogations.
        address: f64 = 5.0, in [0, 20];
        /// Sum of ln(1 − probability of detection) over the misses since any source has seen it, at which a confirmed
        /// target is taken to be gone, and not shown until one sees it again.
        gone: f64 = -6.9, in [-50, -0.1], usually "-6.9: one target in a thousand would be missed that often";
        /// Misses in a row of one source that count for that: what hides a target once hides it again.
        misses: u32 = 2, in [1, 1000];
    }

    /// Systematic errors of the sources (BF-3).
    pub struct RegistrationSettings {
        /// They are estimated and removed.
        enabled: bool = true;
        /// Name of the source that is taken as true.
        reference_source: Option<SourceRef> = None, usually "the middle of all sources";
        /// Time constant with which old comparisons are forgotten.
        memory_s: f64 = 600.0, in [1, 1e6];
        /// Gross errors of azimuth, range, time or place, of which a source's tracks join none, are taken off where a
        /// third source, the reference source or addresses tell whose they are. They are told in any case.
        gross: bool = false;
    }

    /// Weighing of the sources.
    pub struct RuleSettings {
        /// Name of the rule; `koseki fuse --help` lists them.
        name: RuleName = RuleName::default();
        /// Residual V (TI-6): `position`, norm of the position difference over the axes; `velocity`, of the velocity
        /// difference; `per-axis`, position difference with an accuracy value, a choice and a weight per axis;
        /// `innovation`, |measured − predicted| where raw detections are delivered, else `position`.
        residual: Residual = Residual::Position;
        /// Weight of an earlier report relative to the next newer one in the mean of second positions (TI-5); 1 is
        /// plain.
        recency: f64 = 1.0, in [1e-6, 1];
        /// Name of the source whose alpha is normalised to 1 (TI-8).
        reference_source: Option<SourceRef> = None;
        /// Accuracy values lambda (TI-9) are given also by rules that need none, whose states are those of the target's
        /// filter: of each sensor track the last reports are then kept. Where each report gives a state, that makes the
        /// engine's work 7 % more.
        accuracy_values: Option<bool> = None, usually "true with refresh_s, else false";
        /// Decision between equal accuracy values (TI-11): the source chosen last time, then priority; or priority
        /// alone.
        tie: Tie = Tie::LastThenPriority;
        /// Age beyond which a source has missed its expected report, in periods of its own (TI-15).
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
        /// Cells of the area and the sources that hold there (QF-9).
        mosaic: MosaicSettings = MosaicSettings::default();
    }

    /// Passing of the output from one source to another (TI-13 … TI-16).
    pub struct HandOverSettings {
        check HandOverSettings::check;
        /// Coefficients eta_0 of the new source at the first refresh and those that follow, rising; after the last it
        /// is 1. Empty: at once.
        ramp: Vec<f64> = Vec::new(), in [0, 1];
        /// Eta_0 comes from the covariance traces of both sources, for one refresh (TI-16); where a trace cannot be
        /// used the ramp holds.
        by_traces: bool = false;
        /// Blending when the source that is left has missed its expected report (TI-15): `switch`, the new one gets all
        /// at once; `blend`, by its last stored report, moved to the reference time.
        drop_out: DropOut = DropOut::Switch;
        /// Ordered pair of sources with a ramp of its own.
        pairs as "pair": Vec<PairRamp> = Vec::new();
    }

    /// The ramp from one source to another.
    pub struct PairRamp {
        check PairRamp::check;
        /// Name of the source that is left.
        from: SourceRef;
        /// Name of the source that takes over.
        to: SourceRef;
        /// Coefficients eta_0 at successive refreshes, as for those that are no pair.
        ramp: Vec<f64>, in [0, 1];
    }

    /// Cells of the area and the sources that hold there (QF-9).
    pub struct MosaicSettings {
        check MosaicSettings::check;
        /// Width of a cell. Cell (0, 0) begins at the system origin and lies north-east of it.
        cell_m: f64 = 10_000.0, in [1, 1e7];
        /// Names of sources, the most wanted first, where no cell says otherwise. Empty: by the sources' priorities.
        default: Vec<SourceRef> = Vec::new();
        /// Cell with a list of its own.
        cells as "cell": Vec<MosaicCell> = Vec::new();
    }

    /// One cell.
    pub struct MosaicCell {
        /// Column, counted from the system origin to the east.
        east: i32;
        /// Row, counted from the system origin to the north.
        north: i32;
        /// Names of sources, the most wanted first. Those left out are not used there.
        sources: Vec<SourceRef>;
    }

    /// Weighing of one source (TI-2).
    pub struct Weighing {
        /// Time between two reports of one target. A tracker of plots finds it in north marks, or in the plots.
        period_s: Option<f64> = None, in [1e-3, 3600], usually "1, or longer as learned; offline as seen";
        /// Age beyond which a report no longer contributes, at least a period.
        fresh_s: Option<f64> = None, in [1e-3, 1e5], usually "2.5 periods";
        /// Priority for ties: of equally good sources the one with the smallest number is taken (TI-11).
        priority: Option<u32> = None, usually "its place";
        /// Height above the system origin beyond which this source cannot see targets.
        ceiling_m: Option<f64> = None;
        /// Names of sources whose measurements are in its tracks too: together they count once; or "unknown": its
        /// tracks are the system tracks of another centre, of whatever sensors.
        shares: Shares = Shares::default();
        /// Names of sources that are never taken for the same, however alike their reports are.
        independent_of: Vec<SourceRef> = Vec::new();
        /// Sensor accuracy (TI-7).
        accuracy: Option<AccuracyTable> = None, usually "20 m; offline as it states";
        /// Where it sees.
        coverage: Option<CoverageTable> = None, usually "learned from its reports";
    }

    /// Sensor accuracy s ≥ 0 as a function of conditions (TI-7).
    pub struct AccuracyTable {
        /// Kind of accuracy: `constant`, the same everywhere; `polar`, range and azimuth errors, turned into a position
        /// error at the target's place; `reported`, root mean square of the horizontal standard deviations that the
        /// source states; `estimated`, root mean square of the source's own residuals over its recent reports.
        model: AccuracyModel = AccuracyModel::Constant;
        /// Constant accuracy.
        sigma_m: f64 = 20.0, in [0, 1e6];
        /// Polar: range error.
        range_sigma_m: f64 = 20.0, in [0, 1e6];
        /// Polar: azimuth error.
        azimuth_sigma_deg: Degrees = Degrees::of(0.1), in [0, 90];
        /// Estimated: accuracy until there are residuals.
        initial_m: f64 = 20.0, in [1e-3, 1e6];
        /// Estimated: number of residuals that the mean reaches back over.
        memory: f64 = 200.0, in [1, 1e9];
        /// Accuracy that is added per m/s of target speed.
        per_speed_s: f64 = 0.0, in [0, 1e6];
        /// Adjustment coefficient k (TI-8): small for a main source, large for a standby one.
        adjustment: f64 = 1.0, in [0, 1e9];
        /// Factors for named conditions (weather), which can be changed while running; 1 for those not named.
        conditions: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1e6];
    }

    /// Where a source sees; a key that is left out does not limit it.
    pub struct CoverageTable {
        check CoverageTable::check;
        /// Farthest horizontal distance.
        range_m: Option<f64> = None, in [1, 2e6];
        /// First and last azimuth of the sector that is seen, clockwise from north.
        sector_deg: Option<[Degrees; 2]> = None, in [-360, 360];
        /// Corners of the area that is seen, east and north in the system frame.
        polygon_m: Vec<[f64; 2]> = Vec::new(), in [-2e6, 2e6];
        /// Probability that it follows a target in there.
        probability: f64 = 0.9, in [0.01, 1];
    }
}

settings::words! {
    /// Variants of the residual V (TI-6).
    pub enum Residual {
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

    /// Kinds of sensor accuracy.
    pub enum AccuracyModel {
        /// The same everywhere.
        Constant = "constant",
        /// Range and azimuth errors.
        Polar = "polar",
        /// Root mean square of the standard deviations that the source states.
        Reported = "reported",
        /// Root mean square of the source's own residuals.
        Estimated = "estimated",
    }
}

/// A source that a key names: its number follows when all sources are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceRef {
    name: String,
    /// Its number, its place among the sources.
    pub number: u16,
}

impl From<u16> for SourceRef {
    fn from(number: u16) -> Self {
        Self {
            name: String::new(),
            number,
        }
    }
}

settings::spelt_as!(
    SourceRef,
    String,
    "name of a source",
    |name| Ok(Self { name, number: 0 }),
    |source| source.name.clone()
);

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

/// A gate on d² of two degrees of freedom that files state by its probability.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GateProbability {
    probability: f64,
    gate: f64,
}

impl GateProbability {
    /// The gate in which a target lies with this probability.
    pub fn of(probability: f64) -> Self {
        Self {
            probability,
            gate: -2.0 * (1.0 - probability).ln(),
        }
    }

    /// Greatest d².
    pub fn gate(self) -> f64 {
        self.gate
    }
}

settings::spelt_as!(
    GateProbability,
    f64,
    "number",
    |probability| Ok(Self::of(probability)),
    |gate| gate.probability
);

/// Sources whose measurements are in a source's tracks too.
#[derive(Clone, Debug, PartialEq)]
pub enum Shares {
    /// These.
    With(Vec<SourceRef>),
    /// Nobody knows: its tracks are another centre's.
    Unknown,
}

impl Default for Shares {
    fn default() -> Self {
        Self::With(Vec::new())
    }
}

impl Value for Shares {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        if node.get_ref().as_str() == Some(UNKNOWN) {
            *self = Self::Unknown;
            return Ok(());
        }
        let mut sources = Vec::new();
        Value::read(&mut sources, node, range, at)?;
        *self = Self::With(sources);
        Ok(())
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        match self {
            Self::With(sources) => sources.check(range, at),
            Self::Unknown => Ok(()),
        }
    }

    fn kind(&self) -> String {
        format!("{}, or \"{UNKNOWN}\"", Vec::<SourceRef>::new().kind())
    }

    fn text(&self) -> String {
        match self {
            Self::With(sources) => sources.text(),
            Self::Unknown => format!("\"{UNKNOWN}\""),
        }
    }
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
    /// Whether that is only the least, since nobody has stated it: a longer one is learned, and the next follows it.
    pub learns_period: bool,
    /// Age beyond which a report no longer contributes, nanoseconds.
    pub fresh_ns: i64,
    /// Sensor accuracy s (TI-7).
    pub accuracy: Accuracy,
    /// Adjustment coefficient k (TI-8).
    pub adjustment: f64,
    /// Priority for ties, smaller first (TI-11).
    pub priority: u32,
    /// Sources whose measurements are in its tracks too.
    pub shares: Vec<SourceRef>,
    /// Whether its tracks are the system tracks of another centre.
    pub is_centre: bool,
    /// Sources that are never taken for the same as this one.
    pub independent_of: Vec<SourceRef>,
    /// Height above the system origin beyond which it cannot see targets, metres.
    pub ceiling_m: f64,
    /// Where it sees; `None`: learned from its reports.
    pub coverage: Option<CoverageArea>,
    /// East and north of the sensor in the system frame, metres, from where it measures range and azimuth; `None`:
    /// unknown.
    pub place_m: Option<[f64; 2]>,
    /// What its reports may say, where nobody has looked at that before.
    pub limits: ReportLimits,
}

/// Limits of what a source's reports may say; what is beyond is rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportLimits {
    /// East and north of the sensor in the system frame, metres.
    pub place_m: [f64; 2],
    /// Largest horizontal distance from there, metres.
    pub range_m: f64,
    /// Greatest horizontal speed, metres per second.
    pub speed_mps: f64,
}

impl Default for ReportLimits {
    /// What a sensor on this planet can report.
    fn default() -> Self {
        Self {
            place_m: [0.0; 2],
            range_m: 1e8,
            speed_mps: 1e5,
        }
    }
}

impl SourceSettings {
    /// The source called `name`, whose sensor stands at `place_m` (east and north, metres) and reports every
    /// `period_s`. It is weighed as the file says, else it has this `accuracy` and `priority`.
    ///
    /// # Errors
    /// If its reports are not fresh for a period.
    pub fn new(
        name: &str,
        weighing: &Weighing,
        (period_s, priority): (f64, u32),
        place_m: [f64; 2],
        accuracy: &AccuracyTable,
    ) -> Result<Self, SettingsError> {
        let fresh_s = weighing.fresh_s.unwrap_or(FRESH_PERIODS * period_s);
        settings::within("fresh_s", fresh_s, period_s, 1e5)?;
        let accuracy = weighing.accuracy.as_ref().unwrap_or(accuracy);
        Ok(Self {
            name: name.to_owned(),
            sensor_uid: 0,
            period_ns: Seconds::of(period_s).ns(),
            learns_period: weighing.period_s.is_none() && weighing.fresh_s.is_none(),
            fresh_ns: Seconds::of(fresh_s).ns(),
            accuracy: accuracy.at(place_m),
            adjustment: accuracy.adjustment,
            priority: weighing.priority.unwrap_or(priority),
            shares: match &weighing.shares {
                Shares::With(sources) => sources.clone(),
                Shares::Unknown => Vec::new(),
            },
            is_centre: weighing.shares == Shares::Unknown,
            independent_of: weighing.independent_of.clone(),
            ceiling_m: weighing.ceiling_m.unwrap_or(f64::INFINITY),
            coverage: weighing.coverage.as_ref().map(|coverage| coverage.at(place_m)),
            place_m: None,
            limits: ReportLimits::default(),
        })
    }
}

/// Where a source sees targets, and how surely.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

impl AccuracyTable {
    /// The accuracy of a sensor at this place, east and north, metres.
    fn at(&self, place_m: [f64; 2]) -> Accuracy {
        Accuracy {
            base: match self.model {
                AccuracyModel::Constant => AccuracyBase::Constant { sigma_m: self.sigma_m },
                AccuracyModel::Polar => AccuracyBase::Polar {
                    place_m,
                    range_sigma_m: self.range_sigma_m,
                    azimuth_sigma_rad: self.azimuth_sigma_deg.rad(),
                },
                AccuracyModel::Reported => AccuracyBase::Reported,
                AccuracyModel::Estimated => AccuracyBase::Estimated {
                    initial_m: self.initial_m,
                    memory: self.memory,
                },
            },
            per_speed_s: self.per_speed_s,
            conditions: self.conditions.clone().into_iter().collect(),
        }
    }
}

impl CoverageTable {
    fn check(&self) -> Result<(), SettingsError> {
        if !(1..3).contains(&self.polygon_m.len()) {
            return Ok(());
        }
        let what = "a polygon has three corners or more, each [east, north]; leave it out for no further limit";
        Err(SettingsError::new("polygon_m", what))
    }

    /// Where the source at this place sees, east and north, metres.
    fn at(&self, place_m: [f64; 2]) -> CoverageArea {
        CoverageArea {
            place_m,
            range_m: self.range_m.unwrap_or(f64::INFINITY),
            sector_rad: self.sector_deg.map(|sector| sector.map(Degrees::rad)),
            polygon_m: self.polygon_m.clone(),
            probability: self.probability,
        }
    }
}

impl CoverageArea {
    /// The coverage of a sensor whose silence says nothing, like that of a direction finder: probability 0.
    pub fn none() -> Self {
        Self {
            place_m: [0.0; 2],
            range_m: f64::INFINITY,
            sector_rad: None,
            polygon_m: Vec::new(),
            probability: 0.0,
        }
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

impl AssociationSettings {
    fn check(&self) -> Result<(), SettingsError> {
        settings::within("keep_gate", self.keep_gate, self.join_gate(), 1e6)
    }

    /// Gate on d² in the plane (chi-square, two degrees of freedom) for joining a track.
    pub fn join_gate(&self) -> f64 {
        self.join_probability.gate()
    }

    /// Gate on d² of position, velocity and height together.
    pub fn scan_gate(&self) -> f64 {
        self.join_gate() + self.velocity_probability.gate()
    }
}

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

    /// The ramp from source `from` to source `to`.
    pub(crate) fn ramp(&self, from: u16, to: u16) -> &[f64] {
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
    pub(crate) fn list_at(&self, place_m: [f64; 3]) -> Option<&[SourceRef]> {
        let cell = |metres: f64| (metres / self.cell_m).floor() as i32;
        let here = (cell(place_m[0]), cell(place_m[1]));
        match self.cells.binary_search_by_key(&here, |cell| (cell.east, cell.north)) {
            Ok(index) => Some(&self.cells[index].sources),
            Err(_) => (!self.default.is_empty()).then_some(&self.default),
        }
    }
}

impl Settings {
    /// Names of the conditions (weather) that can hold, each in its place: first the one that does at the start. A name
    /// may come again.
    pub fn conditions(&self) -> impl Iterator<Item = &str> {
        let of_sources = self.sources.iter().flat_map(|source| &source.accuracy.conditions);
        std::iter::once("normal").chain(of_sources.map(|(name, _)| name.as_str()))
    }

    /// Rank of a source where one has to come first, the least being the first: the reference source, then by priority.
    pub(crate) fn rank(&self, source: u16) -> (bool, u32, u16) {
        let reference = self.registration.reference_source.as_ref();
        let is_reference = reference.is_some_and(|reference| reference.number == source);
        (!is_reference, self.sources[usize::from(source)].priority, source)
    }

    /// Whether one source comes before another, if there are both.
    pub(crate) fn comes_before(&self, source: u16, other: u16) -> bool {
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
    pub(crate) fn accuracy_values(&self) -> bool {
        self.rule.accuracy_values.unwrap_or(self.refresh_s.is_some())
    }

    /// Time between two states of a system track, nanoseconds; `None`: whenever a report has changed a system track.
    pub fn refresh_ns(&self) -> Option<i64> {
        self.refresh_s.map(Seconds::ns)
    }

    /// Longest time between two reports of any source, seconds.
    pub(crate) fn longest_period_s(&self) -> f64 {
        let longest = self.sources.iter().map(|source| source.period_ns).max();
        longest.unwrap_or(0) as f64 / NS_PER_S
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
