//! Cuts the stream of detections of a sensor into scans.
//!
//! The tracker needs scans: all detections of a sensor in a turn. A radar sends single plots, some a little late, and
//! reports when its antenna points north. A scan that ended at this message would leave late plots to the next scan; a
//! scan that ended by the machine's clock would make the result depend on the load. Therefore only times of the data
//! count. A scan reaches from one boundary to the next. The scan is complete when data arrive that are later than the
//! end of the scan by the *wait*. Detections older than the current scan are too late, and are rejected.
//!
//! A boundary is the start of a turn in the sensor's report ([`Cutter::turn_begins`]). Without such a report for longer
//! than a period and the wait, the turn is assumed to last a period. With [`Boundaries::Period`], reports are ignored
//! and boundaries are at whole multiples of the period. After a silence the next scan begins with the first detection.
//!
//! A period that is not configured is estimated first ([`TurnTime`]), and all detections wait until then. The estimate
//! also depends on the data alone.
//!
//! # Numbers
//!
//! Scans are numbered so that a gap in the numbers is as many periods of silence ([`crate::scans`]). The first number
//! is that of the sixteenth of a second, counted from an epoch, in which the scan began. No sensor makes as many scans,
//! so a cutter that replaces another cutter begins with a number beyond all numbers of the other cutter.

mod empty_scans;

use std::collections::VecDeque;

use observations::Detection;

use crate::turn_time::{TurnEstimate, TurnTime};

/// Numbers set aside for each second.
pub const NUMBERS_PER_S: i64 = 16;
/// Shortest period, nanoseconds.
pub const PERIOD_MIN_NS: i64 = NS_PER_S / NUMBERS_PER_S;
/// Maximum of boundaries that detections have not reached yet.
const BOUNDARIES_MAX: usize = 8;
const NS_PER_S: i64 = messages::NS_PER_S as i64;
/// Period of a sensor that has shown none.
const PERIOD_UNKNOWN_NS: i64 = NS_PER_S;
/// Default wait: this fraction of a period.
const WAIT_PARTS: i64 = 10;

/// Settings of a cutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CutterSettings {
    /// Boundaries of scans.
    pub boundaries: Boundaries,
    /// Time that the sensor takes to look around, nanoseconds, at least [`PERIOD_MIN_NS`]; `None`: estimated from the
    /// data.
    pub period_ns: Option<i64>,
    /// Wait: time by which a detection may come after later ones, nanoseconds, at most a period; `None`: a tenth of a
    /// period.
    pub wait_ns: Option<i64>,
    /// Maximum of detections that wait for the end of their scan.
    pub waiting_max: usize,
    /// From where scan numbers count, UTC, nanoseconds.
    pub epoch_ns: i64,
}

settings::words! {
    /// Places where scans begin.
    pub enum Boundaries {
        /// Boundaries where the sensor says so.
        Turn = "turn",
        /// Boundaries at whole multiples of the period.
        Period = "period",
        /// The sensor numbers its scans itself ([`crate::stated_scans`]).
        Stated = "stated",
    }
}

/// A scan that is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CutScan {
    /// Number of the scan, also set in the detections.
    pub number: u32,
    /// Time of the latest detection, nanoseconds.
    pub time_ns: i64,
}

/// Treatment of a detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetectionTreatment {
    /// The detection waits until the scan is complete.
    Waits,
    /// The scan of the detection is complete already.
    TooLate,
    /// There is no room for the detection.
    Refused,
}

/// Times by which scans are cut, nanoseconds.
#[derive(Clone, Copy, Debug)]
struct Rhythm {
    period_ns: i64,
    wait_ns: i64,
}

/// The scan at hand.
#[derive(Clone, Copy, Debug)]
struct OpenScan {
    number: u32,
    begin_ns: i64,
    /// Set if the scan begins at a boundary reported by the sensor.
    at_boundary: bool,
}

#[derive(Clone, Copy, Debug)]
struct PendingDetection<T> {
    detection: Detection,
    with_it: T,
    /// Number of detections that came before.
    place: u64,
}

/// Cutter of a sensor's detections into scans. `T` stays with each detection: the time of receipt, for example.
#[derive(Clone, Debug)]
pub struct Cutter<T> {
    settings: CutterSettings,
    /// `None` until the period is known.
    rhythm: Option<Rhythm>,
    turn_time: TurnTime,
    scan: Option<OpenScan>,
    boundaries: VecDeque<i64>,
    waiting: Vec<PendingDetection<T>>,
    /// Time of the earliest waiting detection; `i64::MAX` without any.
    first_ns: i64,
    /// Number of detections that have come.
    came: u64,
    /// Latest time of anything that came.
    running_ns: i64,
    complete: Vec<Detection>,
    with_them: Vec<T>,
}

impl<T: Copy> Cutter<T> {
    /// Makes a cutter without data.
    pub fn new(settings: CutterSettings) -> Self {
        Self {
            settings,
            rhythm: settings.period_ns.map(|period_ns| settings.rhythm(period_ns)),
            turn_time: TurnTime::default(),
            scan: None,
            boundaries: VecDeque::with_capacity(BOUNDARIES_MAX),
            waiting: Vec::with_capacity(settings.waiting_max),
            first_ns: i64::MAX,
            came: 0,
            running_ns: i64::MIN,
            complete: Vec::with_capacity(settings.waiting_max),
            with_them: Vec::with_capacity(settings.waiting_max),
        }
    }

    /// Takes a detection together with the attached data.
    pub fn take(&mut self, detection: Detection, with_it: T) -> DetectionTreatment {
        let time_ns = detection.time_of_measurement_ns;
        if self.scan.is_some_and(|scan| time_ns < scan.begin_ns) {
            return DetectionTreatment::TooLate;
        }
        if self.waiting.len() == self.settings.waiting_max {
            return DetectionTreatment::Refused;
        }
        self.waiting.push(PendingDetection {
            detection,
            with_it,
            place: self.came,
        });
        self.came += 1;
        self.first_ns = self.first_ns.min(time_ns);
        self.turn_time.detected(&detection);
        self.passed(time_ns);
        DetectionTreatment::Waits
    }

    /// Takes the sensor's report that a turn begins at `time_ns`.
    pub fn turn_begins(&mut self, time_ns: i64) {
        let is_new = self.boundaries.back().is_none_or(|last_ns| *last_ns < time_ns);
        if self.settings.boundaries == Boundaries::Turn && is_new {
            if self.boundaries.len() == BOUNDARIES_MAX {
                self.boundaries.pop_front();
            }
            self.boundaries.push_back(time_ns);
        }
        self.turn_time.north(time_ns);
        self.passed(time_ns);
    }

    /// Takes the sensor's report that a turn takes `turn_ns` nanoseconds.
    pub fn turn_takes(&mut self, turn_ns: i64) {
        self.turn_time.stated(turn_ns);
    }

    /// Turn that the data have shown so far, whether or not used to cut scans.
    pub fn turn(&self) -> Option<TurnEstimate> {
        self.turn_time.turn()
    }

    /// Period of the scans, nanoseconds; `None` while unknown.
    pub fn period_ns(&self) -> Option<i64> {
        self.rhythm.map(|rhythm| rhythm.period_ns)
    }

    /// Whether no detection waits for a scan.
    pub fn is_idle(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Time from a boundary to the completion of the scan that begins there, nanoseconds; 0 until the period is known.
    pub fn span_ns(&self) -> i64 {
        self.rhythm.map_or(0, |rhythm| rhythm.period_ns + rhythm.wait_ns)
    }

    /// No scan that is complete later is earlier than this time, nanoseconds.
    pub fn earliest_ns(&self) -> i64 {
        self.scan.map_or(i64::MIN, |scan| scan.begin_ns)
    }

    /// The sensor's time has come to `time_ns`.
    pub fn passed(&mut self, time_ns: i64) {
        self.running_ns = self.running_ns.max(time_ns);
    }

    /// The next scan that is complete and has detections; [`Self::detections`] holds the detections until the next
    /// call.
    pub fn next_scan(&mut self) -> Option<CutScan> {
        self.complete_scan(self.running_ns)
    }

    /// The next waiting scan, whether or not more detections may come: for the end of the sensor's data.
    pub fn last_scan(&mut self) -> Option<CutScan> {
        self.complete_scan(i64::MAX)
    }

    /// Detections of the latest scan, ordered by time and, at equal times, by arrival.
    pub fn detections(&self) -> &[Detection] {
        &self.complete
    }

    /// Companions of the detections, in the same order.
    pub fn with_them(&self) -> &[T] {
        &self.with_them
    }

    /// Time after which a sensor that sends nothing is not waited for: a period and the wait, nanoseconds. `None` until
    /// the period is known.
    pub fn patience_ns(&self) -> Option<i64> {
        self.rhythm
            .map(|rhythm| rhythm.period_ns.saturating_add(rhythm.wait_ns))
    }

    fn complete_scan(&mut self, running_ns: i64) -> Option<CutScan> {
        self.complete.clear();
        self.with_them.clear();
        while !self.waiting.is_empty() {
            let rhythm = self.rhythm(running_ns == i64::MAX)?;
            let scan = self.scan_at_hand(rhythm);
            let (end_ns, is_said) = self.end(scan, rhythm, running_ns)?;
            if running_ns < end_ns.saturating_add(rhythm.wait_ns) {
                return None;
            }
            self.boundaries.retain(|boundary_ns| *boundary_ns > end_ns);
            self.collect(end_ns, scan.number);
            self.scan = Some(OpenScan {
                number: scan
                    .number
                    .saturating_add(rhythm.periods(end_ns.saturating_sub(scan.begin_ns))),
                begin_ns: end_ns,
                at_boundary: is_said || self.settings.boundaries == Boundaries::Period,
            });
            if let Some(last) = self.complete.last() {
                return Some(CutScan {
                    number: scan.number,
                    time_ns: last.time_of_measurement_ns,
                });
            }
        }
        None
    }

    /// Times by which scans are cut. `None` as long as the data may still show the period, that is, neither at the end
    /// of the data nor without room for more.
    fn rhythm(&mut self, have_ended: bool) -> Option<Rhythm> {
        if self.rhythm.is_none() {
            let is_late = have_ended || self.turn_time.is_unclear() || self.waiting.len() == self.settings.waiting_max;
            let found_ns = self.turn_time.turn().map(|turn| turn.ns);
            let period_ns = found_ns.or(is_late.then_some(PERIOD_UNKNOWN_NS));
            self.rhythm = period_ns.map(|period_ns| self.settings.rhythm(period_ns));
        }
        self.rhythm
    }

    /// Returns the current scan; after a silence, the scan of the next detection.
    fn scan_at_hand(&mut self, rhythm: Rhythm) -> OpenScan {
        let period_ns = rhythm.period_ns;
        let is_silence = |scan: &OpenScan| self.first_ns.saturating_sub(scan.begin_ns) >= 2 * period_ns;
        if let Some(scan) = self.scan.filter(|scan| !is_silence(scan)) {
            return scan;
        }
        let by_period = self.settings.boundaries == Boundaries::Period;
        let begin_ns = match by_period {
            true => self.first_ns.div_euclid(period_ns).saturating_mul(period_ns),
            false => self.first_ns,
        };
        let after = |scan: OpenScan| {
            let periods = rhythm.periods(begin_ns.saturating_sub(scan.begin_ns));
            scan.number.saturating_add(periods)
        };
        let scan = OpenScan {
            number: self.scan.map_or_else(|| self.first_number(begin_ns), after),
            begin_ns,
            at_boundary: by_period,
        };
        self.boundaries.retain(|boundary_ns| *boundary_ns > begin_ns);
        self.scan = Some(scan);
        scan
    }

    /// End of the scan, nanoseconds, and whether the sensor reported this time; `None` while a report is still
    /// possible.
    fn end(&self, scan: OpenScan, rhythm: Rhythm, running_ns: i64) -> Option<(i64, bool)> {
        let Rhythm { period_ns, wait_ns } = rhythm;
        // No turn is shorter than half a period, unless the beginning was not seen.
        let shortest_ns = if scan.at_boundary { period_ns / 2 } else { 0 };
        let after = |time_ns: i64| scan.begin_ns.saturating_add(time_ns);
        let latest_ns = after(period_ns + wait_ns);
        let mut said = self.boundaries.iter().copied();
        if let Some(said_ns) = said.find(|boundary_ns| (after(shortest_ns)..=latest_ns).contains(boundary_ns)) {
            return Some((said_ns, true));
        }
        let is_given = self.settings.boundaries == Boundaries::Period || running_ns > latest_ns;
        is_given.then_some((after(period_ns), false))
    }

    /// Moves the waiting detections before `end_ns` to the scan.
    fn collect(&mut self, end_ns: i64, number: u32) {
        // Unlike a stable sort, an unstable sort needs no memory.
        self.waiting
            .sort_unstable_by_key(|each| (each.detection.time_of_measurement_ns, each.place));
        let count = self
            .waiting
            .partition_point(|each| each.detection.time_of_measurement_ns < end_ns);
        for (detection_id, each) in (0..).zip(self.waiting.drain(..count)) {
            self.complete.push(Detection {
                scan: number,
                detection_id,
                ..each.detection
            });
            self.with_them.push(each.with_it);
        }
        let first = self.waiting.first();
        self.first_ns = first.map_or(i64::MAX, |each| each.detection.time_of_measurement_ns);
    }

    fn first_number(&self, begin_ns: i64) -> u32 {
        let since_ns = i128::from(begin_ns) - i128::from(self.settings.epoch_ns);
        let sixteenths = since_ns * i128::from(NUMBERS_PER_S) / i128::from(NS_PER_S);
        sixteenths.clamp(0, i128::from(u32::MAX / 2)) as u32
    }
}

impl CutterSettings {
    fn rhythm(&self, period_ns: i64) -> Rhythm {
        let wait_ns = self.wait_ns.map(|wait_ns| wait_ns.min(period_ns));
        Rhythm {
            period_ns,
            wait_ns: wait_ns.unwrap_or(period_ns / WAIT_PARTS),
        }
    }
}

impl Rhythm {
    /// Number of whole periods in a time, at least 1.
    fn periods(self, time_ns: i64) -> u32 {
        (time_ns.saturating_add(self.period_ns / 2) / self.period_ns).clamp(1, i64::from(u32::MAX)) as u32
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::{S, position};

    fn settings(boundaries: Boundaries) -> CutterSettings {
        CutterSettings {
            boundaries,
            period_ns: Some(4 * S),
            wait_ns: Some(S),
            waiting_max: 100,
            epoch_ns: 0,
        }
    }

    /// An event: a detection or a boundary, with the time in tenths of a second.
    #[derive(Clone, Copy, Debug)]
    enum Event {
        Plot(i64),
        North(i64),
    }
    use Event::{North, Plot};

    /// The scans: number, and the times of the detections in tenths of a second.
    fn cut(settings: CutterSettings, events: &[Event]) -> (Vec<(u32, Vec<i64>)>, usize) {
        let mut cutter = Cutter::new(settings);
        let (mut scans, mut late) = (Vec::new(), 0);
        let mut keep = |cutter: &Cutter<usize>, scan: CutScan| {
            let detections = cutter.detections();
            assert_eq!(scan.time_ns, detections.last().unwrap().time_of_measurement_ns);
            assert!(detections.iter().all(|each| each.scan == scan.number));
            assert_eq!(cutter.with_them().len(), detections.len());
            let times = detections.iter().map(|each| each.time_of_measurement_ns / (S / 10));
            scans.push((scan.number, times.collect::<Vec<i64>>()));
        };
        for (place, event) in events.iter().enumerate() {
            match *event {
                Plot(time) => {
                    let taken = cutter.take(position(time * (S / 10), 0.0, 0.0), place);
                    late += usize::from(taken == DetectionTreatment::TooLate);
                }
                North(time) => cutter.turn_begins(time * (S / 10)),
            }
            while let Some(scan) = cutter.next_scan() {
                keep(&cutter, scan);
            }
        }
        while let Some(scan) = cutter.last_scan() {
            keep(&cutter, scan);
        }
        (scans, late)
    }

    #[test]
    fn a_turn_reaches_from_north_to_north_whoever_comes_late() {
        let events = [
            Plot(10),
            Plot(35),
            North(38),
            Plot(41),
            Plot(36),
            Plot(60),
            North(78),
            Plot(79),
            Plot(77),
            Plot(90),
        ];
        let (scans, late) = cut(settings(Boundaries::Turn), &events);
        // The beginning of the first turn was not seen.
        assert_eq!(
            scans,
            [(16, vec![10, 35, 36]), (17, vec![41, 60, 77]), (18, vec![79, 90])]
        );
        assert_eq!(late, 0);
    }

    #[test]
    fn without_its_message_a_turn_lasts_a_period_and_what_is_too_late_is_refused() {
        let events = [North(0), Plot(1), Plot(38), Plot(52), Plot(39), Plot(95), Plot(60)];
        let (scans, late) = cut(settings(Boundaries::Turn), &events);
        assert_eq!(scans, [(1, vec![1, 38]), (2, vec![52]), (3, vec![95])]);
        assert_eq!(late, 2);
    }

    #[test]
    fn boundaries_in_a_row_are_one() {
        let events = [
            North(0),
            Plot(5),
            North(40),
            North(41),
            North(50),
            Plot(51),
            Plot(70),
            North(80),
            Plot(95),
        ];
        let (scans, _) = cut(settings(Boundaries::Turn), &events);
        assert_eq!(scans, [(8, vec![5]), (9, vec![51, 70]), (10, vec![95])]);
    }

    #[test]
    fn periods_are_whole_multiples_and_silence_is_a_gap_in_the_numbers() {
        let events = [Plot(41), North(50), Plot(79), Plot(81), Plot(250), Plot(271)];
        let (scans, _) = cut(settings(Boundaries::Period), &events);
        assert_eq!(scans, [(64, vec![41, 79]), (65, vec![81]), (69, vec![250, 271])]);
    }

    #[test]
    fn one_that_takes_anothers_place_has_greater_numbers() {
        let fastest = CutterSettings {
            period_ns: Some(PERIOD_MIN_NS),
            wait_ns: Some(0),
            ..settings(Boundaries::Turn)
        };
        let events: Vec<Event> = (100..400).map(Plot).collect();
        let (before, _) = cut(fastest, &events);
        let (after, _) = cut(fastest, &[Plot(400)]);
        assert!(before.last().unwrap().0 < after[0].0, "{before:?} {after:?}");
    }

    /// Before the turn is known, everything waits; then scans are cut as if the turn had been known from the first.
    #[test]
    fn a_period_that_is_not_configured_is_that_of_the_data() {
        let events: Vec<Event> = (0..12)
            .flat_map(|turn| [North(76 * turn), Plot(76 * turn + 30), Plot(76 * turn + 70)])
            .collect();
        let configured = CutterSettings {
            period_ns: Some(76 * S / 10),
            wait_ns: None,
            ..settings(Boundaries::Turn)
        };
        let found = CutterSettings {
            period_ns: None,
            ..configured
        };
        let (scans, late) = cut(found, &events);
        assert_eq!(scans.len(), 12);
        assert_eq!((scans, late), cut(configured, &events));

        let mut cutter = Cutter::new(found);
        for turn in 0..2 {
            cutter.turn_begins(76 * turn * S / 10);
            cutter.take(position((76 * turn + 30) * S / 10, 0.0, 1.0), ());
            assert_eq!(cutter.next_scan(), None);
        }
        cutter.turn_takes(76 * S / 10);
        assert_eq!(cutter.next_scan().map(|scan| scan.time_ns), Some(3 * S));
    }

    #[test]
    fn data_that_show_no_period_are_cut_all_the_same() {
        let unknown = CutterSettings {
            period_ns: None,
            wait_ns: None,
            waiting_max: 3,
            ..settings(Boundaries::Period)
        };
        let (scans, late) = cut(unknown, &[Plot(1), Plot(2), Plot(15), Plot(31), Plot(32)]);
        assert_eq!(
            scans,
            [(0, vec![1, 2]), (1, vec![15]), (3, vec![31, 32])],
            "no room for more"
        );
        assert_eq!(late, 0);
        let (scans, _) = cut(unknown, &[Plot(1), Plot(15)]);
        assert_eq!(scans, [(0, vec![1]), (1, vec![15])], "the data have ended");
    }

    #[test]
    fn room_is_bounded() {
        let mut cutter = Cutter::new(CutterSettings {
            waiting_max: 2,
            ..settings(Boundaries::Period)
        });
        let mut take = |time_ns| cutter.take(position(time_ns, 0.0, 0.0), ());
        assert_eq!(
            [take(0), take(1), take(2)],
            [
                DetectionTreatment::Waits,
                DetectionTreatment::Waits,
                DetectionTreatment::Refused
            ]
        );
    }

    proptest! {
        #[test]
        fn any_times_are_cut_into_rising_scans_and_nothing_is_lost(
            events in prop::collection::vec((prop::bool::weighted(0.2), any::<i64>(), -50i64..2000), 0..80),
            by_turn in any::<bool>(),
            is_configured in any::<bool>(),
            wild in any::<bool>(),
        ) {
            let boundaries = if by_turn { Boundaries::Turn } else { Boundaries::Period };
            let period_ns = is_configured.then_some(4 * S);
            let mut cutter = Cutter::new(CutterSettings { period_ns, ..settings(boundaries) });
            let (mut found, mut refused, mut last, mut given) = (0, 0, None, 0);
            for (is_boundary, wild_ns, tenths) in events {
                let time_ns = if wild { wild_ns } else { tenths * (S / 10) };
                if is_boundary {
                    cutter.turn_begins(time_ns);
                } else {
                    given += 1;
                    refused += usize::from(cutter.take(position(time_ns, 0.0, 0.0), ()) != DetectionTreatment::Waits);
                }
                while let Some(scan) = cutter.next_scan() {
                    found += cutter.detections().len();
                    prop_assert!(last.is_none_or(|last: CutScan| last.time_ns <= scan.time_ns));
                    prop_assert!(wild || last.is_none_or(|last: CutScan| last.number < scan.number));
                    last = Some(scan);
                }
            }
            while cutter.last_scan().is_some() {
                found += cutter.detections().len();
            }
            prop_assert_eq!(found + refused, given);
        }
    }
}
