//! Status of the system and of its sensors: CAT065 and CAT063.
//!
//! CAT065 carries the state of the system, and events of its service: degraded, interrupted, ended. Other messages of
//! the category, ends of batches, are not sent. CAT063 has a record per sensor with the state known to the caller:
//! the connection, the presence of reports, and the known biases. Gains of the range are not estimated, and sent as
//! 0.

use super::quantity::nearest;
use super::{BlockOutbox, OutgoingCounts, OutgoingError, SendBlock, check_category, items};
use asterix::categories::{CAT063, CAT065};
use asterix::field::{Elements, Field, elements, field, item, whole};
use asterix::{Category, Frn, RecordWriter};

/// Items of CAT065.
mod system {
    use super::*;

    pub(super) const SOURCE: Elements<2> = elements(CAT065, "010", ["SAC", "SIC"]);
    pub(super) const MESSAGE_TYPE: Elements<1> = whole(CAT065, "000");
    pub(super) const SERVICE: Elements<1> = whole(CAT065, "015");
    pub(super) const TIME: Elements<1> = whole(CAT065, "030");
    pub(super) const EVENT: Elements<1> = whole(CAT065, "050");
    pub(super) const STATUS: Elements<5> = elements(CAT065, "040", ["NOGO", "OVL", "TSV", "PSS", "STTN"]);
}

/// Items of CAT063.
mod sensor {
    use super::*;

    pub(super) const SOURCE: Elements<2> = elements(CAT063, "010", ["SAC", "SIC"]);
    pub(super) const SERVICE: Elements<1> = whole(CAT063, "015");
    pub(super) const TIME: Elements<1> = whole(CAT063, "030");
    pub(super) const SENSOR: Elements<2> = elements(CAT063, "050", ["SAC", "SIC"]);
    pub(super) const STATUS: Frn = item(CAT063, "060");
    pub(super) const CON: Field = field(CAT063, &["060", "CON"]);
    pub(super) const TSV: Field = field(CAT063, &["060", "TSV"]);
    pub(super) const NPW: Field = field(CAT063, &["060", "NPW"]);
    pub(super) const TIME_BIAS: Elements<1> = whole(CAT063, "070");
    pub(super) const SECONDARY_RANGE: Elements<2> = elements(CAT063, "080", ["SRG", "SRB"]);
    pub(super) const SECONDARY_AZIMUTH: Elements<1> = whole(CAT063, "081");
    pub(super) const PRIMARY_RANGE: Elements<2> = elements(CAT063, "090", ["PRG", "PRB"]);
    pub(super) const PRIMARY_AZIMUTH: Elements<1> = whole(CAT063, "091");
}

/// The state of the system (I065/040).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SystemStatus {
    /// Condition: whether the sensor's tracks may be used.
    pub condition: Condition,
    /// True for a system that can not keep up.
    pub overloaded: bool,
    /// True if its time source is not valid.
    pub time_source_invalid: bool,
    /// Selected processing system of up to three, from 1; 0 where that does not apply.
    pub processing_system: u8,
    /// Another value than before: tracks have been numbered anew since.
    pub renumbered: bool,
}

/// Event of the service (I065/050); the numbers are those of the item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceEvent {
    /// Degradation has begun.
    Degraded = 1,
    /// Degradation has ended.
    DegradationEnded = 2,
    /// Interruption due to a contingency.
    Interrupted = 5,
    /// Ready for the restart of the service after a contingency.
    ReadyAgain = 6,
    /// End by the operator.
    Ended = 7,
}

impl ServiceEvent {
    /// Event that leads from one condition of the system to another; `None`: none does.
    pub fn between(before: Condition, now: Condition) -> Option<Self> {
        let runs = |condition| matches!(condition, Condition::Operational | Condition::Degraded);
        match (before, now) {
            (Condition::Operational, Condition::Degraded) => Some(Self::Degraded),
            (Condition::Degraded, Condition::Operational) => Some(Self::DegradationEnded),
            (before, Condition::NotConnected) if runs(before) => Some(Self::Interrupted),
            (Condition::NotConnected, now) if runs(now) => Some(Self::ReadyAgain),
            _ => None,
        }
    }
}

/// Condition of a system or sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// Operational.
    #[default]
    Operational,
    /// Operational with restrictions.
    Degraded,
    /// Starting. CAT065 has no such state; the state is sent as unknown.
    Initialising,
    /// Not connected.
    NotConnected,
}

/// The state of one sensor (I063/060).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorStatus {
    /// System area code of the sensor.
    pub sac: u8,
    /// System identification code of the sensor.
    pub sic: u8,
    /// Condition, as the system sees it.
    pub condition: Condition,
    /// No reports come from it.
    pub silent: bool,
    /// True if its time source is not valid.
    pub time_source_invalid: bool,
    /// Biases of its reports.
    pub biases: SensorBiases,
}

/// Known biases of a sensor (I063/070 to 091): reported value less the true one; `None`: not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorBiases {
    /// Time stamps, seconds.
    pub time_s: Option<f64>,
    /// Range, metres.
    pub range_m: Option<f64>,
    /// Azimuth, clockwise, radians.
    pub azimuth_rad: Option<f64>,
    /// True if range and azimuth are those of a primary radar (I063/090 and 091, else 080 and 081).
    pub primary: bool,
}

/// Sends the state of the system (CAT065) and of its sensors (CAT063).
#[derive(Debug)]
pub struct StatusReports {
    source: [u8; 2],
    service: Option<u8>,
    of_system: (RecordWriter, BlockOutbox),
    of_sensors: (RecordWriter, BlockOutbox),
}

impl StatusReports {
    /// A sender of these editions of CAT065 and CAT063, from a system with these codes (SAC, SIC), in blocks of at most
    /// `block_octets_max` bytes.
    ///
    /// # Errors
    /// If a table is of another category, or the block size is not possible.
    pub fn new(
        of_system: &'static Category,
        of_sensors: &'static Category,
        sac: u8,
        sic: u8,
        block_octets_max: usize,
    ) -> Result<Self, OutgoingError> {
        check_category(of_system, CAT065, "CAT065")?;
        check_category(of_sensors, CAT063, "CAT063")?;
        Ok(Self {
            source: [sac, sic],
            service: None,
            of_system: (
                RecordWriter::new(of_system),
                BlockOutbox::new(of_system.number, block_octets_max)?,
            ),
            of_sensors: (
                RecordWriter::new(of_sensors),
                BlockOutbox::new(of_sensors.number, block_octets_max)?,
            ),
        })
    }

    /// Sends this service identification (I065/015, I063/015).
    #[must_use]
    pub fn with_service(mut self, service: u8) -> Self {
        self.service = Some(service);
        self
    }

    /// Sends the state of the system at `now_utc_ns`, in a block of its own.
    pub fn system(&mut self, now_utc_ns: i64, status: SystemStatus, send: &mut SendBlock<'_>) {
        let no_go = match status.condition {
            Condition::Operational => 0,
            Condition::Degraded => 1,
            Condition::NotConnected => 2,
            Condition::Initialising => 3,
        };
        let (record, outbox) = &mut self.of_system;
        items::source(record, &system::SOURCE, self.source);
        record.write(&system::MESSAGE_TYPE, [1]);
        items::number(record, &system::SERVICE, self.service.map(i64::from));
        items::time_of_day(record, &system::TIME, now_utc_ns);
        let numbers = [
            no_go,
            i64::from(status.overloaded),
            i64::from(status.time_source_invalid),
            i64::from(status.processing_system.min(3)),
            i64::from(status.renumbered),
        ];
        record.write(&system::STATUS, numbers);
        outbox.push(record.finish(), send);
        outbox.flush(send);
    }

    /// Sends an event of the service at `now_utc_ns`, in a block of its own.
    pub fn event(&mut self, now_utc_ns: i64, event: ServiceEvent, send: &mut SendBlock<'_>) {
        let (record, outbox) = &mut self.of_system;
        items::source(record, &system::SOURCE, self.source);
        record.write(&system::MESSAGE_TYPE, [3]);
        items::number(record, &system::SERVICE, self.service.map(i64::from));
        items::time_of_day(record, &system::TIME, now_utc_ns);
        record.write(&system::EVENT, [event as i64]);
        outbox.push(record.finish(), send);
        outbox.flush(send);
    }

    /// Sends the state of each sensor, in as many blocks as it takes.
    pub fn sensors(&mut self, now_utc_ns: i64, sensors: &[SensorStatus], send: &mut SendBlock<'_>) {
        let (record, outbox) = &mut self.of_sensors;
        for sensor in sensors {
            items::source(record, &sensor::SOURCE, self.source);
            items::number(record, &sensor::SERVICE, self.service.map(i64::from));
            items::time_of_day(record, &sensor::TIME, now_utc_ns);
            items::source(record, &sensor::SENSOR, [sensor.sac, sensor.sic]);
            let condition = match sensor.condition {
                Condition::Operational => 0,
                Condition::Degraded => 1,
                Condition::Initialising => 2,
                Condition::NotConnected => 3,
            };
            record
                .item(sensor::STATUS)
                .put(sensor::CON, condition)
                .put(sensor::TSV, sensor.time_source_invalid)
                .put(sensor::NPW, sensor.silent);
            biases(record, &sensor.biases);
            outbox.push(record.finish(), send);
        }
        outbox.flush(send);
    }

    /// Returns the counts of sent records.
    pub fn counts(&self) -> OutgoingCounts {
        let (system, sensors) = (self.of_system.1.counts, self.of_sensors.1.counts);
        OutgoingCounts {
            records: system.records + sensors.records,
            blocks: system.blocks + sensors.blocks,
            ..OutgoingCounts::default()
        }
    }
}

/// Writes the biases that are known and that their items can hold.
fn biases(record: &mut RecordWriter, known: &SensorBiases) {
    let (range, azimuth) = match known.primary {
        true => (&sensor::PRIMARY_RANGE, &sensor::PRIMARY_AZIMUTH),
        false => (&sensor::SECONDARY_RANGE, &sensor::SECONDARY_AZIMUTH),
    };
    if let Some(numbers) = known.time_s.and_then(|time_s| nearest(&sensor::TIME_BIAS, [time_s])) {
        record.write(&sensor::TIME_BIAS, numbers);
    }
    if let Some(numbers) = known.range_m.and_then(|range_m| nearest(range, [0.0, range_m])) {
        record.write(range, numbers);
    }
    if let Some(numbers) = known
        .azimuth_rad
        .and_then(|azimuth_rad| nearest(azimuth, [azimuth_rad]))
    {
        record.write(azimuth, numbers);
    }
}
