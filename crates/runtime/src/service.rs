//! Duty cycle of every process of a deployment.
//!
//! A service is an [`Agent`]: each turn is a bounded piece of work and returns whether more work is waiting. [`run`]
//! repeats turns, reads the clocks once per turn, publishes the agent's health, and ends the process after the work
//! or at a stop request. The agent itself has no loop and reads no clock, so that tests run it step by step.
//! [`run_apart`] does the same for an agent whose thread must do nothing else.

use std::time::Duration;

use messages::LifeState;

use crate::agent::{Agent, Turn};
use crate::clock::{Now, mono_ns};
use crate::health::Reporter;
use crate::housekeeping::Housekeeper;
use crate::process::Process;
use crate::signals::Stop;

/// Time between two health messages, nanoseconds.
const HEALTH_PERIOD_NS: i64 = 200_000_000;

/// Pauses of a thread that would otherwise never sleep.
///
/// Linux suspends a `SCHED_FIFO` thread that uses its core completely for about 50 ms in each second. A thread with
/// own pauses, which are short, is not suspended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rest {
    /// Time between two pauses, nanoseconds.
    pub every_ns: i64,
    /// Length of a pause, nanoseconds.
    pub for_ns: u64,
}

/// Runs `agent` until its work is done or a stop is requested.
///
/// # Errors
/// Errors of the agent.
pub fn run(process: &Process, agent: &mut dyn Agent) -> anyhow::Result<()> {
    run_reporting(&process.stop, process.reporter()?, agent)
}

fn run_reporting(stop: &Stop, mut reporter: Reporter, agent: &mut dyn Agent) -> anyhow::Result<()> {
    let mut entries = Vec::new();
    let result = duty_cycle(stop, agent, None, &mut |agent, now| {
        entries.clear();
        agent.health(&mut entries);
        reporter.publish(now, LifeState::Running, &entries)
    });
    let closed = agent.close(Now::read());
    entries.clear();
    agent.health(&mut entries);
    // At the end, health is best effort: the error itself has priority.
    let _ = reporter.publish(Now::read(), life_at_end(&result, &closed), &entries);
    result.and(closed)
}

/// Runs `agent` as [`run`] does, with all other work left to `housekeeper`, and with the pauses of `rest`.
///
/// # Errors
/// Errors of the agent or of the housekeeper.
pub fn run_apart(
    process: &Process,
    agent: &mut dyn Agent,
    rest: Option<Rest>,
    housekeeper: Housekeeper,
) -> anyhow::Result<()> {
    let result = duty_cycle(&process.stop, agent, rest, &mut |agent, now| {
        housekeeper.say(agent, now)
    });
    let closed = agent.close(Now::read());
    let said = housekeeper.close(agent, Now::read(), life_at_end(&result, &closed));
    // The housekeeper's error comes first: the agent's error is its consequence.
    said.and(result).and(closed)
}

fn life_at_end(result: &anyhow::Result<()>, closed: &anyhow::Result<()>) -> LifeState {
    match result.is_err() || closed.is_err() {
        true => LifeState::Failed,
        false => LifeState::Finished,
    }
}

fn duty_cycle(
    stop: &Stop,
    agent: &mut dyn Agent,
    rest: Option<Rest>,
    say: &mut dyn FnMut(&dyn Agent, Now) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut next_health_ns = i64::MIN;
    let mut rested_ns = mono_ns();
    let idle_max_ns = rest.map_or(HEALTH_PERIOD_NS, |rest| rest.every_ns.min(HEALTH_PERIOD_NS));
    let idle_max = Duration::from_nanos(idle_max_ns as u64);
    loop {
        let now = Now::read();
        if now.mono_ns >= next_health_ns {
            say(agent, now)?;
            next_health_ns = now.mono_ns + HEALTH_PERIOD_NS;
        }
        if stop.requested() {
            return Ok(());
        }
        if let Some(rest) = rest
            && now.mono_ns - rested_ns >= rest.every_ns
        {
            std::thread::sleep(Duration::from_nanos(rest.for_ns));
            rested_ns = mono_ns();
        }
        match agent.turn(now)? {
            Turn::Worked => {}
            Turn::Idle(at_most) => agent.wait(at_most.min(idle_max))?,
            Turn::Finished => return Ok(()),
        }
    }
}
