//! The fed sources of a deployment, and the conversion of lines to samples.

use std::collections::BTreeMap;
use std::time::Duration;

use bus::Root;
use deployment::Input;
use frames::SystemFrame;
use koseki_client::observation::{Observation as _, Scans, fault, missing};
use koseki_client::refusals::{self, Refused};
use koseki_client::{Error, ErrorKind, Publisher};
use messages::admission::{self, Admission, Fault};
use messages::{Outgoing, SensorDetection, SensorTrack};

use super::fields::Fields;
use super::samples;
use super::tapped::TappedLines;
use crate::config::Config;

/// Maximum number of samples collected before publishing.
const GATHERED_MAX: usize = 64;

/// Shortest time between two reports of refusals to the deployment, nanoseconds.
const REPORT_NS: i64 = 500_000_000;

/// Refused lines, by the place of the source (`None`: unknown) and the reason, which mostly is the name of a field.
#[derive(Debug, Default)]
struct Refusals {
    by_reason: BTreeMap<(Option<usize>, String), RefusedLines>,
    /// Monotonic time of the latest report, nanoseconds.
    reported_ns: i64,
}

#[derive(Debug, Default)]
struct RefusedLines {
    count: u64,
    reported: u64,
    /// The latest in words.
    latest: Option<Fault>,
}

/// A source that is fed from outside.
struct Inlet {
    name: String,
    /// Name in the topic.
    of_topic: String,
    kind: InletKind,
    port: Port,
}

/// Meaning of a source's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InletKind {
    /// Of the source with this number.
    Tracks(u16),
    /// Detections; whether the configuration has standard deviations for detections without own values.
    Detections { has_sigmas: bool },
}

/// Publisher of a source, from the first line on, with the samples to be published.
enum Port {
    Closed,
    Tracks(Publisher<SensorTrack>, Vec<SensorTrack>),
    Detections(Publisher<SensorDetection>, Vec<SensorDetection>, Scans),
}

/// All sources of a deployment that are fed from outside.
pub(super) struct Inlets {
    root: Root,
    frame: SystemFrame,
    tapped: TappedLines,
    inlets: Vec<Inlet>,
    /// Source of lines that name none.
    usual: Option<usize>,
    clock_limit: Option<Duration>,
    pub(super) published: u64,
    refused: Refusals,
    /// Source of the present line, as soon as known.
    source_of_line: Option<usize>,
}

impl Inlets {
    /// The sources of the configuration of a running deployment.
    pub(super) fn of(root: &Root, config: &Config, clock_limit: Option<Duration>) -> Self {
        let mut inlets = Vec::new();
        let mut add = |name: &str, of_topic: &str, kind| {
            inlets.push(Inlet {
                name: name.to_owned(),
                of_topic: of_topic.to_owned(),
                kind,
                port: Port::Closed,
            });
        };
        for (number, source) in (0..).zip(&config.sources) {
            if matches!(source.input, Input::External) {
                add(&source.name, &source.name, InletKind::Tracks(number));
            }
            let sensors = config.sensors_of(source);
            let facts = config.tracker(number).map(|tracker| &tracker.settings.sensors);
            for (place, sensor) in sensors.iter().enumerate() {
                if !matches!(sensor.input, Input::External) || sensor.takes_orders {
                    continue;
                }
                let has_sigmas = facts.is_some_and(|facts| facts[place].sigmas.is_some());
                let kind = InletKind::Detections { has_sigmas };
                // The sensor of a source in the short form is known by the source's name.
                let name = sensor.name.strip_suffix(".input").filter(|_| sensors.len() == 1);
                add(name.unwrap_or(&sensor.name), &sensor.name, kind);
            }
        }
        Self {
            root: root.clone(),
            frame: config.frame,
            tapped: TappedLines::of(config),
            inlets,
            usual: None,
            clock_limit,
            published: 0,
            refused: Refusals::default(),
            source_of_line: None,
        }
    }

    /// Names of the sources, for messages.
    fn names(&self) -> String {
        let names: Vec<&str> = self.inlets.iter().map(|inlet| inlet.name.as_str()).collect();
        match names.is_empty() {
            true => "none: declare one by [source.external]".to_owned(),
            false => names.join(", "),
        }
    }

    /// Makes the source called `name` the source of lines without a named source, and opens its topic.
    ///
    /// # Errors
    /// If no source of this name is fed from outside, or the topic cannot be opened.
    pub(super) fn choose(&mut self, name: Option<&str>) -> anyhow::Result<()> {
        let place = match name {
            Some(name) => self
                .place(name)
                .map_err(|fault| offline::Usage(format!("--source {name}: {}; {}", fault.limit, fault.remedy)))?,
            // A single source needs no name.
            None if self.inlets.len() == 1 => 0,
            None if self.inlets.is_empty() => {
                return Err(
                    offline::Usage(format!("no source is fed from outside; there are: {}", self.names())).into(),
                );
            }
            None => return Ok(()),
        };
        self.usual = Some(place);
        Ok(self.open(place)?)
    }

    /// Counts refused datagrams and connections, of which no line was read.
    pub(super) fn note(&mut self, reason: &str, count: u64) {
        if count > 0 {
            let of = (self.usual, reason.to_owned());
            self.refused.by_reason.entry(of).or_default().count += count;
        }
    }

    /// Reports the refused lines to the deployment, for the monitor's alarm; `now_ns` is monotonic.
    pub(super) fn report(&mut self, now_ns: i64) {
        if now_ns - self.refused.reported_ns < REPORT_NS {
            return;
        }
        self.refused.reported_ns = now_ns;
        let mut refusals = Vec::new();
        for ((place, reason), lines) in &mut self.refused.by_reason {
            let count = lines.count - lines.reported;
            lines.reported = lines.count;
            if count > 0 {
                refusals.push(refusals::Refusal {
                    name: place.map_or_else(String::new, |place| self.inlets[place].name.clone()),
                    refused: Refused::Lines {
                        count,
                        reason: reason.clone(),
                        latest: lines.latest.as_ref().map_or_else(String::new, ToString::to_string),
                    },
                });
            }
        }
        if !refusals.is_empty() {
            // Without the alarm, the summary has the counts.
            let _ = refusals::note(&self.root, &refusals);
        }
    }

    /// Refused lines by reason, apart from datagrams and connections of which none was read.
    pub(super) fn refused_lines(&self) -> BTreeMap<&str, u64> {
        let mut all = BTreeMap::new();
        for ((_, reason), lines) in &self.refused.by_reason {
            if lines.latest.is_some() {
                *all.entry(reason.as_str()).or_default() += lines.count;
            }
        }
        all
    }

    fn place(&self, name: &str) -> Result<usize, Fault> {
        let place = self.inlets.iter().position(|inlet| inlet.name == name);
        place.ok_or_else(|| {
            let remedy = format!("sources that are fed from outside: {}", self.names());
            fault("source", name, "is no source that is fed from outside", remedy)
        })
    }

    fn open(&mut self, place: usize) -> Result<(), Error> {
        let inlet = &mut self.inlets[place];
        if !matches!(inlet.port, Port::Closed) {
            return Ok(());
        }
        let name = &inlet.of_topic;
        // Lines are checked here singly, with the same limit.
        inlet.port = match inlet.kind {
            InletKind::Tracks(_) => Port::Tracks(unlimited(Publisher::at(&self.root, name)?), Vec::new()),
            InletKind::Detections { .. } => Port::Detections(
                unlimited(Publisher::at(&self.root, name)?),
                Vec::new(),
                Scans::default(),
            ),
        };
        Ok(())
    }

    /// Takes a line that came at `received_ns` (UTC), to be [flushed](Self::flush). Returns the fault of a refused
    /// line.
    ///
    /// # Errors
    /// If the deployment has ended, or shared memory fails.
    pub(super) fn take(&mut self, line: &[u8], received_ns: i64) -> Result<Option<Fault>, Error> {
        let refused = match self.try_take(line, received_ns) {
            Ok(is_full) => {
                if is_full {
                    self.flush()?;
                }
                return Ok(None);
            }
            Err(Refusal::Ended(error)) => return Err(error),
            Err(Refusal::Fault(fault)) => fault,
        };
        // Field names come from the sender of the lines.
        let reason = match samples::is_known(&refused.field) {
            true => refused.field.as_str(),
            false => "unknown field",
        };
        let of = (self.source_of_line, reason.to_owned());
        let lines = self.refused.by_reason.entry(of).or_default();
        lines.count += 1;
        lines.latest = Some(Fault::clone(&refused));
        Ok(Some(*refused))
    }

    /// Returns whether samples are to be flushed.
    fn try_take(&mut self, line: &[u8], received_ns: i64) -> Result<bool, Refusal> {
        self.source_of_line = self.usual;
        let mut fields = Fields::of_line(line)?;
        let is_tapped = fields.is_tapped();
        let place = match self.usual {
            // The line names a source of the deployment that was tapped.
            Some(place) if is_tapped => place,
            usual => match (fields.text("source")?, usual) {
                (Some(name), _) => self.place(&name)?,
                (None, Some(place)) => place,
                (None, None) => return Err(missing("source", &format!("name one of {}", self.names())).into()),
            },
        };
        self.source_of_line = Some(place);
        self.open(place).map_err(|error| match error.kind() {
            ErrorKind::Ended | ErrorKind::NotRunning => Refusal::Ended(error),
            _ => fault(
                "source",
                &self.inlets[place].name,
                &error.to_string(),
                "try again later",
            )
            .into(),
        })?;
        let limit_ns = self
            .clock_limit
            .map_or(admission::CLOCK_LIMIT_NS, |limit| limit.as_nanos() as i64);
        let checked = |fault: Option<Fault>| fault.map_or(Ok(()), Err);
        let inlet = &mut self.inlets[place];
        let gathered = match (&mut inlet.port, inlet.kind) {
            (Port::Tracks(_, waiting), InletKind::Tracks(source)) => {
                let mut track = match is_tapped {
                    true => self.tapped.track(fields.all(), source)?,
                    false => samples::track(fields)?.sample(&self.frame, received_ns)?,
                };
                track.source = source;
                checked(admission::fault(&track, received_ns, Some(limit_ns)))?;
                waiting.push(track);
                waiting.len()
            }
            (Port::Detections(_, waiting, scans), InletKind::Detections { has_sigmas }) => {
                let detection = if is_tapped {
                    let detection = self.tapped.detection(fields.all())?;
                    checked(admission::fault(&detection, received_ns, Some(limit_ns)))?;
                    detection
                } else {
                    let stated = samples::detection(fields, has_sigmas)?;
                    let mut detection = stated.sample(&self.frame, received_ns)?;
                    checked(admission::fault(&detection, received_ns, Some(limit_ns)))?;
                    stated.count(&mut detection, scans);
                    detection
                };
                waiting.push(detection);
                waiting.len()
            }
            _ => 0,
        };
        Ok(gathered >= GATHERED_MAX)
    }

    /// Publishes the samples from the lines.
    ///
    /// # Errors
    /// If the deployment has ended, or shared memory fails.
    pub(super) fn flush(&mut self) -> Result<(), Error> {
        for inlet in &mut self.inlets {
            self.published += match &mut inlet.port {
                Port::Closed => 0,
                Port::Tracks(publisher, waiting) => publish(publisher, waiting)?,
                Port::Detections(publisher, waiting, _) => publish(publisher, waiting)?,
            };
        }
        Ok(())
    }
}

fn unlimited<T: Outgoing + Admission>(mut publisher: Publisher<T>) -> Publisher<T> {
    publisher.limit_clock(None);
    publisher
}

fn publish<T: Outgoing + Admission>(publisher: &mut Publisher<T>, waiting: &mut Vec<T>) -> Result<u64, Error> {
    if waiting.is_empty() {
        return Ok(0);
    }
    publisher.publish(waiting)?;
    let count = waiting.len() as u64;
    waiting.clear();
    Ok(count)
}

/// Why a line was not taken.
enum Refusal {
    Fault(Box<Fault>),
    /// Nothing more can be fed.
    Ended(Error),
}

impl From<Fault> for Refusal {
    fn from(fault: Fault) -> Self {
        Self::Fault(Box::new(fault))
    }
}
