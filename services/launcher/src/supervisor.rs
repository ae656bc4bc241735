//! Watching the children: the loop that starts, restarts and stops them.

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use configuration::Config;
use messages::ProcessKind;
use runtime::Now;
use runtime::clock::instant;
use runtime::instance::Instance;
use runtime::signals::Stop;

use crate::backoff::FAILURES_MAX;
use crate::board::Board;
use crate::child::{Child, Sequel};
use crate::part::{START_ORDER, STOP_ORDER, parts};
use crate::wake::Wake;
use crate::{Orders, say};

/// How long the processes of one stage of the start may take until they say that they run, before the next stage is
/// started all the same.
const START_PATIENCE: Duration = Duration::from_secs(10);
/// How long a child may take to stop, before it is ended hard.
const STOP_PATIENCE: Duration = Duration::from_secs(5);
/// Longest sleep: health messages must be read and said.
const TICK: Duration = Duration::from_millis(50);

/// A child refuses its configuration or how it was called: exit code 2, here as there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{child} refuses its configuration (exit code 2), for the reason it has given above")]
pub struct ChildRefused {
    /// Which child.
    pub child: String,
}

/// The children of one deployment.
#[derive(Debug)]
pub(crate) struct Supervisor<'a> {
    config: &'a Config,
    orders: &'a Orders,
    instance: &'a Instance,
    executable: PathBuf,
    children: Vec<Child>,
    board: Board,
    stop: Stop,
    wake: Wake,
    /// Shared memory of dead processes is still to be taken back.
    dead_left: bool,
}

impl<'a> Supervisor<'a> {
    /// Nothing is started yet.
    ///
    /// # Errors
    /// If the health topic cannot be joined, or the executable not be found.
    pub(crate) fn new(
        config: &'a Config,
        orders: &'a Orders,
        instance: &'a Instance,
        stop: Stop,
        wake: Wake,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            config,
            orders,
            instance,
            executable: std::env::current_exe().context("finding the executable")?,
            children: parts(config).into_iter().map(Child::new).collect(),
            board: Board::new(instance.bus())?,
            stop,
            wake,
            dead_left: false,
        })
    }

    /// Starts all children, watches them, and stops them.
    ///
    /// # Errors
    /// If one cannot be kept running, or did not stop well.
    pub(crate) fn run(mut self) -> anyhow::Result<()> {
        let watched = self.watch();
        let stopped = self.stop_all();
        watched.and(stopped)
    }

    /// Starts all children and watches them, until there is a reason to stop.
    fn watch(&mut self) -> anyhow::Result<()> {
        let begun = instant();
        let mut stages = START_ORDER.iter();
        let mut stage_began = begun;
        let mut complete: Option<Instant> = None;
        loop {
            let now = instant();
            self.tick(now)?;
            if self.stop.requested() {
                say("asked to stop");
                return Ok(());
            }
            match complete {
                None => {
                    let missing = self.not_up();
                    if missing.is_empty() || now.duration_since(stage_began) >= START_PATIENCE {
                        if !missing.is_empty() {
                            say(&format!("going on without {}", missing.join(", ")));
                        }
                        stage_began = now;
                        match stages.next() {
                            Some(kinds) => self.start_those(kinds)?,
                            None => {
                                self.announce(now.duration_since(begun));
                                complete = Some(now);
                            }
                        }
                        continue;
                    }
                }
                Some(complete) => {
                    let limit = self.orders.run_for;
                    if limit.is_some_and(|limit| now.duration_since(complete) >= limit) || self.is_finished() {
                        return Ok(());
                    }
                }
            }
            self.sleep(now, complete);
        }
    }

    /// Everything that has to be done again and again: mourn, restart, listen, speak.
    fn tick(&mut self, now: Instant) -> anyhow::Result<()> {
        let mut urgent = false;
        for index in 0..self.children.len() {
            if let Some(sequel) = self.children[index].reap(now) {
                urgent = true;
                self.after_end(index, sequel)?;
            }
        }
        if self.dead_left {
            let dead = self.instance.bus().remove_dead();
            self.dead_left = dead.failed > 0;
        }
        for index in 0..self.children.len() {
            if self.children[index].restart_due().is_some_and(|due| now >= due) {
                urgent = true;
                self.start(index)?;
            }
        }
        let children = &mut self.children;
        self.board.read(|pid, life| {
            let speaker = children.iter_mut().find(|child| child.pid() == Some(pid));
            let Some(child) = speaker else { return };
            if let Some(gap) = child.hear(life, now) {
                urgent = true;
                let (title, restarts) = (child.part().title(), child.restarts());
                say(&format!(
                    "{title} restarted ({restarts}), back after {:.2} s",
                    gap.as_secs_f64()
                ));
            }
        })?;
        self.board.say(Now::read(), &self.children, urgent)
    }

    fn start_those(&mut self, kinds: &[ProcessKind]) -> anyhow::Result<()> {
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
        match child.start(Command::new(&self.executable).args(arguments)) {
            None => Ok(()),
            Some(sequel) => self.after_end(index, sequel),
        }
    }

    /// Says that a child has ended. An error means that the deployment has to end too.
    fn after_end(&mut self, index: usize, sequel: Sequel) -> anyhow::Result<()> {
        let child = &self.children[index];
        let title = child.part().title();
        let end = child.last_end().map(ToString::to_string).unwrap_or_default();
        self.dead_left |= sequel != Sequel::Finished;
        match sequel {
            Sequel::Finished => {
                say(&format!("{title} has finished"));
                Ok(())
            }
            // The other one is gone, and with it what this one would have to be told again.
            Sequel::RestartIn(_) if self.has_outlived_a_reader(index) => {
                anyhow::bail!("{title} {end} near the end of the recordings: what it had still to do is missing")
            }
            Sequel::RestartIn(pause) => {
                let pause = pause.as_secs_f64();
                say(&format!("{title} {end}; restarting it in {pause:.1} s"));
                Ok(())
            }
            Sequel::Refused => Err(ChildRefused { child: title }.into()),
            Sequel::GiveUp => anyhow::bail!(
                "{title} failed {FAILURES_MAX} times in a row at its start; the last time it {end}. What it said is above"
            ),
        }
    }

    /// Children that have been started (or should have been) and do not run.
    fn not_up(&self) -> Vec<String> {
        let started = |child: &&Child| child.is_alive() || child.restart_due().is_some() || child.is_finished();
        let missing = self.children.iter().filter(started).filter(|child| !child.is_up());
        missing.map(|child| child.part().title()).collect()
    }

    fn announce(&self, took: Duration) {
        let names = |adapters: bool| -> Vec<String> {
            let parts = self.children.iter().map(Child::part);
            let chosen = parts.filter(|part| (part.kind == ProcessKind::Adapter) == adapters);
            chosen
                .map(|part| if adapters { part.name.clone() } else { part.title() })
                .collect()
        };
        let (services, adapters) = (names(false).join(", "), names(true));
        let instance = &self.orders.options.instance;
        let count = match adapters.len() {
            1 => "1 adapter".to_owned(),
            count => format!("{count} adapters"),
        };
        say(&format!(
            "instance {instance} runs after {:.1} s: {services}, and {count} ({}); Ctrl-C stops it",
            took.as_secs_f64(),
            adapters.join(", ")
        ));
    }

    /// Whether there is nothing left to do: those who read the adapters have finished. Adapters of recordings stay
    /// until they are stopped, so that a restarted reader finds them.
    fn is_finished(&self) -> bool {
        self.readers().all(Child::is_finished)
    }

    fn has_outlived_a_reader(&self, index: usize) -> bool {
        let is_reader = |child: &Child| self.readers().any(|reader| reader.part() == child.part());
        is_reader(&self.children[index]) && self.readers().any(Child::is_finished)
    }

    /// Those who read the adapters, and finish when all recordings have ended.
    fn readers(&self) -> impl Iterator<Item = &Child> {
        let reads = |child: &&Child| matches!(child.part().kind, ProcessKind::Fusion | ProcessKind::Recorder);
        self.children.iter().filter(reads)
    }

    fn sleep(&self, now: Instant, complete: Option<Instant>) {
        let end = complete.zip(self.orders.run_for).map(|(start, limit)| start + limit);
        let restarts = self.children.iter().filter_map(Child::restart_due);
        let next = restarts.chain(end).min();
        let sleep = next.map_or(TICK, |next| next.saturating_duration_since(now).min(TICK));
        if !sleep.is_zero() {
            self.wake.wait(sleep);
        }
    }

    /// Stops all children, one kind after the other.
    fn stop_all(&mut self) -> anyhow::Result<()> {
        let mut problems = Vec::new();
        for kind in STOP_ORDER {
            if kind == ProcessKind::Monitor {
                // The last word before the monitor's final report. That there may be no shared memory to say it in does
                // not change what has to be done.
                let _ = self.board.say(Now::read(), &self.children, true);
            }
            self.stop_kind(kind, &mut problems);
        }
        let _ = self.board.say_end(Now::read(), &self.children);
        if !problems.is_empty() {
            self.instance.bus().remove_dead();
            anyhow::bail!("{}", problems.join("; "));
        }
        Ok(())
    }

    fn stop_kind(&mut self, kind: ProcessKind, problems: &mut Vec<String>) {
        let mut waited_for: Vec<&mut Child> = self
            .children
            .iter_mut()
            .filter(|child| child.part().kind == kind)
            .collect();
        waited_for.retain_mut(|child| child.ask_to_stop());
        let start = instant();
        while !waited_for.is_empty() {
            waited_for.retain_mut(|child| match child.has_stopped() {
                Ok(stopped) => !stopped,
                Err(problem) => {
                    problems.push(problem);
                    false
                }
            });
            if instant() - start >= STOP_PATIENCE {
                break;
            }
            if !waited_for.is_empty() {
                self.wake.wait(TICK);
            }
        }
        for child in waited_for {
            child.kill();
            let patience = STOP_PATIENCE.as_secs();
            problems.push(format!(
                "{} did not stop within {patience} s and was killed",
                child.part().title()
            ));
        }
    }
}
