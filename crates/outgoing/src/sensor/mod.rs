//! Sensor tracks as the sensor itself would send them.
//!
//! The category determines the kind of sensor: a radar (048), a multilateration system (020), an ADS-B ground station
//! (021) or a surface movement sensor (010). Each kind has its own frame and items; this module contains the common
//! parts.
//!
//! A track's end is sent without position or motion: nothing was seen then, and the last position is an old one.

mod adsb;
mod adsb_early;
mod multilateration;
mod radar;
mod surface;

use frames::{SensorFrame, SystemFrame};
use messages::{Identity, SensorTrack, TrackState, sensor_track_bits as bits};

use super::place::{self, Axis, TargetPlace};
use super::track_numbers::TrackNumbers;
use super::{
    BlockOutbox, HeightReference, OutgoingCounts, OutgoingError, SendBlock, Unsent, check_category, items, quantity,
};
use asterix::categories::{CAT010_V1_1, CAT020, CAT021_V0, CAT021_V2, CAT048};
use asterix::{Category, RecordWriter, registry};

/// The greatest track number: 12 bits in all these categories.
const NUMBER_MAX: u16 = 4095;

/// Sends one sensor's tracks and status messages.
#[derive(Debug)]
pub struct SensorReports {
    outbox: BlockOutbox,
    record: RecordWriter,
    status: (RecordWriter, BlockOutbox),
    numbers: TrackNumbers<()>,
    site: Site,
    form: ReportForm,
}

/// The sensor, and the common settings of its records.
#[derive(Debug)]
struct Site {
    source: [u8; 2],
    frame: SensorFrame,
    system: SystemFrame,
    /// The sensor's x, y and up.
    axes: [Axis; 3],
    height: HeightReference,
    simulated: bool,
}

/// Form of the reports, by category.
#[derive(Debug)]
enum ReportForm {
    Radar(radar::RadarForm),
    Multilateration(multilateration::MultilaterationForm),
    AdsB,
    EarlyAdsB(adsb_early::AdsbForm),
    Surface,
}

/// Report of a track, with the values needed by every category.
struct SensorReport<'t> {
    track: &'t SensorTrack,
    state: TrackState,
    number: u16,
    /// Place of the target; `None` at the end of a track.
    place: Option<TargetPlace>,
}

impl SensorReports {
    /// A sender in this edition of CAT048, 020, 021 or 010, from a sensor with these codes (SAC, SIC), in blocks of at
    /// most `block_octets_max` bytes. Status messages are sent in the category that belongs to it: CAT034, 019, 023 or
    /// 010.
    ///
    /// # Errors
    /// If the table is of another category, or the block size is not between
    /// [`BLOCK_OCTETS_LEAST`](super::BLOCK_OCTETS_LEAST) and [`BLOCK_OCTETS_MOST`](super::BLOCK_OCTETS_MOST).
    pub fn new(
        table: &'static Category,
        sac: u8,
        sic: u8,
        sensor: SensorFrame,
        system: SystemFrame,
        block_octets_max: usize,
    ) -> Result<Self, OutgoingError> {
        let (form, status) = ReportForm::new(table)?;
        Ok(Self {
            outbox: BlockOutbox::new(table.number, block_octets_max)?,
            record: RecordWriter::new(table),
            status: (
                RecordWriter::new(status),
                BlockOutbox::new(status.number, block_octets_max)?,
            ),
            numbers: TrackNumbers::new(NUMBER_MAX, usize::from(NUMBER_MAX)),
            site: Site {
                source: [sac, sic],
                frame: sensor,
                system,
                axes: place::axes(&sensor, [0.0; 3]),
                height: HeightReference::default(),
                simulated: false,
            },
            form,
        })
    }

    /// Sends heights of this kind; without this call they are geometric. A radar has flight levels in any case.
    #[must_use]
    pub fn with_height(mut self, height: HeightReference) -> Self {
        self.site.height = height;
        self
    }

    /// Marks every report as simulated. Many a receiver, Koseki's adapters among them, uses no such reports.
    #[must_use]
    pub fn marked_simulated(mut self) -> Self {
        self.site.simulated = true;
        self
    }

    /// Sends a report, with the block it completes.
    pub fn report(&mut self, track: &SensorTrack, send: &mut SendBlock<'_>) {
        if let Err(reason) = self.write(track) {
            self.outbox.count(reason);
            return;
        }
        self.outbox.push(self.record.finish(), send);
    }

    /// Sends a radar's plot: the measurement at `time_ns` (UTC, nanoseconds) of a position in the system frame.
    /// Without `height_known`, the target's reply contained no height. Other sensors report no plots.
    pub fn plot(&mut self, time_ns: i64, position_m: [f64; 3], height_known: bool, send: &mut SendBlock<'_>) {
        self.replied_plot(time_ns, position_m, height_known, &Identity::default(), send);
    }

    /// Sends a radar's plot as [`Self::plot`], with the identity in the target's reply.
    pub fn replied_plot(
        &mut self,
        time_ns: i64,
        position_m: [f64; 3],
        height_known: bool,
        identity: &Identity,
        send: &mut SendBlock<'_>,
    ) {
        let place = TargetPlace::new(&self.site.system, position_m).ok_or(Unsent::Position);
        let written = match &self.form {
            ReportForm::Radar(form) => place.and_then(|place| {
                let height_m = height_known.then(|| place.geodetic.height_m());
                form.write_plot(&self.site, time_ns, position_m, (height_m, identity), &mut self.record)
            }),
            _ => Err(Unsent::Withheld),
        };
        match written {
            Ok(()) => self.outbox.push(self.record.finish(), send),
            Err(reason) => self.outbox.count(reason),
        }
    }

    /// Hands over the block that is being filled.
    pub fn flush(&mut self, send: &mut SendBlock<'_>) {
        self.outbox.flush(send);
    }

    /// Sends the periodic status message of the category, after all earlier reports: north marker (CAT034), periodic
    /// status (CAT019, 010), ground station status (CAT023). The message reports the sensor as operational.
    pub fn status(&mut self, now_utc_ns: i64, send: &mut SendBlock<'_>) {
        let record = &mut self.status.0;
        match self.form {
            ReportForm::Radar(_) => radar::north_marker(&self.site, now_utc_ns, record),
            ReportForm::Multilateration(_) => multilateration::status(&self.site, now_utc_ns, record),
            ReportForm::AdsB | ReportForm::EarlyAdsB(_) => adsb::status(&self.site, now_utc_ns, record),
            ReportForm::Surface => surface::status(&self.site, now_utc_ns, record),
        }
        self.send_status(send);
    }

    /// Sends the message that a radar's antenna enters the sector at this azimuth (rad, clockwise from the sensor's
    /// north), after all earlier reports. Other sensors have no turning antenna, and send nothing.
    pub fn sector(&mut self, now_utc_ns: i64, azimuth_rad: f64, send: &mut SendBlock<'_>) {
        if let ReportForm::Radar(_) = self.form {
            radar::sector_crossing(&self.site, now_utc_ns, azimuth_rad, &mut self.status.0);
            self.send_status(send);
        }
    }

    /// Returns the counts of sent and rejected records, including status messages.
    pub fn counts(&self) -> OutgoingCounts {
        let (reports, status) = (self.outbox.counts, self.status.1.counts);
        OutgoingCounts {
            records: reports.records + status.records,
            blocks: reports.blocks + status.blocks,
            ..reports
        }
    }

    fn send_status(&mut self, send: &mut SendBlock<'_>) {
        let (record, outbox) = &mut self.status;
        self.outbox.flush(send);
        outbox.push(record.finish(), send);
        outbox.flush(send);
    }

    fn write(&mut self, track: &SensorTrack) -> Result<(), Unsent> {
        let state = TrackState::from_code(track.state).ok_or(Unsent::Withheld)?;
        let (key, now_ns) = (track.track_number, track.time_of_measurement_ns);
        let (place, number) = if state == TrackState::Terminated {
            let entry = self.numbers.end(key, now_ns).ok_or(Unsent::Withheld)?;
            (None, entry.number)
        } else {
            self.form.check(track, state)?;
            let place = TargetPlace::new(&self.site.system, track.position_m).ok_or(Unsent::Position)?;
            let number = if self.form.has_track_numbers() {
                self.numbers.report(key, now_ns).ok_or(Unsent::Number)?.number
            } else {
                0
            };
            (Some(place), number)
        };
        if place.is_none() && self.form.is_adsb() {
            return Err(Unsent::Withheld);
        }
        let report = SensorReport {
            track,
            state,
            number,
            place,
        };
        let (site, record) = (&self.site, &mut self.record);
        match &self.form {
            ReportForm::Radar(form) => form.write(site, &report, record)?,
            ReportForm::Multilateration(form) => form.write(site, &report, record),
            ReportForm::AdsB => adsb::write(site, &report, record),
            ReportForm::EarlyAdsB(form) => form.write(site, &report, record),
            ReportForm::Surface => surface::write(site, &report, record),
        }
        Ok(())
    }
}

impl ReportForm {
    /// The form of a table, and the table of its status messages.
    fn new(table: &'static Category) -> Result<(Self, &'static Category), OutgoingError> {
        let (form, status) = if table.is_one_of(CAT048) {
            (Self::Radar(radar::RadarForm::new(table)), 34)
        } else if table.is_one_of(CAT020) {
            (
                Self::Multilateration(multilateration::MultilaterationForm::new(table)),
                19,
            )
        } else if table.is_one_of(CAT021_V2) {
            (Self::AdsB, 23)
        } else if table.is_one_of(CAT021_V0) {
            (Self::EarlyAdsB(adsb_early::AdsbForm::new(table)), 23)
        } else {
            check_category(table, &[&CAT010_V1_1], "CAT048, CAT020, CAT021 and CAT010")?;
            (Self::Surface, 10)
        };
        let status = registry::default_edition(status).expect("status categories have tables");
        Ok((form, status))
    }

    /// True for a category of received reports, without coasted and terminated tracks.
    fn is_adsb(&self) -> bool {
        matches!(self, Self::AdsB | Self::EarlyAdsB(_))
    }

    fn has_track_numbers(&self) -> bool {
        !matches!(self, Self::EarlyAdsB(_))
    }

    /// Rejects live tracks for which the category has no report.
    fn check(&self, track: &SensorTrack, state: TrackState) -> Result<(), Unsent> {
        if self.is_adsb() && state == TrackState::Coasted {
            Err(Unsent::Withheld)
        } else if self.is_adsb() && track.identity.address().is_none() {
            Err(Unsent::Address)
        } else {
            Ok(())
        }
    }
}

impl SensorReport<'_> {
    fn has(&self, valid: u16) -> bool {
        self.track.has(valid)
    }

    fn is_tentative(&self) -> bool {
        self.state == TrackState::Tentative
    }

    fn is_coasted(&self) -> bool {
        self.state == TrackState::Coasted
    }

    fn is_ended(&self) -> bool {
        self.place.is_none()
    }

    /// True for a report of something received just now.
    fn is_received(&self) -> bool {
        !self.is_coasted() && !self.is_ended()
    }

    fn on_ground(&self) -> bool {
        self.has(bits::ON_GROUND)
    }

    fn special_identification(&self) -> bool {
        items::special_identification(self.track.alerts)
    }

    /// Height above the ellipsoid, metres, where it was observed.
    fn height_m(&self) -> Option<f64> {
        let place = self.place.filter(|_| self.has(bits::HEIGHT))?;
        Some(place.geodetic.height_m())
    }

    /// Standard deviation of that height, metres, where known.
    fn height_sigma_m(&self) -> Option<f64> {
        let up = self.place.filter(|_| self.has(bits::HEIGHT))?.up();
        quantity::sigma(place::position_covariance(&self.track.covariance, up, up))
    }

    /// Components of velocity towards east and north at the target, metres per second, where known.
    fn velocity_mps(&self) -> Option<[f64; 2]> {
        let place = self.place.filter(|_| self.has(bits::VELOCITY))?;
        let axes = place.horizontal(self.has(bits::VERTICAL_RATE));
        Some(axes.map(|axis| place::along(axis, self.track.velocity_mps)))
    }

    /// Rate of climb, metres per second, where known. Without a horizontal velocity, the system's vertical one.
    fn climb_mps(&self) -> Option<f64> {
        let up = self.place.filter(|_| self.has(bits::VERTICAL_RATE))?.up();
        let up = if self.has(bits::VELOCITY) {
            up
        } else {
            [0.0, 0.0, up[2]]
        };
        Some(place::along(up, self.track.velocity_mps))
    }

    /// Covariance of velocity along two directions in the horizontal plane, m²/s².
    fn velocity_covariance(&self) -> Option<[f64; 3]> {
        let place = self.place.filter(|_| self.has(bits::VELOCITY))?;
        let [east, north] = place.horizontal(self.has(bits::VERTICAL_RATE));
        let covariance = |a, b| place::velocity_covariance(&self.track.covariance, a, b);
        Some([
            covariance(east, east),
            covariance(east, north),
            covariance(north, north),
        ])
    }
}

impl Site {
    /// A height or rate of climb, if heights are geometric.
    fn geometric(&self, value: Option<f64>) -> Option<f64> {
        value.filter(|_| self.height == HeightReference::Geometric)
    }

    /// A height or rate of climb, if heights are barometric.
    fn barometric(&self, value: Option<f64>) -> Option<f64> {
        value.filter(|_| self.height == HeightReference::Barometric)
    }

    /// Covariance of a report's position (xx, xy, yy; m²) along the sensor's own axes, where it is known.
    fn position_covariance(&self, report: &SensorReport<'_>) -> Option<[f64; 3]> {
        let [x, y] = self.plane(report.has(bits::HEIGHT));
        let covariance = |a, b| place::position_covariance(&report.track.covariance, a, b);
        let [xx, xy, yy] = [covariance(x, x), covariance(x, y), covariance(y, y)];
        let known = !report.is_ended() && xy.is_finite() && quantity::sigma(xx).and(quantity::sigma(yy)).is_some();
        known.then_some([xx, xy, yy])
    }

    /// Returns the axes of the sensor's x and y. Without `vertical_known` the axes are for level flight.
    fn plane(&self, vertical_known: bool) -> [Axis; 2] {
        let [x, y, _] = self.axes;
        [x, y].map(|axis| [axis[0], axis[1], if vertical_known { axis[2] } else { 0.0 }])
    }

    /// Components of velocity along the sensor's own x and y, metres per second, where known.
    fn velocity_mps(&self, report: &SensorReport<'_>) -> Option<[f64; 2]> {
        let known = report.has(bits::VELOCITY) && !report.is_ended();
        let axes = self.plane(report.has(bits::VERTICAL_RATE));
        known.then(|| axes.map(|axis| place::along(axis, report.track.velocity_mps)))
    }
}
