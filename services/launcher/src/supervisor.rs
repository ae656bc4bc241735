//! Supervision of the children: times of start, restart and stop, and of a rebuild of the deployment.

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use bus::Unborn;
use deployment::Deployment;
use messages::{LifeState, ProcessKind};
use runtime::clock::{instant, mono_ns};
use runtime::instance::Instance;
use runtime::signals::Stop;

use crate::backoff::Backoff;
use crate::child::{Child, Sequel};
use crate::children::Children;
use crate::end::End;
use crate::link::{HealthByProcess, KeeperLink, LauncherFacts, ProcessHealth};
use crate::part::{START_ORDER, STOP_ORDER};
use crate::service_manager::{ServiceManager, VARIABLES};
use crate::suspicion::Suspicion;
use crate::wake::Wake;
use crate::{RunOptions, say};

/// Time for the processes of a stage of the start to report running. The next stage starts in any case after this time.
const START_PATIENCE: Duration = Duration::from_secs(10);
/// Time for the recorder to stop before a rebuild, so that all data can be written.
const RECORDER_PATIENCE: Duration = Duration::from_secs(1);
/// Time for fusion's last health message to arrive.
const LAST_WORD_PATIENCE: Duration = Duration::from_millis(500);
/// Time between two messages to the keeper without a change.
const TELL_PERIOD: Duration = Duration::from_millis(200);

/// Exit code of a child that refuses the configuration or arguments: 2, as of the launcher.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{child} refuses its configuration (exit code 2), for the reason it has given above")]
pub struct ChildRefused {
    /// Name of the child.
    pub child: String,
}

/// Children of a deployment.
#[derive(Debug)]
pub(crate) struct Supervisor<'a> {
    config: &'a Deployment,
    /// Time after which a child without a sign of life is replaced.
    watchdog: Duration,
    orders: &'a RunOptions,
    instance: &'a mut Instance,
    executable: PathBuf,
    children: Children,
    /// Connection to the keeper, while a keeper exists.
    keeper: Option<KeeperLink>,
    stop: Stop,
    wake: Wake,
    service_manager: ServiceManager,
    incarnation: u64,
    deaths: u64,
    rebuilds: u64,
    /// Time of the latest message to the keeper.
    told: Instant,
    /// Times of the latest look at the children by the launcher and by the keeper.
    looked: Instant,
    keeper_looked: Instant,
    /// Unfinished memory of killed processes, and the time of the latest search.
    unborn: Unborn,
    swept: Instant,
    suspicion: Suspicion,
    /// Reason for a rebuild of the deployment, if any.
    corrupt: Option<String>,
    rebuilding: Backoff,
    start: StartProgress,
    /// Time at which the deployment was complete for the first time.
    complete: Option<Instant>,
    /// Whether fusion has taken a report.
    has_reports: bool,
    /// Whether the children are being stopped in order.
    is_stopping: bool,
}

/// Progress of the start, or of the start after a rebuild.
#[derive(Clone, Copy, Debug)]
struct StartProgress {
    begun: Instant,
    stage: usize,
    stage_begun: Instant,
    /// Whether all stages have been started.
    is_complete: bool,
}

impl StartProgress {
    fn at(begun: Instant) -> Self {
        Self {
            begun,
            stage: 0,
            stage_begun: begun,
            is_complete: false,
        }
    }
}

impl<'a> Supervisor<'a> {
    /// Creates the supervisor; no child is started yet.
    ///
    /// # Errors
    /// If the executable cannot be found.
    pub(crate) fn new(
        (config, watchdog): (&'a Deployment, Duration),
        orders: &'a RunOptions,
        instance: &'a mut Instance,
        stop: Stop,
        wake: Wake,
    ) -> anyhow::Result<Self> {
        let now = instant();
        let unborn = Unborn::new(instance.root());
        Ok(Self {
            config,
            watchdog,
            orders,
            instance,
            executable: std::env::current_exe().context("finding the executable")?,
            children: Children::of(config),
            keeper: None,
            stop,
            wake,
            service_manager: ServiceManager::new(),
            incarnation: mono_ns() as u64,
            deaths: 0,
            rebuilds: 0,
            told: now,
            looked: now,
            keeper_looked: now,
            unborn,
            swept: now,
            suspicion: Suspicion::default(),
            corrupt: None,
            rebuilding: Backoff::new(),
            start: StartProgress::at(now),
            complete: None,
            has_reports: false,
            is_stopping: false,
        })
    }

    /// Starts, watches and stops all children.
    ///
    /// # Errors
    /// If a needed child cannot be kept running, or a child did not stop well.
    pub(crate) fn run(mut self) -> anyhow::Result<()> {
        let watched = self.watch();
        self.service_manager.stopping();
        let down = self.children.down();
        let stopped = self.stop_all(down);
        watched.and(stopped)
    }

    /// Starts all children and watches the children until there is a reason to stop.
    fn watch(&mut self) -> anyhow::Result<()> {
        loop {
            let now = instant();
            self.tick(now)?;
            if self.stop.requested() {
                say("asked to stop");
                return Ok(());
            }
            if let Some(reason) = self.corrupt.take() {
                self.rebuild(&reason, now)?;
            }
            if !self.start.is_complete {
                self.start_more(now)?;
            }
            let limit = self
                .complete
                .zip(self.orders.run_for)
                .map(|(start, limit)| start + limit);
            if limit.is_some_and(|limit| now >= limit) || self.is_finished() {
                return Ok(());
            }
            self.sleep(now, limit);
        }
    }

    /// A round: collects ended children, reads messages, checks signs of life, restarts, and reports.
    fn tick(&mut self, now: Instant) -> anyhow::Result<()> {
        let mut urgent = false;
        for index in 0..self.children.len() {
            if let Some(sequel) = self.children[index].reap(now) {
                urgent = true;
                self.after_end(index, sequel, now)?;
            }
        }
        urgent |= self.listen(now);
        for index in 0..self.children.len() {
            if self.children[index].restart_due().is_some_and(|due| now >= due) {
                urgent = true;
                self.start(index)?;
            }
        }
        self.tell(now, urgent);
        self.sweep(now);
        let status = self.children.status(self.start.is_complete);
        self.service_manager.sign(status);
        Ok(())
    }

    /// Takes the keeper's message and looks for hung children. Returns whether a child has recovered.
    fn listen(&mut self, now: Instant) -> bool {
        let limit = self.watchdog;
        let mut heard = HealthByProcess::default();
        let mut has_looked = false;
        while let Some(more) = self.keeper.as_ref().and_then(KeeperLink::hear::<HealthByProcess>) {
            has_looked = true;
            heard.extend(more);
        }
        let mut is_back = false;
        let own = ProcessHealth {
            life: LifeState::Running as u8,
            said_ns: mono_ns(),
            has_reports: false,
        };
        self.has_reports |= heard.values().any(|said| said.has_reports);
        for child in self.children.iter_mut() {
            let is_keeper = child.part().kind == ProcessKind::Keeper;
            let said = match is_keeper {
                // The keeper's message is the keeper's sign of life.
                true => has_looked.then_some(own),
                false => child.pid().and_then(|pid| heard.get(&pid).copied()),
            };
            if let Some(gap) = said.and_then(|said| child.hear(said, now)) {
                is_back = true;
                let (title, restarts) = (child.part().title(), child.restarts());
                let gap = gap.as_secs_f64();
                say(&format!("{title} restarted ({restarts}), back after {gap:.2} s"));
            }
            // Without a look by the keeper there is no sign of life of any child.
            if is_keeper {
                child.looked(now.duration_since(self.looked), limit);
            } else if has_looked {
                child.looked(now.duration_since(self.keeper_looked), limit);
            }
        }
        self.looked = now;
        if has_looked {
            self.keeper_looked = now;
        }
        is_back
    }

    /// Removes unfinished memory of killed processes, over which other processes hang.
    fn sweep(&mut self, now: Instant) {
        if now.duration_since(self.swept) < Unborn::PERIOD {
            return;
        }
        self.swept = now;
        match self.unborn.remove() {
            Ok(0) => {}
            Ok(files) => say(&format!(
                "removed shared memory that a killed process had only begun ({files} in number)"
            )),
            // Another look follows.
            Err(error) => say(&format!("searching the remains of killed processes: {error}")),
        }
    }

    /// Sends the facts to the keeper, if due or `urgent`.
    fn tell(&mut self, now: Instant, urgent: bool) {
        if urgent || now.duration_since(self.told) >= TELL_PERIOD {
            self.tell_facts(now, false);
        }
    }

    fn tell_facts(&mut self, now: Instant, ended: bool) {
        let facts = LauncherFacts {
            incarnation: self.incarnation,
            deaths: self.deaths,
            rebuilds: self.rebuilds,
            stopping: self.is_stopping,
            ended,
            children: self.children.iter().map(Child::facts).collect(),
        };
        // Without room, the next round sends the facts.
        if self.keeper.as_ref().is_some_and(|keeper| keeper.say(&facts)) {
            self.told = now;
        }
    }

    /// Starts the next stage, if the present stage is up or the stage's time is over.
    fn start_more(&mut self, now: Instant) -> anyhow::Result<()> {
        if now < self.start.stage_begun {
            return Ok(());
        }
        let missing: Vec<&Child> = self.children.iter().filter(|child| is_waited_for(child)).collect();
        let is_keeper = |child: &&Child| child.part().kind == ProcessKind::Keeper;
        let is_over = now.duration_since(self.start.stage_begun) >= START_PATIENCE;
        // No process can work without topics.
        if !missing.is_empty() && (!is_over || missing.iter().any(is_keeper)) {
            return Ok(());
        }
        let last = self
            .start
            .stage
            .checked_sub(1)
            .map_or(&[][..], |last| START_ORDER[last]);
        let left_out = self
            .children
            .iter()
            .filter(|child| last.contains(&child.part().kind) && !child.is_up());
        let left_out: Vec<String> = left_out.map(|child| child.part().title()).collect();
        if !left_out.is_empty() {
            say(&format!("going on without {}", left_out.join(", ")));
        }
        let Some(kinds) = START_ORDER.get(self.start.stage) else {
            say(&format!(
                "instance {} runs after {:.1} s: {}; Ctrl-C stops it",
                self.orders.options.instance,
                now.duration_since(self.start.begun).as_secs_f64(),
                self.children.listed()
            ));
            self.start.is_complete = true;
            if self.complete.is_none() {
                self.complete = Some(now);
                self.service_manager.ready();
            }
            return Ok(());
        };
        self.start.stage += 1;
        self.start.stage_begun = now;
        for index in 0..self.children.len() {
            if kinds.contains(&self.children[index].part().kind) {
                self.start(index)?;
            }
        }
        Ok(())
    }

    fn start(&mut self, index: usize) -> anyhow::Result<()> {
        let child = &mut self.children[index];
        let arguments = child
            .part()
            .arguments(&self.config.path, &self.orders.options, std::process::id());
        let mut command = Command::new(&self.executable);
        command.args(arguments);
        for variable in VARIABLES {
            command.env_remove(variable);
        }
        let mut input = None;
        if child.part().kind == ProcessKind::Keeper {
            let (own, other) = KeeperLink::pair().context("making a socket for the keeper")?;
            self.keeper = Some(own);
            input = Some(other);
        }
        match child.start(&mut command, input) {
            None => Ok(()),
            Some(sequel) => self.after_end(index, sequel, instant()),
        }
    }

    /// Notes that a child has ended. An error means that the deployment must end too.
    fn after_end(&mut self, index: usize, sequel: Sequel, now: Instant) -> anyhow::Result<()> {
        let child = &self.children[index];
        let title = child.part().title();
        let end = child.last_end().map(ToString::to_string).unwrap_or_default();
        self.deaths += u64::from(sequel != Sequel::Finished);
        match sequel {
            Sequel::Finished => {
                say(&format!("{title} has finished"));
                Ok(())
            }
            // The old keeper is gone, and the new keeper needs all facts.
            Sequel::RestartIn(_) if self.children.has_outlived_a_reader(index) => {
                anyhow::bail!("{title} {end} near the end of the recordings: its remaining work is missing")
            }
            Sequel::RestartIn(pause) => {
                let pause = if self.children.hasten_fusion(now, index) {
                    0.0
                } else {
                    pause.as_secs_f64()
                };
                say(&format!("{title} {end}; restarting it in {pause:.1} s"));
                self.suspect(index, now);
                self.children.hand_over(index);
                Ok(())
            }
            Sequel::Refused => Err(ChildRefused { child: title }.into()),
            Sequel::GiveUp => {
                let times = match child.failures() {
                    1 => "once".to_owned(),
                    failures => format!("{failures} times in a row"),
                };
                anyhow::bail!("{title} failed {times} at its start; the last time it {end}. Its output is above")
            }
        }
    }

    /// Decides whether shared memory is the cause of a child's end.
    fn suspect(&mut self, index: usize, now: Instant) {
        let child = &self.children[index];
        let Some(end) = child.last_end() else { return };
        let is_keeper = child.part().kind == ProcessKind::Keeper;
        // Only shared memory can disturb the keeper: by the contents, or by the fault that ended the previous keeper.
        let keeper_cannot_use_it = is_keeper && !end.is_killed();
        // A hang may have a cause outside; a hang of the successor as well has not.
        let was_stopped = matches!(end, End::StoodStill(_)) && child.failures() == 1;
        // Leader and standby read the same reports: a report that kills the leader may kill the standby.
        let readers_kind = |other: &Child| other.part().kind == ProcessKind::Fusion;
        let reader = match child.part().kind {
            ProcessKind::Fusion => self.children.iter().position(readers_kind).unwrap_or(index),
            _ => index,
        };
        let is_suspect = !was_stopped && end.may_be_of_memory() && self.suspicion.raise(now, reader, child.failures());
        if (keeper_cannot_use_it && !was_stopped) || is_suspect {
            self.corrupt = Some(format!("{} {end}", child.part().title()));
        }
    }

    /// Kills all children, and restarts all in new shared memory.
    fn rebuild(&mut self, reason: &str, now: Instant) -> anyhow::Result<()> {
        if self.children.readers().any(Child::is_finished) {
            anyhow::bail!("{reason} near the end of the recordings: the remaining work is missing");
        }
        self.rebuilds += 1;
        let lived = now.duration_since(self.start.begun);
        let pause = self.rebuilding.ended(lived, self.start.is_complete);
        say(&format!(
            "the shared memory seems to be corrupt: {reason}; rebuilding the deployment in {:.1} s",
            pause.as_secs_f64()
        ));
        let is_recorder = |child: &Child| child.part().kind == ProcessKind::Recorder;
        if let Some(recorder) = self.children.iter_mut().find(|child| is_recorder(child))
            && recorder.ask_to_stop()
        {
            let asked = instant();
            while recorder.has_stopped() == Ok(false) && instant() - asked < RECORDER_PATIENCE {
                self.wake.wait(Wake::TICK);
            }
        }
        for child in self.children.iter_mut() {
            child.tear_down(now);
        }
        self.keeper = None;
        self.instance.empty()?;
        self.suspicion.forget();
        self.start = StartProgress::at(instant() + pause);
        Ok(())
    }

    /// Whether no work is left: the readers of the adapters have finished. Adapters of recordings stay until stopped,
    /// for restarted readers.
    fn is_finished(&self) -> bool {
        self.start.is_complete && self.children.readers().all(Child::is_finished)
    }

    fn sleep(&self, now: Instant, limit: Option<Instant>) {
        let next = self.children.next_restart().into_iter().chain(limit).min();
        let tick = if self.is_calm() { TELL_PERIOD } else { Wake::TICK };
        let sleep = next.map_or(tick, |next| next.saturating_duration_since(now).min(tick));
        if !sleep.is_zero() {
            self.wake.wait(sleep);
        }
    }

    /// Whether all children run: then the next event is a signal, or not urgent.
    fn is_calm(&self) -> bool {
        self.start.is_complete && self.children.iter().all(Child::is_up)
    }

    /// Stops all children, kind by kind.
    ///
    /// # Errors
    /// If a child did not stop well, or if the work was in vain: `down` names children that were missing in the end,
    /// or no report has come. After an early stop request this is a warning; a recorder that failed has lost data in
    /// any case.
    fn stop_all(&mut self, down: Vec<(ProcessKind, String)>) -> anyhow::Result<()> {
        self.is_stopping = true;
        let mut problems = Vec::new();
        let is_recorder = |(kind, _): &(ProcessKind, String)| *kind == ProcessKind::Recorder;
        let (lost, mut in_vain): (Vec<_>, Vec<_>) = down.into_iter().partition(is_recorder);
        for kind in STOP_ORDER {
            if kind == ProcessKind::Keeper && self.complete.is_some() && !self.has_come() {
                in_vain.push((ProcessKind::Fusion, "fusion did not receive a single report".to_owned()));
            }
            // The monitor's final report covers the preceding kinds; the keeper's last message covers all others.
            self.tell_facts(instant(), kind == ProcessKind::Keeper);
            self.children.stop(kind, &self.wake, &mut problems);
        }
        let said = |(_, what): (ProcessKind, String)| what;
        problems.extend(lost.into_iter().map(said));
        if self.stop.requested() {
            in_vain
                .into_iter()
                .for_each(|what| say(&format!("warning: {}", said(what))));
        } else {
            problems.extend(in_vain.into_iter().map(said));
        }
        if !problems.is_empty() {
            anyhow::bail!("{}", problems.join("; "));
        }
        Ok(())
    }

    /// Whether fusion has taken a report; fusion's last message may still be under way.
    fn has_come(&mut self) -> bool {
        let start = instant();
        while !self.has_reports && instant() - start < LAST_WORD_PATIENCE {
            self.wake.wait(Wake::TICK);
            self.listen(instant());
        }
        self.has_reports
    }
}

/// Whether the next stage of the start waits for this child. A failed child waits for its own next start. Other
/// children do not wait for a failed child, except for keeper and fusion.
fn is_waited_for(child: &Child) -> bool {
    let has_failed = child.restart_due().is_some();
    let is_needed = matches!(child.part().kind, ProcessKind::Keeper | ProcessKind::Fusion);
    !child.is_unborn() && !child.is_up() && (!has_failed || is_needed)
}
