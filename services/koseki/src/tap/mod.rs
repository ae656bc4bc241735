//! `koseki tap`: samples as lines of text or as ASTERIX, for programs that map no shared memory (FM-14).
//!
//! A tap is a normal reader: it delays no process, and reports its own losses.

mod blocks;

use std::io::{self, Write};
use std::time::Duration;

use anyhow::bail;
use bus::{Bus, Payload, ReceiveOutcome, Root, SharedMemory, WaitMode, Woken};
use messages::{Topic, Visitor};
use net::{LineServer, Reach};
use offline::Usage;
use runtime::clock::{instant, mono_ns};
use runtime::signals::Stop;
use sample_text::{LineFormat, LineWriter, SampleNames};

use crate::args::{Tap, TapFormat, TapSocket};
use crate::config::Config;
use crate::instances;
use blocks::TapBlocks;

/// Longest wait between two checks for connections or the deployment's end.
const LOOK: Duration = Duration::from_millis(100);
/// Bytes collected before being handed on, if more samples wait.
const BLOCK: usize = 1 << 16;

/// Writes samples as lines, until the deployment ends.
///
/// # Errors
/// If the instance does not run, has no such topic, or the lines cannot be handed on.
pub(crate) fn run(tap: &Tap) -> anyhow::Result<()> {
    let unknown = || Usage(format!("\"{}\" is no topic: see koseki tap --help", tap.topic()));
    messages::visit(tap.topic(), TapReader { tap }).ok_or_else(unknown)?
}

/// Output form of samples.
enum SampleForm {
    Lines(LineWriter),
    Blocks(Box<TapBlocks>),
}

impl SampleForm {
    fn head(&self) -> Vec<u8> {
        match self {
            Self::Lines(lines) => lines.head(),
            Self::Blocks(_) => Vec::new(),
        }
    }

    fn write(&mut self, sample: &[u8], octets: &mut Vec<u8>) {
        match self {
            Self::Lines(lines) => lines.write(sample, octets),
            Self::Blocks(blocks) => blocks.write(sample, octets),
        }
    }

    /// Appends the unfinished output, at the end of the samples.
    fn flush(&mut self, octets: &mut Vec<u8>) {
        if let Self::Blocks(blocks) = self {
            blocks.flush(octets);
        }
    }
}

/// Destination of the lines.
enum LineDestination {
    Out(io::StdoutLock<'static>),
    Server(Box<LineServer>),
}

impl LineDestination {
    fn open(tap: &Tap) -> anyhow::Result<Self> {
        let opened = match tap.socket() {
            Some(TapSocket::Unix(path)) => LineServer::open_unix(&path, tap.mode, tap.group),
            Some(TapSocket::Tcp(address)) => LineServer::open(address, reach_of(tap)),
            None => return Ok(Self::Out(io::stdout().lock())),
        };
        let server = opened.map_err(|error| Usage(format!("{error}; choose another")))?;
        Ok(Self::Server(Box::new(server)))
    }

    /// Sends `octets`. Later clients receive `head` first.
    fn send(&mut self, octets: &[u8], head: &[u8]) -> io::Result<()> {
        match self {
            Self::Out(out) => out.write_all(octets).and_then(|()| out.flush()),
            Self::Server(server) => {
                if !octets.is_empty() {
                    server.send(octets);
                }
                server.accept_with(head)?;
                if let Some(counters) = server.news(mono_ns()) {
                    eprintln!("koseki tap: readers refused or disconnected: {counters}");
                }
                Ok(())
            }
        }
    }
}

/// Returns the readers admitted at an address.
fn reach_of(tap: &Tap) -> Reach {
    Reach::permitted(tap.remote, "--remote")
}

/// Returns the names of a running instance.
///
/// # Errors
/// If the deployment's configuration cannot be read.
fn names_of(root: &Root) -> anyhow::Result<SampleNames> {
    let config = Config::of_running(root.path())?;
    let sources = config.sources.iter().map(|source| source.name.clone());
    Ok(SampleNames::new(sources.collect(), config.frame))
}

struct TapReader<'a> {
    tap: &'a Tap,
}

impl Visitor for TapReader<'_> {
    type Output = anyhow::Result<()>;

    fn visit<T: Payload>(self, topic: Topic<T>) -> anyhow::Result<()> {
        if self.tap.schema {
            let schema = sample_text::json_schema(&T::LAYOUT, !self.tap.raw);
            println!("{schema:#}");
            return Ok(());
        }
        if let Some(TapSocket::Tcp(address)) = self.tap.socket() {
            reach_of(self.tap).check(address).map_err(Usage)?;
        }
        let root = instances::running_or_only(self.tap.instance.as_deref())?;
        let stop = Stop::on_signals()?;
        let bus = Bus::<SharedMemory>::open(&root, "tap")?;
        let mut form = match self.tap.format() {
            TapFormat::Json | TapFormat::Csv => {
                let format = match self.tap.format() {
                    TapFormat::Csv => LineFormat::Csv,
                    _ => LineFormat::Json,
                };
                let names = (!self.tap.raw).then(|| names_of(&root)).transpose()?;
                SampleForm::Lines(LineWriter::new(&T::LAYOUT, format, names))
            }
            TapFormat::Cat062 => match TapBlocks::open(self.tap, &bus, &stop)? {
                Some(blocks) => SampleForm::Blocks(Box::new(blocks)),
                None => return Ok(()),
            },
        };
        let head = form.head();
        let mut subscriber = bus.subscriber(&topic, || mono_ns() as u64)?;
        let mut waiter = bus.waiter(WaitMode::Event);
        waiter.watch(&bus, &topic)?;
        let mut way = LineDestination::open(self.tap)?;
        if let LineDestination::Out(out) = &mut way {
            out.write_all(&head)?;
        }
        let (mut text, mut left, mut lost) = (Vec::new(), self.tap.count.unwrap_or(u64::MAX), 0);
        let mut looked = instant();
        while left > 0 && !stop.requested() {
            let slice = match subscriber.receive()? {
                ReceiveOutcome::Slice(slice) => Some(slice),
                ReceiveOutcome::Rejected => bail!("topic {}: its publisher is of another build", subscriber.topic()),
                ReceiveOutcome::OfOlderEpoch => continue,
                ReceiveOutcome::Nothing => None,
            };
            for sample in slice.iter().flat_map(|slice| slice.samples()).take(left as usize) {
                form.write(T::octets(std::slice::from_ref(sample)), &mut text);
                left -= 1;
            }
            let counts = subscriber.counts();
            if counts.lost > lost {
                eprintln!("koseki tap: too slow: {} samples lost", counts.lost - lost);
                lost = counts.lost;
            }
            if slice.is_some() && text.len() < BLOCK && left > 0 && subscriber.has_slices() {
                continue;
            }
            form.flush(&mut text);
            if let Err(error) = way.send(&text, &head) {
                // The reader has ended.
                return match error.kind() {
                    io::ErrorKind::BrokenPipe => Ok(()),
                    _ => Err(error.into()),
                };
            }
            text.clear();
            let waited = left > 0 && waiter.wait(LOOK, || subscriber.has_slices())? == Woken::Timeout;
            if waited && instant() - looked > LOOK {
                looked = instant();
                if !bus.goes_on()? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}
