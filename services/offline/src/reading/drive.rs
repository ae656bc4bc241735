//! Passes all reports of files to the driver of the engine, in order of time like the live process; in order of arrival
//! for files with stated arrivals.

use std::io;

use fusion::{Driver, Engine, FilterInput, ReportNumber, Sink};
use messages::{Decision, SystemTrack};

use super::arrivals::ArrivedReport;
use super::merged::MergedRows;
use super::progress::Progress;
use crate::host::Host;

/// Step of the end time without a refresh time, nanoseconds: the engine advances to the next whole multiple after
/// the last report.
const STEP_NS: i64 = 1_000_000_000;

/// Sums over the processed reports.
#[derive(Clone, Debug, Default)]
pub(crate) struct DriveTotals {
    /// Number of processed reports.
    pub(crate) reports: u64,
    /// Number of processed reports by source.
    pub(crate) by_source: Vec<u64>,
    /// Time spent in the engine alone, nanoseconds.
    pub(crate) engine_ns: i64,
    /// Time up to which time has passed with the last report, nanoseconds.
    pub(crate) last_ns: Option<i64>,
}

/// States and decisions emitted by the engine for a report.
#[derive(Debug, Default)]
struct EngineOutput {
    states: Vec<SystemTrack>,
    decisions: Vec<Decision>,
    /// Inputs of filters, where requested, each with the number of preceding states.
    inputs: Option<Vec<(usize, FilterInput)>>,
}

impl Sink for EngineOutput {
    fn track(&mut self, track: &SystemTrack) {
        self.states.push(*track);
    }

    fn decision(&mut self, decision: &Decision) {
        self.decisions.push(*decision);
    }

    fn follows_inputs(&self) -> bool {
        self.inputs.is_some()
    }

    fn input(&mut self, input: &FilterInput) {
        if let Some(inputs) = &mut self.inputs {
            inputs.push((self.states.len(), *input));
        }
    }
}

/// Receiver of the engine's output for a report.
pub(crate) trait EngineReader {
    /// Takes the next state of a system track.
    fn state(&mut self, state: &SystemTrack) -> io::Result<()>;

    /// Takes the next decision.
    fn decision(&mut self, _: &Decision) -> io::Result<()> {
        Ok(())
    }

    /// Whether inputs of filters are wanted.
    fn follows_inputs(&self) -> bool {
        false
    }

    /// Takes the next input of a filter.
    fn input(&mut self, _: &FilterInput) -> io::Result<()> {
        Ok(())
    }

    /// Looks at the engine after each report.
    fn look(&mut self, _: &Engine) {}
}

/// Reader of states and decisions.
struct StatesAndDecisions<R, E>(R, E);

impl<R, E> EngineReader for StatesAndDecisions<R, E>
where
    R: FnMut(&SystemTrack) -> io::Result<()>,
    E: FnMut(&Decision) -> io::Result<()>,
{
    fn state(&mut self, state: &SystemTrack) -> io::Result<()> {
        self.0(state)
    }

    fn decision(&mut self, decision: &Decision) -> io::Result<()> {
        self.1(decision)
    }
}

/// Processes all reports; passes each state of a system track to `row` and each decision to `explain`.
///
/// After the last report, time advances to the next whole second, or to the next multiple of the refresh time.
///
/// # Errors
/// If reading a file fails, or `row` fails.
pub(crate) fn drive(
    host: &dyn Host,
    engine: Engine,
    reports: &mut MergedRows,
    row: impl FnMut(&SystemTrack) -> io::Result<()>,
    explain: impl FnMut(&Decision) -> io::Result<()>,
) -> anyhow::Result<(Engine, DriveTotals)> {
    drive_into(host, engine, reports, &mut StatesAndDecisions(row, explain))
}

/// Processes all reports as [`drive`] does; all that the engine emits goes to `reader`.
///
/// # Errors
/// If reading a file fails, or `reader` fails.
pub(crate) fn drive_into(
    host: &dyn Host,
    engine: Engine,
    reports: &mut MergedRows,
    reader: &mut impl EngineReader,
) -> anyhow::Result<(Engine, DriveTotals)> {
    let mut driven = DriveTotals {
        by_source: vec![0; engine.settings().sources.len()],
        ..DriveTotals::default()
    };
    // A file needs no log: the rows are all events.
    let mut driver = Driver::begin(engine, (), 0);
    let mut out = EngineOutput {
        inputs: reader.follows_inputs().then(Vec::new),
        ..EngineOutput::default()
    };
    let mut pass_on = |out: &mut EngineOutput, engine: &Engine| -> io::Result<()> {
        let inputs = out.inputs.iter_mut().flat_map(|inputs| inputs.drain(..));
        let mut inputs = inputs.peekable();
        for (place, state) in out.states.iter().enumerate() {
            while let Some((_, input)) = inputs.next_if(|(before, _)| *before <= place) {
                reader.input(&input)?;
            }
            reader.state(state)?;
        }
        inputs.try_for_each(|(_, input)| reader.input(&input))?;
        out.states.clear();
        reader.look(engine);
        out.decisions
            .drain(..)
            .try_for_each(|decision| reader.decision(&decision))
    };
    let progress = Progress::new(host, reports.octets_in_all);
    while let Some(ArrivedReport {
        track: mut report,
        arrival_ns,
        ..
    }) = reports.next()?
    {
        let begin_ns = runtime::clock::mono_ns();
        driver.report(&mut report, ReportNumber::default(), arrival_ns, &mut out);
        driven.engine_ns += runtime::clock::mono_ns() - begin_ns;
        driven.reports += 1;
        driven.by_source[usize::from(report.source)] += 1;
        driven.last_ns = Some(arrival_ns);
        pass_on(&mut out, driver.engine())?;
        progress.at(*reports.octets.borrow())?;
    }
    if let Some(last_ns) = driven.last_ns {
        // A deadline takes effect only after its time has passed, so a nanosecond is added.
        let settings = driver.engine().settings();
        let end_ns = end_ns(last_ns, settings.refresh_ns()) + settings.refresh_delay_s.ns() + 1;
        let begin_ns = runtime::clock::mono_ns();
        driver.advance(end_ns, &mut out);
        driven.engine_ns += runtime::clock::mono_ns() - begin_ns;
        pass_on(&mut out, driver.engine())?;
    }
    Ok((driver.into_engine(), driven))
}

/// Returns the first whole multiple of the refresh time that is not before `last_ns`.
pub(crate) fn end_ns(last_ns: i64, refresh_ns: Option<i64>) -> i64 {
    let step_ns = refresh_ns.unwrap_or(STEP_NS);
    last_ns + (-last_ns).rem_euclid(step_ns)
}
