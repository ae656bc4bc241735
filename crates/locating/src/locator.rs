//! All emitters: association of each bearing with an emitter, and the update.

use kept::kept;
use messages::{Covariance, SensorTrack, TrackState, sensor_track_bits};
use observations::Bearing;
use settings::SettingsError;

use crate::bank::{Bank, BankNotes, RawFix};
use crate::counts::LocatorCounts;
use crate::explanation::{Decision, LocatorDecisionKind};
use crate::line_of_bearing::LineOfBearing;
use crate::selection::{Fix, Output, Selector};
use crate::settings::{DroppedEmitter, Settings};
use crate::smoother::StartPoint;

/// First number of emitters that the locator distinguishes itself.
pub const OWN_NUMBERS: u32 = 1_000_001;
/// Decisions on one bearing at most.
const DECISIONS_MAX: usize = 16;
/// A direction with a greater standard deviation is none, radians.
const SIGMA_MAX_RAD: f64 = 1.0;
/// Greatest coordinate of a platform, metres; beyond, differences lose their millimetres.
const COORDINATE_MAX_M: f64 = 1e9;
/// Heights are not observed: standard deviation, metres.
const HEIGHT_SIGMA_M: f64 = 1e4;
/// Seconds of a day.
const DAY_S: i64 = 86_400;
/// Frequencies that were not measured fit all.
const ANY_FREQUENCY_HZ: f64 = 0.0;

/// Report of an emitter after a bearing of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterReport {
    /// The emitter: the bearings' id, or from [`OWN_NUMBERS`] on.
    pub number: u32,
    /// Time of the bearing, nanoseconds.
    pub time_ns: i64,
    /// Fix of the filters.
    pub raw: RawFix,
    /// Output after selection and prediction (EL-4 … EL-10).
    pub output: Output,
}

impl EmitterReport {
    /// The report as a sample of the source numbered `source`, with the numbers of the source's own at 0 (EL-11).
    ///
    /// The covariance is the raw fix's, and as much more as the output is apart from it. Height is not observed.
    pub fn sensor_track(&self, source: u16) -> SensorTrack {
        let apart: [f64; 2] = std::array::from_fn(|axis| self.output.position_m[axis] - self.raw.position_m[axis]);
        let faster: [f64; 2] = std::array::from_fn(|axis| self.output.velocity_mps[axis] - self.raw.velocity_mps[axis]);
        let off = [apart[0], apart[1], faster[0], faster[1]];
        let mut covariance = Covariance::default();
        // East and north, then their velocities, among the six components of a message.
        const PLACES: [usize; 4] = [0, 1, 3, 4];
        for (row, to_row) in PLACES.into_iter().enumerate() {
            for (column, to_column) in PLACES.into_iter().enumerate().skip(row) {
                let value = self.raw.covariance[(row, column)] + off[row] * off[column];
                covariance.set(to_row, to_column, value);
            }
        }
        covariance.set(2, 2, HEIGHT_SIGMA_M * HEIGHT_SIGMA_M);
        let state = match self.raw.is_agreed {
            true => TrackState::Confirmed,
            false => TrackState::Coasted,
        };
        SensorTrack {
            time_of_measurement_ns: self.time_ns,
            track_number: self.number,
            source,
            valid: sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
            position_m: self.output.position_m,
            velocity_mps: self.output.velocity_mps,
            covariance,
            state: state as u8,
            ..SensorTrack::default()
        }
    }
}

/// Reason why a bearing was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BearingRejection {
    /// A value is no number or cannot be.
    Unusable(&'static str),
    /// The bearing is older than the emitter's last one.
    OutOfOrder,
    /// The bearing is of a new emitter, and there is no place for it.
    TableFull,
}

impl std::fmt::Display for BearingRejection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unusable(what) => write!(formatter, "{what}"),
            Self::OutOfOrder => write!(
                formatter,
                "is older than the emitter's last bearing; sort the bearings by time"
            ),
            Self::TableFull => write!(
                formatter,
                "is of a new emitter, and all places are taken; configure a greater emitters_max"
            ),
        }
    }
}

impl std::error::Error for BearingRejection {}

/// State of an emitter.
#[derive(Clone, Debug)]
struct Emitter {
    number: u32,
    /// Set if the bearings carry the emitter's number.
    is_labelled: bool,
    frequency_hz: f64,
    /// Time of its first bearing: times in seconds count from here, so that precision does not depend on the date.
    first_ns: i64,
    last: LineOfBearing,
    last_heading_rad: Option<f64>,
    turning_since_ns: Option<i64>,
    bank: Bank,
    selector: Selector,
    /// Whether it has changed since it was kept.
    is_changed: bool,
}

kept! {
    /// An emitter, but for its filters.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct EmitterRecord {
        pub(crate) number: u32,
        pub(crate) is_labelled: bool,
        pub(crate) frequency_hz: f64,
        pub(crate) first_ns: i64,
        pub(crate) last: LineOfBearing,
        pub(crate) last_heading_rad: Option<f64>,
        pub(crate) turning_since_ns: Option<i64>,
    }
}

/// Locates emitters from bearings.
#[derive(Debug)]
pub struct Locator {
    settings: Settings,
    /// In the order of (is_labelled, number).
    index: Vec<(bool, u32, u32)>,
    emitters: Vec<Emitter>,
    next_number: u32,
    /// Emitters whose first place is known.
    dropped: Vec<DroppedEmitter>,
    /// Places in `emitters` of those that have changed since they were kept.
    changed: Vec<u32>,
    decisions: Vec<Decision>,
    counts: LocatorCounts,
}

impl Locator {
    /// Makes a locator without data. All memory is allocated here.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings::check(&settings)?;
        Ok(Self {
            settings,
            index: Vec::with_capacity(settings.emitters_max),
            emitters: Vec::with_capacity(settings.emitters_max),
            next_number: OWN_NUMBERS,
            dropped: Vec::new(),
            changed: Vec::with_capacity(settings.emitters_max),
            decisions: Vec::with_capacity(DECISIONS_MAX),
            counts: LocatorCounts::default(),
        })
    }

    /// Sets the emitters whose first place is known; it applies to emitters that begin later. The last one of a number
    /// counts.
    pub fn set_dropped(&mut self, dropped: &[DroppedEmitter]) {
        self.dropped = dropped.to_vec();
    }

    /// Takes a bearing. `None`: the geometry does not allow a fix yet.
    ///
    /// # Errors
    /// If the bearing is unusable; the bearing is counted and changes nothing.
    pub fn bearing(&mut self, bearing: &Bearing) -> Result<Option<EmitterReport>, BearingRejection> {
        self.decisions.clear();
        if let Some(fault) = fault(bearing) {
            self.counts.unusable += 1;
            return Err(BearingRejection::Unusable(fault));
        }
        let line = LineOfBearing::new(bearing);
        let found = match bearing.emitter_id {
            Some(id) => self.place(true, id).ok(),
            None => self.associated(bearing, &line),
        };
        let (slot, is_new) = match found {
            Some(place) => (self.index[place].2 as usize, false),
            None => (self.begin(bearing, &line)?, true),
        };
        let emitter = &mut self.emitters[slot];
        if line.time_ns < emitter.last.time_ns {
            self.counts.out_of_order += 1;
            return Err(BearingRejection::OutOfOrder);
        }
        self.counts.bearings += 1;
        self.counts.associated += u64::from(bearing.emitter_id.is_none() && !is_new);
        Ok(self.take(slot, bearing, &line))
    }

    /// Decisions on the last bearing, in order.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Counters of processed and rejected bearings so far.
    pub fn counts(&self) -> &LocatorCounts {
        &self.counts
    }

    /// Emitters there are.
    pub fn emitters(&self) -> usize {
        self.emitters.len()
    }

    /// Settings it was built from.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub(crate) fn next_number(&self) -> u32 {
        self.next_number
    }

    pub(crate) fn resume_numbers(&mut self, next: u32) {
        self.next_number = self.next_number.max(next);
    }

    /// Passes the emitters that have changed since the last call, or all of them, with their places, to `each`.
    pub(crate) fn each_changed(&mut self, all: bool, mut each: impl FnMut(usize, &EmitterRecord, &Bank, &Selector)) {
        if all {
            self.changed.clear();
            self.changed.extend(0..self.emitters.len() as u32);
        }
        for slot in self.changed.drain(..) {
            let emitter = &mut self.emitters[slot as usize];
            emitter.is_changed = false;
            each(slot as usize, &emitter.record(), &emitter.bank, &emitter.selector);
        }
    }

    /// Adds an emitter of a predecessor, if there is room. Of two with the same number, the later one stays.
    pub(crate) fn resume_emitter(&mut self, known: &EmitterRecord, bank: Bank, selector: Selector) {
        let emitter = Emitter {
            number: known.number,
            is_labelled: known.is_labelled,
            frequency_hz: known.frequency_hz,
            first_ns: known.first_ns,
            last: known.last,
            last_heading_rad: known.last_heading_rad,
            turning_since_ns: known.turning_since_ns,
            bank,
            selector,
            is_changed: false,
        };
        let slot = self.emitters.len();
        match self.place(known.is_labelled, known.number) {
            Ok(place) => {
                let other = &mut self.emitters[self.index[place].2 as usize];
                if other.last.time_ns < emitter.last.time_ns {
                    *other = emitter;
                }
            }
            Err(place) if slot < self.settings.emitters_max => {
                self.index.insert(place, (known.is_labelled, known.number, slot as u32));
                self.emitters.push(emitter);
            }
            Err(_) => {}
        }
    }

    fn take(&mut self, slot: usize, bearing: &Bearing, line: &LineOfBearing) -> Option<EmitterReport> {
        let (settings, emitter) = (&self.settings, &mut self.emitters[slot]);
        let after_s = line.after_s(emitter.last.time_ns);
        emitter.watch_heading(bearing.heading_rad, line, settings.consistency.turning_deg_per_s.rad());
        let mut notes = BankNotes::EMPTY;
        let (models, turning_since_ns) = ((&settings.motion, &settings.consistency), emitter.turning_since_ns);
        emitter.bank.add(line, after_s, turning_since_ns, models, &mut notes);
        emitter.last = *line;
        if !std::mem::replace(&mut emitter.is_changed, true) {
            self.changed.push(slot as u32);
        }
        let (number, first_ns, time_ns) = (emitter.number, emitter.first_ns, line.time_ns);
        let fix = emitter.bank.fix_at(time_ns);
        let output = fix.and_then(|raw| emitter.selector.fix(&selectable(&raw, time_ns - first_ns, line)));
        for (kind, value, limit) in notes.iter() {
            self.decide(time_ns, number, kind, value, limit);
        }
        let (Some(raw), Some(output)) = (fix, output) else {
            self.counts.without_fix += 1;
            return None;
        };
        if let Some((reason, value, limit)) = output.decision {
            self.decide(
                time_ns,
                number,
                LocatorDecisionKind::Selection(output.stage, reason),
                value,
                limit,
            );
        }
        self.counts.fixes += 1;
        self.counts.set_aside += u64::from(!raw.is_agreed);
        Some(EmitterReport {
            number,
            time_ns,
            raw,
            output,
        })
    }

    /// The place of an emitter in the index, or where it belongs.
    fn place(&self, is_labelled: bool, number: u32) -> Result<usize, usize> {
        self.index
            .binary_search_by_key(&(is_labelled, number), |&(is_labelled, number, _)| {
                (is_labelled, number)
            })
    }

    /// The place in the index of the emitter without id that a bearing fits best, by frequency and gate.
    fn associated(&self, bearing: &Bearing, line: &LineOfBearing) -> Option<usize> {
        let settings = &self.settings.association;
        let frequency_hz = bearing.frequency_hz.unwrap_or(ANY_FREQUENCY_HZ);
        let mut best: Option<(f64, usize)> = None;
        // Emitters without id come first.
        for (place, (is_labelled, _, slot)) in self.index.iter().enumerate() {
            if *is_labelled {
                break;
            }
            let emitter = &self.emitters[*slot as usize];
            let is_either_unknown = frequency_hz == ANY_FREQUENCY_HZ || emitter.frequency_hz == ANY_FREQUENCY_HZ;
            let apart_hz = (frequency_hz - emitter.frequency_hz).abs();
            if !is_either_unknown && apart_hz > settings.frequency_tolerance_hz {
                continue;
            }
            let (squared, log_variance) = emitter.compare(line, settings.rate_max_deg_per_s.rad());
            let cost = squared + log_variance;
            if squared <= settings.gate * settings.gate && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, place));
            }
        }
        best.map(|(_, place)| place)
    }

    /// A new emitter's place in the table.
    fn begin(&mut self, bearing: &Bearing, line: &LineOfBearing) -> Result<usize, BearingRejection> {
        let (is_labelled, number) = match bearing.emitter_id {
            Some(id) => (true, id),
            None => (false, self.next_number),
        };
        let start = self.start_of(bearing);
        let slot = if self.emitters.len() < self.settings.emitters_max {
            self.emitters.push(Emitter {
                number,
                is_labelled,
                frequency_hz: ANY_FREQUENCY_HZ,
                first_ns: line.time_ns,
                last: *line,
                last_heading_rad: None,
                turning_since_ns: None,
                bank: Bank::new(&self.settings.motion, start),
                selector: Selector::new(self.settings.selection),
                is_changed: false,
            });
            self.emitters.len() - 1
        } else {
            let Some(slot) = self.given_up(line.time_ns) else {
                self.counts.table_full += 1;
                return Err(BearingRejection::TableFull);
            };
            self.emitters[slot].bank = Bank::new(&self.settings.motion, start);
            slot
        };
        let emitter = &mut self.emitters[slot];
        emitter.number = number;
        emitter.is_labelled = is_labelled;
        emitter.frequency_hz = bearing.frequency_hz.unwrap_or(ANY_FREQUENCY_HZ);
        (emitter.first_ns, emitter.last) = (line.time_ns, *line);
        (emitter.last_heading_rad, emitter.turning_since_ns) = (None, None);
        if let Err(place) = self.place(is_labelled, number) {
            self.index.insert(place, (is_labelled, number, slot as u32));
        }
        if !is_labelled {
            self.next_number = self.next_number.checked_add(1).unwrap_or(OWN_NUMBERS);
        }
        self.counts.emitters += 1;
        let (there_are, places) = (self.emitters.len() as f64, self.settings.emitters_max as f64);
        self.decide(
            line.time_ns,
            number,
            LocatorDecisionKind::EmitterStarted,
            there_are,
            places,
        );
        Ok(slot)
    }

    /// Place and time of the drop of a bearing's emitter, on the day nearest to the bearing.
    fn start_of(&self, bearing: &Bearing) -> Option<StartPoint> {
        let id = bearing.emitter_id?;
        let dropped = self.dropped.iter().rfind(|dropped| dropped.emitter_id == id)?;
        let (heard_ns, day_ns) = (bearing.time_of_measurement_ns, DAY_S * 1_000_000_000);
        let of_day_ns = (dropped.time_s * 1e9) as i64;
        let days = (heard_ns - of_day_ns + day_ns / 2).div_euclid(day_ns);
        Some(StartPoint {
            time_ns: days * day_ns + of_day_ns,
            position_m: dropped.position_m,
            sigma_m: dropped.sigma_m,
        })
    }

    /// Returns the emptied slot of the emitter with the longest silence, if the silence was long enough.
    fn given_up(&mut self, time_ns: i64) -> Option<usize> {
        let (slot, emitter) = (self.emitters.iter_mut().enumerate()).min_by_key(|(_, emitter)| emitter.last.time_ns)?;
        let silent_s = (time_ns - emitter.last.time_ns) as f64 * 1e-9;
        if silent_s < self.settings.association.silent_max_s {
            return None;
        }
        let (is_labelled, number) = (emitter.is_labelled, emitter.number);
        emitter.selector = Selector::new(self.settings.selection);
        if let Ok(place) = self.place(is_labelled, number) {
            self.index.remove(place);
        }
        self.counts.emitters_dropped += 1;
        let limit_s = self.settings.association.silent_max_s;
        self.decide(time_ns, number, LocatorDecisionKind::EmitterDropped, silent_s, limit_s);
        Some(slot)
    }

    fn decide(&mut self, time_ns: i64, emitter: u32, kind: LocatorDecisionKind, value: f64, limit: f64) {
        if self.decisions.len() < DECISIONS_MAX {
            self.decisions.push(Decision {
                time_ns,
                emitter,
                kind,
                value,
                limit,
            });
        }
    }
}

impl Emitter {
    /// The emitter, but for its filters.
    fn record(&self) -> EmitterRecord {
        EmitterRecord {
            number: self.number,
            is_labelled: self.is_labelled,
            frequency_hz: self.frequency_hz,
            first_ns: self.first_ns,
            last: self.last,
            last_heading_rad: self.last_heading_rad,
            turning_since_ns: self.turning_since_ns,
        }
    }

    /// Fit of a bearing without id: squared normalised difference, logarithm of its variance.
    fn compare(&self, line: &LineOfBearing, rate_max_rad_per_s: f64) -> (f64, f64) {
        if let Some(compared) = self.bank.compare(line) {
            return compared;
        }
        // Without a fix, the emitter is expected in the direction of its last bearing, within the largest possible
        // change.
        let after_s = line.after_s(self.last.time_ns).abs();
        let may_have_gone = rate_max_rad_per_s * after_s;
        let variance = 1.0 / line.information + 1.0 / self.last.information + may_have_gone * may_have_gone;
        let across = line.sine * self.last.cosine - line.cosine * self.last.sine;
        let along = line.cosine * self.last.cosine + line.sine * self.last.sine;
        let difference = across.atan2(along);
        (difference * difference / variance, variance.ln())
    }

    /// Detects whether and since when the platform turns, by the heading at the line after the last line.
    fn watch_heading(&mut self, heading_rad: Option<f64>, line: &LineOfBearing, turning_rad_per_s: f64) {
        let after_s = line.after_s(self.last.time_ns);
        if let (Some(heading_rad), Some(last)) = (heading_rad, self.last_heading_rad) {
            if after_s <= 0.0 {
                // Two bearings at the same time contain no new information.
                return;
            }
            let change = (heading_rad - last).sin().atan2((heading_rad - last).cos());
            self.turning_since_ns = match change.abs() / after_s > turning_rad_per_s {
                true => self.turning_since_ns.or(Some(line.time_ns)),
                false => None,
            };
        } else {
            self.turning_since_ns = None;
        }
        self.last_heading_rad = heading_rad;
    }
}

/// Fault of a bearing; `None` if there is none.
fn fault(bearing: &Bearing) -> Option<&'static str> {
    let coordinates = bearing.platform_m.iter().all(|value| value.abs() < COORDINATE_MAX_M);
    let angles = bearing.bearing_rad.is_finite() && bearing.heading_rad.is_none_or(f64::is_finite);
    if !angles {
        Some("an angle is no number")
    } else if !(bearing.sigma_rad > 0.0 && bearing.sigma_rad <= SIGMA_MAX_RAD) {
        Some("the standard deviation is not between 0 and 1 rad")
    } else if !coordinates {
        Some("the platform's position is no number, or farther away than 1e9 m")
    } else if bearing
        .frequency_hz
        .is_some_and(|frequency| !(frequency > 0.0 && frequency.is_finite()))
    {
        Some("the frequency is not greater than 0")
    } else {
        None
    }
}

fn selectable(raw: &RawFix, after_ns: i64, line: &LineOfBearing) -> Fix {
    let from_platform: [f64; 2] = std::array::from_fn(|axis| raw.position_m[axis] - line.platform_m[axis]);
    Fix {
        time_s: after_ns as f64 * 1e-9,
        position_m: [raw.position_m[0], raw.position_m[1], 0.0],
        velocity_mps: [raw.velocity_mps[0], raw.velocity_mps[1], 0.0],
        variance_m2: raw.variance_m2(),
        direction_rad: Some(from_platform[0].atan2(from_platform[1])),
    }
}
