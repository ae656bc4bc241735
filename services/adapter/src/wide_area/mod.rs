//! Wide-area sensors: the reports come in, are checked, and are published for the listening trackers (WA-2).
//!
//! A report is a count, not a track, and therefore passes neither a pipeline nor fusion. Live data are read from
//! datagrams ([`live`]), as rows of counts ([`rows`]) or as another system's tracks to be counted ([`tracks`]). A
//! recording is read as a whole ([`recorded`]) and published in the order of arrivals, for the recorder and other
//! readers.
//!
//! A tracker of a recorded source does not wait for publications: the tracker reads the recording itself, so that the
//! tracks do not depend on the faster process. A tracker of a live source takes the published reports
//! ([`SourceChannel`](crate::channel::SourceChannel)).

mod live;
pub(crate) mod recorded;
mod rows;
mod tracks;

use anyhow::Context as _;
use deployment::WideAreaSensor;
use messages::{Counter, Counters, Stream, StreamId};
use reception::ConversionModel;
use runtime::Agent;
use runtime::Process;
use sources::Readings;
use tracking::wide_area::{ReportRejection, WideAreaReport, fault_in};

use self::live::LiveCounts;
use crate::receiver::DatagramAgent;
use crate::replay::{Published, ReplayAgent};

/// The agent of a wide-area sensor.
///
/// # Errors
/// If the input cannot be read, or shared memory fails.
pub(crate) fn agent(process: &Process, sensor: &WideAreaSensor, readings: &Readings) -> anyhow::Result<Box<dyn Agent>> {
    if sensor.recording().is_some() {
        let recording = recorded::read((sensor, readings), &process.options.data, process.first_day_ns())?;
        let published = Published {
            topic: &messages::wide_area(&sensor.name),
            stream: StreamId {
                stream: Stream::WideArea,
                number: sensor.number,
            },
            sensor_uid: None,
        };
        return Ok(Box::new(ReplayAgent::new(
            process,
            recording,
            published.open(process, &[])?,
            None,
            None,
        )?));
    }
    let receiver = sensor.receiver().and_then(|name| process.config.receiver(name));
    let receiver = receiver.with_context(|| format!("wide-area sensor {} is behind no receiver", sensor.name))?;
    let live = LiveCounts::new(process, sensor, readings)?;
    Ok(Box::new(DatagramAgent::open(process, &receiver.transport, live)?))
}

/// Model of the tracks that a wide-area sensor counts.
fn model(sensor: &WideAreaSensor, readings: &Readings) -> anyhow::Result<ConversionModel> {
    let model = readings.counted[usize::from(sensor.number)];
    model.with_context(|| format!("wide-area sensor {} counts no tracks", sensor.name))
}

/// Reports that a check has rejected, by reason.
#[derive(Clone, Copy, Debug, Default)]
struct RejectedReports {
    place: u64,
    time: u64,
    targets: u64,
}

impl RejectedReports {
    /// Whether a report is plausible; counts the reason otherwise.
    fn passes(&mut self, report: &WideAreaReport) -> bool {
        match fault_in(report) {
            None => return true,
            Some(ReportRejection::NoPlace) => self.place += 1,
            Some(ReportRejection::TooManyTargets(_)) => self.targets += 1,
            Some(_) => self.time += 1,
        }
        false
    }

    fn count(&self, counters: &mut Counters) {
        counters[Counter::RejectedPosition] += self.place;
        counters[Counter::RejectedTime] += self.time;
        counters[Counter::RejectedTargets] += self.targets;
    }
}
