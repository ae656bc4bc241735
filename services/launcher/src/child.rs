//! One child process, through all its lives.

use std::os::unix::process::CommandExt as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use messages::{LifeState, ProcessKind};
use runtime::clock::instant;
use rustix::process::{Pid, Signal, kill_process};

use crate::backoff::{Backoff, Verdict};
use crate::end::End;
use crate::part::Part;

/// A part of the deployment, and the process that plays it.
#[derive(Debug)]
pub(crate) struct Child {
    part: Part,
    state: State,
    backoff: Backoff,
    restarts: u32,
    last_end: Option<End>,
}

#[derive(Debug)]
enum State {
    /// It has not been started yet.
    Unborn,
    /// It has a process.
    Alive {
        process: std::process::Child,
        since: Instant,
        /// Whether it has said that it runs.
        running: bool,
        /// When its predecessor ended, as long as it has not said that it runs.
        gap_since: Option<Instant>,
    },
    /// It has ended, and will be started again.
    Waiting { ended: Instant, until: Instant },
    /// It has ended for good.
    Ended,
}

/// What has to be done about a child that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Sequel {
    /// Nothing: its work is done.
    Finished,
    /// Start it again after this time.
    RestartIn(Duration),
    /// End the deployment: it refuses its configuration.
    Refused,
    /// End the deployment: it has failed too often.
    GiveUp,
}

impl Child {
    pub(crate) fn new(part: Part) -> Self {
        Self {
            part,
            state: State::Unborn,
            backoff: Backoff::new(),
            restarts: 0,
            last_end: None,
        }
    }

    pub(crate) fn part(&self) -> &Part {
        &self.part
    }

    /// How often it was started again.
    pub(crate) fn restarts(&self) -> u32 {
        self.restarts
    }

    /// How it last ended, if it did not simply finish.
    pub(crate) fn last_end(&self) -> Option<&End> {
        self.last_end.as_ref().filter(|end| !end.is_finished())
    }

    /// Process number, while it has one.
    pub(crate) fn pid(&self) -> Option<u32> {
        match &self.state {
            State::Alive { process, .. } => Some(process.id()),
            _ => None,
        }
    }

    pub(crate) fn is_alive(&self) -> bool {
        matches!(self.state, State::Alive { .. })
    }

    /// Whether it has done its work and ended, with exit code 0.
    pub(crate) fn is_finished(&self) -> bool {
        matches!(self.state, State::Ended) && self.last_end.as_ref().is_some_and(End::is_finished)
    }

    /// Whether it has said that it runs, or has nothing left to do.
    pub(crate) fn is_up(&self) -> bool {
        matches!(self.state, State::Alive { running: true, .. }) || self.is_finished()
    }

    /// Where it is in its life, as health messages put it.
    pub(crate) fn life(&self) -> LifeState {
        match &self.state {
            State::Alive { running: true, .. } => LifeState::Running,
            State::Unborn | State::Alive { running: false, .. } => LifeState::Starting,
            State::Ended if self.is_finished() => LifeState::Finished,
            State::Waiting { .. } | State::Ended => LifeState::Failed,
        }
    }

    /// When it has to be started again, if it has to.
    pub(crate) fn restart_due(&self) -> Option<Instant> {
        match self.state {
            State::Waiting { until, .. } => Some(until),
            _ => None,
        }
    }

    /// Starts its process. An error counts as an end.
    pub(crate) fn start(&mut self, command: &mut Command) -> Option<Sequel> {
        let gap_since = match self.state {
            State::Waiting { ended, .. } => {
                self.restarts += 1;
                Some(ended)
            }
            _ => None,
        };
        // Only the monitor writes to standard output. In a process group of its own, Ctrl-C does not reach the child:
        // the launcher decides in which order all stop.
        let output = match self.part.kind {
            ProcessKind::Monitor => Stdio::inherit(),
            _ => Stdio::null(),
        };
        let since = instant();
        match command.stdin(Stdio::null()).stdout(output).process_group(0).spawn() {
            Ok(process) => {
                self.state = State::Alive {
                    process,
                    since,
                    running: false,
                    gap_since,
                };
                None
            }
            Err(error) => Some(self.ended(End::NotStarted(error.to_string()), since, since)),
        }
    }

    /// Its process has spoken. Returns how long the part was without a process, if this is the first sign of a
    /// restarted one.
    pub(crate) fn hear(&mut self, life: LifeState, now: Instant) -> Option<Duration> {
        let State::Alive { running, gap_since, .. } = &mut self.state else {
            return None;
        };
        if !matches!(life, LifeState::Running | LifeState::Finished) {
            return None;
        }
        *running = true;
        gap_since.take().map(|ended| now.duration_since(ended))
    }

    /// Whether its process has ended, and what follows from it.
    pub(crate) fn reap(&mut self, now: Instant) -> Option<Sequel> {
        let State::Alive { process, since, .. } = &mut self.state else {
            return None;
        };
        let (end, since) = match process.try_wait() {
            Ok(None) => return None,
            Ok(Some(status)) => (End::from(status), *since),
            // Only if somebody else has waited for it: it is gone, nobody knows how.
            Err(error) => (End::NotStarted(error.to_string()), *since),
        };
        Some(self.ended(end, since, now))
    }

    fn ended(&mut self, end: End, since: Instant, now: Instant) -> Sequel {
        let (finished, refused) = (end.is_finished(), end.is_refused());
        self.last_end = Some(end);
        self.state = State::Ended;
        if finished {
            return Sequel::Finished;
        }
        if refused {
            return Sequel::Refused;
        }
        match self.backoff.ended(now.duration_since(since)) {
            Verdict::GiveUp => Sequel::GiveUp,
            Verdict::RestartIn(pause) => {
                self.state = State::Waiting {
                    ended: now,
                    until: now + pause,
                };
                Sequel::RestartIn(pause)
            }
        }
    }

    /// Asks it to stop. Returns whether it has a process that has to be waited for; it will not be started again.
    pub(crate) fn ask_to_stop(&mut self) -> bool {
        match &self.state {
            State::Alive { process, .. } => {
                signal(process, Signal::TERM);
                true
            }
            State::Waiting { .. } | State::Unborn => {
                self.state = State::Ended;
                false
            }
            State::Ended => false,
        }
    }

    /// Whether its process, having been asked to stop, has stopped. An error describes one that did not stop well.
    pub(crate) fn has_stopped(&mut self) -> Result<bool, String> {
        let State::Alive { process, running, .. } = &mut self.state else {
            return Ok(true);
        };
        let (end, running) = match process.try_wait() {
            Ok(None) => return Ok(false),
            Ok(Some(status)) => (End::from(status), *running),
            Err(error) => (End::NotStarted(error.to_string()), *running),
        };
        self.state = State::Ended;
        let well = end.is_finished() || (end.is_request_to_stop() && !running);
        let problem = format!("{} {end} when it was asked to stop", self.part.title());
        self.last_end = Some(end);
        if well { Ok(true) } else { Err(problem) }
    }

    /// Ends it hard, and waits for that.
    pub(crate) fn kill(&mut self) {
        if let State::Alive { process, .. } = &mut self.state {
            signal(process, Signal::KILL);
            // It has been killed by a signal that cannot be caught; waiting fails only if it is gone already.
            let _ = process.wait();
            self.last_end = Some(End::Signal(Signal::KILL.as_raw()));
        }
        self.state = State::Ended;
    }
}

/// A process that has not been waited for keeps its number, so this cannot reach another one.
fn signal(process: &std::process::Child, signal: Signal) {
    // It fails only if the process has ended, which is what was wanted.
    let _ = kill_process(Pid::from_child(process), signal);
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::NO_SOURCE;

    fn child() -> Child {
        Child::new(Part {
            kind: ProcessKind::Fusion,
            name: "fusion".to_owned(),
            source: NO_SOURCE,
        })
    }

    fn until_ended(child: &mut Child) -> Sequel {
        let start = Instant::now();
        loop {
            if let Some(sequel) = child.reap(Instant::now()) {
                return sequel;
            }
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn shell(script: &str) -> Command {
        let mut command = Command::new("/bin/sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn exit_code_0_is_the_end_and_2_a_refusal() {
        let mut child = child();
        assert_eq!(child.start(&mut shell("exit 0")), None);
        assert_eq!(until_ended(&mut child), Sequel::Finished);
        assert!(child.is_finished() && child.is_up());
        let mut child = self::child();
        child.start(&mut shell("exit 2"));
        assert_eq!(until_ended(&mut child), Sequel::Refused);
        assert_eq!(child.life(), LifeState::Failed);
    }

    #[test]
    fn a_killed_child_is_restarted_counted_and_timed() {
        let mut child = child();
        child.start(&mut shell("kill -KILL $$"));
        assert!(matches!(until_ended(&mut child), Sequel::RestartIn(_)));
        assert_eq!(child.last_end(), Some(&End::Signal(9)));
        assert!(child.restart_due().is_some());
        child.start(&mut shell("sleep 60"));
        assert_eq!(child.restarts(), 1);
        assert_eq!(child.hear(LifeState::Starting, Instant::now()), None);
        assert!(child.hear(LifeState::Running, Instant::now()).is_some());
        assert_eq!(child.hear(LifeState::Running, Instant::now()), None, "said once");
        child.kill();
        assert!(!child.is_alive() && child.restart_due().is_none());
    }

    #[test]
    fn one_that_cannot_be_started_is_tried_again() {
        let mut child = child();
        let sequel = child.start(&mut Command::new("/nowhere/koseki"));
        assert!(matches!(sequel, Some(Sequel::RestartIn(_))));
        assert!(child.last_end().unwrap().to_string().contains("could not be started"));
    }

    #[test]
    fn a_request_to_stop_may_come_before_the_child_listens_for_it() {
        let mut child = child();
        child.start(&mut shell("sleep 60"));
        assert!(child.ask_to_stop());
        let start = Instant::now();
        while !child.has_stopped().unwrap() {
            assert!(start.elapsed() < Duration::from_secs(60));
        }
        assert!(!child.ask_to_stop(), "it is gone");
    }
}
