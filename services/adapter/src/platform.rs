//! Platforms: the process that receives the states of a ship or vehicle, and publishes these states (EL-11).
//!
//! The bytes are sentences of NMEA 0183 or, in datagrams, tables of states. Each sentence becomes a state with the
//! sentence's values, at once: readers put position and attitude together by time, so nothing waits here. A state far
//! from all motion is published like any other, and counted for the alarm.

use std::fs::File;
use std::io::Read as _;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::PathBuf;
use std::time::Duration;

use bus::{Mark, Publisher, SharedMemory};
use deployment::{Platform, PlatformFeed, PlatformInput, ReceiverTransport};
use formats::nmea::{NmeaReader, NmeaSettings};
use formats::platform_states_csv::PlatformStateReader;
use messages::{Counter, PlatformState, StageTimes};
use net::{LinesSettings, TcpLines};
use platform::{JumpWatch, Navigator, State};
use runtime::Process;
use runtime::clock::mono_ns;
use runtime::{Agent, HealthEntry, Now, Turn};
use sources::PlatformReading;

use crate::receiver::{DatagramAgent, DatagramReader, ReceiptTime};
use crate::tables::{TableCounts, utc_ns};

/// Longest wait for a line in a turn, bounded by health messages and stop requests.
const PATIENCE: Duration = Duration::from_millis(50);
/// Time between two looks at a device.
const DEVICE_PAUSE: Duration = Duration::from_millis(5);
/// Bytes taken from a device in a turn.
const DEVICE_OCTETS: usize = 4096;
/// Time between two attempts to open a device, nanoseconds.
const REOPEN_NS: i64 = 1_000_000_000;
/// Distance from the origin of the system frame beyond which the plane of the frame distorts, metres.
pub(crate) const FAR_M: f64 = 300e3;
/// Maximum number of states in a turn; a further state begins the next slice.
const STATES_MAX: usize = 1024;

/// The agent of a platform's process.
///
/// # Errors
/// If the input cannot be opened, or shared memory fails.
pub(crate) fn agent(
    process: &Process,
    (platform, reading): (&Platform, &PlatformReading),
) -> anyhow::Result<Box<dyn Agent>> {
    let states = PlatformStates::new(process, platform, reading)?;
    Ok(match &platform.input {
        PlatformInput::Live(PlatformFeed::Udp(settings)) => Box::new(DatagramAgent::open(
            process,
            &ReceiverTransport::Udp(settings.clone()),
            states,
        )?),
        PlatformInput::Live(PlatformFeed::Loopback(port)) => Box::new(DatagramAgent::open(
            process,
            &ReceiverTransport::Loopback { port: *port },
            states,
        )?),
        PlatformInput::Live(PlatformFeed::Tcp(server)) => Box::new(StreamAgent {
            stream: Stream::Tcp(Box::new(TcpLines::new(LinesSettings::new(*server))?)),
            what: server.to_string(),
            states,
        }),
        PlatformInput::Live(PlatformFeed::Device(path)) => Box::new(StreamAgent {
            stream: Stream::Device(Device {
                path: path.clone(),
                file: None,
                tried_ns: i64::MIN,
                opened: 0,
            }),
            what: path.display().to_string(),
            states,
        }),
        PlatformInput::Recorded(_) | PlatformInput::External => {
            anyhow::bail!("platform {} is received by no process", platform.name)
        }
    })
}

/// Bytes to published states.
#[derive(Debug)]
struct PlatformStates {
    sentences: NmeaReader,
    navigator: Navigator,
    tables: TableCounts,
    jumps: JumpWatch,
    jumped: u64,
    silent_after_ns: i64,
    range_m: f64,
    /// States beyond that range.
    too_far: u64,
    /// Distance of the latest position from the frame's origin, metres.
    distance_m: f64,
    /// Monotonic time of the latest state, or of the start, nanoseconds.
    came_ns: i64,
    /// Time of the latest state, UTC, nanoseconds.
    progress_ns: i64,
    publisher: Publisher<SharedMemory, PlatformState>,
    states: Vec<(State, i64)>,
}

impl PlatformStates {
    fn new(process: &Process, platform: &Platform, reading: &PlatformReading) -> anyhow::Result<Self> {
        let topic = messages::platform_states(&platform.name);
        Ok(Self {
            sentences: NmeaReader::new(NmeaSettings {
                receipt_sigma_s: platform.receipt_sigma_s,
                heading_sigma_rad: reading.assumed.heading_sigma_deg.rad(),
            }),
            navigator: Navigator::new(process.config.frame),
            tables: TableCounts::default(),
            jumps: JumpWatch::new(reading.jumps, reading.assumed.max_gap_s.ns()),
            jumped: 0,
            silent_after_ns: platform.silent_after_ns,
            range_m: platform.range_m,
            too_far: 0,
            distance_m: 0.0,
            came_ns: mono_ns(),
            progress_ns: i64::MIN,
            publisher: process.bus.publisher(&topic, process.incarnation)?,
            states: Vec::with_capacity(STATES_MAX),
        })
    }

    /// Takes sentences; `is_whole` if none may go on in the next bytes.
    fn sentences(&mut self, bytes: &[u8], is_whole: bool, received: ReceiptTime) {
        let before = self.sentences.counts().refused();
        let (navigator, states) = (&mut self.navigator, &mut self.states);
        let mut each = |navigation| states.push((navigator.state(&navigation), received.mono_ns));
        self.sentences.take(bytes, Some(received.utc_ns), &mut each);
        if is_whole {
            self.sentences.end(Some(received.utc_ns), &mut each);
        }
        let refused = self.sentences.refused();
        if let Some(refused) = refused.filter(|_| self.sentences.counts().refused() > before) {
            self.tables.note((refused.fault.sentence(), ""), received, refused);
        }
        self.judge(received);
    }

    fn rows(&mut self, bytes: &[u8], received: ReceiptTime) {
        for row in self.tables.rows(bytes, received, PlatformStateReader::new) {
            let state = State::of_sample(&PlatformState {
                time_ns: utc_ns(received.utc_ns, row.time_ns),
                ..row
            });
            self.states.push((state, received.mono_ns));
        }
        self.judge(received);
    }

    /// Leaves out states beyond the range.
    fn judge(&mut self, received: ReceiptTime) {
        let before = self.too_far;
        let (range_m, too_far, distance_m) = (self.range_m, &mut self.too_far, &mut self.distance_m);
        self.states.retain(|(state, _)| {
            let Some([east, north, up]) = state.position_m else {
                return true;
            };
            // The other side of the earth is below the origin, and near the origin on the plane.
            *distance_m = east.hypot(north).hypot(up);
            *too_far += u64::from(*distance_m > range_m);
            *distance_m <= range_m
        });
        if self.too_far > before {
            let [distance_km, range_km] = [self.distance_m, range_m].map(|metres| metres / 1e3);
            let words = format!(
                "the place is {distance_km:.0} km from the frame's origin; at most range_m of the platform, \
                 {range_km:.0} km: correct the sender, or raise it"
            );
            self.tables.note(("position", ""), received, words);
        }
    }

    fn send(&mut self) -> anyhow::Result<()> {
        let Some((_, came_ns)) = self.states.last() else {
            return Ok(());
        };
        self.came_ns = *came_ns;
        for (state, _) in &self.states {
            self.jumped += u64::from(self.jumps.take(state).is_some());
            self.progress_ns = self.progress_ns.max(state.time_ns);
        }
        for states in self.states.chunks(STATES_MAX) {
            let mark = Mark {
                progress_ns: self.progress_ns,
                sent_ns: mono_ns(),
                end: false,
            };
            self.publisher.send(mark, states.len(), |index, sequence| {
                let (state, ingested_ns) = &states[index];
                let stages = StageTimes {
                    ingested_ns: *ingested_ns,
                    published_ns: mark.sent_ns,
                    ..StageTimes::default()
                };
                PlatformState {
                    sequence,
                    ..state.sample(messages::NO_SOURCE, stages)
                }
            })?;
        }
        self.states.clear();
        Ok(())
    }

    fn count(&self, whole: &mut HealthEntry) {
        let counts = self.sentences.counts();
        self.tables.count(whole);
        whole.counters[Counter::Records] += counts.used + counts.other + counts.refused();
        whole.counters[Counter::BlocksRejected] += counts.no_sentence + counts.field;
        whole.counters[Counter::RejectedTime] += counts.no_date;
        whole.set(Counter::SentencesPartial, counts.partial + counts.too_long);
        whole.set(Counter::SentencesChecksum, counts.checksum);
        whole.set(Counter::SentencesTalker, counts.talker);
        whole.set(Counter::SentencesWithoutFix, counts.no_fix);
        whole.set(Counter::SentencesOther, counts.other);
        whole.set(Counter::PlatformJumps, self.jumped);
        whole.set(Counter::RejectedPosition, self.too_far);
        if self.distance_m > FAR_M {
            whole.set(Counter::PlatformFarKm, (self.distance_m / 1e3) as u64);
        }
        whole.set(Counter::Published, self.publisher.counts().samples);
        whole.progress_ns = self.progress_ns;
        let silent_ns = mono_ns().saturating_sub(self.came_ns);
        if silent_ns > self.silent_after_ns {
            whole.set(Counter::PlatformSilentMs, (silent_ns / 1_000_000) as u64);
        }
    }
}

impl DatagramReader for PlatformStates {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        // Sentences begin with a sign, a table with the name of a column.
        match bytes.first() {
            Some(first) if first.is_ascii_lowercase() => self.rows(bytes, received),
            _ => self.sentences(bytes, true, received),
        }
        Ok(())
    }

    fn publish(&mut self, _count: usize, _now: Now) -> anyhow::Result<()> {
        self.send()
    }

    fn health(&self, whole: &mut HealthEntry, _sources: &mut Vec<HealthEntry>) {
        self.count(whole);
    }
}

/// A stream of sentences.
#[derive(Debug)]
enum Stream {
    Tcp(Box<TcpLines>),
    Device(Device),
}

/// A device that is read without waiting, and opened again after being unplugged.
#[derive(Debug)]
struct Device {
    path: PathBuf,
    file: Option<File>,
    tried_ns: i64,
    opened: u64,
}

/// Agent of a platform behind a connection or a device.
#[derive(Debug)]
struct StreamAgent {
    stream: Stream,
    what: String,
    states: PlatformStates,
}

impl Device {
    /// Reads the available bytes; none if the device is absent or silent.
    fn read(&mut self, buffer: &mut [u8], now: Now) -> usize {
        if self.file.is_none() && now.mono_ns.saturating_sub(self.tried_ns) >= REOPEN_NS {
            self.tried_ns = now.mono_ns;
            let mut options = File::options();
            options
                .read(true)
                .custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
            self.file = options.open(&self.path).ok();
            self.opened += u64::from(self.file.is_some());
        }
        let Some(file) = &mut self.file else { return 0 };
        match file.read(buffer) {
            // A file may grow, but a device that was unplugged reads as an end for ever.
            Ok(0) => {
                if self.is_gone() {
                    self.file = None;
                }
                0
            }
            Ok(length) => length,
            Err(error)
                if matches!(
                    error.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::Interrupted
                ) =>
            {
                0
            }
            Err(_) => {
                self.file = None;
                0
            }
        }
    }
}

impl Device {
    /// Whether the path is no longer that of the open file.
    fn is_gone(&self) -> bool {
        let id = |found: std::fs::Metadata| (found.dev(), found.ino());
        let open = self.file.as_ref().and_then(|file| file.metadata().ok()).map(id);
        open != std::fs::metadata(&self.path).ok().map(id)
    }
}

impl Agent for StreamAgent {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let received = |utc_ns, mono_ns| ReceiptTime {
            utc_ns,
            mono_ns,
            steady_ns: utc_ns,
        };
        let states = &mut self.states;
        let turn = match &mut self.stream {
            Stream::Tcp(client) => {
                client.poll(now.mono_ns, PATIENCE, |line| {
                    let read = Now::read();
                    states.sentences(line, true, received(read.utc_ns, read.mono_ns));
                });
                Turn::Worked
            }
            Stream::Device(device) => {
                let mut buffer = [0; DEVICE_OCTETS];
                let length = device.read(&mut buffer, now);
                states.sentences(&buffer[..length], false, received(now.utc_ns, now.mono_ns));
                match length {
                    0 => Turn::Idle(DEVICE_PAUSE),
                    _ => Turn::Worked,
                }
            }
        };
        states.send()?;
        Ok(turn)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut whole = HealthEntry::default();
        self.states.count(&mut whole);
        match &self.stream {
            Stream::Tcp(client) => {
                whole.set(Counter::Connections, client.counters().connections);
                if !client.is_connected() {
                    whole.note = format!("not connected to {}", self.what);
                }
            }
            Stream::Device(device) => {
                whole.set(Counter::Connections, device.opened);
                if device.file.is_none() {
                    whole.note = format!("{} cannot be opened", self.what);
                }
            }
        }
        entries.push(whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_was_unplugged_is_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        std::fs::write(&path, "first").unwrap();
        let mut device = Device {
            path: path.clone(),
            file: None,
            tried_ns: i64::MIN,
            opened: 0,
        };
        let mut read_at = |second: i64| {
            let mut buffer = [0; 64];
            let now = Now {
                utc_ns: 0,
                mono_ns: second * REOPEN_NS,
            };
            let length = device.read(&mut buffer, now);
            String::from_utf8_lossy(&buffer[..length]).into_owned()
        };
        assert_eq!([read_at(1), read_at(2)], ["first", ""]);
        std::fs::remove_file(&path).unwrap();
        assert_eq!([read_at(3), read_at(4)], ["", ""]);
        std::fs::write(&path, "again").unwrap();
        assert_eq!(read_at(6), "again");
    }
}
