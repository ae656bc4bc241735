//! All emitters: association of each bearing with an emitter, and the update.

use kept::kept;
use messages::{Covariance, SensorTrack, TrackState, sensor_track_bits};
use nalgebra::Matrix4;
use observations::{Arrival, ArrivalTime, Bearing, ReadyFix, Receiver};
use settings::SettingsError;

use crate::arrivals::{ArrivalOutcome, Arrivals, LINES_MAX, Reception, Transmission};
use crate::bank::{Bank, BankNotes, RawFix};
use crate::counts::LocatorCounts;
use crate::cue::{TurnCue, turn_for_range};
use crate::explanation::{Decision, LocatorDecisionKind};
use crate::line_of_bearing::{LineOfBearing, Ray};
use crate::motion::MotionModel;
use crate::rejection::{BearingRejection, arrival_fault, fault, is_place};
use crate::selection::{Fix, Output, Selector};
use crate::settings::{DroppedEmitter, FilterChoice, Settings};
use crate::smoother::StartPoint;

/// First number of emitters that the locator distinguishes itself.
pub const OWN_NUMBERS: u32 = 1_000_001;
/// Decisions on a single bearing at most.
const DECISIONS_MAX: usize = 16;
/// Heights are not observed: standard deviation, metres.
const HEIGHT_SIGMA_M: f64 = 1e4;
/// An emitter without a range for this long is a reason to turn, seconds; another course differs by so much, radians.
const CUED_AFTER_S: f64 = 120.0;
const COURSE_CHANGE_RAD: f64 = 0.5;
/// Seconds of a day.
const DAY_S: i64 = 86_400;
/// Frequencies that were not measured fit all.
const ANY_FREQUENCY_HZ: f64 = 0.0;

/// Report of an emitter after a bearing of the emitter.
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
    /// The covariance is the raw fix's, increased by the distance of the output from the fix. Height is not observed.
    pub fn sensor_track(&self, source: u16) -> SensorTrack {
        let apart: [f64; 2] = std::array::from_fn(|axis| self.output.position_m[axis] - self.raw.position_m[axis]);
        let faster: [f64; 2] = std::array::from_fn(|axis| self.output.velocity_mps[axis] - self.raw.velocity_mps[axis]);
        let off = [apart[0], apart[1], faster[0], faster[1]];
        let mut covariance = Covariance::default();
        // East and north, then the velocities, among the six components of a message.
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

/// State of an emitter.
#[derive(Clone, Debug)]
struct Emitter {
    number: u32,
    /// Set if the bearings carry the emitter's number.
    is_labelled: bool,
    frequency_hz: f64,
    /// Time of the first bearing: times in seconds count from here, so that precision does not depend on the date.
    first_ns: i64,
    /// Last bearing, or last line of an emitter without bearings, and time of the last line of any kind.
    last: LineOfBearing,
    last_ns: i64,
    last_heading_rad: Option<f64>,
    turning_since_ns: Option<i64>,
    /// Course of the platform at the last cue to turn, radians.
    cued_rad: Option<f64>,
    bank: Bank,
    selector: Selector,
    /// Whether the emitter has changed since the last keeping.
    is_changed: bool,
}

kept! {
    /// An emitter, without the filters.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct EmitterRecord {
        pub(crate) number: u32,
        pub(crate) is_labelled: bool,
        pub(crate) frequency_hz: f64,
        pub(crate) first_ns: i64,
        pub(crate) last: LineOfBearing,
        pub(crate) last_ns: i64,
        pub(crate) last_heading_rad: Option<f64>,
        pub(crate) turning_since_ns: Option<i64>,
        pub(crate) cued_rad: Option<f64>,
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
    /// Emitters with a known first place.
    dropped: Vec<DroppedEmitter>,
    /// Places in `emitters` of the emitters that have changed since the last keeping.
    changed: Vec<u32>,
    decisions: Vec<Decision>,
    counts: LocatorCounts,
    arrivals: Arrivals,
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
            arrivals: Arrivals::new(settings.arrivals),
        })
    }

    /// Sets the emitters with a known first place, for emitters that begin later. The last entry of a number counts.
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
        let is_new = found.is_none();
        let slot = match found {
            Some(place) => self.index[place].2 as usize,
            None => self.begin(bearing.emitter_id, bearing.frequency_hz, &line)?,
        };
        self.check_order(slot, &line)?;
        self.counts.bearings += 1;
        self.counts.associated += u64::from(bearing.emitter_id.is_none() && !is_new);
        let turning_rad_per_s = self.settings.consistency.turning_deg_per_s.rad();
        self.emitters[slot].watch_heading(bearing.heading_rad, &line, turning_rad_per_s);
        Ok(self.take(slot, &[line]))
    }

    /// Takes an arrival time or a difference of two. Arrival times at single receivers are collected; the report is of
    /// the emitter with the transmission that this arrival completes.
    ///
    /// # Errors
    /// If the arrival, or the completed transmission, is unusable; such an arrival is counted and changes nothing.
    pub fn arrival(&mut self, arrival: &Arrival) -> Result<Option<EmitterReport>, BearingRejection> {
        self.decisions.clear();
        if let Some(fault) = arrival_fault(arrival) {
            self.counts.unusable += 1;
            return Err(BearingRejection::Unusable(fault));
        }
        let mut clock = |receiver: &Receiver| self.arrivals.clock(receiver).ok_or(BearingRejection::ReceiversFull);
        match arrival.time {
            ArrivalTime::At { receiver, t_s } => {
                let reception = Reception {
                    receiver,
                    clock: clock(&receiver)?,
                    t_s,
                    sigma_s: arrival.sigma_s,
                };
                self.counts.arrivals += 1;
                match self.arrivals.collect(arrival, reception) {
                    Some(transmission) => self.transmission(&transmission),
                    None => Ok(None),
                }
            }
            ArrivalTime::Between { receivers, tdoa_s } => {
                let [one, other] = receivers;
                let both = [(one, clock(&one)?), (other, clock(&other)?)];
                self.counts.arrivals += 1;
                let outcome = self.arrivals.difference(arrival, both, tdoa_s);
                self.conclude(arrival.emitter_id, outcome)
            }
        }
    }

    /// Processes a single transmission that is complete at `now_ns` (UTC, nanoseconds; `None`: any, at the end of the
    /// data): no further arrival can belong to it. `None` if there is none.
    pub fn complete(&mut self, now_ns: Option<i64>) -> Option<Result<Option<EmitterReport>, BearingRejection>> {
        self.decisions.clear();
        let transmission = self.arrivals.complete(now_ns)?;
        Some(self.transmission(&transmission))
    }

    /// Takes a ready-made fix (EL-12): as a measurement of the emitter, or with the filter `none` unchanged.
    ///
    /// # Errors
    /// If the fix is unusable; such a fix is counted and changes nothing.
    pub fn fix(&mut self, fix: &ReadyFix) -> Result<Option<EmitterReport>, BearingRejection> {
        self.decisions.clear();
        let has_place = is_place(&fix.position_m);
        let Some(lines) = LineOfBearing::of_fix(fix).filter(|_| has_place) else {
            self.counts.unusable += 1;
            let fault = match has_place {
                true => "the covariance is not positive definite",
                false => "the position is no number, or farther away than 1e9 m",
            };
            return Err(BearingRejection::Unusable(fault));
        };
        let report = match self.settings.motion.filter {
            FilterChoice::None => self.given(fix, &lines[0])?,
            _ => self.labelled(fix.emitter_id, &lines)?,
        };
        self.counts.ready_fixes += 1;
        Ok(report)
    }

    /// Selects a ready-made fix unchanged.
    fn given(&mut self, fix: &ReadyFix, line: &LineOfBearing) -> Result<Option<EmitterReport>, BearingRejection> {
        let slot = self.slot(fix.emitter_id, line)?;
        self.check_order(slot, line)?;
        self.emitters[slot].last_ns = line.time_ns;
        let [xx, xy, yy] = fix.covariance_m2;
        let mut covariance = Matrix4::zeros();
        for (row, column, value) in [(0, 0, xx), (0, 1, xy), (1, 0, xy), (1, 1, yy)] {
            covariance[(row, column)] = value;
        }
        let raw = RawFix {
            position_m: [fix.position_m[0], fix.position_m[1]],
            velocity_mps: [0.0; 2],
            covariance,
            motion: MotionModel::Given,
            is_agreed: true,
        };
        Ok(self.select(slot, Some(raw)))
    }

    fn transmission(&mut self, transmission: &Transmission) -> Result<Option<EmitterReport>, BearingRejection> {
        let outcome = self.arrivals.process(transmission);
        self.conclude(transmission.emitter_id, outcome)
    }

    /// Gives the filters of an emitter the lines of a transmission.
    fn conclude(
        &mut self,
        emitter_id: u32,
        outcome: ArrivalOutcome,
    ) -> Result<Option<EmitterReport>, BearingRejection> {
        let (count, refusal) = match outcome {
            ArrivalOutcome::Lines => {
                let mut lines = [LineOfBearing::NONE; LINES_MAX];
                let found = self.arrivals.lines();
                let lines = &mut lines[..found.len()];
                lines.copy_from_slice(found);
                return self.labelled(emitter_id, lines);
            }
            ArrivalOutcome::Reference => {
                self.counts.references += 1;
                return Ok(None);
            }
            ArrivalOutcome::Alone => (&mut self.counts.alone, BearingRejection::Alone),
            ArrivalOutcome::ClockUnknown => (&mut self.counts.clock_unknown, BearingRejection::ClockUnknown),
            ArrivalOutcome::Impossible => (&mut self.counts.impossible, BearingRejection::Impossible),
        };
        *count += 1;
        Err(refusal)
    }

    /// Takes lines of the same time of an emitter that has a number.
    fn labelled(&mut self, id: u32, lines: &[LineOfBearing]) -> Result<Option<EmitterReport>, BearingRejection> {
        let slot = self.slot(id, &lines[0])?;
        self.check_order(slot, &lines[0])?;
        Ok(self.take(slot, lines))
    }

    /// Slot of an emitter that has a number.
    fn slot(&mut self, id: u32, line: &LineOfBearing) -> Result<usize, BearingRejection> {
        match self.place(true, id) {
            Ok(place) => Ok(self.index[place].2 as usize),
            Err(_) => self.begin(Some(id), None, line),
        }
    }

    fn check_order(&mut self, slot: usize, line: &LineOfBearing) -> Result<(), BearingRejection> {
        if line.time_ns < self.emitters[slot].last_ns {
            self.counts.out_of_order += 1;
            return Err(BearingRejection::OutOfOrder);
        }
        Ok(())
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

    /// Settings of this locator.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub(crate) fn next_number(&self) -> u32 {
        self.next_number
    }

    pub(crate) fn resume_numbers(&mut self, next: u32) {
        self.next_number = self.next_number.max(next);
    }

    /// Passes the emitters that have changed since the last call, or all of them, with the places, to `each`.
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
            last_ns: known.last_ns,
            last_heading_rad: known.last_heading_rad,
            turning_since_ns: known.turning_since_ns,
            cued_rad: known.cued_rad,
            bank,
            selector,
            is_changed: false,
        };
        let slot = self.emitters.len();
        match self.place(known.is_labelled, known.number) {
            Ok(place) => {
                let other = &mut self.emitters[self.index[place].2 as usize];
                if other.last_ns < emitter.last_ns {
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

    /// Gives the filters lines of the same time.
    fn take(&mut self, slot: usize, lines: &[LineOfBearing]) -> Option<EmitterReport> {
        let (settings, emitter) = (&self.settings, &mut self.emitters[slot]);
        let mut notes = BankNotes::EMPTY;
        if self.arrivals.is_estimated() && lines.iter().any(|line| line.clocks().is_some()) {
            let arrivals = &self.arrivals;
            let ahead = |[one, other]: [u16; 2], time_ns| arrivals.ahead(one.into(), other.into(), time_ns);
            emitter.bank.set_clocks(&ahead);
        }
        let mut cue = None;
        for line in lines {
            let after_s = line.after_s(emitter.last_ns);
            let (models, turning_since_ns) = ((&settings.motion, &settings.consistency), emitter.turning_since_ns);
            emitter.bank.add(line, after_s, turning_since_ns, models, &mut notes);
            emitter.last_ns = line.time_ns;
            cue = emitter.cue(line).or(cue);
            if line.ray().is_some() || emitter.last.ray().is_none() {
                emitter.last = *line;
            }
        }
        let (number, time_ns) = (emitter.number, emitter.last_ns);
        let fix = emitter.bank.fix_at(time_ns, &settings.motion);
        for (kind, value, limit) in notes.iter() {
            self.decide(time_ns, number, kind, value, limit);
        }
        if let Some(cue) = cue {
            let kind = LocatorDecisionKind::RangeNeedsTurn(cue.side);
            self.decide(
                time_ns,
                number,
                kind,
                cue.course_rad.to_degrees(),
                cue.present_rad.to_degrees(),
            );
        }
        self.select(slot, fix)
    }

    /// Makes the output of a fix, at the time of the emitter's last line.
    fn select(&mut self, slot: usize, fix: Option<RawFix>) -> Option<EmitterReport> {
        let emitter = &mut self.emitters[slot];
        if !std::mem::replace(&mut emitter.is_changed, true) {
            self.changed.push(slot as u32);
        }
        let (number, first_ns, time_ns) = (emitter.number, emitter.first_ns, emitter.last_ns);
        let output = fix.and_then(|raw| {
            emitter
                .selector
                .fix(&selectable(&raw, time_ns - first_ns, &emitter.last))
        });
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

    /// The place of an emitter in the index, or the place of insertion.
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
    fn begin(
        &mut self,
        emitter_id: Option<u32>,
        frequency_hz: Option<f64>,
        line: &LineOfBearing,
    ) -> Result<usize, BearingRejection> {
        let (is_labelled, number) = match emitter_id {
            Some(id) => (true, id),
            None => (false, self.next_number),
        };
        let start = self.start_of(emitter_id, line);
        let slot = if self.emitters.len() < self.settings.emitters_max {
            self.emitters.push(Emitter {
                number,
                is_labelled,
                frequency_hz: ANY_FREQUENCY_HZ,
                first_ns: line.time_ns,
                last: *line,
                last_ns: line.time_ns,
                last_heading_rad: None,
                turning_since_ns: None,
                cued_rad: None,
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
        emitter.frequency_hz = frequency_hz.unwrap_or(ANY_FREQUENCY_HZ);
        (emitter.first_ns, emitter.last, emitter.last_ns) = (line.time_ns, *line, line.time_ns);
        (emitter.last_heading_rad, emitter.turning_since_ns, emitter.cued_rad) = (None, None, None);
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

    /// Place and time of the drop of an emitter, on the day nearest to the first line.
    fn start_of(&self, emitter_id: Option<u32>, first: &LineOfBearing) -> Option<StartPoint> {
        let id = emitter_id?;
        let dropped = self.dropped.iter().rfind(|dropped| dropped.emitter_id == id)?;
        let (heard_ns, day_ns) = (first.time_ns, DAY_S * 1_000_000_000);
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
        let (slot, emitter) = (self.emitters.iter_mut().enumerate()).min_by_key(|(_, emitter)| emitter.last_ns)?;
        let silent_s = (time_ns - emitter.last_ns) as f64 * 1e-9;
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
    /// The emitter, without the filters.
    fn record(&self) -> EmitterRecord {
        EmitterRecord {
            number: self.number,
            is_labelled: self.is_labelled,
            frequency_hz: self.frequency_hz,
            first_ns: self.first_ns,
            last: self.last,
            last_ns: self.last_ns,
            last_heading_rad: self.last_heading_rad,
            turning_since_ns: self.turning_since_ns,
            cued_rad: self.cued_rad,
        }
    }

    /// Fit of a bearing without id: squared normalised difference, logarithm of its variance.
    fn compare(&self, line: &LineOfBearing, rate_max_rad_per_s: f64) -> (f64, f64) {
        if let Some(compared) = self.bank.compare(line) {
            return compared;
        }
        // Without a fix, the emitter is expected in the direction of the last bearing, within the largest possible
        // change.
        let (Some(ray), Some(last)) = (line.ray(), self.last.ray()) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let after_s = line.after_s(self.last.time_ns).abs();
        let may_have_gone = rate_max_rad_per_s * after_s;
        let variance = 1.0 / line.information + 1.0 / self.last.information + may_have_gone * may_have_gone;
        let across = ray.sine * last.cosine - ray.cosine * last.sine;
        let along = ray.cosine * last.cosine + ray.sine * last.sine;
        let difference = across.atan2(along);
        (difference * difference / variance, variance.ln())
    }

    /// The turn that would show the range, if the range is open: once on each course. `line` is not the last line yet.
    fn cue(&mut self, line: &LineOfBearing) -> Option<TurnCue> {
        if !self.bank.is_range_open() {
            self.cued_rad = None;
            return None;
        }
        let cue = turn_for_range(self.last.ray()?, line.ray()?)?;
        if line.after_s(self.first_ns) <= CUED_AFTER_S {
            return None;
        }
        let is_known = self
            .cued_rad
            .is_some_and(|cued| (cue.present_rad - cued).cos() > COURSE_CHANGE_RAD.cos());
        if is_known {
            return None;
        }
        self.cued_rad = Some(cue.present_rad);
        Some(cue)
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

/// A fix for the selection. The direction is from the platform of a bearing: receivers and fixes of others have none.
fn selectable(raw: &RawFix, after_ns: i64, line: &LineOfBearing) -> Fix {
    let from_platform =
        |ray: &Ray| -> [f64; 2] { std::array::from_fn(|axis| raw.position_m[axis] - ray.platform_m[axis]) };
    Fix {
        time_s: after_ns as f64 * 1e-9,
        position_m: [raw.position_m[0], raw.position_m[1], 0.0],
        velocity_mps: [raw.velocity_mps[0], raw.velocity_mps[1], 0.0],
        variance_m2: raw.variance_m2(),
        direction_rad: line.ray().map(from_platform).map(|[east, north]| east.atan2(north)),
    }
}
