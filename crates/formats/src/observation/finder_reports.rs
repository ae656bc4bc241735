//! Reports of radio direction finders in ASTERIX (category 205), as measurements for the source's locator.
//!
//! A system of several finders sends bearings, and positions that it has made of these bearings: to use both would
//! count each bearing twice. Bearings are used, and positions where no bearings come.
//!
//! A track number (I205/160) of a system is that of a transmission. The number of a single sensor (message type 5) is
//! the sensor's own: the same transmission has another one at the next sensor. Unless the source is a single sender, by
//! its SAC and SIC, the bearings of sensors are joined by their channel and time ([`Transmissions`]).

use frames::time::NS_PER_S;
use messages::{Counter, Counters};
use observations::{Bearing, EmitterMeasurement};

use super::cat205::{DirectionFinder, FinderRefusal, FinderReport, FinderReportKind, finder_report};
use super::transmissions::Transmissions;

/// Time after a bearing for which positions of the same sender are repetitions, nanoseconds.
const BEARING_AGE_MAX_NS: u64 = 10 * NS_PER_S.unsigned_abs();
/// Half a day, nanoseconds.
const HALF_A_DAY_NS: i64 = 43_200 * NS_PER_S;

/// Finder, or system of finders, and counts of its reports.
#[derive(Debug)]
pub struct FinderReports {
    finder: DirectionFinder,
    /// The place of `finder` is stated.
    is_placed: bool,
    sac_sic: Option<(u8, u8)>,
    /// Time of the latest report, UTC, nanoseconds.
    latest_ns: Option<i64>,
    /// Time of the latest bearing.
    bearing_ns: Option<i64>,
    transmissions: Transmissions,
    counters: Counters,
}

impl FinderReports {
    /// The reports of a finder. `is_placed`: the place of `finder` is stated; otherwise reports without a position are
    /// refused. With SAC and SIC, the reports of this sender alone.
    pub fn new(finder: DirectionFinder, is_placed: bool, sac_sic: Option<(u8, u8)>) -> Self {
        Self {
            finder,
            is_placed,
            sac_sic,
            latest_ns: None,
            bearing_ns: None,
            transmissions: Transmissions::default(),
            counters: Counters::default(),
        }
    }

    /// Counts of reports without a measurement.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The measurement in a record, at a time of day of the day nearest to `received_ns` (UTC, nanoseconds), or in a
    /// recording to the report before, the first of which is on the day that begins at `first_day_ns`. `None` of a
    /// record without a measurement.
    ///
    /// # Errors
    /// The reason. It is counted.
    pub fn take(
        &mut self,
        record: &asterix::Record<'_>,
        received_ns: Option<i64>,
        first_day_ns: i64,
    ) -> Result<Option<EmitterMeasurement>, FinderRefusal> {
        let Some(report) = finder_report(record) else {
            return Ok(None);
        };
        if !report.may_be_of(self.sac_sic) {
            self.counters[Counter::RejectedSource] += 1;
            return Ok(None);
        }
        if matches!(report.kind, FinderReportKind::End | FinderReportKind::Conflict) {
            if let Some(channel) = report.channel.filter(|_| report.kind == FinderReportKind::End) {
                self.transmissions.end(channel);
            }
            self.counters[Counter::ServiceMessages] += 1;
            return Ok(None);
        }
        let near_ns = received_ns.or(self.latest_ns).unwrap_or(first_day_ns + HALF_A_DAY_NS);
        let placed = self.placed(&report);
        match placed.and_then(|report| report.measurement(&self.finder, near_ns)) {
            Ok(measured) => Ok(self.used(&report, measured)),
            Err(refusal) => {
                self.counters[counter(refusal)] += 1;
                Err(refusal)
            }
        }
    }

    /// The report, if every position that it needs is stated, in the report or beside it.
    fn placed<'a>(&self, report: &'a FinderReport) -> Result<&'a FinderReport, FinderRefusal> {
        match self.is_placed || report.geodetic.is_some() {
            true => Ok(report),
            false => Err(FinderRefusal::Position),
        }
    }

    fn used(&mut self, report: &FinderReport, measured: EmitterMeasurement) -> Option<EmitterMeasurement> {
        let time_ns = measured.time_ns();
        self.latest_ns = Some(time_ns);
        match measured {
            EmitterMeasurement::Bearing(bearing) => {
                self.bearing_ns = Some(time_ns);
                let is_common = report.kind == FinderReportKind::Bearing || self.sac_sic.is_some();
                let finder = (report.sac_sic, report.sensor);
                let transmission = |channel| self.transmissions.number(channel, finder, &bearing);
                let emitter_id = bearing
                    .emitter_id
                    .filter(|_| is_common)
                    .or_else(|| report.channel.map(transmission));
                Some(EmitterMeasurement::Bearing(Bearing { emitter_id, ..bearing }))
            }
            EmitterMeasurement::Fix(_) | EmitterMeasurement::Arrival(_) => {
                let repeats = |bearing_ns: i64| bearing_ns.abs_diff(time_ns) <= BEARING_AGE_MAX_NS;
                let is_repetition = self.bearing_ns.is_some_and(repeats);
                self.counters[Counter::ServiceMessages] += u64::from(is_repetition);
                (!is_repetition).then_some(measured)
            }
        }
    }
}

/// Counter of reports that are refused for a reason.
fn counter(refusal: FinderRefusal) -> Counter {
    match refusal {
        FinderRefusal::Time => Counter::RejectedTime,
        FinderRefusal::Position => Counter::RejectedNoPosition,
        FinderRefusal::PositionRange => Counter::RejectedPosition,
        FinderRefusal::TrackNumber => Counter::RejectedNoTrackNumber,
        FinderRefusal::Uncertainty => Counter::RejectedQuality,
        FinderRefusal::Kind | FinderRefusal::Bearing | FinderRefusal::BearingRange => Counter::DetectionsRejected,
    }
}

#[cfg(test)]
mod tests {
    use asterix::StatedTables;
    use frames::{Geodetic, SystemFrame};

    use super::*;

    /// A finder at 47° N, 8° E.
    fn finder(is_placed: bool, sac_sic: Option<(u8, u8)>) -> FinderReports {
        let place = Geodetic::from_degrees(47.0, 8.0, 0.0).unwrap();
        let finder = DirectionFinder::new(&SystemFrame::at(place), place, 3f64.to_radians()).unwrap();
        FinderReports::new(finder, is_placed, sac_sic)
    }

    type Taken = Result<Option<EmitterMeasurement>, FinderRefusal>;

    /// What is made of the report with these items behind SAC 25 and SIC 9.
    fn taken(reports: &mut FinderReports, fspec: &[u8], items: &[&[u8]]) -> Taken {
        let body = [fspec, &[25, 9], &items.concat()].concat();
        let block = [&[205, 0, body.len() as u8 + 3], &body[..]].concat();
        let mut decoder = StatedTables::new(&[], true).decoder();
        let record = decoder.records(&block).next().unwrap().unwrap();
        reports.take(&record, None, 0)
    }

    /// Time of day, so many seconds after midnight.
    fn time(seconds: u32) -> [u8; 3] {
        let [_, time @ ..] = (128 * seconds).to_be_bytes();
        time
    }

    const PLACE: [u8; 8] = [0x00, 0x85, 0xB0, 0x5B, 0x00, 0x16, 0xC1, 0x6C]; // 47° N, 8° E

    /// Type 5: a bearing of 45° at 47° N, 8° E, of the track number 7.
    fn bearing(reports: &mut FinderReports, seconds: u32) -> Taken {
        let items: [&[u8]; 5] = [&[5], &time(seconds), &PLACE, &4500_u16.to_be_bytes(), &[0, 7]];
        taken(reports, &[0xB3, 0x41, 0x20], &items)
    }

    /// Type 1: a position with a radius of 500 m, of the track number 7.
    fn fix(reports: &mut FinderReports, seconds: u32) -> Taken {
        let items: [&[u8]; 5] = [&[1], &time(seconds), &PLACE, &[5], &[0, 7]];
        taken(reports, &[0xB3, 0x09, 0x20], &items)
    }

    #[test]
    fn positions_beside_bearings_are_repetitions() {
        let mut reports = finder(false, None);
        assert!(matches!(fix(&mut reports, 10), Ok(Some(EmitterMeasurement::Fix(_)))));
        let Ok(Some(EmitterMeasurement::Bearing(found))) = bearing(&mut reports, 20) else {
            panic!()
        };
        assert!((found.sigma_rad - 3f64.to_radians()).abs() < 1e-12 && found.time_of_measurement_ns == 20 * NS_PER_S);
        assert_eq!(fix(&mut reports, 30), Ok(None));
        assert!(fix(&mut reports, 31).unwrap().is_some());
        assert_eq!(reports.counters()[Counter::ServiceMessages], 1);
    }

    #[test]
    fn numbers_of_sensors_are_those_of_one_sender_only() {
        let number = |sac_sic| match bearing(&mut finder(false, sac_sic), 0) {
            Ok(Some(EmitterMeasurement::Bearing(bearing))) => bearing.emitter_id,
            other => panic!("{other:?}"),
        };
        assert_eq!((number(None), number(Some((25, 9)))), (None, Some(7)));
        let mut other = finder(false, Some((25, 8)));
        assert_eq!(bearing(&mut other, 0), Ok(None));
        assert_eq!(other.counters()[Counter::RejectedSource], 1);
    }

    #[test]
    fn a_place_comes_from_the_report_or_is_stated() {
        // Type 5 without a position.
        let unplaced = |reports: &mut FinderReports| {
            let items: [&[u8]; 3] = [&[5], &time(0), &4500_u16.to_be_bytes()];
            taken(reports, &[0xB1, 0x40], &items)
        };
        let mut reports = finder(false, None);
        assert_eq!(unplaced(&mut reports), Err(FinderRefusal::Position));
        assert_eq!(reports.counters()[Counter::RejectedNoPosition], 1);
        assert!(unplaced(&mut finder(true, None)).unwrap().is_some());
        // Type 4: the end of a transmission.
        assert_eq!(taken(&mut reports, &[0xB0], &[&[4], &time(0)]), Ok(None));
    }
}
