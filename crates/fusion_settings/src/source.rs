//! Settings of one source: its keys, and what the engine knows of the source.

use std::collections::{BTreeMap, BTreeSet};

use frames::Geodetic;
use messages::{AXES, BiasKind, NS_PER_S, Registration, registration_bits};
use settings::{Degrees, KeyValue, Node, Place, Range, Seconds, SettingsError};

use crate::coverage::{CoverageArea, CoverageTable};
use crate::source_ref::SourceRef;

/// Word for `shares` where the sources are not known.
const UNKNOWN: &str = "unknown";
/// Periods for which a report is fresh unless configured: two reports may be missed.
pub const FRESH_PERIODS: f64 = 2.5;

settings::settings! {
    /// Weighing of one source (TI-2).
    pub struct Weighing {
        /// Time between two reports of a target. For a tracked source, the adapter derives the period from north
        /// marks or plots.
        period_s: Option<f64> = None, in [1e-3, 3600], usually "1, or longer as learned; offline as seen";
        /// Age beyond which a report no longer contributes, at least a period.
        fresh_s: Option<f64> = None, in [1e-3, 1e5], usually "2.5 periods, or intervals of a target that is reported less often";
        /// Priority for ties: of equally good sources, the source with the smallest number is chosen (TI-11).
        priority: Option<u32> = None, usually "its place";
        /// Height above the system origin beyond which this source cannot see targets.
        ceiling_m: Option<f64> = None;
        /// Names of sources with the same measurements in their tracks: together they count once; or "unknown": the
        /// tracks are system tracks of another centre, from unknown sensors.
        shares: Shares = Shares::default();
        /// Names of sources that never count as dependent on this source, however similar their reports are.
        independent_of: Vec<SourceRef> = Vec::new();
        /// Whether targets report their own positions (ADS-B, AIS). The positions are checked by sources that measure
        /// targets of the same address.
        self_reported: Option<bool> = None, usually "as the technology; offline false";
        /// Whether its biases and the points that it detects on targets are estimated by comparison with others. Errors
        /// of located emitters are neither: each persists for minutes and changes with the geometry.
        registered: Option<bool> = None, usually "true; with [source.locator] false";
        /// Rounding of time stamps that are multiples of a coarse step, such as whole seconds: `down`, `nearest`,
        /// `unknown`, or `exact` if the measurements are made at these times. The step is learned; fine stamps are
        /// taken as they are.
        stamps: Option<StampRounding> = None, usually "unknown, if its stamps prove a coarse step";
        /// Sensor accuracy (TI-7).
        accuracy: Option<AccuracyTable> = None, usually "20 m; offline as it states";
        /// Known biases, subtracted from each report.
        correction: CorrectionTable = CorrectionTable::default();
        /// Coverage of the source.
        coverage: Option<CoverageTable> = None, usually "learned from its reports";
    }

    /// Known biases of a source, subtracted from each of its reports before any other use. `koseki status` and the
    /// report print the estimated values as these lines.
    #[derive(Copy)]
    pub struct CorrectionTable {
        /// Azimuth bias, positive for azimuths that are too large; needs the position of the sensor.
        azimuth_deg: Degrees = Degrees::of(0.0), in [-180, 180];
        /// Range bias, positive for ranges that are too long; needs the position of the sensor.
        range_m: f64 = 0.0, in [-1e6, 1e6];
        /// Time offset, positive for reports that show targets where they were earlier.
        time_s: f64 = 0.0, in [-3600, 3600];
        /// Offset east.
        east_m: f64 = 0.0, in [-1e6, 1e6];
        /// Offset north.
        north_m: f64 = 0.0, in [-1e6, 1e6];
        /// Offset up.
        up_m: f64 = 0.0, in [-1e5, 1e5];
    }

    /// Sensor accuracy s ≥ 0 as a function of conditions (TI-7).
    pub struct AccuracyTable {
        check AccuracyTable::check;
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
        /// Estimated: number of recent residuals in the mean.
        memory: f64 = 200.0, in [1, 1e9];
        /// Addition to the accuracy value per m/s of target speed.
        per_speed_s: f64 = 0.0, in [0, 1e6];
        /// Adjustment coefficient k (TI-8): small for a main source, large for a standby one.
        adjustment: f64 = 1.0, in [0, 1e9];
        /// Factors for named conditions (weather), which an order can change during operation; 1 for other conditions.
        conditions: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1e6];
        /// Methods of observation of a source that changes its method and states it in each report (TI-2).
        methods as "method": Vec<MethodAccuracy> = Vec::new();
    }

    /// Accuracy of one method of observation, relative to the source's.
    pub struct MethodAccuracy {
        /// Number of the method in the reports.
        number: u8, in [1, 255];
        /// Factor of the accuracy value while the source observes by this method.
        factor: f64 = 1.0, in [0, 1e6];
        /// Factors for named conditions (weather) instead of those of the source.
        conditions: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1e6];
    }
}

settings::words! {
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

settings::words! {
    /// Rounding of time stamps to multiples of a step.
    pub enum StampRounding {
        /// To the multiple before.
        Down = "down",
        /// To the nearest multiple.
        Nearest = "nearest",
        /// Either way, or the measurements are made at these times.
        Unknown = "unknown",
        /// None: the measurements are made at these times.
        Exact = "exact",
    }
}

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

impl KeyValue for Shares {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        if node.get_ref().as_str() == Some(UNKNOWN) {
            *self = Self::Unknown;
            return Ok(());
        }
        let mut sources = Vec::new();
        KeyValue::read(&mut sources, node, range, at).map_err(|error| match node.get_ref().as_str() {
            Some(word) => SettingsError {
                what: format!("\"{word}\" is not known; write \"{UNKNOWN}\", or a list as in [\"radar\"]"),
                ..error
            },
            None => error,
        })?;
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
    /// Whether that holds for every target, however seldom it is reported.
    pub states_fresh: bool,
    /// Sensor accuracy s (TI-7).
    pub accuracy: Accuracy,
    /// Adjustment coefficient k (TI-8).
    pub adjustment: f64,
    /// True while an order keeps its reports out.
    pub is_out: bool,
    /// Origin of the system frame, if a tracker makes its tracks and takes designations by order: a designated target
    /// lies near it.
    pub designates_round: Option<Geodetic>,
    /// Priority for ties, smaller first (TI-11).
    pub priority: u32,
    /// Sources whose measurements are in its tracks too.
    pub shares: Vec<SourceRef>,
    /// Whether its tracks are the system tracks of another centre.
    pub is_centre: bool,
    /// Whether targets report their own positions.
    pub is_self_reported: bool,
    /// Whether its biases and detection points are estimated.
    pub is_registered: bool,
    /// Stated rounding of its time stamps.
    pub stamps: Option<StampRounding>,
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
    /// Known biases, subtracted from each report, if there are any.
    pub correction: Option<CorrectionTable>,
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
            learns_period: weighing.period_s.is_none() && weighing.fresh_s.is_none(),
            fresh_ns: Seconds::of(fresh_s).ns(),
            states_fresh: weighing.fresh_s.is_some(),
            adjustment: accuracy.adjustment,
            priority: weighing.priority.unwrap_or(priority),
            shares: match &weighing.shares {
                Shares::With(sources) => sources.clone(),
                Shares::Unknown => Vec::new(),
            },
            is_centre: weighing.shares == Shares::Unknown,
            is_self_reported: weighing.self_reported.unwrap_or(false),
            is_registered: weighing.registered.unwrap_or(true),
            stamps: weighing.stamps,
            independent_of: weighing.independent_of.clone(),
            ceiling_m: weighing.ceiling_m.unwrap_or(f64::INFINITY),
            correction: Some(weighing.correction).filter(|known| *known != CorrectionTable::default()),
            coverage: weighing.coverage.as_ref().map(|coverage| coverage.at(place_m)),
            ..Self::of(name, period_s, accuracy.at(place_m))
        })
    }

    /// A source of known period without limits: first in priority, independent, its coverage learned.
    pub fn of(name: &str, period_s: f64, accuracy: Accuracy) -> Self {
        Self {
            name: name.to_owned(),
            sensor_uid: 0,
            period_ns: Seconds::of(period_s).ns(),
            learns_period: false,
            fresh_ns: Seconds::of(FRESH_PERIODS * period_s).ns(),
            states_fresh: false,
            accuracy,
            adjustment: 1.0,
            is_out: false,
            designates_round: None,
            priority: 0,
            shares: Vec::new(),
            is_centre: false,
            is_self_reported: false,
            is_registered: true,
            stamps: None,
            independent_of: Vec::new(),
            ceiling_m: f64::INFINITY,
            coverage: None,
            place_m: None,
            limits: ReportLimits::default(),
            correction: None,
        }
    }
}

impl CorrectionTable {
    /// The biases that are not 0, in the order of their removal: the time last, since the others hold at the measured
    /// place.
    pub fn biases(&self) -> impl Iterator<Item = (BiasKind, [f64; 2])> {
        let biases = [
            (BiasKind::Position, [self.east_m, self.north_m]),
            (BiasKind::Azimuth, [self.azimuth_deg.rad(), 0.0]),
            (BiasKind::Range, [self.range_m, 0.0]),
            (BiasKind::Time, [self.time_s, 0.0]),
        ];
        biases.into_iter().filter(|(_, value)| *value != [0.0; 2])
    }

    /// Returns the correction that replaces this correction and the estimated biases of the source.
    #[must_use]
    pub fn with_estimated(mut self, known: &Registration) -> Self {
        let mut azimuth_rad = self.azimuth_deg.rad();
        let add = |bit: u32, sum: &mut f64, value: f64| *sum += if known.removes(bit) { value } else { 0.0 };
        add(registration_bits::EAST, &mut self.east_m, known.offset_m[0]);
        add(registration_bits::NORTH, &mut self.north_m, known.offset_m[1]);
        add(registration_bits::UP, &mut self.up_m, known.offset_m[2]);
        add(registration_bits::TIME, &mut self.time_s, known.time_offset_s);
        add(registration_bits::RANGE, &mut self.range_m, known.range_bias_m);
        add(registration_bits::AZIMUTH, &mut azimuth_rad, known.azimuth_bias_rad);
        if let Some(gross) = known.gross_error().filter(|gross| gross.is_removed) {
            match gross.kind {
                BiasKind::Azimuth => azimuth_rad += gross.value[0],
                BiasKind::Range => self.range_m += gross.value[0],
                BiasKind::Time => self.time_s += gross.value[0],
                BiasKind::Position => {
                    self.east_m += gross.value[0];
                    self.north_m += gross.value[1];
                }
            }
        }
        self.azimuth_deg = Degrees::of(azimuth_rad.to_degrees());
        self
    }

    /// Returns the keys with a value other than 0, as lines of a configuration.
    pub fn lines(&self) -> Vec<String> {
        let keys = [
            ("azimuth_deg", self.azimuth_deg.rad().to_degrees(), 3),
            ("range_m", self.range_m, 1),
            ("time_s", self.time_s, 3),
            ("east_m", self.east_m, 1),
            ("north_m", self.north_m, 1),
            ("up_m", self.up_m, 1),
        ];
        let written = keys.map(|(key, value, decimals)| (key, format!("{value:.decimals$}")));
        let other_than_0 = written
            .into_iter()
            .filter(|(_, value)| value.bytes().any(|byte| matches!(byte, b'1'..=b'9')));
        other_than_0.map(|(key, value)| format!("{key} = {value}")).collect()
    }

    /// Whether a bias can be removed only with the position of the sensor.
    fn needs_place(self) -> bool {
        self.azimuth_deg.rad() != 0.0 || self.range_m != 0.0
    }
}

impl SourceSettings {
    /// Refuses a correction that cannot be made.
    pub fn check_correction(&self) -> Result<(), SettingsError> {
        if self.place_m.is_none() && self.correction.is_some_and(|known| known.needs_place()) {
            let what = format!(
                "{}: azimuth and range can be corrected only from the position of the sensor; state the position",
                self.name
            );
            return Err(SettingsError::new("correction", what));
        }
        Ok(())
    }
}

/// Longest time between two reports of any source, seconds.
pub fn longest_period_s(sources: &[SourceSettings]) -> f64 {
    let longest = sources.iter().map(|source| source.period_ns).max();
    longest.unwrap_or(0) as f64 / NS_PER_S
}

/// Sensor accuracy s ≥ 0 as a function of conditions (TI-7).
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// What s is at rest and in the normal condition.
    pub base: AccuracyBase,
    /// Added per metre per second of target speed, seconds.
    pub per_speed_s: f64,
    /// Factors for named conditions (weather), which an order can change during operation; 1 for other conditions.
    pub conditions: Vec<(String, f64)>,
    /// Methods of observation that reports name, if the source changes its method.
    pub methods: Vec<MethodAccuracy>,
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

impl AccuracyBase {
    /// What the configuration states for a target at this place, metres; `None` if the source itself states it. An
    /// estimate counts before there are residuals.
    #[inline]
    pub fn configured_m(&self, [east, north, _]: [f64; AXES]) -> Option<f64> {
        match *self {
            Self::Constant { sigma_m } => Some(sigma_m),
            Self::Polar {
                place_m,
                range_sigma_m,
                azimuth_sigma_rad,
            } => {
                let range_m = (east - place_m[0]).hypot(north - place_m[1]);
                Some(range_sigma_m.hypot(azimuth_sigma_rad * range_m))
            }
            Self::Reported => None,
            Self::Estimated { initial_m, .. } => Some(initial_m),
        }
    }
}

impl Accuracy {
    /// The same accuracy everywhere and in all conditions, metres.
    pub fn constant(sigma_m: f64) -> Self {
        Self {
            base: AccuracyBase::Constant { sigma_m },
            per_speed_s: 0.0,
            conditions: Vec::new(),
            methods: Vec::new(),
        }
    }

    /// Names of the conditions that change the accuracy of the source or of one of its methods.
    pub fn condition_names(&self) -> impl Iterator<Item = &str> {
        let of_source = self.conditions.iter().map(|(name, _)| name.as_str());
        let of_methods = self.methods.iter().flat_map(|method| method.conditions.keys());
        of_source.chain(of_methods.map(String::as_str))
    }
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
            methods: self.methods.clone(),
        }
    }

    /// Refuses two methods of one number.
    pub fn check(&self) -> Result<(), SettingsError> {
        let mut numbers = BTreeSet::new();
        for (place, method) in self.methods.iter().enumerate() {
            if !numbers.insert(method.number) {
                let what = format!(
                    "{}: an earlier method has this number; give each method once",
                    method.number
                );
                return Err(SettingsError::new(format!("method[{place}].number"), what));
            }
        }
        Ok(())
    }
}
