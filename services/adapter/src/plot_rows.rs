//! Rows of detections in datagrams (FM-6), and the sensors of tracker processes behind the socket.
//!
//! Each datagram is a separate table. Rows name the sensor, so several sensors may send to a single socket; a row of a
//! sensor that no configuration names is counted, and a row that names none is of the only sensor. An unreadable row
//! names no sensor: such a row belongs to the only sensor, or to the socket. A row of the kind `none` states a scan
//! without detections.

use anyhow::Context as _;
use deployment::SampleDelivery;
use formats::plane::Plane;
use formats::scan_rows_csv::{ScanRow, ScanRowReader};
use messages::{Counter, Counters};
use observations::SensorEvent;
use runtime::Process;
use runtime::{HealthEntry, Now};

use crate::Processed;
use crate::channel::SourceChannel;
use crate::receiver::{DatagramReader, ReceiptTime};
use crate::tables::{TableCounts, utc_ns};

/// Reader of tables of detections.
#[derive(Debug)]
pub(crate) struct PlotRows {
    /// Each with the sensor's number in rows; `None` takes all rows.
    channels: Vec<(Option<u32>, SourceChannel)>,
    /// The plane of the deployment.
    plane: Plane,
    tables: TableCounts,
    /// Rows of unknown sensors.
    strangers: u64,
}

impl PlotRows {
    pub(crate) fn new(process: &Process, sources: &[Processed<'_>]) -> anyhow::Result<Self> {
        let channel = |processed: &Processed<'_>| match processed.source.delivers {
            SampleDelivery::Plots { sensor_id, .. } => Ok((sensor_id, SourceChannel::open(process, *processed)?)),
            _ => anyhow::bail!("source {} takes no rows of detections", processed.source.name),
        };
        let channels: Vec<_> = sources.iter().map(channel).collect::<anyhow::Result<_>>()?;
        channels.first().context("no sensor is behind this receiver")?;
        Ok(Self {
            channels,
            plane: Plane::Given(process.config.frame),
            tables: TableCounts::default(),
            strangers: 0,
        })
    }

    /// Counts the lines of the next table, which continues an earlier table, from `lines`.
    pub(crate) fn after_lines(&mut self, lines: u64) {
        self.tables.after_lines(lines);
    }
}

/// Event that a row states at a time of the day, with the sensor's number.
pub(crate) fn event_of(row: ScanRow, utc_ns: impl Fn(i64) -> i64) -> (u32, SensorEvent) {
    match row {
        ScanRow::Detection(mut detection) => {
            detection.time_of_measurement_ns = utc_ns(detection.time_of_measurement_ns);
            (detection.sensor_id, SensorEvent::Detection(detection))
        }
        ScanRow::Empty(scan) => {
            let event = SensorEvent::EmptyScan {
                number: scan.scan,
                time_ns: utc_ns(scan.time_ns),
            };
            (scan.sensor_id, event)
        }
    }
}

impl DatagramReader for PlotRows {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        for (_, channel) in &mut self.channels {
            channel.received(received)?;
        }
        let mut stranger = None;
        let (plane, only) = (self.plane, self.channels[0].0.filter(|_| self.channels.len() == 1));
        let open = |bytes, first_day_ns| {
            let mut reader = ScanRowReader::with_scans(bytes, first_day_ns)?.placed_in(plane);
            reader.set_sensor(only.unwrap_or(1));
            Ok(reader)
        };
        for row in self.tables.rows(bytes, received, open) {
            let (sensor_id, event) = event_of(row, |time_ns| utc_ns(received.utc_ns, time_ns));
            let of_sensor = |(id, _): &&mut (Option<u32>, SourceChannel)| id.is_none_or(|id| id == sensor_id);
            match self.channels.iter_mut().find(of_sensor) {
                Some((_, channel)) => channel.row(&event, received.mono_ns)?,
                None => {
                    self.strangers += 1;
                    stranger = Some(sensor_id);
                }
            }
        }
        if let Some(sensor_id) = stranger {
            let words = format!("sensor_id {sensor_id} is that of no source; write it into `sensor_id` of its source");
            self.tables.note(("sensor_id", ""), received, words);
        }
        Ok(())
    }

    fn publish(&mut self, _count: usize, _now: Now) -> anyhow::Result<()> {
        self.channels.iter_mut().try_for_each(|(_, channel)| channel.publish())
    }

    fn health(&self, whole: &mut HealthEntry, sources: &mut Vec<HealthEntry>) {
        sources.extend(
            self.channels
                .iter()
                .map(|(_, channel)| channel.health(&Counters::default())),
        );
        match &mut sources[..] {
            [only] => self.tables.count(only),
            _ => self.tables.count(whole),
        }
        whole.set(Counter::RejectedSource, self.strangers);
    }
}
