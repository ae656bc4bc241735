//! Evaluation, publication and log of alarms.

use std::path::Path;

use alarms::{AlarmHistory, AlarmKind, Board, RateLimit};
use bus::{Bus, Mark, Publisher, Transport};
use deployment::Deployment;
use messages::{Alarm, AlarmEvent, BatchHeader, SystemTrack};
use runtime::Now;

use crate::conditions::{Conditions, RoundView};
use crate::feeders::FeederWatch;
use crate::machine::{Machine, Room, is_gone};
use crate::settings::Settings;
use crate::survey::DeploymentSurvey;

/// Period of evaluation and publication, nanoseconds.
const ROUND_NS: i64 = 500_000_000;
/// Evaluations between two looks at the machine.
const ROUNDS_PER_LOOK: u32 = 4;
/// Name of the monitor that publishes alarms; additional monitors evaluate the same conditions and publish nothing.
const PUBLISHING: &str = "monitor";

/// Evaluation of alarms.
pub(crate) struct AlarmDesk<S: Transport> {
    board: Board,
    conditions: Conditions,
    machine: Machine,
    feeders: FeederWatch,
    room: Room,
    rounds: u32,
    publisher: Option<Publisher<S, Alarm>>,
    limit: RateLimit,
    due_ns: i64,
    standing: Vec<Alarm>,
}

impl<S: Transport> AlarmDesk<S> {
    /// Creates the alarms of the monitor called `name`, with files in `folder`.
    ///
    /// # Errors
    /// If the topic cannot be opened.
    pub(crate) fn new(
        (config, settings): (&Deployment, &Settings),
        name: &str,
        folder: &Path,
        bus: &Bus<S>,
        begun: Now,
    ) -> anyhow::Result<Self> {
        let publish = || bus.publisher(&messages::alarms(), begun.mono_ns as u64);
        let writes = config.services.recorder || settings.files;
        Ok(Self {
            board: Board::default(),
            conditions: Conditions::new((config, settings.alarms), name, folder.display().to_string(), begun),
            machine: Machine {
                folder: writes.then(|| folder.to_owned()),
            },
            feeders: FeederWatch::new(config, bus)?,
            room: Room::default(),
            rounds: 0,
            publisher: (name == PUBLISHING).then(publish).transpose()?,
            limit: RateLimit::default(),
            due_ns: i64::MIN,
            standing: Vec::new(),
        })
    }

    /// Takes a slice of system tracks.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], now: Now) {
        self.conditions.receive(header, tracks, now);
    }

    /// Evaluates all conditions if due, and publishes the standing alarms; `say` receives a line for each change.
    /// While the deployment is being stopped, no alarm is raised or cleared: ends of processes are no faults then.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn turn(
        &mut self,
        now: Now,
        survey: &mut DeploymentSurvey,
        say: &mut dyn FnMut(&str),
    ) -> anyhow::Result<()> {
        if now.mono_ns < self.due_ns || survey.observed.is_stopping() {
            return Ok(());
        }
        self.due_ns = now.mono_ns + ROUND_NS;
        if self.rounds.is_multiple_of(ROUNDS_PER_LOOK) {
            self.room = self.machine.room();
        }
        self.rounds = self.rounds.wrapping_add(1);
        survey.forget_guests(now, is_gone);
        let processes = survey.processes(now);
        let feeding = self.feeders.look(now);
        let sight = RoundView {
            observed: &survey.observed,
            processes: &processes,
            room: self.room,
            feeding: &feeding,
            now,
        };
        let mut round = self.board.round(now.mono_ns, now.utc_ns);
        self.conditions.look(sight, &mut round);
        let told = round.end();
        for alarm in &told {
            if let Some(line) = line(alarm)
                && let Some(withheld) = self.limit.ask(now.mono_ns)
            {
                match withheld {
                    0 => say(&line),
                    withheld => say(&format!("{line} ({withheld} changes of alarms were not told before)")),
                }
            }
        }
        if let Some(publisher) = &mut self.publisher {
            let mark = Mark {
                progress_ns: i64::MIN,
                sent_ns: now.mono_ns,
                end: false,
            };
            publisher.send(mark, told.len(), |index, sequence| Alarm {
                sequence,
                ..told[index]
            })?;
        }
        self.standing = told;
        self.standing.retain(|alarm| alarm.event() != Some(AlarmEvent::Cleared));
        Ok(())
    }

    /// Returns the standing alarms, the worst first.
    pub(crate) fn standing(&self) -> &[Alarm] {
        &self.standing
    }

    /// Returns every alarm since the start.
    pub(crate) fn history(&self) -> impl Iterator<Item = AlarmHistory> + '_ {
        self.board.history()
    }
}

/// Returns the line for a change; `None` without a change.
fn line(alarm: &Alarm) -> Option<String> {
    let kind = AlarmKind::from_code(alarm.code)?;
    match alarm.event()? {
        AlarmEvent::Raised => Some(format!(
            "alarm, {}: {} {}",
            kind.severity().word(),
            alarm.text(),
            kind.remedy()
        )),
        AlarmEvent::Cleared => Some(format!("alarm cleared: {}", alarm.text())),
        AlarmEvent::Standing => None,
    }
}
