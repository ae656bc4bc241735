//! Load for a live deployment: two sensors on loopback multicast, at a fixed rate, and what the gateway sends, kept.
//!
//! ```text
//! koseki up config/load.toml --for 80 --out records/load
//! cargo run --release -p koseki --example asterix_load -- 20000 60 records/load/gateway.ast
//! ```
//!
//! Arguments: records per second of both sensors together, seconds, the file for the gateway's blocks, and how many
//! times as many records there are in the second third of the time (1 if nothing is said; 10 or 100 is an overload).
//! Targets fly straight on in a grid; each is reported by both sensors in turn. Records are sent when they are due,
//! however late that is: a sender that is held up catches up, it does not leave out.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use anyhow::Context as _;
use asterix::{blocks, registry};
use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{Covariance, Identity, SensorTrack, TrackState, sensor_track_bits as bits};
use net::{Interface, ReceiverSettings, SenderSettings, UdpReceiver, UdpSender};
use outgoing::{HeightReference, SensorReports};

const TARGETS: u64 = 4_000;
const GRID: u64 = 64;
const SPACING_M: f64 = 3_000.0;
const TICK: Duration = Duration::from_millis(5);
/// How long to wait for what is still on its way in the end.
const AFTERMATH: Duration = Duration::from_secs(2);
const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let rate: f64 = arguments
        .next()
        .map_or(Ok(20_000.0), |text| text.parse())
        .context("records per second")?;
    let seconds: f64 = arguments
        .next()
        .map_or(Ok(60.0), |text| text.parse())
        .context("seconds")?;
    let file = arguments.next().unwrap_or_else(|| "gateway.ast".to_owned());
    let factor: f64 = arguments
        .next()
        .map_or(Ok(1.0), |text| text.parse())
        .context("factor")?;
    let mut sensors = [
        Sensor::new(48, 1, [239, 255, 48, 2], 8648)?,
        Sensor::new(20, 2, [239, 255, 20, 2], 8620)?,
    ];
    let mut picture = Picture::new(&file)?;

    let begun = Instant::now();
    let begun_utc_ns = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos() as i64;
    let third_s = seconds / 3.0;
    let due_by = |elapsed_s: f64| {
        let more_s = (factor - 1.0) * (elapsed_s - third_s).clamp(0.0, third_s);
        (rate * (elapsed_s.min(seconds) + more_s)) as u64
    };
    let all = due_by(seconds);
    let mut sent = 0;
    while sent < all {
        let elapsed = begun.elapsed();
        let due = due_by(elapsed.as_secs_f64());
        for record in sent..due {
            let sensor = &mut sensors[(record % 2) as usize];
            sensor.send(&track(record / 2 % TARGETS, begun_utc_ns, elapsed));
        }
        sent = due;
        sensors.iter_mut().for_each(Sensor::flush);
        let next = elapsed + TICK;
        picture.receive(next.saturating_sub(begun.elapsed()))?;
    }
    let took = begun.elapsed();
    let end = Instant::now() + AFTERMATH;
    while Instant::now() < end {
        picture.receive(TICK)?;
    }
    for (sensor, name) in sensors.iter().zip(["CAT048", "CAT020"]) {
        let (counts, sender) = (sensor.reports.counts(), sensor.sender.counters());
        println!(
            "sent {} records of {name} in {} datagrams, {} of them refused by the machine; {} tracks had no number",
            counts.records,
            sender.sent,
            sender.failed,
            counts.refused()
        );
    }
    println!(
        "that is {:.0} records a second over {:.1} s",
        sent as f64 / took.as_secs_f64(),
        took.as_secs_f64()
    );
    picture.finish(&file)
}

/// The state of a target: on a grid, in one of eight directions, at 100 m/s to and fro.
fn track(target: u64, begun_utc_ns: i64, elapsed: Duration) -> SensorTrack {
    let seconds = elapsed.as_secs_f64();
    let heading = (target % 8) as f64 * std::f64::consts::FRAC_PI_4;
    let velocity = [80.0 * heading.sin(), 80.0 * heading.cos()];
    let place = [target % GRID, target / GRID].map(|step| (step as f64 - GRID as f64 / 2.0) * SPACING_M);
    SensorTrack {
        time_of_measurement_ns: begun_utc_ns + elapsed.as_nanos() as i64,
        track_number: target as u32 + 1,
        valid: bits::VELOCITY | bits::HEIGHT,
        identity: Identity::default()
            .with_address(0x40_0000 + target as u32)
            .with_mode_3a((target % 4096) as u16),
        position_m: [
            place[0] + velocity[0] * seconds,
            place[1] + velocity[1] * seconds,
            5_000.0,
        ],
        velocity_mps: [velocity[0], velocity[1], 0.0],
        covariance: Covariance::diagonal([20.0; 3], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

/// A sensor on its multicast group.
struct Sensor {
    reports: SensorReports,
    sender: UdpSender,
}

impl Sensor {
    fn new(category: u8, sic: u8, group: [u8; 4], port: u16) -> anyhow::Result<Self> {
        let place = Geodetic::from_degrees(41.297063, 2.078447, 0.0)?;
        let system = SystemFrame::at(place);
        let frame = SensorFrame::new(&system, place, 0.0);
        let table = registry::default_edition(category).context("no such category")?;
        let settings = SenderSettings {
            interface: Some(Interface::Address(LOOPBACK)),
            ..SenderSettings::new(SocketAddr::from((group, port)))
        };
        Ok(Self {
            reports: SensorReports::new(table, 25, sic, frame, system, 1472)?.with_height(HeightReference::Barometric),
            sender: UdpSender::open(&settings)?,
        })
    }

    fn send(&mut self, track: &SensorTrack) {
        let sender = &mut self.sender;
        self.reports.report(track, &mut |datagram| drop(sender.send(datagram)));
    }

    fn flush(&mut self) {
        let sender = &mut self.sender;
        self.reports.flush(&mut |datagram| drop(sender.send(datagram)));
    }
}

/// What the gateway sends.
struct Picture {
    receiver: UdpReceiver,
    file: BufWriter<File>,
    blocks: u64,
}

impl Picture {
    fn new(file: &str) -> anyhow::Result<Self> {
        let settings = ReceiverSettings {
            interface: Some(Interface::Address(LOOPBACK)),
            ..ReceiverSettings::new(IpAddr::from([239, 255, 62, 2]), 8662)
        };
        Ok(Self {
            receiver: UdpReceiver::open(&settings)?,
            file: BufWriter::new(File::create(file).with_context(|| format!("making {file}"))?),
            blocks: 0,
        })
    }

    /// Takes what is there, and waits for it as long as `patience`.
    fn receive(&mut self, patience: Duration) -> anyhow::Result<()> {
        let end = Instant::now() + patience;
        loop {
            let (file, count) = (&mut self.file, &mut self.blocks);
            let mut written = Ok(());
            self.receiver
                .receive(end.saturating_duration_since(Instant::now()), |datagram| {
                    *count += blocks(datagram.bytes).count() as u64;
                    if written.is_ok() {
                        written = file.write_all(datagram.bytes);
                    }
                })?;
            written?;
            if Instant::now() >= end {
                return Ok(());
            }
        }
    }

    fn finish(mut self, file: &str) -> anyhow::Result<()> {
        self.file.flush()?;
        let counted = self.receiver.counters();
        println!(
            "received {} datagrams with {} blocks from the gateway, {} dropped by the kernel; kept in {file}",
            counted.datagrams, self.blocks, counted.kernel_drops
        );
        Ok(())
    }
}
