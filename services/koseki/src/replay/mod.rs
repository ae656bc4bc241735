//! `koseki replay`: a recording of all topics, fused again as recorded, bit for bit (FM-10), or otherwise.
//!
//! The state of an engine depends only on the calls of its driver. Live fusion records these calls as steps of the
//! event log; the reports are on the sources' topics. This module reads a recording slice by slice. `again` brings
//! steps and reports together and drives a new engine from each start of fusion. `verification` compares the resulting
//! system tracks with the recorded tracks. `live` publishes the reports again into a running deployment instead.

mod again;
#[cfg(test)]
mod again_tests;
mod live;
pub(crate) mod smoothing;
mod verification;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use deployment::Source;
use formats::rows::RowWriter;
use formats::tracks_csv::PlacedTrack;
use frames::time::NS_PER_DAY;
use messages::layout::Sample as _;
use messages::{BatchHeader, Restored, SensorTrack, SystemTrack, WorkStep};
use offline::{OutputFile, Usage, check_outputs};
use recording::{Facts, Item};
use runtime::Speed;

use crate::args::ReplayArgs;
use crate::config::Config;
use crate::recording_info::{files, note_damage};
use again::{Again, Plan, RunOutcome, Spans};
use verification::Verification;

/// Fact: text of the configuration.
const CONFIGURATION: &str = "configuration";

/// Replays.
///
/// # Errors
/// If the recording cannot be used, the result cannot be written, or the result differs from the recording.
pub(crate) fn run(replay: &ReplayArgs) -> anyhow::Result<()> {
    let files = files(&replay.recording)?;
    check_outputs(files.iter().chain(&replay.config), &[("--out", replay.out.as_ref())])?;
    let recorded = configuration(&facts(&files[0])?, &files[0])?;
    check_sources(replay, &recorded)?;
    if replay.live {
        return live::run(replay, &recorded, &files);
    }
    if matches!(replay.speed, Some(Speed::Factor(_))) {
        let why = "without --live there is no pace to keep; omit the option";
        return Err(Usage(format!("--speed: {why}")).into());
    }
    let used = match &replay.config {
        Some(path) => Config::read(path, &[])?,
        None => recorded.clone(),
    };
    let plan = plan(replay, &recorded, &used);
    let result = Result {
        span: (replay.from, replay.to),
        verification: replay.verify.then(Verification::default),
        out: replay.out.as_deref().map(OutputFile::begin).transpose()?,
        rows: None,
        config: used,
        failed: Ok(()),
        states: 0,
        damaged: 0,
        damaged_bytes: 0,
    };
    let (again, result) = fused_again(&files, topics(&recorded), plan, result)?;
    result.finish(&again)
}

/// Fuses the recording in `files` again; all output goes to `result`.
fn fused_again<R: ReplayResult>(
    files: &[PathBuf],
    topics: BTreeMap<String, ReplayTopic>,
    plan: Plan,
    result: R,
) -> anyhow::Result<(Again, R)> {
    let mut reading = ReplayReading {
        topics,
        slice: BatchHeader::default(),
        place: 0,
        topic: None,
        taken_ns: 0,
        again: Again::new(plan),
        result,
    };
    for path in files {
        let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
        let read = |item: Item<'_>| {
            note_damage(path, &item);
            reading.item(item)
        };
        recording::read::<_, anyhow::Error>(&mut file, read).with_context(|| format!("reading {}", path.display()))?;
    }
    reading.work(u64::MAX)?;
    Ok((reading.again, reading.result))
}

/// Topics of a recording that a replay looks at.
fn topics(recorded: &Config) -> BTreeMap<String, ReplayTopic> {
    let reports = recorded.sources.iter().map(|source| {
        let topic = messages::sensor_tracks(&source.name);
        (topic.name.as_str().to_owned(), ReplayTopic::Reports(source.number))
    });
    let own = [
        (messages::event_log().name, ReplayTopic::Steps),
        (messages::system_tracks().name, ReplayTopic::States),
        (messages::restored().name, ReplayTopic::Restored),
    ];
    let own = own.map(|(name, topic)| (name.as_str().to_owned(), topic));
    reports.chain(own).collect()
}

/// Shows a recording in browsers at the address of `settings`. Labels, start view and declination come from the
/// recorded configuration, or from the configuration `given` with its folder of data, which also has the maps.
///
/// # Errors
/// If the recording cannot be used.
pub(crate) fn show(
    recording: &Path,
    settings: display::Settings,
    given: Option<(&Config, &Path)>,
) -> anyhow::Result<()> {
    let files = files(recording)?;
    let config = configuration(&facts(&files[0])?, &files[0])?;
    let settings = match given {
        None => settings.looking_like(config.parts.display()),
        Some((given, data)) => {
            let settings = settings
                .looking_like(given.parts.display())
                .with_maps(given.parts.display(), data);
            display::check_maps(&settings, &config.frame, data).map_err(Usage)?;
            settings
        }
    };
    display::show_recording(&config, &config.engine, (recording, &files), &settings)
}

/// A topic that is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReplayTopic {
    /// Reports of a source.
    Reports(u16),
    /// The order of work.
    Steps,
    /// States of system tracks.
    States,
    /// Start of a fusion.
    Restored,
}

/// Receiver of a replay's output.
trait ReplayResult {
    /// Takes an outcome.
    fn take(&mut self, outcome: RunOutcome<'_>);

    /// Takes a failure so far.
    fn take_failure(&mut self) -> std::io::Result<()>;

    /// Takes a recorded state of a system track.
    fn record(&mut self, _: &SystemTrack) {}

    /// Takes note of a damaged part of the recording with so many bytes.
    fn skip(&mut self, _bytes: u64) {}

    /// States that the recording does not contain.
    fn pass_over(&mut self, _missing: &[Range<usize>]) {}
}

/// The recording, during reading.
#[derive(Debug)]
struct ReplayReading<R> {
    topics: BTreeMap<String, ReplayTopic>,
    /// Header of the present slice, the place of the next sample, the topic, and the time at which the slice was taken.
    slice: BatchHeader,
    place: u64,
    topic: Option<ReplayTopic>,
    taken_ns: u64,
    again: Again,
    result: R,
}

/// Where the states go.
#[derive(Debug)]
struct Result {
    /// Reference times between which states count, UTC, nanoseconds.
    span: (Option<i64>, Option<i64>),
    verification: Option<Verification>,
    out: Option<OutputFile>,
    rows: Option<RowWriter<PlacedTrack, OutputFile>>,
    config: Config,
    failed: std::io::Result<()>,
    states: u64,
    /// Skipped damaged parts of the recording, and skipped bytes.
    damaged: u64,
    damaged_bytes: u64,
}

impl<R: ReplayResult> ReplayReading<R> {
    fn item(&mut self, item: Item<'_>) -> anyhow::Result<()> {
        match item {
            Item::Topic { name, missing, .. } => {
                if let Some(ReplayTopic::States) = self.topics.get(name) {
                    self.result.pass_over(missing);
                }
            }
            Item::Facts(_) => {}
            Item::Damaged { bytes, .. } => self.result.skip(bytes.end - bytes.start),
            Item::Slice {
                topic,
                header,
                taken_ns,
                ..
            } => {
                self.topic = self.topics.get(topic).copied();
                self.slice = header;
                self.place = 0;
                self.taken_ns = taken_ns;
                self.work(taken_ns)?;
            }
            Item::Sample { octets, .. } => self.sample(octets),
        }
        Ok(())
    }

    fn sample(&mut self, octets: &[u8]) {
        let header = &self.slice;
        let number = header.first_sequence.wrapping_add(self.place);
        self.place += 1;
        match self.topic {
            Some(ReplayTopic::Reports(source)) => {
                if let Some(report) = SensorTrack::of_octets(octets) {
                    self.again.report(source, header.incarnation, number, &report);
                }
            }
            Some(ReplayTopic::Steps) => {
                if let Some(step) = WorkStep::of_octets(octets) {
                    self.again.step(header.incarnation, number, step, self.taken_ns);
                }
            }
            Some(ReplayTopic::States) => {
                if let Some(state) = SystemTrack::of_octets(octets) {
                    self.result.record(&state);
                }
            }
            Some(ReplayTopic::Restored) => {
                if let Some(part) = Restored::of_octets(octets) {
                    self.again.restored(&part);
                }
            }
            None => {}
        }
    }

    /// Performs the work that the recording contains up to this time of the recorder.
    fn work(&mut self, read_ns: u64) -> anyhow::Result<()> {
        let Self { again, result, .. } = self;
        again.work(read_ns, &mut |outcome| result.take(outcome))?;
        Ok(result.take_failure()?)
    }
}

impl ReplayResult for Result {
    fn record(&mut self, state: &SystemTrack) {
        if let Some(verification) = &mut self.verification {
            verification.record(state);
        }
    }

    fn pass_over(&mut self, missing: &[Range<usize>]) {
        if let Some(verification) = &mut self.verification {
            verification.pass_over(missing);
        }
    }

    fn skip(&mut self, bytes: u64) {
        self.damaged += 1;
        self.damaged_bytes += bytes;
    }

    fn take_failure(&mut self) -> std::io::Result<()> {
        std::mem::replace(&mut self.failed, Ok(()))
    }

    fn take(&mut self, outcome: RunOutcome<'_>) {
        match outcome {
            RunOutcome::Began(epoch, sequence) => {
                if let Some(verification) = &mut self.verification {
                    verification.begin(epoch, sequence);
                }
            }
            RunOutcome::Broke(epoch) => {
                if let Some(verification) = &mut self.verification {
                    verification.break_off(epoch);
                }
            }
            RunOutcome::State(state) => {
                if let Some(verification) = &mut self.verification {
                    verification.give(state);
                }
                let time_ns = state.reference_time_ns;
                let (from, to) = self.span;
                if from.is_none_or(|from| time_ns >= from) && to.is_none_or(|to| time_ns <= to) && self.failed.is_ok() {
                    self.states += 1;
                    self.failed = self.write(state);
                }
            }
            RunOutcome::Input(_) | RunOutcome::Worked(_) => {}
        }
    }
}

impl Result {
    fn write(&mut self, state: &SystemTrack) -> std::io::Result<()> {
        if let Some(out) = self.out.take() {
            let of_first = || state.reference_time_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
            let first_day_ns = self.config.first_day_ns.unwrap_or_else(of_first);
            self.rows = Some(RowWriter::begin(out, first_day_ns)?);
        }
        let Some(rows) = &mut self.rows else { return Ok(()) };
        rows.write(&PlacedTrack::new(state, &self.config.frame))
    }

    fn finish(self, again: &Again) -> anyhow::Result<()> {
        if let Some(rows) = self.rows {
            rows.into_inner().finish()?;
        }
        let Spans {
            done_ns, left_out_ns, ..
        } = again.spans;
        let seconds = |ns: i64| ns as f64 / 1e9;
        let mut text = String::new();
        let damage = match self.damaged {
            0 => String::new(),
            parts => format!("damaged parts skipped: {parts} ({} bytes)\n", self.damaged_bytes),
        };
        let Some(mut verification) = self.verification else {
            let (reports, states) = (again.worked, self.states);
            writeln!(
                text,
                "replayed {:.1} s, {reports} reports, {states} track states",
                seconds(done_ns)
            )?;
            if left_out_ns > 0 || again.missing > 0 {
                let missing = again.missing;
                writeln!(
                    text,
                    "left out: {:.1} s; missing: {missing} reports",
                    seconds(left_out_ns)
                )?;
            }
            text.push_str(&damage);
            crate::print(&text)?;
            anyhow::ensure!(reports > 0, "no report of the recording could be worked off");
            return Ok(());
        };
        verification.finish();
        let Verification {
            states,
            differences,
            first,
            not_verified,
            not_recorded,
            ..
        } = verification;
        writeln!(
            text,
            "verified {:.1} s, {states} track states, {differences} differences",
            seconds(done_ns)
        )?;
        if left_out_ns > 0 || not_verified > 0 {
            writeln!(
                text,
                "not verified: {:.1} s, {not_verified} track states",
                seconds(left_out_ns)
            )?;
        }
        if not_recorded > 0 {
            writeln!(text, "given, but not recorded: {not_recorded} track states")?;
        }
        text.push_str(&damage);
        crate::print(&text)?;
        if let Some(first) = first {
            anyhow::bail!("{differences} track states differ from those recorded, the first {first}");
        }
        anyhow::ensure!(states > 0, "nothing was verified");
        let parts = self.damaged;
        anyhow::ensure!(
            parts == 0,
            "the recording is damaged: what its {parts} damaged parts contain is not verified"
        );
        Ok(())
    }
}

/// Facts at the beginning of a file.
pub(crate) fn facts(path: &Path) -> anyhow::Result<Facts> {
    let mut found = Facts::new();
    recording::facts(&mut BufReader::new(File::open(path)?))
        .map(|facts| found.extend(facts.unwrap_or_default()))
        .with_context(|| format!("reading {}", path.display()))?;
    Ok(found)
}

/// The configuration that a recording was made with.
pub(crate) fn configuration(facts: &Facts, path: &Path) -> anyhow::Result<Config> {
    let Some(text) = facts.get(CONFIGURATION) else {
        return Err(Usage(format!(
            "{}: does not say with which configuration it was made",
            path.display()
        ))
        .into());
    };
    Ok(Config::parse_whole(path, text)?)
}

fn check_sources(replay: &ReplayArgs, recorded: &Config) -> std::result::Result<(), Usage> {
    for name in &replay.sources {
        if !recorded.sources.iter().any(|source| source.name == *name) {
            let known: Vec<&str> = recorded.sources.iter().map(|source| source.name.as_str()).collect();
            return Err(Usage(format!(
                "--sources {name}: the recording has no such source; there are {}",
                known.join(", ")
            )));
        }
    }
    Ok(())
}

/// How the recording is fused again: the sources of `recorded` by the settings of `used`.
fn plan(replay: &ReplayArgs, recorded: &Config, used: &Config) -> Plan {
    let number = |source: &Source| {
        let is_wanted = replay.sources.is_empty() || replay.sources.contains(&source.name);
        let used = used.sources.iter().find(|other| other.name == source.name);
        used.filter(|_| is_wanted).map(|used| used.number)
    };
    Plan {
        settings: used.engine.clone(),
        order: recorded.order,
        origin: used.origin,
        sources: recorded.sources.iter().map(number).collect(),
        conditions: recorded.engine.conditions().map(str::to_owned).collect(),
        tolerates: !replay.verify,
        restores: replay.config.is_none() && replay.sources.is_empty(),
    }
}
