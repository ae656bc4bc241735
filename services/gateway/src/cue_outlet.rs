//! Cue outlet: search regions to a sensor controller (WA-12).
//!
//! Before its next look a steerable sensor needs the place of each target and the region to be searched. A controller
//! is no part of the deployment and reads no shared memory, so the cues leave as rows of text. Either datagrams contain
//! the rows, each with a header line; or controllers connect and receive lines. The rows are those of
//! `koseki track --cues`. Times are seconds since midnight (UTC) of the day of the scan after which the cue was made.
//!
//! An outlet is a subscriber like any other: cues are recorded from their topic, whether or not an outlet sends them.
//! A row that a controller cannot take is not repeated, since the next scan gives a newer one.

use std::time::Duration;

use bus::{Bus, BusError, Subscriber, Transport, WaitMode, Waiter};
use formats::cues_csv::CueRow;
use formats::rows::{Row, RowWriter};
use messages::{Counter, Cue, NS_PER_S};
use observations::sensor_id;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::cue_settings::CueOutletSettings;
use crate::outlet::Outlet;

/// Maximum number of slices taken in one turn.
const SLICES_PER_TURN: usize = 64;
/// Longest sleep, bounded by controllers that connect.
const SLEEP_MAX: Duration = Duration::from_millis(50);
const NS_PER_DAY: i64 = 86_400 * NS_PER_S as i64;

/// Outlet of a source's cues as an agent, generic over the transport: tests run it in process.
#[derive(Debug)]
pub(crate) struct CueOutlet<S: Transport> {
    subscriber: Subscriber<S, Cue>,
    waiter: Waiter<S>,
    outlet: Outlet,
    text: CueText,
    records: u64,
}

/// Rows that wait to be sent.
#[derive(Debug)]
struct CueText {
    header: Vec<u8>,
    /// Header and rows.
    rows: Vec<u8>,
    /// The row at hand.
    row: Vec<u8>,
    /// Largest size of `rows`.
    octets_max: usize,
}

impl CueText {
    fn new(octets_max: usize) -> Self {
        let header = format!("{}\n", CueRow::columns()).into_bytes();
        Self {
            rows: header.clone(),
            row: Vec::with_capacity(octets_max),
            header,
            octets_max,
        }
    }

    /// Adds a cue; gives the rows so far to `send` first if both have no room.
    fn add(&mut self, cue: &Cue, send: &mut impl FnMut(&[u8])) {
        let day_ns = cue.made_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        self.row.clear();
        let mut writer = RowWriter::resume(std::mem::take(&mut self.row), day_ns);
        // Writing to memory cannot fail.
        let _ = writer.write(&CueRow {
            sensor_id: sensor_id(cue.source),
            cue: *cue,
        });
        self.row = writer.into_inner();
        if self.rows.len() + self.row.len() > self.octets_max {
            self.flush(send);
        }
        self.rows.extend_from_slice(&self.row);
    }

    /// Gives the rows to `send`, if there are any.
    fn flush(&mut self, send: &mut impl FnMut(&[u8])) {
        if self.rows.len() > self.header.len() {
            send(&self.rows);
        }
        self.rows.truncate(self.header.len());
    }
}

impl<S: Transport> CueOutlet<S> {
    /// Opens the outlet on `bus`; `incarnation` is the process's monotonic start time, nanoseconds.
    ///
    /// # Errors
    /// If the socket or the topic cannot be opened.
    pub(crate) fn new(settings: &CueOutletSettings, bus: &Bus<S>, incarnation: u64) -> anyhow::Result<Self> {
        let topic = messages::cues(&settings.source);
        let mut waiter = bus.waiter(WaitMode::Event);
        waiter.watch(bus, &topic)?;
        Ok(Self {
            subscriber: bus.subscriber(&topic, || incarnation)?,
            waiter,
            outlet: Outlet::open(&settings.way()?)?,
            text: CueText::new(settings.block_bytes),
            records: 0,
        })
    }

    /// Sends the published cues. Returns whether more slices may be waiting.
    fn send(&mut self) -> Result<bool, BusError> {
        let Self {
            subscriber,
            outlet,
            text,
            records,
            ..
        } = self;
        let header = text.header.len();
        // A controller that connects gets the header first, a datagram has its own.
        let first = if matches!(outlet, Outlet::Lines(_)) { header } else { 0 };
        let mut send = |rows: &[u8]| outlet.send(&rows[first..]);
        let slices = subscriber.take(SLICES_PER_TURN, |_, cues| {
            for cue in cues {
                *records += 1;
                text.add(cue, &mut send);
            }
        })?;
        text.flush(&mut send);
        Ok(slices == SLICES_PER_TURN)
    }
}

impl<S: Transport> Agent for CueOutlet<S> {
    fn turn(&mut self, _now: Now) -> anyhow::Result<Turn> {
        self.outlet.accept_with(&self.text.header)?;
        Ok(match self.send()? {
            true => Turn::Worked,
            false => Turn::Idle(SLEEP_MAX),
        })
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let subscriber = &self.subscriber;
        self.waiter.wait(at_most, || subscriber.has_slices())?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        let taken = self.subscriber.counts();
        entry.set(Counter::Taken, taken.taken);
        entry.set(Counter::Lost, taken.lost);
        entry.set(Counter::RejectedSchema, taken.schema_mismatch);
        entry.set(Counter::RejectedEpoch, taken.of_older_epochs);
        entry.set(Counter::RecordsSent, self.records);
        self.outlet.count(&mut entry);
        entries.push(entry);
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead as _, BufReader};
    use std::net::{TcpStream, UdpSocket};

    use bus::{InProcess, Mark, Publisher, Root, TopicHold};
    use tempfile::TempDir;
    use test_support::S;

    use super::*;
    use crate::destination::Destination;

    /// An outlet on a bus of its own.
    struct Bench {
        outlet: CueOutlet<InProcess>,
        cues: Publisher<InProcess, Cue>,
        _held: TopicHold,
        _bus: Bus<InProcess>,
        _folder: TempDir,
    }

    impl Bench {
        fn new(settings: CueOutletSettings) -> Self {
            let settings = CueOutletSettings {
                source: "radar".to_owned(),
                ..settings
            };
            let folder = tempfile::tempdir().unwrap();
            let root = Root::in_base(folder.path(), "test").unwrap();
            let bus: Bus<InProcess> = Bus::open(&root, "test").unwrap();
            let held = bus.hold(&messages::cues("radar")).unwrap();
            let cues = bus.publisher(&messages::cues("radar"), 1).unwrap();
            Self {
                _held: held,
                outlet: CueOutlet::new(&settings, &bus, 1).unwrap(),
                cues,
                _bus: bus,
                _folder: folder,
            }
        }

        fn publish(&mut self, tracks: std::ops::Range<u32>) {
            let mark = Mark {
                progress_ns: i64::MIN,
                sent_ns: 0,
                end: false,
            };
            let count = tracks.len();
            self.cues
                .send(mark, count, |index, sequence| Cue {
                    sequence,
                    ..cue(tracks.start + index as u32)
                })
                .unwrap();
        }

        fn turn(&mut self) {
            let now = Now { mono_ns: 0, utc_ns: 0 };
            while matches!(self.outlet.turn(now).unwrap(), Turn::Worked) {}
        }
    }

    /// A cue of the second source, made a second before midnight for a look after it.
    fn cue(track_number: u32) -> Cue {
        Cue {
            made_ns: 3 * NS_PER_DAY - S,
            time_ns: 3 * NS_PER_DAY + 3 * S,
            position_m: [1.0, -2.5, 0.0],
            half_axes_m: [300.0, 100.0],
            orientation_rad: 0.5,
            track_number,
            source: 1,
            ..Cue::default()
        }
    }

    const HEADER: &str = "made_s,time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,longer_m,shorter_m,orientation_rad";
    const ROW: &str = ",1.000,-2.500,0.000,0.000,0.000,0.000,300.000,100.000,0.500000";

    #[test]
    fn rows_go_out_in_datagrams_that_each_have_a_header() {
        let controller = UdpSocket::bind("127.0.0.1:0").unwrap();
        controller.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let mut bench = Bench::new(CueOutletSettings {
            send_to: Some(Destination(controller.local_addr().unwrap())),
            block_bytes: 300,
            ..CueOutletSettings::default()
        });
        bench.turn();
        bench.publish(7..12);
        bench.turn();
        let (mut rows, mut octets) = (Vec::new(), [0; 2000]);
        while rows.len() < 5 {
            let length = controller.recv(&mut octets).unwrap();
            assert!(length <= 300, "{length}");
            let text = std::str::from_utf8(&octets[..length]).unwrap();
            let (header, own) = text.split_once('\n').unwrap();
            assert_eq!(header, HEADER);
            rows.extend(own.lines().map(str::to_owned));
        }
        let expected = (7..12).map(|track| format!("86399,86403,2,{track}{ROW}"));
        assert_eq!(rows, expected.collect::<Vec<_>>());
        let mut entries = Vec::new();
        bench.outlet.health(&mut entries);
        assert_eq!(entries[0].counters[Counter::RecordsSent], 5);
        assert!(entries[0].counters[Counter::DatagramsSent] >= 3);
    }

    #[test]
    fn controllers_that_connect_get_a_header_and_the_following_rows() {
        let mut bench = Bench::new(CueOutletSettings {
            listen: Some(Destination(([127, 0, 0, 1], 0).into())),
            ..CueOutletSettings::default()
        });
        bench.publish(1..2);
        bench.turn();
        let address = bench.outlet.outlet.listening_at().unwrap();
        let mut controllers = [(); 2].map(|()| BufReader::new(TcpStream::connect(address).unwrap()));
        bench.turn();
        bench.publish(2..4);
        bench.turn();
        for controller in &mut controllers {
            let mut line = || {
                let mut line = String::new();
                controller.read_line(&mut line).unwrap();
                line.trim_end().to_owned()
            };
            assert_eq!(line(), HEADER);
            assert_eq!(
                [line(), line()],
                [2, 3].map(|track| format!("86399,86403,2,{track}{ROW}"))
            );
        }
    }
}
